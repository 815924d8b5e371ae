"""What changed between two campaigns on the same reducer, or from level to level of a column.

change   a case, and readings before and after -> Change
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError, NoSolutionError, ReadingsError
from cbpt.lab.change.answer import Change
from cbpt.lab.change.counting import pattern_of
from cbpt.lab.change.demanded import demanded, not_of_all, support_of
from cbpt.lab.change.designs import note_on_rates, unlike_design
from cbpt.lab.change.loop_widths import LoopWidths, widths_of
from cbpt.lab.change.noise import noise_change
from cbpt.lab.change.odd_level import odd_level_of
from cbpt.lab.change.parameters import Held, by_itself, changed_of, differs, held_of, unchanged_of
from cbpt.lab.change.parties import EachAlone, Levels, levels_of
from cbpt.lab.change.posterior import Choice, Search, Weighed, choices_of, in_reach, weigh
from cbpt.lab.change.progress import part_of, rising, untold
from cbpt.lab.change.record import Changed, Kind
from cbpt.lab.change.reproducibility import (
    counted_by_repeats,
    counted_once,
    dispersed,
    dispersion_of,
    reproducibility_of,
    with_set_ups,
)
from cbpt.lab.change.rest import Rest, again, rest_of
from cbpt.lab.change.stand_ins import plausible, with_stand_ins
from cbpt.lab.change.text import unless_repeated
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.diagnosis.by_level import MOST_LEVELS
from cbpt.lab.diagnosis.diagnose import judged, prepared
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.diagnosis.fit_text import at_limits, beyond_own_loops
from cbpt.lab.inference.crew import side_by_side
from cbpt.lab.inference.residuals import rmse_of
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_terms import campaign_of, chosen
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.readings.readings import Readings
from cbpt.lab.selection.competition import Progress
from cbpt.lab.selection.history import notes_of_levels, with_their_history
from cbpt.lab.selection.posterior import named_of
from cbpt.lab.selection.rules import RULES
from cbpt.lab.wording.numbers import listed

__all__ = ["change"]

_DIAGNOSED, _FITTED, _WEIGHED, _OFFERED, _TRIED = 0.6, 0.7, 0.8, 0.85, 0.95
"""Shares of the work that are done after the diagnoses, after the fits of each level, after the
choices of what changed, and after the fits and the choices of other effects in its place."""

Given = str | os.PathLike[str] | Mapping[str, ArrayLike]


def change(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    before: Readings | Given,
    after: Readings | Given | None = None,
    *,
    by: str | None = None,
    effects: Sequence[str | OwnEffect] | None = None,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, Any] | None = None,
    reproducibility_arcsec: float | None = None,
    repeated: Sequence[Sequence[str]] = (),
    seed: int = 0,
    progress: Progress | None = None,
) -> Change:
    """Find out what changed between campaigns on the same reducer.

    One model stands for all campaigns. For each effect, and for each number of drive and rig, the
    evidence that it has one value is weighed against one value for each campaign.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`; the same before and after.
    before : Readings, str, PathLike, mapping or data frame
        The table of readings before, or the one table that `by` divides.
    after : Readings, str, PathLike, mapping or data frame, optional
        The table of readings after.
    by : str, optional
        A column of `before` in place of `after`: each of its values is a level, numbers in rising
        order and names in that of the
        table.
    effects : sequence of str or OwnEffect, optional
        Effects to fit at every level. Without it each level is diagnosed, and what any of them
        demands is fitted at all; of what some levels do not show together the effect that they
        demand least is left out, and a note says so.
    columns : mapping of str to str, optional
        What headers of the tables mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.
    reproducibility_arcsec : float, optional
        Standard deviation of the angle by which the rig differs when it is set up again and nothing
        was changed. Without it a new set-up changes nothing.
    repeated : sequence of sequences of str
        In place of that: levels of `by` that repeat one state, for example
        ``[("initial", "initial_repeated")]``; the reproducibility is estimated from them. Without
        both, a level whose name is that of another and `repeated` repeats it. Two tables say it by
        the names of their files, or by a column of words with one value in each.
    seed : int
        Seed of the diagnoses.
    progress : callable, optional
        Called as ``progress(what_is_next, share_done)``. What it raises ends the work.

    Returns
    -------
    Change
        The verdict, what changed and what did not, and whether the scatter changed.

    Raises
    ------
    CaseError, ReadingsError, InvalidInputError
        Case, table or an argument cannot be read.
    NoSolutionError
        The model has no solution with the same numbers at all levels.
    """
    if (after is None) == (by is None):
        raise InvalidInputError("after, by: give a second table, or a column, and not both")
    case, first = case_and_readings(case, before, columns, sheet, only, by)
    if by is not None:
        names, parts = _levels(first, by)
    else:
        assert after is not None
        second = case_and_readings(case, after, columns, sheet, only)[1]
        names, parts = ["before", "after"], [first, second]
    asked = repeated or reproducibility_arcsec is not None
    called = names if asked else _called(names, parts, by)
    named = [] if asked else _named_as_repeated(called)
    states = _states(called, named or repeated, reproducibility_arcsec)
    tell = rising(progress or untold)
    with one_blas_thread():
        asked_for, own = (None, []) if effects is None else chosen(case, effects)
        tell("friction from run to run", 0.0)
        levels = [None if by is None else f"{by} {name}" for name in names]
        ready = [_ready(case, *one, own) for one in zip(levels, parts, strict=True)]
        campaigns, histories = with_their_history([campaign for campaign, _ in ready], asked_for)
        of_levels = dict(zip(names, campaigns, strict=True))
        answers, ids = [], [asked_for or []]
        if asked_for is None:
            noted = [[*of, *told] for (_, of), told in zip(ready, histories, strict=True)]
            answers = _diagnosed(case, of_levels, noted, seed, tell)
            ids = demanded(answers)
        told = part_of(tell, _DIAGNOSED, _FITTED)
        candidates, left_out = _fitted(of_levels, ids, answers, told)
        if candidates and states:
            reproducibility_arcsec = _estimated(candidates, states)
        count = _counting(candidates, states, reproducibility_arcsec)
        weighed = _weighed(candidates, count, states, asked_for or (), tell)
    if weighed is None:
        raise NoSolutionError(
            "the model has no solution with the same numbers at all levels; compare each level "
            "with cbpt compare first"
        )
    loops = widths_of(parts, reproducibility_arcsec, states)
    rest = rest_of(weighed, comes_back=reproducibility_arcsec is None)
    answer = _answer(dict(zip(names, parts, strict=True)), weighed, rest, answers, by, loops)
    notes = [*left_out, *notes_of_levels(names, histories), *_notes(campaigns, weighed, named)]
    if answer.kind == "changed" and reproducibility_arcsec is None:
        notes.append(unless_repeated(_between_runs_arcsec(weighed.best.levels)))
    tell("the answer", 1.0)
    return replace(answer, reproducibility_arcsec=reproducibility_arcsec, notes=tuple(notes))


def _ready(
    case: Case | Drive, level: str | None, readings: Readings, own: Sequence[OwnEffect]
) -> tuple[Campaign, list[str]]:
    """The readings of one level that can be judged, and what was set aside; an error names it."""
    try:
        return prepared(campaign_of(case, readings, own))
    except ReadingsError as wrong:
        if level is None:
            raise
        path = f"{wrong.path}, {level}"
        raise ReadingsError(path, wrong.mistakes, wrong.place) from None


def _diagnosed(
    case: Case | Drive,
    campaigns: Mapping[str, Campaign],
    noted: Sequence[Sequence[str]],
    seed: int,
    tell: Progress,
) -> list[Diagnosis]:
    """The diagnoses of all levels, with what was noted of each."""
    answers = []
    for k, ((name, campaign), notes) in enumerate(zip(campaigns.items(), noted, strict=True)):
        begin, end = (_DIAGNOSED * i / len(campaigns) for i in (k, k + 1))
        told = part_of(tell, begin, end, f"diagnosis of {name}, ")
        answers.append(judged(case, campaign, seed, notes, told))
    return answers


def _forms(answers: Sequence[Diagnosis]) -> set[str]:
    """The forms of effects in the probable combinations of the levels, by their labels."""
    return {
        variant.label
        for d in answers
        for row in d.combinations()
        if row.probability >= RULES.likely
        if (names := named_of(tuple(sorted(row.effects)))) in d.competition.fits
        for variant in d.competition.fits[names].hypothesis.variants
    }


def _fitted(
    campaigns: Mapping[str, Campaign],
    sets: Sequence[Sequence[str]],
    answers: Sequence[Diagnosis],
    tell: Progress,
) -> tuple[list[Levels], list[str]]:
    """Each set of effects at all levels, where all have a solution; and notes on effects that were
    left out: of what some levels do not show together, the one that the levels demand least.
    Without answers, the diagnoses of the levels, the effects were named, and stay."""
    forms, support = _forms(answers), support_of(answers)
    alone = EachAlone(list(campaigns.values()), {effect for ids in sets for effect in ids}, forms)
    found: dict[tuple[str, ...], Levels | None] = {}
    refused: dict[tuple[str, ...], str] = {}
    for k, ids in enumerate(map(tuple, sets)):
        while ids not in found:
            if ids not in refused:
                tell(f"fits with {listed(ids)}" if ids else "fits without effects", k / len(sets))
                try:
                    found[ids] = alone.levels_of(ids)
                    break
                except (InvalidInputError, ReadingsError) as why:
                    refused[ids] = _refused(campaigns, ids, forms, why, bool(answers))
            least = min(ids, key=lambda effect: support.get(effect, 0.0))
            ids = tuple(effect for effect in ids if effect != least)
    fitted = {effect for ids in found for effect in ids}
    notes = [
        f"{told}; left out at all levels: {listed(out)}"
        for ids, told in refused.items()
        if (out := [effect for effect in ids if effect not in fitted])
    ]
    notes += [
        f"{effect} is not fitted: readings of a level demand it, and the table of another one has "
        "no column that shows it"
        for effect in not_of_all(answers)
    ]
    return [levels for levels in found.values() if levels is not None], notes


def _refused(
    campaigns: Mapping[str, Campaign],
    ids: Sequence[str],
    forms: Collection[str],
    why: InvalidInputError | ReadingsError,
    may_leave_out: bool,
) -> str:
    """What to say of a set of effects that some levels do not show together, or each otherwise.
    Raises what told so where the effects were named, and no level shows them or a table lacks a
    column."""
    blind = [name for name, one in campaigns.items() if not _shows(one, ids, forms)]
    named = not may_leave_out
    if named and (len(blind) in (0, len(campaigns)) or isinstance(why, ReadingsError)):
        raise why
    if not blind:
        return f"the columns that show {listed(ids)} are not in all tables"
    told = f"{listed(blind)}: the readings do not show {listed(ids)} together"
    if named:
        raise InvalidInputError(
            f"{told}, which others show, so whether they changed cannot be told ({why}); load "
            f"{'it' if len(blind) == 1 else 'them'} as the others, or name effects to fit"
        ) from why
    return told


def _shows(campaign: Campaign, effects: Sequence[str], forms: Collection[str]) -> bool:
    """Whether some effects can be fitted to a level alone."""
    with suppress(InvalidInputError, ReadingsError):
        return levels_of([campaign], effects, forms) is not None
    return False


def _between_runs_arcsec(levels: Levels) -> float | None:
    """The most that readings of a level differ by from run to run with the same torques; None where
    no runs repeat each other."""
    return max((a.scatter_arcsec for a in again(levels) if a is not None), default=None)


def _called(names: Sequence[str], parts: Sequence[Readings], by: str | None) -> Sequence[str]:
    """What the levels are called: of two tables their files or what a column of words says of all
    their readings, where one of these names repeats the other."""
    if by is not None:
        return names
    files = [Path(part.source).stem for part in parts]
    columns = [
        [part.labels[column][0] for part in parts]
        for column in parts[0].labels
        if all(len(set(part.labels.get(column, np.empty(0)).tolist())) == 1 for part in parts)
    ]
    return next((c for c in (files, *columns) if _named_as_repeated(c)), names)


def _named_as_repeated(names: Sequence[str]) -> list[list[str]]:
    """Levels that repeat another by their names: `initial` and `initial_repeated`."""
    found: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        state = re.sub(r"[\s_.(-]+repeated\W*$", "", name, flags=re.IGNORECASE)
        found.setdefault(state if state in names else name, []).append(name)
    return [levels for levels in found.values() if len(levels) > 1]


def _states(
    names: Sequence[str], repeated: Sequence[Sequence[str]], stated_arcsec: float | None
) -> list[list[int]]:
    """The places of levels that repeat one state."""
    if stated_arcsec is not None and not (np.isfinite(stated_arcsec) and stated_arcsec >= 0):
        raise InvalidInputError(
            f"reproducibility_arcsec = {stated_arcsec}: expected a finite number not less than 0"
        )
    if repeated and stated_arcsec is not None:
        raise InvalidInputError("reproducibility_arcsec, repeated: give one of them")
    for level in (level for state in repeated for level in state):
        if level not in names:
            raise InvalidInputError(f"repeated: no level {level!r}; the levels are {listed(names)}")
    if any(len(set(state)) < 2 for state in repeated):
        raise InvalidInputError("repeated: a state needs two different levels or more")
    return [[names.index(level) for level in dict.fromkeys(state)] for state in repeated]


def _counting(
    candidates: Sequence[Levels], states: Sequence[Sequence[int]], stated_arcsec: float | None
) -> Callable[[Levels], Levels]:
    """How the readings of levels count: for less by what repeated levels differ, else by the
    pattern of what the fits leave, and with what a new set-up changes where that is stated."""
    if not candidates:
        return lambda levels: levels
    if states:
        phi = max(dispersion_of(levels, states) for levels in candidates)
        return partial(dispersed, phi=phi)
    phi = pattern_of(candidates)
    if not stated_arcsec:
        return partial(dispersed, phi=phi)
    return lambda levels: with_set_ups(dispersed(levels, phi), stated_arcsec)


def _searched(
    candidates: Sequence[Levels],
    count: Callable[[Levels], Levels],
    tell: Progress,
    beside: Choice | None = None,
) -> list[Choice]:
    """What may have changed, by every set of effects that may hold the best answer."""
    counted = [count(levels) for levels in candidates]
    searched = in_reach([levels for levels in counted if not levels.choices])
    searched += [Search(levels, beside) for levels in counted if levels.choices]
    if not searched:
        return []
    share = 1 / len(searched)
    works = [
        partial(search.choices, part_of(tell, k * share, (k + 1) * share))
        for k, search in enumerate(searched)
    ]
    campaign = searched[0].levels.parties[0].problem.campaign
    return [choice for found in side_by_side(campaign, works) for choice in found]


def _weighed(
    candidates: Sequence[Levels],
    count: Callable[[Levels], Levels],
    states: Sequence[Sequence[int]],
    named: Collection[str],
    tell: Progress,
) -> Weighed | None:
    """What may have changed by every set of effects and, where something did, by what may stand in
    its place; effects that were named stay. states: places of levels that repeat one state; what a
    new set-up changes is known from them."""
    weighed = _searched_through(candidates, count, named, tell)
    if weighed is None:
        return None
    return counted_by_repeats(weighed, states) if states else counted_once(weighed)


def _searched_through(
    candidates: Sequence[Levels],
    count: Callable[[Levels], Levels],
    named: Collection[str],
    tell: Progress,
) -> Weighed | None:
    choices = _searched(candidates, count, part_of(tell, _FITTED, _WEIGHED))
    weighed = weigh(choices)
    if weighed is None or weighed.something < RULES.certain:
        return weighed
    offered = with_stand_ins(weighed, named, part_of(tell, _WEIGHED, _OFFERED))
    more = _searched(offered, count, part_of(tell, _OFFERED, _TRIED), weighed.best)
    every = [*choices, *filter(plausible, more)]
    return weigh(_searched_whole(every, part_of(tell, _TRIED, 1.0)))


def _searched_whole(found: Sequence[Choice], tell: Progress) -> list[Choice]:
    """What stands in is tried beside what seemed to have changed without it. Where that is the most
    probable, anything of its set may have changed, and all that may is searched."""
    best = max(found, key=lambda choice: choice.log_odds)
    if not best.levels.choices:
        return list(found)
    whole = choices_of(replace(best.levels, choices=()), tell)
    rest = [choice for choice in found if choice.levels is not best.levels]
    return [*rest, *filter(plausible, whole)]


def _estimated(candidates: Sequence[Levels], states: Sequence[Sequence[int]]) -> float:
    """The reproducibility by the set of effects that comes first."""
    found = reproducibility_of(candidates[0], states)
    if found is None:
        raise NoSolutionError(
            "the model of one repeated level has no solution under the loads of the other; state "
            "reproducibility_arcsec instead"
        )
    return found


def _notes(
    campaigns: Sequence[Campaign], weighed: Weighed, named: Sequence[Sequence[str]]
) -> Iterator[str]:
    """What the smaller loops of the levels say of their plays, and numbers that end at a limit,
    once each; which levels repeat a state by their names."""
    fits = weighed.best.levels.fits
    told = (
        note
        for campaign, fit in zip(campaigns, fits, strict=True)
        for note in (*beyond_own_loops(campaign, fit), *at_limits(campaign, fit))
    )
    yield from dict.fromkeys(told)
    yield from note_on_rates([campaign.readings for campaign in campaigns])
    files = [campaign.readings.sha256 for campaign in campaigns]
    angles = [campaign.readings.elastic_angle_arcsec for campaign in campaigns]
    if len(set(files)) < len(files) and all(np.array_equal(a, angles[0]) for a in angles):
        yield "the tables are the same readings, so nothing can have changed between them"
    if named:
        yield f"by their names {'; '.join(map(listed, named))} repeat one state"


def _levels(readings: Readings, by: str) -> tuple[list[str], list[Readings]]:
    """Numbers in rising order, names in that of the table."""
    labels = readings.labels[by]
    names = list(dict.fromkeys(labels.tolist()))
    if not 2 <= len(names) <= MOST_LEVELS:
        raise InvalidInputError(
            f"by = {by!r}: found {len(names)} different value{'s' * (len(names) != 1)}, expected "
            f"2 to {MOST_LEVELS}; take a column that says which state each reading is of"
        )
    with suppress(ValueError):
        names.sort(key=float)
    return names, [readings.select(labels == name) for name in names]


# --- the answer ---------------------------------------------------------------------------


def _told(
    weighed: Weighed, changed: Sequence[Changed], rest: Rest
) -> tuple[list[Changed], set[str]]:
    """What of the changes is told, and what is hidden by what the effects leave or by runs that
    differ. An effect of which no number moved is one of those: beside such a rest by its values,
    else by what they differ by, which may be known better than each of them."""
    still = {
        c.effect
        for c in changed
        if not c.moved
        and (rest.not_followed_arcsec or not differs(weighed.best_with(c.effect), c.effect))
    }
    still -= {c.effect for c in changed if c.moved}
    hidden = {*rest.hidden, *still}
    doubtful = {*rest.runs_differ, *still}

    def is_told(c: Changed) -> bool:
        """Of a group, those of which numbers moved, alike in all runs, must be certain alone."""
        group = {c.along or c.effect, *c.rivals}
        alone = not c.rivals or weighed.of_any(group - doubtful) >= RULES.certain
        return alone and not group <= hidden

    told = [c for c in changed if is_told(c)]
    hidden |= {c.effect for c in changed if not is_told(c)}
    # One of a group that is told is not said to be too small.
    return told, hidden - {c.effect for c in told}


def _not_shown(
    held: Sequence[Held], changed: Sequence[Changed], names: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Levels that say nothing of what another one shows, by the effect, unless it is told."""
    told = {c.effect for c in changed}
    of = [h for h in held if h.not_shown and h.number.effect not in told]
    return {h.number.effect: tuple(names[k] for k in h.not_shown) for h in of}


def _most_left(answers: Sequence[Diagnosis], rmse_arcsec: Sequence[float]) -> dict[str, Any] | None:
    """The rest of the level where most is left; none of a level is one that the effects of all
    levels follow."""
    of_levels = zip([d.remains() for d in answers], rmse_arcsec, strict=False)
    remains = [left for left, rmse in of_levels if left is not None and left["rms_arcsec"] <= rmse]
    return max(remains, key=lambda left: left["rms_arcsec"], default=None)


def _answer(
    parts: Mapping[str, Readings],
    weighed: Weighed,
    rest: Rest,
    answers: Sequence[Diagnosis],
    by: str | None,
    loops: tuple[LoopWidths, ...],
) -> Change:
    something, levels, names = weighed.something, weighed.best.levels, list(parts)
    tables = [party.problem.campaign.readings for party in levels.parties]
    rmse_arcsec = tuple(
        rmse_of(p.problem.campaign, f) for p, f in zip(levels.parties, levels.fits, strict=True)
    )
    kind: Kind = "undecided"
    if something >= RULES.certain and not rest.hides_all:
        kind = "changed"
    elif something < RULES.undecided and not any(widths.may_differ for widths in loops):
        kind = "nothing"
    changed = changed_of(weighed, rest.is_law) if kind == "changed" else []
    changed, hidden = _told(weighed, changed, rest)
    unlike = unlike_design(list(parts.values())) if kind == "changed" else ""
    if kind == "changed" and (unlike or (hidden and not changed)):
        kind, changed = "undecided", []
    held = held_of(weighed) if kind != "undecided" else []
    # What the effects do not follow may hide a change of any number, or take its place.
    told = unchanged_of(weighed, held) if not rest.not_followed_arcsec else []
    not_shown = _not_shown(held, changed, names)
    noise = noise_change(tables, levels.fits)
    odd_level = odd_level_of(levels, noise.u_arcsec) if kind == "nothing" else None
    differs = rest.differs_arcsec if kind == "nothing" else None
    if kind == "nothing" and (not_shown or odd_level or differs):
        kind = "undecided"
    return Change(
        kind=kind,
        changed=tuple(changed),
        unchanged=() if odd_level else tuple(told),
        probability=1 - something if kind == "nothing" else something,
        noise=noise,
        remains=_most_left(answers, rmse_arcsec),
        levels=tuple(names),
        readings=tuple(parts.values()),
        rmse_arcsec=rmse_arcsec,
        not_followed_arcsec=rest.not_followed_arcsec,
        moves_arcsec=rest.moves_arcsec,
        told_from_arcsec=rest.told_from_arcsec,
        hidden=tuple(e for e in rest.moves_arcsec if e in hidden),
        runs_differ=tuple(e for e in rest.runs_differ if e in hidden),
        on_large_loops=tuple(e for e in rest.on_large_loops if e in hidden),
        levels_differ_by_arcsec=rest.apart_arcsec if something >= RULES.certain else None,
        effects=tuple(dict.fromkeys(v.effect for v in levels.variants)),
        by=by,
        weighed=weighed,
        by_itself=tuple(by_itself(levels, rest.is_law)),
        loops=loops,
        not_shown=not_shown,
        odd_level=odd_level,
        rests_differ_arcsec=differs,
        unlike_design=unlike,
    )
