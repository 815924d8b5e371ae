"""All small sets of effects at once: linear in their sizes, the noise profiled.

Offer              a set of effects with the score that a view gives it, and where a full fit starts
Sets               sets of equally many signatures, with their scores
View               the library about one fit, seen through one noise
views              one view for each noise that the readings may have
single_offers      every variant of every effect
promising_singles  those that are worth a fit, by effect
variant_prices     what the best variant of an effect exceeds their mean by
set_offers         pairs, and triples
leaders            the first sets without a lot of balls, and the first with one
with_a_part        whether each set promises more than all that it contains
additions_to       one effect more than those of a fit

A set of signatures is a linear problem; its marginal likelihood follows from the Gram matrix of a
view, with the scale of the noise at its most probable value for each set. Effects that a smaller
set does not show are found so, because no set is built on another one: all singles and all pairs
are weighed, and all triples: every pair of effects in its best forms with every third effect.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import least_scale, log_scale_prior
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.selection.linear_screen import Gains, Screen, Signature, Stack
from cbpt.lab.selection.setting import Names, Setting

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Offer:
    """A set of effects as a view sees it."""

    score: float
    """Log of evidence times prior odds, as the view sees it."""
    view: View
    members: tuple[int, ...]
    """Signatures of the view that are added to `base`."""
    base: Fit | None = None
    """The fit that is added to; None for the drive as stated."""

    @property
    def signatures(self) -> tuple[Signature, ...]:
        """What is added to `base`."""
        return tuple(self.view.signatures[m] for m in self.members)

    @property
    def sizes(self) -> Floats:
        """Of the signatures, one after the other."""
        return self.view.screen.gain(self.members).sizes

    @property
    def seen(self) -> Fit:
        """The fit that the view is about, through its noise."""
        return self.view.seen

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
    def adds(self) -> str:
        """The effect that is added last."""
        return self.signatures[-1].variant.effect

    @property
    def has_lot(self) -> bool:
        """Whether a lot of balls is added."""
        return any(s.variant.spread for s in self.signatures)

    @property
    def curved(self) -> bool:
        """Whether an effect is added that does not grow in proportion to its size."""
        return any(s.secant for s in self.signatures)


class Sets(NamedTuple):
    """Sets of equally many signatures of a view."""

    score: Floats
    """Shape (n,)."""
    members: Ints
    """Shape (n, m)."""


class View:
    """The library about one fit, seen through one noise."""

    def __init__(self, setting: Setting, seen: Fit, stack: Stack) -> None:
        self.stack, self.signatures, self.seen = stack, stack.signatures, seen
        self.screen = Screen(seen, stack)
        fitter = setting.fitter
        self.campaign = fitter.campaign
        self._stated_dof = fitter.stated_dof
        offsets = fitter.campaign.offsets.shape[1]
        self._dof = float(len(fitter.campaign) - offsets)
        self._level = setting.score(seen)
        self._weights = setting.weights(stack)
        self.usable, self.narrow = self.screen.usable, stack.narrow
        self.singles = self._of_singles()
        """Scores of all signatures; minus infinity where one cannot be seen."""

    def score(self, gained: Floats, sizes: Ints | int) -> Floats:
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

    def weighed(self, members: Ints) -> Floats:
        """Scores of sets (n, m), shape (n,); minus infinity where a size is negative that must not
        be."""
        gains = self.screen.gains(members)
        return self.score(gains.chi2, self._count(members)) + self._rest(members, gains)

    def _count(self, members: Ints) -> Ints:
        """How many sizes sets have."""
        return np.asarray(self.stack.width[members].sum(axis=1))

    def _rest(self, members: Ints, gains: Gains) -> Floats:
        """What sets score beside what they take off the misfit."""
        weights = self._weights[members].sum(axis=1)
        return np.asarray(gains.log_volume + gains.log_prior + weights)

    def _of_singles(self) -> Floats:
        score = np.full(len(self.signatures), -np.inf)
        for members in self.stack.by_width(self.usable):
            score[members] = self.weighed(members[:, None])
        return score

    @cached_property
    def best_of_effects(self) -> Floats:
        """The best score of each effect alone, by its number in the stack."""
        best = np.full(self.stack.kind.max() + 1, -np.inf)
        np.maximum.at(best, self.stack.kind, self.singles)
        return best

    def pairs(self, count: int) -> Sets:
        """All pairs of the first `count` signatures that are of two effects and no lots."""
        at = np.flatnonzero((self.usable & self.narrow)[:count])
        members = at[np.column_stack(np.triu_indices(len(at), 1))]
        kinds = self.stack.kind[members]
        members = members[kinds[:, 0] != kinds[:, 1]]
        return Sets(self.weighed(members), members)

    def additions(self, members: Ints, count: int | None = None) -> Floats:
        """Roughly the scores of sets (n, m) with one more narrow signature of another effect, of
        the first `count`, shape (n, count); minus infinity where that cannot be seen.

        Roughly: the prior of the sizes and the volume of a set are those that it has alone.
        """
        seen = (self.usable & self.narrow)[:count]
        left, score = np.flatnonzero(seen), np.full((len(members), len(seen)), -np.inf)
        gains = self.screen.gains(members)
        alone, sizes = self._rest(members, gains), self._count(members)
        # A few sets at a time, so that what is worked on stays in the cache.
        for start in range(0, len(members), _LIMITS.at_once):
            some = slice(start, start + _LIMITS.at_once)
            more = self._one_more(gains.some(some), sizes[some, None], left)
            have = self.stack.kind[members[some], None] == self.stack.kind[left]
            score[some, left] = np.where(have.any(axis=1), -np.inf, alone[some, None] + more)
        return score

    def _one_more(self, gains: Gains, sizes: Ints, left: Ints) -> Floats:
        """Scores of sets of so many sizes with one of some narrow signatures each, whatever its
        effect, without what they have alone, shape (sets, signatures).

        Of a signature with several columns the first and the last count.
        """
        stack, gram = self.stack, self.screen.gram
        first, last = stack.first[left], stack.first[left] + stack.width[left] - 1
        wide = np.flatnonzero(first < last)
        # Every column beside every set, (sets, columns), once the set has taken its part.
        cross = gram[gains.columns.T]
        seen = np.moveaxis(gains.inverse * (gains.real[:, None] & gains.real), 2, 0) @ cross
        b = self.screen.projection - np.einsum("skc,ks->sc", cross, gains.sizes)
        own = np.diagonal(gram)
        # No less than the hair that every column has of its own.
        g = np.maximum(own - np.einsum("skc,skc->sc", cross, seen), 1e-9 * own)
        b1, g11 = b[:, first], g[:, first]
        b2, g22, g12 = np.zeros(b1.shape), np.ones(b1.shape), np.zeros(b1.shape)
        one, two = first[wide], last[wide]
        b2[:, wide], g22[:, wide] = b[:, two], g[:, two]
        both = np.einsum("skn,skn->sn", cross[:, :, one], seen[:, :, two])
        g12[:, wide] = gram[one, two] - both
        determinant = np.maximum(g11 * g22 - g12**2, 1e-9 * g11 * g22)
        size1, size2 = (b1 * g22 - b2 * g12) / determinant, (b2 * g11 - b1 * g12) / determinant
        variances = np.array([g22, np.where(first < last, g11, 0.0)]) / determinant
        gained = gains.chi2[:, None] + b1 * size1 + b2 * size2
        score = self.score(gained, sizes + stack.width[left]) - 0.5 * np.log(determinant)
        score += stack.log_prior(left, np.array([size1, size2]), variances)
        return np.asarray(score + self._weights[left])

    def best_additions(self, members: Ints, count: int | None = None) -> Sets:
        """Sets (n, m) with one more of the first `count` signatures, of every effect the best form
        beside each set."""
        kind = self.stack.kind[:count]
        order = np.argsort(kind, kind="stable")
        cuts = np.flatnonzero(np.diff(kind[order])) + 1
        score = self.additions(members, count)[:, order]
        of_kinds = zip(np.split(score, cuts, axis=1), np.split(order, cuts), strict=True)
        more = np.concatenate([forms[part.argmax(axis=1)] for part, forms in of_kinds])
        best = np.maximum.reduceat(score, np.r_[0, cuts], axis=1)
        return Sets(best.T.reshape(-1), np.c_[np.tile(members, (best.shape[1], 1)), more])

    def best_forms(self, sets: Sets) -> Sets:
        """Of sets of the same effects the best one; the best of all first."""
        score, members = sets
        kinds = np.sort(self.stack.kind[members], axis=1)
        effects = self.stack.kind.max() + 1
        code = kinds @ (effects ** np.arange(kinds.shape[1]))
        best = np.full(effects ** kinds.shape[1], -np.inf)
        np.maximum.at(best, code, score)
        found = np.flatnonzero((score == best[code]) & np.isfinite(score))
        found = found[np.sort(np.unique(code[found], return_index=True)[1])]
        found = found[np.argsort(-score[found], kind="stable")]
        return Sets(score[found], members[found])

    def offers(self, sets: Sets, base: Fit | None = None) -> list[Offer]:
        """One of each set that has a score."""
        found = zip(sets.score.tolist(), sets.members.tolist(), strict=True)
        return [
            Offer(score, self, tuple(members), base) for score, members in found if score > -np.inf
        ]


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
    at_once: int = 64
    """Sets to which one more is added at once."""


_LIMITS = _Limits()


def views(setting: Setting) -> list[View]:
    """The library about the drive as stated, under every noise that the readings may have."""
    return _views(setting, setting.null, _noises(setting), setting.wider)


def _views(setting: Setting, base: Fit, noises: Sequence[Noise], stack: Stack) -> list[View]:
    """Of some signatures about a fit, under some noises."""

    def view(noise: Noise) -> View:
        return View(setting, setting.fitter.look(base, noise), stack)

    return side_by_side(setting.fitter.campaign, [partial(view, noise) for noise in noises])


def _noises(setting: Setting) -> list[Noise]:
    """Those of the drive as stated, which may have taken an effect for noise, and of fits which may
    follow the whole library, and a grid."""
    c, rows = setting.fitter.campaign, setting.fitter.campaign.rows
    flexible = setting.flexible
    typical = float(np.median(c.u_arcsec)) * flexible.scale
    correlations = _LIMITS.correlations if rows.runs < len(c) else (0.0,)
    correlations = tuple(dict.fromkeys(min(r, rows.most_correlation) for r in correlations))
    offsets = _LIMITS.offsets if 1 < rows.runs < len(c) else (0.0,)
    grid = product(correlations, (offset * typical for offset in offsets))
    return list(setting.noises) + [
        replace(flexible, correlation=correlation, offset_arcsec=offset_arcsec)
        for correlation, offset_arcsec in grid
        # That itself is among the first.
        if (correlation, offset_arcsec) != (flexible.correlation, flexible.offset_arcsec)
    ]


def best_of_each(offers: Iterable[Offer]) -> list[Offer]:
    """The best offer of every set of effects, the best first."""
    best: dict[Names, Offer] = {}
    for offer in offers:
        if offer.names not in best or offer.score > best[offer.names].score + 1e-6:
            best[offer.names] = offer
    return sorted(best.values(), key=lambda o: -round(o.score, 6))


def single_offers(seen: Sequence[View], base: Fit | None = None) -> list[Offer]:
    """The best offer of every variant of every effect, the best first; of views of one stack."""
    scores = np.array([view.singles for view in seen])
    form, offers = seen[0].stack.form, []
    for members in (np.flatnonzero(form == number) for number in range(form.max() + 1)):
        # Of equals the first.
        best = int(np.argmax(np.round(scores[:, members], 6)))
        view, member = best // len(members), int(members[best % len(members)])
        if np.isfinite(scores[view, member]):
            offers.append(Offer(float(scores[view, member]), seen[view], (member,), base))
    return sorted(offers, key=lambda o: -round(o.score, 6))


def variant_prices(setting: Setting, singles: Sequence[Offer]) -> dict[str, float]:
    """By the label of a variant. The evidence of an effect is the mean over its variants, of which
    the best is shown: what it exceeds their mean by, as single effects tell. In a set the one that
    is shown is the best, so no other counts for more there, however it does alone."""
    found: dict[str, dict[str, float]] = {}
    for offer in singles:
        label = offer.signatures[0].variant.label
        of_effect = found.setdefault(offer.names[0], {})
        of_effect[label] = max(offer.score, of_effect.get(label, -np.inf))
    return {
        label: float(
            np.log(setting.variants[effect])
            - np.log(np.exp(np.minimum(np.array(list(scores.values())) - own, 0.0)).sum())
        )
        for effect, scores in found.items()
        for label, own in scores.items()
    }


def set_offers(seen: Sequence[View], count: int) -> list[Offer]:
    """The best offers of pairs and of triples, the best first."""
    found = side_by_side(seen[0].campaign, [partial(_pairs, view, count) for view in seen])
    ranked = list(zip(found, seen, strict=True))
    pairs = _exact(ranked)
    top = max((o.score for o in pairs), default=-np.inf)
    # Not under a noise under which no pair comes near the best one under another.
    near = [
        (found, view)
        for found, view in ranked
        if len(found.score) and found.score[0] > top - _LIMITS.noise_room
    ]
    works = [partial(_triples, view, found) for found, view in near]
    triples = side_by_side(seen[0].campaign, works)
    return best_of_each(
        [*pairs, *_exact(list(zip(triples, (view for _, view in near), strict=True)))]
    )


def _exact(ranked: Iterable[tuple[Sets, View]]) -> list[Offer]:
    """The first sets of each view, weighed without a shortcut."""
    offers = []
    for (score, members), view in ranked:
        # Many score well by one effect that says it all: they are not to crowd out the others.
        alone = view.best_of_effects[view.stack.kind[members]].max(axis=1, initial=-np.inf)
        lots, own = _with_lot(view, members), np.flatnonzero(score > alone)
        places = {*leaders(lots, _LIMITS.exact), *own[leaders(lots[own], _LIMITS.exact)].tolist()}
        first = members[sorted(places)]
        offers += view.offers(Sets(view.weighed(first), first))
    return offers


def _with_lot(view: View, members: Ints) -> NDArray[np.bool_]:
    """Which sets have a lot of balls."""
    return np.asarray(~view.narrow[members].all(axis=1))


def leaders(lots: Sequence[bool] | NDArray[np.bool_], most: int) -> list[int]:
    """Places of the first sets without a lot of balls and of the first with one, at most so many of
    each: a lot can be any function, and beside the true pair many sets of one and anything else
    score well."""
    with_lot = np.asarray(lots, dtype=bool)
    return [i for part in (~with_lot, with_lot) for i in np.flatnonzero(part)[:most].tolist()]


def with_a_part(sets: Sequence[Offer], singles: Sequence[Offer]) -> list[bool]:
    """Of sets whether they promise more than every set that they contain, so that each of their
    effects has a part in it; else one is but a passenger of the others."""
    best: dict[Names, float] = {}
    for offer in (*singles, *sets):
        best[offer.names] = max(offer.score, best.get(offer.names, -np.inf))
    return [
        all(
            best.get(part, -np.inf) < offer.score
            for size in range(1, len(offer.names))
            for part in combinations(offer.names, size)
        )
        for offer in sets
    ]


def _pairs(view: View, count: int) -> Sets:
    """The best pair of signatures of every pair of effects, the best first; of the first `count`
    signatures."""
    score, members = view.pairs(count)
    lots = np.flatnonzero((view.usable & ~view.narrow)[:count])
    if len(lots):
        first = np.argsort(-view.singles[lots], kind="stable")[: _LIMITS.pairs_with_lots]
        of_lots = view.best_additions(lots[first, None], count)
        score, members = np.r_[score, of_lots.score], np.r_[members, of_lots.members]
    return view.best_forms(Sets(score, members))


def _triples(view: View, pairs: Sets) -> Sets:
    """The best of all triples: every pair of effects in its best forms, with every third effect in
    all of its forms; the best first."""
    with_lot = _with_lot(view, pairs.members)
    parts = [view.best_additions(pairs.members[of]) for of in (~with_lot, with_lot) if of.any()]
    score, members = (np.concatenate(both) for both in zip(*parts, strict=True))
    return view.best_forms(Sets(score, members))


def additions_to(setting: Setting, base: Fit, noises: Sequence[Noise] = ()) -> list[list[Offer]]:
    """One effect more than those of a fit, about its values, each in all of its forms, the best
    first; under some noises, else under its own and those near it."""
    about = setting.library.about(base, setting.names, secants=False)
    further = [s for s in about if s.variant.effect not in base.hypothesis.effects]
    if not further:
        return []
    stack = Stack(further)
    # As the library has it: a discrepancy of the first effects may be the further one.
    exact = replace(base, discrepancy_sd=0.0)
    looks = _views(setting, exact, noises or _near(base.noise, setting.flexible), stack)
    forms: dict[Names, list[Offer]] = {}
    for offer in single_offers(looks, base):
        forms.setdefault(offer.names, []).append(offer)
    return list(forms.values())


def _near(noise: Noise, flexible: Noise) -> list[Noise]:
    """A noise, and those in which a further effect may be at work that it has taken for noise."""
    found = [noise]
    if noise.offset_arcsec:
        found += [replace(noise, offset_arcsec=share * noise.offset_arcsec) for share in (0, 0.35)]
    if noise.correlation:
        found += [replace(n, correlation=0.5 * noise.correlation) for n in found]
    if noise.scale <= flexible.scale:
        return found
    return [noise, *(replace(n, scale=flexible.scale) for n in found)]


def promising_singles(
    offers: Sequence[Offer], fewest: int, room: float, variant_room: float
) -> dict[str, list[Offer]]:
    """The forms of every single effect that may matter, the most promising first; of one that does
    not grow in proportion to its size the linear problem does not say whether it does.

    fewest: effects, however improbable. room: log odds below the best within which all are.
    variant_room: the same of the forms of one effect.
    """
    out: dict[str, list[Offer]] = {}
    for offer in offers:
        if len(out) >= fewest and offer.score < offers[0].score - room and not offer.curved:
            continue
        forms = out.setdefault(offer.signatures[0].variant.effect, [])
        if not forms or offer.score > forms[0].score - variant_room:
            forms.append(offer)
    return out
