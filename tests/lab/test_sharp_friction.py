"""Friction that reaches its limit at once: a spring that slips, behind it a play.

The loops of a gearbox as somebody would simulate them: one elastic-plastic element (Jenkin) beside
a spring with a sharp play, solved here without the product.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt

Floats = NDArray[np.float64]

STIFFNESS_Nm_per_deg = 72.0
NOISE_deg = 0.001
CASE = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": STIFFNESS_Nm_per_deg / 60}}


def loop_deg(torque_Nm: Floats, play_deg: float, friction_Nm: float) -> Floats:
    """The angle along a way from rest, by bisection of the balance at each torque."""
    slips_after_deg = 0.02
    found, friction, angle = [], 0.0, 0.0
    for torque in torque_Nm:
        low, high = -20.0, 20.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            held = friction + friction_Nm * (middle - angle) / slips_after_deg
            held = min(max(held, -friction_Nm), friction_Nm)
            taken_up = middle - min(max(middle, -0.5 * play_deg), 0.5 * play_deg)
            if STIFFNESS_Nm_per_deg * taken_up + held > torque:
                high = middle
            else:
                low = middle
        friction, angle = held, middle
        found.append(middle)
    return np.array(found)


def table(play_deg: float, friction_Nm: float, seed: int) -> dict[str, Floats]:
    """Two small loops and two large ones, each from rest, as a file has them."""
    rng = np.random.default_rng(seed)
    columns: dict[str, list[Any]] = {"run": [], "time_s": [], "torque_Nm": [], "angle": []}
    start_s = 0.0
    for run, (most, steps) in enumerate([(5.0, 21), (5.0, 21), (40.0, 54), (40.0, 54)], 1):
        leg = np.linspace(0.0, most, steps)
        torque = np.concatenate([leg, leg[-2::-1], -leg[1:], -leg[-2::-1], leg[1:]])
        angle = loop_deg(torque, play_deg, friction_Nm) + rng.normal(0, NOISE_deg, len(torque))
        columns["run"].append(np.full(len(torque), float(run)))
        columns["time_s"].append(start_s + 0.5 * np.arange(len(torque)))
        columns["torque_Nm"].append(np.round(torque, 2))
        columns["angle"].append(np.round(angle, 4))
        start_s += 0.5 * len(torque) + 120
    found = {name: np.concatenate(parts) for name, parts in columns.items()}
    found["elastic_angle_deg"] = found.pop("angle")
    return found


@pytest.mark.parametrize(("play_deg", "friction_Nm"), [(0.12, 1.07), (0.05, 1.63)])
def test_play_and_friction_are_told_alone_and_rightly(play_deg: float, friction_Nm: float) -> None:
    found = cbpt.diagnose(CASE, table(play_deg, friction_Nm, 7))
    assert set(found.verdict.effects) == {"backlash", "friction_hysteresis"}
    assert found.remains() is None
    results = found.results()
    play, friction = (
        results["backlash.play_arcsec"],
        results["friction_hysteresis.friction_torque_Nm"],
    )
    for row, truth in ((play, 3600 * play_deg), (friction, friction_Nm)):
        assert row.value is not None and row.u is not None
        assert abs(row.value - truth) < 3 * row.u < 0.1 * truth


def test_what_changed_has_the_values_of_both_states() -> None:
    before, after = table(0.12, 1.07, 7), table(0.05, 1.63, 8)
    found = cbpt.change(CASE, before, after)
    told = {c.parameter: c for c in found.changed}
    assert set(told) == {"play_rad", "friction_torque_Nm"}
    for name, truth in (
        ("play_rad", np.radians([0.12, 0.05])),
        ("friction_torque_Nm", np.array([1.07, 1.63])),
    ):
        changed = told[name]
        assert changed.u_before is not None and changed.u_after is not None
        assert abs(changed.before - truth[0]) < 3 * changed.u_before
        assert abs(changed.after - truth[1]) < 3 * changed.u_after


def test_the_torque_along_a_loop_is_the_closed_form() -> None:
    """Energy of a loop of a spring that slips: 4 Tf0 (A - alpha_p) at the amplitude A."""
    case = CASE | {
        "effect": [
            {
                "id": "friction_hysteresis",
                "friction_torque_Nm": 2.0,
                "engagement_angle_arcsec": 36.0,
                "build_up_exponent": 0.0,
            }
        ]
    }
    leg = np.linspace(0.0, 10.0, 2001)
    torque = np.concatenate([leg, leg[-2::-1], -leg[1:], -leg[-2::-1], leg[1:]])
    read = {"torque_Nm": torque, "elastic_angle_deg": np.zeros(len(torque))}
    angle = np.radians(cbpt.compare(case, read).model.elastic_angle_arcsec / 3600)
    around = slice(len(leg) - 1, None)
    t, a = torque[around], angle[around]
    energy = np.sum(0.5 * (t[1:] + t[:-1]) * np.diff(a))
    amplitude = (10.0 - 2.0) / STIFFNESS_Nm_per_deg
    expected = 4 * 2.0 * np.radians(amplitude - 0.01)
    np.testing.assert_allclose(energy, expected, rtol=1e-3)
