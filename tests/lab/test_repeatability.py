"""The uncertainty of a reading from repeats.

Groups: identities of the estimate; how often it is right; what is not counted as a repeat; what
comparison and diagnosis say of it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.covariance.repeatability import (
    Repeats,
    independent_share,
    no_uncertainty_of,
    pooled,
)
from cbpt.lab.covariance.within_run import estimate
from cbpt.lab.readings.reader import Readings, read_readings
from cbpt.results import solve_many

Floats = NDArray[np.float64]
LOOP = np.r_[np.linspace(0, 4, 9), np.linspace(3.5, -4, 16), np.linspace(-3.5, 0, 8)]


@cache
def campaign(runs: int = 3, preloads: tuple[float, ...] = (400.0,)) -> Readings:
    """A loop of the torque in every run, each preload in `runs` of them; no uncertainty stated."""
    n = len(preloads) * runs
    torque, preload = np.tile(LOOP, n), np.repeat(np.tile(preloads, runs), len(LOOP))
    drive = cbpt.Drive.from_toml(cbpt.example_case())
    return read_readings(
        {
            "run": np.repeat(np.arange(n), len(LOOP)),
            "torque_Nm": torque,
            "preload_N": preload,
            "elastic_angle_arcsec": solve_many(drive, torque, preload).elastic_angle_arcsec,
        }
    )


def noisy(readings: Readings, u: float, seed: int = 0) -> Readings:
    noise = u * np.random.default_rng(seed).standard_normal(len(readings))
    return replace(readings, elastic_angle_arcsec=readings.elastic_angle_arcsec + noise)


def found(readings: Readings, residual: Floats) -> Repeats:
    repeats = pooled(readings, residual)
    assert repeats is not None
    return repeats


# --- identities ---------------------------------------------------------------------------


def test_two_readings_of_a_condition_are_their_difference() -> None:
    """Two runs and one preload: u^2 is half the variance of the differences."""
    readings = campaign(2)
    e = np.random.default_rng(1).normal(0, 0.3, len(readings))
    repeats = found(readings, e)
    difference = e[: len(LOOP)] - e[len(LOOP) :]
    assert repeats.u_arcsec == pytest.approx(difference.std(ddof=1) / np.sqrt(2), rel=1e-12)
    assert repeats.dof == len(LOOP) - 1
    assert (repeats.conditions, repeats.readings) == (len(LOOP), 2 * len(LOOP))


def test_neither_what_a_condition_misses_nor_a_zero_counts() -> None:
    readings = campaign(3, (300.0, 500.0))
    rng = np.random.default_rng(2)
    e = rng.normal(0, 0.3, len(readings))
    zero = rng.normal(0, 5, readings.run_index.max() + 1)[readings.run_index]
    misfit = np.sin(readings.torque_Nm) + 0.01 * np.asarray(readings.preload_N)
    moved = found(readings, e + zero + misfit)
    assert moved.u_arcsec == pytest.approx(found(readings, e).u_arcsec, rel=1e-9)
    # Every condition in three runs, the zeros of three runs a preload less the one that they share.
    assert moved.dof == len(readings) - 2 * len(LOOP) - 2 * 2


def test_a_stated_uncertainty_is_weighed() -> None:
    readings = campaign(2)
    e = np.random.default_rng(3).normal(0, 0.3, len(readings))
    stated = replace(readings, u_elastic_angle_arcsec=np.full(len(readings), 0.1))
    plain, weighed = found(readings, e), found(stated, e)
    assert plain.ratio is None and weighed.ratio is not None
    assert weighed.u_arcsec == pytest.approx(plain.u_arcsec, rel=1e-12)
    assert weighed.ratio == pytest.approx(plain.u_arcsec / 0.1, rel=1e-12)


# --- how often it is right ----------------------------------------------------------------


def test_the_variance_is_unbiased_and_known_as_well_as_told() -> None:
    readings = campaign(3)
    rng = np.random.default_rng(4)
    all_found = [found(readings, rng.normal(0, 0.25, len(readings))) for _ in range(300)]
    variance = np.array([each.u_arcsec**2 for each in all_found]) / 0.25**2
    dof = all_found[0].dof
    assert abs(variance.mean() - 1) < 4 * np.sqrt(2 / dof / len(variance))
    # The spread of a chi-squared with as many degrees of freedom, to a fifth.
    assert variance.std() == pytest.approx(np.sqrt(2 / dof), rel=0.2)


def test_steady_repeats_are_taken_for_steady() -> None:
    readings = campaign(4)
    rng = np.random.default_rng(5)
    for _ in range(60):
        e = rng.normal(0, 0.3, len(readings))
        repeats = pooled(readings, e, estimate(readings, e))
        assert repeats is not None and repeats.steady


def test_repeats_between_which_something_changes_are_told() -> None:
    """A loop that opens from run to run: smooth inside a run, so no scatter of the readings."""
    readings = campaign(4)
    e = np.random.default_rng(6).normal(0, 0.05, len(readings))
    e += (1.0 + readings.run_index) * np.asarray(readings.torque_Nm) / 4
    repeats = pooled(readings, e, estimate(readings, e))
    assert repeats is not None and not repeats.steady


# --- what is no repeat --------------------------------------------------------------------


def test_why_repeats_tell_no_uncertainty() -> None:
    """Not that nothing was repeated, where it was."""
    repeats = Repeats(2.0, None, 12.0, 6, 18, steady=False)
    assert "taken again" in no_uncertainty_of(None)
    assert "taken again" not in no_uncertainty_of(repeats)
    assert "18 readings repeated" in no_uncertainty_of(repeats)


def test_one_run_with_one_loop_has_no_repeats() -> None:
    readings = campaign(1)
    assert pooled(readings, np.zeros(len(readings))) is None


def test_the_two_legs_of_a_loop_are_different_conditions() -> None:
    """Rising and falling differ by 6 arcsec, which is friction and no uncertainty."""
    readings = campaign(3)
    e = np.random.default_rng(7).normal(0, 0.1, len(readings))
    assert found(readings, e + 3.0 * readings.direction()).u_arcsec < 0.15


def test_loading_for_the_first_time_stands_apart() -> None:
    """0 to 4 N m comes again at the end of a second loop in the run, which is another thing."""
    torque = np.r_[LOOP, LOOP[1:], LOOP[1:]]
    table = {"torque_Nm": torque, "preload_N": 0 * torque + 400.0, "alpha_arcsec": torque}
    readings = read_readings(table)
    e = np.random.default_rng(8).normal(0, 0.1, len(readings))
    e[: np.argmax(torque) + 1] += 5.0
    assert found(readings, e).u_arcsec < 0.15


def test_loops_of_other_amplitudes_are_no_repeats_where_friction_holds_them() -> None:
    """Small loops inside large ones were a rig that changes between its repeats."""
    loops = [2 * LOOP, 2 * LOOP, LOOP, LOOP]
    torque = np.concatenate(loops)
    rng = np.random.default_rng(3)
    noise = 0.1 * rng.standard_normal(len(torque))
    # From rest all go the same way, and turn back where they turn.
    way = np.concatenate([np.sign(np.diff(loop, prepend=-99)) for loop in loops])
    way[np.tile(np.arange(len(LOOP)) < 9, 4)] = 0
    residual = noise + np.repeat([3.0, 3.0, 1.0, 1.0], len(LOOP)) * way
    rows = {
        "run": np.repeat(np.arange(4), len(LOOP)),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 7 * torque + residual,
    }
    readings = read_readings(rows, need_preload=False)
    repeats = pooled(readings, residual, estimate(readings, noise))
    assert repeats is not None and repeats.steady
    assert repeats.u_arcsec == pytest.approx(0.1, rel=0.3)


def test_readings_that_agree_in_every_digit_say_nothing() -> None:
    readings = campaign(3)
    assert pooled(readings, readings.torque_Nm) is None


def test_a_torque_that_is_held_with_jitter_is_one_level() -> None:
    rng = np.random.default_rng(9)
    readings = campaign(3)
    jitter = replace(readings, torque_Nm=readings.torque_Nm + rng.normal(0, 0.003, len(readings)))
    assert found(jitter, rng.normal(0, 0.3, len(readings))).conditions > 20


# --- what is said of it -------------------------------------------------------------------


@cache
def case() -> cbpt.Case:
    return cbpt.Case.from_toml(cbpt.example_case())


def test_the_comparison_judges_by_repeats() -> None:
    c = cbpt.compare(case(), noisy(campaign(), 0.2))
    assert c.u_from == "repeats" and c.repeats is not None
    assert c.p_value_of_repeats is not None and c.p_value_of_repeats > 0.01
    document = c.to_dict()
    assert document["u_from"] == "repeats"
    assert document["repeats"]["u_arcsec"] == pytest.approx(0.2, rel=0.3)
    assert "The uncertainty was estimated from repeated readings: 0." in c.report()
    assert "With this uncertainty the model agrees with the readings." in c.report()
    bent = noisy(campaign(), 0.2)
    bent = replace(bent, elastic_angle_arcsec=bent.elastic_angle_arcsec * 1.1)
    assert (
        "With this uncertainty the model disagrees with the readings."
        in cbpt.compare(case(), bent).report()
    )


def test_the_comparison_says_what_it_judges_by() -> None:
    readings = noisy(campaign(1), 0.2)
    assert cbpt.compare(case(), readings).u_from == "scatter"
    stated = replace(readings, u_elastic_angle_arcsec=np.full(len(readings), 0.2))
    assert cbpt.compare(case(), stated).u_from == "stated"
    assert (
        "Repeated readings agree to"
        in cbpt.compare(
            case(), replace(noisy(campaign(), 0.2), u_elastic_angle_arcsec=np.full(99, 0.2))
        ).report()
    )


def noise_of(readings: Readings) -> Any:
    answer = cbpt.diagnose(case(), readings)
    noise = answer.to_dict()["noise"]
    assert noise["u_says"].split("(")[0] in " ".join(answer.report().split())
    return noise


def test_the_diagnosis_says_what_it_judges_by() -> None:
    noise = noise_of(noisy(campaign(), 0.2))
    assert (noise["u_from"], noise["u_stated_arcsec"]) == ("repeats", None)
    assert noise["u_estimated_arcsec"] == pytest.approx(0.2, rel=0.25)
    assert noise["repeats"]["dof"] == 3 * len(LOOP) - len(LOOP) - 2
    assert "estimated from repeated readings" in noise["u_says"] and noise["u_dof"] > 60
    noise = noise_of(noisy(campaign(1), 0.2))
    assert (noise["u_from"], noise["repeats"]) == ("scatter", None)
    assert "was estimated: the residuals of the answer" in noise["u_says"]


# --- readings of one hold -----------------------------------------------------------------


def held(u: float | None = 0.1, runs: int = 4, visits: int = 12, each: int = 3) -> Readings:
    """A staircase of the torque, each torque held for some readings."""
    torque = np.repeat(np.r_[np.linspace(0, 4, visits // 2), np.linspace(4, 0, visits // 2)], each)
    table = {
        "run": np.repeat(np.arange(runs), len(torque)),
        "torque_Nm": np.tile(torque, runs),
        "preload_N": np.repeat(400.0 + 100.0 * np.arange(runs), len(torque)),
        "elastic_angle_arcsec": np.tile(torque, runs),
    }
    stated = {} if u is None else {"u_elastic_angle_arcsec": np.full(runs * len(torque), u)}
    return read_readings(table | stated)


def slow(readings: Readings, correlation: float, seed: int) -> Floats:
    """Noise of standard deviation 1, each reading alike to the one before it in its run."""
    rng = np.random.default_rng(seed)
    e = rng.standard_normal(len(readings))
    first = np.r_[True, np.diff(readings.run_index) != 0]
    for i in np.flatnonzero(~first):
        e[i] = correlation * e[i - 1] + (1 - correlation**2) ** 0.5 * e[i]
    return e


@pytest.mark.parametrize("correlation", [0.0, 0.4, 0.8])
def test_repeats_show_a_share_of_noise_that_moves_slowly(correlation: float) -> None:
    """Its variance over the share is that of the noise, whatever the holds have of it."""
    readings = held(None, runs=6)
    share = independent_share(readings, correlation)
    squares = [found(readings, slow(readings, correlation, s)).u_arcsec ** 2 for s in range(60)]
    assert np.mean(squares) / share == pytest.approx(1.0, rel=0.08)
    # In a hold of three; the two at the largest torque are one hold of six.
    assert share == pytest.approx(1 - (4 * correlation + 2 * correlation**2) / 6, rel=0.05)


def test_repeats_far_apart_show_all_of_it() -> None:
    assert independent_share(campaign(3), 0.8) == pytest.approx(1.0, abs=0.01)


def test_what_opens_between_repeats_is_no_scatter() -> None:
    """Every torque is held in two runs alike, and between them something gives by ten times what
    the holds scatter by and is stated; without the holds' word it is scatter."""
    twice = held(0.1, runs=2)
    assert twice.preload_N is not None
    twice = replace(twice, preload_N=np.full(len(twice), 400.0))
    noise = 0.1 * np.random.default_rng(3).standard_normal(len(twice))
    opened = noise + np.where(twice.run_index == 1, 0.5 * np.sign(twice.torque_Nm - 2), 0.0)
    assert not found(twice, opened).steady
    assert found(twice, noise).steady
    # Noise that moves slowly is alike in a hold as well, but no larger than stated.
    assert found(twice, 0.1 * slow(twice, 0.9, 1)).steady


def test_slow_noise_of_a_staircase_is_no_missing_effect() -> None:
    """Its holds agree to half of what the readings scatter by: that is no rest."""
    drive = cbpt.Drive.from_toml(cbpt.example_case())
    readings = held(0.1)
    assert readings.preload_N is not None
    angle = solve_many(drive, readings.torque_Nm, readings.preload_N).elastic_angle_arcsec
    read = replace(readings, elastic_angle_arcsec=angle + 0.1 * slow(readings, 0.75, 5))
    answer = cbpt.diagnose(drive, read)
    said = answer.to_dict()
    assert said["verdict"]["kind"] in ("complete", "rig") and said["remains"] is None
