"""Noise, numbers of the drive, instruments and effects in one competition.

    Competition     every hypothesis that was fitted, with its odds
    compete         screen, fit, weigh

Order: a first fit of the drive as stated; loose readings; the library at a glance under two noises
(as that fit sees it, and as a fit that can follow everything sees it); every effect that could
gain, fitted in full; the pairs that could gain more; patterns without a name, alone and on top of
the best. All are weighed by evidence and prior odds, so no order of asking decides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from itertools import product as cartesian

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.noise import Noise, Whitener, fit_noise
from cbpt.lab.covariance.outliers import looseness
from cbpt.lab.inference.fit import Fit, Fitter, Hypothesis
from cbpt.lab.inference.modes import solved
from cbpt.lab.model.forward import Campaign
from cbpt.lab.model.priors import LOT, ODDS, Variant
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.selection.lack_of_fit import Component, components
from cbpt.lab.selection.linear_screen import Gain, Screen, Signature, Signatures
from cbpt.lab.selection.patterns import Pattern, patterns_on, says_no_more

Floats = NDArray[np.float64]
Names = tuple[str, ...]
Progress = Callable[[str, float], object]
"""Told what is next and what share of the work is done; what it raises ends the work."""

REPLICATES = 400
_PAIRS = 8
# A pair is fitted in full where the screen sees it this near to the best single.
_PAIR_ROOM = 4.0
_FORMS = 3
_GLANCED = 60
# In log odds: effects this near to the best, and likelier than none, are looked at for other
# solutions.
_SOLVED_WITHIN = 10.0
_LARGE = 4


@dataclass(frozen=True, eq=False)
class Competition:
    """Outcome of the competition."""

    fitter: Fitter
    fits: dict[Names, Fit]
    """The best form of every set of effects that was fitted; () is the drive as stated."""
    log_odds: dict[Names, float]
    """Posterior log odds of each against the drive as stated."""
    patterns: tuple[Pattern, ...]
    """Unnamed patterns, the most probable first."""
    pattern_log_odds: tuple[float, ...]
    library: Signatures = field(repr=False)
    names: dict[int, tuple[str, str]] = field(repr=False)
    """(effect, parameter) of each value of the fits."""
    null_maximum: Floats = field(repr=False)
    """Largest log odds of any effect in noise alone."""
    flexible: Noise
    """The noise as a fit sees it that may follow the whole library."""
    looser: Floats | None = field(repr=False)

    @property
    def campaign(self) -> Campaign:
        """The readings."""
        return self.fitter.campaign

    @property
    def best(self) -> Names:
        """The most probable set of effects."""
        return max(self.log_odds, key=lambda k: self.log_odds[k])

    def p_value(self, names: Names) -> float:
        """Chance of any single effect looking this good in noise alone."""
        odds = self.log_odds[names]
        return float(
            (1 + np.count_nonzero(self.null_maximum >= odds)) / (1 + len(self.null_maximum))
        )


def prior(names: Names) -> float:
    """Log prior odds of a set of effects against nothing."""
    return float(sum(np.log(ODDS.get(n, ODDS[""])) for n in names))


def compete(
    campaign: Campaign, rng: np.random.Generator, progress: Progress | None = None
) -> Competition:
    """Fit and weigh everything. The model must have a solution at every row."""
    told = progress or (lambda what, share: None)
    told("the drive as stated", 0.0)
    fitter = Fitter(campaign)
    names = places(fitter)
    nothing = Hypothesis()
    first = fitter.fit(nothing, free_noise=False)
    if first is None:
        raise ValueError("the model has no solution at some rows; leave them out first")
    families = components(campaign.readings)
    library = Signatures(campaign, fitter.variants)
    signatures = library.about(first, names)
    looser = _loose(fitter, first, signatures, families)
    start = Noise(looser=looser)
    null = fitter.fit(nothing, noise=start)
    assert null is not None
    flexible = _flexible_noise(fitter, null, signatures, start)
    fits: dict[Names, Fit] = {(): null}

    # Singles: under both noises, then in full.
    looks = [fitter.look(null, noise) for noise in (null.noise, flexible)]
    # Behind the others, so that a number means the same in both lists.
    wider = signatures + library.far(first, names)
    screens = [Screen(look, wider) for look in looks]
    levels = [look.log_evidence for look in looks]
    _price_forms(fitter, screens, levels, wider)
    # The most promising first: the others need not be polished further than it takes to be out.
    promising = _promising(screens, levels, wider)
    for number, (member, sizes) in enumerate(promising):
        told(wider[member].variant.effect, 0.1 + 0.5 * number / len(promising))
        hypothesis = Hypothesis((wider[member].variant,))
        values = start_values(fitter, wider, (member,), sizes)
        # Zeros of the runs can hide what goes with the input angle, so both ways are tried.
        for noise in _noises(campaign, flexible, start):
            _keep(fits, fitter.fit(hypothesis, values, noise))

    bar = max(_score(fitter, f) for f in fits.values()) - _SOLVED_WITHIN
    bar = max(bar, _score(fitter, null))
    for single in [n for n, f in fits.items() if _score(fitter, f) > bar]:
        fits[single] = solved(fitter, fits[single])

    # Pairs: about the drive as stated, and about the best singles.
    ranked = sorted((n for n in fits if len(n) == 1), key=lambda n: -_score(fitter, fits[n]))
    told("pairs of effects", 0.6)
    pairs = _pairs(fitter, library, fits, screens, levels, signatures, names, ranked[:2], flexible)
    for number, fit in enumerate(pairs, 1):
        told("pairs of effects", 0.6 + 0.2 * number / _PAIRS)
        _keep(fits, fit)
    if campaign.drive.kind == "torsion_spring":
        for fit in _together(
            fitter, signatures, screens[0], [n for (n,) in ranked[:_LARGE]], start
        ):
            told("effects together", 0.8)
            _keep(fits, fit)

    told("patterns without a name", 0.85)
    top = max(fits, key=lambda n: _score(fitter, fits[n]))
    if not fits[top].solved:
        fits[top] = solved(fitter, fits[top])
    log_odds = {n: _score(fitter, f) - _score(fitter, null) for n, f in fits.items()}
    best = max(log_odds, key=lambda k: log_odds[k])
    patterns = [
        p
        for base in sorted({(), best})
        for p in patterns_on(fitter, fits[base], families, flexible)
        if not says_no_more(p, fits[best])
    ]
    pattern_odds = [
        p.log_evidence
        + prior(p.base)
        + _forms(fitter, fits[p.base])
        + np.log(ODDS["unknown"])
        - _score(fitter, null)
        for p in patterns
    ]
    order = np.argsort(pattern_odds)[::-1]
    weights = np.array([_weight(fitter, s.variant) for s in wider])
    told("what chance shows", 0.95)
    screen = Screen(fitter.look(null, fits[best].noise), wider)
    return Competition(
        fitter,
        fits,
        log_odds,
        tuple(patterns[i] for i in order),
        tuple(float(pattern_odds[i]) for i in order),
        library,
        names,
        screen.null_of_maximum(weights, REPLICATES, rng),
        flexible,
        looser,
    )


# --- steps ------------------------------------------------------------------------------------


def places(fitter: Fitter) -> dict[int, tuple[str, str]]:
    """(effect, parameter) of each value; of a ball of a lot with its number, `3.oversize_m`."""
    found = {}
    for (instance, name), i in fitter.model.places.items():
        effect = fitter.effects[instance]
        number = instance - fitter.effects.index(LOT) if effect == LOT else 0
        found[i] = effect, f"{number}.{name}" if effect == LOT else name
    return found


def _loose(
    fitter: Fitter, fit: Fit, signatures: list[Signature], families: tuple[Component, ...]
) -> Floats | None:
    c = fitter.campaign
    # Beside a loop of play and friction still to be explained, what looks loose is part of it.
    if len(c) < 12 or c.drive.kind == "torsion_spring":
        return None
    numbers = fit.point.slopes * np.array([u.unit for u in fit.unknowns])
    seen = [np.where(np.isfinite(s.columns), s.columns, 0.0) for s in signatures]
    fields = [numbers, *seen, *(f.patterns for f in families)]
    y = c.y_arcsec - fit.point.angle_arcsec
    looser = looseness(y, c.zeros, fields, Whitener.of(Noise(), c.u_arcsec, c.rows))
    return None if looser is None or _of_one_place(c, looser > 1.5) else looser


def _of_one_place(campaign: Campaign, loose: NDArray[np.bool_]) -> bool:
    """Whether loose readings sit together where chance would not put them: that is no noise."""
    r, count = campaign.readings, int(np.count_nonzero(loose))
    if count < 3:
        return False
    size = np.abs(r.torque_Nm)
    places = [
        r.run_index,
        np.round(np.mod(r.input_angle_deg, 360.0), 3),
        size > np.quantile(size, 0.6),
    ]
    if r.preload_N is not None:
        places.append(levels_of(r.preload_N).index)
    for place in places:
        values, index = np.unique(place, return_inverse=True)
        inside = np.bincount(index[loose], minlength=len(values))
        at = int(np.argmax(inside))
        share = float(np.mean(index == at))
        if (
            len(values) > 1
            and inside[at] >= 0.9 * count
            and share ** inside[at] * len(values) < 3e-4
        ):
            return True
    return False


def _flexible_noise(fitter: Fitter, fit: Fit, signatures: list[Signature], start: Noise) -> Noise:
    """The noise as seen by a fit that may follow the whole library."""
    c = fitter.campaign
    y, x, precision = fitter.linear(fit)
    columns = np.column_stack([s.columns for s in signatures])
    columns = columns[:, np.isfinite(columns).all(axis=0)]
    size = np.linalg.norm(columns / c.u_arcsec[:, None], axis=0)
    columns = columns[:, size > 1e-9] / size[size > 1e-9]
    # Each signature may be as strong as a hundred standard deviations of the whole table.
    noise, _ = fit_noise(
        y,
        np.column_stack([x, columns]),
        np.r_[precision, np.full(columns.shape[1], 1e-4)],
        c.u_arcsec,
        c.rows,
        start,
        fitter.stated_dof,
        structures=len(c) > 3 * columns.shape[1],
    )
    # What so many free columns take from the scatter by chance is given back.
    size = np.linalg.svd(columns / c.u_arcsec[:, None], compute_uv=False)
    taken = float(np.sum(size**2 / (size**2 + 1e-2)))
    return replace(noise, scale=noise.scale * np.sqrt(len(c) / max(len(c) - taken, 1.0)))


def _promising(
    screens: list[Screen], levels: list[float], signatures: list[Signature]
) -> list[tuple[int, Floats]]:
    """The best forms of every effect that gains, with sizes; the most promising first."""
    found: dict[str, tuple[float, int, Floats]] = {}
    for screen, level in zip(screens, levels, strict=True):
        for m, s in enumerate(signatures):
            if not screen.usable(m):
                continue
            gain = screen.single(m)
            if gain.chi2 < 2 or not np.isfinite(gain.log_odds):
                continue
            value, form = level + gain.log_odds, s.variant.label
            if form not in found or value > found[form][0]:
                found[form] = (value, m, gain.sizes)
    ranked = sorted(found.values(), key=lambda f: -f[0])
    taken: dict[str, int] = {}
    out = []
    for _, m, sizes in ranked:
        effect = signatures[m].variant.effect
        taken[effect] = taken.get(effect, 0) + 1
        if taken[effect] <= _FORMS:
            out.append((m, sizes))
    return out


def start_values(
    fitter: Fitter,
    signatures: list[Signature],
    members: tuple[int, ...],
    sizes: Floats,
    base: Fit | None = None,
) -> Floats:
    """Values to start from: what the screen found, cut to what is plausible."""
    hypothesis = Hypothesis(tuple(signatures[m].variant for m in members))
    given: dict[str, float] = {}
    at = 0
    for m in members:
        s = signatures[m]
        v = s.variant
        width = s.columns.shape[1]
        found = s.sizes(sizes[at : at + width])
        at += width
        for name, size, ratio in zip(
            v.sizes, found, v.ratios or (1.0,) * len(v.sizes), strict=True
        ):
            most = 0.5 * v.high * ratio if not v.spread else 4 * v.spread
            given[f"{v.effect}.{name}"] = fitter.neutral(v.effect, name) + float(
                np.clip(size, -most, most)
            )
        given |= {f"{v.effect}.{name}": value for name, value in s.shapes.items()}
    values = fitter.start(hypothesis, given)
    if base is not None:
        kept = [u.index for u in base.unknowns]
        values[kept] = base.point.values[kept]
        for name, value in given.items():
            effect, _, parameter = name.partition(".")
            if effect not in base.hypothesis.effects:
                i = fitter.place(effect, parameter)
                values[i] = np.clip(value, fitter.model.lower[i], fitter.model.upper[i])
    return values


def _noises(campaign: Campaign, noise: Noise, plain: Noise) -> Iterator[Noise]:
    """Noises to start a fit from: with and without zeros of runs.

    Play and friction of a torsion spring are as large as the angle itself, and through noise that
    is correlated along the run a fit may not find its way to them; so there the plain one as well.
    """
    yield noise
    if noise.offset_arcsec:
        yield replace(noise, offset_arcsec=0.0)
    if campaign.drive.kind == "torsion_spring":
        yield plain


def _keep(fits: dict[Names, Fit], fit: Fit | None) -> None:
    if fit is None or not np.isfinite(fit.log_evidence):
        return
    names = fit.hypothesis.effects
    if names not in fits or fit.log_evidence > fits[names].log_evidence:
        fits[names] = fit


def _forms(fitter: Fitter, fit: Fit) -> float:
    """Price of having chosen the best of several forms of an effect, less what the others count."""
    return -float(sum(fitter.form_price.get(e, 0.0) for e in fit.hypothesis.effects))


def _price_forms(
    fitter: Fitter, screens: list[Screen], levels: list[float], signatures: list[Signature]
) -> None:
    """The evidence of an effect is the mean over its forms; here seen by the screen."""
    for effect in {v.effect for v in fitter.variants}:
        forms: dict[str, float] = {}
        for screen, level in zip(screens, levels, strict=True):
            for m, s in enumerate(signatures):
                if s.variant.effect == effect and screen.usable(m):
                    value = level + screen.single(m).log_odds
                    forms[s.variant.label] = max(value, forms.get(s.variant.label, -np.inf))
        count = sum(v.effect == effect for v in fitter.variants)
        values = np.array(list(forms.values()))
        if count > 1 and len(values) and np.isfinite(values.max()):
            share = float(np.exp(values - values.max()).sum())
            fitter.form_price[effect] = float(np.log(count / share))


def _weight(fitter: Fitter, variant: Variant) -> float:
    count = sum(v.effect == variant.effect for v in fitter.variants)
    return prior((variant.effect,)) - float(np.log(count))


def _score(fitter: Fitter, fit: Fit) -> float:
    """Log of evidence times prior odds."""
    return fit.log_evidence + prior(fit.hypothesis.effects) + _forms(fitter, fit)


def _pairs(
    fitter: Fitter,
    library: Signatures,
    fits: dict[Names, Fit],
    screens: list[Screen],
    levels: list[float],
    signatures: list[Signature],
    names: dict[int, tuple[str, str]],
    bases: Sequence[Names],
    noise: Noise,
) -> Iterator[Fit | None]:
    """Pairs that might beat every single, fitted in full."""
    bar = max(_score(fitter, f) for f in fits.values()) - _PAIR_ROOM
    wanted: dict[Names, tuple[float, tuple[int, ...], Floats, Fit | None]] = {}

    def offer(score: float, members: tuple[int, ...], sizes: Floats, base: Fit | None) -> None:
        before = base.hypothesis.effects if base else ()
        key = tuple(sorted([*before, *(signatures[m].variant.effect for m in members)]))
        if score > bar and (key not in wanted or score > wanted[key][0]):
            wanted[key] = (score, members, sizes, base)

    for screen, level in zip(screens, levels, strict=True):
        usable = [m for m, s in enumerate(signatures) if screen.usable(m) and not s.variant.spread]
        for _, a, b in screen.pairs(usable)[:_GLANCED]:
            va, vb = signatures[a].variant, signatures[b].variant
            if va.effect == vb.effect:
                continue
            gain = screen.gain((a, b))
            if np.isfinite(gain.log_odds):
                weight = _weight(fitter, va) + _weight(fitter, vb)
                offer(level + gain.log_odds + weight, (a, b), gain.sizes, None)
    for base in bases:
        fit = fits[base]
        about = library.about(fit, names, secants=False)
        # As the library has it: what looks like a departure from form may be the second effect.
        seen = fitter.look(replace(fit, form_sd=0.0), noise)
        screen, level = Screen(seen, about), _score(fitter, seen)
        for m, s in enumerate(about):
            if screen.usable(m) and s.variant.effect not in base:
                gain = screen.single(m)
                if np.isfinite(gain.log_odds):
                    offer(level + gain.log_odds + _weight(fitter, s.variant), (m,), gain.sizes, fit)
    ordered = sorted(wanted.values(), key=lambda w: -w[0])[:_PAIRS]
    for _, members, sizes, base_fit in ordered:
        added = tuple(signatures[m].variant for m in members)
        before = base_fit.hypothesis.variants if base_fit else ()
        yield fitter.fit(
            Hypothesis((*before, *added)),
            start_values(fitter, signatures, members, sizes, base_fit),
            noise,
        )


def _together(
    fitter: Fitter,
    signatures: list[Signature],
    screen: Screen,
    effects: Sequence[str],
    noise: Noise,
) -> Iterator[Fit | None]:
    """Two and three effects at once, from the linear problem about the reducer as stated.

    Play, friction and what comes with them are each as large as the loop: from a fit that has taken
    the loop for one of them there is no way to the others.
    """
    forms = {
        e: [m for m, s in enumerate(signatures) if s.variant.effect == e and screen.usable(m)]
        for e in effects
    }
    for chosen in (*combinations(effects, 2), *combinations(effects, 3)):
        gains = [screen.gain(members) for members in cartesian(*(forms[e] for e in chosen))]
        # The best start of each choice of forms.
        best: dict[tuple[str, ...], Gain] = {}
        for gain in sorted(gains, key=lambda g: -g.log_odds):
            labels = tuple(signatures[m].variant.label for m in gain.members)
            best.setdefault(labels, gain)
        for gain in list(best.values())[:_FORMS]:
            hypothesis = Hypothesis(tuple(signatures[m].variant for m in gain.members))
            values = start_values(fitter, signatures, gain.members, gain.sizes)
            yield _without_idle(fitter, fitter.fit(hypothesis, values, noise), noise)


def _without_idle(fitter: Fitter, fit: Fit | None, noise: Noise) -> Fit | None:
    """A fit without the effects that it put to nothing: they are no part of what it found."""
    if fit is None:
        return None
    idle = {
        v.effect
        for v in fit.hypothesis.variants
        if all(
            fit.point.values[fitter.place(v.effect, size)] == fitter.neutral(v.effect, size)
            for size in v.sizes
        )
    }
    if not idle:
        return fit
    rest = tuple(v for v in fit.hypothesis.variants if v.effect not in idle)
    return fitter.fit(Hypothesis(rest), fit.point.values, noise)
