"""A drive with ring grooves, as a case file has it, that several tests take for an example."""

from __future__ import annotations

from typing import Any

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
