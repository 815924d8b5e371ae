"""Random valid drives, their loads, and the base case."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st

from cbpt import Drive, Solution

ARCSEC = math.pi / 648000
CaseDict = dict[str, Any]


def examples(number: int) -> settings:
    """The same cases in every run, so that a test cannot fail by chance."""
    return settings(max_examples=number, derandomize=True, deadline=None, database=None)


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


BASE = Drive.from_dict(base_case())
