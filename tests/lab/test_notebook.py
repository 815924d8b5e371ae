"""What results show of themselves in a notebook: tables and pictures, all of it escaped."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.wording import layout
from cbpt.lab.wording.html import Reported
from cbpt.sketch import Series, against, sketch
from common.hidden import FOLDER, diagnosed
from common.html import tags

ATTACK = "<script>alert(1)</script>"


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


def test_a_solution_shows_its_load_and_its_pairs() -> None:
    drive = cbpt.Drive.from_toml(cbpt.example_case())
    shown = drive.solve(5, 600)._repr_html_()
    assert "table" in tags(shown) and "Elastic angle: 12.4605 arcsec" in shown
    beyond = drive.solve(5000, 600)._repr_html_()
    assert "table" not in tags(beyond) and "Status" in beyond


def pictures(shown: str) -> int:
    """How many pictures stand in it; each is drawn in its own field."""
    for svg in re.findall(r"<svg.*?</svg>", shown):
        width, height = (float(re.search(rf'{n}="(.*?)"', svg)[1]) for n in ("width", "height"))  # type: ignore[index]
        for path in re.findall(r'<path d="([^"HVh]+)"', svg):
            x, y = np.array(re.findall(r"[-\d.]+", path), dtype=float).reshape(-1, 2).T
            assert x.min() >= 0 and x.max() <= width and y.min() >= 0 and y.max() <= height
    return tags(shown).count("svg")


def test_solutions_loads_plans_sweeps_and_fits_show_a_small_picture() -> None:
    case = cbpt.Case.from_file(FOLDER / "dev03.toml")
    assert pictures(case.drive.solve(3, 600)._repr_html_()) == 2
    torque = np.linspace(0, 5, 40)
    loads = cbpt.solve_many(case, torque[:, None], [400.0, 600.0])._repr_html_()
    assert pictures(loads) == 1 and "preload_N 400" in loads and "over torque_Nm" in loads
    assert pictures(cbpt.solve_many(case, 3.0, 600.0)._repr_html_()) == 0
    swept = cbpt.sweep(case, {"load.torque_Nm": torque, "load.preload_N": 600})
    assert pictures(swept._repr_html_()) == 1
    plan = cbpt.read_plan(FOLDER.parents[2] / "examples" / "plan.toml")
    assert pictures(plan._repr_html_()) == 1
    fitted = cbpt.fit(case, FOLDER / "dev03.csv", ["creep"])._repr_html_()
    assert pictures(fitted) == 1 and "as given" in fitted


def test_a_sketch_escapes_leaves_out_what_is_not_finite_and_draws_nothing_of_one_point() -> None:
    x = np.array([0.0, 1.0, 2.0, np.nan])
    shown = sketch([Series(ATTACK, x, x), Series("b", x, 2 * x)], "<x>", "y")
    assert "script" not in tags(shown) and "&lt;x&gt;" in shown and "nan" not in shown
    assert sketch([Series("a", x[:1], x[:1])], "x", "y") == ""
    # One load varies among many: dots, as no line says which belong together.
    spread = {"torque_Nm": np.arange(20.0), "preload_N": 600 + np.sin(np.arange(20.0))}
    assert against(spread, "angle", np.arange(20.0)).count("h0") == 20


def test_plans_sweeps_and_readings_show_as_tables() -> None:
    case = cbpt.Case.from_file(FOLDER / "dev03.toml")
    swept = cbpt.sweep(case, {"load.torque_Nm": np.linspace(0, 5, 40), "load.preload_N": 600})
    assert "table" in tags(swept._repr_html_()) and "more rows" in swept._repr_html_()
    plan = cbpt.read_plan(FOLDER.parents[2] / "examples" / "plan.toml")
    assert tags(plan._repr_html_()).count("tr") == 1 + len(plan.runs)
    readings = cbpt.read_readings(FOLDER / "dev03.csv")
    assert "torque_Nm" in readings._repr_html_()
    looked = cbpt.preflight(case, FOLDER / "dev03.csv")._repr_html_()
    assert "p" in tags(looked) and "script" not in tags(looked)


def test_a_report_becomes_tables_and_paragraphs_whatever_the_terminal() -> None:
    class Told(Reported):
        def report(self) -> str:
            row = ["<b>", "a long sentence " * 30]
            return "Heading:\n" + layout.table(["key", "words"], [row]) + "\nEnd"

    shown = Told()._repr_html_()
    assert tags(shown).count("tr") == 2 and "b" not in tags(shown) and "&lt;b&gt;" in shown
    assert "<p>Heading:</p>" in shown and ("a long sentence " * 30).strip() in shown


def test_the_page_stands_in_a_frame_that_sees_nothing_of_the_notebook(tmp_path: Path) -> None:
    pytest.importorskip("plotly")
    names = {"run": [ATTACK] * 7, "torque_Nm": [0.0, 1, 2, 3, 2, 1, 0], "preload_N": [600.0] * 7}
    data: dict[str, Any] = names | {"elastic_angle_arcsec": [0.0, 3.1, 6.2, 9.0, 6.1, 3.0, 0.1]}
    shown = cbpt.compare(FOLDER / "dev04.toml", data).show(height_px=500)
    frame = shown._repr_html_()
    assert tags(frame) == ["iframe"] and "allow-same-origin" not in frame
    assert "height:500px" in frame and ATTACK not in shown.html
    assert shown.html.startswith("<!doctype html>") or "<html" in shown.html[:200]
    shown.save(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == shown.html
