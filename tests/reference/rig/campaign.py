"""Random drives, test plans, and campaigns with a sealed truth."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from reference.contact import Floats
from reference.forward import RingGroove
from reference.rig.bench import ARCSEC, CaseDict, Effect, Rows, drive_of, held_Nm

PRIORS: dict[str, float] = {
    "contact_stiffness_rel": 0.10,
    "contact_angle_deg": 0.5,
    "torque_gain_rel": 0.01,
    "preload_gain_rel": 0.02,
    "sensor_gain_rel": 0.005,
}
MOST_READINGS = 560
COLUMNS = (
    "run",
    "cycle",
    "time_s",
    "torque_Nm",
    "preload_N",
    "input_angle_deg",
    "temperature_degC",
    "elastic_angle_arcsec",
    "u_elastic_angle_arcsec",
)


# --- drives -----------------------------------------------------------------------------------


def draw_case(rng: np.random.Generator) -> dict[str, dict[str, Any]]:
    """A drive without any finding: no undercut, inside walls present, balls apart."""
    for _ in range(2000):
        z2 = int(rng.choice([14, 16, 18, 20, 22, 24]))
        r0 = float(rng.choice([2.5, 2.8, 3.2, 3.6, 4.0]))
        conformity = float(rng.choice([1.05, 1.06, 1.08]))
        beta = float(rng.choice([40.0, 45.0, 50.0]))
        ball = float(rng.choice([1.0, 1.2, 1.3, 1.5]))
        slide = bool(rng.random() < 0.25)
        case: dict[str, dict[str, Any]] = {
            "material": {"youngs_modulus_GPa": 208.0, "poissons_ratio": 0.3},
            "deceleration": {
                "ball_count": z2,
                "short_amplitude_coefficient": float(rng.choice([0.4, 0.45, 0.5, 0.55])),
                "rolling_circle_radius_mm": r0,
                "ball_radius_mm": ball,
                "groove_conformity": conformity,
                "contact_angle_deg": beta,
            },
            "equal_speed": {
                "kind": "cross_slide" if slide else "ring_groove",
                "ball_count": int(rng.choice([12, 14, 15, 16] if slide else [8, 10, 12])),
                "pitch_radius_mm": float(rng.choice([32.0, 35.0, 38.0, 40.0])),
                "ball_radius_mm": ball,
                "groove_conformity": conformity,
                "contact_angle_deg": beta,
            },
        }
        if _sound(case):
            return case
    raise ArithmeticError("no sound drive found")


def _sound(case: CaseDict) -> bool:
    """Whether a drive has all its walls with some margin and its balls do not touch."""
    drive = drive_of(case)
    found = drive.deceleration.findings()
    if found["undercut"] or found["balls_touch"]:
        return False
    beta = drive.deceleration.contact_angle_rad
    if found["smallest_track_radius_m"] < 1.2 * drive.deceleration.ball_radius_m * np.cos(beta):
        return False
    pair = drive.equal_speed
    if isinstance(pair, RingGroove):
        near = pair.ring_radius_m < 1.1 * pair.ball_radius_m * np.cos(beta)
        rings = pair.findings()
        return not (near or rings["balls_touch"] or rings["grooves_overlap"])
    return not pair.findings()["balls_touch"]


# --- test plans -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Plan:
    """How a campaign is run: levels, angles, ramps, rates, warming."""

    preloads_N: tuple[float, ...]
    angles_deg: tuple[float, ...]
    own_angle_each_run: bool
    cycles: int
    steps: int
    torque_share: float
    negative: bool
    dwells_s: tuple[float, ...]
    warming_K: float
    one_way: bool = False
    steady_warming: bool = False


def draw_plan(rng: np.random.Generator, needs: Sequence[str] = (), thin: bool = False) -> Plan:
    """A sensible plan; needs: preloads, angles, reversal, cycles, temperature, rates."""
    lowest = float(rng.integers(35, 56)) * 10
    count = 1 if thin else int(rng.integers(3 if "preloads" in needs else 2, 5))
    ratio = float(rng.uniform(2.2, 3.2))
    levels = [lowest * ratio ** (i / max(count - 1, 1)) for i in range(count)]
    if thin:
        levels = [lowest * 2]
    how_many = int(rng.integers(5, 9)) if "angles" in needs else int(rng.integers(3, 5))
    first = float(rng.uniform(0, 60))
    angles = [round(first + 360 / how_many * i, 1) for i in range(1 if thin else how_many)]
    rates = "rates" in needs or (not thin and bool(rng.random() < 0.4))
    dwells = tuple(round(float(x), 1) for x in rng.uniform(1.5, 9.0, 4)) if rates else (4.0,)
    warming = float(rng.uniform(4, 9)) if "temperature" in needs else float(rng.uniform(0.5, 4))
    cycles = 2 if "cycles" in needs or (not thin and rng.random() < 0.2) else 1
    steps = 8 if thin else int(rng.integers(5, 9))
    while len(levels) * len(angles) * steps * 4 * cycles > MOST_READINGS and steps > 4:
        steps -= 1
    if len(levels) * len(angles) * steps * 4 * cycles > MOST_READINGS:
        levels = [levels[0], levels[len(levels) // 2], levels[-1]][: max(2, len(levels) - 1)]
    return Plan(
        preloads_N=tuple(round(x / 10) * 10.0 for x in levels),
        angles_deg=tuple(angles),
        own_angle_each_run=not thin and "angles" not in needs and bool(rng.random() < 0.25),
        cycles=cycles,
        steps=steps,
        torque_share=float(rng.uniform(0.55, 0.9)),
        negative="reversal" in needs or bool(rng.random() < 0.85),
        dwells_s=dwells,
        warming_K=warming,
        one_way=thin,
    )


def _ramp(plan: Plan) -> tuple[list[float], list[int]]:
    """Shares of the largest torque of one run and the cycle of each: up, down, other way, back."""
    up = [i / plan.steps for i in range(plan.steps + 1)]
    if plan.one_way:
        return up, [1] * len(up)
    lap = up[1:] + up[-2::-1]
    if plan.negative:
        lap = lap + [-x for x in lap]
    return [0.0] + lap * plan.cycles, [1] + [c + 1 for c in range(plan.cycles) for _ in lap]


def rows_of(plan: Plan, case: CaseDict, rng: np.random.Generator) -> Rows:
    """The table of a plan, its largest torque a share of what the lowest preload holds.

    Time runs on from run to run with a pause between; the housing warms towards a limit.
    """
    runs = [(p, a) for p in plan.preloads_N for a in plan.angles_deg]
    if plan.own_angle_each_run:
        angles = np.round(np.sort(rng.uniform(0, 360, len(runs))), 1)
        runs = [(p, float(a)) for (p, _), a in zip(runs, rng.permutation(angles), strict=True)]
    share, cycle = _ramp(plan)
    n, m = len(runs), len(share)
    time, clock = np.zeros((n, m)), 0.0
    for i in range(n):
        dwell = plan.dwells_s[i % len(plan.dwells_s)]
        time[i] = clock + np.concatenate([[0], np.cumsum(rng.normal(dwell, 0.05 * dwell, m - 1))])
        clock = time[i, -1] + 120.0
    flat = time.ravel().round(2)
    late = 1 - np.exp(-flat / (0.5 * max(float(flat[-1]), 1.0)))
    if plan.steady_warming:
        late = flat / max(float(flat[-1]), 1.0)
    temperature = 20 + plan.warming_K * late
    temperature[0] = 20.0
    rows = Rows(
        run=np.repeat(np.arange(1, n + 1), m),
        time_s=flat,
        torque_Nm=np.tile(share, n),
        preload_N=np.repeat([p for p, _ in runs], m),
        input_angle_rad=np.deg2rad(np.repeat([a for _, a in runs], m)),
        temperature_degC=temperature.round(3),
        cycle=np.tile(cycle, n),
    )
    up, down = held_Nm(drive_of(case), rows)
    top = plan.torque_share * float(np.minimum(up, down).min())
    step = top / plan.steps
    digits = 1 - int(np.floor(np.log10(step)))
    step = np.floor(step * 10**digits) / 10**digits
    torque = np.round(rows.torque_Nm * plan.steps) * step
    return Rows(**{**vars(rows), "torque_Nm": torque.round(6)})


# --- campaigns --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Campaign:
    """Readings of a drive. truth is sealed: nothing that analyses may look at it.

    case: the case file as tables; effects: what made the data (all of it, calibrations too).
    """

    case: dict[str, dict[str, Any]]
    rows: Rows
    angle_rad: Floats
    stated_u_rad: Floats
    truth: dict[str, Any]
    effects: tuple[Effect, ...] = field(default=(), repr=False)

    def columns(self) -> dict[str, Floats]:
        """The table, by the names and in the units of the file, rounded as in the file."""
        r = self.rows
        values: tuple[Any, ...] = (
            r.run,
            r.cycle,
            r.time_s,
            r.torque_Nm,
            r.preload_N,
            np.rad2deg(r.input_angle_rad).round(6),
            r.temperature_degC,
            (self.angle_rad / ARCSEC).round(4),
            (self.stated_u_rad / ARCSEC).round(6),
        )
        return dict(zip(COLUMNS, values, strict=True))

    def to_csv(self) -> str:
        """The table as text, one row a reading."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(zip(*(c.tolist() for c in self.columns().values()), strict=True))
        return out.getvalue()

    def to_toml(self) -> str:
        """The case file."""
        parts = []
        for section, table in self.case.items():
            lines = [f"{key} = {json.dumps(value)}" for key, value in table.items()]
            parts.append("\n".join([f"[{section}]", *lines]))
        return "\n\n".join(parts) + "\n"

    def write(self, folder: Path, name: str) -> None:
        """name.toml, name.csv and name.truth.json."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.toml").write_text(self.to_toml())
        (folder / f"{name}.csv").write_text(self.to_csv())
        (folder / f"{name}.truth.json").write_text(json.dumps(self.truth, indent=1) + "\n")
