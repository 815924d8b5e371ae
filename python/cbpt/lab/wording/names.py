"""Effects, kinds of noise and columns of readings in words.

called              the name of an effect in a sentence, for a kind of reducer
number_called       the same of a number of the drive or the rig
tell_tale           how an effect shows in the readings
columns_in_words    what something depends on
scatter_from        what the scatter of readings was taken from
"""

from __future__ import annotations

from collections.abc import Sequence

from cbpt._core import effect_specs
from cbpt.lab.wording.numbers import listed

NAMES = {
    "unknown": "an effect that is not in the library",
    "contact_stiffness": "a contact stiffness other than designed",
    "contact_angle": "contact angles other than designed",
    "torque_scale": "a wrong gain of the torque readings",
    "torque_zero": "a zero error of the torque readings",
    "torque_lag": "torque readings that lag behind the angle",
    "torque_hysteresis": "hysteresis of the torque sensor",
    "preload_crosstalk": "a preload that depends on the torque",
    "preload_scale": "a wrong gain of the preload readings",
    "shaft_shift": "a sideways shift of the output shaft under load",
    "loose_fixture": "a fixture that slips through its clearance",
    "sensor_hysteresis": "hysteresis of the angle sensor or slack of its coupling",
    "sensor_gain": "a wrong gain of the angle sensor",
    "sensor_nonlinearity": "a nonlinear angle sensor",
    "run_offset": "an offset that differs from run to run",
    "drift": "a drift of the instrument",
    "span_drift": "a ratio of angle to torque that drifts (the sensor's span, or the stiffness)",
    "eccentric_bearing": "compliance of the eccentric bearing",
    "bearing_play": "play in the bearing",
    "backlash": "backlash",
    "output_torsion": "torsion of the output shaft",
    "stiffness_curve": "a stiffness that changes with the load otherwise than stated",
    "hard_stop": "a hard stop",
    "friction_hysteresis": "friction (a hysteresis loop)",
    "distributed_friction": "friction of contacts that slip one after another",
    "rate_friction": "friction that grows with the rate",
    "breakaway_friction": "friction that breaks away (sticks and slips)",
    "damping": "an angle that lags behind the torque (damping, or a slow angle sensor)",
    "preload_loss": "preload that does not reach the meshing points",
    "preload_spring": "a stiff preload mechanism (the preload changes as the plates move)",
    "thermal_preload": "preload that follows the temperature",
    "eccentricity_error": "an eccentricity error (once per turn of the input)",
    "groove_pitch_error": "a pitch error of the groove",
    "ball_diameter_lot": "balls of unequal diameter",
    "plate_tilt": "a tilt between the plates",
    "rough_contact": "contacts softer than Hertz's (rough surfaces)",
    "run_in": "a permanent set after the first loading",
    "wear": "preload that is lost with time",
    "creep": "creep under torque",
}
"""What each effect is called in a sentence."""

_OF_SPRINGS = {
    "contact_stiffness": "a torsional stiffness other than stated",
    "eccentric_bearing": "a compliance that stiffens with the load",
}

_NUMBERS = {
    "contact_stiffness": "the contact stiffness",
    "contact_angle": "the contact angle",
    "torque_scale": "the gain of the torque readings",
    "preload_scale": "the gain of the preload readings",
    "sensor_gain": "the gain of the angle sensor",
}

_TELL_TALES = {spec.id: spec.tell_tale for spec in effect_specs()}
_TELL_TALES_OF_SPRINGS = {
    "torque_scale": "shifts the bends of the curve along the torque axis",
    "torque_zero": "shifts the whole curve along the torque axis, its loop with it",
    "shaft_shift": "one sign at torques of both signs, in proportion to the torque; under one sign "
    "a softer spring",
    "sensor_gain": "scales every angle; the bends of the curve stay at their torques",
    "eccentric_bearing": "grows with torque, less than in proportion",
    "output_torsion": "linear in torque, no loop",
    "friction_hysteresis": "a loop, wider at high torque if friction grows with the load; the "
    "first loading of a run appears stiffer",
}
"""Used where the text of the library speaks of preload or contacts: a torsion spring has none."""

_COLUMNS = {
    "torque_Nm": "the torque",
    "preload_N": "the preload",
    "preload_step": "the preload step",
    "input_angle_deg": "the input angle",
    "direction": "the direction of loading",
    "time_s": "time",
    "order": "the order of the readings",
    "run_time_s": "the time since a run began",
    "torque_rate": "the rate of loading",
    "temperature_degC": "the temperature",
    "cycle": "the cycle",
    "run": "the run",
}


def called(effect: str, kind: str) -> str:
    """The name of an effect in a sentence, for a reducer of that kind."""
    own = _OF_SPRINGS if kind == "torsion_spring" else {}
    return own.get(effect, NAMES.get(effect, effect))


def number_called(number: str, kind: str) -> str:
    """The name of a number of the drive or the rig, for a reducer of that kind."""
    if kind == "torsion_spring" and number == "contact_stiffness":
        return "the torsional stiffness"
    return _NUMBERS.get(number, number)


def tell_tale(effect: str, kind: str) -> str:
    """How an effect of the library shows in readings of a reducer of that kind."""
    own = _TELL_TALES_OF_SPRINGS if kind == "torsion_spring" else {}
    return own.get(effect, _TELL_TALES.get(effect, ""))


def scatter_from(source: str | None) -> str | None:
    """What the scatter of readings was taken from (`Adequacy.source`); None for a scatter that is
    not told beside a misfit, as a part of it can be misfit."""
    return None if source == "scatter within runs" else source


def columns_in_words(columns: Sequence[str]) -> str:
    """What a misfit depends on: the torque and the input angle."""
    return listed([_COLUMNS.get(c, c) for c in columns])
