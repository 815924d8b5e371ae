"""What a residual depends on, and which readings are loose: found where planted, not in noise.

Groups: patterns; families in a residual; loose readings.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbpt import diagnose, read_readings
from cbpt.lab.covariance.linear_gaussian import Noise, Whitener
from cbpt.lab.covariance.outliers import inflation_of
from cbpt.lab.diagnosis.unexplained import measure_next, shape_of
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import VARIANTS
from cbpt.lab.selection.lack_of_fit import (
    Structure,
    components,
    hats,
    levels,
    product,
    smooth,
    turn,
)
from cbpt.lab.selection.linear_screen import Signatures
from cbpt.lab.selection.starts import places
from common import mostly_long
from common.comparisons import columns_of, drive_of
from common.drives import examples
from common.friction_loops import SPRING
from common.simulated import Floats, dense, plan, readings_of, truth

TIMELESS = (
    "run",
    "torque_Nm",
    "preload_N",
    "input_angle_deg",
    "elastic_angle_arcsec",
    "u_elastic_angle_arcsec",
)

# --- patterns -----------------------------------------------------------------------------


@given(st.lists(st.floats(-50, 50), min_size=2, max_size=40), st.integers(2, 9))
@examples(60)
def test_hats_add_up_to_one_and_follow_every_line(values: list[float], knots: int) -> None:
    x = np.array(values)
    found = hats(x, knots)
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=1e-9)
    assert found.min() >= 0 and found.shape[1] <= max(knots, 1)
    if len(np.unique(x)) <= knots and found.shape[1] > 1:
        left = x - found @ np.linalg.lstsq(found, x, rcond=None)[0]
        np.testing.assert_allclose(left, 0, atol=1e-6 * max(1.0, np.ptp(x)))


def test_levels_and_turns_mark_what_is_alike() -> None:
    assert levels(np.array([3.0, -1.0, 3.0])).tolist() == [[0, 1], [1, 0], [0, 1]]
    # A whole turn later is the same place.
    np.testing.assert_array_equal(turn(np.array([10.0, 370.0, 130.0]))[0], [1, 0])
    np.testing.assert_array_equal(turn(np.array([10.0, 370.0, 130.0]))[1], [1, 0])
    assert turn(np.linspace(0, 350, 36)).shape == (36, 17)


def test_products_hold_every_pattern_that_a_row_has() -> None:
    a, b = levels(np.array([0, 0, 1])), levels(np.array([0, 1, 1]))
    assert product([a, b]).tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert smooth(np.array([-2.0, 1.0])).tolist() == [[1, -1, 1, -1], [1, 0.5, 0.25, 0.125]]


# --- families in a residual ---------------------------------------------------------------


@cache
def many_angles() -> tuple[Fitter, Fit, Structure]:
    """Loads of a set with eight input angles, and the drive as stated fitted to the model."""
    columns = columns_of("dev07")
    columns["u_elastic_angle_arcsec"][:] = 0.3
    campaign = Campaign.of(drive_of("dev07"), read_readings(columns))
    campaign = readings_of(campaign, {("output_torsion", "compliance_rad_per_Nm"): 0.0}, None)
    fitter = Fitter(campaign, [])
    fit = fitter.fit(Hypothesis(), free_noise=False)
    assert fit is not None
    families = components(campaign.readings)
    return fitter, fit, Structure(families, fit.whitener, fit.margin)


def residual_of(pattern: Floats, strength: float, seed: int) -> Floats:
    """A whitened residual: a pattern of that length, and noise."""
    _, _, structure = many_angles()
    seen = structure.projected(pattern - pattern.mean())
    noise = np.random.default_rng([41, seed]).standard_normal(len(pattern))
    return np.asarray(strength * seen / np.linalg.norm(seen) + noise)


def ranked(residual: Floats) -> list[tuple[tuple[str, ...], float]]:
    """Columns and log odds of the families in a residual, the most telling first."""
    _, _, structure = many_angles()
    odds = structure.log_odds(structure.scores(structure.projected(residual)[:, None]))[:, 0]
    order = np.argsort(odds)[::-1]
    return [(structure.families[i].columns, float(odds[i])) for i in order]


def planted(pattern: Floats, seed: int = 0) -> list[tuple[tuple[str, ...], float]]:
    return ranked(residual_of(pattern, 15.0, seed))


@cache
def chance() -> Floats:
    """The largest log odds of any family in noise, sorted."""
    _, _, structure = many_angles()
    noise = np.random.default_rng([41, 98]).standard_normal((len(structure.axes[0]), 1000))
    return np.sort(structure.log_odds(structure.scores(structure.projected(noise))).max(axis=0))


@pytest.mark.parametrize("seed", range(3))
def test_a_function_of_torque_and_angle_is_found_as_such(seed: int) -> None:
    """Of 8 angles and both signs of the torque, stronger at some places than at others."""
    fitter, _, _ = many_angles()
    r = fitter.campaign.readings
    rng = np.random.default_rng([43, seed])
    angles = np.unique(r.input_angle_deg)
    size = rng.standard_normal(len(angles))[np.searchsorted(angles, r.input_angle_deg)]
    bent = rng.standard_normal(len(angles))[np.searchsorted(angles, r.input_angle_deg)]
    torque = r.torque_Nm / 8
    found = planted(size * torque + bent * torque**2, seed=seed)
    columns, odds = found[0]
    assert set(columns) == {"torque_Nm", "input_angle_deg"}
    assert odds > 20 + chance()[-1]


def test_a_function_of_torque_alone_is_found_as_such() -> None:
    fitter, _, _ = many_angles()
    found = planted(np.sin(fitter.campaign.readings.torque_Nm * 2.1))
    assert found[0][0] == ("torque_Nm",)
    others = [odds for columns, odds in found if columns != ("torque_Nm",)]
    assert found[0][1] > 3 + max(others)


def test_a_step_from_way_to_way_is_found_as_such() -> None:
    fitter, _, _ = many_angles()
    found = planted(fitter.campaign.readings.direction().astype(np.float64))
    assert found[0][0] == ("direction",)


def test_a_wave_in_time_is_found_as_such() -> None:
    fitter, _, _ = many_angles()
    time = fitter.campaign.readings.time_s
    assert time is not None
    found = planted(np.sin(9 * time / time.max()))
    assert found[0][0] == ("time_s",)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_what_began_at_a_moment_is_found_as_such(order: int) -> None:
    """An offset, a gain or a give of both signs from a third of the table on."""
    fitter, _, structure = many_angles()
    r = fitter.campaign.readings
    later = np.arange(len(r)) > 0.37 * len(r)
    shape = [np.ones(len(r)), r.torque_Nm, r.torque_Nm * np.abs(r.torque_Nm)][order]
    found = planted(later * shape)[0][0]
    assert found == (("time_s",) if order == 0 else ("torque_Nm", "time_s"))
    # One moment of many, and one form of several, share the prior odds of a family.
    mine = [f.share for f in structure.families if f.columns == ("torque_Nm", "time_s")]
    assert sum(mine) == pytest.approx(1.75)


def test_a_moment_is_one_of_the_clock_and_not_of_the_table() -> None:
    """Runs that the table has in another order than the clock; and a clock for each run."""
    n = 24
    late_first = {"time_s": np.r_[np.arange(12) + 100.0, np.arange(12)]}
    for time in (late_first["time_s"], np.tile(np.arange(12.0), 2)):
        table = {
            "run": np.repeat([1, 2], 12),
            "time_s": time,
            "torque_Nm": np.tile(np.arange(12.0), 2),
            "elastic_angle_arcsec": np.arange(n) * 1.0,
        }
        first = next(
            f.patterns[:, 0]
            for f in components(read_readings(table, need_preload=False))
            if f.columns == ("time_s",) and not f.whole
        )
        begun = set(np.flatnonzero(first > 0))
        assert begun == (set(range(24)) - {12} if time[0] == 100.0 else set(range(1, 24)))


def test_noise_shows_no_more_than_chance() -> None:
    """Correlated noise, seen through its own whitening, as much as white noise does."""
    fitter, fit, _ = many_angles()
    c = fitter.campaign
    noise = Noise(1.0, 0.5, 0.4)
    seen = fitter.look(fit, noise)
    structure = Structure(components(c.readings), seen.whitener, seen.margin)
    rng = np.random.default_rng([47, 1])
    factor = np.linalg.cholesky(dense(noise, c.u_arcsec, c.rows))
    draws = factor @ rng.standard_normal((len(c), 200))
    white = rng.standard_normal((len(c), 1000))

    def largest(residuals: Floats) -> Floats:
        scores = structure.scores(structure.projected(residuals))
        return np.asarray(structure.log_odds(scores).max(axis=0))

    bars = np.quantile(largest(white), [0.5, 0.9, 0.95])
    above = (largest(seen.whitener(draws))[:, None] > bars).mean(axis=0)
    assert (np.abs(above - [0.5, 0.1, 0.05]) < [0.11, 0.06, 0.04]).all()
    assert chance()[950] < 8


def test_scores_are_sums_of_squares_of_their_rank() -> None:
    _, _, structure = many_angles()
    n = len(structure.axes[0])
    noise = np.random.default_rng([41, 7]).standard_normal((n, 300))
    mean = structure.scores(noise).mean(axis=1)
    np.testing.assert_allclose(mean, structure.ranks, rtol=0.1, atol=0.4)
    for axes in structure.axes:
        np.testing.assert_allclose(axes.T @ axes, np.eye(axes.shape[1]), atol=1e-8)


def test_what_a_refit_takes_away_is_no_structure() -> None:
    """Numbers of the drive and the zero; the gain of the sensor is a twin of the stiffness."""
    fitter, fit, structure = many_angles()
    _, x, _ = fitter.linear(fit)
    left = structure.projected(fit.whitener(x))
    assert np.abs(left).max() < 1e-8 * np.abs(fit.whitener(x)).max()
    assert structure.scores(left).max() < 1e-10


# --- loose readings -----------------------------------------------------------------------


@cache
def around() -> tuple[Campaign, Floats, Floats, Floats]:
    """396 readings of the model: the model, the slopes of its numbers, and what the library and the
    table can follow.
    """
    campaign = readings_of(plan(), {("output_torsion", "compliance_rad_per_Nm"): 0.0}, None)
    fitter = Fitter(campaign, VARIANTS)
    fit = fitter.fit(Hypothesis(), free_noise=False)
    assert fit is not None
    signatures = Signatures(campaign, fitter.variants).about(fit, places(fitter))
    numbers = fit.point.slopes * np.array([u.unit for u in fit.unknowns])
    seen = [np.where(np.isfinite(s.columns), s.columns, 0.0) for s in signatures]
    families = [f.patterns for f in components(campaign.readings) if f.whole]
    # One group with the kernel of all, each as strong as any other: made once, it saves time.
    groups = [g @ g.T for g in (numbers, *seen, *families)]
    kernel = np.sum([k / np.trace(k) for k in groups if np.trace(k) > 0], axis=0)
    size, axes = np.linalg.eigh(kernel)
    root = axes * np.sqrt(np.maximum(size, 0.0))
    return campaign, fit.point.angle_arcsec, numbers, root[:, size > 1e-12 * size[-1]]


def loose(y: Floats) -> Floats | None:
    campaign, model, _, field = around()
    whitener = Whitener.of(Noise(), campaign.u_arcsec, campaign.rows)
    return inflation_of(y - model, campaign.offsets, [field], whitener)


def noise_of(seed: int) -> Floats:
    campaign, *_ = around()
    return campaign.u_arcsec * np.random.default_rng([53, seed]).standard_normal(len(campaign))


@pytest.mark.parametrize("seed", mostly_long(range(4), [0]))
def test_planted_outliers_are_found(seed: int) -> None:
    """8 of 396, by ten standard uncertainties."""
    campaign, model, *_ = around()
    rng = np.random.default_rng([59, seed])
    at = rng.choice(len(campaign), 8, replace=False)
    y = model + noise_of(seed)
    y[at] += 10 * campaign.u_arcsec[at] * rng.choice([-1.0, 1.0], 8)
    found = loose(y)
    assert found is not None
    assert set(np.argsort(found)[-8:]) == set(at)
    assert found[at].min() > 2.5
    # The others are normal, and stay as they are.
    assert np.count_nonzero(np.delete(found, at) > 1) <= 4


@pytest.mark.parametrize(
    ("seeds", "most"),
    [(range(100, 106), 1), pytest.param(range(100, 130), 2, marks=pytest.mark.long)],
)
def test_clean_readings_are_not_loose(seeds: range, most: int) -> None:
    _, model, *_ = around()
    assert sum(loose(model + noise_of(seed)) is not None for seed in seeds) <= most


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("eccentric_bearing", {"reference_deflection_m": 1e-6, "exponent": 2 / 3}),
        ("friction_hysteresis", {"friction_radius_m": 4e-4, "engagement_angle_rad": 2e-5}),
        ("preload_spring", {"spring_rate_N_per_m": 5e7}),
    ],
)
@pytest.mark.parametrize(
    ("length", "seed"), mostly_long([(15, 0), (15, 1), (15, 2), (80, 0)], [(15, 0), (80, 0)])
)
def test_an_effect_is_not_taken_for_loose_readings(
    effect: str, values: dict[str, float], length: float, seed: int
) -> None:
    """length: of the effect, whitened, once the numbers are refitted."""
    campaign, model, numbers, _ = around()
    size = next(iter(values))
    step = truth(campaign, {(effect, p): v for p, v in values.items()}) - model
    x = np.column_stack([numbers, campaign.offsets])
    left = step - x @ np.linalg.lstsq(x, step, rcond=None)[0]
    share = length / float(np.linalg.norm(left / campaign.u_arcsec))
    made = values | {size: share * values[size]}
    y = truth(campaign, {(effect, p): v for p, v in made.items()}) + noise_of(200 + seed)
    assert loose(y) is None


def test_heavy_tails_are_loose_and_short_ones_not() -> None:
    campaign, model, *_ = around()
    rng = np.random.default_rng(61)
    heavy = campaign.u_arcsec * rng.standard_t(3, len(campaign))
    flat = campaign.u_arcsec * rng.uniform(-1.7, 1.7, len(campaign))
    assert loose(model + heavy) is not None
    assert loose(model + flat) is None


def test_a_gain_of_each_run_is_no_lot_of_balls() -> None:
    """Where each run has an input angle of its own, a lot can follow whatever differs from run to
    run: it was certain, though readings held back were not predicted by it."""
    rng = np.random.default_rng(11)
    runs, torque = 10, np.r_[np.linspace(0, 5, 11), np.linspace(4.5, 0, 10)]
    n = len(torque)
    table = {
        "run": np.repeat(np.arange(1, runs + 1), n),
        "time_s": np.arange(runs * n) * 3.0,
        "torque_Nm": np.tile(torque, runs),
        "preload_N": np.full(runs * n, 600.0),
        "input_angle_deg": np.repeat(np.arange(runs) * 36.0, n),
        "elastic_angle_arcsec": np.zeros(runs * n),
        "u_elastic_angle_arcsec": np.full(runs * n, 0.3),
    }
    drive = drive_of("dev03")
    model = truth(Campaign.of(drive, read_readings(table)), {})
    gain = np.repeat(1 + 0.03 * rng.standard_normal(runs), n)
    table["elastic_angle_arcsec"] = model * gain + 0.3 * rng.standard_normal(runs * n)
    verdict = diagnose(drive, table).verdict
    assert (verdict.kind, verdict.effects) == ("unknown", ())


@pytest.mark.parametrize(("zero", "gain"), [(1.0, 0.0), (0.0, 0.04)])
def test_time_goes_on_though_nobody_wrote_it_down(zero: float, gain: float) -> None:
    """A zero that wanders is a noise; a span that does is a lack of fit, and no effect of the other
    columns is certain: a run-in was."""
    drive, table = drive_of("dev07"), columns_of("dev07")
    table = {name: table[name] for name in TIMELESS}
    table["u_elastic_angle_arcsec"] = np.full(len(table["torque_Nm"]), 0.3)
    model = truth(Campaign.of(drive, read_readings(table)), {})
    wave = np.sin(2 * np.pi * np.linspace(0.16, 1.66, len(model)))
    noise = 0.3 * np.random.default_rng(1).standard_normal(len(model))
    table["elastic_angle_arcsec"] = model * (1 + gain * wave) + zero * wave + noise
    found = diagnose(drive, table)
    assert not found.verdict.effects
    if zero:
        assert found.verdict.kind in ("rig", "complete") and "wanders" in found.sentence
    else:
        assert found.verdict.kind == "unknown" and "order of the readings" in found.sentence
        assert "write down the time" in measure_next(found)


@pytest.mark.parametrize("seed", mostly_long(range(4), [0]))
def test_a_crack_at_a_moment_has_no_name(seed: int) -> None:
    """A give of the second order from a moment on: pairs and triples of effects that look alike in
    some places were certain where the unnamed had to be any curve at all times."""
    drive, table = drive_of("dev07"), columns_of("dev07")
    table["u_elastic_angle_arcsec"] = np.full(len(table["torque_Nm"]), 0.3)
    campaign = Campaign.of(drive, read_readings(table))
    torque = campaign.readings.torque_Nm / np.abs(campaign.readings.torque_Nm).max()
    n = len(torque)
    crack = 1.5 * torque * np.abs(torque) * (np.arange(n) > 0.42 * n)
    noise = 0.3 * np.random.default_rng([71, seed]).standard_normal(n)
    table["elastic_angle_arcsec"] = truth(campaign, {}) + crack + noise
    found = diagnose(drive, table)
    assert found.verdict.kind == "unknown" and not found.verdict.effects


def test_the_shape_of_what_began_is_nothing_before_it() -> None:
    """It was told as -2.76e-18, what is left of a mean."""
    readings = read_readings(columns_of("dev07"))
    begun = np.where(np.arange(len(readings)) > 0.5 * len(readings), 0.8, -2.76e-18)
    left = SimpleNamespace(fitted_arcsec=begun, columns=("time_s",))
    d = SimpleNamespace(verdict=SimpleNamespace(lack_of_fit=left), readings=readings)
    [line] = shape_of(cast(Any, d))
    assert line.startswith("0 at 0 to ") and "+0.8 at" in line and "e-1" not in line


def test_a_wave_over_the_torque_is_no_set_of_effects() -> None:
    """Three waves over the range. A stiffness, two kinds of a bent curve and a torque zero that
    nearly cancel followed it for certain, as a curve of any shape was taken to be more complex."""
    torque = np.r_[0:10:0.5, 10:-10:-0.5, -10:10:0.5, 10:-10:-0.5, -10:0.1:0.5]
    noise = np.random.default_rng(2).normal(0.0, 2.0, len(torque))
    table = {
        "torque_Nm": torque,
        "elastic_angle_arcsec": 60 * torque + 15 * np.sin(0.9 * torque + 1) + noise,
        "u_elastic_angle_arcsec": np.full(len(torque), 2.0),
    }
    found = diagnose(SPRING, read_readings(table, need_preload=False))
    assert found.verdict.kind == "unknown", found.sentence
    assert found.unknown is not None
