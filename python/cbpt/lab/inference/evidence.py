"""A hypothesis at its most probable values, and its evidence.

Fit          values, uncertainties, noise, evidence
Closing      how near the values of a fit are to the minimum
Discrepancy  how far the effects may depart from their equations
evaluated    the fit at a point of the search
linearised   its linear problem

The evidence is Laplace's: likelihood at the mode, times prior density, times the volume of the
posterior (MacKay 2003, chapter 28). Sizes of effects are equally likely in the logarithm over their
plausible range.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import log_scale_prior, price_of
from cbpt.lab.covariance.linear_gaussian import (
    Linear,
    Margin,
    Noise,
    Whitener,
    inverse,
    log_likelihood,
)
from cbpt.lab.inference.gauss_newton import Problem
from cbpt.lab.inference.hypothesis import Hypothesis, Unknown
from cbpt.lab.model.discrepancy import discrepancy_columns
from cbpt.lab.model.forward import Point
from cbpt.lab.model.priors import PRIORS, log_size_prior

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Closing:
    """How near the values of a fit are to the minimum."""

    steps: int
    """Gauss-Newton steps that were taken to come so near."""
    tolerance_u: float
    """The longest step, in standard uncertainties, that need not be taken."""
    next_step_u: float
    """How long the next step would be, in standard uncertainties."""
    converged: bool
    """Whether the next step is within the tolerance, or lost in rounding. It is not where the model
    has a kink at the minimum."""

    def __str__(self) -> str:
        taken = f"{self.steps} closing Gauss-Newton step{'s' * (self.steps != 1)}"
        if self.converged:
            return f"{taken}; the next one would be {self.next_step_u:.1g} standard uncertainties"
        return (
            f"{taken} did not reach the tolerance; the next one would be "
            f"{self.next_step_u:.1g} standard uncertainties"
        )


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis at its most probable values."""

    hypothesis: Hypothesis
    point: Point
    unknowns: tuple[Unknown, ...]
    noise: Noise
    whitener: Whitener = field(repr=False)
    margin: Margin = field(repr=False)
    """Residual and columns, whitened; the last columns are the offsets."""
    covariance: Floats = field(repr=False)
    """Of the unknowns, SI (of logarithms where they are logarithmic)."""
    offsets_arcsec: Floats
    residual_arcsec: Floats
    """Reading minus model minus offsets."""
    log_marginal: float
    """Log likelihood, the unknowns integrated out, sizes of effects per unit of size."""
    log_size_prior: float
    """What turns that into evidence: the prior density of the sizes."""
    converged: bool
    discrepancy_sd: float = 0.0
    """How far the effects may depart from their forms; see `discrepancy`."""
    log_discrepancy: float = 0.0
    """Log prior of that departure, and what other modes add to the evidence."""
    other_modes: tuple[Fit, ...] = field(default=(), repr=False)
    """The same effects with other values or forms that the readings do not exclude; see `modes`."""
    noise_of_values: Noise = field(default=Noise(), repr=False)
    """The noise under which the values were sought. Where the effects depart from their forms the
    values are still those of the exact forms, and `noise` is what the departure leaves."""
    closing: Closing | None = None
    """How near the values are to the minimum; None where that was not asked for."""
    modes_searched: bool = False
    """Whether other modes were looked for."""
    reached: float = np.inf
    """Misfit with priors at the end of the search under the noise that it began with."""

    def value(self, unknown: Unknown) -> float:
        """SI."""
        return float(self.point.values[unknown.index])

    def u(self, unknown: Unknown) -> float:
        """Standard uncertainty, SI."""
        i = self.unknowns.index(unknown)
        sd = float(np.sqrt(self.covariance[i, i]))
        return sd * abs(self.value(unknown)) if unknown.log else sd

    @property
    def log_evidence(self) -> float:
        """Of the hypothesis, up to a constant that all share."""
        return self.log_marginal + self.log_size_prior + self.log_discrepancy


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """How far the effects of a fit may depart from their equations."""

    functions: Floats
    """Of the columns of the table, which the share of an effect may follow, shape (n, m)."""
    sd: float = 0.0
    """Standard deviation of each of them; 0: the equations hold exactly."""


def may_depart(hypothesis: Hypothesis, unknowns: tuple[Unknown, ...]) -> list[list[int]]:
    """Places of the sizes of each effect that has an equation to depart from.

    Numbers of the drive have none, and a lot of balls is any function already.
    """
    return [
        [i for i, u in enumerate(unknowns) if u.size_of == number]
        for number, v in enumerate(hypothesis.variants)
        if v.effect not in PRIORS and not v.spread
    ]


def linearised(
    problem: Problem, hypothesis: Hypothesis, point: Point, discrepancy: Discrepancy
) -> Linear:
    """Readings less model, columns of unknowns, discrepancies and offsets, prior precisions; in
    arcsec."""
    columns = problem.columns(point)
    y = problem.campaign.y_arcsec - point.angle_arcsec + columns @ problem.at(point).off
    departures = _departures(problem, hypothesis, point, discrepancy)
    x = np.column_stack([columns, departures, problem.campaign.offsets])
    return Linear(y, x, _precisions(problem, departures))


def _precisions(problem: Problem, departures: Floats) -> Floats:
    """Of the priors of unknowns, departures and offsets."""
    flat = np.zeros(problem.offsets.shape[1])
    return np.concatenate([problem.precision, np.ones(departures.shape[1]), flat])


def _departures(
    problem: Problem, hypothesis: Hypothesis, point: Point, discrepancy: Discrepancy
) -> Floats:
    """Columns by which the effects may depart from their equations, of one standard deviation each,
    arcsec, shape (n, k)."""
    found = [np.zeros((len(problem.campaign), 0))]
    if discrepancy.sd:
        columns, size = problem.columns(point), problem.off_mean(point)
        for at in may_depart(hypothesis, problem.unknowns):
            contribution = columns[:, at] @ size[at]
            sd = discrepancy.sd * _own_share(problem, point, size, at)
            found.append(sd * discrepancy_columns(contribution, discrepancy.functions))
    return np.column_stack(found)


def _own_share(problem: Problem, point: Point, size: Floats, at: Sequence[int]) -> float:
    """How much of what an effect contributes the numbers of the drive and the offsets do not take.

    An effect may depart from its form by a share of what it shows itself: one whose contribution
    is that of a number of the drive would lend its departures to anything.
    """
    columns, precision = problem.at(point).x, problem.precision
    known = [i for i in range(len(precision)) if precision[i] > 0 and i not in set(at)]
    contribution = columns[:, at] @ size[at]
    x = np.column_stack([columns[:, known], problem.offsets])
    flat = np.zeros(problem.offsets.shape[1])
    total = float(contribution @ contribution)
    left = Margin.of(contribution, x, np.r_[precision[known], flat]).chi2
    return float(np.sqrt(left / total)) if total > 0 else 0.0


def evaluated(
    problem: Problem,
    hypothesis: Hypothesis,
    reached: tuple[Point, bool],
    discrepancy: Discrepancy,
    stated_dof: float,
) -> Fit:
    """The fit at a point of the search.

    Parameters
    ----------
    reached: the point, and whether the search came to its end there.
    stated_dof: so many repeats the stated uncertainty is worth.
    """
    c, (point, converged) = problem.campaign, reached
    seen, flat = problem.at(point), np.zeros(problem.offsets.shape[1])
    y = seen.y + seen.x @ seen.off
    departures = _departures(problem, hypothesis, point, discrepancy)
    if departures.size:
        departures = problem.whitener(departures)
    x = np.column_stack([seen.x, departures, problem.offsets])
    margin = Margin.of(y, x, _precisions(problem, departures))
    p = len(problem.unknowns)
    covariance = inverse(margin.factor)[:p, :p] * np.outer(problem.unit, problem.unit)
    r = c.y_arcsec - point.angle_arcsec
    offsets = Margin.of(seen.y, problem.offsets, flat).mode
    marginal = log_likelihood(margin.chi2, problem.whitener, margin.log_volume)
    marginal += float(log_scale_prior(np.array(problem.noise.scale), stated_dof))
    marginal -= price_of(problem.noise)
    # The linear problem counts as reached what lies beyond a bound or where no search came.
    within = problem.step(point)[1] if p else 0.0
    exact = margin
    if discrepancy.sd:
        x = np.column_stack([seen.x, problem.offsets])
        exact = Margin.of(y, x, np.r_[problem.precision, flat])
    promised = problem.objective(point) - exact.chi2
    marginal -= 0.5 * (max(promised - within, 0.0) + max(within, 0.0))
    return Fit(
        hypothesis=hypothesis,
        point=point,
        unknowns=problem.unknowns,
        noise=problem.noise,
        whitener=problem.whitener,
        margin=margin,
        covariance=covariance,
        offsets_arcsec=offsets,
        residual_arcsec=r - c.offsets @ offsets,
        log_marginal=marginal,
        log_size_prior=sum(_log_prior_of_sizes(problem, hypothesis, point, covariance)),
        converged=converged,
        noise_of_values=problem.noise,
        discrepancy_sd=discrepancy.sd,
    )


def _log_prior_of_sizes(
    problem: Problem, hypothesis: Hypothesis, point: Point, covariance: Floats
) -> Iterator[float]:
    """Of each variant: see `priors.log_size_prior`."""
    off = problem.off_mean(point)
    own = np.sqrt(np.diag(covariance)) / problem.unit
    for number, variant in enumerate(hypothesis.variants):
        at = [i for i, u in enumerate(problem.unknowns) if u.size_of == number]
        yield float(log_size_prior(variant, off[at], own[at]))
