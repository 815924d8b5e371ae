"""Preflight on signals that were lost or cut, single readings that are wrong, drift and offsets."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.preflight.record import Check

Floats = NDArray[np.float64]
Columns = dict[str, NDArray[np.float64]]
SPRING = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.6}}
PER_RUN = SPRING | {"measurement": {"zero": "per_run"}}
SUBJECT = "single readings"


def ramps(
    steps: int = 40, runs: int = 3, noise: float = 2.0, seed: int = 0, friction_Nm: float = 0.0
) -> Columns:
    """Runs of one and a quarter cycles to 20 N m, of 100 arcsec/(N m)."""
    rng = np.random.default_rng(seed)
    phase = np.arange(5 * steps + 1) / steps
    torque = 20 * np.interp(phase, [0, 1, 3, 5], [0, 1, -1, 1])
    spring, moved = np.zeros(len(torque)), 0.0
    for i, load in enumerate(torque):
        moved = min(max(moved, load - friction_Nm), load + friction_Nm)
        spring[i] = 100 * moved
    n = len(torque)
    return {
        "run": np.repeat(np.arange(1.0, runs + 1), n),
        "time_s": np.arange(runs * n, dtype=np.float64) + np.repeat(30.0 * np.arange(runs), n),
        "torque_Nm": np.tile(torque, runs),
        "elastic_angle_arcsec": np.tile(spring, runs) + rng.normal(0, noise, runs * n),
    }


def check(subject: str, columns: Columns, case: Mapping[str, object] | None = None) -> Check:
    found = cbpt.preflight(PER_RUN if case is None else case, columns)
    return next(check for check in found.checks if check.subject == subject)


# --- single readings ----------------------------------------------------------------------


@pytest.mark.parametrize("friction_Nm", [0.0, 1.0])
@pytest.mark.parametrize("steps", [3, 10, 40, 200])
@pytest.mark.parametrize("noise", [0.0, 2.0, 40.0])
def test_loops_have_no_odd_readings(steps: int, noise: float, friction_Nm: float) -> None:
    for seed in range(3):
        columns = ramps(steps, noise=noise, seed=seed, friction_Nm=friction_Nm)
        assert check(SUBJECT, columns).state == "good"


@pytest.mark.parametrize(
    ("column", "value", "unit"),
    [("elastic_angle_arcsec", 800.0, "arcsec"), ("torque_Nm", 180.0, "N m")],
)
def test_a_spike_is_told_with_its_row_and_left_out_of_the_rest(
    column: str, value: float, unit: str
) -> None:
    columns = ramps()
    columns[column][300] += value
    found = cbpt.preflight(PER_RUN, columns)
    checks = {each.subject: each for each in found.checks}
    assert checks[SUBJECT].state == "look"
    assert "of row 301 lies" in checks[SUBJECT].finding and unit in checks[SUBJECT].finding
    clean = {each.subject: each for each in cbpt.preflight(PER_RUN, ramps()).checks}
    for subject, each in checks.items():
        assert subject == SUBJECT or each.state == clean[subject].state, subject


def test_a_preload_that_stands_alone_is_told() -> None:
    columns = ramps() | {"preload_N": np.full(603, 600.0)}
    columns["preload_N"][100] = 6000.0
    assert "preload of row 101" in check(SUBJECT, columns).finding


@pytest.mark.parametrize("column", ["torque_Nm", "elastic_angle_arcsec"])
def test_a_frozen_signal_is_told(column: str) -> None:
    columns = ramps(100)
    columns[column][150:190] = columns[column][150]
    found = check(SUBJECT, columns)
    assert found.state == "look" and "rows 151 to 190" in found.finding


def test_torques_that_are_held_are_not_frozen() -> None:
    columns = {name: np.repeat(values, 12) for name, values in ramps(5).items()}
    columns["time_s"] = np.arange(len(columns["run"]), dtype=np.float64)
    columns["elastic_angle_arcsec"] += np.random.default_rng(1).normal(0, 2, len(columns["run"]))
    assert check(SUBJECT, columns).state == "good"


# --- runs ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("column", "words"),
    [
        ("elastic_angle_arcsec", "in run 2 the torque varies and the angle hardly moves"),
        ("torque_Nm", "in run 2 the torque stays while the angle moves as in the others"),
    ],
)
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_run_without_one_of_its_signals_is_named(column: str, words: str, noise: float) -> None:
    """noise: as a share of the column's range."""
    columns = ramps()
    here = columns["run"] == 2
    scatter = np.random.default_rng(2).normal(0, 1, int(here.sum()))
    columns[column][here] = noise * float(np.ptp(columns[column])) * scatter
    assert words in check("units", columns).finding
    assert check("sign of the angle", columns).finding.endswith("in every other run")


def test_runs_at_one_torque_each_are_compared_with_each_other() -> None:
    torque = np.repeat([10.0, 20.0, -20.0], 50)
    columns = {
        "run": np.repeat([1.0, 2.0, 3.0], 50),
        "time_s": np.arange(150.0),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 100 * torque + np.random.default_rng(0).normal(0, 2, 150),
    }
    found = check("units", columns)
    assert found.state == "good" and "from run to run, not within runs" in found.finding
    assert "100 arcsec/(N m)" in found.finding


def test_a_slope_that_fits_leaves_the_rated_torque_in_question() -> None:
    case = PER_RUN | {"rating": {"rated_torque_Nm": 2.0}}
    assert "rated torque in the case" in check("units", ramps(), case).remedy


# --- closing ------------------------------------------------------------------------------


@pytest.mark.parametrize("noise", [2.0, 20.0])
@pytest.mark.parametrize("steps", [2, 4, 10])
def test_noise_leaves_no_loop_open(steps: int, noise: float) -> None:
    for seed in range(5):
        columns = ramps(steps, runs=48, noise=noise, seed=seed)
        assert check("loops", columns).state == "good"
        stated = columns | {"u_elastic_angle_arcsec": np.full(len(columns["run"]), noise)}
        assert check("loops", stated).state == "good"


@pytest.mark.parametrize("drift_arcsec_per_s", [0.3, 1.0])
def test_a_drift_beyond_the_noise_is_told(drift_arcsec_per_s: float) -> None:
    columns = ramps()
    columns["elastic_angle_arcsec"] += drift_arcsec_per_s * columns["time_s"]
    found = check("loops", columns)
    assert found.state == "look" and "drift" in found.remedy


def test_torques_that_are_displayed_coarsely_leave_no_loop_open() -> None:
    columns = ramps(200, noise=0.1)
    columns["torque_Nm"] = columns["torque_Nm"] + np.random.default_rng(3).normal(0, 0.1, 3003)
    assert check("loops", columns).state == "good"


# --- torque and zeros ---------------------------------------------------------------------


def scattered(columns: Columns, scatter_Nm: float) -> Columns:
    noise = np.random.default_rng(4).normal(0, scatter_Nm, len(columns["run"]))
    return columns | {"torque_Nm": columns["torque_Nm"] + noise}


@pytest.mark.parametrize(("scatter_Nm", "state"), [(0.02, "good"), (1.0, "look")])
def test_scatter_of_the_torque_is_judged_by_what_it_moves(scatter_Nm: float, state: str) -> None:
    found = check("noise of the torque", scattered(ramps(1000, runs=1), scatter_Nm))
    assert found.state == state and "by which the angle changes by" in found.finding


def play(columns: Columns) -> Columns:
    lost = 300 * np.clip(columns["torque_Nm"] / 0.4, -1, 1)
    return columns | {"elastic_angle_arcsec": columns["elastic_angle_arcsec"] + lost}


@pytest.mark.parametrize(
    ("change", "state"), [(lambda columns: columns, "good"), (play, "look")], ids=["even", "play"]
)
def test_coarse_steps_matter_where_the_angle_bends(
    change: Callable[[Columns], Columns], state: str
) -> None:
    assert check("steps of the torque", change(ramps(10))).state == state


def test_lost_motion_is_read_at_a_share_of_the_rated_torque() -> None:
    case = PER_RUN | {"rating": {"rated_torque_Nm": 40.0}}
    assert "read off at +-1.2 N m" in check("steps of the torque", ramps(), case).finding


@pytest.mark.parametrize(("apart", "state"), [(0.0, "good"), (20.0, "look"), (200.0, "look")])
@pytest.mark.parametrize("factor", [1.0, 0.1])
def test_zeros_of_runs_are_judged_by_what_readings_scatter(
    apart: float, state: str, factor: float
) -> None:
    """A stated uncertainty that is ten times too small makes no offsets."""
    columns = ramps(runs=5)
    columns["elastic_angle_arcsec"] += apart * columns["run"]
    columns |= {"u_elastic_angle_arcsec": np.full(len(columns["run"]), 2.0 * factor)}
    assert check("zeros of runs", columns, SPRING).state == state


def test_a_sensor_that_is_cut_at_its_end_is_told_where_few_readings_reach_it() -> None:
    rng = np.random.default_rng(5)
    torque = np.tile(np.r_[0:9, 8:-9:-1, -8:9].astype(np.float64), 12)
    preload = np.repeat(np.linspace(400, 1200, 12), len(torque) // 12)
    angle = 40 * torque * (preload / 600) ** (-1 / 3) + rng.normal(0, 0.3, len(torque))
    columns = {
        "run": np.repeat(np.arange(1.0, 13), len(torque) // 12),
        "torque_Nm": torque,
        "preload_N": preload,
        "elastic_angle_arcsec": np.minimum(angle, 330.0),
    }
    found = check("ends of the ranges", columns)
    assert found.state == "look" and "the same largest angle, 330 arcsec" in found.finding
    assert check("ends of the ranges", columns | {"elastic_angle_arcsec": angle}).state == "good"


# --- what a second look found -------------------------------------------------------------


@pytest.mark.parametrize(
    "steps", [np.r_[0:11:5, 5:-11:-5, -5:11:5].repeat(3), np.r_[0, np.full(8, 5)]]
)
def test_steps_that_are_held_have_no_rate_of_zero(steps: Floats) -> None:
    time = np.arange(float(len(steps)))
    columns = {"torque_Nm": 1.0 * steps, "time_s": time, "elastic_angle_arcsec": 100.0 * steps}
    assert "0 N m/s" not in check("rates", columns).finding.split(" to ")


def test_a_load_that_is_held_to_the_end_of_a_run_is_neither_frozen_nor_cut() -> None:
    torque = np.tile(np.r_[np.linspace(0, 8, 6), np.full(25, 8.0)], 6)
    run = np.repeat(np.arange(1.0, 7), 31)
    weights = 0.2 * 0.8 ** np.arange(31)
    late = np.concatenate([np.convolve(load, weights)[:31] for load in np.split(torque, 6)])
    angle = 10 * late + np.random.default_rng(0).normal(0, 0.05, len(late))
    columns = {
        "run": run,
        "time_s": np.arange(float(len(run))),
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle,
    }
    assert check(SUBJECT, columns).state == "good"
    assert check("ends of the ranges", columns).state == "good"


def test_loads_that_the_angle_follows_are_no_spikes() -> None:
    torque = np.zeros(100)
    torque[12::25] = [10.0, -10.0, 10.0, -10.0]
    angle = 100 * torque + np.random.default_rng(0).normal(0, 2, 100)
    assert check(SUBJECT, {"torque_Nm": torque, "elastic_angle_arcsec": angle}).state == "good"


def test_a_short_run_may_have_one_odd_reading() -> None:
    columns = {name: values[:17] for name, values in ramps(10, runs=1).items()}
    columns["elastic_angle_arcsec"][6] += 6000.0
    assert "row 7" in check(SUBJECT, columns).finding


def test_friction_is_no_offset_of_runs() -> None:
    up = np.linspace(-10, 10, 41)
    torque = np.r_[up, up[::-1]]
    noise = np.random.default_rng(0).normal(0, 0.3, 82)
    columns = {
        "run": np.repeat([1.0, 2.0], 41),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 10 * torque + np.repeat([-5.0, 5.0], 41) + noise,
    }
    assert check("zeros of runs", columns, SPRING).state == "good"


@pytest.mark.parametrize("each", [2, 3, 5])
def test_steps_that_are_held_are_no_scatter_of_the_torque(each: int) -> None:
    levels = np.r_[0:8, 8:-8:-1, -8:9].astype(np.float64)
    torque = np.tile(np.repeat(levels, each), 3)
    torque = torque + np.random.default_rng(1).normal(0, 0.02, len(torque))
    columns = {
        "run": np.repeat([1.0, 2.0, 3.0], len(levels) * each),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 100 * torque,
    }
    assert check("noise of the torque", columns).state == "good"
