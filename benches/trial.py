"""The trial: campaigns with a hidden effect, diagnosed and scored (what is scored: `trial_score`).

    python benches/trial.py [--sets N] [--null-sets M] [--seed S] [--workers 2] [--family F]
                            [--json OUT] [--page PAGE.md]

N is for each strength (single, outside) and each other family, M (else N) for each kind of noise
of campaigns that hide nothing. `make trial` is the full length and writes the page of the trial
(docs/explanation/trial.md). Campaigns come from the rig in tests/reference, which shares nothing
with the product; a diagnosis is given the case file and the table alone. Campaigns and answers are
kept in out/trial, under what they
depend on (the rig's source, the product's), so a second run adds only what is new; --fresh starts
over. --shuffle M answers M sets once more with the library in another order: an id is a label, its
place must not matter.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import sys
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from math import gcd
from pathlib import Path
from typing import Any

# One thread a worker: campaigns are small, and answers must not depend on the machine.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
os.environ["RAYON_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np

import cbpt
from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.inference.cross_validation import held_out_residual, rms
from cbpt.lab.inference.fit import Fit
from cbpt.lab.model import spring_priors as reach
from cbpt.lab.model.priors import Variant
from reference.rig_effects import OUTSIDE
from reference.rig_noise import NOISE_KINDS
from reference.rig_oracle import ask
from reference.rig_strength import NoSuchCampaignError
from reference.rig_trial import FAMILIES, SINGLES, STRENGTHS, Family, make_trial
from reference.trial_page import write_page
from reference.trial_score import Outcome, document, grade, measures, table

TOP = Path(__file__).parents[1]
KEPT = TOP / "out" / "trial"
OUTSIDE_STRENGTHS = 5
Task = tuple[Family, int, int]


# --- which campaigns --------------------------------------------------------------------------


def indices(family: Family, sets: int, null_sets: int | None = None) -> list[int]:
    """Indices of a family: every noise or strength `sets` times, effects in turn."""
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
    families: Iterable[Family], sets: int, seed: int, null_sets: int | None = None
) -> list[Task]:
    """All campaigns, families interleaved so that an unfinished trial holds some of each."""
    lists = [[(f, i, seed) for i in indices(f, sets, null_sets)] for f in families]
    order = sorted(
        (n / len(list_), k, n) for k, list_ in enumerate(lists) for n in range(len(list_))
    )
    return [lists[k][n] for _, k, n in order]


# --- what is kept -----------------------------------------------------------------------------


def fingerprint(paths: Iterable[Path]) -> str:
    """Of the contents of some files."""
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:12]


@cache
def rig_folder() -> Path:
    """Campaigns of this rig."""
    reference = TOP / "tests" / "reference"
    own = [*reference.glob("rig*.py"), reference / "forward.py", reference / "contact.py"]
    return KEPT / f"campaigns-{fingerprint(own)}"


@cache
def answer_folder() -> Path:
    """Answers of this product to campaigns of this rig."""
    package = Path(cbpt.__file__).parent
    product = [*(package / "lab").rglob("*.py"), *package.glob("_core*.so")]
    return KEPT / f"answers-{fingerprint(product)}-{rig_folder().name[-12:]}"


def _name(task: Task) -> str:
    family, index, seed = task
    return f"{family}_{seed}_{index}.json"


def _write(path: Path, value: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}")
    part.write_text(json.dumps(value, default=_number), encoding="utf-8")
    part.replace(path)


def _number(x: Any) -> Any:
    return x.tolist() if isinstance(x, np.ndarray | np.generic) else float(x)


def campaign(task: Task) -> dict[str, Any] | None:
    """Case file, table, truth and oracle; None where 40 draws did not come together."""
    path = rig_folder() / _name(task)
    if not path.exists():
        try:
            made = make_trial(*task)
        except NoSuchCampaignError:
            _write(path, None)
            return None
        made.truth["duration_s"] = float(np.ptp(made.rows.time_s))
        asked = vars(ask(made)) if task[0] in ("single", "pair") else None
        if asked and not np.isfinite(asked["held_out_arcsec"]):
            asked["held_out_arcsec"] = None
        columns = made.columns()
        _write(
            path, {"case": made.to_toml(), "columns": columns, "truth": made.truth, "oracle": asked}
        )
    found: dict[str, Any] | None = json.loads(path.read_text(encoding="utf-8"))
    return found


# --- one answer -------------------------------------------------------------------------------


def outcome(task: Task, fresh: bool = False) -> dict[str, Any] | None:
    """One campaign, made or found, and diagnosed."""
    path = answer_folder() / _name(task)
    if path.exists() and not fresh:
        found: dict[str, Any] | None = json.loads(path.read_text(encoding="utf-8"))
        return found
    given = campaign(task)
    if given is None:
        return None
    family, index, _ = task
    result: dict[str, Any] = {
        "family": family,
        "index": index,
        "truth": given["truth"],
        "oracle": given["oracle"],
    }
    start = time.perf_counter()
    try:
        result |= answered(diagnose(cbpt.Case.from_toml(given["case"]), table_of(given)))
    except (
        Exception
    ) as error:  # a set without an answer counts against the product, whatever the cause
        result["error"] = f"{type(error).__name__}: {error}"
    result["seconds"] = time.perf_counter() - start
    _write(path, result)
    return result


def table_of(given: dict[str, Any]) -> dict[str, np.ndarray[Any, Any]]:
    """The columns that are handed over."""
    return {name: np.array(values) for name, values in given["columns"].items()}


def answered(d: Diagnosis) -> dict[str, Any]:
    """What of an answer is scored."""
    v = d.verdict
    return {
        "answer": {
            "kind": v.kind,
            "effects": list(v.effects),
            "rivals": [list(g) for g in v.rivals],
            "probability": v.probability,
            "noise": list(v.noise),
        },
        "held_out": {
            "stated": d.ladder[0].held_out_rmse_arcsec,
            "refitted": d.ladder[1].held_out_rmse_arcsec,
            "after": rms(held_out_residual(d.competition.fitter, d.after, d.fold)),
        },
        "parameters": {e: d.parameters(d.after, e) for e in v.names},
        "criteria": criteria(d),
    }


def criteria(d: Diagnosis) -> dict[str, list[str]]:
    """What plain AIC and BIC pick among everything that was fitted, the stated u believed."""
    fits = d.competition.fits
    n = len(d.readings)

    def picked(price: float) -> list[str]:
        values = {names: _misfit(d, f) + price * len(f.unknowns) for names, f in fits.items()}
        best = min(values.values())
        return sorted(next(names for names, value in values.items() if value == best))

    return {"aic": picked(2.0), "bic": picked(float(np.log(n)))}


def _misfit(d: Diagnosis, fit: Fit) -> float:
    """Residuals against the stated uncertainty, and known numbers against theirs."""
    chi2 = float(np.sum((fit.residual_arcsec / d.competition.campaign.u_arcsec) ** 2))
    known = [u for u in fit.unknowns if np.isfinite(u.sd) and not u.log]
    return chi2 + sum(((fit.value(u) - u.mean) / u.sd) ** 2 for u in known)


def shuffled(task: Task) -> tuple[str, str] | None:
    """The answer with the library as it stands and in another order; None without a campaign."""
    given = campaign(task)
    if given is None:
        return None
    case, columns = cbpt.Case.from_toml(given["case"]), table_of(given)
    order: tuple[Variant, ...] = vars(reach)["VARIANTS"]
    mixed = list(order)
    random.Random(task[1]).shuffle(mixed)

    def said() -> str:
        v = diagnose(case, columns).verdict
        return f"{v.kind} {v.effects} {v.rivals}"

    try:
        first = said()
        vars(reach)["VARIANTS"] = tuple(mixed)
        return first, said()
    finally:
        vars(reach)["VARIANTS"] = order


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


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--sets", type=int, default=15, help="for each noise, strength or family")
    parser.add_argument("--null-sets", type=int, help="for each kind of noise; else as --sets")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--family", choices=FAMILIES, action="append", help="several may be given")
    parser.add_argument("--json", type=Path, help="where to write the score")
    parser.add_argument("--page", type=Path, help="where to write the score as a page")
    parser.add_argument(
        "--fresh", action="store_true", help="diagnose again what was diagnosed before"
    )
    parser.add_argument(
        "--shuffle", type=int, default=10, help="sets answered with the library reordered"
    )
    parser.add_argument("--quiet", action="store_true", help="the table alone")
    asked = parser.parse_args()
    work = tasks(asked.family or FAMILIES, asked.sets, asked.seed, asked.null_sets)
    answer_folder()  # what the sources are now, whatever happens to them during the trial
    outcomes = run(work, asked.workers, asked.fresh, asked.quiet)
    step = max(len(work) // max(asked.shuffle, 1), 1)
    with ProcessPoolExecutor(asked.workers) as pool:
        pairs = [p for p in pool.map(shuffled, work[::step][: asked.shuffle]) if p]
    changed = [p for p in pairs if p[0] != p[1]]
    print(table(measures(outcomes)))
    seconds = [o["seconds"] for o in outcomes]
    if seconds:
        print(f"{len(outcomes)} sets, {np.mean(seconds):.1f} s each, at most {max(seconds):.1f} s")
    print(f"library in another order: {len(changed)} of {len(pairs)} answers change")
    for first, second in changed:
        print(f"  {first} -> {second}")
    score = document(outcomes) | {
        "sets_each": asked.sets,
        "null_sets_each": asked.sets if asked.null_sets is None else asked.null_sets,
        "seed": asked.seed,
        "version": cbpt.__version__,
        "rig": rig_folder().name.split("-")[1],
        "order_of_library": {"sets": len(pairs), "changed": len(changed)},
    }
    if asked.json:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(json.dumps(score, indent=1) + "\n", encoding="utf-8")
    if asked.page:
        write_page(asked.page, score, outcomes)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
