"""The search for the most probable values of one hypothesis under one noise.

Problem  the misfit with its priors, its columns and its Gauss-Newton step
Seen     readings less model and columns at one point, whitened
search   steps until none promises to gain

Gauss-Newton on whitened residuals and priors, damped where it does not gain, with exact slopes and
bounds by projection; offsets of the readings are taken out at each step.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt._core import quadratic_step
from cbpt.lab.covariance.linear_gaussian import Noise, Whitener
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled, Point

Floats = NDArray[np.float64]

_ENOUGH = 0.02
"""Gain in misfit that ends the search; two units of misfit are one of log evidence.
What is reported goes further: see `closing`."""

_POOR, _GOOD = 0.25, 0.75
"""Shares of what a step promises: one that gains less is followed by a shorter one, one that gains
more may be by a longer one."""


def point_at(model: Assembled, values: Floats, unknowns: Sequence[Unknown]) -> Point | None:
    """Prediction with slopes by the unknowns; None where a row has no solution."""
    point = model.at(values, [u.index for u in unknowns])
    known = np.isfinite(point.angle_arcsec).all() and np.isfinite(point.slopes).all()
    return point if known else None


@dataclass(frozen=True, eq=False)
class Seen:
    """Readings less model and columns at one point, whitened."""

    point: Point
    y: Floats
    """Shape (n,)."""
    x: Floats
    """Slopes by one step of each unknown, shape (n, p)."""
    y_left: Floats
    x_left: Floats
    """The same less what the offsets take."""
    coordinates: Floats
    """Of the unknowns, logarithms where they are searched in these, shape (p,)."""
    off: Floats
    """Unknowns off the mean of their priors, in units; 0 where there is no prior."""


class Problem:
    """One set of unknowns and one noise, in steps of each unknown's own unit."""

    def __init__(
        self, campaign: Campaign, model: Assembled, unknowns: tuple[Unknown, ...], noise: Noise
    ) -> None:
        self.campaign, self.model = campaign, model
        self.unknowns = unknowns
        self.mean = np.array([u.mean for u in unknowns])
        self.unit = np.array([u.unit for u in unknowns])
        self.precision = np.array([(u.unit / u.sd) ** 2 for u in unknowns])
        self.log = np.array([u.log for u in unknowns], dtype=bool)
        self.index = np.array([u.index for u in unknowns], dtype=int)
        bounds = np.array([[u.lower, u.upper] for u in unknowns]).reshape(-1, 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.low, self.high = np.where(self.log[:, None], np.log(bounds), bounds).T
        self._under(noise)

    def _under(self, noise: Noise) -> None:
        self.noise = noise
        self._see_through(Whitener.of(noise, self.campaign.u_arcsec, self.campaign.rows))

    def _see_through(self, whitener: Whitener) -> None:
        self.whitener = whitener
        self.offsets = whitener(self.campaign.offsets)
        self.basis = _basis(self.offsets)
        self._last: Seen | None = None

    def under(self, noise: Noise) -> Problem:
        """The same unknowns under another noise."""
        other = copy(self)
        other._under(noise)
        return other

    def through(self, whitener: Whitener) -> Problem:
        """The same seen through another covariance."""
        other = copy(self)
        other._see_through(whitener)
        return other

    def at(self, point: Point) -> Seen:
        """What is seen at a point; that of the last one is kept."""
        last = self._last
        if last is None or last.point is not point:
            residual = (self.campaign.y_arcsec - point.angle_arcsec)[:, None]
            # Without slopes where only the misfit is asked for.
            asked = point.slopes.shape[1] == len(self.unknowns)
            both = np.hstack([residual, self.columns(point)]) if asked else residual
            white = self.whitener(both)
            left = white - self.basis @ (self.basis.T @ white)
            parts = white[:, 0], white[:, 1:], left[:, 0], left[:, 1:]
            coordinates = self.coordinates(point)
            off = np.where(self.precision > 0, (coordinates - self.mean) / self.unit, 0.0)
            self._last = last = Seen(point, *parts, coordinates, off)
        return last

    def coordinates(self, point: Point) -> Floats:
        v = point.values[self.index]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(self.log, np.log(v), v))

    def columns(self, point: Point) -> Floats:
        """Slopes by one step of each unknown, arcsec."""
        v = np.where(self.log, point.values[self.index], 1.0)
        return np.asarray(point.slopes * (v * self.unit))

    def off_mean(self, point: Point) -> Floats:
        """Unknowns off the mean of their priors or, where they have none, off neutral; in units."""
        return np.asarray((self.coordinates(point) - self.mean) / self.unit)

    def objective(self, point: Point) -> float:
        """Whitened misfit after the best offsets, and priors."""
        seen = self.at(point)
        return float(seen.y_left @ seen.y_left + self.precision @ seen.off**2)

    def moved(self, point: Point, step: Floats) -> Point | None:
        x = np.clip(self.at(point).coordinates + step * self.unit, self.low, self.high)
        for bound in (self.low, self.high):
            # At a bound to the last digit, where a step ends there.
            x = np.where(np.abs(x - bound) <= 1e-12 * self.unit, bound, x)
        # With slopes: six steps of seven are taken, and then they are wanted.
        return point_at(self.model, self.values_at(point.values, x), self.unknowns)

    def values_at(self, values: Floats, coordinates: Floats) -> Floats:
        """Some values with the unknowns at these coordinates."""
        values, x = values.copy(), coordinates
        values[self.index] = np.where(self.log, np.exp(np.where(self.log, x, 0.0)), x)
        return values

    def seen(self, point: Point) -> Floats:
        """How far readings and priors see one unit of each unknown, in standard deviations."""
        x = self.at(point).x
        return np.asarray(np.sqrt(np.sum(x * x, axis=0) + self.precision))

    def step(
        self, point: Point, radius: float = np.inf, scale: Floats | float = 1.0
    ) -> tuple[Floats, float]:
        """The step in units that the linear problem asks for within the bounds, and what it
        promises.

        radius: the longest step, each unknown measured by `scale`, shape (p,).
        """
        seen = self.at(point)
        gram, slope = seen.x_left.T @ seen.x_left, seen.x_left.T @ seen.y_left
        at, scale = seen.coordinates, np.broadcast_to(scale, len(self.unknowns))
        # The prior's own pull: its residual is where the unknown stands now.
        gram[np.diag_indices_from(gram)] += self.precision
        slope -= self.precision * seen.off
        bounds = (self.low - at) / self.unit, (self.high - at) / self.unit
        return quadratic_step(gram, slope, bounds, scale, radius)


def _basis(columns: Floats) -> Floats:
    """Orthonormal columns that span the same, shape (n, k); of a single one without LAPACK, whose
    preparation takes longer than a table."""
    if columns.shape[1] == 1:
        return np.asarray(columns / np.linalg.norm(columns))
    return np.linalg.qr(columns)[0]


def search(problem: Problem, point: Point, steps: int, bound: float = np.inf) -> tuple[Point, bool]:
    """The most probable point, and whether the search came to its end.

    It ends where no step promises to gain, after so many predictions, or where what the last step
    promises stays above `bound`. Where a step does not gain what it promises, the next ones are
    shorter, each unknown measured by the most that the readings have seen of it (More 1978): of a
    ball that has lost touch they see nothing. Where balls touch at the minimum, long steps promise
    what they do not bring, and the search ends with short ones.
    """
    value, radius = problem.objective(point), np.inf
    scale = np.zeros(len(problem.unknowns))
    for number in range(steps):
        scale = np.maximum(scale, problem.seen(point))
        step, promised = problem.step(point, radius, np.where(scale > 0, scale, 1.0))
        length = float(np.linalg.norm(scale * step))
        whole = length < 0.99 * radius
        if promised < _ENOUGH:
            return point, True
        if number > 1 and whole and value - 2 * promised > bound:
            return point, False
        candidate = problem.moved(point, step)
        got = np.inf if candidate is None else problem.objective(candidate)
        gained = value - got
        if candidate is not None and gained > 0:
            value, point = got, candidate
            if gained < _ENOUGH and whole:
                return point, True
        if gained < _POOR * promised:
            radius = length / 4
        elif gained > _GOOD * promised:
            radius = max(radius, 2 * length)
    return point, False
