"""Friction, safety and vibration by name: in solve, sweeps, sensitivities, tolerances and bounds.

One drive and load has one number of each name, whoever tells it.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cbpt

NAMES = [
    "friction_torque_Nm",
    "efficiency",
    "wear_Nm_per_turn",
    "static_safety",
    "natural_frequency_Hz",
]
INERTIA_KG_M2 = 2e-3
TEXT = cbpt.example_case() + f"\n[operation]\noutput_inertia_kg_m2 = {INERTIA_KG_M2}\n"
CASE = cbpt.Case.from_toml(TEXT)


def expected(torque: float, preload: float, angle: float) -> list[float]:
    """From what other routines of the product say."""
    solution, friction = (
        CASE.drive.solve(torque, preload, angle),
        CASE.drive.friction(torque, preload, angle),
    )
    assert solution.deceleration and solution.equal_speed
    assert friction.deceleration and friction.equal_speed
    assert friction.friction_torque_Nm is not None and friction.efficiency is not None
    assert solution.torsional_stiffness_Nm_per_rad is not None
    pairs = solution.deceleration, solution.equal_speed
    pressure = max(pair.largest_peak_pressure_Pa for pair in pairs)
    return [
        friction.friction_torque_Nm,
        friction.efficiency,
        friction.deceleration.wear_Nm_per_turn + friction.equal_speed.wear_Nm_per_turn,
        (4.2e9 / pressure) ** 3,
        float(np.sqrt(solution.torsional_stiffness_Nm_per_rad / INERTIA_KG_M2) / (2 * np.pi)),
    ]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "cbpt.cli.main", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "drive.toml"
    path.write_text(TEXT)
    return path


def test_solve_tells_them(case: Path) -> None:
    found = run("solve", str(case), "--input-angle-deg", "20", "--friction", "--json")
    assert found.returncode == 0, found.stderr
    block = json.loads(found.stdout)["friction"]
    assert block.pop("coefficient") == 0.1
    assert list(block) == NAMES
    assert list(block.values()) == pytest.approx(expected(5, 600, 20), rel=1e-12)
    without = json.loads(run("solve", str(case), "--json").stdout)
    assert "friction" not in without


def test_a_sweep_has_the_columns_that_it_names(tmp_path: Path) -> None:
    torque, preload = [0.0, 3.0], [5.0, 600.0, 900.0]
    axes = {"load.torque_Nm": torque, "load.preload_N": preload, "load.input_angle_deg": 20}
    found = cbpt.sweep(CASE, axes, columns=NAMES)
    table = found.to_pandas()
    for _, row in table.iterrows():
        told = [row[name] for name in NAMES]
        if row["status"] == "ok":
            load = row["load.torque_Nm"], row["load.preload_N"], 20.0
            assert told == pytest.approx(expected(*load), rel=1e-12)
        else:
            assert np.isnan(told).all()
    assert set(table["status"]) == {"ok", "beyond_hold"}
    data = found.to_xarray()
    assert data.friction_torque_Nm.attrs["units"] == "N m"
    for name in ("rows.csv", "rows.parquet"):
        path = tmp_path / name
        cbpt.sweep(CASE, axes, columns=NAMES[::-1], out=path)
        again = cbpt.sweep(CASE, axes, columns=NAMES[::-1], out=path).to_pandas()
        for column in NAMES:
            assert again[column].to_numpy() == pytest.approx(
                table[column].to_numpy(), rel=1e-12, nan_ok=True
            )


def test_a_sweep_of_drives_has_the_columns_of_each() -> None:
    axes = {"deceleration.ball_radius_mm": [1.4, 1.5], "load.torque_Nm": [1.0, 5.0]}
    found = cbpt.sweep(CASE, {**axes, "load.preload_N": 600}, columns=["friction_torque_Nm"])
    own = found.to_pandas()
    row = own[(own["deceleration.ball_radius_mm"] == 1.5) & (own["load.torque_Nm"] == 5.0)]
    assert row["friction_torque_Nm"].tolist() == pytest.approx(expected(5, 600, 0)[:1], rel=1e-9)
    assert own["friction_torque_Nm"].nunique() == 4


def test_plans_and_flags_name_columns(case: Path, tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'case = "drive.toml"\ncolumns = ["efficiency"]\n[axes]\nload.torque_Nm = [1, 5]\n'
    )
    out = tmp_path / "rows.csv"
    assert run("sweep", str(plan), "--out", str(out)).returncode == 0
    head, _, last = out.read_text().splitlines()
    place = head.split(",").index("efficiency")
    assert float(last.split(",")[place]) == pytest.approx(expected(5, 600, 0)[1], rel=1e-12)
    flags = run("sweep", str(case), "--torque-Nm", "5", "--columns", "efficiency", "--json")
    assert json.loads(flags.stdout)["efficiency"] == [float(last.split(",")[place])]
    # Another set of columns is another plan.
    plan.write_text(plan.read_text().replace('"efficiency"', '"static_safety"'))
    other = run("sweep", str(plan), "--out", str(out))
    assert other.returncode == 2 and "columns" in other.stderr


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        (["eficiency"], "efficiency"),
        (["efficiency", "efficiency"], "each once"),
        (["natural_frequency_Hz"], r"output_inertia under \[operation\]"),
    ],
)
def test_columns_that_cannot_be_are_told(columns: list[str], told: str) -> None:
    case = cbpt.Case.from_toml(cbpt.example_case())
    with pytest.raises(cbpt.PlanError, match=told):
        cbpt.sweep(case, {"load.torque_Nm": [1.0]}, columns=columns)


def test_sensitivities_are_those_of_larger_differences() -> None:
    """A step of 0.1 % by other routines, within what the curvature leaves."""
    found = CASE.drive.sensitivities(
        5, 600, 20, coefficient=0.1, output_inertia_kg_m2=INERTIA_KG_M2
    )
    low, high = expected(5, 600 * 0.999, 20), expected(5, 600 * 1.001, 20)
    for name, below, above in zip(NAMES, low, high, strict=True):
        answer = found.results[name]
        assert answer is not None
        assert answer.slopes["load.preload_N"] == pytest.approx((above - below) / 1.2, rel=1e-3)
        assert "load.preload_N" not in answer.one_sided
    plain = CASE.drive.sensitivities(5, 600, 20)
    assert not set(NAMES) & set(plain.results)


def test_tolerances_scatter_them() -> None:
    case = cbpt.Case.from_toml(TEXT + "\n[tolerance]\nload_preload_N = 60\n")
    found = cbpt.tolerance(case, samples=400, friction=True)
    ends = expected(5, 540, 0), expected(5, 660, 0)
    for place, name in enumerate(NAMES):
        spread = found.friction[name]
        assert spread.nominal == pytest.approx(expected(5, 600, 0)[place], rel=1e-12)
        low, high = sorted(end[place] for end in ends)
        assert low <= spread.quantiles[0.025] < spread.quantiles[0.975] <= high
        # Even within its limits, and nearly straight.
        assert spread.sd == pytest.approx((high - low) / np.sqrt(12), rel=0.1)
    assert list(found.to_dict()["friction"]) == NAMES
    assert "friction" not in cbpt.tolerance(case, samples=50).to_dict()


def test_a_natural_frequency_bounds_the_preload() -> None:
    """Stiffness rises with the preload, friction torque too, so the limit is where it ends."""
    at_700 = expected(5, 700, 0)[-1]
    bounds = {
        "free": {"load.preload_N": [200, 2000]},
        "limits": {"natural_frequency_Hz": at_700},
    }
    best = cbpt.optimise(CASE, bounds, objective="friction_torque")
    assert best.found and best.case.preload_N == pytest.approx(700, rel=1e-4)
    assert any("natural_frequency_Hz" in bound for bound in best.binds)
    without = cbpt.Case.from_toml(cbpt.example_case())
    with pytest.raises(cbpt.InvalidInputError, match=r"output_inertia under \[operation\]"):
        cbpt.optimise(without, bounds)
