"""Saved answers: those of this version, those of the first schema, and files that are none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import cbpt
from common.hidden import diagnosed

TOP = Path(__file__).parents[2]
FIRST = TOP / "tests" / "data" / "answers" / "schema_1.json"
SCHEMA = TOP / "docs" / "reference" / "answer.schema.json"


def test_an_answer_of_today_is_read_as_it_was_written(tmp_path: Path) -> None:
    written = diagnosed("dev04").to_json()
    path = tmp_path / "answer.json"
    path.write_text(written, encoding="utf-8")
    assert cbpt.read_answer(path) == json.loads(written)
    given = json.loads(written)
    found = cbpt.read_answer(given)
    found["verdict"]["kind"] = "changed by the caller"
    assert given["verdict"]["kind"] == "effect"


def test_an_answer_of_the_first_schema_has_the_keys_of_today_and_nothing_new() -> None:
    before: dict[str, Any] = json.loads(FIRST.read_text(encoding="utf-8"))
    found = cbpt.read_answer(FIRST)
    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8"))).validate(found)
    assert found["schema"] == "cbpt.diagnosis/2" and before["schema"] == "cbpt.diagnosis/1"
    kept = ("kind", "effects", "rivals", "probability", "sentence", "rests_on")
    assert {k: found["verdict"][k] for k in kept} == {k: before["verdict"][k] for k in kept}
    same = before.keys() - {"schema", "verdict", "next_run", "notes"}
    assert same and {k: found[k] for k in same} == {k: before[k] for k in same}
    same = before["next_run"].keys() - {"gain"}
    assert {k: found["next_run"][k] for k in same} == {k: before["next_run"][k] for k in same}
    assert found["next_run"]["largest_gain"] == before["next_run"]["gain"]
    # What was not told is nothing, and the reader is told so.
    assert found["verdict"]["probability_exactly"] is None and found["verdict"]["undecided"] is None
    assert (found["combinations"], found["why"], found["remains"]) == ([], [], None)
    assert found["verdict"]["perhaps"] == [] and "cbpt.diagnosis/1" in found["notes"][-1]


def test_the_gain_of_an_earlier_second_schema_is_what_it_meant() -> None:
    given = json.loads(diagnosed("dev03").to_json())
    largest = given["next_run"].pop("largest_gain")
    given["next_run"]["gain"] = largest
    found = cbpt.read_answer(given)["next_run"]
    assert (found["gain"], found["largest_gain"]) == (None, largest)


def test_an_answer_of_the_first_schema_without_a_next_run_has_none() -> None:
    before: dict[str, Any] = json.loads(FIRST.read_text(encoding="utf-8"))
    assert cbpt.read_answer({**before, "next_run": None})["next_run"] is None
    assert cbpt.read_answer({**before, "next_run": {}})["next_run"]["largest_gain"] is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "line 1: no JSON"),
        ("[1]", "expected one JSON object"),
        ("{}", "schema is None"),
        ('{"schema": "cbpt.diagnosis/3"}', "newer version"),
        ('{"schema": "cbpt.diagnosis/2", "verdict": 1}', "not whole"),
        ('{"schema": "cbpt.diagnosis/1", "verdict": {"kind": "effect"}}', "not whole"),
    ],
)
def test_what_is_no_answer_names_the_file_and_the_remedy(
    tmp_path: Path, text: str, says: str
) -> None:
    path = tmp_path / "wrong.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(cbpt.InvalidInputError, match=says) as raised:
        cbpt.read_answer(path)
    assert "wrong.json" in str(raised.value)


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(cbpt.InvalidInputError, match=r"none\.json: No such file"):
        cbpt.read_answer(tmp_path / "none.json")
    binary = tmp_path / "binary.json"
    binary.write_bytes(b"\xff\xfe\x00{")
    with pytest.raises(cbpt.InvalidInputError, match="not UTF-8"):
        cbpt.read_answer(binary)
