"""The reader of measurement tables: mistakes told in full.

Groups: mistakes (tables), files that are none, data in memory.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbpt.errors import CbptError, ReadingsError
from cbpt.lab.readings.reader import read_readings
from common.tables import GOOD, HEAD, PLAIN, TABLE, Write, refused, same

# --- mistakes -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("row", "remedy"),
    [
        ("1,2,3,600\n", "complete the row or remove it"),
        ("1,2,3,600,9,0.3,7\n", "put each cell that contains the separator in double quotes"),
    ],
)
def test_a_row_of_too_few_or_too_many_cells_is_mended_differently(
    write: Write, row: str, remedy: str
) -> None:
    assert remedy in str(refused(write(HEAD + GOOD + row)))


def test_a_column_without_a_known_name_is_offered_in_the_unit_below_it(write: Write) -> None:
    """`Angle` over `deg` was offered as an angle in arcsec, and read as one."""
    told = refused(write("torque;preload;Angle\nN cm;N;deg\n100;600;0.01\n200;600;0.02\n"))
    assert "columns={'Angle': 'elastic_angle_deg'}" in str(told)
    # Similar headers, too, are told in the words of the front end.
    assert "to use it, name its quantity by HERE" in told.told(lambda step: "HERE")


def test_a_unit_that_is_not_known_is_to_be_converted(write: Write) -> None:
    told = str(refused(write("torque [kgf cm],preload_N,elastic_angle_arcsec\n1,600,3\n")))
    assert "convert the column to one of these, then state its unit" in told


@pytest.mark.parametrize(
    ("text", "line", "column", "value", "expected"),
    [
        (HEAD + GOOD + "1,2,abc,600,9,0.3\n", 4, "torque_Nm", "'abc'", "a number"),
        (HEAD + GOOD + "1,2,,600,9,0.3\n", 4, "torque_Nm", "an empty cell", "a number"),
        (HEAD + GOOD + "1,2,1_0,600,9,0.3\n", 4, "torque_Nm", "'1_0'", "a number"),
        (HEAD + GOOD + "1,2,3 Nm,600,9,0.3\n", 4, "torque_Nm", "'3 Nm'", "a number"),
        (HEAD + GOOD + "1,2,3,NaN,9,0.3\n", 4, "preload_N", "'NaN'", "a finite number"),
        (HEAD + GOOD + "1,2,3,600,-inf,0.3\n", 4, "elastic_angle_arcsec", "'-inf'", "finite"),
        (HEAD + GOOD + "1,2,3,1e999,9,0.3\n", 4, "preload_N", "'1e999'", "a finite number"),
        (HEAD + GOOD + "1,2,3,0,9,0.3\n", 4, "preload_N", "'0'", "a number above 0"),
        (HEAD + GOOD + "1,2,3,600,9,-0.3\n", 4, "u_elastic_angle_arcsec", "'-0.3'", "above 0"),
        (HEAD + GOOD + " ,2,3,600,9,0.3\n", 4, "run", "an empty cell", "a label for the run"),
        (HEAD + GOOD + "\n#\n1,1,3,600,9,0.3\n", 3, "time_s", "1 s twice in run 1", "different"),
        (HEAD + GOOD + "1,2,3,600\n", 4, "", "4 cells", "6, one for each header"),
        (HEAD + GOOD + "1,2,3,600,9,0.3,7\n", 4, "", "7 cells", "6, one for each header"),
        (HEAD + GOOD + '1,2,"3,600,9,0.3\n', 4, "", "unexpected end of data", "a closing quote"),
        (HEAD, 1, "", "no rows under the headers", "a row for each reading"),
        ("1,2,3\n4,5,6\n", 1, "1", "'1'", "a line of headers"),
        ("a,b,a\n1,2,3\n", 1, "a", "same header in columns 1 and 3", "one column of each name"),
        ("preload_N,alpha_arcsec\n1,2\n", 1, "torque_Nm", "'preload_N'", "a column torque_Nm"),
        ("torque_Nm,preload_N\n1,2\n", 1, "elastic_angle_arcsec", "'torque_Nm'", "a column"),
        ("torque_Nm,alpha_arcsec\n1,2\n", 1, "preload_N", "'torque_Nm'", "a column preload_N"),
        (
            "torque_Nm,M [kNm],preload_N,alpha_arcsec\n1,2,3,4\n",
            1,
            "M [kNm]",
            "'torque_Nm' and 'M [kNm]'",
            "only one column for torque",
        ),
        (
            "torque_Nm,preload_N,alpha\n1,2,3\n",
            1,
            "alpha",
            "'alpha'",
            "a unit for elastic_angle (rad, mrad, urad, deg, arcmin, arcsec)",
        ),
        (
            "torque,preload_N,alpha_deg\nozf,N,deg\n1,2,3\n",
            1,
            "torque",
            "with the unit 'ozf'",
            "N cm",
        ),
        ("torque_Nm;preload_N;alpha_deg\n1,5;6;7\n1.5;6;7\n", 3, "torque_Nm", "'1.5'", "comma"),
        ("torque_Nm;preload_N;alpha_deg\n1.234,5;6;7\n", 2, "torque_Nm", "'1.234,5'", "a number"),
        (
            "time_s,torque_Nm,preload_N,alpha_deg\n5,1,2,3\n4,1,2,3\n",
            3,
            "time_s",
            "4 s",
            "increases",
        ),
        ("torque_Nm,preload_N,dh_um\n1,2,3\n", 1, "dh_um", "no lever arm", "lever_arm_mm"),
    ],
)
def test_mistakes(
    write: Write, text: str, line: int, column: str, value: str, expected: str
) -> None:
    path = write(text)
    error = refused(path)
    assert (error.path, error.line, error.column) == (str(path), line, column)
    assert value in error.value and expected in error.expected
    for part in (str(path), f"line {line}", value, expected):
        assert part in str(error)
    assert isinstance(error, CbptError) and isinstance(error, ValueError)
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error) and copy.mistakes == error.mistakes


def test_every_mistake_is_told(write: Write) -> None:
    error = refused(write(HEAD + "1,0,x,600,3,0.3\n1,1,2,-6,,0.3\n1,2\n2,0,y,600,3,0\n"))
    found = {(m.lines, m.column) for m in error.mistakes}
    assert found == {
        ((2, 5), "torque_Nm"),
        ((3,), "preload_N"),
        ((3,), "elastic_angle_arcsec"),
        ((5,), "u_elastic_angle_arcsec"),
        ((4,), ""),
    }
    assert "the same on line" in str(error) and "5" in str(error)


def test_a_time_twice_comes_with_its_remedy(write: Write) -> None:
    whole = "".join(f"1,{i // 2},{i},600,3,0.3\n" for i in range(4))
    assert "finer steps, or leave the column out" in str(refused(write(HEAD + whole)))
    anew = "".join(f"{i % 3},{i},600,3\n" for i in range(6))
    told = str(refused(write("time_s,torque_Nm,preload_N,elastic_angle_arcsec\n" + anew)))
    assert "add a run column if the clock starts anew" in told


def test_many_mistakes_are_counted(write: Write) -> None:
    rows = "".join(f"1,{i // 2},1,600,3,0.3\n" for i in range(30))
    error = refused(write(HEAD + rows))
    assert len(error.mistakes) == 15
    assert str(error).count("twice in run 1") == 10 and "and 5 more" in str(error)
    lines = "".join(f"1,{i},x,600,3,0.3\n" for i in range(30))
    assert "and 21 more" in str(refused(write(HEAD + lines)))


@pytest.mark.parametrize(
    ("header", "remedy"),
    [
        ("torqe_Nm,preload_N,alpha_deg", "columns={'torqe_Nm': 'torque_Nm'}"),
        ("torque_Nm,preload_N,angle_deg", "columns={'angle_deg': 'elastic_angle_deg'}"),
        ("T [ozf in],preload_N,alpha_deg", "'ozf in' is not a unit of"),
        ("torque_Nm,preload_mark,alpha_deg", "'mark' is not a unit of it"),
        ("torque_Nm preload_N alpha_deg", "by commas, semicolons or tabs"),
        ("torque,preload_N,alpha_deg", "columns={'torque': 'torque_Nm'}"),
        ("#torque_Nm,preload_N,alpha_deg", "remove the # if"),
    ],
)
def test_remedies(write: Write, header: str, remedy: str) -> None:
    columns = header.count(",") + 1
    assert remedy in str(refused(write(header + "\n" + ",".join("123"[:columns]) + "\n")))


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ({"Momnt": "torque_Nm"}, "one of the headers 'Moment'"),
        ({"Moment": "torqe_Nm"}, "not 'torqe_Nm'"),
        ({"Moment": "torque"}, "for example pass columns={'Moment': 'torque_Nm'}"),
        ({"Moment": "torque_ozf"}, "not 'torque_ozf'"),
    ],
)
def test_columns_that_cannot_be(write: Write, columns: dict[str, str], expected: str) -> None:
    path = write("Moment,preload_N,alpha_deg\n1,2,3\n")
    assert expected in str(refused(path, columns=columns))
    assert read_readings(path, columns={"Moment": "torque_Nm"}).torque_Nm.tolist() == [1]


# --- files that are none ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"", "an empty file"),
        (b"\n \n\t\n", "an empty file"),
        (b"# only\n# comments\n", "2 comment lines and nothing else"),
        (b"PK\x03\x04\x14\x00\x06\x00", "a workbook (or another zip archive) that cannot be read"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an old Excel workbook"),
        (b"\x89HDF\r\n\x1a\n", "an HDF5"),
        (b"TDSm\x0e\0\0\0", "no group with a table"),
        (b"PAR1\x15\x04", "a Parquet file"),
        (b"\x1f\x8b\x08\0", "a gzip archive"),
        (bytes(range(256)), "a binary file"),
        (b"run,torque_Nm\n1,2\0\n", "a binary file"),
    ],
)
def test_files_that_are_no_table(write: Write, content: bytes, found: str) -> None:
    error = refused(write(content, "t.xlsx"))
    assert found in error.value and error.line is None and "t.xlsx" in str(error)
    if content.startswith(b"PK"):
        assert "save it again, or export the table to CSV" in str(error)


def test_paths_that_are_no_file(tmp_path: Path) -> None:
    assert "no such file" in str(refused(tmp_path / "none.csv"))
    assert "none.csv" in str(refused(str(tmp_path / "none.csv")))
    assert "a directory" in str(refused(tmp_path))
    assert "t\\x00" in repr(str(refused("t\0.csv")))


# --- data in memory -----------------------------------------------------------------------


class Frame:
    """The part of pandas and polars that is used."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.data = data
        self.columns: Sequence[Any] = list(data)

    def __getitem__(self, name: str) -> Any:
        return np.asarray(self.data[name])


class Arrow(Frame):
    """The same of pyarrow, whose `columns` are no names."""

    def __init__(self, data: dict[str, Any]) -> None:
        super().__init__(data)
        self.columns = [object() for _ in data]
        self.column_names = list(data)


@pytest.mark.parametrize("source", [TABLE, Frame(TABLE), Arrow(TABLE)], ids=["dict", "df", "pa"])
def test_data_in_memory(write: Write, source: Any) -> None:
    read = read_readings(source)
    same(read, read_readings(write(PLAIN)))
    assert read.source == "<data>" and read.line.tolist() == [1, 2, 3]
    assert read.sha256 == read_readings(dict(TABLE)).sha256
    assert read.sha256 != read_readings(TABLE | {"torque_Nm": [0.5, 1.25, -2.1]}).sha256


def test_data_is_copied() -> None:
    torque = np.array([1.0, 2.0, 3.0])
    read = read_readings(TABLE | {"torque_Nm": torque})
    torque[:] = 0
    assert read.torque_Nm.tolist() == [1, 2, 3] and torque.flags.writeable


class NAType:
    """Stands for pandas.NA: neither true nor false, and no float."""

    def __bool__(self) -> bool:
        raise TypeError("boolean value of NA is ambiguous")


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ([1.0, math.nan, 2.0], "'nan'"),
        ([1.0, None, 2.0], "an empty cell"),
        (np.array([1.0, NAType(), 2.0], dtype=object), "an empty cell"),
        (np.ma.masked_array([1.0, 5.0, 2.0], [False, True, False]), "an empty cell"),
        (["1", "x", "2"], "'x'"),
    ],
)
def test_gaps_in_data(values: Any, found: str) -> None:
    error = refused(TABLE | {"torque_Nm": values})
    assert (error.path, error.line, error.column) == ("<data>", 2, "torque_Nm")
    assert "row 2" in str(error) and error.value == found


@pytest.mark.parametrize("kind", ["timedelta64", "datetime64"])
@pytest.mark.parametrize("unit", ["ns", "ms", "m"])
def test_clocks_are_seconds(kind: str, unit: str) -> None:
    """A count of nanoseconds must not pass for seconds, nor seconds for what the header says."""
    clock = np.arange(7, 10).astype(f"{kind}[{unit}]")
    since = 7 if kind == "timedelta64" else 0
    seconds = np.arange(since, since + 3) * {"ns": 1e-9, "ms": 1e-3, "m": 60.0}[unit]
    for header in ("time_s", "time_min", "time"):
        read = read_readings(TABLE | {header: clock})
        assert read.time_s is not None
        np.testing.assert_allclose(read.time_s, seconds, rtol=1e-15)
    error = refused(TABLE | {"torque_Nm": clock})
    assert error.column == "torque_Nm" and "not a date" in error.expected
    read = read_readings(TABLE | {"written": clock})
    assert not read.extra and any("ignored column 'written'" in note for note in read.notes)


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ({}, "no columns"),
        (TABLE | {"torque_Nm": [1, 2]}, "2 values"),
        (TABLE | {"torque_Nm": 1.0}, "not a single column"),
        (TABLE | {"torque_Nm": [[1, 2], [3, 4], [5, 6]]}, "not a single column"),
        (TABLE | {"torque_Nm": [[1, 2], [3], [5]]}, "not a single column"),
        (Frame({"a": [1]}), "only the headers 'a'"),
        ({name: [] for name in TABLE}, "no rows"),
    ],
)
def test_data_that_is_no_table(source: Any, found: str) -> None:
    assert found in str(refused(source))


@pytest.mark.parametrize("source", [42, None, [1, 2], np.ones(3)])
def test_what_is_no_source(source: Any) -> None:
    with pytest.raises(TypeError, match="a path, a mapping"):
        read_readings(source)


def test_labels_of_runs() -> None:
    assert read_readings(TABLE | {"run": [1.0, 1.0, 2.0]}).run.tolist() == [1, 1, 2]
    assert read_readings(TABLE | {"run": ["a", "a", 2]}).run.tolist() == ["a", "a", "2"]
    # Dotted numbers are labels: the tenth run of a series is not its first.
    read = read_readings(TABLE | {"run": ["1.10", "1.1", "1.10"]})
    assert read.run.tolist() == ["1.10", "1.1", "1.10"] and read.run_index.tolist() == [0, 1, 0]


def test_dotted_labels_in_a_file(write: Write) -> None:
    text = PLAIN.replace("\n1,0", "\n1.1,0").replace("\n1,1", "\n1.10,1")
    assert read_readings(write(text)).run.tolist() == ["1.1", "1.10", "2"]


def test_an_empty_cell_of_the_levels_is_told_with_column_row_and_remedy() -> None:
    table = {
        "torque_Nm": [1.0, 2.0, 3.0],
        "elastic_angle_arcsec": [1.0, 2.0, 3.0],
        "state": ["a", "", "b"],
    }
    assert len(read_readings(table, need_preload=False)) == 3
    with pytest.raises(ReadingsError, match=r"row 2, column 'state'.*empty cell.*remove"):
        read_readings(table, need_preload=False, by="state")


def test_a_unit_that_is_stated_against_the_header_is_told(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text("torque_Nm,angle [arcmin]\n1,2\n", encoding="utf-8")

    def notes(stated: str) -> str:
        read = read_readings(path, need_preload=False, columns={"angle [arcmin]": stated})
        return " ".join(map(str, read.notes))

    assert "as elastic_angle in deg, though its header says arcmin" in notes("elastic_angle_deg")
    assert "though" not in notes("elastic_angle")
