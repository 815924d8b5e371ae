"""Friction, wear and safety as limits and objectives of a search, and as an answer of their own.

Groups: searches against grids of all designs, limits that cannot be, the answer `Costs`, maps.
"""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt.design.judge import at_load, judge
from common.drives import base_case

# --- searches -----------------------------------------------------------------------------


def test_a_limit_on_friction_ends_the_search_inside_its_bounds() -> None:
    bounds = {
        "free": {"load.preload_N": [200, 4000]},
        "limits": {"friction_torque_Nm": 0.15, "preload": "continuous"},
    }
    best = cbpt.optimise(base_case(), bounds)
    grid = np.arange(200.0, 4001.0)
    found = judge(at_load(base_case()), ["load.preload_N"], grid[:, None], coefficient=0.1)
    angle = np.where(found["friction_torque_Nm"] <= 0.15, found["elastic_angle_rad"], np.inf)
    assert best.found and best.binds == ("friction_torque_Nm 0.15",)
    assert best.case.preload_N == pytest.approx(grid[np.argmin(angle)], abs=1)
    assert best.friction["friction_torque_Nm"] == pytest.approx(0.15, rel=1e-5)
    assert "at this input angle: 0.15 N m" in best.report()


@pytest.mark.parametrize("objective", ["friction_torque", "wear"])
def test_the_least_friction_lies_at_the_least_preload_that_is_allowed(objective: str) -> None:
    bounds = {
        "free": {"load.preload_N": [200, 4000], "deceleration.contact_angle_deg": [35, 55]},
        "limits": {"static_safety": 2, "efficiency": 0.5},
    }
    best = cbpt.optimise(base_case(), bounds, objective=objective)
    assert best.found and best.objective == objective
    assert best.case.preload_N == pytest.approx(200, rel=1e-6)
    before, after = (best.friction[f"friction_torque_Nm{end}"] for end in ("_before", ""))
    assert before is not None and after is not None and after < before


def test_an_objective_that_is_not_known_is_told() -> None:
    bounds = {"free": {"load.preload_N": [200, 4000]}}
    with pytest.raises(cbpt.InvalidInputError, match="friction_torque"):
        cbpt.optimise(base_case(), bounds, objective="colour")


# --- the answer ---------------------------------------------------------------------------


def test_costs_of_the_base_case(tmp_path: Path) -> None:
    case = base_case() | {
        "operation": {
            "input_speed_rpm": 300,
            "output_inertia_kg_cm2": 50,
            "planet_mass_g": 250,
            "static_safety": 1.5,
        }
    }
    found = cbpt.friction(case)
    drive = cbpt.Drive.from_dict(base_case())
    alone = drive.friction(5, 600)
    assert found.friction_torque_Nm == alone.friction_torque_Nm
    assert found.efficiency == alone.efficiency
    document = json.loads(found.to_json())
    assert document["heat_W"] == pytest.approx(alone.heat_W(300), rel=1e-12)
    assert document["drive"]["friction_torque_u_Nm"] == pytest.approx(
        alone.with_coefficient(0.03), rel=1e-12
    )
    stiffness = drive.solve(5, 600).torsional_stiffness_Nm_per_rad
    assert stiffness is not None
    frequency = math.sqrt(stiffness / 0.005) / (2 * math.pi)
    assert document["natural_frequency_Hz"] == pytest.approx(frequency, rel=1e-12)
    # 0.25 kg at 2 e = 4 mm and 10 pi rad/s.
    assert document["unbalance_kg_m"] == pytest.approx(1e-3, rel=1e-12)
    assert document["unbalance_force_N"] == pytest.approx(1e-3 * (10 * math.pi) ** 2, rel=1e-12)
    found.plot(tmp_path / "window.svg")
    assert (tmp_path / "window.svg").stat().st_size > 1000


def test_largest_torque_and_window_meet_the_safety_they_are_for() -> None:
    found = cbpt.friction(base_case(), static_safety=2.5)
    assert found.preload_window_N is not None and found.largest_torque_Nm is not None
    least, largest = found.preload_window_N
    needed = cbpt.Drive.from_dict(base_case()).preload(5).drive
    assert least == pytest.approx(needed.continuous_N, rel=1e-9)
    at_end = cbpt.friction(base_case(), preload_N=largest).static_safety
    assert at_end == pytest.approx(2.5, rel=1e-6)
    at_most = cbpt.friction(base_case(), torque_Nm=found.largest_torque_Nm).static_safety
    assert at_most == pytest.approx(2.5, rel=1e-6)
    assert found.static_safety > 2.5


def test_a_safety_that_no_preload_meets_leaves_no_window() -> None:
    found = cbpt.friction(base_case(), static_safety=1e4)
    assert found.preload_window_N is None and found.largest_torque_Nm is None
    assert "none" in found.report()


def test_a_load_that_slips_has_no_friction() -> None:
    found = cbpt.friction(base_case(), preload_N=5)
    assert not found.has_solution and found.efficiency is None
    assert found.document["status"] == "beyond_hold" and found.static_safety == 0
    json.loads(found.to_json())


def test_a_torsion_spring_has_no_contacts() -> None:
    spring = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 5}}
    with pytest.raises(cbpt.InvalidInputError, match="ball drive"):
        cbpt.friction(spring, torque_Nm=1, preload_N=1)


def test_the_table_of_pairs_has_the_numbers_of_the_document() -> None:
    found = cbpt.friction(base_case())
    rows = {row.pop("pair"): row for row in csv.DictReader(io.StringIO(found.to_csv()))}
    assert list(rows) == ["deceleration", "equal_speed", "drive"]
    for name, row in rows.items():
        track = float(row.pop("track_wear_Nm_per_mm"))
        assert {key: found.document[name][key] for key in row} == {
            k: float(v) for k, v in row.items()
        }
        pairs = ("deceleration", "equal_speed") if name == "drive" else (name,)
        assert track == max(max(found.document[pair]["track_wear_Nm_per_mm"]) for pair in pairs)
    assert cbpt.friction(base_case(), preload_N=5).to_csv().count("\n") == 1


# --- maps ---------------------------------------------------------------------------------


def test_a_map_has_the_numbers_of_single_loads_and_tells_its_progress() -> None:
    told: list[tuple[int, int]] = []
    torque, preload = np.array([[0.0], [5.0], [50.0]]), np.array([300.0, 600.0])
    found = cbpt.friction_map(
        base_case(), torque, preload, progress=lambda done, of: told.append((done, of))
    )
    assert found.efficiency.shape == (3, 2)
    drive = cbpt.Drive.from_dict(base_case())
    for i in range(2):
        for j in range(2):
            single = drive.friction(float(torque[i, 0]), float(preload[j]))
            assert found.friction_torque_Nm[i, j] == single.friction_torque_Nm
            assert found.wear_Nm_per_turn[i, j] == single.wear_Nm_per_turn
    assert list(found.status[2]) == ["beyond_hold"] * 2 and np.isnan(found.efficiency[2]).all()
    assert all(done <= of == 6 for done, of in told)


def test_effects_that_are_left_out_are_told() -> None:
    effects: list[tuple[str, dict[str, float]]] = [("eccentric_bearing", {})]
    case = cbpt.Case.from_dict(base_case()).with_effects(effects)
    found = cbpt.friction(case)
    assert "without the effects of the case: eccentric_bearing" in found.report()
    assert found.to_dict()["effects_not_counted"] == ["eccentric_bearing"]
    assert cbpt.friction_map(case, 5, 600).effects_not_counted == ("eccentric_bearing",)
    assert cbpt.friction_map(base_case(), 5, 600).effects_not_counted == ()
