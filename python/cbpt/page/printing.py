"""A page printed by a browser of this machine.

    print_pdf   HTML text -> the bytes of a PDF

The page is what any browser prints; this one is run without a window and without a network.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from cbpt.errors import PlotError

_BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
)
_LONGEST_S = 120


def print_pdf(html: str) -> bytes:
    """The page on paper. Raises `PlotError` without a browser, and where it prints nothing."""
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None:
        raise PlotError(
            "a PDF is printed by a browser, and none was found: install Chromium, or write the "
            "page as .html and print it from any browser"
        )
    with tempfile.TemporaryDirectory(prefix="cbpt-", ignore_cleanup_errors=True) as folder:
        page, out = Path(folder, "page.html"), Path(folder, "page.pdf")
        page.write_text(html, encoding="utf-8")
        command = [
            browser,
            "--headless",
            "--disable-gpu",
            "--no-pdf-header-footer",
            f"--user-data-dir={folder}/profile",
            f"--print-to-pdf={out}",
            page.as_uri(),
        ]
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # it refuses its sandbox to root
            command.insert(1, "--no-sandbox")
        try:
            subprocess.run(command, capture_output=True, timeout=_LONGEST_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PlotError(f"{browser} could not print the page: {error}") from error
        if not out.exists():
            raise PlotError(
                f"{browser} printed nothing: write the page as .html and print it from a browser"
            )
        return out.read_bytes()
