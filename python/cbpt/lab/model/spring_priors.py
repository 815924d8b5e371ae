"""The library that suits a reducer.

library_of             forms of effects with what is plausible for them, and those asked for
typical_rate_Nm_per_s  at which a table's torque changes

The sizes of `library` are those of ball drives. A torsion spring may turn by seconds of arc or by
degrees, so its sizes are shares of what the table reaches: the largest torque, the angle that the
spring as stated turns under it, the length of the longest run.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.instrument_priors import (
    crosstalks,
    sensor_hystereses,
    span_drifts,
    torque_hystereses,
    torque_lags,
    torque_zeros,
    warm_ups,
)
from cbpt.lab.model.own_loops import WIDEST_TRANSITION, small_loops_of
from cbpt.lab.model.priors import (
    ARCSEC,
    ASYMMETRY,
    BUILD_UP,
    EXPONENT,
    LAG,
    ODDS,
    SETTLING,
    VARIANTS,
    Floats,
    Shape,
    Variant,
    constant_frictions,
    creeps,
    joints,
    slowing_wear,
    soft_plays,
    within_limits,
)
from cbpt.lab.readings.readings import Readings
from cbpt.results import solve_many


def library_of(
    campaign: Campaign, asked: Sequence[str] = (), beside: Sequence[Campaign] = ()
) -> tuple[Variant, ...]:
    """Every form of every effect that its reducer can have; of those that no diagnosis proposes,
    those asked for, by effect or form. beside: other campaigns that are fitted with this one: of
    these the usual forms and those asked for alone, as what real loops leave at all of them would
    choose a rare one."""
    forms = map(within_limits, _forms_of(campaign, asked, beside))
    return tuple(
        v for v in forms if v is not None and (v.odds >= 1 or not beside or v.label in asked)
    )


def _forms_of(
    campaign: Campaign, asked: Sequence[str], beside: Sequence[Campaign]
) -> tuple[Variant, ...]:
    """The same, in ranges that may go beyond what the equations take."""
    if campaign.drive.kind == "ball_drive":
        torque = float(np.abs(campaign.readings.torque_Nm).max()) or 1.0
        read = [c.readings.preload_N for c in (campaign, *beside)]
        preload = np.concatenate([p for p in read if p is not None])
        # At one preload it is the friction that follows the preload.
        several = np.ptp(preload) > 0.01 * preload.mean()
        proposed = (
            *VARIANTS,
            *(constant_frictions(torque) if several else ()),
            *soft_plays(torque),
            *joints(torque),
            *slowing_wear(_length_s(campaign)),
            *torque_zeros(torque, _length_s(campaign)),
            *warm_ups(_length_s(campaign), 0.1 * ARCSEC, 30.0 * ARCSEC),
            *_of_instruments(campaign, torque),
            *_rate_frictions(campaign),
        )
    else:
        wide = {"hard_stop"}.intersection(asked)  # in the range of what is asked for
        proposed = tuple(v for v in _of_spring(campaign) if v.effect not in wide)
    offered = {v.effect for v in proposed}
    labels = {v.label for v in proposed}
    if all(a in offered or a in labels for a in asked):
        return proposed
    torque, angle = _reach(campaign)
    further = (
        *_on_request(campaign),
        *_of_instruments(campaign, torque),
        # What a drifting zero error leaves free would follow what no effect does.
        *(v for v in torque_zeros(torque, _length_s(campaign)) if len(v.sizes) == 1),
        _shift(angle / torque),
        _loose_fixture(torque, angle),
    )
    return *proposed, *(
        v
        for v in further
        if v.label not in labels
        and (v.label in asked or (v.effect in asked and v.effect not in offered))
    )


def _of_instruments(campaign: Campaign, torque_Nm: float) -> Iterator[Variant]:
    """What data sheets of a rig's instruments state beside gain and zero."""
    readings = campaign.readings
    yield from _lags(campaign, torque_Nm)
    yield from torque_hystereses(torque_Nm)
    yield from sensor_hystereses(_reach(campaign)[1])
    if readings.preload_N is not None and campaign.drive.kind == "ball_drive":
        yield from crosstalks(torque_Nm, float(readings.preload_N.mean()))
    yield from span_drifts(_length_s(campaign), readings.temperature_degC is not None)


def _length_s(campaign: Campaign) -> float | None:
    """From the first reading to the last; None without times."""
    time_s = campaign.readings.time_s
    return None if time_s is None else float(np.ptp(time_s))


def _rate_frictions(campaign: Campaign) -> Iterator[Variant]:
    """Friction that depends on the rate, where a lag of the torque, its twin, is proposed too."""
    if _lags(campaign, 1.0):
        yield from (form for form in _on_request(campaign) if form.effect == "rate_friction")


def _lags(campaign: Campaign, torque_Nm: float) -> tuple[Variant, ...]:
    """A lag of the torque readings, where the torque changes with time."""
    rate = typical_rate_Nm_per_s(campaign.readings)
    return () if rate is None else torque_lags(torque_Nm, rate)


def typical_rate_Nm_per_s(readings: Readings) -> float | None:
    """At which the torque changes where it does; None where it does not, or without times."""
    rates = _rates_Nm_per_s(readings)
    return float(np.median(rates)) if rates.size else None


def _slowest(readings: Readings) -> float:
    """The rate that one step of the torque in ten is slower than, over the typical one."""
    rates = _rates_Nm_per_s(readings)
    return float(np.quantile(rates, 0.1) / np.median(rates)) if rates.size else 1.0


def _rates_Nm_per_s(readings: Readings) -> NDArray[np.float64]:
    """Of the steps of the torque along the runs; none without times."""
    if readings.time_s is None:
        return np.zeros(0)
    order = np.lexsort((readings.time_s, readings.run_index))
    same_run = np.diff(readings.run_index[order]) == 0
    time_s = np.diff(readings.time_s[order])[same_run]
    step_Nm = np.abs(np.diff(readings.torque_Nm[order]))[same_run]
    moving = (time_s > 0) & (step_Nm > 0)
    return np.asarray(step_Nm[moving] / time_s[moving])


def _reach(campaign: Campaign) -> tuple[float, float]:
    """Largest torque of the table and the angle that goes with it: N m, rad. The angle is half of
    what the readings turn by, as a stiffness may be stated ten times too large; where nothing was
    read it is what the reducer as stated turns."""
    torque = float(np.abs(campaign.readings.torque_Nm).max()) or 1.0
    seen = max(_half_span_rad(campaign, run) for run in range(campaign.rows.runs))
    if seen > 0:
        return torque, seen
    preload = campaign.readings.preload_N
    most = 0.0 if preload is None else float(preload.max())
    turned = solve_many(campaign.drive, [-torque, torque], most).elastic_angle_rad
    return torque, float(np.nanmax(np.abs(turned), initial=0.0)) or 60 * ARCSEC


def _half_span_rad(campaign: Campaign, run: int) -> float:
    """Half of what nearly all readings of a run turn by; outliers have no say."""
    own = campaign.y_arcsec[campaign.rows.run_index == run]
    own = own[np.isfinite(own)]
    return 0.5 * float(np.ptp(np.quantile(own, (0.02, 0.98)))) * ARCSEC if len(own) else 0.0


def _on_request(campaign: Campaign) -> Iterator[Variant]:
    """What not every diagnosis proposes, in shares of what the table reaches."""
    torque, angle = _reach(campaign)
    exponent = Shape("slip_exponent", -0.8, 2.0, (0.0,))
    slip = _ranged("slip_angle_rad", angle, 1e-3, 3.0, (0.03, 0.15, 0.6))
    breaks_away = (
        _ranged("engagement_angle_rad", angle, 1e-3, 1.0, (0.01, 0.04, 0.15)),
        _ranged("breakaway_share", 1.0, 0.02, 5.0, (0.1, 0.5, 2.0)),
        _ranged("weakening_ratio", 1.0, 1.5, 50.0, (3.0, 10.0)),
    )
    forms = [("friction_torque_Nm", torque, "")]
    if campaign.readings.preload_N is not None:
        by_preload = "friction_radius_m", torque / _mean_preload(campaign), "preload_N"
        forms = [by_preload] if campaign.drive.kind == "ball_drive" else [*forms, by_preload]
    for size, unit, needs in forms:
        name = "with the preload" if needs else "constant"
        friction = _of("distributed_friction", (size,), unit, 1e-3, 0.7)
        yield _with(friction, (slip, exponent), name, needs)
        yield _with(_of("breakaway_friction", (size,), unit, 1e-3, 0.7), breaks_away, name, needs)
        if campaign.readings.time_s is not None:
            swings = 4 * angle / max(_longest_run(campaign), 1e-9)
            # Where the slowest ramp is fast beside it, the friction is one that does not grow.
            least = 0.5 * _slowest(campaign.readings)
            grid = tuple(max(share, least) for share in (0.1, 1.0, 10.0))
            rate = _ranged("reference_rate_rad_per_s", swings, least, 1e2, grid)
            yield _with(_of("rate_friction", (size,), unit, 1e-3, 0.7), (rate,), name, "time_s")
    yield _hard_stop(torque, 0.05, (0.2, 0.4, 0.6, 0.8))


def _plays(torque: float, angle: float, transition: Shape) -> Iterator[Variant]:
    """At next to no torque; or where a weight on the output, which holds it to one flank, is
    outweighed: as likely as the zero error of the torque readings that this looks like."""
    play = _of("backlash", ("play_rad",), angle, 1e-3, 3.0)
    yield _with(play, (transition,))
    least, most = 0.04 * torque, torque / 3
    grid = tuple(share * torque for share in (0.07, 0.15, 0.25))
    for centre, side in (
        (Shape("centre_torque_Nm", least, most, grid), "above"),
        (Shape("centre_torque_Nm", -most, -least, tuple(-m for m in grid)), "below"),
    ):
        form = _with(play, (transition, centre), f"off centre, {side}")
        instead = (("centre_torque_Nm", ("torque_zero", "zero_error_Nm")),)
        yield replace(form, odds=ODDS[""] / 2, instead=instead)


def _loose_fixture(torque: float, angle: float) -> Variant:
    """What next to nothing holds is a play, and what the largest torque hardly overcomes is seen by
    a reading or two."""
    holding = _ranged("holding_torque_Nm", torque, 0.03, 0.95, (0.1, 0.25, 0.45, 0.7))
    transition = _ranged("transition_torque_Nm", torque, 1e-3, WIDEST_TRANSITION, (0.01, 0.05))
    play = _of("loose_fixture", ("fixture_play_rad",), angle, 1e-3, 1.0)
    first = Shape("first_share", -0.5, 0.5, (-0.5, 0.0, 0.5))
    return _with(play, (holding, transition, first))


def _hard_stop(torque: float, low: float, grid: tuple[float, ...]) -> Variant:
    stop = _ranged("stop_torque_Nm", torque, low, 0.98, grid)
    return _with(_of("hard_stop", ("taken_share",), 1.0, 0.02, 1.0), (stop,))


def _frictions(campaign: Campaign, torque: float, angle: float) -> Iterator[Variant]:
    """Friction that follows the preload or not, and that grows with the load or not."""
    # Before contacts slip they yield along their surface by less than across it, by a share of the
    # order of the coefficient of friction (Mindlin, J. Appl. Mech. 16, 1949).
    engagement = _ranged("engagement_angle_rad", angle, 1e-4, 0.5, (0.001, 0.01, 0.04, 0.15))
    for size, unit, needs in (
        ("friction_torque_Nm", torque, ""),
        ("friction_radius_m", torque / _mean_preload(campaign), "preload_N"),
    ):
        name = "with the preload" if needs else "constant"
        # What turned under a torque was held by less. A fit may go three times as far as this.
        friction = _of("friction_hysteresis", (size,), unit, 1e-3, 1 / 3)
        growing = _of("friction_hysteresis", (size, "load_share"), unit, 1e-3, 1 / 6)
        growing = replace(growing, ratios=(1.0, 1 / unit))
        for shapes, how in (((engagement,), ""), ((engagement, BUILD_UP), ", to a sharp limit")):
            yield _with(friction, shapes, f"{name}{how}", needs)
            yield _with(growing, shapes, f"{name}, growing with the load{how}", needs)


def _sensor_curve(angle: float) -> Variant:
    """A curve 1/angle per angle is an error as large as the angle itself, at the largest torque; of
    no sensor that anyone measures with it is more than a twentieth."""
    names = "quadratic_per_rad", "cubic_per_rad2"
    curve = _of("sensor_nonlinearity", names, 1 / angle, 1e-3, 0.05)
    return _signed(curve, ratios=(1.0, 1 / angle))


def _stiffness_curves(torque: float, angle: float) -> Iterator[Variant]:
    """Alike under both signs of the torque or nearly. Without friction or play nothing tells them
    from a sensor that bends."""
    for second, name, ratio in (("cubed_rad", "", 1.0), ("skewed_rad", "skewed", 0.1)):
        curve = _of("stiffness_curve", ("squared_rad", second), angle, 1e-3, 0.5)
        curve = _signed(curve, name, ratios=(1.0, ratio))
        yield replace(curve, fixed=(("reference_torque_Nm", torque),))
    # As makers of strain-wave gears state it. What is soft below the range of T1 is a play; with
    # one break torque alone it is a joint with a stop.
    first = _ranged("break_torque_1_Nm", torque, 0.1, 0.5, (0.15, 0.3))
    then = _ranged("break_torque_2_Nm", torque, 0.5, 0.95, (0.6, 0.8))
    softer = "added_compliance_1_rad_per_Nm", "added_compliance_2_rad_per_Nm"
    pieces = _of("stiffness_curve", softer, angle / torque, 1e-3, 1.0)
    yield replace(_with(pieces, (first, then), "in pieces"), ratios=(1.0, 1.0))


def _instruments_of_spring(campaign: Campaign, torque: float, angle: float) -> Iterator[Variant]:
    """Errors of angle and torque sensor, and what looks like a late one."""
    yield _sensor_curve(angle)
    yield from sensor_hystereses(angle)
    # A load that lags behind its readings is friction.
    yield from (replace(v, signed=False) for v in torque_hystereses(torque))
    yield from _lags(campaign, torque)
    yield from _rate_frictions(campaign)
    yield from torque_zeros(torque, None)
    yield from span_drifts(_length_s(campaign), campaign.readings.temperature_degC is not None)


def _of_spring(campaign: Campaign) -> Iterator[Variant]:
    readings = campaign.readings
    torque, angle = _reach(campaign)
    numbers = ("contact_stiffness", "torque_scale", "sensor_gain")
    yield from (v for v in VARIANTS if v.effect in numbers)

    yield from _frictions(campaign, torque, angle)
    yield from (form for form in _on_request(campaign) if form.effect == "distributed_friction")
    # A play is taken up at next to no torque, beside any loop of the table; what turns over a wider
    # range is a soft middle and no play.
    loops = small_loops_of(campaign)
    reach = torque if loops is None else loops.amplitude_Nm
    widest = WIDEST_TRANSITION
    transition = _ranged("transition_torque_Nm", reach, 1e-3, widest, (0.01, 0.05, widest))
    yield from _plays(torque, angle, transition)
    yield from _instruments_of_spring(campaign, torque, angle)
    yield from _stiffness_curves(torque, angle)
    yield from _run_ins(angle)
    # Nearer to zero torque a softer spring with a stop is a play.
    yield _hard_stop(torque, 0.4, (0.5, 0.65, 0.8))
    if readings.time_s is not None:
        length = _length_s(campaign) or 1.0
        run = max(_longest_run(campaign), 1e-3 * length)
        time = _ranged("time_constant_s", run, 1e-3, 10.0, (0.01, 0.05, 0.2, 1.0))
        compliance = angle / torque
        yield from creeps(_of("creep", ("compliance_rad_per_Nm",), compliance, 1e-4, 1.0), time)
        drift = _signed(_of("drift", ("rate_rad_per_s",), angle / length, 1e-3, 1.0), name="time")
        yield replace(drift, needs="time_s")
        yield from warm_ups(length, 1e-3 * angle, angle)
    if readings.temperature_degC is not None:
        span = float(np.ptp(readings.temperature_degC)) or 1.0
        drift = _signed(_of("drift", ("rate_rad_per_K",), angle / span, 1e-3, 1.0), "temperature")
        drift = replace(drift, needs="temperature_degC")
        yield drift
        if readings.time_s is not None:
            lag = Shape(LAG[0], 60.0, 1200.0, LAG[1], log=True)
            yield replace(drift, name="lagging temperature", shapes=(lag,))
    spring = tomllib.loads(campaign.drive.to_toml())["torsion_spring"]
    curved = "torque_Nm" in spring
    yield from _joints(angle / torque, torque, curved)
    # Under torques of one sign it is the stiffness, as a joint without a shape is.
    if curved or _both_signs(readings.torque_Nm):
        yield _shift(angle / torque)
    radius = spring.get("reference_radius_m")
    if radius is not None:
        at_100_N = angle * radius * (100 * radius / torque) ** 0.9
        yield _with(
            _of("eccentric_bearing", ("reference_deflection_m",), at_100_N, 1e-3, 1.0), (EXPONENT,)
        )
        offset = ("offset_sine_m", "offset_cosine_m")
        yield _signed(_of("eccentricity_error", offset, angle * radius, 1e-3, 1.0))
        # Under the whole torque, so that friction does not hold it as it holds `backlash`.
        clearance = _of("bearing_play", ("clearance_m",), 2 * angle * radius, 1e-3, 1.0)
        yield _with(clearance, (transition,))


def _both_signs(torque_Nm: Floats) -> bool:
    """Whether the lesser sign reaches a twentieth of what the other does."""
    reached = sorted((float(torque_Nm.max()), -float(torque_Nm.min())))
    return reached[0] > 0.05 * reached[1]


def _shift(compliance: float) -> Variant:
    return _signed(_of("shaft_shift", ("shift_rad_per_Nm",), compliance, 1e-3, 1.0))


def _run_ins(angle: float) -> Iterator[Variant]:
    forms: tuple[tuple[str, tuple[Shape, ...]], ...] = (
        ("permanent_set", ()),
        ("permanent_set_of_run", ()),
        ("settled", (SETTLING,)),
    )
    for name, shapes in forms:
        form = _signed(_of("run_in", (f"{name}_rad",), angle, 1e-3, 1.0), name)
        yield replace(form, shapes=shapes)


def _joints(compliance: float, torque: float, curved: bool) -> Iterator[Variant]:
    """Without a shape only beside a curve: in series with one stiffness it is that stiffness. A
    joint that levels off early is play, and belongs to `backlash`.
    """
    joint = _joint(compliance)
    if curved:
        yield joint
    yield _with(joint, (ASYMMETRY,), "softer one way")
    stiffening = _ranged("stiffening_per_Nm", 1 / torque, 0.3, 5.0, (1.0, 4.0))
    yield _with(joint, (stiffening,), "stiffening")
    stop = _ranged("stop_torque_Nm", torque, 0.5, 0.95, (0.7,))
    yield _with(joint, (stop,), "up to a stop")
    opening = _ranged("opening_torque_Nm", torque, 0.2, 0.8, (0.35, 0.6))
    yield _with(joint, (opening,), "that opens")


def _joint(compliance: float) -> Variant:
    return _of("output_torsion", ("compliance_rad_per_Nm",), compliance, 1e-3, 1.0)


def joint_of(campaign: Campaign) -> Variant | None:
    """A joint without a shape that takes the whole torque; None of a ball drive, which has one in
    its library. Beside friction it is no stiffness: that keeps the angle of the spring alone."""
    if campaign.drive.kind == "ball_drive":
        return None
    torque, angle = _reach(campaign)
    return _joint(angle / torque)


def _of(effect: str, sizes: tuple[str, ...], unit: float, low: float, high: float) -> Variant:
    return Variant(effect, sizes, low * unit, high * unit, scaled=True)


def _ranged(name: str, unit: float, low: float, high: float, grid: tuple[float, ...]) -> Shape:
    return Shape(name, low * unit, high * unit, tuple(g * unit for g in grid), log=True)


def _with(v: Variant, shapes: tuple[Shape, ...], name: str = "", needs: str = "") -> Variant:
    return replace(v, shapes=shapes, name=name, needs=needs)


def _signed(v: Variant, name: str = "", ratios: tuple[float, ...] = ()) -> Variant:
    return Variant(v.effect, v.sizes, v.low, v.high, True, name=name, ratios=ratios, scaled=True)


def _mean_preload(campaign: Campaign) -> float:
    preload = campaign.readings.preload_N
    return 1.0 if preload is None else float(preload.mean())


def _longest_run(campaign: Campaign) -> float:
    """Time from the first to the last reading of a run, s."""
    time, rows = campaign.readings.time_s, campaign.rows
    assert time is not None
    first, last = np.full(rows.runs, np.inf), np.full(rows.runs, -np.inf)
    np.minimum.at(first, rows.run_index, time)
    np.maximum.at(last, rows.run_index, time)
    return float((last - first).max())
