"""How many observations readings are: what a model leaves goes on along a run, and comes again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.change import reproducibility
from cbpt.lab.change.counting import autocorrelation_time, design_effect
from cbpt.lab.change.parties import Levels
from cbpt.lab.change.reproducibility import counted_once
from common.friction_loops import read_from


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


def counted(*left: NDArray[np.float64], readings: cbpt.Readings) -> float:
    """The design effect of levels whose fits leave this, in standard deviations."""
    campaign = SimpleNamespace(readings=readings, rows=readings)
    problem = SimpleNamespace(whitener=lambda y: y, campaign=campaign)
    fits = tuple(SimpleNamespace(residual_arcsec=one) for one in left)
    parties = (SimpleNamespace(problem=problem),) * len(left)
    return design_effect(cast(Levels, SimpleNamespace(parties=parties, fits=fits)))


def loops_of(k: int) -> tuple[NDArray[np.float64], cbpt.Readings]:
    """Torque of one loop, and k such loops."""
    torque = np.sin(np.linspace(0, 2 * np.pi, 64, endpoint=False))
    table = {"run": np.repeat(np.arange(k), 64), "torque_Nm": np.tile(torque, k)}
    angle = {"elastic_angle_arcsec": np.zeros(64 * k)}
    return torque, cbpt.read_readings(table | angle, need_preload=False)


@pytest.mark.parametrize("k", [1, 2, 4])
def test_runs_that_leave_the_same_law_count_as_one(k: int) -> None:
    torque, readings = loops_of(k)
    law = np.tile(np.cos(7 * torque) - np.cos(7 * torque).mean(), k)
    noise = np.random.default_rng(5).standard_normal((20, 64 * k))
    assert [counted(one, readings=readings) for one in noise] == [1.0] * 20
    once = autocorrelation_time([law[:64]]) * np.mean(law**2)
    found = counted(2 * law + 0.01 * noise[0], readings=readings)
    assert found == pytest.approx(4 * k * once if k > 1 else 1.0, rel=0.01)


def test_a_law_counts_by_its_readings_and_whichever_way_it_goes() -> None:
    k = 10
    _, readings = loops_of(k)
    noise = np.random.default_rng(5).standard_normal(64 * k)
    up_and_down = np.tile(np.resize([1.0, -1.0], 64), k)
    # Ten runs that leave the same are one, from reading to reading as they may go.
    assert counted(up_and_down + 0.01 * noise, readings=readings) == pytest.approx(k, rel=0.01)
    law = np.tile(2 * np.cos(np.linspace(0, 20, 64)), k)
    both = counted(law, law, readings=readings)
    # At one of two levels alone, half of it.
    assert counted(law, noise, readings=readings) == pytest.approx(both / 2, rel=0.1)


def test_readings_that_all_but_count_leave_each_choice_its_probability(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A gain that is off by far more than its calibration, and its twin, too."""
    case = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}}
    torque = np.concatenate([np.arange(0, 20), np.arange(20, -20, -1), np.arange(-20, 0.1)])
    one, other = (read_from(case, torque, seed=seed, u=2.0) for seed in (1, 2))
    other["elastic_angle_arcsec"] = 1.2 * other["elastic_angle_arcsec"]
    told = case | {"uncertainty": {"contact_stiffness_rel": 0.1}}
    before = cbpt.change(told, one, other, effects=[]).weighed
    assert any(c.loose for c in before.choices) and any(c.stands_for for c in before.choices)
    monkeypatch.setattr(reproducibility, "design_effect", lambda levels: 1 + 1e-9)
    after = counted_once(before)
    for c in before.near(1.0):
        (same,) = [
            a
            for a in after.choices
            if (a.changed, a.loose, a.stands_for, a.fit.separate)
            == (c.changed, c.loose, c.stands_for, c.fit.separate)
            and a.levels.variants == c.levels.variants
        ]
        assert same.probability == pytest.approx(c.probability, abs=0.01)
