"""Hypotheses fitted to one data set.

Fitter  the library assembled once; fits one hypothesis, with its noise
Race    fits under one noise, of which those far behind are given up

The numbers of the drive and the calibrations are always free within their stated uncertainties.
Noise and values are found in turns: the most probable values under a noise (`gauss_newton`), then
the noise that makes their residuals most likely (`fit_noise`). The evidence (`evidence`) is summed
over how far the effects may depart from their equations (`discrepancy`).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import HIDDEN_DOF, STATED_DOF, fit_noise
from cbpt.lab.covariance.linear_gaussian import Linear, Noise
from cbpt.lab.inference.evidence import Fit, Ground, evaluated, linearised, may_depart
from cbpt.lab.inference.gauss_newton import Problem, point_at, search
from cbpt.lab.inference.hypothesis import Hypothesis, Unknown, unknown_of_shape
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.discrepancy import DISCREPANCY_ODDS, modulations
from cbpt.lab.model.forward import Assembled, Point
from cbpt.lab.model.own_loops import CENTRE, FRICTION, LOAD_SHARE, PLAY, small_loops_of
from cbpt.lab.model.priors import LOT, VARIANTS, Variant, lots, no_quicker
from cbpt.lab.model.spring_priors import library_of

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Search:
    """When a search ends."""

    steps: int = 40
    noise_worth: float = 2.0
    """In log-likelihood: a departure from form that gains less needs no new look at the noise."""
    stated_room: float = 6.0
    """In stated uncertainties: how far a number of the drive or a calibration may move, whatever
    is plausible where nothing is stated."""
    hopeless: float = 60.0
    """In misfit: a search that stays this far above the best one under the same noise is given
    up.
    """


_SEARCH = _Search()


@dataclass(frozen=True)
class _How:
    """How a fit is searched: the arguments of `Fitter.fit`."""

    start: Floats | None
    noise: Noise | None
    free_noise: bool
    bound: float
    base: Fit | None


class Fitter:
    """Fits hypotheses to one campaign: the library assembled once, every effect once."""

    def __init__(
        self,
        campaign: Campaign,
        variants: Sequence[Variant] | None = None,
        asked: Sequence[str] = (),
    ) -> None:
        self.campaign = campaign
        balls = campaign.balls
        # What the case has already may turn out to be less.
        given = {effect for effect, _ in campaign.effects if effect not in campaign.own}
        self.library = tuple(library_of(campaign, asked) if variants is None else variants)
        step_s = campaign.step_s
        fitting = (
            seen
            for v in self.library
            if not v.lacks(campaign.readings) and (seen := no_quicker(v, step_s)) is not None
        )
        library = tuple(replace(v, signed=True) if v.effect in given else v for v in fitting)
        self.variants = library + campaign.candidates + (lots(balls) if balls else ())
        # Of variants that are given all have a place, also those that this table cannot show: what
        # fitters of several tables know is then put from one to another place by place.
        placed = (v.effect for v in (*(variants or ()), *self.variants))
        self.effects = (*dict.fromkeys([*campaign.priors, *campaign.own, *placed]),)
        # Every ball of a lot is an instance of its own; they come last, one after the other.
        self.effects += (LOT,) * (balls - 1)
        self.model = Assembled(campaign, self.effects)
        self.stated_dof = STATED_DOF if campaign.u_stated else 0.1
        if campaign.u_repeated:
            assert campaign.repeats is not None
            self.stated_dof = min(campaign.repeats.dof, STATED_DOF)
        if campaign.step_arcsec:
            # What scatters beside the rounding is hardly seen.
            self.stated_dof = HIDDEN_DOF
        # Play and friction of a torsion spring change the angle a lot, so a fit needs more steps.
        self.steps = 2 * _SEARCH.steps if campaign.drive.kind == "torsion_spring" else _SEARCH.steps
        self.ranks = False
        """Whether fits are only ranked."""
        self.functions = modulations(campaign.readings)
        loops = small_loops_of(campaign)
        self.most = {
            PLAY: np.inf if loops is None else loops.play_rad,
            FRICTION: np.inf if loops is None else loops.friction_Nm,
        }
        """Largest sizes that do not contradict the table's own smaller loops, by name."""
        self.small_Nm = 0.0 if loops is None else loops.amplitude_Nm

    def beside(self) -> Fitter:
        """Another one like it, for a thread of its own."""
        other = copy(self)
        other.model = self.model.beside()
        return other

    def roughly(self) -> Fitter:
        """The same for fits that are only ranked: their searches end sooner, and are not told to
        have come to their end."""
        other = copy(self)
        other.ranks = True
        return other

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
                bounds = self._bounds(i, _SEARCH.stated_room * sd)
                found.append(Unknown(i, effect, neutral, sd, *bounds, unit=sd))
        for number, variant in enumerate(hypothesis.variants):
            for size, ratio in zip(
                variant.sizes, variant.ratios or (1.0,) * len(variant.sizes), strict=True
            ):
                i, name = self._parameter(variant.effect, size)
                bounds = self._bounds(i)
                if variant.scaled:
                    bounds = self._scaled(i, name, variant, ratio)
                neutral, unit = float(self.model.neutral[i]), variant.low * ratio
                sd, owner = (variant.spread, -1) if variant.spread else (np.inf, number)
                found.append(Unknown(i, name, neutral, sd, *bounds, unit=unit, size_of=owner))
            for shape in variant.shapes:
                i, name = self._parameter(variant.effect, shape.name)
                found.append(unknown_of_shape(i, name, shape))
        return tuple(found)

    def _parameter(self, effect: str, name: str) -> tuple[int, str]:
        return self.model.index(self.effects.index(effect), name), f"{effect}.{name}"

    def _bounds(self, index: int, about: float = 0.0) -> tuple[float, float]:
        """What is plausible, with some room beyond, and in any case so much about neutral."""
        low, high = self.model.likely[index]
        neutral = float(self.model.neutral[index])
        # What starts at nothing may be larger than is likely, whether or not that has a least size.
        room = 2.0 * (high - low) if low * high <= 0 or neutral == 0 else 0.0
        low = max(min(low - room, neutral - about), self.model.lower[index])
        return float(low), float(min(max(high + room, neutral + about), self.model.upper[index]))

    def _scaled(self, index: int, name: str, variant: Variant, ratio: float) -> tuple[float, float]:
        """Bounds of a size whose range is the variant's own: three times what is plausible."""
        neutral = float(self.model.neutral[index])
        reach = 3.0 * variant.high * ratio
        ends = [end for s in variant.shapes if s.name == CENTRE for end in (s.low, s.high)]
        centre = max(map(abs, ends), default=0.0)
        # Loops that go beyond where a play lies are wide there, and not at zero torque.
        if centre == 0 or centre >= self.small_Nm:
            reach = min(reach, self.most.get(name, np.inf))
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
        base: Fit | None = None,
    ) -> Fit | None:
        """The most probable values of a hypothesis; None where the model has no solution, or its
        forms contradict each other.

        A pure function: nothing that was fitted before changes a bit of what it returns.

        Parameters
        ----------
        start: values to begin with, shape (p,); neutral ones where None.
        noise: the noise to begin with; white noise of the stated size where None.
        free_noise: whether the noise is fitted too.
        bound: a search whose misfit (`Fit.reached`) cannot come below this is given up: the fit is
            then not converged and its evidence is a rough one. See `Race`.
        base: a fit of some of the effects. The search begins nearer to it where the start follows
            the readings worse: of a form that hardly shows when small the linear problem asks for
            sizes that the model does not follow (Nocedal and Wright 2006, section 3.1).
        """
        if hypothesis.contradicts_itself:
            return None
        unknowns = self.unknowns(hypothesis)
        how = _How(start, noise, free_noise, bound, base)
        found = self._fit(hypothesis, unknowns, how)
        if found is None or not self._more_than_small_loops_allow(unknowns, found.point.values):
            return found
        within = [self._within(unknowns, found.point.values)]
        if start is not None and 0 < self._friction(unknowns, start) <= self.most[FRICTION]:
            within.append(self._within(unknowns, start))
        tried = []
        for bounded in within:
            values = found.point.values.copy()
            for u in bounded:
                values[u.index] = np.clip(values[u.index], u.lower, u.upper)
            tried.append(self._fit(hypothesis, bounded, replace(how, start=values, base=None)))
        solved = [fit for fit in tried if fit is not None]
        return max(solved, key=lambda fit: fit.log_evidence, default=None)

    def _friction(self, unknowns: tuple[Unknown, ...], values: Floats) -> float:
        """Friction at the ends of the small loops where it grows with the load, N m; else 0."""
        at = {u.name: float(values[u.index]) for u in unknowns}
        grows = {FRICTION, LOAD_SHARE} <= at.keys()
        return at[FRICTION] + at[LOAD_SHARE] * self.small_Nm if grows else 0.0

    def _more_than_small_loops_allow(self, unknowns: tuple[Unknown, ...], values: Floats) -> bool:
        return self._friction(unknowns, values) > self.most[FRICTION] * (1 + 1e-6)

    def _within(self, unknowns: tuple[Unknown, ...], values: Floats) -> tuple[Unknown, ...]:
        """Unknowns with friction and its share of the load bounded in the ratio of some values, so
        that both together are no more than what the small loops allow at their ends."""
        share = self.most[FRICTION] / max(self._friction(unknowns, values), 1e-300)
        return tuple(
            replace(u, upper=min(u.upper, max(share * float(values[u.index]), u.lower)))
            if u.name in (FRICTION, LOAD_SHARE)
            else u
            for u in unknowns
        )

    def _fit(self, hypothesis: Hypothesis, unknowns: tuple[Unknown, ...], how: _How) -> Fit | None:
        """As `fit`, within given bounds."""
        start, base, bound, free_noise = how.start, how.base, how.bound, how.free_noise
        self.model.cold()
        values = self.start(hypothesis, {})
        if start is not None:
            # Nothing else: of a form that this hypothesis does not have no number may be at work.
            own = [u.index for u in unknowns]
            values[own] = start[own]
        noise = how.noise or self.campaign.plain_noise
        problem = self._problem(unknowns, noise)
        least = self._problem(base.unknowns, noise).objective(base.point) if base else np.inf
        nothing = self.model.neutral if base is None else base.point.values
        point = point_at(self.model, values, unknowns)
        known = {u.index for u in base.unknowns} if base else set()
        back = [u.index for u in unknowns if u.index in known or (not u.log and np.isinf(u.sd))]
        # What the priors of new shapes ask is no less where their effect does nothing.
        least += problem.prior(values, [u.index not in back for u in unknowns])
        for _ in range(6):
            if point is not None and (base is None or problem.objective(point) < least):
                break
            # Too much for the preload to hold, or for the model to follow: nearer to doing nothing.
            values[back] = 0.5 * (values[back] + nothing[back])
            point = point_at(self.model, values, unknowns)
        if point is None:
            return None
        point, converged = search(problem, point, self.steps, bound, self.ranks)
        reached = problem.objective(point)
        for _ in range(2 if free_noise and reached < bound else int(free_noise)):
            before = noise
            noise, _ = fit_noise(
                linearised(self._ground(problem, hypothesis, point), 0.0),
                self.campaign.u_arcsec,
                self.campaign.rows,
                noise,
                self.stated_dof,
                # A fit that was given up needs no finer noise.
                structures=reached < bound,
            )
            problem = problem.under(noise)
            if _near(before, noise) or reached >= bound:
                break
            point, converged = search(problem, point, self.steps, ranked=self.ranks)
        ground = self._ground(problem, hypothesis, point)
        found = evaluated(ground, converged and not self.ranks, 0.0, self.stated_dof)
        if free_noise and may_depart(hypothesis, unknowns):
            found = self._with_discrepancy(found, ground)
        return replace(found, reached=reached)

    def _with_discrepancy(self, exact: Fit, ground: Ground) -> Fit:
        """The evidence summed over how far the effects may depart from their forms; noise and
        uncertainty are those of the likeliest departure.

        ground: that of the fit.
        """
        c, dof = self.campaign, self.stated_dof
        seen = [exact]
        for sd, _ in DISCREPANCY_ODDS[1:]:
            loose = evaluated(ground, exact.converged, sd, dof)
            if loose.log_marginal > exact.log_marginal + _SEARCH.noise_worth:
                noise, _ = fit_noise(
                    linearised(ground, sd), c.u_arcsec, c.rows, exact.noise, self.stated_dof
                )
                other = self._ground(ground.problem.under(noise), exact.hypothesis, exact.point)
                loose = evaluated(other, exact.converged, sd, dof)
            seen.append(loose)
        odds = [
            f.log_evidence + np.log(share)
            for f, (_, share) in zip(seen, DISCREPANCY_ODDS, strict=True)
        ]
        best = int(np.argmax(odds))
        total = float(np.logaddexp.reduce(odds))
        return replace(
            seen[best],
            log_discrepancy=total - seen[best].log_evidence,
            noise_of_values=exact.noise,
        )

    def _ground(self, problem: Problem, hypothesis: Hypothesis, point: Point) -> Ground:
        return Ground(problem, hypothesis, point, self.functions)

    def _departed(
        self, fit: Fit, problem: Problem, reached: tuple[Point, bool] | None = None
    ) -> Fit:
        """A fit with its departures as a problem sees it; at its values or others."""
        point, converged = reached or (fit.point, fit.converged)
        ground = self._ground(problem, fit.hypothesis, point)
        return evaluated(ground, converged, fit.discrepancy_sd, self.stated_dof)

    def moved(self, fit: Fit, reached: tuple[Point, bool]) -> Fit:
        """The same fit, noise and departures, at another point (and whether it is the end of a
        search); other modes stay."""
        return replace(
            self._departed(fit, self._problem(fit.unknowns, fit.noise), reached),
            log_discrepancy=fit.log_discrepancy,
            noise_of_values=fit.noise_of_values,
            other_modes=fit.other_modes,
            modes_searched=fit.modes_searched,
            reached=fit.reached,
        )

    def _problem(self, unknowns: tuple[Unknown, ...], noise: Noise) -> Problem:
        return Problem(self.campaign, self.model, unknowns, noise)

    def misfit(self, hypothesis: Hypothesis, values: Floats, noise: Noise) -> float:
        """What a search from these values would start with; infinite where there is no solution."""
        self.model.cold()
        point = point_at(self.model, values, ())
        if point is None:
            return np.inf
        return self._problem(self.unknowns(hypothesis), noise).objective(point)

    def look(self, fit: Fit, noise: Noise) -> Fit:
        """The same values through another noise."""
        return replace(
            self._departed(fit, self._problem(fit.unknowns, noise)),
            log_discrepancy=fit.log_discrepancy,
        )

    def at_nominal(self, fit: Fit) -> Fit:
        """The drive exactly as stated but for its offsets, seen through the noise of a fit."""
        self.model.cold()
        problem, point = self._problem((), fit.noise), self.model.at(self.model.neutral)
        return evaluated(self._ground(problem, Hypothesis(), point), True, 0.0, self.stated_dof)

    def linear(self, fit: Fit) -> Linear:
        """Readings less model, columns of unknowns and offsets, prior precisions, about a fit; in
        arcsec.
        """
        problem = self._problem(fit.unknowns, fit.noise)
        return linearised(self._ground(problem, fit.hypothesis, fit.point), fit.discrepancy_sd)

    def place(self, effect: str, name: str) -> int:
        """Where a parameter stands among the values."""
        return self.model.index(self.effects.index(effect), name)

    def neutral(self, effect: str, name: str) -> float:
        """The value at which a parameter does nothing."""
        return float(self.model.neutral[self.place(effect, name)])


class Race:
    """Fits that begin with one noise, each given up where it cannot come near the best before it.

    The bound follows from the fits of this race alone.
    """

    def __init__(self, fitter: Fitter, noise: Noise) -> None:
        self.fitter, self.noise = fitter, noise
        # How a fit of play and friction begins does not say how it ends.
        large = fitter.campaign.drive.kind == "torsion_spring"
        self._room = np.inf if large else _SEARCH.hopeless
        self._best = np.inf

    def against(self, fit: Fit) -> None:
        """As if a fit had run, to its values."""
        reached = self.fitter.misfit(fit.hypothesis, fit.point.values, self.noise)
        self._best = min(self._best, reached)

    def fit(
        self,
        hypothesis: Hypothesis,
        start: Floats,
        free_noise: bool = True,
        base: Fit | None = None,
    ) -> Fit | None:
        """As `Fitter.fit`."""
        bound = self._best + self._room
        found = self.fitter.fit(hypothesis, start, self.noise, free_noise, bound, base)
        if found is not None:
            self._best = min(self._best, found.reached)
        return found


def _near(one: Noise, other: Noise) -> bool:
    """Whether a fit would not move from one noise to the other."""
    return (
        abs(np.log(one.scale / other.scale)) < 0.03
        and abs(one.correlation - other.correlation) < 0.03
        and one.offset_arcsec == other.offset_arcsec == 0.0
    )
