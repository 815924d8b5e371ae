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

FEWEST = 3
"""Readings of a stretch: settings that change with nearly every reading are no runs."""


def stretches(settings: Sequence[NDArray[np.float64]]) -> NDArray[np.int64] | None:
    """Labels 1, 2, ... of shape (n,); None where there is one stretch, or where some are short.

    settings: columns of shape (n,) that are set for a run.
    """
    changed = np.any([np.diff(column) != 0 for column in settings], axis=0)
    starts = np.concatenate([[0], np.flatnonzero(changed) + 1])
    lengths = np.diff(np.append(starts, len(changed) + 1))
    if len(starts) < 2 or lengths.min() < FEWEST:
        return None
    return np.repeat(np.arange(1, len(starts) + 1), lengths)
