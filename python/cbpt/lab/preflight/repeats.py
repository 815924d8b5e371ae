"""What was repeated in a table, and how far it differs.

repeats_check   readings or whole loops under the same conditions, and how far they differ

Same conditions are the same preload (or its step), input angle and, where the table has columns of
words such as a state or a moment, the same word in each: what differs in one of these was not
repeated, however alike the torques are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.covariance.repeatability import Repeats, pooled
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.wording.numbers import listed, rounded

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    misstated: float = 1.5
    """Repeats against the stated uncertainty, either way."""
    amplitudes: tuple[float, float] = (0.9, 1 / 0.9)
    """Ratio of the torques to which loops of one amplitude go."""


_LIMITS = _Limits()


def repeats_check(r: Readings, loops: list[Loop]) -> Check:
    """What was taken again under the same conditions."""
    settings = _settings(r)
    scattered = any(branch.scattered for loop in loops for branch in loop.branches)
    # Where the torque was measured and not set, hardly two readings have the same.
    found = None if scattered else pooled(_apart(r, settings), r.elastic_angle_arcsec)
    if found is not None:
        of_readings = _of_readings(found)
        return replace(of_readings, finding=of_readings.finding + _whatever(r))
    groups = _repeated(loops, settings)
    if groups:
        found_loops = _of_loops(groups, display_step(r.elastic_angle_arcsec))
        return replace(found_loops, finding=found_loops.finding + _whatever(r))
    remedy = "Repeat at least one run without touching the rig: repeats alone tell the noise."
    return Check("repeats", "lost", "hardly any reading was repeated", remedy)


def _settings(r: Readings) -> NDArray[np.int64]:
    """Which readings share preload, input angle and words, counted from 0, shape (n,)."""
    columns = [levels_of(np.mod(r.input_angle_deg, 360.0)).index]
    if r.preload_N is not None:
        columns.append(levels_of(r.preload_N).index)
    words = [*r.labels.values(), *([] if r.preload_step is None else [r.preload_step])]
    columns += [np.unique(labels, return_inverse=True)[1] for labels in words]
    return np.unique(np.column_stack(columns), axis=0, return_inverse=True)[1].ravel()


def _whatever(r: Readings) -> str:
    """Columns of numbers that one run has one value of and some runs share: what they mean is not
    known, and no runs were kept apart by them."""
    runs = int(r.run_index.max()) + 1
    firsts = [int(np.flatnonzero(r.run_index == k)[0]) for k in range(runs)]
    names = [
        repr(name)
        for name, values in r.extra.items()
        if np.array_equal(values, values[firsts][r.run_index], equal_nan=True)
        and 1 < len(np.unique(values)) < runs
    ]
    if not names:
        return ""
    return (
        f", whatever {listed(names)} {'is' if len(names) == 1 else 'are'}: if that was changed on "
        "purpose, look at each of its values alone (--only)"
    )


def _apart(r: Readings, settings: NDArray[np.int64]) -> Readings:
    """The readings with each setting a preload step of its own."""
    return replace(r, preload_step=settings)


def _of_readings(found: Repeats) -> Check:
    words = f"{found}; standard deviation {rounded(found.u_arcsec)} arcsec"
    if found.ratio is None:
        return Check("repeats", "good", words)
    words += f", {rounded(found.ratio)} of the stated uncertainty"
    if 1 / _LIMITS.misstated < found.ratio < _LIMITS.misstated:
        return Check("repeats", "good", words)
    remedy = "Check u_elastic_angle_arcsec, or what moves between repeats (clamping, temperature)."
    return Check("repeats", "look", words, remedy)


def _repeated(loops: list[Loop], settings: NDArray[np.int64]) -> list[list[Loop]]:
    """Whole loops in groups of one setting and one amplitude, of two or more each."""
    low, high = _LIMITS.amplitudes
    groups: list[tuple[int, list[Loop]]] = []
    for loop in sorted((x for x in loops if x.whole), key=lambda x: x.amplitude_Nm):
        rows = np.concatenate([branch.row for branch in loop.branches]).astype(np.int64)
        here = np.unique(settings[rows])
        if len(here) > 1:
            continue
        for setting, group in groups:
            ratio = loop.amplitude_Nm / group[0].amplitude_Nm
            if setting == here[0] and low < ratio < high:
                group.append(loop)
                break
        else:
            groups.append((int(here[0]), [loop]))
    return [group for _, group in groups if len(group) > 1]


def _of_loops(groups: list[list[Loop]], step_arcsec: float) -> Check:
    parts = [(_variance(group), len(group) - 1) for group in groups]
    dof = sum(n for _, n in parts)
    spread = (sum(variance * n for variance, n in parts) / dof) ** 0.5
    count = sum(map(len, groups))
    several = f" under {len(groups)} conditions" * (len(groups) > 1)
    words = f"{count} loops repeat each other{several}"
    turn = max(loop.turn_arcsec for group in groups for loop in group)
    # What repeats to the last digit tells the display and not the noise.
    if spread < max(step_arcsec / 12**0.5, 1e-9 * turn):
        shown = f"steps of {rounded(step_arcsec)} arcsec" if step_arcsec else "last digit"
        words += f" and agree to within the {shown}, which hides how far they differ"
        remedy = "Read more digits; where rows were copied or simulated, no noise can be told."
        return Check("repeats", "look", words, remedy)
    words += f" and differ by {rounded(spread)} arcsec (standard deviation about their mean)"
    return Check("repeats", "good", words)


def _variance(group: list[Loop]) -> float:
    """How far loops lie apart: both branches on the same torques, each loop without its offset,
    arcsec squared."""
    grid = np.linspace(-0.9, 0.9, 19) * min(loop.amplitude_Nm for loop in group)
    table = np.array([np.concatenate([b.at(grid) for b in loop.branches]) for loop in group])
    table = table[:, np.isfinite(table).all(axis=0)]
    table = table - table.mean(axis=1)[:, None]
    return float(np.mean(table.var(axis=0, ddof=1)))
