"""How far readings on legs that repeat each other differ.

    Compared   how far each reading lies off the others, and the scatter of a reading
    compared   finds it
    odd_runs   runs that differ from the others by far more than those among themselves
    slopes     how far the slopes of runs differ

Each reading of a leg stands beside the straight lines between the readings of the other legs at its
own torque. With m others, each a line between two readings with weights w, the difference has the
variance of a reading times 1 + sum w^2/m^2, so that it tells the scatter of one reading, however
many there are: of the angle, and of the torque where that is noisy. Each run has its own zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import typical_size
from cbpt.lab.preflight.legs import Leg
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """Numbers of the estimate."""

    others: int = 8
    """Legs that one is held against; more hardly make their mean better known."""
    grid: int = 19
    """Torques on which zeros of runs are found."""
    sweeps: int = 30
    """Steps in which zeros of runs and means of groups settle."""
    apart: float = 4.0
    """Standard deviations from which on a reading is no part of the scatter: hardly any of normal
    noise."""
    fewest: int = 5
    """Degrees of freedom that tell a scatter."""
    odd: float = 3.0
    """A run is odd that differs from the others by this many times what they differ by."""
    suspect: float = 2.5
    """Least ratio of its mean square to the median of runs: one of three runs with three times the
    noise of the others, which it is a part of the mean for, has 2.7 times."""


_LIMITS = _Limits()


@dataclass(frozen=True, eq=False)
class Compared:
    """Readings against those of the other legs; arrays have shape (k,)."""

    row: Ints
    run: Ints
    off_arcsec: Floats
    """Off the mean of the others, each as large as one reading scatters."""
    others_arcsec: Floats
    """The mean of the others."""
    size: Floats
    """By how many of its own standard deviations a reading is off them."""
    step_arcsec: float

    @property
    def near(self) -> NDArray[np.bool_]:
        """Which of them are part of the scatter."""
        size = max(typical_size(self.off_arcsec), self.step_arcsec / 12**0.5)
        return np.abs(self.off_arcsec) <= (_LIMITS.apart * size if size > 0 else np.inf)

    @property
    def turn_arcsec(self) -> float:
        """The range of the angle."""
        return float(np.ptp((self.others_arcsec + self.off_arcsec * self.size)[self.near]))

    @property
    def hidden(self) -> bool:
        """Whether rounding to the steps of the display is more than the scatter behind it: of
        both together it is then more than half, in squares."""
        return self.scatter() < self.step_arcsec / 6**0.5

    def scatter(self, u: Floats | None = None) -> float:
        """Standard deviation of a reading in arcsec, or in its stated uncertainties (shape (n,)).

        What stands far apart is no part of it, and is told by `near`."""
        take = self.near
        off = self.off_arcsec[take] / (1.0 if u is None else u[self.row[take]])
        free = len(off) - len(np.unique(self.run[take]))
        return float(np.sqrt(off @ off / free)) if free > 0 else 0.0

    @property
    def slope(self) -> tuple[Ints, Floats, float]:
        """Runs, by which share the angle grows more in each than in the others, and the scatter
        that is left without that."""
        take = self.near
        runs, run = np.unique(self.run, return_inverse=True)
        x = _less_means(self.others_arcsec, run)
        off = self.off_arcsec * self.size
        gain = np.bincount(run, x * off) / np.maximum(np.bincount(run, x**2), 1e-300)
        gain -= gain.mean()
        off = (off - gain[run] * x) / self.size
        free = max(int(take.sum()) - 2 * len(runs), 1)
        return runs, gain, float(np.sqrt(off[take] @ off[take] / free))


@dataclass(frozen=True, eq=False)
class _Line:
    """A leg by its torque: each torque once, with the mean angle and how many readings it has."""

    torque: Floats
    angle: Floats
    count: Floats

    @classmethod
    def of(cls, torque: Floats, angle: Floats) -> _Line:
        at, index = np.unique(torque, return_inverse=True)
        count = np.bincount(index).astype(np.float64)
        return cls(at, np.bincount(index, angle) / count, count)

    def at(self, torque: Floats) -> tuple[Floats, Floats]:
        """The angle between two readings, NaN beyond the ends, and its variance in that of one."""
        last = len(self.torque) - 2
        i = np.clip(np.searchsorted(self.torque, torque, side="right") - 1, 0, last)
        w = (torque - self.torque[i]) / (self.torque[i + 1] - self.torque[i])
        angle = (1 - w) * self.angle[i] + w * self.angle[i + 1]
        variance = (1 - w) ** 2 / self.count[i] + w**2 / self.count[i + 1]
        return np.where((w >= 0) & (w <= 1), angle, np.nan), variance


def compared(r: Readings, groups: list[list[Leg]], step_arcsec: float) -> Compared | None:
    """None where too little was repeated. step_arcsec: of the display of the angle, or 0."""
    if not groups:
        return None
    zero = _zeros(r, groups)
    angle = r.elastic_angle_arcsec - zero[r.run_index]
    parts = []
    for group in groups:
        lines = [_Line.of(r.torque_Nm[leg.rows], angle[leg.rows]) for leg in group]
        for j, leg in enumerate(group):
            many = min(len(group) - 1, _LIMITS.others)
            others = [lines[(j + k) % len(group)] for k in range(1, many + 1)]
            parts.append(_of_leg(leg.rows, (r.torque_Nm, angle), others))
    rows, off, mean, size = (np.concatenate(column) for column in zip(*parts, strict=True))
    row = rows.astype(np.int64)
    run = r.run_index[row]
    off = _less_means(off, run) / size
    legs = sum(map(len, groups))
    dof = sum(len(part[0]) for part in parts) * (1 - len(groups) / legs) - len(np.unique(run))
    return Compared(row, run, off, mean, size, step_arcsec) if dof >= _LIMITS.fewest else None


def _of_leg(
    rows: Ints, columns: tuple[Floats, Floats], others: list[_Line]
) -> tuple[Floats, Floats, Floats, Floats]:
    """Rows of a leg, off the mean of the others, that mean, and by how many of its own standard
    deviations a reading is off it. columns: torque and angle of the table."""
    torque, angle = (column[rows] for column in columns)
    total, variance, count = (np.zeros(len(rows)) for _ in range(3))
    for other in others:
        value, part = other.at(torque)
        here = np.isfinite(value)
        total[here] += value[here]
        variance[here] += part[here]
        count[here] += 1
    take = count > 0
    mean = total[take] / count[take]
    size = np.sqrt(1 + variance[take] / count[take] ** 2)
    return rows[take].astype(np.float64), angle[take] - mean, mean, size


def _zeros(r: Readings, groups: list[list[Leg]]) -> Floats:
    """The zero of each run against the others, arcsec: of the best mean = group + run."""
    group, run, mean = [], [], []
    for number, legs in enumerate(groups):
        ends = [(float(t.min()), float(t.max())) for t in (r.torque_Nm[leg.rows] for leg in legs)]
        low, high = max(end[0] for end in ends), min(end[1] for end in ends)
        grid = np.linspace(low, max(low, high), _LIMITS.grid)
        for leg in legs:
            line = _Line.of(r.torque_Nm[leg.rows], r.elastic_angle_arcsec[leg.rows])
            group.append(number)
            run.append(leg.run)
            mean.append(float(np.mean(np.interp(grid, line.torque, line.angle))))
    many = int(r.run_index.max()) + 1
    g, k, y = np.array(group, np.int64), np.array(run, np.int64), np.array(mean)
    zero = np.zeros(many)
    for _ in range(_LIMITS.sweeps):
        level = np.bincount(g, y - zero[k]) / np.bincount(g)
        zero = np.bincount(k, y - level[g], many) / np.maximum(np.bincount(k, minlength=many), 1)
    return zero


def _less_means(values: Floats, group: Ints) -> Floats:
    """Without the mean of each group."""
    count = np.maximum(np.bincount(group), 1)
    return values - (np.bincount(group, values) / count)[group]


def odd_runs(
    r: Readings, groups: list[list[Leg]], found: Compared
) -> tuple[list[tuple[int, float]], Compared]:
    """Runs that differ from the others by far more than those among themselves, with by how much
    in arcsec, and the others against each other: fewer than half of the runs, and none of two."""
    odd: list[tuple[int, float]] = []
    most = (len(np.unique(found.run)) - 1) // 2
    while len(odd) < most:
        runs = np.unique(found.run)
        size = np.array([typical_size(found.off_arcsec[found.run == run]) for run in runs])
        worst = int(np.argmax(size))
        if size[worst] ** 2 < _LIMITS.suspect * float(np.median(size**2)):
            break
        groups = _without(groups, int(runs[worst]))
        rest = compared(r, groups, found.step_arcsec)
        if rest is None:
            break
        if size[worst] < _LIMITS.odd * max(rest.scatter(), rest.step_arcsec / 12**0.5):
            break
        mine = found.run == runs[worst]
        odd.append((int(runs[worst]), typical_size((found.off_arcsec * found.size)[mine])))
        found = rest
    return odd, found


def _without(groups: list[list[Leg]], run: int) -> list[list[Leg]]:
    left = [[leg for leg in group if leg.run != run] for group in groups]
    return [group for group in left if len(group) > 1]
