"""What a fit is of.

Hypothesis        variants of effects that are at work together
Unknown           one free number: its prior, bounds and unit
unknown_of_shape  a shape of an effect as an unknown
places_of_sizes   where the sizes of each variant stand among the unknowns
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbpt.lab.model.priors import STARTS_MOVING, Shape, Variant


@dataclass(frozen=True)
class Unknown:
    """One free number of a fit. sd: of its normal prior, infinite where there is none.

    A logarithmic unknown is searched in ln(value); its prior then is in the logarithm too.
    """

    index: int
    name: str
    mean: float
    sd: float
    lower: float
    upper: float
    unit: float
    """What one step of the search is, in SI: puts all unknowns on one scale."""
    log: bool = False
    size_of: int = -1
    """Which of the hypothesis's variants it is the size of; -1 for what is no size."""


@dataclass(frozen=True)
class Hypothesis:
    """Forms of effects that are at work together; none: the drive as stated."""

    variants: tuple[Variant, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """Ids, sorted."""
        return tuple(sorted(v.effect for v in self.variants))

    @property
    def contradicts_itself(self) -> bool:
        """Whether its forms have runs begin both at rest and while the torque changes."""
        return len({dict(v.fixed).get(STARTS_MOVING, 0.0) for v in self.variants if v.late}) > 1


def unknown_of_shape(index: int, name: str, shape: Shape) -> Unknown:
    """A normal prior as wide as the uniform one over the range of the shape."""
    low, high = (np.log(shape.low), np.log(shape.high)) if shape.log else (shape.low, shape.high)
    sd = float((high - low) / np.sqrt(12))
    return Unknown(
        index, name, float((low + high) / 2), sd, shape.low, shape.high, unit=sd, log=shape.log
    )


def places_of_sizes(variants: Sequence[Variant], unknowns: Sequence[Unknown]) -> list[list[int]]:
    """Of each variant of a hypothesis the places of its sizes among the unknowns."""
    numbers = range(len(variants))
    return [[i for i, u in enumerate(unknowns) if u.size_of == number] for number in numbers]
