"""Property: a change counts as far as the runs that repeat each other agree on it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.change import rest
from cbpt.lab.change.agreement import _Pair
from common.springs import Reducer, loops

EFFECTS = ["backlash", "friction_hysteresis"]
CASE = {
    "torsion_spring": {"torsional_stiffness_Nm_per_rad": 2000.0},
    "measurement": {"zero": "per_run"},
    "uncertainty": {"contact_stiffness_rel": 0.2},
}
STATE = Reducer(play_rad=0.004, friction_Nm=1.5)


def runs(reducers: list[Reducer], seed: int) -> dict[str, Any]:
    table = loops(reducers, noise_rad=5e-5, seed=seed)
    del table["preload_step"]
    return table


def changed(before: list[Reducer], after: list[Reducer]) -> cbpt.Change:
    case = cbpt.Case.from_dict(CASE)
    return cbpt.change(case, runs(before, 1), runs(after, 2), effects=EFFECTS)


ODD = replace(STATE, friction_Nm=2.2)


def test_one_run_that_went_otherwise_is_no_change(monkeypatch: pytest.MonkeyPatch) -> None:
    found = changed([STATE] * 4, [STATE, STATE, ODD, STATE])
    assert found.kind == "undecided" and found.hidden, found.sentence
    # Evidence alone, which adds up over all readings, is certain of it.
    monkeypatch.setattr(rest, "runs_agree", lambda choice, effect: True)
    assert changed([STATE] * 4, [STATE, STATE, ODD, STATE]).kind == "changed"


def test_what_all_runs_show_is_a_change() -> None:
    found = changed([STATE] * 4, [ODD] * 4)
    assert found.kind == "changed"
    assert [c.effect for c in found.changed] == ["friction_hysteresis"]


def test_runs_that_differ_less_than_the_change_do_not_hide_it() -> None:
    near = [replace(STATE, friction_Nm=f) for f in (1.45, 1.5, 1.55, 1.5)]
    far = [replace(STATE, friction_Nm=f) for f in (2.1, 2.2, 2.3, 2.2)]
    found = changed(near, far)
    assert found.kind == "changed"
    assert {c.effect for c in found.changed} == {"friction_hysteresis"}


def test_of_more_levels_those_most_apart_count() -> None:
    """The level between the others says little of either."""
    frictions = (1.5, 1.8, 2.2)
    parts = [runs([replace(STATE, friction_Nm=f)] * 3, seed) for seed, f in enumerate(frictions, 1)]
    table = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    table["run"] = np.repeat(np.arange(9), len(table["run"]) // 9)
    table["step"] = np.repeat(np.arange(3), len(table["run"]) // 3)
    found = cbpt.change(cbpt.Case.from_dict(CASE), table, by="step", effects=EFFECTS)
    assert found.kind == "changed" and found.runs_differ == ()
    assert [c.effect for c in found.changed] == ["friction_hysteresis"]


def pair_of(
    told: list[list[float]], shown: list[list[float]], excludes: tuple[bool, bool] = (False, False)
) -> _Pair:
    """Two levels of two small loops and two large ones: how much each tells of the change, and how
    much more than all of it."""
    loop = np.sin(np.linspace(0, 2 * np.pi, 16))
    torque = np.concatenate([4 * loop, 4 * loop, 40 * loop, 40 * loop])
    columns = {"run": np.repeat(np.arange(4), 16), "torque_Nm": torque, "elastic_angle_deg": torque}
    table = cbpt.read_readings(columns, need_preload=False)
    weight = [np.repeat(of_level, 16) / 16 for of_level in told]
    before, after = (w * np.repeat(c, 16) for w, c in zip(weight, shown, strict=True))
    return _Pair((table, table), (before, after), (weight[0], weight[1]), excludes)


def test_a_run_that_hardly_tells_the_change_does_not_lend_its_scatter_to_others() -> None:
    """The play of a real reducer: before, the large loops tell it badly; after, they tell it best.
    Their scatter before was taken for that of all large loops, and hid the change."""
    told = [[36.0, 36.0, 15.0, 14.0], [6.0, 7.0, 43.0, 44.0]]
    assert pair_of(told, [[0, 0.02, -0.1, 0.45], [0.2, -0.1, 0, 0.01]]).agrees()
    # Loops that tell the change and differ as much hide it.
    assert not pair_of(told, [[0, 0.02, -0.1, 0.45], [0.2, -0.1, -0.9, 0.9]]).agrees()


def test_a_level_whose_loops_exclude_the_others_value_needs_no_runs_that_agree() -> None:
    """Small loops after are narrower than the play before, all of them: how large loops differ does
    not matter there. It does before, where the loops leave the value after open."""
    told = [[150.0, 140.0, 31.0, 26.0], [1.5, 0.1, 18.0, 15.0]]
    shown = [[0, 0.02, -0.24, 0.25], [0.7, 4.2, 0.4, -0.58]]
    assert not pair_of(told, shown).agrees()
    assert pair_of(told, shown, (False, True)).agrees()
    assert not pair_of(told, shown, (True, False)).agrees()
