"""What every verb of the lab is given: a case and a table of readings, each in several forms."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError
from cbpt.lab.readings.reader import Readings, read_readings


def case_of(case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any]) -> Case | Drive:
    """The case in any of its forms."""
    if isinstance(case, (str, os.PathLike)):
        return Case.from_file(case)
    if isinstance(case, Mapping):
        return Case.from_dict(dict(case))
    if not isinstance(case, (Case, Drive)):
        raise TypeError(
            f"a case comes from a path, a dict, a Case or a Drive, not from {type(case).__name__}"
        )
    return case


def case_and_readings(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, Any] | None = None,
    by: str | None = None,
) -> tuple[Case | Drive, Readings]:
    """The case, and the readings with what the case fills in: lever arm, preload, input angle."""
    if _is_case(data) and isinstance(case, (str, os.PathLike)) and not _is_case(case):
        raise InvalidInputError(f"the case comes first: {data}, then {case}")
    case = case_of(case)
    lever_arm_mm, fill = filled_in(case)
    if not isinstance(data, Readings):
        spring = (case.drive if isinstance(case, Case) else case).kind == "torsion_spring"
        data = read_readings(
            data,
            lever_arm_mm=lever_arm_mm,
            columns=columns,
            sheet=sheet,
            need_preload=not spring,
            fill=fill,
            only=only,
            by=by,
        )
    elif only or by:
        raise TypeError("only and by are read with the table: pass a path or columns, not Readings")
    return case, data


def _is_case(given: object) -> bool:
    """Whether something is the name of a case file."""
    return isinstance(given, (str, os.PathLike)) and Path(given).suffix.lower() == ".toml"


def filled_in(case: Case | Drive) -> tuple[float | None, dict[str, float]]:
    """What a case states that a table may lack: the lever arm, and values of columns."""
    if not isinstance(case, Case):
        return None, {}
    load = {"preload_N": case.preload_N, "input_angle_deg": case.input_angle_deg}
    return case.lever_arm_mm, {name: value for name, value in load.items() if value is not None}
