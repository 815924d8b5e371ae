"""Levels with the same effects in the same forms, each fitted by itself under its own noise.

Levels      parties of all levels, their fits and the forms
levels_of   finds them: the effects that any level demands, in the forms most probable over all
log_noise   what the noise of a level adds to the log evidence, whatever the values
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from cbpt.errors import InvalidInputError
from cbpt.lab.change.shared import Party
from cbpt.lab.covariance.fit_noise import PRICE, log_scale_prior
from cbpt.lab.covariance.linear_gaussian import log_likelihood
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.gauss_newton import Problem
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import Variant
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.selection.fit_effects import best_fit


@dataclass(frozen=True, eq=False)
class Levels:
    """All levels with one list of unknowns."""

    parties: tuple[Party, ...]
    fits: tuple[Fit, ...]
    variants: tuple[Variant, ...]


def levels_of(campaigns: Sequence[Campaign], effects: Sequence[str]) -> Levels | None:
    """The levels fitted; None where some level has no solution."""
    library = library_of(_longest(campaigns), effects, campaigns)
    fitters = [Fitter(campaign, library) for campaign in campaigns]
    best: tuple[float, tuple[Variant, ...], list[Fit]] | None = None
    for forms in _forms(fitters, effects):
        fits = _fitted(fitters, forms)
        if fits is None:
            continue
        total = sum(fit.log_evidence for fit in fits)
        if best is None or total > best[0]:
            best = total, forms, fits
    if best is None:
        return None
    _, forms, fits = best
    parties = []
    for fitter, fit in zip(fitters, fits, strict=True):
        problem = Problem(fitter.campaign, fitter.model, fit.unknowns, fit.noise)
        parties.append(Party(problem, fit.point, log_noise(problem, fitter.stated_dof)))
    return Levels(tuple(parties), tuple(fits), forms)


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


def _forms(fitters: Sequence[Fitter], effects: Sequence[str]) -> list[tuple[Variant, ...]]:
    """The forms that each level favours."""
    if not effects:
        return [()]
    found = [best_fit(fitter, effects).hypothesis.variants for fitter in fitters]
    everywhere = [{v.label for v in (*f.variants, *f.campaign.candidates)} for f in fitters]
    suited = [f for f in found if all({v.label for v in f} <= known for known in everywhere)]
    return list(dict.fromkeys(suited or found))


def _fitted(fitters: Sequence[Fitter], forms: tuple[Variant, ...]) -> list[Fit] | None:
    """Each level in these forms: from neutral values, and from those of the levels before it."""
    fits: list[Fit] = []
    for fitter in fitters:
        hypothesis = Hypothesis(forms)
        starts = [fitter.start(hypothesis, _sizes(forms))]
        for other in fits:
            values = fitter.start(hypothesis, {})
            for mine, theirs in zip(fitter.unknowns(hypothesis), other.unknowns, strict=True):
                values[mine.index] = np.clip(other.value(theirs), mine.lower, mine.upper)
            starts.append(values)
        if forms:
            with suppress(InvalidInputError):
                # Not where another level alone shows what a form does: the other starts are left.
                starts.append(best_fit(fitter, [v.label for v in forms]).point.values)
        tried = [fitter.fit(hypothesis, start) for start in starts]
        solved = [fit for fit in tried if fit is not None]
        if not solved:
            return None
        fits.append(max(solved, key=lambda fit: fit.log_evidence))
    return fits


def _sizes(forms: Sequence[Variant]) -> dict[str, float]:
    """Small sizes to begin with, at which shapes can be seen."""
    return {
        f"{v.effect}.{name}": float(np.sqrt(v.low * v.high)) for v in forms for name in v.sizes[:1]
    }
