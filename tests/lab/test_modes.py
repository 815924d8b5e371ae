"""Several solutions: readings that fit one effect in more than one way, or that two angles explain.

The drive and the plans of a reviewer's sets, read by the product's own simulate.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from cbpt import Case, read_readings
from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.diagnosis.fitted import fit
from cbpt.lab.diagnosis.sparse_term import dictionary
from cbpt.lab.experiment.simulate import simulate
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.readings.reader import Readings
from common import mostly_long

DRIVE = """
[deceleration]
ball_count = 24
short_amplitude_coefficient = 0.5
rolling_circle_radius_mm = 4.0
ball_radius_mm = 1.4
groove_conformity = 1.06
contact_angle_deg = 45.0
[equal_speed]
kind = "ring_groove"
ball_count = 12
pitch_radius_mm = 45.0
ball_radius_mm = 2.0
groove_conformity = 1.06
contact_angle_deg = 45.0
[load]
preload_N = 800
"""
PLAN = """
u_elastic_angle_arcsec = 0.3
temperature_degC = {temperature}
dwell_s = 4
[[run]]
preload_N = [500, 800, 1400]
input_angle_deg = {angles}
torque_Nm = {{ to = 8, points = {points}, shape = "loop" }}
"""
TWO = PLAN.format(temperature="{ from = 20, to = 24 }", angles="[0, 90]", points=5)
THREE = PLAN.format(temperature="20", angles="[10, 95, 200]", points=4)
SIX = PLAN.format(temperature="20", angles="{ from = 0, to = 300, points = 6 }", points=2)


Set = tuple[str, str, str, float, int]
"""Plan, effect, the size that is not 0, its value in its own unit, seed."""
TILT: Set = (TWO, "plate_tilt", "tilt_cosine_urad", 200.0, 35)
LARGE_PITCH: Set = (TWO, "groove_pitch_error", "cosine_um", 4.0, 40)


def readings_of(of: Set) -> Readings:
    plan, effect, size, value, seed = of
    numbers = {size: value} | ({"harmonic": 3.0} if effect == "groove_pitch_error" else {})
    with TemporaryDirectory() as folder:
        path = Path(folder) / "plan.toml"
        path.write_text(plan)
        return simulate(Case.from_toml(DRIVE), path, effects=[(effect, numbers)], seed=seed)


@cache
def diagnosed(of: Set) -> Diagnosis:
    return diagnose(Case.from_toml(DRIVE), readings_of(of))


def holds_truth(found: Fit, effect: str, true: dict[str, float]) -> bool:
    """Whether one of the solutions is the truth, to 3.3 standard uncertainties."""
    for solution in (found, *found.other_modes):
        own = {u.name: (solution.value(u), solution.u(u)) for u in solution.unknowns}
        pairs = [(own.get(f"{effect}.{name}"), value) for name, value in true.items()]
        if all(o is not None and abs(o[0] - value) < 3.3 * o[1] for o, value in pairs):
            return True
    return False


@pytest.mark.parametrize(
    ("of", "true"),
    mostly_long(
        [
            (TILT, 200e-6),
            ((SIX, "plate_tilt", "tilt_cosine_urad", 200.0, 32), 200e-6),
            ((TWO, "plate_tilt", "tilt_cosine_urad", 100.0, 41), 100e-6),
        ],
        [(TILT, 200e-6)],
    ),
)
def test_a_tilt_of_either_sign_is_told(of: Set, true: float) -> None:
    d = diagnosed(of)
    assert d.verdict.effects == ("plate_tilt",)
    assert holds_truth(d.after, "plate_tilt", {"tilt_cosine_rad": true, "tilt_sine_rad": 0.0})
    signs = {np.sign(f.value(f.unknowns[-2])) for f in (d.after, *d.after.other_modes)}
    assert signs == {-1.0, 1.0}
    found = d.parameters(d.after, "plate_tilt")
    assert all(p["u"] is None and "another value" in p["why_no_u"] for p in found.values())
    assert any("plate_tilt has" in note and "solutions" in note for note in d.notes)
    assert "another solution" in d.sentence


@pytest.mark.parametrize("phase", mostly_long(range(0, 360, 30), [60, 120]))
def test_a_large_tilt_is_no_smaller_one_beside_another_stiffness(phase: float) -> None:
    """The angle goes with its square, so from the drive as stated the slopes lead elsewhere."""
    size = 230.0 * np.array([np.cos(np.radians(phase)), np.sin(np.radians(phase))])
    numbers = dict(
        zip(("fixed_plate_tilt_cosine_urad", "fixed_plate_tilt_sine_urad"), size, strict=True)
    )
    with TemporaryDirectory() as folder:
        path = Path(folder) / "plan.toml"
        path.write_text(THREE)
        readings = simulate(Case.from_toml(DRIVE), path, effects=[("plate_tilt", numbers)], seed=3)
    verdict = diagnose(Case.from_toml(DRIVE), readings).verdict
    assert verdict.effects == ("plate_tilt",), verdict


def test_a_fit_finds_the_solutions_that_the_diagnosis_finds() -> None:
    found = fit(Case.from_toml(DRIVE), readings_of(TILT), "plate_tilt")
    assert holds_truth(found.result, "plate_tilt", {"tilt_cosine_rad": 2e-4, "tilt_sine_rad": 0.0})
    assert all(p["u"] is None for p in found.parameters()["plate_tilt"].values())
    assert any("plate_tilt has" in note for note in found.notes)


def test_a_form_that_was_asked_for_is_kept() -> None:
    form = "groove_pitch_error:planet, harmonic 2"
    found = fit(Case.from_toml(DRIVE), readings_of(LARGE_PITCH), form)
    for solution in (found.result, *found.result.other_modes):
        assert [v.label for v in solution.hypothesis.variants] == [form]


def test_an_offset_of_a_centre_is_named_where_any_function_of_two_angles_fits_as_well() -> None:
    d = diagnosed((TWO, "eccentricity_error", "offset_sine_um", 3.0, 20))
    assert (d.verdict.kind, d.verdict.effects) == ("effect", ("eccentricity_error",))


@pytest.mark.parametrize("seed", mostly_long([21, 34], [21]))
def test_a_pitch_error_is_a_rival_of_the_tilt_that_looks_like_it(seed: int) -> None:
    d = diagnosed((TWO, "groove_pitch_error", "cosine_um", 2.0, seed))
    assert d.verdict.kind == "ambiguous"
    assert any({"groove_pitch_error", "plate_tilt"} <= set(g) for g in d.verdict.rivals)


def test_forms_that_two_angles_cannot_tell_apart_are_told() -> None:
    d = diagnosed(LARGE_PITCH)
    assert d.verdict.effects == ("groove_pitch_error",)
    assert holds_truth(d.after, "groove_pitch_error", {"cosine_m": 4e-6, "sine_m": 0.0})
    forms = {f.hypothesis.variants[0].name for f in (d.after, *d.after.other_modes)}
    assert {"fixed groove, harmonic 3", "planet, harmonic 3"} <= forms
    again = fit(Case.from_toml(DRIVE), readings_of(LARGE_PITCH), "groove_pitch_error")
    assert again.result.hypothesis == d.after.hypothesis


def test_few_input_angles_are_remarked_on() -> None:
    load = {"torque_Nm": [0.0, 1.0, 2.0, 3.0], "preload_N": [500.0, 800.0, 500.0, 800.0]}
    load |= {"elastic_angle_arcsec": [0.0, 5.0, 10.0, 15.0]}
    for angles, word in (([0.0, 90.0, 0.0, 450.0], "two"), ([0.0, 90.0, 180.0, 0.0], "three")):
        notes = read_readings(load | {"input_angle_deg": angles}).notes
        assert any(f"only {word} input angles" in note for note in notes)
    assert not any("input angles" in note for note in read_readings(load).notes)


def test_a_draft_has_no_more_numbers_than_there_are_angles() -> None:
    where = [w for _, w in dictionary(readings_of(TILT)) if "input_angle_rad" in w.text]
    assert where and all(not w.shapes for w in where)
