"""Preloads and input angles that a table varies, and what they can show.

preload_range     ratio of the largest preload to the smallest
preload_varies    whether it shows an effect of the preload
Angles            input angles round the turn
angles_of         those of readings
turn_is_covered   whether they show a pattern round the turn
told_apart        whether effects of the preload and of the input angle can be
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.set_points import levels_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """What is enough."""

    preload: float = 1.1
    """Ratio of preloads. By Hertz the angle goes with the cube root of the preload at most: from
    here on it differs by the 3 % by which others can be told (lost motion, slopes of runs)."""
    angles: int = 4
    """Input angles: a mean, and sine and cosine of one period a turn, leave one to test them."""
    gap_deg: float = 180.0
    """Between neighbours, at most: less than half of a period looks like a slope or an offset."""
    evenly: float = 0.02
    """Of the step, by which equally spaced angles may be off."""
    set_deg: float = 0.1
    """Input angles that all lie within this are one: even a hundred periods a turn hardly change
    within it."""


_LIMITS = _Limits()


def preload_range(r: Readings) -> float:
    """1 where there is none."""
    if r.preload_N is None or not len(r):
        return 1.0
    value = levels_of(r.preload_N).value
    return float(value.max() / value.min()) if value.min() > 0 else float("inf")


def preload_varies(r: Readings) -> bool:
    """By enough to show what depends on it."""
    return preload_range(r) >= _LIMITS.preload


@dataclass(frozen=True, eq=False)
class Angles:
    """Set points of the input angle, deg in the turn."""

    value: Floats
    """In rising order round the turn from one of them on, shape (k,)."""
    index: Ints
    """Which of them each reading has, shape (n,)."""

    def __len__(self) -> int:
        return len(self.value)

    @property
    def gap_deg(self) -> float:
        """The largest between neighbours round the turn."""
        return float(np.diff(self.value, append=self.value[0] + 360.0).max())

    @property
    def step_deg(self) -> float:
        """Where they are spaced equally round the whole turn, else 0."""
        gaps = np.diff(self.value, append=self.value[0] + 360.0)
        step = 360.0 / len(gaps)
        return step if np.abs(gaps - step).max() <= _LIMITS.evenly * step else 0.0


def angles_of(input_angle_deg: Floats) -> Angles:
    """Of each reading, shape (n,). Scatter about set points is none of their number."""
    turn = np.mod(input_angle_deg, 360.0)
    exact = np.unique(turn)
    gaps = np.diff(exact, append=exact[0] + 360.0)
    # From the far side of the largest gap on, so that nothing is cut in two at zero.
    start = float(exact[(int(np.argmax(gaps)) + 1) % len(exact)])
    found = levels_of(np.mod(turn - start, 360.0))
    if found.value[-1] <= _LIMITS.set_deg:
        return Angles(start + found.value[:1], np.zeros(len(turn), dtype=np.int64))
    return Angles(start + found.value, found.index)


def turn_is_covered(angles: Angles) -> bool:
    """A pattern with one period a turn or more can be told."""
    return len(angles) >= _LIMITS.angles and angles.gap_deg <= _LIMITS.gap_deg


def told_apart(r: Readings, angles: Angles) -> bool:
    """Whether each preload leads to each other one over input angles that both were taken at, where
    both vary: else a pattern round the turn may stand for what the preload does."""
    if r.preload_N is None or len(angles) < 2:
        return True
    preload = levels_of(r.preload_N).index
    many = int(preload.max()) + 1
    if many < 2 or not preload_varies(r):
        return True
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    size = many + len(angles)
    pairs = coo_array((np.ones(len(r)), (preload, many + angles.index)), (size, size))
    return int(connected_components(pairs, directed=False)[0]) == 1
