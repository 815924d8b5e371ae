"""Reducers that are torsion springs: loops, play, friction and stiffness curves.

    Spring          what turns: stiffness, the largest torque of its curve, calibrations
    SPRING_EFFECTS  what may be hidden in it, by id: forms, and the number that is its size
    SpringEffect    one of them with its numbers
    spring_rows     loops of the torque up and down, both ways
    turned_rad      the angle of every reading

The spring carries m = M - T(alpha), where T is a friction torque that remembers; its angle is
alpha = c(m) m/k + (play/2) side(m). Solved from one reading to the next: every loop begins where
the one before it ended, and friction does not fade in between. The first one begins at rest, or
after torques that nobody read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from reference.contact import Floats
from reference.rig.bench import ARCSEC, Friction, Rows
from reference.rig.campaign import Campaign
from reference.rig.friction import Dahl, Iwan
from reference.rig.mesh import Ints, root_of


@dataclass(frozen=True)
class Spring:
    """As stated (gains 1) or as it really is: logarithm of the stiffness' error, gains."""

    stiffness_Nm_per_rad: float
    top_Nm: float
    stiffer: float = 0.0
    torque_gain: float = 1.0
    sensor_gain: float = 1.0
    past: tuple[float, ...] = ()
    """Where the torque turned back before the first reading, over the largest one."""

    def before_Nm(self, first_Nm: float) -> Floats:
        """Torques from rest to the first reading."""
        turns = np.array([0.0, *(self.top_Nm * share for share in self.past), first_Nm])
        at = np.linspace(0, len(turns) - 1, 40 * (len(turns) - 1) + 1)
        return np.interp(at, np.arange(len(turns)), turns)[:-1] if self.past else np.zeros(0)

    @property
    def top_rad(self) -> float:
        """Angle under the largest torque, nominal."""
        return self.top_Nm / self.stiffness_Nm_per_rad


SPRING_EFFECTS: dict[str, tuple[str, ...]] = {
    "friction_hysteresis": ("dahl", "iwan", "blunt", "with_load"),
    "backlash": ("smooth", "hard", "offset"),
    "stiffness_curve": ("stiffening", "two_slopes", "one_sided"),
    "creep": ("library", "stretched"),
}
"""Forms by id; of a stiffness curve the library of causes need not know."""


@dataclass(frozen=True)
class SpringEffect:
    """size: friction torque over the largest torque, play over the largest angle, share of the
    largest angle that a curve takes away or creep adds. shape: an engagement angle over the largest
    angle, a transition torque over the largest torque, a knee, a time (s)."""

    id: str
    form: str
    size: float
    shape: float

    def sized(self, size: float) -> SpringEffect:
        """The same, stronger or weaker."""
        return replace(self, size=size)


def draw_spring_effect(effect_id: str, form: str, rng: np.random.Generator) -> SpringEffect:
    """An effect with its shape at random, small."""
    shape = {
        "friction_hysteresis": float(10 ** rng.uniform(-1.7, 0.0)),
        "backlash": float(10 ** rng.uniform(-1.9, -0.9)),
        "stiffness_curve": float(rng.uniform(0.3, 0.6)),
        "creep": float(10 ** rng.uniform(0.3, 1.5)),
    }[effect_id]
    return SpringEffect(effect_id, form, 0.02, shape)


def spring_rows(
    top_Nm: float, loops: int, steps: int, dwell_s: float, rng: np.random.Generator
) -> Rows:
    """Runs of one loop each: up, down, the other way, back."""
    up = np.arange(steps + 1) / steps
    lap = np.r_[up[1:], up[-2::-1]]
    share = np.r_[0.0, lap, -lap]
    n, m = loops, len(share)
    wait = rng.normal(dwell_s, 0.05 * dwell_s, (n, m)).clip(0.2 * dwell_s)
    time = np.cumsum(wait.ravel()) + np.repeat(60.0 * np.arange(n), m)
    nil = np.zeros(n * m)
    return Rows(
        run=np.repeat(np.arange(1, n + 1), m),
        time_s=time.round(2),
        torque_Nm=np.tile(share, n).round(6) * top_Nm,
        preload_N=nil,
        input_angle_rad=nil,
        temperature_degC=nil + 20.0,
        cycle=np.ones(n * m, dtype=np.int64),
    )


BLOCK = 12
"""Readings of a fast logger for one of a slow one."""


def ramped_rows(
    top_Nm: float, loops: int, steps: int, dwell_s: float, rng: np.random.Generator
) -> Rows:
    """What a fast logger sees of runs of one loop each at one rate, to 85 to 100 % of the torque. A
    slow one reads so many steps up to the largest."""
    rate = top_Nm / (steps * dwell_s)
    runs, clock = [], 0.0
    for _ in range(loops):
        top = top_Nm * rng.uniform(0.85, 1.0)
        count = int(4 * top / rate / dwell_s) * BLOCK
        time = dwell_s / BLOCK * np.arange(count)
        torque = np.interp(rate * time, top * np.array([0, 1, 3, 4]), top * np.array([0, 1, -1, 0]))
        runs.append((clock + time, torque))
        clock += float(time[-1]) + 60.0
    nil = np.zeros(sum(len(time) for time, _ in runs))
    return Rows(
        run=np.repeat(np.arange(1, loops + 1), [len(time) for time, _ in runs]),
        time_s=np.concatenate([time for time, _ in runs]),
        torque_Nm=np.concatenate([torque for _, torque in runs]),
        preload_N=nil,
        input_angle_rad=nil,
        temperature_degC=nil + 20.0,
        cycle=np.ones(len(nil), dtype=np.int64),
    )


def logged_rows(fast: Rows, means: bool) -> Rows:
    """What a slow logger makes of them."""
    slow = fast.take(np.arange(0, len(fast), BLOCK))
    time_s, torque_Nm = (logged(column, means) for column in (fast.time_s, fast.torque_Nm))
    return replace(slow, time_s=time_s, torque_Nm=torque_Nm)


def logged(column: Floats, means: bool) -> Floats:
    """What a slow logger makes of a column of a fast one: means of blocks, or samples."""
    blocks = column.reshape(-1, BLOCK)
    return np.asarray(blocks.mean(axis=1) if means else blocks[:, BLOCK // 3])


# --- the angle --------------------------------------------------------------------------------


def _curve(spring: Spring, effects: Sequence[SpringEffect], m: Floats) -> tuple[Floats, Floats]:
    """Angle (rad) under the torque that the spring carries, and its slope."""
    k = spring.stiffness_Nm_per_rad * np.exp(spring.stiffer)
    x = m / spring.top_Nm
    angle, slope = m / k, np.full_like(m, 1 / k)
    for e in effects:
        if e.id == "stiffness_curve":
            add, by = _less(e, x)
            angle, slope = angle - spring.top_rad * add, slope - by / spring.stiffness_Nm_per_rad
        if e.id == "backlash":
            side, by = _side(e, x)
            half = 0.5 * e.size * spring.top_rad
            angle, slope = angle + half * side, slope + half * by / spring.top_Nm
    return angle, slope


def _less(e: SpringEffect, x: Floats) -> tuple[Floats, Floats]:
    """Share of the largest angle that the curve takes away at a share of the torque; slope."""
    if e.form == "stiffening":
        return e.size * x**3, 3 * e.size * x**2
    over = np.abs(x) - e.shape
    if e.form == "one_sided":
        over = -x - e.shape
    over = np.maximum(over, 0.0) / (1 - e.shape)
    sign = np.where(x < 0, -1.0, 1.0)
    slope = np.where(over > 0, e.size / (1 - e.shape), 0.0)
    return e.size * sign * over, slope


def _side(e: SpringEffect, x: Floats) -> tuple[Floats, Floats]:
    """Which flank carries, -1 to 1, at a share of the largest torque; slope."""
    x = x - 0.5 * e.shape if e.form == "offset" else x
    if e.form == "hard":
        return np.clip(x / e.shape, -1, 1), (np.abs(x) < e.shape) / e.shape
    wide = np.hypot(x, e.shape)
    return x / wide, e.shape**2 / wide**3


def _friction(
    spring: Spring, effects: Sequence[SpringEffect], load_Nm: Floats
) -> tuple[Friction, Floats] | None:
    """Law and limit (N m) of every reading; None without friction."""
    for e in effects:
        if e.id == "friction_hysteresis":
            length = e.shape * spring.top_rad
            laws: dict[str, Friction] = {
                "dahl": Dahl(length),
                "iwan": Iwan(length),
                "blunt": Dahl(length, power=0.5),
                "with_load": Dahl(length),
            }
            limit = np.full(len(load_Nm), e.size * spring.top_Nm)
            if e.form == "with_load":
                limit = limit * (0.3 + 1.4 * np.abs(load_Nm) / spring.top_Nm)
            return laws[e.form], limit
    return None


def _crept(spring: Spring, effects: Sequence[SpringEffect], rows: Rows) -> Floats:
    out = np.zeros(len(rows))
    for e in effects:
        if e.id == "creep":
            t = rows.run_time_s / e.shape
            grown = np.log1p(t) if e.form == "library" else 4 * (1 - np.exp(-np.sqrt(t / 8)))
            out += e.size * spring.top_rad * rows.torque_Nm / spring.top_Nm * grown
    return out


def turned_rad(spring: Spring, rows: Rows, effects: Sequence[SpringEffect] = ()) -> Floats:
    """Angle (rad) of every reading."""
    load = rows.torque_Nm * spring.torque_gain
    after = _crept(spring, effects, rows)
    if _friction(spring, effects, load) is None:
        return np.asarray(spring.sensor_gain * (_curve(spring, effects, load)[0] + after))
    before = spring.before_Nm(float(rows.torque_Nm[0])) * spring.torque_gain
    turned = _turned_under_friction(spring, effects, np.concatenate([before, load]))
    return np.asarray(spring.sensor_gain * (turned[len(before) :] + after))


def _turned_under_friction(spring: Spring, effects: Sequence[SpringEffect], load: Floats) -> Floats:
    friction = _friction(spring, effects, load)
    assert friction is not None
    law, limit = friction
    angle = np.zeros(len(load))
    now = np.array([0])
    angle[now] = _curve(spring, effects, load[now])[0]
    memory = law.begin(limit[now])
    rate = np.zeros(1)
    for step in range(1, len(load)):
        now = np.array([step])
        before = angle[now - 1]
        memory = (memory[0], limit[now])

        def balance(
            m: Floats,
            now: Ints = now,
            before: Floats = before,
            memory: object = memory,
        ) -> tuple[Floats, Floats]:
            turned, slope = _curve(spring, effects, m)
            held, stiff = law.torque(memory, turned - before, rate)
            return m - load[now] + held, 1 + stiff * slope

        wide = 1.5 * limit[now] + 1e-12
        unit = np.abs(load[now]) + wide
        m = root_of(balance, load[now], load[now] - wide, load[now] + wide, unit)
        angle[now] = _curve(spring, effects, m)[0]
        memory = law.step(memory, angle[now] - before, rate)
    return angle


@dataclass(frozen=True)
class SpringCampaign(Campaign):
    """Readings of a torsion spring: no preload, no input angle, no temperature."""

    def columns(self) -> dict[str, Floats]:
        """Run, time, torque, angle and its uncertainty."""
        left_out = ("preload_N", "input_angle_deg", "temperature_degC", "cycle")
        return {k: v for k, v in super().columns().items() if k not in left_out}

    def to_csv(self) -> str:
        """The table as text."""
        columns = self.columns()
        rows = zip(*(c.tolist() for c in columns.values()), strict=True)
        return "\n".join([",".join(columns), *(",".join(map(str, r)) for r in rows)]) + "\n"


def draw_spring(rng: np.random.Generator) -> tuple[dict[str, dict[str, float]], Spring]:
    """A case and the spring that it states: seconds of arc to minutes under the largest torque."""
    top = float(np.round(10 ** rng.uniform(0.0, 2.0), 2))
    angle = float(10 ** rng.uniform(1.3, 3.0)) * ARCSEC
    stated = float(np.round(top / angle * np.pi / 10800, 6))
    case = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": stated}}
    return case, Spring(stated * 10800 / np.pi, top)
