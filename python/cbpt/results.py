"""Many loads at once: arrays of torque, preload and input angle in, labelled arrays out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive, Predictor, Unit, solve_angles
from cbpt.errors import InvalidInputError
from cbpt.sketch import against
from cbpt.units import UNITS

__all__ = ["ANGLE_UNITS", "ARCSEC_PER_RAD", "Angles", "solve_many"]


def _one(of: Unit, unit: Unit) -> float:
    times, over, _ = of.conversion(unit)
    return times / over


ARCSEC_PER_RAD = _one(UNITS["rad"], UNITS["arcsec"])
"""Seconds of arc in a radian."""

ANGLE_UNITS = {
    unit.symbol: _one(UNITS["arcsec"], unit)
    for unit in reversed(UNITS.values())
    if unit.quantity == "angle"
}
"""Units that results can be given in: the value of one arcsec in each."""
_SHOWN_ROWS = 20
"""Loads that a notebook shows."""


@dataclass(frozen=True, eq=False)
class Angles:
    """Elastic angles of many loads. All arrays have the broadcast shape of the loads.

    Where a load has no solution its numbers are NaN and `status` says why; nothing is left out.
    """

    torque_Nm: NDArray[np.float64]
    """Resistance torque on the output."""
    preload_N: NDArray[np.float64]
    """Axial preload."""
    input_angle_deg: NDArray[np.float64]
    """Angle of the input crank."""
    alpha_deceleration_rad: NDArray[np.float64]
    """Part of the deceleration pair."""
    alpha_equal_speed_rad: NDArray[np.float64]
    """Part of the equal-speed pair that reaches the output."""
    residual: NDArray[np.float64]
    """Largest scaled residual of the equations."""
    hold_preload_N: NDArray[np.float64]
    """Preload at which the torque would just slip, where the status is `beyond_hold`."""
    status: NDArray[np.str_]
    """`ok`, `outside_small_displacements`, `outside_table`, `beyond_hold`, `undercut`,
    `indeterminate`, `not_converged` or `effect_not_finite`."""
    shown_rad: NDArray[np.float64] | None = None
    """Angle as the instrument shows it with the effects of a case; None where there are none."""

    @property
    def elastic_angle_rad(self) -> NDArray[np.float64]:
        """Elastic angle of the drive at its output, with the effects of a case if it has any."""
        if self.shown_rad is not None:
            return self.shown_rad
        return self.alpha_deceleration_rad + self.alpha_equal_speed_rad

    @property
    def elastic_angle_arcsec(self) -> NDArray[np.float64]:
        """Elastic angle of the drive at its output."""
        return self.elastic_angle_rad * ARCSEC_PER_RAD

    @property
    def has_solution(self) -> NDArray[np.bool_]:
        """Where the numbers are there."""
        return np.isfinite(self.alpha_deceleration_rad)

    def __len__(self) -> int:
        return int(self.torque_Nm.size)

    def _repr_html_(self) -> str:
        """As a notebook shows it: a table of the first loads, and the angle over them."""
        loads = {n: getattr(self, n) for n in ("torque_Nm", "preload_N", "input_angle_deg")}
        angle = self.elastic_angle_arcsec
        found = loads | {"elastic_angle_arcsec": angle, "status": self.status}
        return first_rows(repr(self), found) + against(loads, "elastic_angle_arcsec", angle)

    def __repr__(self) -> str:
        solved = int(np.count_nonzero(self.has_solution))
        text = f"Angles({solved} of {len(self)} loads solved"
        if solved:
            angle = self.elastic_angle_arcsec[self.has_solution]
            text += f", elastic angle {angle.min():.6g} to {angle.max():.6g} arcsec"
        for name in np.unique(self.status[~self.has_solution]):
            text += f", {np.count_nonzero(self.status == name)} {name}"
        return text + ")"


def first_rows(heading: str, columns: Mapping[str, NDArray[Any]]) -> str:
    """The first rows of some columns as HTML, for a notebook."""
    values = [np.ravel(column)[:_SHOWN_ROWS].tolist() for column in columns.values()]
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    told = [
        [escape(v) if isinstance(v, str) else f"{v:.6g}" for v in row]
        for row in zip(*values, strict=True)
    ]
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in told)
    total = max((np.size(column) for column in columns.values()), default=0)
    more = f"<p>and {total - len(told)} more rows</p>" if total > len(told) else ""
    return f"<p>{escape(heading)}</p><table><tr>{head}</tr>{body}</table>{more}"


def solve_many(
    drive: Drive | Case,
    torque_Nm: ArrayLike,
    preload_N: ArrayLike = 0.0,
    input_angle_deg: ArrayLike = 0.0,
    *,
    progress: Callable[[int, int], object] | None = None,
) -> Angles:
    """Solve a drive, or a case with its effects, for arrays of loads on all cores.

    It works in threads and in processes, also in processes that were forked: each of those starts
    threads of its own.

    Parameters
    ----------
    drive : Drive or Case
        A `Case` brings its effects: each load is then a run of one reading, from rest, at time 0.
    torque_Nm : array_like
        Torque on the output, N m.
    preload_N : array_like
        Axial preload, N. A torsion spring needs none.
    input_angle_deg : array_like
        Angle of the input crank, degrees. The three arrays broadcast against each other as in
        numpy.
    progress : callable, optional
        Called as ``progress(loads_done, loads)``. What it raises ends the work.

    Returns
    -------
    Angles
        Elastic angles and their parts in rad, residuals and statuses, in the broadcast shape. A
        torsion spring has one part, `alpha_deceleration_rad`.

    Raises
    ------
    InvalidInputError
        A number is not possible (the message has its index), complex or masked; or the shapes do
        not broadcast.

    Examples
    --------
    >>> import cbpt
    >>> drive = cbpt.Drive.from_toml(cbpt.example_case())
    >>> angles = cbpt.solve_many(drive, [[1.0], [5.0]], [600, 900])
    >>> angles.elastic_angle_arcsec.shape
    (2, 2)
    """
    torque, preload, angle = loads_of(
        torque_Nm=torque_Nm, preload_N=preload_N, input_angle_deg=input_angle_deg
    )
    shape = torque.shape
    t, n, a = (np.ascontiguousarray(x).reshape(-1) for x in (torque, preload, np.deg2rad(angle)))
    if isinstance(drive, Case):
        if drive.effects:
            return _with_effects(drive, torque, preload, angle, progress)
        drive = drive.drive
    report = None if progress is None else lambda done: progress(done, torque.size)
    deceleration, equal_speed, residual, hold, code, names = solve_angles(
        drive, t, n, a, list(shape), report
    )
    return Angles(
        torque_Nm=torque.copy(),
        preload_N=preload.copy(),
        input_angle_deg=angle.copy(),
        alpha_deceleration_rad=deceleration.reshape(shape),
        alpha_equal_speed_rad=equal_speed.reshape(shape),
        residual=residual.reshape(shape),
        hold_preload_N=hold.reshape(shape),
        status=np.array(names, dtype=np.str_)[code].reshape(shape),
    )


_BATCH = 2048
"""Loads that are predicted together."""


def _with_effects(
    case: Case,
    torque: NDArray[np.float64],
    preload: NDArray[np.float64],
    angle_deg: NDArray[np.float64],
    progress: Callable[[int, int], object] | None,
) -> Angles:
    own = {effect.id: effect for effect in case.own_effects}
    effects = [own.get(effect.id, effect.id) for effect in case.effects]
    values = np.array([value for effect in case.effects for _, value in effect.values])
    t, n, a = (
        np.ascontiguousarray(x).reshape(-1) for x in (torque, preload, np.deg2rad(angle_deg))
    )
    found = []
    for start in range(0, len(t), _BATCH):
        rows = slice(start, start + _BATCH)
        rest = np.zeros(len(t[rows]))
        run = np.arange(len(rest), dtype=np.int64)
        model = Predictor(case.drive, effects, run, rest, t[rows], n[rows], a[rows], rest)
        found.append(model.predict(values))
        if progress is not None:
            progress(min(start + _BATCH, len(t)), len(t))

    def shaped(parts: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        return np.concatenate([*parts, np.zeros(0)]).reshape(torque.shape)

    status = [name for part in found for name in part.status]
    return Angles(
        torque_Nm=torque.copy(),
        preload_N=preload.copy(),
        input_angle_deg=angle_deg.copy(),
        alpha_deceleration_rad=shaped([part.parts_rad[:, 0] for part in found]),
        alpha_equal_speed_rad=shaped([part.parts_rad[:, 1] for part in found]),
        residual=shaped([part.residual for part in found]),
        hold_preload_N=shaped([part.hold_preload_N for part in found]),
        status=np.array(status, dtype=np.str_).reshape(torque.shape),
        shown_rad=shaped([part.angle_rad for part in found]),
    )


def loads_of(**loads: ArrayLike) -> tuple[NDArray[np.float64], ...]:
    """Loads as arrays of one shape, by name; an `InvalidInputError` where they cannot be that."""
    arrays = [_real(name, values) for name, values in loads.items()]
    try:
        return np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = [f"{name} has the shape {a.shape}" for name, a in zip(loads, arrays, strict=True)]
        raise InvalidInputError(
            f"{', '.join(shapes)}, but they must broadcast to one: give one number or as many in "
            "each"
        ) from None


def _real(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as float64; numpy itself would drop imaginary parts and masks."""
    masked = np.ma.getmaskarray(values) if np.ma.isMaskedArray(values) else np.zeros(0)
    if masked.any():
        place = ", ".join(map(str, np.argwhere(masked)[0].tolist()))
        found = f"{name}[{place}] is masked" if place else f"{name} is masked"
        raise InvalidInputError(f"{found}, but must be a number: fill it or leave such loads out")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError):  # rows of different lengths
        raise InvalidInputError(f"{name} is no array: its rows must have one length") from None
    if np.iscomplexobj(array):
        raise InvalidInputError(f"{name} is complex, but must be real: take its real part")
    if array.dtype.kind in "mMV":
        what = {"m": "durations", "M": "dates", "V": "records with several fields"}
        raise InvalidInputError(f"{name} holds {what[array.dtype.kind]}, but must hold numbers")
    try:
        return np.asarray(array, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):  # of objects and texts
        raise InvalidInputError(f"{name} holds {array.dtype}, but must hold numbers") from None
