"""What the page draws against the JSON of the answer: the same numbers, the same digits.

Each campaign is a report on disk, opened in a browser; gauge, tables and cards are read.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import cbpt
from cbpt.lab.diagnosis.fit_text import parameter_words
from cbpt.lab.diagnosis.why import sentence
from cbpt.lab.wording.numbers import AngleUnit, probability, rounded, with_uncertainty
from cbpt.page.report import report
from common.browser import DRAWN, PATIENCE_MS, watched
from common.documents import document
from common.hidden import diagnosed

NAMES = ["dev03", "dev09"]


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
        assert " ".join(sentence(d, why, angle).split()) in words(page, "#why")


def test_a_figure_has_the_digits_of_its_uncertainty(opened: tuple[Any, Any]) -> None:
    page, d = opened
    page.select_option("#unit", "arcsec")
    found = [row[1:] for row in rows(page, "Figures of catalogues before and after")]
    told = [[cell.replace("−", "-") for cell in row] for row in found]
    figures = {
        " ± ".join(with_uncertainty(f.value, f.u))
        for f in cbpt.characterise(d.case, d.competition.campaign.readings).figures
        if f.value is not None and f.u
    }
    assert told and {row[0] for row in told} <= figures


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
