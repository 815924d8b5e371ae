"""The section of the page on the table by itself."""

from __future__ import annotations

import json
from pathlib import Path

import cbpt
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.page.document.loops import table_section
from common.hidden import FOLDER

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_page_says_what_the_verbs_say() -> None:
    case, table = EXAMPLES / "reducer.toml", EXAMPLES / "reducer.csv"
    found = table_section(*case_and_readings(case, table))
    json.dumps(found, allow_nan=False)
    verb = cbpt.preflight(case, table)
    assert [check["finding"] for check in found["checks"]] == [c.finding for c in verb.checks]
    figures = cbpt.characterise(case, table)
    shown = [f["value"] for setting in found["loops"] for f in setting["figures"]]
    assert shown == [figure.value for figure in figures.figures]
    steps = [f"preload step {step}" for step in (1, 2, 3)]
    assert all(f["after"] is None for setting in found["loops"] for f in setting["figures"])
    assert [setting["setting"] for setting in found["loops"]] == steps


def test_the_answer_gives_the_model_a_loop(tmp_path: Path) -> None:
    case, readings = case_and_readings(FOLDER / "dev04.toml", FOLDER / "dev04.csv")
    answer = cbpt.fit(case, readings, ["friction_hysteresis"]).case.to_toml()
    for setting in table_section(case, readings, answer)["loops"]:
        width = next(f for f in setting["figures"] if f["name"] == "hysteresis_loss")
        assert width["model"] == 0
        assert abs(width["after"] / width["value"] - 1) < 0.2


def test_a_table_without_a_loop_has_no_figures() -> None:
    readings = {"torque_Nm": [1, 2, 3], "elastic_angle_arcsec": [60, 120, 180]}
    case = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}}
    one_way = cbpt.read_readings(readings, need_preload=False)
    section = table_section(cbpt.Case.from_dict(case), one_way)
    assert section["checks"]
    assert len(section["loops"]) <= 1
