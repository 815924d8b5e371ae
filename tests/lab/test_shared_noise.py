"""Property: no set of effects is behind for want of the kind of noise that the best one has."""

from __future__ import annotations

import numpy as np

import cbpt
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.selection.model_comparison import _Contest
from cbpt.lab.selection.refits import kind_of
from cbpt.lab.selection.setting import prepare, with_an_artefact

SPRING = cbpt.Case.from_toml("[torsion_spring]\ntorsional_stiffness_Nm_per_rad = 2000.0\n")


def test_a_set_as_far_behind_as_the_kind_of_noise_is_worth_is_tried_with_it() -> None:
    """A graduated disc whose error repeats every 1000 arcsec, and a curve that is the spring's or
    the sensor's. The one with that noise was 185 ahead, and only sets within 25 were tried."""
    up = np.linspace(0.0, 30.0, 13)
    torque = np.tile(np.concatenate([up, up[-2::-1], -up[1:], -up[-2::-1]]), 3)
    angle = np.rad2deg(torque / 2000.0) * 3600
    angle = angle + 60.0 * np.sin(2 * np.pi * angle / 1000.0) + 30.0 * (torque / 30.0) ** 2
    table = {
        "run": np.repeat([1, 2, 3], len(torque) // 3),
        "time_s": 5.0 * np.arange(len(torque)),
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle + 4.0 * np.random.default_rng(0).standard_normal(len(torque)),
        "u_elastic_angle_arcsec": np.full(len(torque), 4.0),
    }
    readings = cbpt.read_readings(table, need_preload=False)
    made = _Contest(prepare(Fitter(campaign_of(SPRING, readings, []))), lambda what, share: None)
    fitter, forms = made.fitter, {v.label: v for v in made.fitter.variants}
    plain = [
        fitter.fit(Hypothesis((forms[f],))) for f in ("stiffness_curve", "sensor_nonlinearity")
    ]
    spring, sensor = (fit for fit in plain if fit is not None)
    noises = with_an_artefact(fitter, spring, fitter.campaign.plain_noise)
    found = (fitter.fit(spring.hypothesis, spring.point.values, noise) for noise in noises)
    best = max((fit for fit in found if fit is not None), key=lambda fit: fit.log_evidence)
    for fit in (best, sensor):
        made.fits[fit.hypothesis.effects] = fit
    assert made.score(("sensor_nonlinearity",)) < made.score(("stiffness_curve",)) - 100
    made.share_noise()
    assert kind_of(made.fits["sensor_nonlinearity",].noise) == kind_of(best.noise)
    assert made.score(("sensor_nonlinearity",)) > made.score(("stiffness_curve",)) - 10
