"""What an instrument does to many readings at once, as random effects: columns of normal
coefficients.

Artefact        one of a kind, with the size that it has
random_walk     the zero wanders in absolute time
walks_by_order  the zero drifts or wanders from reading to reading, in a table without times
first_readings  the first reading of every run is off, say before a clamp has settled
encoders        an error with a period of the angle that is read, as a graduated disc has
(known)         what is known to be uncertain before a reading is looked at: torques that are means
                or polynomials through what a sensor showed (`diagnosis.held_torque`,
                `ramped_torque`), and a curve between the points of its table
                (`model.table_curve`)
gains_of        log likelihood that an artefact gains where all else has been taken out
without         readings less what an artefact most probably does to them

A random walk is a Brownian motion from the first reading on, by the leading terms of its
Karhunen-Loeve expansion (Loeve 1978, section 37.5); what they leave is quick and small and counts
as noise.

Torques of a few sizes turn the drive by angles of a few sizes, and through any of these goes a sine
of some period. So a period is offered as far as the readings sample it: they stand in most quarters
of it, over its whole range. The error of a disc that is graduated more finely stays a lack of fit
without a name.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.symmetric import eigen

Floats = NDArray[np.float64]
Kind = Literal["random_walk", "first_reading", "encoder", "known"]

_TERMS = 40
"""Of the expansion of a random walk: what they leave is 0.5 % of its variance. A walk may be ten
times as large as the scatter of a reading, and what sixteen leave was as large as that."""

_ALONE, _RUNS_ALONE = 0.3, 64
"""What the first readings of runs differ by, of what they have in common; in so many runs at most:
more of them tell the common part well enough."""


@dataclass(frozen=True, eq=False)
class Artefact:
    """Columns of shape (n, k), arcsec, each with a normal coefficient of variance 1."""

    kind: Kind
    columns_arcsec: Floats
    among: int = 1
    """Of how many columns like these the best are taken."""

    def sized(self, factor: float) -> Artefact:
        """So many times as large."""
        return replace(self, columns_arcsec=factor * self.columns_arcsec)

    @property
    def is_known(self) -> bool:
        """Whether it is none that the readings have to show."""
        return self.kind == "known"

    def beside(self, known: Artefact | None) -> Artefact:
        """With the columns of another one, which has no name beside it."""
        if known is None:
            return self
        columns = np.column_stack([self.columns_arcsec, known.columns_arcsec])
        return replace(self, columns_arcsec=columns)

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


def walks_by_order(order: Floats) -> list[Artefact]:
    """A zero that drifts steadily from reading to reading, 1 arcsec at the last one, and one that
    wanders."""
    walk = random_walk(order)
    if walk is None:
        return []
    straight = Artefact("random_walk", (order / order.max())[:, None])
    return [replace(way, among=2) for way in (straight, walk)]


def first_readings(before: NDArray[np.int64]) -> Iterator[Artefact]:
    """1 arcsec, alike in all runs, and with a part of each run's own; `before` is negative for the
    first reading of a run. None where runs are of one or two readings, or there are two at most."""
    first = before < 0
    runs = int(np.count_nonzero(first))
    if runs < 3 or len(before) < 3 * runs:
        return
    alike = first[:, None].astype(np.float64)
    yield Artefact("first_reading", alike)
    if runs <= _RUNS_ALONE:
        alone = np.zeros((len(before), runs))
        alone[np.flatnonzero(first), np.arange(runs)] = _ALONE
        yield Artefact("first_reading", np.column_stack([alike, alone]))


@dataclass(frozen=True)
class _Periods:
    """Which periods of an encoder are looked for."""

    fewest: float = 5.0
    """In the range of the angles: fewer are any curve of the angle."""
    apart: float = 0.25
    """From one to the next, counted in periods: half a turn of the phase at the middle hides in no
    gap."""
    least_u: float = 10.0
    """Of the uncertainty of a reading in the shortest one: the scatter of the angle that is read
    hides the phase of shorter ones."""
    sampled: float = 0.75
    """Share of the quarters of a period, over the range of the angles, that readings stand in."""


_PERIODS = _Periods()


def encoders(read_arcsec: Floats, model_arcsec: Floats, u_arcsec: float) -> list[Artefact]:
    """1 arcsec at each period that the readings can show. model_arcsec: the angles that a model
    computes, which do not scatter: how densely the readings stand is told by them."""
    range_arcsec = float(np.ptp(model_arcsec))
    if not range_arcsec > 0:
        return []
    most = range_arcsec / max(_PERIODS.least_u * u_arcsec, 1e-6 * range_arcsec)
    most = min(most, len(read_arcsec) / 4)
    found = []
    for count in np.arange(_PERIODS.fewest, most, _PERIODS.apart):
        quarters = np.floor(4 * count * (model_arcsec - model_arcsec.min()) / range_arcsec)
        if len(np.unique(quarters)) < _PERIODS.sampled * 4 * count:
            break
        phase = 2 * np.pi * count * read_arcsec / range_arcsec
        found.append(np.column_stack([np.cos(phase), np.sin(phase)]))
    return [Artefact("encoder", columns, among=len(found)) for columns in found]


def gains_of(gram: Floats, projection: Floats, sizes: Floats) -> Floats:
    """Of columns U by their products U'U (k, k) and with the readings U'y (k,), all whitened, and
    whatever else is free taken out; at s sizes, shape (s,)."""
    values, axes = eigen(gram)
    square = sizes[:, None] ** 2
    grown = 1 + square * np.maximum(values, 0.0)
    explained = square * (axes.T @ projection) ** 2 / grown
    return np.asarray(0.5 * (explained - np.log(grown)).sum(axis=1))


def without(artefact: Artefact, residual_arcsec: Floats, weight: Floats) -> Floats:
    """Arcsec, shape (n,); weight: of each reading, 1/arcsec^2."""
    columns = artefact.columns_arcsec
    weighted = weight[:, None] * columns
    mode = np.linalg.solve(
        columns.T @ weighted + np.eye(columns.shape[1]), weighted.T @ residual_arcsec
    )
    return np.asarray(residual_arcsec - columns @ mode)
