"""Friction of a ball drive: an independent reference.

It shares no method with the product, which tries all crossings of lines in two unknowns. Here every
ball has its three unknowns: the angular velocity in the frame of the crank, with slip and pivoting
as vectors of space. The sum of norms is minimised as it stands: smoothed, sqrt(x^2 + w^2) - w with
a width w that shrinks, each time by Newton's method of SciPy (trust-exact, with exact derivatives).

    plate_turns    how the plates turn in the frame of the crank
    Contact, Ball  contact normals, speeds and forces in space
    least_loss_Nm  friction power over the coefficient, per radian of the input
    row_loss_Nm    the same of a row of balls under its forces
    ..._loss_Nm    the same of each kind of pair under a load, by the reference's equilibrium

SI units and radians; speeds and turns are those for one radian of the input.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import ellipe

from reference.contact import Floats, contact_state
from reference.equilibrium import solve_pair
from reference.pairs import CrossSlide, Deceleration, MeshingPair, Output, RingGroove


def plate_turns(ball_count: int, output: Output) -> tuple[float, float, float]:
    """Turns of epicycloid plate, ball circle and hypocycloid plate against the crank."""
    lobes = (ball_count - 1, ball_count, ball_count + 1)
    fixed = lobes[0] if output == "hypocycloid" else lobes[2]
    return -fixed / lobes[0], -fixed / lobes[1], -fixed / lobes[2]


@dataclass(frozen=True)
class Contact:
    """A loaded contact in space: outward normal, the ball centre's velocity against the plate (m),
    the plate's turn, force (N), and (3/8) a E(m) of its ellipse (m)."""

    normal: Floats
    velocity_m: Floats
    plate_turn: float
    force_N: float
    pivoting_arm_m: float


def pivoting_arm_m(force_N: float, curvatures: tuple[float, float], modulus_Pa: float) -> float:
    """(3/8) a E(m), m = 1 - (b/a)^2; 3 pi a/16 for a circle."""
    state = contact_state(force_N, *curvatures, modulus_Pa)
    m = 1 - (state.semi_axis_minor_m / state.semi_axis_major_m) ** 2
    return 0.375 * state.semi_axis_major_m * float(ellipe(m))


def least_loss_Nm(radius_m: float, contacts: Sequence[Contact]) -> float:
    """min over the spin of sum Q (|slip| + arm |pivoting|), over three unknowns."""
    if not contacts:
        return 0.0
    blocks, offsets = [], []
    axis = np.array([0.0, 0.0, 1.0])
    for contact in contacts:
        # w x (r c) = -r [c]x w
        c, q = contact.normal, contact.force_N
        cross = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
        slip = -radius_m * cross
        blocks.append(q * slip)
        offsets.append(q * (contact.velocity_m - slip @ axis * contact.plate_turn))
        pivot = q * contact.pivoting_arm_m * c[None, :]
        blocks.append(pivot)
        offsets.append(-pivot @ axis * contact.plate_turn)
    return _least_sum_of_norms(blocks, offsets)


def _least_sum_of_norms(blocks: list[Floats], offsets: list[Floats]) -> float:
    scale = max(float(np.linalg.norm(b)) for b in offsets)
    # Unknowns of the size of the spin, values of the size of the largest norm.
    size = scale / max(float(np.linalg.norm(a)) for a in blocks)
    a = [block * size / scale for block in blocks]
    b = [offset / scale for offset in offsets]

    def value(x: Floats, width: float) -> tuple[float, Floats, Floats]:
        total, gradient, hessian = 0.0, np.zeros(3), np.zeros((3, 3))
        for matrix, vector in zip(a, b, strict=True):
            v = matrix @ x + vector
            root = math.sqrt(float(v @ v) + width * width)
            total += root
            gradient += matrix.T @ v / root
            inner = np.eye(len(v)) / root - np.outer(v, v) / root**3
            hessian += matrix.T @ inner @ matrix
        return total, gradient, hessian

    x = np.zeros(3)
    for width in 10.0 ** -np.arange(1.0, 10.0):
        parts: list[Any] = [lambda x, i=i, w=float(width): value(x, w)[i] for i in range(3)]
        options: Any = {"gtol": 1e-13, "maxiter": 400}
        found = minimize(
            parts[0], x, jac=parts[1], hess=parts[2], method="trust-exact", options=options
        )
        x = np.asarray(found.x, dtype=np.float64)
    norms = [float(np.linalg.norm(m @ x + v)) for m, v in zip(a, b, strict=True)]
    return scale * sum(norms)


Velocities = Sequence[tuple[tuple[float, float], tuple[float, float]]]


def row_loss_Nm(
    pair: MeshingPair,
    forces_N: tuple[Floats, Floats],
    velocities_m: Velocities,
    turns: tuple[float, float],
) -> float:
    """Loss of a row of balls, N m.

    forces_N are those of the plus and minus diagonals; velocities_m those of each ball's centre
    against driving and output plate in the plane (along and across the line of centres), turns
    those of these plates.
    """
    along = np.zeros(len(pair.arm_m)) if pair.push_along is None else pair.push_along
    across = np.ones(len(pair.arm_m)) if pair.push_across is None else pair.push_across
    total = 0.0
    for ball in range(len(pair.arm_m)):
        contacts = []
        # Plus runs from the driving plate to the output plate, minus is listed the other way.
        for sign, angle, walls, force in [
            (1.0, pair.contact_angle_plus_rad, pair.walls_plus[ball], forces_N[0][ball]),
            (-1.0, pair.contact_angle_minus_rad, pair.walls_minus[ball][::-1], forces_N[1][ball]),
        ]:
            if force <= 0 or None in walls:
                continue
            for side, wall in enumerate(walls):
                assert wall is not None
                # A loaded plus diagonal pushes the output plate, whose wall lies there.
                away = math.cos(angle) * (sign if side == 1 else -sign)
                axial = math.sin(angle) * (-1 if side == 1 else 1)
                normal = np.array([away * along[ball], away * across[ball], axial])
                velocity = np.array([*velocities_m[ball][side], 0.0])
                arm = pivoting_arm_m(float(force), wall, pair.contact_modulus_Pa)
                contacts.append(Contact(normal, velocity, turns[side], float(force), arm))
        total += least_loss_Nm(pair.ball_radius_m, contacts)
    return total


def deceleration_loss_Nm(
    pair: Deceleration, phase_rad: float, torque_Nm: float, preload_N: float
) -> float:
    """Loss of the deceleration pair for one radian of the input, over the coefficient."""
    epi, ring, hypo = plate_turns(pair.ball_count, pair.output)
    turns = (epi, hypo) if pair.output == "hypocycloid" else (hypo, epi)
    e = pair.short_amplitude * pair.rolling_radius_m
    phi = phase_rad + 2 * math.pi * np.arange(pair.ball_count) / pair.ball_count
    # From the pitch point, about which every plate turns against the balls.
    x = pair.ball_count * (pair.rolling_radius_m * np.cos(phi) - e)
    y = pair.ball_count * pair.rolling_radius_m * np.sin(phi)
    first, second = ring - turns[0], ring - turns[1]
    velocities = [
        ((-first * v, first * u), (-second * v, second * u)) for u, v in zip(x, y, strict=True)
    ]
    return _solved_loss_Nm(pair.at(phase_rad), torque_Nm, preload_N, velocities, turns)


def ring_loss_Nm(
    pair: RingGroove, phase_rad: float, torque_Nm: float, preload_N: float, turn: float
) -> float:
    """Loss of the ring grooves, both plates turning at `turn` against the crank."""
    speed = pair.ring_radius_m * turn
    velocities = [((0.0, -speed), (0.0, speed))] * pair.ball_count
    return _solved_loss_Nm(pair.at(phase_rad), torque_Nm, preload_N, velocities, (turn, turn))


def slide_loss_Nm(
    pair: CrossSlide, angle_rad: float, torque_Nm: float, preload_N: float, eccentricity_m: float
) -> float:
    """Loss of both rows of a cross-slide, which carries torque_Nm, at an angle of the crank."""
    total = 0.0
    for way in (math.cos(angle_rad), math.sin(angle_rad)):
        speed = eccentricity_m * way
        velocities = [((speed, 0.0), (-speed, 0.0))] * pair.ball_count
        total += _solved_loss_Nm(pair.at(), torque_Nm, preload_N, velocities, (0.0, 0.0))
    return total


def _solved_loss_Nm(
    pair: MeshingPair,
    torque_Nm: float,
    preload_N: float,
    velocities_m: Velocities,
    turns: tuple[float, float],
) -> float:
    solved = solve_pair(pair, torque_Nm, preload_N)
    forces = (solved.force_plus_N, solved.force_minus_N)
    return row_loss_Nm(pair, forces, velocities_m, turns)
