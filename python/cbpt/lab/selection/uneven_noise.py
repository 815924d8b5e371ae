"""Whether what a fit takes for noise may be a law that shows in a part of the readings alone.

may_be_local_law  what is left is larger at some torques or in some runs, and smooth there

Noise may grow with the torque, and may be alike from one reading to the next; both together, what
is left is large in places and follows its neighbours there, as a law does that the model lacks at
those torques or at that time. Neither test asks how noise is distributed: sizes are compared by
their ranks (Kruskal and Wallis, J. Am. Stat. Assoc. 47 (1952) 583), and the products of neighbours
by their signs, which are even where neighbours are independent, however much each scatters.
Readings far off that follow one another to the same side are a law too, however few.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.residuals import left_by
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MOST_LEVELS = 12
"""More torques are taken together in as many parts."""
_FAR = 4.0
"""Standard deviations; of normal noise one reading in 16,000 is as far off."""


def may_be_local_law(fitter: Fitter, fit: Fit, chance: float) -> bool:
    """Whether noise would be as uneven, and where it is large as smooth, with less than `chance`
    each. Of a coarse display rounding is both."""
    c, noise = fitter.campaign, fit.noise
    if c.step_arcsec:
        return False
    own = noise.scale * c.u_arcsec
    sd = own if noise.beside_arcsec is None else np.hypot(own, noise.beside_arcsec)
    order = c.rows.order
    z = (left_by(c, fit) / sd)[order]
    follows = np.diff(c.readings.run_index[order]) == 0
    if _far_together(_innovations(z, follows, noise.correlation), follows) < chance:
        return True
    return _smooth(z[1:][follows] * z[:-1][follows]) < chance and any(
        _uneven(_innovations(z, follows, noise.correlation), part[order]) < chance / 2
        for part in _parts(c.readings)
    )


def _far_together(beside: Floats, follows: NDArray[np.bool_]) -> float:
    """Chance that as many readings far off follow one another to the same side, where any reading
    may be far off: a sensor that ends early, or sticks, is no scatter with heavy tails. beside:
    what each reading has beside what the one before it tells, in standard deviations."""
    from scipy.special import gammainc

    far = np.abs(beside) > _FAR
    both = far[1:] & far[:-1] & follows
    met = int(np.count_nonzero(both & (beside[1:] * beside[:-1] > 0)))
    count, places, n = int(far.sum()), int(follows.sum()), len(beside)
    expected = 0.5 * places * count * max(count - 1, 0) / (n * max(n - 1, 1))
    # Of a Poisson variable: as many or more.
    return float(gammainc(met, expected)) if met and expected > 0 else 1.0


def _innovations(z: Floats, follows: NDArray[np.bool_], correlation: float) -> Floats:
    """What each reading has beside what the one before it tells."""
    beside = (z[1:] - correlation * z[:-1]) / (1 - correlation**2) ** 0.5
    return np.concatenate([z[:1], np.where(follows, beside, z[1:])])


def _parts(readings: Readings) -> Iterator[Ints]:
    """Which part of the torques, and which run, each reading belongs to."""
    torque = levels_of(readings.torque_Nm).held
    levels = np.unique(torque)
    if len(levels) > _MOST_LEVELS:
        ends = np.quantile(torque, np.linspace(0, 1, _MOST_LEVELS + 1)[1:-1])
        yield np.searchsorted(ends, torque)
    else:
        yield np.searchsorted(levels, torque)
    yield np.asarray(readings.run_index)


def _smooth(products: Floats) -> float:
    """Chance that products of neighbours are positive by so much where signs are even."""
    from scipy.special import ndtr

    size = float(np.sqrt(np.sum(products**2)))
    return float(ndtr(-np.sum(products) / size)) if size > 0 else 1.0


def _uneven(values: Floats, part: Ints) -> float:
    """Chance that sizes differ so much from part to part."""
    from scipy.stats import kruskal

    parts = [np.abs(values[part == p]) for p in np.unique(part)]
    return float(kruskal(*parts).pvalue) if len(parts) > 1 else 1.0
