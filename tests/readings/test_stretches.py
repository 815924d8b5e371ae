"""Runs of a table that does not number them."""

from __future__ import annotations

import numpy as np
import pytest

import cbpt
from cbpt.lab.readings.stretches import stretches

LOOP = np.array([0.0, 2.0, 4.0, 2.0, 0.0, -2.0, -4.0, -2.0, 0.0])


def table(preload_N: np.ndarray, input_angle_deg: np.ndarray) -> dict[str, np.ndarray]:
    n = len(preload_N)
    return {
        "time_s": 5.0 * np.arange(n),
        "torque_Nm": np.resize(LOOP, n),
        "preload_N": preload_N,
        "input_angle_deg": input_angle_deg,
        "elastic_angle_arcsec": 10.0 * np.resize(LOOP, n),
    }


def test_what_is_set_for_a_loop_tells_the_runs() -> None:
    preload, angle = np.repeat([600.0, 600.0, 900.0], 9), np.repeat([0.0, 40.0, 40.0], 9)
    read = cbpt.read_readings(table(preload, angle))
    assert read.run.tolist() == np.repeat([1, 2, 3], 9).tolist()
    assert any("each stretch at one preload" in n and "3 in all" in n for n in read.notes)
    numbered = cbpt.read_readings(table(preload, angle) | {"run": np.repeat([1.0, 2, 2], 9)})
    assert numbered.run_index.max() == 1


@pytest.mark.parametrize(
    "settings",
    [
        (np.full(27, 600.0), np.zeros(27)),  # one
        (np.full(27, 600.0), np.arange(27.0)),  # the input turns
        (600.0 + np.resize([0.1, -0.2, 0.3], 27), np.repeat([0.0, 40.0, 80.0], 9)),  # measured
        (np.repeat([600.0, 700.0], [26, 1]), np.zeros(27)),  # a rest of one
        (np.repeat([600.0, 601.0], [14, 13]), np.zeros(27)),  # measured, in whole newtons
    ],
)
def test_else_it_is_one_run(settings: tuple[np.ndarray, np.ndarray]) -> None:
    assert stretches(settings, np.resize(LOOP, 27)) is None
    read = cbpt.read_readings(table(*settings))
    assert read.run_index.max() == 0
    assert any("all rows are treated as one run" in note for note in read.notes)


def test_angles_that_are_set_at_each_torque_are_no_runs() -> None:
    torque, angle = np.repeat(LOOP, 12), np.tile(np.repeat([0.0, 90, 180, 270], 3), len(LOOP))
    held = table(np.full(len(torque), 600.0), angle) | {"torque_Nm": torque}
    assert cbpt.read_readings(held).run_index.max() == 0


def test_rows_out_of_time_order_are_refused_whatever_was_set() -> None:
    interleaved = table(np.repeat([600.0, 900.0], 9), np.zeros(18))
    interleaved["time_s"] = np.r_[0.0:18:2, 1.0:18:2]
    with pytest.raises(cbpt.ReadingsError, match="sort the rows by time"):
        cbpt.read_readings(interleaved)
    in_order = np.argsort(interleaved["time_s"])
    read = cbpt.read_readings({name: column[in_order] for name, column in interleaved.items()})
    assert read.run_index.max() == 0


def test_one_reading_is_one_run() -> None:
    assert stretches([np.array([600.0])], np.zeros(1)) is None
