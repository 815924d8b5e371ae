"""From odds to words: what is certain, what is open, what kind of answer that is.

    Verdict     kind, certain effects, rival groups, probability, what it rests on
    judge       the rules, in the order in which they apply

1. Something without a name is far likelier than everything with one: `unknown`.
2. No effect is demanded: `complete`, `rig` where noise or a gain is what is off, `parameter` where
   a number of the drive has to move by more than two standard uncertainties, `ambiguous` where the
   calibrations are stated so loosely that drive and instrument explain the same shift.
3. Effects are demanded: those in every set that is within the limit of odds are certain, the
   others rivals.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from cbpt.lab.covariance.fit_noise import LEAST_SCALE
from cbpt.lab.covariance.linear_gaussian import Margin, Noise
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.dataset import DEFAULT_UNCERTAINTY
from cbpt.lab.model.discrepancy import DISCREPANCY_ODDS
from cbpt.lab.model.priors import CLASSES, PRIORS, TWINS
from cbpt.lab.selection.lack_of_fit import LackOfFit
from cbpt.lab.selection.model_comparison import Competition
from cbpt.lab.selection.rules import RULES, DecisionRules
from cbpt.lab.selection.setting import Names


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


def judge(competition: Competition, rules: DecisionRules = RULES) -> Verdict:
    """The verdict on a competition, by the rules above."""
    sets = weighed(competition)
    limit = rules.log_rival_odds
    best = max(sets, key=lambda n: sets[n])
    named = {n: o for n, o in sets.items() if UNKNOWN not in n}
    first = max(named, key=lambda n: named[n])
    # The best of many families gains something in noise alone. An effect that must depart far from
    # its form to explain the readings is hardly a name for what is at work.
    ahead = rules.unknown_over_departed
    if _keeps_form(competition, first):
        ahead = limit + rules.unknown_by_chance
    beaten = UNKNOWN in best and sets[best] > named[first] + ahead
    if beaten and not _only_form(best, sets[best], sets.get(_less(best, UNKNOWN), -np.inf), rules):
        return _unknown(competition, best)
    reach = limit if _keeps_form(competition, first) else 2 * limit
    near = {n: o for n, o in named.items() if o > named[first] - reach - _kinship(n, first, rules)}
    within = {n: o for n, o in near.items() if n}
    alone = {n: o for n, o in sets.items() if UNKNOWN in n and set(n) <= {UNKNOWN, OFFSET}}
    offsets_only = all(n == (OFFSET,) for n in within)
    strange = max(alone.values(), default=-np.inf) > rules.unknown_over_offsets + named[first]
    if not _demanded(competition, first, named, rules) or (offsets_only and not strange):
        return _no_effect(competition, rules)
    # A lack of fit alone counts as a rival where it explains about as well; sooner where the named
    # effect leaves more scatter than there is, or keeps its form badly.
    sound = _keeps_form(competition, first) and not _strained(competition, first, rules)
    fair = float(np.log(rules.unknown_odds)) if sound else limit
    within |= {n: o for n, o in alone.items() if o > max(sets.values()) - fair}
    # The fewest effects that do: a set with more than another one that does needs no mention.
    least = {n: o for n, o in within.items() if not any(set(m) < set(n) for m in within)}
    chosen = max(least, key=lambda n: named.get(n, -np.inf))
    effects = _less(chosen, OFFSET)
    # Either the runs' offsets or an effect: something is there, and noise is not in question.
    either = (OFFSET,) in least and len(least) > 1
    numbers_only = all(n in PRIORS for n in effects)
    # Numbers alone, but far better with their priors widened: that is a finding like an effect.
    numbers_only = numbers_only and named[first] - named.get((), -np.inf) < rules.strain
    if not either and (numbers_only or _p_value(competition, effects) > rules.largest_chance):
        return _no_effect(competition, rules)
    return _effects(competition, least, chosen, rules)


def _kinship(names: Names, best: Names, rules: DecisionRules) -> float:
    """How much further a set is a rival because an effect of it differs from one of the best only
    in a shape that real parts do not keep exactly."""
    ours, theirs = set(names) - set(best), set(best) - set(names)
    kin = any({a, b} == set(pair) for a in ours for b in theirs for pair in rules.kin)
    return rules.kin_reach if kin and len(ours) == len(theirs) == 1 else 0.0


def _demanded(
    competition: Competition, first: Names, named: dict[Names, float], rules: DecisionRules
) -> bool:
    """Whether the best set is called for: far likelier than nothing, or likelier and no chance."""
    over = named[first] - named.get((), -np.inf)
    if over >= rules.log_rival_odds:
        return True
    chance = _p_value(competition, _less(first, OFFSET))
    return bool(over > np.log(rules.weak_odds) and chance <= rules.weak_chance)


def _keeps_form(competition: Competition, names: Names) -> bool:
    """Whether the effects of a set explain the readings about as the library has them."""
    fit = competition.fits.get(_less(names, OFFSET))
    return fit is None or fit.discrepancy_sd < DISCREPANCY_ODDS[-1][0]


def _strained(competition: Competition, names: Names, rules: DecisionRules) -> bool:
    """Whether a set leaves more scatter than a fit that may follow the whole library."""
    fit = competition.fits[_less(names, OFFSET)]
    grown = np.log(fit.noise.scale / competition.flexible.scale)
    return bool(len(competition.campaign) * grown > rules.strain)


UNKNOWN, OFFSET = "unknown", "run_offset"


def weighed(competition: Competition) -> dict[Names, float]:
    """Log odds of every set that competed; offsets of runs and a lack of fit without a name are
    members too.
    """
    found: dict[Names, float] = {}

    def add(names: Iterable[str], odds: float) -> None:
        key = tuple(sorted(names))
        found[key] = max(odds, found.get(key, -np.inf))

    for names, odds in competition.log_odds.items():
        add((*names, *_offset(competition.fits[names].noise)), odds)
    for lack_of_fit, odds in zip(
        competition.lacks_of_fit, competition.lack_of_fit_log_odds, strict=True
    ):
        add((*lack_of_fit.base, *_offset(lack_of_fit.noise), UNKNOWN), odds)
    return found


def _offset(noise: Noise) -> Names:
    return (OFFSET,) if noise.offset_arcsec else ()


def _less(names: Names, name: str) -> Names:
    return tuple(n for n in names if n != name)


def _p_value(competition: Competition, names: Names) -> float:
    return competition.p_value(names) if names in competition.log_odds else 0.0


# --- 1 ---


def _only_form(best: Names, top: float, rest: float, rules: DecisionRules) -> bool:
    """Whether what is left without a name is small beside what the named effects of the set
    explain.
    """
    if len(best) == 1 or not np.isfinite(rest):
        return False
    # The odds of the named part against nothing, its price given back.
    return top - rest < rules.departure_share * (rest + rules.effect_price * (len(best) - 1))


def _unknown(competition: Competition, best: Names) -> Verdict:
    lack_of_fit = next(
        p for p in competition.lacks_of_fit if set(best) - {UNKNOWN, OFFSET} == set(p.base)
    )
    names = lack_of_fit.base
    noise = noise_words(competition, lack_of_fit.noise)
    share = _share(competition, [UNKNOWN])
    return Verdict("unknown", (), (), share, (), False, names, lack_of_fit, noise)


# --- 2 ---


def _no_effect(competition: Competition, rules: DecisionRules) -> Verdict:
    fits, odds = competition.fits, competition.log_odds
    null = fits[()]
    noise = noise_words(competition, null.noise)
    moved = shifts(null)
    inadequate = _nominal_rejected(competition, null, rules)
    rests = _rests(null, moved, rules) if inadequate else ()

    def verdict(
        kind: str,
        effects: tuple[str, ...] = (),
        rivals: tuple[str, ...] = (),
        within_uncertainty: bool = False,
    ) -> Verdict:
        share = _share_of_nothing(competition, (*effects, *rivals))
        groups = (rivals,) if rivals else ()
        return Verdict(kind, effects, groups, share, rests, within_uncertainty, (), None, noise)

    # The readings leave a shift open by a quarter of a sigma or so; that counts for the number.
    strained = {n: z for n, z in moved.items() if abs(z) > rules.moved_sigma + rules.moved_slack}
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
        if v > top - rules.log_rival_odds and abs(z) <= rules.shared_sigma
    )


# --- 3 ---


def _effects(
    competition: Competition, sets: dict[Names, float], chosen: Names, rules: DecisionRules
) -> Verdict:
    certain = set(chosen).intersection(*map(set, sets))
    groups = _groups([set(n) - certain for n in sorted(sets, key=lambda n: -sets[n])])
    effects = tuple(sorted(certain))
    if groups:
        kind = "ambiguous"
    elif all(_class_of(e) == "rig" for e in effects):
        kind = "rig"
    elif all(_class_of(e) == "parameter" for e in effects):
        kind = "parameter"
    else:
        kind = "effect"
    names = _less(_less(chosen, OFFSET), UNKNOWN)
    fit = competition.fits[names]
    return Verdict(
        kind,
        effects,
        tuple(tuple(sorted(g)) for g in groups),
        _share(competition, certain, groups),
        _decided_by(competition, names, rules),
        False,
        names,
        None,
        noise_words(competition, fit.noise),
    )


def _groups(remainders: list[set[str]]) -> list[set[str]]:
    """Groups from each of which one is needed; `remainders` are the sets less what is certain.

    Where all need as many, place by place; else at least one of all that any of them needs.
    """
    remainders = [r for r in remainders if r]
    if len(remainders) < 2:
        return []
    if len({len(r) for r in remainders}) > 1:
        return [set().union(*remainders)]
    first, rest = remainders[0], remainders[1:]
    groups = [{name} for name in sorted(first)]
    for other in rest:
        # What another set has in common stays in its place; what differs joins the places left.
        places = [g for g in groups if not g & other]
        new = [n for n in sorted(other) if not any(n in g for g in groups)]
        for n, g in zip(new, places or groups, strict=False):
            g.add(n)
    if not all(r & g for r in remainders for g in groups):
        return [set().union(*remainders)]
    return [g for g in groups if len(g) > 1]


def _decided_by(competition: Competition, chosen: Names, rules: DecisionRules) -> tuple[Rest, ...]:
    """Stated numbers without which another answer would be as good."""
    fits = competition.fits
    found = []
    for number in PRIORS:
        other = fits.get((number,))
        if other is None or (number,) == chosen:
            continue
        # As good on the readings alone.
        if other.log_marginal > fits[chosen].log_marginal - rules.decided_within:
            u = next(u for u in other.unknowns if u.name.startswith(number + "."))
            sd = competition.campaign.priors[number]
            if sd > 0:
                found.append(Rest(number, sd, float((other.value(u) - u.mean) / sd)))
    return tuple(found)


def _rests(fit: Fit, moved: dict[str, float], rules: DecisionRules) -> tuple[Rest, ...]:
    sds = {u.name: u.sd for u in fit.unknowns}
    return tuple(Rest(n, float(sds[n]), z) for n, z in moved.items() if abs(z) > rules.told_sigma)


def _share(
    competition: Competition, certain: Iterable[str], groups: Iterable[Iterable[str]] = ()
) -> float:
    """Posterior probability that all that is certain is at work, and one of each group."""
    odds = weighed(competition)
    top = max(odds.values())
    needed, rivals = set(certain), [set(g) for g in groups]

    def fits(names: Names) -> bool:
        found = set(names)
        return needed <= found and all(found & g for g in rivals)

    total = sum(np.exp(o - top) for o in odds.values())
    return calibrated(sum(np.exp(o - top) for n, o in odds.items() if fits(n)) / total)


def _share_of_nothing(competition: Competition, besides: Iterable[str] = ()) -> float:
    """Posterior probability that no effect is at work but for these."""
    odds = weighed(competition)
    top = max(odds.values())
    allowed = {OFFSET, *besides}
    total = sum(np.exp(o - top) for o in odds.values())
    return calibrated(sum(np.exp(o - top) for n, o in odds.items() if set(n) <= allowed) / total)


def calibrated(share: float) -> float:
    """Probability that an answer is right, from its share of all that was weighed.

    Over the trial (`benches/trial`, reliability table) answers of share s were right about
    0.95 s of the time; fitted on seeds 2 and 3, the published table is of another.
    """
    return float(0.95 * share)


def _class_of(effect: str) -> str:
    return CLASSES.get(effect, "effect")


def noise_words(competition: Competition, noise: Noise) -> tuple[str, ...]:
    """What the noise is beside white, in the words of the answer."""
    if noise.scale < 1.05 * LEAST_SCALE:
        # Readings far better than stated: nothing more can be said of how they scatter.
        return ("misstated",)
    words = []
    if noise.offset_arcsec:
        words.append("run_offset")
    if noise.correlation:
        words.append("correlated")
    if noise.inflation is not None:
        far = np.count_nonzero(noise.inflation > RULES.far_reading)
        words.append(
            "outliers"
            if far <= RULES.outlier_share * len(noise.inflation)
            and noise.inflation.max() > RULES.largest_inflation
            else "heavy_tailed"
        )
    dof = len(competition.campaign)
    if competition.campaign.u_believed != 1 or (
        competition.campaign.u_stated
        and abs(np.log(noise.scale)) * np.sqrt(2 * dof) > RULES.misstated_sigma
        and abs(np.log(noise.scale)) > RULES.misstated_log
    ):
        words.append("misstated")
    return tuple(words) or ("white",)
