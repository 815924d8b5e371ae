"""What a slack of the angle sensor's coupling, a warm-up and a sharp reversal look like.

All three are added to the readings by hand, so that the library's equations are not their own
witness.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common.comparisons import EXAMPLES
from common.friction_loops import LOOP, SPRING
from common.play import following

Floats = NDArray[np.float64]
CASE = EXAMPLES / "campaign.toml"
TABLE = cbpt.read_readings(EXAMPLES / "campaign.csv")
U_ARCSEC = 0.3


def read(true_arcsec: Floats, seed: int = 1) -> cbpt.Readings:
    """The table of the demo with these angles, each off by the uncertainty of a reading."""
    off = U_ARCSEC * np.random.default_rng(seed).standard_normal(len(true_arcsec))
    u = np.full(len(true_arcsec), U_ARCSEC)
    return replace(TABLE, elastic_angle_arcsec=true_arcsec + off, u_elastic_angle_arcsec=u)


def plain(torque_Nm: Floats = TABLE.torque_Nm) -> Floats:
    """Angles of the drive as stated."""
    rows = replace(TABLE, torque_Nm=torque_Nm)
    return cbpt.simulate(CASE, rows, u_elastic_angle_arcsec=1e-9).elastic_angle_arcsec


def told(found: cbpt.Diagnosis) -> set[str]:
    v = found.verdict
    return {*v.effects, *(effect for group in v.rivals for effect in group)}


def test_a_slack_of_the_sensor_is_no_certain_friction() -> None:
    found = cbpt.diagnose(CASE, read(following(plain(), 4 * U_ARCSEC, TABLE.run_index)))
    assert "sensor_hysteresis" in told(found), found.sentence
    assert "friction_hysteresis" not in found.verdict.effects
    value = found.parameters(found.after, "sensor_hysteresis")["half_width_rad"]
    rad = 4 * U_ARCSEC * np.pi / 648000
    assert value["value"] == pytest.approx(rad, abs=3 * value["u"])


def test_friction_that_turns_over_at_once_is_no_certain_torque_sensor() -> None:
    """Coulomb's friction: the load lags behind the torque by it, whatever the angle."""
    load = following(TABLE.torque_Nm, 0.3, TABLE.run_index)
    found = cbpt.diagnose(CASE, read(plain(load)))
    assert "friction_hysteresis" in told(found), found.sentence


def test_a_warm_up_is_no_certain_run_in() -> None:
    assert TABLE.time_s is not None
    warm = 1 - np.exp(-(TABLE.time_s - TABLE.time_s[0]) / (0.2 * np.ptp(TABLE.time_s)))
    readings = replace(read(plain() + 8 * U_ARCSEC * warm), temperature_degC=None)
    found = cbpt.diagnose(CASE, readings)
    assert "drift" in told(found), found.sentence
    assert "run_in" not in found.verdict.effects


def test_on_a_spring_a_note_has_the_slack_that_looks_like_friction() -> None:
    """A linear spring with friction and one whose sensor has a slack read the same."""
    runs = np.repeat([0, 1, 2], len(LOOP))
    torque = np.tile(LOOP, 3)
    shown = following(60 * torque, 36.0, runs)
    table = {
        "run": runs.astype(float),
        "torque_Nm": torque,
        "elastic_angle_arcsec": shown + 2 * np.random.default_rng(1).standard_normal(len(shown)),
        "u_elastic_angle_arcsec": np.full(len(shown), 2.0),
    }
    found = cbpt.diagnose(SPRING, cbpt.read_readings(table, need_preload=False))
    noted = any(note.startswith("sensor_hysteresis would explain") for note in found.notes)
    assert noted or "sensor_hysteresis" in told(found), found.sentence
