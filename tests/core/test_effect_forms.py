"""Forms of effects against formulas and integrators of NumPy and SciPy: temperatures that lag,
settling over the cycles, joints; and what goes by time in whatever order a table has it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp

import cbpt
from cbpt import Drive, InvalidInputError, _core
from common.rings import RINGS

Floats = NDArray[np.float64]
ARCSEC = np.pi / 648000
SHARES = np.array([0.0, 0.3, 0.7, 1.0, 0.6, 0.1, -0.4, -0.9, -0.2])
RUNS, N = 4, 9
RUN = np.repeat(np.arange(1, RUNS + 1), N)
TIME_s = np.concatenate([60.0 + 700.0 * r + 9.0 * np.arange(N) for r in range(RUNS)])
TORQUE_Nm = np.concatenate([SHARES * peak for peak in (1.5, 3.0, 2.0, 2.5)])
PRELOAD_N = np.repeat([450.0, 600.0, 800.0, 600.0], N)
WARMTH_K = 3.0 * (1 - np.exp(-TIME_s / 900)) + 0.4 * np.sin(TIME_s / 170)
WHOLE = np.arange(RUNS * N)
DRIVE = Drive.from_dict(RINGS)
SPRING = Drive.from_dict({"torsion_spring": {"torsional_stiffness_Nm_per_rad": 5e4}})


def angle(
    effect: str,
    values: dict[str, float],
    rows: NDArray[np.intp] = WHOLE,
    cycle: Floats | None = None,
    drive: Drive = DRIVE,
) -> Floats:
    """Angles (rad) with one effect, or without any where it is empty, of rows of the table in the
    order given."""
    found = _core.Predictor(
        drive,
        [effect] if effect else [],
        RUN[rows].astype(np.int64),
        TIME_s[rows],
        TORQUE_Nm[rows],
        PRELOAD_N[rows] if drive is DRIVE else None,
        np.full(len(rows), 0.3),
        20.0 + WARMTH_K[rows],
        None if cycle is None else cycle[rows],
    )
    at = found.neutral()
    for i, (_, _, parameter) in enumerate(found.parameters):
        at[i] = values.get(parameter.name, at[i])
    return np.asarray(found.predict(at).angle_rad)


def added(effect: str, values: dict[str, float], **how: Any) -> Floats:
    """What one effect adds to the angle."""
    return np.subtract(angle(effect, values, **how), angle("", {}, **how))


def part_temperature_K(time_constant_s: float) -> Floats:
    """Of a part that is as warm as the first reading at first, by an integrator."""
    found = solve_ivp(
        lambda t, part: (np.interp(t, TIME_s, WARMTH_K) - part) / time_constant_s,
        (TIME_s[0], TIME_s[-1]),
        [WARMTH_K[0]],
        t_eval=TIME_s,
        rtol=1e-10,
        atol=1e-12,
        max_step=2.0,
    )
    return np.asarray(found.y[0] - WARMTH_K[0])


@pytest.mark.parametrize("time_constant_s", [60.0, 500.0, 1200.0])
def test_a_part_follows_the_measured_temperature(time_constant_s: float) -> None:
    part = part_temperature_K(time_constant_s)
    lag = {"time_constant_s": time_constant_s}
    shown = added("drift", {"rate_rad_per_K": 2e-6, **lag})
    np.testing.assert_allclose(shown, 2e-6 * part, rtol=1e-6, atol=1e-12)
    warmer = angle("thermal_preload", {"rate_N_per_K": 30.0, **lag})
    for i in range(0, len(WHOLE), 5):
        alone = DRIVE.solve(TORQUE_Nm[i], PRELOAD_N[i] + 30.0 * part[i], np.rad2deg(0.3))
        assert warmer[i] == pytest.approx(alone.elastic_angle_rad, rel=1e-6, abs=1e-13)


def test_without_lag_a_part_has_the_measured_temperature() -> None:
    shown = added("drift", {"rate_rad_per_K": 2e-6})
    np.testing.assert_allclose(shown, 2e-6 * (WARMTH_K - WARMTH_K[0]), rtol=1e-9, atol=1e-17)


@pytest.mark.parametrize("settled_arcsec", [-6.0, 6.0])
def test_settling_decays_over_the_cycles(settled_arcsec: float) -> None:
    """Of either sign; without a count of cycles over the runs."""
    values = {"settled_rad": settled_arcsec * ARCSEC, "settling_cycles": 1.7}
    done = (RUN - 1).astype(np.float64)
    expected = settled_arcsec * ARCSEC * (1 - np.exp(-done / 1.7))
    np.testing.assert_allclose(added("run_in", values), expected, atol=1e-16)
    twice = added("run_in", values, cycle=2 * done + 5)
    expected = settled_arcsec * ARCSEC * (1 - np.exp(-2 * done / 1.7))
    np.testing.assert_allclose(twice, expected, atol=1e-16)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("run_in", {"permanent_set_rad": -4 * ARCSEC}),
        ("run_in", {"settled_rad": 4 * ARCSEC, "settling_cycles": 2.0}),
        ("drift", {"rate_rad_per_s": 1e-9, "rate_rad_per_K": 1e-6, "time_constant_s": 300.0}),
        ("thermal_preload", {"rate_N_per_K": 20.0, "time_constant_s": 300.0}),
        ("wear", {"lost_share_per_s": 1e-5}),
        ("wear", {"slowing_lost_share": 0.1, "seated_lost_share": 0.1, "seating_time_s": 500.0}),
    ],
)
def test_history_goes_by_time(effect: str, values: dict[str, float]) -> None:
    """Not by the order in which the runs stand in the file."""
    in_order = angle(effect, values)
    shuffled = np.concatenate([WHOLE[N * r : N * (r + 1)] for r in (2, 0, 3, 1)])
    np.testing.assert_array_equal(angle(effect, values, shuffled), in_order[shuffled])


# --- sensors ----------------------------------------------------------------------------------


def test_a_spring_may_bend_otherwise_than_stated() -> None:
    """Two odd terms, each as large at the reference torque as it says."""
    values = {"squared_rad": -3e-6, "cubed_rad": 2e-6, "reference_torque_Nm": 2.0}
    x = TORQUE_Nm / 2.0
    expected = -3e-6 * x * np.abs(x) + 2e-6 * x**3
    found = added("stiffness_curve", values, drive=SPRING)
    np.testing.assert_allclose(found, expected, atol=1e-17)


def test_a_sensor_may_flatten_beyond_a_knee() -> None:
    s, k = 3e-5, 10 * ARCSEC
    plain = angle("sensor_nonlinearity", {})
    found = angle("sensor_nonlinearity", {"flattening_rad": s, "knee_rad": k})
    np.testing.assert_allclose(found, plain + s * (np.tanh(plain / k) - plain / k), rtol=1e-9)
    assert np.abs(plain).max() > k


# --- joints -----------------------------------------------------------------------------------

C = 2e-6


@pytest.mark.parametrize("drive", [DRIVE, SPRING], ids=["balls", "spring"])
def test_a_joint_may_be_softer_one_way(drive: Drive) -> None:
    found = added("output_torsion", {"compliance_rad_per_Nm": C, "asymmetry": 0.4}, drive=drive)
    expected = C * np.where(TORQUE_Nm > 0, 1.4, 0.6) * TORQUE_Nm
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-17)


def test_a_joint_may_be_clamped_by_the_preload() -> None:
    found = added("output_torsion", {"compliance_rad_per_Nm": C, "preload_exponent": 1 / 3})
    expected = C * TORQUE_Nm * (500 / PRELOAD_N) ** (1 / 3)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-17)
    with pytest.raises(InvalidInputError, match="preload_exponent of output_torsion"):
        angle("output_torsion", {"preload_exponent": 0.5}, drive=SPRING)


@pytest.mark.parametrize("drive", [DRIVE, SPRING], ids=["balls", "spring"])
def test_a_joint_may_stiffen_and_come_to_a_stop(drive: Drive) -> None:
    stiffening = {"compliance_rad_per_Nm": C, "stiffening_per_Nm": 0.8}
    expected = [
        np.sign(m) * quad(lambda x: C / (1 + 0.8 * x), 0, abs(m), epsabs=1e-16)[0]
        for m in TORQUE_Nm
    ]
    found = added("output_torsion", stiffening, drive=drive)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-16)
    stop = {"compliance_rad_per_Nm": C, "stop_torque_Nm": 0.9}
    found = added("output_torsion", stop, drive=drive)
    np.testing.assert_allclose(found, C * TORQUE_Nm.clip(-0.9, 0.9), rtol=1e-9, atol=1e-17)


def test_defaults_of_forms_change_no_bit() -> None:
    """A case of before, without the numbers of these forms, is the same case."""
    plain = cbpt.Case.from_dict(RINGS).with_effects(
        [("output_torsion", {"compliance_rad_per_Nm": C})]
    )
    assert dict(plain.effects[0].values)["asymmetry"] == 0.0
    linear = angle("output_torsion", {"compliance_rad_per_Nm": C})
    np.testing.assert_array_equal(linear, angle("", {}) + C * TORQUE_Nm)
