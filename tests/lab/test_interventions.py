"""Loops of a real reducer before and after its preload was raised, against model-free widths."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.change.counting import doubts_of
from cbpt.lab.change.rest import rest_of
from cbpt.lab.diagnosis.unexplained import shape_of
from cbpt.lab.model.own_loops import small_loops_of

DATA = Path(__file__).parents[1] / "data" / "interventions"
STIFF = "stiff"
SOFT = "soft"
CASES: dict[str, Any] = {
    # Several times stiffer than the loops, and softer than some of them.
    STIFF: {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.3},
        "measurement": {"zero": "per_run"},
    },
    SOFT: {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.05},
        "uncertainty": {"contact_stiffness_rel": 0.5},
        "measurement": {"zero": "per_run"},
    },
}


@cache
def fitted(build: str, moment: str, case: str) -> tuple[cbpt.Fitted, cbpt.Readings]:
    """Play beside friction."""
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    part = readings.select(readings.labels["moment"] == moment)
    return cbpt.fit(CASES[case], part, ["backlash", "friction_hysteresis"]), part


def fitted_and_width_deg(build: str, moment: str, case: str = STIFF) -> tuple[float, float]:
    """The play that is fitted beside friction, and how far apart the branches of the small loops
    lie at no torque; a loop ends where it comes back to zero."""
    found, part = fitted(build, moment, case)
    play = found.parameters()["backlash"]["play_rad"]["value"]
    widths = []
    for run in np.unique(part.run_index):
        here = part.run_index == run
        torque, angle = part.torque_Nm[here], part.elastic_angle_arcsec[here] / 3600
        if np.abs(torque).max() < 10:
            top = int(np.argmax(torque))
            cross = top + int(np.argmax(torque[top:] <= 0))
            falling = np.interp(0.0, torque[[cross, cross - 1]], angle[[cross, cross - 1]])
            widths.append(float(falling - angle[-1]))
    return float(np.degrees(play)), float(np.mean(widths))


MOMENTS = [
    *(("split_onyx_1", m) for m in ("initial", "after_run_in")),
    *(("split_onyx_1", f"preload_{k}") for k in (*range(1, 11), 12)),
    *(("conic_pccf_1", m) for m in ("initial", "after_run_in", "after_run_in_repeated")),
    *(("conic_pccf_1", f"preload_{k}") for k in range(1, 6)),
    *(("split_undersized_pccf_1", m) for m in ("initial", "initial_repeated", "after_run_in")),
    *(("split_undersized_pccf_1", f"preload_{k}") for k in range(1, 5)),
    *(("base_onyx_1", m) for m in ("initial", "after_run_in")),
]
"""All but the eleventh step, whose two small loops turn by less than twice what its one large loop
turns back over as much torque: friction may hold them."""


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("build", "moment"), MOMENTS)
def test_the_play_that_is_fitted_is_near_the_width(build: str, moment: str, case: str) -> None:
    play, width = fitted_and_width_deg(build, moment, case)
    assert 1 / 1.5 < play / width < 1.5


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("build", "moment"), MOMENTS)
def test_friction_with_its_share_of_the_load_is_what_small_loops_allow(
    build: str, moment: str, case: str
) -> None:
    found, _ = fitted(build, moment, case)
    friction = {k: p["value"] for k, p in found.parameters()["friction_hysteresis"].items()}
    loops = small_loops_of(found.fitter.campaign)
    assert loops is not None
    at_ends = friction.get("load_share", 0.0) * loops.amplitude_Nm
    if at_ends:
        assert friction["friction_torque_Nm"] + at_ends <= 1.001 * loops.friction_Nm


def test_a_play_that_friction_may_hold_is_said_to_rest_on_larger_loops() -> None:
    readings = cbpt.read_readings(DATA / "split_onyx_1.csv", need_preload=False, by="moment")
    part = readings.select(readings.labels["moment"] == "preload_11")
    found = cbpt.fit(CASES[STIFF], part, ["backlash", "friction_hysteresis"])
    assert any("it rests on the larger loops alone" in note for note in found.notes)


@pytest.mark.parametrize(("build", "last"), [("conic_pccf_1", 5), ("split_onyx_1", 12)])
def test_the_play_that_is_fitted_falls_with_the_preload(build: str, last: int) -> None:
    first, _ = fitted_and_width_deg(build, "after_run_in")
    after, _ = fitted_and_width_deg(build, f"preload_{last}")
    assert after < 0.5 * first


EFFECTS = ["backlash", "friction_hysteresis"]


def between(
    build: str,
    before: str,
    after: str,
    effects: Sequence[str] = EFFECTS,
    case: Any = CASES[STIFF],
    **options: Any,
) -> cbpt.Change:
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    moment = readings.labels["moment"]
    # Without their names, by which a state that is measured twice says so itself.
    parts = (replace(readings.select(moment == m), labels={}) for m in (before, after))
    return cbpt.change(case, *parts, effects=effects, **options)


def directions(found: cbpt.Change) -> dict[str, str]:
    return {c.effect: c.direction for c in found.foremost if not c.rivals}


def test_preload_takes_play_and_raises_friction() -> None:
    """With the stiffness that the large loops show."""
    found = between("split_onyx_1", "after_run_in", "preload_12", case=DATA / "reducer.toml")
    assert {"backlash": "down", "friction_hysteresis": "up"}.items() <= directions(found).items()
    found = between("conic_pccf_1", "after_run_in", "preload_5", case=DATA / "reducer.toml")
    assert directions(found) == {"backlash": "down"}
    # A stiffness or a gain may have changed beside it.
    verdict = found.to_dict()["verdict"]
    assert "contact_stiffness" in [p["effect"] for p in verdict["perhaps"]]
    assert "contact_stiffness" not in [u.effect for u in found.unchanged]
    # What could have been told is said with its size, as the fitted numbers of others differ too.
    size = re.search(r"moves the angles by less than (\d+) arcsec \(rms\), once", found.sentence)
    assert size and float(size[1]) == pytest.approx(found.told_from_arcsec, rel=0.01)
    assert 0 < found.told_from_arcsec < found.moves_arcsec["backlash"]


def test_one_step_of_the_preload_that_closes_the_play() -> None:
    """The small loops of the state before are all wider than those after are; two ramps of a kind
    differ by much, and hid it."""
    found = between("split_onyx_1", "preload_4", "preload_5", case=DATA / "reducer.toml")
    told = directions(found)
    assert told["backlash"] in {"down", "gone"} and told["friction_hysteresis"] == "up"


def test_a_play_that_rests_on_large_loops_alone_is_not_told() -> None:
    """Friction holds the small loops after, which are as wide as those before; a play of 1.4 deg
    stands for what the model does not follow of the large ones."""
    found = between("split_onyx_1", "preload_10", "preload_11", case=DATA / "reducer.toml")
    assert "backlash" not in directions(found)


def test_a_state_that_is_measured_twice_did_not_change() -> None:
    """Its small loops are 1.07 and 1.86 deg wide: that is how well this rig comes back to it, and
    not what was done to the reducer. Who does not say that it is one state hears of the loops, and
    of no change for certain."""
    table, moments = DATA / "conic_pccf_1.csv", ("after_run_in_repeated", "after_run_in")
    parts = [
        cbpt.read_readings(table, need_preload=False, only={"moment": moment}) for moment in moments
    ]
    found = cbpt.change(DATA / "reducer.toml", *parts, effects=EFFECTS)
    assert found.kind == "nothing"
    unsaid = between("conic_pccf_1", *moments, case=DATA / "reducer.toml")
    assert unsaid.kind == "undecided" and not unsaid.changed
    assert "The measured loops changed" in unsaid.sentence


def test_a_stiffness_that_is_far_off_is_told_to_be_corrected_first() -> None:
    stated = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.6}}
    found = between("split_onyx_1", "preload_6", "preload_7", case=CASES[STIFF] | stated)
    assert any("ends at the limit of its range (-80.0 %)" in note for note in found.notes)


def test_what_the_effects_do_not_follow_counts_beside_a_stated_reproducibility_too() -> None:
    """A reproducibility of next to nothing says what none that is stated does."""
    pair = "conic_pccf_1", "preload_1", "preload_2"
    bare = between(*pair, case=DATA / "reducer.toml")
    stated = between(*pair, case=DATA / "reducer.toml", reproducibility_arcsec=1e-3)
    assert stated.weighed.something == pytest.approx(bare.weighed.something, rel=1e-2)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(
    ("build", "last"), [("conic_pccf_1", 3), ("conic_pccf_1", 5), ("split_onyx_1", 12)]
)
def test_play_falls_and_friction_rises_by_itself(build: str, last: int, case: str) -> None:
    """The small loops are a third as wide and less: that is told, though these effects may leave
    too much of the large loops to say what changed."""
    found = between(build, "after_run_in", f"preload_{last}", case=CASES[case])
    assert found.kind != "nothing" and "backlash" not in {u.effect for u in found.unchanged}
    size = {b.parameter: b for b in found.by_itself}
    play, friction = size["play_rad"], size["friction_torque_Nm"]
    assert play.values[1] < 0.5 * play.values[0]
    if case != STIFF:
        assert friction.values[1] > 1.3 * friction.values[0]
    assert found.sentence.count("The measured loops changed") == 1
    assert "by itself" in found.sentence


@pytest.mark.parametrize("further", [[], ["output_torsion"]])
@pytest.mark.parametrize(
    ("build", "before", "after"),
    [
        # Where the effects leave more than what they say changed, a gain is not what did.
        ("split_undersized_pccf_1", "after_run_in", "preload_4"),
    ],
)
def test_what_moves_the_angles_by_less_than_is_left_did_not_certainly_change(
    build: str, before: str, after: str, further: list[str]
) -> None:
    found = between(build, before, after, [*EFFECTS, *further])
    assert found.kind != "changed" and not found.changed
    assert found.not_followed_arcsec > 0 and not found.unchanged


@pytest.mark.parametrize(
    ("build", "moment"), [("conic_pccf_1", "after_run_in"), ("base_onyx_1", "after_run_in")]
)
def test_a_diagnosis_finds_play_and_friction_together(build: str, moment: str) -> None:
    """Neither shows without the other: as a set they follow the loops far better than any that a
    search finds which adds one effect to another."""
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    found = cbpt.diagnose(
        DATA / "reducer.toml", readings.select(readings.labels["moment"] == moment)
    )
    assert {"backlash", "friction_hysteresis"} <= set(found.verdict.names)
    assert set(found.verdict.effects) <= {"backlash", "friction_hysteresis"}


def without_a_second_large_loop(moment: str) -> cbpt.Readings:
    readings = cbpt.read_readings(DATA / "split_onyx_1.csv", need_preload=False, by="moment")
    part = readings.select(readings.labels["moment"] == moment)
    return part.select(part.run_index != part.run_index.max())


def test_no_cause_is_certain_where_nothing_tells_the_scatter() -> None:
    """Ramps of which neighbours go together, and no uncertainty is stated: the scatter is what the
    fit leaves, 3000 arcsec of them, which may as well be a law."""
    found = cbpt.diagnose(CASES["soft"], without_a_second_large_loop("preload_4"))
    assert found.verdict.probability < 0.95
    assert all(row["probability"] < 0.95 for row in found.to_dict()["combinations"])
    assert "nothing else tells what they scatter by" in found.report()


def test_what_is_not_certain_is_not_told_as_a_fact() -> None:
    found = cbpt.diagnose(CASES["soft"], without_a_second_large_loop("preload_5"))
    assert found.verdict.probability < 0.95 and found.verdict.perhaps
    assert "In addition there is" not in found.sentence
    assert "perhaps also" in found.sentence


def part_of(build: str, moment: str) -> cbpt.Readings:
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    return readings.select(readings.labels["moment"] == moment)


def test_what_hides_behind_a_loop_is_fitted_beside_it() -> None:
    """Beside all that the drive alone leaves of a loop, a sensor's curve of a likely size does not
    stand out; beside play and friction it does. It was refused as nothing that the readings depend
    on."""
    effects = ["backlash", "friction_hysteresis", "sensor_nonlinearity"]
    found = cbpt.fit(DATA / "reducer.toml", part_of("split_onyx_1", "preload_2"), effects)
    without = cbpt.fit(DATA / "reducer.toml", part_of("split_onyx_1", "preload_2"), effects[:2])
    assert found.after.rmse_arcsec < without.after.rmse_arcsec


def test_a_play_that_fell_is_found_where_no_effect_is_named() -> None:
    """What the levels demand is fitted to both; the same set ended with an error."""
    before, after = (part_of("split_onyx_1", f"preload_{k}") for k in (2, 3))
    found = cbpt.change(DATA / "reducer.toml", before, after)
    assert ("backlash", "down") in {(c.effect, c.direction) for c in found.changed}


def test_a_state_that_is_measured_twice_did_not_change_where_no_effect_is_named() -> None:
    """Its loops are 1.07 and 1.86 deg wide, and it repeats a state by its name. It was undecided:
    what such states differ by was counted by the first set of effects, and not by the best one."""
    moments = "after_run_in_repeated", "after_run_in"
    before, after = (part_of("conic_pccf_1", moment) for moment in moments)
    found = cbpt.change(DATA / "reducer.toml", before, after)
    assert found.kind == "nothing" and not found.changed


def test_what_remains_is_told_by_the_runs_of_the_table() -> None:
    """And not by their places, which begin with 0."""
    part = part_of("conic_pccf_1", "preload_5")
    found = cbpt.diagnose(DATA / "reducer.toml", part)
    assert found.verdict.lack_of_fit is not None and "run" in found.verdict.lack_of_fit.columns
    told = {line.partition(":")[0] for line in shape_of(found)}
    assert told == {f"run {run}" for run in np.unique(part.run)}


def test_runs_with_the_same_torques_are_one_run_in_the_uncertainty_beside_a_rest() -> None:
    """What play and friction leave of a state is the same in each ramp: three ramps for each one
    tell no more of it."""
    whole = between("split_undersized_pccf_1", "initial_repeated", "initial")
    levels = whole.weighed.best.levels
    is_law = rest_of(whole.weighed, comes_back=False).is_law
    assert all(is_law)
    doubts = doubts_of(levels, is_law, alone=True)
    assert doubts_of(levels, [False, False], alone=True) == [1.0, 1.0]
    assert min(doubts) > 1.4  # of two ramps each, sqrt(2) from that alone
    fit = levels.fits[0]
    play = next(u for u in fit.unknowns if u.name == "backlash.play_rad")
    told = next(b for b in whole.by_itself if b.parameter == "play_rad")
    assert told.u[0] == pytest.approx(doubts[0] * fit.u(play))


@pytest.mark.parametrize("build", ["conic_pccf_1", "split_onyx_1"])
def test_a_torque_of_the_other_sign_is_refused_however_wide_the_loop(build: str) -> None:
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    part = readings.select(readings.labels["moment"] == "after_run_in")
    turned = replace(part, torque_Nm=-part.torque_Nm)
    with pytest.raises(cbpt.ReadingsError, match="reverse the sign"):
        cbpt.diagnose(DATA / "reducer.toml", turned)
