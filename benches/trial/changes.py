"""Pairs of campaigns on one drive, of which nothing changed or one effect; what is said of them.

    python benches/trial/changes.py [--null-sets N] [--sets M] [--seed S] [--workers 2]
                                    [--page PAGE.md]

Each pair has a drive, a plan, and numbers off nominal that are the same before and after; half of
the pairs have an effect besides that does not change. The rig is the independent one. d is the
strength of the change on one campaign, as in the trial. `--page` writes the table between the
marks of a page.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

for _threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "benches"), str(ROOT / "tests")]

from page_table import parser_of, show_table

import cbpt
from reference.contact import Floats
from reference.rig import ARCSEC, drive_of, simulate
from reference.rig.campaign import PRIORS, draw_case, draw_plan, rows_of
from reference.rig.effects import LIBRARY, Hidden, draw_hidden
from reference.rig.noise import draw_noise
from trial.families import RIG_CLASS, SINGLES, Draw, Setting, drawn, rivals_of
from trial.strength import NoSuchCampaignError, draw_parameters

STRENGTHS = (6.0, 8.0, 12.0, 20.0)
CHANGING = tuple(i for i in SINGLES if i not in RIG_CLASS and i != "ball_diameter_lot")
"""Effects that may change; offsets and drifts of instruments are not what is asked."""
MARKS = "<!-- changes: made by benches/trial/changes.py -->", "<!-- end of changes -->"


@dataclass(frozen=True)
class Pair:
    """Two tables, and what changed between them: one id, or none."""

    case: dict[str, dict[str, object]]
    before: dict[str, Floats]
    after: dict[str, Floats]
    changed: str
    d: float
    truth: dict[str, object] = field(default_factory=dict)
    """What `drawn` notes."""


def make_pair(index: int, seed: int, null: bool) -> Pair:
    """Pair number index; the seed fixes everything that is random."""
    return drawn(partial(_made, index=index, null=null), (seed, 77 + int(null), index))


def _made(rng: np.random.Generator, noise_factor: float, *, index: int, null: bool) -> Pair:
    effect = CHANGING[index % len(CHANGING)]
    d = 0.0 if null else STRENGTHS[(index + index // len(CHANGING)) % len(STRENGTHS)]
    s = _setting(Draw(rng, noise_factor), effect)
    kept: tuple[Hidden, ...] = ()
    if index % 2:
        other = str(rng.choice([i for i in CHANGING if i not in rivals_of(effect)]))
        kept = (_hidden(s, other, float(rng.choice([8.0, 12.0, 20.0])), rng),)
    more = () if null else (_hidden(s, effect, d, rng),)
    with_it = bool(rng.random() < 0.7)  # else it is gone
    sides = [(), more] if with_it else [more, ()]
    tables = []
    for side in sides:
        clean = simulate(s.drive, s.rows, (*s.base, *kept, *side))
        tables.append(_table(s, s.noise.readings(clean, s.rows, rng)))
    return Pair(s.case, tables[0], tables[1], "" if null else effect, d)


def _setting(draw: Draw, effect: str) -> Setting:
    rng = draw.rng
    case = draw_case(rng)
    rows = rows_of(draw_plan(rng, (LIBRARY[effect].needs,)), case, rng)
    u = float(rng.choice([0.1, 0.2, 0.3])) * draw.noise_factor * ARCSEC
    noise = draw_noise("white", u, rng)
    return Setting(case, drive_of(case), rows, noise, draw_parameters(rng, PRIORS), dict(PRIORS))


def _hidden(s: Setting, effect: str, d: float, rng: np.random.Generator) -> Hidden:
    kind = LIBRARY[effect]
    found = s.yardstick.sized(draw_hidden(kind, kind.forms[0], rng), d)
    if not kind.signed and kind.neutral == 0 and abs(found.size) < kind.low:
        raise NoSuchCampaignError(f"{effect}: too small to be plausible", kind.low / found.size)
    return found


def _table(s: Setting, read_rad: Floats) -> dict[str, Floats]:
    rows = s.rows
    return {
        "run": rows.run,
        "cycle": rows.cycle,
        "time_s": rows.time_s,
        "torque_Nm": rows.torque_Nm,
        "preload_N": rows.preload_N,
        "input_angle_deg": np.rad2deg(rows.input_angle_rad),
        "temperature_degC": rows.temperature_degC,
        "elastic_angle_arcsec": read_rad / ARCSEC,
        "u_elastic_angle_arcsec": np.full(len(rows), s.noise.stated_u_rad / ARCSEC),
    }


@dataclass(frozen=True)
class Said:
    """What was said of a pair."""

    changed: str
    d: float
    kind: str
    named: tuple[str, ...]
    perhaps: tuple[str, ...]
    noise: bool

    def right(self, loose: bool = False) -> bool:
        """Whether the changed effect, or one that no data tells from it, is among the named."""
        named = self.named + (self.perhaps if loose else ())
        return bool(set(rivals_of(self.changed)) & set(named))


def said_of(index: int, seed: int, null: bool) -> Said:
    """The verdict on one pair."""
    pair = make_pair(index, seed, null)
    found = cbpt.change(pair.case, pair.before, pair.after).to_dict()
    verdict = found["verdict"]
    return Said(
        pair.changed,
        pair.d,
        verdict["kind"],
        tuple(dict.fromkeys(c["effect"] for c in verdict["changed"])),
        tuple(p["effect"] for p in verdict["perhaps"]),
        found["noise"]["changed"],
    )


def wilson(hits: int, n: int) -> tuple[float, float]:
    """The 95 % interval of a share."""
    if not n:
        return 0.0, 1.0
    z, p = 1.96, hits / n
    middle, half = p + z**2 / (2 * n), z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    return float((middle - half) / (1 + z**2 / n)), float((middle + half) / (1 + z**2 / n))


def lines(said: Sequence[Said]) -> list[str]:
    """The table of the page."""

    def row(what: str, chosen: Sequence[Said], hit: Sequence[bool], target: str) -> str:
        low, high = wilson(sum(hit), len(chosen))
        share = f"{sum(hit)} of {len(chosen)} ({low:.0%} to {high:.0%})"
        return f"| {what} | {share} | {target} |"

    null = [s for s in said if not s.changed]
    found = ["| pairs | share (95 % interval) | to reach |", "|---|---|---|"]
    false = [s.kind == "changed" for s in null]
    found.append(row("nothing changed: said that something did", null, false, "<= 5 %"))
    noisy = [s.noise for s in null]
    found.append(row("nothing changed: said that the scatter did", null, noisy, "<= 5 %"))
    for d in STRENGTHS:
        some = [s for s in said if s.changed and s.d == d]
        target = ">= 90 %" if d >= 8 else ""
        found.append(row(f"changed, d = {d:g}: named", some, [s.right() for s in some], target))
    strong = [s for s in said if s.d >= 8]
    found.append(row("d >= 8: named", strong, [s.right() for s in strong], ">= 90 %"))
    loose = [s.right(loose=True) for s in strong]
    found.append(row("d >= 8: named or perhaps", strong, loose, ""))
    wrong = [s.kind == "changed" and bool(s.named) and not s.right(loose=True) for s in strong]
    found.append(row("d >= 8: another one named", strong, wrong, ""))
    return found


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("--null-sets", type=int, default=100)
    parser.add_argument("--sets", type=int, default=100)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    jobs = [(i, True) for i in range(options.null_sets)]
    jobs += [(i, False) for i in range(options.sets)]
    jobs.sort()  # a run that is stopped has some of each
    with ProcessPoolExecutor(options.workers) as pool:
        tasks = [pool.submit(said_of, i, options.seed, null) for i, null in jobs]
        said = []
        for (i, null), task in zip(jobs, tasks, strict=True):
            said.append(task.result())
            print(i, "null" if null else "changed", said[-1], flush=True)
    show_table(lines(said), options.page, MARKS)


if __name__ == "__main__":
    main()
