"""Whether levels were loaded alike: at the same rates, and at the same input angles.

note_on_rates   what to say where rates were not the same
unlike_design   what else than a change may make levels differ, in words

A law that depends on the rate, or on the input angle, looks like a change between levels that
differ in it, and no level by itself shows it: what it stands in for did not change, however certain
the fits are of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from cbpt.lab.characteristics.warnings import RATES
from cbpt.lab.model.spring_priors import typical_rate_Nm_per_s
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded

_NOTED = 1.2
"""Factor by which rates differ that is told: a friction that depends on the rate may differ by some
percent then, which looks like a small change."""
_FEW_ANGLES = 4
"""Input angles up to which a law of the angle is none that the level itself shows."""


def note_on_rates(tables: Sequence[Readings]) -> Iterator[str]:
    """What levels that were loaded at unlike rates may show beside a change."""
    slow, fast = _rates_of_like_runs(tables)
    if fast > _NOTED * slow:
        yield (
            f"the torque changes at {rounded(slow)} to {rounded(fast)} N m/s from level to level "
            "in runs to the same torque: an instrument that lags, and friction or creep that "
            "depends on the rate, look like a change of friction then. Measure all levels at one "
            "rate"
        )


def unlike_design(tables: Sequence[Readings]) -> str:
    """Empty where nothing speaks against a change."""
    slow, fast = _rates_of_like_runs(tables)
    if fast > RATES * slow:
        return (
            f"the levels were loaded at {rounded(slow)} to {rounded(fast)} N m/s, and a law that "
            "depends on the rate would look like this: measure all levels at one rate"
        )
    angles = [set(np.round(np.mod(r.input_angle_deg, 360.0)).tolist()) for r in tables]
    few = any(
        not one & other and min(len(one), len(other)) <= _FEW_ANGLES
        for one, other in combinations(angles, 2)
    )
    if few:
        return (
            "the levels have no input angle in common, and a law that depends on it would look "
            "like this: measure all levels at the same input angles"
        )
    return ""


def _rates_of_like_runs(tables: Sequence[Readings]) -> tuple[float, float]:
    """The two rates that differ most, of levels in runs to like torques: a level may have more of
    the slow ones."""
    kinds = [_rates(readings) for readings in tables]
    pairs = (
        sorted((one[kind], other[kind]))
        for one, other in combinations(kinds, 2)
        for kind in one.keys() & other.keys()
    )
    slow, fast = max(pairs, key=lambda pair: pair[1] / pair[0], default=(1.0, 1.0))
    return slow, fast


def _rates(readings: Readings) -> dict[int, float]:
    """The typical rate of the runs to each torque, N m/s, in classes a quarter wide."""
    most = np.zeros(int(readings.run_index.max()) + 1)
    np.maximum.at(most, readings.run_index, np.abs(readings.torque_Nm))
    kind = np.round(np.log(np.maximum(most, 1e-12)) / np.log(1.25)).astype(np.int64)
    found = {
        int(one): typical_rate_Nm_per_s(readings.select(kind[readings.run_index] == one))
        for one in np.unique(kind)
    }
    return {one: rate for one, rate in found.items() if rate}
