"""How much of the oracle's lead is that it knows the hidden effect's exact shape.

    python benches/trial/blind.py --seed 5 11 [--page docs/explanation/trial-notes.md]

The oracle of the trial has the hidden effect exactly as it is, and a draw or two of the shape of
every other one. Nobody who reads a table knows an exponent or an engagement angle to the last
digit, so a second oracle is asked here: it has several draws of each form of every effect, of the
hidden one too, and not the hidden one as it is. Noise, rule and prior odds are the same. Single
effects, sets of at most two. `--page` writes the table between the marks of a page.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"
BENCHES = Path(__file__).parents[1]
sys.path[:1] = [str(BENCHES), str(BENCHES.parent / "tests")]

from unittest.mock import patch

import numpy as np
from page_table import parser_of, show_table

from reference.contact import Floats
from reference.rig.campaign import Campaign
from reference.rig.effects import Hidden, draw_hidden
from reference.rig.kinds import Kind, Values
from trial import candidates as forms
from trial import claims, wider
from trial.answers import outcome
from trial.evidence import posterior, spoken
from trial.families import Setting
from trial.run import SHORT
from trial.targets import by_oracle

DRAWS = 6
MOST = 2
MARKS = "<!-- blind: made by benches/trial/blind.py -->", "<!-- end of blind -->"


def _draws(kind: Kind, form: str, rng: np.random.Generator) -> Iterator[Values]:
    drawn = draw_hidden(kind, form, rng).values
    if "harmonic" in drawn:
        for order in range(2, 8):
            yield {**drawn, "harmonic": float(order)}
        return
    yield drawn
    if set(drawn) - {kind.size, "phase_rad"}:
        for _ in range(DRAWS - 1):
            yield draw_hidden(kind, form, rng).values


def without_the_truth(s: Setting, made: Campaign, _: tuple[Hidden, ...]) -> dict[str, Any]:
    """As the oracle of the trial, with drawn shapes alone."""
    signer = forms.Signer(s.yardstick)
    shifts = [s.shifts[n] / sd for n, sd in s.priors.items()]
    off: Floats = made.angle_rad - s.yardstick.angle_rad + s.yardstick.slopes_rad @ shifts
    left_out = ("run_offset",) if s.noise.offset_rad > 0 else ()
    with patch.object(forms, "_shapes", _draws):
        known = forms.candidates(signer, (), left_out)
    return {"answer": spoken(posterior(s.yardstick.whiten(off), known, MOST))}


def asked(task: tuple[Any, int, int]) -> dict[str, Any] | None:
    """What the trial has of a campaign, and what the second oracle says of it."""
    found = outcome(task, False)
    if found is None or not found.get("oracle"):
        return None
    with patch.object(wider, "oracle", without_the_truth):
        return {**found, "blind": wider.make_wider(*task)[1]}


def rows(seeds: list[int]) -> Iterator[str]:
    """Of the table."""
    work = [(f, index, seed) for f in ("one", "two") for seed in seeds for index in SHORT[f]]
    with ProcessPoolExecutor(2) as pool:
        every = [o for o in pool.map(asked, work) if o is not None]
    yield "| effects | sets | the product | with drawn shapes | the oracle |"
    yield "|---|---|---|---|---|"
    singles = [o for o in every if o["family"] == "one"]
    for d in (6.0, 8.0, 12.0):
        these = [o for o in singles if abs(o["truth"]["d"] / d - 1) < 0.15]
        yield _row(f"single, named, d = {d:g}", these, claims.named)
    pairs = [o for o in every if o["family"] == "two"]
    yield _row("pair, held", pairs, claims.all_held)
    yield _row("pair, named", pairs, claims.named)


def _row(what: str, these: list[dict[str, Any]], of: Callable[[claims.Outcome], bool]) -> str:
    blind = [of({**o, "answer": o["blind"]["answer"]}) for o in these]
    product, exact = [of(o) for o in these], [by_oracle(of)(o) for o in these]
    told = " | ".join(f"{sum(c)} ({np.mean(c):.0%})" for c in (product, blind, exact))
    return f"| {what} | {len(these)} | {told} |"


def main() -> None:
    """The table, on the screen or on a page."""
    parser = parser_of(__doc__)
    parser.add_argument("--seed", type=int, nargs="+", default=[5, 11])
    given = parser.parse_args()
    show_table(rows(given.seed), given.page, MARKS)


if __name__ == "__main__":
    main()
