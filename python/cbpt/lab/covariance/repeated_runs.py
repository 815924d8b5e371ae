"""Whether what a model leaves comes again in runs that repeat each other.

    ComesAgain   what runs differ by, and the chance that noise alone agrees as much
    comes_again  from the residuals of a model

Noise differs from run to run, however slowly it moves; a law that the model lacks comes again. With
y_ij what is left of run i at place j of k runs with the same torques,

    y_ij = a_j + b_i + e_ij,   F = k var(a)/var(e),

a two-way analysis of variance. Neighbours in a run may be alike: with the correlation r of e from
one reading to the next, n readings count as n (1 - r^2)/(1 + r^2) (Bayley and Hammersley, J. R.
Stat. Soc. Suppl. 8 (1946) 184). Unlike `repeatability`, the torques need not be set points: a ramp
that is measured as it comes is the same ramp again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """Which runs repeat each other."""

    alike: float = 0.15
    """Largest difference of their torques at the same place, as a share of the largest."""
    fewest: int = 12
    """Readings of a run."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class ComesAgain:
    """What repeated runs say of what is left."""

    scatter_arcsec: float
    """Standard deviation of a reading from run to run."""
    p_value: float
    """Chance that noise alone agrees as much from run to run."""


def comes_again(readings: Readings, left_arcsec: Floats) -> ComesAgain | None:
    """left_arcsec: shape (n,). None where no runs repeat each other."""
    from scipy.special import fdtrc

    squares, freedom, chances = 0.0, 0.0, []
    for rows in _alike(readings):
        k, m = rows.shape
        y = left_arcsec[rows] - left_arcsec[rows].mean(axis=1, keepdims=True)
        common = y.mean(axis=0)
        e = y - common
        within = float(np.sum(e**2)) / ((k - 1) * (m - 1))
        if not within > 0:
            continue
        r = float(np.sum(e[:, 1:] * e[:, :-1]) / np.sum(e**2))
        share = (1 - r**2) / (1 + r**2)
        ratio = k * float(np.sum(common**2)) / (m - 1) / within
        dof = (m - 1) * share
        chances.append(float(fdtrc(dof, (k - 1) * dof, ratio)))
        squares += float(np.sum(e**2))
        freedom += (k - 1) * (m - 1)
    if not chances:
        return None
    p_value = min(1.0, len(chances) * min(chances))
    return ComesAgain(float(np.sqrt(squares / freedom)), p_value)


def _alike(readings: Readings) -> list[Ints]:
    """Rows of runs that repeat each other, each group of shape (runs, readings of a run)."""
    order = np.argsort(readings.run_index, kind="stable")
    run = readings.run_index[order]
    ends = np.flatnonzero(np.diff(run)) + 1
    groups: list[list[Ints]] = []
    for rows in np.split(order, ends):
        if len(rows) < _LIMITS.fewest:
            continue
        for group in groups:
            if _same(readings, group[0], rows):
                group.append(rows)
                break
        else:
            groups.append([rows])
    return [np.array(group) for group in groups if len(group) > 1]


def _same(readings: Readings, one: Ints, other: Ints) -> bool:
    """Whether two runs have the same torques under the same conditions."""
    if len(one) != len(other):
        return False
    torque = readings.torque_Nm
    reach = float(np.abs(torque[one]).max())
    if np.abs(torque[one] - torque[other]).max() > _LIMITS.alike * reach:
        return False
    steady = readings.preload_N, readings.preload_step, readings.input_angle_deg
    return all(
        np.allclose(column[one], column[other], rtol=0.02, atol=1e-6)
        for column in steady
        if column is not None
    )
