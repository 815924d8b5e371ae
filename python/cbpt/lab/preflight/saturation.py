"""Columns that stay at the end of their range while the load goes on.

saturation_check   torque or angle that stays where the other one, or a command, goes on and back
follows_torque     names of the other columns that follow the torque, as a command does
saturated          whether the torque stays while such a column goes on

A held torque is no saturation: under it an angle creeps one way, and does not come back while the
torque stays. What goes on and comes back while another column stays at its end tells that this one
was cut, or the drive was at a limit. An angle has to stay to the last digit for that, though it
otherwise differs from reading to reading, and where the torque does so as well, both were cut.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import listed, rounded

Floats = NDArray[np.float64]
Kind = Literal["command", "torque", "angle", "both"]


@dataclass(frozen=True)
class _Limits:
    """What stays, and what goes on."""

    fewest: int = 4
    """Readings in a row at the end of a range: a ramp that turns leaves two or three there."""
    of_scatter: float = 4.0
    """Standard deviations by which a reading may lie off the end of its range and be there."""
    of_step: float = 0.1
    """The same as a share of the usual step to the next reading."""
    goes_on: float = 0.02
    """Share of its range by which another column goes beyond where it was when the first came to
    its end."""
    clear: float = 5.0
    """Nor less than so many times what counts as the end of the range."""
    follows: float = 0.9
    """Correlation of a column that follows the torque."""
    neighbours: float = 0.2
    """Share of neighbouring readings that may be the same where sameness is to tell something."""


_LIMITS = _Limits()


_CUT_ANGLE = (
    "Is the angle sensor at the end of its range? Widen it, or leave these readings out. If not, "
    "the drive is at a hard stop."
)


@dataclass(frozen=True)
class _Found:
    """One column at one end in one run."""

    kind: Kind
    run: str
    at: float
    beyond: float
    """Where the other column went."""
    other: str = ""


def saturation_check(r: Readings) -> Check:
    """Torque and angle at the ends of their ranges."""
    found = list(_all(r))
    # A sensor is cut at one angle in all runs; where an angle sticks for another reason, it is not.
    angles = [f.at for f in found if f.kind == "angle"]
    several = int(r.run_index.max()) > 0 if len(r) else False
    found = [f for f in found if f.kind != "angle" or not several or angles.count(f.at) > 1]
    parts = [
        _told(kind, those)
        for kind in ("command", "torque", "angle", "both")
        if (those := [f for f in found if f.kind == kind])
    ]
    if not any(f.kind == "angle" for f in found) and (alike := _same_end(r)):
        parts.append((alike, _CUT_ANGLE))
    if not parts:
        return Check("ends of the ranges", "good", "no column stays at its end while others go on")
    words, remedies = zip(*parts, strict=True)
    return Check("ends of the ranges", "look", "; ".join(words), " ".join(remedies))


def _same_end(r: Readings) -> str:
    """What is said where many readings have the largest or the least angle to the last digit, under
    conditions that differ, and hardly two have any other: few readings of each run may reach it."""
    if not np.ptp(r.elastic_angle_arcsec) > 0:
        return ""
    told = []
    values, index = np.unique(r.elastic_angle_arcsec, return_inverse=True)
    count = np.bincount(index.ravel(), minlength=len(values))
    for end, word, others in ((-1, "largest", count[:-1]), (0, "least", count[1:])):
        here = index.ravel() == end % len(values)
        columns = (r.torque_Nm, r.preload_N, r.input_angle_deg)
        differ = any(np.ptp(column[here]) > 0 for column in columns if column is not None)
        torque = r.torque_Nm[here]
        alike = max(_LIMITS.fewest, _LIMITS.clear * float(others.max(initial=0)))
        if count[end] >= alike and differ:
            told.append(
                f"{count[end]} readings have the same {word} angle, {rounded(values[end])} arcsec, "
                f"under torques of {rounded(torque.min())} to {rounded(torque.max())} N m"
            )
    return "; ".join(told)


def saturated(r: Readings) -> bool:
    """Whether the torque stays while a column that follows it goes on."""
    return any(f.kind == "command" for f in _all(r))


def follows_torque(r: Readings) -> list[str]:
    """Names of the columns without a use that follow the torque."""
    return [name for name, values in r.extra.items() if _follows(values, r.torque_Nm)]


def _told(kind: Kind, found: list[_Found]) -> tuple[str, str]:
    runs = list(dict.fromkeys(f.run for f in found))
    which = f"in run {runs[0]}" if len(runs) == 1 else f"in {len(runs)} runs"
    at, beyond = rounded(max(abs(f.at) for f in found)), rounded(max(abs(f.beyond) for f in found))
    if kind == "command":
        columns = listed(sorted({repr(f.other) for f in found}))
        words = f"{which} the torque stays at {at} N m while {columns} goes on to {beyond} and back"
        remedy = (
            f"The drive or its current was at a limit: rely on no torque beyond {at} N m, do not "
            "use the command in its place, and ramp no further."
        )
        return words, remedy
    if kind == "torque":
        words = f"{which} the torque stays at {at} N m while the angle goes on and back"
        return words, (
            "Is the torque sensor at the end of its range? Widen it, or leave these readings out."
        )
    if kind == "angle":
        words = f"{which} the angle stays while the torque goes on to {beyond} N m and back"
        return words, _CUT_ANGLE
    words = f"{which} torque and angle stay the same to the last digit at the end of the loop"
    return words, "Were both columns cut there, or the signals frozen? Leave these readings out."


def _all(r: Readings) -> Iterator[_Found]:
    step = display_step(r.elastic_angle_arcsec)
    commands = follows_torque(r)
    for run in range(int(r.run_index.max()) + 1 if len(r) else 0):
        rows = np.flatnonzero(r.run_index == run)
        torque, angle = r.torque_Nm[rows], r.elastic_angle_arcsec[rows]
        if len(rows) < 2 * _LIMITS.fewest or not np.ptp(torque) * np.ptp(angle) > 0:
            continue
        if float(np.corrcoef(torque, angle)[0, 1]) < 0:
            angle = -angle
        label = str(r.run[rows[0]])
        for sign in (1.0, -1.0):
            others = {name: sign * r.extra[name][rows] for name in commands}
            yield from _at_one_end(label, sign * torque, sign * angle, others, step)


def _at_one_end(
    run: str, torque: Floats, angle: Floats, commands: dict[str, Floats], step: float
) -> Iterator[_Found]:
    """At the upper end of both columns."""
    ends, near = _stays(torque, 0.0)
    for part in ends:
        gone = {name: _goes_on(c, part, near / np.ptp(torque)) for name, c in commands.items()}
        name = max(gone, key=lambda n: gone[n], default="")
        at = float(np.median(torque[part]))
        if name and gone[name]:
            yield _Found("command", run, at, float(commands[name][part].max()), name)
        elif _goes_on(angle, part, near / np.ptp(torque)):
            yield _Found("torque", run, at, float(angle[part].max()))
        elif _same(torque, part) and _same(angle, part) and _cut(angle, part, step):
            yield _Found("both", run, at, at)
    ends, near = _stays(angle, step)
    for part in ends:
        # After a play, or where friction sticks, an angle hardly moves; cut, it does not at all.
        cut = _same(angle, part) and _differs(angle)
        if cut and _goes_on(torque, part, near / np.ptp(angle)):
            at = float(np.median(angle[part]))
            yield _Found("angle", run, at, float(torque[part].max()))


def _stays(values: Floats, step: float) -> tuple[list[slice], float]:
    """Where a column stays at its upper end, and how near to it that is."""
    scatter = neighbour_scatter([values], 3)
    usual = float(np.median(np.abs(np.diff(values))))
    near = max(_LIMITS.of_scatter * scatter, _LIMITS.of_step * usual, step)
    # The end is what most of the highest readings have, not the one with the most scatter.
    top = float(np.median(np.sort(values)[-_LIMITS.fewest :]))
    inside = np.r_[False, np.abs(values - top) <= near, False]
    edges = np.flatnonzero(np.diff(inside.astype(np.int8)))
    parts = [slice(a, b) for a, b in edges.reshape(-1, 2).tolist() if b - a >= _LIMITS.fewest]
    return parts, near


def _goes_on(values: Floats, part: slice, near: float) -> float:
    """By which share of its range a column goes on beyond both ends of a part; 0 for too little."""
    here = values[part]
    range_ = float(np.ptp(values)) or 1.0
    share = float(here.max() - max(here[0], here[-1])) / range_
    noise = neighbour_scatter([values], 3) / range_
    return share if share > max(_LIMITS.goes_on, _LIMITS.clear * max(near, noise)) else 0.0


def _same(values: Floats, part: slice) -> bool:
    """Whether enough readings in a row are the same to the last digit."""
    same = np.r_[False, np.diff(values[part]) == 0, False].astype(np.int8)
    edges = np.flatnonzero(np.diff(same)).reshape(-1, 2)
    return bool(np.any(np.diff(edges, axis=1) >= _LIMITS.fewest - 1))


def _cut(values: Floats, part: slice, step: float) -> bool:
    """Whether a column that differs otherwise comes to a part and leaves it by more than steps of
    its display, as one does not that turns slowly."""
    by = np.abs(np.diff(values))
    moves = np.flatnonzero(by)
    # The last move before the column came to stay, and the first one after it.
    middle = (part.start + part.stop) // 2
    beside = [by[k] for k in (*moves[moves < middle][-1:], *moves[moves >= middle][:1])]
    return bool(beside) and min(beside) > 2 * step and _differs(values)


def _differs(values: Floats) -> bool:
    """Whether readings away from the ends differ from their neighbours."""
    low, high = float(values.min()), float(values.max())
    middle = values[(values > low) & (values < high)]
    return len(middle) > 2 and float(np.mean(np.diff(middle) == 0)) < _LIMITS.neighbours


def _follows(values: Floats, torque: Floats) -> bool:
    known = np.isfinite(values)
    if known.sum() < 3 or not np.ptp(values[known]) * np.ptp(torque[known]) > 0:
        return False
    return bool(known.all() and np.corrcoef(values, torque)[0, 1] > _LIMITS.follows)
