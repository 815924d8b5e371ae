"""Whether the runs of each level agree on what changed.

runs_agree  of one effect or number

Evidence adds up over readings, and one run that went otherwise may bring all of it: a ramp after a
rest, a slip, a first loop. Runs of one level that repeat each other say how much of a change each
of them shows. With d the change of the fitted curve and z what the fit leaves, both whitened, run r
shows the share c_r = 1 + z.d/d.d of it. The scatter of c among runs with the same torques, within a
level, is that of the change beside the noise model (a sandwich of the scores of clusters: Liang and
Zeger, Biometrika 73 (1986) 13); its variance goes with 1/d.d, by which a run tells the change, and
is pooled so, and that of each kind of runs moderated by all (G. Smyth, Stat. Appl. Genet. Mol.
Biol. 3 (2004) 3). Student's t tells whether the change is more (two-sided, with the chance that
widths of loops have, and the degrees of freedom of Welch and Satterthwaite).

A level that cannot by far have the other's value (a play much wider than its own small loops) needs
no runs to show it: all of them do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.loop_widths import CHANCE
from cbpt.lab.change.posterior import Choice
from cbpt.lab.change.reproducibility import excludes, places_of, with_values_of
from cbpt.lab.covariance.repeated_runs import groups_of_runs
from cbpt.lab.inference.gauss_newton import Problem
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]

_ALIKE = 4.0
"""Degrees of freedom that all groups lend to the variance of each: as the noise of the fit has it
they scatter alike, and so about within a factor of two (2 to 4 runs of a kind tell it worse)."""


def runs_agree(choice: Choice, effect: str) -> bool:
    """Between the levels that it moves most apart. True as well where no level repeats a run, or a
    level has no solution with the values of the other one, or the same curve."""
    pairs = [_Pair.of(choice, effect, levels) for levels in _furthest(choice, effect)]
    known = [pair for pair in pairs if pair is not None]
    return not known or max(known, key=lambda pair: pair.size).agrees()


def _furthest(choice: Choice, effect: str) -> set[tuple[int, int]]:
    """Pairs of levels between which some number of an effect differs most."""
    places = places_of(choice, effect)
    values = np.array([point.values[places] for point in choice.fit.points])
    least, most = values.argmin(axis=0).tolist(), values.argmax(axis=0).tolist()
    return {(min(pair), max(pair)) for pair in zip(least, most, strict=True) if pair[0] != pair[1]}


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two levels, and of each reading of both z d and d d."""

    tables: tuple[Readings, Readings]
    score: tuple[Floats, Floats]
    weight: tuple[Floats, Floats]
    excludes: tuple[bool, bool] = (False, False)
    """Whether the level cannot by far have the value of the other one."""

    @classmethod
    def of(cls, choice: Choice, effect: str, levels: tuple[int, int]) -> _Pair | None:
        found = []
        for level, other in (levels, levels[::-1]):
            moved = with_values_of(choice, effect, level, other)
            if moved is None or not (moved != choice.fit.points[level].angle_arcsec).any():
                return None
            problem, point = choice.levels.parties[level].problem, choice.fit.points[level]
            left = problem.campaign.y_arcsec - point.angle_arcsec
            z, d = _freely(problem, left, point.angle_arcsec - moved)
            found.append((problem.campaign.readings, z * d, d * d))
        (one, u, v), (two, s, t) = found
        beyond = excludes(choice, effect, *levels), excludes(choice, effect, *levels[::-1])
        return cls((one, two), (u, s), (v, t), beyond)

    @property
    def size(self) -> float:
        """Square of the change, whitened."""
        return float(sum(weight.sum() for weight in self.weight))

    def agrees(self) -> bool:
        """Whether the change is more than runs of one level differ by."""
        from scipy.special import stdtrit

        variance, share, freedom, repeated, alone = [], [], [], 0.0, 0.0
        for group in groups_of_runs(self.tables):
            off, weights = [], []
            for level in sorted({level for level, _ in group}):
                here = [rows for at, rows in group if at == level]
                own = np.array([self.weight[level][rows].sum() for rows in here])
                score = np.array([self.score[level][rows].sum() for rows in here])
                least = np.maximum(own, 1e-300)
                off.append((score / least - score.sum() / least.sum()) * np.sqrt(own))
                weights.append((not self.excludes[level]) * own / self.weight[level].sum() ** 2)
            free = len(group) - len(off)
            if free:
                squares = float(np.sum(np.concatenate(off) ** 2))
                variance.append(squares / free)
                share.append(float(np.concatenate(weights).sum()))
                freedom.append(free)
                repeated += squares
            else:
                alone += float(np.concatenate(weights).sum())
        if not freedom:
            return True
        pooled, known = repeated / sum(freedom), np.array(freedom) + _ALIKE
        moderated = (_ALIKE * pooled + np.array(freedom) * variance) / known
        parts = moderated * share
        # A run that nothing repeats scatters as the others do.
        parts[int(np.argmax(parts))] += alone * pooled
        total = float(parts.sum())
        if total == 0:
            return True
        nu = float(total**2 / np.sum(parts**2 / known))
        return bool(1 / np.sqrt(total) > stdtrit(nu, 1 - CHANCE / 2))


def _freely(problem: Problem, *curves: Floats) -> Iterator[Floats]:
    """Curves whitened, without what the offsets of the readings take up."""
    offsets = np.linalg.qr(problem.offsets)[0]
    for curve in curves:
        white = problem.whitener(curve)
        yield white - offsets @ (offsets.T @ white)
