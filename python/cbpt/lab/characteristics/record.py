"""Figures of all settings as a record, which text, picture and document are made from.

Group                 the figures of one setting, from readings, model or both
CharacteristicsData   all groups, with the convention
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.figures import Convention, curve_torques, stiffness_of
from cbpt.lab.characteristics.uncertainty import Figure, LoopSet
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]

_NOTHING = 1e-3
"""An angle below this share of the lost motion is none, and nothing is divided by it."""


@dataclass(frozen=True, eq=False)
class Group:
    """The figures at one setting."""

    setting: str | None
    """In words; None where the table has only one."""
    readings: tuple[Figure, ...]
    """Of the readings; empty without a table."""
    model: tuple[Figure, ...]
    """Of the model with its effects."""
    loops: LoopSet | None = field(repr=False)
    model_loops: LoopSet | None = field(repr=False)
    count: int
    """Loops in the table at this setting."""
    warnings: tuple[str, ...] = ()

    @property
    def figures(self) -> tuple[Figure, ...]:
        """Of the readings, else of the model."""
        return self.readings or self.model

    def ratios(self) -> Iterator[tuple[str, float, float]]:
        """Name, reading over model, and its standard uncertainty."""
        motion = next((f.value or 0.0 for f in self.model if f.name == "lost_motion"), 0.0)
        for a, b in zip(self.readings, self.model, strict=False):
            if a.value is None or not b.value:
                continue
            if a.unit == "arcsec" and abs(b.value) < _NOTHING * motion:
                continue
            ratio = a.value / b.value
            parts = [(f.u or 0.0) / f.value for f in (a, b) if f.value]
            yield a.name, ratio, abs(ratio) * float(np.hypot.reduce(parts))

    def stiffness_curve(self, convention: Convention) -> list[dict[str, Any]]:
        """Secant stiffness of both branches over the torque, N m/arcmin, mean over the loops, with
        the standard uncertainty of that mean where there are several."""
        loops = self.loops or self.model_loops
        if loops is None:
            return []
        columns: dict[str, Floats] = {"torque_Nm": curve_torques(convention)}
        for way in ("rising", "falling"):
            table = np.array([stiffness_of(getattr(x, way), convention) for x in loops.full])
            columns[way] = table.mean(axis=0)
            n = len(table)
            columns[f"u_{way}"] = table.std(axis=0, ddof=1) / n**0.5 if n > 1 else table[0] * np.nan
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        return [
            {name: None if v != v else v for name, v in zip(columns, row, strict=True)}
            for row in rows
        ]


@dataclass(frozen=True, eq=False)
class CharacteristicsData:
    """Figures with what they were read off with."""

    groups: tuple[Group, ...]
    convention: Convention
    rated_torque_from: str
    """Where the rated torque comes from, in words."""
    source: Readings | None = field(repr=False)
    """The readings; None where only the model was asked."""
    by: str | None = None

    @property
    def figures(self) -> tuple[Figure, ...]:
        """All figures: of the readings, else of the model, setting by setting."""
        return tuple(figure for group in self.groups for figure in group.figures)

    def figure(self, name: str, setting: str | None = None) -> Figure:
        """One figure by its name, of the first setting where none is named."""
        for each in self.figures:
            if each.name == name and setting in (None, each.setting):
                return each
        raise KeyError(name)
