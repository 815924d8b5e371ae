"""How tightly, and how fast, random drives are enclosed: 100,000 of them, as a table.

    python benches/enclosures.py [--page docs/explanation/proof.md]

The drives and loads are those of `crates/cbpt-core/tests/proof.rs`: 3 to 200 balls, 1e-3 to 1e6 N,
any input angle, up to 99.9 % of the torque that the preload holds. The first that is not enclosed
ends the run. `--page` writes the table between the marks of a page.
"""

from __future__ import annotations

import argparse
import os
import subprocess
from pathlib import Path

TOP = Path(__file__).parents[1]
MARKS = "<!-- benches/enclosures.py -->\n", "<!-- end of enclosures -->\n"
HEAD = (
    "| torque, of what is held | drives | enclosed | relative width, median | largest "
    "| proof, median (µs) | solve, median (µs) |\n|---|---|---|---|---|---|---|"
)
COMMAND = "cargo test --release --quiet -p cbpt-core --test mechanics -- --ignored --nocapture"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--page", type=Path)
    parser.add_argument("--drives", type=int, default=100_000)
    options = parser.parse_args()
    env = {**os.environ, "DRIVES": str(options.drives)}
    ran = subprocess.run(
        COMMAND.split(), cwd=TOP, env=env, stdout=subprocess.PIPE, text=True, check=False
    )
    if ran.returncode:
        raise SystemExit(ran.stdout)
    rows = [line for line in ran.stdout.splitlines() if line.startswith("| ")]
    text = "\n".join([HEAD, *rows]) + "\n"
    print(text)
    if options.page:
        page = options.page.read_text()
        before, rest = page.split(MARKS[0])
        after = rest.split(MARKS[1])[1]
        options.page.write_text(before + MARKS[0] + "\n" + text + "\n" + MARKS[1] + after)


if __name__ == "__main__":
    main()
