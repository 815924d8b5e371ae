"""What follows values through a slack: the play operator, as a test writes it down by hand."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def following(values: Floats, half_width: float, runs: NDArray[np.int64]) -> Floats:
    """Of each run from 0: where it was, moved as little as keeps it within the half width."""
    follows = np.zeros(len(values))
    for run in np.unique(runs):
        at = 0.0
        for i in np.flatnonzero(runs == run):
            at = float(np.clip(at, values[i] - half_width, values[i] + half_width))
            follows[i] = at
    return follows
