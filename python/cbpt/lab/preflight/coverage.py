"""What a table varies, and what could not be told from it, whatever the model.

coverage_checks   sides, torques, preloads and input angles
blind_to          effects that no model could find, for what the table does not vary
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cbpt._core import Case, Drive, effect_specs
from cbpt.lab.preflight.record import Blind, Check
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of


def coverage_checks(r: Readings, case: Case | Drive | None) -> Iterator[Check]:
    """Sides, torques, preloads and input angles."""
    yield _sides(r)
    yield from _coverage(r, case)


def _sides(r: Readings) -> Check:
    above, below = int(np.sum(r.torque_Nm > 0)), int(np.sum(r.torque_Nm < 0))
    words = f"{above} readings at positive torque, {below} at negative"
    if not np.ptp(r.torque_Nm) > 0:
        remedy = "Load the output with several torques; without them no stiffness can be told."
        return Check("sides", "lost", words, remedy)
    if min(above, below) < 0.1 * max(above, below):
        remedy = "Load both ways: play, lost motion and differences by sign need both."
        return Check("sides", "lost", words, remedy)
    return Check("sides", "good", words)


def _kind(case: Case | Drive | None) -> str | None:
    drive = case.drive if isinstance(case, Case) else case
    return None if drive is None else drive.kind


def _coverage(r: Readings, case: Case | Drive | None) -> Iterator[Check]:
    torques = len(levels_of(r.torque_Nm))
    span = f"{r.torque_Nm.min():.4g} to {r.torque_Nm.max():.4g} N m"
    words = f"{torques} torques, {span}"
    if torques < 5:
        yield Check("torque", "look", words, "Take 5 or more torques, or a bend has no shape.")
    else:
        yield Check("torque", "good", words)
    yield from _preload(r, _kind(case))
    angles = len(np.unique(np.round(np.mod(r.input_angle_deg, 360.0), 3)))
    words = f"{angles} input angle{'s' * (angles != 1)}"
    remedy = "Repeat at 4 or more input angles that are not multiples of each other."
    yield Check("input angle", "good" if angles > 3 else "lost", words, remedy * (angles < 4))


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
    count, of_what = 0, "preload"
    if r.preload_N is not None:
        count = len(levels_of(r.preload_N))
    elif r.preload_step is not None:
        count, of_what = len(np.unique(r.preload_step)), "preload step"
    words = f"{count} {of_what}{'s' * (count != 1)}"
    if r.preload_N is None:
        words += ", no force in newtons"
    if count > 1 or spring:
        yield Check("preload", "good", words)
    else:
        remedy = "Repeat the torques at a second preload that differs by a factor 1.5 or more."
        yield Check("preload", "lost", words, remedy)


def blind_to(readings: Readings, case: Case | Drive | None) -> Iterator[Blind]:
    """Effects that no model could find in these readings, for what they do not vary."""
    kind = _kind(case)
    known = {spec.id for spec in effect_specs() if kind is None or kind in spec.reducers}
    for effects, there, why, remedy in _needs(readings):
        suited = tuple(effect for effect in effects if effect in known)
        if suited and not there:
            yield Blind(suited, why, remedy)


def _needs(r: Readings) -> Iterator[tuple[tuple[str, ...], bool, str, str]]:
    """Effects, whether the table varies what they need, why not, and the remedy."""
    preload = r.preload_N
    yield (
        ("preload_loss", "preload_spring", "preload_scale", "rough_contact"),
        preload is not None and len(levels_of(preload)) > 1,
        "the preload does not vary",
        "Repeat the torques at a second preload.",
    )
    angles = len(np.unique(np.round(np.mod(r.input_angle_deg, 360.0), 3)))
    yield (
        ("eccentricity_error", "groove_pitch_error", "ball_diameter_lot", "plate_tilt"),
        angles > 3,
        f"{angles} input angle{'s' * (angles != 1)} cannot show a pattern round the turn",
        "Repeat at 4 or more input angles.",
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
