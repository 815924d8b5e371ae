"""From odds to words: what is certain, what is open, what kind of answer that is.

    Verdict     kind, certain effects, rival groups, probability, what it rests on
    judge       the rules, in the order in which they apply

1. The posterior over sets of effects says what is certain, which groups hold one that is needed,
   and what is likely (`posterior`).
2. Nothing is demanded: `complete`, `rig` where noise or a gain is what is off, `parameter` where a
   parameter of the drive has to move by more than two standard uncertainties, `ambiguous` where the
   calibrations are stated so loosely that drive and instrument explain the same shift.
3. Effects are demanded: `effect`, `rig` or `parameter` by what they are, `ambiguous` where some are
   rivals, `unknown` where only a lack of fit is certain.
4. What was found is checked (`adequacy`): too few readings for its free numbers, or a misfit that
   may as well be scatter, leave the question open: `undecided`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from cbpt.lab.covariance.fit_noise import LEAST_SCALE
from cbpt.lab.covariance.linear_gaussian import Margin, Noise
from cbpt.lab.inference.cross_validation import folds, log_score
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.dataset import DEFAULT_UNCERTAINTY
from cbpt.lab.model.priors import CLASSES, PRIORS, TWINS
from cbpt.lab.selection.adequacy import (
    Adequacy,
    adequacy_of,
    departure_chance,
    free_numbers,
    law_left,
    readings_of_the_curve,
    readings_that_could_show,
    scatter_shown,
)
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.lack_of_fit import LackOfFit
from cbpt.lab.selection.posterior import (
    OFFSET,
    UNKNOWN,
    Posterior,
    Spoken,
    named_of,
    posterior_of,
    spoken_of,
)
from cbpt.lab.selection.rest import beside_rest, rest_arcsec
from cbpt.lab.selection.rules import RULES, DecisionRules
from cbpt.lab.selection.setting import Names
from cbpt.lab.selection.uneven_noise import may_be_local_law

_TOLD_SIGMA = 0.3
"""Standard uncertainties: smaller shifts are not listed among what an answer rests on."""
Why = Literal[
    "no answer is probable",
    "few readings",
    "scatter or law",
    "scatter unknown",
    "uneven misfit",
    "no prediction",
    "input side",
]
"""Why nothing can be said: no answer has a probability of one half; fewer than about three readings
for each free number; scatter and a law that is missing cannot be told apart, by their size alone,
because nothing tells what is noise, or because what is left is larger in places and smooth there;
what explains the readings does not predict those that are kept back; torques may be those of the
input side."""


@dataclass(frozen=True)
class Rest:
    """A number from outside the readings that the answer rests on."""

    number: str
    prior: float
    """Its stated standard uncertainty."""
    needed_shift_sigma: float
    """How far it would have to be off to explain the readings in place of what is named."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """The answer in short."""

    kind: str
    effects: tuple[str, ...]
    rivals: tuple[tuple[str, ...], ...]
    probability: float
    rests_on: tuple[Rest, ...]
    within_uncertainty: bool
    """`complete`, but only after numbers moved within what is stated of them."""
    names: Names
    """The set of effects that the answer is drawn with."""
    lack_of_fit: LackOfFit | None
    """What is left without a name, where it matters."""
    noise: tuple[str, ...] = field(default=("white",))
    perhaps: tuple[tuple[str, float], ...] = ()
    """Effects that are likely but neither certain nor rivals, with their probability."""
    exactly: float = 1.0
    """Probability that the set the answer is drawn with, and nothing else, is at work;
    `probability` is that of all that is said, whatever else is."""
    inside: float = 1.0
    """Probability that the library holds the cause at all; it is a factor of the two above."""
    beside: Mapping[str, float] = field(default_factory=dict)
    """By effect: probability that it is no part of what is left without a name."""
    undecided: Why | None = None
    """Why nothing can be said."""
    adequacy: Adequacy | None = None
    """What the answer leaves, against what readings scatter by."""

    def of_set(self, names: Iterable[str]) -> float:
        """Probability that the library holds the cause and that none of these imitates what has no
        name: a factor of the probability of their set."""
        return min([self.inside, *(self.beside.get(name, 1.0) for name in names)])


def judge(competition: Competition, rules: DecisionRules = RULES) -> Verdict:
    """The verdict on a competition, by the rules above."""
    posterior = posterior_of(competition)
    spoken = spoken_of(posterior, rules)
    said = {*spoken.effects, *(e for g in spoken.rivals for e in g)}
    if said - {OFFSET}:
        verdict = _effects(competition, posterior, spoken, rules)
    elif posterior.within({*PRIORS, OFFSET}) >= rules.undecided:
        verdict = _no_effect(competition, posterior, rules)
        named = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
        # A parameter that moved is named; as an effect it is the same statement again.
        rest = tuple((effect, p) for effect, p in spoken.perhaps if effect not in named)
        verdict = replace(verdict, perhaps=rest)
    else:
        verdict = _undecided(competition, posterior, "no answer is probable", rules)
    return _checked(competition, posterior, verdict, rules)


def withheld(competition: Competition, why: Why) -> Verdict:
    """No verdict, for a reason that the competition does not know."""
    return _undecided(competition, posterior_of(competition), why, RULES)


def _checked(
    competition: Competition, posterior: Posterior, verdict: Verdict, rules: DecisionRules
) -> Verdict:
    """The verdict, unless the readings are too few for it or what it leaves is no noise."""
    if verdict.kind == "undecided":
        return verdict
    fitter, fit = competition.fitter, competition.fits[verdict.names]
    adequacy = adequacy_of(fitter, fit)
    verdict = replace(verdict, adequacy=adequacy)
    if verdict.lack_of_fit is None and adequacy.p_value < rules.left_chance:
        if adequacy.source == "stated":
            return _undecided(competition, posterior, "scatter or law", rules)
        verdict = _with_remains(competition, verdict)
    if verdict.lack_of_fit is None and departure_chance(fit) < rules.left_chance:
        verdict = _with_remains(competition, verdict, exact=True)
    untold = _scatter_untold(competition, verdict)
    verdict = _with_what_comes_again(competition, verdict, rules, untold is not None)
    nothing = not (set(verdict.effects) - {OFFSET} or verdict.rivals or verdict.lack_of_fit)
    # Where runs repeat each other, and what is left does not come again, it is noise.
    if nothing and untold and law_left(fitter, fit, np.inf) is None:
        return _undecided(competition, posterior, untold, rules)
    if (
        nothing
        and adequacy.source != "repeats"
        and may_be_local_law(fitter, fit, rules.left_chance)
    ):
        return _undecided(competition, posterior, "uneven misfit", rules)
    verdict = _beside_rest(competition, verdict, rules)
    if untold == "scatter unknown":
        verdict = _untested(verdict, rules)
    free = free_numbers(fitter, fit)
    if verdict.lack_of_fit is not None:
        free += verdict.lack_of_fit.free_numbers
    readings = float(readings_of_the_curve(competition.campaign))
    if nothing:
        readings = min(readings, readings_that_could_show(competition.campaign))
    if readings < rules.readings_per_number * free:
        return _undecided(competition, posterior, "few readings", rules)
    return verdict


def _scatter_untold(competition: Competition, verdict: Verdict) -> Why | None:
    """Why nothing but the fit tells what is noise; None where something does."""
    source = verdict.adequacy.source if verdict.adequacy else "nothing"
    if source == "nothing" and not competition.campaign.u_stated:
        return "scatter unknown"
    claimed = {"correlated", "misstated"}
    return "scatter or law" if source == "stated" and claimed <= set(verdict.noise) else None


def _with_what_comes_again(
    competition: Competition, verdict: Verdict, rules: DecisionRules, untold: bool
) -> Verdict:
    """The verdict with what is left, where it comes again in repeated runs: beside a name, where
    nothing else tells what is noise (`untold`), or where readings that are far off count for less,
    as if they were loose."""
    named = set(verdict.effects) - {OFFSET} or verdict.rivals
    doubtful = untold or competition.fits[verdict.names].noise.inflation is not None
    if not doubtful and (not named or competition.campaign.repeats):
        return verdict
    law = law_left(competition.fitter, competition.fits[verdict.names], rules.left_chance)
    return verdict if law is None else _with_remains(competition, replace(verdict, adequacy=law))


def _undecided(
    competition: Competition, posterior: Posterior, why: Why, rules: DecisionRules
) -> Verdict:
    """Nothing is said; what would change that goes with the reason."""
    inclusion = posterior.inclusion
    likely = sorted(inclusion, key=lambda e: -inclusion[e])
    return Verdict(
        kind="undecided",
        effects=(),
        rivals=(),
        probability=min(max(posterior.sets.values()), rules.undecided),
        rests_on=(),
        within_uncertainty=False,
        names=(),
        lack_of_fit=None,
        noise=noise_words(competition, competition.fits[()]),
        perhaps=tuple((e, inclusion[e]) for e in likely if inclusion[e] >= rules.likely),
        undecided=why,
        exactly=max(posterior.sets.values()),
    )


def _with_remains(competition: Competition, verdict: Verdict, exact: bool = False) -> Verdict:
    """The verdict with what is left without a name; alone that is the answer. exact: beside effects
    that keep their equations."""
    lack = competition.lack_on(verdict.names, exact)
    if lack is None:
        return verdict
    if verdict.effects or verdict.rivals:
        return replace(verdict, lack_of_fit=lack)
    return replace(verdict, kind="unknown", lack_of_fit=lack, rests_on=())


def _beside_rest(competition: Competition, verdict: Verdict, rules: DecisionRules) -> Verdict:
    """The verdict with less probability where it names a cause and something else remains: what has
    no name may as well be what the cause imitates (`rest`). A cause that is more likely imitated
    than not is no more than possible; without any other the answer is that something is missing."""
    if verdict.lack_of_fit is None or verdict.kind == "unknown":
        return verdict
    rest = rest_arcsec(verdict.lack_of_fit, verdict.adequacy)
    own = beside_rest(competition, verdict.names, rest)
    kept = tuple(e for e in verdict.effects if own.get(e, 1.0) >= rules.undecided)
    rivals = tuple(g for g in verdict.rivals if min(own.get(e, 1.0) for e in g) >= rules.undecided)
    inclusion = posterior_of(competition).inclusion
    open_ = [
        *((e, 1.0) for e in verdict.effects if e not in kept),
        *((e, inclusion.get(e, 0.0)) for g in verdict.rivals if g not in rivals for e in g),
        *verdict.perhaps,
    ]
    possible = [(e, p * own.get(e, 1.0)) for e, p in open_ if e != UNKNOWN]
    likely = sorted((e for e in possible if e[1] >= rules.likely), key=lambda e: -e[1])
    held = replace(verdict, effects=kept, rivals=rivals, perhaps=tuple(likely), beside=own)
    if not (set(kept) - {OFFSET} or rivals):
        held = replace(held, kind="unknown", rests_on=())
    else:
        said = {*kept, *(e for group in rivals for e in group)}
        inside = min([rules.certain, *(p for e, p in own.items() if e in said)])
        probability = inside * verdict.probability
        kind = _kind_of(kept, rivals)
        held = replace(held, kind=kind, inside=inside, probability=probability)
    return replace(held, exactly=held.of_set(verdict.names) * verdict.exactly)


def _untested(verdict: Verdict, rules: DecisionRules) -> Verdict:
    """The verdict with less probability where it names a cause, and nothing but the fit tells what
    the readings scatter by: what it leaves may as well be a law."""
    named = set(verdict.effects) - {OFFSET} or verdict.rivals
    if not named or verdict.lack_of_fit is not None:
        return verdict
    return replace(
        verdict,
        inside=rules.certain,
        probability=rules.certain * verdict.probability,
        exactly=rules.certain * verdict.exactly,
    )


# --- 2 ---


def _no_effect(competition: Competition, posterior: Posterior, rules: DecisionRules) -> Verdict:
    fits, odds = competition.fits, competition.log_odds
    null = fits[()]
    noise = noise_words(competition, null)
    moved = shifts(null)
    inadequate = _nominal_rejected(competition, null, rules)
    rests = _rests(null, moved) if inadequate else ()

    def verdict(
        kind: str,
        effects: tuple[str, ...] = (),
        rivals: tuple[str, ...] = (),
        within_uncertainty: bool = False,
    ) -> Verdict:
        return Verdict(
            kind=kind,
            effects=effects,
            rivals=(rivals,) if rivals else (),
            probability=posterior.demands_at_most({*effects, *rivals, *PRIORS, OFFSET}),
            rests_on=rests,
            within_uncertainty=within_uncertainty,
            names=(),
            lack_of_fit=None,
            noise=noise,
            exactly=posterior.sets[posterior.best],
        )

    strained = {n: z for n, z in moved.items() if abs(z) > rules.moved_sigma}
    if inadequate and strained:
        wide = max(strained, key=lambda n: abs(strained[n]))
        near = max(odds.values()) - rules.log_rival_odds
        named = {n for names, o in odds.items() if len(names) == 1 and o > near for n in names}
        if _at_end(null, wide):
            # Further off than a number of a drive can be: its twin is as likely to blame.
            named |= set(TWINS.get(wide, ()))
        if named - {wide}:
            return verdict("ambiguous", rivals=tuple(sorted(named | {wide})))
        return verdict("rig" if _class_of(wide) == "rig" else "parameter", (wide,))
    if inadequate:
        sharing = _sharing(competition, null, rules)
        loose = [
            n
            for n in sharing
            if _class_of(n) == "rig"
            and competition.campaign.priors[n] >= rules.loose_calibration * DEFAULT_UNCERTAINTY[n]
        ]
        if loose and len(sharing) > 1:
            return verdict("ambiguous", rivals=tuple(sharing), within_uncertainty=True)
    if noise != ("white",):
        effects = (OFFSET,) if OFFSET in noise else ()
        return verdict("rig", effects, within_uncertainty=inadequate)
    return verdict("complete", within_uncertainty=inadequate)


def _at_end(fit: Fit, number: str) -> bool:
    """Whether a number of drive or instrument stands at the end of its range."""
    u = next(u for u in fit.unknowns if u.name == number)
    value = fit.value(u)
    return bool(value <= u.lower * (1 + 1e-6) or value >= u.upper * (1 - 1e-6))


def shifts(fit: Fit) -> dict[str, float]:
    """How far each number of drive and instrument has moved, in standard uncertainties."""
    return {
        u.name: (fit.value(u) - u.mean) / u.sd
        for u in fit.unknowns
        if u.name in PRIORS and np.isfinite(u.sd)
    }


def _nominal_rejected(competition: Competition, null: Fit, rules: DecisionRules) -> bool:
    """Whether the readings demand that numbers move at all: the stated ones against the refit."""
    from scipy.special import chdtrc

    if not shifts(null):
        return False
    nominal = competition.fitter.at_nominal(null)
    gain = max(nominal.margin.chi2 - null.margin.chi2, 0.0)
    return bool(chdtrc(len(shifts(null)), gain) < rules.nominal_chance)


def _sharing(competition: Competition, null: Fit, rules: DecisionRules) -> list[str]:
    """Numbers that could each carry the shift alone, within the limit of odds, none beyond two
    sigma.
    """
    y, x, precision = competition.fitter.linear(null)
    whitener = null.whitener
    numbers = [u.name for u in null.unknowns]
    offsets = list(range(len(numbers), x.shape[1]))
    alone: dict[str, tuple[float, float]] = {}
    for i, name in enumerate(numbers):
        keep = [i, *offsets]
        margin = Margin.of(whitener(y), whitener(x[:, keep]), precision[keep])
        alone[name] = (-0.5 * margin.chi2 + margin.log_volume, float(margin.mode[0]))
    top = max(v for v, _ in alone.values())
    return sorted(
        n
        for n, (v, z) in alone.items()
        if v > top - rules.log_rival_odds and abs(z) <= rules.moved_sigma
    )


# --- 3 ---


def _effects(
    competition: Competition, posterior: Posterior, spoken: Spoken, rules: DecisionRules
) -> Verdict:
    best = posterior.best
    named = named_of(best)
    found = tuple(e for e in spoken.effects if e != UNKNOWN)
    idle = _predict_nothing(competition, named, found, rules)
    certain = tuple(e for e in found if e not in idle)
    if idle and not (certain or spoken.rivals):
        return _undecided(competition, posterior, "no prediction", rules)
    lack = competition.lack_on(named) if UNKNOWN in spoken.effects else None
    fit = competition.fits[named]
    if lack is not None and not (spoken.rivals or set(certain) - {OFFSET}):
        kind, certain = "unknown", ()
    else:
        kind = _kind_of(certain, spoken.rivals)
    return Verdict(
        kind=kind,
        effects=certain,
        rivals=spoken.rivals,
        probability=posterior.of_all((*certain, *([UNKNOWN] if lack else [])), spoken.rivals),
        rests_on=() if kind == "unknown" else _decided_by(competition, named, rules),
        within_uncertainty=False,
        names=named,
        lack_of_fit=lack,
        noise=noise_words(competition, fit, None if lack is None else lack.noise),
        perhaps=(*((e, posterior.inclusion[e]) for e in idle), *spoken.perhaps),
        exactly=posterior.sets[best],
    )


def _kind_of(effects: Names, rivals: Sequence[Names]) -> str:
    """By what is certain, and what is needed beside it."""
    if rivals:
        return "ambiguous"
    classes = {_class_of(e) for e in effects}
    return next((kind for kind in ("rig", "parameter") if classes <= {kind}), "effect")


def _predict_nothing(
    competition: Competition, names: Names, effects: Names, rules: DecisionRules
) -> Names:
    """Effects without which readings that are kept back are predicted better: what explains the
    others by chance is none."""
    fitter, noise = competition.fitter, competition.fits[names].noise
    fold, _ = folds(competition.campaign)

    def predicts(of: Names) -> float:
        return log_score(fitter, fitter.look(competition.fits[of], noise), fold)

    less = {e: _less(names, e) for e in effects if e in names}
    known = {e: of for e, of in less.items() if of in competition.fits}
    # With one fold there is nothing to predict from.
    if not known or len(np.unique(fold)) < 2:
        return ()
    least = predicts(names) + rules.log_rival_odds
    return tuple(e for e, of in known.items() if predicts(of) > least)


def _less(names: Names, name: str) -> Names:
    return tuple(n for n in names if n != name)


def _decided_by(competition: Competition, chosen: Names, rules: DecisionRules) -> tuple[Rest, ...]:
    """Stated numbers without which another answer would be as good."""
    fits = competition.fits
    found = []
    for number in PRIORS:
        other = fits.get((number,))
        if other is None or (number,) == chosen:
            continue
        # As good on the readings alone.
        if other.log_marginal > fits[chosen].log_marginal - 2 * rules.log_rival_odds:
            u = next(u for u in other.unknowns if u.name.startswith(number + "."))
            sd = competition.campaign.priors[number]
            if sd > 0:
                found.append(Rest(number, sd, float((other.value(u) - u.mean) / sd)))
    return tuple(found)


def _rests(fit: Fit, moved: dict[str, float]) -> tuple[Rest, ...]:
    sds = {u.name: u.sd for u in fit.unknowns}
    return tuple(Rest(n, float(sds[n]), z) for n, z in moved.items() if abs(z) > _TOLD_SIGMA)


def _class_of(effect: str) -> str:
    return CLASSES.get(effect, "effect")


def noise_words(competition: Competition, fit: Fit, noise: Noise | None = None) -> tuple[str, ...]:
    """What the noise is beside white, in the words of the answer: that of a fit, or another."""
    noise = noise or fit.noise
    coarse = bool(competition.campaign.step_arcsec)
    if not coarse and noise.scale < 1.05 * LEAST_SCALE:
        # Readings far better than stated: nothing more can be said of how they scatter.
        return ("misstated",) if competition.campaign.u_stated else ("white",)
    words = []
    if noise.offset_arcsec:
        words.append("run_offset")
    if noise.correlation:
        words.append("correlated")
    campaign = competition.campaign
    scatters = campaign.torque_scatter_Nm or campaign.torque_errors is not None
    if noise.torque_arcsec is not None or scatters:
        words.append("torque_noise")
    if noise.artefact is not None and noise.has_artefact:
        words.append(noise.artefact.kind)
    if noise.inflation is not None:
        far = np.count_nonzero(noise.inflation > RULES.far_reading)
        words.append(
            "outliers" if 0 < far <= RULES.outlier_share * len(noise.inflation) else "heavy_tailed"
        )
    off = _misstated_shown(competition, fit) if coarse else _misstated(competition, noise)
    return (*words, "misstated") if off else tuple(words) or ("white",)


def _misstated(competition: Competition, noise: Noise) -> bool:
    """Whether readings scatter by another uncertainty than the stated one."""
    c = competition.campaign
    sigma = abs(np.log(noise.scale)) * np.sqrt(2 * len(c))
    # What the scatter of the torque adds is estimated, and nobody stated it.
    stated = c.u_stated and not c.torque_scatter_Nm
    return c.u_believed != 1 or bool(stated and sigma > RULES.misstated_sigma)


def _misstated_shown(competition: Competition, fit: Fit) -> bool:
    """The same of a coarse display, by the steps that it shows; what is stated may hold the
    rounding or not."""
    c, behind = competition.campaign, scatter_shown(competition.fitter, fit)
    stated = c.readings.u_elastic_angle_arcsec
    if stated is None or not behind.dof:
        return False
    of = float(np.median(stated / c.u_arcsec))
    off = min(abs(np.log(behind.scale)), abs(np.log(behind.scale / of)))
    return bool(off * np.sqrt(2 * behind.dof) > RULES.misstated_sigma)
