"""What results show of themselves in a notebook: tables and pictures, all of it escaped."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

import cbpt
from common.hidden import FOLDER, diagnosed

ATTACK = "<script>alert(1)</script>"


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)


def tags(text: str) -> list[str]:
    parser = _Tags()
    parser.feed(text)
    return parser.tags


def test_an_answer_shows_its_sentence_its_tables_and_its_picture() -> None:
    d = diagnosed("dev09")
    shown = d._repr_html_()
    found = tags(shown)
    assert found[0] == "p" and {"table", "ul", "svg", "details"} <= set(found)
    assert found.count("li") == len(d.why())
    assert "friction" in shown and "script" not in found


def test_what_files_say_is_escaped() -> None:
    angle = np.array([0.0, 3.1, 6.2, 9.0, 6.1, 3.0, 0.1])
    data: dict[str, Any] = {
        "torque_Nm": [0.0, 1, 2, 3, 2, 1, 0],
        "preload_N": [600.0] * 7,
        "elastic_angle_arcsec": angle,
        "run": [ATTACK] * 7,
    }
    case = cbpt.Case.from_file(FOLDER / "dev04.toml")
    shown = cbpt.compare(case, data)._repr_html_()
    assert "table" in tags(shown) and "script" not in tags(shown)


@pytest.mark.parametrize("shape", [(3,), (2, 2)])
def test_loads_show_as_a_table(shape: tuple[int, ...]) -> None:
    drive = cbpt.Drive.from_toml(cbpt.example_case())
    shown = cbpt.solve_many(drive, np.ones(shape), 600.0)._repr_html_()
    assert tags(shown).count("tr") == 1 + np.prod(shape)
