"""What is not known of a torsion spring between the points of its table.

curve_errors  columns of normal coefficients: what the slope at each point may be off by

A table of a few points, as data sheets have it, leaves the curve between them open. The model's
curve is monotone and bends as little as it must. Cubic splines (through one side, or both) and
Akima's curve (J. ACM 17, 1970) bend otherwise between the same points. The most that a slope of
theirs differs by at a point is taken as the standard uncertainty of the slope there, and Hermite's
cubics carry it to the torques between (a Type B evaluation, JCGM 100:2008, 4.3). Where points are
dense the curves are one, and next to nothing is added.
"""

from __future__ import annotations

import tomllib

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Drive
from cbpt.results import ARCSEC_PER_RAD

Floats = NDArray[np.float64]

_MOST = 64
"""Points: what more of them leave open is less than anything that is measured."""
_LEAST = 1e-6
"""Of the angle of the table: less than this is none."""


def curve_errors(drive: Drive, torque_Nm: Floats) -> Floats | None:
    """Arcsec, shape (n, k), k at most the number of points; None of a ball drive, of one stiffness,
    and where the points leave nothing open."""
    if drive.kind != "torsion_spring":
        return None
    stated = tomllib.loads(drive.to_toml())["torsion_spring"]
    if not 3 <= len(stated.get("torque_Nm", ())) <= _MOST:
        return None
    torque = np.array(stated["torque_Nm"])
    angle = np.array(stated["elastic_angle_rad"]) * ARCSEC_PER_RAD
    odd = torque[0] == 0.0 and angle[0] == 0.0
    columns = _of_slopes(torque, np.abs(torque_Nm) if odd else torque_Nm) * _open(
        torque, angle, odd
    )
    if odd:
        columns *= np.sign(torque_Nm)[:, None]
    shown = np.abs(columns).max(axis=0) > _LEAST * np.ptp(angle)
    return columns[:, shown] if shown.any() else None


def _open(torque: Floats, angle: Floats, odd: bool) -> Floats:
    """What the slopes of the curves differ by at each point. A reducer whose stiffness rises from
    zero torque on bends sharply there, so a smooth curve may also end there."""
    from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator

    x, y = (np.r_[-of[:0:-1], of] if odd else of for of in (torque, angle))
    monotone = PchipInterpolator(x, y)(torque, 1)
    smooth = CubicSpline(x, y), CubicSpline(torque, angle), Akima1DInterpolator(torque, angle)
    return np.asarray(np.max([np.abs(curve(torque, 1) - monotone) for curve in smooth], axis=0))


def _of_slopes(torque: Floats, at_Nm: Floats) -> Floats:
    """What a slope of 1 at each point alone makes of a curve through zeros, shape (n, points)."""
    from scipy.interpolate import CubicHermiteSpline

    each = np.eye(len(torque))
    found = CubicHermiteSpline(torque, np.zeros_like(each), each)(np.clip(at_Nm, *torque[[0, -1]]))
    beyond = at_Nm - np.clip(at_Nm, *torque[[0, -1]])
    found[:, 0] += np.minimum(beyond, 0.0)
    found[:, -1] += np.maximum(beyond, 0.0)
    return np.asarray(found)
