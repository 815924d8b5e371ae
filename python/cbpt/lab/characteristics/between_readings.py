"""What a curve may be between two readings, and what that makes uncertain about a figure.

    half_width_arcsec  half the range of where a branch may be at a torque
    Leaning            a branch that lies anywhere in that range
    leaning            a loop of such branches
    width_open_arcsec  by how much the width of a loop at zero torque may differ

Between two readings a branch goes on as it came, comes as it goes on, or takes the straight way;
no further than both readings, as the angle rises with the torque. A step that falls between two
readings makes these differ by all of it, a curve that bends by as much as it bends over a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.loops import NEIGHBOURS, Branch, Loop

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Leaning(Branch):
    """A branch as it may be."""

    shares: Floats
    """Of half the range, about its middle, between -1 and 1; before zero torque, and after it, as
    the branch goes: of shape (2,)."""
    way: int
    """1 where it rises, -1 where it falls."""

    @property
    def knots_Nm(self) -> Floats:
        """The torques of the readings and those in their middle."""
        middle = 0.5 * (self.torque_Nm[1:] + self.torque_Nm[:-1])
        return np.sort(np.concatenate([self.torque_Nm, middle]))

    def _inside(self, torque: Floats) -> Floats:
        share = self.shares[(self.way * torque > 0).astype(int)]
        low, high = _range_arcsec(self, torque)
        return np.asarray(0.5 * (low + high) + 0.5 * share * (high - low))

    def integral(self, low_Nm: float, high_Nm: float) -> float:
        """The integral of the angle over the torque, arcsec N m."""
        return self._on_grid(low_Nm, high_Nm)


def leaning(loop: Loop, shares: Floats) -> Loop:
    """Both branches lean by the same shares, of shape (2,), each from where it comes from: what
    coarse steps leave out of a curve they leave out everywhere, and of both."""
    rising, falling = loop.rising, loop.falling
    return loop.with_branches(
        rising and _lean(rising, shares, 1), falling and _lean(falling, -shares, -1)
    )


def _lean(branch: Branch, shares: Floats, way: int) -> Leaning:
    own = branch.torque_Nm, branch.angle_arcsec, branch.row, branch.scattered
    return Leaning(*own, shares=shares, way=way)


def half_width_arcsec(branch: Branch, torque_Nm: Floats | float) -> Floats:
    """Half the range in which the angle of a branch lies at torques of any shape."""
    low, high = _range_arcsec(branch, np.asarray(torque_Nm, dtype=np.float64))
    return np.asarray(0.5 * (high - low))


def _range_arcsec(branch: Branch, torque: Floats) -> tuple[Floats, Floats]:
    """Between which angles a branch lies at torques of any shape."""
    flat = np.atleast_1d(torque).ravel()
    ways = _of_lines(branch, flat) if branch.scattered else _of_readings(branch, flat)
    return ways.min(axis=0).reshape(torque.shape), ways.max(axis=0).reshape(torque.shape)


def width_open_arcsec(loop: Loop) -> float:
    """By how much the width at zero torque may be smaller or larger between the readings."""
    return sum(float(half_width_arcsec(branch, 0.0)) for branch in loop.branches)


def _gaps(branch: Branch, torque: Floats) -> Ints:
    """Between which readings torques lie."""
    found = np.searchsorted(branch.torque_Nm, torque, side="right") - 1
    return np.asarray(np.clip(found, 0, len(branch.torque_Nm) - 2))


def _of_readings(branch: Branch, torque: Floats) -> Floats:
    """What the readings allow where the branch goes through them, shape (ways, n)."""
    x, y = branch.torque_Nm, branch.angle_arcsec
    slope = np.diff(y) / np.diff(x)
    gap = _gaps(branch, torque)
    ways = [
        y[gap] + slope[gap] * (torque - x[gap]),
        y[gap] + slope[np.maximum(gap - 1, 0)] * (torque - x[gap]),
        y[gap + 1] + slope[np.minimum(gap + 1, len(slope) - 1)] * (torque - x[gap + 1]),
    ]
    slack = 1e-9 * float(np.ptp(x))
    first = np.where(np.abs(torque - x[gap + 1]) < slack, gap + 1, gap)
    last = np.where(np.abs(torque - x[gap]) < slack, gap, gap + 1)
    return np.asarray(np.clip(ways, *np.sort([y[first], y[last]], axis=0)))


def _of_lines(branch: Branch, torque: Floats) -> Floats:
    """The same where it is made of straight lines through neighbouring readings: the lines of the
    readings about a torque, before it and after it."""
    count = min(NEIGHBOURS, len(branch.torque_Nm))
    ways = [branch.line_at(torque, shift) for shift in (0, -(count // 2), count // 2)]
    rows = branch.first_neighbour(torque, 0)[:, None] + np.arange(count)
    about = branch.angle_arcsec[rows]
    return np.asarray(np.clip(ways, about.min(axis=1), about.max(axis=1)))
