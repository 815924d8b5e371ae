"""Effects on the torque and preload that reach the balls, and gaps at the balls.

N is the preload N_Z; a ball's squeeze is (d + zeta) sin(beta) + g +- (a_i alpha + p) cos(beta).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reference.contact import Floats
from reference.rig.bench import ARCSEC, Bench, Friction
from reference.rig.friction import DAHL, Dahl, Iwan
from reference.rig.kinds import Register, Values, any_phase, any_seed
from reference.rig.mesh import Mesh, Spring

LOADS = Register()


# --- load: friction and preload ---------------------------------------------------------------


@LOADS.effect(
    "load",
    "mu_T_m",
    "m",
    (1e-6, 5e-3),
    forms=("library", "blunt", "iwan", "rate", "own_angle"),
    needs="reversal",
    draw=lambda rng: {"length_rad": float(rng.uniform(2, 15) * ARCSEC)},
)
def friction_hysteresis(b: Bench, v: Values, form: str) -> None:
    """Friction on the total angle, limit mu_T N.

    Variants: a blunter Dahl; elements that slip one after the other; a limit that rises with the
    rate; friction that feels the meshing points' own angle alone.
    """
    limit = v["mu_T_m"] * b.preload_N
    length = v["length_rad"]
    models: dict[str, Friction] = {
        "library": Dahl(length),
        "own_angle": Dahl(length),
        "blunt": replace(DAHL, length_rad=length, power=0.5),
        "iwan": Iwan(length),
        "rate": replace(DAHL, length_rad=length, rising=0.06),
    }
    b.friction = (models[form], limit)
    b.friction_feels_series = form != "own_angle"


@LOADS.effect("load", "share", "", (0.0, 0.6), forms=("library", "degressive"))
def preload_loss(b: Bench, v: Values, form: str) -> None:
    """N -> (1 - eta) N; variant: less of it is held back the more there is."""
    share = np.full(len(b.rows), v["share"])
    if form == "degressive":
        share = share * (1.15 - 0.3 * b.preload_N / b.preload_N.max())
    b.preload_N = b.preload_N * (1 - share)


@LOADS.effect("load", "rate_N_per_m", "N/m", (0.0, 2e9), forms=("library", "stiffening"))
def preload_spring(b: Bench, v: Values, form: str) -> None:
    """N -> N - k_c (d - d0) of each pair's own approach; variant: stiffens with its way."""
    b.spring = Spring(v["rate_N_per_m"], 3e-6 if form == "stiffening" else float(np.inf))


@LOADS.effect(
    "load",
    "rate_N_per_K",
    "N/K",
    (0.0, 100.0),
    forms=("library", "late"),
    signed=True,
    needs="temperature",
)
def thermal_preload(b: Bench, v: Values, form: str) -> None:
    """N + c (T - T0), T0 the first reading's; variant: follows the thermometer ten minutes late."""
    warm = b.rows.temperature_degC - b.rows.temperature_degC[0]
    if form == "late":
        lagged = warm.copy()
        for i in range(1, len(lagged)):
            share = 1 - np.exp(-(b.rows.time_s[i] - b.rows.time_s[i - 1]) / 600)
            lagged[i] = lagged[i - 1] + share * (warm[i] - lagged[i - 1])
        warm = lagged
    b.preload_N = b.preload_N + v["rate_N_per_K"] * warm


@LOADS.effect("load", "lost_share", "", (0.0, 0.5), forms=("library", "root", "work"))
def wear(b: Bench, v: Values, form: str) -> None:
    """Preload lost with time, N (1 - w t); variants: with its root, or with torque worked off."""
    t = b.rows.time_s - b.rows.time_s[0]
    work = np.cumsum(np.abs(np.diff(b.rows.torque_Nm, prepend=0.0)))
    way = {
        "library": t / max(float(t.max()), 1e-9),
        "root": np.sqrt(t / max(float(t.max()), 1e-9)),
        "work": work / max(float(work.max()), 1e-9),
    }[form]
    b.preload_N = b.preload_N * (1 - v["lost_share"] * way)


# --- gaps at the balls ------------------------------------------------------------------------


def _nothing(mesh: Mesh) -> list[Floats]:
    return [np.zeros_like(mesh.ball_angle_rad) for _ in range(3)]


@LOADS.effect(
    "gap",
    "amplitude_m",
    "m",
    (0.1e-6, 10e-6),
    forms=("library", "two_harmonics", "planet"),
    needs="angles",
    draw=lambda rng: {**any_phase(rng), "harmonic": float(rng.integers(2, 8))},
)
def groove_pitch_error(b: Bench, v: Values, form: str) -> None:
    """p_i = A cos(h t_i + phase) at the ball's place t_i along the fixed groove.

    Against the fixed plate the ball circle turns by theta/Z2, so t_i = theta/Z2 + 2 pi i/Z2, or
    the ball's angle from the line of centres plus theta. Variants: two harmonics; the planet's
    groove, against which the line of centres turns by theta Z1/Z3.
    """
    z2 = b.drive.deceleration.ball_count
    epicycloid = b.drive.deceleration.output == "epicycloid"
    h, amplitude, phase = v["harmonic"], v["amplitude_m"], v["phase_rad"]
    rate = -1.0 if epicycloid else 1.0
    if form == "planet":
        rate *= (z2 + 1) / (z2 - 1) if epicycloid else (z2 - 1) / (z2 + 1)

    def gaps(bench: Bench, meshes: tuple[Mesh, Mesh]) -> tuple[list[Floats], list[Floats]]:
        one, two = _nothing(meshes[0]), _nothing(meshes[1])
        t = meshes[0].ball_angle_rad + rate * bench.rows.input_angle_rad[:, None]
        one[2] += amplitude * np.cos(h * t + phase)
        if form == "two_harmonics":
            one[2] += 0.6 * amplitude * np.cos((h + 2) * t + 2.3 * phase)
        return one, two

    b.gaps.append(gaps)


@LOADS.effect(
    "gap",
    "spread_m",
    "m",
    (0.05e-6, 3e-6),
    forms=("library", "both_pairs"),
    needs="angles",
    draw=any_seed,
)
def ball_diameter_lot(b: Bench, v: Values, form: str) -> None:
    """g_i normal with the lot's spread, for the cycloid pair's balls; variant: of both pairs."""

    def gaps(bench: Bench, meshes: tuple[Mesh, Mesh]) -> tuple[list[Floats], list[Floats]]:
        rng = np.random.default_rng(int(v["seed"]))
        out = [_nothing(m) for m in meshes]
        for number, (mesh, parts) in enumerate(zip(meshes, out, strict=True)):
            lot: Floats = rng.standard_normal((1, mesh.ball_angle_rad.shape[1]))
            if number == 0 or form == "both_pairs":
                parts[1] += v["spread_m"] * (lot - lot.mean())
        return out[0], out[1]

    b.gaps.append(gaps)


@LOADS.effect(
    "gap", "tilt_rad", "rad", (1e-6, 1e-3), forms=("library", "housing", "one_pair"), draw=any_phase
)
def plate_tilt(b: Bench, v: Values, form: str) -> None:
    """zeta_i = psi R cos(phi_i - phase), phi_i from the line of centres, R of the pair's circle.

    Variants: the tilt stands still in the housing; only the cycloid pair is tilted.
    """
    radii = (
        b.drive.deceleration.ball_count * b.drive.deceleration.rolling_radius_m,
        b.drive.equal_speed.pitch_radius_m,
    )
    turn = b.rows.input_angle_rad[:, None] if form == "housing" else 0.0

    def gaps(bench: Bench, meshes: tuple[Mesh, Mesh]) -> tuple[list[Floats], list[Floats]]:
        out = [_nothing(m) for m in meshes]
        for number, (mesh, parts) in enumerate(zip(meshes, out, strict=True)):
            if number == 0 or form != "one_pair":
                wave = np.cos(mesh.ball_angle_rad + turn - v["phase_rad"])
                parts[0] += v["tilt_rad"] * radii[number] * wave
        return out[0], out[1]

    b.gaps.append(gaps)
