"""What an effect of the rig is: a port, a size, other numbers, one or more forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from reference.rig.bench import Bench

Values = dict[str, float]
Act = Callable[[Bench, Values, str], None]
Draw = Callable[[np.random.Generator], Values]


@dataclass(frozen=True)
class Kind:
    """What is known of one effect: where it acts, which number is its size, in which range.

    neutral: the size at which it does nothing. draw: its other numbers, at random. needs: what a
    test plan must have for the effect to be seen at all.
    """

    id: str
    port: str
    size: str
    unit: str
    low: float
    high: float
    act: Act
    draw: Draw = lambda rng: {}
    forms: tuple[str, ...] = ("library",)
    neutral: float = 0.0
    signed: bool = False
    needs: str = ""


@dataclass(frozen=True)
class Hidden:
    """One effect in one form with its numbers."""

    kind: Kind
    values: Values
    form: str = "library"

    @property
    def id(self) -> str:
        """Its name."""
        return self.kind.id

    @property
    def port(self) -> str:
        """Where it acts."""
        return self.kind.port

    @property
    def size(self) -> float:
        """The number that says how strong it is."""
        return self.values[self.kind.size]

    def sized(self, size: float) -> Hidden:
        """The same effect, stronger or weaker."""
        return replace(self, values={**self.values, self.kind.size: size})

    def act(self, bench: Bench) -> None:
        """Change the bench; nothing at all at the neutral size."""
        if self.size != self.kind.neutral:
            self.kind.act(bench, self.values, self.form)


class Register(dict[str, Kind]):
    """Kinds by id, in the order in which they were added; form is what the first is called."""

    def __init__(self, form: str = "library") -> None:
        super().__init__()
        self.form = form

    def effect(
        self, port: str, size: str, unit: str, span: tuple[float, float], **rest: Any
    ) -> Callable[[Act], Act]:
        """Adds what a function does under its name; span: low and high, rest: as Kind has it."""

        def add(act: Act) -> Act:
            rest.setdefault("forms", (self.form,))
            name = act.__name__
            self[name] = Kind(name, port, size, unit, *span, act=act, **rest)
            return act

        return add


def draw_hidden(kind: Kind, form: str, rng: np.random.Generator) -> Hidden:
    """An effect with its other numbers at random and the size at the lower end of its range."""
    values = kind.draw(rng)
    sign = float(rng.choice([-1.0, 1.0])) if kind.signed else 1.0
    start = kind.neutral + sign * max(abs(kind.low), 1e-3 * abs(kind.high))
    return Hidden(kind, {**values, kind.size: start}, form)


def any_seed(rng: np.random.Generator) -> Values:
    """A seed of its own, for effects that are drawn ball by ball or run by run."""
    return {"seed": float(rng.integers(1, 2**31))}


def any_phase(rng: np.random.Generator) -> Values:
    """Any place round the turn."""
    return {"phase_rad": float(rng.uniform(0, 2 * np.pi))}
