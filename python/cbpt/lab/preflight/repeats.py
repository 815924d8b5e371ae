"""What was repeated in a table, and how far it differs.

repeats_check   readings under the same conditions, and how far they differ

Same conditions are the same preload (or its step), input angle and, where the table has columns of
words such as a state or a moment, the same word in each: what differs in one of these was not
repeated, however alike the torques are. Where the torque goes there and back, readings are held
against those of other legs that come from the same turning point (`repeats_compared`), else
against those at the same torque.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.covariance.repeatability import Repeats, pooled
from cbpt.lab.covariance.robust import typical_size
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.coverage_settings import angles_of
from cbpt.lab.preflight.legs import Leg, likes_of
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.repeats_compared import Compared, compared, odd_runs
from cbpt.lab.preflight.repeats_copies import copies_of
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.wording.numbers import listed, percent, rounded
from cbpt.lab.wording.phrases import some

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    misstated: float = 1.5
    """Repeats against the stated uncertainty, either way."""
    of_turn: float = 0.03
    """Share of the angle's range by which readings scatter, or slopes differ: lost motion is read
    at 3 % of the torque, where a linear drive turns by as much."""
    explained: float = 0.5
    """Share of the variance that has a reason if the reason is told."""
    apart: float = 0.01
    """Share of readings that stand apart from the scatter, from which on it is told."""
    apart_sd: float = 4.0
    """Standard deviations beyond which a step of the torque is none of its scatter."""
    strides: tuple[int, ...] = (1, 2, 3)
    """Readings apart, in differences of the torque."""
    follows: float = 0.1
    """Share of the torque's wavering that the angle may miss where the drive is no straight line;
    noise is more."""
    exact: float = 1e-9
    """Of the turn: what repeats better was computed."""
    named: int = 3
    """Runs that are named."""


_LIMITS = _Limits()
_TOO_MUCH = (
    "Find what scatters before anything is read off: lost motion is read at 3 % of the torque, "
    "where a linear drive turns by less than that."
)


def repeats_check(r: Readings, loops: list[Loop], legs: list[Leg]) -> Check:
    """What was taken again under the same conditions."""
    settings = _settings(r)
    groups = likes_of(r, legs, settings)
    copies = copies_of(r, legs, groups)
    step = display_step(r.elastic_angle_arcsec)
    for likes in (likes_of(r, copies.legs, settings), groups):
        found = compared(r, likes, step)
        if found is not None:
            check = _hidden(found) or _of_legs(r, likes, found)
            break
    else:
        check = _of_torques(r, settings, loops)
    if check.state != "lost":
        check = replace(check, finding=check.finding + _whatever(r))
    return _with_copies(r, check, copies.runs)


def _with_copies(r: Readings, check: Check, runs: list[tuple[int, int]]) -> Check:
    if not runs:
        return check
    shown = [
        f"run {_name(r, copy)} has the angles of "
        + (f"run {_name(r, whose)}" if copy != whose else "another of its own branches")
        for copy, whose in runs[: _LIMITS.named]
    ]
    more = f", and so on in {len(runs) - len(shown)} more" if len(runs) > len(shown) else ""
    words = f"{listed(shown)}{more}, to the last digit; {check.finding}"
    remedy = (
        "Were rows copied? If so, remove the copies from the table. In this check they count once."
    )
    return Check(check.subject, "look", words, f"{remedy} {check.remedy}".strip())


def _name(r: Readings, run: int) -> str:
    return str(r.run[int(np.flatnonzero(r.run_index == run)[0])])


def _settings(r: Readings) -> NDArray[np.int64]:
    """Which readings share preload, input angle and words, counted from 0, shape (n,)."""
    columns = [angles_of(r.input_angle_deg).index]
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


def _of_torques(r: Readings, settings: Ints, loops: list[Loop]) -> Check:
    """Readings at the same torques."""
    scattered = any(branch.scattered for loop in loops for branch in loop.branches)
    # Where the torque was measured and not set, hardly two readings have the same.
    found = None if scattered else pooled(_apart(r, settings), r.elastic_angle_arcsec)
    if found is None:
        remedy = "Repeat at least one run without touching the rig: repeats alone tell the noise."
        return Check("repeats", "lost", "hardly any reading was repeated", remedy)
    return _of_readings(found, float(np.ptp(r.elastic_angle_arcsec)))


def _of_readings(found: Repeats, turn_arcsec: float) -> Check:
    share = found.u_arcsec / turn_arcsec
    words = (
        f"{found}; standard deviation {rounded(found.u_arcsec)} arcsec, {rounded(100 * share)} % "
        "of the range of the angle"
    )
    check = _against_stated(words, (found.ratio, found.ratio))
    if share <= _LIMITS.of_turn:
        return check
    return Check("repeats", "look", check.finding, f"{check.remedy} {_TOO_MUCH}".strip())


def _against_stated(words: str, ratios: tuple[float | None, float | None]) -> Check:
    """ratios: of the repeats to the stated uncertainty, with and without what the torque does."""
    whole, least = ratios
    if whole is None or least is None:
        return Check("repeats", "good", words)
    words += f", {rounded(whole)} of the stated uncertainty"
    if 1 / _LIMITS.misstated < whole and least < _LIMITS.misstated:
        return Check("repeats", "good", words)
    remedy = "Check u_elastic_angle_arcsec, or what moves between repeats (clamping, temperature)."
    return Check("repeats", "look", words, remedy)


# --- legs ---------------------------------------------------------------------------------


def _of_legs(r: Readings, groups: list[list[Leg]], every: Compared) -> Check:
    odd, found = odd_runs(r, groups, every)
    odd.sort(key=lambda run: -run[1])
    size = found.scatter()
    part = _of_torque(r, groups, size)
    words = _told(r, found, part)
    u = r.u_elastic_angle_arcsec
    ratios: tuple[float | None, float | None] = (None, None)
    if u is not None:
        whole = found.scatter(u)
        ratios = (whole, whole * max(1 - (part / size if size else 0.0) ** 2, 0.0) ** 0.5)
    check = _against_stated(words, ratios)
    slopes, remedy = _slopes(r, found)
    words = check.finding + slopes
    asked = [check.remedy, remedy]
    if size > _LIMITS.of_turn * found.turn_arcsec and not remedy:
        asked.append(_TOO_MUCH)
    if odd:
        runs, off = _runs(r, [run for run, _ in odd]), [rounded(size) for _, size in odd]
        much = off[0] if len(odd) == 1 else f"{off[-1]} to {off[0]}"
        words += (
            f"; readings of {runs} are {much} arcsec off those of the others (standard deviation), "
            "and were left out of this"
        )
        asked.append(f"Look at what was different in {runs}.")
    told = " ".join(filter(None, asked))
    return Check("repeats", "look" if told else "good", words, told)


def _told(r: Readings, found: Compared, part: float) -> str:
    """How far readings differ, and why. part: what the torque's scatter makes of it."""
    size = found.scatter()
    runs = len(np.unique(found.run))
    words = (
        f"{len(np.unique(found.row))} readings of {runs} run{'s' * (runs > 1)} were repeated; a "
        f"reading scatters by {rounded(size)} arcsec about the mean at its torque (standard "
        f"deviation), {rounded(100 * size / found.turn_arcsec)} % of the range of the angle"
    )
    if part > _LIMITS.explained**0.5 * size:
        words += f"; the scatter of the torque alone makes about {rounded(part, 2)} arcsec"
    apart = float(np.mean(~found.near))
    if apart > _LIMITS.apart:
        words += f"; {percent(apart)} of the readings are further off and left out of that"
    return words


def _hidden(found: Compared) -> Check | None:
    """What repeats to the last digit tells the display and not the noise."""
    step = found.step_arcsec
    if not found.hidden and found.scatter() > _LIMITS.exact * found.turn_arcsec:
        return None
    runs = len(np.unique(found.run))
    shown = f"steps of {rounded(step)} arcsec" if step else "last digit"
    words = (
        f"{len(np.unique(found.row))} readings of {runs} run{'s' * (runs > 1)} were repeated and "
        f"agree to within the {shown}, which hides how far they differ"
    )
    remedy = "Read more digits; where rows were copied or simulated, no noise can be told."
    return Check("repeats", "look", words, remedy)


def _slopes(r: Readings, found: Compared) -> tuple[str, str]:
    """By how much the slopes of runs differ where that is most of the scatter, and the remedy."""
    runs, gain, left = found.slope
    size = found.scatter()
    if len(runs) < 2 or left**2 > (1 - _LIMITS.explained) * size**2:
        return "", ""
    # Each slope is off the mean of the others, and so further than off the mean of all.
    apart = float(np.ptp(gain)) * (1 - 1 / len(runs))
    steep, flat = int(runs[np.argmax(gain)]), int(runs[np.argmin(gain)])
    words = (
        f"; most of it as slopes of runs differ, by up to {percent(apart)} (run {_name(r, steep)} "
        f"turns most, run {_name(r, flat)} least)"
    )
    if apart < _LIMITS.of_turn:
        return words, ""
    return words, "Find what changes between runs (gain, clamping, preload, input angle)."


def _runs(r: Readings, runs: list[int]) -> str:
    return some("run", [_name(r, run) for run in runs], _LIMITS.named)


def _of_torque(r: Readings, groups: list[list[Leg]], scatter_arcsec: float) -> float:
    """What the scatter of the torque makes of that of the angle, arcsec.

    By third differences along the legs, which a curve hardly shows, of neighbours and of readings
    further apart, as noise may be alike in neighbours. Where the torque really wavers, the angle
    follows it; the part that it does not follow is noise of the torque.
    """
    legs = [leg.rows for group in groups for leg in group]
    torque, angle = (
        np.concatenate([values[rows] - values[rows].mean() for rows in legs])
        for values in (r.torque_Nm, r.elastic_angle_arcsec)
    )
    slope = float(torque @ angle / (torque @ torque))
    parts = []
    for apart in _LIMITS.strides:
        series = [rows[k::apart] for rows in legs for k in range(apart)]
        x, y = (
            np.concatenate([np.diff(values[rows], 3) for rows in series])
            for values in (slope * r.torque_Nm, r.elastic_angle_arcsec)
        )
        size = typical_size(x)
        near = np.abs(x) < _LIMITS.apart_sd * size
        if not near.any():
            return 0.0
        x, y = x[near], y[near]
        follows = abs(float(x @ y)) / float(x @ x)
        left = y - follows * x
        share = 1 - follows - 2 * float(np.sqrt((left @ left) / (x @ x) / len(x)))
        parts.append(size / 20**0.5 * share**0.5 if share > _LIMITS.follows else 0.0)
    return min(float(np.median(parts)), scatter_arcsec)
