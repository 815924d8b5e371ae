"""The table of results: uncertainties, what they rest on, the angle at a load.

Groups: the budget against the formula written down; rounding; the angle at a load; why there is no
uncertainty; the table as text, CSV, Markdown and JSON; the verbs.
"""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt import InvalidInputError
from cbpt.cli import main as commands
from cbpt.lab.inference.budget import READINGS, Budget
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.prediction import Load, angle_at
from cbpt.lab.inference.residuals import rmse_of
from cbpt.lab.inference.results import Result, Results, results_of
from cbpt.lab.model.priors import PRIORS
from common.comparisons import CAMPAIGNS
from common.simulated import (
    Values,
    dense,
    drawn_numbers,
    hypothesis_of,
    plan,
    readings_of,
    truth,
    variant_of,
)

PLANTED = {("output_torsion", "compliance_rad_per_Nm"): 2e-6}
EFFECT = "output_torsion"


def fitted(values: Values, seed: int, exact: bool = False) -> tuple[Fitter, Fit]:
    campaign = readings_of(plan("dev03"), values, np.random.default_rng([23, seed]))
    if exact:
        campaign = replace(campaign, priors=dict.fromkeys(PRIORS, 0.0))
    fitter = Fitter(campaign, [variant_of(EFFECT)])
    found = fitter.fit(hypothesis_of(EFFECT))
    assert found is not None
    return fitter, found


@cache
def example(exact: bool = False) -> tuple[Fitter, Fit]:
    return fitted(PLANTED, 1, exact)


@cache
def table(exact: bool = False) -> Results:
    fitter, fit = example(exact)
    return results_of(
        fitter,
        fit,
        [("rmse", rmse_of(fitter.campaign, fit))],
        angle_at(fitter, fit, Load(5.0, 600.0)),
    )


# --- the budget ---------------------------------------------------------------------------


def test_the_budget_is_the_formula_written_down() -> None:
    """With the covariance of the readings as a dense matrix, nothing whitened, nothing scaled."""
    fitter, fit = example()
    c = fitter.campaign
    inverse = np.linalg.inv(dense(fit.noise, c.u_arcsec, c.rows))
    x = np.column_stack([fit.point.slopes, c.offsets])
    prior = np.diag(np.r_[[u.sd**-2.0 for u in fit.unknowns], np.zeros(c.offsets.shape[1])])
    seen = x.T @ inverse @ x
    covariance = np.linalg.inv(seen + prior)
    from_readings = covariance @ seen @ covariance
    results = table()
    budget = Budget.of(fitter, fit)
    for i, unknown in enumerate(fit.unknowns):
        found = budget.combined(budget.gradient(unknown))
        assert found is not None
        assert found.u == pytest.approx(np.sqrt(covariance[i, i]), rel=1e-6)
        assert found.u == pytest.approx(fit.u(unknown), rel=1e-9)
        share = from_readings[i, i] / covariance[i, i]
        assert found.shares.get(READINGS, 0.0) == pytest.approx(share, abs=0.006)
        for j, other in enumerate(fit.unknowns):
            source = f"stated {PRIORS.get(other.name, '').rpartition('_')[0]}"
            if other.name in PRIORS:
                part = covariance[i, j] ** 2 * prior[j, j] / covariance[i, i]
                assert found.shares.get(source, 0.0) == pytest.approx(part, abs=0.006)
        assert sum(found.shares.values()) == pytest.approx(1, abs=0.03)
    assert results["zero of the readings"].u == pytest.approx(np.sqrt(covariance[-1, -1]), rel=1e-6)


def test_without_priors_everything_is_type_a() -> None:
    fitter = example(True)[0]
    for row in table(True):
        if row.u is not None:
            assert row.evaluation == "A" and dict(row.rests_on) == {READINGS: pytest.approx(1)}
            # The readings less the zero and the one parameter, and what the stated u counts as.
            assert row.dof == pytest.approx(len(fitter.campaign) - 2 + fitter.stated_dof)
            assert row.coverage_factor == pytest.approx(1.966, abs=1e-3)
            assert row.coverage_factor is not None
            assert row.expanded == pytest.approx(row.coverage_factor * row.u)


def test_a_number_that_the_readings_cannot_see_keeps_its_prior() -> None:
    row = table()["sensor_gain.sensor_gain"]
    assert row.evaluation == "B" and row.rests_on[0][0] == "stated sensor_gain"
    assert row.u == pytest.approx(0.005, rel=0.05)
    assert row.coverage_factor == pytest.approx(1.96, abs=2e-3)


def test_correlations_are_told_both_ways() -> None:
    rows = {row.name: dict(row.correlated_with) for row in table()}
    assert any(rows.values())
    for name, others in rows.items():
        for other, r in others.items():
            assert rows[other][name] == pytest.approx(r) and 0.7 <= abs(r) <= 1


# --- rounding -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "u", "shown"),
    [
        (0.208590, 0.0099939, ("0.209", "0.010")),
        (0.208590, 0.0123456, ("0.209", "0.012")),
        (28.624, 0.29433, ("28.62", "0.29")),
        (28.624, 12.3, ("29", "12")),
        (28624.0, 1234.0, ("28600", "1200")),
        (-1.5e-9, 2.34e-10, ("-1.50e-09", "2.3e-10")),
        (0.0, 0.5, ("0.00", "0.50")),
        (99.96, 0.0996, ("99.96", "0.10")),
    ],
)
def test_two_digits_of_the_uncertainty(value: float, u: float, shown: tuple[str, str]) -> None:
    assert Result("x", "effect", value, "", u=u, expanded=2 * u).rounded[:2] == shown


def test_without_an_uncertainty_four_digits() -> None:
    assert Result("x", "error", 1.234567, "").rounded == ("1.235", "", "")
    assert Result("x", "error", None, "").rounded == ("", "", "")


# --- the angle at a load ------------------------------------------------------------------


def test_at_the_loads_of_the_readings_it_is_the_model() -> None:
    """With gains of 1 the drive's own angle is what the sensor shows, less the zero."""
    fitter, fit = example(True)
    r = fitter.campaign.readings
    assert r.preload_N is not None
    at = angle_at(fitter, fit, Load(r.torque_Nm, r.preload_N, r.input_angle_deg))
    model = fitter.campaign.y_arcsec - fit.residual_arcsec - fit.offsets_arcsec[0]
    np.testing.assert_allclose(at.elastic_angle_arcsec, model, rtol=1e-9, atol=1e-9)
    assert at.inside.all() and (at.u_elastic_angle_arcsec[np.abs(r.torque_Nm) > 0] > 0).all()


def test_the_interval_covers_the_truth() -> None:
    """Drives and rigs off as much as is stated: the drive's own angle, not the sensor's."""
    z = []
    torque, preload = np.array([2.0, 6.0, -7.5]), np.array([500.0, 900.0, 700.0])
    for seed in range(30):
        rng = np.random.default_rng([29, seed])
        numbers = drawn_numbers(plan("dev03"), rng)
        fitter, fit = fitted(numbers | PLANTED, seed)
        at = angle_at(fitter, fit, Load(torque, preload))
        own = {
            key: value
            for key, value in numbers.items()
            if key[0] in ("contact_stiffness", "contact_angle")
        }
        c = fitter.campaign
        there = replace(
            c,
            readings=cbpt.read_readings(
                {
                    "run": np.arange(3),
                    "torque_Nm": torque,
                    "preload_N": preload,
                    "elastic_angle_arcsec": 0 * torque,
                }
            ),
        )
        there = type(there).of(c.drive, there.readings)
        z.append(
            (truth(there, own | PLANTED) - at.elastic_angle_arcsec) / at.u_elastic_angle_arcsec
        )
    spread = np.sqrt(np.mean(np.square(z), axis=0))
    # Standard deviations of 30 draws, each angle by itself, lie here in 999 of 1000 cases.
    assert (spread > 0.57).all() and (spread < 1.5).all(), spread


def test_beyond_the_readings_is_told() -> None:
    fitter, fit = example()
    at = angle_at(fitter, fit, Load([1.0, 1.0, 500.0], [600.0, 5000.0, 600.0]))
    assert at.inside.tolist() == [True, False, False]
    assert np.isnan(at.elastic_angle_arcsec[2]) and np.isnan(at.u_elastic_angle_arcsec[2])
    assert at.status[2] == "beyond_hold"
    results = results_of(fitter, fit, load=at)
    row = results["elastic angle at 500 N m, 600 N, 0 deg"]
    assert row.value is None and row.why_no_u == "no solution: beyond_hold"
    assert "extrapolated" in results.report()


@pytest.mark.parametrize(
    ("load", "found"),
    [
        ((np.nan, 600.0, 0.0), "torque_Nm = nan"),
        ((1.0, 0.0, 0.0), "preload_N = 0: expected a finite number above 0"),
        ((1.0, 600.0, np.inf), "input_angle_deg = inf"),
        (([1.0, 2.0], [1.0, 2.0, 3.0], 0.0), "they must broadcast to one"),
        (("a", 600.0, 0.0), "torque_Nm holds <U1, but must hold numbers"),
    ],
)
def test_loads_that_cannot_be(load: tuple[float, float, float], found: str) -> None:
    with pytest.raises(InvalidInputError, match=found.replace("(", r"\(")):
        angle_at(*example(), Load(*load))


# --- why there is no uncertainty ----------------------------------------------------------


def test_every_quantity_has_an_uncertainty_or_a_reason() -> None:
    for results in (table(), table(True)):
        for row in results:
            assert (row.u is None) == bool(row.why_no_u)
            assert (row.u is None) == (row.expanded is None) == (not row.evaluation)


def test_a_number_stated_as_exact_says_so() -> None:
    row = table(True)["contact_angle.contact_angle_shift_deg"]
    assert row.why_no_u == "the case states it as exact (contact_angle_rad = 0)" and row.value == 0


def test_what_was_chosen_says_so() -> None:
    values = {("groove_pitch_error", "cosine_m"): 4e-6, ("groove_pitch_error", "harmonic"): 3.0}
    campaign = readings_of(plan("dev03"), values, np.random.default_rng(3))
    fitter = Fitter(campaign, [variant_of("groove_pitch_error", "fixed groove, harmonic 3")])
    fit = fitter.fit(hypothesis_of("groove_pitch_error", "fixed groove, harmonic 3"))
    assert fit is not None
    row = results_of(fitter, fit)["groove_pitch_error.harmonic"]
    assert row.value == 3 and "chosen among the forms" in row.why_no_u


def test_at_the_end_of_the_range_says_so() -> None:
    """Play is never negative; readings that want it so hold it at 0."""
    values = {("output_torsion", "compliance_rad_per_Nm"): 2e-6}
    campaign = readings_of(plan("dev03"), values, None)
    below = replace(campaign, y_arcsec=campaign.y_arcsec - np.sign(campaign.readings.torque_Nm))
    fitter = Fitter(below, [variant_of("bearing_play")])
    fit = fitter.fit(hypothesis_of("bearing_play"), fitter.start(hypothesis_of("bearing_play"), {}))
    assert fit is not None
    row = results_of(fitter, fit)["bearing_play.clearance_um"]
    assert row.u is None and "end of its allowed range" in row.why_no_u


def test_where_something_has_no_name_nothing_has_an_uncertainty() -> None:
    results = results_of(*example(), why_no_u="something else is at work")
    assert all(row.u is None and row.why_no_u for row in results)


# --- the table ----------------------------------------------------------------------------


def test_the_table_in_all_its_forms() -> None:
    results = table()
    rows = list(csv.DictReader(results.to_csv().splitlines()))
    assert [row["name"] for row in rows] == [row.name for row in results]
    for text, row in zip(rows, results, strict=True):
        assert (float(text["u"]) if text["u"] else None) == row.u
    document = json.loads(results.to_json())
    assert document["results"] == json.loads(json.dumps(results.to_list()))
    assert document["results"][0]["rests_on"].keys() <= {
        READINGS,
        *(f"stated {key.rpartition('_')[0]}" for key in PRIORS.values()),
    }
    lines = results.to_markdown().splitlines()
    assert lines[1] == "|" + "---|" * 7 and lines[2].startswith("| output_torsion.compliance")
    assert max(map(len, results.report().splitlines())) <= 100
    with pytest.raises(KeyError, match="which are: output_torsion"):
        results["no such"]


def test_the_table_is_told_in_another_unit() -> None:
    plain, told = table(), table().told_in("arcmin")
    by_name = {row.name: row for row in told}
    assert [row.kind for row in plain] == [row.kind for row in told]
    for row, other in zip(plain, told, strict=True):
        factor = 1 / 60 if row.unit.startswith("arcsec") else 1.0
        assert other.unit == row.unit.replace("arcsec", "arcmin")
        for one, two in ((row.value, other.value), (row.u, other.u)):
            assert (one is None) == (two is None)
            assert one is None or two == pytest.approx(factor * one)
        assert {name for name, _ in other.correlated_with} <= by_name.keys()
    assert "output_torsion.compliance_arcmin_per_Nm" in by_name
    with pytest.raises(InvalidInputError, match="angle_unit"):
        plain.told_in("N m")


def test_while_it_is_undecided_the_angle_has_no_uncertainty_and_every_combination_its_own() -> None:
    """An angle by the numbers of the drive alone stood there with an uncertainty of a twentieth of
    what the leading combination gives otherwise."""
    d = cbpt.diagnose(CAMPAIGNS / "dev11.toml", CAMPAIGNS / "dev11.csv")
    assert d.verdict.kind == "undecided"
    found = d.predict(6.0, 600.0)
    assert np.isnan(found.u_elastic_angle_arcsec).all() and "undecided" in str(found.why_no_u)
    probable = [c for c in d.combinations() if c.probability >= 0.05]
    assert len(found.by_rival_arcsec) >= len({c.effects for c in probable}) - 1 > 0


# --- the verbs ----------------------------------------------------------------------------

CASE, DATA = CAMPAIGNS / "dev01.toml", CAMPAIGNS / "dev01.csv"


@cache
def answer() -> cbpt.Diagnosis:
    return cbpt.diagnose(CASE, DATA)


def test_a_diagnosis_has_results() -> None:
    a = answer()
    results = a.results(3, 600)
    assert results["elastic angle at 3 N m, 600 N, 0 deg"].u is not None
    assert results["rmse as stated"].value == a.ladder[0].rmse_arcsec
    assert [r["name"] for r in a.to_dict()["results"]] == [r.name for r in a.results()]
    with pytest.raises(InvalidInputError, match="give the preload at which"):
        a.results(3)
    with pytest.raises(InvalidInputError, match="give the torque at which"):
        a.results(preload_N=600)


@pytest.mark.parametrize("name", ["r.csv", "r.md", "r.json"])
def test_the_verb_writes_them(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    known = answer()
    monkeypatch.setattr("cbpt.lab.diagnosis.diagnose.diagnose", lambda *_, **__: known)
    flags = ["--torque-Nm", "3", "--preload-N", "600", "--results", str(tmp_path / name)]
    assert commands.main(["diagnose", *flags, str(CASE), str(DATA)]) == 0
    results = answer().results(3, 600)
    made = {"r.csv": results.to_csv, "r.md": results.to_markdown, "r.json": results.to_json}
    assert (tmp_path / name).read_text() == made[name]()
    assert "U (95 %)" not in capsys.readouterr().out


def test_flags_without_a_file_leave_the_case_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    known = answer()
    monkeypatch.setattr("cbpt.lab.diagnosis.diagnose.diagnose", lambda *_, **__: known)
    assert commands.main(["diagnose", "--results", str(CASE), str(DATA)]) == 0
    assert "U (95 %)" in capsys.readouterr().out
    assert commands.main(["diagnose", "--json", str(CASE), str(DATA)]) == 0
    assert json.loads(capsys.readouterr().out)["schema"] == "cbpt.diagnosis/2"
    assert commands.main(["diagnose", str(CASE), str(DATA), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["results"]
    assert commands.main(["diagnose", "--results=r.txt", str(CASE), str(DATA)]) == 2
    assert "must end in .csv, .md or .json" in capsys.readouterr().err
