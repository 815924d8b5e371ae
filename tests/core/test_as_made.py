"""Parts as they were made against closed forms (a turned groove, one harmonic, one large ball,
turned rings, a shifted plate), against the effects of the library; thresholds of the preload.

The tables are lists here; files are in test_as_made_tables.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt._core import ball_loads
from cbpt.design.judge import at_load, judge

Floats = NDArray[np.float64]
CRANKS_DEG = np.array([0.0, 7.3, 45.0, 123.4, 360.0, 2000.5])
K, R0_MM, Z2, BETA = 0.5, 4.0, 20, math.radians(45)
R_M, E_M = Z2 * R0_MM * 1e-3, K * R0_MM * 1e-3
OUTPUTS = ["hypocycloid", "epicycloid"]


def case(
    as_made: dict[str, Any], output: str = "hypocycloid", track: str = "neglect", **more: Any
) -> cbpt.Case:
    groove = {"ball_radius_mm": 1.5, "groove_conformity": 1.08, "contact_angle_deg": 45.0}
    sections: dict[str, Any] = {
        "track_curvature": track,
        "deceleration": {
            "ball_count": Z2,
            "short_amplitude_coefficient": K,
            "rolling_circle_radius_mm": R0_MM,
            "output_plate": output,
            **groove,
        },
        "equal_speed": {
            "kind": "ring_groove",
            "ball_count": 14,
            "pitch_radius_mm": 40.0,
            **groove,
        },
        **more,
    }
    return cbpt.Case.from_dict(sections | ({"as_made": as_made} if as_made else {}))


def profile(groove: str, deviation_m: Any, rows: int = 7200) -> dict[str, Any]:
    t = 2 * np.pi * np.arange(rows) / rows
    return {
        f"{groove}_groove_angle_rad": t.tolist(),
        f"{groove}_deviation_m": np.asarray(deviation_m(t)).tolist(),
    }


def rotation(of: cbpt.Case, torque: float = 0.0, cranks: Any = CRANKS_DEG) -> cbpt.Angles:
    return cbpt.solve_many(of, torque, 600.0, cranks)


def lobes(groove: str) -> int:
    return Z2 - 1 if groove == "epicycloid" else Z2 + 1


def track(groove: str, t: Floats) -> Floats:
    """The groove in its plate: MODEL's equations, shape (2, n)."""
    sign = -1.0 if groove == "epicycloid" else 1.0
    return np.array(
        [R_M * np.cos(t) + sign * E_M * np.cos(Z2 * t), R_M * np.sin(t) - E_M * np.sin(Z2 * t)]
    )


def outward(groove: str, t: Floats) -> Floats:
    """Its normal away from the centre, by the equation's own derivative, shape (2, n)."""
    sign = -1.0 if groove == "epicycloid" else 1.0
    along = np.array(
        [
            -R_M * np.sin(t) - sign * Z2 * E_M * np.sin(Z2 * t),
            R_M * np.cos(t) - Z2 * E_M * np.cos(Z2 * t),
        ]
    )
    normal = np.array([along[1], -along[0]]) / np.hypot(*along)
    return np.asarray(normal * np.sign(np.sum(normal * track(groove, t), axis=0)))


# --- rigid motions, exact at any size -----------------------------------------------------


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("groove", ["epicycloid", "hypocycloid"])
@pytest.mark.parametrize("torque", [0.0, 4.0])
def test_a_turned_groove_turns_the_output(output: str, groove: str, torque: float) -> None:
    """A groove turned by a small angle deviates by (turn x place) . normal everywhere; the output
    follows by the ratio of the lobes, the same at every crank angle and load."""
    turn = 2e-5

    def deviation(t: Floats) -> Floats:
        x, y = track(groove, t)
        return np.asarray(turn * np.sum(np.array([-y, x]) * outward(groove, t), axis=0))

    made = rotation(case(profile(groove, deviation), output), torque)
    nominal = rotation(case({}, output), torque)
    moved = made.alpha_deceleration_rad - nominal.alpha_deceleration_rad
    share = lobes(groove) / lobes(output)
    # Alpha is counted clockwise. Turning the output's own groove turns the output back.
    sign = 1.0 if groove == output else -1.0
    assert np.abs(moved) == pytest.approx(turn * share, rel=1e-5)
    assert np.all(np.sign(moved) == np.sign(moved[0]))
    assert np.sign(moved[0]) == sign


@pytest.mark.parametrize("output", OUTPUTS)
def test_turned_rings_turn_the_output(output: str) -> None:
    turn, rings, rows = 2e-5, 14, 720
    about = 2 * np.pi * np.arange(rows) / rows
    places = 2 * np.pi * np.arange(rings) / rings
    deviation = [turn * 0.04 * np.sin(about - place) for place in places]
    made = {
        "planet_ring": np.repeat(np.arange(rings), rows).tolist(),
        "planet_ring_angle_rad": np.tile(about, rings).tolist(),
        "planet_ring_deviation_m": np.concatenate(deviation).tolist(),
    }
    for torque in (0.0, 4.0):
        found = rotation(case(made, output), torque).alpha_equal_speed_rad
        nominal = rotation(case({}, output), torque).alpha_equal_speed_rad
        assert np.abs(found - nominal) == pytest.approx(turn, rel=1e-6)


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("groove", ["epicycloid", "hypocycloid"])
def test_a_shifted_plate_is_a_profile(output: str, groove: str) -> None:
    shift = np.array([3e-6, -2e-6])
    by_plate = case({f"{groove}_plate_offset_um": [3.0, -2.0]}, output, "exact")
    by_table = case(profile(groove, lambda t: shift @ outward(groove, t)), output, "exact")
    first, second = (rotation(each, 3.0).alpha_deceleration_rad for each in (by_plate, by_table))
    assert first == pytest.approx(second, rel=1e-5)


# --- one harmonic -------------------------------------------------------------------------


def arms(phase: float) -> Floats:
    phi = phase + 2 * np.pi * np.arange(Z2) / Z2
    return np.asarray((Z2 + 1) * E_M * np.sin(phi) / np.sqrt(1 + K * K - 2 * K * np.cos(phi)))


@pytest.mark.parametrize("groove", ["epicycloid", "hypocycloid"])
def test_one_harmonic_on_one_groove(groove: str) -> None:
    """With one stiffness for all contacts a small p turns the output by -sum(a p)/sum(a^2)."""
    size, h = 1e-10, 3
    found = rotation(case(profile(groove, lambda t: size * np.cos(h * t)))).alpha_deceleration_rad
    for crank, angle in zip(np.deg2rad(CRANKS_DEG), found, strict=True):
        phi = -crank * (Z2 - 1) / Z2
        a, ball = arms(phi), phi + 2 * np.pi * np.arange(Z2) / Z2
        of_epicycloid = groove == "epicycloid"
        t = ball + crank * (1.0 if of_epicycloid else (Z2 - 1) / (Z2 + 1))
        p = size * np.cos(h * t) * (1.0 if of_epicycloid else -1.0)
        assert angle == pytest.approx(-(a @ p) / (a @ a), rel=2e-5, abs=1e-6 * size / E_M)


def test_its_order_is_that_of_the_crank() -> None:
    """Of the fixed groove a wave h makes the orders h and Z1 - h of the crank; the first has the
    amplitude c b_h / (2 Zo e mean(s^2)), s = sin(phi)/sqrt(D), b_h its Fourier coefficient."""
    size, h = 1e-10, 3
    drive = case(profile("epicycloid", lambda t: size * np.cos(h * t)))
    cranks = np.arange(256) * 360.0 / 256
    spectrum = 2 * np.abs(np.fft.rfft(rotation(drive, cranks=cranks).alpha_deceleration_rad)) / 256
    phi = 2 * np.pi * np.arange(4096) / 4096
    s = np.sin(phi) / np.sqrt(1 + K * K - 2 * K * np.cos(phi))
    b = 2 * np.mean(s * np.sin(h * phi))
    assert spectrum[h] == pytest.approx(size * b / (2 * (Z2 + 1) * E_M * np.mean(s * s)), rel=1e-3)
    largest = set(np.argsort(spectrum)[-2:])
    assert largest <= {h, Z2 - 1 - h, Z2 - 1 + h, 2 * (Z2 - 1) - h}


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize(("groove", "prefix"), [("fixed", ""), ("planet", "planet_")])
def test_a_table_is_what_the_effect_says(output: str, groove: str, prefix: str) -> None:
    """The pitch error of the library, whose sign on the planet is that of p itself."""
    fixed = "epicycloid" if output == "hypocycloid" else "hypocycloid"
    other = next(name for name in OUTPUTS if name != fixed)
    sign, name = (1.0, fixed) if groove == "fixed" else (-1.0, other)
    made = case(profile(name, lambda t: sign * 2e-6 * np.sin(4 * t)), output, "exact")
    effect = {"id": "groove_pitch_error", "harmonic": 4, f"{prefix}sine_um": 2.0}
    by_effect = case({}, output, "exact", effect=[effect])
    first, second = rotation(made, 3.0), rotation(by_effect, 3.0)
    assert first.elastic_angle_rad == pytest.approx(second.elastic_angle_rad, rel=1e-6)


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("plate", ["fixed_plate", "output_plate"])
@pytest.mark.parametrize("torque", [0.0, 4.0, 20.0])
def test_a_tilted_plate_is_what_the_effect_says(output: str, plate: str, torque: float) -> None:
    """Alone in its pair, at every crank angle of several turns."""
    fixed = "epicycloid" if output == "hypocycloid" else "hypocycloid"
    name = f"{fixed}_plate" if plate == "fixed_plate" else "ring_plate"
    made = case({f"{name}_tilt_urad": [30.0, -50.0]}, output)
    tilt = {f"{plate}_tilt_cosine_urad": 30.0, f"{plate}_tilt_sine_urad": -50.0}
    by_effect = case({}, output, effect=[{"id": "plate_tilt", **tilt}])
    first, second = (rotation(each, torque).elastic_angle_rad for each in (made, by_effect))
    assert first == pytest.approx(second, rel=1e-9, abs=1e-15)
    if torque:
        nominal = rotation(case({}, output), torque).elastic_angle_rad
        assert np.min(np.abs(first - nominal)) > 1e-7


@pytest.mark.parametrize("output", OUTPUTS)
def test_both_plates_together_are_the_tilt_of_both_pairs(output: str) -> None:
    """At crank angle 0; further on the plate of the output turns away from the housing."""

    def tilted(*stems: str) -> cbpt.Case:
        tilt = {f"{stem}_tilt_{part}_urad": 40.0 for stem in stems for part in ("cosine", "sine")}
        return case({}, output, effect=[{"id": "plate_tilt", **tilt}])

    cranks = np.array([0.0, 45.0])
    each = rotation(tilted("fixed_plate", "output_plate"), 4.0, cranks).elastic_angle_rad
    both = rotation(tilted("housing"), 4.0, cranks).elastic_angle_rad
    assert each[0] == pytest.approx(both[0], rel=1e-9)
    assert each[1] != pytest.approx(both[1], rel=1e-6)


# --- balls --------------------------------------------------------------------------------


def diameters(**oversize_um: float) -> dict[str, Any]:
    sizes = np.full(Z2, 3.0)
    for ball, oversize in oversize_um.items():
        sizes[int(ball[1:])] += oversize * 1e-3
    return {"deceleration_ball_diameter_mm": sizes.tolist()}


def test_a_large_ball_is_what_the_effect_says() -> None:
    made = case(diameters(b4=1.5), track="exact")
    effect = {"id": "ball_diameter_lot", "ball": 4, "oversize_um": 1.5}
    by_effect = case({}, track="exact", effect=[effect])
    first, second = rotation(made, 3.0), rotation(by_effect, 3.0)
    assert first.elastic_angle_rad == pytest.approx(second.elastic_angle_rad, rel=1e-9)


def stiffness() -> float:
    """k of a diagonal, N/m^1.5, from N_Z = 2 Z2 k (d sin beta)^1.5 sin beta."""
    solution = case({}).drive.solve(0.0, 600.0)
    assert solution.deceleration is not None
    squeezed = solution.deceleration.approach_m * math.sin(BETA)
    return 600.0 / (2 * Z2 * math.pow(squeezed, 1.5) * math.sin(BETA))


@pytest.mark.parametrize("oversize_um", [0.5, 3.0, -1.0, 30.0])
def test_one_large_ball_carries_more(oversize_um: float) -> None:
    """Its two diagonals are pressed alike, so it turns nothing; the preload is shared by
    2 k sin beta [(x + g)^1.5 + (Z2 - 1) x^1.5] = N_Z, x = d sin beta, each bracket at least 0."""
    drive = case(diameters(b7=oversize_um)).drive
    found = ball_loads(drive, 0.0, 600.0, np.deg2rad(CRANKS_DEG))
    k, g = stiffness(), oversize_um * 1e-6

    def carried(x: float) -> tuple[float, float]:
        force = 2 * k * math.sin(BETA)
        return force * max(x + g, 0.0) ** 1.5, force * max(x, 0.0) ** 1.5

    low, high = -40e-6, 40e-6
    for _ in range(200):
        x = 0.5 * (low + high)
        large, other = carried(x)
        low, high = (x, high) if large + (Z2 - 1) * other < 600.0 else (low, x)
    assert found[0][:, 7] == pytest.approx(large, rel=1e-9)
    assert np.delete(found[0], 7, axis=1) == pytest.approx(other, rel=1e-9, abs=1e-9)
    if oversize_um < 30:  # alone, it leaves the output free to turn
        assert rotation(case(diameters(b7=oversize_um))).alpha_deceleration_rad == pytest.approx(
            0.0, abs=1e-15
        )


def test_a_large_ball_turns_the_output_as_often_as_it_comes_round() -> None:
    """With curved tracks its two diagonals differ, so it does turn the output: with the ball ring,
    Z1/Z2 times a turn of the crank."""
    drive = case(diameters(b7=1.0), track="exact")
    turns = 20
    cranks = np.arange(160 * turns) * 360.0 / 160
    curve = rotation(drive, cranks=cranks).alpha_deceleration_rad
    spectrum = 2 * np.abs(np.fft.rfft(curve)) / len(curve)
    lines = np.flatnonzero(spectrum > 1e-3 * spectrum[1:].max())
    assert len(lines) >= 2
    assert np.all(lines % 19 == 0)


# --- thresholds ---------------------------------------------------------------------------


def test_what_seats_the_balls_beside_a_large_one() -> None:
    """Until the others touch the large one carries all: N = 2 k g^1.5 sin beta."""
    drive = case(diameters(b7=2.0)).drive
    seating = drive.preload(0.0, 10.0).deceleration
    expected = 2 * stiffness() * (2e-6) ** 1.5 * math.sin(BETA)
    assert seating.hold_N == 0.0
    assert seating.continuous_N == pytest.approx(expected, rel=1e-8)
    assert seating.zero_backlash_N == pytest.approx(expected, rel=1e-8)


def test_nearly_nominal_parts_have_the_nominal_thresholds() -> None:
    made = case(diameters(b7=1e-7), track="exact").drive
    for torque in (5.0, -3.0):
        found, nominal = (drive.preload(torque, 33.0).drive for drive in (made, made.nominal()))
        assert found.hold_N == nominal.hold_N
        assert found.continuous_N == pytest.approx(nominal.continuous_N, rel=1e-3)
        assert found.zero_backlash_N == pytest.approx(nominal.zero_backlash_N, rel=1e-3)


def test_at_the_threshold_the_first_meshing_point_parts() -> None:
    drive = case(
        diameters(b7=1.0, b2=-0.7) | profile("epicycloid", lambda t: 1e-6 * np.cos(2 * t)),
        track="exact",
    ).drive
    needed = drive.preload(5.0, 40.0).deceleration.zero_backlash_N
    carrying = []
    for preload in (needed * 0.999, needed * 1.001):
        solution = drive.solve(5.0, preload, 40.0)
        assert solution.deceleration is not None
        carrying.append(solution.deceleration.carrying)
    assert carrying == [2 * Z2 - 1, 2 * Z2]


# --- the case -----------------------------------------------------------------------------


def test_the_case_reads_back_the_same() -> None:
    made = case(
        diameters(b7=1.0)
        | profile("hypocycloid", lambda t: 1e-6 * np.sin(t), 90)
        | {"ring_plate_tilt_urad": [3.0, 0.0], "epicycloid_plate_offset_um": [0.0, 1.0]}
    )
    again = cbpt.Case.from_toml(made.to_toml())
    assert again == made and again.drive == made.drive and again.drive.has_parts_as_made
    assert again != case({}) and not again.drive.nominal().has_parts_as_made
    assert again.drive.nominal() == case({}).drive


def test_polar_angles_are_those_about_the_centre_of_the_plate() -> None:
    t = 2 * np.pi * np.arange(3600) / 3600
    x, y = track("epicycloid", t)
    polar = np.unwrap(np.arctan2(y, x))
    by_polar = {
        "epicycloid_polar_angle_rad": polar.tolist(),
        "epicycloid_deviation_m": (1e-6 * np.cos(5 * t)).tolist(),
    }
    first = rotation(case(by_polar), 3.0).alpha_deceleration_rad
    second = rotation(
        case(profile("epicycloid", lambda t: 1e-6 * np.cos(5 * t), 3600)), 3.0
    ).alpha_deceleration_rad
    assert first == pytest.approx(second, rel=1e-9)


@pytest.mark.parametrize("output", OUTPUTS)
def test_it_repeats_after_the_turns_it_says(output: str) -> None:
    made = (
        profile("epicycloid", lambda t: 1e-6 * np.cos(2 * t), 360)
        | profile("hypocycloid", lambda t: 1e-6 * np.sin(t), 360)
        | diameters(b3=1.0)
    )
    drive = case(made, output, "exact")
    turns = drive.drive.repetition_turns
    assert turns == (420 if output == "hypocycloid" else 380)
    cranks = np.array([11.0, 100.0])
    first = rotation(drive, 3.0, cranks).elastic_angle_rad
    assert rotation(drive, 3.0, cranks + 360.0 * turns).elastic_angle_rad == pytest.approx(
        first, rel=1e-9
    )
    for sooner in (turns // 2, turns // 5, turns // 3, turns // 7, turns // 19):
        moved = rotation(drive, 3.0, cranks + 360.0 * sooner).elastic_angle_rad
        if turns % max(sooner, 1) == 0:
            assert np.any(np.abs(moved - first) > 1e-9)


def test_a_cross_slide_has_balls_of_two_rows() -> None:
    slide = {"kind": "cross_slide", "ball_count": 16, "pitch_radius_mm": 40.0}
    groove = {"ball_radius_mm": 1.5, "groove_conformity": 1.08, "contact_angle_deg": 45.0}
    sizes = np.full(32, 3.0)
    nominal = case({}, equal_speed=slide | groove)
    same = case({"equal_speed_ball_diameter_mm": sizes.tolist()}, equal_speed=slide | groove)
    assert rotation(same, 3.0).elastic_angle_rad == pytest.approx(
        rotation(nominal, 3.0).elastic_angle_rad, rel=1e-9
    )
    sizes[3] += 1e-3
    first = case({"equal_speed_ball_diameter_mm": sizes.tolist()}, equal_speed=slide | groove)
    second = case(
        {"equal_speed_ball_diameter_mm": np.roll(sizes, 16).tolist()}, equal_speed=slide | groove
    )
    in_first, in_second = (rotation(each, 3.0).elastic_angle_rad for each in (first, second))
    assert in_first == pytest.approx(in_second, rel=1e-9)
    assert np.all(np.abs(in_first - rotation(nominal, 3.0).elastic_angle_rad) > 1e-12)


# --- friction of the parts as made ---------------------------------------------------------


@pytest.mark.parametrize("output", OUTPUTS)
def test_friction_has_the_forces_of_the_parts_as_made(output: str) -> None:
    made = case(diameters(b3=2.0), output).drive
    found = made.friction(4.0, 600.0, 33.0)
    solved = made.solve(4.0, 600.0, 33.0)
    for name, pair in (("deceleration", solved.deceleration), ("equal_speed", solved.equal_speed)):
        assert pair is not None
        listed = [contact.force_N for contact in found.contacts if contact.pair == name]
        # Each loaded diagonal has a contact with either plate.
        expected = np.repeat(pair.force_N[pair.force_N > 0], 2)
        assert np.sort(listed) == pytest.approx(np.sort(expected), rel=1e-12)
    nominal = made.nominal().friction(4.0, 600.0, 33.0)
    assert found.friction_torque_Nm != pytest.approx(nominal.friction_torque_Nm, rel=1e-4)


def test_nearly_nominal_parts_rub_like_nominal_ones() -> None:
    made = case(diameters(b3=1e-6)).drive
    for angle in (None, 33.0):
        one, other = (drive.friction(4.0, 600.0, angle) for drive in (made, made.nominal()))
        assert one.friction_torque_Nm == pytest.approx(other.friction_torque_Nm, rel=1e-5)


def test_the_mean_over_the_turns_is_that_of_single_angles() -> None:
    """At angles that have nothing in common with the places that are summed up."""
    made = case(diameters(b3=2.0)).drive
    found = made.friction(4.0, 600.0)
    turns = made.repetition_turns
    angles = 360.0 * turns * np.arange(397) / 397 + 0.123
    rows = [made.friction(4.0, 600.0, float(angle)).friction_torque_Nm or 0.0 for angle in angles]
    assert found.friction_torque_Nm == pytest.approx(np.mean(rows), rel=2e-3)
    assert found.ripple_Nm is not None and found.ripple_Nm > 0.5 * np.ptp(rows)


def test_a_map_of_the_preload_has_the_parts_as_made() -> None:
    """A design that only has another load is the same drive; with other balls it is not."""
    of = case(diameters(b3=2.0))
    whole = at_load(of, 4.0, 600.0, 33.0)
    rows = judge(whole, ["load.preload_N"], np.array([[600.0], [900.0]]), coefficient=0.1)
    expected = [of.drive.friction(4.0, n, 33.0).friction_torque_Nm for n in (600.0, 900.0)]
    assert rows["friction_torque_Nm"] == pytest.approx(expected, rel=1e-12)
    radius = judge(whole, ["deceleration.ball_radius_m"], np.array([[1.5e-3]]), coefficient=0.1)
    nominal = of.drive.nominal().friction(4.0, 600.0, 33.0).friction_torque_Nm
    assert radius["friction_torque_Nm"] == pytest.approx([nominal], rel=1e-12)


# --- strength of the parts as made ---------------------------------------------------------


@pytest.mark.parametrize("output", OUTPUTS)
def test_static_safety_is_that_of_the_worst_angle_of_the_parts_as_made(output: str) -> None:
    made = case(diameters(b3=2.0), output)
    found = cbpt.friction(made, torque_Nm=4.0, preload_N=600.0)
    places = min(made.drive.repetition_turns * 8 * Z2, 4096)
    angles = 2 * np.pi * made.drive.repetition_turns * np.arange(places) / places
    whole = at_load(made, 4.0, 600.0)
    rows = judge(whole, ["load.input_angle_rad"], angles[:, None], pressures=True)
    assert found.static_safety == pytest.approx(rows["static_safety"].min(), rel=1e-9)
    nominal = cbpt.friction(made.nominal(), torque_Nm=4.0, preload_N=600.0)
    assert found.static_safety < 0.9 * nominal.static_safety


def test_nearly_nominal_parts_are_as_safe_as_nominal_ones() -> None:
    made = case(diameters(b3=1e-6))
    one, other = (
        cbpt.friction(of, torque_Nm=4.0, preload_N=600.0, static_safety=2.0)
        for of in (made, made.nominal())
    )
    assert one.static_safety == pytest.approx(other.static_safety, rel=1e-3)
    assert one.largest_torque_Nm == pytest.approx(other.largest_torque_Nm, rel=1e-3)
    assert one.preload_window_N == pytest.approx(other.preload_window_N, rel=1e-3)


def test_window_and_largest_torque_of_the_parts_as_made_meet_the_safety_they_are_for() -> None:
    made = case(diameters(b3=8.0))
    found = cbpt.friction(made, torque_Nm=4.0, preload_N=600.0, static_safety=2.0)
    assert found.preload_window_N is not None and found.largest_torque_Nm is not None
    least, largest = found.preload_window_N
    assert least == pytest.approx(made.drive.preload(4.0).drive.continuous_N, rel=1e-9)
    for torque, preload in ((4.0, largest), (found.largest_torque_Nm, 600.0)):
        at_end = cbpt.friction(made, torque_Nm=torque, preload_N=preload)
        assert at_end.static_safety == pytest.approx(2.0, rel=1e-6)
    nominal = cbpt.friction(made.nominal(), torque_Nm=4.0, preload_N=600.0, static_safety=2.0)
    assert nominal.preload_window_N is not None and nominal.largest_torque_Nm is not None
    assert largest < nominal.preload_window_N[1]
    # Near the torque that the preload holds one contact carries all, whatever the parts are.
    assert found.largest_torque_Nm <= nominal.largest_torque_Nm
