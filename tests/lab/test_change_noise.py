"""Whether the scatter changed, and whether levels were loaded at one rate."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import cbpt
from cbpt.lab.change.designs import note_on_rates, unlike_design
from cbpt.lab.change.noise import noise_change
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.readings.readings import Readings

STEP_arcsec = 4.71
SMALL, LARGE = (
    peak * np.interp(np.arange(80), [0, 20, 60, 80], [0.0, 1.0, -1.0, 0.0]) for peak in (5.0, 30.0)
)


def shown(seed: int, zero_arcsec: float) -> tuple[Readings, Fit]:
    """A display in steps coarser than the scatter, and what the true curve leaves of it."""
    rng = np.random.default_rng(seed)
    torque = np.concatenate([SMALL, LARGE])
    curve = 20 * torque + zero_arcsec
    seen = curve + 0.6 * np.cumsum(rng.standard_normal(160)) + 0.4 * rng.standard_normal(160)
    angle = STEP_arcsec * np.round(seen / STEP_arcsec)
    data = {"run": np.repeat([1, 2], 80), "torque_Nm": torque, "elastic_angle_arcsec": angle}
    left: Any = SimpleNamespace(
        residual_arcsec=angle - curve, noise=SimpleNamespace(inflation=None)
    )
    return cbpt.read_readings(data, need_preload=False), cast(Fit, left)


@pytest.mark.parametrize("seed", range(8))
def test_where_a_coarse_display_rounds_is_no_change_of_the_scatter(seed: int) -> None:
    (before, left), (after, left_after) = shown(seed, 0.0), shown(seed + 50, 1.9)
    assert noise_change([before, after], [left, left_after]).probability < 0.5


def ramps(small: int, large: int, seconds_a_ramp: float) -> Readings:
    torque = np.concatenate([SMALL] * small + [LARGE] * large)
    runs = small + large
    data = {
        "run": np.repeat(np.arange(runs), 80),
        "time_s": np.tile(np.linspace(0.0, seconds_a_ramp, 80), runs),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 20 * torque,
    }
    return cbpt.read_readings(data, need_preload=False)


def test_the_rates_of_ramps_to_like_torques_are_compared() -> None:
    assert not list(note_on_rates([ramps(4, 1, 80.0), ramps(1, 3, 80.0)]))
    [note] = note_on_rates([ramps(4, 1, 80.0), ramps(1, 3, 20.0)])
    assert note.startswith("the torque changes at 1.48 to 5.92 N m/s from level to level")
    # By a quarter too: friction that rose by some percent was told without a word on it.
    assert list(note_on_rates([ramps(4, 1, 80.0), ramps(1, 3, 64.0)]))
    assert not list(note_on_rates([ramps(4, 1, 80.0), ramps(1, 3, 70.0)]))


def turned(angles: list[float]) -> Readings:
    n = 20
    data = {
        "run": np.repeat(np.arange(len(angles)), n),
        "torque_Nm": np.tile(np.linspace(0.0, 5.0, n), len(angles)),
        "input_angle_deg": np.repeat(angles, n),
        "elastic_angle_arcsec": np.zeros(n * len(angles)),
    }
    return cbpt.read_readings(data, need_preload=False)


def test_levels_at_a_few_other_angles_or_rates_were_not_measured_alike() -> None:
    few, other = turned([10.0, 130.0, 250.0]), turned([60.0, 190.0, 310.0])
    assert "no input angle in common" in unlike_design([few, other])
    assert not unlike_design([few, turned([60.0, 130.0])]) and not unlike_design([few, few])
    # Of many angles each level shows by itself what depends on them.
    many = [turned(list(np.arange(8.0) * 45 + first)) for first in (0.0, 20.0)]
    assert not unlike_design(many)
    # A whole turn later is the same place.
    assert not unlike_design([few, turned([370.0])])
    assert "measure all levels at one rate" in unlike_design([ramps(4, 1, 80.0), ramps(1, 3, 20.0)])
    assert not unlike_design([ramps(4, 1, 80.0), ramps(1, 3, 80.0)])
