"""Elastic angle of a cycloid ball planetary transmission: an independent reference.

Plain Python on NumPy and SciPy. It shares neither code nor method with the product: where the
product linearises and iterates, this one only brackets. Every equilibrium is found by nested
root bracketing (rotation outside, the lateral shift of a floating plate inside it, the axial
approach innermost), and the state so found is refined by residuals in extended precision.
Slow on purpose; read it from top to bottom:

    contact.py                one Hertz contact from exact elliptic integrals; groove walls
    pairs.py                  dimensions and phase -> arms, stiffnesses, contact angles
    equilibrium.py            preload and torque -> approach, rotation, forces of a pair
    here: limits              the three threshold preloads, from the states that define them
          Drive, solve_drive  two pairs in series at a crank angle

SI units and radians; the unit is part of every name. Geometry after the 2017 paper,
DOI 10.1177/1687814017734112; the statics are derived afresh (see the docstrings).

Words. A *diagonal* is one way of squeezing a ball: between a wall of the one plate and the
opposite wall of the other, so it is two contacts in series. Each ball has two, "plus" (loaded by a
positive torque where the arm is positive) and "minus". A diagonal whose groove wall does not
exist has stiffness 0. A stiffness k means N = k delta^1.5, unit N/m^1.5.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

from scipy.optimize import brentq, minimize_scalar

from reference.contact import (
    RTOL,
    ContactState,
    Material,
    contact_state,
    contact_stiffness_N_per_m1p5,
)
from reference.equilibrium import (
    NOMINAL,
    Conditions,
    Solution,
    TorqueNotHeldError,
    capacity,
    solve_pair,
    torsional_stiffness_Nm_per_rad,
)
from reference.pairs import CrossSlide, Deceleration, MeshingPair, RingGroove

__all__ = [
    "Conditions",
    "ContactState",
    "CrossSlide",
    "Deceleration",
    "Drive",
    "DriveSolution",
    "Limits",
    "Material",
    "MeshingPair",
    "RingGroove",
    "Solution",
    "TorqueNotHeldError",
    "capacity",
    "contact_state",
    "contact_stiffness_N_per_m1p5",
    "drive_limits",
    "limits",
    "limits_over_period",
    "solve_drive",
    "solve_pair",
    "torsional_stiffness_Nm_per_rad",
]


# --- threshold preloads ---------------------------------------------------------------------


@dataclass(frozen=True)
class Limits:
    """Threshold preloads (N) of a torque: holding it, the state d = 0, no diagonal parted."""

    hold_N: float
    continuous_N: float | None
    zero_backlash_N: float


def _preload_where(
    pair: MeshingPair,
    torque_Nm: float,
    conditions: Conditions,
    hold_N: float,
    measure: Callable[[Solution], float],
) -> float:
    """The preload (N) above hold_N at which a measure of the equilibrium rises through zero."""

    def value(preload: float) -> float:
        return measure(solve_pair(pair, torque_Nm, preload, conditions))

    trials = [hold_N * (1 + above) for above in (1e-2, 1e-4, 1e-6, 1e-9)]
    low = next((p for p in trials if p > 0 and value(p) < 0), None)
    if hold_N == 0:  # no torque, gaps alone
        low = 1e-9
    if low is None:
        return hold_N
    high = max(2 * low, 1.0)
    while value(high) < 0:
        high *= 2
    return float(brentq(value, low, high, xtol=1e-15, rtol=10 * RTOL))


def limits(pair: MeshingPair, torque_Nm: float, conditions: Conditions = NOMINAL) -> Limits:
    """The three thresholds of a pair for a torque (N m), each from the state that defines it.

    hold: a preload just above it still has an equilibrium. continuous: the preload whose
    equilibrium has d = 0; with gaps the origin of d means nothing and it is None. zero backlash:
    the smallest preload at which no existing diagonal has parted. Gaps and the power law are
    respected, the axial spring is not: the thresholds speak of the force that reaches the points.
    """
    conditions = replace(conditions, spring_N_per_m=0.0)
    hold = abs(torque_Nm) / capacity(pair, 1 if torque_Nm >= 0 else -1)
    args = (pair, torque_Nm, conditions, hold)
    if torque_Nm == 0 and not conditions.has_gaps:
        return Limits(0.0, 0.0, 0.0)
    backlash = _preload_where(*args, lambda s: s.smallest_squeeze_m)
    if conditions.has_gaps:
        return Limits(hold, None, backlash)
    return Limits(hold, _preload_where(*args, lambda s: s.approach_m), backlash)


def largest_over_period(f: Callable[[float], float], period_rad: float, scan: int = 16) -> float:
    """Largest value of a periodic function of the phase: a scan, then the best two refined.

    The functions have kinks where one ball takes over from the next, which the bounded search
    follows as well as a smooth top, only more slowly.
    """
    step = period_rad / scan
    values = [f(i * step) for i in range(scan)]
    best = sorted(range(scan), key=lambda i: -values[i])[:2]
    found = [
        -minimize_scalar(
            lambda phase: -f(float(phase)),
            bounds=((i - 1) * step, (i + 1) * step),
            method="bounded",
            options={"xatol": 1e-10 * period_rad, "maxiter": 200},
        ).fun
        for i in best
    ]
    return float(max(*values, *found))


@cache
def limits_over_period(model: Deceleration | RingGroove | CrossSlide, torque_Nm: float) -> Limits:
    """The largest of each threshold (N) over one period of the phase."""
    if isinstance(model, CrossSlide):
        return limits(model.at(), torque_Nm)
    sign = 1 if torque_Nm >= 0 else -1
    names: dict[str, Callable[[Solution], float]] = {
        "continuous": lambda s: s.approach_m,
        "zero_backlash": lambda s: s.smallest_squeeze_m,
    }

    def hold(phase: float) -> float:
        return abs(torque_Nm) / capacity(model.at(phase), sign)

    def threshold(name: str) -> float:
        def at(phase: float) -> float:
            pair = model.at(phase)
            return _preload_where(pair, torque_Nm, NOMINAL, hold(phase), names[name])

        return largest_over_period(at, model.period_rad)

    return Limits(
        largest_over_period(hold, model.period_rad, scan=64),
        threshold("continuous"),
        threshold("zero_backlash"),
    )


# --- the drive ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Drive:
    """A deceleration pair with one kind of equal-speed pair."""

    deceleration: Deceleration
    equal_speed: RingGroove | CrossSlide

    def __post_init__(self) -> None:
        slide = isinstance(self.equal_speed, CrossSlide)
        if slide and self.deceleration.output == "epicycloid":
            raise ValueError("a cross-slide holds the planet of a drive with hypocycloid output")

    @property
    def ratio(self) -> float:
        """Turns of the crank per turn of the output: (Z2+1)/2 or -(Z2-1)/2."""
        z2 = self.deceleration.ball_count
        return (z2 + 1) / 2 if self.deceleration.output == "hypocycloid" else -(z2 - 1) / 2

    @property
    def transfer(self) -> float:
        """Torque on one equal-speed pair per torque on the output: 1, or Z1/Z3 on a slide."""
        z2 = self.deceleration.ball_count
        return (z2 - 1) / (z2 + 1) if isinstance(self.equal_speed, CrossSlide) else 1.0

    def phases_rad(self, crank_angle_rad: float) -> tuple[float, float]:
        """Phases of the two pairs: against the crank the balls and the planet turn backwards.

        -theta Z1/Z2 and -theta Z1/Z3 with the hypocycloid plate as output, theta Z3/Z2 and
        theta Z3/Z1 with the epicycloid plate.
        """
        z2 = self.deceleration.ball_count
        if self.deceleration.output == "hypocycloid":
            return -crank_angle_rad * (z2 - 1) / z2, -crank_angle_rad * (z2 - 1) / (z2 + 1)
        return crank_angle_rad * (z2 + 1) / z2, crank_angle_rad * (z2 + 1) / (z2 - 1)

    def pairs(self, crank_angle_rad: float) -> tuple[MeshingPair, MeshingPair]:
        """Deceleration pair and (one interface of) the equal-speed pair at a crank angle."""
        phi, psi = self.phases_rad(crank_angle_rad)
        return self.deceleration.at(phi), self.equal_speed.at(psi)


@dataclass(frozen=True)
class DriveSolution:
    """Angles of a drive (rad).

    equal_speed_rad is that pair's own angle under the torque that it carries (on a cross-slide
    the sum of both interfaces), equal_speed_at_output_rad what of it reaches the output; total
    is deceleration + equal_speed_at_output. paper_total_rad puts the full torque on a cross-slide
    and its full angle on the output, as the 2017 paper does (None if its slide cannot hold that).
    """

    deceleration: Solution
    equal_speed: Solution
    equal_speed_rad: float
    equal_speed_at_output_rad: float
    total_rad: float
    paper_total_rad: float | None


def solve_drive(
    drive: Drive, crank_angle_rad: float, torque_Nm: float, preload_N: float
) -> DriveSolution:
    """Elastic angle of the drive: alpha1(M0) + alpha2(M0) with ring grooves.

    With a cross-slide alpha1(M0) + (Z1/Z3) alpha3(M0 Z1/Z3), alpha3 the sum over two equal
    interfaces in series. The same preload passes through every pair.
    """
    reducer, coupling = drive.pairs(crank_angle_rad)
    first = solve_pair(reducer, torque_Nm, preload_N)
    second = solve_pair(coupling, torque_Nm * drive.transfer, preload_N)
    series = 2 if isinstance(drive.equal_speed, CrossSlide) else 1
    own = series * second.alpha_rad
    paper: float | None
    try:
        paper = first.alpha_rad + series * solve_pair(coupling, torque_Nm, preload_N).alpha_rad
    except TorqueNotHeldError:
        paper = None
    at_output = own * drive.transfer
    return DriveSolution(first, second, own, at_output, first.alpha_rad + at_output, paper)


def drive_limits(drive: Drive, torque_Nm: float, crank_angle_rad: float | None = None) -> Limits:
    """The larger of each threshold (N) of both pairs, for a torque (N m) on the output.

    At one crank angle, or (None) the largest over each pair's own period.
    """
    torques = (torque_Nm, torque_Nm * drive.transfer)
    if crank_angle_rad is None:
        models = (drive.deceleration, drive.equal_speed)
        found = [limits_over_period(m, q) for m, q in zip(models, torques, strict=True)]
    else:
        pairs = drive.pairs(crank_angle_rad)
        found = [limits(p, q) for p, q in zip(pairs, torques, strict=True)]
    return Limits(
        max(f.hold_N for f in found),
        max(f.continuous_N or 0.0 for f in found),
        max(f.zero_backlash_N for f in found),
    )
