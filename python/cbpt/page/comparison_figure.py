"""A comparison as a picture: readings and model over torque, the residual below them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cbpt.errors import PlotError
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from cbpt.lab.compare import Comparison

# Legible on white for every kind of colour vision (Okabe and Ito 2008).
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
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
    assert readings.preload_N is not None
    figure = Figure(figsize=(8, 7), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    levels = np.unique(readings.preload_N)
    direction = readings.direction()
    zeros = np.array([c.zero_arcsec.get(str(run), 0.0) for run in readings.run])
    counted = readings.elastic_angle_arcsec - zeros
    for index, level in enumerate(levels):
        colour = _COLOURS[index % len(_COLOURS)]
        rows = readings.preload_N == level
        order = np.argsort(readings.torque_Nm[rows], kind="stable")
        torque = readings.torque_Nm[rows][order]
        upper.plot(torque, model.elastic_angle_arcsec[rows][order] * factor, color=colour, lw=1.2)
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
    handles = [
        Line2D([], [], color=_COLOURS[i % len(_COLOURS)], label=f"model, preload {level:g} N")
        for i, level in enumerate(levels[: len(_COLOURS)])
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
