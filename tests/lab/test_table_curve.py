"""What a torsion spring's table leaves open between its points."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.model.table_curve import curve_errors
from cbpt.results import ARCSEC_PER_RAD, solve_many

Floats = NDArray[np.float64]
LARGEST_NM = 20.0


def turned(torque_Nm: Floats) -> Floats:
    """Arcsec: softer near zero and smooth."""
    share = np.abs(torque_Nm) / LARGEST_NM
    return np.asarray(np.sign(torque_Nm) * 60.0 * (share + 0.5 * (1 - np.exp(-4 * share))))


def case(points: int) -> cbpt.Case:
    torque = np.linspace(0.0, 1.1 * LARGEST_NM, points)
    return cbpt.Case.from_toml(
        f"[torsion_spring]\ntorque_Nm = {torque.tolist()}\n"
        f"elastic_angle_arcsec = {turned(torque).tolist()}\n"
    )


def table(seed: int, play_arcsec: float = 0.0) -> dict[str, Floats]:
    torque = LARGEST_NM * np.sin(np.linspace(0.0, 4 * np.pi, 120))
    noise = np.random.default_rng(seed).normal(0.0, 0.3, torque.size)
    play = 0.5 * play_arcsec * torque / np.hypot(torque, 0.4)
    angle = turned(torque) + play + noise
    return {
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle,
        "u_elastic_angle_arcsec": np.full(torque.size, 0.3),
    }


def test_a_curve_is_certain_at_its_points_and_where_they_are_dense() -> None:
    points = np.linspace(0.0, 1.1 * LARGEST_NM, 6)
    found = curve_errors(case(6).drive, np.r_[-points, points, 2.0])
    assert found is not None
    assert np.abs(found[:-1]).max() < 1e-9 < np.abs(found[-1]).max()
    between = np.linspace(-LARGEST_NM, LARGEST_NM, 201)
    few, many = (curve_errors(case(count).drive, between) for count in (6, 48))
    assert few is not None
    assert many is not None
    assert np.linalg.norm(many, axis=1).max() < 0.05 * np.linalg.norm(few, axis=1).max()


def test_what_is_missed_between_points_is_as_large_as_is_said() -> None:
    between = np.linspace(-LARGEST_NM, LARGEST_NM, 201)
    u = np.linalg.norm(np.asarray(curve_errors(case(6).drive, between)), axis=1)
    model = solve_many(case(6).drive, between, 0.0).elastic_angle_rad * ARCSEC_PER_RAD
    missed = np.abs(model - turned(between))
    assert 0.3 < missed.max() / u.max() < 3.0


@pytest.mark.parametrize("drive", ["linear", "two points", "straight"])
def test_nothing_is_open_on_a_straight_line(drive: str) -> None:
    points = {"two points": [0.0, 10.0], "straight": [0.0, 5.0, 10.0, 20.0]}.get(drive)
    text = "torsional_stiffness_Nm_per_arcsec = 0.5"
    if points:
        text = f"torque_Nm = {points}\nelastic_angle_arcsec = {[2 * p for p in points]}"
    spring = cbpt.Case.from_toml(f"[torsion_spring]\n{text}\n").drive
    assert curve_errors(spring, np.array([-3.0, 7.0])) is None


@pytest.mark.parametrize("seed", range(3))
def test_a_curve_of_few_points_is_no_play(seed: int) -> None:
    found = cbpt.diagnose(case(6), table(seed))
    assert found.verdict.kind == "complete"
    assert any("the points of the case leave the curve" in n for n in found.notes)


def test_a_play_is_seen_beside_a_curve_of_few_points() -> None:
    assert "backlash" in cbpt.diagnose(case(6), table(0, play_arcsec=12.0)).verdict.effects


@pytest.mark.parametrize("seed", range(2))
def test_a_catalogue_in_pieces_may_mean_straight_lines(seed: int) -> None:
    """Its corners were a joint or a nonlinear sensor at 0.98: the model's curve is smooth."""
    points, angles = [0.0, 14.0, 48.0, 90.0], [0.0, 4.516, 12.243, 20.32]
    spring = cbpt.Case.from_toml(
        f"[torsion_spring]\ntorque_Nm = {points}\nelastic_angle_arcmin = {angles}\n"
    )
    torque = np.tile(np.r_[np.arange(-60.0, 60.0, 4.0), np.arange(60.0, -64.0, -4.0)], 2)
    angle = np.sign(torque) * np.interp(np.abs(torque), points, angles)
    noise = np.random.default_rng(seed).normal(0.0, 0.03, torque.size)
    read = {
        "torque_Nm": torque,
        "elastic_angle_arcmin": angle + noise,
        "u_elastic_angle_arcmin": np.full(torque.size, 0.03),
    }
    assert cbpt.diagnose(spring, read).verdict.kind == "complete"


def test_the_angle_at_a_load_is_no_more_certain_than_the_curve() -> None:
    """Its u was a twelfth of what it was off by."""
    at = np.array([1.5, 2.2])
    rows = cbpt.diagnose(case(6), table(0)).results(torque_Nm=at).to_list()
    found = [row for row in rows if row["kind"] == "angle"]
    for row, truth in zip(found, turned(at), strict=True):
        assert abs(row["value"] - truth) < 3 * row["u"]
        assert all(abs(r) < 0.3 for r in row["correlated_with"].values())


def test_a_change_beside_a_curve_of_few_points_is_told_with_its_values() -> None:
    """The play was told as 6.3 arcsec before and 8.3 after, +- 0.4: the levels bore what the curve
    was off by."""
    changed = cbpt.change(case(6), table(0, play_arcsec=2.0), table(1, play_arcsec=6.0)).changed
    [play] = [c for c in changed if c.effect == "backlash"]
    for value, u, truth in ((play.before, play.u_before, 2.0), (play.after, play.u_after, 6.0)):
        assert u is not None
        assert abs(value * ARCSEC_PER_RAD - truth) < 4 * u * ARCSEC_PER_RAD
