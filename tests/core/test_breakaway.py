"""Friction that breaks away: closed forms, and which solution is reached where the angle jumps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbpt import Drive
from common.drives import examples
from common.ramps import (
    BALLS,
    SPRING,
    Floats,
    angles,
    check_sensitivities,
    predictor,
    ramp,
    values_of,
)

LIMIT_Nm, QUICK_rad = 1.5, 1e-4


def numbers(share: float, ratio: float, quick_rad: float = QUICK_rad) -> dict[str, float]:
    return {
        "friction_torque_Nm": LIMIT_Nm,
        "engagement_angle_rad": quick_rad,
        "breakaway_share": share,
        "weakening_ratio": ratio,
    }


def spring(stiffness: float) -> Drive:
    return Drive.from_dict({"torsion_spring": {"torsional_stiffness_Nm_per_rad": stiffness}})


def first_reached(
    torque_Nm: Floats, stiffness: float, of: dict[str, float], fine_rad: float
) -> Floats:
    """By small steps of the angle, each the way that the torque pulls, until it is balanced."""
    limit, share = of["friction_torque_Nm"], of["breakaway_share"]
    lengths = of["engagement_angle_rad"] * np.array([1.0, of["weakening_ratio"]])
    parts = limit * np.array([1 + share, -share])
    angle, z, found = 0.0, np.zeros(2), []
    for torque in torque_Nm:
        way = np.sign(torque - stiffness * angle - parts @ z)
        while way * (torque - stiffness * angle - parts @ z) > 0:
            angle += way * fine_rad
            z = way - (way - z) * np.exp(-fine_rad / lengths)
        found.append(angle)
    return np.array(found)


# --- closed forms -----------------------------------------------------------------------------


@pytest.mark.parametrize("drive", [SPRING, BALLS], ids=["spring", "balls"])
def test_without_a_share_that_is_lost_it_is_dahls(drive: Drive) -> None:
    scale = 1.0 if drive is SPRING else 0.1
    torque = scale * ramp(8.0, -8.0, 3.0, steps=40)
    size = {"friction_radius_m": 3e-4} if drive is BALLS else {"friction_torque_Nm": LIMIT_Nm}
    dahl = size | {"engagement_angle_rad": QUICK_rad}
    expected = angles(drive, {"friction_hysteresis": dahl}, torque)
    for lost in ({"breakaway_share": 0.0}, {"breakaway_share": 0.7, "weakening_ratio": 1.0}):
        found = angles(drive, {"breakaway_friction": dahl | lost}, torque)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())


def test_the_torque_peaks_after_a_reversal_and_falls_to_that_of_sliding() -> None:
    """On a spring that stiffens faster than friction falls, so that every angle is reached. From
    rest and from sliding the other way the peak lies at p r/(r - 1) ln(r (1 + b)/b)."""
    share, ratio, k = 0.8, 6.0, 2e4
    torque = ramp(80.0, -80.0, steps=16000)
    turned = angles(spring(k), {"breakaway_friction": numbers(share, ratio)}, torque)
    held = torque - k * turned
    peak_rad = QUICK_rad * ratio / (ratio - 1) * np.log(ratio * (1 + share) / share)
    quick, slow = np.exp(-peak_rad / QUICK_rad), np.exp(-peak_rad / QUICK_rad / ratio)
    for grown, sign, leg in ((1, 1, slice(0, 16001)), (2, -1, slice(16000, None))):
        along, rubs = sign * (turned[leg] - turned[leg][0]), sign * held[leg]
        top = int(np.argmax(rubs))
        assert along[top] == pytest.approx(peak_rad, rel=0.01)
        expected = LIMIT_Nm * (1 - grown * ((1 + share) * quick - share * slow))
        # What slid before has all but settled.
        assert rubs[top] == pytest.approx(expected, rel=1e-5 if grown == 1 else 1e-3)
        assert rubs[top] > 1.1 * LIMIT_Nm
        assert rubs[-1] == pytest.approx(LIMIT_Nm, rel=2e-3)


@pytest.mark.parametrize("top_Nm", [2.0, 6.0, 30.0])
def test_the_energy_of_a_loop_is_the_closed_form(top_Nm: float) -> None:
    """4 L ((1 + b)(A - p tanh(A/p)) - b (A - r p tanh(A/(r p)))) at the amplitude A."""
    share, ratio = 0.8, 6.0
    torque = ramp(*[top_Nm, -top_Nm] * 8, top_Nm, steps=600)
    turned = angles(spring(2e4), {"breakaway_friction": numbers(share, ratio)}, torque)
    last = slice(-1201, None)
    a = 0.5 * float(np.ptp(turned[last]))
    quick, slow = QUICK_rad, ratio * QUICK_rad
    lost = (1 + share) * (a - quick * np.tanh(a / quick)) - share * (a - slow * np.tanh(a / slow))
    energy = abs(np.trapezoid(torque[last], turned[last]))
    assert energy == pytest.approx(4 * LIMIT_Nm * lost, rel=2e-3)


# --- jumps ------------------------------------------------------------------------------------

SOFT = 500.0
"""N m/rad: the friction falls faster than this spring stiffens."""


@pytest.mark.parametrize("steps", [7, 60])
@pytest.mark.parametrize(("share", "ratio"), [(0.5, 5.0), (2.0, 3.0), (1.0, 20.0)])
def test_the_solution_is_the_one_that_the_motion_reaches_first(
    share: float, ratio: float, steps: int
) -> None:
    of = numbers(share, ratio)
    torque = ramp(5.0, -4.0, 2.0, 5.0, steps=steps)
    fine_rad = 2e-3 * QUICK_rad
    found = angles(spring(SOFT), {"breakaway_friction": of}, torque)
    expected = first_reached(torque, SOFT, of, fine_rad)
    # Where a step of the torque stops just short of a jump, the coarser of the two may be over it.
    apart = np.abs(found - expected)
    assert np.quantile(apart, 0.95) < 3 * fine_rad
    assert np.median(apart) < 1.5 * fine_rad


def test_it_jumps_where_the_balance_folds() -> None:
    """The friction peaks at more than it slides with; the angle jumps over what is unstable."""
    of = numbers(2.0, 4.0)
    torque = ramp(8.0, steps=4000)
    found = angles(spring(SOFT), {"breakaway_friction": of}, torque)
    steps = np.diff(found)
    jump = int(np.argmax(steps))
    assert steps[jump] > 300 * np.median(steps)
    assert (steps >= 0).all()
    angle = np.linspace(0, 2e-2, 200_001)
    quick, slow = np.expm1(-angle / QUICK_rad), np.expm1(-angle / QUICK_rad / 4)
    needed = SOFT * angle - LIMIT_Nm * (3.0 * quick - 2.0 * slow)
    fold = int(np.argmax(np.diff(needed) < 0))
    assert torque[jump] <= needed[fold] <= torque[jump + 1]
    after = int(np.argmax((needed > needed[fold]) & (angle > angle[fold])))
    assert found[jump + 1] == pytest.approx(angle[after], rel=5e-3)


@examples(40)
@given(
    st.floats(0.0, 5.0),
    st.floats(1.0, 60.0),
    st.floats(2.0, 4.5).map(lambda power: 10**power),
    st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=12),
)
def test_every_reading_is_balanced_and_reached_on_its_way(
    share: float, ratio: float, stiffness: float, ends: list[float]
) -> None:
    """What is solved keeps the balance, and a denser table of the same torques ends at the same
    angles: a jump depends on the torques passed through and not on where one looks."""
    of = {"breakaway_friction": numbers(share, ratio)}
    sparse = np.array([0.0, *ends])
    dense = ramp(*ends, steps=8)
    found = [predictor(spring(stiffness), list(of), t) for t in (sparse, dense)]
    one, many = (f.predict(values_of(f, of)) for f in found)
    assert one.solved.all() and many.solved.all()
    angle, again = np.asarray(one.angle_rad), np.asarray(many.angle_rad)[::8]
    np.testing.assert_allclose(angle, again, rtol=1e-6, atol=1e-6 * QUICK_rad)
    held, lengths = 0.0, QUICK_rad * np.array([1.0, ratio])
    z, before = np.zeros(2), 0.0
    for torque, here in zip(sparse, angle, strict=True):
        way = here - before
        z = np.sign(way) - (np.sign(way) - z) * np.exp(-abs(way) / lengths)
        held = LIMIT_Nm * float(np.array([1 + share, -share]) @ z)
        assert abs(stiffness * here + held - torque) < 1e-8 * (abs(torque) + LIMIT_Nm * (1 + share))
        before = here


@pytest.mark.parametrize("drive", [SPRING, BALLS], ids=["spring", "balls"])
def test_sensitivities_are_exact_on_the_branch_that_is_reached(drive: Drive) -> None:
    size = {"friction_radius_m": 5e-4} if drive is BALLS else {"friction_torque_Nm": 0.8}
    of = {
        "breakaway_friction": size
        | {"engagement_angle_rad": 2e-4, "breakaway_share": 0.9, "weakening_ratio": 3.0}
    }
    torque = np.array([0.0, 1.13, 2.87, 4.02, 3.31, 1.07, -2.23, -3.61, -1.19])
    found = predictor(drive, list(of), torque)
    check_sensitivities(found, values_of(found, of))
