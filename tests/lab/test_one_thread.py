"""A diagnosis keeps linear algebra to one thread, in a process that has done none before."""

from __future__ import annotations

import os
import subprocess
import sys

from common.hidden import FOLDER

_SCRIPT = """
import sys
import cbpt
from threadpoolctl import threadpool_info

def look(*_):
    import scipy.linalg
    found = [lib["num_threads"] for lib in threadpool_info() if lib["user_api"] == "blas"]
    print(*found)
    sys.exit()

cbpt.diagnose(*sys.argv[1:], progress=look)
"""


def test_scipy_which_is_loaded_late_has_one_thread_too() -> None:
    files = FOLDER / "dev01.toml", FOLDER / "dev01.csv"
    told = subprocess.run(
        [sys.executable, "-c", _SCRIPT, *map(str, files)],
        # Of whatever BLAS there is; the machine may have one core.
        env={**os.environ, "OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    assert told and set(told) == {"1"}
