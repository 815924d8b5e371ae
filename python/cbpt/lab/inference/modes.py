"""Other solutions: the same effects at another phase, sign or size, or in another form.

with_modes  the best mode of the effects of a fit, with those as good in `other_modes`
with_shapes the best fit of its forms from every point at which their shapes are looked for
apart       whether two fits are two solutions, not one that was reached twice

Of a tilt, a pitch error or an offset the linear problem knows one phase; the readings may allow
several, each a peak of the likelihood with a small uncertainty of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter, Race
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.priors import Variant

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Search:
    """Where modes are looked for."""

    phases: int = 8
    sizes: tuple[float, ...] = (0.4, 1.0, 2.5)
    """Amplitudes to start from, of that which was found."""
    starts: int = 6
    polished_within: float = 8.0
    """In log odds, under the noise of the fit that is given: what is further off is not
    polished.
    """
    most: int = 8
    shapes: int = 12
    """Points at which the shapes of a form are looked for; of a form with more none is tried."""
    apart: float = 3.0
    """In standard uncertainties."""


_SEARCH = _Search()


def with_modes(
    fitter: Fitter,
    fit: Fit,
    within: float,
    forms: Sequence[Variant] = (),
    beside: Fit | None = None,
) -> Fit:
    """The best solution of the effects of a fit, over phases and forms, and other modes as good.

    within: log odds within which a mode is not excluded.
    forms: those to choose from; all of the library where empty.
    beside: a fit of other effects; no mode is of use that cannot come near it.
    """
    race = Race(fitter, fit.noise)
    if beside is not None:
        race.against(beside)
    rough: list[Fit] = []
    for variant in fit.hypothesis.variants:
        if variant.directed and fit.hypothesis.effects.count(variant.effect) == 1:
            rough += _rough(race, fit, variant, forms or fitter.variants)
    if not rough:
        return replace(fit, modes_searched=True)
    rough.sort(key=lambda f: -f.log_evidence)
    top = rough[0].log_evidence
    near = _distinct([f for f in rough if f.log_evidence > top - _SEARCH.polished_within])[
        : _SEARCH.most
    ]
    fine = (race.fit(f.hypothesis, f.point.values) for f in near)
    found = [fit, *(f for f in fine if f is not None and np.isfinite(f.log_evidence))]
    found.sort(key=lambda f: -f.log_evidence)
    best, *other_modes = _distinct(found)
    as_good = [f for f in other_modes if f.log_evidence > best.log_evidence - within]
    return replace(best, other_modes=tuple(as_good), modes_searched=True)


def with_shapes(fitter: Fitter, fit: Fit) -> Fit:
    """The best fit of the same forms from every point at which their shapes are looked for: from
    the one at which the linear problem sees most, a fit may end in a basin of its own."""
    race, found = Race(fitter, fit.noise), [fit]
    race.against(fit)
    for variant in fit.hypothesis.variants:
        at = [fitter.place(variant.effect, shape.name) for shape in variant.shapes]
        points = list(product(*(shape.grid for shape in variant.shapes)))
        for point in points if 1 < len(points) <= _SEARCH.shapes else ():
            start = fit.point.values.copy()
            start[at] = point
            got = race.fit(fit.hypothesis, start, free_noise=False)
            if got is not None and np.isfinite(got.log_evidence):
                found.append(got)
    best = max(found, key=lambda f: f.log_evidence)
    fine = None if best is fit else race.fit(best.hypothesis, best.point.values)
    return fit if fine is None or not fine.log_evidence > fit.log_evidence else fine


def _rough(race: Race, fit: Fit, variant: Variant, forms: Sequence[Variant]) -> Iterator[Fit]:
    """Under the noise of the fit, from the best starts of every form of one of its effects."""
    fitter = race.fitter
    at = [fitter.place(variant.effect, size) for size in variant.sizes]
    amplitude = max(float(np.linalg.norm(fit.point.values[at])), variant.low)
    for form in forms:
        if form.effect != variant.effect or not form.directed:
            continue
        hypothesis = Hypothesis(tuple(form if v is variant else v for v in fit.hypothesis.variants))
        # Of each phase the best size: one basin may hold the best starts of all.
        best: dict[float, tuple[float, Floats]] = {}
        for start, phase in _starts(fitter, fit, hypothesis, form, amplitude):
            misfit = fitter.misfit(hypothesis, start, fit.noise)
            if phase not in best or misfit < best[phase][0]:
                best[phase] = misfit, start
        starts = [s for _, s in sorted(best.values(), key=lambda b: b[0])[: _SEARCH.starts]]
        for start in [*starts, *_far(fitter, fit, hypothesis, form)]:
            got = race.fit(hypothesis, start, free_noise=False)
            if got is not None and np.isfinite(got.log_evidence):
                yield got


def _starts(
    fitter: Fitter, fit: Fit, hypothesis: Hypothesis, form: Variant, amplitude: float
) -> Iterator[tuple[Floats, float]]:
    """The values of the fit, but for the effect: that at all phases and some sizes; the phase."""
    base = _without(fitter, fit, hypothesis, form)
    at = [fitter.place(form.effect, size) for size in form.sizes]
    for phase in 2 * np.pi * np.arange(_SEARCH.phases) / _SEARCH.phases:
        for size in _SEARCH.sizes:
            values = base.copy()
            values[at] = size * amplitude * np.array([np.cos(phase), np.sin(phase)])
            yield values, float(phase)


def _without(fitter: Fitter, fit: Fit, hypothesis: Hypothesis, form: Variant) -> Floats:
    """The values of the fit, the effect at nothing."""
    kept = [u.index for u in fit.unknowns if u.name.partition(".")[0] != form.effect]
    base = fitter.start(hypothesis, {})
    base[kept] = fit.point.values[kept]
    return base


def _far(fitter: Fitter, fit: Fit, hypothesis: Hypothesis, form: Variant) -> Iterator[Floats]:
    """Of a form that does not grow in proportion to its size: the largest at which it is looked for
    as well. A basin of large sizes shows neither in the slopes at small ones nor by its misfit."""
    sizes = np.array(form.secants)
    if len(sizes):
        length = np.linalg.norm(sizes, axis=1)
        base = _without(fitter, fit, hypothesis, form)
        at = [fitter.place(form.effect, size) for size in form.sizes]
        for size in sizes[length > 0.99 * length.max()]:
            values = base.copy()
            values[at] = size
            yield values


def apart(one: Fit, other: Fit) -> bool:
    """Whether forms differ, or a size by more than its uncertainty lets it."""
    labels = [{v.label for v in f.hypothesis.variants} for f in (one, other)]
    if labels[0] != labels[1]:
        return True
    values = {u.name: (other.value(u), other.u(u)) for u in other.unknowns if u.size_of >= 0}
    return any(
        abs(one.value(u) - values[u.name][0])
        > _SEARCH.apart * np.hypot(one.u(u), values[u.name][1])
        for u in one.unknowns
        if u.size_of >= 0
    )


def _distinct(fits: list[Fit]) -> list[Fit]:
    """Those that are apart from all before them."""
    found: list[Fit] = []
    for fit in fits:
        if all(apart(fit, f) for f in found):
            found.append(fit)
    return found
