"""What a campaign could see and tell apart, against diagnoses of simulated readings of it."""

from __future__ import annotations

import json
from contextvars import ContextVar
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt import InvalidInputError, isolability, read_plan, simulate
from cbpt.cli import main as commands
from cbpt.lab.experiment.isolability import Isolability
from cbpt.lab.experiment.plan import Plan, PlannedRun
from cbpt.lab.experiment.separation import between, crossing
from cbpt.lab.selection.rules import RULES
from cbpt.lab.wording import layout
from common.comparisons import strictly

TOP = Path(__file__).parents[2]
CASE, PLAN = TOP / "examples" / "campaign.toml", TOP / "examples" / "plan.toml"
EFFECTS = [
    *("contact_stiffness", "sensor_gain", "torque_scale", "preload_scale", "preload_loss"),
    *("eccentric_bearing", "output_torsion", "bearing_play", "thermal_preload"),
]


@cache
def found() -> Isolability:
    return isolability(CASE, PLAN, effects=EFFECTS)


# --- against simulation -------------------------------------------------------------------


def told(effect: str, values: dict[str, float], seed: int) -> bool:
    """Whether a diagnosis of simulated readings names the effect, certain or among rivals."""
    readings = simulate(CASE, PLAN, effects=[(effect, values)], seed=seed)
    verdict = cbpt.diagnose(CASE, readings).verdict
    return effect in {*verdict.effects, *(e for group in verdict.rivals for e in group)}


def test_an_effect_is_told_as_often_as_claimed() -> None:
    """A third of the smallest size not, the size that is told 19 times of 20 nearly always."""
    seen = found().effect("bearing_play")
    even, sure = seen.values("even"), seen.values("sure")
    assert even is not None and sure is not None
    small = {name: 0.3 * value for name, value in even.items()}
    assert sum(told("bearing_play", sure, seed) for seed in range(3)) >= 2
    assert not told("bearing_play", small, 0)


def test_effects_that_are_not_told_apart_come_out_as_rivals() -> None:
    pair = found().pair("eccentric_bearing", "output_torsion")
    seen = found().effect("output_torsion")
    assert pair.verdict == "above" and pair.correlation > 0.99
    above, sure = pair.above[1], seen.smallest["sure"]
    assert above is not None and sure is not None and 3 * sure < above
    values = seen.form.values(1.2 * sure)
    for seed in range(2):
        readings = simulate(CASE, PLAN, effects=[("output_torsion", values)], seed=seed)
        verdict = cbpt.diagnose(CASE, readings).verdict
        assert {"eccentric_bearing", "output_torsion"} <= {e for g in verdict.rivals for e in g}


def test_what_an_answer_calls_detectable_is_what_was_said_beforehand() -> None:
    answer = cbpt.diagnose(CASE, simulate(CASE, PLAN, seed=3))
    after = {entry["effect"]: entry["smallest"] for entry in answer.detectable()}
    for effect in ("bearing_play", "eccentric_bearing", "output_torsion"):
        seen = found().effect(effect)
        name, even = seen.form.variant.sizes[0], seen.values()
        assert even is not None
        assert after[effect][name] == pytest.approx(even[name], rel=0.25)


# --- properties ---------------------------------------------------------------------------


def test_twins_are_named_with_what_decides() -> None:
    for one, other in (("contact_stiffness", "sensor_gain"), ("preload_loss", "preload_scale")):
        pair = found().pair(one, other)
        assert pair.verdict == "twins"
    assert found().pair("preload_loss", "preload_scale").decided_by == ("preload_gain_rel",)
    groups = [set(group) for group in found().groups()]
    assert not any({"eccentric_bearing", "output_torsion"} <= group for group in groups)
    report = found().report()
    assert (
        "Pairs that no reading of this rig can distinguish" in report
        and "preload_gain_rel = 0.02" in report
    )


@pytest.mark.parametrize("columns", [72, 80])
def test_headings_are_whole_words_in_a_narrow_terminal(
    columns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "_width", ContextVar("width", default=columns))
    lines = found().report().splitlines()
    top = next(i for i, line in enumerate(lines) if line.startswith("\u250c"))
    end = next(i for i, line in enumerate(lines) if line.startswith("\u255e"))
    assert len(lines[top]) <= columns
    cells = [line.strip("\u2502").split("\u2506") for line in lines[top + 1 : end]]
    named = {" ".join(" ".join(parts).split()) for parts in zip(*cells, strict=True)}
    assert named == {"effect", "parameter", "in 50 %", "in 95 %", "at most", "most similar effect"}


def test_what_a_plan_lacks_is_said() -> None:
    assert "temperature_degC" in found().unseen["thermal_preload"]
    once = Plan.of_runs([PlannedRun((0.0, 2.0, 4.0), 700, u_elastic_angle_arcsec=0.3)])
    held = isolability(CASE, once, effects=["creep", "eccentricity_error"])
    assert not held.pairs and "time_s" in held.unseen["creep"]


def test_four_times_the_readings_halve_the_smallest_size() -> None:
    """Of an effect that grows in proportion, where runs share a zero: a little less, for the
    numbers of the drive are known no better from outside."""
    effects = ["bearing_play"]
    once = isolability(CASE, PLAN, effects=effects).effect("bearing_play").smallest["even"]
    runs = read_plan(PLAN).runs
    often = isolability(CASE, Plan.of_runs([*runs] * 4), effects=effects)
    four = often.effect("bearing_play").smallest["even"]
    assert once is not None and four is not None
    assert 0.4 * once < four < 0.65 * once
    finer = isolability(CASE, PLAN, effects=effects, u_elastic_angle_arcsec=0.15)
    half = finer.effect("bearing_play").smallest["even"]
    assert half is not None and half < 0.65 * once


def test_the_smallest_size_is_between_the_sizes_looked_at() -> None:
    sizes = np.geomspace(1, 100, 5)
    fine, d = between(sizes, 2 * sizes)
    assert d == pytest.approx(2 * fine, rel=1e-9)
    assert crossing(fine, d) == pytest.approx(RULES.log_rival_odds / 2, rel=1e-2)
    stopped, _ = between(sizes, np.array([1, 2, np.nan, 4, 5]))
    assert stopped[-1] == pytest.approx(sizes[1])
    assert crossing(sizes, np.zeros(5)) is None


# --- the document, the picture, the verb --------------------------------------------------


def test_the_document_is_json_and_says_what_the_text_says(tmp_path: Path) -> None:
    document = strictly(found().to_json())
    assert document["schema"] == "cbpt.isolability/1"
    by = {entry["effect"]: entry for entry in document["effects"]}
    assert by["eccentric_bearing"]["looks_most_like"] == "output_torsion"
    sizes = by["bearing_play"]["sizes"]
    assert len(sizes) > 5 and sizes[0]["d"] < sizes[-1]["d"]
    assert document["priors"]["torque_gain_rel"] == 0.01
    pytest.importorskip("matplotlib")
    found().plot(tmp_path / "matrix.svg")
    assert "output_torsion" in (tmp_path / "matrix.svg").read_text()


def test_the_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["isolability", str(CASE), str(PLAN), "--effects", "bearing_play", "creep"]
    out = tmp_path / "answer.json"
    assert commands.main([*given, "--json", str(out), "--noise", "run_offset=1"]) == 0
    assert "bearing_play" in capsys.readouterr().out
    assert json.loads(out.read_text())["noise"]["run_offset_per_u"] == 1
    assert commands.main([*given[:3], "--effects", "bearing"]) == 2
    assert "did you mean bearing_play?" in capsys.readouterr().err
    table = tmp_path / "loads.csv"
    table.write_text("torque_Nm,preload_N,u_elastic_angle_arcsec\n900,500,1\n1,500,1\n")
    assert commands.main([*given[:2], str(table)]) == 3
    assert "900 N m" in capsys.readouterr().err
    with pytest.raises(InvalidInputError, match="run_offset=SIZE"):
        isolability(CASE, PLAN, effects=["run_offset"])
