"""What changed where more than the named effects is at work: an offered set is searched whole.

Loops of a spring with play and friction on a shaft that the load moves one way, before and after.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.selection.fit_effects import fits_of_forms
from common.springs import Reducer, loops

CASE = cbpt.Case.from_dict(
    {
        "torsion_spring": {"torsional_stiffness_Nm_per_rad": 2000.0},
        "measurement": {"zero": "per_run"},
        "uncertainty": {"contact_stiffness_rel": 0.3},
    }
)
BEFORE = Reducer(play_rad=0.004, friction_Nm=1.5, load_share=0.05)
AFTER = replace(BEFORE, friction_Nm=2.1, stiffness_Nm_per_rad=2500.0, play_rad=0.002)


def measured(reducer: Reducer, seed: int) -> dict[str, NDArray[np.float64]]:
    """Two small loops and two large ones, with an angle that grows alike under both signs of the
    torque."""
    parts = [
        loops([reducer] * 2, noise_rad=5e-5, seed=seed + 10 * k, peak_Nm=peak)
        for k, peak in enumerate((4.0, 30.0))
    ]
    names = "time_s", "torque_Nm", "elastic_angle_rad"
    table = {name: np.concatenate([part[name] for part in parts]) for name in names}
    table["elastic_angle_rad"] += 1e-4 * np.abs(table["torque_Nm"])
    return table | {"run": np.repeat(np.arange(4), 64)}


def test_all_that_changed_is_told_beside_what_nobody_named() -> None:
    """Play fell, friction and stiffness rose, and the shift of the shaft stayed. A gain of the
    torque was told to have fallen, and the shift to have risen, for certain: with the shift only
    what had seemed to change without it was tried."""
    tables = measured(BEFORE, 1), measured(AFTER, 2)
    found = cbpt.change(CASE, *tables, effects=["backlash", "friction_hysteresis"])
    assert "shaft_shift" in {v.effect for v in found.weighed.best.levels.variants}
    told = {c.parameter: c for c in found.foremost}
    assert {c.effect: c.direction for c in found.foremost} == {
        "backlash": "down",
        "contact_stiffness": "up",
        "friction_hysteresis": "up",
    }
    assert told["play_rad"].after == pytest.approx(0.002, rel=0.05)
    assert told["friction_torque_Nm"].after == pytest.approx(2.1, rel=0.05)
    assert told["stiffness_scale"].after == pytest.approx(1.25, rel=0.03)


def test_a_form_that_no_start_shows_does_not_end_the_fit() -> None:
    """One that a diagnosis reached from another form ended `cbpt change`."""
    readings = cbpt.read_readings(measured(BEFORE, 1), need_preload=False)
    first = readings.select(readings.run_index == 0)  # what settles from run to run is a zero here
    fitter = Fitter(campaign_of(CASE, first, []))
    hidden = {"run_in:settled"}
    found = fits_of_forms(fitter, ["run_in"], hidden)
    assert found and hidden.isdisjoint(v.label for forms in found for v in forms)
