"""How the workbench listens, and what it sends first."""

from __future__ import annotations

import asyncio
import json
import os
import posixpath
import re
import socket
from contextlib import closing
from pathlib import Path, PurePosixPath
from types import SimpleNamespace

import pytest
from starlette.testclient import TestClient

from cbpt.errors import CaseError, InvalidInputError
from cbpt.page.report import WEB
from cbpt.page.workbench import session as sessions
from cbpt.page.workbench.job import Job
from cbpt.page.workbench.own_check import own_effect_of, refusal
from cbpt.page.workbench.serve import _listening
from cbpt.page.workbench.server import _mark
from cbpt.page.workbench.session import CLOSING_S, Session
from common import PATIENCE_S
from common.hidden import FOLDER
from common.page_server import client_of


def test_answers_do_not_wait_for_the_browser_to_acknowledge_their_head() -> None:
    async def answered() -> int:
        found: asyncio.Future[int] = asyncio.get_running_loop().create_future()

        async def answer(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            asked = writer.get_extra_info("socket")
            found.set_result(asked.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        listening = _listening("127.0.0.1", 0)
        async with await asyncio.start_server(answer, sock=listening):
            _, writer = await asyncio.open_connection(*listening.getsockname())
            nodelay = await found
            writer.close()
        return nodelay

    assert asyncio.run(answered()) != 0


def test_the_same_address_where_it_is_free_else_another() -> None:
    with _listening("127.0.0.1", None) as first, _listening("127.0.0.1", None) as second:
        assert first.getsockname() != second.getsockname()
    with pytest.raises(InvalidInputError, match="--port"), _listening("127.0.0.1", 0) as taken:
        _listening("127.0.0.1", taken.getsockname()[1])


def test_a_page_of_an_earlier_workbench_at_the_same_address_is_told_to_reload(
    session: Session,
) -> None:
    """What it shows is of other readings than the answers would be."""
    first, second = client_of(session), client_of(session)
    key = _key(first)
    assert key != _key(second)
    assert first.get("/api/job", params={"page": key}).status_code == 200
    refused = second.get("/api/job", params={"page": key})
    assert refused.status_code == 409
    assert "reload" in refused.json()["error"]


def _key(client: TestClient) -> str:
    found = re.search(r"api/document\?page=(\w+)", client.get("/").text)
    assert found
    return found[1]


def test_the_end_waits_a_second_for_work_under_way_however_often_it_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [100.0]

    class Endless(Job):
        def join(self, seconds: float | None = None) -> bool:
            now[0] += seconds or 0.0
            return False

    monkeypatch.setattr(sessions, "time", SimpleNamespace(monotonic=lambda: now[0]))
    session = Session()
    session._job = Endless(lambda step: None)
    session.stop()
    now[0] += 0.25 * CLOSING_S
    session.close()
    session.close()
    assert now[0] == 100 + CLOSING_S


def test_another_version_of_the_library_has_another_name_in_the_browser(tmp_path: Path) -> None:
    path = tmp_path / "plotly.min.js"
    contents = [
        b"/* v1 */" + bytes(5000),
        b"/* v2 */" + bytes(5000),
        b"/* v1 */" + bytes(5001),
        b"x",
    ]
    marks = set()
    for content in contents:
        path.write_bytes(content)
        os.utime(path, (0, 0))
        marks.add(_mark(path))
    assert len(marks) == len(contents)


def test_the_first_plot_asks_for_all_its_modules_at_once() -> None:
    page = (WEB / "index.html").read_text(encoding="utf-8")
    preloaded = set(re.findall(r'rel="modulepreload" href="([\w./-]+)"', page))
    needed: set[str] = set()
    ways = ["main.js"]
    while ways:
        at = PurePosixPath(ways.pop())
        text = (WEB / at).read_text(encoding="utf-8")
        found = re.findall(r'from "(\.[\w./-]+\.js)"', text)
        new = {posixpath.normpath(at.parent / path) for path in found} - needed
        needed |= new
        ways += sorted(new)
    assert preloaded == needed


def test_readings_are_diagnosed_again_with_an_own_effect_and_the_headline_follows() -> None:
    """What the library lacks, written and fitted, then weighed: it is what is missing."""
    damage = {
        "id": "groove_damage",
        "port": "series",
        "expression": "a * sign(torque_Nm) * max(abs(torque_Nm) - t, 0)"
        " * exp(-((input_angle_rad - c) / w)^2)",
        "parameters": [
            {"name": "a", "unit": "rad/(N m)", "start": 1e-5, "min": 0.0, "max": 1e-3},
            {"name": "t", "unit": "N m", "start": 2.0, "min": 0.0, "max": 6.0},
            {"name": "c", "unit": "rad", "start": 2.2, "min": 1.8, "max": 2.8},
            {"name": "w", "unit": "rad", "start": 0.5, "min": 0.1, "max": 1.0},
        ],
    }
    with closing(Session.of_files(FOLDER / "dev10.toml", FOLDER / "dev10.csv")) as found:
        found.start()
        assert found.join(PATIENCE_S)
        before = json.loads(found.document() or "")["answer"]
        found.fit_own(damage)
        found.start(own=True)
        assert found.join(PATIENCE_S)
        after = json.loads(found.document() or "")["answer"]
    assert before["verdict"]["effects"] != ["groove_damage"]
    assert "groove_damage" in after["verdict"]["effects"]
    assert after["after"]["rmse_arcsec"] < 0.2 * after["before"]["rmse_arcsec"]


def test_a_unit_that_does_not_fit_is_told_with_the_one_that_does() -> None:
    a = {"name": "a", "unit": "rad/(N m)", "start": 1e-6}
    effect = {"id": "mine", "port": "series", "expression": "a * torque_Nm^2", "parameters": [a]}
    with pytest.raises(CaseError) as error:
        own_effect_of(effect)
    told = refusal(error.value, effect)
    assert (told["column"], told["field"]) == (1, "expression")
    assert told["message"].endswith("a series term is an angle: give a in rad/(N m)^2")
