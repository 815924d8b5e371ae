"""The model held against readings: what a comparison says must be so.

Groups: readings made from the model itself; what has no solution; what is refused; forms (text,
JSON, rows, pickle).
"""

from __future__ import annotations

import csv
import json
import pickle
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt import compare, read_readings
from common.comparisons import (
    ARCSEC,
    CAMPAIGNS,
    EXAMPLES,
    UNLIKE,
    base,
    by,
    case_of,
    columns_of,
    compared,
    excess,
    model,
    strictly,
    synthetic,
)

# --- readings made from the model itself --------------------------------------------------


def test_the_model_agrees_with_itself() -> None:
    c = compare(base(), synthetic(base()))
    assert c.overall is not None
    assert c.overall.rmse_arcsec == c.overall.bias_arcsec == c.overall.chi2_per_dof == 0
    assert c.p_value == 1
    assert [group.share_of_misfit for group in c.groups] == [0.0] * len(c.groups)
    assert "residuals are far smaller than the stated uncertainty" in c.report()


@pytest.mark.parametrize("offset", [0.25, -3.0])
def test_an_offset_is_a_bias_and_no_excess(offset: float) -> None:
    c = compare(base(), synthetic(base(), offset=offset))
    assert c.overall is not None
    assert c.overall.bias_arcsec == pytest.approx(offset, rel=1e-12)
    assert c.overall.rmse_arcsec == pytest.approx(abs(offset), rel=1e-12)
    assert c.overall.excess_arcsec == pytest.approx(0, abs=1e-12)
    assert c.overall.chi2_per_dof == pytest.approx((offset / 0.5) ** 2, rel=1e-12)
    assert c.best_common_zero_arcsec == pytest.approx(offset, rel=1e-12)
    assert c.rmse_with_best_zero_arcsec == pytest.approx(0, abs=1e-12)
    for group in c.groups:
        assert group.misfit.bias_arcsec == pytest.approx(offset, rel=1e-12)


@pytest.mark.parametrize("gain", [1.1, 0.9])
def test_a_gain_is_an_excess_and_no_bias(gain: float) -> None:
    drive, columns = base(), synthetic(base(), gain=gain)
    c = compare(drive, columns)
    size = np.abs(model(drive, columns))
    loaded = columns["torque_Nm"] != 0
    assert c.overall is not None
    assert c.overall.bias_arcsec == pytest.approx(0, abs=0.02)
    assert c.overall.excess_arcsec == pytest.approx((gain - 1) * size[loaded].mean(), rel=1e-9)
    assert c.overall.rmse_arcsec == pytest.approx(abs(gain - 1) * np.sqrt(np.mean(size**2)))
    assert ("beyond the model" if gain > 1 else "short of the model") in c.report()


def test_a_zero_of_each_run_is_its_weighted_mean() -> None:
    drive, columns = base(), synthetic(base())
    n = len(columns["torque_Nm"])
    rng = np.random.default_rng(7)
    columns["run"] = np.where(np.arange(n) < 20, "one", "two")
    offset = np.where(columns["run"] == "one", 5.0, -2.0)
    noise = rng.normal(0, 0.3, n)
    u = rng.uniform(0.2, 0.6, n)
    columns["u_elastic_angle_arcsec"] = u
    columns["elastic_angle_arcsec"] += offset + noise
    case = cbpt.Case.from_toml(cbpt.example_case() + '[measurement]\nzero = "per_run"\n')
    c = compare(case, columns)
    raw, left = offset + noise, np.empty(n)
    assert list(c.zero_arcsec) == ["one", "two"]
    for run, zero in c.zero_arcsec.items():
        rows = columns["run"] == run
        assert zero == pytest.approx(np.average(raw[rows], weights=u[rows] ** -2.0))
        left[rows] = raw[rows] - zero
    np.testing.assert_allclose(c.residual_arcsec, left, rtol=0, atol=1e-11)
    assert c.overall is not None
    assert c.overall.chi2_per_dof == pytest.approx(np.sum((left / u) ** 2) / (n - 2))
    # The best common zero is what is left for it, and the runs have taken it all.
    assert c.best_common_zero_arcsec == pytest.approx(0, abs=1e-11)
    assert compare(drive, columns).zero == "common"


def test_without_an_uncertainty_nothing_is_judged() -> None:
    columns = synthetic(base(), offset=1.0)
    del columns["u_elastic_angle_arcsec"]
    c = compare(base(), columns)
    assert c.overall is not None
    assert c.p_value is None and c.overall.chi2_per_dof is None
    assert all(group.misfit.chi2_per_dof is None for group in c.groups)
    assert c.overall.bias_arcsec == pytest.approx(1)
    assert "no uncertainty is stated" in c.report()
    assert any("u_elastic_angle_arcsec" in note for note in c.readings.notes)
    assert "u_elastic_angle_arcsec" not in c.rows()[0]


def test_one_reading() -> None:
    columns = {name: values[-1:] for name, values in synthetic(base(), offset=1.0).items()}
    c = compare(base(), columns)
    assert c.overall is not None
    assert (c.overall.readings, c.groups, c.worst()) == (1, (), None)
    assert c.overall.bias_arcsec == pytest.approx(1) == c.overall.excess_arcsec
    assert c.overall.chi2_per_dof == pytest.approx(4)
    assert c.p_value == pytest.approx(0.0455, abs=1e-4)  # beyond 2 sigma, both sides
    assert "1 reading" in c.report()


def test_torque_to_either_side_and_none() -> None:
    columns = synthetic(base(), torque=[-6, 0, 6])
    columns["elastic_angle_arcsec"] += 2.0 * np.sign(columns["torque_Nm"]) + 0.5
    groups = by(compare(base(), columns), "torque_Nm").values()
    assert [g.label for g in groups] == ["-6", "0", "6"]
    assert [g.misfit.bias_arcsec for g in groups] == pytest.approx([-1.5, 0.5, 2.5])
    assert [excess(g) for g in groups] == pytest.approx([1.5, 0, 2.5])
    only_zero = compare(base(), synthetic(base(), torque=[0.0]))
    assert only_zero.overall is not None and only_zero.overall.excess_arcsec == 0


def test_rows_out_of_time_order_keep_their_lines(tmp_path: Path) -> None:
    columns = synthetic(base())
    n = len(columns["torque_Nm"])
    columns["time_s"] = np.arange(n, dtype=float)
    columns["run"] = np.ones(n)
    columns["elastic_angle_arcsec"][11] += 40
    order = np.random.default_rng(3).permutation(n)
    path = tmp_path / "shuffled.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(values[order].tolist() for values in columns.values()), strict=True))
    c = compare(base(), path)
    assert c.overall is not None
    assert c.overall.largest_error_arcsec == pytest.approx(40)
    assert c.overall.largest_error_line == order.tolist().index(11) + 2
    straight = compare(base(), columns)
    np.testing.assert_allclose(c.residual_arcsec, straight.residual_arcsec, rtol=0, atol=1e-12)


# --- what has no solution -----------------------------------------------------------------


def test_a_reading_beyond_hold_is_named_and_never_dropped() -> None:
    columns = synthetic(base(), offset=0.5)
    columns["torque_Nm"][[3, 20]] = [90.0, -90.0]
    c = compare(base(), columns)
    assert c.without_solution == {"beyond_hold": [4, 21]}
    assert c.overall is not None and c.overall.readings == len(c.readings) - 2
    assert c.overall.bias_arcsec == pytest.approx(0.5)
    assert np.flatnonzero(np.isnan(c.residual_arcsec)).tolist() == [3, 20]
    assert "no solution at 2 readings (beyond_hold), which are left out: rows 4, 21" in c.report()
    assert re.search(r"largest error .* on row \d+;", c.report())
    names, rows = c.rows()
    gone = dict(zip(names, rows[3], strict=True))
    assert gone["status"] == "beyond_hold"
    assert gone["model_elastic_angle_arcsec"] is None and gone["residual_arcsec"] is None
    assert gone["elastic_angle_arcsec"] == columns["elastic_angle_arcsec"][3]
    for group in c.groups:  # a group in which nothing was solved says nothing
        assert group.misfit.readings > 0


def test_where_nothing_has_a_solution_it_says_so() -> None:
    columns = synthetic(base())
    columns["torque_Nm"] = columns["torque_Nm"] * 0 + 500.0
    c = compare(base(), columns)
    assert c.overall is None and c.groups == () and c.p_value is None and c.worst() is None
    assert len(c.without_solution["beyond_hold"]) == len(c.readings)
    assert "Nothing can be compared" in c.report()
    document = strictly(c.to_json())
    assert document["overall"] is None and document["best_common_zero_arcsec"] is None


def test_an_undercut_drive_is_compared_with_nothing() -> None:
    text = cbpt.example_case().replace("ball_radius_mm = 1.5", "ball_radius_mm = 20", 1)
    c = compare(cbpt.Drive.from_toml(text), synthetic(base()))
    assert list(c.without_solution) == ["undercut"]


def test_a_bias_that_was_subtracted_is_nought() -> None:
    """And no rounding error such as 3e-14 arcsec."""
    c = compare(EXAMPLES / "reducer.toml", EXAMPLES / "reducer.csv")
    assert c.overall is not None
    assert c.overall.bias_arcsec == 0.0
    assert c.overall.rmse_arcsec > 100


def test_a_run_without_solution_gets_no_zero() -> None:
    columns = synthetic(base(), offset=0.5)
    columns["run"] = np.where(columns["torque_Nm"] > 7, 2, 1)
    columns["torque_Nm"] = np.where(columns["run"] == 2, 200.0, columns["torque_Nm"])
    case = cbpt.Case.from_toml(cbpt.example_case() + '[measurement]\nzero = "per_run"\n')
    c = compare(case, columns)
    assert c.zero_arcsec == {"1": pytest.approx(0.5)}


# --- what is refused ----------------------------------------------------------------------


def test_what_cannot_be_compared_is_refused() -> None:
    columns = synthetic(base())
    with pytest.raises(cbpt.ReadingsError, match="preload_N"):
        compare(base(), {k: v for k, v in columns.items() if k != "preload_N"})
    without = read_readings(
        {k: v for k, v in columns.items() if k != "preload_N"}, need_preload=False
    )
    with pytest.raises(cbpt.ReadingsError, match="preload"):
        compare(base(), without)
    with pytest.raises(cbpt.CaseError, match=r"no_such\.toml"):
        compare("no_such.toml", columns)
    with pytest.raises(cbpt.ReadingsError, match=r"no_such\.csv"):
        compare(base(), "no_such.csv")
    with pytest.raises(TypeError, match="int"):
        compare(base(), 7)  # type: ignore[arg-type]


@pytest.mark.parametrize("verb", [compare, cbpt.diagnose])
def test_a_table_in_place_of_the_case_is_told_so(verb: Callable[..., object]) -> None:
    with pytest.raises(cbpt.InvalidInputError, match=r"the case comes first: .*toml, then .*csv"):
        verb(CAMPAIGNS / "dev03.csv", CAMPAIGNS / "dev03.toml")


def test_an_effect_of_the_case_is_part_of_the_model() -> None:
    plain = compare(case_of("dev03", ""), CAMPAIGNS / "dev03.csv")
    torsion = '[[effect]]\nid = "output_torsion"\ncompliance_arcsec_per_Nm = 0.5\n'
    with_it = compare(case_of("dev03", torsion), CAMPAIGNS / "dev03.csv")
    change = plain.residual_arcsec - with_it.residual_arcsec
    np.testing.assert_allclose(change, 0.5 * plain.readings.torque_Nm, atol=1e-9)


def test_an_effect_without_a_size_is_said_to_do_nothing() -> None:
    found = compare(
        case_of("dev03", '[[effect]]\nid = "output_torsion"\n'), CAMPAIGNS / "dev03.csv"
    )
    (hint,) = (hint for hint in found.hints if "output_torsion" in hint)
    assert "does nothing" in hint and "compliance_arcsec_per_Nm" in hint


def test_torques_of_the_input_side_are_asked_about() -> None:
    columns = synthetic(base(), torque=[-6, -3, 0, 3, 6])
    columns["torque_Nm"] = columns["torque_Nm"] / 10.5
    (hint,) = compare(base(), columns).hints
    assert "input side" in hint and "10.5" in hint
    assert compare(base(), synthetic(base(), torque=[-6, -3, 0, 3, 6])).hints == ()


def test_computed_angles_have_no_scatter() -> None:
    """The first check that anybody makes: the model against itself, without any uncertainty."""
    columns = synthetic(base())
    del columns["u_elastic_angle_arcsec"]
    report = compare(base(), columns).report()
    assert "scatter" not in report and "largest at" not in report


def test_an_own_effect_of_the_case_is_part_of_the_model() -> None:
    own = (
        '[[effect]]\nid = "mine"\nport = "series"\nexpression = "a * torque_Nm"\n'
        'parameters = { a = { unit = "rad/(N m)", start = 1e-6 } }\n'
    )
    plain = compare(case_of("dev03", ""), CAMPAIGNS / "dev03.csv")
    with_it = compare(case_of("dev03", own), CAMPAIGNS / "dev03.csv")
    change = np.deg2rad((plain.residual_arcsec - with_it.residual_arcsec) / 3600)
    np.testing.assert_allclose(change, 1e-6 * plain.readings.torque_Nm, atol=1e-14)
    assert [(n.effect, n.name, n.value) for n in with_it.numbers] == [("mine", "a", 1e-6)]


def test_what_progress_raises_stops_the_comparison() -> None:
    def stop(done: int, total: int) -> None:
        assert 0 <= done <= total == 40_002
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compare(base(), synthetic(base(), torque=np.linspace(-8, 8, 20_001)), progress=stop)


def test_a_case_may_be_a_dict() -> None:
    """As everywhere, and with what belongs to it: here the preload of its load."""
    columns = synthetic(base())
    rows = columns["preload_N"] == 400
    data = {name: values[rows] for name, values in columns.items() if name != "preload_N"}
    case = tomllib.loads(cbpt.example_case()) | {"load": {"preload_N": 400}}
    c = compare(case, data)
    np.testing.assert_allclose(c.residual_arcsec, 0, atol=1e-9)
    with pytest.raises(cbpt.CaseError, match="deceleration"):
        compare({}, data)
    with pytest.raises(TypeError, match="not from int"):
        compare(7, data)  # type: ignore[arg-type]


# --- forms --------------------------------------------------------------------------------


@UNLIKE
def test_json_holds_what_the_object_holds(name: str) -> None:
    c = compared(name)
    document = strictly(c.to_json())
    assert document == json.loads(json.dumps(c.to_dict()))
    assert document["schema"] == "cbpt.compare/1"
    assert document["readings"] == len(c.readings)
    assert document["p_value"] == c.p_value
    assert c.overall is not None
    for key, value in document["overall"].items():
        assert getattr(c.overall, key) == value
    assert [group["label"] for group in document["groups"]] == [group.label for group in c.groups]
    assert document["data_sha256"] == c.readings.sha256 and len(c.readings.sha256) == 64
    assert set(document["versions"]) == {"cbpt", "numpy", "scipy", "python"}


def test_rows_stand_beside_their_readings() -> None:
    c, columns = compared("dev03"), columns_of("dev03")
    names, rows = c.rows()
    assert all(len(row) == len(names) for row in rows) and len(rows) == len(c.readings)
    table = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    for name in columns.keys() & table.keys():
        assert table[name] == columns[name].tolist(), name
    assert table["line"] == list(range(2, len(rows) + 2))
    assert table["residual_arcsec"] == c.residual_arcsec.tolist()
    left = np.array(table["elastic_angle_arcsec"]) - np.array(table["model_elastic_angle_arcsec"])
    np.testing.assert_array_equal(left, c.residual_arcsec)
    assert set(table["status"]) == {"ok"}
    assert table["direction"] == c.readings.direction().tolist()


def test_the_report_is_in_the_unit_that_is_asked_for() -> None:
    c = compared("dev03")
    assert repr(c) == c.report() == c.report("arcsec")
    assert "RMSE 2.48 arcsec" in c.report()
    assert f"RMSE {2.4839 / 60:.3g} arcmin" in c.report("arcmin")
    assert "RMSE 12 urad" in c.report("urad")
    assert "mrad ┆" in c.report("mrad") and "arcsec" not in c.report("mrad")


def test_everything_is_pickled() -> None:
    c = compared("dev03")
    again = pickle.loads(pickle.dumps(c))
    assert again.report() == c.report() and again.to_json() == c.to_json()
    np.testing.assert_array_equal(again.residual_arcsec, c.residual_arcsec)
    np.testing.assert_array_equal(again.model.status, c.model.status)
    assert pickle.loads(pickle.dumps(c.groups)) == c.groups


def test_cases_drives_and_readings_come_in_any_form() -> None:
    case, data = CAMPAIGNS / "dev03.toml", CAMPAIGNS / "dev03.csv"
    expected = compared("dev03").residual_arcsec
    for of in (str(case), cbpt.Case.from_file(case), cbpt.Drive.from_file(case)):
        for readings in (str(data), read_readings(data), columns_of("dev03")):
            np.testing.assert_allclose(
                compare(of, readings).residual_arcsec, expected, rtol=0, atol=1e-11
            )


def test_columns_and_lever_arm_are_handed_on() -> None:
    columns = synthetic(base(), offset=0.5)
    moved = {"Moment": columns["torque_Nm"], **columns}
    del moved["torque_Nm"]
    c = compare(base(), moved, columns={"Moment": "torque_Nm"})
    assert c.overall is not None and c.overall.bias_arcsec == pytest.approx(0.5)
    # A sensor that touches at a radius of 80 mm instead of an angle.
    angle = columns.pop("elastic_angle_arcsec")
    del columns["u_elastic_angle_arcsec"]
    columns["sensor_displacement_um"] = 80e3 * np.tan(angle * ARCSEC)
    case = cbpt.Case.from_toml(cbpt.example_case() + "[measurement]\nlever_arm_mm = 80\n")
    c = compare(case, columns)
    assert c.overall is not None and c.overall.bias_arcsec == pytest.approx(0.5, rel=1e-9)


def test_a_table_in_another_unit_is_no_agreement(tmp_path: Path) -> None:
    """Preloads of kN under preload_N: the few readings that are left agree by chance."""
    lines = (EXAMPLES / "campaign.csv").read_text().splitlines()
    column = lines[0].split(",").index("preload_N")
    rows = [line.split(",") for line in lines[1:]]
    for row in rows:
        row[column] = str(float(row[column]) / 1000)
    table = tmp_path / "kN.csv"
    table.write_text("\n".join([lines[0], *(",".join(row) for row in rows)]) + "\n")
    report = compare(EXAMPLES / "campaign.toml", table).report()
    assert "agrees" not in report
    assert "check the units of torque and preload" in report
    lines = [
        line.replace("u_elastic_angle_arcsec", "no_u") for line in table.read_text().split("\n")
    ]
    table.write_text("\n".join(lines))
    report = compare(EXAMPLES / "campaign.toml", table).report()
    assert "agrees" not in report and "check the units of torque and preload" in report


def test_the_load_of_the_case_fills_in_what_the_table_lacks(tmp_path: Path) -> None:
    case = (EXAMPLES / "campaign.toml").read_text()
    case += "\n[load]\npreload_N = 420\ninput_angle_deg = 40\n"
    data = {"torque_Nm": [1.0, 2.0], "elastic_angle_arcsec": [6.0, 12.0]}
    c = compare(cbpt.Case.from_toml(case), data)
    assert c.readings.preload_N is not None
    assert c.readings.preload_N.tolist() == [420, 420]
    assert c.readings.input_angle_deg.tolist() == [40, 40]
    assert "no preload_N column: 420 is used for every reading" in c.report()


def test_angles_that_cannot_be_are_refused() -> None:
    data = {"torque_Nm": [1.0], "preload_N": [600.0], "elastic_angle_arcsec": [1e200]}
    with pytest.raises(cbpt.ReadingsError, match="180 deg"):
        compare(EXAMPLES / "campaign.toml", data)


def test_a_drive_has_no_place_for_effects() -> None:
    text = cbpt.example_case() + '\n[[effect]]\nid = "creep"\ncompliance_rad_per_Nm = 1e-7\n'
    with pytest.raises(cbpt.CaseError, match="creep"):
        cbpt.Drive.from_toml(text)
    assert cbpt.Case.from_toml(text).drive == cbpt.Drive.from_toml(cbpt.example_case())
