"""One model for the campaigns of all levels, with some numbers shared and the others each its own.

    Party       one level: its problem under its own noise, and where its search begins
    Shared      a choice of the numbers that have a value for each level, fitted
    fit_shared  the most probable values of a choice, and its evidence
    foreseen    what evidence a search would reach, by the slopes where another choice ends

The misfits of the levels add up, each through its own noise and without its own offsets. A number
that is shared has one slot for all levels, another one slot for each. Gauss-Newton on the slots;
Laplace's approximation gives the evidence, with one prior for each slot.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cbpt._core import quadratic_step
from cbpt.lab.change.loop_widths import ALIKE_WIDTHS
from cbpt.lab.inference.gauss_newton import Problem, point_at
from cbpt.lab.inference.hypothesis import places_of_sizes
from cbpt.lab.model.forward import Point
from cbpt.lab.model.priors import VARIANTS, Variant, log_prior_of_sizes, log_size_prior

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Effort:
    """How far is searched."""

    steps: int = 25
    enough: float = 0.02
    """Gain in misfit that ends the search; two units of misfit are one of log odds."""
    roughly: float = 0.5
    """The same of fits that are only ranked."""
    looks: int = 4
    """Steps after which a search asks whether it can reach what it should."""


_EFFORT = _Effort()


@dataclass(frozen=True)
class Until:
    """When a search ends."""

    ranked: bool = False
    """Sooner, as the fit is only ranked among others."""
    least: float = -np.inf
    """Where its steps promise no log evidence as high as this."""


@dataclass(frozen=True, eq=False)
class Party:
    """One level under its own noise."""

    problem: Problem
    point: Point
    """The most probable values of the level by itself."""
    log_noise: float
    """What the noise itself adds to the log evidence, whatever the values: with it, choices with
    other effects can be compared too."""
    set_up: Floats | None = None
    """What a new set-up may add to the angles, arcsec, one column for each way; None where that is
    nothing. It is no evidence however much of it there is, and stays where readings count less."""


@dataclass(frozen=True, eq=False)
class Shared:
    """A choice fitted. Coordinates are in the units of the unknowns, shape (slots,)."""

    separate: frozenset[int]
    """Unknowns that have a value for each level."""
    slots: Ints
    """The slot of each unknown at each level, shape (levels, p)."""
    x: Floats
    covariance: Floats
    bounds: tuple[Floats, Floats]
    """Lower and upper ones of the slots, in the same units."""
    points: tuple[Point, ...]
    misfit: float
    """Of the readings, and of the values with what is stated of them."""
    of_readings: float
    log_evidence: float

    def value(self, level: int, unknown: int) -> tuple[float, float]:
        """Coordinate and standard uncertainty of an unknown at a level, in its unit."""
        slot = self.slots[level, unknown]
        return float(self.x[slot]), float(np.sqrt(self.covariance[slot, slot]))

    def differences(self, unknowns: Sequence[int]) -> Iterator[tuple[Floats, Floats]]:
        """What the values of any two levels differ by, shape (k,), and the covariance of that: what
        they share with the other numbers drops out."""
        for a, b in combinations(self.slots[:, list(unknowns)], 2):
            crossed = self.covariance[np.ix_(a, b)]
            own = self.covariance[np.ix_(a, a)] + self.covariance[np.ix_(b, b)]
            yield self.x[a] - self.x[b], own - crossed - crossed.T

    def limit(self, level: int, unknown: int) -> float | None:
        """The bound that a value ends at, in its unit; None where it lies within its range."""
        slot = self.slots[level, unknown]
        low, high = (bound[slot] for bound in self.bounds)
        near = 1e-6 * max(high - low, 1e-300)
        return next((float(b) for b in (low, high) if abs(self.x[slot] - b) <= near), None)

    def ends_at_limit(self, unknowns: Collection[int]) -> bool:
        """Whether some value of one of these ends at a bound, and would go further."""
        return any(
            self.limit(level, unknown) is not None
            for level in range(len(self.slots))
            for unknown in unknowns
        )


def fit_shared(
    parties: Sequence[Party],
    variants: Sequence[Variant],
    separate: frozenset[int],
    start: Sequence[Point] | None = None,
    loose: frozenset[int] = frozenset(),
    until: Until = Until(),
) -> Shared | None:
    """The most probable values with the unknowns in `separate` free at each level; None where the
    model has no solution. start: a point for each level, else those of the levels themselves.
    loose: numbers of drive and rig whose changes do not keep to what is stated of the number."""
    first = parties[0].problem
    slots = _slots(len(parties), len(first.unknowns), separate)
    system = _System(parties, slots, loose)
    x = system.mean_of([p.point for p in parties] if start is None else list(start))
    points = system.points(x)
    # With the values of one level for all where the mean has no solution, and with less of them.
    further = [system.all_of(p) for p in parties]
    further += [system.mean + 0.5 * (other - system.mean) for other in (x, *further)]
    for other in further:
        if points is not None:
            break
        x, points = other, system.points(other)
    if points is None:
        return None
    value = system.objective(points, x)
    enough = _EFFORT.roughly if until.ranked else _EFFORT.enough
    for left in range(_EFFORT.steps, 0, -1):
        step, promised = system.step(points, x)
        if promised < enough:
            break
        if left % _EFFORT.looks == 0 and until.least > -np.inf:
            # Steps promise less and less.
            reached = system.log_evidence(variants, points, x, value)[0]
            if reached + 0.5 * left * promised < until.least:
                break
        moved = system.moved(points, x, step, value)
        if moved is None:
            break
        gained = value - moved[2]
        x, points, value = moved
        if gained < enough:
            break
    log_evidence, covariance = system.log_evidence(variants, points, x, value)
    bounds = system.low, system.high
    of_readings = value - system.of_priors(x)
    return Shared(
        separate, slots, x, covariance, bounds, tuple(points), value, of_readings, log_evidence
    )


def foreseen(
    parties: Sequence[Party],
    variants: Sequence[Variant],
    separate: frozenset[int],
    start: Shared,
) -> float:
    """The log evidence that `fit_shared` from the values of `start` would reach if the model were
    linear from there on: a Wald test of what `start` has apart, a score test of what it shares
    (Buse, American Statistician 36 (1982) 153)."""
    slots = _slots(len(parties), start.slots.shape[1], separate)
    system = _System(parties, slots, frozenset())
    x = system.mean_of(start.points)
    step, value = system.ahead(start.points, x)
    return system.log_evidence(variants, start.points, x + step, value)[0]


def _slots(levels: int, p: int, separate: frozenset[int]) -> Ints:
    slots = np.tile(np.arange(p, dtype=np.int64), (levels, 1))
    fresh = p
    for level in range(1, levels):
        for unknown in sorted(separate):
            slots[level, unknown] = fresh
            fresh += 1
    return slots


def _prior(
    problem: Problem, variants: Sequence[Variant], slots: Ints, x: Floats, covariance: Floats
) -> float:
    """Log prior of the sizes: once for each value that they have, in forms that are the same."""
    off, which, places = x.copy(), [], []
    of_each = places_of_sizes(variants, problem.unknowns)
    for variant, at in zip(variants, of_each, strict=True):
        for place in sorted({tuple(row[at].tolist()) for row in slots}):
            off[list(place)] = x[list(place)] - problem.mean[at] / problem.unit[at]
            which.append(variant if variant not in which else replace(variant, odds=1.0))
            places.append(place)
    return log_prior_of_sizes(which, places, off, covariance)


def _of_changes(
    problem: Problem, slots: Ints, found: tuple[Floats, Floats], loose: frozenset[int]
) -> Iterator[float]:
    """Log priors of the changes of loose numbers since the first level.

    What is stated of a number holds as long as nothing happens to it. What happens between two
    campaigns, an overload of a torque cell or a sensor that is mounted anew, does not keep to the
    uncertainty of its calibration: it is of any size that is plausible.
    """
    x, covariance = found
    for place in sorted(loose):
        variant = next(v for v in VARIANTS if v.effect == problem.unknowns[place].name)
        scale = problem.unit[place] / variant.low
        first = slots[0, place]
        for slot in sorted(set(slots[1:, place].tolist()) - {int(first)}):
            off = np.array([x[slot] - x[first]]) * scale
            own = np.sqrt(covariance[slot, slot]) * scale
            yield log_size_prior(variant, off, np.array([own]))


class _System:
    """The slots' misfit, step and second derivatives; coordinates are in units from zero."""

    def __init__(self, parties: Sequence[Party], slots: Ints, loose: frozenset[int]) -> None:
        self.parties, self.slots, self.loose = parties, slots, loose
        first = parties[0].problem
        count = int(slots.max()) + 1
        owner = np.zeros(count, dtype=np.int64)
        for row in slots:
            owner[row] = np.arange(len(row))
        self.precision = first.precision[owner]
        for place in loose:
            self.precision[list(set(slots[1:, place].tolist()) - {int(slots[0, place])})] = 0.0
        self.mean = (first.mean / first.unit)[owner]
        self.low, self.high = np.full(count, np.inf), np.full(count, -np.inf)
        self.within = np.full(count, np.inf), np.full(count, -np.inf)
        least = np.full(count, np.inf)
        for party, row in zip(parties, slots, strict=True):
            np.minimum.at(self.within[0], row, party.problem.low)
            np.maximum.at(self.within[1], row, party.problem.high)
            high = party.problem.high / first.unit
            np.minimum.at(self.low, row, party.problem.low / first.unit)
            np.maximum.at(self.high, row, high)
            np.minimum.at(least, row, high)
        # A value of its own keeps to what the level's own loops allow; a shared one to what any
        # level's do, as long as that is not far beyond what another's do.
        far = (least < self.high) & (self.high > ALIKE_WIDTHS * least)
        self.high[far] = ALIKE_WIDTHS * least[far]

    def mean_of(self, points: Sequence[Point]) -> Floats:
        """A start: the mean over the levels that share a slot, weighted by what they know of it."""
        total, weight = np.zeros(len(self.mean)), np.full(len(self.mean), 1e-12)
        for party, point, row in zip(self.parties, points, self.slots, strict=True):
            known = np.sum(party.problem.at(point).x_left ** 2, axis=0) + 1e-9
            at = party.problem.coordinates(point) / party.problem.unit
            np.add.at(total, row, known * at)
            np.add.at(weight, row, known)
        return np.asarray(np.clip(total / weight, self.low, self.high))

    def all_of(self, party: Party) -> Floats:
        """A start: the values of one level for all."""
        x = np.zeros(len(self.mean))
        for row in self.slots:
            x[row] = party.problem.coordinates(party.point) / party.problem.unit
        return np.clip(x, self.low, self.high)

    def points(self, x: Floats) -> list[Point] | None:
        """The model of each level there."""
        found = []
        for party, row in zip(self.parties, self.slots, strict=True):
            problem = party.problem
            # A bound in units, times its unit, may lie beyond the bound by rounding.
            at = np.clip(x[row] * problem.unit, *(bound[row] for bound in self.within))
            values = problem.values_at(party.point.values, at)
            point = point_at(problem.model, values, problem.unknowns)
            if point is None:
                return None
            found.append(point)
        return found

    def objective(self, points: Sequence[Point], x: Floats) -> float:
        """Whitened misfit after the best offsets of each level, and priors."""
        total = self.of_priors(x)
        for party, point in zip(self.parties, points, strict=True):
            left = party.problem.at(point).y_left
            total += float(left @ left)
        return total

    def of_priors(self, x: Floats) -> float:
        """What the priors add to the misfit."""
        return float(self.precision @ (x - self.mean) ** 2)

    def _normal(self, points: Sequence[Point]) -> tuple[Floats, Floats]:
        """Second derivatives and slopes of half the misfit, without priors."""
        n = len(self.mean)
        gram, push = np.zeros((n, n)), np.zeros(n)
        for party, point, row in zip(self.parties, points, self.slots, strict=True):
            seen = party.problem.at(point)
            gram[np.ix_(row, row)] += seen.x_left.T @ seen.x_left
            push[row] += seen.x_left.T @ seen.y_left
        return gram, push

    def gram(self, points: Sequence[Point]) -> Floats:
        """Second derivatives with the priors; a size that nothing shows is known to a unit."""
        gram = self._normal(points)[0] + np.diag(self.precision)
        gram[np.diag_indices_from(gram)] += 1e-6
        return gram

    def log_evidence(
        self, variants: Sequence[Variant], points: Sequence[Point], x: Floats, value: float
    ) -> tuple[float, Floats]:
        """By Laplace's approximation there, and the covariance of the slots. value: the misfit."""
        gram = self.gram(points)
        covariance: Floats = np.linalg.inv(gram).astype(np.float64)
        first, prior = self.parties[0].problem, self.precision[self.precision > 0]
        found = -0.5 * value - 0.5 * float(np.linalg.slogdet(gram)[1])
        found += 0.5 * float(np.sum(np.log(prior)))
        found += _prior(first, variants, self.slots, x, covariance)
        found += float(sum(_of_changes(first, self.slots, (x, covariance), self.loose)))
        return found + sum(party.log_noise for party in self.parties), covariance

    def step(self, points: Sequence[Point], x: Floats) -> tuple[Floats, float]:
        """The step within the bounds, and what it promises to gain."""
        return self._within(*self._normal(points), x)

    def _within(self, gram: Floats, push: Floats, x: Floats) -> tuple[Floats, float]:
        gram += np.diag(self.precision)
        gram[np.diag_indices_from(gram)] *= 1 + 1e-10
        gram[np.diag_indices_from(gram)] += 1e-9
        push = push - self.precision * (x - self.mean)
        bounds = self.low - x, self.high - x
        # Each unknown in its own uncertainty: so a matrix of many is seldom taken for singular.
        return quadratic_step(gram, push, bounds, np.sqrt(np.diagonal(gram)), np.inf)

    def ahead(self, points: Sequence[Point], x: Floats) -> tuple[Floats, float]:
        """The step from x within the bounds and the misfit after it, by the slopes at points that
        need not be those of x."""
        gram, push = self._normal(points)
        value = self.of_priors(x)
        for party, point, row in zip(self.parties, points, self.slots, strict=True):
            seen = party.problem.at(point)
            off = x[row] - party.problem.coordinates(point) / party.problem.unit
            push[row] -= seen.x_left.T @ (seen.x_left @ off)
            left = seen.y_left - seen.x_left @ off
            value += float(left @ left)
        step, promised = self._within(gram, push, x)
        return step, value - promised

    def moved(
        self, points: Sequence[Point], x: Floats, step: Floats, value: float
    ) -> tuple[Floats, list[Point], float] | None:
        """A step that gains, shortened where it has to be; None where none does."""
        for _ in range(5):
            goal = np.clip(x + step, self.low, self.high)
            # With slopes: most steps are taken, and then they are wanted.
            found = self.points(goal)
            got = np.inf if found is None else self.objective(found, goal)
            if found is not None and got < value:
                return goal, found, got
            step = step / 3
        return None
