"""Campaigns made and diagnosed, each kept on disk under what it depends on.

    campaign    case file, table and truth of a task, made by the rig or found
    outcome     the same with what the product answers
    criteria    what plain AIC and BIC pick among the same fits
    shuffled    whether an answer depends on the order of the library

A campaign depends on the source of the rig and of its makers here, an answer on the product's as
well: the names of their folders in out/trial are made of those. A diagnosis is given the case file
and the table alone.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import time
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np

import cbpt
from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.inference.cross_validation import held_out_residual, rms
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model import spring_priors as reach
from cbpt.lab.model.priors import Variant
from trial.adapter import kept, read
from trial.families import FAMILIES, Family, make_trial
from trial.oracle import ask
from trial.strength import NoSuchCampaignError
from trial.wider import Wider, make_wider

TOP = Path(__file__).parents[2]
KEPT = TOP / "out" / "trial"
MAKERS = (
    "candidates.py",
    "evidence.py",
    "families.py",
    "oracle.py",
    "rivals.py",
    "spring_sets.py",
    "strength.py",
    "wider.py",
)
"""What of this folder a campaign depends on."""
Task = tuple[Family | Wider, int, int]
"""Family, index, seed."""


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
    model = [reference / f"{part}.py" for part in ("contact", "equilibrium", "forward", "pairs")]
    makers = [Path(__file__).with_name(name) for name in MAKERS]
    own = [*(reference / "rig").glob("*.py"), *model, *makers]
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
            _write(path, _made(task))
        except NoSuchCampaignError:
            _write(path, None)
    found: dict[str, Any] | None = json.loads(path.read_text(encoding="utf-8"))
    return found


def _made(task: Task) -> dict[str, Any]:
    family, index, seed = task
    asked: dict[str, Any] | None
    if family not in FAMILIES:
        made, asked = make_wider(cast(Wider, family), index, seed)
    else:
        made = make_trial(family, index, seed)
        asked = vars(ask(made)) if family in ("single", "pair") else None
        if asked and not np.isfinite(asked["held_out_arcsec"]):
            asked["held_out_arcsec"] = None
    made.truth["duration_s"] = float(np.ptp(made.rows.time_s))
    columns = made.columns()
    return {"case": made.to_toml(), "columns": columns, "truth": made.truth, "oracle": asked}


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
    start, worked = time.perf_counter(), time.process_time()
    try:
        d = diagnose(cbpt.Case.from_toml(given["case"]), table_of(given))
        result["cpu_seconds"] = time.process_time() - worked
        result |= answered(d) if family in FAMILIES else documented(d)
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
            "undecided": v.kind == "undecided",
        },
        "held_out": {
            "stated": d.ladder[0].held_out_rmse_arcsec,
            "refitted": d.ladder[1].held_out_rmse_arcsec,
            "after": rms(held_out_residual(d.competition.fitter, d.after, d.fold)),
        },
        "parameters": {e: d.parameters(d.after, e) for e in v.names},
        "criteria": criteria(d),
    }


def documented(d: Diagnosis) -> dict[str, Any]:
    """What of an answer's document is scored, and the document without its long lists."""
    document = d.to_dict()
    drive = {
        u.name.partition(".")[0]: [d.after.value(u) - u.mean, d.after.u(u)]
        for u in d.after.unknowns
        if np.isfinite(u.sd)
    }
    return {"answer": read(document).plain(), "document": kept(document), "drive": drive}


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
