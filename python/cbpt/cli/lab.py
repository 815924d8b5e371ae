"""The lab's verbs on the command line; those about campaigns to come are in `plan_verbs`.

compare     model against a table of readings, with effects fitted where asked
diagnose    which effect is missing
fit         add effects to a case
"""

from __future__ import annotations

import argparse
import csv
import re
import shlex
import sys
import time
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from cbpt.errors import ChooseSheet, Setting, Step, TakeColumn

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.lab.diagnosis.fitted import Fitted

# As in the Rust command line, whose help lists them.
SUCCESS, NO_SOLUTION = 0, 3
# Files that the table of results is written to.
RESULTS = (".csv", ".md", ".json")
_TABLE = "table of readings: CSV, xlsx, xls, ods, MATLAB, TDMS or Parquet"


# What verbs read, and the flags of what they write.
_INPUTS = ("case", "data", "bounds", "plan")
_OUTPUTS = ("out", "json", "plot", "results")


class Parser(argparse.ArgumentParser):
    """Tells the nearest flag where one is misspelt, and lets no verb write over what it reads."""

    def parse_args(self, args: Sequence[str]) -> argparse.Namespace:  # type: ignore[override]
        options = super().parse_args(args)
        inputs = [getattr(options, name, None) for name in _INPUTS]
        for flag in _OUTPUTS:
            out = getattr(options, flag, None)
            if not isinstance(out, str | Path) or not Path(out).exists():
                continue
            if any(path and Path(path).exists() and Path(path).samefile(out) for path in inputs):
                self.error(
                    f"--{flag} {out}: this file is read here and would be lost; give another name"
                )
        return options

    def error(self, message: str) -> NoReturn:
        unknown = re.search(r"unrecognized arguments: (--[\w-]+)", message)
        near = get_close_matches(unknown[1], self._option_string_actions, 1) if unknown else []
        super().error(f"{message}; did you mean {near[0]}?" if near else message)


def inputs(
    prog: str,
    description: str,
    epilog: str | None = None,
    table: tuple[str, str] = ("DATA", _TABLE),
    needed: bool = True,
) -> argparse.ArgumentParser:
    """A parser that takes a case, a table (its name and what it is) and what its headers mean."""
    parser = Parser(prog=prog, description=description, epilog=epilog)
    some: dict[str, Any] = {} if needed else {"nargs": "?"}
    parser.add_argument("case", metavar="CASE", type=Path, help="case file (TOML)", **some)
    parser.add_argument("data", metavar=table[0], type=Path, help=table[1], **some)
    parser.add_argument(
        "--column",
        metavar="HEADER=NAME",
        action="append",
        default=[],
        help="what a header means, for example Moment=torque_Nm; repeatable",
    )
    parser.add_argument(
        "--sheet",
        metavar="NAME",
        help="sheet of a workbook, struct of a MATLAB file or group of a TDMS file; else the first "
        "with readings",
    )
    parser.add_argument(
        "--only",
        metavar="COLUMN=VALUE",
        action="append",
        default=[],
        help="take these readings alone, for example preload_step=3; repeatable",
    )
    return parser


def add_plot(parser: argparse.ArgumentParser) -> None:
    """The flag that draws."""
    parser.add_argument("--plot", metavar="FILE", type=Path, help="draw to FILE.svg, .png or .pdf")


def check_plot(options: argparse.Namespace) -> None:
    """Before anything is computed."""
    if options.plot:
        from cbpt.figures.shared import check_picture_name

        check_picture_name(options.plot)


def add_results(parser: argparse.ArgumentParser) -> None:
    """Flags of the table of results."""
    parser.add_argument(
        "--results",
        metavar="FILE",
        nargs="?",
        const="-",
        help="every number with its uncertainty and what it rests on: print the table, or write it "
        "to FILE.csv, .md or .json",
    )
    for flag, what in (
        ("--torque-Nm", "load at which the results tell the elastic angle"),
        ("--preload-N", "the preload there; else that of the case"),
        ("--input-angle-deg", "the input angle there; else that of the case, or 0"),
    ):
        parser.add_argument(flag, metavar="VALUE", type=float, help=what)


def show_results(found: Diagnosis | Fitted, options: argparse.Namespace) -> None:
    """The table of results, printed or written."""
    load = options.torque_Nm, options.preload_N, options.input_angle_deg
    if options.results is None and load == (None, None, None):
        return
    results = found.results(*load)
    if options.results in (None, "-"):
        print(f"\n{results.report()}")
        return
    made = {".csv": results.to_csv, ".md": results.to_markdown, ".json": results.to_json}
    path = Path(options.results)
    path.write_text(made[path.suffix.lower()](), encoding="utf-8")


def check_results(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Before anything is computed."""
    name = options.results
    if name not in (None, "-") and Path(name).suffix.lower() not in RESULTS:
        parser.error(f"--results {name}: the name must end in {', '.join(RESULTS)}")


def optional_files(argv: list[str], **endings: tuple[str, ...]) -> list[str]:
    """The flags whose file may be left out, told from what comes after: `--json CASE DATA`."""
    told = []
    for place, word in enumerate(argv):
        known = endings.get(word.removeprefix("--")) if word.startswith("--") else None
        after = argv[place + 1] if place + 1 < len(argv) else "-"
        takes = known is not None and (after == "-" or after.lower().endswith(known))
        told.append(f"{word}=-" if known is not None and not takes else word)
    return told


def only_of(parser: argparse.ArgumentParser, options: argparse.Namespace) -> dict[str, str] | None:
    """What --only says."""
    only = {}
    for entry in options.only:
        column, equals, value = entry.partition("=")
        if not equals:
            parser.error(f"--only {entry}: expected COLUMN=VALUE, for example preload_step=3")
        only[column] = value
    return only or None


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


def in_flags(step: Step) -> str:
    """What a message tells to do, in the flags of the command line."""
    match step:
        case TakeColumn(header, column):
            return f"give --column {shlex.quote(f'{header}={column}')}"
        case ChooseSheet(name):
            return f"give --sheet {shlex.quote(name)}"
        case Setting(name):
            return {"columns": "--column", "sheet": "--sheet"}[name]


def compare(argv: list[str]) -> int:
    """cbpt compare CASE DATA"""
    from cbpt.lab.diagnosis.compare import compare as compared
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
    add_plot(parser)
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
    check_plot(options)
    with _Counter() as counter:
        comparison = compared(
            options.case,
            options.data,
            effects=options.effects,
            columns=columns or None,
            sheet=options.sheet,
            only=only_of(parser, options),
            progress=counter.show,
        )
    if options.out and options.out.suffix.lower() == ".json":
        options.out.write_text(comparison.to_json() + "\n", encoding="utf-8")
    elif options.out:
        names, rows = comparison.rows()
        with options.out.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([names, *rows])
    report = comparison.report(options.angle_unit, in_flags)
    print(comparison.to_json() if options.json else report)
    sys.stdout.flush()
    if options.plot:
        comparison.plot(options.plot, options.angle_unit)
    return SUCCESS if comparison.overall else NO_SOLUTION


def diagnose(argv: list[str]) -> int:
    """cbpt diagnose CASE DATA"""
    from cbpt.lab.diagnosis.by_level import DividedDiagnosis, diagnose_by
    from cbpt.lab.diagnosis.diagnose import diagnose as diagnosed
    from cbpt.lab.diagnosis.diagnosis import Diagnosis

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
    add_plot(parser)
    parser.add_argument(
        "--by",
        metavar="COLUMN",
        help="diagnose each level of a column by itself, and tell how the numbers change",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        help="of the simulated chances; the same seed, the same answer",
    )
    add_results(parser)
    options = parser.parse_args(optional_files(argv, json=(".json",), results=RESULTS))
    columns = columns_of(parser, options)
    check_results(parser, options)
    only = only_of(parser, options)
    if options.by and (options.plot or options.results):
        parser.error(
            "--plot and --results are of one diagnosis: take a level with --only, not --by"
        )
    check_plot(options)
    answer: Diagnosis | DividedDiagnosis
    given = {
        "columns": columns or None,
        "sheet": options.sheet,
        "only": only,
        "seed": options.seed,
    }
    if options.by:
        answer = diagnose_by(options.case, options.data, options.by, **given)
    else:
        with _Counter() as counter:
            answer = diagnosed(
                options.case,
                options.data,
                effects=options.effects,
                progress=counter.share,
                **given,
            )
            counter.share("what the answer rests on", 0.98)
            answer.to_dict()  # made once and kept
    if options.json == "-":
        print(answer.to_json())
    else:
        if options.json:
            Path(options.json).write_text(answer.to_json() + "\n", encoding="utf-8")
        print(answer.report(in_flags) if isinstance(answer, Diagnosis) else answer.report())
    if isinstance(answer, Diagnosis):
        if options.json != "-" or options.results not in (None, "-"):
            show_results(answer, options)
        sys.stdout.flush()
        if options.plot:
            answer.plot(options.plot)
    return SUCCESS


def fit(argv: list[str]) -> int:
    """cbpt fit CASE DATA --with EFFECT"""
    from cbpt.lab.diagnosis.fitted import fit as fitted

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
    add_results(parser)
    options = parser.parse_args(optional_files(argv, results=RESULTS))
    if options.out and options.out.suffix.lower() != ".toml":
        parser.error(f"--out {options.out}: the name of a case file ends in .toml")
    columns = columns_of(parser, options)
    check_results(parser, options)
    found = fitted(
        options.case,
        options.data,
        options.effects,
        columns=columns or None,
        sheet=options.sheet,
        only=only_of(parser, options),
    )
    if options.out:
        options.out.write_text(found.case.to_toml(), encoding="utf-8")
    print(found.report(in_flags))
    show_results(found, options)
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
        self._line(f"{done}/{total} readings solved ")

    def share(self, what: str, share: float) -> None:
        """As a diagnosis tells it."""
        self._line(f"{share:.0%} done, next: {what} ")

    def _line(self, text: str) -> None:
        if time.monotonic() - self.start > 1 and sys.stderr is not None and sys.stderr.isatty():
            self.shown = True
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    def __exit__(self, *error: object) -> None:
        if self.shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
