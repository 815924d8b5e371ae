"""An instrument whose parts of noise add up, with artefacts of its own and a display.

    Instrument  what a reading goes through: noise, zeros, drift, display, and the torque column
    instrument  one of a kind, with sizes drawn in standard uncertainties of a reading
    noise_of    the noise of a campaign from its truth, of this kind or of noise.py

`Noise` has one imperfection at a time; here they come together: zeros of runs and correlation, and
both behind a coarse display. ARTEFACTS are things that instruments do and that are no physics of
the drive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from reference.contact import Floats
from reference.rig.bench import ARCSEC, Rows
from reference.rig.noise import NOISE_KINDS, Noise, draw_noise

TOGETHER = "zeros_correlated"
COARSE = ("coarse_zeros", "coarse_correlated", "coarse_both")
ARTEFACTS = (
    "random_walk",
    "encoder",
    "first_reading",
    "torque_display",
    "torque_hysteresis",
    "torque_zero",
)
KINDS = (*NOISE_KINDS, TOGETHER, *COARSE, *ARTEFACTS)
ZEROS = ("run_offset", TOGETHER, "coarse_zeros", "coarse_both")
"""Kinds in which every run has a zero of its own."""


@dataclass(frozen=True)
class Instrument:
    """White noise of u_rad, of which AR(1) correlation from one reading of a run to the next, and:

    offset_rad: spread of the zeros of runs. display_rad: step of the angle's display. walk_rad:
    standard deviation that a random walk in absolute time has reached at the end. ripple_rad,
    period_rad: an interpolation error of the encoder, a sine of the angle that is read.
    first_rad: what the first reading of every run is off by. torque_step_Nm: step of the torque's
    display. torque_lag_Nm: half the width of the loop that the torque's reading describes.
    torque_zero_Nm: what the torque reads where there is none.
    """

    kind: str
    u_rad: float
    stated_u_rad: float
    offset_rad: float = 0.0
    correlation: float = 0.0
    display_rad: float = 0.0
    walk_rad: float = 0.0
    ripple_rad: float = 0.0
    period_rad: float = 1.0
    first_rad: float = 0.0
    torque_step_Nm: float = 0.0
    torque_lag_Nm: float = 0.0
    torque_zero_Nm: float = 0.0

    def covariance(self, rows: Rows) -> Floats:
        """Covariance of the readings (rad^2); of a display the variance of its rounding."""
        same_run = rows.run[:, None] == rows.run[None, :]
        place = np.arange(len(rows))
        apart = np.abs(place[:, None] - place[None, :])
        inside = np.where(same_run, np.power(self.correlation, apart), 0.0)
        shown = self.display_rad**2 / 12 * np.eye(len(rows))
        t = self._share_of_time(rows)
        walk = self.walk_rad**2 * np.minimum(t[:, None], t[None, :])
        return np.asarray(self.u_rad**2 * inside + self.offset_rad**2 * same_run + shown + walk)

    def readings(self, angle_rad: Floats, rows: Rows, rng: np.random.Generator) -> Floats:
        """What is read where the angle is angle_rad."""
        n = len(rows)
        x = rng.standard_normal(n)
        for i in range(1, n):
            if rows.run[i] == rows.run[i - 1]:
                x[i] = self.correlation * x[i - 1] + np.sqrt(1 - self.correlation**2) * x[i]
        runs, back = np.unique(rows.run, return_inverse=True)
        zeros = self.offset_rad * rng.standard_normal(len(runs))
        passed = np.diff(self._share_of_time(rows), prepend=0.0)
        walk = self.walk_rad * np.cumsum(np.sqrt(passed) * rng.standard_normal(n))
        first = self.first_rad * (rows.starts == np.arange(n))
        out = angle_rad + self.u_rad * x + zeros[back] + walk + first
        phase = rng.uniform(0, 2 * np.pi)
        out = out + self.ripple_rad * np.sin(2 * np.pi * out / self.period_rad + phase)
        return _rounded(out, self.display_rad)

    def loads(self, planned: Rows, rng: np.random.Generator) -> tuple[Rows, Rows]:
        """The rows as they really were and as the torque column shows them.

        Behind a display the torque lies anywhere within half a step. A transducer that lags reads
        less than there is while the torque rises and more while it falls, by torque_lag_Nm once
        the torque has turned by twice that.
        """
        real, shown = planned.torque_Nm, planned.torque_Nm
        if self.torque_step_Nm > 0:
            inside = self.torque_step_Nm * rng.uniform(-0.5, 0.5, len(planned))
            at_start = planned.starts == np.arange(len(planned))
            shown = _rounded(shown, self.torque_step_Nm)
            real = np.where(at_start, shown, shown + 0.999 * inside)
        if self.torque_lag_Nm > 0:
            real = real + _play(real, planned, self.torque_lag_Nm)
        real = real - self.torque_zero_Nm
        return replace(planned, torque_Nm=real), replace(planned, torque_Nm=shown)

    @staticmethod
    def _share_of_time(rows: Rows) -> Floats:
        t = rows.time_s - rows.time_s[0]
        return np.asarray(t / max(float(t.max()), 1e-9))


def _rounded(x: Floats, step: float) -> Floats:
    return np.asarray(step * np.round(x / step) + 0.0) if step > 0 else np.asarray(x)


def _play(torque_Nm: Floats, rows: Rows, lag_Nm: float) -> Floats:
    """How far a reading with play stays behind: 0 at a run's start, then between -lag and lag."""
    out, behind = np.zeros(len(rows)), 0.0
    for i in range(len(rows)):
        if rows.starts[i] == i:
            behind = 0.0
        else:
            behind = float(np.clip(behind + torque_Nm[i] - torque_Nm[i - 1], -lag_Nm, lag_Nm))
        out[i] = behind
    return out


def instrument(
    kind: str, u_rad: float, compliance_rad_per_Nm: float, rng: np.random.Generator
) -> Instrument | Noise:
    """One of a kind: zeros of 1 to 4 u, correlation 0.4 to 0.8, display 1.7 to 2 u, artefacts that
    move a reading by 2 to 6 u where the drive turns by compliance_rad_per_Nm."""
    if kind in NOISE_KINDS:
        return draw_noise(kind, u_rad, rng)
    plain = Instrument(kind, u_rad, u_rad)
    zeros = u_rad * float(rng.uniform(1.0, 4.0))
    correlation = float(rng.uniform(0.4, 0.8))
    display = u_rad * float(rng.uniform(1.7, 2.0))
    size = u_rad * float(rng.uniform(2.0, 6.0))
    torque = size / max(compliance_rad_per_Nm, 1e-12)
    parts: dict[str, dict[str, Any]] = {
        TOGETHER: {"offset_rad": zeros, "correlation": correlation},
        "coarse_zeros": {"offset_rad": zeros, "display_rad": display},
        "coarse_correlated": {"correlation": correlation, "display_rad": display},
        "coarse_both": {"offset_rad": zeros, "correlation": correlation, "display_rad": display},
        "random_walk": {"walk_rad": size},
        "encoder": {"ripple_rad": size / 2, "period_rad": float(rng.uniform(8, 20)) * ARCSEC},
        "first_reading": {"first_rad": size * float(rng.choice([-1.0, 1.0]))},
        "torque_display": {"torque_step_Nm": torque},
        "torque_hysteresis": {"torque_lag_Nm": torque / 2},
        # Most of it is a common zero of the angle.
        "torque_zero": {"torque_zero_Nm": 2 * torque},
    }
    return replace(plain, **parts[kind])


def plain_values(noise: Instrument | Noise) -> dict[str, Any]:
    """The noise as it stands in the truth of a campaign, from which noise_of makes it again."""
    return {
        "kind": noise.kind,
        "u_arcsec": noise.u_rad / ARCSEC,
        "stated_u_arcsec": noise.stated_u_rad / ARCSEC,
        "run_offset_arcsec": noise.offset_rad / ARCSEC,
        "parts": asdict(noise),
    }


def noise_of(truth: Mapping[str, Any]) -> Instrument | Noise:
    """The noise that a truth tells."""
    if truth["kind"] not in NOISE_KINDS:
        return Instrument(**truth["parts"])
    return Noise(
        truth["kind"],
        truth["u_arcsec"] * ARCSEC,
        truth["stated_u_arcsec"] * ARCSEC,
        truth["run_offset_arcsec"] * ARCSEC,
    )
