"""The step of a linear problem within bounds, against SciPy's bounded least squares.

Groups: without a radius it is the minimum; with one it is within bounds and not uphill.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from cbpt._core import held_at_bounds, quadratic_step
from common.drives import examples

Floats = NDArray[np.float64]


def problem(seed: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Columns that are much alike, readings, and bounds of which some are where the step begins."""
    rng = np.random.default_rng(seed)
    p = int(rng.integers(1, 9))
    shared = rng.standard_normal((20, 1))
    j = shared * rng.standard_normal(p) + 0.2 * rng.standard_normal((20, p))
    y = 3 * rng.standard_normal(20)
    low = -rng.choice([0.0, 0.0, 0.3, np.inf], p)
    high = rng.choice([0.0, 0.1, 1.0, np.inf], p)
    high[(low == 0) & (high == 0)] = 0.5
    return j, y, low, high


def step_of(j: Floats, y: Floats, low: Floats, high: Floats, radius: float = np.inf) -> Floats:
    step, promised = quadratic_step(j.T @ j, j.T @ y, (low, high), np.ones(len(low)), radius)
    gained = float(np.sum(y**2) - np.sum((y - j @ step) ** 2))
    assert abs(promised - gained) <= 1e-9 * (1 + np.sum(y**2))
    return step


def by_functions(j: Floats, y: Floats, low: Floats, high: Floats) -> Floats:
    """The same of a problem that functions tell of."""

    def asked(step: Floats, free: NDArray[np.bool_]) -> Floats:
        left = y - j[:, ~free] @ step[~free]
        return np.asarray(np.linalg.lstsq(j[:, free], left, rcond=None)[0])

    return held_at_bounds(asked, lambda step: j.T @ (y - j @ step), low, high)


@given(st.integers(0, 10**6))
@examples(150)
def test_it_is_the_minimum_within_bounds(seed: int) -> None:
    j, y, low, high = problem(seed)
    found = step_of(j, y, low, high)
    told = j @ by_functions(j, y, low, high)
    np.testing.assert_allclose(told, j @ found, atol=1e-6 * (1 + np.abs(y).max()))
    assert (found >= low - 1e-12).all() and (found <= high + 1e-12).all()
    best = lsq_linear(j, y, (low, high), method="bvls", tol=1e-14)
    left = float(np.sum((y - j @ found) ** 2))
    assert left <= 2 * best.cost * (1 + 1e-9) + 1e-12


def test_a_start_that_is_beyond_a_bound_in_its_last_digit_alone_moves() -> None:
    """And one that no reading sees stays where it is."""
    j = np.column_stack([np.arange(9.0) - 4, np.zeros(9)])
    found = step_of(j, 2 * j[:, 0], np.array([-5.0, 1e-17]), np.array([5.0, 1.0]), 100.0)
    np.testing.assert_allclose(found, [2.0, 0.0], atol=1e-12)


@given(st.integers(0, 10**6), st.sampled_from([0.05, 0.5, 3.0]))
@examples(150)
def test_a_step_that_is_cut_is_within_bounds_and_not_uphill(seed: int, radius: float) -> None:
    j, y, low, high = problem(seed)
    found = step_of(j, y, low, high, radius)
    assert (found >= low - 1e-12).all() and (found <= high + 1e-12).all()
    assert np.sum((y - j @ found) ** 2) <= np.sum(y**2) * (1 + 1e-12)


def test_what_a_function_raises_comes_out() -> None:
    def asked(step: Floats, free: NDArray[np.bool_]) -> Floats:
        raise ZeroDivisionError("as asked")

    with pytest.raises(ZeroDivisionError, match="as asked"):
        held_at_bounds(asked, asked, np.zeros(2), np.ones(2))
    with pytest.raises(np.linalg.LinAlgError):
        quadratic_step(
            np.full((1, 1), np.nan), np.ones(1), (-np.ones(1), np.ones(1)), np.ones(1), 1
        )
