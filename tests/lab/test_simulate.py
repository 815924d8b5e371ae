"""Simulated readings: the model with the case's effects, and an instrument that does as it says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt import InvalidInputError, NoSolutionError, PlanError, read_plan, read_readings, simulate
from cbpt.cli import main as commands
from cbpt.lab.covariance.linear_gaussian import Rows
from cbpt.lab.experiment.simulate import NOISES, Instrument

TOP = Path(__file__).parents[2]
CASE, PLAN = TOP / "examples" / "campaign.toml", TOP / "examples" / "plan.toml"
BEARING = [("eccentric_bearing", {"reference_deflection_um": 0.5})]


# --- the angle ----------------------------------------------------------------------------


def test_without_noise_the_readings_are_the_model() -> None:
    readings = simulate(CASE, PLAN, noise="none")
    assert cbpt.compare(CASE, readings).rmse_with_best_zero_arcsec == pytest.approx(0, abs=1e-12)


def test_effects_of_the_case_act_as_those_that_are_added() -> None:
    case = cbpt.Case.from_file(CASE).with_effects(BEARING)
    own = simulate(case, PLAN, seed=3)
    added = simulate(CASE, PLAN, effects=BEARING, seed=3)
    assert own.elastic_angle_arcsec.tolist() == added.elastic_angle_arcsec.tolist()
    plain = simulate(CASE, PLAN, seed=3)
    assert np.abs(own.elastic_angle_arcsec - plain.elastic_angle_arcsec).max() > 1
    with pytest.raises(InvalidInputError, match="the case has it already"):
        simulate(case, PLAN, effects=BEARING)


def test_rows_without_a_solution_are_named_and_no_number_is_made_up() -> None:
    loads = {"torque_Nm": [1.0, 900.0], "preload_N": [500.0, 500.0]}
    with pytest.raises(NoSolutionError, match=r"1 of 2 rows \(row 2\).*900 N m at a preload"):
        simulate(CASE, loads, u_elastic_angle_arcsec=0.1)


def test_the_remedy_is_that_of_the_status(tmp_path: Path) -> None:
    text = CASE.read_text()
    undercut = tmp_path / "undercut.toml"
    undercut.write_text(
        text.replace("short_amplitude_coefficient = 0.5", "short_amplitude_coefficient = 0.9")
    )
    assert cbpt.Case.from_file(undercut).drive.solve(1, 500).status == "undercut"
    loads = {"torque_Nm": [1.0], "preload_N": [500.0]}
    with pytest.raises(NoSolutionError) as told:
        simulate(undercut, loads, u_elastic_angle_arcsec=0.1)
    assert "ball radius" in str(told.value) and "torque or" not in str(told.value)


# --- the instrument -----------------------------------------------------------------------

N, RUNS = 40_000, 400
ROWS = Rows.of(np.repeat(np.arange(RUNS), N // RUNS))


def noise_of(*kinds: str) -> np.ndarray:
    rng = np.random.default_rng(7)
    return Instrument.of(kinds).readings(np.zeros(N), np.full(N, 0.5), ROWS, rng) / 0.5


def kurtosis(values: np.ndarray) -> float:
    return float(np.mean(values**4) / np.mean(values**2) ** 2)


def test_every_kind_of_noise_is_what_it_says() -> None:
    white = noise_of("white")
    assert white.std() == pytest.approx(1, rel=0.02) and kurtosis(white) == pytest.approx(3, 0.05)
    assert not noise_of("none").any()
    correlated = noise_of("correlated=0.7").reshape(RUNS, -1)
    assert correlated.std() == pytest.approx(1, rel=0.03)
    neighbours = np.mean(correlated[:, 1:] * correlated[:, :-1])
    assert neighbours == pytest.approx(0.7, abs=0.03)
    means = noise_of("run_offset=2").reshape(RUNS, -1).mean(axis=1)
    assert means.std() == pytest.approx(2, rel=0.1)
    tails = noise_of("heavy_tailed=5")
    assert tails.std() == pytest.approx(1, rel=0.05) and kurtosis(tails) > 4
    assert np.mean(np.abs(noise_of("outliers=0.1")) > 5) == pytest.approx(0.1, rel=0.1)
    assert noise_of("misstated=0.7").std() == pytest.approx(0.7, rel=0.02)
    # Rounding is part of u only where the angle passes many steps.
    angle = np.linspace(0, 400, N)
    rng = np.random.default_rng(8)
    steps = Instrument.of("quantised=3").readings(angle, np.full(N, 0.5), ROWS, rng)
    assert set(np.unique(np.round(steps / 1.5, 9) % 1)) == {0.0}
    assert (steps - angle).std() == pytest.approx(0.5, rel=0.05)


def test_kinds_add_up_and_a_seed_is_a_scatter() -> None:
    both = noise_of("run_offset=2", "misstated=0.5").reshape(RUNS, -1)
    assert both.mean(axis=1).std() == pytest.approx(2, rel=0.1)
    assert (both - both.mean(axis=1, keepdims=True)).std() == pytest.approx(0.5, rel=0.03)
    np.testing.assert_allclose(noise_of("misstated=2"), 2 * noise_of("white"))


@pytest.mark.parametrize(
    ("noise", "told"),
    [
        ("pink", "found 'pink', expected white"),
        ("correlated=x", "correlated: found 'x'"),
        ("correlated=1", "correlation: found 1"),
        ("heavy_tailed=2", "degrees_of_freedom: found 2"),
        ("quantised=4", "from 0 to 3.46"),
        ("misstated=nan", "scale: found nan"),
        ("outliers=-1", "from 0 to 0.5"),
    ],
)
def test_a_noise_that_cannot_be_is_told(noise: str, told: str) -> None:
    with pytest.raises(InvalidInputError, match=told):
        Instrument.of(noise)


# --- the verb -----------------------------------------------------------------------------


def run(*arguments: str) -> int:
    return commands.main(["simulate", str(CASE), str(PLAN), *arguments])


def test_the_same_seed_writes_the_same_bytes_which_the_other_verbs_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    noise = ["--noise", *NOISES]
    bearing = ["--with", "eccentric_bearing", "reference_deflection_um=0.5"]
    assert run(*noise, *bearing, "--seed", "5", "--out", "one.csv") == 0
    assert run(*noise, *bearing, "--seed", "5", "--out", "two.csv") == 0
    assert run(*noise, *bearing, "--seed", "6", "--out", "three.csv") == 0
    one, two, three = (Path(f"{n}.csv").read_bytes() for n in ("one", "two", "three"))
    assert one == two != three
    assert "138 readings in 4 runs" in capsys.readouterr().out
    readings = read_readings("one.csv")
    assert readings.u_elastic_angle_arcsec is not None and readings.time_s is not None
    assert commands.main(["compare", str(CASE), "one.csv"]) == 0


def test_what_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "loads.csv"
    table.write_text("torque_Nm,preload_N\n1,500\n900,500\n")
    given = ["simulate", str(CASE), str(table)]
    assert commands.main(given) == 2 and "--u-arcsec" in capsys.readouterr().err
    assert commands.main([*given, "--u-arcsec", "0.1"]) == 3
    assert "loads.csv" in (told := capsys.readouterr().err) and "900 N m" in told
    for wrong, said in (
        (["--with", "bearing", "c=1"], "bearing"),
        (["--with", "eccentric_bearing", "um"], "NAME=VALUE"),
        (["--out", "x.json"], ".csv"),
        (["--noise", "pink"], "pink"),
    ):
        assert run(*wrong) == 2 and said in capsys.readouterr().err
    with pytest.raises(PlanError):
        simulate(CASE, read_plan(PLAN), u_elastic_angle_arcsec=0)


def test_an_own_effect_comes_with_the_case() -> None:
    own = cbpt.effects.expression("mine", "series", "a * torque_Nm", {"a": 1e-6})
    with pytest.raises(cbpt.InvalidInputError, match=r"\[\[effect\]\]"):
        cbpt.simulate("examples/campaign.toml", "examples/plan.toml", effects=[own])  # type: ignore[list-item]
    with pytest.raises(cbpt.InvalidInputError, match="ids of effects"):
        cbpt.isolability("examples/campaign.toml", "examples/plan.toml", effects=[own])  # type: ignore[list-item]
