"""Files are opened while the page asks about those it shows: each order of events, deliberately.

The page may not ask the server about files that the server no longer has: the answer is a 409,
which every `watched` page counts as a failure.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from common.browser import PATIENCE_MS, watched, workbench
from common.page_server import CASE, HEAD, ROWS

ASKS = """
async () => {
  const { post } = await import('/lib/api.js');
  window.told = '';
  const say = words => () => window.told = words;
  post('drive', { load: {}, design: {} }).then(say('answered'), say('dropped'));
}
"""


@pytest.fixture
def page(browser: Any, tmp_path: Path) -> Iterator[Any]:
    """The page with a first table, its diagnosis done."""
    with workbench() as address, watched(browser) as found:
        found.goto(address)
        found.wait_for_selector("dialog[open]")
        table(found, tmp_path, "first", CASE)
        shows(found, "first")
        found.wait_for_selector("#job", state="hidden")
        yield found


def table(page: Any, folder: Path, name: str, *others: Path) -> None:
    """Hand over a table, without waiting for what comes of it."""
    path = folder / f"{name}.csv"
    path.write_text(HEAD + ROWS, encoding="utf-8")
    if not page.is_visible("dialog[open]"):
        page.click("#open-files")
    page.set_input_files("#files", [*others, path])


def shows(page: Any, name: str) -> None:
    page.wait_for_function(
        "name => document.querySelector('#what').textContent.includes(name)", arg=name
    )


def held(page: Any, address: str, answered: bool) -> list[Any]:
    """Hold what goes to an address: with the server's answer, which the page has not, or before
    the server hears of it. Who waits for the first finds it here."""
    found: list[Any] = []

    def hold(route: Any) -> None:
        found.append((route, route.fetch() if answered else None))

    page.route(address, hold, times=1)
    return found


def wait_for(page: Any, found: list[Any]) -> tuple[Any, Any]:
    for _ in range(PATIENCE_MS // 20):
        if found:
            break
        page.wait_for_timeout(20)
    route, answer = found[0]
    return route, answer


def what_came(page: Any) -> str:
    """Of what was asked by `ASKS`."""
    page.wait_for_function("() => window.told !== ''")
    return str(page.evaluate("window.told"))


def test_what_is_asked_while_the_server_opens_other_files_is_not_sent(
    page: Any, tmp_path: Path
) -> None:
    # The server has opened the second table and the page does not know it yet.
    waiting = held(page, "**/api/upload?*", answered=True)
    table(page, tmp_path, "second")
    route, answer = wait_for(page, waiting)
    page.evaluate(ASKS)
    route.fulfill(response=answer)
    shows(page, "second")
    assert what_came(page) == "dropped"
    assert page.is_hidden("#trouble")


def test_what_was_asked_before_other_files_were_opened_is_taken_back(
    page: Any, tmp_path: Path
) -> None:
    # What the page has asked arrives after the files that it has handed over later.
    waiting = held(page, "**/api/drive?*", answered=False)
    page.evaluate(ASKS)
    route, _ = wait_for(page, waiting)
    table(page, tmp_path, "second")
    shows(page, "second")
    with suppress(Exception):  # the browser has none of it any more
        route.continue_()
    assert what_came(page) == "dropped"
    assert page.is_hidden("#trouble")


def test_what_was_asked_is_answered_where_the_files_are_refused(page: Any, tmp_path: Path) -> None:
    waiting = held(page, "**/api/drive?*", answered=False)
    page.evaluate(ASKS)
    wait_for(page, waiting)
    refused = tmp_path / "none.csv"
    refused.write_text("torque_Nm\n", encoding="utf-8")
    page.click("#open-files")
    # A table that cannot be read is an answer like any other, no failed request.
    page.set_input_files("#files", [refused])
    page.wait_for_function(
        "() => document.querySelector('#upload-found').textContent.includes('none.csv')"
        " && !/^Reading/.test(document.querySelector('#upload-found').textContent)"
    )
    assert what_came(page) == "answered"
    page.click("dialog >> text=Close")
    shows(page, "first")


def test_a_diagnosis_that_ends_with_its_files_offers_no_button(page: Any, tmp_path: Path) -> None:
    # The job that the page follows is of files that the server has let go.
    told = {"state": "running", "stage": "screen", "share": 0.1, "error": ""}
    of = {"x-cbpt-opened": "2"}

    def job(route: Any) -> None:
        if told:
            route.fulfill(json=told, headers=of)
        else:
            route.fallback()

    page.route("**/api/job?*", job)
    table(page, tmp_path, "second")
    shows(page, "second")
    page.wait_for_selector("#cancel")
    page.evaluate(
        """() => {
          window.offered = false;
          new MutationObserver(() => window.offered ||= !!document.querySelector('#diagnose'))
            .observe(document.querySelector('#job'), { childList: true, subtree: true });
        }"""
    )
    waiting = held(page, "**/api/upload?*", answered=True)
    table(page, tmp_path, "third")
    route, answer = wait_for(page, waiting)
    told["state"], of["x-cbpt-opened"] = "idle", "3"  # as the server has it from now on
    page.wait_for_timeout(500)  # several times as long as the page waits between two looks
    told.clear()
    route.fulfill(response=answer)
    shows(page, "third")
    page.wait_for_selector("#sentence")
    assert not page.evaluate("window.offered")
