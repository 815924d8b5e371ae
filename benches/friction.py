"""Speed of friction: one load at one angle, a period, a map of loads.

    python benches/friction.py

Wall time; the map uses all cores. Behind each figure stands its share of the target: one load at
one angle at most 1 ms, a map of 50 x 50 loads over a period, with progress, at most 20 s on two
cores.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import cbpt

CASES = Path(__file__).parents[1] / "examples"


def seconds(work: Callable[[], object], rounds: int) -> float:
    """The least of several rounds."""
    taken = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


MOST_ANGLE_S, MOST_MAP_S = 1e-3, 20.0


def mapped(drive: cbpt.Drive) -> float:
    """A map of 50 x 50 loads over a period with its progress told."""
    torque, preload = np.linspace(0, 15, 50)[:, None], np.linspace(400, 1500, 50)
    told: list[int] = []
    taken = seconds(
        lambda: cbpt.friction_map(
            drive, torque, preload, progress=lambda done, _: told.append(done)
        ),
        1,
    )
    assert told, "a map tells how far it is"
    return taken


def main() -> None:
    rings = (CASES / "base_case.toml").read_text()
    slide = rings.replace('"ring_groove"', '"cross_slide"').replace(
        "ball_count = 14", "ball_count = 16"
    )
    for name, text in (("ring grooves", rings), ("cross-slide", slide)):
        drive = cbpt.Drive.from_toml(text)
        angle = seconds(partial(drive.friction, 5, 600, 30), 200)
        period = seconds(partial(drive.friction, 5, 600), 10)
        print(
            f"{name}: one load at an angle {1e3 * angle:.3f} ms ({angle / MOST_ANGLE_S:.0%} of the "
            f"target), a period {1e3 * period:.1f} ms"
        )
        whole = mapped(drive)
        print(
            f"{name}: a map of 50 x 50 loads over a period {whole:.1f} s "
            f"({whole / MOST_MAP_S:.0%} of the target)"
        )
    whole = seconds(lambda: cbpt.friction(CASES / "base_case.toml"), 3)
    print(f"cbpt.friction, window and largest torque with it: {whole:.2f} s")


if __name__ == "__main__":
    main()
