"""Elastic angle of a cycloid ball planetary transmission (CBPT).

    >>> import cbpt
    >>> drive = cbpt.Drive.from_toml(cbpt.example_case())
    >>> solution = drive.solve(torque_Nm=5, preload_N=600)

Map:

- `Drive`, `Case`: the drive, from a case file, TOML text or a dict;
- `Drive.solve` -> `Solution` -> `PairSolution`: one load, every meshing point; `Enclosure`:
  where its angle lies for certain;
- `Drive.preload` -> `PreloadThresholds`: the preload that a torque needs;
- `Drive.friction` -> `Friction` -> `PairFriction`, `FrictionContact`: friction torque at the input,
  efficiency, wear; `friction` -> `Costs`: all that preload and stiffness cost; `friction_map` ->
  `FrictionMap`: arrays of loads;
- `solve_many` -> `Angles`: arrays of loads on all cores;
- `sweep` -> `Sweep`: any parameter of drive, load or effects, also on an executor or to a file;
  `SweepPlan`: what it follows;
- `read_readings` -> `Readings`, `compare` -> `Comparison`: model against measurement;
- `preflight` -> `Preflight`: what a table holds, and what it cannot tell, before any model;
- `characterise` -> `Characteristics`: lost motion, hysteresis loss, rigidity of loops;
- `change` -> `Change`: what changed between two campaigns, or from level to level;
- `diagnose` -> `Diagnosis`: which effect is missing; `diagnose_by` -> `DividedDiagnosis`: the same
  for each level of a column; `read_answer`: one that was saved; `fit` -> `Fitted`: the case with
  it;
- `effects`: effects of your own, as an expression or a Python function;
- `read_plan` -> `Plan`: a campaign to come; `simulate` -> `Readings`: what it would read;
  `isolability` -> `Isolability`: what it could see and tell apart; `next_runs` -> `NextRuns`: what
  would decide; `shortest_plan` -> `Design`: a whole campaign;
- `Drive.sensitivities` -> `Sensitivities`: derivatives of angle and thresholds by every design
  number; `tolerance` -> `Tolerance`: what the drawing's tolerances make of the angle; `optimise` ->
  `Optimum`: the design with the smallest angle within bounds; `pareto_front` -> `ParetoFront`:
  designs of which none is better in two objectives; `transmission` -> `Transmission`: the
  error of the parts as they were made; `datasheet`: one page of a drive, HTML;
- `errors`: everything that can be raised, under `CbptError`.

Input is in the unit that its name ends in; inside everything is SI and radians.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cbpt._core import (
    Case,
    Drive,
    Enclosure,
    Finding,
    Friction,
    FrictionContact,
    LargestAngle,
    PairFriction,
    PairSolution,
    PreloadThresholds,
    Sensitivities,
    Sensitivity,
    Solution,
    SweepPlan,
    Thresholds,
    example_case,
)
from cbpt.errors import (
    CaseError,
    CbptError,
    InvalidInputError,
    NoSolutionError,
    PlanError,
    ReadingsError,
)

if TYPE_CHECKING:
    __version__: str
    from cbpt import effects as effects
    from cbpt.design.costs import Costs, FrictionMap, friction, friction_map
    from cbpt.design.front import ParetoFront, pareto_front
    from cbpt.design.optimise import Optimum, optimise
    from cbpt.design.tolerance import Tolerance, tolerance
    from cbpt.design.transmission import Transmission, transmission
    from cbpt.lab.change.answer import Change
    from cbpt.lab.change.change import change
    from cbpt.lab.characteristics.characterise import characterise
    from cbpt.lab.characteristics.characteristics import Characteristics
    from cbpt.lab.diagnosis.by_level import DividedDiagnosis, diagnose_by
    from cbpt.lab.diagnosis.compare import Comparison, compare
    from cbpt.lab.diagnosis.diagnose import diagnose
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.lab.diagnosis.fitted import Fitted, fit
    from cbpt.lab.diagnosis.next_runs import NextRuns, next_runs
    from cbpt.lab.diagnosis.saved import read_answer
    from cbpt.lab.experiment.candidates import Limits
    from cbpt.lab.experiment.isolability import Isolability, isolability
    from cbpt.lab.experiment.plan import Plan, read_plan
    from cbpt.lab.experiment.shortest_plan import Design, shortest_plan
    from cbpt.lab.experiment.simulate import simulate
    from cbpt.lab.preflight.preflight import Preflight, preflight
    from cbpt.lab.readings.reader import Readings, read_readings
    from cbpt.page.datasheet import datasheet
    from cbpt.results import Angles, solve_many
    from cbpt.sweeps.result import Sweep
    from cbpt.sweeps.run import sweep

# Loaded when first asked for, so that `import cbpt` stays light.
_LAZY = {
    "Angles": "cbpt.results",
    "Change": "cbpt.lab.change.answer",
    "Characteristics": "cbpt.lab.characteristics.characteristics",
    "Comparison": "cbpt.lab.diagnosis.compare",
    "Costs": "cbpt.design.costs",
    "Design": "cbpt.lab.experiment.shortest_plan",
    "Diagnosis": "cbpt.lab.diagnosis.diagnosis",
    "DividedDiagnosis": "cbpt.lab.diagnosis.by_level",
    "Fitted": "cbpt.lab.diagnosis.fitted",
    "FrictionMap": "cbpt.design.costs",
    "Isolability": "cbpt.lab.experiment.isolability",
    "Limits": "cbpt.lab.experiment.candidates",
    "NextRuns": "cbpt.lab.diagnosis.next_runs",
    "Optimum": "cbpt.design.optimise",
    "ParetoFront": "cbpt.design.front",
    "Plan": "cbpt.lab.experiment.plan",
    "Preflight": "cbpt.lab.preflight.preflight",
    "Readings": "cbpt.lab.readings.reader",
    "Sweep": "cbpt.sweeps.result",
    "Tolerance": "cbpt.design.tolerance",
    "Transmission": "cbpt.design.transmission",
    "change": "cbpt.lab.change.change",
    "characterise": "cbpt.lab.characteristics.characterise",
    "compare": "cbpt.lab.diagnosis.compare",
    "datasheet": "cbpt.page.datasheet",
    "diagnose": "cbpt.lab.diagnosis.diagnose",
    "diagnose_by": "cbpt.lab.diagnosis.by_level",
    "fit": "cbpt.lab.diagnosis.fitted",
    "friction": "cbpt.design.costs",
    "friction_map": "cbpt.design.costs",
    "isolability": "cbpt.lab.experiment.isolability",
    "next_runs": "cbpt.lab.diagnosis.next_runs",
    "optimise": "cbpt.design.optimise",
    "pareto_front": "cbpt.design.front",
    "preflight": "cbpt.lab.preflight.preflight",
    "read_answer": "cbpt.lab.diagnosis.saved",
    "read_plan": "cbpt.lab.experiment.plan",
    "read_readings": "cbpt.lab.readings.reader",
    "shortest_plan": "cbpt.lab.experiment.shortest_plan",
    "simulate": "cbpt.lab.experiment.simulate",
    "solve_many": "cbpt.results",
    "sweep": "cbpt.sweeps.run",
    "tolerance": "cbpt.design.tolerance",
    "transmission": "cbpt.design.transmission",
}

__all__ = [
    "Angles",
    "Case",
    "CaseError",
    "CbptError",
    "Change",
    "Characteristics",
    "Comparison",
    "Costs",
    "Design",
    "Diagnosis",
    "DividedDiagnosis",
    "Drive",
    "Enclosure",
    "Finding",
    "Fitted",
    "Friction",
    "FrictionContact",
    "FrictionMap",
    "InvalidInputError",
    "Isolability",
    "LargestAngle",
    "Limits",
    "NextRuns",
    "NoSolutionError",
    "Optimum",
    "PairFriction",
    "PairSolution",
    "ParetoFront",
    "Plan",
    "PlanError",
    "Preflight",
    "PreloadThresholds",
    "Readings",
    "ReadingsError",
    "Sensitivities",
    "Sensitivity",
    "Solution",
    "Sweep",
    "SweepPlan",
    "Thresholds",
    "Tolerance",
    "Transmission",
    "change",
    "characterise",
    "compare",
    "datasheet",
    "diagnose",
    "diagnose_by",
    "effects",
    "example_case",
    "fit",
    "friction",
    "friction_map",
    "isolability",
    "next_runs",
    "optimise",
    "pareto_front",
    "preflight",
    "read_answer",
    "read_plan",
    "read_readings",
    "shortest_plan",
    "simulate",
    "solve_many",
    "sweep",
    "tolerance",
    "transmission",
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
