"""Torques that were held: whether the scatter of their readings is the torque's or the sensor's.

held_torque         a campaign with the mean torque of each hold, each level that comes again or
                    each place in runs that are alike, where the angle does not follow
holds               which readings the torque was held at
with_torque_errors  one with what the errors of its torques make of the angles

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

from cbpt.lab.covariance.artefacts import Artefact
from cbpt.lab.covariance.linear_gaussian import Held
from cbpt.lab.diagnosis.followed import at_torques, stays
from cbpt.lab.model.dataset import Campaign

__all__ = ["held_torque", "holds", "with_torque_errors"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """What counts as held."""

    fewest: int = 3
    """Readings of a hold."""
    jump: float = 7.0
    """Steps of torque and angle (root sum of squares) from which a hold ends, each in typical steps
    inside holds of the run."""
    rounds: int = 8
    """Times at most that typical steps are taken anew, without jumps."""
    apart: float = 2.0
    """Gap between levels, in widest gaps between readings of one level."""
    overshot: float = 4.0
    """Standard deviations by which torques on one way, of a run or to a level, may differ from
    their levels on the mean."""
    columns: int = 64
    """Errors of torques that are told apart from scatter, at most."""
    aimless: float = 0.55
    """Mean square of the steps of scatter, over twice its variance, is 1 (von Neumann 1941); of
    a ramp or a small loop less than this."""
    fewest_dof: int = 8
    set_apart: float = 0.01
    """Mean square within runs over that between them, below which their levels are their own."""


_LIMITS = _Limits()


def held_torque(
    campaign: Campaign, model: Callable[[Campaign], Floats]
) -> tuple[Campaign, list[str]]:
    """The campaign with the mean torque of each hold where that is what was held, and a note; or
    with that of each level to which the torque was set again and again, or of each place in runs
    that are alike.

    model: the case at every reading of a campaign, arcsec.
    """
    ways = [(holds, "while the torque is held", "each hold")]
    if campaign.drive.kind == "ball_drive":
        # A loop with play or a stop hardly tells whether the angle follows.
        ways.append((_levels, "about the levels that it is set to", "each level"))
        ways.append((_places, "between runs that are alike", "their first, second, ... readings"))
    for find, while_, of_each in ways:
        held = _at_means(campaign, model, *find(campaign), comes_again=find is not holds)
        if held is not None:
            other, scatter_Nm = held
            return other, [
                f"the torque readings scatter by {scatter_Nm:.2g} N m {while_}, and the angle does "
                f"not follow: the mean of {of_each} is used, with its uncertainty"
            ]
    return campaign, []


def _at_means(
    campaign: Campaign,
    model: Callable[[Campaign], Floats],
    hold: NDArray[np.int64],
    long: NDArray[np.bool_],
    comes_again: bool,
) -> tuple[Campaign, float] | None:
    """The campaign with the mean torque of each hold, and by how much torques scatter about it;
    None where the angle follows that. comes_again: whether holds go through many runs."""
    torque = campaign.readings.torque_Nm
    dof = int(np.count_nonzero(long)) - len(np.unique(hold[long]))
    # Of a few holds among ramps little is told, and the ramps have a scatter of their own.
    if dof < _LIMITS.fewest_dof or np.mean(long) <= 0.5:
        return None
    order = campaign.rows.order
    if not comes_again and _settles(torque[order], hold[order], long[order]):
        return None
    mean = np.where(long, _means(torque, hold), torque)
    other = at_torques(campaign, mean)
    at_mean = model(other)
    follows = (model(campaign) - at_mean)[long]
    off = campaign.y_arcsec - at_mean
    off = (off - _means(off, hold))[long]
    scatter_Nm = float(np.sqrt(np.sum((torque - mean)[long] ** 2) / dof))
    exact = not scatter_Nm > 1e-6 * float(np.abs(torque).max())
    if exact or not stays(follows, off, dof - 1):
        return None
    # What is in no hold has the scatter of its own reading.
    u_mean = scatter_Nm / np.sqrt(np.where(long, np.bincount(hold)[hold], 1))
    moved = 0.5 * np.abs(
        model(at_torques(campaign, mean + u_mean)) - model(at_torques(campaign, mean - u_mean))
    )
    # Beside the torque at which the balls slip the model has no solution on one side.
    moved = np.where(np.isfinite(moved), moved, np.nanmax(moved))
    other = replace(other, u_arcsec=np.hypot(other.u_arcsec, np.where(long, 0.0, moved)))
    moved = np.where(long, moved, 0.0)
    if comes_again:
        return with_torque_errors(other, moved[:, None] * _members(hold, long)), scatter_Nm
    return replace(other, held=Held(moved, hold)), scatter_Nm


def _members(hold: NDArray[np.int64], long: NDArray[np.bool_]) -> Floats:
    """1 where a reading is of a hold, shape (n, holds)."""
    holds, index = np.unique(hold[long], return_inverse=True)
    found = np.zeros((len(hold), len(holds)))
    found[np.flatnonzero(long), index] = 1.0
    return found


def with_torque_errors(campaign: Campaign, columns_arcsec: Floats) -> Campaign:
    """The campaign with what the errors of its torques make of the angles, shape (n, k): each moves
    many readings together. What the leading axes of many of them leave counts as scatter."""
    axes, size, _ = np.linalg.svd(columns_arcsec, full_matrices=False)
    columns = axes * size
    left = np.square(columns[:, _LIMITS.columns :]).sum(axis=1)
    return replace(
        campaign,
        torque_errors=Artefact("known", columns[:, : _LIMITS.columns]),
        u_arcsec=np.sqrt(campaign.u_arcsec**2 + left),
    )


def holds(campaign: Campaign) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Which stretch of a run each reading is of, shape (n,), and whether the torque was held there:
    the steps inside a stretch are small against those between, and lead nowhere. Where the torque
    of stairs scatters by more than their steps show, those of the angle tell them."""
    torque, angle, rows = campaign.readings.torque_Nm, campaign.y_arcsec, campaign.rows
    hold, long = np.zeros(len(torque), dtype=np.int64), np.zeros(len(torque), dtype=bool)
    count = 0
    for run in np.split(rows.order, rows.starts[1:]):
        parts = _parts(torque[run], angle[run], campaign.step_arcsec)
        fewest = 2
        if not _are_stairs(torque[run], parts):
            parts, fewest = _parts(torque[run], np.zeros(len(run)), 0.0), _LIMITS.fewest
        for part in parts:
            hold[run[part]] = count
            long[run[part]] = len(part) >= fewest and _aimless(torque[run[part]])
            count += 1
    return hold, long


def _parts(torque_Nm: Floats, angle_arcsec: Floats, step_arcsec: float) -> list[Ints]:
    """Readings of a run between steps that are large against those of scatter, which are a third of
    all or more. step_arcsec: of a coarse display."""
    torque, angle = np.abs(np.diff(torque_Nm)), np.abs(np.diff(angle_arcsec))
    jumps = np.zeros(len(torque), dtype=bool)
    digit = float(torque[torque > 0].min()) if torque.any() else 0.0
    for inside in (1 / 3, *(0.5,) * _LIMITS.rounds) if len(torque) else ():
        usual, of_angle = (np.quantile(v[~jumps], inside) for v in (torque, angle))
        usual_angle = max(float(of_angle), step_arcsec)
        far = np.hypot(torque / (max(float(usual), digit) or 1.0), angle / (usual_angle or np.inf))
        known, jumps = jumps, far > _LIMITS.jump
        if np.array_equal(known, jumps) or jumps.all():
            break
    return np.split(np.arange(len(torque_Nm)), np.flatnonzero(jumps) + 1)


def _settles(torque_Nm: Floats, hold: Ints, long: NDArray[np.bool_]) -> bool:
    """Whether the first readings of holds lag behind the step that led there, as those of a late
    sensor do: the mean of such a hold is the torque of none of its readings. In order of time."""
    first = np.flatnonzero(np.diff(hold, prepend=-1) != 0)
    mean = (np.bincount(hold, torque_Nm) / np.bincount(hold))[hold[first]]
    step = np.sign(np.diff(mean, prepend=mean[0]))
    lags = (step * (mean - torque_Nm[first]))[long[first] & (step != 0)]
    if len(lags) < _LIMITS.fewest_dof:
        return False
    return bool(lags.mean() > _LIMITS.overshot * lags.std(ddof=1) / np.sqrt(len(lags)))


def _are_stairs(torque_Nm: Floats, parts: list[Ints]) -> bool:
    """Whether the torque of a run gets from one part to the next between them: on a ramp it does so
    inside them as well, by the share of the steps that they have."""
    if len(parts) < _LIMITS.fewest:
        return False
    mean = np.array([torque_Nm[part].mean() for part in parts])
    # Each part but the first and the last, and where the torque goes around it.
    way = 0.5 * (mean[2:] - mean[:-2])
    inside = np.array([torque_Nm[part[-1]] - torque_Nm[part[0]] for part in parts[1:-1]])
    share = 1 - (len(parts) - 2) / sum(len(part) for part in parts[1:-1])
    return float(np.sign(way) @ inside) < 0.5 * share * float(np.abs(way).sum())


def _levels(campaign: Campaign) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Which level each torque is of, over all runs, and whether it has enough readings: levels are
    apart by several times the widest gap inside one."""
    torque = campaign.readings.torque_Nm
    order = np.argsort(torque, kind="stable")
    gaps = np.diff(torque[order])
    level, none = np.arange(len(torque)), np.zeros(len(torque), dtype=bool)
    size = np.sort(gaps)
    wider = size[1:] > _LIMITS.apart * size[:-1]
    # Beyond the middle: the most gaps are those between readings of one level.
    wider[: len(size) // 2] = False
    if not wider.any():
        return level, none
    widest_inside = size[:-1][wider][-1]
    level[order] = np.r_[0, np.cumsum(gaps > widest_inside)]
    long = np.bincount(level)[level] >= _LIMITS.fewest
    scatter = _alike(campaign, level) and not _are_set(campaign, level)
    return (level, long) if scatter else (level, none)


def _are_set(campaign: Campaign, level: NDArray[np.int64]) -> bool:
    """Whether runs come back to their own torques far more closely than they agree on a level: then
    levels that differ by little are those of different runs, and no scatter of one."""
    torque = campaign.readings.torque_Nm
    _, own = np.unique(
        np.column_stack([campaign.rows.run_index, level]), axis=0, return_inverse=True
    )
    count = np.bincount(own)
    free = int(np.sum(count - 1))
    if free < _LIMITS.fewest_dof or np.count_nonzero(count > 1) < 2:
        return False
    mean = _means(torque, own)
    inside = float(np.sum((torque - mean) ** 2)) / free
    off = (mean - _means(torque, level))[count[own] > 1]
    return inside < _LIMITS.set_apart * float(np.mean(off**2))


def _alike(campaign: Campaign, level: NDArray[np.int64]) -> bool:
    """Whether levels have one torque in every run and however they were reached. Of one that is
    overshot, or of a sensor that is late, the mean is the torque of none of its readings."""
    torque, way = campaign.readings.torque_Nm, campaign.readings.direction()
    inside = (np.bincount(level)[level] >= _LIMITS.fewest) & (way != 0)
    off = (torque - _means(torque, level))[inside]
    for kind in (campaign.rows.run_index, level):
        _, group = np.unique(2 * kind[inside] + (way[inside] > 0), return_inverse=True)
        count = np.bincount(group)
        mean = np.bincount(group, off) / count
        own = float(np.sum((off - mean[group]) ** 2)) / max(len(off) - len(count), 1)
        if np.any(mean**2 * count > _LIMITS.overshot**2 * own):
            return False
    return True


def _places(campaign: Campaign) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Which place in runs of one kind each reading has, and whether such runs are alike: they
    differ no more from their mean than torques scatter from reading to reading."""
    torque, rows = campaign.readings.torque_Nm, campaign.rows
    place, alike = np.arange(len(torque)), np.zeros(len(torque), dtype=bool)
    kinds: dict[int, list[NDArray[np.int64]]] = {}
    for run in np.split(rows.order, rows.starts[1:]):
        kinds.setdefault(len(run), []).append(run)
    for runs in kinds.values():
        if len(runs) < _LIMITS.fewest or not 1 < len(runs[0]) <= _LIMITS.columns:
            continue
        table = np.array(runs)
        off = torque[table] - torque[table].mean(axis=0)
        differ = float(np.sqrt(np.sum(off**2) / (off.size - off.shape[1])))
        # Where only the sensor scatters, what runs differ by is as rough along a run as it can be.
        steps = float(np.sqrt(np.mean(np.diff(off, axis=1) ** 2) / 2 / (1 - 1 / len(runs))))
        if steps > _LIMITS.aimless**0.5 * differ:
            place[table] = table[0]
            alike[table] = True
    return np.unique(place, return_inverse=True)[1], alike


def _aimless(torque_Nm: Floats) -> bool:
    """Whether values scatter about a level, and neither climb nor turn back along a loop."""
    steps = float(np.mean(np.diff(torque_Nm) ** 2))
    return steps >= _LIMITS.aimless * 2 * float(np.var(torque_Nm, ddof=1))


def _means(values: Floats, hold: NDArray[np.int64]) -> Floats:
    return np.asarray((np.bincount(hold, values) / np.bincount(hold))[hold])
