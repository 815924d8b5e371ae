"""Ranking that rounding does not decide.

ranked  places of values, the largest first
"""

from __future__ import annotations

from collections.abc import Sequence

_DIGITS = 6


def ranked(values: Sequence[float]) -> list[int]:
    """Places of values, the largest first; those that differ by less than 1e-6 keep their order.

    Different forms of an effect, or families of patterns, may be the same function of the readings
    that a table has: then the first one is taken on every machine.
    """
    return sorted(range(len(values)), key=lambda i: -round(values[i], _DIGITS))
