"""Add effects to a case: fit them to readings, and get the case with them in it.

fit         a case, its readings and effects -> Fitted
Fitted      values with uncertainties, the error before and after, the new case
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from numpy.typing import ArrayLike

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError, Say, said
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.diagnosis.diagnose import prepared
from cbpt.lab.diagnosis.diagnosis_data import Rung
from cbpt.lab.diagnosis.fit_text import (
    at_limits,
    beyond_own_loops,
    moved_numbers,
    parameter_words,
    solutions,
)
from cbpt.lab.diagnosis.rungs import rung_of
from cbpt.lab.inference.cross_validation import folds
from cbpt.lab.inference.estimates import parameters_of
from cbpt.lab.inference.evidence import Closing, Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.prediction import AtLoad, Load, angle_at, load_of_choice
from cbpt.lab.inference.residuals import told_by, zeros_out
from cbpt.lab.inference.results import Results, results_of
from cbpt.lab.model.own_terms import campaign_of, chosen
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.fit_effects import best_fit
from cbpt.lab.selection.history import with_its_history
from cbpt.lab.wording import html, layout
from cbpt.lab.wording.numbers import AngleUnit, angle_unit_of, rounded
from cbpt.sketch import Series, sketch

__all__ = ["Fitted", "fit"]


@dataclass(frozen=True, eq=False)
class Fitted:
    """Effects fitted to readings."""

    case_or_why: Case | InvalidInputError = field(repr=False)
    """`case`, or why there is none."""
    readings: Readings
    effects: tuple[str, ...]
    before: Rung
    """The case as given."""
    after: Rung
    """With the effects, and the numbers refitted within their stated uncertainties."""
    nominal: Fit = field(repr=False)
    """The case as given, seen through the noise of the fit."""
    result: Fit = field(repr=False)
    fitter: Fitter = field(repr=False)
    held_out_by: str
    notes: tuple[str, ...]

    @property
    def case(self) -> Case:
        """The case with the effects in it, and the numbers of the drive as they were refitted.

        Raises `InvalidInputError` where an effect is a function of Python, which no case holds.
        """
        if isinstance(self.case_or_why, InvalidInputError):
            raise self.case_or_why
        return self.case_or_why

    def parameters(self) -> dict[str, dict[str, dict[str, Any]]]:
        """By effect and parameter: value, standard uncertainty (or why there is none), unit."""
        return {e: parameters_of(self.result, e) for e in self.effects}

    @property
    def closing(self) -> Closing | None:
        """How near the values are to the minimum, and the steps it took."""
        return self.result.closing

    def predict(
        self,
        torque_Nm: ArrayLike,
        preload_N: ArrayLike | None = None,
        input_angle_deg: ArrayLike = 0.0,
    ) -> AtLoad:
        """Predict the elastic angle under loads of choice, as `Diagnosis.predict` does.

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
            Elastic angles and standard uncertainties (k = 1) in arcsec, shape (n,).
        """
        return angle_at(self.fitter, self.result, Load(torque_Nm, preload_N, input_angle_deg))

    def results(
        self,
        torque_Nm: ArrayLike | None = None,
        preload_N: ArrayLike | None = None,
        input_angle_deg: ArrayLike | None = None,
    ) -> Results:
        """List every number of the fit, as `Diagnosis.results` does.

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
            Rows with value, unit, standard uncertainty and what it rests on.
        """
        load = load_of_choice(self.case, torque_Nm, preload_N, input_angle_deg)
        errors = (
            ("rmse as given", self.before.rmse_arcsec),
            ("rmse fitted", self.after.rmse_arcsec),
            ("rmse fitted, held out", self.after.held_out_rmse_arcsec),
        )
        return results_of(
            self.fitter,
            self.result,
            errors,
            angle_at(self.fitter, self.result, load) if load else None,
        )

    def report(self, say: Say = str, angle_unit: str = "arcsec") -> str:
        """As text, angles in `angle_unit`; `say` says the steps of notes, else they are Python."""
        return "\n".join(self._lines(say, angle_unit_of(angle_unit)))

    def _lines(self, say: Say, angle: AngleUnit) -> Iterator[str]:
        yield f"{len(self.readings)} readings of {self.readings.source}"
        yield from (f"Note: {angle.retold(said(note, say))}" for note in self.notes)
        for effect, found in self.parameters().items():
            c = self.fitter.campaign
            words = (parameter_words(c, (effect, n), p, angle) for n, p in found.items())
            yield f"{effect}: {', '.join(map(' '.join, words))}"
        if self.closing:
            yield f"Values at the minimum: {self.closing}."
        moved = moved_numbers(self.result, self.fitter.campaign)
        if moved:
            yield f"The fit changed parameters of drive and rig too; the fitted case has {moved}."
        rows = [
            [
                name,
                angle.number(r.rmse_arcsec),
                angle.number(r.held_out_rmse_arcsec),
                rounded(r.chi2_per_dof),
            ]
            for name, r in (("as given", self.before), ("fitted", self.after))
        ]
        zeros = zeros_out(self.fitter.campaign, self.result.noise)
        yield f"Error, in sample and held out (cross-validation by {self.held_out_by}); {zeros}:"
        yield layout.table(
            ["", f"rmse_{angle.symbol}", f"held_out_{angle.symbol}", "chi2/dof"], rows
        )

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        """As a notebook shows it: parameters, errors, what the fit leaves, the folded report."""
        c = self.fitter.campaign
        numbers = [
            (effect, *parameter_words(c, (effect, name), p))
            for effect, found in self.parameters().items()
            for name, p in found.items()
        ]
        errors = [
            (name, rounded(r.rmse_arcsec), rounded(r.held_out_rmse_arcsec))
            for name, r in (("as given", self.before), ("fitted", self.after))
        ]
        parts = (
            html.table(["effect", "parameter", "value"], numbers),
            html.table(["", "rmse_arcsec", "held_out_arcsec"], errors),
            self._sketch(),
            html.folded("the whole report", self.report()),
        )
        return "".join(parts)

    def _sketch(self) -> str:
        """What the model leaves of the readings, over the torque, before and after the fit."""
        torque_Nm = self.fitter.campaign.readings.torque_Nm
        left = {
            "as given": self.nominal.residual_arcsec,
            "fitted": self.result.residual_arcsec,
        }
        series = [Series(name, torque_Nm, y, line=False) for name, y in left.items()]
        return sketch(series, "torque_Nm", "reading minus model, arcsec,")


def fit(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    effects: str | OwnEffect | Sequence[str | OwnEffect],
    *,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, Any] | None = None,
) -> Fitted:
    """Fit effects to readings, together with the numbers of the drive.

    The numbers of the drive and the calibrations stay within their stated uncertainties. Where an
    effect has several forms (`cbpt effects` lists them), the most probable one is taken.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    data : Readings, str, PathLike, mapping or data frame
        The table of readings, as `read_readings` takes it.
    effects : str, OwnEffect or sequence of these
        Ids of the library, effects from `cbpt.effects`, or ids of own effects of the case, which
        are then fitted anew.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.

    Returns
    -------
    Fitted
        The case with the fitted effects, their parameters, and the errors before and after.

    Raises
    ------
    InvalidInputError
        An effect is not in the library, or these readings do not depend on it.
    CaseError, ReadingsError
        The case or the table cannot be read.
    """
    case, readings = case_and_readings(case, data, columns, sheet, only)
    ids, own = chosen(case, effects)
    if not ids:
        raise InvalidInputError("effects: name at least one effect to fit, see cbpt effects")
    if isinstance(case, Drive):
        case = Case.from_toml(case.to_toml())
    with one_blas_thread():
        campaign, notes = prepared(campaign_of(case, readings, own))
        campaign, told = with_its_history(campaign, ids)
        notes += told
        fitter = Fitter(campaign, asked=ids)
        names = tuple(dict.fromkeys(e.partition(":")[0] for e in ids))
        found = best_fit(fitter, ids)
        fold, held_by = folds(campaign)
        # One noise judges both, with what the instrument does as the fit shows it.
        noise = told_by(campaign, found.residual_arcsec, found.noise)
        nominal = fitter.at_nominal(replace(found, noise=noise))
        return Fitted(
            case_or_why=_case_or_why(case, fitter, found),
            readings=campaign.readings,
            effects=names,
            nominal=nominal,
            before=rung_of(fitter, "", nominal, fold),
            after=rung_of(fitter, " + ".join(names), found, fold),
            result=found,
            fitter=fitter,
            held_out_by=held_by,
            notes=(
                *notes,
                *map(str, solutions(found)),
                *beyond_own_loops(campaign, found),
                *at_limits(campaign, found),
            ),
        )


def _case_or_why(case: Case, fitter: Fitter, found: Fit) -> Case | InvalidInputError:
    try:
        return case_with(case, fitter, found)
    except InvalidInputError as error:
        return error


def case_with(case: Case, fitter: Fitter, found: Fit) -> Case:
    """The case with fitted effects, and with the numbers of the drive as refitted."""
    entries: dict[tuple[str, str], dict[str, float]] = {}
    for u in found.unknowns:
        effect, _, name = u.name.partition(".")
        if effect in PRIORS and not name:
            # Known by its effect: its one number.
            name = next(v.sizes[0] for v in fitter.variants if v.effect == effect)
        ball, dot, stem = name.partition(".")
        if dot:
            entries[effect, ball] = {"ball": float(ball), stem: found.value(u)}
        else:
            entries.setdefault((effect, ""), {})[name] = found.value(u)
    for variant in found.hypothesis.variants:
        if not variant.spread:
            entries[variant.effect, ""] |= dict(variant.fixed)
    # What the case has beside stays as it is.
    campaign, fitted = fitter.campaign, {effect for effect, _ in entries}
    kept = [(e, numbers) for e, numbers in campaign.effects if e not in fitted]
    listed = [*kept, *((effect, numbers) for (effect, _), numbers in entries.items())]
    case = case.with_effects([(campaign.own.get(e, e), numbers) for e, numbers in listed])
    between_runs = case.with_friction_between_runs(campaign.history)
    return between_runs.with_torque_turns(campaign.torque_turns)
