"""Torque ramps on a spring and on a drive with balls, and the angles that effects make of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbpt import Drive, _core
from common.rings import RINGS

Floats = NDArray[np.float64]
STIFFNESS = 2000.0
SPRING = Drive.from_dict({"torsion_spring": {"torsional_stiffness_Nm_per_rad": STIFFNESS}})
BALLS = Drive.from_dict(RINGS)


def predictor(
    drive: Drive, effects: list[str], torque_Nm: Floats, step_s: float = 1.0
) -> _core.Predictor:
    n = len(torque_Nm)
    return _core.Predictor(
        drive,
        effects,
        np.zeros(n, dtype=np.int64),
        step_s * np.arange(n, dtype=np.float64),
        torque_Nm,
        np.full(n, 600.0) if drive is BALLS else None,
        np.zeros(n),
        None,
        None,
    )


def values_of(found: _core.Predictor, numbers: dict[str, dict[str, float]]) -> Floats:
    values = found.neutral()
    for i, (_, effect, parameter) in enumerate(found.parameters):
        values[i] = numbers.get(effect, {}).get(parameter.name, values[i])
    return values


def angles(
    drive: Drive, numbers: dict[str, dict[str, float]], torque_Nm: Floats, step_s: float = 1.0
) -> Floats:
    found = predictor(drive, list(numbers), torque_Nm, step_s)
    prediction = found.predict(values_of(found, numbers))
    assert prediction.solved.all()
    return np.asarray(prediction.angle_rad)


def check_sensitivities(found: _core.Predictor, values: Floats) -> None:
    """Those by all numbers that are not 0 are the differences of the predicted angles."""
    wanted = [i for i in range(len(values)) if values[i] != 0.0]
    exact = found.predict(values, wanted).sensitivities
    for column, i in enumerate(wanted):
        h = 1e-5 * values[i]
        up, down = values.copy(), values.copy()
        up[i], down[i] = values[i] + h, values[i] - h
        difference = (found.predict(up).angle_rad - found.predict(down).angle_rad) / (2 * h)
        size = np.abs(difference).max()
        np.testing.assert_allclose(exact[:, column], difference, rtol=1e-4, atol=1e-5 * size)


def ramp(*ends: float, steps: int = 400) -> Floats:
    """From one end to the next in even steps, the first being 0."""
    legs = [np.linspace(a, b, steps + 1)[1:] for a, b in zip((0.0, *ends), ends, strict=False)]
    return np.concatenate([np.zeros(1), *legs]).astype(np.float64)
