"""The answer as one sentence, the way an engineer would write it into a report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from cbpt.lab.wording.names import called, columns_in_words
from cbpt.lab.wording.numbers import listed, shown

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis
    from cbpt.lab.inference.evidence import Fit

_NOISE = {
    "run_offset": "a zero of its own in every run",
    "correlated": "noise that is correlated from one reading to the next",
    "heavy_tailed": "noise with heavy tails",
    "outliers": "a few outliers",
    "misstated": "an uncertainty that is misstated",
}


def name_of(d: Diagnosis, effect: str) -> str:
    """What an effect is called, of the reducer that this is about."""
    return called(effect, d.competition.campaign.drive.kind)


def sentence(d: Diagnosis) -> str:
    """One or two sentences that say what is certain, what is open and how sure that is."""
    v = d.verdict
    sure = f"probability {v.probability:.2f}"
    if v.probability < 0.5:
        sure = f"the likeliest answer, but not a sure one: {sure}"
    before, after = d.ladder[0].rmse_arcsec, d.final_rung.rmse_arcsec
    floor = d.noise_floor_arcsec
    noise = "" if floor is None else f" (noise {floor:.2f})"
    fall = f"the error falls from {before:.2f} to {after:.2f} arcsec{noise}"
    if after > 0.97 * before:
        fall = f"the error stays at {after:.2f} arcsec"
    if v.kind == "unknown":
        return _unknown(d, sure)
    if v.kind == "complete":
        return _complete(d, sure, fall)
    if v.kind == "rig" and set(v.effects) <= {"run_offset"}:
        what = listed([_noise(d, n) for n in v.noise if n in _NOISE])
        return f"Nothing is missing in the model; the readings show {what} ({sure})."
    if v.kind == "ambiguous":
        return _ambiguous(d, sure, fall)
    what = listed([_with_value(d, e) for e in v.effects])
    kinds = {"parameter": "A number of the drive is off", "rig": "The instrument is off"}
    return f"{kinds.get(v.kind, 'Missing from the model')}: {what} ({sure}); {fall}."


def _noise(d: Diagnosis, word: str) -> str:
    """A kind of noise with its size."""
    c, noise = d.competition.campaign, d.after.noise
    if word == "run_offset":
        return f"{_NOISE[word]} (spread {noise.offset_arcsec:.2g} arcsec)"
    if word == "misstated":
        u = float(np.median(c.u_arcsec))
        return f"{_NOISE[word]} (stated {u / c.u_believed:.2g}, found {u * noise.scale:.2g} arcsec)"
    if word == "correlated":
        return f"{_NOISE[word]} ({noise.correlation:.2f})"
    return _NOISE[word]


def _unknown(d: Diagnosis, sure: str) -> str:
    columns = d.verdict.pattern.columns if d.verdict.pattern else ()
    on = columns_in_words(columns)
    return (
        f"Something real is missing that no effect of the library explains ({sure}): the misfit "
        f"depends on {on}." + _beside(d)
    )


def _beside(d: Diagnosis) -> str:
    """What has a name beside a pattern that has none; of a reducer that is most of its loop."""
    named = d.verdict.names
    if not named or d.competition.campaign.drive.kind != "torsion_spring":
        return ""
    what = listed([_with_value(d, e) for e in named])
    return (
        f" Beside it there is {what}: the error falls from {d.ladder[0].rmse_arcsec:.3g} to "
        f"{d.final_rung.rmse_arcsec:.3g} arcsec."
    )


def _complete(d: Diagnosis, sure: str, fall: str) -> str:
    v = d.verdict
    if not v.within_uncertainty:
        return (
            f"Nothing is missing ({sure}): the model as stated explains the readings to within "
            f"their noise of {d.noise_floor_arcsec:.2f} arcsec."
        )
    null = d.competition.fits[()]
    off = [moved(r.number, null) for r in v.rests_on if abs(r.needed_shift_sigma) > 0.8]
    which = f" ({listed(off)})" if off else ""
    return (
        f"Nothing is missing ({sure}): with the numbers of the drive moved within their stated "
        f"uncertainty{which}, {fall}."
    )


def _ambiguous(d: Diagnosis, sure: str, fall: str) -> str:
    v = d.verdict
    parts = []
    if v.effects:
        parts.append(f"{listed([name_of(d, e) for e in v.effects])} is certain")
    for group in v.rivals:
        names = listed([name_of(d, e) for e in group], "or")
        parts.append(f"one of {names} is needed, and these readings cannot say which")
    text = "; ".join(parts)
    return f"{text[:1].upper()}{text[1:]} ({sure}); {fall}."


def moved(number: str, fit: Fit) -> str:
    """How far a fit has moved a number of drive or rig: `contact_stiffness -37.6 %`."""
    u = next(u for u in fit.unknowns if u.name == number)
    off = fit.value(u) - u.mean
    by = f"{100 * off:+.1f} %" if number != "contact_angle" else f"{np.rad2deg(off):+.2f} deg"
    return f"{number} {by}"


def moved_numbers(fit: Fit, priors: Mapping[str, float]) -> str:
    """Numbers that a fit moved by more than one of their standard uncertainties."""
    parts = []
    for u in fit.unknowns:
        if u.name in priors and np.isfinite(u.sd) and abs(fit.value(u) - u.mean) > u.sd:
            sigma = (fit.value(u) - u.mean) / u.sd
            parts.append(f"{moved(u.name, fit)} ({sigma:+.1f} standard uncertainties)")
    return ", ".join(parts)


def _with_value(d: Diagnosis, effect: str) -> str:
    """An effect with the numbers that were found for it."""
    name = name_of(d, effect)
    found = d.parameters(d.after, effect)
    if not found:
        strained = {u.name: u for u in d.after.unknowns if u.name == effect}
        return f"{name} ({moved(effect, d.after)})" if strained else name
    values = [shown(effect, n, p["value"], p["u"], p["unit"]) for n, p in found.items()]
    if any(note.startswith(f"{effect} has") for note in solutions(d.after)):
        values.append("or another solution, see the notes")
    return f"{name} ({', '.join(values)})"


_TOLD_SOLUTIONS = 3


def solutions(fit: Fit) -> Iterator[str]:
    """Of each effect that fits about as well with other values or in another form: which."""
    for effect in fit.hypothesis.effects if fit.others else ():
        said = list(dict.fromkeys(_solution(f, effect) for f in (fit, *fit.others)))
        if len(said) > 1:
            more = len(said) - _TOLD_SOLUTIONS
            told = "; or ".join(said[:_TOLD_SOLUTIONS]) + (f", and {more} more" if more > 0 else "")
            yield (
                f"{effect} has {len(said)} solutions that these readings cannot tell apart (odds "
                f"within 20 : 1): {told}; so its numbers have no uncertainty"
            )


def _solution(fit: Fit, effect: str) -> str:
    variant = next(v for v in fit.hypothesis.variants if v.effect == effect)
    sizes = [f"{effect}.{name}" for name in variant.sizes]
    values = [
        shown(effect, name, fit.value(u), fit.u(u) if fit.u(u) < u.upper - u.lower else None)
        for name, full in zip(variant.sizes, sizes, strict=True)
        for u in fit.unknowns
        if u.name == full
    ]
    return f"{variant.name + ', ' if variant.name else ''}{', '.join(values)}"
