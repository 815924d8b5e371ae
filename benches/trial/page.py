"""The score of a trial as a page of the documentation, with the reliability of its probabilities.

write_page(PAGE, outcomes, seeds)   the page
section(outcomes, seeds)            the table of what the answer has to reach, as Markdown
"""

from __future__ import annotations

import datetime
import math
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from trial.families import FAMILIES
from trial.grades import Outcome
from trial.score import Measure, reliability
from trial.targets import NAMES, targets
from trial.wider import WIDER

_INTRO = """# The trial

The trial measures how often the diagnosis is right. Campaigns with hidden effects come from an
implementation that shares no code with the product (`tests/reference/rig`); its effects differ in
form from those of the library. The diagnosis gets a case file and a table, and no label.
`make trial-short` (about ten minutes: four to seventeen by the machine) and `make trial` (two to
three hours) write this page.

There are campaigns without an effect, with one, two and three, under every noise; with one that
stands out by far (*strong*); cross-slides and torsion springs, some read by a logger with a clock,
whose torque turns back between readings; coarse displays and artefacts of instruments; effects that
the library lacks; tables of 6 to 40 readings, and tables without a law (the model times random
factors).

- *d* is the size of a hidden effect in standard deviations of the noise, and conditional: how far
  the weakest of the hidden effects stands out once the numbers of the drive and the sizes of the
  other effects are refitted too, to first order.
- *held*: the certain effects, with one of each group of rivals, contain the truth. *named*: they
  are the truth, and nothing is open.
- The *oracle* weighs all singles, pairs and triples of the rig's own forms by their linear Gaussian
  evidence. It knows the noise and the true shapes, and has the prior odds and the rule of the
  product. *Behind the oracle* compares on the same sets, with the interval of paired shares.
- *truth not held, or false name*: of the answers with a probability of 0.9 or more. Where nothing
  is hidden the truth is that nothing is missing; outside the library that something without a name
  is left; without a law that nothing can be said. *No truth held, or a false name certain* leaves
  out answers that hold one effect of two and claim no other.
- The calibration error of few sets is biased upwards: 24 sets that are right and stated at 0.95
  have 0.05. An undecided answer claims nothing and is left out.
"""


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


def write_page(page: Path, outcomes: Sequence[Outcome], seeds: Sequence[int]) -> None:
    """The page; `make docs` draws its picture from the table of probabilities."""
    claiming = [o for o in outcomes if not o.get("error") and not o["answer"].get("undecided")]
    lines = [
        _INTRO,
        section(outcomes, seeds),
        "*reached* is `yes` or `no` where the whole interval (95 %) lies on one side, else `open`.",
        "",
        "## Probabilities",
        "",
        "<!-- picture: trial.svg | Stated probability against the share that was right -->",
        "",
        _reliability(reliability(claiming)),
        "",
        *_taken_over(page),
        "What falls short and why: [notes on the trial](trial-notes.md).",
        "",
    ]
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("\n".join(lines), encoding="utf-8")


def dated() -> str:
    """Today and the commit, as pages that a bench writes state them."""
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    return f"{today}, commit `{commit(Path(__file__).parents[2])}`"


def section(outcomes: Sequence[Outcome], seeds: Sequence[int]) -> str:
    """What campaigns, then the table."""
    families = {f: sum(o["family"] == f for o in outcomes) for f in (*FAMILIES, *WIDER)}
    told = ", ".join(f"{n} {NAMES.get(f, f)}" for f, n in families.items() if n)
    made = f"{dated()}, {'seed' if len(seeds) == 1 else 'seeds'} {' and '.join(map(str, seeds))}"
    return f"{made}: {told}.\n\n{_table(targets(outcomes))}\n"


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
