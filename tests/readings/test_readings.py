"""The reader of measurement tables: formats that mean the same.

Groups: formats and units (tables), the sensor, time and direction, the class itself.
"""

from __future__ import annotations

import hashlib
import math
import pickle

import numpy as np
import pytest

import cbpt
from cbpt.lab.readings.headers import converted, find_unit, read_header
from cbpt.lab.readings.reader import Readings, read_readings
from common.tables import CAMPAIGNS, PLAIN, TABLE, Write, refused, same

# --- formats that mean the same -----------------------------------------------------------

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
        *[(unit, "torque", 0.1129848290276167) for unit in ("lbf in", "in-lbf", "lbf·in", "in lb")],
        *[(unit, "torque", 1.3558179483314004) for unit in ("lbf ft", "ft-lbf", "lb-ft")],
        ("lbf", "force", 4.4482216152605),
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
    assert found is not None and to is not None and found.quantity == kind
    np.testing.assert_allclose(converted(np.ones(1), found, to), in_own, rtol=1e-14)


@pytest.mark.parametrize(
    ("unit", "kind"),
    [
        ("MNm", "torque"),
        ("MN", "force"),
        ("Mrad", "angle"),
        ("ozf in", "torque"),
        ("kgf", "force"),
        ("", "force"),
        ("grad", "angle"),
    ],
)
def test_units_that_are_not_guessed(unit: str, kind: str) -> None:
    assert find_unit(unit, kind) is None


def test_own_units_are_read_exactly(write: Write) -> None:
    """A value in the standard unit is the float that stands in the file."""
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
    assert said.unit is not None and said.unit.written == symbol
    assert not said.expected


@pytest.mark.parametrize(
    "header",
    ["U [V]", "M [kg]", "commanded_torque_Nm", "angle_deg", "T_amb", "F [N]", ""],
)
def test_headers_of_other_things(header: str) -> None:
    said = read_header(header)
    assert said.quantity is None and not said.expected


@pytest.mark.parametrize(
    ("header", "below", "expected"),
    [
        ("torque", "", "a unit for torque (N m, N cm, N mm, mN m, kN m, lbf in, lbf ft)"),
        ("T", "", "a unit for time or torque or temperature"),
        (
            "torque [ozf in]",
            "",
            "one of N m, N cm, N mm, mN m, kN m, lbf in",
        ),
        ("torque [N]", "", "as the unit of torque"),
        ("preload / t", "", "as the unit of preload"),
        ("torque_Nm", "kNm", "one unit, not both 'Nm' and 'kNm'"),
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
        "input_angle_deg",
        "temperature_degC",
        "u_elastic_angle_arcsec",
    ):
        assert any(note.startswith(f"the table has no {name} column") for note in read.notes), name
    assert "preload" not in " ".join(read.notes)  # none is needed


def test_other_columns(write: Write) -> None:
    text = (
        ",torque_Nm,preload_N,alpha_arcsec,humidity,operator,empty,T_oil\n"
        "0,1,600,3,40,Ann,,\n1,2,600,6,,Bob,,nan\n2,3,600,9,42,,,31\n"
    )
    read = read_readings(write(text))
    assert read.extra.keys() == {"column 1", "humidity", "T_oil"}
    np.testing.assert_array_equal(read.extra["humidity"], [40, math.nan, 42])
    np.testing.assert_array_equal(read.extra["T_oil"], [math.nan, math.nan, 31])
    assert "ignored column 'operator': line 2 has 'Ann', which is no number" in read.notes


@pytest.mark.parametrize(
    ("rows", "note"),
    [
        ("0,600,3\n0,700,4\n", "the torque is 0 in every row"),
        ("5,600,3\n5,700,4\n", "the torque is 5 N m in every row"),
        ("1,600,3\n2,700,14400\n", "the elastic angle goes 2 deg from the middle of its run, more"),
        ("1,600,3\n2,600,4\n", "the preload is the same in every row"),
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
    assert any("'sensor_displacement_um' is not used" in note for note in read.notes)


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


def test_a_header_without_a_unit_gives_way_to_one_that_states_it() -> None:
    """`moment` is a torque, and also a word for when something was measured."""
    told = {"moment": ["before", "after"], "torque_Nm": [1, 2], "elastic_angle_arcsec": [2.5, 5]}
    read = cbpt.read_readings(told, need_preload=False)
    assert read.torque_Nm.tolist() == [1, 2]
    assert any("'moment' is not used" in note and "states no unit" in note for note in read.notes)
    alone = {"moment": [1, 2], "elastic_angle_arcsec": [2.5, 5]}
    with pytest.raises(cbpt.ReadingsError, match="expected a unit for torque"):
        cbpt.read_readings(alone, need_preload=False)
    stated = {"moment_Nm": [1, 2], "elastic_angle_arcsec": [2.5, 5]}
    read = cbpt.read_readings(stated, need_preload=False)
    assert any("'moment_Nm' as torque in N m" in note for note in read.notes)


def test_a_column_with_a_unit_that_is_not_used_is_told() -> None:
    """It may be meant to be; one without a unit is a remark of the user's."""
    table = {
        "torque_Nm": [0.0, 1.0],
        "preload_N": [500.0, 500.0],
        "elastic_angle_arcsec": [0.0, 5.0],
        "Crank [deg]": [0.0, 0.0],
        "operator": [1.0, 1.0],
    }
    notes = cbpt.read_readings(table).notes
    assert any(note.startswith("column 'Crank [deg]' is not used") for note in notes)
    assert not any("operator" in note for note in notes)
    assert not any(
        "Crank" in note
        for note in cbpt.read_readings(table, columns={"Crank [deg]": "extra"}).notes
    )


def test_readings_of_several_labels_are_told_to_be_taken_together() -> None:
    table = {
        "torque_Nm": np.linspace(-5, 5, 12),
        "preload_N": np.full(12, 600.0),
        "elastic_angle_arcsec": np.linspace(-12, 12, 12),
    }
    two = cbpt.read_readings(table | {"design": ["conic"] * 6 + ["split"] * 6})
    (told,) = [note for note in two.notes if "taken together" in note]
    assert "2 values of 'design' (conic, split)" in told and "--only design=conic" in told
    assert "cbpt change --by design (change) says what differs" in told
    for labels in (["conic"] * 12, [f"remark {n}" for n in range(12)]):
        one = cbpt.read_readings(table | {"design": labels})
        assert not any("taken together" in note for note in one.notes)
