"""Files that programs write tables of readings to, each made the same table as a CSV file.

    read_file   CSV, workbook (xlsx, xls, ods), MATLAB (.mat), TDMS or Parquet, told by its content
    sheets_of   the tables of a file that may hold several

The libraries come with `pip install "cbpt[io]"`. They run in a process of their own, with limits
(`apart`); `parts` says which tables are in what they find. Whatever goes wrong is told as a
ReadingsError that names the file.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

from cbpt.errors import ChooseSheet, Setting, Words
from cbpt.lab.readings.apart import contents_of
from cbpt.lab.readings.parts import PARTS, File, Part
from cbpt.lab.readings.text import Table, read_bytes, read_text, wrong

__all__ = ["read_file", "sheets_of"]

# How a file begins, what it is, what its tables are called, and its kind in `PARTS`.
_FORMATS: tuple[tuple[tuple[bytes, ...], str, str, str], ...] = (
    ((b"PK\x03\x04",), "a workbook (or another zip archive)", "sheet", "workbook"),
    ((b"\xd0\xcf\x11\xe0",), "an old Excel workbook", "sheet", "workbook"),
    ((b"MATLAB 5", b"MATLAB 7.3"), "a MATLAB file", "struct", "matlab"),
    ((b"TDSm",), "a TDMS file", "group", "tdms"),
    ((b"PAR1",), "a Parquet file", "table", "parquet"),
)


def read_file(path: str | os.PathLike[str], sheet: str | None, columns: Mapping[str, str]) -> Table:
    """The table of readings in a file, of several the one called `sheet` or the first that fits.

    columns: as in `read_readings`, to know which of several tables is meant.
    """
    source = os.fsdecode(path)
    raw = read_bytes(source)
    found = _parts(source, raw, columns)
    if found is not None:
        what, parts = found
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
    found = _parts(source, read_bytes(source), columns)
    return [] if found is None else [(p.name, p.has_readings(columns)) for p in found[1]]


def _parts(source: str, raw: bytes, columns: Mapping[str, str]) -> tuple[str, list[Part]] | None:
    """What the tables of a program's file are called, and these; None where it is no such file."""
    for magics, what, called, kind in _FORMATS:
        if raw.startswith(magics):
            sha256 = hashlib.sha256(raw).hexdigest()
            contents = contents_of(source, raw, sha256, kind, what)
            return called, list(PARTS[kind](File(source, sha256, contents, columns)))
    return None


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
