"""Friction torques that remember where they were, one entry for each run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from reference.contact import Floats


@dataclass(frozen=True)
class Dahl:
    """dT/da = (T0/a_p) |1 - s T/T0|^power with s the sense of turning: a bristle that bends.

    power 1 is the common form, T = s T0 - (s T0 - T_before) exp(-|way|/a_p); below 1 it saturates
    sooner. rising > 0 adds a part of T0 that grows with the logarithm of the rate, as a lubricant
    may.
    """

    length_rad: float
    power: float = 1.0
    rising: float = 0.0

    def begin(self, limit_Nm: Floats) -> tuple[Floats, Floats]:
        """Torque of the bristle and its limit."""
        return np.zeros_like(limit_Nm), limit_Nm

    def torque(self, memory: Any, way_rad: Floats, rate_rad_per_s: Floats) -> tuple[Floats, Floats]:
        """Friction torque after the way and its slope by the way."""
        before, limit = memory
        limit = limit * (1 + self.rising * np.log1p(np.abs(rate_rad_per_s) / 1e-6))
        safe = np.where(limit > 0, limit, 1.0)
        sense = np.where(way_rad < 0, -1.0, 1.0)
        x = np.abs(way_rad) / self.length_rad
        left = 1 - sense * before / safe  # how far from slipping: 2 at a reversal, 0 slipping
        left = np.maximum(left, 0.0)
        if self.power == 1.0:
            after = left * np.exp(-x)
        else:  # d left/dx = -left^p, which ends in a finite way for p < 1
            rest = np.maximum(left ** (1 - self.power) - (1 - self.power) * x, 0.0)
            after = rest ** (1 / (1 - self.power))
        value = sense * limit * (1 - after)
        slope = limit / self.length_rad * after**self.power
        off = limit <= 0
        return np.where(off, 0.0, value), np.where(off, 0.0, slope)

    def step(self, memory: Any, way_rad: Floats, rate_rad_per_s: Floats) -> Any:
        """The bristle after the way."""
        return self.torque(memory, way_rad, rate_rad_per_s)[0], memory[1]


DAHL = Dahl(1.0)


@dataclass(frozen=True)
class Iwan:
    """Springs in parallel, each slipping at its own torque: a loop that closes (Masing).

    Element j of J slips after the way y_j, the quantiles of an exponential distribution of mean
    a_p, so the virgin curve is that of Dahl, T0 (1 - exp(-a/a_p)), in J straight pieces.
    """

    length_rad: float
    count: int = 12

    @property
    def _slip_ways_rad(self) -> Floats:
        share = (np.arange(self.count) + 0.5) / self.count
        return np.asarray(-self.length_rad * np.log1p(-share))

    def begin(self, limit_Nm: Floats) -> tuple[Floats, Floats]:
        """Stretch of every spring (run, element) and the limit."""
        return np.zeros((len(limit_Nm), self.count)), limit_Nm

    def torque(self, memory: Any, way_rad: Floats, rate_rad_per_s: Floats) -> tuple[Floats, Floats]:
        """Friction torque after the way and its slope by the way."""
        stretch, limit = memory
        ways = self._slip_ways_rad
        after = stretch + way_rad[:, None]
        stuck = np.abs(after) < ways
        pull = np.clip(after, -ways, ways) / ways
        share = limit / self.count
        return share * pull.sum(axis=1), share * (stuck / ways).sum(axis=1)

    def step(self, memory: Any, way_rad: Floats, rate_rad_per_s: Floats) -> Any:
        """Stretches after the way; a spring that slips keeps its limit."""
        ways = self._slip_ways_rad
        return np.clip(memory[0] + way_rad[:, None], -ways, ways), memory[1]
