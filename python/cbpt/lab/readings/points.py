"""Readings as a picture takes them."""

from __future__ import annotations

import numpy as np

from cbpt.figures.shared import Points
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.set_points import levels_of, settings


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
        setting=levels.index,
        setting_names=tuple(names),
        torque_set_point=torque.index,
        torque_set_points_Nm=torque.value,
    )
