"""How large an effect has to be before a diagnosis tells it.

    log_odds    what an effect that stands out by so much brings against nothing
    distance    how far it has to stand out for the limit of odds

How far an effect stands out, `d`, is the length of what it adds to the readings, in standard
uncertainties, once the numbers of the drive, the calibrations and the offsets have been refitted.
The misfit it explains is d^2, worth a little less than half of that because the scatter is not
known beforehand; the price of its free size is that of `priors.log_size_prior`, and where its
shape is free as well there is a price for that. A reading of d scatters by 1, so an effect at
exactly the size at which the odds reach the limit (`DecisionRules.rival_odds`) is told half the
time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import STATED_DOF
from cbpt.lab.model.priors import Variant, log_density
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import prior

Floats = NDArray[np.float64]

LIMIT = RULES.log_rival_odds
"""Log odds against nothing from which an effect is told."""


def weight(variants: Sequence[Variant], variant: Variant) -> float:
    """Log prior odds of one form of an effect."""
    forms = sum(v.effect == variant.effect for v in variants)
    return prior((variant.effect,)) - float(np.log(forms))


def log_odds(
    variant: Variant, d: Floats, size: Floats, readings: int, shape: Floats | float = 0.0
) -> Floats:
    """Log Bayes factor against nothing of an effect that stands out by d at a size (SI, off
    neutral); arrays of one shape. readings: how many. shape: what its shape adds, below 0.
    """
    k = len(variant.sizes)
    r = np.maximum(size / variant.low, 1.0)
    own = r / np.maximum(d, 1.0)
    dof = readings + STATED_DOF
    likelihood = 0.5 * dof * np.log1p(d**2 / dof)
    return np.asarray(likelihood + k * np.log(own) + log_density(variant, r) + shape)


def distance(variant: Variant, weight: float, readings: int, above: float = 0.0) -> float:
    """The d at which an effect that grows in proportion to its size reaches the limit.

    above: normal quantile of how often; 0 is half the time.
    """
    d = np.geomspace(1.0, 100.0, 2000)
    odds = log_odds(variant, d, variant.low * np.maximum(d, 1), readings) + weight
    return float(np.interp(LIMIT, odds, d)) + above
