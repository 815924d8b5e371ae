"""What holds of any competition: no set follows the readings worse than one that it contains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.priors import ODDS
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.effort import EFFORT
from cbpt.lab.selection.refits import follows
from cbpt.lab.selection.setting import Names


def exactly(c: Competition, names: Names) -> float:
    """How a set follows the readings by the equations of its effects; in a fit they may depart from
    these, each set as far as suits it."""
    fit = c.fits[names]
    return follows(c.fitter, c.fitter.look(replace(fit, discrepancy_sd=0.0), fit.noise))


def worse_than_a_part(c: Competition, by: float = EFFORT.worse) -> list[tuple[Names, Names, float]]:
    """Sets near the best that follow the readings worse than one of one effect less: the larger one
    may take the values and the noise of the smaller, and add nothing, so its score is no less than
    that of the smaller less the price of the addition, nor than a fit that begins there: the
    room for the sizes costs too. by: in log odds."""
    best = max(c.log_odds.values())
    found = []
    for names in c.fits:
        inner = [tuple(n for n in names if n != gone) for gone in names]
        if c.log_odds[names] < best - EFFORT.settled_room:
            continue
        for part in inner:
            if part in c.fits:
                as_fitted = follows(c.fitter, c.fits[part]) - follows(c.fitter, c.fits[names])
                off = min(as_fitted, exactly(c, part) - exactly(c, names))
                # A form that follows less well may cost less: what it owes is told by the score.
                (more,) = set(names) - set(part)
                price = -float(np.log(ODDS.get(more, ODDS[""])))
                off = min(off, c.log_odds[part] - c.log_odds[names] - price)
                if off > by and begun_at(c, names, part) - c.fits[names].log_evidence > by:
                    found.append((names, part, off))
    return found


def begun_at(c: Competition, names: Names, part: Names) -> float:
    """Log evidence of a set whose fit begins at the values and the noise of one of its parts."""
    smaller = c.fits[part]
    more = (v for v in c.fits[names].hypothesis.variants if v.effect not in part)
    hypothesis = Hypothesis((*smaller.hypothesis.variants, *more))
    start = c.fitter.start(hypothesis, {})
    kept = [u.index for u in smaller.unknowns]
    start[kept] = smaller.point.values[kept]
    found = c.fitter.fit(hypothesis, start, smaller.noise)
    return -np.inf if found is None else found.log_evidence
