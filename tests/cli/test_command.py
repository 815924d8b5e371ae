"""The `cbpt` command of the package, as installed and through `cbpt.cli.main.main`.

Groups: the verbs of the mechanics, which are those of the plain binary; compare as text, JSON,
table and picture; what is refused and with which exit code; pipes and full disks; inputs and
Ctrl-C. Help and what messages tell to do are in test_cli_words.

What the verbs of the mechanics answer is tested with the binary, in
crates/cbpt-cli/tests/command_line; here it must only be the same.
"""

from __future__ import annotations

import csv
import importlib.util
import json
import os
import signal
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.cli import main as commands
from cbpt.cli.options import Counter
from common.command_line import CASE, COMMAND, DATA, at_desk, compare, interrupted, run

TOP = Path(__file__).parents[2]
DRAWS = pytest.mark.skipif(
    importlib.util.find_spec("matplotlib") is None, reason="matplotlib is an extra"
)


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A directory of its own with the example as case.toml."""
    return at_desk(tmp_path, monkeypatch)


def at_work(pid: int) -> bool:
    """Whether a process has had processor time enough, whatever the machine does beside it."""
    stat = Path(f"/proc/{pid}/stat").read_text()
    ticks = sum(map(int, stat.rsplit(")", 1)[1].split()[11:13]))
    return ticks >= 1.5 * os.sysconf("SC_CLK_TCK")


def code_of(arguments: list[str]) -> Any:
    """The exit code of a command line in this process, however it ends."""
    try:
        return commands.main(arguments)
    except SystemExit as ended:
        return ended.code


def strictly(text: str) -> Any:
    """JSON as every reader takes it: NaN and Infinity are none."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)


# --- verbs of the mechanics ---------------------------------------------------------------


def binary() -> Path:
    """The plain binary, if cargo has built it from these sources."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", TOP / "target"))
    name = "cbpt.exe" if os.name == "nt" else "cbpt"
    sources = [
        path
        for crate in ("cbpt-core", "cbpt-cli")
        for path in (TOP / "crates" / crate / "src").rglob("*")
        if path.is_file() and "tests" not in path.parts[len(TOP.parts) :]  # not part of the binary
    ]
    newest = max(path.stat().st_mtime for path in sources)
    module = importlib.util.find_spec("cbpt._core")
    assert module is not None and module.origin is not None
    for path in (target / "debug" / name, target / "release" / name):
        if (
            path.exists()
            and min(path.stat().st_mtime, Path(module.origin).stat().st_mtime) > newest
        ):
            return path
    pytest.skip("cargo has not built the binary from these sources")


@pytest.mark.parametrize(
    "line",
    [
        "solve case.toml",
        "solve case.toml --json --angle-unit mrad --force-unit kN --input-angle-deg -12.5",
        "solve case.toml --torque-Nm 50 --json",
        "solve case.toml --points --over-period",
        "preload case.toml --torque-Nm -5",
        "preload case.toml --json",
        "sweep case.toml --torque-Nm -1:8:0.5 --preload-N 200,600",
        "sweep case.toml --torque-Nm 500 --json",
        "check case.toml --preload-N 1e5",
        "schema",
        "schema --keys",
        "schema --example",
        "--help",
        "sweep --help",
        "--version",
        "solve case.toml --preload-N 0",
        "solve case.toml --torque 5",
        "solve missing.toml",
        "sweep case.toml --torque-Nm 0:1",
        "slove",
        "",
    ],
)
def test_the_wheel_answers_like_the_binary(line: str, capfd: pytest.CaptureFixture[str]) -> None:
    code = commands.main(line.split())
    ours = capfd.readouterr()
    theirs = subprocess.run(
        [binary(), *line.split()], capture_output=True, text=True, encoding="utf-8", check=False
    )
    assert (ours.out, ours.err, code) == (theirs.stdout, theirs.stderr, theirs.returncode)


def test_the_module_is_the_command(desk: Path) -> None:
    line = [sys.executable, "-m", "cbpt", "solve", "case.toml"]
    module = subprocess.run(line, capture_output=True, text=True, check=True)
    assert module.stdout == run("solve", "case.toml").stdout


def test_the_installed_command_is_the_same() -> None:
    ran = run("solve", "case.toml", "--json")
    solution = cbpt.Drive.from_file("case.toml").solve(torque_Nm=5, preload_N=600)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert json.loads(ran.stdout) == json.loads(solution.to_json())
    module = subprocess.run(
        [sys.executable, "-m", "cbpt.cli.main", "solve", "case.toml", "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert module.stdout == ran.stdout


def test_a_verb_answers_like_the_object(capfd: pytest.CaptureFixture[str]) -> None:
    drive = cbpt.Drive.from_file("case.toml")
    solution = drive.solve(torque_Nm=7, preload_N=500, input_angle_deg=20)
    load = ["--torque-Nm", "7", "--preload-N", "500", "--input-angle-deg", "20"]
    assert commands.main(["solve", "case.toml", *load, "--json"]) == 0
    assert json.loads(capfd.readouterr().out) == json.loads(solution.to_json())
    assert commands.main(["solve", "case.toml", *load]) == 0
    assert capfd.readouterr().out.rstrip() == repr(solution)
    assert commands.main(["preload", "case.toml", "--torque-Nm", "7"]) == 0
    assert capfd.readouterr().out.rstrip() == repr(drive.preload(torque_Nm=7))


def test_the_promised_keys(capfd: pytest.CaptureFixture[str]) -> None:
    line = "solve case.toml --torque-Nm 5 --preload-N 600 --input-angle-deg 0 --json"
    assert commands.main(line.split()) == 0
    solved = strictly(capfd.readouterr().out)
    assert solved["status"] == "ok" and solved["residual"] <= 1e-11
    assert solved["elastic_angle_arcsec"] == pytest.approx(12.46045490, abs=1e-8)
    assert solved["alpha_deceleration_arcsec"] == pytest.approx(5.159034343406146, rel=1e-10)
    assert solved["alpha_equal_speed_arcsec"] == pytest.approx(7.301420557567914, rel=1e-10)
    assert commands.main(["preload", "case.toml", "--torque-Nm", "5", "--json"]) == 0
    needed = strictly(capfd.readouterr().out)
    for pair in ("deceleration", "equal_speed", "drive"):
        assert list(needed[pair]) == ["hold_N", "continuous_N", "zero_backlash_N"]
    assert needed["deceleration"]["continuous_N"] == pytest.approx(145.0457, abs=1e-4)
    assert needed["equal_speed"]["continuous_N"] == pytest.approx(152.4597, abs=1e-4)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("solve case.toml", 0),
        ("solve case.toml --out no/such/place.json", 1),
        ("solve missing.toml", 2),
        ("solve case.toml --torque-Nm 50", 3),
        ("sweep case.toml --torque-Nm 500,600", 3),
        ("check undercut.toml", 4),
    ],
)
def test_exit_codes_are_those_of_the_help(line: str, code: int, desk: Path) -> None:
    undercut = cbpt.example_case().replace("ball_radius_mm = 1.5", "ball_radius_mm = 20", 1)
    (desk / "undercut.toml").write_text(undercut)
    assert commands.main(line.split()) == code


def test_ctrl_c_while_modules_load_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "numpy.py").write_text("raise KeyboardInterrupt\n")
    done = subprocess.run(
        [sys.executable, "-m", "cbpt.cli.main", "--version"],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (130, "cbpt: interrupted\n")


def test_signals_are_as_they_were() -> None:

    before = signal.getsignal(signal.SIGINT)
    assert commands.main(["check", "case.toml"]) == 0
    assert signal.getsignal(signal.SIGINT) is before


# --- compare ------------------------------------------------------------------------------


def test_compare_prints_the_report(capsys: pytest.CaptureFixture[str]) -> None:
    assert compare() == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out == cbpt.compare(CASE, DATA).report() + "\n"
    assert said.out == run("compare", CASE, DATA).stdout
    for part in ("396 readings", "RMSE 2.48 arcsec", "preload_N 420", "direction rising"):
        assert part in said.out


def test_a_column_may_have_several_values(capsys: pytest.CaptureFixture[str]) -> None:
    """The last value won without a word; then one value a column was all that could be asked."""
    assert compare("--only", "run=1", "--only", "run=2", "--only", "preload_N=420") == 0
    report = capsys.readouterr().out
    assert "readings are used, those with run = 1 or 2, preload_N = 420" in report
    assert compare("--only", "run=1", "--only", "run=no") == 2
    assert "readings with run = no" in capsys.readouterr().err


def test_compare_prints_one_json_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("--json") == 0
    document = strictly(capsys.readouterr().out)
    assert document == cbpt.compare(CASE, DATA).to_dict()
    assert document["overall"]["readings"] == 396
    assert document["overall"]["rmse_arcsec"] == pytest.approx(2.4839, abs=1e-4)


def test_compare_writes_every_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert compare("--out", "rows.csv") == 0
    assert capsys.readouterr().out == cbpt.compare(CASE, DATA).report() + "\n"
    with Path("rows.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    table = np.loadtxt(DATA, delimiter=",", skiprows=1)
    assert [float(row["elastic_angle_arcsec"]) for row in rows] == table[:, 6].tolist()
    assert [int(row["line"]) for row in rows] == list(range(2, 398))
    for row in rows:
        left = float(row["elastic_angle_arcsec"]) - float(row["model_elastic_angle_arcsec"])
        assert float(row["residual_arcsec"]) == left
        assert row["status"] == "ok"
    assert compare("--out", "answer.JSON") == 0
    assert strictly(Path("answer.JSON").read_text()) == cbpt.compare(CASE, DATA).to_dict()


def test_what_compare_writes_can_be_compared_again() -> None:
    assert compare("--out", "rows.csv") == 0
    again = cbpt.compare(CASE, "rows.csv")
    expected = cbpt.compare(CASE, DATA)
    np.testing.assert_array_equal(again.residual_arcsec, expected.residual_arcsec)


def test_a_table_that_is_written_has_the_unit_of_choice() -> None:
    assert compare("--out", "rows.csv", "--angle-unit", "mrad") == 0
    with Path("rows.csv").open(newline="", encoding="utf-8") as file:
        head = next(csv.reader(file))
    assert [name for name in head if "arcsec" in name] == []
    assert {"elastic_angle_mrad", "model_elastic_angle_mrad", "residual_mrad"} <= set(head)
    again, expected = cbpt.compare(CASE, "rows.csv"), cbpt.compare(CASE, DATA)
    np.testing.assert_allclose(again.residual_arcsec, expected.residual_arcsec, atol=1e-9)


@DRAWS
def test_the_same_picture_is_the_same_file(desk: Path) -> None:
    assert compare("--plot", "one.svg") == 0
    assert compare("--plot", "two.svg") == 0
    other = desk / "elsewhere"
    other.mkdir()
    assert run("compare", CASE, DATA, "--plot", "three.svg", cwd=other).returncode == 0
    picture = Path("one.svg").read_bytes()
    assert picture == Path("two.svg").read_bytes() == (other / "three.svg").read_bytes()
    root = xml.etree.ElementTree.fromstring(picture)
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert compare("--plot", "mrad.svg", "--angle-unit", "mrad") == 0
    assert Path("mrad.svg").read_bytes() != picture


@DRAWS
@pytest.mark.parametrize(
    ("name", "begin"), [("a.png", b"\x89PNG"), ("a.pdf", b"%PDF"), ("a.SVG", b"<?xml")]
)
def test_a_picture_is_what_its_name_says(name: str, begin: bytes) -> None:
    assert compare("--plot", name) == 0
    assert Path(name).read_bytes().startswith(begin)


@DRAWS
def test_friction_with_a_picture_answers_as_without_one(capfd: pytest.CaptureFixture[str]) -> None:
    loads = ["--torque-Nm", "4", "--coefficient", "0.08", "--static-safety", "1.5"]
    said = []
    for also in ([], ["--plot", "window.svg"]):
        answer = [["--json", "--out", "a.csv"], ["--out", "a.json"]]
        for flags in answer:
            assert commands.main(["friction", "case.toml", *loads, *flags, *also]) == 0
            said.append(capfd.readouterr().out.splitlines())
        said.append([Path(name).read_text(encoding="utf-8") for name in ("a.csv", "a.json")])
    alone, drawn = said[:3], said[3:]
    assert json.loads("\n".join(alone[0])) == json.loads("\n".join(drawn[0]))
    assert alone[1][:-1] == drawn[1][:-1]
    assert alone[2][0] == drawn[2][0] and json.loads(alone[2][1]) == json.loads(drawn[2][1])
    assert Path("window.svg").read_bytes().startswith(b"<?xml")


@DRAWS
def test_friction_draws_which_preload_would_hold_a_load_that_slips() -> None:
    assert commands.main(["friction", "case.toml", "--preload-N", "5", "--plot", "a.svg"]) == 3
    assert Path("a.svg").stat().st_size > 1000


def test_the_picture_of_friction_overwrites_no_case_and_has_its_help(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert code_of(["friction", "case.toml", "--plot", "case.toml"]) == 2
    assert "overwrite" in capsys.readouterr().err
    assert code_of(["help", "friction"]) == 0
    assert "--plot FILE" in capsys.readouterr().out


def test_without_matplotlib_drawing_says_what_to_install() -> None:
    # None stands for a module that cannot be imported.
    program = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from cbpt.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", program, "compare", str(CASE), str(DATA)]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    drawn = subprocess.run(
        [*command, "--plot", "a.svg"], capture_output=True, text=True, check=False
    )
    assert drawn.returncode == 2
    assert 'pip install "cbpt[plot]"' in drawn.stderr and "Traceback" not in drawn.stderr
    assert not Path("a.svg").exists()


@pytest.mark.parametrize("unit", ["arcsec", "arcmin", "deg", "urad", "mrad", "rad"])
def test_compare_says_angles_in_the_unit_asked_for(
    unit: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare("--angle-unit", unit) == 0
    out = capsys.readouterr().out
    assert out == cbpt.compare(CASE, DATA).report(unit) + "\n"
    # A wide table breaks its headings.
    header = next(line for line in out.splitlines() if "chi2/" in line)
    assert (
        header.count("┆") and out.splitlines()[out.splitlines().index(header) + 1].count(unit) == 4
    )


def test_compare_is_told_what_headers_mean(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = DATA.read_text()
    (desk / "odd.csv").write_text(
        text.replace("torque_Nm", "Brake").replace("preload_N", "Spring = F", 1)
    )
    named = ["--column", "Brake=torque_Nm", "--column", "Spring = F=preload_N"]
    assert commands.main(["compare", str(CASE), "odd.csv", *named]) == 0
    assert "RMSE 2.48 arcsec" in capsys.readouterr().out
    assert commands.main(["compare", str(CASE), "odd.csv"]) == 2
    said = capsys.readouterr()
    assert said.out == "" and "torque_Nm" in said.err and "preload_N" in said.err


def test_readings_without_any_solution_are_exit_code_3(
    desk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = ["torque_Nm,preload_N,elastic_angle_arcsec", "400,600,5", "500,600,7"]
    (desk / "strong.csv").write_text("\n".join(rows))
    assert commands.main(["compare", "case.toml", "strong.csv"]) == 3
    assert "beyond_hold" in capsys.readouterr().out
    assert commands.main(["compare", "case.toml", "strong.csv", "--json"]) == 3
    document = strictly(capsys.readouterr().out)
    assert document["overall"] is None
    assert document["without_solution"] == {"beyond_hold": [2, 3]}


def test_paths_may_hold_blanks_and_any_letters(desk: Path) -> None:
    folder = desk / "Prüfstand 3 β"
    folder.mkdir()
    (folder / "Δ case.toml").write_bytes(CASE.read_bytes())
    (folder / "данные.csv").write_bytes(DATA.read_bytes())
    ran = run(
        *("compare", folder / "Δ case.toml", folder / "данные.csv", "--out", folder / "ω.csv"),
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
    )
    assert (ran.returncode, ran.stderr) == (0, "")
    assert "данные.csv" in ran.stdout and (folder / "ω.csv").exists()


# --- what is refused ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["missing.toml", DATA], ["missing.toml", "not found"]),
        ([CASE, "missing.csv"], ["missing.csv", "no such file"]),
        ([CASE, "."], ["directory"]),
        ([CASE, "empty.csv"], ["empty.csv", "an empty file"]),
        ([CASE, "wrong.csv"], ["wrong.csv", "line 3", "torque_Nm", "'five'"]),
        (["wrong.toml", DATA], ["wrong.toml", "ball_cuont", "ball_count"]),
        (["effect.toml", DATA], ["effect.toml", "k_Nm_per_rad", "compliance_arcsec_per_Nm"]),
        ([CASE], ["DATA"]),
        ([], ["CASE"]),
        ([CASE, DATA, "--out", "answer.xlsx"], ["answer.xlsx", ".csv or .json"]),
        ([CASE, DATA, "--out", "answer"], ["answer", ".csv or .json"]),
        ([CASE, DATA, "--plot", "picture.bmp"], ["picture.bmp", ".svg", ".png"]),
        ([CASE, DATA, "--angle-unit", "grad"], ["grad", "arcsec"]),
        ([CASE, DATA, "--column", "Moment"], ["Moment", "HEADER=NAME"]),
        ([CASE, DATA, "--column", "Moment=torque_Nm"], ["Moment"]),
        ([CASE, DATA, "--nothing"], ["--nothing"]),
    ],
)
def test_bad_input_is_exit_code_2(
    arguments: list[str | Path], words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    example = cbpt.example_case()
    Path("empty.csv").write_text("")
    Path("wrong.csv").write_text("torque_Nm,preload_N,elastic_angle_arcsec\n1,2,3\nfive,2,3\n")
    Path("wrong.toml").write_text(example.replace("ball_count", "ball_cuont", 1))
    Path("effect.toml").write_text(
        f'{example}[[effect]]\nid = "output_torsion"\nk_Nm_per_rad = 1\n'
    )
    assert code_of(["compare", *map(str, arguments)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    for word in words:
        assert word in said.err
    assert not Path("answer.xlsx").exists() and not Path("picture.bmp").exists()


@pytest.mark.parametrize("flag", ["--out", pytest.param("--plot", marks=DRAWS)])
def test_a_file_that_cannot_be_written_is_exit_code_1(
    flag: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name = "no/such/place/answer" + {"--out": ".csv", "--plot": ".svg"}[flag]
    assert compare(flag, name) == 1
    said = capsys.readouterr()
    assert said.err.startswith("cbpt: ") and name in said.err


def test_ctrl_c_is_exit_code_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import cbpt.lab.diagnosis.compare

    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cbpt.lab.diagnosis.compare, "solve_many", interrupted)
    assert compare() == 130
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "cbpt: interrupted\n")


def test_long_work_shows_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a terminal, after a second, and the line is wiped in the end."""
    with Counter() as counter:
        monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
        counter.show(100, 396)
        assert capsys.readouterr().err == ""
        counter.start -= 2
        counter.show(200, 396)
        assert capsys.readouterr().err == "\r\x1b[K200/396 readings solved "
        counter.share("pairs of effects", 0.6)
        assert capsys.readouterr().err == "\r\x1b[K60% done, next: pairs of effects "
    assert capsys.readouterr().err == "\r\x1b[K"


def test_long_work_into_a_file_tells_that_it_goes_on(capsys: pytest.CaptureFixture[str]) -> None:
    """A comparison of fourteen levels was silent for minutes; a line each half a minute."""
    with Counter() as counter:
        counter.share("pairs of effects", 0.2)
        assert capsys.readouterr().err == ""
        counter.start -= 40
        counter.told -= 40
        counter.share("pairs of effects", 0.6)
        counter.share("pairs of effects", 0.7)
    assert capsys.readouterr().err == "after 40 s: 60% done, next: pairs of effects\n"


# --- pipes --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ["sweep", "case.toml", "--torque-Nm", "0:5:0.001", "--json"],
        ["compare", CASE, DATA, "--json"],
        ["compare", CASE, DATA],
    ],
    ids=["sweep", "compare as JSON", "compare"],
)
def test_a_reader_that_leaves_early_is_no_failure(arguments: list[str | Path]) -> None:
    command = [str(COMMAND), *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("verb", ["solve", "compare"])
def test_a_full_disk_behind_standard_output_is_exit_code_1(verb: str) -> None:
    arguments = ["case.toml"] if verb == "solve" else [str(CASE), str(DATA), "--json"]
    with Path("/dev/full").open("w") as full:
        ran = run(verb, *arguments, stdout=full)
    assert ran.returncode == 1
    assert ran.stderr.startswith("cbpt: ") and "Traceback" not in ran.stderr


# --- inputs and Ctrl-C --------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    [
        "compare {case} {data} --out {data}",
        "diagnose {case} {data} --results {data}",
        "fit {case} {data} --with zero_offset --out {case}",
        "fit {case} {data} --with zero_offset --results {data}",
        "simulate {case} {data} --out {data}",
        "report {case} {data} --out {data}",
        "next-run {case} {data} --out {case}",
        "plan {case} --separate zero_offset --u-arcsec 1 --out {case}",
        "tolerance {case} --json {case}",
        "tolerance {case} --plot {case}",
        "optimise {case} {data} --out {case}",
        "optimise {case} {data} --out {data}",
        "transmission {case} --plot {case}",
    ],
)
def test_no_verb_writes_over_what_it_reads(
    line: str, desk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here, data = desk / "case.toml", desk / "data.csv"
    data.write_text("precious")
    case = here.read_text()
    # By another way to the same file.
    words = line.format(case="case.toml", data="data.csv").split()
    words[-1] = str(desk / words[-1])
    assert commands.main(words) == 2
    assert "would overwrite it" in capsys.readouterr().err
    assert (here.read_text(), data.read_text()) == (case, "precious")


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads processor time in /proc")
@pytest.mark.parametrize(
    "line", ["tolerance toleranced.toml --samples 10000000", "optimise case.toml bounds.toml"]
)
def test_ctrl_c_ends_with_one_line(line: str, desk: Path) -> None:
    (desk / "toleranced.toml").write_text((TOP / "examples/toleranced.toml").read_text())
    (desk / "bounds.toml").write_text((TOP / "examples/bounds.toml").read_text())
    assert interrupted([str(COMMAND), *line.split()], at_work) == (130, "cbpt: interrupted\n")
