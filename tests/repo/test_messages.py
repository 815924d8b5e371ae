"""No module reads what another has said: the text of an error is passed on, never taken apart.

What a message tells is handed over beside it: attributes of the error, codes, structured remedies.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

TOP = Path(__file__).parents[2]

# What takes a text apart, or asks what it holds.
TAKES_APART = re.compile(
    r"r?(split|partition|find|index)|splitlines|(starts|ends)with|remove(pre|suf)fix"
    r"|replace|match|fullmatch|search|findall|finditer|sub"
)
# Names under which messages go about.
MESSAGES = frozenset(["message", "sentence", "remedy", "words", "why", "reason"])

# An error of another library has nothing but its text.
ALLOWED = {
    "python/cbpt/lab/readings/child.py": "the first line of what a library for files says, shown",
}


def is_message(node: ast.expr, errors: frozenset[str]) -> bool:
    """`str(error)`, `error.args[0]`, an f-string of it, `finding.message`, or made of it."""
    match node:
        case ast.Call(func=ast.Name(id="str" | "repr"), args=[ast.Name(id=name)]):
            return name in errors
        case ast.Subscript(value=ast.Attribute(value=ast.Name(id=name), attr="args")):
            return name in errors
        case ast.Attribute(attr=attr):
            return attr in MESSAGES
        case ast.Subscript(slice=ast.Constant(value=str(key))):
            return key in MESSAGES
        case ast.Name(id=name):
            return name in MESSAGES
        case ast.JoinedStr(values=values):
            return any(
                isinstance(v, ast.FormattedValue)
                and isinstance(v.value, ast.Name)
                and v.value.id in errors
                for v in values
            )
        case ast.Call(func=ast.Attribute(value=value)):
            return is_message(value, errors)
        case ast.BoolOp(values=values):
            return any(is_message(value, errors) for value in values)
    return False


def taken_apart(source: str) -> set[int]:
    """Lines on which a message is split, matched or searched."""
    tree = ast.parse(source)
    errors = frozenset(
        handler.name
        for handler in ast.walk(tree)
        if isinstance(handler, ast.ExceptHandler) and handler.name
    ) | {"error", "exc", "exception"}
    found = set()
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Attribute(value=value, attr=attr), args=args):
                asked = bool(TAKES_APART.fullmatch(attr)) and any(
                    is_message(x, errors) for x in [value, *args]
                )
            case ast.Compare(left=left, ops=ops, comparators=comparators):
                texts = [is_message(each, errors) for each in comparators]
                held = isinstance(left, ast.Constant | ast.JoinedStr) or is_message(left, errors)
                asked = held and any(
                    text
                    for op, text in zip(ops, texts, strict=True)
                    if isinstance(op, ast.In | ast.NotIn)
                )
            case _:
                continue
        if asked:
            found.add(node.lineno)
    return found


def test_no_module_takes_a_message_apart() -> None:
    found = [
        f"{name}:{line}"
        for path in sorted((TOP / "python").rglob("*.py"))
        if (name := path.relative_to(TOP).as_posix()) not in ALLOWED
        for line in sorted(taken_apart(path.read_text(encoding="utf-8")))
    ]
    assert not found, "a message is taken apart; hand over what it tells beside it: " + ", ".join(
        found
    )


def test_what_is_allowed_is_still_needed() -> None:
    for name in ALLOWED:
        assert taken_apart((TOP / name).read_text(encoding="utf-8")), name


@pytest.mark.parametrize(
    "line",
    [
        're.search("x", str(error))',
        '_PATTERN.match(str(error).removeprefix("a"))',
        'error.args[0].split(":")',
        'str(caught).startswith("a")',
        '"a" in str(error)',
        '"no column" in f"{error}"',
        'finding.message.partition(";")[0]',
        'finding["message"].split(";")',
        'if "preload" in remedy: pass',
    ],
)
def test_a_message_taken_apart_is_found(line: str) -> None:
    source = f"try:\n    f()\nexcept ValueError as caught:\n    {line}\n"
    assert taken_apart(source) == {4}


@pytest.mark.parametrize(
    "line",
    [
        'print(f"{error}")',
        "raise Wrong(str(error)) from error",
        'name.split(":")',
        "message in {1}",
    ],
)
def test_a_message_passed_on_is_none(line: str) -> None:
    assert not taken_apart(line + "\n")
