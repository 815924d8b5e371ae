"""Whether the scatter of the readings changed.

NoiseChange    the scatter of each level, and the probability that it is not one and the same
noise_change   from what the levels' fits leave

What a model does not follow is left beside the scatter, and changes with what changed. It is smooth
along a run but for few places: so the scatter is what half of the readings differ by from the
middle of their neighbours. Neighbours further apart see more of its bend, so levels whose torques
go in other steps are not compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.covariance.within_run import behind_display, display_step
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]

_SPREAD = 0.7
"""Standard deviation, in the logarithm, of a scatter that did change: a factor of 2."""
_ODDS = 0.1
"""Prior odds that it did."""
_OWN = 0.37 * 36 / 70
"""How many readings without correlation tell their scatter as well as one second difference
y_1 - 2 y_2 + y_3, whose covariances are as 6, -4 and 1: 6^2/(6^2 + 2 (4^2 + 1^2)); of that 0.37, as
the median of sizes tells less than their mean square."""
_STEPS = 1.5
"""Factor from which the steps of the torque are not those of another level."""


@dataclass(frozen=True)
class NoiseChange:
    """The scatter of each level."""

    u_arcsec: tuple[float, ...]
    """Standard deviation of a reading, beside its neighbours."""
    probability: float
    """That they are not all the same."""

    @property
    def changed(self) -> bool:
        """Whether that is as good as certain."""
        return self.probability >= 0.95

    def to_dict(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "changed": self.changed,
            "probability": self.probability,
            "u_arcsec": list(self.u_arcsec),
        }


def noise_change(readings: Sequence[Readings], fits: Sequence[Fit]) -> NoiseChange:
    """Normal in the logarithm of the scatter, with as many readings as correlation leaves."""
    told = [
        behind_display(*_scatter(r, _left(fit)), display_step(r.elastic_angle_arcsec))
        for r, fit in zip(readings, fits, strict=True)
    ]
    size = [arcsec for arcsec, _, _ in told]
    # A sample of what is not quite normal knows its spread half as well.
    v = np.array([1 / max(freedom, 2.0) for _, freedom, _ in told])
    log = np.log(np.maximum(size, 1e-300))

    def evidence(extra: float) -> float:
        """Of one mean, on which all levels scatter by `extra` beside their own variance."""
        w = 1 / (v + extra)
        mean = float(w @ log / w.sum())
        return float(0.5 * np.sum(np.log(w)) - 0.5 * np.log(w.sum()) - 0.5 * w @ (log - mean) ** 2)

    steps = [_step(r) for r in readings]
    alike = max(steps) <= _STEPS * min(steps)
    gained = min(evidence(_SPREAD**2) - evidence(0.0), 500.0) if alike else 0.0
    odds = _ODDS * np.exp(gained)
    return NoiseChange(tuple(size), float(odds / (1 + odds)))


def _step(readings: Readings) -> float:
    """Typical step of the torque along the runs, N m."""
    steps = np.concatenate([np.abs(np.diff(t)) for t in _of_runs(readings, readings.torque_Nm)])
    return float(np.median(steps)) if len(steps) else 0.0


def _of_runs(readings: Readings, values: Floats) -> list[Floats]:
    """Values of the readings, run by run."""
    order = np.argsort(readings.run_index, kind="stable")
    ends = np.flatnonzero(np.diff(readings.run_index[order])) + 1
    return np.split(values[order], ends)


def _left(fit: Fit) -> Floats:
    """What a fit leaves, arcsec; of a reading that was inflated, the share that it would have."""
    inflation = fit.noise.inflation
    return fit.residual_arcsec if inflation is None else fit.residual_arcsec / inflation


def _scatter(readings: Readings, left_arcsec: Floats) -> tuple[float, float]:
    """Scatter from second differences along the runs, and how many readings tell it; of all
    readings where half of them bend nowhere."""
    runs = _of_runs(readings, left_arcsec)
    size = neighbour_scatter(runs, 2)
    if size > 0:
        return size, _OWN * sum(max(len(run) - 2, 0) for run in runs)
    return float(np.sqrt(np.mean(left_arcsec**2))), float(len(left_arcsec))
