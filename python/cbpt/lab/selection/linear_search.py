"""All small sets of effects at once: linear in their sizes, the noise profiled.

Offer          a set of effects with the score that a view gives it, and where a full fit starts
View           the library about one fit, seen through one noise
views          one view for each noise that the readings may have
single_offers  every variant of every effect
variant_prices what the best variant of an effect exceeds their mean by
set_offers     pairs, and triples
leaders        the first sets without a lot of balls, and the first with one
additions_to   one effect more than those of a fit

A set of signatures is a linear problem; its marginal likelihood follows from the Gram matrix of a
view, with the scale of the noise at its most probable value for each set. Effects that a smaller
set does not show are found so, because no set is built on another one: all singles and all pairs
are weighed, and all triples: every pair of effects in its best forms with every third effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import least_scale, log_scale_prior
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.selection.linear_screen import Screen, Signature
from cbpt.lab.selection.setting import Names, Setting

Floats = NDArray[np.float64]
SomeSet = TypeVar("SomeSet")
ScoredSet = tuple[float, tuple[int, ...]]
"""Score and places of some signatures."""


@dataclass(frozen=True, eq=False)
class Offer:
    """A set of effects as a view sees it."""

    score: float
    """Log of evidence times prior odds, as the view sees it."""
    signatures: tuple[Signature, ...]
    """What is added to `base`."""
    sizes: Floats
    seen: Fit
    """The fit that the view is about, through its noise."""
    base: Fit | None = None
    """The fit that is added to; None for the drive as stated."""

    @property
    def noise(self) -> Noise:
        """That of the view."""
        return self.seen.noise

    @property
    def names(self) -> Names:
        """The effects, sorted."""
        before = self.base.hypothesis.effects if self.base else ()
        return tuple(sorted([*before, *(s.variant.effect for s in self.signatures)]))

    @property
    def has_lot(self) -> bool:
        """Whether a lot of balls is added."""
        return any(s.variant.spread for s in self.signatures)


class View:
    """The library about one fit, seen through one noise."""

    def __init__(self, setting: Setting, seen: Fit, signatures: Sequence[Signature]) -> None:
        self.signatures, self.seen = signatures, seen
        self.screen = Screen(seen, signatures)
        fitter = setting.fitter
        self._stated_dof = fitter.stated_dof
        offsets = fitter.campaign.offsets.shape[1]
        self._dof = float(len(fitter.campaign) - offsets)
        self._level = setting.score(seen)
        self.weight = np.array([setting.weight(s.variant) for s in signatures])
        self.usable = np.array([self.screen.usable(m) for m in range(len(signatures))], dtype=bool)
        self.narrow = np.array([not s.variant.spread for s in signatures], dtype=bool)
        effects = [s.variant.effect for s in signatures]
        self._kind = np.unique(effects, return_inverse=True)[1]
        """Which effect each signature is of."""
        self._width = np.array([s.columns.shape[1] for s in signatures])
        self._first = np.array([place.start for place in self.screen.places])
        self._one_sided = np.array([s.one_sided for s in signatures], dtype=bool)
        powers = np.array([len(s.variant.sizes) for s in signatures])
        signed = np.array([s.variant.signed for s in signatures])
        span = np.array([np.log(s.variant.high / s.variant.low or 1.0) for s in signatures])
        around = np.where(powers == 1, np.where(signed, 2.0, 1.0), 2 * np.pi)
        # ln of the density of a size r: constant less as many ln r as there are components.
        with np.errstate(divide="ignore", invalid="ignore"):
            self._density = 0.5 * powers * np.log(2 * np.pi) - np.log(span * around)
        self._powers = powers

    def score(self, gained: Floats, sizes: Floats | int) -> Floats:
        """Score of sets that take so much off the misfit with so many sizes, without the volume and
        the prior of the sizes; the scale of the noise is the most probable one of each."""
        scale, chi2 = self.seen.noise.scale, self.seen.margin.chi2
        dof = self._dof - sizes
        left = np.maximum(chi2 - gained, 1e-9)
        square = (left + self._stated_dof / scale**2) / (np.maximum(dof, 1.0) + self._stated_dof)
        least = least_scale(self._stated_dof) / scale
        factor = np.maximum(np.sqrt(square), least)
        prior = log_scale_prior(scale * factor, self._stated_dof)
        prior = prior - log_scale_prior(np.array(scale), self._stated_dof)
        likelihood = 0.5 * chi2 - 0.5 * left / factor**2 - dof * np.log(factor)
        return np.asarray(self._level + likelihood + prior)

    def names(self, members: Iterable[int]) -> Names:
        """The effects of some signatures, sorted."""
        return tuple(sorted(self.signatures[m].variant.effect for m in members))

    def has_lot(self, members: Iterable[int]) -> bool:
        """Whether some signatures have a lot of balls among them."""
        return any(not self.narrow[m] for m in members)

    def offer(self, members: tuple[int, ...], base: Fit | None = None) -> Offer:
        """One set, exactly."""
        gain = self.screen.gain(members)
        rest = gain.log_odds - 0.5 * gain.chi2
        count = int(self._width[list(members)].sum())
        score = float(self.score(np.array(gain.chi2), count)) + rest
        score += float(self.weight[list(members)].sum())
        chosen = tuple(self.signatures[m] for m in members)
        return Offer(score, chosen, gain.sizes, self.seen, base)

    def singles(self) -> Floats:
        """Scores of all signatures; minus infinity where one cannot be seen."""
        score = np.full(len(self.signatures), -np.inf)
        at = np.flatnonzero(self.usable & self.narrow)
        nothing = np.zeros((0, len(self.screen.gram)))
        score[at] = self._one_more(at, nothing, np.zeros(0), 0)
        for m in np.flatnonzero(self.usable & ~self.narrow).tolist():
            score[m] = self.offer((m,)).score
        return score

    def pairs(self, members: Sequence[int]) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
        """Scores of all pairs of narrow signatures of two effects, and their places.

        All at once: every signature is padded to two columns, every pair is a 4 x 4 system.
        """
        at = np.array([m for m in members if self.narrow[m] and self.usable[m]], dtype=np.int64)
        kinds = self._kind[at]
        one, two = np.triu_indices(len(at), 1)
        other = kinds[one] != kinds[two]
        a, b = at[one[other]], at[two[other]]
        if not len(a):
            return np.zeros(0), a, b
        at, real, scaled, length = self._systems(np.column_stack([a, b]))
        y = np.where(real, self.screen.projection[at], 0.0)
        inverse = np.linalg.inv(scaled)
        sizes = np.einsum("ijk,ik->ij", inverse, y / length)
        gained = np.einsum("ij,ij->i", y / length, sizes)
        sizes = sizes / length
        own = np.where(real, np.sqrt(np.einsum("ijj->ij", inverse)) / length, 0.0)
        volume = -0.5 * np.linalg.slogdet(scaled)[1] - np.log(length).sum(axis=1)
        score = self.score(gained, self._width[a] + self._width[b]) + volume
        for part, m in ((slice(0, 2), a), (slice(2, 4), b)):
            r = np.linalg.norm(sizes[:, part], axis=1)
            seen = np.linalg.norm(own[:, part], axis=1) / np.sqrt(self._width[m])
            r = np.maximum(np.maximum(r, seen), 1.0)
            score = score + self._density[m] - self._powers[m] * np.log(r) + self.weight[m]
            score[self._one_sided[m] & (sizes[:, part.start] <= 0)] = -np.inf
        return score, a, b

    def additions(self, sets: Sequence[ScoredSet]) -> Floats:
        """Roughly the scores of sets of equally many signatures with one more narrow signature of
        another effect, (sets, signatures); minus infinity where that cannot be seen.

        Roughly: the prior of the sizes and the volume of a set are those that it has alone.
        """
        members = np.array([members for _, members in sets], dtype=np.int64)
        at, real, scaled, length = self._systems(members)
        unit = np.where(real, 1.0 / length, 0.0)
        both = np.concatenate([self.screen.gram, self.screen.projection[:, None]], axis=1)
        seen = np.linalg.solve(np.linalg.cholesky(scaled), both[at] * unit[:, :, None])
        left = np.flatnonzero(self.usable & self.narrow)
        score = np.full((len(members), len(self.signatures)), -np.inf)
        count = self._width[members].sum(axis=1)
        found = self._one_more(left, seen[:, :, :-1], seen[:, :, -1], count)
        alone = np.array([score for score, _ in sets])
        gained = np.einsum("ij,ij->i", seen[:, :, -1], seen[:, :, -1])
        found += (alone - self.score(gained, count))[:, None]
        have = (self._kind[members][:, :, None] == self._kind[left]).any(axis=1)
        score[:, left] = np.where(have, -np.inf, found)
        return score

    def best_additions(
        self, sets: Sequence[ScoredSet], count: int | None = None
    ) -> list[ScoredSet]:
        """Sets of equally many signatures with one more of the first `count`, each set of effects
        in its best forms, the best first."""
        if not sets:
            return []
        score = self.additions(sets)[:, :count]
        which, more = np.indices(score.shape).reshape(2, -1)
        members = np.array([members for _, members in sets], dtype=np.int64)
        return self.best_forms(score.reshape(-1), np.column_stack([members[which], more]))

    def best_forms(self, score: Floats, members: NDArray[np.int64]) -> list[ScoredSet]:
        """Of sets (n, k) with the same effects the best one; the best of all first."""
        seen = np.flatnonzero(np.isfinite(score))
        order = seen[np.argsort(-score[seen], kind="stable")]
        effects = np.sort(self._kind[members[order]], axis=1)
        code = effects @ (len(self._kind) ** np.arange(effects.shape[1]))
        first = np.sort(np.unique(code, return_index=True)[1])
        return [(float(score[i]), tuple(members[i].tolist())) for i in order[first].tolist()]

    def _systems(
        self, members: NDArray[np.int64]
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_], Floats, Floats]:
        """Gram matrices of sets (n, m), every signature padded to two columns or as many as another
        in its place has: columns (n, k), which are no padding, matrices scaled by the lengths, and
        these."""
        at, real, lot = [], [], []
        for m in members.T:
            step = np.arange(max(2, int(self._width[m].max())))
            real.append(step < self._width[m][:, None])
            at.append(self._first[m][:, None] + np.where(real[-1], step, 0))
            lot.append(real[-1] & ~self.narrow[m][:, None])
        columns, known, of_lot = (np.concatenate(parts, axis=1) for parts in (at, real, lot))
        g = self.screen.gram[columns[:, :, None], columns[:, None, :]]
        g = np.where(known[:, :, None] & known[:, None, :], g, 0.0)
        identity = np.eye(columns.shape[1])
        g = g + np.where(known, np.where(of_lot, 1.0, 0.0), 1.0)[:, :, None] * identity
        length = np.sqrt(np.einsum("ijj->ij", g))
        scaled = g / (length[:, :, None] * length[:, None, :]) + 1e-9 * identity
        return columns, known, scaled, length

    def _one_more(
        self, left: NDArray[np.int64], cross: Floats, pull: Floats, count: NDArray[np.int64] | int
    ) -> Floats:
        """Scores of one narrow signature each beside sets of so many columns, (..., signatures);
        cross, pull: the Gram matrix (..., k, columns) and the projection (..., k) as seen along the
        axes of each set."""
        screen = self.screen
        first, last = self._first[left], self._first[left] + self._width[left] - 1
        one, two = cross[..., first], cross[..., last]
        b1 = screen.projection[first] - np.einsum("...k,...kj->...j", pull, one)
        b2 = screen.projection[last] - np.einsum("...k,...kj->...j", pull, two)
        g11 = screen.gram[first, first] - np.einsum("...kj,...kj->...j", one, one)
        g22 = screen.gram[last, last] - np.einsum("...kj,...kj->...j", two, two)
        g12 = screen.gram[first, last] - np.einsum("...kj,...kj->...j", one, two)
        lone = self._width[left] == 1
        g12, g22, b2 = np.where(lone, 0.0, g12), np.where(lone, 1.0, g22), np.where(lone, 0.0, b2)
        determinant = np.maximum(g11 * g22 - g12**2, 1e-9 * np.abs(g11 * g22) + 1e-300)
        size1 = (b1 * g22 - b2 * g12) / determinant
        size2 = np.where(lone, 0.0, (b2 * g11 - b1 * g12) / determinant)
        gained = b1 * size1 + b2 * size2
        before = np.einsum("...k,...k->...", pull, pull)[..., None]
        score = self.score(gained + before, np.asarray(count)[..., None] + self._width[left])
        score = score - 0.5 * np.log(determinant)
        own = (g22 + np.where(lone, 0.0, g11)) / determinant / self._width[left]
        size = np.sqrt(np.maximum(np.maximum(size1**2 + size2**2, own), 1.0))
        score = score + self._density[left] - self._powers[left] * np.log(size)
        return np.where(self._one_sided[left] & (size1 <= 0), -np.inf, score + self.weight[left])


@dataclass(frozen=True)
class _Limits:
    """What is weighed."""

    correlations: tuple[float, ...] = (0.0, 0.35, 0.7)
    offsets: tuple[float, ...] = (0.0, 1.0, 4.0)
    """Spread of the offsets of runs, in typical uncertainties of a reading."""
    pairs_with_lots: int = 3
    """Lots of balls, the most probable ones, that are weighed in pairs."""
    noise_room: float = 12.0
    """Log odds below the best pair at which a noise is no longer tried."""
    exact: int = 12
    """Sets of each size that are weighed again without a shortcut."""


_LIMITS = _Limits()


def views(setting: Setting) -> list[View]:
    """The library about the drive as stated, under every noise that the readings may have."""
    fitter = setting.fitter
    return [
        View(setting, fitter.look(setting.null, noise), setting.wider) for noise in _noises(setting)
    ]


def _noises(setting: Setting) -> list[Noise]:
    """Those of the drive as stated, which may have taken an effect for noise, and of fits which may
    follow the whole library, and a grid."""
    c, rows = setting.fitter.campaign, setting.fitter.campaign.rows
    flexible = setting.flexible
    typical = float(np.median(c.u_arcsec)) * flexible.scale
    correlations = _LIMITS.correlations if rows.runs < len(c) else (0.0,)
    correlations = tuple(dict.fromkeys(min(r, rows.most_correlation) for r in correlations))
    offsets = _LIMITS.offsets if 1 < rows.runs < len(c) else (0.0,)
    return list(setting.noises) + [
        replace(flexible, correlation=correlation, offset_arcsec=offset * typical)
        for correlation in correlations
        for offset in offsets
    ]


def best_of_each(offers: Iterable[Offer]) -> list[Offer]:
    """The best offer of every set of effects, the best first."""
    best: dict[Names, Offer] = {}
    for offer in offers:
        if not np.isfinite(offer.score):
            continue
        if offer.names not in best or offer.score > best[offer.names].score + 1e-6:
            best[offer.names] = offer
    return sorted(best.values(), key=lambda o: -round(o.score, 6))


def single_offers(seen: Sequence[View]) -> list[Offer]:
    """The best offer of every variant of every effect, the best first."""
    found: dict[str, tuple[float, View, int]] = {}
    for view in seen:
        score = view.singles()
        for m in np.flatnonzero(np.isfinite(score)).tolist():
            label = view.signatures[m].variant.label
            if label not in found or score[m] > found[label][0] + 1e-6:
                found[label] = float(score[m]), view, m
    offers = [view.offer((m,)) for _, view, m in found.values()]
    return sorted((o for o in offers if np.isfinite(o.score)), key=lambda o: -round(o.score, 6))


def variant_prices(setting: Setting, singles: Sequence[Offer]) -> dict[str, float]:
    """The evidence of an effect is the mean over its variants, of which the best is shown."""
    found: dict[str, list[float]] = {}
    for offer in singles:
        found.setdefault(offer.names[0], []).append(offer.score)
    return {
        effect: float(np.log(setting.variants[effect]) - np.log(np.exp(scores - max(scores)).sum()))
        for effect, scores in ((e, np.array(s)) for e, s in found.items())
    }


def set_offers(seen: Sequence[View], count: int) -> list[Offer]:
    """The best offers of pairs and of triples, the best first."""
    ranked = [(_pairs(view, count), view) for view in seen]
    pairs = _exact(ranked)
    top = max((o.score for o in pairs), default=-np.inf)
    # Not under a noise under which no pair comes near the best one under another.
    near = [
        (found, view) for found, view in ranked if found and found[0][0] > top - _LIMITS.noise_room
    ]
    return best_of_each([*pairs, *_exact([(_triples(view, found), view) for found, view in near])])


def _exact(ranked: Iterable[tuple[Sequence[ScoredSet], View]]) -> list[Offer]:
    """The first sets of each view, weighed without a shortcut."""
    return [
        view.offer(members)
        for found, view in ranked
        for members in leaders([m for _, m in found], view.has_lot, _LIMITS.exact)
    ]


def leaders(
    found: Iterable[SomeSet], has_lot: Callable[[SomeSet], bool], most: int
) -> list[SomeSet]:
    """The first sets without a lot of balls and the first with one, at most so many of each: a lot
    can be any function, and beside the true pair many sets of one and anything else score well."""
    parts: dict[bool, list[SomeSet]] = {False: [], True: []}
    for members in found:
        parts[has_lot(members)].append(members)
    return [members for part in parts.values() for members in part[:most]]


def _pairs(view: View, count: int) -> list[ScoredSet]:
    """The best pair of signatures of every pair of effects, the best first; of the first `count`
    signatures."""
    score, a, b = view.pairs(range(count))
    found = view.best_forms(score, np.column_stack([a, b]))
    lots = [m for m in range(count) if view.usable[m] and not view.narrow[m]]
    single = sorted(((view.offer((m,)).score, (m,)) for m in lots), reverse=True)
    for lot in single[: _LIMITS.pairs_with_lots]:
        found += view.best_additions([lot], count)
    return view.best_forms(np.array([s for s, _ in found]), np.array([m for _, m in found]))


def _triples(view: View, pairs: Sequence[ScoredSet]) -> list[ScoredSet]:
    """The best of all triples: every pair of effects in its best forms, with every third effect in
    all of its forms; the best first."""
    triples: list[ScoredSet] = []
    for lot in (False, True):
        triples += view.best_additions([s for s in pairs if view.has_lot(s[1]) == lot])
    return view.best_forms(np.array([s for s, _ in triples]), np.array([m for _, m in triples]))


def additions_to(setting: Setting, base: Fit, noises: Sequence[Noise] = ()) -> list[list[Offer]]:
    """One effect more than those of a fit, about its values, each in all of its forms, the best
    first; under some noises, else under its own and those near it."""
    about = setting.library.about(base, setting.names, secants=False)
    # As the library has it: a discrepancy of the first effects may be the further one.
    exact = replace(base, discrepancy_sd=0.0)
    have = set(base.hypothesis.effects)
    found: dict[str, tuple[float, View, int]] = {}
    for noise in noises or _near(base.noise, setting.flexible):
        view = View(setting, setting.fitter.look(exact, noise), about)
        score = view.singles()
        for m in np.flatnonzero(np.isfinite(score)).tolist():
            effect, label = about[m].variant.effect, about[m].variant.label
            if effect not in have and (label not in found or score[m] > found[label][0] + 1e-6):
                found[label] = float(score[m]), view, m
    forms: dict[Names, list[Offer]] = {}
    for offer in sorted(
        (view.offer((m,), base) for _, view, m in found.values()), key=lambda o: -round(o.score, 6)
    ):
        if np.isfinite(offer.score):
            forms.setdefault(offer.names, []).append(offer)
    return list(forms.values())


def _near(noise: Noise, flexible: Noise) -> list[Noise]:
    """A noise, and those in which a further effect may be at work that it has taken for noise."""
    found = [noise]
    if noise.offset_arcsec:
        found += [replace(noise, offset_arcsec=share * noise.offset_arcsec) for share in (0, 0.35)]
    if noise.correlation:
        found += [replace(n, correlation=0.5 * noise.correlation) for n in found]
    scale = min(noise.scale, flexible.scale)
    return [noise, *(replace(n, scale=scale) for n in found)]
