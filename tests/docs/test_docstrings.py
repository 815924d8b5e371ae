"""Docstrings of what `cbpt` exports: a first line, numpydoc sections, examples that run."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import cbpt
from cbpt import effects

MOST_ARGUMENTS = 2  # with more, a docstring has the sections Parameters and Returns
SECTION = re.compile(r"^([A-Z][a-z]+)\n-{3,}$", re.MULTILINE)
PARAMETER = re.compile(r"^(\w+(?:, \w+)*) : \S", re.MULTILINE)


def exported() -> Iterator[tuple[str, Any]]:
    """Name and object of everything public that can be called, methods included."""
    for module in (cbpt, effects):
        for name in module.__all__:
            value = getattr(module, name)
            if inspect.isclass(value):
                yield name, value
                for inner, member in vars(value).items():
                    function = getattr(member, "__func__", member)
                    if not inner.startswith("_") and callable(function):
                        yield f"{name}.{inner}", function
            elif inspect.isroutine(value):
                yield name, value


EXPORTED = list(exported())
FUNCTIONS = [(name, value) for name, value in EXPORTED if inspect.isfunction(value)]


def arguments(function: Any) -> list[str]:
    return [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]


def parts(text: str) -> dict[str, str]:
    """The sections of a docstring by their titles."""
    cut = SECTION.split(inspect.cleandoc(text))
    return dict(zip(cut[1::2], cut[2::2], strict=True))


@pytest.mark.parametrize(("name", "value"), EXPORTED, ids=[name for name, _ in EXPORTED])
def test_the_first_line_is_a_sentence(name: str, value: Any) -> None:
    first = (inspect.getdoc(value) or "").partition("\n\n")[0]
    assert first.endswith((".", ":")), f"{name}: {first!r}"


@pytest.mark.parametrize(("name", "function"), FUNCTIONS, ids=[name for name, _ in FUNCTIONS])
def test_many_arguments_have_sections(name: str, function: Any) -> None:
    wanted = arguments(function)
    found = parts(function.__doc__ or "")
    if len(wanted) > MOST_ARGUMENTS:
        assert {"Parameters", "Returns"} <= set(found), name
    if "Parameters" in found:
        groups = PARAMETER.findall(found["Parameters"])
        assert [one for group in groups for one in group.split(", ")] == wanted, name


def test_missing_sections_are_seen() -> None:
    assert parts("One line.\n\nParameters\n----------\nx : int\n    A number.\n") == {
        "Parameters": "\nx : int\n    A number."
    }
    assert parts("Parameters: none") == {}


# --- examples -----------------------------------------------------------------------------

# Modules with examples in their docstrings; those of pages are run by test_readme.py.
WITH_EXAMPLES = ["cbpt", "cbpt.effects", "cbpt.results", "cbpt.lab.readings.reader"]


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples_run(name: str) -> None:
    ran = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert ran.attempted and not ran.failed


def test_no_example_is_left_out() -> None:
    package = Path(cbpt.__file__).parent
    found = set()
    for path in package.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        docs = [
            ast.get_docstring(node) or ""
            for node in ast.walk(ast.parse(text))
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        ]
        if any(">>> " in doc for doc in docs):
            module = ".".join(("cbpt", *path.relative_to(package).with_suffix("").parts))
            found.add(module.removesuffix(".__init__"))
    assert sorted(found) == sorted(WITH_EXAMPLES)
