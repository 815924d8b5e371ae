"""What several tests share."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest

PATIENCE_S = 120.0
"""How long a test waits for what must come. Only what hangs is meant to meet it, however busy the
machine is: no test measures time against a clock."""


def mostly_long(cases: Iterable[Any], short: Collection[Any]) -> list[Any]:
    """Cases of one claim for `parametrize`: `make test` runs the short ones, `make test-long` the
    others."""
    cases = list(cases)
    assert all(case in cases for case in short), f"not among the cases: {short}"
    return [
        case
        if case in short
        else pytest.param(*case if isinstance(case, tuple) else [case], marks=pytest.mark.long)
        for case in cases
    ]
