"""Readings as data: columns of one length in the units of their names, checked, frozen, picklable.

Readings    one measurement; `readings` makes them from tables
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt.results import first_rows

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """n readings in the order of the file, by time within a run; every array is read-only.

    Units are those of the names; arrays are float64 of shape (n,) unless said. A column that the
    table does not have is None, but for `run` (then stretches at one preload and input angle, or
    all 1) and `input_angle_deg` (then all 0); `notes` say what can no longer be told without it.

    run: labels, int64 or str; run_index: int64, 0 for the first run of the table, then 1, ...
    u_elastic_angle_arcsec: standard uncertainty (k = 1).
    line: int64, the line of the file each reading stands on, 1-based (of data: the row).
    place: what `line` counts, "line" or "row".
    torque_read_Nm: what the table says where a diagnosis uses means of it as `torque_Nm`, or None.
    source: the path (with the sheet where there are several), or "<data>".
    sha256: of the bytes of the file (of data: of names and values).
    preload_step: labels, int64 or str, of a preload that was set but not measured.
    extra: the other numeric columns under their own names, NaN where a cell is empty.
    labels: the cells, as text, of the columns that were asked for by `only` or `by`, and of
    columns of words with one value or a few.
    """

    torque_Nm: Floats
    preload_N: Floats | None
    input_angle_deg: Floats
    elastic_angle_arcsec: Floats
    u_elastic_angle_arcsec: Floats | None
    run: NDArray[Any]
    time_s: Floats | None
    cycle: Floats | None
    temperature_degC: Floats | None
    line: Ints
    source: str = "<data>"
    sha256: str = ""
    notes: tuple[str, ...] = ()
    preload_step: NDArray[Any] | None = None
    extra: dict[str, Floats] = field(default_factory=dict)
    labels: dict[str, NDArray[np.str_]] = field(default_factory=dict)
    place: str = "row"
    torque_read_Nm: Floats | None = None
    run_index: Ints = field(init=False)

    def __post_init__(self) -> None:
        put = object.__setattr__  # the way to complete a frozen dataclass
        labels = self.run.tolist()
        order = {label: index for index, label in enumerate(dict.fromkeys(labels))}
        index = np.fromiter(map(order.__getitem__, labels), dtype=np.int64, count=len(labels))
        put(self, "run_index", index)
        for name in self.__slots__:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                put(self, name, self._sealed(name, value))
        put(self, "extra", {name: self._sealed(name, v) for name, v in self.extra.items()})

    def _sealed(self, name: str, values: NDArray[Any]) -> NDArray[Any]:
        if values.shape != (len(self.run),):
            raise ValueError(f"{name} has shape {values.shape}, the runs {self.run.shape}")
        view = values.view()
        view.flags.writeable = False
        return view

    def __reduce__(self) -> tuple[Callable[..., Readings], tuple[Any, ...]]:
        # Through the constructor, as arrays forget on the way that they are read-only.
        return type(self), tuple(getattr(self, f.name) for f in dataclasses.fields(self) if f.init)

    def __len__(self) -> int:
        return len(self.run)

    def __repr__(self) -> str:
        n = len(self)
        parts = [_count(n, "reading"), _count(len(np.unique(self.run_index)), "run")]
        if n and self.preload_N is not None:
            levels = _count(len(np.unique(self.preload_N)), "preload level")
            parts.append(f"{levels} {_span(self.preload_N)} N")
        if n:
            parts.append(f"torque {_span(self.torque_Nm)} N m")
        if n and self.u_elastic_angle_arcsec is not None:
            parts.append(f"u {_span(self.u_elastic_angle_arcsec)} arcsec")
        return f"Readings({', '.join(parts)}, {self.source!r})"

    def _repr_html_(self) -> str:
        """As a notebook shows it: a table of the first readings."""
        names = ("run", "torque_Nm", "preload_N", "input_angle_deg", "elastic_angle_arcsec")
        columns = {name: getattr(self, name) for name in names}
        return first_rows(repr(self), {n: c for n, c in columns.items() if c is not None})

    def direction(self) -> Ints:
        """Shape (n,): +1 where the torque rises, -1 where it falls, 0 where it holds.

        Compared with the reading before it in the same run; the first of a run takes the value
        of the next, and that of a run of one reading is 0.
        """
        grouped = np.argsort(self.run_index, kind="stable")
        runs, torque = self.run_index[grouped], self.torque_Nm[grouped]
        step = np.zeros(len(self), dtype=np.int64)
        step[1:] = np.sign(np.diff(torque))
        first = np.ones(len(self), dtype=bool)
        first[1:] = runs[1:] != runs[:-1]
        step[first] = 0
        leads = np.flatnonzero(first[:-1] & ~first[1:])
        step[leads] = step[leads + 1]
        result = np.empty_like(step)
        result[grouped] = step
        return result

    def alike(self, one: int, other: int) -> bool:
        """Whether two readings have the same torque and the same angle to the last digit."""
        columns = self.torque_Nm, self.elastic_angle_arcsec
        return all(bool(column[one] == column[other]) for column in columns)

    def select(self, mask: ArrayLike) -> Readings:
        """The readings where `mask` (bool of shape (n,), or row indices) says, in that order.

        `direction` of the selection compares the readings that are left.
        """
        rows = np.asarray(mask)
        if rows.dtype == bool and rows.shape != (len(self),):
            raise ValueError(f"the mask has shape {rows.shape}, expected ({len(self)},)")
        if rows.dtype != bool:
            rows = rows.astype(np.int64)  # an empty list arrives as floats

        def part(value: Any) -> Any:
            return value[rows] if isinstance(value, np.ndarray) else value

        kept = {f.name: part(getattr(self, f.name)) for f in dataclasses.fields(self) if f.init}
        kept["extra"] = {name: part(values) for name, values in self.extra.items()}
        kept["labels"] = {name: part(values) for name, values in self.labels.items()}
        return Readings(**kept)


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'s' * (n != 1)}"


def _span(values: Floats) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:g}" if low == high else f"{low:g}..{high:g}"
