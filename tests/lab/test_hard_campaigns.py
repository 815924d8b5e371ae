"""Campaigns that are hard to answer (`data/hidden_effect/hard`), each with what is hidden in it.

Nothing false is certain in any; tables without a law stay undecided; noise alone shows nothing; two
and three effects are held.
"""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import pytest

from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from common import mostly_long
from common.hidden import FOLDER

HARD = FOLDER / "hard"
TRUTH: dict[str, dict[str, Any]] = json.loads((HARD / "truth.json").read_text(encoding="utf-8"))
NAMES = sorted(TRUTH)
LAWLESS = [n for n in NAMES if n.startswith("lawless")]
NULLS = [n for n in NAMES if n.startswith("null")]
FAMILIES = ("pair", "triple")
# One of a kind, and those that tests below look at more closely.
SHORT = [*LAWLESS[:2], *NULLS, "loss33", "pair19", "pair7", "single10", "spring6", "triple5"]
OPEN = {
    "spring6": "the spring stiffens, which its truth does not count; a stiffness curve is certain",
}
"""Where something false is certain, and why."""


@cache
def answer(name: str) -> Diagnosis:
    """The diagnosis of a campaign, made once."""
    case = "lawless" if name in LAWLESS else name
    return diagnose(HARD / f"{case}.toml", HARD / f"{name}.csv")


def hidden(name: str) -> list[set[str]]:
    """Each hidden effect as the ids of which one is right."""
    truth = TRUTH[name]
    if all(isinstance(one, list) for one in truth["truth"]):
        return [set(one) for one in truth["truth"]]
    return [{*truth["truth"], *truth.get("kin", [])}]


def in_noise(name: str) -> set[str]:
    """What is an effect of the noise."""
    kind = TRUTH[name].get("noise_kind", "")
    return {"run_offset"} if kind == "both" or "zeros" in kind else set()


def test_every_table_has_its_truth() -> None:
    assert sorted(path.stem for path in HARD.glob("*.csv")) == NAMES


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.xfail(reason=OPEN[n], strict=True))
        if n in OPEN
        else mostly_long([n], [n] if n in SHORT else [])[0]
        for n in NAMES
    ],
)
def test_nothing_false_is_certain(name: str) -> None:
    """No effect, and no group of which one is said to be needed."""
    verdict = answer(name).verdict
    right = in_noise(name).union(*hidden(name))
    assert set(verdict.effects) <= right
    assert all(set(group) & right for group in verdict.rivals)


@pytest.mark.parametrize("name", mostly_long(LAWLESS, LAWLESS[:2]))
def test_tables_without_a_law_are_undecided(name: str) -> None:
    verdict = answer(name).verdict
    assert (verdict.kind, verdict.effects, verdict.rivals) == ("undecided", (), ())
    assert verdict.probability <= 0.5
    # There is no answer that residuals could be of.
    assert "residuals of the drive as stated" in answer(name).report()


@pytest.mark.parametrize("name", NULLS)
def test_noise_alone_shows_no_effect(name: str) -> None:
    """Under a coarse display, which once made a lack of fit out of nothing."""
    verdict = answer(name).verdict
    assert verdict.kind in {"rig", "complete"}
    assert set(verdict.effects) <= {"run_offset"}
    assert verdict.rivals == () and verdict.lack_of_fit is None


HELD = ["pair19", "pair7", "pair22", "triple5", "pair52"]


@pytest.mark.parametrize("name", mostly_long(HELD, ["pair19", "pair7", "triple5"]))
def test_all_that_is_hidden_is_held(name: str) -> None:
    """Each hidden effect is certain or one of a group of rivals."""
    verdict = answer(name).verdict
    told = {*verdict.effects, *(e for g in verdict.rivals for e in g)}
    assert all(one & told for one in hidden(name))
    # And the answer is drawn with as many effects as are hidden.
    assert len(verdict.names) == len(hidden(name))
