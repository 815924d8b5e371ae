"""A fit taken to the last digit, for what is reported.

    closed   the fit at the end of a few more steps, and how near that is

Hypotheses are compared at values where the next step promises next to no gain in evidence, which
may be a twentieth of a standard uncertainty away. That is enough for a comparison and cheap, but
not for a value that is told: so the answer, and no other candidate, is closed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.evidence import Closing, Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.gauss_newton import Problem, point_at
from cbpt.lab.inference.least_squares import Aim, minimise
from cbpt.lab.model.forward import Point

Floats = NDArray[np.float64]


_AIM = Aim(tolerance=1e-6, variance=1.0, steps=40)
"""Two steps are enough where the readings determine a smooth model well."""


def closed(fitter: Fitter, fit: Fit) -> Fit:
    """The same fit at the minimum of the misfit that its values were sought in, with `Fit.closing`;
    noise and other modes stay."""
    if not fit.unknowns:
        return fit
    problem = Problem(fitter.campaign, fitter.model, fit.unknowns, fit.noise_of_values)
    fitter.model.cold()
    reached = _Reached(problem, fit.point)
    start = problem.coordinates(fit.point) / problem.unit
    found = minimise(
        reached,
        start,
        (problem.low / problem.unit, problem.high / problem.unit),
        _AIM,
    )
    if found is None:
        return fit
    left = float(np.sqrt(max(found.promised, 0.0)))
    closing = Closing(found.steps, _AIM.tolerance, left, found.converged)
    point = reached.points[found.x.tobytes()]
    there = (point, fit.converged or found.converged)
    return replace(fitter.moved(fit, there), closing=closing)


class _Reached:
    """The whitened residual with the priors' own, offsets taken out, by unknowns in their units;
    keeps the points it has been at."""

    def __init__(self, problem: Problem, start: Point) -> None:
        self.problem, self.start = problem, start
        self.root = np.sqrt(problem.precision)
        self.points: dict[bytes, Point] = {}

    def __call__(self, x: Floats) -> tuple[Floats, Floats] | None:
        p = self.problem
        point = point_at(p.model, p.values_at(self.start.values, x * p.unit), p.unknowns)
        if point is None:
            return None
        self.points[x.tobytes()] = point
        seen = p.at(point)
        return (
            np.concatenate([seen.y_left, -self.root * seen.off]),
            np.vstack([seen.x_left, np.diag(self.root)]),
        )
