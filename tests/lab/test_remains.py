"""What remains beside what is named: the decision on odds made up by hand.

Groups: what comes again in repeated runs; what has no name beside something else; what a name is
worth beside a rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.repeatability import Repeats
from cbpt.lab.selection import decision
from cbpt.lab.selection.adequacy import Adequacy
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
from common.simulated import plan

BEARING, TORSION, FRICTION = "eccentric_bearing", "output_torsion", "friction_hysteresis"
LOSS = "preload_loss"
LAW = Adequacy(0.4, 0.1, "repeats", 1e-6, comes_again=True)


@pytest.fixture(autouse=True, scope="module")
def kept_back() -> Iterator[None]:
    with predicts_as_made_up():
        yield


def judged(shares: Shares, around: Around) -> Verdict:
    """Where every effect takes 3 arcsec of misfit away."""
    null = MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396, 10.0))
    return judge(competition(shares, {(): null}, around))


# --- what comes again ---------------------------------------------------------------------


@pytest.fixture
def law(monkeypatch: pytest.MonkeyPatch) -> None:
    """In repeated runs the same is left again, whatever is fitted."""
    monkeypatch.setattr(decision, "law_left", lambda *_: LAW)


NAMED = {(): 0.01, ("unknown",): 0.01, (FRICTION,): 0.98}
RIVALS = {(): 0.01, ("unknown",): 0.01, (BEARING,): 0.55, (TORSION,): 0.43}


@pytest.mark.usefixtures("law")
@pytest.mark.parametrize("shares", [NAMED, RIVALS])
def test_what_comes_again_beside_a_name_remains(shares: Shares) -> None:
    verdict = judged(shares, Around(lack_arcsec=0.3))
    assert verdict.kind in ("effect", "ambiguous")
    assert verdict.adequacy == LAW
    assert verdict.lack_of_fit is not None


@pytest.mark.parametrize("shares", [NAMED, RIVALS])
def test_without_repeated_runs_nothing_does(shares: Shares) -> None:
    verdict = judged(shares, Around())
    assert verdict.adequacy is not None and not verdict.adequacy.comes_again
    assert verdict.lack_of_fit is None


@pytest.mark.usefixtures("law")
def test_what_remains_already_is_told_with_what_comes_again() -> None:
    shares = {(): 0.01, ("unknown",): 0.01, (FRICTION,): 0.01, (FRICTION, "unknown"): 0.97}
    verdict = judged(shares, Around(lack_arcsec=0.3))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.lack_of_fit is not None and verdict.lack_of_fit.base == (FRICTION,)
    assert verdict.adequacy == LAW


@pytest.mark.usefixtures("law")
@pytest.mark.parametrize(
    ("shares", "kind"),
    [
        ({(): 0.98, ("unknown",): 0.02}, "complete"),
        ({(): 0.01, ("unknown",): 0.99}, "unknown"),
    ],
)
def test_it_is_asked_beside_a_name_alone(shares: Shares, kind: str) -> None:
    verdict = judge(competition(shares))
    assert verdict.kind == kind
    assert verdict.adequacy is not None and not verdict.adequacy.comes_again


@pytest.mark.usefixtures("law")
def test_repeats_of_a_state_tell_more() -> None:
    c = replace(plan("dev03"), repeats=Repeats(0.3, 1.0, 40.0, 20, 60, steady=True))
    verdict = judged(NAMED, Around(campaign=c))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert verdict.adequacy is not None and not verdict.adequacy.comes_again


# --- what has no name beside something else -----------------------------------------------


def test_offsets_of_runs_are_no_name_beside_what_has_none() -> None:
    around = Around(lack_noise=Noise(offset_arcsec=0.5))
    verdict = judge(competition({(): 0.01, ("unknown",): 0.99}, around=around))
    assert said(verdict) == ("unknown", (), ())
    assert verdict.lack_of_fit is not None
    assert verdict.probability == pytest.approx(0.99)


def test_what_is_possible_keeps_its_probability_where_it_is_not_fitted() -> None:
    """The set that is drawn has no loss, so nothing of it can be part of what remains."""
    shares = {
        (): 0.005,
        ("unknown",): 0.005,
        (FRICTION,): 0.005,
        (FRICTION, LOSS): 0.005,
        (FRICTION, "unknown"): 0.63,
        (FRICTION, LOSS, "unknown"): 0.35,
    }
    verdict = judged(shares, Around(lack_arcsec=0.3))
    assert said(verdict) == ("effect", (FRICTION,), ())
    assert dict(verdict.perhaps) == {LOSS: pytest.approx(0.355)}
    explained = float(np.sqrt(np.mean(white(396, 10.0) ** 2) - np.mean(white(396) ** 2)))
    assert verdict.probability == pytest.approx(0.98 * (1 - 2 / np.pi * np.arctan(0.3 / explained)))


# --- what a name is worth beside a rest ---------------------------------------------------


def beside(lack_arcsec: float) -> Verdict:
    """Friction, which takes 3 arcsec of misfit away, with a lack of fit beside it."""
    shares = {(): 0.005, (FRICTION,): 0.02, ("unknown",): 0.005, (FRICTION, "unknown"): 0.97}
    return judged(shares, Around(lack_arcsec=lack_arcsec))


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
    assert verdict.exactly <= dict(verdict.perhaps)[FRICTION] < verdict.probability


def test_no_set_is_more_probable_than_what_is_possible_in_it() -> None:
    """One of two explains less than remains: it is possible, and so is the set with both."""
    both = MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396))
    fits = {
        (): MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396, 30.0)),
        (FRICTION,): MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396, 1.5)),
        (LOSS,): MadeUpFit(values=dict(NUMBERS), residual_arcsec=white(396, 30.0)),
        (FRICTION, LOSS): both,
    }
    shares: Shares = {(FRICTION, LOSS, "unknown"): 0.98, (): 0.01, (FRICTION, LOSS): 0.01}
    verdict = judge(competition(shares, fits, Around(lack_arcsec=2.0)))
    possible = dict(verdict.perhaps)
    assert verdict.effects == (FRICTION,) and 0.05 < possible[LOSS] < 0.5
    assert verdict.exactly == pytest.approx(0.98 * possible[LOSS], rel=0.05)


def test_rivals_that_explain_less_than_remains_are_only_possible() -> None:
    """A group of which one is needed is no surer than an effect that is certain."""
    shares: Shares = {(FRICTION, "unknown"): 0.54, (LOSS, "unknown"): 0.43, (): 0.01}
    shares = {**shares, (FRICTION,): 0.01, (LOSS,): 0.01}
    near = judged(shares, Around(lack_arcsec=1.0))
    assert said(near) == ("ambiguous", (), ((FRICTION, LOSS),))
    assert near.probability < 0.95
    far = judged(shares, Around(lack_arcsec=6.0))
    assert said(far) == ("unknown", (), ()) and far.probability > 0.9
    assert {FRICTION, LOSS} == set(dict(far.perhaps))
