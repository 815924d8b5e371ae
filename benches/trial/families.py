"""Families of campaigns with a hidden effect of a stated strength, each fixed by its seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeVar, get_args

import numpy as np

from reference.forward import Drive
from reference.rig import ARCSEC, Rows, drive_of, simulate
from reference.rig.campaign import PRIORS, Campaign, Plan, draw_case, draw_plan, rows_of
from reference.rig.effects import LIBRARY, OUTSIDE, Hidden, Kind, draw_hidden, hidden
from reference.rig.instrument import Instrument, plain_values
from reference.rig.mesh import NotHeldError
from reference.rig.noise import NOISE_KINDS, Noise, NoiseKind, draw_noise
from trial.strength import (
    PARAMETERS,
    NoSuchCampaignError,
    Yardstick,
    draw_parameters,
    parameter_effect,
)

Family = Literal["null", "parameter_only", "single", "pair", "confounded", "outside"]
FAMILIES: tuple[Family, ...] = get_args(Family)
RIG_CLASS = ("run_offset", "drift", "sensor_nonlinearity", *list(PARAMETERS.values())[2:])
TWINS: tuple[tuple[str, ...], ...] = (
    ("contact_stiffness", "sensor_gain"),
    ("contact_angle", "preload_loss", "preload_scale", "torque_scale"),
    ("eccentric_bearing", "output_torsion"),
)
SINGLES = tuple(i for i in LIBRARY if i not in PARAMETERS.values())
STRENGTHS = (3.0, 4.0, 6.0, 8.0, 12.0, 20.0)


# --- one campaign -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Draw:
    """Where a campaign's chance comes from; noise_factor: how much rougher than usual it reads."""

    rng: np.random.Generator
    noise_factor: float = 1.0


@dataclass(frozen=True)
class Setting:
    """Everything but the hidden effects and the noise that falls."""

    case: dict[str, dict[str, Any]]
    drive: Drive
    rows: Rows
    noise: Noise | Instrument
    shifts: dict[str, float]
    priors: dict[str, float]

    @property
    def base(self) -> tuple[Hidden, ...]:
        """The numbers of the drive as they really are."""
        return tuple(parameter_effect(n, s) for n, s in self.shifts.items() if s != 0)

    @property
    def yardstick(self) -> Yardstick:
        """How strong an effect is on this table."""
        return Yardstick.of(self.drive, self.rows, self.base, self.noise, self.priors)


def _setting(
    draw: Draw,
    noise_kind: NoiseKind = "white",
    needs: tuple[str, ...] = (),
    thin: bool = False,
    priors: dict[str, float] | None = None,
    change: Callable[[Plan], Plan] = lambda plan: plan,
) -> Setting:
    """A drive, a plan, its noise and the numbers it really has."""
    rng = draw.rng
    case = draw_case(rng)
    stated = {**PRIORS, **(priors or {})}
    if priors:
        case["uncertainty"] = dict(priors)
    rows = rows_of(change(draw_plan(rng, needs, thin)), case, rng)
    u = float(rng.choice([0.1, 0.2, 0.3, 0.3])) * draw.noise_factor * ARCSEC
    noise = draw_noise(noise_kind, u, rng)
    return Setting(case, drive_of(case), rows, noise, draw_parameters(rng, stated), stated)


def _campaign(
    s: Setting,
    hiddens: tuple[Hidden, ...],
    answer: dict[str, Any],
    rng: np.random.Generator,
    **more: Any,
) -> Campaign:
    """The readings and the sealed truth."""
    effects = (*s.base, *hiddens)
    clean = simulate(s.drive, s.rows, effects)
    read = s.noise.readings(clean, s.rows, rng)
    truth = {
        "answer": answer,
        "hidden": [{"id": h.id, "form": h.form, "values": h.values} for h in hiddens],
        "noise": plain_values(s.noise),
        "shifts": s.shifts,
        "free": [*s.priors, "zero"],
        **more,
    }
    stated = np.full(len(s.rows), s.noise.stated_u_rad)
    return Campaign(s.case, s.rows, read, stated, truth, effects)


def _answer(kind: str, effects: tuple[str, ...] = (), rivals: Any = (), **more: Any) -> Any:
    return {
        "kind": kind,
        "effects": list(effects),
        "rivals": [list(r) for r in rivals],
        **more,
    }


def rivals_of(effect_id: str) -> list[str]:
    """The effects that no torque-angle data tells from this one, or hardly."""
    return next((list(g) for g in TWINS if effect_id in g), [effect_id])


# --- families ---------------------------------------------------------------------------------


def _null(draw: Draw, index: int) -> Campaign:
    kind = NOISE_KINDS[index % len(NOISE_KINDS)]
    s = _setting(draw, kind, thin=index // len(NOISE_KINDS) % 6 == 5)
    calm = kind in ("white", "quantised")
    named = ("run_offset",) if kind == "run_offset" else ()
    kinds = ["complete"] if kind == "white" else ["complete", "rig"]
    answer = _answer("complete" if calm else "rig", named, kinds=kinds)
    return _campaign(s, (), answer, draw.rng, d=0.0)


def _parameter_only(draw: Draw, index: int) -> Campaign:
    s = _setting(draw)
    sigmas = float(draw.rng.uniform(3.0, 6.0) * draw.rng.choice([-1.0, 1.0]))
    s.shifts["contact_stiffness_rel"] = sigmas * PRIORS["contact_stiffness_rel"]
    answer = _answer("parameter", ("contact_stiffness",))
    return _campaign(s, (), answer, draw.rng, shift_sigma=sigmas)


def _hide(draw: Draw, s: Setting, kind: Kind, form: str, d: float) -> Hidden:
    """The effect at the strength; refused where its size would be below what is plausible."""
    found = s.yardstick.sized(draw_hidden(kind, form, draw.rng), d)
    if not kind.signed and kind.neutral == 0 and abs(found.size) < kind.low:
        raise NoSuchCampaignError(f"{kind.id}: too small to be plausible", kind.low / found.size)
    return found


def _single(draw: Draw, index: int) -> Campaign:
    kind = LIBRARY[SINGLES[index % len(SINGLES)]]
    turn = index // len(SINGLES)
    d = STRENGTHS[turn % len(STRENGTHS)]
    other = kind.forms[1:] or kind.forms
    odd = turn + turn // len(STRENGTHS)  # library's form and another in turn, at every strength
    form = other[odd // 2 % len(other)] if odd % 2 else kind.forms[0]
    s = _setting(draw, needs=(kind.needs,))
    found = _hide(draw, s, kind, form, d)
    what = "rig" if kind.id in RIG_CLASS else "effect"
    answer = _answer(what, (kind.id,), also_right=[rivals_of(kind.id)])
    return _campaign(s, (found,), answer, draw.rng, d=d)


def _pair(draw: Draw, index: int) -> Campaign:
    """Two effects, each of the strength when alone; never two of one group of twins."""
    rng = draw.rng
    while True:
        ids = [str(i) for i in rng.choice(SINGLES, 2, replace=False)]
        if ids[1] not in rivals_of(ids[0]):
            break
    kinds = [LIBRARY[i] for i in ids]
    s = _setting(draw, needs=tuple(k.needs for k in kinds))
    d = float(rng.choice([6.0, 8.0, 12.0, 20.0]))
    found = tuple(_hide(draw, s, k, str(rng.choice(k.forms)), d) for k in kinds)
    what = "rig" if all(i in RIG_CLASS for i in ids) else "effect"
    answer = _answer(what, tuple(ids), also_right=[rivals_of(i) for i in ids])
    return _campaign(s, found, answer, draw.rng, d=d)


def _confounded(draw: Draw, index: int) -> Campaign:
    """Six cases in turn where the data, with these priors or this plan, cannot name one effect."""
    case, rng = index % 6, draw.rng
    sign = float(rng.choice([-1.0, 1.0]))
    if case == 0:  # a calibration as doubtful as the drive
        s = _setting(draw, priors={"contact_stiffness_rel": 0.10, "sensor_gain_rel": 0.05})
        found = hidden("sensor_gain", gain=1 + sign * float(rng.uniform(0.03, 0.10)))
        group = rivals_of("sensor_gain")
    elif case == 1:  # preload not measured well
        s = _setting(draw, priors={"preload_gain_rel": 0.2})
        found = hidden("preload_loss", share=float(rng.uniform(0.1, 0.3)))
        group = ["preload_loss", "preload_scale"]
    elif case == 2:  # neither torque nor preload measured well
        s = _setting(draw, priors={"torque_gain_rel": 0.2, "preload_gain_rel": 0.2})
        found = hidden("torque_scale", gain=1 + float(rng.uniform(0.08, 0.15)))
        group = ["preload_loss", "preload_scale", "torque_scale"]
    elif case == 3:  # nine readings
        s = _setting(draw, thin=True)
        kind = LIBRARY["eccentric_bearing"]
        found = s.yardstick.sized(Hidden(kind, {kind.size: 1e-7, "exponent": 0.9}), 8.0)
        group = rivals_of("eccentric_bearing")
    elif case == 4:  # three runs, each at an angle of its own
        s = _setting(draw, needs=("reversal",), change=_three_runs)
        phase = float(rng.uniform(0, 2 * np.pi))
        found = hidden("eccentricity_error", offset_m=0.7e-6, phase_rad=phase)
        group = ["eccentricity_error", "run_offset"]
    else:  # a temperature that rises with time, one level of preload
        s = _setting(draw, needs=("temperature",), change=_steady_warming)
        kind = LIBRARY["thermal_preload"]
        start = Hidden(kind, {kind.size: -0.1})
        found = s.yardstick.sized(start, 8.0)
        group = ["thermal_preload", "wear"]
    exact = case != 3
    within_priors = case < 3  # a refit inside the priors is adequate as well
    kinds = ["ambiguous", "complete"] if within_priors else ["ambiguous"]
    d = None if within_priors else s.yardstick.strength(found)
    answer = _answer("ambiguous", (), [group], kinds=kinds, exact=exact)
    return _campaign(s, (found,), answer, draw.rng, d=d, confounded=case)


def _three_runs(plan: Plan) -> Plan:
    """One level of preload, three angles."""
    few = {"preloads_N": plan.preloads_N[:1], "angles_deg": plan.angles_deg[:3]}
    return Plan(**{**vars(plan), **few, "own_angle_each_run": False})


def _steady_warming(plan: Plan) -> Plan:
    """One level of preload, a housing that warms in proportion to time."""
    return Plan(**{**vars(plan), "preloads_N": plan.preloads_N[:1], "steady_warming": True})


def _outside(draw: Draw, index: int) -> Campaign:
    kind = list(OUTSIDE.values())[index % len(OUTSIDE)]
    d = (6.0, 8.0, 12.0, 20.0, 30.0)[index // len(OUTSIDE) % 5]
    s = _setting(draw, needs=(kind.needs,))
    found = _hide(draw, s, kind, "outside", d)
    return _campaign(s, (found,), _answer("unknown"), draw.rng, d=d)


MAKERS: dict[Family, Callable[[Draw, int], Campaign]] = {
    "null": _null,
    "parameter_only": _parameter_only,
    "single": _single,
    "pair": _pair,
    "confounded": _confounded,
    "outside": _outside,
}


def make_trial(family: Family, index: int, seed: int) -> Campaign:
    """Campaign number index of a family. A draw that does not come together is drawn again.

    The index walks through kinds of noise, effects, strengths and forms in turn; the seed fixes
    everything that is random.
    """

    def made(rng: np.random.Generator, noise_factor: float) -> Campaign:
        return MAKERS[family](Draw(rng, noise_factor), index)

    campaign = drawn(made, (seed, FAMILIES.index(family), index))
    campaign.truth.update(family=family, index=index, seed=seed)
    return campaign


class Drawn(Protocol):
    """What is drawn notes how."""

    @property
    def truth(self) -> Any:
        """What is hidden, and the attempt: a dict."""


D = TypeVar("D", bound=Drawn)


def drawn(made: Callable[[np.random.Generator, float], D], words: tuple[int, ...]) -> D:
    """What is made with the seed of these words, in as many attempts as it takes, up to 40.

    Where an effect does not come to its strength the noise is changed at the next attempt.
    """
    noise_factor = 1.0
    for attempt in range(40):
        rng = np.random.default_rng([*words, attempt])
        try:
            campaign = made(rng, noise_factor)
        except NoSuchCampaignError as missed:
            noise_factor = float(np.clip(noise_factor * missed.noise_factor * 1.2, 0.1, 5.0))
            continue
        except (NotHeldError, ArithmeticError):
            continue
        campaign.truth["attempt"] = attempt
        return campaign
    raise NoSuchCampaignError(f"{words}: 40 draws failed", 1.0)
