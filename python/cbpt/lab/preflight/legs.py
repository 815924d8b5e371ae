"""Ways of the torque from one turn to the next, and which of them repeat each other.

    Leg        one way of a run
    legs_of    all of a table
    likes_of   legs in groups that repeat each other

The angle at a torque depends on where the torque came from: legs repeat each other that go the same
way from the same turning point under the same settings. The first leg of a run comes from whatever
was before; it is compared with other first legs, and only where nothing else was repeated.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.turns import turns_of

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """What makes a turn, and turning points alike."""

    turn: float = 0.04
    """Share of the torque's range in the run by which it turns back, as for loops."""
    of_whole: float = 0.01
    """And of its range in the table: a held torque that wavers has no turns."""
    of_scatter: float = 5.0
    """And standard deviations of the torque."""
    start: float = 0.05
    """Turning points of loops whose amplitudes differ by a tenth differ by this share of the
    range; what is called one load differs by no more."""


_LIMITS = _Limits()


@dataclass(frozen=True, eq=False)
class Leg:
    """One way of a run."""

    run: int
    """Index of the run."""
    rows: Ints
    """In the order of time, from one turn to the next."""
    way: int
    """+1 where the torque rises, -1 where it falls."""
    first: bool
    """Whether the run begins with it."""

    def start_Nm(self, r: Readings) -> float:
        """The torque at which it begins."""
        return float(r.torque_Nm[self.rows[0]])


def legs_of(r: Readings) -> list[Leg]:
    """Of every run in the order of the table; none where the torque goes nowhere, or at random."""
    found: list[Leg] = []
    whole = float(np.ptp(r.torque_Nm)) if len(r) else 0.0
    for run in range(int(r.run_index.max()) + 1 if len(r) else 0):
        rows = np.flatnonzero(r.run_index == run)
        torque = r.torque_Nm[rows]
        if len(rows) < 3:
            continue
        least = max(
            _LIMITS.turn * float(np.ptp(torque)),
            _LIMITS.of_scatter * neighbour_scatter([torque], 2),
            _LIMITS.of_whole * whole,
        )
        for first, last in pairwise(turns_of(torque, least)):
            way = 1 if torque[last] > torque[first] else -1
            begins = not found or found[-1].run != run
            found.append(Leg(run, rows[first : last + 1], way, begins))
    return found


def likes_of(r: Readings, legs: list[Leg], settings: Ints) -> list[list[Leg]]:
    """Groups of two or more legs that repeat each other. settings: shape (n,), of each reading."""
    later = [leg for leg in legs if not leg.first]
    return _groups(r, later, settings) or _groups(r, [leg for leg in legs if leg.first], settings)


def _groups(r: Readings, legs: list[Leg], settings: Ints) -> list[list[Leg]]:
    slack = _LIMITS.start * float(np.ptp(r.torque_Nm)) if len(r) else 0.0
    found: dict[tuple[int, int], list[list[Leg]]] = {}
    for leg in sorted(legs, key=lambda leg: leg.start_Nm(r)):
        here = settings[leg.rows]
        if (here != here[0]).any():
            continue
        same = found.setdefault((int(here[0]), leg.way), [])
        if same and leg.start_Nm(r) - same[-1][0].start_Nm(r) <= slack:
            same[-1].append(leg)
        else:
            same.append([leg])
    return [group for same in found.values() for group in same if len(group) > 1]
