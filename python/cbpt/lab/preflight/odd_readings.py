"""Readings that the rig did not take: single ones far from their neighbours, and frozen signals.

odd_check   what was found, and which readings the other checks leave out

A reading is far where the ones before and after it agree, and it differs from them by many times
what neighbours differ by otherwise. A torque that turns, a play, a step of a program and a first
loading all move on and do not come back at once. A signal is frozen where it is the same to the
last digit for many readings while the other column goes on, and jumps to where that has got to.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import typical_size
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded
from cbpt.lab.wording.phrases import few, some

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class _Limits:
    """What is far, and what is frozen."""

    neighbours: int = 3
    """On each side of a reading; two odd ones in a row are still fewer than the others."""
    of_scatter: float = 10.0
    """Standard deviations of what a reading differs by from its neighbours: no noise does that."""
    of_step: float = 3.0
    """The same in steps to the next reading, as four in five are at most: at a turn of the torque
    the neighbours are two steps away."""
    of_digit: float = 2.0
    """The same in the smallest step of the column: rounding moves two readings apart by one, and a
    last digit that flickers by one more."""
    digit_of_held: float = 0.05
    """That digit as a share of what was held, where the column hardly ever moves and shows none."""
    moves: int = 5
    """Steps of a column that show its last digit: one odd reading makes two."""
    agree: float = 1 / 3
    """Share of it by which the neighbours differ at most, but for the outermost two of them."""
    most: float = 0.05
    """Share of the readings of a run, one at least: more of them are how the run was taken."""
    follows: float = 0.5
    """Share of what a torque would turn the drive by that may be missing where it was there."""
    frozen: int = 8
    """Readings in a row that are the same."""
    same: float = 0.2
    """Share of the other neighbours that may be the same where sameness is to tell something."""
    jump: float = 5.0
    """Usual steps by which the column jumps afterwards."""


_LIMITS = _Limits()


def odd_check(r: Readings) -> tuple[Check, Bools]:
    """The check, and which readings are odd, shape (n,)."""
    far, still = np.zeros(len(r), dtype=np.bool_), np.zeros(len(r), dtype=np.bool_)
    words, remedies = [], []
    runs = [np.flatnonzero(r.run_index == k) for k in range(int(r.run_index.max()) + 1)]
    for name, values, other, unit in _columns(r):
        here, off = np.zeros(len(r), dtype=np.bool_), np.zeros(len(r))
        stretches = []
        for rows in runs:
            mine, torque, angle = values[rows], r.torque_Nm[rows], r.elastic_angle_arcsec[rows]
            off[rows] = mine - _neighbours(mine)[0]
            digit, slope = _digit(mine), _slope(angle, torque)
            turned, loaded = angle - _neighbours(angle)[0], torque - _neighbours(torque)[0]
            by_load = slope * loaded
            here[rows] = _far(mine, digit)
            if name != "preload":
                # A load that the angle follows was there.
                here[rows] &= np.abs(turned - by_load) > _LIMITS.follows * np.abs(by_load)
                # What the torque turns the drive by is no distance from the neighbours; but at a
                # turn an angle that ends at a stop is none either.
                digit = _digit(angle) + abs(slope) * _digit(torque)
                alone = _far(angle - slope * torque, digit) & ~_near_turns(torque)
                not_angle = np.abs(turned) < _LIMITS.follows * np.abs(by_load)
                here[rows] |= alone & (not_angle if name == "torque" else ~not_angle)
            if other is not None and slope:
                per = 1 / slope if name == "torque" else slope
                stretches += [rows[part] for part in _frozen(mine, per * other[rows])]
        if here.any():
            words.append(_told_far(r, name, off[here], np.flatnonzero(here), unit))
            far |= here
        if stretches:
            words.append(_told_frozen(r, name, stretches))
            still[np.concatenate(stretches)] = True
    if far.any():
        remedies.append(
            "A spike, a wrong digit or a lost sample? Correct the table there, or remove the row."
        )
    if still.any():
        remedies.append(
            "Did the signal freeze, or the logger lose it? Remove those rows, or measure again."
        )
    name = "single readings"
    if not words:
        told = "no reading lies far from those before and after it"
        if max(map(len, runs)) <= 2 * _LIMITS.neighbours:
            told = "the runs are too short to tell whether one reading lies far from the others"
        return Check(name, "good", told), far
    words.append("the other checks leave that out, compare and diagnose do not")
    return Check(name, "look", "; ".join(words), " ".join(remedies)), far | still


def _columns(r: Readings) -> Iterator[tuple[str, Floats, Floats | None, str]]:
    """Name, values and unit of each column, and the one that goes on where it is frozen."""
    yield "torque", r.torque_Nm, r.elastic_angle_arcsec, "N m"
    yield "angle", r.elastic_angle_arcsec, r.torque_Nm, "arcsec"
    if r.preload_N is not None:
        yield "preload", r.preload_N, None, "N"


def _told_far(r: Readings, name: str, off: Floats, rows: NDArray[np.int64], unit: str) -> str:
    """off: by which the readings in these rows differ from their neighbours."""
    at = some(r.place, list(map(str, r.line[rows].tolist())))
    return (
        f"the {name} of {at} lies {'up to ' * (len(rows) > 1)}"
        f"{rounded(float(np.abs(off).max()))} {unit} from the readings before and after it"
    )


def _told_frozen(r: Readings, name: str, stretches: list[NDArray[np.int64]]) -> str:
    parts = [f"{r.line[rows[0]]} to {r.line[rows[-1]]}" for rows in stretches]
    other = "angle" if name == "torque" else "torque"
    return (
        f"the {name} stays the same to the last digit in {r.place}s {few(parts)} while the "
        f"{other} goes on, and jumps afterwards"
    )


def _neighbours(values: Floats) -> tuple[Floats, Floats]:
    """The median of the nearest readings of each reading, and by how much these differ but for the
    least and the largest of them; NaN at the ends of a run, where there are none on one side."""
    k, n = _LIMITS.neighbours, len(values)
    middle, apart = np.full(n, np.nan), np.full(n, np.nan)
    if n > 2 * k:
        window = np.lib.stride_tricks.sliding_window_view(values, 2 * k + 1)
        near = np.sort(np.delete(window, k, axis=1), axis=1)
        middle[k:-k], apart[k:-k] = np.median(near, axis=1), near[:, -2] - near[:, 1]
    return middle, apart


def _digit(values: Floats) -> Floats:
    """The smallest step of a column, at each of its readings."""
    step = np.abs(np.diff(values))
    moving = step[step > 0]
    if len(moving) < _LIMITS.moves:
        return np.asarray(_LIMITS.digit_of_held * np.abs(values))
    return np.full(len(values), moving.min())


def _slope(angle: Floats, torque: Floats) -> float:
    """Angle over torque from reading to reading, the median over the larger steps."""
    step, turned = np.diff(torque), np.diff(angle)
    size = np.abs(step)
    if not np.any(size > 0):
        return 0.0
    large = size >= np.median(size[size > 0])
    return float(np.median(turned[large] / step[large]))


def _far(values: Floats, digit: Floats) -> Bools:
    """Readings of one run, in the order of time, that lie far from their neighbours. digit: the
    smallest step that the column shows, at each reading."""
    middle, apart = _neighbours(values)
    off = np.abs(values - middle)
    known = np.isfinite(off)
    if not known.any():
        return known
    limit = (
        _LIMITS.of_scatter * typical_size(off[known])
        + _LIMITS.of_step * float(np.quantile(np.abs(np.diff(values)), 0.8))
        + _LIMITS.of_digit * digit
    )
    far = known & (off > limit) & (apart < _LIMITS.agree * off)
    return far & bool(far.sum() <= max(1.0, _LIMITS.most * len(far)))


def _near_turns(torque: Floats) -> Bools:
    """Readings beside which the torque turns, as many away as neighbours are looked at."""
    way = np.sign(np.diff(torque))
    turns = np.flatnonzero(way[1:] * way[:-1] < 0) + 1
    near = np.zeros(len(torque), dtype=np.bool_)
    for off in range(-_LIMITS.neighbours, _LIMITS.neighbours + 1):
        near[np.clip(turns + off, 0, len(torque) - 1)] = True
    return near


def _frozen(values: Floats, other: Floats) -> Iterator[slice]:
    """Stretches of one run over which a column is frozen while the other one goes on, which is
    given as what it would make of the first."""
    same = np.diff(values) == 0
    edges = np.flatnonzero(np.diff(np.r_[False, same, False].astype(np.int8))).reshape(-1, 2)
    long = [slice(a, b + 1) for a, b in edges.tolist() if b + 1 - a >= _LIMITS.frozen]
    if not long:
        return
    elsewhere = np.ones(len(same), dtype=np.bool_)
    for part in long:
        elsewhere[part.start : part.stop - 1] = False
    if not elsewhere.any() or float(np.mean(same[elsewhere])) > _LIMITS.same:
        return
    step = np.abs(np.diff(values))
    usual = float(np.median(step[elsewhere & (step > 0)]))
    for part in long:
        after = part.stop
        if after == len(values):
            continue
        jump = float(values[after] - values[part.start])
        went = float(other[after - 1] - other[part.start])
        # A torque that is held, and then set anew, takes the angle with it when it moves.
        if abs(jump) > _LIMITS.jump * usual and abs(went - jump) < _LIMITS.follows * abs(jump):
            yield part
