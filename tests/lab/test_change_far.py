"""Property: what is not searched to its end because it is far below the best changes no answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cbpt
from cbpt.lab.change import posterior, shared
from cbpt.lab.change.change import _searched_through
from cbpt.lab.change.parties import EachAlone, Levels, levels_of
from cbpt.lab.change.posterior import Search, in_reach
from cbpt.lab.change.progress import untold
from cbpt.lab.change.shared import Until, fit_shared, foreseen
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.selection import fit_effects
from common.counted import calls_of
from common.springs import Reducer, loops

CASE = cbpt.Case.from_dict(
    {
        "torsion_spring": {"torsional_stiffness_Nm_per_rad": 2000.0},
        "measurement": {"zero": "per_run"},
        "uncertainty": {"contact_stiffness_rel": 0.3},
    }
)
BOTH = ["backlash", "friction_hysteresis"]
STATE = Reducer(play_rad=0.004, friction_Nm=1.5)
STATES = STATE, replace(STATE, play_rad=0.002), replace(STATE, play_rad=0.001, friction_Nm=2.0)


def table(state: Reducer, seed: int) -> cbpt.Readings:
    columns = loops([state] * 2, noise_rad=5e-5, seed=seed)
    del columns["preload_step"]
    return cbpt.read_readings(columns, need_preload=False)


def levels(states: tuple[Reducer, ...], effects: list[str], case: cbpt.Case = CASE) -> Levels:
    tables = [table(state, seed) for seed, state in enumerate(states, 1)]
    found = levels_of([campaign_of(case, t, []) for t in tables], effects)
    assert found is not None
    return found


def reached(sets: list[Levels]) -> list[Levels]:
    return [search.levels for search in in_reach(sets)]


def test_a_search_without_a_chance_ends_early(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared, "_EFFORT", replace(shared._EFFORT, looks=1))
    of = levels(STATES, BOTH)
    whole = fit_shared(of.parties, of.variants, frozenset())
    assert whole is not None
    reached = fit_shared(
        of.parties, of.variants, frozenset(), until=Until(least=whole.log_evidence - 1)
    )
    assert reached is not None
    assert reached.log_evidence == pytest.approx(whole.log_evidence, rel=1e-9)
    ended = fit_shared(
        of.parties, of.variants, frozenset(), until=Until(least=whole.log_evidence + 1e6)
    )
    assert ended is not None and ended.log_evidence < whole.log_evidence - 1e-3


def test_what_a_search_is_to_reach_is_foreseen() -> None:
    """Where values apart differ by little, the model is linear between them: the evidence of one
    value for all is that which a search finds. Of values far apart the order of two is."""
    same = (STATE,) * 3
    of = levels(same, BOTH)
    every = frozenset(range(len(of.fits[0].unknowns)))
    apart = fit_shared(of.parties, of.variants, every)
    assert apart is not None
    for separate in (frozenset[int](), frozenset({0}), every):
        found = fit_shared(of.parties, of.variants, separate)
        assert found is not None
        reached = foreseen(of.parties, of.variants, separate, apart)
        assert reached == pytest.approx(found.log_evidence, abs=0.5), separate
    of = levels(STATES, BOTH)
    apart = fit_shared(of.parties, of.variants, every)
    assert apart is not None
    one = foreseen(of.parties, of.variants, frozenset(), apart)
    assert one < foreseen(of.parties, of.variants, every, apart) - 100


def test_sets_without_a_chance_are_left() -> None:
    bare, play, both = (levels(STATES, effects) for effects in ([], ["backlash"], BOTH))
    assert reached([bare, play, both]) == [both]
    assert reached([bare]) == [bare]
    same = replace(STATE, friction_Nm=0.0, play_rad=0.0)
    none, more = levels((same, same), []), levels((same, same), ["backlash"])
    assert reached([none, more]) == [none, more]


def test_what_is_stated_of_a_number_drops_no_set() -> None:
    """A stiffness that is off by many of its uncertainties costs once where it is shared, and once
    for each level where it is not: no set was left, and the model was said to have no solution."""
    stated = cbpt.Case.from_dict(
        {
            "torsion_spring": {"torsional_stiffness_Nm_per_rad": 1600.0},
            "measurement": {"zero": "per_run"},
            "uncertainty": {"contact_stiffness_rel": 0.02},
        }
    )
    same = (replace(STATE, friction_Nm=0.0, play_rad=0.0),) * 4
    none, more = levels(same, [], stated), levels(same, ["backlash"], stated)
    assert reached([none, more]) == [none, more]


def test_several_sets_are_weighed_as_if_all_were_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    sets = [levels(STATES, effects) for effects in (["backlash"], [], BOTH)]
    found = _searched_through(sets, lambda one: one, (), untold)
    monkeypatch.setattr(posterior, "_EFFORT", replace(posterior._EFFORT, far=np.inf))
    whole = _searched_through(sets, lambda one: one, (), untold)
    assert found is not None and whole is not None
    assert found.best.changed == whole.best.changed == set(BOTH)
    assert found.best.log_odds == pytest.approx(whole.best.log_odds, abs=1e-3)
    for group in whole.groups:
        assert found.changed(group.effect) == pytest.approx(whole.changed(group.effect), abs=1e-3)


def test_what_is_foreseen_to_have_no_say_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    of = levels(STATES, [*BOTH, "stiffness_curve", "creep"])
    made = calls_of(monkeypatch, posterior, "fit_shared")
    fits, best = [], []
    for effort in (replace(posterior._EFFORT, far=np.inf, room=np.inf), posterior._EFFORT):
        made.clear()
        monkeypatch.setattr(posterior, "_EFFORT", effort)
        search = Search(of)
        search.score(frozenset())
        search.more(untold)
        search.fewer(untold)
        fits.append(len(made))
        best.append(max(search.scored, key=lambda own: search.scored[own][1]))
    assert fits[1] < 0.7 * fits[0]
    assert best[1] == best[0]


def test_one_set_of_effects_begins_where_another_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each effect by itself was sought again with every set."""
    made = calls_of(monkeypatch, Fitter, "fit")
    # Many forms, of which one is exchanged at a time.
    monkeypatch.setattr(fit_effects, "_EFFORT", replace(fit_effects._EFFORT, whole=4))
    campaigns = [campaign_of(CASE, table(state, seed), []) for seed, state in enumerate(STATES)]
    every = [*BOTH, "stiffness_curve"]
    alone = EachAlone(campaigns, every)
    alone.levels_of(BOTH)
    made.clear()
    after = alone.levels_of(every)
    begun = len(made)
    by_itself = levels_of(campaigns, every)
    assert begun < 0.8 * (len(made) - begun)
    assert after is not None and by_itself is not None
    of_both = [sum(fit.log_evidence for fit in found.fits) for found in (after, by_itself)]
    assert of_both[0] > of_both[1] - 0.5


def test_the_answer_is_that_of_a_search_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    before, after = (table(state, seed) for seed, state in enumerate(STATES[1:], 1))
    found = cbpt.change(CASE, before, after, effects=BOTH)
    monkeypatch.setattr(posterior, "_EFFORT", replace(posterior._EFFORT, far=np.inf))
    whole = cbpt.change(CASE, before, after, effects=BOTH)
    assert found.kind == whole.kind == "changed"
    for one, other in zip(found.changed, whole.changed, strict=True):
        assert (one.effect, one.parameter, one.direction) == (
            other.effect,
            other.parameter,
            other.direction,
        )
        assert one.probability == pytest.approx(other.probability, abs=1e-3)
        assert one.values == pytest.approx(other.values, rel=1e-6)


def test_what_has_a_say_is_fitted_to_its_end() -> None:
    """All choices are ranked first, by searches that end sooner."""
    of = levels(STATES, BOTH)
    whole, ranked = (
        fit_shared(of.parties, of.variants, frozenset(), until=Until(r)) for r in (False, True)
    )
    assert whole is not None and ranked is not None and ranked.misfit > whole.misfit + 1e-3
    search = Search(of)
    search.choices()
    near = search.best - 12.0
    last = [(own, fit) for own, (fit, odds) in search.scored.items() if odds > near]
    assert last
    for own, fit in last:
        further = fit_shared(of.parties, of.variants, own, fit.points)
        assert further is not None and further.misfit > fit.misfit - 0.05


def test_sets_near_the_best_one_of_a_spring_are_fitted_to_their_end() -> None:
    found = cbpt.diagnose(CASE, table(STATE, 3)).competition
    best = max(found.log_odds.values())
    near = [names for names, odds in found.log_odds.items() if odds > best - 20 and len(names) > 1]
    assert len(near) > 1
    assert all(found.fits[names].converged for names in near)
