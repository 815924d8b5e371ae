"""The answer as one sentence, the way an engineer would write it into a report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.fit_text import moved_by, solutions
from cbpt.lab.diagnosis.noise_statement import noise_floor
from cbpt.lab.wording.names import called, columns_in_words
from cbpt.lab.wording.numbers import in_words, listed

_NOISE = {
    "run_offset": "an offset that differs from run to run",
    "correlated": "noise that is correlated between successive readings",
    "heavy_tailed": "noise with heavy tails",
    "outliers": "a few outliers",
    "misstated": "a misstated uncertainty",
}


@dataclass(frozen=True)
class Say:
    """How numbers that were found are written; without arguments as in a case file."""

    number: Callable[[str, str], str] = "{} {}".format
    """From its name and its value with the uncertainty: `exponent 0.914 +- 0.017`."""
    aside: Callable[[str], str] = "({})".format
    """All numbers of one effect."""


_PLAINLY = Say()


def name_of(d: DiagnosisData, effect: str) -> str:
    """What an effect is called, of the reducer that this is about."""
    return called(effect, d.competition.campaign.drive.kind)


def sentence(d: DiagnosisData, say: Say = _PLAINLY) -> str:
    """One or two sentences that say what is certain, what is open and how sure that is."""
    v = d.verdict
    sure = f"probability {v.probability:.2f}"
    if v.probability < 0.5:
        sure = f"the most probable answer, but uncertain: {sure}"
    before, after = d.ladder[0].rmse_arcsec, d.final_rung.rmse_arcsec
    floor = noise_floor(d)[0]
    noise = "" if floor is None else f" (noise {floor:.2f})"
    fall = f"the error falls from {before:.2f} to {after:.2f} arcsec{noise}"
    if after > 0.97 * before:
        fall = f"the error stays at {after:.2f} arcsec"
    if v.kind == "unknown":
        return _unknown(d, sure, say)
    if v.kind == "complete":
        return _complete(d, sure, fall, say)
    if v.kind == "rig" and set(v.effects) <= {"run_offset"}:
        what = listed([_noise(d, n) for n in v.noise if n in _NOISE])
        return f"No effect is missing from the model: the readings show {what} ({sure})."
    if v.kind == "ambiguous":
        return _ambiguous(d, sure, fall)
    what = listed([_with_value(d, e, say) for e in v.effects])
    kinds = {
        "parameter": "A parameter of the drive differs from the case",
        "rig": "The measurement has an error",
    }
    return f"{kinds.get(v.kind, 'Missing from the model')}: {what} ({sure}); {fall}."


def _noise(d: DiagnosisData, word: str) -> str:
    """A kind of noise with its size."""
    c, noise = d.competition.campaign, d.after.noise
    if word == "run_offset":
        return f"{_NOISE[word]} (standard deviation {noise.offset_arcsec:.2g} arcsec)"
    if word == "misstated":
        u = float(np.median(c.u_arcsec))
        return f"{_NOISE[word]} (stated {u / c.u_believed:.2g}, found {u * noise.scale:.2g} arcsec)"
    if word == "correlated":
        return f"{_NOISE[word]} ({noise.correlation:.2f})"
    return _NOISE[word]


def _unknown(d: DiagnosisData, sure: str, say: Say) -> str:
    columns = d.verdict.lack_of_fit.columns if d.verdict.lack_of_fit else ()
    on = columns_in_words(columns)
    return (
        f"An effect is missing that is not in the library ({sure}): the misfit depends on {on}."
        + _beside(d, say)
    )


def _beside(d: DiagnosisData, say: Say) -> str:
    """What has a name beside a lack of fit that has none; of a reducer that is most of its loop."""
    named = d.verdict.names
    if not named or d.competition.campaign.drive.kind != "torsion_spring":
        return ""
    what = listed([_with_value(d, e, say) for e in named])
    return (
        f" In addition there is {what}: the error falls from {d.ladder[0].rmse_arcsec:.3g} to "
        f"{d.final_rung.rmse_arcsec:.3g} arcsec."
    )


def _complete(d: DiagnosisData, sure: str, fall: str, say: Say) -> str:
    v = d.verdict
    if not v.within_uncertainty:
        return (
            f"No effect is missing ({sure}): the model as stated explains the readings to within "
            f"their noise of {noise_floor(d)[0]:.2f} arcsec."
        )
    null = d.competition.fits[()]
    far = [r.number for r in v.rests_on if abs(r.needed_shift_sigma) > 0.8]
    off = [say.number(number, moved_by(number, null)) for number in far]
    which = f" {say.aside(listed(off))}" if off else ""
    return (
        f"No effect is missing ({sure}): with the parameters of the drive changed within their "
        f"stated uncertainty{which}, {fall}."
    )


def _ambiguous(d: DiagnosisData, sure: str, fall: str) -> str:
    v = d.verdict
    parts = []
    if v.effects:
        parts.append(f"{listed([name_of(d, e) for e in v.effects])} is certain")
    for group in v.rivals:
        names = listed([name_of(d, e) for e in group], "or")
        parts.append(f"one of {names} is needed, but these readings cannot distinguish them")
    text = "; ".join(parts)
    return f"{text[:1].upper()}{text[1:]} ({sure}); {fall}."


def _with_value(d: DiagnosisData, effect: str, say: Say) -> str:
    """An effect with the numbers that were found for it."""
    name = name_of(d, effect)
    found = d.parameters(d.after, effect)
    if not found:
        if effect not in {u.name for u in d.after.unknowns}:
            return name
        return f"{name} {say.aside(say.number(effect, moved_by(effect, d.after)))}"
    words = (in_words(effect, n, p["value"], p["u"], p["unit"]) for n, p in found.items())
    values = [say.number(*number) for number in words]
    if any(several.effect == effect for several in solutions(d.after)):
        values.append("or another solution, see the notes")
    return f"{name} {say.aside(', '.join(values))}"
