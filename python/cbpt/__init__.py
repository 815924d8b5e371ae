"""Elastic angle of a cycloid ball planetary transmission (CBPT).

    >>> import cbpt
    >>> drive = cbpt.Drive.from_toml(cbpt.example_case())
    >>> solution = drive.solve(torque_Nm=5, preload_N=600)

Map:

- `Drive`, `Case`: the drive, from a case file, TOML text or a dict;
- `Drive.solve` -> `Solution` -> `PairSolution`: one load, every meshing point;
- `Drive.preload` -> `PreloadThresholds`: the preload that a torque needs;
- `solve_many` -> `Angles`: arrays of loads on all cores;
- `read_readings` -> `Readings`, `compare` -> `Comparison`: model against measurement;
- `diagnose` -> `Diagnosis`: which effect is missing; `fit` -> `Fitted`: the case with it;
- `effects`: effects of your own, as an expression or a Python function;
- `errors`: everything that can be raised, under `CbptError`.

Input is in the unit that its name ends in; inside everything is SI and radians.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cbpt._core import (
    Case,
    Drive,
    Finding,
    LargestAngle,
    PairSolution,
    PreloadThresholds,
    Solution,
    Thresholds,
    example_case,
)
from cbpt.errors import CaseError, CbptError, InvalidInputError, ReadingsError

if TYPE_CHECKING:
    __version__: str
    from cbpt import effects as effects
    from cbpt.lab.answer import Diagnosis
    from cbpt.lab.compare import Comparison, compare
    from cbpt.lab.diagnose import diagnose
    from cbpt.lab.fitting import Fitted, fit
    from cbpt.lab.readings import Readings, read_readings
    from cbpt.results import Angles, solve_many

# Loaded when first asked for, so that `import cbpt` stays light.
_LAZY = {
    "Angles": "cbpt.results",
    "Comparison": "cbpt.lab.compare",
    "Diagnosis": "cbpt.lab.answer",
    "Fitted": "cbpt.lab.fitting",
    "Readings": "cbpt.lab.readings",
    "compare": "cbpt.lab.compare",
    "diagnose": "cbpt.lab.diagnose",
    "fit": "cbpt.lab.fitting",
    "read_readings": "cbpt.lab.readings",
    "solve_many": "cbpt.results",
}

__all__ = [
    "Angles",
    "Case",
    "CaseError",
    "CbptError",
    "Comparison",
    "Diagnosis",
    "Drive",
    "Finding",
    "Fitted",
    "InvalidInputError",
    "LargestAngle",
    "PairSolution",
    "PreloadThresholds",
    "Readings",
    "ReadingsError",
    "Solution",
    "Thresholds",
    "compare",
    "diagnose",
    "effects",
    "example_case",
    "fit",
    "read_readings",
    "solve_many",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("cbpt")
    if name == "effects":
        return import_module("cbpt.effects")
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'cbpt' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
