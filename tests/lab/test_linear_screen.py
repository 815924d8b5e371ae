"""The library at a glance: slopes, gains and what chance alone gains.

Groups: signatures; gains; chance.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.priors import ARCSEC, PRIORS, VARIANTS, Variant
from cbpt.lab.selection.linear_screen import Screen, Signature, Signatures, Stack
from cbpt.lab.selection.starts import places
from common.simulated import Floats, Values, drawn_numbers, hypothesis_of, plan, readings_of, truth

NOTHING: Values = {("output_torsion", "compliance_rad_per_Nm"): 0.0}


@cache
def glance() -> tuple[Fitter, Fit, tuple[Signature, ...], Screen]:
    """The whole library about a fit of readings in which nothing is missing."""
    campaign = readings_of(plan(), NOTHING, np.random.default_rng([31, 0]))
    fitter = Fitter(campaign, VARIANTS)
    fit = fitter.fit(Hypothesis())
    assert fit is not None
    signatures = Signatures(campaign, fitter.variants).about(fit, places(fitter))
    return fitter, fit, tuple(signatures), Screen(fit, Stack(signatures))


# --- signatures ---------------------------------------------------------------------------


def change(fit: Fit, campaign: Campaign, signature: Signature, sizes: Floats) -> Floats:
    """What sizes of one effect do at the values of a fit, by two predictions."""
    v = signature.variant
    numbers = [u.name for u in fit.unknowns]
    model = Assembled(campaign, [*numbers, v.effect])
    values = model.neutral.copy()
    for instance, unknown in enumerate(fit.unknowns):
        own = next(i for (owner, _), i in model.places.items() if owner == instance)
        values[own] = fit.value(unknown)
    # A number of the drive is its own effect, once more on top.
    for name, value in (*v.fixed, *signature.shapes.items()):
        values[model.index(len(numbers), name)] = value
    before = model.at(values).angle_arcsec
    for name, size in zip(v.sizes, sizes, strict=True):
        values[model.index(len(numbers), name)] += size
    return np.asarray(model.at(values).angle_arcsec - before)


def plain(variant: Variant) -> bool:
    return not variant.spread


LABELS = sorted({v.label for v in VARIANTS})


@pytest.mark.parametrize("label", LABELS)
def test_a_signature_is_the_difference_of_the_model(label: str) -> None:
    fitter, fit, signatures, _ = glance()
    for s in (s for s in signatures if s.variant.label == label):
        if s.secant:
            units = float(np.linalg.norm(s.secant)) / s.variant.low
            whole = change(fit, fitter.campaign, s, np.array(s.secant))
            np.testing.assert_allclose(s.columns[:, 0] * units, whole, rtol=1e-9, atol=1e-9)
            continue
        for j, column in enumerate(s.columns.T):
            step = np.zeros(len(s.unit))
            step[j] = 1e-3 * s.unit[j]
            up = change(fit, fitter.campaign, s, step)
            if s.variant.signed:
                expected = (up - change(fit, fitter.campaign, s, -step)) / 2e-3
            else:
                # No negative sizes: two steps forward, of second order.
                expected = (4 * up - change(fit, fitter.campaign, s, 2 * step)) / 2e-3
            largest = float(np.abs(column).max())
            np.testing.assert_allclose(column, expected, rtol=1e-4, atol=2e-4 * largest + 1e-9)


def test_every_effect_has_a_signature_that_the_readings_show() -> None:
    fitter, _, signatures, screen = glance()
    seen = {s.variant.effect for m, s in enumerate(signatures) if screen.usable[m]}
    assert seen == {v.effect for v in fitter.variants}


# --- gains --------------------------------------------------------------------------------

ALIKE = {"preload_loss", "preload_spring", "thermal_preload"}
"""Hardly told from the calibrations: no small effect unless these are exact."""

SMALL: list[tuple[str, str, dict[str, float]]] = [
    ("output_torsion", "", {"compliance_rad_per_Nm": 1.0}),
    ("bearing_play", "", {"clearance_m": 1.0}),
    ("preload_loss", "", {"lost_share": 1.0}),
    ("preload_spring", "", {"spring_rate_N_per_m": 1.0}),
    ("thermal_preload", "", {"rate_N_per_K": -1.0}),
    ("drift", "time", {"rate_rad_per_s": 1.0}),
    ("eccentricity_error", "fixed", {"offset_sine_m": 0.6, "offset_cosine_m": -0.8}),
    ("wear", "", {"lost_share_per_s": 1.0}),
    ("run_in", "permanent_set_of_run", {"permanent_set_of_run_rad": 1.0}),
    (
        "friction_hysteresis",
        "",
        {"friction_radius_m": 1.0, "engagement_angle_rad": 4.5 * ARCSEC},
    ),
]


@pytest.mark.parametrize(("effect", "name", "values"), SMALL, ids=[e for e, _, _ in SMALL])
def test_the_gain_of_a_small_effect_is_that_of_a_full_fit(
    effect: str, name: str, values: dict[str, float]
) -> None:
    """Planted at ten standard uncertainties of its size."""
    variant = hypothesis_of(effect, name).variants[0]
    # Shapes as planted in both, so that the sizes are all that is free.
    shapes = tuple((s.name, values[s.name]) for s in variant.shapes)
    bare = replace(variant, shapes=(), fixed=(*variant.fixed, *shapes), secants=())
    nothing = readings_of(plan(), NOTHING, np.random.default_rng([31, 1]))
    if effect in ALIKE:
        nothing = replace(nothing, priors=dict.fromkeys(PRIORS, 0.0))
    fitter = Fitter(nothing, [bare])
    null = fitter.fit(Hypothesis(), free_noise=False)
    assert null is not None
    signatures = Signatures(nothing, [bare]).about(null, places(fitter))
    (signature,) = (s for s in signatures if plain(s.variant))
    screen = Screen(null, Stack([signature]))
    unit = 10 / np.sqrt(screen.gram[0, 0])
    made = {
        (effect, p): (unit * signature.unit[0] * v if p in variant.sizes else v)
        for p, v in values.items()
    }
    # The readings without the effect, and the effect on top of them.
    effect_arcsec = truth(nothing, made) - truth(nothing, NOTHING)
    campaign = replace(nothing, y_arcsec=nothing.y_arcsec + effect_arcsec)
    fitter = Fitter(campaign, [bare])
    null = fitter.fit(Hypothesis(), free_noise=False)
    assert null is not None
    gain = Screen(null, Stack([signature])).single(0)
    start = fitter.start(
        Hypothesis((bare,)),
        {f"{effect}.{p}": x for p, x in zip(bare.sizes, signature.sizes(gain.sizes), strict=True)},
    )
    full = fitter.fit(Hypothesis((bare,)), start, Noise(), free_noise=False)
    assert full is not None
    assert gain.chi2 == pytest.approx(null.margin.chi2 - full.margin.chi2, rel=0.05)
    assert gain.log_odds == pytest.approx(full.log_evidence - null.log_evidence, rel=0.05)
    assert gain.chi2 > 40


def test_a_gain_needs_the_right_sign() -> None:
    _, _, signatures, screen = glance()
    m = next(m for m, s in enumerate(signatures) if s.variant.label == "output_torsion")
    place = screen.places[m]
    own = float(np.diag(screen.gram)[place][0])
    projection = 9 * np.sqrt(np.diag(screen.gram))
    gain, opposite = screen.single(m, projection), screen.single(m, -projection)
    assert gain.chi2 == pytest.approx(81, rel=1e-6) and gain.log_odds > 30
    assert gain.sizes[0] == pytest.approx(9 / np.sqrt(own))
    assert opposite.chi2 == 0 and np.isneginf(opposite.log_odds)
    signed = next(m for m, s in enumerate(signatures) if s.variant.label == "torque_scale")
    there, back = screen.single(signed, projection), screen.single(signed, -projection)
    assert there.log_odds == pytest.approx(back.log_odds) and there.chi2 == pytest.approx(81)


def test_twins_of_the_numbers_do_not_survive_the_refit() -> None:
    """Stiffness, torsion and play in how much of them a refit of the numbers leaves."""
    _, _, signatures, screen = glance()
    left = {
        s.variant.label: float(screen.surviving[screen.places[m].start])
        for m, s in enumerate(signatures)
        if plain(s.variant)
    }
    assert all(0 <= v <= 1 + 1e-9 for v in left.values())
    assert left["contact_stiffness"] < 0.1 < left["friction_hysteresis"]


# --- chance -------------------------------------------------------------------------------


def test_the_null_of_the_maximum_is_what_noise_does() -> None:
    """Readings of noise, of drives that are off as they are stated to be, one by one."""
    fitter, fit, signatures, _ = glance()
    # Every third is enough, and three times as fast.
    signatures, fit = signatures[::3], fitter.look(fit, Noise())
    screen = Screen(fit, Stack(signatures))
    weights = np.array([-0.1 * (m % 7) for m in range(len(signatures))])
    null = screen.null_of_maximum(weights, 400, np.random.default_rng([31, 3]))
    bar = np.quantile(null, 0.95)

    finite = [np.where(np.isfinite(s.columns), s.columns, 0.0) for s in signatures]
    left = fit.margin.left(fit.whitener(np.column_stack(finite)))
    _, x, precision = fitter.linear(fit)
    x = fit.whitener(x)
    known = precision > 0
    rng = np.random.default_rng([31, 4])
    usable = [m for m in range(len(signatures)) if screen.usable[m]]
    above = 0
    for _ in range(200):
        noise = rng.standard_normal(len(x))
        noise += x[:, known] @ (rng.standard_normal(known.sum()) / np.sqrt(precision[known]))
        # Each table tells its own scatter.
        noise /= np.sqrt(float(noise @ fit.margin.left(noise)) / len(noise))
        projection = left.T @ noise
        best = max(weights[m] + screen.single(m, projection).log_odds for m in usable)
        above += best > bar
    assert 4 <= above <= 18


def test_the_null_of_the_maximum_repeats_and_rises_with_the_weights() -> None:
    _, _, signatures, screen = glance()
    weights = np.zeros(len(signatures))

    def null(by: float) -> Floats:
        return screen.null_of_maximum(weights + by, 50, np.random.default_rng(1))

    np.testing.assert_array_equal(null(0.0), null(0.0))
    np.testing.assert_allclose(null(1.5), null(0.0) + 1.5, atol=1e-12)
    weights[:] = -np.inf
    assert np.isneginf(null(0.0)).all()


def test_whole_way_from_noise_to_the_chance() -> None:
    """The largest gain in readings of nothing lies inside what chance alone gives."""
    weights = np.zeros(len(glance()[2]))
    ranks = []
    for seed in range(6):
        rng = np.random.default_rng([31, 50 + seed])
        campaign = plan()
        campaign = readings_of(campaign, drawn_numbers(campaign, rng), rng)
        fitter = Fitter(campaign, VARIANTS)
        fit = fitter.fit(Hypothesis())
        assert fit is not None
        signatures = Signatures(campaign, fitter.variants).about(fit, places(fitter))
        screen = Screen(fit, Stack(signatures))
        best = max(screen.single(m).log_odds for m in range(len(signatures)) if screen.usable[m])
        null = screen.null_of_maximum(weights, 200, rng)
        ranks.append(float(np.mean(null < best)))
    assert np.count_nonzero(np.array(ranks) > 0.95) <= 2
    assert min(ranks) < 0.7
