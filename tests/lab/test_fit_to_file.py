"""`cbpt fit --out` writes the file that it has read, with the effects in it."""

from __future__ import annotations

from pathlib import Path

import pytest

import cbpt
from cbpt.cli import main as commands
from common.cases import check_same
from common.hidden import FOLDER


def test_comments_order_and_units_of_the_case_stay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (FOLDER / "dev03.toml").read_text(encoding="utf-8")
    mine = f"# drive 7, rig B\n{text}\n[measurement]  # as the rig was set\nzero = 'common'\n"
    case, out = tmp_path / "mine.toml", tmp_path / "fitted.toml"
    case.write_text(mine, encoding="utf-8")
    line = ["fit", str(case), str(FOLDER / "dev03.csv"), "--with", "eccentric_bearing"]
    assert commands.main([*line, "--out", str(out)]) == 0
    written = out.read_text(encoding="utf-8")
    assert written.startswith(mine)
    assert "reference_deflection_um = " in written.removeprefix(mine)
    found = cbpt.fit(case, FOLDER / "dev03.csv", "eccentric_bearing").case
    check_same(cbpt.Case.from_file(out), found)
