"""What a plan could see and tell apart, as data: one effect, two effects, all of them.

Seen               one effect: the smallest size that would be told
Pair               two effects: whether and from which sizes they would be told apart
IsolabilityData    all of them
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.experiment.effect_changes import Form
from cbpt.lab.experiment.plan import Plan
from cbpt.lab.experiment.simulate import Instrument

Floats = NDArray[np.float64]

CHANCES = {"even": (0.5, 0.0), "sure": (0.95, 1.6448536269514722)}
"""How often an effect of the size is told, and the normal quantile of that."""


@dataclass(frozen=True, eq=False)
class Seen:
    """One effect as a plan would show it."""

    effect: str
    form: Form = field(repr=False)
    """The form that is seen soonest."""
    d: Floats
    """How far it stands out at the sizes of the form; NaN where the model has no solution."""
    left: Floats = field(repr=False)
    smallest: Mapping[str, float | None]
    """Smallest size (SI, off neutral) that is told with each of `CHANCES`."""
    why_not: str = ""

    @property
    def label(self) -> str:
        """Effect and form."""
        return self.form.variant.effect if self.form.variant.spread else self.form.variant.label

    def values(self, chance: str = "even") -> dict[str, float] | None:
        """Parameters at the smallest size, SI."""
        size = self.smallest[chance]
        return None if size is None else self.form.values(size)


@dataclass(frozen=True)
class Pair:
    """Two effects as a plan would show them.

    verdict: `apart` as soon as they are seen; `above` certain sizes; `not_here` within their
    plausible ranges; `twins`, which no reading of this rig tells apart.
    """

    effects: tuple[str, str]
    correlation: float
    """The largest there is once everything is refitted, each at the smallest size seen."""
    verdict: str
    above: tuple[float | None, float | None]
    """Size of each (SI, off neutral) from which it is told from the other in an even chance,
    whatever the shape of the form that is seen soonest."""
    decided_by: tuple[str, ...] = ()
    """Numbers of `[uncertainty]` that tell twins apart, as far as they can be told."""


@dataclass(frozen=True, eq=False)
class IsolabilityData:
    """What a campaign could see."""

    plan: Plan
    noise: Instrument
    seen: tuple[Seen, ...]
    unseen: Mapping[str, str]
    """Effects that the plan cannot show at all, each with the reason."""
    pairs: tuple[Pair, ...]
    priors: Mapping[str, float]

    def effect(self, effect: str) -> Seen:
        """One of those seen."""
        return next(s for s in self.seen if s.effect == effect)

    def pair(self, one: str, other: str) -> Pair:
        """Two of those seen, in either order."""
        return next(p for p in self.pairs if set(p.effects) == {one, other})

    def looks_most_like(self, effect: str) -> tuple[str | None, float | None]:
        """The other effect that it correlates most with, and by how much."""
        own = [p for p in self.pairs if effect in p.effects]
        if not own:
            return None, None
        most = max(own, key=lambda p: p.correlation)
        return next(e for e in most.effects if e != effect), most.correlation

    def groups(self) -> list[list[str]]:
        """Effects that this campaign cannot tell apart, twins among them."""
        group = {s.effect: {s.effect} for s in self.seen}
        for pair in self.pairs:
            if pair.verdict in ("not_here", "twins") and set(pair.effects) <= set(group):
                one, other = (group[e] for e in pair.effects)
                one |= other
                for effect in one:
                    group[effect] = one
        distinct = {id(g): sorted(g) for g in group.values() if len(g) > 1}
        return sorted(distinct.values())
