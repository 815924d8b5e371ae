"""The figures of catalogues and standards, from readings, from a model, or side by side.

characterise   a case, and readings where there are any -> Characteristics
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.characteristics.characteristics import Characteristics
from cbpt.lab.characteristics.figures import DEFINITIONS, NAMES, ROUNDING, Convention, pieces_of
from cbpt.lab.characteristics.loops import Loop, loops_of
from cbpt.lab.characteristics.play import MOST_FRICTION, SPAN, friction_torque_Nm
from cbpt.lab.characteristics.record import Group
from cbpt.lab.characteristics.simulated import Conditions, simulated
from cbpt.lab.characteristics.uncertainty import Figure, LoopSet, Sources, estimated
from cbpt.lab.characteristics.warnings import cautions
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.covariance.robust import neighbour_scatter
from cbpt.lab.covariance.rounding import rounds_alike
from cbpt.lab.covariance.within_run import display_step, written_step
from cbpt.lab.model.dataset import stated_uncertainty
from cbpt.lab.readings.inputs import case_and_readings, case_of
from cbpt.lab.readings.readings import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.wording.numbers import rounded
from cbpt.results import ARCSEC_PER_RAD

__all__ = ["characterise"]

Mask = NDArray[np.bool_]

_OF_MODEL = (
    "angle between both sides at no torque in the loops of the model without friction, read off "
    "like that of readings"
)


@dataclass(frozen=True)
class _Limits:
    """Which loops belong together."""

    full: tuple[float, float] = (0.75, 1.25)
    """Amplitudes of full loops, as shares of the rated torque."""
    alike: float = 0.85
    """Loops whose amplitudes differ by no more than this factor are of one amplitude."""
    repeated: float = 0.95
    """Loops that repeat each other differ in amplitude by no more."""
    uneven: float = 0.1
    """Share of the readings at which straight branches may bend."""


_LIMITS = _Limits()


def characterise(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike] | None = None,
    *,
    rated_torque_Nm: float | None = None,
    window: float = 0.03,
    break_torques_Nm: Sequence[float] | None = None,
    by: str | None = None,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, Any] | None = None,
) -> Characteristics:
    """Read the figures of catalogues and standards off torque-angle loops.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`. Its effects are part of the model, `[rating]` gives the rated
        torque, and `[uncertainty]` the uncertainty of type B.
    data : Readings, str, PathLike, mapping or data frame, optional
        The table of readings, as `read_readings` takes it. Without it the figures are the model's.
    rated_torque_Nm : float, optional
        Rated torque, N m, in place of that of the case. Where neither is stated, the largest torque
        of the table is taken.
    window : float
        Share of the rated torque at which lost motion is read. Makers of strain-wave gears use
        0.04.
    break_torques_Nm : two floats, optional
        T1 and T2, N m, where they are given and not to be fitted.
    by : str, optional
        A column; each of its values gets figures of its own. Without it, each preload does.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.

    Returns
    -------
    Characteristics
        Figures with standard uncertainties, conventions and warnings.

    Raises
    ------
    CaseError, ReadingsError, InvalidInputError
        The case, the table or an argument cannot be read.
    """
    _check(rated_torque_Nm, window, break_torques_Nm)
    readings = None
    if data is None:
        case = case_of(case)
    else:
        case, readings = case_and_readings(case, data, columns, sheet, only, by)
    groups = _groups(readings, by) if readings is not None else [(None, None)]
    found = {name: loops_of(part) if part is not None else [] for name, part in groups}
    if readings is not None and not any(found.values()):
        raise ReadingsError.of_column(
            readings.source,
            "torque_Nm",
            "no run whose torque turns back",
            "a loop to read the figures off",
            "load and unload in one run, through zero torque if possible",
        )
    rated, where = _rated(rated_torque_Nm, case, readings, [x for v in found.values() for x in v])
    breaks = None if break_torques_Nm is None else (break_torques_Nm[0], break_torques_Nm[1])
    convention = Convention(rated, window, breaks)
    with one_blas_thread():
        answered = tuple(
            _group(case, convention, name, part, found[name])
            for name, part in groups
            if part is None or found[name]
        )
    return Characteristics(answered, convention, where, readings, by)


def _check(rated: float | None, window: float, breaks: Sequence[float] | None) -> None:
    if rated is not None and not (np.isfinite(rated) and rated > 0):
        raise InvalidInputError(f"rated_torque_Nm: found {rated:g}, expected a torque above 0")
    if not 0 < window < 0.5:
        raise InvalidInputError(f"window: found {window:g}, expected a share above 0 and below 0.5")
    if breaks is not None and not (len(breaks) == 2 and 0 < breaks[0] < breaks[1]):
        raise InvalidInputError(
            f"break_torques_Nm: found {list(breaks)}, expected T1 and T2, both above 0, T1 < T2"
        )


def _groups(readings: Readings, by: str | None) -> list[tuple[str | None, Readings]]:
    """The readings of each level of a column, or of each preload."""
    labels: NDArray[Any]
    if by is not None:
        labels = np.array([f"{by} {label}" for label in readings.labels[by].tolist()])
    elif readings.preload_N is not None and len(levels := levels_of(readings.preload_N)) > 1:
        names = [f"preload {value:.4g} N" for value in levels.value.tolist()]
        labels = np.array(names)[levels.index]
    elif readings.preload_step is not None:
        labels = np.array([f"preload step {step}" for step in readings.preload_step.tolist()])
    else:
        return [(None, readings)]
    found = list(dict.fromkeys(labels.tolist()))
    if len(found) == 1 and by is None:
        return [(None, readings)]
    return [(name, readings.select(labels == name)) for name in found]


def _rated(
    given: float | None, case: Case | Drive, readings: Readings | None, loops: Sequence[Loop]
) -> tuple[float, str]:
    if given is not None:
        return given, "as given"
    if isinstance(case, Case) and case.rated_torque_Nm is not None:
        return case.rated_torque_Nm, "from [rating] of the case"
    if loops:
        largest = max(loop.amplitude_Nm for loop in loops)
        return largest, "the largest of its loops, as no rated torque is stated under [rating]"
    if readings is None and isinstance(case, Case) and case.torque_Nm:
        return abs(case.torque_Nm), "the torque of [load], as none is stated under [rating]"
    raise InvalidInputError(
        "rated_torque_Nm: the case states no rated torque; add rated_torque_Nm under [rating]"
    )


# --- one setting --------------------------------------------------------------------------


def _group(
    case: Case | Drive,
    convention: Convention,
    name: str | None,
    part: Readings | None,
    loops: list[Loop],
) -> Group:
    used, warned = None, list[str]()
    of_readings: tuple[Figure, ...] = ()
    at = Conditions(convention.rated_torque_Nm)
    if part is not None:
        used = _used(loops, convention.rated_torque_Nm)
        of_readings = _of_readings(case, convention, name, part, used)
        warned = cautions(used, loops, convention)
        at = _conditions(part, used)
    model = simulated(case, at, convention)
    if isinstance(model, str):
        of_model = tuple(_missing(n, convention, name, model) for n in NAMES)
        return Group(name, of_readings, of_model, used, None, len(loops), tuple(warned))
    value, u = model.type_b(convention)
    rests = ("the model", *(f"[uncertainty] {key}" for key in model.shifted))
    told = _Told(convention, name, model.loops, rests)
    figures = {n: told.figure(n, value[n], 0.0, u[n]) for n in NAMES}
    figures["backlash"] = replace(figures["backlash"], convention=_OF_MODEL)
    of_model = tuple(figures.values())
    return Group(name, of_readings, of_model, used, model.loops, len(loops), tuple(warned))


def _used(loops: Sequence[Loop], rated: float) -> LoopSet:
    """The loops that go to the rated torque, or nearest to it, and the smallest ones."""
    whole = [loop for loop in loops if loop.whole] or list(loops)
    size = np.array([loop.amplitude_Nm for loop in whole])
    full = (size >= _LIMITS.full[0] * rated) & (size <= _LIMITS.full[1] * rated)
    if not full.any():
        near = size[np.argmin(np.abs(np.log(size / rated)))]
        full = (size >= _LIMITS.alike * near) & (size <= near / _LIMITS.alike)
    small = size <= size.min() / _LIMITS.alike
    picked = [loop for loop, take in zip(whole, full, strict=True) if take]
    return LoopSet(picked, [loop for loop, take in zip(whole, small, strict=True) if take])


def _conditions(part: Readings, used: LoopSet) -> Conditions:
    rates = [loop.rate_Nm_per_s for loop in used.full if loop.rate_Nm_per_s]
    temperature = part.temperature_degC
    return Conditions(
        used.amplitude_Nm,
        used.small_amplitude_Nm if used.several else None,
        preload_N=None if part.preload_N is None else float(np.median(part.preload_N)),
        input_angle_deg=float(np.median(part.input_angle_deg)),
        temperature_degC=20.0 if temperature is None else float(np.median(temperature)),
        rate_Nm_per_s=float(np.median(rates)) if rates else None,
    )


def _of_readings(
    case: Case | Drive, convention: Convention, name: str | None, part: Readings, used: LoopSet
) -> tuple[Figure, ...]:
    gains = stated_uncertainty(case)
    u = part.u_elastic_angle_arcsec
    scatter = _scatter(used) if u is None else float(np.median(u))
    step = _step_arcsec(part, used)
    alike = rounds_alike(scatter / step) if step and len(used.full) > 1 else 0.0
    own, rounding = step / 12**0.5 * np.sqrt([1 - alike, alike])
    sources = Sources(
        float(np.hypot(scatter, own)),
        float(rounding),
        gains.get("torque_scale", 0.0),
        gains.get("sensor_gain", 0.0),
    )
    found = estimated(used, convention, sources)
    source = "the stated u of a reading" if u is not None else "the scatter along the branches"
    if found.loops > 1:
        beside = f", {source}" if u is not None else ""
        source = f"the spread over {found.loops} loops{beside}"
    rests = (
        f"{found.loops} loop{'s' * (found.loops > 1)} to {rounded(used.amplitude_Nm)} N m",
        source,
        "the steps between the readings",
        "[uncertainty] torque_gain_rel",
        "[uncertainty] sensor_gain_rel",
    )
    told = _Told(convention, name, used, rests)
    return tuple(told.figure(n, found.value[n], found.type_a[n], found.type_b[n]) for n in NAMES)


def _step_arcsec(part: Readings, used: LoopSet) -> float:
    """By what angles are rounded: to the last digit that is written, or to the step of a display,
    as which the even steps of straight branches only look."""
    angles = [b.angle_arcsec for loop in used.full for b in loop.branches]
    bends = np.concatenate([np.abs(np.diff(angle, 2)) for angle in angles])
    uneven = np.mean(bends > ROUNDING * used.turn_arcsec) > _LIMITS.uneven
    angle = part.elastic_angle_arcsec
    return max(written_step(angle), display_step(angle) if uneven else 0.0)


def _scatter(used: LoopSet) -> float:
    """Standard deviation of a reading: of what loops of one amplitude differ by at the same
    torques, where there are several and the torque was set, else from second differences along the
    branches, of which the bends of a loop are a part."""
    most = max(loop.amplitude_Nm for loop in used.full)
    alike = [loop for loop in used.full if loop.amplitude_Nm >= _LIMITS.repeated * most]
    squares, freedom = 0.0, 0
    for of_way in ([x.rising for x in alike], [x.falling for x in alike]):
        # Two loops of a run may have one branch in common.
        known = list({b.row.tobytes(): b for b in of_way if b is not None}.values())
        if len(known) < 2 or any(b.scattered for b in known):
            continue
        angles = np.array([b.at(known[0].torque_Nm) for b in known])
        off = angles[:, np.isfinite(angles).all(axis=0)]
        if off.shape[1] > 1:
            off = off - off.mean(axis=1, keepdims=True)
            squares += float(np.sum((off - off.mean(axis=0)) ** 2))
            freedom += (len(off) - 1) * (off.shape[1] - 1)
    if freedom:
        return float(np.sqrt(squares / freedom))
    return neighbour_scatter([b.angle_arcsec for loop in used.full for b in loop.branches], 2)


@dataclass(frozen=True)
class _Told:
    """What the figures of one setting share."""

    convention: Convention
    setting: str | None
    loops: LoopSet
    rests_on: tuple[str, ...]

    def figure(self, name: str, value: float, type_a: float, type_b: float) -> Figure:
        """One figure, or why there is none."""
        if not np.isfinite(value):
            reason = _reason(name, self.loops, self.convention)
            return _missing(name, self.convention, self.setting, reason)
        unit, words = _words(name, self.convention, self.loops)
        least = ROUNDING * {
            "arcsec": self.loops.turn_arcsec,
            "J": self.loops.turn_arcsec * self.loops.small_amplitude_Nm / ARCSEC_PER_RAD,
        }.get(unit, 0.0)
        value, type_a, type_b = (0.0 if abs(x) < least else x for x in (value, type_a, type_b))
        return Figure(
            name,
            value,
            float(np.hypot(type_a, type_b)),
            unit,
            words,
            _torque(name, value, self.convention, self.loops),
            self.rests_on,
            u_type_a=type_a,
            u_type_b=type_b,
            setting=self.setting,
        )


def _missing(name: str, convention: Convention, setting: str | None, reason: str) -> Figure:
    unit, words = _words(name, convention, None)
    return Figure(name, None, None, unit, words, None, (), reason=reason, setting=setting)


def _words(name: str, convention: Convention, loops: LoopSet | None) -> tuple[str, str]:
    """Unit and convention of a figure."""
    unit, words = DEFINITIONS[name]
    if name == "backlash":
        words = (
            "free play without the part of friction: the angle between the two sides of zero, "
            "where the mean torque of both branches, in which friction cancels, is zero. It "
            "is read off parabolas through each branch on each side, from one and a half times the "
            "torque of friction (5 % of the largest torque at least) to 50 % of the largest torque"
        )
        return unit, f"{words}. A preloaded reducer usually has none"
    if name[0] in "KT" and convention.breaks_Nm is not None:
        words += ", with given break torques"
    return unit, words.format(window=f"{100 * convention.window:.3g} %")


def _torque(
    name: str, value: float, convention: Convention, loops: LoopSet
) -> float | tuple[float, float] | None:
    match name:
        case "lost_motion":
            return convention.window_Nm
        case "hysteresis_loss" | "backlash":
            return 0.0
        case "torsional_rigidity":
            rated = convention.rated_torque_Nm
            return 0.5 * rated, min(rated, loops.amplitude_Nm)
        case "T1" | "T2":
            return value
        case "loop_energy":
            return loops.amplitude_Nm
    return None


def _reason(name: str, loops: LoopSet, convention: Convention) -> str:
    """Why a figure cannot be had."""
    reach = loops.amplitude_Nm
    match name:
        case "torsional_rigidity" if not any(loop.rising and loop.falling for loop in loops.full):
            return (
                "no run has both branches: it is the mean of both, as a branch that has just "
                "turned is stiffer. Unload too"
            )
        case "torsional_rigidity":
            return (
                f"the loops go to {rounded(reach)} N m, and the slope is taken from 50 % to 100 % "
                f"of the rated {rounded(convention.rated_torque_Nm)} N m"
            )
        case "T1" | "T2":
            return "a straight line describes the curve as well as three pieces do"
        case "K1" | "K2" | "K3":
            return _no_piece(int(name[1]), loops, convention)
    if not any(loop.whole for loop in loops.full):
        return "no run has a loop: torques on both sides of zero, there and back"
    if name == "backlash":
        return _no_play(loops)
    return f"the loops do not reach {rounded(convention.window_Nm)} N m on both sides"


def _no_piece(number: int, loops: LoopSet, convention: Convention) -> str:
    found = pieces_of(loops.full[0], convention)
    if found is None:
        return (
            "the curve has fewer than 8 torques between zero and the rated torque, or to where "
            "friction turns back"
        )
    edges = [0.0, *found.breaks_Nm, convention.rated_torque_Nm]
    return (
        f"the angle does not grow with the torque along piece {number}, from "
        f"{rounded(edges[number - 1])} to {rounded(edges[number])} N m: the curve has a step there "
        "(as of play), and no bend"
    )


def _no_play(loops: LoopSet) -> str:
    friction = float(np.mean([friction_torque_Nm(loop) for loop in loops.full]))
    reach = loops.amplitude_Nm
    if friction > MOST_FRICTION * reach:
        width = float(np.mean([loop.width_arcsec for loop in loops.small]))
        return (
            f"friction takes up {rounded(friction)} N m of the {rounded(reach)} N m that the loops "
            "go to, so that the play cannot be told from the way on which friction turns back; "
            f"the width at zero torque, {rounded(width)} arcsec in loops to "
            f"{rounded(loops.small_amplitude_Nm)} N m, holds both. Run loops to "
            f"{rounded(friction / MOST_FRICTION)} N m or more"
        )
    least, most = (f"{100 * share:.3g} %" for share in SPAN)
    return (
        f"the branches have fewer than 3 torques between {least} and {most} of the amplitude on "
        "each side of zero, beyond one and a half times the torque of friction"
    )
