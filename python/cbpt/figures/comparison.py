"""A comparison as a picture: readings and model over torque, the residual below them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import (
    Points,
    bare,
    colour,
    draw_points,
    model_curves,
    new_figure,
    save,
    titled,
)
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Box:
    """A region in which the misfit stands out."""

    rows: NDArray[np.bool_]
    """Its readings, shape (n,)."""
    label: str
    share_of_misfit: float


@dataclass(frozen=True, eq=False)
class ComparisonPicture:
    """What is drawn of a comparison. Angles in arcsec, arrays of shape (n,)."""

    points: Points
    """Readings, with the offsets of their runs taken off."""
    model_arcsec: Floats
    residual_arcsec: Floats
    has_effects: bool
    """Whether the model may differ between torque rising and falling."""
    regions: Sequence[Box]
    rmse_arcsec: float | None


def draw_comparison(c: ComparisonPicture, path: str | os.PathLike[str], angle_unit: str) -> None:
    """Draw `c` to `path` (SVG, PNG or PDF by its ending), angles in `angle_unit`."""
    figure = new_figure(path, 8, 7)
    factor, points = ANGLE_UNITS[angle_unit], c.points
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    for setting, torque, angle in model_curves(points, c.model_arcsec, c.has_effects):
        upper.plot(torque, angle * factor, color=colour(setting), lw=1.2)
    draw_points(upper, points, points.angle_arcsec * factor, 3.5)
    draw_points(lower, points, c.residual_arcsec * factor, 3.5)
    if points.u_arcsec is not None:
        band = 2 * float(np.median(points.u_arcsec)) * factor
        lower.axhspan(-band, band, color="0.85", zorder=0)
    lower.axhline(0, color="0.3", lw=0.8)
    _draw_regions(c, lower, factor)
    _draw_legend(points, upper)
    upper.set_ylabel(f"elastic angle ({angle_unit})")
    lower.set_ylabel(f"reading minus model ({angle_unit})")
    lower.set_xlabel("torque (N m)")
    if c.rmse_arcsec is not None:
        rmse = c.rmse_arcsec * factor
        titled(upper, f"{Path(points.source).name}: RMSE {rmse:.3g} {angle_unit}", 12.0)
    for axes in (upper, lower):
        axes.grid(color="0.92", lw=0.6)
    bare(upper, lower)
    save(figure, path)


def _draw_legend(points: Points, axes: Axes) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=colour(i), label=f"model, {name}")
        for i, name in enumerate(points.setting_names[:7])
    ]
    handles += [
        Line2D([], [], ls="", marker=marker, color="0.3", label=f"reading, {name}")
        for _, marker, name in points.directions
    ]
    if points.u_arcsec is not None:
        handles.append(Line2D([], [], color="0.85", lw=8, label="stated uncertainty (k = 2)"))
    axes.legend(handles=handles, fontsize="small", frameon=False)


def _draw_regions(c: ComparisonPicture, axes: Axes, factor: float) -> None:
    """A box about the readings of every region, numbered, and what it is below the axes."""
    from matplotlib.patches import Rectangle

    if not c.regions:
        return
    torque = c.points.torque_Nm
    span = float(np.ptp(torque)) or 1.0
    residual = c.residual_arcsec * factor
    height = float(np.nanmax(residual) - np.nanmin(residual))
    for number, region in enumerate(c.regions, 1):
        x, y = torque[region.rows], residual[region.rows]
        left, right = x.min() - 0.02 * span, x.max() + 0.02 * span
        low, high = y.min() - 0.03 * height, y.max() + 0.03 * height
        box = Rectangle((left, low), right - left, high - low)
        box.set(facecolor="#E69F00", alpha=0.13, edgecolor="none", zorder=0.5)
        axes.add_patch(box)
        edge = Rectangle((left, low), right - left, high - low)
        edge.set(facecolor="none", edgecolor="#8a5f00", lw=0.8, ls=(0, (4, 2)), zorder=0.6)
        axes.add_patch(edge)
        # Boxes over the whole range carry their numbers side by side.
        at = left + (0.01 + 0.035 * (number - 1)) * span if right - left > 0.9 * span else left
        axes.annotate(
            str(number),
            (at, high),
            xytext=(1, 2),
            textcoords="offset points",
            fontsize="small",
            color="#8a5f00",
            fontweight="bold",
        )
    lines = [f"{i}: {r.label} ({r.share_of_misfit:.0%})" for i, r in enumerate(c.regions, 1)]
    axes.annotate(
        "boxes: where the misfit is larger than elsewhere (share of the misfit)\n"
        + "\n".join(lines),
        (0, 0),
        xytext=(0, -34),
        xycoords="axes fraction",
        textcoords="offset points",
        va="top",
        fontsize="small",
        color="#5c3f00",
    )
