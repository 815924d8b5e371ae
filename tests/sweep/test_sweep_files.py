"""Sweeps to files: plans in TOML, resuming after a kill, and what must not be written over."""

from __future__ import annotations

import json
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path

import pytest

import cbpt
from cbpt import PlanError, SweepPlan, sweep
from cbpt.cli.main import main
from cbpt.sweeps.files import open_output
from common.command_line import interrupted

Desk = Callable[..., Path]
GRID = """\
case = "case.toml"
[axes]
load.torque_Nm = { from = 0, to = 8, step = 0.5 }
load.preload_N = [400, 600]
"""
# New contact angles for every row: slow enough to be killed, some 0.5 s on one core.
SLOW = """\
case = "case.toml"
design = "latin_hypercube"
rows = 60000
seed = 5
[axes]
load.torque_Nm = { from = 0, to = 8 }
deceleration.contact_angle_deg = { from = 30, to = 60 }
equal_speed.ball_radius_mm = { from = 1, to = 2, scale = "log" }
"""


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Desk:
    """A directory with the example case, and plans put beside it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text(cbpt.example_case())

    def put(text: str, name: str = "plan.toml") -> Path:
        (tmp_path / name).write_text(text)
        return tmp_path

    return put


def command(out: str, *further: str) -> list[str]:
    return [sys.executable, "-m", "cbpt.cli.main", "sweep", "plan.toml", "--out", out, *further]


def written(folder: Path, name: str) -> int:
    """Bytes of a file and of what is kept beside it until it is whole."""
    found = 0
    for path in folder.rglob("*"):
        with suppress(FileNotFoundError):
            found += path.stat().st_size if name in str(path.relative_to(folder)) else 0
    return found


# --- killed and taken up ------------------------------------------------------------------


@pytest.mark.parametrize(("out", "kills"), [("result.csv", 4), ("result.parquet", 3)])
def test_a_sweep_killed_at_any_moment_ends_with_the_same(out: str, kills: int, desk: Desk) -> None:
    top = desk(SLOW)
    whole = f"whole{Path(out).suffix}"
    subprocess.run(command(whole, "--chunk-rows", "8192"), check=True, capture_output=True)
    size, moments, killed = written(top, whole), random.Random(11), 0
    for number in range(kills):
        goal = (number + moments.random()) / (kills + 1) * size
        with subprocess.Popen(
            command(out, "--chunk-rows", "8192"), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        ) as running:
            while running.poll() is None and written(top, out) <= goal:
                time.sleep(0.001)
            time.sleep(moments.uniform(0, 0.03) if number else 0)
            killed += running.poll() is None
            running.kill()
            assert running.communicate()[1] == b""
    assert killed >= 1
    subprocess.run(command(out), check=True, capture_output=True)
    if out.endswith(".csv"):
        assert (top / out).read_bytes() == (top / whole).read_bytes()
    else:
        from pyarrow import parquet

        one, other = (parquet.read_table(top / name) for name in (out, whole))
        assert one.equals(other) and one.num_rows == 60000
        assert not list(top.glob(".*.sweep")), "no part is left"


def test_a_finished_output_is_not_made_again(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    top = desk(GRID)
    for out in ("t.csv", "t.parquet"):
        assert main(["sweep", "plan.toml", "--out", out]) == 0
        before = (top / out).stat()
        assert main(["sweep", "plan.toml", "--out", out]) == 0
        assert (top / out).stat().st_mtime_ns == before.st_mtime_ns
    capsys.readouterr()


def test_ctrl_c_keeps_what_is_done(desk: Desk) -> None:
    top = desk(SLOW)
    for out in ("t.csv", "t.parquet"):

        def stop(done: int, total: int) -> None:
            if done >= 2 * 8192:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            sweep(top / "plan.toml", out=out, progress=stop, chunk_rows=8192)
        with closing(open_output(SweepPlan.from_file(top / "plan.toml"), Path(out), False)) as made:
            assert 8192 <= made.done < 60000


# --- what is there ------------------------------------------------------------------------


@pytest.mark.parametrize("out", ["t.csv", "t.parquet"])
def test_another_plan_is_refused_and_told_apart(
    out: str, desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    top = desk(GRID)
    assert main(["sweep", "plan.toml", "--out", out]) == 0
    before = (top / out).read_bytes()
    desk(GRID.replace("400, 600", "400, 601"))
    assert main(["sweep", "plan.toml", "--out", out]) == 2
    with pytest.raises(PlanError) as caught:
        sweep(top / "plan.toml", out=out)
    for words in ("another plan", "load.preload_N", "--out", "--fresh"):
        assert words in str(caught.value)
    assert "load.torque_Nm" not in str(caught.value)
    assert (top / out).read_bytes() == before
    assert main(["sweep", "plan.toml", "--out", out, "--fresh"]) == 0
    assert (top / out).read_bytes() != before
    capsys.readouterr()


def test_another_case_is_another_plan(desk: Desk) -> None:
    top = desk(GRID)
    sweep(top / "plan.toml", out="t.csv")
    (top / "case.toml").write_text(cbpt.example_case().replace("1.08", "1.07"))
    with pytest.raises(PlanError, match="differs in the case"):
        sweep(top / "plan.toml", out="t.csv")


@pytest.mark.parametrize("out", ["t.csv", "t.parquet"])
def test_a_file_that_is_no_sweep_is_not_written_over(out: str, desk: Desk) -> None:
    top = desk(GRID)
    (top / out).write_text("precious")
    with pytest.raises(PlanError, match="--fresh"):
        sweep(top / "plan.toml", out=out)
    assert (top / out).read_text() == "precious"
    sweep(top / "plan.toml", out=out, fresh=True)
    assert len((top / out).read_bytes()) > 100


def test_a_parquet_file_with_other_rows_is_not_taken_for_the_sweep(desk: Desk) -> None:
    from pyarrow import parquet

    top = desk(GRID)
    sweep(top / "plan.toml", out="t.parquet")
    with parquet.ParquetFile(top / "t.parquet") as file:
        table = file.read()
    parquet.write_table(table.slice(0, 5), top / "t.parquet")
    with pytest.raises(PlanError, match="the file has 5 rows, the plan 34"):
        sweep(top / "plan.toml", out="t.parquet")


def test_a_parquet_file_that_was_changed_is_not_taken_for_the_sweep(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    top = desk(GRID)
    assert main(["sweep", "plan.toml", "--out", "t.parquet"]) == 0
    file, beside = top / "t.parquet", top / "t.parquet.sweep"
    whole = file.read_bytes()
    file.write_bytes(whole[:300] + bytes([whole[300] ^ 1]) + whole[301:])
    capsys.readouterr()
    assert main(["sweep", "plan.toml", "--out", "t.parquet"]) == 2
    told = capsys.readouterr().err
    assert "t.parquet: its contents differ" in told and "--fresh" in told
    beside.unlink()
    assert main(["sweep", "plan.toml", "--out", "t.parquet"]) == 0
    assert "not checked, because t.parquet.sweep is missing" in capsys.readouterr().out
    with pytest.warns(UserWarning, match="not checked, because t.parquet.sweep is missing"):
        sweep(top / "plan.toml", out="t.parquet")
    beside.write_text("{}")
    assert main(["sweep", "plan.toml", "--out", "t.parquet"]) == 2
    assert main(["sweep", "plan.toml", "--out", "t.parquet", "--fresh"]) == 0
    capsys.readouterr()
    assert main(["sweep", "plan.toml", "--out", "t.parquet"]) == 0
    assert "not checked" not in capsys.readouterr().out


def test_parts_of_another_parquet_sweep_are_not_taken_for_the_sweep(desk: Desk) -> None:
    top = desk(SLOW)

    def stop(done: int, total: int) -> None:
        if done > 8192:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(top / "plan.toml", out="t.parquet", progress=stop, chunk_rows=8192)
    folder = top / ".t.parquet.sweep"
    parts = list(folder.glob("*.parquet"))
    assert parts
    (folder / "plan.json").unlink()
    desk(SLOW.replace("seed = 5", "seed = 6"))
    with pytest.raises(PlanError, match=r"0\.parquet: the file holds rows of another plan.*seed"):
        sweep(top / "plan.toml", out="t.parquet")
    assert list(folder.glob("*.parquet")) == parts
    assert not (folder / "plan.json").exists()
    desk(SLOW)
    parts[0].write_bytes(b"garbled")
    with pytest.raises(PlanError, match=r"0\.parquet: .* is not a sweep.*--fresh"):
        sweep(top / "plan.toml", out="t.parquet")


def begun(top: Path) -> tuple[bytes, Path, Path]:
    """A sweep stopped after its first chunk: what it should become, the file and its record."""
    whole = sweep(top / "plan.toml", out="whole.csv").path
    assert whole is not None

    def stop(done: int, total: int) -> None:
        if done > 8192:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(top / "plan.toml", out="t.csv", progress=stop, chunk_rows=8192)
    return whole.read_bytes(), top / "t.csv", top / "t.csv.sweep"


def test_half_a_chunk_beyond_the_record_is_cut_off(desk: Desk) -> None:
    top = desk(SLOW.replace("60000", "20000"))
    whole, file, record = begun(top)
    assert 0 < json.loads(record.read_text())["rows_done"] < 20000
    file.write_bytes(file.read_bytes() + b"1.5,garbled\xff\n3")
    sweep(top / "plan.toml", out=file)
    assert file.read_bytes() == whole


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda text: text[:-10], "bytes, its record says"),
        (lambda text: text[:-10] + b"9" * 10, "the rows differ from those of its record"),
        # In the first row, far from the end, at the same length.
        (
            lambda text: text.replace(b",ok\n", b",OK\n", 1),
            "the rows differ from those of its record",
        ),
    ],
)
def test_a_file_that_was_changed_is_not_gone_on_with(
    spoil: Callable[[bytes], bytes], told: str, desk: Desk
) -> None:
    top = desk(SLOW.replace("60000", "20000"))
    whole, file, _ = begun(top)
    file.write_bytes(spoil(file.read_bytes()))
    with pytest.raises(PlanError, match=told):
        sweep(top / "plan.toml", out=file)
    sweep(top / "plan.toml", out=file, fresh=True)
    assert file.read_bytes() == whole


def test_what_was_added_to_a_finished_file_is_not_cut_off(desk: Desk) -> None:
    top = desk(GRID)
    sweep(top / "plan.toml", out="t.csv")
    with (top / "t.csv").open("a") as file:
        file.write("# mine\n")
    with pytest.raises(PlanError, match=r"t\.csv: the file has 7 bytes after the rows.*--fresh"):
        sweep(top / "plan.toml", out="t.csv")
    assert (top / "t.csv").read_text().endswith("# mine\n")


def test_a_file_that_is_gone_is_told_and_none_is_left(desk: Desk) -> None:
    top = desk(GRID)
    sweep(top / "plan.toml", out="t.csv")
    whole = (top / "t.csv").read_bytes()
    (top / "t.csv").unlink()
    with pytest.raises(PlanError, match=r"t\.csv: the file is missing.*34 rows.*--fresh"):
        sweep(top / "plan.toml", out="t.csv")
    assert not (top / "t.csv").exists()
    sweep(top / "plan.toml", out="t.csv", fresh=True)
    assert (top / "t.csv").read_bytes() == whole


def test_a_garbled_record_is_told(desk: Desk) -> None:
    top = desk(GRID)
    sweep(top / "plan.toml", out="t.csv")
    (top / "t.csv.sweep").write_text("{")
    with pytest.raises(PlanError, match="is not a record of a sweep"):
        sweep(top / "plan.toml", out="t.csv")


def test_killed_before_the_first_record_it_begins(desk: Desk) -> None:
    top = desk(GRID)
    whole = sweep(top / "plan.toml", out="whole.csv").path
    assert whole is not None
    (top / "t.csv").touch()
    sweep(top / "plan.toml", out="t.csv")
    assert (top / "t.csv").read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("fresh", [False, True])
@pytest.mark.parametrize("out", ["t.csv", "t.parquet"])
def test_two_cannot_write_one_file(out: str, fresh: bool, desk: Desk) -> None:
    top = desk(GRID)
    with (
        closing(open_output(SweepPlan.from_file(top / "plan.toml"), top / out, False)),
        pytest.raises(PlanError, match="another process is writing this file"),
    ):
        sweep(top / "plan.toml", out=out, fresh=fresh)
    assert sweep(top / "plan.toml", out=out).has_solution.any()


def test_a_full_disk_is_told_and_the_sweep_goes_on_later(desk: Desk) -> None:
    top = desk(SLOW.replace("60000", "30000"))
    whole = sweep(top / "plan.toml", out="whole.csv").path
    assert whole is not None

    def small() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1_500_000, 1_500_000))

    made = subprocess.run(
        command("t.csv", "--chunk-rows", "8192"),
        capture_output=True,
        text=True,
        preexec_fn=small,
        restore_signals=False,
    )
    assert made.returncode == 1
    assert made.stderr.startswith("cbpt: cannot write t.csv: ")
    assert (top / "t.csv").stat().st_size > 8192
    sweep(top / "plan.toml", out="t.csv")
    assert (top / "t.csv").read_bytes() == whole.read_bytes()


def test_a_place_that_cannot_be_written_is_exit_code_1(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk(GRID)
    for out in ("no/such/t.csv", "no/such/t.parquet"):
        assert main(["sweep", "plan.toml", "--out", out]) == 1
    capsys.readouterr()


@pytest.mark.parametrize("out", ["rows.csv", "case.toml", "plan.toml"])
def test_what_a_plan_is_read_from_is_not_written_over(out: str, desk: Desk) -> None:
    top = desk('case = "case.toml"\ntable = "rows.csv"\n')
    (top / "rows.csv").write_text("load.torque_Nm\n1\n")
    before = (top / out).read_bytes()
    with pytest.raises(PlanError, match="would overwrite it"):
        sweep(top / "plan.toml", out=top / out, fresh=True)
    assert (top / out).read_bytes() == before


def test_numbers_that_clash_are_told(desk: Desk, capfd: pytest.CaptureFixture[str]) -> None:
    clash = 'equal_speed.kind = ["ring_groove", "cross_slide"]\n'
    plates = 'deceleration.output_plate = ["hypocycloid", "epicycloid"]\n'
    top = desk(GRID + clash + plates)
    told = []
    for out in ("t.csv", "t.parquet"):
        assert main(["sweep", "plan.toml", "--out", out]) == 0
        told.append(capfd.readouterr().err)
    assert told[0] == told[1]
    found = sweep(top / "plan.toml")
    wrong = (found.status == "invalid_input").nonzero()[0]
    why = found.plan.reason(int(wrong[0]))
    assert f"invalid_input: {len(wrong)} rows, for example row {wrong[0] + 1}: {why}" in told[0]
    assert found.plan.reason(int((found.status == "ok").nonzero()[0][0])) is None


def test_steps_that_do_not_meet_the_end_are_told(
    desk: Desk, capfd: pytest.CaptureFixture[str]
) -> None:
    top = desk(GRID.replace("step = 0.5", "step = 3"))
    for out in ("t.csv", "t.parquet"):
        assert main(["sweep", "plan.toml", "--out", out]) == 0
        told = capfd.readouterr().err
        assert told.startswith("cbpt: note: load.torque_Nm: the last value is 6, not 8, ")
    with pytest.warns(UserWarning, match="the last value is 6, not 8"):
        assert set(sweep(top / "plan.toml").axis("load.torque_Nm")) == {0, 3, 6}
    desk(GRID.replace("to = 8, step = 0.5", "to = 0.3, step = 0.1"))
    assert SweepPlan.from_file(top / "plan.toml").remarks == []


FAT = """\
case = "case.toml"
[axes]
load.torque_Nm = [1, 2]
equal_speed.ball_radius_mm = [1.5, 4, 12]
equal_speed.ball_count = [14, 60]
"""


def test_drives_that_cannot_be_built_are_told(
    desk: Desk, capfd: pytest.CaptureFixture[str]
) -> None:
    top = desk(FAT)
    told, found = [], []
    for out in ("t.csv", "t.parquet"):
        assert main(["sweep", "plan.toml", "--out", out]) == 0
        told.append(capfd.readouterr().err)
        found.append(sweep(top / "plan.toml", out=out))
    assert told[0] == told[1]
    assert list(found[0].finding) == list(found[1].finding)
    wrong = (found[0].finding != "").nonzero()[0]
    assert 0 < len(wrong) < len(found[0])
    assert f"of 12 rows solved now, {len(wrong)} have a drive that cannot be built" in told[0]
    assert (
        f" rows, for example row {wrong[0] + 1}: {found[0].plan.finding(int(wrong[0]))}" in told[0]
    )


def test_one_drive_that_cannot_be_built_is_told_before(
    desk: Desk, capfd: pytest.CaptureFixture[str]
) -> None:
    top = desk(GRID)
    (top / "case.toml").write_text(
        cbpt.example_case().replace("ball_radius_mm = 1.5", "ball_radius_mm = 12")
    )
    for out in ("t.csv", "t.parquet"):
        assert main(["sweep", "plan.toml", "--out", out]) == 0
        told = capfd.readouterr().err
        assert told.startswith("cbpt: warning: the drive of the case cannot be built (")
    assert "finding" not in (top / "t.csv").read_text().splitlines()[0]
    with pytest.warns(UserWarning, match="cannot be built"):
        found = sweep(top / "plan.toml")
    assert set(found.finding) == {""}


def once(path: Path) -> Callable[[int], bool]:
    """Whether a command works, as may be seen of a file."""
    return lambda _: path.exists()


def test_ctrl_c_ends_with_one_line(desk: Desk) -> None:
    top = desk(SLOW.replace("60000", "60000000"))
    for out, begun in (("t.csv", "t.csv.sweep"), ("t.parquet", ".t.parquet.sweep/plan.json")):
        found = interrupted(command(out), once(top / begun))
        assert found == (130, "cbpt: interrupted\n")


def test_ctrl_c_that_does_not_wake_who_waits(desk: Desk) -> None:
    """As one that comes just before the wait begins: here another thread takes the signal."""
    top = desk(SLOW.replace("60000", "60000000"))
    script = (
        "import signal, sys, threading\n"
        "threading.Thread(target=threading.Event().wait, daemon=True).start()\n"
        "signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})\n"
        "from cbpt.cli.main import main\n"
        "sys.exit(main(['sweep', 'plan.toml', '--out', 't.csv']))\n"
    )
    found = interrupted([sys.executable, "-c", script], once(top / "t.csv.sweep"))
    assert found == (130, "cbpt: interrupted\n")


# --- plans in TOML ------------------------------------------------------------------------


def test_a_table_beside_the_plan(desk: Desk) -> None:
    top = desk('case = "case.toml"\ntable = "rows.csv"\n')
    table = "load.torque_Nm,deceleration.output_plate\n1,hypocycloid\n2,epicycloid\n"
    (top / "rows.csv").write_text("\ufeff" + table)
    found = sweep(top / "plan.toml", out="t.csv")
    assert (top / "t.csv").read_text().splitlines()[1].startswith("1.0,hypocycloid,")
    assert list(found.axis("deceleration.output_plate")) == ["hypocycloid", "epicycloid"]
    for text, told in [
        (table.replace("2,", "two,"), r"rows\.csv:3: load\.torque_Nm = \"two\""),
        (table.replace("torque_Nm", "torque_Nmm,x"), "rows.csv"),
        (table.replace("epi", "api"), r"rows\.csv:3: .*did you mean epicycloid"),
        (table.replace(",", ";"), r"rows\.csv: the columns are separated by ';'; .* commas"),
        (table.splitlines()[0], "has no rows"),
        (table.replace("load.torque_Nm", "torque"), r"rows\.csv:1: "),
    ]:
        (top / "rows.csv").write_text(text)
        with pytest.raises(PlanError, match=told):
            sweep(top / "plan.toml")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            GRID.replace("step = 0.5", ""),
            "plan.toml:3: load.torque_Nm: no range; give the number of values",
        ),
        (GRID.replace("step = 0.5", "steps = 2"), "did you mean step?"),
        (GRID.replace("step = 0.5", "step = -1"), "must lead from one end to the other"),
        (GRID.replace("step = 0.5", "count = 1"), "count must be 2 or more"),
        # By the name that plans of runs have for it, too.
        (GRID.replace("step = 0.5", "points = 1"), "count must be 2 or more"),
        (GRID.replace("step = 0.5", "points = 5, count = 5"), "give one of them"),
        (GRID.replace("from = 0, ", ""), "needs both from and to"),
        (GRID.replace("preload_N", "preload"), "plan.toml:4: load.preload: the key needs a unit"),
        (GRID.replace("[400, 600]", "[400, -600]"), "plan.toml:4: load.preload_N = -600"),
        (GRID.replace("[400, 600]", '[400, "x"]'), "a list of numbers only"),
        (GRID.replace("[400, 600]", "true"), "expected a number, a list, or a range"),
        ("seeds = 1\n" + GRID, "plan.toml:1: seeds: unknown key; did you mean seed?"),
        ('design = "girds"\n' + GRID, "did you mean grid?"),
        ('design = "random"\n' + GRID, "rows: missing"),
        ("rows = 5\n" + GRID, "rows: the axes of a grid fix the number of rows"),
        ("rows = -5\n" + GRID, "expected a whole number"),
        ('table = "rows.csv"\n' + GRID, "leave [axes] out"),
        (GRID.split("[axes]")[0], "name what varies"),
        (GRID.split("\n", 1)[1], "name the case file"),
        (GRID.replace("case.toml", "cases.toml"), "cases.toml: file not found"),
        (GRID + "load.torque_Nmm = 5\n", "plan.toml:5: load.torque_Nmm: sets the same value"),
        (GRID + "oops", "not valid TOML"),
    ],
)
def test_a_wrong_plan_is_told_with_its_line(text: str, told: str, desk: Desk) -> None:
    desk(text)
    with pytest.raises(PlanError) as caught:
        SweepPlan.from_file(Path("plan.toml"))
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        (["plan.toml"], "--out is missing"),
        (["plan.toml", "--out", "t.xlsx"], "must end in .csv or .parquet"),
        (["plan.toml", "--out", "t.csv", "--torque-Nm", "5"], "the axis load.torque_Nm"),
        (["plan.toml", "--out", "t.csv", "--json"], "--json is for cases"),
        (["plan.toml", "--out", "t.csv", "--angle-unit", "deg"], "--angle-unit deg"),
        (["case.toml", "--fresh"], "are for plans"),
        (["case.toml", "--torque-Nm", "1,2", "--out", "t.parquet"], "case.toml is a case"),
        (["none.toml", "--out", "t.parquet"], "none.toml: file not found"),
    ],
)
def test_flags_that_do_not_go_together_are_told(flags: list[str], told: str, desk: Desk) -> None:
    desk(GRID)
    done = subprocess.run(
        [sys.executable, "-m", "cbpt.cli.main", "sweep", *flags], capture_output=True, text=True
    )
    assert done.returncode == 2
    assert told in done.stderr
