"""Torques that were held: whether the scatter of their readings is the torque's or the sensor's.

held_torque  a campaign with the mean torque of each hold, where the angle does not follow

An angle that follows a torque follows its scatter as well. Where it does not, the scatter is the
sensor's, and it would not stay noise: what goes by the sense of loading follows the sense of the
scatter, and explains some of it. The mean of a hold is not its torque either: its error moves all
readings of the hold together (`Held`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Held
from cbpt.lab.model.dataset import Campaign

__all__ = ["held_torque"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """What counts as held, and as not followed."""

    fewest: int = 3
    """Readings of a hold."""
    jump: float = 5.0
    """Steps of the torque from which a hold ends, in typical steps of the run."""
    aimless: float = 0.55
    """Mean square of the steps of scatter, over twice its variance, is 1 (von Neumann 1941); of
    a ramp or a small loop less than this."""
    fewest_dof: int = 8
    follows: float = 0.5
    sigmas: float = 3.0
    """The angle does not follow where so many standard deviations above what it shows is less than
    this share of what the model computes."""


_LIMITS = _Limits()


def held_torque(
    campaign: Campaign, model: Callable[[Campaign], Floats]
) -> tuple[Campaign, list[str]]:
    """The campaign with the mean torque of each hold where that is what was held, and a note.

    model: the case at every reading of a campaign, arcsec.
    """
    torque = campaign.readings.torque_Nm
    hold, long = _holds(campaign)
    dof = int(np.count_nonzero(long)) - len(np.unique(hold[long]))
    if dof < _LIMITS.fewest_dof:
        return campaign, []
    mean = np.where(long, _means(torque, hold), torque)
    other = _at(campaign, mean)
    at_mean = model(other)
    follows = (model(campaign) - at_mean)[long]
    off = campaign.y_arcsec - at_mean
    off = (off - _means(off, hold))[long]
    size = float(follows @ follows)
    if not size > 0:
        return campaign, []
    gain = float(follows @ off) / size
    rest = off - gain * follows
    u_gain = float(np.sqrt(rest @ rest / (dof - 1) / size))
    if gain + _LIMITS.sigmas * u_gain > _LIMITS.follows:
        return campaign, []
    scatter = float(np.sqrt(np.sum((torque - mean)[long] ** 2) / dof))
    u_mean = np.where(long, scatter / np.sqrt(np.bincount(hold)[hold]), 0.0)
    moved = 0.5 * np.abs(model(_at(campaign, mean + u_mean)) - model(_at(campaign, mean - u_mean)))
    # Beside the torque at which the balls slip the model has no solution on one side.
    error = Held(np.where(np.isfinite(moved), moved, np.nanmax(moved)), hold)
    return replace(other, held=error), [
        f"the torque readings scatter by {scatter:.2g} N m while the torque is held, and the angle "
        "does not follow: the mean of each hold is used, with its uncertainty"
    ]


def _at(campaign: Campaign, torque_Nm: Floats) -> Campaign:
    return replace(campaign, readings=replace(campaign.readings, torque_Nm=torque_Nm))


def _holds(campaign: Campaign) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Which stretch of a run each reading is of, shape (n,), and whether the torque was held there:
    the steps inside a stretch are small against those between, and lead nowhere."""
    torque, rows = campaign.readings.torque_Nm, campaign.rows
    hold, long = np.zeros(len(torque), dtype=np.int64), np.zeros(len(torque), dtype=bool)
    count = 0
    for run in np.split(rows.order, rows.starts[1:]):
        steps = np.abs(np.diff(torque[run]))
        typical = float(np.median(steps)) if len(steps) else 0.0
        for part in np.split(run, np.flatnonzero(steps > _LIMITS.jump * typical) + 1):
            hold[part] = count
            long[part] = len(part) >= _LIMITS.fewest and _aimless(torque[part])
            count += 1
    return hold, long


def _aimless(torque_Nm: Floats) -> bool:
    """Whether values scatter about a level, and neither climb nor turn back along a loop."""
    steps = float(np.mean(np.diff(torque_Nm) ** 2))
    return steps > _LIMITS.aimless * 2 * float(np.var(torque_Nm, ddof=1))


def _means(values: Floats, hold: NDArray[np.int64]) -> Floats:
    return np.asarray((np.bincount(hold, values) / np.bincount(hold))[hold])
