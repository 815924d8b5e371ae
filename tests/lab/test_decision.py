"""From odds to words: the rules on odds made up by hand.

Groups: a competition made up; effects demanded; something without a name; no effect demanded;
probabilities.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.dataset import DEFAULT_UNCERTAINTY
from cbpt.lab.model.discrepancy import DISCREPANCY_ODDS
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.selection.decision import Verdict, calibrated, judge, weighed
from cbpt.lab.selection.model_comparison import Competition
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names
from common.drives import examples
from common.simulated import Floats

LIMIT, FAIR = float(np.log(RULES.rival_odds)), float(np.log(RULES.unknown_odds))
BEARING, TORSION, FRICTION = "eccentric_bearing", "output_torsion", "friction_hysteresis"
LOSS, SPRING, CREEP, RUNOUT = "preload_loss", "preload_spring", "creep", "eccentricity_error"
OFFSETS = Noise(offset_arcsec=0.5)
BY_CHANCE = 2.0
"""Log odds that the best of the patterns gains in noise alone."""

# --- a competition made up ----------------------------------------------------------------


@dataclass
class MadeUpFit:
    """What the rules ask of a fit."""

    noise: Noise = field(default_factory=Noise)
    log_marginal: float = 0.0
    values: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Mean, standard deviation of the prior, value; by unknown."""
    chi2: float = 300.0
    discrepancy_sd: float = 0.0

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        return tuple(
            Unknown(i, name, mean, sd, 0.01, 100.0, sd)
            for i, (name, (mean, sd, _)) in enumerate(self.values.items())
        )

    def value(self, unknown: Unknown) -> float:
        return self.values[unknown.name][2]

    def whitener(self, columns: Floats) -> Floats:
        return columns

    @property
    def margin(self) -> Any:
        return SimpleNamespace(chi2=self.chi2)


class Table:
    """396 readings."""

    u_believed, u_stated = 1.0, True

    def __init__(self) -> None:
        self.priors = dict(DEFAULT_UNCERTAINTY)

    def __len__(self) -> int:
        return 396


NUMBERS = dict.fromkeys(PRIORS, (1.0, 0.02, 1.0))


Odds = Mapping[Any, float]
"""By sets of effects, `Names`; a mapping of short tuples is none of long ones."""


@dataclass(frozen=True)
class Around:
    """What a competition was held in: chance, the drive as stated, free noise, calibrations."""

    null_maximum: float = -50.0
    nominal_chi2: float = 300.0
    flexible: Noise = field(default_factory=Noise)
    calibrations: Mapping[str, float] = field(default_factory=dict)


def competition(
    odds: Odds,
    lacks_of_fit: Odds | None = None,
    noises: Mapping[Any, Noise] | None = None,
    null: MadeUpFit | None = None,
    marginals: Mapping[Any, MadeUpFit] | None = None,
    around: Around = Around(),
) -> Competition:
    """Log odds of sets of effects, and of patterns on top of such sets."""
    all_odds = {(): 0.0, **{tuple(sorted(n)): o for n, o in odds.items()}}
    fits = {n: MadeUpFit((noises or {}).get(n, Noise())) for n in all_odds}
    fits[()] = null or replace(fits[()], values=dict(NUMBERS))
    fits |= dict(marginals or {})
    campaign = Table()
    campaign.priors |= around.calibrations
    found = {tuple(sorted(n)): o for n, o in (lacks_of_fit or {}).items()}
    return Competition(
        fitter=cast(
            Any,
            SimpleNamespace(
                campaign=campaign,
                at_nominal=lambda _: MadeUpFit(chi2=around.nominal_chi2),
                linear=lambda _: shared_by_all(),
            ),
        ),
        fits=cast(Any, fits),
        log_odds=all_odds,
        lacks_of_fit=cast(Any, tuple(SimpleNamespace(base=n, noise=Noise()) for n in found)),
        lack_of_fit_log_odds=tuple(found.values()),
        library=cast(Any, None),
        names={},
        null_maximum=np.full(400, around.null_maximum),
        flexible=around.flexible,
        inflation=None,
    )


def said(verdict: Verdict) -> tuple[str, tuple[str, ...], tuple[tuple[str, ...], ...]]:
    return verdict.kind, verdict.effects, verdict.rivals


def sigmoid(*log_odds: float) -> float:
    """The share of the first of some log odds."""
    weights = np.exp(np.array(log_odds) - max(log_odds))
    return float(weights[0] / weights.sum())


def shared_by_all() -> tuple[Floats, Floats, Floats]:
    """Readings that move by 1.5 standard uncertainties of any of the five numbers, and a zero."""
    slope = np.linspace(-40.0, 40.0, 20)
    x = np.column_stack([*[slope] * len(PRIORS), np.ones(20)])
    return 1.5 * slope, x, np.r_[np.ones(len(PRIORS)), 0.0]


# --- effects demanded ---------------------------------------------------------------------


def test_one_effect_far_ahead_is_certain() -> None:
    verdict = judge(competition({(FRICTION,): 30, (LOSS,): 12, (FRICTION, CREEP): 28}))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.names == (FRICTION,) and verdict.noise == ("white",)
    assert verdict.probability == pytest.approx(calibrated(1.0), abs=1e-6)


@pytest.mark.parametrize(("behind", "rival"), [(LIMIT - 0.1, True), (LIMIT + 0.1, False)])
def test_rivals_are_those_within_the_limit_of_odds(behind: float, rival: bool) -> None:
    verdict = judge(competition({(FRICTION,): 30, (LOSS,): 30 - behind}))
    if rival:
        assert said(verdict) == ("ambiguous", (), ((FRICTION, LOSS),))
        assert verdict.probability == pytest.approx(calibrated(1.0))
    else:
        assert said(verdict) == ("effect", (FRICTION,), ())
        assert verdict.probability == pytest.approx(calibrated(sigmoid(0.0, -behind)))
    assert verdict.names == (FRICTION,)


@pytest.mark.parametrize(("behind", "rival"), [(LIMIT + 2.9, True), (LIMIT + 3.1, False)])
@pytest.mark.parametrize("first", [BEARING, TORSION])
def test_kin_are_rivals_a_little_further(first: str, behind: float, rival: bool) -> None:
    other = BEARING if first == TORSION else TORSION
    verdict = judge(competition({(first,): 30, (other,): 30 - behind}))
    assert said(verdict)[0] == ("ambiguous" if rival else "effect")
    # With another effect beside, in both, no less.
    verdict = judge(competition({(first, CREEP): 60, (other, CREEP): 60 - behind}))
    assert verdict.kind == ("ambiguous" if rival else "effect")
    assert CREEP in verdict.effects
    # What differs in more than that is no kin.
    verdict = judge(competition({(first, CREEP): 60, (other, LOSS): 60 - behind}))
    assert said(verdict) == ("effect", tuple(sorted((first, CREEP))), ())


def test_three_rivals_are_one_group() -> None:
    verdict = judge(competition({(BEARING,): 30, (TORSION,): 29.5, (SPRING,): 28}))
    assert said(verdict) == ("ambiguous", (), ((BEARING, TORSION, SPRING),))


def test_a_superset_that_is_not_demanded_needs_no_mention() -> None:
    odds = {(FRICTION,): 30.0, (CREEP, FRICTION): 30 + LIMIT - 0.1}
    assert said(judge(competition(odds))) == ("effect", (FRICTION,), ())
    odds[(CREEP, FRICTION)] = 30 + LIMIT + 0.1
    assert said(judge(competition(odds))) == ("effect", (CREEP, FRICTION), ())


def test_what_a_superset_adds_is_no_rival() -> None:
    odds = {(FRICTION,): 30.0, (CREEP, FRICTION): 31.0, (LOSS,): 29.0}
    assert said(judge(competition(odds))) == ("ambiguous", (), ((FRICTION, LOSS),))


def test_what_all_sets_have_is_certain_and_the_rest_rivals() -> None:
    odds = {(BEARING, FRICTION): 60.0, (FRICTION, TORSION): 59.0, (FRICTION,): 40.0}
    verdict = judge(competition(odds))
    assert said(verdict) == ("ambiguous", (FRICTION,), ((BEARING, TORSION),))
    assert verdict.probability == pytest.approx(calibrated(1.0), abs=1e-6)


def test_one_effect_or_two_others() -> None:
    verdict = judge(competition({(SPRING,): 30, (BEARING, LOSS): 29}))
    assert said(verdict) == ("ambiguous", (), ((BEARING, LOSS, SPRING),))


def test_two_places_have_two_groups() -> None:
    odds = {
        tuple(sorted((a, b))): 60.0 - 0.1 * i
        for i, (a, b) in enumerate((x, y) for x in (BEARING, TORSION) for y in (LOSS, SPRING))
    }
    verdict = judge(competition(odds))
    assert verdict.kind == "ambiguous" and verdict.effects == ()
    assert set(verdict.rivals) == {(BEARING, TORSION), (LOSS, SPRING)}


POOL = (BEARING, TORSION, FRICTION, LOSS, SPRING, CREEP)
SETS = st.lists(st.sets(st.sampled_from(POOL), min_size=1, max_size=3), min_size=1, max_size=5).map(
    lambda sets: {tuple(sorted(s)) for s in sets}
)


def possible(sets: set[Names]) -> set[Names]:
    """The fewest effects that do."""
    return {n for n in sets if not any(set(m) < set(n) for m in sets)}


@given(SETS, st.randoms(use_true_random=False))
@examples(50)
def test_what_all_have_is_certain_and_nothing_else(sets: set[Names], random: Any) -> None:
    verdict = judge(competition({n: 60 + random.random() for n in sets}))
    common = set.intersection(*map(set, possible(sets)))
    assert set(verdict.effects) == common
    assert (verdict.kind == "effect") == (not verdict.rivals)
    assert not common & {e for g in verdict.rivals for e in g}
    assert verdict.names in sets


@pytest.mark.parametrize(
    "sets",
    [
        [(BEARING, LOSS), (TORSION, SPRING)],
        [(BEARING, LOSS), (BEARING, TORSION), (CREEP, BEARING)],
        [(BEARING, LOSS), (CREEP,)],
        [(BEARING, CREEP, LOSS), (BEARING, LOSS, TORSION), (CREEP, LOSS, TORSION, SPRING)],
        [(BEARING, LOSS), (BEARING, CREEP), (CREEP, LOSS)],
        [(BEARING, LOSS), (TORSION, SPRING), (BEARING, TORSION)],
    ],
)
def test_every_possible_set_is_told(sets: list[Names]) -> None:
    """All of it is certain or a rival, and it has one of each group."""
    odds = {tuple(sorted(n)): 60 - 0.1 * i for i, n in enumerate(sets)}
    verdict = judge(competition(odds))
    told = {*verdict.effects, *(e for g in verdict.rivals for e in g)}
    for names in sets:
        assert set(names) <= told
        assert all(set(names) & set(g) for g in verdict.rivals)


def test_gains_and_numbers_have_kinds_of_their_own() -> None:
    assert said(judge(competition({("drift",): 30}))) == ("rig", ("drift",), ())
    both = judge(competition({("drift", FRICTION): 60}))
    assert said(both) == ("effect", ("drift", FRICTION), ())
    # Of a number of the drive the prior has to be widened by far; else it moves within it.
    number = judge(competition({("contact_stiffness",): 30}))
    assert said(number) == ("parameter", ("contact_stiffness",), ())
    assert said(judge(competition({("contact_stiffness",): 7}))) == ("complete", (), ())


def test_what_chance_does_is_no_effect() -> None:
    odds = {(FRICTION,): LIMIT + 1}
    assert judge(competition(odds, around=Around(null_maximum=0.0))).kind == "effect"
    verdict = judge(competition(odds, around=Around(null_maximum=LIMIT + 2)))
    assert said(verdict) == ("complete", (), ())


def test_an_effect_within_the_limit_of_none_is_not_named() -> None:
    """Unless chance hardly ever shows as much."""
    within, weak = LIMIT - 0.1, float(np.log(RULES.weak_odds))

    def kind(odds: float, most_in_noise: float) -> str:
        around = Around(null_maximum=most_in_noise)
        return judge(competition({(FRICTION,): odds}, around=around)).kind

    assert kind(within, LIMIT) == "complete"
    assert kind(LIMIT + 0.1, LIMIT) == "effect"
    assert kind(weak + 0.1, 0.0) == "effect"
    assert kind(weak - 0.1, 0.0) == "complete"


def test_an_answer_tells_the_calibrations_it_rests_on() -> None:
    gain = MadeUpFit(log_marginal=98.0, values={"preload_scale.preload_gain": (1.0, 0.02, 0.85)})
    far = MadeUpFit(log_marginal=80.0, values={"torque_scale.torque_gain": (1.0, 0.01, 1.1)})
    made = competition(
        {(LOSS,): 30, ("preload_scale",): 20, ("torque_scale",): 5},
        marginals={
            (LOSS,): MadeUpFit(log_marginal=100.0),
            ("preload_scale",): gain,
            ("torque_scale",): far,
        },
    )
    verdict = judge(made)
    assert said(verdict) == ("effect", (LOSS,), ())
    (rest,) = verdict.rests_on
    assert (rest.number, rest.prior) == ("preload_scale", 0.02)
    assert rest.needed_shift_sigma == pytest.approx(-7.5)


# --- zeros of the runs --------------------------------------------------------------------


def test_zeros_alone_are_the_rig() -> None:
    verdict = judge(competition({}, noises={(): OFFSETS}, null=MadeUpFit(OFFSETS, values=NUMBERS)))
    assert said(verdict) == ("rig", ("run_offset",), ())
    assert verdict.noise == ("run_offset",)


def test_zeros_or_an_effect_are_rivals() -> None:
    """A runout where each run has its own angle."""
    null = MadeUpFit(OFFSETS, values=NUMBERS)
    verdict = judge(competition({(RUNOUT,): 1.0}, null=null))
    assert said(verdict) == ("ambiguous", (), ((RUNOUT, "run_offset"),))
    assert verdict.names == (RUNOUT,)
    assert verdict.probability == pytest.approx(calibrated(1.0))


def test_an_effect_far_ahead_of_zeros_is_certain() -> None:
    null = MadeUpFit(OFFSETS, values=NUMBERS)
    verdict = judge(competition({(RUNOUT,): LIMIT + 5}, null=null))
    assert said(verdict) == ("effect", (RUNOUT,), ())


def test_an_effect_far_behind_zeros_is_none() -> None:
    null = MadeUpFit(OFFSETS, values=NUMBERS)
    # Runout and zeros are kin: with few runs either looks like the other.
    for behind, kind in ((LIMIT + 2.9, "ambiguous"), (LIMIT + 3.1, "rig")):
        assert judge(competition({(RUNOUT,): -behind}, null=null)).kind == kind
    verdict = judge(competition({(FRICTION,): -LIMIT - 0.1}, null=null))
    assert said(verdict) == ("rig", ("run_offset",), ())


def test_zeros_beside_an_effect_are_told() -> None:
    null = MadeUpFit(OFFSETS, values=NUMBERS)
    verdict = judge(competition({(FRICTION,): 30}, noises={(FRICTION,): OFFSETS}, null=null))
    assert verdict.kind == "effect" and verdict.rivals == ()
    assert FRICTION in verdict.effects and verdict.noise == ("run_offset",)
    assert verdict.names == (FRICTION,)


# --- something without a name -------------------------------------------------------------


def test_a_pattern_far_ahead_is_unknown() -> None:
    ahead = LIMIT + BY_CHANCE + 0.1
    verdict = judge(competition({(FRICTION,): 30}, {(): 30 + ahead}))
    assert said(verdict) == ("unknown", (), ())
    assert verdict.names == () and verdict.lack_of_fit is not None
    assert verdict.probability == pytest.approx(calibrated(sigmoid(ahead, 0.0)), rel=1e-6)


def test_a_pattern_without_anything_beside_is_unknown() -> None:
    assert judge(competition({}, {(): LIMIT + BY_CHANCE + 0.1})).kind == "unknown"
    assert judge(competition({}, {(): LIMIT + BY_CHANCE - 0.1})).kind == "complete"


@pytest.mark.parametrize(
    ("behind", "rival"), [(-2.0, True), (FAIR - 0.1, True), (FAIR + 0.1, False)]
)
def test_a_pattern_alone_that_is_about_as_likely_is_a_rival(behind: float, rival: bool) -> None:
    verdict = judge(competition({(FRICTION,): 30}, {(): 30 - behind}))
    if rival:
        assert said(verdict) == ("ambiguous", (), ((FRICTION, "unknown"),))
        assert verdict.probability == pytest.approx(calibrated(1.0))
    else:
        assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.names == (FRICTION,)


def test_a_strained_effect_has_the_pattern_for_a_rival_sooner() -> None:
    """The fit with it leaves more scatter than a fit that may follow everything."""
    strained = {(FRICTION,): Noise(1.05)}
    for behind, rival in ((LIMIT - 0.1, True), (LIMIT + 0.1, False)):
        made = competition({(FRICTION,): 30}, {(): 30 - behind}, strained)
        assert (judge(made).kind == "ambiguous") == rival
    made = competition({(FRICTION,): 30}, {(): 28}, strained, around=Around(flexible=Noise(1.05)))
    assert judge(made).kind == "effect"


def departed(odds: Any, patterns: Any) -> Competition:
    """Friction that explains the readings only far from its form."""
    fits = {(FRICTION,): MadeUpFit(discrepancy_sd=DISCREPANCY_ODDS[-1][0])}
    return competition(odds, patterns, marginals=fits)


def test_an_effect_far_from_its_form_yields_to_a_pattern() -> None:
    for ahead, kind in ((0.1, "unknown"), (-0.1, "ambiguous"), (0.1 - LIMIT, "ambiguous")):
        assert judge(departed({(FRICTION,): 30}, {(): 30 + ahead})).kind == kind
    assert judge(departed({(FRICTION,): 30}, {(): 29.9 - LIMIT})).kind == "effect"
    # The same odds with its form kept: the name stands.
    assert judge(competition({(FRICTION,): 30}, {(): 29.5})).kind == "effect"


def test_an_effect_far_from_its_form_has_rivals_further_off() -> None:
    odds = {(FRICTION,): 30.0, (LOSS,): 30 - 2 * LIMIT + 0.1}
    assert said(judge(departed(odds, {}))) == ("ambiguous", (), ((FRICTION, LOSS),))
    assert judge(competition(odds)).kind == "effect"


def test_a_pattern_on_top_of_an_effect_is_unknown() -> None:
    verdict = judge(competition({(FRICTION,): 30}, {(): 20, (FRICTION,): 45}))
    assert said(verdict) == ("unknown", (), ())
    assert verdict.names == (FRICTION,)
    assert verdict.lack_of_fit is not None and verdict.lack_of_fit.base == (FRICTION,)


def test_a_little_left_over_is_the_form_of_the_effect() -> None:
    """Six per cent of what a strong effect explains; real parts do not keep the library's form."""
    verdict = judge(competition({(FRICTION,): 300}, {(FRICTION,): 312}))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert judge(competition({(FRICTION,): 300}, {(FRICTION,): 340})).kind == "unknown"


def test_a_pattern_that_gains_by_chance_changes_nothing() -> None:
    odds = {(FRICTION,): 30.0, (LOSS,): 30 - LIMIT - 0.1}
    verdict = judge(competition(odds, {(FRICTION,): 30 + np.log(0.005) + 1.9}))
    assert said(verdict) == ("effect", (FRICTION,), ())


# --- no effect demanded -------------------------------------------------------------------


def moved(number: str, sigmas: float, nominal_chi2: float = 400.0) -> Verdict:
    null = MadeUpFit(values=NUMBERS | {number: (1.0, 0.02, 1.0 + 0.02 * sigmas)})
    return judge(competition({}, null=null, around=Around(nominal_chi2=nominal_chi2)))


def test_nothing_is_missing() -> None:
    verdict = judge(competition({(FRICTION,): -3, (LOSS,): -4}))
    assert said(verdict) == ("complete", (), ())
    assert not verdict.within_uncertainty and verdict.rests_on == ()
    assert verdict.probability == pytest.approx(calibrated(sigmoid(0.0, -3.0, -4.0)))


def test_numbers_that_move_within_what_is_stated() -> None:
    verdict = moved("contact_stiffness", 1.5)
    assert said(verdict) == ("complete", (), ()) and verdict.within_uncertainty
    (rest,) = verdict.rests_on
    assert rest.number == "contact_stiffness" and rest.needed_shift_sigma == pytest.approx(1.5)


def test_calibrations_known_loosely_share_a_shift() -> None:
    """Instrument and drive explain the same, and neither is known well."""
    null = MadeUpFit(values=NUMBERS | {"contact_stiffness": (1.0, 0.02, 1.03)})
    around = Around(nominal_chi2=400.0, calibrations={"sensor_gain": 0.1})
    made = competition({}, null=null, around=around)
    verdict = judge(made)
    assert said(verdict) == ("ambiguous", (), (tuple(sorted(PRIORS)),))
    assert verdict.within_uncertainty


@pytest.mark.parametrize("sigmas", [-2.5, 2.5])
def test_numbers_that_move_further_are_found(sigmas: float) -> None:
    assert said(moved("contact_stiffness", sigmas)) == ("parameter", ("contact_stiffness",), ())
    assert said(moved("torque_scale", sigmas)) == ("rig", ("torque_scale",), ())
    (rest,) = moved("torque_scale", sigmas).rests_on
    assert rest.needed_shift_sigma == pytest.approx(sigmas)


def test_numbers_that_need_not_move_do_not_count() -> None:
    """The drive as stated does as well."""
    verdict = moved("contact_stiffness", 2.5, nominal_chi2=301.0)
    assert said(verdict) == ("complete", (), ()) and not verdict.within_uncertainty
    assert verdict.rests_on == ()


def test_an_effect_as_likely_as_a_number_is_its_rival() -> None:
    null = MadeUpFit(values=NUMBERS | {"contact_stiffness": (1.0, 0.02, 1.1)})
    verdict = judge(competition({(SPRING,): -1}, null=null, around=Around(nominal_chi2=400.0)))
    assert said(verdict) == ("ambiguous", (), (("contact_stiffness", SPRING),))
    assert verdict.probability == pytest.approx(calibrated(1.0))


@pytest.mark.parametrize(
    ("noise", "words"),
    [
        (Noise(correlation=0.5), ("correlated",)),
        (Noise(scale=1.3), ("misstated",)),
        (Noise(scale=0.7), ("misstated",)),
        (Noise(scale=1.05), ("white",)),
        (Noise(inflation=np.r_[np.full(4, 5.0), np.ones(392)]), ("outliers",)),
        (Noise(inflation=np.r_[np.full(60, 2.2), np.ones(336)]), ("heavy_tailed",)),
        (Noise(0.25, 0.5, 0.4), ("misstated",)),
        (Noise(1.3, 0.5, 0.4), ("run_offset", "correlated", "misstated")),
    ],
)
def test_noise_has_a_name(noise: Noise, words: tuple[str, ...]) -> None:
    verdict = judge(competition({}, null=MadeUpFit(noise, values=NUMBERS)))
    assert verdict.noise == words
    assert verdict.kind == ("complete" if words == ("white",) else "rig")


# --- probabilities ------------------------------------------------------------------------


@given(
    st.dictionaries(SETS.map(lambda s: min(s)), st.floats(-20, 60), max_size=6),
    st.dictionaries(st.sampled_from([(), (FRICTION,)]), st.floats(-20, 70), max_size=2),
)
@examples(50)
def test_probabilities_add_up(odds: dict[Names, float], patterns: dict[Names, float]) -> None:
    """What is said is the share of all sets that it is true of."""
    patterns = {base: o for base, o in patterns.items() if base in odds or not base}
    made = competition(odds, patterns)
    verdict = judge(made)
    sets = weighed(made)
    assert set(sets) >= {(), *odds}
    shares = {n: sigmoid(o, *(p for m, p in sets.items() if m != n)) for n, o in sets.items()}
    assert sum(shares.values()) == pytest.approx(1.0)

    def true_of(names: Names) -> bool:
        if verdict.kind == "unknown":
            return "unknown" in names
        if verdict.kind == "complete":
            return not names
        has_all = set(verdict.effects) <= set(names)
        return has_all and all(set(g) & set(names) for g in verdict.rivals)

    expected = sum(share for n, share in shares.items() if true_of(n))
    assert verdict.probability == pytest.approx(calibrated(expected), abs=1e-9)
    assert 0 <= verdict.probability <= 1 + 1e-12


def test_a_larger_share_is_more_probable() -> None:
    """And none is certain."""
    said_of = [calibrated(share) for share in np.linspace(0, 1, 21)]
    assert said_of == sorted(said_of)
    assert said_of[0] >= 0 and 0.9 < said_of[-1] < 1


def test_the_order_of_asking_decides_nothing() -> None:
    odds = {(BEARING,): 30.0, (TORSION,): 29.0, (CREEP, LOSS): 28.5, (FRICTION,): 3.0}
    forward = judge(competition(odds, {(): 12}))
    backward = judge(competition(dict(reversed(odds.items())), {(): 12}))
    assert said(forward) == said(backward)
    assert forward.probability == pytest.approx(backward.probability)
