"""What the verbs of the command line share: parsers, flags and what they mean, answers printed.

Parser, of_case, inputs     parsers of a case, and of a case with a table
add_*                       one flag, or a few that belong together
Load, load_of               what the flags of a load say
check_*                     refuse before anything is computed
columns_of, only_of         what --column and --only say
in_flags                    what a message tells to do, in flags
show, tell                  text and errors as the terminal takes them
show_answer, show_results   answers printed or written
Counter                     progress on a terminal
"""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Protocol, TextIO, TypedDict

from cbpt._core import painted, terminal_colour
from cbpt.errors import ChooseSheet, Setting, Step, TakeColumn
from cbpt.lab.wording.layout import within
from cbpt.lab.wording.numbers import listed
from cbpt.results import ANGLE_UNITS
from cbpt.whole_files import write_whole

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.lab.diagnosis.fitted import Fitted

# As in the Rust command line, whose help lists them.
SUCCESS, NO_SOLUTION = 0, 3
RESULTS = (".csv", ".md", ".json")
"""Files that the table of results is written to."""
_TABLE = "table of readings: CSV, xlsx, xls, ods, MATLAB, TDMS or Parquet"

# What verbs read, and the flags of what they write.
_INPUTS = ("case", "data", "after", "bounds", "plan")
_OUTPUTS = ("out", "json", "plot", "results")


_ENDINGS = {"--json": (".json",), "--results": RESULTS}
"""Of files whose flag may stand alone, by which they are told from CASE and DATA."""


class Parser(argparse.ArgumentParser):
    """Suggests the nearest flag for a misspelt one, and lets no verb overwrite its inputs."""

    def parse_args(self, args: Sequence[str]) -> argparse.Namespace:  # type: ignore[override]
        self._words = list(args)
        options, unknown = self.parse_known_args(args)
        if unknown:
            hint = self._nearest(unknown) or self._endings()
            self.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
        inputs = [getattr(options, name, None) for name in _INPUTS]
        for flag in _OUTPUTS:
            out = getattr(options, flag, None)
            if not isinstance(out, str | Path) or not Path(out).exists():
                continue
            if any(path and Path(path).exists() and Path(path).samefile(out) for path in inputs):
                self.error(
                    f"--{flag} {out}: the command reads this file and would overwrite it; give "
                    "another name"
                )
        return options

    def error(self, message: str) -> NoReturn:
        """Says too which flag took a file for one of its values."""
        super().error(message + self._taken())

    def _taken(self) -> str:
        """The flag of several values that took files, in words; empty where none did."""
        many = {flag for a in self._actions if a.nargs == "+" for flag in a.option_strings}
        flag, taken = "", list[str]()
        for word in self._words:
            if word.startswith("--"):
                flag = word
            elif flag in many and Path(word).suffix:
                taken.append(word)
        if not taken:
            return ""
        which = next(word for word in self._words if word in many)
        return f"; {listed(taken)} went to {which}: put the files before it"

    def _endings(self) -> str:
        """What a file after a flag that may stand alone ends in, where one stands alone."""
        alone = [word.removesuffix("=-") for word in self._words if word.endswith("=-")]
        known = [f"after {f} ends in {listed(_ENDINGS[f], 'or')}" for f in alone if f in _ENDINGS]
        return f"; a file {'; '.join(known)}" if known else ""

    def _nearest(self, unknown: Sequence[str]) -> str:
        """The flag that the first unknown one may stand for, in words; empty where none is."""
        flags = [word.partition("=")[0] for word in unknown if word.startswith("--")]
        near = get_close_matches(flags[0], self._option_string_actions, 1) if flags else []
        return f"; did you mean {near[0]}?" if near else ""


def of_case(
    prog: str, description: str, epilog: str | None = None, **some: Any
) -> argparse.ArgumentParser:
    """A parser that takes a case."""
    parser = Parser(prog=prog, description=description, epilog=epilog)
    parser.add_argument("case", metavar="CASE", type=Path, help="case file (TOML)", **some)
    return parser


def inputs(
    prog: str,
    description: str,
    epilog: str | None = None,
    table: tuple[str, str] = ("DATA", _TABLE),
    needed: bool | str = True,
) -> argparse.ArgumentParser:
    """A parser that takes a case, a table (its name and what it is) and what its headers mean;
    needed: both, none (False), or only the case ("case")."""
    optional: dict[str, Any] = {"nargs": "?"}
    parser = of_case(prog, description, epilog, **({} if needed else optional))
    of_table = {} if needed is True else optional
    parser.add_argument("data", metavar=table[0], type=Path, help=table[1], **of_table)
    parser.add_argument(
        "--column",
        metavar="HEADER=NAME",
        action="append",
        default=[],
        help="meaning of a header, for example Moment=torque_Nm; may be repeated",
    )
    parser.add_argument(
        "--sheet",
        metavar="NAME",
        help="sheet of a workbook, struct of a MATLAB file or group of a TDMS file (default: the "
        "first with readings)",
    )
    parser.add_argument(
        "--only",
        metavar="COLUMN=VALUE",
        action="append",
        default=[],
        help="use only these readings, for example preload_step=3; may be repeated, for another "
        "value of the column or for another column",
    )
    return parser


# --- flags --------------------------------------------------------------------------------


def add_plot(
    parser: argparse.ArgumentParser, what: str = "draw a plot to FILE.svg, .png or .pdf"
) -> None:
    """The flag that draws."""
    parser.add_argument("--plot", metavar="FILE", type=Path, help=what)


def add_json(parser: argparse.ArgumentParser) -> None:
    """The flag for the JSON document."""
    parser.add_argument(
        "--json",
        metavar="OUT",
        nargs="?",
        const="-",
        help="write the complete answer to OUT.json; without a name, print it instead of the text",
    )


def add_angle_unit(
    parser: argparse.ArgumentParser, units: Iterable[str] = ANGLE_UNITS, of: str = "text and plot"
) -> None:
    """The flag for the unit of angles; `of`: of what."""
    parser.add_argument(
        "--angle-unit",
        choices=list(units),
        default="arcsec",
        help=f"unit of angles in {of}",
    )


def add_seed(parser: argparse.ArgumentParser, same: str) -> None:
    """The flag for the seed of random numbers; `same`: what the same seed gives again."""
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        help=f"seed of the random numbers (default 0); the same seed gives the same {same}",
    )


def add_load(
    parser: argparse.ArgumentParser,
    at: str = "",
    *,
    torque: str = "resistance torque",
    angle: bool = True,
) -> None:
    """Flags of a load, in place of that of the case; the angle where it is at one."""
    flags = [("--torque-Nm", "T", torque), ("--preload-N", "F", "axial preload")]
    if angle:
        flags.append(("--input-angle-deg", "A", "angle of the input crank"))
    for flag, metavar, what in flags:
        words = f"{what}{at}, instead of that of the case"
        parser.add_argument(flag, metavar=metavar, type=float, help=words)


class Load(TypedDict):
    """A load, in place of that of the case where it is given."""

    torque_Nm: float | None
    preload_N: float | None
    input_angle_deg: float | None


def load_of(options: argparse.Namespace) -> Load:
    """What the flags of a load say."""
    return Load(
        torque_Nm=options.torque_Nm,
        preload_N=options.preload_N,
        input_angle_deg=options.input_angle_deg,
    )


def add_effects(parser: argparse.ArgumentParser, what: str, required: bool = False) -> None:
    """The flag that names effects."""
    parser.add_argument(
        "--with",
        metavar="EFFECT",
        nargs="+",
        action="extend",
        default=None if required else [],
        required=required,
        dest="effects",
        help=what,
    )


COMPETING = "own effects of the case to test as the missing effect, instead of assuming them"
"""What --with names in a diagnosis."""


def add_results(parser: argparse.ArgumentParser) -> None:
    """Flags of the table of results."""
    parser.add_argument(
        "--results",
        metavar="FILE",
        nargs="?",
        const="-",
        help="print a table of all parameters with their uncertainties and what these depend on, "
        "or write it to FILE.csv, .md or .json",
    )
    add_load(parser, " at which the results state the elastic angle")


# --- checks, before anything is computed --------------------------------------------------


def check_plot(options: argparse.Namespace) -> None:
    """Refuse a picture whose ending is not known."""
    if options.plot:
        from cbpt.figures.shared import check_picture_name

        check_picture_name(options.plot)


def check_name(
    parser: argparse.ArgumentParser, flag: str, path: Path | None, *endings: str
) -> None:
    """Refuse a file whose name has none of the endings."""
    if path and path.suffix.lower() not in endings:
        parser.error(f"{flag} {path}: the name must end in {listed(endings, 'or')}")


def check_results(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Refuse a table of results whose ending is not known."""
    if options.results not in (None, "-"):
        check_name(parser, "--results", Path(options.results), *RESULTS)


# --- what flags say -----------------------------------------------------------------------


def optional_files(argv: list[str], **endings: tuple[str, ...]) -> list[str]:
    """The flags whose file may be left out, told from what comes after: `--json CASE DATA`."""
    words = []
    for place, word in enumerate(argv):
        known = endings.get(word.removeprefix("--")) if word.startswith("--") else None
        after = argv[place + 1] if place + 1 < len(argv) else "-"
        takes = known is not None and (after == "-" or after.lower().endswith(known))
        words.append(f"{word}=-" if known is not None and not takes else word)
    return words


def only_of(
    parser: argparse.ArgumentParser, options: argparse.Namespace
) -> dict[str, list[str]] | None:
    """What --only says."""
    only: dict[str, list[str]] = {}
    for entry in options.only:
        column, equals, value = entry.partition("=")
        if not equals:
            parser.error(f"--only {entry}: expected COLUMN=VALUE, for example preload_step=3")
        only.setdefault(column, []).append(value)
    return only or None


def columns_of(parser: argparse.ArgumentParser, options: argparse.Namespace) -> dict[str, str]:
    """What --column says; the order of CASE and DATA is checked on the way."""
    if (
        options.case
        and options.case.suffix.lower() != ".toml"
        and options.data.suffix.lower() == ".toml"
    ):
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


# --- answers ------------------------------------------------------------------------------


def show(text: str) -> None:
    """Print a report: as wide as the terminal, with colours where it has them."""
    if sys.stdout.isatty():
        text = within(text)
    print(painted(text) if _coloured(sys.stdout) else text)


def tell(problem: str) -> None:
    """Print what is wrong."""
    text = f"cbpt: {problem}"
    print(painted(text) if _coloured(sys.stderr) else text, file=sys.stderr)


def _coloured(stream: TextIO) -> bool:
    """Whether a stream is that of a terminal with colours, and not one put in its place."""
    try:
        number = stream.fileno()
    except (AttributeError, OSError, ValueError):
        return False
    return number in (1, 2) and terminal_colour(number == 2)


class Answer(Protocol):
    """What a verb of the lab found."""

    def to_json(self) -> str:
        """The document."""


def show_answer(answer: Answer, json: str | None, report: Callable[[], str]) -> None:
    """Print the text, or the JSON document in its place; or write that beside it."""
    if json == "-":
        print(answer.to_json())
    else:
        if json:
            write_whole(json, answer.to_json() + "\n")
        show(report())
    sys.stdout.flush()


def show_results(found: Diagnosis | Fitted, options: argparse.Namespace) -> None:
    """The table of results, printed or written."""
    load = options.torque_Nm, options.preload_N, options.input_angle_deg
    if options.results is None and load == (None, None, None):
        return
    results = found.results(*load)
    told = results.told_in(options.angle_unit)
    if options.results in (None, "-"):
        show(f"\n{told.report()}")
        return
    made = {".csv": told.to_csv, ".md": told.to_markdown, ".json": results.to_json}
    path = Path(options.results)
    write_whole(path, made[path.suffix.lower()]())


_TELL_EACH_S = 30.0
"""Where no terminal shows how far the work is, a line each half a minute says that it goes on."""


class Counter:
    """A line on the terminal for what takes longer than a second, gone when the work is done; into
    a file or a pipe, lines of their own."""

    def __init__(self) -> None:
        self.start = self.told = time.monotonic()
        self.shown = False

    def __enter__(self) -> Counter:
        return self

    def show(self, done: int, total: int) -> None:
        self._line(f"{done}/{total} readings solved")

    def share(self, what: str, share: float) -> None:
        """As a diagnosis tells it."""
        self._line(f"{share:.0%} done, next: {what}")

    def _line(self, text: str) -> None:
        now = time.monotonic()
        if sys.stderr is None:
            return
        if not sys.stderr.isatty():
            if now - self.told > _TELL_EACH_S:
                self.told = now
                print(f"after {now - self.start:.0f} s: {text}", file=sys.stderr, flush=True)
        elif now - self.start > 1:
            self.shown = True
            print(f"\r\x1b[K{text} ", end="", file=sys.stderr, flush=True)

    def __exit__(self, *error: object) -> None:
        if self.shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
