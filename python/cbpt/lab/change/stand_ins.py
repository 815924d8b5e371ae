"""Other effects in place of what seems to have changed.

with_stand_ins  sets of effects with one that may have changed instead
plausible       whether its size in a choice is

A diagnosis of each level names what that level needs, and effects that are named may not be all
that there are. What is there at one level alone, or what the model lacks, may be taken for a change
of what every level has: an error of an instrument; friction or damping by the rate, which look like
a lag; a joint that takes the whole torque, of a fixture. So each is fitted beside the effects of
the best answer, and in place of each that changed in it; for a torsion spring so is anything that a
diagnosis proposes (for a ball drive that is far more, each of which costs as many fits). One that
all levels share may do the same where what it does differs with how a level is loaded, as a lag
does with the rate: then nothing has changed.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from cbpt.lab.change.parties import (
    Levels,
    forms_of,
    joint_in_series,
    proposed_for_springs,
    with_engagement,
    with_form,
)
from cbpt.lab.change.posterior import Choice, Weighed
from cbpt.lab.change.progress import untold
from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.hypothesis import Unknown, places_of_sizes
from cbpt.lab.model.priors import CLASSES, PRIORS, Variant
from cbpt.lab.selection.competition import Progress
from cbpt.lab.selection.rules import RULES

_INSTRUMENTS = {
    *(effect for effect, kind in CLASSES.items() if kind == "rig" and effect != "run_offset"),
    *("rate_friction", "damping"),
}
"""Errors of instruments (zeros, lags, curves, drifts), and what looks like a lag."""


def with_stand_ins(
    weighed: Weighed, named: Collection[str] = (), tell: Progress = untold
) -> list[Levels]:
    """Sets of effects in which one more may have changed in place of what most probably did; those
    that follow the levels by far worse are left. named: effects that stay."""
    best = next(choice for choice in weighed.choices if choice.changed)
    have = [v.effect for v in best.levels.variants]
    tried = _INSTRUMENTS | set(proposed_for_springs(best.levels))
    forms = forms_of(best.levels, sorted(tried - PRIORS.keys() - set(have)))
    places = (None, *(e for e in have if e in best.changed and e not in named))
    sets = list(product(forms, places))

    def offered(number: int, form: Variant, place: str | None) -> list[Levels]:
        tell(f"{form.effect} in its place", number / len(sets))
        return _offered(best, with_form(best.levels, form, place), form)

    works = [partial(offered, number, *one) for number, one in enumerate(sets)]
    found = side_by_side(best.levels.parties[0].problem.campaign, works)
    return [*(levels for one in found for levels in one), *_with_joint(best, places)]


def _offered(best: Choice, levels: Levels | None, form: Variant) -> list[Levels]:
    """The levels with what may have changed of them, unless they are implausible or far worse."""
    if levels is None or not _plausible(levels, form) or not _as_good(levels, best.levels):
        return []
    return [replace(levels, choices=tuple(_choices(best, levels, form.effect)))]


def _with_joint(best: Choice, places: Sequence[str | None]) -> list[Levels]:
    """A joint in series that changed in place of what most probably did. Its angle is no part of
    what friction keeps, so beside friction a stiffness and the friction seem to have changed both;
    without it no reading tells it from a stiffness, and none is offered."""
    joint, have = joint_in_series(best.levels), {v.effect: v for v in best.levels.variants}
    if joint is None or "friction_hysteresis" not in have:
        return []
    if joint.effect in have:
        levels = with_form(best.levels, have[joint.effect], joint.effect)
        choices = () if levels is None else tuple(_choices(best, levels, joint.effect))
        found = [] if levels is None else [replace(levels, choices=choices)]
    else:
        sets = (with_form(best.levels, joint, place) for place in places)
        found = [one for levels in sets for one in _offered(best, levels, joint)]
    return [with_engagement(levels, joint.effect) for levels in found]


def _as_good(levels: Levels, other: Levels) -> bool:
    """Whether one set of effects is no less probable at the levels than another, but for what an
    effect that a level does not need takes away."""
    found, before = (sum(fit.log_evidence for fit in one.fits) for one in (levels, other))
    return found > before - 2 * RULES.log_rival_odds * len(levels.fits)


def _plausible(levels: Levels, form: Variant) -> bool:
    """Whether no level needs an implausible size."""
    most = _most(form)
    return all(
        abs(fit.value(u)) <= high
        for fit in levels.fits
        for u, high in zip(_sizes(fit, form), most, strict=True)
    )


def _sizes(fit: Fit, form: Variant) -> list[Unknown]:
    own = [u for u in fit.unknowns if u.name.startswith(form.effect + ".")]
    return own[: len(form.sizes)]


def _most(form: Variant) -> list[float]:
    """The largest plausible sizes."""
    return [form.high * ratio for ratio in form.ratios or (1.0,) * len(form.sizes)]


def plausible(choice: Choice) -> bool:
    """Whether the last effect of a choice, which stands in for another, is of a plausible size at
    every level."""
    form, unknowns = choice.levels.variants[-1], choice.levels.fits[0].unknowns
    places = places_of_sizes(choice.levels.variants, unknowns)[-1]
    return all(
        abs(choice.fit.value(level, place)[0] * unknowns[place].unit) <= high
        for level in range(len(choice.levels.fits))
        for place, high in zip(places, _most(form), strict=True)
    )


def _choices(best: Choice, levels: Levels, other: str) -> Sequence[frozenset[str]]:
    """What may have changed: nothing, or all but one of what else did, with another effect that all
    levels share; the other, it and what else changed, it in place of each of that."""
    possible = {v.effect for v in levels.variants} | PRIORS.keys()
    changed = best.changed & possible
    fewer = [frozenset[str](), *(changed - {effect} for effect in sorted(changed))]
    one = frozenset({other})
    return list(dict.fromkeys([*fewer, *(names | one for names in (*fewer, changed))]))
