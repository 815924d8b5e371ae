"""What a slack of the angle sensor's coupling, a sensor that saturates, a warm-up and a sharp
reversal look like.

All of these are added to the readings by hand, so that the library's equations are not their own
witness.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common.comparisons import EXAMPLES
from common.friction_loops import LOOP, SPRING, loops
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


@pytest.mark.parametrize("in_u", [8, 16])
def test_a_sensor_that_saturates_is_no_certain_part_of_the_drive(in_u: float) -> None:
    """A square and a cube of the angle do not follow it: a play was certain in its place, or rough
    contacts and a tilt beside it."""
    shown = plain()
    share = shown / np.abs(shown).max()
    found = cbpt.diagnose(CASE, read(shown - in_u * U_ARCSEC * np.tanh(1.5 * share) ** 3))
    assert found.verdict.effects == ("sensor_nonlinearity",), found.sentence


def test_friction_that_turns_over_at_once_is_no_certain_torque_sensor() -> None:
    """Coulomb's friction: the load lags behind the torque by it, whatever the angle."""
    load = following(TABLE.torque_Nm, 0.3, TABLE.run_index)
    found = cbpt.diagnose(CASE, read(plain(load)))
    assert "friction_hysteresis" in told(found), found.sentence


@pytest.mark.parametrize("tau_s", [1.0, 4.0])
def test_a_damper_on_a_triangle_is_no_friction(tau_s: float) -> None:
    """At one rate both are a loop of one width, but for where the torque turns: there the angle is
    as late as ever. A torque that turns slowly was assumed, and friction was certain."""
    assert TABLE.time_s is not None
    load = TABLE.torque_Nm.copy()
    for run in np.unique(TABLE.run_index):
        rows = np.flatnonzero(TABLE.run_index == run)
        for before, now in pairwise(rows.tolist()):
            step_s = TABLE.time_s[now] - TABLE.time_s[before]
            steady = tau_s * (TABLE.torque_Nm[now] - TABLE.torque_Nm[before]) / step_s
            late = (load[before] - TABLE.torque_Nm[before] + steady) * np.exp(-step_s / tau_s)
            load[now] = TABLE.torque_Nm[now] - steady + late
    found = cbpt.diagnose(CASE, read(plain(load)))
    assert found.verdict.effects == ("damping",), found.sentence
    value = found.parameters(found.after, "damping")["time_constant_s"]
    assert value["value"] == pytest.approx(tau_s, abs=3 * value["u"])


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


def on_a_spring(
    shown_Nm: Floats, angle_arcsec: Floats, time_s: Floats, seed: int = 1, **case: float
) -> cbpt.Diagnosis:
    """Two runs of so many readings each; 2 arcsec of noise."""
    noise = 2 * np.random.default_rng(seed).standard_normal(2 * len(time_s))
    table = {
        "run": np.repeat([1.0, 2.0], len(time_s)),
        "time_s": np.tile(time_s, 2),
        "torque_Nm": np.tile(shown_Nm, 2),
        "elastic_angle_arcsec": np.tile(angle_arcsec, 2) + noise,
        "u_elastic_angle_arcsec": np.full(len(noise), 2.0),
    }
    spring = {**SPRING, "torsion_spring": {**SPRING["torsion_spring"], **case}}
    return cbpt.diagnose(spring, cbpt.read_readings(table, need_preload=False))


def test_on_a_spring_a_late_torque_sensor_has_a_name() -> None:
    """Its filter of 1.5 s, in small steps; torques that swing faster and faster."""
    fine = np.arange(0.0, 60.0, 0.01)
    load = 8 * np.sin(2 * np.pi * (fine / 40 + (fine / 60) ** 2))
    shown = np.zeros(len(fine))
    for i in range(1, len(fine)):
        shown[i] = shown[i - 1] + 0.01 / 1.5 * (load[i - 1] - shown[i - 1])
    found = on_a_spring(shown[::60], 60 * load[::60], fine[::60])
    assert told(found) == {"torque_lag"}, found.sentence
    value = found.parameters(found.after, "torque_lag")["lag_s"]
    assert value["value"] == pytest.approx(1.5, abs=0.15)


def test_on_a_spring_a_torque_sensor_with_a_loop_is_not_late_for_certain() -> None:
    """It shows up to 0.15 N m less than there is while the torque rises, so the angle leads.
    Triangles at one rate: a late sensor shows nearly the same."""
    time = np.arange(0.0, 96.0)
    shown = 8 * (1 - np.abs((time / 24 + 1) % 4 - 2))
    behind = np.zeros(len(shown))
    for i in range(1, len(shown)):
        behind[i] = np.clip(behind[i - 1] + shown[i] - shown[i - 1], -0.15, 0.15)
    found = on_a_spring(shown, 60 * (shown + behind), time)
    assert "torque_hysteresis" in told(found), found.sentence
    assert "torque_lag" not in found.verdict.effects


def test_on_a_spring_a_damper_is_no_torque_sensor_that_leads() -> None:
    """The spring carries 0.03 N m less for each arcsec/s."""
    fine = np.arange(0.0, 60.0, 0.01)
    load = 8 * np.sin(2 * np.pi * (fine / 40 + (fine / 60) ** 2))
    angle = np.zeros(len(fine))
    for i in range(1, len(fine)):
        angle[i] = angle[i - 1] + 0.01 / 0.03 * (load[i - 1] - angle[i - 1] / 60)
    found = on_a_spring(load[::60], angle[::60], fine[::60])
    assert "damping" in told(found) and found.verdict.kind == "effect", found.sentence
    value = found.parameters(found.after, "damping")["time_constant_s"]
    assert value["value"] == pytest.approx(1.8, abs=0.05)


@pytest.mark.parametrize("seed", [1, 5])
@pytest.mark.parametrize("effect", ["torque_lag", "damping"])
def test_a_run_may_start_in_the_middle_of_a_steady_loop(effect: str, seed: int) -> None:
    """One period of a sine that has gone on for long, with torque or angle late by 0.2 rad of it.
    As if they began at rest, these were creep, drift and a permanent set for certain; and a damper
    was creep for certain where its start was told by the first rates alone."""
    time = np.arange(0.0, 40.5, 1.0)
    phase = 2 * np.pi * time / 40
    small = np.cos(0.2)
    shown_Nm, angle_arcsec = 8 * np.sin(phase), 480 * np.sin(phase - 0.2) * small
    if effect == "torque_lag":
        shown_Nm, angle_arcsec = 8 * np.sin(phase - 0.2) * small, 480 * np.sin(phase)
    found = on_a_spring(shown_Nm, angle_arcsec, time, seed=seed)
    assert effect in told(found), found.sentence
    assert not {"creep", "drift", "run_in"} & set(found.verdict.effects), found.sentence


def test_on_a_spring_a_ratio_that_drifts_is_no_certain_creep_without_a_note() -> None:
    """A stiffness that falls by 5 % along the runs."""
    time = np.arange(0.0, 80.0, 2.0)
    load = 8 * np.sin(2 * np.pi * time / 80)
    found = on_a_spring(load, 60 * load * (1 + 0.05 * time / 80), time)
    noted = any("span_drift would explain" in note for note in found.notes)
    assert noted or "creep" not in found.verdict.effects, found.sentence


def test_play_that_friction_does_not_hold_has_a_name_on_a_spring() -> None:
    """It is taken up by the whole torque, and the spring by what friction leaves of it."""
    one = np.zeros(len(LOOP), dtype=np.int64)
    carried = np.mean([following(LOOP, half, one) for half in (0.4, 0.6, 0.8, 1.0, 1.2)], axis=0)
    angle = 60 * carried + 40 * np.tanh(LOOP / 0.05)
    found = on_a_spring(LOOP, angle, np.arange(float(len(LOOP))), reference_radius_mm=30.0)
    assert told(found) >= {"bearing_play", "friction_hysteresis"}, found.sentence


def test_friction_as_small_as_the_hysteresis_of_a_torque_sensor_says_so() -> None:
    """0.8 % of the largest torque, and 10 %."""
    small, large = (cbpt.diagnose(SPRING, loops(friction_Nm)) for friction_Nm in (0.08, 1.0))
    for found, wanted in ((small, 1), (large, 0)):
        assert "friction_hysteresis" in told(found), found.sentence
        notes = [note for note in found.notes if "hysteresis on the data sheet" in note]
        assert len(notes) == wanted, found.notes
