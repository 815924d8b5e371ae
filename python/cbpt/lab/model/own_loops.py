"""What a table's own smaller loops say of a play and of friction.

SmallLoops        the runs of the smallest amplitude: what they turn, how far apart their flanks
                  lie at most, and whether friction held them
small_loops_of    finds them
play_allowed_rad  the largest play that does not contradict them

A loop that comes back from +A lies on its upper flank until the torque falls through zero, and one
that comes back from -A on its lower flank until it rises through zero; friction Tc keeps either
there for longer. With F and R the angles on these ways, the share s(t + Tc) of a play j is then
taken up at a torque t, so j <= (F(t) - R(-t))/s(t + Tc) at every t, with s that of the widest
transition that still is a play. Without friction this is the step across zero torque, with much
friction the width of the loop at zero torque. Tc is the torque at which the loop has turned half
of that width. Angles and torques are those of readings, each on the side that allows more.

Friction that is not overcome holds the members off their flanks. By Masing's rule such a loop
turns by as much as a large one does over the same torque after it has turned back (G. Masing,
Proc. 2nd Int. Congr. Appl. Mech., 1926); it says nothing of a play.

A loop that opens by much of what it turns has overcome most of the friction: where friction f of
its limit Tf is built up at its ends, f Tf is at most the amplitude A, so Tf <= A/f. Where friction
grows with the load, Tf is that at the ends of the loop.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.model.dataset import Campaign
from cbpt.results import ARCSEC_PER_RAD

Floats = NDArray[np.float64]

PLAY = "backlash.play_rad"
CENTRE = "centre_torque_Nm"
"""Of a play that lies off zero torque, of which small loops may show nothing."""
FRICTION = "friction_hysteresis.friction_torque_Nm"
ENGAGEMENT = "friction_hysteresis.engagement_angle_rad"
LOAD_SHARE = "friction_hysteresis.load_share"
WIDEST_TRANSITION = 0.1
"""Of the amplitude of the smallest loops: what is taken up over more torque is a soft middle."""
ALIKE = 1.25
"""Amplitudes within this factor of the smallest are one kind of loop."""
_MASING = 2.0
"""A loop that turns by more than this many times what friction lets it is not held by friction."""
_SCATTER = 8.0
"""Standard uncertainties between the largest and the smallest of readings that only scatter."""
_HELD = 0.98
"""Of the largest torque: readings above it are of its dwell."""
_LEAST = 0.05
"""Share of its turn that a small loop leaves open as play."""
_BUILT_UP = np.linspace(0.0, 1.0, 1001)[1:-1]
"""Shares of its limit that friction reaches at the ends of a loop."""
_OPENS = -np.log1p(-(_BUILT_UP**2)) / (2 * np.arctanh(_BUILT_UP))
"""Of what it turns: how far apart its flanks then lie at zero torque, where friction holds the
whole load (Dahl's law from one end to the other). Springs that share the load bring them closer."""
_TORQUES = np.array([0.0, 0.05, 0.1, 0.2, 0.3, 0.5])
"""Where the flanks are compared, in shares of the amplitude."""


@dataclass(frozen=True)
class SmallLoops:
    """The runs of the smallest amplitude."""

    amplitude_Nm: float
    turn_arcsec: float
    """Largest less smallest angle, the median over these runs."""
    apart_arcsec: float
    """How far apart their flanks lie at most, the mean over these runs."""
    opens_arcsec: float
    """How far apart their flanks lie at zero torque, the mean over these runs."""
    held: bool
    """Whether friction holds them, as far as one can tell."""

    @property
    def allowed_arcsec(self) -> float:
        """The largest play that does not contradict them."""
        return np.inf if self.held else max(self.apart_arcsec, _LEAST * self.turn_arcsec)

    @property
    def play_rad(self) -> float:
        """The same, rad."""
        return self.allowed_arcsec / ARCSEC_PER_RAD

    @property
    def friction_Nm(self) -> float:
        """The largest friction at their ends that opens them as far."""
        share = np.clip(self.opens_arcsec / self.turn_arcsec if self.turn_arcsec else 0.0, 0.0, 1.0)
        return self.amplitude_Nm / float(np.interp(share, _OPENS, _BUILT_UP))


@dataclass(frozen=True)
class _Loop:
    """The readings of a run through zero torque, in their order."""

    torque_Nm: Floats
    angle_arcsec: Floats

    def either_way(self) -> tuple[_Loop, _Loop]:
        """As it is, and with both signs turned over: the lower flank is then the upper one."""
        return self, _Loop(-self.torque_Nm, -self.angle_arcsec)

    @property
    def top(self) -> int:
        return int(np.argmax(self.torque_Nm))

    def until(self, torque_Nm: float) -> int:
        """The last reading on the way back from the largest torque to this one."""
        below = np.flatnonzero(self.torque_Nm[self.top :] < torque_Nm)
        return self.top + (max(int(below[0]) - 1, 0) if len(below) else -1 - self.top)

    def at_zero_arcsec(self) -> float | None:
        """The first angle at zero torque or beyond on the way back from the largest one; where the
        run ends less than a step short of it, that of one more such step; None where it does not
        come back."""
        torque, angle = self.torque_Nm, self.angle_arcsec
        below = np.flatnonzero(torque[self.top :] <= 0)
        if len(below):
            return float(angle[self.top + below[0]])
        next_one = self.top + 1 < len(torque) and 2 * torque[-1] <= torque[-2]
        return float(2 * angle[-1] - angle[-2]) if next_one else None

    def held_until_Nm(self, middle_arcsec: float) -> float:
        """The torque the other way at which it is still above a middle, at least 0."""
        below = np.flatnonzero(self.angle_arcsec[self.top :] < middle_arcsec)
        return max(-float(self.torque_Nm[self.top + below[0] - 1]), 0.0) if len(below) else 0.0

    def turned_back_arcsec(self, swing_Nm: float) -> float | None:
        """What it turns from the end of its largest torque until that has come back by so much;
        None where it does not. What it creeps while the torque is held is no way back."""
        held = np.flatnonzero(self.torque_Nm >= _HELD * self.torque_Nm[self.top])
        last = int(held[-1])
        end_Nm = self.torque_Nm[last] - swing_Nm
        beyond = np.flatnonzero(self.torque_Nm[last:] <= end_Nm)
        if not len(beyond):
            return None
        two = [last + int(beyond[0]), last + int(beyond[0]) - 1]
        end = np.interp(end_Nm, self.torque_Nm[two], self.angle_arcsec[two])
        return max(float(self.angle_arcsec[last] - end), 0.0)


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
    small = both & (amplitude <= ALIKE * smallest)
    amplitude_Nm, turned = float(np.median(amplitude[small])), float(np.median(turn[small]))
    loops = list(_loops(campaign, small))
    u = _scatter_arcsec(campaign, loops)
    apart = float(np.mean([_apart_arcsec(loop, amplitude_Nm) for loop in loops])) + 3 * u
    opens = _opens_arcsec(loops) - 3 * u
    held = False
    if largest > ALIKE * smallest:
        back = _turned_back(_loops(campaign, both & ~small), 2 * amplitude_Nm)
        held = turned <= _MASING * back + _SCATTER * u
    return SmallLoops(amplitude_Nm, turned, apart, opens, held)


def _loops(campaign: Campaign, wanted: NDArray[np.bool_]) -> Iterator[_Loop]:
    """The runs wanted, without readings that have no angle."""
    rows = campaign.rows
    ends = np.append(rows.starts, len(rows.order))
    for run in np.flatnonzero(wanted):
        here = rows.order[ends[run] : ends[run + 1]]
        here = here[np.isfinite(campaign.y_arcsec[here])]
        yield _Loop(campaign.readings.torque_Nm[here], campaign.y_arcsec[here])


def _apart_arcsec(loop: _Loop, amplitude_Nm: float) -> float:
    """How far apart the flanks of one loop lie at most."""
    ways = loop.either_way()

    def lie_apart(torque_Nm: float) -> list[float]:
        return [float(one.angle_arcsec[one.until(torque_Nm)]) for one in ways]

    upper, lower = lie_apart(0.0)
    friction_Nm = max(
        one.held_until_Nm(sign * 0.5 * (upper - lower))
        for one, sign in zip(ways, (1, -1), strict=True)
    )
    found = np.array([sum(lie_apart(share * amplitude_Nm)) for share in _TORQUES])
    carried = _TORQUES + friction_Nm / amplitude_Nm
    taken_up = carried / np.hypot(carried, WIDEST_TRANSITION)
    known = taken_up > 0
    return float((found[known] / taken_up[known]).min())


def _opens_arcsec(loops: Sequence[_Loop]) -> float:
    """How far apart the flanks lie at zero torque, the mean over the loops that come back to it
    from both ends; 0 where none does."""
    flanks = [[one.at_zero_arcsec() for one in loop.either_way()] for loop in loops]
    found = [upper + lower for upper, lower in flanks if upper is not None and lower is not None]
    return float(np.mean(found)) if found else 0.0


def _scatter_arcsec(campaign: Campaign, loops: list[_Loop]) -> float:
    """Standard uncertainty of a reading: as stated, else what the small loops show from each
    reading to the next two, or the rounding of a display. What a fit finds may hold what its model
    lacks."""
    if campaign.u_stated:
        return float(np.median(campaign.u_reading_arcsec))
    bends = np.concatenate([np.diff(loop.angle_arcsec, 2) for loop in loops])
    # Median of the absolute values of normal ones, which are sums with 1, -2, 1.
    seen = float(np.median(np.abs(bends))) / (0.6745 * 6**0.5) if len(bends) else 0.0
    return max(seen, display_step(campaign.readings.elastic_angle_arcsec) / 12**0.5)


def _turned_back(loops: Iterator[_Loop], swing_Nm: float) -> float:
    """What large loops turn from their largest torque of either sign until it has come back by so
    much: the median, arcsec."""
    ways = (one.turned_back_arcsec(swing_Nm) for loop in loops for one in loop.either_way())
    found = [way for way in ways if way is not None]
    return float(np.median(found)) if found else 0.0


def play_allowed_rad(campaign: Campaign) -> float:
    """The largest play that does not contradict the smallest loops, rad; infinite without loops."""
    loops = small_loops_of(campaign)
    return np.inf if loops is None else loops.play_rad


def _per_run(values: Floats, run: NDArray[np.int64], runs: int) -> tuple[Floats, Floats]:
    """The largest and the smallest value of each run."""
    high, low = np.full(runs, -np.inf), np.full(runs, np.inf)
    # Not a number where nothing was read: points that are to be predicted.
    np.fmax.at(high, run, values)
    np.fmin.at(low, run, values)
    return high, low
