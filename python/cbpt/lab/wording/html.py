"""What results show of themselves in a notebook. Everything is escaped: names come from files.

paragraph, bullets, table   text in HTML
folded                      plain text behind a heading that opens it
Reported                    a result whose report a notebook shows
of_report                   the text that a result prints: its paragraphs, and its tables as tables
picture                     what a method draws, as SVG; nothing without matplotlib
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from html import escape
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory

from cbpt.errors import PlotError
from cbpt.lab.wording.layout import unlimited

__all__ = ["Reported", "bullets", "folded", "of_report", "paragraph", "picture", "table"]

_ROW, _FRAME = "│", "┌╞├└"
"""What lines of a text table begin with."""


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


class Reported:
    """A result that prints a report, and shows it in a notebook, its picture with it."""

    report: Callable[[], str]

    def _repr_html_(self) -> str:
        draw = getattr(self, "plot", None)
        return of_report(self.report) + (picture(draw) if draw else "")


def of_report(report: Callable[[], str]) -> str:
    """What `report` prints, its text tables as tables."""
    with unlimited():
        lines = report().split("\n")
    parts: list[str] = []
    for is_table, group in groupby(lines, lambda line: line[:1] != "" and line[0] in _ROW + _FRAME):
        if is_table:
            rows = [line.strip(_ROW).split("┆") for line in group if line[0] == _ROW]
            head, *body = [[cell.strip() for cell in row] for row in rows]
            parts.append(table(head, body))
        else:
            parts += [paragraph(line) for line in group if line.strip()]
    return "".join(parts)


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
