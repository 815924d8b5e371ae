"""What is no number where numbers are asked for, and libraries that are missing: the package's
errors; effects of the user's own through pickle."""

from __future__ import annotations

import copy
import datetime
import pickle
import sys
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.errors import MissingLibraryError

DRIVE = cbpt.Drive.from_toml(cbpt.example_case())
ODD: dict[str, Any] = {
    "ragged": [[1.0, 2.0], [3.0]],
    "dates": np.array(["2024-01-01", "2024-01-02"], dtype="datetime64[D]"),
    "durations": np.array([1, 2], dtype="timedelta64[s]"),
    "records": np.array([(1.0, 2.0)], dtype=[("a", float), ("b", float)]),
    "objects": [datetime.date(2024, 1, 1)],
    "nothing": [None, object()],
    "words": ["a", "b"],
    "a whole number of 400 digits": [10**400],
    "dicts": [{}],
}


@pytest.mark.parametrize("name", ["torque_Nm", "preload_N", "input_angle_deg"])
@pytest.mark.parametrize("odd", ODD.values(), ids=ODD.keys())
def test_loads_that_are_no_numbers(name: str, odd: Any) -> None:
    loads: dict[str, Any] = {"torque_Nm": 1.0, "preload_N": 600.0, "input_angle_deg": 0.0}
    with pytest.raises(cbpt.InvalidInputError, match=name):
        cbpt.solve_many(DRIVE, **{**loads, name: odd})


@pytest.mark.parametrize("odd", ODD.values(), ids=ODD.keys())
def test_an_axis_that_is_no_numbers(odd: Any) -> None:
    with pytest.raises(cbpt.PlanError, match=r"load\.torque_Nm"):
        cbpt.sweep(DRIVE, {"load.torque_Nm": odd, "load.preload_N": 600.0})


@pytest.mark.parametrize("odd", [(1,), (), ("a", 2), (1, 10**400), (1, [2]), (1, 2, "log", 3)])
def test_a_range_that_is_none(odd: Any) -> None:
    axes = {"load.torque_Nm": odd, "load.preload_N": 600.0}
    with pytest.raises(cbpt.PlanError, match=r"load\.torque_Nm"):
        cbpt.sweep(DRIVE, axes, design="random", rows=3)


@pytest.mark.parametrize("odd", ODD.values(), ids=ODD.keys())
def test_a_column_of_readings_that_is_no_numbers(odd: Any) -> None:
    table = {"torque_Nm": odd, "preload_N": [600.0] * len(odd)}
    table["elastic_angle_arcsec"] = [1.0] * len(odd)
    with pytest.raises(cbpt.ReadingsError, match="torque_Nm"):
        cbpt.read_readings(table)


@pytest.mark.parametrize(("method", "library"), [("to_pandas", "pandas"), ("to_xarray", "xarray")])
def test_a_missing_library_is_told(
    monkeypatch: pytest.MonkeyPatch, method: str, library: str
) -> None:
    found = cbpt.sweep(DRIVE, {"load.torque_Nm": [1.0], "load.preload_N": 600.0})
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingLibraryError, match=rf"pip install .cbpt\[{library}\]") as caught:
        getattr(found, method)()
    assert isinstance(caught.value, ImportError) and caught.value.name == library


def bent(rows: Any, a: float) -> Any:
    return a * rows["torque_Nm"]


EFFECTS = [
    cbpt.effects.expression("shaft", "series", "a * torque_Nm", {"a": 1e-6}),
    cbpt.effects.expression(
        "pull", "load", "b + c", {"b": {"start": 0.1, "unit": "N", "min": 0, "max": 1}, "c": 1 / 3},
        adds_to="preload_N",
    ),
    cbpt.effects.own_effect("bent", "series", bent, {"a": {"start": 1e-6, "max": 1e-3}}),
    cbpt.effects.own_effect("more", "load", bent, {"a": 1e-6}, adds_to="torque_Nm"),
]  # fmt: skip


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.id)
def test_an_own_effect_goes_through_pickle(effect: Any) -> None:
    for made in (pickle.loads(pickle.dumps(effect)), copy.deepcopy(effect)):
        assert made.id == effect.id and made.parameters == effect.parameters
        assert (made.port, made.adds_to, made.expression) == (
            effect.port, effect.adds_to, effect.expression,
        )  # fmt: skip
