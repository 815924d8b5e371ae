"""Loops of the model with the effects of its case, as a rig would run them.

    Conditions   what the loops are run at
    ModelLoops   the loops, and how each of the numbers of [uncertainty] moves them
    simulated    makes them

A run goes from zero torque through two whole cycles; figures are read off the second, so that what
belongs to the first loading alone is not part of them.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError
from cbpt.lab.characteristics.figures import Convention
from cbpt.lab.characteristics.loops import Loop, loops_of
from cbpt.lab.characteristics.uncertainty import LoopSet, play_of_form_arcsec, read_off
from cbpt.lab.model.dataset import stated_uncertainty
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.priors import PRIORS, VARIANTS
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]

_OF_RIG = ("torque_scale", "sensor_gain")
"""Calibrations of the instruments, which the model has no part in."""
_POINTS = 121
"""Torques of one leg."""
_FRICTIONS = (
    "friction_hysteresis",
    "distributed_friction",
    "rate_friction",
    "breakaway_friction",
)


@dataclass(frozen=True)
class Conditions:
    """What loops are run at."""

    amplitude_Nm: float
    small_amplitude_Nm: float | None = None
    """None: the same."""
    preload_N: float | None = None
    input_angle_deg: float = 0.0
    temperature_degC: float = 20.0
    rate_Nm_per_s: float | None = None
    """None: a loop takes a minute."""


@dataclass(frozen=True)
class ModelLoops:
    """Loops of the model; `shifted`: by number of [uncertainty], with it one u higher."""

    loops: LoopSet
    shifted: dict[str, LoopSet]
    play_arcsec: float
    """The jump at zero torque without friction."""
    u_play_arcsec: float
    """What the play depends on the form of the curve that is continued to no torque."""

    def type_b(self, convention: Convention) -> tuple[dict[str, float], dict[str, float]]:
        """The figures, and what all numbers together make uncertain about them."""
        value = read_off(self.loops, convention) | {"backlash": self.play_arcsec}
        square = dict.fromkeys(value, 0.0)
        for loops in self.shifted.values():
            moved = read_off(loops, convention)
            for name in value.keys() - {"backlash"}:  # geometry, which no stiffness moves
                change = moved[name] - value[name]
                square[name] += change**2 if np.isfinite(change) else 0.0
        square["backlash"] = self.u_play_arcsec**2
        return value, {name: float(np.sqrt(s)) for name, s in square.items()}


def simulated(case: Case | Drive, at: Conditions, convention: Convention) -> ModelLoops | str:
    """Loops of the model; a reason in words where it has no solution at these torques."""
    rows = _rows(case, at, convention)
    effects = [effect.id for effect in case.effects] if isinstance(case, Case) else []
    numbers = {e: u for e, u in stated_uncertainty(case).items() if e not in _OF_RIG and u > 0}
    model = Assembled(campaign_of(case, rows, ()), [*effects, *numbers])
    places = [model.places[len(effects) + i, _size(e)] for i, e in enumerate(numbers)]
    point = model.at(model.neutral, places)
    solved = np.isfinite(point.angle_arcsec)
    if not solved.all():
        first = int(np.flatnonzero(~solved)[0])
        status = model.states(model.neutral)[1][first]
        return f"the model has no solution at {rows.torque_Nm[first]:.4g} N m: {status}"
    shifted = {
        PRIORS[effect]: _loops(rows, point.angle_arcsec + u * point.slopes[:, i])
        for i, (effect, u) in enumerate(numbers.items())
    }
    shifted |= dict(_of_drive(case, rows, effects))
    bare = model.neutral.copy()
    for (instance, _), place in model.places.items():
        if model.effects[instance] in _FRICTIONS:
            bare[place] = model.nothing[place]
    free = _loops(rows, model.at(bare).angle_arcsec)
    play = read_off(free, convention)["backlash"]
    return ModelLoops(
        _loops(rows, point.angle_arcsec), shifted, play, play_of_form_arcsec(free, convention)
    )


def _size(effect: str) -> str:
    return next(v.sizes[0] for v in VARIANTS if v.effect == effect)


def _of_drive(
    case: Case | Drive, rows: Readings, effects: list[str]
) -> Iterator[tuple[str, LoopSet]]:
    """The same for the numbers of the drive whose uncertainty is stated."""
    if not isinstance(case, Case) or case.drive.kind != "ball_drive":
        return
    written = tomllib.loads(case.to_toml())
    for name, kind, size in case.spreads():
        section, _, key = name.partition(".")
        value = written.get(section, {}).get(key)
        if kind != "normal" or section == "load" or value is None:
            continue
        moved = case.with_numbers({name: value + size})
        model = Assembled(campaign_of(moved, rows, ()), effects)
        yield name, _loops(rows, model.at(model.neutral).angle_arcsec)


def _loops(rows: Readings, angle_arcsec: Floats) -> LoopSet:
    found = loops_of(replace(rows, elastic_angle_arcsec=angle_arcsec))
    last: dict[str, Loop] = {loop.run: loop for loop in found}
    return LoopSet([last["1"]], [last.get("2", last["1"])])


def _rows(case: Case | Drive, at: Conditions, convention: Convention) -> Readings:
    drive = case.drive if isinstance(case, Case) else case
    preload = at.preload_N
    if preload is None and isinstance(case, Case):
        preload = case.preload_N
    if preload is None and drive.kind == "ball_drive":
        raise InvalidInputError("preload_N: the case has no [load] preload_N; state one there")
    amplitudes = [a for a in (at.amplitude_Nm, at.small_amplitude_Nm) if a is not None]
    runs = [_torques(amplitude, convention) for amplitude in amplitudes]
    torque = np.concatenate(runs)
    n = len(torque)
    rate = at.rate_Nm_per_s or at.amplitude_Nm / 15.0
    return Readings(
        torque_Nm=torque,
        preload_N=None if preload is None else np.full(n, preload),
        input_angle_deg=np.full(n, at.input_angle_deg),
        elastic_angle_arcsec=np.full(n, np.nan),
        u_elastic_angle_arcsec=None,
        run=np.repeat(np.arange(1, len(runs) + 1), [len(run) for run in runs]),
        time_s=np.r_[0.0, np.cumsum(np.abs(np.diff(torque)))] / rate,
        cycle=None,
        temperature_degC=np.full(n, at.temperature_degC),
        line=np.arange(1, n + 1),
        source="the model's loops",
    )


def _torques(amplitude: float, convention: Convention) -> Floats:
    """From zero to the amplitude and through two cycles, on the torques that figures need."""
    rated = convention.rated_torque_Nm
    marks = [0.0, convention.window_Nm, 0.5 * rated, rated, *(convention.breaks_Nm or ())]
    grid = np.linspace(0.0, amplitude, _POINTS // 2 + 1)
    inside = [mark for mark in marks if mark <= amplitude]
    half = np.unique(np.round(np.r_[grid, inside], 12))
    up = np.r_[-half[:0:-1], half]
    return np.concatenate([half, up[-2::-1], up[1:], up[-2::-1], up[1:]])
