"""Angles of an encoder that counts on from anywhere, and begins again after a whole turn.

unwrapped    angles without the jumps of a whole turn; unwrapped_note, what is said of them
absurd       angles and uncertainties that no drive has
about_runs   how far angles lie from the middle of their run

An elastic angle is a small part of a turn. Where a reading differs from the one before it, or a run
from the first one, by a turn but for such a part, the encoder went past its end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.wording.phrases import some

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_TURN_ARCSEC = 1296000.0
_LEFT = 1 / 16
"""Share of a turn by which a reading may differ from the one before it once the turn is taken off:
more is a wrong number, and not an encoder that begins again."""


def unwrapped(angle_arcsec: Floats, run: NDArray[np.int64]) -> tuple[Floats, Ints]:
    """The angles, shape (n,), with whole turns taken off where they jump within a run, and where
    the middle of a run is a whole turn from that of the first one, but for a small part; and the
    rows at which they do.

    run: number of the run of each, in the order of the table.
    """
    order = np.argsort(run, kind="stable")
    angle, index = angle_arcsec[order], run[order]
    step = np.diff(angle)
    turns = np.where(np.diff(index) == 0, np.round(step / _TURN_ARCSEC), 0.0)
    left = np.abs(step - turns * _TURN_ARCSEC)[turns != 0]
    if left.size and left.max() > _LEFT * _TURN_ARCSEC:
        return angle_arcsec, np.zeros(0, dtype=np.int64)
    jumped = np.r_[0.0, turns]
    total = np.cumsum(jumped)
    starts = np.flatnonzero(np.r_[True, np.diff(index) != 0])
    # Each run begins with the turn that its first reading has.
    total -= total[starts][np.cumsum(np.r_[True, np.diff(index) != 0]) - 1]
    angle = angle - total * _TURN_ARCSEC
    first = float(np.median(angle[: starts[1]])) if len(starts) > 1 else 0.0
    for a, b in pairwise([*starts[1:].tolist(), len(angle)]):
        off = float(np.median(angle[a:b])) - first
        whole = np.round(off / _TURN_ARCSEC)
        if whole and abs(off - whole * _TURN_ARCSEC) <= _LEFT * _TURN_ARCSEC:
            angle[a:b] -= whole * _TURN_ARCSEC
            jumped[a] = whole
    found = np.empty_like(angle_arcsec)
    found[order] = angle
    return found, np.sort(order[np.flatnonzero(jumped)])


def unwrapped_note(place: str, lines: list[int]) -> str:
    """What is said where whole turns were taken off, given the lines at which angles jumped."""
    return (
        f"the angle jumps by 360 deg at {some(place, list(map(str, lines)))}, as an encoder does "
        "that begins again after a turn: whole turns were taken off"
    )


def absurd(
    values: Mapping[str, Floats], run: NDArray[np.int64]
) -> Iterator[tuple[str, Ints, str, str]]:
    """Quantity, rows, the first value and what was expected, for angles of many turns or more than
    half a turn from the middle of their run, and uncertainties beyond half a turn or of nothing:
    slips of a unit or a digit."""
    for key, least in (("elastic_angle", 0.0), ("u_elastic_angle", 1e-9)):
        if key not in values:
            continue
        size = np.abs(values[key])
        beyond = size > 0.5 * _TURN_ARCSEC
        if not least:
            beyond = size > 1.5 * _TURN_ARCSEC  # one turn, and what was unwrapped
            beyond |= np.abs(about_runs(values[key], run)) > 0.5 * _TURN_ARCSEC
        rows = np.flatnonzero(beyond | (size < least))
        if len(rows):
            expected = (
                "an angle below 180 deg and above 1e-9 arcsec"
                if least
                else "an angle within a turn, and less than 180 deg from the middle of its run"
            )
            yield key, rows, f"{values[key][rows[0]]:g} arcsec", expected


def about_runs(angle_arcsec: Floats, run: NDArray[np.int64]) -> Floats:
    """How far each angle lies from the median of its run, shape (n,)."""
    found = np.empty_like(angle_arcsec)
    order = np.argsort(run, kind="stable")
    edges = np.flatnonzero(np.diff(run[order])) + 1
    for rows in np.split(order, edges):
        if len(rows):
            found[rows] = angle_arcsec[rows] - np.median(angle_arcsec[rows])
    return found
