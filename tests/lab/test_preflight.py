"""A table before any model: what each check finds, and what it cannot show."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

import cbpt
from cbpt.cli import main as commands
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.units import input_side
from common.comparisons import columns_of, drive_of

SPRING = {"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0}}
LOOP = np.round(
    np.concatenate([np.arange(0, 10, 0.25), np.arange(10, -10, -0.25), np.arange(-10, 10.1, 0.25)]),
    9,
)
RUNS = 3
EXAMPLES = Path(__file__).parents[2] / "examples"
TABLE: dict[str, ArrayLike] = {
    "run": np.repeat(np.arange(RUNS), len(LOOP)),
    "time_s": np.tile(np.arange(len(LOOP)) * 1.0, RUNS) + np.repeat([0, 1e4, 2e4], len(LOOP)),
    "torque_Nm": np.tile(LOOP, RUNS),
    "elastic_angle_arcsec": np.tile(60 * LOOP, RUNS)
    + np.random.default_rng(1).normal(0, 0.5, RUNS * len(LOOP)),
    "u_elastic_angle_arcsec": np.full(RUNS * len(LOOP), 0.5),
}


def column(name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array(TABLE[name], dtype=np.float64)


def states(**changed: ArrayLike) -> dict[str, str]:
    found = cbpt.preflight(SPRING, TABLE | changed)
    return {check.subject: check.state for check in found.checks}


def units_of(found: cbpt.Preflight) -> Check:
    return next(check for check in found.checks if check.subject == "units")


def test_a_good_table_is_called_good() -> None:
    found = states()
    assert not {name for name, state in found.items() if state != "good"}


@pytest.mark.parametrize(
    ("subject", "name", "change"),
    [
        ("units", "elastic_angle_arcsec", lambda a: a * 3600 / 60),
        ("sides", "torque_Nm", lambda t: np.abs(t)),
        ("repeats", "u_elastic_angle_arcsec", lambda u: 4 * u),
        ("display of the angle", "elastic_angle_arcsec", lambda a: np.round(a / 30) * 30),
        (
            "noise of the torque",
            "torque_Nm",
            lambda t: t + np.random.default_rng(3).normal(0, 0.4, len(t)),
        ),
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


RATED = SPRING | {"rating": {"rated_torque_Nm": 10}}
SECOND = np.repeat([False, True, False], len(LOOP))


@pytest.mark.parametrize(
    ("name", "change", "subject", "said"),
    [
        ("torque_Nm", lambda t: 1e3 * t, "units", "N mm, not in N m"),
        ("torque_Nm", lambda t: t / 40, "units", "transmission ratio of about 40"),
        ("elastic_angle_arcsec", lambda a: a / 60, "units", "arcmin, not in arcsec"),
        ("elastic_angle_arcsec", lambda a: a * np.pi / 648000, "units", "rad, not in arcsec"),
        ("elastic_angle_arcsec", lambda a: -a, "sign of the angle", "reversed"),
        (
            "elastic_angle_arcsec",
            lambda a: np.where(SECOND, -a, a),
            "sign of the angle",
            "falls as the torque grows in run 1, and not",
        ),
        (
            "torque_Nm",
            lambda t: np.where(SECOND, 1e3 * t, t),
            "units of the runs",
            "torques of run 1 reach 1000 times",
        ),
        (
            "elastic_angle_arcsec",
            lambda a: np.where(SECOND, 60 * a, a),
            "units of the runs",
            "angles of run 1 reach",
        ),
    ],
)
def test_a_slip_of_a_unit_or_a_sign_is_asked_about(
    name: str, change: object, subject: str, said: str
) -> None:
    assert callable(change)
    found = cbpt.preflight(RATED, TABLE | {name: change(column(name))})
    check = next(check for check in found.checks if check.subject == subject)
    assert check.state == "look" and said in f"{check.finding} {check.remedy}"
    assert "?" in check.remedy


def test_a_header_in_kilonewton_metres_over_newton_metres_is_asked_about() -> None:
    """N mm alone were asked about, though the header has kN m."""
    table = {name: values for name, values in TABLE.items() if name != "torque_Nm"}
    slipped = cbpt.preflight(SPRING, table | {"torque_kNm": column("torque_Nm")})
    assert "in N m, not in kN m" in units_of(slipped).remedy
    right = cbpt.preflight(SPRING, table | {"torque_kNm": column("torque_Nm") / 1e3})
    assert units_of(right).state == "good"


@pytest.mark.parametrize("factor", [0.3, 1.0, 3.0])
def test_a_drive_that_differs_from_its_model_is_no_slip(factor: float) -> None:
    turned = column("elastic_angle_arcsec") * factor
    found = cbpt.preflight(RATED, TABLE | {"elastic_angle_arcsec": turned})
    known = {check.subject: check.state for check in found.checks}
    assert {known[name] for name in ("units", "sign of the angle", "units of the runs")} == {"good"}


@pytest.mark.parametrize(
    ("column", "factor", "said"),
    [
        ("preload_N", 1e-3, "preloads in kN"),
        ("torque_Nm", 1 / 10.5, "torques those of the input side"),
        ("torque_Nm", 1.0, ""),
    ],
)
def test_units_of_a_ball_drive_are_those_of_its_case(column: str, factor: float, said: str) -> None:
    readings = cbpt.read_readings(EXAMPLES / "campaign.csv")
    table: dict[str, ArrayLike] = {
        name: getattr(readings, name)
        for name in ("run", "time_s", "torque_Nm", "preload_N", "elastic_angle_arcsec")
    }
    table[column] = factor * np.asarray(table[column])
    units = units_of(cbpt.preflight(EXAMPLES / "campaign.toml", table))
    assert units.state == ("look" if said else "good")
    assert said in units.remedy


def test_nothing_is_named_where_torques_look_like_those_of_the_input_side() -> None:
    """As effects they were a contact angle 29 deg off and a lost preload, for certain."""
    drive = drive_of("dev05")
    table = columns_of("dev05")
    other = table | {"torque_Nm": table["torque_Nm"] / drive.transmission_ratio}
    found = cbpt.diagnose(drive, other)
    assert found.verdict.undecided == "input side" and not found.verdict.effects
    assert "torque that of the input side?" in found.sentence
    assert not any(
        input_side(cbpt.read_readings(columns_of(name)), drive_of(name))
        for name in ("dev01", "dev05", "dev10", "dev12")
    )


def test_a_ball_drive_without_a_preload_is_looked_at() -> None:
    found = cbpt.preflight(EXAMPLES / "campaign.toml", TABLE)
    preload = next(check for check in found.checks if check.subject == "preload")
    assert preload.state == "lost" and "preload_N under [load]" in preload.remedy


def check_of(subject: str, **changed: ArrayLike) -> Check:
    found = cbpt.preflight(SPRING, TABLE | changed)
    return next(check for check in found.checks if check.subject == subject)


@pytest.mark.parametrize(
    "apart",
    [
        {"preload_N": [400.0, 600.0, 900.0]},
        {"input_angle_deg": [0.0, 40.0, 90.0]},
        {"state": ["new", "run in", "worn"]},
    ],
)
@pytest.mark.parametrize("jitter_Nm", [0.0, 0.02])
def test_what_differs_in_its_conditions_was_not_repeated(
    apart: dict[str, list[float | str]], jitter_Nm: float
) -> None:
    torque = column("torque_Nm") + jitter_Nm * np.sin(1e3 * np.arange(RUNS * len(LOOP)))
    changed: dict[str, ArrayLike] = {
        name: np.repeat(values, len(LOOP)) for name, values in apart.items()
    }
    assert check_of("repeats", torque_Nm=torque).state == "good"
    assert check_of("repeats", torque_Nm=torque, **changed).state == "lost"


@pytest.mark.parametrize("jitter_Nm", [0.0, 0.02])
def test_a_column_of_numbers_that_runs_share_is_told(jitter_Nm: float) -> None:
    """It may count repeats or states: nobody can tell."""
    torque = column("torque_Nm") + jitter_Nm * np.sin(1e3 * np.arange(RUNS * len(LOOP)))
    state = np.repeat([1.0, 1.0, 2.0], len(LOOP))
    words = check_of("repeats", torque_Nm=torque, state=state).finding
    assert "whatever 'state' is" in words and "--only" in words
    counted = np.repeat(np.arange(float(RUNS)), len(LOOP))
    assert "whatever" not in check_of("repeats", torque_Nm=torque, number=counted).finding


@pytest.mark.parametrize("column", [{}, {"preload_N": np.full(RUNS * len(LOOP), 400.0)}])
def test_a_spring_is_asked_for_no_preload(column: dict[str, ArrayLike]) -> None:
    """Its model has none."""
    found = cbpt.preflight(SPRING, TABLE | column)
    assert not any("preload" in check.remedy for check in found.checks)
    assert "preload_N column" not in found.report()
    drive = next(c for c in cbpt.preflight(None, TABLE | column).checks if c.subject == "preload")
    assert drive.state == "lost" and "Repeat the torques at" in drive.remedy


def test_steps_of_the_preload_are_no_forces() -> None:
    step = np.repeat([1.0, 2.0, 3.0], len(LOOP))
    assert check_of("preload", preload_step=step).finding == "3 preload steps, no force in newtons"
    force = np.repeat([400.0, 600.0, 900.0], len(LOOP))
    assert check_of("preload", preload_N=force).finding == "3 preloads, 400 to 900 N"


def test_a_display_that_is_coarse_beside_the_loop_is_told() -> None:
    """And hides how far repeats differ."""
    rising = np.diff(LOOP, prepend=-1.0) > 0
    loop = np.tile(59 * LOOP + np.where(rising, -45.0, 45.0), RUNS)
    shown = np.round(loop / 60) * 60
    less = {name: values for name, values in TABLE.items() if name[0] != "u"}
    for angle in (shown, np.round(loop)):
        found = cbpt.preflight(SPRING, less | {"elastic_angle_arcsec": angle})
        known = {check.subject: check for check in found.checks}
        assert known["display of the angle"].state == "look"
        assert known["repeats"].state == "look" and "hides" in known["repeats"].finding


def command_of(limit_Nm: float) -> dict[str, ArrayLike]:
    """The drive comes to a limit of the torque; its command does not."""
    held = np.clip(column("torque_Nm"), -limit_Nm, limit_Nm)
    noise = np.random.default_rng(2).normal(0, 0.02, (2, len(held)))
    return {
        "torque_Nm": held + noise[0],
        "elastic_angle_arcsec": 60 * held + 10 * noise[1],
        "target": column("torque_Nm"),
    }


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (command_of(20.0), ""),
        (command_of(7.0), "N m while 'target' goes on to 10 and back"),
        ({"torque_Nm": np.clip(column("torque_Nm"), -7, 7)}, "torque stays at 7 N m while the ang"),
        (
            {"elastic_angle_arcsec": np.clip(column("elastic_angle_arcsec"), -400, 400)},
            "the angle stays while the torque goes on to 10 N m",
        ),
        (
            {
                "torque_Nm": np.clip(column("torque_Nm"), -7, 7),
                "elastic_angle_arcsec": np.clip(column("elastic_angle_arcsec"), -400, 400),
            },
            "torque and angle stay the same to the last digit",
        ),
    ],
)
def test_a_column_that_is_cut_at_its_end_is_told(changed: dict[str, ArrayLike], said: str) -> None:
    check = check_of("ends of the ranges", **changed)
    assert check.state == ("look" if said else "good") and said in check.finding


def test_a_command_that_a_limit_cuts_is_no_remedy_for_a_noisy_torque() -> None:
    for limit_Nm, offered in ((10.0, True), (5.0, False)):
        table = _noisier(command_of(limit_Nm), 0.022 * limit_Nm)
        noise = check_of("noise of the torque", **table)
        assert noise.state == "look" and ("'target'" in noise.remedy) == offered


def _noisier(table: dict[str, ArrayLike], scatter_Nm: float) -> dict[str, ArrayLike]:
    noise = np.random.default_rng(3).normal(0, scatter_Nm, RUNS * len(LOOP))
    return table | {"torque_Nm": np.asarray(table["torque_Nm"]) + noise}


def test_a_torque_that_is_held_while_the_angle_creeps_is_not_cut() -> None:
    top = np.flatnonzero(LOOP == 10.0)[0]
    hold = np.r_[LOOP[:top], np.full(10, 10.0), LOOP[top:]]
    creep = np.r_[np.zeros(top), np.linspace(0, 60, 10), np.full(len(LOOP) - top, 60.0)]
    noise = np.random.default_rng(4).normal(0, 0.5, RUNS * len(hold))
    table: dict[str, ArrayLike] = {
        "run": np.repeat(np.arange(RUNS), len(hold)),
        "torque_Nm": np.tile(hold, RUNS),
        "elastic_angle_arcsec": np.tile(60 * hold + creep, RUNS) + noise,
    }
    found = cbpt.preflight(SPRING, table)
    ends = next(check for check in found.checks if check.subject == "ends of the ranges")
    assert ends.state == "good"


def test_the_step_of_the_torque_is_told_whole() -> None:
    """Where it is wider than the torques that are looked at."""
    coarse = np.isclose(np.mod(column("torque_Nm"), 1.0), 0.0)
    found = cbpt.preflight(SPRING, {name: np.asarray(v)[coarse] for name, v in TABLE.items()})
    steps = next(check for check in found.checks if check.subject == "steps of the torque")
    assert "steps of 1 N m" in steps.finding


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
