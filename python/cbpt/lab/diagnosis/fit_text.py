"""What a fit found, in words: parameters that it changed, and effects with several solutions.

moved_by         how far the fit changed a number of the drive or the instruments
moved_numbers    all numbers that changed by more than their standard uncertainty
prior_of         the stated uncertainty of a number
Several          an effect that fits about as well with other values or in another form
solutions        the effects of a fit of which that holds
parameter_words  a parameter of an effect: its name with the unit, and its value
beyond_own_loops a play at odds with the table's own smaller loops
at_limits        numbers of drive and rig that end at a limit of their range
beyond_likely    sizes of effects that are larger than such drives have
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_loops import CENTRE, PLAY, small_loops_of
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.wording.names import number_called
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit, in_words, rounded, shown
from cbpt.results import ARCSEC_PER_RAD

_SHOWN_SOLUTIONS = 3


def moved_by(number: str, fit: Fit) -> str:
    """How far a fit has moved a number of drive or rig: `-37.6 %`."""
    u = next(u for u in fit.unknowns if u.name == number)
    off = fit.value(u) - u.mean
    return f"{100 * off:+.1f} %" if number != "contact_angle" else f"{np.rad2deg(off):+.2f} deg"


def moved_numbers(fit: Fit, campaign: Campaign) -> str:
    """Numbers that a fit moved by more than one of their standard uncertainties."""
    parts = []
    for u in fit.unknowns:
        if u.name in campaign.priors and np.isfinite(u.sd) and abs(fit.value(u) - u.mean) > u.sd:
            sigma = (fit.value(u) - u.mean) / u.sd
            name = number_called(u.name, campaign.drive.kind)
            parts.append(f"{name} {moved_by(u.name, fit)} ({sigma:+.1f} standard uncertainties)")
    return ", ".join(parts)


def prior_of(number: str, prior: float) -> str:
    """The stated uncertainty of a number of drive or rig: `10 %`."""
    return f"{np.rad2deg(prior):.2g} deg" if number == "contact_angle" else f"{100 * prior:.2g} %"


def parameter_words(
    campaign: Campaign, number: tuple[str, str], p: Mapping[str, Any], angle: AngleUnit = ARCSEC
) -> tuple[str, str]:
    """Name and value of a parameter as people read it; that of an own effect in the unit in which
    it was stated. number: effect and name. p: value and uncertainty in SI."""
    own = campaign.own.get(number[0])
    unit = own.stated_units.get(number[1], "") if own else p["unit"]
    return in_words(number, p["value"], p["u"], unit, angle)


@dataclass(frozen=True)
class Several:
    """An effect with several solutions, which the readings cannot distinguish."""

    effect: str
    solutions: tuple[str, ...]
    """Form and parameters of each, in words, the best first."""

    def __str__(self) -> str:
        more = len(self.solutions) - _SHOWN_SOLUTIONS
        text = "; or ".join(self.solutions[:_SHOWN_SOLUTIONS])
        rest = f", and {more} more" if more > 0 else ""
        return (
            f"{self.effect} has {len(self.solutions)} solutions that these readings cannot "
            f"distinguish (odds within 20 : 1): {text}{rest}. No uncertainty is given for its "
            "parameters"
        )


def solutions(fit: Fit) -> Iterator[Several]:
    """Effects that fit about as well with other values or in another form."""
    for effect in fit.hypothesis.effects if fit.other_modes else ():
        found: dict[str, str] = {}
        for mode in (fit, *fit.other_modes):
            told = _solution(mode, effect)
            # What differs in its uncertainty alone is one solution.
            found.setdefault(re.sub(r" \+- \S+\b", "", told), told)
        if len(found) > 1:
            yield Several(effect, tuple(found.values()))


def _solution(fit: Fit, effect: str) -> str:
    variant = next(v for v in fit.hypothesis.variants if v.effect == effect)
    sizes = [f"{effect}.{name}" for name in variant.sizes]
    values = [
        shown((effect, name), fit.value(u), fit.u(u) if fit.u(u) < u.upper - u.lower else None)
        for name, full in zip(variant.sizes, sizes, strict=True)
        for u in fit.unknowns
        if u.name == full
    ]
    return f"{variant.name + ', ' if variant.name else ''}{', '.join(values)}"


def beyond_own_loops(campaign: Campaign, fit: Fit) -> Iterator[str]:
    """What to say where the fitted play is at odds with the table's own smaller loops."""
    play = next((u for u in fit.unknowns if u.name == PLAY), None)
    loops = small_loops_of(campaign)
    centre = PLAY.replace("play_rad", CENTRE)
    if play is None or loops is None or any(u.name == centre for u in fit.unknowns):
        return
    value = fit.value(play) * ARCSEC_PER_RAD
    turned = (
        f"the loops to +-{loops.amplitude_Nm:.3g} N m turn by {rounded(loops.turn_arcsec)} arcsec"
    )
    if loops.held and value > loops.turn_arcsec:
        yield (
            f"the fitted play of {rounded(value)} arcsec is more than the small loops show: "
            f"{turned}; there friction may hold it, so it rests on the larger loops alone"
        )
    elif value >= (1 - 1e-6) * play.upper and value >= (1 - 1e-6) * loops.allowed_arcsec:
        yield (
            f"{turned}, and their flanks lie at most {rounded(loops.allowed_arcsec)} arcsec apart, "
            "so no play is larger than that: the fit is held there, and what else these readings "
            "show near zero torque is no play"
        )


def at_limits(campaign: Campaign, fit: Fit) -> Iterator[str]:
    """What to say of numbers of drive and rig that a fit would move further than it may."""
    for u in fit.unknowns:
        value, near = fit.value(u), 1e-6 * (u.upper - u.lower)
        if u.name in PRIORS and not u.lower + near < value < u.upper - near:
            name = number_called(u.name, campaign.drive.kind)
            yield (
                f"{name} ends at the limit of its range ({moved_by(u.name, fit)}): effects make up "
                "for what is left. Correct it in the case first"
            )


def beyond_likely(fit: Fit) -> Iterator[str]:
    """What to say of sizes of effects that lie outside what is plausible, their u considered."""
    for variant in fit.hypothesis.variants:
        if variant.spread or variant.effect in PRIORS:
            continue
        ratios = variant.ratios or (1.0,) * len(variant.sizes)
        for name, ratio in zip(variant.sizes, ratios, strict=True):
            number, most = (variant.effect, name), variant.high * ratio
            u = next(u for u in fit.unknowns if u.name == ".".join(number))
            if abs(fit.value(u) - u.mean) > most + 2 * fit.u(u):
                yield (
                    f"{variant.effect}: {shown(number, fit.value(u), fit.u(u))} is more than is "
                    f"likely ({in_words(number, u.mean + most, None)[1]} at most): a part of it "
                    "may come from another effect"
                )
