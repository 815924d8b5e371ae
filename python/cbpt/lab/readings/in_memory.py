"""Columns that are in memory, made a table.

    read_columns  a mapping, a data frame of any make, a structured array, a data set of xarray
    table_of      named arrays, with their units where they are stated apart from the names

A unit may hang on a column (`attrs` of pandas and xarray, the metadata of an Arrow field); it is
then read like a row of units under the headers. Dates and durations become seconds.
"""

from __future__ import annotations

import datetime
import hashlib
import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.readings.headers import read_header
from cbpt.lab.readings.text import Column, Loaded, Table, cells_of, check_headers, wrong

__all__ = ["array_of", "column_of", "read_columns", "table_of", "unit_below"]


def read_columns(data: Any) -> Table:
    """The table in columns: a mapping, a data frame (anything with column names and []) or arrays.

    Raises TypeError if `data` is nothing of the kind, ReadingsError if the columns are no table.
    """
    keys = _keys(data)
    columns = [data[key] for key in keys]
    units = [_unit_of(data, key, column) for key, column in zip(keys, columns, strict=True)]
    names = [str(key).strip() for key in keys]
    arrays = [array_of("<data>", name, each) for name, each in zip(names, columns, strict=True)]
    digest = hashlib.sha256()
    for name, array in zip(names, arrays, strict=True):
        digest.update(name.encode() + b"\0")
        digest.update(array.tobytes() if array.dtype != object else repr(list(array)).encode())
    return table_of("<data>", digest.hexdigest(), names, arrays, units)


def _keys(data: Any) -> list[Any]:
    """The names of the columns, in the type that `data` knows them by."""
    if hasattr(data, "data_vars") and hasattr(data, "coords"):  # xarray: the axes are columns too
        return [*data.coords, *data.data_vars]
    if isinstance(data, Mapping):
        return list(data)
    if isinstance(data, np.ndarray) and data.dtype.names:
        return list(data.dtype.names)
    # pyarrow keeps its names apart from its columns; elsewhere `columns` are the names.
    names = getattr(data, "column_names", None)
    names = getattr(data, "columns", None) if names is None else names
    if names is None or not hasattr(data, "__getitem__"):
        raise TypeError(
            "readings come from a path, a mapping of column to values or a data frame, "
            f"not from {type(data).__name__}"
        )
    return list(names)


def _unit_of(data: Any, key: Any, column: Any) -> str:
    """The unit that hangs on a column; empty where none does."""
    attributes = getattr(column, "attrs", None)
    if hasattr(getattr(data, "schema", None), "field"):  # Arrow
        attributes = {
            name.decode("utf-8", "replace"): value.decode("utf-8", "replace")
            for name, value in (data.schema.field(key).metadata or {}).items()
        }
    if not isinstance(attributes, Mapping):
        return ""
    found = next((attributes[name] for name in ("unit", "units") if name in attributes), "")
    return found.strip() if isinstance(found, str) else ""


def table_of(
    source: str,
    sha256: str,
    names: Sequence[str],
    arrays: Sequence[NDArray[Any]],
    units: Sequence[str] = (),
    notes: tuple[str, ...] = (),
) -> Table:
    """A table of arrays as `array_of` makes them; its rows count from 1."""
    if not names:
        raise wrong(source, "", "no columns", "a column for each quantity")
    check_headers(source, list(names), 0)
    n = max(map(len, arrays))
    for name, array in zip(names, arrays, strict=True):
        if len(array) != n:
            raise wrong(source, name, f"{len(array)} values", f"{n}, one for each row")
    clocks = [clock_of(array) for array in arrays]
    below = [
        unit_below(name, unit, clock is not None)
        for name, unit, clock in zip(names, units or [""] * len(names), clocks, strict=True)
    ]

    def load(as_text: Collection[int]) -> Loaded:
        columns = [column_of(array, i in as_text) for i, array in enumerate(arrays)]
        return Loaded(columns, np.arange(1, n + 1, dtype=np.int64), [])

    return Table(
        source, sha256, tuple(names), tuple(below), 0, "row", "a number", tuple(notes), load
    )


def array_of(source: str, name: str, values: Any) -> NDArray[Any]:
    """One column as float64, or as objects where it holds anything but numbers."""
    if isinstance(values, np.ma.MaskedArray):
        values = [None if value is np.ma.masked else value for value in values]
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        array = np.empty((0, 0))
    if array.ndim != 1:
        raise wrong(source, name, "values that are not a single column", "one value for each row")
    if array.dtype.kind in "mM":
        return array
    return array.astype(np.float64 if array.dtype.kind in "fiub" else object)


def column_of(array: NDArray[Any], keep: bool) -> Column:
    """The numbers of a column, and what is none."""
    clock = clock_of(array)
    if clock is not None:
        cells = ["" if math.isnan(t) else str(v) for v, t in zip(array, clock, strict=True)]
        odd = dict.fromkeys(np.flatnonzero(np.isnan(clock)).tolist(), "")
        return Column(clock, odd, cells if keep else [], clock=True)
    if array.dtype == np.float64:
        strange = np.flatnonzero(~np.isfinite(array))
        odd = {int(row): str(array[row]) for row in strange}
        numbers = array.copy()
        numbers[strange] = math.nan
        # A number of a run may have become a float on its way through a data frame.
        text = [_label(n) for n in array.tolist()] if keep else []
        return Column(numbers, odd, text)
    return cells_of([_cell(value) for value in array], 0, False, keep)


def _label(number: float) -> str:
    return str(int(number)) if number.is_integer() else str(number)


def _missing(value: Any) -> bool:
    """What stands for no value: None, pandas.NA, NaT, an empty cell of a workbook."""
    if value is None or type(value).__name__ in {"NAType", "NaTType"}:
        return True
    return isinstance(value, str) and not value.strip()


def _cell(value: Any) -> str:
    """A value as text; a missing one as nothing."""
    if _missing(value):
        return ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


# --- dates and durations ------------------------------------------------------------------


def unit_below(name: str, unit: str, clock: bool) -> str:
    """The unit of a column without one in its name: of dates in a column of times it is s."""
    if not clock or unit:
        return unit
    said = read_header(name, "s")
    of_time = said.quantity is not None and said.quantity.kind == "time" and not said.expected
    return "s" if of_time else ""


def clock_of(array: NDArray[Any]) -> NDArray[np.float64] | None:
    """Seconds since the earliest of a column of dates, or of durations and times of day.

    NaN where there is none; None where the column is no clock.
    """
    if array.dtype.kind in "mM":
        there = array[~np.isnat(array)]
        since = array - there.min() if array.dtype.kind == "M" and len(there) else array
        if since.dtype.kind == "M":  # not one date
            return np.full(len(array), math.nan)
        return np.asarray(since / np.timedelta64(1, "s"), dtype=np.float64)
    if array.dtype != object:
        return None
    values = [value for value in array if not _missing(value)]
    for kinds, seconds in (
        ((datetime.date,), _since_first),
        ((datetime.timedelta, datetime.time), _durations),
    ):
        if values and all(isinstance(value, kinds) for value in values):
            try:
                found = iter(seconds(values))
            except TypeError:  # dates with and without a time zone
                return None
            return np.array([math.nan if _missing(value) else next(found) for value in array])
    return None


def _since_first(dates: list[Any]) -> list[float]:
    """Midnight arrives as a date without a time."""
    midnight = datetime.time()
    exact = [
        each if isinstance(each, datetime.datetime) else datetime.datetime.combine(each, midnight)
        for each in dates
    ]
    first = min(exact)
    return [(each - first).total_seconds() for each in exact]


def _durations(clocks: list[Any]) -> list[float]:
    """Those below a day arrive as times of day."""
    return [
        each.total_seconds()
        if isinstance(each, datetime.timedelta)
        else 3600.0 * each.hour + 60 * each.minute + each.second + 1e-6 * each.microsecond
        for each in clocks
    ]
