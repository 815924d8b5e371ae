"""Whether the scatter of the readings changed.

NoiseChange    the scatter of each level, and the probability that it is not one and the same
noise_change   from the noise of the levels' fits
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cbpt.lab.inference.evidence import Fit

_SPREAD = 0.7
"""Standard deviation, in the logarithm, of a scatter that did change: a factor of 2."""
_ODDS = 0.1
"""Prior odds that it did."""


@dataclass(frozen=True)
class NoiseChange:
    """The scatter of each level."""

    u_arcsec: tuple[float, ...]
    """Standard deviation of a typical reading."""
    probability: float
    """That they are not all the same."""

    @property
    def changed(self) -> bool:
        """Whether that is as good as certain."""
        return self.probability >= 0.95

    def to_dict(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "changed": self.changed,
            "probability": self.probability,
            "u_arcsec": list(self.u_arcsec),
        }


def noise_change(fits: Sequence[Fit]) -> NoiseChange:
    """Normal in the logarithm of the scatter, with as many readings as correlation leaves."""
    size, variance = [], []
    for fit in fits:
        n, rho = len(fit.residual_arcsec), fit.noise.correlation
        left = max((n - len(fit.unknowns)) * (1 - rho) / (1 + rho), 2.0)
        residual = fit.residual_arcsec
        if fit.noise.inflation is not None:
            residual = residual / fit.noise.inflation
        size.append(float(np.sqrt(np.mean(residual**2))))
        # A sample of what is not quite normal knows its spread half as well.
        variance.append(2 / (2 * left))
    log = np.log(np.maximum(size, 1e-300))
    v = np.array(variance)

    def evidence(extra: float) -> float:
        """Of one mean, on which all levels scatter by `extra` beside their own variance."""
        w = 1 / (v + extra)
        mean = float(w @ log / w.sum())
        return float(0.5 * np.sum(np.log(w)) - 0.5 * np.log(w.sum()) - 0.5 * w @ (log - mean) ** 2)

    odds = _ODDS * np.exp(min(evidence(_SPREAD**2) - evidence(0.0), 500.0))
    return NoiseChange(tuple(size), float(odds / (1 + odds)))
