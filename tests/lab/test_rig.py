"""The rig that makes trial data: its drive, its effects, its noise and its campaigns."""

from __future__ import annotations

import ast
import csv
import io
import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from common.rings import PLAN
from common.rings import RINGS as CASE
from reference.contact import Floats
from reference.forward import CrossSlide, Drive, solve_drive
from reference.rig import ARCSEC, Rows, drive_of, held_Nm, simulate
from reference.rig.campaign import Campaign, draw_case, rows_of
from reference.rig.effects import LIBRARY, OUTSIDE, Hidden, draw_hidden, hidden
from reference.rig.mesh import NotHeldError
from reference.rig.noise import NOISE_KINDS, Noise, draw_noise
from trial import families
from trial.families import SINGLES, Family, make_trial
from trial.rivals import rival_correlations, yardstick_of

DRIVE = drive_of(CASE)
ROWS = rows_of(PLAN, CASE, np.random.default_rng(0))
ARM_M = DRIVE.deceleration.pitch_arm_m


def change(*effects: Hidden, rows: Rows = ROWS) -> Floats:
    """What effects add to the angle (rad)."""
    return simulate(DRIVE, rows, effects) - simulate(DRIVE, rows)


# --- the drive --------------------------------------------------------------------------------


@pytest.mark.parametrize("slide", [None, 14, 15])
def test_angles_are_those_of_the_reference(slide: int | None) -> None:
    drive = DRIVE
    if slide:
        pair = CrossSlide(slide, 0.035, 0.0012, 1.08, np.pi / 4)
        drive = Drive(DRIVE.deceleration, pair)
    some = np.arange(1, len(ROWS), 29)
    rows = ROWS.take(some)
    found = simulate(drive, rows)
    loads = zip(rows.input_angle_rad, rows.torque_Nm, rows.preload_N, strict=True)
    wanted = [solve_drive(drive, *(float(x) for x in load)).total_rad for load in loads]
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_torque_beyond_what_is_held_is_refused() -> None:
    up, _ = held_Nm(DRIVE, ROWS)
    rows = Rows(**{**vars(ROWS), "torque_Nm": np.full(len(ROWS), 1.01 * up.max())})
    with pytest.raises(NotHeldError):
        simulate(DRIVE, rows)


def test_neither_rig_nor_score_meets_the_product() -> None:
    trial = set(Path(families.__file__).parent.glob("*.py"))
    meets = {path for path in trial if path.stem in ("answers", "changes", "proposed", "run")}
    reference = (Path(__file__).parents[1] / "reference").rglob("*.py")
    for path in [*reference, *(trial - meets)]:
        tree = ast.parse(path.read_text())
        names = {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
        names |= {n.module or "" for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
        assert not any(n.split(".")[0] == "cbpt" for n in names), path


# --- effects ----------------------------------------------------------------------------------


@pytest.mark.parametrize("effect_id", [*LIBRARY, *OUTSIDE])
def test_no_size_no_change_and_more_size_more_change(effect_id: str) -> None:
    kind = {**LIBRARY, **OUTSIDE}[effect_id]
    cycles = Rows(**{**vars(ROWS), "cycle": ROWS.cycle + (np.arange(len(ROWS)) % 2)})
    if effect_id == "friction_hysteresis":
        cycles = cycles.take(np.arange(40))
    nominal = simulate(DRIVE, cycles)
    for form in kind.forms:
        effect = draw_hidden(kind, form, np.random.default_rng(3))
        none = simulate(DRIVE, cycles, [effect.sized(kind.neutral)])
        np.testing.assert_array_equal(none, nominal)
        small = kind.neutral + 1e-4 * (kind.high - kind.neutral)
        little = simulate(DRIVE, cycles, [effect.sized(small)]) - nominal
        assert 0 < np.abs(little).max() < 5 * ARCSEC, (effect_id, form)


def test_play_is_a_step_at_reversal() -> None:
    step = change(hidden("bearing_play", clearance_m=4e-6))
    np.testing.assert_allclose(step, np.sign(ROWS.torque_Nm) * 2e-6 / ARM_M, atol=1e-15)


def test_runout_is_a_sine_of_the_input_angle() -> None:
    found = change(hidden("eccentricity_error", offset_m=5e-7, phase_rad=0.7))
    wanted = 5e-7 / ARM_M * np.sin(ROWS.input_angle_rad + 0.7)
    np.testing.assert_allclose(found, wanted, atol=1e-15)


def test_creep_grows_with_the_logarithm_of_time() -> None:
    found = change(hidden("creep", rate_rad_per_Nm=6e-7, tau_s=20.0))
    wanted = 6e-7 * ROWS.torque_Nm * np.log(1 + ROWS.run_time_s / 20)
    np.testing.assert_allclose(found, wanted, atol=1e-15)


def test_superposed_creep_is_creep_where_the_torque_stays() -> None:
    still = ROWS.take(np.flatnonzero(ROWS.run == 1))
    still = Rows(**{**vars(still), "torque_Nm": np.full(len(still), 3.0)})
    values = {"rate_rad_per_Nm": 6e-7, "tau_s": 20.0}
    one, two = (change(hidden("creep", f, **values), rows=still) for f in ("library", "superposed"))
    np.testing.assert_allclose(one, two, atol=1e-15)


def test_bearing_and_torsion() -> None:
    bearing = change(hidden("eccentric_bearing", u_ref_m=2e-7, exponent=0.9))
    push = np.abs(ROWS.torque_Nm) / ARM_M
    wanted = np.sign(ROWS.torque_Nm) * 2e-7 * (push / 100) ** 0.9 / ARM_M
    np.testing.assert_allclose(bearing, wanted, atol=1e-15)
    torsion = change(hidden("output_torsion", compliance_rad_per_Nm=1e-6))
    np.testing.assert_allclose(torsion, 1e-6 * ROWS.torque_Nm, atol=1e-15)


def test_a_softer_contact_gives_by_the_two_thirds_power() -> None:
    nominal = simulate(DRIVE, ROWS)
    soft = simulate(DRIVE, ROWS, [hidden("contact_stiffness", scale=0.5)])
    np.testing.assert_allclose(soft, 2 ** (2 / 3) * nominal, rtol=1e-9, atol=1e-16)


def test_twins_are_twins() -> None:
    less = simulate(DRIVE, ROWS, [hidden("preload_loss", share=0.1)])
    twin = simulate(DRIVE, ROWS, [hidden("preload_scale", gain=0.9)])
    np.testing.assert_allclose(less, twin, rtol=1e-12, atol=1e-18)
    torque = simulate(DRIVE, ROWS, [hidden("torque_scale", gain=1 / 0.9)])
    np.testing.assert_allclose(less, 0.9 ** (2 / 3) * torque, rtol=1e-9, atol=1e-16)


@pytest.mark.parametrize("form", ["library", "iwan"])
def test_friction_loses_what_the_torque_does_not_give_back(form: str) -> None:
    """Virgin loading reads stiffer, unloading reads further; a short way is all friction."""
    values = {"mu_T_m": 6e-4, "length_rad": 5 * ARCSEC}
    one = ROWS.take(np.flatnonzero(ROWS.run == 1))
    found = simulate(DRIVE, one, [hidden("friction_hysteresis", form, **values)])
    plain = simulate(DRIVE, one)
    up, down = np.arange(1, PLAN.steps), 2 * PLAN.steps - np.arange(1, PLAN.steps)
    assert (found[up] < plain[up]).all() and (found[down] > found[up]).all()
    if form == "iwan":
        return
    way = found[up] - found[0]  # balls off the symmetric place turn a little at no torque
    friction = 6e-4 * one.preload_N[up] * (1 - np.exp(-way / (5 * ARCSEC)))
    less = Rows(**{**vars(one.take(up)), "torque_Nm": one.torque_Nm[up] - friction})
    np.testing.assert_allclose(simulate(DRIVE, less), found[up], rtol=1e-9)


def test_preload_spring_meets_the_reference() -> None:
    from reference.forward import Conditions, solve_pair

    rows = ROWS.take(np.arange(0, 8, 3))
    found = simulate(DRIVE, rows, [hidden("preload_spring", rate_N_per_m=3e8)])
    wanted = []
    for angle, torque, preload in zip(
        rows.input_angle_rad, rows.torque_Nm, rows.preload_N, strict=True
    ):
        pairs = DRIVE.pairs(float(angle))
        spring = Conditions(spring_N_per_m=3e8)
        load = float(torque), float(preload)
        wanted.append(sum(solve_pair(p, *load, spring).alpha_rad for p in pairs))
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-16)


# --- noise ------------------------------------------------------------------------------------


def many(kind: Any, seed: int = 5) -> tuple[Noise, Rows, Floats]:
    """A long table of nothing but noise of unit size."""
    runs, length = 100, 60
    run = np.repeat(np.arange(runs), length)
    t: Floats = np.arange(runs * length, dtype=np.float64)
    nil = np.zeros_like(t)
    rows = Rows(run, t, nil, nil + 500, nil, nil + 20, np.ones_like(run))
    noise = draw_noise(kind, 1.0, np.random.default_rng(seed))
    angle = 37.7 * np.sin(t)
    return noise, rows, noise.readings(angle, rows, np.random.default_rng(seed + 1)) - angle


@pytest.mark.parametrize("kind", NOISE_KINDS)
def test_statistics_of_noise(kind: Any) -> None:
    noise, rows, x = many(kind)
    table = x.reshape(100, 60)
    inside = table - table.mean(axis=1, keepdims=True)
    lag = float((inside[:, 1:] * inside[:, :-1]).mean() / inside.var())
    assert lag == pytest.approx(0.57 if kind == "correlated" else -0.015, abs=0.04)
    robust = float(stats.median_abs_deviation(inside, axis=None, scale="normal"))
    if kind == "heavy_tailed":
        assert stats.kurtosis(x) > 3 and x.std() == pytest.approx(1.0, abs=0.2)
        assert robust == pytest.approx(0.65, abs=0.05)
    elif kind == "quantised":
        shown = (x + 37.7 * np.sin(rows.time_s)) / noise.step_rad
        np.testing.assert_allclose(shown, np.round(shown), atol=1e-9)
        assert x.std() == pytest.approx(1.0, abs=0.1)
    else:
        assert robust == pytest.approx(1.0, abs=0.07)
    assert np.mean(np.abs(inside) > 6) == pytest.approx(
        0.02 if kind == "outliers" else 0.0, abs=0.006
    )
    spread = float(table.mean(axis=1).std())
    expected = {"run_offset": noise.offset_rad, "correlated": 0.25, "outliers": 0.29}.get(
        kind, 0.13
    )
    assert spread == pytest.approx(expected, rel=0.3)
    assert (noise.stated_u_rad in (0.7, 1.3)) == (kind == "misstated")
    variance = noise.covariance(rows.take(np.arange(80)))
    assert np.linalg.eigvalsh(variance).min() > 0


# --- campaigns --------------------------------------------------------------------------------


def test_random_drives_are_sound() -> None:
    rng = np.random.default_rng(11)
    for _ in range(20):
        drive = drive_of(draw_case(rng))
        assert not any(drive.deceleration.findings()[k] for k in ("undercut", "balls_touch"))
        assert not any(v for v in drive.equal_speed.findings().values())


FEW: list[tuple[Family, int]] = [
    ("null", 1),
    ("null", 35),
    ("parameter_only", 0),
    ("single", SINGLES.index("eccentric_bearing")),
    ("single", SINGLES.index("preload_loss") + 2 * len(SINGLES)),
    ("confounded", 0),
    ("confounded", 5),
    ("outside", 8),
]


@pytest.fixture(scope="module")
def campaigns() -> dict[tuple[Family, int], Campaign]:
    return {key: make_trial(*key, seed=2) for key in FEW}


@pytest.mark.parametrize("key", FEW)
def test_campaign(
    key: tuple[Family, int], campaigns: dict[tuple[Family, int], Campaign], tmp_path: Path
) -> None:
    c = campaigns[key]
    up, down = held_Nm(drive_of(c.case), c.rows, c.effects)
    assert (c.rows.torque_Nm < up).all() and (-c.rows.torque_Nm < down).all()
    assert (np.diff(c.rows.time_s) > 0).all()
    if key[0] in ("single", "outside"):
        d = yardstick_of(c).strength(next(e for e in c.effects[::-1] if isinstance(e, Hidden)))
        assert d == pytest.approx(c.truth["d"], rel=0.05)
    c.write(tmp_path, "one")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "one.csv").read_text())))
    assert len(rows) == len(c.rows)
    read = np.array([float(r["elastic_angle_arcsec"]) for r in rows])
    np.testing.assert_allclose(read, c.angle_rad / ARCSEC, atol=1e-4)
    assert tomllib.loads((tmp_path / "one.toml").read_text()) == c.case
    truth = json.loads((tmp_path / "one.truth.json").read_text())
    assert truth["answer"]["kind"] and truth == json.loads(json.dumps(c.truth))


def test_same_seed_same_readings(campaigns: dict[tuple[Family, int], Campaign]) -> None:
    key: tuple[Family, int] = ("outside", 8)  # an effect that was fitted to a strength
    again, other = make_trial(*key, seed=2), make_trial(*key, seed=3)
    assert again.to_csv() == campaigns[key].to_csv() and again.truth == campaigns[key].truth
    assert other.to_csv() != again.to_csv()


def test_readings_are_the_effects_and_the_noise(
    campaigns: dict[tuple[Family, int], Campaign],
) -> None:
    c = campaigns[FEW[3]]
    left = (c.angle_rad - simulate(drive_of(c.case), c.rows, c.effects)) / c.stated_u_rad
    assert left.std() == pytest.approx(1.0, abs=4 / np.sqrt(2 * len(left)))


def test_exact_twins_are_found_out(campaigns: dict[tuple[Family, int], Campaign]) -> None:
    """Warming in proportion to time at one preload: thermal preload and wear are the same."""
    few = ["wear", "eccentricity_error"]
    found = rival_correlations(campaigns["confounded", 5], draws=1, among=few)
    assert found["wear"] > 0.9999 and found["eccentricity_error"] < 0.9
