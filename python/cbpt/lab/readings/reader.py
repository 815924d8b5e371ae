"""A measurement: readings of the elastic angle under torque and preload.

    read_readings   a file, a mapping of columns or a data frame -> Readings (in `readings`)

`headers` reads what a header means; `text`, `files` and `in_memory` make columns of a source; this
module checks what a table of readings must hold. Two rules: a unit is never guessed, and no row
silently disappears.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Unit
from cbpt.errors import Mistake, ReadingsError, Setting, TakeColumn, Words
from cbpt.lab.readings.chosen_rows import chosen_rows
from cbpt.lab.readings.files import read_file
from cbpt.lab.readings.headers import (
    CONTRACT,
    Header,
    Quantity,
    converted,
    find_unit,
    other_unit,
    plain,
    read_header,
    read_stated,
    unit_at_end,
)
from cbpt.lab.readings.in_memory import read_columns
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.remarks import are_levels, remarks, taken_together
from cbpt.lab.readings.stretches import stretches
from cbpt.lab.readings.text import Column, Loaded, Table
from cbpt.lab.readings.whole_turns import absurd, unwrapped, unwrapped_note

__all__ = ["Readings", "read_readings"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def read_readings(
    source: str | os.PathLike[str] | Mapping[str, ArrayLike] | Any,
    *,
    lever_arm_mm: float | None = None,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    need_preload: bool = True,
    fill: Mapping[str, float] | None = None,
    only: Mapping[str, Any] | None = None,
    by: str | None = None,
) -> Readings:
    """Read a table of readings.

    Torque and elastic angle (or the displacement of a sensor) are needed. A run that is out of time
    order is sorted, and a note says so.

    Parameters
    ----------
    source : str, PathLike, mapping, data frame or data set
        The path of a text table (CSV), a workbook (xlsx, xls, ods), or a MATLAB, TDMS or Parquet
        file. Or columns in memory: a mapping of names to values, a data frame (pandas, polars,
        pyarrow), a structured array or an xarray data set, each column of shape (n,).
    lever_arm_mm : float, optional
        Radius at which the displacement sensor reads, mm. A table with `sensor_displacement_um` in
        place of the elastic angle needs it; the angle is then atan(displacement / lever arm).
    columns : mapping of str to str, optional
        What a header means, for example ``{"Moment": "torque_Nm"}``. The name may end in any known
        unit (`elastic_angle_deg`); `extra` sets a column aside.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file. Without it, the first
        one that has readings is taken.
    need_preload : bool
        Whether a table without a preload is an error. If not, nothing is said of it.
    fill : mapping of str to float, optional
        Value for every reading where the table has no such column: `preload_N`, `input_angle_deg`.
        A note says where it was used.
    only : mapping, optional
        The readings to take, for example ``{"design": "conic", "preload_step": [3, 4]}``: rows
        whose cells have this value, or one of these, compared as text or as numbers.
    by : str, optional
        A column whose cells are kept as `labels`, to divide the readings by.

    Returns
    -------
    Readings
        Arrays of shape (n,), sorted by run and time.

    Raises
    ------
    ReadingsError
        The table has mistakes. The message has each one with line, column, value and what was
        expected.
    TypeError
        `source` is nothing that holds a table.

    Examples
    --------
    >>> import cbpt
    >>> table = {"torque_Nm": [1, 2], "preload_N": [600, 600], "elastic_angle_arcsec": [2.5, 5.0]}
    >>> len(cbpt.read_readings(table))
    2
    """
    if lever_arm_mm is not None and not (math.isfinite(lever_arm_mm) and lever_arm_mm > 0):
        mistake = Mistake((), "lever_arm_mm", f"{lever_arm_mm!r}", "a length above 0")
        raise ReadingsError(_name(source), [mistake])
    columns = columns or {}
    if isinstance(source, str | os.PathLike):
        table = read_file(source, sheet, columns)
    else:
        table = read_columns(source)
    reader = _Reader(table, columns, lever_arm_mm, need_preload, fill or {})
    reader.kept = tuple(dict.fromkeys([*(only or {}), *([by] if by else [])]))
    reader.by = by
    return chosen_rows(reader.read(), only or {})


def _name(source: object) -> str:
    return os.fsdecode(source) if isinstance(source, str | os.PathLike) else "<data>"


_QUANTITY = {quantity.key: quantity for quantity in CONTRACT}
_UNIT = {q.key: unit for q in CONTRACT if (unit := find_unit(q.unit, q.kind or None))}
_COLUMNS = {quantity.column: quantity.key for quantity in CONTRACT}
_POSITIVE = {"preload", "u_elastic_angle", "u_sensor_displacement"}
_SENSOR = {"sensor_displacement": "elastic_angle", "u_sensor_displacement": "u_elastic_angle"}
_WITHOUT = {
    "time": "the rows are used in file order, and drift and creep cannot be detected",
    # Where the model needs a preload, a table without one is a mistake; where not, nothing is lost.
    "preload": "",
    "input_angle": "0 deg is used for every row, so effects that vary with the input angle "
    "cannot be detected",
    "temperature": "thermal effects cannot be detected",
    "u_elastic_angle": "the uncertainty of a reading has to be estimated",
}
_ARCSEC_PER_RAD = 648000.0 / math.pi
_WHOLE = re.compile(r"[+-]?[0-9]{1,18}(?:[.,]0*)?")


@dataclass(frozen=True, slots=True)
class _Use:
    """What one column is used for: the quantity it holds and, once stated, the unit it is in."""

    index: int
    header: str
    quantity: Quantity
    unit: Unit | None


def _overlooked(header: str, below: str, columns: Mapping[str, str], kept: Sequence[str]) -> str:
    """Why a column is not used that has a unit, and so may be meant to be."""
    wanted = header in columns or header in kept
    has_unit = find_unit(below or unit_at_end(header)) is not None
    if wanted or not has_unit:
        return ""
    return Words(
        "no quantity is read from this header; to use it, name its quantity by ", Setting("columns")
    )


class _Reader:
    """One table on its way to Readings; gathers mistakes and notes as it goes."""

    def __init__(
        self,
        table: Table,
        columns: Mapping[str, str],
        lever_arm_mm: float | None,
        need_preload: bool,
        fill: Mapping[str, float],
    ) -> None:
        self.table = table
        self.columns = columns
        self.lever_arm_mm = lever_arm_mm
        self.need_preload = need_preload and "preload_N" not in fill
        self.fill = {_COLUMNS[name]: value for name, value in fill.items()}
        self.mistakes: list[Mistake] = []
        self.notes = list(table.notes)
        self.kept: tuple[str, ...] = ()
        self.by: str | None = None
        self.levels: dict[str, NDArray[np.str_]] = {}

    def read(self) -> Readings:
        uses = self.assign()
        run, step = uses.get("run"), uses.get("preload_step")
        kept = self.columns_kept(uses)
        as_text = {use.index for use in (run, step) if use} | set(kept.values())
        loaded = self.table.load(as_text)
        self.mistakes += loaded.mistakes
        if not len(loaded.lines) and not loaded.mistakes:
            self.wrong("", "no rows under the headers", "a row for each reading")
        for use in uses.values():
            self.check(use, loaded)
        if self.by in kept:
            self.check_levels(self.by, loaded.columns[kept[self.by]], loaded.lines)
        self.stop_if_wrong()  # what follows needs whole columns
        values = {key: self.in_own_unit(use, loaded) for key, use in uses.items()}
        labels = self.labels(loaded.columns[run.index]) if run else self.runs_of(values)
        extra = self.extra(uses, loaded, set(kept.values()))
        readings = self.build(values, labels, extra, loaded.lines)
        readings = dataclasses.replace(
            readings,
            preload_step=self.labels(loaded.columns[step.index]) if step else None,
            labels=self.levels
            | {name: np.array(loaded.columns[i].text) for name, i in kept.items()},
        )
        readings = self.in_time(readings, has_runs=run is not None)
        self.stop_if_wrong()
        if run and readings.run_index.max() == 0:
            self.notes.append(
                "the table has one run, so differences between runs cannot be detected"
            )
        return dataclasses.replace(readings, notes=(*self.notes, *remarks(readings)))

    def wrong(
        self,
        column: str,
        value: str,
        expected: str,
        remedy: str = "",
        lines: Sequence[int] | None = None,
    ) -> None:
        """Take down a mistake: on `lines`, else in the line of headers if there is one."""
        if lines is None:
            lines = (self.table.line,) if self.table.line else ()
        self.mistakes.append(Mistake(tuple(lines), column, value, expected, remedy))

    def stop_if_wrong(self) -> None:
        if self.mistakes:
            raise ReadingsError(self.table.source, self.mistakes, self.table.place)

    # --- which column is what -------------------------------------------------------------

    def assign(self) -> dict[str, _Use]:
        """The column of each quantity."""
        headers = self.table.headers
        units = self.table.units or ("",) * len(headers)
        for name in self.columns.keys() - set(headers):
            known = ", ".join(map(repr, headers))
            self.wrong(
                name, Words(f"{name!r} in ", Setting("columns")), f"one of the headers {known}"
            )
        uses: dict[str, _Use] = {}
        asked: set[str] = set()  # quantities that a header may mean but does not state
        hints: dict[str, str] = {}  # headers that mean none, and why not if they come close
        told: list[str] = []
        means = [self.understand(name, below) for name, below in zip(headers, units, strict=True)]
        stated = {m.quantity.key: i for i, m in enumerate(means) if m.quantity and not m.expected}
        for index, (name, below) in enumerate(zip(headers, units, strict=True)):
            said = means[index]
            if said.expected and name in self.kept and name not in self.columns:
                # Wanted for its cells: a label, though its name may mean a quantity without unit.
                said = Header()
            if said.bare and said.quantity and said.quantity.key in stated:
                # "moment" beside "torque_Nm" may as well be the moment of the measurement.
                other = headers[stated[said.quantity.key]]
                said = Header(hint=f"it states no unit, and {other!r} is the {said.quantity.key}")
            if said.expected:
                asked |= {quantity.key for quantity in said.candidates}
                found = f"{name!r} with the unit {below!r}" if below else repr(name)
                self.wrong(name, found, said.expected, said.remedy)
            if said.quantity is None:
                hints[name] = said.hint or _overlooked(name, below, self.columns, self.kept)
            elif said.quantity.key in uses:
                key = said.quantity.key
                found = f"{uses[key].header!r} and {name!r}"
                remedy = Words("to leave one out, ", TakeColumn(name, "extra"))
                self.wrong(name, found, f"only one column for {key}", remedy)
            else:
                uses[said.quantity.key] = _Use(index, name, said.quantity, said.unit)
                if said.unit and name != said.quantity.column:
                    own = other_unit(said.unit, name, below)
                    but = f", though its header says {own.written}" if own else ""
                    told.append(f"{name!r} as {said.quantity.key} in {said.unit.written}{but}")
        for sensor, angle in _SENSOR.items():
            if sensor in uses and angle in uses:
                spare = uses.pop(sensor)
                self.notes.append(
                    f"column {spare.header!r} is not used: the table also has {angle}"
                )
        self.require(uses, asked, hints)
        self.notes += [f"read {', '.join(told)}"] if told else []
        self.notes += [
            Words(f"column {name!r} is not used: ", hint) for name, hint in hints.items() if hint
        ]
        return uses

    def columns_kept(self, uses: dict[str, _Use]) -> dict[str, int]:
        """Where the columns stand whose cells are wanted as text, by header or by quantity."""
        headers = self.table.headers
        places = {use.quantity.column: use.index for use in uses.values()}
        places |= {header: index for index, header in enumerate(headers)}
        for name in self.kept:
            if name not in places:
                known = ", ".join(map(repr, headers))
                self.wrong(name, "no such column", f"one of the headers {known}")
        return {name: places[name] for name in self.kept if name in places}

    def understand(self, name: str, below: str) -> Header:
        """What a header means: as `columns` state it, else as it reads."""
        stated = self.columns.get(name)
        return read_header(name, below) if stated is None else read_stated(stated, name, below)

    def require(self, uses: dict[str, _Use], asked: set[str], hints: dict[str, str]) -> None:
        """Mistakes for the quantities that have to be there, notes for the others."""
        given = uses.keys() | asked
        sensor = uses.get("sensor_displacement") or uses.get("u_sensor_displacement")
        if sensor and self.lever_arm_mm is None:
            expected = (
                "lever_arm_mm under [measurement] in the case (the radius at which the "
                "sensor reads)"
            )
            remedy = Words("or, to leave the column out, ", TakeColumn(sensor.header, "extra"))
            self.wrong(sensor.header, "no lever arm", expected, remedy)
        given |= {_SENSOR[key] for key in given & _SENSOR.keys()}
        for key in ["torque", "elastic_angle"] + ["preload"] * self.need_preload:
            if key not in given | self.fill.keys():
                self.missing(_QUANTITY[key], hints)
        for key, lost in _WITHOUT.items():
            if key in given:
                continue
            column = _QUANTITY[key].column
            if key in self.fill:
                lost = f"{self.fill[key]:g} is used for every reading"
            if lost:
                self.notes.append(f"the table has no {column} column: {lost}")

    def missing(self, quantity: Quantity, hints: dict[str, str]) -> None:
        """A mistake that names the free headers which may have been meant."""
        own = set(quantity.key.split("_"))
        typos = difflib.get_close_matches(quantity.column, hints, n=3, cutoff=0.6)
        shared = [
            name
            for name in hints
            if own & set(plain(name).split())
            or any(plain(name).startswith(f"{letter} ") for letter in quantity.letters)
        ]
        near = list(dict.fromkeys(typos + shared))
        header = near[0] if near else "your header"
        below = dict(zip(self.table.headers, self.table.units or (), strict=False))
        written = below.get(header) or unit_at_end(header)
        unit = find_unit(written, quantity.kind)
        fits = unit is not None and unit.quantity == quantity.kind
        column = f"{quantity.key}_{written}" if fits else quantity.column
        remedy = Words(
            "rename a column, or ", TakeColumn(header, column), " with the unit that the column has"
        )
        if near:
            remedy = Words(remedy, "; similar headers: ")
            for place, name in enumerate(near):
                why = (" (", hints[name], ")") if hints[name] else ()
                remedy = Words(remedy, f"{', ' * (place > 0)}{name!r}", *why)
        if len(self.table.headers) == 1:
            remedy = Words(remedy, "; separate the columns by commas, semicolons or tabs")
        found = ", ".join(map(repr, self.table.headers))
        self.wrong(
            quantity.column, f"only the headers {found}", f"a column {quantity.column}", remedy
        )

    # --- what its cells hold --------------------------------------------------------------

    def check(self, use: _Use, loaded: Loaded) -> None:
        """Mistakes for the cells of a column that cannot be used."""
        column, key = loaded.columns[use.index], use.quantity.key
        wrong: dict[str, list[int]] = {}
        if column.clock and use.quantity.kind not in ("", "time"):
            wrong["a number, not a date or a duration"] = list(range(len(column.numbers)))
        for row, cell in column.odd.items():
            if key in {"run", "preload_step"}:
                if cell == "" or cell.casefold() == "nan":
                    wrong.setdefault(f"a label for the {key.replace('_', ' ')}", []).append(row)
            elif _is_boundless(cell):
                wrong.setdefault("a finite number", []).append(row)
            else:
                wrong.setdefault(self.table.number, []).append(row)
        if key in _POSITIVE:
            rows = np.flatnonzero(column.numbers <= 0).tolist()
            wrong |= {"a number above 0": rows} if rows else {}
        remedy = Words("correct the cell or remove the row")
        if key not in {"torque", "elastic_angle", "preload", "sensor_displacement"}:
            remedy = Words(
                remedy, "; to leave the whole column out, ", TakeColumn(use.header, "extra")
            )
        for expected, rows in wrong.items():
            first = column.odd.get(rows[0], f"{column.numbers[rows[0]]:g}")
            found = repr(first) if first else "an empty cell"
            self.wrong(use.header, found, expected, remedy, loaded.lines[rows].tolist())

    def check_levels(self, name: str, column: Column, lines: Ints) -> None:
        """A mistake for the cells that say no level."""
        empty = [row for row, text in enumerate(column.text) if text.casefold() in {"", "nan"}]
        if empty:
            remedy = "write the level of the reading in the cell, or remove the row"
            self.wrong(name, "an empty cell", "a level in each row", remedy, lines[empty].tolist())

    @staticmethod
    def in_own_unit(use: _Use, loaded: Loaded) -> Floats:
        """The numbers of a column in its standard unit."""
        column = loaded.columns[use.index]
        unit = _UNIT["time"] if column.clock else use.unit
        own = _UNIT.get(use.quantity.key)
        return converted(column.numbers, unit, own) if unit and own else column.numbers

    @staticmethod
    def labels(column: Column) -> NDArray[Any]:
        """Labels of runs: whole numbers where all of them are (01 is 1), else text."""
        whole = {
            text: int(re.split("[.,]", text)[0])
            for text in dict.fromkeys(column.text)
            if _WHOLE.fullmatch(text)
        }
        if all(text in whole for text in column.text):
            return np.array([whole[text] for text in column.text], dtype=np.int64)
        return np.array([str(whole.get(text, text)) for text in column.text], dtype=np.str_)

    def extra(self, uses: dict[str, _Use], loaded: Loaded, kept: set[int]) -> dict[str, Floats]:
        """The columns without a use: numbers are kept, for anything else there is a note."""
        used = {use.index for use in uses.values()}
        found: dict[str, Floats] = {}
        for index, column in enumerate(loaded.columns):
            name = self.table.headers[index] or f"column {index + 1}"
            filled = {row: cell for row, cell in column.odd.items() if cell}
            if index in used or (not filled and len(column.odd) == len(column.numbers)):
                continue
            text = next((row for row, cell in filled.items() if not _is_boundless(cell)), None)
            if text is not None and index in kept:
                continue
            if column.clock:
                note = (
                    f"ignored column {name!r}: it has dates or durations; if it is the time of the "
                )
                self.notes.append(Words(note, "readings, ", TakeColumn(name, "time_s")))
                continue
            if text is not None:
                where = f"{self.table.place} {loaded.lines[text]}"
                self.notes.append(
                    f"ignored column {name!r}: {where} has {filled[text]!r}, which is no number"
                )
                cells = list(filled.values())
                several = are_levels(cells)
                if len(cells) == len(column.numbers) and (several or len(set(cells)) == 1):
                    self.levels[name] = np.array(cells)
                    if several:
                        self.notes.append(taken_together(name, cells))
                continue
            for row, cell in filled.items():  # nan and inf
                column.numbers[row] = float(cell)
            found[name] = column.numbers
        return found

    # --- the readings ---------------------------------------------------------------------

    def runs_of(self, values: dict[str, Floats]) -> NDArray[Any]:
        """Labels where the table has none."""
        set_up = [values[key] for key in ("preload", "input_angle") if key in values]
        torque = values["torque"]
        # Rows out of time order, or clocks that start anew, are for the user to say.
        in_order = (np.diff(values.get("time", np.arange(len(torque)))) > 0).all()
        found = stretches(set_up, torque) if set_up and in_order else None
        if found is None:
            found = np.ones(len(torque), dtype=np.int64)
            taken = "all rows are treated as one run, so differences between runs cannot be told"
        else:
            taken = (
                "each stretch at one preload and one input angle is taken as a run, "
                f"{found[-1]} in all"
            )
        self.notes.append(f"the table has no run column: {taken}")
        return found

    def build(
        self, values: dict[str, Floats], run: NDArray[Any], extra: dict[str, Floats], line: Ints
    ) -> Readings:
        if self.lever_arm_mm is not None:
            arm_um = 1e3 * self.lever_arm_mm
            if "sensor_displacement" in values:
                self.notes.append(
                    "the elastic angle is atan(displacement / lever arm), with the lever arm of "
                    f"{self.lever_arm_mm:g} mm"
                )
                slope = values["sensor_displacement"] / arm_um
                values["elastic_angle"] = np.arctan(slope) * _ARCSEC_PER_RAD
            if "u_sensor_displacement" in values:
                # d alpha / d dh = cos(alpha)^2 / h
                cosine = np.cos(values["elastic_angle"] / _ARCSEC_PER_RAD)
                slope = values["u_sensor_displacement"] / arm_um
                values["u_elastic_angle"] = slope * cosine**2 * _ARCSEC_PER_RAD
        self.check_angles(values, run, line)
        everywhere = {key: np.full(len(line), value) for key, value in self.fill.items()}
        values = {"input_angle": np.zeros(len(line))} | everywhere | values
        return Readings(
            torque_Nm=values["torque"],
            preload_N=values.get("preload"),
            input_angle_deg=values["input_angle"],
            elastic_angle_arcsec=values["elastic_angle"],
            u_elastic_angle_arcsec=values.get("u_elastic_angle"),
            run=run,
            time_s=values.get("time"),
            cycle=values.get("cycle"),
            temperature_degC=values.get("temperature"),
            line=line,
            source=self.table.source,
            sha256=self.table.sha256,
            extra=extra,
            place=self.table.place,
        )

    def check_angles(self, values: dict[str, Floats], run: NDArray[Any], line: Ints) -> None:
        """Takes whole turns off the angles, and stops at angles that no drive has."""
        index = np.unique(run, return_inverse=True)[1].ravel()
        if "elastic_angle" in values:
            values["elastic_angle"], jumps = unwrapped(values["elastic_angle"], index)
            if len(jumps):
                self.notes.append(unwrapped_note(self.table.place, line[jumps].tolist()))
        for key, rows, value, expected in absurd(values, index):
            remedy = "check the unit of the column"
            self.wrong(_QUANTITY[key].column, value, expected, remedy, lines=line[rows].tolist())
        self.stop_if_wrong()

    def in_time(self, readings: Readings, has_runs: bool) -> Readings:
        """The readings with each run in order of time, every run on the rows that it has."""
        time, index = readings.time_s, readings.run_index
        if time is None:
            return readings
        rows = np.argsort(index, kind="stable")  # run after run, each in file order
        by_time = np.lexsort((time, index))  # the same, each in order of time
        line, t, run = readings.line[by_time], time[by_time], index[by_time]
        same = np.flatnonzero((t[1:] == t[:-1]) & (run[1:] == run[:-1]))
        moved = readings.line[rows[rows != by_time]]
        starts_anew = len(moved) and not has_runs
        remedy = "give times in finer steps, or leave the column out"
        if starts_anew:
            remedy = "add a run column if the clock starts anew for each loop"
        for k in same[: ReadingsError.MOST].tolist():
            twice = f"{t[k]:g} s twice in run {readings.run[by_time[k]]}"
            expected = "a different time for each reading of a run"
            copied = "remove the copy, as both rows have the same torque and angle"
            how = copied if readings.alike(*by_time[k : k + 2].tolist()) else remedy
            self.wrong("time_s", twice, expected, how, sorted(line[k : k + 2].tolist()))
        if starts_anew:
            # A clock that starts anew for each loop looks just so: sorting would mix the loops.
            late = rows[1:][np.diff(time[rows]) < 0][0]
            remedy = "add a run column, or sort the rows by time if they are one run"
            back = f"{time[late]:g} s after {time[late - 1]:g} s"
            expected = "a time that increases from row to row"
            self.wrong("time_s", back, expected, remedy, [int(readings.line[late])])
        if not len(moved) or self.mistakes:
            return readings
        runs = ", ".join(map(str, dict.fromkeys(readings.run[rows[rows != by_time]].tolist())))
        where = f"{len(moved)} rows from {self.table.place} {moved.min()} on"
        self.notes.append(f"sorted by time within run {runs}: {where} were out of order")
        order = np.empty_like(rows)
        order[rows] = by_time
        return readings.select(order)


def _is_boundless(cell: str) -> bool:
    """Whether an odd cell is a number after all, but nan, inf or too large for a float."""
    try:
        return not math.isfinite(float(cell))
    except ValueError:
        return False
