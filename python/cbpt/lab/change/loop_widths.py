"""The loops of the levels as they were measured, without any model.

LoopWidths   width at zero torque at every level, of loops of one amplitude
widths_of    finds them

A model can only say what changed in its own terms. Where it leaves a rest that is larger than what
changed, one value may describe all levels though their loops differ; the widths then show it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.between_readings import width_open_arcsec
from cbpt.lab.characteristics.loops import Loop, loops_of
from cbpt.lab.model.own_loops import ALIKE
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]

ALIKE_WIDTHS = 1.5
"""Widths that differ by less may differ by what a fitted friction or play does not follow."""
_UNLIKE = 2.0
"""Standard uncertainties by which widths differ that are not said to be one."""
CHANCE = 0.01
"""Largest chance at which loops of one width would differ as much (Student's t)."""


@dataclass(frozen=True)
class LoopWidths:
    """Loops of one amplitude; the tuples have a value for each level."""

    amplitude_Nm: float
    width_arcsec: tuple[float, ...]
    """Falling less rising branch at zero torque, the mean of the level's loops."""
    u_arcsec: tuple[float | None, ...]
    """Standard uncertainty, from how much loops of one level differ and from the steps of their
    torque; None where none repeats."""
    loops: tuple[int, ...]
    """How many each level has."""
    differ: tuple[int, int] | None
    """The two levels whose widths differ most, where they differ by more than the loops of one
    level, a factor of 1.5 and what the steps of the torque leave open; else None."""
    may_differ: tuple[int, int] | None = None
    """Two levels whose widths differ, or too much to say that nothing changed; else None."""


def widths_of(
    levels: Sequence[Readings],
    reproducibility_arcsec: float | None = None,
    repeated: Sequence[Sequence[int]] = (),
) -> tuple[LoopWidths, ...]:
    """Of all amplitudes at which every level has whole loops, the smallest first; a difference
    counts as far as it goes beyond what the rig does when it is set up again. repeated: places of
    levels that repeat one state, if that is estimated from them."""
    per_level = [[loop for loop in loops_of(r) if loop.whole] for r in levels]
    found = []
    for low, high in _amplitudes([loop.amplitude_Nm for loops in per_level for loop in loops]):
        alike = [
            [p for p in loops if low <= p.amplitude_Nm <= high and np.isfinite(p.width_arcsec)]
            for loops in per_level
        ]
        if all(alike):
            amplitude_Nm = float(np.sqrt(low * high))
            set_up_arcsec = reproducibility_arcsec or 0.0
            found.append(_of_one_amplitude(amplitude_Nm, alike, set_up_arcsec, repeated))
    return tuple(found)


def _amplitudes(all_Nm: Sequence[float]) -> Iterator[tuple[float, float]]:
    """The ranges of those that are alike, in rising order."""
    rest = sorted(all_Nm)
    while rest:
        alike = [a for a in rest if a <= ALIKE * rest[0]]
        yield alike[0], alike[-1]
        rest = rest[len(alike) :]


def _of_one_amplitude(
    amplitude_Nm: float,
    loops: Sequence[Sequence[Loop]],
    reproducibility_arcsec: float,
    repeated: Sequence[Sequence[int]],
) -> LoopWidths:
    """The scatter is taken as the same at all levels."""
    widths = [np.array([loop.width_arcsec for loop in of_level]) for of_level in loops]
    left_open = np.array([np.mean([width_open_arcsec(p) for p in of_level]) for of_level in loops])
    mean = np.array([w.mean() for w in widths])
    count = np.array([len(w) for w in widths])
    dof = int(np.sum(count - 1))
    alone = u = np.full(len(widths), np.nan)
    if dof:
        scatter = sum(float(np.sum((w - w.mean()) ** 2)) for w in widths) / dof
        alone = np.sqrt(scatter / count)
        # A set-up that moves the branches of a loop apart widens it by twice as much.
        u = np.hypot(alone, 2 * reproducibility_arcsec)
    told = np.hypot(u, left_open / np.sqrt(3))  # anywhere between the readings, as likely
    differ = _most_different(mean, u, left_open, dof) if dof else None
    if repeated:
        # A few repeats tell a reproducibility only roughly: it makes no widths alike that differ by
        # more than the repeats themselves.
        may = _perhaps_different(mean, np.hypot(alone, left_open / np.sqrt(3)), repeated)
    else:
        may = _perhaps_different(mean, told)
    return LoopWidths(
        amplitude_Nm=amplitude_Nm,
        width_arcsec=tuple(mean.tolist()),
        u_arcsec=tuple(value if dof else None for value in told.tolist()),
        loops=tuple(count.tolist()),
        differ=differ,
        may_differ=differ or may,
    )


def _most_different(mean: Floats, u: Floats, left_open: Floats, dof: int) -> tuple[int, int] | None:
    """Two levels, of all pairs those furthest apart in their uncertainties, that differ by more
    than the steps of the torque leave open of both."""
    from scipy.stats import t

    pairs = list(combinations(range(len(mean)), 2))
    apart = [
        (abs(mean[a] - mean[b]) > left_open[a] + left_open[b])
        * abs(mean[a] - mean[b])
        / max(np.hypot(u[a], u[b]), 1e-300)
        for a, b in pairs
    ]
    first, second = pairs[int(np.argmax(apart))]
    # The most of several pairs: the chance of each is that much smaller (Bonferroni).
    chance = 2 * float(t.sf(max(apart), dof)) * len(pairs)
    return (first, second) if chance < CHANCE and _apart(mean[first], mean[second]) else None


def _perhaps_different(
    mean: Floats, u: Floats, repeated: Sequence[Sequence[int]] = ()
) -> tuple[int, int] | None:
    """Two levels, of all pairs those furthest apart in their uncertainties, that differ by a factor
    of 1.5, by twice their uncertainty and by more than levels that repeat one state."""
    together = [pair for state in repeated for pair in combinations(sorted(state), 2)]
    alike = max((abs(mean[a] - mean[b]) for a, b in together), default=0.0)
    told = [
        (abs(mean[a] - mean[b]) / max(np.hypot(u[a], u[b]), 1e-300), (a, b))
        for a, b in combinations(range(len(mean)), 2)
        if _apart(mean[a], mean[b]) and abs(mean[a] - mean[b]) > alike
    ]
    furthest, pair = max(told, default=(0.0, (0, 0)))
    return pair if furthest > _UNLIKE else None


def _apart(one: float, other: float) -> bool:
    small, large = sorted((abs(one), abs(other)))
    return large > ALIKE_WIDTHS * small
