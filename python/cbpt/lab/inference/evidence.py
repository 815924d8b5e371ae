"""A hypothesis at its most probable values, and its evidence.

Fit          values, uncertainties, noise, evidence
Closing      how near the values of a fit are to the minimum
Ground       a hypothesis at a point of the search
evaluated    the fit there
linearised   its linear problem

The evidence is Laplace's: likelihood at the mode, times prior density, times the volume of the
posterior (MacKay 2003, chapter 28). Sizes of effects are equally likely in the logarithm over their
plausible range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

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
from cbpt.lab.inference.hypothesis import Hypothesis, Unknown, places_of_sizes
from cbpt.lab.model.discrepancy import discrepancy_columns
from cbpt.lab.model.forward import Point
from cbpt.lab.model.priors import PRIORS, log_prior_of_sizes

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


def may_depart(hypothesis: Hypothesis, unknowns: tuple[Unknown, ...]) -> list[list[int]]:
    """Places of the sizes of each effect that has an equation to depart from.

    Numbers of the drive have none, and a lot of balls is any function already.
    """
    places = places_of_sizes(hypothesis.variants, unknowns)
    return [
        at
        for v, at in zip(hypothesis.variants, places, strict=True)
        if v.effect not in PRIORS and not v.spread
    ]


class Ground:
    """A hypothesis at a point of the search, with what is the same however far its effects may
    depart from their equations.

    functions: of the columns of the table, which the share of an effect may follow, shape (n, m).
    """

    def __init__(
        self, problem: Problem, hypothesis: Hypothesis, point: Point, functions: Floats
    ) -> None:
        self.problem, self.hypothesis, self.point = problem, hypothesis, point
        self._functions = functions
        self.seen = problem.at(point)

    @cached_property
    def x(self) -> Floats:
        """Columns of the unknowns, whitened."""
        return self.seen.x

    @cached_property
    def y(self) -> Floats:
        """Readings less model with the unknowns at the means of their priors, whitened."""
        return np.asarray(self.seen.y + self.x @ self.seen.off)

    @cached_property
    def columns(self) -> Floats:
        """Of the unknowns, arcsec."""
        return self.problem.columns(self.point)

    @cached_property
    def flat(self) -> Floats:
        """Precisions of the offsets."""
        return np.zeros(self.problem.offsets.shape[1])

    @cached_property
    def offsets(self) -> Floats:
        """The most probable ones, the unknowns where they are."""
        return Margin.of(self.seen.y, self.problem.offsets, self.flat).mode

    @cached_property
    def exact(self) -> Margin:
        """Unknowns and offsets taken out, the equations taken for right."""
        x = np.column_stack([self.x, self.problem.offsets])
        return Margin.of(self.y, x, np.r_[self.problem.precision, self.flat])

    @cached_property
    def promised(self) -> float:
        """What a step within the bounds would gain."""
        return self.problem.step(self.point)[1] if len(self.problem.unknowns) else 0.0

    @cached_property
    def departures(self) -> Floats:
        """Columns by which the effects may depart from their equations, of one standard deviation
        each, in arcsec, where each function of the columns has one of all of the share, (n, k)."""
        found = [np.zeros((len(self.problem.campaign), 0))]
        size = self.problem.off_mean(self.point)
        for at in may_depart(self.hypothesis, self.problem.unknowns):
            contribution = self.columns[:, at] @ size[at]
            own = self._own_share(size, at)
            found.append(own * discrepancy_columns(contribution, self._functions))
        return np.column_stack(found)

    @cached_property
    def departures_seen(self) -> Floats:
        """The same, whitened."""
        return self.problem.whitener(self.departures) if self.departures.size else self.departures

    def _own_share(self, size: Floats, at: Sequence[int]) -> float:
        """How much of what an effect contributes the numbers of the drive and the offsets do not
        take.

        An effect may depart from its form by a share of what it shows itself: one whose
        contribution is that of a number of the drive would lend its departures to anything.
        """
        precision = self.problem.precision
        known = [i for i in range(len(precision)) if precision[i] > 0 and i not in set(at)]
        contribution = self.x[:, at] @ size[at]
        x = np.column_stack([self.x[:, known], self.problem.offsets])
        total = float(contribution @ contribution)
        left = Margin.of(contribution, x, np.r_[precision[known], self.flat]).chi2
        return float(np.sqrt(left / total)) if total > 0 else 0.0


def linearised(ground: Ground, discrepancy_sd: float) -> Linear:
    """Readings less model, columns of unknowns, discrepancies and offsets, prior precisions; in
    arcsec.

    discrepancy_sd: how far the effects may depart from their equations; 0: these hold exactly.
    """
    problem, columns = ground.problem, ground.columns
    y = problem.campaign.y_arcsec - ground.point.angle_arcsec + columns @ ground.seen.off
    departures = [discrepancy_sd * ground.departures] if discrepancy_sd else []
    x = np.column_stack([columns, *departures, problem.campaign.offsets])
    return Linear(y, x, _precisions(ground, x))


def _precisions(ground: Ground, x: Floats) -> Floats:
    """Of the priors of unknowns, departures and offsets, which are the columns."""
    own = ground.problem.precision
    return np.concatenate([own, np.ones(x.shape[1] - len(own) - len(ground.flat)), ground.flat])


def evaluated(ground: Ground, converged: bool, discrepancy_sd: float, stated_dof: float) -> Fit:
    """The fit at a point of the search.

    Parameters
    ----------
    converged: whether the search came to its end there.
    discrepancy_sd: how far the effects may depart from their equations; 0: these hold exactly.
    stated_dof: so many repeats the stated uncertainty is worth.
    """
    problem, hypothesis, point = ground.problem, ground.hypothesis, ground.point
    c, margin = problem.campaign, ground.exact
    if discrepancy_sd:
        departures = discrepancy_sd * ground.departures_seen
        x = np.column_stack([ground.x, departures, problem.offsets])
        margin = Margin.of(ground.y, x, _precisions(ground, x))
    p = len(problem.unknowns)
    covariance = inverse(margin.factor)[:p, :p] * np.outer(problem.unit, problem.unit)
    marginal = log_likelihood(margin.chi2, problem.whitener, margin.log_volume)
    marginal += float(log_scale_prior(np.array(problem.noise.scale), stated_dof))
    marginal -= price_of(problem.noise)
    # The linear problem counts as reached what lies beyond a bound or where no search came.
    within = ground.promised
    promised = problem.objective(point) - ground.exact.chi2
    marginal -= 0.5 * (max(promised - within, 0.0) + max(within, 0.0))
    return Fit(
        hypothesis=hypothesis,
        point=point,
        unknowns=problem.unknowns,
        noise=problem.noise,
        whitener=problem.whitener,
        margin=margin,
        covariance=covariance,
        offsets_arcsec=ground.offsets,
        residual_arcsec=c.y_arcsec - point.angle_arcsec - c.offsets @ ground.offsets,
        log_marginal=marginal,
        log_size_prior=_log_prior_of_sizes(problem, hypothesis, point, covariance),
        converged=converged,
        noise_of_values=problem.noise,
        discrepancy_sd=discrepancy_sd,
    )


def _log_prior_of_sizes(
    problem: Problem, hypothesis: Hypothesis, point: Point, covariance: Floats
) -> float:
    """See `priors.log_prior_of_sizes`."""
    places = places_of_sizes(hypothesis.variants, problem.unknowns)
    of_sizes = covariance / np.outer(problem.unit, problem.unit)
    return log_prior_of_sizes(hypothesis.variants, places, problem.off_mean(point), of_sizes)
