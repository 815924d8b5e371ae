"""How well a fit predicts readings it has not seen.

Whole preload levels are held back in turn; where there are fewer than three, whole runs; else
stretches of the table. The numbers are refitted to the others, linearised about the fit, and what
is held back is predicted. An offset of its own that noise gives each run cannot be predicted and is
taken off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Linear, Margin, Noise, Whitener, log_likelihood
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.readings.set_points import levels_of

Floats = NDArray[np.float64]
_MOST_FOLDS = 12


def folds(campaign: Campaign) -> tuple[NDArray[np.int64], str]:
    """The fold of each reading, and by what they are divided."""
    preload = campaign.readings.preload_N
    if preload is not None:
        level = levels_of(preload)
        if len(level) >= 3:
            return level.index % _MOST_FOLDS, "preload level"
    step = campaign.readings.preload_step
    if step is not None:
        names, index = np.unique(step, return_inverse=True)
        if len(names) >= 3:
            return index.astype(np.int64) % _MOST_FOLDS, "preload step"
    if campaign.rows.runs >= 3:
        return campaign.rows.run_index % _MOST_FOLDS, "run"
    n = len(campaign)
    return np.arange(n) * min(4, n) // max(n, 1), "stretch of the table"


def held_out_residual(fitter: Fitter, fit: Fit, fold: NDArray[np.int64]) -> Floats:
    """Readings less what the other folds predict of them, arcsec, shape (n,)."""
    return held_out_by(fitter.campaign, fitter.linear(fit), fit.noise, fold)


def held_out_by(
    c: Campaign,
    problem: Linear,
    noise: Noise,
    fold: NDArray[np.int64],
) -> Floats:
    """The same by a linear problem."""
    y, x, precision = problem
    out = np.full(len(y), np.nan)
    numbers = np.unique(fold)
    for number in numbers:
        held = fold == number
        # One fold alone has nothing to be predicted from; then nothing is held out.
        kept = ~held if len(numbers) > 1 else held
        whitener = Whitener.of(noise.select(kept), c.u_arcsec[kept], c.rows.select(kept))
        # The hair of precision is for offsets of runs that are held back: their columns are empty.
        margin = Margin.of(whitener(y[kept]), whitener(x[kept]), precision + 1e-12)
        out[held] = y[held] - x[held] @ margin.mode
    if noise.offset_arcsec or c.offsets.shape[1] > 1:
        mean = np.bincount(c.rows.run_index, out) / np.bincount(c.rows.run_index)
        out = out - mean[c.rows.run_index]
    return out


def log_score(fitter: Fitter, fit: Fit, fold: NDArray[np.int64]) -> float:
    """Log density of each fold as predicted from the others, added up; about the fit, with its
    noise.

    That of all readings less that of the others (Bayes): it counts a far prediction as uncertain as
    it is, which a squared error does not.
    """
    c, (y, x, precision) = fitter.campaign, fitter.linear(fit)

    def density(kept: NDArray[np.bool_]) -> float:
        whitener = Whitener.of(fit.noise.select(kept), c.u_arcsec[kept], c.rows.select(kept))
        margin = Margin.of(whitener(y[kept]), whitener(x[kept]), precision + 1e-12)
        return log_likelihood(margin.chi2, whitener, margin.log_volume)

    every = density(np.ones(len(y), dtype=bool))
    return float(sum(every - density(fold != number) for number in np.unique(fold)))


def rms(values: Floats, inflation: Floats | None = None) -> float:
    """Root mean square; loose readings count less, as they do in the fits."""
    weight = np.ones(len(values)) if inflation is None else inflation**-2.0
    return float(np.sqrt(np.sum(weight * values**2) / np.sum(weight)))
