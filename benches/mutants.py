"""Mutants of the lab's decision: an operator, constant or branch is changed; do tests notice?

    python benches/mutants.py [--part 1/4] [--only decision]

Each mutant lives in a forked process of its own, where the module is compiled from the changed
tree; no file is touched. A mutant that all tests pass has survived, and is told with its line.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import copy
import importlib.abc
import importlib.machinery
import io
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType

import numpy
import pytest
import scipy.linalg
import scipy.optimize
import scipy.stats

TOP = Path(__file__).parents[1]
LOADED = (numpy, scipy)  # before the fork, so that no mutant pays for it
MODULES = {
    "decision": ("tests/lab/test_decision.py",),
    "posterior": ("tests/lab/test_posterior.py", "tests/lab/test_decision.py"),
}
PATIENCE_S = 600
COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
REVERSED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr,
}  # fmt: skip


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """What may stand in the place of a node."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for table in (COMPARISONS, REVERSED):
            if other := table.get(type(node.ops[0])):
                yield ast.Compare(node.left, [other()], node.comparators)
    elif isinstance(node, ast.BinOp) and (sign := ARITHMETIC.get(type(node.op))):
        yield ast.BinOp(node.left, sign(), node.right)
    elif isinstance(node, ast.BoolOp):
        yield ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield node.operand
    elif isinstance(node, ast.IfExp):
        yield node.body
        yield node.orelse
    elif isinstance(node, ast.Constant):
        if isinstance(node.value, bool):
            yield ast.Constant(not node.value)
        elif isinstance(node.value, int | float):
            yield ast.Constant(node.value + 1)


def places(tree: ast.AST) -> Iterator[tuple[ast.AST, str, int | None]]:
    """Every place that holds an expression of a function: its owner, field and number in a list."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for owner in (part for line in function.body for part in ast.walk(line)):
                for field, value in ast.iter_fields(owner):
                    for place, child in enumerate(value if isinstance(value, list) else [value]):
                        if isinstance(child, ast.expr):
                            yield owner, field, place if isinstance(value, list) else None


def mutants(text: str) -> Iterator[tuple[str, ast.Module]]:
    """Each change of a module, as its line with what stood and what stands there, and as a tree."""
    seen = set()
    for number, _ in enumerate(places(ast.parse(text))):
        tree = ast.parse(text)
        owner, field, place = list(places(tree))[number]
        held = getattr(owner, field)
        child = held if place is None else held[place]
        for other in changes(child):
            copied = copy.deepcopy(other)
            ast.copy_location(copied, child)
            told = f"{child.lineno}: {ast.unparse(child)} -> {ast.unparse(other)}"
            if (told, child.col_offset) in seen:
                continue
            seen.add((told, child.col_offset))
            if place is None:
                setattr(owner, field, copied)
            else:
                held[place] = copied
            yield told, ast.fix_missing_locations(copy.deepcopy(tree))


class Changed(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports one module from a tree."""

    def __init__(self, name: str, path: Path, tree: ast.Module) -> None:
        self.name, self.path, self.tree = name, path, tree

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != self.name:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, origin=str(self.path))

    def exec_module(self, module: ModuleType) -> None:
        exec(compile(self.tree, str(self.path), "exec"), module.__dict__)


def outcome(name: str, path: Path, tree: ast.Module, tests: Sequence[str]) -> str:
    """How the tests end with a module changed; a crash of the process says nothing of them."""
    child = os.fork()
    if child == 0:
        code = 3  # whatever ends the tests
        try:
            signal.alarm(PATIENCE_S)
            sys.meta_path.insert(0, Changed(name, path, tree))
            with (
                contextlib.redirect_stdout(io.StringIO()),
                contextlib.redirect_stderr(io.StringIO()),
            ):
                code = pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests])
        finally:
            os._exit(int(code))
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    return {0: "survived", 1: "killed", 2: "killed", -signal.SIGALRM: "killed"}.get(code, "crashed")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--part", default="1/1", help="the K-th of every N mutants: K/N")
    parser.add_argument("--only", choices=MODULES)
    options = parser.parse_args()
    part, parts = map(int, options.part.split("/"))
    os.chdir(TOP)
    began = time.perf_counter()
    for module, tests in MODULES.items():
        if options.only not in (None, module):
            continue
        path = TOP / f"python/cbpt/lab/selection/{module}.py"
        all_of_it = list(mutants(path.read_text(encoding="utf-8")))
        tried = all_of_it[part - 1 :: parts]
        name = f"cbpt.lab.selection.{module}"
        if outcome(name, path, ast.parse(path.read_text(encoding="utf-8")), tests) != "survived":
            raise SystemExit(f"{module}: the tests fail without any change")
        ends: Counter[str] = Counter()
        for told, tree in tried:
            end = outcome(name, path, tree, tests)
            ends[end] += 1
            if end != "killed":
                print(f"{end:<9} {module}.py:{told}", flush=True)
        counts = ", ".join(f"{count} {end}" for end, count in ends.items())
        seconds = time.perf_counter() - began
        print(
            f"{module}: {len(tried)} of {len(all_of_it)} tried, {counts} ({seconds:.0f} s)",
            flush=True,
        )


if __name__ == "__main__":
    main()
