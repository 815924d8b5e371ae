"""The data of docs/tutorial.md; what the page shows is run by tests/docs/test_readme.py."""

from __future__ import annotations

import numpy as np

from reference.make_tutorial import CASE, FOLDER, HIDDEN, files, rows_of
from reference.rig import ARCSEC, drive_of, simulate


def test_the_files_of_the_tutorial_are_what_its_rig_gives() -> None:
    for name, text in files().items():
        assert (FOLDER / name).read_text(encoding="utf-8") == text, f"{name}: make it anew"


def test_the_angle_that_the_page_calls_true_is_the_rigs() -> None:
    drive_alone = [effect for effect in HIDDEN if effect.port != "instrument"]
    angle = simulate(drive_of(CASE), rows_of(1, [(1000, 0, [0, 15])]), drive_alone) / ARCSEC
    assert np.round(angle[-1], 1) == 63.0
    page = (FOLDER.parents[1] / "docs" / "tutorial.md").read_text(encoding="utf-8")
    assert "turns by 63.0 arcsec at 15 N m and 1000 N" in page
