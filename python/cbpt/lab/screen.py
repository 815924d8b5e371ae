"""The whole library at a glance: every effect as what it would add to the readings if it were small.

    Signatures  slopes of the readings by the size of every effect, at several shapes, about one fit
    Screen      what each signature, and each pair, would gain; and what chance alone would gain at most

Linear in the sizes, so hundreds of candidates cost one prediction and one matrix product. What comes out
on top is fitted in full afterwards; the chance of the largest gain needs no more than this.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.assembled import Assembled, Campaign
from cbpt.lab.fit import Fit
from cbpt.lab.library import PRIORS, Variant, log_density, log_size_prior

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Signature:
    """One variant at one set of shapes: columns (n, k) in arcsec per unit of size."""

    variant: Variant
    shapes: dict[str, float]
    columns: Floats = field(repr=False)
    unit: Floats = field(repr=False)
    """SI size of one unit of each column."""


class Signatures:
    """Every variant on the grid of its shapes, as a model of its own."""

    def __init__(self, campaign: Campaign, variants: Sequence[Variant]) -> None:
        self.entries: list[tuple[Variant, dict[str, float]]] = []
        for variant in variants:
            grids = product(*(s.grid for s in variant.shapes))
            for grid in grids:
                shapes = {s.name: g for s, g in zip(variant.shapes, grid, strict=True)}
                self.entries.append((variant, shapes))
        self.base = tuple(dict.fromkeys([*PRIORS, *(v.effect for v, _ in self.entries)]))
        self.model = Assembled(campaign, [*self.base, *(v.effect for v, _ in self.entries)])

    def about(self, fit: Fit, names: dict[int, tuple[str, str]]) -> list[Signature]:
        """Slopes at the values of a fit; `names` says which (effect, parameter) its values are."""
        values = self.model.neutral.copy()
        present = set(fit.hypothesis.effects) | set(PRIORS)
        for i, (effect, name) in names.items():
            if effect in present:
                values[self.model.index(self.base.index(effect), name)] = fit.point.values[i]
        wanted: list[int] = []
        for number, (variant, shapes) in enumerate(self.entries):
            instance = len(self.base) + number
            for name, value in (*variant.fixed, *shapes.items()):
                values[self.model.index(instance, name)] = value
            wanted += [self.model.index(instance, size) for size in variant.sizes]
        slopes = self.model.at(values, wanted).slopes
        return list(self._split(slopes))

    def _split(self, slopes: Floats) -> Iterator[Signature]:
        at = 0
        for variant, shapes in self.entries:
            k = len(variant.sizes)
            unit = variant.low * np.array(variant.ratios or (1.0,) * k)
            yield Signature(variant, shapes, slopes[:, at : at + k] * unit, unit)
            at += k


@dataclass(frozen=True, eq=False)
class Gain:
    """What some signatures together would gain: Bayes factor against none of them, and their sizes."""

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
        self.alive = finite & (np.diag(self.gram) > 1e-6 * np.maximum(own, 1e-300))
        self.gram[np.diag_indices_from(self.gram)] += 1e-9 * np.maximum(own, 1e-300)
        self.surviving = np.sqrt(np.clip(np.diag(self.gram) / np.maximum(own, 1e-300), 0, 1))
        self.projection = left.T @ fit.margin.y
        self.dof = len(fit.margin.y)

    def usable(self, member: int) -> bool:
        """Whether the readings could see it at all."""
        return bool(self.alive[self.places[member]].all())

    def single(self, member: int, projection: Floats | None = None) -> Gain:
        """One signature alone."""
        return self.gain((member,), projection)

    def gain(self, members: tuple[int, ...], projection: Floats | None = None) -> Gain:
        """Some signatures together; a size that must not be negative and would be is none."""
        b = self.projection if projection is None else projection
        at = np.concatenate([np.arange(self.places[m].start, self.places[m].stop) for m in members])
        g, b = self.gram[np.ix_(at, at)], b[at]
        try:
            factor = np.linalg.cholesky(g)
        except np.linalg.LinAlgError:
            return Gain(members, -np.inf, 0.0, np.zeros(len(at)))
        half = np.linalg.solve(factor, b)
        sizes = np.linalg.solve(factor.T, half)
        chi2 = float(half @ half)
        odds = 0.5 * chi2 - float(np.log(np.diag(factor)).sum())
        start = 0
        inverse = np.linalg.inv(factor)
        own = np.sqrt(np.sum(inverse**2, axis=0))
        for m in members:
            v = self.signatures[m].variant
            k = len(v.sizes)
            part = slice(start, start + k)
            start += k
            if not v.signed and sizes[part][0] <= 0:
                return Gain(members, -np.inf, 0.0, sizes)
            odds += log_size_prior(v, sizes[part], own[part])
        return Gain(members, odds, chi2, sizes)

    def null_of_maximum(
        self, weights: Floats, replicates: int, rng: np.random.Generator
    ) -> Floats:
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
        v = self.signatures[member].variant
        g = self.gram[place, place]
        inverse = np.linalg.inv(g)
        sizes = inverse @ draws[place]
        chi2 = np.einsum("ij,ij->j", draws[place], sizes)
        odds = 0.5 * chi2 - 0.5 * float(np.linalg.slogdet(g)[1])
        own = np.sqrt(np.diag(inverse))
        r = np.linalg.norm(sizes, axis=0)
        odds += log_density(v, np.maximum(r, max(float(np.linalg.norm(own)) / np.sqrt(len(own)), 1.0)))
        if not v.signed:
            odds = np.where(sizes[0] > 0, odds, -np.inf)
        return np.asarray(odds)
