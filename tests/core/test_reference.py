"""The reference model against the golden numbers, and against itself.

golden/forward.json was made by another hand: all of it is compared. golden/reference.json was
made by this model: a spread of its cases is made anew here (all of it takes minutes and is
`python -m reference.make_golden --check`, run from this folder), so that the file cannot drift
away from its generator.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.special import ellipe, ellipk

from reference import make_golden
from reference.contact import contact_shape
from reference.forward import (
    Conditions,
    CrossSlide,
    Deceleration,
    MeshingPair,
    RingGroove,
    TorqueNotHeldError,
    capacity,
    contact_stiffness_N_per_m1p5,
    limits,
    solve_pair,
)

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
FORWARD: dict[str, Any] = json.loads((GOLDEN / "forward.json").read_text())
REFERENCE: dict[str, Any] = json.loads((GOLDEN / "reference.json").read_text())
RTOL = 1e-9


def pair_of(case: dict[str, Any]) -> MeshingPair:
    """The pair of a case of forward.json."""
    p = case["parameters"]
    model: Deceleration | RingGroove | CrossSlide
    if case["pair"] == "deceleration":
        model = Deceleration(p["Z2"], p["K"], p["r0"], p["rd"], p["conf"], p["beta"])
    elif case["pair"] == "ring_groove":
        inside = p.get("beta_inside", p["beta"])
        model = RingGroove(p["Zd"], p["Rw"], p["ring_r"], p["rq"], p["conf"], p["beta"], inside)
    else:
        model = CrossSlide(p["ZS"], p["RS"], p["rs"], p["conf"], p["beta"])
    return model.at(p.get("phase", 0.0))


every_pair = pytest.mark.parametrize(
    "case", FORWARD["pairs"], ids=[f"{i}-{c['pair']}" for i, c in enumerate(FORWARD["pairs"])]
)


# --- golden/forward.json --------------------------------------------------------------------


@pytest.mark.parametrize("case", FORWARD["hertz"])
def test_contact_stiffness(case: dict[str, float]) -> None:
    """Exact Hertz stiffness of single contacts."""
    k = contact_stiffness_N_per_m1p5(case["c1"], case["c2"], case["e_star"])
    assert k == pytest.approx(case["k"], rel=1e-13)


@every_pair
def test_arms_and_stiffnesses(case: dict[str, Any]) -> None:
    """Arms within rounding of the largest one; stiffnesses each, a missing wall exactly 0."""
    pair = pair_of(case)
    np.testing.assert_allclose(pair.arm_m, case["arm"], rtol=0, atol=1e-14 * max(case["arm"]))
    np.testing.assert_allclose(pair.stiffness_plus_N_per_m1p5, case["k_plus"], rtol=1e-13)
    np.testing.assert_allclose(pair.stiffness_minus_N_per_m1p5, case["k_minus"], rtol=1e-13)


@every_pair
def test_equilibria(case: dict[str, Any]) -> None:
    """Rotation, approach and every force; what cannot be held is refused, and only that."""
    pair = pair_of(case)
    for load in case["solutions"]:
        if load["alpha"] is None:
            with pytest.raises(TorqueNotHeldError):
                solve_pair(pair, load["torque"], load["preload"])
            continue
        found = solve_pair(pair, load["torque"], load["preload"])
        assert found.alpha_rad == pytest.approx(load["alpha"], rel=RTOL)
        assert found.approach_m == pytest.approx(load["axial_approach"], rel=RTOL)
        np.testing.assert_allclose(found.force_plus_N, load["n_plus"], rtol=RTOL, atol=1e-12)
        np.testing.assert_allclose(found.force_minus_N, load["n_minus"], rtol=RTOL, atol=1e-12)


@every_pair
def test_threshold_preloads(case: dict[str, Any]) -> None:
    """The three thresholds, each bracketed from the state that defines it."""
    expected = case["preload_limits"]
    found = limits(pair_of(case), expected["torque"])
    assert found.hold_N == pytest.approx(expected["hold"], rel=RTOL)
    assert found.continuous_N == pytest.approx(expected["continuous"], rel=RTOL)
    assert found.zero_backlash_N == pytest.approx(expected["no_backlash"], rel=RTOL)


# --- golden/reference.json ------------------------------------------------------------------

SPREAD_OF_PAIRS = (
    "deceleration: 20 balls undercut epicycloid output",
    "ring_groove: 10 balls no inside wall unlike angles",
    "conditions: deceleration, gaps, exponent and spring",
    "conditions: ring groove, all gaps, no inside wall",
)
SPREAD_OF_DRIVES = (
    "base, ring grooves, epicycloid output, crank at 5.1 rad",
    "base, cross-slide, crank at 1.9 rad",
)


def stored(part: str, name: str) -> dict[str, Any]:
    """One case of reference.json."""
    (found,) = (case for case in REFERENCE[part] if case["id"] == name)
    return dict(found)


def test_file_holds_every_case() -> None:
    """No case added to the generator and not written, or the reverse; and as it writes them."""
    assert [case["id"] for case in REFERENCE["pairs"]] == list(make_golden.pair_jobs())
    assert [case["id"] for case in REFERENCE["drives"]] == list(make_golden.drive_jobs())
    assert make_golden.as_text(REFERENCE) == make_golden.GOLDEN.read_text()


def test_contacts_made_anew() -> None:
    """The generator still makes the stored contacts."""
    made = make_golden.contacts()
    assert make_golden.largest_difference(REFERENCE["contacts"], made) <= 1e-12


@pytest.mark.parametrize("name", SPREAD_OF_PAIRS)
def test_pairs_made_anew(name: str) -> None:
    """The generator still makes the stored pair."""
    made = make_golden.pair_jobs()[name]()
    assert make_golden.largest_difference(stored("pairs", name), made) <= RTOL


@pytest.mark.parametrize("name", SPREAD_OF_DRIVES)
def test_drives_made_anew(name: str) -> None:
    """The generator still makes the stored drive."""
    made = make_golden.drive_jobs()[name]()
    assert make_golden.largest_difference(stored("drives", name), made) <= RTOL


def test_stored_solutions_are_in_equilibrium() -> None:
    """Forces of every stored solution against its load, from the stored numbers alone."""
    for case in REFERENCE["pairs"]:
        arm = np.array(case["arm_m"])
        plus, minus = case["contact_angle_plus_rad"], case["contact_angle_minus_rad"]
        for load in case["solutions"]:
            if load["status"] == "refused":
                assert load["preload_N"] <= load["preload_that_holds_N"]
                continue
            n_plus, n_minus = np.array(load["force_plus_N"]), np.array(load["force_minus_N"])
            axial = n_plus.sum() * math.sin(plus) + n_minus.sum() * math.sin(minus)
            side = n_plus * math.cos(plus) - n_minus * math.cos(minus)
            scale = abs(arm).max() * axial
            assert axial == pytest.approx(load["preload_at_points_N"], rel=1e-12)
            assert side @ arm == pytest.approx(load["torque_Nm"], rel=1e-12, abs=1e-12 * scale)
            if case["axial_spring_N_per_m"] == 0:
                assert axial == pytest.approx(load["preload_N"], rel=1e-12)
            else:
                closed = load["approach_m"] - load["approach_unloaded_m"]
                left = load["preload_N"] - case["axial_spring_N_per_m"] * closed
                assert axial == pytest.approx(left, rel=1e-9)
            if case["pair"] == "cross_slide":
                assert abs(side.sum()) <= 1e-12 * axial


# --- identities -----------------------------------------------------------------------------


def test_contact_shape_solves_the_legendre_form() -> None:
    """The ratio of curvatures in K and E themselves, where their differences are not small."""
    for large in (3.0, 40.0, 900.0):
        ratio, big_k, big_d = contact_shape(1.0, large)
        m = 1 - ratio**2
        assert big_k == pytest.approx(ellipk(m), rel=1e-13)
        assert big_d == pytest.approx((ellipk(m) - ellipe(m)) / m, rel=1e-13)
        curvatures = (ellipe(m) / ratio**2 - ellipk(m)) / (ellipk(m) - ellipe(m))
        assert curvatures == pytest.approx(large, rel=1e-12)


def test_outputs_are_the_same_pair_seen_from_either_plate() -> None:
    """With the other plate as output torque and rotation scale with Z1/Z3 and Z3/Z1, reversed."""
    hypo = Deceleration(11, 0.45, 5e-3, 1.5e-3, 1.08, 0.75)
    epi = Deceleration(11, 0.45, 5e-3, 1.5e-3, 1.08, 0.75, output="epicycloid")
    one = solve_pair(hypo.at(0.2), 3.0, 500.0)
    other = solve_pair(epi.at(0.2), -3.0 * 10 / 12, 500.0)
    assert other.alpha_rad == pytest.approx(-one.alpha_rad * 12 / 10, rel=1e-12)
    np.testing.assert_allclose(other.force_minus_N, one.force_plus_N, rtol=1e-12)


def test_spring_and_gaps_of_nothing_change_nothing() -> None:
    """Zero gaps and a spring of 1 N/m leave the state where it was."""
    pair = Deceleration(7, 0.4, 6e-3, 1.5e-3, 1.08, 0.8).at(0.1)
    zero = np.zeros(7)
    plain = solve_pair(pair, 2.0, 400.0)
    gaps = solve_pair(pair, 2.0, 400.0, Conditions(zero, zero, zero))
    soft = solve_pair(pair, 2.0, 400.0, Conditions(spring_N_per_m=1.0))
    assert gaps.alpha_rad == plain.alpha_rad
    assert soft.alpha_rad == pytest.approx(plain.alpha_rad, rel=1e-8)


def held_by_linear_programme(pair: MeshingPair, sign: int) -> float:
    """Largest torque per newton of preload (m) over all non-negative forces in balance."""
    existing = np.concatenate([pair.stiffness_plus_N_per_m1p5, pair.stiffness_minus_N_per_m1p5]) > 0
    count = len(pair.arm_m)
    angle = np.repeat([pair.contact_angle_plus_rad, pair.contact_angle_minus_rad], count)
    side: NDArray[np.float64] = np.repeat([1.0, -1.0], count) * np.cos(angle)
    lever = sign * side * np.tile(pair.arm_m, 2)
    rows, values = [np.sin(angle)[existing]], [1.0]
    if pair.floating:
        rows, values = [*rows, side[existing]], [1.0, 0.0]
    unit = abs(lever).max()
    found = linprog(-lever[existing] / unit, A_eq=np.array(rows), b_eq=values, method="highs")
    assert found.fun is not None
    return -float(found.fun) * float(unit)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    "model",
    [
        make_golden.BASE,
        *(model for model, _ in make_golden.RINGS.values()),
        *make_golden.SLIDES.values(),
    ],
    ids=lambda m: f"{type(m).__name__}-{m.ball_count}",
)
def test_hold_limit_against_a_linear_programme(
    model: Deceleration | RingGroove | CrossSlide, sign: int
) -> None:
    """The edge of the cone of forces is the optimum of the programme (solver tolerance 1e-7)."""
    pair = model.at(0.07)
    assert capacity(pair, sign) == pytest.approx(held_by_linear_programme(pair, sign), rel=1e-7)
