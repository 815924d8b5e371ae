"""Readings as a picture takes them.

points_of   readings as points
legs_of     which way of a run each of them is on
"""

from __future__ import annotations

import numpy as np

from cbpt.figures.shared import Points
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.set_points import levels_of, settings
from cbpt.lab.readings.turns import turns_of


def points_of(readings: Readings, offset_arcsec: float | np.ndarray = 0.0) -> Points:
    """Readings as points, less an offset: one number, or one of each reading, shape (n,)."""
    levels, names = settings(readings)
    torque = levels_of(readings.torque_Nm)
    return Points(
        source=readings.source,
        torque_Nm=readings.torque_Nm,
        angle_arcsec=readings.elastic_angle_arcsec - offset_arcsec,
        u_arcsec=readings.u_elastic_angle_arcsec,
        direction=readings.direction(),
        run=readings.run_index,
        leg=legs_of(readings),
        setting=levels.index,
        setting_names=tuple(names),
        torque_set_point=torque.index,
        torque_set_points_Nm=torque.value,
    )


def legs_of(readings: Readings) -> np.ndarray:
    """Shape (n,): how many times the torque has turned back before each reading, run after run."""
    # A smaller turn is scatter of the torque: by its share of the range of the run, and by typical
    # second differences, three of which are five standard deviations of what scatters.
    of_range, of_steps = 0.04, 3.0
    leg, before = np.zeros(len(readings), dtype=np.int64), 0
    order = np.argsort(readings.run_index, kind="stable")
    runs = np.split(order, np.flatnonzero(np.diff(readings.run_index[order])) + 1)
    for rows in runs if len(readings) else ():
        torque = readings.torque_Nm[rows]
        rough = float(np.median(np.abs(np.diff(torque, 2)))) if len(torque) > 2 else 0.0
        turns = turns_of(torque, max(of_range * float(np.ptp(torque)), of_steps * rough))[1:-1]
        leg[rows] = before + np.searchsorted(turns, np.arange(len(rows)), side="left")
        before = int(leg[rows].max()) + 1
    return leg
