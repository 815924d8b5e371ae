"""Noise that goes slowly and a law that the model lacks look alike: what is said of a table that
has the one or the other, and of one that tells them apart.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common.friction_loops import SPRING

Floats = NDArray[np.float64]

LEGS = [np.arange(0, 10, 0.25), np.arange(10, -10, -0.25), np.arange(-10, 0.1, 0.25)]
LOOP = np.concatenate(LEGS)


def slow(n: int, sd_arcsec: float, rng: np.random.Generator) -> Floats:
    """Each reading alike to the one before by 0.8."""
    found = rng.normal(0.0, sd_arcsec, n)
    for i in range(1, n):
        found[i] = 0.8 * found[i - 1] + 0.6 * found[i]
    return found


def asked(
    runs: int, seed: int, stated_arcsec: float | None, torque_sd_Nm: float = 0.0
) -> cbpt.Diagnosis:
    """Of a spring with slow noise of 4 arcsec."""
    rng = np.random.default_rng(seed)
    torque = np.concatenate([LOOP + rng.normal(0, torque_sd_Nm, len(LOOP)) for _ in range(runs)])
    angle = 60 * torque + np.concatenate([slow(len(LOOP), 4.0, rng) for _ in range(runs)])
    table = {
        "run": np.repeat(np.arange(runs), len(LOOP)),
        "time_s": np.arange(float(len(torque))),
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle,
    }
    if stated_arcsec:
        table["u_elastic_angle_arcsec"] = np.full(len(torque), stated_arcsec)
    return cbpt.diagnose(SPRING, table)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    ("stated_arcsec", "why"), [(2.0, "scatter or law"), (None, "scatter unknown")]
)
def test_slow_noise_of_one_run_is_neither_a_law_nor_certainly_none(
    stated_arcsec: float | None, why: str, seed: int
) -> None:
    """Of twice the stated uncertainty it was certain that nothing is missing, and it would be no
    better to be certain that something is."""
    found = asked(1, seed, stated_arcsec)
    assert found.verdict.kind == "undecided" and found.verdict.undecided == why, found.sentence


@pytest.mark.parametrize("torque_sd_Nm", [0.0, 0.02])
def test_runs_that_repeat_each_other_tell_it_from_a_law(torque_sd_Nm: float) -> None:
    """Also where their torques differ a little: it does not come again."""
    found = asked(4, 1, None, torque_sd_Nm)
    assert found.verdict.kind == "rig" and not found.verdict.effects, found.sentence


@pytest.mark.parametrize("stated_arcsec", [2.0, None])
def test_a_law_that_comes_again_is_told(stated_arcsec: float | None) -> None:
    """What follows the way of the torque alone, in two runs."""
    way = np.cumsum(np.abs(np.diff(LOOP, prepend=0.0)))
    law = 12.0 * (way % 7.0 > 4.0)
    rng = np.random.default_rng(3)
    torque = np.tile(LOOP, 2) + rng.normal(0, 0.02, 2 * len(LOOP))
    table = {
        "run": np.repeat([0, 1], len(LOOP)),
        "torque_Nm": torque,
        "elastic_angle_arcsec": 60 * torque + np.tile(law, 2) + rng.normal(0, 1.0, len(torque)),
    }
    if stated_arcsec:
        table["u_elastic_angle_arcsec"] = np.full(len(torque), stated_arcsec)
    found = cbpt.diagnose(SPRING, table)
    assert found.remains() is not None, found.sentence


@pytest.mark.parametrize("how", ["grows", "differs from run to run"])
def test_waves_over_the_torque_that_change_have_no_name(how: str) -> None:
    """The ones that grow with time were a stiffness curve, for certain, beside noise of 1.8 times
    what is stated; those that differ from run to run were such noise alone."""
    rng = np.random.default_rng(1)
    torque = np.tile(LOOP, 3) + rng.normal(0, 0.02, 3 * len(LOOP))
    run = np.repeat([0, 1, 2], len(LOOP))
    time = 2.0 * np.arange(len(torque))
    by = time / time[-1] if how == "grows" else np.array([1.0, -1.0, 0.3])[run]
    law = np.sin(np.pi * torque / 5) * by
    table = {
        "run": run,
        "time_s": time,
        "torque_Nm": torque,
        "elastic_angle_arcsec": 60 * torque + 3 * law / law.std() + rng.normal(0, 1, len(torque)),
        "u_elastic_angle_arcsec": np.ones(len(torque)),
    }
    found = cbpt.diagnose(SPRING, table)
    assert found.verdict.kind == "unknown", found.sentence
