"""Drives drawn within the tolerances of a drawing: against closed forms, against the exact
sensitivities where tolerances are small, and what has no solution.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt.cli.main import main

TOP = Path(__file__).parents[2]
BASE = (TOP / "examples/base_case.toml").read_text()


def case_with(tolerance: str = "", uncertainty: str = "", base: str = BASE) -> cbpt.Case:
    text = f"{base}\n[tolerance]\n{tolerance}\n[uncertainty]\n{uncertainty}\n"
    return cbpt.Case.from_toml(text)


def test_a_modulus_within_limits_has_a_known_law() -> None:
    """alpha = alpha_0 (E/E_0)^(-2/3): even in E, so the quantiles are known, and the moments are
    integrals of powers."""
    case = case_with("material_youngs_modulus_GPa = 50")
    found = cbpt.tolerance(case, samples=20_000)
    nominal = found.nominal_arcsec
    assert nominal is not None
    low, high = 158 / 208, 258 / 208
    for p, (quantile, error) in found.quantiles_arcsec.items():
        expected = nominal * (low + (1 - p) * (high - low)) ** (-2 / 3)
        assert abs(quantile - expected) <= 4 * error, p
    mean = nominal * 3 * (high ** (1 / 3) - low ** (1 / 3)) / (high - low)
    square = nominal**2 * 3 * (low ** (-1 / 3) - high ** (-1 / 3)) / (high - low)
    assert abs(found.mean_arcsec - mean) <= 4 * found.mean_error_arcsec
    assert abs(found.sd_arcsec - np.sqrt(square - mean**2)) <= 4 * found.sd_error_arcsec
    # Errors are of the size of a sample's own: a few parts in a thousand of the spread.
    assert 0.003 < found.mean_error_arcsec / found.sd_arcsec < 0.02
    assert 0.001 < found.sd_error_arcsec / found.sd_arcsec < 0.02
    # The corners are exact.
    ends = [nominal * high ** (-2 / 3), nominal * low ** (-2 / 3)]
    assert found.stacked_arcsec == pytest.approx(ends, rel=1e-9)
    linear = nominal * 2 / 3 * 50 / 208
    assert found.stacked_linear_arcsec == pytest.approx([nominal - linear, nominal + linear])


@pytest.mark.parametrize("samples", [2, 3])
def test_few_drives_do_not_know_their_spread_well(samples: int) -> None:
    case = case_with("material_youngs_modulus_GPa = 50")
    for seed in range(4):
        found = cbpt.tolerance(case, samples=samples, seed=seed)
        assert 0.3 < found.sd_error_arcsec / found.sd_arcsec < 1
        assert np.isnan(found.quantiles_arcsec[0.025][1])
        assert "(standard error unknown, too few drives)" in found.report()


SMALL = """
deceleration_ball_radius_um = 0.5
deceleration_contact_angle_deg = 0.05
deceleration_rolling_circle_radius_um = 2
equal_speed_pitch_radius_um = 20
load_preload_N = 1
"""


def test_small_tolerances_are_linear() -> None:
    found = cbpt.tolerance(
        case_with(SMALL, "equal_speed_groove_conformity = 0.0005"), samples=20_000
    )
    assert found.linear_u_arcsec is not None
    assert abs(found.sd_arcsec - found.linear_u_arcsec) <= 4 * found.sd_error_arcsec
    assert abs(found.mean_arcsec - (found.nominal_arcsec or 0)) <= 4 * found.mean_error_arcsec
    assert sum(n.share or 0 for n in found.numbers) == pytest.approx(1)
    for number in found.numbers:
        assert number.share is not None and number.share_drawn is not None
        assert number.share_drawn == pytest.approx(number.share, abs=0.03)
    assert found.stacked_linear_arcsec is not None
    assert found.stacked_arcsec == pytest.approx(found.stacked_linear_arcsec, rel=1e-4)
    kinds = {n.number: n.distribution for n in found.numbers}
    assert kinds["equal_speed.groove_conformity"] == "normal"
    assert set(kinds.values()) == {"normal", "uniform"} and len(kinds) == 6


def test_limits_count_before_the_uncertainty() -> None:
    found = cbpt.tolerance(
        case_with(
            "load_preload_N = 10\ndeceleration_ball_radius_um = 1",
            "deceleration_ball_radius_um = 50",
        ),
        samples=100,
    )
    by = {n.number: n for n in found.numbers}
    assert by["deceleration.ball_radius_m"].distribution == "uniform"
    assert by["deceleration.ball_radius_m"].size == pytest.approx(1e-6)


def test_one_of_two_equal_numbers_may_scatter_by_itself() -> None:
    found = cbpt.tolerance(case_with("material_ball_youngs_modulus_GPa = 4"), samples=4000)
    both = cbpt.tolerance(case_with("material_youngs_modulus_GPa = 4"), samples=4000)
    # Half of the compliance is the ball's.
    assert found.linear_u_arcsec == pytest.approx((both.linear_u_arcsec or 0) / 2, rel=1e-9)
    assert found.sd_arcsec == pytest.approx(found.linear_u_arcsec, rel=0.05)


def test_what_has_no_solution_is_counted() -> None:
    case = case_with("load_preload_N = 50")
    found = cbpt.tolerance(case, samples=4000, torque_Nm=5.0, preload_N=140)
    # Even in the preload, and held from hold_N on.
    hold = cbpt.Drive.from_toml(BASE).preload(5, input_angle_deg=0).drive.hold_N
    expected = (hold - 90) / 100
    share, error = found.share_of(found.status["beyond_hold"])
    assert abs(share - expected) <= 4 * error
    assert sum(found.status.values()) == 4000
    assert np.isnan(found.angles_arcsec).sum() == found.status["beyond_hold"]
    assert "no solution: beyond hold" in found.report()
    # At the corner with the least preload there is none.
    assert found.stacked_arcsec[1] is None and found.stacked_arcsec[0] is not None
    with pytest.raises(cbpt.NoSolutionError, match="no solution for any of 100 random drives"):
        cbpt.tolerance(case, samples=100, torque_Nm=60)


def test_numbers_that_make_no_drive_are_told_as_such() -> None:
    # A conformity below 1 is no groove for its ball.
    base = BASE.replace("groove_conformity = 1.08", "groove_conformity = 1.001")
    case = case_with("deceleration_groove_conformity = 0.01", base=base)
    found = cbpt.tolerance(case, samples=500)
    assert 0 < found.status["no_drive"] < 500
    said = [line for line in found.report().splitlines() if "no possible drive" in line]
    assert len(said) == 1 and said[0].startswith("numbers that describe no possible drive: ")


def test_lost_walls_are_counted() -> None:
    base = BASE.replace("short_amplitude_coefficient = 0.5", "short_amplitude_coefficient = 0.265")
    found = cbpt.tolerance(
        case_with("deceleration_short_amplitude_coefficient = 0.01", base=base), samples=4000
    )
    # Without inside wall where K r0 <= r cos(beta); the drive still turns.
    edge = 1.5e-3 * np.cos(np.pi / 4) / 4e-3
    share, error = found.share_of(found.lost["inside_wall_missing"])
    assert abs(share - (edge - 0.255) / 0.02) <= 4 * error
    assert found.status == {"ok": 4000} and found.lost["undercut"] == 0


def test_the_same_seed_draws_the_same_drives() -> None:
    case = case_with(SMALL)
    one, two, other = (cbpt.tolerance(case, samples=500, seed=seed) for seed in (1, 1, 2))
    assert one.to_dict() == two.to_dict() != other.to_dict()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"samples": 1}, "samples = 1: expected 2"),
        ({"seed": -1}, "seed = -1"),
        ({"preload_N": -1.0}, "preload_N"),
    ],
)
def test_what_cannot_be_is_refused(arguments: dict[str, float], words: str) -> None:
    with pytest.raises(cbpt.InvalidInputError, match=words):
        cbpt.tolerance(case_with(SMALL), **arguments)  # type: ignore[arg-type]


def test_a_case_without_tolerances_or_load_says_what_to_add() -> None:
    with pytest.raises(cbpt.InvalidInputError, match=r"add a table \[tolerance\]"):
        cbpt.tolerance(TOP / "examples/base_case.toml")
    bare = BASE[: BASE.index("[load]")]
    with pytest.raises(cbpt.InvalidInputError, match="torque_Nm is missing"):
        cbpt.tolerance(case_with(SMALL, base=bare))
    with pytest.raises(cbpt.InvalidInputError, match="ball drive"):
        cbpt.tolerance(TOP / "examples/reducer.toml", torque_Nm=1, preload_N=1)


def test_the_verb_prints_and_draws(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    case, picture = tmp_path / "case.toml", tmp_path / "t.svg"
    case.write_text(f"{BASE}\n[tolerance]\n{SMALL}")
    line = ["tolerance", str(case), "--samples", "500", "--plot", str(picture)]
    assert main([*line, "--angle-unit", "urad"]) == 0
    said = capfd.readouterr().out
    assert "in urad" in said and "+- 0.0005" in said
    assert "density [1/urad]" in picture.read_text()
    assert main([*line[:4], "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["status"]["ok"]["share"] == 1
    assert found["quantiles"][1]["probability"] == 0.5
    assert {row["number"] for row in found["numbers"]} >= {"load.preload_N"}
    assert main(["tolerance", str(case), "--samples", "0"]) == 2
    assert main(["tolerance", str(case), "--torque-Nm", "99", "--samples", "9"]) == 3
