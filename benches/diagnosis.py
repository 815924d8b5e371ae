"""How long a prediction and a diagnosis take, on the bundled campaigns. `make bench` runs it.

A prediction is that of every reading after one number has changed, as a fit asks for it; a
diagnosis is the whole library, pairs, patterns and simulated chances, in process. The best of
several rounds is shown: these machines are noisy, and nothing but noise makes a round slower.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import cbpt
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled

DATA = Path(__file__).parents[1] / "tests" / "data" / "hidden_effect"
ROUNDS = 15
LONG = 20_000
"""Readings of the long tables."""


def best_ms(work: Callable[[int], object], rounds: int = ROUNDS) -> float:
    """Shortest time of several rounds, ms."""
    times = []
    for number in range(rounds):
        start = time.perf_counter()
        work(number)
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def prediction_ms(name: str, effects: list[str], sizes: dict[str, float], wanted: int) -> float:
    """Of all readings of a campaign, with the slopes by `wanted` numbers."""
    case = cbpt.Case.from_file(DATA / f"{name}.toml")
    campaign = Campaign.of(case, cbpt.read_readings(DATA / f"{name}.csv"))
    model = Assembled(campaign, ["contact_stiffness", "torque_scale", *effects])
    values = model.neutral.copy()
    for key, value in sizes.items():
        values[model.index(2, key)] = value

    def work(number: int) -> None:
        values[0] = 1 + 0.02 * np.sin(float(number))
        model.at(values, range(wanted))

    return best_ms(work)


def diagnosis_ms(name: str, table: cbpt.Readings, rounds: int) -> float:
    """Of a table by the case of a campaign."""
    return best_ms(lambda _: cbpt.diagnose(DATA / f"{name}.toml", table), rounds)


def tiled(name: str, count: int) -> dict[str, np.ndarray]:
    """Columns of a campaign measured again and again, with as many readings or a few more: later,
    in runs of their own, with other noise of the stated size."""
    with (DATA / f"{name}.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    once = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
    times = -(-count // len(rows))
    turn = np.repeat(np.arange(times), len(rows))
    table = {key: np.tile(column, times) for key, column in once.items()}
    table["run"] += turn * (once["run"].max() + 1)
    table["time_s"] += turn * (np.ptp(once["time_s"]) + 60)
    noise = np.random.default_rng(1).standard_normal(len(turn))
    table["elastic_angle_arcsec"] += table["u_elastic_angle_arcsec"] * noise
    return table


NAMES = [f"dev{i:02d}" for i in range(1, 14)]
LONG_NAMES = ("dev03", "dev05", "dev12")
"""Campaigns that are tiled."""

_ANSWERS = """
import sys, time
import cbpt
for line in sys.stdin:
    case, table = line.split()
    processor, clock = time.process_time(), time.perf_counter()
    cbpt.diagnose(case, table)
    print(time.process_time() - processor, time.perf_counter() - clock, flush=True)
"""


class Other:
    """A process that diagnoses with the build of one checkout, and says how long that took."""

    def __init__(self, checkout: Path) -> None:
        python = str(checkout / ".venv" / "bin" / "python")
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(
            [python, "-c", _ANSWERS], stdin=pipe, stdout=pipe, text=True, cwd=checkout
        )

    def seconds(self, name: str, table: Path) -> list[float]:
        """Processor time and time by the clock of one diagnosis by the case of a campaign."""
        told, said = self._process.stdin, self._process.stdout
        assert told is not None
        assert said is not None
        print(DATA / f"{name}.toml", table, file=told, flush=True)
        return [float(seconds) for seconds in said.readline().split()]


def beside(checkout: Path, rounds: int = 4) -> None:
    """Prints times of this checkout and another, the smallest of rounds in turns."""
    here, there = Other(Path(__file__).parents[1]), Other(checkout)

    def row(label: str, name: str, table: Path, turns: int) -> np.ndarray:
        took = [(here.seconds(name, table), there.seconds(name, table)) for _ in range(turns)]
        return show(label, np.min(took, axis=0).T)

    def show(label: str, times: np.ndarray) -> np.ndarray:
        told = (f"{one:8.2f} {other:8.2f} {one / other:14.2f}" for one, other in times)
        print(f"{label:24s} {' '.join(told)}", flush=True)
        return times

    head = f"{'here':>8s} {'there':>8s} {'here / there':>14s}"
    print(f"{'processor; clock, s':24s} {head} {head}")
    found = [row(name, name, DATA / f"{name}.csv", rounds) for name in NAMES]
    show("median of these", np.median(found, axis=0))
    with tempfile.TemporaryDirectory() as folder:
        for name in LONG_NAMES:
            columns, table = tiled(name, LONG), Path(folder) / f"{name}.csv"
            with table.open("w", encoding="utf-8", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(columns)
                writer.writerows(np.column_stack(list(columns.values())).tolist())
            row(f"{name}, {len(columns['run'])} readings", name, table, 2)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--beside", type=Path, metavar="CHECKOUT")
    other = parser.parse_args().beside
    if other is not None:
        beside(other.resolve())
        return
    friction = {"friction_radius_m": 6e-4, "engagement_angle_rad": 2.5e-5}
    rows = [
        ("prediction, 396 readings", prediction_ms("dev01", [], {}, 0)),
        ("  with 2 slopes", prediction_ms("dev01", [], {}, 2)),
        (
            "prediction with friction, 396 readings",
            prediction_ms("dev04", ["friction_hysteresis"], friction, 0),
        ),
        ("  with 4 slopes", prediction_ms("dev04", ["friction_hysteresis"], friction, 4)),
    ]
    diagnoses = []
    for name in NAMES:
        table = cbpt.read_readings(DATA / f"{name}.csv")
        diagnoses.append(diagnosis_ms(name, table, 3))
        rows.append((f"diagnosis of {name}, {len(table)} readings", diagnoses[-1]))
    rows.append(("median of these", float(np.median(diagnoses))))
    for name in LONG_NAMES:
        table = cbpt.read_readings(tiled(name, LONG))
        rows.append((f"diagnosis of {name}, {len(table)} readings", diagnosis_ms(name, table, 2)))
    for label, took in rows:
        print(f"{label:45s} {took:8.2f} ms")


if __name__ == "__main__":
    main()
