"""How fast the load went.

rates_check   the rates of the loops against each other
"""

from __future__ import annotations

from dataclasses import dataclass

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.reader import Readings
from cbpt.lab.wording.numbers import rounded


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    rates: float = 1.5
    """Ratio of the quickest rate to the slowest."""


_LIMITS = _Limits()


def rates_check(r: Readings, loops: list[Loop]) -> Check:
    if r.time_s is None:
        remedy = "Record the time of each reading: drift, creep and the rate need it."
        return Check("rates", "lost", "no time in the table", remedy)
    rates = [loop.rate_Nm_per_s for loop in loops if loop.rate_Nm_per_s]
    if not rates:
        return Check("rates", "good", "no loop with a rate")
    words = f"{rounded(min(rates))} to {rounded(max(rates))} N m/s"
    if max(rates) > _LIMITS.rates * min(rates):
        remedy = "Load at one rate: friction of reducers depends on it."
        return Check("rates", "look", words, remedy)
    return Check("rates", "good", words)
