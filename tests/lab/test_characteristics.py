"""The figures of catalogues: against loops whose figures are known in closed form."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import cbpt
from cbpt.cli import main as commands
from cbpt.lab.characteristics.loops import loops_of
from cbpt.lab.characteristics.three_pieces import three_pieces

Floats = NDArray[np.float64]
RATED, STEP = 10.0, 0.1
SPRING = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "rating": {"rated_torque_Nm": RATED},
    "uncertainty": {"torque_gain_rel": 0.0, "sensor_gain_rel": 0.0},
}
UP = np.round(np.arange(-RATED, RATED + STEP / 2, STEP), 9)
CYCLES = np.concatenate([UP[UP >= 0], *[UP[-2::-1], UP[1:]] * 3])
FALLS = np.diff(CYCLES, prepend=-1.0) < 0
FIRST = np.cumsum(FALLS) == 0


def read(torque: Floats, angle: Floats, **more: Floats) -> cbpt.Characteristics:
    return cbpt.characterise(SPRING, {"torque_Nm": torque, "elastic_angle_arcsec": angle} | more)


def virgin(torque: Floats | float) -> Floats:
    """The first loading of the Masing loop, arcsec."""
    torque = np.asarray(torque)
    return 60 * torque + 0.5 * np.sign(torque) * torque**2


def masing() -> Floats:
    """Masing's rule: each branch is the virgin curve doubled in both directions."""
    tip = virgin(RATED)
    falls = tip - 2 * virgin((RATED - CYCLES) / 2)
    rises = -tip + 2 * virgin((RATED + CYCLES) / 2)
    return np.where(FIRST, virgin(CYCLES), np.where(FALLS, falls, rises))


def with_play(play: float = 30.0) -> Floats:
    """A play held by friction until the torque turns over, before a spring of 1 N m/arcmin."""
    side = np.where(CYCLES == 0, np.where(FALLS, 1.0, -1.0), np.sign(CYCLES))
    return 60 * CYCLES + 0.5 * play * side


# --- closed form --------------------------------------------------------------------------


def test_the_figures_of_a_masing_loop() -> None:
    found = read(CYCLES, masing())
    window = 0.03 * RATED
    ends = virgin((RATED + window) / 2) - virgin((RATED - window) / 2)
    expected: dict[str, ArrayLike] = {
        "lost_motion": 2 * ends,
        "hysteresis_loss": 2 * virgin(RATED) - 4 * virgin(RATED / 2),
        # The mean angle of both branches from half to full torque.
        "torsional_rigidity": 60
        * (RATED / 2)
        / (virgin(RATED) - virgin(0.75 * RATED) + virgin(0.25 * RATED)),
        "loop_energy": 2 / 3 * RATED**3 * np.pi / 648000,
        "backlash": 0.0,
    }
    for name, value in expected.items():
        assert found.figure(name).value == pytest.approx(
            float(np.asarray(value)), rel=1e-6, abs=1e-9
        ), name


def test_the_figures_of_a_play_with_a_spring() -> None:
    # Round angles would be rounded ones.
    found = read(CYCLES, with_play() + 1 / 7)
    expected = {"lost_motion": 30 + 36, "hysteresis_loss": 30, "backlash": 30}
    for name, value in (expected | {"torsional_rigidity": 1.0}).items():
        assert found.figure(name).value == pytest.approx(value, rel=1e-6), name
    assert all(found.figure(name).u == pytest.approx(0, abs=1e-9) for name in expected)


def test_three_pieces_are_found_and_may_be_given() -> None:
    compliance, breaks = [120.0, 60.0, 40.0], [2.5, 6.3]
    knots = [0.0, *breaks, RATED]
    angles = np.concatenate([[0.0], np.cumsum(np.array(compliance) * np.diff(knots))])
    angle = np.sign(CYCLES) * np.interp(np.abs(CYCLES), knots, angles)
    found = read(CYCLES, angle)
    for name, value in zip(("K1", "K2", "K3"), compliance, strict=True):
        assert found.figure(name).value == pytest.approx(60 / value, rel=1e-6)
    for name, value in zip(("T1", "T2"), breaks, strict=True):
        assert found.figure(name).value == pytest.approx(value, rel=1e-6)
    given = cbpt.characterise(
        SPRING,
        {"torque_Nm": CYCLES, "elastic_angle_arcsec": angle},
        break_torques_Nm=breaks,
    )
    assert given.figure("K2").value == pytest.approx(1.0, rel=1e-9)
    assert "given break torques" in given.figure("K2").convention


def test_a_straight_curve_has_no_break_torques() -> None:
    found = three_pieces(UP[UP > 0], 60 * UP[UP > 0])
    assert found is not None and not found.broken
    figure = read(CYCLES, 60 * CYCLES).figure("T1")
    assert figure.value is None and figure.reason and "straight" in figure.reason


def test_the_turn_of_friction_is_no_break_of_the_curve() -> None:
    """A straight spring, held back by friction that turns over within one step of the torque."""
    found = read(CYCLES, 60 * CYCLES + np.where(FALLS, 50.0, -50.0))
    for name in ("K1", "K2", "K3"):
        assert found.figure(name).value == pytest.approx(1.0, rel=1e-6)
    for name in ("T1", "T2"):
        figure = found.figure(name)
        assert figure.value is None and figure.reason and "straight" in figure.reason
    backlash = found.figure("backlash")
    assert backlash.value == 0.0
    assert "e+00" not in repr(found)


def test_a_piece_without_a_rise_says_so() -> None:
    found = read(CYCLES, 60 * CYCLES + 30 * np.sign(CYCLES))
    missing = [found.figure(name) for name in ("K1", "K2", "K3")]
    reasons = [figure.reason for figure in missing if figure.value is None]
    assert reasons and all(reason and "does not grow" in reason for reason in reasons)


# --- uncertainty --------------------------------------------------------------------------


def test_type_a_is_that_of_the_mean_over_loops() -> None:
    rng = np.random.default_rng(3)
    noisy = with_play() + rng.normal(0, 2.0, len(CYCLES))
    found = read(CYCLES, noisy)
    readings = cbpt.read_readings(
        {"torque_Nm": CYCLES, "elastic_angle_arcsec": noisy}, need_preload=False
    )
    losses = [
        float(x.falling.at(0.0) - x.rising.at(0.0))
        for x in loops_of(readings)
        if x.falling and x.rising
    ]
    assert len(losses) == 3
    figure = found.figure("hysteresis_loss")
    assert figure.value == pytest.approx(np.mean(losses))
    assert figure.u_type_a == pytest.approx(np.std(losses, ddof=1) / 3**0.5)


def test_a_single_loop_takes_the_stated_uncertainty() -> None:
    """The width is the difference of two readings."""
    one = CYCLES[: 4 * len(UP) // 2]
    found = read(one, with_play()[: len(one)], u_elastic_angle_arcsec=np.full(len(one), 2.0))
    figure = found.figure("hysteresis_loss")
    assert figure.u_type_a == pytest.approx(2 * 2**0.5, rel=0.35)


@pytest.mark.parametrize(
    ("loops", "larger", "said"),
    [
        (1, 0.0, "1 loop to 10 N m, with both branches"),
        (
            3,
            0.0,
            "3 loops; the figures are those of the 3 with both branches and the largest torque",
        ),
        (1, 4.0, "2 loops; the figures are those of the one with both branches and the largest"),
    ],
)
def test_the_report_counts_loops(loops: int, larger: float, said: str) -> None:
    """A loop that goes further and does not come back is none with both branches."""
    cycle = np.concatenate([UP[UP >= 0], UP[-2::-1], UP[1:]])
    torque = np.tile(cycle, loops)
    run = np.repeat(np.arange(float(loops)), len(cycle))
    if larger:
        half = np.arange(-larger * RATED, larger * RATED, STEP)
        torque = np.concatenate([torque, half])
        run = np.concatenate([run, np.full(len(half), 9.0)])
    found = read(torque, 60 * torque, run=run)
    assert said in found.report()


def test_type_b_follows_the_gains() -> None:
    case = SPRING | {"uncertainty": {"torque_gain_rel": 0.02, "sensor_gain_rel": 0.01}}
    table = {"torque_Nm": CYCLES, "elastic_angle_arcsec": 60 * CYCLES + 1 / 7}
    found = cbpt.characterise(case, table)
    assert found.figure("torsional_rigidity").u_type_b == pytest.approx(5**0.5 * 0.01, rel=1e-3)
    motion = found.figure("lost_motion")
    assert motion.value is not None
    assert motion.u_type_b == pytest.approx(5**0.5 * 0.01 * motion.value, rel=1e-3)


# --- the model ----------------------------------------------------------------------------


def test_the_model_has_the_figures_of_its_effects() -> None:
    play = {"id": "backlash", "play_arcsec": 30, "transition_torque_Nm": 1e-6}
    found = cbpt.characterise(SPRING | {"effect": [play]})
    assert found.figure("backlash").value == pytest.approx(30, rel=1e-6)
    assert found.figure("lost_motion").value == pytest.approx(66, rel=1e-6)
    assert found.figure("torsional_rigidity").value == pytest.approx(1, rel=1e-6)
    assert found.figure("torsional_rigidity").u == pytest.approx(0.1, rel=0.15)


def test_readings_of_the_model_stand_beside_it() -> None:
    friction = {"id": "friction_hysteresis", "friction_torque_Nm": 1, "engagement_angle_arcsec": 40}
    case = cbpt.Case.from_dict(SPRING | {"effect": [friction]})
    rows = {"torque_Nm": CYCLES, "elastic_angle_arcsec": CYCLES, "time_s": np.arange(len(CYCLES))}
    made = cbpt.simulate(
        case, cbpt.read_readings(rows, need_preload=False), noise="none", u_elastic_angle_arcsec=1.0
    )
    found = cbpt.characterise(case, made)
    ratios = {entry["name"]: entry["value"] for entry in found.to_dict()["ratios"]}
    for name in ("lost_motion", "hysteresis_loss", "torsional_rigidity", "loop_energy"):
        assert ratios[name] == pytest.approx(1, abs=2e-3), name


@pytest.mark.parametrize("transition_Nm", [0.2, 1.0])
def test_a_soft_play_is_one_number_for_readings_and_model(transition_Nm: float) -> None:
    """The model's was read off a loop a tenth as large, in which such a play hardly opens: 27
    arcsec beside 566 of the readings."""
    play = {"id": "backlash", "play_arcsec": 580, "transition_torque_Nm": transition_Nm}
    case = cbpt.Case.from_dict(SPRING | {"effect": [play]})
    rows = {"torque_Nm": CYCLES, "elastic_angle_arcsec": CYCLES}
    made = cbpt.simulate(
        case, cbpt.read_readings(rows, need_preload=False), noise="none", u_elastic_angle_arcsec=1.0
    )
    ratios = cbpt.characterise(case, made).to_dict()["ratios"]
    beside = {entry["name"]: entry["value"] for entry in ratios}
    assert beside["backlash"] == pytest.approx(1, abs=0.05)
    alone, both = cbpt.characterise(case), cbpt.characterise(case, made)
    model = next(f for f in both.groups[0].model if f.name == "backlash")
    assert alone.figure("backlash").value == pytest.approx(model.value, rel=1e-9)


def test_loops_that_no_figure_is_read_off_are_told() -> None:
    run = np.repeat([1, 2, 3], len(CYCLES))
    torque = np.concatenate([CYCLES, 0.6 * CYCLES, 0.2 * CYCLES])
    [told] = [w for w in read(torque, 60 * torque, run=run).groups[0].warnings if "left out" in w]
    assert "3 of 9 loops, to 6 N m, are left out" in told
    run, torque = run[run != 2], torque[run != 2]
    assert not any("left out" in w for w in read(torque, 60 * torque, run=run).groups[0].warnings)


def test_a_torque_that_is_not_held_has_no_figures() -> None:
    case = cbpt.example_case() + "\n[rating]\nrated_torque_Nm = 500\n"
    figure = cbpt.characterise(cbpt.Case.from_toml(case)).figure("lost_motion")
    assert figure.value is None and figure.reason and "beyond_hold" in figure.reason


# --- what is told -------------------------------------------------------------------------


def test_half_a_loop_has_a_rigidity_and_no_lost_motion() -> None:
    half = np.r_[np.arange(0, 10.01, 0.5), np.arange(9.5, -0.01, -0.5)]
    found = read(half, 60 * half)
    assert found.figure("torsional_rigidity").value == pytest.approx(1)
    figure = found.figure("lost_motion")
    assert figure.value is None and figure.reason and "both sides of zero" in figure.reason


def test_warnings_name_steps_closure_and_rate() -> None:
    coarse = CYCLES[::10]
    drifting = 60 * coarse + 2.0 * np.arange(len(coarse))
    warnings = " ".join(read(coarse, drifting).groups[0].warnings)
    assert "coarser than the window" in warnings and "does not close" in warnings
    time = np.r_[0.0, np.cumsum(np.abs(np.diff(CYCLES)))]
    time[len(CYCLES) // 2 :] += np.arange(len(CYCLES) - len(CYCLES) // 2) * 1.0
    assert "N m/s" in " ".join(read(CYCLES, 60 * CYCLES, time_s=time).groups[0].warnings)


def test_a_report_tells_all_its_angles_in_one_unit() -> None:
    """Warnings and reasons said arcsec beside figures in degrees."""
    coarse = CYCLES[::10]
    report = read(coarse, 60 * coarse + 2.0 * np.arange(len(coarse))).report("deg")
    assert "does not close" in report and "arcsec" not in report


def test_each_preload_and_each_level_of_a_column_has_figures() -> None:
    moments = np.repeat(["before", "after"], len(CYCLES))
    table = {
        "moment": moments,
        "run": np.repeat([1, 2], len(CYCLES)),
        "torque_Nm": np.tile(CYCLES, 2),
        "elastic_angle_arcsec": np.r_[with_play(30), with_play(12)],
    }
    found = cbpt.characterise(SPRING, table, by="moment")
    assert found.figure("backlash", "moment before").value == pytest.approx(30)
    assert found.figure("backlash", "moment after").value == pytest.approx(12)


def test_what_all_settings_and_several_figures_share_is_said_once() -> None:
    """Three settings had the same warnings each, and five figures one convention."""
    coarse = np.r_[0.0, CYCLES[::10], 0.0]
    table = {
        "moment": np.repeat(["before", "after"], len(coarse)),
        "run": np.repeat([1, 2], len(coarse)),
        "torque_Nm": np.tile(coarse, 2),
        "elastic_angle_arcsec": np.r_[60 * coarse, 30 * coarse],
    }
    by_moment = cbpt.characterise(SPRING, table, by="moment")
    report = by_moment.report()
    assert all(len(group.warnings) for group in by_moment.groups)
    assert report.count("are coarser than the window") == 1
    assert "\n\nWarning, at every setting: The steps of the torque" in report
    assert "\n- K1, K2, K3, T1, T2: three straight pieces" in report


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"window": 0.7}, "window"),
        ({"rated_torque_Nm": -1.0}, "rated_torque_Nm"),
        ({"break_torques_Nm": (3.0, 2.0)}, "break_torques_Nm"),
    ],
)
def test_arguments_are_checked(given: dict[str, object], told: str) -> None:
    with pytest.raises(cbpt.InvalidInputError, match=told):
        cbpt.characterise(SPRING, **given)  # type: ignore[arg-type]


def test_a_table_without_a_loop_is_refused() -> None:
    with pytest.raises(cbpt.ReadingsError, match="no run whose torque turns back"):
        read(np.ones(5), np.arange(5.0))


# --- the command --------------------------------------------------------------------------


def test_the_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case, table = tmp_path / "case.toml", tmp_path / "loop.csv"
    case.write_text(cbpt.Case.from_dict(SPRING).to_toml())
    rows = zip(CYCLES.tolist(), with_play().tolist(), strict=True)
    lines = ["torque_Nm,elastic_angle_arcsec", *(f"{t},{a}" for t, a in rows)]
    table.write_text("\n".join(lines))
    out, picture = tmp_path / "f.json", tmp_path / "f.svg"
    arguments = ["characterise", str(case), str(table), "--json", str(out), "--plot", str(picture)]
    assert commands.main([*arguments, "--angle-unit", "arcmin"]) == 0
    shown = capsys.readouterr().out
    assert "backlash" in shown and "arcmin" in shown and "Conventions" in shown
    document = json.loads(out.read_text())
    figures = {figure["name"]: figure for figure in document["figures"]}
    keys = {"name", "value", "u", "unit", "convention", "torque_Nm", "rests_on"}
    assert all(keys <= figure.keys() for figure in figures.values())
    assert list(figures) == [
        *("lost_motion", "hysteresis_loss", "backlash", "torsional_rigidity"),
        *("K1", "K2", "K3", "T1", "T2", "loop_energy"),
    ]
    assert figures["backlash"]["value"] == pytest.approx(30)
    assert picture.read_text().startswith("<?xml")
    assert commands.main(["characterise", str(case), "--by", "run"]) == 2
    assert commands.main(["characterise", str(case), "--json"]) == 0


def test_every_figure_is_drawn_where_it_is_read_off(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: dict[str, NDArray[np.float64]] = {}

    def keep(figure: Any, path: object) -> None:
        for line in figure.axes[0].lines:
            drawn[line.get_label()] = np.column_stack(line.get_data())

    monkeypatch.setattr("cbpt.figures.characteristics.save", keep)
    knots, angles = [0.0, 2.5, 6.3, RATED], [0.0, 300.0, 528.0, 676.0]
    angle = np.sign(CYCLES) * np.interp(np.abs(CYCLES), knots, angles)
    found = read(CYCLES, angle)
    found.plot("loop.svg")
    of = {label.split(" ")[0].rstrip(","): line for label, line in drawn.items()}
    assert of.keys() >= {"hysteresis", "lost", "backlash", "K1", "torsional"}
    np.testing.assert_allclose(of["K1"], np.column_stack([knots, angles]), rtol=1e-6)
    half = RATED / 2
    assert of["torsional"][:, 0].tolist() == [half, RATED]
    rigidity = found.figure("torsional_rigidity").value
    assert rigidity is not None
    assert np.diff(of["torsional"][:, 1])[0] == pytest.approx(60 * half / rigidity)
    assert np.all(of["backlash"][:, 0] == 0)
    assert np.ptp(of["backlash"][:, 1]) == pytest.approx(found.figure("backlash").value)


def test_two_loops_that_agree_by_chance_are_no_better_than_their_readings() -> None:
    """u of the hysteresis loss from two loops has one degree of freedom: it was down to an eighth
    of what the stated u of the four readings allows, and the loss 10 u off."""
    up = np.linspace(0.0, 20.0, 41)
    loop = np.concatenate([up, up[-2::-1], -up[1:], -up[-2::-1], up[1:]])
    torque = np.tile(loop, 2)
    carried = np.clip(0.0, torque - 1.0, torque + 1.0)
    held = 0.0
    for i, at in enumerate(torque):
        held = min(max(held, at - 1.0), at + 1.0)
        carried[i] = held
    least = []
    for seed in range(12):
        noise = np.random.default_rng([17, seed]).standard_normal(len(torque))
        table = {
            "run": np.repeat([1, 2], len(loop)),
            "torque_Nm": torque,
            "elastic_angle_arcsec": 10.0 * carried + noise,
            "u_elastic_angle_arcsec": np.ones(len(torque)),
        }
        loss = cbpt.characterise(SPRING, table).figure("hysteresis_loss")
        assert loss.u is not None
        least.append(loss.u)
    # Two widths, each of two readings or more by their neighbours.
    assert min(least) > 0.5
