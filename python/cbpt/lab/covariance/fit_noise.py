"""The noise that makes readings most likely, structure by structure.

fit_noise        scale, correlation along a run and offsets of runs, as far as they pay their price
log_scale_prior  how far the scale may be from what is stated
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import (
    Linear,
    Margin,
    Noise,
    Rows,
    Whitener,
    log_likelihood,
)

Floats = NDArray[np.float64]

STATED_DOF = 8.0
"""A stated uncertainty is believed as if it came from this many repeats."""
FIXED_DOF = 1e5
"""With this many repeats the scatter has no say: what is stated stands."""
PRICE = 3.0
"""Log-likelihood that a further parameter of the noise has to gain: its prior and its width."""
LEAST_SCALE = 0.25
"""Smallest scale: readings that agree better than they can are no proof of more."""


@dataclass(frozen=True)
class _Grid:
    """Where the search for a noise looks first, and where it looks closer."""

    correlations: tuple[float, ...] = (0.25, 0.6)
    fine_correlations: tuple[float, ...] = (0.12, 0.4, 0.75, 0.88)
    offsets: tuple[float, ...] = (0.5, 2.0)
    """In typical uncertainties of a reading."""
    fine_offsets: tuple[float, ...] = (0.25, 1.0, 4.0, 10.0, 30.0)


_GRID = _Grid()


def log_scale_prior(scale: float, stated_dof: float) -> float:
    """Of the scale, 0 where it is 1."""
    return float(-0.5 * stated_dof * (2 * np.log(scale) + 1 / scale**2 - 1))


def fit_noise(
    linear: Linear,
    u_arcsec: Floats,
    rows: Rows,
    start: Noise,
    stated_dof: float = STATED_DOF,
    structures: bool = True,
) -> tuple[Noise, float]:
    """The noise that makes y = x p + noise most likely, and the logarithm of that likelihood.

    The price of each number of the noise is taken off, so noises of different structure compare.
    Flat unknowns (precision 0) count as degrees of freedom used up.
    """
    y, x, precision = linear
    u = u_arcsec * (1.0 if start.inflation is None else start.inflation)
    typical = float(np.median(u_arcsec))
    flat = int(np.count_nonzero(precision == 0))

    def rated(correlation: float, offset: float) -> tuple[float, Noise]:
        scale = start.scale
        for _ in range(2):
            # The runs' offsets scale with the readings' noise while the latter is being found.
            noise = Noise(scale, correlation, offset * scale)
            whitener = Whitener.of(noise, u, rows)
            both = whitener(np.column_stack([y, x]))
            margin = Margin.of(both[:, 0], both[:, 1:], precision)
            # What the priors are pulled by says nothing of the noise.
            scattered = margin.chi2 - float(precision @ margin.mode**2)
            new = _balanced(scale, scattered, len(y) - flat, stated_dof)
            if abs(new / scale - 1) < 1e-3:
                break
            scale = new
        value = log_likelihood(margin.chi2, whitener, margin.log_volume)
        value += log_scale_prior(scale, stated_dof) - PRICE * noise.numbers
        return value, replace(noise, inflation=start.inflation)

    best = rated(0.0, 0.0)
    # Where the scale may not shrink, correlation would only stand in for a smaller one.
    if structures and rows.runs < len(y) and stated_dof < FIXED_DOF:
        best = max(_searched(best, rated, typical, rows.runs > 2), key=lambda t: t[0])
        best = _refined(best, rated)
    return best[1], best[0]


def _balanced(scale: float, chi2: float, dof: float, stated_dof: float) -> float:
    """The scale at which misfit and what is stated agree; chi2 was found with `scale`.

    Never far below what is stated: readings that agree better than they can are no proof of more.
    """
    least = LEAST_SCALE if stated_dof >= 1 else 1e-9
    return max(float(np.sqrt((chi2 * scale**2 + stated_dof) / (dof + stated_dof))), least)


def _searched(
    white: tuple[float, Noise],
    rated: Callable[[float, float], tuple[float, Noise]],
    typical: float,
    with_offsets: bool,
) -> Iterator[tuple[float, Noise]]:
    """Noises of every structure; the fine grid of one only where the coarse one gains."""
    yield white
    alone = [rated(c, 0.0) for c in _GRID.correlations]
    if max(alone, key=lambda t: t[0])[0] > white[0]:
        alone += [rated(c, 0.0) for c in _GRID.fine_correlations]
    yield from alone
    if not with_offsets:
        return
    offsets = [rated(0.0, o * typical) for o in _GRID.offsets]
    if max(offsets, key=lambda t: t[0])[0] > white[0] - PRICE:
        offsets += [rated(0.0, o * typical) for o in _GRID.fine_offsets]
    yield from offsets
    either = max([*alone, *offsets], key=lambda t: t[0])
    if either[0] < white[0]:
        return
    noise = either[1]
    if noise.correlation:
        # Offsets that are not there yet look like a correlation larger than it is.
        for c in (noise.correlation, 0.5 * noise.correlation):
            yield from (rated(c, o * typical) for o in (0.7, 2.0, 5.0))
    else:
        ratio = noise.offset_arcsec / noise.scale
        yield from (rated(c, ratio) for c in (0.2, 0.5, 0.75))


def _refined(
    best: tuple[float, Noise], rated: Callable[[float, float], tuple[float, Noise]]
) -> tuple[float, Noise]:
    """Two rounds of smaller steps on whatever the noise has."""
    for share in (0.3, 0.12):
        noise = best[1]
        ratio = noise.offset_arcsec / noise.scale
        trials = []
        if noise.correlation:
            for step in (-share, share):
                c = noise.correlation + step * min(noise.correlation, 1 - noise.correlation)
                trials.append((c, ratio))
        if ratio:
            trials += [
                (noise.correlation, ratio * (1 - share)),
                (noise.correlation, ratio * (1 + share)),
            ]
        for c, o in trials:
            got = rated(c, o)
            if got[0] > best[0]:
                best = got
    return best
