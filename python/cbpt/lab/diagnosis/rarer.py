"""Effects that follow the readings as well as what is certain, and are less probable only because
they are taken to be rarer.

as_well  told as notes
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cbpt.lab.selection.decision import Verdict
from cbpt.lab.selection.model_comparison import Competition
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names, prior
from cbpt.lab.wording.numbers import listed, rounded


def as_well(competition: Competition, verdict: Verdict) -> Iterator[str]:
    """Of sets in whose place another one stands by prior odds alone: what they have instead, for
    what is certain, within the odds of `certain`. Sets with more effects are no such rivals."""
    best = verdict.names
    spoken = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
    named = set(best) & spoken
    if best not in competition.log_odds or not named:
        return
    told: set[tuple[Names, Names]] = set()
    least = _of_the_readings(competition, best) - RULES.log_rival_odds
    for names in sorted(competition.log_odds, key=lambda n: -_of_the_readings(competition, n)):
        lost, instead = set(best) - set(names), set(names) - set(best)
        if len(names) > len(best) or not lost or lost - named or not instead or instead & spoken:
            continue
        rarer = prior(best) - prior(names)
        if _of_the_readings(competition, names) < least or rarer < RULES.log_rival_odds:
            continue
        pair = tuple(sorted(instead)), tuple(sorted(lost))
        if pair not in told:
            told.add(pair)
            yield (
                f"{listed(pair[0])} would explain these readings as well as {listed(pair[1])}, and "
                f"is taken to be {rounded(float(np.exp(rarer)))} times rarer: if your instrument "
                "is known for it, fit it (cbpt fit --with)"
            )


def _of_the_readings(competition: Competition, names: Names) -> float:
    """Log odds without the prior ones."""
    return competition.log_odds[names] - prior(names)
