"""Model against measurement: how far off, and where.

    compare         a case and its readings -> Comparison
    Comparison      residuals row by row, the misfit as a whole and by group; text, dict, JSON
    Misfit          bias, RMSE, largest error, chi-squared of some of the rows
    Group           the misfit of one preload, torque range, direction, input angle or run

A residual is reading minus zero minus model. `zero = "common"` in the case takes the zero of the
readings as it is; the zero that would fit best is told beside it. `"per_run"` gives every run its
own, fitted as a weighted mean, at the cost of a degree of freedom each.

Nothing is dropped: rows at which the model has no solution are counted and named, with the reason.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive, text_table
from cbpt.errors import ReadingsError
from cbpt.lab.readings import Readings, read_readings
from cbpt.results import ANGLE_UNITS, Angles, solve_many

__all__ = ["Comparison", "Group", "Misfit", "compare"]

SCHEMA = "cbpt.compare/1"
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# As many values of a quantity as this are told one by one, more are told in ranges.
_MOST_LEVELS = 12
_MOST_TORQUES = 7
_RANGES = 6


@dataclass(frozen=True)
class Misfit:
    """How far readings are from the model over some rows. Angles in arcsec."""

    readings: int
    """Rows with a solution of the model."""
    bias_arcsec: float
    """Mean residual."""
    excess_arcsec: float
    """Mean residual counted in the direction of the torque: above 0 the drive is softer than the
    model, below 0 stiffer. Rows without torque do not count."""
    rmse_arcsec: float
    """Root mean square of the residual."""
    largest_error_arcsec: float
    """The residual that is largest in size, with its sign."""
    largest_error_line: int
    """Its line in the file, or its row in data."""
    chi2_per_dof: float | None
    """Sum of squared residuals over their stated variances, per degree of freedom; near 1 where
    the model explains the readings to within their uncertainty. None without a stated one."""


@dataclass(frozen=True)
class Group:
    """The misfit of the rows that share a value, or a range, of one column."""

    column: str
    """`preload_N`, `torque_Nm`, `direction`, `input_angle_deg` or `run`."""
    label: str
    """The value or range, as text."""
    low: float | None
    """Lower end, both ends included; None where the column has no numbers."""
    high: float | None
    """Upper end."""
    share_of_misfit: float
    """Its part of the sum of squared residuals of all rows, 0 to 1."""
    misfit: Misfit


@dataclass(frozen=True, eq=False)
class Comparison:
    """Readings against the model, row by row and in groups. Arrays have shape (n,)."""

    readings: Readings
    model: Angles
    """The model at every row; NaN and a status where it has no solution."""
    residual_arcsec: Floats
    """Reading minus zero minus model; NaN where the model has no solution."""
    zero: str
    """`common` or `per_run`."""
    zero_arcsec: dict[str, float]
    """The zero taken off each run, empty for `common`."""
    best_common_zero_arcsec: float
    """The one zero for all rows that would leave the smallest misfit."""
    rmse_with_best_zero_arcsec: float
    """The RMSE it would leave."""
    p_value: float | None
    """Chance of a chi-squared this large if the model were complete and the stated uncertainty
    right; None without a stated uncertainty."""
    overall: Misfit | None
    """All rows with a solution; None where there is none."""
    groups: tuple[Group, ...]
    """By preload, torque, direction, input angle and run, as far as they vary."""
    findings: tuple[str, ...]
    """What is to be known about the design of the drive itself."""

    @property
    def without_solution(self) -> dict[str, list[int]]:
        """Lines of the table (of data: rows) at which the model has no solution, by status."""
        lines = self.readings.line
        failed = ~self.model.has_solution
        names = np.unique(self.model.status[failed])
        return {str(n): lines[failed & (self.model.status == n)].tolist() for n in names}

    def worst(self) -> Group | None:
        """The group with the largest part of the misfit for its number of rows."""
        apart = [g for g in self.groups if g.column != "run" and g.misfit.readings < self._solved]
        return max(apart, key=lambda g: g.misfit.rmse_arcsec, default=None)

    @property
    def _solved(self) -> int:
        return self.overall.readings if self.overall else 0

    def report(self, angle_unit: str = "arcsec") -> str:
        """The comparison as text, angles in `angle_unit` (arcsec, arcmin, deg, urad, mrad, rad)."""
        if angle_unit not in ANGLE_UNITS:
            raise ValueError(
                f"angle_unit = {angle_unit!r}: expected one of {', '.join(ANGLE_UNITS)}"
            )
        return "\n".join(_report(self, angle_unit))

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain values, the same that `to_json` writes."""
        import scipy

        from cbpt import __version__

        return {
            "schema": SCHEMA,
            "versions": {
                "cbpt": __version__,
                "numpy": np.__version__,
                "scipy": scipy.__version__,
                "python": platform.python_version(),
            },
            "data_sha256": self.readings.sha256,
            "source": self.readings.source,
            "readings": len(self.readings),
            "zero": self.zero,
            "zero_arcsec": self.zero_arcsec,
            "best_common_zero_arcsec": _finite(self.best_common_zero_arcsec),
            "rmse_with_best_zero_arcsec": _finite(self.rmse_with_best_zero_arcsec),
            "overall": asdict(self.overall) if self.overall else None,
            "p_value": self.p_value,
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
        r, u = self.readings, self.readings.u_elastic_angle_arcsec
        columns: dict[str, Any] = {
            "line": r.line,
            "run": r.run,
            "time_s": r.time_s,
            "torque_Nm": r.torque_Nm,
            "preload_N": r.preload_N,
            "input_angle_deg": r.input_angle_deg,
            "direction": r.direction(),
            "elastic_angle_arcsec": r.elastic_angle_arcsec,
            "u_elastic_angle_arcsec": u,
            "model_elastic_angle_arcsec": self.model.elastic_angle_arcsec,
            "residual_arcsec": self.residual_arcsec,
            "status": self.model.status,
        }
        kept = {name: values.tolist() for name, values in columns.items() if values is not None}
        empty = [[None if v != v else v for v in values] for values in kept.values()]
        return list(kept), [list(row) for row in zip(*empty, strict=True)]

    def plot(self, path: str | os.PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw readings, model and residual to an SVG, PNG or PDF file.

        Needs matplotlib: `pip install "cbpt[plot]"`.
        """
        # Only the page loads plotting, and only when a picture is asked for.
        from cbpt.page.comparison_figure import draw_comparison

        draw_comparison(self, path, angle_unit)

    def __repr__(self) -> str:
        return self.report()


def compare(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    columns: Mapping[str, str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Comparison:
    """Solve the model at every reading and say how far off it is, and where.

    case: a case file, a `Case` or a dict of one (its `[measurement]` counts, and its `[load]` fills
        in a preload or an input angle that the table does not have), or a bare `Drive`.
    data: a table of readings (file, mapping of columns, data frame) or `Readings`.
    columns: what headers of the table mean, as in `read_readings`.
    progress: called now and then with the number of rows solved and that of all.

    Raises `CaseError` and `ReadingsError` for what cannot be read; Ctrl-C stops it.
    """
    if isinstance(case, (str, os.PathLike)):
        case = Case.from_file(case)
    elif isinstance(case, Mapping):
        case = Case.from_dict(dict(case))
    elif not isinstance(case, (Case, Drive)):
        raise TypeError(
            f"a case comes from a path, a dict, a Case or a Drive, not from {type(case).__name__}"
        )
    zero, lever_arm_mm, fill = "common", None, {}
    drive = case if isinstance(case, Drive) else case.drive
    if isinstance(case, Case):
        zero, lever_arm_mm = case.zero, case.lever_arm_mm
        load = {"preload_N": case.preload_N, "input_angle_deg": case.input_angle_deg}
        fill = {name: value for name, value in load.items() if value is not None}
    if not isinstance(data, Readings):
        data = read_readings(data, lever_arm_mm=lever_arm_mm, columns=columns, fill=fill)
    if data.preload_N is None:
        raise ReadingsError.of_table(data.source, "preload_N", "a preload for every reading")
    model = solve_many(
        drive, data.torque_Nm, data.preload_N, data.input_angle_deg, progress=progress
    )
    findings = tuple(repr(finding) for finding in drive.findings())
    return _compared(data, model, zero, findings)


def _compared(
    readings: Readings, model: Angles, zero: str, findings: tuple[str, ...]
) -> Comparison:
    solved = model.has_solution
    raw = readings.elastic_angle_arcsec - model.elastic_angle_arcsec
    u = readings.u_elastic_angle_arcsec
    weight = np.ones(len(readings)) if u is None else u**-2.0
    residual, zeros = raw.copy(), {}
    if zero == "per_run":
        for index in np.unique(readings.run_index):
            rows = (readings.run_index == index) & solved
            if rows.any():
                offset = float(np.average(raw[rows], weights=weight[rows]))
                residual[rows] -= offset
                zeros[str(readings.run[rows][0])] = offset
    best = float(np.average(residual[solved], weights=weight[solved])) if solved.any() else np.nan
    left = residual[solved] - best
    everything = _misfit(readings, residual, solved, fitted=len(zeros))
    return Comparison(
        readings=readings,
        model=model,
        residual_arcsec=residual,
        zero=zero,
        zero_arcsec=zeros,
        best_common_zero_arcsec=best,
        rmse_with_best_zero_arcsec=float(np.sqrt(np.mean(left**2))) if left.size else np.nan,
        p_value=_p_value(readings, residual, solved, fitted=len(zeros)),
        overall=everything,
        groups=tuple(_groups(readings, residual, solved)),
        findings=findings,
    )


def _misfit(readings: Readings, residual: Floats, rows: Mask, fitted: int = 0) -> Misfit | None:
    r = residual[rows]
    if not r.size:
        return None
    u = readings.u_elastic_angle_arcsec
    sign = np.sign(readings.torque_Nm[rows])
    largest = int(np.argmax(np.abs(r)))
    chi2 = None
    if u is not None and r.size > fitted:
        chi2 = float(np.sum((r / u[rows]) ** 2) / (r.size - fitted))
    return Misfit(
        readings=int(r.size),
        bias_arcsec=float(r.mean()),
        excess_arcsec=float((r * sign).sum() / max(np.count_nonzero(sign), 1)),
        rmse_arcsec=float(np.sqrt(np.mean(r**2))),
        largest_error_arcsec=float(r[largest]),
        largest_error_line=int(readings.line[rows][largest]),
        chi2_per_dof=chi2,
    )


def _p_value(readings: Readings, residual: Floats, rows: Mask, fitted: int) -> float | None:
    u = readings.u_elastic_angle_arcsec
    dof = np.count_nonzero(rows) - fitted
    if u is None or dof <= 0:
        return None
    from scipy.special import chdtrc

    return float(chdtrc(dof, np.sum((residual[rows] / u[rows]) ** 2)))


def _groups(readings: Readings, residual: Floats, solved: Mask) -> Iterator[Group]:
    total = float(np.sum(residual[solved] ** 2))
    for column, label, low, high, rows in _divisions(readings):
        misfit = _misfit(readings, residual, rows & solved)
        if misfit is not None:
            share = float(np.sum(residual[rows & solved] ** 2)) / total if total else 0.0
            yield Group(column, label, low, high, share, misfit)


Division = tuple[str, str, float | None, float | None, Mask]


def _divisions(readings: Readings) -> Iterator[Division]:
    assert readings.preload_N is not None
    yield from _of_numbers("preload_N", readings.preload_N, _MOST_LEVELS)
    yield from _of_numbers("torque_Nm", readings.torque_Nm, _MOST_TORQUES)
    direction = readings.direction()
    for value, label in ((1, "rising"), (-1, "falling"), (0, "held")):
        if np.any(direction == value) and np.any(direction != value):
            yield "direction", label, float(value), float(value), direction == value
    yield from _of_numbers("input_angle_deg", readings.input_angle_deg, _MOST_LEVELS)
    for index in np.unique(readings.run_index):
        rows = readings.run_index == index
        if not rows.all():
            yield "run", str(readings.run[rows][0]), None, None, rows


def _of_numbers(column: str, values: Floats, most: int) -> Iterator[Division]:
    levels = np.unique(values)
    if len(levels) < 2:
        return
    if len(levels) <= most:
        for level in levels.tolist():
            yield column, f"{level:g}", level, level, values == level
        return
    edges = np.linspace(levels[0], levels[-1], _RANGES + 1)
    index = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, _RANGES - 1)
    for i in np.unique(index).tolist():
        # Adding 0 turns -0 into 0.
        low, high = (
            float(end) + 0.0 for end in (values[index == i].min(), values[index == i].max())
        )
        yield column, f"{low:g} to {high:g}", low, high, index == i


def _report(c: Comparison, angle_unit: str) -> Iterator[str]:
    factor = ANGLE_UNITS[angle_unit]
    yield f"{len(c.readings)} readings of {c.readings.source} against the model"
    for status, lines in c.without_solution.items():
        shown = ", ".join(map(str, lines[:8])) + (", ..." if len(lines) > 8 else "")
        yield (
            f"No solution of the model at {len(lines)} readings ({status}): "
            f"{c.readings.place}s {shown}"
        )
    yield from c.findings
    if c.overall is None:
        yield "Nothing to compare: the model has no solution at any reading."
        return
    yield _verdict(c, angle_unit)
    misfit = c.overall
    yield ""
    headers = ["", "readings", "share_of_misfit", "bias", "excess", "rmse", "largest", "chi2/dof"]
    headers[3:7] = [f"{name}_{angle_unit}" for name in headers[3:7]]
    rows = [_row("all", 1.0, misfit, factor)]
    for column in dict.fromkeys(group.column for group in c.groups if group.column != "run"):
        rows += [
            _row(f"{column} {group.label}", group.share_of_misfit, group.misfit, factor)
            for group in c.groups
            if group.column == column
        ]
    yield text_table(headers, json.dumps(rows))
    yield (
        f"largest error {misfit.largest_error_arcsec * factor:.4g} {angle_unit} on "
        f"{c.readings.place} {misfit.largest_error_line}; excess: residual in the direction of the "
        "torque, above 0 the drive is softer than the model"
    )
    if c.zero == "common":
        yield (
            f"zero: as in the readings; a common zero of "
            f"{c.best_common_zero_arcsec * factor:.4g} {angle_unit} would leave an RMSE of "
            f"{c.rmse_with_best_zero_arcsec * factor:.4g} {angle_unit}"
        )
    else:
        yield f"zero: one for each of {len(c.zero_arcsec)} runs, fitted and taken off"
    for note in c.readings.notes:
        yield f"note: {note}"


def _row(label: str, share: float, misfit: Misfit, factor: float) -> list[Any]:
    angles = (
        misfit.bias_arcsec,
        misfit.excess_arcsec,
        misfit.rmse_arcsec,
        misfit.largest_error_arcsec,
    )
    chi2 = None if misfit.chi2_per_dof is None else float(f"{misfit.chi2_per_dof:.3g}")
    rounded = [float(f"{angle * factor:.4g}") for angle in angles]
    return [label, misfit.readings, f"{share:.0%}", *rounded, chi2]


def _verdict(c: Comparison, angle_unit: str) -> str:
    """How well the model does, in one sentence, and where it is worst in another."""
    assert c.overall is not None
    factor = ANGLE_UNITS[angle_unit]
    rmse = f"{c.overall.rmse_arcsec * factor:.3g} {angle_unit}"
    u = c.readings.u_elastic_angle_arcsec
    lost = len(c.readings) - c.overall.readings
    if u is None:
        text = f"RMSE {rmse}; no uncertainty is stated, so whether that is small cannot be told."
    elif c.p_value is None or c.overall.chi2_per_dof is None:
        return f"RMSE {rmse}; the fitted zeros leave nothing to judge by: take more readings a run."
    else:
        stated = f"{float(np.median(u)) * factor:.3g} {angle_unit}"
        chi2 = f"chi2 per degree of freedom {c.overall.chi2_per_dof:.3g}"
        numbers = f"RMSE {rmse}, stated uncertainty {stated}, {chi2}."
        if lost:
            text = (
                f"The model cannot carry {lost} of {len(c.readings)} readings that the rig did: "
                f"check the units of torque and preload.\nAt the others: {numbers}"
            )
        elif c.p_value >= 0.01:
            if c.p_value > 1 - 1e-6:
                return (
                    f"The readings scatter far less than their stated uncertainty: {numbers}\nThe "
                    "model lies within it, but so would a wrong one: check the uncertainty."
                )
            return f"The model agrees with the readings: {numbers}"
        else:
            text = f"The model is off: {numbers}"
    worst = c.worst()
    if worst is None or (lost and c.p_value is not None and c.p_value >= 0.01):
        return text
    # With torques of both signs the mean hides what the direction of the torque shows.
    m = worst.misfit
    side = "beyond" if m.excess_arcsec > 0 else "short of"
    return (
        f"{text}\nIt is worst at {worst.column} {worst.label}: "
        f"RMSE {m.rmse_arcsec * factor:.3g} {angle_unit}, "
        f"the readings lie {abs(m.excess_arcsec) * factor:.3g} {angle_unit} {side} the model in "
        f"the direction of the torque ({worst.share_of_misfit:.0%} of the misfit, "
        f"{m.readings} of {c.overall.readings} readings)."
    )


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
