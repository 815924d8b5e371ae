"""What a column header says: a quantity and the unit it is given in.

    find_unit, units_of  units by their spellings, and those of a kind (the table is the core's)
    converted            values in another unit
    Quantity, CONTRACT   the columns a table of readings may have, and the names they go by
    read_stated          what somebody says that a header means
    other_unit           the unit in a header where another was stated
    read_header          "T (N·m)" -> torque in N m; or what is missing before it can be read

A unit is never guessed. A word ("torque") names its quantity whatever follows; a letter ("T")
names it only together with a unit of the right kind, because letters mean other things as well.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Unit, units
from cbpt.errors import TakeColumn, Words

__all__ = [
    "CONTRACT",
    "Header",
    "Quantity",
    "converted",
    "find_unit",
    "other_unit",
    "plain",
    "read_header",
    "read_stated",
    "unit_at_end",
    "units_of",
]


# What a column may measure, in the order in which an unknown unit is looked for.
_KINDS = ("torque", "force", "angle", "time", "temperature", "length")
_OF_KIND = {kind: [unit for unit in units() if unit.quantity == kind] for kind in _KINDS}
_UNITS: dict[str, dict[str, Unit]] = {
    kind: {spelling: unit for unit in known for spelling in (unit.symbol, *unit.spellings)}
    for kind, known in _OF_KIND.items()
}
_ANY_CASE = {
    kind: {spelling.casefold(): unit for spelling, unit in known.items()}
    for kind, known in _UNITS.items()
}
# Written in capitals these could be mega as well as milli: only the exact spelling will do.
_MILLI = {"mnm", "mn", "mrad", "ms"}


def _squeeze(text: str) -> str:
    """A unit without what may be written between its parts; look-alike signs made one."""
    text = unicodedata.normalize("NFKC", text).replace("’", "'").replace("”", '"')
    return re.sub(r"[\s·⋅∙•*×.\-−_]+", "", text.replace("µ", "μ"))


def find_unit(text: str, kind: str | None = None) -> Unit | None:
    """The unit that `text` spells; None if it is unknown.

    Case matters ("mN m" is no "MN m"), but where `kind` is known and no prefix hangs on it any
    case will do: "NM" of a torque. A unit of another kind is still found, so look at its kind.
    """
    spelled = _squeeze(text)
    folded = spelled.casefold()
    if kind is not None:
        unit = _UNITS[kind].get(spelled)
        if unit is None and folded not in _MILLI:
            unit = _ANY_CASE[kind].get(folded)
        if unit is not None:
            return unit
    return next((known[spelled] for known in _UNITS.values() if spelled in known), None)


def units_of(kind: str) -> list[str]:
    """The units of a kind as people write them: N m, N cm, ..."""
    return [unit.written for unit in _OF_KIND[kind]]


def converted(values: NDArray[np.float64], unit: Unit, to: Unit) -> NDArray[np.float64]:
    """The same quantities in another unit of the same kind; unchanged if it is this one."""
    if unit == to:
        return values
    times, over, plus = unit.conversion(to)
    return values * times / over + plus if plus else values * times / over


@dataclass(frozen=True, slots=True)
class Quantity:
    """A column that readings may have: its own name, its unit, and what else it is called.

    `kind` is "" for a label or a count, which has no unit. `words` are sure to mean this
    quantity, `letters` only together with a unit of its kind.
    """

    key: str
    kind: str
    unit: str
    words: tuple[str, ...]
    letters: tuple[str, ...] = ()

    @property
    def column(self) -> str:
        """Name and unit that it has everywhere: torque_Nm."""
        return f"{self.key}_{_squeeze(self.unit)}" if self.unit else self.key


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


CONTRACT: tuple[Quantity, ...] = (
    Quantity("run", "", "", _names("run, run no, run number, run id, test run, lauf, versuch")),
    Quantity("time", "time", "s", _names("time, elapsed time, zeit"), ("t",)),
    Quantity(
        "torque",
        "torque",
        "N m",
        _names(
            "torque, output torque, load torque, loading torque, applied torque, "
            "resistance torque, brake torque, moment, load moment, output moment, "
            "drehmoment, lastmoment, abtriebsmoment"
        ),
        _names("t, m, m0, m 0"),
    ),
    Quantity(
        "preload",
        "force",
        "N",
        _names(
            "preload, pre load, preload force, preloading force, axial preload, "
            "axial preload force, axial force, pretightening force, axial pretightening force, "
            "apf, vorspannung, vorspannkraft, axialkraft"
        ),
        _names("n z, nz"),
    ),
    Quantity(
        "input_angle",
        "angle",
        "deg",
        _names(
            "input angle, input shaft angle, input rotation, crank angle, eingangswinkel, "
            "antriebswinkel"
        ),
        _names("theta, θ"),
    ),
    Quantity("temperature", "temperature", "degC", _names("temperature, temp, temperatur"), ("t",)),
    Quantity(
        "elastic_angle",
        "angle",
        "arcsec",
        _names(
            "elastic angle, elastic rotation angle, elastic torsion angle, torsion angle, "
            "torsional angle, twist angle, angle of twist, twist, verdrehwinkel, torsionswinkel, "
            "verdrehung"
        ),
        _names("alpha, α"),
    ),
    Quantity(
        "u_elastic_angle",
        "angle",
        "arcsec",
        _names(
            "u elastic angle, elastic angle standard uncertainty, standard uncertainty, "
            "standard uncertainty of elastic angle, standard uncertainty of the elastic angle"
        ),
        _names("u, u alpha, u α, sigma, σ, sigma alpha, σ α"),
    ),
    Quantity("cycle", "", "", _names("cycle, cycle no, cycle number, zyklus")),
    Quantity("preload_step", "", "", _names("preload step, preload setting, preload stage")),
    Quantity(
        "sensor_displacement",
        "length",
        "um",
        _names("sensor displacement, displacement"),
        _names("dh, δh, delta h"),
    ),
    Quantity(
        "u_sensor_displacement",
        "length",
        "um",
        _names("u sensor displacement, sensor displacement standard uncertainty"),
        _names("u, u dh, u δh, u delta h"),
    ),
)


@dataclass(frozen=True, slots=True)
class Header:
    """What one header was found to say.

    With `quantity` set and `expected` empty the column can be used. `expected` (and `remedy`)
    tell what has to be stated before it can; `candidates` are then what it may have meant.
    With neither the column is none that readings have, and `hint` tells if it came close to one.
    """

    quantity: Quantity | None = None
    unit: Unit | None = None
    candidates: tuple[Quantity, ...] = ()
    expected: str = ""
    remedy: str = ""
    hint: str = ""
    bare: bool = False
    """Whether a unit is expected and none is stated, not even a wrong one."""


LONGEST_HEADER = 1000
"""Signs; what is longer has no meaning."""
_BRACKETS = re.compile(r"(.+?) ?(?:\[([^\[\]]*)\]|\(([^()]*)\))")
_BLANKS = re.compile(r"[\s_\-().]+")


def plain(name: str) -> str:
    """A name as it is compared: blanks, underscores, hyphens and case make no difference."""
    return _BLANKS.sub(" ", unicodedata.normalize("NFKC", name)).strip().casefold()


def _one_line(header: str) -> str:
    """A header with single blanks; of one that is too long, nothing."""
    squeezed = " ".join(header.split())
    return squeezed if len(squeezed) <= LONGEST_HEADER else ""


def _by_name() -> dict[str, tuple[tuple[Quantity, ...], bool]]:
    """What each name means, and whether it is a word (sure) or a letter."""
    words: dict[str, tuple[Quantity, ...]] = {}
    letters: dict[str, tuple[Quantity, ...]] = {}
    both: dict[str, tuple[Quantity, ...]] = {}
    for each in CONTRACT:
        for word in each.words:
            words[word] = (*words.get(word, ()), each)
        for letter in each.letters:
            letters[letter] = (*letters.get(letter, ()), each)
        # "Torque M0", "Elastic angle α": a word and its own letter.
        for word in each.words:
            for letter in each.letters:
                both.setdefault(f"{word} {letter}", (each,))
    sure = {True: both, False: letters}
    found = {name: (each, is_sure) for is_sure, of in sure.items() for name, each in of.items()}
    return found | {name: (each, True) for name, each in words.items()}


_BY_NAME = _by_name()
_MOST_PARTS = max(len(name.split()) for name in _BY_NAME)


def _named(name: str) -> tuple[tuple[Quantity, ...], bool]:
    """The quantities that go by `name`, and whether it is a word (sure) or a letter."""
    return _BY_NAME.get(plain(name), ((), False))


def _split(header: str) -> tuple[str, str | None]:
    """Name and unit of a header; the unit is None where none is given."""
    if brackets := _BRACKETS.fullmatch(header):
        unit = brackets[2] if brackets[2] is not None else brackets[3]
        name = brackets[1].rstrip(" /,").removesuffix(" in").rstrip()  # "torque / (N m)"
        if not (brackets[2] is None and _named(header)[0]):  # "u(alpha)" is a name
            return name, unit
    for mark in "/,":
        name, found, unit = header.rpartition(mark)
        if found and _named(name)[0]:
            return name, unit
    # "torque_Nm", "Torque N m": a name is a run of parts, and the unit what is left of them.
    parts = [part for part in re.split(r"[\s_\-]+", header) if part]
    for count in range(min(len(parts), _MOST_PARTS), 0, -1):
        name, rest = " ".join(parts[:count]), parts[count:]
        if not _named(name)[0]:
            continue
        if not rest:
            return name, None
        if rest[0] == "in" and rest[1:]:
            rest = rest[1:]
        unit = "".join(rest)
        if any(find_unit(unit, each.kind or None) for each in _named(name)[0]):
            return name, unit
    return header, None


def _capital_u(name: str) -> bool:
    """Whether a name starts with a lone capital U, and not because all of it is in capitals."""
    parts = [part for part in _BLANKS.split(name) if part]
    return parts[0] == "U" and (len(parts) == 1 or name != name.upper())


def unit_at_end(header: str) -> str:
    """What stands at the end of a header where a unit would, known or not; else nothing."""
    header = _one_line(header)
    if brackets := _BRACKETS.fullmatch(header):
        return (brackets[2] if brackets[2] is not None else brackets[3]).strip()
    parts = re.split(r"[\s_\-/,]+", header)
    return parts[-1] if len(parts) > 1 else ""


def other_unit(taken: Unit, header: str, below: str) -> Unit | None:
    """The unit that a header or the row under it states where another of its kind is taken."""
    own = find_unit(below or unit_at_end(header), taken.quantity)
    return own if own and own.quantity == taken.quantity and own != taken else None


def read_stated(stated: str, header: str, below: str) -> Header:
    """What somebody says that a header means: a quantity in a unit, or in that of the header; or
    "extra", which is none."""
    if stated == "extra":
        return Header()
    said = read_header(stated)
    if said.quantity and said.expected:
        said = read_header(stated, below or unit_at_end(header))
    if said.expected:
        column = said.candidates[0].column
        return replace(said, remedy=Words("for example ", TakeColumn(header, column)))
    if said.quantity:
        return said
    known = ", ".join(quantity.column for quantity in CONTRACT)
    return Header(expected=f'one of {known} (in any unit) or "extra", not {stated!r}')


def read_header(header: str, unit_below: str | None = None) -> Header:
    """What a header says, with the cell of a row of units under it where there is one.

    Forms read: `name_unit`, `name unit`, `name [unit]`, `name (unit)`, `name / unit`,
    `name, unit`, or a bare name over a unit.
    """
    if not (header := _one_line(header)):
        return Header()
    name, inside = _split(header)
    below = (unit_below or "").strip().strip("[]()")
    stated = [unit.strip() for unit in (inside, below) if unit]
    stated = [unit for unit in stated if unit not in {"", "-", "–", "—", "1"}]
    candidates, sure = _named(name)
    if not candidates:
        return Header(hint=_near(header))
    if not any(each.kind for each in candidates):
        quantity = candidates[0]
        if not stated:
            return Header(quantity, None, candidates)
        expected = f"no unit for {quantity.key}, which is a label or a count"
        return Header(None, None, candidates, expected, _rename(header, candidates))
    if not stated:
        names = " or ".join(each.key for each in candidates)
        kinds = "; ".join(dict.fromkeys(", ".join(units_of(each.kind)) for each in candidates))
        only = candidates[0] if len(candidates) == 1 else None
        expected = f"a unit for {names} ({kinds})"
        return Header(only, None, candidates, expected, _rename(header, candidates), bare=True)

    fits = [
        (each, unit)
        for each in candidates
        if (unit := find_unit(stated[0], each.kind)) is not None and unit.quantity == each.kind
    ]
    if not fits:
        reason = f"{stated[0]!r} is not a unit of {' or '.join(each.key for each in candidates)}"
        if not sure:
            return Header(hint=reason)
        expected = (
            f"one of {', '.join(units_of(candidates[0].kind))} as the unit of {candidates[0].key}"
        )
        remedy = Words("convert the column to one of these, then ", _rename(header, candidates))
        return Header(candidates[0], None, candidates, expected, remedy)
    quantity, unit = fits[0]
    for other in stated[1:]:
        if find_unit(other, quantity.kind) != unit:
            expected = f"one unit, not both {stated[0]!r} and {other!r}"
            return Header(quantity, None, candidates, expected, _rename(header, (quantity,)))
    if quantity.key.startswith("u_") and _capital_u(name):
        expected = "the standard uncertainty u (k = 1); a capital U usually means the expanded one"
        return Header(quantity, None, candidates, expected, _rename(header, (quantity,)))
    return Header(quantity, unit, (quantity,))


def _rename(header: str, candidates: tuple[Quantity, ...]) -> str:
    """How a user states what a header means."""
    first = candidates[0]
    if not first.unit:
        return f"rename the column to {first.key}"
    return Words(
        f"state its unit in the header, as in {first.column} or {first.key} [{first.unit}], or ",
        TakeColumn(header, first.column),
        "; to leave the column out, ",
        TakeColumn(header, "extra"),
    )


def _near(header: str) -> str:
    """Why a header that begins like a quantity was not taken as one; else nothing."""
    parts = plain(header).split()
    for count in range(min(len(parts) - 1, _MOST_PARTS), 0, -1):
        quantities, sure = _named(" ".join(parts[:count]))
        if quantities and sure:
            rest = " ".join(parts[count:])
            return f"it begins like {quantities[0].column}, but {rest!r} is not a unit of it"
    return ""
