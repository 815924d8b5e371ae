"""A part of a table, by what its columns say.

chosen_rows   the readings whose columns have the values that are asked for
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from cbpt.errors import ReadingsError
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import listed


def chosen_rows(readings: Readings, only: Mapping[str, Any]) -> Readings:
    """The readings whose labels are as asked: each column has its value, or one of several."""
    rows, told = np.ones(len(readings), dtype=bool), []
    for column, asked in only.items():
        labels = readings.labels[column]
        chosen, values = np.zeros(len(rows), dtype=bool), _values(asked)
        if not values:
            raise ReadingsError.of_column(
                readings.source, column, "no value", "one value, or several, of the column"
            )
        for wanted in values:
            same = np.array([_same(label, wanted) for label in labels.tolist()], dtype=bool)
            if not (rows & same).any():
                found = ", ".join(dict.fromkeys(labels[rows].tolist()))
                raise ReadingsError.of_column(
                    readings.source, column, f"only {found}", f"readings with {column} = {wanted}"
                )
            chosen |= same
        rows &= chosen
        told.append(f"{column} = {listed(values, 'or')}")
    if rows.all():
        return readings
    which = ", ".join(told)
    note = f"{np.count_nonzero(rows)} of {len(rows)} readings are used, those with {which}"
    return dataclasses.replace(readings.select(rows), notes=(*readings.notes, note))


def _values(asked: object) -> list[str]:
    """One value, or each of several once."""
    several = asked if isinstance(asked, Iterable) and not isinstance(asked, str) else [asked]
    return list(dict.fromkeys(str(value) for value in several))


def _same(label: str, wanted: str) -> bool:
    """Whether two cells say the same, as text or as numbers."""
    try:
        return label == wanted or float(label) == float(wanted)
    except ValueError:
        return False
