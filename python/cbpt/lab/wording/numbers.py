"""Numbers as people read them, rounded in one way, and words in a row.

The page rounds in the same way (`page/web/lib/numbers.js`), so a number has the same digits there.

DISPLAY             name with its usual unit, and that unit in SI, of each parameter
display             the same of one parameter
ratio_of            what a gain is a ratio of
name_of_size        the parameter that an effect's own size is
listed              a, b and c
significant         a number rounded to so many significant digits
rounded             the same as text
with_uncertainty    a value and its uncertainty, rounded to the same place
probability         never more certain than it can be
percent             a share, neither nothing nor all where it is less than one of them
AngleUnit, ARCSEC   the unit that angles are told in
angle_unit_of       that of a symbol
in_words            a parameter: its name with the unit, and its value in that unit
shown               the same in one text
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbpt._core import effect_specs, unit_size
from cbpt.errors import InvalidInputError
from cbpt.results import ANGLE_UNITS
from cbpt.units import unit_at_end

DISPLAY = {
    (spec.id, p.name): (p.display_name, p.display_size)
    for spec in effect_specs()
    for p in spec.parameters
} | {("ball_diameter_lot", "spread_m"): ("spread_um", 1e-6)}
"""Name with the unit that is usual, and that unit in SI, of each parameter of the library."""


def display(effect: str, name: str) -> tuple[str, float]:
    """Name with the usual unit and that unit in SI; of an own effect its own name, and 1."""
    return DISPLAY.get((effect, name), (name, 1.0))


_RATIOS = {
    (spec.id, p.name): p.meaning.replace(" divided by the ", " over ")
    for spec in effect_specs()
    for p in spec.parameters
    if p.name.endswith("_gain")
}


def ratio_of(effect: str, name: str) -> str | None:
    """What a gain is a ratio of, which its name does not tell: true torque over reading."""
    return _RATIOS.get((effect, name))


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
    if "e+" in text and abs(value) < 1e6:
        return f"{float(text):.0f}"
    return re.sub(r"e([+-])0*", lambda sign: "e" + sign[1].strip("+"), text)


def probability(p: float) -> str:
    """A probability to two decimals, never more certain than it can be."""
    if p < 0.005:
        return "< 0.01"
    return "> 0.99" if p > 0.995 else f"{p:.2f}"


def percent(share: float) -> str:
    """A share in whole percent; one that is neither nothing nor all is not rounded to either."""
    if 0 < share < 0.005:
        return "under 1 %"
    return "over 99 %" if 0.995 < share < 1 else f"{100 * share:.0f} %"


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
    if place < -5:
        return f"{value:.{max(int(np.floor(np.log10(abs(value) or 1))) - place, 0)}e}"
    return f"{value:.{-place}f}"


_SMALL = re.compile("arcsec|arcmin")
"""Angles that parameters of the library have in their usual units; others are of the drawing."""
_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_IN_ARCSEC = re.compile(
    rf"('[^']*')|(?<![\w.-])(?:({_NUMBER})(\.\.| to ))?({_NUMBER}) arcsec\b(?!\^)"
)
"""What is quoted, or an angle or a range of angles in arcsec."""


@dataclass(frozen=True)
class AngleUnit:
    """The unit that angles are told in."""

    symbol: str = "arcsec"

    @property
    def per_arcsec(self) -> float:
        """The value of one arcsec in this unit."""
        return ANGLE_UNITS[self.symbol]

    def number(self, arcsec: float | None, digits: int = 3) -> str:
        """An angle in this unit as text; empty for None."""
        return rounded(None if arcsec is None else arcsec * self.per_arcsec, digits)

    def text(self, arcsec: float, digits: int = 3) -> str:
        """The same with the unit: 5.31 arcsec."""
        return f"{self.number(arcsec, digits)} {self.symbol}"

    def retold(self, text: str) -> str:
        """A text with its angles in arcsec told in this unit, but for what is quoted."""
        if self.symbol == "arcsec":
            return text

        def told(found: re.Match[str]) -> str:
            quoted, low, between, high = found.groups()
            if quoted:
                return str(quoted)
            return (self.number(float(low)) + between if low else "") + self.text(float(high))

        return _IN_ARCSEC.sub(told, text)

    def of_unit(self, written: str) -> str:
        """A unit with this one in place of a small angle: arcsec/(N m) is mrad/(N m)."""
        return _SMALL.sub(self.symbol, written)

    def renamed(self, label: str) -> tuple[str, float]:
        """A name with this unit in place of the small angle that it ends with, and how many of the
        units before make one of it; the name and 1 where it ends with none."""
        unit = unit_at_end(label)
        if unit is None:
            return label, 1.0
        before = unit_size(unit.written)
        name, size = self.named(label, before)
        return name, size / before

    def named(self, label: str, size: float) -> tuple[str, float]:
        """The name of a parameter and the size of its unit in SI, with this unit in place of the
        small angle that the name ends with: `rate_arcsec_per_h` is `rate_mrad_per_h`."""
        unit = unit_at_end(label)
        if self.symbol == "arcsec" or unit is None or not _SMALL.search(unit.symbol):
            return label, size
        stem = label.removesuffix(unit.symbol)
        size = unit_size(_SMALL.sub(self.symbol, unit.written))
        return stem + _SMALL.sub(self.symbol, unit.symbol), size


ARCSEC = AngleUnit()
"""Taken where no unit is chosen."""


def angle_unit_of(symbol: str) -> AngleUnit:
    """The unit of a symbol; raises `InvalidInputError` for one that measures no angle."""
    if symbol not in ANGLE_UNITS:
        required = f"expected one of {', '.join(ANGLE_UNITS)}"
        told = f"angle_unit = {symbol!r}: {required}"
        raise InvalidInputError(told, "angle_unit", symbol, required)
    return AngleUnit(symbol)


def in_words(
    number: tuple[str, str],
    value: float,
    u: float | None,
    unit: str = "",
    angle: AngleUnit = ARCSEC,
) -> tuple[str, str]:
    """A parameter as a case file would have it: its name with the unit, and its value in that unit
    with the uncertainty.

    number: effect and name. value, u: SI. unit: that of an own effect, whose names do not carry it.
    angle: the unit of small angles.
    """
    label, size = angle.named(*display(*number))
    if number not in DISPLAY and unit:
        size = unit_size(unit)
    if u is None:
        told = rounded(value / size)
    else:
        told = " +- ".join(with_uncertainty(value / size, u / size))
    return label, f"{told} {unit}".rstrip() if number not in DISPLAY else told


def shown(
    number: tuple[str, str],
    value: float,
    u: float | None,
    unit: str = "",
    angle: AngleUnit = ARCSEC,
) -> str:
    """A parameter as a case file would have it: `reference_deflection_um 0.209 +- 0.010`."""
    return " ".join(in_words(number, value, u, unit, angle))
