"""A level whose readings hold something that its own fit does not follow and another level has not.

OddLevel      the level, what is left of it, and where
odd_level_of  finds it

A level is fitted with noise of its own, and what a slip or a wandering instrument leaves is taken
for that: then the level says little, and little of it speaks for a change. Rigs leave a good deal
in every level alike, which says nothing against comparing them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.parties import Levels
from cbpt.lab.covariance.repeated_runs import runs_alike
from cbpt.lab.inference.residuals import left_by
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]

_MORE = 3.0
"""By what factor what is left is far more than what is left of another level: with as few runs as
campaigns have, noise that wanders differs by twice and more."""
_BESIDE = 3
"""Readings on either side of a jump that tell its size."""
_CLEAR = 6.0
"""How many times the scatter a jump is: more than two steps of noise make."""


@dataclass(frozen=True)
class OddLevel:
    """Beside the values that suit the level best."""

    level: int
    left_arcsec: float
    """Root mean square beyond the scatter."""
    other: int
    other_arcsec: float
    """Of the level that leaves least."""
    run: str | None
    """The run that most of it is in, or that slipped; None where there is none."""
    jump_arcsec: float | None
    """By how much the angle jumps within that run, where that explains most of it."""
    jump_Nm: float | None
    """The torque there."""
    slipped: bool = False
    """Whether it is odd by that jump, which other runs with the same torques do not have, and not
    by how much it leaves."""


def odd_level_of(levels: Levels, scatter_arcsec: Sequence[float]) -> OddLevel | None:
    """The one that leaves most beyond its scatter: more than the scatter, and far more than what is
    left of another level; else one with a run that slipped, where no other has one.

    scatter_arcsec: of each level, by neighbouring readings.
    """
    tables = [party.problem.campaign for party in levels.parties]
    whole = [left_by(campaign, fit) for campaign, fit in zip(tables, levels.fits, strict=True)]
    # A reading that stands apart counts for as little as in the fit.
    left = [
        off if fit.noise.inflation is None else off / fit.noise.inflation
        for off, fit in zip(whole, levels.fits, strict=True)
    ]
    beyond = [
        float(np.sqrt(max(float(np.mean(off**2)) - scatter**2, 0.0)))
        for off, scatter in zip(left, scatter_arcsec, strict=True)
    ]
    most, least = int(np.argmax(beyond)), int(np.argmin(beyond))
    if beyond[most] > max(scatter_arcsec[most], _MORE * beyond[least]):
        where = _where(tables[most].readings, left[most], scatter_arcsec[most])
        return OddLevel(most, beyond[most], least, beyond[least], *where)
    slips = [
        _slip(campaign.readings, off, scatter)
        for campaign, off, scatter in zip(tables, whole, scatter_arcsec, strict=True)
    ]
    sizes = [0.0 if slip is None else abs(slip.jump_arcsec) for slip in slips]
    most, least = int(np.argmax(sizes)), int(np.argmin(sizes))
    slip = slips[most]
    if slip is None or not sizes[most] > _MORE * max(sizes[:most] + sizes[most + 1 :]):
        return None
    return OddLevel(
        most, beyond[most], least, beyond[least], slip.run, slip.jump_arcsec, slip.at_Nm, True
    )


def _where(
    readings: Readings, left_arcsec: Floats, scatter_arcsec: float
) -> tuple[str | None, float | None, float | None]:
    """The run, and the jump within it, in arcsec, with its torque."""
    runs = readings.run_index
    squares = np.bincount(runs, left_arcsec**2)
    worst = int(np.argmax(squares))
    if squares[worst] <= 0.5 * squares.sum():
        return None, None, None
    rows = np.flatnonzero(runs == worst)
    label = str(readings.run[rows[0]])
    jump = _jump(left_arcsec[rows], scatter_arcsec)
    if jump is None:
        return label, None, None
    return label, jump[1], float(readings.torque_Nm[rows[jump[0]]])


@dataclass(frozen=True)
class _Slip:
    """A jump within a run."""

    run: str
    jump_arcsec: float
    at_Nm: float


def _slip(readings: Readings, left_arcsec: Floats, scatter_arcsec: float) -> _Slip | None:
    """The largest jump of a run beside others with the same torques: what all of them leave is no
    slip. The first run of a table may begin otherwise. Of two runs either may be the one."""
    found = []
    for group in runs_alike(readings):
        rows = group[readings.run[group[:, 0]] != readings.run[0]]
        off = left_arcsec[rows]
        names = [str(name) for name in readings.run[rows[:, 0]]]
        if len(rows) == 2:
            off, names = np.diff(off, axis=0), [" or ".join(names)]
        elif len(rows) > 2:
            off = off - np.median(off, axis=0)
        else:
            continue
        for name, own, apart in zip(names, rows, off, strict=False):
            jump = _jump(apart, scatter_arcsec)
            if jump is not None:
                found.append(_Slip(name, jump[1], float(readings.torque_Nm[own[jump[0]]])))
    return max(found, key=lambda slip: abs(slip.jump_arcsec), default=None)


def _jump(left_arcsec: Floats, scatter_arcsec: float) -> tuple[int, float] | None:
    """Before which reading of a run the angle jumped, and by how much, where that explains most of
    what is left of the run and is no drift."""
    y = left_arcsec - left_arcsec.mean()
    if len(y) <= 2 * _BESIDE:
        return None
    at = np.arange(_BESIDE, len(y) - _BESIDE + 1)
    explained = [i * y[:i].mean() ** 2 + (len(y) - i) * y[i:].mean() ** 2 for i in at.tolist()]
    i = int(at[np.argmax(explained)])
    jump = float(np.median(y[i : i + _BESIDE]) - np.median(y[i - _BESIDE : i]))
    # What drifts goes from one side to the other step by step, and is no jump.
    step = float(np.mean(y[i:]) - np.mean(y[:i]))
    if max(explained) <= 0.5 * float(y @ y):
        return None
    if abs(jump) <= max(abs(step) / 2, _CLEAR * scatter_arcsec):
        return None
    return i, jump
