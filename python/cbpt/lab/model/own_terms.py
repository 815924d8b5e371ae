"""Effects of the user's own among those of the library: which are to be fitted, and as what.

chosen        a list of ids and own effects, told apart
campaign_of   readings with the own effects that are to be fitted
variant_of    an own effect as the competition sees it: sizes, shapes, what is plausible

Sizes are the fewest parameters at whose value 0 the term vanishes; where several do, those that may
be 0 and stand first. The others are shapes. A parameter's `min` and `max` are its prior range: a
size is equally likely in the logarithm up to the larger of them, a shape over its range. Without
them a hundred times the start stands for the largest size, and a factor of 30 either way for a
shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.priors import Shape, Variant
from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]
Given = Sequence[str | OwnEffect]

COLUMNS = {
    "time_s": "time_s",
    "run_time_s": "time_s",
    "temperature_difference_K": "temperature_degC",
    "cycles_done": "cycle",
}
"""Columns of a table that variables come from, where they are no part of every table."""


@dataclass(frozen=True)
class _Limits:
    """What an own effect may have."""

    most_parameters: int = 8
    span: float = 1e-3
    """Least plausible size over the largest, where no least one is stated."""


_LIMITS = _Limits()


def chosen(
    case: Case | Drive, effects: str | OwnEffect | Given
) -> tuple[list[str], list[OwnEffect]]:
    """Ids in the order given, and the own effects among them: objects, or ids of the case's own."""
    listed = [effects] if isinstance(effects, (str, OwnEffect)) else list(effects)
    of_case = {own.id: own for own in case.own_effects} if isinstance(case, Case) else {}
    own: dict[str, OwnEffect] = {}
    ids: list[str] = []
    for effect in listed:
        found = of_case.get(effect) if isinstance(effect, str) else effect
        if found is not None and own.setdefault(found.id, found) is not found:
            raise InvalidInputError(
                f"effect {found.id}: two own effects have this id; rename one of them"
            )
        ids.append(found.id if found is not None else str(effect))
    return list(dict.fromkeys(ids)), list(own.values())


def campaign_of(case: Case | Drive, readings: Readings, own: Sequence[OwnEffect]) -> Campaign:
    """Readings, with own effects to be fitted; those of them that the case has are taken out of it.

    Raises `InvalidInputError` for one that cannot be fitted, `ReadingsError` where the table lacks
    a column that one depends on.
    """
    campaign = Campaign.of(case, readings)
    for effect in (*campaign.own.values(), *own):
        _stop_if_a_column_lacks(effect, readings)
    if not own:
        return campaign
    fitted = {effect.id: effect for effect in own}
    campaign = replace(
        campaign,
        own=campaign.own | fitted,
        effects=tuple(e for e in campaign.effects if e[0] not in fitted),
    )
    variants = []
    for effect in own:
        variants.append(variant_of(effect, campaign))
        # A function is known by what it has looked at.
        _stop_if_a_column_lacks(effect, readings)
    return replace(campaign, candidates=tuple(variants))


def _stop_if_a_column_lacks(effect: OwnEffect, readings: Readings) -> None:
    for variable, column in COLUMNS.items():
        if effect.uses(variable) and getattr(readings, column) is None:
            raise ReadingsError.of_table(
                readings.source, column, f"this column, because effect {effect.id} depends on it"
            )


def variant_of(effect: OwnEffect, campaign: Campaign) -> Variant:
    """Raises `InvalidInputError` where there is nothing to fit."""
    parameters = {name: (start, low, high) for name, _, start, low, high in effect.parameters}
    if not 0 < len(parameters) <= _LIMITS.most_parameters:
        raise InvalidInputError(
            f"effect {effect.id} has {len(parameters)} parameters; "
            f"from 1 to {_LIMITS.most_parameters} can be fitted"
        )
    sizes = _sizes(effect, campaign, parameters)
    spans = [_span(effect, name, *parameters[name]) for name in sizes]
    shapes, fixed = [], []
    count = sum(name not in sizes for name in parameters)
    for name, (start, low, high) in parameters.items():
        if name in sizes:
            continue
        if low is not None and low == high:
            fixed.append((name, low))
        else:
            shapes.append(_shape(effect, name, start, low, high, max(5 - count, 2)))
    return Variant(
        effect.id,
        sizes,
        *spans[0],
        signed=any(low is None or low < 0 for _, low, _ in (parameters[name] for name in sizes)),
        shapes=tuple(shapes),
        fixed=tuple(fixed),
        ratios=tuple(high / spans[0][1] for _, high in spans) if len(spans) > 1 else (),
        units=tuple((name, unit) for name, unit, *_ in effect.parameters),
    )


Parameters = dict[str, tuple[float, float | None, float | None]]


def _sizes(effect: OwnEffect, campaign: Campaign, parameters: Parameters) -> tuple[str, ...]:
    """The fewest parameters that, at 0, leave the angle as it is without the effect."""
    bare = Assembled(campaign, []).at(np.zeros(0)).angle_arcsec
    model = Assembled(campaign, [effect.id])
    solved = np.isfinite(bare)

    def vanishes(at_zero: Sequence[str]) -> bool:
        values = np.array([0.0 if n in at_zero else _off_zero(*p) for n, p in parameters.items()])
        angle = model.at(values).angle_arcsec
        return bool(np.allclose(angle[solved], bare[solved], rtol=1e-9, atol=1e-9))

    if vanishes(()):
        raise InvalidInputError(
            f"effect {effect.id} does not change the computed angle of any reading at the start "
            "values of its parameters; choose other start values (not zero), or check that the "
            "readings vary what it depends on"
        )
    for count in range(1, len(parameters) + 1):
        for names in sorted(combinations(parameters, count), key=lambda n: _shifted(n, parameters)):
            if vanishes(names):
                return names
    raise InvalidInputError(
        f"effect {effect.id} must have no influence when one (or several) of its parameters is 0; "
        "multiply the term by a parameter"
    )


def _shifted(names: Sequence[str], parameters: Parameters) -> int:
    """How many of some parameters may not be 0 by their own range."""
    bounds = (parameters[name][1:] for name in names)
    return sum((low or 0) > 0 or (high or 0) < 0 for low, high in bounds)


def _off_zero(start: float, low: float | None, high: float | None) -> float:
    return start or high or low or 1.0


def _span(
    effect: OwnEffect, name: str, start: float, low: float | None, high: float | None
) -> tuple[float, float]:
    """Least and largest plausible size, both above 0."""
    bounds = [abs(b) for b in (low, high) if b]
    largest = max(bounds, default=100 * abs(start))
    if not largest:
        raise InvalidInputError(
            f"effect {effect.id}: parameter {name} starts at 0 and has no range; state its max"
        )
    least = low if low and low > 0 else -high if high and high < 0 else _LIMITS.span * largest
    return min(least, 0.1 * abs(start) or least, 0.5 * largest), largest


def _shape(
    effect: OwnEffect, name: str, start: float, low: float | None, high: float | None, points: int
) -> Shape:
    if start == 0 and (low is None or high is None):
        raise InvalidInputError(
            f"effect {effect.id}: parameter {name} starts at 0 and has no range; state its min "
            "and max"
        )
    ends = sorted((start / 30, start * 30))
    first, last = ends[0] if low is None else low, ends[1] if high is None else high
    log = first > 0 and last > 10 * first
    inside = np.linspace(0, 1, points + 1)[1:-1]
    spread = first * (last / first) ** inside if log else first + (last - first) * inside
    grid = tuple(sorted({float(x) for x in (start, *spread)}))
    return Shape(name, float(first), float(last), grid, log)
