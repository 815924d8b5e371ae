"""The transmission error of a drive as it was made: over the turn, its spectrum, and the balls."""

from __future__ import annotations

import os
from collections.abc import Sequence
from fractions import Fraction
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import COLOURS, bare, new_figure, save
from cbpt.results import ANGLE_UNITS

Floats = NDArray[np.float64]

# More turns in one picture are a block of ink.
_MOST_TURNS = 21


class Line(Protocol):
    """A line of a spectrum."""

    @property
    def order(self) -> Fraction: ...
    @property
    def amplitude_arcsec(self) -> float: ...


class Balls(Protocol):
    """Shares of the balls of a pair."""

    @property
    def least_share(self) -> Floats: ...
    @property
    def mean_share(self) -> Floats: ...
    @property
    def largest_share(self) -> Floats: ...


class Error(Protocol):
    """What the picture needs of a transmission error."""

    @property
    def input_angle_deg(self) -> Floats: ...
    @property
    def unloaded_arcsec(self) -> Floats: ...
    @property
    def loaded_arcsec(self) -> Floats: ...
    @property
    def unloaded_lines(self) -> Sequence[Line]: ...
    @property
    def loaded_lines(self) -> Sequence[Line]: ...
    @property
    def deceleration(self) -> Balls: ...
    @property
    def equal_speed(self) -> Balls: ...


def draw_transmission(
    found: Error, path: str | os.PathLike[str], angle_unit: str = "arcsec"
) -> None:
    """Draw `found` to `path` (SVG, PNG or PDF by its ending)."""
    figure = new_figure(path, 8.5, 6.4)
    one = ANGLE_UNITS[angle_unit]
    grid = figure.add_gridspec(2, 2, height_ratios=[1, 1])
    curve, spectrum = figure.add_subplot(grid[0, :]), figure.add_subplot(grid[1, 0])
    shares = figure.add_subplot(grid[1, 1])
    turns = found.input_angle_deg / 360.0
    rows = turns <= _MOST_TURNS
    kinds = (
        ("unloaded", found.unloaded_arcsec, found.unloaded_lines, COLOURS[0]),
        ("loaded, less its mean", found.loaded_arcsec, found.loaded_lines, COLOURS[1]),
    )
    for place, (label, values, lines, colour) in enumerate(kinds):
        level = float(np.mean(values)) if place else 0.0
        curve.plot(turns[rows], (values[rows] - level) * one, color=colour, lw=0.9, label=label)
        orders = np.array([float(line.order) for line in lines])
        sizes = np.array([line.amplitude_arcsec * one for line in lines])
        spectrum.vlines(orders, 0.0, sizes, color=colour, lw=3.0 - 1.8 * place, label=label)
    curve.set_xlabel("turns of the crank")
    curve.set_ylabel(f"transmission error [{angle_unit}]")
    curve.set_xlim(0.0, float(turns[rows][-1]))
    spectrum.set_xlabel("order [waves per turn of the crank]")
    spectrum.set_ylabel(f"amplitude [{angle_unit}]")
    spectrum.set_ylim(bottom=0.0)
    for balls, label, shift, colour in (
        (found.deceleration, "deceleration", -0.18, COLOURS[0]),
        (found.equal_speed, "equal-speed", 0.18, COLOURS[2]),
    ):
        mean = 100.0 * balls.mean_share
        reach = [mean - 100.0 * balls.least_share, 100.0 * balls.largest_share - mean]
        shares.errorbar(
            np.arange(len(mean)) + shift,
            mean,
            yerr=np.maximum(reach, 0.0),
            fmt=".",
            ms=5,
            lw=0.9,
            color=colour,
            label=f"{label}: mean, least, largest",
        )
    shares.set_xlabel("ball")
    shares.set_ylabel("share of the preload [%]")
    shares.set_ylim(0.0, 1.3 * shares.get_ylim()[1])
    curve.legend(fontsize=8, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    for axes in (spectrum, shares):
        axes.legend(fontsize=8, frameon=False)
    bare(curve, spectrum, shares)
    save(figure, path)
