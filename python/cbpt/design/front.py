"""Designs of which none is better in two objectives: elastic angle against friction torque or wear.

    pareto_front  a case and bounds -> ParetoFront
    ParetoFront   the designs, as text, JSON, CSV and picture

The front by the constraint method (Haimes, Lasdon and Wismer 1971): the ends are the best designs
by either objective; between them one is made small while the other has a limit, at limits that
divide its range evenly, by their logarithms. Each run is one of `optimise`, with its limits and its
polish, and begins at the end that keeps every such limit; so a front may have any shape. What
another design beats in both objectives is left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.design.bounds import Bounds, Limit
from cbpt.design.judge import bare_drive_note, left_out, nominal_parts_note, shown
from cbpt.design.optimise import OBJECTIVES, Optimum, Search, searched
from cbpt.errors import InvalidInputError
from cbpt.figures.front import draw_front
from cbpt.lab.wording import layout
from cbpt.lab.wording.html import Reported
from cbpt.results import ANGLE_UNITS

__all__ = ["ParetoFront", "pareto_front"]

Floats = NDArray[np.float64]

POINTS = 9
MOST_POINTS = 100
_UNITS = {"elastic_angle": "arcsec", "friction_torque": "N m", "wear": "N m per turn"}
# A limit at the end of the front is this share wider than the least value itself.
_ROOM = 1e-6


@dataclass(frozen=True, eq=False)
class ParetoFront(Reported):
    """Designs of which none is better in both objectives, by the first one from its least value."""

    case: Case
    """The case as it was."""
    objectives: tuple[str, str]
    points: tuple[Optimum, ...]
    """The designs; empty where none keeps the bounds."""
    nearest: Optimum | None
    """Where there is none: the nearest to the bounds."""
    beaten: int
    """Runs whose design another one beats in both objectives, or that found none."""
    seed: int
    source: str = field(repr=False, default="")

    @property
    def values(self) -> Floats:
        """Both objectives of each design, arcsec, N m or N m per turn; shape (n, 2)."""
        found = [[_value(point, name) for name in self.objectives] for point in self.points]
        return np.array(found, dtype=np.float64).reshape(-1, 2)

    @property
    def before(self) -> tuple[float | None, float | None]:
        """Both objectives of the case as it was; None without a solution."""
        one = self.points[0] if self.points else self.nearest
        if one is None:
            return None, None
        first, second = (_before(one, name) for name in self.objectives)
        return first, second

    def to_dict(self) -> dict[str, Any]:
        """The document: plain types, JSON-safe."""
        return {
            "objectives": list(self.objectives),
            "before": list(self.before),
            "points": [point.to_dict() for point in self.points],
            "nearest": None if self.nearest is None else self.nearest.to_dict(),
            "beaten": self.beaten,
            "seed": self.seed,
            "not_counted": left_out(self.case),
        }

    def to_json(self) -> str:
        """`to_dict` as JSON text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def to_csv(self) -> str:
        """A row for each design: angle, friction, and every free number in its usual unit."""
        keys = [shown(name, 0.0)[0] for name in (self.points[0].numbers if self.points else {})]
        heads = ["elastic_angle_arcsec", "friction_torque_Nm", "efficiency", "wear_Nm_per_turn"]
        lines = [",".join([*heads, *keys])]
        for point in self.points:
            costs = [point.after_arcsec, *(point.friction[name] for name in heads[1:])]
            free = [shown(name, now)[1] for name, (_, now) in point.numbers.items()]
            lines.append(",".join("" if v is None else repr(float(v)) for v in [*costs, *free]))
        return "\n".join(lines) + "\n"

    def _in(self, angle_unit: str) -> tuple[list[str], Floats]:
        """Names with units, and what of each is one in the unit of the designs."""
        units = _UNITS | {"elastic_angle": angle_unit}
        names = [f"{name.replace('_', ' ')} ({units[name]})" for name in self.objectives]
        sizes = [ANGLE_UNITS[angle_unit] if n == "elastic_angle" else 1.0 for n in self.objectives]
        return names, np.array(sizes)

    def report(self, angle_unit: str = "arcsec") -> str:
        """Text for a terminal."""
        c, (names, sizes) = self.case, self._in(angle_unit)
        lines = [
            f"Designs of which none is better in both {' and '.join(names)}, at {c.torque_Nm:g} "
            f"N m, input angle {c.input_angle_deg or 0:g} deg"
        ]
        if self.nearest is not None:
            lines.append(f"No design meets the limits of {self.source}; the nearest one violates:")
            lines += [f"  {sentence}" for sentence in self.nearest.violated]
            return "\n".join(lines)
        keys = [shown(name, 0.0)[0] for name in self.points[0].numbers]
        rows: list[list[Any]] = [
            [*pair, *(shown(name, now)[1] for name, (_, now) in point.numbers.items())]
            for pair, point in zip(self.values * sizes, self.points, strict=True)
        ]
        lines.append(layout.table([*names, *keys], rows))
        told = [
            "no solution" if value is None else f"{value * one:.6g}"
            for value, one in zip(self.before, sizes, strict=True)
        ]
        lines.append(f"The original case: {names[0]} {told[0]}, {names[1]} {told[1]}.")
        designs = sum(point.designs for point in self.points)
        lines.append(f"{designs} designs computed for these points, seed {self.seed}.")
        lines += bare_drive_note(self.case, "the designs are")
        lines += nominal_parts_note(self.case, "the designs are")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.report()

    def plot(self, path: str | PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw the front with the case as it was, to a file (SVG, PNG or PDF by its ending). Needs
        matplotlib."""
        names, sizes = self._in(angle_unit)
        was = [np.nan if value is None else value for value in self.before]
        draw_front(self.values * sizes, np.array(was) * sizes, (names[0], names[1]), path)


def pareto_front(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    bounds: str | PathLike[str] | Mapping[str, Any] | Bounds,
    objectives: tuple[str, str] = ("elastic_angle", "friction_torque"),
    *,
    points: int = POINTS,
    torque_Nm: float | None = None,
    preload_N: float | None = None,
    input_angle_deg: float | None = None,
    seed: int = 0,
    progress: Callable[[int, int], object] | None = None,
) -> ParetoFront:
    """Designs within bounds of which none is better in both of two objectives.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The design to start from. Numbers that are not free keep its values.
    bounds : Bounds, str, PathLike or dict
        What may change (`[free]`) and what must be kept (`[limits]`), as for `optimise`.
    objectives : tuple of str
        Two of `elastic_angle`, `friction_torque` and `wear`, at the input angle of the load.
    points : int
        Designs to search for, both ends among them. Each takes a search of `optimise`.
    torque_Nm, preload_N, input_angle_deg : float, optional
        The load. What is not given comes from `[load]` of the case.
    seed : int
        Seed of the searches. The same seed gives the same designs.
    progress : callable, optional
        Called as ``progress(searches_done, searches)``. What it raises ends the work.

    Returns
    -------
    ParetoFront
        The designs, from the least value of the first objective to that of the second.

    Raises
    ------
    InvalidInputError
        The objectives or bounds are not possible, or there is no torque.
    """
    first, second = _checked(objectives, points)
    whole, bounds = searched(case, bounds, (torque_Nm, preload_N, input_angle_deg), seed)
    # The elastic angle has the sign of the torque, so it is never the one with a limit.
    least, limited = (second, first) if second == "elastic_angle" else (first, second)
    done = 0

    def run(objective: str, most: float | None = None, start: Optimum | None = None) -> Optimum:
        nonlocal done
        limits = bounds if most is None else _limited(bounds, limited, most)
        found = Search(whole, limits, objective).run(seed, start)
        done += 1
        if progress is not None:
            progress(done, points + 1)
        return found

    start = run(least)
    if not start.found:
        return ParetoFront(whole, (first, second), (), start, 0, seed, bounds.source)
    end = run(limited)
    low, high = (_value(point, limited) for point in (end, start))
    # The last one is the end itself, with the other objective as small as it can be there.
    spaced = np.geomspace if low > 0 else np.linspace
    steps = [float(most) * (1 + _ROOM) for most in spaced(high, low, points)[1:]]
    runs = [start, *(run(least, most, end) for most in steps)]
    order = slice(None) if least == first else slice(None, None, -1)
    kept = _unbeaten([point for point in runs if point.found], (least, limited))[order]
    return ParetoFront(
        whole, (first, second), tuple(kept), None, len(runs) - len(kept), seed, bounds.source
    )


def _checked(objectives: tuple[str, str], points: int) -> tuple[str, str]:
    expected = ", ".join(OBJECTIVES)
    names = list(objectives)
    if len(names) != 2 or names[0] == names[1] or any(name not in OBJECTIVES for name in names):
        raise InvalidInputError(f"objectives = {names}: expected two of {expected}")
    if not 2 <= points <= MOST_POINTS:
        raise InvalidInputError(f"points = {points}: expected 2 to {MOST_POINTS}")
    return names[0], names[1]


def _limited(bounds: Bounds, objective: str, most: float) -> Bounds:
    """The bounds with a limit on an objective, SI; it is tighter than one that is there."""
    column = OBJECTIVES[objective]
    limit = Limit(column, most, 1.0, 1, most or 1.0, (column,))
    others = tuple(other for other in bounds.limits if other.columns != limit.columns)
    return replace(bounds, limits=(*others, limit))


def _unbeaten(points: list[Optimum], names: tuple[str, str]) -> list[Optimum]:
    """Those that no other one beats or equals in both, by the first objective."""
    ordered = sorted(points, key=lambda point: tuple(_value(point, name) for name in names))
    kept: list[Optimum] = []
    for point in ordered:
        if not kept or _value(point, names[1]) < _value(kept[-1], names[1]):
            kept.append(point)
    return kept


def _value(point: Optimum, objective: str) -> float:
    """An objective of a design that has a solution; the angle in arcsec."""
    if objective == "elastic_angle":
        found = point.after_arcsec
    else:
        found = point.friction[OBJECTIVES[objective]]
    return float("nan") if found is None else found


def _before(point: Optimum, objective: str) -> float | None:
    """The same of the case as it was."""
    if objective == "elastic_angle":
        return point.before_arcsec
    return point.friction[f"{OBJECTIVES[objective]}_before"]
