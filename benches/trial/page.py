"""The score of a trial as a page of the documentation, with the reliability of its probabilities.

write_page(PAGE, score, outcomes)   the page
section(outcomes, seed)             the table of what the answer has to reach, as Markdown
"""

from __future__ import annotations

import datetime
import math
import platform
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from trial.families import FAMILIES
from trial.grades import Outcome
from trial.score import Measure, measures, reliability
from trial.targets import NAMES, targets
from trial.wider import WIDER

_INTRO = """# The trial

The trial measures how often the diagnosis is right. Campaigns with a hidden effect come from an
implementation that shares no code with the product (`tests/reference/rig`); its effects differ in
form from those of the library. The diagnosis gets a case file and a table, and no label.
`make trial` runs the full length (60 sets of each strength and family, 400 sets of each noise
without an effect) and writes this page; `tests/lab/test_trial.py` is a short form.

*d* is the size of a hidden effect: the length of its signature after the parameters of the drive
are refitted, in standard deviations of the noise. The oracle knows the true forms and the noise.
Plain AIC and BIC choose among the same fits.
"""


_TO_REACH = """Effects under every noise, one, two or three at a time, cross-slides, torsion
springs, coarse displays, artefacts of instruments, tables of 6 to 40 readings and tables without a
law. *d* is conditional here: how far the weakest of the hidden effects stands out once the sizes of
the others are refitted too. *held*: the certain effects with one of each rival group contain the
truth; *named*: they are the truth, and nothing is open. The oracle weighs all singles, pairs and
triples of the rig's own forms by linear Gaussian evidence, knows the noise, and has the
same prior odds and rule of naming; *behind the oracle* compares on the same sets."""


def commit(top: Path) -> str:
    """The commit that is checked out, marked where the tree differs; `unknown` outside git."""
    try:
        told = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=top,
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return told.stdout.strip()


BEFORE = "## The product as it was before the second version of the answer"
"""A section that a new page takes over from the one it replaces."""


def _taken_over(page: Path) -> list[str]:
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    if BEFORE not in text:
        return []
    rest = text[text.index(BEFORE) + len(BEFORE) :]
    ends = [i for mark in ("\n## ", "\nWhat falls short") if (i := rest.find(mark)) >= 0]
    return [BEFORE + rest[: min(ends, default=len(rest))].rstrip(), ""]


def write_page(
    page: Path,
    score: Mapping[str, Any],
    outcomes: Sequence[Outcome],
    every: Sequence[Outcome] = (),
) -> None:
    """The page; `make docs` draws its picture from the table of probabilities.

    outcomes: of the first six families; every: those of the wider ones as well.
    """
    top = Path(__file__).parents[2]
    seconds = [o["seconds"] for o in outcomes]
    page.parent.mkdir(parents=True, exist_ok=True)
    order = score["order_of_library"]
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    lines = [
        _INTRO,
        f"{today}, commit `{commit(top)}`, {len(outcomes)} campaigns, seed {score['seed']}, "
        f"{platform.machine()}, {sum(seconds) / max(len(seconds), 1):.1f} s an answer on average, "
        f"at most {max(seconds, default=0.0):.1f} s: {score['sets_each']} sets of each strength "
        f"and family, {score['null_sets_each']} of each noise without an effect. "
        f"With the library in another order {order['changed']} of {order['sets']} answers change.",
        "",
        _table(measures(outcomes)),
        "",
        "*reached* is `yes` or `no` where the whole interval (Wilson, 95 %) lies on one side, "
        "else `open`.",
        "",
        "## Probabilities",
        "",
        "<!-- picture: trial.svg | Stated probability against the share that was right -->",
        "",
        _reliability(reliability(outcomes)),
        "",
        *_to_reach(every),
        *_taken_over(page),
        "What falls short and why: [notes on the trial](trial-notes.md).",
        "",
    ]
    page.write_text("\n".join(lines), encoding="utf-8")


def _to_reach(every: Sequence[Outcome]) -> list[str]:
    """The section on what the second version of the answer has to reach."""
    if not every:
        return []
    return ["## What the answer has to reach", "", _TO_REACH, "", _table(targets(every)), ""]


def section(outcomes: Sequence[Outcome], seed: int) -> str:
    """What campaigns, then the table."""
    families = {f: sum(o["family"] == f for o in outcomes) for f in (*FAMILIES, *WIDER)}
    told = ", ".join(f"{n} {NAMES.get(f, f)}" for f, n in families.items() if n)
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    made = f"{today}, commit `{commit(Path(__file__).parents[2])}`, seed {seed}: {told}."
    return f"{made}\n\n{_table(targets(outcomes))}\n"


def _value(x: float, unit: str) -> str:
    if math.isnan(x):
        return "-"
    return f"{100 * x:.1f} %" if unit == "%" else f"{x:.3f}"


def _table(found: Iterable[Measure]) -> str:
    lines = ["| measure | where | value | 95 % interval | sets | to reach | reached |"]
    lines.append("|---|---|---|---|---|---|---|")
    for m in found:
        if not m.sets:
            continue
        asked = [f">= {_value(m.least, m.unit)}"] if m.least is not None else []
        asked += [f"<= {_value(m.most, m.unit)}"] if m.most is not None else []
        interval = f"{_value(m.low, m.unit)} to {_value(m.high, m.unit)}"
        cells = [m.name.strip(), m.where, _value(m.value, m.unit), interval, str(m.sets)]
        lines.append("| " + " | ".join([*cells, ", ".join(asked), m.reached]) + " |")
    return "\n".join(lines)


def _reliability(rows: Iterable[Mapping[str, float]]) -> str:
    lines = ["| stated | sets | mean stated | right | 95 % interval |", "|---|---|---|---|---|"]
    for r in rows:
        lines.append(
            f"| {r['from']:.1f} to {r['to']:.1f} | {r['sets']:.0f} | {r['stated']:.2f} "
            f"| {r['true']:.2f} | {r['true_low']:.2f} to {r['true_high']:.2f} |"
        )
    return "\n".join(lines)
