"""The answer: everything a diagnosis found, as an object, as text and as one JSON document.

Diagnosis   the answer with all it rests on
Rung        one step of the ladder of errors
SCHEMA      name and version of the JSON document
"""

from __future__ import annotations

import json
import os
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.diagnosis.alternatives import moved, smallest
from cbpt.lab.diagnosis.noise_statement import noise_floor, noise_of
from cbpt.lab.diagnosis.sentence import sentence
from cbpt.lab.inference.estimates import parameters_of
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.prediction import AtLoad, angle_at, load_of_choice
from cbpt.lab.inference.residuals import without_zeros
from cbpt.lab.inference.results import Results, results_of
from cbpt.lab.model.priors import CLASSES, PRIORS
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.decision import Verdict
from cbpt.lab.selection.linear_screen import Screen
from cbpt.lab.selection.model_comparison import Competition
from cbpt.lab.wording.versions import versions

Floats = NDArray[np.float64]
SCHEMA = "cbpt.diagnosis/1"
FAR_BELOW = 0.8
LOOSE = (
    "Held out, numbers are refitted to the other readings and an effect may depart a little from "
    "its form; far below in sample it says that the form does not hold."
)
"""What an error held out far below the one in sample means."""


@dataclass(frozen=True)
class Rung:
    """The error after one more thing was added to the model."""

    added: str
    """Empty for the drive exactly as stated."""
    rmse_arcsec: float
    held_out_rmse_arcsec: float
    chi2_per_dof: float
    of_effects: bool = False
    """Whether the model has effects by name."""

    @property
    def loose(self) -> bool:
        """Whether the error held out is far below the one in sample."""
        return self.of_effects and self.held_out_rmse_arcsec < FAR_BELOW * self.rmse_arcsec


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The answer. `to_dict` is the JSON document; `report` says the same in words."""

    case: Case | Drive
    readings: Readings
    """Those that were judged, shape (n,)."""
    competition: Competition = field(repr=False)
    verdict: Verdict
    before: Fit = field(repr=False)
    """The drive exactly as stated, but for the zero."""
    after: Fit = field(repr=False)
    """The best that the answer offers."""
    ladder: tuple[Rung, ...]
    reached: int
    """Rung of the model that the answer offers."""
    held_out_by: str
    fold: NDArray[np.int64] = field(repr=False)
    notes: tuple[str, ...]
    seed: int

    # --- what a picture needs ---

    @property
    def sentence(self) -> str:
        """The answer as an engineer would write it."""
        return sentence(self)

    @property
    def model_before_arcsec(self) -> Floats:
        """The drive as stated, with the best zero, shape (n,)."""
        return self.readings.elastic_angle_arcsec - self.before.residual_arcsec

    @property
    def model_after_arcsec(self) -> Floats:
        """The model the answer offers, shape (n,)."""
        return self.readings.elastic_angle_arcsec - self.after.residual_arcsec

    @property
    def residual_before_arcsec(self) -> Floats:
        """Shape (n,); zeros of runs taken off where the noise has them."""
        c = self.competition.campaign
        return without_zeros(c, self.before.residual_arcsec, self.noise)

    @property
    def residual_after_arcsec(self) -> Floats:
        """Shape (n,); zeros of runs taken off where the noise has them."""
        c = self.competition.campaign
        return without_zeros(c, self.after.residual_arcsec, self.noise)

    @property
    def noise(self) -> Noise:
        """The noise of the answer, through which all models are looked at: a fit without an effect
        may take the effect for noise."""
        return self.after.noise if self.verdict.pattern is None else self.verdict.pattern.noise

    @property
    def noise_floor_arcsec(self) -> float | None:
        """The error that noise alone leaves, beside zeros of runs; None where the answer does not
        hold all that is at work."""
        return noise_floor(self)[0]

    @property
    def ladder_says(self) -> str | None:
        """What to know to read the ladder; None where nothing on it is odd."""
        return LOOSE if any(rung.loose for rung in self.ladder) else None

    @property
    def final_rung(self) -> Rung:
        """The rung of the model that the answer offers."""
        return self.ladder[self.reached]

    # --- results ---

    def predict(
        self,
        torque_Nm: ArrayLike,
        preload_N: ArrayLike | None = None,
        input_angle_deg: ArrayLike = 0.0,
    ) -> AtLoad:
        """The elastic angle of the drive under loads of choice, with its standard uncertainty.

        Of the drive itself: gains and zeros of the instruments are left out. Loads broadcast.
        """
        rivals = {}
        for group in self.verdict.rivals:
            for rival in set(group) - set(self.verdict.names):
                rest = set(self.verdict.names) - set(group)
                names = tuple(sorted({*rest, rival}))
                if names in self.competition.fits:
                    rivals[" + ".join(names)] = self.competition.fits[names]
        named = " + ".join(self.verdict.names)
        for number, other in enumerate(self.after.others, 2):
            rivals[f"{named}, solution {number}"] = other
        return angle_at(
            self.competition.fitter,
            self.after,
            torque_Nm,
            preload_N,
            input_angle_deg,
            why_no_u=self._why_no_u,
            rivals=dict(sorted(rivals.items())),
        )

    def results(
        self,
        torque_Nm: ArrayLike | None = None,
        preload_N: ArrayLike | None = None,
        input_angle_deg: ArrayLike | None = None,
    ) -> Results:
        """Every number of the answer with its uncertainty and what it rests on.

        With a torque, or one in `[load]` of the case, the elastic angle there is among them.
        """
        load = load_of_choice(self.case, torque_Nm, preload_N, input_angle_deg)
        final = self.final_rung
        return results_of(
            self.competition.fitter,
            self.after,
            (
                ("rmse as stated", self.ladder[0].rmse_arcsec),
                ("rmse of the answer", final.rmse_arcsec),
                ("rmse of the answer, held out", final.held_out_rmse_arcsec),
            ),
            self.predict(*load) if load else None,
            self._why_no_u or "",
        )

    @property
    def _why_no_u(self) -> str | None:
        if self.verdict.pattern is None:
            return None
        return "something is at work that the model does not hold"

    # --- parts of the document ---

    def parameters(self, fit: Fit, effect: str) -> dict[str, dict[str, Any]]:
        """Values of an effect's parameters in a fit, SI, with standard uncertainties."""
        return parameters_of(fit, effect)

    def ranking(self) -> list[dict[str, Any]]:
        """Every single effect that was fitted, the most probable first."""
        c = self.competition
        total = log_total(c)
        # Signatures as the drive without effects shows them, looked at through the final noise.
        null = c.fitter.look(c.fits[()], self.after.noise)
        screen = Screen(null, c.library.about(null, c.names, secants=False))
        best = self.verdict.names
        rows = []
        singles = sorted((n for n in c.fits if len(n) == 1), key=lambda n: -c.log_odds[n])
        from cbpt.lab.inference.cross_validation import held_out_residual, rms

        for names in singles:
            fit, effect = c.fits[names], names[0]
            seen = c.fitter.look(fit, self.noise)
            member = _member(screen, fit)
            rival, correlation = _rival(screen, member, c)
            rows.append(
                {
                    "effect": effect,
                    "class": CLASSES.get(effect, "effect"),
                    "parameters": self.parameters(fit, effect),
                    "held_out_rmse_arcsec": rms(held_out_residual(c.fitter, seen, self.fold)),
                    "p_value": c.p_value(names),
                    "probability": float(np.exp(c.log_odds[names] - total)),
                    "surviving_fraction": _surviving(screen, member),
                    "rival": rival,
                    "rival_correlation": correlation,
                    "in_answer": effect in best,
                }
            )
        return rows

    def detectable(self) -> list[dict[str, Any]]:
        """The smallest size of each effect that these readings would have shown, about the final
        fit.
        """
        return [
            {"effect": one.effect, "smallest": {one.name: one.value} | one.shapes}
            for one in smallest(self)
        ]

    def unknown(self) -> dict[str, Any] | None:
        """What the misfit depends on, where nothing in the library explains it."""
        pattern = self.verdict.pattern
        if pattern is None:
            return None
        from cbpt.lab.diagnosis.unexplained import card

        return card(self)

    def next_run(self) -> dict[str, Any] | None:
        """The run that would decide between rivals: peak torque, preload, input angle, what it
        separates, and the log odds it is expected to bring; None where there are no rivals."""
        from cbpt.lab.experiment.expected_gain import next_run

        return next_run(self)

    def where(self) -> list[dict[str, Any]]:
        """Regions where the drive as stated fails."""
        from cbpt.lab.selection.scan import find_regions

        rng = np.random.default_rng([self.seed, 1])
        fit = self.before
        model = self.competition.fitter.model
        regime = model.regimes(model.neutral)
        regions = find_regions(
            self.readings, fit.residual_arcsec, fit.whitener, fit.margin.x, regime, rng
        )
        return [r.to_dict() for r in regions]

    def to_dict(self) -> dict[str, Any]:
        """The JSON document as plain values."""
        return deepcopy(self._document)

    @cached_property
    def _document(self) -> dict[str, Any]:
        v, c = self.verdict, self.competition
        return {
            "schema": SCHEMA,
            "seed": self.seed,
            "versions": versions(),
            "data_sha256": self.readings.sha256,
            "source": self.readings.source,
            "readings": len(self.readings),
            "verdict": {
                "kind": v.kind,
                "effects": list(v.effects),
                "rivals": [list(g) for g in v.rivals],
                "probability": v.probability,
                "sentence": self.sentence,
                "within_stated_uncertainty": v.within_uncertainty,
                "rests_on": [
                    {
                        "number": r.number,
                        "prior": r.prior,
                        "needed_shift_sigma": r.needed_shift_sigma,
                    }
                    for r in v.rests_on
                    if r.number not in v.effects
                ],
            },
            "noise": noise_of(self),
            "before": self._errors(self.ladder[0]),
            "after": self._errors(self.final_rung),
            "where": self.where(),
            "ranking": self.ranking(),
            "ladder": [
                {
                    "added": r.added,
                    "rmse_arcsec": r.rmse_arcsec,
                    "held_out_rmse_arcsec": r.held_out_rmse_arcsec,
                    "chi2_per_dof": r.chi2_per_dof,
                }
                for r in self.ladder
            ],
            "held_out_by": self.held_out_by,
            "ladder_says": self.ladder_says,
            "results": self.results().to_list(),
            "parameters": {e: self.parameters(self.after, e) for e in v.names},
            "moved": list(moved(self)),
            "detectable": self.detectable(),
            "unknown": self.unknown(),
            "next_run": self.next_run(),
            "priors": {PRIORS[e]: sd for e, sd in c.campaign.priors.items()},
            "prior_odds": prior_odds(),
            "notes": list(self.notes),
        }

    def _errors(self, rung: Rung) -> dict[str, Any]:
        floor, of = noise_floor(self)
        return {
            "rmse_arcsec": rung.rmse_arcsec,
            "held_out_rmse_arcsec": rung.held_out_rmse_arcsec,
            "chi2_per_dof": rung.chi2_per_dof,
            "noise_floor_arcsec": floor,
            "noise_floor_of": of,
        }

    def to_json(self) -> str:
        """The document as text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw readings, model before and after, residuals and ladder to an SVG, PNG or PDF file.

        Needs matplotlib: `pip install "cbpt[plot]"`.
        """
        from cbpt.figures.diagnosis import draw_diagnosis

        draw_diagnosis(self, path)

    def report(self) -> str:
        """The answer in words and tables."""
        from cbpt.lab.diagnosis.report import lines

        return "\n".join(lines(self))

    def __repr__(self) -> str:
        return self.report()


def prior_odds() -> dict[str, float]:
    """Prior odds against nothing, as used; `other` stands for effects not listed."""
    from cbpt.lab.model.priors import ODDS

    return {name or "other": odds for name, odds in ODDS.items()}


def log_total(c: Competition) -> float:
    """Logarithm of the sum of all odds."""
    all_odds = np.array([*c.log_odds.values(), *c.pattern_log_odds[:1]])
    top = float(all_odds.max())
    return top + float(np.log(np.exp(all_odds - top).sum()))


def _member(screen: Screen, fit: Fit) -> int | None:
    """The signature nearest to a fit's shapes."""
    variant = fit.hypothesis.variants[0]
    shapes = {
        u.name.partition(".")[2]: fit.value(u)
        for u in fit.unknowns
        if u.name.startswith(variant.effect + ".")
    }
    found = [
        (sum(abs(np.log(max(shapes.get(n, v), 1e-300) / v)) for n, v in s.shapes.items()), m)
        for m, s in enumerate(screen.signatures)
        if s.variant == variant and screen.usable(m)
    ]
    return min(found)[1] if found else None


def _surviving(screen: Screen, member: int | None) -> float | None:
    return None if member is None else float(screen.surviving[screen.places[member]].max())


def _rival(screen: Screen, member: int | None, c: Competition) -> tuple[str | None, float | None]:
    """The other effect whose signature looks most like this one after the refit."""
    if member is None or screen.signatures[member].variant.spread:
        return None, None
    own = screen.places[member]
    best: tuple[str | None, float | None] = (None, None)
    for m, s in enumerate(screen.signatures):
        same = s.variant.effect == screen.signatures[member].variant.effect
        # A lot of balls can look like nearly everything, so it says nothing as a rival.
        if same or s.variant.spread or not screen.usable(m):
            continue
        place = screen.places[m]
        a = np.linalg.cholesky(screen.gram[own, own])
        b = np.linalg.cholesky(screen.gram[place, place])
        cross = np.linalg.solve(a, np.linalg.solve(b, screen.gram[place, own]).T)
        correlation = float(min(np.linalg.svd(cross, compute_uv=False)[0], 1.0))
        if best[1] is None or correlation > best[1]:
            best = (s.variant.effect, correlation)
    return best
