"""What a table varies, and what could not be told from it, whatever the model.

coverage_checks   sides, torques, preloads and input angles
blind_to          effects that no model could find, for what the table does not vary
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cbpt._core import Case, Drive, effect_specs
from cbpt.lab.preflight.coverage_settings import (
    Angles,
    angles_of,
    preload_range,
    preload_varies,
    told_apart,
    turn_is_covered,
)
from cbpt.lab.preflight.record import Blind, Check, State
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.wording.numbers import rounded
from cbpt.lab.wording.phrases import span


@dataclass(frozen=True)
class _Limits:
    """From where something is lost, or another look is due."""

    side: float = 0.1
    """Share of readings on the other side of zero torque."""
    reach: float = 0.5
    """Ratio of the torques that both sides reach: a loop that is whole reaches half as far on one
    side as on the other (`cbpt.lab.characteristics.loops`)."""
    off_rated: float = 0.1
    """Share by which torques differ from the rated one, as in the warnings of the figures
    (`cbpt.lab.characteristics.warnings`)."""
    torques: int = 5
    """Two on each side and zero show a bend of each side."""
    nyquist: int = 5
    """Equally spaced input angles: four see two periods a turn in one phase only."""


_LIMITS = _Limits()


def coverage_checks(r: Readings, case: Case | Drive | None) -> Iterator[Check]:
    """Sides, torques, preloads and input angles."""
    yield _sides(r)
    yield _torque(r, case)
    yield from _preload(r, _kind(case))
    yield _input_angle(r, angles_of(r.input_angle_deg), case)


def _sides(r: Readings) -> Check:
    above, below = int(np.sum(r.torque_Nm > 0)), int(np.sum(r.torque_Nm < 0))
    words = f"{_counted(above, 'reading')} at positive torque, {below} at negative"
    if not np.ptp(r.torque_Nm) > 0:
        remedy = "Load the output with several torques; without them no stiffness can be told."
        return Check("sides", "lost", words, remedy)
    if min(above, below) < _LIMITS.side * max(above, below):
        remedy = "Load both ways: play, lost motion and differences by sign need both."
        return Check("sides", "lost", words, remedy)
    low, high = float(r.torque_Nm.min()), float(r.torque_Nm.max())
    if min(-low, high) < _LIMITS.reach * max(-low, high):
        words += f", to {rounded(high)} N m one way and to {rounded(low)} N m the other"
        remedy = "Load equally far both ways: figures are read off loops that reach both."
        return Check("sides", "look", words, remedy)
    return Check("sides", "good", words)


def _kind(case: Case | Drive | None) -> str | None:
    drive = case.drive if isinstance(case, Case) else case
    return None if drive is None else drive.kind


def _counted(n: int, what: str) -> str:
    return f"{n} {what}{'s' * (n != 1)}"


def _torque(r: Readings, case: Case | Drive | None) -> Check:
    torques = len(levels_of(r.torque_Nm))
    low, high = float(r.torque_Nm.min()), float(r.torque_Nm.max())
    words, asked = f"{_counted(torques, 'torque')}, {span(low, high, 4)} N m", []
    if torques < _LIMITS.torques:
        asked.append(
            f"Take readings at {_LIMITS.torques} torques or more: fewer do not show how the "
            "stiffness changes with the torque."
        )
    rated = case.rated_torque_Nm if isinstance(case, Case) else None
    share = max(-low, high) / rated if rated else 1.0
    if rated and abs(share - 1) > _LIMITS.off_rated:
        words += (
            f"; they reach {rounded(100 * share)} % of the rated torque of {rounded(rated)} N m"
        )
    if share < 1 - _LIMITS.off_rated:
        asked.append(
            "Load up to the rated torque: stiffness there, hysteresis loss and lost motion are "
            "figures of loops to the rated torque."
        )
    return Check("torque", "look" if asked else "good", words, " ".join(asked))


def _preload(r: Readings, kind: str | None) -> Iterator[Check]:
    """A spring has no preload in its model: levels of one are told, none are asked for."""
    spring = kind == "torsion_spring"
    if r.preload_N is None and r.preload_step is None:
        remedy = "Repeat the torques at 2 or more preloads; add the column preload_N."
        if kind == "ball_drive":
            remedy += (
                " A model of a ball drive needs the preload: where there was one, state preload_N "
                "under [load] of the case."
            )
        if not spring:
            yield Check("preload", "lost", "no preload in the table", remedy)
        return
    if r.preload_N is None:
        count = len(np.unique(r.preload_step)) if r.preload_step is not None else 0
        words, varies = f"{_counted(count, 'preload step')}, no force in newtons", count > 1
    else:
        held = levels_of(r.preload_N).value
        words = f"{_counted(len(held), 'preload')}, {span(held.min(), held.max(), 4)} N"
        varies = preload_varies(r)
        if len(held) > 1 and not varies:
            words += f": {rounded(100 * (preload_range(r) - 1))} % apart, which is too little"
    if varies or spring:
        yield Check("preload", "good", words)
    else:
        remedy = "Repeat the torques at a second preload that differs by a factor 1.5 or more."
        yield Check("preload", "lost", words, remedy)


_ROUND_THE_TURN = ("eccentricity_error", "groove_pitch_error", "ball_diameter_lot", "plate_tilt")


def _needs_angle(case: Case | Drive | None) -> bool:
    """Whether anything depends on the input angle: in a spring it is what acts at a radius."""
    if case is None or _kind(case) != "torsion_spring":
        return True
    return "reference_radius_m" in tomllib.loads(case.to_toml())["torsion_spring"]


_ROUND = "Repeat at 4 or more input angles over the whole turn, unequally spaced (0, 50, 130, 230)."


def _input_angle(r: Readings, angles: Angles, case: Case | Drive | None) -> Check:
    name, n = "input angle", len(angles)
    words = _counted(n, "input angle")
    if not _needs_angle(case):
        words += ", and nothing in the model of this spring depends on it"
        return Check(name, "good", words)
    covered, asked = turn_is_covered(angles), []
    if not covered:
        words += _within(angles)
        asked = [_ROUND, *_in_rad(r, angles)]
    elif angles.step_deg:
        words += (
            f", equally spaced by {rounded(angles.step_deg)} deg: patterns with {n}, {2 * n}, ... "
            "periods a turn look constant"
        )
        asked = [_ROUND] * (n < _LIMITS.nyquist)
    else:
        words += f", at most {rounded(angles.gap_deg)} deg apart"
    if not told_apart(r, angles):
        words += "; each preload was taken at others of them"
        asked.append(
            "Take all preloads at the same input angles: else a pattern round the turn looks like "
            "an effect of the preload."
        )
    state: State = "good" if not asked else "look" if covered else "lost"
    return Check(name, state, words, " ".join(asked))


def _within(angles: Angles) -> str:
    """The part of the turn, where it is less than half."""
    covered = 360.0 - angles.gap_deg
    return f" within {rounded(covered)} deg" if 0 < covered < 180 else ""


def _in_rad(r: Readings, angles: Angles) -> list[str]:
    """A question, where the angles would go round the turn if they were in rad."""
    deg = np.degrees(r.input_angle_deg)
    if len(angles) > 1 and np.ptp(deg) <= 360.0 and turn_is_covered(angles_of(deg)):
        return ["Are the input angles in rad, not in deg?"]
    return []


def blind_to(readings: Readings, case: Case | Drive | None) -> Iterator[Blind]:
    """Effects that no model could find in these readings, for what they do not vary."""
    kind = _kind(case)
    known = {spec.id for spec in effect_specs() if kind is None or kind in spec.reducers}
    if not _needs_angle(case):
        known -= set(_ROUND_THE_TURN)
    for effects, there, why, remedy in _needs(readings):
        suited = tuple(effect for effect in effects if effect in known)
        if suited and not there:
            yield Blind(suited, why, remedy)


def _needs(r: Readings) -> Iterator[tuple[tuple[str, ...], bool, str, str]]:
    """Effects, whether the table varies what they need, why not, and the remedy."""
    yield (
        ("preload_loss", "preload_spring", "preload_scale", "rough_contact"),
        preload_varies(r),
        f"the preload does not vary{' by enough' * (preload_range(r) > 1)}",
        "Repeat the torques at a second preload that differs by a factor 1.5 or more.",
    )
    angles = angles_of(r.input_angle_deg)
    yield (
        _ROUND_THE_TURN,
        turn_is_covered(angles),
        f"{_counted(len(angles), 'input angle')}{_within(angles)} cannot show a pattern round the "
        "turn",
        "Repeat at 4 or more input angles over the whole turn.",
    )
    yield (
        ("drift", "creep", "wear"),
        r.time_s is not None,
        "there is no time",
        "Add the column time_s.",
    )
    temperature = r.temperature_degC
    yield (
        ("thermal_preload",),
        temperature is not None and float(np.ptp(temperature)) > 0.5,
        "the temperature is not known, or does not vary by half a kelvin",
        "Record temperature_degC, and measure cold and warm.",
    )
    ways = r.direction()
    yield (
        ("friction_hysteresis",),
        bool(np.any(ways > 0) and np.any(ways < 0)),
        "the torque goes only one way",
        "Unload in the same steps.",
    )
    yield (
        ("bearing_play", "backlash"),
        bool(np.any(r.torque_Nm > 0) and np.any(r.torque_Nm < 0)),
        "the torque has one sign",
        "Load both ways.",
    )
    yield (
        ("run_offset",),
        int(r.run_index.max()) > 0,
        "there is one run",
        "Take the readings in several runs, and say which in the column run.",
    )
