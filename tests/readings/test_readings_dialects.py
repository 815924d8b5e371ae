"""The reader of measurement tables: long ones, random dialects, and the campaigns.

Groups: blocks, a round trip through random dialects, the campaigns.
"""

from __future__ import annotations

import math
import string
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbpt.errors import ReadingsError
from cbpt.lab.readings import text as table
from cbpt.lab.readings.reader import read_readings
from common.drives import examples
from common.tables import CAMPAIGNS, Write, refused

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
# Below a quarter of a turn in every unit that is tried, so that no two differ by a whole one.
ANGLE = st.floats(-1.5e3, 1.5e3).map(lambda x: 0.0 if abs(x) < 1e-9 else x)


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
@examples(150)
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
@examples(150)
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

UNLIKE = [CAMPAIGNS[i] for i in (0, 5, 6, 10)]  # in rows, runs, levels or uncertainty


def test_all_campaigns_are_there() -> None:
    assert [path.stem for path in CAMPAIGNS] == [f"dev{i:02}" for i in range(1, 14)]


@pytest.mark.parametrize("path", UNLIKE, ids=lambda path: path.stem)
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
    few = (
        "the preload is the same in every row"
        if path.stem == "dev11"
        else "only three input angles"
    )
    assert [note for note in read.notes if few in note] == list(read.notes)[-1:]
    assert bool(read.notes) == (path.stem != "dev07")
    np.testing.assert_array_equal(
        read.elastic_angle_arcsec,
        np.loadtxt(path, delimiter=",", skiprows=1, usecols=6),
    )
