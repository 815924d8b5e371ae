"""The page as one file: the document inside, opened from disk without a network.

    report      the whole page of a document: modules, sheet, plotting library and document in one

The modules stay as they are: an import map gives each its text under a name (`cbpt/lib/store.js`),
and their imports (`from "../lib/store.js"`) are turned into these names. A policy in the file
forbids every request.
"""

from __future__ import annotations

import base64
import functools
import gzip
import json
import re
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from cbpt.errors import PlotError
from cbpt.page.document.plain import to_json

WEB = Path(__file__).with_name("web")
"""The page's own files."""
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; "
    "img-src data: blob:; base-uri 'none'; form-action 'none'"
)
_LOADED = re.compile(r"<!-- loaded.*?<!-- /loaded -->", re.DOTALL)
_SHEET = re.compile(r'<link rel="stylesheet" href="([\w.-]+\.css)">')
_IMPORT = re.compile(r'(from |import\()"(\.[\w./-]+\.js)"')


def report(document: Mapping[str, Any]) -> str:
    """HTML with everything inside."""
    return _frame().replace("<!--document-->", inside_script(to_json(document)), 1)


def inside_script(text: str) -> str:
    """JSON for the inside of a script element: nothing that a file says may end the element."""
    for sign, escape in (("<", "\\u003c"), ("\u2028", "\\u2028"), ("\u2029", "\\u2029")):
        text = text.replace(sign, escape)
    return text


def plotly_path() -> Path:
    """The plotting library of the PyPI package."""
    # Found, not imported: its Python is not needed.
    found = find_spec("plotly")
    if found is None or found.origin is None:
        raise PlotError('the page needs plotly: pip install "cbpt[workbench]"')
    return Path(found.origin).with_name("package_data") / "plotly.min.js"


@functools.cache
def _frame() -> str:
    """The page without a document."""
    page = (WEB / "index.html").read_text(encoding="utf-8")
    modules = {_name(path): _as_url(path) for path in sorted(WEB.rglob("*.js"))}
    plotly = base64.b64encode(gzip.compress(plotly_path().read_bytes(), 9, mtime=0)).decode()
    for old, new in (
        ('<html lang="en">', '<html lang="en" data-mode="report">'),
        (
            '<meta charset="utf-8">',
            f'<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" '
            f'content="{_POLICY}">',
        ),
        (
            _LOADED.findall(page)[0],
            f'<script type="importmap">{inside_script(json.dumps({"imports": modules}))}</script>',
        ),
        (
            "</body>",
            '<script type="application/json" id="document"><!--document--></script>\n'
            f'<script type="application/gzip" id="plotly">{plotly}</script>\n'
            '<script type="module">import "cbpt/main.js";</script>\n</body>',
        ),
    ):
        assert page.count(old) == 1, old
        page = page.replace(old, new)
    return _SHEET.sub(lambda found: _as_style(WEB / found[1]), page)


def _as_style(path: Path) -> str:
    return f"<style>\n{path.read_text(encoding='utf-8')}</style>"


def _name(path: Path) -> str:
    """A module's name in the import map."""
    return f"cbpt/{path.resolve().relative_to(WEB.resolve()).as_posix()}"


def _as_url(path: Path) -> str:
    def named(found: re.Match[str]) -> str:
        return f'{found[1]}"{_name(path.parent / found[2])}"'

    text = _IMPORT.sub(named, path.read_text(encoding="utf-8"))
    return f"data:text/javascript;base64,{base64.b64encode(text.encode()).decode()}"
