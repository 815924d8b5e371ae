"""A diagnosis as a picture: readings and model, what is left of them, how the error falls."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import PlotError
from cbpt.figures.comparison import COLOURS, check_picture_name, model_curves
from cbpt.lab.readings.set_points import Levels, settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]

_MARKERS = {1: "^", -1: "v", 0: "o"}
_WAYS = {1: "torque rising", -1: "torque falling", 0: "torque held"}
_DASHED = (0, (3, 2))
_BEFORE, _AFTER, _FLOOR = "#9a9a9a", "#0072B2", "#D55E00"
# Levels beyond this many are drawn, but have no line of their own in the legend.
_NAMED = 7


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


class Diagnosed(Protocol):
    """What the picture needs of a diagnosis. Arrays have shape (n,)."""

    @property
    def readings(self) -> Readings: ...
    @property
    def model_before_arcsec(self) -> Floats: ...
    @property
    def model_after_arcsec(self) -> Floats: ...
    @property
    def residual_before_arcsec(self) -> Floats: ...
    @property
    def residual_after_arcsec(self) -> Floats: ...
    @property
    def ladder(self) -> Sequence[Step]: ...
    @property
    def noise_floor_arcsec(self) -> float | None: ...
    @property
    def sentence(self) -> str: ...


def draw_diagnosis(diagnosis: Diagnosed, path: str | os.PathLike[str]) -> None:
    """Draw to `path` (SVG, PNG or PDF by its ending). Raises `PlotError` without matplotlib."""
    check_picture_name(path)
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError as error:
        raise PlotError('drawing needs matplotlib: pip install "cbpt[plot]"') from error

    figure = Figure(figsize=(8, 9.6), layout="constrained")
    angle, before, after, ladder = _panels(figure)
    levels, names = settings(diagnosis.readings)
    _draw_angle(angle, diagnosis, levels)
    _draw_residual(before, diagnosis, diagnosis.residual_before_arcsec, levels, "as stated")
    _draw_residual(after, diagnosis, diagnosis.residual_after_arcsec, levels, "as diagnosed")
    _draw_ladder(ladder, diagnosis)
    _draw_legend(angle, diagnosis, names)
    for axes in (angle, before, after, ladder):
        axes.spines[["top", "right"]].set_visible(False)
    figure.suptitle("\n".join(wrap(diagnosis.sentence, 104)), x=0.01, ha="left", fontsize=10.5)
    # The same picture is the same file, byte by byte.
    with mpl.rc_context({"svg.hashsalt": "cbpt"}):
        metadata = {"Date": None} if Path(path).suffix.lower() == ".svg" else None
        figure.savefig(path, dpi=150, metadata=metadata)


def _panels(figure: Figure) -> tuple[Axes, Axes, Axes, Axes]:
    """Angle above, the two residuals side by side, the ladder below."""
    grid = figure.add_gridspec(3, 2, height_ratios=[5, 3.2, 3.4])
    angle = figure.add_subplot(grid[0, :])
    before = figure.add_subplot(grid[1, 0])
    after = figure.add_subplot(grid[1, 1])
    return angle, before, after, figure.add_subplot(grid[2, :])


def _draw_angle(axes: Axes, d: Diagnosed, levels: Levels) -> None:
    r = d.readings
    for level, torque, angle in model_curves(r, d.model_before_arcsec, levels, False):
        axes.plot(torque, angle, color=_colour(level), ls=_DASHED, lw=1.0, alpha=0.8)
    after = d.model_after_arcsec
    for level, torque, angle in model_curves(r, after, levels, _remembers(r, after, levels)):
        axes.plot(torque, angle, color=_colour(level), lw=1.4)
    _draw_readings(axes, r, r.elastic_angle_arcsec, levels)
    axes.set_xlabel("torque (N m)")
    axes.set_ylabel("elastic angle (arcsec)")
    axes.grid(color="0.92", lw=0.6)


def _remembers(r: Readings, model: Floats, levels: Levels) -> bool:
    """Whether a model differs between the way up and the way down by more than a line is wide."""
    curves: dict[tuple[int, float], list[float]] = {}
    for level, torque, angle in model_curves(r, model, levels, True):
        for x, y in zip(torque.tolist(), angle.tolist(), strict=True):
            curves.setdefault((level, x), []).append(y)
    widest = max((max(v) - min(v) for v in curves.values()), default=0.0)
    return widest > 0.005 * float(np.ptp(model[np.isfinite(model)]))


def _draw_readings(axes: Axes, r: Readings, values: Floats, levels: Levels) -> None:
    direction = r.direction()
    size = 3.5 if len(r) <= 800 else 2.0
    for level in range(len(levels)):
        for way, marker in _MARKERS.items():
            rows = (levels.index == level) & (direction == way)
            style: dict[str, Any] = {
                "ls": "",
                "marker": marker,
                "ms": size,
                "alpha": 0.65,
                "mew": 0,
            }
            axes.plot(r.torque_Nm[rows], values[rows], color=_colour(level), **style)


def _draw_residual(axes: Axes, d: Diagnosed, residual: Floats, levels: Levels, name: str) -> None:
    u = d.readings.u_elastic_angle_arcsec
    band = d.noise_floor_arcsec if u is None else float(np.median(u))
    if band is not None:
        axes.axhspan(-band, band, color="0.87", zorder=0)
    axes.axhline(0, color="0.3", lw=0.8, zorder=0)
    _draw_readings(axes, d.readings, residual, levels)
    rmse = float(np.sqrt(np.nanmean(residual**2)))
    own = "" if name == "as stated" else " (own scale)"
    axes.set_title(f"{name}: RMSE {rmse:.3g} arcsec{own}", loc="left", fontsize=10)
    axes.set_xlabel("torque (N m)")
    if name == "as stated":
        what = "scatter" if u is None else "u, k = 1"
        says = "" if band is None else f"\nband: ± {band:.2g} ({what})"
        axes.set_ylabel(f"reading minus model (arcsec){says}")
    # On the scale of the first the second would be a line.
    axes.grid(color="0.94", lw=0.6)


def _draw_ladder(axes: Axes, d: Diagnosed) -> None:
    steps = list(d.ladder)
    place = np.arange(len(steps))
    inside = np.array([s.rmse_arcsec for s in steps])
    outside = np.array([s.held_out_rmse_arcsec for s in steps])
    for shift, values, colour, name in (
        (-0.19, inside, _BEFORE, "in sample"),
        (0.19, outside, _AFTER, "held out"),
    ):
        axes.bar(place + shift, values, 0.36, color=colour, label=name)
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
        label = f"noise, {floor:.2g} arcsec"
        axes.axhline(floor, color=_FLOOR, lw=1.3, ls=(0, (5, 2)), label=label)
        finite = np.r_[finite, floor]
    finite = finite[np.isfinite(finite) & (finite > 0)]
    if finite.size and finite.max() > 12 * finite.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set_ylim(0.5 * finite.min(), 2.2 * finite.max())
    elif finite.size:
        axes.set_ylim(0, 1.18 * finite.max())
    axes.set_xlim(-0.6, max(len(steps) - 0.4, 2.4))
    axes.set_xticks(place, [_step_name(s.added, i, len(steps)) for i, s in enumerate(steps)])
    axes.tick_params(axis="x", length=0, labelsize=9)
    axes.set_ylabel("RMSE (arcsec)")
    axes.legend(fontsize="small", frameon=False, loc="upper right")


def _step_name(added: str, place: int, steps: int) -> str:
    """`+ effect`, in lines that fit under its bars."""
    if not added or place == 0:
        return added or "as stated"
    width = max(8, 96 // max(steps, 1) - 2)
    text = added.replace("_", " ")
    return "\n".join(wrap(text if " " in added else f"+ {text}", width))


def _draw_legend(axes: Axes, d: Diagnosed, names: list[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=_colour(i), lw=3, label=name) for i, name in enumerate(names[:_NAMED])
    ]
    if len(names) > _NAMED:
        what = names[0].rpartition(" ")[0] if " N" not in names[0] else "preload"
        handles.append(Line2D([], [], ls="", label=f"and {len(names) - _NAMED} more {what}s"))
    handles += [
        Line2D([], [], color="0.3", lw=1.0, ls=_DASHED, label="model as stated"),
        Line2D([], [], color="0.3", lw=1.4, label="model as diagnosed"),
    ]
    direction = d.readings.direction()
    handles += [
        Line2D([], [], ls="", marker=marker, color="0.3", label=f"reading, {_WAYS[way]}")
        for way, marker in _MARKERS.items()
        if np.any(direction == way)
    ]
    axes.legend(handles=handles, fontsize="small", frameon=False, loc="best")


def _colour(level: int) -> str:
    return COLOURS[level % len(COLOURS)]
