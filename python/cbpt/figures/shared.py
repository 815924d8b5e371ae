"""What all pictures share.

Points               readings as a picture takes them
model_curves         the model as lines over the torque
ways_of              which way each reading is on
COLOURS, MARKERS     of settings, and of the ways of the torque
check_picture_name   refuses an ending that is not known
new_figure, save     a figure of matplotlib, and its file
titled               a title, folded to its axes
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import PlotError
from cbpt.whole_files import whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Legible on white for every kind of colour vision (Okabe and Ito 2008).
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = {1: ("^", "torque rising"), -1: ("v", "torque falling"), 0: ("o", "torque held")}
"""Marker and name of each direction of the torque."""
_PT_PER_INCH = 72.0
_LETTER = 0.58
"""Mean width of a letter, as a share of the size of the type."""
_FORMATS = (".svg", ".png", ".pdf")


@dataclass(frozen=True, eq=False)
class Points:
    """Readings as a picture takes them. Arrays have shape (n,) unless said."""

    source: str
    """The table they are from."""
    torque_Nm: Floats
    angle_arcsec: Floats
    u_arcsec: Floats | None
    """Standard uncertainty of the angle as stated; None where none is."""
    direction: Ints
    """+1 where the torque rises, -1 where it falls, 0 where it holds."""
    run: Ints
    leg: Ints
    """Counts on where the torque of a run turns back, and from run to run."""
    setting: Ints
    """What the rig was set to, counted from 0: preloads, else steps of the preload, else runs."""
    setting_names: tuple[str, ...]
    torque_set_point: Ints
    """The set point of each torque, counted from the lowest."""
    torque_set_points_Nm: Floats
    """Their values, shape (k,)."""

    def __len__(self) -> int:
        return len(self.torque_Nm)

    @property
    def directions(self) -> Iterator[tuple[int, str, str]]:
        """Those that occur: direction, marker and name."""
        for way, (marker, name) in MARKERS.items():
            if np.any(self.direction == way):
                yield way, marker, name


def model_curves(
    points: Points, model_arcsec: Floats, memory: bool
) -> Iterator[tuple[int, Floats, Floats]]:
    """Setting, torque and angle of each line: the mean model at each set point of the torque.

    One line for each setting; with memory one up and one down. Where hardly a torque comes twice:
    one for each run, with memory for each way of it. The model may differ between input
    angles too, and a line through all of its points would be a saw.
    """
    for _, setting, torque, angle in owned_curves(points, model_arcsec, memory):
        yield setting, torque, angle


def owned_curves(
    points: Points, model_arcsec: Floats, memory: bool
) -> Iterator[tuple[int, int, Floats, Floats]]:
    """The same with what each line is of ahead: its setting, or its run."""
    torque, count_of = points.torque_set_point, len(points.torque_set_points_Nm)
    if 2 * count_of > len(points):
        # Hardly a torque twice, as where it was measured and not set: the line follows the runs.
        # In order of the torque: where that scatters along its way, a line in time is a saw. One
        # curve both ways without memory: dashes drawn twice would fill each other's gaps.
        line = points.leg if memory else points.run
        order = np.argsort(line, kind="stable")
        for drawn in np.split(order, np.flatnonzero(np.diff(line[order])) + 1):
            rows = drawn[np.isfinite(model_arcsec[drawn])]
            rows = rows[np.argsort(points.torque_Nm[rows], kind="stable")]
            if len(rows):
                yield (
                    int(points.run[rows[0]]),
                    int(points.setting[rows[0]]),
                    points.torque_Nm[rows],
                    model_arcsec[rows],
                )
        return
    way = ways_of(points.direction, points.run) if memory else np.zeros(len(points), dtype=np.int64)
    for setting in range(len(points.setting_names)):
        for each in np.unique(way):
            rows = (points.setting == setting) & (way == each) & np.isfinite(model_arcsec)
            count = np.bincount(torque[rows], minlength=count_of)
            sums = np.bincount(torque[rows], model_arcsec[rows], count_of)
            there = count > 0
            yield setting, setting, points.torque_set_points_Nm[there], sums[there] / count[there]


def ways_of(direction: Ints, run: Ints) -> Ints:
    """Shape (n,): the direction of each reading; of one whose torque is held, the one that led
    there. A line through held readings alone would join the ends of a loop."""
    grouped = np.argsort(run, kind="stable")
    own, place = direction[grouped], np.arange(len(run))
    first = np.r_[True, np.diff(run[grouped]) != 0][: len(run)]
    last = np.maximum.accumulate(np.where((own != 0) | first, place, 0))
    found = np.empty_like(own)
    found[grouped] = own[last]
    return found


def draw_points(axes: Axes, points: Points, values: Floats, size: float) -> None:
    """A marker for each reading: its colour is the setting, its form the direction."""
    for setting in range(len(points.setting_names)):
        for way, (marker, _) in MARKERS.items():
            rows = (points.setting == setting) & (points.direction == way)
            axes.plot(
                points.torque_Nm[rows],
                values[rows],
                color=colour(setting),
                ls="",
                marker=marker,
                ms=size,
                alpha=0.65,
                mew=0,
            )


def colour(setting: int) -> str:
    """The colour of a setting; they come again after seven."""
    return COLOURS[setting % len(COLOURS)]


def check_picture_name(path: str | os.PathLike[str]) -> None:
    """Refuse a file name whose ending is not known, before any work is done."""
    if Path(path).suffix.lower() not in _FORMATS:
        raise PlotError(f"{os.fspath(path)}: the name must end in {', '.join(_FORMATS)}")


def new_figure(path: str | os.PathLike[str], width: float, height: float) -> Figure:
    """A figure of so many inches, to be saved to `path`. Raises `PlotError` for a name whose ending
    is not known, and without matplotlib."""
    check_picture_name(path)
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise PlotError('drawing needs matplotlib: pip install "cbpt[plot]"') from error
    return Figure(figsize=(width, height), layout="constrained")


def titled(axes: Axes, title: str, size_pt: float = 10.0) -> None:
    """A title above axes, folded where it would be wider than they are."""
    from matplotlib.figure import Figure

    figure, place = axes.get_figure(), axes.get_subplotspec()
    assert isinstance(figure, Figure)
    share = 1.0 if place is None else len(place.colspan) / place.get_gridspec().ncols
    letters = share * figure.get_figwidth() * _PT_PER_INCH / (_LETTER * size_pt)
    axes.set_title("\n".join(wrap(title, max(int(letters), 10))), loc="left", fontsize=size_pt)


def bare(*axes: Axes) -> None:
    """Take the frame off above and at the right."""
    for each in axes:
        each.spines[["top", "right"]].set_visible(False)


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure; the same picture is the same file, byte by byte."""
    import matplotlib as mpl

    with mpl.rc_context({"svg.hashsalt": "cbpt"}):
        metadata = {"Date": None} if Path(path).suffix.lower() == ".svg" else None
        form = Path(path).suffix[1:].lower()
        with whole(path) as new:
            figure.savefig(new, dpi=150, metadata=metadata, format=form)
