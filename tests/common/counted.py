"""Counts how often something is called."""

from __future__ import annotations

from typing import Any

import pytest


def calls_of(monkeypatch: pytest.MonkeyPatch, owner: object, name: str) -> list[Any]:
    """What a function of a class or module is given from now on, call by call; it does what it
    did."""
    made: list[Any] = []
    does = getattr(owner, name)

    def counted(*given: Any, **more: Any) -> Any:
        made.append(given)
        return does(*given, **more)

    monkeypatch.setattr(owner, name, counted)
    return made
