"""What a person would want to look at again in a table; nothing is changed for it.

remarks         notes on a table that was read
are_levels      whether the words of a column are a few levels, as states of a rig are
taken_together  that readings of several levels are
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.whole_turns import about_runs

_LARGEST_ANGLE_ARCSEC = 3600.0  # an elastic angle of a degree: a broken drive or a wrong unit
_MOST_LABELS, _SHOWN_LABELS = 24, 3
"""Values of a column of words that are told, and those that are listed."""


def remarks(readings: Readings) -> list[str]:
    """Notes on torque, angle, preload and input angle."""
    notes = []
    torque, preload = readings.torque_Nm, readings.preload_N
    if not torque.any():
        notes.append("the torque is 0 in every row")
    elif len(torque) > 1 and torque.min() == torque.max():
        notes.append(f"the torque is {torque[0]:g} N m in every row")
    largest = np.abs(about_runs(readings.elastic_angle_arcsec, readings.run_index)).max()
    if largest > _LARGEST_ANGLE_ARCSEC:
        notes.append(
            f"the elastic angle goes {largest / 3600:.3g} deg from the middle of its run, more "
            "than usual: check the unit of the column"
        )
    if preload is not None and preload.min() == preload.max():
        notes.append(
            "the preload is the same in every row, so effects that depend on it cannot be detected"
        )
    angles = len(np.unique(np.round(np.mod(readings.input_angle_deg, 360.0), 3)))
    if angles in (2, 3):
        what = ("phase, the number of cycles per turn", "number of cycles per turn")[angles - 2]
        notes.append(
            f"the readings have only {('two', 'three')[angles - 2]} input angles: where an effect "
            f"varies with the input angle, its {what} and the plate that it comes from cannot be "
            "determined"
        )
    return notes


def are_levels(cells: Sequence[str]) -> bool:
    """Whether a column of words, shape (n,), has a few values that come again."""
    return 2 <= len(set(cells)) <= min(_MOST_LABELS, len(cells) // 2)


def taken_together(name: str, cells: Sequence[str]) -> str:
    """That readings with several labels of a column are taken together."""
    values = list(dict.fromkeys(cells))
    some = ", ".join(values[:_SHOWN_LABELS]) + (", ..." if len(values) > _SHOWN_LABELS else "")
    return (
        f"readings of {len(values)} values of {name!r} ({some}) are taken together; --by {name} "
        f"(diagnose_by) or --only {name}={values[0]} keeps them apart, and cbpt change --by {name} "
        "(change) says what differs between them"
    )
