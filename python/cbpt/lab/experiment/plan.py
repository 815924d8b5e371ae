"""A plan: the loads of a campaign that has not been run.

    PlannedRun  one run: torques in turn, preload, input angles, times
    Plan        all rows of a campaign, as a table of readings whose angles are yet to be read
    read_plan   a TOML list of runs, or any table of readings less the angle -> Plan
    table_text  rows of a plan or of readings as CSV

Keys of a TOML plan carry their unit as those of a case file do; what stands above the first run
holds for every run that does not say otherwise.
"""

from __future__ import annotations

import csv
import difflib
import io
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive
from cbpt.errors import PlanError, ReadingsError
from cbpt.lab.readings.headers import (
    CONTRACT,
    converted,
    find_unit,
    read_header,
    unit_at_end,
    units_of,
)
from cbpt.lab.readings.reader import Readings, read_readings
from cbpt.lab.wording import html
from cbpt.lab.wording.numbers import significant
from cbpt.sketch import Series, sketch
from cbpt.toml_files import is_number, read_toml, shown

__all__ = ["Plan", "PlannedRun", "read_plan", "sequence", "table_text"]

Floats = NDArray[np.float64]

SHAPES = ("up", "up_down", "loop", "hold")
PAUSE_S = 60.0
"""Between two runs, where the plan has times and says nothing."""
_MOST_POINTS, _MOST_REPEATS, _MOST_ROWS = 10_000, 1_000, 200_000
_LARGEST = 1e12  # in any unit; no rig has such a load


@dataclass(frozen=True)
class PlannedRun:
    """One run: the torques in turn, at each of the input angles in turn.

    dwell_s: from one reading to the next; rate_Nm_per_s: of the torque in between. Without both
    the run has no times. cycles: how often all of it is gone through; None: not counted.
    temperature_degC: at the first and at the last reading.
    """

    torque_Nm: tuple[float, ...]
    preload_N: float | None = None
    input_angle_deg: tuple[float, ...] = (0.0,)
    u_elastic_angle_arcsec: float | None = None
    temperature_degC: tuple[float, float] | None = None
    dwell_s: float | None = None
    rate_Nm_per_s: float | None = None
    pause_s: float = PAUSE_S
    cycles: int | None = None

    def __len__(self) -> int:
        return len(self.torque_Nm) * len(self.input_angle_deg) * (self.cycles or 1)

    @property
    def timed(self) -> bool:
        """Whether it has times."""
        return self.dwell_s is not None or self.rate_Nm_per_s is not None

    def columns(self, start_s: float = 0.0) -> dict[str, Floats]:
        """Its rows, shape (n,) each; a column that the run does not have is left out."""
        turns, torques = self.cycles or 1, len(self.torque_Nm)
        once = len(self.input_angle_deg) * torques
        torque = np.tile(self.torque_Nm, turns * len(self.input_angle_deg))
        n = len(torque)
        found = {
            "torque_Nm": torque,
            "input_angle_deg": np.tile(np.repeat(self.input_angle_deg, torques), turns),
        }
        if self.preload_N is not None:
            found["preload_N"] = np.full(n, self.preload_N)
        if self.timed:
            step = np.full(n - 1, self.dwell_s or 0.0)
            if self.rate_Nm_per_s is not None:
                step += np.abs(np.diff(torque)) / self.rate_Nm_per_s
            found["time_s"] = start_s + np.r_[0.0, np.cumsum(step)]
        if self.temperature_degC is not None:
            found["temperature_degC"] = np.linspace(*self.temperature_degC, n)
        if self.cycles is not None:
            found["cycle"] = 1.0 + np.arange(n) // once
        if self.u_elastic_angle_arcsec is not None:
            found["u_elastic_angle_arcsec"] = np.full(n, self.u_elastic_angle_arcsec)
        return found

    def to_toml(self) -> str:
        """As `[[run]]` of a plan."""
        lines = ["[[run]]"]
        for name, value in vars(self).items():
            if value is None or (name == "pause_s" and not self.timed):
                continue
            numbers = value if isinstance(value, tuple) else (value,)
            text = ", ".join(f"{v:.9g}" for v in numbers)
            if name == "temperature_degC":
                text = f"{{ from = {numbers[0]:.9g}, to = {numbers[-1]:.9g} }}"
            elif len(numbers) > 1:
                text = f"[{text}]"
            lines.append(f"{name} = {text}")
        return "\n".join(lines) + "\n"


def _ends(values: tuple[float, ...]) -> str:
    """The values of a run, or between which they lie."""
    if len(values) < 4:
        return ", ".join(f"{v:g}" for v in values)
    return f"{min(values):g} to {max(values):g} ({len(values)})"


@dataclass(frozen=True, eq=False)
class Plan:
    """A campaign that has not been run."""

    rows: Readings
    """What will be set, and the uncertainty; the elastic angle is NaN everywhere."""
    runs: tuple[PlannedRun, ...] = ()
    """As planned; empty where the plan is a table."""

    @classmethod
    def of_runs(cls, runs: Sequence[PlannedRun], source: str = "<plan>") -> Plan:
        """A campaign of these runs in this order. Raises `PlanError` where they do not agree on
        which columns there are.
        """
        if not runs:
            raise PlanError(f"{source}: no runs; write a [[run]] for each")
        total = sum(map(len, runs))
        if total > _MOST_ROWS:
            raise _too_many(source, total)
        tables: list[dict[str, Floats]] = []
        clock = 0.0
        for number, run in enumerate(runs, 1):
            columns = run.columns(clock)
            if "time_s" in columns:
                clock = float(columns["time_s"][-1]) + run.pause_s
            tables.append({"run": np.full(len(run), float(number)), **columns})
            for name in tables[0].keys() ^ columns.keys() - {"run"}:
                has, lacks = (number, 1) if name in columns else (1, number)
                if name != "run":
                    remedy = "state dwell_s or rate_Nm_per_s" if name == "time_s" else "state it"
                    raise PlanError(
                        f"{source}: run {has} has {name} and run {lacks} has none; "
                        f"{remedy} above the first [[run]] to give it to every run"
                    )
        joined = {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}
        return cls(_as_rows(joined, source), tuple(runs))

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return repr(self.rows).replace("Readings(", "Plan(").replace("reading", "row")

    def _repr_html_(self) -> str:
        """As a notebook shows it: a table of the runs, or of the rows; their torque."""
        if not self.runs:
            return self.rows._repr_html_() + self._sketch()
        headers = ["run", "rows", "preload_N", "torque_Nm", "input_angle_deg", "dwell_s"]
        runs = [
            [
                number,
                len(run),
                run.preload_N,
                _ends(run.torque_Nm),
                _ends(run.input_angle_deg),
                run.dwell_s,
            ]
            for number, run in enumerate(self.runs, 1)
        ]
        return html.paragraph(repr(self)) + html.table(headers, runs) + self._sketch()

    def _sketch(self) -> str:
        """The torque of each run over the time, or over the number of the row."""
        rows = self.rows
        clock = np.arange(1.0, len(rows) + 1) if rows.time_s is None else rows.time_s
        runs = [
            Series(f"run {run}", clock[at], rows.torque_Nm[at])
            for run in dict.fromkeys(rows.run.tolist())
            for at in [rows.run == run]
        ]
        return sketch(runs, "row" if rows.time_s is None else "time_s", "torque_Nm")

    def to_csv(self) -> str:
        """The rows as a table, which `read_plan` takes as well."""
        return table_text(self.rows)

    def to_toml(self) -> str:
        """The runs as a plan file; raises `PlanError` where the plan is a table."""
        if not self.runs:
            raise PlanError(
                f"{self.rows.source}: this plan was read from a table of loads, which a TOML plan "
                "cannot hold; write it to a file that ends in .csv"
            )
        return "\n".join(run.to_toml() for run in self.runs)

    def with_u(self, u_elastic_angle_arcsec: float | None) -> Plan:
        """The plan with this standard uncertainty at every row. Raises `PlanError` where there is
        none to be had.
        """
        if u_elastic_angle_arcsec is None:
            if self.rows.u_elastic_angle_arcsec is None:
                raise PlanError(
                    f"{self.rows.source}: no u_elastic_angle_arcsec; state the standard "
                    "uncertainty of a reading in the plan or with --u-arcsec "
                    "(u_elastic_angle_arcsec=)"
                )
            return self
        u = float(u_elastic_angle_arcsec)
        if not (math.isfinite(u) and u > 0):
            raise PlanError(f"u_elastic_angle_arcsec: found {u:g}, expected a number above 0")
        rows = replace(self.rows, u_elastic_angle_arcsec=np.full(len(self), u))
        runs = tuple(replace(run, u_elastic_angle_arcsec=u) for run in self.runs)
        return Plan(rows, runs)


def read_plan(
    source: Plan | Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    case: Case | Drive | None = None,
    *,
    columns: Mapping[str, str] | None = None,
) -> Plan:
    """Read a plan of a campaign.

    Parameters
    ----------
    source : Plan, Readings, str, PathLike or mapping
        The path of a TOML list of runs, or a table as `read_readings` takes it. The angles of a
        table are not used and may be missing.
    case : Case or Drive, optional
        Fills in preload and input angle where the plan has none.
    columns : mapping of str to str, optional
        What headers of a table mean, as in `read_readings`.

    Returns
    -------
    Plan
        The loads of the campaign, arrays of shape (n,).

    Raises
    ------
    PlanError
        A TOML plan cannot be read. The message has file, run, key, what was found and what was
        expected.
    ReadingsError
        A table cannot be read.
    """
    if isinstance(source, Plan):
        return source
    if isinstance(source, Readings):
        return Plan(_without_angle(source))
    load: dict[str, float] = {}
    if isinstance(case, Case):
        given = {"preload_N": case.preload_N, "input_angle_deg": case.input_angle_deg}
        load = {name: value for name, value in given.items() if value is not None}
    if isinstance(source, str | os.PathLike) and Path(source).suffix.lower() == ".toml":
        return _Reader(os.fsdecode(source), load).read()
    lever_arm_mm = case.lever_arm_mm if isinstance(case, Case) else None
    rows = read_readings(
        source,
        lever_arm_mm=lever_arm_mm,
        columns=columns,
        need_preload=False,
        fill={"elastic_angle_arcsec": math.nan, **load},
    )
    return Plan(_without_angle(rows))


def _too_many(source: str, rows: int) -> PlanError:
    """A plan that is larger than any campaign."""
    return PlanError(f"{source}: {rows} readings or more, expected at most {_MOST_ROWS}")


def _as_rows(columns: Mapping[str, ArrayLike], source: str) -> Readings:
    angle = {"elastic_angle_arcsec": math.nan}
    try:
        rows = read_readings(columns, need_preload=False, fill=angle)
    except ReadingsError as error:
        raise ReadingsError(source, error.mistakes, error.place) from None
    return replace(rows, source=source)


def _without_angle(rows: Readings) -> Readings:
    return replace(rows, elastic_angle_arcsec=np.full(len(rows), math.nan))


def sequence(shape: str, to: float, points: int, start: float | None = None) -> tuple[float, ...]:
    """Torques (or angles) of a shape, `points` from the start to the peak.

    up: start to `to`; up_down: and back; loop: 0 to `to`, down to `start` (-to), back to 0; hold:
    `start`, then `to` at all other points. The start is 0 (of a loop -to) where none is given.
    """
    steps = max(points - 1, 1)
    first = (-to if shape == "loop" else 0.0) if start is None else start
    if shape == "hold":
        return (first, *(to,) * steps)
    if shape == "loop":
        back = max(round(steps * abs(to - first) / max(abs(to), 1e-300)), 1)
        home = max(round(steps * abs(first) / max(abs(to), 1e-300)), 1)
        rise, fall = np.linspace(0, to, points), np.linspace(to, first, back + 1)[1:]
        way = np.r_[rise, fall, np.linspace(first, 0.0, home + 1)[1:] if first else []]
    else:
        way = np.linspace(first, to, points)
        way = np.r_[way, way[-2::-1]] if shape == "up_down" else way
    return tuple(significant(v, 12) for v in way)


def table_text(readings: Readings) -> str:
    """Readings as a CSV table; an angle that is NaN everywhere is left out, and so is every column
    that the readings do not have.
    """
    names, columns = [], []
    for column in (quantity.column for quantity in CONTRACT):
        values = getattr(readings, column, None)
        if values is None or (values.dtype.kind == "f" and np.isnan(values).all()):
            continue
        names.append(column)
        whole = values.dtype.kind != "f"
        columns.append([str(v) if whole else f"{v:.9g}" for v in values.tolist()])
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([names, *zip(*columns, strict=True)])
    return out.getvalue()


# --- the TOML file ------------------------------------------------------------------------

_QUANTITIES = ("torque", "preload", "input_angle", "temperature", "u_elastic_angle")
_OWN = {quantity.key: quantity for quantity in CONTRACT}
_TIMES = ("dwell", "pause")
_KEYS = (
    *(_OWN[key].column for key in _QUANTITIES),
    *("dwell_s", "pause_s", "rate_Nm_per_s", "repeats", "cycles"),
)
_RANGE = ("from", "to", "count", "points", "shape")
"""`count`, as plans of sweeps have it; `points` is the same."""


class _Reader:
    """One TOML plan on its way to a Plan."""

    def __init__(self, source: str, load: Mapping[str, float]) -> None:
        self.source = source
        self.load = load

    def read(self) -> Plan:
        document = read_toml(self.source, PlanError, "a plan (TOML)")
        runs = document.pop("run", None)
        if not isinstance(runs, list) or not runs or not all(isinstance(r, dict) for r in runs):
            raise PlanError(
                f"{self.source}: found no [[run]], expected one for each run, for example\n"
                "  [[run]]\n  preload_N = 600\n  torque_Nm = "
                '{ to = 10, count = 11, shape = "loop" }'
            )
        common = self.understood("above the first run", document)
        planned: list[PlannedRun] = []
        rows = 0
        for number, entry in enumerate(runs, 1):
            for run in self.runs(f"[[run]] {number}", common, entry):
                planned.append(run)
                if (rows := rows + len(run)) > _MOST_ROWS:
                    raise _too_many(self.source, rows)
        plan = Plan.of_runs(planned, self.source)
        return replace(plan, rows=replace(plan.rows, notes=tuple(self.notes(plan.rows))))

    @staticmethod
    def notes(rows: Readings) -> Iterator[str]:
        if rows.time_s is None:
            yield (
                "no dwell_s and no rate_Nm_per_s: without times drift and creep cannot be detected"
            )
        if len(np.unique(rows.torque_Nm)) == 1:
            yield (
                "the torque is the same in every row, so effects that depend on it cannot be "
                "detected"
            )

    def wrong(self, place: str, key: str, value: object, expected: str) -> PlanError:
        found = "nothing" if value is None else shown(value)
        return PlanError(f"{self.source}: {place}, {key}: found {found}, expected {expected}")

    def understood(self, place: str, entry: Mapping[str, Any]) -> dict[str, tuple[str, Any, float]]:
        """Each entry under its standard name: its key as written, value, factor to the
        unit of that name.
        """
        found: dict[str, tuple[str, Any, float]] = {}
        for key, value in entry.items():
            name, factor = self.meaning(place, key, value)
            if name in found:
                raise self.wrong(
                    place, key, value, f"{name} only once; {found[name][0]} states it too"
                )
            found[name] = key, value, factor
        return found

    def meaning(self, place: str, key: str, value: object) -> tuple[str, float]:
        if key in ("repeats", "cycles"):
            return key, 1.0
        stem, _, unit = key.partition("_")
        second = find_unit("s", "time")
        assert second is not None
        if stem in _TIMES:
            known = find_unit(unit, "time") if unit else None
            if known is None or known.quantity != "time":
                times = ", ".join(units_of("time"))
                raise self.wrong(place, key, value, f"a key {stem}_s; units: {times}")
            return f"{stem}_s", known.size / second.size
        if stem == "rate":
            over, per, under = unit.partition("_per_")
            torque = find_unit(over, "torque") if per else None
            time = find_unit(under, "time") if per else None
            newton_metre = find_unit("N m", "torque")
            if not torque or not time or (torque.quantity, time.quantity) != ("torque", "time"):
                raise self.wrong(place, key, value, "a key rate_Nm_per_s")
            assert newton_metre is not None
            return "rate_Nm_per_s", torque.size / newton_metre.size * second.size / time.size
        said = read_header(key)
        if said.quantity is None or said.unit is None or said.quantity.key not in _QUANTITIES:
            near = difflib.get_close_matches(key, _KEYS, 1, 0.5)
            hint = f"; did you mean {near[0]}?" if near else ""
            if said.candidates and not unit_at_end(key):
                hint = f"; add the unit to the key: {said.candidates[0].column}"
            raise self.wrong(place, key, value, f"one of {', '.join(_KEYS)}{hint}")
        return said.quantity.column, 1.0  # units of offset zero need more than a factor

    def runs(
        self, place: str, common: Mapping[str, tuple[str, Any, float]], entry: Mapping[str, Any]
    ) -> Iterator[PlannedRun]:
        """The runs of one entry: one for each preload, as often as it repeats."""
        keys = {**common, **self.understood(place, entry)}
        if "torque_Nm" not in keys:
            raise self.wrong(place, "torque_Nm", None, "the torques of the run")
        torque = self.numbers(place, keys, "torque_Nm")
        angles = self.numbers(place, keys, "input_angle_deg") or (
            self.load.get("input_angle_deg", 0.0),
        )
        preloads: tuple[float | None, ...] = self.numbers(place, keys, "preload_N", 0.0)
        temperature = None
        if "temperature_degC" in keys:
            ends = self.numbers(place, keys, "temperature_degC")
            temperature = ends[0], ends[-1]
        u = self.numbers(place, keys, "u_elastic_angle_arcsec", 0.0)
        run = PlannedRun(
            torque_Nm=torque,
            input_angle_deg=angles,
            u_elastic_angle_arcsec=u[0] if u else None,
            temperature_degC=temperature,
            dwell_s=self.number(place, keys, "dwell_s"),
            rate_Nm_per_s=self.number(place, keys, "rate_Nm_per_s"),
            pause_s=self.number(place, keys, "pause_s") or PAUSE_S,
            cycles=self.count(place, keys, "cycles"),
        )
        if len(run) > _MOST_ROWS:
            raise _too_many(self.source, len(run))
        if run.timed and np.any(np.diff(run.columns()["time_s"]) <= 0):
            key = keys["rate_Nm_per_s"][0]
            expected = "dwell_s as well: at a rate alone, equal torques in succession take no time"
            raise self.wrong(place, key, run.rate_Nm_per_s, expected)
        turns = self.count(place, keys, "repeats") or 1
        for preload in preloads or (self.load.get("preload_N"),):
            yield from repeat(replace(run, preload_N=preload), turns)

    def number(
        self, place: str, keys: Mapping[str, tuple[str, Any, float]], name: str
    ) -> float | None:
        """A number above 0."""
        if name not in keys:
            return None
        key, value, factor = keys[name]
        if not is_number(value) or value <= 0:
            raise self.wrong(place, key, value, "a number above 0")
        return float(value) * factor

    def count(
        self, place: str, keys: Mapping[str, tuple[str, Any, float]], name: str
    ) -> int | None:
        if name not in keys:
            return None
        key, value, _ = keys[name]
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not 1 <= value <= _MOST_REPEATS:
            raise self.wrong(place, key, value, f"a whole number from 1 to {_MOST_REPEATS}")
        return int(value)

    def numbers(
        self,
        place: str,
        keys: Mapping[str, tuple[str, Any, float]],
        name: str,
        above: float = -math.inf,
    ) -> tuple[float, ...]:
        """Numbers in the standard unit: one, a list, or a range; empty where not given."""
        if name not in keys:
            return ()
        key, value, _ = keys[name]
        if isinstance(value, dict):
            values = list(self.range(place, key, name, value))
        else:
            values = value if isinstance(value, list) else [value]
        if not values or not all(map(is_number, values)) or min(values) <= above:
            some = "a number above 0" if above == 0 else "a number"
            expected = f"{some}, a list of them or {{ from, to, count }}"
            if name == "torque_Nm":
                expected = f"{some}, a list of them or {{ to, count, shape }}"
            raise self.wrong(place, key, value, expected)
        if max(map(abs, values)) > _LARGEST:
            raise self.wrong(place, key, value, f"numbers of a size up to {_LARGEST:g}")
        said = read_header(key)
        own = find_unit(_OWN[said.quantity.key].unit, said.unit.quantity)  # type: ignore[union-attr]
        assert said.unit is not None and own is not None
        return tuple(converted(np.array(values, dtype=np.float64), said.unit, own).tolist())

    def range(self, place: str, key: str, name: str, entry: Mapping[str, Any]) -> tuple[float, ...]:
        unknown = next((k for k in entry if k not in _RANGE), None)
        if unknown is not None:
            keys = f"a range of the keys {', '.join(_RANGE)} alone"
            raise self.wrong(place, f"{key}.{unknown}", entry[unknown], keys)
        for bound in ("from", "to"):
            if not is_number(entry.get(bound, 0.0 if bound == "from" else None)):
                raise self.wrong(place, f"{key}.{bound}", entry.get(bound), "a number")
        if "count" in entry and "points" in entry:
            raise self.wrong(place, key, entry, "count or points, which are the same, not both")
        named = "points" if "points" in entry else "count"
        points = entry.get(named, 2 if name == "temperature_degC" else None)
        whole = isinstance(points, int) and not isinstance(points, bool)
        if not whole or not 2 <= points <= _MOST_POINTS:
            expected = f"the number of readings from the start to the peak, 2 to {_MOST_POINTS}"
            raise self.wrong(place, f"{key}.{named}", entry.get(named), expected)
        shape = entry.get("shape", "up")
        allowed = SHAPES if name == "torque_Nm" else SHAPES[:1]
        if shape not in allowed:
            raise self.wrong(place, f"{key}.shape", shape, f"one of {', '.join(allowed)}")
        start, to = entry.get("from"), float(entry["to"])
        largest = max(abs(to), abs(start or 0.0))
        if largest > _LARGEST or (shape == "loop" and to and largest > _MOST_POINTS * abs(to)):
            expected = f"ends of a size up to {_LARGEST:g}, and of a loop from not far beyond to"
            raise self.wrong(place, key, entry, expected)
        if shape == "loop" and to == 0:
            raise self.wrong(place, f"{key}.to", entry["to"], "the peak torque of the loop, not 0")
        return sequence(shape, to, points, None if start is None else float(start))
