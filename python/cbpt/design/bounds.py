"""What a search may change and what it must keep: a file of bounds.

Free         a number that may change, between two values
Limit        what a design must keep
Bounds       all of them
read_bounds  a TOML file or a dict -> Bounds

[free]                                   # keys of a case file, least and greatest value
deceleration.short_amplitude_coefficient = [0.3, 0.6]
deceleration.rolling_circle_radius_mm = [3, 5]
equal_speed.ball_count = [10, 16]
load.preload_N = [200, 1500]

[limits]
outer_radius_mm = 90                     # at most
contact_pressure_GPa = 3                 # at most, in both pairs
preload = "continuous"                   # at least this threshold over a period
undercut_margin = 0.1                    # at least
friction_torque_Nm = 0.08                # at most, at the input
efficiency = 0.8                         # at least
wear_Nm_per_turn = 6                     # at most
static_safety = 1.5                      # at least
natural_frequency_Hz = 40                # at least; needs output_inertia under [operation]
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, design_number
from cbpt.design.judge import Judged
from cbpt.errors import InvalidInputError
from cbpt.toml_files import is_number, read_toml, shown

Floats = NDArray[np.float64]

THRESHOLDS = ("hold", "continuous", "zero_backlash")
_LENGTH = {"_m": 1.0, "_mm": 1e-3, "_um": 1e-6}
_TORQUE = {"_Nm": 1.0, "_mNm": 1e-3}
_STRESS = {"_Pa": 1.0, "_MPa": 1e6, "_GPa": 1e9}
# Of each limit: its units, its sign (at most 1, at least -1), what is 1 of a violation where the
# limit itself is 0, the columns it holds for, and what holds where nothing is said.
_KINDS: dict[str, tuple[dict[str, float], int, float, tuple[str, ...], float | None]] = {
    "outer_radius": (_LENGTH, 1, 1e-3, ("outer_radius_m",), None),
    "contact_pressure": (
        _STRESS,
        1,
        1e9,
        ("deceleration_pressure_Pa", "equal_speed_pressure_Pa"),
        None,
    ),
    "undercut_margin": ({"": 1.0}, -1, 1.0, ("undercut_margin",), 0.0),
    "inside_wall_margin": ({"": 1.0}, -1, 1.0, ("inside_wall_margin",), 0.0),
    "ball_clearance": (
        _LENGTH,
        -1,
        1e-3,
        ("deceleration_ball_clearance_m", "equal_speed_ball_clearance_m"),
        0.0,
    ),
    "ring_clearance": (_LENGTH, -1, 1e-3, ("ring_clearance_m",), 0.0),
    "friction_torque": (_TORQUE, 1, 1e-2, ("friction_torque_Nm",), None),
    "efficiency": ({"": 1.0}, -1, 1.0, ("efficiency",), None),
    "wear": ({"_Nm_per_turn": 1.0}, 1, 1.0, ("wear_Nm_per_turn",), None),
    "static_safety": ({"": 1.0}, -1, 1.0, ("static_safety",), None),
    "natural_frequency": ({"_Hz": 1.0}, -1, 1.0, ("natural_frequency_Hz",), None),
}
FRICTION = ("friction_torque_Nm", "efficiency", "wear_Nm_per_turn")
"""Columns that friction fills."""
PRESSURE = (
    "deceleration_pressure_Pa",
    "equal_speed_pressure_Pa",
    "static_safety",
    "natural_frequency_Hz",
)
"""Columns that need every meshing point."""


@dataclass(frozen=True)
class Free:
    """A number that may change, SI."""

    number: str
    """Name in SI."""
    low: float
    high: float
    whole: bool


@dataclass(frozen=True)
class Limit:
    """What a design must keep."""

    key: str
    """As in the file, with its unit."""
    value: float
    """In that unit."""
    unit: float
    """One of it in SI."""
    sign: int
    """1: at most; -1: at least."""
    size: float
    """A violation of so much counts as 1, SI."""
    columns: tuple[str, ...]

    def excesses(self, judged: Judged) -> Floats:
        """How far designs are beyond it, in units of its size, below 0 within it: each of its
        columns by itself, shape (columns, n)."""
        found = np.array([judged[column] for column in self.columns])
        return self.sign * (found - self.value * self.unit) / self.size

    def excess(self, judged: Judged) -> Floats:
        """The largest of them, shape (n,)."""
        largest: Floats = np.max(self.excesses(judged), axis=0)
        return largest


@dataclass(frozen=True)
class Bounds:
    """What a search may change and what it must keep."""

    free: tuple[Free, ...]
    limits: tuple[Limit, ...]
    threshold: str | None
    """The least preload: one of `THRESHOLDS`."""
    source: str

    @property
    def needs_pressures(self) -> bool:
        """Whether a limit is about contact pressure."""
        return self._about(PRESSURE)

    @property
    def needs_friction(self) -> bool:
        """Whether a limit is about friction."""
        return self._about(FRICTION)

    def _about(self, columns: tuple[str, ...]) -> bool:
        return any(column in columns for limit in self.limits for column in limit.columns)


def read_bounds(bounds: str | os.PathLike[str] | Mapping[str, Any], case: Case) -> Bounds:
    """Bounds from a TOML file or a dict of its tables.

    Raises `InvalidInputError` with file, key, what was found and what is expected.
    """
    if isinstance(bounds, Mapping):
        return _bounds(bounds, "<bounds>", case)
    tables = read_toml(bounds, InvalidInputError, "bounds of a design (TOML)")
    return _bounds(tables, os.fsdecode(bounds), case)


def _bounds(tables: Mapping[str, Any], source: str, case: Case) -> Bounds:
    for name in tables:
        if name not in ("free", "limits"):
            raise InvalidInputError(f"{source}: {name}: expected the tables [free] and [limits]")
    free: list[Free] = []
    for key, value in _flat(tables.get("free", {}), source):
        found = _free(key, value, source, case)
        if any(_same(found.number, other.number) for other in free):
            raise InvalidInputError(
                f"{source}: free.{key}: another key frees this one too; keep one"
            )
        free.append(found)
    if not free:
        raise InvalidInputError(
            f"{source}: no parameter is free: add [free] with keys of a case and their ranges, "
            "for example deceleration.rolling_circle_radius_mm = [3, 5]"
        )
    stated = tables.get("limits", {})
    if not isinstance(stated, Mapping):
        raise InvalidInputError(f"{source}: limits: expected a table")
    limits = dict(_limit(key, value, source) for key, value in stated.items())
    threshold = limits.pop("preload", None)
    if "natural_frequency" in limits and case.output_inertia_kg_m2 is None:
        raise InvalidInputError(
            f"{source}: limits.natural_frequency_Hz needs output_inertia under [operation] in the "
            "case"
        )
    for kind, (units, sign, size, columns, default) in _KINDS.items():
        if default is not None and kind not in limits:
            suffix = "_mm" if "_mm" in units else ""
            limits[kind] = Limit(kind + suffix, default, units[suffix], sign, size, columns)
    ordered = tuple(limits[kind] for kind in _KINDS if kind in limits)
    return Bounds(tuple(free), ordered, threshold, source)


def _same(one: str, other: str) -> bool:
    """Whether two names are of one number, or one of them stands for two with the other in it."""
    shorter, longer = sorted((one, other), key=len)
    section, _, stem = shorter.partition(".")
    of = (f"{section}.{part}_{stem}" for part in ("ball", "plate", "outside", "inside"))
    return one == other or longer in of


def _flat(tables: Any, source: str, path: str = "") -> Iterator[tuple[str, Any]]:
    if not isinstance(tables, Mapping):
        raise InvalidInputError(
            f"{source}: free: expected keys with ranges, such as load.preload_N = [200, 4000]"
        )
    for key, value in tables.items():
        name = f"{path}.{key}" if path else str(key)
        if isinstance(value, Mapping) and name.count(".") < 2:  # no key of a case has more parts
            yield from _flat(value, source, name)
        else:
            yield name, value


def _number(value: object) -> float | None:
    return float(value) if is_number(value) else None


def _free(key: str, value: Any, source: str, case: Case) -> Free:
    ends = [_number(v) for v in value] if isinstance(value, list | tuple) else []
    low, high = (*ends, None, None)[:2] if len(ends) == 2 else (None, None)
    if low is None or high is None or low >= high:
        raise InvalidInputError(
            f"{source}: free.{key} = {shown(value)}: expected [least, greatest], two numbers"
        )
    try:
        number, (low, high), whole = design_number(case, key, [low, high])
    except InvalidInputError as error:
        raise InvalidInputError(f"{source}: free.{error}") from None
    if number.startswith("load.") and number != "load.preload_N":
        raise InvalidInputError(
            f"{source}: free.{key}: of the load only load.preload_N can be free; give the "
            "rest under [load] in the case or by its flag"
        )
    return Free(number, low, high, whole)


def _limit(key: str, value: Any, source: str) -> tuple[str, Any]:
    if key == "preload":
        if value not in THRESHOLDS:
            expected = ", ".join(THRESHOLDS)
            raise InvalidInputError(
                f"{source}: limits.preload = {shown(value)}: expected one of {expected}"
            )
        return key, value
    known = {kind + unit: (kind, unit) for kind, (units, *_) in _KINDS.items() for unit in units}
    if key not in known:
        near = difflib.get_close_matches(key, [*known, "preload"], 1)
        hint = f"did you mean {near[0]}? " if near else ""
        allowed = ", ".join([*known, "preload"])
        raise InvalidInputError(f"{source}: limits.{key}: {hint}expected one of {allowed}")
    number = _number(value)
    if number is None:
        raise InvalidInputError(
            f"{source}: limits.{key} = {shown(value)}: expected a finite number"
        )
    kind, unit = known[key]
    units, sign, size, columns, _ = _KINDS[kind]
    si = units[unit]
    return kind, Limit(key, number, si, sign, abs(number * si) or size, columns)
