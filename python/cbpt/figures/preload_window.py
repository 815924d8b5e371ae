"""What a preload brings and what it costs: elastic angle, friction and safety over the preload."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import bare, colour, new_figure, save, titled
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

# Below this a value is no result, in any unit of angles.
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class WindowPicture:
    """Curves over the preload (N), each of shape (n,)."""

    title: str
    own_N: float
    """The preload of the load."""
    preload_N: Floats
    angle_arcsec: Floats
    friction_torque_Nm: Floats
    static_safety: Floats
    required_static_safety: float
    window: Mapping[str, float | None]
    """`hold_N`, `continuous_N`, `least_N` and `largest_N`."""


def draw_window(
    picture: WindowPicture, path: str | os.PathLike[str], angle_unit: str = "arcsec"
) -> None:
    """Draw three panels to `path` (SVG, PNG or PDF by its ending)."""
    figure = new_figure(path, 6.4, 6.6)
    panels = figure.subplots(3, 1, sharex=True)
    curves = (
        (picture.angle_arcsec * ANGLE_UNITS[angle_unit], f"elastic angle ({angle_unit})"),
        (picture.friction_torque_Nm, "friction torque (N m)"),
        (picture.static_safety, "static safety"),
    )
    least, largest = picture.window["least_N"], picture.window["largest_N"]
    for place, (axes, (values, label)) in enumerate(zip(panels, curves, strict=True)):
        axes.plot(picture.preload_N, values, color=colour(place))
        axes.set_ylabel(label)
        # Close to the holding limit the angle is a hundred times that of the window; without torque
        # it is nothing but rounding.
        if np.any(values > _ROUNDING):
            axes.set_yscale("log")
        else:
            axes.set_ylim(0, 1)
        if least is not None and largest is not None:
            axes.axvspan(least, largest, color="0.9", zorder=0, label="window")
        for name, style in (("hold_N", ":"), ("continuous_N", "--")):
            at = picture.window[name]
            if at is not None and at > 0:
                axes.axvline(at, color="0.4", lw=0.9, ls=style, label=name.removesuffix("_N"))
        axes.axvline(picture.own_N, color="0.4", lw=0.9, label="this preload")
    panels[2].axhline(
        picture.required_static_safety, color="0.4", lw=0.9, ls="-.", label="required"
    )
    panels[2].set(xlabel="preload (N)", xscale="log")
    round_ticks(panels[2])
    panels[2].set_xlim(0.95 * min(picture.own_N, picture.preload_N[0]), picture.preload_N[-1])
    panels[2].legend(fontsize="small", framealpha=1, edgecolor="none")
    titled(panels[0], picture.title, 8.5)
    bare(*panels)
    save(figure, path)


def round_ticks(axes: Axes) -> None:
    """Preloads of 1, 2 and 5 times a power of ten, and no others, whose names would run into each
    other."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
