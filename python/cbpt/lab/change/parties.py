"""Levels with the same effects in the same forms, each fitted by itself under its own noise.

Levels      parties of all levels, their fits and the forms
EachAlone   finds them for several sets of effects, in the forms most probable over all levels
levels_of   the same for one set
with_form   the same with one more effect
forms_of    the forms that effects may have at all levels
proposed_for_springs  effects that a diagnosis proposes for a torsion spring
joint_in_series  a joint outside the friction
with_engagement  the same where such a joint changes the engagement of friction
log_noise   what the noise of a level adds to the log evidence, whatever the values
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.shared import Party
from cbpt.lab.covariance.fit_noise import PRICE, log_scale_prior
from cbpt.lab.covariance.linear_gaussian import log_likelihood
from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.gauss_newton import Problem
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_loops import ENGAGEMENT
from cbpt.lab.model.priors import Variant
from cbpt.lab.model.spring_priors import joint_of, library_of
from cbpt.lab.selection.fit_effects import Fits, best_of_forms, fits_of_forms, start_from
from cbpt.lab.selection.rules import RULES

Floats = NDArray[np.float64]

_ROOM = 2 * RULES.log_rival_odds
"""In log odds for each level: what other starts may gain. Forms further below the best are left."""


@dataclass(frozen=True, eq=False)
class Levels:
    """All levels with one list of unknowns."""

    parties: tuple[Party, ...]
    fits: tuple[Fit, ...]
    variants: tuple[Variant, ...]
    choices: tuple[frozenset[str], ...] = ()
    """What may have changed: the choices to weigh. Where empty, they are searched."""
    alongside: tuple[tuple[str, int], ...] = ()
    """Unknowns that change with an effect and belong to another, by the former."""


@dataclass(frozen=True, eq=False)
class _Alone:
    """A level by itself."""

    fitter: Fitter
    fits: Fits
    """In each form of the effects."""
    best: Fit | None
    """Over all forms; None without effects."""

    @classmethod
    def of(
        cls, fitter: Fitter, effects: Sequence[str], among: Collection[str], known: Fits
    ) -> _Alone:
        """known: fits of other effects to the level, to which those by themselves are added."""
        if not effects:
            return cls(fitter, {}, None)
        fits = fits_of_forms(fitter, effects, among, known)
        return cls(fitter, fits, best_of_forms(fitter, effects, fits))

    def first(self, forms: tuple[Variant, ...]) -> Fit | None:
        """The level in some forms, from the values that suit it best."""
        start = self._values_in(forms)
        found = None if start is None else self.fitter.fit(Hypothesis(forms), start)
        return found or self.fitter.fit(Hypothesis(forms), self._neutral(forms))

    def again(
        self, forms: tuple[Variant, ...], first: Fit | None, others: Sequence[Fit]
    ) -> Fit | None:
        """The best of that, of the level from neutral values and from those of others."""
        hypothesis = Hypothesis(forms)
        starts = [self._neutral(forms)] if self.best is not None else []
        starts += [_from_values_of(other, self.fitter, hypothesis, {}) for other in others]
        tried = [first, *(self.fitter.fit(hypothesis, start) for start in starts)]
        solved = [fit for fit in tried if fit is not None]
        return max(solved, key=lambda fit: fit.log_evidence, default=None)

    def _neutral(self, forms: tuple[Variant, ...]) -> Floats:
        return self.fitter.start(Hypothesis(forms), _sizes(forms))

    def _values_in(self, forms: tuple[Variant, ...]) -> Floats | None:
        """Those that suit the level best in some forms, to begin with."""
        if self.best is not None and self.best.hypothesis.variants == forms:
            return self.best.point.values
        if forms in self.fits:
            return self.fits[forms].point.values
        return None if self.best is None else start_from(self.fitter, forms, self.best)


class EachAlone:
    """Levels that are each fitted by itself, with one set of effects after another. What is known
    of one set is where the next one begins."""

    def __init__(
        self, campaigns: Sequence[Campaign], effects: Collection[str], among: Collection[str] = ()
    ) -> None:
        """effects: those of all sets. among: labels of the forms that they may have, where any form
        of an effect is named."""
        library = _library(campaigns, sorted(effects))
        self._fitters = [Fitter(campaign, library) for campaign in campaigns]
        self._known: list[Fits] = [{} for _ in campaigns]
        self._among = among

    def levels_of(self, effects: Sequence[str]) -> Levels | None:
        """The levels with one set, in the forms that are most probable over all; None where some
        level has no solution. Raises `InvalidInputError` and `ReadingsError` where a level does not
        show the effects."""
        # The levels of each set have models of their own, as sets are searched side by side.
        fitters = [fitter.beside() for fitter in self._fitters]
        campaign = fitters[0].campaign
        works = [
            partial(_Alone.of, fitter, effects, self._among, known)
            for fitter, known in zip(fitters, self._known, strict=True)
        ]
        alone = side_by_side(campaign, works)
        for known, level in zip(self._known, alone, strict=True):
            known.update(level.fits)
        begun = {
            forms: side_by_side(campaign, [partial(level.first, forms) for level in alone])
            for forms in _forms(alone)
        }
        best, most = None, -np.inf
        favoured = [level.best for level in alone]
        for forms in sorted(begun, key=lambda forms: -_total(begun[forms])):
            first = begun[forms]
            # A level without a solution may have one from other starts.
            reach = [fit or own for fit, own in zip(first, favoured, strict=True)]
            if _total(reach) < most - _ROOM * len(alone):
                continue
            works_again = [
                partial(level.again, forms, fit, _beside(first, k))
                for k, (level, fit) in enumerate(zip(alone, first, strict=True))
            ]
            fits = [fit for fit in side_by_side(campaign, works_again) if fit is not None]
            if len(fits) == len(alone) and (best is None or _total(fits) > most):
                best, most = _levels(fitters, fits, forms), _total(fits)
        return best


def levels_of(
    campaigns: Sequence[Campaign], effects: Sequence[str], among: Collection[str] = ()
) -> Levels | None:
    """The levels with one set of effects, as in `EachAlone`."""
    return EachAlone(campaigns, effects, among).levels_of(effects)


def _total(fits: Sequence[Fit | None]) -> float:
    """Log evidence of all levels; that of no solution where one has none."""
    return float(sum(-np.inf if fit is None else fit.log_evidence for fit in fits))


def _beside(fits: Sequence[Fit | None], k: int) -> list[Fit]:
    """Those of the levels before and after one."""
    return [fit for fit in (*fits[max(k - 1, 0) : k], *fits[k + 1 : k + 2]) if fit is not None]


def with_form(levels: Levels, variant: Variant, without: str | None) -> Levels | None:
    """The levels with a form of one more effect, which may stand in place of another; None where
    some level has no solution. The search begins with the values that the levels have."""
    kept = tuple(v for v in levels.variants if v.effect != without)
    hypothesis = Hypothesis((*kept, variant))
    campaigns = [party.problem.campaign for party in levels.parties]
    asked = [v.label for v in hypothesis.variants]
    library = _library(campaigns, asked)
    if variant not in library:
        library = *library, variant
    fitters = [Fitter(campaign, library) for campaign in campaigns]
    fits = []
    for fitter, before in zip(fitters, levels.fits, strict=True):
        tried = []
        for sign in (1.0, -1.0) if variant.signed else (1.0,):
            sizes = {name: sign * size for name, size in _sizes([variant]).items()}
            start = _from_values_of(before, fitter, hypothesis, sizes)
            tried.append(fitter.fit(hypothesis, start))
        solved = [fit for fit in tried if fit is not None]
        if not solved:
            return None
        fits.append(max(solved, key=lambda fit: fit.log_evidence))
    return _levels(fitters, fits, hypothesis.variants)


def _from_values_of(
    fit: Fit, fitter: Fitter, hypothesis: Hypothesis, sizes: dict[str, float]
) -> Floats:
    """The values of a fit of this level or of another one, within the bounds of this; of what that
    has not, these sizes."""
    values, known = fitter.start(hypothesis, sizes), {u.name: fit.value(u) for u in fit.unknowns}
    for u in fitter.unknowns(hypothesis):
        if u.name in known:
            values[u.index] = np.clip(known[u.name], u.lower, u.upper)
    return values


def _levels(fitters: Sequence[Fitter], fits: Sequence[Fit], forms: tuple[Variant, ...]) -> Levels:
    parties = []
    for fitter, fit in zip(fitters, fits, strict=True):
        problem = Problem(fitter.campaign, fitter.model, fit.unknowns, fit.noise)
        parties.append(Party(problem, fit.point, log_noise(problem, fitter.stated_dof)))
    return Levels(tuple(parties), tuple(fits), forms)


def forms_of(levels: Levels, effects: Sequence[str]) -> tuple[Variant, ...]:
    """The forms that some effects may have at all levels, without what their tables cannot show."""
    campaigns = [party.problem.campaign for party in levels.parties]
    longest = _longest(campaigns)
    # What a diagnosis proposes has the range that it is proposed in.
    proposed = {v.effect for v in library_of(longest, (), campaigns)}
    asked = [effect for effect in effects if effect not in proposed]
    library = library_of(longest, asked, campaigns)
    offered = [Fitter(campaign, library).variants for campaign in campaigns]
    everywhere = set.intersection(*({v.label for v in variants} for variants in offered))
    return tuple(v for v in library if v.effect in effects and v.label in everywhere)


def proposed_for_springs(levels: Levels) -> list[str]:
    """The effects that a diagnosis proposes for the levels of a torsion spring; none for those of
    a ball drive."""
    campaigns = [party.problem.campaign for party in levels.parties]
    longest = _longest(campaigns)
    spring = longest.drive.kind == "torsion_spring"
    return [v.effect for v in library_of(longest, [], campaigns)] if spring else []


def joint_in_series(levels: Levels) -> Variant | None:
    """A joint that takes the whole torque, of a size that the tables can show."""
    return joint_of(_longest([party.problem.campaign for party in levels.parties]))


def with_engagement(levels: Levels, effect: str) -> Levels:
    """The levels where the angle over which friction builds up changes with a joint in series: the
    model counts it on the total angle, so what the joint turns while friction builds up is in it.
    """
    unknowns = levels.fits[0].unknowns
    places = (i for i, u in enumerate(unknowns) if u.name == ENGAGEMENT)
    return replace(levels, alongside=tuple((effect, place) for place in places))


def log_noise(problem: Problem, stated_dof: float) -> float:
    """The terms of `evidence.evaluated` that depend on the noise alone, offsets integrated out."""
    offsets = problem.offsets
    volume = -0.5 * float(np.linalg.slogdet(offsets.T @ offsets)[1])
    found = log_likelihood(0.0, problem.whitener, volume) - PRICE * problem.noise.numbers
    return found + float(log_scale_prior(np.array(problem.noise.scale), stated_dof))


def _longest(campaigns: Sequence[Campaign]) -> Campaign:
    """The level that reaches furthest: plausible sizes of a torsion spring are shares of that."""
    reach = [float(np.abs(c.readings.torque_Nm).max()) for c in campaigns]
    return campaigns[int(np.argmax(reach))]


def _library(campaigns: Sequence[Campaign], asked: Sequence[str]) -> tuple[Variant, ...]:
    """The forms of the level that reaches furthest, and those that only tables of others have."""
    longest = _longest(campaigns)
    found = list(library_of(longest, asked, campaigns))
    for other in campaigns:
        known = {v.label for v in found}
        found += [v for v in library_of(other, asked, campaigns) if v.label not in known]
    return tuple(found)


def _forms(alone: Sequence[_Alone]) -> list[tuple[Variant, ...]]:
    """The forms that any level favours, of those that all levels may have."""
    if not any(level.fits for level in alone):
        return [()]
    found = [level.best.hypothesis.variants for level in alone if level.best is not None]
    everywhere = [
        {v.label for v in (*level.fitter.variants, *level.fitter.campaign.candidates)}
        for level in alone
    ]
    suited = [f for f in found if all({v.label for v in f} <= known for known in everywhere)]

    return list(dict.fromkeys(suited or found))


def _sizes(forms: Sequence[Variant]) -> dict[str, float]:
    """Small sizes to begin with, at which shapes can be seen."""
    return {
        f"{v.effect}.{name}": float(np.sqrt(v.low * v.high)) for v in forms for name in v.sizes[:1]
    }
