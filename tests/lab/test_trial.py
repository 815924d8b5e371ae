"""A short trial on fixed seeds, and the score itself.

Groups: the trial; the score; which campaigns are drawn. The long trial is benches/trial.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbpt import Case
from cbpt.lab.diagnosis.diagnose import diagnose
from common import mostly_long
from reference.rig.noise import NOISE_KINDS
from trial import answers
from trial.families import FAMILIES, SINGLES, STRENGTHS, Family, make_trial
from trial.grades import Outcome, contains, grade, named, true_statement
from trial.oracle import ask
from trial.run import indices, tasks
from trial.score import document, intervals, measures, table, wilson
from trial.targets import calibration

SEED = 1


# --- the trial ----------------------------------------------------------------------------


@cache
def outcome(family: Family, index: int) -> Outcome:
    """A campaign diagnosed; nothing is kept on disk."""
    made = make_trial(family, index, SEED)
    made.truth["duration_s"] = float(np.ptp(made.rows.time_s))
    found = diagnose(Case.from_toml(made.to_toml()), made.columns())
    return {"family": family, "index": index, "truth": made.truth, **answers.answered(found)}


BY_CHANCE = pytest.mark.xfail(
    strict=True, reason="a coarse display: play is named at 0.951, one of the false alarms in 20"
)
NOTHING = [
    pytest.param(i, marks=BY_CHANCE) if kind == "quantised" else i
    for i, kind in enumerate(NOISE_KINDS)
]


@pytest.mark.parametrize("index", NOTHING)
def test_nothing_is_named_where_nothing_is_hidden(index: int) -> None:
    found = outcome("null", index)
    assert grade(found) == "right", (found["truth"]["noise"]["kind"], found["answer"])


CLEAR: list[tuple[Family, int]] = [
    ("single", 80),  # run_in
    ("single", 82),  # friction_hysteresis
    ("single", 86),  # wear
    ("single", 90),  # rough_contact, made by a soft layer
    ("single", 100),  # friction_hysteresis that rises with the rate
    ("pair", 4),  # thermal_preload, drift
]


# A simple one, one that is made by other laws than the library has, and a pair.
SHORT = [CLEAR[1], CLEAR[3], CLEAR[5]]


@pytest.mark.parametrize(("family", "index"), mostly_long(CLEAR, SHORT))
def test_the_truth_is_in_the_answer(family: Family, index: int) -> None:
    """Singles of strength 12 and 20, and a pair."""
    found = outcome(family, index)
    assert contains(found["answer"], found["truth"]["answer"]["effects"]), found["answer"]
    assert found["held_out"]["after"] < found["held_out"]["refitted"]


@pytest.mark.parametrize("index", mostly_long([24, 25], [24]))
def test_what_no_library_holds_is_unknown(index: int) -> None:
    found = outcome("outside", index)
    assert found["truth"]["d"] >= 20 and found["answer"]["kind"] == "unknown", found["answer"]


def test_a_softer_contact_is_a_number_of_the_drive() -> None:
    assert grade(outcome("parameter_only", 1)) == "right"


def test_an_undecided_answer_is_none_for_the_calibration() -> None:
    """Nine readings."""
    found = outcome("confounded", 3)
    assert found["answer"]["undecided"]
    assert math.isnan(calibration([found])[-1].value)


def test_exact_twins_are_told_as_rivals() -> None:
    assert grade(outcome("confounded", 0)) == "right"


def test_an_effect_is_the_same_wherever_it_stands_in_the_library(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(answers, "KEPT", tmp_path)
    for folder in (answers.rig_folder, answers.answer_folder):
        folder.cache_clear()
    both = answers.shuffled(("confounded", 0, SEED))
    assert both and both[0] == both[1]
    for folder in (answers.rig_folder, answers.answer_folder):
        folder.cache_clear()


@pytest.mark.long
def test_the_oracle_knows() -> None:
    index = SINGLES.index("creep") + 3 * len(SINGLES)
    made = make_trial("single", index, SEED)
    found = ask(made, draws=1)
    assert found.names == "creep" and 0 < max(found.rivals.values()) < 1
    assert found.held_out_arcsec == pytest.approx(made.truth["noise"]["u_arcsec"], rel=0.2)


# --- the score ----------------------------------------------------------------------------


def made_up(
    family: str, truth: dict[str, Any], answer: tuple[str, list[str], list[list[str]]], p: float = 1
) -> Outcome:
    kind, effects, rivals = answer
    said = {"kind": kind, "effects": effects, "rivals": rivals, "probability": p}
    return {"family": family, "index": 0, "truth": {"answer": truth, "d": 8.0}, "answer": said}


CREEP = {"kind": "effect", "effects": ["creep"], "rivals": [], "also_right": [["creep", "wear"]]}
NULL = {"kind": "complete", "kinds": ["complete"], "effects": [], "rivals": []}
OUT = {"kind": "unknown", "effects": [], "rivals": []}
GRADES = [
    ("single", CREEP, ("effect", ["creep"], []), "right", True),
    ("single", CREEP, ("ambiguous", [], [["creep", "wear"]]), "contains", True),
    ("single", CREEP, ("ambiguous", ["drift"], [["creep", "wear"]]), "contains", False),
    ("single", CREEP, ("effect", ["creep", "drift"], []), "contains", False),
    ("single", CREEP, ("effect", ["wear"], []), "twin", False),
    ("single", CREEP, ("effect", ["drift"], []), "wrong", False),
    ("single", CREEP, ("complete", [], []), "missed", False),
    ("single", CREEP, ("rig", ["run_offset"], []), "missed", False),
    ("single", CREEP, ("unknown", [], []), "unknown", False),
    ("null", NULL, ("complete", [], []), "right", True),
    ("null", NULL, ("rig", ["run_offset"], []), "wrong", False),
    ("null", NULL, ("ambiguous", [], [["creep", "wear"]]), "wrong", False),
    ("outside", OUT, ("unknown", [], []), "right", True),
    ("outside", OUT, ("ambiguous", [], [["creep", "unknown"]]), "contains", True),
    ("outside", OUT, ("effect", ["creep"], []), "wrong", False),
    ("outside", OUT, ("complete", [], []), "missed", False),
]


@pytest.mark.parametrize(("family", "truth", "answer", "wanted", "true"), GRADES)
def test_grade(family: str, truth: Any, answer: Any, wanted: str, true: bool) -> None:
    found = made_up(family, truth, answer)
    assert (grade(found), true_statement(found)) == (wanted, true)


def test_two_of_one_group_are_not_both_picked() -> None:
    answer = {"effects": [], "rivals": [["creep", "wear"]]}
    assert contains(answer, ["wear"]) and not contains(answer, ["creep", "wear"])
    assert not named(answer)


def test_wilson() -> None:
    """Wilson's interval by its definition: the shares p at which |k/n - p| is z sigma(p)."""
    for hits, n in ((0, 10), (3, 17), (19, 20), (400, 400)):
        for p in wilson(hits, n):
            if 0 < p < 1:
                assert abs(hits / n - p) == pytest.approx(1.959964 * math.sqrt(p * (1 - p) / n))
    assert wilson(0, 0) == (0.0, 1.0)


def test_every_measure_stands_in_the_table() -> None:
    names = {m.name.strip() for m in measures([])}
    assert {"held-out error fall", "contains the truth", "Brier score", "no answer"} <= names
    some = [made_up("outside", OUT, ("unknown", [], []), p) for p in (0.5, 0.97, 1.0)]
    found = {(m.name, m.where): m for m in measures(some)}
    assert found["outside: says unknown", "d >= 12"].sets == 0
    assert found["Brier score", "all"].value == pytest.approx((0.25 + 0.03**2) / 3)
    error = (0.5 + 0.03) / 3
    assert found["expected calibration error", "all"].value == pytest.approx(error)
    assert "Brier score" in table(measures(some)) and document(some)["sets"] == 3


def test_an_interval_is_held_against_the_true_value() -> None:
    found = {
        **made_up("single", CREEP, ("effect", ["creep"], [])),
        "parameters": {"creep": {"compliance_rad_per_Nm": {"value": 6e-7, "u": 1e-8}}},
    }
    values = {"rate_rad_per_Nm": 6.1e-7, "tau_s": 3.0}
    found["truth"] |= {
        "hidden": [{"id": "creep", "form": "library", "values": values}],
        "duration_s": 9.0,
    }
    assert intervals([found]) == [("creep.compliance_rad_per_Nm", True)]
    values["rate_rad_per_Nm"] = 6.3e-7
    assert intervals([found]) == [("creep.compliance_rad_per_Nm", False)]


# --- which campaigns are drawn ------------------------------------------------------------


def test_a_full_round_has_every_effect_at_every_strength() -> None:
    drawn = indices("single", len(SINGLES))
    assert sorted(drawn) == list(range(len(SINGLES) * len(STRENGTHS)))
    assert sorted(indices("outside", 8)) == list(range(40))
    assert len({i % len(SINGLES) for i in indices("single", 3)}) >= 9


def test_families_are_interleaved() -> None:
    work = tasks(FAMILIES, 3, SEED)
    assert len(set(work)) == len(work)
    assert {family for family, _, _ in work[: len(work) // 3]} == set(FAMILIES)
