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
        _panel(axes, picture, ANGLE_UNITS[angle_unit], angle_unit)
        axes.set(xlabel="torque (N m)", ylabel=f"elastic angle ({angle_unit})")
    for axes in panels[len(pictures) :]:
        axes.set_visible(False)
    bare(*panels)
    save(figure, path)


def _panel(axes: Axes, picture: LoopPicture, factor: float, unit: str) -> None:
    for kind, loops, style in (("readings", picture.loops, "-"), ("model", picture.model, "--")):
        for number, loop in enumerate(loops):
            for torque, angle in loop:
                line = axes.plot(torque, angle * factor, style, lw=1.0, alpha=0.6)[0]
                line.set_color(colour(0 if kind == "readings" else 1))
                if number == 0 and torque is loop[0][0]:
                    line.set_label(kind)
    for share in (0.5, 1.0):
        for sign in (-1, 1):
            axes.axvline(sign * share * picture.rated_torque_Nm, color="0.85", lw=0.7, zorder=0)
    _at_zero(axes, picture, factor, unit)
    _pieces(axes, picture, factor)
    _rigidity(axes, picture, factor)
    titled(axes, picture.title, 8.5)
    axes.legend(fontsize="x-small", frameon=False, loc="upper left")


def _at_zero(axes: Axes, picture: LoopPicture, factor: float, unit: str) -> None:
    """Hysteresis loss, lost motion and backlash, each between the angles that it lies between."""
    values = picture.values
    loss, motion = values.get("hysteresis_loss"), values.get("lost_motion")
    if loss is not None:
        half = 0.5 * loss * factor
        label = f"hysteresis loss {_short(loss * factor)} {unit}"
        axes.plot([0, 0], [-half, half], color=colour(2), lw=4, alpha=0.7, label=label)
    if motion is not None:
        half, at = 0.5 * motion * factor, picture.window_Nm
        label = f"lost motion {_short(motion * factor)} {unit}"
        axes.plot([-at, at], [-half, half], "o-", color=colour(3), ms=4, label=label)
    play = values.get("backlash")
    if play is not None:
        half = 0.5 * play * factor
        label = f"backlash {_short(play * factor)} {unit}"
        axes.plot([0, 0], [-half, half], "_-", color="black", ms=14, mew=1.4, lw=1.4, label=label)


def _pieces(axes: Axes, picture: LoopPicture, factor: float) -> None:
    """K1 to K3 as the three straight pieces from zero torque, each with its name."""
    values, rated = picture.values, picture.rated_torque_Nm
    stiffness = [values.get(name) for name in ("K1", "K2", "K3")]
    if all(k is None for k in stiffness):
        return
    breaks = [values.get("T1"), values.get("T2")]
    side, end = _side(picture)
    torques = [0.0, *(t for t in breaks if t is not None), min(end, rated)]
    bent = len(torques) == 4
    if not bent:
        stiffness = stiffness[:1]
    # A piece without a figure has no rise.
    rises = [0.0 if k is None else 60.0 / k for k in stiffness]
    angles = np.r_[0.0, np.cumsum(np.array(rises) * np.diff(torques))] * factor
    places = side * np.array(torques)
    angles = side * angles
    label = "K1, K2, K3" if bent else "K1 = K2 = K3 (straight)"
    axes.plot(places, angles, color=colour(4), lw=2.0, ls=(0, (5, 1.5)), zorder=3, label=label)
    span = abs(places[-1]) or 1.0
    if not bent:
        return
    for i, k in enumerate(stiffness):
        if k is not None and abs(places[i + 1] - places[i]) > 0.08 * span:
            middle = 0.5 * (places[i] + places[i + 1]), 0.5 * (angles[i] + angles[i + 1])
            _named(axes, f"K{i + 1}", middle, (-20 * side, 8 * side), colour(4))
    # Names of breaks that lie together would cover each other.
    together = abs(places[2] - places[1]) < 0.08 * span
    for name, place in zip(("T1, T2", "") if together else ("T1", "T2"), places[1:3], strict=True):
        axes.axvline(place, color=colour(4), lw=0.8, ls=":")
        axes.annotate(
            name,
            (place, 0.01),
            xytext=(2, 0),
            textcoords="offset points",
            xycoords=("data", "axes fraction"),
            fontsize="small",
            color=colour(4),
        )


def _rigidity(axes: Axes, picture: LoopPicture, factor: float) -> None:
    """The slope b/a from 50 % to 100 % of rated torque, through the middle of the loop there."""
    rigidity = picture.values.get("torsional_rigidity")
    loops = picture.loops or picture.model
    if not rigidity or not loops:
        return
    side, end = _side(picture)
    torques = side * np.array([0.5, min(end / picture.rated_torque_Nm, 1.0)])
    torques = torques * picture.rated_torque_Nm
    middle = 0.5 * float(torques.sum())
    at = [np.interp(middle, torque, angle) for torque, angle in loops[0]]
    angles = (float(np.mean(at)) + 60.0 / rigidity * (torques - middle)) * factor
    label = f"torsional rigidity {_short(rigidity)} N m/arcmin"
    axes.plot(torques, angles, color=colour(5), lw=7.0, alpha=0.4, zorder=1, label=label)
    for name, across in (("b", True), ("a", False)):  # torque and angle
        corner = (torques[1], angles[0])
        start = (torques[0], angles[0]) if across else (torques[1], angles[1])
        axes.plot(*zip(start, corner, strict=True), color=colour(5), lw=0.8, ls="--")
        place = 0.5 * (start[0] + corner[0]), 0.5 * (start[1] + corner[1])
        _named(axes, name, place, (0, -11 * side) if across else (5 * side, 0), colour(5))


def _side(picture: LoopPicture) -> tuple[float, float]:
    """The side of zero torque on which names stand, and how far the loops go there."""
    loops = picture.loops or picture.model
    low = min(float(torque.min()) for loop in loops for torque, _ in loop)
    high = max(float(torque.max()) for loop in loops for torque, _ in loop)
    return (1.0, high) if high >= -0.5 * low else (-1.0, -low)


def _named(
    axes: Axes, name: str, place: tuple[float, float], offset: tuple[float, float], shade: str
) -> None:
    axes.annotate(
        name,
        place,
        xytext=offset,
        textcoords="offset points",
        fontsize="small",
        color=shade,
    )


def _short(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
