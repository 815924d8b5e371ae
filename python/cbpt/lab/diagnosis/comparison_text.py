"""A comparison in words and tables, for a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from cbpt.errors import Say, said
from cbpt.lab.diagnosis.comparison_data import ComparisonData
from cbpt.lab.diagnosis.misfit import Misfit
from cbpt.lab.wording import layout
from cbpt.lab.wording.numbers import (
    angle_unit_of,
    in_words,
    name_of_size,
    rounded,
    significant,
)
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from cbpt.lab.selection.fit_effects import Number


def lines(c: ComparisonData, angle_unit: str, say: Say) -> Iterator[str]:
    """The report, line by line."""
    factor = ANGLE_UNITS[angle_unit]
    yield f"{len(c.readings)} readings of {c.readings.source} against the model"
    for status, lines in c.without_solution.items():
        shown = ", ".join(map(str, lines[:8])) + (", ..." if len(lines) > 8 else "")
        yield (
            f"The model has no solution at {len(lines)} readings ({status}), which are left out: "
            f"{c.readings.place}s {shown}"
        )
    yield from c.findings
    if c.overall is None:
        yield "Nothing can be compared: the model has no solution at any reading."
        return
    if c.before is not None:
        yield from _added(c, c.before, angle_unit)
    yield _verdict(c, angle_unit)
    if 2 * c.overall.readings >= len(c.readings):
        yield from _scatter(c, angle_unit)
        yield from _repeats(c, angle_unit)
    for hint in c.hints:
        yield f"Likely mistake: {hint}."
    misfit = c.overall
    yield ""
    headers = ["", "readings", "share of\nmisfit", "bias", "excess", "rmse", "largest", "chi2/dof"]
    headers[3:7] = [f"{name}\n{angle_unit}" for name in headers[3:7]]
    rows = [_row("all", 1.0, misfit, factor)]
    for column in dict.fromkeys(group.column for group in c.groups if group.column != "run"):
        rows += [
            _row(f"{column} {group.label}", group.share_of_misfit, group.misfit, factor)
            for group in c.groups
            if group.column == column
        ]
    yield layout.table(headers, rows)
    yield ""
    yield from _where(c, angle_unit)
    yield (
        f"largest error {_angle(misfit.largest_error_arcsec, angle_unit, 4)} on "
        f"{c.readings.place} {misfit.largest_error_line}; excess: residual counted in the "
        "direction of the torque; above 0 the drive is softer than the model"
    )
    if c.zero == "common":
        yield (
            f"offset: none subtracted; subtracting a common offset of "
            f"{_angle(c.best_common_zero_arcsec, angle_unit, 4)} would give an RMSE of "
            f"{_angle(c.rmse_with_best_zero_arcsec, angle_unit, 4)}; diagnose and fit always "
            "subtract one"
        )
    else:
        yield (
            f"offset: one fitted for each of {len(c.zero_arcsec)} runs and subtracted, as diagnose "
            "and fit do"
        )
    for note in c.readings.notes:
        yield f"Note: {angle_unit_of(angle_unit).retold(said(note, say))}"


def _row(label: str, share: float, misfit: Misfit, factor: float) -> list[Any]:
    angles = (
        misfit.bias_arcsec,
        misfit.excess_arcsec,
        misfit.rmse_arcsec,
        misfit.largest_error_arcsec,
    )
    chi2 = None if misfit.chi2_per_dof is None else significant(misfit.chi2_per_dof, 3)
    shown = [significant(angle * factor, 4) for angle in angles]
    return [label, misfit.readings, f"{share:.0%}", *shown, chi2]


def _verdict(c: ComparisonData, angle_unit: str) -> str:
    """How well the model does, in one sentence, and where it is worst in another."""
    assert c.overall is not None
    rmse = _angle(c.overall.rmse_arcsec, angle_unit)
    u = c.readings.u_elastic_angle_arcsec
    lost = len(c.readings) - c.overall.readings
    if u is None and 2 * lost > len(c.readings):
        return f"{_unsolved(c, lost)}\nAt the others: RMSE {rmse}; that says nothing of the model."
    if u is None:
        text = f"RMSE {rmse}; no uncertainty is stated."
    elif c.p_value is None or c.overall.chi2_per_dof is None:
        return (
            f"RMSE {rmse}; the fitted offsets leave no degrees of freedom, so agreement cannot be "
            "judged: measure more readings."
        )
    else:
        stated = _angle(float(np.median(u)), angle_unit)
        chi2 = f"chi2 per degree of freedom {c.overall.chi2_per_dof:.3g}"
        numbers = f"RMSE {rmse}, stated uncertainty {stated}, {chi2}."
        if lost:
            text = f"{_unsolved(c, lost)}\nAt the others: {numbers}"
        elif c.p_value >= 0.01:
            if c.p_value > 1 - 1e-6:
                return (
                    f"The residuals are far smaller than the stated uncertainty: {numbers}\n"
                    "A wrong model would agree as well: check the uncertainty."
                )
            return f"The model agrees with the readings: {numbers}"
        else:
            text = f"The model disagrees with the readings: {numbers}"
    worst = c.worst()
    if (
        worst is None
        or not worst.misfit.rmse_arcsec
        or (lost and c.p_value is not None and c.p_value >= 0.01)
    ):
        return text
    # With torques of both signs the mean hides what the direction of the torque shows.
    m = worst.misfit
    side = "beyond" if m.excess_arcsec > 0 else "short of"
    return (
        f"{text}\nThe error is largest at {worst.column} {worst.label}: "
        f"RMSE {_angle(m.rmse_arcsec, angle_unit)}, "
        f"the readings lie {_angle(abs(m.excess_arcsec), angle_unit)} {side} the model in "
        f"the direction of the torque ({worst.share_of_misfit:.0%} of the misfit, "
        f"{m.readings} of {c.overall.readings} readings)."
    )


def _unsolved(c: ComparisonData, lost: int) -> str:
    return (
        f"The model has no solution at {lost} of {len(c.readings)} measured loads: check the units "
        "of torque and preload."
    )


def _added(c: ComparisonData, before: ComparisonData, angle_unit: str) -> Iterator[str]:
    """What the fitted effects change, and their numbers."""
    factor = ANGLE_UNITS[angle_unit]
    names = list(dict.fromkeys(n.effect for n in c.numbers if n.added))
    if before.overall is None or c.overall is None:
        return
    then, now = (m.rmse_arcsec * factor for m in (before.overall, c.overall))
    text = (
        f"With {' and '.join(names)} fitted, the RMSE changes from {then:.3g} to {now:.3g} "
        f"{angle_unit}"
    )
    if before.overall.chi2_per_dof is not None and c.overall.chi2_per_dof is not None:
        text += (
            f", chi2 per degree of freedom from {before.overall.chi2_per_dof:.3g} to "
            f"{c.overall.chi2_per_dof:.3g}"
        )
    yield f"{text}."
    angle = angle_unit_of(angle_unit)
    rows = [
        [n.effect, *in_words((n.effect, _parameter(n)), n.value, n.u, angle=angle)]
        for n in c.numbers
    ]
    yield layout.table(["effect", "parameter", "value"], rows)


def _parameter(n: Number) -> str:
    """Its name; a number of drive or rig is called as its effect."""
    return name_of_size(n.effect) if n.name == n.effect else n.name


def _scatter(c: ComparisonData, angle_unit: str) -> Iterator[str]:
    """The misfit against what the readings themselves say of their scatter."""
    scatter, p = c.scatter, c.p_value_of_scatter
    if scatter is None or p is None or c.overall is None:
        return
    found = _angle(scatter.u_arcsec, angle_unit)
    along = (
        f" (correlation {scatter.correlation:g} between successive readings)"
        if scatter.correlation
        else ""
    )
    judged = _judged("scatter", p, c.overall.rmse_arcsec, scatter.u_arcsec)
    found += along
    if scatter.step_arcsec:
        step = _angle(scatter.step_arcsec, angle_unit)
        text = (
            f"The angles are recorded in steps of {step}, so their scatter is hardly known: about "
            f"{found}"
        )
        if p < 0.01:
            text += f"; even {judged}"
        elif scatter.ratio is None:
            text += f"; {judged}"
        yield f"{text}."
    elif scatter.ratio is None:
        yield f"Within runs the readings scatter by {found}; {judged}."
    elif scatter.off:
        which = "small" if scatter.ratio > 1 else "large"
        yield (
            f"The stated uncertainty looks too {which}: within runs the readings scatter by "
            f"{found}, {scatter.ratio:.2g} times as much; {judged}."
        )
    elif scatter.alike:
        yield f"Within runs the readings scatter by {found}, as the stated uncertainty says."
    else:
        yield (
            f"Within runs the readings scatter by {found}, {scatter.ratio:.2g} times the stated "
            "uncertainty; these readings do not tell whether that is chance."
        )


def _repeats(c: ComparisonData, angle_unit: str) -> Iterator[str]:
    """The misfit against what readings taken again say of their uncertainty."""
    found, p = c.repeats, c.p_value_of_repeats
    if found is None:
        return
    u = _angle(found.u_arcsec, angle_unit)
    if not found.steady:
        yield (
            f"Repeated readings differ by {u} ({found}), far more than the readings scatter within "
            "runs: something changes between the repeats."
        )
    elif p is not None and found.ratio is None:
        rmse_arcsec = c.overall.rmse_arcsec if c.overall else 0.0
        judged = _judged("uncertainty", p, rmse_arcsec, found.u_arcsec)
        yield f"The uncertainty was estimated from repeated readings: {u} ({found})."
        yield f"{judged[0].upper()}{judged[1:]}."
    elif p is not None:
        yield f"Repeated readings agree to {u} ({found})."


def _judged(what: str, p_value: float, rmse_arcsec: float, u_arcsec: float) -> str:
    """What an estimated uncertainty says of the model. Few degrees of freedom allow almost any
    misfit: one of more than twice the uncertainty is no agreement."""
    if p_value >= 0.01 and rmse_arcsec > 2 * u_arcsec:
        return f"this {what} is known too roughly to judge the model by it"
    judged = "agrees" if p_value >= 0.01 else "disagrees"
    return f"with this {what} the model {judged} with the readings"


def _angle(arcsec: float, unit: str, digits: int = 3) -> str:
    """An angle in a unit, with the unit."""
    return f"{rounded(arcsec * ANGLE_UNITS[unit], digits)} {unit}"


def _where(c: ComparisonData, angle_unit: str) -> Iterator[str]:
    """The regions in which the misfit stands out."""
    factor = ANGLE_UNITS[angle_unit]
    if not c.where:
        if c.p_value is not None and c.p_value < 0.01:
            yield "where: no region has a larger misfit than the others"
        return
    yield (
        "where the misfit is larger than elsewhere (p_value: the probability that noise alone "
        "causes this):"
    )
    headers = ["region", "readings", "share of\nmisfit", "bias", "excess", "p_value"]
    headers[3:5] = [f"{name}\n{angle_unit}" for name in headers[3:5]]
    rows: list[list[str | float]] = [
        [
            region.label,
            region.readings,
            f"{region.share_of_misfit:.0%}",
            significant(region.bias_arcsec * factor, 4),
            significant(region.excess_arcsec * factor, 4),
            significant(region.p_value, 2),
        ]
        for region in c.where
    ]
    yield layout.table(headers, rows)
