"""Loops of a torsion spring with friction, before and after a change."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.typing import NDArray

import cbpt

SPRING = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "uncertainty": {"contact_stiffness_rel": 0.2},
}
HALF = np.arange(0, 10, 0.5)
LOOP = np.concatenate([HALF, np.arange(10, -10, -0.5), np.arange(-10, 0.1, 0.5)])
FRICTION = "friction_hysteresis"


@cache
def loops(
    friction_Nm: float = 1.0,
    stiffness: float = 1.0,
    seed: int = 1,
    u: float = 2.0,
    engagement_arcsec: float = 30,
) -> dict[str, NDArray[np.float64]]:
    """Two loops of a spring with friction."""
    case: dict[str, object] = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": stiffness},
        "effect": [
            {
                "id": FRICTION,
                "friction_torque_Nm": friction_Nm,
                "engagement_angle_arcsec": engagement_arcsec,
            }
        ],
    }
    read = read_from(case, LOOP, seed=seed, u=u)
    return read | {"u_elastic_angle_arcsec": np.full(2 * len(LOOP), 2.0)}


def read_from(
    case: Mapping[str, object],
    torque_Nm: NDArray[np.float64],
    seconds_a_step: float = 1.0,
    seed: int = 1,
    u: float = 2.0,
) -> dict[str, NDArray[np.float64]]:
    """Two runs of these torques, simulated; no uncertainty is stated."""
    n = len(torque_Nm)
    plan = {
        "run": np.repeat([1.0, 2.0], n),
        "torque_Nm": np.tile(torque_Nm, 2),
        "time_s": seconds_a_step * np.arange(2.0 * n),
        "elastic_angle_arcsec": np.zeros(2 * n),
    }
    rows = cbpt.read_readings(plan, need_preload=False)
    made = cbpt.simulate(case, rows, seed=seed, u_elastic_angle_arcsec=u)
    return plan | {"elastic_angle_arcsec": np.array(made.elastic_angle_arcsec)}


def found(*tables: dict[str, NDArray[np.float64]]) -> cbpt.Change:
    return cbpt.change(SPRING, *tables, effects=[FRICTION])


def by_step(*friction_Nm: float) -> dict[str, NDArray[np.float64]]:
    """One table, a step for each friction."""
    parts = [loops(f, seed=s) for s, f in enumerate(friction_Nm)]
    table = {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}
    table["run"] = np.repeat(np.arange(2.0 * len(parts)), len(LOOP))
    table["step"] = np.repeat(np.arange(1.0, len(parts) + 1), 2 * len(LOOP))
    return table
