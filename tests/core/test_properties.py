"""Laws of mechanics as a Python user sees them, on random drives.

Groups: solutions and their arrays, symmetries and scaling, preload and largest angle.
"""

from __future__ import annotations

import _thread
import contextlib
import math
import re
import signal
import threading
import time

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cbpt import Drive, solve_many
from common.drives import (
    ARCSEC,
    CRANK_DEG,
    PRELOAD_N,
    SHARE,
    CaseDict,
    angle_of,
    base_case,
    cases,
    drives,
    examples,
    solved,
    torque_of,
)

# --- solutions and their arrays -----------------------------------------------------------


@examples(100)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG)
def test_forces_balance_and_arrays_fit(
    drive: Drive, share: float, preload: float, angle: float
) -> None:
    """The normal forces of each pair carry the preload; no contact pulls; one row a diagonal."""
    torque = torque_of(drive, share, preload, angle)
    solution = solved(drive, torque, preload, angle)
    assert solution.status in ("ok", "outside_small_displacements")
    assert (solution.torque_Nm, solution.preload_N) == (torque, preload)
    assert solution.input_angle_deg == angle
    assert solution.hold_preload_N is None
    assert solution.residual is not None
    assert 0 <= solution.residual <= 1e-11
    for pair, balls in [
        (solution.deceleration, drive.deceleration_ball_count),
        (solution.equal_speed, drive.equal_speed_ball_count),
    ]:
        assert pair is not None
        n = 2 * balls
        assert pair.ball.shape == pair.diagonal.shape == pair.force_N.shape == (n,)
        assert pair.deformation_m.shape == pair.gap_m.shape == (n,)
        assert len(pair.role) == len(pair.contact) == n
        assert np.issubdtype(pair.ball.dtype, np.integer)
        assert pair.force_N.dtype == pair.deformation_m.dtype == np.float64
        np.testing.assert_array_equal(pair.ball, np.repeat(np.arange(balls), 2))
        np.testing.assert_array_equal(pair.diagonal, np.tile([1, -1], balls))
        assert set(pair.role) <= {"FTMP", "NFTMP", "neutral"}
        contact = np.array(pair.contact)
        assert set(pair.contact) <= {"loaded", "parted", "wall_missing"}
        np.testing.assert_array_equal(contact == "loaded", pair.force_N > 0)
        assert (pair.deformation_m >= 0).all()
        assert (pair.gap_m >= 0).all()
        assert (pair.deformation_m * pair.gap_m == 0).all()
        assert pair.carrying == np.count_nonzero(pair.force_N)
        loaded = contact == "loaded"
        walls = (pair.wall_approach_m, pair.major_semi_axis_m, pair.minor_semi_axis_m)
        for wall in (*walls, pair.peak_pressure_Pa):
            assert wall.shape == (n, 2)
            assert wall.dtype == np.float64
            assert not np.isnan(wall[contact != "wall_missing"]).any()
            assert (wall[contact == "parted"] == 0).all()
        assert np.isnan(pair.peak_pressure_Pa[contact == "wall_missing"]).any(axis=1).all()
        # Two contacts in series, and the force under the half ellipsoid of the pressure.
        approach = pair.wall_approach_m[loaded].sum(axis=1)
        np.testing.assert_allclose(approach, pair.deformation_m[loaded], rtol=1e-11)
        ellipse = math.pi * pair.major_semi_axis_m * pair.minor_semi_axis_m
        force = 2 / 3 * (ellipse * pair.peak_pressure_Pa)[loaded]
        np.testing.assert_allclose(force, np.stack([pair.force_N[loaded]] * 2, axis=1), rtol=1e-11)
        assert pair.largest_peak_pressure_Pa == np.nanmax(pair.peak_pressure_Pa)


@examples(60)
@given(cases(), SHARE, PRELOAD_N, CRANK_DEG)
def test_axial_forces_add_up_to_the_preload(
    case: CaseDict, share: float, preload: float, angle: float
) -> None:
    """Sum N sin(beta) = N_Z; the force across the deceleration pair is M0/(Zo e)."""
    drive = Drive.from_dict(case)
    torque = torque_of(drive, share, preload, angle)
    solution = solved(drive, torque, preload, angle)
    first, second = solution.deceleration, solution.equal_speed
    assert first is not None
    assert second is not None
    beta = math.radians(case["deceleration"]["contact_angle_deg"])
    assert first.force_N.sum() * math.sin(beta) == pytest.approx(preload, rel=1e-10)
    beta_2 = case["equal_speed"]["contact_angle_rad"]
    assert second.force_N.sum() * math.sin(beta_2) == pytest.approx(preload, rel=1e-10)
    lobes = drive.deceleration_ball_count + math.copysign(1, drive.transmission_ratio)
    across = torque / (lobes * drive.eccentricity_m)
    scale = preload / math.tan(beta)
    assert first.in_plane_force_across_N == pytest.approx(across, abs=1e-10 * scale)
    sideways = second.in_plane_force_across_N
    assert sideways == pytest.approx(0, abs=1e-10 * preload / math.tan(beta_2))


@examples(60)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG)
def test_the_parts_add_up(drive: Drive, share: float, preload: float, angle: float) -> None:
    """The elastic angle is the sum of its parts, in every unit; the compliances add, too."""
    torque = torque_of(drive, share, preload, angle)
    s = solved(drive, torque, preload, angle)
    first, second = s.deceleration, s.equal_speed
    assert first is not None
    assert second is not None
    assert s.alpha_deceleration_arcsec is not None
    assert s.alpha_equal_speed_arcsec is not None
    total = s.alpha_deceleration_arcsec + s.alpha_equal_speed_arcsec
    scale = abs(s.alpha_deceleration_arcsec) + abs(s.alpha_equal_speed_arcsec)
    assert s.elastic_angle_arcsec == pytest.approx(total, abs=1e-14 * scale)
    assert s.elastic_angle_rad == pytest.approx(total * ARCSEC, abs=1e-14 * scale * ARCSEC)
    assert first.angle_arcsec == s.alpha_deceleration_arcsec
    carried = second.torque_Nm / torque
    assert s.alpha_equal_speed_arcsec == pytest.approx(carried * second.angle_arcsec, rel=1e-14)
    compliance = 1 / first.torsional_stiffness_Nm_per_rad
    compliance += carried**2 / second.torsional_stiffness_Nm_per_rad
    assert s.torsional_stiffness_Nm_per_rad == pytest.approx(1 / compliance, rel=1e-12)


@examples(40)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG, st.floats(0.001, 0.999))
def test_without_a_balance_there_are_no_numbers(
    drive: Drive, share: float, preload: float, angle: float, less: float
) -> None:
    """Below the hold threshold a solution has its reason and None, never a number."""
    torque = torque_of(drive, share, preload, angle)
    hold = drive.preload(torque, angle).drive.hold_N
    s = drive.solve(torque, hold * less, angle)
    assert s.status == "beyond_hold"
    assert not s.has_solution
    assert s.hold_preload_N == pytest.approx(hold, rel=1e-12)
    told = re.search(r"more than ([0-9.]+) N", s.message)
    assert told is not None
    # Rounded up to five digits: a preload that is typed in from the message holds.
    assert hold * (1 - 1e-12) <= float(told[1]) <= hold * (1 + 1.1e-4)
    assert s.elastic_angle_rad is None
    assert s.elastic_angle_arcsec is None
    assert s.alpha_deceleration_arcsec is None
    assert s.alpha_equal_speed_arcsec is None
    assert s.torsional_stiffness_Nm_per_rad is None
    assert s.residual is None
    assert s.deceleration is None
    assert s.equal_speed is None
    many = solve_many(drive, [torque], hold * less, angle)
    assert many.status.tolist() == ["beyond_hold"]
    assert not many.has_solution.any()
    assert np.isnan(many.elastic_angle_rad).all()
    assert np.isnan(many.residual).all()
    assert many.hold_preload_N == pytest.approx(hold, rel=1e-12)
    assert drive.solve(torque, hold * 1.001, angle).has_solution


def test_an_undercut_drive_has_a_reason_and_no_numbers() -> None:
    """A groove that cuts its own wall away is told by status and finding, not by an exception."""
    case = base_case()
    case["deceleration"]["short_amplitude_coefficient"] = 0.8
    drive = Drive.from_dict(case)
    s = drive.solve(5, 600)
    assert (s.status, s.elastic_angle_rad, s.deceleration) == ("undercut", None, None)
    assert solve_many(drive, [5, 1], 600).status.tolist() == ["undercut"] * 2
    assert drive.largest_elastic_angle(5, 600) is None
    assert [finding.code for finding in drive.findings()][:1] == ["undercut"]


# --- symmetries and scaling ---------------------------------------------------------------


@examples(60)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG)
def test_the_mirror_image(drive: Drive, share: float, preload: float, angle: float) -> None:
    """alpha(-M0) at -theta is -alpha(M0) at theta."""
    torque = torque_of(drive, share, preload, angle)
    here = angle_of(drive, torque, preload, angle)
    there = angle_of(drive, -torque, preload, -angle)
    assert there == pytest.approx(-here, rel=1e-8)


@examples(60)
@given(cases(), SHARE, PRELOAD_N, CRANK_DEG, st.floats(0.05, 20), st.floats(0.01, 100))
def test_only_load_over_stiffness_counts(
    case: CaseDict, share: float, preload: float, angle: float, modulus: float, load: float
) -> None:
    """alpha = k^(-2/3) N_Z^(2/3) f(M0/N_Z), with k through Young's modulus."""
    drive = Drive.from_dict(case)
    torque = torque_of(drive, share, preload, angle)
    material = case.setdefault("material", {})
    for name, default in [("ball_youngs_modulus_GPa", 208), ("plate_youngs_modulus_Pa", 208e9)]:
        material[name] = modulus * material.get(name, default)
    other = Drive.from_dict(case)
    here = angle_of(drive, torque, preload, angle)
    there = angle_of(other, load * torque, load * preload, angle)
    assert there == pytest.approx(here * (load / modulus) ** (2 / 3), rel=1e-8)


@examples(40)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG, st.floats(1e-3, 0.99))
def test_more_torque_more_angle(
    drive: Drive, share: float, preload: float, angle: float, less: float
) -> None:
    """The elastic angle rises with the torque and turns with it."""
    torque = torque_of(drive, share, preload, angle)
    torques = torque * np.array([less, 1.0])
    small, large = solve_many(drive, torques, preload, angle).elastic_angle_rad
    assert (large - small) * torque > 0


# --- preload and largest angle ------------------------------------------------------------


@examples(20)
@given(drives(), st.floats(-60, 60).filter(lambda t: abs(t) > 1e-3), CRANK_DEG, st.floats(0.1, 9))
def test_thresholds_in_their_order(
    drive: Drive, torque: float, angle: float, factor: float
) -> None:
    """hold <= continuous <= zero backlash; the drive needs the larger; all go with the torque."""
    most, here = drive.preload(torque), drive.preload(torque, angle)
    assert (most.input_angle_deg, here.input_angle_deg) == (None, angle)
    assert most.torque_Nm == here.torque_Nm == torque
    names = ("hold_N", "continuous_N", "zero_backlash_N")
    for all_angles, one_angle in [
        (most.deceleration, here.deceleration),
        (most.equal_speed, here.equal_speed),
        (most.drive, here.drive),
    ]:
        values = [getattr(one_angle, name) for name in names]
        assert 0 < values[0] <= values[1] * (1 + 1e-12) <= values[2] * (1 + 2e-12)
        for name, value in zip(names, values, strict=True):
            assert value <= getattr(all_angles, name) * (1 + 1e-9)
    for name in names:
        pairs = getattr(here.deceleration, name), getattr(here.equal_speed, name)
        assert getattr(here.drive, name) == max(pairs)
        times = getattr(drive.preload(factor * torque, angle).drive, name)
        assert times == pytest.approx(factor * getattr(here.drive, name), rel=1e-11)


@examples(40)
@given(drives(), SHARE, PRELOAD_N, CRANK_DEG)
def test_zero_backlash_is_where_the_first_diagonal_parts(
    drive: Drive, share: float, preload: float, angle: float
) -> None:
    """Above the threshold every diagonal of the drive carries, just below one has parted."""
    torque = torque_of(drive, share, preload, angle)
    threshold = drive.preload(torque, angle).drive.zero_backlash_N

    def parted(preload_N: float) -> bool:
        s = solved(drive, torque, preload_N, angle)
        assert s.deceleration is not None
        assert s.equal_speed is not None
        return "parted" in s.deceleration.contact + s.equal_speed.contact

    assert not parted(threshold * (1 + 1e-6))
    assert parted(threshold * (1 - 1e-6))


@examples(12)
@given(drives(), st.floats(0.05, 0.9), PRELOAD_N, st.booleans())
def test_no_angle_exceeds_the_largest(
    drive: Drive, share: float, preload: float, negative: bool
) -> None:
    """The largest elastic angle is reached where it says, and nowhere exceeded over its period."""
    assume(drive.deceleration_ball_count * drive.equal_speed_ball_count < 200)
    sign = -1 if negative else 1
    torque = sign * share * preload / drive.preload(sign).drive.hold_N
    largest = drive.largest_elastic_angle(torque, preload)
    assert largest is not None
    at = solved(drive, torque, preload, largest.input_angle_deg).elastic_angle_arcsec
    assert at == pytest.approx(largest.elastic_angle_arcsec, rel=1e-9)
    cranks = np.linspace(0, largest.period_deg, 50)
    sizes = sign * solve_many(drive, torque, preload, cranks).elastic_angle_arcsec
    most = sign * largest.elastic_angle_arcsec
    slack = 1e-3 * largest.amplitude_arcsec + 1e-9 * most
    assert sizes.max() <= most + slack
    # The amplitude is that of the samples.
    assert most - sizes.min() <= 1.01 * largest.amplitude_arcsec + slack
    assert sizes[-1] == pytest.approx(sizes[0], rel=1e-8)
    assert drive.largest_elastic_angle(torque, preload * share * 0.99) is None


def test_the_search_for_the_largest_angle_can_be_interrupted() -> None:
    """Most of the processor's time that a thousand balls take is saved."""
    case = base_case()
    case["deceleration"]["ball_count"] = 1000
    case["equal_speed"] |= {"ball_count": 999, "pitch_radius_mm": 3000}
    drive = Drive.from_dict(case)

    def searched() -> float:
        start = time.process_time()
        with contextlib.suppress(KeyboardInterrupt):
            drive.largest_elastic_angle(1, 600)
        return time.process_time() - start

    whole = searched()
    # Whoever starts the tests in the background may have Ctrl-C ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.01, _thread.interrupt_main).start()
        assert searched() < 0.5 * whole
    finally:
        signal.signal(signal.SIGINT, before)
