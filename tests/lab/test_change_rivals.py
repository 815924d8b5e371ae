"""Changes that the readings do not tell apart, and values at the limit of their range."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.change.parameters import _direction, _of_effect, changed_of
from cbpt.lab.change.parties import levels_of
from cbpt.lab.change.posterior import Choice, Group, Search, Weighed, groups_of
from cbpt.lab.change.record import Changed, Limit
from cbpt.lab.change.reproducibility import moves_of
from cbpt.lab.change.rest import Rest, rest_of
from cbpt.lab.change.shared import _System, fit_shared
from cbpt.lab.change.text import _told
from cbpt.lab.model.own_loops import ENGAGEMENT
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.wording.numbers import ARCSEC
from common.friction_loops import FRICTION, LOOP, SPRING, found, loops, read_from


def play(play_arcsec: float, seed: int = 1) -> dict[str, NDArray[np.float64]]:
    """The same loops of a spring with play."""
    plan = loops()
    case = SPRING | {"effect": [{"id": "backlash", "play_arcsec": play_arcsec}]}
    rows = cbpt.read_readings(plan, need_preload=False)
    made = cbpt.simulate(case, rows, seed=seed, u_elastic_angle_arcsec=2.0)
    return plan | {"elastic_angle_arcsec": np.array(made.elastic_angle_arcsec)}


def stiffened(table: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """What a spring that is stiffer by 5 % turns."""
    return table | {"elastic_angle_arcsec": table["elastic_angle_arcsec"] / 1.05}


def test_twins_are_told_as_one_of_them() -> None:
    """No reading of a spring tells a gain from its stiffness; what is stated of the gain of an
    instrument does not say what happened to it in between."""
    answer = cbpt.change(SPRING, play(0.0), stiffened(play(0.0, seed=2)), effects=[])
    twins = ("contact_stiffness", "sensor_gain", "torque_scale")
    assert answer.kind == "changed" and answer.rivals == (twins,)
    assert {c.effect: c.direction for c in answer.changed} == {
        "contact_stiffness": "up",
        "sensor_gain": "down",
        "torque_scale": "down",
    }
    assert answer.changed[0].effect == "contact_stiffness"
    assert all(0.03 < c.probability < 0.95 for c in answer.changed)
    assert answer.changed[0].rivals == ("sensor_gain", "torque_scale")
    assert "One of these changed, and the readings do not tell which: contact_" in answer.sentence
    # A cell that reads too high has a gain that fell.
    assert "torque_scale fell: torque_gain (true torque over reading) from " in answer.sentence
    assert not set(twins) & {u.effect for u in answer.unchanged}
    verdict = answer.to_dict()["verdict"]
    assert verdict["rivals"] == [list(twins)]
    assert verdict["changed"][0]["rivals"] == ["sensor_gain", "torque_scale"]
    assert [c["moved"] for c in verdict["changed"]] == [c.moved for c in answer.changed]


def test_a_gain_that_all_else_follows_may_be_a_stiffness() -> None:
    """The play turns by less too: of a gain, or of a stiffness that the play comes from."""
    answer = cbpt.change(SPRING, play(300.0), stiffened(play(300.0, seed=2)), effects=["backlash"])
    assert answer.rivals == (("contact_stiffness", "sensor_gain"),)
    stiffness, gain = answer.changed
    assert 0.95 > stiffness.probability > gain.probability > 0.05
    assert stiffness.moved and gain.moved


def in_pieces(
    scale: float, seed: int, friction_Nm: float = 1.0, behind: bool = False
) -> dict[str, NDArray[np.float64]]:
    """Loops of a spring in pieces with friction: so many times the torque at each angle. behind: of
    a shaft in series and of what creeps too."""
    plan = loops()
    pieces = {
        "added_compliance_1_rad_per_Nm": 1.5e-4 / scale,
        "added_compliance_2_rad_per_Nm": 0.8e-4 / scale,
        "break_torque_1_Nm": 2.0 * scale,
        "break_torque_2_Nm": 7.0 * scale,
    }
    effects: list[dict[str, object]] = [
        {"id": "stiffness_curve", **pieces},
        {"id": FRICTION, "friction_torque_Nm": friction_Nm, "engagement_angle_arcsec": 30.0},
    ]
    if behind:
        creep = {"id": "creep", "time_constant_s": 10.0}
        effects += [
            {"id": "output_torsion", "compliance_arcsec_per_Nm": 20.0 / scale},
            {**creep, "compliance_arcsec_per_Nm": 6.0 / scale},
        ]
    case = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": scale},
        "effect": effects,
    }
    rows = cbpt.read_readings(plan, need_preload=False)
    made = cbpt.simulate(case, rows, seed=seed, u_elastic_angle_arcsec=2.0)
    return plan | {"elastic_angle_arcsec": np.array(made.elastic_angle_arcsec)}


@pytest.mark.parametrize(("alone", "together"), [(0.7, 0.1), (0.1, 0.7)])
def test_a_friction_is_told_with_a_stiffness_only_in_its_likeliest_choice(
    alone: float, together: float
) -> None:
    """Else a friction at 0.1 stood beside a stiffness that another fit had by itself."""
    none = cast(Any, None)
    stiffness = "contact_stiffness"
    own = Choice(frozenset({stiffness}), none, none, 0.0, alone)
    both = frozenset({stiffness, FRICTION})
    for_gain = Choice(both, none, none, 0.0, together, "torque_scale", frozenset({FRICTION}))
    choices = sorted((own, for_gain), key=lambda c: -c.probability)
    weighed = Weighed((), tuple(choices))
    assert weighed.along(FRICTION) == (stiffness if together > alone else "")
    assert weighed.stood_for("torque_scale") and not weighed.stood_for("sensor_gain")


def test_a_stiffness_in_place_of_a_gain_changes_by_as_much() -> None:
    """All angles are larger by a twelfth, and the curve keeps its places over the torque: of the
    two, the gain is fitted. The stiffness was told with the values of a worse fit of its own."""
    after = in_pieces(1.0, 2)
    after["elastic_angle_arcsec"] = after["elastic_angle_arcsec"] / 0.92
    answer = cbpt.change(SPRING, in_pieces(1.0, 1), after, effects=[FRICTION, "stiffness_curve"])
    assert answer.rivals == (("contact_stiffness", "sensor_gain"),)
    stiffness, gain = answer.changed
    assert stiffness.after / stiffness.before == pytest.approx(0.92, abs=0.01)
    assert gain.before / gain.after == pytest.approx(stiffness.after / stiffness.before, rel=1e-9)
    # By a twelfth of a scale that is itself known to 1.3 %.
    assert (stiffness.before - stiffness.after) / stiffness.apart == pytest.approx(0.0011, rel=0.1)


def test_another_modulus_of_all_members_is_no_gain_of_the_torque() -> None:
    """Warm: every member is softer by a twelfth, with its curve over the angle, and friction fell.
    No reading tells that from a torque cell; it was one for certain, beside a friction that fell by
    less."""
    tables = in_pieces(1.0, 1, behind=True), in_pieces(0.92, 2, 0.7, behind=True)
    effects = [FRICTION, "stiffness_curve", "output_torsion", "creep"]
    answer = cbpt.change(SPRING, *tables, effects=effects)
    assert answer.rivals == (("contact_stiffness", "torque_scale"),)
    found = {c.effect: c for c in answer.changed}
    assert found["contact_stiffness"].probability == pytest.approx(0.5, abs=0.1)
    for effect, ratio in (("contact_stiffness", 0.92), (FRICTION, 0.7)):
        assert found[effect].after / found[effect].before == pytest.approx(ratio, abs=0.01)
    # Of all members: what stands behind the spring became softer too.
    assert not {"output_torsion", "creep"} & {u.effect for u in answer.unchanged}


def test_a_stiffness_and_a_friction_that_fell_by_one_share_are_told_beside_the_gain() -> None:
    """Warm: both fell by an eighth. No reading tells that from a torque cell, which was told alone,
    for certain, with both unchanged."""
    tables = loops(), loops(0.88, 0.88, seed=2)
    answer = cbpt.change(SPRING, *tables, effects=[FRICTION])
    assert answer.rivals == (("contact_stiffness", "torque_scale"),)
    found = {c.effect: c for c in answer.changed}
    assert set(found) == {"contact_stiffness", "torque_scale", FRICTION}
    for effect in ("contact_stiffness", FRICTION):
        assert found[effect].after / found[effect].before == pytest.approx(0.88, abs=0.01)
    assert found[FRICTION].along == "contact_stiffness" and FRICTION not in answer.perhaps
    assert ", together with friction_hysteresis fell: friction_torque" in answer.sentence
    assert " that they changed, by the same share); or torque_scale rose: " in answer.sentence
    assert not {u.effect for u in answer.unchanged} & set(found)
    written = {c["effect"]: c["along"] for c in answer.to_dict()["verdict"]["changed"]}
    assert written == {**dict.fromkeys(found), FRICTION: "contact_stiffness"}


def test_one_of_a_group_that_is_told_is_not_said_to_be_too_small(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside a rest between what the stiffness and what the gain moves."""
    tables = play(300.0), stiffened(play(300.0, seed=2))

    def with_hidden(weighed: Weighed, comes_back: bool) -> Rest:
        return replace(rest_of(weighed, comes_back), hidden=("contact_stiffness",))

    monkeypatch.setattr("cbpt.lab.change.change.rest_of", with_hidden)
    answer = cbpt.change(SPRING, *tables, effects=["backlash"])
    assert answer.rivals == (("contact_stiffness", "sensor_gain"),)
    assert {c.effect for c in answer.changed} == set(answer.rivals[0])
    assert not answer.hidden


def test_a_zero_of_the_torque_is_no_change_of_the_reducer() -> None:
    """Of a play the curve moves along the torque; the diagnoses of a spring do not propose it."""
    table = play(30.0, seed=2)
    moved = table | {"torque_Nm": table["torque_Nm"] + 0.5}
    answer = cbpt.change(SPRING, play(30.0), moved, effects=["backlash"])
    assert answer.kind == "changed"
    assert [c.effect for c in answer.changed] == ["torque_zero"]
    assert abs(answer.changed[0].after) == pytest.approx(0.5, rel=0.1)
    assert answer.changed[0].direction == "new" and answer.changed[0].probability > 0.95


def test_what_is_not_certain_is_told_as_possible_and_last() -> None:
    """It stood as flatly beside what is certain, and "cannot be told" beside it."""
    answer = found(loops(), loops(1.3, seed=2))
    [friction] = answer.changed
    play = replace(friction, effect="backlash", parameter="play_rad", unit="rad", probability=0.6)
    both = replace(answer, changed=(play, friction)).sentence
    assert both.startswith("friction_hysteresis rose: ") and "; possibly backlash rose: " in both
    assert replace(answer, changed=(play,)).sentence.startswith("Possibly backlash rose: ")


def test_a_friction_that_rises_keeps_the_angle_over_which_it_builds_up() -> None:
    """One number more, and not two: else a gain of the torque, which is one number, stands in for
    a friction and a stiffness that rose both."""
    answer = found(loops(), loops(1.3, seed=2))
    [friction] = answer.changed
    assert friction.parameter == "friction_torque_Nm"
    assert friction.after / friction.before == pytest.approx(1.3, rel=0.02)
    [own] = [u.index for u in answer.weighed.best.levels.fits[0].unknowns if u.name == ENGAGEMENT]
    first, second = (point.values[own] for point in answer.weighed.best.fit.points)
    assert first == second


def test_a_friction_that_builds_up_later_is_told_by_that() -> None:
    answer = found(loops(), loops(engagement_arcsec=60, seed=2))
    assert answer.kind == "changed"
    assert {c.parameter for c in answer.changed} >= {"engagement_angle_rad"}
    [late] = [c for c in answer.changed if c.parameter == "engagement_angle_rad"]
    assert late.moved and late.direction == "up"


def test_a_joint_outside_the_friction_is_one_change() -> None:
    """It was a fall of the stiffness and one of the friction, both for certain."""
    table = loops(seed=2)
    fixed = table["elastic_angle_arcsec"] + 12.0 * table["torque_Nm"]
    answer = found(loops(), table | {"elastic_angle_arcsec": fixed})
    assert answer.kind == "changed"
    assert [(c.effect, c.direction) for c in answer.changed] == [("output_torsion", "up")]
    [joint] = answer.changed
    assert joint.moved and (joint.after - joint.before) * 206265 == pytest.approx(12.0, rel=0.1)
    assert FRICTION in {u.effect for u in answer.unchanged}


@pytest.mark.parametrize(("friction_Nm", "stiffness"), [(0.6, 1.0), (1.0, 0.85)])
def test_what_one_number_explains_is_no_joint(friction_Nm: float, stiffness: float) -> None:
    answer = found(loops(), loops(friction_Nm, stiffness, seed=2))
    assert answer.kind == "changed"
    assert "output_torsion" not in {c.effect for c in answer.changed}


# --- values at the limit of their range ---------------------------------------------------


def changed_from(before: float, after: float, *limits: Limit | None) -> Changed:
    values, u = (before, after), tuple(None if limit else 0.01 for limit in limits)
    return Changed(
        effect="output_torsion",
        parameter="stop_torque_Nm",
        unit="N m",
        before=before,
        after=after,
        u_before=u[0],
        u_after=u[1],
        direction="up",
        probability=0.99,
        values=values,
        u=u,
        limits=limits,
        trend=None,
    )


@pytest.mark.parametrize(
    ("c", "said"),
    [
        (changed_from(1.0, 2.0, None, "upper"), "to at least 2 (the limit of its range)"),
        (changed_from(-2.0, 2.0, "lower", "upper"), "from at most -2 (the limit of its range)"),
        (changed_from(1.0, 2.0, None, "own loops"), "(the most that the small loops allow)"),
        (changed_from(2.0, 2.0, "upper", "upper"), "but no number of it by more than twice"),
        (changed_from(2.0, 2.00001, "upper", "upper"), "but no number of it by more than twice"),
    ],
)
def test_a_value_at_the_limit_of_its_range_has_no_uncertainty(c: Changed, said: str) -> None:
    one = replace(found(loops(1.0), loops(1.5, seed=2)), changed=(c,))
    told = _told(one, ARCSEC, c)
    assert said in told and ("+-" in told) == (c.moved and None in c.limits)


def test_a_difference_known_better_than_both_values_is_told() -> None:
    """ "From 0.0 +- 2.2 to 0.8 +- 2.2" reads as no change."""
    c = changed_from(1.0, 1.8, None, None)
    c = replace(c, u_before=2.2, u_after=2.2, u=(2.2, 2.2), apart=8.0)
    one = replace(found(loops(1.0), loops(1.5, seed=2)), changed=(c,))
    told = _told(one, ARCSEC, c)
    assert "from 1.0 +- 2.2 to 1.8 +- 2.2 (by 0.80 +- 0.10)" in told
    clear = changed_from(1.0, 1.8, None, None)
    assert " (by " not in _told(replace(one, changed=(clear,)), ARCSEC, clear)


def test_of_an_effect_of_which_only_the_shape_moved_that_is_told() -> None:
    """A transition torque that falls is no less play; it was "backlash fell"."""
    both = found(loops(1.0), loops(1.0, seed=2, engagement_arcsec=60))
    assert [(c.parameter, c.is_shape) for c in both.foremost] == [("engagement_angle_rad", True)]
    told = "friction_hysteresis changed: engagement_angle_arcsec rose from"
    assert told in both.sentence.replace("Friction", "friction")
    size = found(loops(1.0), loops(1.5, seed=2))
    assert not size.foremost[0].is_shape and f"{FRICTION} rose: friction_torque" in size.sentence


@pytest.mark.parametrize(("limit", "direction"), [(None, "gone"), ("own loops", "down")])
def test_what_ends_at_a_limit_has_not_disappeared(limit: Limit | None, direction: str) -> None:
    """However uncertain it is: a play as large as the small loops allow is there."""
    assert _direction((6.0, 1.0), (0.5, 0.8), (None, limit), may_vanish=True) == direction
    opposite = {"gone": "new", "down": "up"}[direction]
    assert _direction((1.0, 6.0), (0.8, 0.5), (limit, None), may_vanish=True) == opposite


def test_a_value_at_its_bound_is_at_a_limit() -> None:
    """But for nothing at all, which is no limit of an effect."""
    case = cbpt.Case.from_dict(SPRING)
    readings = [cbpt.read_readings(loops(f), need_preload=False) for f in (1.0, 1.5)]
    levels = levels_of([campaign_of(case, r, []) for r in readings], [FRICTION])
    assert levels is not None
    everything = frozenset(range(len(levels.fits[0].unknowns)))
    free = fit_shared(levels.parties, levels.variants, everything)
    assert free is not None
    size = next(i for i, u in enumerate(levels.fits[0].unknowns) if u.size_of == 0)
    low, high = free.bounds
    assert low[free.slots[1, size]] == 0.0
    held, gone = high.copy(), free.x.copy()
    held[free.slots[1, size]], gone[free.slots[1, size]] = free.x[free.slots[1, size]], 0.0
    limits = []
    for fit in (free, replace(free, bounds=(low, held)), replace(free, x=gone)):
        choice = Choice(frozenset({FRICTION}), levels, fit, 0.0, 1.0)
        [friction, *_] = changed_of(Weighed(groups_of(levels), (choice,)), [False, False])
        limits.append(friction.limits)
        assert (friction.u_after is None) == (friction.limits[1] is not None)
    assert limits == [(None, None), (None, "upper"), (None, None)]


def late(seconds_a_step: float, seed: int) -> dict[str, NDArray[np.float64]]:
    """Two loops with friction, at a rate, read by a torque sensor that is late by 0.4 s."""
    effects = [
        {"id": FRICTION, "friction_torque_Nm": 1.0, "engagement_angle_arcsec": 30.0},
        {"id": "torque_lag", "lag_s": 0.4},
    ]
    case = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}, "effect": effects}
    read = read_from(case, LOOP, seconds_a_step, seed)
    return read | {"u_elastic_angle_arcsec": np.full(2 * len(LOOP), 2.0)}


def test_a_late_sensor_at_another_rate_is_no_certain_change_of_friction() -> None:
    """One lag that both campaigns share explains what the rate does, and nothing has changed."""
    unlike = found(late(1.0, 1), late(0.25, 2))
    assert unlike.kind != "changed" or FRICTION not in {
        c.effect for c in unlike.changed if not c.rivals
    }, unlike.sentence
    assert any("Measure all levels at one rate" in note for note in unlike.notes)
    # A stiff rubber foot at a fifth of the rate had a friction that was new, for certain.
    assert unlike.kind != "changed"
    alike = found(late(1.0, 1), late(1.0, 2))
    assert alike.kind == "nothing", alike.sentence
    assert not any("at one rate" in note for note in alike.notes)


def test_a_bound_in_units_is_not_beyond_the_bound() -> None:
    """By rounding a tenth over its unit, times its unit, may be more: `change` ended with that."""
    read = cbpt.read_readings(loops(), need_preload=False)
    levels = levels_of([campaign_of(cbpt.Case.from_dict(SPRING), read, [])] * 2, [FRICTION])
    assert levels is not None
    first = levels.parties[0].problem
    high = first.high.copy()
    units = np.array([next(u for u in np.linspace(0.5, 1.0, 999) if h / u * u > h) for h in high])
    for party in levels.parties:
        party.problem.unit[:] = units
    system = _System(levels.parties, np.tile(np.arange(len(high)), (2, 1)), frozenset())
    assert np.all(system.high * units > high)
    points = system.points(system.high)
    assert points is not None
    for point in points:
        assert np.all(first.coordinates(point) <= high)


def test_a_gain_that_would_go_beyond_what_is_plausible_explains_nothing() -> None:
    """Beside a law that the model lacks, a gain of 0.7, where its range ends, was told for
    certain on a real reducer whose friction rose."""
    table = play(60.0)
    half = play(60.0, seed=2)
    half["elastic_angle_arcsec"] = 0.5 * half["elastic_angle_arcsec"]
    answer = cbpt.change(SPRING, table, half, effects=["backlash"])
    unknowns = [u.name for u in answer.weighed.best.levels.fits[0].unknowns]
    likely = [c for c in answer.weighed.choices if c.probability > 0.01]
    assert answer.kind == "changed" and likely
    for choice in likely:
        gains = {"torque_scale", "sensor_gain"} & choice.changed
        assert not choice.fit.ends_at_limit([unknowns.index(gain) for gain in gains])


def test_a_change_moves_the_angles_by_what_no_other_one_makes_up_for() -> None:
    """By its values alone each of two that cancel moved the angles by far more than levels differ,
    and both were told for certain beside what the model lacks of a real reducer."""
    tables = [cbpt.read_readings(t, need_preload=False) for t in (play(0.0), stiffened(play(0.0)))]
    levels = levels_of([campaign_of(cbpt.Case.from_dict(SPRING), t, []) for t in tables], [])
    assert levels is not None
    unknowns = [u.name for u in levels.fits[0].unknowns]

    def moves(effect: str, *changed: str) -> float:
        own = frozenset(unknowns.index(name) for name in changed)
        fit = fit_shared(levels.parties, levels.variants, own)
        assert fit is not None
        return moves_of(Choice(frozenset(changed), levels, fit, 0.0), effect)

    alone = moves("contact_stiffness", "contact_stiffness")
    largest = float(np.abs(tables[0].elastic_angle_arcsec).max())
    assert 0.01 * largest < alone < 0.08 * largest
    assert moves("contact_stiffness", "contact_stiffness", "sensor_gain") < 0.01 * alone


def test_a_choice_without_one_change_is_another_choice() -> None:
    """The angle over which friction builds up changes with a joint. A choice without it was the
    same again, and the search for fewer changes never ended."""
    search = object.__new__(Search)
    search.levels = cast(Any, SimpleNamespace(alongside=(("output_torsion", 1),)))
    search.groups = (
        Group("friction_hysteresis", (0, 1), (0,)),
        Group("output_torsion", (2,), (2,)),
    )
    assert set(search._less(frozenset({0, 1, 2}))) == {frozenset({1, 2}), frozenset({0, 1})}


def test_an_effect_appears_with_all_of_its_sizes_and_is_told_by_those_that_moved() -> None:
    """A friction that came to grow with the load was said to have fallen, by the part of it that
    hardly moved; the part that grew did not make the friction new."""
    one = found(loops(1.0), loops(1.5, seed=2)).changed[0]
    torque = replace(one, parameter="friction_torque_Nm", values=(0.2, 0.18), apart=2.01)
    share = replace(one, parameter="load_share", values=(0.001, 0.06), u=(0.003, 0.002), apart=19.8)
    share = replace(share, direction="new", limits=(None, None))
    torque = replace(torque, u=(0.026, 0.027), direction="down", limits=(None, None))
    assert _of_effect(share, [torque, share]).direction == "up"
    assert _of_effect(share, [share]).direction == "new"
    told = replace(found(loops(1.0), loops(1.5, seed=2)), changed=(torque, share))
    assert [c.parameter for c in told.foremost] == ["load_share"]
    both = replace(told, changed=(replace(torque, apart=9.0), share))
    assert [c.parameter for c in both.told_of(one.effect)] == ["friction_torque_Nm", "load_share"]
    assert "friction_hysteresis changed: " in _told(both, ARCSEC, both.foremost[0])
