"""How strong an effect is in a campaign: what is left of it once everything free is refitted.

The strength d is the whitened norm of what it adds to the readings. With y the change of the
angle, C the covariance of the noise, J the slopes of the angle by the free numbers and P their
prior variances,

    d^2 = min over p of |C^(-1/2) (y - J p)|^2 + p' P^-1 p = y' (C + J P J')^-1 y.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from reference.contact import Floats
from reference.forward import Drive
from reference.rig import ARCSEC, Rows, simulate
from reference.rig.effects import LIBRARY, Hidden
from reference.rig.instrument import Instrument
from reference.rig.mesh import NotHeldError
from reference.rig.noise import Noise

PARAMETERS = {
    "contact_stiffness_rel": "contact_stiffness",
    "contact_angle_deg": "contact_angle",
    "torque_gain_rel": "torque_scale",
    "preload_gain_rel": "preload_scale",
    "sensor_gain_rel": "sensor_gain",
}
ZERO_PRIOR_RAD = 1e4 * ARCSEC


class NoSuchCampaignError(ValueError):
    """This drive, plan and effect do not come together at the strength asked for.

    noise_factor: what the noise would have to be multiplied by, roughly, for a better chance.
    """

    def __init__(self, message: str, noise_factor: float) -> None:
        self.noise_factor = noise_factor
        super().__init__(message)


# --- what is free -----------------------------------------------------------------------------


def parameter_effect(name: str, shift: float) -> Hidden:
    """A number of the drive off nominal by shift: of its logarithm, or degrees of the angle."""
    kind = LIBRARY[PARAMETERS[name]]
    value = np.deg2rad(shift) if name == "contact_angle_deg" else np.exp(shift)
    return Hidden(kind, {kind.size: float(value)})


def draw_parameters(rng: np.random.Generator, priors: dict[str, float]) -> dict[str, float]:
    """Shifts from the stated priors, cut at two standard deviations."""
    shifts = {}
    for name, sigma in priors.items():
        z = rng.standard_normal()
        while abs(z) > 2:
            z = rng.standard_normal()
        shifts[name] = sigma * float(z)
    return shifts


@dataclass(frozen=True)
class Yardstick:
    """Measures d on one table.

    slopes_rad: of the angle by each free number, for one standard deviation of its prior. factors:
    Cholesky factors of the noise (zeros included) and of C + J P J'.
    """

    drive: Drive
    rows: Rows
    base: tuple[Hidden, ...]
    priors: dict[str, float]
    angle_rad: Floats
    slopes_rad: Floats
    factors: tuple[Floats, Floats]

    @classmethod
    def of(
        cls,
        drive: Drive,
        rows: Rows,
        base: tuple[Hidden, ...],
        noise: Noise | Instrument,
        priors: dict[str, float],
        zero_per_run: bool = False,
    ) -> Yardstick:
        """With the parameters, and one zero or one for each run, free within their priors."""
        angle = simulate(drive, rows, base)
        columns = []
        for name, sigma in priors.items():
            step = 0.02 * sigma
            moved = simulate(drive, rows, (*base, parameter_effect(name, step)))
            columns.append((moved - angle) / step * sigma)
        slopes = np.column_stack(columns)
        same = rows.run[:, None] == rows.run[None, :] if zero_per_run else True
        covariance = noise.covariance(rows) + ZERO_PRIOR_RAD**2 * np.where(same, 1.0, 0.0)
        both = (covariance, covariance + slopes @ slopes.T)
        first, second = (np.asarray(cholesky(c, lower=True)) for c in both)
        return cls(drive, rows, base, priors, angle, slopes, (first, second))

    def whiten(self, change_rad: Floats) -> Floats:
        """What is left of a change of the angle after refitting, in standard deviations."""
        return np.asarray(solve_triangular(self.factors[1], change_rad, lower=True))

    def left(self, effect: Hidden) -> Floats:
        """The same for an effect, by solving the drive with it."""
        return self.whiten(simulate(self.drive, self.rows, (*self.base, effect)) - self.angle_rad)

    def strength(self, effect: Hidden) -> float:
        """d of an effect as it is; nan where the preload would not hold the torque any more.

        Where a prior is moved by more than half a standard deviation the drive is solved anew at
        every step of the refit, since a knee that moves is not linear.
        """
        try:
            target = simulate(self.drive, self.rows, (*self.base, effect))
        except (NotHeldError, ArithmeticError):
            return float("nan")
        return self._refitted(target)

    def _model(self, moved: Floats) -> Floats:
        """The angle (rad) with every free number moved, in standard deviations; nan if not held."""
        shifts = zip(self.priors.items(), moved, strict=True)
        numbers = [parameter_effect(n, s * float(m)) for (n, s), m in shifts]
        try:
            return simulate(self.drive, self.rows, (*self.base, *numbers))
        except (NotHeldError, ArithmeticError):
            return np.full(len(self.rows), np.nan)

    def _slopes(self, moved: Floats, model: Floats) -> Floats:
        """Of the whitened angle by each free number where they are; one-sided, small steps."""
        columns = []
        for i in range(len(moved)):
            for step in (0.02, -0.02):
                other = moved.copy()
                other[i] += step
                there = self._model(other)
                if np.isfinite(there).all():
                    columns.append((there - model) / step)
                    break
            else:
                columns.append(np.zeros_like(model))
        return self._white(np.column_stack(columns))

    def _white(self, x: Floats) -> Floats:
        return np.asarray(solve_triangular(self.factors[0], x, lower=True))

    def _refitted(self, target_rad: Floats) -> float:
        """Square root of the smallest sum of squares, priors included, that a refit leaves.

        Gauss-Newton, damped where a step makes matters worse. The slopes are found anew at every
        step: the knee moves with the numbers, and Broyden's rule was caught in its bent valley.
        Where the first step is long, the number that moves the knee is looked through first.
        """
        j, one = self._white(self.slopes_rad), np.eye(self.slopes_rad.shape[1])
        moved, left = np.zeros(len(one)), self._white(target_rad - self.angle_rad)
        found, damping = float(left @ left), 0.0
        for _ in range(12):
            curvature, pull = one + j.T @ j, j.T @ left - moved
            step = np.linalg.solve(curvature, pull)
            hoped = float(np.sum((left - j @ step) ** 2) + np.sum((moved + step) ** 2))
            if np.abs(step).max() < 0.5 and (hoped > 0.98 * found or not moved.any()):
                return float(np.sqrt(hoped))
            if not moved.any():
                best = self._looked_through(target_rad, found)
                if best is not None:
                    moved, left, found, j = best
                    continue
            for _ in range(8):
                step = np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), pull)
                step *= min(1.0, 4.0 / float(np.abs(step).max()))
                model = self._model(moved + step)
                if not np.isfinite(model).all():
                    damping = max(10 * damping, 1e-3)
                    continue
                trial = self._white(target_rad - model)
                value = float(trial @ trial + np.sum((moved + step) ** 2))
                if value < found:
                    moved, left, found = moved + step, trial, value
                    damping = damping / 10 if damping > 1e-4 else 0.0
                    break
                damping = max(10 * damping, 1e-3)
            else:
                break
            j = self._slopes(moved, model)
        return float(np.sqrt(found))

    def _looked_through(
        self, target_rad: Floats, found: float
    ) -> tuple[Floats, Floats, float, Floats] | None:
        """Where the preload's gain alone leaves least, if that is less than `found`."""
        names = list(self.priors)
        if "preload_gain_rel" not in names:
            return None
        best = None
        for sigmas in np.r_[-4:4.1:0.5]:
            moved = np.zeros(len(names))
            moved[names.index("preload_gain_rel")] = sigmas
            model = self._model(moved)
            if np.isfinite(model).all():
                left = self._white(target_rad - model)
                value = float(left @ left + moved @ moved)
                if value < found:
                    found, best = value, (moved, left, value, model)
        return None if best is None else (*best[:3], self._slopes(best[0], best[3]))

    def sized(self, effect: Hidden, d: float, tolerance: float = 0.02) -> Hidden:
        """The effect at the size that leaves d, within its range."""
        kind = effect.kind
        sign = np.copysign(1.0, effect.size - kind.neutral)
        most = abs(kind.high - kind.neutral) if sign > 0 else abs(kind.low - kind.neutral)
        most = abs(kind.high) if kind.signed else most
        low, high = 0.0, most
        size = min(max(abs(effect.size - kind.neutral), 0.01 * most), 0.3 * most)
        for _ in range(24):
            trial = effect.sized(float(kind.neutral + sign * size))
            got = self.strength(trial)
            if abs(got / d - 1) <= tolerance:
                return trial
            if np.isnan(got) or got > d:
                high = size
            else:
                low = size
            guess = size * d / got if got > 0 else (low + high) / 2
            inside = low + 0.02 * (high - low) < guess < high - 0.02 * (high - low)
            if not inside:
                steep = guess <= low if low > 0 else guess < 0.02 * high
                guess = guess if steep and guess > low else (low + high) / 2
            if size >= most * 0.999 and got < d:
                break
            if low >= 0.98 * most or (high - low) < 3e-3 * high:
                break
            size = float(guess)
        raise NoSuchCampaignError(f"{effect.id}: d = {d:g} is beyond its range here", 0.5)
