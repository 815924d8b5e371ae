"""What results show of themselves in a notebook. Everything is escaped: names come from files.

paragraph, bullets, table   text in HTML
folded                      plain text behind a heading that opens it
picture                     what a method draws, as SVG; nothing without matplotlib
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from cbpt.errors import PlotError

__all__ = ["bullets", "folded", "paragraph", "picture", "table"]


def paragraph(text: str) -> str:
    """A paragraph."""
    return f"<p>{escape(text)}</p>"


def bullets(texts: Iterable[str]) -> str:
    """A list; nothing for none."""
    items = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>{items}</ul>" if items else ""


def table(headers: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; None is an empty cell."""

    def line(cells: Sequence[object], tag: str) -> str:
        shown = ("" if cell is None else escape(str(cell)) for cell in cells)
        return f"<tr>{''.join(f'<{tag}>{cell}</{tag}>' for cell in shown)}</tr>"

    body = "".join(line(row, "td") for row in rows)
    return f"<table><thead>{line(headers, 'th')}</thead><tbody>{body}</tbody></table>"


def folded(heading: str, text: str) -> str:
    """Plain text that a click opens."""
    return f"<details><summary>{escape(heading)}</summary><pre>{escape(text)}</pre></details>"


def picture(draw: Callable[[Path], None]) -> str:
    """An SVG of what `draw` writes to the path that it is given; empty without matplotlib."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.svg"
        try:
            draw(path)
        except PlotError:
            return ""
        svg = path.read_text(encoding="utf-8")
    return svg[svg.index("<svg") :]
