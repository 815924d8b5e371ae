"""Pages of the documentation that repeat what the program says must say the same."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import jsonschema
import pytest

import cbpt

TOP = Path(__file__).parents[2]
CASES = [*TOP.glob("tests/data/hidden_effect/*.toml"), *TOP.glob("examples/*.toml")]


@cache
def said_by(*arguments: str) -> str:
    command = [sys.executable, "-m", "cbpt.cli.main", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@cache
def validator() -> jsonschema.Draft202012Validator:
    schema = json.loads(said_by("schema"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_page_of_keys_is_the_programs() -> None:
    assert (TOP / "docs/reference/case-file.md").read_text().endswith(said_by("schema", "--keys"))


def test_the_page_of_effects_is_the_programs() -> None:
    assert (TOP / "docs/reference/effects.md").read_text().endswith(said_by("effects", "--page"))


def test_the_schema_knows_the_numbers_of_each_effect() -> None:
    case = tomllib.loads(cbpt.example_case())

    def accepted(**effect: object) -> bool:
        return validator().is_valid(case | {"effect": [effect]})

    for spec in cbpt._core.effect_specs():
        likely = {n.display_name: n.range[0] / n.display_size for n in spec.parameters}
        assert accepted(id=spec.id) and accepted(id=spec.id, port=spec.port, **likely), spec.id
        assert not accepted(id=spec.id, nothing=1.0)
        assert not accepted(id=spec.id, **dict.fromkeys(likely, 1e99))
    assert not accepted(id="crep")
    assert not accepted(id="creep", port="load")
    assert not accepted(id="drift", rate_rad_per_s=0, rate_arcsec_per_h=1)
    assert accepted(id="mine", port="series", expression="0 * torque_Nm")


def test_the_example_is_the_programs() -> None:
    example = (TOP / "examples/base_case.toml").read_text()
    assert example == said_by("schema", "--example") == cbpt.example_case()


# Files of other kinds among the examples.
NO_CASE = ("plan.toml", "bounds.toml", "sweep.toml")


@pytest.mark.parametrize(
    "case",
    [
        *sorted((TOP / "tests/data/hidden_effect").glob("*.toml")),
        *(path for path in sorted(TOP.glob("examples/*.toml")) if path.name not in NO_CASE),
    ],
    ids=lambda path: path.name,
)
def test_the_schema_accepts_what_the_parser_accepts(case: Path) -> None:
    assert validator().is_valid(tomllib.loads(case.read_text()))
    cbpt.Case.from_file(case)


def test_the_schema_refuses_a_misspelt_key() -> None:
    document = tomllib.loads(cbpt.example_case())
    document["deceleration"]["ball_cuont"] = 20
    assert not validator().is_valid(document)
    with pytest.raises(cbpt.CaseError, match="did you mean ball_count"):
        cbpt.Case.from_dict(document)


def test_the_program_of_the_rust_page_is_the_one_that_is_run() -> None:
    program = (TOP / "examples/embed/src/main.rs").read_text()
    assert f"```rust\n{program}```" in (TOP / "docs/reference/rust.md").read_text()
