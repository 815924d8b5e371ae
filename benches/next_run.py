"""Suggested next runs against random ones: how many runs bring the same certainty.

    python benches/next_run.py [--seeds N] [--draws M]

Effects are hidden one at a time, at several strengths, in a short campaign of the example's drive;
where the diagnosis leaves rivals, runs are added until every two of them are expected to be 20 : 1
apart (linearised), once as suggested and M times at random among the same candidates. Random orders
that do not get there within 15 runs count as 15, which favours them.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np

from common.next_runs import HIDDEN, race, scaled, view_of

TOP = Path(__file__).parents[1]
MOST = 15
STRENGTHS = (1.0, 1.5, 2.0, 0.7, 3.0, 4.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--draws", type=int, default=5)
    options = parser.parse_args()
    rng = np.random.default_rng(1)
    mine: list[int] = []
    drawn: list[float] = []
    out = 0
    undecided = 0
    for effect, values in HIDDEN:
        for seed in range(options.seeds):
            hidden = scaled(values, STRENGTHS[seed % len(STRENGTHS)])
            view = view_of(TOP / "examples" / "campaign.toml", effect, hidden, seed)
            if view is None:
                out += 1
                continue
            found = race(view, rng, options.draws, MOST)
            if found is None:
                undecided += 1
                continue
            assert found.suggested is not None
            counts = [MOST if n is None else n for n in found.random]
            mine.append(found.suggested)
            drawn.append(float(np.mean(counts)))
            rivals = ", ".join(view.names)
            print(f"{effect:22s} {found.suggested:3d} {drawn[-1]:6.1f}   {rivals}", flush=True)
    print(
        f"{len(mine)} races; {out} without rivals that runs could tell apart, {undecided} undecided"
    )
    if mine:
        ratio = sum(mine) / sum(drawn)
        each = float(np.median(np.array(mine) / np.array(drawn)))
        print(f"runs suggested over runs at random: {ratio:.2f} in all, {each:.2f} in the median")
        print(f"to reach: 0.60; {'reached' if ratio <= 0.6 else 'not reached'}")


if __name__ == "__main__":
    main()
