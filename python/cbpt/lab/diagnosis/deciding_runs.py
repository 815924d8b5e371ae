"""The run that would decide what a diagnosis leaves open, or that none within reach can.

RankedRuns        runs ranked by what they are expected to bring
most_probable     of the hypotheses that are open
rank              ranks them; rank_if_open, where something is open
next_run          the best of them, as the document of the answer has it
why_no_run        why there is none, and what helps in its place
name_among        the hypothesis that a set of effects is among those that are open
open_hypotheses   the hypotheses that a diagnosis leaves open
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.unexplained import measure_next
from cbpt.lab.experiment.candidates import Limits, candidates, limits_of
from cbpt.lab.experiment.expected_gain import LIMIT, OpenHypotheses, Suggested, lacking, prospect
from cbpt.lab.experiment.plan import PlannedRun
from cbpt.lab.model.priors import PRIORS, TWINS
from cbpt.lab.selection.rules import RULES
from cbpt.lab.wording.numbers import listed

BALLS = "ball_drive"
"""The kind of drive for which runs are computed: the candidates are loops at preloads and input
angles that a torsion spring does not have."""
CANDIDATES = 200
"""How many runs are chosen among."""
# A combination this much less probable than the best still counts as open.
_OPEN = float(np.log(1000.0))
_MOST_OPEN = 6
_LIMIT_OF = {"time_s": "dwell_s", "temperature_degC": "temperature_degC", "cycle": "cycles"}
"""What gives further runs a column."""
_OF_SPRING = (
    "runs are computed for ball drives alone, not for a torsion spring; loops to other torques and "
    "at other rates may decide between the combinations that are open, and so may other knowledge, "
    "such as a calibration or a drawing"
)
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

    @property
    def leading(self) -> str:
        """The most probable hypothesis."""
        return most_probable(self.open)

    def closest(self, run: Suggested) -> tuple[str, str]:
        """The pair that a run tells most about, where it decides none; one with the most probable
        hypothesis, where it tells anything about such a pair."""
        gains = run.pairs
        own = [pair for pair in gains if self.leading in pair and gains[pair] > HARDLY]
        return max(own or gains, key=lambda pair: gains[pair])

    def told_from_leading(self, run: Suggested) -> list[str]:
        """The most probable hypothesis and those that a run is expected to tell from it beyond the
        limit of odds; empty where it tells none."""
        told = [n for n, gain in run.against(self.leading).items() if gain > LIMIT]
        return sorted([*told, self.leading]) if told else []

    def runs_like(self, run: Suggested) -> int | None:
        """About how many such runs decide the pair that it tells most about; None where hardly any
        number does."""
        best = max(run.pairs.values(), default=0.0)
        most = best if best > LIMIT else run.pairs[self.closest(run)]
        return int(np.ceil(LIMIT / most)) if most > HARDLY else None

    def untold(self) -> list[str]:
        """Hypotheses that no run within reach tells from the most probable one."""
        most: dict[str, float] = {}
        for suggested in self.ranked:
            for other, gain in suggested.against(self.leading).items():
                most[other] = max(most.get(other, 0.0), gain)
        return [name for name, gain in most.items() if gain <= HARDLY]


def most_probable(open_: Mapping[str, float]) -> str:
    """Of hypotheses with their shares."""
    return max(open_, key=lambda name: open_[name])


def rank(d: DiagnosisData, limits: Limits | None = None, most: int = CANDIDATES) -> RankedRuns:
    """Rank the runs that could decide what a diagnosis leaves open."""
    if d.verdict.kind == "unknown":
        return RankedRuns({}, (), measure_next(d))
    if d.competition.campaign.drive.kind != BALLS:
        return RankedRuns({}, (), f"{_OF_SPRING[0].upper()}{_OF_SPRING[1:]}.")
    hypotheses = open_hypotheses(d)
    if len(hypotheses) < 2:
        why = "No further run is needed to decide: only one hypothesis is left."
        return RankedRuns({}, (), why)
    runs = candidates(d.competition.campaign.drive, limits or limits_of(d.readings), most)
    with one_blas_thread():
        view = prospect(hypotheses, runs)
        if view is None:
            return RankedRuns({}, (), _why_not(hypotheses, runs))
        found: list[Suggested] = []
        for number, run in enumerate(runs):
            pairs = view.gains(view.rows.run_index == number)
            if np.isfinite(list(pairs.values())).all():
                found.append(Suggested(run, view.mean_gain(pairs), pairs))
    found.sort(key=lambda suggested: -suggested.gain)
    shares = dict(zip(view.names, view.share.tolist(), strict=True))
    twins = tuple(p for p in combinations(view.names, 2) if p[1] in TWINS.get(p[0], []))
    if not found:
        return RankedRuns(
            shares, (), "The model has no solution for any run within the limits.", twins
        )
    if found[0].gain < HARDLY or len(twins) == len(found[0].pairs):
        why = (
            "No run within the limits can decide between the hypotheses; other knowledge, such as "
            "a drawing, can."
        )
        return RankedRuns(shares, (), why, twins)
    return RankedRuns(shares, tuple(found), "", twins)


def rank_if_open(d: DiagnosisData) -> RankedRuns | None:
    """The same where something is open; None where nothing is."""
    if d.competition.campaign.drive.kind != BALLS:
        return None
    return rank(d) if d.verdict.rivals or d.verdict.perhaps else None


def next_run(found: RankedRuns | None) -> dict[str, Any] | None:
    """The best run for what is open, as the answer's document has it; None where nothing is."""
    if found is None or not found.ranked:
        return None
    best = found.ranked[0]
    return best.to_dict() | {
        "separates": found.told_from_leading(best) or best.separates or list(found.closest(best)),
        "most_probable": found.leading,
        "runs": found.runs_like(best),
        "untold": found.untold(),
    }


def why_no_run(d: DiagnosisData, answer: Mapping[str, Any]) -> str:
    """Why the document of an answer suggests no run, and what helps in its place."""
    verdict, unknown = answer["verdict"], answer["unknown"]
    if verdict["kind"] == "unknown":
        return str(unknown["measure_next"])
    for one, other in (pair for group in verdict["rivals"] for pair in combinations(group, 2)):
        if other in TWINS.get(one, []):
            return (
                f"no run of this rig tells {one} from {other}: both change every reading in the "
                "same way; other knowledge, such as a calibration or a drawing, can"
            ).replace("_", " ")
    if (verdict["rivals"] or verdict["perhaps"]) and d.competition.campaign.drive.kind != BALLS:
        return _OF_SPRING
    if verdict["rivals"] or verdict["perhaps"]:
        return (
            "no run like the previous ones would decide between the combinations that are open; "
            "other knowledge, such as a calibration or a drawing, can"
        )
    if unknown:
        return str(unknown["measure_next"])
    return "nothing is open, so no further run is needed to decide"


def open_hypotheses(d: DiagnosisData) -> OpenHypotheses:
    """Combinations that make up 95 % of the posterior, at most six; where one does that alone,
    those within 1000 : 1 of it.

    Each is named by what it has beside the effects that all of them have. Where numbers of drive
    and rig share a shift within their uncertainties, those numbers are the hypotheses. What has no
    name predicts nothing, so it is none.
    """
    fits = d.competition.fits
    if d.verdict.within_uncertainty and d.verdict.rivals:
        numbers = dict.fromkeys(number for group in d.verdict.rivals for number in group)
        return _hypotheses(d, {n: (n,) if (n,) in fits else () for n in numbers})
    return _hypotheses(d, {name: names for names, name in _named(_near(d)).items()})


def _named(near: Sequence[tuple[str, ...]]) -> dict[tuple[str, ...], str]:
    """Sets by what they have beside the effects that all of them have."""
    common = set(near[0]).intersection(*near)
    # Beside several that have more, the one that all have in common is called so.
    rest = "no further effect" if common else "no effect"
    return {n: " + ".join(e for e in n if e not in common) or rest for n in near}


def name_among(d: DiagnosisData, names: tuple[str, ...]) -> str | None:
    """The hypothesis that a set of effects is among those that are open; None where it is none."""
    return _named(_near(d)).get(names)


def _hypotheses(d: DiagnosisData, sets: Mapping[str, tuple[str, ...]]) -> OpenHypotheses:
    """With the odds of each, and the noise of the answer; without one that of the first of them."""
    fits, odds = d.competition.fits, d.competition.log_odds
    noise = fits[next(iter(sets.values()))].noise if d.verdict.undecided else d.after.noise
    weighed = {name: (fits[names], odds[names]) for name, names in sets.items()}
    return OpenHypotheses(d.case, d.competition.fitter, noise, weighed)


def _why_not(hypotheses: OpenHypotheses, runs: Sequence[PlannedRun]) -> str:
    """Which effects further runs cannot show, and what to do about it."""
    lacks = lacking(hypotheses, runs)
    columns = dict.fromkeys(column for column in lacks.values() if column)
    limits = listed([_LIMIT_OF[column] for column in columns])
    remedy = f", because its runs have no {listed(list(columns))}; set {limits} of the limits"
    return (
        f"No run is suggested: the change by {listed(list(lacks))} cannot be computed for a "
        f"further run{remedy if columns else ''}."
    )


def _near(d: DiagnosisData) -> list[tuple[str, ...]]:
    """Sets of effects by probability; a set is left out where a more probable one differs from it
    by numbers of drive or rig alone: these move in every fit, only not as far."""
    odds = d.competition.log_odds
    top = max(odds.values())
    total = sum(np.exp(value - top) for value in odds.values())
    found: list[tuple[str, ...]] = []
    held = 0.0
    for names in sorted(odds, key=lambda n: -odds[n]):
        enough = held >= RULES.certain and len(found) > 1
        if enough or odds[names] < top - _OPEN or len(found) == _MOST_OPEN:
            break
        held += float(np.exp(odds[names] - top) / total)
        if names not in {_bare(n) for n in found if _bare(n) != n}:
            found.append(names)
    return found


def _bare(names: tuple[str, ...]) -> tuple[str, ...]:
    """A set without numbers of drive and rig."""
    return tuple(e for e in names if e not in PRIORS)
