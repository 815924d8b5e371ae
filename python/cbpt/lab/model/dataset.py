"""Readings as the statistics need them.

Campaign            angles in arcsec, uncertainties, order of rows, offsets, priors
stated_uncertainty  of the numbers of drive and instruments
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, OwnEffect, effect_specs
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.covariance.artefacts import Artefact
from cbpt.lab.covariance.linear_gaussian import Held, Noise, Rows
from cbpt.lab.covariance.repeatability import Repeats
from cbpt.lab.covariance.rounding import rounds_alike, with_step, without_step
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.model.priors import LOT, PRIORS, Variant
from cbpt.lab.model.table_curve import curve_errors
from cbpt.lab.readings.reader import Readings

Floats = NDArray[np.float64]
History = Literal["by_clock", "released", "carried", "carried_from_above", "carried_from_below"]
Turns = Literal["where_ramps_meet", "between_readings", "at_readings"]
Mask = NDArray[np.bool_]

# Known no better than this where a table states no uncertainty; found from the scatter instead.
_UNSTATED_ARCSEC = 1.0


@dataclass(frozen=True, eq=False)
class Campaign:
    """Readings of a drive, all arrays of shape (n,)."""

    drive: Drive
    readings: Readings
    y_arcsec: Floats
    u_arcsec: Floats
    """Standard uncertainty of each reading, without the rounding of a coarse display."""
    u_stated: bool
    rows: Rows
    priors: dict[str, float]
    """Standard uncertainty of each number that is a `PRIORS` effect, by effect id."""
    effects: tuple[tuple[str, dict[str, float]], ...] = ()
    """Effects that the case has, each with its numbers, SI."""
    u_believed: float = 1.0
    """What the stated uncertainty was multiplied by, where it cannot be meant as it stands."""
    step_arcsec: float = 0.0
    """Step of the display where it is coarse against the uncertainty, else 0."""
    rounding_arcsec: Floats | None = None
    """Standard deviation of each reading by the rounding of a coarse display, beside `u_arcsec`."""
    held: Held | None = None
    """The error of the mean torque of each hold, where means stand for the torque readings."""
    torque_errors: Artefact | None = None
    """What the errors of torques do that are means or ramps through many readings."""
    curve_errors: Artefact | None = None
    """What a torsion spring's table leaves open between its points."""
    own: dict[str, OwnEffect] = field(default_factory=dict)
    """Effects of the user's own by id: those of the case, and those to be fitted."""
    candidates: tuple[Variant, ...] = ()
    """Forms of the own effects that are to be fitted."""
    torque_scatter_Nm: float = 0.0
    """Scatter of the torques about their ramps that `u_arcsec` holds, beside what is stated."""
    repeats: Repeats | None = None
    """What readings taken again say of the uncertainty, where that was asked."""
    history: History = "by_clock"
    """Whether friction goes on where a run begins as the one before it ended: if both are timed by
    one clock, at no run, or by whatever clocks; then also what was done before the first run."""
    torque_turns: Turns = "where_ramps_meet"
    """Where the torque of a ramp turns back: where the ramps beside meet, unless all turns meet the
    clock alike; there in any case; or at readings."""
    zero_per_run: bool = False
    """Whether every run has an offset of its own, else all share one."""

    @classmethod
    def of(cls, case: Case | Drive, readings: Readings) -> Campaign:
        """From a case and its readings. Raises `ReadingsError` where there is no preload."""
        drive = case if isinstance(case, Drive) else case.drive
        if readings.preload_N is None and drive.kind == "ball_drive":
            raise ReadingsError.of_table(
                readings.source, "preload_N", "a preload for every reading"
            )
        u = readings.u_elastic_angle_arcsec
        # Without a stated uncertainty the scatter decides; exact readings have none, so there is a
        # floor far below what an instrument can.
        size = max(1e-3 * float(np.ptp(readings.elastic_angle_arcsec)), 1e-6)
        stated = np.full(len(readings), min(_UNSTATED_ARCSEC, size)) if u is None else u
        step = display_step(readings.elastic_angle_arcsec)
        coarse = step > 1.5 * float(np.median(stated)) if u is not None else False
        rounding = None
        if coarse:
            # The drive hardly knows the input angle and is the same both ways, so readings at one
            # torque and preload may round alike, and averaging those helps no further.
            same = np.zeros(len(readings)) if readings.preload_N is None else readings.preload_N
            loads = np.column_stack([np.abs(readings.torque_Nm), same])
            repeats = len(readings) / len(np.unique(np.round(loads, 6), axis=0))
            alike = rounds_alike(float(np.median(stated)) / step)
            square = step**2 / 12 * (1 + (repeats - 1) * alike)
            rounding = np.full(len(readings), np.sqrt(square))
            stated = without_step(stated, step)
        between = curve_errors(drive, readings.torque_Nm)
        return cls(
            drive=drive,
            readings=readings,
            y_arcsec=readings.elastic_angle_arcsec,
            u_arcsec=stated,
            u_stated=u is not None,
            effects=_effects_of(case),
            own={own.id: own for own in case.own_effects} if isinstance(case, Case) else {},
            step_arcsec=step if coarse else 0.0,
            rounding_arcsec=rounding,
            rows=Rows.of(readings.run_index),
            zero_per_run=isinstance(case, Case) and case.zero == "per_run",
            history=cast("History", case.friction_between_runs)
            if isinstance(case, Case)
            else "by_clock",
            torque_turns=cast("Turns", case.torque_turns)
            if isinstance(case, Case)
            else "where_ramps_meet",
            priors=stated_uncertainty(case),
            curve_errors=None if between is None else Artefact("known", between),
        )

    def __len__(self) -> int:
        return len(self.y_arcsec)

    @cached_property
    def step_s(self) -> float:
        """Typical time from a reading to the next one of its run, s; 0 where none is known."""
        time, before = self.readings.time_s, self.rows.before
        if time is None:
            return 0.0
        follows = before >= 0
        steps = time[follows] - time[before[follows]]
        return float(np.median(steps)) if len(steps) else 0.0

    @cached_property
    def offsets(self) -> Floats:
        """Columns (n, z) of the offsets that are always free: one, or one for each run.

        Made when they are asked for, as a long table is thinned before that.
        """
        return self.rows.columns() if self.zero_per_run else np.ones((len(self), 1))

    @property
    def u_reading_arcsec(self) -> Floats:
        """Standard uncertainty of each reading by itself, with its rounding, shape (n,)."""
        stated = self.readings.u_elastic_angle_arcsec
        if not self.step_arcsec or stated is None:
            return self.u_arcsec
        return with_step(stated, self.step_arcsec)

    @property
    def plain_noise(self) -> Noise:
        """White noise of the stated size."""
        return Noise(
            rounding_arcsec=self.rounding_arcsec, held=self.held, artefact=self.known_errors
        )

    @property
    def known_errors(self) -> Artefact | None:
        """Errors of many readings at once whose size is known before they are read."""
        if self.torque_errors is None:
            return self.curve_errors
        return self.torque_errors.beside(self.curve_errors)

    @property
    def u_repeated(self) -> bool:
        """Whether the uncertainty is that of the repeats, as none is stated."""
        return not self.u_stated and self.repeats is not None and self.repeats.steady

    @property
    def balls(self) -> int:
        """Number of deceleration balls; a torsion spring has none."""
        return self.drive.deceleration_ball_count if self.drive.kind == "ball_drive" else 0

    def select(self, rows: Mask) -> Campaign:
        """Some of the readings; history along a run is then that of the rows that are left."""
        return replace(
            self,
            readings=self.readings.select(rows),
            y_arcsec=self.y_arcsec[rows],
            u_arcsec=self.u_arcsec[rows],
            rounding_arcsec=None if self.rounding_arcsec is None else self.rounding_arcsec[rows],
            held=None if self.held is None else self.held.select(rows),
            torque_errors=None if self.torque_errors is None else self.torque_errors.select(rows),
            curve_errors=None if self.curve_errors is None else self.curve_errors.select(rows),
            rows=self.rows.select(rows),
        )


def _effects_of(case: Case | Drive) -> tuple[tuple[str, dict[str, float]], ...]:
    if isinstance(case, Drive):
        return ()
    found = tuple((effect.id, dict(effect.values)) for effect in case.effects)
    ids = [effect for effect, _ in found]
    twice = next((i for i in ids if ids.count(i) > 1 and i != LOT), None)
    if twice:
        raise InvalidInputError(
            f"effect {twice} is in the case more than once and cannot be fitted; keep one of them"
        )
    return found


DEFAULT_UNCERTAINTY = {
    "contact_stiffness": 0.10,
    "contact_angle": float(np.deg2rad(0.5)),
    "torque_scale": 0.01,
    "preload_scale": 0.02,
    "sensor_gain": 0.005,
}


def stated_uncertainty(case: Case | Drive) -> dict[str, float]:
    """Of each number that is a `PRIORS` effect: as the case says, else the defaults."""
    stated = {}
    kind = (case.drive if isinstance(case, Case) else case).kind
    suited = {spec.id for spec in effect_specs() if kind in spec.reducers}
    if isinstance(case, Case):
        stated = tomllib.loads(case.to_toml()).get("uncertainty", {})
    return {
        effect: float(stated.get(key, DEFAULT_UNCERTAINTY[effect]))
        for effect, key in PRIORS.items()
        if effect in suited
    }
