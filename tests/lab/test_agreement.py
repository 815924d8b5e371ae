"""Property: a change counts as far as the runs that repeat each other agree on it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.change import rest
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
