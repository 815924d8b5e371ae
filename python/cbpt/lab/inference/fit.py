"""One hypothesis fitted: the values of its numbers, the noise, and the evidence for it.

    Hypothesis  which forms of which effects are at work
    Fitter      fits hypotheses to one campaign
    Fit         the outcome
    Race        fits under one noise, of which those far behind are given up

The numbers of the drive and the calibrations are always free within their stated uncertainties.
The fit is the most probable one (Gauss-Newton on whitened residuals and priors, bounds by
projection); the evidence is Laplace's: likelihood at the mode, times prior density, times the
volume of the posterior (MacKay 2003, chapter 28). Sizes of effects are equally likely in the
logarithm over their plausible range.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.noise import (
    FIXED_DOF,
    PRICE,
    STATED_DOF,
    Margin,
    Noise,
    Whitener,
    fit_noise,
    log_likelihood,
    log_scale_prior,
)
from cbpt.lab.model.discrepancy import FORM_ODDS, form_columns, modulations
from cbpt.lab.model.forward import Assembled, Campaign, Point
from cbpt.lab.model.priors import LOT, PRIORS, VARIANTS, Shape, Variant, log_size_prior, lots
from cbpt.lab.model.spring_priors import library_of

Floats = NDArray[np.float64]
_STEPS = 12
# In misfit: two of it are one unit of log-evidence.
_ENOUGH = 0.02
# In log-likelihood: a departure from form that gains less needs no new look at the noise.
_NOISE_WORTH = 2.0
_HOPELESS = 60.0
"""In misfit: a search that stays this far above the best one under the same noise is given up."""


@dataclass(frozen=True)
class Unknown:
    """One free number of a fit. sd: of its normal prior, infinite where there is none.

    A logarithmic unknown is searched in ln(value); its prior then is in the logarithm too.
    """

    index: int
    name: str
    mean: float
    sd: float
    lower: float
    upper: float
    unit: float
    """What one step of the search is, in SI: puts all unknowns on one scale."""
    log: bool = False
    size_of: int = -1
    """Which of the hypothesis's variants it is the size of; -1 for what is no size."""


@dataclass(frozen=True)
class Hypothesis:
    """Forms of effects that are at work together; none: the drive as stated."""

    variants: tuple[Variant, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """Ids, sorted."""
        return tuple(sorted(v.effect for v in self.variants))


@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis at its most probable values."""

    hypothesis: Hypothesis
    point: Point
    unknowns: tuple[Unknown, ...]
    noise: Noise
    whitener: Whitener = field(repr=False)
    margin: Margin = field(repr=False)
    """Residual and columns, whitened; the last columns are the zeros."""
    covariance: Floats = field(repr=False)
    """Of the unknowns, SI (of logarithms where they are logarithmic)."""
    zeros_arcsec: Floats
    residual_arcsec: Floats
    """Reading minus model minus zeros."""
    log_marginal: float
    """Log likelihood, the unknowns integrated out, sizes of effects per unit of size."""
    log_size_prior: float
    """What turns that into evidence: the prior density of the sizes."""
    converged: bool
    form_sd: float = 0.0
    """How far the effects may depart from their forms; see `forms`."""
    log_forms: float = 0.0
    """Log prior of that departure, and what the others add to the evidence."""
    others: tuple[Fit, ...] = field(default=(), repr=False)
    """The same effects with other values or forms that the readings do not exclude; see `peaks`."""
    solved: bool = False
    """Whether others were looked for."""
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
        return self.log_marginal + self.log_size_prior + self.log_forms

    @property
    def rmse_arcsec(self) -> float:
        """Of the residual."""
        return float(np.sqrt(np.mean(self.residual_arcsec**2)))


class Fitter:
    """Fits hypotheses to one campaign: the library assembled once, every effect once."""

    def __init__(self, campaign: Campaign, variants: Sequence[Variant] | None = None) -> None:
        self.campaign = campaign
        balls = campaign.balls
        # What the case has already may turn out to be less.
        given = {effect for effect, _ in campaign.effects if effect not in campaign.own}
        self.library = tuple(library_of(campaign) if variants is None else variants)
        fitting = (v for v in self.library if _needed(campaign, v))
        library = tuple(replace(v, signed=True) if v.effect in given else v for v in fitting)
        self.variants = library + campaign.candidates + (lots(balls) if balls else ())
        self.effects = (
            *dict.fromkeys([*campaign.priors, *campaign.own, *(v.effect for v in self.variants)]),
        )
        # Every ball of a lot is an instance of its own; they come last, one after the other.
        self.effects += (LOT,) * (balls - 1)
        self.model = Assembled(campaign, self.effects)
        self.stated_dof = STATED_DOF if campaign.u_stated else 0.1
        if campaign.u_repeated:
            assert campaign.repeats is not None
            self.stated_dof = min(campaign.repeats.dof, STATED_DOF)
        if campaign.step_arcsec:
            # Rounding errors hide how much they scatter; what is stated stands.
            self.stated_dof = FIXED_DOF
        # Play and friction of a torsion spring change the angle a lot, so a fit needs more steps.
        self.steps = 4 * _STEPS if campaign.drive.kind == "torsion_spring" else _STEPS
        self.modulations = modulations(campaign.readings)

    def with_angles(self, y_arcsec: Floats) -> Fitter:
        """The same model and loads with other measured angles, shape (n,)."""
        other = copy(self)
        other.campaign = replace(self.campaign, y_arcsec=y_arcsec)
        return other

    # --- what is free ---

    def unknowns(self, hypothesis: Hypothesis) -> tuple[Unknown, ...]:
        """Numbers of the drive and calibrations, then sizes and shapes of the effects."""
        wide = {v.effect for v in hypothesis.variants}
        found = []
        for effect, sd in self.campaign.priors.items():
            if effect not in wide and sd > 0:
                variant = next(v for v in VARIANTS if v.effect == effect)
                i, name = self._parameter(effect, variant.sizes[0])
                neutral = float(self.model.neutral[i])
                found.append(Unknown(i, effect, neutral, sd, *self._bounds(i), unit=sd))
        for number, variant in enumerate(hypothesis.variants):
            for size, ratio in zip(
                variant.sizes, variant.ratios or (1.0,) * len(variant.sizes), strict=True
            ):
                i, name = self._parameter(variant.effect, size)
                bounds = self._bounds(i)
                if variant.scaled:
                    bounds = self._scaled(i, variant, ratio)
                neutral, unit = float(self.model.neutral[i]), variant.low * ratio
                sd, owner = (variant.spread, -1) if variant.spread else (np.inf, number)
                found.append(Unknown(i, name, neutral, sd, *bounds, unit=unit, size_of=owner))
            for shape in variant.shapes:
                i, name = self._parameter(variant.effect, shape.name)
                found.append(_unknown_of_shape(i, name, shape))
        return tuple(found)

    def _parameter(self, effect: str, name: str) -> tuple[int, str]:
        return self.model.index(self.effects.index(effect), name), f"{effect}.{name}"

    def _bounds(self, index: int) -> tuple[float, float]:
        """What is plausible, with some room beyond, and neutral in any case."""
        low, high = self.model.likely[index]
        neutral = float(self.model.neutral[index])
        room = 0.0 if low * high > 0 else 2.0 * (high - low)
        low = max(min(low, neutral) - room, self.model.lower[index])
        return float(low), float(min(max(high, neutral) + room, self.model.upper[index]))

    def _scaled(self, index: int, variant: Variant, ratio: float) -> tuple[float, float]:
        """Bounds of a size whose range is the variant's own: three times what is plausible."""
        neutral = float(self.model.neutral[index])
        reach = 3.0 * variant.high * ratio
        low = max(neutral - reach, float(self.model.lower[index])) if variant.signed else neutral
        return min(low, neutral), min(neutral + reach, float(self.model.upper[index]))

    def start(self, hypothesis: Hypothesis, sizes: dict[str, float]) -> Floats:
        """Neutral values, but for `sizes` by parameter (`effect.name`) and what a variant fixes."""
        values = self.model.neutral.copy()
        for variant in hypothesis.variants:
            for name, value in variant.fixed:
                values[self._parameter(variant.effect, name)[0]] = value
            for shape in variant.shapes:
                values[self._parameter(variant.effect, shape.name)[0]] = (
                    np.sqrt(shape.low * shape.high) if shape.log else 0.5 * (shape.low + shape.high)
                )
        for name, value in sizes.items():
            effect, _, parameter = name.partition(".")
            i = self._parameter(effect, parameter)[0]
            values[i] = np.clip(value, self.model.lower[i], self.model.upper[i])
        return values

    # --- fitting ---

    def fit(
        self,
        hypothesis: Hypothesis,
        start: Floats | None = None,
        noise: Noise | None = None,
        free_noise: bool = True,
        bound: float = np.inf,
    ) -> Fit | None:
        """The most probable values of a hypothesis; None where the model has no solution.

        A pure function: nothing that was fitted before changes a bit of what it returns.

        Parameters
        ----------
        start: values to begin with, shape (p,); neutral ones where None.
        noise: the noise to begin with; white noise of the stated size where None.
        free_noise: whether the noise is fitted too.
        bound: a search whose misfit (`Fit.reached`) cannot come below this is given up: the fit is
            then not converged and its evidence is a rough one. See `Race`.
        """
        self.model.cold()
        unknowns = self.unknowns(hypothesis)
        values = self.start(hypothesis, {}) if start is None else start.copy()
        noise = noise or Noise()
        point = self._at(values, unknowns)
        sizes = [u.index for u in unknowns if not u.log and np.isinf(u.sd)]
        for _ in range(6):
            if point is not None:
                break
            # Too much for the preload to hold: nearer to doing nothing.
            values[sizes] = 0.5 * (values[sizes] + self.model.neutral[sizes])
            point = self._at(values, unknowns)
        if point is None:
            return None
        search = _Search(self, unknowns, noise, 0.0, hypothesis.variants)
        point, converged = search.run(point, bound)
        reached = search.objective(point)
        for _ in range(2 if free_noise and reached < bound else int(free_noise)):
            y, x, precision = search.linear(point)
            before = noise
            noise, _ = fit_noise(
                y,
                x,
                precision,
                self.campaign.u_arcsec,
                self.campaign.rows,
                noise,
                self.stated_dof,
                # A fit that was given up needs no finer noise.
                structures=reached < bound,
            )
            search = _Search(self, unknowns, noise, 0.0, hypothesis.variants)
            if _near(before, noise) or reached >= bound:
                break
            point, converged = search.run(point)
        exact = search.outcome(hypothesis, point, converged)
        found = self._of_any_form(exact) if free_noise and search.formed else exact
        return replace(found, reached=reached)

    def _of_any_form(self, exact: Fit) -> Fit:
        """The evidence summed over how far the effects may depart from their forms; noise and
        uncertainty are those of the likeliest departure.
        """
        c = self.campaign
        seen = [exact]
        for sd, _ in FORM_ODDS[1:]:
            loose = self._departed(exact, exact.noise, sd)
            if loose.log_marginal > exact.log_marginal + _NOISE_WORTH:
                noise, _ = fit_noise(
                    *self.linear(loose), c.u_arcsec, c.rows, exact.noise, self.stated_dof
                )
                loose = self._departed(exact, noise, sd)
            seen.append(loose)
        odds = [
            f.log_evidence + np.log(share) for f, (_, share) in zip(seen, FORM_ODDS, strict=True)
        ]
        best = int(np.argmax(odds))
        total = float(np.logaddexp.reduce(odds))
        return replace(seen[best], log_forms=total - seen[best].log_evidence)

    def _departed(self, fit: Fit, noise: Noise, form_sd: float) -> Fit:
        search = _Search(self, fit.unknowns, noise, form_sd, fit.hypothesis.variants)
        return search.outcome(fit.hypothesis, fit.point, fit.converged)

    def misfit(self, hypothesis: Hypothesis, values: Floats, noise: Noise) -> float:
        """What a search from these values would start with; infinite where there is no solution."""
        self.model.cold()
        point = self._at(values, ())
        if point is None:
            return np.inf
        search = _Search(self, self.unknowns(hypothesis), noise, 0.0, hypothesis.variants)
        return search.objective(point)

    def look(self, fit: Fit, noise: Noise) -> Fit:
        """The same values through another noise."""
        return replace(self._departed(fit, noise, fit.form_sd), log_forms=fit.log_forms)

    def at_nominal(self, fit: Fit) -> Fit:
        """The drive exactly as stated but for its zeros, seen through the noise of a fit."""
        search = _Search(self, (), fit.noise)
        self.model.cold()
        return search.outcome(Hypothesis(), self.model.at(self.model.neutral), True)

    def linear(self, fit: Fit) -> tuple[Floats, Floats, Floats]:
        """Readings less model, columns of unknowns and zeros, prior precisions, about a fit; in
        arcsec.
        """
        variants = fit.hypothesis.variants
        return _Search(self, fit.unknowns, fit.noise, fit.form_sd, variants).linear(fit.point)

    def place(self, effect: str, name: str) -> int:
        """Where a parameter stands among the values."""
        return self.model.index(self.effects.index(effect), name)

    def neutral(self, effect: str, name: str) -> float:
        """The value at which a parameter does nothing."""
        return float(self.model.neutral[self.place(effect, name)])

    def _at(self, values: Floats, unknowns: Sequence[Unknown]) -> Point | None:
        point = self.model.at(values, [u.index for u in unknowns])
        known = np.isfinite(point.angle_arcsec).all() and np.isfinite(point.slopes).all()
        return point if known else None


class Race:
    """Fits that begin with one noise, each given up where it cannot come near the best before it.

    The bound follows from the fits of this race alone.
    """

    def __init__(self, fitter: Fitter, noise: Noise) -> None:
        self.fitter, self.noise = fitter, noise
        # How a fit of play and friction begins does not say how it ends.
        large = fitter.campaign.drive.kind == "torsion_spring"
        self._room = np.inf if large else _HOPELESS
        self._best = np.inf

    def fit(self, hypothesis: Hypothesis, start: Floats, free_noise: bool = True) -> Fit | None:
        """As `Fitter.fit`."""
        bound = self._best + self._room
        found = self.fitter.fit(hypothesis, start, self.noise, free_noise, bound)
        if found is not None:
            self._best = min(self._best, found.reached)
        return found


def _unknown_of_shape(index: int, name: str, shape: Shape) -> Unknown:
    low, high = (np.log(shape.low), np.log(shape.high)) if shape.log else (shape.low, shape.high)
    # A normal prior as wide as the uniform one over the range.
    sd = float((high - low) / np.sqrt(12))
    return Unknown(
        index, name, float((low + high) / 2), sd, shape.low, shape.high, unit=sd, log=shape.log
    )


def _near(one: Noise, other: Noise) -> bool:
    """Whether a fit would not move from one noise to the other."""
    return (
        abs(np.log(one.scale / other.scale)) < 0.03
        and abs(one.correlation - other.correlation) < 0.03
        and one.offset_arcsec == other.offset_arcsec == 0.0
    )


def _needed(campaign: Campaign, variant: Variant) -> bool:
    return not variant.needs or getattr(campaign.readings, variant.needs) is not None


class _Search:
    """Gauss-Newton for one set of unknowns and one noise, in steps of each unknown's own unit."""

    def __init__(
        self,
        fitter: Fitter,
        unknowns: tuple[Unknown, ...],
        noise: Noise,
        form_sd: float = 0.0,
        variants: tuple[Variant, ...] = (),
    ) -> None:
        self.fitter, self.unknowns, self.noise = fitter, unknowns, noise
        self.form_sd, self.variants = form_sd, variants
        # Numbers of the drive have no form, and a lot of balls is any form already.
        self.formed = [
            [i for i, u in enumerate(unknowns) if u.size_of == number]
            for number, v in enumerate(variants)
            if v.effect not in PRIORS and not v.spread
        ]
        c = fitter.campaign
        self.whitener = Whitener.of(noise, c.u_arcsec, c.rows)
        self.zeros = self.whitener(c.zeros)
        self.mean = np.array([u.mean for u in unknowns])
        self.unit = np.array([u.unit for u in unknowns])
        self.precision = np.array([(u.unit / u.sd) ** 2 for u in unknowns])
        self.log = np.array([u.log for u in unknowns], dtype=bool)
        self.index = np.array([u.index for u in unknowns], dtype=int)
        bounds = np.array([[u.lower, u.upper] for u in unknowns]).reshape(-1, 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.low, self.high = np.where(self.log[:, None], np.log(bounds), bounds).T

    def coordinates(self, point: Point) -> Floats:
        v = point.values[self.index]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(self.log, np.log(v), v))

    def columns(self, point: Point) -> Floats:
        """Slopes by one step of each unknown, arcsec."""
        v = np.where(self.log, point.values[self.index], 1.0)
        return np.asarray(point.slopes * (v * self.unit))

    def off(self, point: Point) -> Floats:
        """Unknowns off the mean of their priors, in units; 0 where there is no prior."""
        return np.where(self.precision > 0, (self.coordinates(point) - self.mean) / self.unit, 0.0)

    def objective(self, point: Point) -> float:
        """Whitened misfit after the best zeros, and priors."""
        r = self.whitener(self.fitter.campaign.y_arcsec - point.angle_arcsec)
        margin = Margin.of(r, self.zeros, np.zeros(self.zeros.shape[1]))
        return margin.chi2 + float(self.precision @ self.off(point) ** 2)

    def run(self, point: Point, bound: float = np.inf) -> tuple[Point, bool]:
        """Steps until none promises to gain, or until what the last one promises stays above
        `bound`.
        """
        value = self.objective(point)
        for number in range(self.fitter.steps):
            step, promised = self.step(point)
            if promised < _ENOUGH:
                return point, True
            if number > 1 and value - 2 * promised > bound:
                return point, False
            for _ in range(4):
                candidate = self.moved(point, step)
                got = np.inf if candidate is None else self.objective(candidate)
                if got < value:
                    break
                step = step / 3
            else:
                return point, False
            assert candidate is not None
            gained, value = value - got, got
            accepted = self.fitter._at(candidate.values, self.unknowns)
            if accepted is None:
                return point, False
            point = accepted
            if gained < _ENOUGH:
                return point, True
        return point, False

    def moved(self, point: Point, step: Floats) -> Point | None:
        x = np.clip(self.coordinates(point) + step * self.unit, self.low, self.high)
        values = point.values.copy()
        values[self.index] = np.where(self.log, np.exp(np.where(self.log, x, 0.0)), x)
        # Without slopes: most of the cost is saved where the step is refused.
        return self.fitter._at(values, ())

    def step(self, point: Point) -> tuple[Floats, float]:
        """The step in units that the linear problem asks for within the bounds, and what it
        promises.
        """
        y = self.whitener(self.fitter.campaign.y_arcsec - point.angle_arcsec)
        j = self.whitener(self.columns(point))
        at = self.coordinates(point)
        p = len(self.unknowns)
        step = np.zeros(p)
        free = np.ones(p, dtype=bool)
        start = self.off(point)
        for _ in range(p + 1):
            # The prior's own pull: its residual is where the unknown stands now.
            x = np.column_stack([j[:, free], self.zeros])
            precision = np.r_[self.precision[free], np.zeros(self.zeros.shape[1])]
            held = y - j[:, ~free] @ step[~free]
            a = x.T @ x + np.diag(precision)
            a[np.diag_indices_from(a)] *= 1 + 1e-10
            a[np.diag_indices_from(a)] += 1e-12 * max(float(np.trace(a)), 1e-300) / len(a)
            b = x.T @ held
            b[: free.sum()] -= self.precision[free] * start[free]
            step[free] = np.linalg.solve(a, b)[: free.sum()]
            goal = at + step * self.unit
            out = free & ((goal < self.low - 1e-15) | (goal > self.high + 1e-15))
            if not out.any():
                break
            step[out] = (np.clip(goal, self.low, self.high) - at)[out] / self.unit[out]
            free &= ~out
        now = Margin.of(y, self.zeros, np.zeros(self.zeros.shape[1])).chi2 + float(
            self.precision @ start**2
        )
        then = Margin.of(y - j @ step, self.zeros, np.zeros(self.zeros.shape[1])).chi2
        then += float(self.precision @ np.where(self.precision > 0, start + step, 0.0) ** 2)
        return step, now - then

    def linear(self, point: Point) -> tuple[Floats, Floats, Floats]:
        """The problem linearised here: y, columns with zeros, precision; unknowns count from the
        prior's mean.
        """
        c = self.fitter.campaign
        columns = self.columns(point)
        y = c.y_arcsec - point.angle_arcsec + columns @ self.off(point)
        forms = self.forms(point, columns)
        x = np.column_stack([columns, forms, c.zeros])
        zeros = np.zeros(c.zeros.shape[1])
        return y, x, np.r_[self.precision, np.ones(forms.shape[1]), zeros]

    def forms(self, point: Point, columns: Floats) -> Floats:
        """What effects may show beside their forms, each column of unit prior, arcsec."""
        found = [np.zeros((len(columns), 0))]
        if self.form_sd:
            size = (self.coordinates(point) - self.mean) / self.unit
            for at in self.formed:
                contribution = columns[:, at] @ size[at]
                found.append(self.form_sd * form_columns(contribution, self.fitter.modulations))
        return np.column_stack(found)

    def outcome(self, hypothesis: Hypothesis, point: Point, converged: bool) -> Fit:
        c = self.fitter.campaign
        y, x, precision = self.linear(point)
        margin = Margin.of(self.whitener(y), self.whitener(x), precision)
        p = len(self.unknowns)
        inverse = np.linalg.inv(margin.factor)
        covariance = (inverse.T @ inverse)[:p, :p] * np.outer(self.unit, self.unit)
        r = c.y_arcsec - point.angle_arcsec
        zeros = Margin.of(self.whitener(r), self.zeros, np.zeros(self.zeros.shape[1])).mode
        residual = r - c.zeros @ zeros
        marginal = log_likelihood(margin.chi2, self.whitener, margin.log_volume)
        marginal += log_scale_prior(self.noise.scale, self.fitter.stated_dof)
        marginal -= PRICE * self.noise.numbers
        if not converged:
            # The linear problem counts as reached what the search did not reach.
            marginal -= 0.5 * max(self.step(point)[1], 0.0)
        return Fit(
            hypothesis=hypothesis,
            point=point,
            unknowns=self.unknowns,
            noise=self.noise,
            whitener=self.whitener,
            margin=margin,
            covariance=covariance,
            zeros_arcsec=zeros,
            residual_arcsec=residual,
            log_marginal=marginal,
            log_size_prior=sum(self.log_prior_of_sizes(hypothesis, point, covariance)),
            converged=converged,
            form_sd=self.form_sd,
        )

    def log_prior_of_sizes(
        self, hypothesis: Hypothesis, point: Point, covariance: Floats
    ) -> Iterator[float]:
        """Of each variant: see `library.log_size_prior`."""
        off = (self.coordinates(point) - self.mean) / self.unit
        own = np.sqrt(np.diag(covariance)) / self.unit
        for number, variant in enumerate(hypothesis.variants):
            at = [i for i, u in enumerate(self.unknowns) if u.size_of == number]
            yield float(log_size_prior(variant, off[at], own[at]))
