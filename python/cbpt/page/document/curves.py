"""Lines through the model, for drawing: one for each setting of the rig and each way of the torque.

The model may differ between input angles and runs, and a line through all of its points would be a
saw; a line shows the mean at each torque level, or over stretches where the torque was not set to
levels. Numbers are read from the rows, never from these lines.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.figures.shared import ways_of
from cbpt.lab.readings.points import legs_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of, settings
from cbpt.page.document.plain import numbers
from cbpt.page.document.types import Branch, Column, Line

Floats = NDArray[np.float64]

BRANCHES: dict[int, Branch] = {1: "up", -1: "down", 0: "none"}
"""What `Readings.direction` says, as the document has it."""
# Points of a line where the torque was swept, not set.
_STRETCHES = 60


class Curves:
    """The lines of one table."""

    def __init__(self, readings: Readings) -> None:
        self.size = len(readings)
        levels, names = settings(readings)
        way = ways_of(readings.direction(), readings.run_index)
        torque, leg = levels_of(readings.torque_Nm), legs_of(readings)
        set_to_levels = 2 * len(torque) <= len(readings) and len(torque) <= 200
        self._cells = np.full(self.size, -1, dtype=np.int64)
        self.lines: list[Line] = []
        self._spans: list[slice] = []
        at = 0
        for level, name in enumerate(names):
            for branch in np.unique(way[levels.index == level]).tolist():
                rows = np.flatnonzero((levels.index == level) & (way == branch))
                if set_to_levels:
                    found, index = np.unique(torque.index[rows], return_inverse=True)
                    x = torque.value[found]
                else:
                    index, x = _stretches(readings.torque_Nm[rows], leg[rows])
                self._cells[rows] = at + index
                self._spans.append(slice(at, at + len(x)))
                at += len(x)
                self.lines.append(
                    {
                        "label": name,
                        "level": level,
                        "preload_N": None
                        if readings.preload_N is None
                        else float(levels.value[level]),
                        "branch": BRANCHES[branch],
                        "torque_Nm": numbers(x),
                    }
                )
        self._count = at
        self.mean_over = [
            name
            for name, values in (
                ("input angle", readings.input_angle_deg),
                ("run", readings.run_index),
            )
            if self._varies(values)
        ]
        """What differs between the readings of one point: its line shows the mean over that."""

    def _varies(self, values: NDArray[Any]) -> bool:
        order = np.lexsort((values, self._cells))
        cell, value = self._cells[order], values[order]
        return bool(np.any((cell[1:] == cell[:-1]) & (value[1:] != value[:-1])))

    def of(self, model_arcsec: Floats) -> list[Column | None]:
        """The lines of one model, in the order of `lines`."""
        solved = np.isfinite(model_arcsec)
        cells = self._cells[solved]
        count = np.bincount(cells, minlength=self._count)
        sums = np.bincount(cells, model_arcsec[solved], self._count)
        with np.errstate(invalid="ignore"):
            mean = np.where(count > 0, sums / np.maximum(count, 1), np.nan)
        return [numbers(mean[span]) for span in self._spans]


def _stretches(torque: Floats, leg: NDArray[np.int64]) -> tuple[NDArray[np.int64], Floats]:
    """Stretches of about equally many readings: which one each is in, and their mean torques. Of
    legs that do not overlap, as the first and the last of a loop, single readings where there are
    few."""
    order = np.argsort(torque, kind="stable")
    overlap = np.count_nonzero(np.diff(leg[order])) >= len(np.unique(leg))
    count = max(1, min(_STRETCHES, len(torque) // 3 if overlap else len(torque)))
    index = np.empty(len(torque), dtype=np.int64)
    index[order] = np.arange(len(torque)) * count // len(torque)
    return index, np.bincount(index, torque) / np.bincount(index)
