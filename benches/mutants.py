"""Mutants of the lab's decision: an operator, constant or branch is changed; do tests notice?

    python benches/mutants.py [--only decision] [--list]

All tests are collected once, and run once to see which of them enter which function. Each mutant
is a forked process in which the changed code takes the place of a function's own; it runs the
tests that enter that function, the quickest first, up to the first that fails. No file is touched.
A mutant that all of them pass has survived, and is told with its line.
"""

from __future__ import annotations

import argparse
import ast
import copy
import gc
import os
import signal
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from functools import partial
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType, FunctionType

import pytest

TOP = Path(__file__).parents[1]
MODULES = ("decision", "posterior")
TESTS = [f"tests/lab/test_{name}.py" for name in (*MODULES, "remains")]
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


def codes(code: CodeType) -> Iterator[tuple[str, CodeType]]:
    """The functions of a module that is compiled, by name; not those inside functions."""
    for inner in code.co_consts:
        if isinstance(inner, CodeType) and "<" not in inner.co_qualname:
            if inner.co_flags & CO_OPTIMIZED:  # a class is none
                yield inner.co_qualname, inner
            yield from codes(inner)


def mutants(path: Path) -> Iterator[tuple[str, str, CodeType]]:
    """Each change of a module: its line with what stood and what stands there, and the one function
    that differs, as its name and its code."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    own = dict(codes(compile(tree, str(path), "exec")))
    seen = set()
    for owner, field, place in list(places(tree)):
        held = getattr(owner, field)
        child = held if place is None else held[place]
        for other in changes(child):
            told = f"{child.lineno}: {ast.unparse(child)} -> {ast.unparse(other)}"
            if (told, child.col_offset) in seen:
                continue
            seen.add((told, child.col_offset))
            copied = ast.fix_missing_locations(ast.copy_location(copy.deepcopy(other), child))
            setattr(owner, field, _with(held, place, copied))
            changed = dict(codes(compile(tree, str(path), "exec")))
            setattr(owner, field, held)
            for name in own:
                if changed[name] != own[name]:
                    yield told, name, changed[name]


def _with(held: object, place: int | None, child: ast.AST) -> object:
    """What an owner holds, with a child in one place."""
    if not isinstance(held, list) or place is None:
        return child
    return [*held[:place], child, *held[place + 1 :]]


# --- tests --------------------------------------------------------------------------------


def passes(item: pytest.Item) -> bool:
    """Whether a test passes; what it has set up is taken down."""
    failed = item.session.testsfailed
    item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
    return item.session.testsfailed == failed


class Mutants:
    """What pytest does with the tests that it has collected, in place of running them."""

    def __init__(self, modules: Sequence[str], only_list: bool) -> None:
        self.modules, self.only_list = modules, only_list

    def pytest_configure(self) -> None:
        from hypothesis import Phase, settings  # pytest wants to be first

        # A case that fails is enough: the least one is not looked for.
        settings.register_profile("first", phases=[Phase.explicit, Phase.generate])
        settings.load_profile("first")

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        paths = {name: TOP / f"python/cbpt/lab/selection/{name}.py" for name in self.modules}
        entered = _entered(session.items, {str(path) for path in paths.values()})
        for name, path in paths.items():
            began = time.perf_counter()
            functions = _functions(path)
            ends: Counter[str] = Counter()
            for told, function, code in mutants(path):
                tests = entered[str(path), function]
                end = "not run" if self.only_list else _outcome(functions[function], code, tests)
                ends[end] += 1
                if end != "killed":
                    print(f"{end:<9} {name}.py:{told}", flush=True)
            counts = ", ".join(f"{count} {end}" for end, count in ends.items())
            print(f"{name}: {ends.total()} mutants, {counts} ({time.perf_counter() - began:.0f} s)")
        return True


def _functions(path: Path) -> dict[str, FunctionType]:
    """The functions that were made of a file, by name."""
    made = (each for each in gc.get_objects() if isinstance(each, FunctionType))
    return {each.__qualname__: each for each in made if each.__code__.co_filename == str(path)}


def _entered(
    items: Sequence[pytest.Item], paths: set[str]
) -> dict[tuple[str, str], list[pytest.Item]]:
    """The tests that enter each function, the quickest first. All must pass."""
    found: dict[tuple[str, str], dict[pytest.Item, float]] = defaultdict(dict)
    for item in items:
        names: set[tuple[str, str]] = set()
        began = time.perf_counter()
        sys.setprofile(partial(_note, paths, names))
        passed = passes(item)
        sys.setprofile(None)
        if not passed:
            raise SystemExit(f"{item.nodeid} fails without any change")
        for name in names:
            found[name][item] = time.perf_counter() - began
    return defaultdict(list, {name: sorted(of, key=of.__getitem__) for name, of in found.items()})


def _note(
    paths: set[str], names: set[tuple[str, str]], frame: FrameType, event: str, _: object
) -> None:
    """Notes a function of these files that is entered; one inside another is the other."""
    code = frame.f_code
    if event == "call" and code.co_filename in paths:
        names.add((code.co_filename, code.co_qualname.split(".<locals>")[0]))


def _outcome(function: FunctionType, code: CodeType, tests: Sequence[pytest.Item]) -> str:
    """How the tests end with a function changed; a crash of the process says nothing of them."""
    child = os.fork()
    if child == 0:
        signal.alarm(PATIENCE_S)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        function.__code__ = code
        os._exit(0 if all(map(passes, tests)) else 1)
    _, status = os.waitpid(child, 0)
    ended = os.waitstatus_to_exitcode(status)
    return {0: "survived", 1: "killed", -signal.SIGALRM: "killed"}.get(ended, "crashed")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", choices=MODULES)
    parser.add_argument("--list", action="store_true", help="the mutants, without any test of them")
    options = parser.parse_args()
    os.chdir(TOP)
    modules = [options.only] if options.only else MODULES
    plugin = Mutants(modules, options.list)
    sys.exit(pytest.main(["-q", "-s", "--tb=no", "-p", "no:cacheprovider", *TESTS], [plugin]))


if __name__ == "__main__":
    main()
