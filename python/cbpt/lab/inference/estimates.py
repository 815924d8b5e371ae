"""The parameters of a fit as reports and documents show them.

parameters_of  the parameters of one effect: value, uncertainty or why there is none, unit
parameter      one of them
unit_of        the unit at the end of a name
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.priors import LOT
from cbpt.units import unit_at_end


def parameters_of(fit: Fit, effect: str) -> dict[str, dict[str, Any]]:
    """Values of an effect's parameters, SI, with standard uncertainties, or why there is none.

    All that a case needs to have the effect: what its form fixes (a harmonic) comes last.
    """
    own = [u for u in fit.unknowns if u.name.startswith(effect + ".")]
    if effect == LOT and own:
        # One number for many balls: how far their diameters differ.
        sizes = np.array([fit.value(u) for u in own])
        spread = {"value": float(sizes.std()), "u": None, "unit": "m", "at_bound": False}
        return {
            "spread_m": spread | {"why_no_u": f"it is computed from {len(own)} fitted diameters"}
        }
    units = dict(unit for v in fit.hypothesis.variants if v.effect == effect for unit in v.units)
    found = {u.name.partition(".")[2]: parameter(fit, u) for u in own}
    for variant in fit.hypothesis.variants:
        for name, value in variant.fixed if variant.effect == effect else ():
            found[name] = {
                "value": value,
                "u": None,
                "unit": unit_of(name),
                "at_bound": False,
                "why_no_u": "it was chosen among the forms of the effect, not fitted",
            }
    # The names of an own effect's parameters do not tell their units.
    return {name: p | {"unit": units.get(name, p["unit"])} for name, p in found.items()}


def parameter(fit: Fit, u: Unknown) -> dict[str, Any]:
    """One number, SI, with its standard uncertainty or why there is none."""
    value, sd = fit.value(u), fit.u(u)
    at_bound = (
        bool(value <= u.lower * (1 + 1e-9) or value >= u.upper * (1 - 1e-9))
        if u.upper > u.lower
        else False
    )
    why = None
    if at_bound:
        why = "the fitted value is at the end of its allowed range"
    elif not np.isfinite(sd) or (np.isfinite(u.upper) and sd > (u.upper - u.lower)):
        why = "the readings do not determine it"
    elif _elsewhere(fit, u):
        why = "another value or form of the effect fits about as well, see the notes"
    return {
        "value": value,
        "u": None if why else sd,
        "unit": unit_of(u.name.partition(".")[2]),
        "at_bound": at_bound,
        "why_no_u": why,
    }


def _elsewhere(fit: Fit, u: Unknown) -> bool:
    """Whether another solution has other sizes of the same effect, or has it in another form."""
    if u.size_of < 0:
        return False
    sizes = [own for own in fit.unknowns if own.size_of == u.size_of]
    form = fit.hypothesis.variants[u.size_of]
    for other in fit.other_modes:
        if form not in other.hypothesis.variants:
            return True
        there = {o.name: o for o in other.unknowns}
        for own in sizes:
            same = there[own.name]
            off = abs(other.value(same) - fit.value(own))
            if off > np.hypot(fit.u(own), other.u(same)):
                return True
    return False


def unit_of(name: str) -> str:
    """The unit at the end of a parameter's name; empty for pure numbers."""
    unit = unit_at_end(name)
    return unit.written if unit else ""
