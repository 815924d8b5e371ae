"""What displays leave of the angle and of the torque.

display_check   the steps of both displays: against the loops, the stated uncertainty and the noise
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.covariance.robust import typical_size
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.legs import Leg
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.sizes import to_resolve_arcsec, turn_arcsec, width_arcsec
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    of_u: float = 1.5
    """Steps of the display in a stated uncertainty."""
    chance: float = 14.0
    """The smallest distance of n values in a range R by chance is R/n^2 times an exponential
    number, which exceeds this once in a million tables."""
    digits: float = 0.05
    """Of a step, by which the digits of a table round it once more."""
    apart: float = 4.0
    """Standard deviations from which on a difference is no part of the scatter."""
    set_torque: float = 0.5
    """Share of the scatter within a step of the torque, as rounding leaves it, that readings of one
    displayed torque show; those of a torque that was set scatter by their own noise."""
    displayed: float = 0.02
    """Share of the torque's range from which on steps were rather set than displayed."""
    few: int = 20
    """Readings that share their torque with one beside them, to tell a display."""


_LIMITS = _Limits()


@dataclass(frozen=True, eq=False)
class _Step:
    """Of the display of the angle, in arcsec."""

    all_over: float
    """0 where none is to be seen."""
    far: float
    """Of the larger half of the angles, where that is coarser: a few digits make it so."""
    finest: float
    """The smallest distance of two angles: no step is larger."""

    @classmethod
    def of(cls, angle: Floats) -> _Step:
        values = np.unique(np.round(angle, 9))
        finest = float(np.diff(values).min()) if len(values) > 1 else 0.0
        step = display_step(angle)
        large = np.abs(angle) > np.median(np.abs(angle))
        far = display_step(angle[large]) if large.any() else 0.0
        # Half of the values share fewer multiples, so only a step that is clearly larger counts.
        return cls(step or _lattice(values), far if far > 2 * max(step, finest) else 0.0, finest)


def _lattice(values: Floats) -> float:
    """The step of sorted values that come no closer, 0 where that is chance or not all are near
    whole multiples of it."""
    if len(values) < 3:
        return 0.0
    gaps = np.diff(values)
    least = float(gaps.min())
    if least * len(values) ** 2 < _LIMITS.chance * float(np.ptp(values)):
        return 0.0
    steps = gaps[gaps < 3.5 * least] / least
    off = np.abs(steps - np.round(steps))
    return float(least * np.median(steps / np.round(steps))) if off.max() < _LIMITS.digits else 0.0


def display_check(r: Readings, loops: list[Loop], legs: list[Leg]) -> Iterator[Check]:
    """The step of the display of the angle, and that of the torque where it matters."""
    step = _Step.of(r.elastic_angle_arcsec)
    yield _of_angle(r, loops, step, _typical([_off_lines(r, leg) for leg in legs]))
    in_time = _typical([np.diff(r.elastic_angle_arcsec[leg.rows], 3) / 20**0.5 for leg in legs])
    yield from _of_torque(r, legs, max(in_time, step.all_over / 12**0.5))


def _of_angle(r: Readings, loops: list[Loop], found: _Step, noise: float) -> Check:
    """noise: by which readings scatter about a line over the torque, rounding included."""
    name, far = "display of the angle", found.far > noise
    step = found.far if far else found.all_over
    if not step:
        finest = f"larger than {rounded(found.finest)} arcsec " * bool(found.finest)
        return Check(name, "good", f"no step {finest}is to be seen")
    words = f"the angle comes in steps of {rounded(step)} arcsec"
    if far:
        words += " where it is large"
    u = r.u_elastic_angle_arcsec
    coarse = u is not None and step > _LIMITS.of_u * float(np.median(u))
    if loops:
        turn, width = turn_arcsec(loops), width_arcsec(loops)
        if step > to_resolve_arcsec(loops):
            coarse = True
            words += (
                f"; the loops turn by {rounded(turn)} arcsec and are {rounded(width)} arcsec wide"
            )
    # What rounding leaves, step/sqrt(12), is then more than the noise behind it, in squares.
    if 0 < noise < found.all_over / 6**0.5:
        coarse = True
        words += "; the steps hide how far readings scatter"
    if not coarse:
        return Check(name, "good", words)
    remedy = (
        "Read more digits, or average several readings. Else state an uncertainty of at least "
        f"{rounded(step / 12**0.5)} arcsec, which is what rounding to these steps makes."
    )
    return Check(name, "look", words, remedy)


def _off_lines(r: Readings, leg: Leg) -> Floats:
    """Readings off the lines between their neighbours in torque, as large as one scatters."""
    order = np.argsort(r.torque_Nm[leg.rows], kind="stable")
    x, y = r.torque_Nm[leg.rows][order], r.elastic_angle_arcsec[leg.rows][order]
    share = (x[1:-1] - x[:-2]) / np.maximum(x[2:] - x[:-2], 1e-300)
    off = y[1:-1] - (1 - share) * y[:-2] - share * y[2:]
    return np.asarray(off / np.sqrt(1 + share**2 + (1 - share) ** 2))


def _typical(series: list[Floats]) -> float:
    """Root mean square without what stands apart; 0 of too few."""
    off = np.concatenate([*series, np.zeros(0)])
    if len(off) < _LIMITS.few:
        return 0.0
    most = _LIMITS.apart * typical_size(off)
    near = off[np.abs(off) <= most] if most else off
    return float(np.sqrt(near @ near / len(near)))


def _of_torque(r: Readings, legs: list[Leg], noise: float) -> Iterator[Check]:
    """Where the torque stays the same from reading to reading and the angle goes on. noise: of the
    angle from one reading to the next."""
    ties = [tie for leg in legs for tie in _ties(r, leg)]
    if not ties:
        return
    gap, squares, free = np.array(ties).T
    if free.sum() < _LIMITS.few:
        return
    within = float(np.sqrt(squares.sum() / free.sum()))
    slope = float(np.ptp(r.elastic_angle_arcsec) / np.ptp(r.torque_Nm))
    step = float(np.sqrt(np.average(gap**2, weights=free)))
    rounding = slope * step / 12**0.5
    if rounding < noise or within < _LIMITS.set_torque * rounding:
        return
    if step > _LIMITS.displayed * float(np.ptp(r.torque_Nm)):
        return  # rather a torque that was set
    words = (
        f"the torque comes in steps of {rounded(step)} N m, within which the angle changes by "
        f"{rounded(slope * step)} arcsec, while a reading scatters by {rounded(noise)} arcsec"
    )
    remedy = (
        "Read more digits of the torque, or let it be averaged over the same time as the angle."
    )
    yield Check("display of the torque", "look", words, remedy)


def _ties(r: Readings, leg: Leg) -> Iterator[tuple[float, float, int]]:
    """Of each torque that a leg has more than once: the distance to the next torque, and the sum of
    squares of its angles about their mean with its degrees of freedom."""
    torque, angle = r.torque_Nm[leg.rows], r.elastic_angle_arcsec[leg.rows]
    at, index, count = np.unique(torque, return_inverse=True, return_counts=True)
    if len(at) < 3 or len(at) == len(torque):
        return
    off = angle - (np.bincount(index, angle) / count)[index]
    squares = np.bincount(index, off**2)
    gaps = np.diff(at)
    # Ends are left out, where a torque may be held and the angle creep.
    for k in range(1, len(at) - 1):
        if count[k] > 1:
            yield float(min(gaps[k - 1], gaps[k])), float(squares[k]), int(count[k] - 1)
