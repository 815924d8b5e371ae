"""How far readings are from the model over some of the rows, and how likely that is.

Misfit, misfit_of       bias, RMSE, largest error and chi-squared of some of the rows
Group, groups_of        the misfit of a preload, torque range, direction, input angle or run
p_value                 chance of such a misfit, judged by the stated uncertainty
p_value_of              the same, judged by an uncertainty that was estimated
divisions               the rows of each value or range of a column
columns_of              what the row of a reading begins with
as_rows                 columns as rows of a table, with nothing where there is no number
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.repeatability import Repeats
from cbpt.lab.covariance.within_run import Scatter
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class _Shown:
    """How much is listed."""

    most_levels: int = 12
    """As many values of a quantity as this are told one by one, more are told in ranges."""
    most_torques: int = 7
    ranges: int = 6


_SHOWN = _Shown()


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


def misfit_of(
    readings: Readings, residual: Floats, rows: Mask | Ints, fitted: int = 0
) -> Misfit | None:
    """Of the rows of a mask, or of those with these numbers; None where there are none."""
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
        bias_arcsec=_mean(r),
        excess_arcsec=float((r * sign).sum() / max(np.count_nonzero(sign), 1)),
        rmse_arcsec=float(np.sqrt(np.mean(r**2))),
        largest_error_arcsec=float(r[largest]),
        largest_error_line=int(readings.line[rows][largest]),
        chi2_per_dof=chi2,
    )


def _mean(values: Floats) -> float:
    """0 where only rounding is left, as of residuals whose mean was subtracted."""
    mean = float(values.mean())
    return mean if abs(mean) > 1e-12 * float(np.abs(values).max()) else 0.0


def p_value(readings: Readings, residual: Floats, rows: Mask, fitted: int) -> float | None:
    u = readings.u_elastic_angle_arcsec
    dof = np.count_nonzero(rows) - fitted
    if u is None or dof <= 0:
        return None
    from scipy.special import chdtrc

    return float(chdtrc(dof, np.sum((residual[rows] / u[rows]) ** 2)))


def p_value_of(
    known: Scatter | Repeats | None, readings: Readings, residual: Floats, rows: Mask, fitted: int
) -> float | None:
    """Judged by an uncertainty that was estimated, and is known to so many degrees of freedom."""
    dof = np.count_nonzero(rows) - fitted
    if known is None or dof <= 0 or not known.u_arcsec:
        return None
    from scipy.special import fdtrc

    u = readings.u_elastic_angle_arcsec
    sd = known.u_arcsec if u is None or known.ratio is None else u[rows] * known.ratio
    return float(fdtrc(dof, known.dof, np.sum((residual[rows] / sd) ** 2) / dof))


def groups_of(readings: Readings, residual: Floats, solved: Mask) -> Iterator[Group]:
    total = float(np.sum(residual[solved] ** 2))
    for column, label, low, high, rows in divisions(readings):
        rows = rows[solved[rows]]
        misfit = misfit_of(readings, residual, rows)
        if misfit is not None:
            share = float(np.sum(residual[rows] ** 2)) / total if total else 0.0
            yield Group(column, label, low, high, share, misfit)


Division = tuple[str, str, float | None, float | None, Ints]
"""Column, label, lower and upper end, numbers of the rows."""


def _parts(index: Ints) -> list[Ints]:
    """Numbers of the rows of each part, from the part that each row is of, counted from 0.

    All parts at once: a mask for each would go over the table as often as there are parts.
    """
    order = np.argsort(index, kind="stable")
    return np.split(order, np.cumsum(np.bincount(index))[:-1])


def divisions(readings: Readings) -> Iterator[Division]:
    """By preload, torque, direction, input angle and run, as far as they vary."""
    if readings.preload_N is not None:
        yield from _of_numbers("preload_N", readings.preload_N, _SHOWN.most_levels)
    if readings.preload_step is not None:
        yield from _of_labels(
            "preload_step", *np.unique(readings.preload_step, return_inverse=True)
        )
    yield from _of_numbers("torque_Nm", readings.torque_Nm, _SHOWN.most_torques)
    direction = readings.direction()
    for value, label in ((1, "rising"), (-1, "falling"), (0, "held")):
        if np.any(direction == value) and np.any(direction != value):
            rows = np.flatnonzero(direction == value)
            yield "direction", label, float(value), float(value), rows
    yield from _of_numbers("input_angle_deg", readings.input_angle_deg, _SHOWN.most_levels)
    _, first = np.unique(readings.run_index, return_index=True)
    yield from _of_labels("run", readings.run[first], readings.run_index)


def _of_labels(column: str, labels: NDArray[Any], index: Ints) -> Iterator[Division]:
    """A division for each label, where there are several."""
    for label, rows in zip(labels, _parts(index), strict=True) if len(labels) > 1 else ():
        yield column, str(label), None, None, rows


def _of_numbers(column: str, values: Floats, most: int) -> Iterator[Division]:
    levels = levels_of(values)
    if len(levels) < 2:
        return
    index = levels.index
    single = len(levels) <= most
    if not single:
        edges = np.linspace(levels.value[0], levels.value[-1], _SHOWN.ranges + 1)
        part = np.clip(np.searchsorted(edges, levels.value, side="right") - 1, 0, _SHOWN.ranges - 1)
        index = part[index]
    for i, rows in enumerate(_parts(index)):
        if not rows.size:
            continue
        # Adding 0 turns -0 into 0.
        low, high = (float(end) + 0.0 for end in (values[rows].min(), values[rows].max()))
        label = f"{low:g} to {high:g}"
        if single:
            label = f"{low:g}" if low == high else f"{levels.value[i]:.4g}"
        yield column, label, low, high, rows


def columns_of(r: Readings) -> dict[str, Any]:
    """Of each reading what a row begins with, before what a model says of it. The torques are those
    of the table, and those that were used where these are means; the direction is that of what was
    used."""
    means = r.torque_read_Nm is not None
    return {
        "line": r.line,
        "run": r.run,
        "time_s": r.time_s,
        "torque_Nm": r.torque_read_Nm if means else r.torque_Nm,
        "torque_used_Nm": r.torque_Nm if means else None,
        "preload_N": r.preload_N,
        "input_angle_deg": r.input_angle_deg,
        "direction": r.direction(),
        "elastic_angle_arcsec": r.elastic_angle_arcsec,
        "u_elastic_angle_arcsec": r.u_elastic_angle_arcsec,
    }


def as_rows(columns: dict[str, Any]) -> tuple[list[str], list[list[Any]]]:
    """Names of the columns that are there, and the rows of a table."""
    kept = {name: values.tolist() for name, values in columns.items() if values is not None}
    empty = [[None if v != v else v for v in values] for values in kept.values()]
    return list(kept), [list(row) for row in zip(*empty, strict=True)]
