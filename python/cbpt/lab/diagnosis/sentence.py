"""The answer as one sentence, the way an engineer would write it into a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cbpt._core import Drive
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.fit_text import moved_by, parameter_words, solutions
from cbpt.lab.diagnosis.noise_statement import estimated, noise_floor
from cbpt.lab.selection.adequacy import readings_of_the_curve, readings_that_could_show
from cbpt.lab.selection.decision import Why
from cbpt.lab.selection.posterior import posterior_of
from cbpt.lab.selection.rest import remains_arcsec
from cbpt.lab.selection.rules import RULES
from cbpt.lab.wording.names import called, columns_in_words, number_called
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit, listed, percent, probability, rounded

_NOISE = {
    "run_offset": "an offset that differs from run to run",
    "correlated": "noise that is correlated between successive readings",
    "heavy_tailed": "noise with heavy tails",
    "torque_noise": "scatter of the torque readings",
    "random_walk": "a zero that drifts or wanders",
    "first_reading": "a first reading of each run that is off",
    "encoder": "an error of the angle sensor with a period of the angle",
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
    angle: AngleUnit = ARCSEC


_PLAINLY = Say()
_MOST_LIKELY = 4
_FAR_SIGMA = 5.0
"""Stated standard uncertainties: a number moved further is more likely a slip than a finding."""


def name_of(d: DiagnosisData, effect: str) -> str:
    """What an effect is called, of the reducer that this is about."""
    return called(effect, d.competition.campaign.drive.kind)


def sentence(d: DiagnosisData, say: Say = _PLAINLY) -> str:
    """What is certain, what is open, how sure that is, and what to check first."""
    return _answer(d, say) + _scatter(d, say.angle) + _to_check(d)


def _scatter(d: DiagnosisData, angle: AngleUnit) -> str:
    """That readings scatter unlike what is stated of them, where the noise of the answer says so
    and nothing else has told it. What has no name can be a part of what is left."""
    stated, v = d.readings.u_elastic_angle_arcsec, d.verdict
    told = v.undecided or v.lack_of_fit is not None or _of_noise_alone(d)
    if stated is None or "misstated" not in v.noise or told:
        return ""
    u, found = float(np.sqrt(np.mean(stated**2))), estimated(d)
    return (
        f" The readings scatter about this answer {rounded(found / u, 2)} times as much as is "
        f"stated (stated {angle.number(u)}, found {angle.text(found)})."
    )


def _of_noise_alone(d: DiagnosisData) -> bool:
    """Whether the answer is how the readings scatter."""
    return d.verdict.kind == "rig" and set(d.verdict.effects) <= {"run_offset"}


def _to_check(d: DiagnosisData) -> str:
    """What to look at before the answer is believed: numbers far from what is stated of them."""
    campaign = d.competition.campaign
    priors, drive = campaign.priors, campaign.drive
    far = [
        number_called(u.name.partition(".")[0], drive.kind)
        for u in d.after.unknowns
        if (sd := priors.get(u.name.partition(".")[0]))
        and abs(d.after.value(u) - u.mean) > _FAR_SIGMA * sd
    ]
    if not far:
        return ""
    case = "check that the case file is that of this drive"
    if drive.kind == "ball_drive":
        case += f", and that the torque is that of the output (the ratio is {_ratio(drive):g})"
    were = "was" if len(far) == 1 else "were"
    return (
        f" {listed(far)[:1].upper()}{listed(far)[1:]} {were} moved by more than {_FAR_SIGMA:g} "
        f"stated standard uncertainties: first {case}."
    )


def _ratio(drive: Drive) -> float:
    return float(drive.transmission_ratio)


def _answer(d: DiagnosisData, say: Say) -> str:
    """What was found."""
    v = d.verdict
    sure = f"probability {probability(v.probability)}"
    if v.probability < 0.5:
        sure = f"the most probable answer, but uncertain: {sure}"
    if v.undecided:
        return _undecided(d)
    if v.kind == "unknown":
        return _unknown(d, sure, say) + _besides(d)
    if v.kind == "complete":
        return _complete(d, sure, say) + _besides(d)
    if _of_noise_alone(d):
        what = listed([_noise(d, n, say.angle) for n in v.noise if n in _NOISE])
        said = f"No effect is missing from the model: the readings show {what} ({sure})."
        return said + _besides(d)
    fall = f"{_also(d)}; {_with(d)}{_fall(d, say.angle)}"
    if v.kind == "ambiguous":
        return _ambiguous(d, sure, fall, say.angle)
    what = listed([_with_value(d, e, say) for e in v.effects])
    kinds = {
        "parameter": "A parameter of the drive differs from the case",
        "rig": "The measurement has an error",
    }
    rest = _rest(d, say.angle)
    return f"{kinds.get(v.kind, 'Missing from the model')}: {what} ({sure}){fall}.{rest}"


def _fall(d: DiagnosisData, angle: AngleUnit) -> str:
    """What the error does from the model as stated to that of the answer."""
    before, after = d.ladder[0].rmse_arcsec, d.final_rung.rmse_arcsec
    if after > 0.97 * before:
        return f"the error stays at {angle.text(after)}"
    floor = noise_floor(d)[0]
    noise = "" if floor is None else f" (noise {angle.number(floor)})"
    return f"the error falls from {angle.number(before)} to {angle.text(after)}{noise}"


def likely(d: DiagnosisData) -> str:
    """What is likely but not certain, the most probable first, with probabilities."""
    v = d.verdict
    # What remains without a name is told already where that is the answer.
    found = [(e, p) for e, p in v.perhaps if not (v.kind == "unknown" and e == "unknown")]
    return _with_chances(d, found[:_MOST_LIKELY])


def _with_chances(d: DiagnosisData, found: Sequence[tuple[str, float]]) -> str:
    """Effects with their probabilities; beside an answer the most probable ones are those that do
    not predict."""
    but = "" if d.verdict.undecided else ", but readings held back are predicted better without it"
    told = [
        f"{name_of(d, e)} ({probability(p)}{but if p >= RULES.certain else ''})" for e, p in found
    ]
    exclude = sum(p for _, p in found) <= 1 and (
        posterior_of(d.competition).of_several([e for e, _ in found]) < RULES.likely
    )
    return listed(told, "or" if exclude else "and")


def _also(d: DiagnosisData) -> str:
    return f"; perhaps also {said}" if (said := likely(d)) else ""


def _besides(d: DiagnosisData) -> str:
    return f" Possible all the same: {said}." if (said := likely(d)) else ""


def _with(d: DiagnosisData) -> str:
    """What the most probable combination has beside what is certain: its error is told."""
    v = d.verdict
    more = [e for e in v.names if e not in v.effects]
    return f"with {listed([name_of(d, e) for e in more])} " if more else ""


_WHY: dict[Why, str] = {
    "no answer is probable": "neither one effect nor one of a group of them is certain, and that "
    "nothing is missing is not certain either",
    "few readings": "there are too few readings for the parameters that would have to be fitted",
    "scatter or law": "the misfit could be scatter or a missing effect: the readings deviate "
    "from the model by more than the stated uncertainty, and no reading was repeated",
    "scatter unknown": "what is left could be noise or a missing effect: neither a stated "
    "uncertainty, nor repeats, nor how neighbouring readings differ tell what is noise",
    "uneven misfit": "the misfit could be noise or a missing effect: it is larger at some torques "
    "or in some runs than elsewhere, and nearly the same from one reading to the next there",
    "no prediction": "what explains the readings does not predict those that are kept back",
    "input side": "the angle changes with the torque many times more than in the model, about as "
    "often as the transmission ratio says",
}
_REMEDY: dict[Why, str] = {
    "no answer is probable": "Measure more, with other preloads, torques and angles",
    "few readings": "Take three readings or more for each parameter",
    "scatter or law": "Repeat a run at the same torques, or some readings under the same "
    "conditions; or take them closer together along a run, if they are far apart",
    "scatter unknown": "Repeat a run at the same torques, or state the standard uncertainty "
    "of the angles (u_elastic_angle) if you know it",
    "uneven misfit": "Repeat runs in which it is large: noise differs from run to run, an effect "
    "comes again",
    "no prediction": "Measure more preloads and runs, and check the instruments",
    "input side": "Is the torque that of the input side? Then multiply it by the ratio. If not, "
    "check the stiffness in the case",
}


def _undecided(d: DiagnosisData) -> str:
    """Why nothing can be said, what is likely, what would change that."""
    v = d.verdict
    assert v.undecided is not None
    which = ""
    if v.perhaps and v.undecided == "no answer is probable":
        sure = [(e, p) for e, p in v.perhaps if p >= RULES.certain]
        beside = f"Beside {_with_chances(d, sure)} these are possible" if sure else "Possible"
        open_ = _with_chances(d, v.perhaps[len(sure) :][:_MOST_LIKELY])
        which = f" {beside}, with their probabilities: {open_}." if open_ else ""
    elif v.perhaps:
        are = "is" if len(v.perhaps) == 1 else "are"
        which = f" If an effect is missing, the most probable {are} {likely(d)}."
    which += _in_its_place(d)
    why, remedy, campaign = _WHY[v.undecided], _REMEDY[v.undecided], d.competition.campaign
    different = readings_of_the_curve(campaign)
    if v.undecided == "few readings" and different < len(campaign):
        why += (
            f" (a coarse display: {different} different angles, in steps of "
            f"{campaign.step_arcsec:g} arcsec, which tell as much as "
            f"{readings_that_could_show(campaign):.2g} readings of the stated uncertainty)"
        )
        remedy = "Record the angle in finer steps: more readings in these tell no more"
    return f"These readings do not decide what is missing: {why}.{which} {remedy}."


def _in_its_place(d: DiagnosisData) -> str:
    """What an instrument would have done where no effect is missing; an artefact is no effect, and
    has no place among those that are possible."""
    artefact = d.competition.fits[()].noise.artefact
    if artefact is None or artefact.is_known:
        return ""
    return f" Or nothing is missing, and the instrument shows {_NOISE[artefact.kind]}."


def _rest(d: DiagnosisData, angle: AngleUnit) -> str:
    """What is left beside the effects that have a name."""
    lack = d.verdict.lack_of_fit
    if lack is None:
        return ""
    left = remains_arcsec(lack, d.verdict.adequacy)
    before, after = d.residual_before_arcsec, d.residual_after_arcsec
    share = 1 - float(np.mean(after**2) / np.mean(before**2))
    explained = f" What is named explains {percent(share)} of the misfit." if share > 0 else ""
    return (
        f"{explained} A misfit of {angle.text(left)} remains that no effect of the library "
        f"explains; it depends on {columns_in_words(lack.columns)}."
    )


def _noise(d: DiagnosisData, word: str, angle: AngleUnit) -> str:
    """A kind of noise with its size."""
    c, noise = d.competition.campaign, d.after.noise
    if word == "run_offset":
        return f"{_NOISE[word]} (standard deviation {angle.text(noise.offset_arcsec)})"
    if word == "misstated":
        u = float(np.median(c.u_arcsec))
        seen = u * noise.scale
        if c.step_arcsec and d.verdict.adequacy is not None:
            seen = u * d.verdict.adequacy.left_arcsec / float(np.sqrt(np.mean(c.u_arcsec**2)))
        stated, found = angle.number(u / c.u_believed), angle.text(seen)
        return f"{_NOISE[word]} (stated {stated}, found {found})"
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
    v = d.verdict
    if not v.names or d.competition.campaign.drive.kind != "torsion_spring":
        return ""
    sure = [_with_value(d, e, say) for e in v.names if e in v.effects]
    open_ = [_with_value(d, e, say) for e in v.names if e not in v.effects]
    parts = []
    if sure:
        parts.append(f" In addition there is {listed(sure)}")
    if open_:
        it = "it is" if len(open_) == 1 else "they are"
        begin = "; beside it" if sure else " Beside it"
        parts.append(f"{begin} {listed(open_)} would fit best, but {it} not certain")
    return (
        f"{''.join(parts)}: the error falls from "
        f"{say.angle.number(d.ladder[0].rmse_arcsec)} to "
        f"{say.angle.text(d.final_rung.rmse_arcsec)}."
    )


def _complete(d: DiagnosisData, sure: str, say: Say) -> str:
    v = d.verdict
    if not v.within_uncertainty:
        return (
            f"No effect is missing ({sure}): the model as stated explains the readings to within "
            f"their noise of {say.angle.text(noise_floor(d)[0] or 0.0)}."
        )
    null = d.competition.fits[()]
    far = [r.number for r in v.rests_on if abs(r.needed_shift_sigma) > 0.8]
    off = [say.number(number, moved_by(number, null)) for number in far]
    which = f" {say.aside(listed(off))}" if off else ""
    return (
        f"No effect is missing ({sure}): with the parameters of the drive changed within their "
        f"stated uncertainty{which}, {_fall(d, say.angle)}."
    )


def _ambiguous(d: DiagnosisData, sure: str, fall: str, angle: AngleUnit) -> str:
    v = d.verdict
    if v.within_uncertainty and v.lack_of_fit is None:
        kind = d.competition.campaign.drive.kind
        names = listed([number_called(n, kind) for group in v.rivals for n in group], "or")
        return (
            f"No effect need be missing: {names} differs from its stated value, within the stated "
            f"uncertainty, but these readings cannot tell which ({sure}){fall}."
        )
    parts = []
    if v.effects:
        are = "is" if len(v.effects) == 1 else "are"
        parts.append(f"{listed([name_of(d, e) for e in v.effects])} {are} certain")
    for group in v.rivals:
        names = listed([name_of(d, e) for e in group], "or")
        parts.append(f"one of {names} is needed, but these readings cannot distinguish them")
    text = "; ".join(parts)
    return f"{text[:1].upper()}{text[1:]} ({sure}){fall}.{_rest(d, angle)}"


def _with_value(d: DiagnosisData, effect: str, say: Say) -> str:
    """An effect with the numbers that were found for it."""
    name = name_of(d, effect)
    found = d.parameters(d.after, effect)
    if not found:
        if effect not in {u.name for u in d.after.unknowns}:
            return name
        return f"{name} {say.aside(say.number(effect, moved_by(effect, d.after)))}".rstrip()
    c = d.competition.campaign
    words = (parameter_words(c, (effect, n), p, say.angle) for n, p in found.items())
    values = [say.number(*number) for number in words]
    if any(several.effect == effect for several in solutions(d.after)):
        values.append("or another solution, see the notes")
    return f"{name} {say.aside(', '.join(values))}".rstrip()
