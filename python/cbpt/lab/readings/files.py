"""Files that programs write tables of readings to, each made the same table as a CSV file.

    read_file   CSV, workbook (xlsx, xls, ods), MATLAB (.mat), TDMS or Parquet, told by its content
    at_most     tighter limits, for files from somebody else
    Part        one table of a file that may hold several: a sheet, a struct, a group

The libraries come with `pip install "cbpt[io]"` and are imported only when such a file is read.
Whatever goes wrong inside of them is told as a ReadingsError that names the file.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import reduce
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import ChooseSheet, ReadingsError, Setting, Words
from cbpt.lab.readings.headers import plain, read_header
from cbpt.lab.readings.in_memory import array_of, column_of, read_columns, table_of, unit_below
from cbpt.lab.readings.text import (
    Loaded,
    Table,
    check_headers,
    is_unit_row,
    read_bytes,
    read_text,
    stop_if_wide,
    wrong,
)

__all__ = ["at_most", "read_file"]

# More than any campaign has; a file that claims more is broken or meant to do harm.
_MOST_CELLS = ContextVar("most_cells", default=50_000_000)
_MOST_BYTES = ContextVar("most_bytes", default=1 << 30)
# Headers are looked for in as many rows of a sheet.
_TITLE_ROWS = 50


@contextmanager
def at_most(cells: int, unpacked_bytes: int) -> Iterator[None]:
    """Larger files are refused, here and now, before they are unpacked."""
    before = _MOST_CELLS.set(cells), _MOST_BYTES.set(unpacked_bytes)
    try:
        yield
    finally:
        _MOST_CELLS.reset(before[0])
        _MOST_BYTES.reset(before[1])


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


def read_file(path: str | os.PathLike[str], sheet: str | None, columns: Mapping[str, str]) -> Table:
    """The table of readings in a file, of several the one called `sheet` or the first that fits.

    columns: as in `read_readings`, to know which of several tables is meant.
    """
    source = os.fsdecode(path)
    raw = read_bytes(source)
    for kind, what, magics, reader in _FORMATS:
        if raw.startswith(magics):
            with _reading(source, kind):
                parts = list(reader(source, raw, columns))
                return _chosen(source, parts, what, sheet, columns)
    if raw.startswith(b"\x89HDF"):
        raise wrong(source, "", "an HDF5 file", "a table of readings", "export it to CSV")
    if sheet is not None:
        remedy = Words("leave out ", Setting("sheet"))
        expected = f"a file with the sheet {sheet!r}"
        raise wrong(source, "", "a text table, which has no sheets", expected, remedy)
    return read_text(source, raw)


def sheets_of(path: str | os.PathLike[str], columns: Mapping[str, str]) -> list[tuple[str, bool]]:
    """The tables of a file that may hold several, by name, and whether each may hold readings; of a
    file that holds one as text, none."""
    source = os.fsdecode(path)
    raw = read_bytes(source)
    for kind, _, magics, reader in _FORMATS:
        if raw.startswith(magics):
            with _reading(source, kind):
                return [(p.name, p.has_readings(columns)) for p in reader(source, raw, columns)]
    return []


@contextmanager
def _reading(source: str, kind: str) -> Iterator[None]:
    """Whatever a library makes of a broken file, said in one sentence that names the file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (ReadingsError, KeyboardInterrupt, SystemExit):
        raise
    except ImportError as error:
        remedy = 'pip install "cbpt[io]", or export the table to CSV'
        expected = f"the library that reads it ({error.name or error})"
        raise wrong(source, "", kind, expected, remedy) from None
    except BaseException as error:  # a panic in a library of Rust is no Exception
        why = (str(error).strip() or type(error).__name__).splitlines()[0][:200]
        found = f"{kind} that cannot be read ({why})"
        remedy = "save it again, or export the table to CSV"
        raise wrong(source, "", found, "a complete file", remedy) from None


def _chosen(
    source: str, parts: Sequence[Part], what: str, sheet: str | None, columns: Mapping[str, str]
) -> Table:
    """The part asked for, else the first with readings."""
    names = ", ".join(repr(part.name) for part in parts)
    if not parts:
        raise wrong(source, "", f"no {what} with a table in it", "a row for each reading")

    def load(part: Part) -> Table:
        return part.load(f"{source}, {what} {part.name!r}" if len(parts) > 1 else source)

    if sheet is not None:
        for part in parts:
            if part.name == sheet:
                return load(part)
        raise wrong(source, "", f"no {what} {sheet!r}", f"one of {names}")
    fitting = [part for part in parts if part.has_readings(columns)]
    if not fitting and len(parts) > 1:
        expected = f"a {what} of readings with a column torque_Nm"
        remedy = Words(
            f"choose a {what} (for example ",
            ChooseSheet(parts[0].name),
            ") and state what its columns are",
        )
        raise wrong(source, "", f"only {names}", expected, remedy)
    if len(fitting) > 1:
        others = ", ".join(repr(part.name) for part in fitting[1:])
        note = Words(
            f"read {what} {fitting[0].name!r}; {others} may hold readings too (",
            Setting("sheet"),
            " chooses another)",
        )
        table = load(fitting[0])
        return replace(table, notes=(*table.notes, note))
    return load(fitting[0] if fitting else parts[0])


def _has_readings(headers: Sequence[str], below: Sequence[str], columns: Mapping[str, str]) -> bool:
    units = list(below) or [""] * len(headers)
    return any(
        header in columns
        or any(each.key == "torque" for each in read_header(header, unit).candidates)
        for header, unit in zip(headers, units, strict=True)
        if plain(header)
    )


def _stop_if_large(source: str, cells: int) -> None:
    if cells > _MOST_CELLS.get():
        expected = f"at most {_MOST_CELLS.get():,}"
        raise wrong(
            source,
            "",
            f"{cells:,} cells",
            expected,
            "keep only the rows and columns that are needed",
        )


def _part_of_arrays(
    name: str,
    source: str,
    raw: bytes,
    columns: Mapping[str, Any],
    units: Sequence[str],
    notes: Sequence[str] = (),
) -> Part:
    """A part whose columns are at hand."""
    names = [each.strip() for each in columns]

    def load(called: str) -> Table:
        arrays = [
            array_of(called, each, values)
            for each, values in zip(names, columns.values(), strict=True)
        ]
        sha256 = hashlib.sha256(raw).hexdigest()
        return table_of(called, sha256, names, arrays, units, tuple(notes))

    return Part(name, names, units, load)


# --- workbooks ----------------------------------------------------------------------------


def _workbook(source: str, raw: bytes, columns: Mapping[str, str]) -> Iterator[Part]:
    """The sheets that hold anything; numbers and dates arrive as such."""
    if raw.startswith(b"PK"):
        _stop_if_bomb(source, zipfile.ZipFile(io.BytesIO(raw)))
    book = import_module("python_calamine").CalamineWorkbook.from_filelike(io.BytesIO(raw))
    for name in book.sheet_names:
        sheet = book.get_sheet_by_name(name)
        _stop_if_large(source, sheet.total_height * sheet.total_width)
        rows = sheet.to_python(skip_empty_area=False)
        if any(not _is_empty(row) for row in rows):
            yield _sheet(source, name, rows, hashlib.sha256(raw).hexdigest(), columns)


def _stop_if_bomb(source: str, archive: zipfile.ZipFile) -> None:
    """Sheets are unpacked as full rectangles: one stray cell in the last row would end it all."""
    unpacked = sum(each.file_size for each in archive.infolist())
    most = _MOST_BYTES.get()
    if unpacked > most:
        raise wrong(source, "", f"{unpacked:,} bytes when unpacked", f"at most {most:,}")
    for each in archive.namelist():
        if re.fullmatch(r"xl/worksheets/[^/]*\.xml", each):
            rows = columns = 0
            for cell in _CELL.finditer(archive.read(each)):
                rows = max(rows, int(cell[2]))
                columns = max(columns, reduce(lambda n, letter: 26 * n + letter - 64, cell[1], 0))
            _stop_if_large(source, rows * columns)


# A cell with something in it; its column has letters from A to XFD.
_CELL = re.compile(rb'<c r="([A-Z]{1,3})(\d{1,7})"[^>]*(?<!/)>')


def _is_empty(row: Sequence[Any]) -> bool:
    return all(isinstance(cell, str) and not cell.strip() for cell in row)


def _sheet(
    source: str,
    name: str,
    rows: Sequence[Sequence[Any]],
    sha256: str,
    columns: Mapping[str, str],
) -> Part:
    """One sheet: perhaps a title, a row of headers, perhaps one of units, rows, perhaps gaps."""
    filled = [number for number, row in enumerate(rows) if not _is_empty(row)]
    at, header = filled[0], _texts(rows[filled[0]])
    for number in filled[:_TITLE_ROWS]:
        cells = _texts(rows[number])
        stop_if_wide(source, cells)
        below = _units_under(rows, number, cells)
        if sum(map(bool, cells)) > 1 and _has_readings(cells, below, columns):
            at, header = number, cells
            break
    units = _units_under(rows, at, header)
    body = [number for number in filled if number > at + bool(units)]
    above = [number + 1 for number in filled if number < at]
    notes = (f"rows {above[0]} to {above[-1]} above the headers were skipped",) if above else ()
    kept = [i for i, each in enumerate(header) if each or any(_full(rows[n][i]) for n in body)]
    headers = [header[i] for i in kept]
    values = [_of_cells([rows[number][i] for number in body]) for i in kept]

    def load(source: str) -> Table:
        check_headers(source, headers, at + 1)
        below = [units[i] for i in kept] if units else [""] * len(kept)
        below = [
            unit_below(each, unit, column_of(column, False).clock)
            for each, unit, column in zip(headers, below, values, strict=True)
        ]

        def cells(as_text: Any) -> Loaded:
            found = [column_of(column, i in as_text) for i, column in enumerate(values)]
            return Loaded(found, np.array(body, dtype=np.int64) + 1, [])

        return Table(
            source, sha256, tuple(headers), tuple(below), at + 1, "row", "a number", notes, cells
        )

    return Part(name, headers, [units[i] for i in kept] if units else [], load)


def _full(cell: Any) -> bool:
    return not isinstance(cell, str) or bool(cell.strip())


def _texts(row: Sequence[Any]) -> list[str]:
    return [str(cell).strip() for cell in row]


def _units_under(rows: Sequence[Sequence[Any]], at: int, header: list[str]) -> list[str]:
    """The row of units right under the headers; empty where it is none."""
    below = _texts(rows[at + 1]) if at + 1 < len(rows) else []
    return below if is_unit_row(below, header) else []


def _of_cells(cells: list[Any]) -> NDArray[Any]:
    if all(type(cell) in (int, float) for cell in cells):
        return np.array(cells, dtype=np.float64)
    column = np.empty(len(cells), dtype=object)
    column[:] = cells
    return column


# --- MATLAB -------------------------------------------------------------------------------


def _matlab(source: str, raw: bytes, columns: Mapping[str, str]) -> Iterator[Part]:
    """The top level and each struct with vectors; matrices whose columns are named."""
    if raw.startswith(b"MATLAB 7.3"):
        import_module("h5py")  # where it is missing this names it
    tree = import_module("pymatreader").read_mat(source)
    for name, level in _levels("top level", tree, 3):
        yield from _tables_of(name, level, source, raw, columns)


def _levels(name: str, level: Mapping[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
    own = {key: value for key, value in level.items() if not key.startswith(("__", "#"))}
    yield name, own
    for key, value in own.items():
        if isinstance(value, Mapping) and depth:
            inner = key if name == "top level" else f"{name}.{key}"
            yield from _levels(inner, value, depth - 1)


def _tables_of(
    name: str, level: Mapping[str, Any], source: str, raw: bytes, columns: Mapping[str, str]
) -> Iterator[Part]:
    vectors = {
        key: vector for key, value in level.items() if (vector := _vector(value)) is not None
    }
    matrices = {
        key: value
        for key, value in level.items()
        if isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "fiub"
    }
    names_of: dict[str, str] = {}
    for key, matrix in matrices.items():
        for other, names in vectors.items():
            if len(names) == matrix.shape[1] and all(isinstance(each, str) for each in names):
                names_of[key] = other
    for key, other in names_of.items():
        called = [str(each).strip() for each in vectors[other]]
        if len(set(called)) == len(called):
            by_name = dict(zip(called, np.asarray(level[key]).T, strict=True))
            inner = key if name == "top level" else f"{name}.{key}"
            yield _part_of_arrays(inner, source, raw, by_name, [""] * len(called))
    vectors = {key: value for key, value in vectors.items() if key not in names_of.values()}
    if vectors:
        kept, notes = _equally_long(vectors, level, columns)
        yield _part_of_arrays(name, source, raw, kept, [""] * len(kept), notes)
    elif matrices and not names_of:
        key, matrix = next(iter(matrices.items()))
        found = f"a matrix of {matrix.shape[1]} columns without names"
        remedy = (
            "save the names of its columns, in order, as a cell array in the same file "
            "(names = {'torque_Nm', ...}), or save a struct with a vector for each column"
        )
        raise wrong(source, key, found, "a name for each column", remedy)


def _vector(value: Any) -> NDArray[Any] | None:
    """A vector of numbers or of text with more than one entry; None for anything else."""
    if isinstance(value, list):
        if not all(isinstance(each, (str, int, float, np.number)) for each in value):
            return None
        array = np.empty(len(value), dtype=object)
        array[:] = value
    elif isinstance(value, np.ndarray):
        array = value.ravel() if value.ndim == 2 and 1 in value.shape else value
    else:
        return None
    return array if array.ndim == 1 and len(array) > 1 and array.dtype.kind in "fiubUO" else None


def _equally_long(
    vectors: Mapping[str, Any], level: Mapping[str, Any], columns: Mapping[str, str]
) -> tuple[dict[str, Any], list[str]]:
    """Vectors as long as the torque; those of another length only where they are readings."""
    telling = {
        key: bool(read_header(columns.get(key, key)).candidates) and columns.get(key) != "extra"
        for key in level
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
    single = [key for key in level if telling[key] and key not in vectors]
    if single:
        notes.append(f"{', '.join(single)}: not read, because it has no value for each reading")
    return kept, notes


# --- TDMS ---------------------------------------------------------------------------------


def _tdms(source: str, raw: bytes, columns: Mapping[str, str]) -> Iterator[Part]:
    """The groups; a channel's `unit_string` is its unit, waveforms bring their time along."""
    with import_module("nptdms").TdmsFile.open(io.BytesIO(raw)) as file:
        _stop_if_large(source, sum(len(c) for group in file.groups() for c in group.channels()))
        for group in file.groups():
            channels = {channel.name: channel for channel in group.channels()}
            notes = [
                f"channel {name!r} is empty and was not read"
                for name, channel in channels.items()
                if not len(channel)
            ]
            channels = {name: channel for name, channel in channels.items() if len(channel)}
            if not channels:
                continue
            units = [str(c.properties.get("unit_string", "")).strip() for c in channels.values()]
            values = {name: channel[:] for name, channel in channels.items()}
            time = _waveform_time(list(channels.values()))
            if time is not None and not any(
                (said := read_header(columns.get(name, name), unit)).quantity
                and said.quantity.key == "time"
                for name, unit in zip(values, units, strict=True)
            ):
                values, units = {"time_s": time} | values, ["", *units]
                step = channels[next(iter(channels))].properties["wf_increment"]
                notes.append(
                    f"time_s comes from the clock of the waveforms: {step:g} s between readings"
                )
            yield _part_of_arrays(group.name, source, raw, values, units, notes)


def _waveform_time(channels: Sequence[Any]) -> NDArray[np.float64] | None:
    """Seconds of channels that are waveforms of one clock; None where they are none."""
    clocks = {
        (float(c.properties["wf_start_offset"]), float(c.properties["wf_increment"]), len(c))
        for c in channels
        if "wf_increment" in c.properties and "wf_start_offset" in c.properties
    }
    if len(clocks) != 1:
        return None
    start, step, n = clocks.pop()
    if not (step > 0 and np.isfinite([start, step]).all()):
        return None
    return np.asarray(start + step * np.arange(n), dtype=np.float64)


# --- Parquet ------------------------------------------------------------------------------


def _parquet(source: str, raw: bytes, columns: Mapping[str, str]) -> Iterator[Part]:
    """The one table of the file; a field's metadata may state its `unit`."""
    pyarrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    file = parquet.ParquetFile(pyarrow.BufferReader(raw))
    _stop_if_large(source, file.metadata.num_rows * file.metadata.num_columns)
    table = read_columns(file.read())
    sha256 = hashlib.sha256(raw).hexdigest()
    yield Part(
        "the table",
        table.headers,
        table.units,
        lambda called: replace(table, source=called, sha256=sha256),
    )


_Reader = Callable[[str, bytes, Mapping[str, str]], Iterator[Part]]
# What the file is, what its parts are called, how it begins, and who reads it.
_FORMATS: tuple[tuple[str, str, tuple[bytes, ...], _Reader], ...] = (
    ("a workbook (or another zip archive)", "sheet", (b"PK\x03\x04",), _workbook),
    ("an old Excel workbook", "sheet", (b"\xd0\xcf\x11\xe0",), _workbook),
    ("a MATLAB file", "struct", (b"MATLAB 5", b"MATLAB 7.3"), _matlab),
    ("a TDMS file", "group", (b"TDSm",), _tdms),
    ("a Parquet file", "table", (b"PAR1",), _parquet),
)
