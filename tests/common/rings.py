"""A drive with ring grooves, as a case file has it, and a plan of loads, for several tests."""

from __future__ import annotations

from typing import Any

from reference.rig.campaign import Plan

CaseDict = dict[str, dict[str, Any]]

RINGS: CaseDict = {
    "deceleration": {
        "ball_count": 20,
        "short_amplitude_coefficient": 0.5,
        "rolling_circle_radius_mm": 2.5,
        "ball_radius_mm": 1.2,
        "groove_conformity": 1.08,
        "contact_angle_deg": 45.0,
    },
    "equal_speed": {
        "kind": "ring_groove",
        "ball_count": 12,
        "pitch_radius_mm": 35.0,
        "ball_radius_mm": 1.2,
        "groove_conformity": 1.08,
        "contact_angle_deg": 45.0,
    },
}
PLAN = Plan(
    preloads_N=(420.0, 800.0),
    angles_deg=(10.0, 130.0, 250.0),
    own_angle_each_run=False,
    cycles=1,
    steps=6,
    torque_share=0.8,
    negative=True,
    dwells_s=(4.0,),
    warming_K=3.0,
)
