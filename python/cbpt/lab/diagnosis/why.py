"""Why this and not that: the answer against each rival, split by readings.

Why        one rival: log odds, what of it the readings tell and where, what the rest is
whys       the rivals that the readings leave, the most probable first, and no effect at all
sentence   one rival in words

The difference in log evidence is half the difference in chi-squared, which is a sum over readings,
and what the hypotheses cost beside it: prior odds, and how much of their plausible range the
readings leave (the Occam factor; MacKay 2003, chapter 28).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.diagnosis.combinations import Combination
from cbpt.lab.diagnosis.deciding_runs import RankedRuns, name_among
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.misfit import divisions
from cbpt.lab.experiment.candidates import in_words
from cbpt.lab.experiment.plan import PlannedRun
from cbpt.lab.model.priors import TWINS
from cbpt.lab.selection.posterior import UNKNOWN, named_of, posterior_of
from cbpt.lab.selection.setting import Names
from cbpt.lab.wording.names import called
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit, listed, rounded

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Told:
    """What is told."""

    rivals: int = 6
    decide: float = 0.8
    """Share of the difference in chi-squared that the groups named in the sentence make up."""
    apart: float = 0.6
    """Share of the readings that lies outside these groups at least."""
    worse: float = 1.5
    """Times the held-out error of the answer from which that of a rival is told."""


_TOLD = _Told()
_WORDS = {
    "torque_Nm": ("torque", " N m"),
    "preload_N": ("preload", " N"),
    "preload_step": ("preload step", ""),
    "input_angle_deg": ("input angle", " deg"),
    "direction": ("torque", ""),
    "run": ("run", ""),
}


@dataclass(frozen=True)
class Group:
    """Readings that share a value or a range of a column."""

    column: str
    label: str
    readings: int
    delta_chi2: float
    """By how much chi-squared of the rival is larger there."""


@dataclass(frozen=True)
class Why:
    """The answer against one rival."""

    effects: tuple[str, ...]
    unnamed: bool
    log_odds: float
    """Log posterior odds of the most probable combination against this one."""
    delta_chi2: float | None
    """Chi-squared of the rival less that of the answer; None where a part of it has no name."""
    more_numbers: int
    """Free numbers that the rival has more."""
    groups: tuple[Group, ...]
    decides: tuple[Group, ...]
    """The fewest groups of one column that make up most of the difference."""
    run: dict[str, Any] | None
    """The run that would tell the two apart best, and how many of it would turn the answer."""
    run_in_words: str
    """The same run as one would ask for it at the rig."""
    held_out: tuple[float, float] | None
    """Held-out error of the rival and of the answer, arcsec."""

    @property
    def other_log_odds(self) -> float | None:
        """What of the log odds is not the misfit: prior odds and the price of free numbers."""
        return None if self.delta_chi2 is None else self.log_odds - 0.5 * self.delta_chi2

    def to_dict(self) -> dict[str, Any]:
        """As plain values."""
        by: dict[str, list[dict[str, Any]]] = {}
        for g in self.groups:
            row = {"label": g.label, "readings": g.readings, "delta_chi2": g.delta_chi2}
            by.setdefault(g.column, []).append(row)
        return {
            "effects": list(self.effects),
            "unnamed": self.unnamed,
            "log_odds": self.log_odds,
            "delta_chi2": self.delta_chi2,
            "other_log_odds": self.other_log_odds,
            "by": by,
            "decides": [{"column": g.column, "label": g.label} for g in self.decides],
            "run": self.run,
        }


def whys(d: DiagnosisData, found: list[Combination], runs: RankedRuns | None) -> list[Why]:
    """The answer against the other combinations, and against no effect at all."""
    posterior = posterior_of(d.competition)
    sets = sorted(posterior.sets, key=lambda n: -posterior.sets[n])
    best = sets[0]
    rivals = sets[1 : min(len(found), _TOLD.rivals + 1)]
    nothing = next((n for n in sets if not set(named_of(n)) and UNKNOWN not in n), None)
    if nothing is not None and nothing != best and nothing not in rivals:
        rivals.append(nothing)
    moved = named_of(best)
    if nothing in rivals and not d.verdict.names and set(moved) <= set(d.verdict.effects):
        rivals.remove(nothing)  # the answer itself: the parameter has moved as a refitted one
    held = {(c.effects, c.unnamed): c.held_out_rmse_arcsec for c in found}
    return [_why(d, best, names, posterior.sets, held, runs) for names in rivals]


def _why(
    d: DiagnosisData,
    best: Names,
    names: Names,
    chances: Any,
    held: dict[tuple[Names, bool], float],
    runs: RankedRuns | None,
) -> Why:
    log_odds = float(np.log(chances[best] / max(chances[names], 1e-300)))
    groups: tuple[Group, ...] = ()
    total, more = None, 0
    if UNKNOWN not in best and UNKNOWN not in names:
        one, other = _whitened(d, best), _whitened(d, names)
        change = other**2 - one**2
        total, groups = float(change.sum()), tuple(_groups(d, change))
        more = _free(d, names) - _free(d, best)
    told = [held.get((tuple(e for e in n if e != UNKNOWN), UNKNOWN in n)) for n in (names, best)]
    errors = (told[0], told[1]) if told[0] is not None and told[1] is not None else None
    run, many = _run(d, runs, best, names, log_odds) or (None, {})
    return Why(
        effects=tuple(e for e in names if e != UNKNOWN),
        unnamed=UNKNOWN in names,
        log_odds=log_odds,
        delta_chi2=total,
        more_numbers=more,
        groups=groups,
        decides=_decide(groups, total, len(d.readings)),
        run=_as_dict(run) | many if run else None,
        run_in_words=in_words(run) if run else "",
        held_out=errors,
    )


def _whitened(d: DiagnosisData, names: Names) -> Floats:
    """What a set leaves of each reading, in standard uncertainties, without correlation."""
    fit = d.competition.fitter.look(d.fit_of(named_of(names)), d.noise)
    return np.asarray(fit.whitener(fit.residual_arcsec))


def _free(d: DiagnosisData, names: Names) -> int:
    return sum(
        u.size_of >= 0 or "." in u.name for u in d.competition.fits[named_of(names)].unknowns
    )


def _groups(d: DiagnosisData, change: Floats) -> list[Group]:
    return [
        Group(column, label, len(rows), float(change[rows].sum()))
        for column, label, _, _, rows in divisions(d.readings)
    ]


def _decide(groups: tuple[Group, ...], total: float | None, n: int) -> tuple[Group, ...]:
    """Of the column in which the fewest readings make most of the difference."""
    if total is None or abs(total) < 2:
        return ()
    best: tuple[float, tuple[Group, ...]] = (_TOLD.apart, ())
    for column in dict.fromkeys(g.column for g in groups):
        own = sorted(
            (g for g in groups if g.column == column), key=lambda g: -g.delta_chi2 * np.sign(total)
        )
        part = 0.0
        for count, group in enumerate(own[:3], 1):
            part += group.delta_chi2
            share = sum(g.readings for g in own[:count]) / n
            if part / total >= _TOLD.decide and 1 - share > best[0]:
                best = 1 - share, tuple(own[:count])
    return best[1]


def _run(
    d: DiagnosisData, runs: RankedRuns | None, best: Names, names: Names, log_odds: float
) -> tuple[PlannedRun, dict[str, Any]] | None:
    """The run that separates the two best, and about how many of it would turn the answer."""
    if runs is None or UNKNOWN in best or UNKNOWN in names:
        return None
    pair = {name_among(d, named_of(best)), name_among(d, named_of(names))}
    gains = [
        (gain, s.run) for s in runs.ranked for key, gain in s.pairs.items() if set(key) == pair
    ]
    if len(pair) < 2 or not gains:
        return None
    gain, run = max(gains, key=lambda g: g[0])
    if gain < 0.1:
        return None
    return run, {"gain": gain, "runs": int(np.ceil(log_odds / gain))}


def _as_dict(run: PlannedRun) -> dict[str, Any]:
    torque = np.array(run.torque_Nm)
    return {
        "torque_Nm": float(torque[np.argmax(np.abs(torque))]),
        "preload_N": run.preload_N,
        "input_angle_deg": run.input_angle_deg[0],
    }


# --- in words -----------------------------------------------------------------------------------


def sentence(d: DiagnosisData, why: Why, angle: AngleUnit = ARCSEC) -> str:
    """One rival in words: how much less probable, from which readings, and what would turn it."""
    told = [f"{_name(d, why)[:1].upper()}{_name(d, why)[1:]}: {_times(why.log_odds)}."]
    if why.delta_chi2 is not None:
        told.append(_misfit(why))
    if why.held_out and why.held_out[0] < 0.98 * why.held_out[1]:
        own, best = (angle.number(v) for v in why.held_out)
        told.append(
            f"Its held-out error is lower ({own} against {best} {angle.symbol}): that speaks for "
            "it, and these odds do not count it."
        )
    elif why.held_out and why.held_out[0] > _TOLD.worse * why.held_out[1]:
        own, best = (angle.number(v) for v in why.held_out)
        told.append(
            f"Readings that were kept back it predicts worse ({own} against {best} "
            f"{angle.symbol}): that speaks against it, and these odds do not count it."
        )
    if why.run:
        count = why.run["runs"]
        many = "this run" if count < 2 else f"about {count} runs of this kind"
        told.append(f"If it were true, {many} would turn the answer: {why.run_in_words}.")
    elif _twin(d, why):
        told.append(
            "No run of this rig tells it from the answer: both change every reading in the same "
            "way. Other knowledge, such as a calibration or a drawing, can."
        )
    return " ".join(told)


def _twin(d: DiagnosisData, why: Why) -> bool:
    """Whether it is the answer but for one effect in the place of its exact twin."""
    own = set(why.effects) - set(d.verdict.names)
    other = set(d.verdict.names) - set(why.effects)
    return len(own) == len(other) == 1 and other <= set(TWINS.get(own.pop(), []))


def _name(d: DiagnosisData, why: Why) -> str:
    kind = d.competition.campaign.drive.kind
    unnamed = ["an effect without a name"] if why.unnamed else []
    return listed([*(called(e, kind) for e in why.effects), *unnamed]) or "no effect at all"


def _times(log_odds: float) -> str:
    if log_odds > np.log(1e6):
        return "more than a million times less probable"
    times = float(np.exp(log_odds))
    return "about as probable" if times < 1.5 else f"{rounded(times, 2)} times less probable"


def _misfit(why: Why) -> str:
    """How its misfit compares, where, and what else counts."""
    total, more = why.delta_chi2, why.more_numbers
    assert total is not None
    size = f"chi-squared {rounded(abs(total))}"
    other = why.log_odds - 0.5 * total
    numbers = "number" if abs(more) == 1 else "numbers"
    price = ""
    if other > 1 and more > 0:
        price = f"the price of {more} more free {numbers} is {_weight(other)}"
    elif other > 1:
        price = f"the price of its prior odds and ranges is {_weight(other)}"
    where = f", mostly {_places(why.decides)}" if why.decides else ""
    if abs(total) < 2:
        return f"It fits as well; {price or 'nothing else decides'}."
    if total < 0:
        return f"It fits better by {size}{where}; {price or 'but not enough'}."
    if other < -1:
        price = (
            "a part of that does not count, as the model allows for larger noise and for "
            "departures from the equations"
        )
    return f"It fits worse by {size}{where}{f'; {price}' if price else ''}."


def _weight(log_odds: float) -> str:
    """What belongs to the price, as odds: about 1800 : 1."""
    known = log_odds < np.log(1e6)
    return f"about {rounded(np.exp(log_odds), 2)} : 1" if known else "over a million : 1"


def _places(groups: tuple[Group, ...]) -> str:
    """At torque -8 and 8 N m (66 readings); in runs 3 and 12."""
    name, unit = _WORDS.get(groups[0].column, (groups[0].column, ""))
    count = sum(g.readings for g in groups)
    if groups[0].column == "run":
        name = "in runs" if len(groups) > 1 else "in run"
    else:
        name = f"at {name}"
    return f"{name} {listed([g.label for g in groups])}{unit} ({count} readings)"
