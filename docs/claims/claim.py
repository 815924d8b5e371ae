"""A claim of the paper, and its verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

HOLDS = "holds"
FAILS = "does not hold"


@dataclass(frozen=True)
class Claim:
    """A statement of the paper and what this model makes of it."""

    key: str
    figure: str
    """Figure of the paper."""
    says: str
    """The claim."""
    verdict: str
    """`holds`, `holds where ...` or `does not hold`."""
    why: str
    model: Mapping[str, float] = field(default_factory=dict)
    """Numbers of this model by what they are, with the unit."""
    paper: Mapping[str, float] = field(default_factory=dict)
    """Numbers of the paper, likewise."""


def verdict(evidence: object, where: str = "") -> str:
    """The verdict on evidence that was sought in the range that `where` names."""
    return (f"{HOLDS} where {where}" if where else HOLDS) if evidence else FAILS


def close(a: float, b: float, tolerance: float) -> bool:
    """Whether two numbers agree to a share of the second."""
    return abs(a - b) <= tolerance * abs(b)
