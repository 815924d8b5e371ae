"""The notebook of examples/: every cell runs, without a network, and shows what it is there for."""

from __future__ import annotations

import json
import socket
import sys
from pathlib import Path
from typing import Any

import pytest

from common.html import tags

TOP = Path(__file__).parents[2]
sys.path.insert(0, str(TOP / "docs" / "site"))

import notebook_page  # noqa: E402


@pytest.fixture
def no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Any connection is a mistake."""

    def refused(*address: Any) -> None:
        raise AssertionError(f"the notebook asked the network for {address}")

    monkeypatch.setattr(socket.socket, "connect", refused)


@pytest.mark.usefixtures("no_network")
def test_every_cell_runs_and_shows_its_result() -> None:
    here = Path.cwd()
    ran = [cell for cell in notebook_page.run() if cell[0] == "code"]
    assert Path.cwd() == here and 10 <= len(ran) <= 25
    for _, code, html in ran:
        assert ("iframe" in tags(html)) == (".show(" in code), code
        assert html and "script" not in tags(html), code
    assert sum("table" in tags(html) for _, _, html in ran) >= 8
    assert "answer.verdict.effects" in ran[-2][1]
    assert "The model agrees with the readings" in ran[-1][2]


def test_the_notebook_is_kept_without_outputs() -> None:
    document = json.loads(notebook_page.NOTEBOOK.read_text(encoding="utf-8"))
    assert document["nbformat"] == 4
    ids = [cell["id"] for cell in document["cells"]]
    assert len(set(ids)) == len(ids)
    assert not any(cell.get("outputs") for cell in document["cells"])


def test_the_page_of_the_site_has_the_code_and_the_tables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = [
        ("markdown", "# T", ""),
        ("code", "a", "<p>1</p>\n\n<p>2</p>"),
        ("code", "b", "<iframe>"),
    ]
    monkeypatch.setattr(notebook_page, "run", lambda: iter(told))
    (tmp_path / "how-to").mkdir()
    notebook_page.write(tmp_path)
    text = (tmp_path / "how-to" / "notebook-tutorial.md").read_text(encoding="utf-8")
    assert text.startswith("# T\n\n```python\na\n```\n\n<div")
    assert "<p>1</p>\n<p>2</p>" in text and "<iframe" not in text and "page.md" in text
