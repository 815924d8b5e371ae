"""Tables of parts as made in CSV files: what is read, and what is told of bad ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import cbpt

TOP = Path(__file__).parents[2]
BASE = (TOP / "examples/base_case.toml").read_text(encoding="utf-8")

Rows = list[str]


def profile(rows: int = 360, unit: str = "um") -> Rows:
    size = {"um": 2.0, "mm": 0.002}[unit]
    angles = [360.0 * row / rows for row in range(rows)]
    lines = [f"{angle},{size * np.cos(3 * np.deg2rad(angle))}" for angle in angles]
    return [f"groove_angle_deg,deviation_{unit}", *lines]


def balls(count: int = 20) -> Rows:
    return ["ball,diameter_mm", *(f"{ball},{3.0 + 1e-4 * ball}" for ball in range(count))]


def rings(count: int = 14) -> Rows:
    rows = [
        f"{ring},{10 * step},{np.sin(np.deg2rad(10 * step)) + 0.1 * ring}"
        for ring in range(count)
        for step in range(36)
    ]
    return ["ring,ring_angle_deg,deviation_um", *rows]


def read(folder: Path, key: str, lines: Rows, more: str = "") -> cbpt.Case:
    (folder / "table.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "case.toml").write_text(
        f'{BASE}\n[as_made]\n{key} = "table.csv"\n{more}', encoding="utf-8"
    )
    return cbpt.Case.from_file(folder / "case.toml")


def angles(case: cbpt.Case) -> list[float]:
    found = cbpt.solve_many(case, 3.0, 600.0, [0.0, 50.0, 400.0]).elastic_angle_rad
    return [float(angle) for angle in found]


# --- what is read -------------------------------------------------------------------------


def test_units_and_ways_of_writing_are_one(tmp_path: Path) -> None:
    plain = angles(read(tmp_path, "epicycloid_profile", profile()))
    assert angles(read(tmp_path, "epicycloid_profile", profile(unit="mm"))) == pytest.approx(
        plain, rel=1e-12
    )
    german = [line.replace(",", ";").replace(".", ",") for line in profile()]
    assert angles(read(tmp_path, "epicycloid_profile", german)) == plain
    with_notes = ["# a measuring machine", "", *profile(), ""]
    assert angles(read(tmp_path, "epicycloid_profile", with_notes)) == plain
    closed = [*profile(), "360,2.0"]
    assert angles(read(tmp_path, "epicycloid_profile", closed)) == plain
    in_other_columns = [",".join(reversed(line.split(","))) + ",x" for line in profile()]
    assert angles(read(tmp_path, "epicycloid_profile", in_other_columns)) == plain


def test_balls_stand_by_their_numbers(tmp_path: Path) -> None:
    plain = angles(read(tmp_path, "deceleration_balls", balls()))
    shuffled = ["ball,diameter_um", *(f"{b},{3000 + 0.1 * b}" for b in reversed(range(20)))]
    assert angles(read(tmp_path, "deceleration_balls", shuffled)) == pytest.approx(plain, rel=1e-9)
    assert angles(read(tmp_path, "equal_speed_balls", balls(14))) != plain


def test_rings_have_a_profile_each(tmp_path: Path) -> None:
    case = read(tmp_path, "planet_rings", rings())
    assert case.drive.has_parts_as_made
    assert cbpt.Case.from_toml(case.to_toml()) == case


def test_the_path_is_relative_to_the_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read(tmp_path, "epicycloid_profile", profile())
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert cbpt.Case.from_file("../case.toml").drive.has_parts_as_made


# --- what is told -------------------------------------------------------------------------


def without(rows: slice) -> Callable[[], Rows]:
    def made() -> Rows:
        lines = profile()
        del lines[rows]
        return lines

    return made


def changed(row: int, line: str, of: Callable[[], Rows] = profile) -> Callable[[], Rows]:
    def made() -> Rows:
        lines = of()
        lines[row - 1] = line
        return lines

    return made


def drifting() -> Rows:
    head, *lines = profile()
    return [head, *(f"{line.split(',')[0]},{0.01 * row}" for row, line in enumerate(lines))]


GROOVE = "epicycloid_profile"
BAD: list[tuple[str, Callable[[], Rows], list[str]]] = [
    # key, table, what the message must have
    (GROOVE, without(slice(100, 160)), ["row 100", "gap from 98 to 159 deg", "measure"]),
    (GROOVE, without(slice(181, 361)), ["row 181", "gap from 179 to 360 deg"]),
    (GROOVE, changed(50, "48,NaN"), ["row 50", 'deviation_um = "NaN"', "finite"]),
    (GROOVE, changed(50, "48,"), ["row 50", "deviation_um is empty"]),
    (GROOVE, changed(50, "48,2.o"), ["row 50", '"2.o"']),
    (GROOVE, changed(50, "46,1.0"), ["row 50", "46 deg after 47 deg", "sort"]),
    (GROOVE, changed(50, "48,5000"), ["row 50", "5000 um", "unit"]),
    (GROOVE, changed(361, "900,1"), ["row 361", "one turn of 360 deg"]),
    (GROOVE, drifting, ["row 361", "close after 360 deg", "drift"]),
    (GROOVE, lambda: profile(5), ["row 6", "5 rows", "8 rows or more"]),
    (GROOVE, lambda: profile()[:1], ["has a header and no rows"]),
    (GROOVE, lambda: ["angle,deviation_um", "1,2"], ["row 1", "no column groove_angle_deg"]),
    (GROOVE, lambda: ["groove_angle_deg,deviation", "1,2"], ["row 1", "deviation has no unit"]),
    (GROOVE, lambda: profile(13_000), ["12000 rows", "every nth row"]),
    ("deceleration_balls", lambda: balls(19), ["19 diameters", "each of the 20 balls"]),
    ("deceleration_balls", changed(5, "3,1.5", balls), ["table.csv, ball 3: 1.5 mm", "no radius"]),
    ("deceleration_balls", changed(5, "2,3.0", balls), ["row 5", "ball 2 stands on row 4"]),
    ("deceleration_balls", changed(5, "30,3.0", balls), ["ball 3 is missing"]),
    ("deceleration_balls", changed(5, "3.5,3.0", balls), ["row 5", "ball = 3.5"]),
    ("planet_rings", lambda: rings(13), ["13 rings", "each of the 14 rings"]),
    ("planet_rings", changed(40, "1,20,900000", rings), ["row 40", "ring 1", "unit"]),
]  # fmt: skip


@pytest.mark.parametrize(("key", "table", "words"), BAD, ids=[f"{k}-{w[0]}" for k, _, w in BAD])
def test_bad_tables_are_told_with_file_and_row(
    tmp_path: Path, key: str, table: Callable[[], Rows], words: list[str]
) -> None:
    with pytest.raises(cbpt.CaseError) as told:
        read(tmp_path, key, table())
    message = str(told.value)
    assert f"case.toml:{BASE.count(chr(10)) + 3}: as_made.{key}: table.csv" in message, message
    if words[0].startswith("row"):
        assert f"table.csv, {words[0]}:" in message, message
    for word in words:
        assert word in message, message


def test_a_missing_file_and_a_text_without_folder_are_told(tmp_path: Path) -> None:
    text = f'{BASE}\n[as_made]\nepicycloid_profile = "nowhere.csv"\n'
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    with pytest.raises(cbpt.CaseError, match=r"nowhere.csv: file not found; the path is relative"):
        cbpt.Case.from_file(tmp_path / "case.toml")
    with pytest.raises(cbpt.CaseError, match=r"has no folder .* epicycloid_deviation_um"):
        cbpt.Case.from_toml(text)


def test_file_and_list_are_one_too_many(tmp_path: Path) -> None:
    with pytest.raises(cbpt.CaseError, match="gives it as a list as well; keep one"):
        read(tmp_path, "epicycloid_profile", profile(), "epicycloid_deviation_um = [1.0]\n")


LISTS = [
    ("epicycloid_deviation_um = [1.0, 2.0]", "needs as_made.epicycloid_groove_angle"),
    ("epicycloid_plate_offset_um = [1.0]", "must be two numbers"),
    ("epicycloid_plate_offset_um = [1.0, 9000.0]", "check its unit"),
    ("ring_plate_tilt_rad = [1.0, 0.0]", "check its unit"),
    ("deceleration_ball_diameter_mm = [3.0, nan]", "list of finite numbers"),
    ("planet_ring = [0, 1]", "needs all of"),
]


@pytest.mark.parametrize(("line", "words"), LISTS)
def test_bad_lists_are_told(line: str, words: str) -> None:
    with pytest.raises(cbpt.CaseError) as told:
        cbpt.Case.from_toml(f"{BASE}\n[as_made]\n{line}\n")
    assert words in str(told.value)


def test_a_torsion_spring_has_no_such_parts() -> None:
    spring = "[torsion_spring]\ntorsional_stiffness_Nm_per_rad = 100\n"
    text = f"{spring}[as_made]\nring_plate_tilt_urad = [1, 0]\n"
    with pytest.raises(cbpt.CaseError, match="about a ball drive"):
        cbpt.Case.from_toml(text)


@pytest.mark.parametrize("noise", range(40))
def test_nothing_panics_on_broken_tables(tmp_path: Path, noise: int) -> None:
    """A table with bytes changed, cut or doubled is read or told."""
    generator = np.random.default_rng(noise)
    key, lines = [
        ("epicycloid_profile", profile(60)),
        ("deceleration_balls", balls()),
        ("facing_rings", rings()),
    ][noise % 3]
    text = bytearray("\n".join(lines).encode())
    for _ in range(int(generator.integers(1, 8))):
        place = int(generator.integers(len(text)))
        match generator.integers(3):
            case 0:
                text[place] = int(generator.integers(256))
            case 1:
                del text[place : place + int(generator.integers(200))]
            case _:
                text[place:place] = text[: int(generator.integers(200))]
    (tmp_path / "table.csv").write_bytes(bytes(text))
    (tmp_path / "case.toml").write_text(f'{BASE}\n[as_made]\n{key} = "table.csv"\n')
    try:
        cbpt.Case.from_file(tmp_path / "case.toml")
    except cbpt.CaseError as error:
        assert "table.csv" in str(error) or "as_made" in str(error)
