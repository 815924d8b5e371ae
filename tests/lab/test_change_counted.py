"""How many observations readings are: what a model leaves goes on along a run, and comes again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.change.parties import Levels
from cbpt.lab.change.reproducibility import autocorrelation_time, pattern_of


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_the_time_of_a_correlation_is_that_of_its_closed_form(correlation: float) -> None:
    """(1 + rho)/(1 - rho) of a first-order autoregressive series."""
    rng = np.random.default_rng(3)
    runs = []
    for _ in range(60):
        run = np.zeros(300)
        for i in range(1, 300):
            run[i] = correlation * run[i - 1] + rng.standard_normal()
        runs.append(run)
    wanted = (1 + correlation) / (1 - correlation)
    assert autocorrelation_time(runs) == pytest.approx(wanted, rel=0.15)


def counted(left: NDArray[np.float64], readings: cbpt.Readings) -> float:
    """phi of one level whose fit leaves this, in standard deviations."""
    campaign = SimpleNamespace(readings=readings, rows=readings)
    problem = SimpleNamespace(whitener=lambda y: y, campaign=campaign)
    fit = SimpleNamespace(residual_arcsec=left)
    levels = SimpleNamespace(parties=(SimpleNamespace(problem=problem),), fits=(fit,))
    return pattern_of([cast(Levels, levels)])


def test_runs_that_leave_the_same_law_count_as_one() -> None:
    """Of noise phi is that of its runs; of a law that is the same in k runs k times that of one."""
    torque = np.sin(np.linspace(0, 2 * np.pi, 64, endpoint=False))
    rng = np.random.default_rng(5)
    found = {}
    for k in (1, 2, 4):
        table = {"run": np.repeat(np.arange(k), 64), "torque_Nm": np.tile(torque, k)}
        angle = {"elastic_angle_arcsec": np.zeros(64 * k)}
        readings = cbpt.read_readings(table | angle, need_preload=False)
        law = np.tile(np.cos(7 * torque) - np.cos(7 * torque).mean(), k)
        noise = rng.standard_normal((20, 64 * k))
        found[k] = counted(law + 0.01 * noise[0], readings)
        runs = [max(autocorrelation_time(list(one.reshape(k, 64))), 1.0) for one in noise]
        assert [counted(one, readings) for one in noise] == pytest.approx(runs)
    assert found[2] == pytest.approx(2 * found[1], rel=0.05)
    assert found[4] == pytest.approx(4 * found[1], rel=0.05)
