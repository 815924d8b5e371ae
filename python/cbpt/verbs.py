"""The lab's verbs on the command line: compare is in `commands`, here are diagnose and fit."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

SUCCESS = 0


def inputs(prog: str, description: str) -> argparse.ArgumentParser:
    """A parser that takes a case, a table and what its headers mean."""
    parser = argparse.ArgumentParser(prog=prog, description=description)
    parser.add_argument("case", metavar="CASE", type=Path, help="case file (TOML)")
    parser.add_argument("data", metavar="DATA", type=Path, help="table of readings (CSV)")
    parser.add_argument(
        "--column",
        metavar="HEADER=NAME",
        action="append",
        default=[],
        help="what a header means, for example Moment=torque_Nm; repeatable",
    )
    return parser


def columns_of(parser: argparse.ArgumentParser, options: argparse.Namespace) -> dict[str, str]:
    """What --column says; the order of CASE and DATA is checked on the way."""
    if options.case.suffix.lower() != ".toml" and options.data.suffix.lower() == ".toml":
        parser.error(f"CASE comes first: {parser.prog} {options.data} {options.case}")
    columns = {}
    for entry in options.column:
        header, equals, name = entry.rpartition("=")
        if not equals:
            parser.error(f"--column {entry}: expected HEADER=NAME, for example Moment=torque_Nm")
        columns[header] = name
    return columns


def diagnose(argv: list[str]) -> int:
    """cbpt diagnose CASE DATA"""
    from cbpt.lab.diagnose import diagnose as diagnosed

    parser = inputs(
        "cbpt diagnose",
        "Say which effect the readings demand, that none is needed, or that they cannot tell.",
    )
    parser.add_argument(
        "--json",
        metavar="OUT",
        nargs="?",
        const="-",
        help="write the whole answer to OUT.json; without a name, print it in place of the text",
    )
    parser.add_argument("--plot", metavar="FILE", type=Path, help="draw to FILE.svg, .png or .pdf")
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        help="of the simulated chances; the same seed, the same answer",
    )
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    if options.plot:
        from cbpt.page.comparison_figure import check_picture_name

        check_picture_name(options.plot)
    answer = diagnosed(options.case, options.data, columns=columns or None, seed=options.seed)
    if options.json == "-":
        print(answer.to_json())
    else:
        if options.json:
            Path(options.json).write_text(answer.to_json() + "\n", encoding="utf-8")
        print(answer.report())
    sys.stdout.flush()
    if options.plot:
        answer.plot(options.plot)
    return SUCCESS


def fit(argv: list[str]) -> int:
    """cbpt fit CASE DATA --with EFFECT"""
    from cbpt.lab.fitting import fit as fitted

    parser = inputs(
        "cbpt fit",
        "Fit effects of the library to readings, the numbers of the drive within their stated "
        "uncertainties, and write the case with them in it, to compare again.",
    )
    parser.add_argument(
        "--with",
        dest="effects",
        metavar="EFFECT",
        nargs="+",
        required=True,
        help="ids of effects, see cbpt effects",
    )
    parser.add_argument("--out", metavar="CASE2", type=Path, help="write the case with the effects")
    options = parser.parse_args(argv)
    if options.out and options.out.suffix.lower() != ".toml":
        parser.error(f"--out {options.out}: the name of a case file ends in .toml")
    columns = columns_of(parser, options)
    found = fitted(options.case, options.data, options.effects, columns=columns or None)
    if options.out:
        options.out.write_text(found.case.to_toml(), encoding="utf-8")
    print(found.report())
    return SUCCESS
