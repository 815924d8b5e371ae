"""Whether levels were loaded at the same rates.

note_on_rates   what to say where they were not
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from cbpt.lab.characteristics.warnings import RATES
from cbpt.lab.model.spring_priors import typical_rate_Nm_per_s
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded


def note_on_rates(tables: Sequence[Readings]) -> Iterator[str]:
    """What levels that were loaded at unlike rates may show beside a change. Runs to like torques
    are compared: a level may have more of the slow ones."""
    kinds = [_rates(readings) for readings in tables]
    pairs = (
        sorted((one[kind], other[kind]))
        for one, other in combinations(kinds, 2)
        for kind in one.keys() & other.keys()
    )
    slow, fast = max(pairs, key=lambda pair: pair[1] / pair[0], default=(1.0, 1.0))
    if fast > RATES * slow:
        yield (
            f"the torque changes at {rounded(slow)} to {rounded(fast)} N m/s from level to level "
            "in runs to the same torque: an instrument that lags, and friction or creep that "
            "depends on the rate, look like a change of friction then. Measure all levels at one "
            "rate"
        )


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
