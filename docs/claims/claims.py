"""What the 2017 paper (DOI 10.1177/1687814017734112) says of its figures, held against this model.

Map:

- `claim`: what a claim is, and its verdict;
- `evidence`: the numbers behind the claims, each computed once;
- `claims_of_pairs`, `claims_of_drive`: one function a claim, or a few of one kind;
- `claims_of_reasons`: the reasons and the advice that the paper gives beside its figures;
- here: all of them, in the order of the paper's figures.

A verdict is computed from the numbers, never written down by hand.
"""

from __future__ import annotations

from functools import cache

import claims_of_drive as drive
import claims_of_pairs as pairs
import claims_of_reasons as reasons
from claim import Claim

__all__ = ["Claim", "claims"]


@cache
def claims() -> tuple[Claim, ...]:
    """All claims."""
    return (
        pairs.minimum_preload_deceleration(),
        pairs.minimum_preload_rings(),
        pairs.minimum_preload_slide(),
        pairs.equal_speed_governs(),
        pairs.larger_of_both(),
        *pairs.periods(),
        *pairs.deformation_at_minimum_preload(),
        pairs.angle_against_equal_speed_balls(),
        *pairs.ratio_of_equal_speed_pairs(),
        *pairs.amplitude_against_equal_speed_balls(),
        pairs.rings_stiffer(),
        pairs.inside_softer(),
        pairs.deformation_against_equal_speed_balls(),
        *pairs.angle_against_deceleration_balls(),
        pairs.stiffness_against_short_amplitude(),
        *drive.amplitude_of_drive(),
        *drive.influence_of_short_amplitude(),
        reasons.imbalance(),
        *drive.influence_of_preload(),
        reasons.predeformation_against_preload(),
        reasons.wear_against_preload(),
        *drive.influence_of_rolling_circle(),
        reasons.arm_against_rolling_circle(),
        *drive.influence_of_contact_angle(),
        reasons.predeformation_against_contact_angle(),
        reasons.wear_against_contact_angle(),
        *drive.influence_of_torque(),
        *reasons.forces_against_torque(),
        *drive.influence_of_ball_number(),
        reasons.angle_of_the_test_bar(),
        reasons.reversal_without_load(),
        *drive.prototype(),
    )
