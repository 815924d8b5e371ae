"""What changed since the readings shown, for the page: the answer of `change` with its picture.

change_section   from a case and two tables
"""

from __future__ import annotations

from dataclasses import replace

from cbpt._core import Case, Drive
from cbpt.lab.change.answer import Change
from cbpt.lab.change.change import change
from cbpt.lab.change.record import Changed
from cbpt.lab.change.text import headline_and_rest, limited
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import in_words, listed
from cbpt.page.document.plain import numbers
from cbpt.page.document.types import (
    ChangedNumber,
    ChangeSection,
    MeasuredLevel,
    NumberByItself,
    OpenChange,
    UnchangedNumber,
)


def change_section(
    case: Case | Drive, before: Readings, after: Readings, names: tuple[str, str]
) -> ChangeSection:
    """Raises `ReadingsError` and `NoSolutionError`. names: of the two tables."""
    found = change(case, before, after)
    # What each table has by itself stands in a table of its own.
    headline, rest = headline_and_rest(replace(found, by_itself=()))
    return {
        "kind": found.kind,
        "headline": headline,
        "rest": rest.strip(),
        "probability": found.probability,
        "changed": [_changed(c) for c in found.changed],
        "open": _open(found, names),
        "unchanged": _unchanged(found),
        "loops": [
            {
                "amplitude_Nm": w.amplitude_Nm,
                "width_arcsec": list(w.width_arcsec),
                "u_arcsec": list(w.u_arcsec),
            }
            for w in found.loops
        ],
        "by_itself": _by_itself(found),
        "levels": [
            _level(found, k, name, readings)
            for k, (name, readings) in enumerate(zip(names, found.readings, strict=True))
        ],
        "effects": list(found.effects),
        "remains_arcsec": None if found.remains is None else found.remains["rms_arcsec"],
        "notes": list(found.notes),
    }


def _changed(c: Changed) -> ChangedNumber:
    number, before = in_words((c.effect, c.parameter), c.before, c.u_before, c.unit)
    _, after = in_words((c.effect, c.parameter), c.after, c.u_after, c.unit)
    first, *_, last = c.limits
    return {
        "effect": c.effect,
        "number": f"{number}, by the same share as {c.along}" if c.along else number,
        "before": limited(before, first),
        "after": limited(after, last),
        "direction": c.direction,
        "probability": c.probability,
    }


def _open(found: Change, names: tuple[str, str]) -> list[OpenChange]:
    """By the order of the library, what some table does not show last."""
    rows: list[OpenChange] = []
    for effect, chance in found.perhaps.items():
        why = "the readings do not decide"
        if effect in found.runs_differ:
            why = "runs with the same torques do not agree on it"
        elif effect in found.on_large_loops:
            why = "friction holds the small loops, so it rests on the large ones alone"
        elif effect in found.hidden:
            why = "it is within its uncertainty, or smaller than the misfit that remains"
        rows.append({"effect": effect, "probability": chance, "why": why})
    for effect, levels in found.not_shown.items():
        tables = listed([names[found.levels.index(level)] for level in levels])
        why = f"{tables} does not show it"
        chance = found.weighed.changed(effect)
        rows.append({"effect": effect, "probability": chance, "why": why})
    return rows


def _by_itself(found: Change) -> list[NumberByItself]:
    rows: list[NumberByItself] = []
    for b in found.by_itself:
        told = [
            in_words((b.effect, b.parameter), value, u, b.unit)
            for value, u in zip(b.values, b.u, strict=True)
        ]
        rows.append({"effect": b.effect, "number": told[0][0], "values": [v for _, v in told]})
    return rows


def _unchanged(found: Change) -> list[UnchangedNumber]:
    rows: list[UnchangedNumber] = []
    for u in found.unchanged:
        number, value = in_words((u.effect, u.parameter), u.value, u.u, u.unit)
        rows.append({"effect": u.effect, "number": number, "value": value})
    return rows


def _level(found: Change, k: int, name: str, readings: Readings) -> MeasuredLevel:
    return {
        "name": name,
        "readings": len(readings),
        "rmse_arcsec": found.rmse_arcsec[k],
        "u_arcsec": found.noise.u_arcsec[k],
        "run": readings.run_index.tolist(),
        "torque_Nm": numbers(readings.torque_Nm),
        "elastic_angle_arcsec": numbers(readings.elastic_angle_arcsec),
    }
