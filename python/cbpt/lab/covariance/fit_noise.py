"""The noise that makes readings most likely, structure by structure.

fit_noise        scale, correlation along a run and offsets of runs, as far as they pay their price
log_scale_prior  how far the scale may be from what is stated
price_of         what the structure of a noise costs
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import (
    Linear,
    Noise,
    Rows,
    Solved,
    Whitener,
)
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


@dataclass(frozen=True)
class _Grid:
    """Where the search for a noise looks first, and where it looks closer."""

    correlations: tuple[float, ...] = (0.25, 0.6)
    fine_correlations: tuple[float, ...] = (0.12, 0.4, 0.75, 0.88)
    offsets: tuple[float, ...] = (0.5, 2.0)
    """In typical uncertainties of a reading."""
    fine_offsets: tuple[float, ...] = (0.25, 1.0, 4.0, 10.0, 30.0)


_GRID = _Grid()


def log_scale_prior(scale: Floats, stated_dof: float) -> Floats:
    """Of scales, 0 where one is 1."""
    return np.asarray(-0.5 * stated_dof * (2 * np.log(scale) + 1 / scale**2 - 1))


def price_of(noise: Noise) -> float:
    """Log likelihood that the structure of a noise has to gain."""
    inflation = 0.0 if noise.inflation is None else price_of_inflation(noise.inflation)
    artefact = 0.0 if noise.artefact is None else PRICE_OF_ARTEFACT
    return PRICE * noise.numbers + artefact + inflation


class _Sums:
    """Scalar products of columns, from which those of whitened columns follow for any noise.

    With z the columns over the standard deviations, the autoregression whitens a reading that
    follows another to (z_t - rho z_(t-1)) / sqrt(1 - rho^2): its products are a polynomial in rho.
    """

    def __init__(self, columns: Floats, u_arcsec: Floats, rows: Rows, start: Noise) -> None:
        shared = start.artefact
        if shared is not None:
            columns = np.column_stack([columns, shared.columns_arcsec])
        self._shared = 0 if shared is None else shared.columns_arcsec.shape[1]
        self._columns, self._u, self._rows = columns, u_arcsec, rows
        self._exact = start.beside_arcsec is not None or start.held is not None
        self._known: dict[tuple[float, float], tuple[Floats, Floats, float]] = {}
        if self._exact:
            return
        sd = u_arcsec * (1.0 if start.inflation is None else start.inflation)
        z, one = columns / sd[:, None], 1 / sd
        follows = rows.before >= 0
        first, past = ~follows, rows.before[follows]
        now, then, one_now, one_then = z[follows], z[past], one[follows], one[past]
        cross = now.T @ then
        self._grams = z[first].T @ z[first], now.T @ now, -(cross + cross.T), then.T @ then
        self._log_sd = 2 * float(np.log(sd).sum())
        self._followers = int(np.count_nonzero(follows))

        def by_run(values: Floats, at: NDArray[np.bool_]) -> Floats:
            of_all = np.zeros((len(sd), values.shape[1]))
            of_all[at] = values
            return rows.sums(of_all)

        both, both_then = np.column_stack([now, one_now]), np.column_stack([then, one_then])
        self._runs = (
            by_run(np.column_stack([z[first], one[first]]) * one[first][:, None], first),
            by_run(both * one_now[:, None], follows),
            -by_run(both_then * one_now[:, None] + both * one_then[:, None], follows),
            by_run(both_then * one_then[:, None], follows),
        )

    def gram(self, noise: Noise) -> tuple[Floats, float]:
        """Products of the whitened columns, and the log determinant of the covariance."""
        gram, log_det = self._without_artefact(noise)
        if not self._shared:
            return gram, log_det
        # An artefact's columns stand last; what they explain is taken off all other products.
        kept = len(gram) - self._shared
        a = np.eye(self._shared) + gram[kept:, kept:]
        taken = gram[:kept, kept:] @ np.linalg.solve(a, gram[kept:, :kept])
        return gram[:kept, :kept] - taken, log_det + float(np.linalg.slogdet(a)[1])

    def _without_artefact(self, noise: Noise) -> tuple[Floats, float]:
        if self._exact:
            gram, runs, log_det = self._whitened(noise)
        else:
            gram, runs, log_det = self._by_polynomials(noise)
        if noise.offset_arcsec:
            size = runs[:, -1]
            grown = 1 + noise.offset_arcsec**2 * size
            weight = (1 - 1 / grown) / size
            gram = gram - runs[:, :-1].T @ (runs[:, :-1] * weight[:, None])
            log_det += float(np.log(grown).sum())
        return gram, log_det

    def _whitened(self, noise: Noise) -> tuple[Floats, Floats, float]:
        """Without offsets of runs: products, those of each run with a column of ones, and the log
        determinant. Noises that differ in their offsets share them."""
        key = noise.scale, noise.correlation
        if key not in self._known:
            bare = replace(noise, artefact=None, offset_arcsec=0.0)
            whitener = Whitener.of(bare, self._u, self._rows)
            seen = whitener(np.column_stack([self._columns, np.ones(len(self._u))]))
            x = seen[:, :-1]
            by_run = self._rows.sums(seen * seen[:, -1:])
            self._known[key] = x.T @ x, by_run, whitener.log_det
        return self._known[key]

    def _by_polynomials(self, noise: Noise) -> tuple[Floats, Floats, float]:
        """The same where differences whiten."""
        rho, square = noise.correlation, noise.scale**2

        def at(parts: tuple[Floats, Floats, Floats, Floats]) -> Floats:
            first, now, cross, then = parts
            follow = (now + rho * cross + rho**2 * then) / (1 - rho**2)
            return np.asarray((first + follow) / square)

        count = len(self._columns)
        log_det = self._log_sd + count * np.log(square) + self._followers * np.log1p(-(rho**2))
        runs = at(self._runs) if noise.offset_arcsec else np.zeros((0, 0))
        return at(self._grams), runs, float(log_det)


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
    Flat unknowns (precision 0) count as degrees of freedom used up.
    """
    y, x, precision = linear
    typical = float(np.median(u_arcsec))
    flat = int(np.count_nonzero(precision == 0))
    sums = _Sums(np.column_stack([y, x]), u_arcsec, rows, start)

    def rated(correlation: float, offset: float) -> tuple[float, Noise]:
        correlation = min(correlation, rows.most_correlation)
        scale = start.scale
        for _ in range(2):
            # The runs' offsets scale with the readings' noise while the latter is being found.
            noise = replace(
                start, scale=scale, correlation=correlation, offset_arcsec=offset * scale
            )
            gram, log_det = sums.gram(noise)
            margin = Solved.of(gram[1:, 1:], gram[1:, 0], float(gram[0, 0]), precision)
            # What the priors are pulled by says nothing of the noise.
            scattered = margin.chi2 - float(precision @ margin.mode**2)
            new = _balanced(scale, scattered, len(y) - flat, stated_dof)
            if abs(new / scale - 1) < 1e-3:
                break
            scale = new
        value = -0.5 * (margin.chi2 + log_det) + margin.log_volume
        value += float(log_scale_prior(np.array(scale), stated_dof)) - price_of(noise)
        return value, noise

    best = rated(0.0, 0.0)
    if structures and rows.runs < len(y):
        tried = [*_searched(best, rated, typical, rows.runs > 1)]
        if start.numbers:
            tried.append(rated(start.correlation, start.offset_arcsec / start.scale))
        best = max(tried, key=lambda t: t[0])
        best = _refined(best, rated)
    return best[1], best[0]


def _balanced(scale: float, chi2: float, dof: float, stated_dof: float) -> float:
    """The scale at which misfit and what is stated agree; chi2 was found with `scale`.

    Never far below what is stated: readings that agree better than they can are no proof of more.
    """
    least = least_scale(stated_dof)
    return max(float(np.sqrt((chi2 * scale**2 + stated_dof) / (dof + stated_dof))), least)


def _searched(
    white: tuple[float, Noise],
    rated: Callable[[float, float], tuple[float, Noise]],
    typical: float,
    with_offsets: bool,
) -> Iterator[tuple[float, Noise]]:
    """Noises of every structure; the fine grid of one only where the coarse one gains."""
    yield white
    alone = [rated(c, 0.0) for c in _GRID.correlations]
    if max(alone, key=lambda t: t[0])[0] > white[0]:
        alone += [rated(c, 0.0) for c in _GRID.fine_correlations]
    yield from alone
    if not with_offsets:
        return
    offsets = [rated(0.0, o * typical) for o in _GRID.offsets]
    if max(offsets, key=lambda t: t[0])[0] > white[0] - PRICE:
        offsets += [rated(0.0, o * typical) for o in _GRID.fine_offsets]
    yield from offsets
    either = max([*alone, *offsets], key=lambda t: t[0])
    if either[0] < white[0]:
        return
    noise = either[1]
    if noise.correlation:
        # Offsets that are not there yet look like a correlation larger than it is.
        for c in (noise.correlation, 0.5 * noise.correlation):
            yield from (rated(c, o * typical) for o in (0.7, 2.0, 5.0))
    else:
        ratio = noise.offset_arcsec / noise.scale
        yield from (rated(c, ratio) for c in (0.2, 0.5, 0.75))


def _refined(
    best: tuple[float, Noise], rated: Callable[[float, float], tuple[float, Noise]]
) -> tuple[float, Noise]:
    """Two rounds of smaller steps on whatever the noise has."""
    for share in (0.3, 0.12):
        noise = best[1]
        ratio = noise.offset_arcsec / noise.scale
        trials = []
        if noise.correlation:
            for step in (-share, share):
                c = noise.correlation + step * min(noise.correlation, 1 - noise.correlation)
                trials.append((c, ratio))
        if ratio:
            trials += [
                (noise.correlation, ratio * (1 - share)),
                (noise.correlation, ratio * (1 + share)),
            ]
        for c, o in trials:
            got = rated(c, o)
            if got[0] > best[0]:
                best = got
    return best
