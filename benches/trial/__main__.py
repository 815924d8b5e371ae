"""`python benches/trial`, whose arguments are told in run.py. `make trial` is the full length."""

import os
import sys
from pathlib import Path

# One thread a worker: campaigns are small, and answers must not depend on the machine.
for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"
BENCHES = Path(__file__).parents[1]
sys.path[:1] = [str(BENCHES), str(BENCHES.parent / "tests")]

from trial.run import main  # noqa: E402 (what is above must come first)

if __name__ == "__main__":
    raise SystemExit(main())
