"""Designs of which none is better in two objectives."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import bare, colour, new_figure, save


def draw_front(
    values: NDArray[np.float64],
    before: NDArray[np.float64],
    labels: tuple[str, str],
    path: str | os.PathLike[str],
) -> None:
    """Draw designs, shape (n, 2), and the case as it was, shape (2,), to SVG, PNG or PDF."""
    figure = new_figure(path, 5.6, 4.0)
    axes = figure.subplots()
    # Points alone: a line between two would run above the designs that lie there.
    axes.plot(values[:, 0], values[:, 1], "o", color=colour(0), label="best within the bounds")
    if np.isfinite(before).all():
        axes.plot(*before, "x", color="C3", label="the case as it was")
    axes.set(xlabel=labels[0], ylabel=labels[1])
    axes.legend(fontsize="small", frameon=False)
    bare(axes)
    save(figure, path)
