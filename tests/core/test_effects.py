"""Effects of the core against the rig's own, which shares nothing with them, and their Python face.

Each effect at a typical size in the form that both have, on one campaign, for three drives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import cbpt
from cbpt import Drive, InvalidInputError, _core
from common.play import following
from common.rings import PLAN, RINGS, CaseDict
from reference.rig import ARCSEC, Rows, drive_of, simulate
from reference.rig.campaign import rows_of
from reference.rig.effects import LIBRARY, Hidden, hidden
from reference.rig.kinds import Kind

Floats = NDArray[np.float64]

CASES: dict[str, CaseDict] = {
    "rings": RINGS,
    "slide": {**RINGS, "equal_speed": {**RINGS["equal_speed"], "kind": "cross_slide"}},
    "epicycloid": {
        **RINGS,
        "deceleration": {**RINGS["deceleration"], "output_plate": "epicycloid"},
    },
}
ROWS = rows_of(PLAN, RINGS, np.random.default_rng(0))

Values = dict[str, float]
# What the rig hides, and the same in the numbers of the library: effect by effect.
SAME: dict[str, tuple[Values, Callable[[Values], list[Values]]]] = {
    "contact_stiffness": ({"scale": 0.8}, lambda v: [{"stiffness_scale": v["scale"]}]),
    "contact_angle": (
        {"shift_rad": 0.03},
        lambda v: [{"contact_angle_shift_rad": v["shift_rad"]}],
    ),
    "torque_scale": ({"gain": 1.04}, lambda v: [{"torque_gain": v["gain"]}]),
    "preload_scale": ({"gain": 1.1}, lambda v: [{"preload_gain": v["gain"]}]),
    "sensor_gain": ({"gain": 1.2}, lambda v: [{"sensor_gain": v["gain"]}]),
    "sensor_nonlinearity": (
        {"error_rad": 3 * ARCSEC, "cubic_share": 0.4},
        lambda v: [
            {
                "quadratic_per_rad": v["error_rad"] * 0.6 / (60 * ARCSEC) ** 2,
                "cubic_per_rad2": v["error_rad"] * 0.4 / (60 * ARCSEC) ** 3,
            }
        ],
    ),
    "drift": (
        {"total_rad": 4 * ARCSEC},
        lambda v: [{"rate_rad_per_s": v["total_rad"] / float(np.ptp(ROWS.time_s))}],
    ),
    "eccentric_bearing": (
        {"u_ref_m": 4e-7, "exponent": 2 / 3},
        lambda v: [{"reference_deflection_m": v["u_ref_m"], "exponent": v["exponent"]}],
    ),
    "bearing_play": ({"clearance_m": 4e-6}, lambda v: [{"clearance_m": v["clearance_m"]}]),
    "output_torsion": (
        {"compliance_rad_per_Nm": 2e-6},
        lambda v: [{"compliance_rad_per_Nm": v["compliance_rad_per_Nm"]}],
    ),
    "friction_hysteresis": (
        {"mu_T_m": 5e-4, "length_rad": 6 * ARCSEC},
        lambda v: [{"friction_radius_m": v["mu_T_m"], "engagement_angle_rad": v["length_rad"]}],
    ),
    "preload_loss": ({"share": 0.12}, lambda v: [{"lost_share": v["share"]}]),
    "preload_spring": (
        {"rate_N_per_m": 3e8},
        lambda v: [{"spring_rate_N_per_m": v["rate_N_per_m"]}],
    ),
    "thermal_preload": ({"rate_N_per_K": 20.0}, lambda v: [{"rate_N_per_K": v["rate_N_per_K"]}]),
    "eccentricity_error": (
        {"offset_m": 6e-7, "phase_rad": 0.7},
        lambda v: [
            {
                "offset_sine_m": v["offset_m"] * np.cos(v["phase_rad"]),
                "offset_cosine_m": v["offset_m"] * np.sin(v["phase_rad"]),
            }
        ],
    ),
    "groove_pitch_error": (
        {"harmonic": 3.0, "amplitude_m": 5e-7, "phase_rad": 0.4},
        lambda v: [
            {
                "harmonic": v["harmonic"],
                "cosine_m": v["amplitude_m"] * np.cos(v["phase_rad"]),
                "sine_m": -v["amplitude_m"] * np.sin(v["phase_rad"]),
            }
        ],
    ),
    "ball_diameter_lot": (
        {"spread_m": 3e-7, "seed": 5.0},
        lambda v: [
            {"ball": float(i), "oversize_m": v["spread_m"] * float(x)}
            for i, x in enumerate(_lot(int(v["seed"])))
        ],
    ),
    "plate_tilt": (
        {"tilt_rad": 2e-5, "phase_rad": 0.6},
        lambda v: [
            {
                "tilt_cosine_rad": v["tilt_rad"] * np.cos(v["phase_rad"]),
                "tilt_sine_rad": v["tilt_rad"] * np.sin(v["phase_rad"]),
            }
        ],
    ),
    "rough_contact": ({"excess": 0.3}, lambda v: [{"exponent": 1.5 + v["excess"]}]),
    "run_in": ({"set_rad": 5 * ARCSEC}, lambda v: [{"permanent_set_rad": v["set_rad"]}]),
    "wear": (
        {"lost_share": 0.08},
        lambda v: [{"lost_share_per_s": v["lost_share"] / float(np.ptp(ROWS.time_s))}],
    ),
    "creep": (
        {"rate_rad_per_Nm": 6e-7, "tau_s": 20.0},
        lambda v: [{"compliance_rad_per_Nm": v["rate_rad_per_Nm"], "time_constant_s": v["tau_s"]}],
    ),
}


def _lot(seed: int) -> Floats:
    lot = np.random.default_rng(seed).standard_normal(20)
    return np.asarray(lot - lot.mean())


def rig_drive(case: CaseDict) -> Any:
    """The rig names the output by another key."""
    plates = {
        **case["deceleration"],
        "output": case["deceleration"].get("output_plate", "hypocycloid"),
    }
    return drive_of({**case, "deceleration": plates})


def predictor(drive: Drive, effects: list[str], rows: Rows = ROWS) -> _core.Predictor:
    return _core.Predictor(
        drive,
        effects,
        rows.run.astype(np.int64),
        rows.time_s,
        rows.torque_Nm,
        rows.preload_N,
        rows.input_angle_rad,
        rows.temperature_degC,
    )


def of_rig(effect_id: str) -> Hidden:
    return hidden(effect_id, "library", **SAME[effect_id][0])


def values_of(found: _core.Predictor, numbers: list[Values]) -> Floats:
    """Neutral values with the numbers of each effect put in."""
    values = found.neutral()
    for i, (effect, _, parameter) in enumerate(found.parameters):
        values[i] = numbers[effect].get(parameter.name, values[i])
    return values


def test_every_effect_that_the_rig_has_is_compared() -> None:
    ids = [spec.id for spec in _core.effect_specs() if "ball_drive" in spec.reducers]
    # test_loop_forms.py, test_breakaway.py
    of_loops = {"hard_stop", "distributed_friction", "rate_friction", "breakaway_friction"}
    of_torque = {"torque_zero", "torque_lag", "torque_hysteresis", "damping"}
    instruments = {
        *of_torque,
        "preload_crosstalk",
        "shaft_shift",
        "sensor_hysteresis",
        "loose_fixture",
    }
    alone = {"run_offset", "span_drift", *instruments, *of_loops}
    assert set(SAME) == set(ids) - alone == set(LIBRARY) - {"run_offset"}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("effect_id", SAME)
def test_an_effect_is_that_of_the_rig(effect_id: str, case: str) -> None:
    theirs, ours = SAME[effect_id]
    numbers = ours(theirs)
    found = predictor(Drive.from_dict(CASES[case]), [effect_id] * len(numbers))
    prediction = found.predict(values_of(found, numbers))
    assert prediction.solved.all()
    wanted = simulate(rig_drive(CASES[case]), ROWS, [of_rig(effect_id)])
    plain = simulate(rig_drive(CASES[case]), ROWS)
    assert np.abs(wanted - plain).max() > 0.1 * ARCSEC
    np.testing.assert_allclose(prediction.angle_rad, wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_a_zero_error_of_the_torque_is_another_torque(case: str) -> None:
    """Under all that follows from the torque."""
    others = ["eccentric_bearing", "preload_spring", "sensor_nonlinearity"]
    found = predictor(Drive.from_dict(CASES[case]), ["torque_zero", *others])
    numbers = [{"zero_error_Nm": 0.3}, *(SAME[each][1](SAME[each][0])[0] for each in others)]
    shifted = replace(ROWS, torque_Nm=ROWS.torque_Nm - 0.3)
    wanted = simulate(rig_drive(CASES[case]), shifted, [of_rig(each) for each in others])
    angle = found.predict(values_of(found, numbers)).angle_rad
    np.testing.assert_allclose(angle, wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_a_torque_that_lags_one_with_hysteresis_and_damping_are_other_torques(case: str) -> None:
    """By their equations, reading for reading."""
    torque = ROWS.torque_Nm
    drive = Drive.from_dict(CASES[case])
    for effect, number, value in (
        ("torque_lag", "lag_s", 0.7),
        ("damping", "time_constant_s", 0.7),
        ("torque_hysteresis", "half_width_Nm", 0.2),
        ("torque_hysteresis", "half_width_Nm", -0.2),
    ):
        loads = torque.copy()
        for run in np.unique(ROWS.run):
            here = np.flatnonzero(ROWS.run == run)
            loads[here] += _added(effect, value, ROWS.time_s[here], torque[here])
        assert np.abs(loads - torque).max() > 0.01
        found = predictor(drive, [effect])
        angle = found.predict(values_of(found, [{number: value}])).angle_rad
        wanted = simulate(rig_drive(CASES[case]), replace(ROWS, torque_Nm=loads))
        np.testing.assert_allclose(angle, wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_a_sensor_with_hysteresis_shows_what_follows_the_angle_through_a_slack(case: str) -> None:
    """By its equation, reading for reading, ahead of what the sensor makes of the angle."""
    half, gain = 0.8 * ARCSEC, 1.02
    found = predictor(Drive.from_dict(CASES[case]), ["sensor_gain", "sensor_hysteresis"])
    shown = found.predict(values_of(found, [{"sensor_gain": gain}, {"half_width_rad": half}]))
    true = simulate(rig_drive(CASES[case]), ROWS)
    wanted = gain * following(true, half, ROWS.run)
    assert np.ptp(wanted / gain - true) > 1.9 * half
    np.testing.assert_allclose(shown.angle_rad, wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_an_instrument_that_warms_up_drifts_until_it_is_warm(case: str) -> None:
    """In the time of the table, whatever the runs do."""
    found = predictor(Drive.from_dict(CASES[case]), ["drift"])
    passed = ROWS.time_s - ROWS.time_s[0]
    time_s = float(passed.max()) / 4
    numbers = [{"warm_up_rad": 3 * ARCSEC, "warm_up_time_s": time_s}]
    wanted = simulate(rig_drive(CASES[case]), ROWS) + 3 * ARCSEC * (1 - np.exp(-passed / time_s))
    angle = found.predict(values_of(found, numbers)).angle_rad
    np.testing.assert_allclose(angle, wanted, rtol=1e-8, atol=1e-12)


def _added(effect: str, value: float, time_s: Floats, torque_Nm: Floats) -> Floats:
    """To the torques of a run, N m."""
    if effect == "torque_hysteresis":
        run = np.zeros(len(torque_Nm), dtype=np.int64)
        return np.asarray(np.sign(value) * (torque_Nm - following(torque_Nm, abs(value), run)))
    arriving, leaving = _rates(time_s, torque_Nm)
    if effect == "torque_lag":
        return np.asarray(value * arriving)
    late = [0.0]
    for i in range(len(time_s) - 1):
        span_s = float(time_s[i + 1] - time_s[i])
        change = (arriving[i + 1] - leaving[i]) / span_s
        step = solve_ivp(
            _late_by(value, float(leaving[i]), float(change)),
            (0.0, span_s),
            [late[-1]],
            rtol=1e-11,
            atol=1e-13,
        )
        late.append(float(step.y[0, -1]))
    return np.array(late)


def _late_by(tau_s: float, rate: float, change: float) -> Callable[[float, Floats], Floats]:
    """What a load late by so much adds to a torque whose rate begins so and changes so."""

    def slope(time_s: float, added: Floats) -> Floats:
        return np.asarray(-rate - change * time_s - added / tau_s)

    return slope


def _rates(time_s: Floats, torque_Nm: Floats) -> tuple[Floats, Floats]:
    """With which the torque of a run from rest arrives at each reading and leaves it."""
    step = np.diff(torque_Nm) / np.diff(time_s)
    change = np.diff(step, prepend=np.nan)
    middle = np.r_[np.nan, (torque_Nm[2:] - torque_Nm[:-2]) / (time_s[2:] - time_s[:-2]), np.nan]
    arriving, leaving = middle.copy(), middle.copy()
    for i in range(2, len(time_s) - 2):
        before, behind = step[i - 1], step[i]
        if abs(behind - before) > 2 * (abs(change[i - 1]) + abs(change[i + 1])):
            arriving[i] = before + change[i - 1] * (
                (time_s[i] - time_s[i - 1]) / (time_s[i] - time_s[i - 2])
            )
            leaving[i] = behind - change[i + 1] * (
                (time_s[i + 1] - time_s[i]) / (time_s[i + 2] - time_s[i])
            )
    arriving[0], arriving[-1] = 0.0, step[-1]
    leaving[0] = step[0]
    if step[0] * step[1] > 0:
        leaving[0] -= change[1] * (time_s[1] - time_s[0]) / (time_s[2] - time_s[0])
    return arriving, leaving


@pytest.mark.parametrize("case", CASES)
def test_a_span_that_drifts_is_a_share_of_the_angle(case: str) -> None:
    found = predictor(Drive.from_dict(CASES[case]), ["span_drift"])
    numbers = [{"rate_per_s": 1e-6, "rate_per_K": -2e-3}]
    plain = simulate(rig_drive(CASES[case]), ROWS)
    assert ROWS.temperature_degC is not None
    passed, warmer = ROWS.time_s - ROWS.time_s[0], ROWS.temperature_degC - ROWS.temperature_degC[0]
    angle = found.predict(values_of(found, numbers)).angle_rad
    wanted = plain * (1 + 1e-6 * passed - 2e-3 * warmer)
    np.testing.assert_allclose(angle, wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_crosstalk_is_another_preload(case: str) -> None:
    found = predictor(Drive.from_dict(CASES[case]), ["preload_crosstalk"])
    numbers = [{"crosstalk_force_N": -30.0, "crosstalk_share": 0.1, "reference_torque_Nm": 4.0}]
    grown = ROWS.preload_N * (1 + 0.025 * ROWS.torque_Nm)
    other = replace(ROWS, preload_N=grown - 7.5 * ROWS.torque_Nm)
    wanted = simulate(rig_drive(CASES[case]), other)
    angle = found.predict(values_of(found, numbers)).angle_rad
    np.testing.assert_allclose(angle, wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_a_shaft_shifts_by_the_true_torque_ahead_of_the_sensor(case: str) -> None:
    """Not by what a torque sensor off zero and off gain reads, which here has the other sign too;
    the angle sensor scales the shift as it scales the angle."""
    true_Nm = 0.85 * ROWS.torque_Nm - 1.3
    assert (true_Nm * ROWS.torque_Nm < 0).any()
    found = predictor(
        Drive.from_dict(CASES[case]), ["sensor_gain", "shaft_shift", "torque_scale", "torque_zero"]
    )
    numbers = [
        {"sensor_gain": 0.9},
        {"shift_rad_per_Nm": -3e-6},
        {"torque_gain": 0.85},
        {"zero_error_Nm": 1.3},
    ]
    plain = simulate(rig_drive(CASES[case]), replace(ROWS, torque_Nm=true_Nm))
    wanted = 0.9 * (plain - 3e-6 * np.abs(true_Nm))
    angle = found.predict(values_of(found, numbers)).angle_rad
    np.testing.assert_allclose(angle, wanted, rtol=1e-8, atol=1e-12)


def test_effects_together_are_those_of_the_rig() -> None:
    """Gains first, then the ports. Not a preload that changes within a run: there the rig's
    friction keeps the limit of the run's start."""
    left_out = ("contact_angle", "ball_diameter_lot", "thermal_preload", "wear")
    ids = [each for each in SAME if each not in (*left_out, "friction_hysteresis")]
    ids.append("friction_hysteresis")  # the rig takes its limit where it is listed
    effects: list[Hidden] = [of_rig(each) for each in ids]
    found = predictor(Drive.from_dict(RINGS), ids)
    numbers = [SAME[each][1](SAME[each][0])[0] for each in ids]
    prediction = found.predict(values_of(found, numbers))
    wanted = simulate(drive_of(RINGS), ROWS, effects)
    np.testing.assert_allclose(prediction.angle_rad, wanted, rtol=1e-8, atol=1e-12)


def test_kinds_of_the_rig_and_of_the_library_agree_on_the_port() -> None:
    ports = {spec.id: spec.port for spec in _core.effect_specs()}
    gains = {"torque_scale", "preload_scale"}
    for each, kind in LIBRARY.items():
        assert isinstance(kind, Kind)
        assert ports[each] == ("reading" if each in gains else kind.port)


# --- the Python face --------------------------------------------------------------------------


def test_sensitivities_and_contributions_have_their_shapes() -> None:
    found = predictor(Drive.from_dict(RINGS), ["creep", "contact_stiffness"])
    assert found.effects == ["creep", "contact_stiffness"]
    names = [(effect, id, number.name) for effect, id, number in found.parameters]
    assert names == [
        (0, "creep", "compliance_rad_per_Nm"),
        (0, "creep", "time_constant_s"),
        (0, "creep", "superposed_compliance_rad_per_Nm"),
        (0, "creep", "power_compliance_rad_per_Nm"),
        (0, "creep", "growth_exponent"),
        (1, "contact_stiffness", "stiffness_scale"),
    ]
    values = np.array([6e-7, 20.0, 0.0, 0.0, 0.3, 0.9])
    prediction = found.predict(values, [5, 0])
    count = len(ROWS)
    assert prediction.angle_rad.shape == (count,) and prediction.sensitivities.shape == (count, 2)
    assert prediction.carrying.shape == (count, 2) and prediction.regime.shape == (count,)
    assert prediction.solved.all() and set(prediction.regime) <= {0, 1, 2}
    creeping = ROWS.torque_Nm * np.log1p(ROWS.run_time_s / 20)
    np.testing.assert_allclose(prediction.sensitivities[:, 1], creeping, rtol=1e-13, atol=1e-15)
    assert found.predict(values).sensitivities.shape == (count, 0)
    parts = dict(found.contributions(values))
    assert list(parts) == ["model", "contact_stiffness", "creep"]
    np.testing.assert_allclose(sum(parts.values()), prediction.angle_rad, rtol=1e-14, atol=1e-18)


def test_rows_without_solution_are_no_numbers() -> None:
    heavy = ROWS.torque_Nm.copy()
    heavy[7] = 1e3
    found = predictor(Drive.from_dict(RINGS), ["creep"], replace(ROWS, torque_Nm=heavy))
    prediction = found.predict(found.neutral(), [0])
    assert prediction.status[7] == "beyond_hold" and prediction.regime[7] == 255
    assert np.flatnonzero(np.isnan(prediction.angle_rad)).tolist() == [7]
    assert np.isnan(prediction.sensitivities[7]).all()


def test_mistakes_are_named() -> None:
    drive = Drive.from_dict(RINGS)
    with pytest.raises(InvalidInputError, match=r"effects\[0\] = crep"):
        predictor(drive, ["crep"])
    with pytest.raises(InvalidInputError, match=r"preload_N\[0\]"):
        predictor(drive, [], replace(ROWS, preload_N=-ROWS.preload_N))
    found = predictor(drive, ["wear"])
    with pytest.raises(InvalidInputError, match="lost_share_per_s of wear"):
        found.predict(np.array([-1.0, 0.0, 3600.0, 0.5, 0.0, 600.0, 0.0, 30.0]))


def test_specs_are_complete() -> None:
    for spec in _core.effect_specs():
        assert spec.kind in ("parameter", "rig", "effect")
        assert spec.equation and spec.source and spec.tell_tale
        for number in spec.parameters:
            low, high = number.range
            assert number.lower <= low < high <= number.upper
            assert number.scale in ("linear", "log", "fixed") and number.meaning


# --- effects of a case ------------------------------------------------------------------------


def test_a_case_takes_effects_and_gives_them_back_in_SI() -> None:
    case = cbpt.Case.from_dict(RINGS)
    lot = [(i, {"ball": float(i), "oversize_um": 0.1 * i}) for i in range(3)]
    effects: list[tuple[str, dict[str, float]]] = [
        *(("ball_diameter_lot", numbers) for _, numbers in lot),
        ("drift", {"rate_arcsec_per_h": 3600.0}),
        ("eccentric_bearing", {"reference_deflection_um": 2.0}),
    ]
    more = case.with_effects(effects)
    assert more.drive == case.drive and case.effects == []
    found = [(effect.id, dict(effect.values)) for effect in more.effects]
    assert found[:3] == [
        ("ball_diameter_lot", {"ball": i, "oversize_m": pytest.approx(1e-7 * i)}) for i in range(3)
    ]
    assert found[3][1] == {
        "rate_rad_per_s": pytest.approx(ARCSEC),
        "rate_rad_per_K": 0.0,
        "time_constant_s": 0.0,
        "warm_up_rad": 0.0,
        "warm_up_time_s": 600.0,
    }
    assert found[4] == ("eccentric_bearing", {"reference_deflection_m": 2e-6, "exponent": 0.9})
    assert cbpt.Case.from_toml(more.to_toml()) == more
    assert more.with_effects([]) == case


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (("crep", {}), "did you mean creep"),
        (("creep", {"compliance_rad_per_N": 1e-7}), "rad_per_N is not read; use rad_per_Nm"),
        (("creep", {"compliance_rad_per_Nm": -1e-7}), "not less than 0"),
        (("creep", {"compliance_rad_per_Nm": np.nan}), "finite"),
        (("ball_diameter_lot", {"ball": 0.5}), "whole number"),
        (("drift", {"rate_rad_per_s": 0.0, "rate_arcsec_per_h": 1.0}), "same quantity"),
    ],
)
def test_what_no_effect_takes_is_told(effect: tuple[str, dict[str, float]], words: str) -> None:
    with pytest.raises(cbpt.CaseError, match=words):
        cbpt.Case.from_dict(RINGS).with_effects([effect])
