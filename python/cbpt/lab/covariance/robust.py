"""Scatter by medians, which a few values that stand apart do not move.

typical_size       standard deviation of normal values about 0
neighbour_scatter  of the values of series beside their neighbours
scatter_off_lines  the same of values at places that are not evenly spaced
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb, sqrt

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_NORMAL = 1.4826
"""Standard deviation over the median size of what is normal about 0."""


def typical_size(values: Floats) -> float:
    """In the unit of the values; 0 of none."""
    return _NORMAL * float(np.median(np.abs(values))) if len(values) else 0.0


def neighbour_scatter(series: Sequence[Floats], order: int) -> float:
    """By the differences of this order, which a curve through the values hardly shows: of second
    differences y_1 - 2 y_2 + y_3 the variance is 6 times that of a value, of third ones 20 times.
    """
    differences = [np.diff(values, order) for values in series]
    size = typical_size(np.concatenate(differences)) if differences else 0.0
    return size / sqrt(comb(2 * order, order))


def scatter_off_lines(series: Sequence[tuple[Floats, Floats]]) -> float:
    """Of values y at rising places x off the straight lines through their two neighbours."""
    off = []
    for x, y in series:
        share = (x[1:-1] - x[:-2]) / np.maximum(x[2:] - x[:-2], 1e-300)
        line = (1 - share) * y[:-2] + share * y[2:]
        off.append((y[1:-1] - line) / np.sqrt(1 + share**2 + (1 - share) ** 2))
    return typical_size(np.concatenate(off)) if off else 0.0
