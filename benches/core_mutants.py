"""Mutants of the mechanics, all in one program: do the tests of the core notice them?

    python benches/core_mutants.py [--shard 0/10] [--python] [--only hertz] [--json OUT.json]

cargo-mutants lists the mutants; it would compile the core once for each. Here all are written into
a copy of the core side by side, each behind the question whether it is the one that is on, so that
it is compiled once and a mutant costs only the tests up to the first that fails. What cannot stand
beside the code as it is (in a `const fn`, in a chain of `let`, of another type) is not tried, and
counted. A shard takes every N-th mutant. Survivors have passed all four programs of tests; with
--python also the tests in Python of the mechanics, on a module that is made of the copy.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import tree_sitter_rust
from tree_sitter import Language, Node, Parser

TOP = Path(__file__).parents[1]
COPY = TOP / "out" / "mutants" / "src"
CORE = "crates/cbpt-core"
PROGRAMS: tuple[tuple[str, ...], ...] = (
    ("cbpt_core",),
    ("mechanics", "--skip=sensitivity", "--skip=lanes"),
    ("effects",),
    ("mechanics", "sensitivity"),
    ("mechanics", "lanes"),
    ("properties",),
)
"""The tests of the core, the quickest first: a program and what it is told."""
IN_PYTHON = ("reference_drives", "as_made_tables", "friction", "effects", "reference", "as_made")
"""Tests of the mechanics in tests/core, the quickest first, which are asked last of all."""
TESTS = {"PROPTEST_CASES": "60", "PROPTEST_MAX_SHRINK_ITERS": "0", "RUSTC_BOOTSTRAP": "1"}
"""The last one lets a program of tests take `--fail-fast`, which is not stable yet."""
OWN_TESTS = ("-p", "cbpt-core", "--tests", "--lib")
MOST_ROUNDS = 30
SWITCH = """
static ACTIVE: std::sync::LazyLock<u32> = std::sync::LazyLock::new(|| {
    std::env::var("MUTANT").ok().and_then(|n| n.parse().ok()).unwrap_or(0)
});
#[inline(always)]
pub(crate) fn on(mutant: u32) -> bool {
    *ACTIVE == mutant
}
"""


@dataclass(frozen=True)
class Program:
    """A program of tests: its command, where it runs."""

    command: list[str]
    folder: Path


@dataclass(frozen=True)
class Mutant:
    """One change, as cargo-mutants lists it; its place in bytes."""

    number: int
    file: str
    name: str
    genre: str
    replacement: str
    start: int
    end: int


def listed() -> list[Mutant]:
    """All mutants of the modules that .cargo/mutants.toml names."""
    found = subprocess.run(
        ["cargo", "mutants", "--list", "--json"], cwd=TOP, check=True, stdout=subprocess.PIPE
    )
    mutants = []
    for number, m in enumerate(json.loads(found.stdout), 1):
        lines = (TOP / m["file"]).read_text(encoding="utf-8").splitlines(keepends=True)
        start, end = (_byte(lines, **m["span"][which]) for which in ("start", "end"))
        mutants.append(
            Mutant(number, m["file"], m["name"], m["genre"], m["replacement"], start, end)
        )
    return mutants


def _byte(lines: Sequence[str], line: int, column: int) -> int:
    """Where a line and a column, both from 1, lie in a file."""
    return len("".join([*lines[: line - 1], lines[line - 1][: column - 1]]).encode())


# --- mutants side by side -----------------------------------------------------------------


class Written:
    """A file with some mutants in it; `used`: the numbers of those that found their place."""

    def __init__(self, source: bytes, mutants: Iterable[Mutant]) -> None:
        self._source = source
        self._at: dict[tuple[str, int], list[Mutant]] = defaultdict(list)
        for m in mutants:
            self._at[m.genre, m.start].append(m)
        self.used: set[int] = set()
        tree = Parser(Language(tree_sitter_rust.language())).parse(source)
        self.text = self._of(tree.root_node)

    def _of(self, node: Node) -> bytes:
        """A part of the program with the mutants inside it."""
        if node.type in ("const_item", "static_item") or _is_const(node):
            return self._source[node.start_byte : node.end_byte]
        match node.type:
            case "binary_expression":
                return self._binary(node)
            case "compound_assignment_expr":
                return self._assignment(node)
            case "unary_expression":
                return self._unary(node)
            case "function_item":
                return self._function(node)
            case "match_pattern":
                return self._guard(node)
            case "field_initializer":
                return self._field(node)
        return self._children(node)

    def _children(self, node: Node, put: dict[int, bytes] | None = None) -> bytes:
        """The parts of a node one after the other; put: what takes the place of some, by id."""
        parts, at = [], node.start_byte
        for child in node.children:
            parts.append(self._source[at : child.start_byte])
            parts.append((put or {}).get(child.id) or self._of(child))
            at = child.end_byte
        return b"".join([*parts, self._source[at : node.end_byte]])

    def _choice(self, mutants: Sequence[Mutant], form: str, otherwise: str) -> bytes:
        """`if on(1) { .. } else { .. }`; form: of a mutant, with %s for its replacement."""
        self.used |= {m.number for m in mutants}
        ways = ((m.number, form.replace("%s", m.replacement)) for m in mutants)
        chosen = (f"if crate::on({number}) {{ {way} }} else " for number, way in ways)
        return f"{''.join(chosen)}{{ {otherwise} }}".encode()

    def _binary(self, node: Node) -> bytes:
        left, sign, right = (_field(node, name) for name in ("left", "operator", "right"))
        mutants = self._at.get(("BinaryOperator", sign.start_byte), [])
        if not mutants:
            return self._children(node)
        l, r, s = self._of(left).decode(), self._of(right).decode(), sign.type  # noqa: E741
        if s in ("&&", "||"):
            return b"(" + self._choice(mutants, f"({l}) %s ({r})", f"({l}) {s} ({r})") + b")"
        by = "&" if s in ("==", "!=", "<", ">", "<=", ">=") else ""
        chosen = self._choice(mutants, "l %s r", f"l {s} r").decode()
        return f"(match ({by}({l}), {by}({r})) {{ (l, r) => {chosen} }})".encode()

    def _assignment(self, node: Node) -> bytes:
        left, sign, right = (_field(node, name) for name in ("left", "operator", "right"))
        mutants = self._at.get(("BinaryOperator", sign.start_byte), [])
        if not mutants:
            return self._children(node)
        l, r = self._of(left).decode(), self._of(right).decode()  # noqa: E741
        chosen = self._choice(mutants, f"{l} %s r", f"{l} {sign.type} r").decode()
        return f"{{ let r = {r}; {chosen} }}".encode()

    def _unary(self, node: Node) -> bytes:
        mutants = self._at.get(("UnaryOperator", node.start_byte), [])
        if not mutants:
            return self._children(node)
        sign, value = node.children[0].type, self._of(node.children[1]).decode()
        chosen = self._choice(mutants, "e", f"{sign}e").decode()
        return f"(match ({value}) {{ e => {chosen} }})".encode()

    def _function(self, node: Node) -> bytes:
        body = node.child_by_field_name("body")
        if body is None:
            return self._children(node)
        # Of a function inside this one they begin later.
        first = next((c for c in body.named_children if "comment" not in c.type), body)
        inside = [
            m
            for (genre, start), some in self._at.items()
            if genre == "FnValue" and body.start_byte < start <= first.start_byte
            for m in some
        ]
        ways = [f"if crate::on({m.number}) {{ return {m.replacement}; }} " for m in inside]
        self.used |= {m.number for m in inside}
        text = b"{ " + "".join(ways).encode() + self._of(body)[1:]
        return self._children(node, {body.id: text})

    def _guard(self, node: Node) -> bytes:
        guard = node.child_by_field_name("condition")
        if guard is not None and (mutants := self._at.get(("MatchArmGuard", guard.start_byte))):
            chosen = self._choice(mutants, "%s", self._of(guard).decode())
            return self._children(node, {guard.id: b"(" + chosen + b")"})
        mutants = self._at.get(("MatchArm", node.start_byte), [])
        if not mutants:
            return self._children(node)
        number = mutants[0].number
        self.used.add(number)
        joined = "if" if guard is None else "&&"
        return self._children(node) + f" {joined} !crate::on({number})".encode()

    def _field(self, node: Node) -> bytes:
        mutants = self._at.get(("StructField", node.start_byte), [])
        beside = node.parent.children if node.parent else []
        rest = [c for c in beside if c.type == "base_field_initializer"]
        if not mutants or not rest:
            return self._children(node)
        name, value = _field(node, "field"), _field(node, "value")
        base = self._of(rest[0].named_children[0]).decode()
        field = self._source[name.start_byte : name.end_byte].decode()
        chosen = self._choice(mutants, f"({base}).{field}", self._of(value).decode())
        return self._children(node, {value.id: chosen})


def _field(node: Node, name: str) -> Node:
    found = node.child_by_field_name(name)
    assert found is not None
    return found


def _is_const(node: Node) -> bool:
    """Whether nothing can be asked at run time: a constant function."""
    return node.type == "function_item" and any(
        c.type == "function_modifiers" and b"const" in (c.text or b"") for c in node.children
    )


# --- the program --------------------------------------------------------------------------


def write_copy(mutants: Sequence[Mutant], left_out: set[int]) -> set[int]:
    """The workspace with all mutants in it; returns the numbers of those that are there."""
    used: set[int] = set()
    by_file: dict[str, list[Mutant]] = defaultdict(list)
    for m in mutants:
        by_file[m.file] += [m] if m.number not in left_out else []
    for file, some in by_file.items():
        written = Written((TOP / file).read_bytes(), some)
        (COPY / file).write_bytes(written.text)
        used |= written.used
    source = TOP / CORE / "src" / "lib.rs"
    (COPY / CORE / "src" / "lib.rs").write_text(source.read_text() + SWITCH)
    return used


def cargo(*words: str) -> Iterator[Any]:
    """What cargo says of the copy, message by message."""
    ran = subprocess.run(
        ["cargo", *words, "--profile", "mutants", "--message-format=json"],
        cwd=COPY,
        env={"CARGO_TARGET_DIR": str(TOP / "target"), **os.environ},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    yield from map(json.loads, ran.stdout.splitlines())


def refused(messages: Iterable[Any]) -> set[int]:
    """The mutants at which the compiler stops."""
    found = set()
    for message in messages:
        told = message.get("message")
        if message["reason"] != "compiler-message" or told["level"] != "error":
            continue
        for span in told["spans"]:
            file = COPY / span["file_name"]
            if span["is_primary"] and file.is_file():
                before = file.read_bytes()[: span["byte_end"]]
                if len(parts := before.rsplit(b"crate::on(", 1)) == 2:
                    found.add(int(parts[1].partition(b")")[0]))
    return found


def built(mutants: Sequence[Mutant]) -> set[int]:
    """Writes the copy; returns the mutants that compile together."""
    shutil.rmtree(COPY, ignore_errors=True)
    ignored = shutil.ignore_patterns("target", "out", ".git", ".venv", "node_modules", "docs")
    shutil.copytree(TOP, COPY, ignore=ignored)
    left_out: set[int] = set()
    for _ in range(MOST_ROUNDS):
        used = write_copy(mutants, left_out)
        wrong = refused(cargo("check", *OWN_TESTS))
        if not wrong:
            return used
        print(f"{len(wrong)} do not compile beside the code as it is", flush=True)
        left_out |= wrong
    raise SystemExit(f"it does not compile after {MOST_ROUNDS} rounds")


def own_tests() -> list[Program]:
    """The programs of tests of the core."""
    programs = {
        m["target"]["name"]: Path(m["executable"])
        for m in cargo("test", "--no-run", *OWN_TESTS)
        if m["reason"] == "compiler-artifact" and m.get("executable")
    }
    if not {name for name, *_ in PROGRAMS} <= set(programs):
        raise SystemExit(f"built {sorted(programs)} alone")
    quick = ["-Zunstable-options", "--fail-fast", "--quiet"]
    return [Program([str(programs[name]), *told, *quick], COPY / CORE) for name, *told in PROGRAMS]


def python_tests() -> list[Program]:
    """Tests of the Python package, on a module made of the copy."""
    messages = cargo("build", "-p", "cbpt-py", "--features", "pyo3/extension-module")
    made = [m["filenames"] for m in messages if m.get("target", {}).get("name") == "_core"]
    if not made:
        raise SystemExit("the module for Python was not built")
    shutil.copy(made[0][0], COPY / "python" / "cbpt" / "_core.abi3.so")
    pytest = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"]
    return [Program([*pytest, f"tests/core/test_{name}.py"], COPY) for name in IN_PYTHON]


def outcome(programs: Sequence[Program], patience_s: float, mutant: int) -> str:
    """`caught`, `timeout` or `survived`."""
    package = str(COPY / "python")
    env = {**os.environ, **TESTS, "PYTHONPATH": package, "MUTANT": str(mutant)}
    for program in programs:
        try:
            ran = subprocess.run(
                program.command,
                cwd=program.folder,
                env=env,
                timeout=patience_s,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return "timeout"
        if ran.returncode:
            return "caught"
    return "survived"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shard", default="0/1", help="K/N: every N-th mutant, from the K-th on")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--python", action="store_true", help="ask tests in Python too")
    parser.add_argument("--only", default="", help="mutants whose name has this")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--patience-s", type=float, default=1200.0, help="for a program of tests")
    asked = parser.parse_args()
    mutants = listed()
    used = built(mutants)
    programs = own_tests() + (python_tests() if asked.python else [])
    if outcome(programs, asked.patience_s, 0) != "survived":
        raise SystemExit("the tests fail without any mutant")
    first, step = map(int, asked.shard.split("/"))
    sample = [m for m in mutants[first::step] if asked.only in m.name]
    tried = [m for m in sample if m.number in used]
    judge = partial(outcome, programs, asked.patience_s)
    found: dict[str, str] = {m.name: "not tried" for m in sample}
    with ThreadPoolExecutor(asked.jobs) as pool:
        for m, said in zip(tried, pool.map(judge, (m.number for m in tried)), strict=True):
            found[m.name] = said
            print(said, m.name, flush=True)
    count = Counter(found.values())
    print(f"{len(sample)} of {len(mutants)} mutants:", dict(count))
    if asked.json:
        asked.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
