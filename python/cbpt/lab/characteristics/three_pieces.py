"""K1, K2, K3: a curve from zero torque as three straight pieces (catalogues of strain-wave gears).

    alpha(T) = T/K1 up to T1, then with 1/K2 up to T2, then with 1/K3

least squares in the angle. For given break torques that is linear; free ones are searched over the
torques of the curve and then polished, with the three slopes refitted at each (variable
projection, Golub and Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """When a curve is broken."""

    fewest: int = 8
    """Points of a curve on which five numbers are fitted."""
    searched: int = 16
    """Torques at which a break is looked for first."""
    polished: int = 12
    """Steps from the best of these."""
    chance: float = 0.01
    """Chance at which a straight curve would be taken for a broken one (F test)."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class ThreePieces:
    """Compliances in arcsec/(N m), break torques in N m; `broken`: whether pieces are needed."""

    compliances: tuple[float, float, float]
    breaks_Nm: tuple[float, float]
    broken: bool


def three_pieces(
    torque_Nm: Floats, angle_arcsec: Floats, breaks_Nm: Sequence[float] | None = None
) -> ThreePieces | None:
    """The best three pieces through a curve, torques above 0, shape (n,); None with few points."""
    if len(torque_Nm) < _LIMITS.fewest:
        return None
    if breaks_Nm is None:
        breaks_Nm = _searched(torque_Nm, angle_arcsec)
    first, second = sorted(breaks_Nm)
    slopes, left = _fitted(torque_Nm, angle_arcsec, first, second)
    single = float(torque_Nm @ angle_arcsec / (torque_Nm @ torque_Nm))
    straight = float(np.sum((angle_arcsec - single * torque_Nm) ** 2))
    rest = float(left @ left)
    tiny = (1e-10 * float(np.ptp(angle_arcsec))) ** 2 * len(torque_Nm)
    return ThreePieces(
        (float(slopes[0]), float(slopes[1]), float(slopes[2])),
        (float(first), float(second)),
        broken=straight > tiny and _beyond_chance(straight, rest, len(torque_Nm)),
    )


def _beyond_chance(straight: float, rest: float, n: int) -> bool:
    from scipy.special import fdtrc

    if rest <= 1e-12 * straight:
        return True
    ratio = (straight - rest) / 4 / (rest / (n - 5))
    return float(fdtrc(4, n - 5, ratio)) < _LIMITS.chance


def _columns(torque: Floats, first: float, second: float) -> Floats:
    pieces = [
        np.minimum(torque, first),
        np.clip(torque - first, 0.0, second - first),
        np.maximum(torque - second, 0.0),
    ]
    return np.column_stack(pieces)


def _fitted(torque: Floats, angle: Floats, first: float, second: float) -> tuple[Floats, Floats]:
    """Slopes and what they leave, shape (3,) and (n,)."""
    columns = _columns(torque, first, second)
    slopes: Floats = np.linalg.lstsq(columns, angle, rcond=None)[0].astype(np.float64)
    return slopes, angle - columns @ slopes


def _squares(torque: Floats, angle: Floats, places: Floats, pairs: NDArray[np.int64]) -> Floats:
    """What the best slopes leave with breaks at each pair of places, shape (k,), by the normal
    equations: quick, and good enough to choose by."""
    # Three pieces are a straight line that bends at two places.
    bends = np.maximum(torque - places[:, None], 0.0)
    columns = np.vstack([torque, bends])
    products, by_angle = columns @ columns.T, columns @ angle
    chosen = np.column_stack([np.zeros(len(pairs), dtype=np.int64), 1 + pairs])
    matrix = products[chosen[:, :, None], chosen[:, None, :]] + 1e-12 * np.eye(3)
    right = by_angle[chosen]
    slopes = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
    return np.asarray(angle @ angle - np.sum(right * slopes, axis=1))


def _searched(torque: Floats, angle: Floats) -> tuple[float, float]:
    from scipy.optimize import least_squares

    inside = np.unique(torque)[1:-1]
    places = np.unique(np.quantile(inside, np.linspace(0, 1, _LIMITS.searched), method="nearest"))
    pairs = np.column_stack(np.triu_indices(len(places), 1))
    lefts = _squares(torque, angle, places, pairs) if len(pairs) else np.array([np.inf])
    start = places[pairs[int(np.argmin(lefts))]] if len(pairs) else places[[0, -1]]
    low, high = float(inside[0]), float(inside[-1])
    size = float(np.ptp(angle)) or 1.0

    def rest(breaks: Floats) -> Floats:
        return np.asarray(_fitted(torque, angle, *np.sort(breaks))[1] / size)

    def derivative(breaks: Floats) -> Floats:
        """Of what is left once the slopes follow (Kaufman 1975): a break moves what lies beyond it
        by how much the slope changes there, but for what the slopes make up for."""
        order = np.argsort(breaks)
        first, second = breaks[order]
        slopes, _ = _fitted(torque, angle, first, second)
        columns = np.linalg.qr(_columns(torque, first, second))[0]
        moved = np.diff(slopes) * (torque[:, None] > breaks[order])
        found = np.empty_like(moved)
        found[:, order] = moved - columns @ (columns.T @ moved)
        return found / size

    tight = 1e-12
    bounds = ([low, low], [high, high])
    found = least_squares(
        *(rest, start, derivative),
        bounds=bounds,
        xtol=tight,
        ftol=tight,
        gtol=tight,
        max_nfev=_LIMITS.polished,
    )
    best = float(lefts.min())
    first, second = np.sort(found.x if 2 * found.cost * size**2 <= best else start)
    return float(first), float(second)
