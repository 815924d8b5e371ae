"""The covariance of the readings, and a linear Gaussian model seen through it.

Rows            which readings follow each other in which run
Held            the error of a mean torque, shared by the readings for which it was held
Noise           scale of the stated uncertainties, correlation, offsets of runs, inflation factors
Linear          readings, columns and the precisions of their unknowns
Whitener        turns readings into independent ones of unit variance
Solved          normal unknowns taken out of readings, from scalar products
Margin          the likelihood of readings with linear unknowns of normal priors integrated out
log_likelihood  of the readings, from misfit and volume

The covariance is  s^2 D A D + o^2 B + R + H + U U',  D the stated uncertainties (times the
inflation factor of a reading that scatters more), A the correlation rho^|i-j| of a first-order
autoregression along each run, B = 1 where two readings share a run, R = r^2 on the diagonal the
rounding of a coarse display and the noise of the torque, H = h h' where two readings share a hold
(`Held`), U the few columns of an artefact (`artefacts`).
Whitening is exact and costs a few passes over the rows: the autoregression is undone by differences
(Cochrane and Orcutt 1949), the offsets of runs by a rank-one step a run, an artefact by one of its
rank. Beside R the autoregression is whitened stretch by stretch, and so is H.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbpt import _core
from cbpt.lab.covariance.artefacts import Artefact

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Rows:
    """The order of n readings: `run_index` of each, and `before`, the one before it in its run or
    -1.

    order sorts the readings by run; starts says where in that order each run begins.
    most_correlation: the largest correlation of a reading with the next that its noise can have.
    """

    run_index: Ints
    before: Ints
    runs: int
    order: Ints
    starts: Ints
    most_correlation: float = 1.0

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

    def columns(self) -> Floats:
        """1 where a reading is of a run, shape (n, runs); for tables that are not long."""
        return np.asarray(self.run_index[:, None] == np.arange(self.runs), dtype=np.float64)

    def thinned(self, most: int) -> NDArray[np.bool_]:
        """Whole runs, evenly spread, as many as fit into so many readings, but twelve at least; of
        long runs, every so many readings. A mask, shape (n,)."""
        sizes = np.bincount(self.run_index, minlength=self.runs)
        wanted = max(1, min(self.runs, int(most / sizes.mean())), min(self.runs, 12))
        chosen = np.unique(np.linspace(0, self.runs - 1, wanted).round().astype(int))
        keep = np.isin(self.run_index, chosen)
        stride = int(np.ceil(np.count_nonzero(keep) / most))
        place = np.empty(len(self.run_index), dtype=np.int64)
        place[self.order] = np.arange(len(place)) - np.repeat(self.starts, sizes)
        return np.asarray(keep & (place % stride == 0))

    def select(self, rows: NDArray[np.bool_]) -> Rows:
        """Some of the rows."""
        return replace(Rows.of(self.run_index[rows]), most_correlation=self.most_correlation)


@dataclass(frozen=True, eq=False)
class Held:
    """The error of a mean torque, shared by the readings for which it was held: known, so that no
    scale applies (errors in variables; Fuller 1987)."""

    sd_arcsec: Floats
    """What it does to each reading, shape (n,); 0 where no torque was held."""
    index: Ints
    """The hold of each reading, shape (n,): those of one follow each other in one run."""

    def select(self, rows: NDArray[np.bool_]) -> Held:
        """That of some of the readings."""
        return Held(self.sd_arcsec[rows], self.index[rows])

    def sized(self, factor: float) -> Held:
        """So many times as large."""
        return Held(self.sd_arcsec * factor, self.index)

    def most_probable(self, residual_arcsec: Floats, weight: Floats) -> Floats:
        """What it most probably does to residuals, arcsec; weight: of each reading, 1/arcsec^2."""
        _, index = np.unique(self.index, return_inverse=True)
        pull = np.bincount(index, weight * self.sd_arcsec * residual_arcsec)
        size = np.bincount(index, weight * self.sd_arcsec**2)
        return np.asarray(self.sd_arcsec * (pull / (1 + size))[index])


@dataclass(frozen=True, eq=False)
class Noise:
    """One noise. scale: true over stated uncertainty; correlation: rho from a reading to the next
    of its run; offset_arcsec: spread of the runs' offsets; inflation: factor on each reading's
    standard deviation, 1 for most.
    """

    scale: float = 1.0
    correlation: float = 0.0
    offset_arcsec: float = 0.0
    inflation: Floats | None = None
    rounding_arcsec: Floats | None = None
    """Standard deviation of each reading by the rounding of a coarse display, beside the rest:
    independent of the readings before it, and known, so that no scale applies."""
    torque_arcsec: Floats | None = None
    """The same by the noise of the torque readings, seen through the slope of the angle: it
    scatters most where the drive is soft (errors in variables; Fuller 1987)."""
    held: Held | None = None
    """The error of the mean torque of each hold."""

    artefact: Artefact | None = None
    """What the instrument does to many readings at once."""

    instrument_arcsec: Floats | None = None
    """What the two of these most probably do to each reading, where one fit tells it for others:
    else another fit, seen through this noise, has its misfit taken for them."""

    @property
    def numbers(self) -> int:
        """How many numbers it has beside its scale."""
        further = self.torque_arcsec is not None, self.has_artefact
        return sum((self.correlation != 0, self.offset_arcsec != 0, *further))

    @property
    def has_artefact(self) -> bool:
        """Whether the instrument does something that the readings had to show."""
        return self.artefact is not None and not self.artefact.is_known

    @property
    def differences(self) -> bool:
        """Whether differences from reading to reading whiten it, before offsets and artefacts."""
        return self.held is None and (self.beside_arcsec is None or not self.correlation)

    @property
    def beside_arcsec(self) -> Floats | None:
        """Standard deviation of each reading that is independent of those before it and that no
        scale applies to; None where there is none."""
        if self.rounding_arcsec is None or self.torque_arcsec is None:
            return self.torque_arcsec if self.rounding_arcsec is None else self.rounding_arcsec
        return np.hypot(self.rounding_arcsec, self.torque_arcsec)

    def sized(self, factor: float) -> Noise:
        """So many times as large, all of it."""
        of_each = self.rounding_arcsec, self.torque_arcsec, self.instrument_arcsec
        rounding, torque, done = (None if a is None else a * factor for a in of_each)
        artefact = None if self.artefact is None else self.artefact.sized(factor)
        held = None if self.held is None else self.held.sized(factor)
        return replace(
            self,
            scale=self.scale * factor,
            offset_arcsec=self.offset_arcsec * factor,
            rounding_arcsec=rounding,
            torque_arcsec=torque,
            held=held,
            artefact=artefact,
            instrument_arcsec=done,
        )

    def select(self, rows: NDArray[np.bool_]) -> Noise:
        """That of some of the readings."""
        of_each = self.inflation, self.rounding_arcsec, self.torque_arcsec, self.instrument_arcsec
        inflation, rounding, torque, done = (None if a is None else a[rows] for a in of_each)
        artefact = None if self.artefact is None else self.artefact.select(rows)
        held = None if self.held is None else self.held.select(rows)
        return replace(
            self,
            inflation=inflation,
            rounding_arcsec=rounding,
            torque_arcsec=torque,
            held=held,
            artefact=artefact,
            instrument_arcsec=done,
        )


class Linear(NamedTuple):
    """The model y = x p + noise, p normal about 0."""

    y: Floats
    """Shape (n,)."""
    x: Floats
    """Columns, shape (n, p)."""
    precision: Floats
    """Of the prior of each unknown, shape (p,); 0 where it is flat."""


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
    filter: _core.NoiseFilter | None = field(default=None, repr=False)
    """Of noise that no differences whiten."""
    shared: tuple[tuple[Floats, Floats], ...] = field(default=(), repr=False)
    """Of what moves many readings at once, seen through the rest: orthonormal axes, shape (n, k),
    and by how much each is shortened, (k,)."""

    @classmethod
    def of(cls, noise: Noise, u_arcsec: Floats, rows: Rows) -> Whitener:
        """For readings with the stated uncertainties `u_arcsec`."""
        sd = noise.scale * u_arcsec * (1.0 if noise.inflation is None else noise.inflation)
        beside = noise.beside_arcsec
        if not noise.differences:
            plain = cls._filtered(noise, sd, rows)
        else:
            if beside is not None:
                sd = np.hypot(sd, beside)
            followers = len(sd) - rows.runs
            log_det = 2 * float(np.log(sd).sum()) + followers * np.log1p(-(noise.correlation**2))
            plain = cls(rows, 1 / sd, noise.correlation, np.zeros(0), np.zeros(0), log_det)
        if noise.offset_arcsec:
            plain = cls._with_offsets(plain, noise, u_arcsec, rows)
        return plain if noise.artefact is None else plain.beside(noise.artefact.columns_arcsec)

    @staticmethod
    def _with_offsets(plain: Whitener, noise: Noise, u_arcsec: Floats, rows: Rows) -> Whitener:
        ones = plain(np.ones(len(u_arcsec)))
        size = np.bincount(rows.run_index, ones**2, rows.runs)
        grown = 1 + noise.offset_arcsec**2 * size
        # v - b (b'v) (1 - 1/sqrt(1 + o^2 |b|^2)) / |b|^2 makes I + o^2 b b' the identity.
        shrink = (1 - 1 / np.sqrt(grown)) / size
        log_det = float(plain.log_det + np.log(grown).sum())
        return replace(plain, ones=ones, shrink=shrink, log_det=log_det)

    def beside(self, columns_arcsec: Floats) -> Whitener:
        """For a covariance that has columns U, shape (n, k), more: U U'."""
        axes, size, _ = np.linalg.svd(self(columns_arcsec), full_matrices=False)
        grown = 1 + size**2
        log_det = float(self.log_det + np.log(grown).sum())
        return replace(self, shared=(*self.shared, (axes, 1 - 1 / np.sqrt(grown))), log_det=log_det)

    @classmethod
    def _filtered(cls, noise: Noise, sd: Floats, rows: Rows) -> Whitener:
        """Of noise that no differences whiten."""
        held = None if noise.held is None else (noise.held.sd_arcsec, noise.held.index)
        numbers = sd, noise.correlation, rows.order, rows.before
        found = _core.NoiseFilter(*numbers, noise.beside_arcsec, held)
        none = np.zeros(0)
        return cls(rows, 1 / sd, noise.correlation, none, none, found.log_det, found)

    @cached_property
    def compiled(self) -> _core.Whitener:
        """Its parts as `crates/cbpt-core/src/covariance/whitener.rs` takes them."""
        offsets = (self.rows.run_index, self.ones, self.shrink) if self.ones.size else None
        return _core.Whitener(
            self.inverse, self.correlation, self.rows.before, offsets, self.shared, self.filter
        )

    def __call__(self, columns: Floats) -> Floats:
        wide = columns.reshape(len(columns), -1)
        return self.compiled.whitened(wide).reshape(columns.shape)


def cholesky(a: Floats) -> Floats:
    """The lower factor of a positive matrix; LinAlgError where it is not.

    LAPACK itself: thousands of systems of a dozen unknowns are solved."""
    from scipy.linalg.lapack import dpotrf

    if not len(a):
        return a
    factor, failed = dpotrf(a, lower=1)
    if failed:
        raise np.linalg.LinAlgError("the matrix is not positive")
    return np.asarray(factor)


def solved(factor: Floats, b: Floats) -> Floats:
    """A^-1 b from the lower factor of A."""
    from scipy.linalg.lapack import dpotrs

    return np.asarray(dpotrs(factor, b, lower=1)[0]) if len(factor) else b


def inverse(factor: Floats) -> Floats:
    """A^-1 from the lower factor of A."""
    lower = _lower_of_inverse(factor)
    return np.asarray(lower + np.tril(lower, -1).T)


def inverse_diagonal(factor: Floats) -> Floats:
    """The diagonal of A^-1 from the lower factor of A."""
    return np.diagonal(_lower_of_inverse(factor))


def _lower_of_inverse(factor: Floats) -> Floats:
    """The lower triangle of A^-1, with zeros above it."""
    from scipy.linalg.lapack import dpotri

    return np.asarray(dpotri(factor, lower=1)[0]) if len(factor) else factor


class Solved(NamedTuple):
    """Normal unknowns taken out of readings, from scalar products alone.

    Compiled: `crates/cbpt-core/src/covariance/solved.rs`.
    """

    factor: Floats
    """Cholesky factor of A, lower."""
    mode: Floats
    chi2: float
    """Misfit and prior together at the mode."""
    log_volume: float
    """-1/2 log det A + 1/2 log det of the precision where there is one."""

    @classmethod
    def of(cls, gram: Floats, projection: Floats, square: float, precision: Floats) -> Solved:
        """gram: X'X (p, p); projection: X'y (p,); square: y'y; precision (p,), 0 for none."""
        factor, mode, chi2, log_volume = _core.take_out(gram, projection, square, precision)
        return cls(factor.T, mode, chi2, log_volume)


@dataclass(frozen=True)
class Margin:
    """Whitened readings with whitened columns X of unknowns, of prior precision (0: none), taken
    out; see `Solved`."""

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
        return cls(y, x, *Solved.of(x.T @ x, x.T @ y, float(y @ y), precision))

    def left(self, columns: Floats) -> Floats:
        """Whitened columns as seen by whoever refits the unknowns: C^-1 of C = 1 + X P X' on them.

        A whitened column times this is the scalar product that counts.
        """
        return columns - self.x @ solved(self.factor, self.x.T @ columns)


def log_likelihood(chi2: float, whitener: Whitener, margin_volume: float) -> float:
    """Of the readings, up to a constant that all noises and models share."""
    return -0.5 * (chi2 + whitener.log_det) + margin_volume
