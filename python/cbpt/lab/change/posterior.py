"""Which numbers changed, from the evidence of sharing them or not.

    Group       what changes together: the parameters of an effect, or one number
    Choice      some effects at every level, and which groups changed
    Weighed     choices with their probabilities
    in_reach    the sets of effects that may hold a choice as probable as the best
    Search      of one set of effects: none, each group, and further ones while that gains
    choices_of  all that it finds
    weigh       gives them their probabilities

A choice is a set of groups that have values of their own at each level, each by its sizes alone or
with its shapes: a friction that rises by some factor is one number more, and not three. Prior odds
say how often such a thing changes between two campaigns on one reducer; they are the same for every
table.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cbpt.lab.change.parties import Levels
from cbpt.lab.change.progress import untold
from cbpt.lab.change.shared import Shared, Until, fit_shared, foreseen
from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.model.priors import CLASSES, FRICTIONS, PRIORS, TWINS
from cbpt.lab.model.priors import ODDS as THERE
from cbpt.lab.selection.competition import Progress
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

OF_SPRINGS = {"torque_scale": "contact_stiffness"}
"""The same of a torsion spring, with its frictions: what multiplies every torque at an angle is the
gain of the torque, or what all of them share."""


@dataclass(frozen=True)
class _Effort:
    """How far is searched."""

    together: int = 4
    """Groups that change together at most."""
    leaders: int = 3
    """Choices whose values all others are tried at."""
    room: float = 12.0
    """In log odds: what is that far below the best has no say."""
    far: float = 120.0
    """In log odds: what is that far below the best is not searched to its end. Ten times `room`, as
    readings may count for less in the end, and fits of whole sets may have stopped short of it: 20
    times less, and it is still 6 below."""


_EFFORT = _Effort()


@dataclass(frozen=True)
class Group:
    """What changes together: the numbers of an effect; its sizes may change and its shapes not."""

    effect: str
    unknowns: tuple[int, ...]
    """Their places among the unknowns of the levels."""
    sizes: tuple[int, ...]
    """Those of them that are no shapes."""

    @property
    def forms(self) -> tuple[frozenset[int], ...]:
        """What has values of its own at each level: the sizes alone, and all."""
        return tuple(dict.fromkeys((frozenset(self.sizes), frozenset(self.unknowns))))

    @property
    def log_odds(self) -> float:
        """Prior of each form; one is as likely as the other."""
        return float(np.log(ODDS.get(self.effect, ODDS[""]) / len(self.forms)))


@dataclass(frozen=True, eq=False)
class Choice:
    """Some effects at every level, and which of them changed."""

    changed: frozenset[str]
    levels: Levels
    fit: Shared
    log_odds: float
    probability: float = 0.0
    stands_for: str = ""
    """The instrument whose fit it is, where that stands for the same of its twin, which the
    readings follow in the same way."""
    along: frozenset[str] = frozenset()
    """What then changed by the same share as the twin, in one event: frictions with a stiffness."""
    loose: frozenset[int] = frozenset()
    """Places of gains that change by whatever an instrument may."""

    def places_of(self, effect: str) -> tuple[int, ...]:
        """Of the numbers of an effect; of one that changed by what an instrument has in its place,
        of the instrument's."""
        places = {group.effect: group.unknowns for group in groups_of(self.levels)}
        own = places[effect]
        apart = effect in self.changed and self.stands_for and self.fit.separate.isdisjoint(own)
        return places[self.stands_for] if apart else own

    def own_places(self, effect: str) -> frozenset[int]:
        """Those of them that have a value for each level."""
        return self.fit.separate.intersection(self.places_of(effect))

    def beside(self, effect: str) -> frozenset[int]:
        """Places of what else has a value for each level where this effect keeps one."""
        return Search(self.levels).alongside(self.fit.separate - self.own_places(effect))


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

    def along(self, effect: str) -> str:
        """The number with which a friction changed in one event, in the most probable choice where
        that did; empty where it rather changed by itself."""
        together = [c for c in self.choices if effect in c.along]
        if not self._together(together) > 0.5 * self.changed(effect):
            return ""
        number = twin_of(together[0].stands_for)
        return number if effect in self.best_with(number).along else ""

    def stood_for(self, instrument: str) -> bool:
        """Whether a number may have changed in place of an instrument."""
        by = self._together(c for c in self.choices if c.stands_for == instrument)
        return by > RULES.likely

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
            names = tuple(sorted(c.changed - c.along))
            sets[names] = sets.get(names, 0.0) + c.probability
        return spoken_of(Posterior(sets), RULES).rivals

    def near(self, d: float) -> tuple[Choice, ...]:
        """Those that have a say where the readings count d times less."""
        least = self.best.log_odds - _EFFORT.room * d
        return tuple(choice for choice in self.choices if choice.log_odds > least)

    def best_with(self, effect: str) -> Choice:
        """The most probable one in which it changed."""
        return next(c for c in self.choices if effect in c.changed)


def groups_of(levels: Levels) -> tuple[Group, ...]:
    """One for each effect, and one for each number of drive and rig."""
    found: dict[str, list[int]] = {}
    unknowns = levels.fits[0].unknowns
    for i, unknown in enumerate(unknowns):
        effect, _, name = unknown.name.partition(".")
        if name or effect in PRIORS:
            found.setdefault(effect, []).append(i)
    groups = []
    for effect, places in found.items():
        sizes = [i for i in places if unknowns[i].size_of >= 0]
        groups.append(Group(effect, tuple(places), tuple(sizes or places)))
    return tuple(groups)


def weigh(found: Sequence[Choice]) -> Weighed | None:
    """The choices of all sets of effects with their probabilities; None where there is none: the
    model has no solution with all numbers shared."""
    if not found:
        return None
    return of_odds([form for choice in found for form in _forms(choice)])


def of_odds(found: Sequence[Choice]) -> Weighed:
    """Choices with the probabilities that their log odds give them."""
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
    likely as the other. A gain of the torque multiplies every torque: of a torsion spring, those of
    its curve at each angle, as another modulus does, and those of friction. What made both fall by
    one share, as warmth may, is one event, and no less likely than a stiffness alone.
    """
    known, changed = {group.effect for group in groups_of(choice.levels)}, choice.changed
    is_spring = choice.levels.parties[0].problem.campaign.drive.kind == "torsion_spring"
    twins = {**_TWINS, **(OF_SPRINGS if is_spring else {})}
    twins = {one: number for one, number in twins.items() if {one, number} <= known}

    def forms(number: str, beside: frozenset[str]) -> float:
        """Log of how many forms a change of a number has beside others."""
        gains = [one for one, other in twins.items() if other == number and one not in beside]
        return float(np.log(1 + len(gains)))

    for instrument, number in twins.items():
        if instrument in changed and number not in changed:
            others = changed - {instrument}
            odds = choice.log_odds + float(np.log(ODDS[number] / ODDS[instrument]))
            along = FRICTIONS & known - changed if instrument in OF_SPRINGS else frozenset[str]()
            twin = replace(choice, log_odds=odds - forms(number, others), stands_for=instrument)
            yield replace(twin, changed=others | {number} | along, along=along)
    fewer = sum(forms(number, changed) for number in set(twins.values()) & changed)
    yield replace(choice, log_odds=choice.log_odds - fewer)


def twin_of(instrument: str) -> str:
    """The number of the drive that has its place; empty where there is none."""
    return _TWINS.get(instrument, OF_SPRINGS.get(instrument, ""))


def choices_of(levels: Levels, tell: Progress = untold) -> list[Choice]:
    """Those that the levels state; else none, each group, and further ones while that gains; then
    all groups, and fewer while that gains: two that changed together may look no better than none
    as long as one of them is shared."""
    return Search(levels).choices(tell)


def in_reach(sets: Sequence[Levels]) -> list[Search]:
    """The searches of those of several sets of effects of which a choice may be as probable as the
    best one.

    Each is fitted with all numbers shared and with none. No choice follows the readings better than
    the latter, what is stated of its numbers left aside, and the volume of the prior takes least
    with the former.
    """
    searches = [Search(levels) for levels in sets]
    if len(searches) < 2:
        return searches
    ends = side_by_side(sets[0].parties[0].problem.campaign, [one.ends for one in searches])
    best = max(max(odds) for _, *odds in ends)
    return [s for s, (most, *_) in zip(searches, ends, strict=True) if most >= best - _EFFORT.far]


class Search:
    """The choices of one set of effects that were fitted so far, with their log odds, by the places
    of the unknowns that have values of their own at each level."""

    def __init__(self, levels: Levels, beside: Choice | None = None) -> None:
        """beside: a choice of another set of effects; stated ones far below it are not searched to
        their end."""
        self.levels, self.groups = levels, groups_of(levels)
        self.known = -np.inf if beside is None or not levels.choices else beside.log_odds
        """Log odds of that."""
        self.there = sum(float(np.log(THERE.get(v.effect, THERE[""]))) for v in levels.variants)
        self.scored: dict[frozenset[int], tuple[Shared, float]] = {}
        self.asked: dict[frozenset[int], float] = {}
        """Log odds from where on each of them was searched to its end."""

    def choices(self, tell: Progress = untold) -> list[Choice]:
        """All that matter."""
        if self.levels.choices:
            self.stated()
        elif self.score(frozenset()) > -np.inf:
            self.more(tell)
            self.fewer(tell)
        tell("each choice from the best values", 0.9)
        self.finish()
        self.settle()
        found = [
            Choice(self.names(own), self.levels, fit, odds)
            for own, (fit, odds) in self.scored.items()
        ]
        return [*found, *self.gains()]

    def stated(self) -> None:
        """The choices that the levels state: that in which most changed, and of the others those
        that may have a say by what can be seen from it."""
        every = {own for names in self.levels.choices for own in self.forms_of(names)}
        most, *others = sorted(every, key=lambda own: (-len(own), sorted(own)))
        known = self.score(most, None, self.floor) > -np.inf
        for own in reversed(others):
            if not known or self._foreseen(own, self.alongside(most)) > self.floor:
                self.score(own, None, self.floor)

    def names(self, own: frozenset[int]) -> frozenset[str]:
        """What changed."""
        return frozenset(group.effect for group in self._changed(own))

    def forms_of(self, names: frozenset[str]) -> set[frozenset[int]]:
        """The ways in which some groups change: in their sizes alone, or in all their numbers."""
        ways = [group.forms for group in self.groups if group.effect in names]
        return {frozenset[int]().union(*(way[end] for way in ways)) for end in (0, -1)}

    def score(
        self, own: frozenset[int], of: frozenset[int] | None = None, least: float = -np.inf
    ) -> float:
        """Log odds of a choice; of: another one, from whose values it is searched too. least: from
        where on it is searched to its end."""
        own, scored = self.alongside(own), self.scored
        if own in scored and scored[own][1] < self.asked[own] and least < self.asked[own]:
            self.asked[own] = least
            self._from(own, scored[own][0], least, ranked=True)
        if own not in scored:
            starts = _nested(own, scored), [scored[of][0]] if of is not None else []
            found = _fitted(self.levels, own, *starts, self._until(own, least))
            if found is None:
                return -np.inf
            scored[own] = found, found.log_evidence + self._prior(own)
            self.asked[own] = least
        return scored[own][1]

    def top(
        self,
        choices: Sequence[frozenset[int]],
        of: frozenset[int] | None = None,
        enough: float = np.inf,
    ) -> frozenset[int]:
        """The most probable of some choices; those that are foreseen to be so are tried first. What
        is far below it is not searched to its end, nor begun where that is foreseen. Once one has
        log odds that are enough, none is begun that is foreseen to have no say beside it."""
        ahead = {own: self._foreseen(own, of) for own in choices}
        best, most = choices[0], -np.inf
        for own in sorted(choices, key=lambda own: -ahead[own]):
            if ahead[own] < most - (_EFFORT.far if most < enough else _EFFORT.room):
                break
            odds = self.score(own, of, most - _EFFORT.far)
            if odds > most:
                best, most = own, odds
        return best

    def _foreseen(self, own: frozenset[int], of: frozenset[int] | None) -> float:
        """Log odds of a choice as far as they can be seen from another one, or from the best one
        that it holds; infinite where there is none."""
        own = self.alongside(own)
        if own in self.scored:
            return self.scored[own][1]
        starts = _nested(own, self.scored) if of is None else [self.scored[of][0]]
        if not starts:
            return np.inf
        levels = self.levels
        return foreseen(levels.parties, levels.variants, own, starts[0]) + self._prior(own)

    def ends(self) -> tuple[float, float, float]:
        """Log odds that no choice goes beyond, those where nothing changed and where all did; all
        minus infinity where the search has no choice to begin with."""
        every = frozenset(i for group in self.groups for i in group.unknowns)
        none, whole = self.score(frozenset()), self.score(every)
        if none == -np.inf:
            return none, none, none
        if whole == -np.inf:
            return np.inf, none, whole
        shared, own = (self.scored[self.alongside(at)][0] for at in (frozenset[int](), every))
        return max(none, whole, none + 0.5 * (shared.misfit - own.of_readings)), none, whole

    def _changed(self, own: frozenset[int]) -> list[Group]:
        return [group for group in self.groups if not own.isdisjoint(group.sizes)]

    def _prior(self, own: frozenset[int]) -> float:
        return sum((group.log_odds for group in self._changed(own)), self.there)

    def alongside(self, own: frozenset[int]) -> frozenset[int]:
        """With what changes beside a group that did, and without shapes of one that did not."""
        changed = self._changed(own)
        names = {group.effect for group in changed}
        kept = own.intersection(i for group in changed for i in group.unknowns)
        return kept | {place for name, place in self.levels.alongside if name in names}

    def more(self, tell: Progress) -> None:
        """From none, one group after the other, by its sizes or whole."""
        best = frozenset[int]()
        for number in range(2 * _EFFORT.together):
            tell("what changed", 0.25 * number / _EFFORT.together)
            further = [best | form for group in self.groups for form in group.forms]
            further = [own for own in further if len(self.names(own)) <= _EFFORT.together]
            top = self.top(further or [best])
            top = self.top([top, *self._less(top)])
            if self.score(top) <= self.scored[best][1]:
                break
            best = self.alongside(top)

    def _less(self, own: frozenset[int]) -> list[frozenset[int]]:
        """Without one of the groups that changed, or without the shapes of one; what changes beside
        another group stays."""
        changed = self._changed(own)
        fewer = [own.difference(group.unknowns) for group in changed]
        shared = [own.difference(group.unknowns) | set(group.sizes) for group in changed]
        kept = [self.alongside(less) for less in (*fewer, *shared)]
        return [less for less in dict.fromkeys(kept) if less and less != self.alongside(own)]

    def fewer(self, tell: Progress) -> None:
        """From all, one less after the other."""
        best = every = frozenset(i for group in self.groups for i in group.unknowns)
        if self.score(best) == -np.inf:
            return
        whole = self.alongside(best)
        for inside in _nested(whole, self.scored):
            if self.scored[whole][0].misfit > inside.misfit + 0.1:
                self._from(whole, inside, self.least, ranked=True)
        while less := self._less(best):
            tell("what did not change", 0.9 - 0.4 * len(best) / len(every))
            known = self.scored[best][1]
            fewer = self.top(less, best, enough=known)
            if self.score(fewer) < known:
                break
            best = self.alongside(fewer)

    def gains(self) -> Iterator[Choice]:
        """The best choices with a gain in place of a number of the drive, and that gain alone: by
        whatever an instrument may change, and no further."""
        known = [group for group in self.groups if group.effect in PRIORS]
        gains = [group for group in known if CLASSES[group.effect] == "rig"]
        numbers = {i for group in known if group not in gains for i in group.unknowns}
        leaders = sorted(self.scored, key=lambda own: -self.scored[own][1])
        swapped = {
            (own - numbers).union(gain.unknowns)
            for own in leaders[: _EFFORT.leaders]
            if own & numbers
            for gain in gains
        }
        places = frozenset(i for gain in gains for i in gain.unknowns)
        alone = {own & places for own in swapped}
        for own in sorted(swapped | alone, key=sorted):
            of, wide = self.levels, self.alongside(own)
            fitted = partial(fit_shared, of.parties, of.variants, wide, loose=own & places)
            fit = fitted(until=self._until(wide, self.least))
            if fit is not None and fit.log_evidence + self._prior(wide) > self.best - _EFFORT.room:
                fit = fitted(start=fit.points) or fit
            if fit is not None and not fit.ends_at_limit(own & places):
                odds = fit.log_evidence + self._prior(wide)
                yield Choice(self.names(wide), of, fit, odds, loose=own & places)

    @property
    def best(self) -> float:
        """Log odds of the best choice so far."""
        return max((odds for _, odds in self.scored.values()), default=-np.inf)

    @property
    def floor(self) -> float:
        """Log odds that are far below those of another set."""
        return self.known - _EFFORT.far

    @property
    def least(self) -> float:
        """Log odds that are far below those."""
        return max(self.best - _EFFORT.far, self.floor)

    def finish(self) -> None:
        """Those that have a say are fitted to their end: the others were ranked."""
        of, near = self.levels, max(self.best, self.known) - _EFFORT.room
        for own, (fit, odds) in list(self.scored.items()):
            if odds > near:
                found = fit_shared(of.parties, of.variants, own, fit.points)
                if found is not None and found.misfit <= fit.misfit:
                    self.scored[own] = found, found.log_evidence + self._prior(own)

    def settle(self) -> None:
        """Choices fitted again from the values of the best ones, where that may gain: what fits
        well with values of its own at each level may do so with one for all, and a search that
        stopped short of it would count as a change. What a choice holds fits no better than the
        choice."""
        leaders = sorted(self.scored, key=lambda own: -self.scored[own][1])[: _EFFORT.leaders]
        for own in sorted(self.scored, key=len):
            for other in leaders:
                start = self.scored[other][0]
                if own < other:
                    may_gain = self._is_promised(own, start)
                else:
                    may_gain = other < own and self.scored[own][0].misfit > start.misfit + 0.1
                if may_gain:
                    self._from(own, start, self.least)

    def _from(self, own: frozenset[int], start: Shared, least: float, ranked: bool = False) -> None:
        """A choice searched again from the values of a fit, kept if it is more probable there."""
        of, prior = self.levels, self._prior(own)
        until = Until(ranked, least - prior)
        again = fit_shared(of.parties, of.variants, own, start.points, until=until)
        if again is not None and again.log_evidence + prior > self.scored[own][1]:
            self.scored[own] = again, again.log_evidence + prior

    def _until(self, own: frozenset[int], least: float) -> Until:
        """When the first search of a choice ends: it is to be ranked, and far below some log odds
        no more than that."""
        return Until(True, least - self._prior(own))

    def _is_promised(self, own: frozenset[int], start: Shared) -> bool:
        """Whether a choice may become more probable, and not far below the best one, by a search
        from the values of another choice. What is foreseen of values far apart may be too little.
        """
        of = self.levels
        reached = foreseen(of.parties, of.variants, own, start) + self._prior(own)
        return reached > max(self.scored[own][1] - _EFFORT.room, self.least)


def _fitted(
    levels: Levels,
    places: frozenset[int],
    inside: Sequence[Shared],
    further: Sequence[Shared],
    until: Until,
) -> Shared | None:
    """A choice holds the one inside it, so it fits at least as well. further: choices from whose
    values it is searched too."""
    fitted = partial(fit_shared, levels.parties, levels.variants, places, until=until)
    found, worse = fitted(), 0.6 if until.ranked else 0.1
    for other in further:
        if found is not None and found.misfit <= other.misfit + worse:
            continue  # it is held by the other, and fits no better
        again = fitted(start=other.points)
        if again is not None and (found is None or again.log_evidence > found.log_evidence):
            found = again
    for other in inside:
        if found is None or found.misfit > other.misfit + worse:
            again = fitted(start=other.points)
            if again is not None and (found is None or again.misfit < found.misfit):
                found = again
    return found


def _nested(
    own: frozenset[int], scored: dict[frozenset[int], tuple[Shared, float]]
) -> Sequence[Shared]:
    """The best fit of a choice that this one holds."""
    inside = [value for other, value in scored.items() if other < own]
    return [max(inside, key=lambda value: value[1])[0]] if inside else []
