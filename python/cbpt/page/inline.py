"""The page inside a notebook, without a server: `answer.show()` and `comparison.show()`.

Inline      the page in a frame of its own, which a notebook shows
inline      the page of a case, its readings and, if there is one, its diagnosis
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

from cbpt._core import Case, Drive
from cbpt.lab.readings.reader import Readings
from cbpt.page.document.document import page_document
from cbpt.page.document.source import Source
from cbpt.page.report import report
from cbpt.whole_files import write_whole

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.diagnosis import Diagnosis

__all__ = ["Inline", "inline"]


@dataclass(frozen=True)
class Inline:
    """A page that a notebook shows where it is the value of a cell."""

    html: str = field(repr=False)
    """The page as `cbpt report` writes it: one file that opens without a network."""
    height_px: int = 800

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file that a browser opens. Raises `OSError` where it cannot."""
        write_whole(path, self.html)

    def _repr_html_(self) -> str:
        # Scripts of the page see nothing of the notebook: the frame has an origin of its own.
        return (
            f'<iframe srcdoc="{escape(self.html)}" sandbox="allow-scripts allow-downloads" '
            f'style="width:100%;height:{int(self.height_px)}px;border:1px solid #ccc"></iframe>'
        )


def inline(
    case: Case | Drive, readings: Readings, diagnosis: Diagnosis | None, height_px: int
) -> Inline:
    """The page of what a notebook has at hand; no file has a name there but the table."""
    source = Source.of_files("case.toml", readings.source)
    return Inline(report(page_document(case, readings, source, diagnosis)), height_px)
