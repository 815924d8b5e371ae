"""One diagnosis for each level of a column, and how the numbers change from level to level.

diagnose_by       a case, its readings and a column -> DividedDiagnosis
DividedDiagnosis  the answers side by side
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.diagnosis.diagnose import diagnosed
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.inference.estimates import parameters_of
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.residuals import rmse_of
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.selection.fit_effects import best_fit
from cbpt.lab.wording import layout
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.numbers import AngleUnit, angle_unit_of, in_words
from cbpt.lab.wording.versions import versions

__all__ = ["DividedDiagnosis", "diagnose_by"]

SCHEMA = "cbpt.diagnosis_by/1"
MOST_LEVELS = 40
"""Values of a column that readings are divided by."""


@dataclass(frozen=True, eq=False)
class DividedDiagnosis(Reported):
    """Answers by the level of a column, in the order of the table."""

    by: str
    answers: dict[str, Diagnosis]
    effects: tuple[str, ...]
    """All effects that the answer of any level names: fitted at every level, to be compared."""
    fits: dict[str, Fit] = field(repr=False)
    failed: dict[str, str]
    """Levels that could not be judged, and why."""

    def parameters(self) -> dict[str, dict[str, dict[str, Any]]]:
        """By number (`effect.name`) and level: value, SI, and its standard uncertainty."""
        found: dict[str, dict[str, dict[str, Any]]] = {}
        for level, fit in self.fits.items():
            for number in (u for u in fit.unknowns if "." not in u.name):
                entry = {"value": fit.value(number), "u": fit.u(number)}
                found.setdefault(number.name, {})[level] = entry
            for effect in self.effects:
                for name, p in parameters_of(fit, effect).items():
                    entry = {"value": p["value"], "u": p["u"], "why_no_u": p["why_no_u"]}
                    found.setdefault(f"{effect}.{name}", {})[level] = entry
        return found

    def rmse_arcsec(self) -> dict[str, float]:
        """Root mean square residual of the fit at each level, as in the answers of the levels."""
        return {
            level: rmse_of(self.answers[level].competition.campaign, fit)
            for level, fit in self.fits.items()
        }

    def to_dict(self) -> dict[str, Any]:
        """As plain values, the same that `to_json` writes."""
        levels = {
            level: {
                "verdict": d.to_dict()["verdict"],
                "before_rmse_arcsec": d.ladder[0].rmse_arcsec,
                "after_rmse_arcsec": d.final_rung.rmse_arcsec,
            }
            for level, d in self.answers.items()
        }
        return {
            "schema": SCHEMA,
            "versions": versions(),
            "by": self.by,
            "levels": levels,
            "effects_fitted_at_every_level": list(self.effects),
            "rmse_arcsec": self.rmse_arcsec(),
            "parameters": self.parameters(),
            "failed": self.failed,
        }

    def to_json(self) -> str:
        """One JSON document."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def report(self, angle_unit: str = "arcsec") -> str:
        """As text, angles in `angle_unit`."""
        return "\n".join(self._lines(angle_unit_of(angle_unit)))

    def _lines(self, angle: AngleUnit) -> Iterator[str]:
        for level, d in self.answers.items():
            told = d.sentence_in(angle.symbol)
            yield f"{self.by} {level} ({len(d.readings)} readings): {told}"
        yield from (
            f"{self.by} {level}: not diagnosed. {why}" for level, why in self.failed.items()
        )
        if not self.fits:
            return
        yield ""
        added = f"with {', '.join(self.effects)}" if self.effects else "without effects"
        yield (
            f"The same model, {added}, was fitted to the readings of each {self.by} alone; "
            "its parameters:"
        )
        rows = []
        for number, by_level in self.parameters().items():
            effect, _, name = number.partition(".")
            label, cells = number, []
            for level in self.fits:
                p = by_level.get(level)
                if p is None:
                    cells.append("")
                    continue
                head, value = in_words((effect, name or effect), p["value"], p["u"], angle=angle)
                label = f"{effect} {head}" if name else label
                cells.append(value)
            rows.append([label, *cells])
        rmse = [angle.number(value) for value in self.rmse_arcsec().values()]
        yield layout.table([self.by, *self.fits], [*rows, [f"rmse_{angle.symbol}", *rmse]])

    def __repr__(self) -> str:
        return self.report()


def diagnose_by(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, object],
    data: str | os.PathLike[str] | Mapping[str, ArrayLike],
    by: str,
    *,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, object] | None = None,
    seed: int = 0,
) -> DividedDiagnosis:
    """Diagnose the readings of each value of a column by themselves.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    data : Readings, str, PathLike, mapping or data frame
        The table of readings, as `read_readings` takes it.
    by : str
        The column, `preload_step` or any other.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.
    seed : int
        Seed of the simulated p-values. The same seed gives the same answers.

    Returns
    -------
    DividedDiagnosis
        One diagnosis for each value. A value with too few readings to judge stands in `failed`.

    Raises
    ------
    CaseError, ReadingsError
        The case or the table cannot be read.
    """
    case, readings = case_and_readings(case, data, columns, sheet, only, by)
    labels = readings.labels[by]
    levels = list(dict.fromkeys(labels.tolist()))
    if len(levels) > MOST_LEVELS:
        raise InvalidInputError(
            f"by = {by!r}: the column has {len(levels)} different values, at most "
            f"{MOST_LEVELS} are possible; choose a column of set points, such as preload_step"
        )
    answers: dict[str, Diagnosis] = {}
    failed: dict[str, str] = {}
    with one_blas_thread():
        for level in levels:
            try:
                answers[level] = diagnosed(case, readings.select(labels == level), seed)
            except ReadingsError as error:
                failed[level] = str(error)
        named = [e for d in answers.values() for e in _named(d)]
        effects = tuple(sorted(dict.fromkeys(named)))
        fits = {level: _fitted(d, effects) for level, d in answers.items()}
    found = {level: fit for level, fit in fits.items() if fit is not None}
    return DividedDiagnosis(by, answers, effects, found, failed)


def _named(d: Diagnosis) -> tuple[str, ...]:
    """Effects of an answer that can be fitted: offsets of runs and numbers of the drive cannot."""
    numbers = d.competition.campaign.priors
    return tuple(e for e in d.verdict.names if e != "run_offset" and e not in numbers)


def _fitted(d: Diagnosis, effects: tuple[str, ...]) -> Fit | None:
    fits = d.competition.fits
    if effects in fits:
        return fits[effects]
    try:
        found = best_fit(d.competition.fitter, effects)
    except (InvalidInputError, ReadingsError):
        return None
    return found if np.isfinite(found.residual_arcsec).all() else None
