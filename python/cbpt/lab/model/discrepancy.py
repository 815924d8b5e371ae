"""Real parts keep no textbook form exactly: how far an effect may look other than its equation.

    modulations          what the share of an effect may vary with, over the rows of a table
    discrepancy_columns  what an effect may show beside its form
    DISCREPANCY_ODDS     how much an effect is believed to depart from its form

An effect of contribution c(x) may be c(x) (1 + sum_j w_j b_j(x)) with small normal w_j; b_j are
smooth functions of load, angle and time, of mean 0 and variance 1 where the effect acts (the
discrepancy of Kennedy and O'Hagan 2001, tied to the effect's own size). So a bearing whose exponent
drifts stays a bearing, and a form that fits by a hair is no proof against its rivals.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]

DISCREPANCY_ODDS: tuple[tuple[float, float], ...] = ((0.0, 0.5), (0.02, 0.4), (0.08, 0.1))
"""Standard deviation of each w_j, and how likely that is."""
# A function that hardly varies where the effect acts says nothing of its form.
_LEAST_SPREAD = 0.02


def modulations(readings: Readings) -> Floats:
    """Functions of the columns that the share of an effect may follow, shape (n, m)."""
    return np.column_stack(list(_functions(readings)))


def _functions(r: Readings) -> Iterator[Floats]:
    size = np.abs(r.torque_Nm)
    share = size / max(float(size.max()), 1e-300)
    yield share
    yield share**2
    yield np.sign(r.torque_Nm)
    yield r.direction().astype(np.float64)
    if r.preload_N is not None:
        yield np.log(r.preload_N)
    angle = np.deg2rad(r.input_angle_deg)
    yield np.cos(angle)
    yield np.sin(angle)
    if r.time_s is not None:
        yield _from_start(r.time_s, np.zeros(len(size), dtype=np.int64))
        since = _from_start(r.time_s, r.run_index)
        yield since
        yield np.sqrt(since)


def _from_start(time_s: Floats, group: NDArray[np.int64]) -> Floats:
    """Time since the first reading of each group, on the longest."""
    first = np.full(int(group.max()) + 1, np.inf)
    np.minimum.at(first, group, time_s)
    since = time_s - first[group]
    return np.asarray(since / max(float(since.max()), 1e-300))


def discrepancy_columns(contribution: Floats, functions: Floats) -> Floats:
    """c (b_j - its mean) / its spread where the effect c acts, shape (n, k)."""
    weight = contribution**2
    total = float(weight.sum())
    if total <= 0:
        return np.zeros((len(contribution), 0))
    off = functions - (weight @ functions) / total
    spread = np.sqrt(weight @ off**2 / total)
    seen = spread > _LEAST_SPREAD
    return np.asarray(contribution[:, None] * (off[:, seen] / spread[seen]))
