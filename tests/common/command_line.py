"""The `cbpt` command of the package on a campaign, for the tests of it."""

from __future__ import annotations

import subprocess
import sysconfig
from pathlib import Path
from typing import Any

import pytest

import cbpt
from cbpt import commands
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


def compare(*arguments: str | Path) -> int:
    """`cbpt compare` of a campaign, in this process."""
    return commands.main(["compare", str(CASE), str(DATA), *map(str, arguments)])
