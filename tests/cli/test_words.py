"""What the `cbpt` command says: help, what a message tells to do, tables."""

from __future__ import annotations

from pathlib import Path

import pytest

import cbpt
from cbpt.cli import lab as verbs
from cbpt.cli import main as commands
from common.command_line import CASE, DATA, at_desk, compare, run

VERBS = ["solve", "preload", "sweep", "check", "schema", "compare"]


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A directory of its own with the example as case.toml."""
    return at_desk(tmp_path, monkeypatch)


# --- help ---------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [["--help"], ["-h"], ["help"]])
def test_help_lists_every_verb(arguments: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert commands.main(arguments) == 0
    said = capfd.readouterr()
    assert said.err == ""
    listed = [line.split()[0] for line in said.out.splitlines() if line.startswith("  ")]
    assert set(VERBS) <= set(listed)
    assert "Exit codes: 0 done, 1 cannot write, 2 bad input, 3 no solution" in said.out


def test_every_verb_has_help() -> None:
    for verb in VERBS:
        ran = run(verb, "--help")
        assert (ran.returncode, ran.stderr) == (0, ""), verb
        assert f"cbpt {verb}" in ran.stdout
        assert "--out" in ran.stdout


def test_the_version_is_that_of_the_package(capfd: pytest.CaptureFixture[str]) -> None:
    assert commands.main(["--version"]) == 0
    assert capfd.readouterr().out == f"cbpt {cbpt.__version__}\n"


# --- what a message tells to do -----------------------------------------------------------


def test_remedies_name_the_flag(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = desk / "t.csv"
    table.write_text("Moment's,preload_N,angle deg\n1,600,2\n")
    assert commands.main(["compare", "case.toml", str(table)]) == 2
    told = capsys.readouterr().err
    assert "columns=" not in told and "--column 'angle deg=elastic_angle_deg'" in told
    flags = ["--column", "Moment's=torque_Nm", "--column", "angle deg=elastic_angle_deg"]
    assert commands.main(["compare", "case.toml", str(table), *flags]) == 0
    capsys.readouterr()
    assert commands.main(["compare", "case.toml", str(table), "--column", "x=torque_Nm"]) == 2
    assert "'x' in --column" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("python", "flags"),
    [
        ("pass columns={'a': 'torque_Nm'} in", "pass --column a=torque_Nm in"),
        ("""columns={"it's": 'extra'};""", """--column 'it'"'"'s=extra';"""),
        ("as in sheet='Run 1', and", "as in --sheet 'Run 1', and"),
        (r"columns={'\x': 'y'}", r"columns={'\x': 'y'}"),  # part of a header, no text of Python
    ],
)
def test_python_said_in_flags(python: str, flags: str) -> None:
    assert verbs.in_flags(python) == flags


@pytest.mark.parametrize(
    ("flag", "near"), [("--colum", "--column"), ("--plto", "--plot"), ("--zzz", None)]
)
def test_a_misspelt_flag_names_the_nearest(
    flag: str, near: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    line = ["compare", str(CASE), str(DATA), flag + "x"]
    assert commands.main(line) == 2
    told = capsys.readouterr().err
    assert flag in told and (f"did you mean {near}?" in told) == (near is not None)


def test_a_sheet_is_chosen(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import xlsxwriter

    with xlsxwriter.Workbook(desk / "t.xlsx") as book:
        for name in ("Rig", "Run 1", "Run 2"):
            page = book.add_worksheet(name)
            if name != "Rig":
                page.write_row(0, 0, ["torque_Nm", "preload_N", "elastic_angle_arcsec"])
                page.write_row(1, 0, [1, 600, 2])
    assert commands.main(["compare", "case.toml", "t.xlsx", "--sheet", "Run 2"]) == 0
    assert "sheet 'Run 2'" in capsys.readouterr().out
    assert commands.main(["compare", "case.toml", "t.xlsx"]) == 0
    assert "'Run 2' may hold readings too (--sheet)" in capsys.readouterr().out
    assert commands.main(["compare", "case.toml", "t.xlsx", "--sheet", "Run 3"]) == 2
    assert "no sheet 'Run 3', expected one of 'Run 1', 'Run 2'" in capsys.readouterr().err


def test_readings_of_displacement(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = desk / "t.csv"
    table.write_text("torque_Nm,preload_N,sensor_displacement_mm,u_dh_um\n1,600,0.0012,0.1\n")
    assert commands.main(["compare", "case.toml", str(table)]) == 2
    assert "lever_arm_mm under [measurement] of the case" in capsys.readouterr().err
    with (desk / "case.toml").open("a") as case:
        case.write("\n[measurement]\nlever_arm_mm = 100\n")
    assert commands.main(["compare", "case.toml", str(table)]) == 0
    assert "with the lever arm of 100 mm" in capsys.readouterr().out


def test_tables_fit_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert compare() == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line[:1] in "│┌╞└"]
    assert len(lines) > 10 and max(map(len, lines)) <= 100


@pytest.mark.parametrize("effect", [[], ["friction_hysteresis"]])
def test_the_tables_of_effects_fit_a_terminal(effect: list[str]) -> None:
    lines = [line for line in run("effects", *effect).stdout.splitlines() if line[:1] in "│┌╞└"]
    assert len(lines) > 5 and max(map(len, lines)) <= 100
