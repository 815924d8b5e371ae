"""The workbench's server against hostile files, names and requests.

Groups: hostile files and names; requests that are none of the page's.
"""

from __future__ import annotations

import io
import json
import re
import threading
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import xlsxwriter
from starlette.testclient import TestClient

from cbpt.errors import CaseError
from cbpt.page.workbench import uploads
from cbpt.page.workbench.session import Session
from common import PATIENCE_S
from common.page_server import CASE, HEAD, ROWS, opened, own_effect, upload

# --- hostile files and names ----------------------------------------------------------------

SCRIPT = "<script>alert(1)</script>"


def test_names_are_only_shown_and_lead_nowhere(client: TestClient, tmp_path: Path) -> None:
    name = f"../../{SCRIPT}\u202e\u0000.csv"
    found = opened(client, (HEAD + ROWS).encode(), name).json()
    assert found["ready"], found
    # Of a path the last part is shown; here it is what follows the slash of the closing tag.
    assert found["name"] == "script>.csv"
    found = upload(client, "..\\..\\etc\\" + "n" * 500 + ".csv", (HEAD + ROWS).encode()).json()
    assert found["name"] == "n" * 120
    assert upload(client, "", (HEAD + ROWS).encode()).json()["name"] == "table"


def test_hostile_words_in_a_table_arrive_as_text(client: TestClient) -> None:
    rows = ROWS.replace("1,", f"{SCRIPT},", 1).replace("\n1,", "\n\"=cmd|' /C calc'!A0\",")
    table = HEAD.replace("run", "run", 1).replace("\n", f",{SCRIPT}\n", 1)
    lines = [f"{line},7" for line in rows.splitlines()]
    found = opened(client, (table + "\n".join(lines)).encode()).json()
    assert found["ready"], found
    answer = client.get("/api/document")
    assert answer.headers["content-type"] == "application/json"
    assert SCRIPT in answer.json()["readings"]["run"]
    text = client.get("/api/export/csv").text
    assert "'=cmd" in text
    assert not re.search(r"(^|,)\"?=", text, re.MULTILINE)


def test_a_report_of_hostile_names_holds_no_script_of_theirs(client: TestClient) -> None:
    from cbpt.page.report import report

    case = CASE.read_text(encoding="utf-8") + f"\n# </script>{SCRIPT}<!--\n"
    upload(client, f"{SCRIPT.replace('/', '')}.toml", case.encode())
    rows = ROWS.replace("1,", f"</script>{SCRIPT},", 1)
    assert upload(client, "</SCRIPT>.csv", (HEAD + rows).encode()).json()["ready"]
    page = report(client.get("/api/document").json())
    assert SCRIPT not in page
    assert "<script>alert" not in page


@pytest.mark.parametrize(
    "raw",
    [
        b"", b"\x00" * 2000, b"\xff\xfe", b"PK\x03\x04 no archive", b"PAR1", b"TDSm", b"%PDF-1.7",
        b"MATLAB 5.0 MAT-file", b"\xd0\xcf\x11\xe0", b"\x89HDF\r\n", b"a" * 70_000,
        b"a,b\n" + b'"' * 1000, b"torque_Nm\n" * 3, HEAD.encode(),
        (HEAD + "1,0,nan,600,3,0.3\n").encode(), (HEAD + "1,0,1e999,600,3,0.3\n").encode(),
        (HEAD + "1,0,1,-600,3,0.3\n").encode(), (HEAD + "1,0,1,600,3,0\n").encode(),
        (HEAD + "1,0,1,600\n").encode(), "\n".join([HEAD] * 5).encode(),
    ],
    ids=lambda raw: repr(raw[:12]),
)  # fmt: skip
def test_what_is_no_table_of_readings_is_told_and_nothing_breaks(
    client: TestClient, raw: bytes
) -> None:
    found = opened(client, raw)
    if found.status_code == 200:
        assert not found.json()["ready"]
        assert found.json()["message"]
        told = found.json()["message"]
    else:
        assert found.status_code == 400
        told = found.json()["error"]
    assert "/tmp" not in told
    assert client.get("/api/document").json() is None
    assert opened(client, (HEAD + ROWS).encode()).json()["ready"]


@pytest.mark.parametrize(
    "raw",
    [b"", b"\xff\xfe\x00", b"[", b"a = 1", b"[deceleration]\nball_count = 1e9", b"x" * (2 << 20)],
    ids=lambda raw: repr(raw[:12]),
)
def test_what_is_no_case_is_told(client: TestClient, raw: bytes) -> None:
    found = upload(client, "case.toml", raw)
    assert found.status_code == 400
    assert found.json()["error"]


def test_a_case_keeps_its_comments_as_text(client: TestClient) -> None:
    text = f"# {SCRIPT}\n" + CASE.read_text(encoding="utf-8")
    upload(client, "c.toml", text.encode())
    upload(client, "t.csv", (HEAD + ROWS).encode())
    assert client.get("/api/document").json()["case"]["text"] == text
    with pytest.raises(CaseError, match="no UTF-8"):
        uploads.read_case("c.toml", b"# \xe4\n" + CASE.read_bytes())


def test_a_workbook_that_unpacks_to_far_more_is_not_unpacked(client: TestClient) -> None:
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for sheet in range(66):
            archive.writestr(f"xl/worksheets/sheet{sheet}.xml", b"0" * (1 << 22))
    assert len(raw.getvalue()) < uploads.MOST_BYTES
    found = opened(client, raw.getvalue(), "bomb.xlsx").json()
    assert not found["ready"]
    assert "when unpacked" in found["message"]


def test_a_stray_cell_in_the_last_row_does_not_fill_the_memory(
    client: TestClient, tmp_path: Path
) -> None:
    with xlsxwriter.Workbook(tmp_path / "t.xlsx") as book:
        page = book.add_worksheet("Data")
        page.write(0, 0, "torque_Nm")
        page.write(1_048_575, 16_000, 1)
    found = opened(client, (tmp_path / "t.xlsx").read_bytes(), "t.xlsx").json()
    assert not found["ready"]
    assert "cells" in found["message"]


def test_a_small_file_that_holds_more_cells_than_may_be_is_refused_unread(
    client: TestClient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Of one value repeated a column of Parquet is nearly nothing, a thousand million of it too.
    monkeypatch.setattr(uploads, "_MOST_CELLS", 100_000)
    path = tmp_path / "t.parquet"
    pq.write_table(pa.table({"torque_Nm": np.ones(200_000)}), path, compression="zstd")
    assert path.stat().st_size < 10_000
    found = opened(client, path.read_bytes(), "t.parquet").json()
    assert not found["ready"]
    assert "200,000 cells" in found["message"]


@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_columns_are_bounded(client: TestClient, tmp_path: Path, kind: str) -> None:
    """What each header means is found out one by one: thousands would hold up all else."""
    names = [f"Moment{i}" for i in range(6000)]
    file = tmp_path / f"wide.{kind}"
    if kind == "csv":
        file.write_text(f"{','.join(names)}\n", encoding="utf-8")
    else:
        with xlsxwriter.Workbook(file) as book:
            book.add_worksheet().write_row(0, 0, names)
    found = opened(client, file.read_bytes(), file.name).json()
    assert not found["ready"]
    assert "6,000 columns" in found["message"]


def test_a_name_is_no_option_of_the_command(client: TestClient) -> None:
    opened(client, (HEAD + ROWS).encode(), "--out=x.csv")
    assert " ./--out=x.csv " in client.get("/api/document").json()["command"]


def test_rows_and_bytes_are_bounded(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    many = opened(client, b"torque_Nm\n" + b"1\n" * 300_000)
    assert many.status_code == 400
    assert "rows" in many.json()["error"]
    monkeypatch.setattr(uploads, "MOST_ROWS", 5)
    found = opened(client, (HEAD + ROWS).encode()).json()
    assert not found["ready"]
    assert "7 rows" in found["message"]


def test_an_upload_is_bounded_while_it_streams(client: TestClient) -> None:
    sent = 0

    def endless() -> Iterator[bytes]:
        nonlocal sent
        while True:
            sent += 1 << 20
            yield b"1" * (1 << 20)
            if sent > 4 * uploads.MOST_BYTES:  # only were the bound not there
                return

    kind = {"content-type": "application/octet-stream"}
    found = client.post("/api/upload", params={"name": "t.csv"}, content=endless(), headers=kind)
    assert found.status_code == 413
    told = {**kind, "content-length": str(10**12)}
    assert client.post("/api/upload", content=b"1", headers=told).status_code == 413


# --- requests that are none of the page's -----------------------------------------------------


@pytest.mark.parametrize(
    "body",
    [
        b"", b"[]", b"null", b"{", b"[" * 100_000, b'{"effects": 3}', b'{"effects": [1]}',
        b'{"effects": null}', b'{"effects": ["' + b"x" * 5000 + b'"]}',
        b'{"effects": ["' + b'","'.join([b"a%d" % i for i in range(50)]) + b'"]}',
        b'{"effects": NaN}', b'{"effects": ["__class__"]}', b'{"effects": ["<script>"]}',
    ],
    ids=lambda body: repr(body[:14]),
)  # fmt: skip
def test_a_request_that_makes_no_sense_is_a_mistake_not_a_crash(
    diagnosed: tuple[Session, TestClient], body: bytes
) -> None:
    _, client = diagnosed
    headers = {"content-type": "application/json"}
    found = client.post("/api/model", content=body, headers=headers)
    assert found.status_code == 400
    assert found.json()["error"]


@pytest.mark.parametrize("torque", ["1" + 400 * "0", "1e999", '"1"', "true", "[1]"])
def test_a_load_that_is_no_number_is_a_mistake_not_a_crash(
    diagnosed: tuple[Session, TestClient], torque: str
) -> None:
    body = f'{{"load": {{"torque_Nm": {torque}}}}}'
    headers = {"content-type": "application/json"}
    found = diagnosed[1].post("/api/drive", content=body, headers=headers)
    assert found.status_code == 400
    assert "numbers by name" in found.json()["error"]


@pytest.mark.parametrize(
    "expression",
    [
        "__import__('os').system('true')", "a.__class__", "(" * 900, "a" * 5000, "1/0", "a; b",
        "lambda: 1", "a\u0000", "‮a", "exp(exp(exp(a * 1e3))) * torque_Nm",
    ],
)  # fmt: skip
def test_an_expression_is_read_by_the_grammar_and_never_run_as_code(
    diagnosed: tuple[Session, TestClient], expression: str
) -> None:
    _, client = diagnosed
    effect = {
        "id": "evil",
        "port": "series",
        "expression": expression,
        "parameters": [{"name": "a", "start": 1.0}],
    }
    assert client.post("/api/own/check", json=effect).status_code == 200
    assert client.post("/api/own/fit", json=effect).status_code == 400


@pytest.mark.parametrize(
    "change",
    [
        {"id": "<b>"}, {"id": 3}, {"id": "stated"}, {"port": "kernel"}, {"parameters": {"a": 1}},
        {"parameters": [{"name": "a", "start": "1"}]}, {"parameters": [{"name": "a"}] * 2},
        {"parameters": [{"name": "a", "start": 1e400}]}, {"expression": None}, {"parameters": []},
        {"parameters": [{"name": f"p{i}", "start": 1} for i in range(400)]},
    ],
)  # fmt: skip
def test_an_own_effect_out_of_form_is_refused(
    diagnosed: tuple[Session, TestClient], change: dict[str, Any]
) -> None:
    _, client = diagnosed
    body = json.dumps(own_effect({}, **change))
    headers = {"content-type": "application/json"}
    assert client.post("/api/own/fit", content=body, headers=headers).status_code == 400


def test_a_mistake_of_our_own_is_told_without_its_inside(
    client: TestClient, session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken() -> dict[str, Any]:
        raise ZeroDivisionError("secret")

    monkeypatch.setattr(session, "job", broken)
    found = client.get("/api/job")
    assert found.status_code == 500
    assert "secret" not in found.text


def test_a_table_that_takes_long_to_read_keeps_nobody_waiting(
    client: TestClient, session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert opened(client, (HEAD + ROWS).encode()).json()["ready"]
    begun, go_on = threading.Event(), threading.Event()
    read = uploads.Opened.read

    def slow(self: uploads.Opened) -> Any:
        begun.set()
        assert go_on.wait(PATIENCE_S)
        return read(self)

    monkeypatch.setattr(uploads.Opened, "read", slow)
    taking = threading.Thread(target=session.take, args=("t.csv", (HEAD + ROWS).encode()))
    taking.start()
    assert begun.wait(PATIENCE_S)
    asking = threading.Thread(target=session.document, daemon=True)
    asking.start()
    asking.join(PATIENCE_S)
    waits = asking.is_alive()
    go_on.set()
    taking.join(PATIENCE_S)
    assert not waits
