"""Many designs of one case at once, as labelled arrays.

    Judged     status, elastic angle, sizes and margins of each design
    judge      the case with other values of some numbers, row by row
    at_load    the case with its load completed
    value_of   a number as the case has it
    shown      a number by its key in the usual unit
    left_out    ids of what of the case has no part here
    bare_drive_note, nominal_parts_note   the same as text

Numbers are named in SI as in a case file: `deceleration.ball_radius_m`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, design_numbers, judge_designs
from cbpt.errors import InvalidInputError
from cbpt.lab.readings.inputs import case_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Judged:
    """n designs; arrays of shape (n,), NaN where there is no solution or it was not asked for."""

    status: NDArray[np.str_]
    """As in `Angles`, or `no_drive` where the numbers make none."""
    columns: dict[str, Floats]
    """`elastic_angle_rad`, `outer_radius_m`, `undercut_margin`, `inside_wall_margin`,
    `deceleration_ball_clearance_m`, `equal_speed_ball_clearance_m`, `ring_clearance_m`,
    `deceleration_pressure_Pa`, `equal_speed_pressure_Pa`, `needed_preload_N`, `friction_torque_Nm`,
    `efficiency`, `wear_Nm_per_turn`, `static_safety`, `torsional_stiffness_Nm_per_rad`,
    `natural_frequency_Hz`."""

    def __getitem__(self, column: str) -> Floats:
        return self.columns[column]


def judge(
    case: Case,
    numbers: Sequence[str],
    values: Floats,
    *,
    pressures: bool = False,
    threshold: str | None = None,
    coefficient: float | None = None,
) -> Judged:
    """Designs with `values`, shape (n, k), in place of the case's own of k `numbers`.

    Under the load of the case. `threshold` (hold, continuous or zero_backlash) fills
    `needed_preload_N`, as a maximum over a period; it takes a hundred times as long as all else.
    `pressures` fills static safety, stiffness and, where the case states the inertia at the output,
    the natural frequency too. A friction `coefficient` fills friction
    torque, efficiency and wear, at the angle of the load.
    """
    assert case.torque_Nm is not None and case.preload_N is not None, "see at_load"
    code, names, table, columns = judge_designs(
        case.drive,
        case.torque_Nm,
        case.preload_N,
        float(np.deg2rad(case.input_angle_deg or 0.0)),
        list(numbers),
        np.ascontiguousarray(values, dtype=np.float64).reshape(-1),
        pressures,
        threshold,
        coefficient,
    )
    found = {name: table[:, place] for place, name in enumerate(columns)}
    inertia = case.output_inertia_kg_m2
    stiffness = found["torsional_stiffness_Nm_per_rad"]
    found["natural_frequency_Hz"] = (
        np.full(len(stiffness), np.nan)
        if inertia is None
        else np.sqrt(stiffness / inertia) / (2 * np.pi)
    )
    return Judged(status=np.array(names, dtype=np.str_)[code], columns=found)


def at_load(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    torque_Nm: float | None = None,
    preload_N: float | None = None,
    input_angle_deg: float | None = None,
) -> Case:
    """The case, in any form, with a whole load: what is stated here, else that of `[load]`.

    Raises `InvalidInputError` where a number is missing or cannot be, and for another reducer.
    """
    found = case_of(case)
    whole = found if isinstance(found, Case) else Case.from_toml(found.to_toml())
    stated = {"load.torque_Nm": torque_Nm, "load.preload_N": preload_N}
    if input_angle_deg is not None:
        stated["load.input_angle_rad"] = float(np.deg2rad(input_angle_deg))
    whole = whole.with_numbers({name: value for name, value in stated.items() if value is not None})
    for name, value in (("torque_Nm", whole.torque_Nm), ("preload_N", whole.preload_N)):
        if value is None:
            raise InvalidInputError(f"{name} is missing: give it here or under [load] in the case")
    return whole


def value_of(case: Case, number: str) -> float | None:
    """A number of the case, SI; None for one that stands for two that differ."""
    section, _, key = number.partition(".")
    # As the case writes itself: in SI, two that are the same under their common name.
    table = tomllib.loads(case.to_toml())[section]
    common = key.split("_", 1)[-1]
    value = table.get(key, table.get(common, 0.0 if key == "input_angle_rad" else None))
    return None if value is None else float(value)


@cache
def _numbers() -> dict[str, tuple[str, float]]:
    return design_numbers()


def shown(number: str, value: float) -> tuple[str, float]:
    """Key and value in the usual unit: `deceleration.ball_radius_mm` and 1.5."""
    key, per_si = _numbers()[number]
    return key, value * per_si


def effects_of(case: Case) -> list[str]:
    """Ids of the effects of a case."""
    return [effect.id for effect in case.effects] + [own.id for own in case.own_effects]


def left_out(case: Case) -> list[str]:
    """Ids of the effects of a case, and `as_made` where it has tables of its parts."""
    return effects_of(case) + (["as_made"] if case.drive.has_parts_as_made else [])


def nominal_parts_note(case: Case, what: str) -> list[str]:
    """A line that says so, where the case has tables of its parts."""
    parts = case.drive.has_parts_as_made
    return [f"Note: {what} computed for nominal parts, without [as_made]."] if parts else []


def bare_drive_note(case: Case, what: str) -> list[str]:
    """A line that says so, where there are any."""
    ids = ", ".join(effects_of(case))
    return (
        [f"Note: {what} computed for the drive alone, without the effects of the case: {ids}."]
        if ids
        else []
    )
