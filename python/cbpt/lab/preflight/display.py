"""What a display leaves of the angle.

display_check   the step of the display against the loops and the stated uncertainty
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    of_u: float = 1.5
    """Steps of the display in a stated uncertainty."""
    of_width: float = 0.1
    of_turn: float = 0.01
    """A display resolves a tenth of the width that is read off a loop, or a hundredth of its turn
    where the loop is narrower: the usual ratio of an instrument to what it measures."""


_LIMITS = _Limits()


def display_check(r: Readings, loops: list[Loop]) -> Check:
    """The step of the display."""
    name, step = "display of the angle", display_step(r.elastic_angle_arcsec)
    if not step:
        return Check(name, "good", "no step is to be seen")
    words = f"the angle comes in steps of {rounded(step)} arcsec"
    u = r.u_elastic_angle_arcsec
    coarse = u is not None and step > _LIMITS.of_u * float(np.median(u))
    if loops:
        turn = float(np.median([loop.turn_arcsec for loop in loops]))
        widths = np.abs([loop.width_arcsec for loop in loops])
        known = widths[np.isfinite(widths)]
        width = float(np.median(known)) if len(known) else 0.0
        if step > max(_LIMITS.of_width * width, _LIMITS.of_turn * turn):
            coarse = True
            words += (
                f"; the loops turn by {rounded(turn)} arcsec and are {rounded(width)} arcsec wide"
            )
    if not coarse:
        return Check(name, "good", words)
    remedy = "Read more digits, or average; state a u that holds the step over the root of 12."
    return Check(name, "look", words, remedy)
