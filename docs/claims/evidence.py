"""Numbers behind the claims: the drives, curves over one parameter, and tests of a trend.

Angles are in arcsec, and every curve is computed once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

import cbpt
from cbpt.results import ARCSEC_PER_RAD

Array = NDArray[np.float64]

# --- the drives ---------------------------------------------------------------------------

TORQUE_NM = 5.0
PRELOAD_N = 600.0
DECELERATION: Mapping[str, Any] = {
    "ball_count": 20,
    "short_amplitude_coefficient": 0.5,
    "rolling_circle_radius_mm": 4.0,
    "ball_radius_mm": 1.5,
    "groove_conformity": 1.08,
    "contact_angle_deg": 45.0,
}
RINGS: Mapping[str, Any] = {
    "kind": "ring_groove",
    "ball_count": 14,
    "pitch_radius_mm": 40.0,
    "ball_radius_mm": 1.5,
    "groove_conformity": 1.08,
    "contact_angle_deg": 45.0,
}
SLIDE: Mapping[str, Any] = {**RINGS, "kind": "cross_slide", "ball_count": 16}
PAPER_SHARE = {"torque_share": "paper"}  # M0 itself on the cross-slide
PAPER_FORM = {"form": "paper", "torque_share": "paper"}  # its arms too


def make_drive(
    equal_speed: Mapping[str, Any] = RINGS, track_curvature: str = "exact", **deceleration: Any
) -> cbpt.Drive:
    """The base case with another equal-speed pair or other keys of the deceleration pair."""
    return cbpt.Drive.from_dict(
        {
            "track_curvature": track_curvature,
            "deceleration": {**DECELERATION, **deceleration},
            "equal_speed": dict(equal_speed),
        }
    )


def make_prototype(track_curvature: str = "neglect") -> cbpt.Drive:
    """The drive of the paper's experiment.

    With its true track curvature it cannot be solved: its grooves undercut, and its ring grooves
    have no inside wall.
    """
    rings = {**RINGS, "ball_count": 10, "pitch_radius_mm": 25.0, "ball_radius_mm": 2.5}
    return make_drive(
        rings,
        track_curvature,
        ball_count=26,
        short_amplitude_coefficient=0.6,
        rolling_circle_radius_mm=0.8,
        ball_radius_mm=2.0,
    )


# --- evidence -----------------------------------------------------------------------------

NAN = float("nan")

# Deceleration balls of the curves: equal steps, and with the 14 ring-groove balls of the base
# case such drives repeat after few turns, which makes their largest angle quick to find.
BALL_COUNTS = (13, 20, 27, 34)
EQUAL_SPEED_COUNTS = tuple(range(6, 25))
DECELERATION_COUNTS = tuple(range(10, 41))


def alpha_dmax_arcsec(
    drive: cbpt.Drive, torque_Nm: float = TORQUE_NM, preload_N: float = PRELOAD_N
) -> float:
    """Largest elastic angle over a period; NaN where there is none within small displacements."""
    largest = drive.largest_elastic_angle(torque_Nm, preload_N)
    if largest is None:
        return NAN
    state = drive.solve(torque_Nm, preload_N, largest.input_angle_deg)
    return largest.elastic_angle_arcsec if state.status == "ok" else NAN


Trend = Callable[[Array, Array], bool]


@dataclass(frozen=True)
class Scan:
    """Largest elastic angle against one parameter, for several numbers of deceleration balls."""

    x: Array
    alpha_arcsec: Mapping[int, Array]

    def gaps(self) -> list[Array]:
        """Angle of the fewer balls minus that of the next more."""
        return [few - more for few, more in pairwise(self.alpha_arcsec.values())]

    def between(self, low: float, high: float) -> Scan:
        """The part of the scan with the parameter in this range."""
        inside = (self.x >= low) & (self.x <= high)
        return Scan(self.x[inside], {z2: a[inside] for z2, a in self.alpha_arcsec.items()})

    def all(self, trend: Trend) -> bool:
        """Whether the curves of all ball numbers follow a trend."""
        return all(trend(alpha, self.x) for alpha in self.alpha_arcsec.values())

    def all_gaps(self, trend: Trend) -> bool:
        """Whether all gaps follow a trend."""
        return all(trend(gap, self.x) for gap in self.gaps())

    def falls_ever_slower_with_balls(self) -> bool:
        """Whether at every point the angle falls with the ball number, and so do the gaps."""
        rows = np.array(list(self.alpha_arcsec.values())).T
        # A bend needs three numbers of balls that hold the torque.
        rows = rows[np.isfinite(rows).sum(axis=1) > 2]
        return len(rows) > 0 and all(falls_ever_slower(row) for row in rows)


def _scan(x: Array, angle: Callable[[float, int], float]) -> Scan:
    return Scan(x, {z2: np.array([angle(float(v), z2) for v in x]) for z2 in BALL_COUNTS})


@cache
def scan_short_amplitude() -> Scan:
    # A point on either side of the step where the ring grooves' inside wall appears.
    step = inside_wall_from() + np.array([-1e-6, 1e-6])
    return _scan(
        np.sort(np.concatenate([np.arange(10, 61, 2) / 100, step])),
        lambda k, z2: alpha_dmax_arcsec(make_drive(ball_count=z2, short_amplitude_coefficient=k)),
    )


@cache
def scan_preload_N() -> Scan:
    drives = {z2: make_drive(ball_count=z2) for z2 in BALL_COUNTS}
    return _scan(
        np.concatenate([np.arange(150.0, 300.0, 25.0), np.arange(300.0, 1501.0, 50.0)]),
        lambda preload_N, z2: alpha_dmax_arcsec(drives[z2], preload_N=preload_N),
    )


@cache
def scan_rolling_circle_mm() -> Scan:
    return _scan(
        np.arange(2.25, 8.1, 0.25),
        lambda r0_mm, z2: alpha_dmax_arcsec(
            make_drive(ball_count=z2, rolling_circle_radius_mm=r0_mm)
        ),
    )


@cache
def scan_contact_angle_deg(rings_too: bool = False) -> Scan:
    """Only the deceleration pair's angle, or that of the ring grooves with it."""

    def angle(beta_deg: float, z2: int) -> float:
        rings = {**RINGS, "contact_angle_deg": beta_deg} if rings_too else RINGS
        return alpha_dmax_arcsec(make_drive(rings, ball_count=z2, contact_angle_deg=beta_deg))

    fine, coarse = np.arange(5.0, 25.0, 1.0), np.arange(25.0, 78.0, 2.5)
    return _scan(coarse if rings_too else np.concatenate([fine, coarse]), angle)


@cache
def scan_torque_Nm() -> Scan:
    drives = {z2: make_drive(ball_count=z2) for z2 in BALL_COUNTS}
    return _scan(
        np.arange(0.5, 20.1, 0.5),
        lambda torque_Nm, z2: alpha_dmax_arcsec(drives[z2], torque_Nm),
    )


@cache
def scan_deceleration_balls() -> Array:
    """alpha_dmax for the `DECELERATION_COUNTS`."""
    return np.array([alpha_dmax_arcsec(make_drive(ball_count=z2)) for z2 in DECELERATION_COUNTS])


def slopes(y: Iterable[float], x: Array | None = None) -> Array:
    """Slopes between neighbours, of the part of a curve that exists."""
    values = np.array(list(y))
    places = np.arange(len(values), dtype=np.float64) if x is None else x
    there = np.isfinite(values)
    slope: Array = np.diff(values[there]) / np.diff(places[there])
    return slope


def falls(y: Iterable[float], x: Array | None = None) -> bool:
    slope = slopes(y, x)
    return bool(len(slope) and np.all(slope < 0))


def rises(y: Iterable[float], x: Array | None = None) -> bool:
    slope = slopes(y, x)
    return bool(len(slope) and np.all(slope > 0))


def bends_up(y: Iterable[float], x: Array | None = None) -> bool:
    """Whether every slope is above the one before."""
    bend = np.diff(slopes(y, x))
    return bool(len(bend) and np.all(bend > 0))


def falls_ever_slower(y: Iterable[float], x: Array | None = None) -> bool:
    values = list(y)
    return falls(values, x) and bends_up(values, x)


def rises_ever_faster(y: Iterable[float], x: Array | None = None) -> bool:
    values = list(y)
    return rises(values, x) and bends_up(values, x)


def bends_up_from(y: Array, x: Array) -> float:
    """The place from which a curve bends up to its end."""
    there = np.isfinite(y)
    down = np.flatnonzero(np.diff(slopes(y, x)) <= 0)
    return float(x[there][down[-1] + 1 if len(down) else 0])


def goes_at(code: str, key: str, low: float, high: float, ball_count: int = 20) -> float:
    """Value of a key of the deceleration pair at which a design finding comes or goes."""

    def found(value: float) -> bool:
        changed: dict[str, Any] = {"ball_count": ball_count, key: value}
        drive = make_drive(**changed)
        return any(finding.code == code for finding in drive.findings())

    at_low = found(low)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if found(middle) == at_low else (low, middle)
    return 0.5 * (low + high)


@cache
def inside_wall_from() -> float:
    """K above which the ring grooves have an inside wall."""
    return goes_at("inside_wall_missing", "short_amplitude_coefficient", 0.1, 0.4)


@cache
def undercut_from(ball_count: int) -> float:
    """K from which the deceleration grooves undercut."""
    return goes_at("undercut", "short_amplitude_coefficient", 0.4, 0.7, ball_count)


@cache
def undercut_below_mm(ball_count: int) -> float:
    """r0 below which the deceleration grooves undercut."""
    return goes_at("undercut", "rolling_circle_radius_mm", 1.0, 4.0, ball_count)


def pair_angles_arcsec(drive: cbpt.Drive, crank_deg: Array) -> tuple[Array, Array]:
    """Parts of the deceleration and of the equal-speed pair at the base load."""
    angles = cbpt.solve_many(drive, TORQUE_NM, PRELOAD_N, crank_deg)
    return (
        angles.alpha_deceleration_rad * ARCSEC_PER_RAD,
        angles.alpha_equal_speed_rad * ARCSEC_PER_RAD,
    )


def crank_of_ball_ring_deg(ball_ring_deg: Array | float, z2: int = 20) -> Array:
    """Crank angle at which the ring of deceleration balls has turned by Phi."""
    return np.asarray(ball_ring_deg, dtype=np.float64) * z2 / (z2 - 1)


def equal_speed_angles_arcsec(
    ball_count: int, equal_speed: Mapping[str, Any] = RINGS
) -> tuple[float, float]:
    """Largest angle and amplitude over a turn of an equal-speed pair."""
    drive = make_drive({**equal_speed, "ball_count": ball_count})
    # One period of the ring grooves; the cross-slide is constant, in the paper's form it needs
    # a full turn.
    ring_period_deg = 360.0 / ball_count * 21 / 19
    full = equal_speed.get("form") == "paper"
    _, alpha = pair_angles_arcsec(drive, np.linspace(0, 360.0 if full else ring_period_deg, 49))
    return float(alpha.max()), float(np.ptp(alpha))


@cache
def equal_speed_curves() -> dict[str, tuple[Array, Array]]:
    """Largest angle and amplitude against the number of balls, by kind of pair."""
    kinds = {
        "rings": RINGS,
        "slide": SLIDE,
        "slide, M0": {**SLIDE, **PAPER_SHARE},
        "slide, paper": {**SLIDE, **PAPER_FORM},
    }
    curves = {}
    for name, pair in kinds.items():
        both = np.array([equal_speed_angles_arcsec(z, pair) for z in EQUAL_SPEED_COUNTS])
        curves[name] = (both[:, 0], both[:, 1])
    return curves


def deformations_um(pair: cbpt.PairSolution | None) -> tuple[float, float]:
    """Largest deformation of an FTMP and smallest of an NFTMP."""
    assert pair is not None
    role, deformation = np.array(pair.role), np.asarray(pair.deformation_m) * 1e6
    return float(deformation[role == "FTMP"].max()), float(deformation[role == "NFTMP"].min())


@cache
def equal_speed_deformations_um(kind: str) -> tuple[Array, Array]:
    pair = RINGS if kind == "rings" else SLIDE
    states = [
        make_drive({**pair, "ball_count": z}).solve(TORQUE_NM, PRELOAD_N)
        for z in EQUAL_SPEED_COUNTS
    ]
    both = np.array([deformations_um(state.equal_speed) for state in states])
    return both[:, 0], both[:, 1]


@cache
def deceleration_curves() -> dict[str, Array]:
    """Largest angle, amplitude and deformations against the number of deceleration balls."""
    rows = []
    for z2 in DECELERATION_COUNTS:
        drive = make_drive(ball_count=z2)
        alpha, _ = pair_angles_arcsec(drive, np.linspace(0, 360.0 / (z2 - 1), 49))
        state = drive.solve(TORQUE_NM, PRELOAD_N)
        rows.append((alpha.max(), np.ptp(alpha), *deformations_um(state.deceleration)))
    largest, amplitude, loaded, unloaded = np.array(rows).T
    return {
        "largest_arcsec": largest,
        "amplitude_arcsec": amplitude,
        "loaded_um": loaded,
        "unloaded_um": unloaded,
    }


@cache
def minimum_preload_N(ball_ring_deg: tuple[float, ...]) -> dict[str, Array]:
    """The paper's minimum APF of each pair against the angle of the ring of balls."""
    drives = {
        "rings": make_drive(),
        "slide": make_drive(SLIDE),
        "slide, M0": make_drive({**SLIDE, **PAPER_SHARE}),
        "slide, paper": make_drive({**SLIDE, **PAPER_FORM}),
    }
    crank_deg = crank_of_ball_ring_deg(np.array(ball_ring_deg))
    curves = {
        name: np.array([drive.preload(TORQUE_NM, a).equal_speed.continuous_N for a in crank_deg])
        for name, drive in drives.items()
    }
    curves["deceleration"] = np.array(
        [drives["rings"].preload(TORQUE_NM, a).deceleration.continuous_N for a in crank_deg]
    )
    return curves


@cache
def minimum_preload_deformations_um(kind: str, ball_ring_deg: tuple[float, ...]) -> Array:
    """Deformation of every diagonal, each state at the minimum preload of its own angle, shape
    (angles, balls, 2): first the diagonal of an FTMP at a positive arm."""
    drive = make_drive(SLIDE if kind == "slide" else RINGS)
    name = "deceleration" if kind == "deceleration" else "equal_speed"
    states = []
    # Backwards, so that the first ball's angle on its own circle rises with the turn.
    for crank_deg in -crank_of_ball_ring_deg(np.array(ball_ring_deg)):
        need_N = getattr(drive.preload(TORQUE_NM, crank_deg), name).continuous_N
        pair = getattr(drive.solve(TORQUE_NM, need_N, crank_deg), name)
        states.append(np.asarray(pair.deformation_m).reshape(-1, 2) * 1e6)
    return np.array(states)


PROTOTYPE_PRELOADS_N = (600.0, 500.0, 400.0)


@cache
def prototype_curves() -> tuple[Array, dict[float, Array]]:
    """Largest elastic angle of the prototype against the torque, by preload."""
    torque_Nm = np.arange(0.0, 5.01, 0.25)
    drive = make_prototype()
    angles = {
        preload_N: np.array([0.0, *(alpha_dmax_arcsec(drive, t, preload_N) for t in torque_Nm[1:])])
        for preload_N in PROTOTYPE_PRELOADS_N
    }
    return torque_Nm, angles


def prototype_torques_Nm(preload_N: float) -> tuple[float, float, float]:
    """Torque at which a diagonal parts, at which d = 0, and that the deceleration pair holds."""
    per_Nm = make_prototype().preload(1.0).deceleration
    thresholds = (per_Nm.zero_backlash_N, per_Nm.continuous_N, per_Nm.hold_N)
    first, zero, hold = (preload_N / threshold for threshold in thresholds)
    return first, zero, hold
