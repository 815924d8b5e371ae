"""Creep that grows with a power of time (Andrade), as polymers and greased joints show it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common.friction_loops import LOOP, SPRING


def creeping(exponent: float, size_arcsec: float, seed: int) -> dict[str, NDArray[Any]]:
    """Two loops of a spring, each step of torque of which creeps from its own time on; size_arcsec
    after a minute under 1 N m; 2 arcsec of noise."""
    rng = np.random.default_rng(seed)
    torque = np.tile(LOOP, 2)
    run = np.repeat([0, 1], len(LOOP))
    time = np.tile(2.0 * np.arange(len(LOOP)), 2)
    since = np.maximum(time[: len(LOOP), None] - time[None, : len(LOOP)], 0.0)
    crept = (since / 60) ** exponent @ np.diff(LOOP, prepend=0.0)
    angle = 60 * torque + size_arcsec * np.tile(crept, 2) + rng.normal(0, 2.0, len(torque))
    return {
        "run": run,
        "time_s": time,
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle,
        "u_elastic_angle_arcsec": np.full(len(torque), 2.0),
    }


@pytest.mark.parametrize(("exponent", "seed"), [(0.3, 1), (0.2, 2), (0.4, 3)])
def test_creep_with_a_power_of_time_has_no_friction_beside_it(exponent: float, seed: int) -> None:
    """Its quick beginning is no logarithm of time: friction, or one of several, was certain."""
    found = cbpt.diagnose(SPRING, creeping(exponent, 15.0, seed))
    assert found.verdict.effects == ("creep",), found.sentence
    assert not found.verdict.rivals
    q = found.parameters(found.after, "creep")["growth_exponent"]
    assert abs(q["value"] - exponent) < 3.3 * q["u"]
