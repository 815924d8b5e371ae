"""Any combination of effects fitted quickly, by starting from what is fitted already.

    Bench   a fitter with the fits that it has made; the diagnosis' own, or one with own effects

A set grows from the best fit of a part of it, one effect after the other, each in the form and from
the sizes that the linear problem finds best: a fraction of a second, where the search of the
diagnosis weighs all forms. One noise judges all, that of the answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import OwnEffect
from cbpt.errors import InvalidInputError
from cbpt.lab.answer import Diagnosis
from cbpt.lab.assembled import Campaign
from cbpt.lab.competition import Names, places, start_values
from cbpt.lab.fit import Fit, Fitter, Hypothesis
from cbpt.lab.noise import Noise
from cbpt.lab.own import campaign_of
from cbpt.lab.screen import Gain, Screen, Signature, Signatures

Floats = NDArray[np.float64]
# Starts that are tried for an effect of the user's own, of which nothing is known.
_STARTS = 3
_TIMID, _NO_WORSE = 0.02, 1.02


class Bench:
    """Fits of one campaign, by sorted ids of effects."""

    def __init__(self, fitter: Fitter, noise: Noise, fits: dict[Names, Fit]) -> None:
        self.fitter, self.noise, self.fits = fitter, noise, fits
        self._names = places(fitter)
        self._searched: set[Names] = set()

    @classmethod
    def of_diagnosis(cls, d: Diagnosis) -> Bench:
        """With everything that was fitted."""
        return cls(d.competition.fitter, d.noise, dict(d.competition.fits))

    def with_own(self, d: Diagnosis, own: Sequence[OwnEffect]) -> Bench:
        """The same readings with effects of the user's own beside the library.

        Raises `InvalidInputError` and `ReadingsError` for one that cannot be fitted.
        """
        c = d.competition.campaign
        new = campaign_of(d.case, c.readings, own)
        campaign: Campaign = replace(
            c, own=c.own | new.own, effects=new.effects, candidates=new.candidates
        )
        fitter = Fitter(campaign)
        null = fitter.fit(Hypothesis(), noise=self.noise, free_noise=False)
        if null is None:
            raise InvalidInputError("the model has no solution at these loads")
        return Bench(fitter, self.noise, {(): null})

    def adopt(self, names: Names, other: Bench) -> None:
        """Fit a set from where another bench has it."""
        found = other.fits[names]
        values = self.fitter.start(found.hypothesis, {})
        for unknown in found.unknowns:
            effect, dot, name = unknown.name.partition(".")
            if not dot:
                variant = next(v for v in self.fitter.variants if v.effect == effect)
                name = variant.sizes[0]
            values[self.fitter.place(effect, name)] = found.value(unknown)
        self.fits[names] = self._polished(found.hypothesis, values)

    def fit(self, effects: Sequence[str]) -> Fit:
        """The fit of a set. Raises `InvalidInputError` for what cannot be fitted."""
        names = tuple(sorted(dict.fromkeys(effects)))
        if names in self.fits:
            return self._ended(names)
        known = [n for n in self.fits if set(n) <= set(names)]
        reached = max(known, key=lambda n: (len(n), self.fits[n].log_evidence))
        fit = self.fits[reached]
        for effect in (n for n in effects if n not in reached):
            fit = self._with(fit, effect)
            reached = tuple(sorted((*reached, effect)))
            self.fits[reached] = fit
        return fit

    def _ended(self, names: Names) -> Fit:
        """A fit that the diagnosis left as it was out is searched further, once."""
        fit = self.fits[names]
        if not fit.converged and names not in self._searched:
            self._searched.add(names)
            found = self._polished(fit.hypothesis, fit.point.values)
            self.fits[names] = self.fitter.look(replace(found, form_sd=fit.form_sd), self.noise)
        return self.fits[names]

    def _with(self, base: Fit, effect: str) -> Fit:
        """A fit with one more effect."""
        fitter = self.fitter
        variants = [v for v in fitter.variants if v.effect == effect]
        if not variants:
            raise InvalidInputError(f"{effect}: it cannot be fitted to these readings")
        look = replace(fitter.look(base, self.noise), form_sd=0.0)
        # What is there already has to be in the model that the slopes are taken of.
        there = [replace(v, shapes=(), secants=()) for v in base.hypothesis.variants]
        library = Signatures(fitter.campaign, [*variants, *there])
        signatures: list[Signature] = []
        gains: list[Gain] = []
        # A start needs the changes up to finite sizes only where the slopes show nothing.
        for secants in (False, True):
            if not gains:
                seen = library.about(look, self._names, secants)
                signatures = [s for s in seen if s.variant.effect == effect]
                screen = Screen(look, signatures)
                usable = [m for m in range(len(signatures)) if screen.usable(m)]
                gains = sorted((screen.single(m) for m in usable), key=lambda g: -g.log_odds)
        if not gains:
            raise InvalidInputError(f"{effect}: these readings do not depend on it")
        own = effect in fitter.campaign.own
        best: Fit | None = None
        for gain in gains[: _STARTS if own else 1]:
            variant = signatures[gain.members[0]].variant
            hypothesis = Hypothesis((*base.hypothesis.variants, variant))
            # From a start that is too bold the search is long, and may end worse than it was
            # without.
            starts = [
                start_values(fitter, signatures, gain.members, share * gain.sizes, base)
                for share in (1.0, _TIMID)
            ]
            for start in sorted(starts, key=lambda s: fitter.misfit(hypothesis, s, self.noise)):
                found = self._polished(hypothesis, start)
                if best is None or found.margin.chi2 < best.margin.chi2:
                    best = found
                if best.margin.chi2 < _NO_WORSE * look.margin.chi2:
                    break
        assert best is not None
        return best

    def _polished(self, hypothesis: Hypothesis, start: Floats) -> Fit:
        """A choice of the user's is followed to its end however bad it is."""
        hopeless = self.fitter.hopeless
        try:
            self.fitter.hopeless = np.inf
            found = self.fitter.fit(hypothesis, start, self.noise, free_noise=False)
        finally:
            self.fitter.hopeless = hopeless
        if found is None:
            names = " + ".join(hypothesis.effects)
            raise InvalidInputError(f"{names}: the model has no solution with it at these loads")
        return found
