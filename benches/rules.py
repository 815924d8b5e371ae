"""How the answers change when a rule of the decision is halved or doubled.

`python benches/rules.py` diagnoses campaigns of the trial's rig once, and judges each competition
anew under every rule of `selection/rules` at half and at twice its value; of a probability near 1
what is missing to 1 is halved and doubled. It writes docs/explanation/rules.md.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "benches"), str(ROOT / "tests")]

from cbpt import Case, CbptError
from cbpt.lab.diagnosis.diagnose import prepared
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.selection.decision import Verdict, judge
from cbpt.lab.selection.model_comparison import compete
from cbpt.lab.selection.rules import RULES, DecisionRules
from trial import claims
from trial.answers import Task, campaign, table_of
from trial.page import dated

PAGE = ROOT / "docs" / "explanation" / "rules.md"
FAMILIES: Mapping[str, int] = {
    "null": 7,
    "coarse": 5,
    "artefact": 5,
    "one": 14,
    "two": 14,
    "three": 5,
    "outside": 5,
    "small": 6,
    "lawless": 6,
}
"""How many campaigns of each."""
COUNTS = ("held", "something false certain", "false alarm", "undecided")


def variants() -> Iterator[tuple[str, str, DecisionRules]]:
    """Every rule at half and at twice its value."""
    yield "", "", RULES
    for rule in fields(RULES):
        value = float(getattr(RULES, rule.name))
        for factor, name in ((0.5, "halved"), (2.0, "doubled")):
            new = 1 - factor * (1 - value) if value > 0.9 and value < 1 else factor * value
            yield rule.name, name, replace(RULES, **{rule.name: new})


def outcome_of(given: Mapping[str, Any], family: str, verdict: Verdict) -> dict[str, Any]:
    """As the trial scores it."""
    answer = {
        "kind": verdict.kind,
        "effects": list(verdict.effects),
        "rivals": [list(g) for g in verdict.rivals],
        "perhaps": [e for e, _ in verdict.perhaps],
        "remains": verdict.lack_of_fit is not None,
        "undecided": verdict.kind == "undecided",
        "probability": verdict.probability,
        "probability_of": "named" if verdict.effects or verdict.rivals else "whole",
    }
    return {"family": family, "truth": given["truth"], "answer": answer}


def counts(outcome: Mapping[str, Any]) -> tuple[bool, ...]:
    """What is counted of one answer, in the order of `COUNTS`."""
    answer = outcome["answer"]
    wanted = claims.accepted(outcome)
    nothing = not wanted and not claims.unnamed(outcome)
    return (
        bool(wanted) and claims.held(answer, wanted),
        bool(claims.false_certain(outcome)),
        nothing and claims.alarms(outcome),
        answer["undecided"],
    )


def judged(task: Task) -> list[tuple[bool, ...]] | None:
    """The counts of one campaign under every variant of the rules."""
    given = campaign(task)
    if given is None:
        return None
    try:
        case, readings = case_and_readings(Case.from_toml(given["case"]), table_of(given))
        table, _ = prepared(campaign_of(case, readings, []))
    except CbptError:
        return None
    competition = compete(table, np.random.default_rng(0))
    return [
        counts(outcome_of(given, task[0], judge(competition, rules))) for _, _, rules in variants()
    ]


def page(found: np.ndarray[Any, Any], sets: int) -> str:
    """The table as a page of the documentation; found: counts of every variant."""
    lines = [
        "# How much each rule decides",
        "",
        "Each rule of [the decision](diagnosis.md) at half and at twice its value, all others as "
        "they are; of `certain` what is missing to 1 is halved and doubled. "
        f"`python benches/rules.py` writes this page: {sets} campaigns of the trial's rig (seed 5: "
        + ", ".join(f"{n} {family}" for family, n in FAMILIES.items())
        + "), each searched once and judged under every variant.",
        "",
        "*held*: what is hidden is among what is certain, with one of each group. *something false "
        "certain*: in any campaign. *false alarm*: where nothing is hidden. Beside a count stands "
        f"its change against the rules in force. {dated()}.",
        "",
        "| rule | | " + " | ".join(COUNTS) + " |",
        "|---|---|" + "---|" * len(COUNTS),
        "| in force | | " + " | ".join(map(str, found[0])) + " |",
    ]
    for (rule, how, _), row in list(zip(variants(), found, strict=True))[1:]:
        cells = (
            f"{n} ({n - base:+d})" if n != base else f"{n}"
            for n, base in zip(row, found[0], strict=True)
        )
        lines.append(f"| `{rule}` | {how} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, ""])


def main() -> None:
    """All campaigns, on so many processes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--page", type=Path, default=PAGE)
    asked = parser.parse_args()
    tasks: list[Any] = [(f, i, asked.seed) for f, n in FAMILIES.items() for i in range(n)]
    with get_context("spawn").Pool(asked.workers) as pool:
        done = [c for c in pool.imap(judged, tasks) if c is not None]
    asked.page.write_text(page(np.sum(np.array(done), axis=0), len(done)), encoding="utf-8")


if __name__ == "__main__":
    main()
