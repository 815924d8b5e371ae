"""Whether friction goes on from run to run, or starts anew at each: what the readings say.

    with_its_history    the campaign with the history that its readings follow better
    with_their_history  the same of campaigns on one rig, together

Where a run begins as the one before it ended, a real reducer keeps the friction that this has left
(loops that were cut into runs), unless it was released, reassembled or stood for long in between.
The clocks of the runs should say which: one that starts again says that the reducer was at rest.
Many rigs start a clock with each file all the same, and others release the reducer and let the
clock go on. So where the two differ, friction is fitted both ways; of a torsion spring beside play,
which is as large as its loops: friction alone would take it for a start of its own. There a single
loop is asked as well whether it was the first one: a ball drive turns little, so little of its loop
is a first loading, and the question is not worth its time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cbpt.errors import InvalidInputError
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign, History
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_loops import FRICTION, PLAY
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.selection.fit_effects import fits_of_forms
from cbpt.lab.selection.rules import RULES

_FRICTION, _PLAY = (name.partition(".")[0] for name in (FRICTION, PLAY))
_NOTES = {
    "anew": "runs begin where the ones before them ended, but the readings show friction that "
    "starts anew at each run: it faded or was released in between. For cbpt compare to take it so, "
    "let time_s begin at 0 in each run",
    "carried": "the readings show friction that goes on from run to run, though time_s does not. "
    "For cbpt compare to take it so, let time_s go on from run to run",
    "repeated": "the readings show that the first loops begin with friction of loops before them, "
    "which were not measured: they are fitted as if the same loop had been run before. "
    "cbpt compare takes them as loaded from rest",
}


def with_its_history(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """The campaign, and a note where it is not as its clocks say."""
    [found], notes = with_their_history([campaign])
    return found, notes


def with_their_history(campaigns: Sequence[Campaign]) -> tuple[list[Campaign], list[str]]:
    """The campaigns, all with one history or as their clocks say, and a note as above."""
    timed, found = [*campaigns], [*campaigns]
    known: dict[int, float] = {}
    """Log evidence of campaigns as their clocks say, by their places."""
    gained_most, notes = RULES.log_rival_odds, list[str]()
    histories: tuple[History, ...] = "anew", "carried"
    for history in histories:
        other = [replace(campaign, history=history) for campaign in timed]
        pairs = enumerate(zip(other, timed, strict=True))
        told = {place: note for place, pair in pairs if (note := _what_differs(*pair))}
        for place in told.keys() - known.keys():
            known[place] = _log_evidence(timed[place])
        gained = sum(_log_evidence(other[place]) - known[place] for place in told)
        if told and gained >= gained_most:
            gained_most, found, notes = gained, other, [*dict.fromkeys(told.values())]
    return found, notes


def _what_differs(other: Campaign, timed: Campaign) -> str:
    """What runs do that they do not as their clocks say; empty where they do the same."""
    here, there = (Assembled(campaign, ()) for campaign in (other, timed))
    if here.runs_that_go_on != there.runs_that_go_on:
        return _NOTES[other.history]
    spring = other.drive.kind == "torsion_spring"
    return _NOTES["repeated"] if spring and here.runs_repeated_before else ""


def _log_evidence(campaign: Campaign) -> float:
    """Of friction in its best form, of a torsion spring beside play."""
    effects = [_FRICTION, _PLAY] if campaign.drive.kind == "torsion_spring" else [_FRICTION]
    fitter = Fitter(campaign, [v for v in library_of(campaign, ()) if v.effect in effects])
    try:
        fits = fits_of_forms(fitter, effects)
    except InvalidInputError:
        return -np.inf
    return max(fit.log_evidence for fit in fits.values())
