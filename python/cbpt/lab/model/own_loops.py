"""What a table's own smaller loops say of a play.

SmallLoops        the runs of the smallest amplitude: what they turn, and whether friction held them
small_loops_of    finds them
play_allowed_rad  the largest play that does not contradict them

A loop that crosses zero torque takes up the whole play, so it turns by more than that: no play can
be larger than what the smallest loops turn. On both flanks it turns elastically besides. While the
torque comes back from an end of the loop to half of it, no play is crossed, and friction makes the
members no softer; so from what the loop turns there follows the least that is elastic, for members
that are straight or stiffen. It is taken off where larger loops of the same table show that these
are small. Friction that is not overcome there holds the members
off their flanks. By Masing's rule such a loop turns by as much as a large one does over the same
torque after it has turned back (G. Masing, Proc. 2nd Int. Congr. Appl. Mech., 1926); it says
nothing of a play.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.model.dataset import Campaign
from cbpt.results import ARCSEC_PER_RAD

PLAY = "backlash.play_rad"
_ALIKE = 1.25
"""Amplitudes within this factor of the smallest are one kind of loop."""
_MASING = 2.0
"""A loop that turns by more than this many times what friction lets it is not held by friction."""
_SCATTER = 8.0
"""Standard uncertainties between the largest and the smallest of readings that only scatter."""


_LEAST = 0.05
"""Share of its turn that a small loop leaves open as play however straight it is."""


@dataclass(frozen=True)
class SmallLoops:
    """The runs of the smallest amplitude."""

    amplitude_Nm: float
    turn_arcsec: float
    """Largest less smallest angle, the median over these runs."""
    elastic_arcsec: float
    """What of it is elastic; 0 where no larger loops show that these are small."""
    held: bool
    """Whether friction holds them, as far as one can tell."""

    @property
    def allowed_arcsec(self) -> float:
        """The largest play that does not contradict them."""
        if self.held:
            return np.inf
        return max(self.turn_arcsec - self.elastic_arcsec, _LEAST * self.turn_arcsec)


def small_loops_of(campaign: Campaign) -> SmallLoops | None:
    """The smallest loops through zero torque; None where no run goes both ways, and for a ball
    drive, which the preload keeps free of play."""
    if campaign.drive.kind == "ball_drive":
        return None
    torque, angle, rows = campaign.readings.torque_Nm, campaign.y_arcsec, campaign.rows
    high, low = _per_run(torque, rows.run_index, rows.runs)
    most, least = _per_run(angle, rows.run_index, rows.runs)
    amplitude, turn = np.minimum(high, -low), most - least
    both = (amplitude > 0.02 * np.abs(torque).max()) & np.isfinite(turn)
    if not both.any():
        return None
    smallest, largest = amplitude[both].min(), amplitude[both].max()
    small = both & (amplitude <= _ALIKE * smallest)
    amplitude_Nm, turned = float(np.median(amplitude[small])), float(np.median(turn[small]))
    held, elastic = False, 0.0
    if largest > _ALIKE * smallest:
        elastic = _elastic(campaign, np.flatnonzero(small))
        back = _turned_back(campaign, np.flatnonzero(both & ~small), 2 * amplitude_Nm)
        room = _SCATTER * float(np.median(campaign.u_arcsec))
        held = turned <= _MASING * back + room
    return SmallLoops(amplitude_Nm, turned, elastic, held)


def _elastic(campaign: Campaign, runs: NDArray[np.int64]) -> float:
    """What loops turn elastically, both flanks together: the slope from each end of the loop until
    half of the torque has gone, over all of that torque; the median, arcsec."""
    found = []
    for run in runs:
        here = _rows_of(campaign, run)
        total = 0.0
        for sign in (1, -1):
            torque, angle = sign * campaign.readings.torque_Nm[here], campaign.y_arcsec[here]
            top = int(np.argmax(torque))
            last = top + int(np.argmin(np.abs(torque[top:] - 0.5 * torque[top])))
            gone = torque[top] - torque[last]
            if 0 < gone < 0.8 * torque[top]:
                total += sign * float(angle[top] - angle[last]) / gone * torque[top]
        found.append(total)
    return max(float(np.nanmedian(found)), 0.0)


def _turned_back(campaign: Campaign, runs: NDArray[np.int64], swing_Nm: float) -> float:
    """What large loops turn from their largest torque of either sign until it has come back by so
    much: the median, arcsec."""
    found = []
    for run in runs:
        here = _rows_of(campaign, run)
        for sign in (1, -1):
            torque = sign * campaign.readings.torque_Nm[here]
            top = int(np.argmax(torque))
            back = np.flatnonzero(torque[top:] <= torque[top] - swing_Nm)
            if len(back):
                two = campaign.y_arcsec[here[[top, top + back[0]]]]
                found.append(float(abs(two[1] - two[0])))
    return float(np.median(found)) if found else 0.0


def _rows_of(campaign: Campaign, run: int) -> NDArray[np.int64]:
    """The readings of a run, in its order."""
    rows = campaign.rows
    ends = np.append(rows.starts, len(rows.order))
    return rows.order[ends[run] : ends[run + 1]]


def play_allowed_rad(campaign: Campaign) -> float:
    """The largest play that does not contradict the smallest loops, rad; infinite without loops."""
    loops = small_loops_of(campaign)
    return np.inf if loops is None else loops.allowed_arcsec / ARCSEC_PER_RAD


def _per_run(
    values: NDArray[np.float64], run: NDArray[np.int64], runs: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The largest and the smallest value of each run."""
    high, low = np.full(runs, -np.inf), np.full(runs, np.inf)
    # Not a number where nothing was read: points that are to be predicted.
    np.fmax.at(high, run, values)
    np.fmin.at(low, run, values)
    return high, low
