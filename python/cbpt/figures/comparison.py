"""A comparison as a picture: readings and model over torque, the residual below them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cbpt.errors import PlotError
from cbpt.lab.readings.set_points import Levels, levels_of, settings
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from cbpt.lab.diagnosis.compare import Comparison
    from cbpt.lab.readings.reader import Readings

# Legible on white for every kind of colour vision (Okabe and Ito 2008).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_FORMATS = (".svg", ".png", ".pdf")
_MARKERS = {1: ("^", "torque rising"), -1: ("v", "torque falling"), 0: ("o", "torque held")}


def check_picture_name(path: str | os.PathLike[str]) -> None:
    """Refuse a file name whose ending is not known, before any work is done."""
    if Path(path).suffix.lower() not in _FORMATS:
        raise PlotError(f"{os.fspath(path)}: the name must end in {', '.join(_FORMATS)}")


def draw_comparison(c: Comparison, path: str | os.PathLike[str], angle_unit: str) -> None:
    """Draw `c` to `path` (SVG, PNG or PDF by its ending), angles in `angle_unit`."""
    check_picture_name(path)
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
        from matplotlib.lines import Line2D
    except ImportError as error:
        raise PlotError('drawing needs matplotlib: pip install "cbpt[plot]"') from error

    factor = ANGLE_UNITS[angle_unit]
    readings, model = c.readings, c.model
    figure = Figure(figsize=(8, 7), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    levels, names = settings(readings)
    direction = readings.direction()
    zeros = np.array([c.zero_arcsec.get(str(run), 0.0) for run in readings.run])
    counted = readings.elastic_angle_arcsec - zeros
    curves = model_curves(readings, model.elastic_angle_arcsec, levels, bool(c.numbers))
    for level, torque, angle in curves:
        upper.plot(torque, angle * factor, color=COLOURS[level % len(COLOURS)], lw=1.2)
    for level in range(len(levels)):
        colour = COLOURS[level % len(COLOURS)]
        rows = levels.index == level
        for value, (marker, _) in _MARKERS.items():
            some = rows & (direction == value)
            style = {"ls": "", "marker": marker, "ms": 3.5, "color": colour, "alpha": 0.7}
            upper.plot(readings.torque_Nm[some], counted[some] * factor, **style)
            lower.plot(readings.torque_Nm[some], c.residual_arcsec[some] * factor, **style)
    u = readings.u_elastic_angle_arcsec
    if u is not None:
        band = 2 * float(np.median(u)) * factor
        lower.axhspan(-band, band, color="0.85", zorder=0)
    lower.axhline(0, color="0.3", lw=0.8)
    _draw_regions(c, lower, factor)
    handles = [
        Line2D([], [], color=COLOURS[i % len(COLOURS)], label=f"model, {name}")
        for i, name in enumerate(names[: len(COLOURS)])
    ]
    handles += [
        Line2D([], [], ls="", marker=marker, color="0.3", label=f"reading, {label}")
        for value, (marker, label) in _MARKERS.items()
        if np.any(direction == value)
    ]
    if u is not None:
        handles.append(Line2D([], [], color="0.85", lw=8, label="stated uncertainty (k = 2)"))
    upper.legend(handles=handles, fontsize="small", frameon=False)
    upper.set_ylabel(f"elastic angle ({angle_unit})")
    lower.set_ylabel(f"reading minus model ({angle_unit})")
    lower.set_xlabel("torque (N m)")
    if c.where:
        told = [f"{i}: {r.label} ({r.share_of_misfit:.0%})" for i, r in enumerate(c.where, 1)]
        title = "boxes: where the misfit stands out (share of it)\n" + "\n".join(told)
        lower.annotate(
            title,
            (0, 0),
            xytext=(0, -34),
            xycoords="axes fraction",
            textcoords="offset points",
            va="top",
            fontsize="small",
            color="#5c3f00",
        )
    if c.overall is not None:
        rmse = c.overall.rmse_arcsec * factor
        upper.set_title(f"{Path(readings.source).name}: RMSE {rmse:.3g} {angle_unit}", loc="left")
    for axes in (upper, lower):
        axes.grid(color="0.92", lw=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    # The same picture is the same file, byte by byte.
    with mpl.rc_context({"svg.hashsalt": "cbpt"}):
        metadata = {"Date": None} if Path(path).suffix.lower() == ".svg" else None
        figure.savefig(path, dpi=150, metadata=metadata)


def model_curves(
    readings: Readings, model_arcsec: NDArray[np.float64], levels: Levels, memory: bool
) -> Iterator[tuple[int, NDArray[np.float64], NDArray[np.float64]]]:
    """Preload level, torque and angle of each line: the mean model at each torque level.

    One line for each preload; with memory one up and one down. The model may differ between input
    angles too, and a line through all of its points would be a saw.
    """
    torque = levels_of(readings.torque_Nm)
    if 2 * len(torque) > len(readings):
        # Hardly a torque twice, as where it was measured and not set: the line follows the runs.
        for run in np.unique(readings.run_index):
            rows = (readings.run_index == run) & np.isfinite(model_arcsec)
            if rows.any():
                yield int(levels.index[rows][0]), readings.torque_Nm[rows], model_arcsec[rows]
        return
    way = readings.direction() if memory else np.zeros(len(readings), dtype=np.int64)
    for level in range(len(levels)):
        for each in np.unique(way):
            rows = (levels.index == level) & (way == each) & np.isfinite(model_arcsec)
            count = np.bincount(torque.index[rows], minlength=len(torque))
            sums = np.bincount(torque.index[rows], model_arcsec[rows], len(torque))
            there = count > 0
            yield level, torque.value[there], sums[there] / count[there]


def _draw_regions(c: Comparison, axes: Axes, factor: float) -> None:
    """A box about the readings of every region, numbered, and what it is below the axes."""
    from matplotlib.patches import Rectangle

    torque = c.readings.torque_Nm
    span = float(np.ptp(torque)) or 1.0
    residual = c.residual_arcsec * factor
    height = float(np.nanmax(residual) - np.nanmin(residual)) if c.where else 1.0
    for number, region in enumerate(c.where, 1):
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
