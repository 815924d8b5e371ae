"""The page in a real browser before its plotting library is there, and where it never comes.

Groups: the library does not load, the sketch while it waits, the same numbers in both, early files.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from common.browser import DRAWN, READY, undiagnosed, watched, workbench
from common.hidden import FOLDER

LIBRARY = "**/plotly.min.js*"
SKETCH = "#readings-plot .area > svg:not(.main-svg)"


@pytest.fixture(scope="module")
def bench(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    table = larger(1, tmp_path_factory.mktemp("bench"))
    with workbench(FOLDER / "dev07.toml", table) as address:
        yield address


# The text of the library comes when it is let through.
HOLD = """
const text = Response.prototype.text, held = new Promise(go => { globalThis.letThrough = go; });
Response.prototype.text = async function () { await held; return text.call(this); };
"""


@contextmanager
def sketched(browser: Any, table: Path, folder: Path, **options: Any) -> Iterator[Any]:
    """A report whose library is still to be read; `arrived` lets it be."""
    with watched(browser, **options) as page:
        page.add_init_script(HOLD)
        page.goto(undiagnosed(FOLDER / "dev07.toml", table, folder))
        page.wait_for_selector(SKETCH)
        # The other sections are there.
        page.wait_for_selector("#unit option", state="attached")
        yield page


def arrived(page: Any) -> None:
    page.evaluate("letThrough()")
    page.wait_for_selector(READY)


# --- the library does not load ------------------------------------------------------------


def test_a_library_that_does_not_load_is_told_and_asked_for_again(browser: Any, bench: str) -> None:
    plots = ("where", "drive")
    with watched(browser, blocked="plotly.min.js") as page:
        page.route(LIBRARY, lambda route: route.abort())
        page.goto(bench)
        # Nothing more is going to be drawn.
        page.wait_for_selector(DRAWN)
        page.wait_for_selector("#unit option", state="attached")
        # What is drawn again asks for it again.
        page.select_option("#unit", "arcmin")
        page.wait_for_selector(DRAWN)
        assert page.is_visible(SKETCH)
        for plot in ("readings", *plots):
            told = page.locator(f"#{plot} .area .unplotted").first
            assert "did not load" in told.text_content(), plot
            # A picture has nothing inside that can be pressed.
            assert told.locator("xpath=..").get_attribute("role") != "img"
        page.click("#readings .under button")
        page.wait_for_selector("#trouble:has-text('did not load')")
        page.click("#where .unplotted button")
        page.wait_for_selector(DRAWN)
        assert page.locator("#where .unplotted").count() == 2
        page.unroute(LIBRARY)
        page.click("#where .unplotted button")
        for plot in ("readings", *plots):
            page.wait_for_selector(f"#{plot} .main-svg", state="attached")
        page.wait_for_selector(DRAWN)
        assert page.locator(".unplotted").count() == page.locator(SKETCH).count() == 0
        assert page.locator(".area[role=img]").count() == page.locator(".area").count()


# --- the sketch while it waits ------------------------------------------------------------


def test_a_sketch_follows_colours_width_and_paper(browser: Any, tmp_path: Path) -> None:
    look = f"""() => {{
      const drawn = document.querySelector('{SKETCH}');
      const colours = new Set([...drawn.querySelectorAll('line')].map(
        line => line.getAttribute('stroke')));
      return {{ wide: drawn.clientWidth, high: drawn.clientHeight, colours: [...colours].sort(),
                room: drawn.parentElement.clientWidth,
                all: drawn.parentElement.clientHeight }};
    }}"""
    table = FOLDER / "dev07.csv"
    with sketched(browser, table, tmp_path, color_scheme="light") as page:
        light = page.evaluate(look)
        assert light["wide"] == light["room"] > 800
        page.emulate_media(color_scheme="dark")
        page.wait_for_function(
            f"old => !({look})().colours.some(c => old.includes(c))", arg=light["colours"]
        )
        page.set_viewport_size({"width": 700, "height": 900})
        page.wait_for_function(f"() => ({look})().wide === ({look})().room")
        narrow = page.evaluate(look)
        assert narrow["wide"] < 700
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        paper = page.evaluate(look)
        assert (paper["wide"], paper["all"]) == (640, 240)
        assert paper["colours"] == light["colours"]
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert page.evaluate(look) == narrow
        # Nothing can be dragged here yet, and a file is made once it can be.
        assert page.is_hidden("#box-hint")
        with page.expect_download() as saved:
            page.click("#readings .under button")
            assert page.is_hidden("#trouble")
            arrived(page)
        assert saved.value.suggested_filename == "readings.svg"
        assert page.is_visible("#box-hint")


# --- the same numbers in both -------------------------------------------------------------

PLACES = """inside => {
  const area = document.querySelector('#readings-plot .area');
  const origin = area.getBoundingClientRect();
  return [...area.querySelectorAll(inside)].filter(e => e.textContent).map(e => {
    const text = e.textContent.replaceAll("\u200b", ""); // after what Plotly raises
    const box = e.getBoundingClientRect();
    return { text, left: box.left - origin.left, top: box.top - origin.top,
             right: box.right - origin.left };
  }).sort((a, b) => a.text.localeCompare(b.text) || a.left - b.left || a.top - b.top);
}"""
POINTS = """inside => {
  const area = document.querySelector('#readings-plot .area');
  const origin = area.getBoundingClientRect();
  const boxes = [...area.querySelectorAll(inside)].map(e => e.getBoundingClientRect());
  return [Math.min(...boxes.map(b => b.left)) - origin.left,
          Math.max(...boxes.map(b => b.right)) - origin.left,
          Math.min(...boxes.map(b => b.top)) - origin.top];
}"""


def larger(times: float, folder: Path) -> Path:
    """Some readings of dev07, which are soon diagnosed, with angles that many times as large."""
    with (FOLDER / "dev07.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))[::7]
    for row in rows:
        for column in row:
            if "elastic_angle" in column:
                row[column] = repr(float(row[column]) * times)
    table = folder / "larger.csv"
    with table.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    return table


@pytest.mark.parametrize(
    ("times", "unit", "width", "tick"),
    [
        (1, "arcsec", 1280, "\N{MINUS SIGN}40"),
        (1e4, "arcsec", 390, "\N{MINUS SIGN}400000"),
        (1e4, "urad", 1280, "\N{MINUS SIGN}2×106"),
    ],
)
def test_sketch_and_plot_have_the_same_numbers_in_the_same_places(
    browser: Any, tmp_path: Path, times: float, unit: str, width: int, tick: str
) -> None:
    with sketched(browser, larger(times, tmp_path), tmp_path, width=width) as page:
        page.select_option("#unit", unit)
        first = page.evaluate(PLACES, "svg text")
        points = page.evaluate(POINTS, ".signs")
        arrived(page)
        then = page.evaluate(PLACES, ":is(.xtick, .ytick, .y2tick, .infolayer) text")
        assert [t["text"] for t in first] == [t["text"] for t in then]
        assert tick in [t["text"] for t in first]
        for a, b in zip(first, then, strict=True):
            assert all(abs(a[k] - b[k]) < 1 for k in ("left", "top", "right")), (a, b)
        assert points == pytest.approx(page.evaluate(POINTS, ".signs"), abs=0.5)
        room = page.locator("#readings-plot .area").bounding_box()["width"]
        assert all(t["left"] >= 0 and t["right"] <= room for t in first)
        # Titles stand beside their numbers.
        titles = [t for t in first if f"({unit})" in t["text"]]
        numbers = [t for t in first if t["text"] == tick]
        assert len(titles) == 2 and numbers
        assert max(t["right"] for t in titles if "elastic" in t["text"]) < min(
            t["left"] for t in numbers
        )


def test_no_plot_writes_numbers_with_endings_of_units(browser: Any, tmp_path: Path) -> None:
    with watched(browser) as page:
        page.goto(undiagnosed(FOLDER / "dev07.toml", FOLDER / "dev07.csv", tmp_path))
        page.wait_for_selector("#drive .main-svg", state="attached")
        page.wait_for_selector(DRAWN)
        # Of every axis and colour bar, 4k to 40M of what are no prefixed units.
        formats = page.evaluate(
            """() => [...document.querySelectorAll('.js-plotly-plot')].flatMap(area => [
              ...Object.entries(area._fullLayout).filter(([key]) => /^[xy]axis/.test(key)),
              ...area._fullData.filter(d => d.showscale).map(d => ['bar', d.colorbar]),
            ].map(([key, axis]) => `${key} ${axis.exponentformat}`))"""
        )
        assert {f.split()[1] for f in formats if f.split()[1] != "undefined"} == {"power"}
        assert "bar power" in formats and "yaxis2 power" in formats


# --- early files --------------------------------------------------------------------------


def test_a_file_dropped_before_the_sections_are_there_is_taken(browser: Any, bench: str) -> None:
    held: list[Any] = []
    with watched(browser) as page:
        page.route("**/sections/all.js", lambda route: held.append(route))
        page.goto(bench)
        page.wait_for_selector(SKETCH)
        stopped = page.evaluate(
            """() => {
              const dataTransfer = new DataTransfer();
              dataTransfer.items.add(new File(['torque_Nm\\n'], 'early.csv'));
              return ['dragover', 'drop'].map(name => {
                const event = new DragEvent(
                  name, { dataTransfer, cancelable: true, bubbles: true });
                document.body.dispatchEvent(event);
                return event.defaultPrevented;
              });
            }"""
        )
        assert stopped == [True, True]
        while not held:  # the page has yet to ask
            page.wait_for_timeout(10)
        held.pop().continue_()
        page.wait_for_selector("dialog[open] #upload-found:has-text('early.csv')")
        page.click("dialog >> text=Close")
        page.wait_for_selector(READY)
