"""What changed, asked of the workbench: a second table against the one shown."""

from __future__ import annotations

from typing import Any

import numpy as np
from starlette.testclient import TestClient

import cbpt
from common.page_server import upload

SPRING = """\
[torsion_spring]
torsional_stiffness_Nm_per_arcmin = 1.0
[uncertainty]
contact_stiffness_rel = 0.2
"""
WAY = np.concatenate([np.arange(0, 10, 1), np.arange(10, -10, -1), np.arange(-10, 1, 1)])


def table(friction_Nm: float, seed: int, way: np.ndarray = WAY) -> bytes:
    """Runs of a spring with friction."""
    torque = np.tile(way, 2)
    run = np.repeat([1, 2], len(way))
    effect = f"friction_torque_Nm = {friction_Nm}\nengagement_angle_arcsec = 30\n"
    case = cbpt.Case.from_toml(f'{SPRING}[[effect]]\nid = "friction_hysteresis"\n{effect}')
    plan = {"run": run, "torque_Nm": torque, "elastic_angle_arcsec": 0.0 * torque}
    rows = cbpt.read_readings(plan, need_preload=False)
    made = cbpt.simulate(case, rows, seed=seed, u_elastic_angle_arcsec=2.0)
    head = "run,time_s,torque_Nm,elastic_angle_arcsec,u_elastic_angle_arcsec"
    lines = zip(run, torque, made.elastic_angle_arcsec, strict=True)
    rows_text = (f"{r},{i},{t},{a:.3f},2" for i, (r, t, a) in enumerate(lines))
    return "\n".join([head, *rows_text]).encode()


def asked(client: TestClient, raw: bytes) -> dict[str, Any]:
    answer = client.post(
        "/api/change",
        params={"name": "after.csv"},
        content=raw,
        headers={"content-type": "application/octet-stream"},
    )
    return {"status": answer.status_code, **answer.json()}


def test_a_second_table_is_told_against_the_one_shown(client: TestClient) -> None:
    assert asked(client, table(1.0, 1))["status"] == 409
    upload(client, "case.toml", SPRING.encode())
    assert upload(client, "before.csv", table(1.0, 1)).json()["ready"]
    found = asked(client, table(2.0, 2))
    assert found["kind"] == "changed"
    [row] = found["changed"]
    assert row["effect"] == "friction_hysteresis" and row["direction"] == "up"
    assert found["headline"].startswith("friction_hysteresis rose") and found["rest"]
    [loops] = found["loops"]
    assert loops["amplitude_Nm"] == 10 and loops["width_arcsec"][0] < loops["width_arcsec"][1]
    assert [level["name"] for level in found["levels"]] == ["before.csv", "after.csv"]
    assert len(found["levels"][1]["torque_Nm"]) == 2 * len(WAY)
    # What is shown stays, and a table that cannot be read is told as in an upload.
    document = client.get("/api/document").json()
    assert document["data"]["name"] == "before.csv"
    refused = asked(client, b"a,b\n1,2\n")
    assert refused["status"] == 400 and "after.csv" in str(refused["error"])


def test_what_a_table_does_not_show_is_told_with_its_name(client: TestClient) -> None:
    upload(client, "case.toml", SPRING.encode())
    assert upload(client, "before.csv", table(1.0, 1)).json()["ready"]
    found = asked(client, table(1.0, 2, WAY[3:7]))  # the torque never turns over
    assert found["kind"] == "undecided"
    [row] = found["open"]
    assert row["effect"] == "friction_hysteresis"
    assert row["why"] == "after.csv does not show it"
    assert found["loops"] == []
