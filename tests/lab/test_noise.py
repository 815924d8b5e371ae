"""What scatters: whitening and margins against dense matrices.

Groups: order of rows; whitening; artefacts of the instrument; a coarse display; margins.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy import integrate, stats

from cbpt.lab.covariance.artefacts import (
    Artefact,
    encoders,
    first_readings,
    gains_of,
    random_walk,
    without,
)
from cbpt.lab.covariance.fit_noise import (
    PRICE,
    _Sums,
    fit_noise,
    price_of,
)
from cbpt.lab.covariance.linear_gaussian import (
    Held,
    Linear,
    Margin,
    Noise,
    Rows,
    Whitener,
    log_likelihood,
)
from cbpt.lab.covariance.outliers import price_of_inflation
from cbpt.lab.covariance.rounding import rounds_alike, scatter_behind
from common.drives import examples
from common.simulated import FLAT, ONE, TWELVE, Floats, U, dense, sample

# --- order of rows ------------------------------------------------------------------------

RUNS = arrays.arrays(np.int64, st.integers(1, 24), elements=st.integers(0, 4))


@given(RUNS)
@examples(60)
def test_before_is_the_last_reading_of_the_same_run(runs: np.ndarray) -> None:
    rows = Rows.of(runs)
    for i, run in enumerate(runs):
        earlier = np.flatnonzero(runs[:i] == run)
        assert rows.before[i] == (earlier[-1] if len(earlier) else -1)
    assert rows.runs == len(np.unique(runs))


@given(RUNS, st.integers(0, 99))
@examples(30)
def test_sums_are_run_by_run(runs: np.ndarray, seed: int) -> None:
    rows = Rows.of(runs)
    columns = np.random.default_rng(seed).standard_normal((len(runs), 3))
    expected = [columns[runs == run].sum(axis=0) for run in np.unique(runs)]
    np.testing.assert_allclose(rows.sums(columns), expected, atol=1e-12)


def test_selected_rows_follow_each_other_across_what_is_gone() -> None:
    rows = Rows.of(np.array([7, 3, 7, 7, 3])).select(np.array([True, True, False, True, True]))
    assert rows.before.tolist() == [-1, -1, 0, 1]


# --- whitening ----------------------------------------------------------------------------


@st.composite
def noises(draw: st.DrawFn) -> tuple[Noise, Floats, Rows]:
    runs = draw(RUNS)
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    inflation = np.exp(rng.uniform(0, 2, len(runs))) if draw(st.booleans()) else None
    columns = rng.uniform(-2, 2, (len(runs), draw(st.integers(1, 3))))
    rows = Rows.of(runs)
    index = np.empty(len(runs), dtype=np.int64)
    begins = rng.random(len(runs)) < 0.4
    begins[rows.starts] = True
    index[rows.order] = np.cumsum(begins)
    noise = Noise(
        scale=draw(st.floats(0.1, 10)),
        correlation=draw(st.sampled_from([0.0, -0.5, 0.2, 0.6, 0.95])),
        offset_arcsec=draw(st.sampled_from([0.0, 0.01, 1.0, 30.0])),
        inflation=inflation,
        rounding_arcsec=rng.uniform(0.1, 2.0, len(runs)) if draw(st.booleans()) else None,
        torque_arcsec=rng.uniform(0.1, 2.0, len(runs)) if draw(st.booleans()) else None,
        held=Held(rng.uniform(0.1, 2.0, len(runs)), index) if draw(st.booleans()) else None,
        artefact=Artefact("random_walk", columns) if draw(st.booleans()) else None,
    )
    return noise, rng.uniform(0.1, 3.0, len(runs)), rows


@given(noises())
@examples(60)
def test_whitener_is_a_root_of_the_inverse_covariance(drawn: tuple[Noise, Floats, Rows]) -> None:
    noise, u, rows = drawn
    covariance = dense(noise, u, rows)
    whitener = Whitener.of(noise, u, rows)
    w = whitener(np.eye(len(u)))
    rounding = 1e-14 * float(np.linalg.cond(covariance))
    np.testing.assert_allclose(w @ covariance @ w.T, np.eye(len(u)), atol=1e-9 + rounding)
    sign, log_det = np.linalg.slogdet(covariance)
    assert sign == 1
    assert whitener.log_det == pytest.approx(log_det, abs=1e-9 * (1 + abs(log_det)) + rounding)


@given(noises(), st.integers(0, 99))
@examples(30)
def test_whitener_takes_vectors_and_columns_alike(
    drawn: tuple[Noise, Floats, Rows], seed: int
) -> None:
    noise, u, rows = drawn
    whitener = Whitener.of(noise, u, rows)
    columns = np.random.default_rng(seed).standard_normal((len(u), 4))
    given_columns = columns.copy()
    whole = whitener(columns)
    for j in range(4):
        np.testing.assert_allclose(whole[:, j], whitener(columns[:, j]), atol=1e-12)
    np.testing.assert_array_equal(columns, given_columns)


def test_what_is_known_of_each_reading_is_selected_with_it() -> None:
    each = np.arange(1.0, 4.0)
    noise = Noise(inflation=each, rounding_arcsec=2 * each, torque_arcsec=3 * each)
    some = noise.select(np.array([True, False, True]))
    assert some.inflation is not None and some.beside_arcsec is not None
    assert some.inflation.tolist() == [1, 3]
    np.testing.assert_allclose(some.beside_arcsec, np.hypot([2, 6], [3, 9]))
    assert noise.numbers == 1 and Noise(torque_arcsec=None).beside_arcsec is None
    of_holds = Noise(held=Held(each, np.array([4, 4, 5]))).select(np.array([True, False, True]))
    assert of_holds.held is not None and of_holds.held.sd_arcsec.tolist() == [1, 3]
    assert of_holds.held.index.tolist() == [4, 5] and of_holds.numbers == 0
    shared = Noise(artefact=Artefact("random_walk", each[:, None]))
    kept = shared.select(np.array([True, False, True])).artefact
    assert kept is not None and kept.columns_arcsec.tolist() == [[1], [3]]
    assert shared.numbers == 1


def factors_of(z: Floats) -> Floats:
    return np.sqrt(np.maximum((4 + z**2) / 5, 1.0))


def test_heavy_tails_cost_what_students_t_says_less() -> None:
    z = stats.t.ppf((np.arange(400) + 0.5) / 400, 4)
    claimed = stats.norm.logpdf(z, scale=factors_of(z)) - stats.t.logpdf(z, 4)
    assert price_of_inflation(factors_of(z)) == pytest.approx(claimed.sum(), rel=0.02)
    noise = Noise(correlation=0.3, inflation=factors_of(z))
    assert price_of(noise) > price_of(Noise()) + PRICE


@pytest.mark.parametrize("n", [40, 400])
def test_one_outlier_costs_its_share_and_its_place_alone(n: int) -> None:
    """A normal distribution of which a share from 0.002 to 0.1 is wrong, by Cauchy's of scale 10.
    All other readings are normal, and pay nothing for tails that they do not show."""
    z = 19.0
    inflation = np.ones(n)
    inflation[0] = factors_of(np.array([z]))[0]

    def says(log_share: float) -> float:
        share = np.exp(log_share)
        rest = (1 - share) ** (n - 1)
        one = share * stats.cauchy.pdf(z, scale=10) + (1 - share) * stats.norm.pdf(z)
        return float(one * rest)

    ends = np.log([0.002, 0.1])
    said = integrate.quad(says, *ends)[0] / np.ptp(ends)
    claimed = stats.norm.logpdf(z, scale=inflation[0]) - np.log(said)
    assert price_of_inflation(inflation) == pytest.approx(claimed, abs=0.1)
    heavy = stats.norm.logpdf(z, scale=inflation[0]) - stats.t.logpdf(z, 4) + 0.09 * (n - 1)
    assert price_of_inflation(inflation) < heavy - 3


def test_likelihood_is_that_of_the_dense_normal() -> None:
    rng = np.random.default_rng(5)
    rows = Rows.of(np.arange(40) % 3)
    u = rng.uniform(0.2, 0.5, 40)
    noise = Noise(1.3, 0.5, 0.4)
    y = sample(noise, u, rows, rng)
    c = dense(noise, u, rows)
    exact = -0.5 * (y @ np.linalg.solve(c, y) + np.linalg.slogdet(c)[1])
    whitener = Whitener.of(noise, u, rows)
    white = whitener(y)
    assert log_likelihood(float(white @ white), whitener, 0.0) == pytest.approx(exact, abs=1e-9)


# --- artefacts of the instrument ----------------------------------------------------------


def test_a_random_walk_is_brownian_motion() -> None:
    """Its covariance is the smaller of two shares of the time that has passed."""
    time_s = np.array([100.0, 130.0, 150.0, 300.0, 500.0, 900.0])
    walk = random_walk(time_s)
    assert walk is not None
    share = (time_s - 100) / 800
    found = walk.columns_arcsec @ walk.columns_arcsec.T
    np.testing.assert_allclose(found, np.minimum.outer(share, share), atol=0.02)
    assert random_walk(np.full(5, 7.0)) is None


def test_first_readings_need_runs_with_others() -> None:
    alike, found = first_readings(Rows.of(np.repeat([0, 1, 2], 4)).before)
    assert alike.columns_arcsec.shape == (12, 1)
    assert np.flatnonzero(found.columns_arcsec[:, 0]).tolist() == [0, 4, 8]
    rows, runs = np.nonzero(found.columns_arcsec[:, 1:])
    assert (rows.tolist(), runs.tolist()) == ([0, 4, 8], [0, 1, 2])
    [many] = first_readings(Rows.of(np.repeat(np.arange(65), 3)).before)
    assert many.columns_arcsec.shape == (195, 1)
    assert not list(first_readings(Rows.of(np.repeat([0, 1], 4)).before))
    assert not list(first_readings(Rows.of(np.repeat([0, 1, 2], 2)).before))


def test_periods_of_an_encoder_are_those_that_the_readings_sample() -> None:
    """No curves, no scatter, and no sine through a few angles."""
    angle, rng = np.linspace(-50.0, 50.0, 400), np.random.default_rng(1)
    wanted, found = np.sin(0.7 + 2 * np.pi * angle / 10), encoders(angle, angle, 0.5)
    left = [wanted - a.columns_arcsec @ np.linalg.lstsq(a.columns_arcsec, wanted)[0] for a in found]
    assert min(float(np.linalg.norm(x)) for x in left) < 1e-9
    assert {a.among for a in found} == {len(found)} and len(found) < 200
    assert price_of(Noise(artefact=found[0])) > price_of(
        Noise(artefact=Artefact("encoder", found[0].columns_arcsec))
    )
    assert encoders(angle, angle, 20.0) == [] and encoders(np.zeros(9), np.zeros(9), 0.5) == []
    few = np.repeat(np.linspace(-50.0, 50.0, 9), 40)
    assert encoders(few + 3 * rng.standard_normal(len(few)), few, 0.5) == []


@given(st.integers(1, 4), st.floats(0.1, 30), st.integers(0, 99))
@examples(30)
def test_what_an_artefact_gains_is_that_of_the_dense_normal(k: int, size: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, columns = rng.standard_normal(30), rng.standard_normal((30, k))
    covariance = np.eye(30) + size**2 * columns @ columns.T
    exact = stats.multivariate_normal.logpdf(y, cov=covariance)
    exact -= stats.multivariate_normal.logpdf(y, cov=np.eye(30))
    found = gains_of(columns.T @ columns, columns.T @ y, np.array([1.0, size]))
    assert found.shape == (2,)
    assert found[1] == pytest.approx(exact, abs=1e-8 * (1 + size**2))
    left = without(Artefact("random_walk", size * columns), y, np.ones(30))
    np.testing.assert_allclose(left, np.linalg.solve(covariance, y), atol=1e-8 * (1 + size**2))


# --- a coarse display ---------------------------------------------------------------------


@given(noises(), st.integers(0, 99))
@examples(60)
def test_products_of_columns_are_those_of_whitened_ones(
    drawn: tuple[Noise, Floats, Rows], seed: int
) -> None:
    """Found once, for any scale, correlation and offset."""
    noise, u, rows = drawn
    columns = np.random.default_rng(seed).standard_normal((len(u), 4))
    start = replace(noise, scale=1.0, correlation=0.0, offset_arcsec=0.0)
    whitener = Whitener.of(noise, u, rows)
    seen = whitener(columns)
    gram, log_det = _Sums(columns, u, rows, start).gram(noise)
    own = np.sqrt(np.diag(seen.T @ seen))
    # Offsets far above the scatter leave the difference of large numbers.
    np.testing.assert_allclose(
        gram / own / own[:, None], seen.T @ seen / own / own[:, None], atol=1e-6
    )
    assert log_det == pytest.approx(whitener.log_det, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("offset", [0.0, 0.7])
@pytest.mark.parametrize("correlation", [0.0, 0.6, 0.95])
@pytest.mark.parametrize("rounded", [False, True])
def test_holds_and_a_rounding_are_whitened_beside_a_correlation(
    offset: float, correlation: float, rounded: bool
) -> None:
    """Runs of any length, interleaved."""
    rng = np.random.default_rng(5)
    run = rng.permutation(np.repeat([0, 1], [150, 40]))
    rows, u = Rows.of(run), rng.uniform(0.2, 0.5, 190)
    hold = np.empty(190, dtype=np.int64)
    hold[rows.order] = np.r_[np.repeat(np.arange(10), 15), np.repeat([10, 11], 20)]
    holds = Held(rng.uniform(0.0, 0.6, 190), hold)
    rounding = rng.uniform(0.0, 0.3, 190) if rounded else None
    noise = Noise(1.2, correlation, offset, rounding_arcsec=rounding, held=holds)
    whitener = Whitener.of(noise, u, rows)
    w, covariance = whitener(np.eye(190)), dense(noise, u, rows)
    np.testing.assert_allclose(w @ covariance @ w.T, np.eye(190), atol=1e-9)
    assert whitener.log_det == pytest.approx(float(np.linalg.slogdet(covariance)[1]))


def test_what_a_mean_torque_does_is_that_of_the_dense_normal() -> None:
    rng = np.random.default_rng(3)
    holds = Held(rng.uniform(0.1, 1.0, 12), np.repeat([7, 2, 9], 4))
    r, u = rng.standard_normal(12), rng.uniform(0.2, 0.6, 12)
    shared = dense(Noise(1e-9, held=holds), u, Rows.of(np.zeros(12, dtype=np.int64)))
    expected = shared @ np.linalg.solve(shared + np.diag(u**2), r)
    np.testing.assert_allclose(holds.most_probable(r, u**-2.0), expected, atol=1e-9)


def test_readings_that_are_no_numbers_have_no_noise() -> None:
    """An error, and no likelihood that looks like one."""
    with pytest.raises(np.linalg.LinAlgError):
        fit_noise(Linear(np.full(396, np.nan), ONE, FLAT), U, TWELVE, Noise())


def test_a_rounding_has_no_scale() -> None:
    """It is known; only what is beside it may be larger than stated."""
    u, rounding = np.full(396, 0.3), np.full(396, 0.2)
    whitener = Whitener.of(Noise(2.0, rounding_arcsec=rounding), u, TWELVE)
    np.testing.assert_allclose(whitener(np.ones(396)), 1 / np.hypot(0.6, 0.2))


def test_roundings_are_alike_without_noise_and_independent_with_much() -> None:
    assert rounds_alike(0.0) == pytest.approx(1, abs=0.01) and rounds_alike(0.0) <= 1
    assert rounds_alike(2.0) < 1e-12
    falling = [rounds_alike(steps) for steps in np.linspace(0, 1, 30)]
    assert falling == sorted(falling, reverse=True)


@pytest.mark.parametrize("steps", [0.05, 0.15, 0.3])
def test_roundings_are_as_alike_as_drawn_ones(steps: float) -> None:
    rng = np.random.default_rng(21)
    readings = rng.uniform(0, 1, 200_000) + steps * rng.standard_normal((2, 200_000))
    errors = np.round(readings) - readings
    assert rounds_alike(steps) == pytest.approx(
        float(np.mean(errors[0] * errors[1]) * 12), abs=0.01
    )


@pytest.mark.parametrize("step", [0.5, 2.0, 8.0])
@pytest.mark.parametrize("scale", [0.5, 1.0, 3.0])
def test_the_scatter_behind_a_display_is_found_from_its_steps(step: float, scale: float) -> None:
    """A number that is known loosely, one that is free, and noise that is wider than stated."""
    rng = np.random.default_rng([31, round(10 * step)])
    x = np.column_stack([40 * np.sin(0.7 * np.arange(1200.0)), np.ones(1200)])
    exact = x @ [0.8, 3.3] + scale * U[0] * rng.standard_normal(1200)
    linear = Linear(step * np.round(exact / step), x, np.array([1.0, 0.0]))
    behind = scatter_behind(linear, np.full(1200, U[0]), step)
    assert abs(np.log(behind.scale / scale)) < 4 / np.sqrt(2 * behind.dof)
    # Only readings near an edge of a step tell it.
    assert 5 < behind.dof < 1200 * min(2 * scale * U[0] / step, 1.0)


def test_a_misfit_within_the_steps_is_seen_behind_a_display() -> None:
    """It is half of what rounding adds, and many times what the readings scatter by."""
    curve = 40 * np.sin(0.7 * np.arange(1200.0))
    exact = curve + 1.2 * np.sin(0.011 * np.arange(1200.0))
    linear = Linear(8 * np.round(exact / 8) - curve, np.ones((1200, 1)), np.zeros(1))
    assert scatter_behind(linear, np.full(1200, U[0]), 8.0).scale * U[0] > 0.6


# --- margins ------------------------------------------------------------------------------


def problem(n: int, p: int, seed: int) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((n, p)) * np.exp(rng.uniform(-2, 2, p))
    return 3 * rng.standard_normal(n), x, np.exp(rng.uniform(-4, 4, p))


@given(st.integers(6, 20), st.integers(1, 5), st.integers(0, 10**6))
@examples(60)
def test_margin_is_the_dense_marginal_likelihood(n: int, p: int, seed: int) -> None:
    y, x, precision = problem(n, p, seed)
    margin = Margin.of(y, x, precision)
    c = np.eye(n) + x @ np.diag(1 / precision) @ x.T
    assert margin.chi2 == pytest.approx(y @ np.linalg.solve(c, y), rel=1e-7)
    assert margin.log_volume == pytest.approx(-0.5 * np.linalg.slogdet(c)[1], abs=1e-7)
    mode = np.diag(1 / precision) @ x.T @ np.linalg.solve(c, y)
    np.testing.assert_allclose(margin.mode, mode, rtol=1e-6, atol=1e-9)


@given(st.integers(8, 20), st.integers(1, 4), st.integers(0, 10**6))
@examples(30)
def test_flat_unknowns_are_least_squares(n: int, p: int, seed: int) -> None:
    y, x, _ = problem(n, p, seed)
    margin = Margin.of(y, x, np.zeros(p))
    expected, left, *_ = np.linalg.lstsq(x, y, rcond=None)
    np.testing.assert_allclose(margin.mode, expected, rtol=1e-5, atol=1e-8)
    assert margin.chi2 == pytest.approx(float(left[0]), rel=1e-6)
    assert margin.log_volume == pytest.approx(-0.5 * np.linalg.slogdet(x.T @ x)[1], abs=1e-6)


@given(st.integers(8, 20), st.integers(1, 4), st.integers(0, 10**6))
@examples(30)
def test_left_gives_the_scalar_products_of_whoever_refits(n: int, p: int, seed: int) -> None:
    y, x, precision = problem(n, p, seed)
    columns = np.random.default_rng(seed + 1).standard_normal((n, 3))
    c = np.eye(n) + x @ np.diag(1 / precision) @ x.T
    left = Margin.of(y, x, precision).left(columns)
    np.testing.assert_allclose(
        columns.T @ left, columns.T @ np.linalg.solve(c, columns), rtol=1e-6, atol=1e-8
    )
    np.testing.assert_allclose(y @ left, y @ np.linalg.solve(c, columns), rtol=1e-6, atol=1e-7)


def test_a_column_that_nothing_shows_does_no_harm() -> None:
    y, x, precision = problem(12, 2, 3)
    blind = np.column_stack([x, np.zeros(12)])
    margin = Margin.of(y, blind, np.r_[precision, 0.0])
    assert margin.chi2 == pytest.approx(Margin.of(y, x, precision).chi2, rel=1e-9)
    assert np.isfinite(margin.mode).all()
