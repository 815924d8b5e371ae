"""The results of a fit as a table: value, uncertainty, and what it rests on.

    Result        one quantity
    Results       all of them; text, Markdown, CSV and plain values
    results_of    of a fit

After JCGM 100:2008 (GUM): standard uncertainties (k = 1), evaluated from the readings (type A) or
from what was known before (type B), the share of each in the variance, effective degrees of
freedom, an expanded uncertainty that covers 95 %, large correlations. Every quantity without an
uncertainty says why it has none.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from textwrap import wrap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.budget import TABLE, Budget, Combined, range_of
from cbpt.lab.inference.estimates import parameter, parameters_of, unit_of
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.inference.prediction import AtLoad
from cbpt.lab.model.priors import LOT, PRIORS
from cbpt.lab.wording import layout
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.numbers import (
    ARCSEC,
    AngleUnit,
    angle_unit_of,
    display,
    name_of_size,
    rounded,
    with_uncertainty,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Shown:
    """What a table of results shows."""

    large: float = 0.7
    """Correlations smaller than this are not told."""
    all: float = 0.9
    """A prior with so much of the variance is all there is."""
    fewest_left: int = 3


_SHOWN = _Shown()


@dataclass(frozen=True)
class Result:
    """One quantity. `u`, `coverage_factor`, `expanded` and `dof` are None where `why_no_u` says
    why; `dof` is None also where it is infinite."""

    name: str
    kind: str
    """`effect`, `number` (of drive or rig), `zero`, `noise`, `error` or `angle`."""
    value: float | None
    unit: str
    u: float | None = None
    """Standard uncertainty (k = 1)."""
    expanded: float | None = None
    """Half the width of an interval that covers 95 %."""
    coverage_factor: float | None = None
    dof: float | None = None
    """Effective degrees of freedom."""
    evaluation: str = ""
    """`A` from the readings, `B` from what was known before, `A+B`; empty without u."""
    rests_on: tuple[tuple[str, float], ...] = ()
    """What the variance comes from, with shares, the largest first."""
    correlated_with: tuple[tuple[str, float], ...] = ()
    """Other quantities with a correlation of 0.7 or more in size."""
    why_no_u: str = ""

    @property
    def rounded(self) -> tuple[str, str, str]:
        """Value, u and expanded uncertainty as text: two digits of the uncertainty, and the value
        to the same place."""
        if self.value is None:
            return "", "", ""
        if self.u is None or self.expanded is None:
            return rounded(self.value, 4), "", ""
        value, u, expanded = with_uncertainty(self.value, self.u, self.expanded)
        return value, u, expanded


@dataclass(frozen=True)
class Results(Reported):
    """A table of quantities."""

    rows: tuple[Result, ...]
    notes: tuple[str, ...] = ()
    """What holds for all of them."""

    def __iter__(self) -> Iterator[Result]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Result:
        found = next((row for row in self.rows if row.name == name), None)
        if found is None:
            known = ", ".join(row.name for row in self.rows)
            raise KeyError(f"{name!r} is not a name of the results, which are: {known}")
        return found

    def told_in(self, angle_unit: str) -> Results:
        """The same with small angles in another unit: arcsec, arcmin, deg, mrad, urad, rad."""
        angle = angle_unit_of(angle_unit)
        rows = tuple(_in_unit(row, angle) for row in self.rows)
        return Results(rows, tuple(map(angle.retold, self.notes)))

    def to_list(self) -> list[dict[str, Any]]:
        """As plain values, unrounded, the same that the JSON document has."""
        return [
            asdict(row)
            | {"rests_on": dict(row.rests_on)}
            | {"correlated_with": dict(row.correlated_with)}
            for row in self.rows
        ]

    def to_csv(self) -> str:
        """As CSV, unrounded."""
        file = io.StringIO()
        names = [name for name in asdict(self.rows[0]) if name not in _PAIRS]
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*names, *_PAIRS])
        for row in self.rows:
            values = asdict(row)
            writer.writerow(
                [
                    *("" if values[name] is None else values[name] for name in names),
                    *("; ".join(f"{n} {v:.3g}" for n, v in values[pair]) for pair in _PAIRS),
                ]
            )
        return file.getvalue()

    def to_markdown(self) -> str:
        """As a table in Markdown, rounded."""
        lines = ["| " + " | ".join(_HEADERS) + " |", "|" + "---|" * len(_HEADERS)]
        lines += [
            "| " + " | ".join(cell.replace("|", "\\|") for cell in _cells(row)) + " |"
            for row in self.rows
        ]
        return "\n".join([*lines, "", *self.notes]) + "\n"

    def to_json(self) -> str:
        """As JSON, unrounded."""
        document = {"results": self.to_list(), "notes": list(self.notes)}
        return json.dumps(document, indent=2, allow_nan=False)

    def report(self) -> str:
        """As text, rounded: a table, then what each quantity rests on."""
        table = [[row.name, *row.rounded, row.unit, row.evaluation] for row in self.rows]
        headers = ["quantity", "value", "u", "U (95 %)", "unit", "type"]
        lines = [layout.table(headers, table)]
        for row in self.rows:
            text = f"{row.name}: {_basis(row)}"
            lines += wrap(text, layout.prose_width(), initial_indent="  ", subsequent_indent="    ")
        for note in self.notes:
            lines += wrap(note, layout.prose_width())
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.report()


_PAIRS = ("rests_on", "correlated_with")
_HEADERS = ["quantity", "value", "u", "U (95 %)", "k", "unit", "type, sources of u"]


def _cells(row: Result) -> list[str]:
    k = "" if row.coverage_factor is None else f"{row.coverage_factor:.2f}"
    kind = f"{row.evaluation}: " if row.evaluation else ""
    return [row.name, *row.rounded, k, row.unit, kind + _basis(row)]


def _basis(row: Result) -> str:
    """What a quantity rests on, or why it has no uncertainty."""
    text = ", ".join(f"{source} {share:.0%}" for source, share in row.rests_on)
    if row.correlated_with:
        others = ", ".join(f"{name} {r:+.2f}" for name, r in row.correlated_with)
        text += f"; correlated with {others}"
    if row.why_no_u:
        text = f"no uncertainty: {row.why_no_u}"
    return text


def _in_unit(row: Result, angle: AngleUnit) -> Result:
    """A row whose small angle is told in another unit."""
    name, size = angle.renamed(row.name)
    if name == row.name and row.unit == ARCSEC.symbol:
        size = 1 / angle.per_arcsec
    value, u, expanded = (
        None if number is None else number / size for number in (row.value, row.u, row.expanded)
    )
    unit = row.unit if size == 1 else angle.of_unit(row.unit)
    others = tuple((angle.renamed(other)[0], r) for other, r in row.correlated_with)
    return replace(
        row, name=name, value=value, unit=unit, u=u, expanded=expanded, correlated_with=others
    )


# --- the quantities of a fit --------------------------------------------------------------


def results_of(
    fitter: Fitter,
    fit: Fit,
    errors: Sequence[tuple[str, float]] = (),
    load: AtLoad | None = None,
    why_no_u: str = "",
) -> Results:
    """Of a fit of one campaign. errors: names and root mean squares in arcsec; load: angles that
    were asked for; why_no_u: where no uncertainty of the fit can be trusted."""
    budget = Budget.of(fitter, fit)
    told: list[tuple[Result, Floats]] = []
    for unknown in fit.unknowns:
        if unknown.name.partition(".")[0] != LOT:
            told.append(_of_unknown(budget, unknown))
    told += _zeros(budget)
    if load is not None:
        told += _angles(load)
    rows = [
        replace(row, correlated_with=tuple(_correlated(budget, row, gradient, told)))
        for row, gradient in told
    ]
    rows += _chosen(fit)
    rows += _exact(fitter, fit)
    rows += _noise(fitter, fit, budget)
    fact = "it is a property of these readings, not an estimate"
    rows += [Result(name, "error", value, "arcsec", why_no_u=fact) for name, value in errors]
    if why_no_u:
        rows = [_without(row, why_no_u) if row.u is not None else row for row in rows]
    order = ["effect", "number", "zero", "angle", "noise", "error"]
    rows.sort(key=lambda row: order.index(row.kind))
    return Results(tuple(rows), tuple(_notes(load)))


def _without(row: Result, why: str) -> Result:
    return Result(row.name, row.kind, row.value, row.unit, why_no_u=why)


def _with(row: Result, found: Combined | None, size: float = 1.0) -> Result:
    """With its uncertainty; `size` is what one unit of the row is, in that of the budget."""
    if found is None:
        return replace(row, why_no_u="the readings do not determine it")
    k = found.coverage_factor
    return replace(
        row,
        u=found.u / size,
        expanded=k * found.u / size,
        coverage_factor=k,
        dof=found.dof if np.isfinite(found.dof) else None,
        evaluation=found.evaluation,
        rests_on=tuple(found.shares.items()),
    )


def _of_unknown(budget: Budget, unknown: Unknown) -> tuple[Result, Floats]:
    """A parameter of an effect, or a number of the drive or the rig."""
    effect, _, name = unknown.name.partition(".")
    if not name:
        name = name_of_size(effect)
    label, size = display(effect, name)
    kind = "number" if effect in PRIORS else "effect"
    row = Result(f"{effect}.{label}", kind, budget.fit.value(unknown) / size, unit_of(label))
    gradient = budget.gradient(unknown)
    why = parameter(budget.fit, unknown)["why_no_u"]
    if why:
        return replace(row, why_no_u=why), gradient
    row = _with(row, budget.combined(gradient), size)
    ranges = {range_of(each) for each in budget.fit.unknowns}
    if max((share for source, share in row.rests_on if source in ranges), default=0.0) > _SHOWN.all:
        row = _without(row, "the readings say no more about it than its plausible range does")
    return row, gradient


def _zeros(budget: Budget) -> Iterator[tuple[Result, Floats]]:
    """The common offset; those of runs are no quantities that anyone wants to know."""
    fit = budget.fit
    if len(fit.offsets_arcsec) == 1:
        gradient = np.zeros(len(budget.covariance))
        gradient[-1] = 1.0
        row = Result("zero of the readings", "zero", float(fit.offsets_arcsec[0]), "arcsec")
        yield _with(row, budget.combined(gradient)), gradient


def _angles(load: AtLoad) -> Iterator[tuple[Result, Floats]]:
    for i, angle in enumerate(load.elastic_angle_arcsec.tolist()):
        preload = "" if np.isnan(load.preload_N[i]) else f"{load.preload_N[i]:g} N, "
        name = (
            f"elastic angle at {load.torque_Nm[i]:g} N m, {preload}{load.input_angle_deg[i]:g} deg"
        )
        part = load.parts[i]
        if not np.isfinite(angle):
            row = Result(name, "angle", None, "arcsec", why_no_u=f"no solution: {load.status[i]}")
        elif part is None:
            why = load.why_no_u or "no fitted parameter changes it"
            row = Result(name, "angle", angle, "arcsec", why_no_u=why)
        else:
            row = _with(Result(name, "angle", angle, "arcsec"), part)
        yield row, load.gradients[i]


def _correlated(
    budget: Budget, row: Result, gradient: Floats, told: Sequence[tuple[Result, Floats]]
) -> Iterator[tuple[str, float]]:
    for other, g in told:
        if other is row or row.u is None or other.u is None:
            continue
        # What the case's table leaves open is of the one alone.
        r = budget.correlation(gradient, g) * _of_the_fit(row) * _of_the_fit(other)
        if abs(r) >= _SHOWN.large:
            yield other.name, r


def _of_the_fit(row: Result) -> float:
    """The part of an uncertainty that the unknowns of the fit make, of its size."""
    return float(np.sqrt(1 - dict(row.rests_on).get(TABLE, 0.0)))


def _chosen(fit: Fit) -> Iterator[Result]:
    """What was chosen and not fitted, and what many numbers stand for."""
    for variant in fit.hypothesis.variants:
        for name, value in variant.fixed:
            label, size = display(variant.effect, name)
            why = "it was chosen among the forms of the effect, not fitted"
            full = f"{variant.effect}.{label}"
            yield Result(full, "effect", value / size, unit_of(label), why_no_u=why)
    if any(v.effect == LOT for v in fit.hypothesis.variants):
        spread = parameters_of(fit, LOT)["spread_m"]
        value = 1e6 * spread["value"]
        yield Result(f"{LOT}.spread_um", "effect", value, "um", why_no_u=spread["why_no_u"])


def _exact(fitter: Fitter, fit: Fit) -> Iterator[Result]:
    """Numbers that are stated without any uncertainty."""
    free = {u.name.partition(".")[0] for u in fit.unknowns}
    for effect, key in PRIORS.items():
        if effect not in free and fitter.campaign.priors.get(effect) == 0:
            name = name_of_size(effect)
            label, size = display(effect, name)
            value = fitter.neutral(effect, name) / size
            why = f"the case states it as exact ({key} = 0)"
            yield Result(f"{effect}.{label}", "number", value, unit_of(label), why_no_u=why)


def _noise(fitter: Fitter, fit: Fit, budget: Budget) -> Iterator[Result]:
    """The uncertainty of a reading, known to so many degrees of freedom, and its structure."""
    u = fit.noise.scale * float(np.sqrt(np.mean(fitter.campaign.u_arcsec**2)))
    row = Result("u of a reading", "noise", u, "arcsec")
    if budget.dof < _SHOWN.fewest_left or fitter.campaign.step_arcsec:
        coarse = "it is smaller than the step of the display"
        few = "there are too few degrees of freedom"
        yield replace(row, why_no_u=coarse if fitter.campaign.step_arcsec else few)
    else:
        found = Combined(u / float(np.sqrt(2 * budget.dof)), {"readings": 1.0}, budget.dof)
        yield _with(row, found)
    chosen = "the curvature of the likelihood was not computed for it"
    if fit.noise.offset_arcsec:
        yield Result(
            "spread of the zeros of runs",
            "noise",
            fit.noise.offset_arcsec,
            "arcsec",
            why_no_u=chosen,
        )
    if fit.noise.correlation:
        yield Result(
            "correlation from reading to reading",
            "noise",
            fit.noise.correlation,
            "",
            why_no_u=chosen,
        )


def _notes(load: AtLoad | None) -> Iterator[str]:
    yield (
        "u: standard uncertainty (k = 1), provided that the model of the answer is right; U = k u: "
        "expanded uncertainty, 95 %, with k from the effective degrees of freedom."
    )
    if load is None:
        return
    if not load.inside.all():
        yield "Loads beyond those of the readings are extrapolated; u does not cover that."
    for name, angles in load.by_rival_arcsec.items():
        there = ", ".join(rounded(angle, 4) for angle in angles)
        yield f"By another probable combination, {name}: {there} arcsec."
