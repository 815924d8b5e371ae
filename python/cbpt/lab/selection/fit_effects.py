"""What a model has beside the drive: effects of the case, and effects fitted to the readings.

Number          one parameter with its value and, where it was fitted, its uncertainty
Prediction      what drive and effects say at every reading
predicted       a case with the effects it has
fitted          a case with further effects of the library, fitted to the readings
best_fit        the most probable form and values of some effects
fits_of_forms   the most probable values in each form
fits_nearby     the same where a campaign differs little
best_of_forms   the best of these
start_from      values of a fit for other forms
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.inference.closing import closed
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.inference.modes import with_modes
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of, chosen
from cbpt.lab.model.priors import ON_REQUEST, Variant, no_quicker
from cbpt.lab.model.spring_priors import library_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.linear_screen import Gain, Screen, Signatures, Stack
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.starts import places, start_values

Floats = NDArray[np.float64]

Fits = dict[tuple[Variant, ...], Fit]
"""By the form of each effect."""


@dataclass(frozen=True)
class _Effort:
    """How far is searched."""

    leaders: int = 4
    """Choices of forms that are searched further."""
    listed: int = 4096
    """Choices of signatures that are all looked at. Of more, one is exchanged at a time."""
    same: float = 1e-6
    """In log odds: choices of signatures that differ by less are as good."""
    whole: int = 16
    """Choices of forms that are all fitted. Of more one form is exchanged at a time: their number
    grows with the product of the forms of all effects, and one fit with the number of effects."""


_EFFORT = _Effort()


@dataclass(frozen=True)
class Number:
    """A parameter of an effect, or a number of the drive or the rig, in the unit of its name."""

    effect: str
    """Id of the effect."""
    name: str
    value: float
    u: float | None = None
    """Standard uncertainty; None where it was not fitted."""
    added: bool = True
    """Of an effect that was asked for; else a number that moves within its stated uncertainty."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """A model at n readings. Arrays have shape (n,)."""

    elastic_angle_arcsec: Floats
    """NaN where there is no solution."""
    status: NDArray[np.str_]
    """As in `Angles`."""
    regime: NDArray[np.str_]
    """One of `where.REGIMES`, empty where there is no solution."""
    numbers: tuple[Number, ...] = field(default=())
    fitted: int = 0
    """How many numbers were fitted freely, offsets not counted."""

    @property
    def has_solution(self) -> NDArray[np.bool_]:
        """Where the numbers are there."""
        return np.isfinite(self.elastic_angle_arcsec)


def predicted(case: Case | Drive, readings: Readings) -> Prediction:
    """The case as it is, with the effects it has."""
    effects = case.effects if isinstance(case, Case) else []
    model = Assembled(campaign_of(case, readings, ()), [effect.id for effect in effects])
    values = model.neutral.copy()
    numbers = []
    for instance, effect in enumerate(effects):
        for name, value in effect.values:
            values[model.index(instance, name)] = value
            numbers.append(Number(effect.id, name, value))
    return _prediction(model, values, tuple(numbers), 0)


def _prediction(
    model: Assembled, values: Floats, numbers: tuple[Number, ...], fitted: int
) -> Prediction:
    angle, status = model.states(values)
    return Prediction(angle, status, model.regimes(values), numbers, fitted)


# --- effects to be fitted -----------------------------------------------------------------


def fitted(
    case: Case | Drive, readings: Readings, effects: Sequence[str | OwnEffect]
) -> Prediction:
    """The case with `effects` (ids of the library, own effects) fitted, and its numbers within
    their priors.

    Each effect takes the form that the readings favour. Readings at which the drive has no solution
    do not count in the fit. Raises `InvalidInputError` for an effect that is not known, and
    `ReadingsError` where the table lacks what it needs.
    """
    ids, own = chosen(case, effects)
    campaign = campaign_of(case, readings, own)
    solved = np.isfinite(Assembled(campaign, []).at(np.zeros(0)).angle_arcsec)
    if np.count_nonzero(solved) < 3:
        raise ReadingsError.of_table(
            readings.source,
            "elastic_angle",
            "3 or more readings at which the model has a solution",
        )
    fitter = Fitter(campaign if solved.all() else campaign.select(solved), asked=ids)
    with one_blas_thread():
        best = best_fit(fitter, ids)
    full = Assembled(campaign, fitter.effects)
    free = sum(unknown.sd == np.inf for unknown in best.unknowns)
    return _prediction(full, best.point.values, tuple(_numbers(best)), free)


def best_fit(fitter: Fitter, effects: Sequence[str]) -> Fit:
    """The most probable fit of some effects over all their forms, from promising starts, closed.

    Raises `InvalidInputError` for an effect that is not known or that the readings do not depend
    on, `ReadingsError` where the table lacks a column that it needs.
    """
    return best_of_forms(fitter, effects, fits_of_forms(fitter, effects))


def fits_of_forms(
    fitter: Fitter,
    effects: Sequence[str],
    among: Collection[str] = (),
    known: Fits | None = None,
) -> Fits:
    """The most probable fit of some effects in each of their forms, from promising starts.

    among: labels of forms to which effects that have any of them are confined, unless no start
    shows them together.
    known: fits of effects to the same campaign, to begin from; those of each effect by itself are
    not sought again, and are added where they are missing.

    Raises `InvalidInputError` and `ReadingsError` as `best_fit` does.
    """
    every = [_forms(effect, fitter) for effect in dict.fromkeys(effects)]
    forms = [[v for v in of_one if v.label in among] or of_one for of_one in every]
    known = {} if known is None else known
    if () not in known and (null := fitter.fit(Hypothesis())) is not None:
        known[()] = null
    found = _fits(fitter, forms, known) or _fits(fitter, every, known) if () in known else {}
    if not found:
        raise InvalidInputError(
            f"{' + '.join(effects)} cannot be fitted: the computed angles of these readings do not "
            "depend on the parameters"
        )
    return found


def fits_nearby(fitter: Fitter, elsewhere: Fits, known: Fits | None = None) -> Fits:
    """Those of a campaign that differs little from the one of other fits: in each choice of forms
    from where it ended there, and the best ones from where choices end that they contain.

    known: fits of this campaign, which stay where they are better. Then only the choices that are
    best elsewhere are fitted again.
    """
    found: Fits = dict(known or {})
    for variants in _leaders(elsewhere) if known else elsewhere:
        fit = elsewhere[variants]
        _keep_best(fitter, variants, [(start_from(fitter, variants, fit), fit.noise)], found)
    if not known:
        _from_what_they_contain(fitter, found, [])
    return found


def _from_what_they_contain(fitter: Fitter, found: Fits, smaller: Sequence[Fit]) -> None:
    """The best choices once more, from where choices that they contain and smaller fits end."""
    # Forms of few numbers first: those of more contain them.
    for variants in sorted(_leaders(found), key=lambda chosen: sum(len(v.sizes) for v in chosen)):
        inside = [fit for others, fit in found.items() if _contains(variants, others)]
        starts = [(start_from(fitter, variants, f), f.noise) for f in (*smaller, *inside)]
        _keep_best(fitter, variants, starts, found)


def _leaders(fits: Fits) -> list[tuple[Variant, ...]]:
    return sorted(fits, key=lambda variants: -fits[variants].log_evidence)[: _EFFORT.leaders]


def _fits(fitter: Fitter, forms: Sequence[Sequence[Variant]], known: Fits) -> Fits:
    """In each choice of one form an effect, from promising starts. The best ones also from where
    each effect ends by itself, and from where choices end that they contain: more effects and more
    numbers hardly ever follow the readings worse. Of many choices only those are fitted that differ
    by one form from a better one. known: as in `fits_of_forms`."""
    null = known[()]
    alone = [_alone(fitter, of_one, known) for of_one in forms] if len(forms) > 1 else []
    smaller = [max(a.values(), key=lambda fit: fit.log_evidence) for a in alone if a]
    plain = replace(fitter.campaign.plain_noise, inflation=null.noise.inflation)
    found: Fits = {}

    def keep(variants: tuple[Variant, ...]) -> None:
        starts = [(start, plain) for start in _starts(fitter, null, variants)]
        _keep_best(fitter, variants, starts, found)

    choices = list(product(*forms))
    if len(choices) <= _EFFORT.whole:
        for variants in choices:
            keep(variants)
        _from_what_they_contain(fitter, found, smaller)
        return found
    best = [_leaders(a)[0][0] if a else of_one[0] for a, of_one in zip(alone, forms, strict=True)]
    if near := _nearest(known, forms):
        fit = known[near]
        there = {v.effect: v for v in near if any(v in of_one for of_one in forms)}
        variants = tuple(there.get(v.effect, v) for v in best)
        values = _with_own(start_from(fitter, variants, fit), fit, smaller)
        _keep_best(fitter, variants, [(values, fit.noise)], found)
    for variants in (tuple(best), *choices) if not found else ():
        keep(variants)
        _keep_best(
            fitter, variants, [(start_from(fitter, variants, f), plain) for f in smaller], found
        )
        if found:
            break
    _exchanged(fitter, forms, alone, found)
    for variants in _leaders(found):
        keep(variants)
    _from_what_they_contain(fitter, found, [])
    return found


def _alone(fitter: Fitter, forms: Sequence[Variant], known: Fits) -> Fits:
    """An effect by itself, in each of its forms."""
    if missing := [form for form in forms if (form,) not in known]:
        known.update(_fits(fitter, [missing], known))
    return {(form,): known[form,] for form in forms if (form,) in known}


def _nearest(known: Fits, forms: Sequence[Sequence[Variant]]) -> tuple[Variant, ...]:
    """The known choice that has most of some effects in these forms, and of several the most
    probable one; empty where none has more than one of them."""
    wanted = {form for of_one in forms for form in of_one}
    shared = {variants: len(wanted.intersection(variants)) for variants in known}
    most = max(shared.values())
    if most < 2:
        return ()
    near = [variants for variants, count in shared.items() if count == most]
    return max(near, key=lambda variants: known[variants].log_evidence)


def _with_own(values: Floats, fit: Fit, others: Sequence[Fit]) -> Floats:
    """Values of a fit with those of further effects, as they are in other fits."""
    have = {u.index for u in fit.unknowns}
    for other in others:
        own = [u.index for u in other.unknowns if u.index not in have]
        values[own] = other.point.values[own]
    return values


def _exchanged(
    fitter: Fitter, forms: Sequence[Sequence[Variant]], alone: Sequence[Fits], found: Fits
) -> None:
    """Choices that differ by one form from the best one, from where that ended, until none of them
    is better. Numbers that the new form alone has begin where it ends by itself."""
    while found:
        best = _leaders(found)[0]
        fit = found[best]
        for k, (of_one, by_itself) in enumerate(zip(forms, alone, strict=True)):
            for form in of_one:
                variants = (*best[:k], form, *best[k + 1 :])
                if variants in found:
                    continue
                other = [by_itself[form,]] if (form,) in by_itself else []
                values = _with_own(start_from(fitter, variants, fit), fit, other)
                _keep_best(fitter, variants, [(values, fit.noise)], found)
        if _leaders(found)[0] == best:
            return


def _keep_best(
    fitter: Fitter,
    variants: tuple[Variant, ...],
    starts: Sequence[tuple[Floats, Noise]],
    found: Fits,
) -> None:
    """The most probable fit from some starts, if it is more so than the one that was found."""
    got = [fitter.fit(Hypothesis(variants), start, noise) for start, noise in starts]
    for fit in (fit for fit in got if fit is not None):
        if variants not in found or fit.log_evidence > found[variants].log_evidence:
            found[variants] = fit


def start_from(fitter: Fitter, variants: tuple[Variant, ...], fit: Fit) -> Floats:
    """The values of a fit; what it does not have begins at nothing."""
    values = fitter.start(Hypothesis(variants), {})
    kept = [u.index for u in fit.unknowns]
    values[kept] = fit.point.values[kept]
    return values


def _contains(one: tuple[Variant, ...], other: tuple[Variant, ...]) -> bool:
    """Whether each form of the other is one of these with numbers put to nothing."""
    return one != other and all(
        set(b.sizes) <= set(a.sizes) for a, b in zip(one, other, strict=True)
    )


def best_of_forms(
    fitter: Fitter, effects: Sequence[str], fits: Mapping[tuple[Variant, ...], Fit]
) -> Fit:
    """The most probable of them, over the modes of their effects, closed."""
    best = max(fits.values(), key=lambda fit: fit.log_evidence)
    listed = [v for effect in dict.fromkeys(effects) for v in _forms(effect, fitter)]
    return closed(fitter, with_modes(fitter, best, RULES.log_rival_odds, listed))


def _forms(effect: str, fitter: Fitter) -> list[Variant]:
    """Forms of an effect that the table can show; `drift:time` stands for one of them."""
    if effect == "run_offset":
        raise InvalidInputError(
            "run_offset cannot be added as an effect: to fit an offset for each run, set "
            'zero = "per_run" under [measurement]'
        )
    readings = fitter.campaign.readings
    lots = (v for v in fitter.variants if v.spread)
    everything = (*fitter.library, *fitter.campaign.candidates, *lots)
    variants = [v for v in everything if effect in (v.effect, v.label)]
    if not variants:
        if need := _missing_column(effect, fitter.campaign):
            _stop_without(need, effect, readings)
        known = list(dict.fromkeys([*(v.effect for v in everything), *ON_REQUEST]))
        near = [k for k in known if effect in k] or difflib.get_close_matches(effect, known, 1)
        hint = f"Did you mean {near[0]}? " if effect and near else ""
        raise InvalidInputError(
            f"{effect!r} is not an effect that can be fitted. {hint}Expected one of: "
            + ", ".join(known)
        )
    possible = [v for v in variants if not v.lacks(readings)]
    if not possible:
        _stop_without(variants[0].lacks(readings), effect, readings)
    seen = [v for v in possible if v.spread or no_quicker(v, fitter.campaign.step_s) is not None]
    if not seen:
        raise InvalidInputError(
            f"{effect!r} is over sooner than the next reading is taken, so these readings do not "
            "show it: take readings that follow each other more quickly"
        )
    return seen


def _missing_column(effect: str, campaign: Campaign) -> str:
    """The column without which the reducer's library does not have an effect; empty where there is
    none."""
    numbers = np.arange(1.0, len(campaign) + 1)

    def offered(readings: Readings) -> bool:
        library = library_of(replace(campaign, readings=readings), [effect])
        return any(effect in (v.effect, v.label) for v in library)

    bare = campaign.readings
    filled = {
        "time_s": replace(bare, time_s=numbers),
        "temperature_degC": replace(bare, temperature_degC=numbers),
        "preload_N": replace(bare, preload_N=numbers),
    }
    lacking = (column for column in filled if getattr(bare, column) is None)
    return next((column for column in lacking if offered(filled[column])), "")


def _stop_without(column: str, effect: str, readings: Readings) -> NoReturn:
    raise ReadingsError.of_table(readings.source, column, f"the column that {effect} depends on")


def _starts(fitter: Fitter, null: Fit, variants: Sequence[Variant]) -> Iterator[Floats]:
    """What the linear problem finds at the shapes that suit it best. An effect that would not stand
    out from what the drive alone leaves may do so beside others."""
    library = Signatures(fitter.campaign, variants)
    signatures = library.about(null, places(fitter)) + library.far(null, places(fitter))
    screen = Screen(null, Stack(signatures))
    members = [
        [m for m, s in enumerate(signatures) if s.variant is v and screen.shown[m]]
        for v in variants
    ]
    for gain in _promising(screen, members):
        yield start_values(fitter, [signatures[m] for m in gain.members], gain.sizes)


def _promising(screen: Screen, members: Sequence[Sequence[int]]) -> list[Gain]:
    """The best two choices of one signature an effect. Of many choices one signature is exchanged
    at a time, from those that are best alone."""
    if prod(map(len, members)) <= _EFFORT.listed:
        choices = list(product(*members))
        found = screen.each(np.array(choices)) if choices else []
        return sorted(found, key=lambda gain: -gain.log_odds)[:2]
    alone = [max(of_one, key=lambda m: screen.single(m).log_odds) for of_one in members]
    best = [screen.gain(tuple(alone))]
    while True:
        now = best[0].members
        exchanged = (
            (*now[:k], m, *now[k + 1 :]) for k, of_one in enumerate(members) for m in of_one
        )
        others = list(dict.fromkeys(exchanged))
        found = screen.each(np.array(others))
        before = found[others.index(now)].log_odds
        best = sorted(found, key=lambda gain: -gain.log_odds)[:2]
        if not best[0].log_odds > before + _EFFORT.same:
            return best


def _numbers(fit: Fit) -> Iterator[Number]:
    """Those of the added effects first."""
    added = {variant.effect for variant in fit.hypothesis.variants}
    numbers = [
        Number(variant.effect, name, value)
        for variant in fit.hypothesis.variants
        for name, value in variant.fixed
    ]
    for unknown in fit.unknowns:
        effect, _, name = unknown.name.partition(".")
        numbers.append(
            Number(effect, name or effect, fit.value(unknown), fit.u(unknown), effect in added)
        )
    yield from sorted(numbers, key=lambda number: not number.added)
