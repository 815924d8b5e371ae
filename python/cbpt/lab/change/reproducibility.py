"""How well a rig comes back to the same state when it is set up again.

with_set_ups        levels whose noise has what a new set-up changes
reproducibility_of  that, from levels that repeat one state
rms_arcsec          of angles, as the fit weighs them
moves_of            by how much the angles move with a change of one effect
with_values_of      the curve of a level with those of another one
places_of           where they stand
excludes            whether a level cannot have the values of another one
dispersed           levels whose readings count for less
dispersion_of       by how much, from levels that repeat one state
counted_once        an answer by evidence that counts runs which leave the same as one
counted_by_repeats  an answer by evidence that counts for less what repeated levels differ by

A repeated measurement on a real rig differs by more than readings scatter: the members lie a little
otherwise, grease and temperature are others. How levels differ is told by their fitted curves; by
the reproducibility a new set-up alone may move a level that way. It belongs to the noise of the
level, whatever changed; so a change counts only as far as it goes beyond it (a random effect of the
set-up in a mixed model). Slopes alone would not do: levels that lie far apart differ by what no sum
of slopes at one of them is. Nor may each number stand otherwise by itself: with many of them almost
any two curves would be the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.counting import design_effect
from cbpt.lab.change.loop_widths import ALIKE_WIDTHS
from cbpt.lab.change.parties import Levels
from cbpt.lab.change.posterior import Choice, Weighed, choices_of, groups_of, of_odds
from cbpt.lab.change.shared import Party, fit_shared
from cbpt.lab.inference.gauss_newton import Problem, point_at
from cbpt.lab.model.dataset import Campaign

Floats = NDArray[np.float64]


def with_set_ups(levels: Levels, arcsec: float) -> Levels:
    """The levels with a reproducibility of this standard deviation."""
    return replace(
        levels,
        parties=tuple(_with_set_up(party, levels.parties, arcsec) for party in levels.parties),
    )


def _with_set_up(party: Party, parties: Sequence[Party], arcsec: float) -> Party:
    plain = party.problem
    ways = [_way(party, other) for other in parties if other is not party]
    if not ways:
        return party
    columns = _freely(plain, np.column_stack(ways))
    size = np.sqrt(np.mean(columns**2, axis=0))
    seen = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    return _beside(party, columns[:, seen] * (arcsec / size[seen]))


def _beside(party: Party, set_up: Floats) -> Party:
    """A level with what a new set-up may add."""
    problem = party.problem.through(party.problem.whitener.beside(set_up))
    more = _log_volume(problem) - _log_volume(party.problem)
    return Party(problem, party.point, party.log_noise + more, set_up)


def dispersed(levels: Levels, phi: float) -> Levels:
    """The levels with likelihoods that are raised to the power 1/phi."""
    return replace(levels, parties=tuple(_dispersed(party, phi) for party in levels.parties))


def dispersion_of(levels: Levels, places: Sequence[Sequence[int]]) -> float:
    """By how much levels that repeat one state gain in misfit by values of their own, for each such
    value: 1 by noise alone (the dispersion phi of a quasi-likelihood; McCullagh and Nelder,
    Generalized Linear Models, 1989, section 4.5). It needs no size of what a set-up changes and no
    direction of it.
    """
    gained, numbers = 0.0, 0
    for state in places:
        repeats = replace(
            levels,
            parties=tuple(levels.parties[k] for k in state),
            fits=tuple(levels.fits[k] for k in state),
            choices=(),
        )
        choices = choices_of(repeats)
        if choices:
            shared = next(choice.fit.misfit for choice in choices if not choice.changed)
            gained += shared - min(choice.fit.misfit for choice in choices)
            numbers += len(levels.fits[0].unknowns) * (len(state) - 1)
    return max(gained / max(numbers, 1), 1.0)


def counted_once(weighed: Weighed) -> Weighed:
    """The choices near the best weighed again, with runs that leave the same counted as one.

    What comes again in k runs with the same torques is no more evidence than one of them: the
    likelihoods are raised to the power 1/d (`design_effect`). By the most probable answer, which
    leaves least: what a stand-in follows comes again too, and is evidence for it.
    """
    return _counted_for_less(weighed, design_effect(weighed.best.levels))


def counted_by_repeats(weighed: Weighed, states: Sequence[Sequence[int]]) -> Weighed:
    """The same by what levels that repeat one state still gain by values of their own in the most
    probable answer: effects that were found after the first sets may follow how they differ."""
    return _counted_for_less(weighed, dispersion_of(weighed.best.levels, states))


def _counted_for_less(weighed: Weighed, d: float) -> Weighed:
    """The choices near the best weighed again with likelihoods raised to the power 1/d."""
    if d <= 1:
        return weighed
    near = weighed.near(d)
    counted = {id(c.levels): dispersed(c.levels, d) for c in near}
    found: list[Choice] = []
    for c in near:
        of = counted[id(c.levels)]
        fit = fit_shared(of.parties, of.variants, c.fit.separate, c.fit.points, c.loose)
        if fit is not None and not (c.loose and fit.ends_at_limit(c.loose)):
            odds = c.log_odds + fit.log_evidence - c.fit.log_evidence
            found.append(replace(c, levels=of, fit=fit, log_odds=odds))
    return of_odds(found) if found else weighed


def _dispersed(party: Party, phi: float) -> Party:
    counted = party.problem
    problem = counted.under(counted.noise.sized(float(np.sqrt(phi))))
    if party.set_up is None:
        return Party(problem, party.point, party.log_noise / phi)
    of_set_up = _log_volume(counted) - _log_volume(counted.under(counted.noise))
    bare = Party(problem, party.point, (party.log_noise - of_set_up) / phi)
    return _beside(bare, party.set_up)


def reproducibility_of(levels: Levels, places: Sequence[Sequence[int]]) -> float | None:
    """Standard deviation in arcsec by which levels differ that repeat one state, each fitted by
    itself; None where that cannot be told. places: of the levels of each state."""
    squares, freedom = 0.0, 0
    for state in places:
        first, *others = (levels.parties[k] for k in state)
        curves = [first.point.angle_arcsec]
        for other in others:
            curve = _curve(first, other)
            if curve is None:
                return None
            curves.append(curve)
        free = _freely(first.problem, np.column_stack(curves))
        off = free - free.mean(axis=1, keepdims=True)
        squares += sum(rms_arcsec(first.problem.campaign, curve) ** 2 for curve in off.T)
        freedom += len(others)
    return float(np.sqrt(squares / freedom)) if freedom else None


def moves_of(choice: Choice, effect: str) -> float:
    """By how much levels differ by the change of an effect beyond what other numbers make up for:
    of the fitted angles, against those where it keeps one value at all levels, the standard
    deviation over levels in arcsec. Infinite where the model has no solution then, or the loops of
    one level exclude what another one has.

    What a change does by itself says little: two that cancel each other, a softer joint and a
    stiffer contact, each move the angles by far more than levels differ.
    """
    levels, fit = choice.levels, choice.fit
    if any(excludes(choice, effect, *pair) for pair in permutations(range(len(fit.slots)), 2)):
        return float("inf")
    kept = choice.beside(effect)
    fitted = partial(fit_shared, levels.parties, levels.variants, kept, loose=choice.loose & kept)
    found = [again for again in (fitted(start=fit.points), fitted()) if again is not None]
    if not found:
        return float("inf")
    without = min(found, key=lambda again: again.misfit)
    squares = 0.0
    for party, with_it, point in zip(levels.parties, fit.points, without.points, strict=True):
        moved = (with_it.angle_arcsec - point.angle_arcsec)[:, None]
        squares += rms_arcsec(party.problem.campaign, _freely(party.problem, moved)[:, 0]) ** 2
    return float(np.sqrt(squares / (len(fit.points) - 1)))


def with_values_of(choice: Choice, effect: str, level: int, other: int) -> Floats | None:
    """Angles at the loads of a level by its own values, and those of another level for one effect,
    arcsec; None without a solution."""
    problem, places = choice.levels.parties[level].problem, places_of(choice, effect)
    values = choice.fit.points[level].values.copy()
    values[places] = choice.fit.points[other].values[places]
    moved = point_at(problem.model, values, ())
    return None if moved is None else moved.angle_arcsec


def places_of(choice: Choice, effect: str) -> NDArray[np.int64]:
    """Where the numbers of an effect stand among the values of a point."""
    return np.asarray(choice.levels.parties[0].problem.index[list(choice.places_of(effect))])


def excludes(choice: Choice, effect: str, level: int, other: int) -> bool:
    """Whether a size of an effect is far beyond the limit of one level at the other one."""
    group = next(g for g in groups_of(choice.levels) if g.effect == effect)
    slots = choice.fit.slots[:, list(group.sizes)]
    values, most = choice.fit.x[slots[other]], choice.fit.bounds[1][slots[level]]
    return bool((values > ALIKE_WIDTHS * most).any())


def rms_arcsec(campaign: Campaign, values: Floats) -> float:
    """Root mean square over the readings, those of kinds of runs that scatter more counting for
    less, as in the fit."""
    return float(np.sqrt(np.average(values**2, weights=campaign.u_arcsec**-2.0)))


def _curve(party: Party, other: Party) -> Floats | None:
    """Angles at the loads of a level by the values of another, arcsec; None without a solution."""
    problem = party.problem
    values = party.point.values.copy()
    values[problem.index] = other.point.values[other.problem.index]
    point = point_at(problem.model, values, ())
    return None if point is None else point.angle_arcsec


def _way(party: Party, other: Party) -> Floats:
    """What leads from the fitted curve of a level to that of another: its beginning by the slopes,
    and their difference where the model has a solution there; shape (n, 1 or 2)."""
    problem = party.problem
    # Each by its own places: models of different tables need not have the same.
    far = other.problem.coordinates(other.point) - problem.coordinates(party.point)
    begun: Floats = problem.columns(party.point) @ (far / problem.unit)
    curve = _curve(party, other)
    if curve is None:
        return begun[:, None]
    return np.column_stack([begun, curve - party.point.angle_arcsec])


def _log_volume(problem: Problem) -> float:
    """What the covariance of the readings adds to the log evidence, offsets integrated out."""
    gram = problem.offsets.T @ problem.offsets
    return -0.5 * (problem.whitener.log_det + float(np.linalg.slogdet(gram)[1]))


def _freely(problem: Problem, columns: Floats) -> Floats:
    """Columns without what the offsets of the readings take up."""
    offsets = problem.campaign.offsets
    if not offsets.shape[1]:
        return columns
    basis = np.linalg.qr(offsets)[0]
    return np.asarray(columns - basis @ (basis.T @ columns))
