"""The design with the smallest elastic angle, friction torque or wear within bounds.

    optimise    a case and bounds -> Optimum
    Optimum     the best design, or the nearest to the bounds where none keeps them
    OBJECTIVES  what may be made small
    searched    what is searched: a whole case, and its bounds; Search does it

The search is SciPy's differential evolution (Storn and Price 1997): it needs no slopes, takes whole
numbers, and asks for a whole population at once, which `judge` answers on all cores. Designs are
compared by Deb's rules (2000): of two that keep the limits the smaller angle, of two that do not
the smaller violation, and one that keeps them before one that does not; so a design without a
solution never wins. What it finds is polished by SLSQP in the numbers that are not whole.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.design.bounds import FRICTION, Bounds, read_bounds
from cbpt.design.judge import (
    Judged,
    at_load,
    bare_drive_note,
    judge,
    left_out,
    nominal_parts_note,
    shown,
    value_of,
)
from cbpt.errors import InvalidInputError
from cbpt.lab.wording.html import Reported
from cbpt.results import ANGLE_UNITS, ARCSEC_PER_RAD

__all__ = ["Optimum", "optimise"]

Floats = NDArray[np.float64]

# A design of the population for each free number, and generations at most.
_POPULATION, _GENERATIONS = 10, 150
# Searches before it is said that no design was found.
_ATTEMPTS = 3
# The search ends when the angles of the population differ by about this part of them; the rest is
# the polish's.
_AGREE = 1e-3
# A threshold that was not asked for, as other limits are violated, counts as twice the preload.
_UNASKED = 1.0
# Input angles over a period at which the outcome is looked at.
_ANGLES = 24
# Without a solution a design is beyond every one that has one.
_UNSOLVED = 100.0
# Kept clear of a limit by the polish, so that rounding does not step over it.
_CLEAR = 1e-7
# Nearer to a bound than this, of the range or of the limit's size, is at it.
_BINDS = 1e-4


OBJECTIVES = {
    "elastic_angle": "elastic_angle_rad",
    "friction_torque": "friction_torque_Nm",
    "wear": "wear_Nm_per_turn",
}
"""What may be made small, and its column."""


@dataclass(frozen=True, eq=False)
class Optimum(Reported):
    """The outcome of a search. Numbers are named in SI, values are SI."""

    case: Case
    """The best design as a case; the nearest where none keeps the bounds. Its parts are nominal."""
    started: Case = field(repr=False)
    """The case as it was, with its load."""
    found: bool
    """Whether it keeps them."""
    numbers: dict[str, tuple[float, float]]
    """Each free number: as it was, and as it is."""
    before_arcsec: float | None
    """Elastic angle of the case as it was; None without a solution."""
    after_arcsec: float | None
    """Elastic angle of `case`."""
    binds: tuple[str, ...]
    """Bounds and limits that the design lies at: what keeps the angle from being smaller."""
    violated: tuple[str, ...]
    """What `case` violates, in sentences; nothing where it was found."""
    violated_before: tuple[str, ...]
    """What the case as it was violates."""
    margins: dict[str, float]
    """What is left to each limit, in the unit of its key; below 0 it is violated. That of a preload
    threshold is `preload_N`."""
    over_period: dict[str, float | None]
    """`elastic_angle_least_arcsec`, `elastic_angle_largest_arcsec` and, where pressure is limited,
    `contact_pressure_largest_GPa` of `case` at input angles over a period."""
    designs: int
    """How many were judged."""
    seed: int
    source: str = field(repr=False, default="")
    objective: str = "elastic_angle"
    """What was made small: a name of `OBJECTIVES`."""
    friction: dict[str, float | None] = field(default_factory=dict)
    """`friction_torque_Nm`, `efficiency` and `wear_Nm_per_turn` of `case` at its input angle, with
    `..._before` as it was."""

    def to_dict(self) -> dict[str, Any]:
        """The document: plain types, JSON-safe."""
        keys = {name: shown(name, value[0])[0] for name, value in self.numbers.items()}
        load = self.case
        return {
            "found": self.found,
            "torque_Nm": load.torque_Nm,
            "preload_N": load.preload_N,
            "input_angle_deg": load.input_angle_deg or 0.0,
            "elastic_angle_before_arcsec": self.before_arcsec,
            "elastic_angle_arcsec": self.after_arcsec,
            "numbers": {
                keys[name]: {"before": shown(name, was)[1], "value": shown(name, now)[1]}
                for name, (was, now) in self.numbers.items()
            },
            "objective": self.objective,
            **self.friction,
            "binds": list(self.binds),
            "margins": {key: _plain(value) for key, value in self.margins.items()},
            "over_period": self.over_period,
            "violated": list(self.violated),
            "violated_before": list(self.violated_before),
            "designs": self.designs,
            "seed": self.seed,
            "not_counted": left_out(self.started),
            "case_toml": self.case.to_toml(),
        }

    def to_json(self) -> str:
        """`to_dict` as JSON text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def report(self, angle_unit: str = "arcsec") -> str:
        """Text for a terminal."""
        from cbpt.lab.wording import layout

        def angle(arcsec: float | None) -> str:
            if arcsec is None:
                return "no solution"
            return f"{arcsec * ANGLE_UNITS[angle_unit]:.6g} {angle_unit}"

        c = self.case
        lines = [
            f"Elastic angle at {c.torque_Nm:g} N m, input angle {c.input_angle_deg or 0:g} deg: "
            f"{angle(self.after_arcsec)}; before: {angle(self.before_arcsec)}"
        ]
        if not self.found:
            lines = [
                f"No design meets the limits of {self.source} ({self.designs} designs computed); "
                "the nearest one violates:",
                *(f"  {sentence}" for sentence in self.violated),
                *lines,
            ]
        rows: list[list[str | float]] = []
        for name, (was, now) in self.numbers.items():
            key, before = shown(name, was)
            rows.append([key, before, shown(name, now)[1]])
        lines.append(layout.table(["number", "before", "now"], rows))
        lines.append(self._of_period(angle))
        lines.append(self._of_friction())
        if self.found:
            at = (
                ", ".join(self.binds)
                or f"none, the smallest {self.objective.split('_')[-1]} lies inside the ranges and "
                "limits"
            )
            lines.append(f"Bounds reached: {at}.")
        if self.found and self.violated_before:
            lines.append(f"The original case violates: {'; '.join(self.violated_before)}.")
        lines.append(f"{self.designs} designs computed, seed {self.seed}.")
        lines += bare_drive_note(self.case, "the angles are")
        lines += nominal_parts_note(self.started, "the designs are")
        return "\n".join(lines)

    def _of_period(self, angle: Callable[[float | None], str]) -> str:
        of = self.over_period
        least, largest = (of[f"elastic_angle_{end}_arcsec"] for end in ("least", "largest"))
        if least is None:
            return "At some input angles within a period of the drive there is no solution."
        told = f"Over a period of the drive: {angle(least)} to {angle(largest)}"
        pressure = of.get("contact_pressure_largest_GPa")
        if pressure is not None:
            told += f", contact pressure at most {pressure:.6g} GPa"
            if self.found:
                told += f" (the limit is checked at {self.case.input_angle_deg or 0:g} deg)"
        return f"{told}."

    def _of_friction(self) -> str:
        now, before = (self.friction.get(f"friction_torque_Nm{end}") for end in ("", "_before"))
        if now is None:
            return "Friction torque at the input: no solution."
        was = "no solution" if before is None else f"{before:.6g} N m"
        return (
            f"Friction torque at the input, at this input angle: {now:.6g} N m, efficiency "
            f"{self.friction['efficiency']:.4g}, coefficient {self.case.friction_coefficient:g}; "
            f"before: {was}."
        )

    def __repr__(self) -> str:
        return self.report()


def optimise(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    bounds: str | PathLike[str] | Mapping[str, Any] | Bounds,
    *,
    torque_Nm: float | None = None,
    preload_N: float | None = None,
    input_angle_deg: float | None = None,
    seed: int = 0,
    objective: str = "elastic_angle",
) -> Optimum:
    """Search for the design with the smallest elastic angle, friction torque or wear within bounds.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The design to start from. Numbers that are not free keep its values.
    bounds : Bounds, str, PathLike or dict
        What may change (`[free]`) and what must be kept (`[limits]`).
    torque_Nm, preload_N, input_angle_deg : float, optional
        The load. What is not given comes from `[load]` of the case.
    seed : int
        Seed of the search. The same seed gives the same design.
    objective : str
        What is made small: `elastic_angle`, `friction_torque` or `wear`, at the input angle of the
        load.

    Returns
    -------
    Optimum
        The case of the best design, the angles before and after, and the bounds that it meets.

    Raises
    ------
    InvalidInputError
        The bounds are not possible, or there is no torque.
    """
    whole, bounds = searched(case, bounds, (torque_Nm, preload_N, input_angle_deg), seed)
    if objective not in OBJECTIVES:
        expected = ", ".join(OBJECTIVES)
        raise InvalidInputError(f"objective = {objective}: expected one of {expected}")
    return Search(whole, bounds, objective).run(seed)


def searched(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    bounds: str | PathLike[str] | Mapping[str, Any] | Bounds,
    load: tuple[float | None, float | None, float | None],
    seed: int,
) -> tuple[Case, Bounds]:
    """The case under its whole load, torque, preload and angle as in `optimise`, and its bounds.

    Raises `InvalidInputError` for bounds that are not possible, and where there is no torque.
    """
    whole = at_load(case, *load)
    bounds = bounds if isinstance(bounds, Bounds) else read_bounds(bounds, whole)
    if whole.torque_Nm == 0.0:
        raise InvalidInputError(
            "torque_Nm = 0: expected a torque; without one the elastic angle of every design is 0"
        )
    if seed < 0:
        raise InvalidInputError(f"seed = {seed}: expected 0 or more")
    return whole, bounds


class Search:
    """The search for one design: what it changes, what it keeps, what it makes small."""

    def __init__(self, case: Case, bounds: Bounds, objective: str) -> None:
        self.started, self.bounds, self.objective = case, bounds, objective
        # What was measured of one drive's parts says nothing of another's.
        self.case = case.nominal()
        self.column = OBJECTIVES[objective]
        rubs = bounds.needs_friction or objective != "elastic_angle"
        self.coefficient = case.friction_coefficient if rubs else None
        self.names = [free.number for free in bounds.free]
        self.low = np.array([free.low for free in bounds.free])
        self.high = np.array([free.high for free in bounds.free])
        self.whole = np.array([free.whole for free in bounds.free])
        self.designs = 0

    def run(self, seed: int, start: Optimum | None = None) -> Optimum:
        """The best design; the search begins at the case, or at another outcome."""
        from scipy.optimize import Bounds as Box
        from scipy.optimize import differential_evolution

        values = [value_of(self.case, free.number) for free in self.bounds.free]
        # One that stands for two that differ starts in the middle of its range.
        middle = 0.5 * (self.low + self.high)
        # A start on the very bound is outside to the rounding of SciPy's own scale.
        inside = 1e-9 * (self.high - self.low)
        was = np.array([m if v is None else v for v, m in zip(values, middle, strict=True)])
        begin = was if start is None else np.array([start.numbers[name][1] for name in self.names])
        of_population: Any = self.of_population  # one number in SciPy's own types
        # Where nothing keeps the limits the search may have run into a blind end: it is begun
        # again, from elsewhere and less greedily.
        for attempt in range(_ATTEMPTS):
            ended = differential_evolution(
                of_population,
                Box(self.low, self.high),
                x0=np.clip(begin, self.low + inside, self.high - inside) if attempt == 0 else None,
                strategy="best1bin" if attempt == 0 else "rand1bin",
                integrality=self.whole,
                vectorized=True,
                updating="deferred",
                popsize=_POPULATION,
                maxiter=_GENERATIONS,
                tol=_AGREE,
                polish=False,
                seed=seed + attempt * 1_000_003,
            )
            if ended.fun < 1.0:
                break
        best = np.where(self.whole, np.round(ended.x), ended.x)
        polished = self.polished(best) if ended.fun < 1.0 else best
        merits = self.merit(np.array([best, polished]))
        x = polished if merits[1] < merits[0] else best
        found = float(merits.min()) < 1.0
        return self.optimum(was, x if found else self.kept_back(was, x), found, seed)

    def kept_back(self, was: Floats, x: Floats) -> Floats:
        """What does not bear on the violation as it was, where its range lets it."""
        x = x.copy()
        for place, value in enumerate(np.clip(was, self.low, self.high)):
            back = x.copy()
            back[place] = round(value) if self.whole[place] else value
            merits = self.merit(np.array([x, back]))
            if merits[1] <= merits[0]:
                x = back
        return x

    def of_population(self, x: Floats) -> Floats:
        """The merits of designs in columns, or of one."""
        return self.merit(np.atleast_2d(x.T))

    def judged(self, x: Floats) -> Judged:
        """Without the threshold, which is asked for where nothing else decides."""
        self.designs += len(x)
        return judge(
            self.case,
            self.names,
            x,
            pressures=self.bounds.needs_pressures,
            coefficient=self.coefficient,
        )

    def excesses(self, x: Floats, judged: Judged) -> Floats:
        """By limit and design, the last row that of the preload; above 0 it is violated. NaN: not
        asked for, as the threshold is where another limit is violated."""
        limits = np.array([limit.excess(judged) for limit in self.bounds.limits])
        preload = np.full(len(x), np.nan if self.bounds.threshold else -1.0)
        good = (np.nan_to_num(limits, nan=1.0) <= 0).all(axis=0) & (judged.status == "ok")
        if self.bounds.threshold and good.any():
            preload[good] = self.preload_excess(x[good])
        return np.vstack([limits, preload])

    def preload_excess(self, x: Floats) -> Floats:
        """What the threshold needs beyond the preload, as a part of the preload."""
        threshold = self.bounds.threshold
        needed = judge(self.case, self.names, x, threshold=threshold)["needed_preload_N"]
        place = "load.preload_N"
        fixed = np.full(len(x), self.case.preload_N)
        own = x[:, self.names.index(place)] if place in self.names else fixed
        return needed / own - 1.0

    def merit(self, x: Floats) -> Floats:
        """Objective, brought below 1, of what keeps the limits; 1 and the violation of what does
        not."""
        judged = self.judged(x)
        excess = np.clip(self.excesses(x, judged), 0.0, None)
        excess[-1] = np.nan_to_num(excess[-1], nan=_UNASKED)
        solved = judged.status == "ok"
        violation = np.nansum(np.minimum(excess, 1e6), axis=0) + np.where(solved, 0.0, _UNSOLVED)
        # A wall that is missing is no small violation, however little is missing: the pressures at
        # the edge are those of another design, so that no way leads across it.
        for limit in self.bounds.limits:
            if limit.key in ("undercut_margin", "inside_wall_margin") and limit.value >= 0:
                violation += judged[limit.key] < 0
        size = np.abs(judged[self.column])
        if self.objective != "elastic_angle":
            size = size / (1.0 + size)
        return np.where(violation > 0, 1.0 + violation, np.where(solved, size, np.inf))

    def polished(self, x: Floats) -> Floats:
        """The nearest smallest objective in the numbers that are not whole, by SLSQP."""
        from scipy.optimize import minimize

        moving = np.flatnonzero(~self.whole)
        if not len(moving):
            return x
        low, size = self.low[moving], (self.high - self.low)[moving]
        step = 1e-6
        asked: dict[bytes, tuple[Floats, Floats]] = {}

        def at(z: Floats) -> tuple[Floats, Floats]:
            """Value and slopes of the log of the objective, then of what is left to each limit."""
            key = z.tobytes()
            if key not in asked:
                # Inside the bounds, where a number is at one of them to one side.
                ends = [np.clip(z - step, 0, 1), np.clip(z + step, 0, 1)]
                rows = [
                    z,
                    *(np.where(np.eye(len(z))[i], end, z) for i in range(len(z)) for end in ends),
                ]
                designs = np.tile(x, (len(rows), 1))
                designs[:, moving] = low + np.array(rows) * size
                judged = self.judged(designs)
                # Column by column: the larger of two would have a kink.
                limits = np.vstack([limit.excesses(judged) for limit in self.bounds.limits])
                if self.bounds.threshold:
                    limits = np.vstack([limits, self.preload_excess(designs)])
                found = np.vstack([np.log(np.abs(judged[self.column])), -limits - _CLEAR])
                # What is without limit or without a solution does not pull.
                found = np.nan_to_num(found, nan=-1.0, posinf=1e6, neginf=-1e6)
                span = np.array([ends[1][i] - ends[0][i] for i in range(len(z))])
                asked[key] = found[:, 0], (found[:, 2::2] - found[:, 1::2]) / span
            return asked[key]

        def angle(z: Floats) -> tuple[float, Floats]:
            values, slopes = at(z)
            return float(values[0]), slopes[0]

        left: Any = {"type": "ineq", "fun": lambda z: at(z)[0][1:], "jac": lambda z: at(z)[1][1:]}
        ended = minimize(
            angle,
            (x[moving] - low) / size,
            jac=True,
            bounds=[(0.0, 1.0)] * len(moving),
            constraints=left,
            method="SLSQP",
            options={"maxiter": 100, "ftol": 1e-12},
        )
        better = x.copy()
        better[moving] = low + np.clip(ended.x, 0, 1) * size
        return better

    def optimum(self, was: Floats, now: Floats, found: bool, seed: int) -> Optimum:
        both = np.array([was, now])
        judged = self.judged(both)
        excess = self.excesses(both, judged)
        if self.bounds.threshold:
            excess[-1] = self.preload_excess(both)
        angles = np.abs(judged["elastic_angle_rad"]) * ARCSEC_PER_RAD
        rubbed = judge(self.case, self.names, both, coefficient=self.case.friction_coefficient)
        values = {name: float(v) for name, v in zip(self.names, now, strict=True)}
        limits = self.bounds.limits
        margins = {
            limit.key: -float(limit.excess(judged)[1]) * limit.size / limit.unit for limit in limits
        }
        case = self.case.with_numbers(values)
        if self.bounds.threshold and case.preload_N is not None:
            margins["preload_N"] = -float(excess[-1, 1]) * case.preload_N
        at = [
            f"{shown(free.number, 0.0)[0]} ({'least' if value < middle else 'greatest'})"
            for free, value in zip(self.bounds.free, now, strict=True)
            if min(value - free.low, free.high - value) <= _BINDS * (free.high - free.low)
            for middle in [(free.low + free.high) / 2]
        ]
        at += [
            f"{limit.key} {limit.value:g}"
            for limit, e in zip(limits, excess, strict=False)
            if abs(e[1]) <= _BINDS
        ]
        if self.bounds.threshold and abs(excess[-1, 1]) <= _BINDS:
            at.append(f"preload for {self.bounds.threshold}")
        return Optimum(
            case=case,
            started=self.started,
            found=found,
            numbers={
                name: (float(w), float(n)) for name, w, n in zip(self.names, was, now, strict=True)
            },
            before_arcsec=_plain(angles[0]),
            after_arcsec=_plain(angles[1]),
            binds=tuple(at) if found else (),
            violated=() if found else self.violations(excess[:, 1], str(judged.status[1])),
            violated_before=self.violations(excess[:, 0], str(judged.status[0]))
            + tuple(self.outside(was)),
            margins=margins,
            over_period=self.over_period(case),
            designs=self.designs,
            seed=seed,
            source=self.bounds.source,
            objective=self.objective,
            friction={
                name + end: _plain(rubbed[name][place])
                for name in FRICTION
                for place, end in ((0, "_before"), (1, ""))
            },
        )

    def over_period(self, case: Case) -> dict[str, float | None]:
        """Of a design: ends of the angle, and the largest pressure where that is limited."""
        torque, preload = case.torque_Nm, case.preload_N
        assert torque is not None and preload is not None, "see at_load"
        found: dict[str, float | None] = dict.fromkeys(
            ("elastic_angle_least_arcsec", "elastic_angle_largest_arcsec")
        )
        if self.bounds.needs_pressures:
            found["contact_pressure_largest_GPa"] = None
        largest = case.drive.largest_elastic_angle(torque, preload)
        if largest is None:
            return found
        at = (case.input_angle_deg or 0.0) + largest.period_deg * np.arange(_ANGLES) / _ANGLES
        solved = [case.drive.solve(torque, preload, float(angle)) for angle in at]
        angles = [abs(s.elastic_angle_arcsec) for s in solved if s.elastic_angle_arcsec is not None]
        pairs = [pair for s in solved for pair in (s.deceleration, s.equal_speed) if pair]
        pressures = [pair.largest_peak_pressure_Pa for pair in pairs]
        if len(angles) < len(at):
            return found
        found["elastic_angle_least_arcsec"] = min(angles)
        found["elastic_angle_largest_arcsec"] = max(angles)
        if self.bounds.needs_pressures:
            found["contact_pressure_largest_GPa"] = max(pressures) * 1e-9
        return found

    def violations(self, excess: Floats, status: str) -> tuple[str, ...]:
        told = [] if status == "ok" else [f"the load has no solution ({status})"]
        for limit, e in zip(self.bounds.limits, excess, strict=False):
            if e > 0:
                found = limit.value + limit.sign * e * limit.size / limit.unit
                least = "at most" if limit.sign > 0 else "at least"
                told.append(f"{limit.key} = {found:.6g}, {least} {limit.value:g}")
        if excess[-1] > 0:
            more = 100 * float(excess[-1])
            told.append(f"preload: {self.bounds.threshold} needs {more:.3g} % more preload")
        return tuple(told)

    def outside(self, was: Floats) -> list[str]:
        outside = [
            shown(free.number, value)
            for free, value in zip(self.bounds.free, was, strict=True)
            if not free.low <= value <= free.high
        ]
        return [f"{key} = {value:.6g} is outside its range" for key, value in outside]


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
