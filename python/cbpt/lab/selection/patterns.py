"""Patterns without a name: something real that nothing in the library explains.

Pattern         a family of patterns on top of a hypothesis, at its most favourable amplitude
patterns_on     the families that stand out in the residual of a fit, weighed like effects
says_no_more    whether a pattern is only what a fit has a name for
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.noise import Margin, Noise, Whitener, fit_noise
from cbpt.lab.inference.fit import Fit, Fitter
from cbpt.lab.model.discrepancy import FORM_ODDS
from cbpt.lab.selection.lack_of_fit import Component, Structure
from cbpt.lab.selection.ranking import ranked

Floats = NDArray[np.float64]
Names = tuple[str, ...]

_FAMILIES = 3
_AMPLITUDES = (0.5, 1.5, 5.0, 15.0)
# In misfit.
_AS_WELL = 6.0


@dataclass(frozen=True, eq=False)
class Pattern:
    """Something real without a name, on top of a hypothesis.

    base: the effects of the hypothesis; columns: what the pattern depends on; amplitude: in
    standard uncertainties of a reading.
    """

    base: Names
    columns: Names
    log_evidence: float
    amplitude: float
    noise: Noise
    problem: Patterned = field(repr=False)

    @property
    def fitted_arcsec(self) -> Floats:
        """What it amounts to at every reading, shape (n,)."""
        return self.problem.fitted(self.amplitude, self.noise)


@dataclass(frozen=True, eq=False)
class Patterned:
    """A linear problem with patterns among its columns, behind those of the unknowns; arcsec."""

    fitter: Fitter
    y: Floats
    columns: Floats
    precision: Floats
    start: Noise

    def prior(self, amplitude: float) -> Floats:
        """Precisions of all columns, the patterns being of an amplitude."""
        patterns = self.columns.shape[1] - len(self.precision)
        u = float(np.median(self.fitter.campaign.u_arcsec))
        own = np.full(patterns, (amplitude * u) ** -2.0)
        return np.concatenate([self.precision, own])

    def rated(self, amplitude: float, structures: bool = False) -> tuple[float, Noise]:
        """Log evidence, and the noise that suits it."""
        c = self.fitter.campaign
        noise, value = fit_noise(
            self.y,
            self.columns,
            self.prior(amplitude),
            c.u_arcsec,
            c.rows,
            self.start,
            self.fitter.stated_dof,
            structures,
        )
        return value, noise

    def mode(self, amplitude: float, noise: Noise) -> Floats:
        """Most probable values of all columns."""
        c = self.fitter.campaign
        whitener = Whitener.of(noise, c.u_arcsec, c.rows)
        y, x = whitener(self.y), whitener(self.columns)
        return np.asarray(Margin.of(y, x, self.prior(amplitude)).mode)

    def fitted(self, amplitude: float, noise: Noise) -> Floats:
        """What the patterns amount to at every reading."""
        first = len(self.precision)
        return np.asarray(self.columns[:, first:] @ self.mode(amplitude, noise)[first:])

    def residual(self, amplitude: float, noise: Noise) -> Floats:
        """Readings less everything."""
        return np.asarray(self.y - self.columns @ self.mode(amplitude, noise))


def patterns_on(
    fitter: Fitter, fit: Fit, families: Sequence[Component], noise: Noise
) -> Iterator[Pattern]:
    """The families that stand out most, each with the amplitude and noise that suit it.

    Looked at through two noises: that of the fit, which may have taken the pattern for noise, and
    `noise`, as a fit sees it that can follow the whole library.
    """
    start = replace(noise, looser=fit.noise.looser)
    tried: dict[int, Component] = {}
    for seen in (fit, fitter.look(fit, start)):
        structure = Structure(families, seen.whitener, seen.margin)
        if not structure.families:
            continue
        scores = structure.scores(structure.projected(seen.margin.y)[:, None])
        odds = structure.log_odds(scores)[:, 0]
        for i in ranked(odds.tolist())[:_FAMILIES]:
            if odds[i] > 1:
                tried[i] = structure.families[i]
    y, x, precision = fitter.linear(fit)
    for family in tried.values():
        patterns = family.patterns - family.patterns.mean(axis=0)
        problem = Patterned(fitter, y, np.column_stack([x, patterns]), precision, start)
        ratings = [(problem.rated(a)[0], a) for a in _AMPLITUDES]
        amplitude = max(ratings)[1]
        value, suited = problem.rated(amplitude, structures=True)
        value += fit.log_size_prior
        names = fit.hypothesis.effects
        yield Pattern(names, family.columns, value, amplitude, suited, problem)


def says_no_more(pattern: Pattern, fit: Fit) -> bool:
    """Whether effects with names follow the readings as well, and could follow any such pattern.

    At two or three input angles an offset of a centre is any function of the angle: a pattern with
    no more freedom than the sizes of the effects is no reason to call the effects unknown.
    """
    sizes = sum(u.size_of >= 0 for u in fit.unknowns)
    problem = pattern.problem
    patterns = problem.columns[:, len(problem.precision) :]
    if not set(pattern.base) < set(fit.hypothesis.effects) or fit.form_sd > FORM_ODDS[1][0]:
        return False
    if np.linalg.matrix_rank(patterns) > sizes:
        return False
    c = problem.fitter.campaign
    whitener = Whitener.of(pattern.noise, c.u_arcsec, c.rows)
    prior = problem.prior(pattern.amplitude)
    free = Margin.of(whitener(problem.y), whitener(problem.columns), prior).chi2
    return bool(problem.fitter.look(fit, pattern.noise).margin.chi2 - free < _AS_WELL)
