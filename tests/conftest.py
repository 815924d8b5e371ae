"""Fixtures of several tests."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cbpt.lab.diagnosis import diagnose
from cbpt.lab.readings.apart import Limits
from cbpt.lab.selection import model_comparison
from cbpt.lab.selection.competition import Competition
from cbpt.page.workbench import ahead
from common import PATIENCE_S
from common.browser import chromium
from common.nested_sets import worse_than_a_part
from common.page_server import client, diagnosed, session  # noqa: F401  (fixtures)
from common.tables import Write

# A job in the background of a shell is born deaf to Ctrl-C, and so would be whatever it starts: the
# tests of Ctrl-C would wait for commands that never hear of it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests of the development sets stand together, so that one process diagnoses each set once for
    all of them: where there are several, each begins with a part of the list."""
    items.sort(key=lambda item: not hasattr(getattr(item, "module", None), "diagnosed"))


@pytest.fixture(scope="session", autouse=True)
def _near_alone() -> Iterator[None]:
    """Of models prepared ahead only those one switch away: the others take half a minute of each
    session, behind whatever test comes next. They have tests of their own in test_page_ahead."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ahead, "MOST_FAR", 0)
        yield


@pytest.fixture(scope="session", autouse=True)
def _patient() -> Iterator[None]:
    """A file that takes long on a busy machine is none that is refused."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Limits, "SECONDS", PATIENCE_S)
        yield


@pytest.fixture(scope="session", autouse=True)
def _nested() -> Iterator[None]:
    """In every diagnosis of every test no set is worse than one that it contains, but by a little:
    a search aims at the posterior, which the priors of the values are a part of."""

    def compete(*arguments: Any) -> Competition:
        found = model_comparison.compete(*arguments)
        assert worse_than_a_part(found, by=5.0) == []
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(diagnose, "compete", compete)
        yield


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write text (or bytes) to a file in a directory of its own."""

    def put(content: str | bytes, name: str = "t.csv", encoding: str = "utf-8") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return put
