"""Models of one table as the page shows them: what was fitted, and any further choice of effects.

    stated     the case as it is, without a diagnosis
    Models     the fits of a diagnosis, each an entry of the document; further ones start from them

All rows of the table are predicted, those too that a diagnosis of a long table did not look at.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from cbpt._core import Case, Drive, effect_specs
from cbpt.errors import InvalidInputError
from cbpt.lab.answer import Diagnosis, log_total
from cbpt.lab.assembled import Assembled, Campaign
from cbpt.lab.competition import Competition, Names, start_values
from cbpt.lab.fit import Fit, Hypothesis
from cbpt.lab.holdout import held_out_residual, rms
from cbpt.lab.library import PRIORS
from cbpt.lab.own import campaign_of
from cbpt.lab.readings import Readings
from cbpt.lab.screen import Screen, Signatures
from cbpt.lab.sentence import DISPLAY, name_of, shown
from cbpt.page.plain import finite, numbers

Floats = NDArray[np.float64]

STATED, REFITTED, UNKNOWN = "stated", "refitted", "unknown"
"""Keys of the models that have no effect of their own."""
_TELL_TALES = {spec.id: spec.tell_tale for spec in effect_specs()}


def key_of(effects: Sequence[str]) -> str:
    """The key of the model with some effects."""
    return "+".join(sorted(effects)) or REFITTED


def rows_of(
    key: str, role: str, label: str, effects: Sequence[str], y: Floats, model: Floats
) -> dict[str, Any]:
    """What every entry has: the model and the residual row by row, and the error."""
    residual = y - model
    solved = np.isfinite(residual)
    return {
        "key": key,
        "role": role,
        "label": label,
        "effects": list(effects),
        "model_arcsec": numbers(model),
        "residual_arcsec": numbers(residual),
        "rmse_arcsec": rms(residual[solved]) if solved.any() else None,
        "held_out_rmse_arcsec": None,
        "chi2_per_dof": None,
        "zero_arcsec": None,
        "parameters": [],
        "numbers": [],
        "probability": None,
        "tell_tale": "",
        "signature_arcsec": None,
        "converged": True,
    }


def stated(case: Case | Drive, readings: Readings) -> tuple[dict[str, Any], Floats, list[str]]:
    """The case as it is, but for the best zero: its entry, the model row by row, its regimes."""
    from cbpt.lab.added import predicted

    found = predicted(case, readings)
    campaign = campaign_of(case, readings, ())
    model, zero = _with_zeros(campaign, found.elastic_angle_arcsec)
    entry = rows_of(STATED, "stated", "the drive as stated", (), campaign.y_arcsec, model)
    entry["zero_arcsec"] = finite(zero)
    return entry, model, [str(name) for name in found.regime]


def _with_zeros(campaign: Campaign, angle: Floats) -> tuple[Floats, float]:
    """The model with the zeros that fit best, and the zero where all readings share one."""
    weight = np.where(np.isfinite(angle), campaign.u_arcsec**-2.0, 0.0)
    off = np.where(np.isfinite(angle), campaign.y_arcsec - angle, 0.0)
    # Zeros are columns without overlap: one for all, or one for each run.
    zero = (campaign.zeros.T @ (weight * off)) / np.maximum(campaign.zeros.T @ weight, 1e-300)
    return angle + campaign.zeros @ zero, float(zero[0]) if len(zero) == 1 else np.nan


class Models:
    """The models of a diagnosis on all rows of its table. One caller at a time; others wait."""

    def __init__(self, diagnosis: Diagnosis, readings: Readings) -> None:
        self.diagnosis = diagnosis
        self.readings = readings
        fitter, c = diagnosis.competition.fitter, diagnosis.competition.campaign
        self.used = np.isin(readings.line, c.readings.line)
        """Rows that were judged, shape (n,)."""
        if self.used.all():
            self.campaign, self._model = c, fitter.model
        else:
            whole = campaign_of(diagnosis.case, readings, ())
            self.campaign = replace(whole, own=c.own, candidates=c.candidates, effects=c.effects)
            self._model = Assembled(self.campaign, fitter.effects)
        self._fits: dict[Names, Fit] = dict(diagnosis.competition.fits)
        self._lock = threading.Lock()

    @property
    def _competition(self) -> Competition:
        return self.diagnosis.competition

    # --- entries of the document ---

    def entries(self) -> Iterator[dict[str, Any]]:
        """What the diagnosis fitted: as stated, refitted, then sets, the most probable first."""
        d, c = self.diagnosis, self._competition
        yield self._entry(STATED, "stated", "the drive as stated", (), d.before)
        for names in sorted(c.fits, key=lambda n: (len(n) > 0, -c.log_odds[n])):
            yield self.entry(names, c.fits[names])
        if d.verdict.pattern is not None:
            yield self._of_pattern()

    def entry(self, names: Names, fit: Fit) -> dict[str, Any]:
        """One set of effects."""
        label = " + ".join(name_of(self.diagnosis, n) for n in names) or "numbers refitted"
        return self._entry(key_of(names), self._role(names), label, names, fit)

    def _entry(
        self, key: str, role: str, label: str, effects: Sequence[str], fit: Fit
    ) -> dict[str, Any]:
        d, c = self.diagnosis, self._competition
        model = self.predicted(fit)
        entry = rows_of(key, role, label, effects, self.campaign.y_arcsec, model)
        held = held_out_residual(c.fitter, c.fitter.look(fit, self._noise), d.fold)
        names = tuple(effects)
        known = key != STATED and names in c.log_odds
        entry |= {
            "rmse_arcsec": fit.rmse_arcsec if self.used.all() else entry["rmse_arcsec"],
            "held_out_rmse_arcsec": rms(held),
            "chi2_per_dof": fit.chi2_per_dof,
            "zero_arcsec": float(fit.zeros_arcsec[0]) if len(fit.zeros_arcsec) == 1 else None,
            "parameters": list(self._parameters(fit, effects)),
            "numbers": list(self._numbers(fit)),
            "probability": float(np.exp(c.log_odds[names] - log_total(c))) if known else None,
            "tell_tale": " ".join(self._tell_tale(effect) for effect in effects),
            "signature_arcsec": numbers(model - self._stated()) if effects else None,
            "converged": fit.converged,
        }
        return entry

    @property
    def _noise(self) -> Any:
        """One noise judges every model, as in the ladder: that of the answer."""
        pattern = self.diagnosis.verdict.pattern
        return self.diagnosis.after.noise if pattern is None else pattern.noise

    def predicted(self, fit: Fit) -> Floats:
        """A fit at every row of the table, with its zeros, shape (n,)."""
        if self.used.all():
            return self.campaign.y_arcsec - fit.residual_arcsec
        angle = self._model.at(fit.point.values).angle_arcsec
        if len(fit.zeros_arcsec) == 1 and self.campaign.zeros.shape[1] == 1:
            return np.asarray(angle + fit.zeros_arcsec[0])
        return _with_zeros(self.campaign, angle)[0]

    def regimes(self) -> list[str]:
        """Contact regime of each row, of the drive as stated."""
        return [str(name) for name in self._model.regimes(self._model.neutral)]

    def _stated(self) -> Floats:
        return self.predicted(self.diagnosis.before)

    def _role(self, names: Names) -> str:
        v = self.diagnosis.verdict
        if names == v.names and names:
            return "answer"
        if not names:
            return "refitted"
        rivals = {effect for group in v.rivals for effect in group}
        return "rival" if rivals & set(names) and len(names) == 1 else "candidate"

    def _tell_tale(self, effect: str) -> str:
        own = self._competition.campaign.own.get(effect)
        return str(own.expression) if own and own.expression else _TELL_TALES.get(effect, "")

    def _parameters(self, fit: Fit, effects: Sequence[str]) -> Iterator[dict[str, Any]]:
        """In the unit that people read, with the SI value beside it."""
        for effect in effects:
            for name, p in self.diagnosis.parameters(fit, effect).items():
                label, size = DISPLAY.get((effect, name), (name, 1.0))
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
                    "text": shown(effect, name, p["value"], p["u"], p["unit"]),
                }

    @staticmethod
    def _numbers(fit: Fit) -> Iterator[dict[str, Any]]:
        """Numbers of drive and rig, which move within their stated uncertainties."""
        for u in fit.unknowns:
            if u.name in PRIORS and np.isfinite(u.sd):
                value = fit.value(u)
                yield {
                    "number": u.name,
                    "stated": u.mean,
                    "prior": u.sd,
                    "value": value,
                    "u": fit.u(u),
                    "shift_sigma": (value - u.mean) / u.sd,
                }

    def _of_pattern(self) -> dict[str, Any]:
        """What is left without a name, followed as closely as it can be; no model of it."""
        d = self.diagnosis
        pattern = d.verdict.pattern
        assert pattern is not None
        model = np.full(len(self.readings), np.nan)
        residual = pattern.problem.residual(pattern.amplitude, pattern.noise)
        model[self.used] = self._competition.campaign.y_arcsec - residual
        label = f"any function of {' and '.join(pattern.columns)}"
        entry = rows_of(UNKNOWN, "unknown", label, (), self.campaign.y_arcsec, model)
        entry["held_out_rmse_arcsec"] = d.ladder[-1].held_out_rmse_arcsec
        entry["chi2_per_dof"] = d.ladder[-1].chi2_per_dof
        entry["probability"] = d.verdict.probability if d.verdict.kind == "unknown" else None
        entry["signature_arcsec"] = numbers(model - self._stated())
        return entry

    # --- further choices ---

    def choice(self, effects: Sequence[str]) -> dict[str, Any]:
        """The model with these effects, fitted now where the diagnosis has not.

        Raises `InvalidInputError` for an effect that is not known or cannot be seen in this table.
        """
        names = tuple(sorted(dict.fromkeys(effects)))
        with self._lock, threadpool_limits(1, user_api="blas"):
            if names not in self._fits:
                self._fits[names] = self._fitted(names)
            return self.entry(names, self._fits[names])

    def fit_of(self, effects: Sequence[str]) -> Fit:
        """The fit behind `choice`."""
        self.choice(effects)
        return self._fits[tuple(sorted(dict.fromkeys(effects)))]

    def _fitted(self, names: Names) -> Fit:
        """From the best fit of some of the effects, the others added one after the other."""
        known = [n for n in self._fits if set(n) <= set(names)]
        reached = max(known, key=lambda n: self._fits[n].log_evidence)
        fit = self._fits[reached]
        while reached != names:
            rest = [n for n in names if n not in reached]
            for effect in rest[:1]:
                fit = self._with(fit, effect)
                reached = tuple(sorted((*reached, effect)))
                self._fits.setdefault(reached, fit)
        return fit

    def _with(self, base: Fit, effect: str) -> Fit:
        """A fit with one more effect, in the form and from the sizes that the linear problem finds
        best."""
        c = self._competition
        fitter = c.fitter
        variants = [v for v in fitter.variants if v.effect == effect]
        if not variants:
            raise InvalidInputError(f"{effect}: it cannot be fitted to these readings")
        library = Signatures(c.campaign, variants)
        look = replace(fitter.look(base, self._noise), form_sd=0.0)
        signatures = library.about(look, c.names, secants=True)
        screen = Screen(look, signatures)
        usable = [m for m in range(len(signatures)) if screen.usable(m)]
        gains = sorted((screen.single(m) for m in usable), key=lambda g: -g.log_odds)
        if not gains:
            raise InvalidInputError(f"{effect}: these readings do not depend on it")
        before, hopeless = base.hypothesis.variants, fitter.hopeless
        member = gains[0].members[0]
        hypothesis = Hypothesis((*before, signatures[member].variant))
        start = start_values(fitter, signatures, (member,), gains[0].sizes, base)
        try:
            # A choice of the user's is polished however bad it is.
            fitter.hopeless = np.inf
            found = fitter.fit(hypothesis, start, self._noise, free_noise=False)
        finally:
            fitter.hopeless = hopeless
        if found is None:
            raise InvalidInputError(f"{effect}: the model has no solution with it at these loads")
        return found
