"""The page of a result, for a notebook.

The page stands above the lab, which does not need it; so it is found by its name, as a plug-in is.

Shown    what a notebook shows
page     the page of a case, its readings and, if there is one, its diagnosis
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Protocol, cast

from cbpt._core import Case, Drive

__all__ = ["Shown", "page"]


class Shown(Protocol):
    """What a notebook shows where it is the value of a cell."""

    html: str
    """The page as `cbpt report` writes it."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to a file that a browser opens."""

    def _repr_html_(self) -> str: ...


def page(case: Case | Drive, readings: object, diagnosis: object, height_px: int) -> Shown:
    """The page in a frame of so many pixels in height. Raises `PlotError` without plotly."""
    front = import_module("cbpt.page.inline")
    return cast(Shown, front.inline(case, readings, diagnosis, height_px))
