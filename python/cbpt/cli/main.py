"""The `cbpt` command of the Python package.

Verbs of the mechanics (solve, preload, friction, sweep, sensitivity, check, effects, schema) are
handed to the Rust command line as they are, but for a sweep to Parquet (`sweep`) and for friction
with a picture (`design`); those of the lab are in `lab` (compare, diagnose, change, fit) and, about
campaigns to come, in `campaigns` (simulate, isolability, next-run, plan); those about drives to be
built, and their parts as they were made, in `design` (tolerance, optimise, transmission); those of
the page in `page` (report, workbench, datasheet); those about loops and a table by itself in
`tables` (characterise, preflight). What they share is in `options`.
"""

from __future__ import annotations

import io
import os
import sys
import threading
from collections.abc import Callable, Sequence

try:
    from cbpt._core import run_command_line
    from cbpt.cli import campaigns as plan_verbs
    from cbpt.cli import design as design_verbs
    from cbpt.cli import lab as verbs
    from cbpt.cli import page as page_verbs
    from cbpt.cli import sweep as sweep_verb
    from cbpt.cli import tables as table_verbs
    from cbpt.cli.options import in_flags, tell
    from cbpt.errors import CaseError, CbptError, NoSolutionError, told
except KeyboardInterrupt:  # numpy takes a while to load
    print("cbpt: interrupted", file=sys.stderr)
    os._exit(130)

__all__ = ["main"]

# How often Ctrl-C is looked for.
POLL_S = 0.05

# As in the Rust command line, whose help lists them.
SUCCESS, CANNOT_WRITE, BAD_INPUT, NO_SOLUTION, INTERRUPTED = 0, 1, 2, 3, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code."""
    argv = list(sys.argv[1:] if arguments is None else arguments)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by who has started this
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
    if argv[:1] == ["help"] and argv[1:2] and argv[1] in (*_LAB, "friction"):
        argv = [argv[1], "--help"]
    if argv and argv[0] in _LAB:
        return _guarded(_LAB[argv[0]], argv[1:])
    if design_verbs.is_with_window(argv):
        return _guarded(design_verbs.friction, argv[1:])
    if sweep_verb.is_for_parquet(argv):
        return _guarded(sweep_verb.sweep, argv[1:])
    if sys.stdout is not None:
        sys.stdout.flush()
    if threading.current_thread() is not threading.main_thread():
        return run_command_line(["cbpt", *argv])
    return _beside(["cbpt", *argv])


def _beside(argv: list[str]) -> int:
    """Run a verb of Rust, which does not see Python's signals, on a thread of its own.

    Ctrl-C is met here and ends the process, as a kill would; what a sweep has on disk stays.
    """
    codes = [101]  # as Rust ends where it panics
    worker = threading.Thread(target=lambda: codes.append(run_command_line(argv)), daemon=True)
    try:
        worker.start()
        # A signal just before a wait begins, or one to another thread, does not end the wait.
        while worker.is_alive():
            worker.join(POLL_S)
    except KeyboardInterrupt:
        os._exit(_interrupted())
    return codes[-1]


def _interrupted() -> int:
    if sys.stderr is not None:
        bar = "\r\x1b[K" if sys.stderr.isatty() else ""  # of progress, which this line stands for
        print(f"{bar}cbpt: interrupted", file=sys.stderr, flush=True)
    return INTERRUPTED


def _guarded(verb: Callable[[list[str]], int], argv: list[str]) -> int:
    try:
        return verb(argv)
    except NoSolutionError as error:
        tell(str(error))
        return NO_SOLUTION
    except CbptError as error:
        tell(error.shown if isinstance(error, CaseError) else told(error, in_flags))
        return BAD_INPUT
    except BrokenPipeError:
        # The reader (`| head`) has seen enough; what is left in the buffer must not complain.
        sys.stdout = io.StringIO()
        return SUCCESS
    except OSError as error:
        # Only what is printed has no name.
        name, why = error.filename or "standard output", error.strerror or error
        tell(f"cannot write {name}: {why}")
        return CANNOT_WRITE
    except SystemExit as stop:  # of argparse: help, or a mistake that it has told
        return stop.code if isinstance(stop.code, int) else BAD_INPUT
    except KeyboardInterrupt:
        return _interrupted()


_LAB: dict[str, Callable[[list[str]], int]] = {
    "characterise": table_verbs.characterise,
    "preflight": table_verbs.preflight,
    "compare": verbs.compare,
    "diagnose": verbs.diagnose,
    "change": verbs.change,
    "fit": verbs.fit,
    "simulate": plan_verbs.simulate,
    "isolability": plan_verbs.isolability,
    "next-run": plan_verbs.next_run,
    "plan": plan_verbs.plan,
    "tolerance": design_verbs.tolerance,
    "optimise": design_verbs.optimise,
    "transmission": design_verbs.transmission,
    "report": page_verbs.report,
    "workbench": page_verbs.workbench,
    "datasheet": page_verbs.datasheet,
}

if __name__ == "__main__":
    sys.exit(main())
