"""HTML as tests look at it."""

from __future__ import annotations

from html.parser import HTMLParser


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)


def tags(text: str) -> list[str]:
    """The tags that a text opens, in their order."""
    parser = _Tags()
    parser.feed(text)
    return parser.tags
