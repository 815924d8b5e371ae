"""The three kinds of ball pair of the reference model, as balls between two plates.

Each model (Deceleration, RingGroove, CrossSlide) holds dimensions; `at(phase)` gives the
MeshingPair that the equilibrium needs, `findings()` what is wrong with the design. SI units and
radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from reference.contact import (
    STEEL,
    Floats,
    Material,
    Wall,
    groove_wall,
    series_stiffness_N_per_m1p5,
    track_curvatures_per_m,
)

Output = Literal["hypocycloid", "epicycloid"]
TrackCurvature = Literal["exact", "neglect"]


# --- pairs ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class MeshingPair:
    """A row of balls between two plates, as the equilibrium sees it (one entry per ball).

    push_along and push_across: in-plane direction in which a loaded plus diagonal pushes the
    output plate, along the line of centres (positive towards the pitch point) and a quarter turn
    further on (positive where a positive torque puts it); None where the line has no meaning.
    walls_plus, walls_minus: the two walls in series of each diagonal.
    floating: a plate of this pair is held by the balls alone and shifts until it is balanced.
    """

    kind: Literal["deceleration", "ring_groove", "cross_slide"]
    ball_radius_m: float
    contact_modulus_Pa: float
    arm_m: Floats
    stiffness_plus_N_per_m1p5: Floats
    stiffness_minus_N_per_m1p5: Floats
    contact_angle_plus_rad: float
    contact_angle_minus_rad: float
    walls_plus: tuple[tuple[Wall, Wall], ...]
    walls_minus: tuple[tuple[Wall, Wall], ...]
    push_along: Floats | None
    push_across: Floats | None
    floating: bool = False


def _pair(
    walls_plus: list[tuple[Wall, Wall]],
    walls_minus: list[tuple[Wall, Wall]],
    material: Material,
    **rest: object,
) -> MeshingPair:
    """A pair from its walls: the stiffness of each diagonal follows from the two in series."""
    modulus = material.contact_modulus_Pa

    def stiffnesses(walls: list[tuple[Wall, Wall]]) -> Floats:
        return np.array([series_stiffness_N_per_m1p5(a, b, modulus) for a, b in walls])

    return MeshingPair(
        contact_modulus_Pa=modulus,
        stiffness_plus_N_per_m1p5=stiffnesses(walls_plus),
        stiffness_minus_N_per_m1p5=stiffnesses(walls_minus),
        walls_plus=tuple(walls_plus),
        walls_minus=tuple(walls_minus),
        **rest,  # type: ignore[arg-type]  # the makers below name the remaining fields
    )


@dataclass(frozen=True)
class Deceleration:
    """Cycloid grooves facing each other. Lengths in m, angles in rad.

    ball_count Z2, rolling_radius r0, short_amplitude K; eccentricity e = K r0 (half the crank's).
    """

    ball_count: int
    short_amplitude: float
    rolling_radius_m: float
    ball_radius_m: float
    conformity: float
    contact_angle_rad: float
    output: Output = "hypocycloid"
    track_curvature: TrackCurvature = "exact"
    material: Material = STEEL

    @property
    def pitch_arm_m(self) -> float:
        """From the centre of the output plate to the pitch point: Z3 e or Z1 e."""
        lobes = self.ball_count + (1 if self.output == "hypocycloid" else -1)
        return lobes * self.short_amplitude * self.rolling_radius_m

    def at(self, phase_rad: float) -> MeshingPair:
        """The pair with ball 0 at phase_rad from the pitch point, about the ball circle's centre.

        In the plane every normal passes through the pitch point, at Z_out e from the output
        plate's centre, so its signed arm is Z_out e sin(phi)/sqrt(1 + K^2 - 2 K cos(phi)).
        A positive torque presses a ball of positive arm towards the pitch point: away from the
        output plate's far wall, onto the other plate's near wall.
        """
        k, radius = self.short_amplitude, self.ball_radius_m
        phi = phase_rad + 2 * math.pi * np.arange(self.ball_count) / self.ball_count
        root = np.sqrt(1 + k * k - 2 * k * np.cos(phi))
        epi, hypo = track_curvatures_per_m(phi, self.ball_count, k, self.rolling_radius_m)
        if self.track_curvature == "neglect":
            epi, hypo = 0 * epi, 0 * hypo
        own, other = (hypo, epi) if self.output == "hypocycloid" else (epi, hypo)

        def walls(near: Floats, far: Floats) -> list[tuple[Wall, Wall]]:
            groove = (radius, self.contact_angle_rad, self.conformity)
            pairs = zip(near, far, strict=True)
            return [
                (groove_wall(float(n), *groove), groove_wall(-float(f), *groove)) for n, f in pairs
            ]

        return _pair(
            walls(other, own),
            walls(own, other),
            self.material,
            kind="deceleration",
            ball_radius_m=radius,
            arm_m=self.pitch_arm_m * np.sin(phi) / root,
            contact_angle_plus_rad=self.contact_angle_rad,
            contact_angle_minus_rad=self.contact_angle_rad,
            push_along=(np.cos(phi) - k) / root,
            push_across=np.sin(phi) / root,
        )

    @property
    def period_rad(self) -> float:
        """In the phase: the next ball takes the place of this one."""
        return 2 * math.pi / self.ball_count

    def findings(self) -> dict[str, bool | float]:
        """Smallest radius of curvature of the tracks (m) against r cos(beta); balls touching."""
        phi = np.linspace(0, math.pi, 20001)
        curvature = track_curvatures_per_m(
            phi, self.ball_count, self.short_amplitude, self.rolling_radius_m
        )
        smallest = 1 / max(float(np.abs(c).max()) for c in curvature)
        pitch = 2 * self.ball_count * self.rolling_radius_m * math.sin(math.pi / self.ball_count)
        return {
            "smallest_track_radius_m": smallest,
            "undercut": smallest <= self.ball_radius_m * math.cos(self.contact_angle_rad),
            "balls_touch": 2 * self.ball_radius_m >= pitch,
        }


@dataclass(frozen=True)
class RingGroove:
    """Ring grooves between planet and output. Lengths in m, angles in rad; ring_radius is e."""

    ball_count: int
    pitch_radius_m: float
    ring_radius_m: float
    ball_radius_m: float
    conformity: float
    contact_angle_outside_rad: float
    contact_angle_inside_rad: float
    track_curvature: TrackCurvature = "exact"
    material: Material = STEEL

    def at(self, phase_rad: float) -> MeshingPair:
        """The pair with the planet turned by phase_rad against the line of centres.

        All in-plane normals are parallel to the line of centres, so the arm of ball j is
        R_w sin(phase + 2 pi j/Z_d). Plus presses a ball between the two outside walls, minus
        between the two inside ones.
        """
        angles = phase_rad + 2 * math.pi * np.arange(self.ball_count) / self.ball_count
        kappa = 0.0 if self.track_curvature == "neglect" else 1 / self.ring_radius_m
        groove = (self.ball_radius_m, self.contact_angle_outside_rad, self.conformity)
        outside = groove_wall(-kappa, *groove)
        groove = (self.ball_radius_m, self.contact_angle_inside_rad, self.conformity)
        inside = groove_wall(kappa, *groove)
        return _pair(
            [(outside, outside)] * self.ball_count,
            [(inside, inside)] * self.ball_count,
            self.material,
            kind="ring_groove",
            ball_radius_m=self.ball_radius_m,
            arm_m=self.pitch_radius_m * np.sin(angles),
            contact_angle_plus_rad=self.contact_angle_outside_rad,
            contact_angle_minus_rad=self.contact_angle_inside_rad,
            push_along=-np.ones(self.ball_count),
            push_across=np.zeros(self.ball_count),
        )

    @property
    def period_rad(self) -> float:
        """In the phase: the next ball takes the place of this one."""
        return 2 * math.pi / self.ball_count

    def findings(self) -> dict[str, bool | float]:
        """Inside wall missing (ring radius <= r cos beta), balls touching, grooves overlapping."""
        pitch = 2 * self.pitch_radius_m * math.sin(math.pi / self.ball_count)
        offset = self.ball_radius_m * math.cos(self.contact_angle_inside_rad)
        return {
            "inside_wall_missing": self.ring_radius_m <= offset,
            "balls_touch": 2 * self.ball_radius_m >= pitch,
            "grooves_overlap": 2 * (self.ring_radius_m + self.ball_radius_m) >= pitch,
        }


@dataclass(frozen=True)
class CrossSlide:
    """One of the two equal interfaces of a cross-slide: straight grooves, a floating plate.

    Lengths in m, angles in rad. paper_arm_shift_m is added to every arm, and the floating plate
    is then left unbalanced: the 2017 paper's form (its shift is e cos(phi)), only to compare.
    """

    ball_count: int
    pitch_radius_m: float
    ball_radius_m: float
    conformity: float
    contact_angle_rad: float
    material: Material = STEEL
    paper_arm_shift_m: float | None = None

    def at(self, phase_rad: float = 0.0) -> MeshingPair:
        """The interface; arms R_s cos(2 pi n/Z_s) do not depend on the phase."""
        del phase_rad
        angles = 2 * math.pi * np.arange(self.ball_count) / self.ball_count
        wall = groove_wall(0.0, self.ball_radius_m, self.contact_angle_rad, self.conformity)
        walls = [(wall, wall)] * self.ball_count
        return _pair(
            walls,
            walls,
            self.material,
            kind="cross_slide",
            ball_radius_m=self.ball_radius_m,
            arm_m=self.pitch_radius_m * np.cos(angles) + (self.paper_arm_shift_m or 0.0),
            contact_angle_plus_rad=self.contact_angle_rad,
            contact_angle_minus_rad=self.contact_angle_rad,
            push_along=None,
            push_across=None,
            floating=self.paper_arm_shift_m is None,
        )

    def findings(self) -> dict[str, bool | float]:
        """Whether the balls of the row touch."""
        pitch = 2 * self.pitch_radius_m * math.sin(math.pi / self.ball_count)
        return {"balls_touch": 2 * self.ball_radius_m >= pitch}
