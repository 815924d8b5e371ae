"""What is read off a loop: the figures of catalogues, each by its definition.

    Convention   rated torque, window and break torques
    DEFINITIONS  name -> unit and convention in words
    of_loop      the figures of one loop
    stiffness_of the stiffness of one branch over the torque
    curve_of     the centre line of a loop as a curve from zero torque

Definitions after RV, cycloidal and strain-wave catalogues and GB/T 40731-2021. Makers differ: what
cycloidal catalogues call backlash (the width at zero torque) is `hysteresis_loss` here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.loops import Branch, Loop
from cbpt.lab.characteristics.play import friction_torque_Nm, play_of
from cbpt.lab.characteristics.three_pieces import ThreePieces, three_pieces
from cbpt.results import ARCSEC_PER_RAD

Floats = NDArray[np.float64]

ARCSEC_PER_ARCMIN = 60.0


@dataclass(frozen=True)
class Convention:
    """At which torques figures are read off."""

    rated_torque_Nm: float
    window: float = 0.03
    """Share of the rated torque at which lost motion is read: 3 %; strain-wave makers: 4 %."""
    breaks_Nm: tuple[float, float] | None = None
    """Break torques T1 and T2, where they are given."""

    @property
    def window_Nm(self) -> float:
        """The torque of lost motion."""
        return self.window * self.rated_torque_Nm


@dataclass(frozen=True)
class _Shares:
    """Of the rated torque, where nothing else is said."""

    rigid: tuple[float, float] = (0.5, 1.0)
    """Between which the torsional rigidity is taken."""
    least_reach: float = 0.75
    """To which a loop must go for that at least."""
    curve: float = 0.05
    """Half the span of a stiffness."""
    as_soft: float = 0.9
    """A branch that has turned turns by this share of what the other one does, once friction has
    come round."""
    turned: float = 0.5
    """Of the amplitude: nearer to zero torque no readings are left out for a branch that has just
    turned, however large friction is."""


_SHARES = _Shares()
CURVE_POINTS = 19
ROUNDING = 1e-6
"""Share of a figure, or of the angle of a loop, that is rounding, and what extrapolation leaves."""

_PIECES = (
    "three straight pieces laid through the centre line: K1, K2 and K3 are their stiffnesses, T1 "
    "and T2 the torques where they meet. They go from zero torque to where a loop that turns round "
    "has taken up its friction: twice its torque below the end, and until both branches turn alike"
)
DEFINITIONS: Mapping[str, tuple[str, str]] = {
    "lost_motion": (
        "arcsec",
        "angle between +{window} and -{window} of rated torque on the centre line of the loop",
    ),
    "hysteresis_loss": (
        "arcsec",
        "angle between both branches at zero torque after a full loop (cycloidal catalogues call "
        "it backlash)",
    ),
    "backlash": ("arcsec", ""),
    "torsional_rigidity": (
        "N m/arcmin",
        "change of torque over change of angle between 50 % and 100 % of rated torque; the angle "
        "is the mean of both branches, on each side of zero that has both",
    ),
    "K1": ("N m/arcmin", _PIECES),
    "K2": ("N m/arcmin", _PIECES),
    "K3": ("N m/arcmin", _PIECES),
    "T1": ("N m", _PIECES),
    "T2": ("N m", _PIECES),
    "loop_energy": ("J", "area of the loop: the energy that a cycle loses"),
}
NAMES = tuple(DEFINITIONS)


def of_loop(loop: Loop, convention: Convention) -> dict[str, float]:
    """Figures of one loop in the units of `DEFINITIONS`; NaN for what it does not have.

    Backlash may be below zero here. Beside it `straight`, the same from straight lines.
    """
    found = dict.fromkeys((*NAMES, "straight"), np.nan)
    found["torsional_rigidity"] = _rigidity(loop, convention)
    found |= _pieces(loop, convention)
    if not (loop.whole and loop.rising and loop.falling):
        return found
    rising, falling = loop.rising, loop.falling
    window = convention.window_Nm * np.array([-1.0, 1.0])
    found["lost_motion"] = float(np.diff(0.5 * (rising.at(window) + falling.at(window)))[0])
    found["hysteresis_loss"] = float(falling.at(0.0) - rising.at(0.0))
    play = play_of(loop)
    found["backlash"], found["straight"] = play.jump_arcsec, play.straight_arcsec
    low, high = _shared(rising, falling)
    area = falling.integral(low, high) - rising.integral(low, high)
    found["loop_energy"] = area / ARCSEC_PER_RAD
    return found


def _shared(*branches: Branch) -> tuple[float, float]:
    """The torques that all branches have."""
    return max(b.ends_Nm[0] for b in branches), min(b.ends_Nm[1] for b in branches)


def _rigidity(loop: Loop, convention: Convention) -> float:
    """Torque over angle, the angle averaged over both branches on each side of zero where both go
    far enough; to the end of a branch that does not quite reach the rated torque.

    Averaged as angles, because just after a turn a branch may hardly move at all.
    """
    if not (loop.rising and loop.falling):
        return np.nan
    rated, compliances = convention.rated_torque_Nm, list[float]()
    for sign, side in ((-1.0, 0), (1.0, 1)):
        reach = min(sign * branch.ends_Nm[side] for branch in loop.branches)
        reach = min(reach, _SHARES.rigid[1] * rated)
        ends = sign * np.array([_SHARES.rigid[0] * rated, reach])
        if reach >= _SHARES.least_reach * rated:
            ways = [float(np.diff(branch.at(ends))[0]) for branch in loop.branches]
            compliances += [way / float(np.diff(ends)[0]) for way in ways]
    return _stiffness(float(np.mean(compliances))) if compliances else np.nan


def curve_of(loop: Loop, rated_torque_Nm: float) -> tuple[Floats, Floats]:
    """Torques above 0 up to the rated one and the angle of the centre line from zero there, the
    mean of both signs where there are both; shape (k,). At the torques that were measured, but for
    those where friction turns back: there the curve has a corner that no spring has."""
    low, high = _slid(loop)
    knots = np.abs(np.concatenate([branch.knots_Nm for branch in loop.branches]))
    largest = min(max(-low, high), rated_torque_Nm)
    knots = np.unique(np.round(knots[(knots > 0) & (knots <= largest * (1 + 1e-9))], 12))

    def centre(torque: Floats | float) -> Floats:
        return np.asarray(np.mean([branch.at(torque) for branch in loop.branches], axis=0))

    if loop.whole:
        angle = 0.5 * (centre(knots) - centre(-knots))
    else:
        side = 1.0 if high > -low else -1.0
        zero = min(max(0.0, low), high)
        angle = side * (centre(side * knots) - centre(zero))
    solid = np.isfinite(angle)
    return knots[solid], angle[solid]


def _slid(loop: Loop) -> tuple[float, float]:
    """The torques that all branches have, without those from a turn to where friction has come
    round: twice its torque, and until the branch that has turned is as soft as the other one."""
    low, high = _shared(*loop.branches)
    friction = float(np.nan_to_num(friction_torque_Nm(loop)))
    least = _SHARES.turned * loop.amplitude_Nm
    first = max(low + 2 * friction, -_round_at(loop.rising, loop.falling, -low, -1, least))
    last = min(high - 2 * friction, _round_at(loop.falling, loop.rising, high, 1, least))
    return min(first, max(low, -least)), max(last, min(high, least))


def _round_at(
    turned: Branch | None, other: Branch | None, end_Nm: float, side: int, least_Nm: float
) -> float:
    """The torque on one side of zero, no less than the least, at which a branch that has turned at
    the end is as soft as the other one there."""
    if turned is None or other is None or end_Nm <= least_Nm:
        return end_Nm
    span = _SHARES.curve * end_Nm
    torque = np.linspace(end_Nm - span, least_Nm, CURVE_POINTS)
    ways = [
        np.abs(branch.at(side * (torque + span)) - branch.at(side * (torque - span)))
        for branch in (turned, other)
    ]
    soft = np.flatnonzero(ways[0] >= _SHARES.as_soft * ways[1])
    return float(torque[soft[0]]) if len(soft) else least_Nm


def _pieces(loop: Loop, convention: Convention) -> dict[str, float]:
    found = pieces_of(loop, convention)
    if found is None:
        return {}
    least = ROUNDING * max(found.compliances)
    stiffness = {
        f"K{i}": _stiffness(c) if c > least else np.nan for i, c in enumerate(found.compliances, 1)
    }
    return stiffness | _breaks(found, convention)


def pieces_of(loop: Loop, convention: Convention) -> ThreePieces | None:
    """Three straight pieces through the curve from zero torque; None with few torques."""
    torque, angle = curve_of(loop, convention.rated_torque_Nm)
    return three_pieces(torque, angle, convention.breaks_Nm)


def _breaks(found: ThreePieces, convention: Convention) -> dict[str, float]:
    if convention.breaks_Nm is None and not found.broken:
        return {"T1": np.nan, "T2": np.nan}
    return dict(zip(("T1", "T2"), found.breaks_Nm, strict=True))


def _stiffness(compliance: float) -> float:
    return ARCSEC_PER_ARCMIN / compliance if compliance > 0 else np.nan


def curve_torques(convention: Convention) -> Floats:
    """Torques at which the stiffness curve is told, shape (k,)."""
    end = 1.0 - _SHARES.curve
    return convention.rated_torque_Nm * np.linspace(-end, end, CURVE_POINTS)


def stiffness_of(branch: Branch | None, convention: Convention) -> Floats:
    """The secant stiffness of a branch about each torque of the curve, N m/arcmin; NaN where the
    branch does not go or the angle does not change."""
    torque = curve_torques(convention)
    if branch is None:
        return np.full(len(torque), np.nan)
    span = _SHARES.curve * convention.rated_torque_Nm
    way = branch.at(torque + span) - branch.at(torque - span)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(way > 0, 2 * span * ARCSEC_PER_ARCMIN / way, np.nan)
