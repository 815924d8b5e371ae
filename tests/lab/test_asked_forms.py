"""Forms of loops that are fitted where they are asked for, and that no diagnosis proposes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.priors import ON_REQUEST
from cbpt.lab.model.spring_priors import library_of

CASE = {"torsion_spring": {"torsional_stiffness_Nm_per_rad": 2000.0}}
NOISE_rad = 2e-5
HIDDEN: dict[str, dict[str, float]] = {
    "distributed_friction": {"friction_torque_Nm": 1.5, "slip_angle_rad": 3e-3},
    "rate_friction": {"friction_torque_Nm": 1.5, "reference_rate_rad_per_s": 4e-4},
    "breakaway_friction": {
        "friction_torque_Nm": 1.5,
        "engagement_angle_rad": 2e-4,
        "breakaway_share": 0.4,
        "weakening_ratio": 8.0,
    },
    "hard_stop": {"taken_share": 0.8, "stop_torque_Nm": 14.0},
    "loose_fixture": {"fixture_play_rad": 5e-4, "holding_torque_Nm": 9.0},
}
SIZES = {effect: next(iter(numbers)) for effect, numbers in HIDDEN.items()}


def table(effect: str) -> dict[str, Any]:
    """A large loop at two rates and a small one inside it."""
    parts = []
    for number, (peak, length_s) in enumerate([(20.0, 60.0), (20.0, 6.0), (6.0, 60.0)], 1):
        time = np.linspace(0.0, length_s, 64)
        torque = np.interp(time, length_s * np.array([0, 0.25, 0.75, 1]), [0.0, peak, -peak, 0.0])
        parts.append((np.full(64, number), 100.0 * number + time, torque))
    run, time, torque = (np.concatenate(column) for column in zip(*parts, strict=True))
    data: dict[str, Any] = {
        "run": run,
        "time_s": time,
        "torque_Nm": torque,
        "elastic_angle_rad": 0 * time,
    }
    case = cbpt.Case.from_dict(CASE).with_effects([(effect, HIDDEN[effect])])
    angle = np.deg2rad(cbpt.compare(case, data).model.elastic_angle_arcsec / 3600)
    noise = NOISE_rad * np.random.default_rng(1).standard_normal(len(run))
    return data | {"elastic_angle_rad": angle + noise}


@pytest.mark.parametrize("effect", HIDDEN)
def test_a_form_is_fitted_where_it_is_asked_for(effect: str) -> None:
    found = cbpt.fit(CASE, table(effect), [effect])
    numbers = found.parameters()[effect]
    for name, true in HIDDEN[effect].items():
        close = max(0.05 * true, 3 * numbers[name]["u"])
        assert numbers[name]["value"] == pytest.approx(true, abs=close), name
        assert numbers[name]["u"] < 0.2 * true, name
    assert found.after.rmse_arcsec < 1.1 * np.rad2deg(NOISE_rad) * 3600


def test_not_every_diagnosis_proposes_them() -> None:
    """But for a stop near the end of the torques, contacts that slip one after another, as creep
    looks like them, and friction by the rate where there are times, as a late torque sensor does.
    """
    assert set(HIDDEN) == set(ON_REQUEST)
    timeless = {k: column for k, column in table("hard_stop").items() if k != "time_s"}
    for data, proposed in (
        (timeless, {"hard_stop", "distributed_friction"}),
        (table("hard_stop"), {"rate_friction", "hard_stop", "distributed_friction"}),
    ):
        campaign = campaign_of(cbpt.Case.from_dict(CASE), cbpt.compare(CASE, data).readings, ())
        assert {v.effect for v in Fitter(campaign).variants} & set(ON_REQUEST) == proposed
        asked = Fitter(campaign, asked=["hard_stop"])
        wanted = proposed | {"hard_stop"}
        assert {v.effect for v in asked.variants} & set(ON_REQUEST) == wanted


def test_friction_by_the_rate_grows_within_the_rates_of_the_table() -> None:
    """Far above its reference rate it is a friction that turns over at once, and stood in for one
    on ramps of one rate."""

    def least_share(lengths_s: tuple[float, ...]) -> float:
        """Of the rate of the longest loop."""
        time = np.concatenate([np.linspace(0.0, length, 64) for length in lengths_s])
        one = np.interp(np.linspace(0, 4, 65), [0, 1, 3, 4], [0.0, 20.0, -20.0, 0.0])[:-1]
        torque = np.tile(one, len(lengths_s))
        data = {
            "run": np.repeat(np.arange(1.0, len(lengths_s) + 1), 64),
            "time_s": time,
            "torque_Nm": torque,
            "elastic_angle_rad": torque / 2000.0,
        }
        readings = cbpt.read_readings(data, need_preload=False)
        variants = library_of(campaign_of(cbpt.Case.from_dict(CASE), readings, ()))
        [rate] = next(v for v in variants if v.effect == "rate_friction").shapes
        return float(rate.low * max(lengths_s) / (4 * np.ptp(data["elastic_angle_rad"]) / 2))

    assert least_share((60.0, 60.0)) == pytest.approx(0.5, rel=0.1)
    # Of the slow ones, as half the steps are ten times as fast.
    assert least_share((60.0, 6.0)) < 0.15


def test_a_diagnosis_finds_a_stop_at_the_end_of_a_spring() -> None:
    """It was a stiffer spring with a joint that reaches its stop."""
    verdict = cbpt.diagnose(CASE, table("hard_stop")).verdict
    assert (verdict.kind, verdict.effects) == ("effect", ("hard_stop",))


def test_a_lag_of_the_torque_is_fitted_to_a_spring_where_it_is_asked_for() -> None:
    data = table("hard_stop")
    case = cbpt.Case.from_dict(CASE).with_effects([("torque_lag", {"lag_s": 0.4})])
    angle = np.deg2rad(cbpt.compare(case, data).model.elastic_angle_arcsec / 3600)
    noise = NOISE_rad * np.random.default_rng(1).standard_normal(len(angle))
    found = cbpt.fit(CASE, data | {"elastic_angle_rad": angle + noise}, ["torque_lag"])
    lag = found.parameters()["torque_lag"]["lag_s"]
    assert lag["value"] == pytest.approx(0.4, abs=3 * lag["u"]) and lag["u"] < 0.02


def test_a_mistyped_one_is_helped() -> None:
    with pytest.raises(cbpt.InvalidInputError, match=r"Did you mean hard_stop\?"):
        cbpt.fit(CASE, table("hard_stop"), ["hard_stopp"])


@pytest.mark.parametrize(
    "effect", ["creep", "torque_lag", "rate_friction", "torque_zero:drifting", "span_drift"]
)
def test_the_column_that_one_needs_is_told(effect: str) -> None:
    without = table("hard_stop")
    del without["time_s"]
    with pytest.raises(cbpt.ReadingsError, match=f"'time_s'.*{effect} depends on"):
        cbpt.fit(CASE, without, [effect])


def test_no_column_makes_an_effect_of_balls_one_of_a_spring() -> None:
    with pytest.raises(cbpt.InvalidInputError, match="'thermal_preload' is not an effect"):
        cbpt.fit(CASE, table("hard_stop"), ["thermal_preload"])
    data = table("hard_stop") | {"preload_N": np.full(192, 600.0)}
    campaign = campaign_of(cbpt.Case.from_dict(CASE), cbpt.read_readings(data), ())
    offered = {v.effect for v in library_of(campaign, ["preload_crosstalk", "torque_hysteresis"])}
    assert "preload_crosstalk" not in offered and "torque_hysteresis" in offered


def test_a_change_in_one_is_found_where_it_is_asked_for() -> None:
    before, after = table("distributed_friction"), table("distributed_friction")
    rng = np.random.default_rng(7)
    after["elastic_angle_rad"] = after["elastic_angle_rad"] + NOISE_rad * rng.standard_normal(192)
    found = cbpt.change(CASE, before, after, effects=["distributed_friction"])
    assert found.kind == "nothing"
