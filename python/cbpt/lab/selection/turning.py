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

import numpy as np

from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.selection.rules import RULES


def with_their_turns(
    campaigns: Sequence[Campaign], log_evidence: Callable[[Campaign], float]
) -> tuple[list[Campaign], list[str]]:
    """All as they are most probable together, but for those whose readings tell otherwise; a note
    of each, empty where nothing turned back between readings.

    log_evidence: of friction, given a campaign.
    """
    turns = [Assembled(campaign, ()).turns_between_readings for campaign in campaigns]
    gained = [
        _gained(campaign, log_evidence) if count else 0.0
        for campaign, count in zip(campaigns, turns, strict=True)
    ]
    together = sum(gained) >= RULES.log_rival_odds
    found, notes = list[Campaign](), list[str]()
    for campaign, count, own in zip(campaigns, turns, gained, strict=True):
        clear = abs(own) >= RULES.log_rival_odds
        at_readings = count > 0 and (own > 0 if clear else together)
        found.append(replace(campaign, turns_at_readings=True) if at_readings else campaign)
        notes.append(_note(campaign, count, at_readings) if count else "")
    return found, notes


def _gained(campaign: Campaign, log_evidence: Callable[[Campaign], float]) -> float:
    """Log evidence of turns at readings over that of turns between them."""
    at_readings = replace(campaign, turns_at_readings=True)
    gained = log_evidence(at_readings) - log_evidence(campaign)
    return 0.0 if np.isnan(gained) else gained


def _note(campaign: Campaign, count: int, at_readings: bool) -> str:
    times = "once" if count == 1 else f"{count} times"
    if at_readings:
        return (
            f"the ramps of the torque meet between readings ({times}), but the readings show "
            "friction that turned back at them. The case of the fit says so to cbpt compare: "
            'torque_turns = "at_readings" under [measurement]'
        )
    means = (
        "; as the readings there show, each is taken as a mean over the time from halfway to the "
        "one before to halfway to the next"
        if Assembled(campaign, ()).readings_are_means
        else ""
    )
    return (
        f"the torque turned back between readings ({times}): the model turns back where the ramps "
        f"on both sides meet{means}. For a torque that was set and held at each reading state "
        'torque_turns = "at_readings" under [measurement]'
    )
