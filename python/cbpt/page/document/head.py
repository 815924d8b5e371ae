"""The head of the page: what was measured, on what, by whom.

head_of     of a case and its readings
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator

import numpy as np

from cbpt._core import Case, Drive
from cbpt.lab.readings.reader import Readings
from cbpt.page.document.source import Source
from cbpt.page.document.types import Head

_MOST = 6
"""Values of a column that are told one by one."""


def head_of(case: Case | Drive, readings: Readings, source: Source) -> Head:
    """What the files say, and what nobody but their author knows."""
    drive = case if isinstance(case, Drive) else case.drive
    return {
        "drive": _drive(drive),
        "measured": ", ".join(_measured(readings)),
        "rig": source.told.rig,
        "author": source.told.author,
        "date": source.told.date,
    }


def _drive(drive: Drive) -> str:
    numbers = tomllib.loads(drive.to_toml())
    if drive.kind != "ball_drive":
        return "reducer as a torsion spring"
    second = numbers["equal_speed"]
    return (
        f"ball reducer, {numbers['deceleration']['ball_count']} balls in the deceleration pair, "
        f"{second['ball_count']} in the equal-speed pair ({second['kind'].replace('_', ' ')})"
    )


def _measured(r: Readings) -> Iterator[str]:
    runs = len(np.unique(r.run_index))
    yield f"{len(r)} readings in {runs} run{'s' * (runs != 1)}"
    columns = (
        ("torque", r.torque_Nm, "N m"),
        ("preload", r.preload_N, "N"),
        ("input angle", r.input_angle_deg, "deg"),
        ("temperature", r.temperature_degC, "degC"),
    )
    for name, values, unit in columns:
        if values is None or not np.isfinite(values).any():
            continue
        found = np.unique(values[np.isfinite(values)])
        if len(found) <= _MOST and name != "torque":
            yield f"{name} {', '.join(f'{v:g}' for v in found)} {unit}"
        else:
            yield f"{name} {found[0]:.4g} to {found[-1]:.4g} {unit}"
