"""How long and how much memory a large table takes: `compare`, `diagnose`, and reading the file.

    python benches/large_tables.py [--rows 1000000] [--runs 30000] [--json FILE]

The table is the drive of the examples, its torque taken up, down and back in runs of one length, at
three preloads and twelve input angles, with noise; in the table "alike" all runs have one preload
and one angle. Each verb runs in a process of its own, so that the peak of its memory is told as
well (that of the whole process, the table in it). `zero` is that of the case: with "per_run" every
run has an offset of its own. Seconds are those of the processor, which other load changes little.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import cbpt

CASE = Path(__file__).parents[1] / "examples" / "campaign.toml"
WORK = [
    ("read", "common", False),
    *((verb, zero, False) for verb in ("compare", "diagnose") for zero in ("common", "per_run")),
    ("compare", "common", True),
    ("diagnose", "common", True),
]
"""Verb, zero, whether all runs are alike."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--runs", type=int, default=30_000)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--one", nargs=3, metavar=("VERB", "ZERO", "TABLE"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measured(*options.one)))
        return
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for alike in (False, True):
            save(table(folder, alike), campaign(options.rows, options.runs, alike))
        for verb, zero, alike in WORK:
            command = [sys.executable, __file__, "--one", verb, zero, table(folder, alike)]
            out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            found.append({"alike": alike} | json.loads(out))
            print(line(found[-1]), flush=True)
    if options.json:
        options.json.write_text(json.dumps(found, indent=2))


def table(folder: str, alike: bool) -> str:
    """The file of a table."""
    return str(Path(folder, f"{'alike' if alike else 'plan'}.npy"))


def save(path: str, columns: dict[str, NDArray[Any]]) -> None:
    names = np.dtype([(name, values.dtype) for name, values in columns.items()])
    rows = np.empty(len(columns["run"]), dtype=names)
    for name, values in columns.items():
        rows[name] = values
    np.save(path, rows)


def line(found: dict[str, Any]) -> str:
    kind = "alike" if found["alike"] else ""
    return "{verb:9} zero {zero:8} {kind:6} {seconds:6.1f} s {peak_MB:6.0f} MB".format(
        kind=kind, **found
    )


def campaign(rows: int, runs: int, alike: bool, seed: int = 0) -> dict[str, NDArray[Any]]:
    """Columns of a table: up, down and back to zero torque in every run, with noise."""
    rng = np.random.default_rng(seed)
    run = np.arange(rows) * runs // rows
    first = np.searchsorted(run, np.arange(runs))
    place = (np.arange(rows) - first[run]) / max(rows // runs, 1)
    torque = np.round(np.interp(place, [0, 0.25, 0.75, 1], [0, 6, -6, 0]), 2)
    preload = np.array([320.0, 420.0, 520.0])[run % 3 * (not alike)]
    angle = np.arange(12)[run // 3 % 12] * (0.0 if alike else 30.0)
    model = cbpt.solve_many(cbpt.Case.from_file(CASE).drive, torque, preload, angle)
    noise = 0.3 * rng.standard_normal(rows) + 0.1 * rng.standard_normal(runs)[run]
    return {
        "run": run,
        "torque_Nm": torque,
        "preload_N": preload,
        "input_angle_deg": angle,
        "elastic_angle_arcsec": np.round(1.03 * model.elastic_angle_arcsec + noise, 3),
        "u_elastic_angle_arcsec": np.full(rows, 0.3),
    }


def measured(verb: str, zero: str, table: str) -> dict[str, Any]:
    """One verb in this process."""
    case = cbpt.Case.from_toml(CASE.read_text() + f'\n[measurement]\nzero = "{zero}"\n')
    columns = np.load(table, mmap_mode="r")
    start = time.process_time()
    readings = cbpt.read_readings({name: columns[name] for name in columns.dtype.names})
    if verb != "read":
        start = time.process_time()
        str(cbpt.compare(case, readings) if verb == "compare" else cbpt.diagnose(case, readings))
    seconds = time.process_time() - start
    peak_MB = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {
        "verb": verb,
        "zero": zero,
        "rows": len(readings),
        "seconds": seconds,
        "peak_MB": peak_MB,
    }


if __name__ == "__main__":
    main()
