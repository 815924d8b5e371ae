"""The torque that a loop lies about.

    Middle      a torque, and how much of the loop's lopsidedness it does not explain
    middle_of   finds it

A drive that is alike both ways has a loop that goes over into itself when it is turned by half a
turn about its middle: the rising branch before it becomes the falling one after it. Where the
middle is not at zero torque, the torque sensor does not read zero without a torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbpt.lab.characteristics.loops import Loop


@dataclass(frozen=True)
class _Limits:
    """Shares of the amplitude."""

    reach: float = 0.5
    """Torques either side of the middle on which both branches are held against each other: beyond,
    one of them has just turned."""
    search: float = 0.2
    """Largest torque of a middle."""


_LIMITS = _Limits()
_POINTS = 201
_PLACES = 81


@dataclass(frozen=True)
class Middle:
    """Where a loop has its middle."""

    torque_Nm: float
    left: float
    """Share of the squares by which the branches differ about zero that is left about there."""


def middle_of(loop: Loop) -> Middle:
    """The torque about which the branches of a whole loop differ least."""
    from scipy.optimize import minimize_scalar

    if not (loop.whole and loop.rising and loop.falling):
        return Middle(0.0, 1.0)
    about_zero = _differ(0.0, loop)
    if about_zero <= _POINTS * (1e-9 * loop.turn_arcsec) ** 2:
        return Middle(0.0, 1.0)
    places = loop.amplitude_Nm * np.linspace(-_LIMITS.search, _LIMITS.search, _PLACES)
    differ = [_differ(float(place), loop) for place in places]
    best = int(np.clip(np.argmin(differ), 1, _PLACES - 2))
    found = minimize_scalar(
        _differ, bounds=(places[best - 1], places[best + 1]), args=(loop,), method="bounded"
    )
    return Middle(float(found.x), float(found.fun) / about_zero)


def _differ(torque_Nm: float, loop: Loop) -> float:
    """Sum of squares; the angle of the middle is free."""
    rising, falling = loop.rising, loop.falling
    assert rising is not None and falling is not None
    way = loop.amplitude_Nm * np.linspace(-_LIMITS.reach, _LIMITS.reach, _POINTS)
    both = rising.at(torque_Nm - way) + falling.at(torque_Nm + way)
    both = both[np.isfinite(both)]
    return float(np.sum((both - both.mean()) ** 2))
