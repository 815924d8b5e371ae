"""Play beside friction: against loops whose play is known in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt

Floats = NDArray[np.float64]
RATED, STEP = 10.0, 0.1
CASE = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "rating": {"rated_torque_Nm": RATED},
    "uncertainty": {"torque_gain_rel": 0.0, "sensor_gain_rel": 0.0},
}


@dataclass(frozen=True)
class Rig:
    """A spring of 60 arcsec/(N m) behind a play, held by dry friction."""

    play_arcsec: float = 30.0
    friction_Nm: float = 0.77
    growth: float = 0.0
    """Friction torque per spring torque."""
    hardening: float = 0.0
    """Share by which the last newton metre of ten turns the spring less than the first."""
    slip_arcsec: float = 0.0
    """Angle over which friction comes round after a turn; 0: at once."""

    def spring(self, torque: Floats | float) -> Floats:
        size = np.abs(torque)
        way = 60 * np.sign(torque) * size * (1 - self.hardening * size / (2 * RATED))
        return np.asarray(way + 0.5 * self.play_arcsec * np.clip(torque / 1e-6, -1.0, 1.0))

    def angles(self, torque: Floats) -> Floats:
        """Through these torques from rest."""
        if self.slip_arcsec:
            return self._slipping(torque)
        found, spring = [], 0.0
        for value in torque.tolist():
            spring = min(max(spring, self._held(value, -1.0)), self._held(value, 1.0))
            found.append(float(self.spring(spring)))
        return np.array(found)

    def _held(self, torque: float, way: float) -> float:
        """The spring's torque from which friction, all of it, points this way."""
        rest = torque + way * self.friction_Nm
        return float(rest / (1 - way * self.growth * np.sign(rest)))

    def _slipping(self, torque: Floats) -> Floats:
        """Dahl's friction: d F / d angle = (1 - F sign) / slip."""
        found, angle, friction, spring = [], 0.0, 0.0, 0.0
        for value in torque.tolist():
            low, high = -2.0 * RATED, 2.0 * RATED
            for _ in range(60):
                middle = 0.5 * (low + high)
                way = float(self.spring(middle)) - angle
                sign = np.sign(way)
                held = sign - (sign - friction) * np.exp(-abs(way) / self.slip_arcsec)
                total = middle + (self.friction_Nm + self.growth * abs(middle)) * held
                low, high = (middle, high) if total < value else (low, middle)
            spring, friction = middle, float(held)
            angle = float(self.spring(spring))
            found.append(angle)
        return np.array(found)


def cycles(amplitude: float, step: float = STEP) -> Floats:
    up = np.round(np.arange(-amplitude, amplitude + step / 2, step), 9)
    return np.concatenate([up[up >= 0], *[up[-2::-1], up[1:]] * 2])


def loops_to(rig: Rig, *amplitudes: float, noise: float = 0.0) -> cbpt.Characteristics:
    torque = [cycles(amplitude, STEP * amplitude / RATED) for amplitude in amplitudes]
    angle = np.concatenate([rig.angles(part) for part in torque])
    angle = angle + np.random.default_rng(1).normal(0, noise, len(angle))
    run = np.repeat(np.arange(len(torque)), [len(part) for part in torque])
    table = {"run": run, "torque_Nm": np.concatenate(torque), "elastic_angle_arcsec": angle}
    return cbpt.characterise(CASE, table)


def value_of(found: cbpt.Characteristics) -> float:
    value = found.figure("backlash").value
    assert value is not None
    return value


@pytest.mark.parametrize("play", [0.0, 3.0, 30.0, 300.0])
@pytest.mark.parametrize("growth", [0.0, 0.02])
@pytest.mark.parametrize("hardening", [0.0, 0.5])
def test_dry_friction_is_no_part_of_the_play(play: float, growth: float, hardening: float) -> None:
    """The mean torque of both branches at one angle is that of the spring, without friction."""
    rig = Rig(play, growth=growth, hardening=hardening)
    found = loops_to(rig, RATED)
    way = 60 * 2 * rig.friction_Nm
    assert found.figure("hysteresis_loss").value == pytest.approx(play + way, rel=0.05)
    assert value_of(found) == pytest.approx(play, abs=1e-3 * way)


@pytest.mark.parametrize("play", [0.0, 30.0, 300.0])
def test_small_loops_beside_large_ones_add_no_friction(play: float) -> None:
    """The width at zero torque of loops of no amplitude holds the way on which friction turns."""
    found = loops_to(Rig(play), 2.0, RATED)
    assert value_of(found) == pytest.approx(play, abs=0.1)


@pytest.mark.parametrize("slip", [40.0, 100.0, 200.0])
@pytest.mark.parametrize("friction", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("play", [0.0, 120.0])
def test_friction_that_comes_round_over_an_angle(slip: float, friction: float, play: float) -> None:
    rig = Rig(play, friction_Nm=friction, slip_arcsec=slip)
    figure = loops_to(rig, RATED).figure("backlash")
    assert figure.value is not None and figure.u is not None
    assert abs(figure.value - play) < 3 * figure.u
    assert figure.u < 0.1 * 60 * 2 * friction


def test_loops_that_are_mostly_friction_have_no_play_to_tell() -> None:
    """Nor is it read off the torques that friction takes up."""
    found = loops_to(Rig(30.0, slip_arcsec=40.0), 2.0)
    figure = found.figure("backlash")
    assert figure.value is None and figure.u is None
    assert figure.reason and "friction" in figure.reason and "holds both" in figure.reason
    assert "2 N m" in figure.reason


def test_the_play_is_not_more_than_small_loops_turn() -> None:
    """Where these go beyond the torque of friction: within it friction may hold the play."""
    torque = [cycles(2.0, 0.02), cycles(RATED)]
    angle = [60 * torque[0], 60 * torque[1] + 150 * np.sign(torque[1])]
    run = np.repeat([1, 2], [len(part) for part in torque])
    table = {
        "run": run,
        "torque_Nm": np.concatenate(torque),
        "elastic_angle_arcsec": np.concatenate(angle),
    }
    assert value_of(cbpt.characterise(CASE, table)) == pytest.approx(240)
    held = loops_to(Rig(300.0), 0.5, RATED)
    assert value_of(held) == pytest.approx(300, abs=0.1)


def test_the_uncertainty_of_a_play_at_its_bound_is_not_none() -> None:
    figure = loops_to(Rig(0.0), RATED, RATED, RATED, noise=2.0).figure("backlash")
    assert figure.value is not None and 0 <= figure.value < 3 * (figure.u or 0)
    assert figure.u and figure.u > 0.2


def test_the_form_of_the_curve_is_part_of_the_uncertainty() -> None:
    straight, bent = (loops_to(Rig(hardening=h), RATED).figure("backlash") for h in (0.0, 0.5))
    assert straight.u is not None and bent.u is not None
    assert straight.u < 1 < bent.u


def test_small_loops_that_friction_may_hold_are_no_bound() -> None:
    """The mean torque of friction that comes round slowly is less than what it holds at most."""
    rig = Rig(1500.0, friction_Nm=1.0, slip_arcsec=200.0)
    alone, beside = (value_of(loops_to(rig, *to)) for to in ((RATED,), (0.985, RATED)))
    assert alone == pytest.approx(1500, rel=0.02)
    assert beside == pytest.approx(alone, abs=3)


def test_small_loops_that_friction_holds_do_not_stand_in_for_large_ones() -> None:
    """They turn little and lose little: their friction is small beside their amplitude."""
    figure = loops_to(Rig(120.0, friction_Nm=1.9, slip_arcsec=200.0), 0.3, RATED).figure("backlash")
    assert figure.value is None and figure.reason and "friction" in figure.reason
