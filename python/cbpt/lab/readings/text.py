"""A table as it was written, before anyone asks what its columns mean.

    Table       the headers, and on `load` each column as numbers
    read_bytes  what a file holds, or why it cannot be read
    read_text   a CSV-like file: encoding, separator, decimal mark, comments, row of units

Columns in memory are in `in_memory`, files of other programs in `files`. A million rows are
ordinary, so cells are turned into numbers a column of a block at a time, and one by one only where
that fails. What is no finite number is kept with its place (`Column.odd`): whether it is a mistake
depends on the column, and that is for the caller to say.
"""

from __future__ import annotations

import csv
import hashlib
import io
import itertools
import math
import re
from array import array
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import Mistake, ReadingsError
from cbpt.lab.readings.headers import LONGEST_HEADER, find_unit

__all__ = [
    "Column",
    "Loaded",
    "Table",
    "cells_of",
    "check_headers",
    "is_unit_row",
    "read_bytes",
    "read_text",
    "stop_if_wide",
    "wrong",
]

MOST_COLUMNS = 1000
_MOST_TITLE = 60  # lines in which the first row of numbers is looked for
_BLOCK = 50_000  # rows; large enough for numpy, small enough to keep the text of few cells alive


@dataclass(slots=True)
class Column:
    """One column, n rows: `numbers` (float64, NaN where `odd`) and what is no finite number.

    `odd` maps a row (0-based) to its cell as written; `text` has all n cells where it was asked
    for. `clock`: the cells are dates or durations, and the numbers seconds whatever the header
    says.
    """

    numbers: NDArray[np.float64]
    odd: dict[int, str]
    text: list[str] = field(default_factory=list)
    clock: bool = False


@dataclass(slots=True)
class Loaded:
    """The body of a table: its columns, the line of each row, and what is wrong with rows."""

    columns: list[Column]
    lines: NDArray[np.int64]
    mistakes: list[Mistake]


@dataclass(frozen=True, slots=True)
class Table:
    """Headers of a table; `load(text)` reads the body, with all cells of the columns in `text`.

    `units` is the row of units under the headers, or empty; `line` is that of the headers, 0
    for data in memory; `place` what a line is called.
    """

    source: str
    sha256: str
    headers: tuple[str, ...]
    units: tuple[str, ...]
    line: int
    place: str
    number: str  # what a number looks like here, for messages
    notes: tuple[str, ...]
    load: Callable[[Collection[int]], Loaded]


# --- text ---------------------------------------------------------------------------------

_FOREIGN = (
    (b"\x1f\x8b", "a gzip archive", "unpack it"),
    (b"%PDF", "a PDF document", "export the table to CSV"),
)
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_TEXT_TABLE = "a text table (CSV)"


def read_text(source: str, raw: bytes) -> Table:
    """The table in a text file that holds `raw`; raises ReadingsError if there is none in it."""
    for magic, name, remedy in _FOREIGN:
        if raw.startswith(magic):
            raise wrong(source, "", name, _TEXT_TABLE, remedy)
    text, notes = _decode(source, raw)
    lines = list(io.StringIO(text, newline=None))
    kept, numbers, comments = _significant(lines)
    separator = ""
    if kept and (stated := re.fullmatch(r"sep=([;,\t|])\s*", kept[0])):  # written by Excel
        separator = stated[1]
        del kept[0], numbers[0]
    if not kept:
        found = f"{len(comments)} comment lines and nothing else" if comments else "an empty file"
        raise wrong(source, "", found, "a line of headers and a row for each reading")
    title = _title(kept, separator)
    if title:
        notes += (f"lines above the headers were skipped{_at(numbers[:title])}",)
        kept, numbers = kept[title:], numbers[title:]
    separator = separator or _separator(kept)

    rows = csv.reader(kept, delimiter=separator, skipinitialspace=True, strict=True)
    body = 0
    try:
        header = next(rows)
        body = rows.line_num
        unit_row = next(rows, [])
    except csv.Error as error:
        line = numbers[body]
        raise wrong(
            source, "", str(error), "a closing quote after each opening one", line=line
        ) from None
    line = numbers[0]
    stop_if_wide(source, header, line)
    check_headers(source, header, line, lines)
    units: list[str] = []
    if is_unit_row(unit_row, header):
        units = unit_row + [""] * (len(header) - len(unit_row))
        body = rows.line_num
    between = [number for number in comments if number > line]
    if between:
        notes += (f"comment lines (#) after the headers were skipped{_at(between)}",)

    comma = separator in ";\t" and _decimal_comma(kept, body, separator)
    kept, numbers = kept[body:], numbers[body:]

    def load(as_text: Collection[int]) -> Loaded:
        return _load_text(kept, numbers, len(header), separator, comma, as_text)

    return Table(
        source,
        hashlib.sha256(raw).hexdigest(),
        tuple(cell.strip() for cell in header),
        tuple(cell.strip() for cell in units),
        line,
        "line",
        "a number with a decimal comma (as the rest of the file)" if comma else "a number",
        notes,
        load,
    )


def wrong(
    source: str, column: str, value: str, expected: str, remedy: str = "", line: int | None = None
) -> ReadingsError:
    lines = () if line is None else (line,)
    return ReadingsError(source, [Mistake(lines, column, value, expected, remedy)])


def stop_if_wide(source: str, headers: Sequence[str], line: int | None = None) -> None:
    """What a header means takes milliseconds to find out, so there may not be any number."""
    count = sum(map(bool, headers))
    if count > MOST_COLUMNS:
        found, expected = f"{count:,} columns", f"at most {MOST_COLUMNS:,}"
        raise wrong(source, "", found, expected, "keep only the columns that are needed", line)


def _at(lines: Sequence[int]) -> str:
    """Where, for a note: " (lines 3, 9, 12 ...)"."""
    return f" (line{'s' * (len(lines) > 1)} {', '.join(map(str, lines[:8]))}" + (
        " ...)" if len(lines) > 8 else ")"
    )


def read_bytes(source: str) -> bytes:
    """The bytes of a file; raises ReadingsError where it cannot be read."""
    try:
        if Path(source).is_dir():
            raise wrong(source, "", "a directory", "a file", "name the table inside it")
        return Path(source).read_bytes()
    except FileNotFoundError:
        raise wrong(source, "", "no such file", "a table of readings", "check the path") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        raise wrong(source, "", str(error), "a file that can be read") from None


def _decode(source: str, raw: bytes) -> tuple[str, tuple[str, ...]]:
    """The text of a file, and a note if its encoding was not certain."""
    encoding = "utf-8-sig"
    notes: tuple[str, ...] = ()
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        encoding = "utf-16"
    elif len(raw) > 3 and not any(raw[1:64:2]):  # UTF-16 without its mark: every other byte is 0
        encoding = "utf-16-le"
    elif len(raw) > 3 and not any(raw[0:64:2]):
        encoding = "utf-16-be"
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError:
        text, notes = raw.decode("latin-1"), ("the file is not UTF-8 text and was read as Latin-1",)
    if _CONTROL.search(text):
        raise wrong(source, "", "a binary file", _TEXT_TABLE, "export the table to CSV")
    return text.replace("\N{MINUS SIGN}", "-"), notes


def _significant(lines: list[str]) -> tuple[list[str], list[int], list[int]]:
    """Lines that hold something, their numbers (1-based), and the numbers of comment lines.

    A line of separators alone holds nothing: spreadsheets write them below a table.
    """
    kept, numbers, comments = [], [], []
    for number, line in enumerate(lines, 1):
        if not line[0].isalnum():  # most lines begin with a digit and need no closer look
            if not line.strip(' \t\r\n;,"'):
                continue
            if line.lstrip().startswith("#"):
                comments.append(number)
                continue
        kept.append(line)
        numbers.append(number)
    return kept, numbers, comments


def _separator(kept: list[str]) -> str:
    """The separator that splits header and first row alike, else the first one in the header."""
    inside = [mark for mark in ";\t," if mark in re.sub(r'"[^"]*"', "", kept[0])]
    for mark in inside:
        try:
            counts = {len(row) for row in csv.reader(kept[:2], delimiter=mark)}
        except csv.Error:
            continue
        if len(counts) == 1:
            return mark
    return inside[0] if inside else ","


def _title(kept: list[str], separator: str) -> int:
    """How many lines of text stand above the headers: of none as many cells as these and the first
    row of numbers have."""
    for mark in separator or ";\t,":
        try:
            rows = [next(csv.reader([line], delimiter=mark)) for line in kept[:_MOST_TITLE]]
        except (csv.Error, StopIteration):
            continue
        widths = [len(row) for row in rows]
        body = next((i for i, row in enumerate(rows) if _is_of_numbers(row)), 0)
        if body < 2:
            continue
        header = body - 2 if is_unit_row(rows[body - 1], rows[body]) else body - 1
        if widths[header] == widths[body] and widths[body] not in widths[:header]:
            return header
    return 0


def _is_of_numbers(cells: list[str]) -> bool:
    """Whether most of two cells or more are numbers."""
    filled = [cell for cell in cells if cell.strip()]
    return len(filled) > 1 and 2 * sum(map(_is_number, filled)) > len(filled)


def check_headers(source: str, header: list[str], line: int, lines: Sequence[str] = ()) -> None:
    """Raise if there are no headers, one of them twice, or one that is no name."""
    names = [cell.strip() for cell in header]
    at = (line,) if line else ()
    if any(names) and all(_is_number(name) for name in names if name):
        remedy = "add a line of headers such as run,time_s,torque_Nm,preload_N,..."
        above = [text.strip() for text in lines[: line - 1] if text.lstrip().startswith("#")]
        if line and above:
            remedy = f"remove the # if {above[-1]!r} is the line of headers, otherwise {remedy}"
        mistake = Mistake(at, names[0], repr(names[0]), "a line of headers", remedy)
        raise ReadingsError(source, [mistake])
    longest = max(names, key=len, default="")
    if len(longest) > LONGEST_HEADER:
        found, expected = f"a header of {len(longest):,} signs", f"at most {LONGEST_HEADER:,}"
        remedy = "write the name and the unit of the column alone"
        raise ReadingsError(source, [Mistake(at, longest[:40] + "...", found, expected, remedy)])
    mistakes = []
    for name in (name for name, count in Counter(names).items() if name and count > 1):
        places = " and ".join(str(i) for i, other in enumerate(names, 1) if other == name)
        found = f"the same header in columns {places}"
        remedy = "rename or remove one of them"
        mistakes.append(Mistake(at, name, found, "one column of each name", remedy))
    if mistakes:
        raise ReadingsError(source, mistakes)


def _is_number(cell: str) -> bool:
    """Whether a cell is a number with either decimal mark."""
    return _number(cell.replace(",", ".")) is not None


def is_unit_row(cells: list[str], header: list[str]) -> bool:
    """No cell is a number and one at least is a unit."""
    filled = [cell.strip().strip("[]()") for cell in cells if cell.strip()]
    return (
        len(cells) <= len(header)
        and any(find_unit(cell) for cell in filled)
        and not any(_is_number(cell) for cell in filled if cell != "1")
    )


def _decimal_comma(kept: list[str], body: int, separator: str) -> bool:
    """Whether any cell of the body is a number with a decimal comma."""
    cell = re.compile(
        rf'(?:^|{separator})[ "]*[+-]?(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?[ "\r\n]*(?={separator}|$)'
    )
    return any("," in line and cell.search(line) for line in itertools.islice(kept, body, None))


def _load_text(
    kept: list[str],
    numbers: list[int],
    width: int,
    separator: str,
    comma: bool,
    as_text: Collection[int],
) -> Loaded:
    """The body of a text table, a block of lines after the other."""
    blocks: list[list[Column]] = []
    lines = array("q")
    ragged: dict[int, list[int]] = {}
    mistakes: list[Mistake] = []
    at = 0
    while at < len(kept):
        start, here = len(lines), at
        block = _plain_columns(kept[at : at + _BLOCK], start, width, separator, comma, as_text)
        if block:
            at += len(block[0].numbers)
            lines.extend(numbers[here:at])
            blocks.append(block)
            continue
        rows: list[list[str]] = []
        rest = map(kept.__getitem__, range(at, len(kept)))
        reader = csv.reader(rest, delimiter=separator, skipinitialspace=True, strict=True)
        try:
            for row in itertools.islice(reader, _BLOCK):
                line = numbers[here]
                here = at + reader.line_num  # a quoted cell may run over several lines
                if len(row) > width and not any(cell.strip() for cell in row[width:]):
                    del row[width:]  # separators at the end of the line
                if len(row) == width:
                    rows.append(row)
                    lines.append(line)
                else:
                    ragged.setdefault(len(row), []).append(line)
        except csv.Error as error:
            mistakes.append(
                Mistake((numbers[here],), "", str(error), "a closing quote after each opening one")
            )
            break
        if rows:
            cells = enumerate(zip(*rows, strict=True))
            blocks.append([cells_of(column, start, comma, i in as_text) for i, column in cells])
        at = here
    for count, where in ragged.items():
        expected = f"{width}, one for each header"
        remedy = "put each cell that contains the separator in double quotes"
        if count < width:
            remedy = "complete the row or remove it"
        mistakes.append(Mistake(tuple(where), "", f"{count} cells", expected, remedy))
    if not blocks:
        blocks = [[Column(np.empty(0), {}) for _ in range(width)]]
    columns = [_join(parts) for parts in zip(*blocks, strict=True)]
    return Loaded(columns, np.asarray(lines, dtype=np.int64), mistakes)


def _plain_columns(
    lines: list[str], start: int, width: int, separator: str, comma: bool, as_text: Collection[int]
) -> list[Column]:
    """The columns of a block without quotes or gaps, several times faster; else nothing.

    A column is taken for numbers if its first cell is one.
    """
    if any('"' in line or line.count(separator) != width - 1 for line in lines):
        return []
    swapped = lines
    if comma:
        if any("." in line for line in lines):
            return []
        swapped = [line.replace(",", ".") for line in lines]
    first = swapped[0].split(separator)
    plain = [i for i in range(width) if i not in as_text and _number(first[i]) is not None]
    if not plain:
        return []
    try:
        block = np.loadtxt(swapped, delimiter=separator, comments=None, usecols=plain, ndmin=2)
    except ValueError:
        return []
    if not np.isfinite(block).all():
        return []
    columns = {i: Column(block[:, k], {}) for k, i in enumerate(plain)}
    for i in set(range(width)) - columns.keys():
        cells = [line.split(separator, i + 1)[i] for line in lines]
        columns[i] = cells_of(cells, start, comma, i in as_text)
    return [columns[i] for i in range(width)]


def _number(cell: str) -> float | None:
    """A cell as a float; None if it is no number. Python's 1_000 is none."""
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        return None


def cells_of(cells: Sequence[str], start: int, comma: bool, keep: bool) -> Column:
    """The cells of a block that begins at row `start`, one by one."""
    # Where commas are decimal a point is none, so that 1.234 is not taken for a thousandth of
    # what was meant.
    swap = str.maketrans(",.", ".,")
    ready = [cell.translate(swap) for cell in cells] if comma else cells
    values = [_number(cell) for cell in ready]
    numbers = np.array([math.nan if value is None else value for value in values])
    strange = ~np.isfinite(numbers)
    odd = {start + row: cells[row].strip() for row in np.flatnonzero(strange).tolist()}
    numbers[strange] = math.nan
    return Column(numbers, odd, [cell.strip() for cell in cells] if keep else [])


def _join(parts: Sequence[Column]) -> Column:
    """The blocks of one column, one after the other."""
    odd: dict[int, str] = {}
    for part in parts:
        odd |= part.odd
    text = list(itertools.chain.from_iterable(part.text for part in parts))
    return Column(np.concatenate([part.numbers for part in parts]), odd, text)
