"""Noise, numbers of the drive, instruments and effects in one competition.

Competition     every hypothesis that was fitted, with its odds
compete         screen, fit, weigh

Order: the setting (a first fit of the drive as stated, readings that scatter more, the library at a
glance under two noises); every effect that could gain, fitted in full; the pairs that could gain
more; lack of fit that no effect names, alone and on top of the best. All are weighed by evidence
and prior odds, so no order of asking decides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from itertools import product as cartesian

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter, Race
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.inference.modes import with_modes
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import ODDS
from cbpt.lab.selection.lack_of_fit import LackOfFit, lacks_of_fit_on, says_no_more
from cbpt.lab.selection.linear_screen import Gain, Screen, Signature, Signatures
from cbpt.lab.selection.ranking import ranked
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names, Setting, prepare, prior
from cbpt.lab.selection.starts import start_values

Floats = NDArray[np.float64]
Progress = Callable[[str, float], object]
"""Called with what is next and what share of the work is done; what it raises ends the work."""


@dataclass(frozen=True)
class _Effort:
    """How far the competition searches: more costs time and changes no rule."""

    replicates: int = 400
    """Sets of noise by which the chance of the largest gain is simulated."""
    variants: int = 3
    """Variants of an effect that are fitted in full."""
    pairs: int = 8
    """Pairs that are fitted in full."""
    pair_room: float = 4.0
    """Log odds below the best single at which the screen may see a pair that is fitted."""
    pairs_weighed: int = 60
    """Pairs of the largest gain in misfit whose odds the screen works out."""
    modes_room: float = 10.0
    """Log odds below the best within which an effect is searched for other modes."""
    large: int = 4
    """Effects of a torsion spring of which two and three are fitted at once."""


_EFFORT = _Effort()
_TIE = 1e-6
"""In log odds: fits nearer than this are equally good, and the first of them stands."""


@dataclass(frozen=True, eq=False)
class Competition:
    """Outcome of the competition."""

    fitter: Fitter
    fits: dict[Names, Fit]
    """The best form of every set of effects that was fitted; () is the drive as stated."""
    log_odds: dict[Names, float]
    """Posterior log odds of each against the drive as stated."""
    lacks_of_fit: tuple[LackOfFit, ...]
    """Lacks of fit without a name, the most probable first."""
    lack_of_fit_log_odds: tuple[float, ...]
    library: Signatures = field(repr=False)
    names: dict[int, tuple[str, str]] = field(repr=False)
    """(effect, parameter) of each value of the fits."""
    null_maximum: Floats = field(repr=False)
    """Largest log odds of any effect in noise alone."""
    flexible: Noise
    """The noise as a fit sees it that may follow the whole library."""
    inflation: Floats | None = field(repr=False)

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


def compete(
    campaign: Campaign, rng: np.random.Generator, progress: Progress | None = None
) -> Competition:
    """Fit and weigh everything. The model must have a solution at every row."""
    report = progress or (lambda what, share: None)
    report("the drive as stated", 0.0)
    contest = _Contest(prepare(Fitter(campaign)), report)
    contest.fit_singles()
    contest.find_modes()
    contest.fit_pairs()
    if campaign.drive.kind == "torsion_spring":
        contest.fit_together()
    report("lack of fit", 0.85)
    contest.find_modes_of_best()
    unnamed = contest.unnamed()
    report("p-values by simulation", 0.95)
    return contest.competition(unnamed, rng)


class _Contest:
    """The fits so far, and the steps that add to them."""

    def __init__(self, setting: Setting, report: Progress) -> None:
        self.setting, self.report = setting, report
        self.fitter = setting.fitter
        self.race = Race(self.fitter, setting.flexible)
        self.fits: dict[Names, Fit] = {(): setting.null}
        """The best fit of every set of effects so far."""

    def keep(self, fit: Fit | None) -> None:
        """Keep a fit where it is the best of its set."""
        if fit is None or not np.isfinite(fit.log_evidence):
            return
        names = fit.hypothesis.effects
        if names not in self.fits or fit.log_evidence > self.fits[names].log_evidence + _TIE:
            self.fits[names] = fit

    def score(self, names: Names) -> float:
        """Log of evidence times prior odds."""
        return self.setting.score(self.fits[names])

    @property
    def ranked_singles(self) -> list[Names]:
        """Single effects, the best first."""
        return sorted((n for n in self.fits if len(n) == 1), key=lambda n: -self.score(n))

    # --- steps ---

    def fit_singles(self) -> None:
        """Every effect that may gain; the most promising first, which bounds the others."""
        wider = self.setting.wider
        promising = _promising(self.setting)
        for number, gain in enumerate(promising):
            variant = wider[gain.members[0]].variant
            self.report(variant.effect, 0.1 + 0.5 * number / len(promising))
            hypothesis = Hypothesis((variant,))
            start = start_values(self.fitter, [wider[gain.members[0]]], gain.sizes)
            self.keep(self.race.fit(hypothesis, start))
            for noise in _other_noises(self.setting):
                self.keep(self.fitter.fit(hypothesis, start, noise))

    def find_modes(self) -> None:
        """Other modes of the singles that are near the best."""
        best = max(self.score(n) for n in self.fits) - _EFFORT.modes_room
        least = max(best, self.setting.score(self.setting.null))
        for names in [n for n in self.fits if self.score(n) > least]:
            self.fits[names] = with_modes(self.fitter, self.fits[names], RULES.log_rival_odds)

    def fit_pairs(self) -> None:
        """Pairs that may beat every single one."""
        self.report("pairs of effects", 0.6)
        for number, pair in enumerate(self._promising_pairs(), 1):
            added = tuple(s.variant for s in pair.signatures)
            before = pair.base.hypothesis.variants if pair.base else ()
            start = start_values(self.fitter, pair.signatures, pair.sizes, pair.base)
            fit = self.race.fit(Hypothesis((*before, *added)), start)
            self.report("pairs of effects", 0.6 + 0.2 * number / _EFFORT.pairs)
            self.keep(fit)

    def fit_together(self) -> None:
        """Two and three effects at once, from the linear problem about the reducer as stated.

        Play, friction and what comes with them are each as large as the loop: from a fit that has
        taken the loop for one of them there is no way to the others.
        """
        effects = [effect for (effect,) in self.ranked_singles[: _EFFORT.large]]
        signatures, screen = self.setting.signatures, self.setting.looks[0].screen
        variants = {
            e: [m for m, s in enumerate(signatures) if s.variant.effect == e and screen.usable(m)]
            for e in effects
        }
        for chosen in (*combinations(effects, 2), *combinations(effects, 3)):
            gains = [screen.gain(members) for members in cartesian(*(variants[e] for e in chosen))]
            # The best start of each choice of variants.
            best: dict[tuple[str, ...], Gain] = {}
            for gain in sorted(gains, key=lambda g: -g.log_odds):
                labels = tuple(signatures[m].variant.label for m in gain.members)
                best.setdefault(labels, gain)
            for gain in list(best.values())[: _EFFORT.variants]:
                members = [signatures[m] for m in gain.members]
                hypothesis = Hypothesis(tuple(s.variant for s in members))
                start = start_values(self.fitter, members, gain.sizes)
                fit = self.fitter.fit(hypothesis, start, self.setting.plain)
                self.report("effects together", 0.8)
                self.keep(_without_idle(self.fitter, fit, self.setting.plain))

    def find_modes_of_best(self) -> None:
        """Other modes of the best set, where they were not searched for yet."""
        top = max(self.fits, key=self.score)
        if not self.fits[top].modes_searched:
            self.fits[top] = with_modes(self.fitter, self.fits[top], RULES.log_rival_odds)

    def unnamed(self) -> list[tuple[float, LackOfFit]]:
        """Lack of fit without a name on the drive as stated and on the best set, with log odds, the
        most probable first."""
        setting, fits = self.setting, self.fits
        best = max(fits, key=self.score)
        null = setting.score(setting.null)
        found = [
            (
                p.log_evidence
                + prior(p.base)
                - setting.price(p.base)
                + float(np.log(ODDS["unknown"]))
                - null,
                p,
            )
            for base in sorted({(), best})
            for p in lacks_of_fit_on(self.fitter, fits[base], setting.families, setting.flexible)
            if not says_no_more(p, fits[best])
        ]
        return sorted(found, key=lambda f: -f[0])

    def competition(
        self, unnamed: Sequence[tuple[float, LackOfFit]], rng: np.random.Generator
    ) -> Competition:
        """The outcome, with what chance alone would show."""
        setting, null = self.setting, self.score(())
        log_odds = {names: self.score(names) - null for names in self.fits}
        best = max(log_odds, key=lambda n: log_odds[n])
        screen = Screen(self.fitter.look(setting.null, self.fits[best].noise), setting.wider)
        weights = np.array([setting.weight(s.variant) for s in setting.wider])
        return Competition(
            self.fitter,
            self.fits,
            log_odds,
            tuple(lack_of_fit for _, lack_of_fit in unnamed),
            tuple(odds for odds, _ in unnamed),
            setting.library,
            setting.names,
            screen.null_of_maximum(weights, _EFFORT.replicates, rng),
            setting.flexible,
            setting.plain.inflation,
        )

    def _promising_pairs(self) -> list[_Pair]:
        """Pairs that the screen sees near the best fit so far or above it, the best first."""
        offers = _Offers(max(self.score(n) for n in self.fits) - _EFFORT.pair_room)
        self._offer_pairs(offers)
        for base in self.ranked_singles[:2]:
            self._offer_additions(offers, self.fits[base])
        return sorted(offers.best.values(), key=lambda p: -p.score)[: _EFFORT.pairs]

    def _offer_pairs(self, offers: _Offers) -> None:
        """Two effects about the drive as stated."""
        setting, signatures = self.setting, self.setting.signatures
        for look in setting.looks:
            screen = look.screen
            usable = [
                m for m, s in enumerate(signatures) if screen.usable(m) and not s.variant.spread
            ]
            for _, a, b in screen.pairs(usable)[: _EFFORT.pairs_weighed]:
                one, other = signatures[a], signatures[b]
                if one.variant.effect == other.variant.effect:
                    continue
                gain = screen.gain((a, b))
                weight = setting.weight(one.variant) + setting.weight(other.variant)
                score = look.log_evidence + gain.log_odds + weight
                offers.add(_Pair(score, (one, other), gain.sizes, None))

    def _offer_additions(self, offers: _Offers, base: Fit) -> None:
        """A second effect about the best fit of one."""
        setting = self.setting
        about = setting.library.about(base, setting.names, secants=False)
        # As the library has it: a discrepancy of the first effect may be the second one.
        seen = self.fitter.look(replace(base, discrepancy_sd=0.0), setting.flexible)
        screen, level = Screen(seen, about), setting.score(seen)
        for m, s in enumerate(about):
            if screen.usable(m) and s.variant.effect not in base.hypothesis.effects:
                gain = screen.single(m)
                score = level + gain.log_odds + setting.weight(s.variant)
                offers.add(_Pair(score, (s,), gain.sizes, base))


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two effects that may be better than any single one."""

    score: float
    """Log of evidence times prior odds, as the screen sees it."""
    signatures: tuple[Signature, ...]
    """What is added: both effects, or the second one."""
    sizes: Floats
    base: Fit | None
    """The fit of one of them that the other is added to; None for both at once."""

    @property
    def names(self) -> Names:
        """The effects, sorted."""
        before = self.base.hypothesis.effects if self.base else ()
        return tuple(sorted([*before, *(s.variant.effect for s in self.signatures)]))


class _Offers:
    """The best offer of every pair of effects, of those that score above a limit."""

    def __init__(self, least: float) -> None:
        self.least = least
        self.best: dict[Names, _Pair] = {}

    def add(self, pair: _Pair) -> None:
        """Keep the pair where it is the best of its effects so far."""
        if not np.isfinite(pair.score) or pair.score <= self.least:
            return
        if pair.names not in self.best or pair.score > self.best[pair.names].score:
            self.best[pair.names] = pair


def _promising(setting: Setting) -> list[Gain]:
    """The best variants of every effect that gains, with sizes; the most promising first."""
    found: dict[str, tuple[float, Gain]] = {}
    for look in setting.looks:
        for m, s in enumerate(setting.wider):
            if not look.screen.usable(m):
                continue
            gain = look.screen.single(m)
            if gain.chi2 < 2 or not np.isfinite(gain.log_odds):
                continue
            value, label = look.log_evidence + gain.log_odds, s.variant.label
            if label not in found or value > found[label][0] + _TIE:
                found[label] = value, gain
    taken: dict[str, int] = {}
    out = []
    gains = [gain for _, gain in found.values()]
    for place in ranked([value for value, _ in found.values()]):
        gain = gains[place]
        effect = setting.wider[gain.members[0]].variant.effect
        taken[effect] = taken.get(effect, 0) + 1
        if taken[effect] <= _EFFORT.variants:
            out.append(gain)
    return out


def _other_noises(setting: Setting) -> Iterator[Noise]:
    """Noises to start a fit from beside the flexible one.

    Offsets of the runs can hide what goes with the input angle, so a fit is tried without them too.
    Play and friction of a torsion spring are as large as the angle itself, and through noise that
    is correlated along the run a fit may not find its way to them; so there the plain one as well.
    """
    if setting.flexible.offset_arcsec:
        yield replace(setting.flexible, offset_arcsec=0.0)
    if setting.fitter.campaign.drive.kind == "torsion_spring":
        yield setting.plain


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
