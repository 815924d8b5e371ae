"""What a level does not show is not said to be unchanged there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.change.parameters import differs
from cbpt.lab.change.posterior import Choice, Weighed, weigh
from cbpt.lab.change.shared import Shared
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.selection.fit_effects import fits_of_forms
from common.friction_loops import FRICTION, read_from

STIFF = {"torsional_stiffness_Nm_per_arcmin": 1.0}
CASE = {
    "torsion_spring": STIFF,
    "uncertainty": {"contact_stiffness_rel": 0.1},
    "measurement": {"zero": "per_run"},
}
BOTH_WAYS = np.concatenate([np.arange(0, 20), np.arange(20, -20, -1), np.arange(-20, 0.1)])
ONE_WAY = np.concatenate([np.arange(4, 20, 0.5), np.arange(20, 3.9, -0.5)])


def level(
    torque_Nm: NDArray[np.float64],
    play_arcsec: float,
    friction_Nm: float = 1.0,
    seed: int = 1,
    u: float = 2.0,
) -> dict[str, NDArray[np.float64]]:
    """Two runs of a spring with friction and play."""
    friction = {"friction_torque_Nm": friction_Nm, "engagement_angle_arcsec": 30.0}
    case: dict[str, Any] = {
        "torsion_spring": STIFF,
        "effect": [
            {"id": FRICTION, **friction},
            {"id": "backlash", "play_arcsec": play_arcsec, "transition_torque_Nm": 0.5},
        ],
    }
    return read_from(case, torque_Nm, seed=seed, u=u)


def four_runs(seed: int) -> dict[str, NDArray[np.float64]]:
    """Twice two, one after the other."""
    first, second = (level(BOTH_WAYS, 150.0, seed=seed + k) for k in (0, 1))
    second = second | {"run": second["run"] + 2, "time_s": second["time_s"] + len(second["run"])}
    return {name: np.concatenate([first[name], second[name]]) for name in first}


def found(*tables: dict[str, NDArray[np.float64]]) -> cbpt.Change:
    return cbpt.change(CASE, *tables, effects=[FRICTION, "backlash"])


@pytest.mark.parametrize("turned", [False, True])
def test_a_play_that_a_level_cannot_show_is_not_unchanged(turned: bool) -> None:
    """Loaded one way only, with a zero for each run, a play is a shift of the whole run."""
    tables = [level(BOTH_WAYS, 150.0), level(ONE_WAY, 300.0, seed=2)]
    answer = found(*tables[::-1] if turned else tables)
    assert answer.kind == "undecided" and answer.probability < 0.5
    assert answer.to_dict()["not_shown"] == {"backlash": ["before" if turned else "after"]}
    assert "nothing changed" in answer.sentence and "Nothing changed" not in answer.sentence
    assert "Whether backlash changed cannot be told" in answer.sentence
    assert "backlash within" not in answer.sentence
    assert "backlash" not in {u.effect for u in answer.unchanged}
    # The other numbers are shown by both.
    assert FRICTION in {u.effect for u in answer.unchanged}


def test_what_a_level_cannot_show_is_told_beside_a_change() -> None:
    after = level(ONE_WAY, 150.0, 1.6, seed=2)
    # Half the steps in half the time each: at another rate nothing could be told.
    at_one_rate = after | {"time_s": 0.5 * after["time_s"]}
    answer = found(level(BOTH_WAYS, 150.0), at_one_rate)
    assert answer.kind == "changed" and {c.effect for c in answer.changed} == {FRICTION}
    assert "Whether backlash changed cannot be told" in answer.sentence


def test_within_is_what_the_levels_may_differ_by() -> None:
    """Not how well the value is known that they share: one level shows little of it."""
    answer = found(level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, seed=2, u=20.0))
    assert answer.kind == "nothing" and not answer.not_shown
    [play] = [u for u in answer.unchanged if u.effect == "backlash"]
    before, after = next(b.values for b in answer.by_itself if b.parameter == "play_rad")
    assert play.within > 0.5 * abs(before - after) and play.within > 2.5 * play.u
    assert f"backlash within {play.within / play.value:.1%}" in answer.sentence


# --- what changed by no number ------------------------------------------------------------


def test_what_was_tried_and_is_far_from_certain_has_no_row() -> None:
    """Seventeen of twenty-two rows said 0.000."""
    report = found(level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 90.0, seed=2)).report()
    table, _, after = report.partition("Tried too, each with a probability < 0.01: ")
    assert "sensor_hysteresis" not in table and "sensor_hysteresis" in after
    for shown in ("contact_stiffness", FRICTION, "backlash"):
        assert f"│ {shown} " in table


def test_a_change_of_no_number_is_not_the_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """However much better the readings are followed with two values that are as good as one."""

    def less_known(choices: Sequence[Choice]) -> Weighed | None:
        return weigh(
            [replace(c, fit=replace(c.fit, covariance=1e4 * c.fit.covariance)) for c in choices]
        )

    tables = level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, 1.2, seed=2)
    assert found(*tables).kind == "changed"
    monkeypatch.setattr("cbpt.lab.change.change.weigh", less_known)
    answer = found(*tables)
    assert answer.kind == "undecided" and answer.hidden == (FRICTION,) and not answer.changed
    assert f"But no number of {FRICTION} differs by more than twice" in answer.sentence
    assert "but no number of it" not in answer.sentence


def test_a_difference_may_be_known_better_than_both_values() -> None:
    """What is stated of a stiffness is the same at both levels."""
    softer = level(BOTH_WAYS, 150.0, seed=2)
    torque = softer["torque_Nm"]
    answer = cbpt.change(
        CASE | {"uncertainty": {"contact_stiffness_rel": 0.02, "torque_gain_rel": 0.02}},
        level(BOTH_WAYS, 150.0),
        with_more(softer, 60 * 0.015 * torque),
        effects=[FRICTION, "backlash"],
    )
    assert answer.kind == "changed"
    assert {"contact_stiffness"} <= {c.effect for c in answer.changed}


# --- what one level holds and the other has not -------------------------------------------


def with_more(table: dict[str, NDArray[np.float64]], more: NDArray[np.float64]) -> Any:
    return table | {"elastic_angle_arcsec": table["elastic_angle_arcsec"] + more}


def test_a_slip_in_one_level_keeps_the_answer_from_nothing() -> None:
    """The noise of that level takes it up, and no number changes."""
    before, after = level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, seed=2)
    place = len(BOTH_WAYS) + 30
    slip = np.where((after["run"] == 2) & (np.arange(len(after["run"])) >= place), 300.0, 0.0)
    answer = found(before, with_more(after, slip))
    assert answer.kind == "undecided" and answer.probability < 0.5 and not answer.unchanged
    assert "Nothing changed" not in answer.sentence
    odd = answer.to_dict()["odd_level"]
    assert (odd["level"], odd["other"], odd["run"]) == ("after", "before", "2")
    assert odd["jump_arcsec"] == pytest.approx(300, rel=0.1)
    assert odd["jump_Nm"] == pytest.approx(BOTH_WAYS[30], abs=1)
    assert "most of it in run 2, where the angle jumps by " in answer.sentence
    # The other way round it is the other level.
    turned = found(with_more(after, slip), before).odd_level
    assert turned is not None and (turned.level, turned.other) == (0, 1)


@pytest.mark.parametrize(("runs", "told"), [(4, "3"), (3, "2 or 3")])
def test_a_slip_shows_beside_what_all_runs_leave(runs: int, told: str) -> None:
    """A sharp play under a scattering torque leaves so much that a slip in one loop was not three
    times as much: "nothing changed", for certain."""
    before, after = (four_runs(seed) for seed in (1, 3))
    at = np.arange(len(after["run"])) - 2 * len(BOTH_WAYS)
    slip = np.where((at >= 30) & (at < len(BOTH_WAYS)), 150.0, 0.0)
    law = 90 * np.sin(after["torque_Nm"] / 2)
    tables = with_more(before, law), with_more(after, law + slip)
    kept = after["run"] <= runs
    answer = found(*({name: column[kept] for name, column in t.items()} for t in tables))
    assert answer.kind == "undecided" and answer.odd_level is not None
    assert (answer.odd_level.level, answer.odd_level.run) == (1, told)
    assert answer.odd_level.slipped
    assert f"But in run {told} of after the angle jumps by 1" in answer.sentence
    assert abs(answer.odd_level.jump_arcsec or 0.0) == pytest.approx(150, rel=0.1)


def test_what_wanders_in_one_level_is_no_jump() -> None:
    before, after = level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, seed=2)
    wanders = 60 * np.sin(2 * np.pi * np.arange(len(after["run"])) / 37)
    answer = found(before, with_more(after, wanders))
    assert answer.kind != "nothing" and "Nothing changed" not in answer.sentence
    if answer.odd_level is not None:
        assert answer.odd_level.jump_arcsec is None


def test_what_is_left_of_both_levels_alike_says_nothing() -> None:
    law = 40 * np.sin(np.tile(BOTH_WAYS, 2) / 2)
    tables = [with_more(level(BOTH_WAYS, 150.0, seed=s), law) for s in (1, 2)]
    answer = found(*tables)
    assert answer.kind == "nothing" and answer.odd_level is None
    # What the law may hide is no "nothing".
    assert answer.sentence.startswith("Of what the model follows nothing changed")


@pytest.mark.parametrize("shift", [1.0, 3.0])
def test_another_law_that_no_effect_follows_is_not_nothing(shift: float) -> None:
    """As large in both levels, and alike in the runs of each: no number of the model changed."""
    waves = [40 * np.sin(np.tile(BOTH_WAYS, 2) / 2 + at) for at in (0.0, shift)]
    tables = [with_more(level(BOTH_WAYS, 150.0, seed=s), w) for s, w in enumerate(waves, 1)]
    answer = found(*tables)
    assert answer.kind == "undecided" and answer.probability < 0.5 and not answer.unchanged
    differ = answer.to_dict()["rests_differ_arcsec"]
    assert differ == pytest.approx(40 * abs(np.sin(shift / 2)), rel=0.4)
    assert answer.sentence.startswith("Of what the model follows nothing changed")
    assert "something that the model lacks changed" in answer.sentence
    # Of a rig that does not come back to its state the rest does not either.
    again = cbpt.change(CASE, *tables, effects=[FRICTION, "backlash"], reproducibility_arcsec=40.0)
    assert again.kind != "changed" and again.rests_differ_arcsec is None


def twice(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """The runs of two tables in one."""
    found = {name: np.concatenate([one[name], other[name]]) for name in one}
    return found | {"run": np.repeat([1, 2, 3, 4], len(BOTH_WAYS))}


def test_a_law_that_grew_is_not_nothing() -> None:
    """No effect follows it, and it is the same in the runs of a level."""
    wave = np.tile(40 * np.sin(BOTH_WAYS / 2), 4)
    tables = [
        with_more(twice(level(BOTH_WAYS, 150.0, seed=s), level(BOTH_WAYS, 150.0, seed=s + 1)), more)
        for s, more in ((1, wave), (3, 1.4 * wave))
    ]
    answer = found(*tables)
    assert answer.kind == "undecided" and answer.rests_differ_arcsec is not None
    assert answer.rests_differ_arcsec == pytest.approx(0.4 * 40 / 2, rel=0.2)
    assert "changed, in form or in size" in answer.sentence


def test_more_scatter_is_no_rest() -> None:
    answer = found(level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, seed=2, u=12.0))
    assert answer.kind == "nothing" and answer.odd_level is None


# --- what cannot be fitted to one level ---------------------------------------------------


def test_the_level_that_effects_cannot_be_fitted_to_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fits(fitter: Fitter, *given: Any) -> Any:
        if fitter.campaign.readings.torque_Nm.min() > 0:
            raise cbpt.InvalidInputError("the angles do not depend on the parameters")
        return fits_of_forms(fitter, *given)

    monkeypatch.setattr("cbpt.lab.change.parties.fits_of_forms", fits)
    tables = level(BOTH_WAYS, 150.0), level(ONE_WAY, 150.0, seed=2)
    with pytest.raises(cbpt.InvalidInputError, match=r"^after: .* do not show .* together"):
        found(*tables)
    with pytest.raises(cbpt.InvalidInputError, match=r"^the angles do not depend"):
        found(tables[1], tables[1])


def test_of_effects_that_nobody_named_the_one_that_a_level_cannot_show_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Levels of a real reducer demanded five effects together, and two of seven showed no such
    five: `change` ended with an error after minutes."""

    def fits(fitter: Fitter, effects: Sequence[str], *given: Any) -> Any:
        if len(effects) > 1 and fitter.campaign.readings.torque_Nm.min() > 0:
            raise cbpt.InvalidInputError("the angles do not depend on the parameters")
        return fits_of_forms(fitter, effects, *given)

    monkeypatch.setattr("cbpt.lab.change.parties.fits_of_forms", fits)
    answer = cbpt.change(CASE, level(BOTH_WAYS, 150.0), level(ONE_WAY, 150.0, seed=2))
    assert answer.kind != "changed"
    (note,) = [n for n in answer.notes if "left out" in n]
    assert note.startswith("after: the readings do not show ")


@pytest.mark.parametrize(("off", "expected"), [((0.0, 1.5), True), ((1.0, 1.1), False)])
def test_numbers_that_are_known_together_alone_differ_together(
    off: tuple[float, float], expected: bool
) -> None:
    """A size and a time constant, each known to 1 and their difference to 0.2."""
    own = np.array([[1.0, 0.98], [0.98, 1.0]])
    kinds = {"size": 0, "time": -1}
    unknowns = [SimpleNamespace(name=f"creep.{name}", size_of=n) for name, n in kinds.items()]
    fit = Shared(
        separate=frozenset({0, 1}),
        slots=np.array([[0, 1], [2, 3]]),
        x=np.array([0.0, 0.0, *off]),
        covariance=np.kron(0.5 * np.eye(2), own),
        bounds=(np.full(4, -9.0), np.full(4, 9.0)),
        points=(),
        misfit=0.0,
        of_readings=0.0,
        log_evidence=0.0,
    )
    levels = SimpleNamespace(fits=[SimpleNamespace(unknowns=unknowns)])
    choice = SimpleNamespace(levels=levels, fit=fit, stands_for=False)
    assert differs(cast(Choice, choice), "creep") is expected


def test_a_level_of_a_few_readings_ends_nothing() -> None:
    """Runs too short to repeat each other."""
    few = level(np.array([3.0, 4.0, 5.0, 6.0]), 150.0, seed=2)
    assert found(level(BOTH_WAYS, 150.0), few).kind == "undecided"


@pytest.mark.parametrize("stated_arcsec", [None, 5.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_table_without_times_is_compared_with_one_that_has_them(
    turned: bool, stated_arcsec: float | None
) -> None:
    """Their models have other effects to offer, and one list of places for what they share."""
    timed, bare = (
        {name: column[: len(BOTH_WAYS)] for name, column in table.items()}
        for table in (level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, 2.0, seed=2))
    )
    del bare["time_s"]
    tables = [bare, timed] if turned else [timed, bare]
    effects = [FRICTION, "backlash"]
    answer = cbpt.change(CASE, *tables, effects=effects, reproducibility_arcsec=stated_arcsec)
    assert answer.kind == "changed"
    [changed] = answer.changed
    assert changed.effect == FRICTION and changed.direction == ("down" if turned else "up")


def test_an_effect_over_time_is_not_fitted_to_a_table_without_times() -> None:
    timed, bare = level(BOTH_WAYS, 150.0), level(BOTH_WAYS, 150.0, seed=2)
    del bare["time_s"]
    bare["torque_Nm"] = 1.01 * bare["torque_Nm"]  # ranges are those of the larger torque
    for tables in ([timed, bare], [bare, timed]):
        with pytest.raises(cbpt.ReadingsError, match=r"'time_s': .*column that creep depends on"):
            cbpt.change(CASE, *tables, effects=[FRICTION, "creep"])


def test_a_table_without_preloads_is_compared_with_one_that_has_them() -> None:
    """What stands in for a friction that changed does not follow a preload: it ended `change`."""
    loaded = level(BOTH_WAYS, 150.0)
    loaded["preload_N"] = np.full(len(loaded["torque_Nm"]), 600.0)
    [changed] = cbpt.change(
        CASE, loaded, level(BOTH_WAYS, 150.0, 2.0, seed=2), effects=[FRICTION]
    ).changed
    assert (changed.effect, changed.parameter) == (FRICTION, "friction_torque_Nm")


def test_what_a_set_up_may_hide_is_not_told_as_unchanged() -> None:
    """A play that falls to a third beside friction that rises: the loops are about as wide, and of
    a rig that comes back to 40 arcsec nobody can tell."""
    tables = [level(BOTH_WAYS, 150.0, 1.0), level(BOTH_WAYS, 50.0, 1.8, seed=2)]
    effects = [FRICTION, "backlash"]
    assert found(*tables).kind == "changed"
    blurred = cbpt.change(CASE, *tables, effects=effects, reproducibility_arcsec=40.0)
    assert blurred.kind == "undecided" and "backlash" in blurred.not_shown
    assert "backlash" not in {u.effect for u in blurred.unchanged}
    assert "beside what a new set-up changes" in blurred.sentence
    same = [level(BOTH_WAYS, 150.0, seed=seed) for seed in (1, 2)]
    alike = cbpt.change(CASE, *same, effects=effects, reproducibility_arcsec=40.0)
    assert alike.kind == "nothing"
