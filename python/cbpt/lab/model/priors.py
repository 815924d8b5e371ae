"""The library as the competition sees it: what of an effect is its size, what its shape, and what
is plausible.

    Variant     one form of an effect: sizes that vanish where it does nothing, and shapes
    VARIANTS    all forms of all effects
    PRIORS      which number of `[uncertainty]` stands behind which effect

Names and ranges of parameters come from the core's table; here is only how they are searched.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import effect_specs
from cbpt.lab.readings.readings import Readings

Floats = NDArray[np.float64]
ARCSEC = np.pi / 648000.0
STARTS_MOVING = "starts_moving"


@dataclass(frozen=True)
class Shape:
    """A number that says how an effect looks, not how large it is: its range and where to look
    first.
    """

    name: str
    low: float
    high: float
    grid: tuple[float, ...]
    log: bool = False


@dataclass(frozen=True)
class Variant:
    """One form of an effect.

    sizes: parameters that are neutral together; several of them are components of one amplitude.
    low, high: plausible sizes (off neutral), equally likely in the logarithm. signed: may be
    negative. fixed: parameters that are not fitted.
    """

    effect: str
    sizes: tuple[str, ...]
    low: float
    high: float
    signed: bool = False
    shapes: tuple[Shape, ...] = ()
    fixed: tuple[tuple[str, float], ...] = ()
    needs: str = ""
    name: str = ""
    ratios: tuple[float, ...] = ()
    """Of the plausible size of each component to that of the first; all 1 where empty."""
    spread: float = 0.0
    """Where above 0 the sizes are a lot: each normal about 0 with this standard deviation."""
    secants: tuple[tuple[float, ...], ...] = ()
    """Sizes at which to look as well, where an effect does not grow in proportion to its size."""
    units: tuple[tuple[str, str], ...] = ()
    """Of the parameters of an own effect, whose names do not tell them."""

    scaled: bool = False
    """Its ranges are those of one table, not of the core's library."""

    far: tuple[tuple[float, ...], ...] = ()
    """The same for the look at single effects alone: many forms that hardly show when small."""

    odds: float = 1.0
    """Prior odds of this form against the usual ones of its effect."""
    instead: tuple[tuple[str, tuple[str, str]], ...] = ()
    """Shapes of this form, each with the size of another effect (effect, size) that does the same
    beside the usual form."""

    @property
    def directed(self) -> bool:
        """Whether its two sizes are the components of one amplitude at some phase."""
        return self.signed and len(self.sizes) == 2 and not (self.ratios or self.scaled)

    def lacks(self, readings: Readings) -> str:
        """The first column that it needs and the readings do not have, or nothing."""
        needed = [self.needs] if self.needs else []
        # A friction that follows the preload.
        needed += ["preload_N"] if "friction_radius_m" in self.sizes else []
        return next((column for column in needed if getattr(readings, column) is None), "")

    @property
    def late(self) -> bool:
        """Whether it depends on how runs begin."""
        return STARTS_MOVING in _PARAMETERS.get(self.effect, {})

    @property
    def label(self) -> str:
        """Effect and form."""
        return f"{self.effect}:{self.name}" if self.name else self.effect


_PARAMETERS = {spec.id: {p.name: p for p in spec.parameters} for spec in effect_specs()}


def _shape(effect: str, name: str, grid: tuple[float, ...], log: bool = False) -> Shape:
    """A shape over the core's plausible range."""
    return Shape(name, *_PARAMETERS[effect][name].range, grid, log)


def _largest(effect: str, size: str) -> float:
    """The largest plausible size, off neutral, by the core's range."""
    p = _PARAMETERS[effect][size]
    return max(abs(end - p.neutral) for end in p.range)


EXPONENT = _shape("eccentric_bearing", "exponent", (2 / 3, 0.9))
_ENGAGEMENT = _shape(
    "friction_hysteresis",
    "engagement_angle_rad",
    tuple(a * ARCSEC for a in (0.5, 3.0, 8.0, 22.0)),
    log=True,
)
BUILD_UP = _shape("friction_hysteresis", "build_up_exponent", (0.3,))
_TIME = _shape("creep", "time_constant_s", (2.0, 10.0, 50.0, 400.0), log=True)
_POWER = _shape("creep", "growth_exponent", (0.2, 0.4))
_MINUTE = ("time_constant_s", 60.0)


def creeps(form: Variant, time: Shape) -> tuple[Variant, ...]:
    """All forms of creep: with the logarithm of the time since the run began, or since each step of
    torque; with a power of that, of which the size is what a minute adds: the law of polymers,
    which is the rarer one in a reducer, and of a small power hardly another than friction."""
    form = replace(form, needs="time_s")
    return (
        replace(form, shapes=(time,)),
        replace(
            form, sizes=("superposed_compliance_rad_per_Nm",), shapes=(time,), name="superposed"
        ),
        replace(
            form,
            sizes=("power_compliance_rad_per_Nm",),
            shapes=(_POWER,),
            fixed=(_MINUTE,),
            name="power of time",
            odds=0.1,
        ),
    )


LAG = "time_constant_s", (120.0, 500.0)
"""Time constant of a part that follows the measured temperature, and where to look for it."""
SETTLING = _shape("run_in", "settling_cycles", (1.0, 5.0), log=True)
ASYMMETRY = _shape("output_torsion", "asymmetry", (-0.8, 0.8))
_CLAMPED = _shape("output_torsion", "preload_exponent", (0.6,))


def _ring(*sizes: float) -> tuple[tuple[float, float], ...]:
    """Amplitudes at four phases."""
    phases = (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)
    return tuple((size * c, size * s) for size in sizes for c, s in phases)


_OF_CORE = math.nan
"""Stands for the core's largest plausible size."""
_SPAN_OF_CURVE = [
    _largest("sensor_nonlinearity", name) for name in ("quadratic_per_rad", "cubic_per_rad2")
]
_LOST_SHARE, _LOST_FORCE = "lost_share", "lost_force_N"

_TABLE: tuple[Variant, ...] = (
    Variant("contact_stiffness", ("stiffness_scale",), 0.02, _OF_CORE, signed=True),
    Variant("contact_angle", ("contact_angle_shift_rad",), 0.002, _OF_CORE, signed=True),
    Variant("torque_scale", ("torque_gain",), 0.005, _OF_CORE, signed=True),
    Variant("preload_scale", ("preload_gain",), 0.005, _OF_CORE, signed=True),
    Variant("shaft_shift", ("shift_rad_per_Nm",), 1e-7, _OF_CORE, signed=True),
    Variant("sensor_gain", ("sensor_gain",), 0.005, _OF_CORE, signed=True),
    Variant(
        "sensor_nonlinearity",
        ("quadratic_per_rad", "cubic_per_rad2"),
        2.0,  # a coefficient of 10 per rad is an error of 0.17 arcsec at 60 arcsec
        _OF_CORE,
        signed=True,
        ratios=(1.0, _SPAN_OF_CURVE[1] / _SPAN_OF_CURVE[0]),
    ),
    Variant(
        "sensor_nonlinearity",
        ("flattening_rad",),
        0.1 * ARCSEC,
        _OF_CORE,
        signed=True,
        shapes=(_shape("sensor_nonlinearity", "knee_rad", (30 * ARCSEC, 80 * ARCSEC), log=True),),
        name="flattening",
    ),
    Variant(
        "drift", ("rate_rad_per_s",), 1e-11, _OF_CORE, signed=True, name="time", needs="time_s"
    ),
    Variant(
        "drift",
        ("rate_rad_per_K",),
        1e-8,
        _OF_CORE,
        signed=True,
        name="temperature",
        needs="temperature_degC",
    ),
    Variant(
        "drift",
        ("rate_rad_per_K",),
        1e-8,
        _OF_CORE,
        signed=True,
        shapes=(_shape("drift", *LAG, log=True),),
        name="lagging temperature",
        needs="temperature_degC",
    ),
    Variant("eccentric_bearing", ("reference_deflection_m",), 2e-8, _OF_CORE, shapes=(EXPONENT,)),
    Variant("bearing_play", ("clearance_m",), 2e-8, _OF_CORE),
    *(
        Variant(
            "output_torsion", ("compliance_rad_per_Nm",), 1e-7, _OF_CORE, shapes=shapes, name=name
        )
        for shapes, name in (
            ((), ""),
            ((ASYMMETRY,), "softer one way"),
            ((_CLAMPED,), "clamped by the preload"),
        )
    ),
    *(
        Variant(
            "friction_hysteresis", ("friction_radius_m",), 1e-6, _OF_CORE, shapes=shapes, name=name
        )
        for shapes, name in (((_ENGAGEMENT,), ""), ((_ENGAGEMENT, BUILD_UP), "to a sharp limit"))
    ),
    Variant("preload_loss", (_LOST_SHARE,), 0.005, _OF_CORE),
    Variant("preload_loss", (_LOST_FORCE,), 2.0, _OF_CORE, name="force"),
    Variant(
        "preload_loss",
        (_LOST_SHARE, _LOST_FORCE),
        0.005,
        _OF_CORE,
        name="share and force",
        ratios=(1.0, 800.0),  # a force counts as much as the share that it is of 800 N
    ),
    Variant("preload_spring", ("spring_rate_N_per_m",), 1e6, _OF_CORE),
    *(
        Variant(
            "thermal_preload",
            ("rate_N_per_K",),
            0.1,
            _OF_CORE,
            signed=True,
            shapes=shapes,
            name=name,
            needs="temperature_degC",
        )
        for shapes, name in (
            ((), ""),
            ((_shape("thermal_preload", *LAG, log=True),), "lagging temperature"),
        )
    ),
    *(
        Variant(
            "eccentricity_error",
            (f"{where}offset_sine_m", f"{where}offset_cosine_m"),
            2e-8,
            _OF_CORE,
            signed=True,
            name="planet" if where else "fixed plate",
        )
        for where in ("", "planet_")
    ),
    *(
        Variant(
            "groove_pitch_error",
            (f"{groove}cosine_m", f"{groove}sine_m"),
            1e-7,
            _OF_CORE,
            signed=True,
            fixed=(("harmonic", float(harmonic)),),
            name=f"{'planet' if groove else 'fixed groove'}, harmonic {harmonic}",
            far=_ring(1e-6, 4e-6),
        )
        for harmonic in range(2, 9)
        for groove in ("", "planet_")
    ),
    *(
        Variant(
            "plate_tilt",
            (f"{where}tilt_cosine_rad", f"{where}tilt_sine_rad"),
            1e-6,
            _OF_CORE,
            signed=True,
            name=name,
            secants=_ring(1e-5, 4e-5, 1.5e-4),
        )
        for where, name in (
            ("", "with the crank"),
            ("housing_", "in the housing"),
            ("fixed_plate_", "fixed plate"),
            ("output_plate_", "output plate"),
        )
    ),
    Variant("rough_contact", ("exponent",), 0.02, _OF_CORE, signed=True),
    *(
        Variant(
            "run_in",
            (f"{name}_rad",),
            0.1 * ARCSEC,
            _OF_CORE,
            signed=True,
            shapes=shapes,
            name=name,
        )
        for name, shapes in (
            ("permanent_set", ()),
            ("permanent_set_of_run", ()),
            ("settled", (SETTLING,)),
        )
    ),
    Variant("wear", ("lost_share_per_s",), 1e-7, _OF_CORE, needs="time_s"),
    *creeps(Variant("creep", ("compliance_rad_per_Nm",), 1e-9, _OF_CORE), _TIME),
)
"""All forms of all effects; `low` is the least size that could matter."""

VARIANTS = tuple(replace(v, high=_largest(v.effect, v.sizes[0])) for v in _TABLE)
ON_REQUEST = (
    *("distributed_friction", "rate_friction", "breakaway_friction", "hard_stop"),
    "loose_fixture",
)
"""Effects that are fitted where the user asks for them; no diagnosis proposes them, but for
`rate_friction`, which a lag of the torque would else be named for, and two of a torsion spring: the
`hard_stop`, for which a stiffer one with a joint would, and `distributed_friction`, for which creep
would. What that rests on: docs/explanation/loop-forms.md."""


def lots(balls: int) -> tuple[Variant, ...]:
    """Balls of unequal diameter: one size a ball, with a few spreads to choose from."""
    sizes = tuple(f"{i}.oversize_m" for i in range(balls))
    return tuple(
        Variant(LOT, sizes, s, s, signed=True, spread=s, name=f"spread {s * 1e6:g} um")
        for s in (0.05e-6, 0.15e-6, 0.5e-6, 1.5e-6)
    )


_TIMES = "time_constant_s", "warm_up_time_s", "seating_time_s"
"""Times over which something is over."""


def no_quicker(variant: Variant, step_s: float) -> Variant | None:
    """A form whose time constant is no shorter than the time from reading to reading, None where
    all are: what is over before the next reading is seen by none."""
    shapes: list[Shape] = []
    for shape in variant.shapes:
        if shape.name in _TIMES and shape.low < step_s:
            if shape.high <= step_s:
                return None
            grid = tuple(t for t in shape.grid if t > step_s)
            shapes.append(replace(shape, low=step_s, grid=grid or (step_s,)))
        else:
            shapes.append(shape)
    return replace(variant, shapes=tuple(shapes))


def within_limits(variant: Variant) -> Variant | None:
    """A form whose ranges are no wider than what its equation takes, None where nothing is left: a
    range that comes from the table may go beyond, as that of a time over years does."""
    known, hair = _PARAMETERS.get(variant.effect, {}), 1e-12
    shapes: list[Shape] = []
    for shape in variant.shapes:
        limits = known.get(shape.name)
        if limits is not None:
            # A hair within: what is searched in logarithms comes back but for rounding.
            low = max(shape.low, limits.lower * (1 + hair))
            high = min(shape.high, limits.upper * (1 - hair))
            if low >= high:
                return None
            grid = dict.fromkeys(min(max(at, low), high) for at in shape.grid)
            shape = replace(shape, low=low, high=high, grid=tuple(grid))
        shapes.append(shape)
    ratios = variant.ratios or (1.0,) * len(variant.sizes)
    most = min(
        (known[size].upper - known[size].neutral) / ratio if size in known else math.inf
        for size, ratio in zip(variant.sizes, ratios, strict=True)
    )
    if variant.low >= most:
        return None
    return replace(variant, high=min(variant.high, most), shapes=tuple(shapes))


def joints(torque_Nm: float) -> tuple[Variant, ...]:
    """A joint of the shaft that gives less as it is loaded, by 5 to 22 % at the largest torque; one
    that opens at 20 to 80 % of it; or one that comes to a stop at 40 to 90 % of it, before which it
    is a play."""
    per_Nm = 1 / torque_Nm
    growth = Shape("stiffening_per_Nm", 0.1 * per_Nm, 0.6 * per_Nm, (0.25 * per_Nm,), log=True)
    at = 0.35 * torque_Nm, 0.6 * torque_Nm
    opens = Shape("opening_torque_Nm", 0.2 * torque_Nm, 0.8 * torque_Nm, at, log=True)
    near, far = 0.5 * torque_Nm, 0.7 * torque_Nm
    stops = Shape("stop_torque_Nm", 0.4 * torque_Nm, 0.9 * torque_Nm, (near, far), log=True)
    shaft = next(v for v in VARIANTS if v.effect == "output_torsion")
    return tuple(
        replace(shaft, shapes=(shape,), name=name)
        for shape, name in ((growth, "stiffening"), (opens, "that opens"), (stops, "up to a stop"))
    )


def slowing_wear(length_s: float | None) -> tuple[Variant, ...]:
    """A loss of 0.5 to 50 % of the preload over the table that slows down: by a power of time, or
    until joints have seated; and one in each run, by the logarithm of its time. Rarer laws than
    steady wear, and hardly others than a preload that follows a temperature, or creep."""
    if not length_s:
        return ()
    by_the_end = (("slowing_time_s", length_s),)
    exponent = _shape("wear", "slowing_exponent", (0.3, 0.5, 0.7))
    slows = Variant("wear", ("slowing_lost_share",), 0.005, 0.5, shapes=(exponent,))
    slows = replace(slows, fixed=by_the_end, name="that slows down")
    within = (length_s / 12, length_s / 3)
    time = Shape("seating_time_s", length_s / 30, length_s, within, log=True)
    seats = Variant("wear", ("seated_lost_share",), 0.005, 0.5, shapes=(time,), name="that ends")
    relaxing = _shape("wear", "relaxing_time_s", (5.0, 100.0), log=True)
    relaxes = Variant("wear", ("relaxing_lost_share",), 0.002, 0.1, shapes=(relaxing,))
    forms = slows, seats, replace(relaxes, name="in each run")
    return tuple(replace(form, needs="time_s", odds=0.1, scaled=True) for form in forms)


def soft_plays(torque_Nm: float) -> tuple[Variant, ...]:
    """A play of the bearing that is taken up within 0.5 to 15 % of the largest torque."""
    low, high = 0.005 * torque_Nm, 0.15 * torque_Nm
    grid = (0.015 * torque_Nm, 0.06 * torque_Nm)
    within = Shape("transition_torque_Nm", low, high, grid, log=True)
    play = next(v for v in VARIANTS if v.effect == "bearing_play")
    return (replace(play, shapes=(within,), name="soft"),)


def constant_frictions(torque_Nm: float) -> tuple[Variant, ...]:
    """Friction of seals and bearings, the same at every preload: 0.05 to 30 % of the largest
    torque."""
    loops = (v for v in VARIANTS if v.effect == "friction_hysteresis")
    low, high = 5e-4 * torque_Nm, 0.3 * torque_Nm
    size = ("friction_torque_Nm",)
    return tuple(
        replace(loop, sizes=size, low=low, high=high, scaled=True, name=f"constant{sharp}")
        for loop, sharp in zip(loops, ("", ", to a sharp limit"), strict=True)
    )


LOT = "ball_diameter_lot"

PRIORS = {
    "contact_stiffness": "contact_stiffness_rel",
    "contact_angle": "contact_angle_rad",
    "torque_scale": "torque_gain_rel",
    "preload_scale": "preload_gain_rel",
    "sensor_gain": "sensor_gain_rel",
}
"""Effects that are numbers of the drive or calibrations: the uncertainty stated for each."""


def log_size_prior(variant: Variant, size: Floats, own: Floats) -> float:
    """Log of the prior density of a size, with the 2 pi of Laplace's method.

    size, own: components and their standard uncertainties in units of `low`, shape (k,). A size
    that is seen no better than its own uncertainty counts as that large: there the logarithm has
    no say.
    """
    k = len(size)
    if k == 0:
        return 0.0
    r = max(float(np.linalg.norm(size)), float(np.linalg.norm(own)) / math.sqrt(k), 1.0)
    return log_density_of_one(variant) - len(variant.sizes) * math.log(r)


def log_prior_of_sizes(
    variants: Sequence[Variant], places: Sequence[Sequence[int]], off: Floats, covariance: Floats
) -> float:
    """Log of the prior density of the sizes of all variants, with the factor by which their
    plausible ranges reduce the volume of the posterior.

    When the readings determine only the sum of two sizes, the linear problem leaves each of them
    without a limit. Here the limit is a Gaussian about zero with the standard deviation `high`; it
    hardly changes sizes that the readings determine.

    places: of the sizes of each variant; off: of all, from where they vanish, in units of `low`;
    covariance: in squares of these. Minus infinity where the covariance is not finite.
    """
    at = [i for place in places for i in place]
    reach = np.array([v.high / v.low for v, p in zip(variants, places, strict=True) for _ in p])
    freedom = covariance[np.ix_(at, at)] / np.outer(reach, reach)
    if not np.isfinite(freedom).all():
        return -np.inf
    limited = np.eye(len(at)) + freedom
    own = np.zeros(len(off))
    own[at] = reach * np.sqrt(np.diag(np.linalg.solve(limited, freedom)))
    return -0.5 * float(np.linalg.slogdet(limited)[1]) + sum(
        log_size_prior(variant, off[list(place)], own[list(place)])
        for variant, place in zip(variants, places, strict=True)
    )


def log_density(variant: Variant, r: Floats) -> Floats:
    """Equally likely in ln r over the plausible range: on a ray, a line, in a plane, in space."""
    return np.asarray(log_density_of_one(variant) - len(variant.sizes) * np.log(r))


def log_density_of_one(variant: Variant) -> float:
    """The same at r = 1, with the odds of the form."""
    k = len(variant.sizes)
    span = math.log(variant.high / variant.low)
    around = 1.0 if k == 1 and not variant.signed else _sphere(k)
    return 0.5 * k * math.log(2 * math.pi) - math.log(span * around / variant.odds)


def _sphere(k: int) -> float:
    """Surface of the unit sphere in k dimensions."""
    return float(2 * math.pi ** (k / 2) / math.gamma(k / 2))


_CALIBRATIONS = ("torque_scale", "preload_scale", "sensor_gain", "contact_angle")
_INSTRUMENTS = (
    *("torque_lag", "torque_hysteresis", "sensor_hysteresis", "span_drift", "loose_fixture"),
)
ODDS: dict[str, float] = {
    "": 0.03,
    **dict.fromkeys((*_CALIBRATIONS, *_INSTRUMENTS), 2e-4),
    **dict.fromkeys(("rate_friction", "distributed_friction", "damping"), 2e-4),
    "ball_diameter_lot": 0.01,
    **dict.fromkeys(("shaft_shift", "preload_crosstalk"), 3e-3),
    "unknown": 0.03,
}
"""Prior odds of an effect against nothing; "" stands for those not listed. A calibration or an
angle that is wrong by far more than its stated uncertainty is a hundred times less likely than a
missing effect, and so is an error of an instrument beyond gain, zero and drift, or friction and
damping by the rate, which look like a late sensor, or friction by another law: without evidence of
their own they are no rivals of friction. A shaft that a side load moves takes an open lever to be
seen at all, so it is ten times rarer than an effect; odds of 0.03 let it stand in for rough
contacts and bearings (docs/explanation/tests-by-others.md). So is a torque that changes the
preload: with the odds of an instrument a torque sensor off zero, which the readings tell from it
no better, was named for certain in its place.
"""

CLASSES: dict[str, str] = {spec.id: spec.kind for spec in effect_specs()}
"""`rig`, `parameter` or `effect`, by effect."""
FRICTIONS = frozenset(
    spec.id
    for spec in effect_specs()
    if any(number.name == "friction_torque_Nm" for number in spec.parameters)
)
"""Effects that hold a torque back."""
TWINS: dict[str, list[str]] = {spec.id: spec.twins for spec in effect_specs()}
"""Effects that look like an effect, by effect."""
