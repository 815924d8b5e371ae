"""Plans of campaigns to come: what a file means, what is refused, the table and the file again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt import PlanError, read_plan
from cbpt.lab.experiment.plan import Plan, PlannedRun, sequence
from common.comparisons import CAMPAIGNS

TOP = Path(__file__).parents[2]
EXAMPLE = TOP / "examples" / "plan.toml"


def plan_of(text: str, tmp_path: Path) -> Plan:
    path = tmp_path / "plan.toml"
    path.write_text(text, encoding="utf-8")
    return read_plan(path)


# --- what a plan means --------------------------------------------------------------------


def test_torques_of_each_shape() -> None:
    assert sequence("up", 4, 3) == (0, 2, 4)
    assert sequence("up", 4, 3, -4) == (-4, 0, 4)
    assert sequence("up_down", 4, 3) == (0, 2, 4, 2, 0)
    assert sequence("loop", 4, 3) == (0, 2, 4, 2, 0, -2, -4, -2, 0)
    assert sequence("loop", 4, 3, 0) == (0, 2, 4, 2, 0)
    assert sequence("hold", 4, 4) == (0, 4, 4, 4)


def test_lists_of_preloads_are_runs_and_lists_of_angles_stay_within_one(tmp_path: Path) -> None:
    rows = plan_of(
        "u_elastic_angle_arcsec = 0.2\n[[run]]\npreload_N = [300, 600]\nrepeats = 2\n"
        "input_angle_deg = [0, 90]\ntorque_Nm = [0, 5]",
        tmp_path,
    ).rows
    assert rows.run.tolist() == np.repeat([1, 2, 3, 4], 4).tolist()
    assert rows.preload_N is not None
    assert rows.preload_N[::4].tolist() == [300, 300, 600, 600]
    assert rows.input_angle_deg[:4].tolist() == [0, 0, 90, 90]
    assert rows.torque_Nm[:4].tolist() == [0, 5, 0, 5]
    assert rows.time_s is None and any("dwell_s" in note for note in rows.notes)
    assert np.isnan(rows.elastic_angle_arcsec).all()


def test_any_unit_is_read(tmp_path: Path) -> None:
    one = plan_of(
        "[[run]]\npreload_kN = 0.6\ninput_angle_rad = 1.0\ntorque_mNm = { to = 5000, points = 2 }\n"
        "dwell_min = 0.1\nrate_Nmm_per_min = 60_000\nu_elastic_angle_arcmin = 0.01\n"
        "temperature_K = 293.15",
        tmp_path,
    )
    (run,) = one.runs
    assert run.torque_Nm == (0, 5) and run.preload_N == 600
    assert run.input_angle_deg == pytest.approx((np.rad2deg(1.0),))
    assert run.u_elastic_angle_arcsec == pytest.approx(0.6)
    assert run.temperature_degC == pytest.approx((20, 20))
    assert one.rows.time_s is not None
    # 6 s to wait, and 5 N m at 1 N m/s.
    assert one.rows.time_s.tolist() == pytest.approx([0, 11])


def test_time_goes_on_between_runs_and_cycles_count() -> None:
    run = PlannedRun((0.0, 5.0), 600, dwell_s=10, pause_s=30, cycles=2)
    rows = Plan.of_runs([run, run]).rows
    assert rows.time_s is not None and rows.cycle is not None
    assert rows.time_s.tolist() == [0, 10, 20, 30, 60, 70, 80, 90]
    assert rows.cycle.tolist() == [1, 1, 2, 2] * 2


@pytest.mark.parametrize("again", ["toml", "csv"])
def test_a_plan_written_and_read_again_is_the_same(again: str, tmp_path: Path) -> None:
    plan = read_plan(EXAMPLE)
    path = tmp_path / f"again.{again}"
    path.write_text(plan.to_toml() if again == "toml" else plan.to_csv(), encoding="utf-8")
    one, other = plan.rows, read_plan(path).rows
    for name in ("run", "time_s", "torque_Nm", "preload_N", "input_angle_deg", "temperature_degC"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-9)


def test_readings_are_a_plan_and_their_angles_are_not_looked_at() -> None:
    plan = read_plan(CAMPAIGNS / "dev03.csv")
    assert len(plan) == 396 and np.isnan(plan.rows.elastic_angle_arcsec).all()
    assert "elastic_angle_arcsec" not in plan.to_csv().split(",")
    with pytest.raises(PlanError, match=r"ends in \.csv"):
        plan.to_toml()


def test_the_case_fills_in_preload_and_input_angle(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text("[[run]]\ntorque_Nm = [0, 5]\n", encoding="utf-8")
    rows = read_plan(path, cbpt.Case.from_toml(cbpt.example_case())).rows
    assert rows.preload_N is not None and rows.preload_N.tolist() == [600, 600]


# --- what is refused ----------------------------------------------------------------------

RUN = "[[run]]\npreload_N = 600\ntorque_Nm = [0, 5]\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no [[run]]"),
        ("run = 3", "no [[run]]"),
        ("[[run]\n", "plan.toml: "),
        ("[[run]]\npreload_N = 600", "[[run]] 1, torque_Nm: found nothing"),
        (RUN + "torque = 3", "add the unit to the key: torque_Nm"),
        (RUN + "preloads_N = 3", "did you mean preload_N?"),
        (RUN + "torque_kN = 3", "[[run]] 1, torque_kN: found 3"),
        (RUN + "torque_kNm = 3", "torque_Nm only once"),
        (RUN + "elastic_angle_arcsec = 3", "expected one of torque_Nm"),
        (RUN + "dwell = 3", "a key dwell_s"),
        (RUN + "dwell_N = 3", "a key dwell_s"),
        (RUN + "dwell_s = -3", "found -3, expected a number above 0"),
        (RUN + "rate_Nm = 3", "rate_Nm_per_s"),
        (RUN + "repeats = 0", "whole number from 1"),
        (RUN + "repeats = true", "whole number from 1"),
        (RUN + "u_elastic_angle_arcsec = 0", "a number above 0"),
        ("[[run]]\ntorque_Nm = []", "a list of them"),
        ("[[run]]\ntorque_Nm = [1, 'a']", "a list of them"),
        ("[[run]]\ntorque_Nm = [1, nan]", "a list of them"),
        ("[[run]]\npreload_N = -1\ntorque_Nm = 1", "preload_N: found -1"),
        ("[[run]]\ntorque_Nm = { to = 5 }", "torque_Nm.count: found nothing"),
        ("[[run]]\ntorque_Nm = { points = 5 }", "torque_Nm.to: found nothing"),
        ("[[run]]\ntorque_Nm = { to = 5, points = 1 }", "torque_Nm.points: found 1"),
        ("[[run]]\ntorque_Nm = { to = 5, points = 3, shape = 'ramp' }", "one of up, up_down"),
        (
            "[[run]]\ntorque_Nm = { to = 0, points = 3, shape = 'loop' }",
            "the peak torque of the loop",
        ),
        ("[[run]]\ntorque_Nm = { to = 5, points = 3, step = 2 }", "torque_Nm.step"),
        (RUN + "rate_Nm_per_s = 1\n" + RUN, "run 1 has time_s and run 2 has none"),
        ("[[run]]\ntorque_Nm = [1, 1]\nrate_Nm_per_s = 1", "dwell_s as well"),
    ],
)
def test_a_mistake_is_told_with_its_place(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(PlanError) as caught:
        plan_of(text, tmp_path)
    assert told in str(caught.value) and "plan.toml" in str(caught.value)


def test_a_plan_that_is_no_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"none\.toml: No such file"):
        read_plan(tmp_path / "none.toml")
    with pytest.raises(cbpt.ReadingsError, match="torque_Nm"):
        read_plan({"preload_N": [1, 2]})
    with pytest.raises(PlanError, match="--u-arcsec"):
        read_plan({"torque_Nm": [1, 2]}).with_u(None)
    with pytest.raises(PlanError, match="above 0"):
        read_plan({"torque_Nm": [1, 2]}).with_u(-1)


def test_the_plan_that_the_page_shows_is_one(tmp_path: Path) -> None:
    page = (TOP / "docs" / "how-to" / "plans.md").read_text(encoding="utf-8")
    shown = page.split("```toml\n", 1)[1].split("```", 1)[0]
    plan = plan_of(shown, tmp_path)
    assert len(plan.runs) == 4 and plan.rows.cycle is not None


def test_a_range_counts_as_in_a_plan_of_a_sweep(tmp_path: Path) -> None:
    def rows(said: str) -> cbpt.Plan:
        path = tmp_path / "plan.toml"
        path.write_text(f"[[run]]\npreload_N = 600\ntorque_Nm = {{ to = 6, {said} }}\n")
        return cbpt.read_plan(path)

    assert rows("count = 4").rows.torque_Nm.tolist() == rows("points = 4").rows.torque_Nm.tolist()
    with pytest.raises(cbpt.PlanError, match="not both"):
        rows("count = 4, points = 4")
