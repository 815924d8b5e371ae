"""The model of a reducer with effects on the rows of a data set.

Assembled  predicts every reading, and how that moves with every parameter
Point      values of all parameters with what the model says there
REGIMES    words for the contact regimes
"""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Drive, Misfit, Prediction, Predictor
from cbpt.lab.model.dataset import Campaign
from cbpt.results import ARCSEC_PER_RAD

Floats = NDArray[np.float64]

REGIMES = np.array([""] * 256, dtype="U32")
REGIMES[:3] = "all points loaded", "points parting", "below continuous transmission"
"""Words for the codes of `Predictor`."""


@dataclass(frozen=True, eq=False)
class Point:
    """The model at some values of its parameters."""

    values: Floats
    """All parameters, SI, shape (p,)."""
    angle_arcsec: Floats
    """Shape (n,); NaN where there is no solution."""
    slopes: Floats = field(repr=False)
    """Shape (n, wanted), arcsec per SI unit of the parameter."""

    @property
    def parts(self) -> tuple[Floats, Floats, Floats]:
        """As compiled code takes them."""
        return self.values, self.angle_arcsec, self.slopes


class Assembled:
    """A drive with effects, on the rows of one campaign; an effect may appear several times."""

    def __init__(self, campaign: Campaign, effects: Sequence[str]) -> None:
        r = campaign.readings
        self.effects = tuple(effects)
        self._predictor = Predictor(
            campaign.drive,
            [campaign.own.get(effect, effect) for effect in effects],
            campaign.rows.run_index,
            _or_zero(r.time_s, len(r)),
            r.torque_Nm,
            r.preload_N,
            np.deg2rad(r.input_angle_deg),
            None if r.temperature_degC is None else r.temperature_degC,
            None if r.cycle is None else np.asarray(r.cycle, dtype=np.float64),
            campaign.torque_turns,
        )
        self._predictor.take_history(campaign.history)
        self.nothing = self._predictor.neutral()
        """Values at which every effect does nothing."""
        self.neutral = self.nothing.copy()
        """Values at which nothing is added to the case: its own effects keep theirs."""
        parameters = self._predictor.parameters
        self.lower = np.array([p.lower for _, _, p in parameters])
        self.upper = np.array([p.upper for _, _, p in parameters])
        """Limits of what the equations take."""
        self.likely = np.array([p.range for _, _, p in parameters], dtype=np.float64).reshape(-1, 2)
        """Range of what is plausible, shape (p, 2)."""
        self.places = {(owner, p.name): i for i, (owner, _, p) in enumerate(parameters)}
        """Place of each parameter among the values, by instance of an effect and name."""
        for (_, name), i in self.places.items():
            if name == "contact_angle_shift_rad":
                low, high = _contact_angles(campaign.drive)
                self.lower[i] = max(self.lower[i], 0.02 - low)
                self.upper[i] = min(self.upper[i], np.pi / 2 - 0.02 - high)
        met: dict[str, int] = {}
        for effect, numbers in campaign.effects:
            instances = [i for i, known in enumerate(self.effects) if known == effect]
            number = met.get(effect, 0)
            met[effect] = number + 1
            if number < len(instances):
                for name, value in numbers.items():
                    self.neutral[self.places[instances[number], name]] = value
        for variant in campaign.candidates:
            for instance, effect in enumerate(self.effects):
                if effect == variant.effect:
                    self.neutral[[self.places[instance, size] for size in variant.sizes]] = 0.0
        balls = [i for (_, name), i in self.places.items() if name == "ball"]
        self.neutral[balls] = np.arange(len(balls)) % max(campaign.balls, 1)

    def index(self, instance: int, name: str) -> int:
        """Place of a parameter among the values; `3.name` is that of the third instance after."""
        number, dot, stem = name.partition(".")
        return self.places[instance + int(number), stem] if dot else self.places[instance, name]

    @property
    def runs_that_go_on(self) -> int:
        """Runs that begin where the one before them ended, with the friction that it has left."""
        return self._predictor.runs_that_go_on

    @property
    def turns_between_readings(self) -> list[int]:
        """Of each turn of the torque between readings the row before it, or over it."""
        return self._predictor.turns_between_readings

    @property
    def readings_are_means(self) -> bool:
        """Whether all readings are means over time, as those over a turn show."""
        return self._predictor.readings_are_means

    @property
    def runs_with_unmeasured_past(self) -> int:
        """Runs that go on from a repetition of themselves, or a loop, that nobody measured."""
        return self._predictor.runs_with_unmeasured_past

    def beside(self) -> Assembled:
        """Another one like it, for a thread of its own."""
        other = copy(self)
        other._predictor = copy(self._predictor)
        return other

    def cold(self) -> None:
        """What is asked next does not depend, to the last bit, on what was asked before."""
        self._predictor.cold()

    def at(self, values: Floats, wanted: Sequence[int] = ()) -> Point:
        """Prediction and the slopes of the wanted parameters."""
        return _point(values, self._predictor.predict(values, list(wanted)))

    def search(
        self, misfit: Misfit, start: Point, limits: tuple[int, float, bool]
    ) -> tuple[Point, bool]:
        """The most probable point from a start, and whether the search came to its end. limits: as
        `Misfit.search` takes them."""
        found, ended = misfit.search(self._predictor, start.parts, limits)
        return Point(*found) if found else start, ended

    def states(self, values: Floats) -> tuple[Floats, NDArray[np.str_]]:
        """Angle in arcsec and status of each row."""
        found = self._predictor.predict(values)
        return found.angle_rad * ARCSEC_PER_RAD, np.array(found.status, dtype=np.str_)

    def regimes(self, values: Floats) -> NDArray[np.str_]:
        """Contact regime of each row."""
        return REGIMES[self._predictor.predict(values).regime]

    def with_regimes(self, values: Floats) -> tuple[Point, NDArray[np.str_]]:
        """Prediction, and the contact regime of each row."""
        found = self._predictor.predict(values)
        return _point(values, found), REGIMES[found.regime]


def _point(values: Floats, found: Prediction) -> Point:
    return Point(values, found.angle_rad * ARCSEC_PER_RAD, found.sensitivities * ARCSEC_PER_RAD)


def _contact_angles(drive: Drive) -> tuple[float, float]:
    """The least and the greatest contact angle of all pairs, rad."""
    pairs = tomllib.loads(drive.to_toml())
    angles = [
        value
        for pair in ("deceleration", "equal_speed")
        for name, value in pairs[pair].items()
        if name.endswith("contact_angle_rad")
    ]
    return min(angles), max(angles)


def _or_zero(column: NDArray[np.float64] | None, n: int) -> Floats:
    return np.zeros(n) if column is None else column
