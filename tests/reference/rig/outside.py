"""Effects that no library of causes holds: what a diagnosis must call unknown.

Same shape as the others, in one form; each is real, repeatable and depends on columns of the table.
"""

from __future__ import annotations

import numpy as np

from reference.contact import Floats
from reference.rig.bench import ARCSEC, Bench
from reference.rig.kinds import Register, Values

OUTSIDE = Register("outside")


def _largest(b: Bench) -> float:
    """Largest torque of the table (N m)."""
    return float(np.abs(b.torque_Nm).max())


def _rate(b: Bench) -> Floats:
    """|dM0/dt| (N m/s) that led to each reading; 0 at a run's start."""
    step = np.abs(np.diff(b.rows.torque_Nm, prepend=0.0))
    gap = np.maximum(np.diff(b.rows.time_s, prepend=-1.0), 1e-9)
    return np.asarray(np.where(b.rows.run_time_s == 0, 0.0, step / gap))


@OUTSIDE.effect(
    "series",
    "slope_rad_per_Nm",
    "rad/(N m)",
    (0.0, 1e-3),
    needs="angles",
    draw=lambda rng: {
        "centre_rad": float(rng.uniform(0, 2 * np.pi)),
        "width_rad": float(rng.uniform(0.3, 0.8)),
        "threshold_Nm": float(rng.uniform(1.0, 3.0)),
    },
)
def groove_damage(b: Bench, v: Values, form: str) -> None:
    """Above a torque, near one input angle, a further angle that grows with the torque.

    a (|T| - T1) sgn(T) exp(-(theta - theta_1)^2 / (2 w^2)), theta wrapped to half a turn.
    """
    away = b.rows.input_angle_rad - v["centre_rad"]
    away = (away + np.pi) % (2 * np.pi) - np.pi
    near = np.exp(-0.5 * (away / v["width_rad"]) ** 2)
    over = np.maximum(np.abs(b.torque_Nm) - v["threshold_Nm"], 0.0)
    b.series += v["slope_rad_per_Nm"] * np.sign(b.torque_Nm) * over * near


@OUTSIDE.effect(
    "series",
    "gap_rad",
    "rad",
    (0.0, 60 * ARCSEC),
    needs="reversal",
    draw=lambda rng: {"stick_share": float(rng.uniform(0.35, 0.7))},
)
def sticking_backlash(b: Bench, v: Values, form: str) -> None:
    """A coupling that lies on one flank until a torque the other way overcomes its stick."""
    side, now, share = np.zeros(len(b.rows)), 0.0, v["stick_share"] * _largest(b)
    for i, torque in enumerate(b.torque_Nm):
        if b.rows.run_time_s[i] == 0:
            now = 0.0
        if abs(torque) > share:
            now = float(np.sign(torque))
        side[i] = now
    b.series += v["gap_rad"] / 2 * side


@OUTSIDE.effect(
    "series",
    "slope_rad_per_Nm",
    "rad/(N m)",
    (0.0, 1e-4),
    needs="rates",
    draw=lambda rng: {"quantile": float(rng.uniform(0.4, 0.8))},
)
def rate_resonance(b: Bench, v: Values, form: str) -> None:
    """An angle with the torque, large where the rate of loading meets a resonance of the rig."""
    rate = _rate(b)
    centre = v["quantile"] * float(rate.max())
    x = rate / max(centre, 1e-9)
    b.series += v["slope_rad_per_Nm"] * b.torque_Nm * x**2 / np.sqrt((1 - x**2) ** 2 + 0.02)


@OUTSIDE.effect(
    "series",
    "give_rad",
    "rad",
    (0.0, 60 * ARCSEC),
    draw=lambda rng: {"moment_share": float(rng.uniform(0.25, 0.75))},
)
def sudden_give(b: Bench, v: Values, form: str) -> None:
    """From one moment on the output gives more, as the square of the torque: something cracked."""
    t = b.rows.time_s - b.rows.time_s[0]
    after = t > v["moment_share"] * t.max()
    share = b.torque_Nm / _largest(b)
    b.series += v["give_rad"] * after * share * np.abs(share)


@OUTSIDE.effect(
    "series",
    "give_rad",
    "rad",
    (0.0, 60 * ARCSEC),
    needs="preloads",
    draw=lambda rng: {"level": float(rng.integers(0, 4))},
)
def one_preload_square(b: Bench, v: Values, form: str) -> None:
    """T^2 of one sign at one level of preload only: a seat that opens there."""
    levels = np.unique(b.rows.preload_N)
    here = b.rows.preload_N == levels[int(v["level"]) % len(levels)]
    b.series += v["give_rad"] * here * (b.torque_Nm / _largest(b)) ** 2


@OUTSIDE.effect(
    "series",
    "give_rad",
    "rad",
    (0.0, 60 * ARCSEC),
    needs="reversal",
    draw=lambda rng: {"from_share": float(rng.uniform(0.2, 0.6))},
)
def one_sided_seat(b: Bench, v: Values, form: str) -> None:
    """A seat that gives for one sign of torque alone, once it passes a share of the largest."""
    over = np.maximum(-b.torque_Nm / _largest(b) - v["from_share"], 0.0)
    b.series -= v["give_rad"] * over / (1 - v["from_share"])


@OUTSIDE.effect(
    "reading",
    "amplitude_rad",
    "rad",
    (0.0, 10 * ARCSEC),
    draw=lambda rng: {"pitch_rad": float(rng.uniform(8, 20) * ARCSEC)},
)
def encoder_ripple(b: Bench, v: Values, form: str) -> None:
    """An interpolation error of the angle sensor, a sine of its own reading."""
    b.reading.append(
        lambda a: np.asarray(a + v["amplitude_rad"] * np.sin(2 * np.pi * a / v["pitch_rad"]))
    )


@OUTSIDE.effect(
    "series",
    "amplitude_rad",
    "rad",
    (0.0, 60 * ARCSEC),
    needs="angles",
    draw=lambda rng: {
        "order": float(rng.integers(2, 5)),
        "phase_rad": float(rng.uniform(0, 2 * np.pi)),
    },
)
def meshing_order(b: Bench, v: Values, form: str) -> None:
    """A high order of the input angle that grows with the torque, whatever its sign."""
    share = np.abs(b.torque_Nm) / _largest(b)
    wave = np.sin(v["order"] * b.rows.input_angle_rad + v["phase_rad"])
    b.series += v["amplitude_rad"] * share**1.5 * wave
