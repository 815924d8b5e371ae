"""How tightly, and how fast, random drives are enclosed: 100,000 of them, as a table.

    python benches/enclosures.py [--page docs/explanation/proof.md]

The drives and loads are those of `crates/cbpt-core/tests/proof.rs`: 3 to 200 balls, 1e-3 to 1e6 N,
any input angle, up to 99.9 % of the torque that the preload holds. The first that is not enclosed
ends the run. `--page` writes the table between the marks of a page.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from page_table import parser_of, show_table

TOP = Path(__file__).parents[1]
MARKS = "<!-- benches/enclosures.py -->", "<!-- end of enclosures -->"
HEAD = (
    "| torque, of what is held | drives | enclosed | relative width, median | largest "
    "| proof, median (µs) | solve, median (µs) |\n|---|---|---|---|---|---|---|"
)
COMMAND = "cargo test --release --quiet -p cbpt-core --test mechanics -- --ignored --nocapture"


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("--drives", type=int, default=100_000)
    options = parser.parse_args()
    env = {**os.environ, "DRIVES": str(options.drives)}
    ran = subprocess.run(
        COMMAND.split(), cwd=TOP, env=env, stdout=subprocess.PIPE, text=True, check=False
    )
    if ran.returncode:
        raise SystemExit(ran.stdout)
    rows = [line for line in ran.stdout.splitlines() if line.startswith("| ")]
    show_table([HEAD, *rows], options.page, MARKS)


if __name__ == "__main__":
    main()
