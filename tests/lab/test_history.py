"""Friction that goes on from run to run, or starts anew at each: whichever the readings show."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.model.dataset import Campaign, History
from cbpt.lab.model.forward import Assembled
from cbpt.lab.selection.history import notes_of_levels, with_its_history, with_their_history
from cbpt.lab.selection.lack_of_fit import run_time
from common.comparisons import CAMPAIGNS, drive_of
from common.friction_loops import LOOP as SPRING_LOOP
from common.friction_loops import found as changed
from common.friction_loops import loops, read_from
from common.simulated import readings_of

LOOP = np.concatenate([np.linspace(0, 5, 11), np.linspace(4.5, -5, 20), np.linspace(-4.5, 0, 10)])
FRICTION = {
    ("friction_hysteresis", "friction_radius_m"): 6e-4,
    ("friction_hysteresis", "engagement_angle_rad"): 4e-5,
}


def repeated(loops: int = 4, pause_s: float = 60.0) -> Campaign:
    """The same loop again and again at one preload and one input angle."""
    n = len(LOOP)
    table = {
        "run": np.repeat(np.arange(1, loops + 1), n),
        "time_s": np.arange(loops * n) * 2.0 + np.repeat(np.arange(loops), n) * pause_s,
        "torque_Nm": np.tile(LOOP, loops),
        "preload_N": np.full(loops * n, 600.0),
        "input_angle_deg": np.full(loops * n, 10.0),
        "elastic_angle_arcsec": np.arange(loops * n, dtype=np.float64),
        "u_elastic_angle_arcsec": np.full(loops * n, 0.3),
    }
    return Campaign.of(drive_of("dev03"), cbpt.read_readings(table))


@pytest.mark.parametrize("anew", [True, False])
def test_the_readings_say_whether_friction_goes_on(anew: bool) -> None:
    campaign = replace(repeated(), history="released" if anew else "by_clock")
    measured = readings_of(campaign, FRICTION, np.random.default_rng(3))
    found, notes = with_its_history(replace(measured, history="by_clock"))
    assert (found.history == "released") == anew
    assert [note.partition(",")[0] for note in notes] == (
        ["runs begin where the ones before them ended"] if anew else []
    )


def test_without_friction_and_without_runs_that_go_on_nothing_is_asked() -> None:
    plain = readings_of(repeated(), {}, np.random.default_rng(4))
    assert with_its_history(plain) == (plain, [])
    other = readings_of(repeated(1), FRICTION, np.random.default_rng(5))
    assert with_its_history(other) == (other, [])


def test_friction_that_starts_anew_is_friction() -> None:
    """It was creep or a lag of the torque for certain: the later runs of a table have no virgin
    loading where friction goes on."""
    campaign = replace(repeated(), history="released")
    measured = readings_of(campaign, FRICTION, np.random.default_rng(6))
    table = {
        name: getattr(measured.readings, name) for name in ("time_s", "torque_Nm", "preload_N")
    }
    table |= {
        "run": measured.readings.run_index + 1,
        "input_angle_deg": measured.readings.input_angle_deg,
        "elastic_angle_arcsec": measured.y_arcsec,
        "u_elastic_angle_arcsec": measured.u_arcsec,
    }
    answer = cbpt.diagnose(drive_of("dev03"), table)
    assert answer.verdict.effects == ("friction_hysteresis",)
    assert any("starts anew at each run" in note for note in answer.notes)


def test_of_a_torsion_spring_friction_goes_on() -> None:
    """Friction alone, without the play that is there too, followed the readings better by itself
    at the start of each run."""
    friction = {"friction_torque_Nm": 1.0, "engagement_angle_arcsec": 30.0}
    play = {"play_arcsec": 150.0, "transition_torque_Nm": 0.5}
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}}
    effects = [{"id": "friction_hysteresis"} | friction, {"id": "backlash"} | play]
    table = read_from(spring | {"effect": effects}, SPRING_LOOP)
    readings = cbpt.read_readings(table, need_preload=False)
    campaign = Campaign.of(cbpt.Case.from_dict(spring), readings)
    assert with_its_history(campaign) == (campaign, [])


def test_the_remedy_of_the_note_is_one() -> None:
    """Runs that each begin at time 0 do not go on."""
    campaign = repeated()
    at_rest = replace(campaign.readings, time_s=run_time(campaign.readings))
    assert Assembled(campaign, ()).runs_that_go_on == 3
    assert not Assembled(replace(campaign, readings=at_rest), ()).runs_that_go_on


SPRING = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.1},
    "uncertainty": {"contact_stiffness_rel": 0.1},
    "measurement": {"zero": "per_run"},
}
OF_SPRING = {
    ("friction_hysteresis", "friction_torque_Nm"): 1.0,
    ("friction_hysteresis", "engagement_angle_rad"): 1e-3,
    ("backlash", "play_rad"): 4e-3,
    ("backlash", "transition_torque_Nm"): 0.1,
}


def ramps(clocks: bool) -> Campaign:
    """Small loops and large ones of a torsion spring, each in a run; clocks: that start again."""
    loops = [scale * LOOP for scale in (1.0, 1.0, 4.0, 4.0)]
    n = len(LOOP)
    passed = np.arange(len(loops) * n) * 2.0
    table = {
        "run": np.repeat(np.arange(1, len(loops) + 1), n),
        "time_s": passed % (2.0 * n) if clocks else passed,
        "torque_Nm": np.concatenate(loops),
        "elastic_angle_arcsec": np.arange(float(len(passed))),
        "u_elastic_angle_arcsec": np.full(len(passed), 30.0),
    }
    readings = cbpt.read_readings(table, need_preload=False)
    return Campaign.of(cbpt.Case.from_dict(SPRING), readings)


REPEATED = (
    "the readings show that the first loops begin with friction of loops before them, which were "
    "not measured"
)
CARRIED = (
    "the readings show friction that goes on from run to run, though time_s does not. The case of "
    "the fit says so to cbpt compare"
)
ANEW = (
    "runs begin where the ones before them ended, but the readings show friction that starts anew "
    "at each run"
)


@pytest.mark.parametrize(
    ("clocks", "carried", "told"),
    [
        (True, True, [CARRIED]),
        (False, True, [REPEATED]),
        (True, False, []),
        (False, False, [ANEW]),
    ],
)
def test_loops_of_a_spring_say_it_too(clocks: bool, carried: bool, told: list[str]) -> None:
    """A file for each ramp has a clock for each ramp, and the friction that the last one left."""
    campaign = replace(ramps(clocks), history="carried" if carried else "released")
    measured = readings_of(campaign, OF_SPRING, np.random.default_rng(7))
    found, notes = with_its_history(replace(measured, history="by_clock"))
    assert Assembled(found, ()).runs_that_go_on == (3 if carried else 0)
    assert [note.partition(":")[0] for note in notes] == told
    # Several campaigns are of one rig.
    timed = replace(measured, history="by_clock")
    both, alike = with_their_history([timed, timed])
    assert [campaign.history for campaign in both] == 2 * [found.history]
    assert alike == [notes, notes]
    assert notes_of_levels(["before", "after"], alike) == notes


def test_each_level_begins_after_a_past_of_its_own() -> None:
    """One history for all made a play fall where only one campaign began from rest."""
    timed = ramps(clocks=False)
    rng = np.random.default_rng(7)
    known: tuple[History, ...] = "carried", "by_clock", "carried"
    measured = [readings_of(replace(timed, history=h), OF_SPRING, rng) for h in known]
    found, notes = with_their_history([replace(c, history="by_clock") for c in measured])
    assert [campaign.history for campaign in found] == [*known]
    [told] = notes_of_levels(["1", "2", "3"], notes)
    assert told.startswith(f"1 and 3, unlike 2: {REPEATED}")


def test_a_first_loading_is_no_change() -> None:
    """The same loop from rest, and after another one that was not measured."""
    both, n = loops(u=1.0), len(SPRING_LOOP)
    rest = {name: column[:n] for name, column in both.items()}
    after = {name: column[n:] for name, column in both.items()}
    answer = changed(after, rest)
    assert answer.kind == "nothing"
    assert any(note.startswith("before, unlike after: the readings show") for note in answer.notes)


@pytest.mark.parametrize(
    ("bends", "numbers", "named"),
    [
        ("stiffness_curve", {"cubed_arcsec": 30.0, "reference_torque_Nm": 10.0}, False),
        ("hard_stop", {"taken_share": 0.5, "stop_torque_Nm": 6.0}, False),
        ("hard_stop", {"taken_share": 0.5, "stop_torque_Nm": 6.0}, True),
    ],
)
def test_a_stiffness_that_bends_hides_no_start_from_rest(
    bends: str, numbers: dict[str, float], named: bool
) -> None:
    """Friction alone follows the curve better where earlier loops have left some."""
    up = np.linspace(0, 10, 11)
    torque = np.tile(np.concatenate([up, up[-2::-1]]), 2)
    run = np.repeat([1, 2], len(torque) // 2)
    friction = {"friction_torque_Nm": 0.6, "engagement_angle_arcsec": 5.0}
    case = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 5.0},
        "uncertainty": {"contact_stiffness_rel": 0.1},
        "measurement": {"zero": "per_run"},
    }
    effects = [{"id": "friction_hysteresis"} | friction, {"id": bends} | numbers]
    plan = {"run": run, "torque_Nm": torque, "elastic_angle_arcsec": 0.0 * run}
    fresh = cbpt.read_readings(plan, need_preload=False)  # without a clock each begins at rest
    made = cbpt.simulate(case | {"effect": effects}, fresh, seed=4, u_elastic_angle_arcsec=1.0)
    measured = {
        "elastic_angle_arcsec": made.elastic_angle_arcsec,
        "time_s": 2.0 * np.arange(len(run)),
        "u_elastic_angle_arcsec": np.full(len(run), 1.0),
    }
    readings = cbpt.read_readings(plan | measured, need_preload=False)
    campaign = Campaign.of(cbpt.Case.from_dict(case), readings)
    found, [note] = with_its_history(campaign, ["friction_hysteresis", bends] if named else None)
    assert found.history == "released" and "starts anew at each run" in note


def test_a_fitted_case_says_what_became_of_friction_between_runs() -> None:
    """compare of the case that fit had written disagreed with the same table by three times the
    noise: the clock of the runs went on, and friction did not."""
    campaign = replace(repeated(), history="released")
    measured = readings_of(campaign, FRICTION, np.random.default_rng(6))
    r = measured.readings
    table: dict[str, Any] = {
        "run": r.run_index + 1,
        "time_s": r.time_s,
        "torque_Nm": r.torque_Nm,
        "preload_N": r.preload_N,
        "input_angle_deg": r.input_angle_deg,
        "elastic_angle_arcsec": measured.y_arcsec,
        "u_elastic_angle_arcsec": measured.u_arcsec,
    }
    case = cbpt.Case.from_file(CAMPAIGNS / "dev03.toml")
    found = cbpt.fit(case, table, ["friction_hysteresis"])
    assert found.case.friction_between_runs == "released"
    assert 'friction_between_runs = "released"' in found.case.to_toml()
    clocked = found.case.with_friction_between_runs("by_clock")
    rmse, other = (cbpt.compare(c, table).overall for c in (found.case, clocked))
    assert rmse and other and rmse.rmse_arcsec < 0.33 < other.rmse_arcsec
    # Once the case says it, it is not asked again.
    notes = cbpt.fit(found.case, table, ["friction_hysteresis"]).notes
    assert not any("starts anew" in note for note in notes)
    with pytest.raises(
        cbpt.InvalidInputError, match="none of by_clock, released, carried, carried_from_above"
    ):
        case.with_friction_between_runs("never")


@pytest.mark.parametrize(
    ("past", "path", "how"),
    [
        ([20, -20, 20, 0], [20, -20, 20, -20, 0], "carried_from_above"),
        ([20, -20, 20, 0], [20, -20, 0], "carried_from_above"),
        ([20, -20, 7, 0], [20, -20, 20, -20, 0], "carried_from_above"),
        ([-20, 20, 5], [-20, 20, -20, 7], "carried_from_above"),
        ([-20, 20, -20, 0], [-20, 20, -20, 20, 0], "carried_from_below"),
    ],
)
def test_what_was_done_before_the_first_reading_is_asked(
    past: list[float], path: list[float], how: str
) -> None:
    """Loops that nobody measured had left friction: a torque zero, or a friction with a rate and a
    late torque, were certain in place of friction alone."""
    legs = [0.0, *past, *path]
    torque = np.concatenate(
        [np.linspace(a, b, round(abs(b - a)) + 1)[1:] for a, b in itertools.pairwise(legs)]
    )
    first = sum(round(abs(b - a)) for a, b in itertools.pairwise([0.0, *past])) - 1
    spring = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 5.0},
        "uncertainty": {"contact_stiffness_rel": 0.1},
    }
    friction = {"id": "friction_hysteresis", "friction_torque_Nm": 0.6}
    case = spring | {"effect": [friction | {"engagement_angle_arcsec": 5.0}]}
    plan = {
        "run": np.ones(len(torque)),
        "time_s": 2.0 * np.arange(len(torque)),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 0.0 * torque,
    }
    rows = cbpt.read_readings(plan, need_preload=False)
    made = cbpt.simulate(case, rows, seed=1, u_elastic_angle_arcsec=1.0)
    table = {name: column[first:] for name, column in plan.items()} | {
        "elastic_angle_arcsec": made.elastic_angle_arcsec[first:],
        "u_elastic_angle_arcsec": np.ones(len(torque) - first),
    }
    answer = cbpt.diagnose(spring, table)
    assert answer.verdict.effects == ("friction_hysteresis",)
    [note] = [note for note in answer.notes if "were not measured" in note]
    assert f'friction_between_runs = "{how}"' in note
    fitted = cbpt.fit(spring, table, ["friction_hysteresis"])
    assert fitted.case.friction_between_runs == how
    again = cbpt.compare(fitted.case, table).overall
    assert again and again.rmse_arcsec < 1.1
