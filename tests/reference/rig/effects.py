"""Effects that the rig can hide in its readings, each from its own physics and in several forms.

`form="library"` is the textbook form; the others are sensible variations of the same cause. Every
effect has one number that is its size; at its neutral value it changes nothing. OUTSIDE holds
effects that no library of causes knows.
"""

from __future__ import annotations

from reference.rig.kinds import Hidden, Kind, draw_hidden
from reference.rig.loads import LOADS
from reference.rig.outside import OUTSIDE
from reference.rig.series import SERIES

__all__ = ["LIBRARY", "OUTSIDE", "Hidden", "Kind", "draw_hidden", "hidden"]

LIBRARY: dict[str, Kind] = {**SERIES, **LOADS}


def hidden(effect_id: str, form: str = "library", **values: float) -> Hidden:
    """An effect by its id; every number it needs must be given."""
    kind = {**LIBRARY, **OUTSIDE}[effect_id]
    if form not in kind.forms:
        raise ValueError(f"{effect_id} has the forms {kind.forms}, not {form}")
    return Hidden(kind, values, form)
