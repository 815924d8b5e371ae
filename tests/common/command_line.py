"""The `cbpt` command of the package on a campaign, for the tests of it."""

from __future__ import annotations

import signal
import subprocess
import sysconfig
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

import cbpt
from cbpt.cli import main as commands
from common import PATIENCE_S
from common.hidden import FOLDER

COMMAND = Path(sysconfig.get_path("scripts")) / "cbpt"
CASE, DATA = FOLDER / "dev03.toml", FOLDER / "dev03.csv"


def at_desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Works in a directory with the example as case.toml."""
    (tmp_path / "case.toml").write_text(cbpt.example_case(), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    """The installed command, in a process of its own."""
    command = [str(COMMAND), *map(str, arguments)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    return subprocess.run(command, text=True, encoding="utf-8", check=False, **pipes)


def interrupted(command: Sequence[str], works: Callable[[int], bool]) -> tuple[int, str]:
    """Exit code and standard error of a command that is met by Ctrl-C once it works, as may be
    seen of its process."""
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as running:
        try:
            while not works(running.pid):
                assert running.poll() is None, "it ended before"
                time.sleep(0.005)
            running.send_signal(signal.SIGINT)
            told = running.communicate(timeout=PATIENCE_S)[1]
        finally:
            running.kill()
    return running.returncode, told


def compare(*arguments: str | Path) -> int:
    """`cbpt compare` of a campaign, in this process."""
    return commands.main(["compare", str(CASE), str(DATA), *map(str, arguments)])
