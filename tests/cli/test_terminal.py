"""What a terminal shows: its width, colours, the line of a mistake with a caret."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

from common.command_line import CASE, DATA, at_desk, run

pty = pytest.importorskip("pty", reason="only Unix has pseudo-terminals")
CARET = "did you mean ball_radius_mm = 1.5?"
STYLE = re.compile(r"\x1b\[[\d;]*m")


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A directory of its own with the example as case.toml, and a slip in wrong.toml."""
    desk = at_desk(tmp_path, monkeypatch)
    text = (desk / "case.toml").read_text(encoding="utf-8")
    slip = text.replace("ball_radius_mm = 1.5", "ball_diameter_mm = 3", 1)
    (desk / "wrong.toml").write_text(slip, encoding="utf-8")
    return desk


def on_terminal(columns: int, *arguments: str, **more: str) -> str:
    """What `cbpt` writes to a terminal so wide."""
    import fcntl
    import struct
    import subprocess
    import termios

    mine, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "CLICOLOR")}
    started = subprocess.Popen(
        [sys.executable, "-m", "cbpt.cli.main", *arguments],
        stdout=theirs,
        stderr=theirs,
        stdin=subprocess.DEVNULL,
        env=environment | {"TERM": "xterm-256color"} | more,
    )
    os.close(theirs)
    found = b""
    while True:
        try:
            part = os.read(mine, 65536)
        except OSError:  # so Linux tells that the other end is closed
            break
        if not part:
            break
        found += part
    started.wait()
    os.close(mine)
    return found.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("verb", [["check", "wrong.toml"], ["compare", "wrong.toml", str(DATA)]])
def test_a_mistake_is_shown_in_its_line_by_the_verbs_of_rust_and_of_python(verb: list[str]) -> None:
    ran = run(*verb)
    assert ran.returncode == 2 and CARET in ran.stderr and "\x1b" not in ran.stderr
    line, caret = ran.stderr.splitlines()[-2:]
    assert line.index("ball_diameter_mm") == caret.index("^")
    shown = on_terminal(80, *verb)
    assert "\x1b[1;31m^" in shown and STYLE.sub("", shown) == ran.stderr
    assert on_terminal(80, *verb, NO_COLOR="1") == ran.stderr


@pytest.mark.parametrize("columns", [80, 100])
@pytest.mark.parametrize(
    "verb",
    [
        ["compare", str(CASE), str(DATA)],
        ["sweep", "case.toml", "--torque-Nm", "0:5:1"],
    ],
)
def test_tables_and_sentences_are_no_wider_than_the_terminal(verb: list[str], columns: int) -> None:
    shown = STYLE.sub("", on_terminal(columns, *verb))
    widest = max(shown.splitlines(), key=len)
    assert "┆" in shown and len(widest) <= columns, widest


def test_tables_in_a_file_have_a_hundred_columns() -> None:
    rows = [
        line for line in run("compare", str(CASE), str(DATA)).stdout.splitlines() if "┆" in line
    ]
    assert rows and max(map(len, rows)) <= 100


def test_a_sweep_that_writes_a_file_names_it(desk: Path) -> None:
    line = ["sweep", "case.toml", "--torque-Nm", "0:5:0.05"]
    assert "--out FILE.csv writes all" in run(*line).stdout
    told = run(*line, "--out", "x.csv").stdout
    assert "x.csv has all of them" in told and "--out" not in told
