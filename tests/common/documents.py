"""Documents of the page for the development sets, made once."""

from __future__ import annotations

from functools import cache
from typing import Any

from cbpt.page.document.document import page_document
from cbpt.page.document.models import Models
from cbpt.page.document.source import Source
from common.hidden import diagnosed

SOURCE = Source.of_files("case.toml", "data.csv")


@cache
def models(name: str) -> Models:
    d = diagnosed(name)
    return Models(d, d.readings)


@cache
def document(name: str) -> Any:
    d = diagnosed(name)
    return page_document(d.case, d.readings, SOURCE, d, models=models(name))
