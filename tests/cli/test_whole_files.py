"""What is written is whole or not there, whoever writes it and whatever fails.

Groups: the routine; verbs; the files of sweeps; what a killed workbench leaves.
"""

from __future__ import annotations

import errno
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

import cbpt
from cbpt.page.workbench import scratch
from cbpt.page.workbench.scratch import Scratch
from cbpt.sweeps.files import open_output
from cbpt.whole_files import whole, write_whole
from common import PATIENCE_S

TOP = Path(__file__).parents[2]
EXAMPLES = TOP / "examples"
POSIX = pytest.mark.skipif(os.name != "posix", reason="of POSIX")

# --- the routine --------------------------------------------------------------------------


@pytest.mark.parametrize("step", ["open", "fsync", "replace"])
def test_a_failure_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    path = tmp_path / "t.txt"
    path.write_text("before")

    def full(*args: object, **more: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, step, full)
    with pytest.raises(OSError, match="No space left") as caught:
        write_whole(path, "after")
    monkeypatch.undo()
    assert caught.value.filename == str(path) and caught.value.errno == errno.ENOSPC
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["t.txt"]


def test_an_error_inside_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "t.txt"
    path.write_text("before")

    def half() -> None:
        with whole(path) as new:
            new.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        half()
    assert path.read_text() == "before" and len(list(tmp_path.iterdir())) == 1


@POSIX
def test_a_link_is_followed_and_stays(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for name in ("there/old.txt", "there/new.txt"):
        link = tmp_path / f"link{name[-5]}.txt"
        link.symlink_to(name)
        if "old" in name:
            (tmp_path / name).write_text("before")
        write_whole(link, "after")
        assert link.is_symlink() and (tmp_path / name).read_text() == "after"
    assert len(list((tmp_path / "there").iterdir())) == 2


@POSIX
def test_permissions_are_kept_and_those_of_a_new_file_are_usual(tmp_path: Path) -> None:
    old, new, usual = (tmp_path / name for name in ("old", "new", "usual"))
    old.write_text("before")
    old.chmod(0o640)
    usual.write_text("")
    write_whole(old, "after")
    write_whole(new, b"after")
    assert old.stat().st_mode & 0o777 == 0o640
    assert new.stat().st_mode == usual.stat().st_mode


@POSIX
def test_what_is_no_plain_file_is_written_to() -> None:
    write_whole("/dev/null", "anything")
    assert not Path("/dev/null").is_file()


def test_half_a_character_is_written(tmp_path: Path) -> None:
    write_whole(tmp_path / "t.txt", "a\udc80")
    assert (tmp_path / "t.txt").read_text() == "a\\udc80"


# --- verbs --------------------------------------------------------------------------------

CASE, DATA = str(EXAMPLES / "campaign.toml"), str(EXAMPLES / "campaign.csv")
VERBS = {
    "fit": ["fit", CASE, DATA, "--with", "sensor_gain", "--out"],
    "compare": ["compare", CASE, DATA, "--out"],
    "picture": ["compare", CASE, DATA, "--plot"],
    "simulate": ["simulate", CASE, str(EXAMPLES / "plan.toml"), "--out"],
    "solve": ["solve", CASE, "--torque-Nm", "5", "--preload-N", "600", "--out"],
    "schema": ["schema", "--out"],
}
ENDINGS = {"fit": ".toml", "picture": ".svg", "schema": ".json"}


@POSIX
@pytest.mark.parametrize("name", VERBS)
def test_a_verb_that_cannot_write_leaves_what_was_there(tmp_path: Path, name: str) -> None:
    """No file may have a byte here, as where a disk is full."""
    path = tmp_path / f"out{ENDINGS.get(name, '.csv')}"
    path.write_text("before")
    words = [sys.executable, "-m", "cbpt.cli.main", *VERBS[name], str(path)]
    command = ["sh", "-c", 'ulimit -f 0; trap "" XFSZ; exec "$@"', "sh", *words]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=PATIENCE_S, check=False,
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert f"cannot write {path}: " in done.stderr, done.stderr
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@POSIX
@pytest.mark.parametrize("verb", [["check", CASE], ["compare", CASE, DATA]], ids=["rust", "python"])
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_closed_output_is_no_crash(verb: list[str], closed: str) -> None:
    words = [sys.executable, "-m", "cbpt.cli.main", *verb]
    command = ["sh", "-c", f'"$@" {closed}', "sh", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert done.returncode == 0 and "Traceback" not in done.stderr


# What writes files of its own: see there.
WRITES = {
    "python/cbpt/whole_files.py",
    "python/cbpt/sweeps/files.py",  # parts, each put in its place when it is on the disk
    "python/cbpt/page/workbench/uploads.py",  # in a folder of its own
    "python/cbpt/page/printing.py",  # in a folder of its own
    "python/cbpt/figures/datasheet.py",  # into memory
    "python/cbpt/page/document/typescript.py",  # of the repository
    "python/cbpt/lab/readings/apart.py",  # without a name
    "python/cbpt/cli/main.py",  # nowhere
    "crates/cbpt-cli/src/whole.rs",
    "crates/cbpt-cli/src/sweep/output.rs",  # what grows
}
WRITING = re.compile(
    r"\.write_(text|bytes|table)\(|open\([^)\n]*\"[wax]b?\"|\.savefig\((?!new)|fs::write|File::create|File::options"
)


def test_all_files_are_written_by_one_routine() -> None:
    sources = [*(TOP / "python/cbpt").rglob("*.py"), *(TOP / "crates").glob("*/src/**/*.rs")]
    found = {
        path.relative_to(TOP).as_posix()
        for path in sources
        if "tests" not in path.parts and WRITING.search(path.read_text(encoding="utf-8"))
    }
    assert found <= WRITES, found - WRITES


# --- the files of sweeps ------------------------------------------------------------------


@pytest.fixture
def plan() -> cbpt.SweepPlan:
    return cbpt.SweepPlan.from_file(EXAMPLES / "sweep.toml")


@POSIX
@pytest.mark.parametrize("how", ["deleted", "replaced"])
def test_an_output_that_is_gone_is_told(tmp_path: Path, plan: cbpt.SweepPlan, how: str) -> None:
    path = tmp_path / "t.csv"
    output = open_output(plan, path, False)
    output.append(b"1,2\n", 1)
    path.unlink()
    if how == "replaced":
        path.write_text("another")
    with pytest.raises(OSError, match="deleted or replaced") as caught:
        output.append(b"1,2\n", 1)
    assert caught.value.errno == errno.EIO
    assert str(caught.value).endswith(f"while the sweep wrote it: {str(path)!r}")
    output.close()


@POSIX
@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_a_sweep_follows_a_link(tmp_path: Path, ending: str) -> None:
    (tmp_path / "there").mkdir()
    link = tmp_path / f"link{ending}"
    link.symlink_to(f"there/real{ending}")
    case = cbpt.Case.from_file(EXAMPLES / "base_case.toml")
    for _ in range(2):  # the second time it is complete
        cbpt.sweep(case, {"load.torque_Nm": [1.0, 2.0], "load.preload_N": 600.0}, out=link)
        assert link.is_symlink() and (tmp_path / f"there/real{ending}").is_file()
    assert [p.name for p in tmp_path.iterdir() if p.name != "there"] == [link.name]


# --- what a killed workbench leaves -------------------------------------------------------


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], set[str]]:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return lambda: {p.name for p in tmp_path.iterdir()}


def test_a_folder_goes_with_its_end(folders: Callable[[], set[str]]) -> None:
    mine = Scratch()
    (mine.path / "table").write_text("1")
    assert folders() == {mine.path.name}
    mine.close()
    assert folders() == set()


@POSIX
def test_what_a_kill_has_left_is_swept(tmp_path: Path, folders: Callable[[], set[str]]) -> None:
    program = (
        f"import tempfile; tempfile.tempdir = {str(tmp_path)!r}\n"
        "from cbpt.page.workbench.scratch import Scratch\n"
        "mine = Scratch(); (mine.path / 'table').write_text('1')\n"
        "import os; os.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", program], check=False, timeout=PATIENCE_S)
    assert len(folders()) == 1
    mine = Scratch()
    (tmp_path / "cbpt-workbench-of-another").mkdir()  # without a lock: not known to be ours
    (tmp_path / "others").mkdir()
    scratch.sweep()
    assert folders() == {mine.path.name, "cbpt-workbench-of-another", "others"}
    mine.close()
