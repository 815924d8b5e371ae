"""The drive to scale, as numbers: lines, circles, balls, meshing points, arrows; lengths in mm.

    drawing_of      both pairs of a drive under a load, seen along the axis, and cut through a ball

The deceleration pair lies with the centre O2 of its balls at the origin and the pitch point P on
the x axis; the epicycloid plate is centred on O1 (e towards P), the hypocycloid plate on O3 (e away
from it), each turned so that its track passes through all balls. Of a ring-groove pair the line of
centres is the x axis, the output's rings are centred towards +x of their balls; of a cross-slide
one row is drawn, the other is the same at right angles.

Two lines beside every track are where the walls are touched, r cos(beta) off it. An arrow is the
in-plane force of a ball on the plate that drives the output: a plus diagonal pushes its wall away
from P (rings: to -x, slides: to +y), a minus diagonal the other way.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Drive, PairSolution, Solution
from cbpt.page.document.drive_types import (
    Arrow,
    CutBall,
    Drawing,
    DrawnCircle,
    DrawnLine,
    DrawnPair,
    LoadedPair,
    MeshingPoint,
    PointState,
    Wall,
)
from cbpt.page.document.plain import finite, finite_numbers

Complex = NDArray[np.complex128]

_MM = 1e3
_DIGITS = 4
_POINTS_OF_A_LOBE = 24
# The longest arrow, as a part of what is drawn.
_LONGEST = 0.16
# Of the walls in a cut, rad.
_HALF_ARC = 0.6


def drawing_of(drive: Drive, solution: Solution, input_angle_deg: float) -> Drawing:
    """Both pairs of a ball drive; without a solution the geometry alone."""
    case = tomllib.loads(drive.to_toml())
    theta = float(np.deg2rad(input_angle_deg))
    deceleration = _deceleration(case, theta, solution.deceleration)
    equal_speed = case["equal_speed"]
    make = _ring_groove if equal_speed["kind"] == "ring_groove" else _cross_slide
    return {
        "unit": "mm",
        "pairs": [deceleration, make(case, theta, solution.equal_speed)],
    }


def _deceleration(case: Mapping[str, Any], theta: float, pair: PairSolution | None) -> DrawnPair:
    d = case["deceleration"]
    z2, k, r0 = d["ball_count"], d["short_amplitude_coefficient"], d["rolling_circle_radius_m"]
    e, radius, beta = k * r0, z2 * r0, d["contact_angle_rad"]
    reach = d["ball_radius_m"] * np.cos(beta)
    hypo_drives = d["output_plate"] == "hypocycloid"
    phase = -theta * (z2 - 1) / z2 if hypo_drives else theta * (z2 + 1) / z2
    balls = radius * np.exp(1j * (phase + 2 * np.pi * np.arange(z2) / z2))
    t = np.linspace(0, 2 * np.pi, _POINTS_OF_A_LOBE * (z2 + 1) + 1)
    lines = []
    for plate, sign, lobes in (("epicycloid", -1, z2 - 1), ("hypocycloid", 1, z2 + 1)):
        turn = np.exp(1j * phase * z2 / lobes)
        track = radius * np.exp(1j * t) + sign * e * np.exp(-sign * 1j * z2 * t)
        along = 1j * radius * np.exp(1j * t) - 1j * z2 * e * np.exp(-sign * 1j * z2 * t)
        side = 1j * along / np.abs(along)
        for kind, off in (("track", 0.0), ("wall", reach), ("wall", -reach)):
            lines.append(_line(plate, kind, turn * (track + off * side) - sign * e))
    to_pitch = z2 * e - balls
    towards = to_pitch / np.abs(to_pitch)
    # Of the two walls of a diagonal the epicycloid's stands first.
    column = int(hypo_drives)
    rest = _Balls(balls, d["ball_radius_m"], (-towards, towards), (beta, beta), column)
    centres = (("O1", e), ("O2", 0.0), ("O3", -e), ("P", z2 * e))
    output = "hypocycloid" if hypo_drives else "epicycloid"
    return {
        **_pair("deceleration", f"Deceleration pair, {z2} balls", rest, pair),
        "plates": {"output": output, "other": "epicycloid" if hypo_drives else "hypocycloid"},
        "lines": lines,
        "circles": [_circle("balls", "pitch", 0j, radius)],
        "centres": [{"label": label, "x": _mm(x), "y": 0.0} for label, x in centres],
        "section": _section(d, [beta, beta], pair),
    }


def _ring_groove(case: Mapping[str, Any], theta: float, pair: PairSolution | None) -> DrawnPair:
    d, r = case["deceleration"], case["equal_speed"]
    z2 = d["ball_count"]
    e = d["short_amplitude_coefficient"] * d["rolling_circle_radius_m"]
    hypo_drives = d["output_plate"] == "hypocycloid"
    psi = -theta * (z2 - 1) / (z2 + 1) if hypo_drives else theta * (z2 + 1) / (z2 - 1)
    angle = psi + 2 * np.pi * np.arange(r["ball_count"]) / r["ball_count"]
    balls = r["pitch_radius_m"] * np.exp(1j * angle)
    outside, inside = _ring_angles(r)
    reach = [r["ball_radius_m"] * np.cos(outside), r["ball_radius_m"] * np.cos(inside)]
    circles = [_circle("balls", "pitch", 0j, r["pitch_radius_m"])]
    for plate, centre in (("output", e), ("planet", -e)):
        for ball in balls:
            circles.append(_circle(plate, "track", ball + centre, e))
            circles.append(_circle(plate, "wall", ball + centre, e + reach[0]))
            if e > reach[1]:
                circles.append(_circle(plate, "wall", ball + centre, e - reach[1]))
    left = np.full(len(balls), -1.0 + 0j)
    title = f"Equal-speed pair: ring grooves, {r['ball_count']} balls"
    rest = _Balls(balls, r["ball_radius_m"], (left, -left), (outside, inside))
    return {
        **_pair("equal_speed", title, rest, pair),
        "plates": {"output": "output", "other": "planet"},
        "lines": [],
        "circles": circles,
        "centres": [
            {"label": "output", "x": _mm(e), "y": 0.0},
            {"label": "planet", "x": _mm(-e), "y": 0.0},
        ],
        "section": _section(r, [outside, inside], pair),
    }


def _ring_angles(r: Mapping[str, Any]) -> tuple[float, float]:
    common = r.get("contact_angle_rad", np.pi / 4)
    outside = float(r.get("outside_contact_angle_rad", common))
    return outside, float(r.get("inside_contact_angle_rad", common))


def _cross_slide(case: Mapping[str, Any], theta: float, pair: PairSolution | None) -> DrawnPair:
    d, s = case["deceleration"], case["equal_speed"]
    e = d["short_amplitude_coefficient"] * d["rolling_circle_radius_m"]
    angle = 2 * np.pi * np.arange(s["ball_count"]) / s["ball_count"]
    balls = s["pitch_radius_m"] * np.exp(1j * angle)
    beta = s["contact_angle_rad"]
    reach = s["ball_radius_m"] * np.cos(beta)
    # A ball moves by the eccentricity along its groove, either way.
    half = e + s["ball_radius_m"]
    lines = []
    for ball in balls:
        for kind, off in (("track", 0.0), ("wall", reach), ("wall", -reach)):
            ends = np.array([ball - half + 1j * off, ball + half + 1j * off])
            lines.append(_line("planet", kind, ends))
    up = np.full(len(balls), 1j)
    title = f"Equal-speed pair: cross-slide, one of two rows of {s['ball_count']} balls"
    rest = _Balls(balls, s["ball_radius_m"], (up, -up), (beta, beta))
    return {
        **_pair("equal_speed", title, rest, pair),
        "plates": {"output": "planet", "other": "floating plate"},
        "lines": lines,
        "circles": [_circle("balls", "pitch", 0j, s["pitch_radius_m"])],
        "centres": [{"label": "planet", "x": 0.0, "y": 0.0}],
        "section": _section(s, [beta, beta], pair),
    }


# --- what all pairs have ------------------------------------------------------------------


@dataclass(frozen=True)
class _Balls:
    """The balls of a pair. towards, contact_angles_rad: of the plus and of the minus diagonal, from
    the ball to its wall on the output's plate; the other wall lies opposite."""

    centres: Complex
    radius_m: float
    towards: tuple[Complex, Complex]
    contact_angles_rad: tuple[float, float]
    output_column: int = 1
    """Which of the two walls of a diagonal is the output's, as a solution counts them."""


def _pair(key: str, title: str, balls: _Balls, pair: PairSolution | None) -> LoadedPair:
    """Balls, meshing points and arrows."""
    extent = float(np.abs(balls.centres).max()) + 3 * balls.radius_m
    points = list(_points(balls, pair))
    longest = max((p["in_plane_force_N"] or 0.0 for p in points), default=0.0)
    scale = _LONGEST * extent * _MM / longest if longest else None
    return {
        "pair": key,
        "title": title,
        "extent_mm": _mm(extent),
        "balls": [
            {"number": i, "x": _mm(b.real), "y": _mm(b.imag), "radius": _mm(balls.radius_m)}
            for i, b in enumerate(balls.centres)
        ],
        "points": points,
        "arrows": list(_arrows(points, scale)) if scale else [],
        "arrow_mm_per_N": scale,
        "torque_Nm": None if pair is None else pair.torque_Nm,
        "angle_arcsec": None if pair is None else pair.angle_arcsec,
        "carrying": None if pair is None else pair.carrying,
        "peak_pressure_GPa": None if pair is None else finite(1e-9 * pair.largest_peak_pressure_Pa),
    }


def _points(balls: _Balls, pair: PairSolution | None) -> Iterator[MeshingPoint]:
    """Two meshing points for each diagonal: on the output's plate and on the other."""
    for ball, place in enumerate(balls.centres):
        for side, diagonal in enumerate(("plus", "minus")):
            direction = balls.towards[side][ball]
            cosine = float(np.cos(balls.contact_angles_rad[side]))
            row = 2 * ball + side
            for plate, sign in (("other", -1), ("output", 1)):
                at = place + sign * balls.radius_m * cosine * direction
                column = balls.output_column
                if plate == "other":
                    column = 1 - column
                yield {
                    "ball": ball,
                    "diagonal": diagonal,
                    "plate": plate,
                    "x": _mm(at.real),
                    "y": _mm(at.imag),
                    "nx": round(float((sign * direction).real), 6),
                    "ny": round(float((sign * direction).imag), 6),
                    **_state(pair, row, column, cosine),
                }


def _state(pair: PairSolution | None, row: int, column: int, cosine: float) -> PointState:
    """What a meshing point carries; nothing is known without a solution."""
    if pair is None:
        return {
            "state": None,
            "role": None,
            "force_N": None,
            "in_plane_force_N": None,
            "deformation_um": None,
            "gap_um": None,
            "peak_pressure_GPa": None,
        }
    return {
        "state": pair.contact[row],
        "role": pair.role[row],
        "force_N": float(pair.force_N[row]),
        "in_plane_force_N": float(pair.force_N[row]) * cosine,
        "deformation_um": float(1e6 * pair.deformation_m[row]),
        "gap_um": float(1e6 * pair.gap_m[row]),
        "peak_pressure_GPa": finite(float(1e-9 * pair.peak_pressure_Pa[row, column])),
    }


def _arrows(points: Sequence[MeshingPoint], scale: float) -> Iterator[Arrow]:
    """What the balls do to the plate that drives the output."""
    for point in points:
        if point["plate"] == "output" and point["in_plane_force_N"]:
            length = scale * point["in_plane_force_N"]
            yield {
                "ball": point["ball"],
                "diagonal": point["diagonal"],
                "x": point["x"],
                "y": point["y"],
                "dx": round(length * point["nx"], _DIGITS),
                "dy": round(length * point["ny"], _DIGITS),
                "force_N": point["in_plane_force_N"],
            }


def _section(
    groove: Mapping[str, Any], contact_angles_rad: Sequence[float], pair: PairSolution | None
) -> CutBall:
    """The ball that carries most, cut across its track: x towards where a minus diagonal presses
    the output's plate, which lies above; the arcs are the walls about their contacts."""
    ball = 0 if pair is None else int(np.argmax(pair.force_N)) // 2
    radius = groove["ball_radius_m"]
    arc = groove["groove_conformity"] * radius
    walls: list[Wall] = []
    for side, diagonal in enumerate(("plus", "minus")):
        cosine = np.cos(contact_angles_rad[side])
        across = (-1 if diagonal == "plus" else 1) * cosine
        normal = across + 1j * np.sin(contact_angles_rad[side])
        for plate, sign in (("other", -1), ("output", 1)):
            n = sign * normal
            spread = n * np.exp(1j * np.linspace(-_HALF_ARC, _HALF_ARC, 25))
            curve = (radius - arc) * n + arc * spread
            walls.append(
                {
                    **_line(plate, "wall", curve),
                    "diagonal": diagonal,
                    "contact": {"x": _mm(radius * n.real), "y": _mm(radius * n.imag)},
                    "nx": round(float(n.real), 6),
                    "ny": round(float(n.imag), 6),
                    "state": None if pair is None else pair.contact[2 * ball + side],
                    "force_N": None if pair is None else float(pair.force_N[2 * ball + side]),
                }
            )
    return {"ball": ball, "ball_radius_mm": _mm(radius), "walls": walls}


def _line(plate: str, kind: str, points: Complex) -> DrawnLine:
    return {
        "plate": plate,
        "kind": kind,
        "x": finite_numbers(points.real * _MM, _DIGITS),
        "y": finite_numbers(points.imag * _MM, _DIGITS),
    }


def _circle(plate: str, kind: str, centre: complex, radius_m: float) -> DrawnCircle:
    x, y = _mm(complex(centre).real), _mm(complex(centre).imag)
    return {"plate": plate, "kind": kind, "x": x, "y": y, "radius": _mm(radius_m)}


def _mm(length_m: float) -> float:
    return round(float(length_m) * _MM, _DIGITS)
