"""Whether an effect of the user's own can be fitted, as it is typed.

own_effect_of  what the page sends, as an effect
refusal        what is wrong with an entry that cannot be read, and in which field of the page
why_not        what keeps an effect from being fitted to these readings, before anything is fitted
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cbpt._core import Case, Drive, OwnEffect
from cbpt.effects import expression
from cbpt.errors import CaseError, CaseMistake, InvalidInputError, ReadingsError
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import COLUMNS, variant_of
from cbpt.lab.readings.reader import Readings
from cbpt.page.document.stated import stop_if_taken

_FIELD = re.compile(
    r"(?:effect\[0\]\.)?(parameters\.(\w+)(?:\.(start|min|max|unit))?|id|expression)"
)
_PARAMETER_KEYS = ("unit", "start", "min", "max")
_HEADS = {"start": "start", "min": "minimum", "max": "maximum", "unit": "unit"}

_NOT_FINITE = "effect_not_finite"
# As many tell it, and a check keeps up with who types.
_MOST = 1200


def own_effect_of(entry: Mapping[str, Any]) -> OwnEffect:
    """An own effect from what the page sends: as in a case file, the parameters as a list."""
    for key in ("id", "port", "expression"):
        if not isinstance(entry.get(key), str):
            raise InvalidInputError(f"{key}: expected text", key)
    stop_if_taken(entry["id"])
    parameters = entry.get("parameters") or []
    if not isinstance(parameters, list) or not all(isinstance(p, dict) for p in parameters):
        raise InvalidInputError("parameters: expected a list")
    named = {
        str(p.get("name", "")): {k: p[k] for k in _PARAMETER_KEYS if p.get(k) is not None}
        for p in parameters
    }
    if len(named) < len(parameters):
        raise InvalidInputError("parameters: two have the same name")
    adds_to = entry.get("adds_to")
    return expression(
        entry["id"],
        entry["port"],
        entry["expression"],
        named,
        adds_to=adds_to if isinstance(adds_to, str) else None,
    )


def refusal(error: CaseError | InvalidInputError, entry: Mapping[str, Any]) -> dict[str, Any]:
    """`message`; `field`, as the page names it, or None (`parameters.a`: all that is typed of `a`);
    `column`: the character of the expression, or None."""
    mistakes = error.mistakes if isinstance(error, CaseError) else ()
    if not mistakes:
        key = error.field if isinstance(error, InvalidInputError) else ""
        return {"message": str(error), "column": None, "field": key or None}
    first = mistakes[0]
    field = _FIELD.fullmatch(first.key)
    return {
        "message": "\n".join(_in_words_of_the_page(mistake, entry) for mistake in mistakes),
        "column": first.place[2],
        "field": field[1] if field else None,
    }


def _in_words_of_the_page(mistake: CaseMistake, entry: Mapping[str, Any]) -> str:
    """The mistake under the name that stands over its field."""
    if mistake.place[2] is not None:
        return mistake.words
    key, words = mistake.key, mistake.words
    if field := _FIELD.fullmatch(key):
        key, name, part = field.groups()
        if name:
            key = f"{_HEADS[part]} of {name}" if part else name
            if "," in str(_typed(entry, name).get(part, "")):
                words += ", written with a decimal point"
    found = f" = {mistake.found}" if mistake.found else ""
    return f"{key}{found}: {words}"


def _typed(entry: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """What was typed of a parameter."""
    found = (p for p in entry.get("parameters") or () if p.get("name") == name)
    return next(found, {})


def why_not(effect: OwnEffect, case: Case | Drive, readings: Readings) -> str | None:
    """None where the effect is a number at every reading, with its parameters at their starts, and
    depends on one that may make it vanish."""
    try:
        bare = Campaign.of(case, readings)
        campaign = replace(
            bare,
            own=bare.own | {effect.id: effect},
            effects=tuple(e for e in bare.effects if e[0] != effect.id),
        )
        if said := _missing_column(effect, readings) or _not_finite(effect, campaign):
            return said
        if len(readings) > _MOST:
            some = np.zeros(len(readings), dtype=bool)
            some[:: len(readings) // _MOST + 1] = True
            campaign = campaign.select(some)
        variant_of(effect, campaign)
    except (InvalidInputError, ReadingsError) as error:
        return str(error)
    return None


def _missing_column(effect: OwnEffect, readings: Readings) -> str | None:
    for variable, column in COLUMNS.items():
        if effect.uses(variable) and getattr(readings, column) is None:
            return f"{variable}: the table has no column {column}"
    return None


def _not_finite(effect: OwnEffect, campaign: Campaign) -> str | None:
    r = campaign.readings
    starts = np.array([start for _, _, start, _, _ in effect.parameters])
    _, status = Assembled(campaign, [effect.id]).states(starts)
    bad = np.flatnonzero(status == _NOT_FINITE)
    if not len(bad):
        return None
    first = bad[0]
    load = f"torque {r.torque_Nm[first]:g} N m"
    if r.preload_N is not None:
        load += f", preload {r.preload_N[first]:g} N"
    if r.time_s is not None and effect.uses("time_s"):
        load += f", time {r.time_s[first]:g} s"
    return (
        f"it is no number at {len(bad)} of {len(r)} readings, first at {r.place} "
        f"{r.line[first]} ({load}), with its parameters at their starts"
    )
