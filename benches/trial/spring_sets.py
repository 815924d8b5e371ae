"""Torsion springs with loops, play, friction, creep and stiffness curves, and without.

    spring_set       one campaign, with what the oracle says of it
    spring_artefact  one under an artefact of an instrument, with friction or nothing
    spring_logged    one whose torque turns back between the readings of a logger with a clock

Free are the spring's stiffness, the gains of torque and angle within their priors, and one zero.
Half of them had been turned to and fro before the first reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from reference.contact import Floats
from reference.rig import Rows
from reference.rig.campaign import PRIORS, Campaign
from reference.rig.instrument import ARTEFACTS, TOGETHER, Instrument, instrument, plain_values
from reference.rig.noise import Noise
from reference.rig.springs import (
    SPRING_EFFECTS,
    Spring,
    SpringCampaign,
    SpringEffect,
    draw_spring,
    draw_spring_effect,
    logged,
    logged_rows,
    ramped_rows,
    spring_rows,
    turned_rad,
)
from trial.candidates import remaining
from trial.evidence import Candidate, likeliest, posterior, spoken
from trial.strength import ZERO_PRIOR_RAD, NoSuchCampaignError, draw_parameters

SETS: tuple[tuple[str, ...], ...] = (
    (),
    ("friction_hysteresis",),
    ("backlash",),
    ("stiffness_curve",),
    ("friction_hysteresis", "backlash"),
    ("creep",),
)
ACCEPTED = {
    "friction_hysteresis": ["friction_hysteresis", "distributed_friction"],
    "backlash": ["backlash", "bearing_play"],
    "creep": ["creep"],
    # A function of the load is one of the reading; a joint softer one way has a bend as well.
    "stiffness_curve": ["stiffness_curve", "sensor_nonlinearity", "output_torsion"],
}
PASTS: tuple[tuple[float, ...], ...] = ((), (-1.0, 1.0), (), (1.0, -1.0), (), (0.6, -0.6, 0.6))
"""Where the torque turned back before the first reading, over the largest one."""
MOST_SIZE = 0.6
FREE = {"contact_stiffness_rel": "stiffer", "torque_gain_rel": "", "sensor_gain_rel": ""}


@dataclass(frozen=True)
class SpringYard:
    """Measures d on one table of a spring."""

    spring: Spring
    rows: Rows
    noise: Instrument | Noise

    @cached_property
    def angle_rad(self) -> Floats:
        """Without effects."""
        return turned_rad(self.spring, self.rows)

    @cached_property
    def _factor(self) -> Floats:
        slopes = []
        for name in FREE:
            step = 0.02 * PRIORS[name]
            moved = off_nominal(self.spring, {name: step})
            slopes.append((turned_rad(moved, self.rows) - self.angle_rad) / 0.02)
        j = np.column_stack(slopes)
        covariance = self.noise.covariance(self.rows) + ZERO_PRIOR_RAD**2
        return np.asarray(cholesky(covariance + j @ j.T, lower=True))

    def whiten(self, change_rad: Floats) -> Floats:
        """What is left of a change after refitting, in standard deviations."""
        return np.asarray(solve_triangular(self._factor, change_rad, lower=True))

    def columns(self, effects: Sequence[SpringEffect]) -> list[Floats]:
        """Of each effect, the difference that leaving it out makes."""
        every = turned_rad(self.spring, self.rows, effects)
        less = [[e for e in effects if e is not own] for own in effects]
        return [self.whiten(every - turned_rad(self.spring, self.rows, rest)) for rest in less]


def off_nominal(spring: Spring, shifts: dict[str, float]) -> Spring:
    """The spring with its calibrations off, by their logarithms."""
    return replace(
        spring,
        stiffer=spring.stiffer + shifts.get("contact_stiffness_rel", 0.0),
        torque_gain=spring.torque_gain * float(np.exp(shifts.get("torque_gain_rel", 0.0))),
        sensor_gain=spring.sensor_gain * float(np.exp(shifts.get("sensor_gain_rel", 0.0))),
    )


def _sized(
    yard: SpringYard, starts: Sequence[SpringEffect], d: float
) -> tuple[list[SpringEffect], list[float]]:
    found = list(starts)
    for _ in range(12):
        left = remaining(yard.columns(found))
        if all(abs(x / d - 1) < 0.04 for x in left):
            return found, left
        for i, (e, x) in enumerate(zip(found, left, strict=True)):
            size = e.size * float(np.clip(d / max(x, 1e-9), 0.05, 30.0))
            if size > MOST_SIZE:
                raise NoSuchCampaignError(f"{e.id}: d = {d:g} is beyond its range here", 0.5)
            found[i] = e.sized(size)
    raise NoSuchCampaignError(f"{[e.id for e in starts]}: no such strength", 0.8)


def _candidates(yard: SpringYard, hidden: Sequence[SpringEffect]) -> list[Candidate]:
    rng = np.random.default_rng(13)
    found = []
    for name, forms in SPRING_EFFECTS.items():
        for form in forms:
            for _ in range(3):
                column = yard.columns([draw_spring_effect(name, form, rng)])
                found.append(Candidate.of(name, form, column, one_sided=True))
    for e, own in zip(hidden, yard.columns(hidden), strict=True):
        found.append(Candidate.of(e.id, "true", [own], one_sided=True))
    return [c for c in found if c]


def spring_set(
    rng: np.random.Generator, noise_factor: float, index: int
) -> tuple[Campaign, dict[str, Any]]:
    """Set number index: effects in turn, d = 8, 12 and 20 in turn, every other with zeros of runs
    and correlation."""
    ids, turn = SETS[index % len(SETS)], index // len(SETS)
    d = (12.0, 8.0, 20.0)[turn % 3]
    return _drawn(rng, noise_factor, TOGETHER if (index + turn) % 2 else "white", ids, d)


def spring_artefact(rng: np.random.Generator, noise_factor: float, index: int) -> Campaign:
    """Set number index: artefacts in turn, first with nothing hidden, then with friction."""
    ids = SETS[index // len(ARTEFACTS) % 2]
    made, _ = _drawn(rng, noise_factor, ARTEFACTS[index % len(ARTEFACTS)], ids, 12.0)
    return made


def spring_logged(rng: np.random.Generator, noise_factor: float, index: int) -> Campaign:
    """Set number index: effects in turn; means of blocks and samples in turn; d = 60 and 12 in
    turn, as turns in a wrong place are lost in the noise of weak friction."""
    ids, turn = SETS[index % len(SETS)], index // len(SETS)
    means = bool((index + turn) % 2)
    return _drawn(rng, noise_factor, "white", ids, (60.0, 12.0)[turn % 2], means)[0]


def _drawn(
    rng: np.random.Generator,
    noise_factor: float,
    kind: str,
    ids: Sequence[str],
    d: float,
    means: bool | None = None,
) -> tuple[Campaign, dict[str, Any]]:
    """means: whether a logger with a clock takes means or samples; None where torques are set. To
    the oracle and for d all torques are set."""
    case, stated = draw_spring(rng)
    stated = replace(stated, past=PASTS[int(rng.integers(len(PASTS)))])
    loops, steps = int(rng.integers(2, 7)), int(rng.integers(6, 15))
    of_loops = stated.top_Nm, loops, steps, float(rng.uniform(1.5, 6.0)), rng
    fast = None if means is None else ramped_rows(*of_loops)
    rows = spring_rows(*of_loops) if fast is None else logged_rows(fast, bool(means))
    u = stated.top_rad * float(10 ** rng.uniform(-3.3, -2.3)) * noise_factor
    noise = instrument(kind, u, 1 / stated.stiffness_Nm_per_rad, rng)
    if isinstance(noise, Instrument) and noise.ripple_rad > 0:
        # As many periods as a ball drive turns by.
        noise = replace(noise, period_rad=2 * stated.top_rad / float(rng.uniform(6.0, 15.0)))
    shifts = draw_parameters(rng, {n: PRIORS[n] for n in FREE})
    real = off_nominal(stated, shifts)
    yard = SpringYard(real, rows, noise)
    starts = [draw_spring_effect(i, str(rng.choice(SPRING_EFFECTS[i])), rng) for i in ids]
    hidden, left = _sized(yard, starts, d) if ids else ([], [])
    loads = noise.loads(rows, rng) if isinstance(noise, Instrument) else (rows, rows)
    angle = turned_rad(real, loads[0] if fast is None else fast, hidden)
    angle = angle if fast is None else logged(angle, bool(means))
    read = noise.readings(angle, loads[0], rng)
    truth: dict[str, Any] = {
        "hidden": [{"id": e.id, "form": e.form, "values": vars(e)} for e in hidden],
        "noise": plain_values(noise),
        "past": stated.past,
        "shifts": shifts,
        "free": [*FREE, "zero"],
        "accepted": [ACCEPTED[i] for i in ids],
        "readings": len(rows),
        "conditional": left,
        "d": min(left, default=0.0),
        "answer": {
            "kind": "effect" if ids else "complete",
            "effects": list(ids),
            "rivals": [],
            "kinds": ["complete", "rig", "parameter"],
        },
    }
    off = read - yard.angle_rad + (yard.angle_rad - turned_rad(stated, rows))
    found = posterior(yard.whiten(off), _candidates(yard, hidden))
    said = {"answer": spoken(found), "best": likeliest(found)}
    made = SpringCampaign(case, loads[1], read, np.full(len(rows), u), truth)
    return made, said
