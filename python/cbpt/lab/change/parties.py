"""Levels with the same effects in the same forms, each fitted by itself under its own noise.

Levels      parties of all levels, their fits and the forms
levels_of   finds them: the effects that any level demands, in the forms most probable over all
with_form   the same with one more effect
forms_of    the forms that effects may have at all levels
proposed_for_springs  effects that a diagnosis proposes for a torsion spring
joint_in_series  a joint outside the friction
with_engagement  the same where such a joint changes the engagement of friction
log_noise   what the noise of a level adds to the log evidence, whatever the values
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
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
from cbpt.lab.selection.fit_effects import best_of_forms, fits_of_forms, start_from

Floats = NDArray[np.float64]


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
    fits: dict[tuple[Variant, ...], Fit]
    """In each form of the effects."""
    best: Fit | None
    """Over all forms; None without effects."""

    @classmethod
    def of(cls, fitter: Fitter, effects: Sequence[str], among: Collection[str]) -> _Alone:
        if not effects:
            return cls(fitter, {}, None)
        fits = fits_of_forms(fitter, effects, among)
        return cls(fitter, fits, best_of_forms(fitter, effects, fits))

    def values_in(self, forms: tuple[Variant, ...]) -> Iterator[Floats]:
        """Those that suit the level best in some forms, to begin with."""
        if self.best is not None and self.best.hypothesis.variants == forms:
            yield self.best.point.values
        elif forms in self.fits:
            yield self.fits[forms].point.values
        elif self.best is not None:
            yield start_from(self.fitter, forms, self.best)


def levels_of(
    campaigns: Sequence[Campaign], effects: Sequence[str], among: Collection[str] = ()
) -> Levels | None:
    """The levels fitted; None where some level has no solution. among: labels of the forms that
    effects may have, where any form of an effect is named."""
    library = _library(campaigns, effects)
    works = [
        partial(_Alone.of, Fitter(campaign, library), effects, among) for campaign in campaigns
    ]
    alone = side_by_side(campaigns[0], works)
    fitters = [level.fitter for level in alone]
    best: tuple[float, tuple[Variant, ...], list[Fit]] | None = None
    for forms in _forms(alone):
        fits = _fitted(alone, forms, -np.inf if best is None else best[0])
        if fits is None:
            continue
        total = sum(fit.log_evidence for fit in fits)
        if best is None or total > best[0]:
            best = total, forms, fits
    if best is None:
        return None
    _, forms, fits = best
    return _levels(fitters, fits, forms)


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
        known = {u.name: before.value(u) for u in before.unknowns}
        unknowns = fitter.unknowns(hypothesis)
        tried = []
        for sign in (1.0, -1.0) if variant.signed else (1.0,):
            sizes = {name: sign * size for name, size in _sizes([variant]).items()}
            values = fitter.start(hypothesis, sizes)
            for u in unknowns:
                if u.name in known:
                    values[u.index] = np.clip(known[u.name], u.lower, u.upper)
            tried.append(fitter.fit(hypothesis, values))
        solved = [fit for fit in tried if fit is not None]
        if not solved:
            return None
        fits.append(max(solved, key=lambda fit: fit.log_evidence))
    return _levels(fitters, fits, hypothesis.variants)


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
    """The forms that each level favours, those first with which all levels alone are probable."""
    if not any(level.fits for level in alone):
        return [()]
    found = [level.best.hypothesis.variants for level in alone if level.best is not None]
    everywhere = [
        {v.label for v in (*level.fitter.variants, *level.fitter.campaign.candidates)}
        for level in alone
    ]
    suited = [f for f in found if all({v.label for v in f} <= known for known in everywhere)]

    def together(forms: tuple[Variant, ...]) -> float:
        known = [level.fits.get(forms) for level in alone]
        return float(sum(-np.inf if fit is None else fit.log_evidence for fit in known))

    return sorted(dict.fromkeys(suited or found), key=together, reverse=True)


def _fitted(alone: Sequence[_Alone], forms: tuple[Variant, ...], least: float) -> list[Fit] | None:
    """Each level in these forms: from neutral values, from those that suit it best and from those
    of the level before it; None where a level has no solution, or where the evidence of all cannot
    reach `least`."""
    fits: list[Fit] = []
    for k, level in enumerate(alone):
        fitter, hypothesis = level.fitter, Hypothesis(forms)
        starts = [fitter.start(hypothesis, _sizes(forms))]
        if fits:
            values = fitter.start(hypothesis, {})
            for mine, theirs in zip(fitter.unknowns(hypothesis), fits[-1].unknowns, strict=True):
                values[mine.index] = np.clip(fits[-1].value(theirs), mine.lower, mine.upper)
            starts.append(values)
        if forms:
            starts += level.values_in(forms)
        tried = [fitter.fit(hypothesis, start) for start in starts]
        solved = [fit for fit in tried if fit is not None]
        if not solved:
            return None
        fits.append(max(solved, key=lambda fit: fit.log_evidence))
        # No level is more probable than in the forms that it favours itself.
        rest = [np.inf if a.best is None else a.best.log_evidence for a in alone[k + 1 :]]
        if sum(fit.log_evidence for fit in fits) + sum(rest) < least:
            return None
    return fits


def _sizes(forms: Sequence[Variant]) -> dict[str, float]:
    """Small sizes to begin with, at which shapes can be seen."""
    return {
        f"{v.effect}.{name}": float(np.sqrt(v.low * v.high)) for v in forms for name in v.sizes[:1]
    }
