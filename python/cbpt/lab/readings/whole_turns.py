"""Angles of an encoder that counts on from anywhere, and begins again after a whole turn.

unwrapped    angles without the jumps of a whole turn
absurd       angles and uncertainties that no drive has
about_runs   how far angles lie from the middle of their run

An elastic angle is a small part of a turn. Where a reading differs from the one before it by a turn
but for such a part, the encoder went past its end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.wording.numbers import listed

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TURN_ARCSEC = 1296000.0
_LEFT = 1 / 16
"""Share of a turn by which a reading may differ from the one before it once the turn is taken off:
more is a wrong number, and not an encoder that begins again."""


def unwrapped(angle_arcsec: Floats, run: NDArray[np.int64]) -> tuple[Floats, Ints]:
    """The angles, shape (n,), with whole turns taken off where they jump within a run, and the rows
    at which they do.

    run: number of the run of each, in the order of the table.
    """
    order = np.argsort(run, kind="stable")
    angle, index = angle_arcsec[order], run[order]
    step = np.diff(angle)
    turns = np.where(np.diff(index) == 0, np.round(step / TURN_ARCSEC), 0.0)
    if not turns.any() or np.abs(step - turns * TURN_ARCSEC)[turns != 0].max() > (
        _LEFT * TURN_ARCSEC
    ):
        return angle_arcsec, np.zeros(0, dtype=np.int64)
    jumped = np.r_[0.0, turns]
    total = np.cumsum(jumped)
    first = np.r_[True, np.diff(index) != 0]
    # Each run begins with the turn that its first reading has.
    total -= total[first][np.cumsum(first) - 1]
    found = np.empty_like(angle_arcsec)
    found[order] = angle - total * TURN_ARCSEC
    return found, np.sort(order[np.flatnonzero(jumped)])


def unwrapped_note(place: str, lines: list[int]) -> str:
    """What is said where whole turns were taken off, given the lines at which angles jumped."""
    shown = listed([str(line) for line in lines[:5]])
    more = f" and {len(lines) - 5} more" if len(lines) > 5 else ""
    return (
        f"the angle jumps by 360 deg at {place}{'s' * (len(lines) > 1)} {shown}{more}, as an "
        "encoder does that begins again after a turn: whole turns were taken off"
    )


def absurd(
    values: Mapping[str, Floats], run: NDArray[np.int64]
) -> Iterator[tuple[str, Ints, str, str]]:
    """Quantity, rows, the first value and what was expected, for angles more than half a turn from
    the middle of their run and uncertainties as large or of nothing: slips of a unit or a digit.
    """
    for key, least in (("elastic_angle", 0.0), ("u_elastic_angle", 1e-9)):
        if key not in values:
            continue
        size = np.abs(values[key] if least else about_runs(values[key], run))
        rows = np.flatnonzero((size > 0.5 * TURN_ARCSEC) | (size < least))
        if len(rows):
            about = " and above 1e-9 arcsec" if least else " about the middle of the run"
            value = f"{float(np.abs(values[key][rows[0]])):g} arcsec"
            yield key, rows, value, f"an angle below 180 deg{about}"


def about_runs(angle_arcsec: Floats, run: NDArray[np.int64]) -> Floats:
    """How far each angle lies from the median of its run, shape (n,)."""
    found = np.empty_like(angle_arcsec)
    order = np.argsort(run, kind="stable")
    edges = np.flatnonzero(np.diff(run[order])) + 1
    for rows in np.split(order, edges):
        if len(rows):
            found[rows] = angle_arcsec[rows] - np.median(angle_arcsec[rows])
    return found
