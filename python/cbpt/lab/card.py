"""A misfit that nothing in the library explains: what it depends on, ready to be written as an
own effect."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.draft import draft
from cbpt.lab.levels import levels_of
from cbpt.lab.structure import rate_of, run_time

if TYPE_CHECKING:
    from cbpt.lab.answer import Diagnosis

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_MOST_LEVELS = 12
_STRETCHES = 6
_MOST_LINES = 16


def card(d: Diagnosis) -> dict[str, Any]:
    """Columns it depends on, where it is strongest, harmonic of the input angle, shape in words."""
    pattern = d.verdict.pattern
    assert pattern is not None
    f = pattern.fitted_arcsec
    noise = pattern.noise.scale * float(np.median(d.competition.campaign.u_arcsec))
    columns = list(pattern.columns)
    strong = np.abs(f) > 2 * noise
    found = draft(d)
    return {
        "depends_on": columns,
        "regime": _regime(d, f),
        "harmonic": _harmonic(d, f) if "input_angle_deg" in columns else None,
        "expression": found.effect.expression if found else None,
        "effect_toml": found.effect.to_toml() if found else None,
        "expression_held_out_rmse_arcsec": found.held_out_rmse_arcsec if found else None,
        "rms_arcsec": float(np.sqrt(np.mean(f**2))),
        "noise_arcsec": noise,
        "strong_where": {
            name: [float(v[strong].min()), float(v[strong].max())]
            for name, v in ((name, column(d, name)) for name in columns)
            if strong.any()
        },
        "shape": list(_shape(d, columns, f))[:_MOST_LINES],
    }


def column(d: Diagnosis, name: str) -> Floats:
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
    if name == "run":
        return readings.run_index.astype(np.float64)
    return np.asarray(getattr(readings, name), dtype=np.float64)


def _shape(d: Diagnosis, columns: list[str], f: Floats) -> Iterator[str]:
    """Lines such as `input_angle_deg 130: -5.9 at -8, ... +10.6 at 8 torque_Nm`, in arcsec."""
    along, across = columns[0], columns[1:]
    for label, rows in _cells(d, across):
        parts = [
            f"{float(f[rows & part].mean()):+.2f} at {text}"
            for text, part in _parts(column(d, along))
            if (rows & part).any()
        ]
        yield f"{label}{', '.join(parts)} {along}"


def _cells(d: Diagnosis, columns: list[str]) -> Iterator[tuple[str, Mask]]:
    """Every combination of levels or stretches of some columns."""
    if not columns:
        yield "", np.ones(len(d.readings), dtype=bool)
        return
    for text, part in _parts(column(d, columns[0])):
        for label, rows in _cells(d, columns[1:]):
            if (part & rows).any():
                yield f"{columns[0]} {text}: {label}", part & rows


def _parts(values: Floats) -> Iterator[tuple[str, Mask]]:
    """The levels of a column, or stretches of it where there are many."""
    found = levels_of(values)
    if len(found) <= _MOST_LEVELS:
        for number, level in enumerate(found.value):
            yield f"{level:g}", found.index == number
        return
    edges = np.unique(np.quantile(values, np.linspace(0, 1, _STRETCHES + 1)))
    for number, (low, high) in enumerate(pairwise(edges)):
        above = values > low if number else values >= low
        yield f"{low:.3g} to {high:.3g}", above & (values <= high)


def _regime(d: Diagnosis, f: Floats) -> str | None:
    """The contact regime that holds nearly all of it, if one does."""
    model = d.competition.fitter.model
    regime = model.regimes(d.after.point.values)
    total = float(np.sum(f**2))
    for name in np.unique(regime):
        part = regime == name
        if part.sum() < 0.9 * len(f) and float(np.sum(f[part] ** 2)) > 0.9 * total:
            return str(name)
    return None


def _harmonic(d: Diagnosis, f: Floats) -> int | None:
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
