"""Angles of encoders that count from anywhere and begin again after a turn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from cbpt.errors import ReadingsError
from cbpt.lab.readings.reader import read_readings
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]
TORQUE = np.r_[np.arange(0, 10), np.arange(10, -10, -1), np.arange(-10, 1)].astype(np.float64)


def read(angle_deg: Floats, run: NDArray[np.int64] | None = None) -> Readings:
    columns = {
        "torque_Nm": np.resize(TORQUE, len(angle_deg)),
        "elastic_angle_deg": angle_deg,
        "run": np.ones(len(angle_deg), dtype=np.int64) if run is None else run,
    }
    return read_readings(columns, need_preload=False)


@given(start=st.floats(-180, 179.99), ends=st.sampled_from([(-180.0, 180.0), (0.0, 360.0)]))
def test_an_encoder_that_begins_again_is_read_as_if_it_went_on(
    start: float, ends: tuple[float, float]
) -> None:
    low, high = ends
    angle = start + 0.05 * TORQUE
    shown = low + np.mod(angle - low, high - low)
    found = read(shown)
    turned = found.elastic_angle_arcsec - found.elastic_angle_arcsec[0]
    np.testing.assert_allclose(turned, 3600 * (angle - angle[0]), atol=1e-6)
    jumps = int(np.count_nonzero(np.abs(np.diff(shown)) > 180))
    assert sum("whole turns were taken off" in str(note) for note in found.notes) == (jumps > 0)


def test_each_run_keeps_the_turn_that_it_begins_with() -> None:
    run = np.repeat([1, 2], len(TORQUE))
    angle = np.r_[359.9 + 0.05 * TORQUE, 60 + 0.05 * TORQUE]
    found = read(np.mod(angle, 360.0), run).elastic_angle_arcsec / 3600
    np.testing.assert_allclose(found, angle, atol=1e-9)


@pytest.mark.parametrize("zero_deg", [0.0, 359.9999])
def test_runs_on_both_sides_of_the_end_of_an_encoder_have_one_zero(zero_deg: float) -> None:
    run = np.repeat([1, 2], len(TORQUE))
    angle = np.r_[0.02 + 0.001 * TORQUE, -0.02 + 0.001 * TORQUE] + zero_deg
    found = read(np.mod(angle, 360.0), run)
    apart = np.diff([np.median(found.elastic_angle_arcsec[run == k]) for k in (1, 2)])
    assert apart == pytest.approx(-0.04 * 3600)
    assert any("whole turns were taken off" in str(note) for note in found.notes)


def test_runs_of_one_reading_hide_no_wrong_unit() -> None:
    with pytest.raises(ReadingsError, match="within a turn"):
        read(1e6 * TORQUE, np.arange(len(TORQUE)))


def test_an_angle_far_from_zero_is_no_wrong_unit_of_a_drive_that_hardly_turns() -> None:
    found = read(200 + 0.05 * TORQUE)
    assert not any("check the unit" in str(note) for note in found.notes)


def test_a_wrong_number_is_no_turn() -> None:
    angle = 0.05 * TORQUE
    angle[7] = 270.0
    with pytest.raises(ReadingsError, match="less than 180 deg from the middle of its run"):
        read(angle)


def test_a_copied_row_is_to_be_removed() -> None:
    columns = {
        "torque_Nm": np.repeat(TORQUE, 2),
        "elastic_angle_arcsec": 60 * np.repeat(TORQUE, 2),
        "time_s": np.repeat(np.arange(float(len(TORQUE))), 2),
        "run": np.ones(2 * len(TORQUE), dtype=np.int64),
    }
    with pytest.raises(ReadingsError, match="remove the copy"):
        read_readings(columns, need_preload=False)
