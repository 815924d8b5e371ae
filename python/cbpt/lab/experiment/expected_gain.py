"""The run that would decide what the readings leave open, or that none within reach can.

    next_runs   a case and its readings -> NextRuns: runs ranked by what they are expected to bring
    ranked      the same for a diagnosis that has been made
    next_run    the best of them as the answer's document has it

Each hypothesis that is still open, as it was fitted, predicts what a further run would read: a
normal distribution, whose mean is the model at the most probable values and whose covariance is the
noise, a zero of its own for the run, and what the fit still does not know of its numbers. If A is
true, a run is expected to bring log odds of A against B equal to the divergence of their
predictions (Kullback and Leibler 1951); A is true with its posterior probability. Parameters enter
linearised about the fit.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from cbpt._core import Case, Drive
from cbpt.lab.covariance.linear_gaussian import Noise, Rows
from cbpt.lab.diagnosis.unexplained import measure_next
from cbpt.lab.experiment.candidates import Limits, candidates, described, limits_of
from cbpt.lab.experiment.plan import Plan, PlannedRun
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import PRIORS, TWINS
from cbpt.lab.selection.decision import ODDS_LIMIT
from cbpt.lab.wording.versions import versions

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.lab.readings.reader import Readings

__all__ = ["NextRuns", "Prospect", "Suggested", "next_run", "next_runs", "ranked"]

Floats = NDArray[np.float64]
Names = tuple[str, ...]
SCHEMA = "cbpt.next_run/1"

CANDIDATES = 200
# Without rivals: what is this much less likely than the best still counts as open.
_OPEN = float(np.log(1000.0))
_MOST_OPEN = 6
# Log odds: a pair is decided, and hardly touched at all.
LIMIT = float(np.log(ODDS_LIMIT))
_DECIDED, _HARDLY = 5.0, 0.1
# Spread of the zero of a further run over the noise: it is not known at all.
_ZERO_PER_U = 100.0


@dataclass(frozen=True)
class Suggested:
    """One run with what it is expected to bring."""

    run: PlannedRun
    gain: float
    """Log odds of what is true against the others, on average over what may be true."""
    pairs: Mapping[tuple[str, str], float]
    """The same for each two hypotheses."""

    @property
    def separates(self) -> list[str]:
        """Hypotheses that the run is expected to tell from another one beyond the limit of odds."""
        return sorted({n for pair, gain in self.pairs.items() if gain > LIMIT for n in pair})

    def to_dict(self) -> dict[str, Any]:
        """As the answer has it."""
        torque = np.array(self.run.torque_Nm)
        return {
            "torque_Nm": float(torque[np.argmax(np.abs(torque))]),
            "preload_N": self.run.preload_N,
            "input_angle_deg": self.run.input_angle_deg[0],
            "direction": described(self.run),
            "separates": self.separates,
            "gain": max(self.pairs.values()),
        }


@dataclass(frozen=True, eq=False)
class Prospect:
    """What the hypotheses that are open predict for some rows: `names`, their probabilities, and
    of each the mean (n,) and a root of the covariance that its numbers leave (n, p), in arcsec.
    """

    names: tuple[str, ...]
    share: Floats
    rows: Rows
    means: tuple[Floats, ...]
    roots: tuple[Floats, ...]
    noise: Noise
    u_arcsec: float

    def gains(self, rows: NDArray[np.bool_]) -> dict[tuple[str, str], float]:
        """Expected log odds between each two from the rows, whichever of the two is true; NaN where
        a model has no solution.
        """
        covariance = self._noise(self.rows.run_index[rows])
        found = {}
        seen = [
            (m[rows], covariance + r[rows] @ r[rows].T)
            for m, r in zip(self.means, self.roots, strict=True)
        ]
        for i, one in enumerate(seen):
            for j, other in enumerate(seen[i + 1 :], i + 1):
                p, q = self.share[i], self.share[j]
                gain = np.nan
                if np.isfinite(one[0]).all() and np.isfinite(other[0]).all():
                    gain = (p * _divergence(one, other) + q * _divergence(other, one)) / (p + q)
                found[self.names[i], self.names[j]] = float(gain)
        return found

    def mean_gain(self, pairs: Mapping[tuple[str, str], float], most: float = np.inf) -> float:
        """Of what is true against the others, each weighed by its probability."""
        weights = [
            self.share[self.names.index(a)] * self.share[self.names.index(b)] for a, b in pairs
        ]
        gains = np.minimum(np.array(list(pairs.values())), most)
        return float(np.average(gains, weights=np.array(weights) + 1e-300))

    def _noise(self, run: NDArray[np.int64]) -> Floats:
        same = run[:, None] == run[None, :]
        place = np.arange(len(run))
        apart = np.abs(place[:, None] - place[None, :])
        correlated = np.where(same, float(self.noise.correlation) ** apart, 0.0)
        size = self.noise.scale * self.u_arcsec
        zero = max(_ZERO_PER_U * size, self.noise.offset_arcsec)
        return np.asarray(size**2 * correlated + zero**2 * same)


def _divergence(one: tuple[Floats, Floats], other: tuple[Floats, Floats]) -> float:
    """Of two normal distributions (mean, covariance), the first being true."""
    (m, a), (n, b) = one, other
    inverse = np.linalg.inv(b)
    off = m - n
    volume = np.linalg.slogdet(b)[1] - np.linalg.slogdet(a)[1]
    return float(0.5 * (np.sum(inverse * a.T) - len(m) + volume + off @ inverse @ off))


@dataclass(frozen=True, eq=False)
class NextRuns:
    """Runs ranked by what they are expected to bring. `report` says it in words."""

    diagnosis: Diagnosis = field(repr=False)
    open: Mapping[str, float]
    """Hypotheses that are open, with the share of each among them."""
    ranked: tuple[Suggested, ...]
    why_none: str = ""
    """Why no run is suggested, where none is."""
    twins: tuple[tuple[str, str], ...] = ()
    """Pairs that no reading of this rig tells apart."""

    @property
    def best(self) -> Suggested | None:
        """The first of the runs."""
        return self.ranked[0] if self.ranked else None

    def plan(self) -> Plan | None:
        """The best run as a plan."""
        return Plan.of_runs([self.ranked[0].run]) if self.ranked else None

    def runs_like_it(self) -> int | None:
        """About how many such runs the closest pair needs, were each to bring as much."""
        if self.best is None:
            return None
        least = min(g for pair, g in self.best.pairs.items() if pair not in self.twins)
        return int(np.ceil(LIMIT / max(least, 1e-9))) if least > _HARDLY else None

    def to_dict(self) -> dict[str, Any]:
        """The JSON document as plain values."""
        return {
            "schema": SCHEMA,
            "seed": self.diagnosis.seed,
            "versions": versions(),
            "data_sha256": self.diagnosis.readings.sha256,
            "source": self.diagnosis.readings.source,
            "open": dict(self.open),
            "why_none": self.why_none,
            "twins": [list(pair) for pair in self.twins],
            "runs": [
                {
                    **vars(s.run),
                    "direction": described(s.run),
                    "gain": s.gain,
                    "separates": s.separates,
                    "pairs": [{"between": list(p), "gain": g} for p, g in s.pairs.items()],
                }
                for s in self.ranked
            ],
        }

    def to_json(self) -> str:
        """The document as text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def report(self, most: int = 5) -> str:
        """In words and a table of the best runs."""
        return "\n".join(self._lines(most))

    def _lines(self, most: int) -> Iterator[str]:
        from cbpt._core import text_table

        yield self.diagnosis.sentence
        if self.open:
            shares = ", ".join(f"{name} {share:.2f}" for name, share in self.open.items())
            yield f"Open: {shares}."
        for one, other in self.twins:
            yield f"No run on this rig can tell {one} from {other}: they are one to any reading."
        if self.why_none:
            yield self.why_none
        if not self.ranked:
            return
        table = []
        for s in self.ranked[:most]:
            d = s.to_dict()
            peak, angles = f"{d['torque_Nm']:g}", s.run.input_angle_deg
            table.append(
                [
                    f"{s.run.preload_N:g}",
                    peak,
                    d["direction"],
                    f"{angles[0]:g}" if len(angles) == 1 else "a turn",
                    f"{s.gain:.1f}",
                    ", ".join(d["separates"]),
                ]
            )
        yield f"Expected log odds of what is true against the others ({LIMIT:.1f} decide):"
        headers = ["preload_N", "torque_Nm", "torque goes", "input_angle_deg", "gain", "separates"]
        yield text_table(headers, table)
        count = self.runs_like_it()
        if count is not None and count > 1:
            yield f"About {count} such runs would decide between the closest two."

    def __repr__(self) -> str:
        return self.report()


def next_runs(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    columns: Mapping[str, str] | None = None,
    limits: Limits | None = None,
    most: int = CANDIDATES,
    seed: int = 0,
) -> NextRuns:
    """Diagnose the readings and rank the runs that could decide what they leave open.

    limits: what the rig can do; a fourth beyond what it did where not given. most: how many runs to
    choose among. Raises as `diagnose` does.
    """
    from cbpt.lab.diagnosis.diagnose import diagnose

    return ranked(diagnose(case, data, columns=columns, seed=seed), limits, most)


def ranked(d: Diagnosis, limits: Limits | None = None, most: int = CANDIDATES) -> NextRuns:
    """Rank the runs that could decide what a diagnosis leaves open."""
    if d.verdict.kind == "unknown":
        return NextRuns(d, {}, (), measure_next(d))
    if d.competition.campaign.drive.kind != "ball_drive":
        why = "How far a torsion spring may be loaded is not known, so no run is suggested for one."
        return NextRuns(d, {}, (), why)
    fits = open_hypotheses(d)
    if len(fits) < 2:
        why = "Nothing is open between hypotheses that predict a further run."
        return NextRuns(d, {}, (), why)
    runs = candidates(d.competition.campaign.drive, limits or limits_of(d.readings), most)
    with threadpool_limits(1, user_api="blas"):
        view = prospect(d, fits, runs)
        if view is None:
            return NextRuns(d, {}, (), "The case has an effect that further runs would not show.")
        found = []
        for number, run in enumerate(runs):
            pairs = view.gains(view.rows.run_index == number)
            if np.isfinite(list(pairs.values())).all():
                found.append((view.mean_gain(pairs, _DECIDED), number, run, pairs))
    # A pair that is decided need not be decided further.
    found.sort(key=lambda f: (-f[0], f[1]))
    ranked = tuple(Suggested(run, view.mean_gain(pairs), pairs) for _, _, run, pairs in found)
    shares = dict(zip(view.names, view.share.tolist(), strict=True))
    twins = tuple(p for p in combinations(view.names, 2) if p[1] in TWINS.get(p[0], []))
    if not found:
        return NextRuns(d, shares, (), "None of the runs within the limits has a solution.", twins)
    if found[0][0] < _HARDLY:
        why = "No run within the limits can decide; knowledge from outside the readings can."
        return NextRuns(d, shares, (), why, twins)
    return NextRuns(d, shares, ranked, "", twins)


def next_run(d: Diagnosis) -> dict[str, Any] | None:
    """The best run for rivals, as the answer's document has it; None where there are none."""
    if d.competition.campaign.drive.kind != "ball_drive":
        return None  # how far a torsion spring may be loaded is not known
    if not d.verdict.rivals:
        return None
    found = ranked(d)
    return found.best.to_dict() if found.best else None


# --- what is open -------------------------------------------------------------------------


def open_hypotheses(d: Diagnosis) -> dict[str, tuple[Fit, float]]:
    """By name, each hypothesis that is open as it was fitted, with its log odds.

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
    if groups:
        return found
    top = max(odds.values())
    near = sorted((n for n in fits if odds[n] > top - _OPEN), key=lambda n: -odds[n])
    if near[0] and set(near[0]) <= set(PRIORS):
        # Without effects it is the same model, only that the number may not move as far.
        near = [n for n in near if n]
    return {" + ".join(n) or "nothing": (fits[n], odds[n]) for n in near[:_MOST_OPEN]}


def prospect(
    d: Diagnosis, fits: Mapping[str, tuple[Fit, float]], runs: Sequence[PlannedRun]
) -> Prospect | None:
    """What some hypotheses predict for some runs; None where the case cannot show them all."""
    rows = Plan.of_runs(runs).rows
    u = np.ones(len(rows))
    campaign = Campaign.of(d.case, replace(rows, u_elastic_angle_arcsec=u))
    c = d.competition.campaign
    campaign = replace(campaign, own=c.own, candidates=c.candidates, effects=c.effects)
    plan = Fitter(campaign)
    if plan.effects != d.competition.fitter.effects:
        return None
    seen = [_predicted(plan, fit) for fit, _ in fits.values()]
    odds = np.array([value for _, value in fits.values()])
    share = np.exp(odds - odds.max())
    return Prospect(
        names=tuple(fits),
        share=share / share.sum(),
        rows=campaign.rows,
        means=tuple(mean for mean, _ in seen),
        roots=tuple(root for _, root in seen),
        noise=d.after.noise,
        u_arcsec=float(np.median(d.competition.campaign.u_arcsec)),
    )


def _predicted(plan: Fitter, fit: Fit) -> tuple[Floats, Floats]:
    """Angles at all rows, and what the fit's own uncertainty makes of them, arcsec."""
    indices = [u.index for u in fit.unknowns]
    point = plan.model.at(fit.point.values, indices)
    by = np.array([fit.value(u) if u.log else 1.0 for u in fit.unknowns])
    size, axes = np.linalg.eigh(fit.covariance)
    root = axes * np.sqrt(np.maximum(size, 0.0))
    slopes = np.where(np.isfinite(point.slopes), point.slopes, 0.0) * by
    return point.angle_arcsec, slopes @ root
