"""The noise that suits some readings: found in noise, against dense likelihoods and grids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from cbpt.lab.covariance.artefacts import random_walk
from cbpt.lab.covariance.fit_noise import (
    LEAST_SCALE,
    PRICE,
    STATED_DOF,
    fit_noise,
)
from cbpt.lab.covariance.linear_gaussian import (
    Linear,
    Margin,
    Noise,
    Rows,
    Whitener,
    log_likelihood,
)
from common import mostly_long
from common.simulated import FLAT, ONE, TWELVE, Floats, U, dense, prior_of_scale, sample


def found(y: Floats, start: Noise | None = None, structures: bool = True) -> Noise:
    return fit_noise(Linear(y, ONE, FLAT), U, TWELVE, start or Noise(), structures=structures)[0]


def many(noise: Noise, seeds: int = 8) -> list[Noise]:
    return [found(sample(noise, U, TWELVE, np.random.default_rng([7, s]))) for s in range(seeds)]


@pytest.mark.parametrize("scale", mostly_long([0.5, 1.0, 1.3, 3.0], [0.5, 3.0]))
def test_the_scale_is_found(scale: float) -> None:
    got = np.array([n.scale for n in many(Noise(scale))])
    # A sample of 396 tells its spread to 3.6 %; the stated one counts as eight readings.
    assert np.abs(got / scale - 1).max() < 0.12
    assert got.mean() == pytest.approx(scale, rel=0.04)


@pytest.mark.parametrize("rho", mostly_long([0.3, 0.6, 0.85], [0.6]))
def test_correlation_is_found(rho: float) -> None:
    got = many(Noise(1.0, rho))
    correlations = np.array([n.correlation for n in got])
    # A sample of 396 tells it to 4.8 % of sqrt(1 - rho^2), of which four at most.
    assert np.abs(correlations - rho).max() < 0.2 * np.sqrt(1 - rho**2)
    assert correlations.mean() == pytest.approx(rho, abs=0.05)
    assert np.mean([n.scale for n in got]) == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("offset", mostly_long([0.3, 0.8, 4.0], [0.8]))
def test_zeros_of_the_runs_are_found(offset: float) -> None:
    got = many(Noise(1.0, 0.0, offset))
    offsets = np.array([n.offset_arcsec for n in got])
    # Twelve runs tell their spread to 21 %.
    assert (np.abs(np.log(offsets / offset)) < 0.7).all()
    assert offsets.mean() == pytest.approx(offset, rel=0.2)
    assert [n.correlation for n in got].count(0.0) >= 7
    assert np.mean([n.scale for n in got]) == pytest.approx(1.0, rel=0.05)


def test_correlation_and_zeros_are_found_together() -> None:
    got = many(Noise(1.0, 0.6, 1.5))
    assert all(n.correlation and n.offset_arcsec for n in got)
    assert np.mean([n.correlation for n in got]) == pytest.approx(0.6, abs=0.08)
    assert np.mean([n.offset_arcsec for n in got]) == pytest.approx(1.5, rel=0.25)


def most_likely(y: Floats) -> float:
    """Largest log likelihood of scale, correlation and zeros, by a search of its own; dense."""

    def negative(p: Floats) -> float:
        noise = Noise(float(np.exp(p[0])), float(np.tanh(p[1])), float(np.exp(p[2])))
        c = dense(noise, U[:99], ROWS_3)
        factor = np.linalg.cholesky(c)
        both = np.linalg.solve(factor, np.column_stack([y, ONE[:99]]))
        size = float(both[:, 1] @ both[:, 1])
        chi2 = float(both[:, 0] @ both[:, 0]) - float(both[:, 0] @ both[:, 1]) ** 2 / size
        value = -0.5 * chi2 - float(np.log(np.diag(factor)).sum()) - 0.5 * np.log(size)
        return -float(value + prior_of_scale(noise.scale, STATED_DOF))

    starts = [(0.0, 0.5, -3.0), (0.0, 0.5, 0.0)]
    return -min(float(minimize(negative, s, method="Nelder-Mead").fun) for s in starts)


ROWS_3 = Rows.of(np.repeat(np.arange(3), 33))


@pytest.mark.parametrize(
    "noise",
    [
        Noise(1.0, 0.6),
        Noise(1.0, 0.0, 1.5),
        Noise(1.0, 0.5, 1.0),
    ],
)
def test_no_other_noise_is_much_likelier(noise: Noise) -> None:
    """The search on a coarse grid comes near the top of the likelihood."""
    y = sample(noise, U[:99], ROWS_3, np.random.default_rng(11))
    got, value = fit_noise(Linear(y, ONE[:99], FLAT), U[:99], ROWS_3, Noise())
    top = most_likely(y)
    assert top - 2 * PRICE - 0.5 < value <= top - PRICE * got.numbers + 0.01


def test_white_stays_white() -> None:
    got = many(Noise(), seeds=60)
    assert sum(n.numbers == 0 for n in got) >= 57


def test_loose_readings_are_taken_as_given() -> None:
    inflation = np.ones(396)
    inflation[::20] = 8.0
    y = sample(Noise(1.2, inflation=inflation), U, TWELVE, np.random.default_rng(1))
    told, untold = found(y, Noise(inflation=inflation)), found(y)
    assert told.inflation is inflation
    assert told.scale == pytest.approx(1.2, rel=0.1)
    assert untold.scale > 1.7


def test_without_structures_only_the_scale_is_free() -> None:
    y = sample(Noise(1.0, 0.8, 2.0), U, TWELVE, np.random.default_rng(2))
    assert found(y, structures=False).numbers == 0


def test_a_single_reading_a_run_has_no_structure() -> None:
    rows = Rows.of(np.arange(30))
    y = 0.3 * np.random.default_rng(3).standard_normal(30)
    noise, _ = fit_noise(Linear(y, np.ones((30, 1)), FLAT), U[:30], rows, Noise())
    assert noise.numbers == 0


@pytest.mark.parametrize("seed", range(4))
def test_columns_that_are_alike_and_the_same_all_along_each_run_are_no_error(seed: int) -> None:
    """Beside large offsets of the runs no more is left of them than rounding."""
    rng = np.random.default_rng(seed)
    rows, alike = Rows.of(np.repeat(np.arange(84), 3)), np.repeat(rng.standard_normal(84), 3)
    x = np.column_stack([alike, 3.7 * alike, 1.09 * alike, np.ones(252)])
    y = 20 * np.repeat(rng.standard_normal(84), 3) + rng.standard_normal(252)
    noise, value = fit_noise(Linear(y, x, np.zeros(4)), np.ones(252), rows, Noise())
    assert noise.offset_arcsec > 5
    assert np.isfinite(value)


@pytest.mark.parametrize("noise", [Noise(1.4), Noise(0.8, 0.6), Noise(1.2, 0.0, 0.9)])
def test_the_value_is_the_dense_likelihood_less_its_price(noise: Noise) -> None:
    rng = np.random.default_rng(4)
    y = sample(noise, U, TWELVE, rng) + 2.0
    x = np.column_stack([ONE, np.sin(np.arange(396.0))])
    precision = np.array([0.0, 0.5])
    got, value = fit_noise(Linear(y, x, precision), U, TWELVE, Noise())
    inverse = np.linalg.inv(dense(got, U, TWELVE))
    a = x.T @ inverse @ x + np.diag(precision)
    chi2 = y @ inverse @ y - (x.T @ inverse @ y) @ np.linalg.solve(a, x.T @ inverse @ y)
    exact = -0.5 * (chi2 - np.linalg.slogdet(inverse)[1])
    exact += -0.5 * np.linalg.slogdet(a)[1] + 0.5 * np.log(precision[1])
    exact += prior_of_scale(got.scale, STATED_DOF) - PRICE * got.numbers
    assert value == pytest.approx(exact, abs=0.02)


def test_the_scale_is_the_most_probable_one() -> None:
    """Of the marginal likelihood times its prior, dense and on a grid."""
    y = sample(Noise(1.7), U, TWELVE, np.random.default_rng(6))
    centred = y - y.mean()
    chi2 = float(centred @ centred) / 0.3**2

    def log_posterior(scale: float) -> float:
        return (
            -0.5 * chi2 / float(scale) ** 2
            - 395 * float(np.log(scale))
            + prior_of_scale(scale, STATED_DOF)
        )

    grid = np.linspace(1.2, 2.2, 2001)
    best = grid[np.argmax([log_posterior(s) for s in grid])]
    assert found(y, structures=False).scale == pytest.approx(best, rel=1e-3)


WALK = random_walk(np.arange(396.0))
assert WALK is not None


@pytest.mark.parametrize(
    "beside",
    [
        Noise(rounding_arcsec=np.full(396, 0.6)),
        Noise(torque_arcsec=np.full(396, 0.6)),
        Noise(artefact=WALK.sized(0.3)),
    ],
    ids=["rounding", "torque", "artefact"],
)
@pytest.mark.parametrize("scale", [0.5, 1.0, 4.0])
def test_the_scale_is_the_most_probable_one_beside_what_has_none(
    scale: float, beside: Noise
) -> None:
    """It stopped on its way, and noises were compared there."""
    noise = replace(beside, scale=scale)
    y = sample(noise, U, TWELVE, np.random.default_rng(6))
    linear = Linear(y, ONE, FLAT)

    def log_posterior(at: float) -> float:
        whitener = Whitener.of(replace(noise, scale=at), U, TWELVE)
        margin = Margin.of(whitener(y), whitener(ONE), FLAT)
        return log_likelihood(margin.chi2, whitener, margin.log_volume) + prior_of_scale(
            at, STATED_DOF
        )

    grid = np.geomspace(LEAST_SCALE, 8.0, 300)
    most = max(log_posterior(s) for s in grid)
    got, _ = fit_noise(linear, U, TWELVE, beside, structures=False)
    assert log_posterior(got.scale) == pytest.approx(most, abs=0.05)


def test_a_scale_far_below_what_is_stated_is_not_believed() -> None:
    y = sample(Noise(0.05), U, TWELVE, np.random.default_rng(8))
    assert found(y).scale == LEAST_SCALE


def test_nothing_stated_leaves_the_scale_to_the_readings() -> None:
    y = sample(Noise(50.0), U, TWELVE, np.random.default_rng(7))
    noise, _ = fit_noise(Linear(y, ONE, FLAT), U, TWELVE, Noise(), stated_dof=1e-3)
    assert noise.scale == pytest.approx(float(np.std(y, ddof=1)) / 0.3, rel=1e-4)
    assert prior_of_scale(1.0, STATED_DOF) == 0.0
    assert prior_of_scale(0.5, STATED_DOF) < 0 and prior_of_scale(2.0, STATED_DOF) < 0


@pytest.mark.parametrize(
    ("noise", "correlated", "offsets"),
    [
        (Noise(), False, False),
        (Noise(1.0, 0.0, 1.2), False, True),
        (Noise(1.0, 0.7), True, False),
        (Noise(1.0, 0.6, 1.5), True, True),
    ],
)
def test_structure_shows_through_a_coarse_display(
    noise: Noise, correlated: bool, offsets: bool
) -> None:
    """It used to be switched off, and offsets came out as a lack of fit."""
    step = 1.8 * 0.3
    display = Noise(rounding_arcsec=np.full(396, step / 12**0.5))
    curve = 40 * np.sin(0.7 * np.arange(396.0))
    for seed in range(4):
        exact = curve + sample(noise, U, TWELVE, np.random.default_rng([9, seed]))
        got = found(step * np.round(exact / step) - curve, display)
        assert (bool(got.correlation), bool(got.offset_arcsec)) == (correlated, offsets)
        assert got.scale == pytest.approx(1.0, rel=0.3)
        if offsets:
            assert 0.4 < got.offset_arcsec / noise.offset_arcsec < 2.2
        if correlated:
            assert got.correlation == pytest.approx(noise.correlation, abs=0.2)
