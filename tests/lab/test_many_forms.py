"""Effects with many forms: one form is exchanged at a time, and the best choice is found all the
same."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.readings.reader import read_readings
from cbpt.lab.selection import fit_effects
from cbpt.lab.selection.fit_effects import fits_of_forms, predicted
from cbpt.lab.selection.linear_screen import Gain, Screen

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
    best, number = [], []
    usual = fit_effects._EFFORT
    for effort in (replace(usual, whole=10_000), usual):
        monkeypatch.setattr(fit_effects, "_EFFORT", effort)
        found = fits_of_forms(fitter, EFFECTS)
        best.append(max(fit.log_evidence for fit in found.values()))
        number.append(len(found))
    assert number[1] < 0.6 * number[0]
    # Half a unit of log evidence is no odds.
    assert best[1] > best[0] - 0.5


def test_of_many_choices_of_signatures_one_is_exchanged_at_a_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of three effects with some signatures each: the best two choices of all."""
    rng = np.random.default_rng(3)
    alone = rng.normal(0, 5.0, 30)
    together = rng.normal(0, 1.0, (30, 30))

    class Known:
        """A screen whose gains are those of each signature, and a little of each two."""

        def gain(self, members: tuple[int, ...]) -> Gain:
            each, two = alone[list(members)], together[np.ix_(members, members)]
            return Gain(members, float(each.sum() + np.triu(two, 1).sum()), 0.0, np.zeros(3))

        def single(self, member: int) -> Gain:
            return self.gain((member,))

        def each(self, members: NDArray[np.int64]) -> list[Gain]:
            return [self.gain(tuple(m)) for m in members.tolist()]

    members = [[0, 1, 2], [10, 11, 12], [20, 21, 22, 23]]
    listed = fit_effects._promising(cast("Screen", Known()), members)
    monkeypatch.setattr(fit_effects, "_EFFORT", replace(fit_effects._EFFORT, listed=1))
    exchanged = fit_effects._promising(cast("Screen", Known()), members)
    assert [gain.members for gain in exchanged] == [gain.members for gain in listed]
    assert len({gain.members for gain in exchanged}) == 2
