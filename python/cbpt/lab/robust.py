"""Readings that are looser than the rest: outliers and heavy tails, told before any cause is named.

    looseness   factor on each reading's standard deviation, or None where all are alike

Each reading is predicted from all others by a smooth field that can follow every effect of the library
and every pattern of the table (a Gaussian process; leave-one-out in closed form, Rasmussen and Williams
2006, eq. 5.12). What is far from its prediction gets the weight that Student's t with 4 degrees of freedom
gives it. A cause that is real moves its neighbours too, so it is not mistaken for a loose reading.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.noise import Whitener

Floats = NDArray[np.float64]

_DEGREES = 4.0
_FAR = 4.2
_KURTOSIS = 1.2
_AMPLITUDES = (0.0, 1.0, 4.0, 16.0, 64.0)


def looseness(
    y: Floats, certain: Floats, fields: Sequence[Floats], whitener: Whitener
) -> Floats | None:
    """y: misfit of the readings, (n,); certain: columns that are surely free; fields: groups of patterns.

    y and all columns in arcsec; the whitener says what scatter is stated.
    """
    n = len(y)
    y = y * whitener.inverse
    base = _kernel([certain * whitener.inverse[:, None]]) * 1e6
    smooth = _kernel([f * whitener.inverse[:, None] for f in fields])
    loose = np.ones(n)
    for _ in range(4):
        z = _left_out(y, base, smooth, loose)
        new = np.sqrt(np.maximum((_DEGREES + z**2) / (_DEGREES + 1), 1.0))
        if np.abs(new - loose).max() < 0.02 * new.max():
            break
        loose = new
    kurtosis = float(np.mean(z**4) / np.mean(z**2) ** 2 - 3)
    alike = np.abs(z).max() < _FAR and kurtosis < max(_KURTOSIS, 5 * np.sqrt(24 / n))
    return None if alike else loose


def _kernel(groups: Sequence[Floats]) -> Floats:
    """Groups of columns, each group as strong as any other."""
    total = 0.0
    for g in groups:
        k = g @ g.T
        size = float(np.trace(k)) / len(k)
        if size > 0:
            total = total + k / size
    return np.asarray(total) / max(len(groups), 1)


def _left_out(y: Floats, base: Floats, smooth: Floats, loose: Floats) -> Floats:
    """Each reading less its prediction from the others, in robust standard deviations."""
    best, out = -np.inf, y
    for amplitude in _AMPLITUDES:
        covariance = base + amplitude * smooth + np.diag(loose**2)
        try:
            factor = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            continue
        inverse = np.linalg.inv(factor)
        half = inverse @ y
        scale = float(half @ half) / len(y)
        value = -0.5 * len(y) * np.log(scale) - float(np.log(np.diag(factor)).sum())
        if value > best:
            precision = inverse.T @ inverse
            best = value
            # Standardised as if none were loose, so that the next weights start afresh.
            error = (precision @ y) / np.diag(precision)
            spread = np.sqrt(np.maximum(1 / np.diag(precision) - loose**2 + 1, 1.0))
            out = error / spread
    return np.asarray(out / (1.4826 * np.median(np.abs(out))))
