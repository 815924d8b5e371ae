"""Text of a megabyte, however odd, takes a time that grows with its length.

No clock is read: what grows with the square of a megabyte takes hours, and only that meets the
patience of a test.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

import cbpt
from cbpt.lab.readings.headers import read_header, unit_at_end
from common import PATIENCE_S
from common.tables import HEAD, Write, refused

N = 1_000_000
HEADERS = {
    "blanks": " " * N,
    "blanks inside": "torque" + " " * N + "x",
    "blanks before a bracket": "torque " + " " * N + "[N",
    "brackets": "[" * N,
    "pairs of brackets": "()" * (N // 2),
    "words": "a " * (N // 2),
    "names": "torque " * (N // 7),
    "hyphens": "torque-" * (N // 7),
    "in": "torque" + " in" * (N // 3),
    "units": "torque " + "N " * (N // 2),
    "signs that unfold": "\ufdfa" * N,
}
ROW = "1,0,1,600,3,0.3\n"
TABLES = {
    "a header of blanks": " " * N + "x,torque_Nm\n1,2\n",
    "as many headers as may be": ",".join("a " * 480 + str(i) for i in range(999)) + "\n" + ROW,
    "headers that are nearly right": ",".join(f"torque_Nmm{i}" for i in range(999)) + "\n" + ROW,
    "separators": ";" * N + "\n" + ROW,
    "a cell of digits": "a;b\n1," + "1" * N + "x;2\n",
    "a cell of blanks": "a;b\n1,1" + " " * N + "x;2\n",
    "the same time": HEAD + ROW * (N // 16),
    "quotes": '"' * N,
    "quotes that end": '"a,' * (N // 3) + "\n" + ROW,
}


def ends(work: Callable[[], object]) -> bool:
    """Whether it comes to an end."""
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(PATIENCE_S)
    return not thread.is_alive()


@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS.keys())
def test_a_long_header(header: str) -> None:
    assert ends(lambda: (read_header(header), unit_at_end(header)))


def test_a_header_is_read_whatever_its_blanks() -> None:
    for header in ("torque" + " " * 5000 + "[N m]", "\n torque\t[N\xa0m]", "torque in N m"):
        found = read_header(header)
        assert found.quantity is not None and found.quantity.key == "torque"
        assert found.unit is not None and found.unit.symbol == "Nm"


@pytest.mark.parametrize("text", TABLES.values(), ids=TABLES.keys())
def test_a_long_table(write: Write, text: str) -> None:
    path = write(text)
    told: list[str] = []
    assert ends(lambda: told.append(str(refused(path))))
    assert len(told) == 1 and len(told[0]) < 20_000


def test_a_header_that_is_no_name_is_told(write: Write) -> None:
    error = str(refused(write(" " * 5000 + "x" * 2000 + ",b\n1,2\n")))
    assert "a header of 2,000 signs" in error


@pytest.mark.parametrize("part", [",", ",\n", "a = 1\n", "[", "= ", 'a = "'])
def test_a_long_case_keeps_nobody_waiting(part: str, tmp_path: Path) -> None:
    """In a process of its own: a thread in Rust cannot be left behind."""
    path = tmp_path / "case.toml"
    path.write_text(part * (N // len(part)))
    command = [sys.executable, "-m", "cbpt.cli.main", "check", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.returncode == 2
    # Twenty mistakes, each with its line and a caret, and how many there are.
    assert len(done.stderr.splitlines()) <= 3 * 20 + 1


def test_a_case_is_read_without_the_lock_of_python() -> None:
    """Another thread goes on while a text is read."""
    text = "a = 1\n" * 150_000
    begun = threading.Event()
    beats: list[int] = []

    def beat() -> None:
        begun.wait()
        beats.append(0)

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(PATIENCE_S)  # nobody gives the lock away but who means to
    try:
        begun.set()
        with pytest.raises(cbpt.CaseError):
            cbpt.Case.from_toml(text)
        there = bool(beats)
    finally:
        sys.setswitchinterval(interval)
        thread.join(PATIENCE_S)
    assert there
