"""Figures of catalogues against loops whose figures are known, however they are read.

A spring with or without play beside one slider (Jenkin) is solved here without the product; a sum
of play operators is its own solution.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt

Floats = NDArray[np.float64]
Model = Callable[[Floats], Floats]

CLOSED = (0, 20, -20, 20)
EXACT_GAINS = {"uncertainty": {"torque_gain_rel": 0.0, "sensor_gain_rel": 0.0}}


def along(turns: Sequence[float], step: float) -> Floats:
    """Torques from turn to turn, N m."""
    legs = [
        np.linspace(a, b, round(abs(b - a) / step) + 1)[1:] for a, b in itertools.pairwise(turns)
    ]
    return np.concatenate([[float(turns[0])], *legs])


def slider(friction_Nm: float, stiffness: float, play_arcmin: float = 0.0) -> Model:
    """A spring of 5 N m/arcmin with a play, beside a spring (N m/arcmin) that slips."""

    def angles_arcsec(torque_Nm: Floats) -> Floats:
        held, at, found = 0.0, 0.0, []
        for torque in torque_Nm:
            low, high = -30.0, 30.0
            for _ in range(60):
                middle = 0.5 * (low + high)
                friction = np.clip(held + stiffness * (middle - at), -friction_Nm, friction_Nm)
                taken_up = middle - np.clip(middle, -0.5 * play_arcmin, 0.5 * play_arcmin)
                low, high = (low, middle) if 5 * taken_up + friction > torque else (middle, high)
            held, at = friction, middle
            found.append(60 * middle)
        return np.array(found)

    return angles_arcsec


def plays(radii_Nm: Sequence[float], weights: Sequence[float]) -> Model:
    """A spring of 5 N m/arcmin in series with play operators of the torque, arcsec/(N m) each."""

    def angles_arcsec(torque_Nm: Floats) -> Floats:
        angle = 12 * torque_Nm
        for radius, weight in zip(radii_Nm, weights, strict=True):
            at, followed = 0.0, []
            for torque in torque_Nm:
                at = float(np.clip(at, torque - radius, torque + radius))
                followed.append(at)
            angle = angle + weight * np.array(followed)
        return angle

    return angles_arcsec


def figures(*runs: tuple[Floats, Floats]) -> cbpt.Characteristics:
    case: dict[str, Any] = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 5.0},
        "rating": {"rated_torque_Nm": 20.0},
    }
    table = {
        "run": np.repeat(np.arange(1, len(runs) + 1), [len(torque) for torque, _ in runs]),
        "torque_Nm": np.concatenate([torque for torque, _ in runs]),
        "elastic_angle_arcsec": np.concatenate([angle for _, angle in runs]),
    }
    return cbpt.characterise(case | EXACT_GAINS, table)


def departure(found: cbpt.Characteristics, name: str, truth: float) -> float:
    """Of a figure from the truth, in its standard uncertainties."""
    [figure] = [f for f in found.groups[0].readings if f.name == name]
    assert figure.value is not None and figure.u is not None
    assert figure.u < 1.3 * max(abs(truth), abs(figure.value))
    return abs(figure.value - truth) / max(figure.u, 1e-4 * abs(truth))


def told(found: cbpt.Characteristics) -> str:
    return " ".join(found.groups[0].warnings)


@pytest.mark.parametrize("loops", [1, 2])
@pytest.mark.parametrize("step", [1.0, 5.0])
def test_what_a_display_rounds_alike_in_all_loops_is_uncertain(loops: int, step: float) -> None:
    """Repeated loops round alike: they agreed on a wrong width to 0.02 arcsec and better."""
    model = plays([0.2, 0.5, 1.0], [2.0, 1.0, 1.0])
    torque = along([0, *([20, -20] * loops), 20], 0.5)
    for zero in (0.0, 0.7 * step):
        read = np.round((model(torque) + zero) / step) * step
        found = figures((torque, read))
        assert departure(found, "hysteresis_loss", 3.8) < 3
        assert departure(found, "lost_motion", 19.2) < 3


@pytest.mark.parametrize("step", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("offset", [0.1, 0.5])
def test_coarse_steps_over_a_play_leave_all_of_it_open(step: float, offset: float) -> None:
    """Both branches showed the same chord: a width of 7 with an uncertainty of 34 arcsec."""
    up = np.arange(-20 + offset * step, 20.001, step)
    torque = np.concatenate([up[up >= 0], up[::-1][1:], up[1:], up[::-1][1:], up[1:]])
    found = figures((torque, slider(0.3, 20.0, 2.0)(torque)))
    assert departure(found, "hysteresis_loss", 127.2) < 3
    assert departure(found, "lost_motion", 134.4) < 3


@pytest.mark.parametrize(("step", "scatter"), [(0.1, 0.05), (0.25, 0.1)])
def test_torques_that_scatter_do_not_hide_a_play(step: float, scatter: float) -> None:
    """Straight lines through seven readings went across the step of the play, for certain."""
    torque = along([0, 20, -20, 20, -20, 20], step)
    angle = slider(0.3, 20.0, 2.0)(torque)
    for seed in range(2):
        read = torque + np.random.default_rng(seed).normal(0, scatter, len(torque))
        found = figures((read, angle))
        assert departure(found, "hysteresis_loss", 127.2) < 3
        assert departure(found, "lost_motion", 134.4) < 3


def test_rigidity_takes_both_branches() -> None:
    """A first loading alone was 10 % softer than the mean of both branches that it stood for."""
    model, truth = slider(1.0, 50.0), 5.5556
    for turns in ((0, 20, 0), (0, 20, -20), CLOSED):
        torque = along(turns, 0.5)
        found = figures((torque, model(torque)))
        assert departure(found, "torsional_rigidity", truth) < 1, turns
    alone = along((0, 20), 0.5)
    both = along((0, 20, 0), 0.5)
    [figure] = [
        f
        for f in figures((alone, model(alone))).groups[0].readings
        if f.name == "torsional_rigidity"
    ]
    assert figure.value is None and "both branches" in (figure.reason or "")
    assert departure(figures((both, model(both))), "torsional_rigidity", truth) < 1


def test_the_area_that_a_first_leg_takes_is_uncertain() -> None:
    """A loop from rest back to zero torque lacked 4 % of its energy, at 14 uncertainties."""
    model = plays([1.0, 2.0, 4.0, 8.0], [1.0, 1.0, 1.0, 2.0])
    whole, open_ = along(CLOSED, 0.25), along((0, 20, -20, 0), 0.25)
    energy = sum(
        2 * r * w * (40 - 2 * r)
        for r, w in zip([1.0, 2.0, 4.0, 8.0], [1.0, 1.0, 1.0, 2.0], strict=True)
    )
    truth = energy / 3600 * np.pi / 180
    assert departure(figures((whole, model(whole))), "loop_energy", truth) < 3
    assert departure(figures((open_, model(open_))), "loop_energy", truth) < 3


@pytest.mark.parametrize("stiffness", [5.0, 20.0])
def test_where_friction_comes_round_is_no_corner_of_the_spring(stiffness: float) -> None:
    """A linear spring had K3 = 6.67 +- 0.08 from T1 = 16 on: friction that yields before it slips
    takes longer than twice its torque."""
    torque = along([0, 20, -20, 20], 0.25)
    found = figures((torque, slider(1.0, stiffness)(torque)))
    for name in ("K1", "K2", "K3"):
        assert departure(found, name, 5.0) < 1, name
    assert not any(f.value for f in found.groups[0].readings if f.name in ("T1", "T2"))


def test_two_loops_are_no_better_than_their_readings() -> None:
    """Two widths that agree by chance had an uncertainty of 0.007 arcsec, where they scatter by
    0.4; loops of one run share the reading at the turn."""
    model = plays([0.2, 0.5, 1.0], [2.0, 1.0, 1.0])
    torque = along([0, 20, -20, 20, -20, 20], 0.5)
    exact = figures((torque, model(torque)))
    [rigidity] = [f.value for f in exact.groups[0].readings if f.name == "torsional_rigidity"]
    assert rigidity is not None
    off = []
    for seed in range(16):
        noise = np.random.default_rng(seed).normal(0, 0.5, len(torque))
        found = figures((torque, model(torque) + noise))
        off.append(
            [
                departure(found, "hysteresis_loss", 3.8),
                departure(found, "torsional_rigidity", rigidity),
            ]
        )
    # Of 16 normal numbers more than 4 lie beyond 2 standard deviations in one of 2,000 cases.
    assert (np.sum(np.array(off) > 2, axis=0) <= 4).all()
    assert np.max(off) < 4


@pytest.mark.parametrize("size", [0.01, 1.0, 40.0])
@pytest.mark.parametrize("turns", [CLOSED, (0, 20, -20, 20, -20, 0)])
def test_angles_with_all_their_digits_are_not_rounded(size: float, turns: Sequence[float]) -> None:
    """Small angles are multiples of nothing; two loops may have one branch in common."""
    torque = along(turns, 0.5)
    exact = size * plays([0.2, 0.5, 1.0], [2.0, 1.0, 1.0])(torque)
    noise = np.random.default_rng(1).normal(0, 0.02 * size, len(torque))
    found = figures((torque, exact + noise))
    [figure] = [f for f in found.groups[0].readings if f.name == "hysteresis_loss"]
    assert figure.u is not None and 0.01 * size < figure.u < 0.06 * size


def test_runs_that_share_no_torque_have_the_scatter_along_them() -> None:
    rng = np.random.default_rng(1)
    runs = [along((side, 20 * side, side), 0.5) for side in (1, -1)]
    found = figures(*[(t, 12 * t + rng.normal(0, 0.5, len(t))) for t in runs])
    [figure] = [f for f in found.groups[0].readings if f.name == "torsional_rigidity"]
    assert figure.u is not None and figure.u > 1e-3


def test_opposite_senses_and_a_late_torque_are_told() -> None:
    model, torque = plays([0.2, 0.5, 1.0], [2.0, 1.0, 1.0]), along((0, 20, -20, 20, -20, 20), 0.5)
    assert "opposite senses" in told(figures((torque, -model(torque))))
    assert "ahead of the torque" in told(figures((torque[::-1], model(torque)[::-1])))
    for angle in (model(torque), 12 * torque):
        assert not told(figures((torque, angle)))


def test_loops_of_unlike_amplitudes_are_told() -> None:
    model = slider(1.0, 50.0)
    runs = [(t, model(t)) for t in (along((0, top, -top, top), 0.5) for top in (17, 20))]
    assert "means over loops to 17 to 20 N m" in told(figures(*runs))
