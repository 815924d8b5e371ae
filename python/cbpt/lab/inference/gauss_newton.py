"""The search for the most probable values of one hypothesis under one noise.

Problem  the misfit with its priors, its columns and its Gauss-Newton step
search   steps until none promises to gain

Gauss-Newton on whitened residuals and priors, with exact slopes and bounds by projection; offsets
of the readings are taken out at each step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Linear, Margin, Noise, Whitener
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled, Point

Floats = NDArray[np.float64]

_ENOUGH = 0.02
"""Gain in misfit that ends the search; two units of misfit are one of log evidence.
What is reported goes further: see `closing`."""

_MOST_DAMPED = 500.0
"""Damping at which a search that does not gain is at its end."""


def point_at(model: Assembled, values: Floats, unknowns: Sequence[Unknown]) -> Point | None:
    """Prediction with slopes by the unknowns; None where a row has no solution."""
    point = model.at(values, [u.index for u in unknowns])
    known = np.isfinite(point.angle_arcsec).all() and np.isfinite(point.slopes).all()
    return point if known else None


class Problem:
    """One set of unknowns and one noise, in steps of each unknown's own unit."""

    def __init__(
        self, campaign: Campaign, model: Assembled, unknowns: tuple[Unknown, ...], noise: Noise
    ) -> None:
        self.campaign, self.model = campaign, model
        self.unknowns, self.noise = unknowns, noise
        self.whitener = Whitener.of(noise, campaign.u_arcsec, campaign.rows)
        self.offsets = self.whitener(campaign.offsets)
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
        """Whitened misfit after the best offsets, and priors."""
        r = self.whitener(self.campaign.y_arcsec - point.angle_arcsec)
        margin = Margin.of(r, self.offsets, np.zeros(self.offsets.shape[1]))
        return margin.chi2 + float(self.precision @ self.off(point) ** 2)

    def moved(self, point: Point, step: Floats) -> Point | None:
        x = np.clip(self.coordinates(point) + step * self.unit, self.low, self.high)
        values = point.values.copy()
        values[self.index] = np.where(self.log, np.exp(np.where(self.log, x, 0.0)), x)
        # With slopes: six steps of seven are taken, and then they are wanted.
        return point_at(self.model, values, self.unknowns)

    def step(self, point: Point, damping: float = 0.0) -> tuple[Floats, float]:
        """The step in units that the linear problem asks for within the bounds, and what it
        promises.

        damping: Levenberg's; how many times over the step is held back as the prior holds the
        unknown, or, where there is none, as the readings do (Marquardt 1963).
        """
        y = self.whitener(self.campaign.y_arcsec - point.angle_arcsec)
        j = self.whitener(self.columns(point))
        at = self.coordinates(point)
        p = len(self.unknowns)
        step = np.zeros(p)
        free = np.ones(p, dtype=bool)
        start = self.off(point)
        for _ in range(p + 1):
            # The prior's own pull: its residual is where the unknown stands now.
            x = np.column_stack([j[:, free], self.offsets])
            precision = np.r_[self.precision[free], np.zeros(self.offsets.shape[1])]
            held = y - j[:, ~free] @ step[~free]
            a = x.T @ x + np.diag(precision)
            seen = np.diagonal(a)[: free.sum()]
            back = damping * np.where(precision[: free.sum()] > 0, precision[: free.sum()], seen)
            a[np.diag_indices_from(a)] *= 1 + 1e-10
            a[np.arange(len(back)), np.arange(len(back))] += back
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
        now = Margin.of(y, self.offsets, np.zeros(self.offsets.shape[1])).chi2 + float(
            self.precision @ start**2
        )
        then = Margin.of(y - j @ step, self.offsets, np.zeros(self.offsets.shape[1])).chi2
        then += float(self.precision @ np.where(self.precision > 0, start + step, 0.0) ** 2)
        return step, now - then

    def linear(self, point: Point) -> Linear:
        """The problem linearised here: y, columns, precision; unknowns count from the mean of their
        priors."""
        columns = self.columns(point)
        y = self.campaign.y_arcsec - point.angle_arcsec + columns @ self.off(point)
        return Linear(y, columns, self.precision)


def search(problem: Problem, point: Point, steps: int, bound: float = np.inf) -> tuple[Point, bool]:
    """The most probable point, and whether the search came to its end.

    It ends where no step promises to gain, after so many steps, or where what the last step
    promises stays above `bound`. Where even a short step does not gain, steps are damped: balls
    that lose touch turn the way down aside.
    """
    value, damping = problem.objective(point), 0.0
    for number in range(steps):
        step, promised = problem.step(point, damping)
        if promised < _ENOUGH:
            return point, not damping
        if number > 1 and value - 2 * promised > bound:
            return point, False
        for _ in range(4):
            candidate = problem.moved(point, step)
            got = np.inf if candidate is None else problem.objective(candidate)
            if got < value:
                break
            step = step / 3
        else:
            if damping >= _MOST_DAMPED:
                return point, False
            damping = max(8.0 * damping, 1.0)
            continue
        damping = 0.25 * damping if damping > 1 else 0.0
        assert candidate is not None
        gained, value, point = value - got, got, candidate
        if gained < _ENOUGH:
            return point, True
    return point, False
