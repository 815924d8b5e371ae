"""Numbers of other files, of another sheet or of another window never stand beside those shown."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import xlsxwriter
from starlette.testclient import TestClient

from common.browser import DRAWN, PATIENCE_MS, open_campaign, watched, workbench
from common.hidden import FOLDER
from common.page_server import CASE, opened, upload

# --- the server ---------------------------------------------------------------------------


def test_who_shows_other_files_is_told_so(client: TestClient) -> None:
    opened(client, (FOLDER / "dev04.csv").read_bytes())
    document = client.get("/api/document")
    first = document.json()["opened"]
    assert document.headers["x-cbpt-opened"] == str(first)
    assert client.get("/api/job", params={"opened": first}).status_code == 200
    opened(client, (FOLDER / "dev04.csv").read_bytes(), "again.csv")
    for act in ("model", "own/fit", "shown", "drive", "cancel", "diagnose"):
        refused = client.post(f"/api/{act}", params={"opened": first}, json={})
        assert refused.status_code == 409, act
        assert "other files" in refused.json()["error"]
    # What no files are needed for goes on.
    assert client.get("/api/document").json()["opened"] > first


def test_another_sheet_is_another_campaign(client: TestClient, tmp_path: Path) -> None:
    book = tmp_path / "two.xlsx"
    with xlsxwriter.Workbook(book) as workbook:
        for k in (1, 2):
            sheet = workbook.add_worksheet(f"run {k}")
            sheet.write_row(0, 0, ["torque_Nm", "preload_N", "elastic_angle_arcsec"])
            for i in range(1, 9):
                sheet.write_row(i, 0, [i, 600, k * i])
    upload(client, "case.toml", CASE.read_bytes())
    upload(client, "two.xlsx", book.read_bytes())
    numbers = []
    for k in (1, 2):
        client.post("/api/columns", json={"columns": {}, "sheet": f"run {k}"})
        numbers.append(client.get("/api/document").json()["opened"])
    assert numbers[0] != numbers[1]


# --- the page -----------------------------------------------------------------------------


HELD = """async () => {
  const { state } = await import('/lib/store.js');
  return state.document.models.map(m => [m.key, m.residual_arcsec.length]);
}"""


SHOWN_LATER = """async effects => {
  (await import('/lib/models.js')).show(effects);
}"""


FRAMES = """async many => {
  for (let n = 0; n < many; n++) await new Promise(requestAnimationFrame);
}"""


@pytest.fixture(scope="module")
def bench(browser: Any) -> Iterator[str]:
    """A workbench that shows dev04, for tests that leave it so."""
    with workbench(FOLDER / "dev04.toml", FOLDER / "dev04.csv") as address:
        yield address


def answered(page: Any) -> None:
    page.wait_for_selector("#sentence")
    page.wait_for_selector("#job", state="hidden")


def test_a_model_of_files_that_are_shown_no_more_is_dropped(browser: Any) -> None:
    with workbench() as address, watched(browser) as page:
        page.goto(address)
        open_campaign(page, FOLDER, "dev07")
        # Plots out of sight wait for a model that is under way, and this one never comes.
        page.wait_for_selector(DRAWN)
        held: list[Any] = []
        page.route(re.compile("api/model"), lambda route: held.append(route))
        with page.expect_request(re.compile("api/model")):
            page.evaluate(SHOWN_LATER, ["drift", "plate_tilt"])
        open_campaign(page, FOLDER, "dev04")
        with suppress(Exception):  # the page has taken it back
            held[0].continue_()
        page.evaluate("() => new Promise(requestAnimationFrame)")
        assert page.is_hidden("#trouble")
        held_by_page = page.evaluate(HELD)
        assert "drift+plate_tilt" not in dict(held_by_page)
        assert {rows for _, rows in held_by_page} == {396}


def test_another_window_with_other_files_is_told_not_mixed(browser: Any) -> None:
    files = FOLDER / "dev04.toml", FOLDER / "dev04.csv"
    with workbench(*files) as address, browser.new_context() as context:
        context.set_default_timeout(PATIENCE_MS)
        first, second = context.new_page(), context.new_page()
        first.goto(address)
        answered(first)
        second.goto(address.split("?")[0])
        open_campaign(second, FOLDER, "dev07")
        before = first.evaluate(HELD)
        first.evaluate(SHOWN_LATER, ["creep", "drift", "plate_tilt"])
        first.wait_for_selector("#trouble:not([hidden])")
        assert "other files" in first.text_content("#trouble")
        assert first.evaluate(HELD) == before


def test_switches_used_faster_than_they_are_fitted_all_count(browser: Any, bench: str) -> None:
    with watched(browser) as page:
        page.goto(bench)
        answered(page)
        wanted = ["creep", "drift", "plate_tilt"]
        page.evaluate(
            """async effects => {
              const { toggle } = await import('/lib/models.js');
              await Promise.all(effects.map(effect => toggle(effect)));
            }""",
            wanted,
        )
        modelled = "async () => (await import('/lib/store.js')).modelShown().effects.toSorted()"
        assert page.evaluate(modelled) == wanted


def test_plots_wait_for_a_switch_but_not_where_they_are_looked_at(browser: Any, bench: str) -> None:
    # Not watched: the held request fails, which the console tells.
    with browser.new_context() as context:
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.set_viewport_size({"width": 1280, "height": 700})
        page.goto(bench)
        answered(page)
        page.wait_for_selector("html[data-drawn]")
        page.evaluate("document.querySelector('#readings').scrollIntoView()")
        held: list[Any] = []
        page.route(re.compile("api/model"), lambda route: held.append(route))
        # A model that the page has is shown, and at once one that it has to ask for.
        with page.expect_request(re.compile("api/model")):
            page.evaluate(
                """async () => {
                  const { show } = await import('/lib/models.js');
                  document.querySelector('#where .area').dataset.old = 'true';
                  show(['drift']);
                  show(['creep', 'drift', 'plate_tilt']);
                  Plotly.react = new Proxy(Plotly.react, { apply(react, self, given) {
                    delete given[0].dataset.old;
                    return Reflect.apply(react, self, given);
                  } });
                }"""
            )
        page.evaluate(FRAMES, 30)
        assert page.locator("#where .area[data-old]").count() == 1
        page.evaluate("document.querySelector('#where .area').scrollIntoView()")
        page.wait_for_selector("#where .area:not([data-old])")
        assert page.locator("html[data-drawn]").count() == 0
        held[0].abort()
        page.wait_for_selector("html[data-drawn]")
