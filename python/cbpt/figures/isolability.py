"""What a campaign could tell apart, as a matrix: an effect a row, how like each other they look."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from cbpt.errors import PlotError
from cbpt.figures.comparison import check_picture_name

if TYPE_CHECKING:
    from cbpt.lab.experiment.isolability import Isolability

_SIGNS = {"apart": "", "above": "larger", "not_here": "no", "twins": "twins"}


def draw_isolability(i: Isolability, path: str | os.PathLike[str]) -> None:
    """Draw `i` to `path` (SVG, PNG or PDF by its ending)."""
    check_picture_name(path)
    try:
        import matplotlib as mpl
        from matplotlib.figure import Figure
    except ImportError as error:
        raise PlotError('drawing needs matplotlib: pip install "cbpt[plot]"') from error

    names = list(dict.fromkeys(e for p in i.pairs for e in p.effects))
    if not names:
        raise PlotError("nothing to draw: this plan shows fewer than two effects")
    place = {name: k for k, name in enumerate(names)}
    matrix = np.full((len(names), len(names)), np.nan)
    size = 2.6 + 0.42 * len(names)
    figure = Figure(figsize=(size + 1.2, size), layout="constrained")
    axes = figure.subplots()
    for pair in i.pairs:
        one, other = sorted(place[e] for e in pair.effects)
        # Half a square is enough: the lower one.
        matrix[other, one] = pair.correlation
        colour = "white" if pair.correlation > 0.6 else "black"
        sign = _SIGNS[pair.verdict]
        axes.text(one, other, sign, ha="center", va="center", fontsize=6.5, color=colour)
    shown = axes.imshow(matrix, vmin=0, vmax=1, cmap="cividis_r")
    figure.colorbar(
        shown, label="correlation after the refit, at the smallest size seen", shrink=0.6
    )
    axes.set_xticks(range(len(names)), names, rotation=90, fontsize=8)
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.spines[:].set_visible(False)
    axes.set_title(
        "larger: told apart only above the smallest size seen; no: not by this plan; twins: never; "
        "blank: not both are seen",
        fontsize=8,
    )
    with mpl.rc_context({"svg.hashsalt": "cbpt", "svg.fonttype": "none"}):
        figure.savefig(path, metadata={"Date": None} if str(path).endswith("svg") else None)
