"""Sweeps: memory, time of a case, and what an executor adds to it. `python benches/sweep.py`.

- Memory: a sweep of 1e5 and one of 1e7 cases to CSV, each in a process of its own, whose peak
  resident memory is read when it ends. Loads on one drive, so that solving is as quick as it gets
  and all else weighs the most.
- Executors: the same cases here on one thread, on a process pool of one worker and on a Dask
  cluster of one worker; the difference is their overhead. Beside it a drive of its own for each
  case, which costs more to solve, and a size of an effect of its own, which does too.

Shorter with `--cases 1e6`; the page docs/how-to/sweeps.md gives the figures of the full run.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from cbpt import Case, SweepPlan, example_case, sweep

LOADS = [("load.torque_Nm", (0.0, 8.0, False)), ("load.preload_N", (400.0, 1200.0, False))]
DRIVES = [*LOADS, ("deceleration.contact_angle_deg", (40.0, 50.0, False))]
EFFECT = '\n[[effect]]\nid = "eccentric_bearing"\nreference_deflection_um = 2\n'
SIZE = "effect.eccentric_bearing.reference_deflection_um"
EFFECTS = [*LOADS, (SIZE, (0.0, 4.0, False))]
CHUNKS = (8192, 65536)


def plan(axes: list[Any], cases: int) -> SweepPlan:
    """Drawn cases on the example drive."""
    text = example_case() + (EFFECT if axes is EFFECTS else "")
    return SweepPlan(Case.from_toml(text), axes, "random", cases)


def whole(cases: int, out: Path, axes: list[Any]) -> dict[str, float]:
    """A sweep in a process of its own: its time and its peak memory."""
    program = (
        "import sys; sys.path.insert(0, sys.argv[1]); import sweep; "
        "sweep.in_process(int(sys.argv[2]), sys.argv[3], sys.argv[4])"
    )
    kind = "drives" if axes is DRIVES else "loads"
    here = str(Path(__file__).parent)
    command = [sys.executable, "-c", program, here, str(cases), str(out), kind]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    out.unlink()
    found: dict[str, float] = json.loads(done.stdout)
    return found


def in_process(cases: int, out: str, kind: str) -> None:
    """The work of `whole`."""
    begun = time.perf_counter()
    sweep(plan(DRIVES if kind == "drives" else LOADS, cases), out=out, fresh=True)
    took = time.perf_counter() - begun
    used = resource.getrusage(resource.RUSAGE_SELF)
    peak = used.ru_maxrss / 1024  # KiB on Linux
    print(json.dumps({"s": took, "cpu_s": used.ru_utime + used.ru_stime, "peak_MiB": peak}))


@contextmanager
def here() -> Iterator[Executor]:
    with ThreadPoolExecutor(1) as pool:
        yield pool


@contextmanager
def process() -> Iterator[Executor]:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        yield pool


@contextmanager
def dask() -> Iterator[Executor]:
    from distributed import Client, LocalCluster

    quiet = {"dashboard_address": None, "silence_logs": 50}
    made: Any = LocalCluster
    with (
        made(n_workers=1, threads_per_worker=1, **quiet) as cluster,
        Client(cluster) as client,  # type: ignore[no-untyped-call]
    ):
        yield client.get_executor()


def us_per_case(
    executor: Executor, axes: list[Any], cases: int, chunk: int, rounds: int
) -> tuple[float, float]:
    """To CSV through an executor of one worker that is warm by then: time, and processor time of
    the process that hands out and writes; the best of some rounds."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "t.csv"
        sweep(plan(axes, 8192), executor=executor, out=out, fresh=True)
        found = []
        for _ in range(rounds):
            begun, cpu = time.perf_counter(), time.process_time()
            sweep(plan(axes, cases), executor=executor, out=out, chunk_rows=chunk, fresh=True)
            found.append((time.perf_counter() - begun, time.process_time() - cpu))
    return 1e6 * min(took for took, _ in found) / cases, 1e6 * min(cpu for _, cpu in found) / cases


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=float, default=1e7, help="of the large sweep")
    parser.add_argument("--rounds", type=int, default=3, help="of which the best counts")
    options = parser.parse_args()
    large = int(options.cases)
    print(f"{os.cpu_count()} cores, load average {os.getloadavg()[0]:.1f}\n")
    print("To CSV in this process, all cores")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "t.csv"
        for axes, name, cases in [
            (LOADS, "loads", 100_000),
            (LOADS, "loads", large),
            (DRIVES, "a drive each", 100_000),
        ]:
            found = whole(cases, out, axes)
            each, cpu = (1e6 * found[key] / cases for key in ("s", "cpu_s"))
            print(
                f"  {cases:>10} {name:13} {found['s']:8.1f} s  {each:7.2f} us a case, "
                f"{cpu:7.2f} us of processor, peak {found['peak_MiB']:.0f} MiB"
            )
    print(
        "\nTo CSV on one worker, us a case by rows in a chunk: time, what the executor adds to it,"
    )
    print("and processor time of the process that hands out and writes; core hours of 1e9 cases")
    kinds: list[tuple[str, Callable[[], Any]]] = [
        ("one thread here", here),
        ("process pool", process),
        ("Dask LocalCluster", dask),
    ]
    for axes, label, cases in [
        (LOADS, "loads", 524_288),
        (DRIVES, "a drive each", 65_536),
        (EFFECTS, "effects each", 65_536),
    ]:
        base: dict[int, float] = {}
        for name, start in kinds:
            with start() as executor:
                for chunk in CHUNKS:
                    took, cpu = us_per_case(executor, axes, cases, chunk, options.rounds)
                    over = took - base.setdefault(chunk, took)
                    print(
                        f"  {name:18} {label:13} {chunk:>7} {took:8.2f} {over:+8.2f} {cpu:8.2f}"
                        f" {took / 3.6:8.2f} h"
                    )


if __name__ == "__main__":
    main()
