"""The play of a loop, told from what friction does.

    friction_torque_Nm   half the mean width of a loop in torque
    Play                 the play of one loop, and what it would be with straight lines
    play_of              reads it off

Friction holds the spring's torque back by as much as it helps it on the way back: where both
branches have one angle, the torque of the spring is the mean of theirs. The play is therefore the
angle between both sides where the mean torque of the branches goes to zero. A parabola through each
branch, on torques beyond those of friction, is continued to there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.loops import Branch, Loop

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """Shares of the amplitude."""

    nearest: float = 0.05
    """Readings nearer to zero torque are not looked at, however small friction is: a play may be
    taken up softly."""
    furthest: float = 0.5
    """Nor those further out: there the falling branch has just turned."""
    friction: float = 0.1
    """Largest friction torque. Beyond, branches are continued over more than a third of the
    torques that they are read on, where friction has not yet come round fully."""
    beyond: float = 1.5
    """Readings nearer to zero than so many times the mean friction torque are not looked at:
    friction that comes round over an angle holds more than its mean."""
    fewest: int = 3
    """Readings of a branch on each side."""


_LIMITS = _Limits()
MOST_FRICTION = _LIMITS.friction
SPAN = _LIMITS.nearest, _LIMITS.furthest


@dataclass(frozen=True)
class Play:
    """Angles in arcsec, NaN where they cannot be had; below zero where the curve hardens."""

    jump_arcsec: float = np.nan
    straight_arcsec: float = np.nan
    """The same with straight lines in place of parabolas."""


def friction_torque_Nm(loop: Loop) -> float:
    """Half the width of a loop in torque, the mean over its angles: its area over its turn."""
    if loop.rising is None or loop.falling is None:
        return np.nan
    ends = [branch.ends_Nm for branch in (loop.rising, loop.falling)]
    low, high = max(end[0] for end in ends), min(end[1] for end in ends)
    area = loop.falling.integral(low, high) - loop.rising.integral(low, high)
    turn = loop.turn_arcsec
    return max(0.5 * area / turn, 0.0) if turn > 0 else 0.0


def play_of(loop: Loop) -> Play:
    """The play of a whole loop whose friction is small beside its amplitude."""
    if not (loop.whole and loop.rising and loop.falling):
        return Play()
    friction = friction_torque_Nm(loop) / loop.amplitude_Nm
    if not friction <= _LIMITS.friction:
        return Play()
    least = max(_LIMITS.nearest, _LIMITS.beyond * friction)
    ends = [_feet(loop.rising, loop.falling, loop.amplitude_Nm, s, least) for s in (1.0, -1.0)]
    if ends[0] is None or ends[1] is None:
        return Play()
    return Play(*(ends[0] - ends[1]).tolist())


def _feet(
    rising: Branch, falling: Branch, amplitude: float, sign: float, least: float
) -> Floats | None:
    """The angle on one side at which the torques of both branches are opposite and equal, with
    parabolas and with straight lines; None with too few readings."""
    found = []
    for branch in (rising, falling):
        share = branch.torque_Nm / amplitude
        size = sign * share * (1 + 1e-9)
        inside = (size >= least) & (size <= _LIMITS.furthest)
        if inside.sum() < _LIMITS.fewest:
            return None
        found.append((share[inside], branch.angle_arcsec[inside]))
    return np.array(
        [_meeting(*(np.polyfit(*points, degree) for points in found)) for degree in (2, 1)]
    )


def _meeting(rising: Floats, falling: Floats) -> float:
    """The angle of one curve at some torque and of the other at the opposite one, where they are
    the same; near zero torque."""
    mirrored = falling * (-1.0) ** np.arange(len(falling) - 1, -1, -1)
    apart = np.concatenate([[0.0], rising - mirrored])[-3:]
    square = apart[1] ** 2 - 4 * apart[0] * apart[2]
    if not (apart[1] > 0 and square >= 0):
        return np.nan
    torque = -2 * apart[2] / (apart[1] + np.sqrt(square))
    return float(np.polyval(rising, torque))
