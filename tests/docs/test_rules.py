"""The table of the decision's rules on docs/explanation/diagnosis.md is that of the record."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path

from cbpt.lab.selection.rules import RULES

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "diagnosis.md"
ROW = re.compile(r"^\| `(?P<rule>\w+)` \| (?P<value>[\d.]+) \| \S", re.MULTILINE)


def test_the_page_lists_every_rule_with_its_value() -> None:
    rows = {m["rule"]: float(m["value"]) for m in ROW.finditer(PAGE.read_text(encoding="utf-8"))}
    assert rows == asdict(RULES)
