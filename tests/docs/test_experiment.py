"""The experiment of the 2017 paper: the example, and its page."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "examples" / "prototype"))

import experiment

from common import mostly_long

TOP = Path(__file__).parents[2]
PAGE = (TOP / "docs" / "explanation" / "experiment.md").read_text(encoding="utf-8")
STEEL = experiment.CONDITIONS["bearing steel"]


def test_page_is_up_to_date_but_for_its_diagnoses(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a diagnosis weighs has a test of its own."""
    left_out = ["left", "out"]
    monkeypatch.setattr(experiment, "diagnosis", lambda condition: left_out)
    head, tail = experiment.page().split("combinations from probability 0.1 |\n", 1)
    assert PAGE.startswith(head)
    assert PAGE.endswith(tail.rpartition("| left | out |\n")[2])


@pytest.mark.parametrize("condition", mostly_long(experiment.CONDITIONS, ["aluminium"]))
def test_no_condition_names_one_cause(condition: str) -> None:
    name, rmse, kind, _ = experiment.diagnosis(condition)
    assert kind not in ("effect", "parameter", "complete")
    assert f"| {name} | {rmse} |" in PAGE


def test_the_rig_is_that_of_the_text() -> None:
    """7.99 V/mm at 0.1 m: 1 arcsec is 0.485 um, and a step of 12 bit 2.44 mV."""
    arcsec_um = 0.1 * experiment.ARCSEC * 1e6
    assert arcsec_um == pytest.approx(0.485, abs=5e-4)
    step_um = 10 / 4096 / 7.99 * 1e3
    assert experiment.budget(0.0)[0][2] == pytest.approx(step_um / arcsec_um / math.sqrt(12))
    gain = sum(u**2 for _, _, u in experiment.budget(1.0)[1:]) ** 0.5
    stated = experiment.document(STEEL)["uncertainty"]["sensor_gain_rel"]
    assert stated == pytest.approx(gain, rel=0.02)


def test_readings_are_calculated_less_difference() -> None:
    table = experiment.readings(STEEL)
    assert len(table["torque_Nm"]) == 11
    rows = zip(table["preload_N"], table["torque_Nm"], table["elastic_angle_arcsec"], strict=True)
    found = {(preload, torque): angle for preload, torque, angle in rows}
    for row in experiment.stated():
        place = row["preload_N"], row["torque_Nm"]
        calculated = experiment.calculated(STEEL, *place)[0]
        assert calculated - found[place] == pytest.approx(
            row["calculated_minus_measured_arcsec"], abs=1e-9
        )
    assert [found[preload, 0.0] for preload in (600.0, 500.0, 400.0)] == [0.0, 0.0, 0.0]


def test_what_gives_way_makes_readings_larger_and_friction_makes_them_smaller() -> None:
    larger = experiment.makes_larger()
    assert {"bearing_play", "eccentric_bearing", "output_torsion"} <= set(larger)
    assert "friction_hysteresis" not in larger
    # A stiffer contact by half, at the point where nothing has parted yet: s^(-2/3) - 1.
    size = experiment.size_for("contact_stiffness", STEEL, experiment.POINTS[3])
    assert size is not None
    calculated = experiment.calculated(STEEL, 400.0, 4.0)[0]
    assert (size ** (-2 / 3) - 1) * calculated == pytest.approx(49.8, rel=0.02)
