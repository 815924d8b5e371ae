"""Any reducer as a torsion spring: one load, many, a table of readings, what is missing, and how
its numbers change with the step of the preload."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt._core import Predictor
from common.springs import Reducer, loops

CASE = {"torsion_spring": {"torsional_stiffness_Nm_per_rad": 2000.0}}
TABLE = {
    "torsion_spring": {"torque_Nm": [0, 5, 10, 30], "elastic_angle_arcmin": [0.0, 12.0, 20.0, 44.0]}
}


def drive(case: dict[str, Any] = CASE) -> cbpt.Drive:
    return cbpt.Drive.from_dict(case)


def test_a_load_needs_no_preload() -> None:
    solution = drive().solve(torque_Nm=10)
    assert solution.elastic_angle_rad == pytest.approx(10 / 2000, rel=1e-15)
    assert solution.torsional_stiffness_Nm_per_rad == pytest.approx(2000)
    assert solution.preload_N is None
    assert solution.deceleration is None
    assert "deceleration" not in repr(solution)
    assert repr(pickle.loads(pickle.dumps(solution))) == repr(solution)
    angles = cbpt.solve_many(drive(), np.linspace(-5, 5, 11))
    assert np.allclose(angles.elastic_angle_rad, np.linspace(-5, 5, 11) / 2000, rtol=1e-15)


def test_a_table_is_carried_on_straight_and_says_so() -> None:
    inside, outside = drive(TABLE).solve(-10), drive(TABLE).solve(40)
    assert inside.elastic_angle_arcsec == pytest.approx(-20 * 60)
    assert inside.status == "ok"
    assert outside.status == "outside_table"
    # The parabola through the last three points has the slope 1.2 + (1.2 - 1.6) 20/25 at the end.
    assert outside.elastic_angle_arcsec == pytest.approx((44 + 10 * 0.88) * 60)


@pytest.mark.parametrize("asked", ["findings", "preload", "transmission_ratio", "largest"])
def test_what_is_about_balls_is_refused(asked: str) -> None:
    spring = drive()
    questions: dict[str, Callable[[], object]] = {
        "findings": spring.findings,
        "preload": lambda: spring.preload(5),
        "transmission_ratio": lambda: spring.transmission_ratio,
        "largest": lambda: spring.largest_elastic_angle(5, 600),
    }
    with pytest.raises(cbpt.errors.InvalidInputError, match="this one is a torsion spring"):
        questions[asked]()
    with pytest.raises(cbpt.errors.InvalidInputError, match="a ball drive needs a preload"):
        cbpt.Drive.from_toml(cbpt.example_case()).solve(5)


# --- readings -----------------------------------------------------------------------------


def test_readings_need_no_preload_and_keep_its_step() -> None:
    data = loops([Reducer(), Reducer()]) | {"design": np.repeat(["conic", "split"], 64)}
    comparison = cbpt.compare(CASE, data)
    assert comparison.overall is not None
    assert comparison.overall.rmse_arcsec == pytest.approx(np.rad2deg(2e-5) * 3600, rel=0.2)
    assert comparison.readings.preload_step is not None
    steps = [g for g in comparison.groups if g.column == "preload_step"]
    assert [g.label for g in steps] == ["1", "2"]
    part = cbpt.compare(CASE, data, only={"design": "split", "preload_step": 2.0}).readings
    assert set(part.run.tolist()) == {2}
    assert (
        part.notes[-1]
        == "64 of 128 readings are used, those with design = split, preload_step = 2.0"
    )
    for several in ([1, 2, 2], range(1, 3), frozenset({1, 2})):
        both = cbpt.compare(CASE, data, only={"preload_step": several, "design": ["split"]})
        assert set(both.readings.run.tolist()) == {2}
        assert "1 or 2," in both.readings.notes[-1]
    with pytest.raises(cbpt.ReadingsError, match="no value"):
        cbpt.compare(CASE, data, only={"design": []})
    with pytest.raises(cbpt.ReadingsError, match="readings with design = flat"):
        cbpt.compare(CASE, data, only={"design": "flat"})
    with pytest.raises(cbpt.ReadingsError, match="no such column"):
        cbpt.compare(CASE, data, only={"desing": "conic"})


def test_a_bare_angle_is_asked_about() -> None:
    data = loops([Reducer()])
    data["angle_deg"] = np.rad2deg(data.pop("elastic_angle_rad"))
    with pytest.raises(cbpt.ReadingsError, match=r"columns=\{'angle_deg': 'elastic_angle_deg'\}"):
        cbpt.compare(CASE, data)
    comparison = cbpt.compare(CASE, data, columns={"angle_deg": "elastic_angle_deg"})
    assert comparison.overall is not None


# --- diagnosis ----------------------------------------------------------------------------


def value(answer: cbpt.Diagnosis, effect: str, name: str) -> float:
    return float(answer.parameters(answer.after, effect)[name]["value"])


def test_nothing_is_missing_where_nothing_is() -> None:
    answer = cbpt.diagnose(CASE, loops([Reducer()] * 3))
    assert answer.verdict.kind == "complete"


def test_backlash_is_found_with_its_play() -> None:
    answer = cbpt.diagnose(CASE, loops([Reducer(play_rad=3e-3)] * 3))
    assert answer.verdict.effects == ("backlash",)
    assert value(answer, "backlash", "play_rad") == pytest.approx(3e-3, rel=0.1)


def test_friction_is_found_with_its_torque() -> None:
    answer = cbpt.diagnose(CASE, loops([Reducer(friction_Nm=1.5)] * 3))
    assert answer.verdict.effects == ("friction_hysteresis",)
    assert value(answer, "friction_hysteresis", "friction_torque_Nm") == pytest.approx(1.5, rel=0.1)


def test_a_spring_that_stiffens_is_no_sensor_that_bends() -> None:
    """Without friction or play nothing tells them apart: the sensor is not named alone."""
    answer = cbpt.diagnose(CASE, loops([Reducer(bend_rad=1e-3)] * 3))
    told = {*answer.verdict.effects, *(e for g in answer.verdict.rivals for e in g)}
    assert "stiffness_curve" in told
    assert "sensor_nonlinearity" not in answer.verdict.effects


def test_creep_is_found() -> None:
    answer = cbpt.diagnose(CASE, loops([Reducer(creep_rad_per_Nm=6e-5)] * 3))
    assert "creep" in {*answer.verdict.effects, *(e for g in answer.verdict.rivals for e in g)}


def test_numbers_are_told_for_each_step_of_the_preload() -> None:
    frictions = [1.0, 1.5, 2.0]
    reducers = [Reducer(friction_Nm=f, play_rad=4e-3, load_share=0.05 * f) for f in frictions]
    found = cbpt.diagnose_by(CASE, loops(reducers), "preload_step")
    assert list(found.answers) == ["1", "2", "3"]
    assert found.effects == ("backlash", "friction_hysteresis")
    numbers = found.parameters()["friction_hysteresis.friction_torque_Nm"]
    for level, friction in zip("123", frictions, strict=True):
        assert numbers[level]["value"] == pytest.approx(friction, rel=0.15)
    assert "friction_torque_Nm" in found.report()
    assert found.to_dict()["levels"].keys() == {"1", "2", "3"}


def test_friction_that_grows_with_the_load_is_found_where_it_is_large() -> None:
    data = loops([Reducer(friction_Nm=3.0, play_rad=4e-3, load_share=0.15)])
    answer = cbpt.diagnose(CASE, data)
    found = value(answer, "friction_hysteresis", "friction_torque_Nm")
    assert found == pytest.approx(3.0, rel=0.15)


def test_a_fitted_case_compares_to_the_noise() -> None:
    data = loops([Reducer(friction_Nm=1.5, play_rad=3e-3)] * 3)
    fitted = cbpt.fit(CASE, data, ["friction_hysteresis", "backlash"])
    after = cbpt.compare(fitted.case, data)
    assert after.overall is not None
    assert after.overall.rmse_arcsec < 1.1 * np.rad2deg(2e-5) * 3600


# --- what a spring has no preload for ------------------------------------------------------

REDUCER = Path(__file__).parents[2] / "examples" / "reducer.toml"
LOOPS = REDUCER.with_suffix(".csv")


@cache
def one_step() -> cbpt.Diagnosis:
    return cbpt.diagnose(REDUCER, LOOPS, only={"preload_step": 2})


def test_the_angle_at_a_load_needs_no_preload() -> None:
    at = one_step().predict([2.0, 5.0])
    assert np.isfinite(at.elastic_angle_arcsec).all() and np.isnan(at.preload_N).all()
    assert (at.u_elastic_angle_arcsec > 0).all() and at.inside.all()
    text = one_step().results(torque_Nm=5.0).report()
    assert "elastic angle at 5 N m, 0 deg" in text and "nan" not in text


def test_runs_and_plans_are_for_ball_drives() -> None:
    found = cbpt.next_runs(REDUCER, LOOPS)
    assert "torsion spring" in found.report() and found.best is None
    plan = cbpt.read_readings(LOOPS, need_preload=False)
    with pytest.raises(cbpt.InvalidInputError, match="ball drives"):
        cbpt.isolability(REDUCER, plan)
    with pytest.raises(cbpt.InvalidInputError, match="ball drives"):
        cbpt.shortest_plan(REDUCER, ["creep"], u_elastic_angle_arcsec=1.0)


def test_steps_of_the_preload_are_no_repeats() -> None:
    whole = cbpt.diagnose(REDUCER, LOOPS)
    assert any("--by preload_step" in note for note in whole.notes)
    assert not any("--by" in note for note in one_step().notes)
    assert whole.to_dict()["noise"]["repeats"] is None


def test_friction_across_a_play_is_solved_from_any_state() -> None:
    """The balance of torques has a steep step between flat parts there."""
    runs, n = 2000, 4
    torque = np.random.default_rng(0).uniform(-5, 5, runs * n)
    drive = cbpt.Case.from_dict({"torsion_spring": {"torsional_stiffness_Nm_per_deg": 18.0}}).drive
    run, none = np.repeat(np.arange(runs), n), np.zeros(runs * n)
    effects = ["friction_hysteresis", "backlash"]
    numbers = {
        "engagement_angle_rad": 5e-4,
        "friction_torque_Nm": 1.7,
        "load_share": 0.29,
        "play_rad": 0.036,
    }
    for transition_Nm in (1.0, 1e-3):
        model = Predictor(drive, effects, run, none, torque, None, none)
        values = model.neutral()
        for i, (_, _, parameter) in enumerate(model.parameters):
            sizes = numbers | {"transition_torque_Nm": transition_Nm}
            values[i] = sizes.get(parameter.name, values[i])
        assert set(model.predict(values).status) == {"ok"}
