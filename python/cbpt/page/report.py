"""The page as one file: the document inside, opened without a network."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cbpt.page.plain import to_json


def report(document: Mapping[str, Any]) -> str:
    """HTML with the whole document inside."""
    # Nothing that a file says may end the element.
    inside = to_json(document).replace("<", "\\u003c").replace("\u2028", "\\u2028")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>CBPT</title></head>\n'
        f'<body><script type="application/json" id="document">{inside}</script></body></html>\n'
    )
