"""`make demo`, the first command of the README: it runs to its end, and the error falls."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from common.comparisons import EXAMPLES


def test_the_demo_finds_an_effect_and_predicts_what_it_has_not_seen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runpy.run_path(str(EXAMPLES / "demo.py"))["main"](tmp_path)
    shown = capsys.readouterr().out
    told = re.search(r"kept back .*: ([\d.]+) arcsec before, ([\d.]+) arcsec with (\w+)", shown)
    assert told is not None, shown
    before, after = float(told[1]), float(told[2])
    # The stated uncertainty of a reading is 0.3 arcsec.
    assert after < 0.4 < before / 2
    assert told[3] in ("eccentric_bearing", "output_torsion")
    for name in ("diagnosis.svg", "damaged.svg", "campaign_with_effect.toml"):
        assert (tmp_path / name).stat().st_size > 0
    # Of what no library holds no cause is named.
    assert "in no library" in shown or "not in the library" in shown
