"""Cases and tables that a browser hands over: bytes are read, names are only shown.

    Upload          one table: its name, its columns with what they are taken for, its readings
    Opened          a case and a table, as far as they are there
    read_case       a case from text
    shown_name      a file's name as it may be shown

A table lies under a name of our own in a directory of our own, so that no name can lead elsewhere;
messages tell the name it came with.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from cbpt._core import Case, Drive
from cbpt.errors import (
    CbptError,
    ChooseSheet,
    Mistake,
    ReadingsError,
    Setting,
    Step,
    TakeColumn,
    said,
    told,
)
from cbpt.lab.readings.apart import Contents, at_most, kept_in
from cbpt.lab.readings.files import read_file, sheets_of
from cbpt.lab.readings.headers import CONTRACT, read_header, units_of
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.text import Table
from cbpt.page.document.source import Command
from cbpt.page.workbench.scratch import Scratch

MOST_BYTES = 64 << 20
MOST_ROWS = 200_000
MOST_CASE_BYTES = 1 << 20
_MOST_CELLS = 5_000_000
_MOST_UNPACKED = 256 << 20
_MOST_MEMORY = 1 << 30
_LONGEST_LINE = 1 << 16
_LONGEST_NAME = 120
_SAMPLED_BYTES = 4 << 20
_SAMPLES = 3
_BINARY = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0", b"MATLAB 5", b"MATLAB 7.3", b"TDSm", b"PAR1")


def shown_name(name: str, otherwise: str) -> str:
    """The last part of a path, without signs that cannot be seen."""
    last = re.split(r"[/\\]", name)[-1]
    clean = "".join(sign for sign in last if sign.isprintable()).strip()
    return clean[:_LONGEST_NAME] or otherwise


def read_case(name: str, raw: bytes) -> tuple[Case, str]:
    """A case and its text. Raises `CaseError`."""
    from cbpt.errors import CaseError

    if len(raw) > MOST_CASE_BYTES:
        raise CaseError(f"{name}: {len(raw):,} bytes, expected a case file of at most a megabyte")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CaseError(f"{name}: byte {error.start + 1} is no UTF-8; save it as UTF-8") from None
    return Case.from_toml(text, name), text


@dataclass
class Upload:
    """A table on its way to readings."""

    name: str
    path: str
    columns: dict[str, str] = field(default_factory=dict)
    """What headers mean, where the user said so."""
    sheet: str | None = None
    only: dict[str, Sequence[str]] | None = None
    mine: Scratch | None = None
    contents: dict[str, Contents] = field(default_factory=dict, repr=False)
    """What is in a program's file, once it has been read."""

    @classmethod
    def of_bytes(cls, name: str, raw: bytes) -> Upload:
        """Raises `ReadingsError` for what is too large, or no table on the face of it."""
        _stop_if_large(name, raw)
        mine = Scratch()
        path = mine.path / "table"
        path.write_bytes(raw)
        return cls(name, os.fspath(path), mine=mine)

    def close(self) -> None:
        """Remove what was written."""
        if self.mine is not None:
            self.mine.close()

    @contextmanager
    def _within_limits(self) -> Iterator[None]:
        with at_most(_MOST_CELLS, _MOST_UNPACKED, _MOST_MEMORY), kept_in(self.contents):
            yield

    def describe(self) -> dict[str, Any]:
        """The columns with what each is taken for, and what is in doubt."""
        sheets: list[tuple[str, bool]] = []
        try:
            with self._within_limits():
                sheets = sheets_of(self.path, self.columns)
                table = read_file(self.path, self.sheet, self.columns)
                found = list(self._columns(table))
            problem = None
        except ReadingsError as error:
            found, problem = [], self.told(error)
        return {
            "name": self.name,
            "sheet": self.sheet,
            "sheets": [name for name, _ in sheets],
            "which_sheet": self.sheet is None and sum(fits for _, fits in sheets) > 1,
            "columns": found,
            "doubt": problem is not None or any(column["doubt"] for column in found),
            "problem": problem,
            "quantities": quantities(),
        }

    def _columns(self, table: Table) -> Any:
        units = table.units or ("",) * len(table.headers)
        samples: list[list[str]] = [[] for _ in table.headers]
        if os.path.getsize(self.path) <= _SAMPLED_BYTES:
            loaded = table.load(range(len(table.headers)))
            samples = [column.text[:_SAMPLES] for column in loaded.columns]
        for header, below, sample in zip(table.headers, units, samples, strict=True):
            stated = self.columns.get(header)
            said = read_header(header if stated in (None, "extra") else stated, below)
            quantity = None if stated == "extra" else said.quantity
            yield {
                "header": header,
                "unit_below": below,
                "column": quantity.column if quantity and not said.expected else None,
                "unit": said.unit.written if said.unit else None,
                "stated": stated,
                "doubt": bool(said.expected) and stated != "extra",
                "expected": said.expected,
                "hint": said.hint,
                "candidates": [each.column for each in said.candidates],
                "sample": sample,
            }

    def readings(self, case: Case) -> Readings:
        """Read with a case, which may fill in a preload or a lever arm. Raises `ReadingsError`."""
        try:
            with self._within_limits():
                _, found = case_and_readings(
                    case, self.path, self.columns or None, self.sheet, self.only
                )
        except ReadingsError as error:
            raise ReadingsError(
                error.path.replace(self.path, self.name), error.mistakes, error.place
            ) from None
        if len(found) > MOST_ROWS:
            raise _too_many_rows(self.name, len(found))
        stop_if_few(self.name, found)
        return replace(found, source=found.source.replace(self.path, self.name, 1))

    def told(self, error: CbptError) -> dict[str, Any]:
        """An error as the page shows it."""
        mistakes = error.mistakes if isinstance(error, ReadingsError) else ()
        return {
            "error": told(error, on_page).replace(self.path, self.name),
            "mistakes": [
                {
                    "lines": list(m.lines[:20]),
                    "column": m.column,
                    "value": m.value,
                    "expected": m.expected,
                    "remedy": said(m.remedy, on_page),
                }
                for m in mistakes[: ReadingsError.SHOWN]
            ],
        }


@dataclass(frozen=True)
class Opened:
    """A case and a table, as far as they are there, with the words of a command line for them."""

    case: Case | Drive | None = None
    case_name: str = ""
    case_text: str = ""
    case_words: str = ""
    upload: Upload | None = None
    data_words: str = ""
    flags: tuple[str, ...] = ()

    @property
    def command(self) -> Command:
        """The command lines on these files."""
        return Command(self.case_words, self.data_words, self.flags)

    def read(self) -> tuple[Readings | None, dict[str, Any]]:
        """The readings, where case and table are there; and what is missing or in doubt."""
        found: dict[str, Any] = {"ready": False, "message": "", "columns": [], "quantities": []}
        if self.upload is None:
            words = f"{self.case_name} is read. Add a table of readings."
            return None, found | {"message": words}
        found |= self.upload.describe()
        if self.case is None:
            words = f"{self.upload.name} is read. Add the case file (TOML)."
            return None, found | {"message": words}
        if found["which_sheet"]:
            words = f"{self.upload.name} has several sheets that may hold readings; choose one."
            return None, found | {"message": words, "doubt": True}
        case = self.case
        if isinstance(case, Drive):
            case = Case.from_toml(case.to_toml())
        try:
            readings = self.upload.readings(case)
        except ReadingsError as error:
            problem = self.upload.told(error)
            return None, found | {"problem": problem, "message": problem["error"], "doubt": True}
        return readings, found | {"ready": True, "message": "", "rows": len(readings)}


def on_page(step: Step) -> str:
    """What a message tells to do, as it is done on the page."""
    match step:
        case TakeColumn(header, column):
            return f"take {header!r} as {column!r}"
        case ChooseSheet(name):
            return f"choose the sheet {name!r}"
        case Setting(name):
            return f"the {name}"


def quantities() -> list[dict[str, Any]]:
    """What a column may be, and the units that it may be in."""
    needed = {"torque", "elastic_angle"}
    return [
        {
            "key": q.key,
            "column": q.column,
            "unit": q.unit,
            "units": units_of(q.kind) if q.kind else [],
            "needed": q.key in needed,
        }
        for q in CONTRACT
    ]


def _stop_if_large(name: str, raw: bytes) -> None:
    if len(raw) > MOST_BYTES:
        found, expected = f"{len(raw):,} bytes", f"at most {MOST_BYTES:,}"
        raise ReadingsError.of_column(name, "", found, expected, "take the rows that are needed")
    if raw.startswith(_BINARY):
        return
    if raw.count(b"\n") + raw.count(b"\r") // 2 > MOST_ROWS + 10_000:
        raise _too_many_rows(name, raw.count(b"\n"))
    longest = max(map(len, re.split(rb"[\r\n]", raw)), default=0)
    if longest > _LONGEST_LINE:
        mistake = Mistake((), "", f"a line of {longest:,} bytes", f"at most {_LONGEST_LINE:,}")
        raise ReadingsError(name, [mistake])


def stop_if_few(name: str, readings: Readings) -> None:
    """As a diagnosis refuses it: the zero alone follows a single reading exactly."""
    from cbpt.lab.diagnosis.diagnose import FEWEST

    if len(readings) < FEWEST:
        found, expected = f"{len(readings)} readings", f"at least {FEWEST}"
        remedy = "measure more torques and preloads: any model fits so few readings"
        raise ReadingsError.of_column(name, "elastic_angle", found, expected, remedy)


def _too_many_rows(name: str, rows: int) -> ReadingsError:
    expected = f"at most {MOST_ROWS:,}"
    remedy = "take a part of them; cbpt diagnose on the command line reads larger tables"
    return ReadingsError.of_column(name, "", f"{rows:,} rows", expected, remedy)
