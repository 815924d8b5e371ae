"""Which effects are fitted at all levels where nobody names them.

demanded     sets of effects, by the diagnoses of the levels
support_of   how much the levels demand each effect
not_of_all   of these, those that the tables of some levels cannot show
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.model.priors import PRIORS


@dataclass(frozen=True)
class _Effort:
    """How far is searched."""

    least: float = 0.1
    """Combinations of a level that are less probable are not looked at."""
    sets: int = 4
    """Sets of effects that are fitted at all levels, beside what all levels have in common."""


_EFFORT = _Effort()
_NO_EFFECTS = frozenset({"", "run_offset", "unknown", *PRIORS})
"""What a diagnosis may say and that is no effect of its own here."""


def demanded(answers: Sequence[Diagnosis]) -> list[list[str]]:
    """Sets of effects for all levels: what the most probable sets of the levels demand together,
    the likeliest first."""
    known = [{v.effect for v in d.competition.fitter.variants} for d in answers]
    sets: dict[frozenset[str], float] = {frozenset(): 1.0}
    for d in answers:
        options = _options(d)
        joined: dict[frozenset[str], float] = {}
        for have, p in sets.items():
            for more, q in options.items():
                joined[have | more] = joined.get(have | more, 0.0) + p * q
        top = sorted(joined, key=lambda names: -joined[names])[: _EFFORT.sets]
        sets = {names: joined[names] for names in top}
    every = dict.fromkeys([*sets, *_in_common(answers)])
    return [sorted(e for e in names if all(e in some for some in known)) for names in every]


def _in_common(answers: Sequence[Diagnosis]) -> list[frozenset[str]]:
    """Where some level has a rest without a name, what the sets that all answers are drawn with
    have in common. Beside such a rest none of it may be certain at any level, and yet be one law
    that all levels follow."""
    if all(d.verdict.lack_of_fit is None for d in answers):
        return []
    best = [frozenset(d.verdict.names) - _NO_EFFECTS for d in answers]
    return [common] if (common := frozenset.intersection(*best)) else []


def not_of_all(answers: Sequence[Diagnosis]) -> list[str]:
    """Effects that some level demands and that the table of another one has no column for."""
    known = [{v.effect for v in d.competition.fitter.variants} for d in answers]
    wanted = {effect for d in answers for names in _options(d) for effect in names}
    return sorted(effect for effect in wanted if not all(effect in some for some in known))


def support_of(answers: Sequence[Diagnosis]) -> dict[str, float]:
    """How much the levels demand each effect: the sum of its probabilities."""
    found: dict[str, float] = {}
    for d in answers:
        for names, probability in _options(d).items():
            for effect in names:
                found[effect] = found.get(effect, 0.0) + probability
    return found


def _options(d: Diagnosis) -> dict[frozenset[str], float]:
    """Sets of effects that a level may demand, with their probabilities."""
    return _told(d) if d.verdict.lack_of_fit is not None else _combined(d)


def _combined(d: Diagnosis) -> dict[frozenset[str], float]:
    """The probable combinations of a level; else the one that its answer is drawn with."""
    rows = [row for row in d.combinations() if row.probability >= _EFFORT.least]
    options = {frozenset(row.effects) - _NO_EFFECTS: row.probability for row in rows}
    return options or {frozenset(d.verdict.names) - _NO_EFFECTS: 1.0}


def _told(d: Diagnosis) -> dict[frozenset[str], float]:
    """The same of a level beside a rest that has no name: what is told for certain, one of each
    group of rivals, with and without what is likely. The other effects of its combinations may be
    parts of the rest."""
    groups = [[(e, p), ("", 1 - p)] for e, p in d.verdict.perhaps]
    groups += [[(e, 1 / len(group)) for e in group] for group in d.verdict.rivals]
    found: dict[frozenset[str], float] = {}
    for chosen in product(*groups):
        names = {*d.verdict.effects, *(e for e, _ in chosen)} - _NO_EFFECTS
        probability = prod(p for _, p in chosen)
        found[frozenset(names)] = found.get(frozenset(names), 0.0) + probability
    return found
