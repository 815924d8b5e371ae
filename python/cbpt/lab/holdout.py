"""How well a fit predicts readings it has not seen.

Whole preload levels are held back in turn; where there are fewer than three, whole runs; else stretches of
the table. The numbers are refitted to the others, linearised about the fit, and what is held back is
predicted. A zero of its own that noise gives each run cannot be predicted and is taken off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.assembled import Campaign
from cbpt.lab.fit import Fit, Fitter
from cbpt.lab.noise import Margin, Whitener
from cbpt.lab.structure import steps

Floats = NDArray[np.float64]
_MOST_FOLDS = 12


def folds(campaign: Campaign) -> tuple[NDArray[np.int64], str]:
    """The fold of each reading, and by what they are divided."""
    preload = campaign.readings.preload_N
    if preload is not None:
        _, level = np.unique(np.round(steps(preload), 9), return_inverse=True)
        if level.max(initial=0) >= 2:
            return level % _MOST_FOLDS, "preload level"
    if campaign.rows.runs >= 3:
        return campaign.rows.run_index % _MOST_FOLDS, "run"
    n = len(campaign)
    return np.arange(n) * min(4, n) // max(n, 1), "stretch of the table"


def held_out_residual(fitter: Fitter, fit: Fit, fold: NDArray[np.int64]) -> Floats:
    """Readings less what the other folds predict of them, arcsec, shape (n,)."""
    c = fitter.campaign
    y, x, precision = fitter.linear(fit)
    out = np.full(len(y), np.nan)
    for number in np.unique(fold):
        held = fold == number
        kept = ~held
        if not kept.any():
            return y - x @ fit.margin.mode
        whitener = Whitener.of(_part(fit, kept), c.u_arcsec[kept], c.rows.select(kept))
        # Zeros of runs that are held back have nothing to be found from; their columns are empty here.
        margin = Margin.of(whitener(y[kept]), whitener(x[kept]), precision + 1e-12)
        out[held] = y[held] - x[held] @ margin.mode
    if fit.noise.offset_arcsec or c.zeros.shape[1] > 1:
        mean = np.bincount(c.rows.run_index, out) / np.bincount(c.rows.run_index)
        out = out - mean[c.rows.run_index]
    return out


def _part(fit: Fit, rows: NDArray[np.bool_]):  # type: ignore[no-untyped-def]
    from dataclasses import replace

    looser = fit.noise.looser
    return fit.noise if looser is None else replace(fit.noise, looser=looser[rows])


def rms(values: Floats, looser: Floats | None = None) -> float:
    """Root mean square; loose readings count less, as they do in the fits."""
    weight = np.ones(len(values)) if looser is None else looser**-2.0
    return float(np.sqrt(np.sum(weight * values**2) / np.sum(weight)))
