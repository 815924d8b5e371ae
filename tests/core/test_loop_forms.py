"""Forms of loops beside Dahl's friction: contacts that slip one after another, friction with a
rate, a hard stop. Against their closed forms, on a torsion spring and on a ball drive."""

from __future__ import annotations

import numpy as np
import pytest

from cbpt import Drive
from common.ramps import (
    BALLS,
    SPRING,
    STIFFNESS,
    angles,
    check_sensitivities,
    predictor,
    ramp,
    values_of,
)

SLIP_rad, LIMIT_Nm = 1e-3, 1.5
SLIPPING = {"slip_angle_rad": SLIP_rad, "friction_torque_Nm": LIMIT_Nm}


# --- contacts that slip one after another -----------------------------------------------------


@pytest.mark.parametrize("exponent", [-0.5, 0.0, 1.0])
@pytest.mark.parametrize("share", [0.4, 0.9, 1.6])
def test_the_energy_of_a_loop_is_the_closed_form(exponent: float, share: float) -> None:
    """4 T0 a u^(x + 3)/(x + 3) at the amplitude u of the slip angle a; 4 T0 a (u - 1) more where
    all slip. The torque that turns the spring by u a is k u a plus the friction there."""
    u = min(share, 1.0)
    held = ((exponent + 2) * u - u ** (exponent + 2)) / (exponent + 1)
    top = STIFFNESS * share * SLIP_rad + LIMIT_Nm * held
    torque = ramp(top, -top, top)
    numbers = SLIPPING | {"slip_exponent": exponent}
    effect = {"distributed_friction": numbers}
    turned = angles(SPRING, effect, torque)
    loop = slice(400, None)
    assert turned[400] == pytest.approx(share * SLIP_rad, rel=3e-3)
    energy = abs(np.trapezoid(torque[loop], turned[loop]))
    expected = 4 * LIMIT_Nm * SLIP_rad * (u ** (exponent + 3) / (exponent + 3) + share - u)
    assert energy == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize("drive", [SPRING, BALLS], ids=["spring", "balls"])
def test_an_inner_loop_closes_as_those_of_dahl_do_not(drive: Drive) -> None:
    scale = 1.0 if drive is SPRING else 0.1
    torque = ramp(3 * scale, scale, 2 * scale, scale, steps=50)
    mu = {"friction_radius_m": 5e-4} if drive is BALLS else {"friction_torque_Nm": LIMIT_Nm}
    way = {"slip_angle_rad": 2e-3} if drive is SPRING else {"slip_angle_rad": 1e-4}
    dahl = {"engagement_angle_rad": next(iter(way.values())) / 2}
    closes = angles(drive, {"distributed_friction": mu | way}, torque)
    drifts = angles(drive, {"friction_hysteresis": mu | dahl}, torque)
    reach = float(np.ptp(closes))
    assert abs(closes[200] - closes[100]) < 1e-9 * reach
    assert abs(drifts[200] - drifts[100]) > 1e-4 * reach


def test_the_energy_of_dahls_loop_is_the_closed_form() -> None:
    """4 T0 (A - p tanh(A/p)) at the amplitude A and engagement angle p, once the loop repeats."""
    top, p = 4.0, 1e-3
    torque = ramp(*[top, -top] * 6, top)
    numbers = {"friction_torque_Nm": LIMIT_Nm, "engagement_angle_rad": p}
    turned = angles(SPRING, {"friction_hysteresis": numbers}, torque)
    last = slice(-801, None)
    amplitude = 0.5 * float(np.ptp(turned[last]))
    energy = abs(np.trapezoid(torque[last], turned[last]))
    expected = 4 * LIMIT_Nm * (amplitude - p * np.tanh(amplitude / p))
    assert energy == pytest.approx(expected, rel=1e-4)


# --- friction with a rate ---------------------------------------------------------------------


@pytest.mark.parametrize("step_s", [0.05, 1.0, 20.0])
def test_a_ramp_is_held_back_by_what_its_rate_gives(step_s: float) -> None:
    """On a steady ramp the spring turns at the rate of the torque over its stiffness, up to where
    the ramp turns. At the top of a sine it rests."""
    torque = ramp(10.0, -10.0, steps=200)
    w0 = 2.5e-5
    numbers = {"friction_torque_Nm": LIMIT_Nm, "reference_rate_rad_per_s": w0}
    turned = angles(SPRING, {"rate_friction": numbers}, torque, step_s)
    held = torque - STIFFNESS * turned
    rate = 10.0 / 200 / step_s / STIFFNESS
    up, down = LIMIT_Nm * -np.expm1(-rate / w0), LIMIT_Nm * np.expm1(-2 * rate / w0)
    assert held[199] == pytest.approx(up, rel=1e-6)
    assert held[399] == pytest.approx(down, rel=1e-6)
    assert held[200] == pytest.approx(up, rel=1e-6)
    swing = 10 * np.sin(np.linspace(0, 2 * np.pi, 401))
    turned = angles(SPRING, {"rate_friction": numbers}, swing, step_s)
    assert swing[100] - STIFFNESS * turned[100] == pytest.approx(0.0, abs=1e-12)


def test_a_slow_ramp_and_a_table_without_time_have_no_rate_friction() -> None:
    torque = ramp(10.0, -10.0, steps=50)
    numbers = {"rate_friction": {"friction_torque_Nm": 1.0, "reference_rate_rad_per_s": 1e-5}}
    bare = torque / STIFFNESS
    assert np.abs(angles(SPRING, numbers, torque, 0.0) - bare).max() == 0.0
    slow = angles(SPRING, numbers, torque, 1e6)
    assert np.abs(slow - bare).max() < 1e-4 * np.abs(bare).max()


# --- a hard stop ------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.6, 1.0])
def test_a_stop_takes_its_share_of_the_torque(share: float) -> None:
    torque = np.linspace(-5, 5, 21)
    turned = angles(SPRING, {"hard_stop": {"taken_share": share, "stop_torque_Nm": 2.0}}, torque)
    beyond = np.clip(np.abs(torque) - 2.0, 0.0, None)
    carried = np.sign(torque) * (np.minimum(np.abs(torque), 2.0) + (1 - share) * beyond)
    np.testing.assert_allclose(turned, carried / STIFFNESS, rtol=1e-14, atol=1e-18)


def test_balls_beside_a_stop_turn_as_under_the_torque_that_it_leaves() -> None:
    stop = {"hard_stop": {"taken_share": 0.75, "stop_torque_Nm": 1.0}}
    turned = angles(BALLS, stop, np.array([0.5, 3.0, -3.0]))
    bare = angles(BALLS, {}, np.array([0.5, 1.5, -1.5]))
    np.testing.assert_allclose(turned, bare, rtol=1e-12)


def test_a_loop_reaches_the_stop_at_one_angle_on_both_branches() -> None:
    """Behind friction: the branches reach it at torques that differ by twice the friction."""
    torque = ramp(10.0, 0.0, steps=2000)
    friction = {"friction_torque_Nm": 1.0, "engagement_angle_rad": 1e-5}
    stop = {"taken_share": 1.0, "stop_torque_Nm": 4.0}
    both = {"hard_stop": stop, "friction_hysteresis": friction}
    turned = angles(SPRING, both, torque)
    at_stop = turned >= 4.0 / STIFFNESS * (1 - 1e-9)
    assert turned.max() == pytest.approx(4.0 / STIFFNESS, rel=1e-12)
    assert torque[np.argmax(at_stop)] == pytest.approx(5.0, abs=0.02)


# --- derivatives ------------------------------------------------------------------------------

MIXED = {
    "hard_stop": {"taken_share": 0.6, "stop_torque_Nm": 2.2},
    "distributed_friction": {
        "friction_torque_Nm": 0.8,
        "slip_angle_rad": 3e-3,
        "slip_exponent": 0.4,
        "load_share": 0.08,
    },
    "rate_friction": {"friction_torque_Nm": 0.4, "reference_rate_rad_per_s": 4e-4},
}


@pytest.mark.parametrize("drive", [SPRING, BALLS], ids=["spring", "balls"])
def test_sensitivities_are_exact(drive: Drive) -> None:
    """The torques keep off the kinks, where an element begins to slip."""
    torque = np.array([0.0, 1.13, 2.87, 4.02, 3.31, 1.07, -2.23, -3.61, -1.19])
    found = predictor(drive, list(MIXED), torque, 2.0)
    check_sensitivities(found, values_of(found, MIXED))
