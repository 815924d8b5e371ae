"""The thresholds by which posterior odds become words.

DecisionRules  all of them, frozen
RULES          those in force
"""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["RULES", "DecisionRules"]


@dataclass(frozen=True)
class DecisionRules:
    """Thresholds of the decision; odds are ratios, log odds natural logarithms."""

    certain: float = 0.95
    """Probability from which an effect, or that of one of a group, is certain."""
    likely: float = 0.05
    """Probability from which an effect is told at all."""
    together: float = 0.2
    """Largest probability that two or more effects of a group of rivals are at work."""
    open: int = 8
    """Effects, the most probable ones, among which groups of rivals are looked for."""
    undecided: float = 0.5
    """Probability below which an answer is none."""
    readings_per_number: float = 3.0
    """Readings for each free number of an answer, below which it is none."""
    left_chance: float = 0.001
    """Chance of noise leaving as much as an answer does, below which something remains."""
    rival_odds: float = 20.0
    """Odds: a set of effects this much less likely than the best is no rival."""
    unknown_odds: float = 1.5
    """Odds: a lack of fit without a name this much less likely than the best set is no rival. Less
    than `rival_odds`, because its evidence is that of its best amplitude."""
    weak_odds: float = 3.0
    """Odds against no effect from which an effect is named although `rival_odds` is not reached,
    where its chance is below `weak_chance`."""
    weak_chance: float = 0.01
    """Largest chance, by simulation, of an effect named at `weak_odds`."""
    largest_chance: float = 0.02
    """Largest chance, by simulation, of an effect that is called found."""
    unknown_by_chance: float = 2.0
    """Log odds that the best lack of fit without a name gains in noise alone; it has to be ahead by
    this beside `rival_odds` to be the answer."""
    unknown_over_departed: float = 0.0
    """Log odds by which a lack of fit without a name has to be ahead of an effect that departs far
    from its equation, to be the answer."""
    unknown_over_offsets: float = 1.0
    """Log odds by which a lack of fit without a name has to be ahead of sets of run offsets alone,
    for an effect to be asked for."""
    departure_share: float = 0.06
    """Share of the log odds of the named effects that a lack of fit beside them may have and still
    be called a departure from their equations."""
    effect_price: float = 5.0
    """Log odds that a further effect pays by its prior; given back before that share is taken."""
    strain: float = 8.0
    """Log likelihood that scatter beyond that of the readings may cost before a set explains them
    poorly."""
    kin: tuple[tuple[str, str], ...] = (
        ("eccentric_bearing", "output_torsion"),
        ("eccentricity_error", "run_offset"),
    )
    """Pairs of effects that differ only in a shape that real parts do not keep exactly: a shaft
    joint that stiffens by a tenth reads like the exponent of a bearing; where each run has its own
    angle, runout is an offset of each run."""
    kin_reach: float = 3.0
    """Log odds further than `rival_odds` at which a set is still a rival of its kin."""
    moved_sigma: float = 2.0
    """Standard uncertainties: a number of drive or rig that moves further is a finding of its
    own."""
    moved_slack: float = 0.25
    """Standard uncertainties by which the readings leave such a shift open."""
    shared_sigma: float = 2.5
    """Standard uncertainties: largest shift of a number that explains the readings alone."""
    told_sigma: float = 0.3
    """Standard uncertainties: smaller shifts are not listed among what an answer rests on."""
    loose_calibration: float = 3.0
    """Calibrations known worse than this many times the default share a shift with the drive."""
    nominal_chance: float = 0.003
    """Largest chance at which the stated numbers count as rejected."""
    decided_within: float = 6.0
    """Log likelihood within which another answer is as good on the readings alone."""
    as_well: float = 6.0
    """Squared whitened misfit by which named effects may follow the readings worse than a lack of
    fit and still say as much."""
    far_reading: float = 2.0
    """Inflation factor from which a reading counts as an outlier."""
    largest_inflation: float = 2.5
    """Inflation factor that the farthest reading of outliers exceeds."""
    outlier_share: float = 0.05
    """Largest share of readings that are outliers; more make heavy tails."""
    misstated_sigma: float = 3.5
    """Standard deviations of the logarithm of the scale from which what is stated is wrong."""
    misstated_log: float = 0.1
    """Least logarithm of the scale at which it is."""

    @property
    def log_rival_odds(self) -> float:
        """Log odds within which nothing is excluded."""
        return math.log(self.rival_odds)


RULES = DecisionRules()
