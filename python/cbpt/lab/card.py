"""A misfit that nothing in the library explains: what it depends on, ready to be written as an own effect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.structure import rate_of, run_time

if TYPE_CHECKING:
    from cbpt.lab.answer import Diagnosis

Floats = NDArray[np.float64]


def card(d: Diagnosis) -> dict[str, Any]:
    """Columns, where it is strongest, harmonic of the input angle, and its shape in words."""
    pattern = d.verdict.pattern
    assert pattern is not None
    r = d.after.residual_arcsec
    u = d.competition.campaign.u_arcsec * d.after.noise.scale
    values = {name: column(d, name) for name in pattern.columns}
    return {
        "depends_on": list(pattern.columns),
        "regime": None,
        "harmonic": _harmonic(d) if "input_angle_deg" in pattern.columns else None,
        "expression": None,
        "shape": [line for name, v in values.items() for line in _along(name, v, r, u)],
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
    if name == "run":
        return readings.run_index.astype(np.float64)
    return np.asarray(getattr(readings, name), dtype=np.float64)


def _along(name: str, values: Floats, residual: Floats, u: Floats) -> list[str]:
    """RMS of the misfit over stretches of a column."""
    edges = np.unique(np.quantile(values, np.linspace(0, 1, 9)))
    if len(np.unique(values)) <= 12:
        stretches = [(v, v) for v in np.unique(values)]
    else:
        stretches = list(zip(edges[:-1], edges[1:], strict=True))
    out = []
    for low, high in stretches:
        rows = (values >= low) & (values <= high)
        if rows.any():
            rms = float(np.sqrt(np.mean(residual[rows] ** 2)))
            size = rms / float(np.sqrt(np.mean(u[rows] ** 2)))
            span = f"{low:g}" if low == high else f"{low:g} to {high:g}"
            out.append(
                f"{name} {span}: misfit {rms:.2f} arcsec rms, {size:.1f} x noise, mean {residual[rows].mean():+.2f}"
            )
    return out


def _harmonic(d: Diagnosis) -> int | None:
    """The harmonic of the input angle that carries most of the misfit."""
    angle = np.deg2rad(d.readings.input_angle_deg)
    r = d.after.residual_arcsec
    power = []
    for h in range(1, 9):
        x = np.column_stack([np.cos(h * angle), np.sin(h * angle)])
        power.append(float(np.sum((x.T @ r) ** 2)))
    return int(np.argmax(power)) + 1 if max(power) > 0 else None
