"""Who may come in to the workbench's server, and what it hands out: tokens, names, policy."""

from __future__ import annotations

import re

import pytest
from starlette.testclient import TestClient

from cbpt.page.workbench.session import Session
from common.page_server import PORT, TOKEN, client_of


def test_the_token_in_the_address_becomes_a_cookie_and_leaves_the_address(
    session: Session,
) -> None:
    client = client_of(session, inside=False)
    assert client.get("/").status_code == 403
    assert client.get("/api/document").status_code == 403
    assert client.get("/", params={"token": "wrong"}).status_code == 403
    found = client.get("/", params={"token": TOKEN}, follow_redirects=False)
    assert (found.status_code, found.headers["location"]) == (303, "/")
    cookie = found.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    page = client.get("/")
    assert page.status_code == 200
    assert TOKEN not in page.text
    assert client.get("/api/document").json() is None


@pytest.mark.parametrize("token", ["", "right-tokem", "rïght", "right-token\u0000"])
def test_another_token_is_none(session: Session, token: str) -> None:
    client = client_of(session, inside=False)
    cookie = f"cbpt_{PORT}={token}; cbpt_1={TOKEN}"
    for name, value in (("x-cbpt-token", token), ("cookie", cookie)):
        headers = [(name.encode(), value.encode("utf-8"))]
        assert client.get("/api/job", headers=headers).status_code == 403


@pytest.mark.parametrize(
    "host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1", f"127.0.0.1:{PORT + 1}", "",
             f"127.0.0.1.evil.example:{PORT}", f"192.168.0.7:{PORT}", f"[::1:{PORT}"],
)  # fmt: skip
def test_a_name_that_is_not_ours_is_refused(client: TestClient, host: str) -> None:
    assert client.get("/api/job", headers={"host": host}).status_code == 421


@pytest.mark.parametrize("host", [f"localhost:{PORT}", f"[::1]:{PORT}"])
def test_other_names_of_this_machine_are_ours(client: TestClient, host: str) -> None:
    assert client.get("/api/job", headers={"host": host}).status_code == 200


def test_where_it_listens_to_the_network_addresses_are_taken_but_no_foreign_names(
    session: Session,
) -> None:
    client = client_of(session, hosts=frozenset({"rig.local"}), addresses=True)
    for host, status in (("192.168.0.7", 200), ("rig.local", 200), ("evil.example", 421)):
        assert client.get("/api/job", headers={"host": f"{host}:{PORT}"}).status_code == status


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": f"http://127.0.0.1:{PORT + 1}"},
        {"origin": "null"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
def test_another_page_may_not_ask(client: TestClient, headers: dict[str, str]) -> None:
    assert client.get("/api/job", headers=headers).status_code == 403
    assert client.post("/api/cancel", json={}, headers=headers).status_code == 403


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""]
)
def test_what_a_foreign_form_could_send_changes_nothing(client: TestClient, kind: str) -> None:
    found = client.post("/api/diagnose", content=b"{}", headers={"content-type": kind})
    assert found.status_code == 415


@pytest.mark.parametrize("address", ["/", "/main.js", "/page.css", "/api/job", "/none", "/api/no"])
def test_every_answer_has_a_strict_policy_and_nobody_is_let_in_from_elsewhere(
    client: TestClient, address: str
) -> None:
    headers = client.get(address).headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "unsafe-eval" not in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert not [name for name in headers if name.startswith("access-control")]


def test_the_page_has_no_script_of_its_own_inside(client: TestClient) -> None:
    page = client.get("/").text
    assert not re.search(r"<script(?![^>]*\bsrc=)", page)
    assert not re.search(r"\son\w+\s*=", page)
    assert "http:" not in page
    assert "https:" not in page


def test_plotly_is_served_from_here(client: TestClient) -> None:
    found = client.get("/plotly.min.js")
    assert found.status_code == 200
    assert found.headers["content-type"].startswith("text/javascript")


@pytest.mark.parametrize(
    "address",
    [
        "/../server.py", "/..%2fserver.py", "/%2e%2e/server.py", "/web/main.js", "/types.d.ts",
        "//etc/passwd", "/main.js%00", "/index.html.bak", "/api/export/../../x",
    ],
)  # fmt: skip
def test_no_address_leads_to_other_files(client: TestClient, address: str) -> None:
    found = client.get(address)
    assert found.status_code in (400, 404, 409)
    assert "import" not in found.text
