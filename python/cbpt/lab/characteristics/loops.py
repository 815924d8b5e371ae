"""Loops in a table of readings: legs between turns of the torque, and branches that make a loop.

    Branch     one way of a loop: the angle over the torque
    Loop       a rising and a falling branch
    loops_of   all loops of a table, run by run

A run that goes 0, +T, -T, 0 has its rising branch in two legs, the last and the first; such a loop
is `composed`. A run on one side of zero has half a loop. The turns are those that stand out from
the scatter of the torque, so that a torque that was measured and not set has no false ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt.lab.covariance.robust import neighbour_scatter, scatter_off_lines
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.turns import turns_of
from cbpt.results import ARCSEC_PER_RAD

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """What makes a turn and a loop; shares are of the torque's range or of the amplitude."""

    turns: tuple[float, ...] = (0.04, 0.12, 0.3)
    """A turn smaller than this share of the range of the run is none; the first that gives whole
    loops."""
    of_scatter: float = 5.0
    """Nor is one smaller than so many standard deviations of the torque."""
    reaches: float = 0.8
    """A branch that reaches this share of the amplitude on both sides is whole."""
    joint: float = 0.15
    """The two legs of a composed branch are at most this share apart."""
    open_of_width: float = 0.1
    open_of_turn: float = 0.01
    """A loop is open that ends further from its start than these shares of its width and of the
    angle that it turns.
    """
    open_of_scatter: float = 5.0
    """It is closed where it ends no further from its start than so many standard deviations of a
    reading."""
    readings_that_scatter: int = 13
    """On each branch. What fewer differ by from their neighbours is the shape of the loop."""


_LIMITS = _Limits()
NEIGHBOURS = 7
"""Readings in a local straight line, where the torque scatters."""


@dataclass(frozen=True, eq=False)
class Branch:
    """One way of a loop, in rising order of the torque. Arrays have shape (n,)."""

    torque_Nm: Floats
    angle_arcsec: Floats
    row: Floats
    """Where in the table each angle was read; the mean where one torque has several readings."""
    scattered: bool
    """Whether the torque scatters along the leg: values are then local straight lines, else they
    pass through the readings (monotone cubics)."""

    @property
    def ends_Nm(self) -> tuple[float, float]:
        """The least and the largest torque."""
        return float(self.torque_Nm[0]), float(self.torque_Nm[-1])

    def at(self, torque_Nm: ArrayLike) -> Floats:
        """The angle in arcsec at torques of any shape; NaN beyond the ends."""
        torque = np.asarray(torque_Nm, dtype=np.float64)
        low, high = self.ends_Nm
        slack = 1e-9 * (high - low)
        inside = (torque >= low - slack) & (torque <= high + slack)
        found = self._inside(np.clip(torque, low, high))
        return np.where(inside, found, np.nan)

    @property
    def knots_Nm(self) -> Floats:
        """The torques at which a curve is read off the branch."""
        return self.torque_Nm

    def _inside(self, torque: Floats) -> Floats:
        if not self.scattered:
            return np.asarray(self._curve(torque))
        flat = np.atleast_1d(torque).ravel()
        return self.line_at(flat).reshape(np.shape(torque))

    def line_at(self, torque_Nm: Floats, shift: int = 0) -> Floats:
        """Straight lines through the readings about each torque, or so many readings further on;
        both of shape (n,)."""
        count = min(NEIGHBOURS, len(self.torque_Nm))
        rows = self.first_neighbour(torque_Nm, shift)[:, None] + np.arange(count)
        x, y = self.torque_Nm[rows], self.angle_arcsec[rows]
        mean = x.mean(axis=1)
        off = x - mean[:, None]
        slope = np.sum(off * y, axis=1) / np.maximum(np.sum(off**2, axis=1), 1e-300)
        return np.asarray(y.mean(axis=1) + slope * (torque_Nm - mean))

    def first_neighbour(self, torque_Nm: Floats, shift: int) -> Ints:
        """The first of the readings of each line."""
        count = min(NEIGHBOURS, len(self.torque_Nm))
        first = np.searchsorted(self.torque_Nm, torque_Nm) - (count + 1) // 2 + shift
        return np.asarray(np.clip(first, 0, len(self.torque_Nm) - count))

    @cached_property
    def _curve(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.torque_Nm, self.angle_arcsec)

    def integral(self, low_Nm: float, high_Nm: float) -> float:
        """The integral of the angle over the torque, arcsec N m."""
        if not self.scattered:
            return float(self._curve.integrate(low_Nm, high_Nm))
        return self._on_grid(low_Nm, high_Nm)

    def _on_grid(self, low_Nm: float, high_Nm: float) -> float:
        grid = np.linspace(low_Nm, high_Nm, 401)
        return float(np.trapezoid(self._inside(grid), grid))

    def scaled(self, torque: float = 1.0, angle: float = 1.0) -> Branch:
        """With torque and angle multiplied."""
        return replace(
            self, torque_Nm=self.torque_Nm * torque, angle_arcsec=self.angle_arcsec * angle
        )


@dataclass(frozen=True, eq=False)
class Loop:
    """A rising and a falling branch of one run; one of them may be missing."""

    run: str
    rising: Branch | None
    falling: Branch | None
    amplitude_Nm: float
    """The torque that is reached on both sides, or on the one side of half a loop."""
    whole: bool
    """Whether it has both branches on both sides."""
    composed: bool = False
    """Whether one branch is made of the first and the last leg of the run."""
    gap_arcsec: float | None = None
    """By how much the angle is larger at the end than at the start; None where no torque was
    reached twice the same way."""
    rate_Nm_per_s: float | None = None

    @property
    def branches(self) -> list[Branch]:
        """Those that there are."""
        return [branch for branch in (self.rising, self.falling) if branch is not None]

    @property
    def width_arcsec(self) -> float:
        """Between both branches at zero torque; NaN where one does not go there."""
        if self.rising is None or self.falling is None:
            return float("nan")
        return float(self.falling.at(0.0) - self.rising.at(0.0))

    @property
    def turn_arcsec(self) -> float:
        """The angle from end to end."""
        return float(np.ptp(np.concatenate([b.angle_arcsec for b in self.branches])))

    @property
    def open_arcsec(self) -> float | None:
        """By how much a loop fails to close that has to; None where it closes well enough, or
        where nobody knows."""
        if self.gap_arcsec is None or not self.whole:
            return None
        of_turn = _LIMITS.open_of_turn * self.turn_arcsec
        of_noise = _LIMITS.open_of_scatter * self.scatter_arcsec
        most = max(_LIMITS.open_of_width * abs(self.width_arcsec), of_turn, of_noise)
        return self.gap_arcsec if abs(self.gap_arcsec) > most else None

    @property
    def scatter_arcsec(self) -> float:
        """Standard deviation of a reading, 0 where few readings cannot tell."""
        return _scatter_arcsec(self.branches)

    @property
    def first_leg_J(self) -> float:
        """The area that a first leg may have taken from a loop that it is a part of: it begins
        where the loop is open by, and comes to the branch of the loop at its end at the latest."""
        gap = self.open_arcsec if self.composed else None
        return 0.5 * abs(gap or 0.0) * self.amplitude_Nm / ARCSEC_PER_RAD

    def with_branches(self, rising: Branch | None, falling: Branch | None) -> Loop:
        """With others in place of its own."""
        return replace(self, rising=rising, falling=falling)

    def closed(self) -> Loop:
        """With what it is open taken off evenly, from its first reading to its last."""
        rows = np.concatenate([branch.row for branch in self.branches])
        per_row = (self.gap_arcsec or 0.0) / float(np.ptp(rows))

        def shifted(branch: Branch | None) -> Branch | None:
            if branch is None:
                return None
            drift = per_row * (branch.row - rows.min())
            return replace(branch, angle_arcsec=branch.angle_arcsec - drift)

        return self.with_branches(shifted(self.rising), shifted(self.falling))

    def scaled(self, torque: float = 1.0, angle: float = 1.0) -> Loop:
        """With torque and angle multiplied."""
        rising, falling = (b and b.scaled(torque, angle) for b in (self.rising, self.falling))
        return replace(self.with_branches(rising, falling), amplitude_Nm=self.amplitude_Nm * torque)


def _scatter_arcsec(branches: Sequence[Branch]) -> float:
    """Standard deviation of a reading beside its two neighbours; 0 where a branch has too few
    readings to tell."""
    if min(len(b.torque_Nm) for b in branches) < _LIMITS.readings_that_scatter:
        return 0.0
    return scatter_off_lines([(b.torque_Nm, b.angle_arcsec) for b in branches])


def loops_of(readings: Readings) -> list[Loop]:
    """Every loop, in the order of the table; none where no torque goes there and back."""
    found: list[Loop] = []
    for run in range(int(readings.run_index.max()) + 1 if len(readings) else 0):
        rows = np.flatnonzero(readings.run_index == run)
        found += _of_run(readings, rows)
    return found


def _of_run(readings: Readings, rows: Ints) -> list[Loop]:
    """Loops with the finest turns that give whole ones; where the torque slips back along a leg,
    fine turns cut a loop into pieces."""
    for least in _LIMITS.turns:
        legs = _legs(readings, rows, least)
        whole = list(_whole(legs, -1)) or list(_whole(legs, 1))
        if whole:
            return whole
    return list(_halves(_legs(readings, rows, _LIMITS.turns[0])))


# --- legs ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Leg:
    """Rows between two turns, in the order of time."""

    readings: Readings
    rows: Ints

    @property
    def torque(self) -> Floats:
        return self.readings.torque_Nm[self.rows]

    @property
    def start(self) -> float:
        return float(self.torque[0])

    @property
    def end(self) -> float:
        return float(self.torque[-1])

    @property
    def way(self) -> int:
        return 1 if self.end > self.start else -1


def _legs(readings: Readings, rows: Ints, least: float) -> list[_Leg]:
    torque = readings.torque_Nm[rows]
    if len(torque) < 3:
        return []
    scatter = neighbour_scatter([torque], 2)
    turns = turns_of(torque, max(least * float(np.ptp(torque)), _LIMITS.of_scatter * scatter))
    return [_Leg(readings, rows[first : last + 1]) for first, last in pairwise(turns)]


def _branch(*legs: _Leg) -> Branch | None:
    """One branch of legs that follow each other in the torque; None below 3 torques."""
    rows = np.concatenate([leg.rows for leg in legs])
    readings = legs[0].readings
    scattered = any(np.any(leg.way * np.diff(leg.torque) < 0) for leg in legs)
    order = np.argsort(readings.torque_Nm[rows], kind="stable")
    rows = rows[order]
    torque, angle = readings.torque_Nm[rows], readings.elastic_angle_arcsec[rows]
    row = rows.astype(np.float64)
    if not scattered:
        torque, index = np.unique(torque, return_inverse=True)
        angle, row = (np.bincount(index, values) / np.bincount(index) for values in (angle, row))
    return Branch(torque, angle, row, scattered) if len(torque) > 2 else None


# --- loops --------------------------------------------------------------------------------


def _whole(legs: Sequence[_Leg], way: int) -> Iterator[Loop]:
    """Loops about each leg of one way that crosses zero from one side to the other."""
    for i, leg in enumerate(legs):
        ends = way * leg.end, -way * leg.start
        amplitude = min(ends)
        if leg.way != way or amplitude < 0.5 * max(ends):
            continue
        before = legs[i - 1] if i else None
        after = legs[i + 1] if i + 1 < len(legs) else None
        there = _branch(leg)
        back, composed, gap = _back(leg, before, after, amplitude)
        if there is None or back is None:
            continue
        rising, falling = (there, back) if way > 0 else (back, there)
        yield Loop(
            str(leg.readings.run[leg.rows[0]]),
            rising,
            falling,
            amplitude,
            whole=True,
            composed=composed,
            gap_arcsec=gap,
            rate_Nm_per_s=_rate(leg),
        )


def _back(
    leg: _Leg, before: _Leg | None, after: _Leg | None, amplitude: float
) -> tuple[Branch | None, bool, float | None]:
    """The branch of the other way, whether it is composed, and how far the loop is from closed."""
    reach = _LIMITS.reaches * amplitude
    if after is not None and -leg.way * after.end >= reach:
        return _branch(after), False, _gap(after, leg)
    if before is not None and leg.way * before.start >= reach:
        return _branch(before), False, _gap(leg, before)
    if after is None or before is None:
        return None, False, None
    # The leg before starts where the one after ends, or there is a hole between them.
    way = before.way
    if way * (before.start - after.end) > _LIMITS.joint * amplitude:
        return None, False, None
    short = way * after.end < 0
    later = before.rows[way * (before.torque - (0.0 if short else after.end)) > 0]
    if len(later) < 2:
        return None, False, None
    gap = _gap_at_joint(before, leg, after)
    found = _branch(after, _Leg(before.readings, later))
    return _through_zero(found, after) if short else found, True, gap


def _through_zero(branch: Branch | None, last: _Leg) -> Branch | None:
    """A composed branch whose last leg ends short of zero torque: there it goes on straight from
    its last two torques. How the first leg begins there, after a rest, says nothing of the loop."""
    ended = _branch(last)
    if branch is None or ended is None:
        return None
    order = slice(None) if last.way > 0 else slice(None, None, -1)
    torque, angle = ended.torque_Nm[order], ended.angle_arcsec[order]
    if ended.scattered:
        zero_arcsec = float(ended.line_at(np.zeros(1))[0])
    else:
        slope = (angle[-1] - angle[-2]) / (torque[-1] - torque[-2])
        zero_arcsec = float(angle[-1] - slope * torque[-1])
    place = int(np.searchsorted(branch.torque_Nm, 0.0))
    return replace(
        branch,
        torque_Nm=np.insert(branch.torque_Nm, place, 0.0),
        angle_arcsec=np.insert(branch.angle_arcsec, place, zero_arcsec),
        row=np.insert(branch.row, place, float(last.rows[-1])),
    )


def _gap_at_joint(before: _Leg, leg: _Leg, after: _Leg) -> float | None:
    """The angle on the leg after less that on the leg before, where one ends and the other starts.

    Between these two torques the angle goes on as it came or comes as it goes on, or changes by as
    much as on the other branch on the other side of zero: the smallest gap that these leave.
    """
    first, opposite, last = _branch(before), _branch(leg), _branch(after)
    if first is None or opposite is None or last is None:
        return None
    start, end = before.start, after.end
    hole = start - end
    if before.way * hole <= 0:
        middle = 0.5 * (start + end)
        return float(last.at(middle) - first.at(middle))
    change = float(first.at(start) - last.at(end))
    ways = [
        last.at(end) - last.at(end - hole),
        first.at(start + hole) - first.at(start),
        opposite.at(-end) - opposite.at(-start),
    ]
    gaps = np.array([float(way) - change for way in ways])
    gaps = gaps[np.isfinite(gaps)]
    return float(gaps[np.argmin(np.abs(gaps))]) if len(gaps) else None


def _gap(last: _Leg, first: _Leg) -> float | None:
    """The angle at the end of one leg less that at the start of an earlier one, at one torque: as
    much as both torques differ the leg turns on."""
    over = last.end - first.start
    if abs(over) > 0.02 * abs(first.start):
        return None
    angle = last.readings.elastic_angle_arcsec
    end = float(angle[last.rows[-1]])
    slope = (end - float(angle[last.rows[0]])) / (last.end - last.start)
    return end - slope * over - float(angle[first.rows[0]])


def _halves(legs: Sequence[_Leg]) -> Iterator[Loop]:
    """What a run on one side of zero has: there and back, or only there."""
    used = -1
    for i, leg in enumerate(legs):
        if i <= used:
            continue
        side = 1 if abs(leg.end) == leg.end else -1
        outward = leg.way == side and abs(leg.start) < 0.3 * abs(leg.end)
        across = min(leg.start * leg.way, -leg.end * leg.way) < 0 and not outward
        if not (outward or across):
            continue
        after = legs[i + 1] if i + 1 < len(legs) and outward else None
        used = i + 1 if after is not None else i
        there, back = _branch(leg), _branch(after) if after is not None else None
        if there is None:
            continue
        rising, falling = (there, back) if leg.way > 0 else (back, there)
        size = max(abs(leg.start), abs(leg.end)) if outward else min(abs(leg.start), abs(leg.end))
        run = str(leg.readings.run[leg.rows[0]])
        yield Loop(run, rising, falling, size, whole=False, rate_Nm_per_s=_rate(leg))


def _rate(leg: _Leg) -> float | None:
    time = leg.readings.time_s
    if time is None:
        return None
    took = float(time[leg.rows[-1]] - time[leg.rows[0]])
    return abs(leg.end - leg.start) / took if took > 0 else None
