"""The `cbpt` command of the Python package.

Verbs of the mechanics (solve, preload, sweep, check, schema) are handed to the Rust command line as
they are; verbs of the lab are here:

    compare     model against a table of readings
    diagnose    which effect is missing          (in `verbs`)
    fit         add effects to a case            (in `verbs`)
"""

from __future__ import annotations

import argparse
import csv
import io
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from cbpt import verbs
from cbpt._core import run_command_line
from cbpt.errors import CbptError

__all__ = ["main"]

# As in the Rust command line, whose help lists them.
SUCCESS, CANNOT_WRITE, BAD_INPUT, NO_SOLUTION, INTERRUPTED = 0, 1, 2, 3, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code."""
    argv = list(sys.argv[1:] if arguments is None else arguments)
    if argv[:1] == ["help"] and argv[1:2] and argv[1] in _LAB:
        argv = [argv[1], "--help"]
    if argv and argv[0] in _LAB:
        return _guarded(_LAB[argv[0]], argv[1:])
    if sys.stdout is not None:
        sys.stdout.flush()
    if threading.current_thread() is not threading.main_thread():
        return run_command_line(["cbpt", *argv])
    # Rust does not see Python's signals; Ctrl-C then simply ends the process.
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        return run_command_line(["cbpt", *argv])
    finally:
        signal.signal(signal.SIGINT, before)


def _guarded(verb: Callable[[list[str]], int], argv: list[str]) -> int:
    try:
        return verb(argv)
    except CbptError as error:
        print(f"cbpt: {error}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:
        # The reader (`| head`) has seen enough; what is left in the buffer must not complain.
        sys.stdout = io.StringIO()
        return SUCCESS
    except OSError as error:
        print(f"cbpt: cannot write {error.filename}: {error.strerror}", file=sys.stderr)
        return CANNOT_WRITE
    except SystemExit as stop:  # of argparse: help, or a mistake that it has told
        return stop.code if isinstance(stop.code, int) else BAD_INPUT
    except KeyboardInterrupt:
        print("cbpt: interrupted", file=sys.stderr)
        return INTERRUPTED


def _compare(argv: list[str]) -> int:
    from cbpt.lab.compare import compare
    from cbpt.results import ANGLE_UNITS

    parser = argparse.ArgumentParser(
        prog="cbpt compare",
        description="Solve the model at every reading; say how far off it is, and where.",
        epilog="The table's columns: run, time_s, torque_Nm, preload_N, input_angle_deg, "
        "temperature_degC, elastic_angle_arcsec, u_elastic_angle_arcsec; torque, preload and "
        "angle are needed. Other names and units are read where they are clear.",
    )
    parser.add_argument("case", metavar="CASE", type=Path, help="case file (TOML)")
    parser.add_argument("data", metavar="DATA", type=Path, help="table of readings (CSV)")
    parser.add_argument(
        "--with",
        metavar="EFFECT",
        nargs="+",
        action="extend",
        default=[],
        dest="effects",
        help="effects of the library to fit to the readings; the report tells before and after",
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
    parser.add_argument(
        "--column",
        metavar="HEADER=NAME",
        action="append",
        default=[],
        help="what a header means, for example Moment=torque_Nm; repeatable",
    )
    options = parser.parse_args(argv)
    columns = {}
    for entry in options.column:
        header, equals, name = entry.rpartition("=")
        if not equals:
            parser.error(f"--column {entry}: expected HEADER=NAME, for example Moment=torque_Nm")
        columns[header] = name
    if options.out and options.out.suffix.lower() not in (".csv", ".json"):
        parser.error(f"--out {options.out}: the name must end in .csv or .json")
    if options.case.suffix.lower() != ".toml" and options.data.suffix.lower() == ".toml":
        parser.error(f"CASE comes first: cbpt compare {options.data} {options.case}")
    if options.plot:
        from cbpt.page.comparison_figure import check_picture_name

        check_picture_name(options.plot)
    with _Counter() as counter:
        comparison = compare(
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


_LAB: dict[str, Callable[[list[str]], int]] = {
    "compare": _compare,
    "diagnose": verbs.diagnose,
    "fit": verbs.fit,
}

if __name__ == "__main__":
    sys.exit(main())
