"""What a campaign could tell apart, as a matrix: an effect a row, how like each other they look."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from cbpt.errors import PlotError
from cbpt.figures.shared import new_figure, save, titled

_SIGNS = {"apart": "", "above": "larger", "not_here": "no", "twins": "twins"}


class Pair(Protocol):
    """Two effects, how like they look and what a plan makes of that."""

    @property
    def effects(self) -> tuple[str, str]: ...
    @property
    def correlation(self) -> float: ...
    @property
    def verdict(self) -> str: ...


def draw_isolability(pairs: Sequence[Pair], path: str | os.PathLike[str]) -> None:
    """Draw the pairs to `path` (SVG, PNG or PDF by its ending)."""
    names = list(dict.fromkeys(e for p in pairs for e in p.effects))
    size = 2.6 + 0.42 * len(names)
    figure = new_figure(path, size + 1.2, size)
    if not names:
        raise PlotError("nothing to draw: fewer than two effects are detectable with this plan")
    place = {name: k for k, name in enumerate(names)}
    matrix = np.full((len(names), len(names)), np.nan)
    axes = figure.subplots()
    for pair in pairs:
        one, other = sorted(place[e] for e in pair.effects)
        # Half a square is enough: the lower one.
        matrix[other, one] = pair.correlation
        shade = "white" if pair.correlation > 0.6 else "black"
        sign = _SIGNS[pair.verdict]
        axes.text(one, other, sign, ha="center", va="center", fontsize=7.5, color=shade)
    shown = axes.imshow(matrix, vmin=0, vmax=1, cmap="cividis_r")
    figure.colorbar(
        shown, label="correlation after refitting, at the smallest detectable size", shrink=0.6
    )
    axes.set_xticks(range(len(names)), names, rotation=90, fontsize=10)
    axes.set_yticks(range(len(names)), names, fontsize=10)
    axes.spines[:].set_visible(False)
    titled(
        axes,
        "larger: distinguishable only above the smallest detectable size; "
        "no: not distinguishable with this plan; "
        "twins: not distinguishable by any plan; blank: one of the two is not detectable",
        11.0,
    )
    save(figure, path)
