"""The prior density of sizes of which the readings see a sum alone."""

from __future__ import annotations

import math
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


def seen_in_sum(freedom: float, sum_sd: float) -> Floats:
    """Two sizes that may be anything within `freedom`, and their sum."""
    apart = freedom**2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return apart + 0.5 * sum_sd**2 * np.eye(2)


def test_one_freedom_is_paid_for_once() -> None:
    """However wide it is: the volume of the posterior grows with it as the prior falls."""
    variants = [single(effect) for effect in NAMES[:2]]
    off, places = np.array([40.0, 60.0]), [[0], [1]]
    evidence = []
    for freedom in (1e3, 1e6):
        covariance = seen_in_sum(freedom, 1.0)
        volume = 0.5 * float(np.linalg.slogdet(covariance)[1])
        evidence.append(volume + log_prior_of_sizes(variants, places, off, covariance))
    assert evidence[1] == pytest.approx(evidence[0], abs=1e-2)


def test_the_order_of_the_effects_is_no_matter() -> None:
    variants = [single(effect) for effect in NAMES]
    off = np.array([3.0, 50.0, 7.0])
    root = np.array([[40.0, 0.0, 0.0], [-600.0, 30.0, 0.0], [10.0, 20.0, 90.0]])
    covariance = root @ root.T
    found = {
        round(
            log_prior_of_sizes(
                [variants[i] for i in order],
                [[0], [1], [2]],
                off[list(order)],
                covariance[np.ix_(order, order)],
            ),
            9,
        )
        for order in permutations(range(3))
    }
    assert len(found) == 1


def test_sizes_that_are_seen_have_their_own() -> None:
    """However they hang together: one that stands out is not as large as another's doubt."""
    variants = [single(effect) for effect in NAMES[:2]]
    off, covariance = np.array([50.0, 9.0]), np.array([[100.0, 700.0], [700.0, 1e4]])
    own = np.sqrt(np.diag(covariance))
    expected = sum(log_size_prior(v, off[[i]], own[[i]]) for i, v in enumerate(variants))
    found = log_prior_of_sizes(variants, [[0], [1]], off, covariance)
    assert found == pytest.approx(expected)
    assert found < log_size_prior(variants[0], off[[0]], own[[0]]) - math.log(50.0)
