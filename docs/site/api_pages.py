"""The pages of the Python API: what `cbpt` exports, by subject, from its docstrings."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path

import cbpt
from cbpt import effects, errors

# Page -> title, what it is about, and its names in the order in which a reader meets them.
PAGES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "drive": (
        "Drives and loads",
        "A drive comes from a case file. It computes the elastic angle under one load or under "
        "arrays of loads, and the preload that a torque needs.",
        (
            "Drive",
            "Case",
            "example_case",
            "Solution",
            "PairSolution",
            "Enclosure",
            "PreloadThresholds",
            "Thresholds",
            "LargestAngle",
            "Finding",
            "solve_many",
            "Angles",
        ),
    ),
    "readings": (
        "Readings and comparison",
        "Readings come from a table. A comparison says how far the model is off, and where. "
        "Characteristics are the figures of catalogues, read off loops.",
        (
            "read_readings",
            "Readings",
            "compare",
            "Comparison",
            "preflight",
            "Preflight",
            "characterise",
            "Characteristics",
        ),
    ),
    "diagnosis": (
        "Diagnosis and fit",
        "A diagnosis says which effect is missing, a change which one is not what it was. "
        "A fit adds effects to the case.",
        (
            "diagnose",
            "Diagnosis",
            "diagnose_by",
            "DividedDiagnosis",
            "read_answer",
            "change",
            "Change",
            "fit",
            "Fitted",
        ),
    ),
    "campaigns": (
        "Campaigns",
        "These functions plan measurements, before the first reading and between campaigns.",
        (
            "read_plan",
            "Plan",
            "simulate",
            "isolability",
            "Isolability",
            "next_runs",
            "NextRuns",
            "Limits",
            "shortest_plan",
            "Design",
        ),
    ),
    "design": (
        "Design",
        "Sensitivities, tolerances and the best design within bounds.",
        (
            "Sensitivities",
            "Sensitivity",
            "tolerance",
            "Tolerance",
            "optimise",
            "Optimum",
            "pareto_front",
            "ParetoFront",
        ),
    ),
    "parts": (
        "Parts as made and the data sheet",
        "The drive that was built, and one page of it.",
        ("transmission", "Transmission", "datasheet"),
    ),
    "friction": (
        "Friction and strength",
        "What preload and stiffness cost: friction torque, efficiency, wear, static safety.",
        (
            "friction",
            "friction_map",
            "Costs",
            "Friction",
            "PairFriction",
            "FrictionContact",
            "FrictionMap",
        ),
    ),
    "sweeps": (
        "Sweeps",
        "A sweep varies any parameter of drive, load or effects.",
        ("sweep", "Sweep", "SweepPlan"),
    ),
}
FROM_MODULES = {"effects", *errors.__all__}


def missing() -> set[str]:
    """Names that `cbpt` exports and no page has."""
    named = {name for _, _, names in PAGES.values() for name in names}
    return set(cbpt.__all__) - named - FROM_MODULES


def directive(name: str, module: str = "cbpt") -> str:
    """What makes Sphinx write the docstring of a class, an error, a function or a value."""
    value = getattr(import_module(module), name)
    kind = "function" if inspect.isroutine(value) else "data"  # a name for a type is data
    if isinstance(value, type):
        kind = "exception" if issubclass(value, Exception) else "class"
    lines = [f".. auto{kind}:: {module}.{name}"]
    if kind == "class":
        lines += ["   :members:", "   :undoc-members:"]
    return "\n".join(["```{eval-rst}", *lines, "```", ""])


def variables() -> str:
    """The variables of own effects as a table."""
    rows = [f"| `{name}` | {meaning} |" for name, meaning in effects.VARIABLES.items()]
    return "\n".join(["## Variables", "", "| variable | meaning |", "|---|---|", *rows, ""])


def page(title: str, about: str, directives: list[str]) -> str:
    return "\n".join([f"# {title}", "", about, "", *directives])


def write(source: Path) -> None:
    """Write the pages into the folder of sources; a name that no page has ends the build."""
    if names := missing():
        raise SystemExit(f"api_pages.py has no page for {', '.join(sorted(names))}")
    folder = source / "reference" / "python"
    folder.mkdir(parents=True)
    texts = {
        file: page(title, about, [directive(name) for name in names])
        for file, (title, about, names) in PAGES.items()
    }
    texts["effects"] = page(
        "Effects of your own",
        "`cbpt.effects` makes effects from an expression or from a Python function. "
        "The guide is [effects of your own](../../how-to/own-effects.md).",
        [
            *(directive(name, "cbpt.effects") for name in effects.__all__ if name != "VARIABLES"),
            variables(),
        ],
    )
    texts["errors"] = page(
        "Errors",
        "Everything that CBPT raises is a `cbpt.CbptError`.",
        [directive(name, "cbpt.errors") for name in errors.__all__],
    )
    listed = "\n".join(texts)
    texts["index"] = (
        "# Python API\n\n`import cbpt` gives everything on these pages. The signatures and texts "
        "come from the docstrings.\n\n"
        f"```{{toctree}}\n:maxdepth: 2\n\n{listed}\n```\n"
    )
    for file, text in texts.items():
        (folder / f"{file}.md").write_text(text, encoding="utf-8")
