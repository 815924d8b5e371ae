"""Where a model fails: regions of a table in which the residual stands out from the rest.

    Region          ranges of columns, what lies in them, the chance that noise shows as much
    Scanned         the table and what a model leaves of it
    find_regions    scans a table for them
    REGIMES         names of the regimes of the meshing points

A region is an interval of one column (of the input angle: an arc), a product of two, or a regime of
the meshing points, alone or at some preloads. Torques of one size to both sides are searched
together and told as a region each. Every region is asked for a shift of the residual, once as it is
read and once in the direction of the torque. What a shift of all readings alike explains counts for
no region. The statistic is the square of the whitened residual along the whitened pattern, whatever
refitting takes of it left out; the chance of the largest among all regions comes from simulated
noise through the same scan (a scan statistic, Kulldorff 1997). Further regions are what is left
once those before are taken out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Whitener
from cbpt.lab.model.forward import REGIMES as CODES
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.units import unit_at_end

__all__ = ["REGIMES", "Region", "Scanned", "find_regions"]

Floats = NDArray[np.float64]
Columns = NDArray[np.floating[Any]]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

REGIMES = tuple(str(name) for name in CODES[:3])


@dataclass(frozen=True)
class _Limits:
    """Numbers of the scan."""

    cells: int = 7
    runs: int = 16
    fewest: int = 3
    most: int = 5
    limit: float = 0.05
    seen: float = 1e-3
    """Of a pattern's square this much has to survive refitting, or it cannot be seen."""
    told: float = 0.4
    """A region that has more of its misfit than this in those before it tells the same again."""
    equal: float = 0.999
    """As telling as this against the best is taken as equal: a part of a column, and the rest
    of it.
    """


_LIMITS = _Limits()

_PRODUCTS = (
    ("torque_Nm", "preload_N"),
    ("torque_Nm", "input_angle_deg"),
    ("torque_Nm", "direction"),
    ("torque_Nm", "time_s"),
    ("torque_size", "preload_N"),
    ("torque_size", "input_angle_deg"),
    ("torque_size", "direction"),
    ("torque_size", "time_s"),
    ("preload_N", "input_angle_deg"),
    ("regime", "preload_N"),
)
DIRECTIONS = {1: "rising", 0: "held", -1: "falling"}
"""What the torque does, by the values of `direction`."""


@dataclass(frozen=True, eq=False)
class Region:
    """Readings among which the residual stands out."""

    ranges: dict[str, tuple[float, float]]
    """Lowest and highest value of each column that bounds it, both included: `torque_Nm`,
    `preload_N`, `input_angle_deg` (counted on past 360 where it passes the end of a turn),
    `direction` (+1 rising, 0 held, -1 falling), `time_s`, `run` (its label, or its place in the
    table where labels are text)."""
    regime: str | None
    """One of `REGIMES`, or None where it is not bounded by a regime."""
    rows: Mask = field(repr=False)
    """The readings in it, shape (n,)."""
    share_of_misfit: float
    """Its part of the sum of squared residuals of all readings, 0 to 1."""
    bias_arcsec: float
    """Mean residual."""
    excess_arcsec: float
    """Mean residual in the direction of the torque; above 0 the drive is softer than the model."""
    p_value: float
    """Chance that noise alone, refitted the same way, shows any region standing out this much."""

    @property
    def readings(self) -> int:
        """How many readings are in it."""
        return int(np.count_nonzero(self.rows))

    @property
    def label(self) -> str:
        """Its bounds for people: `torque 4 to 8 N m, input angle 130 deg`."""
        return label_of(self.ranges, self.regime)

    def within(
        self, readings: Readings, residual_arcsec: Floats, regime: NDArray[np.str_], solved: Mask
    ) -> Region:
        """The same bounds in a larger table, of which only the rows `solved` count."""
        rows = solved.copy()
        if self.regime is not None:
            rows &= regime == self.regime
        columns = {"direction": readings.direction(), "run": _run_values(readings)}
        if readings.preload_step is not None:
            columns["preload_step"] = _step_values(readings)
        for column, (low, high) in self.ranges.items():
            values = columns[column] if column in columns else getattr(readings, column)
            if column == "input_angle_deg":
                values = low + np.mod(values - low, 360.0)
            rows &= (values >= low) & (values <= high)
        return _region(self.ranges, self.regime, rows, residual_arcsec, readings, self.p_value)

    def to_dict(self) -> dict[str, Any]:
        """As in the JSON document."""
        return {
            "region": {column: list(ends) for column, ends in self.ranges.items()},
            "regime": self.regime,
            "readings": self.readings,
            "share_of_misfit": self.share_of_misfit,
            "bias_arcsec": self.bias_arcsec,
            "excess_arcsec": self.excess_arcsec,
            "p_value": self.p_value,
        }


def label_of(ranges: Mapping[str, tuple[float, float]], regime: str | None) -> str:
    """Bounds for people."""
    parts = [_range_text(column, *ends) for column, ends in ranges.items()]
    return ", ".join(parts + ([regime] if regime else []))


def _range_text(column: str, low: float, high: float) -> str:
    if column == "direction":
        first, last = DIRECTIONS[int(low)], DIRECTIONS[int(high)]
        return f"torque {first}" if first == last else f"torque {first} or {last}"
    unit = unit_at_end(column)
    name = column.removesuffix(f"_{unit.symbol}") if unit else column
    near = abs(high - low) <= 0.005 * max(abs(low), abs(high))
    value = f"{(low + high) / 2 if low != high else low:.4g}"
    # For people an arc ends inside the turn.
    end = high - 360 if column == "input_angle_deg" and high > 360 else high
    text = value if near else f"{low:.4g} to {end:.4g}"
    return f"{name.replace('_', ' ')} {text} {unit.written if unit else ''}".rstrip()


@dataclass(frozen=True, eq=False)
class Scanned:
    """A table of n readings and what a model leaves of it."""

    readings: Readings
    residual_arcsec: Floats
    """Reading minus model, finite, shape (n,)."""
    whitener: Whitener
    """The noise."""
    free: Floats
    """Whitened columns (n, p) of what was refitted, offsets too; p may be 0."""
    regime: Sequence[str] | NDArray[np.str_] | None = None
    """Of each reading, one of `REGIMES` (others count for none); None where it is not known."""


def find_regions(
    scanned: Scanned,
    rng: np.random.Generator,
    replicates: int = 400,
    *,
    limit: float = _LIMITS.limit,
    most: int = _LIMITS.most,
) -> tuple[Region, ...]:
    """Regions in which the residual stands out, the most telling first; none where it is noise.

    limit: a region with a larger p-value is not told. most: as many regions as this are told.
    """
    scan = _Scan(scanned)
    if not scan.blocks:
        return ()
    null = scan.null(rng, replicates)
    found: list[Region] = []
    for best in scan.search(most):
        p_value = (1 + np.count_nonzero(null >= best.score)) / (1 + replicates)
        if p_value >= limit:
            break
        found += scan.regions(best, float(p_value))
    return tuple(found[:most])


# --- axes and regions ---------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Axis:
    """A column cut into cells."""

    column: str
    values: Floats
    cell: Ints
    cells: int
    turn: bool = False
    """The column closes on itself."""
    apart: bool = False
    """Cells are kinds, not neighbours: no two make an interval. Values below 0 are unknown."""

    @cached_property
    def intervals(self) -> Mask:
        """Cells of every interval but that of all, shape (m, cells)."""
        k = self.cells
        if self.apart:
            known = np.unique(self.cell[self.values >= 0])
            return np.eye(k, dtype=bool)[known]
        lengths = range(1, k)
        spans = [
            (start, length)
            for length in lengths
            for start in range(k)
            if self.turn or start + length <= k
        ]
        at = np.arange(k)
        return np.array([((at - start) % k) < length for start, length in spans]).reshape(-1, k)

    def ends(self, rows: Mask) -> tuple[float, float]:
        """Lowest and highest value among the rows, of an arc in the order of the turn."""
        values = self.values[rows]
        if self.turn:
            # The arc starts after the widest gap that it leaves.
            exact = np.unique(values)
            gap = int(np.argmax(np.diff(exact, append=exact[0] + 360.0)))
            start = exact[(gap + 1) % len(exact)]
            values = start + np.mod(values - start, 360.0)
        # Adding 0 turns -0 into 0.
        return float(values.min()) + 0.0, float(values.max()) + 0.0


def _axes(readings: Readings, regime: Ints | None) -> dict[str, _Axis]:
    r = readings
    found = [_numbers("torque_Nm", r.torque_Nm)]
    if r.torque_Nm.min() < 0 < r.torque_Nm.max():
        found.append(_numbers("torque_size", np.abs(r.torque_Nm)))
    if r.preload_N is not None:
        found.append(_numbers("preload_N", r.preload_N))
    if r.preload_step is not None:
        found.append(_steps(r))
    found.append(_angle(r.input_angle_deg))
    found.append(_kinds("direction", r.direction()))
    if r.time_s is not None:
        found.append(_numbers("time_s", r.time_s))
    found.append(_runs(r))
    if regime is not None:
        found.append(_kinds("regime", regime, apart=True))
    return {axis.column: axis for axis in found if axis.cells > 1}


def _numbers(column: str, values: Floats, most: int = _LIMITS.cells) -> _Axis:
    """Levels, or where there are many as many neighbours together as make cells of equal range."""
    levels = levels_of(values)
    cell = _merged(levels.value, most)[levels.index]
    return _Axis(column, values, cell, int(cell.max(initial=-1)) + 1)


def _merged(levels: Floats, most: int) -> Ints:
    """Levels, rising, in at most `most` cells; about 0 alike to either side, with 0 on its own."""
    k = len(levels)
    if k <= most:
        return np.arange(k)
    below, above = (int(np.count_nonzero(side)) for side in (levels < 0, levels > 0))
    if not below or not above:
        return np.asarray(np.arange(k) * most // k)
    # Counted from 0 outwards: both sides are cut at the same sizes where they have the same.
    half = most // 2
    left = -1 - np.arange(below)[::-1] * min(half, below) // below
    right = 1 + np.arange(above) * min(half, above) // above
    cell = np.r_[left, np.zeros(k - below - above), right]
    return np.unique(cell, return_inverse=True)[1].astype(np.int64)


def _angle(angle_deg: Floats) -> _Axis:
    """Arcs of a turn, from the widest gap on."""
    wrapped = np.mod(angle_deg, 360.0)
    exact = np.unique(wrapped)
    if not len(exact):
        return _Axis("input_angle_deg", wrapped, np.zeros(0, dtype=np.int64), 0)
    gap = int(np.argmax(np.diff(exact, append=exact[0] + 360.0)))
    origin = exact[(gap + 1) % len(exact)]
    turned = _numbers("", np.mod(wrapped - origin, 360.0))
    return _Axis("input_angle_deg", wrapped, turned.cell, turned.cells, turn=turned.cells > 2)


def _kinds(column: str, values: Ints, apart: bool = False) -> _Axis:
    exact, cell = np.unique(values, return_inverse=True)
    return _Axis(column, values.astype(np.float64), cell.astype(np.int64), len(exact), apart=apart)


def _runs(readings: Readings) -> _Axis:
    index = readings.run_index
    runs = int(index.max(initial=-1)) + 1
    values = _run_values(readings)
    count = min(runs, _LIMITS.runs)
    order = np.argsort(np.argsort(_first_values(values, index, runs)))
    cell = (order * count // max(runs, 1))[index] if runs else index
    return _Axis("run", values, cell, count)


def _steps(readings: Readings) -> _Axis:
    """Steps of the preload are kinds: that they rise with it is not known."""
    values = _step_values(readings)
    _, cell = np.unique(values, return_inverse=True)
    cells = int(cell.max(initial=-1)) + 1
    return _Axis("preload_step", values, cell.astype(np.int64), cells, apart=True)


def _step_values(readings: Readings) -> Floats:
    """Labels where they are numbers, else their places in the alphabet."""
    assert readings.preload_step is not None
    steps = readings.preload_step
    if np.issubdtype(steps.dtype, np.number):
        return np.asarray(steps, dtype=np.float64)
    return np.asarray(np.unique(steps, return_inverse=True)[1] + 1, dtype=np.float64)


def _run_values(readings: Readings) -> Floats:
    """Labels where they are numbers, else places in the table."""
    numbers = np.issubdtype(readings.run.dtype, np.number)
    return np.asarray(readings.run if numbers else readings.run_index + 1, dtype=np.float64)


def _first_values(values: Floats, index: Ints, runs: int) -> Floats:
    first = np.zeros(runs)
    first[index] = values
    return first


# --- the scan -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Block:
    """All regions over one or two axes, and one way of shifting.

    cell: of each reading, (n,), the second axis running fastest; patterns: (n, cells), whitened and
    with what is refitted taken off; inverse: one over the squared length of each region's pattern,
    (regions,), 0 where it cannot be seen.
    """

    axes: tuple[_Axis, ...]
    signed: bool
    cell: Ints
    patterns: Floats
    inverse: Floats

    def over(self, cells: Columns) -> Columns:
        """Values of cells (cells, m) added up over every region, (regions, m), axis by axis."""
        first, rest = self.axes[0].intervals, self.axes[1:]
        m = cells.shape[1]
        sums = first.astype(cells.dtype) @ cells.reshape(first.shape[1], -1)
        for axis in rest:
            sums = axis.intervals.astype(cells.dtype) @ sums.reshape(len(first), -1, m)
        return np.asarray(sums.reshape(-1, m))

    def sums(self, values: Floats | Mask) -> Floats:
        """Values of readings (n,) added up over every region, (regions,)."""
        cells = np.bincount(self.cell, values, self.patterns.shape[1])
        return np.asarray(self.over(cells.astype(np.float64)[:, None])[:, 0])

    def shifts(self, columns: Columns) -> Columns:
        """Squares explained in whitened columns (n, m), shape (regions, m)."""
        along = self.over(self.patterns.T.astype(columns.dtype) @ columns)
        along *= along
        along *= self.inverse.astype(columns.dtype)[:, None]
        return along

    def held(self, place: int) -> Mask:
        """The cells of one region."""
        if len(self.axes) == 1:
            return np.asarray(self.axes[0].intervals[place])
        first, second = (axis.intervals for axis in self.axes)
        a, b = divmod(place, len(second))
        return np.outer(first[a], second[b]).reshape(-1)


@dataclass(frozen=True)
class _Best:
    """One region of one block, and its score."""

    block: _Block
    place: int
    score: float
    rows: Mask


class _Scan:
    """All regions of one table, through one noise and one refit."""

    def __init__(self, scanned: Scanned) -> None:
        readings, residual_arcsec = scanned.readings, scanned.residual_arcsec
        whitener, free, regime = scanned.whitener, scanned.free, scanned.regime
        self.readings, self.residual = readings, residual_arcsec
        self.n = len(readings)
        self.sign = np.sign(readings.torque_Nm)
        self.misfit = (residual_arcsec * whitener.inverse) ** 2
        self.codes = None if regime is None else _codes(regime)
        alike = np.column_stack([np.ones(self.n), self.sign])
        self.free = _basis(np.column_stack([free.reshape(self.n, -1), whitener(alike)]))
        self.seen = self.left(whitener(residual_arcsec[:, None]))[:, 0]
        self.blocks = (
            list(self._blocks(whitener)) if self.n - self.free.shape[1] >= _LIMITS.fewest else []
        )

    def left(self, columns: Floats) -> Floats:
        """Whitened columns once everything is refitted."""
        return np.asarray(columns - self.free @ (self.free.T @ columns))

    def _blocks(self, whitener: Whitener) -> Iterator[_Block]:
        axes = _axes(self.readings, self.codes)
        singles = [(axis,) for axis in axes.values()]
        pairs = [(axes[a], axes[b]) for a, b in _PRODUCTS if a in axes and b in axes]
        both_ways = self.sign.min() < 0 < self.sign.max()
        for group in [*singles, *pairs]:
            cell, member = _cells(group), _member(group)
            one_hot = np.eye(member.shape[1])[cell]
            # Of two sides at least one is told.
            fewest = 2 * _LIMITS.fewest if group[0].column == "torque_size" else _LIMITS.fewest
            enough = member @ one_hot.sum(axis=0) >= fewest
            for signed in (False, True) if both_ways else (False,):
                columns = whitener(one_hot * self.sign[:, None] if signed else one_hot)
                patterns = self.left(columns)
                size = _squares(member, patterns)
                seen = enough & (size > _LIMITS.seen * _squares(member, columns)) & (size > 0)
                inverse = np.where(seen, 1 / np.where(seen, size, 1.0), 0.0)
                yield _Block(group, signed, cell, patterns, inverse)

    def null(self, rng: np.random.Generator, replicates: int) -> Floats:
        """The largest score in each of many sets of noise."""
        noise = self.left(rng.standard_normal((self.n, replicates))).astype(np.float32)
        largest = [block.shifts(noise).max(axis=0) for block in self.blocks]
        return np.asarray(np.max(largest, axis=0), dtype=np.float64)

    def search(self, most: int) -> Iterator[_Best]:
        """Regions one after the other, each in what those before leave."""
        left, taken = self.seen, np.zeros((self.n, 0))
        told = np.zeros(self.n, dtype=bool)
        for _ in range(most):
            best = self._best(left, told)
            if best is None or best.score <= 0:
                return
            yield best
            told |= best.rows
            pattern = best.block.patterns @ best.block.held(best.place)
            taken = np.column_stack([taken, pattern])
            basis = _basis(taken)
            left = self.seen - basis @ (basis.T @ self.seen)

    def _best(self, left: Floats, told: Mask) -> _Best | None:
        scored = [(block, self._allowed(block, left, told)) for block in self.blocks]
        top = max(float(scores.max()) for _, scores in scored)
        if top <= 0:
            return None
        # Of equals the smallest: it says where, the larger one says where not.
        equals = [
            _Best(block, int(i), float(scores[i]), block.held(int(i))[block.cell])
            for block, scores in scored
            for i in np.flatnonzero(scores >= _LIMITS.equal * top)
        ]
        return min(equals, key=lambda b: (np.count_nonzero(b.rows), len(b.block.axes)))

    def _allowed(self, block: _Block, left: Floats, told: Mask) -> Floats:
        """Scores, 0 where the model fails no more than elsewhere, or where it has been told."""
        scores = np.array(block.shifts(left[:, None])[:, 0], dtype=np.float64)
        misfit, within = block.sums(self.misfit), block.sums(np.ones(self.n))
        scores[misfit * self.n < (1 - 1e-9) * self.misfit.sum() * within] = 0.0
        scores[block.sums(self.misfit * told) > _LIMITS.told * misfit] = 0.0
        return scores

    def regions(self, best: _Best, p_value: float) -> Iterator[Region]:
        """The region; where it is a size of the torque without 0, one for each side."""
        sides = [best.rows]
        if best.block.axes[0].column == "torque_size" and self.sign[best.rows].all():
            sides = [best.rows & (self.sign == side) for side in (1, -1)]
        sides = [rows for rows in sides if np.count_nonzero(rows) >= _LIMITS.fewest]
        told = [rows for rows in sides if self.misfit[rows].mean() >= self.misfit.mean()]
        for rows in sorted(told or sides, key=lambda rows: -float(self.misfit[rows].sum())):
            yield self._region(best, rows, p_value)

    def _region(self, best: _Best, rows: Mask, p_value: float) -> Region:
        ranges: dict[str, tuple[float, float]] = {}
        regime = None
        for axis in best.block.axes:
            if axis.column == "regime":
                regime = REGIMES[int(axis.values[rows][0])]
            elif axis.column == "torque_size":
                torque = self.readings.torque_Nm[rows]
                ranges["torque_Nm"] = float(torque.min()), float(torque.max())
            elif len(np.unique(axis.cell[rows])) < axis.cells:
                ranges[axis.column] = axis.ends(rows)
        return _region(ranges, regime, rows, self.residual, self.readings, p_value)


def _region(
    ranges: dict[str, tuple[float, float]],
    regime: str | None,
    rows: Mask,
    residual: Floats,
    readings: Readings,
    p_value: float,
) -> Region:
    inside, signs = residual[rows], np.sign(readings.torque_Nm[rows])
    total = float(residual @ residual)
    return Region(
        ranges=ranges,
        regime=regime,
        rows=rows,
        share_of_misfit=float(inside @ inside) / total if total else 0.0,
        bias_arcsec=float(inside.mean()),
        excess_arcsec=float(inside @ signs) / max(int(np.count_nonzero(signs)), 1),
        p_value=p_value,
    )


def _codes(regime: Sequence[str] | NDArray[np.str_]) -> Ints:
    names = {name: code for code, name in enumerate(REGIMES)}
    return np.array([names.get(str(name), -1) for name in regime], dtype=np.int64)


def _cells(axes: Sequence[_Axis]) -> Ints:
    """Of each reading, among the cells of one axis or of the product of two."""
    if len(axes) == 1:
        return axes[0].cell
    return np.asarray(axes[0].cell * axes[1].cells + axes[1].cell)


def _member(axes: Sequence[_Axis]) -> Floats:
    """1 where a region holds a cell, shape (regions, cells)."""
    parts = [axis.intervals.astype(np.float64) for axis in axes]
    return parts[0] if len(parts) == 1 else np.asarray(np.kron(*parts), dtype=np.float64)


def _squares(member: Floats, patterns: Floats) -> Floats:
    """Squared length of each region's pattern."""
    return np.asarray(np.sum((member @ (patterns.T @ patterns)) * member, axis=1))


def _basis(columns: Floats) -> Floats:
    """Orthonormal columns that span the same."""
    u, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)])
