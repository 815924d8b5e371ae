"""Readings that scatter more than the rest: outliers and heavy tails, told before any cause is
named.

    inflation_of        factor on each reading's standard deviation, or None where all are alike
    price_of_inflation  what it costs to believe that readings scatter unlike

Each reading is predicted from all others by a smooth field that can follow every effect of the
library and every pattern of the table (a Gaussian process; leave-one-out in closed form, Rasmussen
and Williams 2006, eq. 5.12). What is far from its prediction gets the weight that Student's t with
4 degrees of freedom gives it; where few readings are wrong and the others normal, only those. A
cause that is real moves its neighbours too, so it is hardly mistaken for a loose reading; where it
is, the price decides: readings that scatter unlike and a cause that explains them are hypotheses of
one competition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import lgamma, log, pi

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Whitener, cholesky, inverse_diagonal, solved
from cbpt.lab.covariance.robust import typical_size

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """Numbers of the search for outliers."""

    degrees: float = 4.0
    far: float = 4.2
    kurtosis: float = 1.2
    amplitudes: tuple[float, ...] = (0.0, 1.0, 4.0, 16.0, 64.0)
    shares: tuple[float, ...] = tuple(np.geomspace(0.002, 0.1, 9).tolist())
    """Shares of the readings that may be outliers, each as probable as the next."""
    wrong: float = 10.0
    """Standard deviations by which half of them are off or more (Cauchy)."""


_LIMITS = _Limits()
_STUDENT = lgamma((_LIMITS.degrees + 1) / 2) - lgamma(_LIMITS.degrees / 2)
_STUDENT -= 0.5 * log(_LIMITS.degrees * pi)
"""Log density of Student's t at 0."""
_NORMAL = -0.5 * log(2 * pi)
_WITHIN = 0.09
"""What a normal distribution claims beyond Student's t where a factor is 1, on average."""
_SHARES = np.array(_LIMITS.shares)


def inflation_of(
    y: Floats, certain: Floats, fields: Sequence[Floats], whitener: Whitener
) -> Floats | None:
    """y: misfit of the readings, (n,); certain: columns that are surely free; fields: groups of
    patterns.

    y and all columns in arcsec; the whitener says what scatter is stated.
    """
    n = len(y)
    y = y * whitener.inverse
    base = _kernel([certain * whitener.inverse[:, None]]) * 1e6
    smooth = _kernel([f * whitener.inverse[:, None] for f in fields])
    loose = np.ones(n)
    z = y
    for turn in range(4):
        if turn < 2:
            amplitude = max(
                _LIMITS.amplitudes, key=lambda a: _likelihood(y, base + a * smooth, loose)
            )
        z = _left_out(y, base + amplitude * smooth, loose)
        new = np.sqrt(np.maximum((_LIMITS.degrees + z**2) / (_LIMITS.degrees + 1), 1.0))
        if np.abs(new - loose).max() < 0.05 * new.max():
            break
        loose = new
        if turn == 0 and _alike(z):
            return None
    return None if _alike(z) else _those_wrong(z, loose)


def price_of_inflation(inflation: Floats) -> float:
    """Log density that a normal distribution with these factors claims beyond one that knows no
    factors: Student's t (heavy tails), or a normal one in which a small share of the readings is
    wrong by far (outliers; Box and Tiao, Biometrika 55 (1968) 119), whichever claims less.

    A factor w belongs to a reading (5 w^2 - 4)^(1/2) standard deviations off; where w is 1 the mean
    over readings within one standard deviation counts.
    """
    w = inflation[inflation > 1]
    within = len(inflation) - len(w)
    z2 = (_LIMITS.degrees + 1) * w**2 - _LIMITS.degrees
    normal = float((_NORMAL - np.log(w) - 0.5 * z2 / w**2).sum())
    few = _few(z2) + np.log1p(-_SHARES) * within
    return normal - max(float(_heavy(z2).sum()) - _WITHIN * within, _mean_exp(few))


def _heavy(z2: Floats) -> Floats:
    """Log density of Student's t, by the squares of readings in standard deviations."""
    v = _LIMITS.degrees
    return np.asarray(_STUDENT - 0.5 * (v + 1) * np.log1p(z2 / v))


def _few(z2: Floats) -> Floats:
    """Log density of all readings where a share of them is wrong by far, for each such share."""
    right, wrong = _NORMAL - 0.5 * z2, _wrong(z2)
    both = np.logaddexp(np.log1p(-_SHARES)[:, None] + right, np.log(_SHARES)[:, None] + wrong)
    return np.asarray(both.sum(axis=1))


def _wrong(z2: Floats) -> Floats:
    """The same of a reading that is wrong."""
    return -np.log(np.pi * _LIMITS.wrong * (1 + z2 / _LIMITS.wrong**2))


def _mean_exp(values: Floats) -> float:
    return float(np.logaddexp.reduce(values) - np.log(len(values)))


def _those_wrong(z: Floats, loose: Floats) -> Floats:
    """Where few readings are wrong rather than all have heavy tails, only those are loose."""
    z2 = z**2
    few = _few(z2)
    if _mean_exp(few) < _heavy(z2).sum():
        return loose
    share = _SHARES[int(np.argmax(few))]
    likelier = np.log(share) + _wrong(z2) > np.log1p(-share) + _NORMAL - 0.5 * z2
    return np.where(likelier, loose, 1.0)


def _alike(z: Floats) -> bool:
    """Whether no reading is far and the tails are those of a normal distribution."""
    kurtosis = float(np.mean(z**4) / np.mean(z**2) ** 2 - 3)
    return bool(
        np.abs(z).max() < _LIMITS.far and kurtosis < max(_LIMITS.kurtosis, 5 * np.sqrt(24 / len(z)))
    )


def _kernel(groups: Sequence[Floats]) -> Floats:
    """Groups of columns, each group as strong as any other."""
    n = len(groups[0])
    sizes = [float(np.sum(g * g)) / n for g in groups]
    alike = [g / np.sqrt(size) for g, size in zip(groups, sizes, strict=True) if size > 0]
    both = np.column_stack([np.zeros((n, 0)), *alike])
    return np.asarray(both @ both.T) / max(len(groups), 1)


def _likelihood(y: Floats, covariance: Floats, loose: Floats) -> float:
    """Of y up to a constant, the scale of the covariance being free."""
    try:
        factor = cholesky(covariance + np.diag(loose**2))
    except np.linalg.LinAlgError:
        return -np.inf
    size = 0.5 * len(y) * np.log(float(y @ solved(factor, y)))
    return -float(size + np.log(np.diagonal(factor)).sum())


def _left_out(y: Floats, covariance: Floats, loose: Floats) -> Floats:
    """Each reading less its prediction from the others, in robust standard deviations."""
    factor = cholesky(covariance + np.diag(loose**2))
    own = inverse_diagonal(factor)
    error = solved(factor, y) / own
    # Standardised as if none were loose, so that the next weights start afresh.
    out = error / np.sqrt(np.maximum(1 / own - loose**2 + 1, 1.0))
    return np.asarray(out / typical_size(out))
