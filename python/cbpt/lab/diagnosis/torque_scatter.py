"""Ramps of torque as they come: how much the torque column scatters about them, and what that makes
of an angle.

with_torque_scatter  a campaign whose uncertainties hold the scatter of its torques, and a note

A torque that is off by s moves the angle by s times the slope of the curve: hardly where the drive
is stiff, and by the whole play where one reading crosses it. Without it a few readings on the
flanks of a loop, each off by tens of its uncertainties, decide about friction, a zero of the torque
and what changed. The slope is that of the readings, so that it hangs on no model (errors in
variables: Fuller, Measurement Error Models, 1987; combined standard uncertainty: JCGM 100:2008,
5.1).

Scatter are the differences of the torque along a run, of second order and more, in which a
curve hardly shows; those of chosen set points are not, and the angle follows them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import neighbour_scatter, typical_size
from cbpt.lab.diagnosis.held_torque import holds
from cbpt.lab.model.dataset import Campaign

__all__ = ["with_torque_scatter"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """What counts as a ramp that is measured as it comes."""

    fewest: int = 12
    """Readings of a run."""
    window: int = 4
    """Readings before and behind, over which a slope is taken to see whether the angle follows."""
    follows: float = 0.5
    """Share of the second differences of the torque beyond which the angle follows them: they are
    no noise."""
    largest: float = 0.05
    """Share of the largest torque: what scatters by more is no ramp."""
    orders: int = 8
    """Of the differences that are looked at."""
    alike: float = 0.7
    """Of what one order shows the next one has to show: then it is scatter."""
    shown: float = 0.5
    """Of the uncertainty of a reading: what moves no angle by more is left out."""


_LIMITS = _Limits()


def with_torque_scatter(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """The campaign as it is where torques do not scatter, or its angle follows them."""
    torque, angle = campaign.readings.torque_Nm, campaign.y_arcsec
    runs = list(_runs(campaign))
    if not runs:
        return campaign, []
    scatter_Nm = float(np.median([_beside_its_curve(torque[run]) for run in runs]))
    largest_Nm = float(np.abs(torque).max())
    if not 1e-6 * largest_Nm < scatter_Nm < _LIMITS.largest * largest_Nm:
        return campaign, []
    followed, sd = _followed(torque, angle, runs)
    # A loop that play and friction make hardly tells: near the jumps it counts most. Angles of a
    # ball drive go on evenly, and tell it where it matters.
    in_doubt = -2 if campaign.drive.kind == "torsion_spring" else 2
    if followed + in_doubt * sd > _LIMITS.follows:
        return campaign, []
    # Where a part of the scatter is the torque's own, the angle follows by that part of its square.
    scatter_Nm *= float(np.sqrt(1 - np.clip(followed, 0.0, _LIMITS.follows)))
    moved = np.zeros(len(torque))
    for run in runs:
        moved[run] = _moved(torque[run], angle[run], scatter_Nm)
    if moved.max() < _LIMITS.shown * float(np.median(campaign.u_arcsec)):
        return campaign, []
    told = (
        f"the torque readings scatter about their ramps by {scatter_Nm:.2g} N m that the angle "
        f"does not follow, which makes up to {moved.max():.2g} arcsec of an angle: it was added to "
        "the uncertainty of each reading"
    )
    u_arcsec = np.hypot(campaign.u_arcsec, moved)
    return replace(campaign, u_arcsec=u_arcsec, torque_scatter_Nm=scatter_Nm), [told]


def _beside_its_curve(torque: Floats) -> float:
    """What the torques of a run scatter by: scatter shows in differences of every order alike, and
    a curve, as of a load that swings, far less in each further one."""
    size = neighbour_scatter([torque], 2)
    for order in range(3, _LIMITS.orders + 1):
        further = neighbour_scatter([torque], order)
        if further > _LIMITS.alike * size:
            break
        size = further
    return size


def _runs(campaign: Campaign) -> Iterator[Ints]:
    """Readings of each run that is long enough, one after the other; where the torque was held at
    most of them, or does not move at most, it is no ramp."""
    rows, held = campaign.rows, holds(campaign)[1]
    for run in np.split(rows.order, rows.starts[1:]):
        moves = np.count_nonzero(np.diff(campaign.readings.torque_Nm[run])) > 0.5 * len(run)
        if len(run) >= _LIMITS.fewest and moves and not np.mean(held[run]) > 0.5:
            yield run


def _followed(torque: Floats, angle: Floats, runs: list[Ints]) -> tuple[float, float]:
    """Share of the second differences of the torque that those of the angle show, and its standard
    deviation: by the slope over a wider window, where the curve is neither steep nor turns; each
    run by its own scatter."""
    shown = expected = 0.0
    w = _LIMITS.window
    for run in runs:
        t, y = torque[run], angle[run]
        way = np.convolve(np.abs(np.diff(t)), np.ones(2 * w), mode="valid")
        across = t[2 * w :] - t[: -2 * w]
        straight = np.abs(across) > 0.6 * way
        if not straight.any():
            continue
        slope = (y[2 * w :] - y[: -2 * w]) / np.where(straight, across, np.inf)
        x, e = slope * np.diff(t, 2)[w - 1 : 1 - w], np.diff(y, 2)[w - 1 : 1 - w]
        size = typical_size(e)
        use = straight & (np.abs(e) < 4 * size) & (slope <= np.median(slope[straight]))
        if size > 0 and use.any():
            shown += float(x[use] @ e[use]) / size**2
            expected += float(x[use] @ x[use]) / size**2
    return (shown / expected, 1 / np.sqrt(expected)) if expected > 0 else (1.0, 0.0)


def _moved(torque: Floats, angle: Floats, scatter_Nm: float) -> Floats:
    """What the scatter makes of each angle, arcsec: of a curve that goes on evenly from reading to
    reading, its share of the step of the torque. What happens within a step or two alone, as where
    play is crossed, happens before or behind a torque that is off, with that share as its chance.
    As near to each reading as its torque may be off."""
    step = float(np.median(np.abs(np.diff(torque))))
    share = min(scatter_Nm / step, 1.0)
    change = np.abs(np.diff(angle))
    around = np.pad(change, 2)
    alone = np.maximum(change - np.maximum(around[:-4], around[4:]), 0.0)
    reach = 1 + int(np.ceil(2 * share))

    def nearby(values: Floats) -> Floats:
        """The largest so near to each reading."""
        return np.asarray(sliding_window_view(np.pad(values, reach), 2 * reach).max(axis=1))

    return np.asarray(np.hypot(share * nearby(change), np.sqrt(share) * nearby(alone)))
