"""The core's table of units, by symbol.

UNITS        every unit that keys, columns and flags may carry
unit_at_end  the unit in which a name ends: N m of `torque_Nm`
"""

from __future__ import annotations

from cbpt._core import Unit, units

__all__ = ["UNITS", "unit_at_end"]

UNITS = {unit.symbol: unit for unit in units()}


def unit_at_end(name: str) -> Unit | None:
    """The unit in which a name ends; None for a plain number and where the unit is not known.

    `torque_Nm` ends in N m, `rate_arcsec_per_h` in arcsec/h, `share` and `rate_deg_per_week` in
    none.
    """
    start = name.find("_") + 1
    while start:
        if name[start:] in UNITS and not name[: start - 1].endswith("_per"):
            return UNITS[name[start:]]
        start = name.find("_", start) + 1
    return None
