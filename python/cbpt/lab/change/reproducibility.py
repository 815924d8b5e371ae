"""How well a rig comes back to the same state when it is set up again.

with_set_ups    levels whose noise has what a new set-up changes
reproducibility_of  that, from levels that repeat one state

A repeated measurement on a real rig differs by more than readings scatter: the members lie a little
otherwise, grease and temperature are others. What a set-up changes is taken to be of the kind that
effects and numbers can change: each of them may stand otherwise at each level, by as much as moves
the angles by the stated size. It belongs to the noise of a level, whatever changed; so a change
counts only as far as it goes beyond it (a random effect of the set-up in a mixed model).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.parties import Levels, log_noise
from cbpt.lab.change.shared import Party
from cbpt.lab.inference.gauss_newton import Problem, point_at

Floats = NDArray[np.float64]


def with_set_ups(levels: Levels, arcsec: float) -> Levels:
    """The levels with a reproducibility of this standard deviation."""
    parties = tuple(
        _with_set_up(party, arcsec, dof)
        for party, dof in zip(levels.parties, levels.stated_dof, strict=True)
    )
    return replace(levels, parties=parties)


def _with_set_up(party: Party, arcsec: float, stated_dof: float) -> Party:
    plain = party.problem
    columns = _freely(plain, plain.columns(party.point))
    size = np.sqrt(np.mean(columns**2, axis=0))
    seen = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    problem = copy(plain)
    problem.whitener = plain.whitener.beside(columns[:, seen] * (arcsec / size[seen]))
    problem.offsets = problem.whitener(plain.campaign.offsets)
    return Party(problem, party.point, log_noise(problem, stated_dof))


def reproducibility_of(levels: Levels, places: Sequence[Sequence[int]]) -> float | None:
    """Standard deviation in arcsec by which levels differ that repeat one state, each fitted by
    itself; None where that cannot be told. places: of the levels of each state."""
    squares, freedom = 0.0, 0
    for state in places:
        parties = [levels.parties[k] for k in state]
        problem = parties[0].problem
        curves = []
        for party in parties:
            values = parties[0].point.values.copy()
            values[problem.index] = party.point.values[party.problem.index]
            point = point_at(problem.model, values, ())
            if point is None:
                return None
            curves.append(_freely(problem, point.angle_arcsec[:, None])[:, 0])
        off = np.array(curves) - np.mean(curves, axis=0)
        squares += float(np.sum(np.mean(off**2, axis=1)))
        freedom += len(parties) - 1
    return float(np.sqrt(squares / freedom)) if freedom else None


def _freely(problem: Problem, columns: Floats) -> Floats:
    """Columns without what the offsets of the readings take up."""
    offsets = problem.campaign.offsets
    if not offsets.shape[1]:
        return columns
    basis = np.linalg.qr(offsets)[0]
    return np.asarray(columns - basis @ (basis.T @ columns))
