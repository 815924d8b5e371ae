"""Whether friction goes on from run to run, or starts anew at each: what the readings say.

    with_its_history    the campaign with the history that its readings follow better
    with_their_history  the same of campaigns on one rig, each with its own past
    notes_of_levels     their notes, with the levels that they are of

Where a run begins as the one before it ended, a real reducer keeps the friction that this has left
(loops that were cut into runs), unless it was released, reassembled or stood for long in between.
The clocks of the runs should say which: one that starts again says that the reducer was at rest.
Many rigs start a clock with each file all the same, and others release the reducer and let the
clock go on. So where the two differ, friction is fitted both ways; of a torsion spring beside play
and a stiffness that bends, which are as large as its loops: friction alone would take them for a
start of its own. Where somebody names what is fitted, a stiffness that bends, or ends at a stop, is
asked beside it if it is named. Of a spring it is asked as well what was done before the first
reading: nothing, the same loop, or loops from which the torque came down or up to it. A ball drive
turns little, so little of its loop is a first loading, and the question is not worth its time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from cbpt.lab.model.dataset import Campaign, History
from cbpt.lab.model.forward import Assembled
from cbpt.lab.selection.friction_fits import FRICTION_EFFECT, evidence_of, friction_fits
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.turning import Turned, with_their_turns
from cbpt.lab.wording.numbers import listed

_HISTORIES: tuple[History, ...] = "released", "carried", "carried_from_above", "carried_from_below"
_RELEASED, _CARRIED, _FROM_ABOVE, _FROM_BELOW = (
    f'The case of the fit says so to cbpt compare: friction_between_runs = "{word}" under '
    "[measurement]"
    for word in _HISTORIES
)
_NOTES = {
    "released": "runs begin where the ones before them ended, but the readings show friction that "
    f"starts anew at each run: it faded or was released in between. {_RELEASED}",
    "carried": "the readings show friction that goes on from run to run, though time_s does not. "
    f"{_CARRIED}",
    "repeated": "the readings show that the first loops begin with friction of loops before them, "
    "which were not measured: they are fitted as if the same loop had been run before. "
    f"{_CARRIED}",
    "carried_from_above": "the readings show that a run that no other leads to, as the first, "
    "begins with friction of loops before it, which were not measured and from which the torque "
    f"came down to its first reading. {_FROM_ABOVE}",
    "carried_from_below": "the readings show that a run that no other leads to, as the first, "
    "begins with friction of loops before it, which were not measured and from which the torque "
    f"came up to its first reading. {_FROM_BELOW}",
}
_THOUGH = "friction goes on from run to run, though time_s does not, and "


def with_its_history(
    campaign: Campaign, named: Sequence[str] | None = None
) -> tuple[Campaign, list[str]]:
    """The campaign, and notes where it is not as its clocks say, or its torque turned back between
    readings. named: effects that are fitted; None where they are searched."""
    [found], [notes] = with_their_history([campaign], named)
    return found, notes


def with_their_history(
    campaigns: Sequence[Campaign], named: Sequence[str] | None = None
) -> tuple[list[Campaign], list[list[str]]]:
    """The campaigns, and of each the notes as above.

    All have the history that they follow best together, as readings of one campaign may hardly tell
    and are then not to differ from the others by it; but for those whose readings tell another one:
    each begins after a past of its own. Where their torques turned back is asked first.
    """
    friction = named is None or FRICTION_EFFECT in named
    turned = with_their_turns(campaigns, partial(friction_fits, named=named), friction)
    known = [_histories(one, named) for one in turned]
    together: dict[History, float] = {
        history: sum(odds[history][0] for odds in known) for history in known[0]
    }
    best = _clearly_best(together, next(iter(together)))
    found, notes = list[Campaign](), list[list[str]]()
    for one, odds in zip(turned, known, strict=True):
        history = _clearly_best({name: gained for name, (gained, _) in odds.items()}, best)
        note = odds[history][1]
        found.append(replace(one.campaign, history=history) if note else one.campaign)
        notes.append([told for told in (one.note, note) if told])
    return found, notes


def notes_of_levels(names: Sequence[str], notes: Sequence[Sequence[str]]) -> list[str]:
    """The notes of all levels, each once, with the levels that it is of where it is not of all."""
    told = []
    for note in dict.fromkeys(note for of_level in notes for note in of_level):
        of, not_of = (
            [name for name, own in zip(names, notes, strict=True) if (note in own) == has]
            for has in (True, False)
        )
        told.append(f"{listed(of)}, unlike {listed(not_of)}: {note}" if not_of else note)
    return told


def _histories(turned: Turned, named: Sequence[str] | None) -> dict[History, tuple[float, str]]:
    """The log evidence of each history over that of the clocks, and what it says beside them; the
    usual one first."""
    campaign = turned.campaign
    found: dict[History, tuple[float, str]] = {campaign.history: (0.0, "")}
    if campaign.history != "by_clock":
        return found  # somebody knows, and the case says it
    others = {history: replace(campaign, history=history) for history in _HISTORIES}
    notes = {history: _what_differs(other, campaign) for history, other in others.items()}
    unlike = [history for history, note in notes.items() if note]
    asked = [campaign, *(others[history] for history in unlike)] if unlike else []
    fits = friction_fits(asked, named, turned.friction) if unlike else []
    for history, note in notes.items():
        gained = 0.0
        # Where not even the usual one has a solution, nothing is gained.
        if note and fits[0]:
            of_history = fits[1 + unlike.index(history)]
            gained = evidence_of(of_history) - evidence_of(fits[0])
        found[history] = gained, note
    return found


def _clearly_best(odds: dict[History, float], usual: History) -> History:
    """The most probable history; the usual one unless the odds against it are those of a rival."""
    best = max(odds, key=lambda name: odds[name])
    return best if odds[best] - odds[usual] >= RULES.log_rival_odds else usual


def _what_differs(other: Campaign, timed: Campaign) -> str:
    """What runs do that they do not as their clocks say; empty where they do the same."""
    here, there = (Assembled(campaign, ()) for campaign in (other, timed))
    past = here.runs_with_unmeasured_past if other.drive.kind == "torsion_spring" else 0
    goes_on_otherwise = here.runs_that_go_on != there.runs_that_go_on
    if other.history in ("released", "carried"):
        if goes_on_otherwise:
            return _NOTES[other.history]
        return _NOTES["repeated"] if past else ""
    return _THOUGH * goes_on_otherwise + _NOTES[other.history] if past else ""
