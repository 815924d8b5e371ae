"""Loops that do not close, or that are not about zero torque."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.characteristics.loops import Loop, loops_of
from cbpt.lab.characteristics.symmetry import middle_of

Floats = NDArray[np.float64]
RATED, AMPLITUDE, PLAY, FRICTION = 10.0, 12.0, 90.0, 0.52
CASE = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "rating": {"rated_torque_Nm": RATED},
    "uncertainty": {"torque_gain_rel": 0.0, "sensor_gain_rel": 0.0},
}
TRUTH = {"lost_motion": 36.0, "hysteresis_loss": PLAY + 120 * FRICTION, "backlash": PLAY}


def angles(torque: Floats) -> Floats:
    """A play and a spring of 60 arcsec/(N m) behind dry friction, from rest."""
    held = [0.0]
    for value in torque.tolist():
        held.append(min(max(held[-1], value - FRICTION), value + FRICTION))
    spring = np.array(held[1:])
    return np.asarray(0.5 * np.sign(spring) * PLAY + 60 * spring)


def settled(torque: Floats) -> Floats:
    """The same when it is run for the second time."""
    return angles(np.tile(torque, 2))[len(torque) :]


def from_zero(step: float = 0.1) -> Floats:
    """0, T, -T, 0 in the middle of the steps."""
    up = np.arange(-AMPLITUDE + 0.5 * step, AMPLITUDE, step)
    return np.concatenate([up[up > 0], up[-2::-1], up[(up > up[0]) & (up < 0)]])


def from_end(step: float = 0.1, zero: float = 0.0) -> Floats:
    """-T, T, -T about a torque."""
    up = np.arange(-AMPLITUDE + 0.5 * step, AMPLITUDE, step)
    return np.concatenate([up, up[-2::-1]]) + zero


def table(torque: Floats, angle: Floats, runs: int = 1, noise: float = 0.2) -> cbpt.Readings:
    rng = np.random.default_rng(5)
    rows = {
        "run": np.repeat(np.arange(runs), len(torque)),
        "torque_Nm": np.tile(torque, runs),
        "elastic_angle_arcsec": np.tile(angle, runs) + rng.normal(0, noise, runs * len(torque)),
    }
    return cbpt.read_readings(rows, need_preload=False)


def loop_of(torque: Floats, angle: Floats) -> Loop:
    return loops_of(table(torque, angle, noise=0.0))[0]


def warnings_of(readings: cbpt.Readings) -> str:
    return " ".join(cbpt.characterise(CASE, readings).groups[0].warnings)


# --- loops that do not close --------------------------------------------------------------


@pytest.mark.parametrize(
    ("step", "zero"), [(0.1, 0.0), (0.1, 0.3), (0.1, -0.5), (0.8, 0.0), (0.8, 0.3), (1.5, 0.0)]
)
def test_a_loop_closes_though_its_play_lies_in_the_joint(step: float, zero: float) -> None:
    torque = from_zero(step)
    loop = loop_of(torque + zero, settled(torque))
    assert loop.composed and loop.gap_arcsec is not None
    assert abs(loop.gap_arcsec) < 0.05 * PLAY and loop.open_arcsec is None


def test_a_first_loading_does_not_close() -> None:
    readings = table(from_zero(), angles(from_zero()))
    loop = loops_of(readings)[0]
    assert loop.composed and loop.open_arcsec is not None
    assert loop.open_arcsec == pytest.approx(-(0.5 * PLAY + 60 * FRICTION), rel=0.1)
    assert "does not close" in warnings_of(readings)


@pytest.mark.parametrize("torque", [from_zero(0.5), from_end(0.5)])
def test_scatter_of_the_readings_does_not_open_a_loop(torque: Floats) -> None:
    for loop in loops_of(table(torque, 60 * torque, runs=40, noise=15.0)):
        assert loop.open_arcsec is None


@pytest.mark.parametrize("readings", [7, 9, 13, 21, 49])
@pytest.mark.parametrize("even", [True, False])
def test_a_loop_that_drifts_is_open_however_coarse_it_is(readings: int, even: bool) -> None:
    up = AMPLITUDE * np.linspace(-1, 1, readings)
    up = up if even else AMPLITUDE * (up / AMPLITUDE) ** 3
    torque = np.concatenate([up, up[-2::-1]])
    loop = loops_of(table(torque, settled(torque) + np.linspace(0, 60, len(torque))))[0]
    assert loop.open_arcsec is not None


@pytest.mark.parametrize("name", list(TRUTH))
def test_figures_of_a_first_loading_are_as_uncertain_as_it_is_open(name: str) -> None:
    figure = cbpt.characterise(CASE, table(from_zero(), angles(from_zero()))).figure(name)
    assert figure.value is not None and figure.u is not None
    assert abs(figure.value - TRUTH[name]) < 3 * figure.u


@pytest.mark.parametrize("torque", [from_zero(), from_end()])
@pytest.mark.parametrize("name", list(TRUTH))
def test_figures_of_a_drifting_loop_are_as_uncertain_as_it_is_open(
    torque: Floats, name: str
) -> None:
    drift = np.linspace(0, 12.0, len(torque))
    figure = cbpt.characterise(CASE, table(torque, settled(torque) + drift, runs=3)).figure(name)
    assert figure.value is not None and figure.u is not None
    assert abs(figure.value - TRUTH[name]) < 3 * figure.u


def test_a_drift_is_taken_off_a_closed_loop() -> None:
    torque = from_end()
    still, drifting = (
        loop_of(torque, settled(torque) + np.linspace(0, d, len(torque))) for d in (0.0, 12.0)
    )
    assert drifting.gap_arcsec == pytest.approx(12, abs=0.2)
    assert drifting.closed().width_arcsec == pytest.approx(still.width_arcsec, abs=0.1)


# --- loops that are not about zero --------------------------------------------------------


@pytest.mark.parametrize("zero", [0.1, -0.3, 1.0])
@pytest.mark.parametrize("loop", [from_zero(), from_end()])
def test_loops_about_another_torque_are_told(loop: Floats, zero: float) -> None:
    readings = table(loop + zero, settled(loop), runs=2, noise=1.0)
    for found in loops_of(readings):
        assert middle_of(found).torque_Nm == pytest.approx(zero, abs=0.02)
    told = warnings_of(readings)
    assert "alike both ways" in told and "drive unloaded" in told


@pytest.mark.parametrize("noise", [0.0, 1.0, 10.0])
@pytest.mark.parametrize("loop", [from_zero(), from_end(0.3), from_zero(1.5)])
def test_loops_about_zero_are_not_told(loop: Floats, noise: float) -> None:
    assert "alike both ways" not in warnings_of(table(loop, settled(loop), 3, noise))


def test_a_loop_that_is_stiffer_one_way_is_not_called_off_zero() -> None:
    loop = from_end()
    angle = settled(loop)
    told = warnings_of(table(loop, np.where(angle > 0, 0.8 * angle, angle), 3))
    assert "alike both ways" not in told


def test_the_middle_of_a_loop_tells_its_lost_motion() -> None:
    loop = from_end()
    told = warnings_of(table(loop + 0.5, settled(loop), 3, 0.0))
    assert "lost motion is 36 arcsec" in told and "about 0.5 N m" in told


def test_a_loop_that_slips_earlier_one_way_is_not_called_off_zero() -> None:
    """Friction that is half the amplitude: the torque at which it slips is no zero of a sensor."""
    loop = 0.1 * from_end()
    rises = np.gradient(loop) > 0
    slips = np.where(np.where(rises, loop > 0.7, loop > -0.5), PLAY, 0.0)
    assert "alike both ways" not in warnings_of(table(loop, slips + 60 * loop, 2))


@pytest.mark.parametrize("end_Nm", [0.0, -0.05, -0.3, -1.2])
def test_a_run_that_ends_short_of_zero_torque_has_the_width_of_the_loop(end_Nm: float) -> None:
    """The first reading, before any load, lies between both ways and says nothing of the width."""
    up = np.arange(0.0, AMPLITUDE, 0.2)
    back = np.arange(-AMPLITUDE, end_Nm, 0.2)
    torque = np.concatenate([up, np.arange(AMPLITUDE, -AMPLITUDE, -0.2), back, [end_Nm]])
    for way in (1.0, -1.0):
        loop = loop_of(way * torque, way * angles(torque))
        assert loop.composed
        assert loop.width_arcsec == pytest.approx(TRUTH["hysteresis_loss"], abs=1e-6)
