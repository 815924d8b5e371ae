"""Certified digits of the fit engine on the nonlinear problems of NIST StRD, beside SciPy.

    python benches/strd.py [--page docs/explanation/fits.md]

Each problem from both of its starts, with the same exact slopes for all. Digits are those of the
parameter that has fewest (LRE); the certified values have 11. `least_squares` of SciPy runs as it
comes, and with tolerances of 1e-15 and `x_scale="jac"`. `--page` writes the table between the marks
of a page.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from page_table import parser_of, show_table
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from cbpt.lab.inference.least_squares import minimise
from common.strd import AIM, Floats, Problem, digits, problems

TIGHT = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "x_scale": "jac", "max_nfev": 5000}
MARKS = "<!-- benches/strd.py -->", "<!-- end -->"


def main() -> None:
    show_table(lines(), parser_of(__doc__).parse_args().page, MARKS)


def lines() -> Iterator[str]:
    yield "| problem | level | CBPT | steps | SciPy as it comes | SciPy, tolerances 1e-15 |"
    yield "|---|---|---|---|---|---|"
    least = np.full((len(problems()), 3), np.inf)
    for row, problem in enumerate(problems()):
        own = [minimise(problem.residual, start, None, AIM) for start in problem.starts]
        assert own[0] is not None and own[1] is not None
        found = [
            [digits(end.x, problem.certified) for end in own if end],
            *([peer(problem, b, **how) for b in problem.starts] for how in ({}, TIGHT)),
        ]
        least[row] = np.min(found, axis=1)
        ours, *others = (" / ".join(f"{d:.1f}" for d in pair) for pair in found)
        steps = " / ".join(str(end.steps) for end in own if end)
        cells = [problem.name, problem.level.lower(), ours, steps, *others]
        yield f"| {' | '.join(cells)} |"
    worst = (f"{d:.1f}" for d in least.min(axis=0))
    six = (f"{n} of {len(least)}" for n in np.count_nonzero(least >= 6, axis=0))
    yield "| **fewest** | | {} | | {} | {} |".format(*worst)
    yield "| **6 or more from both starts** | | {} | | {} | {} |".format(*six)


def peer(problem: Problem, start: Any, **how: Any) -> float:
    """Digits that SciPy finds; 0 where it gives up with an error."""

    def off(b: Floats) -> Floats:
        return problem.model(b) - problem.y

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = least_squares(off, start, problem.slopes, **how)
        except ValueError:
            return 0.0
    return digits(found.x, problem.certified)


if __name__ == "__main__":
    main()
