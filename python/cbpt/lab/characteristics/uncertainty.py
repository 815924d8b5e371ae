"""Figures with their standard uncertainties (GUM).

    Figure      a number, its uncertainty, unit and convention; or why there is none
    Sources     what is known of the uncertainty of the readings
    Estimates   the figures of some loops: values and the parts of their uncertainty
    estimated   makes them

Type A is the standard deviation of the mean over loops (repeats and runs), and no less than what
the uncertainty of the readings makes of it: the loops are read off again with it added (JCGM 101,
Monte Carlo). Type B is what a standard uncertainty of a gain does to the figure: readings of torque
are scaled and the figures read off again; the angle scales them directly. It is also what a display
rounds alike in all loops (GUM F.2.2.1), and what the curve may be between two readings: the first
loop is read off again with what lies between them drawn from where it may lie. And it is what an
open loop leaves unknown: the figures lie between those read and those of the loops closed by a
drift, with the same chance anywhere; a first leg that begins at rest, where a loop is open, may
take the area of a triangle from it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.characteristics.between_readings import leaning
from cbpt.lab.characteristics.figures import DEFINITIONS, NAMES, Convention, of_loop
from cbpt.lab.characteristics.loops import Branch, Loop
from cbpt.lab.characteristics.play import friction_torque_Nm

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """How closely figures are looked at."""

    draws: int = 40
    """Of the scatter, and of the rounding: their standard deviation is known to 11 %."""
    between: int = 20
    """Of what lies between readings: the root of their mean square is known to 16 %."""
    step: float = 1e-3
    """By which torques are scaled down; up would push the last ones beyond the rated torque."""
    beyond: float = 2.0
    """Loops to more than this factor of the mean torque of friction turn through the play: what
    friction holds at most is more than its mean, by up to twice where it comes round slowly."""
    apart: float = 1.5
    """Amplitudes further apart than this factor are different ones."""


_LIMITS = _Limits()
_GROWS_WITH_ANGLE = {"arcsec": 1.0, "J": 1.0, "N m/arcmin": -1.0, "N m": 0.0}
"""Power of the angle in a figure, by its unit."""


@dataclass(frozen=True)
class Figure:
    """One figure; `value` is None where it cannot be had, and `reason` says why."""

    name: str
    value: float | None
    u: float | None
    """Standard uncertainty (k = 1)."""
    unit: str
    convention: str
    torque_Nm: float | tuple[float, float] | None
    """Where it is read off: a torque, or from one torque to another."""
    rests_on: tuple[str, ...]
    u_type_a: float | None = None
    u_type_b: float | None = None
    reason: str | None = None
    setting: str | None = None
    """Preload or level of the column, where the table has several."""

    def to_dict(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self) | {"rests_on": list(self.rests_on)}


@dataclass(frozen=True)
class Sources:
    """Standard uncertainties behind readings."""

    scatter_arcsec: float = 0.0
    """Of one reading."""
    rounding_arcsec: float = 0.0
    """What a display rounds off a reading, alike in all loops."""
    torque_gain_rel: float = 0.0
    sensor_gain_rel: float = 0.0


@dataclass(frozen=True)
class LoopSet:
    """The loops that figures are read off: those to the rated torque, and the smallest ones."""

    full: Sequence[Loop]
    small: Sequence[Loop]

    @property
    def amplitude_Nm(self) -> float:
        """Mean amplitude of the full loops."""
        return float(np.mean([loop.amplitude_Nm for loop in self.full]))

    @property
    def small_amplitude_Nm(self) -> float:
        """Mean amplitude of the smallest loops."""
        return float(np.mean([loop.amplitude_Nm for loop in self.small]))

    @property
    def several(self) -> bool:
        """Whether there are loops of different amplitudes."""
        return self.amplitude_Nm > _LIMITS.apart * self.small_amplitude_Nm

    @property
    def turn_arcsec(self) -> float:
        """Mean angle from end to end of the smallest loops."""
        return float(np.mean([loop.turn_arcsec for loop in self.small]))

    def changed(self, change: Callable[[Loop], Loop]) -> LoopSet:
        """With every loop changed."""
        full = [change(loop) for loop in self.full]
        known = {id(loop): new for loop, new in zip(self.full, full, strict=True)}
        return LoopSet(full, [known.get(id(loop)) or change(loop) for loop in self.small])


@dataclass(frozen=True)
class Estimates:
    """Figures by name: value (NaN for none), type A and type B."""

    value: dict[str, float]
    type_a: dict[str, float]
    type_b: dict[str, float]
    loops: int

    def u(self, name: str) -> float:
        """Both types together."""
        return float(np.hypot(self.type_a[name], self.type_b[name]))


def estimated(loops: LoopSet, convention: Convention, sources: Sources) -> Estimates:
    """The figures of some loops."""
    table = _Table.of(loops, convention)
    value = table.bounded()
    type_a = _drawn(loops, convention, sources.scatter_arcsec)
    if table.repeated:
        # Two loops may agree by chance: no figure is better than its readings.
        spread = table.jackknife()
        type_a = {name: max(spread[name], type_a[name]) for name in NAMES}
    read = table.figures()
    shifted = _Table.of(
        loops.changed(partial(Loop.scaled, torque=1 - _LIMITS.step)), convention
    ).figures()
    type_b = {}
    for name in NAMES:
        by_torque = (read[name] - shifted[name]) / _LIMITS.step * sources.torque_gain_rel
        power = _GROWS_WITH_ANGLE[DEFINITIONS[name][0]]
        by_angle = power * value[name] * sources.sensor_gain_rel
        type_b[name] = float(np.hypot(np.nan_to_num(by_torque), by_angle))
    type_b["backlash"] = float(np.hypot(type_b["backlash"], table.of_form()))
    between = _between(loops.full[0], convention)
    rounded = _drawn(LoopSet(loops.full[:1], loops.full[:1]), convention, sources.rounding_arcsec)
    closed = _Table.of(loops.changed(Loop.closed), convention).figures()
    for name in NAMES:
        of_closing = float(np.nan_to_num(closed[name] - read[name])) / 3**0.5
        parts = type_b[name], between[name], rounded[name], of_closing
        type_b[name] = float(np.sqrt(np.sum(np.square(parts))))
    first_leg = np.mean([loop.first_leg_J for loop in loops.full]) / 3**0.5
    type_b["loop_energy"] = float(np.hypot(type_b["loop_energy"], first_leg))
    return Estimates(value, type_a, type_b, len(loops.full))


def read_off(loops: LoopSet, convention: Convention) -> dict[str, float]:
    """The figures alone, NaN for those that cannot be had."""
    return _Table.of(loops, convention).bounded()


def play_of_form_arcsec(loops: LoopSet, convention: Convention) -> float:
    """What the play depends on the form of the curve that is continued to no torque: standard
    uncertainty."""
    return _Table.of(loops, convention).of_form()


@dataclass(frozen=True)
class _Table:
    """Figures of each full loop."""

    loops: LoopSet
    full: list[dict[str, float]]

    @classmethod
    def of(cls, loops: LoopSet, convention: Convention) -> _Table:
        return cls(loops, [of_loop(loop, convention) for loop in loops.full])

    @property
    def repeated(self) -> bool:
        return len(self.full) > 1

    def figures(self) -> dict[str, float]:
        """The play as it is read: below zero where the curve hardens."""
        return {name: _mean(self.full, name) for name in NAMES}

    def bounded(self) -> dict[str, float]:
        """No play is less than none, or more than the smallest loops turn, where friction cannot
        hold it in them."""
        found = self.figures()
        if not np.isfinite(found["backlash"]):
            return found
        friction = max(friction_torque_Nm(loop) for loop in self.loops.full)
        beyond = self.loops.small_amplitude_Nm > _LIMITS.beyond * friction
        most = self.loops.turn_arcsec if beyond else np.inf
        return found | {"backlash": float(np.clip(found["backlash"], 0.0, most))}

    def of_form(self) -> float:
        """What the play depends on the form of the curve that is continued to no torque: standard
        uncertainty, where it is between straight lines and parabolas."""
        apart = _mean(self.full, "backlash") - _mean(self.full, "straight")
        return float(abs(np.nan_to_num(apart))) / 12**0.5

    def jackknife(self) -> dict[str, float]:
        """Of a mean it is the standard deviation over the square root of the number."""
        rows, found = self.full, dict.fromkeys(NAMES, 0.0)
        left = [replace(self, full=[*rows[:i], *rows[i + 1 :]]).figures() for i in range(len(rows))]
        for name in NAMES:
            values = np.array([figures[name] for figures in left])
            values = values[np.isfinite(values)]
            n = len(values)
            if n > 1:
                found[name] = float(np.sqrt((n - 1) / n * np.sum((values - values.mean()) ** 2)))
        return found


def _mean(rows: Sequence[dict[str, float]], name: str) -> float:
    values = np.array([row[name] for row in rows])
    values = values[np.isfinite(values)]
    return float(values.mean()) if len(values) else np.nan


def _drawn(loops: LoopSet, convention: Convention, scatter_arcsec: float) -> dict[str, float]:
    if not scatter_arcsec:
        return dict.fromkeys(NAMES, 0.0)
    rng = np.random.default_rng(0)
    last = max(float(b.row.max()) for x in (*loops.full, *loops.small) for b in x.branches)

    def noisy(branch: Branch | None, noise: Floats) -> Branch | None:
        if branch is None:
            return None
        # A reading at a turn is one of two branches.
        own = noise[np.round(branch.row).astype(int)]
        return replace(branch, angle_arcsec=branch.angle_arcsec + own)

    def again(noise: Floats) -> LoopSet:
        return loops.changed(
            lambda x: x.with_branches(noisy(x.rising, noise), noisy(x.falling, noise))
        )

    noises = rng.normal(0.0, scatter_arcsec, (_LIMITS.draws, int(last) + 1))
    draws = [_Table.of(again(noise), convention).figures() for noise in noises]
    found = {}
    for name in NAMES:
        values = np.array([draw[name] for draw in draws])
        values = values[np.isfinite(values)]
        found[name] = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return found


def _between(loop: Loop, convention: Convention) -> dict[str, float]:
    """What the steps between the readings of a loop leave open, and so of all loops with the same
    steps: root mean square departure."""
    value = of_loop(loop, convention)
    rng = np.random.default_rng(1)
    square = dict.fromkeys(NAMES, 0.0)
    for _ in range(_LIMITS.between):
        drawn = of_loop(leaning(loop, rng.uniform(-1.0, 1.0, 2)), convention)
        for name in NAMES:
            square[name] += float(np.nan_to_num(drawn[name] - value[name])) ** 2
    return {name: (total / _LIMITS.between) ** 0.5 for name, total in square.items()}
