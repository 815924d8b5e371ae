"""The posterior over sets of effects, and what is read off it.

Posterior     probability of every set that was weighed
Spoken        what is certain, what is open, what is likely
named_of      the effects of a set that have a name, which are those of a fit
posterior_of  from the odds of a competition
spoken_of     by the rules of the decision
set_of        the set that a fit stands for

Offsets of runs are part of the noise and a lack of fit has no name, but both are members of the
sets like any effect (`OFFSET`, `UNKNOWN`): what could be one of them could be an effect too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations as subsets

import numpy as np

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.rules import DecisionRules
from cbpt.lab.selection.setting import Names, prior

_MOST_OPEN = 8
"""Effects, the most probable ones, among which groups are looked for of which one is needed."""
UNKNOWN, OFFSET = "unknown", "run_offset"


@dataclass(frozen=True)
class Posterior:
    """Probability of every set that was weighed."""

    sets: Mapping[Names, float]
    undemanded: frozenset[Names] = frozenset()
    """Sets whose evidence is no greater than that of the drive as stated: an effect too small for
    these readings has the probability that it had before, and speaks against no other."""

    @property
    def even(self) -> Posterior:
        """The same where one effect is as likely beforehand as none, and each further one as
        improbable as ever: what the readings say of one effect against offsets of runs."""
        sets = {names: p / np.exp(_one_of(names)) for names, p in self.sets.items()}
        total = sum(sets.values())
        return Posterior({names: p / total for names, p in sets.items()}, self.undemanded)

    @property
    def best(self) -> Names:
        """The most probable set."""
        return max(self.sets, key=lambda names: self.sets[names])

    @property
    def inclusion(self) -> dict[str, float]:
        """Probability that an effect is at work, whatever else is."""
        effects = sorted(set().union(*self.sets))
        return {e: self.of_any([e]) for e in effects}

    def of_any(self, effects: Iterable[str]) -> float:
        """Probability that one or more of some effects are at work."""
        wanted = set(effects)
        return _together(p for names, p in self.sets.items() if wanted & set(names))

    def of_several(self, effects: Iterable[str]) -> float:
        """Probability that two or more of some effects are at work."""
        wanted = set(effects)
        return _together(p for names, p in self.sets.items() if len(wanted & set(names)) > 1)

    def of_all(self, certain: Iterable[str], groups: Iterable[Iterable[str]] = ()) -> float:
        """Probability that all of some effects are at work, and one of each group."""
        needed, one_of = set(certain), [set(g) for g in groups]
        return _together(
            p
            for names, p in self.sets.items()
            if needed <= set(names) and all(set(names) & g for g in one_of)
        )

    def within(self, allowed: Iterable[str]) -> float:
        """Probability that nothing but some effects is at work."""
        names = set(allowed)
        return _together(p for found, p in self.sets.items() if set(found) <= names)

    def demands_at_most(self, allowed: Iterable[str]) -> float:
        """Probability that the readings demand nothing but some effects."""
        names = set(allowed)
        more = sum(
            p
            for found, p in self.sets.items()
            if not set(found) <= names and found not in self.undemanded
        )
        return 1.0 - float(more)


def _together(probabilities: Iterable[float]) -> float:
    """Of sets of which one holds; rounding may have made it more than 1."""
    return min(float(sum(probabilities)), 1.0)


@dataclass(frozen=True)
class Spoken:
    """What is certain, what is open, what is likely."""

    effects: tuple[str, ...]
    rivals: tuple[tuple[str, ...], ...]
    """Groups of which one is needed and hardly two are at work."""
    perhaps: tuple[tuple[str, float], ...]
    """Effects that are likely but neither certain nor one of a group, with their probability."""


def named_of(names: Names) -> Names:
    """The effects of a set that a fit has: neither offsets of runs nor a lack of fit."""
    return tuple(n for n in names if n not in (OFFSET, UNKNOWN))


def _one_of(names: Names) -> float:
    """Log prior odds of the likeliest effect of a set; offsets of runs have a price as noise."""
    return max((prior((n,)) for n in names if n != OFFSET), default=0.0)


def posterior_of(competition: Competition) -> Posterior:
    """From the odds of a competition; of sets that were fitted with and without offsets of runs the
    more probable form counts."""
    odds: dict[Names, float] = {}
    undemanded: set[Names] = set()

    def add(names: Names, noise: Noise, value: float) -> None:
        key = set_of(names, noise)
        if value > odds.get(key, -np.inf):
            odds[key] = value
            (undemanded.discard if value > prior(names) else undemanded.add)(key)

    for names, value in competition.log_odds.items():
        add(names, competition.fits[names].noise, value)
    unnamed = zip(competition.lacks_of_fit, competition.lack_of_fit_log_odds, strict=True)
    for lack, value in unnamed:
        add((*lack.base, UNKNOWN), lack.noise, value)
    top = max(odds.values())
    weights = {names: float(np.exp(value - top)) for names, value in odds.items()}
    total = sum(weights.values())
    sets = {names: weight / total for names, weight in weights.items()}
    return Posterior(sets, frozenset(undemanded))


def set_of(names: Names, noise: Noise) -> Names:
    """The effects of a fit, offsets of runs among them where its noise has them."""
    return tuple(sorted((*names, *_offset(noise))))


def _offset(noise: Noise) -> Names:
    return (OFFSET,) if noise.offset_arcsec else ()


def spoken_of(posterior: Posterior, rules: DecisionRules) -> Spoken:
    """What is said of a posterior."""
    inclusion = posterior.inclusion
    certain = sorted(e for e, p in inclusion.items() if p >= rules.certain)
    open_ = sorted(
        (e for e, p in inclusion.items() if rules.likely <= p < rules.certain),
        key=lambda e: -inclusion[e],
    )
    groups: list[tuple[str, ...]] = []
    for group in _groups(posterior, open_[:_MOST_OPEN], rules):
        if not set(group) & set().union(*groups):
            groups.append(tuple(sorted(group)))
    if certain == [OFFSET] and (instead := _instead_of_offsets(posterior, rules)):
        certain, groups = [], [tuple(sorted((OFFSET, *instead)))]
    elif not set(certain) - {OFFSET} and not groups:
        # One or more of them are at work, and nobody can say which. It may take improbable ones.
        ranked = sorted(set(inclusion) - set(certain), key=lambda e: -inclusion[e])
        groups = _one_or_more(posterior, ranked[:_MOST_OPEN], rules)
    grouped = set().union(*groups)
    perhaps = tuple((e, inclusion[e]) for e in open_ if e not in grouped)
    return Spoken(tuple(certain), tuple(sorted(groups)), perhaps)


def _instead_of_offsets(posterior: Posterior, rules: DecisionRules) -> Names:
    """What follows the readings as well as offsets of runs do, which then owe their probability to
    the prior odds alone: where each run has an input angle of its own, an eccentricity, say."""
    if posterior.even.of_any([OFFSET]) >= rules.certain:
        return ()
    return max(
        (names for names in posterior.sets if OFFSET not in names),
        key=lambda names: posterior.sets[names],
        default=(),
    )


def _groups(
    posterior: Posterior, open_: Sequence[str], rules: DecisionRules
) -> list[tuple[str, ...]]:
    """Groups of which one is certain and two are improbable, the smallest first."""
    found = [
        (size, several, group)
        for size in range(2, len(open_) + 1)
        for group in subsets(open_, size)
        if (several := posterior.of_several(group)) < rules.together
        and posterior.of_any(group) >= rules.certain
    ]
    return [group for _, _, group in sorted(found)]


def _one_or_more(
    posterior: Posterior, open_: Sequence[str], rules: DecisionRules
) -> list[tuple[str, ...]]:
    """The most probable effects, as many as it takes for one of them to be certain."""
    for size in range(2, len(open_) + 1):
        if posterior.of_any(open_[:size]) >= rules.certain:
            return [tuple(sorted(open_[:size]))]
    return []
