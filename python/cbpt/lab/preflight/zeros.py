"""Whether the runs start from one zero.

zeros_check   angles of the runs at zero torque against each other
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbpt._core import Case, Drive
from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.sizes import scatter_arcsec
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded


@dataclass(frozen=True)
class _Limits:
    """What is apart."""

    clear: float = 4.0
    """Standard deviations of a reading: of two zeros one pair in 10,000 is further apart."""
    of_turn: float = 0.02
    """Share of the largest turn of a run, where no scatter is known."""


_LIMITS = _Limits()


def zeros_check(r: Readings, loops: Sequence[Loop], case: Case | Drive | None) -> Check:
    """Where each run is at zero torque, against those that come there in the same way."""
    name = "zeros of runs"
    groups = [zeros for zeros in _zeros(r, loops).values() if len(zeros) > 1]
    if not groups:
        words = "too few runs come to zero torque in the same way to compare them"
        return Check(name, "good", words)
    squares = sum(float(np.var(zeros) * len(zeros)) for zeros in groups)
    spread = float(np.sqrt(squares / sum(len(zeros) - 1 for zeros in groups)))
    step, scatter = display_step(r.elastic_angle_arcsec), scatter_arcsec(r, loops)
    if spread <= step:
        return Check(name, "good", "at zero torque the runs are apart by less than a step")
    words = f"at zero torque the runs are {rounded(spread)} arcsec apart (standard deviation)"
    turns = [np.ptp(r.elastic_angle_arcsec[r.run_index == k]) for k in np.unique(r.run_index)]
    least = _LIMITS.clear * scatter if scatter else _LIMITS.of_turn * float(max(turns))
    common = not (isinstance(case, Case) and case.zero == "per_run")
    if spread > least and common:
        remedy = (
            'Set zero = "per_run" under [measurement] in the case, or zero the sensor once for all '
            "runs."
        )
        return Check(name, "look", words, remedy)
    return Check(name, "good", words)


def _zeros(r: Readings, loops: Sequence[Loop]) -> dict[str | int, list[float]]:
    """The angle of each run at zero torque, by how it comes there: the middle of its loops, else
    with a torque that rises (1) or falls (-1), or at its first reading (0). Friction keeps these
    apart."""
    of_loops: dict[str, list[float]] = {}
    for loop in loops:
        middle = float(np.mean([float(branch.at(0.0)) for branch in loop.branches]))
        if loop.whole and np.isfinite(middle):
            of_loops.setdefault(loop.run, []).append(middle)
    found: dict[str | int, list[float]] = {}
    for run in range(int(r.run_index.max()) + 1):
        rows = np.flatnonzero(r.run_index == run)
        middles = of_loops.get(str(r.run[rows[0]]))
        if middles:
            found.setdefault("loop", []).append(float(np.mean(middles)))
        elif (first := _first_zero(r, rows)) is not None:
            found.setdefault(first[0], []).append(first[1])
    return found


def _first_zero(
    r: Readings, rows: np.ndarray[tuple[int], np.dtype[np.int64]]
) -> tuple[int, float] | None:
    """By which way the torque of a run first comes to zero, and the angle there."""
    torque, angle = r.torque_Nm[rows], r.elastic_angle_arcsec[rows]
    here = np.flatnonzero(torque == 0)
    crossed = np.flatnonzero(torque[1:] * torque[:-1] < 0)
    if len(here) and (not len(crossed) or here[0] <= crossed[0]):
        k = int(here[0])
        return (int(np.sign(-torque[k - 1])) if k else 0), float(angle[k])
    if not len(crossed):
        return None
    a, b = crossed[0], crossed[0] + 1
    share = torque[a] / (torque[a] - torque[b])
    return int(np.sign(torque[b])), float(angle[a] + share * (angle[b] - angle[a]))
