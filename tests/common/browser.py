"""A real browser on the page: Debian's Chromium by Playwright, and a workbench to look at.

Whoever opens a page through `watched` has everything that it asks for outside this machine, and
every error in its console, counted as a failure.
"""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from common import PATIENCE_S

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
READY, DRAWN = "html[data-ready]", "html[data-drawn]"
"""The first plot is alive; nothing is left to draw."""
PATIENCE_MS = round(1e3 * PATIENCE_S)
# The sandbox of Chromium is not to be had as root, as in most CI machines.
_LAUNCH = {"executable_path": CHROMIUM, "args": ["--no-sandbox"]}


@contextmanager
def chromium() -> Iterator[Any]:
    """The browser; skips the test where there is none."""
    with _playwright() as playwright:
        browser = playwright.chromium.launch(**_LAUNCH)
        yield browser
        browser.close()


@contextmanager
def kept_chromium(folder: Path) -> Iterator[Any]:
    """A browser that keeps in a folder what it has seen, as that of a user does."""
    with _playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(folder, **_LAUNCH)
        yield context
        context.close()


@contextmanager
def _playwright() -> Iterator[Any]:
    if CHROMIUM is None:
        import pytest

        pytest.skip("no Chromium on this machine: make setup-browser installs it")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        yield playwright


@contextmanager
def watched(
    browser: Any, width: int = 1280, blocked: str = "//nothing", **options: Any
) -> Iterator[Any]:
    """A page of its own; at its end nothing may have gone wrong or asked elsewhere.

    blocked: part of the addresses that the test itself keeps from the page.
    """
    wrong: list[str] = []
    context = browser.new_context(
        viewport={"width": width, "height": 900}, accept_downloads=True, **options
    )
    context.set_default_timeout(PATIENCE_MS)

    def through(route: Any) -> None:
        address = urlsplit(route.request.url)
        if address.scheme in ("data", "blob", "file") or address.hostname == "127.0.0.1":
            route.continue_()
        else:
            wrong.append(f"asked for {route.request.url}")
            route.abort()

    context.route("**/*", through)
    page = context.new_page()
    page.on("pageerror", lambda error: wrong.append(f"page error: {error}"))

    def asked(dialog: Any) -> None:
        wrong.append(f"dialog: {dialog.message}")
        dialog.dismiss()

    page.on("dialog", asked)

    def heard(message: Any) -> None:
        if message.type in ("error", "warning") and blocked not in message.location["url"]:
            wrong.append(f"console: {message.text}")

    page.on("console", heard)
    yield page
    context.close()
    assert not wrong, wrong


_START = """
import sys
from cbpt.cli.main import main
{before}
sys.exit(main())
"""
# Models that may be asked for next would be fitted behind whatever test comes next.
_NOTHING_AHEAD = """
from cbpt.page.workbench.ahead import Ahead
Ahead.around = lambda self, *models: None
"""
# Seconds for each campaign that is opened, for one plot.
_FEW_MATRICES = """
from cbpt.page.workbench.session import Session
isolability, some = Session.isolability, iter(range(MATRICES))
left_out = dict(isolability=None, why="left out")
Session.isolability = lambda self: left_out if next(some, None) is None else isolability(self)
"""


@contextmanager
def workbench(
    *files: Path, port: int | None = None, whole: bool = False, matrices: int = 0
) -> Iterator[str]:
    """A workbench in a process of its own; its address.

    whole: it prepares models that may be asked for next, as a user's does, and the matrix of
    effects that can be told apart; else that of so many campaigns.
    """
    before = "" if whole else f"MATRICES = {matrices}{_NOTHING_AHEAD}{_FEW_MATRICES}"
    flags = ["--no-browser", *([] if port is None else ["--port", str(port)])]
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            _START.format(before=before),
            "workbench",
            *flags,
            *map(str, files),
        ],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    with process.stdout as told:
        try:
            yield told.readline().split()[-1]
        finally:
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) == 0


def undiagnosed(case: Path, table: Path, folder: Path) -> str:
    """A report of readings beside the model as stated alone: quick to make."""
    import cbpt
    from cbpt.page.document.document import page_document
    from cbpt.page.document.source import Source
    from cbpt.page.report import report

    path = folder / "report.html"
    name, text = case.name, case.read_text(encoding="utf-8")
    readings = cbpt.read_readings(table, need_preload=False)
    source = Source.of_files(name, table.name, text)
    found = page_document(cbpt.Case.from_toml(text), readings, source)
    path.write_text(report(found), encoding="utf-8")
    return path.as_uri()


def open_campaign(page: Any, folder: Path, name: str) -> None:
    """Hand over a campaign's two files, and wait for its answer and all that follows from it."""
    page.wait_for_selector("html[data-drawn]")
    if not page.is_visible("dialog[open]"):
        page.click("#open-files")
    page.set_input_files("#files", [folder / f"{name}.csv", folder / f"{name}.toml"])
    page.wait_for_selector("dialog", state="hidden")
    page.wait_for_function(
        "name => document.querySelector('#what').textContent.includes(name)", arg=name
    )
    page.wait_for_selector("#sentence")
    page.wait_for_selector("#job", state="hidden")


def number(page: Any, selector: str) -> float:
    """The number that an element shows."""
    return float(str(page.text_content(selector)).replace("\N{MINUS SIGN}", "-"))


def saved(page: Any, button: str, folder: Path) -> Path:
    """What a button saves."""
    with page.expect_download() as waiting:
        page.click(button)
    path = folder / str(waiting.value.suggested_filename)
    waiting.value.save_as(path)
    return path
