"""Which form of loop a real reducer shows: fits of the forms that the library has, side by side.

    python benches/loop_forms.py [--data FOLDER] [--page docs/explanation/loop-forms.md]

Loops of a cycloidal reducer in four builds at several moments (tests/data/interventions), each
fitted with a play and the forms of friction in turn. For each form: the error that is left, the
play, the largest friction torque without load, and the logarithm of the odds against Dahl's form.
The last rows count the moments. `--page` writes the table between the marks of a page.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

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


DEMANDED = 3.0
"""Log odds from which on a form is demanded, and below minus which it is excluded."""


class Cell(NamedTuple):
    """Error (arcsec), play (deg), friction (N m) and log odds of a form."""

    error_arcsec: float
    play_deg: float
    friction_Nm: float
    log_odds: float

    def __str__(self) -> str:
        told = f"{self.log_odds:+.0f}" if self.log_odds > LEAST else f"< {LEAST}"
        return f"{self.error_arcsec:.0f}, {self.play_deg:.2f}, {self.friction_Nm:.2f}, {told}"


def cells(case: Path, readings: cbpt.Readings) -> Iterator[Cell]:
    """Of each form."""
    first: float | None = None
    for effects in FORMS.values():
        found = cbpt.fit(case, readings, list(effects))
        numbers = found.parameters()
        play = np.degrees(numbers["backlash"]["play_rad"]["value"])
        torques = [n[TORQUE]["value"] for n in numbers.values() if TORQUE in n]
        evidence = found.result.log_evidence
        first = evidence if first is None else first
        yield Cell(found.after.rmse_arcsec, float(play), sum(torques), evidence - first)


def rows(data: Path) -> Iterator[str]:
    """Of the table, as they are found."""
    yield f"| build | moment | width, deg | {' | '.join(FORMS)} |"
    yield "|---" * (3 + len(FORMS)) + "|"
    found: list[tuple[float, list[Cell]]] = []
    for name in BUILDS:
        table = data / f"{name}.csv"
        readings = cbpt.read_readings(table, need_preload=False, by="moment")
        moment = readings.labels["moment"]
        for each in dict.fromkeys(moment.tolist()):
            part = readings.select(moment == each)
            found.append((width_deg(part), list(cells(DATA / "reducer.toml", part))))
            told = " | ".join(map(str, found[-1][1]))
            yield f"| {name} | {each} | {found[-1][0]:.2f} | {told} |"
    yield from counted(found)


def counted(found: Sequence[tuple[float, Sequence[Cell]]]) -> Iterator[str]:
    """At how many moments a form is demanded or excluded, has the smallest error, and, where it is
    demanded, less than two thirds of the width as play; and what is then left."""
    widths = [width for width, _ in found]
    forms = list(zip(*(row for _, row in found), strict=True))
    least = [min(cell.error_arcsec for cell in row) for _, row in found]
    wanted = [[c.log_odds >= DEMANDED for c in form] for form in forms]
    rows: dict[str, list[str]] = {
        f"demanded (log odds {DEMANDED:+g} or more)": [str(sum(w)) for w in wanted],
        f"excluded ({-DEMANDED:+g} or less)": [
            str(sum(c.log_odds <= -DEMANDED for c in form)) for form in forms
        ],
        "smallest error": [
            str(sum(c.error_arcsec == e for c, e in zip(form, least, strict=True)))
            for form in forms
        ],
        "demanded, and play below 2/3 of the width": [
            str(
                sum(
                    w and c.play_deg < width / 1.5
                    for w, c, width in zip(ws, form, widths, strict=True)
                )
            )
            for ws, form in zip(wanted, forms, strict=True)
        ],
        "demanded: error left": [
            _range([c.error_arcsec for w, c in zip(ws, form, strict=True) if w])
            for ws, form in zip(wanted, forms, strict=True)
        ],
    }
    for label, told in rows.items():
        yield f"| of {len(found)} moments | {label} |  | {' | '.join(told)} |"


def _range(values: Sequence[float]) -> str:
    return f"{min(values):.0f} to {max(values):.0f}" if values else ""


def main() -> None:
    parser = parser_of(__doc__)
    parser.add_argument("--data", type=Path, default=DATA)
    options = parser.parse_args()
    show_table(rows(options.data), options.page, MARKS)


if __name__ == "__main__":
    main()
