"""A play that is taken up within a torque is told by its name.

Before that form was in the library it was a compliant bearing with rough contacts, for certain.
"""

from __future__ import annotations

from pathlib import Path

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


def test_a_soft_play_is_told_by_its_name(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    case = Case.from_toml(DRIVE)
    soft = {"clearance_um": 0.2, "transition_torque_Nm": 0.6}
    verdict = diagnose(case, simulate(case, plan, effects=[("bearing_play", soft)], seed=3)).verdict
    assert verdict.effects == ("bearing_play",)
    assert not verdict.rivals
