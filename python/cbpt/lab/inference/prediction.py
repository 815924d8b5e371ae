"""The elastic angle of the drive at loads of choice, with its uncertainty.

    Load           the loads that are asked for
    AtLoad         the angles, as arrays
    angle_at       what a fit says of them
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
from cbpt.lab.inference.budget import Budget, Combined
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.priors import CLASSES
from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]


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
    model = Assembled(
        _fresh_campaign(fitter.campaign, torque, preload, input_angle), fitter.effects
    )
    instrument = np.zeros(len(model.nothing), dtype=bool)
    for (instance, _), place in model.places.items():
        instrument[place] = CLASSES[model.effects[instance]] == "rig"

    def values(of: Fit) -> Floats:
        return np.where(instrument, model.nothing, of.point.values)

    point = model.at(values(fit), [u.index for u in fit.unknowns])
    budget = Budget.of(fitter, fit)
    log = np.array([fit.value(u) if u.log else 1.0 for u in fit.unknowns])
    own = np.array([not instrument[u.index] for u in fit.unknowns], dtype=float)
    gradients = np.zeros((len(torque), len(budget.covariance)))
    gradients[:, : len(fit.unknowns)] = np.nan_to_num(point.slopes) * log * own
    solved = np.isfinite(point.angle_arcsec)
    parts = tuple(
        budget.combined(g) if ok and why_no_u is None else None
        for g, ok in zip(gradients, solved, strict=True)
    )
    return AtLoad(
        torque_Nm=torque,
        preload_N=preload,
        input_angle_deg=input_angle,
        elastic_angle_arcsec=point.angle_arcsec,
        u_elastic_angle_arcsec=np.array([np.nan if p is None else p.u for p in parts]),
        status=model.states(values(fit))[1],
        inside=_inside(fitter.campaign.readings, torque, preload),
        why_no_u=why_no_u,
        by_rival_arcsec={
            name: model.at(values(rival)).angle_arcsec for name, rival in (rivals or {}).items()
        },
        parts=parts,
        gradients=gradients,
    )


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
    if any(load is None for load in loads):
        raise InvalidInputError(
            "preload_N is missing: give the preload at which the angle is computed"
        )
    try:
        arrays = np.broadcast_arrays(*(np.asarray(load, dtype=np.float64) for load in loads))
    except (TypeError, ValueError):
        raise InvalidInputError(
            "torque_Nm, preload_N and input_angle_deg: expected numbers, or arrays of the same "
            "shape"
        ) from None
    for name, array in zip(("torque_Nm", "preload_N", "input_angle_deg"), arrays, strict=True):
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


def _fresh_campaign(c: Campaign, torque: Floats, preload: Floats, angle: Floats) -> Campaign:
    """The drive under each load, with one offset and nothing read."""
    n = len(torque)
    return replace(
        c,
        readings=_fresh(c.readings, torque, preload, angle),
        y_arcsec=np.zeros(n),
        u_arcsec=np.ones(n),
        rows=Rows.of(np.arange(n)),
        zero_per_run=False,
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
