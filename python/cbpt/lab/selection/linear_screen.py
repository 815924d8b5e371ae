"""The whole library at a glance: every effect as what it would add to the readings if it were
small.

    Signatures  slopes of the readings by the size of every effect, at several shapes
    Screen      what each signature, and each pair, would gain; and what chance alone gains at most

Linear in the sizes, so hundreds of candidates cost one prediction and one matrix product. What
comes out on top is fitted in full afterwards; the chance of the largest gain needs no more than
this.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import cholesky, inverse_diagonal, solved
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled, Point
from cbpt.lab.model.priors import LOT, Variant, log_density, log_size_prior

Floats = NDArray[np.float64]


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
        """Prior of a size in units of the columns; see `library.log_size_prior`."""
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

    def about(
        self, fit: Fit, names: dict[int, tuple[str, str]], secants: bool = True
    ) -> list[Signature]:
        """Slopes at the values of a fit; `names` says which (effect, parameter) its values are.

        secants: also the change up to a finite size, for effects that do not grow in proportion.
        """
        point, wanted, places = self._at(fit, names)
        return list(self._split(point, wanted, places, secants))

    def far(self, fit: Fit, names: dict[int, tuple[str, str]]) -> list[Signature]:
        """The changes up to the sizes that a variant has in `far`."""
        point, _, places = self._at(fit, names)
        return [
            self._secant(point, variant, shapes, own, secant)
            for (variant, shapes), own in zip(self.entries, places, strict=True)
            for secant in variant.far
        ]

    def _at(
        self, fit: Fit, names: dict[int, tuple[str, str]]
    ) -> tuple[Point, list[int], list[list[int]]]:
        """Slopes at the values of a fit, by which parameters, and where those of each entry are."""
        # What was asked before changes no bit of the answer.
        self.model.cold()
        values = self.model.neutral.copy()
        present = set(fit.hypothesis.effects) | self.numbers
        for i, (effect, name) in names.items():
            if effect in present:
                values[self.model.index(self.base.index(effect), name)] = fit.point.values[i]
        wanted: list[int] = []
        places: list[list[int]] = []
        instance = len(self.base)
        for variant, shapes in self.entries:
            owner = self.base.index(LOT) if variant.spread else instance
            instance += not variant.spread
            for name, value in (*variant.fixed, *shapes.items()):
                values[self.model.index(owner, name)] = value
            places.append([self.model.index(owner, size) for size in variant.sizes])
            wanted += [i for i in places[-1] if i not in wanted]
        return self.model.at(values, wanted), wanted, places

    def _split(
        self, point: Point, wanted: list[int], places: list[list[int]], secants: bool
    ) -> Iterator[Signature]:
        at = {place: column for column, place in enumerate(wanted)}
        for (variant, shapes), own in zip(self.entries, places, strict=True):
            unit = variant.low * np.array(variant.ratios or (1.0,) * len(own))
            columns = point.slopes[:, [at[i] for i in own]] * unit
            yield Signature(variant, shapes, columns, unit)
            for secant in variant.secants if secants else ():
                yield self._secant(point, variant, shapes, own, secant)

    def _secant(
        self,
        point: Point,
        variant: Variant,
        shapes: dict[str, float],
        own: list[int],
        secant: tuple[float, ...],
    ) -> Signature:
        values = point.values.copy()
        values[own] += secant
        change = self.model.at(values).angle_arcsec - point.angle_arcsec
        size = float(np.linalg.norm(secant)) / variant.low
        unit = np.array([variant.low])
        return Signature(variant, shapes, change[:, None] / size, unit, secant)


@dataclass(frozen=True, eq=False)
class Gain:
    """What some signatures together would gain: Bayes factor against none of them, and their
    sizes.
    """

    members: tuple[int, ...]
    log_odds: float
    chi2: float
    sizes: Floats


class Screen:
    """Signatures as seen by whoever refits the unknowns of a fit."""

    def __init__(self, fit: Fit, signatures: Sequence[Signature]) -> None:
        self.signatures = list(signatures)
        self.places: list[slice] = []
        at = 0
        for s in self.signatures:
            self.places.append(slice(at, at + s.columns.shape[1]))
            at += s.columns.shape[1]
        columns = np.column_stack([s.columns for s in self.signatures])
        finite = np.isfinite(columns).all(axis=0)
        seen = fit.whitener(np.where(finite, columns, 0.0))
        left = fit.margin.left(seen)
        self.gram = seen.T @ left
        own = np.einsum("ij,ij->j", seen, seen)
        # Seen at all: beyond rounding, and by a standard uncertainty at the largest plausible size.
        span = np.concatenate(
            [
                np.full(
                    s.columns.shape[1], 5.0 if s.variant.spread else s.variant.high / s.variant.low
                )
                for s in self.signatures
            ]
        )
        size = np.diag(self.gram)
        self.alive = (
            finite
            & (size > 1e-12 * np.maximum(own, 1e-300))
            & (np.sqrt(np.maximum(size, 0)) * span > 1)
        )
        self.gram[np.diag_indices_from(self.gram)] += 1e-9 * np.maximum(own, 1e-300)
        self.surviving = np.sqrt(np.clip(np.diag(self.gram) / np.maximum(own, 1e-300), 0, 1))
        self.projection = left.T @ fit.margin.y
        self.dof = len(fit.margin.y)

    def _widths(self, members: Sequence[int]) -> Iterator[tuple[Variant, int]]:
        for m in members:
            yield self.signatures[m].variant, self.signatures[m].columns.shape[1]

    def usable(self, member: int) -> bool:
        """Whether the readings could see it at all."""
        alive = self.alive[self.places[member]]
        return bool(alive.any() if self.signatures[member].variant.spread else alive.all())

    def single(self, member: int, projection: Floats | None = None) -> Gain:
        """One signature alone."""
        return self.gain((member,), projection)

    def gain(self, members: tuple[int, ...], projection: Floats | None = None) -> Gain:
        """Some signatures together; a size that must not be negative and would be is none."""
        b = self.projection if projection is None else projection
        at = np.concatenate([np.arange(self.places[m].start, self.places[m].stop) for m in members])
        g, b = self.gram[np.ix_(at, at)].copy(), b[at]
        # A lot is normal about 0 with a spread of one unit.
        lot = np.concatenate([np.full(w, bool(v.spread)) for v, w in self._widths(members)])
        g[lot, lot] += 1.0
        try:
            factor = cholesky(g)
        except np.linalg.LinAlgError:
            return Gain(members, -np.inf, 0.0, np.zeros(len(at)))
        sizes = solved(factor, b)
        chi2 = float(b @ sizes)
        odds = 0.5 * chi2 - float(np.log(np.diagonal(factor)).sum())
        start = 0
        own = np.sqrt(inverse_diagonal(factor))
        for m in members:
            s = self.signatures[m]
            part = slice(start, start + s.columns.shape[1])
            start = part.stop
            if s.one_sided and sizes[part][0] <= 0:
                return Gain(members, -np.inf, 0.0, sizes)
            odds += s.log_prior(sizes[part], own[part])
        return Gain(members, odds, chi2, sizes)

    def null_of_maximum(self, weights: Floats, replicates: int, rng: np.random.Generator) -> Floats:
        """Largest weighted log odds of any single signature in noise alone, shape (replicates,).

        The projections of noise on the signatures are normal with the Gram matrix for covariance;
        each replicate's own estimate of the scatter divides it, as it does in the readings.
        """
        size, axes = np.linalg.eigh(self.gram)
        root = axes * np.sqrt(np.maximum(size, 0.0))
        draws = root @ rng.standard_normal((len(size), replicates))
        draws /= np.sqrt(rng.chisquare(self.dof, replicates) / self.dof)
        best = np.full(replicates, -np.inf)
        for m, weight in enumerate(weights):
            if np.isfinite(weight) and self.usable(m):
                best = np.maximum(best, weight + self._odds_of(m, draws))
        return best

    def _odds_of(self, member: int, draws: Floats) -> Floats:
        """Log odds of one signature for many projections."""
        place = self.places[member]
        s = self.signatures[member]
        v = s.variant
        g = self.gram[place, place] + (np.eye(s.columns.shape[1]) if v.spread else 0.0)
        inverse = np.linalg.inv(g)
        sizes = inverse @ draws[place]
        chi2 = np.einsum("ij,ij->j", draws[place], sizes)
        odds = 0.5 * chi2 - 0.5 * float(np.linalg.slogdet(g)[1])
        if v.spread:
            return np.asarray(odds)
        own = np.sqrt(np.diag(inverse))
        r = np.linalg.norm(sizes, axis=0)
        odds += log_density(
            v, np.maximum(r, max(float(np.linalg.norm(own)) / np.sqrt(len(own)), 1.0))
        )
        if s.one_sided:
            odds = np.where(sizes[0] > 0, odds, -np.inf)
        return np.asarray(odds)
