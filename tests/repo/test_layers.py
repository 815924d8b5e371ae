"""The arrows of CONTRIBUTING.md's map run one way, and importing the package stays light.

Groups: crates and what they may depend on; modules of the core; modules of the command line;
Python modules by their imports; what is loaded when.
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
    "period": set(),
    "real": set(),
    "drive": {"error", "real"},
    "torsion_spring": {"error", "status"},
    "reducer": {"drive", "effect", "torsion_spring"},
    "hertz": set(),
    "geometry": {"drive", "hertz", "real"},
    "solver": {"error"},
    "pair": {"drive", "geometry", "hertz"},
    "equilibrium": {"hertz", "pair", "solver", "status"},
    "transmission": {"drive", "geometry", "pair", "equilibrium", "status"},
    "effect": {"error", "pair", "real"},
    "design": {"drive", "error", "geometry"},
    "predict": {
        *("drive", "effect", "error", "geometry", "pair", "equilibrium", "status"),
        *("reducer", "torsion_spring", "transmission", "sweep"),
    },
    "preload": {"drive", "geometry", "pair", "period", "real", "transmission"},
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
    "judge": {"design", "drive", "equilibrium", "preload", "status", "sweep"},
    "findings": {"design", "drive", "geometry", "equilibrium", "transmission", "status"},
}
CLI_USES: dict[str, set[str]] = {
    "units": set(),
    "formula": set(),
    "case": {"formula"},
    "args": {"units"},
    "exit": {"case"},
    "report": {"args", "exit"},
    "progress": set(),
    "sweep": {"case", "exit", "units"},
    "commands": {"args", "case", "exit", "progress", "report", "sweep", "units"},
    "lib": {"args", "commands", "exit"},
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


# --- modules of Python --------------------------------------------------------------------


def modules() -> dict[str, Path]:
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = ("cbpt", *path.relative_to(PACKAGE).with_suffix("").parts)
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


class Imports(ast.NodeVisitor):
    """Imports at the top of a module and those inside functions, apart from those for types."""

    def __init__(self) -> None:
        self.early: set[str] = set()
        self.late: set[str] = set()
        self.depth = 0

    def visit_If(self, node: ast.If) -> None:
        if not (isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"):
            self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.depth += 1
        self.generic_visit(node)
        self.depth -= 1

    def visit_Import(self, node: ast.Import) -> None:
        (self.late if self.depth else self.early).update(alias.name for alias in node.names)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        assert node.module is not None and node.level == 0, "imports are absolute"
        kept = self.late if self.depth else self.early
        names = {f"{node.module}.{alias.name}" for alias in node.names}
        kept.update(names & {*modules(), "cbpt._core"} or {node.module})


@cache
def imports(name: str) -> Imports:
    found = Imports()
    found.visit(ast.parse(modules()[name].read_text(encoding="utf-8")))
    return found


# The part of the package that a module belongs to, the lowest first.
RANKS = (
    *("_core", "errors", "results", "sweeps"),
    *("effects", "lab", "design", "figures", "page", "cli"),
)
# The one step up: methods that hand their object on when they are called, never on import.
UPWARDS = {
    ("cbpt.lab.diagnosis.compare", "cbpt.figures.comparison"),
    ("cbpt.lab.diagnosis.diagnosis", "cbpt.figures.diagnosis"),
    ("cbpt.lab.experiment.isolability", "cbpt.figures.isolability"),
    ("cbpt.design.tolerance", "cbpt.figures.tolerance"),
}


def rank(name: str) -> int:
    return RANKS.index(name.split(".")[1])


@pytest.mark.parametrize("name", [name for name in modules() if name != "cbpt"])
def test_python_modules_import_only_what_lies_below_them(name: str) -> None:
    found = imports(name)
    own = {each for each in found.early | found.late if each.startswith("cbpt.")}
    for other in own:
        if (name, other) in UPWARDS:
            assert other not in found.early
            continue
        assert rank(other) <= rank(name), f"{name} imports {other}"
    assert "cbpt" not in found.early, "the root imports the others"


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
