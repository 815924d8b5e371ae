"""Groove walls and Hertz contacts of the reference model.

From a groove's centreline to the stiffness of one diagonal: the relative curvatures of ball and
wall, the exact Hertz solution for them, and two contacts in series. SI units and radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ellipkm1, elliprd

Floats = NDArray[np.float64]
HERTZ_EXPONENT = 1.5
RTOL = 4 * float(np.finfo(np.float64).eps)  # the tightest that brentq accepts


# --- one contact ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Material:
    """Elastic constants of balls and plates: moduli in Pa, Poisson ratios without unit."""

    ball_modulus_Pa: float = 208e9
    ball_poisson: float = 0.3
    plate_modulus_Pa: float = 208e9
    plate_poisson: float = 0.3

    @property
    def contact_modulus_Pa(self) -> float:
        """1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""
        ball = (1 - self.ball_poisson**2) / self.ball_modulus_Pa
        plate = (1 - self.plate_poisson**2) / self.plate_modulus_Pa
        return 1 / (ball + plate)


@cache
def contact_shape(curvature_1_per_m: float, curvature_2_per_m: float) -> tuple[float, float, float]:
    """Shape of a Hertz ellipse, from the two principal relative curvatures (1/m).

    With K and E the complete elliptic integrals of the parameter m = 1 - (b/a)^2 for semi-axes
    a >= b, the two curvatures are in the ratio

        larger / smaller = [(a/b)^2 E - K] / [K - E].

    Numerator and denominator both vanish for a circle; written with Carlson's R_D they are
    m R_D(0, 1, (b/a)^2)/3 and m R_D(0, (b/a)^2, 1)/3, so the common factor drops out. The ratio
    is bracketed in u = -ln(b/a). Returns b/a, K and D = (K - E)/m, all without unit.
    """
    small, large = sorted((curvature_1_per_m, curvature_2_per_m))
    if not small > 0:
        raise ValueError("a point contact needs two positive relative curvatures")

    def mismatch(u: float) -> float:
        q = math.exp(-2 * u)
        return math.log(elliprd(0, 1, q) / elliprd(0, q, 1)) - math.log(large / small)

    u = 0.0 if mismatch(0.0) >= 0 else brentq(mismatch, 0.0, 60.0, xtol=1e-16, rtol=RTOL)
    q = math.exp(-2 * u)
    return math.exp(-u), float(ellipkm1(q)), float(elliprd(0, q, 1)) / 3


def contact_stiffness_N_per_m1p5(
    curvature_1_per_m: float, curvature_2_per_m: float, contact_modulus_Pa: float
) -> float:
    """Stiffness of one Hertz contact, N = k delta^1.5, k in N/m^1.5.

    The surfaces part as A x^2 + B y^2 with A half the smaller relative curvature. Hertz gives
    a^3 = 3 N D / (2 pi E* A) and delta = 3 N K / (2 pi E* a); eliminating a,
    k = (2 pi E*/3) sqrt(D/A) / K^1.5. On a circle this is (4/3) E* / sqrt(curvature).
    """
    _, big_k, big_d = contact_shape(curvature_1_per_m, curvature_2_per_m)
    half = min(curvature_1_per_m, curvature_2_per_m) / 2
    return 2 * math.pi / 3 * contact_modulus_Pa * math.sqrt(big_d / half) / math.pow(big_k, 1.5)


STEEL = Material()


@dataclass(frozen=True)
class ContactState:
    """One contact under load: semi-axes and approach in m, pressure at the centre in Pa."""

    semi_axis_major_m: float
    semi_axis_minor_m: float
    peak_pressure_Pa: float
    approach_m: float


def contact_state(
    force_N: float, curvature_1_per_m: float, curvature_2_per_m: float, contact_modulus_Pa: float
) -> ContactState:
    """Semi-axes, peak pressure 3 N / (2 pi a b) and approach of a contact that carries force_N."""
    ratio, _, big_d = contact_shape(curvature_1_per_m, curvature_2_per_m)
    half = min(curvature_1_per_m, curvature_2_per_m) / 2
    major = (3 * force_N * big_d / (2 * math.pi * contact_modulus_Pa * half)) ** (1 / 3)
    minor = ratio * major
    k = contact_stiffness_N_per_m1p5(curvature_1_per_m, curvature_2_per_m, contact_modulus_Pa)
    pressure = 1.5 * force_N / (math.pi * major * minor) if force_N > 0 else 0.0
    return ContactState(major, minor, pressure, (force_N / k) ** (1 / HERTZ_EXPONENT))


# --- groove walls ---------------------------------------------------------------------------


def track_curvatures_per_m(
    phi_rad: float | Floats, ball_count: int, short_amplitude: float, rolling_radius_m: float
) -> tuple[Floats, Floats]:
    """Curvatures (1/m) of the epicycloid and the hypocycloid centreline at a ball at phi.

    phi is counted about the centre of the ball circle from the ray to the pitch point. Positive
    with the centre of curvature on the pitch point's side.
    """
    z2, k = ball_count, short_amplitude
    cos = np.cos(phi_rad)
    scale = z2 * rolling_radius_m * (1 + k * k - 2 * k * cos) ** 1.5
    epi = (1 + z2 * k * k - (1 + z2) * k * cos) / scale
    hypo = (1 - z2 * k * k + (z2 - 1) * k * cos) / scale
    return np.asarray(epi), np.asarray(hypo)


def wall_curvature_per_m(
    wall_side_curvature_per_m: float, ball_radius_m: float, contact_angle_rad: float
) -> float | None:
    """Relative curvature (1/m) of ball and groove wall along the track; None without a wall.

    wall_side_curvature is that of the centreline, positive if its centre lies on the side of this
    wall. The contact runs r cos(beta) beside the centreline, towards this wall, so its own path
    has the curvature kappa / (1 - kappa r cos beta); Meusnier's theorem takes its share cos(beta)
    into the normal section. Where the bracket is not positive the wall has cut itself away.
    """
    offset = ball_radius_m * math.cos(contact_angle_rad)
    bracket = 1 - wall_side_curvature_per_m * offset
    if bracket <= 0:
        return None
    return 1 / ball_radius_m + wall_side_curvature_per_m * math.cos(contact_angle_rad) / bracket


Wall = tuple[float, float] | None  # relative curvatures along and across the track, 1/m


def groove_wall(kappa: float, radius: float, angle: float, conformity: float) -> Wall:
    """Both relative curvatures of one wall; across the track 1/r - 1/(conformity r)."""
    along = wall_curvature_per_m(kappa, radius, angle)
    if along is None:
        return None
    return along, (1 - 1 / conformity) / radius


def series_stiffness_N_per_m1p5(first: Wall, second: Wall, contact_modulus_Pa: float) -> float:
    """Two contacts in series under one force: deltas add, k = (k1^(-2/3) + k2^(-2/3))^(-1.5)."""
    if first is None or second is None:
        return 0.0
    k1 = contact_stiffness_N_per_m1p5(*first, contact_modulus_Pa)
    k2 = contact_stiffness_N_per_m1p5(*second, contact_modulus_Pa)
    return float((k1 ** (-2 / 3) + k2 ** (-2 / 3)) ** -1.5)
