"""Where the uncertainty of a result comes from.

    Budget     the covariance of a fit, split into what the readings bring and what was known before
    Combined   one combined standard uncertainty with its parts

With whitened columns X and prior precisions P the unknowns are  C (X'y + P m),  C = (X'X + P)^-1,
so their covariance is the sum of  C X'X C  from the readings and of  P_j C_.j C_j.  from the prior
of each number j; together C. For a result with gradient g that is a budget of variances (JCGM
100:2008, section 5), and its effective degrees of freedom follow from that of the readings' part
(Welch and Satterthwaite, annex G), priors being taken as exactly known.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.priors import PRIORS

Floats = NDArray[np.float64]

READINGS = "readings"
TABLE = "points of the case's table"


@dataclass(frozen=True)
class _Shown:
    """What is worth a line."""

    least_share: float = 0.005
    """Parts of the variance below this are not worth a line; at the other end they are all of
    it.
    """
    nearly: float = 0.95
    covered: float = 0.95


_SHOWN = _Shown()


@dataclass(frozen=True)
class Combined:
    """A standard uncertainty and its parts."""

    u: float
    shares: dict[str, float]
    """Of the variance, by what it rests on, the largest first; they add up to 1 but for parts
    that are too small to tell."""
    dof: float
    """Effective degrees of freedom; infinite where the readings have no part in it."""

    @property
    def evaluation(self) -> str:
        """`A` from the readings, `B` from what was known before, `A+B` from both."""
        readings = self.shares.get(READINGS, 0.0)
        return "A" if readings > _SHOWN.nearly else "B" if readings < 1 - _SHOWN.nearly else "A+B"

    @property
    def coverage_factor(self) -> float:
        """Of an interval that covers 95 %."""
        from scipy.special import ndtri, stdtrit

        above = (1 + _SHOWN.covered) / 2
        return float(stdtrit(self.dof, above) if np.isfinite(self.dof) else ndtri(above))

    def beside(self, source: str, u: float) -> Combined:
        """With a part that is known exactly and independent of the others."""
        if not u > 0:
            return self
        square = self.u**2 + u**2
        own = self.u**2 / square
        shares = {name: own * share for name, share in self.shares.items()} | {source: 1 - own}
        told = dict(sorted(shares.items(), key=lambda share: -share[1]))
        return Combined(float(np.sqrt(square)), told, self.dof / own**2)


@dataclass(frozen=True, eq=False)
class Budget:
    """Of the unknowns of a fit, then its offsets; unknowns in SI, or in logarithms."""

    fit: Fit
    dof: float
    """Of the scatter of the readings."""
    covariance: Floats = field(repr=False)
    precision: Floats = field(repr=False)
    """Of the priors, 0 where there is none."""
    sources: tuple[str, ...] = ()
    """What stands behind each prior."""

    @classmethod
    def of(cls, fitter: Fitter, fit: Fit) -> Budget:
        """Of a fit of one campaign."""
        offsets = fit.margin.x.shape[1] - len(fit.unknowns)
        unit = np.r_[[u.unit for u in fit.unknowns], np.ones(offsets)]
        inverse = np.linalg.inv(fit.margin.factor)
        covariance = (inverse.T @ inverse) * np.outer(unit, unit)
        precision = np.r_[[u.sd**-2.0 for u in fit.unknowns], np.zeros(offsets)]
        sources = (*(_source(u) for u in fit.unknowns), *([""] * offsets))
        return cls(fit, dof_of(fitter, fit), covariance, precision, sources)

    def gradient(self, unknown: Unknown) -> Floats:
        """Of an unknown itself, SI."""
        g = np.zeros(len(self.covariance))
        i = self.fit.unknowns.index(unknown)
        g[i] = self.fit.value(unknown) if unknown.log else 1.0
        return g

    def combined(self, gradient: Floats) -> Combined | None:
        """Of a result with this gradient; None where the fit says nothing of it."""
        seen = self.covariance @ gradient
        variance = float(gradient @ seen)
        if not (np.isfinite(variance) and variance > 0):
            return None
        shares: dict[str, float] = {}
        for part, source in zip(self.precision * seen**2 / variance, self.sources, strict=True):
            if source and part > 0:
                shares[source] = shares.get(source, 0.0) + float(part)
        readings = max(1.0 - sum(shares.values()), 0.0)
        shares[READINGS] = readings
        told = {
            s: v for s, v in sorted(shares.items(), key=lambda t: -t[1]) if v > _SHOWN.least_share
        }
        dof = self.dof / readings**2 if readings > 1e-6 else np.inf
        return Combined(float(np.sqrt(variance)), told, float(dof))

    def correlation(self, one: Floats, other: Floats) -> float:
        """Of two results with these gradients."""
        a, b = self.covariance @ one, self.covariance @ other
        return float((one @ b) / np.sqrt((one @ a) * (other @ b)))


def dof_of(fitter: Fitter, fit: Fit) -> float:
    """Degrees of freedom of the scatter: those of the readings about the fit, and those that what
    was known before counts as. What is correlated is fewer independent readings."""
    free = sum(bool(np.isinf(u.sd)) for u in fit.unknowns)
    left = max(len(fitter.campaign) - fit.offsets_arcsec.size - free, 0)
    rho = fit.noise.correlation
    return float(left * (1 - rho) / (1 + rho) + fitter.stated_dof)


def _source(unknown: Unknown) -> str:
    """What the prior of an unknown is."""
    if np.isinf(unknown.sd):
        return ""
    if unknown.name in PRIORS:
        return f"stated {PRIORS[unknown.name].rpartition('_')[0]}"
    return range_of(unknown)


def range_of(unknown: Unknown) -> str:
    """The source that stands for the plausible range of a parameter."""
    return f"range of {unknown.name.rpartition('.')[2]}"
