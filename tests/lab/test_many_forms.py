"""Effects with many forms: one form is exchanged at a time, and the best choice is found all the
same."""

from __future__ import annotations

import numpy as np
import pytest

from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.readings.reader import read_readings
from cbpt.lab.selection import fit_effects
from cbpt.lab.selection.fit_effects import fits_of_forms, predicted

SPRING = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}}
HIDDEN = [
    {"id": "friction_hysteresis", "friction_torque_Nm": 0.5, "engagement_angle_arcsec": 15.0},
    {"id": "backlash", "play_arcsec": 60.0, "transition_torque_Nm": 0.2},
]
EFFECTS = [
    *("backlash", "friction_hysteresis", "stiffness_curve"),
    *("sensor_nonlinearity", "output_torsion", "torque_zero"),
]


def test_of_many_choices_of_forms_few_are_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    load = np.r_[np.arange(0, 10, 0.5), np.arange(10, -10, -0.5), np.arange(-10, 10.1, 0.5)]
    columns = {
        "torque_Nm": load,
        "time_s": np.arange(float(len(load))),
        "elastic_angle_arcsec": 0 * load,
        "u_elastic_angle_arcsec": np.full(len(load), 2.0),
    }
    case = case_of(SPRING | {"effect": HIDDEN})
    exact = predicted(case, read_readings(columns, need_preload=False)).elastic_angle_arcsec
    noise = np.random.default_rng(0).normal(0, 2.0, len(load))
    table = read_readings(columns | {"elastic_angle_arcsec": exact + noise}, need_preload=False)
    campaign = campaign_of(case_of(SPRING), table, ())
    fitter = Fitter(campaign, library_of(campaign, EFFECTS))
    # Nor are starts that all choices of signatures bring any better.
    monkeypatch.setattr(fit_effects, "_LISTED", 1)
    best, number = [], []
    for whole in (10_000, fit_effects._WHOLE):
        monkeypatch.setattr(fit_effects, "_WHOLE", whole)
        found = fits_of_forms(fitter, EFFECTS)
        best.append(max(fit.log_evidence for fit in found.values()))
        number.append(len(found))
    assert number[1] < 0.6 * number[0]
    # Half a unit of log evidence is no odds.
    assert best[1] > best[0] - 0.5
