"""The trial where a diagnosis also proposes the forms that it fits on request alone.

    python benches/trial/proposed.py --family spring --sets 8 --seed 5 --fresh

Takes the arguments of the trial; docs/explanation/loop-forms.md tells what came of it. Its answers
are kept apart from those of the trial.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Sequence
from pathlib import Path

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"
BENCHES = Path(__file__).parents[1]
sys.path[:1] = [str(BENCHES), str(BENCHES.parent / "tests")]

from cbpt.lab.inference import fit  # noqa: E402 (what is above must come first)
from cbpt.lab.model.dataset import Campaign  # noqa: E402
from cbpt.lab.model.priors import ON_REQUEST, Variant  # noqa: E402
from cbpt.lab.model.spring_priors import library_of  # noqa: E402
from trial import answers  # noqa: E402
from trial.run import main  # noqa: E402

kept = answers.answer_folder


def everything(campaign: Campaign, asked: Sequence[str] = ()) -> tuple[Variant, ...]:
    """The library with all forms proposed."""
    return library_of(campaign, (*asked, *ON_REQUEST))


def apart() -> Path:
    """Where the answers are kept."""
    return kept().with_name(f"{kept().name}-proposed")


if __name__ == "__main__":
    # Workers are copies of this process, with what it replaces.
    multiprocessing.set_start_method("fork")
    vars(fit)["library_of"] = everything
    vars(answers)["answer_folder"] = apart
    raise SystemExit(main())
