"""Loops as they were run: steps of the torque, its noise, closing, and the zeros of runs.

steps_check, torque_noise_check, closed_check, zeros_check
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cbpt._core import Case, Drive
from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.characteristics.warnings import step_near_zero_Nm
from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.saturation import follows_torque, saturated
from cbpt.lab.readings.reader import Readings
from cbpt.lab.wording.numbers import rounded


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    window: float = 0.03
    """Share of the largest torque at which lost motion is read."""


_LIMITS = _Limits()


def steps_check(loops: list[Loop]) -> Iterator[Check]:
    if not loops:
        return
    window = _LIMITS.window * max(loop.amplitude_Nm for loop in loops)
    branches = [branch for loop in loops for branch in loop.branches]
    largest = step_near_zero_Nm(branches, window)
    if not largest:
        words = "no readings come near zero torque, where lost motion is read off"
        yield Check("steps of the torque", "look", words, "Begin and end each loop at zero torque.")
        return
    words = (
        f"steps of {rounded(largest)} N m near zero, window of lost motion {rounded(window)} N m"
    )
    fine = largest <= window * 1.001
    remedy = "Take finer steps near zero: there the angle changes most."
    yield Check("steps of the torque", "good" if fine else "look", words, remedy * (not fine))


def torque_noise_check(r: Readings, loops: list[Loop]) -> Check:
    scattered = sum(any(b.scattered for b in loop.branches) for loop in loops)
    if not scattered:
        return Check("noise of the torque", "good", "the torque moves one way along each branch")
    size = []
    for run in range(int(r.run_index.max()) + 1):
        torque = r.torque_Nm[r.run_index == run]
        if len(torque) > 4:
            size.append(neighbour_scatter([torque], 3))
    words = (
        f"in {scattered} of {len(loops)} loops the torque goes back and forth along a branch; it "
        f"scatters by about {rounded(float(np.median(size)))} N m"
    )
    remedy = "Measure the torque itself, or average more of it into each reading"
    commands = [] if saturated(r) else follows_torque(r)
    if commands:
        columns = " or ".join(map(repr, commands))
        remedy += f", or take {columns}, which follows it without a limit, if it is a torque"
    remedy += "; play and friction are else found too wide."
    return Check("noise of the torque", "look", words, remedy)


def closed_check(loops: list[Loop]) -> Check:
    whole = [loop for loop in loops if loop.whole]
    words = f"{len(whole)} whole, {len(loops) - len(whole)} half or one-way"
    if not whole:
        remedy = "Run one and a quarter cycles: 0, +T, -T, +T, and on to -T."
        return Check("loops", "lost", words, remedy)
    composed = sum(loop.composed for loop in whole)
    open_ = sum(loop.open_arcsec is not None for loop in whole)
    if open_:
        words += f"; {open_} {'does' if open_ == 1 else 'do'} not close"
        remedy = "Repeat the cycle until it closes; a first loading and drift do not."
        return Check("loops", "look", words, remedy)
    if composed:
        words += f"; {composed} start and end at zero torque, and may hold a first loading"
        return Check("loops", "look", words, "Run a quarter cycle more.")
    return Check("loops", "good", words)


def zeros_check(r: Readings, case: Case | Drive | None) -> Check:
    """The first reading near zero torque of each run against those of the others."""
    near = np.abs(r.torque_Nm) <= _LIMITS.window * float(np.abs(r.torque_Nm).max())
    runs = [np.flatnonzero(near & (r.run_index == k)) for k in range(int(r.run_index.max()) + 1)]
    firsts = np.array([r.elastic_angle_arcsec[rows[0]] for rows in runs if len(rows)])
    if len(firsts) < 2:
        return Check("zeros of runs", "good", "too few runs come near zero torque to compare them")
    spread = float(np.std(firsts, ddof=1))
    size = float(np.ptp(r.elastic_angle_arcsec))
    words = f"the runs start {rounded(spread)} arcsec apart (standard deviation)"
    common = not (isinstance(case, Case) and case.zero == "per_run")
    u = r.u_elastic_angle_arcsec
    much = spread > (0.02 * size if u is None else 5 * float(np.median(u)))
    if much and common:
        remedy = 'Set zero = "per_run" under [measurement], or zero the sensor once for all runs.'
        return Check("zeros of runs", "look", words, remedy)
    return Check("zeros of runs", "good", words)
