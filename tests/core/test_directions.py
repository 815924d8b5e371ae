"""Which wall, which way: laws that a mirrored model would break, on random drives.

A wall on the hollow side of its track fits the ball less than the one across; a crank that turns by
one pitch hands each ball to its neighbour; more preload never makes the drive softer.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cbpt import Drive
from common.drives import CaseDict, angle_of, base_case, cases, drives, examples, solved, torque_of


def output_is_hypocycloid(case: CaseDict) -> bool:
    return bool(case["deceleration"].get("output_plate", "hypocycloid") == "hypocycloid")


# --- the walls ----------------------------------------------------------------------------


@examples(30)
@given(cases("ring_groove"), st.floats(0.03, 0.97))
def test_walls_on_the_side_of_the_centre_of_curvature_fit_the_ball_less(
    case: CaseDict, place: float
) -> None:
    """A wall on the hollow side of its track is met by a ball as a convex one: its contact ellipse
    is longer for its width than that of the wall across. Which of them a diagonal has follows from
    the way in which the torque pushes the ball."""
    z2 = case["deceleration"]["ball_count"]
    drive = Drive.from_dict(case)
    crank_deg = math.degrees(2 * math.pi * place / (z2 - 1))
    pair = solved(drive, 0.0, 100.0, crank_deg).deceleration
    assert pair is not None
    ratio = (pair.minor_semi_axis_m / pair.major_semi_axis_m).reshape(z2, 2, 2)
    assume(np.isfinite(ratio).all())
    way = -(z2 - 1) / z2 if output_is_hypocycloid(case) else (z2 + 1) / z2
    phi = way * math.radians(crank_deg) + 2 * np.pi * np.arange(z2) / z2
    k = case["deceleration"]["short_amplitude_coefficient"]
    # Of the plus diagonal: the epicycloid's wall lies on the side of the pitch point where the
    # hypocycloid is the output, and across where it is not.
    towards = 1.0 if output_is_hypocycloid(case) else -1.0
    for plate, curved in (
        (0, 1 + z2 * k**2 - (1 + z2) * k * np.cos(phi)),
        (1, -(1 - z2 * k**2 + (z2 - 1) * k * np.cos(phi))),
    ):
        clear = np.abs(curved) > 0.05
        less = ratio[clear, 0, plate] < ratio[clear, 1, plate]
        np.testing.assert_array_equal(less, towards * curved[clear] > 0)


@examples(30)
@given(cases("ring_groove"), st.floats(-180, 180))
def test_outside_walls_of_ring_grooves_lie_round_the_ball(case: CaseDict, crank_deg: float) -> None:
    """Along the track the outside wall curves round the ball, the inside wall away from it: their
    relative curvatures are e/(r(e + r cos beta)) and e/(r(e - r cos beta)), across 1/r - 1/g."""
    drive = Drive.from_dict(case)
    groove = case["equal_speed"]
    radius, beta = groove["ball_radius_um"] * 1e-6, groove["contact_angle_rad"]
    shift = radius * math.cos(beta)
    pair = solved(drive, 0.0, 100.0, crank_deg).equal_speed
    assert pair is not None
    ratio = (pair.minor_semi_axis_m / pair.major_semi_axis_m).reshape(groove["ball_count"], 2, 2)
    assume(np.isfinite(ratio).all())
    e = drive.eccentricity_m
    across = (1 - 1 / groove["groove_conformity"]) / radius
    longer = [abs(math.log(e / (radius * (e + side * shift)) / across)) for side in (1, -1)]
    assume(abs(longer[0] - longer[1]) > 1e-3)
    outside_is_rounder = longer[0] < longer[1]
    np.testing.assert_array_equal(ratio[:, 0] > ratio[:, 1], outside_is_rounder)


# --- the crank ----------------------------------------------------------------------------


@examples(40)
@given(cases(), st.floats(0.2, 0.8), st.floats(-180, 180), st.sampled_from([-1.0, 1.0]))
def test_a_crank_that_turns_by_one_pitch_hands_each_ball_to_its_neighbour(
    case: CaseDict, share: float, crank_deg: float, sign: float
) -> None:
    """Against the crank the balls turn backwards where the hypocycloid plate is the output, and
    forwards where the epicycloid plate is."""
    drive = Drive.from_dict(case)
    z2 = case["deceleration"]["ball_count"]
    hypocycloid = output_is_hypocycloid(case)
    pitch_deg = 360 / (z2 - 1) if hypocycloid else 360 / (z2 + 1)
    torque = 0.5 * torque_of(drive, sign * share, 100.0, crank_deg)
    one = solved(drive, torque, 100.0, crank_deg).deceleration
    other = solved(drive, torque, 100.0, crank_deg + pitch_deg).deceleration
    assert one is not None and other is not None
    before, after = (p.force_N.reshape(z2, 2) for p in (one, other))
    # The pattern is no mirror image of itself, or the sense could not be seen.
    assume(np.abs(before - np.roll(before, 2, axis=0)).max() > 1e-3 * before.max())
    step = 1 if hypocycloid else -1
    scale = float(before.max())
    np.testing.assert_allclose(after, np.roll(before, step, axis=0), atol=1e-6 * scale)


@examples(40)
@given(cases("ring_groove"), st.floats(0.2, 0.8), st.floats(-180, 180))
def test_a_planet_that_turns_by_one_pitch_hands_each_ring_ball_to_its_neighbour(
    case: CaseDict, share: float, crank_deg: float
) -> None:
    """The planet turns against the crank with the balls: backwards where the hypocycloid plate is
    the output, forwards where the epicycloid plate is."""
    drive = Drive.from_dict(case)
    z2, z = case["deceleration"]["ball_count"], case["equal_speed"]["ball_count"]
    hypocycloid = output_is_hypocycloid(case)
    turn = (z2 - 1) / (z2 + 1) if hypocycloid else (z2 + 1) / (z2 - 1)
    pitch_deg = 360 / z / turn
    torque = 0.5 * min(
        torque_of(drive, share, 100.0, crank) for crank in (crank_deg, crank_deg + pitch_deg)
    )
    one = solved(drive, torque, 100.0, crank_deg).equal_speed
    other = solved(drive, torque, 100.0, crank_deg + pitch_deg).equal_speed
    assert one is not None and other is not None
    before, after = (p.force_N.reshape(z, 2) for p in (one, other))
    scale = float(before.max())
    step = 1 if hypocycloid else -1
    # Either sense alike, and the sense could not be seen.
    assume(np.abs(np.roll(before, 1, axis=0) - np.roll(before, -1, axis=0)).max() > 1e-3 * scale)
    np.testing.assert_allclose(after, np.roll(before, step, axis=0), atol=1e-6 * scale)


# --- the preload --------------------------------------------------------------------------


@examples(40)
@given(drives(), st.floats(0.05, 0.6), st.floats(1.05, 3.0))
def test_the_largest_angle_falls_with_the_preload(
    drive: Drive, share: float, factor: float
) -> None:
    """At every torque that the lower preload holds. The fall gets slower: the slope of the angle
    in the preload rises."""
    torque = torque_of(drive, share, 100.0, 0.0)
    preloads = [100.0, 100.0 * factor, 100.0 * factor**2]
    found = [drive.largest_elastic_angle(torque, preload) for preload in preloads]
    assume(all(found))
    angles = [f.elastic_angle_arcsec for f in found if f is not None]
    assert angles[0] > angles[1] > angles[2]
    slopes = np.diff(angles) / np.diff(preloads)
    assert slopes[1] > slopes[0]


@examples(60)
@given(drives(), st.floats(0.05, 0.9), st.floats(1.01, 3.0), st.floats(-180, 180))
def test_the_angle_falls_with_the_preload_at_every_input_angle(
    drive: Drive, share: float, factor: float, crank_deg: float
) -> None:
    torque = torque_of(drive, share, 100.0, crank_deg)
    low = angle_of(drive, torque, 100.0, crank_deg)
    assert angle_of(drive, torque, 100.0 * factor, crank_deg) < low


def test_the_fall_follows_the_power_law_far_from_contact_loss() -> None:
    """alpha = k^(-2/3) N^(2/3) f(M/N), and f is linear there: the angle falls as N^(-1/3)."""
    drive = Drive.from_dict(base_case())
    small, large = (angle_of(drive, 1e-4, preload, 0.0) for preload in (600.0, 4800.0))
    assert small / large == pytest.approx(2.0, rel=1e-6)
