"""Property: a logger that is quicker than its sensor adds no readings, and shows no friction."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.diagnosis.held_angle import held_angle
from cbpt.lab.model.dataset import Campaign

Floats = NDArray[np.float64]
SPRING = {"torsion_spring": {"torsional_stiffness_Nm_per_rad": 3000.0}}
UP = np.linspace(0.0, 20.0, 41)
LOOP = np.concatenate([UP, UP[-2::-1], -UP[1:], -UP[-2::-1]])


def table(torque: Floats, angle_rad: Floats, runs: int, u: float = 2e-5) -> dict[str, Floats]:
    n = len(torque)
    return {
        "run": np.repeat(np.arange(1, runs + 1), n // runs),
        "time_s": np.arange(n) * 2.0,
        "torque_Nm": torque,
        "elastic_angle_rad": np.round(angle_rad, 8),
        "u_elastic_angle_rad": np.full(n, u),
    }


def used(read: dict[str, Floats]) -> int:
    campaign = Campaign.of(
        cbpt.Case.from_dict(SPRING), cbpt.read_readings(read, need_preload=False)
    )
    return len(held_angle(campaign)[0])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("every", [3, 4])
def test_a_sensor_that_is_read_too_often_shows_no_friction(every: int, seed: int) -> None:
    """The torque goes on while the angle stays: it was one of damping and friction, or unknown."""
    torque = np.tile(LOOP, 3)
    noisy = torque / 3000.0 + 2e-5 * np.random.default_rng([3, seed]).standard_normal(len(torque))
    place = np.arange(len(torque)) % len(LOOP)
    read = noisy[np.arange(len(torque)) - place % every]
    found = cbpt.diagnose(SPRING, table(torque, read, 3))
    assert found.verdict.effects == () and found.verdict.rivals == (), found.sentence
    [note] = [note for note in found.notes if "read more often than it measures" in note]
    assert f"{3 * -(-len(LOOP) // every)} of {len(torque)} readings" in note


def test_readings_that_come_several_times_are_one() -> None:
    torque = np.repeat(np.tile(LOOP[::3], 2), 3)
    noise = np.repeat(np.random.default_rng(5).standard_normal(len(torque) // 3), 3)
    assert used(table(torque, torque / 3000.0 + 2e-5 * noise, 2)) == len(torque) // 3


def test_a_spring_that_sticks_and_a_coarse_display_are_none() -> None:
    torque = np.tile(LOOP, 2)
    stuck = np.array(torque)
    for i in range(1, len(stuck)):
        stuck[i] = min(max(stuck[i - 1], torque[i] - 4.0), torque[i] + 4.0)
    assert used(table(torque, stuck / 3000.0, 2)) == len(torque)
    coarse = np.round(np.repeat(torque, 3) / 3000.0 / 1e-3) * 1e-3
    assert used(table(np.repeat(torque, 3), coarse, 2)) == 3 * len(torque)
    exact = np.random.default_rng(6).standard_normal(len(torque))
    assert used(table(torque, torque / 3000.0 + 2e-5 * exact, 2)) == len(torque)
