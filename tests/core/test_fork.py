"""Work in a process that was forked, once its parent has used all cores.

A fork copies no threads, so what is handed to those of the parent would never come back. Each case
runs in a process of its own, so that its threads are no matter of the other tests.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import cbpt
from common import PATIENCE_S

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no fork")

WORK = {
    "solve_many": "cbpt.solve_many(case.drive, torque, 700.0).elastic_angle_arcsec.tolist()",
    "sweep": "cbpt.sweep(plan).elastic_angle_arcsec.tolist()",
    "compare": "cbpt.compare(case, readings).residual_arcsec.tolist()",
    "fit": "[n.value for n in cbpt.compare(case, readings, effects=['creep']).numbers]",
    "largest": "case.drive.largest_elastic_angle(3.0, 700.0).elastic_angle_arcsec",
    "command": "cbpt._core.run_command_line(['cbpt', 'sweep', case_path, '-T', '0:2:1'])",
}

PROGRAM = """
import os, sys, warnings
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
import numpy as np
import cbpt

warnings.filterwarnings("ignore", ".*fork")  # of later Pythons; that it works is what is tested
(case_path,) = sys.argv[1:]
case = cbpt.Case.from_file(case_path)
torque = np.linspace(-3, 3, 3000)
axes = [("load.torque_Nm", (0.0, 3.0, False)), ("load.preload_N", (400.0, 900.0, False))]
plan = cbpt.SweepPlan(case, axes, "random", 3000)
readings = {
    "time_s": np.arange(60.0), "torque_Nm": np.tile(np.linspace(-3, 3, 20), 3),
    "preload_N": np.full(60, 700.0), "elastic_angle_arcsec": np.linspace(-20, 20, 60),
}

def work():
    return WORK

def forked():
    '''What `work` gives in a child of this process, as text.'''
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.write(write, repr(work()).encode()[:60_000])
            code = 0
        finally:
            os._exit(code)
    os.close(write)
    with os.fdopen(read) as pipe:
        text = pipe.read()
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    return text

def twice():
    '''In a child, again there, and in a child of it.'''
    return [repr(work())[:60_000], repr(work())[:60_000], forked()]

here = repr(work())[:60_000]
with ProcessPoolExecutor(2, mp_context=get_context("fork")) as pool:
    for found in [pool.submit(twice) for _ in range(3)]:
        assert found.result() == [here] * 3
assert repr(work())[:60_000] == here
"""


@pytest.mark.parametrize("work", WORK)
def test_a_forked_process_works(work: str, tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(cbpt.example_case())
    program = PROGRAM.replace("WORK", WORK[work], 1)
    command = [sys.executable, "-c", program, str(case)]
    # A session of its own, so that children that hang end with it.
    with subprocess.Popen(
        command,
        start_new_session=True,
        text=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    ) as process:
        try:
            _, errors = process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise
    assert process.returncode == 0, errors
