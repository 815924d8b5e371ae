"""The run that decides: what is open, what runs bring, and that suggested runs beat random ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt import InvalidInputError, Limits, NextRuns, read_plan
from cbpt.cli import main as commands
from cbpt.lab.covariance.linear_gaussian import Noise, Rows
from cbpt.lab.diagnosis.deciding_runs import open_hypotheses
from cbpt.lab.diagnosis.next_runs import ranked
from cbpt.lab.diagnosis.unexplained import measure_next
from cbpt.lab.experiment.candidates import READINGS, candidates, limits_of
from cbpt.lab.experiment.expected_gain import LIMIT, Prospect, prospect
from cbpt.lab.experiment.plan import Plan, table_text
from cbpt.lab.wording.numbers import significant
from common.comparisons import strictly
from common.hidden import diagnosed
from common.next_runs import race, short_campaign, view_of

TOP = Path(__file__).parents[2]
CASE = TOP / "examples" / "campaign.toml"
BEARING = [("eccentric_bearing", {"reference_deflection_um": 0.21, "exponent": 2 / 3})]
"""With balls: one with rollers is told from a joint that stiffens by no run."""


@cache
def suggested() -> NextRuns:
    readings = cbpt.simulate(CASE, short_campaign(), effects=BEARING, seed=0)
    return ranked(cbpt.diagnose(CASE, readings))


# --- candidates ---------------------------------------------------------------------------


def test_candidates_stay_within_the_limits_and_are_held() -> None:
    drive = cbpt.Drive.from_file(CASE)
    limits = Limits(10.0, (400.0, 1200.0), (0.0, 30.0))
    runs = candidates(drive, limits)
    assert {len(run) for run in runs} == {READINGS} and len(set(runs)) == len(runs)
    for run in runs:
        assert max(map(abs, run.torque_Nm)) <= 10.0
        assert run.preload_N is not None and 400 <= run.preload_N <= 1200
        # Numbers that a rig can be set to.
        assert run.preload_N == significant(run.preload_N, 2)
        assert run.torque_Nm[0] in (0, significant(run.torque_Nm[0], 2))
    rows = Plan.of_runs(runs).rows
    assert rows.preload_N is not None
    solved = cbpt.solve_many(drive, rows.torque_Nm, rows.preload_N, rows.input_angle_deg)
    assert np.isfinite(solved.elastic_angle_arcsec).all()
    assert len(candidates(drive, limits, 7)) == 7
    # Limits that are no round numbers are kept all the same.
    odd = candidates(drive, Limits(12.3456785, (333.3, 777.7), (0.0,)))
    assert max(abs(torque) for run in odd for torque in run.torque_Nm) <= 12.3456785
    assert {run.preload_N for run in odd} >= {333.3, 777.7}
    assert limits_of(suggested().diagnosis.readings).preload_N == (400.0, 1100.0)


@pytest.mark.parametrize(
    ("torque_Nm", "preload_N"), [(0, (1, 2)), (1, (2, 1)), (1, (0, 1)), (np.nan, (1, 2))]
)
def test_limits_that_cannot_be_are_told(torque_Nm: float, preload_N: tuple[float, float]) -> None:
    with pytest.raises(InvalidInputError, match=r"torque_Nm|preload_N"):
        Limits(torque_Nm, preload_N)


# --- gains --------------------------------------------------------------------------------


def view(root: float) -> Prospect:
    """Two hypotheses that differ by 1 arcsec at every other reading of one run."""
    n = 40
    step = np.asarray(np.arange(n) % 2.0, dtype=np.float64)
    roots = np.full((n, 1), root) * step[:, None]
    return Prospect(
        ("one", "other"),
        np.array([0.5, 0.5]),
        Rows.of(np.zeros(n, dtype=np.int64)),
        (np.zeros(n), step),
        (roots, roots),
        Noise(),
        0.5,
    )


def test_the_gain_is_half_the_squared_distance_in_standard_uncertainties() -> None:
    every = np.ones(40, dtype=bool)
    (gain,) = view(0.0).gains(every).values()
    # The zero of the run takes the mean of the step: 40 readings of +-1/2 arcsec, u 1/2 arcsec.
    assert gain == pytest.approx(0.5 * 40 * 0.25 / 0.25, rel=1e-3)
    (vague,) = view(3.0).gains(every).values()
    assert vague < 0.1 * gain


# --- what is suggested --------------------------------------------------------------------


def test_the_open_hypotheses_hold_the_rivals_and_runs_are_ranked_by_what_they_bring() -> None:
    found = suggested()
    d = found.diagnosis
    assert set(d.verdict.rivals[0]) <= set(found.open) and len(found.open) <= 6
    assert sum(found.open.values()) == pytest.approx(1)
    gains = [s.gain for s in found.ranked]
    assert gains[0] > 1 and gains == sorted(gains, reverse=True)
    assert "Runs, the most useful first. gain: " in found.report()
    best = d.next_run()
    assert best is not None and best["separates"]
    assert best["largest_gain"] == max(found.ranked[0].pairs.values())


def test_the_run_of_an_answer_is_the_first_of_the_ranking_with_its_numbers() -> None:
    """One key had two meanings: the mean over the pairs here, the largest of them there."""
    d = diagnosed("dev03")
    run, first = d.to_dict()["next_run"], ranked(d).to_dict()["runs"][0]
    same = ("gain", "largest_gain", "preload_N", "direction")
    assert {k: run[k] for k in same} == {k: first[k] for k in same}
    assert 0 < run["gain"] <= run["largest_gain"]


def test_rivals_that_no_run_tells_apart_are_told_beside_the_run() -> None:
    """Bearing or shaft: a run tells whether something is late too, and none tells which it is."""
    d = diagnosed("dev09")
    run = d.to_dict()["next_run"]
    assert run["untold"] == ["output_torsion"]
    assert "eccentric_bearing" in run["separates"] and len(run["separates"]) > 1
    assert run["runs"] == np.ceil(LIMIT / run["largest_gain"])
    said = "No run within reach tells the most probable combination from output_torsion"
    assert said in " ".join(d.report().split())
    assert "from output_torsion; other knowledge" in ranked(d, most=40).report()


def test_a_run_is_told_by_what_it_says_of_the_most_probable_combination() -> None:
    """What no run tells from it is not among those that the run tells from it."""
    run = diagnosed("dev04").to_dict()["next_run"]
    assert run["most_probable"] == "no further effect" and run["untold"]
    assert run["most_probable"] in run["separates"] and len(run["separates"]) > 1
    assert not set(run["separates"]) & set(run["untold"])


def test_a_spring_without_a_run_says_what_helps() -> None:
    spring = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.6},
        "uncertainty": {"contact_stiffness_rel": 0.01, "torque_gain_rel": 0.1},
    }
    torque = np.r_[np.linspace(0, 20, 30), np.linspace(20, -20, 60)]
    noise = np.random.default_rng(3).normal(0, 5, len(torque))
    table = {"torque_Nm": torque, "elastic_angle_arcsec": 130 * torque + noise}
    d = cbpt.diagnose(spring, table | {"u_elastic_angle_arcsec": np.full(len(torque), 5.0)})
    assert d.verdict.kind == "ambiguous" and d.next_run() is None
    assert "Runs are computed for ball drives alone" in " ".join(d.report().split())


def test_what_the_suggested_run_brings_is_what_a_diagnosis_with_it_finds() -> None:
    """Repeated until it should decide, the true effect gains over the rival."""
    found = suggested()
    assert found.best is not None
    again = read_plan(short_campaign()).runs
    best = replace(found.best.run, u_elastic_angle_arcsec=0.3)
    more = Plan.of_runs([*again, *[best] * 6])
    after = cbpt.diagnose(CASE, cbpt.simulate(CASE, more, effects=BEARING, seed=0))

    def lead(d: cbpt.Diagnosis) -> float:
        odds = d.competition.log_odds
        return odds[("eccentric_bearing",)] - odds[("bearing_play",)]

    assert lead(after) > lead(found.diagnosis) + 0.5


def test_what_is_perhaps_there_is_open_too() -> None:
    """Open are combinations, named by what not all of them have."""
    d = diagnosed("dev09")
    names = open_hypotheses(d).fits
    likely = [e for e, _ in d.verdict.perhaps]
    assert likely and all(any(e in name.split(" + ") for name in names) for e in likely)
    assert not any(e in name.split(" + ") for e in d.verdict.effects for name in names)


def test_runs_that_lack_what_an_effect_depends_on_are_told_with_the_remedy() -> None:
    found = ranked(suggested().diagnosis, Limits(8.0, (600.0, 900.0), dwell_s=None))
    assert "creep" in found.why_none and "cannot be computed for a further run" in found.why_none
    assert "have no time_s; set dwell_s of the limits" in found.why_none


def test_columns_that_the_readings_lack_are_none_of_the_runs() -> None:
    """Limits state a dwell unless told otherwise; readings without times gain nothing by it."""
    readings = cbpt.simulate(CASE, short_campaign(), effects=BEARING, seed=0)
    d = cbpt.diagnose(CASE, replace(readings, time_s=None))
    assert ranked(d, Limits(8.0, (600.0, 900.0)), most=20).ranked


def test_numbers_that_share_a_shift_are_open_and_no_run_decides_between_them() -> None:
    d = suggested().diagnosis
    shared = ("contact_angle", "preload_scale")
    verdict = replace(d.verdict, kind="ambiguous", rivals=(shared,), within_uncertainty=True)
    found = ranked(replace(d, verdict=verdict))
    assert set(found.open) == set(shared) and not found.ranked
    assert found.twins == (shared,) and "No run on this rig" in found.report()
    assert found.why_none.startswith("No run within the limits can decide")


def test_where_nothing_has_a_name_all_say_where_to_measure_more() -> None:
    d = diagnosed("dev10")
    advice = d.to_dict()["unknown"]["measure_next"]
    assert "depends on the torque and the input angle" in advice
    # The groove is damaged at 130 deg.
    assert "largest near torque 8 N m, input angle 130 deg" in advice
    assert "vary the torque and the input angle one at a time" in advice
    assert ranked(d).why_none == advice
    assert advice in " ".join(d.report().split())


@pytest.mark.parametrize(
    ("columns", "size", "said"),
    [
        (("torque_Nm", "direction"), [0, 0, 5, 9, 0, 0], "direction of loading and is largest near "
         "torque 3 N m, torque rising; it exceeds twice the noise only at torque 2 to 3 N m, "
         "torque rising. Measure more readings there, and vary the torque and the direction of "
         "loading one at a time, with all else constant."),
        (("torque_Nm",), [1, 0, 0, 0, 0, 0], "near torque 0 N m; no single reading shows it, as "
         "it stays below twice the noise. Take each reading there several times, and vary the "
         "torque alone, with all else constant."),
        (("time_s",), [9, 0, 0, 0, 0, 9], "near time 0 s. Measure more readings there, and vary "
         "time alone, with all else constant (for time: hold a load and wait)."),
        (("run",), [0, 0, 0, 9, 9, 9], "depends on the run. Repeat a run unchanged, to see whether "
         "the misfit is the same."),
        (("preload_step",), [0, 0, 0, 9, 9, 9], "depends on the preload step. Vary the preload "
         "step alone, with all else constant."),
    ],
)  # fmt: skip
def test_the_advice_names_places_where_there_are_any(
    columns: tuple[str, ...], size: list[float], said: str
) -> None:
    noise = SimpleNamespace(scale=2.0)
    pattern = SimpleNamespace(columns=columns, fitted_arcsec=np.array(size, float), noise=noise)
    readings = SimpleNamespace(
        torque_Nm=np.array([0.0, 1, 2, 3, 2, 1]),
        time_s=np.arange(6.0),
        run_index=np.repeat([0, 1], 3),
        preload_step=np.repeat(["a", "b"], 3),
        direction=lambda: np.array([0, 1, 1, 1, -1, -1]),
    )
    campaign = SimpleNamespace(u_arcsec=np.ones(6))
    d: Any = SimpleNamespace(
        verdict=SimpleNamespace(lack_of_fit=pattern, effects=()),
        competition=SimpleNamespace(campaign=campaign),
        readings=readings,
    )
    assert measure_next(d).endswith(said)


def test_suggested_runs_decide_sooner_than_random_ones() -> None:
    """The short form of benches/next_run.py."""
    seen = view_of(CASE, *BEARING[0], seed=5)
    assert seen is not None
    found = race(seen, np.random.default_rng(0), 4)
    assert found is not None and found.suggested is not None
    drawn = [15 if n is None else n for n in found.random]
    assert found.suggested <= 0.8 * np.mean(drawn)


# --- the document and the verb ------------------------------------------------------------


def test_the_verb_writes_the_run_as_a_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, out = tmp_path / "data.csv", tmp_path / "next.toml"
    readings = cbpt.simulate(CASE, short_campaign(), effects=BEARING, seed=0)
    table.write_text(table_text(readings))
    given = ["next-run", str(CASE), str(table)]
    limits = ["--torque-Nm", "8", "--preload-N", "600", "900", "--candidates", "30"]
    assert commands.main([*given, *limits, "--json", "--out", str(out)]) == 0
    document = strictly(capsys.readouterr().out)
    assert document["schema"] == "cbpt.next_run/1" and 0 < len(document["runs"]) <= 30
    (run,) = read_plan(out).runs
    assert run.preload_N == document["runs"][0]["preload_N"]
    assert 600 <= document["runs"][0]["preload_N"] <= 900
    assert commands.main([*given, "--candidates", "0"]) == 2
    assert commands.main([*given, "--preload-N", "9", "3"]) == 2


def test_the_report_names_what_is_open() -> None:
    report = suggested().report()
    assert (
        "Hypotheses, with the share of each among these: " in report
        and f"{LIMIT:.1f} or more, {np.exp(LIMIT):.0f} : 1, decide" in report
    )
    assert set(open_hypotheses(suggested().diagnosis).fits) == set(suggested().open)
    d = suggested().diagnosis
    runs = candidates(d.competition.campaign.drive, limits_of(d.readings), 3)
    assert prospect(open_hypotheses(d), runs) is not None
