"""What a program's file holds, read in a process of its own: `apart` starts this file as a script.

Libraries that read binary files can be led to ask for any amount of memory or time, or to crash;
here that ends this process and no other. It sets its own limits, then reads the file on its
standard input, and writes to its standard output

    the numbers of all columns, one array after the other; what is in the file, as JSON, which says
    where each array lies; the length of the JSON, 8 bytes

Nothing of the package is imported: what the columns mean is for the other side to say.

    limit      the process may not have more memory, time or output
    FORMATS    for each kind of file, the libraries and what makes plain contents of it
    Output     columns on their way out
"""

from __future__ import annotations

import datetime
import errno
import io
import json
import os
import signal
import struct
import sys
import warnings
import zipfile
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

_LONGEST = 1000  # signs of what is no text
_DEPTH = 3  # structs within structs


@dataclass(frozen=True)
class Job:
    """What is asked for. path: where the file lies too, for a library that wants a path."""

    kind: str
    path: str
    most_cells: int
    most_bytes: int


class Refused(Exception):
    """What was found, what is expected, and what to do about it."""


def limit(memory: int, seconds: float) -> None:
    """More ends the process, or raises MemoryError. memory: bytes beyond those that it has;
    seconds: from now on.

    Linux keeps to all of it, other systems with `resource` to the time and the output; elsewhere
    the other side limits the time.
    """
    try:
        import resource
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (memory, memory))
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        with open("/proc/self/statm", "rb") as file:
            has = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (has + memory, has + memory))
    except (OSError, ValueError):
        return


# --- columns on their way out -------------------------------------------------------------


class Output:
    """Columns, written at once. Each is known by its number, and `columns` says where it lies."""

    def __init__(self) -> None:
        self.columns: list[dict[str, Any]] = []
        self.at = 0

    def put(self, **column: Any) -> int:
        """A column that is written; its number."""
        self.columns.append(column)
        return len(self.columns) - 1

    def array(self, dtype: str, data: bytes, n: int) -> list[Any]:
        """An array: its type, where it begins, how many."""
        begins, self.at = self.at, self.at + len(data)
        _write(data)
        return [dtype, begins, n]

    def whole(self, values: Sequence[int]) -> int:
        """A column of whole numbers."""
        return self.put(numbers=self._whole(values))

    def cells(self, values: list[Any]) -> int:
        """A column of anything: floats, and beside them the rows that hold something else.

        The list is used up.
        """
        rows = [row for row, value in enumerate(values) if type(value) is not float]
        seen: dict[Any, int] = {}
        said: list[Any] = []
        which = []
        for row in rows:
            value = values[row]
            values[row] = float("nan")
            key = (type(value), _key(value))
            if key not in seen:
                seen[key] = len(said)
                said.append(_said(value))
            which.append(seen[key])
        numbers = self.array("<f8", _bytes(array("d", values)), len(values))
        if not rows:
            return self.put(numbers=numbers)
        return self.put(numbers=numbers, odd=self._whole(rows), which=self._whole(which), said=said)

    def column(self, values: Any) -> int:
        """A column of numpy: numbers, dates and durations as they are, else as `cells`."""
        if values.dtype.kind in "mM":
            values = values.astype(values.dtype.newbyteorder("<"))
        elif values.dtype.kind in "fiub":
            values = values.astype("<f8")
        else:
            return self.cells(values.tolist())
        return self.put(numbers=self.array(values.dtype.str, values.tobytes(), len(values)))

    def _whole(self, values: Sequence[int]) -> list[Any]:
        return self.array("<i8", _bytes(array("q", values)), len(values))

    def end(self, contents: list[dict[str, Any]]) -> None:
        """Everything is there."""
        _end({"contents": contents, "columns": self.columns})

    @staticmethod
    def end_anew(found: Mapping[str, Any]) -> None:
        """In place of whatever has been written."""
        os.lseek(1, 0, os.SEEK_SET)
        os.ftruncate(1, 0)
        _end(found)


def _write(data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(1, view[: 1 << 30]) :]


def _end(found: Mapping[str, Any]) -> None:
    text = json.dumps(found).encode()
    _write(text + struct.pack("<q", len(text)))


def _bytes(values: array[Any]) -> bytes:
    if sys.byteorder == "big":
        values.byteswap()
    return values.tobytes()


def _key(value: Any) -> Any:
    try:
        hash(value)
    except TypeError:
        return id(value)
    return value


def _said(value: Any) -> Any:
    """A cell as JSON has it; dates and durations by the name of their type."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return value
    if isinstance(value, datetime.datetime):
        return {"datetime": value.isoformat()} if value == value else None  # NaT is not itself
    if isinstance(value, (datetime.date, datetime.time)):
        return {type(value).__name__: value.isoformat()}
    if isinstance(value, datetime.timedelta):
        return {"timedelta": [value.days, value.seconds, value.microseconds]}
    if isinstance(value, int) and abs(value) < 1 << 63:
        return value
    if isinstance(value, (bytes, bytearray)):
        return bytes(value).decode("utf-8", "replace")
    return str(value)[:_LONGEST]


# --- workbooks ----------------------------------------------------------------------------


def _workbook(job: Job, raw: bytes, out: Output) -> Iterator[dict[str, Any]]:
    """The sheets that hold anything: rows that are not empty, all columns of them."""
    if raw.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            unpacked = sum(each.file_size for each in archive.infolist())
        if unpacked > job.most_bytes:
            raise Refused(f"{unpacked:,} bytes when unpacked", f"at most {job.most_bytes:,}", "")
    book = import_module("python_calamine").CalamineWorkbook.from_filelike(io.BytesIO(raw))
    for name in book.sheet_names:
        sheet = book.get_sheet_by_name(name)
        _stop_if_many(job, sheet.total_height * sheet.total_width)
        cells = sheet.to_python(skip_empty_area=False)
        rows = [number for number, row in enumerate(cells) if not _is_empty(row)]
        if not rows:
            continue
        filled = [cells[number] for number in rows]
        del cells
        yield {
            "name": name,
            "rows": out.whole(rows),
            "columns": [out.cells(list(column)) for column in zip(*filled, strict=True)],
        }


def _is_empty(row: Sequence[Any]) -> bool:
    return all(isinstance(cell, str) and not cell.strip() for cell in row)


def _stop_if_many(job: Job, cells: int) -> None:
    if cells > job.most_cells:
        remedy = "keep only the rows and columns that are needed"
        raise Refused(f"{cells:,} cells", f"at most {job.most_cells:,}", remedy)


# --- MATLAB -------------------------------------------------------------------------------


def _matlab(job: Job, raw: bytes, out: Output) -> Iterator[dict[str, Any]]:
    """The top level and each struct: vectors, matrices of numbers, and the names of the rest."""
    if raw.startswith(b"MATLAB 7.3"):
        import_module("h5py")  # where it is missing this names it
    tree = import_module("pymatreader").read_mat(job.path)
    for name, level in _levels("top level", tree, _DEPTH):
        vectors, matrices = {}, {}
        for key, value in level.items():
            if _is_matrix(value):
                _stop_if_many(job, value.size)
                matrices[key] = [out.column(column) for column in value.T]
            if (vector := _vector(value)) is not None:
                vectors[key] = out.column(vector)
        yield {"name": name, "keys": list(level), "vectors": vectors, "matrices": matrices}


def _levels(name: str, level: Mapping[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
    own = {key: value for key, value in level.items() if not key.startswith(("__", "#"))}
    yield name, own
    for key, value in own.items():
        if isinstance(value, Mapping) and depth:
            inner = key if name == "top level" else f"{name}.{key}"
            yield from _levels(inner, value, depth - 1)


def _is_matrix(value: Any) -> bool:
    return getattr(value, "ndim", 0) == 2 and value.dtype.kind in "fiub"


def _vector(value: Any) -> Any:
    """A vector of numbers or of text with more than one entry; None for anything else."""
    import numpy as np

    if isinstance(value, list):
        if not all(isinstance(each, (str, int, float, np.number)) for each in value):
            return None
        vector = np.empty(len(value), dtype=object)
        vector[:] = value
    elif isinstance(value, np.ndarray):
        vector = value.ravel() if value.ndim == 2 and 1 in value.shape else value
    else:
        return None
    fits = vector.ndim == 1 and len(vector) > 1 and vector.dtype.kind in "fiubUO"
    return vector if fits else None


# --- TDMS ---------------------------------------------------------------------------------


def _tdms(job: Job, raw: bytes, out: Output) -> Iterator[dict[str, Any]]:
    """The groups: each channel with its `unit_string` and, of a waveform, start and step."""
    with import_module("nptdms").TdmsFile.open(io.BytesIO(raw)) as file:
        groups = file.groups()
        _stop_if_many(job, sum(len(c) for group in groups for c in group.channels()))
        for group in groups:
            yield {"name": group.name, "channels": [_channel(c, out) for c in group.channels()]}


def _channel(channel: Any, out: Output) -> dict[str, Any]:
    of = channel.properties
    found = {"name": channel.name, "unit": str(of.get("unit_string", "")).strip(), "wave": None}
    if "wf_increment" in of and "wf_start_offset" in of:
        found["wave"] = [float(of["wf_start_offset"]), float(of["wf_increment"])]
    return found | {"column": out.column(channel[:]) if len(channel) else None}


# --- Parquet ------------------------------------------------------------------------------


def _parquet(job: Job, raw: bytes, out: Output) -> Iterator[dict[str, Any]]:
    """The one table; a field's metadata may state its `unit`."""
    pyarrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    import numpy as np

    file = parquet.ParquetFile(pyarrow.BufferReader(raw))
    _stop_if_many(job, file.metadata.num_rows * file.metadata.num_columns)
    table = file.read(use_threads=False)
    names, units, columns = [], [], []
    for field, values in zip(table.schema, table.columns, strict=True):
        about = {
            key.decode("utf-8", "replace"): value.decode("utf-8", "replace")
            for key, value in (field.metadata or {}).items()
        }
        names.append(field.name)
        units.append(about.get("unit", about.get("units", "")).strip())
        columns.append(out.column(np.asarray(values)))
    yield {"name": "the table", "headers": names, "units": units, "columns": columns}


# --- the process --------------------------------------------------------------------------

_Reader = Callable[[Job, bytes, Output], Iterator[dict[str, Any]]]
# What reads a kind of file; what is imported before the limits hold.
FORMATS: dict[str, tuple[_Reader, tuple[str, ...]]] = {
    "workbook": (_workbook, ("python_calamine",)),
    "matlab": (_matlab, ("pymatreader", "h5py")),
    "tdms": (_tdms, ("nptdms",)),
    "parquet": (_parquet, ("numpy", "pyarrow.parquet")),
}


def main() -> None:
    asked = json.loads(sys.argv[1])
    sys.path[:] = asked["sys_path"]
    warnings.simplefilter("ignore")
    reader, libraries = FORMATS[asked["kind"]]
    job = Job(asked["kind"], asked["path"], asked["most_cells"], asked["most_bytes"])
    out = Output()
    raw = sys.stdin.buffer.read()
    try:
        for library in libraries:
            with suppress(ImportError):  # told where it is needed
                import_module(library)
        limit(asked["memory"], asked["seconds"])
        out.end(list(reader(job, raw, out)))
    except Refused as refused:
        out.end_anew({"refused": refused.args})
    except MemoryError:
        out.end_anew({"memory": True})
    except ImportError as error:
        out.end_anew({"missing": error.name or str(error)})
    except BaseException as error:  # a panic in a library of Rust is no Exception
        large = isinstance(error, OSError) and error.errno in (errno.EFBIG, errno.ENOMEM)
        why = (str(error).strip() or type(error).__name__).splitlines()[0][:200]
        out.end_anew({"memory": True} if large else {"failed": why})


if __name__ == "__main__":
    main()
    os._exit(0)  # nothing of a library's own end is waited for
