"""How good one answer is, against what was hidden.

    Outcome         one campaign: truth, answer, what the oracle and plain criteria say
    contains, size  an answer as the set of effects that it speaks of
    grade           how good it is, in one word
    true_statement  whether what was answered is so

Nothing here knows how the answers came about: outcomes are plain dictionaries, as they stand in the
JSON document, so that any other method can be graded the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import Any, Literal

from trial import claims

Outcome = Mapping[str, Any]
"""family, index, truth (that of reference.rig.campaign, and duration_s), answer (kind, effects,
rivals, probability), held_out (stated, refitted, after), criteria {aic, bic: [id]},
parameters {effect: {name: {value, u}}}, oracle {names, rivals, held_out_arcsec}, error (text, where
there is no answer)."""

Grade = Literal["right", "contains", "twin", "unknown", "missed", "wrong", "error"]
UNNAMED = {"run_offset"}
"""What belongs to the noise; naming it beside the truth is no wrong name."""


def named(answer: Mapping[str, Any]) -> set[str]:
    """Effects that an answer holds certain."""
    return set(answer["effects"])


def contains(answer: Mapping[str, Any], truth: Iterable[str]) -> bool:
    """Whether the certain effects with one of each rival group can be the truth or more."""
    wanted = set(truth) - named(answer)
    return any(wanted <= set(pick) for pick in product(*answer["rivals"]))


def size(answer: Mapping[str, Any]) -> int:
    """How many effects an answer speaks of."""
    return len(named(answer).union(*map(set, answer["rivals"])))


def grade(outcome: Outcome) -> Grade:
    """right: as the truth has it. contains: an honest set that holds the truth. twin: one of the
    truth's twins named for certain. unknown, missed: nothing was named. wrong: a name that is not
    true."""
    if outcome.get("error"):
        return "error"
    truth, answer = outcome["truth"]["answer"], outcome["answer"]
    by_family: dict[str, Callable[[Mapping[str, Any], Mapping[str, Any]], Grade]] = {
        "null": _null,
        "parameter_only": _parameter,
        "single": _effects,
        "pair": _effects,
        "confounded": _confounded,
        "outside": _outside,
    }
    if outcome["family"] not in by_family:
        return _wider(outcome)
    return by_family[outcome["family"]](truth, answer)


def _wider(outcome: Outcome) -> Grade:
    """A wider family, by what is claimed."""
    if claims.unnamed(outcome):
        return "right" if claims.tells_unnamed(outcome) else "wrong"
    if not claims.accepted(outcome):
        return "right" if claims.is_so(outcome) else "wrong"
    if claims.named(outcome):
        return "right"
    if claims.held(outcome["answer"], claims.accepted(outcome)):
        return "contains"
    return _unnamed(outcome["answer"]) or "wrong"


def _nothing(answer: Mapping[str, Any]) -> bool:
    return not (named(answer) - UNNAMED) and not answer["rivals"]


def _null(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> Grade:
    quiet = answer["kind"] in truth["kinds"] and not answer["rivals"]
    return "right" if quiet and named(answer) <= set(truth["effects"]) else "wrong"


def _parameter(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> Grade:
    if answer["kind"] == "parameter" and named(answer) == set(truth["effects"]):
        return "right"
    if contains(answer, truth["effects"]):
        return "contains"
    return _unnamed(answer) or "wrong"


def _effects(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> Grade:
    true = set(truth["effects"])
    if not answer["rivals"] and named(answer) == true:
        return "right"
    if contains(answer, true):
        return "contains"
    twins = set().union(*truth.get("also_right", []))
    return _unnamed(answer) or (
        "twin" if named(answer) and named(answer) <= twins - true else "wrong"
    )


def _confounded(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> Grade:
    group = set(truth["rivals"][0])
    if answer["kind"] == "ambiguous" and any(group & set(g) for g in answer["rivals"]):
        return "right"
    if _nothing(answer) and answer["kind"] in truth["kinds"]:
        return "right"
    if named(answer) & group - UNNAMED or (answer["kind"] == "rig" and named(answer) & group):
        return "twin"
    return _unnamed(answer) or "wrong"


def _outside(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> Grade:
    if answer["kind"] == "unknown":
        return "right"
    return "contains" if contains(answer, ["unknown"]) else _unnamed(answer) or "wrong"


def _unnamed(answer: Mapping[str, Any]) -> Grade | None:
    if answer["kind"] == "unknown":
        return "unknown"
    return "missed" if _nothing(answer) else None


def true_statement(outcome: Outcome) -> bool:
    """The event that `probability` is the probability of: what was answered is so."""
    if grade(outcome) == "right":
        return True
    if outcome.get("error") or grade(outcome) != "contains":
        return False
    true = set(outcome["truth"]["answer"]["effects"]) or {"unknown"}
    certain = named(outcome["answer"]) <= true | UNNAMED
    return certain and all(set(g) & true for g in outcome["answer"]["rivals"])
