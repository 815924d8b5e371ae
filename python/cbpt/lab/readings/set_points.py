"""Levels: the values that a rig was set to, recognised in what it held.

    Levels      which level each reading belongs to, and the value of each level
    levels_of   finds them
    settings    what a rig was set to: preloads, else steps of the preload, else runs

A held torque or preload jitters about its set point. Values belong to one level where they lie
close together against the distance to the next; a column without such gaps is left as it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Gaps:
    """What makes a set point."""

    jitters: tuple[float, ...] = (0.04, 0.02, 0.01, 0.005, 0.0025, 0.001)
    """Closer than this share of the range may be jitter; the coarsest that leaves clear gaps
    is taken.
    """
    compact: float = 0.5
    """A level is at most this part of the gap to the next."""
    held: float = 0.03
    """A column that varies by less than this part of its size was held at one level, unless
    readings gather at several: this many or more at each.
    """
    gathered: int = 3


_GAPS = _Gaps()


@dataclass(frozen=True, eq=False)
class Levels:
    """n values in k levels."""

    index: Ints
    """The level of each value, counted from the lowest, shape (n,)."""
    value: Floats
    """Shape (k,)."""

    def __len__(self) -> int:
        return len(self.value)

    @property
    def held(self) -> Floats:
        """Each reading's level, shape (n,)."""
        return self.value[self.index]


def levels_of(values: Floats) -> Levels:
    """Levels of a column; exact values where it does not jitter about fewer."""
    exact, index = np.unique(values, return_inverse=True)
    if len(exact) < 2:
        return Levels(index.astype(np.int64), exact)
    group = _grouped(exact, len(values))
    index = group[index].astype(np.int64)
    return Levels(index, _means(values, exact, group, index))


def settings(readings: Readings) -> tuple[Levels, list[str]]:
    """What the rig was set to at each reading, and a name for each setting."""
    if readings.preload_N is not None:
        levels = levels_of(readings.preload_N)
        return levels, [f"preload {value:.4g} N" for value in levels.value]
    word, labels = "run", readings.run
    if readings.preload_step is not None:
        word, labels = "preload step", readings.preload_step
    names, index = np.unique(labels, return_inverse=True)
    numbers = np.arange(len(names), dtype=np.float64)
    return Levels(index.astype(np.int64), numbers), [f"{word} {name}" for name in names.tolist()]


def _grouped(exact: Floats, n: int) -> Ints:
    gaps = np.diff(exact)
    width = float(exact[-1] - exact[0])
    held = width <= _GAPS.held * float(np.abs(exact).max())
    for share in _GAPS.jitters:
        split = gaps > share * width
        tried = np.r_[0, np.cumsum(split)]
        clear = split.any() and _widest(exact, tried) <= _GAPS.compact * float(gaps[split].min())
        if clear and not (held and n < _GAPS.gathered * (tried[-1] + 1)):
            return np.asarray(tried, dtype=np.int64)
    return np.zeros(len(exact), dtype=np.int64) if held else np.arange(len(exact))


def _widest(exact: Floats, group: Ints) -> float:
    first = np.flatnonzero(np.r_[True, np.diff(group) > 0])
    last = np.r_[first[1:] - 1, len(exact) - 1]
    return float((exact[last] - exact[first]).max())


def _means(values: Floats, exact: Floats, group: Ints, index: Ints) -> Floats:
    """Mean of each level, but the value itself where there is only one: a mean would round."""
    count = np.bincount(group)
    mean = np.bincount(index, values) / np.bincount(index)
    single = count == 1
    mean[single] = exact[single[group]]
    return np.asarray(mean)
