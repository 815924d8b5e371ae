"""Effects of calibrations, contacts, the instrument, and of what stands in series.

T is the torque M0 on the output, a the elastic angle, Zo e the arm from the output plate's centre
to the pitch point.
"""

from __future__ import annotations

import numpy as np

from reference.contact import Floats
from reference.rig.bench import ARCSEC, Bench, Rows
from reference.rig.kinds import Register, Values, any_seed
from reference.rig.mesh import Law

SERIES = Register()


# --- what calibrations and the contacts' numbers do -------------------------------------------


@SERIES.effect("contact", "scale", "", (0.3, 3.0), neutral=1.0)
def contact_stiffness(b: Bench, v: Values, form: str) -> None:
    b.stiffness_scale *= v["scale"]


@SERIES.effect("contact", "shift_rad", "rad", (0.0, 0.17), signed=True)
def contact_angle(b: Bench, v: Values, form: str) -> None:
    b.contact_angle_rad += v["shift_rad"]


@SERIES.effect("instrument", "gain", "", (0.7, 1.4), neutral=1.0)
def torque_scale(b: Bench, v: Values, form: str) -> None:
    b.torque_Nm *= v["gain"]


@SERIES.effect("instrument", "gain", "", (0.7, 1.4), neutral=1.0)
def preload_scale(b: Bench, v: Values, form: str) -> None:
    b.preload_N *= v["gain"]


@SERIES.effect("reading", "gain", "", (0.7, 1.4), neutral=1.0)
def sensor_gain(b: Bench, v: Values, form: str) -> None:
    b.reading.append(lambda a: v["gain"] * a)


@SERIES.effect("contact", "excess", "n - 1.5", (0.0, 1.0), forms=("library", "asperities"))
def rough_contact(b: Bench, v: Values, form: str) -> None:
    """N = k d0^1.5 (delta/d0)^n; variant: a soft layer of asperities on a Hertz contact."""
    if form == "library":
        b.law = Law(exponent=1.5 + v["excess"])
    else:
        b.law = Law(layer_m=v["excess"] * 0.4e-6)


# --- the instrument ---------------------------------------------------------------------------


@SERIES.effect(
    "reading",
    "error_rad",
    "rad at 60 arcsec",
    (0.0, 20 * ARCSEC),
    forms=("library", "saturating"),
    draw=lambda rng: {"cubic_share": float(rng.choice([0.0, 1.0, 0.5]))},
)
def sensor_nonlinearity(b: Bench, v: Values, form: str) -> None:
    """c2 a^2 + c3 a^3, both as the error at 60 arcsec; variant: a sensor that saturates."""
    full = 60 * ARCSEC
    size, cubic = v["error_rad"], v["cubic_share"]

    def reads(a: Floats) -> Floats:
        x = a / full
        if form == "saturating":
            return np.asarray(a - size * (np.tanh(x) ** 3) / np.tanh(1.0) ** 3)
        return np.asarray(a + size * ((1 - abs(cubic)) * x**2 + cubic * x**3))

    b.reading.append(reads)


@SERIES.effect("reading", "spread_rad", "rad", (0.0, 10 * ARCSEC), draw=any_seed)
def run_offset(b: Bench, v: Values, form: str) -> None:
    """A zero for each run, normal with the given spread."""
    runs, back = np.unique(b.rows.run, return_inverse=True)
    zeros = v["spread_rad"] * np.random.default_rng(int(v["seed"])).standard_normal(len(runs))
    b.reading.append(lambda a: a + zeros[back])


@SERIES.effect(
    "reading",
    "total_rad",
    "rad",
    (0.0, 20 * ARCSEC),
    forms=("library", "temperature", "warm_up"),
    signed=True,
)
def drift(b: Bench, v: Values, form: str) -> None:
    """c t; or c (T - T0); or slowing down as a warm-up does. Size: what it has reached at last."""
    t = b.rows.time_s - b.rows.time_s[0]
    warm = b.rows.temperature_degC - b.rows.temperature_degC[0]
    way = {
        "library": t / max(float(t.max()), 1e-9),
        "temperature": warm / max(float(np.abs(warm).max()), 1e-9),
        "warm_up": 1 - np.exp(-3 * t / max(float(t.max()), 1e-9)),
    }[form]
    b.reading.append(lambda a: a + v["total_rad"] * way)


# --- in series behind the meshing points ------------------------------------------------------


@SERIES.effect(
    "series",
    "u_ref_m",
    "m at 100 N",
    (0.02e-6, 20e-6),
    forms=("library", "mixed"),
    draw=lambda rng: {"exponent": float(rng.choice([0.9, 2 / 3]))},
)
def eccentric_bearing(b: Bench, v: Values, form: str) -> None:
    """F = T/(Zo e), u = u_ref (F/100 N)^q, angle sgn(T) u/(Zo e); variant: balls and rollers."""
    force = np.abs(b.torque_Nm) / b.arm_m / 100
    q = v["exponent"]
    mixed = 0.5 * force ** (2 / 3) + 0.5 * force**0.9
    way = mixed if form == "mixed" else force**q
    b.series += np.sign(b.torque_Nm) * v["u_ref_m"] * way / b.arm_m


@SERIES.effect(
    "series", "clearance_m", "m", (0.0, 20e-6), forms=("library", "gradual"), needs="reversal"
)
def bearing_play(b: Bench, v: Values, form: str) -> None:
    """+-(c/2)/(Zo e) with the sign of T; variant: taken up over a small torque."""
    side = np.sign(b.torque_Nm)
    if form == "gradual":
        side = np.tanh(b.torque_Nm / (0.04 * np.abs(b.torque_Nm).max()))
    b.series += side * v["clearance_m"] / 2 / b.arm_m


@SERIES.effect(
    "series", "compliance_rad_per_Nm", "rad/(N m)", (1e-7, 1e-4), forms=("library", "stiffening")
)
def output_torsion(b: Bench, v: Values, form: str) -> None:
    """T c; variant: a shaft joint that gives less as it is loaded."""
    share = np.abs(b.torque_Nm) / np.abs(b.torque_Nm).max()
    less = 1 - 0.12 * share if form == "stiffening" else 1.0
    b.series += v["compliance_rad_per_Nm"] * b.torque_Nm * less


@SERIES.effect(
    "series",
    "offset_m",
    "m",
    (0.02e-6, 20e-6),
    forms=("library", "planet", "second_harmonic"),
    needs="angles",
    draw=lambda rng: {"phase_rad": float(rng.uniform(0, 2 * np.pi))},
)
def eccentricity_error(b: Bench, v: Values, form: str) -> None:
    """(de/(Zo e)) sin(theta + phase); of the planet: theta Z1/Z3; variant: 15 % second harmonic."""
    theta, z2 = b.rows.input_angle_rad, b.drive.deceleration.ball_count
    way = theta * (z2 - 1) / (z2 + 1) if form == "planet" else theta
    turn = np.sin(way + v["phase_rad"])
    if form == "second_harmonic":
        turn = turn + 0.15 * np.sin(2 * theta + 1.7 * v["phase_rad"])
    b.series += v["offset_m"] / b.arm_m * turn


def _first_loading(rows: Rows, per_run: bool) -> Floats:
    """Largest torque either way so far, of the campaign or since each run began."""
    so_far = np.maximum.accumulate(np.abs(rows.torque_Nm))
    if per_run:
        for run in np.unique(rows.run):
            here = rows.run == run
            so_far[here] = np.maximum.accumulate(np.abs(rows.torque_Nm[here]))
    return np.asarray(so_far / np.abs(rows.torque_Nm).max())


@SERIES.effect(
    "series",
    "set_rad",
    "rad",
    (0.0, 30 * ARCSEC),
    forms=("library", "per_run", "cycles"),
    needs="cycles",
)
def run_in(b: Bench, v: Values, form: str) -> None:
    """Permanent set, growing with the largest torque so far; of each run; or by the cycle."""
    if form == "cycles":
        done = b.rows.cycle - 1.0
        b.series += v["set_rad"] * (1 - np.exp(-1.2 * done))
    else:
        b.series += v["set_rad"] * _first_loading(b.rows, form == "per_run")


@SERIES.effect(
    "series",
    "rate_rad_per_Nm",
    "rad/(N m)",
    (1e-9, 1e-5),
    forms=("library", "stretched", "two_exponentials", "superposed"),
    draw=lambda rng: {"tau_s": float(10 ** rng.uniform(0.5, 2.2))},
)
def creep(b: Bench, v: Values, form: str) -> None:
    """c T ln(1 + t/tau) since the run began; variants: a stretched exponential, two exponentials,
    or each step of torque creeping from its own time (superposition)."""
    t, tau = b.rows.run_time_s, v["tau_s"]
    if form == "superposed":
        way = np.zeros(len(t))
        for run in np.unique(b.rows.run):
            at = np.flatnonzero(b.rows.run == run)
            steps = np.diff(b.torque_Nm[at], prepend=0.0)
            since = np.maximum(t[at][:, None] - t[at][None, :], 0.0)
            way[at] = np.log1p(since / tau) @ steps
        b.series += v["rate_rad_per_Nm"] * way
        return
    grown = {
        "library": np.log1p(t / tau),
        "stretched": 4 * (1 - np.exp(-np.sqrt(t / (8 * tau)))),
        "two_exponentials": 1.5 * (1 - np.exp(-t / (2 * tau))) + 2 * (1 - np.exp(-t / (15 * tau))),
    }[form]
    b.series += v["rate_rad_per_Nm"] * b.torque_Nm * grown
