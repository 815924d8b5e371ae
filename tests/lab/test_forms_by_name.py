"""Forms of effects that are told by their names: a tilt of one plate, a soft play, seal friction.

Before these forms were in the library a tilted plate of the output was an eccentricity error, a
play that is taken up within a torque a compliant bearing with rough contacts, and a friction that
does not follow the preload needed a second effect beside it, all for certain.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from cbpt import Case, diagnose
from cbpt.lab.experiment.simulate import simulate

DRIVE = """
[deceleration]
ball_count = 22
short_amplitude_coefficient = 0.58
rolling_circle_radius_mm = 3.46
ball_radius_mm = 0.85
groove_conformity = 1.099
contact_angle_deg = 45.0
[equal_speed]
kind = "ring_groove"
ball_count = 15
pitch_radius_mm = 71.0
ball_radius_mm = 1.67
groove_conformity = 1.099
contact_angle_deg = 45.0
"""
PLAN = """
u_elastic_angle_arcsec = 0.05
temperature_degC = 20
dwell_s = 4
[[run]]
preload_N = [500, 800, 1400]
input_angle_deg = { from = 0, to = 300, points = 6 }
torque_Nm = { to = 8, points = 6, shape = "loop" }
"""


@pytest.mark.parametrize(
    ("really", "effects", "name"),
    [
        ({"as_made": {"ring_plate_tilt_urad": [60.0, -80.0]}}, [], "plate_tilt"),
        (
            {},
            [("bearing_play", {"clearance_um": 0.2, "transition_torque_Nm": 0.6})],
            "bearing_play",
        ),
        (
            {},
            [("friction_hysteresis", {"friction_torque_Nm": 0.5, "engagement_angle_arcsec": 4})],
            "friction_hysteresis",
        ),
    ],
    ids=["tilt of the output's plate", "soft play", "constant friction"],
)
def test_it_is_told_by_its_name(
    really: dict[str, Any], effects: list[Any], name: str, tmp_path: Path
) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    stated = tomllib.loads(DRIVE)
    readings = simulate(Case.from_dict(stated | really), plan, effects=effects, seed=3)
    verdict = diagnose(Case.from_dict(stated), readings).verdict
    assert verdict.effects == (name,)
    assert not verdict.rivals
