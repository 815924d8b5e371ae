"""Small pictures for notebooks as SVG, without a plotting library; everything is escaped.

Series   points that are drawn together, under one name
sketch   series over one axis
against  a column over the one that varies most, a series for each setting of the others
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Series", "against", "sketch"]

# Legible on white for every kind of colour vision (Okabe and Ito 2008).
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_WIDTH, _HEIGHT = 460, 220
_LEFT, _RIGHT, _TOP, _BOTTOM = 60, 300, 12, 180
"""The field that is drawn in; names of the series stand at its right."""
_MOST_POINTS = 400
"""Of a series: a notebook keeps its pictures."""
_TEXT = 'font-size="11" font-family="sans-serif"'


@dataclass(frozen=True, eq=False)
class Series:
    """Points that are drawn together; a line through them, or dots."""

    name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    line: bool = True


def sketch(series: Sequence[Series], x_name: str, y_name: str) -> str:
    """Series as an SVG of the width of a table; empty where fewer than two points are finite."""
    kept = [s for s in map(_finite, series) if len(s.x)]
    if sum(len(s.x) for s in kept) < 2:
        return ""
    x, y = (_range([getattr(s, axis) for s in kept]) for axis in ("x", "y"))
    shown = [_drawn(s, x, y, i) for i, s in enumerate(kept)]
    if len(kept) > 1:
        shown += [_named(s.name, i) for i, s in enumerate(kept[: len(_COLOURS)])]
    ends = {axis: _said_range(of) for axis, of in (("x", x), ("y", y))}
    frame = (
        f'<path d="M{_LEFT} {_TOP}V{_BOTTOM}H{_RIGHT}" fill="none" stroke="#444"/>'
        + _text(_LEFT, _BOTTOM + 14, "start", ends["x"][0])
        + _text(_RIGHT, _BOTTOM + 14, "end", ends["x"][1])
        + _text((_LEFT + _RIGHT) / 2, _BOTTOM + 30, "middle", f"{y_name} over {x_name}")
        + _text(_LEFT - 4, _BOTTOM, "end", ends["y"][0])
        + _text(_LEFT - 4, _TOP + 8, "end", ends["y"][1])
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}" role="img"'
    return f'{head} style="background:#fff">{frame}{"".join(shown)}</svg>'


def against(columns: Mapping[str, NDArray[Any]], y_name: str, y: NDArray[np.float64]) -> str:
    """`y` over the column of numbers that has most values; empty where none varies."""
    flat = {name: np.ravel(column) for name, column in columns.items()}
    counts = {
        name: np.unique(column[np.isfinite(column)]).size
        for name, column in flat.items()
        if column.dtype.kind in "fiu"
    }
    over = max(counts, key=lambda name: counts[name], default="")
    if counts.get(over, 0) < 2:
        return ""
    x, y = flat[over].astype(np.float64), np.ravel(y)
    others = [n for n, column in flat.items() if n != over and np.unique(column).size > 1]
    settings = list(zip(*(flat[name].tolist() for name in others), strict=True)) or [()] * len(x)
    different = list(dict.fromkeys(settings))
    if len(different) > len(_COLOURS):
        return sketch([Series("", x, y, line=False)], over, y_name)
    series = []
    for setting in different:
        rows = np.flatnonzero([each == setting for each in settings])
        rows = rows[np.argsort(x[rows], kind="stable")]
        told = (_said(name, value) for name, value in zip(others, setting, strict=True))
        series.append(Series(", ".join(told), x[rows], y[rows]))
    return sketch(series, over, y_name)


def _said(name: str, value: object) -> str:
    return f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}"


def _finite(series: Series) -> Series:
    there = np.flatnonzero(np.isfinite(series.x) & np.isfinite(series.y))
    there = there[:: 1 + len(there) // _MOST_POINTS]
    return Series(series.name, series.x[there], series.y[there], series.line)


def _range(columns: Sequence[NDArray[np.float64]]) -> tuple[float, float]:
    low, high = (float(of([of(c) for c in columns])) for of in (np.min, np.max))
    return (low, high) if high > low else (low - 1.0, high + 1.0)


def _said_range(ends: tuple[float, float]) -> tuple[str, str]:
    """Both ends as text; what is rounding beside the other is 0."""
    low, high = (0.0 if abs(end) < 1e-9 * (ends[1] - ends[0]) else end for end in ends)
    return f"{low:.4g}", f"{high:.4g}"


def _drawn(series: Series, x: tuple[float, float], y: tuple[float, float], number: int) -> str:
    colour = _COLOURS[number % len(_COLOURS)]
    across = _LEFT + (series.x - x[0]) / (x[1] - x[0]) * (_RIGHT - _LEFT)
    up = _BOTTOM - (series.y - y[0]) / (y[1] - y[0]) * (_BOTTOM - _TOP)
    points = [f"{a:.1f} {u:.1f}" for a, u in zip(across.tolist(), up.tolist(), strict=True)]
    if series.line and len(points) > 1:
        d, form = "M" + "L".join(points), 'stroke-width="1.5"'
    else:
        # A line of no length with round ends is a dot.
        d, form = "".join(f"M{p}h0" for p in points), 'stroke-width="4" stroke-linecap="round"'
    return f'<path d="{d}" fill="none" stroke="{colour}" {form}/>'


def _named(name: str, number: int) -> str:
    at = _TOP + 10 + 15 * number
    line = f'<path d="M{_RIGHT + 8} {at - 4}h12" stroke="{_COLOURS[number]}" stroke-width="3"/>'
    return line + _text(_RIGHT + 24, at, "start", name)


def _text(x: float, y: float, anchor: str, text: str) -> str:
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" {_TEXT}>{escape(text)}</text>'
