"""The scatter of readings, estimated from themselves, to be held against what is stated.

    Scatter         standard deviation and correlation inside the runs, and how well they are known
    estimate        from the residuals of a model, right or wrong
    display_step    the step of a display
    written_step    the last digit of a table
    behind_display  what is known of a scatter behind one

A model that is wrong is so smoothly: along a few readings of one run that follow each other in one
direction of the torque a parabola takes its error away, and what is left is scatter. A stretch may
hold a kink: what counts is the median over those that vary no more than chance lets them. Where a
loop bends within a few readings most long stretches do, and short ones scatter less.
Readings that come in steps coarser than they scatter round alike or far apart, and what rounding
leaves inside a few of them may be far less than the step's own uncertainty: then the scatter is
taken to be no less than that, and hardly known.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.results import ARCSEC_PER_RAD

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class _Limits:
    """Numbers of the estimate."""

    longest: int = 10
    nearer: int = 5
    """Readings in a stretch, and in one that a bend reaches less often."""
    alike: tuple[float, float] = (0.87, 1.15)
    """Ratios of two scatters between which they are called alike."""
    fewest_dof: int = 6
    stretches: int = 400
    correlations: tuple[float, ...] = (0.0, 0.2, 0.4, 0.6, 0.8)
    kinked: float = 2.6
    """A stretch whose variance is further above the typical one than this, in standard
    deviations, holds more than scatter.
    """
    price: float = 3.0
    """What a correlation has to gain in log-likelihood."""
    fewest_of_median: int = 24
    """Degrees of freedom from which on the typical variance is a median. Of fewer it may be far
    less than their mean by chance, and then those that are not are taken for kinks.
    """
    efficiency: float = 0.6
    """A median of variances is known as well as a mean of this share of the degrees of
    freedom.
    """
    hidden_dof: float = 3.0
    """Degrees of freedom behind a scatter that a coarse display hides."""
    coarse: float = 1.5
    """A display is coarse from so many standard deviations a step."""
    finest: float = 12.0
    """Rounding leaves more than this part of a step; what follows a curve closer is no
    display's.
    """


_LIMITS = _Limits()


@dataclass(frozen=True)
class Scatter:
    """How readings scatter inside their runs."""

    u_arcsec: float
    """Standard deviation of the typical reading (with a stated uncertainty: of the median one)."""
    ratio: float | None
    """To the stated uncertainty; None where there is none."""
    dof: float
    """How well it is known, as degrees of freedom."""
    correlation: float
    """Of a reading with the next of its run, 0 where none is seen."""
    step_arcsec: float = 0.0
    """Step of the display where it hides the scatter, else 0."""
    nearer: Scatter | None = None
    """The same from shorter stretches, which a bend of the readings does not reach as often."""

    def to_dict(self) -> dict[str, float | None]:
        """As plain values."""
        found = asdict(self)
        del found["nearer"]
        return found

    @property
    def off(self) -> bool:
        """Whether the stated uncertainty cannot be right."""
        if self.ratio is None or not self._is_off:
            return False
        # A bend adds to the scatter along a long stretch, and takes nothing from it.
        nearer = self.nearer if self.ratio > 1 else None
        return nearer is None or nearer.ratio is None or (nearer.ratio > 1 and nearer._is_off)

    @property
    def alike(self) -> bool:
        """Whether it is about what is stated."""
        low, high = _LIMITS.alike
        return self.ratio is not None and low < self.ratio < high

    @property
    def _is_off(self) -> bool:
        assert self.ratio is not None
        if self.correlation > 0:
            # What is correlated is poorly known; only a large difference counts.
            return not 0.4 < self.ratio < 2.5
        from scipy.special import chdtrc

        above = float(chdtrc(self.dof, self.dof * self.ratio**2))
        return min(above, 1 - above) < 0.005 and not self.alike


def estimate(
    readings: Readings, residual_arcsec: Floats, correlation: float | None = None
) -> Scatter | None:
    """Residuals finite, shape (n,). None where too few readings follow each other.

    correlation: of a reading with the next of its run, where it is known; else it is estimated.
    """
    u = readings.u_elastic_angle_arcsec
    weighted = residual_arcsec if u is None else residual_arcsec / u
    step = display_step(readings.elastic_angle_arcsec)
    longer = _along(readings, weighted, _LIMITS.longest, correlation)
    if longer is None:
        return None
    nearer = _along(readings, weighted, _LIMITS.nearer, longer.correlation)
    return replace(longer.of(u, step), nearer=None if nearer is None else nearer.of(u, step))


@dataclass(frozen=True)
class _Along:
    """The scatter along stretches of one length, in the unit of the values."""

    scale: float
    dof: float
    correlation: float

    def of(self, u_arcsec: Floats | None, step_arcsec: float) -> Scatter:
        """Of readings with stated uncertainties, behind a display with steps."""
        typical = 1.0 if u_arcsec is None else float(np.median(u_arcsec))
        scatter = self.scale * typical
        step = step_arcsec if step_arcsec < _LIMITS.finest * scatter else 0.0
        seen, known, hidden = behind_display(scatter, self.dof, step)
        along, step = (0.0, step) if hidden else (self.correlation, 0.0)
        return Scatter(seen, None if u_arcsec is None else seen / typical, known, along, step)


def _along(
    readings: Readings, values: Floats, longest: int, correlation: float | None
) -> _Along | None:
    groups = _by_length(_stretches(readings, longest))
    dof = sum(rows.shape[0] * _free(rows.shape[1]) for rows in groups)
    if dof < _LIMITS.fewest_dof:
        return None
    smooth = _smooth(groups, values)
    if correlation is None:
        tried = _LIMITS.correlations
        gains = [_rated(smooth, values, c)[0] - _LIMITS.price * (c > 0) for c in tried]
        correlation = tried[int(np.argmax(gains))]
    scale = float(np.sqrt(_typical(_rated(smooth, values, correlation)[1], smooth)))
    # What is correlated is fewer independent readings, and the parabola takes more of it away.
    known = dof * _LIMITS.efficiency * ((1 - correlation) / (1 + correlation)) ** 2
    return _Along(scale, known, correlation)


def behind_display(scatter: float, dof: float, step: float) -> tuple[float, float, bool]:
    """A scatter and its degrees of freedom where readings come in steps: where those hide it, no
    less than what rounding makes, and hardly known; and whether they do."""
    if step <= _LIMITS.coarse * scatter:
        return scatter, dof, False
    return max(scatter, step / 12**0.5), min(dof, _LIMITS.hidden_dof), True


def display_step(values: Floats) -> float:
    """The step that all values are whole multiples of, 0 where there is none to be seen."""
    found = np.unique(np.round(values, 9))
    # A step that hardly any two readings share is that of the digits in the table.
    if len(found) < 3 or len(found) > 0.7 * len(values):
        return 0.0
    # Digits of the table may round the multiples once more, so the step is refined on them.
    step = float(np.diff(found).min())
    step = float(np.ptp(found)) / max(round(float(np.ptp(found)) / step), 1)
    off = (found - found[0]) / step
    return step if np.abs(off - np.round(off)).max() < 0.05 else 0.0


def written_step(values_arcsec: Floats) -> float:
    """One of the last digit in which a table states all angles, in any unit; 0 where there are more
    digits than matter."""
    decimal = 10.0 ** np.arange(2, -7, -1)
    most = float(np.ptp(values_arcsec))
    units = np.array([1.0, 60.0, 3600.0, ARCSEC_PER_RAD])
    for step in sorted(np.outer(units, decimal).ravel(), reverse=True):
        off = values_arcsec / step
        if step <= most and np.abs(off - np.round(off)).max() < 1e-5:
            return float(step)
    return 0.0


def _stretches(readings: Readings, longest: int) -> list[Ints]:
    """Rows that follow each other in one run, direction and sign of the torque; evenly spread
    ones where there are more than are needed."""
    order = np.argsort(readings.run_index, kind="stable")
    run = readings.run_index[order]
    torque = levels_of(readings.torque_Nm).held[order]
    same = np.diff(run) == 0
    way = np.sign(np.r_[0.0, np.where(same, np.diff(torque), 0.0)])
    first = np.r_[True, ~same]
    leads = np.flatnonzero(first[:-1] & ~first[1:])
    way[leads] = way[leads + 1]
    side = np.sign(torque)
    # A reading without torque ends the side it comes from.
    side = np.where((side == 0) & ~first, np.r_[0.0, side[:-1]], side)
    turned = (np.diff(way) != 0) | ((np.diff(side) != 0) & (side[:-1] != 0))
    ends = np.r_[np.flatnonzero(~same | turned) + 1, len(order)]
    sizes = np.diff(ends, prepend=0)
    pieces = -(-sizes // longest)
    part = np.repeat(np.arange(len(sizes)), pieces)
    place = np.arange(len(part)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    if len(part) > _LIMITS.stretches:
        chosen = np.linspace(0, len(part) - 1, _LIMITS.stretches).round().astype(int)
        part, place = part[chosen], place[chosen]
    return [
        np.array_split(order[ends[p] - sizes[p] : ends[p]], pieces[p])[k]
        for p, k in zip(part.tolist(), place.tolist(), strict=True)
    ]


def _free(length: int) -> int:
    """Degrees of freedom that a stretch has beside its line or parabola."""
    return max(length - (3 if length >= 5 else 2), 0)


def _by_length(stretches: list[Ints]) -> list[Ints]:
    """Stretches of one length as rows of one array; those too short left out."""
    found: dict[int, list[Ints]] = {}
    for rows in stretches:
        if _free(len(rows)):
            found.setdefault(len(rows), []).append(rows)
    return [np.array(found[length]) for length in sorted(found)]


def _smooth(groups: list[Ints], values: Floats) -> list[Ints]:
    """Stretches without those that hold more than scatter."""
    _, variances = _rated(groups, values, 0.0)
    for _ in range(6):
        typical = _typical(variances, groups)
        kept = []
        for rows, v in zip(groups, variances, strict=True):
            part = 2 / (9 * _free(rows.shape[1]))
            kept.append(v <= typical * (1 - part + _LIMITS.kinked * part**0.5) ** 3)
        if all(k.all() for k in kept):
            break
        groups = [rows[k] for rows, k in zip(groups, kept, strict=True)]
        variances = [v[k] for v, k in zip(variances, kept, strict=True)]
    return groups


def _rated(groups: list[Ints], values: Floats, correlation: float) -> tuple[float, list[Floats]]:
    """Restricted log-likelihood, each stretch with its own variance; those variances."""
    total, variances = 0.0, []
    for rows in groups:
        length, free = rows.shape[1], _free(rows.shape[1])
        trend = np.vander(np.linspace(-1, 1, length), length - free)
        trend, y = _whitened(trend, correlation), _whitened(values[rows].T, correlation)
        q, r = np.linalg.qr(trend)
        left = np.sum((y - q @ (q.T @ y)) ** 2, axis=0)
        # Stretches without any scatter have no likelihood; rounding is the least there can be.
        left = np.maximum(left, max(1e-12 * float(left.sum()), 1e-300))
        volume = np.log(np.abs(np.diag(r))).sum() + 0.5 * (length - 1) * np.log1p(-(correlation**2))
        total -= float(0.5 * free * np.log(left).sum() + len(rows) * volume)
        variances.append(left / free)
    return total, variances


def _whitened(columns: Floats, correlation: float) -> Floats:
    rest = (columns[1:] - correlation * columns[:-1]) / np.sqrt(1 - correlation**2)
    return np.concatenate([columns[:1], rest])


def _typical(variances: list[Floats], groups: list[Ints]) -> float:
    """Median of the variances by their degrees of freedom, as an estimate of their mean."""
    free = np.concatenate([np.full(len(g), float(_free(g.shape[1]))) for g in groups])
    values = np.concatenate(variances)
    if free.sum() < _LIMITS.fewest_of_median:
        return float(np.average(values, weights=free))
    # Wilson and Hilferty: the median of chi-squared is (1 - 2/(9 d))^3 of its mean.
    values = values / (1 - 2 / (9 * free)) ** 3
    order = np.argsort(values)
    half = np.searchsorted(np.cumsum(free[order]), free.sum() / 2)
    return float(values[order][half])
