"""Write tests/data/golden/reference.json: solved cases of the reference model.

Run from the folder tests: `python -m reference.make_golden` (about three minutes; with `--check`
it compares with the file instead of writing it). Deterministic; outputs are rounded to 14
significant digits, so that the last digits of another machine's long double do not show.

Layout of the file. SI units and radians; keys carry the unit. Arrays have one entry per ball, in
the order of the balls. null means: not defined for this case, do not compare.

    about            str
    contacts   [..]  single Hertz contacts
    pairs      [..]  one ball pair each: deceleration, ring_groove or cross_slide (one interface)
    drives     [..]  a deceleration pair with an equal-speed pair, at one crank angle

contacts[]:
    curvature_1_per_m, curvature_2_per_m   principal relative curvatures, in any order
    contact_modulus_Pa                     E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2
    force_N
    stiffness_N_per_m1p5                   k of N = k delta^1.5
    semi_axis_major_m, semi_axis_minor_m, peak_pressure_Pa, approach_m   at force_N

pairs[]:
    id               str, unique
    pair             "deceleration" | "ring_groove" | "cross_slide"
    parameters       deceleration: ball_count (Z2), short_amplitude (K), rolling_radius_m (r0),
                     ball_radius_m, conformity, contact_angle_rad, output ("hypocycloid" |
                     "epicycloid"), track_curvature ("exact" | "neglect"), material
                     ring_groove: ball_count, pitch_radius_m, ring_radius_m (e), ball_radius_m,
                     conformity, contact_angle_outside_rad, contact_angle_inside_rad,
                     track_curvature, material
                     cross_slide: ball_count, pitch_radius_m, ball_radius_m, conformity,
                     contact_angle_rad, material
                     material: ball_modulus_Pa, ball_poisson, plate_modulus_Pa, plate_poisson
    phase_rad        deceleration: ball 0 against the ray to the pitch point; ring_groove: planet
                     against the line of centres; cross_slide: 0
    exponent         n of N = k d0^1.5 (delta/d0)^n, d0 = 1 um; 1.5 is Hertz
    gaps             null, or {axial_m [], normal_m [], in_plane_m []}: zeta, g and p of
                     delta = (d + zeta) sin(beta) + g +- (arm alpha + t + p) cos(beta)
    axial_spring_N_per_m    k_c: the preload that reaches the points is preload_N - k_c (d - d0),
                     d0 the approach at zero torque and full preload; 0 for none
    findings         numbers and flags about the design (undercut, inside_wall_missing, ...), of
                     the true track curvature even where it is neglected
    arm_m []         signed arms about the centre of the output plate
    stiffness_plus_N_per_m1p5 [], stiffness_minus_N_per_m1p5 []   of the two diagonals of each ball,
                     two contacts in series; 0 where a wall is missing
    contact_angle_plus_rad, contact_angle_minus_rad
    solutions []     see below
    limits           threshold preloads (N) for +-torque_Nm at this phase: {torque_Nm,
                     positive: {hold_N, continuous_N, zero_backlash_N}, negative: the same}.
                     With gaps continuous_N is null (the origin of d means nothing there).
                     The axial spring is left out: thresholds are forces that reach the points.
    limits_over_period   null, or the largest of each over a period of phase_rad, for +torque_Nm:
                     {torque_Nm, period_rad, hold_N, continuous_N, zero_backlash_N}

pairs[].solutions[]:
    torque_Nm, preload_N
    status           "ok" | "outside_small_displacements" (|d| or max |arm alpha| beyond 0.05 ball
                     radii; still solved) | "refused" (no equilibrium; then only
                     preload_that_holds_N follows)
    alpha_rad, approach_m, lateral_m       rotation, d, and t (0 but for a cross-slide)
    alpha_floor_rad, approach_floor_m      what rounding of the inputs alone does to alpha and d;
                     compare with |difference| <= 1e-9 |value| + floor
    preload_at_points_N, approach_unloaded_m    with an axial spring; else preload_N and null
    force_plus_N [], force_minus_N []      normal force of each diagonal; compare with
                     |difference| <= 1e-9 preload_N
    force_along_N, force_across_N          in-plane force of the balls on the output plate: towards
                     the pitch point, and a quarter turn on, positive for a positive torque (there
                     it is torque/(Z_out e)). On ring grooves along is minus the sum of
                     N+ cos(beta+) - N- cos(beta-). null for a cross-slide
    tilt_couple_Nm   sum of (N+ sin(beta+) + N- sin(beta-)) arm
    torsional_stiffness_Nm_per_rad         dM0/dalpha at constant preload_N, good to 1e-7
    carrying_diagonals                     diagonals with a force; each is two meshing points
    peak_pressure_Pa                       the highest Hertz pressure of all meshing points

drives[]:
    id, deceleration {parameters}, equal_speed_pair ("ring_groove" | "cross_slide"),
    equal_speed {parameters}               parameters as in pairs[]
    crank_angle_rad, deceleration_phase_rad, equal_speed_phase_rad, ratio
    solutions []     torque_Nm, preload_N, status (the worse of the two pairs) and
                     deceleration_rad, equal_speed_rad (the pair's own angle, of a cross-slide the
                     sum of both interfaces), equal_speed_at_output_rad, total_rad = deceleration
                     + equal_speed_at_output, paper_total_rad (cross-slide: full torque on it, full
                     angle to the output; null if refused), floor_rad (as alpha_floor_rad, of
                     total_rad); or "refused" with preload_that_holds_N
    limits           {torque_Nm, hold_N, continuous_N, zero_backlash_N} at this crank angle: the
                     larger of both pairs, in terms of the output torque
    limits_over_period   null, or the same, the largest over each pair's own period
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from reference.equilibrium import NOMINAL, Conditions, Solution
from reference.forward import (
    CrossSlide,
    Deceleration,
    Drive,
    Limits,
    Material,
    RingGroove,
    TorqueNotHeldError,
    capacity,
    contact_state,
    contact_stiffness_N_per_m1p5,
    drive_limits,
    limits,
    limits_over_period,
    solve_drive,
    solve_pair,
    torsional_stiffness_Nm_per_rad,
)

GOLDEN = Path(__file__).parents[1] / "data" / "golden" / "reference.json"
Model = Deceleration | RingGroove | CrossSlide
Json = dict[str, Any]

DEG = math.pi / 180
CERAMIC_BALLS = Material(310e9, 0.26, 206e9, 0.29)

# Loads are dealt out to the cases from these two rounds, so that every combination turns up.
FRACTIONS = (0.5, 0.0, -0.8, 0.95, 0.2, -0.999, 0.7, 1e-4, -0.9, 0.999, -0.05, 0.99, -0.6)
PRELOADS_N = (600.0, 30.0, 1e-2, 2e3, 250.0, 1.0, 1e5, 1e4)


# --- cases ----------------------------------------------------------------------------------

# The base case and the prototype of the 2017 paper; its prototype needs neglected curvature.
BASE = Deceleration(20, 0.5, 4e-3, 1.5e-3, 1.08, 45 * DEG)
PROTOTYPE = Deceleration(26, 0.6, 0.8e-3, 2e-3, 1.08, 45 * DEG, track_curvature="neglect")
BASE_RING = RingGroove(14, 40e-3, 2e-3, 1.5e-3, 1.08, 45 * DEG, 45 * DEG)
PROTOTYPE_RING = RingGroove(
    10, 25e-3, 0.48e-3, 2.5e-3, 1.08, 45 * DEG, 45 * DEG, track_curvature="neglect"
)
BASE_SLIDE = CrossSlide(16, 40e-3, 1.5e-3, 1.08, 45 * DEG)

DECELERATIONS: dict[str, tuple[Deceleration, float]] = {
    "base": (BASE, 0.03),
    "base epicycloid output": (replace(BASE, output="epicycloid"), 0.03),
    "base mirrored phase": (BASE, -0.03),
    "3 balls": (Deceleration(3, 0.3, 12e-3, 2e-3, 1.08, 45 * DEG), 0.1),
    "4 balls epicycloid output": (
        Deceleration(4, 0.35, 9e-3, 1.5e-3, 1.05, 40 * DEG, output="epicycloid"),
        0.7,
    ),
    "5 balls": (Deceleration(5, 0.4, 8e-3, 1.5e-3, 1.1, 50 * DEG), -0.4),
    "8 balls ceramic": (
        Deceleration(8, 0.45, 6e-3, 1.5e-3, 1.04, 45 * DEG, material=CERAMIC_BALLS),
        0.25,
    ),
    "11 balls epicycloid output": (
        Deceleration(11, 0.25, 5e-3, 2e-3, 1.12, 35 * DEG, output="epicycloid"),
        0.15,
    ),
    "17 balls flat contact": (Deceleration(17, 0.5, 4e-3, 1.2e-3, 1.03, 20 * DEG), 0.05),
    "20 balls steep contact": (replace(BASE, contact_angle_rad=70 * DEG), 0.1),
    "20 balls near undercut": (replace(BASE, short_amplitude=0.585), 0.0),
    "20 balls undercut": (replace(BASE, short_amplitude=0.65), 0.03),
    "20 balls undercut epicycloid output": (
        replace(BASE, short_amplitude=0.72, output="epicycloid"),
        -0.11,
    ),
    "prototype curvature neglected": (PROTOTYPE, 0.02),
    "33 balls": (Deceleration(33, 0.6, 5e-3, 1e-3, 1.04, 50 * DEG), 0.01),
    "40 balls epicycloid output": (
        Deceleration(40, 0.5, 2.5e-3, 1e-3, 1.06, 45 * DEG, output="epicycloid"),
        0.04,
    ),
    "60 balls": (Deceleration(60, 0.55, 2e-3, 0.6e-3, 1.08, 45 * DEG), -0.02),
}

RINGS: dict[str, tuple[RingGroove, float]] = {
    "base": (BASE_RING, 0.11),
    "3 balls": (RingGroove(3, 30e-3, 3e-3, 2e-3, 1.08, 45 * DEG, 45 * DEG), 0.2),
    "5 balls outside steeper": (RingGroove(5, 25e-3, 4e-3, 2e-3, 1.06, 50 * DEG, 40 * DEG), -0.3),
    "8 balls inside steeper": (RingGroove(8, 30e-3, 2.5e-3, 2e-3, 1.05, 38 * DEG, 47 * DEG), 0.4),
    "9 balls no inside wall": (
        RingGroove(9, 30e-3, 0.48e-3, 2.5e-3, 1.08, 45 * DEG, 45 * DEG),
        0.3,
    ),
    "10 balls no inside wall unlike angles": (
        RingGroove(10, 25e-3, 1.2e-3, 2.5e-3, 1.08, 40 * DEG, 50 * DEG),
        0.05,
    ),
    "11 balls ceramic": (
        RingGroove(11, 35e-3, 2e-3, 1.5e-3, 1.1, 30 * DEG, 30 * DEG, material=CERAMIC_BALLS),
        0.0,
    ),
    "prototype curvature neglected": (PROTOTYPE_RING, 0.1),
    "24 balls": (RingGroove(24, 50e-3, 2.5e-3, 1.5e-3, 1.04, 55 * DEG, 52 * DEG), -0.07),
}

SLIDES: dict[str, CrossSlide] = {
    "base": BASE_SLIDE,
    "3 balls": CrossSlide(3, 40e-3, 1.5e-3, 1.08, 45 * DEG),
    "4 balls": CrossSlide(4, 25e-3, 2e-3, 1.05, 40 * DEG),
    "5 balls": CrossSlide(5, 30e-3, 2e-3, 1.06, 50 * DEG),
    "9 balls": CrossSlide(9, 40e-3, 1.5e-3, 1.08, 45 * DEG),
    "15 balls ceramic": CrossSlide(15, 35e-3, 1.5e-3, 1.1, 35 * DEG, CERAMIC_BALLS),
}


def _short(values: ArrayLike) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Gap values in m with four digits, so that the file states exactly what was solved."""
    return np.array([float(f"{v:.4g}") for v in np.asarray(values).tolist()])


def _gaps(model: Model, which: str, seed: int) -> Conditions:
    """Gap terms of a made-up drive: a tilted plate, a lot of balls, two harmonics of pitch."""
    count = model.ball_count
    angle = 2 * math.pi * np.arange(count) / count
    lot = np.random.default_rng(seed).normal(0, 0.4e-6, count)
    terms = {
        "axial_m": _short(1.2e-6 * np.cos(angle - 0.6)),
        "normal_m": _short(lot),
        "in_plane_m": _short(0.8e-6 * np.sin(2 * angle + 0.3) + 0.3e-6 * np.cos(5 * angle)),
    }
    chosen = {name: v if which in ("all", name) else None for name, v in terms.items()}
    return Conditions(chosen["axial_m"], chosen["normal_m"], chosen["in_plane_m"])


CONDITIONS: dict[str, tuple[Model, float, Conditions]] = {
    "deceleration, tilted plate": (BASE, 0.03, _gaps(BASE, "axial_m", 1)),
    "deceleration, ball sizes": (BASE, 0.03, _gaps(BASE, "normal_m", 2)),
    "deceleration, groove pitch": (BASE, 0.03, _gaps(BASE, "in_plane_m", 3)),
    "deceleration, all gaps, epicycloid output": (
        replace(BASE, output="epicycloid"),
        0.05,
        _gaps(BASE, "all", 4),
    ),
    "ring groove, all gaps": (BASE_RING, 0.11, _gaps(BASE_RING, "all", 5)),
    "ring groove, all gaps, no inside wall": (
        RINGS["9 balls no inside wall"][0],
        0.3,
        _gaps(RINGS["9 balls no inside wall"][0], "all", 6),
    ),
    "ring groove, all gaps, unlike angles": (
        RINGS["5 balls outside steeper"][0],
        -0.3,
        _gaps(RINGS["5 balls outside steeper"][0], "all", 7),
    ),
    "cross-slide, ball sizes, even": (BASE_SLIDE, 0.0, _gaps(BASE_SLIDE, "normal_m", 8)),
    "cross-slide, all gaps, odd": (SLIDES["9 balls"], 0.0, _gaps(SLIDES["9 balls"], "all", 9)),
    "deceleration, exponent 1.3": (BASE, 0.03, Conditions(exponent=1.3)),
    "deceleration, exponent 2.5": (BASE, 0.1, Conditions(exponent=2.5)),
    "ring groove, exponent 1.8": (BASE_RING, 0.11, Conditions(exponent=1.8)),
    "cross-slide, exponent 2.1, odd": (SLIDES["5 balls"], 0.0, Conditions(exponent=2.1)),
    "ring groove, exponent and gaps": (
        BASE_RING,
        0.2,
        replace(_gaps(BASE_RING, "all", 10), exponent=1.7),
    ),
    "deceleration, spring 50 N/um": (BASE, 0.03, Conditions(spring_N_per_m=5e7)),
    "ring groove, spring 400 N/um": (BASE_RING, 0.11, Conditions(spring_N_per_m=4e8)),
    "cross-slide, spring 1000 N/um, odd": (SLIDES["9 balls"], 0.0, Conditions(spring_N_per_m=1e9)),
    "deceleration, gaps, exponent and spring": (
        BASE,
        0.03,
        replace(_gaps(BASE, "all", 11), exponent=1.6, spring_N_per_m=2e8),
    ),
}

OVER_PERIOD = {
    "deceleration: base",
    "deceleration: 5 balls",
    "ring_groove: base",
    "ring_groove: 8 balls inside steeper",
    "ring_groove: 9 balls no inside wall",
}

DRIVES: dict[str, tuple[Drive, tuple[float, ...]]] = {
    "base, ring grooves": (Drive(BASE, BASE_RING), (0.0, 0.7, -2.4)),
    "base, cross-slide": (Drive(BASE, BASE_SLIDE), (0.0, 1.9, -0.35)),
    "base, ring grooves, epicycloid output": (
        Drive(replace(BASE, output="epicycloid"), BASE_RING),
        (0.0, 0.7, 5.1),
    ),
    "prototype, curvature neglected": (Drive(PROTOTYPE, PROTOTYPE_RING), (0.0, 3.0)),
    "5 and 9 balls, no inside wall": (
        Drive(DECELERATIONS["5 balls"][0], RINGS["9 balls no inside wall"][0]),
        (0.45, -1.3),
    ),
    "8 and 9 balls, odd cross-slide, ceramic": (
        Drive(DECELERATIONS["8 balls ceramic"][0], SLIDES["9 balls"]),
        (0.2, 4.0),
    ),
    "33 and 8 balls, unlike angles": (
        Drive(DECELERATIONS["33 balls"][0], RINGS["8 balls inside steeper"][0]),
        (0.9,),
    ),
}
DRIVES_OVER_PERIOD = {"base, ring grooves", "base, cross-slide"}
LIMIT_TORQUE_NM = 5.0


# --- writing --------------------------------------------------------------------------------


def _round(value: float | None, noise: float = 0.0) -> float | None:
    """14 significant digits; None for what is undefined, 0 for what is below its noise."""
    if value is None or math.isnan(value):
        return None
    return 0.0 if abs(value) <= noise else float(f"{value:.13e}")


def _list(values: Iterable[float]) -> list[float | None]:
    return [_round(float(v)) for v in values]


def _limits(found: Limits) -> Json:
    return {name: _round(value) for name, value in asdict(found).items()}


def _parameters(model: Model) -> Json:
    found = asdict(model)
    found.pop("paper_arm_shift_m", None)
    return found


def _solution(found: Solution, stiffness: float) -> Json:
    force_noise = 1e-14 * found.preload_N
    return {
        "status": found.status,
        "alpha_rad": _round(found.alpha_rad, 1e-2 * found.alpha_floor_rad),
        "approach_m": _round(found.approach_m),
        "lateral_m": _round(found.lateral_m, 1e-2 * found.approach_floor_m),
        "alpha_floor_rad": float(f"{found.alpha_floor_rad:.1e}"),
        "approach_floor_m": float(f"{found.approach_floor_m:.1e}"),
        "preload_at_points_N": _round(found.preload_at_points_N),
        "approach_unloaded_m": _round(found.approach_unloaded_m),
        "force_plus_N": _list(found.force_plus_N),
        "force_minus_N": _list(found.force_minus_N),
        "force_along_N": _round(found.force_along_N, force_noise),
        "force_across_N": _round(found.force_across_N, force_noise),
        "tilt_couple_Nm": _round(found.tilt_couple_Nm, force_noise * 0.1),
        "torsional_stiffness_Nm_per_rad": float(f"{stiffness:.9e}"),
        "carrying_diagonals": found.carrying_diagonals,
        "peak_pressure_Pa": _round(found.peak_pressure_Pa),
    }


def pair_case(
    name: str,
    model: Model,
    phase_rad: float,
    conditions: Conditions,
    loads: Iterable[tuple[float, float]],
) -> Json:
    """One entry of pairs[]. loads: (fraction of the torque that the preload holds, preload in N);
    a negative fraction turns the other way, one beyond 1 is refused."""
    pair = model.at(phase_rad)
    solutions = []
    for fraction, preload in loads:
        held = capacity(pair, 1 if fraction >= 0 else -1) * preload
        torque = float(f"{fraction * held:.10g}")
        entry: Json = {"torque_Nm": torque, "preload_N": preload}
        try:
            found = solve_pair(pair, torque, preload, conditions)
        except TorqueNotHeldError as refusal:
            entry |= {"status": "refused"}
            entry |= {"preload_that_holds_N": _round(refusal.preload_that_holds_N)}
        else:
            stiffness = torsional_stiffness_Nm_per_rad(pair, torque, preload, conditions)
            entry |= _solution(found, stiffness)
        solutions.append(entry)
    over_period: Json | None = None
    if name in OVER_PERIOD and not isinstance(model, CrossSlide):
        over_period = _limits(limits_over_period(model, LIMIT_TORQUE_NM))
        over_period |= {"torque_Nm": LIMIT_TORQUE_NM, "period_rad": model.period_rad}
    gaps = {
        key: (np.zeros(model.ball_count) if values is None else values).tolist()
        for key in ("axial_m", "normal_m", "in_plane_m")
        for values in [getattr(conditions, key)]
    }
    return {
        "id": name,
        "pair": pair.kind,
        "parameters": _parameters(model),
        "phase_rad": phase_rad,
        "exponent": conditions.exponent,
        "gaps": gaps if conditions.has_gaps else None,
        "axial_spring_N_per_m": conditions.spring_N_per_m,
        "findings": {
            key: value if isinstance(value, bool) else _round(value)
            for key, value in model.findings().items()
        },
        "arm_m": _list(pair.arm_m),
        "stiffness_plus_N_per_m1p5": _list(pair.stiffness_plus_N_per_m1p5),
        "stiffness_minus_N_per_m1p5": _list(pair.stiffness_minus_N_per_m1p5),
        "contact_angle_plus_rad": pair.contact_angle_plus_rad,
        "contact_angle_minus_rad": pair.contact_angle_minus_rad,
        "solutions": solutions,
        "limits": {
            "torque_Nm": LIMIT_TORQUE_NM,
            "positive": _limits(limits(pair, LIMIT_TORQUE_NM, conditions)),
            "negative": _limits(limits(pair, -LIMIT_TORQUE_NM, conditions)),
        },
        "limits_over_period": over_period,
    }


def drive_case(name: str, drive: Drive, crank_angle_rad: float, over_period: bool) -> Json:
    """One entry of drives[]."""
    phases = drive.phases_rad(crank_angle_rad)
    solutions = []
    for torque, preload in ((5.0, 600.0), (-5.0, 600.0), (1.0, 600.0), (5.0, 200.0), (60.0, 1e4)):
        entry: Json = {"torque_Nm": torque, "preload_N": preload}
        try:
            found = solve_drive(drive, crank_angle_rad, torque, preload)
        except TorqueNotHeldError:
            hold = drive_limits(drive, torque, crank_angle_rad).hold_N
            entry |= {"status": "refused", "preload_that_holds_N": _round(hold)}
        else:
            series = 2 if isinstance(drive.equal_speed, CrossSlide) else 1
            parts = (found.deceleration, found.equal_speed)
            floor = parts[0].alpha_floor_rad + series * parts[1].alpha_floor_rad
            entry |= {
                "status": max((p.status for p in parts), key=lambda s: s != "ok"),
                "deceleration_rad": _round(found.deceleration.alpha_rad),
                "equal_speed_rad": _round(found.equal_speed_rad),
                "equal_speed_at_output_rad": _round(found.equal_speed_at_output_rad),
                "total_rad": _round(found.total_rad),
                "paper_total_rad": _round(found.paper_total_rad),
                "floor_rad": float(f"{floor:.1e}"),
            }
        solutions.append(entry)

    def thresholds(angle: float | None) -> Json:
        return {"torque_Nm": LIMIT_TORQUE_NM} | _limits(drive_limits(drive, LIMIT_TORQUE_NM, angle))

    return {
        "id": name,
        "deceleration": _parameters(drive.deceleration),
        "equal_speed_pair": drive.pairs(0.0)[1].kind,
        "equal_speed": _parameters(drive.equal_speed),
        "crank_angle_rad": crank_angle_rad,
        "deceleration_phase_rad": phases[0],
        "equal_speed_phase_rad": phases[1],
        "ratio": drive.ratio,
        "solutions": solutions,
        "limits": thresholds(crank_angle_rad),
        "limits_over_period": thresholds(None) if over_period else None,
    }


def contact_case(first: float, second: float, modulus: float, force: float) -> Json:
    """One entry of contacts[]."""
    state = {k: _round(v) for k, v in asdict(contact_state(force, first, second, modulus)).items()}
    return state | {
        "curvature_1_per_m": first,
        "curvature_2_per_m": second,
        "contact_modulus_Pa": modulus,
        "force_N": force,
        "stiffness_N_per_m1p5": _round(contact_stiffness_N_per_m1p5(first, second, modulus)),
    }


def _deal(number: int, count: int, refuse: bool) -> list[tuple[float, float]]:
    """Loads of a case: the rounds continue where the case before it stopped."""
    picks = range(number * count, (number + 1) * count)
    loads = [(FRACTIONS[i % len(FRACTIONS)], PRELOADS_N[i % len(PRELOADS_N)]) for i in picks]
    return loads + ([((-1) ** number * 1.0001, 100.0)] if refuse else [])


def pair_jobs() -> dict[str, Callable[[], Json]]:
    """The cases of pairs[] by id, not yet computed, in the order of the file."""
    models: list[tuple[str, Model, float]] = [
        *((f"deceleration: {name}", *case) for name, case in DECELERATIONS.items()),
        *((f"ring_groove: {name}", *case) for name, case in RINGS.items()),
        *((f"cross_slide: {name}", slide, 0.0) for name, slide in SLIDES.items()),
    ]
    found = {
        name: partial(pair_case, name, model, phase, NOMINAL, _deal(i, 5, refuse=True))
        for i, (name, model, phase) in enumerate(models)
    }
    # With gaps or a spring only loads whose displacements are of the size of micrometres matter.
    loads = [(0.0, 600.0), (0.3, 600.0), (-0.7, 250.0), (0.9, 2e3), (-0.97, 600.0)]
    for short, (model, phase, conditions) in CONDITIONS.items():
        name = f"conditions: {short}"
        found[name] = partial(pair_case, name, model, phase, conditions, loads)
    return dict(found)


def drive_jobs() -> dict[str, Callable[[], Json]]:
    """The cases of drives[] by id, not yet computed, in the order of the file."""
    found: dict[str, Callable[[], Json]] = {}
    for name, (drive, angles) in DRIVES.items():
        for number, angle in enumerate(angles):
            full = f"{name}, crank at {angle:g} rad"
            over_period = name in DRIVES_OVER_PERIOD and number == 0
            found[full] = partial(drive_case, full, drive, angle, over_period)
    return found


def contacts() -> list[Json]:
    """Circles to long ellipses, up to a curvature ratio of 1e5, and three materials."""
    steel, ceramic, soft = 208e9 / 1.82, CERAMIC_BALLS.contact_modulus_Pa, 3e9
    return [
        contact_case(500.0, 500.0, steel, 100.0),
        contact_case(500.0, 500.0001, steel, 100.0),
        contact_case(49.0, 660.0, steel, 1.0),
        contact_case(1300.0, 50.0, steel, 30.0),
        contact_case(49.0, 20000.0, ceramic, 1e-4),
        contact_case(3.0, 400.0, soft, 5e3),
        contact_case(0.1, 1e4, steel, 12.0),
    ]


def document() -> Json:
    """Everything, computed."""
    return {
        "about": (
            "independent reference model of the elastic angle; SI units and radians; "
            "layout at the head of tests/reference/make_golden.py, which made this file"
        ),
        "contacts": contacts(),
        "pairs": [job() for job in pair_jobs().values()],
        "drives": [job() for job in drive_jobs().values()],
    }


def as_text(made: Json) -> str:
    """The document as it stands in the file: a record a line."""

    def compact(value: Any) -> str:
        return json.dumps(value, separators=(",", ":"), sort_keys=True, allow_nan=False)

    def records(value: Any) -> str:
        if not isinstance(value, list):
            return compact(value)
        return "[\n" + ",\n".join(map(compact, value)) + "\n]"

    return "{\n" + ",\n".join(f"{compact(k)}:{records(v)}" for k, v in made.items()) + "\n}\n"


def largest_difference(one: Any, other: Any, scale: float = 0.0) -> float:
    """Largest relative difference of two documents; infinite where they differ in kind.

    In a list numbers are measured by the largest of the list, elsewhere each by itself.
    """
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        floors = {"alpha_rad": "alpha_floor_rad", "approach_m": "approach_floor_m"}
        return max(
            (
                0.0
                if floors.get(key) in one and abs(one[key] - other[key]) <= one[floors[key]]
                else largest_difference(one[key], other[key])
                for key in one
                if not key.endswith(("floor_rad", "floor_m"))
            ),
            default=0.0,
        )
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        scale = max((abs(v) for v in one if isinstance(v, float)), default=0.0)
        found = (largest_difference(a, b, scale) for a, b in zip(one, other, strict=True))
        return max(found, default=0.0)
    if isinstance(one, float) and isinstance(other, float):
        return 0.0 if one == other else abs(one - other) / max(scale, abs(one), abs(other))
    return 0.0 if one == other else math.inf


def main(arguments: list[str]) -> int:
    """Write the file, or compare with it."""
    made = document()
    if "--check" in arguments:
        difference = largest_difference(json.loads(GOLDEN.read_text()), made)
        print(f"largest relative difference: {difference:.1e}")
        return int(difference > 1e-9)
    GOLDEN.parent.mkdir(parents=True, exist_ok=True)
    GOLDEN.write_text(as_text(made), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
