"""Angles that were written down more often than the sensor gave a new one.

held_angle   a campaign with the first reading of each value, where nearly all come several times

A logger that is quicker than its sensor writes each angle several times. Those are one reading:
taken for several they agree far too well, and while the torque goes on they lag behind it like
friction. A spring that sticks keeps its angle too, but in a part of the loop alone; and of a coarse
display (`Campaign.step_arcsec`) readings are alike because they round alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.model.dataset import Campaign


@dataclass(frozen=True)
class _Limits:
    """What counts as a logger that is too quick."""

    share: float = 0.8
    """Of the readings, that are equal to one before or after them."""
    steps: float = 10.0
    """Steps of the display between readings that differ, as a rule; fewer may round alike."""


_LIMITS = _Limits()


def held_angle(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """The campaign, and a note where readings were left out."""
    order, run = campaign.rows.order, campaign.readings.run_index
    angle = campaign.readings.elastic_angle_arcsec[order]
    follows = np.diff(run[order]) == 0
    change = np.abs(np.diff(angle))
    same = follows & (change == 0)
    alike = np.concatenate([[False], same]) | np.concatenate([same, [False]])
    moves = change[follows & ~same]
    step = display_step(campaign.readings.elastic_angle_arcsec)
    if (
        campaign.step_arcsec
        or np.mean(alike) < _LIMITS.share
        or not moves.size
        or np.median(moves) < _LIMITS.steps * step
    ):
        return campaign, []
    first = np.zeros(len(angle), dtype=np.bool_)
    first[order] = np.concatenate([[True], ~same])
    note = (
        f"the angle stays the same for {len(angle) / np.count_nonzero(first):.2g} readings as a "
        f"rule, as of a sensor that is read more often than it measures: {np.count_nonzero(first)} "
        f"of {len(angle)} readings, the first of each value, are used"
    )
    return campaign.select(first), [note]
