"""The drive's part of the document: drawing, findings, thresholds, the angle over the torque.

drive_section   of a case, at the load that its readings reach
redrawn         the same at another load and with other design numbers
load_of         the load that it begins with

What it holds is typed: `DriveSection` in `types`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from typing import cast

import numpy as np

from cbpt._core import Case, Drive, Solution, Thresholds
from cbpt.errors import InvalidInputError
from cbpt.lab.readings.reader import Readings
from cbpt.page.document.drawing import drawing_of
from cbpt.page.document.drive_types import (
    AngleCurve,
    DriveSection,
    DriveSolution,
    DriveThresholds,
    Load,
    PairThresholds,
    Slider,
    Sliders,
)
from cbpt.page.document.plain import finite, finite_numbers, numbers
from cbpt.results import ARCSEC_PER_RAD, solve_many
from cbpt.units import UNITS

_CURVE_POINTS = 81
_WHY_NO_DRAWING = (
    "a torsion spring is described by its stiffness alone: it has no grooves, balls or preload "
    "thresholds to draw"
)
_RAD, _M, _PA = (UNITS[unit].size for unit in ("deg", "mm", "GPa"))

# Section, key in SI, label, unit shown and its SI value, range: factors of the value, or ends.
_DESIGN: tuple[tuple[str, str, str, str, float, str, float, float], ...] = (
    ("deceleration", "ball_count", "deceleration balls", "", 1.0, "count", -6, 6),
    ("deceleration", "short_amplitude_coefficient", "short amplitude", "", 1.0, "ends", 0.05, 0.95),
    (
        "deceleration",
        "rolling_circle_radius_m",
        "rolling circle radius",
        "mm",
        _M,
        "times",
        0.6,
        1.6,
    ),
    ("deceleration", "ball_radius_m", "ball radius", "mm", _M, "times", 0.5, 1.6),
    ("deceleration", "groove_conformity", "groove conformity", "", 1.0, "ends", 1.01, 1.3),
    ("deceleration", "contact_angle_rad", "contact angle", "deg", _RAD, "ends", 20, 70),
    ("equal_speed", "ball_count", "equal-speed balls", "", 1.0, "count", -6, 6),
    ("equal_speed", "pitch_radius_m", "pitch radius, equal-speed", "mm", _M, "times", 0.6, 1.6),
    ("equal_speed", "ball_radius_m", "ball radius, equal-speed", "mm", _M, "times", 0.5, 1.6),
    (
        "equal_speed",
        "groove_conformity",
        "groove conformity, equal-speed",
        "",
        1.0,
        "ends",
        1.01,
        1.3,
    ),
    ("equal_speed", "contact_angle_rad", "contact angle, equal-speed", "deg", _RAD, "ends", 20, 70),
    ("material", "youngs_modulus_Pa", "Young's modulus", "GPa", _PA, "times", 0.3, 1.6),
)
_SHOWN = {"mm": ("_m", "_mm"), "deg": ("_rad", "_deg"), "GPa": ("_Pa", "_GPa")}


def drive_section(case: Case | Drive, readings: Readings) -> DriveSection:
    """Of the case without its effects, at its own load or else at that of the largest torque."""
    drive = case if isinstance(case, Drive) else case.drive
    load = load_of(case, readings)
    return _section(drive, load, _sliders(drive, load))


def redrawn(
    case: Case | Drive,
    readings: Readings,
    load: Mapping[str, float] | None = None,
    design: Mapping[str, float] | None = None,
) -> DriveSection:
    """The section at a load of choice, with design numbers by the keys of the sliders.

    The sliders are those of the case. Raises `InvalidInputError` and `CaseError` for what cannot
    be.
    """
    drive = case if isinstance(case, Drive) else case.drive
    given = load_of(case, readings)
    sliders = _sliders(drive, given)
    for key, value in (load or {}).items():
        if key not in given:
            known = ", ".join(given)
            raise InvalidInputError(f"load: there is no key {key!r}; the allowed keys are {known}")
        if not np.isfinite(value):
            raise InvalidInputError(f"load: {key} = {value}: expected a finite number")
    given = cast(Load, given | dict(load or {}))
    if design:
        drive = _changed(drive, design)
    return _section(drive, given, sliders)


def _section(drive: Drive, load: Load, sliders: Sliders) -> DriveSection:
    torque, preload, angle = load["torque_Nm"], load["preload_N"], load["input_angle_deg"]
    solution = drive.solve(torque, preload, angle)
    ball_drive = drive.kind == "ball_drive"
    return {
        "kind": drive.kind,
        "load": load,
        "design": {key: value for key, _, value, *_ in _design_of(drive)},
        "solution": _solution(solution),
        "findings": [
            {
                "code": f.code,
                "severity": f.severity,
                "pair": f.pair,
                "message": f.message,
                "remedy": f.remedy,
            }
            for f in (drive.findings(torque, preload, angle) if ball_drive else [])
        ],
        "thresholds": _thresholds(drive, torque) if ball_drive and torque else None,
        "angle_curve": _angle_curve(drive, torque, preload, angle),
        "sliders": sliders,
        "drawing": drawing_of(drive, solution, angle) if ball_drive else None,
        "why_no_drawing": None if ball_drive else _WHY_NO_DRAWING,
    }


def load_of(case: Case | Drive, readings: Readings) -> Load:
    """What the case states, else that of the reading with the largest torque."""
    stated = case if isinstance(case, Case) else None
    largest = int(np.argmax(np.abs(readings.torque_Nm)))
    torque = stated.torque_Nm if stated else None
    preload = stated.preload_N if stated else None
    angle = stated.input_angle_deg if stated else None
    if preload is None and readings.preload_N is not None:
        preload = float(readings.preload_N[largest])
    return {
        "torque_Nm": abs(float(readings.torque_Nm[largest])) if torque is None else torque,
        "preload_N": preload,
        "input_angle_deg": float(readings.input_angle_deg[largest]) if angle is None else angle,
    }


def _solution(s: Solution) -> DriveSolution:
    stiffness = s.torsional_stiffness_Nm_per_rad
    return {
        "status": s.status,
        "message": s.message,
        "elastic_angle_arcsec": s.elastic_angle_arcsec,
        "deceleration_arcsec": s.alpha_deceleration_arcsec,
        "equal_speed_arcsec": s.alpha_equal_speed_arcsec,
        "torsional_stiffness_Nm_per_arcsec": None
        if stiffness is None
        else stiffness / ARCSEC_PER_RAD,
        "hold_preload_N": s.hold_preload_N,
    }


def _thresholds(drive: Drive, torque: float) -> DriveThresholds:
    found = drive.preload(torque)

    def of(t: Thresholds) -> PairThresholds:
        return {
            "hold_N": finite(t.hold_N),
            "continuous_N": finite(t.continuous_N),
            "zero_backlash_N": finite(t.zero_backlash_N),
        }

    return {
        "torque_Nm": torque,
        "drive": of(found.drive),
        "deceleration": of(found.deceleration),
        "equal_speed": of(found.equal_speed),
    }


def _angle_curve(drive: Drive, torque: float, preload: float | None, angle: float) -> AngleCurve:
    """From -torque to torque, with room beyond."""
    reach = 1.25 * abs(torque) or 1.0
    grid = np.linspace(-reach, reach, _CURVE_POINTS)
    found = solve_many(drive, grid, 0.0 if preload is None else preload, angle)
    return {
        "torque_Nm": finite_numbers(grid),
        "elastic_angle_arcsec": numbers(found.elastic_angle_arcsec),
        "deceleration_arcsec": numbers(found.alpha_deceleration_rad * ARCSEC_PER_RAD),
        "equal_speed_arcsec": numbers(found.alpha_equal_speed_rad * ARCSEC_PER_RAD),
        "status": found.status.tolist(),
    }


# --- sliders ------------------------------------------------------------------------------


def _sliders(drive: Drive, load: Load) -> Sliders:
    torque, preload, angle = load["torque_Nm"], load["preload_N"], load["input_angle_deg"]
    reach = 1.25 * abs(torque or 1.0)
    loads = [_slider(("torque_Nm", "torque", "N m"), torque, -reach, reach, reach / 200)]
    if preload is not None:
        low, high = 0.2 * preload, 2 * preload
        loads.append(_slider(("preload_N", "preload", "N"), preload, low, high, preload / 200))
    loads.append(_slider(("input_angle_deg", "input angle", "deg"), angle, 0.0, 360.0, 0.5))
    return {"load": loads, "design": [_design_slider(row) for row in _design_of(drive)]}


def _slider(
    name: tuple[str, str, str], value: float, low: float, high: float, step: float
) -> Slider:
    """name: key, label and unit."""
    key, label, unit = name
    return {
        "key": key,
        "label": label,
        "unit": unit,
        "value": value,
        "min": float(low),
        "max": float(high),
        "step": float(f"{step:.2g}"),
    }


Row = tuple[str, str, float, str, str, float, float]


def _design_of(drive: Drive) -> Iterator[Row]:
    """Key, label, value, unit, kind of range and its ends, of the numbers that the case has."""
    if drive.kind != "ball_drive":
        return
    case = tomllib.loads(drive.to_toml())
    for section, name, label, unit, size, kind, low, high in _DESIGN:
        value = case.get(section, {}).get(name)
        if value is not None:
            si, shown = _SHOWN.get(unit, ("", ""))
            key = f"{section}.{name.removesuffix(si)}{shown}"
            yield key, label, float(f"{value / size:.12g}"), unit, kind, low, high


def _design_slider(row: Row) -> Slider:
    key, label, value, unit, kind, low, high = row
    name = key, label, unit
    if kind == "count":
        return _slider(name, value, max(3, value + low), value + high, 1)
    ends = (value * low, value * high) if kind == "times" else (min(low, value), max(high, value))
    return _slider(name, value, *ends, (ends[1] - ends[0]) / 200)


def _changed(drive: Drive, design: Mapping[str, float]) -> Drive:
    """The drive with other numbers, by the keys of the sliders."""
    case = tomllib.loads(drive.to_toml())
    known = {key for key, *_ in _design_of(drive)}
    for key, value in design.items():
        if key not in known:
            raise InvalidInputError(f"design: {key!r} cannot be changed here")
        section, name = key.split(".")
        for si, shown in _SHOWN.values():
            if name.endswith(shown):
                case[section].pop(name.removesuffix(shown) + si, None)
                break
        whole = name == "ball_count"
        if whole and value != int(value):
            raise InvalidInputError(f"design: {key} = {value:g}: expected a whole number")
        case[section][name] = int(value) if whole else float(value)
    return Drive.from_dict(case)
