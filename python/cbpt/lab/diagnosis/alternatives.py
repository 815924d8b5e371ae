"""What an answer may have overlooked: effects that the readings could hardly show, and effects
that a changed parameter could stand for.

    smallest    the smallest size of each effect that would have been detected, about the final fit
    unseen      those effects whose smallest size lies beyond half of what is likely
    moved       numbers of drive and rig that moved, with the effects that look like it
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.model.priors import LOT, TWINS, Variant
from cbpt.lab.selection.linear_screen import Screen, Stack
from cbpt.lab.selection.rules import RULES
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit, display, rounded, shown


@dataclass(frozen=True)
class _Limits:
    """When a moved number is an alternative."""

    alike: float = 3.0
    """What an effect may leave of the change that a moved number made, in standard
    uncertainties of the readings: about what can be told half the time without a price for
    having looked.
    """
    moved: float = 0.8
    """A number that moved by less than this, in standard uncertainties, is not worth a word."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class Smallest:
    """The smallest size of an effect that would have been seen."""

    effect: str
    name: str
    """Of the parameter that is its size."""
    value: float
    """SI."""
    neutral: float
    """Value at which it does nothing."""
    share: float
    """Of the largest likely size."""
    shapes: dict[str, float]
    """The other parameters, at which it shows itself best."""

    def says(self, angle: AngleUnit) -> str:
        """In the unit that people read."""
        if not self.neutral:
            told = shown((self.effect, self.name), self.value, None, angle=angle)
            return f"{self.effect} smaller than {told}"
        label, size = angle.named(*display(self.effect, self.name))
        off = abs(self.value - self.neutral) / size
        which = "" if label == self.effect else f" with {label}"
        return f"{self.effect}{which} less than {rounded(off, 2)} from {self.neutral / size:g}"


def _screen(d: DiagnosisData) -> Screen:
    c = d.competition
    return Screen(d.after, Stack(c.library.about(d.after, c.names, secants=False)))


def smallest(d: DiagnosisData) -> list[Smallest]:
    """By effect, in its simplest form; those of the answer, and those that cannot be seen at any
    likely size, are not among them.
    """
    screen, fitter = _screen(d), d.competition.fitter
    # Odds of 20 : 1 after prior odds of 1 : 50 and the price of a free size.
    need = np.sqrt(2 * (RULES.log_rival_odds + np.log(50.0) + 3.0))
    best: dict[str, tuple[tuple[int, float], Smallest]] = {}
    for m, s in enumerate(screen.signatures):
        effect, lot = s.variant.effect, bool(s.variant.spread)
        if not screen.usable[m] or effect in d.verdict.names:
            continue
        strength = np.diag(screen.gram)[screen.places[m]]
        # Of a lot all balls show together.
        units = float(need / np.sqrt(strength.sum() if lot else strength[0]))
        size = units * float(s.unit[0])
        name = "spread_m" if lot else s.variant.sizes[0]
        neutral = 0.0 if lot else fitter.neutral(effect, name)
        shapes = dict(s.variant.fixed) | s.shapes
        largest = _largest_spread(fitter.variants) if lot else s.variant.high
        one = Smallest(effect, name, neutral + size, neutral, size / largest, shapes)
        rank = len(s.shapes), units
        if effect not in best or rank < best[effect][0]:
            best[effect] = rank, one
    return [one for _, (_, one) in sorted(best.items())]


def _largest_spread(variants: Iterable[Variant]) -> float:
    return max(v.spread for v in variants if v.effect == LOT)


def unseen(d: DiagnosisData, angle: AngleUnit = ARCSEC) -> list[str]:
    """In words; an effect that would not be seen at any likely size says so."""
    found = smallest(d)
    known = {one.effect for one in found} | set(d.verdict.names)
    blind = {v.effect for v in d.competition.fitter.variants} - known
    return [one.says(angle) for one in found if one.share > 0.5] + [
        f"{effect} of any likely size" for effect in sorted(blind)
    ]


def moved(d: DiagnosisData) -> Iterator[dict[str, Any]]:
    """Numbers that moved in the final fit, how far in standard uncertainties, and what else of the
    library makes the same change."""
    c, fit = d.competition, d.after
    stated = c.campaign.priors
    signatures = [s for s in _screen(d).signatures if not s.variant.spread]
    offsets = fit.whitener(c.campaign.offsets)
    for i, u in enumerate(fit.unknowns):
        if u.name not in stated or not np.isfinite(u.sd):
            continue
        sigma = (fit.value(u) - u.mean) / u.sd
        if abs(sigma) <= _LIMITS.moved:
            continue
        change = sigma * _without(offsets, fit.margin.x[:, i])
        length = float(np.linalg.norm(change))
        like = set(TWINS.get(u.name, ())) & {v.effect for v in c.fitter.variants}
        for s in signatures:
            if s.variant.effect == u.name or not np.isfinite(s.columns).all() or not length:
                continue
            left = _without(_without(offsets, fit.whitener(s.columns)), change)
            if float(np.linalg.norm(left)) < min(_LIMITS.alike, 0.5 * length):
                like.add(s.variant.effect)
        yield {"number": u.name, "by_sigma": float(sigma), "could_be": sorted(like)}


def _without(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values less what the columns can follow of them."""
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])
