"""Which numbers changed, from the evidence of sharing them or not.

    Group       what changes together: the parameters of an effect, or one number
    Choice      some effects at every level, and which groups changed
    Weighed     choices with their probabilities
    choices_of  all that are searched of one set of effects
    weigh       searches the choices: none, each group, and further ones while that gains

A choice is a set of groups that have values of their own at each level. Prior odds say how often
such a thing changes between two campaigns on one reducer; they are the same for every table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cbpt.lab.change.parties import Levels
from cbpt.lab.change.progress import part_of, untold
from cbpt.lab.change.shared import Shared, fit_shared
from cbpt.lab.model.priors import ODDS as THERE
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.selection.model_comparison import Progress

ODDS = {
    "": 0.1,
    "contact_stiffness": 0.03,
    "contact_angle": 0.01,
    "torque_scale": 0.003,
    "preload_scale": 0.01,
    "sensor_gain": 0.003,
}
"""Prior odds that a group changes against that it does not; "" stands for an effect. The
instruments are the same before and after, so their gains hardly change."""


@dataclass(frozen=True)
class _Effort:
    """How far is searched."""

    together: int = 4
    """Groups that change together at most."""
    leaders: int = 3
    """Choices whose values all others are tried at."""


_EFFORT = _Effort()


@dataclass(frozen=True)
class Group:
    """What changes together; `unknowns`: places among those of the levels."""

    effect: str
    unknowns: tuple[int, ...]

    @property
    def log_odds(self) -> float:
        """Prior."""
        return float(np.log(ODDS.get(self.effect, ODDS[""])))


@dataclass(frozen=True, eq=False)
class Choice:
    """Some effects at every level, and which of them changed."""

    changed: frozenset[str]
    levels: Levels
    fit: Shared
    log_odds: float
    probability: float = 0.0


@dataclass(frozen=True, eq=False)
class Weighed:
    """Choices, the most probable first."""

    groups: tuple[Group, ...]
    """Of all choices; `Group.unknowns` are those of the first that has the group."""
    choices: tuple[Choice, ...]

    @property
    def best(self) -> Choice:
        """The most probable one."""
        return self.choices[0]

    def changed(self, effect: str) -> float:
        """Probability that it changed."""
        return float(sum(c.probability for c in self.choices if effect in c.changed))

    @property
    def something(self) -> float:
        """Probability that anything changed."""
        return float(sum(c.probability for c in self.choices if c.changed))

    def best_with(self, effect: str) -> Choice:
        """The most probable one in which it changed."""
        return next(c for c in self.choices if effect in c.changed)


def groups_of(levels: Levels) -> tuple[Group, ...]:
    """One for each effect, and one for each number of drive and rig."""
    found: dict[str, list[int]] = {}
    for i, unknown in enumerate(levels.fits[0].unknowns):
        effect, _, name = unknown.name.partition(".")
        if name or effect in PRIORS:
            found.setdefault(effect, []).append(i)
    return tuple(Group(effect, tuple(places)) for effect, places in found.items())


def weigh(candidates: Sequence[Levels], tell: Progress = untold) -> Weighed | None:
    """All choices that matter, over all sets of effects; None where the model has no solution with
    all numbers shared."""
    found: list[Choice] = []
    for k, levels in enumerate(candidates):
        begin, end = (i / len(candidates) for i in (k, k + 1))
        found += choices_of(levels, part_of(tell, begin, end))
    if not found:
        return None
    logs = np.array([choice.log_odds for choice in found])
    chances = np.exp(logs - logs.max())
    chances /= chances.sum()
    order = np.argsort(-chances, kind="stable")
    choices = tuple(replace(found[i], probability=float(chances[i])) for i in order)
    groups: dict[str, Group] = {}
    for choice in choices:
        for group in groups_of(choice.levels):
            groups.setdefault(group.effect, group)
    return Weighed(tuple(groups.values()), choices)


def choices_of(levels: Levels, tell: Progress = untold) -> list[Choice]:
    """None, each group, and further ones while that gains; then all groups, and fewer while that
    gains: two that changed together may look no better than none as long as one of them is shared.
    """
    groups = {g.effect: g for g in groups_of(levels)}
    there = sum(float(np.log(THERE.get(v.effect, THERE[""]))) for v in levels.variants)
    scored: dict[frozenset[str], tuple[Shared, float]] = {}

    def score(names: frozenset[str], of: frozenset[str] | None = None) -> float:
        if names not in scored:
            places = frozenset(i for name in names for i in groups[name].unknowns)
            further = [scored[of][0]] if of is not None else []
            found = _fitted(levels, places, _nested(names, scored), further)
            if found is None:
                return -np.inf
            prior = sum(groups[name].log_odds for name in names)
            scored[names] = found, found.log_evidence + prior + there
        return scored[names][1]

    best: frozenset[str] = frozenset()
    if score(best) == -np.inf:
        return []
    for number in range(most := min(_EFFORT.together, len(groups))):
        tell("what changed", 0.5 * number / most)
        top = max((best | {name} for name in groups.keys() - best), key=score, default=best)
        less = [top - {name} for name in top if len(top) > 1]
        top = max([top, *less], key=score)
        if score(top) < scored[best][1]:
            break
        best = top
    best = frozenset(groups)
    if score(best) > -np.inf:
        while best:
            tell("what did not change", 0.9 - 0.4 * len(best) / len(groups))
            fewer = max((best - {name} for name in best), key=lambda names: score(names, best))
            if score(fewer) < scored[best][1]:
                break
            best = fewer
    tell("each choice from the best values", 0.9)
    _settled(levels, scored)
    return [Choice(names, levels, fit, odds) for names, (fit, odds) in scored.items()]


def _settled(levels: Levels, scored: dict[frozenset[str], tuple[Shared, float]]) -> None:
    """Choices fitted again from each other's values, the best first: what fits well with values of
    its own at each level may do so with one for all, and a search that stopped short of it would
    count as a change. What a choice holds fits no better than the choice."""
    leaders = sorted(scored, key=lambda names: -scored[names][1])[: _EFFORT.leaders]
    for names in sorted(scored, key=len):
        for other in leaders:
            (fit, odds), start = scored[names], scored[other][0]
            if not (names < other or (other < names and fit.misfit > start.misfit + 0.1)):
                continue
            again = fit_shared(levels.parties, levels.variants, fit.separate, start.points)
            if again is not None and again.log_evidence > fit.log_evidence:
                scored[names] = again, odds + again.log_evidence - fit.log_evidence


def _fitted(
    levels: Levels, places: frozenset[int], inside: Sequence[Shared], further: Sequence[Shared]
) -> Shared | None:
    """A choice holds the one inside it, so it fits at least as well. further: choices from whose
    values it is searched too."""
    found = fit_shared(levels.parties, levels.variants, places)
    for other in further:
        again = fit_shared(levels.parties, levels.variants, places, other.points)
        if again is not None and (found is None or again.log_evidence > found.log_evidence):
            found = again
    for other in inside:
        if found is None or found.misfit > other.misfit + 0.1:
            again = fit_shared(levels.parties, levels.variants, places, other.points)
            if again is not None and (found is None or again.misfit < found.misfit):
                found = again
    return found


def _nested(
    names: frozenset[str], scored: dict[frozenset[str], tuple[Shared, float]]
) -> Sequence[Shared]:
    """The best fit of a choice that this one holds."""
    inside = [value for other, value in scored.items() if other < names]
    return [max(inside, key=lambda value: value[1])[0]] if inside else []
