"""Readings that a planned campaign would give.

    simulate       a case (with its effects), a plan and a noise -> Readings
    Instrument     what an instrument adds to the angle
    NOISES         kinds of noise by name, with the size each has where none is stated

The angle is the model's, effects of the case included. An instrument adds, in this order: scatter
(normal or with the tails of Student's t, correlated along a run or not), an offset of each run,
loose readings, the steps of its display.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError, NoSolutionError
from cbpt.lab.covariance.linear_gaussian import Rows
from cbpt.lab.experiment.plan import Plan, read_plan
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.fit_effects import predicted

__all__ = ["NOISES", "Instrument", "simulate"]

Floats = NDArray[np.float64]

NOISES: dict[str, tuple[str, float, str]] = {
    "correlated": ("correlation", 0.6, "correlation between successive readings of a run"),
    "run_offset": (
        "run_offset_per_u",
        3.0,
        "standard deviation of the offsets of the runs, divided by u",
    ),
    "heavy_tailed": ("degrees_of_freedom", 3.0, "degrees of freedom of Student's t distribution"),
    "outliers": ("outlier_share", 0.02, "share of readings that are off by 8 to 20 u"),
    "misstated": ("scale", 1.3, "true divided by stated uncertainty"),
    "quantised": (
        "step_per_u",
        3.0,
        "display step divided by u, at most 3.46, because u includes the rounding error",
    ),
}
"""Name -> number of `Instrument`, its size, its meaning. `white` and `none` have none."""
_LARGEST_STEP = math.sqrt(12.0)


@dataclass(frozen=True)
class Instrument:
    """What an instrument adds; white noise of the stated uncertainty where nothing is said.

    Sizes are ratios to the stated standard uncertainty u, so they hold for every row.
    """

    scale: float = 1.0
    correlation: float = 0.0
    run_offset_per_u: float = 0.0
    degrees_of_freedom: float = math.inf
    outlier_share: float = 0.0
    step_per_u: float = 0.0

    def __post_init__(self) -> None:
        allowed = {
            "scale": (0.0, 1e3, "a number from 0 to 1000"),
            "correlation": (-0.99, 0.99, "a number from -0.99 to 0.99"),
            "run_offset_per_u": (0.0, 1e6, "a number from 0 to 1e6"),
            "degrees_of_freedom": (
                2.1,
                math.inf,
                "a number above 2, else the variance is infinite",
            ),
            "outlier_share": (0.0, 0.5, "a share from 0 to 0.5"),
            "step_per_u": (
                0.0,
                _LARGEST_STEP,
                "a number from 0 to 3.46, as u includes the rounding",
            ),
        }
        for part in fields(self):
            value = getattr(self, part.name)
            low, high, expected = allowed[part.name]
            if math.isnan(value) or not low <= value <= high:
                raise InvalidInputError(f"noise, {part.name}: found {value:g}, expected {expected}")

    @classmethod
    def of(cls, noise: Instrument | str | Sequence[str]) -> Instrument:
        """From kinds such as `correlated` or `run_offset=2`, which add up."""
        if isinstance(noise, Instrument):
            return noise
        numbers: dict[str, float] = {}
        for entry in [noise] if isinstance(noise, str) else noise:
            kind, given, size = entry.partition("=")
            if kind in ("white", "none") and not given:
                numbers |= {"scale": 0.0} if kind == "none" else {}
                continue
            if kind not in NOISES:
                raise InvalidInputError(
                    f"noise: found {entry!r}, expected white, none or any of "
                    f"{', '.join(NOISES)}, if needed with a size, as in run_offset=2"
                )
            name, usual, meaning = NOISES[kind]
            try:
                numbers[name] = float(size) if given else usual
            except ValueError:
                raise InvalidInputError(
                    f"noise, {kind}: found {size!r}, expected a number: {meaning}"
                ) from None
        return cls(**numbers)

    def readings(
        self, angle_arcsec: Floats, u_arcsec: Floats, rows: Rows, rng: np.random.Generator
    ) -> Floats:
        """What is read where the angle is `angle_arcsec`; all arrays have shape (n,)."""
        n = len(angle_arcsec)
        # Drawn whatever the noise is, so that one seed gives one scatter under every kind.
        scatter = rng.standard_normal(n)
        offsets = rng.standard_normal(rows.runs)
        chance, sign, far = rng.random(n), rng.choice([-1.0, 1.0], n), rng.uniform(8, 20, n)
        if math.isfinite(self.degrees_of_freedom):
            nu = self.degrees_of_freedom
            scatter = rng.standard_t(nu, n) * np.sqrt((nu - 2) / nu)
        if self.correlation:
            rho = self.correlation
            for i in rows.order:
                if rows.before[i] >= 0:
                    fresh = np.sqrt(1 - rho**2) * scatter[i]
                    scatter[i] = rho * scatter[rows.before[i]] + fresh
        # What rounding adds is part of u.
        scatter *= np.sqrt(1 - (self.step_per_u / _LARGEST_STEP) ** 2)
        typical = float(np.median(u_arcsec))
        read = angle_arcsec + self.scale * u_arcsec * scatter
        read = read + self.run_offset_per_u * typical * offsets[rows.run_index]
        read = read + np.where(chance < self.outlier_share, sign * far * u_arcsec, 0.0)
        step = self.step_per_u * typical
        return np.asarray(step * np.round(read / step) + 0.0 if step else read)


def simulate(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    plan: Plan | Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    effects: Sequence[tuple[str, Mapping[str, float]]] = (),
    noise: Instrument | str | Sequence[str] = "white",
    seed: int = 0,
    u_elastic_angle_arcsec: float | None = None,
) -> Readings:
    """Simulate the readings of a campaign.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    plan : Plan, Readings, str, PathLike or mapping
        The campaign, as `read_plan` takes it.
    effects : sequence of (str, mapping)
        Effects that act in addition to those of the case: an id of the library, and its parameters
        named as in a case file: ``("output_torsion", {"compliance_arcsec_per_Nm": 2})``.
    noise : Instrument, str or sequence of str
        An `Instrument`, or kinds of noise with their sizes, for example ``"run_offset=2"``.
    seed : int
        Seed of the random numbers. The same seed gives the same result.
    u_elastic_angle_arcsec : float, optional
        Standard uncertainty of a reading (k = 1), where the plan has none.

    Returns
    -------
    Readings
        Simulated readings of shape (n,), as `compare` and `diagnose` take them.

    Raises
    ------
    NoSolutionError
        The preload of the plan does not hold the torque in some rows.
    PlanError, ReadingsError, CaseError, InvalidInputError
        Plan, case or an argument cannot be read.
    """
    case = with_effects(case_of(case), effects)
    instrument = Instrument.of(noise)
    found = read_plan(plan, case).with_u(u_elastic_angle_arcsec)
    rows = found.rows
    # A plan says at which torques it turns back.
    if found.runs and isinstance(case, Case):
        case = case.with_torque_turns("at_readings")
    truth = predicted(case, rows)
    stop_without_solution(rows, truth.has_solution, truth.status)
    u = rows.u_elastic_angle_arcsec
    assert u is not None
    rng = np.random.default_rng(seed)
    order = Rows.of(rows.run_index)
    read = instrument.readings(truth.elastic_angle_arcsec, u, order, rng)
    return replace(rows, elastic_angle_arcsec=read)


def with_effects(
    case: Case | Drive, effects: Sequence[tuple[str, Mapping[str, float]]]
) -> Case | Drive:
    """The case with further effects."""
    if not effects:
        return case
    if isinstance(case, Drive):
        case = Case.from_toml(case.to_toml())
    for effect in effects:
        if not (isinstance(effect, tuple | list) and len(effect) == 2):
            raise InvalidInputError(
                f"effects: found {effect!r}, expected (id, parameters) of an effect of the "
                "library; put an own effect in the case, as an [[effect]] with an expression"
            )
    own = [(effect.id, dict(effect.values)) for effect in case.effects]
    twice = next((e for e, _ in effects if e in [i for i, _ in own]), None)
    if twice:
        raise InvalidInputError(f"effect {twice}: the case has it already; change it there")
    return case.with_effects([*own, *((effect, dict(numbers)) for effect, numbers in effects)])


_REMEDY = {
    "beyond_hold": "Lower the torque or raise the preload, see cbpt preload",
    "indeterminate": "So few meshing points touch that the plate is free to move: raise the "
    "preload or lower the offsets of the balls",
    "undercut": "A groove of the drive cuts its own wall away at any load: enlarge the rolling "
    "circle, lower the short-amplitude coefficient or the ball radius, or set track_curvature = "
    '"neglect", see cbpt check',
    "effect_not_finite": "The own effect has no finite value there: check its divisions, "
    "logarithms, "
    "roots and powers",
}
"""By status of the first row without a solution."""


def stop_without_solution(
    rows: Readings, solved: NDArray[np.bool_], status: NDArray[np.str_]
) -> None:
    """Raise `NoSolutionError` where the model has no solution at some rows."""
    wrong = np.flatnonzero(~solved)
    if not len(wrong):
        return
    first = int(wrong[0])
    lines = rows.line[wrong[:8]].tolist()
    shown = f"{rows.place}{'s' * (len(wrong) > 1)} {', '.join(map(str, lines))}"
    shown += ", ..." if len(wrong) > 8 else ""
    preload = "" if rows.preload_N is None else f" at a preload of {rows.preload_N[first]:g} N"
    raise NoSolutionError(
        f"{rows.source}: the model has no solution at {len(wrong)} of {len(rows)} rows ({shown}); "
        f"the first has {rows.torque_Nm[first]:g} N m{preload} in run {rows.run[first]}: "
        f"{status[first]}. {_REMEDY.get(str(status[first]), 'Run cbpt solve at this load')}"
    )
