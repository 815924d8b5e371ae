"""Property: what a torque sensor scatters while the torque is held is its own, unless the angle
follows it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.diagnosis.held_torque import _levels as levels
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.readings.readings import Readings
from common.comparisons import EXAMPLES
from common.springs import Reducer, loops

Floats = NDArray[np.float64]
CASE = EXAMPLES / "campaign.toml"
TABLE = cbpt.read_readings(EXAMPLES / "campaign.csv")
PER_HOLD = 8
SCATTER_Nm = 0.15


def held(levels_Nm: Floats) -> Readings:
    """Two runs of holds at these torques."""
    torque = np.repeat(np.tile(levels_Nm, 2), PER_HOLD)
    run = np.repeat([1, 2], PER_HOLD * len(levels_Nm))
    return replace(
        TABLE.select(np.arange(len(torque))),
        run=run,
        time_s=np.arange(0.0, 10.0 * len(torque), 10.0),
        torque_Nm=torque,
        preload_N=np.full(len(torque), 600.0),
        input_angle_deg=np.zeros(len(torque)),
        elastic_angle_arcsec=np.zeros(len(torque)),
    )


def scattered(rows: Readings, seed: int) -> Readings:
    noise = SCATTER_Nm * np.random.default_rng([7, seed]).standard_normal(len(rows))
    return replace(rows, torque_Nm=rows.torque_Nm + noise)


LEVELS_Nm = np.array([4.0, -2.5, 5.0, 1.5, -4.0, 3.0])


@pytest.mark.parametrize("seed", range(3))
def test_scatter_of_the_sensor_is_no_friction(seed: int) -> None:
    """What goes by the sense of loading follows that of the scatter."""
    read = cbpt.simulate(CASE, held(LEVELS_Nm), u_elastic_angle_arcsec=0.5, seed=seed)
    found = cbpt.diagnose(CASE, scattered(read, seed))
    assert found.verdict.kind in ("complete", "rig", "ambiguous"), found.sentence
    assert found.verdict.effects == ()
    assert any("while the torque is held" in note for note in found.notes)


def test_rows_show_the_torques_of_the_table_and_those_that_were_used() -> None:
    read = cbpt.simulate(CASE, held(LEVELS_Nm), u_elastic_angle_arcsec=0.5, seed=1)
    table = scattered(read, 1)
    names, rows = cbpt.diagnose(CASE, table).rows()
    shown = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    np.testing.assert_array_equal(shown["torque_Nm"], table.torque_Nm)
    per_hold = np.reshape(shown["torque_used_Nm"], (-1, PER_HOLD))
    np.testing.assert_array_equal(per_hold, np.repeat(per_hold[:, :1], PER_HOLD, axis=1))
    names, _ = cbpt.compare(CASE, table).rows()
    assert "torque_used_Nm" not in names


@pytest.mark.parametrize("seed", range(3))
def test_levels_that_come_again_have_one_torque(seed: int) -> None:
    """Loops by dead weights through the same five levels, one reading each, and a torque sensor
    that scatters. About each level what is left is a function of the torque that was read, so an
    effect without a name was certain."""
    steps = np.array([0.0, 3.0, 6.0, 3.0, 0.0, -3.0, -6.0, -3.0, 0.0])
    runs = 24
    preload = np.repeat(np.tile([400.0, 600.0, 900.0], 8), len(steps))
    table = {
        "run": np.repeat(np.arange(1.0, runs + 1), len(steps)),
        "time_s": np.arange(float(runs * len(steps))) * 5,
        "torque_Nm": np.tile(steps, runs),
        "preload_N": preload,
        "input_angle_deg": np.repeat(np.arange(runs) * 15.0 % 360, len(steps)),
        "elastic_angle_arcsec": np.zeros(runs * len(steps)),
    }
    read = cbpt.simulate(
        CASE, cbpt.read_readings(table), u_elastic_angle_arcsec=0.2, seed=seed, noise="white"
    )
    found = cbpt.diagnose(CASE, scattered(read, seed))
    assert found.verdict.kind in ("complete", "rig"), found.sentence
    assert found.verdict.effects == ()
    assert any("about the levels that it is set to" in note for note in found.notes)


def test_levels_of_loops_of_three_sizes_are_no_scatter_of_one() -> None:
    """Loops in eight steps to 17.5, 26.6 and 35.6 N m, as preloads of three sizes allow: levels of
    different loops are within 2 % of each other, and each comes again exactly in its own."""
    shares = np.concatenate([np.arange(0, 8), np.arange(8, -8, -1), np.arange(-8, 1)]) / 8
    torque = np.round(np.outer(np.repeat([17.5, 26.6, 35.6], 4), shares).ravel(), 4)
    readings = cbpt.read_readings(
        {
            "run": np.repeat(np.arange(1.0, 13.0), len(shares)),
            "torque_Nm": torque,
            "preload_N": np.repeat([838.0, 1270.0, 1701.0], 4 * len(shares)),
            "elastic_angle_arcsec": np.zeros(len(torque)),
        }
    )
    campaign = campaign_of(cbpt.Case.from_file(CASE), readings, [])
    assert not levels(campaign)[1].any()
    rough = torque + 0.02 * np.random.default_rng(1).standard_normal(len(torque))
    for shown in (rough, np.round(rough, 2), np.round(rough / 0.05) * 0.05):  # and by a display
        assert levels(replace(campaign, readings=replace(readings, torque_Nm=shown)))[1].any()


@pytest.mark.parametrize(("slow_Nm", "fast_Nm"), [(0.02, 0.02), (0.05, 0.05), (0.001, 0.03)])
def test_levels_that_are_overshot_stay_as_they_were_read(slow_Nm: float, fast_Nm: float) -> None:
    """Each level has one torque from below and another from above, and where a sensor is late, in
    fast runs more than in slow ones. Their mean took away a part of the friction that the drive
    has, or all that the sensor does."""
    steps = np.array([0.0, 3.0, 6.0, 3.0, 0.0, -3.0, -6.0, -3.0, 0.0])
    runs = 24
    sense = np.tile(np.sign(np.diff(steps, prepend=-1.0)), runs)
    jitter = 0.002 * np.random.default_rng(3).standard_normal(len(sense))
    off_Nm = np.repeat(np.where(np.arange(runs) % 2, fast_Nm, slow_Nm), len(steps))
    torque = np.tile(steps, runs) + off_Nm * sense + jitter
    table = {
        "run": np.repeat(np.arange(1.0, runs + 1), len(steps)),
        "torque_Nm": torque,
        "preload_N": np.repeat(np.tile([400.0, 600.0, 900.0], 8), len(steps)),
        "input_angle_deg": np.repeat(np.arange(runs) * 15.0 % 360, len(steps)),
        "elastic_angle_arcsec": np.zeros(len(torque)),
    }
    friction = ("friction_hysteresis", {"friction_torque_Nm": 0.1, "engagement_angle_rad": 1e-6})
    rows = cbpt.read_readings(table)
    read = cbpt.simulate(CASE, rows, u_elastic_angle_arcsec=0.2, effects=[friction], noise="white")
    found = cbpt.diagnose(CASE, read)
    np.testing.assert_array_equal(found.readings.torque_Nm, torque)


STAIRS_Nm = np.concatenate([np.arange(0.0, 11.0), np.arange(9.0, -11.0, -1), np.arange(-9.0, 1.0)])


@pytest.mark.parametrize("per_hold", [2, 3, 4])
@pytest.mark.parametrize("seed", range(2))
def test_holds_of_a_few_readings_are_told_by_the_angle(per_hold: int, seed: int) -> None:
    """Stairs of a spring, with a step of the torque six times what its sensor scatters: the holds
    were not found, and it was friction or an effect without a name for certain."""
    torque = np.tile(np.repeat(STAIRS_Nm, per_hold), 2)
    rng = np.random.default_rng([11, per_hold, seed])
    table = {
        "run": np.repeat([1, 2], len(torque) // 2),
        "time_s": 5.0 * np.arange(len(torque)),
        "torque_Nm": torque + rng.standard_normal(len(torque)) / 6,
        "elastic_angle_arcsec": 30.0 * torque + 3.0 * rng.standard_normal(len(torque)),
        "u_elastic_angle_arcsec": np.full(len(torque), 3.0),
    }
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 2.0}}
    found = cbpt.diagnose(spring, table)
    assert (found.verdict.effects, found.verdict.rivals) == ((), ()), found.sentence
    assert found.verdict.kind in ("complete", "rig"), found.sentence
    assert any("while the torque is held" in note for note in found.notes)


def test_steps_that_are_all_large_end_no_diagnosis() -> None:
    """An angle that is one reading late jumps where the torque does not."""
    torque = np.repeat(STAIRS_Nm, 2)
    noise = np.random.default_rng(1).standard_normal(len(torque) - 1)
    table = {
        "torque_Nm": torque[1:],
        "elastic_angle_arcsec": 30.0 * torque[:-1] + 0.1 * noise,
        "u_elastic_angle_arcsec": np.full(len(torque) - 1, 3.0),
    }
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 2.0}}
    np.testing.assert_array_equal(cbpt.diagnose(spring, table).readings.torque_Nm, torque[1:])


@pytest.mark.parametrize("digit_Nm", [0.1, 0.2])
def test_a_digit_of_the_torque_ends_no_hold(digit_Nm: float) -> None:
    torque = np.tile(np.repeat(STAIRS_Nm, 6), 2)
    rng = np.random.default_rng(3)
    scattered_Nm = torque + 0.4 * digit_Nm * rng.standard_normal(len(torque))
    table = {
        "run": np.repeat([1, 2], len(torque) // 2),
        "time_s": 5.0 * np.arange(len(torque)),
        "torque_Nm": np.round(scattered_Nm / digit_Nm) * digit_Nm,
        "elastic_angle_arcsec": 30.0 * torque + 3.0 * rng.standard_normal(len(torque)),
        "u_elastic_angle_arcsec": np.full(len(torque), 3.0),
    }
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 2.0}}
    verdict = cbpt.diagnose(spring, table).verdict
    assert (verdict.effects, verdict.rivals) == ((), ()), verdict


def test_a_late_torque_sensor_is_not_averaged() -> None:
    """In each hold its first readings lag behind the step: no scatter, and no mean torque."""
    torque = np.tile(np.repeat(STAIRS_Nm, 3), 2)
    late = torque - 0.7 * np.where(np.arange(len(torque)) % 3 == 0, np.diff(torque, prepend=0.0), 0)
    rng = np.random.default_rng(5)
    shown = late + 0.05 * rng.standard_normal(len(torque))
    table = {
        "run": np.repeat([1, 2], len(torque) // 2),
        "torque_Nm": shown,
        "elastic_angle_arcsec": 30.0 * torque + 3.0 * rng.standard_normal(len(torque)),
        "u_elastic_angle_arcsec": np.full(len(torque), 3.0),
    }
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 2.0}}
    np.testing.assert_array_equal(cbpt.diagnose(spring, table).readings.torque_Nm, shown)


@pytest.mark.parametrize("seed", range(3))
def test_the_error_of_a_mean_torque_is_no_effect(seed: int) -> None:
    """It moves the readings of a hold together, by more than they scatter."""
    read = cbpt.simulate(CASE, held(LEVELS_Nm), u_elastic_angle_arcsec=0.03, seed=seed)
    found = cbpt.diagnose(CASE, scattered(read, seed))
    assert found.verdict.effects == (), found.sentence


def test_small_loops_that_friction_holds_stay_loops() -> None:
    """The angle follows none of their torques, and yet nothing scatters."""
    reducer = Reducer(friction_Nm=2.0, engagement_rad=3e-4)
    parts = [loops([reducer] * 2)]
    parts += [loops([reducer], rows=9, peak_Nm=1.5, seed=10 + k) for k in range(4)]
    parts = [{c: part[c] for c in ("time_s", "torque_Nm", "elastic_angle_rad")} for part in parts]
    table = {c: np.concatenate([part[c] for part in parts]) for c in parts[0]}
    table["run"] = np.r_[np.repeat([1, 2], 64), np.repeat([3, 4, 5, 6], 9)]
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_rad": 2000.0}}
    found = cbpt.diagnose(spring, table)
    np.testing.assert_array_equal(found.readings.torque_Nm, table["torque_Nm"])


def test_a_torque_that_scatters_itself_stays_as_it_was_read() -> None:
    rows = scattered(held(LEVELS_Nm), 1)
    read = cbpt.simulate(CASE, rows, u_elastic_angle_arcsec=0.5, seed=1)
    found = cbpt.diagnose(CASE, read)
    assert found.verdict.kind == "complete"
    np.testing.assert_array_equal(found.readings.torque_Nm, rows.torque_Nm)
