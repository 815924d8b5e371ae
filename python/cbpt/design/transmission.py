"""The transmission error of a drive whose parts are as they were made.

    transmission   a case with [as_made] -> Transmission
    Transmission   the error over the turns of the crank, its spectrum, what each ball carries, and
                   the thresholds of the preload
    Line           one line of the spectrum
    Balls          what the balls of a pair carry

The error is the angle of the output against that of an ideal drive, above 0 in the sense in which
a torque above 0 turns the output. It is sampled evenly over the turns after which the whole drive
stands as before, so that every line of the spectrum lies on a sample.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, PreloadThresholds, ball_loads
from cbpt.design.judge import at_load, bare_drive_note
from cbpt.errors import InvalidInputError, NoSolutionError
from cbpt.figures.transmission import draw_transmission
from cbpt.lab.wording import layout
from cbpt.results import ANGLE_UNITS, ARCSEC_PER_RAD, solve_many

__all__ = ["Balls", "Line", "Transmission", "transmission"]

Floats = NDArray[np.float64]

# So many samples for each ball and turn of the crank show the ripple of the balls and three of its
# harmonics.
_SAMPLES_PER_BALL = 8
MOST_TURNS = 1000
# What the balls carry changes little from sample to sample.
_BALL_ANGLES = 1024
# Lines of the spectrum that are told, and the least of them as a share of the largest.
_LINES = 24
_LEAST = 1e-3
# Multiples of parts that a line may be made of.
_MULTIPLES = range(-24, 25)


@dataclass(frozen=True)
class Line:
    """One line of a spectrum."""

    order: Fraction
    """Waves for a turn of the crank."""
    amplitude_arcsec: float
    phase_deg: float
    """The line is amplitude times cos(order times crank angle + phase)."""
    source: str
    """What turns at this order: `crank x 2`, `planet x 1`, `balls x 3`, or a sum."""

    def to_dict(self) -> dict[str, Any]:
        """The line in plain types."""
        return {
            "order": float(self.order),
            "order_fraction": str(self.order),
            "amplitude_arcsec": self.amplitude_arcsec,
            "phase_deg": self.phase_deg,
            "source": self.source,
        }


@dataclass(frozen=True, eq=False)
class Balls:
    """What the balls of a pair carry over the turns, one number for each ball, shape (balls,)."""

    mean_share: Floats
    """Share of the preload, mean over the turns."""
    largest_share: Floats
    """The largest."""
    least_share: Floats
    """The least; 0 where the ball comes loose."""
    largest_torque_share: Floats
    """Largest share of the torque of the pair; NaN without torque."""
    largest_force_N: Floats
    """Largest normal force at one of its meshing points."""

    def to_dict(self) -> list[dict[str, Any]]:
        """One entry for each ball, in plain types."""
        return [
            {
                "ball": ball,
                "mean_preload_share": _plain(self.mean_share[ball]),
                "least_preload_share": _plain(self.least_share[ball]),
                "largest_preload_share": _plain(self.largest_share[ball]),
                "largest_torque_share": _plain(self.largest_torque_share[ball]),
                "largest_force_N": _plain(self.largest_force_N[ball]),
            }
            for ball in range(len(self.mean_share))
        ]


@dataclass(frozen=True, eq=False)
class Transmission:
    """Transmission error over the turns after which the drive repeats. Arrays: shape (n,)."""

    case: Case
    """With the load."""
    turns: int
    """Turns of the crank that are covered."""
    repeats: bool
    """Whether the drive stands as before after them; else the spectrum is smeared."""
    input_angle_deg: Floats = field(repr=False)
    unloaded_arcsec: Floats = field(repr=False)
    """Error without torque, under the preload."""
    loaded_arcsec: Floats = field(repr=False)
    """Angle under the torque and preload: elastic angle and error."""
    unloaded_lines: tuple[Line, ...]
    """The largest lines of the spectrum, the largest first."""
    loaded_lines: tuple[Line, ...]
    deceleration: Balls
    equal_speed: Balls
    """Of a cross-slide its first row."""
    thresholds: PreloadThresholds
    """Of the parts as made, under the torque."""
    nominal_thresholds: PreloadThresholds
    seating: PreloadThresholds
    """Of the parts as made without torque: the preload that seats every ball (continuous) and
    every meshing point (zero backlash)."""

    @property
    def unloaded_range_arcsec(self) -> float:
        """Largest minus smallest error without torque."""
        return float(np.ptp(self.unloaded_arcsec))

    @property
    def loaded_range_arcsec(self) -> float:
        """Largest minus smallest angle under the torque."""
        return float(np.ptp(self.loaded_arcsec))

    def to_dict(self) -> dict[str, Any]:
        """The document: plain types, JSON-safe. The curve itself goes to a CSV file."""
        return {
            "torque_Nm": self.case.torque_Nm,
            "preload_N": self.case.preload_N,
            "turns": self.turns,
            "repeats": self.repeats,
            "samples": len(self.input_angle_deg),
            "unloaded_range_arcsec": self.unloaded_range_arcsec,
            "unloaded_mean_arcsec": float(np.mean(self.unloaded_arcsec)),
            "loaded_range_arcsec": self.loaded_range_arcsec,
            "loaded_mean_arcsec": float(np.mean(self.loaded_arcsec)),
            "unloaded_spectrum": [line.to_dict() for line in self.unloaded_lines],
            "loaded_spectrum": [line.to_dict() for line in self.loaded_lines],
            "deceleration_balls": self.deceleration.to_dict(),
            "equal_speed_balls": self.equal_speed.to_dict(),
            "thresholds": _thresholds(self.thresholds),
            "nominal_thresholds": _thresholds(self.nominal_thresholds),
            "seating": _thresholds(self.seating),
        }

    def to_json(self) -> str:
        """`to_dict` as JSON text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def to_csv(self) -> str:
        """The curve: input angle, unloaded error and loaded angle, a row for each sample."""
        rows = zip(self.input_angle_deg, self.unloaded_arcsec, self.loaded_arcsec, strict=True)
        lines = [f"{a!r},{u!r},{m!r}" for a, u, m in (map(float, row) for row in rows)]
        return "input_angle_deg,unloaded_arcsec,loaded_arcsec\n" + "\n".join(lines) + "\n"

    def report(self, angle_unit: str = "arcsec") -> str:
        """Text for a terminal."""
        one, c = ANGLE_UNITS[angle_unit], self.case
        lines = [
            f"Transmission error at {c.preload_N:g} N over {self.turns} turns of the crank, in "
            f"{angle_unit}",
            f"  without torque: range {self.unloaded_range_arcsec * one:.6g}, mean "
            f"{np.mean(self.unloaded_arcsec) * one:.6g}",
            f"  at {c.torque_Nm:g} N m: range {self.loaded_range_arcsec * one:.6g}, mean "
            f"{np.mean(self.loaded_arcsec) * one:.6g}",
        ]
        if not self.repeats:
            lines.append(
                f"  the drive repeats only after {c.drive.repetition_turns} turns: lines of the "
                "spectrum are smeared"
            )
        if not c.drive.has_parts_as_made:
            lines.append("  the case has no [as_made]: all parts are nominal")
        heads = ["order", "source", f"unloaded_{angle_unit}", f"loaded_{angle_unit}"]
        lines += ["Spectrum", layout.table(heads, self._spectrum_rows(one))]
        for name, balls in (("Deceleration", self.deceleration), ("Equal-speed", self.equal_speed)):
            lines += [
                f"{name} balls: share of the preload in %, largest force at a meshing point",
                _ball_table(balls),
            ]
        rows: list[list[Any]] = [
            [name, t.hold_N, t.continuous_N, t.zero_backlash_N]
            for name, t in (
                (f"as made, {c.torque_Nm:g} N m", self.thresholds.drive),
                (f"nominal, {c.torque_Nm:g} N m", self.nominal_thresholds.drive),
                ("as made, no torque", self.seating.drive),
            )
        ]
        lines.append("Preload that is needed, largest over the turns")
        lines.append(layout.table(["parts", "hold_N", "continuous_N", "zero_backlash_N"], rows))
        lines += bare_drive_note(self.case, "the angles are")
        return "\n".join(lines)

    def _spectrum_rows(self, one: float) -> list[list[Any]]:
        orders = {line.order: line.source for line in (*self.unloaded_lines, *self.loaded_lines)}
        sizes = [
            {line.order: line.amplitude_arcsec for line in lines}
            for lines in (self.unloaded_lines, self.loaded_lines)
        ]

        def size(order: Fraction) -> float:
            return max(of.get(order, 0.0) for of in sizes)

        largest = sorted(orders, key=size, reverse=True)[:_LINES]
        return [
            [float(order), orders[order], *(_times(of.get(order), one) for of in sizes)]
            for order in sorted(largest)
        ]

    def __repr__(self) -> str:
        return self.report()

    def plot(self, path: str | PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw error, spectrum and shares to a file (SVG, PNG or PDF). Needs matplotlib."""
        draw_transmission(self, path, angle_unit)


def transmission(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    *,
    torque_Nm: float | None = None,
    preload_N: float | None = None,
    turns: int | None = None,
) -> Transmission:
    """Solve the drive over the turns of the crank, with its parts as they were made.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive with its `[as_made]`.
    torque_Nm, preload_N : float, optional
        The load. What is not given comes from `[load]` of the case.
    turns : int, optional
        Turns of the crank to cover; by default all after which the drive repeats.

    Returns
    -------
    Transmission
        Error without and with torque, its spectrum, shares of the balls, preload thresholds.

    Raises
    ------
    InvalidInputError
        A number is not possible, or the case is a torsion spring.
    NoSolutionError
        Some angle of the crank has no solution; the message has the first.
    """
    case = at_load(case, torque_Nm, preload_N)
    drive = case.drive
    assert case.torque_Nm is not None and case.preload_N is not None
    period = drive.repetition_turns
    turns = period if turns is None else turns
    if not 1 <= turns <= max(MOST_TURNS, period):
        raise InvalidInputError(f"turns = {turns}: expected 1 to {MOST_TURNS}")
    count = turns * _SAMPLES_PER_BALL * drive.deceleration_ball_count
    angle = 360.0 * turns * np.arange(count) / count
    unloaded, loaded = (_angles(drive, t, case.preload_N, angle) for t in (0.0, case.torque_Nm))
    lines = [_lines(drive, turns, curve) for curve in (unloaded, loaded)]
    shown = np.deg2rad(angle[:: -(-count // _BALL_ANGLES)])
    carried = ball_loads(drive, case.torque_Nm, case.preload_N, shown)
    return Transmission(
        case=case,
        turns=turns,
        repeats=turns % period == 0,
        input_angle_deg=angle,
        unloaded_arcsec=unloaded,
        loaded_arcsec=loaded,
        unloaded_lines=lines[0],
        loaded_lines=lines[1],
        deceleration=_balls(*carried[:3]),
        equal_speed=_balls(*carried[3:]),
        thresholds=drive.preload(case.torque_Nm),
        nominal_thresholds=drive.nominal().preload(case.torque_Nm),
        seating=drive.preload(0.0),
    )


def _angles(drive: Drive, torque_Nm: float, preload_N: float, angle_deg: Floats) -> Floats:
    """Angle of the output at each angle of the crank, arcsec."""
    found = solve_many(drive, torque_Nm, preload_N, angle_deg)
    lost = np.flatnonzero(~np.isfinite(found.elastic_angle_rad))
    if len(lost):
        raise NoSolutionError(
            f"no solution at {torque_Nm:g} N m, {preload_N:g} N and an input angle of "
            f"{angle_deg[lost[0]]:g} deg: {found.status[lost[0]]}"
        )
    return found.elastic_angle_rad * ARCSEC_PER_RAD


def _lines(drive: Drive, turns: int, curve: Floats) -> tuple[Line, ...]:
    """The largest lines of a curve, the largest first."""
    found = np.fft.rfft(curve) / len(curve)
    amplitude = 2.0 * np.abs(found)
    amplitude[0] = 0.0
    # What the solver leaves is no line.
    floor = max(_LEAST * float(amplitude.max()), 1e-9 * float(np.max(np.abs(curve), initial=0.0)))
    largest = np.argsort(-amplitude, kind="stable")[:_LINES]
    return tuple(
        Line(
            order=Fraction(int(place), turns),
            amplitude_arcsec=float(amplitude[place]),
            phase_deg=float(np.degrees(np.angle(found[place]))),
            source=_source(drive, Fraction(int(place), turns)),
        )
        for place in largest
        if amplitude[place] > floor
    )


def _source(drive: Drive, order: Fraction) -> str:
    """The fewest turns of crank, planet and balls whose sum has this order."""
    planet, balls = (Fraction(*turns) for turns in drive.turns_of_parts)
    alone = [
        (abs(order / part), f"{name} x {order / part}")
        for name, part in (("crank", Fraction(1)), ("planet", planet), ("balls", balls))
        if (order / part).denominator == 1
    ]
    if alone:
        return min(alone)[1]
    best: tuple[int, str] | None = None
    for of_planet in _MULTIPLES:
        for of_balls in _MULTIPLES:
            of_crank = order - of_planet * planet - of_balls * balls
            size = abs(of_crank) + abs(of_planet) + abs(of_balls)
            if of_crank.denominator == 1 and (best is None or size < best[0]):
                parts = [("crank", int(of_crank)), ("planet", of_planet), ("balls", of_balls)]
                words = " + ".join(f"{name} x {times}" for name, times in parts if times)
                best = int(size), words
    return best[1] if best else "-"


def _balls(axial_N: Floats, torque_Nm: Floats, normal_N: Floats) -> Balls:
    """Shares from what each ball carries at each angle, shape (angles, balls)."""
    share = axial_N / axial_N.sum(axis=1, keepdims=True)
    whole = torque_Nm.sum(axis=1, keepdims=True)
    loaded = np.abs(whole) > 1e-9 * np.max(np.abs(torque_Nm), initial=0.0)
    of_torque = np.divide(torque_Nm, whole, out=np.full_like(torque_Nm, np.nan), where=loaded)
    return Balls(
        mean_share=share.mean(axis=0),
        largest_share=share.max(axis=0),
        least_share=share.min(axis=0),
        largest_torque_share=of_torque.max(axis=0),
        largest_force_N=normal_N.max(axis=0),
    )


def _ball_table(balls: Balls) -> str:
    columns = (balls.least_share, balls.mean_share, balls.largest_share)
    rows: list[list[Any]] = [
        [ball, *(100.0 * float(of[ball]) for of in columns), float(balls.largest_force_N[ball])]
        for ball in range(len(balls.mean_share))
    ]
    if all(np.allclose(row[1:], rows[0][1:], rtol=1e-3) for row in rows):
        rows = [["each", *rows[0][1:]]]
    return layout.table(["ball", "least_%", "mean_%", "largest_%", "force_N"], rows)


def _thresholds(found: PreloadThresholds) -> dict[str, dict[str, float | None]]:
    pairs = {
        "deceleration": found.deceleration,
        "equal_speed": found.equal_speed,
        "drive": found.drive,
    }
    return {
        pair: {
            "hold_N": _plain(t.hold_N),
            "continuous_N": _plain(t.continuous_N),
            "zero_backlash_N": _plain(t.zero_backlash_N),
        }
        for pair, t in pairs.items()
    }


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
