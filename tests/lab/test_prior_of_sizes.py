"""The prior of sizes of which the readings see the sum alone."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from cbpt.lab.model.priors import VARIANTS, Variant, log_prior_of_sizes, log_size_prior

Floats = NDArray[np.float64]
NAMES = ("bearing_play", "output_torsion", "rough_contact")


def single(effect: str) -> Variant:
    """A form of one size."""
    return next(v for v in VARIANTS if v.effect == effect and len(v.sizes) == 1)


def evidence(variants: list[Variant], off: Floats, freedom: float) -> float:
    """Of two sizes that may be anything within a freedom, while their sum is seen to 1 of `low`; up
    to what follows the readings."""
    apart = freedom**2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    covariance = apart + 0.5 * np.eye(2)
    volume = 0.5 * float(np.linalg.slogdet(covariance)[1])
    return volume + log_prior_of_sizes(variants, [[0], [1]], off, covariance)


def test_a_freedom_ends_at_what_is_plausible() -> None:
    """A pair that nothing tells apart was the less likely the flatter its valley, however far that
    lay beyond what sizes can be: 13 of log odds behind its part on a real loop."""
    variants = [single(effect) for effect in NAMES[:2]]
    high = max(v.high / v.low for v in variants)
    wide, wider = (evidence(variants, np.array([4.0, 6.0]), f * high) for f in (10.0, 1e4))
    assert wider == pytest.approx(wide, abs=0.02)


def test_it_is_no_matter_where_in_its_valley_a_fit_ends() -> None:
    variants = [single(effect) for effect in NAMES[:2]]
    found = [evidence(variants, np.array([s, 100.0 - s]), 1e3) for s in (1.0, 50.0, 99.0)]
    assert np.ptp(found) < 1e-9


def test_the_order_of_the_effects_is_no_matter() -> None:
    variants = [single(effect) for effect in NAMES]
    off = np.array([3.0, 50.0, 7.0])
    root = np.array([[40.0, 0.0, 0.0], [-600.0, 30.0, 0.0], [10.0, 20.0, 90.0]])
    covariance = root @ root.T
    found = [
        log_prior_of_sizes(
            [variants[i] for i in order],
            [[0], [1], [2]],
            off[list(order)],
            covariance[np.ix_(order, order)],
        )
        for order in permutations(range(3))
    ]
    assert np.ptp(found) < 1e-9


def test_sizes_that_are_seen_do_not_feel_it() -> None:
    variants = [single(effect) for effect in NAMES[:2]]
    off, covariance = np.array([50.0, 90.0]), np.array([[10.0, 7.0], [7.0, 20.0]])
    own = np.sqrt(np.diag(covariance))
    expected = sum(log_size_prior(v, off[[i]], own[[i]]) for i, v in enumerate(variants))
    found = log_prior_of_sizes(variants, [[0], [1]], off, covariance)
    assert found == pytest.approx(expected, abs=1e-3)


def test_what_is_not_finite_is_no_evidence() -> None:
    variants = [single(effect) for effect in NAMES[:2]]
    lost = log_prior_of_sizes(variants, [[0], [1]], np.zeros(2), np.full((2, 2), np.nan))
    assert not np.isfinite(lost)
