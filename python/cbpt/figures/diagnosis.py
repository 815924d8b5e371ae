"""A diagnosis as a picture: readings and model, what is left of them, how the error falls."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import (
    Points,
    bare,
    colour,
    draw_points,
    model_curves,
    new_figure,
    owned_curves,
    save,
    titled,
)
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

_DASHED = (0, (3, 2))
_BEFORE, _AFTER, _FLOOR = "#9a9a9a", "#0072B2", "#D55E00"
# Settings beyond this many are drawn, but have no line of their own in the legend.
_NAMED = 7
_LEGEND: dict[str, Any] = {"fontsize": "small", "frameon": False}


class Step(Protocol):
    """One step of the ladder of errors."""

    @property
    def added(self) -> str:
        """What came in; empty for the drive as stated."""

    @property
    def rmse_arcsec(self) -> float:
        """In sample."""

    @property
    def held_out_rmse_arcsec(self) -> float:
        """On readings held back."""


@dataclass(frozen=True, eq=False)
class DiagnosisPicture:
    """What is drawn of a diagnosis. Angles in arcsec, arrays of shape (n,)."""

    points: Points
    model_before_arcsec: Floats
    model_after_arcsec: Floats
    residual_before_arcsec: Floats
    residual_after_arcsec: Floats
    ladder: Sequence[Step]
    noise_floor_arcsec: float | None
    sentence: str


@dataclass(frozen=True)
class _Scaled:
    """A step of the ladder in the unit of the picture."""

    added: str
    rmse_arcsec: float
    held_out_rmse_arcsec: float


def _in_unit(d: DiagnosisPicture, one: float) -> DiagnosisPicture:
    """All angles times the value of one arcsec in the unit of the picture."""
    p, floor = d.points, d.noise_floor_arcsec
    u = None if p.u_arcsec is None else p.u_arcsec * one
    steps = [_Scaled(s.added, s.rmse_arcsec * one, s.held_out_rmse_arcsec * one) for s in d.ladder]
    return DiagnosisPicture(
        points=replace(p, angle_arcsec=p.angle_arcsec * one, u_arcsec=u),
        model_before_arcsec=d.model_before_arcsec * one,
        model_after_arcsec=d.model_after_arcsec * one,
        residual_before_arcsec=d.residual_before_arcsec * one,
        residual_after_arcsec=d.residual_after_arcsec * one,
        ladder=steps,
        noise_floor_arcsec=None if floor is None else floor * one,
        sentence=d.sentence,
    )


def draw_diagnosis(
    d: DiagnosisPicture, path: str | os.PathLike[str], angle_unit: str = "arcsec"
) -> None:
    """Draw to `path` (SVG, PNG or PDF by its ending), angles in `angle_unit`. Raises `PlotError`
    without matplotlib."""
    figure = new_figure(path, 8, 9.6)
    d = _in_unit(d, ANGLE_UNITS[angle_unit])
    angle, before, after, ladder = _panels(figure)
    _draw_angle(angle, d)
    _draw_residual(before, d, d.residual_before_arcsec, "as stated", angle_unit)
    _draw_residual(after, d, d.residual_after_arcsec, "as fitted", angle_unit)
    _draw_ladder(ladder, d, angle_unit)
    angle.set_ylabel(f"elastic angle ({angle_unit})")
    _draw_legend(angle, d.points)
    bare(angle, before, after, ladder)
    figure.suptitle("\n".join(wrap(d.sentence, 94)), x=0.01, ha="left", fontsize=10.5)
    save(figure, path)


def _panels(figure: Figure) -> tuple[Axes, Axes, Axes, Axes]:
    """Angle above, the two residuals side by side, the ladder below."""
    grid = figure.add_gridspec(3, 2, height_ratios=[5, 3.2, 3.4])
    angle = figure.add_subplot(grid[0, :])
    before = figure.add_subplot(grid[1, 0])
    after = figure.add_subplot(grid[1, 1])
    return angle, before, after, figure.add_subplot(grid[2, :])


def _draw_angle(axes: Axes, d: DiagnosisPicture) -> None:
    p = d.points
    for setting, torque, angle in model_curves(p, d.model_before_arcsec, False):
        axes.plot(torque, angle, color=colour(setting), ls=_DASHED, lw=1.0, alpha=0.8)
    after = d.model_after_arcsec
    for setting, torque, angle in model_curves(p, after, _remembers(p, after)):
        axes.plot(torque, angle, color=colour(setting), lw=1.4)
    draw_points(axes, p, p.angle_arcsec, _size(p))
    axes.set_xlabel("torque (N m)")
    axes.grid(color="0.92", lw=0.6)


def _size(points: Points) -> float:
    return 3.5 if len(points) <= 800 else 2.0


def _remembers(points: Points, model: Floats) -> bool:
    """Whether a model differs between the way up and the way down by more than a line is wide."""
    lines: dict[int, list[tuple[Floats, Floats]]] = {}
    for owner, _, torque, angle in owned_curves(points, model, True):
        lines.setdefault(owner, []).append((torque, angle))
    widest = 0.0
    for drawn in lines.values():
        for (torque, angle), (after_Nm, after) in pairwise(drawn):
            both = (torque >= after_Nm.min()) & (torque <= after_Nm.max())
            apart = np.abs(angle[both] - np.interp(torque[both], after_Nm, after))
            widest = max(widest, float(apart.max(initial=0.0)))
    return widest > 0.005 * float(np.ptp(model[np.isfinite(model)]))


def _draw_residual(
    axes: Axes, d: DiagnosisPicture, residual: Floats, name: str, angle_unit: str
) -> None:
    u = d.points.u_arcsec
    band = d.noise_floor_arcsec if u is None else float(np.median(u))
    if band is not None:
        axes.axhspan(-band, band, color="0.87", zorder=0)
    axes.axhline(0, color="0.3", lw=0.8, zorder=0)
    draw_points(axes, d.points, residual, _size(d.points))
    rmse = float(np.sqrt(np.nanmean(residual**2)))
    titled(axes, f"{name}: RMSE {rmse:.3g} {angle_unit}")
    axes.set_xlabel("torque (N m)")
    if name == "as stated":
        what = "scatter" if u is None else "u, k = 1"
        says = "" if band is None else f"\nband: ± {band:.2g} ({what})"
        axes.set_ylabel(f"reading minus model ({angle_unit}){says}")
    else:
        axes.set_ylabel("the same, on its own scale")
    # On the scale of the first the second would be a line.
    axes.grid(color="0.94", lw=0.6)


def _draw_ladder(axes: Axes, d: DiagnosisPicture, angle_unit: str) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    steps = list(d.ladder)
    place = np.arange(len(steps))
    inside = np.array([s.rmse_arcsec for s in steps])
    outside = np.array([s.held_out_rmse_arcsec for s in steps])
    for shift, values, shade, name in (
        (-0.19, inside, _BEFORE, "in sample"),
        (0.19, outside, _AFTER, "held out"),
    ):
        axes.bar(place + shift, values, 0.36, color=shade, label=name)
        for x, y in zip(place + shift, values, strict=True):
            if np.isfinite(y):
                axes.annotate(
                    f"{y:.3g}",
                    (x, y),
                    xytext=(0, 2),
                    textcoords="offset points",
                    ha="center",
                    fontsize=8,
                )
    floor = d.noise_floor_arcsec
    finite = np.r_[inside, outside]
    if floor is not None:
        label = f"noise, {floor:.3g} {angle_unit}"
        axes.axhline(floor, color=_FLOOR, lw=1.3, ls=(0, (5, 2)), label=label)
        finite = np.r_[finite, floor]
    finite = finite[np.isfinite(finite) & (finite > 0)]
    if finite.size and finite.max() > 12 * finite.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set_ylim(0.5 * finite.min(), 2.2 * finite.max())
    elif finite.size:
        axes.set_ylim(0, 1.18 * finite.max())
    axes.set_xlim(-0.6, max(len(steps) - 0.4, 2.4))
    axes.set_xticks(place, [_step_name(s.added, i, len(steps)) for i, s in enumerate(steps)])
    axes.tick_params(axis="x", length=0, labelsize=9)
    axes.set_ylabel(f"RMSE ({angle_unit})")
    # Above the bars, which may be as high on the right as on the left.
    axes.legend(
        fontsize="small", frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3
    )


def _step_name(added: str, place: int, steps: int) -> str:
    """`+ effect`, in lines that fit under its bars."""
    if not added or place == 0:
        return added or "as stated"
    width = max(8, 96 // max(steps, 1) - 2)
    text = added.replace("_", " ")
    name = text if " " in added else f"+ {text}"
    return "\n".join(wrap(name, width, break_long_words=False))


def _draw_legend(axes: Axes, points: Points) -> None:
    from matplotlib.lines import Line2D

    names = points.setting_names
    more = len(names) - _NAMED
    handles = [
        Line2D([], [], color=colour(i), lw=3, label=name) for i, name in enumerate(names[:_NAMED])
    ]
    if more > 0:
        handles.append(Line2D([], [], ls="", label=f"and {more} more setting{'s' * (more > 1)}"))
    styles = [
        Line2D([], [], color="0.3", lw=1.0, ls=_DASHED, label="model as stated"),
        Line2D([], [], color="0.3", lw=1.4, label="model as fitted"),
    ]
    styles += [
        Line2D([], [], ls="", marker=marker, color="0.3", label=f"reading, {name}")
        for _, marker, name in points.directions
    ]
    # A curve of the angle over the torque leaves these two corners.
    axes.add_artist(axes.legend(handles=handles, loc="upper left", **_LEGEND))
    axes.legend(handles=styles, loc="lower right", **_LEGEND)
