"""The uncertainty of a reading from repeats: readings taken again under the same conditions.

    Repeats   the pooled standard deviation, and how well it is known
    pooled    from the residuals of a model, right or wrong
    independent_share  what repeats show of noise whose neighbours are alike
    no_uncertainty_of  why repeats do not tell it

Same conditions are the same levels of torque, preload (or its step) and input angle, reached in the
same direction; the first leg of a run stands apart, as loading for the first time is another thing.
With y the residual of reading i, in condition c(i) and run r(i),

    y_i = a_c(i) + b_r(i) + e_i,   u^2 = sum e_i^2 / (n - conditions - free offsets of runs)

(a two-way analysis of variance), so that neither what the model gets wrong at a condition nor the
offset of a run counts as scatter. Residuals, not angles, because a torque held not quite alike
moves both reading and model.

Where repeats are not steady, readings are the same only if the torque last turned at the same level
as well: with friction, loops of other amplitudes take other ways.

Readings of one hold follow each other, so noise that moves slowly is nearly the same in them: they
show a share of its variance alone. And what changes between repeats, as a play that opens half way,
does not change within a hold: repeats that differ by far more than is stated, where readings of one
hold do not, are not steady.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.within_run import Scatter
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of

__all__ = ["Repeats", "no_uncertainty_of", "pooled"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """Numbers of the estimate."""

    fewest_dof: int = 5
    largest: int = 2000
    """Unknowns of a dense system that is solved with ease."""
    negligible: float = 1e-3
    """A correlation that is none."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class Repeats:
    """What readings taken again say of their uncertainty."""

    u_arcsec: float
    """Standard deviation of one reading (with a stated uncertainty: of the median one)."""
    ratio: float | None
    """To the stated uncertainty; None where there is none."""
    dof: float
    """Degrees of freedom of that standard deviation."""
    conditions: int
    """How many conditions were taken more than once."""
    readings: int
    """How many readings were taken under them."""
    steady: bool
    """False where repeats differ by far more than readings scatter inside their runs, or than both
    readings of one hold do and is stated: then something changes between them, and they say nothing
    of the uncertainty."""

    def __str__(self) -> str:
        return (
            f"{self.readings} readings repeated under {self.conditions} conditions, "
            f"{self.dof:.0f} degrees of freedom"
        )


def no_uncertainty_of(repeats: Repeats | None) -> str:
    """Why repeats do not tell the uncertainty of a reading."""
    if repeats is None:
        return "no reading was taken again at exactly the same load"
    return (
        f"repeats ({repeats}) differ by far more than readings scatter within runs, which does not "
        "tell it"
    )


def pooled(
    readings: Readings, residual_arcsec: Floats, scatter: Scatter | None = None
) -> Repeats | None:
    """Residuals finite, shape (n,). None where too little was repeated.

    scatter: that inside the runs, to tell whether something changed between repeats.
    """
    conditions = _conditions(readings)
    found = _pooled(readings, residual_arcsec, scatter, conditions)
    if found is None or found.steady:
        return found
    # Friction holds a small loop inside a large one: then they have no reading in common.
    apart = _both(conditions, _turned_at(readings))
    of_loops = _pooled(readings, residual_arcsec, scatter, apart)
    return of_loops if of_loops is not None and of_loops.steady else found


def _pooled(
    readings: Readings, residual_arcsec: Floats, scatter: Scatter | None, condition: Ints
) -> Repeats | None:
    """The same under given conditions, shape (n,)."""
    u = readings.u_elastic_angle_arcsec
    y = residual_arcsec if u is None else residual_arcsec / u
    again = np.bincount(condition)[condition] > 1
    if not again.any():
        return None
    condition = np.unique(condition[again], return_inverse=True)[1]
    run = np.unique(readings.run_index[again], return_inverse=True)[1]
    y, conditions, runs = y[again], int(condition.max()) + 1, int(run.max()) + 1
    if min(conditions, runs) > _LIMITS.largest:
        return None
    left, dof = _two_way(y, *((condition, run) if runs < conditions else (run, condition)))
    if dof < _LIMITS.fewest_dof:
        return None
    sd = float(np.sqrt(left / dof))
    # Shown digits that agree are no proof of an exact instrument.
    if not sd > 1e-9 * float(np.abs(y).max()):
        return None
    typical = 1.0 if u is None else float(np.median(u))
    if u is not None and (scatter is None or not scatter.u_arcsec):
        scatter = _of_holds(readings, residual_arcsec / u, typical)
    return Repeats(
        u_arcsec=sd * typical,
        ratio=None if u is None else sd,
        dof=float(dof),
        conditions=conditions,
        readings=len(y),
        steady=_steady(sd * typical, dof, scatter),
    )


def independent_share(readings: Readings, correlation: float) -> float:
    """The share of the variance of noise that its repeats show, where each reading is correlated
    with the next of its run: 1 where they are far apart.

    With R_ij = r^|i - j| inside a run, the repeats of a condition, m of them, show of its variance
    (m - sum R_ij / m) / (m - 1); offsets of runs are left out of account.
    """
    condition = _conditions(readings)
    place = _places(readings)
    order = np.lexsort((place, readings.run_index, condition))
    condition, run, place = condition[order], readings.run_index[order], place[order]
    size = np.bincount(condition)
    alike = 0.0
    for further in range(1, len(order)):
        same = (condition[further:] == condition[:-further]) & (run[further:] == run[:-further])
        near = correlation ** (place[further:] - place[:-further])[same]
        if not near.size or near.max() < _LIMITS.negligible:
            break
        alike += float(np.sum(near / size[condition[further:][same]]))
    return 1.0 - 2.0 * alike / max(int(np.sum(size - 1)), 1)


def _of_holds(readings: Readings, weighted: Floats, typical_arcsec: float) -> Scatter | None:
    """How readings of one hold scatter, at least by what is stated; None where few torques were
    held. weighted: residuals in stated uncertainties, shape (n,)."""
    condition, place = _conditions(readings), _places(readings)
    order = np.lexsort((place, readings.run_index))
    begins = (np.diff(condition[order]) != 0) | (np.diff(readings.run_index[order]) != 0)
    hold = np.r_[0, np.cumsum(begins)]
    size = np.bincount(hold)
    dof = int(np.sum(size - 1))
    if dof < _LIMITS.fewest_dof:
        return None
    y = weighted[order]
    off = y - (np.bincount(hold, y) / size)[hold]
    sd = max(float(np.sqrt(off @ off / dof)), 1.0)
    return Scatter(sd * typical_arcsec, sd, float(dof), 0.0)


def _places(readings: Readings) -> Ints:
    """Which reading of its run each is, counted from 0, shape (n,)."""
    order = np.argsort(readings.run_index, kind="stable")
    run = readings.run_index[order]
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order)) - np.searchsorted(run, run)
    return place


def _two_way(y: Floats, many: Ints, few: Ints) -> tuple[float, int]:
    """What the best y = a_many + b_few leaves of the sum of squares, and its degrees of freedom.

    The a are taken out as means, which leaves a dense system for the b alone, and that needs the
    counts of the pairs that occur, not of all. Of each connected part of the graph of pairs one b
    is any number, here 0 (a weighted Laplacian, one node of each part grounded).
    """
    from scipy.sparse import csr_array, diags_array
    from scipy.sparse.csgraph import connected_components

    counts = csr_array((np.ones(len(y)), (many, few)))
    size = np.bincount(many)
    off = y - (np.bincount(many, y) / size)[many]
    shared = (counts.T @ (diags_array(1 / size) @ counts)).toarray()
    gram = np.diag(np.bincount(few).astype(np.float64)) - shared
    parts, label = connected_components(gram, directed=False)
    free = np.ones(len(gram), dtype=bool)
    free[np.unique(label, return_index=True)[1]] = False
    push = np.bincount(few, off)[free]
    b = np.linalg.solve(gram[np.ix_(free, free)], push)
    dof = len(y) - counts.shape[0] - counts.shape[1] + int(parts)
    return max(float(off @ off - push @ b), 0.0), dof


def _steady(u_arcsec: float, dof: int, scatter: Scatter | None) -> bool:
    """Whether repeats scatter as readings do inside their runs, as far as that is known."""
    if scatter is None or not scatter.u_arcsec or u_arcsec < 1.5 * scatter.u_arcsec:
        return True
    from scipy.special import fdtrc

    return float(fdtrc(dof, scatter.dof, (u_arcsec / scatter.u_arcsec) ** 2)) > 0.001


def _conditions(readings: Readings) -> Ints:
    """Which readings share their conditions, counted from 0, shape (n,)."""
    columns = [
        levels_of(readings.torque_Nm).index,
        levels_of(readings.input_angle_deg).index,
        readings.direction(),
        _first_leg(readings),
    ]
    if readings.preload_step is not None:
        columns.append(np.unique(readings.preload_step, return_inverse=True)[1])
    if readings.preload_N is not None:
        columns.append(levels_of(readings.preload_N).index)
    found = np.zeros(len(readings), dtype=np.int64)
    for column in columns:
        found = _both(found, column)
    return found


def _both(one: Ints, other: Ints) -> Ints:
    """One number for each combination, counted anew so that it stays small."""
    low = int(other.min())
    both = one * (int(other.max()) - low + 1) + (other - low)
    return np.asarray(np.unique(both, return_inverse=True)[1], dtype=np.int64)


def _turned_at(readings: Readings) -> Ints:
    """The level of the torque at which each reading's way began, shape (n,)."""
    level, direction = levels_of(readings.torque_Nm).index, readings.direction()
    order = np.argsort(readings.run_index, kind="stable")
    run, ways, levels = readings.run_index[order], direction[order], level[order]
    begins = np.r_[True, (np.diff(run) != 0) | (np.diff(ways) != 0)]
    # Where a way turns, its first reading is a step beyond the turn.
    before = np.r_[levels[0], levels[:-1]]
    new_run = np.r_[True, np.diff(run) != 0]
    starts = np.where(new_run, levels, before)
    last = np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))
    found = np.empty(len(order), dtype=np.int64)
    found[order] = starts[last]
    return found


def _first_leg(readings: Readings) -> Ints:
    """1 until the torque of a run turns for the first time, shape (n,)."""
    first = np.zeros(len(readings), dtype=np.int64)
    direction = readings.direction()
    order = np.argsort(readings.run_index, kind="stable")
    run, ways = readings.run_index[order], direction[order]
    # The way in which each run sets out; 0 where its torque never moves.
    out = np.zeros(int(run.max()) + 1, dtype=np.int64)
    moving = np.flatnonzero(ways)
    out[run[moving[::-1]]] = ways[moving[::-1]]
    turned = np.cumsum((ways != 0) & (ways == -out[run]))
    before = np.r_[0, turned][np.searchsorted(run, run)]
    first[order] = turned == before
    return first
