"""Instructions a case of the hot loops, counted by callgrind, against the numbers kept here.

    python benches/instructions.py

A count does not depend on how busy the machine is, so slow decay shows. callgrind knows no AVX-512
and says so to the program, which therefore runs its AVX2 path: the numbers hold on every x86-64
machine with AVX2. Two sizes are counted and their difference taken, so that start-up drops out.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).parents[1]
KEPT = {"loads": 503, "hard": 694, "geometry": 36_760, "hertz": 143}
"""Instructions a case: easy loads on one pair, loads at 40 to 99.9 % of hold, a new geometry, one
Hertz contact (with what keeps it)."""
TOLERANCE = 0.05
# Beyond 16,384 loads the prepared curve no longer grows with them.
SIZES = {
    "loads": (20_000, 40_000),
    "hard": (20_000, 40_000),
    "geometry": (200, 400),
    "hertz": (8_000, 16_000),
}


def count(binary: Path, workload: str, cases: int) -> int:
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    done = subprocess.run(
        [*command, str(binary), workload, str(cases)],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"RAYON_NUM_THREADS": "1"},
    )
    assert f"{cases} of {cases} solved" in done.stdout, done.stdout
    found = re.search(r"Collected : (\d+)", done.stderr)
    assert found, done.stderr
    return int(found[1])


def main() -> int:
    if shutil.which("valgrind") is None:
        print("valgrind is not installed: apt-get install valgrind")
        return 1
    manifest = TOP / "benches" / "speed" / "Cargo.toml"
    subprocess.run(
        ["cargo", "build", "--release", "--quiet", "--manifest-path", str(manifest)], check=True
    )
    target = Path(os.environ.get("CARGO_TARGET_DIR", manifest.parent / "target"))
    failed = False
    for workload, (few, many) in SIZES.items():
        counts = [count(target / "release" / "instructions", workload, n) for n in (few, many)]
        found = (counts[1] - counts[0]) / (many - few)
        ratio = found / KEPT[workload]
        failed |= abs(ratio - 1) > TOLERANCE
        print(f"{ratio:6.3f} of what is kept  {workload:<10}{found:10.1f} instructions a case")
    if failed:
        print(
            f"beyond {TOLERANCE:.0%}: find out why, or keep the new number in {Path(__file__).name}"
        )
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
