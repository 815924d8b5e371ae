"""The answer: everything a diagnosis found, as an object, as text and as one JSON document.

Diagnosis    the answer: data (`diagnosis_data`), predictions, results, document, text, picture
prior_odds   what the document states of them
SCHEMA       name and version of the JSON document
"""

from __future__ import annotations

import json
import os
from copy import deepcopy
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cbpt.errors import Say
from cbpt.figures.diagnosis import DiagnosisPicture, draw_diagnosis
from cbpt.lab.diagnosis.alternatives import moved, smallest
from cbpt.lab.diagnosis.combinations import Combination, combinations, remains
from cbpt.lab.diagnosis.deciding_runs import RankedRuns, next_run, rank_if_open
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData, Rung
from cbpt.lab.diagnosis.misfit import as_rows, columns_of
from cbpt.lab.diagnosis.noise_statement import noise_floor, noise_of
from cbpt.lab.diagnosis.ranking import ranking
from cbpt.lab.diagnosis.report import label_of, lines, together
from cbpt.lab.diagnosis.sentence import Say as Telling
from cbpt.lab.diagnosis.sentence import sentence
from cbpt.lab.diagnosis.unexplained import card
from cbpt.lab.diagnosis.why import Why, whys
from cbpt.lab.diagnosis.why import sentence as sentence_of_rival
from cbpt.lab.inference.prediction import AtLoad, Load, angle_at, load_of_choice
from cbpt.lab.inference.results import Results, results_of
from cbpt.lab.model.priors import ODDS, PRIORS
from cbpt.lab.readings.points import points_of
from cbpt.lab.selection.posterior import named_of
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.scan import Scanned, find_regions
from cbpt.lab.wording import html
from cbpt.lab.wording.inline import Shown, page
from cbpt.lab.wording.numbers import angle_unit_of, probability, rounded
from cbpt.lab.wording.versions import versions

SCHEMA = "cbpt.diagnosis/2"


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(DiagnosisData):
    """The answer. `to_dict` is the JSON document; `report` says the same in words."""

    @property
    def sentence(self) -> str:
        """The answer as an engineer would write it."""
        return sentence(self)

    def sentence_in(self, angle_unit: str) -> str:
        """The same with angles in another unit: arcsec, arcmin, deg, mrad, urad, rad."""
        return sentence(self, Telling(angle=angle_unit_of(angle_unit)))

    @property
    def noise_floor_arcsec(self) -> float | None:
        """The error that noise alone leaves, beside offsets of runs; None where the answer does not
        hold all that is at work."""
        return noise_floor(self)[0]

    # --- results ---

    def predict(
        self,
        torque_Nm: ArrayLike,
        preload_N: ArrayLike | None = None,
        input_angle_deg: ArrayLike = 0.0,
    ) -> AtLoad:
        """Predict the elastic angle of the drive under loads of choice, with its uncertainty.

        The drive itself is asked: gains and offsets of the instruments are left out.

        Parameters
        ----------
        torque_Nm : array_like
            Torque on the output, N m.
        preload_N : array_like, optional
            Axial preload, N. If it is not given, `[load]` of the case is taken.
        input_angle_deg : array_like
            Angle of the input crank, degrees. The three arrays broadcast to n loads.

        Returns
        -------
        AtLoad
            Elastic angles and standard uncertainties (k = 1) in arcsec, shape (n,); NaN where there
            is none. `inside` says whether a load lies within the readings. While it is undecided
            which effects are at work, the angles are by the most probable combination and have no
            uncertainty; `by_rival_arcsec` has those by the other probable ones.
        """
        probable = {
            named_of(one.effects): None
            for one in self.combinations()
            if one.probability >= RULES.likely
        }
        undecided = self.verdict.kind == "undecided" and bool(probable)
        names = next(iter(probable)) if undecided else self.verdict.names
        rivals = {together(other): self.fit_of(other) for other in probable if other != names}
        for group in self.verdict.rivals:
            for rival in set(group) - set(names):
                other = tuple(sorted({*set(names) - set(group), rival}))
                if other in self.competition.fits:
                    rivals[together(other)] = self.fit_of(other)
        if not undecided:
            for number, mode in enumerate(self.after.other_modes, 2):
                rivals[f"{together(names)}, solution {number}"] = mode
        open_yet = f"which effects are at work is undecided; this is by {together(names)}"
        return angle_at(
            self.competition.fitter,
            self.fit_of(names) if undecided else self.after,
            Load(torque_Nm, preload_N, input_angle_deg),
            why_no_u=open_yet if undecided else self._why_no_u,
            rivals=dict(sorted(rivals.items())),
        )

    def results(
        self,
        torque_Nm: ArrayLike | None = None,
        preload_N: ArrayLike | None = None,
        input_angle_deg: ArrayLike | None = None,
    ) -> Results:
        """List every number of the answer with its uncertainty and what it rests on.

        Parameters
        ----------
        torque_Nm : array_like, optional
            Torques, N m, at which the elastic angle is added to the results. If it is not given,
            `[load]` of the case is taken.
        preload_N : array_like, optional
            Axial preload there, N; else that of the case.
        input_angle_deg : array_like, optional
            Angle of the input crank there, degrees; else that of the case.

        Returns
        -------
        Results
            Rows with value, unit and standard uncertainty; `to_csv`, `to_markdown` and `report`
            write them.
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
            self.predict(load.torque_Nm, load.preload_N, load.input_angle_deg) if load else None,
            self._why_no_u or "",
        )

    @property
    def _why_no_u(self) -> str | None:
        if self.verdict.lack_of_fit is None:
            return None
        return "the model lacks an effect that these readings show"

    # --- parts of the document ---

    def ranking(self) -> list[dict[str, Any]]:
        """Every single effect that was fitted, the most probable first."""
        return ranking(self)

    def combinations(self) -> list[Combination]:
        """The sets of effects that make up 95 % of the posterior, each with its own numbers."""
        return combinations(self)

    def remains(self) -> dict[str, Any] | None:
        """What is left after the answer; None where it is no more than readings scatter by."""
        return remains(self)

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
        lack_of_fit = self.verdict.lack_of_fit
        if lack_of_fit is None:
            return None
        return card(self)

    def next_run(self) -> dict[str, Any] | None:
        """The run that would decide between rivals: peak torque, preload, input angle, what it
        separates, and the log odds it is expected to bring; None where there are no rivals."""
        return next_run(self._runs)

    @cached_property
    def _runs(self) -> RankedRuns | None:
        return rank_if_open(self)

    def why(self) -> list[Why]:
        """The answer against each rival: log odds, and what the readings contribute to them."""
        return list(self._whys)

    @cached_property
    def _whys(self) -> list[Why]:
        return whys(self, self.combinations(), self._runs)

    def where(self) -> list[dict[str, Any]]:
        """Regions where the drive as stated fails."""
        rng = np.random.default_rng([self.seed, 1])
        fit = self.before
        model = self.competition.fitter.model
        regime = model.regimes(model.neutral)
        regions = find_regions(
            Scanned(self.readings, fit.residual_arcsec, fit.whitener, fit.margin.x, regime), rng
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
                "perhaps": [{"effect": e, "probability": p} for e, p in v.perhaps],
                "probability": v.probability,
                "probability_exactly": v.exactly,
                "undecided": v.undecided,
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
            "combinations": [c.to_dict() for c in self.combinations()],
            "remains": self.remains(),
            "why": [w.to_dict() | {"sentence": sentence_of_rival(self, w)} for w in self._whys],
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
            "closing": asdict(self.closing) if self.closing else None,
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

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Column names and rows: each reading with the model before and after, for a table or a CSV
        file."""
        columns = {
            **columns_of(self.readings),
            "model_before_arcsec": self.model_before_arcsec,
            "model_after_arcsec": self.model_after_arcsec,
            "residual_before_arcsec": self.residual_before_arcsec,
            "residual_after_arcsec": self.residual_after_arcsec,
        }
        return as_rows(columns)

    def plot(self, path: str | os.PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw readings, model before and after, residuals and ladder to an SVG, PNG or PDF file.

        Needs matplotlib: `pip install "cbpt[plot]"`.
        """
        # Runs with offsets of their own are drawn on top of each other.
        c = self.competition.campaign
        zero = self.after.residual_arcsec - self.residual_after_arcsec
        if c.offsets.shape[1] > 1:
            zero = zero + c.offsets @ self.after.offsets_arcsec
        level = self.readings.elastic_angle_arcsec - zero
        picture = DiagnosisPicture(
            points=points_of(self.readings, zero),
            model_before_arcsec=level - self.residual_before_arcsec,
            model_after_arcsec=level - self.residual_after_arcsec,
            residual_before_arcsec=self.residual_before_arcsec,
            residual_after_arcsec=self.residual_after_arcsec,
            ladder=self.ladder,
            noise_floor_arcsec=self.noise_floor_arcsec,
            # The numbers of the effects stand in the report; above a picture they are in the way.
            sentence=sentence(self, Telling(aside=lambda _: "", angle=angle_unit_of(angle_unit))),
        )
        draw_diagnosis(picture, path, angle_unit)

    def report(self, say: Say = str, angle_unit: str = "arcsec") -> str:
        """The answer in words and tables, angles in `angle_unit`; `say` says the steps of notes,
        else they are Python."""
        angle = angle_unit_of(angle_unit)
        return "\n".join(lines(self, self._document, self._whys, say, angle))

    def show(self, height_px: int = 800) -> Shown:
        """The page of the answer inside a notebook: no server, no network.

        Needs plotly: `pip install "cbpt[workbench]"`.
        """
        return page(self.case, self.readings, self, height_px)

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        """As a notebook shows it: sentence, combinations, rivals, picture, the report folded."""
        rows = [
            [
                label_of(c.to_dict()),
                probability(c.probability),
                rounded(c.rmse_arcsec),
                rounded(c.held_out_rmse_arcsec),
            ]
            for c in self.combinations()
        ]
        parts = (
            html.paragraph(self.sentence),
            html.table(["effects", "probability", "rmse_arcsec", "held_out_arcsec"], rows),
            html.bullets(sentence_of_rival(self, why) for why in self._whys),
            html.picture(self.plot),
            html.folded("the whole report", self.report()),
        )
        return "".join(parts)


def prior_odds() -> dict[str, float]:
    """Prior odds against nothing, as used; `other` stands for effects not listed."""
    return {name or "other": odds for name, odds in ODDS.items()}
