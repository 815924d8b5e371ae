"""The thresholds by which a posterior becomes words.

DecisionRules  all of them, frozen
RULES          those in force
"""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["RULES", "DecisionRules"]


@dataclass(frozen=True)
class DecisionRules:
    """Thresholds of the decision."""

    certain: float = 0.95
    """Probability from which an effect, or that of one of a group, is certain."""
    likely: float = 0.05
    """Probability from which an effect is told at all."""
    together: float = 0.2
    """Largest probability that two or more effects of a group of rivals are at work."""
    undecided: float = 0.5
    """Probability below which an answer is none."""
    readings_per_number: float = 3.0
    """Readings for each free number of an answer, below which it is none."""
    left_chance: float = 0.001
    """Chance of noise leaving as much as an answer does, below which something remains."""
    moved_sigma: float = 2.25
    """Standard uncertainties: a number of drive or rig that moves further is a finding of its own
    (2, and the quarter that the readings leave open)."""
    loose_calibration: float = 5.0
    """Calibrations known worse than this many times the default share a shift with the drive; many
    a torque cell is stated to three times the default, and is no open question for it."""
    nominal_chance: float = 0.003
    """Largest chance at which the stated numbers count as rejected."""
    far_reading: float = 2.0
    """Inflation factor from which a reading counts as an outlier."""
    outlier_share: float = 0.05
    """Largest share of readings that are outliers; more make heavy tails."""
    misstated_sigma: float = 3.5
    """Standard deviations of the logarithm of the scale from which what is stated is wrong."""

    @property
    def log_rival_odds(self) -> float:
        """Log odds within which nothing is excluded: those of `certain`."""
        return math.log(self.certain / (1 - self.certain))


RULES = DecisionRules()
