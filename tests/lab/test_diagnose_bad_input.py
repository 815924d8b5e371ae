"""Readings that cannot be right, or hardly tell anything: an answer or an error that helps.

Never a traceback, never a hang, never a name that is certain and false. Groups: refused; answered
with care; wrong units and wrong drives; size.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cbpt import Case
from cbpt.errors import CbptError, ReadingsError
from cbpt.lab.diagnosis.diagnose import MOST, diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from common import mostly_long
from common.hidden import ANGLE, Columns, U, case_of, table_of

BAD = ["dev01", "dev03"]
BEARING = "eccentric_bearing"
TRUE = {"dev01": set[str](), "dev03": {BEARING}}
RAD = 180 * 3600 / np.pi
Change = Callable[[Columns], Columns]


def with_(table: Columns, **columns: Any) -> Columns:
    return {**table, **columns}


def outcome(name: str, change: Change, case: str | None = None) -> Diagnosis | CbptError:
    """The answer, dressed in every form, or the error; anything else raised is a failure."""
    try:
        found = diagnose(Case.from_toml(case or case_of(name)), change(table_of(name)))
    except CbptError as error:
        return error
    assert found.to_json() and found.report()
    return found


def wrong(found: Diagnosis | CbptError, true: set[str]) -> str:
    """A name that is false and told with confidence; empty where there is none."""
    if isinstance(found, CbptError):
        return ""
    v = found.verdict
    sure = v.kind in ("effect", "parameter") and v.probability > 0.75
    return (
        f"{v.kind} {v.effects} {v.probability:.2f}" if sure and not set(v.effects) <= true else ""
    )


# --- refused ------------------------------------------------------------------------------


def beyond(table: Columns, share: float) -> Columns:
    return with_(table, preload_N=table["preload_N"] * share)


def gap(table: Columns) -> Columns:
    angle = table[ANGLE].copy()
    angle[4] = np.nan
    return with_(table, **{ANGLE: angle})


def twice(table: Columns) -> Columns:
    clock = table["time_s"].copy()
    clock[4] = clock[3]
    return with_(table, time_s=clock)


REFUSED: dict[str, tuple[Change, str, str]] = {
    "two rows": (
        lambda t: {k: v[:2] for k, v in t.items()},
        "elastic_angle",
        "at least 6",
    ),
    "torque constant": (
        lambda t: with_(t, torque_Nm=0 * t["torque_Nm"] + 3),
        "torque",
        "a column that varies",
    ),
    "a cell is NaN": (gap, ANGLE, "a finite number"),
    "one time twice": (twice, "time_s", "a different time"),
    "u is 0": (lambda t: with_(t, **{U: 0 * t[U]}), U, "above 0"),
    "torque in N mm": (lambda t: with_(t, torque_Nm=1000 * t["torque_Nm"]), "torque", "solution"),
    "preload in kN": (lambda t: beyond(t, 1e-3), "torque", "solution"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_refused(what: str) -> None:
    change, column, expected = REFUSED[what]
    error = outcome("dev03", change)
    assert isinstance(error, ReadingsError)
    assert column in error.column and expected in error.expected


@pytest.mark.parametrize("what", [w for w in REFUSED if w != "one time twice"])
def test_an_error_says_what_to_do(what: str) -> None:
    error = outcome("dev03", REFUSED[what][0])
    assert isinstance(error, ReadingsError)
    assert error.mistakes[0].remedy


@pytest.mark.parametrize("what", REFUSED)
def test_no_column_that_is_there_is_called_missing(what: str) -> None:
    assert "no such column" not in str(outcome("dev03", REFUSED[what][0]))


@pytest.mark.parametrize("what", ["torque in N mm", "preload in kN"])
def test_a_preload_that_holds_nothing_is_called_so(what: str) -> None:
    assert "preload" in str(outcome("dev03", REFUSED[what][0]))


# --- answered with care -------------------------------------------------------------------


def some_beyond(table: Columns) -> Columns:
    preload = table["preload_N"].copy()
    preload[10:20] /= 20
    return with_(table, preload_N=preload)


def one_level(table: Columns) -> Columns:
    here = table["preload_N"] == table["preload_N"].min()
    return {k: v[here] for k, v in table.items()}


def without(*names: str) -> Change:
    return lambda table: {k: v for k, v in table.items() if k not in names}


ANSWERED: dict[str, tuple[Change, str]] = {
    "some readings beyond the preload": (some_beyond, "left out"),
    "preload is the same": (one_level, "preload is the same"),
    "no uncertainty": (without(U), "uncertainty"),
    "no runs and no time": (without("run", "time_s", "temperature_degC"), "no run column"),
    "runs of one reading": (lambda t: with_(t, run=np.arange(float(len(t["run"])))), ""),
    "six readings": (lambda t: {k: v[1:7] for k, v in t.items()}, "preload is the same"),
}


@pytest.mark.parametrize("name", mostly_long(BAD, ["dev03"]))
@pytest.mark.parametrize("what", ANSWERED)
def test_answered(what: str, name: str) -> None:
    change, note = ANSWERED[what]
    found = outcome(name, change)
    assert isinstance(found, Diagnosis), found
    assert note in " ".join(found.notes)
    v = found.verdict
    assert not wrong(found, TRUE[name]) and set(v.effects) <= TRUE[name]
    assert v.kind in ("complete", "effect", "ambiguous", "undecided")


def test_readings_set_aside_are_told_by_line() -> None:
    found = outcome("dev03", some_beyond)
    assert isinstance(found, Diagnosis) and len(found.readings) < 396
    note = next(n for n in found.notes if "left out" in n)
    assert "the preload does not hold the torque" in note and "11, 12" in note


def test_a_zero_for_each_run() -> None:
    for name in BAD:
        case = case_of(name) + '\n[measurement]\nzero = "per_run"\n'
        found = outcome(name, lambda t: t, case)
        assert isinstance(found, Diagnosis)
        told = set(found.verdict.effects).union(*found.verdict.rivals)
        # Without the zero of the angle a joint that stiffens may do for the bearing.
        assert TRUE[name] <= told <= TRUE[name] | {"output_torsion"}


# --- wrong units and wrong drives ---------------------------------------------------------

ODD: dict[str, Change] = {
    "torque in kN m": lambda t: with_(t, torque_Nm=t["torque_Nm"] / 1000),
    "preload in mN": lambda t: beyond(t, 1000),
    "angle and u in rad": lambda t: with_(t, **{ANGLE: t[ANGLE] / RAD, U: t[U] / RAD}),
    "angle in rad": lambda t: with_(t, **{ANGLE: t[ANGLE] / RAD}),
    "angle in urad": lambda t: with_(t, **{ANGLE: t[ANGLE] * 1e6 / RAD, U: t[U] * 1e6 / RAD}),
    "angle a fifth": lambda t: with_(t, **{ANGLE: t[ANGLE] / 5, U: t[U] / 5}),
    "angle in arcmin": lambda t: with_(t, **{ANGLE: t[ANGLE] / 60, U: t[U] / 60}),
    "angle reversed": lambda t: with_(t, **{ANGLE: -t[ANGLE]}),
    "angle constant": lambda t: with_(t, **{ANGLE: 0 * t[ANGLE] + 20}),
    "angle 0": lambda t: with_(t, **{ANGLE: 0 * t[ANGLE]}),
    "u a thousandth": lambda t: with_(t, **{U: t[U] / 1000}),
    "u a thousand times": lambda t: with_(t, **{U: t[U] * 1000}),
    "random angles": lambda t: with_(t, **{ANGLE: np.random.default_rng(1).normal(0, 9, 396)}),
}


@pytest.mark.parametrize("name", mostly_long(BAD, ["dev03"]))
@pytest.mark.parametrize("what", ODD)
def test_odd_readings_name_nothing_for_certain(what: str, name: str) -> None:
    assert not wrong(outcome(name, ODD[what]), TRUE[name])


@pytest.mark.parametrize("balls", mostly_long([14, 17, 22], [17]))
def test_another_drive(balls: int) -> None:
    """Readings of a drive with other balls than the case says."""
    case = case_of("dev01").replace("ball_count = 20", f"ball_count = {balls}")
    assert case != case_of("dev01")
    assert not wrong(outcome("dev01", lambda t: t, case), set())


# --- size ---------------------------------------------------------------------------------


def test_a_hundred_thousand_readings() -> None:
    """The bearing's own angles over and over, with noise that does not come back."""
    table, n = table_of("dev03"), 100_000
    clean = diagnose(Case.from_toml(case_of("dev03")), table).model_after_arcsec
    turns = np.arange(n) // 396
    many = {k: np.resize(v, n) for k, v in table.items()}
    many["run"] += 100.0 * turns
    many["time_s"] += 1e5 * turns
    many[ANGLE] = np.resize(clean, n) + np.random.default_rng(0).normal(0, 0.3, n)
    found = diagnose(Case.from_toml(case_of("dev03")), many)
    assert len(found.readings) <= MOST, "what takes long is done on these"
    assert set(found.verdict.effects).union(*found.verdict.rivals) <= {BEARING, "output_torsion"}
    assert BEARING in {*found.verdict.effects, *(e for g in found.verdict.rivals for e in g)}
    assert "100000 readings" in " ".join(found.notes)
