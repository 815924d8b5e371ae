"""What a further run is expected to bring to hypotheses that are open.

    OpenHypotheses    hypotheses as they were fitted, with their odds
    Prospect          what they predict for some runs, and the log odds to be expected from each
    prospect          makes it
    lacking           effects that runs cannot show, where no prospect can be made
    Suggested         a run with what it is expected to bring

Each hypothesis, as it was fitted, predicts what a further run would read: a normal distribution,
whose mean is the model at the most probable values and whose covariance is the noise, an offset of
its own for the run, and what the fit still does not know of its parameters. If A is true, a run is
expected to bring log odds of A against B equal to the divergence of their predictions (Kullback and
Leibler 1951); A is true with its posterior probability. Parameters enter linearised about the fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.lab.covariance.linear_gaussian import Noise, Rows
from cbpt.lab.covariance.symmetric import eigen
from cbpt.lab.experiment.candidates import described, duration_s, in_words
from cbpt.lab.experiment.plan import Plan, PlannedRun
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.selection.rules import RULES

Floats = NDArray[np.float64]
LIMIT = RULES.log_rival_odds
"""Log odds that decide between two hypotheses."""
_OPTIONAL = ("time_s", "temperature_degC", "cycle")
"""Columns of a table that effects depend on where they are there."""
DECIDED = 5.0
"""Log odds from which a pair counts as decided and need not be decided further."""
# Spread of the offset of a further run over the noise: it is not known at all.
_ZERO_PER_U = 100.0


@dataclass(frozen=True)
class Suggested:
    """One run with what it is expected to bring."""

    run: PlannedRun
    gain: float
    """Log odds of what is true against the others, on average over what may be true, each pair
    counted up to `DECIDED`: runs are ranked by it."""
    pairs: Mapping[tuple[str, str], float]
    """The same for each two hypotheses."""

    @property
    def largest_gain(self) -> float:
        """That of the two hypotheses that it tells apart best."""
        return max(self.pairs.values())

    def against(self, name: str) -> dict[str, float]:
        """The same of one hypothesis against each other one."""
        pairs = self.pairs.items()
        return {b if a == name else a: gain for (a, b), gain in pairs if name in (a, b)}

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
            "in_words": in_words(self.run),
            "duration_s": duration_s(self.run),
            "separates": self.separates,
            "gain": self.gain,
            "largest_gain": self.largest_gain,
        }


@dataclass(frozen=True, eq=False)
class OpenHypotheses:
    """Hypotheses between which readings could not decide."""

    case: Case | Drive
    fitter: Fitter
    """Of the readings."""
    noise: Noise
    """That further runs are expected to have."""
    fits: Mapping[str, tuple[Fit, float]]
    """By name: each as it was fitted, with its log odds."""

    def __len__(self) -> int:
        return len(self.fits)


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

    def mean_gain(self, pairs: Mapping[tuple[str, str], float]) -> float:
        """Of what is true against the others, each weighed by its probability and counted up to
        `DECIDED`: far beyond the readings a line through what a model says there says anything."""
        weights = [
            self.share[self.names.index(a)] * self.share[self.names.index(b)] for a, b in pairs
        ]
        gains = np.minimum(np.array(list(pairs.values())), DECIDED)
        return float(np.average(gains, weights=np.array(weights) + 1e-300))

    def _noise(self, run: NDArray[np.int64]) -> Floats:
        same = run[:, None] == run[None, :]
        place = np.arange(len(run))
        apart = np.abs(place[:, None] - place[None, :])
        correlated = np.where(same, float(self.noise.correlation) ** apart, 0.0)
        size = self.noise.scale * self.u_arcsec
        offset = max(_ZERO_PER_U * size, self.noise.offset_arcsec)
        return np.asarray(size**2 * correlated + offset**2 * same)


def _divergence(one: tuple[Floats, Floats], other: tuple[Floats, Floats]) -> float:
    """Of two normal distributions (mean, covariance), the first being true."""
    (m, a), (n, b) = one, other
    inverse = np.linalg.inv(b)
    off = m - n
    volume = np.linalg.slogdet(b)[1] - np.linalg.slogdet(a)[1]
    return float(0.5 * (np.sum(inverse * a.T) - len(m) + volume + off @ inverse @ off))


def prospect(hypotheses: OpenHypotheses, runs: Sequence[PlannedRun]) -> Prospect | None:
    """What some hypotheses predict for some runs; None where the case cannot show them all."""
    plan, c = _planned(hypotheses, runs), hypotheses.fitter.campaign
    if plan.effects != hypotheses.fitter.effects:
        return None
    seen = [_predicted(plan, fit) for fit, _ in hypotheses.fits.values()]
    odds = np.array([value for _, value in hypotheses.fits.values()])
    share = np.exp(odds - odds.max())
    return Prospect(
        names=tuple(hypotheses.fits),
        share=share / share.sum(),
        rows=plan.campaign.rows,
        means=tuple(mean for mean, _ in seen),
        roots=tuple(root for _, root in seen),
        noise=hypotheses.noise,
        u_arcsec=float(np.median(c.u_arcsec)),
    )


def lacking(hypotheses: OpenHypotheses, runs: Sequence[PlannedRun]) -> dict[str, str]:
    """Effects that the readings could show and some runs cannot, each with the column that the runs
    lack; empty where it is another reason.
    """
    there = set(_planned(hypotheses, runs).effects)
    needs = {v.effect: v.needs for v in hypotheses.fitter.variants if v.needs}
    return {e: needs.get(e, "") for e in hypotheses.fitter.effects if e not in there}


def _planned(hypotheses: OpenHypotheses, runs: Sequence[PlannedRun]) -> Fitter:
    """The model of the readings for further runs; columns that the readings lack stay away."""
    c = hypotheses.fitter.campaign
    rows = Plan.of_runs(runs).rows
    unseen: dict[str, Any] = {name: None for name in _OPTIONAL if getattr(c.readings, name) is None}
    rows = replace(rows, u_elastic_angle_arcsec=np.ones(len(rows)), **unseen)
    campaign = Campaign.of(hypotheses.case, rows)
    return Fitter(replace(campaign, own=c.own, candidates=c.candidates, effects=c.effects))


def _predicted(plan: Fitter, fit: Fit) -> tuple[Floats, Floats]:
    """Angles at all rows, and what the fit's own uncertainty makes of them, arcsec."""
    indices = [u.index for u in fit.unknowns]
    point = plan.model.at(fit.point.values, indices)
    by = np.array([fit.value(u) if u.log else 1.0 for u in fit.unknowns])
    size, axes = eigen(fit.covariance)
    root = axes * np.sqrt(np.maximum(size, 0.0))
    slopes = np.where(np.isfinite(point.slopes), point.slopes, 0.0) * by
    return point.angle_arcsec, slopes @ root
