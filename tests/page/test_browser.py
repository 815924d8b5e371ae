"""The page live in a real browser: the whole story. The report from disk is in test_page_on_disk.

Groups: dev04 (upload, loop, switch, export) and dev10 (an own effect), files that leave doubt, a
name that attacks, who cannot see or has no mouse.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import xlsxwriter

import cbpt
from common.browser import (
    DRAWN,
    PATIENCE_MS,
    number,
    open_campaign,
    saved,
    watched,
    workbench,
)
from common.hidden import FOLDER


@pytest.fixture(scope="module")
def bench(browser: Any) -> Iterator[str]:
    with workbench(matrices=1) as address:
        yield address


@pytest.fixture(scope="module")
def live(browser: Any, bench: str) -> Iterator[Any]:
    with watched(browser) as page:
        page.goto(bench)
        page.wait_for_selector(DRAWN)  # the dialog for files opens by itself before
        yield page


def upload(page: Any, name: str) -> None:
    open_campaign(page, FOLDER, name)
    page.wait_for_selector(DRAWN)


@pytest.fixture(scope="module")
def document(live: Any) -> dict[str, Any]:
    """What the workbench tells the page of dev04."""
    upload(live, "dev04")
    live.wait_for_selector("#matrix .main-svg")
    found: dict[str, Any] = live.evaluate("fetch('api/document').then(r => r.json())")
    return found


@pytest.fixture(scope="module")
def dev04(live: Any, document: dict[str, Any]) -> Any:
    return live


# --- the story ----------------------------------------------------------------------------


def test_the_loop_is_seen_in_the_residual(dev04: Any) -> None:
    assert "friction" in dev04.text_content("#sentence")
    assert number(dev04, "#rmse") == pytest.approx(1.98, abs=0.01)
    # Falling torque reads high, rising torque low: the loop that the model has not.
    bias = dev04.evaluate(
        """async () => {
          const { state, modelShown } = await import('/lib/store.js');
          const sums = { up: 0, down: 0, none: 0 };
          modelShown().residual_arcsec.forEach(
            (v, i) => sums[state.document.readings.branch[i]] += v);
          return sums;
        }"""
    )
    assert bias["up"] < -100
    assert bias["down"] > 100
    assert "torque falling" in dev04.text_content("#regions")


def test_small_numbers_of_another_unit_keep_their_digits(dev04: Any) -> None:
    outlined = "#where-plot .shapelayer path"
    dev04.wait_for_selector(outlined, state="attached")
    dev04.select_option("#unit", "arcmin")
    assert number(dev04, "#rmse") == pytest.approx(1.98 / 60, rel=2e-3)
    facts = dev04.text_content("#answer .facts")
    card = dev04.text_content("[data-card=friction_hysteresis]")
    dev04.select_option("#unit", "arcsec")
    assert re.search(r"0\.0330? → 0\.0050?\d*", facts)
    assert re.search(r"held out 0\.005\d\d? arcmin", card)
    # Regions of the drive as stated are outlined on its map alone.
    dev04.click("#show-answer")
    dev04.wait_for_selector(outlined, state="detached")
    assert "not outlined" in dev04.text_content("#where .under")
    dev04.click("#model-bar >> text=as stated")
    dev04.wait_for_selector(outlined, state="attached")


def test_a_switch_makes_the_error_fall_and_rise_again(dev04: Any) -> None:
    switch = dev04.locator("#missing [data-effect=friction_hysteresis]")
    lines = "#readings-plot .subplot.xy .lines path"
    before = dev04.locator(lines).last.get_attribute("d")
    switch.click()
    dev04.wait_for_selector("#missing [data-effect=friction_hysteresis][aria-checked=true]")
    assert number(dev04, "#rmse") == pytest.approx(0.30, abs=0.01)
    assert "error 0.305" in dev04.text_content("#status")
    dev04.wait_for_selector(DRAWN)
    assert dev04.locator(lines).last.get_attribute("d") != before
    assert "friction" in dev04.text_content("#ladder tr.shown")
    switch.click()
    dev04.wait_for_selector("#missing [data-effect=friction_hysteresis][aria-checked=false]")
    assert number(dev04, "#rmse") == pytest.approx(1.98, abs=0.01)


def every_card(page: Any) -> None:
    """Unfold the less likely candidates: which effects those are is no matter of the page."""
    fold = page.locator("#missing button", has_text="less likely candidate")
    if fold.count():
        fold.click()


def test_any_combination_is_fitted_live(dev04: Any) -> None:
    every_card(dev04)
    for effect in ("creep", "preload_spring"):
        dev04.click(f"#missing [data-effect={effect}]")
        dev04.wait_for_selector(f"#missing [data-effect={effect}][aria-checked=true]")
    both = number(dev04, "#rmse")
    assert 0.4 < both < 1.9
    # The diagnosis' own rungs with their mark, below them the steps to what is shown.
    assert dev04.locator("#ladder tr.apart, #ladder tr.apart ~ tr").count() == 2  # one, both
    assert "friction" in dev04.text_content("#ladder tr.stop")
    dev04.wait_for_selector(DRAWN)
    assert "stop: " in dev04.text_content("#ladder-plot .area")
    dev04.click("#model-bar >> text=as stated")
    assert number(dev04, "#rmse") > both


def test_a_switch_leaves_what_does_not_change_and_the_focus_where_they_are(dev04: Any) -> None:
    every_card(dev04)
    card = "#missing [data-card=preload_spring]"
    dev04.evaluate("card => document.querySelector(card).marked = true", card)
    for effect in ("preload_spring", "creep"):
        dev04.locator(f"#missing [data-effect={effect}]").focus()
        dev04.keyboard.press("Space")
        dev04.wait_for_selector(f"#missing [data-effect={effect}][aria-checked=true]")
        assert dev04.evaluate("document.activeElement.dataset.effect") == effect
    assert dev04.evaluate("card => document.querySelector(card).marked", card)
    # In the bar too, whose switches change with the model.
    in_bar = "#model-bar [data-effect=friction_hysteresis]"
    dev04.locator(in_bar).focus()
    dev04.keyboard.press("Space")
    dev04.wait_for_selector(f"{in_bar}[aria-checked=true]")
    assert dev04.evaluate("document.activeElement.matches('#model-bar .switch')")
    dev04.click("#model-bar >> text=as stated")


def test_a_box_selects_readings_in_every_plot(dev04: Any) -> None:
    plot = dev04.locator("#readings-plot .area")
    plot.scroll_into_view_if_needed()
    box = dev04.locator(".nsewdrag[data-subplot=xy2]").bounding_box()
    dev04.mouse.move(box["x"] + 0.7 * box["width"], box["y"] + 2)
    dev04.mouse.down()
    dev04.mouse.move(box["x"] + 0.9 * box["width"], box["y"] + 0.4 * box["height"], steps=5)
    dev04.mouse.up()
    dev04.wait_for_selector("#selected-count")
    told = dev04.text_content("#selected-count")
    count = int(told.split()[0])
    assert 5 < count < 100
    assert dev04.locator("#selection tbody tr").count() == count
    assert "+" in told  # what lies high was selected
    dev04.click("#clear-selection")
    dev04.wait_for_selector("#selected-count", state="detached")


def test_what_is_exported_gives_the_same_again(dev04: Any, tmp_path: Path) -> None:
    dev04.click("#show-answer")
    dev04.wait_for_selector("#missing [data-effect=friction_hysteresis][aria-checked=true]")
    table, case = saved(dev04, "#save-csv", tmp_path), saved(dev04, "#save-case", tmp_path)
    after = cbpt.compare(case, FOLDER / "dev04.csv")
    assert after.overall is not None
    assert after.overall.rmse_arcsec == pytest.approx(0.305, abs=0.01)
    again = cbpt.compare(FOLDER / "dev04.toml", table)
    assert again.overall is not None
    assert again.overall.rmse_arcsec == pytest.approx(1.979, abs=0.01)
    answer = json.loads(saved(dev04, "#save-answer", tmp_path).read_text(encoding="utf-8"))
    assert answer["verdict"]["effects"] == ["friction_hysteresis"]
    page = json.loads(saved(dev04, "#save-json", tmp_path).read_text(encoding="utf-8"))
    assert page["answer"] == answer
    drawing = saved(dev04, "#readings .under button", tmp_path).read_text(encoding="utf-8")
    assert drawing.startswith("<svg")
    assert drawing.count('class="point"') > 396
    assert "cbpt report" in dev04.text_content("#command")


def test_the_drive_follows_its_sliders(dev04: Any) -> None:
    # Whatever model another test left on.
    switch = dev04.locator("#missing [data-effect=friction_hysteresis]")
    if switch.get_attribute("aria-checked") != "true":
        switch.click()
    dev04.wait_for_selector("#missing [data-effect=friction_hysteresis][aria-checked=true]")
    before = dev04.text_content("#drive-facts")
    slider = dev04.locator("#drive [data-key=torque_Nm]")
    slider.focus()
    for _ in range(3):
        slider.press("ArrowLeft")
    dev04.wait_for_function(
        "before => document.querySelector('#drive-facts').textContent !== before", arg=before
    )
    assert dev04.locator("#drawing svg circle").count() > 40
    # Of the model shown too, at this load: both ways, with the band of its uncertainty.
    dev04.wait_for_selector(DRAWN)
    keys = dev04.locator("#drive-curve .legendtext").all_text_contents()
    assert keys[0] == "± 2 standard uncertainties of the model"
    assert "with the model's effects, torque falling" in keys
    assert "friction" in dev04.text_content("#curve-note")
    preload = dev04.locator("#drive [data-key=preload_N]")
    preload.fill(preload.get_attribute("min"))
    dev04.wait_for_function(
        "() => document.querySelector('#curve-note').textContent.includes('axis ends')"
    )


def test_the_data_sheet_is_made_shown_and_saved(dev04: Any, tmp_path: Path) -> None:
    dev04.click("#make-sheet")
    dev04.wait_for_selector("#save-sheet", timeout=PATIENCE_MS)
    sheet = dev04.frame_locator("iframe.sheet")
    sheet.locator("h1").wait_for()
    # Its own styles hold there, and it has its pictures.
    rule = sheet.locator("header").evaluate("e => getComputedStyle(e).borderBottomStyle")
    assert rule == "solid" and sheet.locator("figure svg").count() >= 6
    with dev04.expect_download() as download:
        dev04.click("#save-sheet")
    target = tmp_path / "sheet.html"
    download.value.save_as(target)
    assert "Efficiency" in target.read_text(encoding="utf-8")


def numbers_of_own(page: Any) -> dict[str, str]:
    """What stands in the fields of the own effect's parameters."""
    found: dict[str, str] = page.evaluate(
        """Object.fromEntries([...document.querySelectorAll('.own-parameters [data-field]')]
             .map(e => [e.dataset.field, e.value]))"""
    )
    return found


def a_pattern_is_no_case(live: Any) -> None:
    upload(live, "dev10")
    assert "not in the library" in live.text_content("#sentence")
    # Nothing of the library is offered as the answer, and a pattern is in no case file.
    assert live.locator("#show-answer").count() == 0
    assert "does not explain the readings" in live.text_content("#answer .facts")
    assert "→" not in live.text_content("#answer .facts")
    assert "the answer stops here" not in live.text_content("#ladder")
    live.click("#show-pattern")
    assert number(live, "#rmse") < 1
    assert live.is_disabled("#save-case")
    assert "no case file: no known effect explains this misfit" in live.text_content("#export")
    live.click("#model-bar >> text=as stated")
    advice = live.text_content("#next .card")
    assert advice.startswith("Where to measure moreNo known effect explains the misfit")
    assert "near torque 8 N m, input angle 130 deg" in advice


def a_formula_is_checked_as_typed(live: Any, draft: str) -> None:
    live.fill("#own-expression", "a * torqe_Nm * (")
    live.wait_for_function("() => document.querySelector('#own-mistake').textContent.includes('^')")
    assert live.is_disabled("#own-fit")
    live.fill("#own-expression", "a * torque_Nm * log(torque_Nm)")
    live.wait_for_function(
        "() => document.querySelector('#own-mistake').textContent.includes('no number at')"
    )
    assert live.is_disabled("#own-fit")
    live.fill("#own-expression", draft)
    live.wait_for_selector("#own-mistake.fine")
    # What was said of a text goes with it.
    assert live.evaluate(
        """() => {
          const field = document.querySelector('#own-expression');
          field.dispatchEvent(new Event('input'));
          const said = document.querySelector('#own-mistake');
          return said.textContent === '' && !said.classList.contains('fine');
        }"""
    )
    live.wait_for_selector("#own-mistake.fine")


def a_fit_that_fails_says_so_beside_the_editor(live: Any) -> None:
    asked: list[str] = []

    def refused(route: Any) -> None:
        asked.append(route.request.url)
        route.fulfill(json={})

    live.route("**/api/own/fit?*", refused)
    live.focus("#own-fit")
    # Whoever presses it again meanwhile asks for nothing more, and the focus stays.
    assert (
        live.evaluate(
            """() => {
          const fit = document.activeElement;
          fit.click();
          fit.click();
          return fit.ariaDisabled;
        }"""
        )
        == "true"
    )
    live.wait_for_selector("#own-mistake:not(.fine):not(:empty)")
    live.wait_for_selector("#own-fit[aria-disabled=false]")
    assert live.evaluate("document.activeElement.id") == "own-fit"
    assert len(asked) == 1
    assert live.is_hidden("#trouble")
    live.unroute("**/api/own/fit?*")


def fields_are_checked_as_typed(live: Any) -> None:
    for field, wrong, said in (
        ("parameters.a1.min", "-1,5", 'minimum of a1 = "-1,5": '),
        ("parameters.a1.start", "", "start of a1: missing"),
        ("id", "stated", 'id = "stated": '),
    ):
        right = live.input_value(f'[data-field="{field}"]')
        live.fill(f'[data-field="{field}"]', wrong)
        live.wait_for_selector(f'[data-field="{field}"][aria-invalid=true]')
        assert live.locator("#own [aria-invalid]").count() == 1
        assert said in live.text_content("#own-mistake")
        assert live.is_disabled("#own-fit")
        live.fill(f'[data-field="{field}"]', right)
        live.wait_for_selector("#own-mistake.fine")
        assert live.locator("#own [aria-invalid]").count() == 0


def another_formula_under_the_same_name_lets_go_of_models(live: Any, draft: str) -> None:
    other = live.locator("#missing [data-effect][aria-checked=false]").first
    other.click()
    on = "document.querySelectorAll('#model-bar [aria-checked=true]').length"
    live.wait_for_function(f"() => {on} === 2")
    live.fill("#own-expression", f"-({draft})")
    live.wait_for_selector("#own-fit[aria-disabled=false]")
    live.click("#own-fit")
    live.wait_for_function(f"() => {on} === 1")
    held = live.evaluate(
        """async () => (await import('/lib/store.js')).state.document.models
             .filter(m => m.effects.includes('my_effect')).map(m => m.key)"""
    )
    assert held == ["my_effect"]


def test_an_own_effect_is_checked_as_typed_fitted_and_shown(live: Any) -> None:
    a_pattern_is_no_case(live)
    draft, drafted = live.input_value("#own-expression"), numbers_of_own(live)
    assert "input_angle_rad" in draft
    assert len(drafted) == 32
    a_formula_is_checked_as_typed(live, draft)
    a_fit_that_fails_says_so_beside_the_editor(live)
    # Other expressions meanwhile have cost the draft none of its numbers.
    assert numbers_of_own(live) == drafted
    fields_are_checked_as_typed(live)
    assert numbers_of_own(live) == drafted
    live.wait_for_selector("#own-fit[aria-disabled=false]")
    before = number(live, "#rmse")
    live.click("#own-fit")
    live.wait_for_selector("#model-bar [data-effect=my_effect][aria-checked=true]")
    assert number(live, "#rmse") < 0.4 < before
    assert "my_effect" in live.text_content("#case-text")
    assert live.text_content("#command-of-model").startswith("cbpt compare dev10_case.toml ")
    another_formula_under_the_same_name_lets_go_of_models(live, draft)


def test_an_own_effect_outlives_a_reload(live: Any) -> None:
    written = live.input_value("#own-expression")
    assert "input_angle_rad" in written
    live.reload()
    live.wait_for_selector(DRAWN)
    live.wait_for_selector("#own-expression")
    assert live.input_value("#own-expression") == written
    # New parameters begin where their place in the expression says.
    live.fill("#own-expression", "size * abs(torque_Nm)^n * exp(-time_s / tau)")
    for field, value in (
        ("size.start", "0.000001"),
        ("n.start", "1"),
        ("n.max", "3"),
        ("tau.start", "60"),
    ):
        assert float(live.input_value(f'[data-field="parameters.{field}"]')) == float(value)


def test_readings_are_left_out_and_the_answer_follows(live: Any) -> None:
    upload(live, "dev04")
    live.select_option("#rows-by", "time_s")
    whole = live.evaluate(DOCUMENT)["readings"]["time_s"]
    last = sorted(whole)[-4]
    live.fill("#rows-from", "0")
    live.fill("#rows-to", str(last))
    live.click("#rows-select")
    kept = sum(t <= last for t in whole)
    assert live.text_content("#selected-count").startswith(f"{kept} readings selected")
    live.click("#keep-alone")
    live.wait_for_selector("#all-again")
    live.wait_for_selector("#job", state="hidden")
    live.wait_for_selector("#sentence")
    assert f"{kept} readings" in live.text_content("#what")
    found = live.evaluate(DOCUMENT)
    assert found["answer"]["readings"] == kept
    assert f"{396 - kept} of 396 readings are left out by hand" in " ".join(found["data"]["notes"])
    # By a level of a column; the readings as a whole are shown again.
    live.select_option("#rows-by", "preload_N")
    live.select_option("#rows-value", label="420")
    assert live.text_content("#selected-count").startswith("99 readings selected")
    live.click("#all-again")
    live.wait_for_function("() => document.querySelector('#what').textContent.includes('396 r')")
    live.wait_for_selector("#sentence")


# --- files that leave doubt ---------------------------------------------------------------


def dialog(page: Any) -> None:
    """The dialog for files, which stands open where none were opened yet."""
    if not page.is_visible("dialog[open]"):
        page.click("#open-files")


def opened(page: Any, *files: Path) -> None:
    dialog(page)
    page.set_input_files("#files", files)


def shown(page: Any, name: str) -> None:
    page.wait_for_selector("dialog", state="hidden")
    page.wait_for_function(
        "name => document.querySelector('#what').textContent.includes(name)", arg=name
    )


DOCUMENT = "fetch('api/document').then(r => r.json())"


def test_columns_in_doubt_are_mapped_with_their_units(live: Any, tmp_path: Path) -> None:
    table = tmp_path / "doubtful.csv"
    rows = "".join(f"{t},600,{3.1 * t / 1000:.6f},ok\n" for t in (0, 1, 2, 3, 4, 5, 6))
    table.write_text(f"Moment,axial force [N],Twist,note\n{rows}", encoding="utf-8")
    before = live.text_content("#what")
    opened(live, FOLDER / "dev04.toml", table)
    live.wait_for_selector("#mapping")
    # What was shown stays until the columns are told.
    assert live.text_content("#what") == before
    live.select_option("[data-header=Moment]", "torque [N m]")
    live.select_option("[data-header=Twist]", "elastic_angle [deg]")
    live.select_option("[data-header=note]", "extra")
    live.click("#confirm-columns")
    shown(live, "doubtful.csv")
    readings = live.evaluate(DOCUMENT)["readings"]
    assert readings["torque_Nm"] == [0, 1, 2, 3, 4, 5, 6]
    assert readings["measured_arcsec"][1] == pytest.approx(3.1e-3 * 3600)
    assert "--column" in live.text_content("#command")


def test_a_sheet_is_chosen_and_a_refused_file_leaves_what_is_shown(
    live: Any, tmp_path: Path
) -> None:
    book = tmp_path / "two.xlsx"
    with xlsxwriter.Workbook(book) as written:
        for number, name in enumerate(("Up", "Down"), 1):
            page = written.add_worksheet(name)
            page.write_row(0, 0, ["torque_Nm", "preload_N", "elastic_angle_arcsec"])
            for k in range(1, 8):
                page.write_row(k, 0, [number * k, 600, 3.1 * k])
    opened(live, FOLDER / "dev04.toml", book)
    live.wait_for_selector("#sheet")
    live.select_option("#sheet", "Down")
    shown(live, "two.xlsx")
    document = live.evaluate(DOCUMENT)
    assert document["readings"]["torque_Nm"][0] == 2
    assert "--sheet Down" in document["command"]
    refused = tmp_path / "none.csv"
    refused.write_text("torque_Nm\n", encoding="utf-8")
    opened(live, refused)
    live.wait_for_function(
        "() => !/Reading/.test(document.querySelector('#upload-found').textContent)"
    )
    assert "none.csv" in live.text_content("#upload-found")
    live.click("dialog >> text=Close")
    assert "two.xlsx" in live.text_content("#what")
    assert live.evaluate(DOCUMENT)["data"]["name"] == "two.xlsx"


# --- a name that attacks ------------------------------------------------------------------


def test_a_hostile_file_name_is_but_a_name(live: Any) -> None:
    dialog(live)
    name = '<img src=x onerror="alert(3)">.csv'
    live.set_input_files(
        "#files", [{"name": name, "mimeType": "text/csv", "buffer": b"<b>a</b>,b\n1,2\n3,4\n"}]
    )
    live.wait_for_selector("#upload-found .trouble, #upload-found #mapping")
    live.wait_for_function(
        "() => document.querySelector('#upload-found').textContent.includes('<b>a')"
    )
    assert live.locator("#upload-found b:text-is('a')").count() == 0
    # Each column that is in doubt has a line of its own.
    assert live.locator("#upload-found > ul > li").count() > 1
    assert live.locator("img").count() == 0
    live.click("dialog >> text=Close")


# --- who cannot see, or has no mouse ------------------------------------------------------


def test_the_focus_goes_to_the_button_that_takes_the_place(
    browser: Any, bench: str, document: dict[str, Any]
) -> None:
    job = {"state": "running", "stage": "screen", "share": 0.1, "answered": False, "error": ""}
    focused = "id => document.activeElement.id === id"
    # The page takes only what is said of the files that it shows.
    of_shown = {"x-cbpt-opened": str(document["opened"])}

    def pressed(state: str) -> Any:
        def through(route: Any) -> None:
            job["state"] = state
            route.fulfill(json={}, headers=of_shown)

        return through

    # Not watched: the workbench has other files by now, and refuses what is asked of these.
    with browser.new_context() as context:
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.route("**/api/job?*", lambda route: route.fulfill(json=job, headers=of_shown))
        page.route("**/api/cancel?*", pressed("cancelled"))
        page.route("**/api/diagnose?*", pressed("running"))
        page.route(
            "**/api/document?*",
            lambda route: route.fulfill(
                json=document if job["state"] == "done" else {**document, "answer": None}
            ),
        )
        page.goto(bench)
        page.focus("#cancel")
        page.keyboard.press("Enter")
        page.wait_for_function(focused, arg="diagnose")
        page.keyboard.press("Enter")
        page.wait_for_function(focused, arg="cancel")
        job["state"] = "done"
        page.wait_for_function(focused, arg="answer")
        # A button that has done all it can keeps the focus too.
        page.click("#missing [data-effect=friction_hysteresis]")
        page.focus("#as-stated")
        page.keyboard.press("Enter")
        page.wait_for_selector("#as-stated[aria-disabled=true]")
        assert page.evaluate("document.activeElement.id") == "as-stated"


@pytest.mark.parametrize("width", [1280, 390])
def test_what_is_pressed_is_named_and_no_smaller_than_24_px(live: Any, width: int) -> None:
    live.set_viewport_size({"width": width, "height": 900})
    found = live.evaluate(
        """() => {
          const all = of => [...document.querySelectorAll(of)];
          const bars = all('[role=toolbar]').filter(e => !e.ariaLabel);
          const refers = all('[aria-labelledby]').filter(
            e => !document.getElementById(e.getAttribute('aria-labelledby')));
          const still = all('.scroll').filter(
            e => e.scrollWidth > e.clientWidth && e.tabIndex < 0);
          const small = all('button, select, input:not(.visually-hidden), summary')
            .filter(e => e.getClientRects().length && !e.closest('.modebar'))
            .filter(e => e.offsetWidth < 24 || e.offsetHeight < 24);
          return [bars, refers, still, small].flat().map(e => e.outerHTML.slice(0, 200));
        }"""
    )
    live.set_viewport_size({"width": 1280, "height": 900})
    assert found == []
