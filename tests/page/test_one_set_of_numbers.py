"""What the page draws against the JSON of the answer: the same numbers, the same digits.

Each campaign is a report on disk, opened in a browser; gauge, tables and cards are read.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

import cbpt
from cbpt.lab.diagnosis.fit_text import parameter_words
from cbpt.lab.diagnosis.why import sentence
from cbpt.lab.inference.residuals import left_by
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.wording.numbers import AngleUnit, probability, rounded, with_uncertainty
from cbpt.page.document.document import page_document
from cbpt.page.document.plain import array
from cbpt.page.report import report
from common.browser import DRAWN, PATIENCE_MS, watched
from common.documents import SOURCE
from common.documents import document as document_of
from common.hidden import diagnosed as diagnosed_of

LOOPS = Path(__file__).parents[1] / "data" / "interventions"
THINNED = "base_onyx_1"
"""Loops of a real reducer, each run with its own zero, of which every second reading is judged."""
NAMES = ["dev03", "dev09", THINNED]


@cache
def diagnosed(name: str) -> Any:
    if name != THINNED:
        return diagnosed_of(name)
    with mock.patch("cbpt.lab.diagnosis.diagnose.MOST", 100):
        return cbpt.diagnose(LOOPS / "reducer.toml", LOOPS / f"{name}.csv")


@cache
def document(name: str) -> Any:
    if name != THINNED:
        return document_of(name)
    case, readings = case_and_readings(LOOPS / "reducer.toml", LOOPS / f"{name}.csv")
    return page_document(case, readings, SOURCE, diagnosed(name))


@pytest.fixture(scope="module", params=NAMES)
def opened(
    request: Any, browser: Any, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Any, Any]]:
    """A page of each campaign for all tests, and its diagnosis."""
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(report(document(request.param)), encoding="utf-8")
    with watched(browser) as page:
        page.goto(file.as_uri())
        page.wait_for_selector(DRAWN, timeout=PATIENCE_MS)
        yield page, diagnosed(request.param)


def words(page: Any, selector: str) -> str:
    return " ".join(page.inner_text(selector).replace("−", "-").split())


def rows(page: Any, caption: str) -> list[list[str]]:
    """The cells of a table, the first without what stands small below it."""
    script = """caption => [...document.querySelectorAll("table")]
        .filter(t => t.caption?.textContent === caption)
        .flatMap(t => [...t.querySelectorAll("tbody tr")])
        .map(tr => [...tr.children].map(c => c.innerText.split("\\n")[0].trim()))"""
    found: list[list[str]] = page.evaluate(script, caption)
    return found


@pytest.mark.parametrize("unit", ["arcsec", "mrad"])
def test_every_place_has_the_numbers_of_the_answer(opened: tuple[Any, Any], unit: str) -> None:
    page, d = opened
    answer, angle = d.to_dict(), AngleUnit(unit)
    page.select_option("#unit", unit)
    told = words(page, "#sentence").replace("µm", "um").replace("±", "+-")
    before, after = answer["before"], answer["after"]
    fall = f"{angle.number(before['rmse_arcsec'])} to {angle.text(after['rmse_arcsec'])}"
    assert f"from {fall}" in told and f"from {fall}" in " ".join(d.sentence_in(unit).split())
    drawn = rows(page, "Combinations of effects that the readings leave")
    assert [row[1:] for row in drawn] == [
        [
            probability(c["probability"]),
            angle.number(c["rmse_arcsec"]),
            angle.number(c["held_out_rmse_arcsec"]),
        ]
        for c in answer["combinations"]
        if len(answer["combinations"]) > 1
    ]
    ladder = rows(page, "Error ladder")
    for row, rung in zip(ladder, answer["ladder"], strict=False):
        assert row[1:3] == [
            angle.number(rung["rmse_arcsec"]),
            angle.number(rung["held_out_rmse_arcsec"]),
        ]
        assert row[3].split()[0] == rounded(rung["chi2_per_dof"])
    page.click("#show-answer")
    gauge = words(page, "#gauge")
    assert gauge.startswith(f"{angle.number(after['rmse_arcsec'])} {unit}")
    assert f"held out {angle.number(after['held_out_rmse_arcsec'])}" in gauge
    for why in d.why():
        told = " ".join(sentence(d, why, angle).split()).replace("+-", "±")
        assert told in words(page, "#why")


def test_a_figure_has_the_digits_of_its_uncertainty(opened: tuple[Any, Any]) -> None:
    page, d = opened
    page.select_option("#unit", "arcsec")
    found = [row[1:] for row in rows(page, "Figures of catalogues before and after")]
    told = [[cell.replace("−", "-") for cell in row] for row in found]
    # Of all readings of the table, not only of those that were judged.
    _, readings = case_and_readings(d.case, d.readings.source)
    figures = {
        " ± ".join(with_uncertainty(f.value, f.u))
        for f in cbpt.characterise(d.case, readings).figures
        if f.value is not None and f.u
    }
    assert told and {row[0] for row in told} <= {*figures, "–"}


def test_cards_have_the_numbers_of_the_model_shown(opened: tuple[Any, Any]) -> None:
    page, d = opened
    page.select_option("#unit", "arcsec")
    page.click("#show-answer")
    report_words = " ".join(d.report().split())
    for effect in d.verdict.names:
        card = words(page, f'[data-card="{effect}"]')
        for text in _values(d, effect):
            assert text.replace("+-", "±") in card and text in report_words


def _values(d: Any, effect: str) -> Iterator[str]:
    found = d.parameters(d.after, effect)
    for name, p in found.items():
        yield parameter_words(d.competition.campaign, (effect, name), p)[1]


@pytest.mark.parametrize("name", NAMES)
def test_errors_are_those_of_the_readings_that_were_judged(name: str) -> None:
    d, found = diagnosed(name), document(name)
    used = np.array(found["readings"]["used"])
    assert used.all() == (name != THINNED) and used.sum() == len(d.readings)
    models = {m["key"]: m for m in found["models"]}
    for m in models.values():
        residual = array(m["residual_arcsec"])[used]
        assert np.sqrt(np.mean(residual**2)) == pytest.approx(m["rmse_arcsec"], rel=1e-6)
    for rung in found["ladder"]["rungs"]:
        if rung["key"] in models:
            of_model = models[rung["key"]]
            assert rung["in_sample_arcsec"] == pytest.approx(of_model["rmse_arcsec"], rel=1e-6)
            assert rung["held_out_arcsec"] == pytest.approx(
                of_model["held_out_rmse_arcsec"], rel=1e-6
            )
    assert models["stated"]["rmse_arcsec"] == pytest.approx(d.to_dict()["before"]["rmse_arcsec"])
    shown = models[found["answer_key"]]
    assert shown["rmse_arcsec"] == pytest.approx(d.to_dict()["after"]["rmse_arcsec"])


def test_runs_with_their_own_zeros_lie_on_each_other_in_a_thinned_table() -> None:
    found, d = document(THINNED), diagnosed(THINNED)
    used = np.array(found["readings"]["used"])
    runs = np.array(found["readings"]["run_index"])
    zero = np.array(found["readings"]["zero_arcsec"])
    # A reading that was not judged has the zero of its run.
    for run in np.unique(runs):
        assert np.ptp(zero[runs == run]) < 1e-6
    fitter = d.competition.fitter
    fit = fitter.look(d.after, d.noise)
    # What an error does not hold is part of the zero.
    out = fit.residual_arcsec - left_by(fitter.campaign, fit)
    expected = fitter.campaign.offsets @ fit.offsets_arcsec + out
    np.testing.assert_allclose(zero[used], expected, atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_rankings_and_models_of_the_page_are_those_of_the_answer(name: str) -> None:
    d = diagnosed(name)
    models = {m["key"]: m for m in document(name)["models"]}
    for row in d.to_dict()["ranking"]:
        for p in models[row["effect"]]["parameters"]:
            assert p["value_SI"] == row["parameters"][p["name_SI"]]["value"]
    for c in d.to_dict()["combinations"]:
        key = "+".join(e for e in c["effects"] if e != "run_offset") or "refitted"
        if not c["unnamed"]:
            assert models[key]["rmse_arcsec"] == c["rmse_arcsec"]
