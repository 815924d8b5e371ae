"""What friction follows of campaigns that differ by what no column says: turns, or a past.

    friction_fits   fits of friction in each of some campaigns, each from where the others ended
    gained_by       what some fits gain over others

Only the first campaign is searched whole. The others differ little from it, and a search that
begins where another one ended compares what differs, and not which of several minima a search
happened to end in.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from cbpt.errors import InvalidInputError
from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_loops import FRICTION, PLAY
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.selection.fit_effects import Fits, fits_nearby, fits_of_forms

FRICTION_EFFECT, _PLAY = (name.partition(".")[0] for name in (FRICTION, PLAY))


def friction_fits(
    campaigns: Sequence[Campaign], named: Sequence[str] | None, first: Fits | None = None
) -> list[Fits]:
    """Friction in its forms, of a torsion spring beside what bends its loops; of each campaign, and
    empty where the first one has no solution. Where effects are searched a curve stands for a stop,
    too.

    named: effects that are fitted; None where they are searched.
    first: fits of the first campaign, where it has been searched.
    """
    fitters = [_fitter(campaign, named) for campaign in campaigns]
    usual = _searched(fitters[0], named) if first is None else first
    if not usual:
        return [{} for _ in campaigns]
    works = [partial(fits_nearby, fitter, usual) for fitter in fitters[1:]]
    found = [usual, *side_by_side(campaigns[0], works)]
    best = max(found, key=evidence_of)
    works = [
        partial(_again, fitter, best, known) for fitter, known in zip(fitters, found, strict=True)
    ]
    return side_by_side(campaigns[0], works)


def evidence_of(fits: Fits) -> float:
    """Log evidence of the best of some fits; that of no solution where there are none."""
    return max((fit.log_evidence for fit in fits.values()), default=-np.inf)


def _fitter(campaign: Campaign, named: Sequence[str] | None) -> Fitter:
    effects = _effects(campaign, named)
    # A rarer form would follow a turn or a past that is not the one.
    library = library_of(campaign, effects)
    return Fitter(campaign, [v for v in library if v.effect in effects and v.odds >= 1])


def _effects(campaign: Campaign, named: Sequence[str] | None) -> list[str]:
    if campaign.drive.kind != "torsion_spring":
        return [FRICTION_EFFECT]
    bends = ["stiffness_curve", "hard_stop"]
    asked = bends[:1] if named is None else [bend for bend in bends if bend in named]
    return [FRICTION_EFFECT, _PLAY, *asked]


def _searched(fitter: Fitter, named: Sequence[str] | None) -> Fits:
    try:
        return fits_of_forms(fitter, _effects(fitter.campaign, named))
    except InvalidInputError:
        return {}


def _again(fitter: Fitter, best: Fits, known: Fits) -> Fits:
    """Fits of a campaign, searched from where the best ones of another ended too."""
    return known if known is best or not known else fits_nearby(fitter, best, known)
