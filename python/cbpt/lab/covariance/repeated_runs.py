"""What runs that repeat each other tell of a model's residuals: which part is law, which noise.

    ComesAgain        what runs differ by, and the chance that noise alone agrees as much
    comes_again       whether what a model leaves comes again
    runs_alike        which runs have the same torques
    groups_of_runs    the same over several tables
    most_correlation  how much neighbours of a run can be alike by noise
    kinds_of_runs     how much runs of one kind scatter beside those of another
    Differing         what of that is not the same from table to table
    differing_of      finds it, and whether it is the same law of another size

Noise differs from run to run, however slowly it moves; a law that the model lacks comes again. With
y_ij what is left of run i at place j of k runs with the same torques,

    y_ij = a_j + b_i + e_ij,   F = k var(a)/var(e),

a two-way analysis of variance, in which e is noise and a law that the model lacks is a part of a.
Neighbours in a run may be alike: with the correlation r of e from
one reading to the next, n readings count as n (1 - r^2)/(1 + r^2) (Bayley and Hammersley, J. R.
Stat. Soc. Suppl. 8 (1946) 184). Unlike `repeatability`, the torques need not be set points: a ramp
that is measured as it comes is the same ramp again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """Which runs repeat each other."""

    alike: float = 0.15
    """Largest difference of their torques at the same place, as a share of the largest."""
    fewest: int = 12
    """Readings of a run."""
    correlations: int = 100
    """Steps from 0 to 1 in which a correlation is looked for."""
    drop: float = 2.7
    """Log-likelihood below the largest at which a correlation is excluded (one-sided, 1 %)."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class ComesAgain:
    """What repeated runs say of what is left."""

    scatter_arcsec: float
    """Standard deviation of a reading from run to run."""
    p_value: float
    """Chance that noise alone agrees as much from run to run."""


def comes_again(readings: Readings, left_arcsec: Floats) -> ComesAgain | None:
    """left_arcsec: shape (n,). None where no runs repeat each other."""
    from scipy.special import fdtrc

    squares, freedom, chances = 0.0, 0.0, []
    for rows in _alike(readings):
        k, m = rows.shape
        common, e, within = _divided(left_arcsec[rows])
        if not within > 0:
            continue
        r = float(np.sum(e[:, 1:] * e[:, :-1]) / np.sum(e**2))
        share = (1 - r**2) / (1 + r**2)
        ratio = k * float(np.sum(common**2)) / (m - 1) / within
        dof = (m - 1) * share
        chances.append(float(fdtrc(dof, (k - 1) * dof, ratio)))
        squares += float(np.sum(e**2))
        freedom += (k - 1) * (m - 1)
    if not chances:
        return None
    p_value = min(1.0, len(chances) * min(chances))
    return ComesAgain(float(np.sqrt(squares / freedom)), p_value)


def most_correlation(readings: Readings, left_arcsec: Floats) -> float:
    """The largest correlation of a reading with the next of its run that the differences of runs
    allow, with a chance of 1 % for more; 1 where no runs repeat each other.

    A law that a model lacks is smooth along a run, and looks like noise whose neighbours are alike.
    It is the same in every run and drops out of their differences, which are first-order
    autoregressions with a mean of their own (restricted likelihood). left_arcsec: shape (n,).
    """
    groups = [_contrasts(left_arcsec[rows]) for rows in _alike(readings)]
    # Runs that agree in every digit are no proof of an exact instrument.
    least = 1e-9 * float(np.abs(left_arcsec).max(initial=0.0))
    groups = [d for d in groups if np.ptp(d, axis=1).max() > least]
    if not groups:
        return 1.0
    tried = np.arange(_LIMITS.correlations) / _LIMITS.correlations
    likely = np.array([sum(_likelihood(d, r) for d in groups) for r in tried.tolist()])
    allowed = np.flatnonzero(likely > likely.max() - _LIMITS.drop)
    return float(tried[allowed[-1]] + 1 / _LIMITS.correlations)


def _contrasts(y: Floats) -> Floats:
    """Orthonormal differences of k runs, shape (k - 1, m)."""
    from scipy.linalg import helmert

    return np.asarray(helmert(len(y)) @ y)


def _likelihood(d: Floats, correlation: float) -> float:
    """Restricted log-likelihood of differences, their scale profiled."""
    first = np.sqrt(1 - correlation**2)
    y = np.column_stack([first * d[:, 0], d[:, 1:] - correlation * d[:, :-1]])
    mean = np.r_[first, np.full(d.shape[1] - 1, 1 - correlation)]
    size = float(mean @ mean)
    left = float(np.sum(y**2) - np.sum((y @ mean) ** 2) / size)
    free = d.shape[0] * (d.shape[1] - 1)
    # Rounding is the least there can be.
    left = max(left, 1e-12 * float(np.sum(d**2)))
    return float(-0.5 * free * np.log(left) + 0.5 * len(d) * np.log(first**2 / size))


def kinds_of_runs(readings: Readings, left_arcsec: Floats) -> Floats:
    """Relative uncertainty of each reading, by how much the runs that repeat its run differ; 1
    where fewer than two kinds of runs are repeated. Shape (n,).

    Large loops often slip and small ones do not. Few runs tell little of their scatter, and none of
    what a model leaves: so the uncertainties are half way from one for all, by their logarithms. A
    run that is not repeated is like those whose largest torque is nearest to its own. Runs that
    agree in every digit are no proof of an exact instrument, and rounding is a scatter too.
    """
    torque = np.abs(readings.torque_Nm)
    kinds = [(rows, _divided(left_arcsec[rows])[2]) for rows in _alike(readings)]
    least = (1e-9 * float(np.abs(left_arcsec).max(initial=0.0))) ** 2
    rounding = display_step(readings.elastic_angle_arcsec) ** 2 / 12
    kinds = [(rows, variance + rounding) for rows, variance in kinds if variance > least]
    found = np.ones(len(readings))
    if len(kinds) < 2:
        return found
    reach = np.array([max(float(torque[rows].max()), 1e-300) for rows, _ in kinds])
    variances = np.array([variance for _, variance in kinds])
    for run in np.unique(readings.run_index):
        here = readings.run_index == run
        own = max(float(torque[here].max()), 1e-300)
        found[here] = variances[np.argmin(np.abs(np.log(reach / own)))]
    for rows, variance in kinds:
        found[rows] = variance
    return np.asarray(found**0.25 / np.sqrt(np.mean(found**0.5)))


def _divided(left_arcsec: Floats) -> tuple[Floats, Floats, float]:
    """What k runs share, shape (m,), what is of each, shape (k, m), and the variance of that; the
    mean of each run left aside."""
    k, m = left_arcsec.shape
    y = left_arcsec - left_arcsec.mean(axis=1, keepdims=True)
    common = y.mean(axis=0)
    e = y - common
    return common, e, float(np.sum(e**2)) / ((k - 1) * (m - 1))


@dataclass(frozen=True)
class Differing:
    """By how much what a model leaves of runs with the same torques differs from table to table."""

    arcsec: float
    """Standard deviation of the means of a table's runs, noise included."""
    correlation: float
    """Of what is law in one table with what is law in another; 1 where nothing is."""
    p_value: float
    """Chance that noise alone differs as much; 1 where no runs of one table repeat each other."""
    p_value_of_sizes: float
    """Chance that what is law in all tables has one size, by how its size differs from run to run
    of a table; 1 where no runs of one table repeat each other, or where most of what differs is of
    another form."""


def differing_of(
    tables: Sequence[Readings], left_arcsec: Sequence[Floats], u_arcsec: Sequence[Floats]
) -> Differing | None:
    """Readings weighted by their uncertainties; None where no run of a table has the torques of
    another's. left_arcsec, u_arcsec: of each table, shape (n,).

    With y_tij what is left of run i of table t at place j, y_tij = a_j + d_tj + b_ti + e_tij; the
    correlation is var(a) / (var(a) + var(d)), by analysis of variance. The sizes are those of the
    pattern a in each run: readings of a run are one observation of its size, and not many. What
    several kinds of runs tell of it is combined by Fisher's method.
    """
    from scipy.special import chdtrc

    squares, weight, common, apart = 0.0, 0.0, 0.0, 0.0
    chances: list[float] = []
    of_sizes: list[float] = []
    for group in groups_of_runs(tables):
        places = sorted({place for place, _ in group})
        if len(places) < 2:
            continue
        runs = [[left_arcsec[p][rows] for at, rows in group if at == p] for p in places]
        first, rows = group[0]
        weights = u_arcsec[first][rows] ** -2.0
        total = float(weights.sum())
        found = _apart([np.array(of) for of in runs], weights)
        weight += total
        squares += total * found.means
        if found.p_value is not None:
            common += total * found.common
            apart += total * found.apart
            chances.append(found.p_value)
            of_sizes.append(found.p_value_of_sizes)
    if not weight:
        return None
    return Differing(
        arcsec=float(np.sqrt(squares / weight)),
        correlation=common / (common + apart) if common + apart > 0 else 1.0,
        p_value=min(1.0, len(chances) * min(chances, default=1.0)),
        p_value_of_sizes=float(
            chdtrc(2 * len(of_sizes), -2 * np.sum(np.log(np.maximum(of_sizes, 1e-300))))
        ),
    )


@dataclass(frozen=True)
class _Apart:
    """Variances over the places of runs with the same torques, of several tables."""

    means: float
    """Of the means of tables, from table to table."""
    common: float = 0.0
    """Of what all tables share."""
    apart: float = 0.0
    """Of what differs from table to table beyond what differs from run to run."""
    p_value: float | None = None
    """None where no run of a table repeats another."""
    p_value_of_sizes: float = 1.0


def _apart(runs: Sequence[Floats], weights: Floats) -> _Apart:
    """runs: of each table, shape (k, m); weights: shape (m,)."""
    from scipy.special import fdtrc

    share = weights / weights.mean()
    y = [of - of.mean(axis=1, keepdims=True) for of in runs]
    means = np.array([of.mean(axis=0) for of in y])
    counts = np.array([len(of) for of in y])
    tables, every, m = len(y), int(counts.sum()), len(share)
    of_means = float(share @ np.var(means, axis=0, ddof=1)) / m
    if every == tables:
        return _Apart(of_means)
    e = np.concatenate([of - mean for of, mean in zip(y, means, strict=True)])
    centre = counts @ means / every
    within = float(np.sum(e**2 @ share)) / ((every - tables) * (m - 1))
    between = float(counts @ ((means - centre) ** 2 @ share)) / ((tables - 1) * (m - 1))
    apart = (between - within) * (tables - 1) * (m - 1)
    if not within > 0:
        return _Apart(of_means)
    r = float(np.sum(e[:, 1:] * e[:, :-1]) / np.sum(e**2))
    dof = (m - 1) * (1 - r**2) / (1 + r**2)
    return _Apart(
        of_means,
        max(float(share @ centre**2) / (m - 1) - between / every, 0.0),
        max(between - within, 0.0) * tables / every,
        float(fdtrc((tables - 1) * dof, (every - tables) * dof, between / within)),
        _of_sizes([of @ (share * centre) for of in y], float(share @ centre**2), apart),
    )


def _of_sizes(sizes: Sequence[Floats], unit: float, apart: float) -> float:
    """Chance that the sizes of runs differ as much from table to table, by how they differ within
    tables: a one-way analysis of variance. sizes: of each table, shape (k,), times `unit`, the
    square of the law. apart: the sum of squares of all that differs from table to table."""
    from scipy.special import fdtrc

    every = np.concatenate(sizes)
    within = sum(float(np.sum((of - of.mean()) ** 2)) for of in sizes)
    between = float(np.sum((every - every.mean()) ** 2)) - within
    freedom = len(sizes) - 1, len(every) - len(sizes)
    if not within > 0 or between < 0.5 * apart * unit:
        return 1.0
    return float(fdtrc(*freedom, between / freedom[0] / (within / freedom[1])))


def runs_alike(readings: Readings) -> list[Ints]:
    """Rows of runs with the same torques, each group of shape (runs, readings of a run); a run that
    nothing repeats is a group by itself. Short runs are left."""
    return [np.array([rows for _, rows in group]) for group in groups_of_runs([readings])]


def _alike(readings: Readings) -> list[Ints]:
    """Those of runs that repeat each other."""
    return [rows for rows in runs_alike(readings) if len(rows) > 1]


def groups_of_runs(tables: Sequence[Readings]) -> list[list[tuple[int, Ints]]]:
    """Runs that repeat each other over all tables: each with the place of its table and its rows.
    Short runs are left."""
    groups: list[list[tuple[int, Ints]]] = []
    for place, readings in enumerate(tables):
        order = np.argsort(readings.run_index, kind="stable")
        ends = np.flatnonzero(np.diff(readings.run_index[order])) + 1
        for rows in np.split(order, ends):
            if len(rows) < _LIMITS.fewest:
                continue
            for group in groups:
                other, theirs = group[0]
                if _same((tables[other], theirs), (readings, rows)):
                    group.append((place, rows))
                    break
            else:
                groups.append([(place, rows)])
    return groups


def _same(one: tuple[Readings, Ints], other: tuple[Readings, Ints]) -> bool:
    """Whether two runs have the same torques under the same conditions."""
    (first, rows), (second, others) = one, other
    if len(rows) != len(others):
        return False
    torque, again = first.torque_Nm[rows], second.torque_Nm[others]
    if np.abs(torque - again).max() > _LIMITS.alike * float(np.abs(torque).max()):
        return False
    return all(
        (a is None and b is None)
        or (a is not None and b is not None and _same_values(a[rows], b[others]))
        for a, b in zip(_conditions(first), _conditions(second), strict=True)
    )


def _same_values(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Whether values or words of a column are the same."""
    if one.dtype.kind == other.dtype.kind == "U":
        return bool(np.all(one == other))
    if "U" in (one.dtype.kind, other.dtype.kind):
        return False
    return np.allclose(one, other, 0.02, 1e-6)


def _conditions(readings: Readings) -> Sequence[NDArray[Any] | None]:
    return readings.preload_N, readings.preload_step, readings.input_angle_deg
