"""The checks of a table, each a subject with what was found and the remedy on the rig.

checks     all of them
blind_to   what could not be told from the table, whatever the model
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, effect_specs
from cbpt.lab.characteristics.loops import Loop, loops_of
from cbpt.lab.characteristics.warnings import step_near_zero_Nm
from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.diagnosis.preflight_record import Blind, Check
from cbpt.lab.diagnosis.preflight_repeats import display_check, repeats_check
from cbpt.lab.diagnosis.preflight_saturation import follows_torque, saturated, saturation_check
from cbpt.lab.diagnosis.preflight_units import unit_checks
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.wording.numbers import rounded

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    rates: float = 1.5
    """Ratio of the quickest rate to the slowest."""
    window: float = 0.03
    """Share of the largest torque at which lost motion is read."""


_LIMITS = _Limits()


def checks(readings: Readings, case: Case | Drive | None) -> Iterator[Check]:
    """Every subject once, in the order in which a rig would be set right."""
    loops = loops_of(readings)
    yield from unit_checks(readings, case)
    yield _sides(readings)
    yield from _coverage(readings, case)
    yield saturation_check(readings)
    yield repeats_check(readings, loops)
    yield display_check(readings, loops)
    yield from _steps(loops)
    yield _torque_noise(readings, loops)
    yield _rates(readings, loops)
    yield _closed(loops)
    yield _zeros(readings, case)


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


def _steps(loops: list[Loop]) -> Iterator[Check]:
    if not loops:
        return
    window = _LIMITS.window * max(loop.amplitude_Nm for loop in loops)
    branches = [branch for loop in loops for branch in loop.branches]
    largest = step_near_zero_Nm(branches, window)
    if not largest:
        words = "no readings come near zero torque, where lost motion is read off"
        yield Check("steps of the torque", "look", words, "Begin and end each loop at zero torque.")
        return
    words = (
        f"steps of {rounded(largest)} N m near zero, window of lost motion {rounded(window)} N m"
    )
    fine = largest <= window * 1.001
    remedy = "Take finer steps near zero: there the angle changes most."
    yield Check("steps of the torque", "good" if fine else "look", words, remedy * (not fine))


def _torque_noise(r: Readings, loops: list[Loop]) -> Check:
    scattered = sum(any(b.scattered for b in loop.branches) for loop in loops)
    if not scattered:
        return Check("noise of the torque", "good", "the torque moves one way along each branch")
    size = []
    for run in range(int(r.run_index.max()) + 1):
        torque = r.torque_Nm[r.run_index == run]
        if len(torque) > 4:
            size.append(neighbour_scatter([torque], 3))
    words = (
        f"in {scattered} of {len(loops)} loops the torque goes back and forth along a branch; it "
        f"scatters by about {rounded(float(np.median(size)))} N m"
    )
    remedy = "Measure the torque itself, or average more of it into each reading"
    commands = [] if saturated(r) else follows_torque(r)
    if commands:
        columns = " or ".join(map(repr, commands))
        remedy += f", or take {columns}, which follows it without a limit, if it is a torque"
    remedy += "; play and friction are else found too wide."
    return Check("noise of the torque", "look", words, remedy)


def _rates(r: Readings, loops: list[Loop]) -> Check:
    if r.time_s is None:
        remedy = "Record the time of each reading: drift, creep and the rate need it."
        return Check("rates", "lost", "no time in the table", remedy)
    rates = [loop.rate_Nm_per_s for loop in loops if loop.rate_Nm_per_s]
    if not rates:
        return Check("rates", "good", "no loop with a rate")
    words = f"{rounded(min(rates))} to {rounded(max(rates))} N m/s"
    if max(rates) > _LIMITS.rates * min(rates):
        remedy = "Load at one rate: friction of reducers depends on it."
        return Check("rates", "look", words, remedy)
    return Check("rates", "good", words)


def _closed(loops: list[Loop]) -> Check:
    whole = [loop for loop in loops if loop.whole]
    words = f"{len(whole)} whole, {len(loops) - len(whole)} half or one-way"
    if not whole:
        remedy = "Run one and a quarter cycles: 0, +T, -T, +T, and on to -T."
        return Check("loops", "lost", words, remedy)
    composed = sum(loop.composed for loop in whole)
    open_ = sum(loop.open_arcsec is not None for loop in whole)
    if open_:
        words += f"; {open_} {'does' if open_ == 1 else 'do'} not close"
        remedy = "Repeat the cycle until it closes; a first loading and drift do not."
        return Check("loops", "look", words, remedy)
    if composed:
        words += f"; {composed} start and end at zero torque, and may hold a first loading"
        return Check("loops", "look", words, "Run a quarter cycle more.")
    return Check("loops", "good", words)


def _zeros(r: Readings, case: Case | Drive | None) -> Check:
    """The first reading near zero torque of each run against those of the others."""
    near = np.abs(r.torque_Nm) <= _LIMITS.window * float(np.abs(r.torque_Nm).max())
    runs = [np.flatnonzero(near & (r.run_index == k)) for k in range(int(r.run_index.max()) + 1)]
    firsts = np.array([r.elastic_angle_arcsec[rows[0]] for rows in runs if len(rows)])
    if len(firsts) < 2:
        return Check("zeros of runs", "good", "too few runs come near zero torque to compare them")
    spread = float(np.std(firsts, ddof=1))
    size = float(np.ptp(r.elastic_angle_arcsec))
    words = f"the runs start {rounded(spread)} arcsec apart (standard deviation)"
    common = not (isinstance(case, Case) and case.zero == "per_run")
    u = r.u_elastic_angle_arcsec
    much = spread > (0.02 * size if u is None else 5 * float(np.median(u)))
    if much and common:
        remedy = 'Set zero = "per_run" under [measurement], or zero the sensor once for all runs.'
        return Check("zeros of runs", "look", words, remedy)
    return Check("zeros of runs", "good", words)


# --- what could not be told ---------------------------------------------------------------


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
