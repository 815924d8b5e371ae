"""What an instrument adds to a reading, and the covariance an honest analysis would use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from reference.contact import Floats
from reference.rig.bench import Rows

NoiseKind = Literal[
    "white", "correlated", "run_offset", "heavy_tailed", "outliers", "misstated", "quantised"
]
NOISE_KINDS: tuple[NoiseKind, ...] = get_args(NoiseKind)
CORRELATION = 0.6
OUTLIER_SHARE = 0.02


@dataclass(frozen=True)
class Noise:
    """Noise of one kind with standard deviation u_rad; the table states stated_u_rad.

    correlated: AR(1) with 0.6 from one reading to the next within a run. run_offset: white, and a
    zero for each run with the spread offset_rad. heavy_tailed: Student t with 3 degrees of
    freedom, scaled so that its standard deviation is u_rad. outliers: 2 % of the readings are off
    by a further 8 to 20 u_rad. misstated: white, stated 30 % too small or too large. quantised:
    white of u_rad / 2, then rounded to steps of 3 u_rad, so that both together come to u_rad.
    """

    kind: NoiseKind
    u_rad: float
    stated_u_rad: float
    offset_rad: float = 0.0

    @property
    def step_rad(self) -> float:
        """Step of the display; 0 without one."""
        return 3.0 * self.u_rad if self.kind == "quantised" else 0.0

    def covariance(self, rows: Rows) -> Floats:
        """Covariance of the readings (rad^2), outliers left aside."""
        same_run = rows.run[:, None] == rows.run[None, :]
        out = np.eye(len(rows))
        if self.kind == "correlated":
            place = np.arange(len(rows))
            out = np.where(same_run, CORRELATION ** np.abs(place[:, None] - place[None, :]), 0.0)
        return np.asarray(self.u_rad**2 * out + self.offset_rad**2 * same_run)

    def readings(self, angle_rad: Floats, rows: Rows, rng: np.random.Generator) -> Floats:
        """What is read where the angle is angle_rad."""
        n = len(rows)
        white = rng.standard_normal(n)
        if self.kind == "correlated":
            for i in range(1, n):
                if rows.run[i] == rows.run[i - 1]:
                    fresh = np.sqrt(1 - CORRELATION**2) * white[i]
                    white[i] = CORRELATION * white[i - 1] + fresh
        elif self.kind == "heavy_tailed":
            white = rng.standard_t(3, n) / np.sqrt(3.0)
        elif self.kind == "outliers":
            hit = rng.random(n) < OUTLIER_SHARE
            hit[rng.integers(n)] = True
            white = white + hit * rng.choice([-1.0, 1.0], n) * rng.uniform(8, 20, n)
        elif self.kind == "quantised":
            white = white * 0.5
        runs, back = np.unique(rows.run, return_inverse=True)
        zeros = self.offset_rad * rng.standard_normal(len(runs))
        out = angle_rad + self.u_rad * white + zeros[back]
        if self.step_rad > 0:
            out = self.step_rad * np.round(out / self.step_rad) + 0.0
        return np.asarray(out)


def draw_noise(kind: NoiseKind, u_rad: float, rng: np.random.Generator) -> Noise:
    """Noise of a kind: an offset of 1 to 4 u where runs have their own zero, u off by 30 %."""
    stated = u_rad
    if kind == "misstated":
        stated = u_rad * float(rng.choice([0.7, 1.3]))
    offset = u_rad * float(rng.uniform(1.0, 4.0)) if kind == "run_offset" else 0.0
    return Noise(kind, u_rad, stated, offset)
