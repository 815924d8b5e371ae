"""The whole library at a glance: every effect as what it would add to the readings if it were
small.

    Signatures  slopes of the readings by the size of every effect, at several shapes
    Stack       signatures side by side
    Screen      what sets of signatures would gain; and what chance alone gains at most

Linear in the sizes, so hundreds of candidates cost one prediction and one matrix product. What
comes out on top is fitted in full afterwards; the chance of the largest gain needs no more than
this.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.symmetric import eigen
from cbpt.lab.inference.crew import both
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled, Point
from cbpt.lab.model.priors import LOT, Variant, log_density_of_one, log_size_prior

_EVEN, _ODD = slice(0, None, 2), slice(1, None, 2)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Signature:
    """One variant at one set of shapes: columns (n, k) in arcsec per unit of size."""

    variant: Variant
    shapes: dict[str, float]
    columns: Floats = field(repr=False)
    unit: Floats = field(repr=False)
    """SI size of one unit of each column."""
    secant: tuple[float, ...] = ()
    """Where the column is not a slope but the whole change up to these sizes, per unit of their
    norm.
    """

    @property
    def one_sided(self) -> bool:
        """Whether a negative size is none."""
        return bool(self.secant) or not self.variant.signed

    def sizes(self, found: Floats) -> Floats:
        """SI sizes, off neutral, of what the screen found in units of the columns."""
        return (
            found[0] * self.unit[0] * _direction(self.secant) if self.secant else found * self.unit
        )

    def found(self, sizes: Floats) -> Floats:
        """The inverse of `sizes`."""
        along = np.array([sizes @ _direction(self.secant)]) if self.secant else sizes
        return np.asarray(along / self.unit[: len(along)])

    def log_prior(self, size: Floats, own: Floats) -> float:
        """Prior of a size in units of the columns; see `priors.log_size_prior`."""
        return log_size_prior(self.variant, size, own) if not self.variant.spread else 0.0


def _direction(secant: tuple[float, ...]) -> Floats:
    return np.asarray(np.array(secant) / np.linalg.norm(secant))


class Signatures:
    """Every variant on the grid of its shapes, as a model of its own."""

    def __init__(self, campaign: Campaign, variants: Sequence[Variant]) -> None:
        self.entries: list[tuple[Variant, dict[str, float]]] = []
        for variant in variants:
            grids = product(*(s.grid for s in variant.shapes))
            for grid in grids:
                shapes = {s.name: g for s, g in zip(variant.shapes, grid, strict=True)}
                self.entries.append((variant, shapes))
        once = [v.effect for v, _ in self.entries if not v.spread]
        own = [*campaign.priors, *campaign.own, *once]
        self.base = (*dict.fromkeys(own), *(LOT,) * campaign.balls)
        self.model = Assembled(campaign, [*self.base, *once])
        self.numbers = set(campaign.priors)
        self._campaign, self._beside = campaign, self.model.beside()
        self._bare = self.model.neutral.copy()
        """Values with the shapes of every entry."""
        self._places: list[list[int]] = []
        """Where the sizes of each entry are."""
        instance = len(self.base)
        for variant, shapes in self.entries:
            owner = self.base.index(LOT) if variant.spread else instance
            instance += not variant.spread
            for name, value in (*variant.fixed, *shapes.items()):
                self._bare[self.model.index(owner, name)] = value
            self._places.append([self.model.index(owner, size) for size in variant.sizes])

    def about(
        self, fit: Fit, names: dict[int, tuple[str, str]], secants: bool = True
    ) -> list[Signature]:
        """Slopes at the values of a fit; `names` says which (effect, parameter) its values are.

        secants: also the change up to a finite size, for effects that do not grow in proportion.
        """
        values = self._values(fit, names)
        even, odd = both(
            self._campaign,
            partial(self._about, self.model, values, _EVEN, secants),
            partial(self._about, self._beside, values, _ODD, secants),
        )
        found = [*even, *odd]
        found[_EVEN], found[_ODD] = even, odd
        return [signature for of_entry in found for signature in of_entry]

    def _about(
        self, model: Assembled, values: Floats, some: slice, secants: bool
    ) -> list[list[Signature]]:
        """Of some entries, at the values of all."""
        # What was asked before changes no bit of the answer.
        model.cold()
        places = self._places[some]
        wanted = list(dict.fromkeys(i for own in places for i in own))
        point = model.at(values, wanted)
        column = {place: number for number, place in enumerate(wanted)}
        found: list[list[Signature]] = []
        for (variant, shapes), own in zip(self.entries[some], places, strict=True):
            unit = variant.low * np.array(variant.ratios or (1.0,) * len(own))
            slopes = point.slopes[:, [column[i] for i in own]]
            found.append([Signature(variant, shapes, slopes * unit, unit)])
            for secant in variant.secants if secants else ():
                found[-1].append(_secant(model, point, variant, shapes, own, secant))
        return found

    def far(self, fit: Fit, names: dict[int, tuple[str, str]]) -> list[Signature]:
        """The changes up to the sizes that a variant has in `far`."""
        values = self._values(fit, names)
        model = self.model.beside()
        model.cold()
        point = model.at(values)
        return [
            _secant(model, point, variant, shapes, own, secant)
            for (variant, shapes), own in zip(self.entries, self._places, strict=True)
            for secant in variant.far
        ]

    def _values(self, fit: Fit, names: dict[int, tuple[str, str]]) -> Floats:
        """Those that the model is asked at first: a fit's, and the shapes of every entry."""
        values = self._bare.copy()
        present = set(fit.hypothesis.effects) | self.numbers
        for i, (effect, name) in names.items():
            if effect in present:
                values[self.model.index(self.base.index(effect), name)] = fit.point.values[i]
        return values


def _secant(
    model: Assembled,
    point: Point,
    variant: Variant,
    shapes: dict[str, float],
    own: list[int],
    secant: tuple[float, ...],
) -> Signature:
    values = point.values.copy()
    values[own] += secant
    change = model.at(values).angle_arcsec - point.angle_arcsec
    size = float(np.linalg.norm(secant)) / variant.low
    unit = np.array([variant.low])
    return Signature(variant, shapes, change[:, None] / size, unit, secant)


class Stack:
    """Signatures side by side, and what of them is the same through every noise.

    Arrays have a value for each signature, or for each column where they say so.
    """

    def __init__(self, signatures: Sequence[Signature]) -> None:
        self.signatures = list(signatures)
        variants = [s.variant for s in self.signatures]
        self.width = np.array([s.columns.shape[1] for s in self.signatures])
        self.first = np.cumsum(self.width) - self.width
        """Its first column."""
        self.places = [slice(a, a + w) for a, w in zip(self.first, self.width, strict=True)]
        """Its columns."""
        columns = np.column_stack([s.columns for s in self.signatures])
        self.finite = np.isfinite(columns).all(axis=0)
        """Of each column."""
        self.columns = np.asfortranarray(np.where(self.finite, columns, 0.0))
        """Shape (n, columns), 0 where one is not finite; column by column in memory, as whitening
        takes them."""
        self.narrow = np.array([not v.spread for v in variants])
        """Whether it is no lot of balls."""
        high = [5.0 if v.spread else v.high / v.low for v in variants]
        self.high = np.repeat(high, self.width)
        """Largest plausible size of each column."""
        self.precision = np.repeat(np.where(self.narrow, 0.0, 1.0), self.width)
        """Of each column: a lot is normal about 0 with a spread of one unit."""
        self.one_sided = np.array([s.one_sided for s in self.signatures])
        self.density = np.array([0.0 if v.spread else log_density_of_one(v) for v in variants])
        self.powers = np.array([0 if v.spread else len(v.sizes) for v in variants])
        """The log density of a size r is `density` less so many ln r."""
        self.kind = np.unique([v.effect for v in variants], return_inverse=True)[1]
        """Signatures of one effect have the same."""
        self.form = np.unique([v.label for v in variants], return_inverse=True)[1]
        """The same of one variant."""

    def by_width(self, wanted: NDArray[np.bool_]) -> list[Ints]:
        """Some of the signatures, those with equally many columns together."""
        widths = np.unique(self.width[wanted])
        return [np.flatnonzero(wanted & (self.width == width)) for width in widths]

    def padded(self, members: Ints) -> tuple[Ints, NDArray[np.bool_], list[slice]]:
        """Columns of sets (n, m), each signature with as many as the widest that stands in its
        place: columns, (k, n), which of them are no padding, and the part of k of each place."""
        at, real, parts, start = [], [], [], 0
        for m in members.T:
            step = np.arange(self.width[m].max(initial=1))[:, None]
            real.append(step < self.width[m])
            at.append(self.first[m] + np.where(real[-1], step, 0))
            parts.append(slice(start, start + len(step)))
            start += len(step)
        return np.concatenate(at), np.concatenate(real), parts

    def log_prior(self, members: Ints, sizes: Floats, variances: Floats) -> Floats:
        """Of sizes and their variances (k, ..., n) of n signatures, shape (..., n); minus infinity
        where one is negative that must not be. See `priors.log_size_prior`."""
        own = variances.sum(axis=0) / self.width[members]
        square = np.maximum(np.maximum(np.square(sizes).sum(axis=0), own), 1.0)
        value = self.density[members] - 0.5 * self.powers[members] * np.log(square)
        return np.where(self.one_sided[members] & (sizes[0] <= 0), -np.inf, value)


@dataclass(frozen=True, eq=False)
class Gain:
    """What some signatures together would gain: Bayes factor against none of them, and their
    sizes.
    """

    members: tuple[int, ...]
    log_odds: float
    chi2: float
    sizes: Floats


class Gains(NamedTuple):
    """The same of n sets, each padded to k columns."""

    chi2: Floats
    """Shape (n,); 0 where a size is negative that must not be."""
    log_volume: Floats
    """Shape (n,)."""
    log_prior: Floats
    """Shape (n,); minus infinity where a size is negative that must not be."""
    sizes: Floats
    """Shape (k, n), 0 in the padding."""
    inverse: Floats
    """Of the Gram matrix, shape (k, k, n)."""
    columns: Ints
    """Shape (k, n)."""
    real: NDArray[np.bool_]
    """Whether a column is no padding, shape (k, n)."""

    def some(self, sets: slice) -> Gains:
        """Those of some of the sets."""
        return Gains(
            self.chi2[sets],
            self.log_volume[sets],
            self.log_prior[sets],
            self.sizes[:, sets],
            self.inverse[:, :, sets],
            self.columns[:, sets],
            self.real[:, sets],
        )


class Screen:
    """Signatures as seen by whoever refits the unknowns of a fit."""

    def __init__(self, fit: Fit, stack: Stack) -> None:
        self.stack, self.signatures, self.places = stack, stack.signatures, stack.places
        margin, seen = fit.margin, fit.whitener(stack.columns)
        refitted = np.linalg.solve(margin.factor, margin.x.T @ seen)
        # Both products are of a matrix with itself, which take half the time.
        self.gram = seen.T @ seen - refitted.T @ refitted
        own = np.maximum(np.einsum("ij,ij->j", seen, seen), 1e-300)
        # Seen at all: beyond rounding, and by a standard uncertainty at the largest plausible size.
        size = np.diagonal(self.gram)
        own_way = stack.finite & (size > 1e-12 * own)
        self.shown = self._of_all(own_way)
        """Of each signature: whether the readings depend on it otherwise than on the unknowns."""
        self.usable = self._of_all(own_way & (np.sqrt(np.maximum(size, 0)) * stack.high > 1))
        """Of each signature: whether its largest size would stand out from the scatter."""
        self.gram[np.diag_indices_from(self.gram)] += 1e-9 * own
        self.surviving = np.sqrt(np.clip(np.diagonal(self.gram) / own, 0, 1))
        """Of each column: the share of it that a refit of the unknowns leaves."""
        self.projection = seen.T @ margin.left(margin.y)
        self.dof = len(margin.y)

    def _of_all(self, columns: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Of each signature: whether it has all of its columns, or one of a lot."""
        count = np.add.reduceat(columns.astype(np.int64), self.stack.first)
        return np.where(self.stack.narrow, count == self.stack.width, count > 0)

    def single(self, member: int, projection: Floats | None = None) -> Gain:
        """One signature alone."""
        return self.gain((member,), projection)

    def gain(self, members: tuple[int, ...], projection: Floats | None = None) -> Gain:
        """Some signatures together; a size that must not be negative and would be is none."""
        return self.each(np.array([members]), projection)[0]

    def each(self, members: Ints, projection: Floats | None = None) -> list[Gain]:
        """The same of sets of equally many signatures each, shape (n, m)."""
        found = self.gains(members, projection)
        odds = 0.5 * found.chi2 + found.log_volume + found.log_prior
        return [
            Gain(tuple(m), float(o), float(chi2), sizes[real])
            for m, o, chi2, sizes, real in zip(
                members.tolist(), odds, found.chi2, found.sizes.T, found.real.T, strict=True
            )
        ]

    def gains(self, members: Ints, projection: Floats | None = None) -> Gains:
        """Sets of equally many signatures each, shape (n, m)."""
        b = self.projection if projection is None else projection
        at, real, parts = self.stack.padded(members)
        k = len(at)
        system = np.zeros((k + 1, k + 1, len(members)))
        system[:k, :k] = self.gram[at[:, None], at] * (real[:, None] & real)
        system[range(k), range(k)] += np.where(real, self.stack.precision[at], 1.0)
        system[:k, k] = system[k, :k] = b[at] * real
        pivots = _swept(system, k)
        inverse, sizes = -system[:k, :k], system[:k, k]
        variances = np.einsum("iij->ij", inverse) * real
        log_prior = np.zeros(len(members))
        for part, m in zip(parts, members.T, strict=True):
            log_prior += self.stack.log_prior(m, sizes[part], variances[part])
        log_prior[~(pivots > 0).all(axis=0)] = -np.inf
        chi2 = np.where(log_prior > -np.inf, -system[k, k], 0.0)
        volume = -0.5 * np.log(np.maximum(pivots, 1e-300)).sum(axis=0)
        return Gains(chi2, volume, log_prior, sizes, inverse, at, real)

    def null_of_maximum(self, weights: Floats, replicates: int, rng: np.random.Generator) -> Floats:
        """Largest weighted log odds of any single signature in noise alone, shape (replicates,).

        The projections of noise on the signatures are normal with the Gram matrix for covariance;
        each replicate's own estimate of the scatter divides it, as it does in the readings.
        """
        size, axes = eigen(self.gram)
        root = axes * np.sqrt(np.maximum(size, 0.0))
        draws = root @ rng.standard_normal((len(size), replicates))
        draws /= np.sqrt(rng.chisquare(self.dof, replicates) / self.dof)
        best = np.full(replicates, -np.inf)
        for members in self.stack.by_width(self.usable & np.isfinite(weights)):
            odds = self._odds_of(members, draws) + weights[members]
            best = np.maximum(best, odds.max(axis=1))
        return best

    def _odds_of(self, members: Ints, draws: Floats) -> Floats:
        """Log odds of signatures of one width, each alone, for many projections, shape (replicates,
        members)."""
        alone = self.gains(members[:, None])
        seen = draws[alone.columns]
        sizes = np.einsum("ijm,jmr->irm", alone.inverse, seen)
        chi2 = np.einsum("imr,irm->rm", seen, sizes)
        variances = np.einsum("iim->im", alone.inverse)[:, None]
        prior = self.stack.log_prior(members, sizes, variances)
        return np.asarray(0.5 * chi2 + alone.log_volume + prior)


def _swept(systems: Floats, count: int) -> Floats:
    """Sweep the first rows of many symmetric matrices (k, k, n) in place (Goodnight 1979); the
    pivots, shape (count, n), are positive where the matrix of these rows is.

    Of [G, y; y', 0] swept by the rows of G what is left is [-G^-1, G^-1 y; (G^-1 y)', -y'G^-1 y].
    One pass over all matrices for each row: LAPACK asked for each costs more than the arithmetic.
    """
    pivots = np.empty((count, systems.shape[2]))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for row in range(count):
            pivots[row] = systems[row, row]
            column = systems[:, row].copy()
            share = column / pivots[row]
            systems -= column[:, None] * share
            systems[row] = systems[:, row] = share
            systems[row, row] = -1.0 / pivots[row]
    return pivots
