"""What coarse steps of the torque leave open is part of the uncertainty."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.change.loop_widths import widths_of
from cbpt.lab.characteristics.between_readings import half_width_arcsec
from cbpt.lab.characteristics.loops import Branch

Floats = NDArray[np.float64]
RATED, AMPLITUDE, PLAY, FRICTION = 10.0, 12.0, 90.0, 0.52
CASE = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "rating": {"rated_torque_Nm": RATED},
    "uncertainty": {"torque_gain_rel": 0.0, "sensor_gain_rel": 0.0},
}


def branch(torque: Floats, angle: Floats, scattered: bool = False) -> Branch:
    return Branch(torque, angle, np.zeros(len(torque)), scattered)


def angle_of(torque: Floats) -> Floats:
    """A play and a spring of 60 arcsec/(N m) behind dry friction."""
    held = [0.0]
    for value in torque.tolist():
        held.append(min(max(held[-1], value - FRICTION), value + FRICTION))
    spring = np.array(held[1:])
    return np.asarray(np.where(spring > 0, 0.5, -0.5) * PLAY + 60 * spring)


def of_steps(step: float, phase: float) -> cbpt.Characteristics:
    return cbpt.characterise(CASE, readings_of(step, phase))


def readings_of(step: float, phase: float) -> cbpt.Readings:
    """Three runs through -T, T, -T on steps that meet zero at a phase."""
    up = np.arange(-AMPLITUDE + phase * step, AMPLITUDE + 1e-9, step)
    cycle = np.concatenate([up[1:][::-1], up, up[:-1][::-1]])
    torque = np.tile(cycle, 3)
    run = np.repeat(np.arange(3), len(cycle))
    angle = np.concatenate([angle_of(cycle)] * 3)
    noise = np.random.default_rng(2).normal(0, 0.1, len(angle))
    rows = {"run": run, "torque_Nm": torque, "elastic_angle_arcsec": angle + noise}
    return cbpt.read_readings(rows, need_preload=False)


# --- where a branch may be ----------------------------------------------------------------


def test_a_straight_branch_leaves_nothing_open() -> None:
    torque = np.linspace(-3.0, 3.0, 7)
    between = np.linspace(-3.0, 3.0, 61)
    for scattered in (False, True):
        line = branch(torque, 60 * torque, scattered)
        assert half_width_arcsec(line, between) == pytest.approx(0, abs=1e-9)


def test_a_step_between_two_readings_leaves_half_of_it_open() -> None:
    torque = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    found = branch(torque, 60 * torque + np.where(torque > 0.4, 90.0, 0.0))
    assert float(half_width_arcsec(found, 0.5)) == pytest.approx(45)
    assert half_width_arcsec(found, torque) == pytest.approx(0, abs=1e-9)


def test_no_branch_is_beyond_its_readings() -> None:
    torque = np.array([-1.0, 0.0, 1.0, 2.0])
    found = branch(torque, np.array([-300.0, 0.0, 10.0, 300.0]))
    assert float(np.max(half_width_arcsec(found, np.linspace(0, 1, 11)))) <= 5.0


def test_a_smooth_branch_leaves_open_what_goes_with_the_square_of_the_step() -> None:
    wide, narrow = (
        float(half_width_arcsec(branch(x, x + 0.1 * x**2), 0.5 * step))
        for step in (0.2, 0.1)
        for x in (np.arange(-1.0, 1.0 + step, step),)
    )
    assert wide > 0 and wide / narrow == pytest.approx(4, rel=0.02)


# --- in the figures -----------------------------------------------------------------------


@pytest.mark.parametrize("phase", [0.1, 0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize("step", [0.3, 0.8, 1.2])
def test_figures_are_as_uncertain_as_their_steps(step: float, phase: float) -> None:
    found = of_steps(step, phase)
    window = 0.03 * RATED
    truth = {
        "lost_motion": 60 * 2 * window,
        "hysteresis_loss": PLAY + 60 * 2 * FRICTION,
        "torsional_rigidity": 1.0,
    }
    for name, value in truth.items():
        figure = found.figure(name)
        assert figure.value is not None and figure.u is not None
        assert abs(figure.value - value) < 3 * figure.u, (name, figure.value, value, figure.u)


def test_fine_steps_leave_less_open() -> None:
    for name in ("lost_motion", "hysteresis_loss", "K1", "T1", "loop_energy"):
        coarse, fine = (of_steps(step, 0.5).figure(name).u_type_b for step in (0.8, 0.1))
        assert coarse is not None and fine is not None and coarse > 3 * fine, (name, coarse, fine)


def test_widths_of_levels_are_as_uncertain_as_their_steps() -> None:
    """Levels that differ in nothing but the place of their steps have the same width."""
    levels = [readings_of(0.8, phase) for phase in (0.3, 0.5, 0.9)]
    widths = widths_of(levels)[0]
    truth = PLAY + 60 * 2 * FRICTION
    assert widths.differ is None
    for value, u in zip(widths.width_arcsec, widths.u_arcsec, strict=True):
        assert u is not None and abs(value - truth) < 3 * u
