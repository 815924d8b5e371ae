"""What loops and readings measure, for all checks: turn, width and scatter of the angle.

turn_arcsec, width_arcsec   of loops, the median
to_resolve_arcsec           what an instrument has to resolve of them
scatter_arcsec              standard deviation of a reading
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.readings.readings import Readings


@dataclass(frozen=True)
class _Limits:
    """The usual ratio of an instrument to what it measures: a tenth of the width that is read off a
    loop, or a hundredth of its turn where the loop is narrower."""

    of_width: float = 0.1
    of_turn: float = 0.01


_LIMITS = _Limits()


def turn_arcsec(loops: Sequence[Loop]) -> float:
    """The angle from end to end; 0 without loops."""
    return float(np.median([loop.turn_arcsec for loop in loops])) if loops else 0.0


def width_arcsec(loops: Sequence[Loop]) -> float:
    """Between both branches at zero torque; 0 where no loop has both."""
    widths = np.abs([loop.width_arcsec for loop in loops])
    known = widths[np.isfinite(widths)]
    return float(np.median(known)) if len(known) else 0.0


def to_resolve_arcsec(loops: Sequence[Loop]) -> float:
    """What an instrument has to resolve, and noise should not hide; 0 without loops."""
    return max(_LIMITS.of_width * width_arcsec(loops), _LIMITS.of_turn * turn_arcsec(loops))


def scatter_arcsec(r: Readings, loops: Sequence[Loop]) -> float:
    """Standard deviation of the angle beside its neighbours, the median over loops; the stated one
    where few readings cannot tell, 0 where none is stated either."""
    of_loops = [each for each in (loop.scatter_arcsec for loop in loops) if each > 0]
    if of_loops:
        return float(np.median(of_loops))
    u = r.u_elastic_angle_arcsec
    return 0.0 if u is None else float(np.median(u))
