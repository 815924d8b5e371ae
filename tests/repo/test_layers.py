"""The arrows of CONTRIBUTING.md's map run one way, and importing the package stays light.

Groups: crates and what they may depend on; modules of the core and of the command line; files of
Rust that need each other; Python modules by their imports, those inside functions and those for
type checkers too; what is loaded when.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

TOP = Path(__file__).parents[2]
CORE = TOP / "crates" / "cbpt-core"
CLI = TOP / "crates" / "cbpt-cli"
PACKAGE = TOP / "python" / "cbpt"

# --- crates -------------------------------------------------------------------------------


def dependencies(crate: Path) -> set[str]:
    manifest = tomllib.loads((crate / "Cargo.toml").read_text())
    return set(manifest["dependencies"])


def test_the_core_knows_no_python_no_files_and_no_command_line() -> None:
    assert dependencies(CORE) <= {"nalgebra", "pulp", "rayon", "thiserror"}
    for path in sources(CORE):
        text = code(path)
        assert not re.search(r"\bstd::(fs|io|env|process|net)\b", text), path
        assert not re.search(r"\be?print(ln)?!", text), path


def test_the_command_line_knows_no_python() -> None:
    found = dependencies(CLI)
    assert "cbpt-core" in found
    assert not found & {"pyo3", "numpy", "cbpt-py"}


def test_nothing_depends_on_the_extension_module() -> None:
    for crate in (TOP / "crates").iterdir():
        if crate.name != "cbpt-py":
            assert "cbpt-py" not in dependencies(crate)


# --- modules of Rust ----------------------------------------------------------------------


def sources(crate: Path) -> list[Path]:
    return sorted((crate / "src").rglob("*.rs"))


def code(path: Path) -> str:
    """A file without comments and without its tests."""
    text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
    return text.split("#[cfg(test)]", 1)[0]


def module(crate: Path, path: Path) -> str:
    """The module under the root that a file belongs to."""
    return path.relative_to(crate / "src").parts[0].removesuffix(".rs")


@cache
def reexports(crate: Path) -> dict[str, str]:
    """What the root hands on (`pub use drive::{Drive, ...}`), and from which module."""
    found: dict[str, str] = {}
    for name, inner in re.findall(r"pub use (\w+)::(\{[^}]*\}|\w+);", code(crate / "src/lib.rs")):
        found |= dict.fromkeys(re.findall(r"\w+", inner), name)
    return found


def used(crate: Path, path: Path) -> set[str]:
    """The modules under the root that a file names."""
    text = code(path)
    names = set(re.findall(r"\bcrate::(\w+)", text))
    for group in re.findall(r"\bcrate::\{(.*?)\};", text, re.DOTALL):
        while "{" in group:
            group = re.sub(r"\{[^{}]*\}", "", group)
        names |= {name for part in group.split(",") for name in re.findall(r"^\s*(\w+)", part)}
    return {reexports(crate).get(name, name) for name in names} - {module(crate, path)}


# Who may use whom; a new module takes its place here.
CORE_USES: dict[str, set[str]] = {
    "error": set(),
    "status": set(),
    "units": set(),
    "period": set(),
    "real": set(),
    "as_made": {"error"},
    "drive": {"as_made", "error", "real"},
    "torsion_spring": {"error", "status"},
    "reducer": {"drive", "effect", "torsion_spring"},
    "hertz": set(),
    "interval": set(),
    "geometry": {"drive", "hertz", "real"},
    "solver": {"error"},
    "covariance": set(),
    "pair": {"as_made", "drive", "geometry", "hertz"},
    "equilibrium": {"hertz", "interval", "pair", "solver", "status"},
    "transmission": {"drive", "geometry", "pair", "equilibrium", "status"},
    "enclosure": {"drive", "equilibrium", "geometry", "interval", "transmission"},
    "effect": {"error", "pair", "real", "units"},
    "design": {"drive", "error", "geometry"},
    "predict": {
        *("drive", "effect", "error", "geometry", "pair", "equilibrium", "status"),
        *("reducer", "torsion_spring", "transmission", "sweep", "units"),
    },
    "fit": {"effect", "error", "predict"},
    "posterior": {"covariance", "error", "predict", "solver", "units"},
    "turn": {"as_made", "drive", "equilibrium", "pair", "status", "sweep", "transmission"},
    "preload": {
        *("drive", "equilibrium", "geometry", "pair", "period", "real", "transmission", "turn"),
    },
    "sensitivity": {
        *(
            "design",
            "drive",
            "effect",
            "equilibrium",
            "error",
            "geometry",
            "pair",
            "preload",
            "real",
        ),
        *("status", "transmission"),
    },
    "extremes": {
        *("drive", "error", "geometry", "pair", "equilibrium", "period", "status"),
        *("transmission", "sweep"),
    },
    "sweep": {"drive", "equilibrium", "geometry", "status", "transmission"},
    "friction": {
        *("drive", "equilibrium", "error", "extremes", "geometry", "hertz", "pair", "status"),
        *("sweep",),
    },
    "judge": {
        *("design", "drive", "equilibrium", "friction", "preload", "status", "strength", "sweep"),
    },
    "cost": {"design", "drive", "error", "friction", "sensitivity", "strength"},
    "strength": {
        *("drive", "equilibrium", "findings", "geometry", "pair", "period", "preload"),
        "transmission",
    },
    "findings": {"design", "drive", "geometry", "equilibrium", "transmission", "status"},
}
CLI_USES: dict[str, set[str]] = {
    "formula": set(),
    "case": {"formula"},
    "args": set(),
    "exit": {"case"},
    "whole": set(),
    "terminal": set(),
    "report": {"args", "exit", "terminal", "whole"},
    "progress": set(),
    "sweep": {"case", "exit", "whole"},
    "bars": {"report"},
    "commands": {"args", "bars", "case", "exit", "progress", "report", "sweep"},
    "lib": {"args", "commands", "exit", "terminal"},
    "main": {"lib"},
}


@pytest.mark.parametrize(
    ("crate", "allowed"), [(CORE, CORE_USES), (CLI, CLI_USES)], ids=["core", "command line"]
)
def test_modules_use_only_what_lies_below_them(crate: Path, allowed: dict[str, set[str]]) -> None:
    for path in sources(crate):
        name = module(crate, path)
        if crate == CORE and name == "lib":  # the map of all
            continue
        assert name in allowed, f"{name} has no place in the plan yet"
        beyond = used(crate, path) - allowed[name]
        assert not beyond, f"{path.relative_to(TOP)} uses {', '.join(sorted(beyond))}"


@pytest.mark.parametrize("allowed", [CORE_USES, CLI_USES], ids=["core", "command line"])
def test_the_plan_itself_has_no_circle(allowed: dict[str, set[str]]) -> None:
    left = dict(allowed)
    while left:
        bottom = [name for name, uses in left.items() if not uses & left.keys()]
        assert bottom, f"a circle among {', '.join(sorted(left))}"
        for name in bottom:
            del left[name]


def test_the_solver_knows_no_ball_and_no_groove() -> None:
    for path in (CORE / "src" / "solver").glob("*.rs"):
        words = re.findall(r"(?i)\b\w*(?:ball|groove|pair|preload|torque|hertz)\w*", code(path))
        assert not words, f"{path.name}: {words}"


# --- files of Rust ------------------------------------------------------------------------

CRATES = [TOP / "crates" / name for name in ("cbpt-core", "cbpt-cli", "cbpt-py")]


def place(crate: Path, path: Path) -> tuple[str, ...]:
    """The path of a file's module: `("case", "parse")`; of `case/mod.rs`, `("case",)`."""
    parts = path.relative_to(crate / "src").with_suffix("").parts
    return parts[:-1] if parts[-1] in ("mod", "lib", "main") else parts


def leaves(tree: str) -> list[list[str]]:
    """Every path of the tree of a `use`: `a::{b, c::d}` names a::b and a::c::d."""
    head, brace, rest = tree.partition("{")
    stem = [part.strip() for part in head.split("::") if part.strip()]
    if not brace:
        return [stem]
    found, depth, start = [], 0, 0
    inner = rest.rpartition("}")[0] + ","
    for i, letter in enumerate(inner):
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            if inner[start:i].strip():
                found += [[*stem, *leaf] for leaf in leaves(inner[start:i])]
            start = i + 1
    return found


class Crate:
    """The files of a crate, and which names each of them takes from another file."""

    def __init__(self, crate: Path) -> None:
        files = [f for f in sources(crate) if "tests" not in place(crate, f)]
        self.texts = {place(crate, f): code(f) for f in files}
        self.uses = {
            at: [leaf for tree in re.findall(r"\buse\s+([^;]+);", text) for leaf in leaves(tree)]
            for at, text in self.texts.items()
        }

    def resolved(self, at: tuple[str, ...], names: list[str], depth: int = 0) -> tuple[str, ...]:
        """The module that a path means as it stands in the file of a module; itself where it means
        something from outside."""
        names = [name.split(" as ")[0].strip() for name in names]
        there: tuple[str, ...] = ()
        if names[:1] == ["crate"]:
            names = names[1:]
        elif names[:1] in (["self"], ["super"]):
            there = at
            while names[:1] in (["self"], ["super"]):
                there = there[:-1] if names[0] == "super" else there
                names = names[1:]
        elif names and (*at, names[0]) in self.texts:
            there = at
        else:
            return at
        while names and (*there, names[0]) in self.texts:
            there, names = (*there, names[0]), names[1:]
        # What a folder's file hands on is of the file that has it.
        for use in self.uses.get(there, []) if names and depth < 4 else []:
            if use[-1].split(" as ")[-1].strip() == names[0]:
                onward = self.resolved(there, use, depth + 1)
                return there if onward == at else onward
        return there

    def graph(self) -> dict[str, set[str]]:
        """File -> files. A file may use what stands in the file of a folder that it lies in: the
        map of the folder and the types that all of it share."""
        found: dict[str, set[str]] = {}
        for at, text in self.texts.items():
            said = [*self.uses[at], *(m.split("::") for m in re.findall(_PATHS, text))]
            others = {self.resolved(at, names) for names in said}
            kept = {o for o in others if o != at[: len(o)]}
            found["/".join(at)] = {"/".join(other) for other in kept}
        return found


_PATHS = r"\b(?:crate|super|self)(?:::\w+)+"


def circles(graph: dict[str, set[str]]) -> list[frozenset[str]]:
    """Groups of nodes each of which can be reached from every other (Tarjan 1972)."""
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[frozenset[str]] = []

    def visit(node: str) -> None:
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in sorted(graph.get(node, ())):
            if other not in order:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == order[node]:
            place = stack.index(node)
            found.append(frozenset(stack[place:]))
            del stack[place:]

    for node in graph:
        if node not in order:
            visit(node)
    return [group for group in found if len(group) > 1]


def test_a_circle_is_found_and_a_chain_is_none() -> None:
    chain = {"a": {"b"}, "b": {"c"}, "c": set()}
    assert circles(chain) == []
    assert circles(chain | {"c": {"a"}, "d": {"a"}}) == [frozenset("abc")]


@pytest.mark.parametrize("crate", CRATES, ids=lambda path: path.name)
def test_no_two_files_of_rust_need_each_other(crate: Path) -> None:
    found = circles(Crate(crate).graph())
    assert not found, "; ".join(", ".join(sorted(circle)) for circle in found)


# --- modules of Python --------------------------------------------------------------------

# Each imports only what stands before it.
PACKAGES = (
    *(
        "_core",
        "errors",
        "toml_files",
        "whole_files",
        "units",
        "sketch",
        "results",
        "sweeps",
        "effects",
        "figures",
    ),
    *("lab", "design", "page", "cli", "__main__"),
)
# The same within a package.
WITHIN = {
    "lab": (
        *("wording", "readings", "covariance", "model", "inference"),
        *("selection", "characteristics", "preflight", "experiment", "diagnosis", "change"),
    ),
    "page": ("document", "report", "inline", "printing", "datasheet", "workbench"),
}


@cache
def modules() -> dict[str, Path]:
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = ("cbpt", *path.relative_to(PACKAGE).with_suffix("").parts)
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


class Imports(ast.NodeVisitor):
    """Imports of a module: at its top, inside functions, and for type checkers alone."""

    def __init__(self) -> None:
        self.early: set[str] = set()
        self.late: set[str] = set()
        self.typed: set[str] = set()
        self.kept = self.early

    def visit_If(self, node: ast.If) -> None:
        if isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            self._inside(self.typed, node)
        else:
            self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self._inside(self.late, node)

    def _inside(self, kept: set[str], node: ast.AST) -> None:
        before, self.kept = self.kept, kept
        self.generic_visit(node)
        self.kept = before

    def visit_Import(self, node: ast.Import) -> None:
        self.kept.update(alias.name for alias in node.names)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        assert node.module is not None and node.level == 0, "imports are absolute"
        for alias in node.names:
            full = f"{node.module}.{alias.name}"
            self.kept.add(full if full in {*modules(), "cbpt._core"} else node.module)

    @property
    def own(self) -> set[str]:
        """Modules of the package that it names anywhere."""
        every = self.early | self.late | self.typed
        return {name for name in every if name.split(".")[0] == "cbpt"}


@cache
def imports(name: str) -> Imports:
    found = Imports()
    found.visit(ast.parse(modules()[name].read_text(encoding="utf-8")))
    return found


def ranks(name: str) -> tuple[int, ...]:
    """Where a module stands: its package, and its place within."""
    _, package, *rest = name.split(".")
    return (
        PACKAGES.index(package),
        *(WITHIN[package].index(r) for r in rest[:1] * (package in WITHIN)),
    )


BELOW_THE_ROOT = [name for name in modules() if name != "cbpt"]


def test_python_modules_import_only_what_lies_below_them() -> None:
    arrows = {(name, other) for name in BELOW_THE_ROOT for other in imports(name).own}
    assert arrows
    assert not {name for name, other in arrows if other == "cbpt"}, "the root imports the others"
    assert not {(a, b) for a, b in arrows if b != "cbpt" and ranks(b) > ranks(a)}


def test_no_two_python_modules_need_each_other() -> None:
    graph = {name: imports(name).own - {name} for name in BELOW_THE_ROOT}
    found = circles(graph)
    assert not found, "; ".join(", ".join(sorted(circle)) for circle in found)


# What speaks to a browser; nothing else of the package knows a network.
SERVING = {"cbpt.page.workbench.guard", "cbpt.page.workbench.server", "cbpt.page.workbench.serve"}
NETWORK = {"http", "socketserver", "urllib", "requests", "socket", "starlette", "uvicorn"}


def test_only_the_page_knows_plotting_and_only_the_workbench_a_server() -> None:
    for name in modules():
        early, late = imports(name).early, imports(name).late
        tops = {each.split(".")[0] for each in early | late}
        if rank_of(name) not in ("page", "figures"):
            assert not tops & {"matplotlib", "plotly"}, name
        assert name in SERVING or not tops & NETWORK, name
        # Whoever asks for a report needs no server.
        assert name in SERVING or not early & SERVING, name


def rank_of(name: str) -> str:
    return "" if name == "cbpt" else name.split(".")[1]


def test_what_is_heavy_is_imported_late() -> None:
    for name in modules():
        tops = {each.split(".")[0] for each in imports(name).early}
        assert not tops & {"scipy", "matplotlib", "pandas"}, name


# --- what is loaded when ------------------------------------------------------------------

SHOWN = "import sys; print(*sorted({name.split('.')[0] for name in sys.modules}))"


def loaded(program: str) -> set[str]:
    """The packages that a fresh interpreter has loaded after a program."""
    command = [sys.executable, "-c", f"{program}\n{SHOWN}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=TOP)
    return set(done.stdout.splitlines()[-1].split())


def test_importing_the_package_is_light() -> None:
    found = loaded("import cbpt; cbpt.Drive.from_toml(cbpt.example_case()).solve(5, 600)")
    assert "cbpt" in found
    assert not found & {"scipy", "matplotlib", "pandas", "argparse"}


def test_comparing_loads_no_plotting() -> None:
    found = loaded(
        "import cbpt; c = cbpt.compare('examples/campaign.toml', 'examples/campaign.csv'); "
        "c.report(), c.to_json(), c.rows()"
    )
    assert "scipy" in found
    assert "matplotlib" not in found


def test_the_verbs_of_the_mechanics_load_neither_scipy_nor_plotting() -> None:
    found = loaded("from cbpt.cli.main import main; main(['check', 'examples/base_case.toml'])")
    assert not found & {"scipy", "matplotlib"}
