"""What `cbpt change` says of a real reducer, against what was done to it.

    python benches/interventions.py [--page docs/explanation/change.md]

Loops of a cycloidal reducer in four builds, each measured at several moments: as assembled, after a
run-in, after each further turn of the anti-backlash screws, and twice without anything done in
between (tests/data/interventions). Every moment is held against the one before it, and the last
against the first after the run-in. The width is model-free: the angle between both branches at zero
torque in the loops of +-4 N m. `--page` writes the table between the marks of a page.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from page_table import parser_of, show_table

import cbpt
from cbpt.lab.change.record import Changed

DATA = Path(__file__).parents[1] / "tests" / "data" / "interventions"
BUILDS = ("conic_pccf_1", "split_undersized_pccf_1", "base_onyx_1", "split_onyx_1")
EFFECTS = ("backlash", "friction_hysteresis")
SMALL_Nm = 10.0
MARKS = "<!-- interventions: made by benches/interventions.py -->", "<!-- end of interventions -->"
WAYS = {"up": "rose", "down": "fell", "new": "appeared", "gone": "disappeared"}


def pairs_of(moments: list[str]) -> Iterator[tuple[str, str]]:
    """Each with the next one, and the first after the run-in with the last."""
    yield from pairwise(moments)
    if "preload_2" in moments:
        yield "after_run_in", moments[-1]


def done(before: str, after: str) -> str:
    """What was done in between."""
    if before == f"{after}_repeated":
        return "nothing"
    if after.startswith("after_run_in"):
        return "run in"
    steps = int(after.rpartition("_")[2])
    steps -= int(before.rpartition("_")[2]) if before.startswith("preload") else 0
    return "preload raised" if steps == 1 else f"preload raised {steps} times"


def width_deg(readings: cbpt.Readings) -> float:
    """Falling less rising branch at zero torque, mean over the small loops; a loop ends where it
    comes back to zero."""
    found = []
    for run in np.unique(readings.run_index):
        here = readings.run_index == run
        torque, angle = readings.torque_Nm[here], readings.elastic_angle_arcsec[here] / 3600
        if np.abs(torque).max() < SMALL_Nm:
            top = int(np.argmax(torque))
            cross = top + int(np.argmax(torque[top:] <= 0))
            falling = np.interp(0.0, torque[[cross, cross - 1]], angle[[cross, cross - 1]])
            found.append(float(falling - angle[-1]))
    return float(np.mean(found))


def told(found: cbpt.Change) -> str:
    """The verdict in a cell."""
    if not found.changed:
        return f"{found.kind}: the loops differ" if found.differing_loops else found.kind
    alone = [_told(c) for c in found.foremost if not c.rivals]
    groups = [
        f"one of {' or '.join(_told(c) for c in found.foremost if c.effect in group)}"
        for group in found.rivals
    ]
    return "; ".join([*alone, *groups]) or "changed, and not told what"


def by_itself(found: cbpt.Change, parameter: str, form: str, unit: float = 1.0) -> str:
    """A size as it is fitted to each moment by itself."""
    values = next((b.values for b in found.by_itself if b.parameter == parameter), ())
    return " to ".join(form.format(unit * value) for value in values)


def _told(c: Changed) -> str:
    sizes = _sizes(c)
    if not c.moved:
        return f"{c.effect} changed, no number by more than twice its uncertainty"
    way = WAYS[c.direction]
    # Another transition torque is no less play.
    return f"{c.effect} changed: {sizes} ({way})" if c.is_shape else f"{c.effect} {way}: {sizes}"


def _sizes(c: Changed) -> str:
    before, after, unit = c.before, c.after, f" {c.unit}"
    if c.unit == "rad":
        before, after, unit = float(np.degrees(before)), float(np.degrees(after)), " deg"
    name = c.parameter
    for suffix in ("_rad_per_Nm", "_rad", "_Nm"):
        name = name.removesuffix(suffix)
    first, *_, last = ("" if limit is None else " (limit)" for limit in c.limits)
    return f"{name} {before:.3g}{first} to {after:.3g}{unit}{last}".rstrip()


def rows() -> Iterator[str]:
    """Of the table, as they are found."""
    yield (
        "| build | from | to | done | width, deg | play, deg | friction, N m | `change` says | p | "
        "levels differ, arcsec |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for name in BUILDS:
        readings = cbpt.read_readings(DATA / f"{name}.csv", need_preload=False, by="moment")
        moment = readings.labels["moment"]
        for pair in pairs_of(list(dict.fromkeys(moment.tolist()))):
            # Without their names, by which a state that is measured twice says so itself.
            parts = [replace(readings.select(moment == m), labels={}) for m in pair]
            found = cbpt.change(DATA / "reducer.toml", *parts, effects=EFFECTS)
            apart = found.levels_differ_by_arcsec
            cells = [
                name,
                *pair,
                done(*pair),
                " to ".join(f"{width_deg(part):.2f}" for part in parts),
                by_itself(found, "play_rad", "{:.2f}", np.degrees(1.0)),
                by_itself(found, "friction_torque_Nm", "{:.1f}"),
                told(found),
                f"{found.probability:.2f}",
                "" if apart is None else f"{apart:.0f}",
            ]
            yield f"| {' | '.join(cells)} |"


def main() -> None:
    show_table(rows(), parser_of(__doc__).parse_args().page, MARKS)


if __name__ == "__main__":
    main()
