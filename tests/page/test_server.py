"""The workbench's server without a browser and without a network.

Groups: the story; columns to confirm; a diagnosis that is cancelled; the verb. Who may come in is
in test_page_guard, hostile files and requests in test_page_hostile.
"""

from __future__ import annotations

import http.client
import json
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import xlsxwriter
from starlette.testclient import TestClient

import cbpt
from cbpt.cli.main import main
from cbpt.errors import ReadingsError
from cbpt.page.document import campaign
from cbpt.page.document.source import from_here
from cbpt.page.workbench.session import Session
from common import PATIENCE_S
from common.page_server import CASE, DATA, HEAD, ROWS, client_of, opened, own_effect, upload

# --- the story ------------------------------------------------------------------------------


def test_case_and_table_are_opened_in_either_order_and_shown_before_any_diagnosis() -> None:
    files = [("dev04.toml", CASE.read_bytes()), ("dev04.csv", DATA.read_bytes())]
    for order in (files, files[::-1]):
        session = Session()
        client = client_of(session)
        first = upload(client, *order[0]).json()
        assert not first["ready"]
        assert first["message"]
        second = upload(client, *order[1]).json()
        assert second["ready"], second
        found = client.get("/api/document").json()
        assert found["answer"] is None
        assert found["data"] == found["data"] | {"name": "dev04.csv", "rows": 396}
        assert found["case"]["text"] == CASE.read_text(encoding="utf-8")
        assert len(found["models"]) == 1
        session.close()


def test_the_diagnosis_is_a_job_and_its_answer_is_that_of_the_command_line(
    diagnosed: tuple[Session, TestClient],
) -> None:
    _, client = diagnosed
    job = client.get("/api/job").json()
    assert job["state"] == "done", job
    found = client.get("/api/document").json()
    verdict = found["answer"]["verdict"]
    assert verdict["effects"] == ["friction_hysteresis"]
    assert found["answer_key"] == "friction_hysteresis"
    assert found["answer"]["source"] == DATA.name


def test_switching_an_effect_on_lets_the_error_fall(
    diagnosed: tuple[Session, TestClient],
) -> None:
    _, client = diagnosed
    whole = client.get("/api/document").json()
    stated = whole["models"][0]["rmse_arcsec"]
    found = client.post("/api/model", json={"effects": ["friction_hysteresis"]}).json()
    assert found["model"]["rmse_arcsec"] < 0.2 * stated
    assert len(found["curves"]) == len(whole["curves"])
    pair = ["friction_hysteresis", "sensor_gain"]
    both = client.post("/api/model", json={"effects": pair})
    assert both.status_code == 200
    assert both.json()["model"]["key"] == "+".join(sorted(pair))


def test_an_own_effect_is_checked_as_it_is_typed_fitted_and_exported(
    diagnosed: tuple[Session, TestClient],
) -> None:
    _, client = diagnosed
    effect: dict[str, Any] = {
        "id": "mine",
        "port": "series",
        "expression": "a * torque",
        "parameters": [
            {"name": "a", "unit": "rad/(N m)", "start": 1e-6, "min": -1e-3, "max": 1e-3}
        ],
    }
    told = client.post("/api/own/check", json=effect).json()
    assert (told["ok"], told["column"]) == (False, 5)
    assert "torque_Nm" in told["message"]
    assert client.post("/api/own/fit", json=effect).status_code == 400
    effect["expression"] = "a * torque_Nm * abs(torque_Nm)"
    effect["parameters"][0]["unit"] = ""
    assert client.post("/api/own/check", json=effect).json() == {
        "ok": True,
        "message": "",
        "column": None,
        "field": None,
        "notes": [],
    }
    # The page makes a parameter of every name that it does not know.
    for name in ("torqe_Nm", "Torque"):
        slip = {"name": name, "unit": "", "start": 1, "min": None, "max": None}
        misspelt = effect | {
            "expression": f"a * {name}",
            "parameters": [*effect["parameters"], slip],
        }
        told = client.post("/api/own/check", json=misspelt).json()
        said = f"`{name}` is treated as a parameter; did you mean the variable `torque_Nm`?"
        assert (told["ok"], told["notes"]) == (True, [said])
    for formula, why in (
        ("a * log(torque_Nm)", "no number at 216 of 396 readings, first at line 2 (torque 0 N m"),
        ("a * torque_Nm / (time_s - time_s)", "no number at 396 of 396"),
        ("a * 0 * torque_Nm", "choose other start values"),
    ):
        other = effect | {"expression": formula}
        told = client.post("/api/own/check", json=other).json()
        assert told["ok"] is False
        assert why in told["message"]
        fitted = client.post("/api/own/fit", json=other)
        assert fitted.status_code == 400
        assert why in fitted.json()["error"]
    bare = effect | {"expression": "torque_Nm", "parameters": []}
    assert "0 parameters" in client.post("/api/own/check", json=bare).json()["message"]
    found = client.post("/api/own/fit", json=effect).json()
    assert found["model"]["role"] == "own"
    both = client.post("/api/model", json={"effects": ["mine", "friction_hysteresis"]}).json()
    assert both["model"]["rmse_arcsec"] < found["model"]["rmse_arcsec"]
    text = client.get("/api/export/case", params={"effects": "mine,friction_hysteresis"}).text
    case = cbpt.Case.from_toml(text)
    assert {e.id for e in case.effects} >= {"mine", "friction_hysteresis"}
    command = client.get("/api/export/command", params={"effects": "mine"}).text
    assert command.startswith("cbpt compare dev04_case.toml ")


@pytest.mark.parametrize(
    ("change", "field", "said"),
    [
        ({"start": None}, "parameters.a.start", "start of a: missing; expected a finite number"),
        ({"min": "-1,5"}, "parameters.a.min", "minimum of a = \"-1,5\": expected a finite number, "
         "written with a decimal point"),
        ({"max": "1e999"}, "parameters.a.max", "maximum of a = \"1e999\": expected a finite"),
        ({"start": "0x1F"}, "parameters.a.start", "start of a = \"0x1F\": expected"),
        ({"min": 1, "max": -1}, "parameters.a", "a: min, start and max must be in this order"),
    ],
)  # fmt: skip
def test_a_number_of_an_own_effect_that_is_none_is_told_with_its_place(
    diagnosed: tuple[Session, TestClient], change: dict[str, Any], field: str, said: str
) -> None:
    _, client = diagnosed
    effect = own_effect({"unit": "", "min": None, "max": None} | change)
    told = client.post("/api/own/check", json=effect).json()
    assert (told["ok"], told["field"]) == (False, field)
    assert told["message"].startswith(said)
    refused = client.post("/api/own/fit", json=effect)
    assert refused.status_code == 400


@pytest.mark.parametrize("name", ["stated", "refitted", "unknown", "friction_hysteresis", "1st"])
def test_a_name_that_cannot_be_had_is_told_by_the_check(
    diagnosed: tuple[Session, TestClient], name: str
) -> None:
    _, client = diagnosed
    effect = {
        "id": name,
        "port": "series",
        "expression": "a * torque_Nm",
        "parameters": [{"name": "a", "start": 1e-6}],
    }
    told = client.post("/api/own/check", json=effect).json()
    assert (told["ok"], told["field"]) == (False, "id")
    assert name in told["message"]
    assert client.post("/api/own/fit", json=effect).status_code == 400


def test_what_is_exported_is_what_is_shown(diagnosed: tuple[Session, TestClient]) -> None:
    _, client = diagnosed
    whole = client.get("/api/document").json()
    assert client.get("/api/export/json").json() == whole
    effects = {"effects": "friction_hysteresis"}
    lines = client.get("/api/export/csv", params=effects).text.splitlines()
    assert len(lines) == 1 + whole["data"]["rows"]
    row = dict(zip(lines[0].split(","), lines[5].split(","), strict=True))
    model = next(m for m in whole["models"] if m["key"] == "friction_hysteresis")
    assert float(row["residual_arcsec"]) == model["residual_arcsec"][4]
    assert float(row["measured_arcsec"]) == whole["readings"]["measured_arcsec"][4]
    command = client.get("/api/export/command", params=effects).text
    assert command.split() == ["cbpt", "compare", "dev04_case.toml", from_here(str(DATA))]
    assert client.get("/api/export/pickle").status_code == 409


@pytest.mark.parametrize("effects", [["creep"], ["plate_tilt", "run_in"]])
def test_the_exported_case_is_the_model_on_the_page(
    diagnosed: tuple[Session, TestClient], effects: list[str]
) -> None:
    """The command of a model compares it: fitted anew, it may end elsewhere. The page weighs the
    zero by the noise of the model, far within its uncertainty (0.015 arcsec)."""
    _, client = diagnosed
    model = client.post("/api/model", json={"effects": effects}).json()["model"]
    text = client.get("/api/export/case", params={"effects": ",".join(effects)}).text
    found = cbpt.compare(cbpt.Case.from_toml(text), cbpt.read_readings(DATA))
    assert found.rmse_with_best_zero_arcsec == pytest.approx(model["rmse_arcsec"], rel=1e-4)
    assert found.best_common_zero_arcsec == pytest.approx(model["zero_arcsec"], abs=0.01)


def test_the_campaign_is_judged_once_when_it_is_asked_for(
    diagnosed: tuple[Session, TestClient], monkeypatch: pytest.MonkeyPatch
) -> None:
    _, client = diagnosed
    calls = []

    def judged(*given: Any) -> tuple[dict[str, Any], None]:
        calls.append(given)
        return {"pairs": []}, None

    monkeypatch.setattr(campaign, "campaign_isolability", judged)
    assert client.get("/api/document").json()["isolability"] is None
    found = client.get("/api/isolability").json()
    assert found == {"isolability": {"pairs": []}, "why": None}
    assert client.get("/api/isolability").json() == found
    assert len(calls) == 1
    whole = client.get("/api/document").json()
    assert whole["isolability"] == found["isolability"]
    assert "isolability" not in whole["reasons"]


def test_the_answer_does_not_wait_for_the_figures_of_loops(
    diagnosed: tuple[Session, TestClient],
) -> None:
    session, client = diagnosed
    assert client.get("/api/document").json()["table"] is None
    found = client.get("/api/table").json()
    assert found["checks"]
    width = next(f for f in found["loops"][0]["figures"] if f["name"] == "hysteresis_loss")
    assert width["model"] == 0 < width["after"]
    assert session.table() is session.table()
    assert client.get("/api/document").json()["table"] == found


def test_what_is_worked_out_meanwhile_lets_a_switch_go_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = Session.of_files(CASE, DATA)
    session.start()
    assert session.join(120)
    order: list[str] = []
    at_work, switching = threading.Event(), threading.Event()
    models = session._diagnosed()
    choice = models.choice
    assert session._ahead is not None
    assert session._ahead.join(60)

    def judged(d: Any, step: Any) -> tuple[dict[str, Any], None]:
        at_work.set()
        assert switching.wait(60)
        step("", 0.5)
        order.append("campaign")
        return {"pairs": []}, None

    def switched(effects: Any, step: Any) -> Any:
        switching.set()
        found = choice(["friction_hysteresis", "creep"])
        order.append("switch")
        return found

    monkeypatch.setattr(campaign, "campaign_isolability", judged)
    monkeypatch.setattr(models, "choice", switched)
    asked = threading.Thread(target=session.isolability)
    asked.start()
    assert at_work.wait(60)
    session.model(["creep"])
    asked.join(60)
    # What may be switched next goes first too.
    assert order.index("campaign") == len(order) - 1 > 0
    session.close()


def test_the_drive_is_redrawn(diagnosed: tuple[Session, TestClient]) -> None:
    _, client = diagnosed
    asked = {"load": {"torque_Nm": 4}, "design": {"deceleration.ball_radius_mm": 1.3}}
    found = client.post("/api/drive", json=asked).json()
    assert found["design"]["deceleration.ball_radius_mm"] == 1.3
    assert found["drawing"]["pairs"][0]["balls"][0]["radius"] == 1.3
    wrong = client.post("/api/drive", json={"design": {"deceleration.ball_radius_mm": 0}})
    assert wrong.status_code == 400
    assert "ball_radius_mm" in wrong.json()["error"]


def test_the_data_sheet_is_that_of_the_verb(diagnosed: tuple[Session, TestClient]) -> None:
    session, client = diagnosed
    found = client.post("/api/datasheet", json={}).json()["html"]
    document = client.get("/api/document").json()
    load, case = document["drive"]["load"], session._shown.case
    assert case is not None
    expected = cbpt.datasheet(
        case,
        title=document["case"]["name"],
        torque_Nm=load["torque_Nm"],
        preload_N=load["preload_N"],
    )
    assert found == expected


@pytest.mark.parametrize("route", ["model", "own/fit", "diagnose", "drive", "datasheet"])
def test_before_there_are_readings_the_page_is_told_so(client: TestClient, route: str) -> None:
    effect = {
        "id": "x",
        "port": "series",
        "expression": "a",
        "parameters": [{"name": "a", "start": 1}],
    }
    found = client.post(f"/api/{route}", json={"effects": []} | effect)
    assert found.status_code == 409
    assert "readings" in found.json()["error"]


# --- columns to confirm ---------------------------------------------------------------------

DOUBTFUL = "Moment,axial force [N],Twist (arcsec),note\n" + "".join(
    f"{t},600,{3.1 * t:.3f},ok\n" for t in (0, 1, 2, 3, 4, 5, 6)
)


def test_names_that_leave_doubt_are_asked_about_and_taken_as_told(client: TestClient) -> None:
    found = opened(client, DOUBTFUL.encode()).json()
    assert not found["ready"]
    assert found["doubt"]
    columns = {c["header"]: c for c in found["columns"]}
    assert columns["Moment"]["doubt"]
    assert "torque_Nm" in columns["Moment"]["candidates"]
    assert columns["Moment"]["sample"] == ["0", "1", "2"]
    assert columns["Twist (arcsec)"]["column"] == "elastic_angle_arcsec"
    assert client.get("/api/document").json() is None
    again = client.post("/api/columns", json={"columns": {"Moment": "torque [N m]"}}).json()
    assert again["ready"], again
    whole = client.get("/api/document").json()
    assert whole["readings"]["torque_Nm"] == [0, 1, 2, 3, 4, 5, 6]
    assert "--column 'Moment=torque [N m]'" in whole["command"]
    milli = client.post("/api/columns", json={"columns": {"Moment": "torque [mN m]"}}).json()
    assert milli["ready"]
    assert client.get("/api/document").json()["readings"]["torque_Nm"][1] == 0.001


def test_a_wrong_mapping_is_told_and_can_be_mended(client: TestClient) -> None:
    opened(client, DOUBTFUL.encode())
    wrong = client.post("/api/columns", json={"columns": {"note": "torque_Nm"}}).json()
    assert not wrong["ready"]
    assert wrong["message"]
    assert client.post("/api/columns", json={"columns": {"Moment": "torque_Nm"}}).json()["ready"]
    assert client.post("/api/columns", json={"columns": {"Moment": 3}}).status_code == 400
    assert client.post("/api/columns", json={"columns": ["Moment"]}).status_code == 400


def workbook(path: Path, *names: str) -> bytes:
    """Each sheet with the readings times its number, but `Notes` with none."""
    with xlsxwriter.Workbook(path) as book:
        for number, name in enumerate(names, 1):
            page = book.add_worksheet(name)
            rows = [row.split(",") for row in (HEAD + ROWS).splitlines()]
            if name == "Notes":
                rows = [["what", "who"], ["rig", "me"]]
            page.write_row(0, 0, rows[0])
            for k, row in enumerate(rows[1:], 1):
                page.write_row(k, 0, row if name == "Notes" else [number * float(v) for v in row])
    return path.read_bytes()


def test_of_several_sheets_with_readings_one_is_chosen(client: TestClient, tmp_path: Path) -> None:
    one = opened(client, workbook(tmp_path / "a.xlsx", "Notes", "Up"), "a.xlsx").json()
    assert one["ready"], one
    raw = workbook(tmp_path / "b.xlsx", "Up", "Notes", "Down")
    found = upload(client, "b.xlsx", raw).json()
    assert not found["ready"]
    assert found["sheets"] == ["Up", "Notes", "Down"]
    assert "several sheets" in found["message"]
    assert client.get("/api/document").json()["data"]["name"] == "a.xlsx"
    assert not client.post("/api/columns", json={"sheet": "Notes"}).json()["ready"]
    assert client.post("/api/columns", json={"sheet": "Down"}).json()["ready"]
    whole = client.get("/api/document").json()
    assert whole["readings"]["torque_Nm"][1] == 3
    assert "--sheet Down" in whole["command"]


# --- files that are refused -----------------------------------------------------------------


@pytest.fixture
def shown() -> Iterator[tuple[Session, TestClient]]:
    """dev04 opened, not diagnosed."""
    session = Session.of_files(CASE, DATA)
    yield session, client_of(session)
    session.close()


@pytest.mark.parametrize(
    ("name", "raw"),
    [
        ("t.csv", b"Moment,Twist\n1,2\n3,4\n"),
        ("t.csv", HEAD.encode()),
        ("t.xlsx", b"PK\x03\x04 no archive"),
        ("t.csv", b"torque_Nm\n" + b"1\n" * 300_000),
        ("case.toml", b"[deceleration]\nball_count = 1e9"),
    ],
    ids=["in doubt", "empty", "broken", "too long", "no case"],
)
def test_what_is_shown_stays_where_other_files_are_refused(
    shown: tuple[Session, TestClient], name: str, raw: bytes
) -> None:
    _, client = shown
    client.post("/api/diagnose", json={})
    before = client.get("/api/document").json()
    told = upload(client, name, raw).json()
    assert told.get("message") or told.get("error")
    assert not told.get("ready")
    assert client.get("/api/document").json()["data"] == before["data"]
    # The diagnosis goes on as well.
    assert client.get("/api/job").json()["state"] in ("running", "done")
    client.post("/api/cancel", json={})


def test_files_handed_over_together_are_shown_together_or_not_at_all(
    shown: tuple[Session, TestClient],
) -> None:
    _, client = shown
    other = "# another\n" + CASE.read_text(encoding="utf-8")
    kind = {"content-type": "application/octet-stream"}
    asked = {"name": "other.toml", "more": "1"}

    def case_shown() -> str:
        return str(client.get("/api/document").json()["case"]["name"])

    client.post("/api/upload", params=asked, content=other.encode(), headers=kind)
    assert case_shown() == "dev04.toml"
    assert not upload(client, "t.csv", HEAD.encode()).json()["ready"]
    assert case_shown() == "dev04.toml"
    # They wait for a table that can be read, unless the dialog is closed.
    assert upload(client, "t.csv", (HEAD + ROWS).encode()).json()["ready"]
    assert case_shown() == "other.toml"
    client.post("/api/upload", params={**asked, "name": "third.toml"}, content=other.encode(),
                headers=kind)  # fmt: skip
    client.post("/api/forget", json={})
    assert upload(client, "u.csv", (HEAD + ROWS).encode()).json()["ready"]
    assert case_shown() == "other.toml"


# --- a diagnosis that is cancelled ----------------------------------------------------------


def test_a_diagnosis_is_cancelled_and_another_may_follow() -> None:
    session = Session.of_files(CASE, DATA)
    client = client_of(session)
    client.post("/api/diagnose", json={})
    # Who asks again joins it; another seed would be another one.
    second = client.post("/api/diagnose", json={})
    assert (second.status_code, second.json()["state"]) == (200, "running")
    other = client.post("/api/diagnose", json={"seed": 1})
    assert other.status_code == 409
    assert "under way" in other.json()["error"]
    client.post("/api/cancel", json={})
    assert session.join(60)
    assert client.get("/api/job").json()["state"] == "cancelled"
    assert client.get("/api/document").json()["answer"] is None
    assert client.post("/api/diagnose", json={}).status_code == 200
    # Other files end it as well, and what it finds is not shown beside them.
    found = upload(client, "other.csv", (HEAD + ROWS).encode()).json()
    assert found["ready"], found
    session.close()
    assert client.get("/api/job").json()["state"] == "idle"
    assert client.get("/api/document").json()["data"]["name"] == "other.csv"


def test_a_diagnosis_that_fails_says_why(client: TestClient, session: Session) -> None:
    one_torque = HEAD + "".join(f"1,{i},1,600,{3 + i % 2},0.3\n" for i in range(8))
    assert opened(client, one_torque.encode()).json()["ready"]
    client.post("/api/diagnose", json={})
    assert session.join(60)
    job = client.get("/api/job").json()
    assert job["state"] == "failed"
    assert "a column that varies" in job["error"]


def test_a_table_too_short_for_a_diagnosis_is_refused_at_once(
    client: TestClient, tmp_path: Path
) -> None:
    few = HEAD + "1,0,1,600,3,0.3\n"
    found = opened(client, few.encode()).json()
    assert not found["ready"]
    assert "found 1 readings, expected at least 6" in found["message"]
    assert client.get("/api/document").json() is None
    table = tmp_path / "one.csv"
    table.write_text(few, encoding="utf-8")
    with pytest.raises(ReadingsError, match="at least 6"):
        Session.of_files(CASE, table)


# --- the verb -------------------------------------------------------------------------------


def test_workbench_serves_on_this_machine_and_ends_with_ctrl_c() -> None:
    command = [sys.executable, "-m", "cbpt.cli.main", "workbench", str(CASE), str(DATA)]
    run = subprocess.Popen(
        [*command, "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert run.stdout is not None
        found = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=(\S{43})", run.stdout.readline())
        assert found is not None
        port, token = int(found[1]), found[2]
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
        connection.request("GET", "/api/document", headers={"x-cbpt-token": token})
        document = json.loads(connection.getresponse().read())
        assert document["data"]["rows"] == 396
        connection.request("GET", "/api/document")
        assert connection.getresponse().status == 403
        connection.close()
        run.send_signal(signal.SIGINT)
        out, err = run.communicate(timeout=PATIENCE_S)
    finally:
        run.kill()
        run.wait()
    assert run.returncode == 0, err
    assert "has ended" in out
    assert err == ""


def test_ctrl_c_ends_with_one_line_though_work_is_under_way() -> None:
    command = [sys.executable, "-m", "cbpt.cli.main", "workbench", str(CASE), str(DATA)]
    run = subprocess.Popen(
        [*command, "--no-browser"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )

    def ask(path: str, body: str | None = None) -> http.client.HTTPConnection:
        found = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
        headers = {"x-cbpt-token": token, "content-type": "application/json"}
        found.request("GET" if body is None else "POST", path, body, headers)
        return found

    def state() -> str:
        with closing(ask("/api/job")) as asked:
            return str(json.loads(asked.getresponse().read())["state"])

    try:
        assert run.stdout is not None
        told = re.search(r":(\d+)/\?token=(\S{43})", run.stdout.readline())
        assert told is not None
        port, token = int(told[1]), told[2]
        with closing(ask("/api/diagnose", "{}")) as begun:
            assert begun.getresponse().status == 200
        while state() != "done":
            time.sleep(0.05)
        with closing(ask("/api/isolability")):
            assert state() == "done"
            run.send_signal(signal.SIGINT)
            out, err = run.communicate(timeout=PATIENCE_S)
    finally:
        run.kill()
        run.wait()
    assert (run.returncode, err) == (0, "")
    assert out.splitlines()[-1] == "The workbench has ended."


def test_workbench_refuses_half_of_its_files(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["workbench", str(CASE), "--no-browser"]) == 2
    assert "both CASE and DATA" in capsys.readouterr().err
    assert main(["workbench", str(CASE), "none.csv", "--no-browser"]) == 2
    assert main(["workbench", "--port", "70000"]) == 2


def test_readings_are_left_out_and_taken_again() -> None:
    session = Session.of_files(CASE, DATA)
    client = client_of(session)
    whole = client.get("/api/document").json()
    n = whole["data"]["rows"]
    assert client.post("/api/leave_out", json={"rows": [0, 2]}).status_code == 200
    rest = client.get("/api/document").json()
    assert rest["opened"] != whole["opened"]
    assert (rest["data"]["rows"], rest["data"]["left_out"]) == (n - 2, 2)
    assert rest["readings"]["row"] == [whole["readings"]["row"][1], *whole["readings"]["row"][3:]]
    # Those shown are counted on; nothing disappears silently.
    client.post("/api/leave_out", json={"rows": [0, 4]})
    third = client.get("/api/document").json()
    assert third["data"]["left_out"] == 4
    assert f"4 of {n} readings are left out by hand: line 2-4, 8" in third["data"]["notes"]
    for wrong in ([n], list(range(n - 3)), ["1"], None):
        assert client.post("/api/leave_out", json={"rows": wrong}).status_code == 400
    client.post("/api/leave_out", json={"rows": []})
    again = client.get("/api/document").json()
    assert again["readings"] == whole["readings"]
    session.close()
