"""The step of a linear problem within bounds.

held_at_bounds  as far as each unknown may go, whatever solves the problem for those that are free
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


def held_at_bounds(
    asked: Callable[[Floats, Mask], Floats],
    pull: Callable[[Floats], Floats],
    low: Floats,
    high: Floats,
) -> Floats:
    """The step that a linear problem asks for within bounds, shape (p,): each unknown is held where
    the way meets its bound, and let go where it pulls away from it again (an active set; Nocedal
    and Wright 2006, chapter 16).

    asked: the step of those that are free, shape (free,), where the others have made theirs.
    pull: half the slope of the gain after a step, shape (p,).
    """
    p = len(low)
    # Where it begins is within bounds, but for the last digit.
    low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    step, free = np.zeros(p), np.ones(p, dtype=bool)
    for _ in range(3 * p):
        way = np.zeros(p)
        if free.any():
            way[free] = asked(step, free) - step[free]
        end = np.clip(step + way, low, high)
        out = free & (np.abs(step + way - end) > 1e-12 * np.abs(way))
        if out.any():
            share = np.divide(end - step, way, out=np.full(p, np.inf), where=out)
            first = out & (share <= share.min())
            step += max(float(share.min()), 0.0) * way
            step[first] = end[first]
            free &= ~first
            continue
        step += way
        slope = pull(step)
        away = ~free & np.where(step <= low, slope > 0, slope < 0) & (low < high)
        away &= np.abs(slope) > 1e-9 * float(np.abs(slope).max(initial=0.0))
        if not away.any():
            break
        free[int(np.argmax(np.where(away, np.abs(slope), 0.0)))] = True
    return step
