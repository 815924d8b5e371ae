"""From odds to words: the rules on odds made up by hand.

The readings are those of a real table; fits and odds are made up, and so is how well a fit predicts
readings that are kept back. What is read off a posterior and what is left beside a name have tests
of their own (`test_posterior`, `test_remains`).

Groups: effects demanded; something without a name; no effect demanded;
what is left; undecided; probabilities.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.repeatability import Repeats
from cbpt.lab.diagnosis.rarer import by_prior_odds_alone
from cbpt.lab.model.dataset import DEFAULT_UNCERTAINTY, Campaign
from cbpt.lab.model.priors import PRIORS, TWINS
from cbpt.lab.selection.adequacy import Source
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.decision import Verdict, judge, shifts
from cbpt.lab.selection.posterior import posterior_of
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names, prior
from common.drives import examples
from common.made_up import (
    NUMBERS,
    Around,
    MadeUpFit,
    Shares,
    competition,
    predicts_as_made_up,
    said,
    white,
)
from common.simulated import Floats, plan

BEARING, TORSION, FRICTION = "eccentric_bearing", "output_torsion", "friction_hysteresis"
LOSS, SPRING, CREEP, RUNOUT = "preload_loss", "preload_spring", "creep", "eccentricity_error"
OFFSETS = Noise(offset_arcsec=0.5)


@pytest.fixture(autouse=True, scope="module")
def kept_back() -> Iterator[None]:
    with predicts_as_made_up():
        yield


# --- effects demanded ---------------------------------------------------------------------


def test_one_effect_far_ahead_is_certain() -> None:
    verdict = judge(competition({(): 0.01, (FRICTION,): 0.98, (LOSS,): 0.01}))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.names == (FRICTION,) and verdict.noise == ("white",)
    assert verdict.probability == pytest.approx(0.98) == verdict.exactly
    assert verdict.undecided is None and verdict.lack_of_fit is None


def test_what_is_said_may_be_surer_than_the_whole_of_it() -> None:
    """Two probabilities: that friction is at work, and that nothing else is."""
    verdict = judge(competition({(): 0.01, (FRICTION,): 0.6, (CREEP, FRICTION): 0.39}))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.probability == pytest.approx(0.99)
    assert verdict.exactly == pytest.approx(0.6)
    assert dict(verdict.perhaps) == {CREEP: pytest.approx(0.39)}


def test_the_most_probable_set_is_drawn_even_where_a_smaller_one_is_near() -> None:
    """A larger set used to be dropped within odds of 20."""
    verdict = judge(competition({(): 0.01, (FRICTION,): 0.33, (CREEP, FRICTION): 0.66}))
    assert verdict.names == (CREEP, FRICTION)
    assert verdict.exactly == pytest.approx(0.66)
    assert verdict.effects == (FRICTION,) and dict(verdict.perhaps)[CREEP] == pytest.approx(0.66)


def test_rivals_are_ambiguous() -> None:
    verdict = judge(competition({(): 0.01, (BEARING,): 0.55, (TORSION,): 0.44}))
    assert said(verdict) == ("ambiguous", (), ((BEARING, TORSION),))
    assert verdict.probability == pytest.approx(0.99)
    assert verdict.exactly == pytest.approx(0.55)
    assert verdict.names == (BEARING,)


def test_what_all_sets_have_is_certain_and_the_rest_rivals() -> None:
    shares = {(): 0.001, (BEARING, FRICTION): 0.6, (FRICTION, TORSION): 0.389, (FRICTION,): 0.01}
    verdict = judge(competition(shares))
    assert said(verdict) == ("ambiguous", (FRICTION,), ((BEARING, TORSION),))
    assert verdict.probability == pytest.approx(0.989)


def test_what_is_less_probable_by_its_prior_odds_alone_is_told() -> None:
    """A gain that drifts is taken to be 150 times rarer than wear."""
    made_up = competition({(): 0.001, ("wear",): 0.9934, ("span_drift",): 0.0056})
    verdict = judge(made_up)
    assert said(verdict) == ("effect", ("wear",), ())
    (note,) = by_prior_odds_alone(made_up, verdict)
    assert note.startswith("span_drift would explain these readings about as well as wear")
    assert "at least 150 times as high" in note
    # What the readings themselves speak against is not told.
    behind = competition({(): 0.001, ("wear",): 0.9989, ("span_drift",): 0.0001})
    assert list(by_prior_odds_alone(behind, judge(behind))) == []


POOL = (BEARING, TORSION, FRICTION, LOSS, SPRING, CREEP)
SETS = st.sets(st.sampled_from(POOL), min_size=1, max_size=3).map(lambda s: tuple(sorted(s)))


@st.composite
def weights(draw: st.DrawFn) -> dict[Names, float]:
    """Of some sets; () is always weighed."""
    scale = st.floats(-6, 0).map(lambda x: 10**x)
    found = {(): draw(scale), **draw(st.dictionaries(SETS, scale, max_size=6))}
    total = sum(found.values())
    return {names: value / total for names, value in found.items()}


@given(weights())
@examples(60)
def test_an_answer_is_that_of_its_posterior(shares: dict[Names, float]) -> None:
    """Certain effects, the set that is drawn, both probabilities."""
    verdict = judge(competition(shares))
    inclusion = {e: sum(p for n, p in shares.items() if e in n) for e in POOL}
    told = {*verdict.effects, *(e for g in verdict.rivals for e in g)} - set(PRIORS)
    if verdict.kind == "undecided":
        # Nothing is certain, no group holds what is needed, and nothing is not the answer.
        assert max(inclusion.values()) < RULES.certain
        assert shares[()] < RULES.undecided
        assert not told and not verdict.names
        return
    assert set(verdict.effects) == {e for e, p in inclusion.items() if p >= RULES.certain}
    if not told:
        assert verdict.kind == "complete" and shares[()] >= RULES.undecided
        idle = [p for n, p in shares.items() if n and p <= shares[()] * np.exp(prior(n))]
        assert verdict.probability == pytest.approx(shares[()] + sum(idle))
        return
    best = max(shares, key=lambda n: shares[n])
    assert verdict.names == best and verdict.exactly == pytest.approx(shares[best])
    true_of = [
        p
        for n, p in shares.items()
        if set(verdict.effects) <= set(n) and all(set(g) & set(n) for g in verdict.rivals)
    ]
    assert verdict.probability == pytest.approx(sum(true_of))
    assert verdict.probability >= RULES.undecided
    assert (verdict.kind == "ambiguous") == bool(verdict.rivals)


def test_gains_and_numbers_have_kinds_of_their_own() -> None:
    def of(*names: str) -> Verdict:
        return judge(competition({(): 0.01, names: 0.99}))

    assert said(of("drift")) == ("rig", ("drift",), ())
    assert said(of("drift", FRICTION)) == ("effect", ("drift", FRICTION), ())
    assert said(of("contact_stiffness")) == ("parameter", ("contact_stiffness",), ())
    assert of("contact_stiffness", FRICTION).kind == "effect"


def test_an_answer_tells_the_calibrations_it_rests_on() -> None:
    gain = MadeUpFit(log_marginal=98.0, values={"preload_scale.preload_gain": (1.0, 0.02, 0.85)})
    not_as_good = 100 - 2.5 * RULES.log_rival_odds
    far = MadeUpFit(log_marginal=not_as_good, values={"torque_scale.torque_gain": (1.0, 0.01, 1.1)})
    shares = {(): 1e-3, (LOSS,): 0.997, ("preload_scale",): 1e-3, ("torque_scale",): 1e-3}
    fits = {
        (LOSS,): MadeUpFit(log_marginal=100.0),
        ("preload_scale",): gain,
        ("torque_scale",): far,
    }
    verdict = judge(competition(shares, fits))
    assert said(verdict) == ("effect", (LOSS,), ())
    (rest,) = verdict.rests_on
    assert (rest.number, rest.prior) == ("preload_scale", 0.02)
    assert rest.needed_shift_sigma == pytest.approx(-7.5)
    assert not verdict.within_uncertainty
    known = Around(calibrations={"preload_scale": 0.0})
    assert judge(competition(shares, fits, known)).rests_on == ()


def with_offsets(shares: Shares, *without: Any) -> Competition:
    """All fits have offsets of runs, but for some."""
    fits = {n: MadeUpFit(OFFSETS, sizes=len(n)) for n in shares if n not in without}
    if () in fits:
        fits[()] = MadeUpFit(OFFSETS, values=dict(NUMBERS))
    return competition(shares, fits)


def test_offsets_of_runs_are_a_member_of_the_sets() -> None:
    """The runout explains what else is an offset of each run."""
    rivals = judge(with_offsets({(): 0.4, (RUNOUT,): 0.6}, (RUNOUT,)))
    assert said(rivals) == ("ambiguous", (), ((RUNOUT, "run_offset"),))
    assert rivals.names == (RUNOUT,)
    ahead = judge(with_offsets({(): 0.02, (RUNOUT,): 0.98}, (RUNOUT,)))
    assert said(ahead) == ("effect", (RUNOUT,), ())
    behind = judge(with_offsets({(): 0.999, (RUNOUT,): 0.001}, (RUNOUT,)))
    assert said(behind) == ("rig", ("run_offset",), ())
    assert behind.probability == pytest.approx(1.0) and behind.exactly == pytest.approx(0.999)
    # The readings say as much of both, and only the prior odds do not.
    alike = judge(with_offsets({(): 0.98, (RUNOUT,): 0.02}, (RUNOUT,)))
    assert said(alike) == ("ambiguous", (), ((RUNOUT, "run_offset"),))


def test_offsets_beside_an_effect_are_told() -> None:
    verdict = judge(with_offsets({(): 0.01, (FRICTION,): 0.99}))
    assert said(verdict) == ("effect", (FRICTION, "run_offset"), ())
    assert verdict.names == (FRICTION,) and verdict.noise == ("run_offset",)


# --- something without a name -------------------------------------------------------------


def test_a_lack_of_fit_alone_is_unknown() -> None:
    verdict = judge(competition({(): 0.01, ("unknown",): 0.97, (FRICTION,): 0.02}))
    assert said(verdict) == ("unknown", (), ())
    assert verdict.lack_of_fit is not None and verdict.lack_of_fit.base == ()
    assert verdict.probability == pytest.approx(0.97)


def test_what_has_no_name_rests_on_nothing_and_tells_its_own_noise() -> None:
    """A gain explains the readings as well, but it is not what is said."""
    gain = MadeUpFit(values={"preload_scale.preload_gain": (1.0, 0.02, 0.85)})
    shares = {(): 0.01, ("unknown",): 0.97, ("preload_scale",): 0.02}
    around = Around(lack_noise=Noise(correlation=0.5))
    verdict = judge(competition(shares, {("preload_scale",): gain}, around))
    assert verdict.kind == "unknown" and verdict.rests_on == ()
    assert verdict.noise == ("correlated",)


def test_a_lack_of_fit_as_probable_as_an_effect_is_its_rival() -> None:
    verdict = judge(competition({(): 0.01, ("unknown",): 0.45, (FRICTION,): 0.54}))
    assert said(verdict) == ("ambiguous", (), ((FRICTION, "unknown"),))


def test_a_lack_of_fit_that_is_only_likely_is_told_as_such() -> None:
    shares = {(): 0.01, (FRICTION,): 0.69, (FRICTION, "unknown"): 0.3}
    verdict = judge(competition(shares))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.lack_of_fit is None
    assert dict(verdict.perhaps) == {"unknown": pytest.approx(0.3)}


# --- no effect demanded -------------------------------------------------------------------


def moved(number: str, sigmas: float, nominal_chi2: float = 400.0) -> Verdict:
    values = NUMBERS | {number: (1.0, 0.02, 1.0 + 0.02 * sigmas)}
    around = Around(nominal_chi2=nominal_chi2)
    return judge(competition({(): 1.0}, {(): MadeUpFit(values=values)}, around))


def test_nothing_is_missing() -> None:
    verdict = judge(competition({(): 0.94, (FRICTION,): 0.04, (LOSS,): 0.02}))
    assert said(verdict) == ("complete", (), ())
    assert not verdict.within_uncertainty and verdict.rests_on == ()
    assert verdict.exactly == pytest.approx(0.94) and verdict.perhaps == ()
    assert verdict.probability == pytest.approx(0.96)


def test_nothing_is_missing_but_something_may_be() -> None:
    verdict = judge(competition({(): 0.6, (FRICTION,): 0.3, (LOSS,): 0.1}))
    assert verdict.kind == "complete" and verdict.probability == pytest.approx(0.6)
    assert dict(verdict.perhaps) == {FRICTION: pytest.approx(0.3), LOSS: pytest.approx(0.1)}


def test_numbers_that_move_within_what_is_stated() -> None:
    verdict = moved("contact_stiffness", 1.5)
    assert said(verdict) == ("complete", (), ()) and verdict.within_uncertainty
    (rest,) = verdict.rests_on
    assert rest.number == "contact_stiffness" and rest.needed_shift_sigma == pytest.approx(1.5)


LOOSE = Around(nominal_chi2=400.0, calibrations={"sensor_gain": 0.1})


def test_a_drive_of_which_nothing_is_refitted() -> None:
    verdict = judge(competition({(): 1.0}, {(): MadeUpFit()}, Around(nominal_chi2=400.0)))
    assert said(verdict) == ("complete", (), ()) and not verdict.within_uncertainty


def test_only_numbers_of_drive_and_instrument_shift() -> None:
    """Another with a prior of its own says nothing of the drive."""
    fit = MadeUpFit(values=NUMBERS | {"offset": (0.0, 0.1, 5.0)}, sizes=1)
    assert set(shifts(cast(Any, fit))) == set(PRIORS)


def test_calibrations_known_loosely_share_a_shift() -> None:
    """Instrument and drive explain the same, and neither is known well."""
    null = MadeUpFit(values=NUMBERS | {"contact_stiffness": (1.0, 0.02, 1.03)})
    verdict = judge(competition({(): 1.0}, {(): null}, LOOSE))
    assert said(verdict) == ("ambiguous", (), (tuple(sorted(PRIORS)),))
    assert verdict.within_uncertainty
    close = judge(competition({(): 1.0}, {(): null}, Around(nominal_chi2=400.0)))
    assert close.kind == "complete"
    limit = RULES.loose_calibration * DEFAULT_UNCERTAINTY["sensor_gain"]
    at_limit = replace(LOOSE, calibrations={"sensor_gain": limit})
    assert judge(competition({(): 1.0}, {(): null}, at_limit)).kind == "ambiguous"


@pytest.mark.parametrize("others", [(), ("contact_stiffness",)])
def test_only_numbers_that_share_a_shift_are_rivals(others: tuple[str, ...]) -> None:
    null = MadeUpFit(values=NUMBERS | {"sensor_gain": (1.0, 0.02, 1.03)})
    sharing = (*others, "sensor_gain")
    around = replace(LOOSE, sharing=dict.fromkeys(sharing, 1.0))
    verdict = judge(competition({(): 1.0}, {(): null}, around))
    assert said(verdict) == (("ambiguous", (), (sharing,)) if others else ("complete", (), ()))


@pytest.mark.parametrize(
    ("slope", "shift_sigma", "kind"),
    [(10.0, 1.5, "ambiguous"), (100.0, 1.5, "complete"), (1.0, 3.0, "complete")],
)
def test_what_shares_a_shift_is_as_probable_and_within_two_sigma(
    slope: float, shift_sigma: float, kind: str
) -> None:
    """The readings tell a number of ten times the slope ten times better, so that it would have to
    be there more precisely: log odds of 2.3 against it, and 1.1 for it, as it moves less."""
    null = MadeUpFit(values=NUMBERS | {"contact_stiffness": (1.0, 0.02, 1.03)})
    sharing = {"contact_stiffness": 1.0, "sensor_gain": slope}
    around = replace(LOOSE, sharing=sharing, shift_sigma=shift_sigma)
    assert judge(competition({(): 1.0}, {(): null}, around)).kind == kind


@pytest.mark.parametrize("value", [0.01, 100.0])
def test_a_number_at_the_end_of_its_range_has_its_twins_as_rivals(value: float) -> None:
    null = MadeUpFit(values=NUMBERS | {"contact_stiffness": (1.0, 0.02, value)})
    verdict = judge(competition({(): 1.0}, {(): null}, Around(nominal_chi2=400.0)))
    rivals = tuple(sorted({"contact_stiffness", *TWINS["contact_stiffness"]}))
    assert len(rivals) > 1 and said(verdict) == ("ambiguous", (), (rivals,))
    null.values["contact_stiffness"] = (1.0, 0.02, value * (1.5 if value < 1 else 0.9))
    verdict = judge(competition({(): 1.0}, {(): null}, Around(nominal_chi2=400.0)))
    assert said(verdict) == ("parameter", ("contact_stiffness",), ())


@pytest.mark.parametrize("sigmas", [-2.5, 2.5])
def test_numbers_that_move_further_are_found(sigmas: float) -> None:
    assert said(moved("contact_stiffness", sigmas)) == ("parameter", ("contact_stiffness",), ())
    assert said(moved("torque_scale", sigmas)) == ("rig", ("torque_scale",), ())
    (rest,) = (verdict := moved("torque_scale", sigmas)).rests_on
    assert rest.needed_shift_sigma == pytest.approx(sigmas) and not verdict.within_uncertainty


@pytest.mark.parametrize("noise", [Noise(), OFFSETS])
@pytest.mark.parametrize("number", ["contact_stiffness", "sensor_gain"])
def test_a_number_that_moved_counts_whether_it_is_refitted_or_an_effect(
    noise: Noise, number: str
) -> None:
    null = MadeUpFit(noise, values=NUMBERS | {number: (1.0, 0.02, 1.1)})
    fits = {
        (): null,
        (number,): MadeUpFit(noise, sizes=1),
        (CREEP, SPRING): MadeUpFit(noise, sizes=2),
    }
    shares = {(): 0.59, (number,): 0.01, (CREEP, SPRING): 0.4}
    verdict = judge(competition(shares, fits, Around(nominal_chi2=400.0)))
    assert verdict.effects == (number,) and verdict.rivals == ()
    assert verdict.probability == pytest.approx(0.6)
    # Of the most probable combination, beside which it stands.
    assert verdict.exactly == pytest.approx(0.59)


@pytest.mark.parametrize(("sigmas", "kind"), [(RULES.moved_sigma, "complete"), (2.5, "parameter")])
def test_the_limit_of_a_shift_is_still_within(sigmas: float, kind: str) -> None:
    """A power of two as uncertainty, so that the shift is exactly that."""
    values = NUMBERS | {"contact_stiffness": (1.0, 0.25, 1.0 + 0.25 * sigmas)}
    around = Around(nominal_chi2=400.0)
    assert judge(competition({(): 1.0}, {(): MadeUpFit(values=values)}, around)).kind == kind


def test_numbers_that_need_not_move_do_not_count() -> None:
    """The drive as stated does as well."""
    verdict = moved("contact_stiffness", 2.5, nominal_chi2=301.0)
    assert said(verdict) == ("complete", (), ()) and not verdict.within_uncertainty
    assert verdict.rests_on == ()


def test_an_effect_as_likely_as_a_number_is_its_rival() -> None:
    null = MadeUpFit(values=NUMBERS | {"contact_stiffness": (1.0, 0.02, 1.1)})
    shares = {(): 0.7, (SPRING,): 0.3}
    verdict = judge(competition(shares, {(): null}, Around(nominal_chi2=400.0)))
    assert said(verdict) == ("ambiguous", (), (("contact_stiffness", SPRING),))
    assert verdict.probability == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("noise", "words"),
    [
        (Noise(correlation=0.5), ("correlated",)),
        (Noise(scale=1.3), ("misstated",)),
        (Noise(scale=0.7), ("misstated",)),
        (Noise(scale=1.05), ("white",)),
        (Noise(inflation=np.r_[np.full(4, 5.0), np.ones(392)]), ("outliers",)),
        (Noise(inflation=np.r_[np.full(60, 2.2), np.ones(336)]), ("heavy_tailed",)),
        (Noise(inflation=np.r_[5.0, np.ones(395)]), ("outliers",)),
        (Noise(inflation=np.r_[2.2, np.full(60, RULES.far_reading), np.ones(335)]), ("outliers",)),
        (Noise(scale=1.12), ("white",)),
        (Noise(scale=1.14), ("misstated",)),
        (Noise(0.25, 0.5, 0.4), ("misstated",)),
        (Noise(0.3, 0.5, 0.4), ("run_offset", "correlated", "misstated")),
        (Noise(1.3, 0.5, 0.4), ("run_offset", "correlated", "misstated")),
    ],
)
def test_noise_has_a_name(noise: Noise, words: tuple[str, ...]) -> None:
    fit = MadeUpFit(noise, values=NUMBERS, residual_arcsec=white(396, noise.scale))
    verdict = judge(competition({(): 1.0}, {(): fit}))
    if {"correlated", "misstated"} <= set(words) and noise.scale > 1:  # It may be a law.
        assert undecided(verdict, "scatter or law")
        return
    assert verdict.noise == words
    assert verdict.kind == ("complete" if words == ("white",) else "rig")
    assert verdict.effects == (("run_offset",) if "run_offset" in words else ())


# --- what is left -------------------------------------------------------------------------


@cache
def pattern() -> Floats:
    """Smooth along the runs, so that it is no scatter; five standard uncertainties."""
    torque = plan("dev03").readings.torque_Nm
    return np.asarray(white(396) + 1.5 * torque / np.abs(torque).max())


def known_by(source: Source) -> Campaign:
    """A table whose scatter repeats tell, or its own smoothness, or only what is stated."""
    c = plan("dev03")
    if source == "repeats":
        return replace(c, repeats=Repeats(0.3, 1.0, 40.0, 20, 60, steady=True))
    if source == "stated":
        # One reading of each run.
        return c.select(np.isin(np.arange(396), np.unique(c.rows.run_index, return_index=True)[1]))
    return c


@pytest.mark.parametrize("source", ["repeats", "scatter within runs"])
def test_an_effect_beside_which_something_remains_says_so(source: Source) -> None:
    shares = {(): 0.01, ("unknown",): 0.005, (FRICTION,): 0.785, (FRICTION, "unknown"): 0.2}
    around = Around(campaign=known_by(source))
    for residual, remains in ((pattern(), True), (white(396), False)):
        null = MadeUpFit(values=dict(NUMBERS), residual_arcsec=4 * pattern())
        fits: dict[Any, MadeUpFit] = {(FRICTION,): MadeUpFit(sizes=1, residual_arcsec=residual)}
        verdict = judge(competition(shares, {(): null, **fits}, around))
        assert said(verdict) == ("effect", (FRICTION,), ())
        left = getattr(verdict.lack_of_fit, "base", None), verdict.probability < 0.95
        assert left == ((FRICTION,) if remains else None, remains)
        assert [e for e, _ in verdict.perhaps] == ([] if remains else ["unknown"])
        assert verdict.adequacy is not None and verdict.adequacy.source == source


def test_nothing_is_missing_is_not_said_of_what_is_no_scatter() -> None:
    fits = {(): MadeUpFit(values=NUMBERS, residual_arcsec=pattern())}
    verdict = judge(competition({(): 0.98, ("unknown",): 0.02}, fits))
    assert said(verdict) == ("unknown", (), ()) and verdict.lack_of_fit is not None


# --- undecided ----------------------------------------------------------------------------


def undecided(verdict: Verdict, why: str) -> bool:
    """Says nothing for that reason, with no number of an answer beside it."""
    found = (*said(verdict), verdict.names, verdict.within_uncertainty, verdict.undecided)
    return found == ("undecided", (), (), (), False, why) and verdict.probability <= RULES.undecided


def test_no_answer_is_probable() -> None:
    shares = {(): 0.3, (FRICTION,): 0.35, (LOSS,): 0.3, (CREEP,): 0.03, (SPRING,): 0.02}
    verdict = judge(competition(shares))
    assert undecided(verdict, "no answer is probable")
    assert verdict.probability == pytest.approx(0.35)
    assert [e for e, _ in verdict.perhaps] == [FRICTION, LOSS]
    shares |= {(): 0.55, (FRICTION,): 0.1}
    assert judge(competition(shares)).kind == "complete"


def few(count: int) -> Campaign:
    """So many readings of one run, which scatter as is stated."""
    return plan("dev03").select(np.arange(396) < count)


@pytest.mark.parametrize(("count", "kind"), [(12, "effect"), (11, "undecided")])
def test_few_readings_for_the_numbers_of_an_answer(count: int, kind: str) -> None:
    """Three sizes and a zero: twelve readings at least."""
    fits = {
        (): MadeUpFit(values=NUMBERS, residual_arcsec=white(count)),
        (FRICTION,): MadeUpFit(sizes=3, residual_arcsec=white(count)),
    }
    around = Around(campaign=few(count))
    verdict = judge(competition({(): 0.01, (FRICTION,): 0.99}, fits, around))
    assert verdict.kind == kind
    if kind == "undecided":
        assert undecided(verdict, "few readings")
        assert dict(verdict.perhaps) == {FRICTION: pytest.approx(0.99)}


def test_what_is_known_beforehand_takes_no_readings() -> None:
    """Five numbers of drive and rig of which the readings say nothing."""
    fits = {(): MadeUpFit(values=NUMBERS, residual_arcsec=white(6))}
    assert judge(competition({(): 1.0}, fits, Around(campaign=few(6)))).kind == "complete"


@pytest.mark.parametrize("names", [(), (FRICTION,)])
@pytest.mark.parametrize(("times", "kind"), [(1.0, "something"), (6.0, "undecided")])
def test_scatter_or_law_where_only_what_is_stated_tells(
    names: Names, times: float, kind: str
) -> None:
    c = known_by("stated")
    residual = white(len(c), times)
    fits = {
        (): MadeUpFit(values=NUMBERS, residual_arcsec=residual),
        (FRICTION,): MadeUpFit(sizes=1, residual_arcsec=residual),
    }
    shares = {(): 0.01, (FRICTION,): 0.01} | {names: 0.99}
    verdict = judge(competition(shares, fits, Around(campaign=c)))
    assert (verdict.kind == "undecided") == (kind == "undecided")
    if kind == "undecided":
        assert undecided(verdict, "scatter or law")


def test_nothing_is_missing_is_not_said_where_nothing_tells_the_scatter() -> None:
    """One reading of each run, and no stated uncertainty."""
    c = replace(known_by("stated"), u_stated=False)
    null = MadeUpFit(values=NUMBERS, residual_arcsec=white(len(c)))
    shares = {(): 0.99, (FRICTION,): 0.01}
    assert undecided(judge(competition(shares, {(): null}, Around(campaign=c))), "scatter unknown")


def test_what_predicts_nothing_is_not_certain() -> None:
    """It explains the readings, but those that are kept back are far more probable without it."""
    shares = {(): 0.001, (FRICTION,): 0.002, (CREEP,): 0.001, (CREEP, FRICTION): 0.996}
    for further, certain in ((-0.1, True), (0.1, False)):
        fits = {
            (CREEP, FRICTION): MadeUpFit(sizes=2, predicts=80.0),
            (FRICTION,): MadeUpFit(sizes=1, predicts=80 + RULES.log_rival_odds + further),
            (CREEP,): MadeUpFit(sizes=1, predicts=20.0),
        }
        verdict = judge(competition(shares, fits))
        assert verdict.effects == ((CREEP, FRICTION) if certain else (FRICTION,))
        assert (CREEP in dict(verdict.perhaps)) != certain
        assert verdict.probability == pytest.approx(0.996 if certain else 0.998)


def test_an_answer_that_predicts_nothing_is_none() -> None:
    fits = {
        (FRICTION,): MadeUpFit(sizes=1, predicts=80.0),
        (): MadeUpFit(values=NUMBERS, predicts=90.0),
    }
    verdict = judge(competition({(): 0.01, (FRICTION,): 0.99}, fits))
    assert undecided(verdict, "no prediction")
    assert dict(verdict.perhaps) == {FRICTION: pytest.approx(0.99)}


@pytest.mark.parametrize(("count", "why"), [(1, "few readings"), (2, "no prediction")])
def test_one_reading_predicts_nothing_and_two_may(count: int, why: str) -> None:
    residual = white(count)
    fits = {
        (FRICTION,): MadeUpFit(sizes=1, predicts=80.0, residual_arcsec=residual),
        (): MadeUpFit(values=NUMBERS, predicts=90.0, residual_arcsec=residual),
    }
    shares = {(): 0.01, (FRICTION,): 0.99}
    assert undecided(judge(competition(shares, fits, Around(campaign=few(count)))), why)


# --- probabilities ------------------------------------------------------------------------


@given(weights(), st.floats(-6, 0).map(lambda x: 10**x), st.booleans())
@examples(40)
def test_probabilities_sum_to_one(
    shares: dict[Names, float], unnamed: float, offsets: bool
) -> None:
    best = max(shares, key=lambda n: shares[n])
    sets = {n: p * (1 - unnamed / 2) for n, p in shares.items()}
    sets[(*best, "unknown")] = unnamed / 2
    noisy = {best: MadeUpFit(OFFSETS, values=NUMBERS)} if offsets else {}
    posterior = posterior_of(competition(sets, noisy))
    assert sum(posterior.sets.values()) == pytest.approx(1)
    with_unnamed = [n for n in posterior.sets if "unknown" in n]
    assert [posterior.sets[n] for n in with_unnamed] == [pytest.approx(unnamed / 2)]
    # Those of sets with offsets of runs are told as such, and nothing is lost.
    assert ("run_offset" in with_unnamed[0]) == offsets
    assert posterior.sets[tuple(sorted((*best, *(["run_offset"] * offsets))))] == pytest.approx(
        sets[best]
    )


def test_the_order_of_asking_decides_nothing() -> None:
    shares = {(): 0.01, (BEARING,): 0.5, (TORSION,): 0.3, (CREEP, LOSS): 0.18, (FRICTION,): 0.01}
    forward = judge(competition(shares))
    backward = judge(competition(dict(reversed(shares.items()))))
    assert said(forward) == said(backward)
    assert forward.probability == pytest.approx(backward.probability)
    assert forward.perhaps == backward.perhaps
