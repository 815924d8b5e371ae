"""Campaigns held against the model: what a comparison says of a hidden truth must be so.

Groups: the campaigns, and the same numbers worked out again in plain numpy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import cbpt
from cbpt import Readings, compare
from cbpt.lab.diagnosis.misfit import Group
from common.comparisons import (
    ARCSEC,
    CAMPAIGNS,
    EVERY,
    TRUTH,
    UNLIKE,
    Columns,
    adequate,
    by,
    case_of,
    columns_of,
    compared,
    drive_of,
    excess,
    model,
    strictly,
)
from common.drives import examples

# --- the campaigns ------------------------------------------------------------------------


@EVERY
def test_only_the_complete_model_is_adequate(name: str) -> None:
    c = compared(name)
    assert adequate(c) == (TRUTH[name]["answer"]["kind"] == "complete")
    verdict = c.report().splitlines()[1]
    assert verdict.startswith("The model agrees" if adequate(c) else "The model disagrees")


@UNLIKE
def test_every_reading_counts(name: str) -> None:
    c, columns = compared(name), columns_of(name)
    n = len(columns["torque_Nm"])
    assert c.overall is not None
    assert len(c.readings) == c.overall.readings == n
    assert c.without_solution == {}
    assert c.readings.line.tolist() == list(range(2, n + 2))
    assert np.ptp(columns["u_elastic_angle_arcsec"]) == 0
    assert columns["u_elastic_angle_arcsec"][0] == TRUTH[name]["sigma_arcsec"]


def test_a_zero_for_each_run_takes_run_offsets_away() -> None:
    c = compare(case_of("dev02", '[measurement]\nzero = "per_run"\n'), CAMPAIGNS / "dev02.csv")
    assert adequate(c)
    assert len(c.zero_arcsec) == 12
    assert 0.4 < np.std(list(c.zero_arcsec.values())) < 1.5  # 0.8 is hidden


def test_a_compliance_behind_the_contacts_grows_with_torque_alone() -> None:
    c = compared("dev03")
    torque = [(group.low or 0.0, excess(group)) for group in by(c, "torque_Nm").values()]
    backwards = [found for low, found in torque if low < 0]
    forwards = [found for low, found in torque if low >= 0]
    assert len(backwards) == len(forwards) == 3
    assert backwards == sorted(backwards, reverse=True) and forwards == sorted(forwards)
    assert min(backwards + forwards) > 0
    assert c.overall is not None
    for column in ("preload_N", "input_angle_deg", "direction"):
        for group in by(c, column).values():
            assert excess(group) == pytest.approx(c.overall.excess_arcsec, rel=0.06), group.label
    worst = c.worst()
    assert worst is not None and worst.column == "torque_Nm" and worst.label == "6 to 8"


def test_friction_shows_in_the_direction_and_with_preload() -> None:
    c = compared("dev04")
    rising, falling = by(c, "direction")["rising"], by(c, "direction")["falling"]
    assert falling.misfit.bias_arcsec - rising.misfit.bias_arcsec > 2
    width = {}
    for preload in (420, 1200):
        rows, way = c.readings.preload_N == preload, c.readings.direction()
        on_the_way = [c.residual_arcsec[rows & (way == sign)].mean() for sign in (1, -1)]
        width[preload] = on_the_way[1] - on_the_way[0]
    assert width[1200] > 1.2 * width[420] > 2
    worst = c.worst()
    assert worst is not None and worst.column == "preload_N"


def test_lost_preload_shows_where_there_is_least_of_it() -> None:
    c = compared("dev05")
    found = [excess(group) for group in by(c, "preload_N").values()]
    assert found == sorted(found, reverse=True)
    assert found[0] > 4 * found[-1] > 0
    worst = c.worst()
    assert worst is not None and (worst.column, worst.label) == ("preload_N", "420")


def test_a_stiff_preload_makes_the_drive_stiffer_than_the_model() -> None:
    c = compared("dev06")
    assert c.overall is not None and c.overall.excess_arcsec < 0
    found = [excess(group) for group in by(c, "preload_N").values()]
    assert found == sorted(found)
    assert all(value < 0 for value in found[:2])


def test_an_eccentric_groove_turns_with_the_input() -> None:
    c = compared("dev07")
    for group in by(c, "input_angle_deg").values():
        assert group.low is not None
        expected = runout(group.low)
        assert group.misfit.bias_arcsec == pytest.approx(expected, abs=0.15)
    assert c.overall is not None
    assert abs(c.overall.excess_arcsec) < 0.1


def test_a_damaged_stretch_is_found_at_its_angle() -> None:
    c = compared("dev10")
    angles = by(c, "input_angle_deg")
    assert angles["130"].share_of_misfit > 0.95
    worst = c.worst()
    assert worst is not None and (worst.column, worst.label) == ("input_angle_deg", "130")


def test_creep_grows_along_a_run() -> None:
    c = compared("dev13")
    assert c.readings.time_s is not None
    sign = np.sign(c.readings.torque_Nm)
    rows = np.abs(c.readings.torque_Nm) == 8
    early = np.zeros(len(c.readings), dtype=bool)
    for run in np.unique(c.readings.run):
        of_run = (c.readings.run == run) & rows
        early[of_run] = c.readings.time_s[of_run] < np.median(c.readings.time_s[of_run])
    excess_then = (c.residual_arcsec * sign)[rows & early].mean()
    excess_later = (c.residual_arcsec * sign)[rows & ~early].mean()
    assert 0 < excess_then < excess_later
    assert c.overall is not None and c.overall.excess_arcsec > 0.5


def _preload_lost(columns: Columns) -> None:
    columns["preload_N"] *= 1 - TRUTH["dev05"]["hidden"]["preload_loss"]


def _gain_undone(columns: Columns) -> None:
    columns["elastic_angle_arcsec"] /= TRUTH["dev08"]["hidden"]["sensor_gain"]


def _stiffness_undone(columns: Columns) -> None:
    # Hertz: with all contacts softer by s every angle grows by s^(-2/3).
    columns["elastic_angle_arcsec"] *= TRUTH["dev12"]["hidden"]["k_scale"] ** (2 / 3)
    columns["u_elastic_angle_arcsec"] *= TRUTH["dev12"]["hidden"]["k_scale"] ** (2 / 3)


def runout(input_angle_deg: Any) -> Any:
    """The hidden error of the eccentricity as an angle of the output, arcsec."""
    shift, phase = TRUTH["dev07"]["hidden"]["runout"]
    # 20 balls run on 21 lobes; eccentricity 0.5 * 2.5 mm.
    lever = 21 * 0.5 * 2.5e-3
    return shift / lever / ARCSEC * np.sin(np.deg2rad(input_angle_deg) + phase)


def _runout_undone(columns: Columns) -> None:
    columns["elastic_angle_arcsec"] -= runout(columns["input_angle_deg"])


@pytest.mark.parametrize(
    ("name", "undo"),
    [
        ("dev05", _preload_lost),
        ("dev07", _runout_undone),
        ("dev08", _gain_undone),
        ("dev12", _stiffness_undone),
    ],
)
def test_with_the_truth_undone_the_model_is_adequate(
    name: str, undo: Callable[[Columns], None]
) -> None:
    columns = columns_of(name)
    assert not adequate(compare(drive_of(name), columns))
    undo(columns)
    assert adequate(compare(drive_of(name), columns))


# --- the same numbers, worked out again ---------------------------------------------------


@UNLIKE
def test_numbers_are_those_of_plain_numpy(name: str) -> None:
    from scipy.stats import chi2

    c, columns = compared(name), columns_of(name)
    angle, u = columns["elastic_angle_arcsec"], columns["u_elastic_angle_arcsec"]
    residual = angle - model(drive_of(name), columns)
    np.testing.assert_array_equal(c.residual_arcsec, residual)
    loaded = columns["torque_Nm"] != 0
    signed = residual * np.sign(columns["torque_Nm"])
    worst = np.argmax(np.abs(residual))
    sum_of_squares = np.sum((residual / u) ** 2)
    n = len(residual)
    assert c.overall is not None
    assert c.overall.bias_arcsec == pytest.approx(np.mean(residual), rel=1e-12, abs=1e-12)
    assert c.overall.excess_arcsec == pytest.approx(np.mean(signed[loaded]), rel=1e-12)
    assert c.overall.rmse_arcsec == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-12)
    assert c.overall.largest_error_arcsec == residual[worst]
    assert c.overall.largest_error_line == worst + 2
    assert c.overall.chi2_per_dof == pytest.approx(sum_of_squares / n, rel=1e-12)
    assert c.p_value == pytest.approx(chi2.sf(sum_of_squares, n), rel=1e-9, abs=1e-300)
    assert c.best_common_zero_arcsec == pytest.approx(np.mean(residual), rel=1e-10)
    assert c.rmse_with_best_zero_arcsec == pytest.approx(np.std(residual), rel=1e-10)


@UNLIKE
def test_groups_divide_the_readings(name: str) -> None:
    c = compared(name)
    total = np.sum(c.residual_arcsec**2)
    assert {group.column for group in c.groups} <= {
        *("preload_N", "torque_Nm", "direction", "input_angle_deg", "run")
    }
    for column in dict.fromkeys(group.column for group in c.groups):
        groups = list(by(c, column).values())
        assert len(groups) == len([group for group in c.groups if group.column == column]) > 1
        sizes = np.array([group.misfit.readings for group in groups])
        assert sizes.sum() == len(c.readings)
        assert sum(group.share_of_misfit for group in groups) == pytest.approx(1, abs=1e-12)
        bias = sum(group.misfit.bias_arcsec * group.misfit.readings for group in groups)
        assert bias / sizes.sum() == pytest.approx(np.mean(c.residual_arcsec), abs=1e-12)
        for group in groups:
            rows = rows_of(c.readings, group)
            part = c.residual_arcsec[rows]
            assert group.misfit.readings == np.count_nonzero(rows), group
            assert group.misfit.rmse_arcsec == pytest.approx(np.sqrt(np.mean(part**2)))
            assert group.share_of_misfit == pytest.approx(np.sum(part**2) / total)
            largest = group.misfit.largest_error_arcsec
            assert abs(largest) == np.max(np.abs(part))
            line = c.readings.line == group.misfit.largest_error_line
            assert (line & rows).sum() == 1 and c.residual_arcsec[line] == largest


def rows_of(readings: Readings, group: Group) -> NDArray[np.bool_]:
    """The rows that a group says it is about."""
    if group.column == "run":
        assert group.low is None and group.high is None
        return np.array([str(run) == group.label for run in readings.run.tolist()])
    of = {"direction": readings.direction()}
    values = of.get(group.column, getattr(readings, group.column))
    if callable(values):
        values = values()
    assert group.low is not None and group.high is not None
    return np.asarray((values >= group.low) & (values <= group.high))


@given(
    torque=st.lists(st.sampled_from([-9.0, -4.0, -1.5, 0.0, 0.5, 3.0, 30.0]), min_size=1),
    seed=st.integers(0, 2**32 - 1),
    stated=st.booleans(),
    zero=st.sampled_from(["common", "per_run"]),
)
@examples(60)
def test_any_table_is_divided_without_a_rest(
    torque: list[float], seed: int, stated: bool, zero: str
) -> None:
    rng = np.random.default_rng(seed)
    n = len(torque)
    columns: Columns = {
        "run": rng.integers(0, 3, n),
        "torque_Nm": np.array(torque) + rng.choice([0.0, 1.0]) * rng.normal(0, 0.01, n),
        "preload_N": rng.choice([150.0, 400.0, 900.0], n),
        "input_angle_deg": rng.choice([0.0, 33.0], n),
        "elastic_angle_arcsec": rng.normal(0, 10, n),
    }
    if stated:
        columns["u_elastic_angle_arcsec"] = rng.uniform(0.1, 2, n)
    case = cbpt.Case.from_toml(cbpt.example_case() + f'[measurement]\nzero = "{zero}"\n')
    c = compare(case, columns)
    solved = int(c.model.has_solution.sum())
    failed = sum(len(lines) for lines in c.without_solution.values())
    assert solved + failed == n == len(c.readings) == len(c.rows()[1])
    assert (c.overall.readings if c.overall else 0) == solved
    strictly(c.to_json())
    if c.overall is None:
        assert c.groups == ()
        return
    assert abs(c.overall.bias_arcsec) <= c.overall.rmse_arcsec * (1 + 1e-12)
    assert c.overall.rmse_arcsec <= abs(c.overall.largest_error_arcsec) * (1 + 1e-12)
    total = np.nansum(c.residual_arcsec**2)
    for column in {group.column for group in c.groups}:
        groups = by(c, column).values()
        assert sum(group.misfit.readings for group in groups) == solved
        share = sum(group.share_of_misfit for group in groups)
        assert share == pytest.approx(1 if total else 0, abs=1e-9)
