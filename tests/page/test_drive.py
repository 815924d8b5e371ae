"""The drive's part of the document: its drawing, its sliders, its thresholds."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.errors import InvalidInputError
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.page.document.document import page_document
from cbpt.page.document.drive import drive_section, redrawn
from cbpt.page.document.models import Models
from cbpt.page.document.plain import to_json
from cbpt.page.document.source import Source
from common.hidden import diagnosed, table_of

SOURCE = Source.of_files("case.toml", "data.csv")


def array(values: list[float | None]) -> Any:
    return np.array([np.nan if v is None else v for v in values])


DRIVES = {
    "ring grooves": ("ring_groove", "hypocycloid"),
    "cross-slide": ("cross_slide", "hypocycloid"),
    "epicycloid drives": ("ring_groove", "epicycloid"),
}


def drive_of(kind: str, output: str) -> cbpt.Drive:
    case = tomllib.loads(cbpt.example_case())
    case["equal_speed"]["kind"] = kind
    case["deceleration"]["output_plate"] = output
    return cbpt.Drive.from_dict(case)


def section_of(drive: cbpt.Drive, **load: float) -> Any:
    _, readings = case_and_readings(drive, table_of("dev04"))
    return redrawn(drive, readings, {"torque_Nm": 5, "preload_N": 600, **load})


@pytest.mark.parametrize(("kind", "output"), DRIVES.values(), ids=DRIVES)
@pytest.mark.parametrize("angle", [0.0, 77.0])
def test_the_arrows_balance_the_torque_about_the_output(
    kind: str, output: str, angle: float
) -> None:
    drive = drive_of(kind, output)
    found = section_of(drive, input_angle_deg=angle)
    solution = drive.solve(5, 600, angle)
    assert found["solution"]["elastic_angle_arcsec"] == solution.elastic_angle_arcsec
    for pair, solved in zip(
        found["drawing"]["pairs"], (solution.deceleration, solution.equal_speed), strict=True
    ):
        assert solved is not None
        centres = {c["label"]: c["x"] for c in pair["centres"]}
        about = {"hypocycloid": "O3", "epicycloid": "O1"}.get(pair["plates"]["output"])
        x0 = centres[about] if about else 0.0
        moment = sum(
            1e-3 * ((a["x"] - x0) * a["dy"] - a["y"] * a["dx"]) / pair["arrow_mm_per_N"]
            for a in pair["arrows"]
        )
        # The torque turns the output clockwise, and the balls hold it.
        assert moment == pytest.approx(solved.torque_Nm, rel=2e-3)
        if pair["pair"] == "deceleration":
            along = sum(a["dx"] for a in pair["arrows"]) / pair["arrow_mm_per_N"]
            assert abs(along) == pytest.approx(abs(solved.in_plane_force_along_N), rel=1e-2)


@pytest.mark.parametrize(("kind", "output"), DRIVES.values(), ids=DRIVES)
def test_tracks_pass_through_all_balls_and_meshing_points_lie_on_walls(
    kind: str, output: str
) -> None:
    pair = section_of(drive_of(kind, output), input_angle_deg=33.0)["drawing"]["pairs"][0]
    lines = {
        (plate, part): np.concatenate(
            [
                _dense(line)
                for line in pair["lines"]
                if line["plate"] == plate and line["kind"] == part
            ]
        )
        for plate in ("epicycloid", "hypocycloid")
        for part in ("track", "wall")
    }
    for ball in pair["balls"]:
        for plate in ("epicycloid", "hypocycloid"):
            off = np.abs(lines[plate, "track"] - (ball["x"] + 1j * ball["y"])).min()
            assert off < 0.04, (plate, ball["number"])
    other = {"hypocycloid": "epicycloid", "epicycloid": "hypocycloid"}[output]
    for point in pair["points"]:
        plate = output if point["plate"] == "output" else other
        off = np.abs(lines[plate, "wall"] - (point["x"] + 1j * point["y"])).min()
        assert off < 0.04


def _dense(line: dict[str, Any]) -> Any:
    z = np.array(line["x"]) + 1j * np.array(line["y"])
    steps = np.linspace(0, 1, 40, endpoint=False)
    return (z[:-1, None] + np.diff(z)[:, None] * steps).ravel()


def test_the_drive_follows_load_and_design() -> None:
    drive = drive_of("ring_groove", "hypocycloid")
    _, readings = case_and_readings(drive, table_of("dev04"))
    other: Any = redrawn(drive, readings, {"torque_Nm": 3.0}, {"deceleration.ball_count": 24})
    case = tomllib.loads(drive.to_toml())
    case["deceleration"]["ball_count"] = 24
    expected = cbpt.Drive.from_dict(case).solve(
        3.0, other["load"]["preload_N"], other["load"]["input_angle_deg"]
    )
    assert other["solution"]["elastic_angle_arcsec"] == expected.elastic_angle_arcsec
    assert len(other["drawing"]["pairs"][0]["balls"]) == 24
    curve = other["angle_curve"]
    middle = len(curve["torque_Nm"]) // 2
    assert curve["elastic_angle_arcsec"][middle] == pytest.approx(0.0, abs=1e-4)


def test_a_load_that_slips_has_its_geometry_its_reason_and_no_force() -> None:
    found = section_of(drive_of("ring_groove", "hypocycloid"), preload_N=50.0)
    assert found["solution"]["status"] == "beyond_hold"
    hold = found["solution"]["hold_preload_N"]
    assert hold > 50
    # What is told has no more digits than are read, and would still hold.
    told = re.search(r"more than ([\d.]+) N", found["solution"]["message"])
    assert told
    assert hold <= float(told[1]) < hold * 1.0001
    assert len(told[1]) < 8
    finding = next(f for f in found["findings"] if "more than" in f["message"])
    assert told[0] in finding["message"]
    # Over the whole turn no less.
    assert found["thresholds"]["drive"]["hold_N"] >= hold
    for pair in found["drawing"]["pairs"]:
        assert pair["arrows"] == []
        assert all(point["force_N"] is None for point in pair["points"])
    to_json(found)


@pytest.mark.parametrize(
    ("load", "design"),
    [
        ({"speed": 1.0}, {}),
        ({}, {"deceleration.output_plate": 1.0}),
        ({}, {"deceleration.ball_count": 20.5}),
        ({}, {"deceleration.ball_radius_mm": -1.0}),
    ],
)
def test_loads_and_designs_that_cannot_be_are_refused(
    load: dict[str, float], design: dict[str, float]
) -> None:
    drive = drive_of("ring_groove", "hypocycloid")
    _, readings = case_and_readings(drive, table_of("dev04"))
    with pytest.raises((InvalidInputError, cbpt.CaseError)):
        redrawn(drive, readings, load, design)


def test_a_torsion_spring_has_a_page_that_says_why_nothing_is_drawn() -> None:
    case, readings = case_and_readings("examples/reducer.toml", "examples/reducer.csv")
    found: Any = page_document(case, readings, SOURCE)
    assert found["drive"]["drawing"] is None
    assert "torsion spring" in found["drive"]["why_no_drawing"]
    assert found["drive"]["thresholds"] is None
    assert all(v is not None for v in found["drive"]["angle_curve"]["elastic_angle_arcsec"])
    assert drive_section(case, readings)["sliders"]["design"] == []
    to_json(found)
    # It has no preload and no contacts that an effect could show by.
    tell_tales = {effect["effect"]: effect["tell_tale"] for effect in found["library"]}
    assert "a loop" in tell_tales["friction_hysteresis"]
    assert [e for e, says in tell_tales.items() if "preload" in says or "contact" in says] == []


def test_the_loop_of_a_model_is_that_of_its_prediction_with_history() -> None:
    diagnosis = diagnosed("dev04")
    models = Models(diagnosis, diagnosis.readings)
    load: Any = {"torque_Nm": 8.0, "preload_N": 420.0, "input_angle_deg": 10.0}
    effects = list(diagnosis.verdict.names)
    assert effects == ["friction_hysteresis"]
    loop: Any = models.loop(effects, load)
    torque, angle, u = (array(v) for v in loop.values())
    assert (torque[0], torque.min(), torque[-1], len(torque)) == (8.0, -8.0, 8.0, 161)
    # A closed cycle, whose ends the first loading reaches but for what the friction has left.
    assert angle[0] == pytest.approx(angle[-1], abs=1e-6)
    fresh = diagnosis.predict([8.0], 420.0, 10.0)
    assert angle[0] == pytest.approx(fresh.elastic_angle_arcsec[0], abs=1e-3)
    assert u[0] == pytest.approx(fresh.u_elastic_angle_arcsec[0], rel=1e-3)
    # Friction opens it: on the way back the angle is ahead.
    middle = {way: angle[np.flatnonzero(torque == 0.0)[k]] for k, way in enumerate(("down", "up"))}
    assert middle["down"] - middle["up"] > 1.0
    refitted: Any = models.loop([], load)
    assert refitted["elastic_angle_arcsec"] != loop["elastic_angle_arcsec"]
    # The drive as stated has nothing fitted, and no uncertainty of a fit.
    entry: Any = next(models.entries())
    assert (entry["key"], entry["loop"]["u_arcsec"]) == ("stated", None)
    # Nobody knows the preload: no loop.
    load["preload_N"] = None
    assert models.loop(effects, load) is None
