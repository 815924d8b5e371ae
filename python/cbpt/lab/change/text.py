"""What changed, in words.

sentence           the verdict
headline_and_rest  the same in two parts
unless_repeated    the remedy where no state was measured twice
limited            a value that may end at a limit of its range
lines              the whole answer
"""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot, isfinite
from typing import NamedTuple

from cbpt.lab.change.loop_widths import LoopWidths
from cbpt.lab.change.record import Changed, ChangeData, Limit, Unchanged
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.selection.rules import RULES
from cbpt.lab.wording import layout
from cbpt.lab.wording.names import called
from cbpt.lab.wording.numbers import (
    ARCSEC,
    AngleUnit,
    in_words,
    listed,
    percent,
    probability,
    ratio_of,
)

_LISTED = 6
"""Levels whose values are all told."""
_AS_WELL = 0.5
"""Of what two uncertainties together make: a difference that is known better is told."""
_WAYS = {"up": "rose", "down": "fell", "new": "appeared", "gone": "is no longer seen"}


def sentence(found: ChangeData, angle: AngleUnit = ARCSEC) -> str:
    """The verdict in one paragraph."""
    return "".join(headline_and_rest(found, angle))


def headline_and_rest(found: ChangeData, angle: AngleUnit = ARCSEC) -> tuple[str, str]:
    """The verdict itself, and what belongs to it; the second is empty or begins with a space."""
    noise, within = _noise(found, angle), _within(found)
    if found.kind == "nothing":
        hidden = _hidden(found, angle)
        what = "Of what the model follows nothing" if found.not_followed_arcsec else "Nothing"
        return f"{what} changed ({_sure(found.probability)}).", hidden + noise + within
    if found.differing_loops is not None:
        head, rest = _loops_alone(found, angle, found.differing_loops)
        return head, rest + _by_itself(found, angle) + noise
    if found.nothing_shown:
        what = "the model follows" if found.beyond_the_model else f"{_all(found)} show"
        open_ = _odd_level(found, angle) + _rests_differ(found, angle) + _not_shown(found)
        return (
            f"Of what {what} nothing changed ({_sure(1 - found.probability)}).",
            f"{open_}{_hidden(found, angle)}{noise}{within}",
        )
    if found.moved_less_than_is_left:
        size = found.levels_differ_by_arcsec
        by = "" if size is None else f", and the angles with it by {angle.text(size)}"
        left = _rest(found, angle)
        left = f"{left} That may look like such a change." if left else ""
        remedy = " Name other effects to fit." if left else ""
        unlike = f" But {found.unlike_design}." if found.unlike_design else ""
        return "What changed cannot be told.", (
            f" By the fitted effects {listed(found.weighed.likely, 'or')} changed{by}."
            f"{unlike}{_runs(found)}{_large_loops(found)}{_still(found)}{left}"
            f"{_loops_differ(found, angle)}{remedy}{_by_itself(found, angle)}{noise}"
        )
    if found.kind == "undecided":
        loops = _loops_differ(found, angle)
        whose = "The fitted effects" if loops else "The readings"
        return (
            f"{whose} do not decide whether something changed ({_sure(found.probability)} that it "
            "did).",
            f"{loops}{_by_itself(found, angle)}{noise}",
        )
    rest = _unless(found, angle) + _not_shown(found) + _large_loops(found)
    rest += _hidden(found, angle) + noise + within
    return _changes(found, angle), rest


def _one(found: ChangeData) -> str:
    """What is compared."""
    return "table" if found.by is None else "level"


def _all(found: ChangeData) -> str:
    return "both tables" if found.by is None else "all levels"


def _loops_alone(found: ChangeData, angle: AngleUnit, loops: LoopWidths) -> tuple[str, str]:
    """That loops differ, and no fitted effect does."""
    sure = loops.differ is not None
    widths = _widths(found, angle, loops)
    return (
        f"The measured loops {'' if sure else 'may have '}changed: {widths}, and "
        f"loops of one {_one(found)} {'differ by less' if sure else 'hardly differ as much'}.",
        " The fitted effects cannot reproduce this (their verdict alone would be that nothing "
        f"changed, {_sure(1 - found.probability)}), so what changed cannot be told: look at the "
        f"loops of both {_one(found)}s, and name other effects to fit.",
    )


def _changes(found: ChangeData, angle: AngleUnit) -> str:
    """What changed. What else of an effect moved stands in the document."""
    events = [c for c in found.foremost if c.along is None]
    alone = sorted((c for c in events if not c.rivals), key=lambda c: c.probability < RULES.certain)
    told = [
        f"{'' if c.probability >= RULES.certain else 'possibly '}{_event(found, angle, c)}"
        for c in alone
    ]
    groups = {tuple(sorted((c.effect, *c.rivals))): c for c in events if c.rivals}
    for group in groups:
        each = [_event(found, angle, c) for c in events if c.effect in group]
        told.append(
            f"one of these changed, and the readings do not tell which: {'; or '.join(each)}"
        )
    if not told:
        return (
            f"Something changed ({_sure(found.probability)}), and the readings do not tell which "
            f"of {listed(found.weighed.likely, 'or')}.{_loops_differ(found, angle)}"
        )
    text = "; ".join(told) + "."
    return text[0].upper() + text[1:] if text.startswith(("one of", "possibly")) else text


def _event(found: ChangeData, angle: AngleUnit, c: Changed) -> str:
    """A change with its probability, and what changed by the same share with it."""
    along = [one for one in found.foremost if one.along == c.effect]
    told = ", together with ".join(_told(found, angle, one) for one in (c, *along))
    whose = "they changed, by the same share" if along else "it changed"
    return f"{told} ({_sure(c.probability)} that {whose})"


def _runs(found: ChangeData) -> str:
    """That runs of one level contradict each other."""
    if not found.runs_differ:
        return ""
    return (
        f" But runs of one {_one(found)} with the same torques do not agree on "
        f"{listed(found.runs_differ)}: they differ by as much. Look at the runs one by one, and "
        "repeat them."
    )


def _large_loops(found: ChangeData) -> str:
    """That small loops do not show a play."""
    if not found.on_large_loops:
        return ""
    return (
        " Friction holds the small loops, which turn by less than the fitted play, so that rests "
        "on the large loops alone and may stand for what else they show."
    )


def _still(found: ChangeData) -> str:
    """That the readings ask for other values of an effect, and these are as good as the same."""
    told = {*found.runs_differ, *found.on_large_loops}
    still = [e for e in found.hidden if e not in told]
    if not still or found.not_followed_arcsec:
        return ""
    return (
        f" But no number of {listed(still, 'or')} differs by more than twice its uncertainty: "
        "something that was not fitted may have changed in its place, or the first loops began "
        "otherwise. Name other effects to fit."
    )


def _hidden(found: ChangeData, angle: AngleUnit) -> str:
    """What the fitted effects do not follow, and what follows from it."""
    rest = _rest(found, angle)
    if not rest:
        return _runs(found) if found.kind == "changed" else ""
    moves = {e: angle.text(m) for e, m in found.moves_arcsec.items() if isfinite(m)}
    each = [f"{e} (moves the angles by {moves[e]}, rms)" if e in moves else e for e in found.hidden]
    also = (
        f" Not decided for this reason: {listed(each)}." if each and found.kind == "changed" else ""
    )
    loops = _loops_differ(found, angle) if found.foremost else ""
    runs = _runs(found) if found.kind == "changed" else ""
    # Of one effect among several; of all together the angles have to move by more than the rest.
    least = found.told_from_arcsec if found.kind == "changed" else found.not_followed_arcsec
    size = (
        f" It hides any change that moves the angles by less than {angle.text(least)} (rms), once "
        f"all other numbers are fitted again; what is fitted to each {_one(found)} alone may "
        "differ all the same."
    )
    return f"{rest}{size}{also}{runs}{loops}{_by_itself(found, angle)}"


def _rest(found: ChangeData, angle: AngleUnit) -> str:
    """What the fitted effects do not follow."""
    if not found.not_followed_arcsec:
        return ""
    return (
        f" The fitted effects leave up to {angle.text(found.not_followed_arcsec)} (rms) of the "
        "readings unexplained, much of it the same each time the same torques come again: no "
        "noise, but something that the model lacks."
    )


def _unless(found: ChangeData, angle: AngleUnit) -> str:
    """What a change rests on where no state was measured twice."""
    if found.reproducibility_arcsec is not None:
        return ""
    size = found.levels_differ_by_arcsec
    apart = "" if size is None else f" The fitted curves are {angle.text(size)} (rms) apart: where"
    than = "about a fifth of that" if apart else "a small part of that"
    return (
        " This holds if the rig comes back to the same state when it is set up again, which these "
        f"readings do not show.{apart or ' Where'} a state that is measured twice differs by more "
        f"than {than}, this may be no change. Measure one state again."
    )


def unless_repeated(runs_arcsec: float | None) -> str:
    """The remedy; runs_arcsec: how much runs of one level differ that have the same torques."""
    runs = ""
    if runs_arcsec is not None:
        runs = (
            f"; without a new set-up, runs with the same torques differ by {runs_arcsec:.3g} arcsec"
        )
    return (
        "how well the rig comes back to the same state is taken as exact: measure one state again "
        f"and give it as repeated, or state reproducibility_arcsec{runs}"
    )


def _sure(chance: float) -> str:
    """A probability in words, never more certain than it can be."""
    return f"probability {probability(chance)}"


def _told(found: ChangeData, angle: AngleUnit, c: Changed) -> str:
    """Of the foremost number of an effect, and of others that moved about as surely."""
    told = [one for one in found.told_of(c.effect) if one.moved]
    phrases = [_moved(found, angle, one) for one in told]
    if not phrases or None in phrases:
        return f"{c.effect} changed, but no number of it by more than twice its uncertainty"
    ways = [phrase for phrase in phrases if phrase is not None]
    if len(ways) > 1 or (c.is_shape and c.trend != "neither"):
        # Another transition torque is no less play.
        return f"{c.effect} changed: {'; '.join(way.alone for way in ways)}"
    (moved,) = ways
    return f"{c.effect} {moved.way}: {moved.label} {moved.values}"


class _Moved(NamedTuple):
    """A number that moved, in words."""

    label: str
    way: str
    values: str
    """From which to which, or all of them."""
    is_way: bool
    """Whether it says from which to which."""

    @property
    def alone(self) -> str:
        """A sentence of its own."""
        return f"{self.label} {self.way}{' ' if self.is_way else ': '}{self.values}"


def _moved(found: ChangeData, angle: AngleUnit, c: Changed) -> _Moved | None:
    """Which way a number went, and between which values; None where these are told alike."""
    known = list(zip(c.values, c.u, c.limits, strict=True))
    pairs = [in_words((c.effect, c.parameter), value, u, c.unit, angle) for value, u, _ in known]
    values = [limited(value, limit) for (_, value), (_, _, limit) in zip(pairs, known, strict=True)]
    if len(set(values)) == 1:
        return None
    way = "went up and down" if c.trend == "neither" else _WAYS[c.direction]
    ratio = ratio_of(c.effect, c.parameter)
    label = f"{pairs[0][0]} ({ratio})" if ratio else pairs[0][0]
    if c.trend is None:
        by = _difference(c, angle)
        return _Moved(label, way, f"from {values[0]} to {values[-1]}{by}", is_way=True)
    of = [f"{v} ({found.by} {level})" for v, level in zip(values, found.levels, strict=True)]
    told, is_way = listed(of), False
    if len(of) > _LISTED and c.trend == "neither":
        by_size = sorted(range(len(of)), key=lambda i: c.values[i])
        told = f"lowest {of[by_size[0]]}, highest {of[by_size[-1]]}"
    elif len(of) > _LISTED:
        back, is_way = "above" if c.trend == "falling" else "below", True
        told = f"from {of[0]} to {of[-1]}, at no level clearly {back} an earlier one"
    return _Moved(label, way, told, is_way)


def _difference(c: Changed, angle: AngleUnit) -> str:
    """The difference of two values, where it is known better than both: what all levels share makes
    them uncertain together."""
    off = abs(c.after - c.before)
    if c.u_before is None or c.u_after is None or not c.apart > 0:
        return ""
    u = off / c.apart
    if u > _AS_WELL * hypot(c.u_before, c.u_after):
        return ""
    return f" (by {in_words((c.effect, c.parameter), off, u, c.unit, angle)[1]})"


def limited(value: str, limit: Limit | None) -> str:
    """A value that may end at a limit of its range."""
    ends = {
        "lower": f"at most {value} (the limit of its range)",
        "upper": f"at least {value} (the limit of its range)",
        "own loops": f"{value} (the most that the small loops allow)",
    }
    return value if limit is None else ends[limit]


def _loops_differ(found: ChangeData, angle: AngleUnit) -> str:
    """What needs no fitted effect."""
    told = next((widths for widths in found.loops if widths.differ), None)
    return "" if told is None else f" The measured loops changed: {_widths(found, angle, told)}."


def _by_itself(found: ChangeData, angle: AngleUnit) -> str:
    """What the levels have if nothing is shared: the first and the last."""
    ends = {found.levels[k]: k for k in (0, -1)}
    names = [b.parameter for b in found.by_itself]
    told = []
    for b in found.by_itself:
        words = {
            level: in_words((b.effect, b.parameter), b.values[k], b.u[k], b.unit, angle)
            for level, k in ends.items()
        }
        label = next(iter(words.values()))[0]
        if names.count(b.parameter) > 1:
            label = f"{label} of {b.effect}"
        told.append(f"{label} {listed([f'{w} ({level})' for level, (_, w) in words.items()])}")
    return f" Each {_one(found)} fitted by itself: {'; '.join(told)}." if told else ""


def _widths(found: ChangeData, angle: AngleUnit, loops: LoopWidths) -> str:
    assert loops.may_differ is not None
    before, after = (loops.width_arcsec[i] for i in loops.may_differ)
    first, second = (found.levels[i] for i in loops.may_differ)
    return (
        f"at +-{loops.amplitude_Nm:.3g} N m their width at zero torque is "
        f"{angle.text(before, 4)} ({first}) and {angle.text(after, 4)} ({second})"
    )


def _width(width_arcsec: float, u_arcsec: float | None, angle: AngleUnit) -> str:
    u = "" if u_arcsec is None else f" +- {angle.number(u_arcsec, 2)}"
    return angle.number(width_arcsec, 4) + u


def _noise(found: ChangeData, angle: AngleUnit) -> str:
    if not found.noise.changed:
        return ""
    u = found.noise.u_arcsec
    if len(u) == 2:
        sizes = f"{angle.number(u[0])} to {angle.text(u[1])}"
    else:
        ends = (min(range(len(u)), key=u.__getitem__), max(range(len(u)), key=u.__getitem__))
        sizes = " and ".join(f"{angle.text(u[i])} ({found.levels[i]})" for i in ends)
        sizes = f"between {sizes}"
    return f" The scatter changed: {sizes} ({_sure(found.noise.probability)})."


def _within(found: ChangeData) -> str:
    """What did not change, and within what."""
    shares = {u.effect: u.within / abs(u.value) for u in found.unchanged if _firm(u)}
    told = [f"{effect} within {max(share, 0.001):.1%}" for effect, share in shares.items()]
    return f" Unchanged: {listed(told)}." if told else ""


def _odd_level(found: ChangeData, angle: AngleUnit) -> str:
    """What one level holds that nothing follows, and where."""
    odd = found.odd_level
    if odd is None:
        return ""
    name, other = found.levels[odd.level], found.levels[odd.other]
    if odd.slipped and odd.jump_arcsec is not None:
        return (
            f" But in run {odd.run} of {name} the angle jumps by "
            f"{angle.text(abs(odd.jump_arcsec))} near {odd.jump_Nm:.3g} N m, and in the other runs "
            "to the same torques it does not: something may have slipped there. A change may be "
            "hidden by it, or be it: look at that run and measure again."
        )
    less = angle.text(odd.other_arcsec, 2) if odd.other_arcsec else "nothing"
    where = "" if odd.run is None else f", most of it in run {odd.run}"
    if odd.jump_arcsec is not None:
        where += (
            f", where the angle jumps by {angle.text(abs(odd.jump_arcsec))} near "
            f"{odd.jump_Nm:.3g} N m"
        )
    return (
        f" But {name} holds something that the model does not follow with any values: it leaves "
        f"{angle.text(odd.left_arcsec)} (rms) beyond the scatter{where}; {other} leaves "
        f"{less}. A change may be hidden by it, or be it: look at the readings of "
        f"{name}{'' if odd.run is None else f', run {odd.run},'} and measure again."
    )


def _rests_differ(found: ChangeData, angle: AngleUnit) -> str:
    """That what no effect follows is another law from level to level, or of another size."""
    if found.rests_differ_arcsec is None:
        return ""
    return (
        f" But what the fitted effects do not follow differs from {_one(found)} to {_one(found)} "
        f"by {angle.text(found.rests_differ_arcsec)} (rms) in runs with the same torques: "
        "something that the model lacks changed, in form or in size, or the rig was set up "
        "otherwise. Compare the "
        f"residuals of the {_one(found)}s (cbpt compare), and measure one state again."
    )


def _not_shown(found: ChangeData) -> str:
    """What some level does not determine, by levels."""
    by_levels: dict[tuple[str, ...], list[str]] = {}
    for effect, levels in found.not_shown.items():
        by_levels.setdefault(levels, []).append(effect)
    beside = "" if found.reproducibility_arcsec is None else " beside what a new set-up changes"
    return "".join(
        f" Whether {listed(effects, 'or')} changed cannot be told: the readings of "
        f"{listed(levels)} determine {'it' if len(effects) == 1 else 'them'} too roughly{beside}."
        for levels, effects in by_levels.items()
    )


def _firm(u: Unchanged) -> bool:
    return abs(u.value) > 3 * u.within > 0


_NEXT_TO_NOTHING = 0.005
"""Probability of a change below which an effect that was tried beside the others has no row."""


def lines(found: ChangeData, angle: AngleUnit = ARCSEC) -> Iterator[str]:
    """The whole answer."""
    kind = found.readings[0].preload_N is None
    head, rest = headline_and_rest(found, angle)
    yield head
    if rest:
        yield ""
        yield rest.strip()
    yield ""
    head = found.by or "campaign"
    rows = [
        [level, str(len(r)), angle.number(rmse), angle.number(u)]
        for level, r, rmse, u in zip(
            found.levels, found.readings, found.rmse_arcsec, found.noise.u_arcsec, strict=True
        )
    ]
    yield layout.table([head, "readings", f"rmse_{angle.symbol}", f"scatter_{angle.symbol}"], rows)
    fitted = listed(found.effects) if found.effects else "no effect"
    numbers = "the numbers of drive and rig within [uncertainty]"
    yield f"Fitted to {_all(found)}: {fitted}, and {numbers}."
    rows, others = [], []
    for group in found.weighed.groups:
        chance = found.weighed.changed(group.effect)
        if chance < _NEXT_TO_NOTHING and group.effect not in {*found.effects, *PRIORS}:
            others.append(group.effect)
            continue
        name = called(group.effect, "torsion_spring" if kind else "ball_drive")
        rows.append([group.effect, name, probability(chance)])
    if rows:
        yield layout.table(["effect or number", "", "probability of a change"], rows)
    if others:
        each = "each " if len(others) > 1 else ""
        yield f"Tried too, {each}with a probability {probability(0.0)}: {listed(others)}."
    yield from _loops(found, angle)
    if found.reproducibility_arcsec:
        yield (
            f"A new set-up alone changes the angles by {angle.text(found.reproducibility_arcsec)} "
            "(standard deviation); a change counts as far as it goes beyond that."
        )
    if found.changed and len(found.levels) > 2:
        rows = []
        for c in found.changed:
            pairs = [
                in_words((c.effect, c.parameter), v, u, c.unit, angle)
                for v, u in zip(c.values, c.u, strict=True)
            ]
            cells = [
                value + ("" if limit is None else " (limit)")
                for (_, value), limit in zip(pairs, c.limits, strict=True)
            ]
            rows.append([f"{c.effect} {pairs[0][0]}", *cells])
        yield layout.table([head, *found.levels], rows)
    if found.remains:
        share = found.remains.get("share_of_misfit")
        told = f", {percent(share)} of the misfit" if isinstance(share, float) else ""
        yield (
            f"After the most probable combination {angle.text(found.remains['rms_arcsec'])} remain"
            f"{told}, more than noise: the numbers above share that rest."
        )
    yield from (f"Note: {angle.retold(note)}" for note in found.notes)


def _loops(found: ChangeData, angle: AngleUnit) -> Iterator[str]:
    """The widths of the measured loops."""
    if not found.loops:
        return
    yield f"Width of the measured loops at zero torque, {angle.symbol}:"
    rows = [
        [
            f"{w.amplitude_Nm:.3g}",
            *(_width(width, u, angle) for width, u in zip(w.width_arcsec, w.u_arcsec, strict=True)),
        ]
        for w in found.loops
    ]
    yield layout.table(["amplitude_Nm", *found.levels], rows)
