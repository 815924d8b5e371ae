"""What the `cbpt` command says: help, what a message tells to do, tables."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

import cbpt
from cbpt.cli import main as commands
from cbpt.cli.options import in_flags
from cbpt.errors import (
    ChooseSheet,
    ReadingsError,
    Setting,
    Step,
    TakeColumn,
    Words,
    said,
    told,
)
from cbpt.page.workbench.uploads import on_page
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
    shown = capfd.readouterr()
    assert shown.err == ""
    listed = [line.split()[0] for line in shown.out.splitlines() if line.startswith("  ")]
    assert set(VERBS) <= set(listed)
    assert "Exit codes: 0 done, 1 cannot write, 2 bad input, 3 no solution" in shown.out


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
    message = capsys.readouterr().err
    assert "columns=" not in message and "--column 'angle deg=elastic_angle_deg'" in message
    flags = ["--column", "Moment's=torque_Nm", "--column", "angle deg=elastic_angle_deg"]
    assert commands.main(["compare", "case.toml", str(table), *flags]) == 0
    capsys.readouterr()
    assert commands.main(["compare", "case.toml", str(table), "--column", "x=torque_Nm"]) == 2
    assert "'x' in --column" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("step", "python", "flags", "page"),
    [
        (
            TakeColumn("a b", "torque_Nm"),
            "pass columns={'a b': 'torque_Nm'}",
            "give --column 'a b=torque_Nm'",
            "take 'a b' as 'torque_Nm'",
        ),
        (
            TakeColumn("it's", "extra"),
            """pass columns={"it's": 'extra'}""",
            """give --column 'it'"'"'s=extra'""",
            """take "it's" as 'extra'""",
        ),
        (
            ChooseSheet("Run 1"),
            "pass sheet='Run 1'",
            "give --sheet 'Run 1'",
            "choose the sheet 'Run 1'",
        ),
        (Setting("columns"), "`columns`", "--column", "the columns"),
    ],
)
def test_each_front_end_says_a_step_in_its_own_way(
    step: Step, python: str, flags: str, page: str
) -> None:
    text = Words("first ", Words(step, ", then measure"))
    assert text == f"first {python}, then measure" and text.steps == (step,)
    assert said(text, in_flags) == f"first {flags}, then measure"
    assert said(text, on_page) == f"first {page}, then measure"
    again = pickle.loads(pickle.dumps(text))
    assert again == text and again.parts == text.parts


def test_a_header_that_reads_like_python_stays_as_it_is(tmp_path: Path) -> None:
    """Steps are known by what they are, not by how they read."""
    header = "columns={'a': 'b'}"
    (tmp_path / "t.csv").write_text(f"{header};torque_Nm\n1;2\n", encoding="utf-8")
    with pytest.raises(ReadingsError) as refused:
        cbpt.read_readings(tmp_path / "t.csv")
    assert repr(header) in told(refused.value, in_flags)
    steps = [step for m in refused.value.mistakes for step in getattr(m.remedy, "steps", ())]
    assert TakeColumn("your header", "elastic_angle_arcsec") in steps


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
    assert "'Run 2' may hold readings too (--sheet chooses another)" in capsys.readouterr().out
    assert commands.main(["compare", "case.toml", "t.xlsx", "--sheet", "Run 3"]) == 2
    assert "no sheet 'Run 3', expected one of 'Run 1', 'Run 2'" in capsys.readouterr().err


def test_readings_of_displacement(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = desk / "t.csv"
    table.write_text("torque_Nm,preload_N,sensor_displacement_mm,u_dh_um\n1,600,0.0012,0.1\n")
    assert commands.main(["compare", "case.toml", str(table)]) == 2
    assert "lever_arm_mm under [measurement] in the case" in capsys.readouterr().err
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


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["fit", "--with", "creep", "a.toml", "b.csv"], "a.toml and b.csv went to --with"),
        (["diagnose", "a.toml", "b.csv", "--json", "answer"], "a file after --json ends in .json"),
        (["fit", "--with", "creep"], "required: CASE, DATA"),
    ],
)
def test_words_that_argparse_took_otherwise_are_explained(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert commands.main(words) == 2
    assert told in capsys.readouterr().err
