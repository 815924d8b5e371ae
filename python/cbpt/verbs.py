"""The lab's verbs on the command line.

compare     model against a table of readings, with effects fitted where asked
diagnose    which effect is missing
fit         add effects to a case
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from pathlib import Path

# As in the Rust command line, whose help lists them.
SUCCESS, NO_SOLUTION = 0, 3


def inputs(prog: str, description: str, epilog: str | None = None) -> argparse.ArgumentParser:
    """A parser that takes a case, a table and what its headers mean."""
    parser = argparse.ArgumentParser(prog=prog, description=description, epilog=epilog)
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


def compare(argv: list[str]) -> int:
    """cbpt compare CASE DATA"""
    from cbpt.lab.compare import compare as compared
    from cbpt.results import ANGLE_UNITS

    parser = inputs(
        "cbpt compare",
        "Solve the model at every reading; say how far off it is, and where.",
        epilog="The table's columns: run, time_s, torque_Nm, preload_N, input_angle_deg, "
        "temperature_degC, elastic_angle_arcsec, u_elastic_angle_arcsec; torque, preload and "
        "angle are needed. Other names and units are read where they are clear.",
    )
    parser.add_argument(
        "--with",
        metavar="EFFECT",
        nargs="+",
        action="extend",
        default=[],
        dest="effects",
        help="effects of the library, or own effects of the case, to fit to the readings; the "
        "report tells before and after",
    )
    parser.add_argument("--plot", metavar="FILE", type=Path, help="draw to FILE.svg, .png or .pdf")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="write FILE.csv (reading, model and residual of every row) or FILE.json",
    )
    parser.add_argument(
        "--angle-unit", choices=list(ANGLE_UNITS), default="arcsec", help="unit of text and plot"
    )
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    if options.out and options.out.suffix.lower() not in (".csv", ".json"):
        parser.error(f"--out {options.out}: the name must end in .csv or .json")
    if options.plot:
        from cbpt.page.comparison_figure import check_picture_name

        check_picture_name(options.plot)
    with _Counter() as counter:
        comparison = compared(
            options.case,
            options.data,
            effects=options.effects,
            columns=columns or None,
            progress=counter.show,
        )
    if options.out and options.out.suffix.lower() == ".json":
        options.out.write_text(comparison.to_json() + "\n", encoding="utf-8")
    elif options.out:
        names, rows = comparison.rows()
        with options.out.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([names, *rows])
    print(comparison.to_json() if options.json else comparison.report(options.angle_unit))
    sys.stdout.flush()
    if options.plot:
        comparison.plot(options.plot, options.angle_unit)
    return SUCCESS if comparison.overall else NO_SOLUTION


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
    parser.add_argument(
        "--with",
        metavar="EFFECT",
        nargs="+",
        action="extend",
        default=[],
        dest="effects",
        help="own effects of the case that are to compete instead of being taken as given",
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
    answer = diagnosed(
        options.case,
        options.data,
        effects=options.effects,
        columns=columns or None,
        seed=options.seed,
    )
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
        help="ids of effects, see cbpt effects, or of own effects of the case",
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
    if options.out:
        print(f"Wrote {options.out}: the case with the effect in it.")
    return SUCCESS


class _Counter:
    """A line on the terminal for what takes longer than a second; gone when the work is done."""

    def __init__(self) -> None:
        self.start = time.monotonic()
        self.shown = False

    def __enter__(self) -> _Counter:
        return self

    def show(self, done: int, total: int) -> None:
        if time.monotonic() - self.start > 1 and sys.stderr is not None and sys.stderr.isatty():
            self.shown = True
            print(f"\r{done}/{total} readings solved ", end="", file=sys.stderr, flush=True)

    def __exit__(self, *error: object) -> None:
        if self.shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
