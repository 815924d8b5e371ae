"""Cases and loads that cannot be: each is refused by its name, none makes a panic."""

from __future__ import annotations

import json
import math
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cbpt
from cbpt import CaseError, CbptError, Drive, InvalidInputError, solve_many
from common import PATIENCE_S
from common.drives import (
    BASE,
    CaseDict,
    base_case,
    examples,
)


def places(case: CaseDict) -> Iterator[tuple[str, str]]:
    for section, keys in case.items():
        for key in keys:
            yield section, key


NO_NUMBERS: list[Any] = ["1.5", "", None, [], [1.0], {}, {"value": 1}, True]
BAD_NUMBERS: dict[str, list[float]] = {
    "torque_Nm": [],
    "input_angle_deg": [],
    "poissons_ratio": [-1, 0.5, 0.7],
    "short_amplitude_coefficient": [0, -0.1, 1, 1.5],
    "groove_conformity": [1, 0.9, 0, -1],
    "contact_angle_deg": [0, -45, 90, 180],
    "ball_count": [0, -20, 2, 20.5, 1001, 2**32 + 20, 2**64, 1e300],
}


@pytest.mark.parametrize(("section", "key"), list(places(base_case())))
def test_each_value_that_cannot_be_is_refused_by_its_key(section: str, key: str) -> None:
    """Whatever stands where a number belongs is told with its key, in the right class."""
    for value in NO_NUMBERS + BAD_NUMBERS.get(key, [0, -1, -1e300]):
        case = base_case()
        case[section][key] = value
        with pytest.raises(CaseError, match=f"{section}.{key}") as caught:
            cbpt.Case.from_dict(case)
        assert isinstance(caught.value, ValueError)
        assert isinstance(caught.value, CbptError)


@pytest.mark.parametrize(("section", "key"), list(places(base_case())))
def test_keys_that_are_missing_or_misspelt_are_told(section: str, key: str) -> None:
    """A required key that is missing, and any key with a letter too many, is named."""
    case = base_case()
    value = case[section].pop(key)
    if section in ("deceleration", "equal_speed") and key != "kind":
        with pytest.raises(CaseError, match=key.split("_")[0]):
            Drive.from_dict(case)
    case[section]["x" + key] = value
    with pytest.raises(CaseError, match="x" + key):
        Drive.from_dict(case)


NOT_FINITE = [math.nan, math.inf, -math.inf, 10**400]


@pytest.mark.parametrize("value", NOT_FINITE, ids=["nan", "inf", "-inf", "10**400"])
def test_a_number_of_a_case_that_is_not_finite_is_a_case_error(value: float) -> None:
    """NaN and infinity have no place in a case, and the message says where they stand."""
    for section, key in places(base_case()):
        if key == "kind":
            continue
        case = base_case()
        case[section][key] = value
        with pytest.raises(CaseError, match=key):
            cbpt.Case.from_dict(case)


@pytest.mark.parametrize("of", [np.float64, np.float32, np.int64, np.uint8])
def test_numbers_of_numpy_are_numbers(of: Callable[[int], Any]) -> None:
    """What numpy makes may stand in a case like what Python makes."""
    case = base_case()
    case["deceleration"]["rolling_circle_radius_mm"] = of(4)
    case["deceleration"]["ball_count"] = of(20)
    assert Drive.from_dict(case) == Drive.from_dict(base_case())


NUMBERS = st.one_of(
    st.floats(),
    st.floats(-10, 1000),
    st.integers(),
    st.sampled_from([0.0, -0.0, 5e-324, 1e-320, 1e308, -1e308, math.nan, math.inf, -math.inf]),
)
ANYTHING = st.recursive(
    st.one_of(NUMBERS, st.none(), st.booleans(), st.text(max_size=8), st.binary(max_size=4)),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=6,
)


@examples(200)
@given(st.data())
def test_no_case_makes_a_panic(data: st.DataObject) -> None:
    """Any value in any place is read or refused; what is read solves or says why not."""
    case = base_case()
    for section, key in data.draw(
        st.lists(st.sampled_from(list(places(case))), min_size=1, max_size=3)
    ):
        value = data.draw(ANYTHING)
        if key == "ball_count" and isinstance(value, (int, float)) and value > 60:
            value = 60
        case[section][key] = value
    if data.draw(st.booleans()):
        case[data.draw(st.text(max_size=8))] = data.draw(ANYTHING)
    try:
        whole = cbpt.Case.from_dict(case)
    except CaseError:
        return
    drive = whole.drive
    s = drive.solve(1.0, 600)
    angle = s.elastic_angle_rad
    assert s.has_solution == (angle is not None)
    assert angle is None or math.isfinite(angle)
    assert repr(drive)
    assert repr(s)
    assert pickle.loads(pickle.dumps(whole)) == whole
    drive.preload(1.0, 0.0)
    drive.findings(1.0, 600)


@examples(200)
@given(ANYTHING)
def test_what_is_no_case_is_refused(value: Any) -> None:
    """A dict, or a text, that is no case is a CaseError; what is neither is a TypeError."""
    for read in (Drive.from_dict, cbpt.Case.from_dict):
        with pytest.raises(CaseError if isinstance(value, dict) else TypeError):
            read(value)
    for read_text in (Drive.from_toml, cbpt.Case.from_toml):
        with pytest.raises(CaseError if isinstance(value, str) else TypeError):
            read_text(value)


BEYOND_READING = {
    "a dict in itself": "case['deceleration'] = case",
    "a list in itself": "case['effect'] = x = []; x.append(x)",
    "very deep": "for _ in range(200_000): case = {'deceleration': case}",
    "a number too long to write": "case['load'] = {'torque_Nm': 10**5000}",
    "its own item": "case['load'] = type('Own', (), {'item': lambda self: self})()",
    "one list a million million times": "for _ in range(6): case = {'effect': [case] * 100}",
    "a key that is no text": "case[10**5000] = 1",
    "half a character": "case['\\ud800'] = '\\ud800'",
}


@pytest.mark.parametrize("make", BEYOND_READING.values(), ids=BEYOND_READING.keys())
def test_a_case_beyond_reading_is_a_case_error(make: str) -> None:
    """In a process of its own, because a stack that overflows takes the interpreter with it."""
    lines = [
        "import cbpt",
        "case = {}",
        make,
        "try: cbpt.Case.from_dict(case)",
        "except cbpt.CaseError: print('refused')",
    ]
    command = [sys.executable, "-c", "\n".join(lines)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "refused\n", "")


def test_what_is_beyond_reading_is_told_by_its_place() -> None:
    inside: CaseDict = {}
    inside["deceleration"] = inside
    with pytest.raises(CaseError, match=r"^(deceleration\.){7}deceleration: found more than 8 lev"):
        cbpt.Case.from_dict(inside)
    with pytest.raises(CaseError, match=r"^load\.torque_Nm = .*a number beyond all range"):
        cbpt.Case.from_dict({**base_case(), "load": {"torque_Nm": 10**5000}})
    longdouble = np.longdouble(20)  # whose item is itself
    with pytest.raises(CaseError, match=r"^load\.torque_Nm: found a value of type longdouble"):
        cbpt.Case.from_dict({**base_case(), "load": {"torque_Nm": longdouble}})
    with pytest.raises(CaseError, match=r"^deceleration: found a key of type int"):
        cbpt.Case.from_dict({"deceleration": {3: 4}})


def test_half_a_character_is_told_by_its_line() -> None:
    for read in (Drive.from_toml, cbpt.Case.from_toml):
        with pytest.raises(CaseError, match=r"^<text>:2: found a lone surrogate"):
            read("# é\nkind = '\ud800'")


@examples(150)
@given(st.data())
def test_no_text_makes_a_panic(data: st.DataObject) -> None:
    """A case file with a piece cut out, doubled or replaced is read or refused by line."""
    text = cbpt.example_case()
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 40)))
    piece = data.draw(st.one_of(st.just(""), st.just(text[start:end] * 2), st.text(max_size=12)))
    try:
        whole = cbpt.Case.from_toml(text[:start] + piece + text[end:])
    except CaseError as error:
        assert "<text>" in str(error)
    else:
        # The counts of balls may have become large, so nothing is solved here.
        assert cbpt.Case.from_toml(whole.to_toml()) == whole


@examples(300)
@given(NUMBERS, NUMBERS, NUMBERS)
def test_no_load_makes_a_panic(torque: float, preload: float, angle: float) -> None:
    """Finite torque and angle and a finite preload above 0 are a load; all else is refused."""
    drive = BASE

    def size(value: float) -> float:
        try:
            return float(value)
        except OverflowError:
            return math.inf

    torque_is, preload_is, angle_is = size(torque), size(preload), size(angle)
    valid = math.isfinite(torque_is) and math.isfinite(angle_is)
    valid = valid and 0 < preload_is < math.inf
    if not valid:
        refused = (InvalidInputError, OverflowError)
        with pytest.raises(refused):
            drive.solve(torque, preload, angle)
        with pytest.raises(refused):
            solve_many(drive, [1.0, torque], preload, angle)
        return
    s = drive.solve(torque, preload, angle)
    many = solve_many(drive, torque, preload, angle)
    assert many.status == s.status
    if s.has_solution:
        assert s.elastic_angle_rad is not None
        assert math.isfinite(s.elastic_angle_rad)
        assert many.elastic_angle_rad == pytest.approx(s.elastic_angle_rad, rel=1e-12)
    else:
        assert s.elastic_angle_rad is None
        assert np.isnan(many.elastic_angle_rad)
    assert s.message
    assert repr(s)
    json.loads(s.to_json())
    drive.preload(torque, angle)


@examples(100)
@given(ANYTHING)
def test_an_argument_of_another_type_is_refused(value: Any) -> None:
    if isinstance(value, (int, float)):
        return
    for call in (
        lambda: BASE.solve(value, 600),
        lambda: BASE.solve(5, value),
        lambda: BASE.solve(5, 600, value),
        lambda: BASE.preload(value),
        lambda: BASE.largest_elastic_angle(5, value),
    ):
        # A torsion spring takes no preload, so None is a number that is missing, not a wrong type.
        with pytest.raises((TypeError, InvalidInputError)):
            call()


def test_a_load_that_cannot_be_is_named() -> None:
    """The message names the number, with its place where there are many."""
    for bad in (math.nan, math.inf, -math.inf):
        with pytest.raises(InvalidInputError, match="torque_Nm"):
            BASE.solve(bad, 600)
        with pytest.raises(InvalidInputError, match="torque_Nm"):
            BASE.preload(bad)
        with pytest.raises(InvalidInputError, match="input_angle"):
            BASE.solve(5, 600, bad)
        with pytest.raises(InvalidInputError, match=r"torque_Nm\[2\]"):
            solve_many(BASE, [1, 2, bad], 600)
    for bad in (0.0, -600.0, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="preload_N"):
            BASE.solve(5, bad)
        with pytest.raises(InvalidInputError, match="preload_N"):
            BASE.largest_elastic_angle(5, bad)
        with pytest.raises(InvalidInputError, match=r"preload_N\[1\]"):
            solve_many(BASE, 5, [600, bad])
    with pytest.raises(ValueError, match="broadcast"):
        solve_many(BASE, [1, 2], [1, 2, 3])


@pytest.mark.parametrize("read", [cbpt.Case.from_file, cbpt.Drive.from_file])
def test_a_path_that_no_file_can_have(read: Any) -> None:
    with pytest.raises(cbpt.CaseError, match="no file can have this name"):
        read("\ud800.toml")
