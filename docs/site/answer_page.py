"""The page of the JSON answer: the keys of its JSON Schema as tables, and the schema itself."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

SCHEMA = Path(__file__).parents[1] / "reference" / "answer.schema.json"
HEAD = """\
# JSON answer

`cbpt diagnose CASE DATA --json answer.json` writes one document with everything that the answer
rests on; in Python it is `cbpt.diagnose(...).to_dict()`, and `to_json()` as text. The page of the
workbench shows the same document under its key `answer`.

The JSON Schema is <a href="../answer.schema.json">answer.schema.json</a>. The tests validate the
answers of the development campaigns against it, and `make docs` writes this page from it.

`cbpt.read_answer("answer.json")` reads a saved answer. One of the older schema `cbpt.diagnosis/1`
it returns with the keys of this page: what that schema did not say is null or an empty list, and
a note says so.

"""


def kind_of(schema: Mapping[str, Any], root: Mapping[str, Any]) -> str:
    """The type of a value in words."""
    if "$ref" in schema:
        return kind_of(root["$defs"][schema["$ref"].rpartition("/")[2]], root)
    if "const" in schema:
        return f"`{schema['const']}`"
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"])
    types = schema.get("type", "any")
    names = [types] if isinstance(types, str) else list(types)
    if "array" in names:
        names[names.index("array")] = f"list of {kind_of(schema['items'], root)}s"
    return " or ".join(names)


def rows(
    schema: Mapping[str, Any], root: Mapping[str, Any], path: str = ""
) -> Iterator[tuple[str, str, str]]:
    """Key, type and meaning of everything below an object."""
    for name, value in schema.get("properties", {}).items():
        key = f"{path}{name}"
        described = value.get("description", "")
        yield key, kind_of(value, root), described
        yield from below(value, root, key)


def below(
    value: Mapping[str, Any], root: Mapping[str, Any], key: str
) -> Iterator[tuple[str, str, str]]:
    """The rows of what a value holds."""
    if "$ref" in value:
        value = root["$defs"][value["$ref"].rpartition("/")[2]]
    if "properties" in value:
        yield from rows(value, root, f"{key}.")
    elif "items" in value:
        yield from below(value["items"], root, f"{key}[]")
    elif isinstance(value.get("additionalProperties"), Mapping):
        yield from below(value["additionalProperties"], root, f"{key}.*")


def text() -> str:
    """The page."""
    root = json.loads(SCHEMA.read_text(encoding="utf-8"))
    parts = [HEAD, root["description"], "", "| key | type | meaning |", "|---|---|---|"]
    inner: list[str] = []
    for name, value in root["properties"].items():
        listed = list(below(value, root, name))
        link = f"[`{name}`](#{name})" if listed else f"`{name}`"
        parts.append(f"| {link} | {kind_of(value, root)} | {value.get('description', '')} |")
        if listed:
            inner += [f"## {name}", "", f"{value['description']}.", ""]
            inner += ["| key | type | meaning |", "|---|---|---|"]
            inner += [f"| `{key}` | {kind} | {meaning} |" for key, kind, meaning in listed]
            inner.append("")
    return "\n".join(
        [*parts, "", "`[]` is each item of a list, `*` each key of a table.", "", *inner]
    )


def write(source: Path) -> None:
    """Write the page and the schema into the folder of sources."""
    folder = source / "reference"
    (folder / "answer.md").write_text(text(), encoding="utf-8")
