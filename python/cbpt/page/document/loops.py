"""The table by itself, for the page: checks before any model, and the figures of its loops.

table_section   both, from what `preflight` and `characterise` say, before and after the answer
table_of        the same of a document, whose answer it takes
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from cbpt._core import Case, Drive
from cbpt.errors import CbptError
from cbpt.lab.characteristics.characterise import characterise
from cbpt.lab.characteristics.uncertainty import Figure
from cbpt.lab.preflight.checks import checks
from cbpt.lab.readings.reader import Readings
from cbpt.page.document.types import PageDocument

_MOST_SETTINGS = 8
"""A page of more loops than that is no page."""


def table_section(
    case: Case | Drive, readings: Readings, after: str | None = None
) -> dict[str, Any]:
    """It takes longer than a first plot may wait, so a page has it once there is a diagnosis.

    after: the case with the answer in it, as TOML.
    """
    return {
        "checks": [asdict(check) for check in checks(readings, case)],
        "loops": _loops(case, readings, None if after is None else Case.from_toml(after)),
    }


def table_of(document: PageDocument, case: Case | Drive, readings: Readings) -> dict[str, Any]:
    """The section of a document, with the model of its answer where that has a case file."""
    key = document["answer_key"]
    after = next((e["case_text"] for e in document["models"] if e["key"] == key), None)
    return table_section(case, readings, after)


def _loops(case: Case | Drive, readings: Readings, after: Case | None) -> list[dict[str, Any]]:
    try:
        found = characterise(case, readings)
        then = characterise(after, readings).groups if after is not None else ()
    except CbptError:  # no loop in the table, or no torque to rate it by
        return []
    answered = {group.setting: {f.name: f for f in group.model} for group in then}
    return [
        {
            "setting": group.setting,
            "figures": [
                _figure(a, b, answered.get(group.setting, {}).get(a.name))
                for a, b in zip(group.readings, group.model, strict=True)
            ],
            "warnings": list(group.warnings),
        }
        for group in found.groups[:_MOST_SETTINGS]
    ]


def _figure(of_readings: Figure, of_model: Figure, answered: Figure | None) -> dict[str, Any]:
    return {
        "name": of_readings.name,
        "unit": of_readings.unit,
        "convention": of_readings.convention,
        "value": of_readings.value,
        "u": of_readings.u,
        "model": of_model.value,
        "u_model": of_model.u,
        "after": None if answered is None else answered.value,
        "u_after": None if answered is None else answered.u,
        "reason": of_readings.reason,
    }
