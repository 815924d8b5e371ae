"""Meshing points of both pairs for many readings at once, and their equilibrium.

The same statics as equilibrium.py, laid out as arrays (reading, diagonal) and solved for all
readings together: rotation outside, the lateral shift of a floating plate inside it, the axial
approach innermost. Each level is a Newton step kept inside a bracket. SI units and radians.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipkm1, elliprd

from reference.contact import Floats, track_curvatures_per_m
from reference.forward import CrossSlide, Deceleration, RingGroove

Ints = NDArray[np.int64]
LAW_LENGTH_M = 1e-6  # delta_0 of the general power law
Curve = Callable[[Floats], tuple[Floats, Floats]]  # x -> growing value and its slope


class NotHeldError(ValueError):
    """Some reading asks for more torque than its preload can hold."""


# --- a growing function's root, for all readings at once ------------------------------------


def root_of(curve: Curve, start: Floats, low: Floats, high: Floats, unit: Floats) -> Floats:
    """Roots of growing functions, one each entry; a Newton step that leaves its bracket is halved.

    low and high may be infinite: while they are, no step is longer than twice what was walked.
    unit is the size of x that the tolerance (1e-14) is relative to.
    """
    x, low, high = start.copy(), low.copy(), high.copy()
    last = np.full(x.shape, np.inf)
    for _ in range(200):
        value, slope = curve(x)
        low = np.where(value <= 0, x, low)
        high = np.where(value >= 0, x, high)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = x - value / slope
        reach = 2 * (np.abs(x - start) + unit)
        newton = np.where(np.isfinite(newton), newton, np.copysign(np.inf, -value))
        newton = np.clip(newton, x - reach, x + reach)
        newton = np.where(value == 0, x, newton)
        closed = np.isfinite(low) & np.isfinite(high)
        with np.errstate(invalid="ignore"):
            middle = np.where(closed, (low + high) / 2, newton)
        lazy = np.abs(value) > 0.5 * last
        outside = ~((newton >= low) & (newton <= high))
        small = np.abs(newton - x) <= 1e-9 * unit
        following = np.where(closed & (outside | (lazy & ~small)), middle, newton)
        last = np.abs(value)
        moved = np.abs(following - x)
        x = following
        if bool((moved <= 1e-14 * (np.abs(x) + unit)).all()):
            return x
        if bool(((moved <= 1e-9 * unit) & small).all()):
            return x  # a Newton step this short leaves its square behind
    raise ArithmeticError("no equilibrium found")


# --- stiffness of the walls -----------------------------------------------------------------


def stiffness_N_per_m1p5(along: Floats, across: Floats | float, modulus_Pa: float) -> Floats:
    """Exact Hertz stiffness for relative curvatures (1/m) along and across the track; 0 for nan.

    The ellipse's axis ratio b/a = exp(-u) solves larger/smaller = R_D(0,1,q) / R_D(0,q,1), where
    q = exp(-2u) and R_D is Carlson's integral; k = (2 pi E*/3) sqrt(D/A) / K^1.5.
    """
    missing = np.isnan(along)
    a = np.where(missing, across, along)
    across = np.broadcast_to(np.asarray(across, dtype=np.float64), a.shape)
    curvature, back = np.unique(np.stack([a.ravel(), across.ravel()]), axis=1, return_inverse=True)
    small, large = curvature.min(axis=0), curvature.max(axis=0)
    target = np.log(large / small)

    def mismatch(u: Floats) -> tuple[Floats, Floats]:
        q, step = np.exp(-2 * u), 1e-6
        r = np.exp(-2 * (u + step))
        value = np.log(elliprd(0, 1, q) / elliprd(0, q, 1)) - target
        other = np.log(elliprd(0, 1, r) / elliprd(0, r, 1)) - target
        return value, (other - value) / step

    zero = np.zeros_like(target)
    u = root_of(mismatch, target / 1.5, zero - 1e-9, zero + 60.0, zero + 1.0)
    q = np.exp(-2 * u)
    big_k, big_d = ellipkm1(q), elliprd(0, q, 1) / 3
    k = 2 * np.pi / 3 * modulus_Pa * np.sqrt(big_d / (small / 2)) / big_k**1.5
    return np.where(missing, 0.0, k[back.ravel()].reshape(a.shape))


def _along(kappa: Floats, radius: float, angle: float) -> Floats:
    """Relative curvature (1/m) of ball and wall along the track; nan where the wall is cut away."""
    bracket = 1 - kappa * radius * np.cos(angle)
    safe = np.where(bracket > 0, bracket, np.nan)
    return np.asarray(1 / radius + kappa * np.cos(angle) / safe)


def _series(first: Floats, second: Floats) -> Floats:
    """Two contacts in series under one force: squeezes add."""
    both = (first > 0) & (second > 0)
    with np.errstate(divide="ignore"):
        k = (first ** (-2 / 3) + second ** (-2 / 3)) ** -1.5
    return np.where(both, k, 0.0)


# --- the meshing points ---------------------------------------------------------------------


@dataclass(frozen=True)
class Law:
    """Force of a squeezed diagonal: N = k d0^1.5 (delta/d0)^n (delta/(delta + h))^2, d0 = 1 um.

    n = 1.5 and h = 0 are Hertz; h (m) is a soft layer of asperities, pressed flat with load.
    """

    exponent: float = 1.5
    layer_m: float = 0.0

    def force(self, stiffness: Floats, squeeze_m: Floats) -> tuple[Floats, Floats]:
        """Forces (N) and their slopes (N/m); parted diagonals carry nothing."""
        x = np.maximum(squeeze_m, 0.0)
        if self.exponent == 1.5:
            slope = stiffness * np.sqrt(x)
            force, slope = slope * x, 1.5 * slope
        else:
            n = self.exponent
            slope = stiffness * LAW_LENGTH_M ** (1.5 - n) * x ** (n - 1)
            force, slope = slope * x, n * slope
        if self.layer_m > 0:
            h = self.layer_m
            share = x / (x + h)
            slope = slope * share**2 + force * 2 * share * h / (x + h) ** 2
            force = force * share**2
        return force, slope


@dataclass(frozen=True)
class Spring:
    """The preload lost to a clamping device as the plates move: k_c s sinh((d - d0)/s), N.

    length_m s; infinite for a linear spring.
    """

    rate_N_per_m: float = 0.0
    length_m: float = np.inf

    def force(self, way_m: Floats) -> tuple[Floats, Floats]:
        """Force (N) taken off the preload and its slope (N/m)."""
        if np.isinf(self.length_m):
            return self.rate_N_per_m * way_m, np.full(way_m.shape, self.rate_N_per_m)
        x = np.clip(way_m / self.length_m, -50.0, 50.0)
        return self.rate_N_per_m * self.length_m * np.sinh(x), self.rate_N_per_m * np.cosh(x)


HERTZ = Law()
NO_SPRING = Spring()


@dataclass(frozen=True)
class Mesh:
    """Diagonals of one pair for every reading: arrays (reading, diagonal), plus first, then minus.

    axial, turning, lateral: how much a diagonal is squeezed by the approach d, the rotation
    (m/rad) and the lateral shift; the same factors turn its force into sums. gap_m adds to the
    squeeze. ball_angle_rad is each ball's place against the line of centres.
    """

    axial: Floats
    turning_m: Floats
    lateral: Floats
    stiffness: Floats
    gap_m: Floats
    ball_angle_rad: Floats
    ball_radius_m: float
    floats: bool
    law: Law = HERTZ
    spring: Spring = NO_SPRING

    def take(self, rows: Ints) -> Mesh:
        """The same for some of the readings."""
        names = ("axial", "turning_m", "lateral", "stiffness", "gap_m", "ball_angle_rad")
        return replace(self, **{n: getattr(self, n)[rows] for n in names})

    def with_gaps(self, axial_m: Floats, normal_m: Floats, in_plane_m: Floats) -> Mesh:
        """Gaps given per ball: zeta along the axis, g along both normals, p in the plane."""
        gap = np.tile(axial_m, 2) * self.axial + np.tile(normal_m, 2)
        return replace(self, gap_m=gap + np.tile(in_plane_m, 2) * self.lateral)

    @property
    def capacity_m(self) -> tuple[Floats, Floats]:
        """Torque per newton of preload (m) that non-negative forces can balance, up and down.

        A force cone's edge: one diagonal, or with a floating plate one plus and one minus whose
        lateral forces cancel.
        """
        exists = self.stiffness > 0
        out = []
        for sign in (1.0, -1.0):
            lever = np.where(exists, sign * self.turning_m, -np.inf)
            if not self.floats:
                out.append((lever / self.axial).max(axis=1))
                continue
            half = lever.shape[1] // 2
            per_push = lever / np.abs(self.lateral)
            cost = self.axial / np.abs(self.lateral)
            pair = per_push[:, :half].max(axis=1) + per_push[:, half:].max(axis=1)
            out.append(pair / (cost[:, 0] + cost[:, half]))
        return out[0], out[1]


@dataclass
class State:
    """Equilibrium of one pair for every reading; compliance is d rotation / d torque."""

    approach_m: Floats
    shift_m: Floats
    rotation_rad: Floats
    compliance_rad_per_Nm: Floats

    @property
    def unknowns(self) -> tuple[Floats, Floats, Floats]:
        """Approach, shift and rotation."""
        return self.approach_m, self.shift_m, self.rotation_rad


def _sums(mesh: Mesh, d: Floats, t: Floats, alpha: Floats) -> tuple[tuple[Floats, ...], Floats]:
    """Axial force, lateral force and torque, and their derivatives (reading, 3, 3)."""
    squeeze = d[:, None] * mesh.axial + alpha[:, None] * mesh.turning_m + mesh.gap_m
    if mesh.floats:
        squeeze += t[:, None] * mesh.lateral
    force, slope = mesh.law.force(mesh.stiffness, squeeze)
    ways = (mesh.axial, mesh.lateral, mesh.turning_m)
    sums = tuple(np.einsum("ij,ij->i", force, w) for w in ways)
    jacobian = np.zeros((len(d), 3, 3))
    for i, first in enumerate(ways):
        part = slope * first
        for j in range(i, 3):
            jacobian[:, i, j] = jacobian[:, j, i] = np.einsum("ij,ij->i", part, ways[j])
    return sums, jacobian


def _eliminate(jacobian: Floats, first: int, size: int) -> Floats:
    """Slope of the sum `first` by its own unknown, the unknowns before it kept balanced."""
    own = jacobian[:, first, first]
    if size == 0:
        return own
    inner = jacobian[:, :size, :size]
    cross = jacobian[:, :size, first]
    singular = np.abs(np.linalg.det(inner)) == 0
    inner = np.where(singular[:, None, None], np.eye(size), inner)
    way = np.linalg.solve(inner, cross[:, :, None])[:, :, 0]
    return np.where(singular, np.nan, own - np.einsum("ij,ij->i", cross, way))


@dataclass
class _Balance:
    """The unknowns of a pair while they are sought: each level balances one force with the levels
    inside it balanced, and starts from where the unknown was last. With a spring, preload_N is what
    the device would press with at the approach spring_zero_m."""

    mesh: Mesh
    torque_Nm: Floats
    preload_N: Floats
    spring_zero_m: Floats | None
    d: Floats
    t: Floats
    warm: bool
    slope: Floats

    def __post_init__(self) -> None:
        self.exists = self.mesh.stiffness > 0
        typical = np.where(self.exists, self.mesh.stiffness * self.mesh.axial, 0.0).sum(axis=1)
        self.scale = (self.preload_N / typical) ** (2 / 3)
        self.wide = np.full(len(self.preload_N), np.inf)

    def sprung(self, d: Floats) -> tuple[Floats | float, Floats | float]:
        """What the spring takes of the preload, and its rate."""
        if self.spring_zero_m is None:
            return 0.0, 0.0
        return self.mesh.spring.force(d - self.spring_zero_m)

    def approach(self, alpha: Floats, t: Floats) -> tuple[tuple[Floats, ...], Floats]:
        """Innermost: the approach d that carries the preload; all sums there, and their slopes."""
        mesh = self.mesh
        rest = alpha[:, None] * mesh.turning_m + t[:, None] * mesh.lateral + mesh.gap_m
        touch = np.where(self.exists, -rest / mesh.axial, np.inf).min(axis=1)

        def pressed(d: Floats) -> tuple[Floats, Floats]:
            force, slope = mesh.law.force(mesh.stiffness, d[:, None] * mesh.axial + rest)
            value = np.einsum("ij,ij->i", force, mesh.axial) - self.preload_N
            slope = np.einsum("ij,ij,ij->i", slope, mesh.axial, mesh.axial)
            taken, rate = self.sprung(d)
            return value + taken, slope + rate

        low = touch if self.spring_zero_m is None else -self.wide
        near = np.where(self.d > touch, self.d, touch + self.scale)
        first = near if self.warm else touch + 3 * self.scale
        self.d = root_of(pressed, first, low, self.wide, self.scale)
        self.warm = True
        sums, jacobian = _sums(mesh, self.d, t, alpha)
        jacobian[:, 0, 0] += self.sprung(self.d)[1]
        return sums, jacobian

    def sideways(self, alpha: Floats) -> tuple[tuple[Floats, ...], Floats]:
        """The same where a floating plate has gone aside as far as it is pushed."""
        if not self.mesh.floats:
            return self.approach(alpha, self.t)

        def pushed(t: Floats) -> tuple[Floats, Floats]:
            sums, jacobian = self.approach(alpha, t)
            return sums[1], _eliminate(jacobian, 1, 1)

        self.t = root_of(pushed, self.t, -self.wide, self.wide, self.scale)
        return self.approach(alpha, self.t)

    def turned(self, alpha: Floats) -> tuple[Floats, Floats]:
        """Outermost: torque that the points lack at a rotation, and its slope."""
        sums, jacobian = self.sideways(alpha)
        size = 2 if self.mesh.floats else 1
        if not self.mesh.floats:
            jacobian = jacobian[:, [0, 2], :][:, :, [0, 2]]
        self.slope = _eliminate(jacobian, size, size)
        return sums[2] - self.torque_Nm, self.slope


def equilibrium(
    mesh: Mesh,
    torque_Nm: Floats,
    preload_N: Floats,
    spring_zero_m: Floats | None = None,
    start: State | None = None,
) -> State:
    """Rotation of a pair at which its meshing points carry torque and preload, every reading."""
    none = np.zeros(len(torque_Nm))
    d, t, alpha = (none,) * 3 if start is None else start.unknowns
    balance = _Balance(mesh, torque_Nm, preload_N, spring_zero_m, d, t, start is not None, none)
    unit = balance.scale / np.abs(mesh.turning_m).max(axis=1)
    alpha = root_of(balance.turned, alpha, -balance.wide, balance.wide, unit)
    balance.turned(alpha)
    return State(balance.d, balance.t, alpha, 1 / balance.slope)


# --- pairs to meshes ------------------------------------------------------------------------


def deceleration_mesh(pair: Deceleration, phase_rad: Floats) -> Mesh:
    """Diagonals of the cycloid pair, one row for each phase (of ball 0 from the pitch point)."""
    k, r, beta = pair.short_amplitude, pair.ball_radius_m, pair.contact_angle_rad
    phi = phase_rad[:, None] + 2 * np.pi * np.arange(pair.ball_count) / pair.ball_count
    epi, hypo = track_curvatures_per_m(phi, pair.ball_count, k, pair.rolling_radius_m)
    if pair.track_curvature == "neglect":
        epi, hypo = 0 * epi, 0 * hypo
    own, other = (hypo, epi) if pair.output == "hypocycloid" else (epi, hypo)
    across = (1 - 1 / pair.conformity) / r

    def squeezed(near: Floats, far: Floats) -> Floats:
        modulus = pair.material.contact_modulus_Pa
        walls = [_along(near, r, beta), _along(-far, r, beta)]
        return _series(*(stiffness_N_per_m1p5(w, across, modulus) for w in walls))

    arm = pair.pitch_arm_m * np.sin(phi) / np.sqrt(1 + k * k - 2 * k * np.cos(phi))
    both = squeezed(other, own), squeezed(own, other)
    return _mesh(arm, both, (beta, beta), phi, r, floats=False)


def ring_mesh(pair: RingGroove, phase_rad: Floats) -> Mesh:
    """Diagonals of the ring grooves, one row for each angle of the planet."""
    psi = phase_rad[:, None] + 2 * np.pi * np.arange(pair.ball_count) / pair.ball_count
    kappa = 0.0 if pair.track_curvature == "neglect" else 1 / pair.ring_radius_m
    angles = pair.contact_angle_outside_rad, pair.contact_angle_inside_rad
    r, modulus = pair.ball_radius_m, pair.material.contact_modulus_Pa
    both = []
    for side, beta in zip((-kappa, kappa), angles, strict=True):
        along = _along(np.array([side]), r, beta)
        k = stiffness_N_per_m1p5(along, (1 - 1 / pair.conformity) / r, modulus)
        both.append(np.broadcast_to(_series(k, k), psi.shape))
    return _mesh(pair.pitch_radius_m * np.sin(psi), (both[0], both[1]), angles, psi, r, False)


def slide_mesh(pair: CrossSlide, phase_rad: Floats) -> Mesh:
    """Diagonals of one interface of a cross-slide; the phase has no say."""
    angle = 2 * np.pi * np.arange(pair.ball_count) / pair.ball_count
    angle = np.broadcast_to(angle, (len(phase_rad), pair.ball_count))
    r, beta, modulus = pair.ball_radius_m, pair.contact_angle_rad, pair.material.contact_modulus_Pa
    k = stiffness_N_per_m1p5(np.array([1 / r]), (1 - 1 / pair.conformity) / r, modulus)
    one = np.broadcast_to(_series(k, k), angle.shape)
    return _mesh(pair.pitch_radius_m * np.cos(angle), (one, one), (beta, beta), angle, r, True)


def _mesh(
    arm_m: Floats,
    stiffness: tuple[Floats, Floats],
    angles_rad: tuple[float, float],
    ball_angle_rad: Floats,
    ball_radius_m: float,
    floats: bool,
) -> Mesh:
    """Plus and minus diagonals side by side."""
    ones = np.ones_like(arm_m)
    plus, minus = angles_rad
    lateral = np.hstack([ones * np.cos(plus), -ones * np.cos(minus)])
    return Mesh(
        axial=np.hstack([ones * np.sin(plus), ones * np.sin(minus)]),
        turning_m=np.tile(arm_m, 2) * lateral,
        lateral=lateral,
        stiffness=np.hstack(stiffness),
        gap_m=np.zeros_like(lateral),
        ball_angle_rad=ball_angle_rad,
        ball_radius_m=ball_radius_m,
        floats=floats,
    )
