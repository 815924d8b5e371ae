"""The reader of measurement tables: formats that mean the same, and mistakes told in full.

Groups: formats and units (tables), mistakes (tables), files that are none, data in memory,
time and direction, the class itself, a round trip through random dialects, and the campaigns.
"""

from __future__ import annotations

import hashlib
import math
import pickle
import string
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbpt.errors import CbptError, ReadingsError
from cbpt.lab import table
from cbpt.lab.readings import Readings, read_readings
from cbpt.lab.units import find_unit, read_header

DATA = Path(__file__).parent / "data"
CAMPAIGNS = sorted((DATA / "hidden_effect").glob("dev*.csv"))

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write text (or bytes) to a file in a directory of its own."""

    def put(content: str | bytes, name: str = "t.csv", encoding: str = "utf-8") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return put


def refused(source: Any, **options: Any) -> ReadingsError:
    with pytest.raises(ReadingsError) as caught:
        read_readings(source, **options)
    return caught.value


def same(a: Readings, b: Readings, rtol: float = 1e-14) -> None:
    for name in ("torque_Nm", "preload_N", "input_angle_deg", "elastic_angle_arcsec", "run"):
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_allclose(x, y, rtol=rtol, atol=0, err_msg=name)
    for name in ("u_elastic_angle_arcsec", "time_s", "temperature_degC", "cycle"):
        x, y = getattr(a, name), getattr(b, name)
        assert (x is None) == (y is None), name
        if x is not None:
            np.testing.assert_allclose(x, y, rtol=rtol, atol=0, err_msg=name)


# --- formats that mean the same -----------------------------------------------------------

PLAIN = """\
run,torque_Nm,preload_N,elastic_angle_arcsec
1,0.5,600,3
1,1.25,600,7.5
2,-2,450.5,-12
"""

FORMATS = {
    "brackets": "run,torque [N m],preload [N],elastic angle [arcsec]\n",
    "parentheses": "Run,T (N·m),Preload (N),Elastic angle (″)\n",
    "slashes": "run,M0 / Nm,N_Z / N,alpha / arcsec\n",
    "slashes and brackets": "run,Torque M0 / (N m),preload/N,α / arcsec\n",
    "commas": 'run,"torque, Nm","preload, N","elastic angle, arcsec"\n',
    "blanks": "Run No,Torque N m,Pre-load N,Elastic-Angle arcsec\n",
    "capitals": "RUN,TORQUE_NM,PRELOAD_N,ELASTIC_ANGLE_ARCSEC\n",
    "in": "run,torque in Nm,preload in N,elastic angle in arcsec\n",
    "two brackets": "run,Torque (T) [Nm],APF [N],Torsion angle [arc-sec]\n",
    "row of units": "run,torque,preload,elastic angle\n,N·m,N,arcsec\n",
    "row of units in brackets": "run,T,N_Z,alpha\n[-],[N.m],[N],['']\n",
    "units twice": "run,torque_Nm,preload [N],alpha [arcsec]\n-,N m,N,″\n",
    "comments": "# rig 3\n\nrun,torque_Nm,preload_N,elastic_angle_arcsec\n#\n",
    "blank lines": "\n\n,,,\nrun,torque_Nm,preload_N,elastic_angle_arcsec\n,,,\n",
    "quotes": '"run","torque_Nm", "preload_N","elastic_angle_arcsec"\n',
    "line in a header": '"run","torque\n[Nm]",preload_N,elastic_angle_arcsec\n',
    "stated separator": "sep=,\nrun,torque_Nm,preload_N,elastic_angle_arcsec\n",
}


@pytest.mark.parametrize("header", FORMATS.values(), ids=FORMATS.keys())
def test_headers_that_mean_the_same(write: Write, header: str) -> None:
    body = PLAIN.split("\n", 1)[1]
    plain = read_readings(write(PLAIN, "plain.csv"))
    read = read_readings(write(header + body))
    same(read, plain)
    assert read.run.tolist() == [1, 1, 2]
    first = header.count("\n") + 1
    assert read.line.tolist() == [first, first + 1, first + 2]


BODIES = {
    "semicolons": PLAIN.replace(",", ";"),
    "decimal commas": PLAIN.replace(",", ";").replace(".", ","),
    "tabs": PLAIN.replace(",", "\t"),
    "tabs, decimal commas": PLAIN.replace(",", "\t").replace(".", ","),
    "blanks after commas": PLAIN.replace(",", ", "),
    "carriage returns": PLAIN.replace("\n", "\r\n"),
    "old carriage returns": PLAIN.replace("\n", "\r"),
    "no last line end": PLAIN.rstrip(),
    "separators at the end": PLAIN.replace("\n", ",\n"),
    "separators after rows": PLAIN.replace("\n", ",\n").replace("arcsec,", "arcsec"),
    "quoted cells": PLAIN.replace("600", '"600"').replace("7.5", ' "7.5"'),
    "typographic minus": PLAIN.replace("-", "\N{MINUS SIGN}"),
    "exponents": PLAIN.replace(",0.5,", ",+5.0E-1,").replace("600", "6e2"),
    "padding": PLAIN.replace("600", "  600  "),
    "trailing rows of separators": PLAIN + ",,,\n , ,,\n",
    "floating run": PLAIN.replace("\n1,", "\n1.0,").replace("\n2,", "\n02,"),
    "other units": (
        "run;T (N·mm);preload / kN;Elastic angle (arcmin)\n"
        "1;500;0,6;0,05\n1;1250;0,6;0,125\n2;-2000;0,4505;-0,2\n"
    ),
}


@pytest.mark.parametrize("text", BODIES.values(), ids=BODIES.keys())
def test_bodies_that_mean_the_same(write: Write, text: str) -> None:
    read = read_readings(write(text))
    same(read, read_readings(write(PLAIN, "plain.csv")))
    assert read.line.tolist() == [2, 3, 4]
    assert read.extra == {}


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1", "cp1252"]
)
def test_encodings(write: Write, encoding: str) -> None:
    text = "torque [N·m],preload_N,alpha [µrad],theta [°],temp [°C]\n1,600,100,-90,20\n"
    path = write(text, encoding=encoding)
    read = read_readings(path)
    assert read.elastic_angle_arcsec[0] == pytest.approx(20.6264806247, rel=1e-10)
    assert read.input_angle_deg[0] == -90
    assert read.temperature_degC is not None and read.temperature_degC[0] == 20
    assert read.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert read.source == str(path)
    assert any("Latin-1" in note for note in read.notes) == (encoding in {"latin-1", "cp1252"})


@pytest.mark.parametrize(
    ("unit", "kind", "in_own"),  # one of it, in N m, N, arcsec, s, degC, um
    [
        *[(unit, "torque", 1) for unit in ("Nm", "N m", "N·m", "N*m", "N.m", "N-m", "N⋅m", "NM")],
        *[(unit, "torque", 1e3) for unit in ("kNm", "kN m", "KNM")],
        *[(unit, "torque", 1e-3) for unit in ("mNm", "mN·m", "N mm", "Nmm")],
        *[(unit, "torque", 1e-2) for unit in ("Ncm", "N cm", "cN m")],
        *[(unit, "force", 1) for unit in ("N", "newton")],
        *[(unit, "force", 1e3) for unit in ("kN", "KN")],
        ("mN", "force", 1e-3),
        *[(unit, "angle", 1) for unit in ("arcsec", "arc sec", "ARCSEC", "″", "''", '"', "′′")],
        *[(unit, "angle", 60) for unit in ("arcmin", "arc-min", "′", "'", "’")],
        *[(unit, "angle", 3600) for unit in ("deg", "°", "Degrees")],
        *[(unit, "angle", 206264.80624709636) for unit in ("rad", "RAD")],
        ("mrad", "angle", 206.26480624709636),
        *[(unit, "angle", 0.20626480624709636) for unit in ("urad", "µrad", "μrad")],
        *[(unit, "time", 1) for unit in ("s", "sec", "S")],
        *[(unit, "time", 1e-3) for unit in ("ms",)],
        *[(unit, "time", 60) for unit in ("min",)],
        *[(unit, "time", 3600) for unit in ("h", "hours")],
        *[(unit, "temperature", 1) for unit in ("degC", "°C", "C", "deg C", "℃")],
        ("K", "temperature", 1 - 273.15),
        *[(unit, "length", 1) for unit in ("um", "µm", "μm", "micron")],
        *[(unit, "length", value) for unit, value in (("m", 1e6), ("mm", 1e3), ("nm", 1e-3))],
    ],
)
def test_units(unit: str, kind: str, in_own: float) -> None:
    own = {"torque": "Nm", "force": "N", "angle": "arcsec", "time": "s", "temperature": "degC"}
    found, to = find_unit(unit, kind), find_unit(own.get(kind, "um"), kind)
    assert found is not None and to is not None and found.kind == kind
    np.testing.assert_allclose(found.convert(np.ones(1), to), in_own, rtol=1e-14)


@pytest.mark.parametrize(
    ("unit", "kind"),
    [
        ("MNm", "torque"),
        ("MN", "force"),
        ("Mrad", "angle"),
        ("lbf in", "torque"),
        ("kgf", "force"),
        ("", "force"),
        ("grad", "angle"),
    ],
)
def test_units_that_are_not_guessed(unit: str, kind: str) -> None:
    assert find_unit(unit, kind) is None


def test_own_units_are_read_exactly(write: Write) -> None:
    """A value in the unit of the contract is the float that stands in the file."""
    values = [0.1, 1 / 3, 2.675, 1e-7, 123456.789]
    rows = "\n".join(f"{v!r},{v!r},{v!r},{v!r}" for v in values)
    read = read_readings(
        write(f"torque_Nm,preload_N,elastic_angle_arcsec,input_angle_deg\n{rows}\n")
    )
    for name in ("torque_Nm", "preload_N", "elastic_angle_arcsec", "input_angle_deg"):
        assert getattr(read, name).tolist() == values


@pytest.mark.parametrize(
    ("header", "key", "symbol"),
    [
        ("T (N·m)", "torque", "N m"),
        ("T [°C]", "temperature", "degC"),
        ("t [s]", "time", "s"),
        ("t_s", "time", "s"),
        ("T [K]", "temperature", "K"),
        ("M_0 [Nm]", "torque", "N m"),
        ("M0_Nm", "torque", "N m"),
        ("N_Z (N)", "preload", "N"),
        ("NZ_kN", "preload", "kN"),
        ("theta (deg)", "input_angle", "deg"),
        ("θ / rad", "input_angle", "rad"),
        ("u(alpha) [arcsec]", "u_elastic_angle", "arcsec"),
        ("u [arcsec]", "u_elastic_angle", "arcsec"),
        ("u [um]", "u_sensor_displacement", "um"),
        ("Δh [µm]", "sensor_displacement", "um"),
        ("sensor displacement, mm", "sensor_displacement", "mm"),
        ("Elapsed time (min)", "time", "min"),
        ("Temp. [°C]", "temperature", "degC"),
        ("torque_nm", "torque", "N m"),
    ],
)
def test_headers(header: str, key: str, symbol: str) -> None:
    said = read_header(header)
    assert said.quantity is not None and said.quantity.key == key
    assert said.unit is not None and said.unit.symbol == symbol
    assert not said.expected


@pytest.mark.parametrize(
    "header",
    ["U [V]", "M [kg]", "commanded_torque_Nm", "preload_step", "angle_deg", "T_amb", "F [N]", ""],
)
def test_headers_of_other_things(header: str) -> None:
    said = read_header(header)
    assert said.quantity is None and not said.expected


@pytest.mark.parametrize(
    ("header", "below", "expected"),
    [
        ("torque", "", "a unit for torque (N m, kN m, N cm, mN m)"),
        ("T", "", "a unit for time or torque or temperature"),
        ("torque [lbf in]", "", "one of N m, kN m, N cm, mN m as the unit of torque"),
        ("torque [N]", "", "as the unit of torque"),
        ("preload / t", "", "as the unit of preload"),
        ("torque_Nm", "kNm", "one unit, not 'Nm' in the header and 'kNm' under it"),
        ("U_elastic_angle_arcsec", "", "standard uncertainty"),
        ("U [arcsec]", "", "standard uncertainty"),
        ("run [Nm]", "", "no unit for run"),
    ],
)
def test_headers_that_are_asked_about(header: str, below: str, expected: str) -> None:
    assert expected in read_header(header, below).expected


def test_columns_state_what_headers_mean(write: Write) -> None:
    text = "Versuch,Moment,Kraft [kN],angle_deg,T\na,1,0.6,0.5,9\nb,2,0.6,1,9\n"
    stated = {
        "Versuch": "run",
        "Moment": "torque_Nm",
        "Kraft [kN]": "preload",
        "angle_deg": "elastic_angle_arcmin",
        "T": "extra",
    }
    read = read_readings(write(text), columns=stated)
    assert read.torque_Nm.tolist() == [1, 2]
    assert read.preload_N is not None and read.preload_N.tolist() == [600, 600]
    assert read.elastic_angle_arcsec.tolist() == [30, 60]
    assert read.run.tolist() == ["a", "b"]
    assert read.extra["T"].tolist() == [9, 9]


def test_absent_columns_are_told(write: Write) -> None:
    read = read_readings(write("torque_Nm,alpha_arcsec\n1,3\n2,6\n"), need_preload=False)
    assert read.preload_N is None and read.u_elastic_angle_arcsec is None
    assert read.time_s is None and read.cycle is None and read.temperature_degC is None
    assert read.run.tolist() == [1, 1] and read.input_angle_deg.tolist() == [0, 0]
    for name in (
        "run",
        "time_s",
        "preload_N",
        "input_angle_deg",
        "temperature_degC",
        "u_elastic_angle_arcsec",
    ):
        assert any(note.startswith(f"no {name} column") for note in read.notes), name


def test_other_columns(write: Write) -> None:
    text = (
        ",torque_Nm,preload_N,alpha_arcsec,humidity,operator,empty,T_oil\n"
        "0,1,600,3,40,Ann,,\n1,2,600,6,,Bob,,nan\n2,3,600,9,42,,,31\n"
    )
    read = read_readings(write(text))
    assert read.extra.keys() == {"column 1", "humidity", "T_oil"}
    np.testing.assert_array_equal(read.extra["humidity"], [40, math.nan, 42])
    np.testing.assert_array_equal(read.extra["T_oil"], [math.nan, math.nan, 31])
    assert "ignored column 'operator': line 2 has 'Ann'" in read.notes


@pytest.mark.parametrize(
    ("rows", "note"),
    [
        ("0,600,3\n0,700,4\n", "the torque is 0 in every row"),
        ("5,600,3\n5,700,4\n", "the torque is 5 N m in every row"),
        ("1,600,3\n2,700,7200\n", "the largest elastic angle is 2 deg: check its unit"),
        ("1,600,3\n2,600,4\n", "one preload level"),
        (
            "1,600,3\n# pause\n2,700,4\n",
            "comment lines (#) after the headers were skipped (line 3)",
        ),
    ],
)
def test_remarks(write: Write, rows: str, note: str) -> None:
    read = read_readings(write("torque_Nm,preload_N,alpha_arcsec\n" + rows))
    assert any(note in each for each in read.notes)
    quiet = read_readings(write("torque_Nm,preload_N,alpha_arcsec\n1,600,3\n2,700,6\n"))
    assert not any(note in each for each in quiet.notes)


# --- mistakes -----------------------------------------------------------------------------

HEAD = "run,time_s,torque_Nm,preload_N,elastic_angle_arcsec,u_elastic_angle_arcsec\n"
GOOD = "1,0,1,600,3,0.3\n1,1,2,600,6,0.3\n"


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
        (HEAD + GOOD + " ,2,3,600,9,0.3\n", 4, "run", "an empty cell", "the label of a run"),
        (HEAD + GOOD + "\n#\n1,1,3,600,9,0.3\n", 3, "time_s", "1 s twice in run 1", "different"),
        (HEAD + GOOD + "1,2,3,600\n", 4, "", "4 cells", "6, one for each header"),
        (HEAD + GOOD + "1,2,3,600,9,0.3,7\n", 4, "", "7 cells", "6, one for each header"),
        (HEAD + GOOD + '1,2,"3,600,9,0.3\n', 4, "", "unexpected end of data", "closed quotes"),
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
            "one column of torque",
        ),
        (
            "torque_Nm,preload_N,alpha\n1,2,3\n",
            1,
            "alpha",
            "'alpha'",
            "a unit for elastic_angle (arcsec, arcmin, deg, rad, mrad, urad)",
        ),
        ("torque,preload_N,alpha_deg\nlbf,N,deg\n1,2,3\n", 1, "torque", "over 'lbf'", "N cm"),
        ("torque_Nm;preload_N;alpha_deg\n1,5;6;7\n1.5;6;7\n", 3, "torque_Nm", "'1.5'", "comma"),
        ("torque_Nm;preload_N;alpha_deg\n1.234,5;6;7\n", 2, "torque_Nm", "'1.234,5'", "a number"),
        ("time_s,torque_Nm,preload_N,alpha_deg\n5,1,2,3\n4,1,2,3\n", 3, "time_s", "4 s", "rises"),
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
        ("T [lbf in],preload_N,alpha_deg", "'lbf in' is no unit of"),
        ("torque_Nm,preload_step,alpha_deg", "'step' is no unit of it"),
        ("torque_Nm preload_N alpha_deg", "separated by commas, semicolons or tabs"),
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
        ({"Moment": "torque"}, "as in columns={'Moment': 'torque_Nm'}"),
        ({"Moment": "torque_lbf"}, "not 'torque_lbf'"),
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
        (b"PK\x03\x04\x14\x00\x06\x00", "an Excel workbook"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "an old Excel workbook"),
        (b"\x89HDF\r\n\x1a\n", "an HDF5"),
        (b"TDSm\x0e\0\0\0", "a TDMS file"),
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
        assert "export the sheet to CSV" in str(error) and "later version" in str(error)


def test_paths_that_are_no_file(tmp_path: Path) -> None:
    assert "no such file" in str(refused(tmp_path / "none.csv"))
    assert "none.csv" in str(refused(str(tmp_path / "none.csv")))
    assert "a directory" in str(refused(tmp_path))
    assert "t\\x00" in repr(str(refused("t\0.csv")))


# --- data in memory -----------------------------------------------------------------------

TABLE: dict[str, Any] = {
    "run": [1, 1, 2],
    "torque_Nm": [0.5, 1.25, -2],
    "preload / kN": np.array([0.6, 0.6, 0.4505]),
    "elastic_angle_arcsec": (3, 7.5, -12),
}


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


@pytest.mark.parametrize("kind", ["timedelta64[ns]", "datetime64[ns]"])
def test_clocks_are_no_numbers(kind: str) -> None:
    """A count of nanoseconds must not pass for seconds."""
    error = refused(TABLE | {"time_s": np.arange(3).astype(kind)})
    assert error.column == "time_s" and error.expected == "a number"


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ({}, "no columns"),
        (TABLE | {"torque_Nm": [1, 2]}, "2 values"),
        (TABLE | {"torque_Nm": 1.0}, "no single column of values"),
        (TABLE | {"torque_Nm": [[1, 2], [3, 4], [5, 6]]}, "no single column of values"),
        (TABLE | {"torque_Nm": [[1, 2], [3], [5]]}, "no single column of values"),
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


# --- the sensor ---------------------------------------------------------------------------


def test_sensor_displacement(write: Write) -> None:
    """alpha = atan(dh / h), and its uncertainty is that of dh times the slope of it."""
    h_um = 1e5
    path = write("M0_Nm,N_Z_N,dh_mm,u_dh_um\n1,600,0.0485,0.5\n2,600,50,0.5\n")
    read = read_readings(path, lever_arm_mm=100)
    alpha = np.array([math.atan(48.5 / h_um), math.atan(0.5)])
    u = 0.5 / h_um * np.cos(alpha) ** 2
    arcsec = 180 * 3600 / math.pi
    np.testing.assert_allclose(read.elastic_angle_arcsec, alpha * arcsec, rtol=1e-14)
    assert read.u_elastic_angle_arcsec is not None
    np.testing.assert_allclose(read.u_elastic_angle_arcsec, u * arcsec, rtol=1e-13)
    assert "lever_arm_mm" in str(refused(path))
    for arm in (0, -1, math.nan, math.inf):
        assert "a length above 0" in str(refused(path, lever_arm_mm=arm))


def test_the_angle_goes_before_the_sensor(write: Write) -> None:
    path = write("torque_Nm,preload_N,alpha_arcsec,sensor_displacement_um\n1,600,3,1.5\n")
    read = read_readings(path)
    assert read.elastic_angle_arcsec.tolist() == [3]
    assert read.extra["sensor_displacement_um"].tolist() == [1.5]
    assert any("'sensor_displacement_um' is kept as extra" in note for note in read.notes)


# --- time and direction -------------------------------------------------------------------


def test_runs_are_put_in_order_of_time() -> None:
    read = read_readings(
        {
            "run": ["b", "a", "b", "a", "b"],
            "time_s": [3, 1, 1, 2, 2],
            "torque_Nm": [33, 1, 31, 2, 32],
            "preload_N": [600] * 5,
            "alpha_arcsec": [1, 2, 3, 4, 5],
        }
    )
    assert read.run.tolist() == ["b", "a", "b", "a", "b"]  # each run keeps its rows
    assert read.torque_Nm.tolist() == [31, 1, 32, 2, 33]
    assert read.line.tolist() == [3, 2, 5, 4, 1]
    assert [note for note in read.notes if "sorted by time within run b: 3 rows" in note]


def test_rows_in_order_stay(write: Write) -> None:
    read = read_readings(CAMPAIGNS[0])
    assert read.line.tolist() == list(range(2, len(read) + 2))


@pytest.mark.parametrize(
    ("runs", "torque", "expected"),
    [
        ([1, 1, 1, 1, 1], [0, 1, 2, 1, 0], [1, 1, 1, -1, -1]),
        ([1, 1, 1, 1, 1], [2, 1, 1, 1, 3], [-1, -1, 0, 0, 1]),
        ([1, 1, 2, 2, 2], [0, 1, 9, 8, 9], [1, 1, -1, -1, 1]),
        ([1, 2, 1, 2, 1], [0, 9, 1, 8, 0], [1, -1, 1, -1, -1]),
        ([1, 2, 2, 3, 3], [0, 9, 9, 1, 0], [0, 0, 0, -1, -1]),
    ],
)
def test_direction(runs: list[int], torque: list[float], expected: list[int]) -> None:
    n = len(runs)
    read = read_readings(
        {"run": runs, "torque_Nm": torque, "preload_N": [600] * n, "alpha_arcsec": range(n)}
    )
    assert read.direction().tolist() == expected


# --- the class ----------------------------------------------------------------------------


def test_readings_are_sealed_and_survive_a_pickle() -> None:
    read = read_readings(TABLE | {"humidity": [1, 2, 3], "time_s": [0, 1, 2]})
    for each in (read, pickle.loads(pickle.dumps(read)), read.select([0, 1])):
        with pytest.raises(ValueError, match="read-only"):
            each.torque_Nm[0] = 1
        with pytest.raises(ValueError, match="read-only"):
            each.extra["humidity"][0] = 1
        with pytest.raises(AttributeError):
            each.source = "elsewhere"  # type: ignore[misc]
    copy = pickle.loads(pickle.dumps(read))
    same(copy, read)
    assert copy.notes == read.notes and copy.sha256 == read.sha256


def test_select() -> None:
    read = read_readings(TABLE | {"humidity": [1, 2, 3]})
    part = read.select(read.run == 2)
    assert len(part) == 1 and part.run_index.tolist() == [0] and part.line.tolist() == [3]
    assert part.extra["humidity"].tolist() == [3] and part.sha256 == read.sha256
    assert read.select([2, 0]).torque_Nm.tolist() == [-2, 0.5]
    assert len(read.select([])) == 0 and "0 readings" in repr(read.select([]))
    assert read.select([]).direction().tolist() == []
    with pytest.raises(ValueError, match="mask"):
        read.select([True, False])


def test_shapes_are_checked() -> None:
    read = read_readings(TABLE)
    with pytest.raises(ValueError, match="torque_Nm"):
        Readings(
            np.ones(2), None, read.input_angle_deg, read.elastic_angle_arcsec, None, read.run,
            None, None, None, read.line,
        )  # fmt: skip


def test_repr() -> None:
    text = repr(read_readings(TABLE | {"u_elastic_angle_arcsec": [0.3, 0.3, 0.3]}))
    assert text == (
        "Readings(3 readings, 2 runs, 2 preload levels 450.5..600 N, torque -2..1.25 N m, "
        "u 0.3 arcsec, '<data>')"
    )


# --- blocks -------------------------------------------------------------------------------


@pytest.mark.parametrize("block", [1, 2, 3, 7, 50_000])
def test_blocks_make_no_difference(
    write: Write, monkeypatch: pytest.MonkeyPatch, block: int
) -> None:
    """Whatever way a block is read, and wherever it ends, the rows and lines are the same."""
    monkeypatch.setattr(table, "_BLOCK", block)
    text = (
        "run,torque_Nm,preload_N,alpha_arcsec,remark,oil\n"
        "1,1,600,1,,1\n1,2,600,2,a,\n\n"
        '1,3,600,3,"over\ntwo lines",3\n# pause\n'
        '"1","4",600,4,"a,b",4\n2,5,600,5,x,5\n2,6,600,6,x,6\n2,7,600,7,x,7\n'
    )
    read = read_readings(write(text))
    assert read.torque_Nm.tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert read.run.tolist() == [1, 1, 1, 1, 2, 2, 2]
    assert read.line.tolist() == [2, 3, 5, 8, 9, 10, 11]
    np.testing.assert_array_equal(read.extra["oil"], [1, math.nan, 3, 4, 5, 6, 7])
    error = refused(write(text + "2,x,600,8,x,8\n3,1\n3,y,600,8,x,8\n"))
    assert [m.lines for m in error.mistakes] == [(13,), (12, 14)]


# --- round trip ---------------------------------------------------------------------------

NAMES = {
    "torque": (["torque", "Torque", "LOAD TORQUE", "M0", "T"], ["Nm", "N m", "kNm", "mN·m"]),
    "preload": (["preload", "Pre-load", "N_Z", "axial force"], ["N", "kN", "mN"]),
    "elastic_angle": (["elastic_angle", "Elastic angle", "alpha"], ["arcsec", "arcmin", "mrad"]),
    "input_angle": (["input angle", "theta", "Crank-Angle"], ["deg", "°", "rad"]),
    "time": (["time", "t", "elapsed_time"], ["s", "ms", "min", "h"]),
    "temperature": (["temperature", "Temp"], ["degC", "°C", "K"]),
    "u_elastic_angle": (["u_elastic_angle", "u(alpha)", "u"], ["arcsec", "urad"]),
}
SIZES = {
    "Nm": 1.0, "N m": 1.0, "kNm": 1e3, "mN·m": 1e-3, "N": 1.0, "kN": 1e3, "mN": 1e-3,
    "arcsec": 1.0, "arcmin": 60.0, "mrad": 648 / math.pi, "urad": 0.648 / math.pi,
    "deg": 1.0, "°": 1.0, "rad": 180 / math.pi, "s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0,
    "degC": 1.0, "°C": 1.0, "K": 1.0,
}  # fmt: skip
OWN = {
    "torque": "torque_Nm",
    "preload": "preload_N",
    "elastic_angle": "elastic_angle_arcsec",
    "input_angle": "input_angle_deg",
    "time": "time_s",
    "temperature": "temperature_degC",
    "u_elastic_angle": "u_elastic_angle_arcsec",
}
STYLES: list[Callable[[str, str], str]] = [
    lambda name, unit: f"{name} [{unit}]",
    lambda name, unit: f"{name} ({unit})",
    lambda name, unit: f"{name} / {unit}",
    lambda name, unit: f"{name}, {unit}",
    lambda name, unit: f"{name}_{unit}",
    lambda name, unit: f"  {name}  [ {unit} ] ",
]
FINITE = st.floats(-1e6, 1e6).map(lambda x: 0.0 if abs(x) < 1e-9 else x)
POSITIVE = st.floats(1e-6, 5e5)
# Below half a turn in every unit that is tried, 3.1 rad and less.
ANGLE = st.floats(-3e3, 3e3).map(lambda x: 0.0 if abs(x) < 1e-9 else x)


@st.composite
def dialects(draw: st.DrawFn) -> tuple[bytes, dict[str, list[float]], list[str]]:
    """A table in some dialect: the bytes, the values in the units of the file, the labels."""
    keys = ["torque", "preload", "elastic_angle"]
    keys += draw(st.lists(st.sampled_from(sorted(NAMES.keys() - set(keys))), unique=True))
    keys = draw(st.permutations(keys))
    n = draw(st.integers(1, 12))
    values: dict[str, list[float]] = {}
    for key in keys:
        kind = POSITIVE if key in {"preload", "u_elastic_angle"} else FINITE
        kind = ANGLE if key == "elastic_angle" else kind
        values[key] = draw(st.lists(kind, min_size=n, max_size=n))
    if "time" in values:
        values["time"] = [float(row) for row in range(n)]
    label = st.text(string.ascii_letters, min_size=1, max_size=4).map(lambda text: "r" + text)
    runs = draw(st.lists(label, min_size=n, max_size=n))

    units = {key: draw(st.sampled_from(NAMES[key][1])) for key in keys}
    separator, decimal = draw(
        st.sampled_from([(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ",")])
    )
    below = draw(st.booleans())
    style = draw(st.sampled_from(STYLES))
    names = {key: draw(st.sampled_from(NAMES[key][0])) for key in keys}
    headers = ["run"] + [names[k] if below else style(names[k], units[k]) for k in keys]
    rows = [[f'"{header}"' for header in headers]]
    if below:
        rows.append(["", *(f"[{units[key]}]" for key in keys)])
    for row in range(n):
        cells = [repr(values[key][row]).replace(".", decimal) for key in keys]
        rows.append([runs[row], *cells])
    quoted = draw(st.booleans())
    lines = []
    for cells in rows:
        lines.append(separator.join(f'"{c.strip(chr(34))}"' if quoted else c for c in cells))
        if draw(st.integers(0, 4)) == 0:
            lines.append(draw(st.sampled_from(["", "  ", "# a remark, 1;2"])))
    text = draw(st.sampled_from(["\n", "\r\n"])).join(lines)
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"]))
    content = text.encode(encoding)
    stated = {key: [units[key]] for key in keys}
    return content, values, [stated[key][0] for key in values] + runs


@given(dialects())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_round_trip(
    tmp_path_factory: pytest.TempPathFactory,
    table: tuple[bytes, dict[str, list[float]], list[str]],
) -> None:
    content, values, words = table
    path = tmp_path_factory.mktemp("dialect") / "t.csv"
    path.write_bytes(content)
    read = read_readings(path)
    units, runs = words[: len(values)], words[len(values) :]
    assert read.run.tolist() == runs
    for (key, written), unit in zip(values.items(), units, strict=True):
        expected = np.array(written) * SIZES[unit] - (273.15 if unit == "K" else 0)
        np.testing.assert_allclose(getattr(read, OWN[key]), expected, rtol=1e-13, atol=1e-10)
    assert (read.time_s is None) == ("time" not in values)


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_damaged_files_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Nothing but ReadingsError, whatever is cut out of a file or put into it."""
    content = CAMPAIGNS[10].read_bytes()
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(content)))
        cut = data.draw(st.integers(0, 9))
        put = data.draw(
            st.sampled_from([b"", b'"', b";", b"\n", b"#", b"\t", b"nan", b"\xff", b"0"])
        )
        content = content[:place] + put + content[place + cut :]
    path = tmp_path_factory.mktemp("damaged") / "t.csv"
    path.write_bytes(content)
    try:
        read = read_readings(path)
    except ReadingsError as error:
        assert str(path) in str(error) and error.expected
    else:
        assert np.isfinite(read.torque_Nm).all() and len(read.direction()) == len(read)


# --- the campaigns ------------------------------------------------------------------------


def test_all_campaigns_are_there() -> None:
    assert [path.stem for path in CAMPAIGNS] == [f"dev{i:02}" for i in range(1, 14)]


@pytest.mark.parametrize("path", CAMPAIGNS, ids=lambda path: path.stem)
def test_campaigns(path: Path) -> None:
    rows, runs, levels = {"dev07": (528, 16, 2), "dev11": (9, 1, 1)}.get(path.stem, (396, 12, 4))
    read = read_readings(path)
    assert len(read) == rows == path.read_text().count("\n") - 1
    assert read.run_index.max() + 1 == runs and read.run.dtype == np.int64
    assert read.preload_N is not None and len(np.unique(read.preload_N)) == levels
    assert read.u_elastic_angle_arcsec is not None
    assert set(read.u_elastic_angle_arcsec) == {0.1 if path.stem == "dev06" else 0.3}
    assert read.time_s is not None and read.temperature_degC is not None and read.extra == {}
    assert set(read.direction()) == ({1} if path.stem == "dev11" else {-1, 1})
    assert bool(read.notes) == (path.stem == "dev11")  # one run at one preload
    np.testing.assert_array_equal(
        read.elastic_angle_arcsec,
        np.loadtxt(path, delimiter=",", skiprows=1, usecols=6),
    )
