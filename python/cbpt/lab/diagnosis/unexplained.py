"""A misfit that nothing in the library explains.

card           what it depends on, ready to be written as an own effect
measure_next   what to measure next, in words
shape_of       how the misfit goes over what it depends on
column         a column of the table, or one made from it, as numbers
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.sparse_term import draft
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.selection.lack_of_fit import rate_of, run_time
from cbpt.lab.selection.scan import DIRECTIONS, label_of
from cbpt.lab.wording.names import columns_in_words
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit, rounded

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class _Shown:
    """How much is listed."""

    most_levels: int = 12
    stretches: int = 6
    most_lines: int = 16
    no_place: tuple[str, ...] = ("run", "preload_step", "torque_rate", "order")
    """Their values are labels, places or a rate: where they lie tells people nothing."""


_SHOWN = _Shown()


def card(d: DiagnosisData) -> dict[str, Any]:
    """Columns it depends on, where it is strongest, harmonic of the input angle, shape in words."""
    lack_of_fit = d.verdict.lack_of_fit
    assert lack_of_fit is not None
    f = lack_of_fit.fitted_arcsec
    columns = list(lack_of_fit.columns)
    found = draft(d)
    return {
        "depends_on": columns,
        "regime": _regime(d, f),
        "harmonic": _harmonic(d, f) if "input_angle_deg" in columns else None,
        "expression": found.effect.expression if found else None,
        "effect_toml": found.effect.to_toml() if found else None,
        "expression_held_out_rmse_arcsec": found.held_out_rmse_arcsec if found else None,
        "rms_arcsec": float(np.sqrt(np.mean(f**2))),
        "noise_arcsec": _noise_arcsec(d),
        "strong_where": {name: list(ends) for name, ends in _strong_where(d).items()},
        "measure_next": measure_next(d),
        "shape": shape_of(d),
    }


def measure_next(d: DiagnosisData) -> str:
    """Advice in place of a computed run, which needs a known effect."""
    lack_of_fit = d.verdict.lack_of_fit
    assert lack_of_fit is not None
    columns, f = list(lack_of_fit.columns), np.abs(lack_of_fit.fitted_arcsec)
    placed = {c: column(d, c) for c in columns if c not in _SHOWN.no_place}
    most = int(np.argmax(f))
    spot = label_of({c: (float(v[most]), float(v[most])) for c, v in placed.items()}, None)
    strong = _strong_where(d)
    part = {c: strong[c] for c, v in placed.items() if strong and strong[c] != _ends(v)}
    left = "what remains" if d.verdict.effects else "the misfit"
    said = (
        f"No known effect explains {left}, so no further run can be computed from it. In these "
        f"readings it depends on {columns_in_words(columns)}"
    )
    said += f" and is largest near {spot}" if spot else ""
    if part:
        said += f"; it exceeds twice the noise only at {label_of(part, None)}"
    if not strong:
        said += "; no single reading shows it, as it stays below twice the noise"
    if "order" in columns:
        return (
            f"{said}. Measure again, and write down the time and the temperature of each reading."
        )
    free = [c for c in columns if c != "run"]
    if not free:
        return f"{said}. Repeat a run unchanged, to see whether the misfit is the same."
    # What no single reading shows takes the mean of several.
    more = "Take each reading there several times" if not strong else "Measure more readings there"
    where = f"{more}, and vary" if spot else "Vary"
    alone = "one at a time" if len(free) > 1 else "alone"
    wait = " (for time: hold a load and wait)" if {"time_s", "run_time_s"} & set(free) else ""
    return f"{said}. {where} {columns_in_words(free)} {alone}, with all else constant{wait}."


def _noise_arcsec(d: DiagnosisData) -> float:
    """Noise of a reading beside the lack of fit."""
    lack_of_fit = d.verdict.lack_of_fit
    assert lack_of_fit is not None
    return lack_of_fit.noise.scale * float(np.median(d.competition.campaign.u_arcsec))


def _strong_where(d: DiagnosisData) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each column where the lack of fit exceeds twice the noise."""
    lack_of_fit = d.verdict.lack_of_fit
    assert lack_of_fit is not None
    strong = np.abs(lack_of_fit.fitted_arcsec) > 2 * _noise_arcsec(d)
    return {c: _ends(column(d, c)[strong]) for c in lack_of_fit.columns if strong.any()}


def _ends(values: Floats) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def column(d: DiagnosisData, name: str) -> Floats:
    """A column of the table, or one made from it, as numbers."""
    readings = d.readings
    if name == "run_time_s":
        return run_time(readings)
    if name == "torque_rate":
        return np.abs(rate_of(readings))
    if name == "direction":
        return readings.direction().astype(np.float64)
    if name == "preload_step" and d.readings.preload_step is not None:
        return np.unique(d.readings.preload_step, return_inverse=True)[1].astype(np.float64)
    if name == "order":
        return np.arange(float(len(readings)))
    if name == "run":
        return readings.run_index.astype(np.float64)
    return np.asarray(getattr(readings, name), dtype=np.float64)


def shape_of(d: DiagnosisData, angle: AngleUnit = ARCSEC) -> list[str]:
    """The misfit over what it depends on, line by line."""
    lack_of_fit = d.verdict.lack_of_fit
    assert lack_of_fit is not None
    f = lack_of_fit.fitted_arcsec * angle.per_arcsec
    # Before something began there is nothing, but for what is left of a mean.
    f = np.where(np.abs(f) < 1e-9 * np.abs(f).max(initial=0.0), 0.0, f)
    return list(_shape(d, list(lack_of_fit.columns), f))[: _SHOWN.most_lines]


def _shape(d: DiagnosisData, columns: list[str], f: Floats) -> Iterator[str]:
    """Lines such as `input_angle_deg 130: -5.9 at -8, ... +10.6 at 8 torque_Nm`, in arcsec."""
    along, across = columns[0], columns[1:]
    for label, rows in _cells(d, across):
        parts = [
            f"{_signed(float(f[rows & part].mean()))} at {text}"
            for text, part in _parts(d, along)
            if (rows & part).any()
        ]
        yield f"{label}{', '.join(parts)} {along}"


_SAID = {"direction": "torque"}
"""Columns that people call otherwise: `torque rising`."""


def _signed(value: float) -> str:
    return f"{'+' if value > 0 else ''}{rounded(value)}"


def _cells(d: DiagnosisData, columns: list[str]) -> Iterator[tuple[str, Mask]]:
    """Every combination of levels or stretches of some columns."""
    if not columns:
        yield "", np.ones(len(d.readings), dtype=bool)
        return
    for text, part in _parts(d, columns[0]):
        for label, rows in _cells(d, columns[1:]):
            if (part & rows).any():
                yield f"{_SAID.get(columns[0], columns[0])} {text}: {label}", part & rows


def _parts(d: DiagnosisData, name: str) -> Iterator[tuple[str, Mask]]:
    """The levels of a column, or stretches of it where there are many."""
    values = column(d, name)
    named = {"run": d.readings.run, "preload_step": d.readings.preload_step}.get(name)
    found = levels_of(values)
    if len(found) <= _SHOWN.most_levels:
        for number, level in enumerate(found.value):
            part = found.index == number
            text = DIRECTIONS[int(level)] if name == "direction" else f"{level:g}"
            yield (text if named is None else str(named[part][0])), part
        return
    edges = np.unique(np.quantile(values, np.linspace(0, 1, _SHOWN.stretches + 1))) + 0.0  # no -0
    for number, (low, high) in enumerate(pairwise(edges)):
        part = (values > low if number else values >= low) & (values <= high)
        if named is None:
            yield f"{low:.3g} to {high:.3g}", part
        elif part.any():
            first, last = (named[part][pick(values[part])] for pick in (np.argmin, np.argmax))
            yield f"{first} to {last}", part


def _regime(d: DiagnosisData, f: Floats) -> str | None:
    """The contact regime that holds nearly all of it, if one does."""
    model = d.competition.fitter.model
    regime = model.regimes(d.after.point.values)
    total = float(np.sum(f**2))
    for name in np.unique(regime):
        part = regime == name
        if part.sum() < 0.9 * len(f) and float(np.sum(f[part] ** 2)) > 0.9 * total:
            return str(name)
    return None


def _harmonic(d: DiagnosisData, f: Floats) -> int | None:
    """The harmonic of the input angle that carries most of it, where the angles can tell."""
    angle = np.deg2rad(d.readings.input_angle_deg)
    distinct = len(np.unique(np.round(np.mod(angle, 2 * np.pi), 6)))
    # The sign of the torque is not the angle's doing.
    g = f * np.where(d.readings.torque_Nm < 0, -1.0, 1.0)
    power = [
        float(np.sum(g * np.cos(h * angle)) ** 2 + np.sum(g * np.sin(h * angle)) ** 2)
        for h in range(1, (distinct - 1) // 2 + 1)
    ]
    return int(np.argmax(power)) + 1 if len(power) > 1 else None
