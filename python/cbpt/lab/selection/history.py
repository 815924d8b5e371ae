"""Whether friction goes on from run to run, or starts anew at each: what the readings say.

    with_its_history  the campaign with that of the two which they follow better

Where a run begins as the one before it ended, a real reducer keeps the friction that this has left
(loops that were cut into runs), unless it was released, reassembled or stood for long in between.
No column says which. So where runs go on, friction alone is fitted both ways.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_loops import FRICTION
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.selection.linear_screen import Gain, Screen, Signatures, Stack
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.starts import places, start_values

_FRICTION = FRICTION.partition(".")[0]


def with_its_history(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """The campaign, and a note where it is not as it is without a question: friction goes on."""
    if not Assembled(campaign, ()).runs_that_go_on:
        return campaign, []
    anew = replace(campaign, runs_start_anew=True)
    if _log_evidence(anew) < _log_evidence(campaign) + RULES.log_rival_odds:
        return campaign, []
    return anew, [
        "runs begin where the ones before them ended, but the readings show friction that starts "
        "anew at each run: it faded or was released in between"
    ]


def _log_evidence(campaign: Campaign) -> float:
    """Of friction alone, in its best form."""
    return max((fit.log_evidence for fit in _fits(campaign)), default=-np.inf)


def _fits(campaign: Campaign) -> Iterator[Fit]:
    """Each form of friction, from the engagement angle that suits the linear problem best."""
    fitter = Fitter(campaign, [v for v in library_of(campaign, ()) if v.effect == _FRICTION])
    null = fitter.fit(Hypothesis())
    if null is None:
        return
    frictions = [v for v in fitter.variants if v.effect == _FRICTION]
    stack = Stack(Signatures(campaign, frictions).about(null, places(fitter)))
    screen = Screen(null, stack)
    best: dict[str, Gain] = {}
    for gain in (screen.gain((m,)) for m in np.flatnonzero(screen.usable).tolist()):
        label = stack.signatures[gain.members[0]].variant.label
        best[label] = max(best.get(label, gain), gain, key=lambda g: g.log_odds)
    for gain in best.values():
        members = [stack.signatures[m] for m in gain.members]
        hypothesis = Hypothesis(tuple(s.variant for s in members))
        found = fitter.fit(hypothesis, start_values(fitter, members, gain.sizes), null.noise)
        if found is not None:
            yield found
