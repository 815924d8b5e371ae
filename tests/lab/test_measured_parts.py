"""A diagnosis begins from what was measured of the parts, so that it is not missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cbpt
from common import mostly_long

TOP = Path(__file__).parents[2]
BASE = (TOP / "examples" / "base_case.toml").read_text(encoding="utf-8")
BASE_CASE = cbpt.Case.from_toml(BASE)


def measured(folder: Path) -> cbpt.Case:
    """The base case with an uneven groove and uneven balls, as tables beside the case."""
    t = np.arange(0.0, 360.0, 2.0)
    deviation = 4.0 * np.cos(3 * np.deg2rad(t) + 0.4) + 1.5 * np.sin(7 * np.deg2rad(t))
    rows = [f"{angle:g},{value:.4f}" for angle, value in zip(t, deviation, strict=True)]
    head = "groove_angle_deg,deviation_um\n"
    (folder / "groove.csv").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    sizes = 3.0 + 1e-3 * np.random.default_rng(4).normal(0.0, 0.5, 20)
    rows = [f"{ball},{size:.6f}" for ball, size in enumerate(sizes)]
    (folder / "balls.csv").write_text("ball,diameter_mm\n" + "\n".join(rows) + "\n")
    made = 'epicycloid_profile = "groove.csv"\ndeceleration_balls = "balls.csv"\n'
    (folder / "case.toml").write_text(f"{BASE}\n[as_made]\n{made}", encoding="utf-8")
    return cbpt.Case.from_file(folder / "case.toml")


def campaign(case: cbpt.Case) -> cbpt.Readings:
    """Loops at eight places of the crank."""
    one = np.concatenate([np.linspace(-5, 5, 11), np.linspace(5, -5, 11)])
    angles = [0.0, 35.0, 80.0, 140.0, 200.0, 250.0, 305.0, 400.0]
    plan = {
        "run": np.repeat(np.arange(len(angles)), len(one)),
        "torque_Nm": np.tile(one, len(angles)),
        "preload_N": np.full(len(angles) * len(one), 600.0),
        "input_angle_deg": np.repeat(angles, len(one)),
    }
    return cbpt.simulate(case, plan, u_elastic_angle_arcsec=0.05, seed=1)


@pytest.mark.parametrize("tables", mostly_long([True, False], [True]))
def test_what_was_measured_of_the_parts_is_not_missing(tmp_path: Path, tables: bool) -> None:
    case = measured(tmp_path)
    readings = campaign(case)
    given = case if tables else BASE_CASE
    without = cbpt.compare(BASE_CASE, readings).overall
    assert without is not None and without.rmse_arcsec > 0.15, "three standard uncertainties"
    found = cbpt.diagnose(given, readings)
    assert (found.verdict.kind == "complete") == tables, found.sentence
    assert found.sentence.startswith("No effect is missing") == tables
