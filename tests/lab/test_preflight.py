"""A table before any model: what each check finds, and what it cannot show."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

import cbpt
from cbpt.cli import main as commands

SPRING = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}}
LOOP = np.round(
    np.concatenate([np.arange(0, 10, 0.25), np.arange(10, -10, -0.25), np.arange(-10, 10.1, 0.25)]),
    9,
)
RUNS = 3
TABLE: dict[str, ArrayLike] = {
    "run": np.repeat(np.arange(RUNS), len(LOOP)),
    "time_s": np.tile(np.arange(len(LOOP)) * 1.0, RUNS) + np.repeat([0, 1e4, 2e4], len(LOOP)),
    "torque_Nm": np.tile(LOOP, RUNS),
    "elastic_angle_arcsec": np.tile(60 * LOOP, RUNS)
    + np.random.default_rng(1).normal(0, 0.5, RUNS * len(LOOP)),
    "u_elastic_angle_arcsec": np.full(RUNS * len(LOOP), 0.5),
}


def states(**changed: ArrayLike) -> dict[str, str]:
    found = cbpt.preflight(SPRING, TABLE | changed)
    return {check.subject: check.state for check in found.checks}


def test_a_good_table_is_called_good() -> None:
    found = states()
    lost = {"preload", "input angle"}  # which a table of one loop cannot have
    assert {name for name, state in found.items() if state != "good"} == lost


def column(name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array(TABLE[name], dtype=np.float64)


@pytest.mark.parametrize(
    ("subject", "name", "change"),
    [
        ("units", "elastic_angle_arcsec", lambda a: a * 3600 / 60),
        ("sides", "torque_Nm", lambda t: np.abs(t)),
        ("repeats", "u_elastic_angle_arcsec", lambda u: 4 * u),
        ("display of the angle", "elastic_angle_arcsec", lambda a: np.round(a / 30) * 30),
        ("noise of the torque", "torque_Nm", lambda t: t + 0.4 * np.sin(1e3 * np.arange(len(t)))),
        ("rates", "time_s", lambda t: np.where(t > 1e4, 1e4 + 3 * (t - 1e4), t)),
        (
            "zeros of runs",
            "elastic_angle_arcsec",
            lambda a: a + np.repeat([0.0, 20.0, 50.0], len(LOOP)),
        ),
        ("loops", "elastic_angle_arcsec", lambda a: a + 0.1 * np.arange(len(a))),
    ],
)
def test_each_check_sees_its_fault(subject: str, name: str, change: object) -> None:
    assert callable(change)
    assert states()[subject] == "good"
    assert states(**{name: change(column(name))})[subject] != "good"


def test_the_step_of_the_torque_is_told_whole() -> None:
    """Where it is wider than the torques that are looked at."""
    coarse = np.isclose(np.mod(column("torque_Nm"), 1.0), 0.0)
    found = cbpt.preflight(SPRING, {name: np.asarray(v)[coarse] for name, v in TABLE.items()})
    steps = next(check for check in found.checks if check.subject == "steps of the torque")
    assert steps.state == "look" and "steps of 1 N m" in steps.finding


def test_remedies_stand_beside_what_is_not_good() -> None:
    for check in cbpt.preflight(SPRING, TABLE).checks:
        assert bool(check.remedy) == (check.state != "good"), check


def test_what_the_table_cannot_show_is_named() -> None:
    blind = {e for b in cbpt.preflight(SPRING, TABLE).cannot_tell for e in b.effects}
    assert "friction_hysteresis" not in blind and "drift" not in blind
    less = {name: values for name, values in TABLE.items() if name != "time_s"}
    blind = {e for b in cbpt.preflight(SPRING, less).cannot_tell for e in b.effects}
    assert {"drift", "creep"} <= blind
    # A torsion spring has no balls.
    assert "ball_diameter_lot" not in blind
    without = {e for b in cbpt.preflight(None, TABLE).cannot_tell for e in b.effects}
    assert "ball_diameter_lot" in without


def test_the_verb_takes_a_case_or_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, case = tmp_path / "t.csv", tmp_path / "case.toml"
    rows = zip(*(np.asarray(values).tolist() for values in TABLE.values()), strict=True)
    lines = [",".join(TABLE), *(",".join(map(str, row)) for row in rows)]
    table.write_text("\n".join(lines))
    case.write_text(cbpt.Case.from_dict(SPRING).to_toml())
    assert commands.main(["preflight", str(table)]) == 0
    assert "cannot show" in capsys.readouterr().out
    assert commands.main(["preflight", str(case), str(table), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {"checks", "cannot_tell", "readings", "runs"} <= document.keys()
    assert document["runs"] == RUNS
    assert commands.main(["preflight", str(case)]) == 2
