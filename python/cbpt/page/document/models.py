"""Models of one table as the page shows them: what was fitted, and any further choice of effects.

    Models     the fits of a diagnosis, each an entry of the document; further ones start from them

All rows of the table are predicted, those too that a diagnosis of a long table did not look at.
Every error is that of the readings that the diagnosis judged, as in its sentence.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.diagnosis.fit_text import parameter_words
from cbpt.lab.diagnosis.fitted import case_with
from cbpt.lab.diagnosis.ranking import probabilities
from cbpt.lab.diagnosis.sentence import name_of
from cbpt.lab.inference.cross_validation import held_out_residual, rms
from cbpt.lab.inference.estimates import parameters_of
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.prediction import Load as Asked
from cbpt.lab.inference.prediction import around_loop
from cbpt.lab.inference.residuals import chi2_of, rmse_of, without_offsets, zero_per_run
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.setting import Names
from cbpt.lab.wording.names import tell_tale
from cbpt.lab.wording.numbers import display
from cbpt.page.document.bench import Bench
from cbpt.page.document.curves import Curves
from cbpt.page.document.drive import load_of
from cbpt.page.document.drive_types import Load, Loop
from cbpt.page.document.plain import array, finite_numbers, numbers
from cbpt.page.document.stated import (
    STATED,
    UNKNOWN,
    best_zeros,
    free_function,
    key_of,
    rows_of,
    stop_if_taken,
)
from cbpt.page.document.types import Choice, FittedNumber, Model, Parameter, Role, Rung

Floats = NDArray[np.float64]

ROUGH = "the search did not converge"
"""Of a fit whose numbers are not told to an uncertainty."""


class Models:
    """The models of a diagnosis on all rows of its table. One caller at a time; others wait."""

    def __init__(self, diagnosis: Diagnosis, readings: Readings) -> None:
        self.diagnosis = diagnosis
        self.readings = readings
        c = diagnosis.competition.campaign
        self.used = np.isin(readings.line, c.readings.line)
        """Rows that were judged, shape (n,)."""
        whole = c if self.used.all() else campaign_of(diagnosis.case, readings, ())
        self._whole = whole
        runs = whole.rows.run_index
        judged = np.isin(runs, runs[self.used])
        self._telling = self.used | ~judged
        """Rows that tell the zero of their run: those that were judged, or all where none was."""
        self._bench = Bench.of_diagnosis(diagnosis)
        self._chances = probabilities(diagnosis.competition)
        self._own: tuple[tuple[OwnEffect, ...], Bench | None] = ((), None)
        self._assembled: dict[int, Assembled] = {}
        self._lock = threading.Lock()
        nominal = self._bench.fitter.look(diagnosis.before, self._bench.noise)
        self._stated = self.predicted(self._bench, nominal)
        after = self._bench.fitter.look(diagnosis.after, self._bench.noise)
        self.zero = self._zeros(after)
        """The offset of the run of each reading by the answer, shape (n,)."""
        self._curves = Curves(readings)
        self._load = load_of(diagnosis.case, readings)

    # --- entries of the document ---

    def entries(self) -> Iterator[Model]:
        """What the diagnosis fitted: as stated, refitted, then sets, the most probable first."""
        d, c = self.diagnosis, self.diagnosis.competition
        yield self._entry(STATED, "stated", "the drive as stated", (), self._bench, d.before)
        for names in sorted(c.fits, key=lambda n: (len(n) > 0, -c.log_odds[n])):
            yield self._of_set(names, self._bench, self._bench.fit(names))
        for number in self.numbers_named:
            yield self._of_set((number,), self._bench, self._bench.fit([number]))
        if d.verdict.lack_of_fit is not None:
            yield self._of_pattern()

    @property
    def numbers_named(self) -> list[str]:
        """Numbers of drive and rig that the answer names without a fit of their own, as it weighs
        how far they move within what is stated; their fits leave them free."""
        d = self.diagnosis
        named = [*d.verdict.effects, *(effect for group in d.verdict.rivals for effect in group)]
        known = {v.effect for v in self._bench.fitter.variants}
        fits = d.competition.fits
        return [n for n in named if n in PRIORS and n in known and (n,) not in fits]

    def _of_set(self, names: Names, bench: Bench, fit: Fit) -> Model:
        label = " + ".join(name_of(self.diagnosis, n) for n in names) or "parameters refitted"
        return self._entry(key_of(names), self._role(names, bench), label, names, bench, fit)

    def _entry(
        self, key: str, role: Role, label: str, effects: Sequence[str], bench: Bench, fit: Fit
    ) -> Model:
        c = self.diagnosis.competition
        # One noise judges all, as in the ladder; the numbers of a fit stay its own.
        look = bench.fitter.look(fit, self.diagnosis.noises.of(effects))
        model = self.predicted(bench, look)
        # Runs with offsets of their own are drawn on top of each other.
        level = self._whole.y_arcsec - self.zero
        left = self._left(self._whole.y_arcsec - model, look.noise)
        entry = rows_of(key, role, label, effects, level, level - left)
        held = held_out_residual(bench.fitter, look, self.diagnosis.fold)
        names = tuple(effects)
        known = key != STATED and bench is self._bench and names in c.log_odds
        own, kind = bench.fitter.campaign.own, c.campaign.drive.kind
        text, why = self._case(bench, fit) if key != STATED else (None, None)
        return entry | {
            "rmse_arcsec": rmse_of(bench.fitter.campaign, look),
            # The folds are refitted by one linear step, which means nothing far from the best.
            "held_out_rmse_arcsec": rms(held) if fit.converged else None,
            "chi2_per_dof": chi2_of(bench.fitter, look),
            "zero_arcsec": float(look.offsets_arcsec[0]) if len(look.offsets_arcsec) == 1 else None,
            "parameters": list(_parameters(bench.fitter.campaign, fit, effects)),
            "numbers": list(_numbers(fit)),
            "probability": self._chances[names] if known else None,
            "tell_tale": " ".join(
                str(own[e].expression) if e in own else tell_tale(e, kind) for e in effects
            ),
            "signature_arcsec": numbers(model - self._stated) if key != STATED else None,
            "converged": fit.converged,
            "case_text": text,
            "why_no_case": why,
            "loop": self._loop(bench, fit, self._load),
        }

    def _case(self, bench: Bench, fit: Fit) -> tuple[str | None, str | None]:
        """The case with effects and refitted numbers in it, as `cbpt fit` writes it, or why not."""
        case = self.diagnosis.case
        if isinstance(case, Drive):
            case = Case.from_toml(case.to_toml())
        try:
            text = case_with(case, bench.fitter, fit).to_toml()
        except InvalidInputError as error:  # an effect that is a function of Python
            return None, str(error)
        return text, None

    def predicted(self, bench: Bench, fit: Fit) -> Floats:
        """A fit at every row of the table, with its zeros, shape (n,)."""
        model = np.empty(len(self.readings))
        if not self.used.all():
            angle = self._model(bench).at(fit.point.values).angle_arcsec
            model = angle + self._offsets(fit, angle)
        model[self.used] = bench.fitter.campaign.y_arcsec - fit.residual_arcsec
        return model

    def _offsets(self, fit: Fit, angle: Floats) -> Floats:
        """The zero of each row: that of the fit; of a run that was not judged the one that fits
        best, shape (n,)."""
        if not self._whole.zero_per_run:
            return np.full(len(angle), fit.offsets_arcsec[0])
        runs = self._whole.rows.run_index
        zero = best_zeros(self._whole, angle)
        zero[runs[self.used]] = fit.offsets_arcsec[self._bench.fitter.campaign.rows.run_index]
        return np.asarray(zero[runs])

    def _left(self, residual: Floats, noise: Noise) -> Floats:
        """A residual without the offset of each run, where runs have their own; of readings that
        were judged as the diagnosis has it, through a noise of it."""
        d = self.diagnosis
        left = residual.copy()
        left[self.used] = without_offsets(d.competition.campaign, residual[self.used], noise)
        if zero_per_run(d.competition.campaign, d.noise):
            there = np.isfinite(residual) & self._telling
            weight = np.where(there, self._whole.u_arcsec**-2.0, 0.0)
            if d.noise.inflation is not None:
                weight[self.used] /= d.noise.inflation**2
            index = self._whole.rows.run_index
            total = np.bincount(index, weight * np.nan_to_num(residual))
            offset = total / np.maximum(np.bincount(index, weight), 1e-300)
            left[~self.used] -= offset[index[~self.used]]
        return left

    def _zeros(self, fit: Fit) -> Floats:
        """The offset of the run of each reading, fitted to it or part of the noise."""
        residual = self._whole.y_arcsec - self.predicted(self._bench, fit)
        zero = residual - self._left(residual, self.diagnosis.noise)
        if self._whole.offsets.shape[1] > 1:
            if self.used.all():
                zero = zero + self._whole.offsets @ fit.offsets_arcsec
            else:
                angle = self._model(self._bench).at(fit.point.values).angle_arcsec
                zero = zero + self._offsets(fit, angle)
        return np.asarray(np.where(np.isfinite(zero), zero, 0.0))

    def _model(self, bench: Bench) -> Assembled:
        """The model of a bench at every row of the table, whatever it was asked before."""
        if id(bench) not in self._assembled:
            c = bench.fitter.campaign
            whole = replace(self._whole, own=c.own, candidates=c.candidates, effects=c.effects)
            self._assembled[id(bench)] = Assembled(whole, bench.fitter.effects)
        self._assembled[id(bench)].cold()
        return self._assembled[id(bench)]

    def regimes(self) -> list[str]:
        """Contact regime of each row, of the drive as stated."""
        fitter = self._bench.fitter
        model = fitter.model if self.used.all() else self._model(self._bench)
        return list(model.regimes(model.neutral).tolist())

    def _role(self, names: Names, bench: Bench) -> Role:
        v = self.diagnosis.verdict
        if not names:
            return "refitted"
        if set(names) & {v.effect for v in bench.fitter.campaign.candidates}:
            return "own"
        if names == v.names and v.kind not in ("unknown", "undecided"):
            return "answer"
        rivals = {effect for group in v.rivals for effect in group}
        return "rival" if len(names) == 1 and names[0] in rivals else "candidate"

    def _of_pattern(self) -> Model:
        """What is left without a name, followed as closely as it can be; no model of it."""
        d = self.diagnosis
        pattern = d.verdict.lack_of_fit
        assert pattern is not None
        model = np.full(len(self.readings), np.nan)
        residual = pattern.problem.residual(pattern.amplitude, pattern.noise)
        model[self.used] = d.competition.campaign.y_arcsec - residual
        label = free_function(pattern.columns)
        level = self._whole.y_arcsec - self.zero
        left = self._left(self._whole.y_arcsec - model, pattern.noise)
        entry = rows_of(UNKNOWN, "unknown", label, (), level, level - left)
        return entry | {
            "held_out_rmse_arcsec": d.ladder[-1].held_out_rmse_arcsec,
            "chi2_per_dof": d.ladder[-1].chi2_per_dof,
            "probability": d.verdict.probability if d.verdict.kind == "unknown" else None,
            "signature_arcsec": numbers(model - self._stated),
            "why_no_case": "no known effect explains this misfit: a case file cannot hold it",
        }

    # --- further choices ---

    def choice(self, effects: Sequence[str], step: Callable[[], None] = lambda: None) -> Choice:
        """The model with these effects, fitted now where nobody has: `model`, its lines in the
        order of `curves`, and the ladder that leads to it in the order given.

        step: called between two fits; what it raises ends the work.

        Raises `InvalidInputError` for an effect that is not known or cannot be seen in this table.
        """
        wanted = list(dict.fromkeys(effects))
        with self._lock, one_blas_thread():
            bench = self._bench_for(wanted)
            ladder = []
            for n in range(len(wanted) + 1):
                step()
                ladder.append(self._rung(bench, wanted[:n]))
            step()
            entry = self._of_set(tuple(sorted(wanted)), bench, bench.fit(wanted))
            curves = self._curves.of(array(entry["model_arcsec"]))
            return {"model": entry, "curves": curves, "ladder": ladder}

    def loop(self, effects: Sequence[str], load: Load) -> Loop | None:
        """The drive with these effects along a loop at a load of choice."""
        wanted = list(dict.fromkeys(effects))
        with self._lock, one_blas_thread():
            bench = self._bench_for(wanted)
            return self._loop(bench, bench.fit(wanted), load)

    def _loop(self, bench: Bench, fit: Fit, load: Load) -> Loop | None:
        try:
            torque, angle, u = around_loop(bench.fitter, fit, Asked(**load))
        except InvalidInputError:  # a drive with balls, and nobody knows its preload
            return None
        return {
            "torque_Nm": finite_numbers(torque),
            "elastic_angle_arcsec": numbers(angle),
            "u_arcsec": numbers(u) if fit.unknowns and fit.converged else None,
        }

    def add_own(self, effect: OwnEffect) -> None:
        """An effect of the user's own, in place of an earlier one of its id.

        Raises `InvalidInputError` where it cannot be fitted or has the id of another effect.
        """
        stop_if_taken(effect.id)
        own = (*(e for e in self._own[0] if e.id != effect.id), effect)
        with self._lock, one_blas_thread():
            bench = self._bench.with_own(self.diagnosis, own)
            self._assembled.clear()
            self._own = own, bench

    @property
    def own(self) -> tuple[OwnEffect, ...]:
        """The user's own effects so far."""
        return self._own[0]

    def _bench_for(self, effects: list[str]) -> Bench:
        own, bench = self._own
        return bench if bench and {e.id for e in own} & set(effects) else self._bench

    def _rung(self, bench: Bench, effects: Sequence[str]) -> Rung:
        """One step of the ladder."""
        look = bench.fitter.look(bench.fit(effects), self.diagnosis.noises.of(effects))
        held = held_out_residual(bench.fitter, look, self.diagnosis.fold)
        return {
            "added": effects[-1] if effects else "",
            "label": effects[-1] if effects else "parameters refitted",
            "key": key_of(effects),
            "effects": list(effects),
            "in_sample_arcsec": rmse_of(bench.fitter.campaign, look),
            "held_out_arcsec": rms(held) if look.converged else None,
            "chi2_per_dof": chi2_of(bench.fitter, look),
        }


def _parameters(campaign: Campaign, fit: Fit, effects: Sequence[str]) -> Iterator[Parameter]:
    """In the unit that people read, with the SI value beside it; without an uncertainty where the
    search was not ended, as the value is then none of its best."""
    rough = {} if fit.converged else {"u": None, "why_no_u": ROUGH}
    for effect in effects:
        for name, found in parameters_of(fit, effect).items():
            p = found | rough
            label, size = display(effect, name)
            named, valued = parameter_words(campaign, (effect, name), p)
            yield {
                "effect": effect,
                "name": label,
                "value": p["value"] / size,
                "u": None if p["u"] is None else p["u"] / size,
                "unit": p["unit"] if size == 1.0 else "",
                "value_SI": p["value"],
                "name_SI": name,
                "at_bound": p["at_bound"],
                "why_no_u": p.get("why_no_u"),
                "text": f"{named} {valued}",
                "value_text": valued,
            }


def _numbers(fit: Fit) -> Iterator[FittedNumber]:
    """Numbers of drive and rig, which move within their stated uncertainties."""
    for u in fit.unknowns:
        if u.name in PRIORS and np.isfinite(u.sd):
            value = fit.value(u)
            yield {
                "number": u.name,
                "stated": u.mean,
                "prior": u.sd,
                "value": value,
                "u": fit.u(u) if fit.converged else None,
                "shift_sigma": (value - u.mean) / u.sd,
            }
