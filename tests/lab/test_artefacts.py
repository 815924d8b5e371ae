"""Property: what the instruments do is not taken for an effect, nor an effect for what they do.

Simulated on the campaign of the demo, whose drive is then exactly as stated.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cbpt
from common.comparisons import EXAMPLES

CASE = EXAMPLES / "campaign.toml"
TABLE = cbpt.read_readings(EXAMPLES / "campaign.csv")
U_ARCSEC = 0.3


@pytest.mark.parametrize("seed", range(2))
def test_noise_of_the_torque_column_is_no_effect(seed: int) -> None:
    """A torque sensor whose noise moves the angle by twice the noise of a reading."""
    rng = np.random.default_rng(seed)
    torque_Nm = TABLE.torque_Nm
    angle = cbpt.simulate(CASE, TABLE, u_elastic_angle_arcsec=1e-9).elastic_angle_arcsec
    slope = float(np.polyfit(torque_Nm, angle, 1)[0])
    shown = torque_Nm + 2 * U_ARCSEC / slope * rng.standard_normal(len(angle))
    read = angle + U_ARCSEC * rng.standard_normal(len(angle))
    found = cbpt.diagnose(CASE, replace(TABLE, torque_Nm=shown, elastic_angle_arcsec=read))
    assert found.verdict.kind == "rig"
    assert found.verdict.effects == () and found.verdict.rivals == ()
    assert "torque_noise" in found.verdict.noise
    assert "scatter of the torque readings" in found.sentence


def test_a_set_of_the_first_cycles_is_no_handful_of_outliers() -> None:
    """Run-in that is over after the first cycle leaves a few readings far off."""
    values = {"permanent_set_rad": 1.2e-5}
    readings = cbpt.simulate(CASE, TABLE, effects=[("run_in", values)], seed=1)
    found = cbpt.diagnose(CASE, readings).verdict
    assert found.effects == ("run_in",)
    assert "outliers" not in found.noise
