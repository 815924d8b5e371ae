"""Whether the runs of each level agree on what changed.

runs_agree  of one effect or number

Evidence adds up over readings, and one run that went otherwise may bring all of it: a ramp after a
rest, a slip, a first loop. Runs of one level that repeat each other say how much of a change each
of them shows. With d the change of the fitted curve and z what the fit leaves, both whitened, run r
shows the share c_r = 1 + z.d/d.d of it. The scatter of c among runs with the same torques, within a
level, is that of the change beside the noise model (a sandwich of the scores of clusters: Liang and
Zeger, Biometrika 73 (1986) 13), and Student's t tells whether the change is more, with the degrees
of freedom of Welch and Satterthwaite.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.posterior import Choice, groups_of
from cbpt.lab.covariance.repeated_runs import groups_of_runs
from cbpt.lab.inference.gauss_newton import Problem, point_at

Floats = NDArray[np.float64]

CHANCE = 0.01
"""Two-sided, as for the widths of loops."""


def runs_agree(choice: Choice, effect: str) -> bool:
    """True as well where no level repeats a run, or the model has no solution between levels."""
    from scipy.special import stdtrit

    scores = [_scores(choice, level, effect) for level in range(len(choice.levels.parties))]
    tables = [party.problem.campaign.readings for party in choice.levels.parties]
    if any(score is None for score in scores):
        return True
    seen = [score for score in scores if score is not None]
    whole = np.array([weight.sum() for _, weight in seen])
    variance, squares, freedom, repeated, alone = [], [], [], 0.0, 0.0
    for group in groups_of_runs(tables):
        shares, weights = [], []
        for level in sorted({level for level, _ in group}):
            score, weight = seen[level]
            here = [rows for at, rows in group if at == level]
            own = np.array([weight[rows].sum() for rows in here])
            shown = np.array([score[rows].sum() for rows in here]) / np.maximum(own, 1e-300)
            shares.append(shown - shown.mean())
            weights.append((own / whole[level]) ** 2)
        off, free = np.concatenate(shares), len(group) - len(shares)
        if free:
            variance.append(float(off @ off) / free)
            squares.append(float(np.concatenate(weights).sum()))
            freedom.append(free)
            repeated += float(off @ off)
        else:
            alone += float(np.concatenate(weights).sum())
    if not freedom:
        return True
    # A run that nothing repeats scatters as the others do.
    parts = np.array(variance) * squares
    parts[int(np.argmax(parts))] += alone * repeated / sum(freedom)
    total = float(parts.sum()) * 2 / len(seen)
    nu = float(parts.sum() ** 2 / np.sum(parts**2 / freedom)) if total > 0 else 1.0
    return total == 0 or 1 / np.sqrt(total) > float(stdtrit(nu, 1 - CHANCE / 2))


def _scores(choice: Choice, level: int, effect: str) -> tuple[Floats, Floats] | None:
    """z d and d d of each reading of a level; None without a solution."""
    problem, point = choice.levels.parties[level].problem, choice.fit.points[level]
    group = next(g for g in groups_of(choice.levels) if g.effect == effect)
    places = problem.index[list(group.unknowns)]
    values = point.values.copy()
    others = [p.values[places] for k, p in enumerate(choice.fit.points) if k != level]
    values[places] = np.mean(others, axis=0)
    moved = point_at(problem.model, values, ())
    if moved is None:
        return None
    left = problem.campaign.y_arcsec - point.angle_arcsec
    z, d = _freely(problem, left, point.angle_arcsec - moved.angle_arcsec)
    return z * d, d * d


def _freely(problem: Problem, *curves: Floats) -> Iterator[Floats]:
    """Curves whitened, without what the offsets of the readings take up."""
    offsets = np.linalg.qr(problem.whitener(problem.campaign.offsets))[0]
    for curve in curves:
        white = problem.whitener(curve)
        yield white - offsets @ (offsets.T @ white)
