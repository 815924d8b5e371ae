"""Model against measurement: how far off, and where.

    compare         a case and its readings -> Comparison, with further effects fitted where asked
    Comparison      the misfit as a whole, by group and where it stands out; text and picture

A residual is reading minus offset minus model. `zero = "common"` in the case leaves the readings as
they are; the common offset that would fit best is told beside them. `"per_run"` gives every run an
offset of its own, fitted as a weighted mean, at the cost of a degree of freedom each.

The misfit is judged twice: against the stated uncertainty, and against the scatter that the
readings show themselves (`scatter`), so that an uncertainty that is misstated is told from a model
that is off. Where it fails is asked of all regions of the table at once (`where`).

Nothing is dropped: rows at which the model has no solution are counted and named, with the reason.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive, OwnEffect, effect_specs
from cbpt.errors import ReadingsError, Say
from cbpt.figures.comparison import Box, ComparisonPicture, draw_comparison
from cbpt.lab.covariance.linear_gaussian import Noise, Rows, Whitener
from cbpt.lab.covariance.repeatability import Repeats, pooled
from cbpt.lab.covariance.within_run import Scatter, estimate
from cbpt.lab.diagnosis.comparison_data import ComparisonData
from cbpt.lab.diagnosis.comparison_text import lines
from cbpt.lab.diagnosis.misfit import as_rows, columns_of, groups_of, misfit_of, p_value, p_value_of
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.readings.points import points_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.unit_check import slips
from cbpt.lab.wording import html
from cbpt.lab.wording.inline import Shown, page
from cbpt.lab.wording.numbers import listed, rounded
from cbpt.lab.wording.versions import versions
from cbpt.results import ANGLE_UNITS, Angles, solve_many

if TYPE_CHECKING:
    from cbpt.lab.selection.fit_effects import Number, Prediction
    from cbpt.lab.selection.scan import Region

__all__ = ["Comparison", "compare"]

SCHEMA = "cbpt.compare/1"
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

_LAST_DIGITS = 1e-9
"""Of the largest angle: less is no scatter of an instrument."""
# Regions are searched in as many readings as this, evenly spread where there are more.
_SEARCHED = 2000


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(ComparisonData):
    """Readings against the model, row by row and in groups. Arrays have shape (n,)."""

    before: Comparison | None
    """The same without the effects that were to be fitted; None where none were."""

    def report(self, angle_unit: str = "arcsec", say: Say = str) -> str:
        """The comparison as text, angles in `angle_unit` (arcsec, arcmin, deg, urad, mrad, rad);
        `say` says the steps of notes, else they are Python."""
        if angle_unit not in ANGLE_UNITS:
            raise ValueError(
                f"angle_unit = {angle_unit!r}: expected one of {', '.join(ANGLE_UNITS)}"
            )
        return "\n".join(lines(self, angle_unit, say))

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain values, the same that `to_json` writes."""
        return {
            "schema": SCHEMA,
            "versions": versions(),
            "data_sha256": self.readings.sha256,
            "source": self.readings.source,
            "readings": len(self.readings),
            "zero": self.zero,
            "zero_arcsec": self.zero_arcsec,
            "best_common_zero_arcsec": _finite(self.best_common_zero_arcsec),
            "rmse_with_best_zero_arcsec": _finite(self.rmse_with_best_zero_arcsec),
            "overall": asdict(self.overall) if self.overall else None,
            "p_value": self.p_value,
            "scatter": self.scatter.to_dict() if self.scatter else None,
            "p_value_of_scatter": self.p_value_of_scatter,
            "repeats": asdict(self.repeats) if self.repeats else None,
            "p_value_of_repeats": self.p_value_of_repeats,
            "u_from": self.u_from,
            "where": [region.to_dict() for region in self.where],
            "hints": list(self.hints),
            "effects": _of_effects(self.numbers),
            "before": self.before.to_dict() if self.before else None,
            "groups": [asdict(group) for group in self.groups],
            "without_solution": self.without_solution,
            "findings": list(self.findings),
            "notes": list(self.readings.notes),
        }

    def to_json(self) -> str:
        """One JSON document."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Column names and rows: each reading beside the model, for a table or a CSV file."""
        columns = {
            **columns_of(self.readings),
            "model_elastic_angle_arcsec": self.model.elastic_angle_arcsec,
            "residual_arcsec": self.residual_arcsec,
            "status": self.model.status,
        }
        return as_rows(columns)

    def plot(self, path: str | os.PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw readings, model and residual to an SVG, PNG or PDF file.

        Needs matplotlib: `pip install "cbpt[plot]"`.
        """
        offsets = np.array([self.zero_arcsec.get(str(run), 0.0) for run in self.readings.run])
        picture = ComparisonPicture(
            points=points_of(self.readings, offsets),
            model_arcsec=self.model.elastic_angle_arcsec,
            residual_arcsec=self.residual_arcsec,
            has_effects=bool(self.numbers),
            regions=[Box(r.rows, r.label, r.share_of_misfit) for r in self.where],
            rmse_arcsec=self.overall.rmse_arcsec if self.overall else None,
        )
        draw_comparison(picture, path, angle_unit)

    def show(self, height_px: int = 800) -> Shown:
        """The page's sections about the drive as stated, for a notebook: no server, no network.

        Needs plotly: `pip install "cbpt[workbench]"`.
        """
        assert self.case is not None
        return page(self.case, self.readings, None, height_px)

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        """As a notebook shows it: groups of readings, picture, and the report folded."""
        rows = [
            [
                f"{g.column} {g.label}",
                g.misfit.readings,
                f"{g.share_of_misfit:.0%}",
                rounded(g.misfit.bias_arcsec),
                rounded(g.misfit.rmse_arcsec),
            ]
            for g in self.groups
            if g.column != "run"
        ]
        headers = ["readings at", "readings", "share of misfit", "bias_arcsec", "rmse_arcsec"]
        parts = (
            html.paragraph(f"{len(self.readings)} readings of {self.readings.source}"),
            html.table(headers, rows) if self.overall else "",
            html.picture(self.plot) if self.overall else "",
            html.folded("the whole report", self.report()),
        )
        return "".join(parts)


def compare(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    effects: Sequence[str | OwnEffect] = (),
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Comparison:
    """Solve the model at every reading, and say how far off it is and where.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive: a `Case`, the path of a case file or a dict of one. `[measurement]` of the case
        counts, and its `[load]` fills in a preload or an input angle that the table does not have.
        A bare `Drive` has neither. The effects of the case are part of the model.
    data : Readings, str, PathLike, mapping or data frame
        The table of readings, as `read_readings` takes it.
    effects : sequence of str or OwnEffect
        Effects to fit on top, by id or from `cbpt.effects`. The numbers of the drive and the
        calibrations are fitted as well, within their stated uncertainties; the comparison without
        the effects is then `Comparison.before`.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.
    progress : callable, optional
        Called now and then as ``progress(rows_done, rows)``. What it raises ends the work.

    Returns
    -------
    Comparison
        Errors in arcsec, their regions, and the residual of each reading, shape (n,).

    Raises
    ------
    CaseError, ReadingsError
        The case or the table cannot be read.
    """
    case, data = case_and_readings(case, data, columns, sheet, only)
    drive = case if isinstance(case, Drive) else case.drive
    zero = case.zero if isinstance(case, Case) else "common"
    if data.preload_N is None and drive.kind == "ball_drive":
        raise ReadingsError.of_table(data.source, "preload_N", "a preload for every reading")
    ball_drive = drive.kind == "ball_drive"
    findings = tuple(map(repr, drive.findings())) if ball_drive else ()
    plain = _compared(data, *_model(case, drive, data, progress), zero, findings)
    plain = replace(plain, case=case, hints=(*plain.hints, *_hints(case, drive, data)))
    if not effects:
        return plain
    from cbpt.lab.selection.fit_effects import fitted

    model = fitted(case, data, effects)
    found = _compared(data, model, model.regime, zero, findings)
    return replace(found, before=plain, case=case)


def _hints(case: Case | Drive, drive: Drive, readings: Readings) -> Iterator[str]:
    """Torques of the other side, and effects of the case that do nothing."""
    from cbpt.lab.preflight.units import input_side

    if input_side(readings, drive):
        ratio = abs(drive.transmission_ratio)
        yield f"the torques are those of the input side; multiply them by the ratio, {ratio:.4g}"
    known = {spec.id: spec for spec in effect_specs()}
    for effect in case.effects if isinstance(case, Case) else []:
        if effect.id not in known:
            continue
        stated = dict(effect.values)
        sizes = [p for p in known[effect.id].parameters if p.is_size]
        if all(stated.get(p.name, p.neutral) == p.neutral for p in sizes):
            names = listed([p.display_name for p in sizes], "or")
            yield (
                f"the effect {effect.id} of the case does nothing, as no size of it is stated: "
                f"give {names}, or fit it"
            )


def _model(
    case: Case | Drive,
    drive: Drive,
    readings: Readings,
    progress: Callable[[int, int], object] | None,
) -> tuple[Angles | Prediction, NDArray[np.str_]]:
    """The case at every reading, and the regime of its meshing points there."""
    from cbpt.lab.selection.fit_effects import predicted

    if isinstance(case, Case) and case.effects:
        model = predicted(case, readings)
        return model, model.regime
    preload = 0.0 if readings.preload_N is None else readings.preload_N
    loads = readings.torque_Nm, preload, readings.input_angle_deg
    angles = solve_many(drive, *loads, progress=progress)
    if len(readings) > _SEARCHED:
        return angles, np.full(len(readings), "")
    return angles, predicted(case, readings).regime


@dataclass(frozen=True)
class _Known:
    """What the readings themselves tell of their uncertainty."""

    scatter: Scatter | None = None
    repeats: Repeats | None = None

    @property
    def steady_repeats(self) -> Repeats | None:
        """Repeats, unless they differ by far more than readings scatter inside their runs."""
        return self.repeats if self.repeats and self.repeats.steady else None


def _compared(
    readings: Readings,
    model: Angles | Prediction,
    regime: NDArray[np.str_],
    zero: str,
    findings: tuple[str, ...],
) -> Comparison:
    solved = model.has_solution
    raw = readings.elastic_angle_arcsec - model.elastic_angle_arcsec
    u = readings.u_elastic_angle_arcsec
    weight = np.ones(len(readings)) if u is None else u**-2.0
    residual, offsets = raw.copy(), dict[str, float]()
    if zero == "per_run":
        offsets, of_runs = _offsets_of_runs(readings, raw, weight, solved)
        residual -= of_runs[readings.run_index]
    best = float(np.average(residual[solved], weights=weight[solved])) if solved.any() else np.nan
    left = residual[solved] - best
    fitted = len(offsets) + getattr(model, "fitted", 0)
    known = _Known()
    if solved.any():
        part = readings if solved.all() else readings.select(solved)
        scatter = estimate(part, residual[solved])
        # Angles that were computed scatter by their last digits.
        size = float(np.abs(part.elastic_angle_arcsec).max())
        if scatter is not None and scatter.u_arcsec <= _LAST_DIGITS * size:
            scatter = None
        known = _Known(scatter, pooled(part, residual[solved], scatter))
    return Comparison(
        readings=readings,
        model=model,
        residual_arcsec=residual,
        zero=zero,
        zero_arcsec=offsets,
        best_common_zero_arcsec=best,
        rmse_with_best_zero_arcsec=float(np.sqrt(np.mean(left**2))) if left.size else np.nan,
        p_value=p_value(readings, residual, solved, fitted),
        overall=misfit_of(readings, residual, solved, fitted),
        groups=tuple(groups_of(readings, residual, solved)),
        findings=findings,
        scatter=known.scatter,
        p_value_of_scatter=p_value_of(known.scatter, readings, residual, solved, fitted),
        repeats=known.repeats,
        p_value_of_repeats=p_value_of(known.steady_repeats, readings, residual, solved, fitted),
        where=_where(readings, residual, solved, regime, zero, known),
        hints=slips(
            (residual + model.elastic_angle_arcsec)[solved], model.elastic_angle_arcsec[solved]
        ),
        numbers=getattr(model, "numbers", ()),
        before=None,
    )


def _offsets_of_runs(
    readings: Readings, raw: Floats, weight: Floats, solved: Mask
) -> tuple[dict[str, float], Floats]:
    """The weighted mean of each run by label, and by run index, 0 where no row is solved."""
    rows = np.flatnonzero(solved)
    run, first = np.unique(readings.run_index[rows], return_index=True)
    offsets = np.zeros(int(readings.run_index.max()) + 1)
    total = np.bincount(readings.run_index[rows], weight[rows])
    moment = np.bincount(readings.run_index[rows], (weight * raw)[rows])
    offsets[run] = moment[run] / total[run]
    labels = map(str, readings.run[rows[first]].tolist())
    return dict(zip(labels, offsets[run].tolist(), strict=True)), offsets


def _where(
    readings: Readings,
    residual: Floats,
    solved: Mask,
    regime: NDArray[np.str_],
    zero: str,
    known: _Known,
) -> tuple[Region, ...]:
    """Regions, judged by the larger of stated uncertainty and scatter; by repeats where none is
    stated."""
    stated = readings.u_elastic_angle_arcsec
    scatter, repeats = known.scatter, known.steady_repeats
    if not solved.any() or (stated is None and scatter is None and repeats is None):
        return ()
    from cbpt.lab.selection.scan import Scanned, find_regions

    rows = _searched(readings, np.flatnonzero(solved), zero)
    part, order = readings.select(rows), Rows.of(readings.run_index[rows])
    noise = Noise()
    if stated is None:
        estimated = repeats or scatter
        assert estimated is not None
        u = np.full(len(rows), estimated.u_arcsec)
    else:
        u = stated[rows]
        if (
            scatter is not None
            and scatter.ratio is not None
            and (scatter.off or scatter.correlation)
        ):
            noise = Noise(scale=max(scatter.ratio, 1.0))
    if scatter is not None and len(rows) == np.count_nonzero(solved):
        noise = replace(noise, correlation=scatter.correlation)
    whitener = Whitener.of(noise, u, order)
    offsets = np.zeros((len(rows), 0))
    if zero == "per_run":
        offsets = whitener(order.columns())
    found = find_regions(
        Scanned(part, residual[rows], whitener, offsets, regime[rows]), np.random.default_rng(0)
    )
    if len(rows) == len(readings):
        return found
    finite = np.where(solved, residual, 0.0)
    return tuple(region.within(readings, finite, regime, solved) for region in found)


def _searched(readings: Readings, rows: Ints, zero: str) -> Ints:
    """The rows in which regions are searched, evenly spread. Whole runs where each has an offset of
    its own: single readings of many runs would be all offset and no residual."""
    if len(rows) <= _SEARCHED:
        return rows
    if zero == "per_run":
        return np.asarray(rows[Rows.of(readings.run_index[rows]).thinned(_SEARCHED)])
    return np.asarray(rows[np.linspace(0, len(rows) - 1, _SEARCHED).round().astype(int)])


def _of_effects(numbers: Sequence[Number]) -> list[dict[str, Any]]:
    """Effects with their parameters, and the numbers of the drive that moved along."""
    effects: dict[str, dict[str, Any]] = {}
    for n in numbers:
        one = effects.setdefault(n.effect, {"effect": n.effect, "added": n.added, "parameters": {}})
        one["parameters"][n.name] = {"value": n.value, "u": n.u}
    return list(effects.values())


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
