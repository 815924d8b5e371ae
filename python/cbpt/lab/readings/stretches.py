"""Runs of a table without a column of runs.

stretches    readings that follow one another at one preload and one input angle

Someone who sets a preload and an angle, drives the torque through a loop and goes on to the next
has made a run of each, whether or not the table numbers them: between two of them the rig was
touched, and its zero may be another.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def stretches(
    settings: Sequence[NDArray[np.float64]], torque_Nm: NDArray[np.float64]
) -> NDArray[np.int64] | None:
    """Labels 1, 2, ... of shape (n,); None where there is one stretch, or where some have no loop
    of their own: settings that change at each torque, or are measured, are no runs.

    settings: columns of shape (n,) that are set for a run. A loop of its own spans two fifths of
    the torques of the table or more (one way from zero is half), and begins within a tenth of them
    of where the first one does.
    """
    changed = np.any([np.diff(column) != 0 for column in settings], axis=0)
    starts = np.concatenate([[0], np.flatnonzero(changed) + 1])
    most, least = (of.reduceat(torque_Nm, starts) for of in (np.maximum, np.minimum))
    spans, begins = most - least, torque_Nm[starts]
    apart, all_ = np.abs(begins - begins[0]), np.ptp(torque_Nm)
    if len(starts) < 2 or spans.min() < 0.4 * all_ or apart.max() > 0.1 * all_:
        return None
    return np.repeat(np.arange(1, len(starts) + 1), np.diff(np.append(starts, len(torque_Nm))))
