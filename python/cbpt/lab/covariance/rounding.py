"""The rounding of a coarse display: what it adds, what it shows alike, what scatters behind it.

with_step       a stated uncertainty and the rounding of a display
without_step    the same less the rounding
rounds_alike    how much two readings of one value round alike
scatter_behind  by how much readings scatter before a display rounds them
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Linear

Floats = NDArray[np.float64]


def with_step(stated_arcsec: Floats, step_arcsec: float) -> Floats:
    """What is stated, or, where it is too small to include the rounding of a display, both."""
    rounding = step_arcsec / 12**0.5
    return np.where(stated_arcsec < rounding, np.hypot(stated_arcsec, rounding), stated_arcsec)


def without_step(stated_arcsec: Floats, step_arcsec: float) -> Floats:
    """What is stated less the rounding of a display, where it is large enough to include that."""
    rounding = step_arcsec / 12**0.5
    rest = np.sqrt(np.maximum(stated_arcsec**2 - rounding**2, (0.3 * stated_arcsec) ** 2))
    return np.where(stated_arcsec < rounding, stated_arcsec, rest)


def rounds_alike(steps: float) -> float:
    """Correlation of the rounding errors of two readings of one value with so many steps of noise.

    The error is a saw-tooth of the value; noise damps its harmonics (Widrow and Kollar 2008,
    chapter 19).
    """
    k = np.arange(1, 200)
    return float(min(6 / np.pi**2 * np.sum(np.exp(-((2 * np.pi * k * steps) ** 2)) / k**2), 1.0))


@dataclass(frozen=True)
class Behind:
    """By how much readings scatter about a model before a display rounds them."""

    scale: float
    """In uncertainties of a reading."""
    dof: float
    """How well it is known, as degrees of freedom: few readings stand near an edge of a step."""


def scatter_behind(linear: Linear, u_arcsec: Floats, step_arcsec: float) -> Behind:
    """By maximum likelihood of the steps that are shown: a display shows the step in which model
    and noise fall, so a model that is right is never further from it than the noise (interval
    censoring; Turnbull 1976, doi:10.1111/j.2517-6161.1976.tb01597.x).

    linear: readings less model, columns and prior precisions; u_arcsec: shape (n,).
    """
    from scipy.optimize import minimize

    y, x, precision = linear
    seen = x / u_arcsec[:, None]
    start = max(float(np.sqrt(np.mean((y / u_arcsec) ** 2))), 1e-3)
    flat = 1e-9 * float(np.trace(seen.T @ seen)) + 1e-12
    # One unit of each coordinate is about one standard uncertainty.
    root = np.linalg.cholesky(seen.T @ seen / start**2 + np.diag(precision + flat))
    columns = np.linalg.solve(root, x.T).T

    def loss(at: Floats) -> tuple[float, Floats]:
        size = np.linalg.solve(root.T, at[:-1])
        log_p, by_off, by_log_scale = _log_shown(
            y - columns @ at[:-1], np.exp(at[-1]) * u_arcsec, step_arcsec
        )
        pull = np.linalg.solve(root, precision * size)
        value = 0.5 * float(precision @ size**2) - log_p.sum()
        slope = np.append(columns.T @ by_off + pull, -by_log_scale.sum())
        return value, slope

    begin = np.append(np.zeros(x.shape[1]), np.log(start))
    within = [(None, None)] * x.shape[1] + [(begin[-1] - 12, begin[-1] + 2)]
    found = minimize(loss, begin, jac=True, method="L-BFGS-B", bounds=within)
    log_scale = float(found.x[-1])
    # Difference quotients over so many standard deviations either way.
    apart = np.array([-1e-2, 1e-2])
    sides = [loss(np.append(found.x[:-1], log_scale + s))[1][-1] for s in apart]
    known = max(float(sides[1] - sides[0]) / (2 * np.ptp(apart)), 0.0)
    # What was fitted followed the scatter as far as the readings tell it.
    off, sd = y - columns @ found.x[:-1], np.exp(log_scale) * u_arcsec
    slopes = [_log_shown(off + s * sd, sd, step_arcsec)[1] for s in apart]
    weight = np.maximum((slopes[0] - slopes[1]) / (np.ptp(apart) * sd), 0.0)
    told = x.T @ (x * weight[:, None])
    fitted = np.trace(np.linalg.solve(told + np.diag(precision + flat), told))
    dof = max(known - float(fitted), 0.0)
    return Behind(float(np.exp(log_scale)) * float(np.sqrt(known / dof)) if dof else 0.0, dof)


def _log_shown(off: Floats, sd: Floats, step: float) -> tuple[Floats, Floats, Floats]:
    """Logarithm of the probability that a display shows what it does, `off` from the model, and
    its derivatives by `off` and by the logarithm of the scatter."""
    from scipy.special import log_ndtr

    # The two edges of the step, near and far, on the side where both tails are small.
    near, far = (np.abs(off) - step / 2) / sd, (np.abs(off) + step / 2) / sd
    log_near, log_far = log_ndtr(-near), log_ndtr(-far)
    log_p = log_near + np.log1p(-np.exp(np.minimum(log_far - log_near, -1e-12)))
    density = [np.exp(-0.5 * (edge**2 + np.log(2 * np.pi)) - log_p) for edge in (near, far)]
    by_off = np.sign(off) * (density[1] - density[0]) / sd
    return log_p, by_off, density[0] * near - density[1] * far
