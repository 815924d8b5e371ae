"""The noise that makes readings most likely, structure by structure.

fit_noise        scale, correlation along a run and offsets of runs, as far as they pay their price
log_scale_prior  how far the scale may be from what is stated
price_of         what the structure of a noise costs
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt import _core
from cbpt.lab.covariance.linear_gaussian import Linear, Noise, Rows, Whitener
from cbpt.lab.covariance.outliers import price_of_inflation

Floats = NDArray[np.float64]

STATED_DOF = 8.0
"""A stated uncertainty is believed as if it came from this many repeats."""
HIDDEN_DOF = 1.0
"""The same where a coarse display hides most of the scatter."""
PRICE = 3.0
"""Log-likelihood that a further parameter of the noise has to gain: its prior and its width."""
PRICE_OF_ARTEFACT = 3.5
"""The same, beside its numbers: an artefact is as improbable beforehand as an effect."""
LEAST_SCALE = 0.25
"""Smallest scale: readings that agree better than they can are no proof of more."""


def log_scale_prior(scale: Floats, stated_dof: float) -> Floats:
    """Of scales, 0 where one is 1."""
    found = _core.log_scale_prior(np.ravel(scale), stated_dof)
    return found.reshape(np.shape(scale))


def price_of(noise: Noise) -> float:
    """Log likelihood that the structure of a noise has to gain."""
    inflation = 0.0 if noise.inflation is None else price_of_inflation(noise.inflation)
    artefact = 0.0
    if noise.artefact is not None and noise.has_artefact:
        artefact = PRICE_OF_ARTEFACT + np.log(noise.artefact.among)
    return PRICE * noise.numbers + float(artefact) + inflation


class _Sums:
    """Scalar products of columns, from which those of whitened columns follow for any noise.

    Where differences whiten, products are a polynomial in the correlation
    (`crates/cbpt-core/src/covariance/products.rs`), whose parts are made here, once.
    """

    def __init__(self, columns: Floats, u_arcsec: Floats, rows: Rows, start: Noise) -> None:
        shared = start.artefact
        if shared is not None:
            columns = np.column_stack([columns, shared.columns_arcsec])
        self.shared = 0 if shared is None else shared.columns_arcsec.shape[1]
        self._columns, self._u, self._rows = columns, u_arcsec, rows
        self._bare = replace(start, artefact=None, offset_arcsec=0.0)
        self._known: dict[tuple[float, float], tuple[Floats, Floats, float]] = {}
        exact = start.beside_arcsec is not None or start.held is not None
        self.products = self._whitened if exact else self._polynomials()

    def _polynomials(self) -> _core.NoisePolynomials:
        """The parts of the polynomials: products of all readings less those of the first or the
        last ones of the runs."""
        rows, inflation = self._rows, self._bare.inflation
        sd = self._u * (1.0 if inflation is None else inflation)
        # Run by run, with a column of ones.
        z = (np.column_stack([self._columns, np.ones(len(sd))]) / sd[:, None])[rows.order]
        first, last = z[rows.starts], z[np.append(rows.starts[1:], len(z)) - 1]
        all_, of_first, of_last = z.T @ z, first.T @ first, last.T @ last
        # A run's first reading stands behind the last one of the run before.
        cross = z[1:].T @ z[:-1] - first[1:].T @ last[:-1]
        grams = of_first, all_ - of_first, -(cross + cross.T), all_ - of_last
        one, behind = z[:, -1:], np.zeros(z.shape)
        behind[1:] = z[1:] * one[:-1] + z[:-1] * one[1:]
        behind[rows.starts] = 0.0
        all_by_run, crossed = np.add.reduceat(np.stack([z * one, behind]), rows.starts, axis=1)
        first, last = first * first[:, -1:], last * last[:, -1:]
        by_run = first, all_by_run - first, -crossed, all_by_run - last
        log_det, counts = 2 * float(np.log(sd).sum()), (len(sd), len(sd) - rows.runs)
        return _core.NoisePolynomials([g[:-1, :-1] for g in grams], list(by_run), log_det, counts)

    def _whitened(self, scale: float, correlation: float) -> tuple[Floats, Floats, float]:
        """Without offsets of runs: products, those of each run with a column of ones, and the log
        determinant. Noises that differ in their offsets share them."""
        key = scale, correlation
        if key not in self._known:
            bare = replace(self._bare, scale=scale, correlation=correlation)
            whitener = Whitener.of(bare, self._u, self._rows)
            seen = whitener(np.column_stack([self._columns, np.ones(len(self._u))]))
            x = seen[:, :-1]
            by_run = self._rows.sums(seen * seen[:, -1:])
            self._known[key] = x.T @ x, by_run, whitener.log_det
        return self._known[key]

    def gram(self, noise: Noise) -> tuple[Floats, float]:
        """Products of the whitened columns, and the log determinant of the covariance."""
        numbers = noise.scale, noise.correlation, noise.offset_arcsec
        return _core.noise_products(self.products, numbers, self.shared)


def least_scale(stated_dof: float) -> float:
    """The smallest scale; none where nothing is stated."""
    return LEAST_SCALE if stated_dof >= 1 else 1e-9


def fit_noise(
    linear: Linear,
    u_arcsec: Floats,
    rows: Rows,
    start: Noise,
    stated_dof: float = STATED_DOF,
    structures: bool = True,
) -> tuple[Noise, float]:
    """The noise that makes y = x p + noise most likely, and the logarithm of that likelihood.

    The price of each number of the noise is taken off, so noises of different structure compare.
    Flat unknowns (precision 0) count as degrees of freedom used up. The search is compiled
    (`crates/cbpt-core/src/covariance/search.rs`).
    """
    y, x, precision = linear
    sums = _Sums(np.column_stack([y, x]), u_arcsec, rows, start)
    typical = float(np.median(u_arcsec))
    counts, least = (len(y), rows.runs), least_scale(stated_dof)
    scale, correlation, offset, value = _core.search_noise(
        sums.products,
        (precision, sums.shared),
        (start.scale, start.correlation, start.offset_arcsec),
        (*counts, typical, stated_dof, least, rows.most_correlation, PRICE),
        structures,
    )
    noise = replace(start, scale=scale, correlation=correlation, offset_arcsec=offset)
    unstructured = replace(start, correlation=0.0, offset_arcsec=0.0)
    return noise, value - price_of(unstructured)
