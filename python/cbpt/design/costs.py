"""What preload and stiffness cost: friction, efficiency, wear, safety, the window of the preload.

friction      a case under a load -> Costs
Costs         the answer: numbers, text, JSON, a picture of the window
friction_map  arrays of loads -> FrictionMap
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive, friction_of_loads
from cbpt.design.judge import at_load, effects_of, judge
from cbpt.figures.preload_window import WindowPicture, draw_window
from cbpt.lab.readings.inputs import case_of
from cbpt.results import ARCSEC_PER_RAD, loads_of

__all__ = ["Costs", "FrictionMap", "friction", "friction_map"]

Floats = NDArray[np.float64]

# Preloads at which the curves of the picture are computed.
_POINTS = 161
# Columns of the table of pairs.
_OF_PAIR = ("friction_torque_Nm", "least_Nm", "largest_Nm", "no_load_Nm", "wear_Nm_per_turn")


@dataclass(frozen=True, eq=False)
class Costs:
    """Friction, wear and safety of a case under a load, over a period."""

    case: Case
    """The case with its whole load."""
    document: dict[str, Any]
    """All numbers, as `cbpt friction --json` prints them."""
    text: str = field(repr=False)

    @property
    def has_solution(self) -> bool:
        """Whether every angle of the period has one."""
        return self.document["drive"] is not None

    @property
    def friction_torque_Nm(self) -> float | None:
        """Mean friction torque at the input; None without solution."""
        return self._of_drive("friction_torque_Nm")

    @property
    def efficiency(self) -> float | None:
        """Work at the output over work at the input; None without solution."""
        return self._of_drive("efficiency")

    @property
    def wear_Nm_per_turn(self) -> float | None:
        """Archard's index for a turn of the input: friction work over the coefficient."""
        return self._of_drive("wear_Nm_per_turn")

    @property
    def backdriving_torque_Nm(self) -> float | None:
        """Torque at the output that turns a free input; None if the drive locks."""
        return _number(self.document["backdriving_torque_Nm"])

    @property
    def static_safety(self) -> float:
        """(pressure limit over highest peak pressure)^3; 0 without solution."""
        return float(self.document["static_safety"])

    @property
    def largest_torque_Nm(self) -> float | None:
        """Largest torque with the required static safety; None where the preload is too much."""
        return _number(self.document["largest_torque_Nm"])

    @property
    def preload_window_N(self) -> tuple[float, float] | None:
        """Least and largest preload that holds, transmits without a loose ball and is safe."""
        window = self.document["preload_window"]
        least, largest = _number(window["least_N"]), _number(window["largest_N"])
        return None if least is None or largest is None else (least, largest)

    def _of_drive(self, key: str) -> float | None:
        drive = self.document["drive"]
        return None if drive is None else float(drive[key])

    def to_dict(self) -> dict[str, Any]:
        """The document: plain types, JSON-safe."""
        return self.document

    def to_json(self) -> str:
        """`to_dict` as JSON text."""
        return json.dumps(self.document, indent=2, allow_nan=False)

    def to_csv(self) -> str:
        """A row for each pair and for the drive; no rows without solution. The wear of the track
        is that of the groove that wears most."""
        lines = [",".join(("pair", *_OF_PAIR, "track_wear_Nm_per_mm"))]
        pairs = {name: self.document[name] for name in ("deceleration", "equal_speed")}
        if self.has_solution:
            wear = {name: max(pair["track_wear_Nm_per_mm"]) for name, pair in pairs.items()}
            for name, row in (pairs | {"drive": self.document["drive"]}).items():
                track = wear.get(name, max(wear.values()))
                cells = [*(row[key] for key in _OF_PAIR), track]
                lines.append(",".join([name, *("" if v is None else repr(v) for v in cells)]))
        return "\n".join(lines) + "\n"

    def report(self) -> str:
        """Text for a terminal."""
        return self.text

    def __repr__(self) -> str:
        return self.text

    def plot(self, path: str | PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw angle, friction torque and safety over the preload, with the window, to a file (SVG,
        PNG or PDF by its ending); the curves are those at the input angle. Needs matplotlib."""
        draw_window(self.picture(), path, angle_unit)

    def picture(self) -> WindowPicture:
        """What `plot` draws."""
        window = {name: _number(value) for name, value in self.document["preload_window"].items()}
        own = float(self.document["preload_N"])
        low = max(window["hold_N"] or 0.0, 1e-3 * own)
        high = 2 * max(window["largest_N"] or 0.0, window["continuous_N"] or 0.0, own)
        preloads = np.geomspace(low * (1 + 1e-6), high, _POINTS)
        case, coefficient = self.case, float(self.document["coefficient"])
        found = judge(
            case, ["load.preload_N"], preloads[:, None], pressures=True, coefficient=coefficient
        )
        return WindowPicture(
            title=f"{case.torque_Nm:g} N m, friction coefficient {coefficient:g}",
            own_N=own,
            preload_N=preloads,
            angle_arcsec=np.abs(found["elastic_angle_rad"]) * ARCSEC_PER_RAD,
            friction_torque_Nm=found["friction_torque_Nm"],
            static_safety=found["static_safety"],
            required_static_safety=float(self.document["required_static_safety"]),
            window=window,
        )


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def friction(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    *,
    torque_Nm: float | None = None,
    preload_N: float | None = None,
    input_angle_deg: float | None = None,
    coefficient: float | None = None,
    static_safety: float | None = None,
) -> Costs:
    """What a drive costs under a load: friction torque, efficiency, wear, safety, preload window.

    The effects of the case are not counted, and the answer says so; the parts as made are.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive. `[friction]` and `[operation]` hold coefficient, speed, inertia and mass.
    torque_Nm, preload_N, input_angle_deg : float, optional
        The load. What is not given comes from `[load]` of the case. The angle counts for the
        natural frequency alone; all else is over a period.
    coefficient : float, optional
        Friction coefficient of the contacts in place of the case's.
    static_safety : float, optional
        Static safety that is required in place of the case's.

    Returns
    -------
    Costs
        The answer; `has_solution` says whether the load has one at every angle.

    Raises
    ------
    InvalidInputError
        A number is missing or not possible, or the reducer is a torsion spring.
    """
    whole = at_load(case, torque_Nm, preload_N, input_angle_deg)
    assert whole.torque_Nm is not None and whole.preload_N is not None, "see at_load"
    angle_deg = whole.input_angle_deg or 0.0
    text, document = whole.costs(
        whole.torque_Nm, whole.preload_N, angle_deg, coefficient, static_safety
    )
    return Costs(whole, json.loads(document), text)


@dataclass(frozen=True, eq=False)
class FrictionMap:
    """Friction over a period for many loads. Arrays have the broadcast shape of the loads, NaN
    where a load has no solution at some angle."""

    torque_Nm: Floats
    """Torque on the output."""
    preload_N: Floats
    """Axial preload."""
    friction_torque_Nm: Floats
    """Mean friction torque at the input."""
    least_Nm: Floats
    """Its least value over the period."""
    largest_Nm: Floats
    """Its largest value over the period."""
    efficiency: Floats
    """Work at the output over work at the input; 0 without torque."""
    wear_Nm_per_turn: Floats
    """Archard's index for a turn of the input."""
    status: NDArray[np.str_]
    """As in `Angles`."""
    effects_not_counted: tuple[str, ...]
    """Ids of the effects of the case: friction is that of the drive without them."""


def friction_map(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    torque_Nm: ArrayLike,
    preload_N: ArrayLike,
    *,
    coefficient: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> FrictionMap:
    """Friction torque, efficiency and wear for arrays of loads, on all cores.

    The effects of the case are not counted, as in `friction`; the parts as made are.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive.
    torque_Nm, preload_N : array_like
        Torque on the output, N m, and axial preload, N. They broadcast against each other.
    coefficient : float, optional
        Friction coefficient in place of the case's.
    progress : callable, optional
        Called as ``progress(loads_done, loads)``. What it raises ends the work.

    Returns
    -------
    FrictionMap
        Arrays in the broadcast shape.

    Raises
    ------
    InvalidInputError
        A number is not possible, or the reducer is a torsion spring.
    """
    found = case_of(case)
    if coefficient is None:
        coefficient = found.friction_coefficient if isinstance(found, Case) else 0.1
    torque, preload = loads_of(torque_Nm=torque_Nm, preload_N=preload_N)
    report = None if progress is None else (lambda done: progress(done, torque.size))
    drive = found.drive if isinstance(found, Case) else found
    mean, least, largest, efficiency, wear, names = friction_of_loads(
        drive,
        np.ascontiguousarray(torque).reshape(-1),
        np.ascontiguousarray(preload).reshape(-1),
        coefficient,
        report,
    )
    return FrictionMap(
        torque_Nm=torque.copy(),
        preload_N=preload.copy(),
        friction_torque_Nm=mean.reshape(torque.shape),
        least_Nm=least.reshape(torque.shape),
        largest_Nm=largest.reshape(torque.shape),
        efficiency=efficiency.reshape(torque.shape),
        wear_Nm_per_turn=wear.reshape(torque.shape),
        status=np.array(names, dtype=np.str_).reshape(torque.shape),
        effects_not_counted=tuple(effects_of(found)) if isinstance(found, Case) else (),
    )
