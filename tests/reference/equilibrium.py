"""Equilibrium of one pair in the reference model: torque and preload to rotation and forces.

Root bracketing throughout, three levels deep, then residuals in extended precision. SI units and
radians; the words are those of forward.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from reference.contact import HERTZ_EXPONENT, RTOL, Floats, contact_state
from reference.pairs import MeshingPair

Real = float | np.floating[Any]  # double, or long double where rounding is taken out
RealArray = NDArray[np.floating[Any]]

LAW_LENGTH_M = 1e-6  # delta_0 of the general power law
SMALL_DISPLACEMENT = 0.05  # of the ball radius; beyond it the linear geometry is doubtful


# --- conditions and the points that carry ---------------------------------------------------


@dataclass(frozen=True)
class Conditions:
    """What may act on a pair besides torque and preload.

    Gaps, one entry per ball (m) or None for none: axial_m adds to the approach (a tilted plate),
    normal_m along both contact normals (a ball's size), in_plane_m to the in-plane displacement
    arm * rotation (groove pitch). exponent n: N = k d0^1.5 (delta/d0)^n with d0 = 1 um.
    spring_N_per_m k_c: the preload that reaches the points is N_Z - k_c (d - d0'), d0' the
    approach at zero torque.
    """

    axial_m: Floats | None = None
    normal_m: Floats | None = None
    in_plane_m: Floats | None = None
    exponent: float = HERTZ_EXPONENT
    spring_N_per_m: float = 0.0

    @property
    def has_gaps(self) -> bool:
        """Whether any gap term is given."""
        return any(g is not None for g in (self.axial_m, self.normal_m, self.in_plane_m))


NOMINAL = Conditions()


@dataclass(frozen=True)
class _Diagonals:
    """The existing diagonals of a pair in one list, plus first, then minus; sign is +1 or -1."""

    sign: Floats
    arm: Floats
    sin: Floats
    cos: Floats
    stiffness: Floats
    axial: Floats
    normal: Floats
    in_plane: Floats
    exponent: float
    floating: bool
    place: NDArray[np.intp]  # index in [plus of all balls, minus of all balls]
    spring: float = 0.0
    spring_zero: float = 0.0

    def deltas(self, d: Real, alpha: Real, t: Real) -> RealArray:
        """Squeeze of each diagonal (m), negative where it has parted.

        delta = (d + zeta) sin(beta) + g +- (arm alpha + t + p) cos(beta): the plates approach by
        d along the axis, and the output plate turns by alpha, which moves its groove by
        arm * alpha along the in-plane normal; t is the lateral shift of a floating plate.
        """
        in_plane = self.arm * alpha + t + self.in_plane
        return (d + self.axial) * self.sin + self.normal + self.sign * in_plane * self.cos

    def forces(self, deltas: RealArray) -> RealArray:
        """Normal force (N) of each diagonal; a parted one carries nothing."""
        squeezed = np.maximum(deltas, 0) / LAW_LENGTH_M
        return np.asarray(self.stiffness * LAW_LENGTH_M**1.5 * squeezed**self.exponent)

    def balance(self, d: Real, alpha: Real, t: Real) -> tuple[Real, Real, Real]:
        """Axial force (N), torque (N m) and lateral force (N) that this state carries."""
        n = self.forces(self.deltas(d, alpha, t))
        axial = (n * self.sin).sum() + self.spring * (d - self.spring_zero)
        in_plane = self.sign * n * self.cos
        return axial, (in_plane * self.arm).sum(), in_plane.sum()


def _diagonals(pair: MeshingPair, conditions: Conditions) -> _Diagonals:
    """The existing diagonals of both kinds, flattened; the spring is added by solve_pair."""
    count = len(pair.arm_m)
    stiffness = np.concatenate([pair.stiffness_plus_N_per_m1p5, pair.stiffness_minus_N_per_m1p5])
    angle = np.repeat([pair.contact_angle_plus_rad, pair.contact_angle_minus_rad], count)
    place = np.flatnonzero(stiffness > 0)

    def both(values: Floats | None) -> Floats:
        one = np.zeros(count) if values is None else np.asarray(values, dtype=np.float64)
        return np.tile(one, 2)[place]

    return _Diagonals(
        sign=np.repeat([1.0, -1.0], count)[place],
        arm=both(pair.arm_m),
        sin=np.sin(angle)[place],
        cos=np.cos(angle)[place],
        stiffness=stiffness[place],
        axial=both(conditions.axial_m),
        normal=both(conditions.normal_m),
        in_plane=both(conditions.in_plane_m),
        exponent=conditions.exponent,
        floating=pair.floating,
        place=place,
    )


# --- equilibrium by nested bracketing -------------------------------------------------------


def _approach(points: _Diagonals, preload_N: float, alpha: float, t: float) -> float:
    """Innermost: the approach d (m) at which the axial force is the preload; it grows with d.

    Below the d at which the first diagonal touches there is no force; where that first one would
    carry the whole preload alone there is at least enough. The root lies between.
    """
    touch = -points.deltas(0.0, alpha, t) / points.sin
    low = float(touch.min())
    need = preload_N
    if points.spring > 0:
        low = min(low, points.spring_zero + preload_N / points.spring)
        need -= points.spring * (low - points.spring_zero)
    first = int(touch.argmin())
    unit = points.stiffness[first] * LAW_LENGTH_M**1.5 * points.sin[first]
    alone = LAW_LENGTH_M * (need / unit) ** (1 / points.exponent) / points.sin[first]
    high = float(touch[first] + alone)
    high += 1e-12 * (abs(high) + alone)

    def excess(d: float) -> float:
        return float(points.balance(d, alpha, t)[0]) - preload_N

    if excess(low) >= 0:
        return low
    return _root(excess, low, high)


def _root(f: Callable[[float], float], low: float, high: float) -> float:
    """Root of f between low and high, down to the rounding of the larger end."""
    resolution = 1e-16 * max(abs(low), abs(high))
    return float(brentq(f, low, high, xtol=resolution, rtol=RTOL, maxiter=1000))


def _grow(f: Callable[[float], float], width: float) -> tuple[float, float]:
    """Move up or down from +-width, doubling, until the growing function f changes its sign."""
    low, high = -width, width
    for _ in range(400):
        if f(high) < 0:
            low, high = high, 2 * high
        elif low < 0 and f(low) > 0:
            low, high = 2 * low, low
        else:
            return low, high
    raise ArithmeticError("no bracket found")


def _lateral(points: _Diagonals, preload_N: float, alpha: float, scale: float) -> float:
    """Middle: the shift t (m) of a floating plate at which its grooves' forces balance."""
    if not points.floating:
        return 0.0

    def force(t: float) -> float:
        return float(points.balance(_approach(points, preload_N, alpha, t), alpha, t)[2])

    width = scale + float(np.abs(points.arm * alpha + points.in_plane).max())
    return _root(force, *_grow(force, width))


def _rotation(points: _Diagonals, torque_Nm: float, preload_N: float) -> tuple[float, float, float]:
    """Outermost: the rotation (rad) at which the balls carry the torque; it grows with alpha.

    Monotone because the elastic energy is convex in (d, alpha, t) and stays so in alpha alone
    once the others have been put at their minimum. Returns d, alpha, t.
    """
    scale = _approach(points, preload_N, 0.0, 0.0) - float(
        (-points.deltas(0.0, 0.0, 0.0) / points.sin).min()
    )

    def state(alpha: float) -> tuple[float, float, float]:
        t = _lateral(points, preload_N, alpha, scale)
        return _approach(points, preload_N, alpha, t), alpha, t

    def excess(alpha: float) -> float:
        return float(points.balance(*state(alpha))[1]) - torque_Nm

    width = scale / float(np.abs(points.arm).max())
    return state(_root(excess, *_grow(excess, width)))


def _jacobian(points: _Diagonals, x: tuple[float, float, float]) -> Floats:
    """Derivatives of (axial, torque, lateral) by (d, alpha, t); 2 by 2 where nothing floats."""
    squeezed = np.maximum(points.deltas(*x), 0) / LAW_LENGTH_M
    slope = points.stiffness * LAW_LENGTH_M**0.5 * points.exponent
    slope = slope * squeezed ** (points.exponent - 1)
    side = points.sign * points.cos
    rows = np.array([points.sin, side * points.arm, side])
    matrix: Floats = (rows * slope) @ rows.T
    matrix[0, 0] += points.spring
    size = 3 if points.floating else 2
    return matrix[:size, :size]


def _refine(
    points: _Diagonals, x: tuple[float, float, float], torque: np.longdouble, preload: np.longdouble
) -> NDArray[np.longdouble]:
    """Take rounding out of a bracketed state: residuals in long double, a few corrections.

    The bracketing decides which state it is; a correction is kept only while it shrinks. Raises
    ArithmeticError if the balance is then not met to 1e-14 of the forces in it.
    """
    state = np.array(x, dtype=np.longdouble)
    free = 3 if points.floating else 2
    last = math.inf
    lever = float(np.abs(points.arm).max())
    for _ in range(8):
        axial, moment, lateral = points.balance(*state)
        residual = np.array([axial - preload, moment - torque, lateral])[:free]
        place = (float(state[0]), float(state[1]), float(state[2]))
        try:
            step = np.linalg.solve(_jacobian(points, place), residual.astype(np.float64))
        except np.linalg.LinAlgError:  # on the very edge of contact: leave what was bracketed
            break
        size = float(np.abs(step * [1, lever, 1][:free]).sum())
        if not size < last:
            break
        state[:free] -= step
        last = size
    axial, moment, lateral = points.balance(*state)
    off = [axial - preload, (moment - torque) / lever, lateral if points.floating else 0.0]
    if not max(abs(float(v)) for v in off) <= 1e-14 * float(preload):
        raise ArithmeticError("equilibrium not reached")
    return state


# --- the solution --------------------------------------------------------------------------


def capacity(pair: MeshingPair, sign: int) -> float:
    """Largest torque per newton of preload (m) that non-negative forces can balance.

    Forces form a cone; the torque is largest on one of its edges. Where only axial force and
    torque are prescribed an edge is one diagonal: +- arm cot(beta). Where a floating plate must
    be balanced as well an edge is a plus and a minus with the same in-plane force.
    sign is +1 or -1, that of the torque. Gaps and the power law have no say in it.
    """
    points = _diagonals(pair, Conditions())
    lever = sign * points.sign * points.arm * points.cos
    if not points.floating:
        return float((lever / points.sin).max())
    plus, minus = points.sign > 0, points.sign < 0
    with_plus = (lever / points.cos)[plus][:, None] + (lever / points.cos)[minus][None, :]
    axial = (points.sin / points.cos)[plus][:, None] + (points.sin / points.cos)[minus][None, :]
    return float((with_plus / axial).max())


@dataclass(frozen=True)
class Solution:
    """Equilibrium of a pair. Forces per ball in N; see solve_pair for the meaning of each."""

    status: Literal["ok", "outside_small_displacements"]
    torque_Nm: float
    preload_N: float
    preload_at_points_N: float
    approach_unloaded_m: float
    alpha_rad: float
    approach_m: float
    lateral_m: float
    force_plus_N: Floats
    force_minus_N: Floats
    force_along_N: float | None
    force_across_N: float | None
    tilt_couple_Nm: float
    carrying_diagonals: int
    smallest_squeeze_m: float
    peak_pressure_Pa: float
    alpha_floor_rad: float
    approach_floor_m: float
    alpha_long: np.longdouble


class TorqueNotHeldError(ValueError):
    """The torque is at or above what the preload can hold."""

    def __init__(self, torque_Nm: float, preload_N: float, preload_that_holds_N: float) -> None:
        self.preload_that_holds_N = preload_that_holds_N
        super().__init__(
            f"{torque_Nm:g} N m is more than a preload of {preload_N:g} N can hold; "
            f"it takes more than {preload_that_holds_N:g} N"
        )


def solve_pair(
    pair: MeshingPair,
    torque_Nm: float | np.longdouble,
    preload_N: float,
    conditions: Conditions = NOMINAL,
) -> Solution:
    """Equilibrium of a pair under a torque (N m) and an axial preload (N).

    Unknown are the approach d (m) of the plates, the rotation alpha (rad) of the output plate
    and, in a cross-slide, the lateral shift t (m) of the floating plate, such that
        sum of N sin(beta)            = preload that reaches the points,
        sum of (+-) N cos(beta) arm   = torque,
        sum of (+-) N cos(beta)       = 0          (cross-slide only),
    over all diagonals, + for plus, - for minus. Without a spring that stiffens the preload a
    solution exists only below `capacity`; beyond it TorqueNotHeldError is raised.

    In the answer: in-plane force of the balls on the output plate along and across the line of
    centres; tilt couple, the sum of N sin(beta) arm; diagonals that carry (each is two meshing
    points); smallest_squeeze_m, the least delta of an existing diagonal (negative: parted); the
    highest Hertz pressure. The floors say how far a result moves if every arm, stiffness and sum
    is off by 4 units of the last place of a double: no agreement below them can be asked for.
    """
    points = _diagonals(pair, conditions)
    if not preload_N > 0:
        raise ValueError("the preload must be positive")
    holds = abs(float(torque_Nm)) / capacity(pair, 1 if torque_Nm >= 0 else -1)
    if preload_N <= holds and conditions.spring_N_per_m == 0:
        raise TorqueNotHeldError(float(torque_Nm), preload_N, holds)

    def state_at(torque: float | np.longdouble) -> NDArray[np.longdouble]:
        rough = _rotation(points, float(torque), preload_N)
        return _refine(points, rough, np.longdouble(torque), np.longdouble(preload_N))

    unloaded = math.nan
    if conditions.spring_N_per_m > 0:
        unloaded = float(state_at(0.0)[0])
        spring = conditions.spring_N_per_m
        points = replace(points, spring=spring, spring_zero=unloaded)
    state = state_at(torque_Nm)
    return _solution(pair, points, float(torque_Nm), preload_N, unloaded, state)


def _solution(
    pair: MeshingPair,
    points: _Diagonals,
    torque_Nm: float,
    preload_N: float,
    approach_unloaded_m: float,
    state: NDArray[np.longdouble],
) -> Solution:
    """Everything that follows from a solved state."""
    d, alpha, t = (float(v) for v in state)
    deltas = points.deltas(*state)
    force = np.zeros(2 * len(pair.arm_m))
    force[points.place] = points.forces(deltas).astype(np.float64)
    plus, minus = np.split(force, 2)
    in_plane = plus * math.cos(pair.contact_angle_plus_rad)
    in_plane = in_plane - minus * math.cos(pair.contact_angle_minus_rad)
    axial = plus * math.sin(pair.contact_angle_plus_rad)
    axial = axial + minus * math.sin(pair.contact_angle_minus_rad)
    pressures = [
        contact_state(float(n), *wall, pair.contact_modulus_Pa).peak_pressure_Pa
        for n, walls in zip(force, pair.walls_plus + pair.walls_minus, strict=True)
        for wall in walls
        if n > 0 and wall is not None
    ]
    limit = SMALL_DISPLACEMENT * pair.ball_radius_m
    beyond = max(abs(d), float(np.abs(pair.arm_m).max()) * abs(alpha)) > limit
    floor = _floors(points, (d, alpha, t))
    return Solution(
        status="outside_small_displacements" if beyond else "ok",
        torque_Nm=torque_Nm,
        preload_N=preload_N,
        preload_at_points_N=float(axial.sum()),
        approach_unloaded_m=approach_unloaded_m,
        alpha_rad=alpha,
        approach_m=d,
        lateral_m=t,
        force_plus_N=plus,
        force_minus_N=minus,
        force_along_N=None if pair.push_along is None else float(in_plane @ pair.push_along),
        force_across_N=None if pair.push_across is None else float(in_plane @ pair.push_across),
        tilt_couple_Nm=float(axial @ pair.arm_m),
        carrying_diagonals=int((force > 0).sum()),
        smallest_squeeze_m=float(deltas.min()),
        peak_pressure_Pa=max(pressures),
        alpha_floor_rad=floor[1],
        approach_floor_m=floor[0],
        alpha_long=state[1],
    )


def _floors(points: _Diagonals, x: tuple[float, float, float]) -> tuple[float, float]:
    """Shift of d (m) and alpha (rad) by errors of 4 units in the last place of all data."""
    d, alpha, t = x
    force = points.forces(points.deltas(*x))
    squeezed = np.maximum(points.deltas(*x), 0)
    slope = points.exponent * force / np.where(squeezed > 0, squeezed, 1.0)
    parts = np.abs(d + points.axial) * points.sin + np.abs(points.normal)
    parts = parts + (np.abs(points.arm * alpha) + abs(t) + np.abs(points.in_plane)) * points.cos
    error = RTOL * (force + slope * parts)
    rows = np.array([points.sin, np.abs(points.arm) * points.cos, points.cos])
    matrix = _jacobian(points, x)
    shift = np.abs(np.linalg.inv(matrix)) @ (rows @ error)[: len(matrix)]
    return float(shift[0]), float(shift[1])


def torsional_stiffness_Nm_per_rad(
    pair: MeshingPair, torque_Nm: float, preload_N: float, conditions: Conditions = NOMINAL
) -> float:
    """dM0/dalpha (N m/rad) at constant preload, by a central difference of two solutions.

    The step is 1e-5 of the distance to the limit, so the difference is good to about 1e-9; less
    (1e-6) where a diagonal is just about to part, since the stiffness falls there like the square
    root of the squeeze that is left.
    """
    sign = 1 if torque_Nm >= 0 else -1
    room = abs(capacity(pair, sign) * preload_N - abs(torque_Nm))
    step = np.longdouble(1e-5 * min(room, capacity(pair, sign) * preload_N))
    after, before = (
        solve_pair(pair, torque_Nm + s * step, preload_N, conditions).alpha_long for s in (1, -1)
    )
    return float(2 * step / (after - before))
