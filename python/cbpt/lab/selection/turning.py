"""Whether a torque turned back between its readings or at them: what the readings say.

    with_their_turns   campaigns with the turns that their readings follow better, and their notes

Ramps that a logger with a clock has read meet between readings (`predict/turns.rs`). That may not
be where the torque turned back: it was set and held, the controller rounds its corners, or somebody
simulated from reading to reading. Where the table has such turns, friction is fitted both ways, as
for its history (`history`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.selection.rules import RULES


def with_their_turns(
    campaigns: Sequence[Campaign], log_evidence: Callable[[Campaign], float]
) -> tuple[list[Campaign], list[str]]:
    """Campaigns of one rig, all with turns between readings or all with turns at them, whichever is
    more probable; a campaign whose own readings clearly say otherwise goes by these. With a note of
    each, empty where nothing turned back between readings.

    log_evidence: of friction, given a campaign.
    """
    turns = [bool(Assembled(campaign, ()).turns_between_readings) for campaign in campaigns]
    works = [
        partial(_gained, campaign, log_evidence) if has else float
        for campaign, has in zip(campaigns, turns, strict=True)
    ]
    gained = side_by_side(campaigns[0], works)
    together = sum(gained) >= RULES.log_rival_odds
    found, notes = list[Campaign](), list[str]()
    for campaign, has, own in zip(campaigns, turns, gained, strict=True):
        clear = abs(own) >= RULES.log_rival_odds
        at_readings = has and (own > 0 if clear else together)
        found.append(replace(campaign, turns_at_readings=True) if at_readings else campaign)
        notes.append(_note(campaign, at_readings) if has else "")
    return found, notes


def _gained(campaign: Campaign, log_evidence: Callable[[Campaign], float]) -> float:
    """Log evidence of turns at readings over that of turns between them."""
    at_readings = replace(campaign, turns_at_readings=True)
    gained = log_evidence(at_readings) - log_evidence(campaign)
    # Where one of both has no solution nothing is told.
    return gained if np.isfinite(gained) else 0.0


def _note(campaign: Campaign, at_readings: bool) -> str:
    if at_readings:
        return (
            "the ramps of the torque meet between readings, but friction follows the readings "
            "better if the torque reversed at them, as it does where each torque is set and held. "
            'The case file that cbpt fit writes has torque_turns = "at_readings" under '
            "[measurement], so that cbpt compare does the same"
        )
    means = (
        ". The readings nearest to the reversals show that all readings are means over time, each "
        "from halfway to the reading before to halfway to the reading after"
        if Assembled(campaign, ()).readings_are_means
        else ""
    )
    return (
        "the torque reversed between readings: the model reverses where the straight ramps before "
        f"and after meet{means}. If each torque was set and held instead, state torque_turns = "
        '"at_readings" under [measurement] in the case'
    )
