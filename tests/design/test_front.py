"""Fronts of two objectives against a grid of all designs, and what they are written as."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt.cli.main import main
from cbpt.design.judge import at_load, judge
from common.drives import base_case

BOUNDS = {
    "free": {"load.preload_N": [200, 2000], "deceleration.contact_angle_deg": [35, 60]},
    "limits": {"static_safety": 1.5},
}
ARCSEC = np.rad2deg(1.0) * 3600


@pytest.fixture(scope="module")
def front() -> cbpt.ParetoFront:
    return cbpt.pareto_front(base_case(), BOUNDS, points=5)


def test_no_design_of_a_grid_beats_one_of_the_front(front: cbpt.ParetoFront) -> None:
    preload, angle = np.meshgrid(np.linspace(200, 2000, 91), np.radians(np.linspace(35, 60, 51)))
    grid = np.column_stack([preload.ravel(), angle.ravel()])
    names = ["load.preload_N", "deceleration.contact_angle_rad"]
    found = judge(at_load(base_case()), names, grid, pressures=True, coefficient=0.1)
    kept = (found["static_safety"] >= 1.5) & (found.status == "ok")
    both = np.column_stack([found["elastic_angle_rad"] * ARCSEC, found["friction_torque_Nm"]])[kept]
    assert len(front.points) == 5 and front.beaten == 0
    for point in front.values:
        assert not np.any(np.all(both < point * (1 - 1e-6), axis=1)), point


def test_it_goes_from_one_end_to_the_other(front: cbpt.ParetoFront) -> None:
    angle, friction = front.values.T
    assert np.all(np.diff(angle) > 0) and np.all(np.diff(friction) < 0)
    stiffest = cbpt.optimise(base_case(), BOUNDS)
    smoothest = cbpt.optimise(base_case(), BOUNDS, objective="friction_torque")
    assert angle[0] == pytest.approx(stiffest.after_arcsec, rel=1e-6)
    assert friction[-1] == pytest.approx(smoothest.friction["friction_torque_Nm"], rel=2e-6)
    # The limits divide the range evenly, and each is reached.
    assert np.diff(np.log(friction)) == pytest.approx(
        np.full(4, np.log(friction[-1] / friction[0]) / 4), rel=1e-3
    )


def test_the_order_of_the_objectives_is_that_of_the_answer(front: cbpt.ParetoFront) -> None:
    turned = cbpt.pareto_front(base_case(), BOUNDS, ("friction_torque", "elastic_angle"), points=5)
    assert turned.values == pytest.approx(front.values[::-1, ::-1], rel=1e-12)


def test_it_is_written_and_drawn(front: cbpt.ParetoFront, tmp_path: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(front.to_csv())))
    for row, point in zip(rows, front.points, strict=True):
        assert float(row["elastic_angle_arcsec"]) == point.after_arcsec
        assert float(row["load.preload_N"]) == point.case.preload_N
    document = json.loads(front.to_json())
    again = cbpt.Case.from_toml(document["points"][2]["case_toml"])
    assert again == front.points[2].case
    assert "elastic angle (arcmin)" in front.report("arcmin")
    picture = tmp_path / "front.svg"
    front.plot(picture)
    assert "friction torque (N m)" in picture.read_text(encoding="utf-8")


def test_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case, bounds, out = (tmp_path / name for name in ("drive.toml", "bounds.toml", "front.csv"))
    case.write_text(cbpt.example_case())
    bounds.write_text("[free]\nload.preload_N = [200, 2000]\n")
    asked = ["optimise", str(case), str(bounds), "--front", "wear", "--points", "2"]
    assert main([*asked, "--out", str(out)]) == 0
    assert "wear (N m per turn)" in capsys.readouterr().out
    assert len(out.read_text().splitlines()) == 3
    assert main([*asked, "--objective", "wear"]) == 2
    assert "another objective" in capsys.readouterr().err


def test_bounds_that_nothing_keeps_and_objectives_that_are_none_are_told() -> None:
    impossible = {"free": {"load.preload_N": [200, 400]}, "limits": {"efficiency": 0.999}}
    found = cbpt.pareto_front(base_case(), impossible, points=2)
    assert not found.points and "efficiency" in found.report()
    for wrong in (("wear", "wear"), ("wear", "colour")):
        with pytest.raises(cbpt.InvalidInputError, match="two of elastic_angle"):
            cbpt.pareto_front(base_case(), BOUNDS, wrong)
    with pytest.raises(cbpt.InvalidInputError, match="points = 1"):
        cbpt.pareto_front(base_case(), BOUNDS, points=1)
