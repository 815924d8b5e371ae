"""Fits to readings whose truth is known: values, uncertainties, evidence, bounds.

Groups: values come back; uncertainties cover; evidence; bounds; starts; what was asked before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cbpt
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.diagnosis.fit_text import beyond_likely
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter, Race
from cbpt.lab.inference.gauss_newton import Problem, point_at, search
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.priors import ARCSEC, PRIORS, VARIANTS, joints, soft_plays
from cbpt.lab.selection.fit_effects import best_fit
from common.drives import examples
from common.simulated import (
    NUMBERS,
    Floats,
    Values,
    drawn_numbers,
    hypothesis_of,
    plan,
    readings_of,
    truth,
    variant_of,
)

EXACT = dict.fromkeys(PRIORS, 0.0)
"""A drive and a rig whose numbers are exactly as stated."""


def fits(
    values: Values, effect: str, name: str = "", seed: int = 1, start: Floats | None = None
) -> tuple[Fitter, Fit]:
    """Readings with one effect, fitted with the form that made them."""
    campaign = readings_of(plan("dev03"), values, np.random.default_rng([17, seed]))
    fitter = Fitter(campaign, [variant_of(effect, name)])
    found = fitter.fit(hypothesis_of(effect, name), start)
    assert found is not None
    return fitter, found


def of(found: Fit, name: str) -> tuple[float, float]:
    """Value and standard uncertainty of an unknown by `effect.parameter`."""
    unknown = next(u for u in found.unknowns if u.name == name)
    return found.value(unknown), found.u(unknown)


# --- values come back ---------------------------------------------------------------------

PLANTED: list[tuple[str, str, dict[str, float]]] = [
    ("contact_stiffness", "", {"stiffness_scale": 1.15}),
    ("torque_scale", "", {"torque_gain": 1.08}),
    ("preload_scale", "", {"preload_gain": 0.92}),
    ("contact_angle", "", {"contact_angle_shift_rad": -0.05}),
    ("shaft_shift", "", {"shift_rad_per_Nm": -1e-6}),
    ("sensor_gain", "", {"sensor_gain": 0.8}),
    ("sensor_nonlinearity", "", {"quadratic_per_rad": 40.0, "cubic_per_rad2": 1e5}),
    (
        "sensor_nonlinearity",
        "flattening",
        {"flattening_rad": -20 * ARCSEC, "knee_rad": 30 * ARCSEC},
    ),
    ("drift", "time", {"rate_rad_per_s": 2e-9}),
    ("drift", "temperature", {"rate_rad_per_K": 5e-7}),
    ("eccentric_bearing", "", {"reference_deflection_m": 1e-6, "exponent": 0.75}),
    ("bearing_play", "", {"clearance_m": 4e-7}),
    ("output_torsion", "", {"compliance_rad_per_Nm": 1e-6}),
    ("output_torsion", "softer one way", {"compliance_rad_per_Nm": 1e-6, "asymmetry": -0.5}),
    (
        "friction_hysteresis",
        "",
        {"friction_radius_m": 6e-4, "engagement_angle_rad": 5 * ARCSEC},
    ),
    ("preload_loss", "", {"lost_share": 0.15}),
    ("preload_loss", "force", {"lost_force_N": 60.0}),
    ("preload_loss", "share and force", {"lost_share": 0.1, "lost_force_N": 60.0}),
    ("preload_spring", "", {"spring_rate_N_per_m": 3e8}),
    ("thermal_preload", "", {"rate_N_per_K": -12.0}),
    ("thermal_preload", "lagging temperature", {"rate_N_per_K": 40.0, "time_constant_s": 400.0}),
    ("eccentricity_error", "fixed", {"offset_sine_m": 2e-7, "offset_cosine_m": -3e-7}),
    ("groove_pitch_error", "fixed groove, harmonic 4", {"cosine_m": 6e-7, "sine_m": -5e-7}),
    ("plate_tilt", "in the housing", {"housing_tilt_cosine_rad": 8e-5, "housing_tilt_sine_rad": 0}),
    *(
        (
            "plate_tilt",
            form.replace("_", " "),
            {f"{form}_tilt_cosine_rad": 8e-5, f"{form}_tilt_sine_rad": -6e-5},
        )
        for form in ("fixed_plate", "output_plate")
    ),
    ("rough_contact", "", {"exponent": 1.7}),
    ("run_in", "permanent_set", {"permanent_set_rad": 3 * ARCSEC}),
    ("run_in", "settled", {"settled_rad": -3 * ARCSEC, "settling_cycles": 2.0}),
    ("wear", "", {"lost_share_per_s": 5e-5}),
    ("creep", "", {"compliance_rad_per_Nm": 6e-7, "time_constant_s": 12.0}),
    (
        "creep",
        "superposed",
        {"superposed_compliance_rad_per_Nm": 6e-7, "time_constant_s": 12.0},
    ),
]


@pytest.mark.parametrize(
    ("effect", "name", "values"), PLANTED, ids=[f"{e}-{n}" for e, n, _ in PLANTED]
)
def test_planted_values_come_back(effect: str, name: str, values: dict[str, float]) -> None:
    variant = variant_of(effect, name)
    made = {(effect, p): v for p, v in (*variant.fixed, *values.items())}
    campaign = readings_of(plan("dev03"), made, np.random.default_rng([17, 1]))
    found = best_fit(Fitter(campaign, [variant]), [variant.label])
    assert found.hypothesis.effects == (effect,)
    for parameter, true in values.items():
        value, u = of(found, f"{effect}.{parameter}")
        assert abs(value - true) <= 4 * u
    # The readings tell the size: an uncertainty as large as the world would prove nothing.
    neutral = [found_neutral(effect, p) for p in variant.sizes]
    off = np.hypot.reduce([values[p] - n for p, n in zip(variant.sizes, neutral, strict=True)])
    assert of(found, f"{effect}.{variant.sizes[0]}")[1] < 0.5 * off


def found_neutral(effect: str, parameter: str) -> float:
    return Fitter(plan("dev03"), [v for v in VARIANTS if v.effect == effect]).neutral(
        effect, parameter
    )


def test_numbers_of_the_drive_move_where_they_are_off() -> None:
    """Known to 10 % and 2 %; the readings know the stiffness better."""
    made = {("contact_stiffness", "stiffness_scale"): 1.12}
    campaign = readings_of(plan("dev03"), made, np.random.default_rng([17, 2]))
    found = Fitter(campaign, []).fit(Hypothesis())
    assert found is not None and found.converged
    value, u = of(found, "contact_stiffness")
    assert abs(value - 1.12) < 4 * u < 0.2
    # What only the calibrations know, the readings leave where it is stated.
    gain, u_gain = of(found, "sensor_gain")
    assert abs(gain - 1) < 3 * 0.005 and u_gain == pytest.approx(0.005, rel=0.05)


def test_zeros_are_free() -> None:
    campaign = readings_of(plan("dev03"), {("run_in", "settled_rad"): 0.0}, None)
    shifted = replace(campaign, y_arcsec=campaign.y_arcsec + 7.25)
    found = Fitter(shifted, []).fit(Hypothesis(), free_noise=False)
    assert found is not None
    assert found.offsets_arcsec == pytest.approx([7.25], abs=1e-6)
    assert np.abs(found.residual_arcsec).max() < 1e-5


# --- uncertainties cover ------------------------------------------------------------------


def test_uncertainties_cover() -> None:
    """Drives and rigs whose numbers are off as they are stated to be, 40 of them."""
    true, z = 4e-7, []
    for seed in range(40):
        rng = np.random.default_rng([29, seed])
        made = {("output_torsion", "compliance_rad_per_Nm"): true}
        campaign = plan("dev03")
        campaign = readings_of(campaign, made | drawn_numbers(campaign, rng), rng)
        fitter = Fitter(campaign, [variant_of("output_torsion")])
        found = fitter.fit(hypothesis_of("output_torsion"))
        assert found is not None
        value, u = of(found, "output_torsion.compliance_rad_per_Nm")
        z.append((value - true) / u)
    assert 34 <= np.count_nonzero(np.abs(z) < 1.96) <= 40
    assert 0.75 < np.std(z) < 1.3
    assert abs(np.mean(z)) < 0.5


# --- evidence -----------------------------------------------------------------------------


@pytest.mark.parametrize("sigmas", [4.0, 8.0, 20.0])
def test_laplace_evidence_is_the_integral_over_the_prior(sigmas: float) -> None:
    """A linear effect of one number, equally likely in the logarithm; the zero is flat in both."""
    base = replace(plan("dev03"), priors=EXACT)
    variant = variant_of("output_torsion")
    plain = truth(base, {("output_torsion", "compliance_rad_per_Nm"): 0.0})
    unit = truth(base, {("output_torsion", "compliance_rad_per_Nm"): 1e-6}) - plain
    unit -= unit.mean()
    # Readings so loose that a standard uncertainty is half of the smallest plausible size or more.
    own = variant.low if sigmas < 20 else 0.5 * variant.low
    loose = own / 1e-6 * float(np.linalg.norm(unit))
    base = replace(base, u_arcsec=np.full(len(base), loose))
    made = {("output_torsion", "compliance_rad_per_Nm"): sigmas * own}
    # Without noise the estimate is just what was planted.
    campaign = readings_of(base, made, None)
    fitter = Fitter(campaign, [variant])
    null = fitter.fit(Hypothesis(), free_noise=False)
    found = fitter.fit(hypothesis_of("output_torsion"), free_noise=False)
    assert null is not None and found is not None
    value, u = of(found, "output_torsion.compliance_rad_per_Nm")
    assert value == pytest.approx(sigmas * own, rel=1e-3) and u == pytest.approx(own, rel=1e-6)

    log_size = np.linspace(np.log(variant.low), np.log(variant.high), 200_001)
    y = campaign.y_arcsec - plain
    y = y - y.mean()
    size = np.exp(log_size) / 1e-6
    gain = (2 * size * float(unit @ y) - size**2 * float(unit @ unit)) / loose**2
    likelihood = np.exp(0.5 * (gain - gain.max()))
    integral = float(np.trapezoid(likelihood, log_size)) / np.log(variant.high / variant.low)
    exact = np.log(integral) + 0.5 * gain.max()
    assert found.log_evidence - null.log_evidence == pytest.approx(exact, abs=0.15)


def test_evidence_prefers_the_effect_that_made_the_readings() -> None:
    made = {("friction_hysteresis", "friction_radius_m"): 5e-4}
    made[("friction_hysteresis", "engagement_angle_rad")] = 5 * ARCSEC
    campaign = readings_of(plan("dev03"), made, np.random.default_rng([17, 3]))
    fitter = Fitter(campaign, VARIANTS)
    values = {n: best_fit(fitter, [n]) for n in ("friction_hysteresis", "preload_loss", "drift")}
    null = fitter.fit(Hypothesis())
    assert null is not None
    gains = {n: f.log_evidence - null.log_evidence for n, f in values.items()}
    assert max(gains, key=lambda n: gains[n]) == "friction_hysteresis"
    assert gains["friction_hysteresis"] > 20 + max(gains["preload_loss"], gains["drift"])


def test_an_effect_that_is_not_there_loses_evidence() -> None:
    campaign = readings_of(plan("dev03"), {("output_torsion", "compliance_rad_per_Nm"): 0.0}, None)
    fitter = Fitter(campaign, [variant_of("output_torsion")])
    null = fitter.fit(Hypothesis(), free_noise=False)
    found = fitter.fit(hypothesis_of("output_torsion"), free_noise=False)
    assert null is not None and found is not None
    assert -8 < found.log_evidence - null.log_evidence < 0


# --- bounds -------------------------------------------------------------------------------

ONE_SIDED = ["output_torsion", "eccentric_bearing", "bearing_play", "preload_loss", "creep"]
"""Sizes that are never negative."""


@pytest.mark.parametrize("effect", ONE_SIDED)
def test_a_size_is_never_negative(effect: str) -> None:
    """The opposite of the effect in the readings leaves none of it."""
    values = next(v for e, _, v in PLANTED if e == effect)
    base = replace(plan("dev03"), priors=EXACT)
    made = truth(base, {(effect, p): v for p, v in values.items()})
    plain = truth(base, {(effect, next(iter(values))): 0.0})
    fitter = Fitter(replace(base, y_arcsec=2 * plain - made), [variant_of(effect)])
    start = fitter.start(hypothesis_of(effect), {f"{effect}.{p}": v for p, v in values.items()})
    found = fitter.fit(hypothesis_of(effect), start)
    assert found is not None
    assert of(found, f"{effect}.{next(iter(values))}")[0] == 0.0
    assert np.isfinite(found.log_evidence)


def test_a_calibration_moves_as_far_as_its_stated_uncertainty_allows() -> None:
    """A torque known to 20 % alone may be 45 % off, though 30 % is the most that is plausible where
    nothing is stated: held there, it made another number of the drive move instead."""
    base = replace(plan("dev03"), priors=EXACT | {"torque_scale": 0.2})
    rng = np.random.default_rng(3)
    far = readings_of(base, {("torque_scale", "torque_gain"): 0.55}, rng)
    found = Fitter(far, []).fit(Hypothesis())
    assert found is not None
    value, u = of(found, "torque_scale")
    assert abs(value - 0.55) < 2 * u < 0.01


@given(
    st.sampled_from([v for v in VARIANTS if v.effect != "plate_tilt"]),
    st.sampled_from([-3.0, -0.3, 0.3, 3.0]),
    st.integers(0, 10**6),
)
@examples(12)
def test_values_stay_within_their_bounds(variant: object, strength: float, seed: int) -> None:
    """Whatever the readings ask for."""
    chosen = next(v for v in VARIANTS if v is variant)
    rng = np.random.default_rng(seed)
    base = plan("dev03")
    plain = truth(base, {("output_torsion", "compliance_rad_per_Nm"): 0.0})
    wild = rng.standard_normal(3) * strength
    loads = base.readings.torque_Nm / 8
    angle = np.deg2rad(base.readings.input_angle_deg)
    y = plain * (1 + 0.2 * wild[0]) + wild[1] * loads**3 + wild[2] * np.sin(angle) * loads
    fitter = Fitter(replace(base, y_arcsec=y), [chosen])
    found = fitter.fit(Hypothesis((chosen,)))
    if found is None:
        return
    for unknown in found.unknowns:
        assert unknown.lower - 1e-12 <= found.value(unknown) <= unknown.upper * (1 + 1e-12)
    assert np.isfinite(found.point.angle_arcsec).all()


def test_a_size_may_be_larger_than_is_likely() -> None:
    """The search once ended at the largest likely friction, and other effects took the rest."""
    far = {
        ("friction_hysteresis", "friction_radius_m"): 8e-3,
        ("friction_hysteresis", "engagement_angle_rad"): 20 * ARCSEC,
    }
    campaign = readings_of(plan("dev03"), far, np.random.default_rng([18, 1]))
    fitter = Fitter(campaign, [variant_of("friction_hysteresis")])
    found = fitter.fit(hypothesis_of("friction_hysteresis"))
    assert found is not None
    value, u = of(found, "friction_hysteresis.friction_radius_m")
    assert abs(value - 8e-3) < 4 * u < 1e-3
    (told,) = beyond_likely(found)
    assert told.startswith("friction_hysteresis: friction_radius_um ")
    assert "is more than is likely (5000 at most)" in told


# --- starts -------------------------------------------------------------------------------

STARTS = [
    ("output_torsion", [{"compliance_rad_per_Nm": c} for c in (0.0, 1e-7, 3e-5)]),
    (
        "eccentric_bearing",
        [
            {"reference_deflection_m": 1e-7, "exponent": 0.95},
            {"reference_deflection_m": 8e-6, "exponent": 0.62},
        ],
    ),
    (
        "friction_hysteresis",
        [
            {"friction_radius_m": 5e-5, "engagement_angle_rad": 20 * ARCSEC},
            {"friction_radius_m": 2e-3, "engagement_angle_rad": 2 * ARCSEC},
        ],
    ),
    ("preload_loss", [{"lost_share": s} for s in (0.0, 0.2)]),
    ("rough_contact", [{"exponent": e} for e in (1.35, 2.3)]),
]


@pytest.mark.parametrize(("effect", "starts"), STARTS, ids=[e for e, _ in STARTS])
def test_a_bad_start_ends_at_the_same_values(effect: str, starts: list[dict[str, float]]) -> None:
    values = next(v for e, _, v in PLANTED if e == effect)
    campaign = readings_of(
        plan("dev03"),
        {(effect, p): v for p, v in values.items()},
        np.random.default_rng([17, 4]),
    )
    fitter = Fitter(campaign, [variant_of(effect)])
    hypothesis = hypothesis_of(effect)

    def reached(given_values: dict[str, float]) -> Fit:
        start = fitter.start(hypothesis, {f"{effect}.{p}": v for p, v in given_values.items()})
        found = fitter.fit(hypothesis, start, Noise(), free_noise=False)
        assert found is not None
        return found

    best = reached(values)
    for given_values in starts:
        other = reached(given_values)
        assert other.converged
        for unknown in best.unknowns:
            near = 0.3 * best.u(unknown)
            assert other.value(unknown) == pytest.approx(best.value(unknown), abs=near)


def test_the_numbers_are_those_of_the_library() -> None:
    """The names that this file plants numbers by."""
    assert set(NUMBERS) == set(PRIORS)
    assert {e for e, _, _ in PLANTED} >= {v.effect for v in VARIANTS} - {"ball_diameter_lot"}


def test_contact_angles_stay_angles() -> None:
    """Fits used to end in an error where the shift reached 45 degrees."""
    fitter = Fitter(plan("dev03"), [variant_of("contact_angle")])
    place = fitter.place("contact_angle", "contact_angle_shift_rad")
    low, high = fitter.model.lower[place], fitter.model.upper[place]
    for shift in (low, high):
        values = fitter.model.neutral.copy()
        values[place] = shift
        fitter.model.at(values)
    assert low < -0.1 and high > 0.1


# --- what was asked before ------------------------------------------------------------------


@pytest.mark.parametrize("name", ["dev01", "dev04"])
def test_a_cold_model_says_to_the_last_bit_what_a_new_one_would(name: str) -> None:
    campaign = plan(name)
    effects = ["contact_stiffness", "plate_tilt", "friction_hysteresis"]
    model = Assembled(campaign, effects)
    values, other = model.neutral.copy(), model.neutral.copy()
    values[model.index(1, "tilt_cosine_rad")] = 3e-5
    other[model.index(0, "stiffness_scale")] = 1.3
    other[model.index(2, "friction_radius_m")] = 6e-4
    wanted = [model.index(0, "stiffness_scale"), model.index(1, "tilt_sine_rad")]
    first = Assembled(campaign, effects).at(values, wanted)
    model.at(other)
    model.cold()
    again = model.at(values, wanted)
    np.testing.assert_array_equal(again.angle_arcsec, first.angle_arcsec)
    np.testing.assert_array_equal(again.slopes, first.slopes)


def test_of_a_form_that_a_hypothesis_does_not_have_no_number_is_at_work() -> None:
    """Values to begin with may be those of a fit that had the effect in another form."""
    values: Values = {("drift", "rate_rad_per_s"): 2e-9}
    campaign = readings_of(plan("dev03"), values, np.random.default_rng([17, 1]))
    fitter = Fitter(campaign)
    hypothesis = hypothesis_of("drift", "time")
    start = fitter.start(hypothesis, {})
    clean = fitter.fit(hypothesis, start)
    start[fitter.place("drift", "rate_rad_per_K")] = 1e-4
    found = fitter.fit(hypothesis, start)
    assert clean is not None and found is not None
    np.testing.assert_array_equal(found.point.values, clean.point.values)
    assert found.log_evidence == clean.log_evidence


def test_a_fit_does_not_depend_on_what_was_fitted_before() -> None:
    """The log evidence of the preload spring was 168.0 alone and 119.6 after another effect."""
    case = cbpt.Case.from_file("examples/campaign.toml")
    campaign = campaign_of(case, cbpt.read_readings("examples/campaign.csv"), ())
    noise = Noise()

    def evidence(*effects: str) -> list[Fit]:
        fitter = Fitter(campaign)
        found = []
        for effect in effects:
            variant = next(v for v in fitter.variants if v.effect == effect)
            found.append(fitter.fit(Hypothesis((variant,)), noise=noise))
        return [fit for fit in found if fit is not None]

    (alone,) = evidence("preload_spring")
    after = evidence("eccentric_bearing", "plate_tilt", "preload_spring")[-1]
    assert alone.log_evidence == after.log_evidence
    np.testing.assert_array_equal(alone.point.values, after.point.values)
    np.testing.assert_array_equal(alone.covariance, after.covariance)


def test_a_bound_ends_a_search_that_cannot_come_below_it() -> None:
    campaign = readings_of(
        plan("dev03"),
        {("eccentric_bearing", "reference_deflection_m"): 1e-6},
        np.random.default_rng(2),
    )
    fitter = Fitter(campaign, [variant_of("preload_spring"), variant_of("eccentric_bearing")])
    free = fitter.fit(hypothesis_of("preload_spring"))
    bounded = fitter.fit(hypothesis_of("preload_spring"), bound=1.0)
    assert free is not None and bounded is not None
    assert free.converged and not bounded.converged
    assert bounded.reached > 1.0
    # A bound that is not met changes nothing.
    loose = fitter.fit(hypothesis_of("preload_spring"), bound=2 * free.reached)
    assert loose is not None and loose.log_evidence == free.log_evidence
    # In a race the bound follows from the best fit so far.
    race = Race(fitter, Noise())
    start = fitter.start(hypothesis_of("preload_spring"), {})
    first = race.fit(hypothesis_of("preload_spring"), start)
    race.fit(hypothesis_of("eccentric_bearing"), start)
    later = race.fit(hypothesis_of("preload_spring"), start)
    assert first is not None and first.converged
    assert later is not None and not later.converged


def test_other_angles_share_the_model_and_change_the_fit() -> None:
    campaign = plan("dev03")
    fitter = Fitter(campaign, [])
    other = fitter.with_angles(campaign.y_arcsec + 0.5)
    first, second = (f.fit(Hypothesis(), free_noise=False) for f in (fitter, other))
    assert first is not None and second is not None
    assert second.offsets_arcsec[0] == pytest.approx(first.offsets_arcsec[0] + 0.5, abs=1e-9)
    assert fitter.campaign is campaign and other.model is fitter.model


# --- forms --------------------------------------------------------------------------------


@pytest.mark.parametrize("step_s", [0.0, 30.0, 1e4])
def test_no_form_is_quicker_than_the_readings_follow_each_other(step_s: float) -> None:
    campaign = plan("dev04")
    time = step_s * np.arange(len(campaign), dtype=np.float64)
    readings = replace(campaign.readings, time_s=time)
    fitter = Fitter(replace(campaign, readings=readings))
    # A power of time has no time constant, so it is as quick as any readings.
    creep = [v for v in fitter.variants if v.effect == "creep" and "power" not in v.name]
    assert bool(creep) == (step_s < 1e4)
    for shape in (s for v in creep for s in v.shapes):
        assert step_s <= shape.low <= min(shape.grid) and max(shape.grid) <= shape.high


@pytest.mark.parametrize("torque_Nm", [0.2, 5.0, 300.0])
def test_a_joint_gives_5_to_22_percent_less_at_the_largest_torque(torque_Nm: float) -> None:
    joint, *_ = joints(torque_Nm)
    (shape,) = joint.shapes
    less = [1 - np.log1p(h * torque_Nm) / (h * torque_Nm) for h in (shape.low, shape.high)]
    assert less == pytest.approx([0.047, 0.217], abs=0.001)


@pytest.mark.parametrize("torque_Nm", [0.2, 5.0, 300.0])
def test_a_soft_play_is_all_but_taken_up_at_the_largest_torque(torque_Nm: float) -> None:
    (play,) = soft_plays(torque_Nm)
    (shape,) = play.shapes
    left = [1 - torque_Nm / np.hypot(torque_Nm, within) for within in (shape.low, shape.high)]
    assert left == pytest.approx([1.2e-5, 0.011], rel=0.05)
    assert shape.low < min(shape.grid) and max(shape.grid) < shape.high


# --- shorter steps ------------------------------------------------------------------------


def test_a_short_step_goes_less_far_and_promises_less() -> None:
    campaign = readings_of(plan("dev03"), {}, np.random.default_rng([17, 1]))
    fitter = Fitter(campaign)
    unknowns = fitter.unknowns(hypothesis_of("eccentric_bearing"))
    problem = Problem(campaign, fitter.model, unknowns, campaign.plain_noise)
    point = point_at(fitter.model, fitter.start(hypothesis_of("eccentric_bearing"), {}), unknowns)
    assert point is not None
    scale = problem.seen(point)
    whole = float(np.linalg.norm(scale * problem.step(point)[0]))
    radii = [np.inf, 0.5 * whole, 0.01 * whole]
    taken = [problem.step(point, radius, scale) for radius in radii]
    lengths = [float(np.linalg.norm(scale * step)) for step, _ in taken]
    assert lengths == pytest.approx([whole, *radii[1:]], rel=0.02)
    assert taken[0][1] > taken[1][1] > taken[2][1] > 0


@given(st.integers(0, 10**6))
@examples(25)
def test_no_step_goes_uphill(seed: int) -> None:
    """Whatever the readings, where several numbers are held at their bounds: numbers that would go
    beyond once were all held there at once, what that promised was a loss, and the search ended."""
    rng = np.random.default_rng(seed)
    names = "friction_hysteresis", "preload_loss:share and force"
    hypothesis = Hypothesis(tuple(v for v in VARIANTS if v.label in names))
    base = plan("dev03")
    load = base.readings.torque_Nm / np.abs(base.readings.torque_Nm).max()
    wild = 30 * rng.standard_normal(3)
    y = base.y_arcsec + wild[0] * load + wild[1] * load**2 + wild[2] * base.readings.direction()
    campaign = replace(base, y_arcsec=y)
    fitter = Fitter(campaign)
    unknowns = fitter.unknowns(hypothesis)
    values = fitter.start(hypothesis, {})
    for u in unknowns[len(campaign.priors) :]:
        values[u.index] = u.lower + 0.3 * rng.random() * (u.upper - u.lower)
    point = point_at(fitter.model, values, unknowns)
    if point is None:
        return
    problem = Problem(campaign, fitter.model, unknowns, Noise())
    for radius in (np.inf, 3.0):
        step, promised = problem.step(point, radius, problem.seen(point))
        assert promised >= -1e-9 * problem.objective(point)
        at = problem.coordinates(point) + step * problem.unit
        assert (at >= problem.low - 1e-12).all() and (at <= problem.high + 1e-12).all()


def test_a_lot_of_balls_is_found_from_equal_balls_though_some_lose_touch() -> None:
    campaign = plan("dev10")
    fitter = Fitter(campaign)
    lot = max((v for v in fitter.variants if v.spread), key=lambda v: v.spread)
    hypothesis = Hypothesis((lot,))
    unknowns = fitter.unknowns(hypothesis)
    noise = Noise(scale=7.6, correlation=0.9)
    problem = Problem(campaign, fitter.model, unknowns, noise)
    start = point_at(fitter.model, fitter.start(hypothesis, {}), unknowns)
    assert start is not None
    short, _ = search(problem, start, 12)
    # A step to where balls carry nothing is a step too far: one that is cut to a third until it
    # gains has come to 289.5 after twice as many predictions.
    assert problem.objective(short) < 278
    long, _ = search(problem, short, 100)
    assert problem.objective(long) == pytest.approx(problem.objective(short), abs=0.5)
