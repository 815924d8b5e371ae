"""What an answer claims, against what was hidden, for the wider families.

    accepted      for each hidden effect the ids that are right for it
    held, named   the truth is in the answer; it is the answer
    false_certain certain names that are not true
    spoken        effects that an answer speaks of
    is_so         the event that the stated probability is the probability of
    misleads      the truth is not held, or a name that is certain is false

An outcome is a plain dictionary: `truth` with `accepted`, `answer` as `Said.plain()`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import permutations, product
from typing import Any

from trial.adapter import NOTHING_MISSING

Outcome = Mapping[str, Any]
RIG = frozenset(
    (
        *("run_offset", "drift", "span_drift"),
        *("sensor_nonlinearity", "sensor_hysteresis", "sensor_gain"),
        *("torque_scale", "torque_zero", "torque_lag", "torque_hysteresis"),
        *("preload_scale", "preload_crosstalk", "shaft_shift", "loose_fixture"),
    )
)
"""What belongs to the instrument, not to the drive."""
ARTEFACT = ("artefact", "spring_artefact")
"""Families in which the instrument does something."""
CONFIDENT = 0.9


def accepted(outcome: Outcome) -> list[list[str]]:
    """For each hidden effect the ids of which one is right."""
    truth = outcome["truth"]
    ids = truth.get("accepted")
    return ids if ids is not None else [[i] for i in truth["answer"]["effects"]]


def beside(outcome: Outcome) -> set[str]:
    """Names of the noise, neither asked for nor wrong."""
    truth = outcome["truth"]
    zeros = {"run_offset"} if truth["noise"]["run_offset_arcsec"] > 0 else set()
    # A play that lies off zero torque is what a torque sensor off zero shows of one that does not.
    offset = any(hidden["form"] == "offset" for hidden in truth["hidden"])
    shifted = {"torque_zero"} if offset else set()
    return zeros | shifted | (RIG if outcome["family"] in ARTEFACT else set())


def unnamed(outcome: Outcome) -> bool:
    """Whether something real is hidden that no library need know."""
    return bool(outcome["family"] == "outside")


_AS_NOISE = {"encoder_ripple": "encoder"}
"""What has a name as noise, by what is hidden."""


def tells_unnamed(outcome: Outcome) -> bool:
    """Whether something without a name is told, or what is hidden is named as noise."""
    answer = outcome["answer"]
    spoken = set(answer["effects"]).union(*map(set, answer["rivals"]))
    if {_AS_NOISE.get(h["id"]) for h in outcome["truth"]["hidden"]} & set(answer.get("noise", ())):
        return True
    return bool(answer.get("remains")) or answer["kind"] == "unknown" or "unknown" in spoken


def _matches(ids: Iterable[str], wanted: Sequence[Sequence[str]]) -> bool:
    """Whether every hidden effect finds an id of its own among these."""
    pool = list(ids)
    return any(
        all(i in right for i, right in zip(pick, wanted, strict=True))
        for pick in permutations(pool, len(wanted))
    )


def held(answer: Mapping[str, Any], wanted: Sequence[Sequence[str]]) -> bool:
    """Whether what is certain with one of each group can be the truth or more."""
    useful = set().union(*wanted) if wanted else set()
    groups = [[i for i in g if i in useful] or [""] for g in answer["rivals"]]
    certain = set(answer["effects"]) & useful
    return any(_matches(certain | (set(pick) - {""}), wanted) for pick in product(*groups))


def all_held(outcome: Outcome) -> bool:
    """Whether the answer holds all that is hidden."""
    return held(outcome["answer"], accepted(outcome))


def named(outcome: Outcome) -> bool:
    """Whether the truth and nothing else is certain, and nothing is open."""
    answer, wanted = outcome["answer"], accepted(outcome)
    certain = set(answer["effects"]) - beside(outcome)
    return not answer["rivals"] and len(certain) == len(wanted) and _matches(certain, wanted)


def part_held(outcome: Outcome) -> bool:
    """Whether at least one hidden effect is held."""
    return any(held(outcome["answer"], [ids]) for ids in accepted(outcome))


def false_certain(outcome: Outcome) -> set[str]:
    """Certain names that are not true."""
    true = set().union(*accepted(outcome)) if accepted(outcome) else set()
    return set(outcome["answer"]["effects"]) - true - beside(outcome)


def spoken(outcome: Outcome) -> set[str]:
    """Effects that an answer speaks of, certain, rivals or perhaps; not the noise beside them."""
    answer = outcome["answer"]
    certain = set(answer["effects"]) | set(answer.get("perhaps", ()))
    return certain.union(*map(set, answer["rivals"])) - {"unknown"} - beside(outcome)


def speaks_of_physics(outcome: Outcome) -> bool:
    """Whether an effect of the drive is certain, or a group of effects of the drive alone."""
    answer = outcome["answer"]
    certain = set(answer["effects"]) - RIG - {"unknown"}
    return bool(certain) or any(not set(g) & (RIG | {"unknown"}) for g in answer["rivals"])


def alarms(outcome: Outcome) -> bool:
    """Whether something is said to be missing where nothing is: an effect, rivals or unknown."""
    answer = outcome["answer"]
    told = set(answer["effects"]) - beside(outcome)
    return (
        bool(told)
        or bool(answer["rivals"])
        or answer["kind"] == "unknown"
        or (bool(answer.get("remains")) and not answer.get("undecided"))
    )


def is_so(outcome: Outcome) -> bool:
    """The event of the stated probability."""
    answer, truth = outcome["answer"], outcome["truth"]
    wanted = accepted(outcome)
    if truth.get("lawless"):
        return bool(answer.get("undecided"))
    if answer.get("undecided"):
        return False
    if (
        outcome["family"] in ARTEFACT and not wanted
    ):  # real and of the instrument, known to the library or not
        return not speaks_of_physics(outcome)
    true = set().union(*wanted) if wanted else set()
    if false_certain(outcome) - {"unknown"}:
        return False
    open_ = true | beside(outcome) | ({"unknown"} if unnamed(outcome) else set())
    if not all(set(g) & open_ for g in answer["rivals"]):
        return False
    if answer.get("probability_of") == "named" and spoken(outcome):
        return True
    if unnamed(outcome):
        return tells_unnamed(outcome)
    if wanted:
        return held(answer, wanted)
    quiet = not (set(answer["effects"]) - beside(outcome)) and answer["kind"] in NOTHING_MISSING
    return quiet and answer["kind"] in truth["answer"].get("kinds", NOTHING_MISSING)


def confident(outcome: Outcome) -> bool:
    """Whether the answer is given at 0.9 or more."""
    return bool(outcome["answer"]["probability"] >= CONFIDENT)


def misleads(outcome: Outcome) -> bool:
    """Whether a name that is certain is false, or the truth is not held.

    With nothing hidden the truth is that nothing is missing; outside the library that something
    without a name is left; without a law that nothing can be said.
    """
    if false_certain(outcome):
        return True
    truth, answer = outcome["truth"], outcome["answer"]
    if unnamed(outcome):
        return not tells_unnamed(outcome)
    if truth.get("lawless") or not accepted(outcome):
        return not is_so(outcome)
    return not held(answer, accepted(outcome))


def answered(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Those with an answer."""
    return [o for o in outcomes if not o.get("error")]
