"""A plan as the fit of a drive without further effects sees it: what is left of a change once the
numbers of the drive, the calibrations and the offsets are refitted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.experiment.plan import Plan
from cbpt.lab.experiment.simulate import stop_without_solution
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.selection.fit_effects import predicted

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """When a finer fit is made."""

    far: float = 0.1
    """A number that moves by more than this part of its uncertainty may leave the straight."""
    plain: float = 60.0
    """What stands out by more than this is seen and told apart, whatever a finer fit would
    make of it.
    """


_LIMITS = _Limits()


class Sight:
    """Raises `NoSolutionError` where the plan's preloads do not hold its torques."""

    def __init__(self, case: Case | Drive, plan: Plan, noise: Noise) -> None:
        truth = predicted(case, plan.rows)
        stop_without_solution(plan.rows, truth.has_solution, truth.status)
        campaign = Campaign.of(case, plan.rows)
        self.campaign = replace(campaign, y_arcsec=truth.elastic_angle_arcsec)
        self.fitter = Fitter(self.campaign)
        fit = self.fitter.fit(Hypothesis(), noise=noise, free_noise=False)
        assert fit is not None  # the model has a solution at every row
        self.fit: Fit = fit
        self.root = np.sqrt(self.fitter.linear(fit)[2])
        # Without the library every prediction is a good deal cheaper.
        self.numbers = Fitter(self.campaign, ())

    def left(self, columns: Floats) -> Floats:
        """Small columns (n, m) in arcsec less what refitting can follow, in standard uncertainties.

        Scalar products of what comes out are those of `Margin.left`: the last rows are what moving
        the numbers against their priors costs.
        """
        return self._split(columns)[0]

    def _split(self, columns: Floats) -> tuple[Floats, Floats]:
        seen = self.fit.whitener(columns)
        x, factor = self.fit.margin.x, self.fit.margin.factor
        moved = np.linalg.solve(factor.T, np.linalg.solve(factor, x.T @ seen))
        return np.vstack([seen - x @ moved, -self.root[:, None] * moved]), moved

    def refitted(self, changes: Floats) -> Floats:
        """The same for changes of any size (n, m), of sizes that grow: where the numbers move far,
        they are fitted in full.

        NaN where there is no change, because the model has no solution.
        """
        solved = np.isfinite(changes).all(axis=0)
        left, moved = self._split(np.where(solved, changes, 0.0))
        unknowns = self.numbers.unknowns(Hypothesis())
        places = [u.index for u in unknowns]
        last: Fit | None = None
        for j in np.flatnonzero(
            solved & (np.abs(moved[: len(unknowns)]) > _LIMITS.far).any(axis=0)
        ):
            changed = self.numbers.with_angles(self.campaign.y_arcsec + changes[:, j])
            start = self.numbers.start(Hypothesis(), {})
            if last is None:
                step = np.clip(moved[: len(unknowns), j], -3, 3) * [u.unit for u in unknowns]
                start[places] += step
            else:
                start[places] = last.point.values[places]
            last = changed.fit(Hypothesis(), start, noise=self.fit.noise, free_noise=False)
            if last is None:
                continue
            m = last.margin
            left[:, j] = np.r_[m.y - m.x @ m.mode, -self.root * m.mode]
            if np.linalg.norm(left[:, j]) > _LIMITS.plain:
                break
        left[:, ~solved] = np.nan
        return left
