"""What effects would do to the readings of a plan, at sizes from the smallest plausible to the
largest.

    Form        one form of an effect with the changes it makes at every size
    forms_of    all forms of some effects on the rows of a campaign
    guises      what a form can look like to a fit that may choose its size and shape

Signatures of `screen` are slopes; here an effect acts in full, because some do not grow in
proportion to their size. All arrays are in arcsec on the n rows of the campaign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.symmetric import eigen
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.priors import LOT, Variant

Floats = NDArray[np.float64]

SIZES = 11
"""Sizes looked at, evenly spread in the logarithm from a tenth of the smallest plausible one to the
largest.
"""


@dataclass(frozen=True, eq=False)
class Form:
    """One form of an effect at one set of shapes."""

    variant: Variant
    shapes: dict[str, float]
    sizes: Floats
    """Off neutral, SI, in the unit of the first component, shape (m,): of several components the
    amplitude; of a lot the spread."""
    direction: Floats
    """Of each component for a size of 1, shape (k,)."""
    neutral: Floats
    """Value of each component where it does nothing, shape (k,)."""
    changes: Floats = field(repr=False)
    """Shape (n, m); NaN where the model has no solution. Of a lot: empty."""
    slopes: Floats = field(repr=False)
    """By one smallest plausible size of each component, shape (n, k)."""

    def values(self, size: float) -> dict[str, float]:
        """Parameters with the effect at this size, SI."""
        if self.variant.spread:
            return {"spread_m": size}
        own = (self.neutral + size * self.direction).tolist()
        sizes = dict(zip(self.variant.sizes, own, strict=True))
        return {**dict(self.variant.fixed), **sizes, **self.shapes}


def forms_of(
    campaign: Campaign, variants: Sequence[Variant], sizes: int | Floats = SIZES
) -> list[Form]:
    """Every variant at every combination of its shapes; of lots, one form that stands for all.

    sizes: how many, or the sizes themselves (SI, off neutral).
    """
    found: list[Form] = []
    models: dict[str, Assembled] = {}
    own = [effect for effect, _ in campaign.effects]
    for variant in variants:
        if variant.spread and any(f.variant.spread for f in found):
            continue
        if variant.effect not in models:
            effects = [e for e in own if e != variant.effect]
            count = campaign.balls if variant.spread else 1
            models[variant.effect] = Assembled(campaign, [variant.effect] * count + effects)
        for shapes in product(*(shape.grid for shape in variant.shapes)):
            named = {s.name: v for s, v in zip(variant.shapes, shapes, strict=True)}
            found.append(_form(models[variant.effect], campaign, variant, named, sizes))
    return found


def _form(
    model: Assembled,
    campaign: Campaign,
    variant: Variant,
    shapes: dict[str, float],
    sizes: int | Floats,
) -> Form:
    values = model.neutral.copy()
    for name, value in (*variant.fixed, *shapes.items()):
        values[model.index(0, name)] = value
    places = [model.index(0, name) for name in variant.sizes]
    point = model.at(values, places)
    ratios = np.array(variant.ratios or (1.0,) * len(places))
    unit = variant.low * ratios
    slopes = point.slopes * unit
    low, high = (2e-8, 3e-6) if variant.spread else (0.1 * variant.low, variant.high)
    grid = np.geomspace(low, high, sizes) if isinstance(sizes, int) else sizes
    if variant.spread:
        empty = np.zeros((len(campaign), 0))
        return Form(variant, shapes, grid, ratios, values[places], empty, slopes)
    direction: Floats = _typical(slopes / campaign.u_arcsec[:, None]) * ratios
    # A size that must not be negative grows from nothing.
    direction = direction if variant.signed else np.abs(direction)
    columns = []
    for size in grid:
        there = values.copy()
        there[places] += size * direction
        inside = np.all(np.abs(there[places]) <= model.upper[places])
        angle = model.at(there).angle_arcsec if inside else np.full(len(campaign), np.nan)
        columns.append(angle - point.angle_arcsec)
    changes = np.column_stack(columns)
    return Form(variant, shapes, grid, direction, values[places], changes, slopes)


def _typical(slopes: Floats) -> Floats:
    """A direction of the components, of length 1, that is seen neither best nor worst."""
    k = slopes.shape[1]
    if k == 1 or not np.isfinite(slopes).all():
        return np.full(k, k**-0.5)
    _, axes = eigen(slopes.T @ slopes)
    mean: Floats = axes.sum(axis=1) / np.sqrt(k)
    return mean if mean[0] >= 0 else -mean


def guises(seen: Sequence[tuple[Form, Floats, Floats]]) -> Iterator[Floats]:
    """Columns that a fit of one effect may combine as it likes; `seen` has each form of it with its
    changes and slopes as they are looked at.

    The components of an amplitude; an effect at two neighbouring shapes, which stand for those
    between; else the effect at each size. A lot can look like nearly everything and has none.
    """
    for variant in dict.fromkeys(form.variant for form, _, _ in seen):
        own = [entry for entry in seen if entry[0].variant is variant]
        if variant.spread:
            continue
        if len(variant.sizes) > 1:
            yield from (slopes for _, _, slopes in own)
        for (_, one, _), (_, other, _) in pairwise(own):
            for j in range(one.shape[1]):
                yield np.column_stack([one[:, j], other[:, j]])
        yield from (changes[:, [j]] for _, changes, _ in own for j in range(changes.shape[1]))


def possible(
    campaign: Campaign, variants: Sequence[Variant]
) -> tuple[list[Variant], dict[str, str]]:
    """Variants whose column varies in the campaign; and effects without any, each with the column
    that it needs."""
    there = [v for v in variants if not v.needs or _moves(campaign, v.needs)]
    effects = {v.effect for v in there}
    return there, {v.effect: str(v.needs) for v in variants if v.effect not in effects}


def _moves(campaign: Campaign, column: str) -> bool:
    values = getattr(campaign.readings, column)
    return values is not None and float(np.ptp(values)) > 0


__all__ = ["LOT", "SIZES", "Form", "forms_of", "guises", "possible"]
