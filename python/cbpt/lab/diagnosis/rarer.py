"""Effects that follow the readings as well as one that is told, which then owes its place to the
prior odds alone.

by_prior_odds_alone  told as notes, one for each effect of the best set
"""

from __future__ import annotations

from collections.abc import Container, Iterator

import numpy as np

from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.decision import Verdict
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names, prior
from cbpt.lab.wording.numbers import listed, rounded


def by_prior_odds_alone(competition: Competition, verdict: Verdict) -> Iterator[str]:
    """Of each effect that is told: rarer ones that are not, and may stand in its place beside the
    other effects of the best set, by the odds of `certain` if all were equally likely beforehand.
    """
    best = verdict.names
    told = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
    if best not in competition.log_odds:
        return
    for effect in (name for name in best if name in told):
        instead = _instead(competition, best, effect, told)
        if instead:
            names = sorted(instead, key=lambda name: -instead[name])
            others = (*(name for name in best if name != effect), names[0])
            rarer = min(_log_rarer(effect, name) for name in names)
            yield (
                f"{listed(names, 'or')} would explain these readings about as well as {effect}; "
                f"{effect} is named because its odds before any reading are taken to be at least "
                f"{rounded(float(np.exp(rarer)))} times as high. If your rig may have such an "
                "error, fit it in its place and compare what is left: cbpt fit CASE TABLE --with "
                f"{' '.join(others)}"
            )


def _instead(
    competition: Competition, best: Names, effect: str, told: Container[str]
) -> dict[str, float]:
    """Effects that follow the readings about as well in the place of one, with the log odds by
    which they do."""
    rest = set(best) - {effect}
    least = _of_the_readings(competition, best) - RULES.log_rival_odds
    found = {}
    for names in competition.log_odds:
        come = set(names) - set(best)
        if len(come) == 1 and set(names) - come == rest:
            (name,) = come
            log_odds = _of_the_readings(competition, names)
            if name not in told and log_odds >= least and _log_rarer(effect, name) > 0:
                found[name] = log_odds
    return found


def _log_rarer(effect: str, other: str) -> float:
    return prior((effect,)) - prior((other,))


def _of_the_readings(competition: Competition, names: Names) -> float:
    """Log odds without the prior ones."""
    return competition.log_odds[names] - prior(names)
