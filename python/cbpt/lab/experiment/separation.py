"""How far one effect stands out in a plan, and how far two can be told apart.

left_of         what refitting leaves of an effect at its sizes
prices_of       what a free shape costs
seen_in         one effect: the smallest size that would be told
soonest         the form that is seen soonest
guises_left     everything that an effect can look like after a refit
pair_of         two effects: whether and from which sizes they would be told apart
twins_unseen    twins of which a plan does not show both
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.experiment.design_fit import Sight
from cbpt.lab.experiment.detection import LIMIT, log_odds
from cbpt.lab.experiment.effect_changes import Form, guises
from cbpt.lab.experiment.isolability_data import CHANCES, Pair, Seen
from cbpt.lab.model.priors import PRIORS, TWINS
from cbpt.lab.selection.setting import prior

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """When two effects count as separated."""

    twin: float = 0.9999
    """Correlation from which two effects are one to any reading."""
    soon: float = 1.25
    """A pair needs no mention where it is told apart at this many times the smallest size
    seen.
    """
    nothing: float = 1e-3


_LIMITS = _Limits()


# --- one effect ---------------------------------------------------------------------------


def left_of(sight: Sight, form: Form) -> Floats:
    return sight.left(form.slopes) if form.variant.spread else sight.refitted(form.changes)


def prices_of(forms: Sequence[Form], lefts: Sequence[Floats]) -> list[Floats]:
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
                    step = abs(float(np.log(value / here) if shape.log else value - here))
                    # Neighbours in another shape say nothing of this one.
                    steps += [(step, np.maximum(across, 0.0))] if step else []
            if steps:
                step, across = min(steps, key=lambda s: s[0])
                price -= 0.5 * np.log1p(across * ((high - low) / step) ** 2 / 12)
        found.append(price)
    return found


def seen_in(sight: Sight, form: Form, left: Floats, odds: Floats) -> Seen:
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
        why = "not detected within its plausible range"
        if np.isnan(d).any():
            why = "at detectable sizes the preload no longer holds the torque"
        elif np.nanmax(d) < 0.1:
            why = "these runs are not sensitive to it"
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


def soonest(found: Sequence[Seen]) -> Seen:
    """The simplest form that is seen, at the smallest part of its plausible range; else the one
    seen best."""

    def rank(seen: Seen) -> tuple[bool, int, float, float]:
        size, variant = seen.smallest["even"], seen.form.variant
        at = np.inf if size is None else size / seen.form.sizes[0]
        largest = np.nanmax(seen.d) if np.isfinite(seen.d).any() else 0.0
        return size is None, len(variant.sizes) + len(variant.shapes), at, -float(largest)

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


def guises_left(sight: Sight, found: Sequence[Seen]) -> list[Floats]:
    """An orthonormal basis of each guise of an effect, of what refitting leaves of it."""
    lefts = [(s.form, s.left, sight.left(s.form.slopes)) for s in found]
    looks = []
    for columns in guises(lefts):
        size = np.linalg.norm(columns, axis=0)
        # What the refit follows to a thousandth of a standard uncertainty is nothing.
        if np.isfinite(size).all() and size.min() > _LIMITS.nothing:
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


def pair_of(
    one: list[Seen], other: list[Seen], one_looks: list[Floats], other_looks: list[Floats]
) -> Pair:
    names = one[0].effect, other[0].effect
    odds = prior(names[:1]) - prior(names[1:])
    sides = [_apart_from(one, other_looks, odds), _apart_from(other, one_looks, -odds)]
    twins = names[1] in TWINS.get(names[0], []) or min(s[2] for s in sides) > _LIMITS.twin
    decided = _deciding(names) if twins else ()
    above = sides[0][0], sides[1][0]
    verdict = _verdict(twins, (one[0], other[0]), above)
    return Pair(names, max(s[1] for s in sides), verdict, above, decided)


def twins_unseen(effects: Sequence[str], unseen: Mapping[str, str]) -> list[Pair]:
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


def _apart_from(
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
        size <= _LIMITS.soon * (each.smallest["even"] or 0.0)
        for each, size in zip(seen, above, strict=True)
        if size is not None
    ]
    return "apart" if all(soon) else "above"
