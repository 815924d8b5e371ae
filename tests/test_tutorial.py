"""The data of docs/tutorial.md; what the page shows is run by tests/test_readme.py."""

from __future__ import annotations

from reference.make_tutorial import FOLDER, files


def test_the_files_of_the_tutorial_are_what_its_rig_gives() -> None:
    for name, text in files().items():
        assert (FOLDER / name).read_text(encoding="utf-8") == text, f"{name}: make it anew"
