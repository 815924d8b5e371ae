"""Ramps whose torque readings scatter: what is a polynomial in time, and what must stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.diagnosis.ramped_torque import ramped_torque
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from common.comparisons import EXAMPLES

Floats = NDArray[np.float64]
CASE = cbpt.Case.from_file(EXAMPLES / "campaign.toml")
COUNT, RUNS = 120, 6
ALONG = np.linspace(0.0, 1.0, COUNT)
STRAIGHT = 8 * ALONG
SHAPES: dict[str, tuple[Floats, float]] = {
    "dwell at both ends": (8 * np.clip(1.5 * ALONG - 0.25, 0.0, 1.0), 0.1),
    "S": (4 + 4 * np.tanh(8 * (ALONG - 0.5)), 0.05),
    "staircase": (np.floor(16 * ALONG) / 2, 0.1),
}


def campaign(ramp_Nm: Floats, scatter_Nm: float, follows: bool = False, seed: int = 1) -> Campaign:
    """The drive under some ramps, and torques that a sensor scatters by, or that do themselves."""
    table = {
        "run": np.repeat(np.arange(1.0, RUNS + 1), COUNT),
        "time_s": np.arange(float(RUNS * COUNT)),
        "torque_Nm": np.tile(ramp_Nm, RUNS),
        "preload_N": np.repeat([450.0, 600.0, 800.0] * 2, COUNT),
        "input_angle_deg": np.repeat(np.arange(RUNS) * 60.0, COUNT),
        "elastic_angle_arcsec": np.zeros(RUNS * COUNT),
    }
    rows = cbpt.read_readings(table)
    scatter = scatter_Nm * np.random.default_rng(seed).standard_normal(len(rows))
    true = replace(rows, torque_Nm=rows.torque_Nm + scatter) if follows else rows
    read = cbpt.simulate(CASE, true, u_elastic_angle_arcsec=0.2, seed=seed)
    return Campaign.of(CASE, replace(read, torque_Nm=rows.torque_Nm + scatter))


def model(campaign: Campaign) -> Floats:
    return Assembled(campaign, []).at(Assembled(campaign, []).neutral).angle_arcsec


@pytest.mark.parametrize("seed", range(3))
def test_a_straight_ramp_is_known_better_than_its_readings(seed: int) -> None:
    found, notes = ramped_torque(campaign(STRAIGHT, 0.15, seed=seed), model)
    off = found.readings.torque_Nm - np.tile(STRAIGHT, RUNS)
    assert len(notes) == 1 and np.sqrt(np.mean(off**2)) < 0.15 / 8
    # What is left of them is in the covariance.
    assert found.torque_errors is not None
    error = found.torque_errors.columns_arcsec
    slope = np.gradient(model(campaign(STRAIGHT, 0.0))[:COUNT], STRAIGHT)
    stated = np.sqrt(np.square(error).sum(axis=1))[:COUNT]
    assert np.sqrt(np.mean((off[:COUNT] * slope) ** 2)) < 3 * np.sqrt(np.mean(stated**2))


@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_no_polynomial_stays_as_it_was_read(shape: str) -> None:
    given = campaign(*SHAPES[shape])
    found, notes = ramped_torque(given, model)
    assert found is given and notes == []


def test_a_torque_that_the_angle_follows_stays_as_it_was_read() -> None:
    given = campaign(STRAIGHT, 0.15, follows=True)
    assert ramped_torque(given, model) == (given, [])
