"""The contents of a program's file, read in a process of its own with limits on memory and time.

    contents_of   what is in the file, its columns as arrays
    at_most       tighter limits, for files from somebody else
    kept_in       a file is read once, however often it is asked for

Files come from others, and the libraries that read them can be led to crash or to ask for any
amount of memory: `child` does the reading, and whatever ends it is an error here like any other.
The limits grow with the file, up to the most that a table may need, so that what unpacks to far
more than its size is refused early. The time is limited on every system. The memory is on Linux;
elsewhere only the count of cells and of unpacked bytes stands in its place.
"""

from __future__ import annotations

import datetime
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.errors import ReadingsError
from cbpt.lab.readings.text import wrong

__all__ = ["Contents", "at_most", "contents_of", "kept_in"]

CHILD = Path(__file__).with_name("child.py")
_MEGABYTE = 1 << 20


@dataclass(frozen=True)
class Limits:
    """What a file may take. memory: bytes, of which each byte of the file gives `PER_BYTE`."""

    cells: int = 50_000_000
    unpacked: int = 1 << 30
    memory: int = 4 << 30

    LEAST = 512 * _MEGABYTE
    PER_BYTE = 100
    # A small file is read in a tenth of this; a bomb is told within five seconds, of which two
    # processes that start on a busy machine take up to two.
    SECONDS = 2.0
    SECONDS_PER_MEGABYTE = 2.0

    def memory_for(self, size: int) -> int:
        """Bytes that a file of this size may take."""
        return min(self.LEAST + self.PER_BYTE * size, self.memory)

    def seconds_for(self, size: int) -> float:
        """Seconds that a file of this size may take, once the libraries are there."""
        return self.SECONDS + self.SECONDS_PER_MEGABYTE * size / _MEGABYTE


# More than any campaign has; a file that claims more is broken or meant to do harm.
_USUAL = Limits()
_LIMITS = ContextVar("limits", default=_USUAL)
_KEPT: ContextVar[dict[str, Contents] | None] = ContextVar("kept", default=None)
# Where the child has a clock of its own that begins once its libraries are there (POSIX), which
# on a busy machine may take several seconds, this one is for what goes on beyond.
_BEYOND = 4 if os.name == "posix" else 1
# Threads of a library would each reserve memory, and count their time to the limit.
_ALONE = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "1",
    "ARROW_DEFAULT_MEMORY_POOL": "system",
}


@contextmanager
def at_most(cells: int, unpacked_bytes: int, memory_bytes: int) -> Iterator[None]:
    """Files that take more are refused, here and now."""
    before = _LIMITS.set(Limits(cells, unpacked_bytes, memory_bytes))
    try:
        yield
    finally:
        _LIMITS.reset(before)


@contextmanager
def kept_in(kept: dict[str, Contents]) -> Iterator[None]:
    """Contents that are read here are kept in a dict, and taken from there."""
    before = _KEPT.set(kept)
    try:
        yield
    finally:
        _KEPT.reset(before)


@dataclass(frozen=True)
class Contents:
    """What `child` has found in a file. parts: in its words; columns: by the numbers in them."""

    parts: list[dict[str, Any]]
    columns: list[NDArray[Any]]


def contents_of(source: str, raw: bytes, sha256: str, kind: str, what: str) -> Contents:
    """The contents of a file. kind: one of `child.FORMATS`; what: the same for people.

    Raises `ReadingsError` where it cannot be read within the limits.
    """
    kept = _KEPT.get()
    if kept is not None and sha256 in kept:
        return kept[sha256]
    answer = _answer(source, raw, kind, what)
    try:
        length = int.from_bytes(answer[-8:], "little")
        found = json.loads(answer[len(answer) - 8 - length : -8])
        _stop_if_refused(source, what, len(raw), found)
        columns = [_column(answer, column) for column in found["columns"]]
    except ReadingsError:
        raise
    except (ValueError, LookupError, TypeError) as error:  # of a child that has come to harm
        raise _ended(source, what, len(raw), 0, repr(error).encode()) from None
    contents = Contents(found["contents"], columns)
    if kept is not None:
        kept[sha256] = contents
    return contents


def _answer(source: str, raw: bytes, kind: str, what: str) -> bytes:
    """What the child has written."""
    limits = _LIMITS.get()
    seconds = limits.seconds_for(len(raw))
    job = {
        "kind": kind,
        "path": os.path.abspath(source),
        "most_cells": limits.cells,
        "most_bytes": limits.unpacked,
        "memory": limits.memory_for(len(raw)),
        "seconds": seconds,
        "sys_path": [os.path.abspath(folder) for folder in sys.path],
    }
    if not sys.executable:
        expected = "a Python that can be started, to read the file in a process of its own"
        raise wrong(source, "", what, expected, "export the table to CSV")
    command = [sys.executable, "-I", str(CHILD), json.dumps(job)]
    try:
        with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as made:
            given.write(raw)
            given.seek(0)
            with tempfile.TemporaryFile() as said:
                child = subprocess.Popen(
                    command, stdin=given, stdout=made, stderr=said, env=os.environ | _ALONE
                )
                try:
                    code = child.wait(seconds * _BEYOND)
                except subprocess.TimeoutExpired:
                    raise _too_long(source, what, seconds) from None
                finally:
                    child.kill()
                    child.wait()
                said.seek(0)
                complaint = said.read(10_000)
            made.seek(0)
            answer = made.read()
    except OSError as error:
        expected = "a process of its own to read the file in"
        raise wrong(
            source, "", f"{what}, but {error}", expected, "export the table to CSV"
        ) from None
    if code or len(answer) < 8:
        raise _ended(source, what, len(raw), code, complaint)
    return answer


def _too_long(source: str, what: str, seconds: float) -> ReadingsError:
    found = f"{what} that is not read after {seconds:.0f} s"
    expected = "a table of a usual size for a file of this length"
    remedy = "keep only the rows and columns that are needed, or export the table to CSV"
    return wrong(source, "", found, expected, remedy)


def _too_large(source: str, what: str, size: int) -> ReadingsError:
    limits = _LIMITS.get()
    megabytes = limits.memory_for(size) // _MEGABYTE
    found = f"{what} that takes more than {megabytes:,} MB of memory to read"
    expected = f"a table of at most {limits.cells:,} cells, and of a usual size for its length"
    remedy = (
        "keep only the rows and columns that are needed (one cell far out makes all cells up to it "
        "a part of the table), or export the table to CSV"
    )
    return wrong(source, "", found, expected, remedy)


def _ended(source: str, what: str, size: int, code: int, complaint: bytes) -> ReadingsError:
    """The child has not lived to tell: by the limits, or by a fault of a library."""
    if any(words in complaint for words in (b"memory allocation of", b"bad_alloc", b"MemoryError")):
        return _too_large(source, what, size)
    try:
        from signal import Signals

        name = Signals(-code).name if code < 0 else f"code {code}"
    except ValueError:
        name = f"signal {-code}"
    if name == "SIGALRM":
        return _too_long(source, what, _LIMITS.get().seconds_for(size))
    found = f"{what} that cannot be read: the reader ended by itself on this file ({name})"
    remedy = "save it again, or export the table to CSV"
    return wrong(source, "", found, "a complete file", remedy)


def _stop_if_refused(source: str, what: str, size: int, found: Mapping[str, Any]) -> None:
    if "refused" in found:
        raise wrong(source, "", *found["refused"])
    if "memory" in found:
        raise _too_large(source, what, size)
    if "missing" in found:
        expected = f"the library that reads it ({found['missing']})"
        remedy = 'pip install "cbpt[io]", or export the table to CSV'
        raise wrong(source, "", what, expected, remedy)
    if "failed" in found:
        remedy = "save it again, or export the table to CSV"
        told = f"{what} that cannot be read ({found['failed']})"
        raise wrong(source, "", told, "a complete file", remedy)


# --- columns on their way in --------------------------------------------------------------


def _column(answer: bytes, told: Mapping[str, Any]) -> NDArray[Any]:
    """Numbers, dates or durations as such; else objects, a float where there is no other cell."""
    numbers = _array(answer, *told["numbers"])
    if "odd" not in told:
        return numbers
    said = np.empty(len(told["said"]), dtype=object)
    said[:] = [_cell(each) for each in told["said"]]
    column = numbers.astype(object)
    column[_array(answer, *told["odd"])] = said[_array(answer, *told["which"])]
    return column


def _array(answer: bytes, dtype: str, begins: int, n: int) -> NDArray[Any]:
    if n == 0:  # of which numpy knows no buffer
        return np.empty(0, dtype)
    return np.frombuffer(answer, np.dtype(dtype), n, begins)


def _cell(said: Any) -> Any:
    if not isinstance(said, Mapping):
        return said
    ((name, value),) = said.items()
    if name == "timedelta":
        return datetime.timedelta(*value)
    return getattr(datetime, name).fromisoformat(value)
