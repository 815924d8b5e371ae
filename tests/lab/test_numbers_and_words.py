"""Numbers and words of an answer do not contradict each other.

Groups: the uncertainty of a reading; zeros of runs; the ladder of errors; the scatter of a coarse
display; a case from the answer; what may have been overlooked; a torsion spring.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbpt import Case, compare, fit, read_readings, simulate
from cbpt.lab.diagnosis.alternatives import smallest
from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.diagnosis.diagnosis_data import Rung
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.wording.numbers import ARCSEC, percent
from cbpt.page.document.document import page_document
from common.documents import SOURCE
from common.hidden import ANGLE, U, case_of, diagnosed, table_of

EXAMPLES = Path(__file__).parents[2] / "examples"

# --- the uncertainty of a reading ---------------------------------------------------------


def with_u(u_arcsec: float | None, step_arcsec: float = 0.0) -> Diagnosis:
    """The complete model of `dev01`, whose readings scatter by 0.31 arcsec, with another
    uncertainty stated, on a display of some step.
    """
    table = dict(table_of("dev01"))
    if u_arcsec is None:
        del table[U]
    else:
        table[U] = np.full(len(table[U]), u_arcsec)
    if step_arcsec:
        table[ANGLE] = np.round(table[ANGLE] / step_arcsec) * step_arcsec
    return diagnose(Case.from_toml(case_of("dev01")), table)


def words(d: Diagnosis) -> str:
    return " ".join(d.report().split())


def test_without_a_stated_uncertainty_chi2_is_held_against_the_estimate() -> None:
    document = with_u(None).to_dict()
    for part in (document["before"], document["after"], *document["ladder"]):
        assert part["chi2_per_dof"] == pytest.approx(1.0, abs=0.02)
    noise = document["noise"]
    assert noise["u_stated_arcsec"] is None and noise["u_from"] == "scatter"
    assert noise["u_says"].startswith("No uncertainty is stated, so")


def test_an_uncertainty_that_cannot_be_meant_is_not_what_was_used() -> None:
    noise = with_u(0.003).to_dict()["noise"]
    assert noise["u_stated_arcsec"] == pytest.approx(0.003) and noise["u_from"] == "scatter"
    assert "states an uncertainty of 0.003 arcsec, but" in noise["u_says"]
    assert "used instead" in noise["u_says"]


def test_the_scatter_has_no_more_degrees_of_freedom_than_readings_less_what_was_fitted() -> None:
    noise = diagnosed("dev11").to_dict()["noise"]
    assert noise["u_dof"] <= 9 - 1
    assert "(8 degrees of freedom)" in noise["u_says"]
    # What is stated counts as well, which is told apart.
    assert f"Combined, the two give {noise['u_estimated_arcsec']:.3g} arcsec" in noise["u_says"]


@cache
def coarse() -> Diagnosis:
    return with_u(0.43, 1.0)


def test_a_coarse_display_has_the_uncertainty_that_is_stated() -> None:
    d = coarse()
    document = d.to_dict()
    noise, after = document["noise"], document["after"]
    assert noise["u_stated_arcsec"] == pytest.approx(0.43)
    assert noise["u_estimated_arcsec"] == pytest.approx(after["rmse_arcsec"], rel=0.02)
    assert noise["u_dof"] < len(d.readings)
    assert after["chi2_per_dof"] == pytest.approx((after["rmse_arcsec"] / 0.43) ** 2, rel=0.02)
    assert after["noise_floor_arcsec"] == noise["u_estimated_arcsec"] == d.noise_floor_arcsec
    assert f"; noise {d.noise_floor_arcsec:.3f} arcsec)" in words(d)
    assert "was added to it" not in words(d)


def test_rounding_is_added_to_an_uncertainty_that_cannot_include_it() -> None:
    d = with_u(0.1, 1.0)
    document = d.to_dict()
    assert document["noise"]["u_stated_arcsec"] == pytest.approx(0.1)
    assert "step / sqrt(12) = 0.289 arcsec), which was added to it" in words(d)
    u = np.hypot(0.1, 1 / np.sqrt(12))
    after = document["after"]
    assert after["chi2_per_dof"] == pytest.approx((after["rmse_arcsec"] / u) ** 2, rel=0.02)


@pytest.mark.parametrize("step_arcsec", [0.6, 1.0, 2.0])
def test_a_display_that_hides_the_scatter_does_not_misstate_it(step_arcsec: float) -> None:
    """What the readings scatter by was taken for as little as a fit allows, and told as found."""
    d = with_u(0.3, step_arcsec)
    assert (d.verdict.kind, d.verdict.noise) == ("complete", ("white",))


def test_a_scatter_other_than_stated_is_found_behind_a_display() -> None:
    d = with_u(0.1, 0.6)
    assert d.verdict.noise == ("misstated",)
    assert d.verdict.adequacy is not None
    assert d.verdict.adequacy.left_arcsec == pytest.approx(0.31, rel=0.1)
    assert f"found {d.verdict.adequacy.left_arcsec:.3g} arcsec" in words(d)


def test_readings_that_are_known_worse_tell_no_more_behind_a_display() -> None:
    """That nothing is missing was said once every fifth reading had an uncertainty of 30 arcsec."""
    table = dict(table_of("dev01"))
    table[ANGLE] = np.round(table[ANGLE] / 5) * 5
    table[U] = np.where(np.arange(len(table[U])) % 5 == 0, 30.0, 0.3)
    d = diagnose(Case.from_toml(case_of("dev01")), table)
    assert d.verdict.kind not in ("complete", "rig")


@pytest.mark.parametrize("step_arcsec", [6.0, 12.0])
def test_that_nothing_is_missing_is_not_said_where_rounding_would_hide_it(
    step_arcsec: float,
) -> None:
    """The bearing of `dev03` shows with 2.5 arcsec, of which the numbers of the drive take most."""
    table = dict(table_of("dev03"))
    table[ANGLE] = np.round(table[ANGLE] / step_arcsec) * step_arcsec
    d = diagnose(Case.from_toml(case_of("dev03")), table)
    assert (d.verdict.kind, d.verdict.undecided) == ("undecided", "few readings")
    assert "Record the angle in finer steps" in words(d)


# --- zeros of runs ------------------------------------------------------------------------


def test_zeros_of_runs_are_no_error_anywhere() -> None:
    """Every run of `dev02` has a zero of its own, of 0.8 arcsec; readings scatter by 0.3."""
    d = diagnosed("dev02")
    document = d.to_dict()
    assert document["noise"]["run_offset_arcsec"] > 0.5
    for part in (document["before"], document["after"], *document["ladder"]):
        assert part["rmse_arcsec"] == pytest.approx(part["held_out_rmse_arcsec"], rel=0.1)
        assert part["chi2_per_dof"] == pytest.approx(1.0, abs=0.15)
    assert d.noise_floor_arcsec == pytest.approx(document["after"]["rmse_arcsec"], rel=0.05)
    for residual in (d.residual_before_arcsec, d.residual_after_arcsec):
        assert np.sqrt(np.mean(residual**2)) == pytest.approx(d.noise_floor_arcsec, rel=0.05)
    assert "with an offset for each run" in document["noise"]["u_says"]


def test_compare_diagnose_and_fit_start_from_one_error_and_say_what_is_subtracted() -> None:
    """Beside correlated noise, zeros of runs stayed in the error of a fit: it began at 368 arcsec,
    the comparison at 358."""
    files = EXAMPLES / "reducer.toml", EXAMPLES / "reducer.csv"
    compared, d, fitted = compare(*files), diagnose(*files), fit(*files, ["backlash"])
    assert compared.overall is not None
    start = compared.overall.rmse_arcsec
    assert fitted.before.rmse_arcsec == pytest.approx(start, rel=1e-9)
    # Outliers, which a diagnosis looks for, count less in its zeros.
    assert d.ladder[0].rmse_arcsec == pytest.approx(start, rel=0.005)
    assert "for each of 3 runs and subtracted, as diagnose and fit do" in compared.report()
    for told in (words(d), fitted.report()):
        assert "); an offset for each run is subtracted:" in told
        # Its three steps of the preload may be compared, too.
        assert "cbpt change --by preload_step (change) says what differs between them" in told


def test_of_a_common_zero_compare_says_that_it_stays_in() -> None:
    files = EXAMPLES / "campaign.toml", EXAMPLES / "campaign.csv"
    assert "; diagnose and fit always subtract one" in compare(*files).report()
    assert "); a common offset is subtracted:" in words(diagnose(*files))


def test_a_noise_floor_is_claimed_only_of_a_model_that_holds_all() -> None:
    d = diagnosed("dev10")
    document = d.to_dict()
    assert document["verdict"]["kind"] == "unknown" and d.noise_floor_arcsec is None
    for part in ("before", "after"):
        assert document[part]["noise_floor_arcsec"] is None
        assert document[part]["noise_floor_of"] == (
            "is unknown: no model explains all of the misfit"
        )
    assert "the noise floor is unknown: no model explains all of the misfit)" in words(d)
    assert "(noise" not in words(d)
    after = diagnosed("dev04").to_dict()["after"]
    assert after["noise_floor_arcsec"] > 0
    assert after["noise_floor_of"] == "scatter about the answer"


def test_no_number_is_minus_nothing() -> None:
    assert re.findall(r"-0(?![.\d])", words(diagnosed("dev10"))) == []


# --- the ladder of errors -----------------------------------------------------------------


@pytest.mark.parametrize("loose", [False, True])
def test_an_error_held_out_far_below_in_sample_is_explained_once(loose: bool) -> None:
    d = diagnosed("dev04")
    if loose:
        below = [replace(r, held_out_rmse_arcsec=0.7 * r.rmse_arcsec) for r in d.ladder]
        d = replace(d, ladder=tuple(below))
    says = "means that the stated form does not fit"
    assert words(d).count(says) == loose
    told = d.to_dict()["ladder_says"]
    assert says in told if loose else told is None


def test_only_an_effect_has_a_form_that_may_not_hold() -> None:
    assert Rung("creep", 1.0, 0.79, 1.0, of_effects=True).loose
    assert not Rung("creep", 1.0, 0.81, 1.0, of_effects=True).loose
    assert not Rung("parameters refitted", 1.0, 0.5, 1.0).loose
    assert not Rung("creep", 1.0, float("nan"), 1.0, of_effects=True).loose


# --- the scatter of a coarse display ------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_what_rounding_hides_is_not_held_against_a_true_model(seed: int) -> None:
    case, plan = EXAMPLES / "campaign.toml", EXAMPLES / "plan.toml"
    readings = simulate(case, plan, noise="quantised=3.3", seed=seed, u_elastic_angle_arcsec=0.3)
    c = compare(case, readings)
    assert c.scatter is not None and c.scatter.step_arcsec == pytest.approx(0.99)
    assert c.scatter.u_arcsec >= 0.99 / np.sqrt(12) and not c.scatter.off
    assert "disagrees" not in c.report() and "scatter is hardly known" in c.report()


def test_a_wrong_model_is_off_in_spite_of_the_steps() -> None:
    case, plan = EXAMPLES / "campaign.toml", EXAMPLES / "plan.toml"
    readings = simulate(case, plan, noise="quantised=3.3", u_elastic_angle_arcsec=0.3)
    bent = replace(readings, elastic_angle_arcsec=readings.elastic_angle_arcsec * 4.0)
    assert "even with this scatter the model disagrees" in compare(case, bent).report()


def test_a_scatter_that_is_hardly_known_is_no_agreement() -> None:
    """Angles in degrees under a header in radians "agreed", 76 times the scatter off."""
    read = read_readings(EXAMPLES / "reducer.csv", need_preload=False)
    table: dict[str, Any] = {
        "run": read.run,
        "time_s": read.time_s,
        "torque_Nm": read.torque_Nm,
        "elastic_angle_rad": read.elastic_angle_arcsec / 3600,
    }
    c = compare(EXAMPLES / "reducer.toml", table)
    assert c.p_value_of_scatter is not None and c.p_value_of_scatter > 0.01
    assert "this scatter is known too roughly to judge the model by it" in c.report()
    assert "Likely mistake" in c.report() and "the model agrees" not in c.report()


# --- a case from the answer ---------------------------------------------------------------


def test_the_answer_has_all_that_a_case_needs() -> None:
    """Put back into a case, an effect does what was found."""
    effect = ("groove_pitch_error", {"sine_um": 2.0, "harmonic": 4})
    case, plan = EXAMPLES / "campaign.toml", EXAMPLES / "plan.toml"
    readings = simulate(case, plan, effects=[effect], u_elastic_angle_arcsec=0.1)
    d = diagnose(case, readings)
    document = d.to_dict()
    assert document["verdict"]["effects"] == [effect[0]]
    found = document["parameters"][effect[0]]
    assert found["harmonic"]["value"] == 4 and found["harmonic"]["u"] is None
    assert document["ranking"][0]["parameters"].keys() == found.keys()
    assert "harmonic 4" in d.sentence


# --- what may have been overlooked --------------------------------------------------------


def test_nothing_is_missing_says_what_could_not_have_been_seen() -> None:
    d = diagnosed("dev01")
    unseen_ones = [one for one in smallest(d) if one.share > 0.5]
    assert unseen_ones
    for one in unseen_ones:
        assert one.says(ARCSEC) in words(d)
    lot = next(e for e in d.to_dict()["detectable"] if e["effect"] == "ball_diameter_lot")
    assert list(lot["smallest"]) == ["spread_m"] and 1e-8 < lot["smallest"]["spread_m"] < 1e-5
    pitch = next(e for e in d.to_dict()["detectable"] if e["effect"] == "groove_pitch_error")
    assert "harmonic" in pitch["smallest"]


def test_a_number_that_moved_says_what_else_that_could_be() -> None:
    case, plan = EXAMPLES / "campaign.toml", EXAMPLES / "plan.toml"
    softer = [("contact_stiffness", {"stiffness_scale": 0.86})]
    d = diagnose(case, simulate(case, plan, effects=softer, u_elastic_angle_arcsec=0.1))
    document = d.to_dict()
    assert document["verdict"]["kind"] == "complete"
    number = next(m for m in document["moved"] if m["number"] == "contact_stiffness")
    assert number["by_sigma"] == pytest.approx(-1.4, abs=0.2)
    assert "sensor_gain" in number["could_be"]
    told = "The change of the contact stiffness could also be caused by "
    assert told in words(d) and "a wrong gain of the angle sensor" in words(d).partition(told)[2]


@pytest.mark.parametrize("name", ["dev03", "dev11", "dev12"])
def test_no_answer_is_its_own_alternative(name: str) -> None:
    verdict = diagnosed(name).to_dict()["verdict"]
    assert not {r["number"] for r in verdict["rests_on"]} & set(verdict["effects"])


# --- a torsion spring ---------------------------------------------------------------------


SPRING = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.6},
    "uncertainty": {"contact_stiffness_rel": 0.01, "torque_gain_rel": 0.1},
}


def loops_of_a_spring(u_arcsec: float, gain: float = 1.0) -> Any:
    """Two loops to +-20 N m with noise of 5 arcsec."""
    once = np.r_[np.linspace(0, 20, 15), np.linspace(20, -20, 30), np.linspace(-20, 0, 15)]
    torque = np.tile(once, 2)
    rng = np.random.default_rng(2)
    angle = gain * torque / 0.6 * 60
    return {
        "run": np.repeat([1, 2], len(once)),
        "time_s": 0.5 * np.arange(2.0 * len(once)),
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle + 5.0 * rng.standard_normal(len(torque)),
        "u_elastic_angle_arcsec": np.full(len(torque), u_arcsec),
    }


def test_numbers_of_a_torsion_spring_have_its_own_names() -> None:
    table = loops_of_a_spring(5.0, gain=1.28)
    d = diagnose(SPRING, table)
    case, readings = case_and_readings(SPRING, table)
    page = page_document(case, readings, SOURCE, d)
    assert {r["number"] for r in d.to_dict()["verdict"]["rests_on"]} == {
        "contact_stiffness",
        "torque_scale",
    }
    assert [(r["label"], r["prior"]) for r in page["rests_on"]] == [
        ("the torsional stiffness", "1 %"),
        ("the gain of the torque readings", "10 %"),
    ]
    told = words(d)
    assert "changed by the fit: the gain of the torque readings +2" in told
    # What a torsion spring does not have causes nothing.
    assert "a torsional stiffness other than stated or a wrong gain of the angle sensor" in told
    assert "contact angle" not in told and "preload" not in told.partition("could also")[2]


def test_an_answer_says_where_the_readings_scatter_more_than_stated() -> None:
    for u_arcsec, said in ((5.0, False), (2.5, True)):
        d = diagnose(SPRING, loops_of_a_spring(u_arcsec, gain=1.25))
        assert ("misstated" in d.verdict.noise) == said
        noise = d.to_dict()["noise"]
        times = f"{noise['u_estimated_arcsec'] / noise['u_stated_arcsec']:.2g}"
        told = f" The readings scatter about this answer {times} times as much as is stated"
        assert (told in words(d)) == said
        assert ("times as much as is stated" in d.sentence_in("arcmin")) == said
    # Beside what has no name the readings scatter by more, and a part of that is misfit.
    unnamed = diagnosed("dev10")
    assert unnamed.verdict.lack_of_fit and "misstated" in unnamed.verdict.noise
    assert "times as much" not in words(unnamed)


@pytest.mark.parametrize(
    ("share", "told"),
    [(0.0, "0 %"), (0.002, "under 1 %"), (0.5, "50 %"), (0.998, "over 99 %"), (1.0, "100 %")],
)
def test_a_share_is_all_only_where_nothing_is_left(share: float, told: str) -> None:
    """'What is named explains 100 % of the misfit. A misfit remains' contradicts itself."""
    assert percent(share) == told
