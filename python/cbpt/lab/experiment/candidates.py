"""Runs that a rig could make: what the choice of a further run, or of a whole campaign, is among.

Limits       what the rig can do: torque, preloads, input angles, times
limits_of    as far as a rig went in some readings
candidates   loops, one-sided runs, held torques and turns of the crank within the limits
described    how the torque of a run goes
in_words     a run as one would ask for it at the rig
duration_s   how long it takes
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Drive
from cbpt.errors import InvalidInputError
from cbpt.lab.experiment.plan import PlannedRun, sequence
from cbpt.lab.readings.reader import Readings
from cbpt.lab.wording.numbers import significant

Floats = NDArray[np.float64]

READINGS = 13
"""In every run, so that runs compare."""
BOTH_WAYS = "up, down, through zero and back"
"""What the torque does in a loop."""


@dataclass(frozen=True)
class _Runs:
    """What candidate runs look like."""

    loop: tuple[float, ...] = (0, 0.25, 0.5, 0.75, 1, 0.5, 0, -0.25, -0.5, -0.75, -1, -0.5, 0)
    shares: tuple[float, ...] = (0.5, 0.85)
    """Of the torque that the preload holds."""
    dwell_s: float = 10.0


_RUNS = _Runs()


@dataclass(frozen=True)
class Limits:
    """What a rig can do. Raises `InvalidInputError` for what cannot be."""

    torque_Nm: float
    """The largest."""
    preload_N: tuple[float, float]
    """The lowest and the highest."""
    input_angle_deg: tuple[float, ...] = (0.0, 45.0, 90.0)
    dwell_s: float | None = _RUNS.dwell_s
    """From one reading to the next; None where there are no times."""
    temperature_degC: float | None = None
    cycles: int | None = None

    def __post_init__(self) -> None:
        low, high = self.preload_N
        if not (np.isfinite(self.torque_Nm) and self.torque_Nm > 0):
            raise InvalidInputError(
                f"torque_Nm: found {self.torque_Nm:g}, expected a torque above 0"
            )
        if not (0 < low <= high < np.inf):
            raise InvalidInputError(
                f"preload_N: found {low:g} to {high:g}, expected two forces above 0, lower first"
            )


def limits_of(readings: Readings) -> Limits:
    """About a fourth beyond what the rig did in some readings, in round numbers."""
    r = readings
    assert r.preload_N is not None
    low, high = float(r.preload_N.min()), float(r.preload_N.max())
    angles = np.unique(np.mod(r.input_angle_deg, 360.0))[:4].tolist()
    angles += [float(np.mod(angles[0] + step, 360.0)) for step in (45.0, 90.0)]
    return Limits(
        torque_Nm=significant(1.25 * float(np.abs(r.torque_Nm).max()), 2),
        preload_N=(significant(0.8 * low, 2), significant(1.25 * high, 2)),
        input_angle_deg=tuple(dict.fromkeys(angles)),
        dwell_s=_usual_step(r),
        temperature_degC=None if r.temperature_degC is None else float(r.temperature_degC.mean()),
        cycles=None if r.cycle is None else 1,
    )


def _usual_step(r: Readings) -> float | None:
    """Median time between readings of a run."""
    if r.time_s is None:
        return None
    order = np.lexsort((r.time_s, r.run_index))
    steps = np.diff(r.time_s[order])[np.diff(r.run_index[order]) == 0]
    return float(np.median(steps)) if len(steps) and np.median(steps) > 0 else _RUNS.dwell_s


def candidates(drive: Drive, limits: Limits, most: int | None = None) -> list[PlannedRun]:
    """Runs of 13 readings within the limits; `most` of them, evenly thinned, where it is given."""
    if most is not None and most < 1:
        raise InvalidInputError(f"candidates: found {most}, expected at least 1")
    every = list(dict.fromkeys(_every(drive, limits)))
    if most is None or len(every) <= most:
        return every
    return [every[i] for i in np.linspace(0, len(every) - 1, most).round().astype(int)]


def _every(drive: Drive, limits: Limits) -> Iterator[PlannedRun]:
    low, high = limits.preload_N
    needed = float(drive.preload(torque_Nm=limits.torque_Nm).drive.hold_N)
    plain = PlannedRun(
        (0.0,),
        dwell_s=limits.dwell_s,
        temperature_degC=None
        if limits.temperature_degC is None
        else (limits.temperature_degC, limits.temperature_degC),
        cycles=limits.cycles,
    )
    # Between the limits round numbers, as a rig is set to them.
    between = (significant(p, 2) for p in np.geomspace(low, high, 5)[1:-1].tolist())
    for preload in dict.fromkeys((low, *(p for p in between if low < p < high), high)):
        # What a preload holds grows in proportion to it.
        held = limits.torque_Nm * preload / needed
        peaks = (min(limits.torque_Nm, significant(share * held, 2)) for share in _RUNS.shares)
        for peak in dict.fromkeys(peaks):
            at = replace(plain, preload_N=preload)
            yield from _runs(at, peak, limits)


def _runs(at: PlannedRun, peak: float, limits: Limits) -> Iterator[PlannedRun]:
    loop = tuple(peak * share for share in _RUNS.loop)
    for angle in limits.input_angle_deg:
        yield replace(at, torque_Nm=loop, input_angle_deg=(angle,))
    first = replace(at, input_angle_deg=limits.input_angle_deg[:1])
    half = READINGS // 2 + 1
    for sign in (1.0, -1.0):
        yield replace(first, torque_Nm=sequence("up_down", sign * peak, half))
        turn = tuple(np.round(np.arange(READINGS) * 360.0 / READINGS, 3).tolist())
        yield replace(first, torque_Nm=(sign * peak,), input_angle_deg=turn)
    if limits.dwell_s is not None:
        yield replace(first, torque_Nm=sequence("hold", peak, READINGS))


def described(run: PlannedRun) -> str:
    """How the torque goes, in words."""
    torque = np.array(run.torque_Nm)
    if len(torque) == 1:
        return "held, while the crank turns"
    if torque.min() < 0 < torque.max():
        return BOTH_WAYS
    steps = np.diff(torque)
    way = "to " + ("the negative peak" if torque.min() < 0 else "the peak")
    return f"{way}, then held" if np.count_nonzero(steps) == 1 else f"{way} and back"


def duration_s(run: PlannedRun) -> float | None:
    """From the first reading to the last, s; None where the run has no times."""
    return None if run.dwell_s is None else (_readings(run) - 1) * run.dwell_s


def in_words(run: PlannedRun) -> str:
    """What one would ask for at the rig, N m, N, deg and s or min in the text:
    `one loop of +-5 N m at 400 N, input angle 10 deg: 13 readings, 2 min`."""
    torque = np.array(run.torque_Nm)
    peak = float(torque[np.argmax(np.abs(torque))])
    at = "" if run.preload_N is None else f" at {run.preload_N:g} N"
    angle = f", input angle {run.input_angle_deg[0]:g} deg"
    if len(torque) == 1:
        what, angle = f"one turn of the crank with {peak:g} N m held{at}", ""
    elif torque.min() < 0 < torque.max():
        what = f"one loop of +-{abs(peak):g} N m{at}"
    elif described(run).endswith("held"):
        what = f"{peak:g} N m, held{at}"
    else:
        what = f"torque to {peak:g} N m and back to zero{at}"
    time = duration_s(run)
    short = "" if time is None else f", {time:.0f} s" if time < 100 else f", {time / 60:.0f} min"
    return f"{what}{angle}: {_readings(run)} readings{short}"


def _readings(run: PlannedRun) -> int:
    return max(len(run.torque_Nm), len(run.input_angle_deg))
