"""Which campaigns, the run over them, and the command.

    python benches/trial [--short] [--sets N] [--null-sets M] [--seed S ...] [--workers 2]
                         [--family F] [--json OUT] [--page PAGE.md] [--section PAGE.md]

--short is for development, ten minutes on two cores (four to seventeen by the machine): some
campaigns of each wider family, and the table of what the answer has to reach alone. In full, N is
for each strength (single, outside) and each other family, M (else N) for each kind of noise of
campaigns that hide nothing; of the wider families N to 5 N. Campaigns and answers are kept as they
come: a run that was killed goes on where it was, and a second run diagnoses only what is new;
--fresh starts over.
--shuffle M answers M sets once more with the library in another order: an id is a label, its place
must not matter.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from math import gcd
from pathlib import Path
from typing import Any

import numpy as np

import cbpt
from reference.rig.effects import OUTSIDE
from reference.rig.noise import NOISE_KINDS
from trial.answers import Task, answer_folder, outcome, rig_folder, shuffled
from trial.families import FAMILIES, SINGLES, STRENGTHS, Family
from trial.grades import Outcome, grade
from trial.page import section, write_page
from trial.score import document, measures, plain, table
from trial.targets import targets
from trial.wider import WIDER, Wider

OUTSIDE_STRENGTHS = 5
SHORT: dict[Family | Wider, tuple[int, ...]] = {
    "null": tuple(range(28)),
    "parameter_only": tuple(range(4)),
    "confounded": tuple(range(6)),
    "outside": tuple(range(16, 32)),
    "one": tuple(range(48)),
    "two": tuple(range(40)),
    "three": tuple(range(12)),
    "strong": tuple(range(16)),
    "slide": tuple(range(15)),
    "coarse": tuple(range(20)),
    "artefact": tuple(range(24)),
    "small": tuple(range(24)),
    "lawless": tuple(range(18)),
    "spring": tuple(range(24)),
    "spring_artefact": tuple(range(12)),
    "spring_logged": tuple(range(12)),
}
"""Indices of each family in the short form."""
FOR_EACH: dict[Family | Wider, int] = {
    "one": 4,
    "two": 5,
    "three": 2,
    "strong": 2,
    "slide": 2,
    "coarse": 2,
    "artefact": 2,
    "small": 2,
    "lawless": 1,
    "spring": 3,
    "spring_artefact": 2,
    "spring_logged": 2,
}
"""Campaigns of a wider family for each of `--sets`."""


# --- which campaigns --------------------------------------------------------------------------


def indices(family: Family | Wider, sets: int, null_sets: int | None = None) -> list[int]:
    """Indices of a family: every noise or strength `sets` times, effects in turn."""
    if family in FOR_EACH:
        return list(range(sets * FOR_EACH[family]))
    if family == "null":
        return list(range((sets if null_sets is None else null_sets) * len(NOISE_KINDS)))
    if family == "single":
        return list(_crossed(sets, len(STRENGTHS), len(SINGLES), 5))
    if family == "outside":
        return list(_crossed(sets, OUTSIDE_STRENGTHS, len(OUTSIDE), 3))
    return list(range(sets))


def _crossed(sets: int, strengths: int, effects: int, stride: int) -> Iterator[int]:
    # Index = turn * effects + effect, the strength being turn % strengths; the stride has no
    # divisor in common with the number of effects: a full round has every effect at each strength.
    assert gcd(stride, effects) == 1
    for number in range(sets):
        for strength in range(strengths):
            turn = strength + strengths * (number // effects)
            yield turn * effects + (stride * number + 2 * strength) % effects


def tasks(
    families: Iterable[Family | Wider], sets: int, seed: int, null_sets: int | None = None
) -> list[Task]:
    """All campaigns, families interleaved so that an unfinished trial holds some of each."""
    return interleaved({f: indices(f, sets, null_sets) for f in families}, seed)


def interleaved(chosen: Mapping[Family | Wider, Sequence[int]], seed: int) -> list[Task]:
    """Some indices of each family, an equal share of each at any time."""
    lists: list[list[Task]] = [[(f, i, seed) for i in some] for f, some in chosen.items()]
    order = sorted(
        (n / len(list_), k, n) for k, list_ in enumerate(lists) for n in range(len(list_))
    )
    return [lists[k][n] for _, k, n in order]


# --- the run ----------------------------------------------------------------------------------


def told(o: Outcome) -> str:
    """One line on an answer that is not right."""
    t, a = o["truth"], o.get("answer", {})
    hidden = ", ".join(f"{h['id']} ({h['form']})" for h in t["hidden"]) or "nothing"
    d = f" d {t['d']:g}" if t.get("d") else ""
    said = o.get("error") or f"{a['kind']} {a['effects']} {a['rivals']} p {a['probability']:.2f}"
    return f"{grade(o):9}{o['family']} {o['index']} {t['noise']['kind']}: {hidden}{d} -> {said}"


def run(work: list[Task], workers: int, fresh: bool, quiet: bool) -> list[Outcome]:
    """Every campaign diagnosed, told as they come."""
    done: list[Outcome] = []
    with ProcessPoolExecutor(workers) as pool:
        for number, found in enumerate(pool.map(outcome, work, [fresh] * len(work)), 1):
            if found is None:
                continue
            done.append(found)
            if not quiet and grade(found) not in ("right", "contains"):
                print(told(found), flush=True)
            if number % 50 == 0:
                print(f"{number} of {len(work)}", file=sys.stderr, flush=True)
    return done


def arguments() -> argparse.Namespace:
    """What the command was given."""
    head = "The trial: campaigns with a hidden effect, diagnosed and scored."
    parser = argparse.ArgumentParser(prog="python benches/trial", description=head)
    short = "about ten minutes on two cores, for development"
    parser.add_argument("--short", action="store_true", help=short)
    parser.add_argument("--sets", type=int, default=15, help="for each noise, strength or family")
    parser.add_argument("--null-sets", type=int, help="for each kind of noise; else as --sets")
    several = "of the campaigns; with --short several may be given"
    parser.add_argument("--seed", type=int, default=[1], nargs="+", help=several)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--family", choices=(*FAMILIES, *WIDER), action="append", help="several may be given"
    )
    parser.add_argument("--json", type=Path, help="where to write the score")
    parser.add_argument("--page", type=Path, help="where to write the score as a page")
    section = "where to write the table of what is to be reached, as Markdown"
    parser.add_argument("--section", type=Path, help=section)
    fresh = "diagnose again what was diagnosed before"
    parser.add_argument("--fresh", action="store_true", help=fresh)
    mixed = "sets answered with the library in another order"
    parser.add_argument("--shuffle", type=int, default=10, help=mixed)
    parser.add_argument("--quiet", action="store_true", help="the table alone")
    return parser.parse_args()


def reordered(work: Sequence[Task], sets: int, workers: int) -> dict[str, int]:
    """How many of some sets are answered otherwise with the library in another order; told too."""
    step = max(len(work) // max(sets, 1), 1)
    with ProcessPoolExecutor(workers) as pool:
        pairs = [p for p in pool.map(shuffled, work[::step][:sets]) if p]
    changed = [p for p in pairs if p[0] != p[1]]
    print(f"library in another order: {len(changed)} of {len(pairs)} answers change")
    for first, second in changed:
        print(f"  {first} -> {second}")
    return {"sets": len(pairs), "changed": len(changed)}


def of_targets(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """The table of what is to be reached as plain values."""
    return {"sets": len(outcomes), "measures": [plain(m) for m in targets(outcomes)]}


def main() -> int:
    """The trial as asked for."""
    asked = arguments()
    families: tuple[Family | Wider, ...] = asked.family or (*FAMILIES, *WIDER)
    if asked.short:
        short = {f: some for f, some in SHORT.items() if f in families}
        work = [task for seed in asked.seed for task in interleaved(short, seed)]
    else:
        (seed,) = asked.seed
        work = tasks(families, asked.sets, seed, asked.null_sets)
    answer_folder()  # what the sources are now, whatever happens to them during the trial
    every = run(work, asked.workers, asked.fresh, asked.quiet)
    print(table(targets(every)))
    if asked.section:
        asked.section.write_text(section(every, asked.seed), encoding="utf-8")
    if asked.page:
        write_page(asked.page, every, asked.seed)
    if asked.short:
        if asked.json:
            asked.json.write_text(json.dumps(of_targets(every), indent=1) + "\n", encoding="utf-8")
        return 0
    outcomes = [o for o in every if o["family"] in FAMILIES]
    print(table(measures(outcomes)))
    seconds = [o["seconds"] for o in outcomes]
    if seconds:
        print(f"{len(outcomes)} sets, {np.mean(seconds):.1f} s each, at most {max(seconds):.1f} s")
    score = document(outcomes) | {
        "sets_each": asked.sets,
        "null_sets_each": asked.sets if asked.null_sets is None else asked.null_sets,
        "seed": seed,
        "version": cbpt.__version__,
        "rig": rig_folder().name.split("-")[1],
        "order_of_library": reordered(work, asked.shuffle, asked.workers),
        "targets": of_targets(every),
    }
    if asked.json:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(json.dumps(score, indent=1) + "\n", encoding="utf-8")
    return 0
