"""Property: scatter of the torque readings about their ramps is part of the uncertainty of an
angle, where the angle does not follow it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.diagnosis.torque_scatter import with_torque_scatter
from cbpt.lab.model.dataset import Campaign
from common.comparisons import EXAMPLES

Floats = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data" / "independent"
SPRING = {
    "torsion_spring": {"torsional_stiffness_Nm_per_deg": 11.0},
    "measurement": {"zero": "per_run"},
    "uncertainty": {"contact_stiffness_rel": 0.1},
}
U_ARCSEC = 10.0


def case() -> cbpt.Case:
    return cbpt.Case.from_dict(SPRING)


def campaign(torque_Nm: Floats, angle_arcsec: Floats, run: Any = 1) -> Campaign:
    table = {
        "run": np.broadcast_to(run, torque_Nm.shape),
        "time_s": np.arange(float(len(torque_Nm))),
        "torque_Nm": torque_Nm,
        "elastic_angle_arcsec": angle_arcsec,
        "u_elastic_angle_arcsec": np.full(len(torque_Nm), U_ARCSEC),
    }
    return Campaign.of(case(), cbpt.read_readings(table, need_preload=False))


def ramp(count: int = 200, largest_Nm: float = 20.0) -> Floats:
    return np.interp(np.linspace(0, 4, count), [0, 1, 3, 4], [0, largest_Nm, -largest_Nm, 0])


def noise(count: int, seed: int = 3) -> Floats:
    return np.random.default_rng(seed).standard_normal(count)


SLOPE = 300.0
"""arcsec/(N m)"""


def test_stairs_of_exact_torques_are_no_ramps_that_scatter() -> None:
    """More than half of their steps are nothing at all, by which the scatter was divided."""
    smooth = ramp(240)
    stairs = np.repeat(smooth[1::3], 3)
    given = campaign(stairs, SLOPE * smooth + noise(len(smooth)))
    same, told = with_torque_scatter(given)
    assert same is given and told == []


@pytest.mark.parametrize("u_arcsec", [10.0, 40.0])
@pytest.mark.parametrize("seed", [0, 1, 5])
def test_torque_noise_alone_is_told_as_such(seed: int, u_arcsec: float) -> None:
    """Neither an effect nor a misstated uncertainty: nobody states of an angle what the torque
    makes of it. Its size is not counted twice."""
    torque, count = np.tile(ramp(64), 6), 6 * 64
    table = {
        "run": np.repeat(np.arange(6), 64),
        "time_s": np.arange(float(count)),
        "torque_Nm": torque + 0.15 * noise(count, seed),
        "elastic_angle_arcsec": torque / 11 * 3600 + u_arcsec * noise(count, seed + 10),
        "u_elastic_angle_arcsec": np.full(count, u_arcsec),
    }
    found = cbpt.diagnose(case(), table)
    assert found.verdict.kind == "rig" and found.verdict.effects == (), found.sentence
    assert {"torque_noise"} <= set(found.verdict.noise) <= {"torque_noise", "outliers"}
    made = float(np.median(found.competition.campaign.u_arcsec))
    assert made == pytest.approx(np.hypot(u_arcsec, 0.15 * 3600 / 11), rel=0.25)


@pytest.mark.parametrize("seed", range(3))
def test_torque_noise_of_a_ball_drive_is_no_effect_without_a_name(seed: int) -> None:
    """Ramps that are alike: their time and their rate tell the true torque better than the column,
    and what was a function of those was certain."""
    ramp_Nm = np.linspace(0.0, 8.0, 30)
    runs = 8
    table = {
        "run": np.repeat(np.arange(1.0, runs + 1), len(ramp_Nm)),
        "time_s": np.arange(float(runs * len(ramp_Nm))) * 4,
        "torque_Nm": np.tile(ramp_Nm, runs),
        "preload_N": np.repeat([400.0, 500.0, 650.0, 800.0] * 2, len(ramp_Nm)),
        "input_angle_deg": np.repeat(np.arange(runs) * 45.0, len(ramp_Nm)),
        "elastic_angle_arcsec": np.zeros(runs * len(ramp_Nm)),
    }
    drive = EXAMPLES / "campaign.toml"
    read = cbpt.simulate(drive, cbpt.read_readings(table), u_elastic_angle_arcsec=0.2, seed=seed)
    noisy = read.torque_Nm + 0.15 * noise(len(read), seed + 20)
    found = cbpt.diagnose(drive, replace(read, torque_Nm=noisy))
    assert found.verdict.kind in ("complete", "rig"), found.sentence
    assert found.verdict.effects == ()


def test_scatter_counts_by_the_slope_of_the_curve() -> None:
    torque = ramp()
    angle = SLOPE * torque + U_ARCSEC * noise(200)
    found, notes = with_torque_scatter(campaign(torque + 0.1 * noise(200, 5), angle))
    assert float(np.median(found.u_arcsec)) == pytest.approx(
        np.hypot(U_ARCSEC, 0.1 * SLOPE), rel=0.4
    )
    assert len(notes) == 1 and "N m that the angle does not follow" in notes[0]
    # A curve that is flat is moved by nothing, wherever its torque was.
    flat, _ = with_torque_scatter(campaign(torque + 0.1 * noise(200, 5), U_ARCSEC * noise(200)))
    assert flat.u_arcsec.max() < 3 * U_ARCSEC


def test_a_jump_within_one_step_is_uncertain_by_its_share_of_the_step() -> None:
    """Play of 2000 arcsec is crossed at zero torque: a torque 0.1 N m off is behind or before it in
    one of four cases, where readings are 0.4 N m apart."""
    torque = ramp()
    angle = 10 * torque + 1000 * np.sign(torque) + U_ARCSEC * noise(200)
    found, _ = with_torque_scatter(campaign(torque + 0.1 * noise(200, 5), angle))
    near = np.abs(torque) < 0.3
    near[[0, -1]] = False  # there it begins and ends half way
    assert found.u_arcsec[near].min() > 0.2 * 2000
    far = (np.abs(torque) > 3) & (np.abs(torque) < 18)
    assert float(np.median(found.u_arcsec[far])) < 2 * U_ARCSEC


@pytest.mark.parametrize("kind", ["jitter", "chosen", "at random", "exact"])
def test_torques_that_the_angle_follows_do_not_scatter(kind: str) -> None:
    """Nor do those that somebody chose, evenly spaced or not."""
    torque = {
        "jitter": ramp() + 0.1 * noise(200, 5),
        "chosen": np.tile([0, 1, 2, 5, 10, 15, 20, 15, 10, 5, 2, 1.0], 6),
        "at random": 10 * noise(200, 5),
        "exact": ramp(),
    }[kind]
    given = campaign(torque, SLOPE * torque + U_ARCSEC * noise(len(torque)))
    found, notes = with_torque_scatter(given)
    assert found is given and notes == []


@pytest.mark.parametrize("of_a_swing", [20, 30, 60])
def test_a_torque_that_swings_does_not_scatter(of_a_swing: int) -> None:
    """Its curve was a scatter that made several times the uncertainty of an angle."""
    torque = 20.0 * np.sin(2 * np.pi * np.arange(6.0 * of_a_swing) / of_a_swing)
    given = campaign(torque, SLOPE * torque + U_ARCSEC * noise(len(torque)))
    found, notes = with_torque_scatter(given)
    assert found is given and notes == []


def between(before: str, after: str) -> cbpt.Change:
    """Tables of an independent generator (tests/data/README.md)."""
    tables = (str(DATA / f"{name}.csv") for name in (before, after))
    return cbpt.change(case(), *tables, effects=["backlash", "friction_hysteresis"])


def test_other_ramps_of_the_same_reducer_are_no_change() -> None:
    """Readings that cross the play in one step decided: friction had fallen by 16 of its
    uncertainties."""
    found = between("ramps_before", "large_ramps_after")
    assert found.kind == "nothing", found.sentence


def test_a_stiffness_that_rose_is_what_changed() -> None:
    """It was the gain of the torque cell, from 0.8 to the limit of its range."""
    found = between("stiffness_before", "stiffness_after")
    assert [c.effect for c in found.changed] == ["contact_stiffness"]
    assert found.changed[0].after == pytest.approx(1.1 * found.changed[0].before, rel=0.02)
