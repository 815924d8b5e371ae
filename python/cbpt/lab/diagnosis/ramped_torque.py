"""Torques that were ramped: whether the scatter of their readings is the torque's or the sensor's.

ramped_torque  a campaign with the torque of each ramp as a polynomial, where the angle does not
               follow what is left of it

A torque that goes smoothly up and down is known better from all readings of a ramp than from one of
them, and the scatter of the sensor is none of the drive's. Left in the torques it is far larger
than what angles scatter by, and whatever makes the angle follow the torque less is then more
probable than the drive (errors in variables: Fuller, Measurement Error Models, 1987). The error
that a polynomial has belongs to the uncertainty of the angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.diagnosis.followed import at_torques, stays
from cbpt.lab.diagnosis.held_torque import with_torque_errors
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.readings.turns import turns_of

__all__ = ["ramped_torque"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """What counts as a ramp whose torque scatters."""

    fewest: int = 8
    """Readings of a ramp."""
    turn: float = 0.04
    of_scatter: float = 5.0
    """A ramp ends where the torque turns back by more than this share of the range of the run, and
    by more than so many standard deviations of its scatter."""
    degree: int = 5
    """Of a polynomial at most."""
    ramps: float = 0.8
    """Share of the readings that are of ramps, at least."""
    chance: float = 0.001
    """With which what is left may be as much the same in all ramps."""
    sigmas: float = 3.0
    """By which what is left of a polynomial may be more than scatter, or alike from reading to
    reading."""


_LIMITS = _Limits()


def ramped_torque(
    campaign: Campaign, model: Callable[[Campaign], Floats]
) -> tuple[Campaign, list[str]]:
    """The campaign with the torques of its ramps where their readings scatter, and a note.

    model: the case at every reading of a campaign, arcsec.
    """
    torque = campaign.readings.torque_Nm
    scatter_Nm = _scatter(campaign)
    if not scatter_Nm > 1e-6 * float(np.abs(torque).max()):
        return campaign, []
    smooth, on_ramps = torque.copy(), np.zeros(len(torque), dtype=bool)
    modes: list[Floats] = []
    for ramps in _alike(campaign, scatter_Nm):
        found = _pooled_or_each(campaign, ramps)
        if found is not None and _fits(
            found, torque[np.concatenate(ramps)], len(ramps), scatter_Nm
        ):
            rows = np.concatenate(ramps)
            smooth[rows], on_ramps[rows] = found.torque_Nm, True
            modes.append(np.zeros((len(torque), found.free)))
            modes[-1][rows] = scatter_Nm * found.basis
    if np.count_nonzero(on_ramps) < _LIMITS.ramps * len(torque):
        return campaign, []
    other = at_torques(campaign, smooth)
    at_smooth = model(other)
    follows, off = model(campaign) - at_smooth, campaign.y_arcsec - at_smooth
    # Beside the torque at which the balls slip the model has no solution on one side.
    solved = bool(np.isfinite(at_smooth).all())
    if not solved or not _stays(campaign, follows, off, on_ramps):
        return campaign, []
    # By one standard deviation of the scatter each way.
    up, down = (model(at_torques(campaign, smooth + sign * scatter_Nm)) for sign in (1.0, -1.0))
    up, down = (np.where(np.isfinite(end), end, at_smooth) for end in (up, down))
    sides = 2.0 - (up == at_smooth) - (down == at_smooth)
    slope = (up - down) / (np.maximum(sides, 1.0) * scatter_Nm)
    return with_torque_errors(other, np.column_stack(modes) * slope[:, None]), [
        f"the torque readings scatter by {scatter_Nm:.2g} N m about smooth ramps, and the angle "
        "does not follow: polynomials through the readings of the ramps are used, with their "
        "uncertainty"
    ]


def _fits(found: _Smooth, torque_Nm: Floats, ramps: int, scatter_Nm: float) -> bool:
    """Whether what polynomials leave is scatter: no more than second differences show, not alike
    from reading to reading, and not the same in each ramp (von Neumann 1941; chi-squared)."""
    from scipy.special import chdtrc

    left = (torque_Nm - found.torque_Nm).reshape(ramps, -1)
    n = left.size
    if found.left_Nm > (1 + _LIMITS.sigmas * (3 / n) ** 0.5) * scatter_Nm:
        return False
    together = float(np.sum(left[:, 1:] * left[:, :-1]) / max(np.sum(left**2), 1e-300))
    if together > _LIMITS.sigmas / n**0.5:
        return False
    means = left.mean(axis=0)
    own = float(np.sum((left - means) ** 2)) / max(n - len(means), 1)
    if ramps < 3 or not own > 0:
        return True
    return float(chdtrc(len(means), ramps * float(means @ means) / own)) > _LIMITS.chance


def _stays(campaign: Campaign, follows: Floats, off: Floats, on_ramps: NDArray[np.bool_]) -> bool:
    """Whether the angle stays where the torque scatters: what both do from reading to reading."""
    rows = campaign.rows
    pairs = np.concatenate([run[:-1] for run in np.split(rows.order, rows.starts[1:])])
    behind = np.concatenate([run[1:] for run in np.split(rows.order, rows.starts[1:])])
    use = on_ramps[pairs] & on_ramps[behind]
    x, y = ((v[behind] - v[pairs])[use] for v in (follows, off))
    solved = np.isfinite(x) & np.isfinite(y)
    x, y = x[solved], y[solved]
    # Differences of neighbours count each reading twice.
    return len(x) >= _LIMITS.fewest and stays(x, y, (len(x) - 1) / 2)


def _scatter(campaign: Campaign) -> float:
    """Of the torque, N m: second differences along the runs."""
    torque, rows = campaign.readings.torque_Nm, campaign.rows
    runs = [run for run in np.split(rows.order, rows.starts[1:]) if len(run) >= _LIMITS.fewest]
    return float(np.median([neighbour_scatter([torque[run]], 2) for run in runs])) if runs else 0.0


def _alike(campaign: Campaign, scatter_Nm: float) -> list[list[Ints]]:
    """Ramps from turn to turn, those of as many readings the same way together; the reading at
    which a torque turns is of the ramp before."""
    torque, rows = campaign.readings.torque_Nm, campaign.rows
    found: dict[tuple[int, bool], list[Ints]] = {}
    for run in np.split(rows.order, rows.starts[1:]):
        least = max(_LIMITS.turn * float(np.ptp(torque[run])), _LIMITS.of_scatter * scatter_Nm)
        turns = turns_of(torque[run], least)[1:-1]
        for ramp in np.split(run, np.array(turns, dtype=np.int64) + 1):
            if len(ramp) >= _LIMITS.fewest:
                rises = bool(torque[ramp[-1]] > torque[ramp[0]])
                found.setdefault((len(ramp), rises), []).append(ramp)
    return list(found.values())


@dataclass(frozen=True, eq=False)
class _Smooth:
    """Polynomials through the torques of ramps, one after the other; arrays of shape (n,)."""

    torque_Nm: Floats
    basis: Floats
    """Orthonormal, shape (n, free): the error of the torques are so many normal numbers times it,
    with the standard deviation of a reading."""
    square: float
    """Sum of the squares that are left, (N m)^2."""

    @property
    def free(self) -> int:
        """How many numbers they have."""
        return int(self.basis.shape[1])

    @property
    def left_Nm(self) -> float:
        """Standard deviation of the readings about them."""
        return float(np.sqrt(self.square / max(len(self.torque_Nm) - self.free, 1)))

    @property
    def price(self) -> float:
        """Of two the smaller one is the more probable (BIC: Schwarz 1978)."""
        n = len(self.torque_Nm)
        return float(n * np.log(max(self.square, 1e-300)) + self.free * np.log(n))


def _pooled_or_each(campaign: Campaign, ramps: list[Ints]) -> _Smooth | None:
    """One polynomial for all ramps, or one for each."""
    pooled = _polynomial(campaign, ramps)
    each = [_polynomial(campaign, [ramp]) for ramp in ramps]
    from scipy.linalg import block_diag

    known = [one for one in each if one is not None]
    if len(known) < len(each) or pooled is None:
        return pooled
    apart = _Smooth(
        np.concatenate([one.torque_Nm for one in known]),
        block_diag(*(one.basis for one in known)),
        sum(one.square for one in known),
    )
    return min(pooled, apart, key=lambda one: one.price)


def _polynomial(campaign: Campaign, ramps: list[Ints]) -> _Smooth | None:
    """The most probable one through ramps, along their time or from reading to reading; None where
    there are hardly more readings than numbers."""
    rows = np.concatenate(ramps)
    torque, time_s = campaign.readings.torque_Nm[rows], campaign.readings.time_s
    ways = [np.concatenate([np.linspace(-1.0, 1.0, len(ramp)) for ramp in ramps])]
    if time_s is not None:
        passed = np.concatenate([time_s[ramp] - time_s[ramp[0]] for ramp in ramps])
        if passed.max() > 0:
            ways.append(2 * passed / passed.max() - 1)
    found = []
    for along in ways:
        for degree in range(1, min(_LIMITS.degree, len(ramps[0]) - 4) + 1):
            q = np.linalg.qr(np.polynomial.legendre.legvander(along, degree))[0]
            fitted = q @ (q.T @ torque)
            square = float(np.sum((torque - fitted) ** 2))
            found.append(_Smooth(fitted, q, square))
    return min(found, key=lambda one: one.price, default=None)
