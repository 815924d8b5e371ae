"""The competition of hypotheses: pairs are those that the screen offers, ties keep their order."""

from __future__ import annotations

import numpy as np

from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.selection.model_comparison import _Contest, _Offers
from cbpt.lab.selection.ranking import ranked
from cbpt.lab.selection.setting import prepare
from cbpt.lab.selection.starts import start_values
from common.simulated import plan, readings_of

BEARING, SET = ("eccentric_bearing", "reference_deflection_m"), ("run_in", "permanent_set_rad")


def test_a_second_effect_is_fitted_as_the_screen_offers_it() -> None:
    """Offers were once read from a longer list: for run-in a tilt of the plate was fitted."""
    campaign = readings_of(plan("dev03"), {BEARING: 4e-7, SET: 4e-6}, np.random.default_rng(3))
    setting = prepare(Fitter(campaign))
    contest = _Contest(setting, lambda what, share: None)
    contest.fit_singles()
    base = contest.fits["eccentric_bearing",]
    offers = _Offers(-np.inf)
    contest._offer_additions(offers, base)
    for names, pair in offers.best.items():
        assert set(names) == {"eccentric_bearing", *(s.variant.effect for s in pair.signatures)}
    pair = offers.best["eccentric_bearing", "run_in"]
    hypothesis = Hypothesis((*base.hypothesis.variants, *(s.variant for s in pair.signatures)))
    start = start_values(setting.fitter, pair.signatures, pair.sizes, base)
    before = setting.fitter.misfit(base.hypothesis, base.point.values, setting.flexible)
    assert setting.fitter.misfit(hypothesis, start, setting.flexible) < before - 5


def test_equal_values_keep_their_order() -> None:
    assert ranked([1.0, 2.0, 2.0 + 1e-12, -np.inf, 3.0]) == [4, 1, 2, 0, 3]
