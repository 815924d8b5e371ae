"""Which numbers changed, from the evidence of sharing them or not.

    Group       what changes together: the parameters of an effect, or one number
    Choice      some effects at every level, and which groups changed
    Weighed     choices with their probabilities
    choices_of  all that matter of one set of effects: none, each group, and further ones while that
                gains
    weigh       gives them their probabilities

A choice is a set of groups that have values of their own at each level. Prior odds say how often
such a thing changes between two campaigns on one reducer; they are the same for every table.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cbpt.lab.change.parties import Levels
from cbpt.lab.change.progress import untold
from cbpt.lab.change.shared import Shared, fit_shared
from cbpt.lab.model.priors import CLASSES, PRIORS, TWINS
from cbpt.lab.model.priors import ODDS as THERE
from cbpt.lab.selection.model_comparison import Progress
from cbpt.lab.selection.posterior import Posterior, spoken_of
from cbpt.lab.selection.rules import RULES

ODDS = {
    "": 0.1,
    "contact_stiffness": 0.03,
    "contact_angle": 0.01,
    **{effect: 0.01 for effect, kind in CLASSES.items() if kind == "rig"},
}
"""Prior odds that a group changes against that it does not; "" stands for an effect of the reducer.
The instruments are the same before and after, so their errors hardly change, one no more than
another."""


_TWINS = {
    one: others[0]
    for one, others in TWINS.items()
    if len(others) == 1 and CLASSES[one] == "rig" and TWINS[others[0]] == [one]
}
"""Instruments that have one twin, a number of the drive that has no other."""


@dataclass(frozen=True)
class _Effort:
    """How far is searched."""

    together: int = 4
    """Groups that change together at most."""
    leaders: int = 3
    """Choices whose values all others are tried at."""
    room: float = 12.0
    """In log odds: what is that far below the best has no say."""


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
    stands_for: bool = False
    """Whether the fit is that of a twin, which the readings follow in the same way."""


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
        return self._together(c for c in self.choices if effect in c.changed)

    def of_any(self, effects: Collection[str]) -> float:
        """Probability that one or more of some effects changed."""
        return self._together(c for c in self.choices if not c.changed.isdisjoint(effects))

    @property
    def something(self) -> float:
        """Probability that anything changed."""
        return self._together(c for c in self.choices if c.changed)

    @staticmethod
    def _together(choices: Iterable[Choice]) -> float:
        """Of choices of which one holds; rounding may have made it more than 1."""
        return min(float(sum(c.probability for c in choices)), 1.0)

    @property
    def likely(self) -> tuple[str, ...]:
        """What may have changed."""
        return tuple(g.effect for g in self.groups if self.changed(g.effect) > RULES.likely)

    @property
    def rivals(self) -> tuple[tuple[str, ...], ...]:
        """Groups of which one changed, and the readings do not tell which: as a diagnosis has them,
        by the same rules."""
        sets: dict[tuple[str, ...], float] = {}
        for c in self.choices:
            names = tuple(sorted(c.changed))
            sets[names] = sets.get(names, 0.0) + c.probability
        return spoken_of(Posterior(sets), RULES).rivals

    def best_with(self, effect: str) -> Choice:
        """The most probable one in which it changed; of a twin, the same with its own values."""
        found = [c for c in self.choices if effect in c.changed]
        own = [c for c in found if not c.stands_for]
        same = [c for c in own if c.changed == found[0].changed]
        return next(iter([*same, *own, *found]))


def groups_of(levels: Levels) -> tuple[Group, ...]:
    """One for each effect, and one for each number of drive and rig."""
    found: dict[str, list[int]] = {}
    for i, unknown in enumerate(levels.fits[0].unknowns):
        effect, _, name = unknown.name.partition(".")
        if name or effect in PRIORS:
            found.setdefault(effect, []).append(i)
    return tuple(Group(effect, tuple(places)) for effect, places in found.items())


def weigh(found: Sequence[Choice]) -> Weighed | None:
    """The choices of all sets of effects with their probabilities; None where there is none: the
    model has no solution with all numbers shared."""
    if not found:
        return None
    found = [form for choice in found for form in _forms(choice)]
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


def _forms(choice: Choice) -> Iterator[Choice]:
    """The choice; where an instrument changed that has a twin, that in its place too.

    A gain of the angle multiplies the whole curve. So does a stiffness, where what is fitted beside
    it comes from the same members, and a stiffness of one member alone does not: one form is as
    likely as the other.
    """
    known = {group.effect for group in groups_of(choice.levels)}
    for instrument, number in _TWINS.items():
        if {instrument, number} <= known and len({instrument, number} & choice.changed) == 1:
            form = choice.log_odds - float(np.log(2))
            if number in choice.changed:
                choice = replace(choice, log_odds=form)
            else:
                changed = (choice.changed - {instrument}) | {number}
                more = float(np.log(ODDS[number] / ODDS[instrument]))
                yield replace(choice, changed=changed, log_odds=form + more, stands_for=True)
    yield choice


def choices_of(levels: Levels, tell: Progress = untold) -> list[Choice]:
    """Those that the levels state; else none, each group, and further ones while that gains; then
    all groups, and fewer while that gains: two that changed together may look no better than none
    as long as one of them is shared.
    """
    search = _Search(levels)
    if levels.choices:
        for names in sorted(levels.choices, key=len):
            search.score(names)
    elif search.score(frozenset()) > -np.inf:
        search.more(tell)
        search.fewer(tell)
    tell("each choice from the best values", 0.9)
    search.settle()
    found = [Choice(names, levels, fit, odds) for names, (fit, odds) in search.scored.items()]
    return [*found, *search.gains()]


class _Search:
    """The choices of one set of effects that were fitted so far, with their log odds."""

    def __init__(self, levels: Levels) -> None:
        self.levels = levels
        self.groups = {g.effect: g for g in groups_of(levels)}
        self.there = sum(float(np.log(THERE.get(v.effect, THERE[""]))) for v in levels.variants)
        self.scored: dict[frozenset[str], tuple[Shared, float]] = {}

    def score(self, names: frozenset[str], of: frozenset[str] | None = None) -> float:
        """Log odds of a choice; of: another one, from whose values it is searched too."""
        scored = self.scored
        if names not in scored:
            places = self._places(names)
            further = [scored[of][0]] if of is not None else []
            found = _fitted(self.levels, places, _nested(names, scored), further)
            if found is None:
                return -np.inf
            prior = sum(self.groups[name].log_odds for name in names)
            scored[names] = found, found.log_evidence + prior + self.there
        return scored[names][1]

    def _places(self, names: frozenset[str]) -> frozenset[int]:
        """The unknowns that have values of their own where some groups changed."""
        own = {i for name in names for i in self.groups[name].unknowns}
        return frozenset(own | {i for name, i in self.levels.alongside if name in names})

    def more(self, tell: Progress) -> None:
        """From none, one group after the other."""
        best: frozenset[str] = frozenset()
        most = min(_EFFORT.together, len(self.groups))
        for number in range(most):
            tell("what changed", 0.5 * number / most)
            further = (best | {name} for name in self.groups.keys() - best)
            top = max(further, key=self.score, default=best)
            less = [top - {name} for name in top if len(top) > 1]
            top = max([top, *less], key=self.score)
            if self.score(top) < self.scored[best][1]:
                break
            best = top

    def fewer(self, tell: Progress) -> None:
        """From all, one less after the other."""
        best = frozenset(self.groups)
        if self.score(best) == -np.inf:
            return
        while best:
            tell("what did not change", 0.9 - 0.4 * len(best) / len(self.groups))
            rest = (best - {name} for name in best)
            fewer = max(rest, key=lambda names: self.score(names, best))
            if self.score(fewer) < self.scored[best][1]:
                break
            best = fewer

    def gains(self) -> Iterator[Choice]:
        """The best choices with a gain in place of a number of the drive, and that gain alone: by
        whatever an instrument may change."""
        gains = [g for g in self.groups if g in PRIORS and CLASSES[g] == "rig"]
        numbers = {g for g in self.groups if g in PRIORS} - set(gains)
        leaders = sorted(self.scored, key=lambda names: -self.scored[names][1])
        swapped = {
            frozenset(names - numbers | {gain})
            for names in leaders[: _EFFORT.leaders]
            if names & numbers
            for gain in gains
        }
        alone = {frozenset({name for name in names if name in gains}) for names in swapped}
        for names in sorted(swapped | alone, key=sorted):
            loose = frozenset(i for name in names & set(gains) for i in self.groups[name].unknowns)
            places = self._places(names)
            of = self.levels
            fit = fit_shared(of.parties, of.variants, places, loose=loose)
            if fit is not None:
                prior = sum(self.groups[name].log_odds for name in names)
                yield Choice(names, of, fit, fit.log_evidence + prior + self.there)

    def settle(self) -> None:
        """Choices fitted again from each other's values."""
        _settled(self.levels, self.scored)


def _settled(levels: Levels, scored: dict[frozenset[str], tuple[Shared, float]]) -> None:
    """Choices fitted again from each other's values, the best first: what fits well with values of
    its own at each level may do so with one for all, and a search that stopped short of it would
    count as a change. What a choice holds fits no better than the choice."""
    leaders = sorted(scored, key=lambda names: -scored[names][1])[: _EFFORT.leaders]
    least = max((odds for _, odds in scored.values()), default=0.0) - _EFFORT.room
    for names in sorted(scored, key=len):
        for other in leaders:
            (fit, odds), start = scored[names], scored[other][0]
            if not (names < other or (other < names and fit.misfit > start.misfit + 0.1)):
                continue
            if names < other and odds + 0.5 * (fit.misfit - start.misfit) < least:
                continue  # not even if it fitted as well as what holds it
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
        if found is not None and found.misfit <= other.misfit + 0.1:
            continue  # it is held by the other, and fits no better
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
