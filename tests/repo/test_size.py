"""No file, no function and no list of arguments longer than a reader can hold.

What is longer stands here with its reason, and nothing else does. (Functions in Rust: clippy.toml.)
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

TOP = Path(__file__).parents[2]
CODE = (".py", ".pyi", ".rs", ".js", ".ts", ".css", ".html", ".md", ".toml", ".json", ".c")
MOST_LINES = 600
MOST_LINES_OF_A_FUNCTION = 60
MOST_ARGUMENTS = 6

_PUBLIC = "public: a few arguments by place, options by name alone"

FILES = {
    "python/cbpt/_core.pyi": "made by the build",
    "python/cbpt/page/web/types.d.ts": "made from page/document/types.py",
}
FUNCTIONS: dict[str, str] = {}
ARGUMENTS = {
    "python/cbpt/design/front.py pareto_front": _PUBLIC,
    "python/cbpt/design/optimise.py optimise": _PUBLIC,
    "python/cbpt/design/tolerance.py tolerance": _PUBLIC,
    "python/cbpt/lab/change/change.py change": _PUBLIC,
    "python/cbpt/lab/characteristics/characterise.py characterise": _PUBLIC,
    "python/cbpt/lab/diagnosis/by_level.py diagnose_by": _PUBLIC,
    "python/cbpt/lab/diagnosis/compare.py compare": _PUBLIC,
    "python/cbpt/lab/diagnosis/diagnose.py diagnose": _PUBLIC,
    "python/cbpt/lab/experiment/shortest_plan.py shortest_plan": _PUBLIC,
    "python/cbpt/lab/readings/reader.py read_readings": _PUBLIC,
    "python/cbpt/sweeps/run.py sweep": _PUBLIC,
}

Function = ast.FunctionDef | ast.AsyncFunctionDef


def sources(*endings: str) -> Iterator[Path]:
    """Files of the repository by their ending, without what a build or a checkout leaves."""
    for part in (".ci", "benches", "crates", "docs", "examples", "python", "tests", ""):
        found = (TOP / part).rglob("*") if part else TOP.glob("*")
        for path in sorted(found):
            if path.suffix in endings and not {"node_modules", "target"} & set(path.parts):
                yield path


def functions() -> Iterator[tuple[str, Function]]:
    """Every Python function, by file and name."""
    for path in sources(".py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, Function):
                yield f"{path.relative_to(TOP).as_posix()} {node.name}", node


def lines(function: Function) -> int:
    """From its head to its end, what its docstring takes aside."""
    first = function.body[0]
    told = ast.get_docstring(function) is not None
    head = (first.end_lineno or 0) - first.lineno + 1 if told else 0
    return (function.end_lineno or 0) - function.lineno + 1 - head


def arguments(function: Function) -> int:
    """How many a caller may give, `self` and `cls` aside."""
    a = function.args
    names = [one.arg for one in (*a.posonlyargs, *a.args, *a.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


def test_files() -> None:
    found = {
        path.relative_to(TOP).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in sources(*CODE)
    }
    assert found
    longer = {name for name, count in found.items() if count > MOST_LINES}
    assert longer == set(FILES)


def test_functions() -> None:
    longer = {name for name, node in functions() if lines(node) > MOST_LINES_OF_A_FUNCTION}
    assert longer == set(FUNCTIONS)


def test_arguments() -> None:
    longer = {name for name, node in functions() if arguments(node) > MOST_ARGUMENTS}
    assert longer == set(ARGUMENTS)
