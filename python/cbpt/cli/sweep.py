"""`cbpt sweep PLAN --out FILE.parquet`; every other sweep of the command line is the core's."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from cbpt._core import SweepTally, is_sweep_plan
from cbpt.cli.options import Parser

__all__ = ["is_for_parquet", "sweep"]


CHUNK_ROWS = "rows at a time, in whole blocks of 8192, which is the least (65536)"


def is_for_parquet(argv: Sequence[str]) -> bool:
    """Whether a command line is a sweep of a plan whose rows go to a Parquet file."""
    if argv[:1] != ["sweep"] or not any(is_sweep_plan(Path(word)) for word in argv[1:]):
        return False
    pairs = zip(argv, [*argv[1:], ""], strict=True)
    named = [word.partition("=")[2] or after for word, after in pairs if word.startswith("--out")]
    return any(name.lower().endswith(".parquet") for name in named)


def sweep(argv: list[str]) -> int:
    """cbpt sweep PLAN --out FILE.parquet"""
    from cbpt.sweeps.run import SweepPlan, Work, open_output, to_output

    parser = Parser(
        prog="cbpt sweep",
        description="Vary any parameter of drive, load or effects; rows to Parquet.",
    )
    parser.add_argument("plan", metavar="PLAN", help="TOML file that names a case and has [axes]")
    parser.add_argument("--out", required=True, metavar="FILE", help="file for the rows")
    parser.add_argument("--chunk-rows", type=_positive, metavar="N", help=CHUNK_ROWS)
    parser.add_argument("--fresh", action="store_true", help="start again and replace FILE")
    options = parser.parse_args(argv)
    plan = SweepPlan.from_file(options.plan)
    with closing(open_output(plan, Path(options.out), options.fresh)) as output:
        found, complete = output.done, output.done >= plan.rows
        shown = sys.stderr is not None and sys.stderr.isatty() and not complete
        for remark in [] if complete else plan.remarks:
            print(f"cbpt: {remark}", file=sys.stderr)
        tally = SweepTally(plan)
        work = Work(chunk_rows=options.chunk_rows, progress=shown)
        to_output(plan, output, work, tally)
    earlier = f", {found} of them from an earlier sweep" if 0 < found < plan.rows else ""
    unchecked = f"; {output.unchecked}" if output.unchecked else ""
    text = (
        f"{options.out}: the file has all {plan.rows} rows already{unchecked}"
        if complete
        else f"{options.out}: {plan.rows} rows{earlier}; the status column says where there is no "
        "solution"
    )
    print(text, flush=True)
    ended = tally.text()
    if ended:
        print(f"cbpt: {ended}", file=sys.stderr)
    return 0


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}: expected 1 or more")
    return number
