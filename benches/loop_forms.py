"""Which form of loop a real reducer shows: fits of the forms that the library has, side by side.

    python benches/loop_forms.py [--data FOLDER] [--page docs/explanation/loop-forms.md]

Loops of a cycloidal reducer in four builds at several moments (tests/data/interventions), each
fitted with a play and the forms of friction in turn. For each form: the error that is left, the
play, the largest friction torque without load, and the logarithm of the odds against Dahl's form.
`--page` writes the table between the marks of a page.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from interventions import BUILDS, DATA, width_deg
from page_table import parser_of, show_table

import cbpt

FORMS: dict[str, tuple[str, ...]] = {
    "Dahl": ("backlash", "friction_hysteresis"),
    "slip one after another": ("backlash", "distributed_friction"),
    "Dahl and a rate": ("backlash", "friction_hysteresis", "rate_friction"),
    "breaks away": ("backlash", "breakaway_friction"),
    "Dahl and a stop": ("backlash", "friction_hysteresis", "hard_stop"),
}
TORQUE = "friction_torque_Nm"
LEAST = -100
"""Log odds below which a number says nothing more: that fit has ended far from the best numbers."""
MARKS = "<!-- forms of loops: made by benches/loop_forms.py -->", "<!-- end of forms of loops -->"


def cells(case: Path, readings: cbpt.Readings) -> Iterator[str]:
    """Error (arcsec), play (deg), friction (N m) and log odds of each form."""
    first: float | None = None
    for effects in FORMS.values():
        found = cbpt.fit(case, readings, list(effects))
        numbers = found.parameters()
        play = np.degrees(numbers["backlash"]["play_rad"]["value"])
        torques = [n[TORQUE]["value"] for n in numbers.values() if TORQUE in n]
        evidence = found.result.log_evidence
        first = evidence if first is None else first
        log_odds = evidence - first
        told = f"{log_odds:+.0f}" if log_odds > LEAST else f"< {LEAST}"
        error = found.after.rmse_arcsec
        yield f"{error:.0f}, {play:.2f}, {sum(torques):.2f}, {told}"


def rows(data: Path) -> Iterator[str]:
    """Of the table, as they are found."""
    yield f"| build | moment | width, deg | {' | '.join(FORMS)} |"
    yield "|---" * (3 + len(FORMS)) + "|"
    for name in BUILDS:
        table = data / f"{name}.csv"
        readings = cbpt.read_readings(table, need_preload=False, by="moment")
        moment = readings.labels["moment"]
        for each in dict.fromkeys(moment.tolist()):
            part = readings.select(moment == each)
            told = " | ".join(cells(DATA / "reducer.toml", part))
            yield f"| {name} | {each} | {width_deg(part):.2f} | {told} |"


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, default=DATA)
    options = parser.parse_args()
    show_table(rows(options.data), options.page, MARKS)


if __name__ == "__main__":
    main()
