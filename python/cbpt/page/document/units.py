"""Units as the page writes them, from the core's table.

ANGLE_SIZES   units of angle that the page can be read in, each with its size in arcsec
written       a unit of the core's table in print
at_ends       how the units at the ends of keys are written
"""

from __future__ import annotations

import re

from cbpt.results import ANGLE_UNITS
from cbpt.units import UNITS, unit_at_end

__all__ = ["ANGLE_SIZES", "at_ends", "name_and_unit", "written"]

ANGLE_SIZES = {
    unit: 1.0 / ANGLE_UNITS[unit] for unit in ("arcsec", "arcmin", "deg", "mrad", "urad")
}
_SIGNS = {"degC": "°C", "deg": "°", "um": "µm", "urad": "µrad"}


def written(unit: str) -> str:
    """A unit in print: `urad/(N m)` is µrad/(N m), `1/rad^2` is 1/rad²."""
    signs = re.sub(r"[A-Za-z]+", lambda word: _SIGNS.get(word[0], word[0]), unit)
    return signs.replace("^2", "²")


def at_ends() -> dict[str, str]:
    """By the end of a key, without the underscore before it."""
    return {symbol: written(unit.written) for symbol, unit in UNITS.items() if symbol}


def name_and_unit(key: str) -> tuple[str, str]:
    """The name in words and the unit in print: `torque_Nm` is torque and N m."""
    unit = unit_at_end(key)
    name = key if unit is None else key.removesuffix(f"_{unit.symbol}")
    return name.replace("_", " "), "" if unit is None else written(unit.written)
