"""What a fit leaves of the readings: one convention for every error that an answer states.

    left_by         residuals of a fit, less the offset of each run where runs have their own
    without_offsets the same of any residuals
    told_by         a noise that knows what the instrument does, as one fit shows it
    zero_per_run    whether every run has a zero of its own
    zeros_out       which offsets are subtracted, in words
    rmse_of         their root mean square
    chi2_of         their chi-squared per degree of freedom
    free_of         degrees of freedom that they have
    scatter_of      standard deviation of a reading about a fit, from the readings alone

As in what is held out (`holdout`): an offset of a run is no error of the model.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.artefacts import without
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign

Floats = NDArray[np.float64]


def left_by(campaign: Campaign, fit: Fit) -> Floats:
    """Arcsec, shape (n,)."""
    return without_offsets(campaign, fit.residual_arcsec, fit.noise)


def without_offsets(campaign: Campaign, residual_arcsec: Floats, noise: Noise) -> Floats:
    """Nor what an artefact of the instrument or the error of a mean torque does; arcsec, shape
    (n,)."""
    found = _centred(campaign, residual_arcsec, noise)
    if noise.artefact is None and noise.held is None:
        return found
    if noise.instrument_arcsec is not None:
        return np.asarray(found - noise.instrument_arcsec)
    return np.asarray(found - _instrument(campaign, found, noise))


def told_by(campaign: Campaign, residual_arcsec: Floats, noise: Noise) -> Noise:
    """The noise, with what the instrument does as these residuals show it: the same for every fit
    that is looked at through it, as a misfit may look like an instrument that wanders."""
    if noise.artefact is None and noise.held is None:
        return noise
    found = _centred(campaign, residual_arcsec, noise)
    return replace(noise, instrument_arcsec=_instrument(campaign, found, noise))


def _centred(campaign: Campaign, values: Floats, noise: Noise) -> Floats:
    """Less the offset of each run, where runs have their own."""
    if not zero_per_run(campaign, noise):
        return values
    index, weight = campaign.rows.run_index, _weight(campaign, noise)
    offset = np.bincount(index, weight * values) / np.bincount(index, weight)
    return np.asarray(values - offset[index])


def _instrument(campaign: Campaign, residual_arcsec: Floats, noise: Noise) -> Floats:
    """What the instrument most probably does to centred residuals, arcsec, shape (n,)."""
    weight = _weight(campaign, noise) / noise.scale**2
    left = residual_arcsec
    if noise.held is not None:
        left = left - noise.held.most_probable(left, weight)
    if noise.artefact is not None:
        columns = noise.artefact.columns_arcsec.T
        columns = np.column_stack([_centred(campaign, c, noise) for c in columns])
        left = without(replace(noise.artefact, columns_arcsec=columns), left, weight)
    return np.asarray(residual_arcsec - left)


def _weight(campaign: Campaign, noise: Noise) -> Floats:
    """Of each reading, but for the scale of the noise, 1/arcsec^2."""
    weight = campaign.u_arcsec**-2.0
    return np.asarray(weight if noise.inflation is None else weight / noise.inflation**2)


def zero_per_run(campaign: Campaign, noise: Noise) -> bool:
    """Whether every run has a zero of its own: the case says so, or the readings show it."""
    return campaign.zero_per_run or bool(noise.offset_arcsec)


def zeros_out(campaign: Campaign, noise: Noise) -> str:
    """Which offsets an error does not hold, as every error of an answer is said with them."""
    which = "an offset for each run" if zero_per_run(campaign, noise) else "a common offset"
    return f"{which} is subtracted"


def rmse_of(campaign: Campaign, fit: Fit) -> float:
    """Arcsec."""
    return float(np.sqrt(np.mean(left_by(campaign, fit) ** 2)))


def chi2_of(fitter: Fitter, fit: Fit) -> float:
    """Against what one reading is known to, or, where nothing tells that, the noise of the fit."""
    u = u_judging(fitter.campaign, fit.noise)
    return float(np.sum((left_by(fitter.campaign, fit) / u) ** 2) / max(free_of(fitter, fit), 1))


def u_judging(campaign: Campaign, noise: Noise) -> Floats:
    """Standard uncertainty of each reading that chi-squared is held against, arcsec."""
    known = campaign.u_stated or campaign.u_repeated
    return np.asarray(campaign.u_reading_arcsec * (1.0 if known else noise.scale))


def free_of(fitter: Fitter, fit: Fit) -> int:
    """Readings less what was fitted to them: numbers without a prior, and offsets."""
    c = fitter.campaign
    offsets = c.rows.runs if zero_per_run(c, fit.noise) else 1
    return max(len(c) - offsets - sum(bool(np.isinf(u.sd)) for u in fit.unknowns), 0)


def scatter_of(fitter: Fitter, fit: Fit, weighted: bool = True) -> tuple[float, float]:
    """Arcsec (root mean square over the readings; loose ones count less), and the degrees of
    freedom behind it; what is correlated is fewer independent readings. weighted: by what each
    reading is known to.
    """
    c, noise = fitter.campaign, fit.noise
    u, free, rho = c.u_reading_arcsec, free_of(fitter, fit), noise.correlation
    u = u if weighted else np.ones(len(c))
    off = left_by(c, fit) / (u if noise.inflation is None else u * noise.inflation)
    sd = np.sqrt(np.sum(off**2) / max(free, 1)) * np.sqrt(np.mean(u**2))
    return float(sd), free * (1 - rho) / (1 + rho)
