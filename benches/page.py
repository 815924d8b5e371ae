"""How quick the page is in a real browser: start to first plot, a switch, twenty thousand readings.

    python benches/page.py [--rounds N]

Start is that of `cbpt workbench CASE DATA` (medians): until the first plot is on the screen, and
until it answers to the pointer, in a new browser and in one that has opened a workbench before,
which keeps the plotting library compiled. A switch is from the click to the next picture with
curves, residual and error changed: of a model that the page has (the best of some rounds), of one
that the server has prepared while nothing was asked for, of one that follows at once on it, which
is prepared too where the answer has been looked at for a while, and of a third at once, which has
to be fitted (medians). `--json FILE` writes the same as JSON.
"""

from __future__ import annotations

import argparse
import json
import os
import socket
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from common.browser import chromium, kept_chromium, workbench
from common.hidden import FOLDER, table_of

READINGS = 20_000
# After this the server has prepared what is one switch away, and after this what is two (not of a
# long table).
NEAR_MS, FAR_MS = 8_000, 25_000
NEAR_OF_MANY_MS, FAR_OF_MANY_MS = 12_000, 12_000
ANSWER = "friction_hysteresis"
# Of both tables; and so many candidates that the diagnosis has not fitted beside the answer.
MOST_OTHERS = 5
OTHERS = """async ([answer, most]) => {
  const { documentShown } = await import("/lib/store.js");
  const whole = documentShown();
  const fitted = new Set(whole.models.map(m => m.key));
  return whole.candidates.map(c => c.effect)
    .filter(e => e !== answer && !fitted.has([answer, e].sort().join("+")))
    .filter(e => document.querySelector(`#missing [data-effect="${e}"]`))
    .slice(0, most);
}"""
# From a click to the picture after it: the frame that has the change, and the beginning of the
# next, when that one is on its way to the screen.
SWITCH = """async effect => {
  const find = () => document.querySelector(`#missing [data-effect="${effect}"]`);
  const before = find().getAttribute("aria-checked");
  const frame = () => new Promise(done => requestAnimationFrame(done));
  const start = performance.now();
  find().click();
  do await frame(); while (find().getAttribute("aria-checked") === before);
  await frame();
  return performance.now() - start;
}"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # Packages that are installed have their modules compiled.
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        os.environ["PYTHONPYCACHEPREFIX"] = str(folder / "compiled")
        with chromium() as browser:
            started(browser, FOLDER / "dev04.toml", FOLDER / "dev04.csv")
            found |= small(browser, options.rounds)
            found |= large(browser, options.rounds, folder)
        found |= again(options.rounds, folder)
    for what, size in found.items():
        print(f"{what.replace('_s,', ',').removesuffix('_s').replace('_', ' '):62s} {size:6.2f} s")
    if options.json:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


@contextmanager
def opened(browser: Any) -> Iterator[Any]:
    """A page that nobody watches: every request that is looked at costs time of its own."""
    page = browser.new_page()
    page.set_viewport_size({"width": 1280, "height": 900})
    yield page
    page.close()


def started(browser: Any, *files: Path, port: int | None = None) -> tuple[float, float, float]:
    """From the command to the first plot, of it the browser's part, and from the command until
    the plot is alive (it answers to the pointer), s."""
    with opened(browser) as page:
        begin = time.time()
        with workbench(*files, port=port, whole=True) as address:
            return _started(page, address, begin)


def _started(page: Any, address: str, begin: float) -> tuple[float, float, float]:
    page.goto(address, wait_until="commit")
    page.wait_for_selector("html[data-ready]")
    origin, first, alive = page.evaluate(
        """[performance.timeOrigin, ...["cbpt-first-plot", "cbpt-plot-alive"].map(
            name => performance.getEntriesByName(name)[0].startTime)]"""
    )
    # The browser keeps compiled what it has used to the end.
    page.wait_for_selector("#sentence")
    return (origin + first) / 1e3 - begin, first / 1e3, (origin + alive) / 1e3 - begin


def starts(browser: Any, rounds: int, *files: Path, port: int | None = None) -> tuple[float, ...]:
    """Medians of `started`."""
    found = [started(browser, *files, port=port) for _ in range(rounds)]
    return tuple(np.median(found, axis=0))


def small(browser: Any, rounds: int) -> dict[str, float]:
    """dev04: 396 readings."""
    files = FOLDER / "dev04.toml", FOLDER / "dev04.csv"
    first, of_page, alive = starts(browser, rounds, *files)
    with workbench(*files, whole=True) as address, opened(browser) as page:
        page.goto(address)
        switches = diagnosed(page, rounds, NEAR_MS, FAR_MS)
    return {
        "command_to_first_plot_s": first,
        "of_it_in_the_browser_s": of_page,
        "command_to_a_plot_that_is_alive_s": alive,
        **{f"{name}, 396 readings": value for name, value in switches.items()},
    }


def again(rounds: int, folder: Path) -> dict[str, float]:
    """dev04 in a browser that has opened a workbench before, at the same port."""
    files = FOLDER / "dev04.toml", FOLDER / "dev04.csv"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with kept_chromium(folder / "browser") as browser:
        starts(browser, 2, *files, port=port)
        first, _, alive = starts(browser, rounds, *files, port=port)
    return {
        "command_to_first_plot_s, a browser that knows it": first,
        "command_to_a_plot_that_is_alive_s, a browser that knows it": alive,
    }


def diagnosed(page: Any, rounds: int, near_ms: int, far_ms: int) -> dict[str, float]:
    """Switches once the answer is there, seen from where the curves are."""
    page.wait_for_selector("#sentence")
    page.wait_for_selector("#matrix .main-svg")
    page.wait_for_selector("html[data-drawn]")
    while page.is_visible("text=less likely candidates"):
        page.click("text=less likely candidates")
    page.evaluate("document.querySelector('#readings').scrollIntoView()")

    def switch(effect: str) -> float:
        return float(page.evaluate(SWITCH, effect)) / 1e3

    known = [switch(ANSWER) for _ in range(2 * rounds)]
    switch(ANSWER)
    others = page.evaluate(OTHERS, [ANSWER, MOST_OTHERS])
    page.wait_for_timeout(far_ms)
    found = []
    for k in range(len(others)):
        # The answer with one more, with two, with three: no set twice.
        three = [others[(k + n) % len(others)] for n in range(3)]
        page.wait_for_timeout(near_ms)
        found.append([switch(effect) for effect in three])
        for effect in reversed(three):
            switch(effect)
    prepared, at_once, fitted = np.median(found, axis=0)
    return {
        "switch_of_a_model_that_the_page_has_s": min(known),
        "switch_of_a_model_that_is_prepared,_median_s": prepared,
        "switch_at_once_after_it,_median_s": at_once,
        "a_third_at_once_(a_fit),_median_s": fitted,
    }


def large(browser: Any, rounds: int, folder: Path) -> dict[str, float]:
    """The campaign of dev04 measured again and again, with noise of its own."""
    columns = table_of("dev04")
    times = -(-READINGS // len(columns["run"]))
    rng = np.random.default_rng(4)
    runs = columns["run"].max()
    rows = [
        "run,time_s,torque_Nm,preload_N,input_angle_deg,elastic_angle_arcsec,u_elastic_angle_arcsec"
    ]
    for k in range(times):
        noise = 0.3 * rng.standard_normal(len(columns["run"]))
        for i in range(len(columns["run"])):
            if len(rows) <= READINGS:
                rows.append(
                    f"{columns['run'][i] + k * runs:.0f},{columns['time_s'][i] + 7200 * k:.2f},"
                    f"{columns['torque_Nm'][i]:g},{columns['preload_N'][i]:g},"
                    f"{columns['input_angle_deg'][i]:g},"
                    f"{columns['elastic_angle_arcsec'][i] + noise[i]:.3f},0.42"
                )
    table = folder / "many.csv"
    table.write_text("\n".join(rows) + "\n", encoding="utf-8")
    files = FOLDER / "dev04.toml", table
    whole, of_page, alive = started(browser, *files)
    with workbench(*files, whole=True) as address, opened(browser) as page:
        page.goto(address)
        begin = time.perf_counter()
        page.wait_for_selector("#matrix .main-svg")
        answered = time.perf_counter() - begin
        switches = diagnosed(page, rounds, NEAR_OF_MANY_MS, FAR_OF_MANY_MS)
    return {
        "command_to_first_plot, 20,000 readings": whole,
        "of_it_in_the_browser, 20,000 readings": of_page,
        "command_to_a_plot_that_is_alive, 20,000 readings": alive,
        "answer_and_all_of_the_page, 20,000 readings": answered,
        **{f"{name}, 20,000 readings": value for name, value in switches.items()},
    }


if __name__ == "__main__":
    main()
