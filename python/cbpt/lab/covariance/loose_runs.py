"""Runs that scatter more than the others of their table.

loose_runs  factor on the uncertainty of each reading, 1 where its run scatters as the others do

A loose clamp, or a fan beside the rig in one run: as long as its readings weigh as much as the
others, any model that follows a few of them seems to be demanded. What a run scatters by shows in
its second differences, but so does what the model lacks where the torque goes in large steps, as of
a sensor that is late. So a run is compared with those that go in steps of half its size at least,
and not with one that holds a torque while the crank turns. Sizes are compared by ranks (Mann and
Whitney, Ann. Math. Stat. 18 (1947) 50), so that heavy tails make no run loose. What the model lacks
at one preload makes them large too, but it comes again at torques that the run reaches more than
once, and those of scatter change their sign: of independent readings each is correlated with the
next by -2/3, of readings whose neighbours are nearly alike by -1/2, of a smooth curve or a kink by
0 or more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import typical_size
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_CHANCE = 0.01
"""With which a run may be taken for loose where none is: its readings then tell a little less."""
_ALTERNATES = -1 / 3
"""Correlation of second differences half way from a curve to scatter."""
_SHARED = 1 + 2 * ((2 / 3) ** 2 + (1 / 6) ** 2)
"""By so much fewer are they, as they share readings: by the squares of their correlations."""


def loose_runs(readings: Readings, weighted: Floats) -> Floats:
    """Shape (n,). weighted: residuals of a model, right or wrong, in their uncertainties, (n,)."""
    found = np.ones(len(readings))
    rows = [np.flatnonzero(readings.run_index == run) for run in np.unique(readings.run_index)]
    torque = levels_of(readings.torque_Nm).index
    curved = [np.diff(weighted[r], 2) for r in rows]
    steps = [_typical_step(readings.torque_Nm[r]) for r in rows]
    for k, own in enumerate(curved):
        alike = [c for j, c in enumerate(curved) if j != k and steps[j] >= 0.5 * steps[k]]
        others = np.concatenate([np.zeros(0), *alike])
        size = typical_size(others)
        larger = size > 0 and _chance(own, others) * len(rows) < _CHANCE
        if larger and _alternates(own) and not _comes_again(own, torque[rows[k][1:-1]]):
            found[rows[k]] = max(typical_size(own) / size, 1.0)
    return found


def _typical_step(torque_Nm: Floats) -> float:
    """Root mean square, N m."""
    return float(np.sqrt(np.mean(np.diff(torque_Nm) ** 2))) if len(torque_Nm) > 1 else 0.0


def _chance(own: Floats, others: Floats) -> float:
    """Of sizes so much larger than the others by ranks, where both scatter alike."""
    from scipy.special import ndtr
    from scipy.stats import rankdata

    m, n = len(own), len(others)
    if not m:
        return 1.0
    rank = float(rankdata(np.abs(np.concatenate([own, others])))[:m].mean())
    sd = np.sqrt((m + n + 1) * n / (12 * m) * _SHARED)
    return float(ndtr(((m + n + 1) / 2 - rank) / sd))


def _alternates(curved: Floats) -> bool:
    return bool(curved[1:] @ curved[:-1] < _ALTERNATES * (curved @ curved))


def _comes_again(curved: Floats, torque: Ints) -> bool:
    """Whether means of each torque that comes again hold more of the squares than half way from
    scatter, of which they hold one for each, to a law, of which they hold all. Where none comes
    again nothing speaks for scatter."""
    _, group, count = np.unique(torque, return_inverse=True, return_counts=True)
    squares = np.bincount(group, curved**2, len(count))[count > 1].sum()
    means = (np.bincount(group, curved, len(count)) ** 2 / count)[count > 1].sum()
    if not squares > 0:
        return True
    by_chance = np.count_nonzero(count > 1) / count[count > 1].sum()
    return bool(means > 0.5 * (1 + by_chance) * squares)
