"""Pictures of the page, taken in Chromium: `make screenshots`, and `make docs` for the gallery.

    python docs/site/screenshots.py FOLDER

The script reaches every state as a user would. Pictures have 256 colours, so that files stay small.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

TOP = Path(__file__).parents[2]
sys.path.insert(0, str(TOP / "tests"))
from common.browser import chromium, open_campaign, watched, workbench  # noqa: E402
from common.hidden import FOLDER  # noqa: E402

COLOURS = 256
ON = "#missing [data-effect={}][aria-checked=true]"


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)

    def take(page: Any, name: str, first: str, last: str, most_px: int = 1600) -> None:
        save(picture_of(page, first, last, most_px), folder / f"{name}.png")

    with chromium() as browser, workbench(matrices=9) as address:
        with watched(browser) as page:
            opened(page, address, "dev04")
            take(page, "before", "#answer", "#readings")
            page.click("#missing [data-effect=friction_hysteresis]")
            page.wait_for_selector(ON.format("friction_hysteresis"))
            take(page, "after", "#answer", "#readings")
            take(page, "missing", "#missing .cards .candidate:nth-child(3)", "#missing .cards", 900)
            take(page, "where", "#where", "#where")
            take(page, "ladder", "#ladder", "#ladder")
            take(page, "next", "#next", "#next", 900)
            take(page, "tell", "#tell", "#tell", 900)
            take(page, "drive", "#drive", "#drive", 1150)
        with watched(browser, color_scheme="dark") as page:
            opened(page, address, "dev10")
            page.click("#own-fit")
            page.wait_for_selector("#model-bar [data-effect=my_effect][aria-checked=true]")
            take(page, "own_dark", "#own", "#own")
        with watched(browser, 390, device_scale_factor=1.5) as page:
            opened(page, address, "dev04")
            page.click("#missing [data-effect=friction_hysteresis]")
            page.wait_for_selector(ON.format("friction_hysteresis"))
            take(page, "phone", "body", "#readings", 1500)


def opened(page: Any, address: str, name: str) -> None:
    """The page with a campaign and its answer."""
    page.goto(address)
    page.wait_for_selector("html[data-drawn], dialog[open]")
    open_campaign(page, FOLDER, name)
    page.wait_for_selector("#matrix .main-svg")


def picture_of(page: Any, first: str, last: str, most_px: int) -> bytes:
    """A picture from the top of one element to the end of another, no taller than `most_px`."""
    page.mouse.move(2, 2)
    page.wait_for_selector("html[data-drawn]")
    # What stays in sight while scrolling would lie over the picture.
    page.evaluate("document.querySelector('#model-bar').style.position = 'static'")
    page.evaluate("scrollTo(0, 0)")
    size = page.viewport_size
    page.set_viewport_size({"width": size["width"], "height": 4000})
    page.wait_for_selector("html[data-drawn]")
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    top = page.locator(first).first.bounding_box()["y"]
    end = page.locator(last).first.bounding_box()
    whole = top < 160
    raw: bytes = page.screenshot(
        full_page=True,
        clip={
            "x": 0 if whole else end["x"] - 12 if end["x"] > 12 else 0,
            "y": 0 if whole else top - 12,
            "width": size["width"] if whole else min(end["width"] + 24, size["width"]),
            "height": min(end["y"] + end["height"] + 12 - (0 if whole else top - 12), most_px),
        },
    )
    page.set_viewport_size(size)
    return raw


def save(raw: bytes, path: Path) -> None:
    """Write a picture with few colours."""
    from PIL import Image

    picture = Image.open(io.BytesIO(raw)).convert("RGB")
    # First colours far from each other, or those of a few points are lost; then the means of what
    # is near them.
    few = picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)
    few.save(path, optimize=True)
    print(f"{path}: {picture.size[0]} x {picture.size[1]}, {path.stat().st_size // 1024} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
