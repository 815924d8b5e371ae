"""Campaigns with a known truth, and readings made from the model itself."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt import Comparison, compare, solve_many
from cbpt.lab.diagnosis.misfit import Group

EXAMPLES = Path(__file__).parents[2] / "examples"

CAMPAIGNS = Path(__file__).parents[1] / "data" / "hidden_effect"
TRUTH: dict[str, Any] = json.loads((CAMPAIGNS / "truth.json").read_text())
EVERY = pytest.mark.parametrize("name", sorted(TRUTH))
UNLIKE = pytest.mark.parametrize("name", ["dev01", "dev07", "dev11"])
"""For what holds of any table: nothing hidden, eight input angles, nine readings of one run."""
ARCSEC = np.pi / 648000

Floats = NDArray[np.float64]
Columns = dict[str, Any]


@cache
def compared(name: str) -> Comparison:
    return compare(CAMPAIGNS / f"{name}.toml", CAMPAIGNS / f"{name}.csv")


@cache
def drive_of(name: str) -> cbpt.Drive:
    return cbpt.Drive.from_file(CAMPAIGNS / f"{name}.toml")


def columns_of(name: str) -> Columns:
    """The table, read by numpy alone."""
    path = CAMPAIGNS / f"{name}.csv"
    headers = path.read_text().splitlines()[0].split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return dict(zip(headers, table.T.copy(), strict=True))


def case_of(name: str, more: str) -> cbpt.Case:
    return cbpt.Case.from_toml((CAMPAIGNS / f"{name}.toml").read_text() + more)


def base() -> cbpt.Drive:
    return cbpt.Drive.from_toml(cbpt.example_case())


def model(drive: cbpt.Drive, columns: Columns) -> Floats:
    found = solve_many(
        drive, columns["torque_Nm"], columns["preload_N"], columns["input_angle_deg"]
    )
    return found.elastic_angle_arcsec


def adequate(c: Comparison) -> bool:
    assert c.overall is not None and c.overall.chi2_per_dof is not None and c.p_value is not None
    near_one = 0.75 < c.overall.chi2_per_dof < 1.3
    assert near_one or c.p_value < 0.01
    return c.p_value >= 0.01


def by(c: Comparison, column: str) -> dict[str, Group]:
    return {group.label: group for group in c.groups if group.column == column}


def excess(group: Group) -> float:
    return group.misfit.excess_arcsec


def synthetic(
    drive: cbpt.Drive, offset: float = 0.0, gain: float = 1.0, torque: Any = None
) -> Columns:
    """Readings that are the model, but for a known offset and gain."""
    levels = np.linspace(-8, 8, 17) if torque is None else np.asarray(torque, dtype=float)
    m0, preload = (a.ravel() for a in np.meshgrid(levels, [400.0, 800.0], indexing="ij"))
    columns: Columns = {
        "torque_Nm": m0,
        "preload_N": preload,
        "input_angle_deg": np.full(m0.size, 12.0),
    }
    columns["elastic_angle_arcsec"] = gain * model(drive, columns) + offset
    columns["u_elastic_angle_arcsec"] = np.full(m0.size, 0.5)
    return columns


def strictly(text: str) -> Any:
    """JSON as every reader takes it: NaN and Infinity are none."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)
