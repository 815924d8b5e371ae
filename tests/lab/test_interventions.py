"""Loops of a real reducer before and after its preload was raised, against model-free widths."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import cbpt

DATA = Path(__file__).parents[1] / "data" / "interventions"


@cache
def fitted_and_width_deg(build: str, moment: str) -> tuple[float, float]:
    """The play that is fitted beside friction, and how far apart the branches of the small loops
    lie at no torque; a loop ends where it comes back to zero."""
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    part = readings.select(readings.labels["moment"] == moment)
    found = cbpt.fit(DATA / "reducer.toml", part, ["backlash", "friction_hysteresis"])
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


@pytest.mark.parametrize(("build", "moment"), MOMENTS)
def test_the_play_that_is_fitted_is_near_the_width(build: str, moment: str) -> None:
    play, width = fitted_and_width_deg(build, moment)
    assert 1 / 1.5 < play / width < 1.5


def test_a_play_that_friction_may_hold_is_said_to_rest_on_larger_loops() -> None:
    readings = cbpt.read_readings(DATA / "split_onyx_1.csv", need_preload=False, by="moment")
    part = readings.select(readings.labels["moment"] == "preload_11")
    found = cbpt.fit(DATA / "reducer.toml", part, ["backlash", "friction_hysteresis"])
    assert any("it rests on the larger loops alone" in note for note in found.notes)


@pytest.mark.parametrize(("build", "last"), [("conic_pccf_1", 5), ("split_onyx_1", 12)])
def test_the_play_that_is_fitted_falls_with_the_preload(build: str, last: int) -> None:
    first, _ = fitted_and_width_deg(build, "after_run_in")
    after, _ = fitted_and_width_deg(build, f"preload_{last}")
    assert after < 0.5 * first


def between(build: str, before: str, after: str) -> cbpt.Change:
    readings = cbpt.read_readings(DATA / f"{build}.csv", need_preload=False, by="moment")
    moment = readings.labels["moment"]
    effects = ["backlash", "friction_hysteresis", "output_torsion"]
    # Without their names, by which a state that is measured twice says so itself.
    parts = (replace(readings.select(moment == m), labels={}) for m in (before, after))
    return cbpt.change(DATA / "reducer.toml", *parts, effects=effects)


def test_numbers_that_changed_together_are_found() -> None:
    """With either of them shared the other cannot follow: none of them is found one at a time."""
    found = between("split_onyx_1", "after_run_in", "preload_12")
    ways = {c.parameter: c.direction for c in found.changed}
    assert ways["play_rad"] in ("down", "gone") and ways["friction_torque_Nm"] == "up"
    found = between("split_onyx_1", "preload_4", "preload_5")
    assert {"backlash", "friction_hysteresis"} <= found.weighed.best.changed


def test_a_play_that_all_states_share_keeps_to_the_loops_of_each() -> None:
    """The small loops fell from 1.73 to 0.45 deg: no play of 1.7 deg is in both."""
    found = between("conic_pccf_1", "after_run_in", "preload_3")
    assert "backlash" not in {u.effect for u in found.unchanged}
    ways = {c.parameter: c.direction for c in found.changed}
    assert ways["play_rad"] in ("down", "gone")


def test_a_state_that_was_measured_twice_is_no_certain_change() -> None:
    """Its small loops are 1.07 and 1.86 deg wide, and no other reproducibility is stated."""
    found = between("conic_pccf_1", "after_run_in_repeated", "after_run_in")
    assert found.kind != "changed"


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
