"""The search for the most probable values of one hypothesis under one noise.

Problem  the misfit with its priors, its columns and its Gauss-Newton step
search   steps until none promises to gain

Gauss-Newton on whitened residuals and priors, damped where it does not gain, with exact slopes and
bounds by projection; offsets of the readings are taken out at each step. Compiled:
`crates/cbpt-core/src/posterior`.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Misfit, Seen
from cbpt.lab.covariance.linear_gaussian import Noise, Whitener
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled, Point

Floats = NDArray[np.float64]


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
        self.unknowns = unknowns
        self.mean = np.array([u.mean for u in unknowns], dtype=np.float64)
        self.unit = np.array([u.unit for u in unknowns], dtype=np.float64)
        self.precision = np.array([(u.unit / u.sd) ** 2 for u in unknowns], dtype=np.float64)
        self.log = np.array([u.log for u in unknowns], dtype=bool)
        self.index = np.array([u.index for u in unknowns], dtype=np.int64)
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
        priors = self.index, self.mean, self.unit, self.precision
        self.misfit = Misfit(
            self.campaign.y_arcsec,
            self.offsets,
            whitener.compiled,
            (*priors, self.log, self.low, self.high),
        )
        self._last: tuple[Point, Seen] | None = None

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
        if self._last is None or self._last[0] is not point:
            self._last = point, self.misfit.at(point.parts)
        return self._last[1]

    def coordinates(self, point: Point) -> Floats:
        """Of the unknowns, logarithms where they are searched in these."""
        return self.misfit.coordinates(point.values)

    def columns(self, point: Point) -> Floats:
        """Slopes by one step of each unknown, arcsec."""
        return self.misfit.columns(point.parts)

    def off_mean(self, point: Point) -> Floats:
        """Unknowns off the mean of their priors or, where they have none, off neutral; in units."""
        return np.asarray((self.coordinates(point) - self.mean) / self.unit)

    def prior(self, values: Floats, some: Sequence[bool]) -> float:
        """The part of the misfit that is the priors of some unknowns."""
        off = (self.misfit.coordinates(values) - self.mean) / self.unit
        return float(np.square(off[some]) @ self.precision[some])

    def objective(self, point: Point) -> float:
        """Whitened misfit after the best offsets, and priors."""
        return self.at(point).misfit

    def values_at(self, values: Floats, coordinates: Floats) -> Floats:
        """Some values with the unknowns at these coordinates."""
        return self.misfit.values_at(values, coordinates)

    def seen(self, point: Point) -> Floats:
        """How far readings and priors see one unit of each unknown, in standard deviations."""
        return self.at(point).reach

    def step(
        self, point: Point, radius: float = np.inf, scale: Floats | float = 1.0
    ) -> tuple[Floats, float]:
        """The step in units that the linear problem asks for within the bounds, and what it
        promises.

        radius: the longest step, each unknown measured by `scale`, shape (p,).
        """
        measured = np.broadcast_to(np.asarray(scale, dtype=np.float64), len(self.unknowns))
        return self.misfit.step(self.at(point), radius, measured)


def search(
    problem: Problem, point: Point, steps: int, bound: float = np.inf, ranked: bool = False
) -> tuple[Point, bool]:
    """The most probable point, and whether the search came to its end.

    It ends where no step promises to gain, after so many predictions, or where what the last step
    promises stays above `bound`. ranked: whether the end is only ranked among others; it comes
    sooner then.
    """
    return problem.model.search(problem.misfit, point, (steps, bound, ranked))
