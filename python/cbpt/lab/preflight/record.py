"""What preflight finds, as records.

Check   one subject: good, or another look, or lost
Blind   effects that a table cannot show
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

State = Literal["good", "look", "lost"]


@dataclass(frozen=True)
class Check:
    """One subject. state: good; look: another look is due; lost: something cannot be told."""

    subject: str
    state: State
    finding: str
    remedy: str = ""


@dataclass(frozen=True)
class Blind:
    """Effects that the table cannot show."""

    effects: tuple[str, ...]
    why: str
    remedy: str
