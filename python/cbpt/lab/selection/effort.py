"""How far a search goes.

Effort  its limits
EFFORT  those of every diagnosis
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """How far the competition searches: more costs time and changes no rule."""

    replicates: int = 400
    """Sets of noise by which the chance of the largest gain is simulated."""
    variants: int = 3
    """Variants of an effect that are fitted in full."""
    singles: int = 6
    """Effects that are fitted alone, however improbable."""
    single_room: float = 15.0
    """Log odds below the best single effect within which all are."""
    variant_room: float = 5.0
    """Log odds below the best variant of an effect at which another one is fitted."""
    sets: int = 10
    """Pairs and triples of the linear search that are fitted in full, and sets far behind that are
    tried with the kind of noise of the best."""
    room: float = 6.0
    """Log odds below the best at which the linear search may see a set that is fitted."""
    curved_room: float = 10.0
    """The same where one of effects that need one another does not grow in proportion."""
    rounds: int = 4
    """Sets to which effects are added and from which they are taken; of large effects, sets from
    which they are only taken are extra. The noise of the best set is passed on as often."""
    additions: int = 3
    """Effects that are added to each of them."""
    most: int = 4
    """Effects of the largest set."""
    settled_room: float = 25.0
    """Log odds below the best within which a set is fitted again if a smaller one follows the
    readings better."""
    worse: float = 1.0
    """Log density by which it may."""
    modes_room: float = 10.0
    """Log odds below the best within which an effect is searched for other modes."""
    curved: int = 2
    """Sets of an effect that does not grow in proportion that are searched for other modes before
    effects are added to any."""
    large: int = 8
    """Of a torsion spring: the best single effects one of which is in every pair that is fitted at
    once, and the effects of the best sets that triples are made of."""
    at_once: int = 30
    """How many pairs, triples and sets of four of those are fitted in several forms, of each."""
    best: int = 2
    """How many of each are fitted in all forms."""


EFFORT = Effort()
