"""The pictures of a data sheet, as SVG text for the page.

    stiffness_svg   elastic angle over torque, for some preloads
    window_svg      thresholds of the preload over the torque, and the window at the rated one
    map_svg         a quantity over torque and preload
    pressure_svg    peak pressures over the torque, with the limit
    drawing_svg     a pair seen along the axis

They draw what they are handed; every one has the same size, so that a page can set them in columns.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import PlotError
from cbpt.figures.shared import COLOURS, bare

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

_SIZE = (3.55, 2.2)
_LINE = 1.1
_SMALL = 7
_OUTPUT, _OTHER, _FAINT = "#0072B2", "#8a8f98", "#d7dae0"


def stiffness_svg(torque_Nm: Floats, curves: Sequence[tuple[str, Floats]], rated_Nm: float) -> str:
    """Curves of the elastic angle (arcsec) by their labels; the rated torque is marked."""
    figure, axes = _axes()
    for place, (label, angles) in enumerate(curves):
        axes.plot(torque_Nm, angles, color=COLOURS[place], lw=_LINE, label=label)
    axes.axvline(rated_Nm, color="0.55", lw=0.7, ls="--")
    axes.axhline(0.0, color="0.85", lw=0.6, zorder=0)
    axes.set(xlabel="torque at the output / N m", ylabel="elastic angle / arcsec")
    axes.legend(fontsize=_SMALL, frameon=False, loc="upper left")
    return _svg(figure)


def window_svg(
    torque_Nm: Floats,
    thresholds: Sequence[tuple[str, Floats]],
    window: tuple[float, float] | None,
    at: tuple[float, float],
) -> str:
    """Thresholds (N) over the torque, the window at the rated torque as a bar, and the preload that
    is set (`at`: N m, N) as a point."""
    figure, axes = _axes()
    for place, (label, preload) in enumerate(thresholds):
        axes.plot(torque_Nm, preload, color=COLOURS[place], lw=_LINE, label=label)
    if window:
        axes.vlines(at[0], *window, color=COLOURS[4], lw=5, alpha=0.45, label="window")
    axes.plot(*at, "o", ms=4, color="k", label="as set")
    axes.set(xlabel="torque at the output / N m", ylabel="preload / N")
    top = max(float(np.nanmax(thresholds[-1][1])), at[1])
    axes.set_ylim(0.0, 1.25 * top)
    axes.legend(fontsize=_SMALL, frameon=False, loc="upper left")
    return _svg(figure)


def map_svg(
    torque_Nm: Floats, preload_N: Floats, values: Floats, label: str, at: tuple[float, float]
) -> str:
    """Lines of equal `values`, shape (preloads, torques); empty where there is no solution."""
    figure, axes = _axes()
    from matplotlib.ticker import MaxNLocator

    shown = np.ma.masked_invalid(values)
    levels = np.linspace(float(shown.min()), float(shown.max()), 25)
    filled = axes.contourf(torque_Nm, preload_N, shown, levels=levels, cmap="viridis")
    lines = axes.contour(torque_Nm, preload_N, shown, levels=7, colors="w", linewidths=0.5)
    axes.clabel(lines, fontsize=6, fmt="%.3g")
    axes.plot(*at, "o", ms=4, mfc="w", mec="k")
    axes.set(xlabel="torque at the output / N m", ylabel="preload / N")
    bar = figure.colorbar(filled, ax=axes, pad=0.02, ticks=MaxNLocator(5))
    bar.set_label(label, fontsize=_SMALL)
    bar.ax.tick_params(labelsize=6)
    # White seams between the fields, as some viewers show them.
    filled.set_edgecolor("face")
    return _svg(figure)


def pressure_svg(
    torque_Nm: Floats,
    pressures_GPa: Sequence[tuple[str, Floats]],
    limit_GPa: float,
    rated_Nm: float,
) -> str:
    """Peak pressures of the pairs over the torque."""
    figure, axes = _axes()
    for place, (label, pressure) in enumerate(pressures_GPa):
        axes.plot(torque_Nm, pressure, color=COLOURS[place], lw=_LINE, label=label)
    axes.axhline(limit_GPa, color="0.3", lw=0.9, ls=":", label="limit")
    axes.axvline(rated_Nm, color="0.55", lw=0.7, ls="--")
    axes.set(xlabel="torque at the output / N m", ylabel="peak pressure / GPa")
    axes.set_ylim(bottom=0.0)
    axes.legend(fontsize=_SMALL, frameon=False, loc="lower left")
    return _svg(figure)


def drawing_svg(pair: Mapping[str, Any]) -> str:
    """A pair of the page's drawing: tracks, rings, balls; lengths in mm."""
    figure, axes = _axes((2.5, 2.35))
    output = pair["plates"]["output"]
    for line in pair["lines"]:
        track = line["kind"] == "track"
        colour = _OUTPUT if line["plate"] == output else _OTHER
        axes.plot(
            line["x"],
            line["y"],
            color=colour if track else _FAINT,
            lw=0.8 if track else 0.5,
            zorder=2 if track else 1,
        )
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    for circle in pair["circles"]:
        if circle["kind"] == "wall":
            continue
        pitch = circle["kind"] == "pitch"
        colour = _FAINT if pitch else _OUTPUT if circle["plate"] == output else _OTHER
        axes.plot(
            circle["x"] + circle["radius"] * np.cos(turn),
            circle["y"] + circle["radius"] * np.sin(turn),
            color=colour,
            lw=0.6,
            ls="--" if pitch else "-",
            zorder=1,
        )
    for ball in pair["balls"]:
        axes.fill(
            ball["x"] + ball["radius"] * np.cos(turn),
            ball["y"] + ball["radius"] * np.sin(turn),
            facecolor="0.82",
            edgecolor="0.25",
            lw=0.6,
            zorder=3,
        )
    reach = pair["extent_mm"]
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()
    return _svg(figure)


def _axes(size: tuple[float, float] = _SIZE) -> tuple[Figure, Axes]:
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise PlotError('a data sheet needs matplotlib: pip install "cbpt[plot]"') from error
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.add_subplot()
    axes.tick_params(labelsize=_SMALL, width=0.6, length=2.5)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_fontsize(_SMALL + 0.5)
    bare(axes)
    return figure, axes


def _svg(figure: Figure) -> str:
    """The picture as an element for the page: text stays text, names are its own."""
    import matplotlib as mpl

    made = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "cbpt", "svg.fonttype": "none"}):
        figure.savefig(made, format="svg", metadata={"Date": None}, transparent=True)
    text = made.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    return re.sub(r"font: ([\d.]+px) [^\";]*", r"font: \1 sans-serif", text)
