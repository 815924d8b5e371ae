"""Sweeps over any parameter of drive, load or effects: here on all cores, or on any executor.

A plan (`SweepPlan`) is data and each of its rows a function of the plan and the row's number, so a
chunk of rows is solved wherever there is room and written in its turn; values do not depend on who
solved it.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import Executor, Future
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cbpt._core import Case, Drive, SweepPlan, SweepTally, is_sweep_plan
from cbpt.errors import CaseError, PlanError
from cbpt.sweeps.files import Output, open_output
from cbpt.sweeps.result import Rows, Sweep

__all__ = ["Sweep", "SweepPlan", "Work", "open_output", "sweep", "to_output"]

Report = Callable[[int, int], object]
Span = tuple[int, int]
Chunks = Generator[tuple[Span, Any], None, None]

MOST_ROWS_IN_MEMORY = 50_000_000
"""More rows than these, some 3 GB, go to a file."""


@dataclass(frozen=True)
class Work:
    """How a sweep is carried out; all as in `sweep`."""

    executor: Executor | None = None
    in_flight: int | None = None
    chunk_rows: int | None = None
    progress: Report | bool | None = None


def sweep(
    drive: Drive | Case | SweepPlan | str | os.PathLike[str],
    axes: Mapping[str, Any] | None = None,
    *,
    design: str = "grid",
    rows: int | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    in_flight: int | None = None,
    chunk_rows: int | None = None,
    progress: Report | bool | None = None,
    out: str | os.PathLike[str] | None = None,
    fresh: bool = False,
    columns: Sequence[str] = (),
) -> Sweep:
    """Solve a drive, or a case with its effects, over any of its parameters.

    A row without solution is NaN, and its status says why. The `finding` of a row says why its
    drive cannot be built, whether it has a solution or not; where no axis is of the drive, there is
    one warning in its place.

    Parameters
    ----------
    drive : Drive, Case, SweepPlan, str or PathLike
        What is solved. A path is that of a case file or of a plan; a plan has its own axes.
    axes : mapping of str to values, optional
        Keys of the case with their sections (`load.torque_Nm`, `deceleration.ball_radius_mm`,
        `effect.eccentric_bearing.reference_deflection_um`) and their values: in a grid all values,
        or one for all rows; in a drawn design a tuple ``(low, high)`` or ``(low, high, "log")``, or
        a list to draw from; in a table one value for each row.
    design : {"grid", "random", "latin_hypercube", "table"}
        How rows follow from the axes.
    rows : int, optional
        The number of rows of a drawn design.
    seed : int
        Seed of a drawn design. The same seed gives the same rows.
    executor : concurrent.futures.Executor, optional
        What solves the chunks, each on one thread. Without it, all cores of this machine.
    in_flight : int, optional
        Chunks under way at a time: two for each worker of the executor, or 32 where their number is
        not known.
    chunk_rows : int, optional
        The smallest number of rows of a chunk.
    progress : callable or bool, optional
        Called as ``progress(rows_done, rows)``; True writes a line to standard error. What it
        raises stops the sweep.
    out : str or PathLike, optional
        A `.csv` or `.parquet` file to write rows to. A sweep that was stopped continues where it
        was.
    fresh : bool
        Whether to start again and replace the sweep that `out` holds.
    columns : sequence of str, optional
        Further columns, of the drive without effects, at the input angle of each row:
        `friction_torque_Nm`, `efficiency`, `wear_Nm_per_turn`, `static_safety`,
        `natural_frequency_Hz`. They take several times as long as the angle. A plan names its own.

    Returns
    -------
    Sweep
        The rows; with `out`, they stay in the file.

    Raises
    ------
    PlanError
        The axes or the output are not possible, or `out` holds another sweep.
    CaseError
        The case cannot be read.
    """
    plan, scalars = _plan(drive, axes, design, rows, seed, columns)
    work = Work(executor, in_flight, chunk_rows, progress)
    for remark in plan.remarks:
        warnings.warn(remark, stacklevel=2)
    if out is not None:
        path = Path(out)
        with closing(open_output(plan, path, fresh)) as output:
            if output.unchecked:
                warnings.warn(f"{path}: {output.unchecked}", stacklevel=2)
            to_output(plan, output, work)
        return Sweep(plan, path, scalars, lambda: Rows.read(plan, path))
    if plan.rows > MOST_ROWS_IN_MEMORY:
        most = f"at most {MOST_ROWS_IN_MEMORY} are kept in memory: name a file with out="
        raise PlanError(f"the sweep has {plan.rows} rows; {most}")
    chunks = _solved(plan, 0, "rows", work)
    with closing(chunks):
        whole = Rows.joined(Rows.of(plan, chunk) for _, chunk in chunks)
    return Sweep(plan, None, scalars, lambda: whole)


def to_output(
    plan: SweepPlan,
    output: Output,
    work: Work,
    tally: SweepTally | None = None,
) -> None:
    """Solve what is left of a plan, write it, and count how its rows ended.

    Lines of CSV have no statuses to be counted.
    """
    chunks = _solved(plan, output.done, output.form, work)
    with closing(chunks):
        for (start, stop), chunk in chunks:
            if output.form == "csv":
                output.append(chunk, stop - start)
                continue
            rows = Rows.of(plan, chunk)
            output.append(rows, stop - start)
            if tally is not None:
                tally.add(start, rows.status, rows.finding)
    output.finish()


def _solved(plan: SweepPlan, done: int, form: str, work: Work) -> Chunks:
    """The chunks that are not done yet, in their order."""
    report: Report | None = _Line(done) if work.progress is True else work.progress or None
    spans = plan.chunks(done, work.chunk_rows)
    if work.executor is None:
        chunks = _here(plan, spans, form, report)
    else:
        most = work.in_flight or _most_in_flight(work.executor)
        chunks = _there(plan, spans, form, work.executor, most)
    with closing(chunks):
        for span, chunk in chunks:
            yield span, chunk
            if report is not None:
                report(span[1], plan.rows)


def _plan(
    drive: Drive | Case | SweepPlan | str | os.PathLike[str],
    axes: Mapping[str, Any] | None,
    design: str,
    rows: int | None,
    seed: int,
    columns: Sequence[str],
) -> tuple[SweepPlan, frozenset[str]]:
    """The plan, and which of its axes were given as one value."""
    if isinstance(drive, str | os.PathLike):
        path = Path(drive)
        # A file without axes that is no plan is told what a plan lacks, unless it is a case.
        if is_sweep_plan(path) or (axes is None and not _is_case(path)):
            drive = SweepPlan.from_file(path)
        else:
            drive = Case.from_file(path)
    if isinstance(drive, SweepPlan):
        if axes is not None or rows is not None or columns:
            raise PlanError(
                "the plan already has axes and rows, and names its columns: leave out axes, rows "
                "and columns"
            )
        return drive, frozenset()
    if not axes:
        raise PlanError('no axes: give what varies, for example axes={"load.torque_Nm": [1, 2, 5]}')
    case = Case.from_toml(drive.to_toml()) if isinstance(drive, Drive) else drive
    drawn = design in ("random", "latin_hypercube")
    given = [(name, _values(name, values, drawn)) for name, values in axes.items()]
    if rows is not None and rows < 1:
        raise PlanError(f"rows = {rows}: expected 1 or more")
    if not 0 <= seed < 2**64:
        raise PlanError(f"seed = {seed}: expected a whole number from 0 to 2**64 - 1")
    scalars = frozenset(name for name, values in axes.items() if np.ndim(values) == 0)
    return SweepPlan(case, given, design, rows, seed, list(columns)), scalars


def _is_case(path: Path) -> bool:
    try:
        Case.from_file(path)
    except CaseError:
        return False
    return True


def _values(name: str, values: Any, drawn: bool) -> Any:
    """The values of an axis as the core takes them."""
    if drawn and isinstance(values, tuple):
        try:
            low, high, *scale = values
            if scale in ([], ["log"], ["linear"]):
                return float(low), float(high), scale == ["log"]
        except (TypeError, ValueError, OverflowError):  # of what is no number
            pass
        raise PlanError(f'{name}: a range is (low, high) or (low, high, "log")')
    try:
        array = np.atleast_1d(values)
    except ValueError:  # rows of different lengths
        raise PlanError(f"{name}: found lists of several lengths, expected one list") from None
    if array.ndim > 1:
        raise PlanError(f"{name}: found {array.ndim} dimensions, expected one list of values")
    if array.dtype.kind in "UT" or (
        array.dtype.kind == "O" and all(isinstance(value, str) for value in array)
    ):
        return [str(value) for value in array]
    if array.dtype.kind not in "iuf" or np.ma.isMaskedArray(values):
        raise PlanError(f"{name}: found {array.dtype} values, expected numbers or words")
    return np.ascontiguousarray(array, dtype=np.float64)


def _here(plan: SweepPlan, spans: list[Span], form: str, report: Report | None) -> Chunks:
    for start, stop in spans:
        told = None if report is None else _counted(report, start, plan.rows)
        solve = plan.csv if form == "csv" else plan.solve
        yield (start, stop), solve(start, stop, None, told)


def _counted(report: Report, start: int, total: int) -> Callable[[int], object]:
    return lambda done: report(start + done, total)


def _there(plan: SweepPlan, spans: list[Span], form: str, executor: Executor, most: int) -> Chunks:
    """Chunks in their order, at most so many on their way."""
    waiting = deque(spans)
    under_way: deque[tuple[Span, Future[Any]]] = deque()
    try:
        while waiting or under_way:
            while waiting and len(under_way) < most:
                span = waiting.popleft()
                part = plan.part(*span) if plan.design == "table" else plan
                under_way.append((span, executor.submit(solve_chunk, part, *span, form)))
            span, future = under_way.popleft()
            yield span, future.result()
    finally:
        for _, future in under_way:
            future.cancel()


def solve_chunk(plan: SweepPlan, start: int, stop: int, form: str) -> Any:
    """The work of one worker, on one thread of its own."""
    return plan.csv(start, stop, 1) if form == "csv" else plan.solve(start, stop, 1)


def _most_in_flight(executor: Executor) -> int:
    for name in ("_max_workers", "num_workers"):  # of Python's own executors, of mpi4py's
        workers = getattr(executor, name, None)
        if isinstance(workers, int) and workers > 0:
            return 2 * workers
    return 32


class _Line:
    """Rows, rate and time left on standard error, a few times a second."""

    def __init__(self, done: int) -> None:
        self.first, self.began, self.shown = done, time.monotonic(), 0.0

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        if sys.stderr is None or (now - self.shown < 0.2 and done < total):
            return
        self.shown = now
        rate = (done - self.first) / max(now - self.began, 1e-9)
        left = (total - done) / rate if rate > 0 else float("inf")
        text = f"\r{done}/{total} rows, {_rate(rate)} a second, {_clock(left)} left "
        print(text, end="\n" if done >= total else "", file=sys.stderr, flush=True)


def _rate(per_second: float) -> str:
    """Three digits say all that a rate means."""
    rounded = float(f"{per_second:.3g}")
    return f"{rounded:,.0f}" if rounded >= 100 else f"{rounded:g}"


def _clock(seconds: float) -> str:
    if seconds > 1e8:
        return "?"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
