"""Whether a torque turned back between its readings or at them: what the readings say.

    Turned             a campaign with the turns that its readings follow better
    with_their_turns   of campaigns on one rig

Ramps that a logger with a clock has read meet between readings (`predict/turns.rs`). That may not
be where the torque turned back: it was set and held, the controller rounds its corners, or somebody
simulated from reading to reading. Where every turn meets the clock alike, as in loops of one length
and in a list of torques that are set, the torques themselves do not say which it was. So where the
ramps of a table meet between readings, friction is fitted both ways, as for its history
(`history`), unless the case says what they did.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.selection.fit_effects import Fits
from cbpt.lab.selection.friction_fits import evidence_of
from cbpt.lab.selection.rules import RULES

FrictionOf = Callable[[Sequence[Campaign]], list[Fits]]
"""Fits of friction in each of some campaigns; empty where the model has no solution."""


@dataclass(frozen=True, eq=False)
class _Asked:
    """A campaign whose ramps meet between readings."""

    between: Campaign
    """With turns where the ramps meet."""
    at_readings: Campaign
    alike: bool
    """Whether all meet the clock alike."""

    @classmethod
    def of(cls, campaign: Campaign, friction: bool) -> _Asked | None:
        """None where the case says, or no ramps meet between readings; or all in the same place,
        and friction, which would tell, is not fitted."""
        if campaign.torque_turns != "where_ramps_meet":
            return None
        meeting = replace(campaign, torque_turns="between_readings")
        at_readings = replace(campaign, torque_turns="at_readings")
        if Assembled(campaign, ()).turns_between_readings:
            return cls(campaign, at_readings, alike=False)
        if friction and Assembled(meeting, ()).turns_between_readings:
            return cls(meeting, campaign, alike=True)
        return None

    def said(self, gained: Sequence[float], usual: float) -> tuple[Campaign, str]:
        """The campaign with the turns that the first clear gain speaks for, else the usual ones;
        and a note, unless all is as usual."""
        clear = next((g for g in gained if abs(g) >= RULES.log_rival_odds), 0.0)
        if (clear or usual) < 0:
            return self.between, _between(self.between, self.alike and clear < 0)
        if self.alike:
            return self.at_readings, "" if clear else _OPEN
        return self.at_readings, _AT_READINGS


@dataclass(frozen=True, eq=False)
class Turned:
    """A campaign with the turns that its readings follow better."""

    campaign: Campaign
    note: str = ""
    """Empty where nothing turned back between readings."""
    friction: Fits | None = None
    """Fits of friction with these turns; None where they were not asked."""


def with_their_turns(
    campaigns: Sequence[Campaign], friction_of: FrictionOf, friction: bool = True
) -> list[Turned]:
    """Campaigns of one rig, all with turns between readings or all with turns at them, whichever is
    more probable; a campaign whose own readings clearly say otherwise goes by these. Where nothing
    is clear they turn back at the readings, unless turns of a table meet the clock in different
    places.

    friction: whether it is among what is fitted.
    """
    asked = [_Asked.of(campaign, friction) for campaign in campaigns]
    fits = side_by_side(campaigns[0], [partial(_fits, one, friction_of) for one in asked])
    # Where one of both has no solution nothing is told.
    gained = [
        evidence_of(at_readings) - evidence_of(between) if at_readings and between else 0.0
        for at_readings, between in fits
    ]
    together = float(sum(gained))
    # Where one table shows that a clock has logged it, the others of the rig were logged too.
    logged = any(
        one and not one.alike and own < RULES.log_rival_odds
        for one, own in zip(asked, gained, strict=True)
    )
    usual = -1.0 if logged else 1.0
    found = []
    for campaign, one, own, (at_readings, between) in zip(
        campaigns, asked, gained, fits, strict=True
    ):
        if one is None:
            found.append(Turned(campaign))
            continue
        chosen, note = one.said((own, together), usual)
        found.append(Turned(chosen, note, between if chosen is one.between else at_readings))
    return found


def _fits(one: _Asked | None, friction_of: FrictionOf) -> tuple[Fits, Fits]:
    """With turns at the readings, and between them."""
    if one is None:
        return {}, {}
    at_readings, between = friction_of([one.at_readings, one.between])
    return at_readings, between


_AT_READINGS = (
    "the ramps of the torque meet between readings, but friction follows the readings better if "
    "the torque reversed at them, as it does where each torque is set and held. The case file that "
    'cbpt fit writes has torque_turns = "at_readings" under [measurement], so that cbpt compare '
    "does the same"
)
_OPEN = (
    "the ramps of the torque meet between readings, each time at the same share of the time from "
    "one to the next, so torques that were set look the same as ramps that a clock logged. The "
    "angles do not tell them apart either, so the model reverses at the readings. If a clock "
    'logged the ramps, state torque_turns = "between_readings" under [measurement] in the case'
)


def _between(campaign: Campaign, followed: bool) -> str:
    means = (
        ". The readings nearest to the reversals show that all readings are means over time, each "
        "from halfway to the reading before to halfway to the reading after"
        if Assembled(campaign, ()).readings_are_means
        else ""
    )
    because = (
        ". Friction follows the readings better then; the case file that cbpt fit writes has "
        'torque_turns = "between_readings" under [measurement], so that cbpt compare does the same'
        if followed
        else ""
    )
    return (
        "the torque reversed between readings: the model reverses where the straight ramps before "
        f"and after meet{means}{because}. If each torque was set and held instead, state "
        'torque_turns = "at_readings" under [measurement] in the case'
    )
