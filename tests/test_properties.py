"""Laws of mechanics as a Python user sees them, on random drives; and input that cannot be.

Groups: solutions and their arrays, symmetries and scaling, preload and largest angle, many loads
at once, pickles and files, input that cannot be, agreement with the reference model.
"""

from __future__ import annotations

import _thread
import copy
import json
import math
import pickle
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import cbpt
from cbpt import CaseError, CbptError, Drive, InvalidInputError, Solution, solve_many

REFERENCE: dict[str, Any] = json.loads(
    (Path(__file__).parent / "data" / "golden" / "reference.json").read_text()
)
ARCSEC = math.pi / 648000
CaseDict = dict[str, Any]


def examples(number: int) -> settings:
    """The same cases in every run, so that a test cannot fail by chance."""
    return settings(max_examples=number, derandomize=True, deadline=None, database=None)


# --- random valid drives and loads --------------------------------------------------------

ANGLE_DEG = st.floats(20, 70)
CONFORMITY = st.floats(1.01, 1.3)
CRANK_DEG = st.floats(-400, 400)
PRELOAD_N = st.floats(-2, 5).map(lambda exponent: 10.0**exponent)


@st.composite
def cases(draw: st.DrawFn, kind: str | None = None) -> CaseDict:
    """A case without undercut; a ring groove may lack its inside wall. Lengths in any unit."""
    balls = draw(st.integers(3, 40))
    k = draw(st.floats(0.05, 0.8))
    radius_mm = draw(st.floats(1, 8))
    # No wall is cut away while the ball is smaller than the smallest radius of the tracks.
    smallest_mm = balls * radius_mm * (1 - k) ** 2 / (1 + balls * k)
    kind = kind or draw(st.sampled_from(["ring_groove", "cross_slide"]))
    deceleration: CaseDict = {
        "ball_count": balls,
        "short_amplitude_coefficient": k,
        "rolling_circle_radius_mm": radius_mm,
        "ball_radius_m": draw(st.floats(0.1, 0.95)) * smallest_mm * 1e-3,
        "groove_conformity": draw(CONFORMITY),
        "contact_angle_deg": draw(ANGLE_DEG),
    }
    if kind == "ring_groove" and draw(st.booleans()):
        deceleration["output_plate"] = "epicycloid"
    equal_speed: CaseDict = {
        "kind": kind,
        "ball_count": draw(st.integers(3, 24)),
        "pitch_radius_mm": draw(st.floats(10, 80)),
        "ball_radius_um": draw(st.floats(300, 4000)),
        "groove_conformity": draw(CONFORMITY),
        "contact_angle_rad": math.radians(draw(ANGLE_DEG)),
    }
    case = {"deceleration": deceleration, "equal_speed": equal_speed}
    if draw(st.booleans()):
        case["material"] = {
            "ball_youngs_modulus_GPa": draw(st.floats(70, 400)),
            "plate_youngs_modulus_Pa": draw(st.floats(70e9, 400e9)),
            "poissons_ratio": draw(st.floats(0.1, 0.45)),
        }
    return case


def drives(kind: str | None = None) -> st.SearchStrategy[Drive]:
    return cases(kind).map(Drive.from_dict)


SHARE = st.floats(0.01, 0.95).flatmap(lambda share: st.sampled_from([share, -share]))


def torque_of(drive: Drive, share: float, preload_N: float, angle_deg: float) -> float:
    """Torque that is a share of what the preload holds at a crank angle, in its direction."""
    hold = drive.preload(math.copysign(1.0, share), angle_deg).drive.hold_N
    return share * preload_N / hold


def solved(drive: Drive, *load: float) -> Solution:
    solution = drive.solve(*load)
    assert solution.has_solution, solution.message
    return solution


def angle_of(drive: Drive, *load: float) -> float:
    angle = solved(drive, *load).elastic_angle_rad
    assert angle is not None
    return angle


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
    assert float(told[1]) == pytest.approx(hold, rel=1e-6, abs=1e-6)
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


# --- many loads at once -------------------------------------------------------------------


@examples(40)
@given(
    drives(),
    st.lists(st.tuples(st.floats(-1.5, 1.5), PRELOAD_N, CRANK_DEG), min_size=1, max_size=12),
)
def test_many_loads_are_solved_as_each_alone(
    drive: Drive, loads: list[tuple[float, float, float]]
) -> None:
    """solve_many gives, in order, what solve gives one by one; unsolvable loads stay as rows."""
    rows = [(torque_of(drive, share, n, angle), n, angle) for share, n, angle in loads]
    torque, preload, angle = np.array(rows).T
    many = solve_many(drive, torque, preload, angle)
    assert len(many) == len(rows)
    for i, load in enumerate(rows):
        s = drive.solve(*load)
        assert many.status[i] == s.status
        assert many.has_solution[i] == s.has_solution
        for found, alone in [
            (many.elastic_angle_rad, s.elastic_angle_rad),
            (many.elastic_angle_arcsec, s.elastic_angle_arcsec),
            (many.alpha_deceleration_rad / ARCSEC, s.alpha_deceleration_arcsec),
            (many.alpha_equal_speed_rad / ARCSEC, s.alpha_equal_speed_arcsec),
            (many.residual, s.residual),
            (many.hold_preload_N, s.hold_preload_N),
        ]:
            value = float(found[i])
            assert (alone is None and math.isnan(value)) or value == pytest.approx(alone, rel=1e-14)


def test_loads_broadcast_as_in_numpy() -> None:
    """Torque down, preload across; the inputs come back in the same shape; all are float arrays."""
    drive = Drive.from_dict(base_case())
    torque, preload = np.linspace(-5, 5, 4)[:, None], [200, 400, 600]
    many = solve_many(drive, torque, preload, 7)
    arrays = [
        many.torque_Nm,
        many.preload_N,
        many.input_angle_deg,
        many.alpha_deceleration_rad,
        many.alpha_equal_speed_rad,
        many.elastic_angle_rad,
        many.residual,
        many.hold_preload_N,
    ]
    assert all(array.shape == (4, 3) and array.dtype == np.float64 for array in arrays)
    assert many.status.shape == many.has_solution.shape == (4, 3)
    assert many.has_solution.dtype == np.bool_
    assert many.elastic_angle_rad[3, 2] == drive.solve(5, 600, 7).elastic_angle_rad
    assert solve_many(drive, 5, 600).elastic_angle_rad.shape == ()
    assert len(solve_many(drive, [], 600)) == 0


# --- pickles and files --------------------------------------------------------------------


@examples(40)
@given(cases(), SHARE, PRELOAD_N, CRANK_DEG)
def test_every_result_survives_pickling(
    case: CaseDict, share: float, preload: float, angle: float
) -> None:
    """Pickled or written as a file and read again, drive and results are the same to the bit."""

    def again(value: Any) -> Any:
        return pickle.loads(pickle.dumps(value))

    drive = Drive.from_dict(case)
    torque = torque_of(drive, share, preload, angle)
    whole = cbpt.Case.from_dict({**case, "load": {"torque_Nm": torque, "preload_N": preload}})
    for value in [
        drive,
        whole,
        drive.preload(torque, angle),
        drive.preload(torque, angle).drive,
        *drive.findings(),
    ]:
        assert again(value) == value
    assert (again(drive).solve(torque, preload).to_json()) == drive.solve(torque, preload).to_json()
    assert hash(again(drive)) == hash(drive)
    assert hash(again(whole)) == hash(whole)
    assert Drive.from_toml(drive.to_toml()) == drive == copy.deepcopy(drive)
    assert cbpt.Case.from_toml(whole.to_toml()) == whole
    s = drive.solve(torque, preload, angle)
    assert again(s).to_json() == s.to_json()
    assert again(s).input_angle_deg == angle
    assert s.deceleration is not None
    np.testing.assert_array_equal(again(s.deceleration).force_N, s.deceleration.force_N)
    assert s.equal_speed is not None
    np.testing.assert_array_equal(again(s.equal_speed).gap_m, s.equal_speed.gap_m)
    many = solve_many(drive, [torque, 1e9], preload, angle)
    np.testing.assert_array_equal(again(many).elastic_angle_rad, many.elastic_angle_rad)
    np.testing.assert_array_equal(again(many).status, many.status)


def test_the_rest_survives_pickling() -> None:
    """Largest angle, an effect, a solution without numbers, and every error."""
    drive = Drive.from_dict(base_case())
    largest = drive.largest_elastic_angle(5, 600)
    assert largest is not None
    assert pickle.loads(pickle.dumps(largest)) == largest
    refused = drive.solve(50, 600)
    assert pickle.loads(pickle.dumps(refused)).message == refused.message
    effect = {"id": "eccentric_bearing", "u_ref_um": 2, "exponent": 0.9}
    whole = cbpt.Case.from_dict(base_case() | {"effect": [effect]})
    assert pickle.loads(pickle.dumps(whole)) == whole
    assert pickle.loads(pickle.dumps(whole.effects)) == whole.effects != []
    for error in [CbptError("a"), InvalidInputError("b"), CaseError("c")]:
        same = pickle.loads(pickle.dumps(error))
        assert (type(same), same.args) == (type(error), error.args)


# --- input that cannot be -----------------------------------------------------------------


def base_case() -> CaseDict:
    """The base case of the 2017 paper."""
    groove = {"ball_radius_mm": 1.5, "groove_conformity": 1.08, "contact_angle_deg": 45.0}
    return {
        "deceleration": {
            "ball_count": 20,
            "short_amplitude_coefficient": 0.5,
            "rolling_circle_radius_mm": 4.0,
            **groove,
        },
        "equal_speed": {
            "kind": "ring_groove",
            "ball_count": 14,
            "pitch_radius_mm": 40.0,
            **groove,
        },
        "material": {"youngs_modulus_GPa": 208.0, "poissons_ratio": 0.3},
        "load": {"torque_Nm": 5.0, "preload_N": 600.0, "input_angle_deg": 0.0},
    }


def places(case: CaseDict) -> Iterator[tuple[str, str]]:
    for section, keys in case.items():
        for key in keys:
            yield section, key


NO_NUMBERS: list[Any] = ["1.5", "", None, [], [1.0], {}, {"value": 1}, True]
BAD_NUMBERS: dict[str, list[float]] = {
    "torque_Nm": [],
    "input_angle_deg": [],
    "poissons_ratio": [-1, 0.5, 0.7],
    "short_amplitude_coefficient": [0, -0.1, 1, 1.5],
    "groove_conformity": [1, 0.9, 0, -1],
    "contact_angle_deg": [0, -45, 90, 180],
    "ball_count": [0, -20, 2, 20.5, 1001, 2**32 + 20, 2**64, 1e300],
}


@pytest.mark.parametrize(("section", "key"), list(places(base_case())))
def test_each_value_that_cannot_be_is_refused_by_its_key(section: str, key: str) -> None:
    """Whatever stands where a number belongs is told with its key, in the right class."""
    for value in NO_NUMBERS + BAD_NUMBERS.get(key, [0, -1, -1e300]):
        case = base_case()
        case[section][key] = value
        with pytest.raises(CaseError, match=f"{section}.{key}") as caught:
            cbpt.Case.from_dict(case)
        assert isinstance(caught.value, ValueError)
        assert isinstance(caught.value, CbptError)


@pytest.mark.parametrize(("section", "key"), list(places(base_case())))
def test_keys_that_are_missing_or_misspelt_are_told(section: str, key: str) -> None:
    """A required key that is missing, and any key with a letter too many, is named."""
    case = base_case()
    value = case[section].pop(key)
    if section in ("deceleration", "equal_speed") and key != "kind":
        with pytest.raises(CaseError, match=key.split("_")[0]):
            Drive.from_dict(case)
    case[section]["x" + key] = value
    with pytest.raises(CaseError, match="x" + key):
        Drive.from_dict(case)


NOT_FINITE = [math.nan, math.inf, -math.inf, 10**400]


@pytest.mark.parametrize("value", NOT_FINITE, ids=["nan", "inf", "-inf", "10**400"])
def test_a_number_of_a_case_that_is_not_finite_is_a_case_error(value: float) -> None:
    """NaN and infinity have no place in a case, and the message says where they stand."""
    for section, key in places(base_case()):
        if key == "kind":
            continue
        case = base_case()
        case[section][key] = value
        with pytest.raises(CaseError, match=key):
            cbpt.Case.from_dict(case)


@pytest.mark.parametrize("of", [np.float64, np.float32, np.int64, np.uint8])
def test_numbers_of_numpy_are_numbers(of: Callable[[int], Any]) -> None:
    """What numpy makes may stand in a case like what Python makes."""
    case = base_case()
    case["deceleration"]["rolling_circle_radius_mm"] = of(4)
    case["deceleration"]["ball_count"] = of(20)
    assert Drive.from_dict(case) == Drive.from_dict(base_case())


NUMBERS = st.one_of(
    st.floats(),
    st.floats(-10, 1000),
    st.integers(),
    st.sampled_from([0.0, -0.0, 5e-324, 1e-320, 1e308, -1e308, math.nan, math.inf, -math.inf]),
)
ANYTHING = st.recursive(
    st.one_of(NUMBERS, st.none(), st.booleans(), st.text(max_size=8), st.binary(max_size=4)),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)


@examples(200)
@given(st.data())
def test_no_case_makes_a_panic(data: st.DataObject) -> None:
    """Any value in any place is read or refused; what is read solves or says why not."""
    case = base_case()
    for section, key in data.draw(
        st.lists(st.sampled_from(list(places(case))), min_size=1, max_size=3)
    ):
        value = data.draw(ANYTHING)
        if key == "ball_count" and isinstance(value, (int, float)) and value > 60:
            value = 60
        case[section][key] = value
    if data.draw(st.booleans()):
        case[data.draw(st.text(max_size=8))] = data.draw(ANYTHING)
    try:
        whole = cbpt.Case.from_dict(case)
    except CaseError:
        return
    drive = whole.drive
    s = drive.solve(1.0, 600)
    angle = s.elastic_angle_rad
    assert s.has_solution == (angle is not None)
    assert angle is None or math.isfinite(angle)
    assert repr(drive)
    assert repr(s)
    assert pickle.loads(pickle.dumps(whole)) == whole
    drive.preload(1.0, 0.0)
    drive.findings(1.0, 600)


@examples(200)
@given(ANYTHING)
def test_what_is_no_case_is_refused(value: Any) -> None:
    """A dict, or a text, that is no case is a CaseError; what is neither is a TypeError."""
    for read in (Drive.from_dict, cbpt.Case.from_dict):
        with pytest.raises(CaseError if isinstance(value, dict) else TypeError):
            read(value)
    for read_text in (Drive.from_toml, cbpt.Case.from_toml):
        with pytest.raises(CaseError if isinstance(value, str) else TypeError):
            read_text(value)


BEYOND_READING = {
    "a dict in itself": "case['deceleration'] = case",
    "a list in itself": "case['effect'] = x = []; x.append(x)",
    "very deep": "for _ in range(200_000): case = {'deceleration': case}",
    "a number too long to write": "case['load'] = {'torque_Nm': 10**5000}",
    "its own item": "case['load'] = type('Own', (), {'item': lambda self: self})()",
    "one list a million million times": "for _ in range(6): case = {'effect': [case] * 100}",
    "a key that is no text": "case[10**5000] = 1",
    "half a character": "case['\\ud800'] = '\\ud800'",
}


@pytest.mark.parametrize("make", BEYOND_READING.values(), ids=BEYOND_READING.keys())
def test_a_case_beyond_reading_is_a_case_error(make: str) -> None:
    """In a process of its own, because a stack that overflows takes the interpreter with it."""
    lines = [
        "import cbpt",
        "case = {}",
        make,
        "try: cbpt.Case.from_dict(case)",
        "except cbpt.CaseError: print('refused')",
    ]
    command = [sys.executable, "-c", "\n".join(lines)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "refused\n", "")


def test_what_is_beyond_reading_is_told_by_its_place() -> None:
    inside: CaseDict = {}
    inside["deceleration"] = inside
    with pytest.raises(CaseError, match=r"^(deceleration\.){7}deceleration: found more than 8 lev"):
        cbpt.Case.from_dict(inside)
    with pytest.raises(CaseError, match=r"^load\.torque_Nm = .*a number beyond all range"):
        cbpt.Case.from_dict({**base_case(), "load": {"torque_Nm": 10**5000}})
    longdouble = np.longdouble(20)  # whose item is itself
    with pytest.raises(CaseError, match=r"^load\.torque_Nm: found a value of type longdouble"):
        cbpt.Case.from_dict({**base_case(), "load": {"torque_Nm": longdouble}})
    with pytest.raises(CaseError, match=r"^deceleration: found a key of type int"):
        cbpt.Case.from_dict({"deceleration": {3: 4}})


def test_half_a_character_is_told_by_its_line() -> None:
    for read in (Drive.from_toml, cbpt.Case.from_toml):
        with pytest.raises(CaseError, match=r"^<text>:2: found a lone surrogate"):
            read("# é\nkind = '\ud800'")


@examples(150)
@given(st.data())
def test_no_text_makes_a_panic(data: st.DataObject) -> None:
    """A case file with a piece cut out, doubled or replaced is read or refused by line."""
    text = cbpt.example_case()
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 40)))
    piece = data.draw(st.one_of(st.just(""), st.just(text[start:end] * 2), st.text(max_size=12)))
    try:
        whole = cbpt.Case.from_toml(text[:start] + piece + text[end:])
    except CaseError as error:
        assert "<text>" in str(error)
    else:
        # The counts of balls may have become large, so nothing is solved here.
        assert cbpt.Case.from_toml(whole.to_toml()) == whole


@examples(300)
@given(NUMBERS, NUMBERS, NUMBERS)
def test_no_load_makes_a_panic(torque: float, preload: float, angle: float) -> None:
    """Finite torque and angle and a finite preload above 0 are a load; all else is refused."""
    drive = BASE

    def size(value: float) -> float:
        try:
            return float(value)
        except OverflowError:
            return math.inf

    torque_is, preload_is, angle_is = size(torque), size(preload), size(angle)
    valid = math.isfinite(torque_is) and math.isfinite(angle_is)
    valid = valid and 0 < preload_is < math.inf
    if not valid:
        refused = (InvalidInputError, OverflowError)
        with pytest.raises(refused):
            drive.solve(torque, preload, angle)
        with pytest.raises(refused):
            solve_many(drive, [1.0, torque], preload, angle)
        return
    s = drive.solve(torque, preload, angle)
    many = solve_many(drive, torque, preload, angle)
    assert many.status == s.status
    if s.has_solution:
        assert s.elastic_angle_rad is not None
        assert math.isfinite(s.elastic_angle_rad)
        assert many.elastic_angle_rad == pytest.approx(s.elastic_angle_rad, rel=1e-12)
    else:
        assert s.elastic_angle_rad is None
        assert np.isnan(many.elastic_angle_rad)
    assert s.message
    assert repr(s)
    json.loads(s.to_json())
    drive.preload(torque, angle)


@examples(100)
@given(ANYTHING)
def test_an_argument_of_another_type_is_refused(value: Any) -> None:
    if isinstance(value, (int, float)):
        return
    for call in (
        lambda: BASE.solve(value, 600),
        lambda: BASE.solve(5, value),
        lambda: BASE.solve(5, 600, value),
        lambda: BASE.preload(value),
        lambda: BASE.largest_elastic_angle(5, value),
    ):
        with pytest.raises(TypeError):
            call()


def test_a_load_that_cannot_be_is_named() -> None:
    """The message names the number, with its place where there are many."""
    for bad in (math.nan, math.inf, -math.inf):
        with pytest.raises(InvalidInputError, match="torque_Nm"):
            BASE.solve(bad, 600)
        with pytest.raises(InvalidInputError, match="torque_Nm"):
            BASE.preload(bad)
        with pytest.raises(InvalidInputError, match="input_angle"):
            BASE.solve(5, 600, bad)
        with pytest.raises(InvalidInputError, match=r"torque_Nm\[2\]"):
            solve_many(BASE, [1, 2, bad], 600)
    for bad in (0.0, -600.0, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="preload_N"):
            BASE.solve(5, bad)
        with pytest.raises(InvalidInputError, match="preload_N"):
            BASE.largest_elastic_angle(5, bad)
        with pytest.raises(InvalidInputError, match=r"preload_N\[1\]"):
            solve_many(BASE, 5, [600, bad])
    with pytest.raises(ValueError, match="broadcast"):
        solve_many(BASE, [1, 2], [1, 2, 3])


def test_the_search_for_the_largest_angle_can_be_interrupted() -> None:
    """With a thousand balls it takes seconds."""
    case = base_case()
    case["deceleration"]["ball_count"] = 1000
    case["equal_speed"] |= {"ball_count": 999, "pitch_radius_mm": 3000}
    drive = Drive.from_dict(case)
    ctrl_c = threading.Timer(0.05, _thread.interrupt_main)
    start = time.monotonic()
    ctrl_c.start()
    with pytest.raises(KeyboardInterrupt):
        drive.largest_elastic_angle(1, 600)
    assert time.monotonic() - start < 1


def test_a_bad_load_of_a_grid_is_named_by_its_place() -> None:
    torque = np.array([[1.0], [2.0], [math.nan]])
    with pytest.raises(InvalidInputError, match=r"^torque_Nm\[2, 0\] = NaN"):
        solve_many(BASE, torque, [600, 700])
    with pytest.raises(InvalidInputError, match=r"^preload_N\[0, 1, 1\] = -1"):
        solve_many(BASE, torque[:2], [[[600, 700], [600, -1]]])
    with pytest.raises(InvalidInputError, match=r"^preload_N = 0"):
        solve_many(BASE, 1, 0)


def test_no_part_of_a_number_is_dropped() -> None:
    """numpy would drop imaginary parts with a warning, and masks without one."""
    with pytest.raises(InvalidInputError, match=r"^torque_Nm is complex"):
        solve_many(BASE, np.array([1, 2j]), 600)
    with pytest.raises(InvalidInputError, match=r"^input_angle_deg is complex"):
        solve_many(BASE, 1, 600, [0, 1j])
    masked = np.ma.masked_greater(np.array([[1.0, 2.0], [3.0, 99.0]]), 50)
    with pytest.raises(InvalidInputError, match=r"^torque_Nm\[1, 1\] is masked"):
        solve_many(BASE, masked, 600)
    with pytest.raises(InvalidInputError, match=r"^preload_N is masked"):
        solve_many(BASE, 1, np.ma.masked)
    np.testing.assert_array_equal(
        solve_many(BASE, masked[0], 600).elastic_angle_rad,
        solve_many(BASE, [1, 2], 600).elastic_angle_rad,
    )


BASE = Drive.from_dict(base_case())


# --- agreement with the reference model ---------------------------------------------------


def why_no_drive(drive: CaseDict) -> str | None:
    """Why the two pairs of a drive of the file cannot belong to one `Drive`."""
    first, second = drive["deceleration"], drive["equal_speed"]
    eccentricity = first["short_amplitude"] * first["rolling_radius_m"]
    if first["material"] != second["material"]:
        return "its pairs differ in material"
    if drive["equal_speed_pair"] == "ring_groove" and not math.isclose(
        second["ring_radius_m"], eccentricity
    ):
        return "its ring radius is not the eccentricity"
    return None


def case_of_the_reference(drive: CaseDict) -> CaseDict:
    """A drive of the file as a case."""
    first, second = drive["deceleration"], drive["equal_speed"]
    ring = drive["equal_speed_pair"] == "ring_groove"
    material = first["material"]
    return {
        "track_curvature": first["track_curvature"],
        "material": {
            "ball_youngs_modulus_Pa": material["ball_modulus_Pa"],
            "ball_poissons_ratio": material["ball_poisson"],
            "plate_youngs_modulus_Pa": material["plate_modulus_Pa"],
            "plate_poissons_ratio": material["plate_poisson"],
        },
        "deceleration": {
            "ball_count": first["ball_count"],
            "short_amplitude_coefficient": first["short_amplitude"],
            "rolling_circle_radius_m": first["rolling_radius_m"],
            "ball_radius_m": first["ball_radius_m"],
            "groove_conformity": first["conformity"],
            "contact_angle_rad": first["contact_angle_rad"],
            "output_plate": first["output"],
        },
        "equal_speed": {
            "kind": drive["equal_speed_pair"],
            "ball_count": second["ball_count"],
            "pitch_radius_m": second["pitch_radius_m"],
            "ball_radius_m": second["ball_radius_m"],
            "groove_conformity": second["conformity"],
            **(
                {
                    "outside_contact_angle_rad": second["contact_angle_outside_rad"],
                    "inside_contact_angle_rad": second["contact_angle_inside_rad"],
                }
                if ring
                else {"contact_angle_rad": second["contact_angle_rad"]}
            ),
        },
    }


# By name, so that no drive goes missing unseen; the Rust test compares these too, pair by pair.
NO_DRIVE = {
    "5 and 9 balls, no inside wall, crank at 0.45 rad": "its ring radius is not the eccentricity",
    "5 and 9 balls, no inside wall, crank at -1.3 rad": "its ring radius is not the eccentricity",
    "8 and 9 balls, odd cross-slide, ceramic, crank at 0.2 rad": "its pairs differ in material",
    "8 and 9 balls, odd cross-slide, ceramic, crank at 4 rad": "its pairs differ in material",
    "33 and 8 balls, unlike angles, crank at 0.9 rad": "its ring radius is not the eccentricity",
}


@pytest.mark.parametrize("expected", REFERENCE["drives"], ids=lambda drive: drive["id"])
def test_whole_drives_agree_with_the_reference(expected: CaseDict) -> None:
    """Angles, statuses and thresholds of an independent model, to 1e-8."""
    if expected["id"] in NO_DRIVE:
        pytest.skip(NO_DRIVE[expected["id"]])
    drive = Drive.from_dict(case_of_the_reference(expected))
    crank = math.degrees(expected["crank_angle_rad"])
    assert drive.transmission_ratio == pytest.approx(expected["ratio"], rel=1e-14)
    for load in expected["solutions"]:
        s = drive.solve(load["torque_Nm"], load["preload_N"], crank)
        if load["status"] == "refused":
            assert (s.status, s.elastic_angle_rad) == ("beyond_hold", None)
            assert s.hold_preload_N == pytest.approx(load["preload_that_holds_N"], rel=1e-8)
            continue
        assert s.status == load["status"]
        assert s.deceleration is not None
        assert s.equal_speed is not None
        assert s.alpha_equal_speed_arcsec is not None
        for found, name in [
            (s.elastic_angle_rad, "total_rad"),
            (s.deceleration.angle_rad, "deceleration_rad"),
            (s.equal_speed.angle_rad, "equal_speed_rad"),
            (s.alpha_equal_speed_arcsec * ARCSEC, "equal_speed_at_output_rad"),
        ]:
            assert found == pytest.approx(load[name], rel=1e-8, abs=load["floor_rad"]), name
    limits = [(expected["limits"], crank), (expected["limits_over_period"], None)]
    for limit, angle in limits:
        if limit is not None:
            thresholds = drive.preload(limit["torque_Nm"], angle).drive
            for name in ("hold_N", "continuous_N", "zero_backlash_N"):
                assert getattr(thresholds, name) == pytest.approx(limit[name], rel=1e-8), name


def test_only_what_is_no_drive_is_left_to_the_rust_test() -> None:
    reasons = {drive["id"]: why_no_drive(drive) for drive in REFERENCE["drives"]}
    assert {name: why for name, why in reasons.items() if why} == NO_DRIVE
