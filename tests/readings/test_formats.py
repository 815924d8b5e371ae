"""Tables of readings from files of other programs, and from objects of other libraries.

Groups: one campaign through every format; workbooks; MATLAB; TDMS; Parquet; objects in memory;
files that are broken, libraries that are missing. Every file is made here, by a library that is
not the one that reads it where there is such a one.
"""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import nptdms
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io
import xarray
import xlsxwriter

import cbpt
from cbpt.errors import Mistake, ReadingsError
from cbpt.lab.readings.reader import read_readings
from common.tables import CAMPAIGNS, TABLE, refused, same

Columns = Mapping[str, Any]
N = 12
rng = np.random.default_rng(7)
# Numbers that no decimal of a few digits can stand for.
CAMPAIGN: dict[str, Any] = {
    "run": np.repeat([1, 2, 3], 4),
    "time_s": np.tile([0.0, 1.1, 2.2, 3.3], 3) + np.repeat([0, 100, 200], 4),
    "torque_Nm": rng.normal(0, 5, N),
    "preload_N": np.repeat([300.0, 600.0, 900.0], 4) + rng.normal(0, 1, N),
    "input_angle_deg": np.repeat([0.0, 10.0, 20.0], 4),
    "temperature_degC": rng.normal(20, 1, N),
    "elastic_angle_arcsec": rng.normal(0, 10, N),
    "u_elastic_angle_arcsec": rng.uniform(0.1, 0.3, N),
}


# --- makers of files ----------------------------------------------------------------------


def xlsx(path: Path, columns: Columns, name: str = "Data", row: int = 0) -> None:
    with xlsxwriter.Workbook(path) as book:
        sheet(book, name, columns, row)


def sheet(
    book: xlsxwriter.Workbook, name: str, columns: Columns, row: int = 0, column: int = 0
) -> Any:
    page = book.add_worksheet(name)
    date = book.add_format({"num_format": "yyyy-mm-dd hh:mm:ss.000"})
    for j, (header, values) in enumerate(columns.items(), column):
        page.write(row, j, header)
        for i, value in enumerate(values, row + 1):
            if isinstance(value, datetime.datetime):
                page.write_datetime(i, j, value, date)
            else:
                page.write(i, j, value)
    return page


def mat(path: Path, columns: Columns) -> None:
    scipy.io.savemat(path, dict(columns))


def mat_struct(path: Path, columns: Columns) -> None:
    scipy.io.savemat(path, {"rig": "A", "campaign": dict(columns)}, oned_as="column")


def mat73(path: Path, columns: Columns) -> None:
    """As MATLAB 7.3 writes it: HDF5 behind a header of 512 bytes, columns as matrices (1, n)."""
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("campaign")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in columns.items():
            made = group.create_dataset(name, data=np.asarray(values, dtype=np.float64)[None, :])
            made.attrs["MATLAB_class"] = np.bytes_("double")
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\0\2IM"
    with path.open("r+b") as raw:
        raw.write(header)


def tdms(path: Path, columns: Columns, units: Mapping[str, str] | None = None) -> None:
    write_tdms(path, {"Campaign": columns}, units or {})


def write_tdms(
    path: Path,
    groups: Mapping[str, Columns],
    units: Mapping[str, str],
    properties: Mapping[str, Any] | None = None,
) -> None:
    with nptdms.TdmsWriter(path) as writer:
        for group, columns in groups.items():
            writer.write_segment(
                [
                    nptdms.ChannelObject(
                        group,
                        name,
                        np.asarray(values),
                        properties={**({"unit_string": units[name]} if name in units else {})}
                        | dict(properties or {}),
                    )
                    for name, values in columns.items()
                ]
            )


def parquet(path: Path, columns: Columns) -> None:
    pq.write_table(pa.table(dict(columns)), path)


Maker = Callable[[Path, Columns], None]
FORMATS: dict[str, tuple[str, Maker]] = {
    "xlsx": ("t.xlsx", xlsx),
    "mat": ("t.mat", mat),
    "mat struct": ("t.mat", mat_struct),
    "mat 7.3": ("t.mat", mat73),
    "tdms": ("t.tdms", tdms),
    "parquet": ("t.parquet", parquet),
}
EACH = pytest.mark.parametrize(("name", "make"), FORMATS.values(), ids=FORMATS.keys())

# --- one campaign through every format ----------------------------------------------------


@EACH
def test_every_format_says_the_same(tmp_path: Path, name: str, make: Maker) -> None:
    make(tmp_path / name, CAMPAIGN)
    read, plain = read_readings(tmp_path / name), read_readings(CAMPAIGN)
    same(read, plain, rtol=0 if name != "t.xlsx" else 1e-15)  # xlsx keeps 16 digits
    assert read.run.tolist() == plain.run.tolist() and read.run.dtype == plain.run.dtype
    assert read.source == str(tmp_path / name) and len(read.sha256) == 64
    assert read.notes == plain.notes and read.extra == {}
    assert read.place == "row"


@EACH
def test_a_campaign_is_compared_alike(tmp_path: Path, name: str, make: Maker) -> None:
    data = CAMPAIGNS[0]
    names = data.read_text().splitlines()[0].split(",")
    values = np.loadtxt(data, delimiter=",", skiprows=1)
    make(tmp_path / name, dict(zip(names, values.T, strict=True)))
    case = data.with_suffix(".toml")
    a, b = cbpt.compare(case, data), cbpt.compare(case, tmp_path / name)
    np.testing.assert_allclose(a.residual_arcsec, b.residual_arcsec, rtol=1e-9, atol=1e-12)


@EACH
def test_mistakes_have_their_row(tmp_path: Path, name: str, make: Maker) -> None:
    make(tmp_path / name, CAMPAIGN | {"preload_N": [*CAMPAIGN["preload_N"][:-1], -5.0]})
    error = refused(tmp_path / name)
    # The row of the sheet, under the headers; elsewhere that of the reading.
    assert error.line == (N + 1 if name == "t.xlsx" else N)
    assert error.column == "preload_N" and "-5" in error.value
    assert str(tmp_path / name) in str(error) and "row" in str(error)


@EACH
def test_units_in_headers_and_what_the_user_says(tmp_path: Path, name: str, make: Maker) -> None:
    torque, angle = CAMPAIGN["torque_Nm"], CAMPAIGN["elastic_angle_arcsec"]
    make(
        tmp_path / name,
        {"Moment_Ncm": torque * 100, "preload_kN": CAMPAIGN["preload_N"] / 1e3, "angle": angle},
    )
    columns = {"angle": "elastic_angle_arcsec"}
    read = read_readings(tmp_path / name, columns=columns)
    np.testing.assert_allclose(read.torque_Nm, torque, rtol=1e-14)
    np.testing.assert_allclose(read.elastic_angle_arcsec, angle, rtol=1e-14)
    assert "a column elastic_angle_arcsec" in str(refused(tmp_path / name))
    expected = "one of the headers"
    assert expected in str(refused(tmp_path / name, columns={"angel": "elastic_angle_deg"}))


# --- workbooks ----------------------------------------------------------------------------


def test_a_sheet_as_people_write_it(tmp_path: Path) -> None:
    """A title, an empty row and column, a row of units, a gap, dates, a note beside the table."""
    start = datetime.datetime(2026, 3, 28, 23, 59, 59)
    times = [start + datetime.timedelta(seconds=s) for s in (0, 1, 2.5, 60)]
    assert times[1].time() == datetime.time()  # midnight, which is a date without a time
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        page = sheet(
            book,
            "Messung",
            {
                "time": ["", *times[:2], "", *times[2:]],
                "T": ["N m", 1.0, 2.0, "", 3.0, 4.0],
                "N_Z": ["kN", 0.6, 0.6, "", 0.6, 0.6],
                "alpha": ["″", 3, 6, "", 9, 12],
                "remark": ["", "", "", "", "slipped?", ""],
            },
            row=3,
            column=1,
        )
        page.write(0, 1, "Rig 3, brake")
    read = read_readings(tmp_path / "t.xlsx")
    assert read.torque_Nm.tolist() == [1, 2, 3, 4]
    assert read.preload_N is not None and read.preload_N.tolist() == [600] * 4
    assert read.time_s is not None
    np.testing.assert_allclose(read.time_s, [0, 1, 2.5, 60], atol=1e-6)
    assert read.line.tolist() == [6, 7, 9, 10]
    assert any("rows above the headers were skipped (1 to 1)" in note for note in read.notes)
    assert any("ignored column 'remark': row 9 has 'slipped?'" in note for note in read.notes)


@pytest.mark.parametrize(
    ("form", "value", "seconds"),
    [("hh:mm:ss", 0.25, 21600.0), ("[h]:mm:ss", 1.25, 108000.0), ("mm:ss.0", 1e-3, 86.4)],
)
def test_durations_are_seconds(tmp_path: Path, form: str, value: float, seconds: float) -> None:
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        page = sheet(book, "Data", TABLE | {"time [min]": [0, 0, 0]})
        for row, number in enumerate((0.0, value, 0.0), 1):
            page.write_number(row, len(TABLE), number, book.add_format({"num_format": form}))
    read = read_readings(tmp_path / "t.xlsx")
    assert read.time_s is not None
    np.testing.assert_allclose(read.time_s, [0, seconds, 0], rtol=1e-9)


def test_the_sheet_with_readings_is_found(tmp_path: Path) -> None:
    path = tmp_path / "t.xlsx"
    with xlsxwriter.Workbook(path) as book:
        sheet(book, "Rig", {"sensor": ["eddy current"], "range": [2]})
        book.add_worksheet("Empty")
        sheet(book, "A", TABLE)
        sheet(book, "B", TABLE | {"torque_Nm": [1, 2, 3]})
    read = read_readings(path)
    assert read.torque_Nm.tolist() == TABLE["torque_Nm"]
    assert read.source == f"{path}, sheet 'A'"
    assert any("'B' may hold readings too" in note for note in read.notes)
    assert read_readings(path, sheet="B").torque_Nm.tolist() == [1, 2, 3]
    error = refused(path, sheet="C")
    assert "no sheet 'C'" in str(error) and "'Rig', 'A', 'B'" in str(error)
    assert "'sensor'" in str(refused(path, sheet="Rig"))
    case = cbpt.Case.from_toml(cbpt.example_case())
    assert cbpt.compare(case, path, sheet="B").readings.torque_Nm.tolist() == [1, 2, 3]


def test_no_sheet_with_readings(tmp_path: Path) -> None:
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        sheet(book, "A", {"Last": [1.0, 2], "F": [600.0, 600], "Winkel": [3.0, 6]})
        sheet(book, "B", {"x": [1]})
    error = refused(tmp_path / "t.xlsx")
    assert "'A', 'B'" in error.value and "sheet='A'" in str(error)
    columns = {"Last": "torque_Nm", "F": "preload_N", "Winkel": "elastic_angle_arcsec"}
    assert read_readings(tmp_path / "t.xlsx", columns=columns).torque_Nm.tolist() == [1, 2]


@pytest.mark.parametrize(
    ("cell", "value"), [("abc", "'abc'"), ("", "an empty cell"), (True, "'True'"), ("1,5", "'1,5'")]
)
def test_cells_that_are_no_numbers(tmp_path: Path, cell: Any, value: str) -> None:
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        sheet(book, "A", TABLE | {"torque_Nm": [1.5, cell, 2]})
        sheet(book, "B", {"x": [1]})
    error = refused(tmp_path / "t.xlsx")
    assert (error.line, error.column, error.value) == (3, "torque_Nm", value)
    assert "sheet 'A'" in error.path


def test_a_stray_cell_far_out_is_told(tmp_path: Path) -> None:
    """Unpacked as a rectangle this sheet would take half a terabyte."""
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        sheet(book, "A", TABLE).write(1_048_575, 16_383, 1)
    assert "one cell far out" in str(refused(tmp_path / "t.xlsx"))


def test_a_format_far_out_is_no_cell(tmp_path: Path) -> None:
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        sheet(book, "A", TABLE).write_blank(
            1_048_575, 16_383, None, book.add_format({"bold": True})
        )
    assert len(read_readings(tmp_path / "t.xlsx")) == 3


# --- MATLAB -------------------------------------------------------------------------------


def test_matrix_with_names(tmp_path: Path) -> None:
    names = ["torque_Nm", "preload_N", "elastic_angle_arcsec"]
    data = np.column_stack([CAMPAIGN[name] for name in names])
    path = tmp_path / "t.mat"
    scipy.io.savemat(path, {"data": data, "names": np.array(names, dtype=object)})
    np.testing.assert_array_equal(read_readings(path).torque_Nm, CAMPAIGN["torque_Nm"])
    scipy.io.savemat(path, {"data": data})
    error = refused(path)
    assert error.column == "data" and "a matrix of 3 columns without names" in error.value
    assert "names = {'torque_Nm', ...}" in str(error)


def test_what_is_no_column_is_told(tmp_path: Path) -> None:
    path = tmp_path / "t.mat"
    table = {key: CAMPAIGN[key] for key in ("torque_Nm", "elastic_angle_arcsec")}
    runs = np.array(["a", "b"], dtype=object).repeat(6)
    given = table | {"run": runs, "preload_N": 600.0, "gain": 2.0, "coefficients": [1, 2, 3]}
    scipy.io.savemat(path, {"campaign": given, "info": {"rig": "A"}})
    read = read_readings(path, fill={"preload_N": 600})
    assert read.run.tolist() == runs.tolist() and read.run_index.max() == 1
    assert "coefficients: not read" in str(read.notes) and "preload_N: not read" in str(read.notes)
    short = CAMPAIGN | {"torque_Nm": CAMPAIGN["torque_Nm"][:-1]}
    mat(path, short)
    assert refused(path).mistakes == (
        Mistake((), "torque_Nm", f"{N - 1} values", f"{N}, one for each row"),
    )


def test_several_structs(tmp_path: Path) -> None:
    path = tmp_path / "t.mat"
    other = CAMPAIGN | {"torque_Nm": -CAMPAIGN["torque_Nm"]}
    scipy.io.savemat(path, {"a": CAMPAIGN, "deep": {"b": other}})
    assert read_readings(path).source.endswith("struct 'a'")
    assert read_readings(path, sheet="deep.b").torque_Nm[0] == other["torque_Nm"][0]
    assert "'a', 'deep.b'" in str(refused(path, sheet="b"))


def test_a_file_without_vectors(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "t.mat", {"x": 1.0})
    assert "no struct with a table in it" in str(refused(tmp_path / "t.mat"))


# --- TDMS ---------------------------------------------------------------------------------


def test_units_of_channels(tmp_path: Path) -> None:
    columns = {
        "Torque": CAMPAIGN["torque_Nm"] * 100,
        "Preload": CAMPAIGN["preload_N"],
        "Elastic angle": CAMPAIGN["elastic_angle_arcsec"] / 3600,
        "Voltage": np.ones(N),
    }
    units = {"Torque": "N·cm", "Preload": "N", "Elastic angle": "°", "Voltage": "V"}
    tdms(tmp_path / "t.tdms", columns, units)
    read = read_readings(tmp_path / "t.tdms")
    np.testing.assert_allclose(read.torque_Nm, CAMPAIGN["torque_Nm"], rtol=1e-14)
    angle = CAMPAIGN["elastic_angle_arcsec"]
    np.testing.assert_allclose(read.elastic_angle_arcsec, angle, rtol=1e-14)
    assert list(read.extra) == ["Voltage"]
    tdms(tmp_path / "t.tdms", columns, units | {"Torque": "ozf in"})
    assert "'Torque' with the unit 'ozf in'" in str(refused(tmp_path / "t.tdms"))


@pytest.mark.parametrize("clock", [False, True])
def test_waveforms_bring_their_time(tmp_path: Path, clock: bool) -> None:
    columns = {k: v for k, v in CAMPAIGN.items() if clock or k != "time_s"}
    waveform = {"wf_start_offset": 2.0, "wf_increment": 0.05, "wf_samples": N}
    write_tdms(tmp_path / "t.tdms", {"A": columns}, {}, waveform)
    read = read_readings(tmp_path / "t.tdms")
    assert read.time_s is not None
    expected = CAMPAIGN["time_s"] if clock else 2 + 0.05 * np.arange(N)
    np.testing.assert_allclose(read.time_s, expected, rtol=1e-15)
    assert any("0.05 s between readings" in note for note in read.notes) is not clock


def test_groups_and_lengths(tmp_path: Path) -> None:
    path = tmp_path / "t.tdms"
    other = CAMPAIGN | {"torque_Nm": -CAMPAIGN["torque_Nm"]}
    write_tdms(path, {"Setup": {"gain": [1.0]}, "Run 1": CAMPAIGN, "Run 2": other}, {})
    assert read_readings(path).source == f"{path}, group 'Run 1'"
    assert read_readings(path, sheet="Run 2").torque_Nm[0] == other["torque_Nm"][0]
    tdms(path, CAMPAIGN | {"torque_Nm": [1.0, 2.0]})
    error = refused(path)
    assert (error.column, error.value) == ("torque_Nm", "2 values")


# --- Parquet ------------------------------------------------------------------------------


def test_units_of_fields(tmp_path: Path) -> None:
    fields = [
        pa.field("torque", pa.float64(), metadata={"unit": "kN m"}),
        pa.field("preload", pa.int32(), metadata={"units": "N"}),
        pa.field("elastic angle", pa.float32(), metadata={"unit": "deg"}),
        pa.field("when", pa.timestamp("ms")),
        pa.field("run", pa.string()),
    ]
    start = datetime.datetime(2026, 1, 1)
    times = [start, start + datetime.timedelta(seconds=1.5), start]
    values = [[1.0, 2.0, 3.0], [600, 600, 300], [0.5, 0.25, 0.125], times, ["a", "a", "b"]]
    pq.write_table(pa.table(values, schema=pa.schema(fields)), tmp_path / "t.parquet")
    read = read_readings(tmp_path / "t.parquet", columns={"when": "time_s"})
    assert read.torque_Nm.tolist() == [1000, 2000, 3000]
    assert read.elastic_angle_arcsec.tolist() == [1800, 900, 450]
    assert read.time_s is not None and read.time_s.tolist() == [0, 1.5, 0]
    assert read.run.tolist() == ["a", "a", "b"]
    notes = str(read_readings(tmp_path / "t.parquet").notes)
    assert "ignored column 'when': it has dates" in notes and "columns={'when': 'time_s'}" in notes


def test_gaps_and_lists(tmp_path: Path) -> None:
    path = tmp_path / "t.parquet"
    parquet(path, TABLE | {"torque_Nm": pa.array([1.0, None, 2.0])})
    assert refused(path).line == 2
    parquet(path, TABLE | {"torque_Nm": pa.array([[1.0], [2.0], [3.0, 4.0]])})
    assert refused(path).column == "torque_Nm"


# --- objects in memory --------------------------------------------------------------------


def test_a_data_frame_and_a_structured_array() -> None:
    data = xarray.Dataset({k: ("row", v) for k, v in CAMPAIGN.items()})
    frame = data.to_dataframe()
    same(read_readings(frame), read_readings(CAMPAIGN), rtol=0)
    assert read_readings(frame).sha256 == read_readings(CAMPAIGN).sha256
    same(read_readings(frame.to_records(index=False)), read_readings(CAMPAIGN), rtol=0)


def test_a_data_set_with_axes_and_units() -> None:
    data = xarray.Dataset(
        {
            "torque": ("time_s", CAMPAIGN["torque_Nm"] * 1e3, {"units": "mN m"}),
            "preload": ("time_s", CAMPAIGN["preload_N"], {"units": "N"}),
            "elastic_angle": ("time_s", CAMPAIGN["elastic_angle_arcsec"], {"units": "arcsec"}),
        },
        coords={"time_s": CAMPAIGN["time_s"]},
    )
    read = read_readings(data)
    np.testing.assert_allclose(read.torque_Nm, CAMPAIGN["torque_Nm"], rtol=1e-14)
    assert read.time_s is not None and read.time_s.tolist() == CAMPAIGN["time_s"].tolist()


def test_dates_with_a_time_zone() -> None:
    frame = xarray.Dataset({k: ("row", v) for k, v in CAMPAIGN.items()}).to_dataframe()
    frame["time"] = frame.pop("time_s").astype("datetime64[s]").dt.tz_localize("Europe/Berlin")
    read = read_readings(frame)
    assert read.time_s is not None
    np.testing.assert_allclose(read.time_s, np.floor(CAMPAIGN["time_s"]))


# --- broken files, missing libraries ------------------------------------------------------


@EACH
@pytest.mark.parametrize("part", [0.02, 0.3, 0.6, 0.95])
def test_a_torn_file_is_told(tmp_path: Path, name: str, make: Maker, part: float) -> None:
    """Never a traceback of the library, never other numbers than were written."""
    path = tmp_path / name
    make(path, CAMPAIGN)
    raw = path.read_bytes()
    path.write_bytes(raw[: max(int(part * len(raw)), 16)])
    try:
        read = read_readings(path)
    except ReadingsError as error:
        assert str(path) in str(error) and len(str(error)) < 1500
    else:  # what is torn off was padding
        same(read, read_readings(CAMPAIGN), rtol=1e-15)


@EACH
def test_a_file_with_other_bytes_is_told(tmp_path: Path, name: str, make: Maker) -> None:
    path = tmp_path / name
    make(path, CAMPAIGN)
    raw = bytearray(path.read_bytes())
    for at in np.random.default_rng(3).integers(16, len(raw), 4).tolist():
        path.write_bytes(bytes(raw[:at]) + bytes([raw[at] ^ 0xFF]) + bytes(raw[at + 1 :]))
        try:
            read_readings(path)
        except ReadingsError as error:
            assert str(path) in str(error)


LIBRARIES = ["python_calamine", "pymatreader", "pymatreader", "h5py", "nptdms", "pyarrow"]


@pytest.mark.parametrize(
    ("format", "library"), list(zip(FORMATS, LIBRARIES, strict=True)), ids=FORMATS.keys()
)
def test_a_missing_library_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, format: str, library: str
) -> None:
    name, make = FORMATS[format]
    make(tmp_path / name, CAMPAIGN)
    (tmp_path / "without").mkdir()
    there = tmp_path / "without" / f"{library}.py"
    there.write_text(f"raise ModuleNotFoundError('no module', name={library!r})")
    monkeypatch.syspath_prepend(there.parent)
    error = refused(tmp_path / name)
    assert 'pip install "cbpt[io]"' in str(error) and library in str(error)


def test_a_text_table_has_no_sheets(tmp_path: Path) -> None:
    assert "a file with the sheet 'A'" in str(refused(CAMPAIGNS[0], sheet="A"))


def test_text_above_the_headers_is_skipped(tmp_path: Path) -> None:
    """As test rigs write it, in German."""
    path = tmp_path / "lauf.csv"
    path.write_text(
        "Getriebe A, 12.11.2026; Prüfer: Müller; 600 N\n\n"
        "Zeit;Drehmoment;Verdrehwinkel;Lauf\n[s];[Nm];[arcmin];\n"
        "0,5;1,0;0,05;1\n1,5;2,0;0,10;1\n",
        encoding="utf-8",
    )
    read = read_readings(path, need_preload=False)
    assert read.torque_Nm.tolist() == [1, 2]
    assert read.elastic_angle_arcsec == pytest.approx([3, 6])
    assert read.line.tolist() == [5, 6]
    assert any("above the headers" in note and "(line 1)" in note for note in read.notes)
