"""Loggers with a clock: the torque turns back between readings, which may be means over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.diagnosis.diagnose import prepared
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.selection.fit_effects import Fits, predicted
from cbpt.lab.selection.turning import with_their_turns

Floats = NDArray[np.float64]
SPRING = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "uncertainty": {"contact_stiffness_rel": 0.1},
}
FRICTION = {
    "id": "friction_hysteresis",
    "friction_torque_Nm": 0.8,
    "engagement_angle_arcsec": 15.0,
}
BLOCK = 10
"""Samples of the fast logger for each reading of the slow one."""


def _table(run: Floats, time_s: Floats, torque_Nm: Floats, angle_arcsec: Floats) -> cbpt.Readings:
    rows = {
        "run": run,
        "time_s": time_s,
        "torque_Nm": torque_Nm,
        "elastic_angle_arcsec": angle_arcsec,
    }
    return cbpt.read_readings(rows, need_preload=False)


@cache
def _fast() -> cbpt.Readings:
    """Three runs of two loops at one rate, each of another size, by a fast logger."""
    runs = list[tuple[Floats, Floats, Floats]]()
    for run, amplitude in enumerate([9.1, 8.3, 9.7]):
        turns = amplitude * np.array([0, 1, -1, 1, -1, 0])
        ends = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))]) / 8.3
        count = int(ends[-1] / 0.02) // BLOCK * BLOCK
        time_s: Floats = 0.02 * np.arange(count, dtype=np.float64)
        torque: Floats = np.interp(time_s, ends, turns)
        runs.append((np.full(count, 1.0 + run), time_s + 1000 * run, torque))
    columns = [np.concatenate(column) for column in zip(*runs, strict=True)]
    table = _table(columns[0], columns[1], columns[2], np.zeros(len(columns[0])))
    angle = predicted(case_of(SPRING | {"effect": [FRICTION]}), table).elastic_angle_arcsec
    return replace(table, elastic_angle_arcsec=angle)


def _slow(means: bool) -> cbpt.Readings:
    """What a slow logger makes of it: means of blocks, or one sample of each."""

    def of(column: Floats) -> Floats:
        blocks = column.reshape(-1, BLOCK)
        return np.asarray(blocks.mean(axis=1) if means else blocks[:, 3])

    fast = _fast()
    assert fast.time_s is not None
    run = np.asarray(fast.run_index, dtype=np.float64)
    columns = of(run), of(fast.time_s), of(fast.torque_Nm), of(fast.elastic_angle_arcsec)
    return _table(*columns)


@pytest.mark.parametrize("means", [False, True])
def test_friction_that_turned_back_between_readings_is_no_damper(means: bool) -> None:
    """Before, both were named for certain."""
    slow = _slow(means)
    noise = np.random.default_rng(3).normal(0, 2.0, len(slow))
    table = replace(
        slow,
        elastic_angle_arcsec=slow.elastic_angle_arcsec + noise,
        u_elastic_angle_arcsec=np.full(len(slow), 2.0),
    )
    answer = cbpt.diagnose(SPRING, table)
    found = answer.verdict
    assert found.effects == ("friction_hysteresis",) and not found.rivals
    note = next(note for note in answer.notes if "reversed between readings" in note)
    assert ("are means over time" in note) == means


def test_samples_are_those_of_the_fast_logger() -> None:
    slow = _slow(means=False)
    there = predicted(case_of(SPRING | {"effect": [FRICTION]}), slow).elastic_angle_arcsec
    assert there == pytest.approx(slow.elastic_angle_arcsec, abs=1e-6)


def test_means_are_those_of_the_fast_logger() -> None:
    """But for how much the loop bends within a block, of some 900 arcsec."""
    slow = _slow(means=True)
    there = predicted(case_of(SPRING | {"effect": [FRICTION]}), slow).elastic_angle_arcsec
    assert there == pytest.approx(slow.elastic_angle_arcsec, abs=4)


def test_a_table_without_times_turns_at_its_readings() -> None:
    slow = replace(_slow(means=True), time_s=None)
    answer = predicted(case_of(SPRING | {"effect": [FRICTION]}), slow)
    assert np.abs(answer.elastic_angle_arcsec - _slow(means=True).elastic_angle_arcsec).max() > 10


@pytest.mark.parametrize("means_first", [False, True])
def test_another_logger_is_no_change(means_first: bool) -> None:
    tables = [_slow(means) for means in (means_first, not means_first)]
    noisy = []
    for seed, table in enumerate(tables):
        noise = np.random.default_rng(seed).normal(0, 2.0, len(table))
        noisy.append(replace(table, elastic_angle_arcsec=table.elastic_angle_arcsec + noise))
    found = cbpt.change(SPRING, *noisy, effects=["friction_hysteresis"])
    assert found.kind == "nothing", found.sentence


def test_the_readings_say_that_the_torque_turned_back_at_them() -> None:
    """As simulations have it that go from reading to reading, and rigs that hold each torque."""
    slow = _slow(means=False)
    held = SPRING | {"effect": [FRICTION], "measurement": {"torque_turns": "at_readings"}}
    angle = predicted(case_of(held), slow).elastic_angle_arcsec
    noise = np.random.default_rng(3).normal(0, 2.0, len(slow))
    u = np.full(len(slow), 2.0)
    table = replace(slow, elastic_angle_arcsec=angle + noise, u_elastic_angle_arcsec=u)
    answer = cbpt.diagnose(SPRING, table)
    assert answer.verdict.effects == ("friction_hysteresis",)
    assert any("if the torque reversed at them" in note for note in answer.notes)
    fitted = cbpt.fit(SPRING, table, effects=["friction_hysteresis"])
    assert fitted.case.torque_turns == "at_readings"
    overall = cbpt.compare(fitted.case, table).overall
    assert overall and overall.rmse_arcsec == pytest.approx(2.0, rel=0.2)


def test_a_list_of_torques_that_are_set_is_no_ramp() -> None:
    """Its last step below the top is half of the others, as if a clock had met the turn there."""
    up = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 45.0, 35.0, 25.0, 15.0, 5.0, -5.0, -15.0, -25.0]
    torque = np.array(3 * [*up, -35.0, -45.0, -50.0, -40.0, -30.0, -20.0, -10.0])
    nothing = np.zeros(len(torque))
    table = _table(nothing + 1, 4.0 * np.arange(len(torque), dtype=np.float64), torque, nothing)
    case = SPRING | {"effect": [FRICTION]}
    held = case_of(case | {"measurement": {"torque_turns": "at_readings"}})
    there = predicted(held, table).elastic_angle_arcsec
    assert predicted(case_of(case), table).elastic_angle_arcsec == pytest.approx(there, abs=1e-9)


@cache
def _alike(count: int, friction_Nm: float) -> cbpt.Readings:
    """Loops of one length, so every turn meets the clock alike: of 50 readings a quarter of a step
    beside one, of 51 halfway between two equal torques."""
    fine = 40
    ends, turns = np.array([0.0, 1.0, 3.0, 4.0]), 30.0 * np.array([0.0, 1.0, -1.0, 0.0])
    loop = np.linspace(0.0, 4.0, fine * (count - 1) + 1)
    run = np.repeat([1.0, 2.0], len(loop))
    time_s = np.concatenate([15.0 * loop, 15.0 * loop + 100.0])
    table = _table(run, time_s, np.tile(np.interp(loop, ends, turns), 2), np.zeros(len(run)))
    friction = {"friction_torque_Nm": friction_Nm, "engagement_angle_arcsec": 70.0}
    case = case_of(SPRING | {"effect": [FRICTION | friction]})
    angle = predicted(case, table).elastic_angle_arcsec
    kept = np.arange(len(run)) % len(loop) % fine == 0
    noise = np.random.default_rng(count).normal(0, 3.0, np.count_nonzero(kept))
    read = [np.asarray(column)[kept] for column in (run, time_s, table.torque_Nm, angle)]
    return _table(read[0], read[1], read[2], read[3] + noise)


@pytest.mark.parametrize("count", [50, 51])
def test_turns_that_all_meet_the_clock_alike_are_asked_for(count: int) -> None:
    """Before, the torque turned back at the nearest readings, and what that leaves was named."""
    answer = cbpt.diagnose(SPRING, _alike(count, 1.34))
    assert answer.verdict.effects == ("friction_hysteresis",) and not answer.verdict.rivals
    assert any("Friction follows the readings better then" in note for note in answer.notes)
    fitted = cbpt.fit(SPRING, _alike(count, 1.34), effects=["friction_hysteresis"])
    assert fitted.case.torque_turns == "between_readings"
    overall = cbpt.compare(fitted.case, _alike(count, 1.34)).overall
    assert overall and overall.rmse_arcsec == pytest.approx(3.0, rel=0.2)


@pytest.mark.parametrize("clock", ["whole seconds", "none"])
def test_readings_are_counted_where_times_are_rounded_or_missing(clock: str) -> None:
    """Before, friction of 0.6 N m was 0.2 N m, or not named, beside effects that are not there."""
    fine = _fine(0.6, [0, 20, -20, 20, -20, 0], 0.01)
    assert fine.time_s is not None
    kept = np.arange(0, len(fine), 137)
    run, torque, angle = fine.run_index[kept], fine.torque_Nm[kept], fine.elastic_angle_arcsec[kept]
    noise = np.random.default_rng(1).normal(0, 2.0, len(kept))
    runs = np.asarray(run + 1.0, dtype=np.float64)
    table = _table(runs, np.round(fine.time_s[kept]), torque, angle + noise)
    if clock == "none":
        table = replace(table, time_s=None)
    answer = cbpt.diagnose(SPRING, table)
    assert answer.verdict.effects == ("friction_hysteresis",) and not answer.verdict.rivals
    found = answer.parameters(answer.after, "friction_hysteresis")["friction_torque_Nm"]
    assert found["value"] == pytest.approx(0.6, abs=3.3 * found["u"])
    assert any("reversed between readings" in note for note in answer.notes)


def _fine(friction_Nm: float, turns: list[float], step_s: float) -> cbpt.Readings:
    """What a fast logger reads at 1 N m/s."""
    ends = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
    time_s = np.arange(0.0, ends[-1] + 1e-9, step_s)
    table = _table(np.ones(len(time_s)), time_s, np.interp(time_s, ends, turns), 0 * time_s)
    friction = {"friction_torque_Nm": friction_Nm, "engagement_angle_arcsec": 30.0}
    case = case_of(SPRING | {"effect": [FRICTION | friction]})
    return replace(table, elastic_angle_arcsec=predicted(case, table).elastic_angle_arcsec)


def test_a_friction_that_fell_is_told_by_loops_that_meet_the_clock_alike() -> None:
    """Before, a damper or a torque sensor had changed for certain, and friction had not."""
    found = cbpt.change(SPRING, _alike(51, 1.34), _alike(51, 1.139))
    (changed,) = found.changed
    assert changed.effect == "friction_hysteresis" and not changed.rivals
    for value, u, true in (
        (changed.before, changed.u_before, 1.34),
        (changed.after, changed.u_after, 1.139),
    ):
        assert u and value == pytest.approx(true, abs=3.3 * u)


@pytest.mark.parametrize("turns", ["at_readings", "between_readings"])
def test_what_the_case_says_of_the_turns_is_not_asked(turns: str) -> None:
    case = SPRING | {"measurement": {"torque_turns": turns}}

    def asked(campaigns: Sequence[Campaign]) -> list[Fits]:
        raise AssertionError(campaigns)

    (found,) = with_their_turns([campaign_of(case_of(case), _alike(50, 1.34), ())], asked)
    campaign = found.campaign
    assert campaign.torque_turns == turns and not found.note
    assert bool(Assembled(campaign, ()).turns_between_readings) == (turns == "between_readings")


def test_one_rig_has_one_logger() -> None:
    """Where no friction says so, a table whose turns meet the clock alike is as the others are."""
    tables = [_alike(50, 1.34), _slow(means=False)]
    alike, logged = (campaign_of(case_of(SPRING), table, ()) for table in tables)

    def turns(*campaigns: Campaign) -> list[bool]:
        found = with_their_turns(campaigns, lambda asked: [{} for _ in asked])
        return [bool(Assembled(one.campaign, ()).turns_between_readings) for one in found]

    assert turns(alike) == [False] and turns(alike, alike) == [False, False]
    assert turns(logged, alike) == [True, True]


def test_long_tables_keep_what_shows_their_turns() -> None:
    slow = _slow(means=True)
    assert slow.time_s is not None
    run = np.asarray(slow.run_index, dtype=np.float64)
    lap = float(slow.time_s[-1]) + 1000.0
    columns = [
        np.concatenate([run + 1 + 3 * k for k in range(10)]),
        np.concatenate([slow.time_s + lap * k for k in range(10)]),
        np.tile(slow.torque_Nm, 10),
        np.tile(slow.elastic_angle_arcsec, 10),
    ]
    table = _table(*columns)
    kept, notes = prepared(campaign_of(case_of(SPRING), table, ()))
    assert len(kept) < len(table) and any("were used for the diagnosis" in note for note in notes)
    model = Assembled(kept, ())
    assert len(model.turns_between_readings) == 120 and model.readings_are_means
