"""The elastic angle of drives within their tolerances: a histogram, and what each number adds."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import bare, new_figure, save
from cbpt.results import ANGLE_UNITS


class Number(Protocol):
    """A number that scatters, with its share of the variance by slopes and as drawn."""

    @property
    def key(self) -> str: ...
    @property
    def share(self) -> float | None: ...
    @property
    def share_drawn(self) -> float | None: ...


class Drawn(Protocol):
    """What the picture needs of a tolerance analysis."""

    @property
    def angles_arcsec(self) -> NDArray[np.float64]: ...
    @property
    def nominal_arcsec(self) -> float | None: ...
    @property
    def quantiles_arcsec(self) -> Mapping[float, tuple[float, float]]: ...
    @property
    def samples(self) -> int: ...
    @property
    def numbers(self) -> Sequence[Number]: ...


def draw_tolerance(t: Drawn, path: str | os.PathLike[str], angle_unit: str = "arcsec") -> None:
    """Draw `t` to `path` (SVG, PNG or PDF by its ending)."""
    figure = new_figure(path, 8.5, 3.6)
    one = ANGLE_UNITS[angle_unit]
    good = t.angles_arcsec[np.isfinite(t.angles_arcsec)] * one
    axes, shares = figure.subplots(1, 2, width_ratios=[3, 2])
    axes.hist(good, bins="auto", color="0.75", density=True)
    low, median, high = (q * one for q, _ in t.quantiles_arcsec.values())
    axes.axvspan(low, high, color="C0", alpha=0.12, label="95 % of the drives")
    axes.axvline(median, color="C0", label="median")
    if t.nominal_arcsec is not None:
        axes.axvline(t.nominal_arcsec * one, color="C3", ls="--", label="nominal")
    axes.set_xlabel(f"elastic angle [{angle_unit}]")
    axes.set_ylabel(f"density [1/{angle_unit}]")
    failed = t.samples - len(good)
    title = f"{t.samples} drives" + (f", {failed} without solution" if failed else "")
    axes.set_title(title, fontsize=9)
    axes.legend(fontsize=8, frameon=False)
    numbers = sorted(t.numbers, key=lambda n: n.share or 0.0)
    places = np.arange(len(numbers))
    for shift, label, colour, values in (
        (0.2, "linear estimate", "C0", [n.share for n in numbers]),
        (-0.2, "random drives", "0.65", [n.share_drawn for n in numbers]),
    ):
        percent = [100 * (value or 0.0) for value in values]
        shares.barh(places + shift, percent, height=0.4, label=label, color=colour)
    shares.set_yticks(places, [n.key for n in numbers], fontsize=7)
    shares.set_xlabel("share of the variance [%]")
    shares.legend(fontsize=8, frameon=False)
    bare(axes, shares)
    save(figure, path)
