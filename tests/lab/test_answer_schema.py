"""The JSON Schema of the answer: what a diagnosis writes is what the schema says."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import cbpt
from common.hidden import diagnosed

TOP = Path(__file__).parents[2]
SCHEMA = TOP / "docs" / "reference" / "answer.schema.json"
# Between them: every kind of answer, rivals with a next run, repeats, a misfit without a name.
REPEATED = "simulated, with repeats"
CAMPAIGNS = ("dev01", "dev02", "dev05", "dev09", "dev10", "dev12", REPEATED)


@cache
def schema() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(SCHEMA.read_text(encoding="utf-8"))
    return found


@cache
def answer(name: str) -> dict[str, Any]:
    if name == REPEATED:
        case = TOP / "examples" / "campaign.toml"
        torque_Nm = np.tile([0, 2, 4, 6, 8, 6, 4, 2], 4)
        plan = {"torque_Nm": torque_Nm, "preload_N": np.full(len(torque_Nm), 600.0)}
        found = cbpt.diagnose(case, cbpt.simulate(case, plan, u_elastic_angle_arcsec=0.3))
    else:
        found = diagnosed(name)
    document: dict[str, Any] = json.loads(found.to_json())
    return document


def validator() -> jsonschema.Draft202012Validator:
    jsonschema.Draft202012Validator.check_schema(schema())
    return jsonschema.Draft202012Validator(schema())


def parts(value: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every schema within the schema, with its place."""
    if isinstance(value, dict):
        if "type" in value or "$ref" in value or "enum" in value:
            yield path, value
        for key, inner in value.items():
            yield from parts(inner, f"{path}/{key}")


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_an_answer_is_as_the_schema_says(name: str) -> None:
    wrong = [f"{list(e.absolute_path)}: {e.message}" for e in validator().iter_errors(answer(name))]
    assert not wrong


def test_the_campaigns_have_every_part_of_an_answer() -> None:
    answers = [answer(name) for name in CAMPAIGNS]
    kinds = {one["verdict"]["kind"] for one in answers}
    assert kinds >= {"effect", "ambiguous", "unknown", "complete", "rig", "parameter"}
    for key in ("moved", "next_run", "unknown", "where", "ranking", "parameters", "notes"):
        assert any(one[key] for one in answers), key
    assert any(one["noise"]["repeats"] for one in answers)


def test_the_schema_refuses_other_documents() -> None:
    document = answer(CAMPAIGNS[0])
    assert not validator().is_valid(document | {"schema": "cbpt.diagnosis/0"})
    assert not validator().is_valid(document | {"more": 1})
    assert not validator().is_valid({k: v for k, v in document.items() if k != "verdict"})
    assert not validator().is_valid(document | {"after": {**document["after"], "rmse_arcsec": "1"}})


def test_every_key_is_explained_and_required() -> None:
    for place, part in parts(schema()):
        if "properties" in part:
            assert set(part["required"]) == set(part["properties"]), place
            assert part["additionalProperties"] is False, place
            assert all(inner.get("description") for inner in part["properties"].values()), place
