"""Many loads at once, and what is kept: pickles and files."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cbpt
from cbpt import CaseError, CbptError, Drive, InvalidInputError, solve_many
from common.drives import (
    ARCSEC,
    BASE,
    CRANK_DEG,
    PRELOAD_N,
    SHARE,
    CaseDict,
    base_case,
    cases,
    drives,
    examples,
    torque_of,
)

# --- many loads at once -------------------------------------------------------------------


@examples(40)
@given(
    drives(),
    st.lists(st.tuples(st.floats(-1.5, 1.5), PRELOAD_N, CRANK_DEG), min_size=1, max_size=12),
)
def test_many_loads_are_solved_as_each_alone(
    drive: Drive, loads: list[tuple[float, float, float]]
) -> None:
    """solve_many gives, in order, what solve gives one by one; unsolvable loads stay as rows.

    Both solve the same equations to the same tolerance, each in its own way.
    """
    rows = [(torque_of(drive, share, n, angle), n, angle) for share, n, angle in loads]
    torque, preload, angle = np.array(rows).T
    many = solve_many(drive, torque, preload, angle)
    assert len(many) == len(rows)
    for i, load in enumerate(rows):
        s = drive.solve(*load)
        assert many.status[i] == s.status
        assert many.has_solution[i] == s.has_solution
        for found, alone in [
            (many.elastic_angle_rad, s.elastic_angle_rad),
            (many.elastic_angle_arcsec, s.elastic_angle_arcsec),
            (many.alpha_deceleration_rad / ARCSEC, s.alpha_deceleration_arcsec),
            (many.alpha_equal_speed_rad / ARCSEC, s.alpha_equal_speed_arcsec),
            (many.hold_preload_N, s.hold_preload_N),
        ]:
            value = float(found[i])
            assert (alone is None and math.isnan(value)) or value == pytest.approx(
                alone, rel=1e-10, abs=1e-11
            )
        assert math.isnan(many.residual[i]) if s.residual is None else many.residual[i] <= 1e-11


def test_loads_broadcast_as_in_numpy() -> None:
    """Torque down, preload across; the inputs come back in the same shape; all are float arrays."""
    drive = Drive.from_dict(base_case())
    torque, preload = np.linspace(-5, 5, 4)[:, None], [200, 400, 600]
    many = solve_many(drive, torque, preload, 7)
    arrays = [
        many.torque_Nm,
        many.preload_N,
        many.input_angle_deg,
        many.alpha_deceleration_rad,
        many.alpha_equal_speed_rad,
        many.elastic_angle_rad,
        many.residual,
        many.hold_preload_N,
    ]
    assert all(array.shape == (4, 3) and array.dtype == np.float64 for array in arrays)
    assert many.status.shape == many.has_solution.shape == (4, 3)
    assert many.has_solution.dtype == np.bool_
    with pytest.raises(InvalidInputError, match=r"torque_Nm has the shape \(4, 1\).*broadcast"):
        solve_many(drive, torque, np.full((2, 2, 3), 600.0), [7, 8])
    alone = drive.solve(5, 600, 7).elastic_angle_rad
    assert many.elastic_angle_rad[3, 2] == pytest.approx(alone, rel=1e-10)
    assert solve_many(drive, 5, 600).elastic_angle_rad.shape == ()
    assert len(solve_many(drive, [], 600)) == 0


def test_a_bad_load_of_a_grid_is_named_by_its_place() -> None:
    torque = np.array([[1.0], [2.0], [math.nan]])
    with pytest.raises(InvalidInputError, match=r"^torque_Nm\[2, 0\] = NaN"):
        solve_many(BASE, torque, [600, 700])
    with pytest.raises(InvalidInputError, match=r"^preload_N\[0, 1, 1\] = -1"):
        solve_many(BASE, torque[:2], [[[600, 700], [600, -1]]])
    with pytest.raises(InvalidInputError, match=r"^preload_N = 0"):
        solve_many(BASE, 1, 0)


def test_no_part_of_a_number_is_dropped() -> None:
    """numpy would drop imaginary parts with a warning, and masks without one."""
    with pytest.raises(InvalidInputError, match=r"^torque_Nm is complex"):
        solve_many(BASE, np.array([1, 2j]), 600)
    with pytest.raises(InvalidInputError, match=r"^input_angle_deg is complex"):
        solve_many(BASE, 1, 600, [0, 1j])
    masked = np.ma.masked_greater(np.array([[1.0, 2.0], [3.0, 99.0]]), 50)
    with pytest.raises(InvalidInputError, match=r"^torque_Nm\[1, 1\] is masked"):
        solve_many(BASE, masked, 600)
    with pytest.raises(InvalidInputError, match=r"^preload_N is masked"):
        solve_many(BASE, 1, np.ma.masked)
    np.testing.assert_array_equal(
        solve_many(BASE, masked[0], 600).elastic_angle_rad,
        solve_many(BASE, [1, 2], 600).elastic_angle_rad,
    )


# --- pickles and files --------------------------------------------------------------------


@examples(40)
@given(cases(), SHARE, PRELOAD_N, CRANK_DEG)
def test_every_result_survives_pickling(
    case: CaseDict, share: float, preload: float, angle: float
) -> None:
    """Pickled or written as a file and read again, drive and results are the same to the bit."""

    def again(value: Any) -> Any:
        return pickle.loads(pickle.dumps(value))

    drive = Drive.from_dict(case)
    torque = torque_of(drive, share, preload, angle)
    whole = cbpt.Case.from_dict({**case, "load": {"torque_Nm": torque, "preload_N": preload}})
    for value in [
        drive,
        whole,
        drive.preload(torque, angle),
        drive.preload(torque, angle).drive,
        *drive.findings(),
    ]:
        assert again(value) == value
    assert (again(drive).solve(torque, preload).to_json()) == drive.solve(torque, preload).to_json()
    assert hash(again(drive)) == hash(drive)
    assert hash(again(whole)) == hash(whole)
    assert Drive.from_toml(drive.to_toml()) == drive == copy.deepcopy(drive)
    assert cbpt.Case.from_toml(whole.to_toml()) == whole
    s = drive.solve(torque, preload, angle)
    assert again(s).to_json() == s.to_json()
    assert again(s).input_angle_deg == angle
    assert s.deceleration is not None
    np.testing.assert_array_equal(again(s.deceleration).force_N, s.deceleration.force_N)
    assert s.equal_speed is not None
    np.testing.assert_array_equal(again(s.equal_speed).gap_m, s.equal_speed.gap_m)
    many = solve_many(drive, [torque, 1e9], preload, angle)
    np.testing.assert_array_equal(again(many).elastic_angle_rad, many.elastic_angle_rad)
    np.testing.assert_array_equal(again(many).status, many.status)


def test_the_rest_survives_pickling() -> None:
    """Largest angle, an effect, a solution without numbers, and every error."""
    drive = Drive.from_dict(base_case())
    largest = drive.largest_elastic_angle(5, 600)
    assert largest is not None
    assert pickle.loads(pickle.dumps(largest)) == largest
    refused = drive.solve(50, 600)
    assert pickle.loads(pickle.dumps(refused)).message == refused.message
    effect = {"id": "eccentric_bearing", "reference_deflection_um": 2, "exponent": 0.9}
    whole = cbpt.Case.from_dict(base_case() | {"effect": [effect]})
    assert pickle.loads(pickle.dumps(whole)) == whole
    assert pickle.loads(pickle.dumps(whole.effects)) == whole.effects != []
    for error in [CbptError("a"), InvalidInputError("b"), CaseError("c")]:
        same = pickle.loads(pickle.dumps(error))
        assert (type(same), same.args) == (type(error), error.args)
