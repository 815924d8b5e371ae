"""Torques of loops as they were run: their steps near zero, and their scatter.

steps_check          steps near zero against the window of lost motion
torque_noise_check   what the scatter of the torque does to the loops
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import comb, sqrt

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.lab.characteristics.figures import Convention
from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.characteristics.warnings import step_near_zero_Nm
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.saturation import follows_torque, saturated
from cbpt.lab.preflight.sizes import to_resolve_arcsec, turn_arcsec
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import percent, rounded

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    uneven: float = 1.5
    """Slope across that window over that of the whole loop from which on a straight line between
    coarse steps is no good."""
    jumps: float = 0.1
    """Share of its range from which on what looks like scatter is a torque that jumps."""
    quarter: float = 0.3186
    """What a quarter of normal values are smaller than, in standard deviations."""
    slack: float = 1.001
    """Of a step, for rounding."""
    looked_at: int = 100
    """Loops on which the slope is looked at, spread over all."""


_LIMITS = _Limits()


def steps_check(loops: list[Loop], case: Case | Drive | None) -> Iterator[Check]:
    """Steps near zero torque, where lost motion is read off."""
    if not loops:
        return
    name = "steps of the torque"
    rated = case.rated_torque_Nm if isinstance(case, Case) else None
    reach = rated or max(loop.amplitude_Nm for loop in loops)
    window, of_what = Convention(reach).window_Nm, "rated" if rated else "largest"
    branches = [branch for loop in loops for branch in loop.branches]
    largest = step_near_zero_Nm(branches, window)
    if not largest:
        words = "no readings come near zero torque, where lost motion is read off"
        yield Check(name, "look", words, "Begin and end each loop at zero torque.")
        return
    words = (
        f"steps of {rounded(largest)} N m near zero; lost motion is read off at "
        f"+-{rounded(window)} N m, {percent(window / reach)} of the {of_what} torque"
    )
    uneven = _unevenness(loops, window)
    if largest <= window * _LIMITS.slack:
        yield Check(name, "good", words)
    elif uneven <= _LIMITS.uneven:
        words += (
            ". The steps are coarser, but the slope there is about that of the whole loop, so lost "
            "motion can be interpolated"
        )
        yield Check(name, "good", words)
    else:
        words += (
            f". The steps are coarser, and the slope there is {rounded(uneven)} times that of the "
            "whole loop"
        )
        yield Check(name, "look", words, "Take finer steps near zero, or lost motion is a guess.")


def _unevenness(loops: Sequence[Loop], window_Nm: float) -> float:
    """How much faster the angle changes across the window than over the whole loop, about the
    middle of its branches; the median over loops."""
    ends = window_Nm * np.array([-1.0, 1.0])
    found = []
    for loop in loops[:: 1 + len(loops) // _LIMITS.looked_at]:
        near = [np.diff(branch.at(ends))[0] / (2 * window_Nm) for branch in loop.branches]
        far = [np.ptp(b.angle_arcsec) / max(np.ptp(b.torque_Nm), 1e-300) for b in loop.branches]
        if np.isfinite(near).all() and np.mean(far) > 0:
            found.append(abs(float(np.mean(near) / np.mean(far))))
    return float(np.median(found)) if found else 1.0


def torque_noise_check(r: Readings, loops: list[Loop]) -> Check:
    """Whether the torque scatters along its way, and by how much that moves the angle."""
    name = "noise of the torque"
    scattered = [loop for loop in loops if any(branch.scattered for branch in loop.branches)]
    if not scattered:
        return Check(name, "good", "the torque moves one way along each branch")
    scatter, of_angle = (_in_time(r, values) for values in (r.torque_Nm, r.elastic_angle_arcsec))
    if not 0 < scatter < _LIMITS.jumps * float(np.ptp(r.torque_Nm)):
        words = "the torque was set, or jumps from reading to reading: no scatter is to be seen"
        return Check(name, "good", words)
    reach = 2 * float(np.median([loop.amplitude_Nm for loop in scattered]))
    slope = turn_arcsec(scattered) / max(reach, 1e-300)
    words = (
        f"the torque goes back and forth along the branches: it scatters by about "
        f"{rounded(scatter)} N m, by which the angle changes by {rounded(scatter * slope)} arcsec"
    )
    if scatter * slope <= max(to_resolve_arcsec(scattered), of_angle):
        return Check(name, "good", words)
    remedy = (
        "Measure the torque itself if it comes from a current, or average more of it into each "
        "reading"
    )
    commands = [] if saturated(r) else follows_torque(r)
    if commands:
        columns = " or ".join(map(repr, commands))
        remedy += f", or take {columns}, which follows it without a limit, if it is a torque"
    remedy += "; play and friction are else found too wide."
    return Check(name, "look", words, remedy)


def _in_time(r: Readings, values: Floats) -> float:
    """Standard deviation of a column beside its neighbours in time, the median over runs: by the
    differences that are smallest, those of ramps, of holds, or of none of both."""
    found = []
    for run in range(int(r.run_index.max()) + 1):
        mine = values[r.run_index == run]
        if len(mine) > 4:
            found.append(
                min(
                    float(np.quantile(np.abs(np.diff(mine, k)), 0.25))
                    / (_LIMITS.quarter * sqrt(comb(2 * k, k)))
                    for k in (1, 2, 3)
                )
            )
    return float(np.median(found)) if found else 0.0
