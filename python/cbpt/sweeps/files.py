"""Files of sweeps, written chunk by chunk; an interrupted sweep continues where it stopped.

CSV is the core's (`SweepCsv`: one file and a record beside it). A Parquet file cannot be appended
to, so its chunks are files of their own in a folder beside it until all are there; then they are
put together, and the finished file holds the record of its plan; its SHA-256 stands beside it.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cbpt._core import SweepCsv, SweepPlan, sweep_findings, sweep_statuses
from cbpt.errors import PlanError
from cbpt.sweeps.result import Rows
from cbpt.whole_files import write_whole

__all__ = ["Output", "open_output"]


_PLAIN = ("residual", "efficiency", "static_safety")
"""Columns without a unit."""


class Output(Protocol):
    """A file that grows."""

    form: str
    """What it takes of each chunk: `csv` or `rows`."""

    unchecked: str
    """Why what is there was not held against the sum of what was written; empty where it was."""

    @property
    def done(self) -> int:
        """Rows that are on disk."""

    def append(self, chunk: Any, rows: int) -> None:
        """Adds the next rows, and returns when they are on disk."""

    def finish(self) -> None:
        """Makes the file whole; all rows are there."""

    def close(self) -> None:
        """Lets others write it."""


def open_output(plan: SweepPlan, path: Path, fresh: bool) -> Output:
    """Open the output of a plan where it stands, or begin it.

    Raises `PlanError` for an output of another plan, a file that the plan was read from or a name
    with another ending, and `OSError` where it cannot be written.
    """
    path = Path(os.path.realpath(path))  # beside it, too, stands what a link leads to
    plan.check_output(path)
    ending = path.suffix.lower()
    if ending == ".csv":
        return _Csv(plan, path, fresh)
    if ending == ".parquet":
        return _Parquet(plan, path, fresh)
    raise PlanError(f"{path}: the name must end in .csv or .parquet")


class _Csv:
    form = "csv"
    unchecked = ""

    def __init__(self, plan: SweepPlan, path: Path, fresh: bool) -> None:
        self.file = SweepCsv(plan, path, fresh)

    @property
    def done(self) -> int:
        return self.file.done

    def append(self, chunk: bytes, rows: int) -> None:
        self.file.append(chunk, rows)

    def finish(self) -> None:
        """Every chunk was at its place."""

    def close(self) -> None:
        del self.file


class _Parquet:
    """Parts `000000000000.parquet`, named by their first row, in `.NAME.sweep` beside the file."""

    form = "rows"

    def __init__(self, plan: SweepPlan, path: Path, fresh: bool) -> None:
        try:
            from pyarrow import parquet
        except ImportError:
            remedy = 'pip install "cbpt[io]", or write to a .csv file'
            raise PlanError(f"{path}: Parquet needs pyarrow: {remedy}") from None
        self.parquet = parquet
        self.plan, self.path = plan, path
        self.folder = path.with_name(f".{path.name}.sweep")
        self.sum = path.with_name(f"{path.name}.sweep")
        self.unchecked = ""
        self.lock: Any = None
        self.done = 0
        if path.exists() and not fresh:
            self._check(path, self._record_of(path))
            self._whole(path)
            self.unchecked = self._unchanged()
            self.done = plan.rows
            return
        self.folder.mkdir(exist_ok=True)
        self._lock()
        try:
            self._take_up(fresh)
        except BaseException:
            self.close()
            raise

    def _take_up(self, fresh: bool) -> None:
        """Counts the rows of parts that are there; behind the lock, so that nobody adds to them."""
        self.sum.unlink(missing_ok=True)  # of a file that is gone, or will be
        record = self.folder / "plan.json"
        if fresh:
            self.path.unlink(missing_ok=True)
            for old in [*self._parts(), *self.folder.glob("*.new"), record]:
                old.unlink(missing_ok=True)
        there = record.exists()
        if there:
            self._check(record, record.read_text(encoding="utf-8"))
        parts = self._parts()
        for part in parts:  # before one of them goes: they may be of another plan
            self._check(part, self._record_of(part))
        if not there:
            write_whole(record, self.plan.record.encode())
        for part in parts:
            if int(part.stem) != self.done:
                part.unlink()
            else:
                self.done += self.parquet.read_metadata(part).num_rows

    def _record_of(self, path: Path) -> str:
        from pyarrow import ArrowInvalid

        try:
            found = (self.parquet.read_schema(path).metadata or {}).get(b"cbpt_sweep")
        except ArrowInvalid:
            found = None
        if found is None:
            raise PlanError(
                f"{path}: the file exists but is not a sweep; give another --out, or --fresh to "
                "replace the file"
            )
        return str(found.decode())

    def _check(self, path: Path, record: str) -> None:
        self.plan.check_record(path, record)

    def _whole(self, path: Path) -> None:
        rows = self.parquet.read_metadata(path).num_rows
        if rows != self.plan.rows:
            raise PlanError(
                f"{path}: the file has {rows} rows, the plan {self.plan.rows}, so the file was "
                "changed after the sweep wrote it; give another --out, or --fresh to start again"
            )

    def _unchanged(self) -> str:
        """Refuses a file that is not the one that was written; says so where no sum can tell."""
        if not self.sum.exists():
            return f"contents not checked, because {self.sum.name} is missing"
        try:
            known = json.loads(self.sum.read_bytes())["sha256"]
        except (ValueError, KeyError, TypeError):
            raise PlanError(
                f"{self.sum}: this is no checksum of a sweep, so {self.path} cannot be checked; "
                "delete the checksum to continue the sweep without the check, or give --fresh to "
                "overwrite both files"
            ) from None
        if _sha256(self.path) != known:
            raise PlanError(
                f"{self.path}: its contents differ from its record {self.sum.name}, so it was "
                "changed after the sweep wrote it; give another --out, or --fresh to start again"
            )
        return ""

    def _lock(self) -> None:
        try:
            import fcntl
        except ImportError:  # where there are no such locks
            return
        self.lock = (self.folder / "lock").open("w")
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise PlanError(
                f"{self.path}: another process is writing this file; wait for it, or give "
                "another --out"
            ) from None

    def _parts(self) -> list[Path]:
        return sorted(self.folder.glob("*.parquet"))

    def append(self, chunk: Rows, rows: int) -> None:
        part = self.folder / f"{self.done:012}.parquet"
        new = part.with_suffix(".new")
        self.parquet.write_table(self._table(chunk), new)
        _to_disk(new)
        new.replace(part)
        self.done += rows

    def _table(self, rows: Rows) -> Any:
        import pyarrow

        columns, fields = [], []

        def add(name: str, column: Any, unit: str | None) -> None:
            columns.append(column)
            metadata = {"unit": unit} if unit else None
            fields.append(pyarrow.field(name, column.type, metadata=metadata))

        plan = self.plan
        for name, unit, words, values in zip(
            plan.names, plan.units, plan.words, rows.axes, strict=True
        ):
            column = _words(values, words) if words else _numbers(values)
            add(name, column, unit)
        for name, values in rows.found.items():
            add(name, _numbers(values), _unit(name))
        if plan.has_findings:
            add("finding", _words(rows.finding, sweep_findings()), None)
        add("status", _words(rows.status, sweep_statuses()), None)
        schema = pyarrow.schema(fields, metadata={"cbpt_sweep": plan.record})
        return pyarrow.Table.from_arrays(columns, schema=schema)

    def finish(self) -> None:
        parts = self._parts()
        if not parts:  # finished by an earlier run
            return
        new = self.folder / "whole.new"
        schema = self.parquet.read_schema(parts[0])
        with self.parquet.ParquetWriter(new, schema) as writer:
            for part in parts:
                with self.parquet.ParquetFile(part) as read:
                    writer.write_table(read.read())
        self._whole(new)
        _to_disk(new)
        written = json.dumps({"sha256": _sha256(new)})
        new.replace(self.path)
        write_whole(self.sum, f"{written}\n".encode())
        self.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def close(self) -> None:
        if self.lock is not None:
            self.lock.close()
            self.lock = None


def _unit(column: str) -> str:
    """The unit that the name of a column ends in; nothing of a plain number."""
    if column in _PLAIN:
        return ""
    return "Nm_per_turn" if column.endswith("_per_turn") else column.rsplit("_", 1)[-1]


def _numbers(values: NDArray[np.float64]) -> Any:
    """A column with nothing where there is no number.

    `pyarrow.array` would do the same and load pandas for it, which takes a second.
    """
    import pyarrow

    there = np.packbits(~np.isnan(values), bitorder="little")
    buffers = [pyarrow.py_buffer(there), pyarrow.py_buffer(np.ascontiguousarray(values))]
    return pyarrow.Array.from_buffers(pyarrow.float64(), len(values), buffers)


def _words(codes: NDArray[Any], words: list[str]) -> Any:
    """A column of words, without pandas too; nothing in place of an empty one."""
    import pyarrow

    empty = [place for place, word in enumerate(words) if not word]
    there = np.packbits(~np.isin(codes, empty), bitorder="little") if empty else None
    places = [
        None if there is None else pyarrow.py_buffer(there),
        pyarrow.py_buffer(codes.astype(np.int32)),
    ]
    indices = pyarrow.Array.from_buffers(pyarrow.int32(), len(codes), places)
    ends = np.cumsum([0, *(len(word.encode()) for word in words)], dtype=np.int32)
    letters = pyarrow.py_buffer("".join(words).encode())
    known = pyarrow.StringArray.from_buffers(len(words), pyarrow.py_buffer(ends), letters)
    return pyarrow.DictionaryArray.from_arrays(indices, known)


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _to_disk(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())
