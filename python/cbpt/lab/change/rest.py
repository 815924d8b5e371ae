"""What the fitted effects leave, and which changes are too small beside it to be told.

Rest       the rest of all levels
rest_of    finds it
again      what runs of each level that repeat each other tell of what its fit leaves
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cbpt.lab.change.agreement import runs_agree
from cbpt.lab.change.parties import Levels
from cbpt.lab.change.posterior import Choice, Weighed
from cbpt.lab.change.reproducibility import moves_of, reproducibility_of, rms_arcsec
from cbpt.lab.covariance.repeated_runs import ComesAgain, Differing, comes_again, differing_of
from cbpt.lab.model.own_loops import PLAY, small_loops_of
from cbpt.lab.selection.rules import RULES
from cbpt.results import ARCSEC_PER_RAD


@dataclass(frozen=True)
class Rest:
    """All in arcsec, rms or standard deviation over the readings as the fit weighs them.

    What the effects do not follow may look like a change that moves the angles by less, and what of
    it differs from level to level like a change of a single effect.
    """

    is_law: tuple[bool, ...]
    """Of each level, whether its rest comes again in runs that repeat each other, and so is no
    noise."""
    not_followed_arcsec: float
    """The largest rest that is no noise; else 0."""
    differs_arcsec: float | None
    """By how much it differs from level to level in runs with the same torques, where it is another
    law there, or the same one of another size; else None."""
    apart_arcsec: float | None
    """By how much the fitted curves of the levels differ; None where one has no solution."""
    moves_arcsec: Mapping[str, float]
    """Of what may have changed: by how much the fitted angles of levels differ by that beyond what
    other numbers make up for."""
    told_from_arcsec: float
    """From which of these on a change of one effect is told: what the rests of runs with the same
    torques differ by from level to level; without such runs, the rest."""
    runs_differ: tuple[str, ...]
    """Of that: what runs of one level with the same torques do not agree on."""
    on_large_loops: tuple[str, ...]
    """Of that: a play wider than what small loops turn that friction holds. It rests on the large
    loops alone, and stands for what else these show."""
    hidden: tuple[str, ...]
    """These, and what moves the angles by less than `told_from_arcsec`."""

    @property
    def hides_all(self) -> bool:
        """Whether no change can be told."""
        smaller = self.apart_arcsec is not None and self.apart_arcsec < self.not_followed_arcsec
        return smaller or len(self.hidden) == len(self.moves_arcsec)


def rest_of(weighed: Weighed, comes_back: bool) -> Rest:
    """By the best answer. comes_back: whether the rig is taken to come back to the same state when
    it is set up again. What a new set-up may change of the fitted curve, it may change of the
    rest."""
    levels = weighed.best.levels
    campaigns = [party.problem.campaign for party in levels.parties]
    left = [fit.residual_arcsec for fit in levels.fits]
    is_law = tuple(a is not None and a.p_value < RULES.left_chance for a in again(levels))
    not_followed_arcsec = max(
        (rms_arcsec(c, r) for c, r, law in zip(campaigns, left, is_law, strict=True) if law),
        default=0.0,
    )
    moves_arcsec = {e: moves_of(weighed.best_with(e), e) for e in weighed.likely}
    differing = differing_of([c.readings for c in campaigns], left, [c.u_arcsec for c in campaigns])
    told_from_arcsec = min(not_followed_arcsec, np.inf if differing is None else differing.arcsec)
    runs_differ = tuple(e for e in moves_arcsec if not runs_agree(weighed.best_with(e), e))
    unseen = tuple(e for e in moves_arcsec if _unseen(weighed.best_with(e), e))
    return Rest(
        is_law=is_law,
        not_followed_arcsec=not_followed_arcsec,
        apart_arcsec=reproducibility_of(levels, [range(len(campaigns))]),
        differs_arcsec=_other_law(differing) if comes_back else None,
        moves_arcsec=moves_arcsec,
        told_from_arcsec=told_from_arcsec,
        runs_differ=runs_differ,
        on_large_loops=unseen,
        hidden=tuple(
            e
            for e, arcsec in moves_arcsec.items()
            if arcsec < told_from_arcsec or e in runs_differ or e in unseen
        ),
    )


def _unseen(choice: Choice, effect: str) -> bool:
    """Whether a play rests on the large loops alone: what they leave may be told as play."""
    names = [unknown.name for unknown in choice.levels.fits[0].unknowns]
    if effect != PLAY.partition(".")[0] or PLAY not in names:
        return False
    place = choice.levels.fits[0].unknowns[names.index(PLAY)].index
    for party, point in zip(choice.levels.parties, choice.fit.points, strict=True):
        loops = small_loops_of(party.problem.campaign)
        play_arcsec = float(point.values[place]) * ARCSEC_PER_RAD
        if loops is not None and loops.held and play_arcsec > loops.turn_arcsec:
            return True
    return False


def _other_law(differing: Differing | None) -> float | None:
    """How much differs, where noise does not: what is left of one level explains less than half of
    what is left of another, or it is the same law and larger by more than its runs let expect."""
    if differing is None or differing.p_value >= RULES.left_chance:
        return None
    other_size = differing.p_value_of_sizes < RULES.left_chance
    return differing.arcsec if other_size or differing.correlation**2 < 0.5 else None


def again(levels: Levels) -> list[ComesAgain | None]:
    """None where no runs repeat each other."""
    return [
        comes_again(party.problem.campaign.readings, fit.residual_arcsec)
        for party, fit in zip(levels.parties, levels.fits, strict=True)
    ]
