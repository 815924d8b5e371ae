"""A name beside a rest that has none: the larger the rest, the less it is worth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from cbpt.lab.selection.decision import Verdict, judge
from cbpt.lab.selection.rules import RULES
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

FRICTION, LOSS = "friction_hysteresis", "preload_loss"


@pytest.fixture(autouse=True, scope="module")
def kept_back() -> Iterator[None]:
    with predicts_as_made_up():
        yield


def beside(lack_arcsec: float) -> Verdict:
    """Friction, which takes 3 arcsec of misfit away, with a lack of fit beside it."""
    shares = {(): 0.005, (FRICTION,): 0.02, ("unknown",): 0.005, (FRICTION, "unknown"): 0.97}
    null = MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396, 10.0))
    return judge(competition(shares, {(): null}, Around(lack_arcsec=lack_arcsec)))


def test_a_lack_of_fit_beside_an_effect_remains() -> None:
    """Both are told, and what remains is that of the set that is drawn. The less remains, the more
    probable the effect is: the next draw of what has no name is a Cauchy variable."""
    verdict = beside(1.0)
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.lack_of_fit is not None and verdict.lack_of_fit.base == (FRICTION,)
    explained = float(np.sqrt(np.mean(white(396, 10.0) ** 2) - np.mean(white(396) ** 2)))
    inside = 1 - 2 / np.pi * np.arctan(1.0 / explained)
    assert 0.7 < inside < 0.9
    assert verdict.probability == pytest.approx(0.97 * inside) == verdict.exactly
    probabilities = [beside(lack).probability for lack in (0.2, 0.5, 1.0, 2.0)]
    assert probabilities == sorted(probabilities, reverse=True)
    assert probabilities[0] <= 0.97 * RULES.certain


def test_an_effect_that_explains_less_than_remains_is_only_possible() -> None:
    verdict = beside(6.0)
    assert said(verdict) == ("unknown", (), ())
    assert verdict.names == (FRICTION,) and verdict.lack_of_fit is not None
    assert 0.2 < dict(verdict.perhaps)[FRICTION] < 0.5


def test_rivals_that_explain_less_than_remains_are_only_possible() -> None:
    """A group of which one is needed is no surer than an effect that is certain."""
    shares: Shares = {(FRICTION, "unknown"): 0.54, (LOSS, "unknown"): 0.43, (): 0.01}
    shares = {**shares, (FRICTION,): 0.01, (LOSS,): 0.01}
    fits = {(): MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396, 10.0))}
    near = judge(competition(shares, fits, Around(lack_arcsec=1.0)))
    assert said(near) == ("ambiguous", (), ((FRICTION, LOSS),))
    assert near.probability < 0.95
    far = judge(competition(shares, fits, Around(lack_arcsec=6.0)))
    assert said(far) == ("unknown", (), ()) and far.probability > 0.9
    assert {FRICTION, LOSS} == set(dict(far.perhaps))
