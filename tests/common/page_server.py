"""A workbench's server without a network, for the tests of it: fixtures and what they open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pytest
from starlette.testclient import TestClient

from cbpt.page.workbench.server import application
from cbpt.page.workbench.session import Session
from common.hidden import FOLDER

TOKEN, PORT = "right-token", 8123
HERE = f"http://127.0.0.1:{PORT}"
CASE, DATA = FOLDER / "dev04.toml", FOLDER / "dev04.csv"
HEAD = "run,time_s,torque_Nm,preload_N,elastic_angle_arcsec,u_elastic_angle_arcsec\n"
ROWS = "".join(f"1,{i},{t},600,{3.1 * t:.3f},0.3\n" for i, t in enumerate([0, 1, 2, 3, 2, 1, 0]))


def client_of(session: Session, inside: bool = True, **more: Any) -> TestClient:
    headers = {"x-cbpt-token": TOKEN} if inside else {}
    app = application(session, TOKEN, PORT, **more)
    return TestClient(app, base_url=HERE, headers=headers)


def own_effect(number: Mapping[str, Any], **changes: Any) -> dict[str, Any]:
    """An effect of the user's own as the page sends it, with one number `a`."""
    effect = {"id": "mine", "port": "series", "expression": "a * torque_Nm"}
    return {**effect, "parameters": [{"name": "a", "start": 1e-6, **number}], **changes}


@pytest.fixture
def session() -> Iterator[Session]:
    found = Session()
    yield found
    found.close()


@pytest.fixture
def client(session: Session) -> TestClient:
    return client_of(session)


@pytest.fixture(scope="module")
def diagnosed() -> Iterator[tuple[Session, TestClient]]:
    """dev04 opened and diagnosed once."""
    found = Session.of_files(CASE, DATA)
    client = client_of(found)
    assert client.post("/api/diagnose", json={}).json()["state"] == "running"
    assert found.join(120)
    yield found, client
    found.close()


def upload(client: TestClient, name: str, raw: bytes) -> Any:
    return client.post(
        "/api/upload",
        params={"name": name},
        content=raw,
        headers={"content-type": "application/octet-stream"},
    )


def opened(client: TestClient, raw: bytes, name: str = "t.csv") -> Any:
    """dev04's case with a table."""
    assert upload(client, "case.toml", CASE.read_bytes()).status_code == 200
    return upload(client, name, raw)
