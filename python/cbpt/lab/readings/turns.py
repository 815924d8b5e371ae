"""Where a torque turns back.

turns_of   rows of the turns, however much the torque scatters along its way
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def turns_of(torque_Nm: NDArray[np.float64], least_Nm: float) -> list[int]:
    """Rows at which a torque, shape (n,) in the order of time, turns back by more than so much,
    with its first and its last extreme; none where it changes by less."""
    if not len(torque_Nm):
        return []
    found: list[int] = []
    way, extreme, low, high = 0, 0, 0, 0
    for i, value in enumerate(torque_Nm.tolist()):
        if way == 0:
            low = i if value < torque_Nm[low] else low
            high = i if value > torque_Nm[high] else high
            if value - torque_Nm[low] > least_Nm or torque_Nm[high] - value > least_Nm:
                way = 1 if value - torque_Nm[low] > least_Nm else -1
                found, extreme = [low if way > 0 else high], i
        elif way * (value - torque_Nm[extreme]) >= 0:
            extreme = i
        elif way * (torque_Nm[extreme] - value) > least_Nm:
            found.append(extreme)
            way, extreme = -way, i
    return [*found, extreme] if found else []
