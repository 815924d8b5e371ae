"""Legs whose angles were copied from another.

    Copies      which legs are whose, and the legs without them
    copies_of   finds them

Noise never repeats to the last digit over a whole leg, unless the display hides it: the share of
readings that are alike on legs that are not copies tells how likely that is by chance.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cbpt.lab.preflight.legs import Leg
from cbpt.lab.readings.readings import Readings


@dataclass(frozen=True)
class _Limits:
    """What makes a copy."""

    chance: float = 1e-6
    """Largest probability of a leg that is alike by chance."""
    values: int = 3
    """Different angles of a leg that can be told from one that stands still."""
    pairs: int = 500
    """Of legs, to tell the share of readings that are alike."""


_LIMITS = _Limits()


@dataclass(frozen=True, eq=False)
class Copies:
    """Legs of which one is the copy of another."""

    runs: list[tuple[int, int]]
    """Index of the run with the copy and of that with the first of its kind, each pair once."""
    legs: list[Leg]
    """Without the copies."""


def copies_of(r: Readings, legs: list[Leg], groups: list[list[Leg]]) -> Copies:
    """legs: all. groups: those that repeat each other."""
    alike = _alike(r, groups)
    first: dict[bytes, Leg] = {}
    kept, runs = [], []
    for leg in legs:
        angle = r.elastic_angle_arcsec[leg.rows]
        if alike ** len(angle) > _LIMITS.chance or len(np.unique(angle)) < _LIMITS.values:
            kept.append(leg)
            continue
        whose = first.setdefault(angle.tobytes(), leg)
        if whose is leg:
            kept.append(leg)
        else:
            runs.append((leg.run, whose.run))
    return Copies(list(dict.fromkeys(runs)), kept)


def _alike(r: Readings, groups: list[list[Leg]]) -> float:
    """Probability of a reading that is alike on two legs that are not copies; 1 where there are
    no two such legs, as in a simulated table."""
    same = total = pairs = 0
    for group in groups:
        for one, other in pairwise(group):
            if len(one.rows) != len(other.rows) or pairs >= _LIMITS.pairs:
                continue
            equal = r.elastic_angle_arcsec[one.rows] == r.elastic_angle_arcsec[other.rows]
            if not equal.all():
                pairs += 1
                same += int(equal.sum())
                total += len(equal)
    return (same + 1) / (total + 1)
