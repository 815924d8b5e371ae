"""What instruments of a rig may add to the readings beside gain and zero, as data sheets state it.

torque_zeros       a torque sensor off zero
torque_lags        torque or angle that is late
torque_hystereses, sensor_hystereses   loops of both sensors
crosstalks         a preload that the torque changes
warm_ups           a zero that drifts until the instrument is warm
span_drifts        a ratio of angle to torque that drifts

Their sizes are shares of what the table reaches.
"""

from __future__ import annotations

from dataclasses import replace

from cbpt.lab.model.priors import STARTS_MOVING, Shape, Variant


def torque_zeros(torque_Nm: float, length_s: float | None) -> tuple[Variant, ...]:
    """A zero error of 0.2 to 20 % of the largest torque: from the first reading on, at the end of
    the table's time, or both."""
    low, high = 0.002 * torque_Nm, 0.2 * torque_Nm
    stays = Variant("torque_zero", ("zero_error_Nm",), low, high, signed=True, scaled=True)
    if not length_s:
        return (stays,)
    sizes = "zero_error_Nm", "zero_drift_Nm_per_s"
    drifts = replace(stays, needs="time_s", name="drifting")
    from_nothing = replace(drifts, sizes=sizes[1:], low=low / length_s, high=high / length_s)
    further = replace(drifts, sizes=sizes, ratios=(1.0, 1 / length_s), name="an error that drifts")
    return stays, from_nothing, further


def torque_lags(torque_Nm: float, rate_Nm_per_s: float) -> tuple[Variant, ...]:
    """Torque or angle late by 0.2 to 20 % of the largest torque at the rate of the table, from runs
    that begin at rest or while the torque changes."""
    low, high = 0.002 * torque_Nm / rate_Nm_per_s, 0.2 * torque_Nm / rate_Nm_per_s
    return tuple(
        Variant(effect, (size,), low, high, needs="time_s", scaled=True, fixed=start, name=name)
        for effect, size in (("torque_lag", "lag_s"), ("damping", "time_constant_s"))
        for start, name in (((), ""), (((STARTS_MOVING, 1.0),), "from moving starts"))
    )


def torque_hystereses(torque_Nm: float) -> tuple[Variant, ...]:
    """Half a loop's width as data sheets of torque sensors have it: 0.02 to 2 % of the largest
    torque."""
    low, high = 2e-4 * torque_Nm, 0.02 * torque_Nm
    return (Variant("torque_hysteresis", ("half_width_Nm",), low, high, True, scaled=True),)


def sensor_hystereses(angle_rad: float) -> tuple[Variant, ...]:
    """Half a loop's width of an angle sensor or its coupling: 0.02 to 5 % of the largest angle."""
    low, high = 2e-4 * angle_rad, 0.05 * angle_rad
    return (Variant("sensor_hysteresis", ("half_width_rad",), low, high, scaled=True),)


def crosstalks(torque_Nm: float, preload_N: float) -> tuple[Variant, ...]:
    """A preload that is off by 0.2 to 20 % at the largest torque: by a force, or by a share of what
    it is.
    """
    at = (("reference_torque_Nm", torque_Nm),)
    low, high = 0.002, 0.2
    force = Variant(
        "preload_crosstalk",
        ("crosstalk_force_N",),
        low * preload_N,
        high * preload_N,
        True,
        fixed=at,
        scaled=True,
        name="a force",
    )
    share = replace(force, sizes=("crosstalk_share",), low=low, high=high, name="a share")
    return force, share


def warm_ups(length_s: float | None, low_rad: float, high_rad: float) -> tuple[Variant, ...]:
    """A zero that drifts until the instrument is warm, within a thirtieth of the table's time or
    longer; what takes more than all of it is a drift in proportion to time."""
    if not length_s:
        return ()
    grid = (length_s / 12, length_s / 3)
    time = Shape("warm_up_time_s", length_s / 30, length_s, grid, log=True)
    form = Variant("drift", ("warm_up_rad",), low_rad, high_rad, True, (time,), needs="time_s")
    return (replace(form, name="warm-up"),)


def span_drifts(length_s: float | None, with_temperature: bool) -> tuple[Variant, ...]:
    """A ratio of angle to torque that is off by 0.1 to 20 % at the end, or by 0.02 to 2 % per
    kelvin."""
    found = []
    if length_s:
        size, low, high = ("rate_per_s",), 1e-3 / length_s, 0.2 / length_s
        form = Variant("span_drift", size, low, high, True, needs="time_s", name="time")
        found.append(replace(form, scaled=True))
    if with_temperature:
        size = ("rate_per_K",)
        form = Variant("span_drift", size, 2e-4, 0.02, True, needs="temperature_degC")
        found.append(replace(form, name="temperature", scaled=True))
    return tuple(found)
