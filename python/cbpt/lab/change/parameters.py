"""The numbers that changed, and those that did not.

changed_of    parameters of the groups that more likely changed than not
unchanged_of  sizes and numbers that one value describes at all levels
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cbpt.lab.change.parties import Levels
from cbpt.lab.change.posterior import Weighed, groups_of
from cbpt.lab.change.record import Changed, Direction, Unchanged
from cbpt.lab.inference.estimates import unit_of
from cbpt.lab.selection.rules import RULES


def changed_of(weighed: Weighed) -> list[Changed]:
    """Parameters of the groups that more likely changed than not: sizes, and shapes that moved."""
    found = []
    for group in weighed.groups:
        chance = weighed.changed(group.effect)
        if chance < RULES.undecided:
            continue
        choice = weighed.best_with(group.effect)
        best, levels = choice.fit, choice.levels
        own = next(g for g in groups_of(levels) if g.effect == group.effect)
        for place in own.unknowns:
            unknown = levels.fits[0].unknowns[place]
            pairs = [_si(levels, best.value(k, place), place) for k in range(len(levels.fits))]
            values, u = (tuple(column) for column in zip(*pairs, strict=True))
            is_size = unknown.size_of >= 0 or "." not in unknown.name
            name = _name(levels, place)
            changed = Changed(
                group.effect,
                name,
                unit_of(name),
                values[0],
                values[-1],
                u[0],
                u[-1],
                _direction(values, u, is_size and "." in unknown.name),
                chance,
                values,
                u,
                trend_of(values, u),
            )
            if is_size or changed.moved:
                found.append(changed)
    return sorted(found, key=lambda c: -c.probability)


def unchanged_of(weighed: Weighed) -> list[Unchanged]:
    """Sizes and numbers that one value describes at all levels."""
    found = []
    best, levels = weighed.best.fit, weighed.best.levels
    for group in groups_of(levels):
        if weighed.changed(group.effect) >= RULES.undecided:
            continue
        place = group.unknowns[0]
        value, u = _si(levels, best.value(0, place), place)
        name = _name(levels, place)
        found.append(Unchanged(group.effect, name, unit_of(name), value, u))
    return found


def _name(levels: Levels, place: int) -> str:
    """The name of a parameter, also of a number that is known by its effect."""
    unknown = levels.fits[0].unknowns[place]
    name = unknown.name.partition(".")[2]
    if name:
        return name
    model = levels.parties[0].problem.model
    return next(p for (_, p), i in model.places.items() if i == unknown.index)


def _si(levels: Levels, found: tuple[float, float], place: int) -> tuple[float, float]:
    """Coordinate and its uncertainty, in SI."""
    unknown = levels.fits[0].unknowns[place]
    value, u = found[0] * unknown.unit, found[1] * unknown.unit
    return (float(np.exp(value)), float(np.exp(value)) * u) if unknown.log else (value, u)


def _direction(values: Sequence[float], u: Sequence[float], may_vanish: bool) -> Direction:
    first, last = abs(values[0]), abs(values[-1])
    if may_vanish and first < 2 * u[0] and last > 3 * u[-1]:
        return "new"
    if may_vanish and last < 2 * u[-1] and first > 3 * u[0]:
        return "gone"
    return "up" if values[-1] > values[0] else "down"


def trend_of(values: Sequence[float], u: Sequence[float]) -> Any:
    """Rising where the last is larger than the first by more than twice their uncertainty, and no
    value is larger than a later one by more than that."""
    if len(values) < 3:
        return None
    v, squared = np.array(values), np.array(u) ** 2
    apart = (v[None, :] - v[:, None]) / np.sqrt(squared[None, :] + squared[:, None])
    later = apart[np.triu_indices(len(v), 1)]
    if apart[0, -1] > 2 and np.all(later > -2):
        return "rising"
    if apart[0, -1] < -2 and np.all(later < 2):
        return "falling"
    return "neither"
