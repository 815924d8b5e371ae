"""Figures of loops as text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from cbpt.lab.characteristics.figures import ROUNDING
from cbpt.lab.wording import layout
from cbpt.lab.wording.numbers import rounded, with_uncertainty
from cbpt.results import ANGLE_UNITS

if TYPE_CHECKING:
    from cbpt.lab.characteristics.record import CharacteristicsData, Group
    from cbpt.lab.characteristics.uncertainty import Figure, LoopSet

__all__ = ["cell", "lines"]


def lines(found: CharacteristicsData, angle_unit: str) -> Iterator[str]:
    """The whole answer."""
    if found.source:
        yield f"{len(found.source)} readings of {found.source.source}"
        # How columns were read; what else is noted is of effects, and none is looked for here.
        yield from (f"Note: {n}" for n in map(str, found.source.notes) if n.startswith("read "))
    rated = rounded(found.convention.rated_torque_Nm, 4)
    yield f"Rated torque {rated} N m, {found.rated_torque_from}."
    everywhere = _of_every_setting(found)
    for group in found.groups:
        yield ""
        yield from _group(group, angle_unit)
        yield from (f"Warning: {w}" for w in group.warnings if w not in everywhere)
    if everywhere:
        yield ""
    yield from (f"Warning, at every setting: {warning}" for warning in everywhere)
    yield ""
    yield (
        "Conventions (a loop has two branches, one as the torque rises and one as it falls; the "
        "centre line lies midway between them):"
    )
    by_words: dict[str, list[str]] = {}
    for figure in found.groups[0].figures:
        by_words.setdefault(figure.convention, []).append(figure.name)
    yield from (f"- {', '.join(names)}: {words}" for words, names in by_words.items())


def _of_every_setting(found: CharacteristicsData) -> list[str]:
    """Warnings that all of several settings have, which are said once."""
    first, *others = found.groups
    return [w for w in first.warnings if others and all(w in group.warnings for group in others)]


def _loops(count: int, used: LoopSet) -> str:
    """How many loops there are, and which of them the figures are those of."""
    full, whole = len(used.full), sum(loop.whole for loop in used.full)
    said = f"{count} loops" if count > 1 else "1 loop"
    if count == full == 1:
        both = "with both branches" if whole else "with one branch"
        return f"{said} to {rounded(used.amplitude_Nm)} N m, {both}"
    those = "the one" if full == 1 else f"the {full}"
    both = f"; {whole} of them have both branches"
    if whole == full:
        those, both = f"{those} with both branches and", ""
    else:
        those += " with"
    return (
        f"{said}; the figures are those of {those} the largest torque, "
        f"{rounded(used.amplitude_Nm)} N m{both}"
    )


def _group(group: Group, angle_unit: str) -> Iterator[str]:
    if group.setting:
        yield f"{group.setting}:"
    if group.loops:
        yield _loops(group.count, group.loops)
    ratios = {name: f"{' +- '.join(with_uncertainty(v, u))}" for name, v, u in group.ratios()}
    both = bool(group.readings and group.model)
    head = ["figure", "unit", "readings" if group.readings else "model"]
    rows = []
    for i, figure in enumerate(group.figures):
        unit = angle_unit if figure.unit == "arcsec" else figure.unit
        row = [figure.name, unit, cell(figure, angle_unit)]
        if both:
            row += [cell(group.model[i], angle_unit), ratios.get(figure.name, "")]
        rows.append(row)
    yield layout.table([*head, "model", "readings/model"] if both else head, rows)
    for kind, figures in (("readings", group.readings), ("model", group.model)):
        reasons: dict[str, list[str]] = {}
        for figure in figures:
            if figure.reason:
                reasons.setdefault(figure.reason, []).append(figure.name)
        for reason, names in reasons.items():
            yield f"No {', '.join(names)} of the {kind}: {reason}."


def cell(figure: Figure, angle_unit: str = "arcsec") -> str:
    """Value and standard uncertainty, or a dash."""
    if figure.value is None:
        return "-"
    factor = ANGLE_UNITS[angle_unit] if figure.unit == "arcsec" else 1.0
    value, u = figure.value * factor, (figure.u or 0.0) * factor
    if u <= ROUNDING * abs(value):
        return rounded(value, 4)
    return " +- ".join(with_uncertainty(value, u)) if value else f"0 +- {rounded(u, 2)}"
