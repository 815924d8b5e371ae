"""The run that would decide what a diagnosis leaves open, or that none within reach can.

NextRuns          runs ranked by what they are expected to bring
ranked            ranks them
next_run          the best of them, as the document of the answer has it
open_hypotheses   the hypotheses that a diagnosis leaves open
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.unexplained import measure_next
from cbpt.lab.experiment.candidates import Limits, candidates, limits_of
from cbpt.lab.experiment.expected_gain import OpenHypotheses, Suggested, prospect
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.priors import PRIORS, TWINS

CANDIDATES = 200
"""How many runs are chosen among."""
# Without rivals: a hypothesis this much less probable than the best still counts as open.
_OPEN = float(np.log(1000.0))
_MOST_OPEN = 6
DECIDED = 5.0
"""Log odds from which a pair counts as decided and need not be decided further."""
HARDLY = 0.1
"""Log odds below which a run hardly touches a pair."""


@dataclass(frozen=True, eq=False)
class RankedRuns:
    """Runs ranked by what they are expected to bring."""

    open: Mapping[str, float]
    """Hypotheses that are open, with the share of each among them."""
    ranked: tuple[Suggested, ...]
    why_none: str = ""
    """Why no run is suggested, where none is."""
    twins: tuple[tuple[str, str], ...] = ()
    """Pairs that no reading of this rig tells apart."""


def rank(d: DiagnosisData, limits: Limits | None = None, most: int = CANDIDATES) -> RankedRuns:
    """Rank the runs that could decide what a diagnosis leaves open."""
    if d.verdict.kind == "unknown":
        return RankedRuns({}, (), measure_next(d))
    if d.competition.campaign.drive.kind != "ball_drive":
        why = "No run is suggested for a torsion spring, because its permissible load is not known."
        return RankedRuns({}, (), why)
    hypotheses = open_hypotheses(d)
    if len(hypotheses) < 2:
        why = "No further run is needed to decide: only one hypothesis is left."
        return RankedRuns({}, (), why)
    runs = candidates(d.competition.campaign.drive, limits or limits_of(d.readings), most)
    with threadpool_limits(1, user_api="blas"):
        view = prospect(hypotheses, runs)
        if view is None:
            return RankedRuns(
                {},
                (),
                "No run is suggested: an effect of the case cannot be computed for a further run.",
            )
        found = []
        for number, run in enumerate(runs):
            pairs = view.gains(view.rows.run_index == number)
            if np.isfinite(list(pairs.values())).all():
                found.append((view.mean_gain(pairs, DECIDED), number, run, pairs))
    # A pair that is decided need not be decided further.
    found.sort(key=lambda f: (-f[0], f[1]))
    ranked = tuple(Suggested(run, view.mean_gain(pairs), pairs) for _, _, run, pairs in found)
    shares = dict(zip(view.names, view.share.tolist(), strict=True))
    twins = tuple(p for p in combinations(view.names, 2) if p[1] in TWINS.get(p[0], []))
    if not found:
        return RankedRuns(
            shares, (), "The model has no solution for any run within the limits.", twins
        )
    if found[0][0] < HARDLY:
        why = (
            "No run within the limits can decide between the hypotheses; other knowledge, such as "
            "a drawing, can."
        )
        return RankedRuns(shares, (), why, twins)
    return RankedRuns(shares, ranked, "", twins)


def next_run(d: DiagnosisData) -> dict[str, Any] | None:
    """The best run for rivals, as the answer's document has it; None where there are none."""
    if d.competition.campaign.drive.kind != "ball_drive":
        return None  # how far a torsion spring may be loaded is not known
    if not d.verdict.rivals:
        return None
    found = rank(d).ranked
    return found[0].to_dict() if found else None


def open_hypotheses(d: DiagnosisData) -> OpenHypotheses:
    """Hypotheses that a diagnosis leaves open.

    Rivals where there are any, each with what is certain; else the best hypothesis and those within
    1000 : 1 of it.
    """
    certain = [e for e in d.verdict.effects if e != "run_offset"]
    fits, odds = d.competition.fits, d.competition.log_odds
    found: dict[str, tuple[Fit, float]] = {}
    groups = [[e for e in g if e not in ("unknown", "run_offset")] for g in d.verdict.rivals]
    for choice in product(*groups) if groups else ():
        names = tuple(sorted([*certain, *choice]))
        # A number of drive or rig moves in every fit, so it needs none of its own.
        bare = tuple(sorted([*certain, *(e for e in choice if e not in PRIORS)]))
        key = names if names in fits else bare
        if key in fits:
            found.setdefault(" + ".join(choice), (fits[key], odds[key]))

    def of(fits: Mapping[str, tuple[Fit, float]]) -> OpenHypotheses:
        return OpenHypotheses(d.case, d.competition.fitter, d.after.noise, fits)

    if groups:
        return of(found)
    top = max(odds.values())
    near = sorted((n for n in fits if odds[n] > top - _OPEN), key=lambda n: -odds[n])
    if near[0] and set(near[0]) <= set(PRIORS):
        # Without effects it is the same model, only that the number may not move as far.
        near = [n for n in near if n]
    return of({" + ".join(n) or "nothing": (fits[n], odds[n]) for n in near[:_MOST_OPEN]})
