"""What is not known of a torsion spring between the points of its table.

curve_errors  columns of normal coefficients: what a curve between the points may be off by

A table of a few points, as data sheets have it, leaves the curve between them open. The model's
curve is monotone and bends as little as it must. Cubic splines (through one side, or both) and
Akima's curve (J. ACM 17, 1970) bend otherwise between the same points, and a catalogue that states
stiffnesses in pieces means straight lines. The most that a slope of the smooth ones differs by at a
point is taken as the standard uncertainty of the slope there, and Hermite's cubics carry it to the
torques between; what the straight line differs by in an interval is another one (Type B
evaluations, JCGM 100:2008, 4.3). Where points are dense the curves are one, and next to nothing is
added. Beyond the last point the slope of the curve's end is as uncertain.
"""

from __future__ import annotations

import tomllib

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Drive
from cbpt.results import ARCSEC_PER_RAD, solve_many

Floats = NDArray[np.float64]

_LEAST = 1e-6
"""Of the angle of the table: less than this is none."""
_MOST = 64
"""Columns, the largest ones: what many points leave open is little at each."""


def curve_errors(drive: Drive, torque_Nm: Floats) -> Floats | None:
    """Arcsec, shape (n, k), k at most twice the number of points; None of a ball drive, of one
    stiffness, and where the points leave nothing open."""
    if drive.kind != "torsion_spring" or not len(torque_Nm):
        return None
    stated = tomllib.loads(drive.to_toml())["torsion_spring"]
    if len(stated.get("torque_Nm", ())) < 3:
        return None
    torque = np.array(stated["torque_Nm"])
    angle = np.array(stated["elastic_angle_rad"]) * ARCSEC_PER_RAD
    odd = torque[0] == 0.0 and angle[0] == 0.0
    at_Nm = np.abs(torque_Nm) if odd else torque_Nm
    slopes = _of_slopes(torque, at_Nm) * _open(drive, torque, angle, odd)
    columns = np.column_stack([slopes, _of_lines(drive, torque, angle, at_Nm)])
    if odd:
        columns *= np.sign(torque_Nm)[:, None]
    size = np.abs(columns).max(axis=0)
    largest = np.sort(np.argsort(-size, kind="stable")[:_MOST])
    shown = largest[size[largest] > _LEAST * np.ptp(angle)]
    return columns[:, shown] if len(shown) else None


def _turned(drive: Drive, torque_Nm: Floats) -> Floats:
    """By the model, arcsec."""
    return solve_many(drive, torque_Nm, 0.0).elastic_angle_rad * ARCSEC_PER_RAD


def _open(drive: Drive, torque: Floats, angle: Floats, odd: bool) -> Floats:
    """What the slopes of the curves differ by at each point. A reducer whose stiffness rises from
    zero torque on bends sharply there, so a smooth curve may also end there."""
    from scipy.interpolate import Akima1DInterpolator, CubicSpline

    step = 1e-4 * float(np.diff(torque).min())
    own = (_turned(drive, torque + step) - _turned(drive, torque - step)) / (2 * step)
    x, y = (np.r_[-of[:0:-1], of] if odd else of for of in (torque, angle))
    smooth = CubicSpline(x, y), CubicSpline(torque, angle), Akima1DInterpolator(torque, angle)
    return np.asarray(np.max([np.abs(curve(torque, 1) - own) for curve in smooth], axis=0))


def _of_slopes(torque: Floats, at_Nm: Floats) -> Floats:
    """What a slope of 1 at each point alone makes of a curve through zeros, shape (n, points)."""
    from scipy.interpolate import CubicHermiteSpline

    each = np.eye(len(torque))
    found = CubicHermiteSpline(torque, np.zeros_like(each), each)(np.clip(at_Nm, *torque[[0, -1]]))
    beyond = at_Nm - np.clip(at_Nm, *torque[[0, -1]])
    found[:, 0] += np.minimum(beyond, 0.0)
    found[:, -1] += np.maximum(beyond, 0.0)
    return np.asarray(found)


def _of_lines(drive: Drive, torque: Floats, angle: Floats, at_Nm: Floats) -> Floats:
    """What the straight line of each interval differs by there, shape (n, points - 1)."""
    within = (at_Nm > torque[0]) & (at_Nm < torque[-1])
    off = np.where(within, np.interp(at_Nm, torque, angle) - _turned(drive, at_Nm), 0.0)
    interval = np.searchsorted(torque, at_Nm, side="right") - 1
    return np.asarray(off[:, None] * (interval[:, None] == np.arange(len(torque) - 1)))
