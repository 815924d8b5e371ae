"""What changed since the readings shown, for the page: the answer of `change` with its picture.

change_section   from a case and two tables
"""

from __future__ import annotations

from cbpt._core import Case, Drive
from cbpt.lab.change.answer import Change
from cbpt.lab.change.change import change
from cbpt.lab.change.record import Changed
from cbpt.lab.change.text import limited
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import in_words
from cbpt.page.document.plain import numbers
from cbpt.page.document.types import ChangedNumber, ChangeSection, MeasuredLevel, UnchangedNumber


def change_section(
    case: Case | Drive, before: Readings, after: Readings, names: tuple[str, str]
) -> ChangeSection:
    """Raises `ReadingsError` and `NoSolutionError`. names: of the two tables."""
    found = change(case, before, after)
    return {
        "kind": found.kind,
        "sentence": found.sentence,
        "probability": found.probability,
        "changed": [_changed(c) for c in found.changed],
        "unchanged": _unchanged(found),
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
        "number": number,
        "before": limited(before, first),
        "after": limited(after, last),
        "direction": c.direction,
        "probability": c.probability,
    }


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
