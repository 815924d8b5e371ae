"""The least sum of squares of a nonlinear model, to the last digit.

    minimise   steps until no further one is worth anything
    Aim        how far they go
    Minimum    where they end, and how well that is known

Gauss-Newton within a region of trust (Levenberg-Marquardt as More has it, 1978): the step is the
shortest of all  min |r - J s|  with |D s| at most the radius, from the singular values of J over D,
not from the product J'J, whose condition is the square of that of J. D holds the largest length
that each column has had, so units of the unknowns do not matter. The radius follows the ratio of
gain to promise. Bounds are kept by projection: an unknown whose step passes its end is held there.

Near the end the sum of squares rounds before the unknowns do: their error goes with its root. So
what promises less than the sum can tell is taken on trust, as long as each step promises less than
the one before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt._core import held_at_bounds

__all__ = ["Aim", "Minimum", "minimise"]

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Model = Callable[[Floats], "tuple[Floats, Floats] | None"]
"""Residual (n,) and the slopes of what was taken off, (n, p); None where there are none."""


@dataclass(frozen=True)
class _Trust:
    """How far a step is trusted."""

    poor: float = 0.25
    """A gain below this part of its promise shortens the radius to this part of the step."""
    good: float = 0.75
    """One above it doubles the radius."""
    least: float = 1e-15
    """A radius below this part of the unknowns is no step at all; and a singular value below this
    part of the largest is none."""
    told: float = 1e-11
    """Part of the sum of squares that its rounding is far below."""
    tries: int = 3
    """Of a step that promises less than that: shorter ones are lost in rounding."""


_TRUST = _Trust()


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a search ends."""

    x: Floats
    squares: float
    """Sum of the squared residuals."""
    promised: float
    """What one more step would take off it."""
    steps: int
    """Steps that were taken."""
    converged: bool
    """Whether one more step is within the tolerance, or lost in rounding."""


@dataclass(frozen=True)
class Aim:
    """How far a search goes."""

    tolerance: float = 1e-6
    """The longest step that need not be taken, in standard uncertainties, of all unknowns."""
    variance: float | None = None
    """Of a residual; that of the residuals themselves where None."""
    steps: int = 50
    """No more than these."""
    reach: float = np.inf
    """The first radius, as a multiple of the start; infinite where the start is near."""


def minimise(
    model: Model, x: Floats, bounds: tuple[Floats, Floats] | None = None, aim: Aim | None = None
) -> Minimum | None:
    """The least squares from a start; None where the model has no value there."""
    aim = aim or Aim()
    found = model(x)
    if found is None or not _finite(found):
        return None
    search = _Search(model, x, found, bounds or (np.full(len(x), -np.inf), np.full(len(x), np.inf)))
    search.radius = aim.reach * (search.size or 1.0)
    for taken in range(aim.steps + 1):
        step, promised = search.step()
        dof = max(len(search.residual) - len(x), 1)
        variance = search.squares / dof if aim.variance is None else aim.variance
        done = promised <= aim.tolerance**2 * variance
        if done or taken == aim.steps or not search.take(step, promised):
            break
    converged = done or (taken < aim.steps and search.lost(step, promised))
    return Minimum(search.x, search.squares, promised, taken, converged)


class _Search:
    """One search: where it stands, and how far it trusts its model."""

    def __init__(
        self, model: Model, x: Floats, found: tuple[Floats, Floats], bounds: tuple[Floats, Floats]
    ) -> None:
        self.model, self.x, (self.low, self.high) = model, x, bounds
        self.residual, self.slopes = found
        self.squares = float(self.residual @ self.residual)
        self.scale = _lengths(self.slopes)
        self.radius = np.inf
        self.last, self.settled, self.on_trust = np.inf, False, True

    @property
    def size(self) -> float:
        """Of the unknowns, as steps are measured."""
        return float(np.linalg.norm(self._weight * self.x))

    @property
    def _weight(self) -> Floats:
        return np.where(self.scale > 0, self.scale, 1.0)

    def lost(self, step: Floats, promised: float) -> bool:
        """Whether a step that was not taken is too small for the sum or the unknowns to tell."""
        short = float(np.linalg.norm(self._weight * step)) <= _TRUST.told * self.size
        return short or promised <= _TRUST.told * self.squares

    def step(self, radius: float = np.inf) -> tuple[Floats, float]:
        """The best step within radius and bounds, and what it promises."""

        def asked(step: Floats, free: Mask) -> Floats:
            weight = self._weight[free]
            left = self.residual - self.slopes[:, ~free] @ step[~free]
            return _within(self.slopes[:, free] / weight, left, radius) / weight

        def pull(step: Floats) -> Floats:
            return np.asarray(self.slopes.T @ (self.residual - self.slopes @ step))

        step = held_at_bounds(asked, pull, self.low - self.x, self.high - self.x)
        along = self.slopes @ step
        # The difference of the two sums, without taking one from the other.
        return step, float(2 * self.residual @ along - along @ along)

    def take(self, step: Floats, promised: float) -> bool:
        """Takes the step, or a shorter one where it is not trusted; whether there was one."""
        untold = promised <= _TRUST.told * self.squares
        # A step on trust that promises no less than the one before was not worth it: from here on
        # the sum has to tell, as far as it can.
        self.on_trust &= not (self.settled and promised >= self.last)
        self.settled, self.last = untold and self.on_trust, promised
        for _ in range(_TRUST.tries if untold else 1000):
            if self.radius <= _TRUST.least * self.size:
                break
            if not self.settled and np.linalg.norm(self._weight * step) > self.radius:
                step, promised = self.step(self.radius)
            length = float(np.linalg.norm(self._weight * step))
            x = np.clip(self.x + step, self.low, self.high)
            found = self.model(x)
            squares = float(found[0] @ found[0]) if found and _finite(found) else np.inf
            if self.settled:
                if squares <= (1 + _TRUST.told) * self.squares:
                    return self._move(x, found, squares)
                return False
            ratio = (self.squares - squares) / promised if promised > 0 else -np.inf
            if ratio < _TRUST.poor:
                self.radius = _TRUST.poor * length
            elif ratio > _TRUST.good:
                self.radius = max(self.radius, 2 * length)
            if ratio > 0:
                return self._move(x, found, squares)
        return False

    def _move(self, x: Floats, found: tuple[Floats, Floats] | None, squares: float) -> bool:
        assert found is not None
        self.x, (self.residual, self.slopes), self.squares = x, found, squares
        self.scale = np.maximum(self.scale, _lengths(self.slopes))
        return True


def _within(j: Floats, r: Floats, radius: float) -> Floats:
    """The z of the least |r - j z| with |z| at most the radius (More 1978, section 5)."""
    u, s, v = np.linalg.svd(j, full_matrices=False)
    seen = s > _TRUST.least * max(float(s.max(initial=0.0)), 1e-300)
    s, c, v = s[seen], u.T[seen] @ r, v[seen]
    damping = 0.0
    for _ in range(50):
        z = s * c / (s**2 + damping)
        length = float(np.linalg.norm(z))
        if length <= 1.01 * radius:
            break
        slope = float(np.sum((s * c) ** 2 / (s**2 + damping) ** 3)) / length
        damping += (length / radius) * (length - radius) / slope
    return np.asarray(v.T @ (s * c / (s**2 + damping)))


def _lengths(columns: Floats) -> Floats:
    return np.asarray(np.linalg.norm(columns, axis=0))


def _finite(found: tuple[Floats, Floats]) -> bool:
    with np.errstate(over="ignore"):
        return bool(np.isfinite(found[0] @ found[0]) and np.isfinite(found[1]).all())
