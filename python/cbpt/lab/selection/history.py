"""Whether friction goes on from run to run, or starts anew at each: what the readings say.

    with_its_history  the campaign with that of the two which they follow better

Where a run begins as the one before it ended, a real reducer keeps the friction that this has left
(loops that were cut into runs), unless it was released, reassembled or stood for long in between.
No column says which. So where runs go on, friction alone is fitted both ways. Not of a torsion
spring: play is as large as its loops, and friction alone takes it for a start of its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cbpt.errors import InvalidInputError
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_loops import FRICTION
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.selection.fit_effects import fits_of_forms
from cbpt.lab.selection.rules import RULES

_FRICTION = FRICTION.partition(".")[0]


def with_its_history(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """The campaign, and a note where it is not as it is without a question: friction goes on."""
    spring = campaign.drive.kind == "torsion_spring"
    if spring or not Assembled(campaign, ()).runs_that_go_on:
        return campaign, []
    anew = replace(campaign, runs_start_anew=True)
    if _log_evidence(anew) < _log_evidence(campaign) + RULES.log_rival_odds:
        return campaign, []
    return anew, [
        "runs begin where the ones before them ended, but the readings show friction that starts "
        "anew at each run: it faded or was released in between. For cbpt compare and cbpt fit to "
        "take it so, let time_s begin at 0 in each run"
    ]


def _log_evidence(campaign: Campaign) -> float:
    """Of friction alone, in its best form."""
    fitter = Fitter(campaign, [v for v in library_of(campaign, ()) if v.effect == _FRICTION])
    try:
        fits = fits_of_forms(fitter, [_FRICTION])
    except InvalidInputError:
        return -np.inf
    return max(fit.log_evidence for fit in fits.values())
