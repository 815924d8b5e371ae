"""Campaigns simulated with the model itself, and dense formulas to hold the fast ones against."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from cbpt import read_readings
from cbpt.lab.covariance.fit_noise import log_scale_prior
from cbpt.lab.covariance.linear_gaussian import Noise, Rows
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.priors import PRIORS, VARIANTS, Variant
from common.comparisons import columns_of, drive_of

Floats = NDArray[np.float64]
Values = Mapping[tuple[str, str], float]
"""By effect and parameter, SI."""

# The number of each effect that is a number of the drive or a calibration.
NUMBERS = {e: next(v.sizes[0] for v in VARIANTS if v.effect == e) for e in PRIORS}


@cache
def plan(name: str = "dev03", u_arcsec: float = 0.3) -> Campaign:
    """The loads of a development set; its readings are there to be replaced."""
    columns = columns_of(name)
    columns["u_elastic_angle_arcsec"][:] = u_arcsec
    return Campaign.of(drive_of(name), read_readings(columns))


def truth(campaign: Campaign, values: Values) -> Floats:
    """What the model says with some effects, arcsec."""
    effects = list(dict.fromkeys(effect for effect, _ in values))
    model = Assembled(campaign, effects)
    at = model.neutral.copy()
    for (effect, name), value in values.items():
        at[model.index(effects.index(effect), name)] = value
    return model.at(at).angle_arcsec


def readings_of(campaign: Campaign, values: Values, rng: np.random.Generator | None) -> Campaign:
    """The campaign with readings of the model plus its white noise; None: without noise."""
    noise = 0.0 if rng is None else campaign.u_arcsec * rng.standard_normal(len(campaign))
    return replace(campaign, y_arcsec=truth(campaign, values) + noise)


def drawn_numbers(campaign: Campaign, rng: np.random.Generator) -> dict[tuple[str, str], float]:
    """Numbers of a drive and a rig that differ from the stated ones as much as is stated."""
    neutral = {e: Fitter(campaign, ()).neutral(e, NUMBERS[e]) for e in PRIORS}
    return {
        (e, NUMBERS[e]): neutral[e] + sd * float(rng.standard_normal())
        for e, sd in campaign.priors.items()
    }


def variant_of(effect: str, name: str = "") -> Variant:
    """A form of an effect by the start of its name."""
    return next(v for v in VARIANTS if v.effect == effect and v.name.startswith(name))


def hypothesis_of(effect: str, name: str = "") -> Hypothesis:
    """One form of one effect."""
    return Hypothesis((variant_of(effect, name),))


def dense(noise: Noise, u_arcsec: Floats, rows: Rows) -> Floats:
    """The covariance of the readings, written down."""
    n = len(u_arcsec)
    place = np.zeros(n, dtype=int)
    for run in range(rows.runs):
        own = rows.run_index == run
        place[own] = np.arange(np.count_nonzero(own))
    same = rows.run_index[:, None] == rows.run_index[None, :]
    apart = np.abs(place[:, None] - place[None, :])
    d = noise.scale * u_arcsec * (np.ones(n) if noise.inflation is None else noise.inflation)
    correlated = np.where(same, float(noise.correlation) ** apart, 0.0)
    covariance = d[:, None] * correlated * d + noise.offset_arcsec**2 * same
    if noise.rounding_arcsec is not None:
        covariance += np.diag(noise.rounding_arcsec**2)
    if noise.torque_arcsec is not None:
        covariance += np.diag(noise.torque_arcsec**2)
    if noise.held is not None:
        shared = noise.held.sd_arcsec
        together = noise.held.index[:, None] == noise.held.index[None, :]
        covariance += shared[:, None] * shared * together
    if noise.artefact is not None:
        covariance += noise.artefact.columns_arcsec @ noise.artefact.columns_arcsec.T
    return np.asarray(covariance)


def sample(noise: Noise, u_arcsec: Floats, rows: Rows, rng: np.random.Generator) -> Floats:
    """Noise of that covariance."""
    factor = np.linalg.cholesky(dense(noise, u_arcsec, rows))
    return np.asarray(factor @ rng.standard_normal(len(u_arcsec)))


# As in the development sets: 12 runs of 33 readings, and one zero.
TWELVE = Rows.of(np.repeat(np.arange(12), 33))
U = np.full(396, 0.3)
ONE, FLAT = np.ones((396, 1)), np.zeros(1)


def prior_of_scale(scale: float, stated_dof: float) -> float:
    """Log prior of one scale of a noise."""
    return float(log_scale_prior(np.array(scale), stated_dof))
