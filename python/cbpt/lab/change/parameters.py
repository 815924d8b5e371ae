"""The numbers that changed, and those that did not.

changed_of    parameters of the groups that more likely changed than not
held_of       sizes and numbers that all levels share, and what each level says of them
differs       whether the numbers of an effect do, all together
unchanged_of  those that one value describes at all levels
by_itself     sizes that each level has if nothing is shared
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np

from cbpt.lab.change.counting import doubts_of
from cbpt.lab.change.parties import Levels
from cbpt.lab.change.posterior import OF_SPRINGS, Choice, Group, Weighed, groups_of, twin_of
from cbpt.lab.change.record import ByItself, Changed, Direction, Limit, Unchanged
from cbpt.lab.change.shared import Shared, fit_shared
from cbpt.lab.inference.estimates import unit_of
from cbpt.lab.model.own_loops import PLAY, play_allowed_rad
from cbpt.lab.model.priors import CLASSES
from cbpt.lab.selection.rules import RULES

_FRICTIONS = "friction_torque_Nm", "friction_radius_m"
"""Sizes that are a torque, or one for each newton of the preload."""


def changed_of(weighed: Weighed, comes_again: Sequence[bool]) -> list[Changed]:
    """Parameters of the groups that more likely changed than not, and of those of which one did:
    sizes, and shapes that moved. comes_again: of each level, whether what its fit leaves does."""
    rivals = {name: group for group in weighed.rivals for name in group}
    found = []
    for group in weighed.groups:
        along = weighed.along(group.effect)
        event = along or group.effect
        if weighed.changed(event) < RULES.undecided and event not in rivals:
            continue
        others = tuple(e for e in rivals.get(event, ()) if e != event)
        choice = weighed.best_with(group.effect)
        own = next(g for g in groups_of(choice.levels) if g.effect == group.effect)
        doubts = doubts_of(choice.levels, comes_again)
        told = []
        for place in own.unknowns:
            unknown = choice.levels.fits[0].unknowns[place]
            chance = weighed.changed(group.effect)
            changed = _of_place(choice, place, chance, doubts)
            changed = replace(changed, rivals=others, along=along or None)
            if unknown.size_of >= 0 or "." not in unknown.name or changed.moved:
                told.append(changed)
        found += [_of_effect(changed, told) for changed in told]
    return sorted(found, key=lambda c: -c.probability)


def _of_effect(c: Changed, every: Sequence[Changed]) -> Changed:
    """A number of an effect, of all of its: one of two sizes may appear or vanish, and the effect
    with it only where the other is not there either."""
    level = {"new": 0, "gone": -1}.get(c.direction)
    if level is None:
        return c
    for other in every:
        u = other.u[level]
        there = other.limits[level] is not None or abs(other.values[level]) > 2 * (u or 0.0)
        if other is not c and not other.is_shape and there:
            return replace(c, direction="up" if c.direction == "new" else "down")
    return c


def _of_place(choice: Choice, place: int, chance: float, doubts: Sequence[float]) -> Changed:
    """One parameter at every level; of its group. doubts: factors of the uncertainties."""
    levels = choice.levels
    unknown, name = levels.fits[0].unknowns[place], _name(levels, place)
    best = _in_terms_of(choice, unknown.name.partition(".")[0])
    levels_k = range(len(levels.fits))
    pairs = [_si(levels, best.value(k, place), place) for k in levels_k]
    values, fitted_u = (tuple(column) for column in zip(*pairs, strict=True))
    all_u = tuple(u * doubt for u, doubt in zip(fitted_u, doubts, strict=True))
    limits = tuple(_limit(choice, best, k, place) for k in levels_k)
    u = tuple(None if limit else known for known, limit in zip(all_u, limits, strict=True))
    may_vanish = unknown.size_of >= 0 and "." in unknown.name
    apart = [
        -d / np.sqrt(variance) / max(doubts) if variance > 0 else 0.0
        for d, variance in _differences(best, place)
    ]
    return Changed(
        effect=unknown.name.partition(".")[0],
        parameter=name,
        unit=unit_of(name),
        before=values[0],
        after=values[-1],
        u_before=u[0],
        u_after=u[-1],
        direction=_direction(values, fitted_u, limits, may_vanish),
        probability=chance,
        values=values,
        u=u,
        limits=limits,
        trend=trend_of(apart, len(values)),
        is_shape=_is_shape(levels, place),
        apart=float(max(map(abs, apart))),
    )


def _is_shape(levels: Levels, place: int) -> bool:
    """Of an effect; a number of the drive or the rig is neither size nor shape."""
    effect, _, name = levels.fits[0].unknowns[place].name.partition(".")
    return any(name == s.name for v in levels.variants if v.effect == effect for s in v.shapes)


def _in_terms_of(choice: Choice, effect: str) -> Shared:
    """The fit of a choice; where it stands for that of a twin, with what the instrument multiplies
    left to a number of an effect, which divides it: the stiffness, or a torque of friction."""
    fit, instrument, unknowns = choice.fit, choice.stands_for, choice.levels.fits[0].unknowns
    number = effect == twin_of(instrument)
    names = {effect} if number else {f"{effect}.{size}" for size in _FRICTIONS}
    if not instrument or not (number or instrument in OF_SPRINGS):
        return fit
    place = next((i for i, u in enumerate(unknowns) if u.name in names), None)
    if place is None:
        return fit
    at = next(i for i, u in enumerate(unknowns) if u.name == instrument)
    slots, count = fit.slots.copy(), len(fit.x)
    x, by = list(fit.x), [*np.eye(count)]
    low, high = (list(bound) for bound in fit.bounds)
    first = fit.slots[0]
    for row in slots[1:]:
        of, gain, ratio = row[place], row[at], fit.x[first[at]] / fit.x[row[at]]
        slope = np.zeros(count)
        slope[of] = ratio
        slope[gain] -= fit.x[of] * ratio / fit.x[gain]
        slope[first[at]] += fit.x[of] / fit.x[gain]
        row[place] = len(x)
        x.append(fit.x[of] * ratio)
        by.append(slope)
        low.append(fit.bounds[0][of] * ratio)
        high.append(fit.bounds[1][of] * ratio)
    covariance = np.array(by) @ fit.covariance @ np.array(by).T
    bounds = np.array(low), np.array(high)
    return replace(fit, slots=slots, x=np.array(x), covariance=covariance, bounds=bounds)


def _limit(choice: Choice, fit: Shared, level: int, place: int) -> Limit | None:
    """The limit that a value ends at. That an effect does nothing is no limit."""
    bound = fit.limit(level, place)
    if bound is None:
        return None
    levels = choice.levels
    unknown, model = levels.fits[0].unknowns[place], levels.parties[0].problem.model
    size, neutral = bound * unknown.unit, float(model.neutral[unknown.index])
    if not unknown.log and abs(size - neutral) <= 1e-6 * unknown.unit:
        return None
    if bound == fit.bounds[0][fit.slots[level, place]]:
        return "lower"
    if unknown.name == PLAY:
        allowed = min(play_allowed_rad(party.problem.campaign) for party in levels.parties)
        return "upper" if size < 0.999 * allowed else "own loops"
    return "upper"


@dataclass(frozen=True)
class Held:
    """A size or number that all levels share; SI."""

    number: Unchanged
    known: tuple[bool, ...]
    """Of each level, whether it determines the number by itself: by more than twice what it may be
    off there, as for an effect that is gone."""
    well_known: tuple[bool, ...]
    """The same by more than three times that, as for an effect that is there."""

    @property
    def not_shown(self) -> tuple[int, ...]:
        """The levels that say nothing of what another one shows."""
        return tuple(k for k, known in enumerate(self.known) if not known and any(self.well_known))


def held_of(weighed: Weighed) -> list[Held]:
    """What did not change in the best answer. How well the levels know it together says nothing of
    a change: one of them may not show it at all. So each has its own value here."""
    best = weighed.best
    groups = [g for g in groups_of(best.levels) if g.effect not in best.changed]
    return [held for held in (_held(best, group) for group in groups) if held is not None]


def _held(best: Choice, group: Group) -> Held | None:
    levels, fit, place = best.levels, best.fit, group.unknowns[0]
    separate = fit.separate | set(group.unknowns)
    free = fit_shared(levels.parties, levels.variants, separate, fit.points)
    if free is None:
        return None
    value, u = _si(levels, fit.value(0, place), place)
    unknown, slots = levels.fits[0].unknowns[place], free.slots[:, place]
    si = unknown.unit * (value if unknown.log else 1.0)
    # What the slopes say of a value is not all: far from it they may be others, and a value that is
    # far from the shared one, which the readings suit as well, is as uncertain.
    off = [
        abs(si) * float(np.hypot(free.x[s] - fit.x[place], np.sqrt(free.covariance[s, s])))
        for s in slots
    ]
    within = abs(si) * max(
        float(np.sqrt(d**2 + variance)) for d, variance in _differences(free, place)
    )
    known = tuple(abs(value) > 2 * o for o in off)
    own = _apart(levels, place)
    if own:
        within = max(within, float(np.ptp(own)))
        known = (min(map(abs, own)) > 2 * within,) * len(own)
    name = _name(levels, place)
    return Held(
        number=Unchanged(group.effect, name, unit_of(name), value, u, within),
        known=known,
        well_known=tuple(abs(value) > 3 * o for o in off),
    )


def _apart(levels: Levels, place: int) -> list[float]:
    """Values of the levels by themselves, SI, where they differ by more than their readings leave
    open and a new set-up may be why; else none. What may be the set-up may be a change too."""
    if all(party.set_up is None for party in levels.parties):
        return []
    found = [(fit.value(fit.unknowns[place]), fit.u(fit.unknowns[place])) for fit in levels.fits]
    differ = any(abs(v - w) > 2 * np.hypot(u, z) for (v, u), (w, z) in combinations(found, 2))
    return [value for value, _ in found] if differ else []


def differs(choice: Choice, effect: str) -> bool:
    """Whether the numbers of an effect differ between two levels, all together, by more than chance
    lets one do by twice its uncertainty: a size and a time constant may each be hardly known, and
    what they do together well."""
    from scipy.special import chdtrc

    group = next(g for g in groups_of(choice.levels) if g.effect == effect)
    fit = _in_terms_of(choice, effect)
    # Of a fit that stands for a twin's, the number has no values of its own but those.
    own = sorted(fit.separate & set(group.unknowns)) or group.unknowns
    chances = [
        float(chdtrc(len(off), off @ np.linalg.pinv(covariance) @ off))
        for off, covariance in fit.differences(own)
    ]
    return min(chances) < float(chdtrc(1, 2.0**2))


def _differences(fit: Shared, place: int) -> Iterator[tuple[float, float]]:
    """By which the values of any two levels differ, and the variance of that."""
    for off, covariance in fit.differences([place]):
        yield float(off[0]), max(float(covariance[0, 0]), 0.0)


def unchanged_of(weighed: Weighed, held: Sequence[Held]) -> list[Unchanged]:
    """Sizes and numbers that one value describes at all levels."""
    rivals = {name for group in weighed.rivals for name in group}
    return [
        h.number
        for h in held
        # What may have changed stands under `perhaps`.
        if weighed.changed(h.number.effect) <= RULES.likely
        and h.number.effect not in rivals
        and not h.not_shown
        and not _in_place_of_a_gain(weighed, h.number)
    ]


def _in_place_of_a_gain(weighed: Weighed, number: Unchanged) -> bool:
    """Whether a size of the reducer changed too, where the stiffness of all members did in place of
    a gain: of the angle, what is an angle; of the torque, what is one for each newton metre."""
    if CLASSES.get(number.effect) != "effect":
        return False
    of_angle = "rad" in number.unit
    # A curve is stated at a torque.
    of_torque = "N m" in number.unit or number.effect == "stiffness_curve"
    torque, angle = (weighed.stood_for(gain) for gain in ("torque_scale", "sensor_gain"))
    return (torque and of_torque) or (angle and of_angle)


def by_itself(levels: Levels, comes_again: Sequence[bool]) -> list[ByItself]:
    """The sizes of the effects as each level has them if nothing is shared."""
    doubts = doubts_of(levels, comes_again, alone=True)
    return [
        ByItself(
            effect=unknown.name.partition(".")[0],
            parameter=_name(levels, place),
            unit=unit_of(_name(levels, place)),
            values=tuple(fit.value(fit.unknowns[place]) for fit in levels.fits),
            u=tuple(
                doubt * fit.u(fit.unknowns[place])
                for fit, doubt in zip(levels.fits, doubts, strict=True)
            ),
        )
        for place, unknown in enumerate(levels.fits[0].unknowns)
        if unknown.size_of >= 0 and "." in unknown.name
    ]


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


def _direction(
    values: Sequence[float],
    u: Sequence[float],
    limits: Sequence[Limit | None],
    may_vanish: bool,
) -> Direction:
    """What ends at a limit of its range is there, however uncertain."""
    first, last = abs(values[0]), abs(values[-1])
    if may_vanish and limits[0] is None and first < 2 * u[0] and last > 3 * u[-1]:
        return "new"
    if may_vanish and limits[-1] is None and last < 2 * u[-1] and first > 3 * u[0]:
        return "gone"
    return "up" if values[-1] > values[0] else "down"


def trend_of(apart: Sequence[float], levels: int) -> Literal["rising", "falling", "neither"] | None:
    """Rising where the last is larger than the first by more than twice their uncertainty, and no
    value is larger than a later one by more than that. apart: by how much each later value is
    larger than each one before it, in uncertainties, in the order of `itertools.combinations`."""
    if levels < 3:
        return None
    later, whole = np.array(apart), apart[levels - 2]
    if whole > 2 and np.all(later > -2):
        return "rising"
    if whole < -2 and np.all(later < 2):
        return "falling"
    return "neither"
