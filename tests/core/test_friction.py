"""Friction: an independent minimisation, and laws of mechanics.

Groups: values from outside, the reference model, properties of random drives, trends of the base
case.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cbpt
from cbpt import Drive
from common import mostly_long
from common.drives import CRANK_DEG, PRELOAD_N, SHARE, base_case, drives, examples, torque_of
from reference.contact import Material
from reference.friction import deceleration_loss_Nm, plate_turns, ring_loss_Nm, slide_loss_Nm
from reference.pairs import CrossSlide, Deceleration, RingGroove

BASE = Drive.from_toml(cbpt.example_case())


def of_angle(drive: Drive, *load: float, coefficient: float = 0.1) -> cbpt.Friction:
    found = drive.friction(load[0], load[1], load[2], coefficient=coefficient)
    assert found.has_solution, found.status
    return found


def parts(found: cbpt.Friction) -> tuple[float, float]:
    assert found.deceleration is not None and found.equal_speed is not None
    return found.deceleration.torque_Nm, found.equal_speed.torque_Nm


def total(found: cbpt.Friction) -> float:
    assert found.friction_torque_Nm is not None
    return found.friction_torque_Nm


# --- values from outside --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("torque", "preload", "deceleration", "ring"),
    [(0, 600, 0.0680, 0.0179), (5, 600, 0.0684, 0.0183), (0, 300, 0.0305, 0.0071)],
)
def test_values_of_an_independent_minimisation(
    torque: float, preload: float, deceleration: float, ring: float
) -> None:
    """Origin: an independent minimisation by another hand, to about 0.5 %, in four decimals."""
    found = parts(of_angle(BASE, torque, preload, 0.0))
    assert found == pytest.approx((deceleration, ring), rel=5e-3, abs=5e-5)


def test_efficiency_of_the_base_case() -> None:
    found = of_angle(BASE, 5, 600, 0)
    assert found.efficiency == pytest.approx(0.846, abs=5e-4)
    assert found.input_torque_Nm == pytest.approx(5 / 10.5 + total(found), rel=1e-14)


# --- the reference model --------------------------------------------------------------------

CASES: list[tuple[dict[str, Any], dict[str, Any], tuple[float, float, float]]] = [
    ({}, {}, (5, 600, 0)),
    ({}, {}, (0, 600, 33)),
    ({"output_plate": "epicycloid"}, {}, (-4, 500, 10)),
    ({"contact_angle_deg": 30, "ball_count": 12}, {"inside_contact_angle_deg": 60}, (3, 400, 100)),
    ({"contact_angle_deg": 60}, {"kind": "cross_slide", "ball_count": 15}, (6, 900, 25)),
    ({}, {"kind": "cross_slide", "ball_count": 16}, (5, 160, 200)),
]


@pytest.mark.parametrize(("first", "second", "load"), mostly_long(CASES, CASES[2:4]))
def test_three_unknowns_minimised_by_scipy_give_the_same(
    first: dict[str, Any], second: dict[str, Any], load: tuple[float, float, float]
) -> None:
    case = base_case()
    case["deceleration"] |= first
    case["equal_speed"] |= second
    if "inside_contact_angle_deg" in second:
        case["equal_speed"]["outside_contact_angle_deg"] = 40
        del case["equal_speed"]["contact_angle_deg"]
    expected = reference_losses(case, *load)
    found = parts(of_angle(Drive.from_dict(case), *load, coefficient=1.0))
    assert found == pytest.approx(expected, rel=1e-5)
    # The product has the minimum itself, the reference comes near it from above.
    for mine, theirs in zip(found, expected, strict=True):
        assert mine <= theirs * (1 + 1e-9)


def reference_losses(
    case: dict[str, Any], torque: float, preload: float, angle_deg: float
) -> tuple[float, float]:
    one, two, theta = case["deceleration"], case["equal_speed"], math.radians(angle_deg)
    output = one.get("output_plate", "hypocycloid")
    pair = Deceleration(
        one["ball_count"],
        one["short_amplitude_coefficient"],
        one["rolling_circle_radius_mm"] * 1e-3,
        one["ball_radius_mm"] * 1e-3,
        one["groove_conformity"],
        math.radians(one["contact_angle_deg"]),
        output,
        material=Material(),
    )
    z1, z2, z3 = pair.ball_count - 1, pair.ball_count, pair.ball_count + 1
    e = pair.short_amplitude * pair.rolling_radius_m
    groove = (two["ball_radius_mm"] * 1e-3, two["groove_conformity"])
    forward = output == "hypocycloid"
    phase = -theta * z1 / z2 if forward else theta * z3 / z2
    first = deceleration_loss_Nm(pair, phase, torque, preload)
    radius = two["pitch_radius_mm"] * 1e-3
    if two["kind"] == "cross_slide":
        slide = CrossSlide(
            two["ball_count"], radius, *groove, math.radians(two["contact_angle_deg"])
        )
        return first, slide_loss_Nm(slide, theta, torque * z1 / z3, preload, e)
    outside = math.radians(two.get("outside_contact_angle_deg", two.get("contact_angle_deg")))
    inside = math.radians(two.get("inside_contact_angle_deg", two.get("contact_angle_deg")))
    ring = RingGroove(two["ball_count"], radius, e, *groove, outside, inside)
    turn = plate_turns(z2, output)[2 if forward else 0]
    phase = -theta * z1 / z3 if forward else theta * z3 / z1
    return first, ring_loss_Nm(ring, phase, torque, preload, turn)


# --- properties -----------------------------------------------------------------------------

MU = st.floats(0.01, 1)


@examples(80)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG, MU)
def test_friction_takes_power_and_is_proportional_to_the_coefficient(
    drive: Drive, share: float, preload: float, angle: float, mu: float
) -> None:
    torque = torque_of(drive, share, preload, angle)
    found = of_angle(drive, torque, preload, angle, coefficient=mu)
    assert found.gap is not None and found.gap <= 1e-8
    assert all(part >= 0 for part in parts(found))
    assert all(contact.torque_Nm >= 0 for contact in found.contacts)
    listed = math.fsum(contact.torque_Nm for contact in found.contacts)
    assert listed == pytest.approx(total(found), rel=1e-9)
    double = of_angle(drive, torque, preload, angle, coefficient=2 * mu)
    assert total(double) == pytest.approx(2 * total(found), rel=1e-12)
    assert total(of_angle(drive, torque, preload, angle, coefficient=0.0)) == 0
    assert found.efficiency is not None and 0 < found.efficiency <= 1


@examples(60)
@given(drives(), PRELOAD_N, st.floats(1.01, 10), CRANK_DEG)
def test_friction_without_load_rises_with_the_preload_by_a_power_from_1_to_4_thirds(
    drive: Drive, preload: float, times: float, angle: float
) -> None:
    """Slip grows like N_Z, pivoting like N_Z^(4/3); the least of sums lies between."""
    low = parts(of_angle(drive, 0, preload, angle))
    high = parts(of_angle(drive, 0, preload * times, angle))
    for a, b in zip(low, high, strict=True):
        # Balls on one diagonal between rings without inside walls roll freely.
        assert times * (1 - 1e-9) * a <= b <= times ** (4 / 3) * (1 + 1e-9) * a


@examples(60)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG)
def test_the_sense_of_rotation_and_of_the_torque_do_not_matter(
    drive: Drive, share: float, preload: float, angle: float
) -> None:
    """Turning back along the same places, and the mirrored drive under the mirrored torque."""
    torque = torque_of(drive, share, preload, angle)
    there = parts(of_angle(drive, torque, preload, angle))
    mirrored = parts(of_angle(drive, -torque, preload, -angle))
    assert there == pytest.approx(mirrored, rel=1e-9)


@examples(20)
@given(drives(), st.sampled_from([0.0, 0.3, -0.6]), st.floats(10, 1e4))
def test_over_a_period_means_and_extremes_hold_together(
    drive: Drive, share: float, preload: float
) -> None:
    torque = share * preload / drive.preload(1.0).drive.hold_N
    found = drive.friction(torque, preload)
    if not found.has_solution:
        return
    assert found.ripple_Nm is not None and found.ripple_Nm >= 0
    assert total(found) == pytest.approx(sum(parts(found)), rel=1e-9)
    at_once = of_angle(drive, torque, preload, 0.0)
    assert abs(total(at_once) - total(found)) <= found.ripple_Nm * (1 + 1e-9) + 1e-9 * total(found)
    assert found.with_coefficient(0.2) == pytest.approx(2 * total(found), rel=1e-9)


def test_the_mean_of_a_cross_slide_is_that_of_its_angles() -> None:
    """Over a period one solution serves all angles; here each has its own."""
    case = base_case()
    case["equal_speed"] |= {"kind": "cross_slide", "ball_count": 15}
    drive = Drive.from_dict(case)
    found = drive.friction(5, 600)
    assert found.equal_speed is not None
    angles = [45.0 * (i + 0.5) / 90 for i in range(90)]  # an eighth of a turn, mirrored in itself
    rows = [parts(of_angle(drive, 5, 600, angle))[1] for angle in angles]
    assert found.equal_speed.torque_Nm == pytest.approx(sum(rows) / 90, rel=1e-4)
    most, least = (parts(of_angle(drive, 5, 600, angle))[1] for angle in (45, 0))
    assert found.equal_speed.ripple_Nm == pytest.approx(most - least, rel=1e-3)


def test_the_slip_of_the_deceleration_pair_falls_with_the_number_of_balls() -> None:
    """Z3/Z1 goes to 1: slip on a track over the way of the ball."""
    shares = []
    for balls in (10, 20, 40):
        case = base_case()
        case["deceleration"] |= {"ball_count": balls, "short_amplitude_coefficient": 0.3}
        contacts = of_angle(Drive.from_dict(case), 0, 600, 0.0).contacts
        slips = [abs(c.slip_m_per_rad) for c in contacts if c.pair == "deceleration"]
        shares.append(max(slips) / (4e-3 * balls))
    assert shares == sorted(shares, reverse=True) and shares[-1] < 0.5 * shares[0]


@examples(60)
@given(drives(), st.floats(0.02, 0.5), PRELOAD_N, CRANK_DEG, st.floats(1.1, 3))
def test_efficiency_falls_with_the_preload_and_rises_with_the_torque(
    drive: Drive, share: float, preload: float, angle: float, times: float
) -> None:
    """Of any drive, away from the limit of hold, where few contacts carry all."""

    def efficiency(torque: float, preload: float) -> float:
        found = of_angle(drive, torque, preload, angle).efficiency
        assert found is not None
        return found

    torque = torque_of(drive, share, preload, angle)
    here = efficiency(torque, preload)
    assert efficiency(torque, preload * times) <= here * (1 + 1e-12)
    assert efficiency(torque / times, preload) <= here * (1 + 1e-12)


@examples(40)
@given(st.integers(6, 30), st.floats(0.1, 0.5), st.floats(1.2, 2))
def test_the_balls_of_more_lobes_run_nearer_to_rolling(balls: int, k: float, times: float) -> None:
    """What a ball must slip at least is the difference of its speeds against the two plates, and
    Z3/Z1 goes to 1."""

    def share(count: int) -> float:
        case = base_case()
        case["deceleration"] |= {"ball_count": count, "short_amplitude_coefficient": k}
        case["track_curvature"] = "neglect"
        contacts = of_angle(Drive.from_dict(case), 0, 600, 0.0).contacts
        slips = [abs(c.slip_m_per_rad) for c in contacts if c.pair == "deceleration"]
        return sum(slips) / count**2  # as many balls, each with a way in proportion

    assert share(math.ceil(balls * times)) < share(balls)


def test_a_coefficient_that_cannot_be_is_told() -> None:
    for wrong in (-0.1, math.nan, 11.0):
        with pytest.raises(cbpt.InvalidInputError, match=r"friction\.coefficient"):
            BASE.friction(5, 600, coefficient=wrong)


def test_a_load_without_solution_has_a_status() -> None:
    found = BASE.friction(5, 5)
    assert found.status == "beyond_hold" and not found.has_solution
    assert found.efficiency is None and found.with_coefficient(0.1) is None


# --- trends of the base case ----------------------------------------------------------------


def test_efficiency_falls_with_preload_and_rises_with_torque() -> None:
    def efficiency(torque: float, preload: float) -> float:
        found = BASE.friction(torque, preload).efficiency
        assert found is not None
        return found

    by_preload = [efficiency(5, n) for n in (200, 400, 800, 1600)]
    by_torque = [efficiency(m, 600) for m in (0, 1, 2, 5, 10, 15)]
    assert by_preload == sorted(by_preload, reverse=True)
    assert by_torque == sorted(by_torque)


def test_a_drive_can_be_driven_backwards_where_friction_is_low() -> None:
    needed = BASE.backdriving_torque_Nm(600)
    assert needed is not None
    friction = BASE.friction(needed, 600)
    assert friction.ripple_Nm is not None
    assert needed / 10.5 == pytest.approx(total(friction), rel=1e-4)
    assert BASE.backdriving_torque_Nm(600, coefficient=3.0) is None
