"""Fixtures of several tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from common.tables import Write


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write text (or bytes) to a file in a directory of its own."""

    def put(content: str | bytes, name: str = "t.csv", encoding: str = "utf-8") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return put
