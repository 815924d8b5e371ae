"""What changed from level to level of a column: the order of the levels, and how numbers went."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.change.parameters import trend_of
from cbpt.lab.change.record import ByItself
from cbpt.lab.change.text import _by_itself
from cbpt.lab.wording.numbers import ARCSEC
from common.friction_loops import FRICTION, SPRING, by_step


def test_levels_of_a_column_have_a_trend() -> None:
    answer = cbpt.change(SPRING, by_step(0.6, 1.0, 1.6), by="step", effects=[FRICTION])
    assert answer.levels == ("1", "2", "3.0") or len(answer.levels) == 3
    first = answer.changed[0]
    assert first.trend == "rising" and first.values[1] == pytest.approx(1.0, abs=0.1)


def test_numbers_are_levels_in_rising_order() -> None:
    table = by_step(1.6, 0.6, 1.0)
    table["step"] = np.array([10.0, 2.0, 9.0])[table["step"].astype(int) - 1]
    answer = cbpt.change(SPRING, table, by="step", effects=[FRICTION])
    assert [float(level) for level in answer.levels] == [2, 9, 10]
    assert answer.changed[0].trend == "rising"


def test_what_goes_up_and_down_is_told_with_both_ends() -> None:
    """The first level and the last say nothing of the one between."""
    answer = cbpt.change(SPRING, by_step(1.0, 1.6, 1.0), by="step", effects=[FRICTION])
    first = answer.changed[0]
    assert first.trend == "neither" and first.moved
    told = "went up and down: friction_torque_Nm 1.00"
    assert told in answer.sentence and " (step 1), 1.6" in answer.sentence
    assert " rose" not in answer.sentence


@pytest.mark.parametrize(
    ("values", "u", "trend"),
    [
        ((1.0, 2.0, 3.0), 0.1, "rising"),
        ((3.0, 2.0, 1.0), 0.1, "falling"),
        ((1.0, 3.0, 2.5, 2.0, 4.0), 0.3, "neither"),  # falls by 2 u in two steps
        ((1.0, 1.5, 1.2), 0.3, "neither"),  # the last is no larger than the first
    ],
)
def test_a_trend_goes_one_way_from_the_first_to_the_last(
    values: tuple[float, ...], u: float, trend: str
) -> None:
    apart = [(b - a) / (u * np.sqrt(2)) for a, b in combinations(values, 2)]
    assert trend_of(apart, len(values)) == trend


def test_a_step_is_not_told_as_a_steady_rise() -> None:
    """Friction of one size at two levels and of another at the third: the sentence said "rising
    from level to level"."""
    answer = cbpt.change(SPRING, by_step(1.0, 1.0, 1.6), by="step", effects=[FRICTION])
    assert answer.changed[0].trend == "rising"
    assert "friction_hysteresis rose: friction_torque_Nm 1.0" in answer.sentence
    assert " (step 1), 1.0" in answer.sentence and "level to level" not in answer.sentence


@pytest.mark.parametrize("steps", [("loose", "mid", "tight"), ("0.5", "1.0", "2.0")])
def test_preload_steps_may_be_words(steps: tuple[str, ...]) -> None:
    """They ended `change` with an error of numpy."""
    table: dict[str, Any] = by_step(0.6, 1.0, 1.6)
    table["preload_step"] = np.array(steps)[table.pop("step").astype(int) - 1]
    answer = cbpt.change(SPRING, table, by="preload_step", effects=[FRICTION])
    assert answer.levels == steps and answer.kind == "changed"


def test_an_error_names_the_level_that_it_is_of() -> None:
    table = by_step(1.0, 1.0, 1.6)
    kept = (table["step"] != 2) | (np.cumsum(table["step"] == 2) <= 3)
    few = {name: column[kept] for name, column in table.items()}
    with pytest.raises(cbpt.ReadingsError, match=r", step 2(\.0)?: .*found 3 readings"):
        cbpt.change(SPRING, few, by="step", effects=[FRICTION])


def test_a_number_that_two_effects_have_is_told_with_its_effect() -> None:
    """Two frictions had the same name in one sentence."""
    answer = cbpt.change(SPRING, by_step(1.0, 1.0), by="step", effects=[FRICTION])
    sizes = (
        ByItself(effect, "friction_torque_Nm", "N m", (1.0, 2.0), (0.1, 0.1))
        for effect in (FRICTION, "distributed_friction")
    )
    told = _by_itself(replace(answer, by_itself=tuple(sizes)), ARCSEC)
    assert f"friction_torque_Nm of {FRICTION} 1.00 +- 0.10 (" in told
    assert "friction_torque_Nm of distributed_friction 1.00 +- 0.10 (" in told
