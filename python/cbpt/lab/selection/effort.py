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
    """Sets to which effects are added and from which they are taken, and how often the noise of the
    best is shared; of large effects those sets from which they are only taken come on top."""
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
    """Effects of a torsion spring: those alone of which one is in each pair that is fitted at once,
    and those of the best pairs of which three are."""
    at_once: int = 30
    """Pairs, triples and sets of four of those, each, that are fitted in more than one form."""
    best: int = 2
    """The same that are fitted in all of their forms."""


EFFORT = Effort()
