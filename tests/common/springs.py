"""Loops of a reducer that is a torsion spring with friction and play, simulated by themselves.

The torque that the spring carries is found by bisection, reading by reading; nothing is shared with
the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Reducer:
    """What turns: stiffness, play, friction that grows with the load, creep."""

    bend_rad: float = 0.0
    """What it turns less at 30 N m than in proportion, with the cube of the torque."""

    stiffness_Nm_per_rad: float = 2000.0
    play_rad: float = 0.0
    transition_Nm: float = 0.5
    friction_Nm: float = 0.0
    engagement_rad: float = 5e-4
    load_share: float = 0.0
    creep_rad_per_Nm: float = 0.0
    creep_time_s: float = 20.0

    def angle(self, carried_Nm: float) -> float:
        """Of the spring and its play."""
        play = 0.5 * self.play_rad * carried_Nm / np.hypot(carried_Nm, self.transition_Nm)
        bend = self.bend_rad * (carried_Nm / 30.0) ** 3
        return float(carried_Nm / self.stiffness_Nm_per_rad + play - bend)

    def run(self, time_s: Floats, torque_Nm: Floats) -> Floats:
        """Angles along one run that starts unloaded, rad."""
        state, angle, out = 0.0, 0.0, np.empty(len(torque_Nm))
        for i, (t, torque) in enumerate(zip(time_s - time_s[0], torque_Nm, strict=True)):
            creep = self.creep_rad_per_Nm * torque * float(np.log1p(t / self.creep_time_s))
            angle, state = self.next(float(torque), creep, angle, state)
            out[i] = angle
        return out

    def next(self, torque: float, creep: float, before: float, state: float) -> tuple[float, float]:
        """Angle and state of the friction under a torque, from those before it."""
        limit = self.friction_Nm + self.load_share * abs(torque)
        low, high = torque - limit, torque + limit
        for _ in range(80):
            carried = 0.5 * (low + high)
            angle = self.angle(carried) + creep
            sense = 1.0 if angle >= before else -1.0
            after = sense - (sense - state) * float(
                np.exp(-abs(angle - before) / self.engagement_rad)
            )
            if carried - torque + limit * after > 0:
                high = carried
            else:
                low = carried
        return angle, after


def loops(
    reducers: list[Reducer],
    noise_rad: float = 2e-5,
    seed: int = 1,
    peak_Nm: float = 20.0,
    rows: int = 64,
) -> dict[str, Any]:
    """One loop a reducer, each a run and a step of the preload; columns of a table."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 60.0, rows)
    # Up, down through zero, and back to it.
    torque = np.interp(time, [0.0, 15.0, 45.0, 60.0], [0.0, peak_Nm, -peak_Nm, 0.0])
    angles = [r.run(time, torque) for r in reducers]
    count = len(reducers)
    noise = noise_rad * rng.standard_normal(rows * count)
    return {
        "run": np.repeat(np.arange(1, count + 1), rows),
        "preload_step": np.repeat(np.arange(1, count + 1), rows),
        "time_s": np.tile(time, count),
        "torque_Nm": np.tile(torque, count),
        "elastic_angle_rad": np.concatenate(angles) + noise,
    }
