"""Curves of the pictures."""

from __future__ import annotations

import numpy as np

import cbpt
from cbpt.figures.diagnosis import _remembers
from cbpt.figures.shared import model_curves
from cbpt.lab.readings.points import points_of
from cbpt.page.document.curves import Curves


def test_a_curve_without_memory_is_drawn_once_from_end_to_end() -> None:
    """Also where the torque was measured, so that no torque comes twice: dashes that are drawn on
    the way up and on the way down fill each other's gaps."""
    way = np.concatenate(
        [np.linspace(0, 9, 30), np.linspace(8.9, -9, 50), np.linspace(-8.8, 0, 29)]
    )
    torque = way + np.random.default_rng(3).normal(0, 0.05, len(way))
    table = {"torque_Nm": torque, "elastic_angle_arcsec": 3 * torque, "run": np.ones(len(way))}
    points = points_of(cbpt.read_readings(table, need_preload=False))
    [(_, x, y)] = model_curves(points, 3 * torque, memory=False)
    assert len(x) == len(way) and np.all(np.diff(x) > 0) and np.allclose(y, 3 * x)


def test_a_loop_whose_torque_scatters_is_a_line_each_way() -> None:
    """In the order of time, or of the torque through both ways, it was a saw."""
    way = np.concatenate([np.linspace(-9, 9, 90), np.linspace(8.9, -9, 90)])
    torque = way + np.random.default_rng(3).normal(0, 0.2, len(way))
    assert np.count_nonzero(np.diff(np.sign(np.diff(torque)))) > 20
    loop = 3 * torque + np.repeat([-2.0, 2.0], 90)
    table = {"torque_Nm": torque, "elastic_angle_arcsec": loop, "run": np.ones(len(way))}
    points = points_of(cbpt.read_readings(table, need_preload=False))
    lines = list(model_curves(points, loop, memory=True))
    assert len(lines) == 2 and sum(len(x) for _, x, _ in lines) == len(way)
    for _, x, y in lines:
        assert np.all(np.diff(x) > 0)
        assert np.count_nonzero(np.diff(np.sign(y - 3 * x))) <= 2  # at the ends alone
    assert _remembers(points, loop)
    assert not _remembers(points, 3 * torque)


def test_held_readings_at_the_ends_of_a_loop_are_on_the_way_that_led_there() -> None:
    """A line through them alone joined the ends, through the middle of the loop."""
    up, down = np.arange(-9.0, 10.0), np.arange(9.0, -10.0, -1.0)
    torque = np.tile(np.r_[up, down], 2)
    loop = 3 * torque + np.tile(np.repeat([-2.0, 2.0], 19), 2)
    table = {"torque_Nm": torque, "elastic_angle_arcsec": loop, "run": np.ones(len(torque))}
    readings = cbpt.read_readings(table, need_preload=False)
    lines = [x for _, x, _ in model_curves(points_of(readings), loop, memory=True)]
    assert len(lines) == 2 and all(np.all(np.diff(x) == 1) for x in lines)
    assert [line["branch"] for line in Curves(readings).lines] == ["down", "up"]
