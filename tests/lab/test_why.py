"""Why an answer holds against each rival: what the readings say, and what run would turn it."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cbpt.lab.diagnosis.why import sentence
from common.hidden import diagnosed

NAMES = ["dev03", "dev09"]


@pytest.mark.parametrize("name", NAMES)
def test_the_parts_make_up_the_odds(name: str) -> None:
    d = diagnosed(name)
    document = d.to_dict()
    best, *others = document["combinations"]
    assert [w["effects"] for w in document["why"]][: len(others)] == [c["effects"] for c in others]
    for why, rival in zip(document["why"], others, strict=False):
        assert why["log_odds"] == pytest.approx(np.log(best["probability"] / rival["probability"]))
        half = 0.5 * why["delta_chi2"]
        assert half + why["other_log_odds"] == pytest.approx(why["log_odds"])
        for groups in why["by"].values():
            assert sum(g["delta_chi2"] for g in groups) == pytest.approx(why["delta_chi2"])
            assert sum(g["readings"] for g in groups) == len(d.readings)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_told_in_text_and_document(name: str) -> None:
    d = diagnosed(name)
    words = " ".join(d.report().split())
    for why, told in zip(d.why(), d.to_dict()["why"], strict=True):
        assert told["sentence"] == sentence(d, why)
        assert told["sentence"] in words
    # The last is no effect at all, which the misfit excludes.
    nothing = d.why()[-1]
    assert not nothing.effects and nothing.delta_chi2 is not None and nothing.delta_chi2 > 100
    assert "No effect at all: more than a million times less probable" in words


@pytest.mark.parametrize("name", NAMES)
def test_evidence_is_told_as_odds(name: str) -> None:
    told = " ".join(why["sentence"] for why in diagnosed(name).to_dict()["why"])
    assert re.search(r"(about \d+|over a million) : 1", told)
    assert "log odds" not in told and "log evidence" not in told


def test_a_parameter_that_moved_is_no_rival_of_itself() -> None:
    d = diagnosed("dev12")
    assert d.verdict.effects == ("contact_stiffness",) and not d.verdict.names
    assert all(why.effects for why in d.why())
    assert "perhaps also a contact stiffness" not in d.sentence
    # As an effect of the set, or refitted without one, it is the same statement; exactly this
    # combination is one of the two.
    same = [c["probability"] for c in d.to_dict()["combinations"] if len(c["effects"]) < 2]
    assert d.verdict.exactly == pytest.approx(same[0]) and d.verdict.probability >= sum(same)


def test_a_run_that_would_turn_the_answer_is_named() -> None:
    d = diagnosed("dev09")
    named = [why for why in d.why() if why.run]
    assert named
    for why in named:
        assert why.run is not None and why.run["runs"] >= 1 and why.run["gain"] > 0
        # As the next run is asked for.
        assert f"would turn the answer: {why.run_in_words}." in sentence(d, why)
    # The run that is suggested weighs all of them.
    open_ones = {" + ".join(sorted(set(why.effects) - {"friction_hysteresis"})) for why in named}
    assert set(d.to_dict()["next_run"]["separates"]) & open_ones
