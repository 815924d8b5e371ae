"""What a sweep found, labelled: numpy, pandas, xarray, and from there NetCDF as CF has it."""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import SweepPlan, sweep_findings, sweep_statuses
from cbpt.errors import MissingLibraryError
from cbpt.results import ARCSEC_PER_RAD, first_rows
from cbpt.sketch import against

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ["Rows", "Sweep", "found_columns"]

_PARTS = {
    "alpha_deceleration_arcsec": "part of the deceleration pair",
    "alpha_equal_speed_arcsec": "part of the equal-speed pair that reaches the output",
    "residual": "largest scaled residual of the equations",
    "hold_preload_N": "preload at which the torque would just slip",
}
_FOUND = {"elastic_angle_arcsec": "elastic angle at the output", **_PARTS}
_FURTHER = {
    "friction_torque_Nm": "friction torque at the input",
    "efficiency": "power at the output over power at the input",
    "wear_Nm_per_turn": "Archard's index for a turn of the input",
    "static_safety": "static safety of the worst contact",
    "natural_frequency_Hz": "torsional natural frequency, the input held",
}
_MEANINGS = _FOUND | _FURTHER
_UNITS = {
    **dict.fromkeys(("residual", "efficiency", "static_safety"), "1"),
    "hold_preload_N": "N",
    "friction_torque_Nm": "N m",
    "wear_Nm_per_turn": "N m",
    "natural_frequency_Hz": "Hz",
}


def _library(name: str, asked: str, install: str) -> Any:
    """A library that is not needed otherwise."""
    try:
        return import_module(name)
    except ImportError:
        remedy = f'pip install "{install}"'
        raise MissingLibraryError(f"{asked} needs {name}: {remedy}", name=name) from None


def found_columns(plan: SweepPlan) -> list[str]:
    """What is found of each row, after its axes and before the words, as in files."""
    return [*(_FOUND if plan.has_pairs else ["elastic_angle_arcsec"]), *plan.columns]


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a sweep, column by column; NaN where a row has no solution."""

    axes: list[NDArray[np.float64]]
    """Of each axis in its unit; of words the place among those of the plan."""
    found: dict[str, NDArray[np.float64]]
    """By the names of `found_columns`."""
    finding: NDArray[np.uint8]
    """Place in `sweep_findings()`: why the drive cannot be built; empty of one drive alone."""
    status: NDArray[np.uint8]
    """Place of the status in `sweep_statuses()`."""

    @classmethod
    def of(cls, plan: SweepPlan, solved: tuple[Any, ...]) -> Rows:
        """Of what `SweepPlan.solve` returns."""
        axes, angle, deceleration, equal_speed, residual, hold, finding, status, further = solved
        angles = [part * ARCSEC_PER_RAD for part in (angle, deceleration, equal_speed)]
        names = found_columns(plan)
        of_pairs = [*angles, residual, hold] if plan.has_pairs else angles[:1]
        columns = dict(zip(names, [*of_pairs, *further], strict=True))
        return cls(axes, columns, finding, status)

    @classmethod
    def joined(cls, parts: Iterable[Rows]) -> Rows:
        """Parts of a sweep, one after the other."""
        first, *others = parts
        every = [first, *others]
        return cls(
            [
                np.concatenate([rows.axes[axis] for rows in every])
                for axis in range(len(first.axes))
            ],
            {name: np.concatenate([rows.found[name] for rows in every]) for name in first.found},
            np.concatenate([rows.finding for rows in every]),
            np.concatenate([rows.status for rows in every]),
        )

    @classmethod
    def read(cls, plan: SweepPlan, path: Path) -> Rows:
        """The rows that a file holds."""
        read = _parquet if path.suffix.lower() == ".parquet" else _csv
        return cls.joined(cls._of_texts(plan, columns) for columns in read(path))

    @classmethod
    def _of_texts(cls, plan: SweepPlan, columns: dict[str, Sequence[Any]]) -> Rows:
        """Some rows as files have them: words, numbers or their texts, nothing for NaN."""

        def numbers(name: str) -> NDArray[np.float64]:
            return np.array([np.nan if x in ("", None) else x for x in columns[name]], np.float64)

        axes = []
        for name, words in zip(plan.names, plan.words, strict=True):
            place = {word: float(index) for index, word in enumerate(words)}
            axes.append(np.array([place[x] for x in columns[name]]) if words else numbers(name))

        def codes(name: str, known: list[str]) -> NDArray[np.uint8]:
            code = {word: code for code, word in enumerate(known)}
            return np.array([code[word or ""] for word in columns[name]], np.uint8)

        finding = codes("finding", sweep_findings()) if plan.has_findings else np.empty(0, np.uint8)
        found = {name: numbers(name) for name in found_columns(plan)}
        return cls(axes, found, finding, codes("status", sweep_statuses()))


_AT_A_TIME = 65536
"""Rows that are read at a time: texts take far more memory than numbers."""


def _csv(path: Path) -> Iterator[dict[str, Sequence[Any]]]:
    with path.open(encoding="utf-8", newline="") as file:
        lines = csv.reader(file)
        header = next(lines)
        while rows := list(itertools.islice(lines, _AT_A_TIME)):
            yield dict(zip(header, zip(*rows, strict=True), strict=True))


def _parquet(path: Path) -> Iterator[dict[str, Sequence[Any]]]:
    from pyarrow import parquet

    with parquet.ParquetFile(path) as file:
        for batch in file.iter_batches(_AT_A_TIME):
            yield batch.to_pydict()


@dataclass(frozen=True, eq=False)
class Sweep:
    """A sweep with its rows in the order of the plan: of a grid the load changes fastest.

    Where a row has no solution its numbers are NaN and `status` says why; nothing is left out.
    Where the rows went to a file (`path`) they are read from it when they are first asked for.
    """

    plan: SweepPlan
    path: Path | None
    scalars: frozenset[str]
    """Axes that were given as one number, which are no dimension of a grid."""
    load: Callable[[], Rows]

    @cached_property
    def rows(self) -> Rows:
        """All columns."""
        return self.load()

    @property
    def elastic_angle_arcsec(self) -> NDArray[np.float64]:
        """Elastic angle of each row, with the effects of the case if it has any."""
        return self.rows.found["elastic_angle_arcsec"]

    @property
    def status(self) -> NDArray[np.str_]:
        """How each row ended."""
        return np.array(sweep_statuses(), dtype=np.str_)[self.rows.status]

    @property
    def finding(self) -> NDArray[np.str_]:
        """Why the drive of each row cannot be built, as `cbpt check` calls it; empty where it can.

        Where the drive does not vary a warning is given instead and all are empty.
        """
        if not self.plan.has_findings:
            return np.full(len(self), "", dtype=np.str_)
        return np.array(sweep_findings(), dtype=np.str_)[self.rows.finding]

    @property
    def has_solution(self) -> NDArray[np.bool_]:
        """Where the numbers are there."""
        return np.isfinite(self.elastic_angle_arcsec)

    def axis(self, name: str) -> NDArray[Any]:
        """One axis at each row: numbers in its unit, or words."""
        place = self.plan.names.index(name)
        words = self.plan.words[place]
        column = self.rows.axes[place]
        return np.array(words)[column.astype(np.intp)] if words else column

    def __len__(self) -> int:
        return self.plan.rows

    def __repr__(self) -> str:
        where = f", in {self.path}" if self.path is not None else ""
        return (
            f"Sweep({self.plan.design}, {len(self)} rows over {', '.join(self.plan.names)}{where})"
        )

    def _repr_html_(self) -> str:
        """As a notebook shows it: a table of the first rows, and the angle over the axes."""
        axes: dict[str, Any] = {name: self.axis(name) for name in self.plan.names}
        angle = self.elastic_angle_arcsec
        found = axes | {"elastic_angle_arcsec": angle, "status": self.status}
        return first_rows(repr(self), found) + against(axes, "elastic_angle_arcsec", angle)

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with a row for each row of the plan; columns as in a CSV file. Raises
        `MissingLibraryError` without pandas.
        """
        pandas = _library("pandas", "to_pandas", "cbpt[pandas]")

        columns: dict[str, Any] = {name: self.axis(name) for name in self.plan.names}
        columns |= self.rows.found
        if self.plan.has_findings:
            codes = self.rows.finding.astype(np.int8) - 1  # -1 is nothing
            columns["finding"] = pandas.Categorical.from_codes(codes, sweep_findings()[1:])
        columns["status"] = pandas.Categorical.from_codes(self.rows.status, sweep_statuses())
        return pandas.DataFrame(columns)

    def to_xarray(self) -> xarray.Dataset:
        """A data set by the CF conventions: of a grid its axes are the dimensions, else `row` is.

        Names are those of the keys with `_` for `.`; the key itself is the attribute `key`.
        `.to_netcdf("sweep.nc", engine="h5netcdf")` of it writes NetCDF. Raises
        `MissingLibraryError` without xarray.
        """
        library = _library("xarray", "to_xarray", "cbpt[xarray]")

        names = _netcdf_names(self.plan.names)
        grid = self.plan.design == "grid"
        every = [not grid or name not in self.scalars for name in self.plan.names]
        coordinates: dict[str, Any] = {}
        for place, (name, key) in enumerate(zip(names, self.plan.names, strict=True)):
            attributes = {"long_name": self.plan.meanings[place], "key": key}
            if not self.plan.words[place]:
                attributes["units"] = cf_unit(self.plan.units[place])
            values: Any = self.plan.values()[place] if grid else self.axis(key)
            if self.plan.words[place]:
                values = np.array(values, dtype=object)
            dimension: tuple[str, ...] = ((name,) if grid else ("row",)) if every[place] else ()
            coordinates[name] = (dimension, values if dimension else values[0], attributes)
        dimensions = [name for name, kept in zip(names, every, strict=True) if kept]

        def variable(column: NDArray[Any], attributes: dict[str, Any]) -> Any:
            if not grid:
                return ("row", column, attributes)
            return (dimensions, self._shaped(column, every), attributes)

        data = {
            name: variable(
                column,
                {
                    "long_name": _MEANINGS[name],
                    "units": _UNITS.get(name, "arcsec"),
                    "ancillary_variables": "status",
                },
            )
            for name, column in self.rows.found.items()
        }

        def flags(codes: NDArray[np.uint8], words: list[str], long_name: str) -> Any:
            attributes = {
                "long_name": long_name,
                "standard_name": "status_flag",
                "flag_values": np.arange(len(words), dtype=np.int8),
                "flag_meanings": " ".join(words),
            }
            return variable(codes.astype(np.int8), attributes)

        if self.plan.has_findings:
            words = ["none", *sweep_findings()[1:]]
            data["finding"] = flags(self.rows.finding, words, "why the drive cannot be built")
        data["status"] = flags(self.rows.status, sweep_statuses(), "how the row ended")
        attributes = {
            "Conventions": "CF-1.11",
            "title": "Sweep of the elastic angle of a reducer",
            "source": f"CBPT {version('cbpt')}",
            "cbpt_sweep": self.plan.record,
        }
        made: xarray.Dataset = library.Dataset(data, coordinates, attributes)
        return made

    def _shaped(self, column: NDArray[Any], kept: list[bool]) -> NDArray[Any]:
        """A column of a grid with its axes in the order in which they were given."""
        sizes = [len(values) for values in self.plan.values()]
        slowest_first = sorted(range(len(sizes)), key=lambda axis: self._rank(axis), reverse=True)
        shaped = column.reshape([sizes[axis] for axis in slowest_first])
        shaped = shaped.transpose(np.argsort(slowest_first))
        return shaped.reshape([size for size, keep in zip(sizes, kept, strict=True) if keep])

    def _rank(self, axis: int) -> tuple[int, int]:
        """By how slowly an axis changes; one of a single value may stand anywhere."""
        return self.plan.strides[axis], len(self.plan.values()[axis])


_PLAIN = {"Nm": "N m", "Nmm": "N mm", "mNm": "mN m", "kNm": "kN m", "deg": "degree"}


def cf_unit(suffix: str) -> str:
    """The unit of a key as UDUNITS writes it: `N_per_mm` is `N mm-1`."""
    if not re.fullmatch(r"\w*", suffix):  # an own effect's unit is its author's
        return suffix
    over, *under = re.split(r"_?per_", suffix)
    units = [_PLAIN.get(over, over)] if over else []
    for each in under:
        unit, power = re.fullmatch(r"(\w+?)(\d*)", each).groups()  # type: ignore[union-attr]
        units += [f"{factor}-{power or 1}" for factor in _PLAIN.get(unit, unit).split()]
    return " ".join(units) or "1"


def _netcdf_names(keys: list[str]) -> list[str]:
    """Letters, digits and `_`, which every reader of NetCDF takes, each name once."""
    names: list[str] = []
    for key in keys:
        name = re.sub(r"[^0-9A-Za-z_]", "_", key)
        while name in names:
            name += "_"
        names.append(name)
    return names
