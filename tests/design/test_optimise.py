"""The search for the smallest elastic angle: against a grid, a known answer, and what cannot be."""

from __future__ import annotations

import itertools
import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.cli.main import main
from cbpt.design.judge import at_load, judge
from common import mostly_long

TOP = Path(__file__).parents[2]
BASE = TOP / "examples/base_case.toml"

TWO: dict[str, Any] = {
    "free": {
        "deceleration": {"short_amplitude_coefficient": [0.3, 0.65], "ball_radius_mm": [0.8, 2.5]},
    },
    "limits": {"outer_radius_mm": 84.0, "undercut_margin": 0.35, "contact_pressure_GPa": 2.4},
}


def test_the_optimum_is_no_worse_than_a_grid_and_close_to_it() -> None:
    case = at_load(cbpt.Case.from_file(BASE))
    found = cbpt.optimise(case, TWO)
    assert found.found and found.after_arcsec is not None
    k, r = np.linspace(0.3, 0.65, 141), np.linspace(0.8e-3, 2.5e-3, 171)
    rows = np.array(list(itertools.product(k, r)))
    names = ["deceleration.short_amplitude_coefficient", "deceleration.ball_radius_m"]
    judged = judge(case, names, rows, pressures=True)
    # The limits as they are stated, written out once more.
    kept = (
        (judged.status == "ok")
        & (judged["outer_radius_m"] <= 84e-3)
        & (judged["undercut_margin"] >= 0.35)
        & (judged["inside_wall_margin"] >= 0)
        & (judged["deceleration_pressure_Pa"] <= 2.4e9)
        & (judged["equal_speed_pressure_Pa"] <= 2.4e9)
        & (judged["deceleration_ball_clearance_m"] >= 0)
        & (judged["ring_clearance_m"] >= 0)
    )
    assert 0 < kept.sum() < len(rows)
    best = cbpt.results.ARCSEC_PER_RAD * judged["elastic_angle_rad"][kept].min()
    assert found.after_arcsec <= best
    assert found.after_arcsec == pytest.approx(best, rel=0.01)
    # It keeps its limits, judged anew, and is what its own case says.
    assert all(margin >= 0 for margin in found.margins.values())
    again = found.case.drive.solve(5, 600).elastic_angle_arcsec
    assert again == pytest.approx(found.after_arcsec, rel=1e-9)
    assert found.binds and found.before_arcsec == pytest.approx(12.4605, abs=1e-4)


def test_whole_numbers_against_every_choice_of_them() -> None:
    case = at_load(cbpt.Case.from_file(BASE))
    free = {"equal_speed": {"ball_count": [6, 40], "pitch_radius_mm": [30, 42]}}
    limits = {"ring_clearance_mm": 1.0, "outer_radius_mm": 90.0}
    found = cbpt.optimise(case, {"free": free, "limits": limits})
    rows = np.array(list(itertools.product(range(6, 41), np.linspace(30e-3, 42e-3, 61))))
    judged = judge(case, ["equal_speed.ball_count", "equal_speed.pitch_radius_m"], rows)
    kept = (judged["ring_clearance_m"] >= 1e-3) & (judged.status == "ok")
    best = cbpt.results.ARCSEC_PER_RAD * judged["elastic_angle_rad"][kept].min()
    assert found.after_arcsec is not None and found.after_arcsec <= best * (1 + 1e-9)
    count = found.numbers["equal_speed.ball_count"][1]
    assert count == round(count) == rows[kept][judged["elastic_angle_rad"][kept].argmin()][0]


def test_one_number_with_a_known_answer() -> None:
    """More preload, a smaller angle: the pressure, which grows with its cube root where nothing
    else acts, sets the end; the pressure at the found preload is the limit."""
    free = {"load": {"preload_N": [100, 3000]}}
    found = cbpt.optimise(BASE, {"free": free, "limits": {"contact_pressure_GPa": 2.8}})
    preload = found.numbers["load.preload_N"][1]
    solution = found.case.drive.solve(5, preload)
    assert solution.deceleration and solution.equal_speed
    pressures = solution.deceleration.peak_pressure_Pa, solution.equal_speed.peak_pressure_Pa
    highest = max(np.max(p) for p in pressures)
    assert highest == pytest.approx(2.8e9, rel=1e-6) and highest <= 2.8e9
    assert found.binds == ("contact_pressure_GPa 2.8",)
    # Without a limit, its own greatest value.
    found = cbpt.optimise(BASE, {"free": free})
    assert found.numbers["load.preload_N"][1] == pytest.approx(3000, rel=1e-6)
    assert found.binds == ("load.preload_N (greatest)",)


def test_the_threshold_is_kept() -> None:
    """The contact angle alone: a flat one is stiff in the plane but needs the more preload... the
    steep one the reverse; continuous transmission sets an end."""
    free = {"equal_speed": {"pitch_radius_mm": [5, 60]}}
    limits = {"preload": "zero_backlash", "inside_wall_margin": -9, "ring_clearance_mm": -99}
    limits |= {"ball_clearance_mm": -99}
    case = at_load(cbpt.Case.from_file(BASE), preload_N=220)
    found = cbpt.optimise(case, {"free": free, "limits": limits})
    assert found.found
    needed = found.case.drive.preload(5).drive.zero_backlash_N
    assert needed <= 220


def test_the_same_seed_gives_the_same_design() -> None:
    one, two = (cbpt.optimise(BASE, TWO, seed=3) for _ in range(2))
    assert one.to_dict() == two.to_dict()
    assert cbpt.optimise(BASE, TWO, seed=4).after_arcsec == pytest.approx(
        one.after_arcsec, rel=1e-4
    )


def test_a_design_without_solution_never_wins() -> None:
    """Where undercut and slipping begin the equations know no angle; the search stays clear."""
    free = {
        "deceleration": {"short_amplitude_coefficient": [0.2, 0.95], "ball_radius_mm": [0.5, 12]},
        "load": {"preload_N": [50, 200]},
    }
    found = cbpt.optimise(BASE, {"free": free, "limits": {"inside_wall_margin": -99}})
    assert found.found and found.after_arcsec is not None
    preload = found.numbers["load.preload_N"][1]
    assert found.case.drive.solve(5, preload).status == "ok"


@pytest.mark.parametrize("seed", mostly_long([0, 1], [0]))
def test_a_missing_wall_is_no_way_to_the_bounds(seed: int) -> None:
    """Just beyond the edge of a wall pressures are low, so a search that counts by how much a limit
    is missed ends there; designs that keep the bounds lie far away."""
    bounds = tomllib.loads((TOP / "examples/bounds.toml").read_text())
    bounds["limits"]["contact_pressure_GPa"] = 1.8
    found = cbpt.optimise(BASE, bounds, seed=seed)
    assert found.found and found.after_arcsec is not None and found.after_arcsec < 9
    assert "equal_speed.ball_count (greatest)" in found.binds


def test_effects_that_are_not_counted_are_told(capfd: pytest.CaptureFixture[str]) -> None:
    effects: list[tuple[str, dict[str, float]]] = [("eccentric_bearing", {})]
    case = cbpt.Case.from_file(BASE).with_effects(effects)
    found = cbpt.optimise(case, {"free": {"load": {"preload_N": [500, 600]}}})
    assert found.to_dict()["not_counted"] == ["eccentric_bearing"]
    assert "without the effects of the case: eccentric_bearing" in found.report()
    plain = cbpt.optimise(BASE, {"free": {"load": {"preload_N": [500, 600]}}})
    assert plain.to_dict()["not_counted"] == [] and "without the effects" not in plain.report()


def test_tables_of_the_parts_are_left_out_and_told() -> None:
    made = TOP / "examples/as_made/drive.toml"
    bounds = {"free": {"load": {"preload_N": [500, 600]}}}
    found = cbpt.optimise(made, bounds)
    front = cbpt.pareto_front(made, bounds, points=2)
    nominal = cbpt.optimise(cbpt.Case.from_file(made).nominal(), bounds)
    for answer in (found, front):
        assert answer.to_dict()["not_counted"] == ["as_made"]
        assert "nominal parts, without [as_made]" in answer.report()
    assert found.after_arcsec == nominal.after_arcsec
    assert nominal.to_dict()["not_counted"] == [] and "[as_made]" not in nominal.report()


def test_what_cannot_be_is_told_with_the_nearest(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bounds = tmp_path / "bounds.toml"
    bounds.write_text(
        "[free]\ndeceleration.rolling_circle_radius_mm = [3, 5]\n[limits]\nouter_radius_mm = 40\n"
    )
    out = tmp_path / "best.toml"
    assert main(["optimise", str(BASE), str(bounds), "--out", str(out)]) == 3
    said = capfd.readouterr().out
    assert "No design meets the limits" in said and "outer_radius_mm" in said
    assert not out.exists()
    assert main(["optimise", str(BASE), str(bounds), "--json"]) == 3
    document = json.loads(capfd.readouterr().out)
    assert not document["found"] and document["violated"] and not document["binds"]
    # The nearest has the smallest circle that is allowed.
    nearest = document["numbers"]["deceleration.rolling_circle_radius_mm"]["value"]
    assert nearest == pytest.approx(3, abs=1e-2)


def test_the_verb_writes_the_design(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    bounds, out = tmp_path / "bounds.toml", tmp_path / "best.toml"
    bounds.write_text("[free]\nload.preload_N = [300, 900]\nequal_speed.ball_radius_mm = [1, 2]\n")
    assert (
        main(["optimise", str(BASE), str(bounds), "--out", str(out), "--angle-unit", "urad"]) == 0
    )
    said = capfd.readouterr().out
    assert "Bounds reached: load.preload_N (greatest)" in said and "urad" in said
    assert main(["solve", str(out)]) == 0
    assert "900" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({}, "no parameter is free"),
        ({"free": {"deceleration": {"ball_radius": [1, 2]}}}, "needs a unit"),
        (
            {"free": {"deceleration": {"bal_radius_mm": [1, 2]}}},
            "did you mean deceleration.ball_radius_mm",
        ),
        ({"free": {"deceleration": {"ball_radius_mm": [2, 1]}}}, r"expected \[least, greatest\]"),
        ({"free": {"deceleration": {"ball_radius_mm": [-1, 1]}}}, "greater than 0"),
        ({"free": {"deceleration": {"ball_count": [10.5, 12]}}}, "whole number"),
        ({"free": {"deceleration": {"output_plate": [1, 2]}}}, "is no number of a design"),
        ({"free": {"measurement": {"lever_arm_mm": [1, 2]}}}, "does not change the elastic angle"),
        (
            {"free": {"load": {"preload_N": [1, 2]}}, "limits": {"outer_radius": 3}},
            "outer_radius_m",
        ),
        ({"free": {"load": {"preload_N": [1, 2]}}, "limits": {"preload": "some"}}, "zero_backlash"),
        ({"free": {"load": {"preload_N": [1, 2]}}, "limits": {"outer_radius_mm": "a"}}, "finite"),
        ({"freedom": {}}, "expected the tables"),
        ({"free": {"load": {"torque_Nm": [0, 5]}}}, "only load.preload_N can be free"),
        ({"free": {"load": {"input_angle_deg": [0, 5]}}}, "only load.preload_N can be free"),
        (
            {
                "free": {
                    "equal_speed": {
                        "contact_angle_deg": [40, 50],
                        "outside_contact_angle_deg": [40, 50],
                    }
                }
            },
            "frees this one too",
        ),
    ],
)
def test_bounds_that_cannot_be_are_refused(bounds: dict[str, Any], words: str) -> None:
    with pytest.raises(cbpt.InvalidInputError, match=words):
        cbpt.optimise(BASE, bounds)


def test_every_limit_that_is_violated_is_told() -> None:
    """A threshold too, which is not asked for in the search while another limit is violated."""
    bounds = {
        "free": {"load": {"preload_N": [100, 200]}, "equal_speed": {"pitch_radius_mm": [25, 30]}},
        "limits": {"preload": "zero_backlash", "contact_pressure_GPa": 1.0},
    }
    found = cbpt.optimise(BASE, bounds)
    assert not found.found
    assert [sentence.split()[0] for sentence in found.violated] == [
        "contact_pressure_GPa",
        "preload:",
    ]
    needed = found.case.drive.preload(5).drive.zero_backlash_N
    have = found.case.preload_N
    assert needed is not None and have is not None
    assert found.margins["preload_N"] == pytest.approx(have - needed)
    tight = {
        "free": {"equal_speed": {"pitch_radius_mm": [39, 60]}},
        "limits": {"preload": "zero_backlash", "contact_pressure_GPa": 1.95},
    }
    before = cbpt.optimise(BASE, tight, preload_N=150).violated_before
    assert [sentence.split()[0] for sentence in before] == ["contact_pressure_GPa", "preload:"]


def test_what_does_not_bear_on_a_violation_stays() -> None:
    bounds = {"free": {"load": {"preload_N": [100, 900]}}, "limits": {"outer_radius_mm": 50}}
    found = cbpt.optimise(BASE, bounds)
    assert not found.found and found.numbers["load.preload_N"] == (600.0, 600.0)


@pytest.mark.parametrize("greatest", [60, 70])
def test_a_case_may_start_on_its_bound(greatest: float) -> None:
    found = cbpt.optimise(BASE, {"free": {"equal_speed": {"pitch_radius_mm": [40, greatest]}}})
    assert found.found
    assert found.case.drive.to_toml() != cbpt.Case.from_file(BASE).drive.to_toml()


def test_the_outcome_is_told_over_a_period() -> None:
    found = cbpt.optimise(BASE, TWO)
    of = found.over_period
    drive, least = found.case.drive, of["elastic_angle_least_arcsec"]
    largest = drive.largest_elastic_angle(5, 600)
    assert largest is not None and least is not None and found.after_arcsec is not None
    assert of["elastic_angle_largest_arcsec"] == pytest.approx(
        largest.elastic_angle_arcsec, rel=0.01
    )
    assert least <= found.after_arcsec <= largest.elastic_angle_arcsec * (1 + 1e-9)
    # The limit is kept at the input angle of the case, so it may be passed at others; that is told.
    pressure = of["contact_pressure_largest_GPa"]
    assert pressure is not None and pressure >= 2.4 - 1e-6
    assert "(the limit is checked at 0 deg)" in found.report()


def test_files_and_loads_that_cannot_be_are_refused(tmp_path: Path) -> None:
    with pytest.raises(cbpt.InvalidInputError, match="No such file"):
        cbpt.optimise(BASE, tmp_path / "none.toml")
    broken = tmp_path / "broken.toml"
    broken.write_text("[free\n")
    with pytest.raises(cbpt.InvalidInputError, match="not TOML"):
        cbpt.optimise(BASE, broken)
    with pytest.raises(cbpt.InvalidInputError, match="without torque"):
        cbpt.optimise(BASE, TWO, torque_Nm=0)
    with pytest.raises(cbpt.InvalidInputError, match="ball drive"):
        cbpt.optimise(TOP / "examples/reducer.toml", TWO, torque_Nm=1)
