"""Files that would crash a reader or fill the memory: an error like any other, and work goes on.

Groups: each file by itself; what else may end the process that reads; where it can be started from.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.io import savemat
from starlette.testclient import TestClient

from cbpt.errors import ReadingsError
from cbpt.lab.readings import apart
from cbpt.lab.readings.apart import Limits, at_most, kept_in
from cbpt.lab.readings.reader import read_readings
from common.bombs import BOMBS
from common.page_server import HEAD, ROWS, opened
from common.tables import CAMPAIGNS, DATA, PLAIN, refused

HOSTILE = sorted(p for p in (DATA / "hostile").iterdir() if p.suffix != ".toml")
USUAL_S = Limits.SECONDS
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the memory is limited on Linux")


@pytest.fixture
def as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit on time as it is for people; the tests' own is patient."""
    monkeypatch.setattr(Limits, "SECONDS", USUAL_S)


def told_well(error: str, path: str) -> None:
    assert path in error
    assert "expected" in error and len(error) < 1000


# --- each file by itself ------------------------------------------------------------------


@LINUX
@pytest.mark.parametrize("path", HOSTILE, ids=lambda path: path.name)
def test_a_hostile_file_is_an_error(path: Path, as_usual: None) -> None:
    told_well(str(refused(path)), str(path))


@LINUX
@pytest.mark.parametrize("make", BOMBS.values(), ids=BOMBS.keys())
def test_a_bomb_is_an_error(tmp_path: Path, make: Callable[[], bytes], as_usual: None) -> None:
    (tmp_path / "bomb").write_bytes(make())
    told_well(str(refused(tmp_path / "bomb")), str(tmp_path / "bomb"))


@LINUX
def test_a_file_of_matlab_7_that_is_mostly_promise(tmp_path: Path, as_usual: None) -> None:
    """A gigabyte of zeros that lies nowhere in the file."""
    path = tmp_path / "t.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        made = file.create_dataset("x", shape=(1, 1 << 27), chunks=(1, 1 << 16), dtype="f8")
        made.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM")
    assert path.stat().st_size < 10_000
    assert "MB of memory" in str(refused(path))


def wide_mat(path: Path, names: list[str]) -> None:
    savemat(path, {name: np.arange(3.0) for name in names})


def wide_parquet(path: Path, names: list[str]) -> None:
    parquet.write_table(pa.table({name: [1.0, 2.0, 3.0] for name in names}), path)


@pytest.mark.parametrize("write", [wide_mat, wide_parquet])
def test_any_number_of_columns(tmp_path: Path, write: Callable[[Path, list[str]], None]) -> None:
    """The same limit as that of text: what each header means takes milliseconds to find out."""
    names = ["torque_Nm", "preload_N", "elastic_angle_arcsec"]
    write(tmp_path / "t", [*names, *(f"c{i}" for i in range(998))])
    error = str(refused(tmp_path / "t"))
    assert "found 1,001 columns, expected at most 1,000" in error
    told_well(error, str(tmp_path / "t"))


@LINUX
@pytest.mark.parametrize("path", HOSTILE, ids=lambda path: path.name)
def test_the_workbench_goes_on(client: TestClient, path: Path) -> None:
    _goes_on(client, path.read_bytes(), path.name)


@LINUX
@pytest.mark.long
@pytest.mark.parametrize(("name", "make"), BOMBS.items(), ids=BOMBS.keys())
def test_the_workbench_goes_on_after_a_bomb(
    client: TestClient, name: str, make: Callable[[], bytes], as_usual: None
) -> None:
    _goes_on(client, make(), f"bomb.{name.split(',')[0]}")


def _goes_on(client: TestClient, raw: bytes, name: str) -> None:
    found = opened(client, raw, name).json()
    assert not found["ready"]
    assert name in found["message"] and "/tmp" not in found["message"]
    assert opened(client, (HEAD + ROWS).encode()).json()["ready"]


# --- what else may end the process that reads ---------------------------------------------


@pytest.fixture
def child(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Read a workbook with another program in place of the one that reads; the error."""

    def read(program: str) -> str:
        (tmp_path / "child.py").write_text(program)
        monkeypatch.setattr(apart, "CHILD", tmp_path / "child.py")
        (tmp_path / "t.xlsx").write_bytes(b"PK\x03\x04")
        return str(refused(tmp_path / "t.xlsx"))

    return read


def test_a_crash_is_told(child: Callable[[str], str]) -> None:
    assert "the reader ended by itself" in child("import os, sys; os.kill(os.getpid(), 9)")
    assert "the reader ended by itself" in child("raise SystemExit(7)")
    assert "the reader ended by itself" in child("print('gibberish' * 9)")
    assert "the reader ended by itself" in child("")


def test_what_hangs_is_ended(child: Callable[[str], str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Limits, "SECONDS", 0.2)
    assert "is not read after" in child("import threading; threading.Event().wait()")


def test_a_python_that_cannot_be_started(
    child: Callable[[str], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    assert "a process of its own" in child("")
    monkeypatch.setattr(sys, "executable", "")
    assert "a process of its own" in child("")


def test_a_file_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "t.xlsx").write_bytes(BOMBS["xlsx"]())
    read: list[bytes] = []
    answer = apart._answer

    def counted(source: str, raw: bytes, kind: str, what: str) -> bytes:
        read.append(raw)
        return answer(source, raw, kind, what)

    monkeypatch.setattr(apart, "_answer", counted)
    import xlsxwriter

    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        sheet = book.add_worksheet()
        for row, line in enumerate(PLAIN.splitlines()):
            cells = line.split(",")
            sheet.write_row(row, 0, map(float, cells) if row else cells)
    with at_most(1000, 1 << 20, 1 << 29), kept_in({}):
        for _ in range(3):
            assert len(read_readings(tmp_path / "t.xlsx")) == 3
    assert len(read) == 1
    with at_most(5, 1 << 20, 1 << 29):
        assert "expected at most 5" in str(refused(tmp_path / "t.xlsx"))


# --- where it can be started from ---------------------------------------------------------


def test_a_script_without_a_guard_and_another_folder(tmp_path: Path) -> None:
    """Nothing of the script that reads is run again, and nothing beside it is imported."""
    (tmp_path / "json.py").write_text("raise SystemExit('not this one')")
    (tmp_path / "script.py").write_text(
        "print('once')\nimport sys\nimport cbpt\n"
        "try:\n    cbpt.read_readings(sys.argv[1])\nexcept cbpt.ReadingsError as error:\n"
        "    print(error)\n"
    )
    command = [sys.executable, "-P", "script.py", str(DATA / "hostile" / "segv.mat")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True)
    assert done.stdout.startswith("once\n")
    assert done.stdout.count("once") == 1
    assert "MATLAB file that cannot be read" in done.stdout
    assert not done.stderr


def test_text_is_read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", os.devnull)
    assert len(read_readings(CAMPAIGNS[0]))
    with pytest.raises(ReadingsError, match="process of its own"):
        read_readings(DATA / "hostile" / "segv.mat")
