"""How wide text is: tables and prose fit the terminal, and are 100 columns wide in a file.

table         a text table
prose_width   columns of a paragraph
within        a text whose long lines run on below
unlimited     text that nothing folds, for who lays it out himself
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from textwrap import wrap

from cbpt._core import terminal_width, text_table

__all__ = ["prose_width", "table", "unlimited", "within"]

_PROSE = 100
"""Longer lines are hard to read."""
_FRAMES = "┌│╞├└"
_MOST = 65535
_width: ContextVar[int | None] = ContextVar("width", default=None)


def table(headers: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A text table, its words folded where it would be wider than the terminal."""
    return text_table(headers, [list(row) for row in rows], _width.get())  # type: ignore[arg-type]


def prose_width() -> int:
    """Columns that a paragraph takes."""
    return min(_PROSE, _width.get() or terminal_width())


def within(text: str) -> str:
    """A text whose lines of prose run on below where they would be wider than the terminal."""
    width = prose_width()
    lines: list[str] = []
    for line in text.split("\n"):
        if len(line) <= width or line[0] in _FRAMES:
            lines.append(line)
            continue
        indent = line[: len(line) - len(line.lstrip())]
        after = f"{indent}  " if indent else ""
        lines += wrap(
            line, width, subsequent_indent=after, break_long_words=False, break_on_hyphens=False
        )
    return "\n".join(lines)


@contextmanager
def unlimited() -> Iterator[None]:
    """Tables inside are as wide as they come."""
    token = _width.set(_MOST)
    try:
        yield
    finally:
        _width.reset(token)
