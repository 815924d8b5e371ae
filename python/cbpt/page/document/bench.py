"""Any combination of effects fitted quickly, by starting from what is fitted already.

    Bench   a fitter with the fits that it has made; the diagnosis' own, or one with own effects

A set grows from the best part of it that the diagnosis fitted, one effect after the other, each in
the form and from the sizes that the linear problem finds best: a fraction of a second, where the
search of the diagnosis weighs all forms. One noise judges all, that of the answer. The effects are
added in an order of their own, the likeliest first, so the fit of a set is the same, to the last
bit, whatever was asked for before it.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import OwnEffect
from cbpt.errors import InvalidInputError
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.diagnosis.diagnosis_data import finished
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.selection.linear_screen import Gain, Screen, Signature, Signatures, Stack
from cbpt.lab.selection.setting import Names
from cbpt.lab.selection.starts import places, start_values

Floats = NDArray[np.float64]
# Starts that are tried for an effect of the user's own, of which nothing is known.
_STARTS = 3
_TIMID, _NO_WORSE = 0.02, 1.02


# Fits that are kept: what has grown can be grown again.
_MOST_KEPT = 48


class Bench:
    """Fits of one campaign, by sorted ids of effects.

    fits: what is fitted already. likeliest: effects in the order in which sets grow. library: the
    bench that fits the sets without an effect of the user's own, where this one has such effects.
    """

    def __init__(
        self,
        fitter: Fitter,
        noise: Noise,
        fits: Mapping[Names, Fit],
        likeliest: Sequence[str] = (),
        library: Bench | None = None,
    ) -> None:
        self.fitter, self.noise, self.fits = fitter, noise, dict(fits)
        self._places = places(fitter)
        self._likeliest = {effect: place for place, effect in enumerate(likeliest)}
        self._library = library
        self._kept: OrderedDict[Names, Fit] = OrderedDict()

    @classmethod
    def of_diagnosis(cls, d: Diagnosis) -> Bench:
        """With everything that was fitted."""
        c = d.competition
        alone = sorted((n for n in c.fits if len(n) == 1), key=lambda n: -c.log_odds[n])
        fits = {names: d.fit_of(names) for names in c.fits}
        return cls(c.fitter, d.noise, fits, [effect for (effect,) in alone])

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
        return Bench(fitter, self.noise, {(): null}, library=self)

    def fit(self, effects: Sequence[str]) -> Fit:
        """The fit of a set. Raises `InvalidInputError` for what cannot be fitted."""
        names = tuple(sorted(dict.fromkeys(effects)))
        known = self.fits.get(names)
        if known is not None:
            return known
        if names not in self._kept:
            self._kept[names] = finished(self.fitter, self._grown(names), self.noise)
            if len(self._kept) > _MOST_KEPT:
                self._kept.popitem(last=False)
        self._kept.move_to_end(names)
        return self._kept[names]

    def _grown(self, names: Names) -> Fit:
        """From the largest and best part that is fitted, by the least likely effect last."""
        if self._library is None:
            parts = [n for n in self.fits if set(n) <= set(names)]
            base = max(parts, key=lambda n: (len(n), self.fits[n].log_evidence))
        else:
            own = {v.effect for v in self.fitter.campaign.candidates}
            base = tuple(n for n in names if n not in own)
            if base == names:
                return self._adopted(names, self._library.fit(names))
        last = max(
            (n for n in names if n not in base),
            key=lambda n: (self._likeliest.get(n, len(self._likeliest)), n),
        )
        return self._with(self.fit([n for n in names if n != last]), last)

    def _adopted(self, names: Names, found: Fit) -> Fit:
        """A set fitted from where another bench has it."""
        values = self.fitter.start(found.hypothesis, {})
        for unknown in found.unknowns:
            effect, dot, name = unknown.name.partition(".")
            if not dot:
                variant = next(v for v in self.fitter.variants if v.effect == effect)
                name = variant.sizes[0]
            values[self.fitter.place(effect, name)] = found.value(unknown)
        return self._polished(found.hypothesis, values)

    def _with(self, base: Fit, effect: str) -> Fit:
        """A fit with one more effect."""
        fitter = self.fitter
        variants = [v for v in fitter.variants if v.effect == effect]
        if not variants:
            raise InvalidInputError(f"{effect} cannot be fitted to these readings")
        look = replace(fitter.look(base, self.noise), discrepancy_sd=0.0)
        # What is there already has to be in the model that the slopes are taken of.
        there = [replace(v, shapes=(), secants=()) for v in base.hypothesis.variants]
        library = Signatures(fitter.campaign, [*variants, *there])
        signatures: list[Signature] = []
        gains: list[Gain] = []
        # A start needs the changes up to finite sizes only where the slopes show nothing.
        for secants in (False, True):
            if not gains:
                seen = library.about(look, self._places, secants)
                signatures = [s for s in seen if s.variant.effect == effect]
                screen = Screen(look, Stack(signatures))
                usable = [m for m in range(len(signatures)) if screen.usable[m]]
                gains = sorted((screen.single(m) for m in usable), key=lambda g: -g.log_odds)
        if not gains:
            raise InvalidInputError(
                f"{effect} cannot be fitted: the computed angles of these readings do not depend "
                "on it"
            )
        own = effect in fitter.campaign.own
        best: Fit | None = None
        for gain in gains[: _STARTS if own else 1]:
            signature = signatures[gain.members[0]]
            hypothesis = Hypothesis((*base.hypothesis.variants, signature.variant))
            # From a start that is too bold the search is long, and may end worse than it was
            # without. A lot of balls starts from equal ones, whatever their sizes.
            shares = (1.0,) if signature.variant.spread else (1.0, _TIMID)
            starts = [
                start_values(fitter, [signature], share * gain.sizes, base) for share in shares
            ]
            for start in sorted(starts, key=lambda s: self._misfit(hypothesis, s)):
                found = self._polished(hypothesis, start)
                if best is None or found.margin.chi2 < best.margin.chi2:
                    best = found
                if best.margin.chi2 < _NO_WORSE * look.margin.chi2:
                    break
        assert best is not None
        return best

    def _misfit(self, hypothesis: Hypothesis, start: Floats) -> float:
        return self.fitter.misfit(hypothesis, start, self.noise)

    def _polished(self, hypothesis: Hypothesis, start: Floats) -> Fit:
        """A choice of the user's is followed to its end however bad it is."""
        found = self.fitter.fit(hypothesis, start, self.noise, free_noise=False)
        if found is None:
            names = " + ".join(hypothesis.effects)
            raise InvalidInputError(f"{names}: with this the model has no solution at these loads")
        return found
