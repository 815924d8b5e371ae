"""A first draft of a term that nothing in the library holds: a sparse expression for the misfit.

    Draft   an expression of at most three terms, with its parameters and the error it was judged by
    draft   finds it, or None where no term predicts what it has not seen

The dictionary holds products: how a term goes with the torque, times where or when it acts. Terms
are taken one by one, each the one that takes most misfit with all numbers of the drive refitted. A
term more is kept while it lowers the error on readings held back, from whose part of the table it
was not chosen either.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbpt._core import OwnEffect
from cbpt.effects import expression
from cbpt.lab.covariance.linear_gaussian import Margin, Whitener
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.model.priors import ARCSEC
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.selection.lack_of_fit import run_time
from cbpt.lab.wording.numbers import significant

if TYPE_CHECKING:
    from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Bounds = tuple[float, float, float, str]
"""Start, least and greatest value, unit."""


@dataclass(frozen=True)
class _Limits:
    """How far terms are added."""

    most_terms: int = 3
    enough: float = 0.95
    """A term more has to bring the held-out error below this share of what it was."""
    most_angles: int = 12


_LIMITS = _Limits()


@dataclass(frozen=True)
class Factor:
    """A part of a term: its text, whose shapes stand in braces, the shapes, and its values."""

    text: str
    unit: str
    values: Floats
    shapes: tuple[tuple[str, Bounds], ...] = ()


@dataclass(frozen=True)
class Draft:
    """An expression that a case file takes."""

    effect: OwnEffect
    held_out_rmse_arcsec: float
    held_out_rmse_without_arcsec: float


def draft(d: DiagnosisData, id: str = "my_effect") -> Draft | None:
    """Of what a diagnosis calls unknown."""
    lack_of_fit = d.verdict.lack_of_fit
    assert lack_of_fit is not None
    fitter, c = d.competition.fitter, d.competition.campaign
    fit = d.competition.fits[lack_of_fit.base]
    y, x, precision = fitter.linear(fit)
    terms = list(dictionary(d.readings))
    columns = np.column_stack([load.values * where.values for load, where in terms]) / ARCSEC
    size = np.linalg.norm(columns, axis=0)
    terms = [term for term, s in zip(terms, size, strict=True) if s > 0]
    columns = columns[:, size > 0] / size[size > 0]
    size = size[size > 0]

    def problem(rows: Mask) -> _Problem:
        noise = lack_of_fit.noise
        if noise.inflation is not None:
            noise = replace(noise, inflation=noise.inflation[rows])
        whitener = Whitener.of(noise, c.u_arcsec[rows], c.rows.select(rows))
        return _Problem(whitener(y[rows]), whitener(x[rows]), precision, whitener(columns[rows]))

    errors = np.zeros((_LIMITS.most_terms + 1, len(y)))
    numbers = np.unique(d.fold)
    if len(numbers) < 2:
        return None
    for number in numbers:
        held = d.fold == number
        part = problem(~held)
        path = part.path()
        for k in range(_LIMITS.most_terms + 1):
            mode = part.solved(path[:k])
            shown = np.column_stack([x[held], columns[held][:, path[:k]]])
            errors[k, held] = y[held] - shown @ mode
    if lack_of_fit.noise.offset_arcsec or c.offsets.shape[1] > 1:
        # An offset of its own that each run has cannot be predicted.
        for error in errors:
            error -= (np.bincount(c.rows.run_index, error) / np.bincount(c.rows.run_index))[
                c.rows.run_index
            ]
    rmse = np.sqrt(np.mean(errors**2, axis=1))
    count = 0
    while count < _LIMITS.most_terms and rmse[count + 1] < _LIMITS.enough * rmse[count]:
        count += 1
    if not count:
        return None
    whole = problem(np.ones(len(y), dtype=bool))
    path = whole.path()[:count]
    found = whole.solved(path)[x.shape[1] :] / size[path]
    effect = _effect(id, [terms[i] for i in path], found)
    return Draft(effect, float(rmse[count]), float(rmse[0]))


class _Problem:
    """Whitened readings, columns of the unknowns with their precisions, and of all terms."""

    def __init__(self, y: Floats, x: Floats, precision: Floats, columns: Floats) -> None:
        # The hair of precision is for offsets of runs that are held back: their columns are empty.
        self.y, self.x, self.precision, self.columns = y, x, precision + 1e-12, columns
        margin = Margin.of(y, x, self.precision)
        left = margin.left(columns)
        self.gram = columns.T @ left
        self.projection = left.T @ margin.y
        self.own = np.einsum("ij,ij->j", columns, columns)

    def path(self) -> list[int]:
        """Terms in the order in which they take most misfit, each given those before it."""
        gram, projection = self.gram.copy(), self.projection.copy()
        taken: list[int] = []
        for _ in range(_LIMITS.most_terms):
            left = np.diag(gram)
            alive = left > 1e-4 * self.own
            gain = np.where(alive, projection**2 / np.where(alive, left, 1.0), -1.0)
            best = int(np.argmax(gain))
            taken.append(best)
            column = gram[:, best] / gram[best, best]
            projection = projection - column * projection[best]
            gram = gram - np.outer(column, gram[best])
        return taken

    def solved(self, path: list[int]) -> Floats:
        """Most probable values of the unknowns and of the terms of a path."""
        columns = np.column_stack([self.x, self.columns[:, path]])
        precision = np.r_[self.precision, np.full(len(path), 1e-12)]
        return np.asarray(Margin.of(self.y, columns, precision).mode)


# --- the dictionary ---------------------------------------------------------------------------


def dictionary(readings: Readings) -> Iterator[tuple[Factor, Factor]]:
    """Every way to go with the torque times every place and time to act."""
    wheres = list(_wheres(readings))
    for load in _loads(readings):
        for where in wheres:
            if load.text != "1" or where.text != "1":
                yield load, where


def _loads(r: Readings) -> Iterator[Factor]:
    t = r.torque_Nm
    most, sign = float(np.abs(t).max()), np.sign(t)
    yield Factor("1", "", np.ones(len(t)))
    yield Factor("torque_Nm", "/(N m)", t)
    yield Factor("abs(torque_Nm)", "/(N m)", np.abs(t))
    yield Factor("sign(torque_Nm)", "", sign)
    yield Factor("torque_Nm^2", "/(N m)^2", t**2)
    yield Factor("torque_Nm * abs(torque_Nm)", "/(N m)^2", t * np.abs(t))
    yield Factor("torque_Nm^3", "/(N m)^3", t**3)
    direction = r.direction().astype(np.float64)
    if np.ptp(direction):
        yield Factor("direction", "", direction)
        yield Factor("direction * abs(torque_Nm)", "/(N m)", direction * np.abs(t))
    for share in (0.2, 0.35, 0.5, 0.65, 0.8):
        start = significant(share * most, 3)
        shape = (("t", (start, 0.0, most, "N m")),)
        over = np.maximum(np.abs(t) - start, 0.0)
        yield Factor("sign(torque_Nm) * max(abs(torque_Nm) - {t}, 0)", "/(N m)", sign * over, shape)
        for side, values in (
            ("torque_Nm", np.maximum(t - start, 0.0)),
            ("-torque_Nm", np.maximum(-t - start, 0.0)),
        ):
            yield Factor(f"max({side} - {{t}}, 0)", "/(N m)", values, shape)


def _wheres(r: Readings) -> Iterator[Factor]:
    n = len(r)
    yield Factor("1", "", np.ones(n))
    if r.preload_N is not None and np.ptp(r.preload_N):
        p = r.preload_N
        yield Factor("preload_N", "/N", p)
        yield Factor("1 / preload_N", "*N", 1 / p)
        yield from _bumps("preload_N", "N", p)
    angle = np.deg2rad(r.input_angle_deg)
    distinct = np.unique(np.round(np.mod(angle, 2 * np.pi), 6))
    for harmonic in range(1, min((len(distinct) - 1) // 2, 4) + 1):
        for name, function in (("cos", np.cos), ("sin", np.sin)):
            yield Factor(f"{name}({harmonic} * input_angle_rad)", "", function(harmonic * angle))
    if len(distinct) == 2:
        # All that two angles tell, in one number.
        yield Factor(f"cos(input_angle_rad - {distinct[0]:.4g})", "", np.cos(angle - distinct[0]))
    if 2 < len(distinct) <= _LIMITS.most_angles:
        gap = float(np.diff(np.r_[distinct, distinct[0] + 2 * np.pi]).min())
        sharp = significant(np.clip(4 / (1 - np.cos(gap)), 1.0, 200.0), 3)
        for centre in distinct:
            c = significant(centre, 4)
            shapes = (("c", (c, c - gap / 2, c + gap / 2, "rad")), ("k", (sharp, 0.5, 500.0, "")))
            values = np.exp(sharp * (np.cos(angle - c) - 1))
            yield Factor("exp({k} * (cos(input_angle_rad - {c}) - 1))", "", values, shapes)
    if r.time_s is not None:
        time = r.time_s - r.time_s[0]
        yield Factor("time_s", "/s", time)
        for moment in np.quantile(time, np.linspace(0.1, 0.9, 9)):
            start = significant(moment, 4)
            shape = (("m", (start, 0.0, float(time.max()), "s")),)
            yield Factor("(1 + sign(time_s - {m})) / 2", "", (1 + np.sign(time - start)) / 2, shape)
        since = run_time(r)
        if np.ptp(since):
            yield Factor("run_time_s", "/s", since)
            for tau in (3.0, 30.0, 300.0):
                shape = (("tau", (tau, 0.1, 1e5, "s")),)
                yield Factor("log(1 + run_time_s / {tau})", "", np.log1p(since / tau), shape)
    if r.temperature_degC is not None and np.ptp(r.temperature_degC):
        change = r.temperature_degC - r.temperature_degC[0]
        yield Factor("temperature_difference_K", "/K", change)
    if r.cycle is not None and np.ptp(r.cycle):
        done = np.asarray(r.cycle, dtype=np.float64)
        yield Factor("cycles_done", "", done - done.min())


def _bumps(name: str, unit: str, values: Floats) -> Iterator[Factor]:
    """Near one level of a column."""
    levels = levels_of(values).value
    if not 2 < len(levels) <= _LIMITS.most_angles:
        return
    for number, level in enumerate(levels):
        gap = float(np.abs(np.delete(levels, number) - level).min())
        c, w = significant(level, 4), significant(0.5 * gap, 3)
        shapes = (("c", (c, c - gap / 2, c + gap / 2, unit)), ("w", (w, 0.2 * w, 10 * w, unit)))
        bump = np.exp(-(((values - c) / w) ** 2))
        yield Factor(f"exp(-(({name} - {{c}}) / {{w}})^2)", "", bump, shapes)


def _effect(id: str, terms: list[tuple[Factor, Factor]], sizes: Floats) -> OwnEffect:
    parameters: dict[str, dict[str, float | str]] = {}
    texts = []
    for number, ((load, where), size) in enumerate(zip(terms, sizes, strict=True), 1):
        name = f"a{number}"
        most = significant(100 * abs(size), 2)
        start = significant(size, 5)
        unit = f"rad{load.unit}{where.unit}"
        parameters[name] = {"unit": unit, "start": start, "min": -most, "max": most}
        factors = []
        for factor in (load, where):
            if factor.text == "1":
                continue
            names = {}
            for shape, (value, low, high, of) in factor.shapes:
                names[shape] = f"{shape}{number}"
                parameters[names[shape]] = {
                    "unit": of,
                    "start": value,
                    "min": significant(low, 6),
                    "max": significant(high, 6),
                }
            factors.append(factor.text.format(**names))
        texts.append(" * ".join([name, *factors]))
    return expression(id, "series", " + ".join(texts), parameters)
