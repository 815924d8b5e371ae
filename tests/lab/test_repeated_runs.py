"""What comes again in runs that repeat each other is law, what does not is noise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.covariance.repeated_runs import (
    comes_again,
    differing_of,
    kinds_of_runs,
    most_correlation,
)
from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]
RUNS, N = 5, 64
SHARES = np.interp(np.linspace(0, 4, N), [0, 1, 3, 4], [0.0, 1.0, -1.0, 0.0])


def table(peaks: Floats, seed: int = 0) -> Readings:
    """Ramps whose torque is measured as it comes."""
    rng = np.random.default_rng(seed)
    torque = np.concatenate([SHARES * p + 0.02 * p * rng.standard_normal(N) for p in peaks])
    data = {
        "run": np.repeat(np.arange(len(peaks)), N),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 10 * torque,
    }
    return cbpt.read_readings(data, need_preload=False)


def noise(correlation: float, seed: int, runs: int = RUNS) -> Floats:
    rng = np.random.default_rng(seed)
    e = rng.standard_normal((runs, N))
    for j in range(1, N):
        e[:, j] = correlation * e[:, j - 1] + np.sqrt(1 - correlation**2) * e[:, j]
    return e.ravel()


def test_noise_does_not_come_again_however_slow_it_is() -> None:
    readings = table(np.full(RUNS, 4.0))
    for correlation in (0.0, 0.6, 0.95):
        chances = []
        for seed in range(60):
            found = comes_again(readings, noise(correlation, seed))
            assert found is not None
            chances.append(found.p_value)
        assert np.mean(np.array(chances) < 0.05) < 0.17, correlation
        assert min(chances) > 1e-4, correlation


def test_a_law_comes_again_under_slow_noise() -> None:
    readings = table(np.full(RUNS, 4.0))
    law = np.tile(2.0 * np.sin(4 * SHARES), RUNS)
    found = comes_again(readings, law + noise(0.95, 1) + np.repeat(np.arange(RUNS), N))
    assert found is not None and found.p_value < 1e-3
    assert 0.5 < found.scatter_arcsec < 1.5


def test_runs_with_other_torques_are_no_repeats() -> None:
    assert comes_again(table(np.array([4.0, 5.0, 40.0])), noise(0.0, 0, 3)) is None
    one = table(np.array([4.0, 40.0, 4.0]))
    found = comes_again(one, noise(0.0, 0, 3))
    assert found is not None and found.p_value > 1e-3


def test_what_two_tables_leave_alike_does_not_differ() -> None:
    before, after = table(np.full(RUNS, 4.0)), table(np.full(RUNS, 4.0), seed=1)
    law, more = np.tile(50 * np.sin(4 * SHARES), RUNS), np.tile(3 * np.cos(9 * SHARES), RUNS)
    one = [np.ones(RUNS * N)] * 2
    same = differing_of([before, after], [law, law], one)
    assert same is not None and same.arcsec == pytest.approx(0.0, abs=1e-9)
    assert same.correlation == 1.0 and same.p_value == 1.0
    found = differing_of([before, after], [law, law + more], one)
    off = 3 * (np.cos(9 * SHARES) - np.mean(np.cos(9 * SHARES)))
    assert found is not None and found.arcsec == pytest.approx(np.sqrt(np.mean(off**2) / 2))
    assert differing_of([before, table(np.full(RUNS, 8.0))], [law, law], one) is None


def test_how_much_of_a_law_is_alike_in_two_tables() -> None:
    """Under noise as large as the laws: their correlation is found, and noise has none."""
    before, after = table(np.full(RUNS, 4.0)), table(np.full(RUNS, 4.0), seed=1)
    shared, own = np.sin(9 * SHARES), np.cos(9 * SHARES)
    shared, own = (np.tile((x - x.mean()) / x.std(), RUNS) for x in (shared, own))
    one = [np.ones(RUNS * N)] * 2
    for angle in (0.0, 0.5, 1.0, 1.5):
        after_it = np.cos(angle) * shared + np.sin(angle) * own
        found = [
            differing_of(
                [before, after], [shared + noise(0.5, s), after_it + noise(0.5, 100 + s)], one
            )
            for s in range(10)
        ]
        alike = np.array([f.correlation for f in found if f is not None])
        r = float(np.corrcoef(shared, after_it)[0, 1])
        assert np.mean(alike) == pytest.approx(r, abs=0.1), angle
        if angle >= 1.0:
            assert all(f is not None and f.p_value < 1e-3 for f in found), angle


def test_noise_does_not_differ_from_table_to_table() -> None:
    before, after = table(np.full(RUNS, 4.0)), table(np.full(RUNS, 4.0), seed=1)
    one = [np.ones(RUNS * N)] * 2
    for correlation in (0.0, 0.6, 0.95):
        chances = []
        for seed in range(60):
            left = [noise(correlation, seed), noise(correlation, 1000 + seed)]
            found = differing_of([before, after], left, one)
            assert found is not None
            chances.append(found.p_value)
        assert np.mean(np.array(chances) < 0.05) < 0.17, correlation
        assert min(chances) > 1e-4, correlation


def sizes(rng: np.random.Generator, mean: float) -> Floats:
    return mean + 0.1 * rng.standard_normal(RUNS)


def test_a_law_whose_size_differs_from_run_to_run_is_no_other_one() -> None:
    """Readings tell that the tables differ, and the runs that they do so themselves."""
    tables = [table(np.full(RUNS, 4.0)), table(np.full(RUNS, 4.0), seed=1)]
    law, one = 50 * np.sin(9 * SHARES), [np.ones(RUNS * N)] * 2
    rng = np.random.default_rng(5)

    def left(mean: float) -> Floats:
        return np.outer(sizes(rng, mean), law).ravel() + rng.standard_normal(RUNS * N)

    alike = [differing_of(tables, [left(1.0), left(1.0)], one) for _ in range(200)]
    of_sizes = np.array([f.p_value_of_sizes for f in alike if f is not None])
    assert np.mean([f is not None and f.p_value < 1e-3 for f in alike]) > 0.05
    assert np.mean(of_sizes < 0.05) == pytest.approx(0.05, abs=0.04)
    assert np.mean(of_sizes < 0.5) == pytest.approx(0.5, abs=0.1)
    grown = differing_of(tables, [left(1.0), left(1.6)], one)
    assert grown is not None and grown.correlation > 0.9 and grown.p_value_of_sizes < 1e-3


def test_a_little_of_another_law_is_not_another_size() -> None:
    """Its part along the law is a size too, and runs that agree tell it for certain."""
    tables = [table(np.full(RUNS, 4.0)), table(np.full(RUNS, 4.0), seed=1)]
    law, one = 40 * np.sin(9 * SHARES), [np.ones(RUNS * N)] * 2
    rng = np.random.default_rng(6)
    chances = []
    for _ in range(40):
        other = [6 * np.cos(rng.uniform(2, 12) * SHARES + rng.uniform(0, 6)) for _ in tables]
        left = [np.tile(law + more, RUNS) + rng.standard_normal(RUNS * N) for more in other]
        found = differing_of(tables, left, one)
        assert found is not None and found.correlation**2 > 0.5
        chances.append(found.p_value_of_sizes)
    assert np.mean(np.array(chances) < 1e-3) < 0.2
    both = [table(np.repeat([4.0, 40.0], 2), seed=s) for s in (0, 1)]
    grew = [np.tile(k * law, 4) + rng.standard_normal(4 * N) for k in (1.0, 1.4)]
    kinds = differing_of(both, grew, [np.ones(4 * N)] * 2)
    assert kinds is not None and kinds.p_value_of_sizes < 1e-3


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_the_differences_of_runs_bound_the_correlation_of_noise(correlation: float) -> None:
    """Whatever law is the same in every run: one bound in a hundred lies below the truth."""
    readings = table(np.full(RUNS, 4.0))
    law = np.tile(30.0 * np.tanh(3 * SHARES), RUNS) + np.repeat(10.0 * np.arange(RUNS), N)
    bounds = [most_correlation(readings, law + noise(correlation, seed)) for seed in range(60)]
    assert np.mean(np.array(bounds) < correlation) < 0.07
    assert np.median(bounds) < correlation + 0.2


def test_without_repeated_runs_any_correlation_is_possible() -> None:
    assert most_correlation(table(np.array([4.0, 5.0, 40.0])), noise(0.0, 0, 3)) == 1.0
    same = table(np.full(RUNS, 4.0))
    assert most_correlation(same, np.tile(SHARES, RUNS)) == 1.0


def test_runs_of_a_kind_that_scatters_more_are_less_certain() -> None:
    """Half way by the logarithms; a kind that is not repeated is like the nearest one."""
    peaks = np.array([4.0, 4.0, 4.0, 4.0, 40.0, 40.0, 40.0, 40.0, 20.0])
    readings, rng = table(peaks), np.random.default_rng(3)
    size = np.repeat(np.where(peaks < 10, 10.0, 160.0), N)
    found = kinds_of_runs(readings, size * rng.standard_normal(len(size)))
    small, large, other = found[0], found[4 * N], found[-1]
    assert large / small == pytest.approx(4.0, rel=0.15) and other == large
    assert np.mean(found**2) == pytest.approx(1.0)
    assert np.all(kinds_of_runs(table(np.full(RUNS, 4.0)), noise(0.0, 0)) == 1.0)


def test_runs_that_agree_in_every_digit_are_no_exact_ones() -> None:
    """Their readings are known no better than a step of the display, and rounding is no scatter."""
    peaks = np.repeat([4.0, 40.0, 60.0], 4)
    readings, rng = table(peaks), np.random.default_rng(3)
    again = np.repeat(peaks > 10, N)
    left = np.where(again, 10 * rng.standard_normal(len(again)), 0.0)
    left += np.where(again, 0.0, 1e-13 * rng.standard_normal(len(again)))
    found = kinds_of_runs(readings, left)
    assert found.max() / found.min() < 2
