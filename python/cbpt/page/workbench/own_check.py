"""Whether an effect of the user's own can be fitted, told as it is typed.

refusal   what is wrong with an entry that cannot be read: in words, and in which field of the page
why_not   what keeps an effect from being fitted to these readings, before anything is fitted
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import COLUMNS, variant_of
from cbpt.lab.readings.reader import Readings

_FIELD = re.compile(r"parameters\.(\w+)(?:\.(start|min|max|unit))?(?= =|:)|(id|expression)(?= =|:)")
_HEADS = {"start": "start", "min": "minimum", "max": "maximum", "unit": "unit"}
_CHARACTER = re.compile(r"character (\d+): (.*)", re.DOTALL)
_WITH_COMMA = re.compile(r'= "[^"]*,[^"]*": expected a finite number$')

_NOT_FINITE = "effect_not_finite"
# As many tell it, and a check keeps up with who types.
_MOST = 1200


def refusal(error: Exception) -> dict[str, Any]:
    """`message`; `field`, as the page names it, or None (`parameters.a`: all that is typed of `a`);
    `column`: the character of the expression, or None."""
    text = str(error).removeprefix("effect[0].")
    at, field = _CHARACTER.search(text), _FIELD.match(text)
    message = at[2] if at else text
    if not at and field and field[1]:
        # In the words that stand over the fields.
        of = f"{_HEADS[field[2]]} of {field[1]}" if field[2] else field[1]
        message = of + text[field.end() :]
        if _WITH_COMMA.search(text):
            message += ", written with a decimal point"
    return {
        "message": message,
        "column": int(at[1]) if at else None,
        "field": field[0] if field else None,
    }


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
