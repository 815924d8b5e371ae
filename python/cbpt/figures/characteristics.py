"""Loops with the figures that are read off them, drawn where they are read off."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import bare, colour, new_figure, save, titled
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]
Branches = Sequence[tuple[Floats, Floats]]


@dataclass(frozen=True)
class LoopPicture:
    """The loops of one setting; angles in arcsec, torques in N m."""

    title: str
    loops: Sequence[Branches]
    model: Sequence[Branches]
    values: Mapping[str, float | None]
    rated_torque_Nm: float
    window_Nm: float


def draw_loops(
    pictures: Sequence[LoopPicture], path: str | os.PathLike[str], angle_unit: str
) -> None:
    """Draw one panel for each setting to `path` (SVG, PNG or PDF by its ending)."""
    columns = min(len(pictures), 3)
    rows = -(-len(pictures) // columns)
    figure = new_figure(path, 5.2 * columns, 4.4 * rows)
    panels = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
    for axes, picture in zip(panels, pictures, strict=False):
        _panel(axes, picture, ANGLE_UNITS[angle_unit])
        axes.set(xlabel="torque (N m)", ylabel=f"elastic angle ({angle_unit})")
    for axes in panels[len(pictures) :]:
        axes.set_visible(False)
    bare(*panels)
    save(figure, path)


def _panel(axes: Axes, picture: LoopPicture, factor: float) -> None:
    for kind, loops, style in (("readings", picture.loops, "-"), ("model", picture.model, "--")):
        for number, loop in enumerate(loops):
            for torque, angle in loop:
                line = axes.plot(torque, angle * factor, style, lw=1.0, alpha=0.8)[0]
                line.set_color(colour(0 if kind == "readings" else 1))
                if number == 0 and torque is loop[0][0]:
                    line.set_label(kind)
    values, rated = picture.values, picture.rated_torque_Nm
    loss, motion = values.get("hysteresis_loss"), values.get("lost_motion")
    if loss is not None:
        half = 0.5 * loss * factor
        axes.plot([0, 0], [-half, half], color=colour(2), lw=3, label="hysteresis loss")
    if motion is not None:
        half, at = 0.5 * motion * factor, picture.window_Nm
        axes.plot([-at, at], [-half, half], "o-", color=colour(3), ms=4, label="lost motion")
    for share in (0.5, 1.0):
        for sign in (-1, 1):
            axes.axvline(sign * share * rated, color="0.85", lw=0.7, zorder=0)
    for name in ("T1", "T2"):
        place = values.get(name)
        if place is not None:
            axes.axvline(place, color=colour(4), lw=0.8, ls=":")
            axes.annotate(name, (place, 1), xycoords=("data", "axes fraction"), fontsize="small")
    titled(axes, picture.title, 8.5)
    axes.legend(fontsize="small", frameon=False)
