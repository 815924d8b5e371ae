"""The report in a real browser, from disk: without a network, on paper, on a phone, by keyboard.

Groups: the report, what is drawn, names that attack, who cannot see or has no mouse.
"""

from __future__ import annotations

import copy
import re
import shlex
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import cbpt
from cbpt.cli.main import main
from cbpt.page.document.document import page_document
from cbpt.page.document.source import Command, Source
from cbpt.page.report import report
from common.browser import DRAWN, number, saved, undiagnosed, watched
from common.documents import document
from common.hidden import FOLDER, case_of

# --- the report ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def on_disk(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of the report of dev04."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    campaign = str(FOLDER / "dev04.toml"), str(FOLDER / "dev04.csv")
    head = ["--author", "A. Author", "--date", "2026-02-03"]
    assert main(["report", *campaign, *head, "--out", str(path)]) == 0
    return path.as_uri()


@pytest.fixture(scope="module")
def on_screen(browser: Any, on_disk: str) -> Iterator[Any]:
    """One page of the report for tests that hardly change it."""
    with watched(browser) as page:
        page.goto(on_disk)
        page.wait_for_selector(DRAWN)
        yield page


@pytest.fixture(scope="module")
def on_phone(browser: Any, on_disk: str) -> Iterator[Any]:
    """The same 390 px wide."""
    with watched(browser, 390) as page:
        page.goto(on_disk)
        page.wait_for_selector(DRAWN)
        yield page


def test_a_number_that_is_the_answer_is_one_model_and_its_case_is_saved(
    browser: Any, tmp_path: Path
) -> None:
    case, data = FOLDER / "dev12.toml", FOLDER / "dev12.csv"
    d = cbpt.diagnose(case, data)
    source = Source.of_files(case.name, data.name, case.read_text(encoding="utf-8"))
    path = tmp_path / "report.html"
    path.write_text(report(page_document(d.case, d.readings, source, d)), encoding="utf-8")
    switch = "#missing [data-effect=contact_stiffness]"
    with watched(browser) as page:
        page.goto(path.as_uri())
        page.click("#show-answer")
        page.wait_for_selector(f"{switch}[aria-checked=true]")
        card = page.text_content("[data-card=contact_stiffness]")
        said = page.text_content("#sentence").replace("\N{MINUS SIGN}", "-")
        off = re.search(r"-[\d.]+ %", said)
        assert off
        assert off[0] in card.replace("\N{MINUS SIGN}", "-")
        assert "parameters refitted (contact stiffness)" in page.text_content("#ladder tr.shown")
        saved_case = saved(page, "#save-case", tmp_path)
        page.click(switch)
        page.wait_for_selector(f"{switch}[aria-checked=false]")
        assert number(page, "#rmse") > 8
        page.click(switch)
        assert number(page, "#rmse") < 0.31
    after = cbpt.compare(saved_case, data).overall
    assert after is not None
    assert after.rmse_arcsec < 0.31


def test_a_report_opens_from_disk_without_a_network(browser: Any, on_disk: str) -> None:
    with watched(browser, offline=True) as page:
        page.goto(on_disk)
        page.wait_for_selector(DRAWN)
        assert "friction" in page.text_content("#sentence")
        # It begins with the model of the answer.
        assert number(page, "#rmse") == pytest.approx(0.30, abs=0.01)
        page.click("#missing [data-effect=friction_hysteresis]")
        assert number(page, "#rmse") == pytest.approx(1.98, abs=0.01)
        for section in ("readings", "where", "ladder", "tell", "drive"):
            assert page.locator(f"#{section} .main-svg").count() > 0
        assert page.locator("#drawing svg").count() == 1
        # Nothing offers to send the readings away.
        titles = page.locator(".modebar-btn").evaluate_all("all => all.map(b => b.dataset.title)")
        assert titles and not [t for t in titles if re.search("share|cloud|send", t, re.I)]
        # What needs a server is not offered.
        assert page.locator("#own textarea, #drive input, #open-files:visible").count() == 0


def test_a_report_prints_with_every_section_in_light_colours(browser: Any, on_disk: str) -> None:
    with watched(browser, color_scheme="dark") as page:
        page.goto(on_disk)
        page.wait_for_selector(DRAWN)
        assert len(page.pdf(format="A4")) > 50_000
        page.emulate_media(media="print")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor").endswith(
            "(255, 255, 255)"
        )
        assert not page.is_visible(".model-bar")
        assert page.is_visible("#drawing svg")
        # Nothing to press or choose is left, what was folded is open, plots fit the paper.
        assert page.locator("main :is(select, input, .main):visible").count() == 0
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert page.locator("details:not([open])").count() == 0
        widths = page.locator(".main-svg").evaluate_all("all => all.map(e => e.clientWidth)")
        assert max(widths) <= 650


def pages(page: Any, hidden: str) -> int:
    """Sheets of A4 that the report takes without some of its parts."""
    page.add_style_tag(content=f"{hidden} {{ display: none !important; }}")
    return len(re.findall(rb"/Type\s*/Page\b", page.pdf(format="A4")))


def test_two_printed_pages_hold_the_answer_and_the_first_a_plot(browser: Any, on_disk: str) -> None:
    with watched(browser) as page:
        page.goto(on_disk)
        page.wait_for_selector(DRAWN)
        head = page.text_content("#head")
        assert "20 balls in the deceleration pair" in head
        assert "396 readings in 12 runs, torque -8 to 8 N m" in head
        assert "2026-02-03 by A. Author" in head
        assert len(re.findall("SHA-256 [0-9a-f]{12}", head)) == 2
        # A loop with its figures before and after, and the run in the words of a rig.
        figures = page.inner_text("#figures tbody").replace("\t", " ")
        assert "hysteresis loss (arcsec)" in figures
        assert "13 readings" in page.text_content("#next .sentence")
        # A sentence of five lines leaves room for the plot.
        page.evaluate("document.querySelector('#sentence').textContent = 'explanation '.repeat(32)")
        assert pages(page, "#appendix, #appendix ~ *") <= 2
        assert pages(page, "#readings ~ *") == 1
        # Buttons of a plot are for the screen.
        page.emulate_media(media="print")
        assert page.locator(".modebar").count() and not page.locator(".modebar:visible").count()


def test_a_plot_stands_on_the_first_page_below_an_answer_beside_which_something_remains(
    browser: Any, tmp_path: Path
) -> None:
    whole = copy.deepcopy(document("dev04"))
    whole["unit"] = "mrad"
    whole["remains"] = {
        "rms_arcsec": 1560.0,
        "share_of_misfit": 0.032,
        "depends_on": "the torque and the time since a run began",
        "expected_arcsec": 1390.0,
        "expected_from": "repeats",
    }
    path = tmp_path / "report.html"
    path.write_text(report(whole), encoding="utf-8")
    with watched(browser) as page:
        page.goto(path.as_uri())
        page.wait_for_selector(DRAWN)
        # The unit that was chosen for the report.
        assert page.input_value("#unit") == "mrad"
        assert re.search(r"0\.0014\d* mrad", page.text_content("#gauge"))
        # Eight lines.
        page.evaluate("document.querySelector('#sentence').textContent = 'explanation '.repeat(50)")
        assert pages(page, "#readings ~ *") == 1


def test_many_notes_stand_in_the_appendix_of_a_printed_report(browser: Any, tmp_path: Path) -> None:
    whole = copy.deepcopy(document("dev04"))
    whole["data"]["notes"] = [f"{n} note that takes a line of its own" for n in range(12)]
    path = tmp_path / "report.html"
    path.write_text(report(whole), encoding="utf-8")
    with watched(browser) as page:
        page.goto(path.as_uri())
        page.wait_for_selector(DRAWN)
        assert page.is_visible("#answer details") and not page.is_visible("#notes")
        page.evaluate("document.querySelector('#sentence').textContent = 'explanation '.repeat(32)")
        page.emulate_media(media="print")
        assert not page.is_visible("#answer details")
        assert page.locator("#notes li:visible").count() == 12
        assert page.is_visible("text=12 notes on the readings stand in the appendix")
        assert pages(page, "#readings ~ *") == 1


# Of the page and of each plot: how wide it is and what is drawn in it.
WIDTHS = """() => [document.documentElement.scrollWidth,
  ...[...document.querySelectorAll('.plot > .area')].map(
    area => [area.clientWidth, area.querySelector('.main-svg')?.clientWidth])]"""


@pytest.mark.parametrize(("of", "width"), [("on_screen", 1280), ("on_phone", 390)])
def test_plots_fit_the_page_and_are_as_wide_after_printing(
    of: str, width: int, request: pytest.FixtureRequest
) -> None:
    page = request.getfixturevalue(of)
    before = page.evaluate(WIDTHS)
    page.pdf(format="A4")
    assert page.evaluate(WIDTHS) == before
    # Nothing has to be scrolled sideways.
    assert before[0] <= width
    assert all(area == drawn for area, drawn in before[1:])


def test_a_sketch_is_printed_and_is_the_same_afterwards(browser: Any, on_disk: str) -> None:
    # The plotting library is never unpacked.
    slow = """globalThis.DecompressionStream = class {
      readable = new ReadableStream(); writable = new WritableStream(); }"""
    sketch = "#readings-plot .area > svg"
    with watched(browser, 1600, color_scheme="dark") as page:
        page.add_init_script(slow)
        page.goto(on_disk)
        page.wait_for_selector(sketch)
        drawn = "document.querySelector('#readings-plot .area').innerHTML"
        before = page.evaluate(drawn)
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert page.locator(sketch).get_attribute("width") == "640"
        assert "#1d232b" in page.evaluate(drawn)  # ink on paper
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert page.evaluate(drawn) == before
        page.pdf(format="A4")
        assert page.evaluate(drawn) == before
        page.emulate_media(color_scheme="light")
        page.wait_for_function(f"() => {drawn}.includes('#1d232b')")


# --- what is drawn ------------------------------------------------------------------------


@pytest.mark.parametrize("width", [1280, 390])
def test_signs_and_bars_lie_inside_their_axes(browser: Any, tmp_path: Path, width: int) -> None:
    with watched(browser, width) as page:
        page.goto(undiagnosed(FOLDER / "dev01.toml", FOLDER / "dev01.csv", tmp_path))
        page.wait_for_selector(DRAWN)
        spare = page.evaluate(
            """() => ['xy', 'xy2'].map(axes => {
              const plot = `#readings-plot .nsewdrag[data-subplot=${axes}]`;
              const room = document.querySelector(plot).getBBox();
              const drawn = document.querySelector(`#readings-plot .${axes} .readings`).getBBox();
              return Math.min(drawn.x, drawn.y, room.width - drawn.x - drawn.width,
                              room.height - drawn.y - drawn.height);
            })"""
        )
        assert min(spare) >= 0


def test_the_legend_says_what_every_line_is(on_screen: Any) -> None:
    on_screen.click("#as-stated")
    assert "model: the drive as stated" in on_screen.text_content("#legend")
    assert "residual of the drive as stated" not in on_screen.text_content("#legend")
    assert "stated uncertainty" in on_screen.text_content("#legend")
    assert "model, torque falling" in on_screen.text_content("#legend")
    assert "± 2 × noise" in on_screen.text_content("#legend")
    on_screen.click("#show-answer")
    assert "model: friction" in on_screen.text_content("#legend")
    assert "residual of the drive as stated" in on_screen.text_content("#legend")


def test_the_residual_is_drawn_against_any_column_and_coloured_by_any(on_screen: Any) -> None:
    drawn = """key => { const p = document.querySelector('#residual-plot .area');
      return [p._fullLayout.xaxis.title.text, p.data.length, p.data[0].x.length]; }"""
    on_screen.wait_for_selector("#residual-plot .main-svg")
    assert on_screen.evaluate(drawn) == ["time (s)", 4, 99]
    assert "preload (N) 420" in on_screen.text_content("#residual-plot .legend")
    on_screen.select_option("#residual-x", "input_angle_deg")
    on_screen.select_option("#residual-colour", "temperature_degC")
    on_screen.wait_for_selector(DRAWN)
    assert on_screen.evaluate(drawn) == ["input angle (deg)", 1, 396]
    assert "temperature (degC)" in on_screen.text_content("#residual-plot .infolayer")
    on_screen.select_option("#residual-x", "order")
    on_screen.wait_for_selector(DRAWN)
    assert on_screen.evaluate(drawn)[0] == "order in the table"


def test_a_torsion_spring_has_nothing_of_a_ball_drive(browser: Any, tmp_path: Path) -> None:
    examples = Path(__file__).parents[2] / "examples"
    with watched(browser) as page:
        page.goto(undiagnosed(examples / "reducer.toml", examples / "reducer.csv", tmp_path))
        page.wait_for_selector(DRAWN)
        words = page.inner_text("main")
        strange = r"\b(balls?|grooves?|walls?|contacts?|pairs?|thresholds?|meshing|parted)\b"
        assert re.findall(strange, words, re.I) == []
        assert "Elastic angle over torque" in words


def test_a_phone_shows_tables_and_names_whole(on_phone: Any) -> None:
    cut = on_phone.locator("main .scroll:visible").evaluate_all(
        "all => all.filter(e => e.scrollWidth > e.clientWidth).map(e => e.ariaLabel)"
    )
    assert cut == []
    for plot in ("#matrix", "#where-plot", "#ladder-plot"):
        # Upright names have their width across, so boxes that meet are names that do.
        boxes = on_phone.locator(f"{plot} .xtick text").evaluate_all(
            "all => all.map(e => e.getBoundingClientRect()).map(b => [b.left, b.right])"
        )
        ends = sorted(boxes)
        assert len(ends) > 2
        assert all(a[1] <= b[0] + 2 for a, b in pairwise(ends)), plot
    assert on_phone.locator("#sizes .scroll").bounding_box()["height"] > 400


# --- names that attack --------------------------------------------------------------------

ATTACK = '<img src=x onerror="alert(1)"></script><script>alert(2)</script>'


def test_names_from_files_are_shown_as_text(browser: Any, tmp_path: Path) -> None:
    table = tmp_path / "t.csv"
    rows = (FOLDER / "dev04.csv").read_text(encoding="utf-8").splitlines()
    quoted = ATTACK.replace('"', '""')
    table.write_text(
        "\n".join([rows[0], *(f'"{quoted}",{row.split(",", 1)[1]}' for row in rows[1:40])]),
        encoding="utf-8",
    )
    case = cbpt.Case.from_toml(case_of("dev04"))
    readings = cbpt.read_readings(table)
    source = Source(
        f"{ATTACK}.toml", f"{ATTACK}.csv", f"# {ATTACK}\u2028", Command(ATTACK, "data.csv")
    )
    document = page_document(case, readings, source)
    for model in document["models"]:
        model["label"] = ATTACK
    path = tmp_path / "report.html"
    path.write_text(report(document), encoding="utf-8")
    with watched(browser) as page:
        page.goto(path.as_uri())
        page.wait_for_selector(DRAWN)
        assert ATTACK in page.text_content("#what")
        assert page.text_content("#command") == document["command"]
        assert shlex.quote(ATTACK) in document["command"]
        page.evaluate(
            """import('cbpt/lib/store.js').then(
              ({ select }) => select(Array.from({ length: 30 }, (_, i) => i)))"""
        )
        page.wait_for_selector("#selected-count")
        assert ATTACK in page.text_content("#selection tbody")
        assert page.locator("img").count() == 0


# --- who cannot see, or has no mouse ------------------------------------------------------


def test_every_control_has_a_name(on_screen: Any) -> None:
    nameless = on_screen.evaluate(
        """() => [...document.querySelectorAll(
            'button, select, input, textarea, a, [role=img]')]
          .filter(e => e.getClientRects().length && !e.closest('.modebar'))
          .filter(e => !(e.textContent.trim() || e.getAttribute('aria-label') ||
                         e.labels?.length))
          .map(e => e.outerHTML.slice(0, 200))"""
    )
    assert nameless == []
    levels = on_screen.evaluate(
        "[...document.querySelectorAll('h1, h2, h3, h4')].map(h => Number(h.tagName[1]))"
    )
    assert levels[0] == 1
    assert all(b - a <= 1 for a, b in pairwise(levels))
    for landmark in ("header", "nav", "main"):
        assert on_screen.locator(landmark).count() == 1


def test_a_switch_is_reached_and_used_by_keyboard(browser: Any, on_disk: str) -> None:
    with watched(browser) as page:
        page.goto(on_disk)
        page.wait_for_selector(DRAWN)
        for _ in range(40):
            page.keyboard.press("Tab")
            if page.evaluate("document.activeElement.dataset.effect") == "friction_hysteresis":
                break
        else:
            pytest.fail("the switch is not reached with Tab")
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline == "solid"
        page.keyboard.press("Space")
        page.wait_for_selector("#model-bar [data-effect=friction_hysteresis][aria-checked=false]")
        # The focus stays where it was.
        assert page.evaluate("document.activeElement.dataset.effect") == "friction_hysteresis"


def test_the_focus_stays_on_what_was_pressed(on_screen: Any) -> None:
    for control in ("#legend .chip", "#ladder td button >> nth=2", "#drive .tab >> nth=1"):
        on_screen.locator(control).first.focus()
        name = on_screen.evaluate("document.activeElement.textContent")
        on_screen.keyboard.press("Enter")
        on_screen.wait_for_selector(DRAWN)
        assert on_screen.evaluate("document.activeElement.textContent") == name
