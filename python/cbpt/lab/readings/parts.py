"""The tables in a program's file: what its contents mean.

    Part    one table of a file that may hold several: a sheet, a struct, a group
    PARTS   for each kind of file, what makes parts of its contents

`apart` gets the contents out of the file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import Words
from cbpt.lab.readings.apart import Contents
from cbpt.lab.readings.headers import plain, read_header
from cbpt.lab.readings.in_memory import array_of, column_of, table_of, unit_below
from cbpt.lab.readings.text import Loaded, Table, check_headers, is_unit_row, stop_if_wide, wrong

__all__ = ["PARTS", "File", "Part"]

# Headers are looked for in as many rows of a sheet.
_TITLE_ROWS = 50


@dataclass(frozen=True)
class File:
    """A file on its way to tables. columns: what the user says of headers (`read_readings`)."""

    source: str
    sha256: str
    contents: Contents
    columns: Mapping[str, str]

    def column(self, number: int) -> NDArray[Any]:
        """A column by the number that it has in the contents."""
        return self.contents.columns[number]


@dataclass(frozen=True)
class Part:
    """A table inside a file. headers, below: as in `Table`; load: makes the table."""

    name: str
    headers: Sequence[str]
    below: Sequence[str]
    load: Callable[[str], Table]

    def has_readings(self, columns: Mapping[str, str]) -> bool:
        """Whether a column may hold the torque, or is one of those the user speaks of."""
        return _has_readings(self.headers, self.below, columns)


def _has_readings(headers: Sequence[str], below: Sequence[str], columns: Mapping[str, str]) -> bool:
    units = list(below) or [""] * len(headers)
    return any(
        header in columns
        or any(each.key == "torque" for each in read_header(header, unit).candidates)
        for header, unit in zip(headers, units, strict=True)
        if plain(header)
    )


def _part_of_arrays(
    name: str,
    file: File,
    columns: Mapping[str, NDArray[Any]],
    units: Sequence[str],
    notes: Sequence[str | Words] = (),
) -> Part:
    """A part whose columns are at hand."""
    names = [each.strip() for each in columns]
    stop_if_wide(file.source, names)

    def load(called: str) -> Table:
        named = zip(names, columns.values(), strict=True)
        arrays = [array_of(called, each, values) for each, values in named]
        return table_of(called, file.sha256, names, arrays, units, tuple(notes))

    return Part(name, names, units, load)


# --- workbooks ----------------------------------------------------------------------------


def _workbook(file: File) -> Iterator[Part]:
    """The sheets that hold anything."""
    for sheet in file.contents.parts:
        columns = [file.column(number) for number in sheet["columns"]]
        yield _sheet(file, sheet["name"], file.column(sheet["rows"]), columns)


def _sheet(file: File, name: str, rows: NDArray[Any], columns: Sequence[NDArray[Any]]) -> Part:
    """One sheet: perhaps a title, a row of headers, perhaps one of units, rows, perhaps gaps.

    rows: the numbers (from 0) of those that are not empty; columns: all cells of these.
    """
    at, header, units = _headers(file, rows, columns)
    first = at + 1 + bool(units)
    notes = (f"rows above the headers were skipped ({rows[0] + 1} to {rows[at - 1] + 1})",)
    values = [_of_cells(column[first:].tolist()) for column in columns]
    kept = [i for i, each in enumerate(header) if each or any(map(_full, values[i].tolist()))]
    headers = [header[i] for i in kept]
    values = [values[i] for i in kept]
    line = int(rows[at]) + 1

    def load(source: str) -> Table:
        check_headers(source, headers, line)
        below = [units[i] for i in kept] if units else [""] * len(kept)
        below = [
            unit_below(each, unit, column_of(column, False).clock)
            for each, unit, column in zip(headers, below, values, strict=True)
        ]

        def cells(as_text: Any) -> Loaded:
            found = [column_of(column, i in as_text) for i, column in enumerate(values)]
            return Loaded(found, rows[first:] + 1, [])

        return Table(
            *(source, file.sha256, tuple(headers), tuple(below), line, "row", "a number"),
            *(notes if at else (), cells),
        )

    return Part(name, headers, [units[i] for i in kept] if units else [], load)


def _headers(
    file: File, rows: NDArray[Any], columns: Sequence[NDArray[Any]]
) -> tuple[int, list[str], list[str]]:
    """Which of the rows has the headers; these, and the units right under them if there are any."""
    top = [[str(cell).strip() for cell in column[: _TITLE_ROWS + 1].tolist()] for column in columns]
    texts = [list(row) for row in zip(*top, strict=True)]

    def units_under(at: int) -> list[str]:
        follows = at + 1 < len(rows) and rows[at + 1] == rows[at] + 1
        return texts[at + 1] if follows and is_unit_row(texts[at + 1], texts[at]) else []

    for at, cells in enumerate(texts[:_TITLE_ROWS]):
        stop_if_wide(file.source, cells)
        units = units_under(at)
        if sum(map(bool, cells)) > 1 and _has_readings(cells, units, file.columns):
            return at, cells, units
    return 0, texts[0], units_under(0)


def _full(cell: Any) -> bool:
    return not isinstance(cell, str) or bool(cell.strip())


def _of_cells(cells: list[Any]) -> NDArray[Any]:
    if all(type(cell) in (int, float) for cell in cells):
        return np.array(cells, dtype=np.float64)
    column = np.empty(len(cells), dtype=object)
    column[:] = cells
    return column


# --- MATLAB -------------------------------------------------------------------------------


def _matlab(file: File) -> Iterator[Part]:
    """The top level and each struct with vectors; matrices whose columns are named."""
    for level in file.contents.parts:
        yield from _tables_of(file, level)


def _tables_of(file: File, level: Mapping[str, Any]) -> Iterator[Part]:
    name = level["name"]
    vectors = {key: file.column(number) for key, number in level["vectors"].items()}
    matrices = {
        key: [file.column(n) for n in numbers] for key, numbers in level["matrices"].items()
    }
    names_of: dict[str, str] = {}
    for key, matrix in matrices.items():
        for other, names in vectors.items():
            if len(names) == len(matrix) and all(isinstance(each, str) for each in names):
                names_of[key] = other
    for key, other in names_of.items():
        called = [str(each).strip() for each in vectors[other]]
        if len(set(called)) == len(called):
            by_name = dict(zip(called, matrices[key], strict=True))
            inner = key if name == "top level" else f"{name}.{key}"
            yield _part_of_arrays(inner, file, by_name, [""] * len(called))
    vectors = {key: value for key, value in vectors.items() if key not in names_of.values()}
    if vectors:
        kept, notes = _equally_long(vectors, level["keys"], file.columns)
        yield _part_of_arrays(name, file, kept, [""] * len(kept), notes)
    elif matrices and not names_of:
        key, matrix = next(iter(matrices.items()))
        found = f"a matrix of {len(matrix)} columns without names"
        remedy = (
            "save the names of its columns, in order, as a cell array in the same file "
            "(names = {'torque_Nm', ...}), or save a struct with a vector for each column"
        )
        raise wrong(file.source, key, found, "a name for each column", remedy)


def _equally_long(
    vectors: Mapping[str, NDArray[Any]], keys: Sequence[str], columns: Mapping[str, str]
) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Vectors as long as the torque; those of another length only where they are readings."""
    telling = {
        key: bool(read_header(columns.get(key, key)).candidates) and columns.get(key) != "extra"
        for key in keys
    }
    lengths = [len(value) for key, value in vectors.items() if telling[key]]
    lengths = lengths or [len(value) for value in vectors.values()]
    n = max(set(lengths), key=lengths.count)
    kept = {key: value for key, value in vectors.items() if len(value) == n or telling[key]}
    left = [key for key in vectors if key not in kept]
    notes = (
        [f"{', '.join(left)}: not read, because the length is not that of the readings"]
        if left
        else []
    )
    single = [key for key in keys if telling[key] and key not in vectors]
    if single:
        notes.append(f"{', '.join(single)}: not read, because it has no value for each reading")
    return kept, notes


# --- TDMS ---------------------------------------------------------------------------------


def _tdms(file: File) -> Iterator[Part]:
    """The groups; a channel's unit is its own, waveforms bring their time along."""
    for group in file.contents.parts:
        channels = {each["name"]: each for each in group["channels"]}
        notes = [
            f"channel {name!r} is empty and was not read"
            for name, channel in channels.items()
            if channel["column"] is None
        ]
        channels = {k: channel for k, channel in channels.items() if channel["column"] is not None}
        if not channels:
            continue
        units = [channel["unit"] for channel in channels.values()]
        values = {name: file.column(channel["column"]) for name, channel in channels.items()}
        waves = [(channel["wave"], len(values[name])) for name, channel in channels.items()]
        time = _waveform_time(waves)
        if time is not None and not any(
            (said := read_header(file.columns.get(name, name), unit)).quantity
            and said.quantity.key == "time"
            for name, unit in zip(values, units, strict=True)
        ):
            values, units = {"time_s": time} | values, ["", *units]
            step = next(iter(channels.values()))["wave"][1]
            notes.append(
                f"time_s comes from the clock of the waveforms: {step:g} s between readings"
            )
        yield _part_of_arrays(group["name"], file, values, units, notes)


def _waveform_time(waves: Sequence[tuple[Any, int]]) -> NDArray[np.float64] | None:
    """Seconds of channels that are waveforms of one clock; None where they are none."""
    clocks = {(*wave, n) for wave, n in waves if wave is not None}
    if len(clocks) != 1:
        return None
    start, step, n = clocks.pop()
    if not (step > 0 and np.isfinite([start, step]).all()):
        return None
    return np.asarray(start + step * np.arange(n), dtype=np.float64)


# --- Parquet ------------------------------------------------------------------------------


def _parquet(file: File) -> Iterator[Part]:
    """The one table of the file."""
    for part in file.contents.parts:
        arrays = map(file.column, part["columns"])
        headers = [header.strip() for header in part["headers"]]
        columns = dict(zip(headers, arrays, strict=True))
        if len(columns) < len(headers):
            check_headers(file.source, headers, 0)
        yield _part_of_arrays(part["name"], file, columns, part["units"])


PARTS: dict[str, Callable[[File], Iterator[Part]]] = {
    "workbook": _workbook,
    "matlab": _matlab,
    "tdms": _tdms,
    "parquet": _parquet,
}
