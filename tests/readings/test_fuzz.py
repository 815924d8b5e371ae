"""Files of strangers: whatever a reader is given, there is a table or one of the package's errors.

Seeds are tests/data/corpus and the hostile files; each input is a seed with some edits. An
ordinary run tries a few inputs, the same every time. `make fuzz` sets FUZZ_SECONDS, for which each
reader goes on with others; an input that fails is kept beside the seeds, so that it stays a test
once the cause is mended. Case files, plans of sweeps, formulas and names of units are tried in
crates/cbpt-cli/tests/fuzz.rs.
"""

from __future__ import annotations

import hashlib
import os
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pytest
import xlsxwriter
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyarrow import parquet
from scipy.io import savemat

import cbpt
from cbpt.design.bounds import read_bounds
from cbpt.errors import CbptError, PlanError, ReadingsError
from cbpt.lab.experiment.plan import read_plan
from cbpt.lab.readings.reader import read_readings
from common.tables import DATA

CORPUS = DATA / "corpus"
EXAMPLES = Path(__file__).parents[2] / "examples"
CASE = cbpt.Case.from_file(EXAMPLES / "base_case.toml")
SECONDS = int(os.environ.get("FUZZ_SECONDS", "0"))
TOKENS = [
    *(
        sign.encode()
        for sign in (*",;\t\n\"'#[]{}=.-_\0µ°²″", "\r\n", "\ufeff", " " * 300, "sep=;\n")
    ),
    *(
        b"1e999",
        b"nan",
        b"inf",
        b"9" * 400,
        b"0x",
        b"1979-05-27",
        b"12:30",
        b"1.234,5",
        b"\xff\xfe",
    ),
    *(b"torque_Nm", b"elastic_angle_arcsec", b"preload_N", b"u_", b"[N m]", b"(deg)", b"[[run]]\n"),
]
LARGEST = 1 << 16

Edit = Callable[[bytes], bytes]


def edits(seeds: list[bytes]) -> st.SearchStrategy[Edit]:
    """One change of some bytes: a flip, a cut, a repeat, a token or a piece of another seed."""
    at, size = st.floats(0, 1), st.integers(0, 60)

    def cut(place: float, length: int, times: int, piece: bytes, flip: int) -> Edit:
        def change(raw: bytes) -> bytes:
            start = round(place * len(raw))
            held = raw[start : start + length]
            if flip and held:
                return raw[:start] + bytes([held[0] ^ flip]) + raw[start + 1 :]
            return (raw[:start] + held * times + piece + raw[start + length :])[:LARGEST]

        return change

    pieces = st.one_of(st.just(b""), st.sampled_from(TOKENS), st.sampled_from(seeds))
    piece = st.builds(lambda p, a, n: p[round(a * len(p)) :][:n] or p[:n], pieces, at, size)
    times = st.sampled_from([0, 0, 1, 1, 2, 300])
    return st.builds(cut, at, size, times, piece, st.sampled_from([0, 0, 0, 1, 8, 128, 255]))


def inputs(seeds: list[bytes]) -> st.SearchStrategy[bytes]:
    def edited(seed: bytes, changes: list[Edit]) -> bytes:
        for change in changes:
            seed = change(seed)
        return seed

    return st.builds(edited, st.sampled_from(seeds), st.lists(edits(seeds), max_size=6))


def kept(name: str) -> list[bytes]:
    return [path.read_bytes() for path in sorted((CORPUS / name).iterdir())]


def binaries(folder: Path) -> list[bytes]:
    """A small table in each binary format, and the hostile files."""
    table = {"torque_Nm": [1.0, 2.0], "preload_N": [600.0] * 2, "input_angle_deg": [0.0] * 2}
    table["elastic_angle_arcsec"] = [2.5, 5.0]
    with xlsxwriter.Workbook(folder / "a.xlsx") as book:
        sheet = book.add_worksheet()
        for column, (header, values) in enumerate(table.items()):
            sheet.write_column(0, column, [header, *values])
    savemat(folder / "a.mat", {name: np.array(values) for name, values in table.items()})
    parquet.write_table(pa.table(table), folder / "a.parquet")
    with h5py.File(folder / "b.mat", "w", userblock_size=512) as file:
        for name, values in table.items():
            file[name] = values
    raw = [path.read_bytes() for path in sorted(folder.iterdir())]
    hostile = (path for path in sorted((DATA / "hostile").iterdir()) if path.suffix != ".toml")
    return raw + [path.read_bytes() for path in hostile]


def tried(
    name: str, seeds: list[bytes], read: Callable[[Path], object], path: Path, examples: int
) -> int:
    """Reads seeds and edits of them; how many. What raises another error than CBPT's is kept."""
    count = 0

    def check(raw: bytes) -> None:
        nonlocal count
        count += 1
        path.write_bytes(raw)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                read(path)
        except CbptError as error:
            assert isinstance(error, ReadingsError | PlanError) or str(error)
            assert len(str(error)) < 20_000

    for seed in seeds:
        check(seed)
    last = b""

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=not SECONDS,
        suppress_health_check=list(HealthCheck),
    )
    @given(raw=inputs(seeds))
    def some(raw: bytes) -> None:
        nonlocal last
        last = raw
        check(raw)

    began = time.monotonic()
    while True:
        try:
            some()
        except BaseException:
            if SECONDS and (CORPUS / name).is_dir():  # hypothesis has ended with the smallest
                found = CORPUS / name / f"found-{hashlib.sha256(last).hexdigest()[:8]}"
                found.write_bytes(last)
            raise
        if time.monotonic() - began >= SECONDS:
            return count


READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "readings": ("table.csv", lambda path: read_readings(path, need_preload=False)),
    "campaign": ("plan.toml", lambda path: read_plan(path, CASE)),
    "bounds": ("bounds.toml", lambda path: read_bounds(path, CASE)),
}


@pytest.mark.parametrize("name", READERS)
def test_text_of_strangers(name: str, tmp_path: Path) -> None:
    file, read = READERS[name]
    count = tried(name, kept(name), read, tmp_path / file, 500 if SECONDS else 150)
    print(f"{name}: {count} inputs")


def test_binary_files_of_strangers(tmp_path: Path) -> None:
    """Each in a process of its own, so there are few of them."""
    made = tmp_path / "seeds"
    made.mkdir()
    count = tried("binary", binaries(made), read_readings, tmp_path / "table", 12)
    print(f"binary: {count} inputs")
