"""The notebook of examples/ as a page: its cells are run here, and what they show stands below.

    run      the cells and what each shows, as a notebook would: HTML where there is some, else text

    write    the page

No kernel is needed: a cell is Python, and what it shows is the value of its last line.
"""

from __future__ import annotations

import ast
import contextlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

TOP = Path(__file__).parents[2]
NOTEBOOK = TOP / "examples" / "tutorial.ipynb"
FILES = "tutorial"
"""The folder beside the notebook that its cells read."""


def cells(notebook: Path = NOTEBOOK) -> list[tuple[str, str]]:
    """Kind (`markdown` or `code`) and text of each cell."""
    found = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in found]


def run(notebook: Path = NOTEBOOK) -> Iterator[tuple[str, str, str]]:
    """Kind and text of each cell, and what it shows; in a folder that is gone afterwards."""
    names: dict[str, Any] = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as left:
        shutil.copytree(notebook.parent / FILES, Path(folder) / FILES)
        left.callback(os.chdir, Path.cwd())
        os.chdir(folder)
        for kind, text in cells(notebook):
            yield kind, text, shown(text, names) if kind == "code" else ""


def shown(code: str, names: dict[str, Any]) -> str:
    """What a cell shows; `names` are those of the cells before it."""
    tree = ast.parse(code)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)
    if last is None:
        return ""
    assert isinstance(last, ast.Expr)
    value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    if hasattr(value, "_repr_html_"):
        return str(value._repr_html_())
    return "" if value is None else f"<pre>{escape(repr(value))}</pre>"


def write(source: Path) -> None:
    """The page, among the staged ones."""
    parts = []
    for kind, text, html in run():
        if kind == "markdown":
            parts.append(text)
            continue
        parts.append(f"```python\n{text}\n```")
        if html.startswith("<iframe"):
            parts.append("*Here stands [the page](page.md), as in a report.*")
        elif html:
            # A blank line would end the block of HTML.
            lines = "\n".join(line for line in html.splitlines() if line.strip())
            parts.append(f'<div class="notebook-output">\n{lines}\n</div>')
    page = source / "how-to" / "notebook-tutorial.md"
    page.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
