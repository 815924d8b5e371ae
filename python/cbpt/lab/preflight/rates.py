"""How fast the load went.

rates_check   the rates of all legs: up against down, runs against each other, along a leg; pauses

The rate of a leg is the median over its middle, of the torque's way over the time of a tenth of
the leg, and where these differ the mean: ends, where a drive waits or turns round, do not count,
and neither do pauses. The first leg of a run often goes half the way; it counts where there is no
other that way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.warnings import RATES
from cbpt.lab.preflight.legs import Leg
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded
from cbpt.lab.wording.phrases import span

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due, and how a leg is cut up."""

    along: float = 2.0
    """Ratio of the quickest to the slowest part of a leg: a sine has 1.7 in the middle of it."""
    told: float = 1.3
    """The same, from where on it is told."""
    ends: float = 0.1
    """Share of a leg's torques at either end that do not count."""
    parts: int = 10
    """Of a leg, over each of which a rate is taken."""
    still: float = 0.1
    """Share of a leg's torques that it goes on by in a pause, or in all of its holds, at most."""
    pause: float = 20.0
    """Times the usual time between readings that a pause takes at least."""
    of_leg: float = 0.1
    """And share of the time of the leg without it."""
    held: float = 0.5
    """Share of its readings that a leg in steps holds the torque for, at least."""
    hold: float = 2.0
    """Times between readings that a hold takes at least."""
    run_s: float = 86_400.0
    """A run that takes more than a day goes through the temperatures of day and night."""
    named: int = 3
    """Runs that are named."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class _Rate:
    """Of one leg."""

    run: str
    way: int
    typical: float
    slow: float
    quick: float
    """In N m/s, of its tenths; the same as the typical one where they cannot be told."""
    hold_s: float
    """How long each step is held, 0 where the torque does not go in steps."""
    paces: float
    """Ratio of the longest times between readings to the shortest."""


@dataclass(frozen=True)
class _Pause:
    """A time without readings or load."""

    time_s: float
    run: str
    before: str


def rates_check(r: Readings, every: Sequence[Leg]) -> Check:
    """Rates, where there are times and legs. every: all legs of the table."""
    name = "rates"
    if r.time_s is None:
        remedy = "Record the time of each reading: drift, creep and the rate need it."
        return Check(name, "lost", "no time in the table", remedy)
    legs = [leg for leg in every if len(leg.rows) > 2]
    usual = np.median([len(leg.rows) for leg in legs]) if legs else 0
    legs = [leg for leg in legs if len(leg.rows) >= 0.5 * usual]  # few readings tell no rate
    later = {leg.way for leg in legs if not leg.first}
    compared = [leg for leg in legs if not (leg.first and leg.way in later)]
    rates = [rate for leg in compared if (rate := _rate(r, leg, r.time_s)) is not None]
    if not rates:
        words = "no run goes steadily from one torque to another, so there is no rate"
        return Check(name, "good", words + _single(r))
    pauses = [pause for leg in legs for pause in _pauses(r, leg, r.time_s)]
    words, asked = _between(rates)
    for more, remedy in (_along(r, rates), _paused(pauses), _long(r, r.time_s, legs)):
        words += more
        asked += [remedy] * bool(remedy)
    remedy = " ".join(dict.fromkeys(asked))
    return Check(name, "look" if remedy else "good", words + _single(r), remedy)


_ONE_RATE = "Load at one rate: friction of reducers depends on it."


def _between(rates: list[_Rate]) -> tuple[str, list[str]]:
    """Legs against each other."""
    typical = [rate.typical for rate in rates]
    low, high = min(typical), max(typical)
    if high <= RATES * low:
        return f"{span(low, high)} N m/s", []
    up, down = (
        float(np.median([rate.typical for rate in rates if rate.way == way] or [np.nan]))
        for way in (1, -1)
    )
    usual = float(np.median(typical))
    runs: dict[str, list[float]] = {}
    ways: dict[str, dict[int, list[float]]] = {}
    for rate in rates:
        runs.setdefault(rate.run, []).append(rate.typical)
        ways.setdefault(rate.run, {}).setdefault(rate.way, []).append(rate.typical)
    # Within runs, where they go both ways: one run may be quicker than another.
    both = [abs(np.log(np.median(w[1]) / np.median(w[-1]))) for w in ways.values() if len(w) == 2]
    differ = max(up, down) > RATES * min(up, down)
    if differ and (not both or np.median(both) > np.log(RATES)):
        return f"{rounded(up)} N m/s up and {rounded(down)} N m/s down", [_ONE_RATE]
    means = {run: float(np.median(own)) for run, own in runs.items()}
    odd = [run for run, mean in means.items() if max(mean / usual, usual / mean) > RATES]
    rest = [mean for run, mean in means.items() if run not in odd]
    clear = [max(means[run] / mean, mean / means[run]) > RATES for run in odd for mean in rest]
    if 0 < len(odd) <= _LIMITS.named and rest and all(clear):
        told = ", ".join(f"{rounded(means[run])} N m/s in run {run}" for run in odd)
        return f"{told} and {span(min(rest), max(rest))} N m/s in the others", [_ONE_RATE]
    return f"{span(low, high)} N m/s", [_ONE_RATE]


def _along(r: Readings, rates: list[_Rate]) -> tuple[str, str]:
    """Parts of the legs against each other."""
    held = [rate.hold_s for rate in rates if rate.hold_s]
    if len(held) > 0.5 * len(rates):
        return f" as a mean over steps with holds of {rounded(float(np.median(held)))} s", ""
    slow = float(np.median([rate.slow for rate in rates]))
    quick = float(np.median([rate.quick for rate in rates]))
    if quick <= _LIMITS.told * slow:
        return "", ""
    words = f", {span(slow, quick)} N m/s along a branch"
    # Finer steps near zero at one pace are those that are asked for where lost motion is read.
    steps = len(np.unique(r.torque_Nm)) <= 0.5 * len(r)
    pace = float(np.median([rate.paces for rate in rates]))
    ratio = quick / max(slow, 1e-300)
    ratio = min(ratio, pace) if steps else ratio
    return words, _ONE_RATE if ratio > _LIMITS.along else ""


def _paused(pauses: list[_Pause]) -> tuple[str, str]:
    if not pauses:
        return "", ""
    longest = max(pauses, key=lambda pause: pause.time_s)
    words = f"; a pause of {rounded(longest.time_s)} s in run {longest.run} before {longest.before}"
    if len(pauses) > 1:
        words += f" and {len(pauses) - 1} shorter one{'s' * (len(pauses) > 2)}"
    return words, "Go through each run without a pause: drift and creep go on in it."


def _long(r: Readings, time: Floats, legs: list[Leg]) -> tuple[str, str]:
    runs = {leg.run for leg in legs}
    took = max(float(np.ptp(time[r.run_index == run])) for run in runs)
    if took <= _LIMITS.run_s:
        return "", ""
    words = f"; a run takes up to {rounded(took / 3600)} h"
    return words, "Are the times in ms, not in s? If not, a run goes through day and night."


def _single(r: Readings) -> str:
    """Runs of one reading, where others have more."""
    count = np.bincount(r.run_index)
    alone = np.flatnonzero(count == 1)
    if not len(alone) or 2 * len(alone) > len(count):
        return ""
    if len(alone) == 1:
        return f"; run {r.run[r.run_index == alone[0]][0]} has one reading, and no rate"
    return f"; {len(alone)} runs have one reading, and no rate"


# --- one leg ------------------------------------------------------------------------------


def _rate(r: Readings, leg: Leg, time: Floats) -> _Rate | None:
    """None where the middle of a leg is too short."""
    rows = _middle(r, leg)
    if r.torque_Nm[rows[0]] == r.torque_Nm[rows[-1]]:
        rows = leg.rows  # the middle is one torque that is held
    torque, t = r.torque_Nm[rows], time[rows]
    step = np.diff(t)
    for pause in _stops(r, rows, time).tolist():
        t = np.r_[t[: pause + 1], t[pause + 1 :] - step[pause] + float(np.median(step))]
    if len(rows) < 2 or not t[-1] > t[0] or torque[-1] == torque[0]:
        return None
    hold = _hold_s(torque, t)
    mean = abs(float(torque[-1] - torque[0])) / float(t[-1] - t[0])
    if hold or len(rows) < 3:
        return _Rate(str(r.run[rows[0]]), leg.way, mean, mean, mean, hold, 1.0)
    k = max(1, len(rows) // _LIMITS.parts)
    way = np.abs(torque[k:] - torque[:-k])
    parts = way / (t[k:] - t[:-k])
    slow, typical, quick = np.percentile(parts, [10, 50, 90]).tolist()
    if quick > _LIMITS.told * slow or not typical > 0:
        typical = mean
    if np.any(np.diff(torque) * leg.way < 0):
        slow, typical, quick = mean, mean, mean  # parts of a torque that scatters tell no rate
    short, long = np.percentile(np.diff(t), [10, 90]).tolist()
    return _Rate(str(r.run[rows[0]]), leg.way, typical, slow, quick, 0.0, long / max(short, 1e-300))


def _middle(r: Readings, leg: Leg) -> NDArray[np.int64]:
    torque = r.torque_Nm[leg.rows]
    low, high = float(torque.min()), float(torque.max())
    off = _LIMITS.ends * (high - low)
    inside = np.flatnonzero((torque >= low + off) & (torque <= high - off))
    return leg.rows[inside[0] : inside[-1] + 1] if len(inside) > 1 else leg.rows


def _stops(r: Readings, rows: NDArray[np.int64], time: Floats) -> NDArray[np.int64]:
    """Places between rows in which time goes on, and the torque does not."""
    step, way = np.diff(time[rows]), np.abs(np.diff(r.torque_Nm[rows]))
    if len(step) < 3:
        return np.zeros(0, dtype=np.int64)
    usual = float(np.median(step))
    long = (step > _LIMITS.pause * usual) & (step > _LIMITS.of_leg * usual * len(step))
    return np.flatnonzero(long & (way <= _LIMITS.still * float(np.ptp(r.torque_Nm[rows]))))


def _pauses(r: Readings, leg: Leg, time: Floats) -> Iterator[_Pause]:
    for place in _stops(r, leg.rows, time).tolist():
        after = int(leg.rows[place + 1])
        took = float(time[after] - time[leg.rows[place]])
        yield _Pause(took, str(r.run[after]), f"{r.place} {int(r.line[after])}")


def _hold_s(torque: Floats, t: Floats) -> float:
    """How long a torque that goes in steps is held; 0 where it goes otherwise."""
    step = np.diff(torque)
    size = float(np.median(np.abs(step)))
    still = np.abs(step) <= max(4 * size, 1e-9 * float(np.abs(torque).max()))
    whole = abs(float(torque[-1] - torque[0]))
    if np.mean(still) < _LIMITS.held or abs(float(step[still].sum())) > _LIMITS.still * whole:
        return 0.0
    ends = np.flatnonzero(~still)
    if len(ends) < 3:
        return 0.0
    hold = float(np.median(t[ends[1:]] - t[ends[:-1] + 1]))
    # Two readings alike may be the display of a torque that goes on.
    return hold if hold >= _LIMITS.hold * float(np.median(np.diff(t))) else 0.0
