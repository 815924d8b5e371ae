"""What is read off a posterior over sets of effects, on probabilities made up by hand.

Groups: probabilities; certain; rivals; likely.
"""

from __future__ import annotations

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbpt.lab.selection.posterior import OFFSET, Posterior, Spoken, spoken_of
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names
from common.drives import examples

POOL = ("bearing", "creep", "friction", "loss", "spring", "torsion")


def of(**shares: float) -> Posterior:
    """By sets written as a_b; `nothing` stands for the drive as stated."""
    sets = {() if k == "nothing" else tuple(sorted(k.split("_"))): p for k, p in shares.items()}
    assert sum(sets.values()) == pytest.approx(1)
    return Posterior(sets)


def spoken(**shares: float) -> Spoken:
    return spoken_of(of(**shares), RULES)


SETS = st.sets(st.sampled_from(POOL), max_size=3).map(lambda s: tuple(sorted(s)))


@st.composite
def posteriors(draw: st.DrawFn) -> Posterior:
    """Some of them with one set far ahead, some with many alike."""
    weights = draw(st.dictionaries(SETS, st.floats(-9, 0).map(lambda x: 10**x), min_size=1))
    total = sum(weights.values())
    return Posterior({names: weight / total for names, weight in weights.items()})


def share(posterior: Posterior, holds: object) -> float:
    """The sum over the sets of which something holds."""
    assert callable(holds)
    return sum(p for names, p in posterior.sets.items() if holds(set(names)))


# --- probabilities ------------------------------------------------------------------------


@given(posteriors(), st.sets(st.sampled_from(POOL), min_size=1))
@examples(80)
def test_probabilities_are_sums_over_sets(posterior: Posterior, some: set[str]) -> None:
    assert posterior.of_any(some) == pytest.approx(share(posterior, lambda s: len(s & some) >= 1))
    several = share(posterior, lambda s: len(s & some) >= 2)
    assert posterior.of_several(some) == pytest.approx(several)
    assert posterior.of_all(some) == pytest.approx(share(posterior, lambda s: s >= some))
    assert posterior.within(some) == pytest.approx(share(posterior, lambda s: s <= some))
    assert posterior.of_any(some) + share(posterior, lambda s: not s & some) == pytest.approx(1)


@given(posteriors(), st.sets(st.sampled_from(POOL)), st.sets(SETS))
@examples(80)
def test_what_the_readings_do_not_demand_speaks_against_nothing(
    posterior: Posterior, allowed: set[str], undemanded: set[Names]
) -> None:
    found = Posterior(posterior.sets, frozenset(undemanded)).demands_at_most(allowed)
    holds = [p for n, p in posterior.sets.items() if set(n) <= allowed or n in undemanded]
    assert found == pytest.approx(sum(holds))


@given(posteriors())
@examples(50)
def test_inclusion_is_the_share_of_the_sets_that_hold_an_effect(posterior: Posterior) -> None:
    expected = {e: share(posterior, lambda s, e=e: e in s) for e in POOL}
    assert posterior.inclusion == pytest.approx(
        {e: p for e, p in expected.items() if any(e in n for n in posterior.sets)}
    )


def test_what_is_said_counts_every_group() -> None:
    posterior = of(bearing_loss=0.4, loss_torsion=0.3, bearing=0.2, nothing=0.1)
    groups = [("bearing", "torsion")]
    assert posterior.of_all(["loss"], groups) == pytest.approx(0.7)
    assert posterior.of_all([], groups) == pytest.approx(0.9)
    assert posterior.best == ("bearing", "loss")


# --- certain ------------------------------------------------------------------------------


@given(posteriors())
@examples(150)
def test_certain_is_what_nearly_all_of_the_posterior_holds(posterior: Posterior) -> None:
    inclusion = posterior.inclusion
    expected = {e for e, p in inclusion.items() if p >= RULES.certain}
    assert set(spoken_of(posterior, RULES).effects) == expected


@pytest.mark.parametrize(("inclusion", "certain"), [(0.951, True), (0.949, False)])
def test_the_limit_is_that_of_the_inclusion(inclusion: float, certain: bool) -> None:
    said = spoken(friction=inclusion - 0.5, friction_loss=0.5, nothing=1 - inclusion)
    assert ("friction" in said.effects) == certain


def test_a_superset_takes_nothing_from_an_effect() -> None:
    """Friction is in every set, whatever else is."""
    said = spoken(friction=0.3, creep_friction=0.3, friction_loss=0.2, friction_spring=0.2)
    assert said.effects == ("friction",)
    assert {e for e, _ in said.perhaps} == {"creep", "loss", "spring"}


def test_a_certain_superset_is_certain_as_a_whole() -> None:
    assert spoken(creep_friction=0.96, friction=0.04).effects == ("creep", "friction")


# --- rivals -------------------------------------------------------------------------------


def valid(posterior: Posterior, group: Names) -> bool:
    """One of them certain, two improbable."""
    return (
        share(posterior, lambda s: bool(s & set(group))) >= RULES.certain
        and share(posterior, lambda s: len(s & set(group)) > 1) < RULES.together
    )


@given(posteriors())
@examples(150)
def test_groups_are_what_they_are_said_to_be(posterior: Posterior) -> None:
    """A group holds one that is needed; what is certain is in none, and what is improbable only
    where a group alone needs it."""
    said = spoken_of(posterior, RULES)
    inclusion = posterior.inclusion
    told = [e for g in said.rivals for e in g]
    assert len(told) == len(set(told))
    assert not {*told} & {*said.effects}
    for group in said.rivals:
        assert len(group) > 1
        assert posterior.of_any(group) >= RULES.certain
        assert all(inclusion[e] < RULES.certain for e in group)
        if said.effects or len(said.rivals) > 1:
            assert valid(posterior, group)
        elif any(inclusion[e] < RULES.likely for e in group):
            least = min(group, key=lambda e: inclusion[e])
            assert posterior.of_any(set(group) - {least}) < RULES.certain


@given(posteriors())
@examples(150)
def test_no_group_is_overlooked(posterior: Posterior) -> None:
    """By a search of its own over all subsets of what is open."""
    said = spoken_of(posterior, RULES)
    open_ = [e for e, p in posterior.inclusion.items() if RULES.likely <= p < RULES.certain]
    possible = [
        g
        for size in range(2, len(open_) + 1)
        for g in combinations(open_, size)
        if valid(posterior, g)
    ]
    for group in possible:
        assert any(set(group) & set(told) for told in said.rivals)


def test_two_that_exclude_each_other_are_rivals() -> None:
    said = spoken(bearing=0.6, torsion=0.38, nothing=0.02)
    assert (said.effects, said.rivals, said.perhaps) == ((), (("bearing", "torsion"),), ())


@pytest.mark.parametrize(("both", "rivals"), [(0.19, True), (0.21, False)])
def test_two_that_may_be_at_work_together_are_no_rivals(both: float, rivals: bool) -> None:
    rest = 1 - both
    said = spoken(bearing_loss_torsion=both, bearing_loss=rest * 0.6, loss_torsion=rest * 0.4)
    assert said.effects == ("loss",)
    assert bool(said.rivals) == rivals
    assert {e for e, _ in said.perhaps} == (set() if rivals else {"bearing", "torsion"})


def test_a_group_is_as_small_as_can_be() -> None:
    said = spoken(bearing=0.5, torsion=0.46, spring=0.04)
    assert said.rivals == (("bearing", "torsion"),)
    assert spoken(bearing=0.5, torsion=0.40, spring=0.1).rivals == (
        ("bearing", "spring", "torsion"),
    )


def test_two_places_have_two_groups() -> None:
    said = spoken(bearing_loss=0.3, bearing_spring=0.25, loss_torsion=0.25, spring_torsion=0.2)
    assert said.rivals == (("bearing", "torsion"), ("loss", "spring"))
    assert not said.effects and not said.perhaps


def test_one_or_more_of_several_is_told_where_nothing_else_is() -> None:
    """Both together are as likely as one of them: no rivals, but one at least is at work."""
    said = spoken(bearing=0.3, torsion=0.3, bearing_torsion=0.38, nothing=0.02)
    assert said.rivals == (("bearing", "torsion"),)
    # Beside what is certain they are likely, and no more.
    beside = spoken(bearing_loss=0.3, loss_torsion=0.3, bearing_loss_torsion=0.38, loss=0.02)
    assert beside.effects == ("loss",) and beside.rivals == ()


def test_it_may_take_an_improbable_one_for_a_group_to_be_certain() -> None:
    said = spoken(bearing=0.945, torsion=0.045, nothing=0.01)
    assert said.rivals == (("bearing", "torsion"),)
    sets = {("bearing", OFFSET): 0.945, (OFFSET, "torsion"): 0.045, (OFFSET,): 0.01}
    zeros = Posterior(sets)
    assert spoken_of(zeros, RULES).effects == (OFFSET,)
    assert spoken_of(zeros, RULES).rivals == (("bearing", "torsion"),)


def test_offsets_of_runs_are_not_certain_by_their_prior_odds_alone() -> None:
    """An eccentricity that follows the readings as well has the likelihood of the offsets, and
    0.03 of their odds. Certain is what the readings say, so each of both may be it."""
    twins = Posterior({(OFFSET,): 0.97, ("eccentricity",): 0.03 * 0.97, ("loss",): 0.0009})
    said = spoken_of(twins, RULES)
    assert said.effects == () and said.rivals == (("eccentricity", OFFSET),)
    # An effect that follows them less well is no rival.
    ahead = Posterior({(OFFSET,): 0.999, ("eccentricity",): 0.001})
    assert spoken_of(ahead, RULES) == Spoken((OFFSET,), (), ())


# --- likely -------------------------------------------------------------------------------


@given(posteriors())
@examples(150)
def test_everything_likely_is_told_once(posterior: Posterior) -> None:
    said = spoken_of(posterior, RULES)
    inclusion = posterior.inclusion
    told = [*said.effects, *(e for g in said.rivals for e in g), *(e for e, _ in said.perhaps)]
    likely = {e for e, p in inclusion.items() if p >= RULES.likely}
    assert len(told) == len(set(told)) and likely <= set(told)
    # What is not likely stands in a group alone, where it takes it for the group to be certain.
    assert not set(told) - likely or (
        len(said.rivals) == 1 and set(told) - likely < set(said.rivals[0])
    )
    assert dict(said.perhaps) == {e: inclusion[e] for e, _ in said.perhaps}


@pytest.mark.parametrize(("chance", "told"), [(0.051, True), (0.049, False)])
def test_the_improbable_is_not_told(chance: float, told: bool) -> None:
    said = spoken(friction=1 - chance, creep_friction=chance)
    assert said.effects == ("friction",)
    assert said.perhaps == ((("creep", chance),) if told else ())


def test_the_likely_are_in_order_of_their_probability() -> None:
    said = spoken(friction=0.4, creep_friction=0.1, friction_loss=0.3, friction_spring=0.2)
    assert [e for e, _ in said.perhaps] == ["loss", "spring", "creep"]
