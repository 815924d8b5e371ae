"""Exact sensitivities from Python and on the command line; their property test is the core's."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

import cbpt
from cbpt._core import judge_designs
from cbpt.cli.main import main
from cbpt.design.judge import judge, value_of
from common.drives import ARCSEC, CaseDict, cases, examples

TOP = Path(__file__).parents[2]
BASE = TOP / "examples/base_case.toml"


@examples(25)
@given(cases())
def test_slopes_are_those_of_differences(case: CaseDict) -> None:
    full = cbpt.Case.from_dict(case | {"load": {"torque_Nm": 0.02, "preload_N": 200}})
    found = full.drive.sensitivities(0.02, 200)
    if found.elastic_angle is None:
        assert found.status in ("beyond_hold", "undercut")
        return
    for name in ("deceleration.ball_radius_m", "equal_speed.pitch_radius_m", "load.preload_N"):
        value = value_of(full, name)
        assert value is not None
        h = 1e-4 * value

        angles = judge(full, [name], np.array([[value - h], [value + h]]))["elastic_angle_rad"]
        slope = (angles[1] - angles[0]) / (2 * h)
        exact = found.elastic_angle.slopes[name]
        size = abs(exact) + abs(found.elastic_angle.value / value)
        assert exact == pytest.approx(slope, abs=1e-3 * size), name


def test_the_drive_tells_all_results() -> None:
    drive = cbpt.Drive.from_file(BASE)
    found = drive.sensitivities(torque_Nm=5, preload_N=600)
    angle = found.elastic_angle
    assert angle is not None and found.status == "ok"
    assert angle.value / ARCSEC == pytest.approx(12.4605, abs=1e-4)
    assert angle.relative["material.youngs_modulus_Pa"] == pytest.approx(-2 / 3, rel=1e-9)
    parts = [found.results[f"{pair}_angle_rad"] for pair in ("deceleration", "equal_speed")]
    for name, slope in angle.slopes.items():
        total = sum(part.slopes[name] for part in parts if part)
        assert slope == pytest.approx(total, rel=1e-12, abs=1e-30)
    hold, preload = found.results["hold_N"], drive.preload(5)
    assert hold is not None and hold.value == pytest.approx(preload.drive.hold_N, rel=1e-12)
    assert hold.relative["load.torque_Nm"] == pytest.approx(1)
    assert "load.preload_N" in str(found) or "preload" in str(found)
    assert pickle.loads(pickle.dumps(found)) == found


def test_one_of_two_numbers_is_told_where_asked() -> None:
    drive = cbpt.Drive.from_file(BASE)
    ball, plate = "material.ball_youngs_modulus_Pa", "material.plate_youngs_modulus_Pa"
    angle = drive.sensitivities(5, 600, also=[ball, plate]).elastic_angle
    assert angle is not None
    both = angle.slopes["material.youngs_modulus_Pa"]
    assert angle.slopes[ball] + angle.slopes[plate] == pytest.approx(both, rel=1e-12)
    with pytest.raises(cbpt.InvalidInputError, match="ball_radius_mm"):
        drive.sensitivities(5, 600, also=["deceleration.ball_radius_mm"])
    with pytest.raises(cbpt.InvalidInputError, match="whole"):
        drive.sensitivities(5, 600, also=["deceleration.ball_count"])


def test_the_verb_tells_shares_of_the_variance(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "case.toml"
    spreads = "\n[tolerance]\ndeceleration_ball_radius_um = 3\n"
    spreads += "[uncertainty]\nequal_speed_pitch_radius_um = 5\n"
    case.write_text(BASE.read_text() + spreads)
    assert main(["sensitivity", str(case), "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    rows = {row["number"]: row for row in found["numbers"]}
    ball, pitch = rows["deceleration.ball_radius_mm"], rows["equal_speed.pitch_radius_mm"]
    assert (ball["distribution"], pitch["distribution"]) == ("uniform", "normal")
    assert ball["u"] == pytest.approx(3e-3 / 3**0.5) and pitch["u"] == pytest.approx(5e-3)
    parts = [row["per_unit"]["elastic_angle_arcsec"] * row["u"] for row in (ball, pitch)]
    u = found["u_elastic_angle_arcsec"]
    assert u == pytest.approx((parts[0] ** 2 + parts[1] ** 2) ** 0.5)
    assert ball["share_of_variance"] == pytest.approx(parts[0] ** 2 / u**2)
    assert rows["deceleration.contact_angle_deg"]["share_of_variance"] is None
    assert found["whole_numbers"] == ["deceleration.ball_count", "equal_speed.ball_count"]
    assert main(["sensitivity", str(case), "--angle-unit", "urad"]) == 0
    text = capfd.readouterr().out
    assert "change of the angle in urad" in text and "whole" in text


def test_without_a_solution_the_thresholds_are_still_told(
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert main(["sensitivity", str(BASE), "--torque-Nm", "50", "--json"]) == 3
    found = json.loads(capfd.readouterr().out)
    assert found["status"] == "beyond_hold" and found["elastic_angle_arcsec"] is None
    assert found["hold_N"] > 600
    assert found["numbers"][0]["per_unit"]["elastic_angle_arcsec"] is None


def test_a_spread_of_one_number_that_is_two_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "case.toml"
    text = BASE.read_text().replace(
        "[deceleration]", "ball_youngs_modulus_GPa = 310\n[deceleration]"
    )
    case.write_text(text + "\n[tolerance]\nmaterial_youngs_modulus_GPa = 5\n")
    assert main(["sensitivity", str(case)]) == 2
    assert "give a spread for each of them" in capfd.readouterr().err


def test_judging_keeps_rows_that_are_no_drive() -> None:

    case = cbpt.Case.from_file(BASE)
    values = np.array([[0.5], [1.5], [0.9], [0.55]])
    found = judge(case, ["deceleration.short_amplitude_coefficient"], values)
    assert found.status.tolist() == ["ok", "no_drive", "undercut", "ok"]
    assert np.isfinite(found["elastic_angle_rad"]).tolist() == [True, False, False, True]
    assert found["undercut_margin"][2] < 0 < found["undercut_margin"][0]
    with pytest.raises(cbpt.InvalidInputError, match="must be one of"):
        judge_designs(case.drive, 5, 600, 0, ["nothing"], np.zeros(1), False, None)


@pytest.mark.parametrize("threshold", ["hold", "continuous", "zero_backlash"])
def test_the_needed_preload_is_the_threshold(threshold: str) -> None:

    case = cbpt.Case.from_file(BASE)
    one = judge(case, ["load.torque_Nm"], np.array([[5.0], [-2.0]]), threshold=threshold)
    for torque, needed in zip((5, -2), one["needed_preload_N"], strict=True):
        expected = getattr(case.drive.preload(torque).drive, f"{threshold}_N")
        assert needed == pytest.approx(expected, rel=1e-9)


def test_of_nothing_no_part_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    """Without torque angle and thresholds are 0 but for rounding, and no percentage is."""
    case = Path(__file__).parents[2] / "examples/base_case.toml"
    assert main(["sensitivity", str(case), "--torque-Nm", "0", "--json"]) == 0
    numbers = json.loads(capfd.readouterr().out)["numbers"]
    assert numbers and all(v is None for n in numbers for v in n["relative"].values())
