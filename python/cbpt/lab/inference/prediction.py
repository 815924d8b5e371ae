"""The elastic angle of the drive at loads of choice, with its uncertainty.

    Load           the loads that are asked for
    AtLoad         the angles, as arrays
    angle_at       what a fit says of them
    around_loop    the same along one loop of the torque, both ways
    load_of_choice the load that a user states, completed from the case

The drive itself is asked: under the torque and preload that act, whatever the instruments make of
them, so effects of class `rig` and offsets are left out. A load is that of a fresh run: reached
from rest in one go, at the median temperature of the readings, with no time passed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError
from cbpt.lab.covariance.linear_gaussian import Rows
from cbpt.lab.inference.budget import TABLE, Budget, Combined
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.priors import CLASSES
from cbpt.lab.model.table_curve import curve_errors
from cbpt.lab.readings.reader import Readings
from cbpt.results import loads_of

Floats = NDArray[np.float64]

_POINTS = 81
"""Torques of one leg of a loop."""
_CYCLE_S = 60.0


@dataclass(frozen=True, eq=False)
class Load:
    """Loads of choice, in N m, N and degrees; they broadcast against each other."""

    torque_Nm: ArrayLike
    preload_N: ArrayLike | None = None
    input_angle_deg: ArrayLike = 0.0

    def arrays(self, drive: Drive) -> tuple[Floats, Floats, Floats]:
        """Torque, preload and input angle, each of shape (n,); a preload of NaN where a torsion
        spring has none. Raises `InvalidInputError` for a load that cannot be.
        """
        spring = drive.kind == "torsion_spring" and self.preload_N is None
        preload = 1.0 if spring else self.preload_N
        torque, preload, angle = _checked(self.torque_Nm, preload, self.input_angle_deg)
        return torque, np.full(len(torque), np.nan) if spring else preload, angle


@dataclass(frozen=True, eq=False)
class AtLoad:
    """The drive under n loads. Arrays have shape (n,)."""

    torque_Nm: Floats
    preload_N: Floats
    """NaN for a torsion spring without one."""
    input_angle_deg: Floats
    elastic_angle_arcsec: Floats
    """NaN where there is no solution."""
    u_elastic_angle_arcsec: Floats
    """Standard uncertainty (k = 1), the model taken for right; NaN where there is none."""
    status: NDArray[np.str_]
    """As in `Angles`."""
    inside: NDArray[np.bool_]
    """Whether torque and preload lie within those of the readings; else it is extrapolated."""
    why_no_u: str | None
    """Where there is no uncertainty at all."""
    by_rival_arcsec: dict[str, Floats]
    """The angle that each rival of the answer gives, by the effects of that rival."""
    parts: tuple[Combined | None, ...] = field(default=(), repr=False)
    """The budget of each uncertainty."""
    gradients: Floats = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    """By the unknowns of the budget, shape (n, p)."""


def angle_at(
    fitter: Fitter,
    fit: Fit,
    load: Load,
    *,
    why_no_u: str | None = None,
    rivals: Mapping[str, Fit] | None = None,
) -> AtLoad:
    """What a fit and its rivals say of the loads; `why_no_u` where no uncertainty can be given.

    Raises `InvalidInputError` for a load that cannot be.
    """
    torque, preload, input_angle = load.arrays(fitter.campaign.drive)
    drive = _DriveAlone(fitter, _fresh(fitter.campaign.readings, torque, preload, input_angle))
    budget = Budget.of(fitter, fit)
    angle, gradients = drive.angle(fit, budget)
    u_curve = _of_the_curve(fitter.campaign, torque)
    parts = tuple(
        part.beside(TABLE, float(u))
        if ok and why_no_u is None and (part := budget.combined(g)) is not None
        else None
        for g, ok, u in zip(gradients, np.isfinite(angle), u_curve, strict=True)
    )
    return AtLoad(
        torque_Nm=torque,
        preload_N=preload,
        input_angle_deg=input_angle,
        elastic_angle_arcsec=angle,
        u_elastic_angle_arcsec=np.array([np.nan if p is None else p.u for p in parts]),
        status=drive.model.states(drive.values(fit))[1],
        inside=_inside(fitter.campaign.readings, torque, preload),
        why_no_u=why_no_u,
        by_rival_arcsec={
            name: drive.model.at(drive.values(rival)).angle_arcsec
            for name, rival in (rivals or {}).items()
        },
        parts=parts,
        gradients=gradients,
    )


def around_loop(fitter: Fitter, fit: Fit, load: Load) -> tuple[Floats, Floats, Floats]:
    """Torques, elastic angles and their standard uncertainties in arcsec, each of shape (n,), along
    a loop from the load's torque down to its opposite and up again; NaN where there is none.

    Raises `InvalidInputError` for a load that cannot be.
    """
    most, preload, input_angle = (float(a[0]) for a in load.arrays(fitter.campaign.drive))
    half = np.linspace(0.0, abs(most) or 1.0, _POINTS // 2 + 1)
    down, up = np.r_[half[-2::-1], -half[1:]], np.r_[-half[-2::-1], half[1:]]
    torque = np.r_[half, down, up, down, up]
    n = len(torque)
    rows = _fresh(fitter.campaign.readings, torque, np.full(n, preload), np.full(n, input_angle))
    time = np.r_[0.0, np.cumsum(np.abs(np.diff(torque)))] * _CYCLE_S / (4 * half[-1])
    rows = replace(rows, run=np.zeros(n, dtype=int), time_s=None if rows.time_s is None else time)
    budget = Budget.of(fitter, fit)
    angle, gradients = _DriveAlone(fitter, rows).angle(fit, budget)
    square = np.einsum("ij,jk,ik->i", gradients, budget.covariance, gradients)
    square += _of_the_curve(fitter.campaign, torque) ** 2
    u = np.where(np.isfinite(angle), np.sqrt(np.maximum(square, 0.0)), np.nan)
    last = slice(n - 2 * _POINTS + 1, None)
    return torque[last], angle[last], u[last]


def _of_the_curve(campaign: Campaign, torque_Nm: Floats) -> Floats:
    """Standard uncertainty by what the table of the case leaves open, arcsec, whatever the readings
    tell of it."""
    columns = curve_errors(campaign.drive, torque_Nm)
    return np.zeros(len(torque_Nm)) if columns is None else np.linalg.norm(columns, axis=1)


class _DriveAlone:
    """The model of a fitter under other loads, its instruments left out."""

    def __init__(self, fitter: Fitter, readings: Readings) -> None:
        self.model = Assembled(_campaign_of(fitter.campaign, readings), fitter.effects)
        self._instrument = np.zeros(len(self.model.nothing), dtype=bool)
        for (instance, _), place in self.model.places.items():
            effect = self.model.effects[instance]
            own = fitter.campaign.own.get(effect)
            self._instrument[place] = (
                CLASSES[effect] == "rig" if own is None else own.port == "reading"
            )

    def values(self, fit: Fit) -> Floats:
        """Of a fit, those of the instruments at nothing."""
        return np.where(self._instrument, self.model.nothing, fit.point.values)

    def angle(self, fit: Fit, budget: Budget) -> tuple[Floats, Floats]:
        """Angles in arcsec, shape (n,), and their slopes by the unknowns of the budget, (n, p)."""
        point = self.model.at(self.values(fit), [u.index for u in fit.unknowns])
        log = np.array([fit.value(u) if u.log else 1.0 for u in fit.unknowns])
        own = np.array([not self._instrument[u.index] for u in fit.unknowns], dtype=float)
        gradients = np.zeros((len(point.angle_arcsec), len(budget.covariance)))
        gradients[:, : len(fit.unknowns)] = np.nan_to_num(point.slopes) * log * own
        return point.angle_arcsec, gradients


def load_of_choice(
    case: Case | Drive,
    torque_Nm: ArrayLike | None,
    preload_N: ArrayLike | None,
    input_angle_deg: ArrayLike | None,
) -> Load | None:
    """The load, completed from `[load]` of the case; None if neither gives a torque."""
    in_case = case if isinstance(case, Case) else None
    if in_case and torque_Nm is None:
        torque_Nm = in_case.torque_Nm
    if torque_Nm is None:
        if preload_N is not None or input_angle_deg is not None:
            raise InvalidInputError(
                "torque_Nm is missing: give the torque at which the angle is computed"
            )
        return None
    if in_case and preload_N is None:
        preload_N = in_case.preload_N
    drive = case if isinstance(case, Drive) else case.drive
    if preload_N is None and drive.kind != "torsion_spring":
        raise InvalidInputError(
            "preload_N is missing: give the preload at which the angle is computed"
        )
    if in_case and input_angle_deg is None:
        input_angle_deg = in_case.input_angle_deg
    return Load(torque_Nm, preload_N, 0.0 if input_angle_deg is None else input_angle_deg)


def _checked(*loads: ArrayLike | None) -> tuple[Floats, ...]:
    given = [load for load in loads if load is not None]
    if len(given) < len(loads):
        raise InvalidInputError(
            "preload_N is missing: give the preload at which the angle is computed"
        )
    names = "torque_Nm", "preload_N", "input_angle_deg"
    arrays = loads_of(**dict(zip(names, given, strict=True)))
    for name, array in zip(names, arrays, strict=True):
        bad = ~np.isfinite(array) | ((array <= 0) if name == "preload_N" else False)
        if bad.any():
            least = " above 0" if name == "preload_N" else ""
            raise InvalidInputError(f"{name} = {array[bad][0]:g}: expected a finite number{least}")
    return tuple(np.array(array).reshape(-1) for array in arrays)


def _inside(readings: Readings, torque: Floats, preload: Floats) -> NDArray[np.bool_]:
    """Whether torque and preload (of any size where it is NaN) lie within those of the readings."""
    r = readings
    inside = (torque >= r.torque_Nm.min()) & (torque <= r.torque_Nm.max())
    if r.preload_N is not None:
        inside &= ~((preload < r.preload_N.min()) | (preload > r.preload_N.max()))
    return np.asarray(inside)


def _campaign_of(c: Campaign, readings: Readings) -> Campaign:
    """The drive under the loads of a table, with one offset and nothing read."""
    n = len(readings)
    return replace(
        c,
        readings=readings,
        y_arcsec=np.zeros(n),
        u_arcsec=np.ones(n),
        rows=Rows.of(readings.run_index),
        zero_per_run=False,
        held=None,
        torque_errors=None,
        curve_errors=None,
    )


def _fresh(readings: Readings, torque: Floats, preload: Floats, angle: Floats) -> Readings:
    """Each load as a run of its own."""
    n = len(torque)
    temperature = readings.temperature_degC
    return Readings(
        torque_Nm=torque,
        preload_N=None if np.isnan(preload).any() else preload,
        input_angle_deg=angle,
        elastic_angle_arcsec=np.zeros(n),
        u_elastic_angle_arcsec=None,
        run=np.arange(n),
        time_s=None if readings.time_s is None else np.zeros(n),
        cycle=None if readings.cycle is None else np.full(n, float(readings.cycle.min())),
        temperature_degC=(
            None if temperature is None else np.full(n, float(np.median(temperature)))
        ),
        line=np.arange(1, n + 1),
    )
