"""What scatters: the covariance of the readings, and how to look at them through it.

    Rows        which readings follow each other in which run
    Noise       u off by a factor, correlation along a run, a zero of each run, loose readings
    Whitener    turns readings into independent ones of unit variance
    Margin      the likelihood of readings with linear unknowns of normal priors integrated out
    fit_noise   the noise that makes the readings most likely, structure by structure

The covariance is  s^2 D A D + o^2 B,  D the stated uncertainties (times what a loose reading is
looser by), A the correlation rho^|i-j| of a first-order autoregression along each run, B = 1 where
two readings share a run. Whitening is exact and costs a few passes over the rows: the
autoregression is undone by differences (Cochrane and Orcutt 1949), the runs' zeros by a rank-one
step a run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# A stated uncertainty is believed as if it came from this many repeats.
STATED_DOF = 8.0
FIXED_DOF = 1e5
"""So many repeats leave the scatter no say: what is stated stands."""
_CORRELATIONS, _FINE_CORRELATIONS = (0.25, 0.6), (0.12, 0.4, 0.75, 0.88)
_OFFSETS, _FINE_OFFSETS = (0.5, 2.0), (0.25, 1.0, 4.0, 10.0, 30.0)
# What a further number of the noise has to gain in log-likelihood: its prior and its width.
PRICE = 3.0
LEAST_SCALE = 0.25


@dataclass(frozen=True)
class Rows:
    """The order of n readings: `run_index` of each, and `before`, the one before it in its run or
    -1.

    order sorts the readings by run; starts says where in that order each run begins.
    """

    run_index: Ints
    before: Ints
    runs: int
    order: Ints
    starts: Ints

    @classmethod
    def of(cls, run_index: Ints) -> Rows:
        """Rows in the order in which they were taken; runs may be interleaved."""
        _, index = np.unique(run_index, return_inverse=True)
        order = np.argsort(index, kind="stable")
        before = np.full(len(index), -1, dtype=np.int64)
        follows = index[order[1:]] == index[order[:-1]]
        before[order[1:][follows]] = order[:-1][follows]
        starts = (
            np.flatnonzero(np.r_[True, ~follows]) if len(index) else np.zeros(0, dtype=np.int64)
        )
        return cls(index.astype(np.int64), before, len(starts), order, starts)

    def sums(self, columns: Floats) -> Floats:
        """Columns of shape (n, m) added up run by run, shape (runs, m)."""
        return np.add.reduceat(columns[self.order], self.starts, axis=0)

    def select(self, rows: NDArray[np.bool_]) -> Rows:
        """Some of the rows."""
        return Rows.of(self.run_index[rows])


@dataclass(frozen=True, eq=False)
class Noise:
    """One noise. scale: true over stated uncertainty; correlation: rho from a reading to the next
    of its run; offset_arcsec: spread of the runs' zeros; looser: factor on each reading's standard
    deviation, 1 for most.
    """

    scale: float = 1.0
    correlation: float = 0.0
    offset_arcsec: float = 0.0
    looser: Floats | None = None

    @property
    def numbers(self) -> int:
        """How many numbers it has beside its scale."""
        return int(self.correlation != 0) + int(self.offset_arcsec != 0)


@dataclass(frozen=True)
class Whitener:
    """Whitens columns of shape (n,) or (n, m)."""

    rows: Rows
    inverse: Floats = field(repr=False)
    correlation: float
    ones: Floats = field(repr=False)
    shrink: Floats = field(repr=False)
    log_det: float
    """Logarithm of the determinant of the covariance."""

    @classmethod
    def of(cls, noise: Noise, u_arcsec: Floats, rows: Rows) -> Whitener:
        """For readings with the stated uncertainties `u_arcsec`."""
        sd = noise.scale * u_arcsec * (1.0 if noise.looser is None else noise.looser)
        plain = cls(rows, 1 / sd, noise.correlation, np.zeros(0), np.zeros(0), 0.0)
        followers = int(np.count_nonzero(rows.before >= 0))
        log_det = 2 * float(np.log(sd).sum()) + followers * np.log1p(-(noise.correlation**2))
        if noise.offset_arcsec == 0:
            return replace(plain, log_det=float(log_det))
        ones = plain(np.ones(len(u_arcsec)))
        size = np.bincount(rows.run_index, ones**2, rows.runs)
        grown = 1 + noise.offset_arcsec**2 * size
        # v - b (b'v) (1 - 1/sqrt(1 + o^2 |b|^2)) / |b|^2 makes I + o^2 b b' the identity.
        shrink = (1 - 1 / np.sqrt(grown)) / size
        return replace(
            plain, ones=ones, shrink=shrink, log_det=float(log_det + np.log(grown).sum())
        )

    def __call__(self, columns: Floats) -> Floats:
        wide = columns.reshape(len(columns), -1)
        out = wide * self.inverse[:, None]
        if self.correlation:
            follows = self.rows.before >= 0
            past = out[self.rows.before[follows]]
            out[follows] = (out[follows] - self.correlation * past) / np.sqrt(
                1 - self.correlation**2
            )
        if self.ones.size:
            index = self.rows.run_index
            sums = self.rows.sums(out * self.ones[:, None])
            out = out - self.ones[:, None] * (sums * self.shrink[:, None])[index]
        return out.reshape(columns.shape)


@dataclass(frozen=True)
class Margin:
    """Whitened readings with whitened columns X of unknowns, of prior precision (0: none), taken
    out.

    With A = X'X + precision the mode is A^-1 X'y and what is left of |y|^2 is y'y - y'X A^-1 X'y.
    """

    y: Floats
    x: Floats
    factor: Floats
    """Cholesky factor of A, lower."""
    mode: Floats
    chi2: float
    """Misfit and prior together at the mode."""
    log_volume: float
    """-1/2 log det A + 1/2 log det of the precision where there is one."""

    @classmethod
    def of(cls, y: Floats, x: Floats, precision: Floats) -> Margin:
        """y (n,), x (n, p), precision (p,)."""
        a = x.T @ x + np.diag(precision)
        # A column that the table cannot see at all has no curvature; a hair of precision keeps A
        # invertible.
        a[np.diag_indices_from(a)] += 1e-12 * max(float(np.trace(a)), 1e-300) / max(len(a), 1)
        factor = np.linalg.cholesky(a)
        b = x.T @ y
        mode = np.linalg.solve(a, b)
        chi2 = float(y @ y - b @ mode)
        known = precision > 0
        volume = -float(np.log(np.diagonal(factor)).sum())
        volume += 0.5 * float(np.log(precision[known]).sum())
        return cls(y, x, np.asarray(factor), np.asarray(mode), max(chi2, 0.0), volume)

    def left(self, columns: Floats) -> Floats:
        """Whitened columns as seen by whoever refits the unknowns: C^-1 of C = 1 + X P X' on them.

        A whitened column times this is the scalar product that counts.
        """
        return columns - self.x @ np.linalg.solve(
            self.factor.T, np.linalg.solve(self.factor, self.x.T @ columns)
        )


def log_likelihood(chi2: float, whitener: Whitener, margin_volume: float) -> float:
    """Of the readings, up to a constant that all noises and models share."""
    return -0.5 * (chi2 + whitener.log_det) + margin_volume


def log_scale_prior(scale: float, stated_dof: float) -> float:
    """Of the scale, 0 where it is 1."""
    return float(-0.5 * stated_dof * (2 * np.log(scale) + 1 / scale**2 - 1))


def fit_noise(
    y: Floats,
    x: Floats,
    precision: Floats,
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
    u = u_arcsec * (1.0 if start.looser is None else start.looser)
    typical = float(np.median(u_arcsec))
    flat = int(np.count_nonzero(precision == 0))

    def rated(correlation: float, offset: float) -> tuple[float, Noise]:
        scale = start.scale
        for _ in range(2):
            # The runs' zeros scale with the readings' noise while the latter is being found.
            noise = Noise(scale, correlation, offset * scale)
            whitener = Whitener.of(noise, u, rows)
            both = whitener(np.column_stack([y, x]))
            margin = Margin.of(both[:, 0], both[:, 1:], precision)
            # What the priors are pulled by says nothing of the noise.
            scattered = margin.chi2 - float(precision @ margin.mode**2)
            new = _balanced(scale, scattered, len(y) - flat, stated_dof)
            if abs(new / scale - 1) < 1e-3:
                break
            scale = new
        value = log_likelihood(margin.chi2, whitener, margin.log_volume)
        value += log_scale_prior(scale, stated_dof) - PRICE * noise.numbers
        return value, replace(noise, looser=start.looser)

    best = rated(0.0, 0.0)
    # Where the scale may not shrink, correlation would only stand in for a smaller one.
    if structures and rows.runs < len(y) and stated_dof < FIXED_DOF:
        best = max(_searched(best, rated, typical, rows.runs > 2), key=lambda t: t[0])
        best = _refined(best, rated)
    return best[1], best[0]


def _balanced(scale: float, chi2: float, dof: float, stated_dof: float) -> float:
    """The scale at which misfit and what is stated agree; chi2 was found with `scale`.

    Never far below what is stated: readings that agree better than they can are no proof of more.
    """
    least = LEAST_SCALE if stated_dof >= 1 else 1e-9
    return max(float(np.sqrt((chi2 * scale**2 + stated_dof) / (dof + stated_dof))), least)


def _searched(
    white: tuple[float, Noise],
    rated: Callable[[float, float], tuple[float, Noise]],
    typical: float,
    with_offsets: bool,
) -> Iterator[tuple[float, Noise]]:
    """Noises of every structure; the fine grid of one only where the coarse one gains."""
    yield white
    alone = [rated(c, 0.0) for c in _CORRELATIONS]
    if max(alone, key=lambda t: t[0])[0] > white[0]:
        alone += [rated(c, 0.0) for c in _FINE_CORRELATIONS]
    yield from alone
    if not with_offsets:
        return
    offsets = [rated(0.0, o * typical) for o in _OFFSETS]
    if max(offsets, key=lambda t: t[0])[0] > white[0] - PRICE:
        offsets += [rated(0.0, o * typical) for o in _FINE_OFFSETS]
    yield from offsets
    either = max([*alone, *offsets], key=lambda t: t[0])
    if either[0] < white[0]:
        return
    noise = either[1]
    if noise.correlation:
        # Zeros that are not there yet look like a correlation larger than it is.
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
