"""What changed, as a record.

Changed      one parameter that changed, before and after
Unchanged    one that all levels share
ByItself     one as each level has it by itself
ChangeData   the verdict with everything that it rests on
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, Literal

from cbpt.lab.change.loop_widths import LoopWidths
from cbpt.lab.change.noise import NoiseChange
from cbpt.lab.change.odd_level import OddLevel
from cbpt.lab.change.posterior import Weighed
from cbpt.lab.readings.readings import Readings
from cbpt.lab.selection.rules import RULES

_AS_SURE = 1 / 3
"""Of the largest difference in standard uncertainties: less beside it is not told of an effect."""

Kind = Literal["changed", "nothing", "undecided"]
Direction = Literal["up", "down", "new", "gone"]
Limit = Literal["lower", "upper", "own loops"]


@dataclass(frozen=True)
class Changed:
    """One parameter; values SI. before, after: of the first and the last level."""

    effect: str
    parameter: str
    unit: str
    before: float
    after: float
    u_before: float | None
    """Standard uncertainty; None where the value ends at a limit of its range."""
    u_after: float | None
    direction: Direction
    probability: float
    """That the effect, or the number, changed."""
    values: tuple[float, ...]
    """At every level."""
    u: tuple[float | None, ...]
    limits: tuple[Limit | None, ...]
    """Whether the value ends at a limit of its range, and may be lower or higher, or is held there
    by the level's own small loops."""
    trend: Literal["rising", "falling", "neither"] | None
    """Of more than two levels: whether the values rise or fall from the first to the last, and
    never go the other way, by more than twice their uncertainty."""
    rivals: tuple[str, ...] = ()
    """Others of which one may have changed in its place: the readings do not tell which."""
    along: str | None = None
    """Of a friction that changed by the same share as a stiffness, in one event: that."""
    apart: float = 0.0
    """The most by which two values differ, in standard uncertainties of that difference: less than
    by those of the values, where a number that all levels share makes them uncertain together."""
    is_shape: bool = False
    """Whether it says how an effect looks, and not how large it is."""

    @property
    def moved(self) -> bool:
        """Whether any two values differ by more than twice their uncertainty."""
        if self.apart > 2:
            return True
        known = list(zip(self.values, self.u, strict=True))
        return any(
            abs(a - b) > 2 * math.hypot(u_a or 0.0, u_b or 0.0)
            for (a, u_a), (b, u_b) in combinations(known, 2)
        )


@dataclass(frozen=True)
class Unchanged:
    """One size or number that the levels share."""

    effect: str
    parameter: str
    unit: str
    value: float
    u: float
    """Standard uncertainty, SI."""
    within: float
    """By how much its values may differ from level to level, root mean square, SI: what they differ
    by and the uncertainty of that, if each level has its own."""


@dataclass(frozen=True)
class ByItself:
    """One size as each level has it if nothing is shared; SI."""

    effect: str
    parameter: str
    unit: str
    values: tuple[float, ...]
    u: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class ChangeData:
    """What changed between levels, and what did not."""

    kind: Kind
    changed: tuple[Changed, ...]
    unchanged: tuple[Unchanged, ...]
    """Both empty where the kind is `undecided`, but for numbers that are not in `not_shown`; the
    latter also where the effects leave more than noise."""
    probability: float
    """That something changed; for `nothing`, that nothing did. By the effects that were fitted:
    where the measured loops say otherwise (`differing_loops`), the kind is `undecided`."""
    noise: NoiseChange
    remains: dict[str, Any] | None
    """What is left after the most probable combination of the level where most is left; None where
    that is noise, or where the effects were given and nothing was diagnosed."""
    levels: tuple[str, ...]
    readings: tuple[Readings, ...] = field(repr=False)
    rmse_arcsec: tuple[float, ...]
    not_followed_arcsec: float
    """What the fitted effects leave of the readings of a level, rms, where it comes again in runs
    that repeat each other and so is no noise: the most of all levels; else 0."""
    moves_arcsec: Mapping[str, float]
    """Of what may have changed: by how much levels differ by it beyond what other numbers make up
    for, standard deviation of the fitted angles; infinite where the model has no solution without
    it, or the loops of one level exclude by far what another one has."""
    told_from_arcsec: float
    """From which of these on a change of one effect is told: how much of what the effects leave
    differs between levels."""
    hidden: tuple[str, ...]
    """Of that: what moves the angles by less, and, where that is no noise, effects of which no
    number moved by more than twice its uncertainty; and what runs of one level do not agree on."""
    on_large_loops: tuple[str, ...]
    """Of these: a play wider than what small loops turn that friction holds; it rests on the large
    loops alone."""
    runs_differ: tuple[str, ...]
    """Of these: what runs of one level with the same torques do not agree on."""
    effects: tuple[str, ...]
    """Fitted at every level."""
    by: str | None
    weighed: Weighed = field(repr=False)
    by_itself: tuple[ByItself, ...] = ()
    loops: tuple[LoopWidths, ...] = ()
    """The loops as they were measured, by amplitude."""
    not_shown: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Effects and numbers that some level determines, with the levels that do not: whether they
    changed there cannot be told."""
    odd_level: OddLevel | None = None
    """The level that holds something that its own fit does not follow, and another has not."""
    rests_differ_arcsec: float | None = None
    """By how much what the effects leave differs from level to level in runs with the same torques,
    where they follow no change and it is another law there, or of another size; None where they do,
    where it is much alike, or where the rig is stated or measured not to come back to its state."""
    unlike_design: str = ""
    """What else than a change may make the levels differ by how they were measured, in words."""
    notes: tuple[str, ...] = ()
    reproducibility_arcsec: float | None = None
    """By which the rig differs when it is set up again; None where nothing was stated."""
    levels_differ_by_arcsec: float | None = None
    """Where something changed by the fitted effects: standard deviation by which the fitted curves
    of the levels differ. A rig that comes back to its state no better would explain it."""

    @property
    def foremost(self) -> tuple[Changed, ...]:
        """One number of each effect that changed: the first of its sizes that moved about as surely
        as any other, else the first number that moved."""
        return tuple(self.told_of(e)[0] for e in dict.fromkeys(c.effect for c in self.changed))

    def told_of(self, effect: str) -> tuple[Changed, ...]:
        """The numbers by which an effect that changed is told: sizes that moved, but for those that
        moved far less surely than another; else one number."""
        own = [c for c in self.changed if c.effect == effect]
        moved = [c for c in own if c.moved]
        sizes = [c for c in moved if not c.is_shape]
        surest = max((c.apart for c in sizes), default=0.0)
        return tuple(c for c in sizes if c.apart >= _AS_SURE * surest) or tuple((moved or own)[:1])

    @property
    def rivals(self) -> tuple[tuple[str, ...], ...]:
        """Groups of which one changed, and the readings do not tell which."""
        if self.kind != "changed":
            return ()
        return tuple(group for group in self.weighed.rivals if not set(group) <= set(self.hidden))

    @property
    def perhaps(self) -> dict[str, float]:
        """Effects and numbers that may have changed and are not told as changed, with the
        probability by the readings."""
        return {
            g.effect: chance
            for g in self.weighed.groups
            if RULES.likely <= (chance := self.weighed.changed(g.effect))
            and (chance < RULES.undecided or g.effect in self.hidden)
            and not any(g.effect in group for group in self.rivals)
            and not any(c.effect == g.effect for c in self.changed if c.along)
        }

    @property
    def nothing_shown(self) -> bool:
        """Of an undecided answer: whether nothing changed of what the model follows and all levels
        show."""
        return (
            self.kind == "undecided"
            and self.probability < RULES.undecided
            and (bool(self.not_shown) or self.beyond_the_model)
            and self.differing_loops is None
        )

    @property
    def beyond_the_model(self) -> bool:
        """Whether levels differ by what no fitted effect follows."""
        return self.odd_level is not None or self.rests_differ_arcsec is not None

    @property
    def moved_less_than_is_left(self) -> bool:
        """Of an undecided answer: whether something changed by the fitted effects that moves the
        angles by less than what these do not follow."""
        return self.kind == "undecided" and self.probability >= RULES.certain

    @property
    def differing_loops(self) -> LoopWidths | None:
        """Of an undecided answer: the loops that differ though the fitted effects say that nothing
        changed."""
        if self.kind != "undecided" or self.probability >= RULES.undecided:
            return None
        return next((widths for widths in self.loops if widths.may_differ), None)
