"""What an instrument does to many readings at once, as random effects: columns of normal
coefficients.

Artefact        one of a kind, with the size that it has
random_walk     the zero wanders in absolute time
first_reading   the first reading of every run is off, say before a clamp has settled
encoder         an error with a period of the angle that is read
gains_of        log likelihood that artefacts gain where all else has been taken out
without         readings less what an artefact most probably does to them

A random walk is a Brownian motion from the first reading on, by the leading terms of its
Karhunen-Loeve expansion (Loeve 1978, section 37.5); what they leave is quick and small and counts
as noise. The error of a graduated disc has the period of its graduation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Kind = Literal["random_walk", "first_reading", "encoder"]

_TERMS = 16
"""Of the expansion of a random walk: they hold 97 % of its variance."""
_FEWEST_PERIODS = 5.0
"""Of the encoder in the range of the angles: fewer are any curve of the angle, and no ripple."""
_FINEST = 4.0
"""Typical uncertainties of a reading in the shortest period that can be told."""
_MOST_PERIODS = 400


@dataclass(frozen=True, eq=False)
class Artefact:
    """Columns of shape (n, k), arcsec, each with a normal coefficient of variance 1."""

    kind: Kind
    columns_arcsec: Floats
    numbers: int = 1
    """How many numbers were chosen for it: its size, and for a period what finding it is worth."""

    def sized(self, factor: float) -> Artefact:
        """So many times as large."""
        return replace(self, columns_arcsec=factor * self.columns_arcsec)

    def select(self, rows: NDArray[np.bool_]) -> Artefact:
        """That of some of the readings."""
        return replace(self, columns_arcsec=self.columns_arcsec[rows])


def random_walk(time_s: Floats) -> Artefact | None:
    """Of variance 1 arcsec^2 at the last reading; None where no time passes."""
    passed = time_s - time_s.min()
    span = float(passed.max())
    if not span > 0:
        return None
    rate = (np.arange(1, _TERMS + 1) - 0.5) * np.pi
    columns = np.sqrt(2) * np.sin(np.outer(passed / span, rate)) / rate
    return Artefact("random_walk", columns)


def first_reading(before: NDArray[np.int64]) -> Artefact | None:
    """1 arcsec; `before` is negative for the first reading of a run. None where all runs are of one
    or two readings, or there is one run."""
    first = before < 0
    runs = int(np.count_nonzero(first))
    if runs < 3 or len(before) < 3 * runs:
        return None
    return Artefact("first_reading", first[:, None].astype(np.float64))


def encoder(angle_arcsec: Floats, u_arcsec: float) -> list[Artefact]:
    """Of all periods that can be told apart, 1 arcsec."""
    extent = float(np.ptp(angle_arcsec))
    most = min(extent / (_FINEST * u_arcsec), _MOST_PERIODS / 4, len(angle_arcsec) / 8)
    found = []
    for periods in np.arange(_FEWEST_PERIODS, most, 0.25):
        phase = 2 * np.pi * periods * (angle_arcsec - angle_arcsec.min()) / max(extent, 1e-300)
        # A period that was found among hundreds is worth some three numbers.
        columns = np.column_stack([np.cos(phase), np.sin(phase)])
        found.append(Artefact("encoder", columns, numbers=3))
    return found


def gains_of(grams: Floats, projections: Floats, sizes: Floats) -> Floats:
    """Of m artefacts of k columns U, by their products U'U (m, k, k) and with the readings U'y
    (m, k), all whitened, and whatever else is free taken out; at s sizes, shape (m, s)."""
    values, axes = np.linalg.eigh(grams)
    along = np.einsum("mij,mi->mj", axes, projections)
    square = sizes[None, :, None] ** 2
    grown = 1 + square * np.maximum(values, 0.0)[:, None, :]
    explained = square * along[:, None, :] ** 2 / grown
    return np.asarray(0.5 * (explained - np.log(grown)).sum(axis=-1))


def without(artefact: Artefact, residual_arcsec: Floats, weight: Floats) -> Floats:
    """Arcsec, shape (n,); weight: of each reading, 1/arcsec^2."""
    columns = artefact.columns_arcsec
    weighted = weight[:, None] * columns
    mode = np.linalg.solve(
        columns.T @ weighted + np.eye(columns.shape[1]), weighted.T @ residual_arcsec
    )
    return np.asarray(residual_arcsec - columns @ mode)
