"""The table of a benchmark, which stands between two marks on a page of the documentation.

parser_of   a command line with the flag --page
show_table  rows printed as they are found, and written to the page
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path


def parser_of(head: str | None) -> argparse.ArgumentParser:
    """A parser with the flag --page, described by the first line of a module's head."""
    parser = argparse.ArgumentParser(description=(head or "").partition("\n")[0])
    parser.add_argument("--page", type=Path, help="write the table between the marks of this page")
    return parser


def show_table(rows: Iterable[str], page: Path | None, marks: tuple[str, str]) -> None:
    """Print each row of a table, and put all in the place of what is between the marks of a page.

    Raises `ValueError` where the page has not both marks.
    """
    table = []
    for row in rows:
        print(row, flush=True)
        table.append(row)
    if page:
        begin, end = marks
        before, rest = page.read_text(encoding="utf-8").split(begin)
        _, after = rest.split(end)
        made = "\n".join([begin, "", *table, "", end])
        page.write_text(before + made + after, encoding="utf-8")
