"""Write the case and the tables of docs/tutorial.md into examples/tutorial.

Run from the folder tests: `python -m reference.make_tutorial`. The drive really has friction and a
ball bearing on its eccentric that gives; contacts and gauges are off by less than is stated. All of
it is made by the rig, which shares no code with the product.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from reference.rig import ARCSEC, Rows, drive_of, simulate
from reference.rig.effects import hidden

FOLDER = Path(__file__).parents[2] / "examples" / "tutorial"
U_ARCSEC = 0.3
PAUSE_S, DWELL_S = 120.0, 5.0

CASE: dict[str, dict[str, Any]] = {
    "material": {"youngs_modulus_GPa": 208.0, "poissons_ratio": 0.3},
    "deceleration": {
        "ball_count": 18,
        "short_amplitude_coefficient": 0.45,
        "rolling_circle_radius_mm": 3.2,
        "ball_radius_mm": 1.5,
        "groove_conformity": 1.06,
        "contact_angle_deg": 45.0,
    },
    "equal_speed": {
        "kind": "ring_groove",
        "ball_count": 14,
        "pitch_radius_mm": 38.0,
        "ball_radius_mm": 1.5,
        "groove_conformity": 1.06,
        "contact_angle_deg": 45.0,
    },
}
HIDDEN = [
    hidden("friction_hysteresis", mu_T_m=300e-6, length_rad=4 * ARCSEC),
    hidden("eccentric_bearing", u_ref_m=0.4e-6, exponent=2 / 3),
    hidden("contact_stiffness", scale=0.95),
    hidden("torque_scale", gain=1.006),
    hidden("preload_scale", gain=0.99),
]

Run = tuple[float, float, Sequence[float]]
"""Preload (N), input angle (deg) and torques (N m)."""


def loop(peak_Nm: float, steps: int) -> list[float]:
    """Up, down through zero to the other side, and back."""
    up = [peak_Nm * i / steps for i in range(steps + 1)]
    half = up + up[-2::-1]
    return [round(t, 6) for t in half + [-t for t in half[1:]]]


@dataclass(frozen=True)
class Table:
    """Runs measured one after the other."""

    first_run: int
    seed: int
    runs: list[Run]


TABLES = {
    "first": Table(1, 5, [(500, 0, loop(9, 6))]),
    # The run that `cbpt next-run` asks for after the first, and one at the end of the range.
    "second": Table(
        2,
        1005,
        [
            (400, 0, [0, 1.36, 2.72, 4.08, 5.44, 2.72, 0, -1.36, -2.72, -4.08, -5.44, -2.72, 0]),
            (1200, 120, loop(20, 4)),
        ],
    ),
    "unseen": Table(
        4, 2005, [(450, 40, loop(7, 5)), (700, 160, loop(12, 6)), (1000, 280, loop(16, 6))]
    ),
}


def rows_of(first_run: int, runs: Sequence[Run]) -> Rows:
    """Runs one after the other."""
    lengths = [len(torques) for _, _, torques in runs]
    number = np.repeat(np.arange(len(runs)), lengths)
    step = np.arange(len(number))
    return Rows(
        run=first_run + number,
        time_s=DWELL_S * step + PAUSE_S * number,
        torque_Nm=np.array([t for _, _, torques in runs for t in torques], dtype=float),
        preload_N=np.repeat([float(preload) for preload, _, _ in runs], lengths),
        input_angle_rad=np.deg2rad(np.repeat([angle for _, angle, _ in runs], lengths)),
        temperature_degC=np.full(len(number), 20.0),
        cycle=np.ones(len(number), dtype=int),
    )


def text_of(table: Table) -> str:
    """The readings of a table as CSV."""
    rows = rows_of(table.first_run, table.runs)
    noise = U_ARCSEC * np.random.default_rng(table.seed).standard_normal(len(rows))
    read = simulate(drive_of(CASE), rows, HIDDEN) / ARCSEC + noise
    columns = {
        "run": rows.run,
        "time_s": rows.time_s,
        "torque_Nm": rows.torque_Nm,
        "preload_N": rows.preload_N,
        "input_angle_deg": np.rad2deg(rows.input_angle_rad).round(6),
        "elastic_angle_arcsec": read.round(2),
        "u_elastic_angle_arcsec": np.full(len(rows), U_ARCSEC),
    }
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(c.tolist() for c in columns.values()), strict=True))
    return out.getvalue()


def files() -> dict[str, str]:
    """What stands in the folder, by name."""
    sections = [
        "\n".join(
            [f"[{name}]", *(f"{key} = {value!r}".replace("'", '"') for key, value in keys.items())]
        )
        for name, keys in CASE.items()
    ]
    made = {f"{name}.csv": text_of(table) for name, table in TABLES.items()}
    return {"drive.toml": "\n\n".join(sections) + "\n", **made}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in files().items():
        (FOLDER / name).write_text(text, encoding="utf-8", newline="\n")
