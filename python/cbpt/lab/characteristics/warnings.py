"""What makes a figure less than it seems, in words for the user.

cautions    of some loops and how they were read
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cbpt.lab.characteristics.figures import Convention
from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.characteristics.uncertainty import LoopSet
from cbpt.lab.wording.numbers import rounded

_RATES = 1.5
"""Loops whose rates differ by more than this factor are not alike."""
_OFF_RATED = 0.1
"""Share by which the amplitude of a full loop may differ from the rated torque."""


def cautions(loops: LoopSet, every: Sequence[Loop], convention: Convention) -> list[str]:
    """Warnings about steps, closure, rates and amplitudes."""
    return [
        *_coarse(loops, convention),
        *_open(loops),
        *_rates(every),
        *_amplitudes(loops, convention),
    ]


def _coarse(loops: LoopSet, convention: Convention) -> Iterator[str]:
    window = convention.window_Nm
    steps = []
    for loop in loops.full:
        for branch in loop.branches:
            near = branch.torque_Nm[np.abs(branch.torque_Nm) <= 2 * window]
            inside = np.concatenate([[-2 * window], near, [2 * window]])
            steps.append(float(np.diff(inside).max()))
    step = float(np.median(steps)) if steps else 0.0
    if step > window * 1.001:
        yield (
            f"The steps of the torque near zero ({rounded(step)} N m or more) are coarser than the "
            f"window of lost motion ({rounded(window)} N m), so lost motion, hysteresis loss, K1 "
            "and T1 are interpolated across the steepest part of the loop (DOI "
            "10.1177/00202940231217338), and as uncertain. Take finer steps near zero."
        )


def _open(loops: LoopSet) -> Iterator[str]:
    worst = max(loops.full, key=lambda loop: abs(loop.open_arcsec or 0.0))
    if worst.open_arcsec is not None:
        yield (
            f"A loop does not close: its end is {rounded(worst.open_arcsec)} arcsec from its "
            f"start, with a hysteresis loss of {rounded(worst.width_arcsec)} arcsec. Repeat the "
            "cycle until it closes, and use the last one."
        )
    count = sum(loop.composed for loop in loops.full)
    if count:
        yield (
            f"{count} of {len(loops.full)} loops start and end at zero torque: one branch consists "
            "of the last and the first leg of the run. The first leg may be a first loading. Run "
            "each loop for one and a quarter cycles."
        )


def _rates(every: Sequence[Loop]) -> Iterator[str]:
    rates = [loop.rate_Nm_per_s for loop in every if loop.rate_Nm_per_s]
    if rates and max(rates) > _RATES * min(rates):
        yield (
            f"The torque changes at {rounded(min(rates))} to {rounded(max(rates))} N m/s from loop "
            "to loop. Loops of reducers depend on the rate (Machines 2022, 10, 765); use one rate."
        )


def _amplitudes(loops: LoopSet, convention: Convention) -> Iterator[str]:
    rated, amplitude = convention.rated_torque_Nm, loops.amplitude_Nm
    if abs(amplitude - rated) > _OFF_RATED * rated:
        yield (
            f"The loops go to {rounded(amplitude)} N m, the rated torque is {rounded(rated)} N m: "
            "hysteresis loss and loop energy are those of this amplitude."
        )
