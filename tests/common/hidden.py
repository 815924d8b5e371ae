"""The development sets of the diagnosis: case, table, what was hidden, what tests ask of it."""

from __future__ import annotations

import csv
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.selection.decision import Verdict

FOLDER = Path(__file__).parents[1] / "data" / "hidden_effect"
TRUTH: dict[str, dict[str, Any]] = json.loads((FOLDER / "truth.json").read_text(encoding="utf-8"))
ANGLE, U = "elastic_angle_arcsec", "u_elastic_angle_arcsec"
Columns = dict[str, NDArray[np.float64]]
Said = tuple[str, tuple[str, ...], tuple[tuple[str, ...], ...]]


def case_of(name: str) -> str:
    """The case file as text."""
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def table_of(name: str) -> Columns:
    """The table as columns."""
    with (FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {column: np.array([float(row[column]) for row in rows]) for column in rows[0]}


@cache
def diagnosed(name: str) -> Diagnosis:
    """The diagnosis of a set, made once."""
    return diagnose(FOLDER / f"{name}.toml", FOLDER / f"{name}.csv")


def said(verdict: Verdict) -> Said:
    """What a verdict states, in an order of its own."""
    groups = sorted(tuple(sorted(g)) for g in verdict.rivals)
    return verdict.kind, tuple(sorted(verdict.effects)), tuple(groups)
