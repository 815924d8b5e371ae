"""What makes a figure less than it seems, in words for the user.

cautions            of some loops and how they were read
step_near_zero_Nm   the step of the torque where lost motion is read
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cbpt.lab.characteristics.figures import Convention
from cbpt.lab.characteristics.loops import Branch, Loop
from cbpt.lab.characteristics.play import MOST_FRICTION, friction_torque_Nm
from cbpt.lab.characteristics.symmetry import middle_of
from cbpt.lab.characteristics.uncertainty import LoopSet
from cbpt.lab.wording.numbers import rounded
from cbpt.lab.wording.phrases import counted

RATES = 1.5
"""Loops whose rates differ by more than this factor are not alike."""


@dataclass(frozen=True)
class _Limits:
    """From where on something is told."""

    off_rated: float = 0.1
    """Share of the rated torque by which amplitudes differ from it, or from each other."""
    off_zero: float = 0.1
    """Of the torque of lost motion, by which the middle of a loop is off zero."""
    left: float = 0.25
    """Of the squares by which a loop is lopsided: where the middle leaves more than half of the
    angle, it is not the reason."""
    clear: float = 5.0
    """Standard deviations of a reading by which a loop is turned round."""
    rounding: float = 1e-3
    """Of the angle that a loop turns by, the same where nothing scatters."""
    slack: float = 1.001
    """Of a step of the torque, for rounding."""


_LIMITS = _Limits()


def cautions(loops: LoopSet, every: Sequence[Loop], convention: Convention) -> list[str]:
    """Warnings about signs, loops that are left out, steps, closure, rates and amplitudes."""
    return [
        *_signs(loops),
        *_left_out(loops, every),
        *_coarse(loops, convention),
        *_open(loops),
        *_off_zero(loops, convention),
        *_rates(every),
        *_amplitudes(loops, convention),
    ]


def _signs(loops: LoopSet) -> Iterator[str]:
    turns = [float(b.angle_arcsec[-1] - b.angle_arcsec[0]) for x in loops.full for b in x.branches]
    if np.median(turns) < 0:
        yield (
            "The angle falls where the torque rises, so torque and angle are counted in opposite "
            "senses, and the figures mean nothing. Change the sign of one of both columns."
        )
        return
    known = [loop for loop in loops.full if loop.whole and loop.open_arcsec is None]
    noise = max((loop.scatter_arcsec for loop in known), default=0.0)
    least = _LIMITS.clear * noise + _LIMITS.rounding * abs(float(np.median(turns)))
    if known and float(np.median([loop.width_arcsec for loop in known])) < -least:
        yield (
            "The angle is ahead of the torque: the loops gain energy instead of losing it. Torque "
            "readings that are late do that; check the clocks of both sensors."
        )


def _left_out(loops: LoopSet, every: Sequence[Loop]) -> Iterator[str]:
    used = {id(loop) for loop in (*loops.full, *loops.small)}
    unused = [loop for loop in every if id(loop) not in used]
    if not unused:
        return
    sizes = sorted(loop.amplitude_Nm for loop in unused)
    low, high = rounded(sizes[0]), rounded(sizes[-1])
    where = f"to {low} N m" if low == high else f"to between {low} and {high} N m"
    are = "is" if len(unused) == 1 else "are"
    yield (
        f"{len(unused)} of {len(every)} loops, {where}, {are} left out: figures are read off whole "
        "loops to the rated torque, or nearest to it, on both sides of zero where there are such, "
        "and the smallest loops bound the play. For figures of another amplitude, state its torque "
        "as the rated one."
    )


def _coarse(loops: LoopSet, convention: Convention) -> Iterator[str]:
    window = convention.window_Nm
    step = _step_Nm(loops.full, window)
    if step > window * _LIMITS.slack:
        yield (
            f"The steps of the torque near zero ({rounded(step)} N m) are coarser than the "
            f"window of lost motion ({rounded(window)} N m), so lost motion, hysteresis loss, K1 "
            "and T1 are interpolated where the angle changes most (DOI 10.1177/00202940231217338); "
            "their uncertainties include that. Take finer steps near zero."
        )


def step_near_zero_Nm(branches: Sequence[Branch], window_Nm: float) -> float:
    """The largest step of the torque that reaches into twice the window of lost motion about zero,
    whole: the median over branches."""
    steps = []
    for branch in branches:
        torque = branch.torque_Nm
        near = (torque[1:] > -2 * window_Nm) & (torque[:-1] < 2 * window_Nm)
        if near.any():
            steps.append(float(np.diff(torque)[near].max()))
    return float(np.median(steps)) if steps else 0.0


def _step_Nm(loops: Sequence[Loop], window: float) -> float:
    return step_near_zero_Nm([branch for loop in loops for branch in loop.branches], window)


def _off_zero(loops: LoopSet, convention: Convention) -> Iterator[str]:
    """Of loops that close, on steps that show where their middle is, and with little friction: what
    slips at one torque one way and at another the other way makes others lopsided."""
    window = convention.window_Nm
    known = [
        loop
        for loop in loops.full
        if loop.open_arcsec is None
        and friction_torque_Nm(loop) <= MOST_FRICTION * loop.amplitude_Nm
    ]
    if not known or _step_Nm(known, window) > window * _LIMITS.slack:
        return
    found = [middle_of(loop) for loop in known]
    middle = float(np.mean([each.torque_Nm for each in found]))
    if (
        abs(middle) < _LIMITS.off_zero * window
        or np.mean([each.left for each in found]) > _LIMITS.left
    ):
        return
    about = [
        float(np.mean([_lost_motion(loop, torque, window) for loop in known]))
        for torque in (0.0, middle)
    ]
    yield (
        f"The loops are alike both ways about {rounded(middle)} N m and not about zero torque: "
        f"about there lost motion is {rounded(about[1])} arcsec in place of {rounded(about[0])}. "
        "The torque sensor may not read zero without a torque. Read it with the drive unloaded, "
        "and take that off the torques."
    )


def _lost_motion(loop: Loop, middle: float, window: float) -> float:
    ends = middle + window * np.array([-1.0, 1.0])
    return float(np.diff(np.mean([branch.at(ends) for branch in loop.branches], axis=0))[0])


def _open(loops: LoopSet) -> Iterator[str]:
    worst = max(loops.full, key=lambda loop: abs(loop.open_arcsec or 0.0))
    if worst.open_arcsec is not None:
        yield (
            f"A loop does not close: its angle ends {rounded(worst.open_arcsec)} arcsec from where "
            f"it began, beside a hysteresis loss of {rounded(worst.width_arcsec)} arcsec. Repeat "
            "the cycle until it closes, and use the last one."
        )
    count = sum(loop.composed for loop in loops.full)
    if count:
        yield (
            f"{count} of {counted(len(loops.full), 'loop')} {'starts' if count == 1 else 'start'} "
            f"and {'ends' if count == 1 else 'end'} at zero torque, so one branch is "
            "put together from the end and the beginning of the run. The beginning may differ, as "
            "the first loading after a rest. Go on for a quarter of a cycle more, to the largest "
            "torque, and the branch is whole."
        )


def _rates(every: Sequence[Loop]) -> Iterator[str]:
    rates = [loop.rate_Nm_per_s for loop in every if loop.rate_Nm_per_s]
    if rates and max(rates) > RATES * min(rates):
        yield (
            f"The torque changes at {rounded(min(rates))} to {rounded(max(rates))} N m/s from loop "
            "to loop. Loops of reducers depend on the rate (Machines 2022, 10, 765); use one rate."
        )


def _amplitudes(loops: LoopSet, convention: Convention) -> Iterator[str]:
    rated, amplitude = convention.rated_torque_Nm, loops.amplitude_Nm
    sizes = [loop.amplitude_Nm for loop in loops.full]
    if max(sizes) - min(sizes) > _LIMITS.off_rated * rated:
        yield (
            f"The figures are means over loops to {rounded(min(sizes))} to {rounded(max(sizes))} "
            "N m: hysteresis loss and loop energy grow with the amplitude. Measure to one torque, "
            "or give only the loops of one amplitude."
        )
    if abs(amplitude - rated) > _LIMITS.off_rated * rated:
        yield (
            f"The loops go to {rounded(amplitude)} N m, the rated torque is {rounded(rated)} N m: "
            "hysteresis loss and loop energy are those of this amplitude."
        )
