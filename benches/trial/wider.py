"""Wider families: effects under every noise, coarse displays, artefacts, small and lawless tables.

    one, two, three   effects of a conditional strength under every noise, zeros and correlation too
    strong            one effect that stands out by far, so that its form matters
    slide             one or two on cross-slides
    coarse, artefact  nothing hidden: coarse displays, and things that instruments do
    small             6 to 40 readings, with an effect and without
    lawless           the model times random factors
    (torsion springs, set, under artefacts and by a logger with a clock: spring_sets)

Of several effects d is that of the weakest with the sizes of the others refitted too, to first
order. What the oracle says stands beside each campaign that it can weigh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from reference.contact import Floats
from reference.rig import ARCSEC, Rows, drive_of, simulate
from reference.rig.campaign import COLUMNS, PRIORS, Campaign, Plan, draw_case, draw_plan, rows_of
from reference.rig.effects import LIBRARY, Hidden, draw_hidden
from reference.rig.instrument import (
    ARTEFACTS,
    COARSE,
    TOGETHER,
    ZEROS,
    Instrument,
    instrument,
    plain_values,
)
from reference.rig.noise import NOISE_KINDS
from trial.candidates import Signer, candidates, conditional
from trial.evidence import likeliest, posterior, spoken
from trial.families import RIG_CLASS, SINGLES, Draw, Setting, drawn, rivals_of
from trial.spring_sets import spring_artefact, spring_logged, spring_set
from trial.strength import NoSuchCampaignError, draw_parameters

Wider = Literal[
    "one",
    "two",
    "three",
    "slide",
    "coarse",
    "artefact",
    "small",
    "lawless",
    "spring",
    "spring_artefact",
    "spring_logged",
    "strong",
]
WIDER: tuple[Wider, ...] = get_args(Wider)
"""In the order in which they came: a family's place is part of the seed of its campaigns."""
OTHERS = tuple(k for k in NOISE_KINDS if k != "white")
SIZES = (6, 8, 10, 12, 16, 20, 25, 30, 40)
SYNONYMS = {"bearing_play": ["bearing_play", "backlash"]}
"""Play in the bearing and play between the members are one to readings without friction."""
Made = tuple[Campaign, dict[str, Any] | None]


# --- what is set up ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Wanted:
    """What a campaign is to be: its noise, the effects' ids, their strength, the table."""

    noise: str = "white"
    ids: tuple[str, ...] = ()
    d: float = 0.0
    readings: int = 0
    slide: bool = False


def _setting(draw: Draw, wanted: Wanted) -> Setting:
    """A drive, a plan, its noise and the numbers it really has."""
    rng = draw.rng
    case = draw_case(rng)
    while wanted.slide and case["equal_speed"]["kind"] != "cross_slide":
        case = draw_case(rng)
    needs = tuple(LIBRARY[i].needs for i in wanted.ids)
    plan = _few(wanted.readings, rng) if wanted.readings else draw_plan(rng, needs)
    rows = rows_of(plan, case, rng)
    if wanted.readings:
        rows = rows.take(np.arange(min(wanted.readings, len(rows))))
    u = float(rng.choice([0.1, 0.2, 0.3, 0.3])) * draw.noise_factor * ARCSEC
    drive = drive_of(case)
    top = rows.torque_Nm == rows.torque_Nm.max()
    compliance = float(np.max(simulate(drive, rows)[top])) / float(rows.torque_Nm.max())
    noise = instrument(wanted.noise, u, compliance, rng)
    return Setting(case, drive, rows, noise, draw_parameters(rng, PRIORS), dict(PRIORS))


def _few(readings: int, rng: np.random.Generator) -> Plan:
    """A plan of about so many readings: ramps up, or loops where there is room for them."""
    runs = 1 if readings < 12 else (2 if readings < 25 else int(rng.integers(2, 4)))
    each = -(-readings // runs)
    one_way = each < 13
    steps = each - 1 if one_way else -(-(each - 1) // 4)
    low = float(rng.integers(35, 80)) * 10
    return Plan(
        preloads_N=(low,) if runs < 3 else tuple(low * f for f in (1.0, 1.5, 2.2)[:runs]),
        angles_deg=tuple(float(a) for a in rng.integers(0, 360, runs if runs < 3 else 1)),
        own_angle_each_run=False,
        cycles=1,
        steps=steps,
        torque_share=float(rng.uniform(0.6, 0.9)),
        negative=not one_way,
        dwells_s=(4.0,),
        warming_K=float(rng.uniform(0.5, 3)),
        one_way=one_way,
    )


def _read(s: Setting, hiddens: tuple[Hidden, ...], rng: np.random.Generator) -> Campaign:
    """The readings, with a truth that tells what is hidden and nothing yet of the answer."""
    effects = (*s.base, *hiddens)
    real, shown = s.rows, s.rows
    if isinstance(s.noise, Instrument):
        real, shown = s.noise.loads(s.rows, rng)
    read = s.noise.readings(simulate(s.drive, real, effects), real, rng)
    truth = {
        "hidden": [{"id": h.id, "form": h.form, "values": h.values} for h in hiddens],
        "noise": plain_values(s.noise),
        "shifts": s.shifts,
        "free": [*s.priors, "zero"],
        "accepted": [SYNONYMS.get(h.id, [h.id]) for h in hiddens],
        "readings": len(shown),
        "d": 0.0,
    }
    return Campaign(s.case, shown, read, np.full(len(shown), s.noise.stated_u_rad), truth, effects)


# --- effects at a conditional strength --------------------------------------------------------


def sized(signer: Signer, starts: Sequence[Hidden], d: float) -> tuple[list[Hidden], list[float]]:
    """Effects of which each leaves d when everything else is refitted, and what they leave."""
    found = list(starts)
    for _ in range(12):
        _, left = conditional(signer, found)
        if all(abs(x / d - 1) < 0.04 for x in left):
            break
        for i, (h, x) in enumerate(zip(found, left, strict=True)):
            factor = float(np.clip(d / x if x > 0 else 30.0, 0.05, 30.0))
            size = h.kind.neutral + (h.size - h.kind.neutral) * factor
            if abs(size - h.kind.neutral) > abs(h.kind.high - h.kind.neutral):
                raise NoSuchCampaignError(f"{h.id}: d = {d:g} is beyond its range here", 0.5)
            found[i] = h.sized(size)
    else:
        raise NoSuchCampaignError(f"{[h.id for h in found]}: no such strength", 0.8)
    for h in found:
        off = abs(h.size - h.kind.neutral)
        if not h.kind.signed and h.kind.neutral == 0 and off < h.kind.low:
            raise NoSuchCampaignError(f"{h.id}: too small to be plausible", h.kind.low / off)
    return found, left


def _hidden(draw: Draw, wanted: Wanted, s: Setting) -> tuple[tuple[Hidden, ...], dict[str, Any]]:
    signer = Signer(s.yardstick)
    kinds = [LIBRARY[i] for i in wanted.ids]
    starts = [draw_hidden(k, str(draw.rng.choice(k.forms)), draw.rng) for k in kinds]
    found, left = sized(signer, starts, wanted.d)
    if len(found) == 1:  # the refit of the drive's numbers is not linear where a knee moves
        for _ in range(3):
            full = s.yardstick.strength(found[0])
            if not np.isfinite(full) or abs(full / wanted.d - 1) < 0.06:
                break
            found, _ = sized(signer, found, left[0] * wanted.d / full)
            left = conditional(signer, found)[1]
        if not np.isfinite(full) or abs(full / wanted.d - 1) > 0.12:
            raise NoSuchCampaignError(f"{wanted.ids}: no such strength", 0.8)
        left = [full]
    each = {"conditional": left, "d": min(left)}
    if len(found) > 1:
        alone = [conditional(signer, [h])[1][0] for h in found]
        if min(x / a for x, a in zip(left, alone, strict=True)) < 0.35:
            raise NoSuchCampaignError(f"{wanted.ids}: too like each other here", 1.0)
        each["alone"] = alone
    return tuple(found), each


def with_effects(draw: Draw, wanted: Wanted) -> Made:
    """A campaign with effects and what the oracle says of it."""
    s = _setting(draw, wanted)
    hiddens, strengths = _hidden(draw, wanted, s)
    made = _read(s, hiddens, draw.rng)
    kind = "rig" if all(i in RIG_CLASS for i in wanted.ids) else "effect"
    answer = {
        "kind": kind,
        "effects": list(wanted.ids),
        "rivals": [],
        "also_right": [rivals_of(i) for i in wanted.ids],
    }
    made.truth.update(strengths, answer=answer)
    return made, oracle(s, made, hiddens)


def oracle(s: Setting, made: Campaign, hiddens: Sequence[Hidden]) -> dict[str, Any]:
    """What follows from the evidence of all sets of the rig's own forms under the true noise."""
    signer = Signer(s.yardstick)
    shifts = [s.shifts[n] / sd for n, sd in s.priors.items()]
    off: Floats = made.angle_rad - s.yardstick.angle_rad + s.yardstick.slopes_rad @ shifts
    left_out = ("run_offset",) if s.noise.offset_rad > 0 else ()
    found = posterior(s.yardstick.whiten(off), candidates(signer, hiddens, left_out))
    return {"answer": spoken(found), "best": likeliest(found)}


def nothing(draw: Draw, wanted: Wanted) -> Made:
    """A campaign in which nothing but noise and calibrations is at work."""
    s = _setting(draw, wanted)
    made = _read(s, (), draw.rng)
    kinds = ["complete"] if wanted.noise == "white" else ["complete", "rig"]
    named = ["run_offset"] if wanted.noise in ZEROS else []
    made.truth["answer"] = {"kind": kinds[-1], "effects": named, "rivals": [], "kinds": kinds}
    return made, None


# --- families ---------------------------------------------------------------------------------


def _ids(
    rng: np.random.Generator, count: int, noise: str, first: int | None = None
) -> tuple[str, ...]:
    """Effects, no two of one group of twins; no zeros of runs where the noise has them."""
    pool = [i for i in SINGLES if i != "run_offset" or (noise not in ZEROS and count == 1)]
    while True:
        ids = [str(i) for i in rng.choice(pool, count, replace=False)]
        if first is not None and SINGLES[first % len(SINGLES)] in pool:
            ids[0] = SINGLES[first % len(SINGLES)]
        groups = [tuple(rivals_of(i)) for i in ids]
        if len(set(groups)) == count:
            return tuple(ids)


Slot = tuple[str, float]
ONE: tuple[Slot, ...] = (
    ("white", 8.0),
    (TOGETHER, 8.0),
    ("white", 12.0),
    (TOGETHER, 12.0),
    ("white", 6.0),
    ("other", 8.0),
)
TWO: tuple[Slot, ...] = (
    ("white", 8.0),
    (TOGETHER, 8.0),
    ("white", 12.0),
    (TOGETHER, 12.0),
    ("other", 12.0),
)
THREE: tuple[Slot, ...] = (("white", 12.0), (TOGETHER, 12.0), ("white", 20.0))
STRONG: tuple[Slot, ...] = (("white", 40.0), (TOGETHER, 40.0), ("white", 100.0), ("other", 60.0))
SLIDE: tuple[tuple[str, float, int], ...] = (
    ("white", 8.0, 1),
    ("white", 12.0, 2),
    (TOGETHER, 12.0, 1),
    (TOGETHER, 12.0, 2),
    ("white", 0.0, 0),
)


def _slot(slots: Sequence[Slot], index: int) -> tuple[str, float, int]:
    """Noise, strength and which time round; the other noises take turns."""
    turn = index // len(slots)
    noise, d = slots[index % len(slots)]
    return (OTHERS[turn % len(OTHERS)] if noise == "other" else noise), d, turn


def _one(draw: Draw, index: int) -> Made:
    noise, d, turn = _slot(ONE, index)
    ids = _ids(draw.rng, 1, noise, first=5 * turn + 3 * (index % len(ONE)))
    return with_effects(draw, Wanted(noise, ids, d))


def _two(draw: Draw, index: int) -> Made:
    noise, d, _ = _slot(TWO, index)
    return with_effects(draw, Wanted(noise, _ids(draw.rng, 2, noise), d))


def _three(draw: Draw, index: int) -> Made:
    noise, d, _ = _slot(THREE, index)
    return with_effects(draw, Wanted(noise, _ids(draw.rng, 3, noise), d))


def _strong(draw: Draw, index: int) -> Made:
    noise, d, turn = _slot(STRONG, index)
    ids = _ids(draw.rng, 1, noise, first=5 * turn + 3 * (index % len(STRONG)))
    return with_effects(draw, Wanted(noise, ids, d))


def _slide(draw: Draw, index: int) -> Made:
    noise, d, count = SLIDE[index % len(SLIDE)]
    if not count:
        return nothing(draw, Wanted(noise, slide=True))
    return with_effects(draw, Wanted(noise, _ids(draw.rng, count, noise), d, slide=True))


def _coarse(draw: Draw, index: int) -> Made:
    return nothing(draw, Wanted((*COARSE, TOGETHER)[index % 4]))


def _artefact(draw: Draw, index: int) -> Made:
    made, _ = nothing(draw, Wanted(_TURNS[index % len(_TURNS)]))
    made.truth["answer"]["kinds"] = ["complete", "rig"]
    return made, None


def _small(draw: Draw, index: int) -> Made:
    """With an effect that such a table can show and without, in turn."""
    readings = SIZES[index // 2 % len(SIZES)]
    if index % 2:
        return nothing(draw, Wanted(readings=readings))
    shown = [i for i in SINGLES if LIBRARY[i].needs in ("", "reversal") and i != "run_offset"]
    if readings < 25:
        shown = [i for i in shown if not LIBRARY[i].needs]
    ids = (str(draw.rng.choice(shown)),)
    return with_effects(draw, Wanted("white", ids, (8.0, 12.0)[index // 4 % 2], readings))


@dataclass(frozen=True)
class Bare(Campaign):
    """A table without run, time and temperature."""

    def columns(self) -> dict[str, Floats]:
        """Torque, preload, input angle, angle and its uncertainty."""
        return {k: v for k, v in super().columns().items() if k in (*COLUMNS[3:6], *COLUMNS[7:])}


def _lawless(draw: Draw, index: int) -> Made:
    """Loads at random, and angles that are the model's times a factor between 0.6 and 1.4."""
    rng, readings = draw.rng, SIZES[index % len(SIZES)]
    s = _setting(draw, Wanted())
    pick = np.sort(rng.choice(len(s.rows), readings, replace=False))
    rows: Rows = replace(s.rows.take(pick), run=np.ones(readings, dtype=np.int64))
    torque = rng.permutation(rows.torque_Nm) + 0.05 * rows.torque_Nm.max()
    rows = replace(rows, torque_Nm=(torque * 0.95).round(4))
    s = replace(s, rows=rows)
    made = _read(s, (), rng)
    clean = simulate(s.drive, rows, s.base)
    read = clean * rng.uniform(0.6, 1.4, readings)
    made.truth.update(lawless=True, answer={"kind": "undecided", "effects": [], "rivals": []})
    bare = Bare if index % 2 else Campaign
    stated = made.stated_u_rad
    return bare(made.case, rows, read, stated, made.truth, made.effects), None


def _spring(draw: Draw, index: int) -> Made:
    return spring_set(draw.rng, draw.noise_factor, index)


def _spring_artefact(draw: Draw, index: int) -> Made:
    return spring_artefact(draw.rng, draw.noise_factor, index), None


def _spring_logged(draw: Draw, index: int) -> Made:
    return spring_logged(draw.rng, draw.noise_factor, index), None


_TURNS = (*ARTEFACTS[:-1] * 4, *ARTEFACTS[-1:] * 4)
"""Artefacts in the order in which they are made: the last one came to the others later."""

MAKERS: dict[Wider, Callable[[Draw, int], Made]] = {
    "one": _one,
    "two": _two,
    "three": _three,
    "strong": _strong,
    "slide": _slide,
    "coarse": _coarse,
    "artefact": _artefact,
    "small": _small,
    "lawless": _lawless,
    "spring": _spring,
    "spring_artefact": _spring_artefact,
    "spring_logged": _spring_logged,
}


def make_wider(family: Wider, index: int, seed: int) -> Made:
    """Campaign number index of a wider family with what the oracle says of it, or None."""
    said: list[dict[str, Any] | None] = []

    def made(rng: np.random.Generator, noise_factor: float) -> Campaign:
        campaign, found = MAKERS[family](Draw(rng, noise_factor), index)
        said[:] = [found]
        return campaign

    campaign = drawn(made, (seed, 100 + WIDER.index(family), index))
    campaign.truth.update(family=family, index=index, seed=seed)
    return campaign, said[0]
