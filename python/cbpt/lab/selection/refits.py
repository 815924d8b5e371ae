"""What is asked of single fits, and tasks for a crew that fit again.

fitting       a fit from some values
ranking       the same, to be ranked among many: its search ends earlier
again         the same effects from their values, under another noise
modes_of      the best mode of the effects of a fit
shapes_of     the best of its forms, wherever their shapes are looked for
in_usual_forms  a set with a rarer form in the usual one
without_idle  a fit without the effects that it put to nothing
follows       how well a fit follows the readings
kind_of       what a noise has that a fit keeps to
is_odd, stripped  whether it has what an instrument does, or loose readings; one without these
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import log_scale_prior, price_of
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.crew import Task
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.inference.modes import with_modes, with_shapes
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import Variant
from cbpt.lab.selection.rules import RULES

Floats = NDArray[np.float64]


def fitting(hypothesis: Hypothesis, start: Floats, noise: Noise) -> Task[Fit | None]:
    """A fit from some values."""
    return lambda fitter: fitter.fit(hypothesis, start, noise)


def ranking(hypothesis: Hypothesis, start: Floats, noise: Noise) -> Task[Fit | None]:
    """A fit from some values, to be ranked among many: its search ends earlier."""
    return lambda fitter: fitter.roughly().fit(hypothesis, start, noise)


def again(fit: Fit, noise: Noise) -> Task[Fit | None]:
    """The same effects from their values, under another noise."""
    return fitting(fit.hypothesis, fit.point.values, noise)


def modes_of(fit: Fit, forms: Sequence[Variant] = (), beside: Fit | None = None) -> Task[Fit]:
    """The best mode of the effects of a fit, in these forms or any, that may come near another."""
    return lambda fitter: with_modes(fitter, fit, RULES.log_rival_odds, forms, beside)


def shapes_of(fit: Fit) -> Task[Fit]:
    """The best of its forms from every point at which their shapes are looked for."""
    return lambda fitter: with_shapes(fitter, fit)


def in_usual_forms(fitter: Fitter, fit: Fit) -> Iterator[Task[Fit | None]]:
    """A set with a rarer form in the usual one, beside the effect that does the same: which of both
    it is, their odds alone tell."""
    for rare in fit.hypothesis.variants:
        instead = dict(rare.instead)
        usual = next((v for v in fitter.variants if v.effect == rare.effect and v.odds >= 1), None)
        for shape, (effect, size) in instead.items():
            other = next((v for v in fitter.variants if v.effect == effect), None)
            if usual is None or other is None:
                continue
            rest = [v for v in fit.hypothesis.variants if v not in (rare, other)]
            start = fitter.start(Hypothesis((usual, other, *rest)), {})
            place, neutral = fitter.place(rare.effect, shape), fitter.neutral(rare.effect, shape)
            kept = [u.index for u in fit.unknowns if u.index != place]
            start[kept] = fit.point.values[kept]
            start[fitter.place(effect, size)] += fit.point.values[place] - neutral
            yield fitting(Hypothesis((usual, other, *rest)), start, fit.noise)


def kind_of(noise: Noise) -> tuple[bool, bool, str]:
    """What there is beside a scale, a correlation and offsets of runs, which every fit finds."""
    artefact = noise.artefact.kind if noise.artefact else ""
    return noise.torque_arcsec is not None, noise.inflation is not None, artefact


def is_odd(noise: Noise) -> bool:
    """Whether it has what an instrument does, or loose readings."""
    return noise.has_artefact or noise.inflation is not None


def stripped(noise: Noise, campaign: Campaign) -> Noise:
    """A noise without these."""
    return replace(noise, artefact=campaign.known_errors, inflation=None)


def follows(fitter: Fitter, fit: Fit) -> float:
    """Log density of the readings at the mode, with what the noise and its scale cost."""
    scale = float(log_scale_prior(np.array(fit.noise.scale), fitter.stated_dof))
    return -0.5 * (fit.margin.chi2 + fit.whitener.log_det) - price_of(fit.noise) + scale


def without_idle(fitter: Fitter, fit: Fit | None) -> Fit | None:
    """A fit without the effects that it put to nothing: they are no part of what it found, but the
    noise may be."""
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
    return fitter.fit(Hypothesis(rest), fit.point.values, fit.noise)
