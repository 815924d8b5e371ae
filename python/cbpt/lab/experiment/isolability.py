"""Before any reading: what a campaign could see, and what it could tell apart.

    isolability     a case and a plan -> Isolability
    Seen            one effect: the smallest size that would be told
    Pair            two effects: whether and from which sizes they would be told apart

An effect is let act in full at sizes over its plausible range. What is left of the change after
the refit has a length `d` in standard uncertainties; `detectable` says which d a diagnosis tells.
Two effects are told apart as far as the change by one lies outside everything that the other can
look like at any size and shape: with the largest correlation r that is d sqrt(1 - r^2), and half
its square is the log odds that it is expected to bring.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.experiment.design_fit import Sight
from cbpt.lab.experiment.detection import LIMIT, log_odds, weight
from cbpt.lab.experiment.effect_changes import Form, forms_of, guises, possible
from cbpt.lab.experiment.plan import Plan, read_plan
from cbpt.lab.experiment.simulate import Instrument
from cbpt.lab.model.priors import CLASSES, LOT, PRIORS, TWINS, VARIANTS, Variant, lots
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.model_comparison import Progress
from cbpt.lab.selection.setting import prior
from cbpt.lab.wording.versions import versions

__all__ = ["Isolability", "Pair", "Seen", "isolability"]

Floats = NDArray[np.float64]
SCHEMA = "cbpt.isolability/1"

CHANCES = {"even": (0.5, 0.0), "sure": (0.95, 1.6448536269514722)}
"""How often an effect of the size is told, and the normal quantile of that."""
# Correlation from which two effects are one to any reading.
_TWIN = 0.9999
# A pair needs no mention where it is told apart at this many times the smallest size seen.
_SOON = 1.25
_NOTHING = 1e-3


@dataclass(frozen=True, eq=False)
class Seen:
    """One effect as a plan would show it."""

    effect: str
    form: Form = field(repr=False)
    """The form that is seen soonest."""
    d: Floats
    """How far it stands out at the sizes of the form; NaN where the model has no solution."""
    left: Floats = field(repr=False)
    smallest: Mapping[str, float | None]
    """Smallest size (SI, off neutral) that is told with each of `CHANCES`."""
    why_not: str = ""

    @property
    def label(self) -> str:
        """Effect and form."""
        return self.form.variant.effect if self.form.variant.spread else self.form.variant.label

    def values(self, chance: str = "even") -> dict[str, float] | None:
        """Parameters at the smallest size, SI."""
        size = self.smallest[chance]
        return None if size is None else self.form.values(size)


@dataclass(frozen=True)
class Pair:
    """Two effects as a plan would show them.

    verdict: `apart` as soon as they are seen; `above` certain sizes; `not_here` within their
    plausible ranges; `twins`, which no reading of this rig tells apart.
    """

    effects: tuple[str, str]
    correlation: float
    """The largest there is once everything is refitted, each at the smallest size seen."""
    verdict: str
    above: tuple[float | None, float | None]
    """Size of each (SI, off neutral) from which it is told from the other in an even chance,
    whatever the shape of the form that is seen soonest."""
    decided_by: tuple[str, ...] = ()
    """Numbers of `[uncertainty]` that tell twins apart, as far as they can be told."""


@dataclass(frozen=True, eq=False)
class Isolability:
    """What a campaign could see. `to_dict` is the JSON document; `report` says it in words."""

    plan: Plan
    noise: Instrument
    seen: tuple[Seen, ...]
    unseen: Mapping[str, str]
    """Effects that the plan cannot show at all, each with the reason."""
    pairs: tuple[Pair, ...]
    priors: Mapping[str, float]

    def effect(self, effect: str) -> Seen:
        """One of those seen."""
        return next(s for s in self.seen if s.effect == effect)

    def pair(self, one: str, other: str) -> Pair:
        """Two of those seen, in either order."""
        return next(p for p in self.pairs if set(p.effects) == {one, other})

    def looks_most_like(self, effect: str) -> tuple[str | None, float | None]:
        """The other effect that it correlates most with, and by how much."""
        own = [p for p in self.pairs if effect in p.effects]
        if not own:
            return None, None
        most = max(own, key=lambda p: p.correlation)
        return next(e for e in most.effects if e != effect), most.correlation

    def groups(self) -> list[list[str]]:
        """Effects that this campaign cannot tell apart, twins among them."""
        group = {s.effect: {s.effect} for s in self.seen}
        for pair in self.pairs:
            if pair.verdict in ("not_here", "twins") and set(pair.effects) <= set(group):
                one, other = (group[e] for e in pair.effects)
                one |= other
                for effect in one:
                    group[effect] = one
        distinct = {id(g): sorted(g) for g in group.values() if len(g) > 1}
        return sorted(distinct.values())

    def to_dict(self) -> dict[str, Any]:
        """The JSON document as plain values."""
        return deepcopy(_document(self))

    def to_json(self) -> str:
        """The document as text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def report(self) -> str:
        """In words and tables."""
        from cbpt.lab.experiment.isolability_text import lines

        return "\n".join(lines(self))

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw the matrix of pairs to an SVG, PNG or PDF file; needs `pip install "cbpt[plot]"`."""
        from cbpt.figures.isolability import draw_isolability

        draw_isolability(self, path)

    def __repr__(self) -> str:
        return self.report()


def isolability(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    plan: Plan | Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    effects: Sequence[str] | None = None,
    noise: Instrument | str | Sequence[str] = "white",
    u_elastic_angle_arcsec: float | None = None,
    progress: Progress | None = None,
) -> Isolability:
    """What a campaign could see and tell apart, before any reading.

    effects: ids of the library; all where not given. noise: as in `simulate`; it counts through its
    covariance, so tails, outliers and steps count as scatter of their standard deviation.
    progress: as in `diagnose`.

    Raises `NoSolutionError` where the plan's preloads do not hold its torques, `PlanError`,
    `ReadingsError`, `CaseError` and `InvalidInputError` for what cannot be read.
    """
    case = case_of(case)
    of_ball_drives(case)
    instrument = Instrument.of(noise)
    found = read_plan(plan, case).with_u(u_elastic_angle_arcsec)
    wanted = known(effects)
    with threadpool_limits(1, user_api="blas"):
        sight = Sight(case, found, covariance(instrument, found))
        return _isolability(found, instrument, sight, wanted, progress)


def of_ball_drives(case: Case | Drive) -> None:
    """Raise `InvalidInputError` for a torsion spring: what is plausible follows from readings."""
    drive = case if isinstance(case, Drive) else case.drive
    if drive.kind != "ball_drive":
        raise InvalidInputError(
            "a torsion spring says too little of what is plausible before there are readings; "
            "plans are judged for ball drives"
        )


def known(effects: Sequence[str] | None) -> tuple[str, ...]:
    """Ids of effects that can be looked for. Raises `InvalidInputError` for others."""
    every = tuple(dict.fromkeys([*(v.effect for v in VARIANTS), LOT]))
    if not effects:
        return every
    wrong = next((e for e in effects if e not in every), None)
    if wrong is not None and not isinstance(wrong, str):
        raise InvalidInputError(f"effects: found {wrong!r}, expected ids of the library")
    if wrong is not None:
        import difflib

        near = difflib.get_close_matches(wrong, every, 1)
        hint = f"; is {near[0]} meant?" if near else ""
        if wrong == "run_offset":
            hint = "; zeros of runs are a noise: run_offset=SIZE"
        raise InvalidInputError(
            f"effects: found {wrong!r}, expected any of {', '.join(every)}{hint}"
        )
    return tuple(dict.fromkeys(effects))


def covariance(instrument: Instrument, plan: Plan) -> Noise:
    """The noise of a plan as fits see it."""
    u = plan.rows.u_elastic_angle_arcsec
    assert u is not None
    offset = instrument.run_offset_per_u * float(np.median(u))
    return Noise(max(instrument.scale, 1e-3), instrument.correlation, offset)


def _isolability(
    plan: Plan,
    instrument: Instrument,
    sight: Sight,
    effects: Sequence[str],
    progress: Progress | None = None,
) -> Isolability:
    campaign = sight.campaign
    every = (*VARIANTS, *lots(campaign.balls))
    there, lacking = possible(campaign, [v for v in every if v.effect in effects])
    unseen = dict(line.split(": ", 1) for line in lacking)
    told = progress or (lambda what, share: None)
    variants: dict[str, list[Variant]] = {}
    for variant in there:
        variants.setdefault(variant.effect, []).append(variant)
    seen: list[Seen] = []
    alike: dict[str, list[Seen]] = {}
    looks: dict[str, list[Floats]] = {}
    for number, effect in enumerate(variants):
        share = 0.8 * number / len(variants)
        told(effect, share)
        own = forms_of(campaign, variants[effect])
        lefts = []
        for form in own:
            told(effect, share)
            lefts.append(_left(sight, form))
        prices = _prices(own, lefts)
        found = [
            _seen(sight, form, left, weight(every, form.variant) + price)
            for form, left, price in zip(own, lefts, prices, strict=True)
        ]
        best = _soonest(found)
        if best.smallest["even"] is None:
            unseen[effect] = best.why_not
            continue
        seen.append(best)
        # The same form at every shape at which it is seen, the soonest first.
        shaped = [s for s in found if s.form.variant is best.form.variant and s is not best]
        alike[effect] = [best, *(s for s in shaped if s.smallest["even"] is not None)]
        looks[effect] = _looks(sight, found)
    order = {effect: i for i, effect in enumerate(effects)}
    seen.sort(key=lambda s: order[s.effect])
    pairs = []
    for i, one in enumerate(seen):
        told("pairs of effects", 0.8 + 0.2 * i / len(seen))
        pairs += [
            _pair(alike[one.effect], alike[other.effect], looks[one.effect], looks[other.effect])
            for other in seen[i + 1 :]
            if LOT not in (one.effect, other.effect)
        ]
    pairs += _twins_unseen(effects, unseen)
    return Isolability(plan, instrument, tuple(seen), unseen, tuple(pairs), campaign.priors)


# --- one effect ---------------------------------------------------------------------------


def _left(sight: Sight, form: Form) -> Floats:
    return sight.left(form.slopes) if form.variant.spread else sight.refitted(form.changes)


def _prices(forms: Sequence[Form], lefts: Sequence[Floats]) -> list[Floats]:
    """What the free shape of each form costs at every size: the logarithm of the part of its range
    that the readings leave it (Laplace), from how its neighbour differs.
    """
    found = []
    for form, left in zip(forms, lefts, strict=True):
        price = np.zeros(len(form.sizes))
        for shape in form.variant.shapes:
            low, high = (np.log(v) if shape.log else v for v in (shape.low, shape.high))
            here = form.shapes[shape.name]
            steps = []
            for other, there in zip(forms, lefts, strict=True):
                if other.variant is form.variant and other is not form:
                    size = np.maximum(np.linalg.norm(left, axis=0), 1e-300)
                    along = np.sum(left * there, axis=0) / size
                    across = np.sum(there**2, axis=0) - along**2
                    value = other.shapes[shape.name]
                    step = np.log(value / here) if shape.log else value - here
                    steps.append((abs(float(step)), np.maximum(across, 0.0)))
            if steps:
                step, across = min(steps, key=lambda s: s[0])
                price -= 0.5 * np.log1p(across * ((high - low) / step) ** 2 / 12)
        found.append(price)
    return found


def _seen(sight: Sight, form: Form, left: Floats, odds: Floats) -> Seen:
    """odds: prior log odds of the form, and the price of its shape, at every size."""
    variant, n = form.variant, len(sight.campaign)
    smallest: dict[str, float | None] = {}
    if variant.spread:
        d, odds_at = _lot(form, left)
        for name, (_, z) in CHANCES.items():
            smallest[name] = crossing(form.sizes, odds_at(z) + odds)
        left = np.zeros((0, len(d)))
    else:
        d = np.linalg.norm(left, axis=0)
        size, fine = between(form.sizes, d)
        price = np.interp(size, form.sizes, odds)
        for name, (_, z) in CHANCES.items():
            stands = np.maximum(fine - z, 0.0)
            smallest[name] = crossing(size, log_odds(variant, stands, size, n, price))
    why = ""
    if smallest["even"] is None:
        why = "not seen within its plausible range"
        if np.isnan(d).any():
            why = "the preloads do not hold the torques before it is seen"
        elif np.nanmax(d) < 0.1:
            why = "these runs do not show it at all"
    return Seen(variant.effect, form, d, left, smallest, why)


def _lot(form: Form, left: Floats) -> tuple[Floats, Callable[[float], Floats]]:
    """How far a lot of balls stands out, and its log odds, by the spread of their diameters."""
    curvature = np.maximum(np.linalg.eigvalsh(left.T @ left), 0.0)
    seen = np.outer((form.sizes / form.variant.low) ** 2, curvature)
    mean = 0.5 * np.sum(seen - np.log1p(seen), axis=1)
    spread = np.sqrt(0.5 * np.sum(seen**2, axis=1))
    return np.sqrt(seen.sum(axis=1)), lambda z: mean - z * spread


def between(sizes: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Sizes and d in small steps, as powers of each other in between; up to the first NaN."""
    end = int(np.argmax(np.isnan(d))) if np.isnan(d).any() else len(d)
    if end < 2:
        return sizes[:end], d[:end]
    fine = np.geomspace(sizes[0], sizes[end - 1], 40 * end)
    log_d = np.interp(np.log(fine), np.log(sizes[:end]), np.log(np.maximum(d[:end], 1e-12)))
    return fine, np.exp(log_d)


def _soonest(found: Sequence[Seen]) -> Seen:
    """The form seen at the smallest part of its plausible range; else the one seen best."""

    def rank(seen: Seen) -> tuple[float, float]:
        size = seen.smallest["even"]
        at = np.inf if size is None else size / seen.form.sizes[0]
        largest = np.nanmax(seen.d) if np.isfinite(seen.d).any() else 0.0
        return at, -float(largest)

    return min(found, key=rank)


def crossing(sizes: Floats, log_odds: Floats) -> float | None:
    """The smallest size at which log odds reach the limit."""
    reached = np.flatnonzero(log_odds >= LIMIT)
    if not len(reached):
        return None
    j = int(reached[0])
    if j == 0:
        return float(sizes[0])
    part = (LIMIT - log_odds[j - 1]) / (log_odds[j] - log_odds[j - 1])
    return float(sizes[j - 1] * (sizes[j] / sizes[j - 1]) ** part)


# --- two effects --------------------------------------------------------------------------


def _looks(sight: Sight, found: Sequence[Seen]) -> list[Floats]:
    """An orthonormal basis of each guise of an effect, of what refitting leaves of it."""
    lefts = [(s.form, s.left, sight.left(s.form.slopes)) for s in found]
    looks = []
    for columns in guises(lefts):
        size = np.linalg.norm(columns, axis=0)
        # What the refit follows to a thousandth of a standard uncertainty is nothing.
        if np.isfinite(size).all() and size.min() > _NOTHING:
            basis, strength, _ = np.linalg.svd(columns / size, full_matrices=False)
            looks.append(basis[:, strength > 1e-6])
    return looks


def explained(left: Floats, looks: Sequence[Floats]) -> Floats:
    """Largest correlation of each column with any of the guises."""
    size = np.maximum(np.linalg.norm(left, axis=0), 1e-300)
    best = np.zeros(left.shape[1])
    for basis in looks:
        best = np.maximum(best, np.linalg.norm(basis.T @ (left / size), axis=0))
    return np.asarray(np.minimum(best, 1.0))


def _pair(
    one: list[Seen], other: list[Seen], one_looks: list[Floats], other_looks: list[Floats]
) -> Pair:
    names = one[0].effect, other[0].effect
    odds = prior(names[:1]) - prior(names[1:])
    sides = [_told(one, other_looks, odds), _told(other, one_looks, -odds)]
    twins = names[1] in TWINS.get(names[0], []) or min(s[2] for s in sides) > _TWIN
    decided = _deciding(names) if twins else ()
    above = sides[0][0], sides[1][0]
    verdict = _verdict(twins, (one[0], other[0]), above)
    return Pair(names, max(s[1] for s in sides), verdict, above, decided)


def _twins_unseen(effects: Sequence[str], unseen: Mapping[str, str]) -> list[Pair]:
    """Twins of which this plan does not show both."""
    return [
        Pair((one, other), 1.0, "twins", (None, None), _deciding((one, other)))
        for i, one in enumerate(effects)
        for other in effects[i + 1 :]
        if other in TWINS.get(one, []) and (one in unseen or other in unseen)
    ]


def _deciding(names: tuple[str, str]) -> tuple[str, ...]:
    """Numbers of `[uncertainty]` that stand behind effects."""
    return tuple(PRIORS[e] for e in names if e in PRIORS)


def _told(
    shapes: list[Seen], looks: list[Floats], odds: float
) -> tuple[float | None, float, float]:
    """Of an effect against another: the size from which it is told, by the shape that needs most
    above what is seen of it; the largest correlation at the smallest size; the least at any.
    """
    ratios: list[float | None] = []
    there, least = [], []
    for seen in shapes:
        smallest = seen.smallest["even"]
        assert smallest is not None
        r = explained(seen.left, looks)
        sizes, apart = between(seen.form.sizes, seen.d * np.sqrt(1 - r**2))
        size = crossing(sizes, 0.5 * apart**2 + odds)
        ratios.append(None if size is None else max(size / smallest, 1.0))
        solved = np.isfinite(seen.d)
        there.append(float(np.interp(smallest, seen.form.sizes[solved], r[solved])))
        least.append(float(r[solved].min()))
    known = [ratio for ratio in ratios if ratio is not None]
    above = max(known) * (shapes[0].smallest["even"] or 0.0) if len(known) == len(ratios) else None
    return above, max(there), min(least)


def _verdict(twins: bool, seen: tuple[Seen, Seen], above: tuple[float | None, float | None]) -> str:
    if twins:
        return "twins"
    if above[0] is None or above[1] is None:
        return "not_here"
    soon = [
        size <= _SOON * (each.smallest["even"] or 0.0)
        for each, size in zip(seen, above, strict=True)
        if size is not None
    ]
    return "apart" if all(soon) else "above"


# --- the document -------------------------------------------------------------------------


def _document(i: Isolability) -> dict[str, Any]:
    rows = i.plan.rows
    return {
        "schema": SCHEMA,
        "versions": versions(),
        "source": rows.source,
        "rows": len(rows),
        "runs": int(rows.run_index.max()) + 1,
        "noise": {
            "scale": i.noise.scale,
            "correlation": i.noise.correlation,
            "run_offset_per_u": i.noise.run_offset_per_u,
        },
        "criterion": {
            "log_odds": LIMIT,
            "chances": {name: chance for name, (chance, _) in CHANCES.items()},
        },
        "priors": {PRIORS[e]: sd for e, sd in i.priors.items()},
        "effects": [_entry(i, s) for s in i.seen],
        "unseen": [{"effect": e, "why": why} for e, why in i.unseen.items()],
        "pairs": [
            {
                "effects": list(p.effects),
                "correlation": p.correlation,
                "verdict": p.verdict,
                "above": {
                    e: None if size is None else i.effect(e).form.values(size)
                    for e, size in zip(p.effects, p.above, strict=True)
                },
                "decided_by": list(p.decided_by),
            }
            for p in i.pairs
        ],
        "groups": i.groups(),
    }


def _entry(i: Isolability, s: Seen) -> dict[str, Any]:
    rival, correlation = i.looks_most_like(s.effect)
    return {
        "effect": s.effect,
        "class": CLASSES.get(s.effect, "effect"),
        "form": s.label,
        "smallest": {name: s.values(name) for name in CHANCES},
        "sizes": [
            {"values": s.form.values(float(size)), "d": None if np.isnan(d) else float(d)}
            for size, d in zip(s.form.sizes, s.d, strict=True)
        ],
        "looks_most_like": rival,
        "correlation": correlation,
    }
