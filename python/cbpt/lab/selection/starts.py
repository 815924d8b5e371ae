"""Where a full fit starts: the sizes that the linear screen found, at their places in the model.

places        effect and parameter of each value of a model
start_values  the values to start a fit from
starts_at_once  the same for some effects together, in the forms that the screen favours
refitted      those with the unknowns of the fit that was screened where the sizes move them
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import solved
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.priors import LOT
from cbpt.lab.selection.linear_screen import Gain, Screen, Signature

Floats = NDArray[np.float64]


def places(fitter: Fitter) -> dict[int, tuple[str, str]]:
    """(effect, parameter) of each value; of a ball of a lot with its number, `3.oversize_m`."""
    found = {}
    for (instance, name), i in fitter.model.places.items():
        effect = fitter.effects[instance]
        number = instance - fitter.effects.index(LOT) if effect == LOT else 0
        found[i] = effect, f"{number}.{name}" if effect == LOT else name
    return found


def start_values(
    fitter: Fitter, signatures: Sequence[Signature], sizes: Floats, base: Fit | None = None
) -> Floats:
    """Values to start a fit of some signatures from, cut to what is plausible, shape (p,).

    A lot starts from equal balls: at the sizes of the linear problem some have lost touch, and from
    there the way may not lead back.

    Parameters
    ----------
    signatures: one of each effect.
    sizes: their sizes one after the other, as `Gain.sizes`.
    base: a fit whose values are kept for everything that it has.
    """
    hypothesis = Hypothesis(tuple(s.variant for s in signatures))
    given: dict[str, float] = {}
    at = 0
    for s in signatures:
        v = s.variant
        width = s.columns.shape[1]
        found = s.sizes(sizes[at : at + width])
        at += width
        if v.spread:
            continue
        for name, size, ratio in zip(
            v.sizes, found, v.ratios or (1.0,) * len(v.sizes), strict=True
        ):
            most = 0.5 * v.high * ratio
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


def starts_at_once(
    fitter: Fitter, signatures: Sequence[Signature], screen: Screen, effects: Sequence[str]
) -> list[tuple[Hypothesis, Floats]]:
    """Some effects in each choice of their forms, and where their fits begin; the most probable
    choice first, one with rarer forms behind all others, and none where the readings do not show
    them together. Far from where the fits end the linear problem cannot weigh a rarer form."""
    members = [
        [m for m, s in enumerate(signatures) if s.variant.effect == e and screen.usable[m]]
        for e in effects
    ]
    sets = np.array(list(product(*members)), dtype=np.int64).reshape(-1, len(effects))
    best: dict[tuple[str, ...], Gain] = {}
    for gain in sorted(screen.each(sets) if len(sets) else [], key=lambda g: -g.log_odds):
        labels = tuple(signatures[m].variant.label for m in gain.members)
        best.setdefault(labels, gain)
    found = []
    for gain in best.values():
        chosen = [signatures[m] for m in gain.members]
        hypothesis = Hypothesis(tuple(s.variant for s in chosen))
        found.append((hypothesis, start_values(fitter, chosen, gain.sizes)))
    return sorted(found, key=lambda start: sum(v.odds < 1 for v in start[0].variants))


def refitted(fitter: Fitter, seen: Fit, signatures: Sequence[Signature], values: Floats) -> Floats:
    """Start values with the unknowns of a fit at the minimum of its linear problem, once the
    signatures have the sizes that the values give them, shape (p,).

    The sizes of the linear problem are those beside unknowns that are fitted too: without that a
    fit begins far from where the linear problem ends.
    """
    taken = np.zeros(len(fitter.campaign))
    added = np.zeros(len(values))
    for s in signatures:
        if s.variant.spread:
            continue
        at = [fitter.place(s.variant.effect, size) for size in s.variant.sizes]
        added[at] = values[at] - fitter.model.neutral[at]
        taken += s.columns @ s.found(added[at])
    margin = seen.margin
    mode = solved(margin.factor, margin.x.T @ (margin.y - seen.whitener(taken)))
    values = values.copy()
    for u, units in zip(seen.unknowns, mode, strict=False):
        # The linear problem has what no prior holds as a step from where it is.
        here = u.mean if np.isfinite(u.sd) else seen.value(u)
        low, high = (np.log(u.lower), np.log(u.upper)) if u.log else (u.lower, u.upper)
        x = float(np.clip(here + u.unit * units, low, high))
        value = np.exp(x) if u.log else x
        # A number of the drive that is an effect too moves by both.
        value += added[u.index]
        values[u.index] = np.clip(value, fitter.model.lower[u.index], fitter.model.upper[u.index])
    return values
