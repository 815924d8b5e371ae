"""Numbers as people read them, rounded in one way, and words in a row.

DISPLAY             name with its usual unit, and that unit in SI, of each parameter
display             the same of one parameter
name_of_size        the parameter that an effect's own size is
listed              a, b and c
significant         a number rounded to so many significant digits
rounded             the same as text
with_uncertainty    a value and its uncertainty, rounded to the same place
in_words            a parameter: its name with the unit, and its value in that unit
shown               the same in one text
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbpt._core import effect_specs

DISPLAY = {
    (spec.id, p.name): (p.display_name, p.display_size)
    for spec in effect_specs()
    for p in spec.parameters
} | {("ball_diameter_lot", "spread_m"): ("spread_um", 1e-6)}
"""Name with the unit that is usual, and that unit in SI, of each parameter of the library."""


def display(effect: str, name: str) -> tuple[str, float]:
    """Name with the usual unit and that unit in SI; of an own effect its own name, and 1."""
    return DISPLAY.get((effect, name), (name, 1.0))


def name_of_size(effect: str) -> str:
    """The first parameter of an effect of the library, which is its size."""
    return next(name for known, name in DISPLAY if known == effect)


def listed(words: Sequence[str], last: str = "and") -> str:
    """a, b and c; empty for no words."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def significant(value: float, digits: int = 3) -> float:
    """A number rounded to so many significant digits."""
    return float(f"{value:.{digits}g}")


def rounded(value: float | None, digits: int = 3) -> str:
    """A number to so many significant digits, without an exponent where that is short; empty for
    None."""
    if value is None:
        return ""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+0" in text and abs(value) < 1e6 else text


def with_uncertainty(value: float, u: float, *more: float) -> tuple[str, ...]:
    """Value, uncertainty and whatever else, as text: two digits of the uncertainty, and all to the
    same place. An uncertainty of zero, or one that is not finite, leaves three digits of each."""
    if not u > 0 or not np.isfinite(u):
        return tuple(rounded(number) for number in (value, u, *more))
    place = int(np.floor(np.log10(u))) - 1
    if round(u / 10.0**place) >= 100:  # 0.0996 rounds up to 0.10
        place += 1
    return tuple(_to(number, place) for number in (value, u, *more))


def _to(value: float, place: int) -> str:
    """A number rounded to a power of ten."""
    if place >= 0:
        whole = round(value / 10.0**place) * 10.0**place
        return f"{whole:.0f}" if place < 6 else f"{whole:.3g}"
    if place < -7:
        return f"{value:.{max(int(np.floor(np.log10(abs(value) or 1))) - place, 0)}e}"
    return f"{value:.{-place}f}"


def in_words(
    effect: str, name: str, value: float, u: float | None, unit: str = ""
) -> tuple[str, str]:
    """A parameter as a case file would have it: its name with the unit, and its value in that unit
    with the uncertainty. `unit` is for an own effect, whose names do not carry it."""
    if (effect, name) not in DISPLAY:
        known = "" if u is None else f" +- {u:.2g}"
        return name, f"{value:.4g}{known} {unit}".rstrip()
    label, size = DISPLAY[effect, name]
    if u is None:
        return label, rounded(value / size)
    return label, " +- ".join(with_uncertainty(value / size, u / size))


def shown(effect: str, name: str, value: float, u: float | None, unit: str = "") -> str:
    """A parameter as a case file would have it: `reference_deflection_um 0.209 +- 0.010`."""
    return " ".join(in_words(effect, name, value, u, unit))
