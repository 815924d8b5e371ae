"""Proved solutions from Python: `Solution.enclosure`.

What is proved and how is tested in crates/cbpt-core/tests/proof.rs, and beside the independent
reference in test_reference_drives; here is what Python gets of it.
"""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import pytest

import cbpt
from cbpt import Enclosure

EXAMPLES = Path(__file__).parents[2] / "examples"
DRIVE = cbpt.Drive.from_file(EXAMPLES / "base_case.toml")


@pytest.mark.parametrize("torque_Nm", [-20.0, 1e-3, 5.0, 23.3])
def test_the_answer_lies_in_the_interval(torque_Nm: float) -> None:
    solution = DRIVE.solve(torque_Nm, 600, 12.5)
    found = solution.enclosure
    assert found is not None
    for (lower, upper), value in [
        (found.elastic_angle_rad, solution.elastic_angle_rad),
        (found.elastic_angle_arcsec, solution.elastic_angle_arcsec),
        (found.alpha_deceleration_arcsec, solution.alpha_deceleration_arcsec),
        (found.alpha_equal_speed_arcsec, solution.alpha_equal_speed_arcsec),
    ]:
        assert value is not None
        assert lower < value < upper
        assert upper - lower < 1e-10 * abs(value)


def test_seconds_of_arc_are_rounded_outwards() -> None:
    found = DRIVE.solve(5, 600).enclosure
    assert found is not None
    arcsec = 648000 / math.pi
    lower, upper = (bound * arcsec for bound in found.elastic_angle_rad)
    assert found.elastic_angle_arcsec[0] < lower < upper < found.elastic_angle_arcsec[1]


def test_an_enclosure_is_a_value() -> None:
    found = DRIVE.solve(5, 600).enclosure
    assert isinstance(found, Enclosure)
    assert pickle.loads(pickle.dumps(found)) == found == DRIVE.solve(5, 600).enclosure
    assert found != DRIVE.solve(5.1, 600).enclosure
    assert repr(found).startswith("Enclosure(elastic angle between 12.4604549")


def test_what_has_no_proof_has_none() -> None:
    assert DRIVE.solve(500, 600).enclosure is None
    spring = cbpt.Drive.from_file(EXAMPLES / "reducer.toml")
    assert spring.solve(5).has_solution and spring.solve(5).enclosure is None
