"""Sweeps over any parameter: values, designs, labels, and what cannot be swept."""

from __future__ import annotations

import itertools
import math
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt import Case, CaseError, Drive, PlanError, SweepPlan, sweep
from cbpt._core import sweep_findings, sweep_statuses
from cbpt.sweeps.result import cf_unit
from cbpt.sweeps.run import _rate
from common.drives import base_case

EFFECT = {"id": "eccentric_bearing", "reference_deflection_um": 2.0}
OWN = {
    "id": "mine",
    "port": "series",
    "expression": "a * torque_Nm",
    "parameters": {"a": {"unit": "rad/(N m)", "start": 1e-6, "min": 0.0, "max": 1e-3}},
}
BLOCK = 8192


def case(**sections: Any) -> Case:
    load = {"torque_Nm": 5, "preload_N": 600}
    return Case.from_dict(base_case() | {"load": load} | sections)


def test_a_case_may_be_the_name_of_its_file(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(case().to_toml())
    axes = {"load.torque_Nm": [1, 2]}
    wanted = sweep(case(), axes).elastic_angle_arcsec
    for name in (path, str(path)):
        assert list(sweep(name, axes).elastic_angle_arcsec) == list(wanted)
    with pytest.raises(PlanError, match="give what varies"):
        sweep(path)
    with pytest.raises(CaseError, match=r"none\.toml: file not found"):
        sweep(tmp_path / "none.toml", axes)
    plan = tmp_path / "plan.toml"
    plan.write_text('case = "case.toml"\n[axes]\nload.torque_Nm = [1, 2]\n')
    assert len(sweep(plan)) == 2
    with pytest.raises(PlanError, match="already has axes"):
        sweep(plan, axes)


def test_the_page_names_every_column_and_status(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "docs" / "how-to" / "sweeps.md").read_text()
    rows = [
        [cell.strip(" `") for cell in line.split("|")[1:-1]]
        for line in text.split("\n## Columns\n")[1].split("\n## ")[0].splitlines()
        if line.startswith("| `")
    ]
    columns = {name: (unit, of) for name, unit, of, _ in (row for row in rows if len(row) == 4)}
    assert [row[0] for row in rows if len(row) == 3] == sweep_statuses()
    spring = Case.from_dict({"torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 5.0}})
    varied = {"equal_speed.ball_count": [14]}
    for drive, axes, out in (
        (case(), {}, "all.csv"),
        (case(), varied, "each.csv"),
        (spring, {}, "spring.csv"),
    ):
        found = sweep(drive, {"load.torque_Nm": [1.0], **axes}, out=tmp_path / out)
        header = (tmp_path / out).read_text().splitlines()[0].split(",")[1 + len(axes) :]
        kept = ["all", "ball drive"] if found.plan.has_pairs else ["all"]
        kept += ["ball drive that varies"] if axes else []
        assert [name for name, (_, of) in columns.items() if of in kept] == header
        data = found.to_xarray()
        for name, (unit, _) in columns.items():
            assert name not in header or unit == data[name].attrs.get("units", "")


@pytest.mark.parametrize(
    ("rate", "text"), [(0.2567, "0.257"), (99.96, "100"), (1096712.3, "1,100,000")]
)
def test_a_rate_has_three_digits(rate: float, text: str) -> None:
    assert _rate(rate) == text


# --- the values are those of single cases -------------------------------------------------


def test_each_row_tells_whether_its_drive_can_be_built() -> None:
    found = sweep(
        case(),
        {
            "load.torque_Nm": [1, 2],
            "equal_speed.ball_radius_mm": [1.5, 4, 12],
            "equal_speed.ball_count": [14, 60],
            "deceleration.short_amplitude_coefficient": [0.5, 0.9],
        },
    )
    solved = 0
    for row in range(len(found)):
        made = base_case()
        for name in found.plan.names[1:]:
            section, key = name.split(".")
            value = float(found.axis(name)[row])
            made[section] = made[section] | {key: int(value) if key == "ball_count" else value}
        findings = Drive.from_dict(made).findings()
        errors = [finding.code for finding in findings if finding.severity == "error"]
        assert found.finding[row] == (errors or [""])[0]
        solved += bool(errors) and found.status[row] == "ok"
    assert solved > 0
    assert {"", "undercut", "rings_overlap"} <= set(found.finding) <= set(sweep_findings())
    data, table = found.to_xarray(), found.to_pandas()
    words = np.array(data.finding.attrs["flag_meanings"].split())
    told = words[found.rows.finding]
    assert [word if word != "none" else "" for word in told] == list(found.finding)
    assert list(table.finding.astype(object).fillna("")) == list(found.finding)


def test_of_one_drive_there_is_a_warning_and_no_column() -> None:
    fat = base_case()
    fat["equal_speed"] = fat["equal_speed"] | {"ball_radius_mm": 12}
    with pytest.warns(UserWarning, match=r"cannot be built \((rings_overlap|balls_touch)\)"):
        found = sweep(case(**fat), {"load.torque_Nm": [1, 2]})
    assert list(found.finding) == ["", ""]
    assert "finding" not in found.to_xarray()


def changed(name: str, value: float | str) -> dict[str, Any]:
    """The base case as a dict, with one key set."""
    made: dict[str, Any] = base_case() | {"load": {"torque_Nm": 5.0, "preload_N": 600.0}}
    section, key = name.split(".")
    unit = key.rsplit("_", 1)[-1]
    stem = key.removesuffix(unit) if unit in ("mm", "deg", "Nm", "kN", "GPa") else key
    kept = {k: v for k, v in made.get(section, {}).items() if not k.startswith(stem)}
    return made | {section: kept | {key: value}}


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("deceleration.short_amplitude_coefficient", [0.3, 0.45, 0.52]),
        ("deceleration.ball_count", [18, 20, 22]),
        ("deceleration.rolling_circle_radius_mm", [3.9, 4.2]),
        ("deceleration.contact_angle_deg", [30, 60]),
        ("deceleration.output_plate", ["hypocycloid", "epicycloid"]),
        ("equal_speed.contact_angle_deg", [40, 50]),
        ("equal_speed.pitch_radius_mm", [35, 50]),
        ("material.youngs_modulus_GPa", [70, 208]),
        ("material.ball_youngs_modulus_GPa", [70, 300]),
        ("load.torque_Nm", [-5, 0, 5]),
        ("load.preload_kN", [0.2, 0.9]),
        ("load.input_angle_deg", [0, 3, 7]),
    ],
)
def test_a_row_is_the_case_with_its_numbers(name: str, values: list[Any]) -> None:
    found = sweep(case(), {name: values})
    assert list(found.status) == ["ok"] * len(values)
    for value, angle in zip(values, found.elastic_angle_arcsec, strict=True):
        made = Case.from_dict(changed(name, value))
        assert made.torque_Nm is not None and made.preload_N is not None
        alone = made.drive.solve(made.torque_Nm, made.preload_N, made.input_angle_deg or 0.0)
        assert angle == pytest.approx(alone.elastic_angle_arcsec, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "key", "values"),
    [
        ("effect.eccentric_bearing.reference_deflection_um", "reference_deflection_um", [0, 1, 3]),
        ("effect.eccentric_bearing.exponent", "exponent", [0.67, 0.9]),
    ],
)
def test_numbers_of_effects_are_swept(name: str, key: str, values: list[float]) -> None:
    found = sweep(case(effect=[EFFECT]), {name: values})
    for value, angle in zip(values, found.elastic_angle_arcsec, strict=True):
        alone = cbpt.solve_many(case(effect=[EFFECT | {key: value}]), 5, 600)
        assert angle == pytest.approx(float(alone.elastic_angle_arcsec), rel=1e-12)


def test_the_second_of_a_kind_and_own_effects_have_names() -> None:
    both = case(effect=[EFFECT, OWN, EFFECT])
    bare = sweep(case(), {"load.torque_Nm": 5}).elastic_angle_arcsec[0]
    first, second = (f"effect.eccentric_bearing{n}.reference_deflection_um" for n in ("", "#2"))
    found = sweep(both, {first: 0.0, second: 0.0, "effect.mine.a": [0, 2e-6, 4e-6]})
    slope = 5 * 2e-6 * 648000 / math.pi
    assert found.elastic_angle_arcsec == pytest.approx(bare + slope * np.arange(3), rel=1e-12)


def test_a_torsion_spring_is_swept_too() -> None:
    spring = Case.from_dict({"torsion_spring": {"torsional_stiffness_Nm_per_rad": 1e4}})
    axes = {"torsion_spring.torsional_stiffness_Nm_per_rad": [1e4, 2e4], "load.torque_Nm": [1, 3]}
    found = sweep(spring, axes)
    assert found.rows.found.keys() == {"elastic_angle_arcsec"}
    angle = np.array([1, 3, 0.5, 1.5]) / 1e4 * 648000 / math.pi
    assert found.elastic_angle_arcsec == pytest.approx(angle, rel=1e-12)


def test_a_row_without_solution_is_nan_with_its_status() -> None:
    found = sweep(case(), {"load.torque_Nm": [5, 500]})
    assert list(found.status) == ["ok", "beyond_hold"]
    assert np.isnan(found.elastic_angle_arcsec[1]) and not found.has_solution[1]
    assert found.rows.found["hold_preload_N"][1] > 600
    undercut = sweep(case(), {"deceleration.short_amplitude_coefficient": [0.5, 0.95]})
    assert list(undercut.status) == ["ok", "undercut"]


def test_numbers_that_cannot_be_together_are_a_status() -> None:
    """A cross-slide needs the hypocycloid plate; each word alone is allowed."""
    slide = case(equal_speed=base_case()["equal_speed"] | {"kind": "cross_slide"})
    found = sweep(slide, {"deceleration.output_plate": ["hypocycloid", "epicycloid"]})
    assert list(found.status) == ["ok", "invalid_input"]
    kinds = sweep(case(), {"equal_speed.kind": ["ring_groove", "cross_slide"]})
    assert list(kinds.status) == ["ok", "ok"]


# --- designs ------------------------------------------------------------------------------

AXES: dict[str, Any] = {"load.torque_Nm": (1.0, 9.0), "load.preload_N": (200.0, 2000.0, "log")}


def test_a_grid_has_the_load_fastest_and_its_dimensions_in_the_order_given() -> None:
    torque, k, preload = [1.0, 2, 3], [0.4, 0.5], [500.0, 700]
    names = ("load.torque_Nm", "deceleration.short_amplitude_coefficient", "load.preload_N")
    found = sweep(case(), dict(zip(names, (torque, k, preload), strict=True)))
    assert list(found.axis(names[0])) == torque * 4
    assert list(found.axis(names[2])) == [500, 500, 500, 700, 700, 700] * 2
    assert list(found.axis(names[1])) == [0.4] * 6 + [0.5] * 6
    angles = found.to_xarray().elastic_angle_arcsec
    assert angles.dims == tuple(name.replace(".", "_") for name in names)
    assert angles.shape == (3, 2, 2)
    for i, j, l in np.ndindex(3, 2, 2):  # noqa: E741
        row = (
            (found.axis(names[0]) == torque[i])
            & (found.axis(names[1]) == k[j])
            & (found.axis(names[2]) == preload[l])
        )
        assert angles.values[i, j, l] == found.elastic_angle_arcsec[row][0]


@pytest.mark.parametrize("design", ["random", "latin_hypercube"])
def test_drawn_rows_lie_within_their_bounds_and_follow_the_seed(design: str) -> None:
    kinds = {"deceleration.ball_count": (18, 21), "deceleration.output_plate": ["hypocycloid"]}
    made = sweep(case(), AXES | kinds, design=design, rows=500, seed=3)
    torque, preload = made.axis("load.torque_Nm"), made.axis("load.preload_N")
    assert ((torque >= 1) & (torque <= 9)).all() and ((preload >= 200) & (preload <= 2000)).all()
    # On a logarithmic scale the median is the geometric mean of the bounds.
    assert np.median(preload) == pytest.approx(math.sqrt(200 * 2000), rel=0.15)
    assert set(made.axis("deceleration.ball_count")) == {18, 19, 20, 21}
    again = sweep(case(), AXES | kinds, design=design, rows=500, seed=3)
    other = sweep(case(), AXES | kinds, design=design, rows=500, seed=4)
    assert np.array_equal(again.axis("load.torque_Nm"), torque)
    assert not np.array_equal(other.axis("load.torque_Nm"), torque)


@pytest.mark.parametrize("rows", [1, 7, 1000])
def test_a_latin_hypercube_has_one_row_in_each_part_of_each_axis(rows: int) -> None:
    made = sweep(case(), AXES, design="latin_hypercube", rows=rows)
    for share in (
        (made.axis("load.torque_Nm") - 1) / 8,
        np.log(made.axis("load.preload_N") / 200) / np.log(10),
    ):
        assert sorted(np.floor(share * rows)) == list(range(rows))


def test_a_table_is_its_rows() -> None:
    rows = {"load.torque_Nm": [1, 5, 3], "deceleration.ball_radius_mm": [1.5, 1.4, 1.5]}
    made = sweep(case(), rows | {"load.preload_N": 700}, design="table")
    assert list(made.axis("load.torque_Nm")) == [1, 5, 3]
    assert list(made.axis("load.preload_N")) == [700] * 3
    assert made.to_xarray().elastic_angle_arcsec.dims == ("row",)


# --- who solves it makes no difference ----------------------------------------------------


@pytest.mark.parametrize(
    ("design", "ending", "start"),
    [
        ("latin_hypercube", ".csv", "fork"),
        ("latin_hypercube", None, "spawn"),
        ("table", ".csv", "fork"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*fork")  # of later Pythons; that it works is what is tested
def test_a_process_pool_gives_the_same_bytes(
    design: str, ending: str | None, start: str, tmp_path: Path
) -> None:
    rows = 2 * BLOCK + 100
    torque = np.linspace(-8, 8, rows)
    axes: dict[str, Any] = {"load.torque_Nm": torque, "load.input_angle_deg": np.zeros(rows)}
    drawn = design != "table"
    plan = sweep_plan(AXES if drawn else axes, design, rows if drawn else None)
    sweep(plan)  # so that a fork leaves threads behind
    with ProcessPoolExecutor(2, mp_context=get_context(start)) as pool:
        same(plan, pool, ending, tmp_path)


def test_threads_and_any_chunks_give_the_same(tmp_path: Path) -> None:
    plan = sweep_plan(AXES, "random", 3 * BLOCK)
    with ThreadPoolExecutor(3) as pool:
        same(plan, pool, ".csv", tmp_path)
    whole = sweep(plan, out=tmp_path / "whole.csv", chunk_rows=10 * BLOCK).path
    parts = sweep(plan, out=tmp_path / "parts.csv", chunk_rows=1).path
    assert whole is not None and parts is not None
    assert whole.read_bytes() == parts.read_bytes()


@pytest.mark.filterwarnings("ignore")  # of Dask itself
def test_dask_gives_the_same_bytes(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    plan = sweep_plan(AXES, "latin_hypercube", 3 * BLOCK + 5)
    quiet = {"dashboard_address": None, "silence_logs": 50}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster,
        distributed.Client(cluster) as client,
    ):
        same(plan, client.get_executor(), ".csv", tmp_path)
        same(plan, client.get_executor(), None, tmp_path)


def sweep_plan(axes: dict[str, Any], design: str, rows: int | None) -> SweepPlan:
    def given(values: Any) -> Any:
        between = isinstance(values, tuple)
        return (*values[:2], "log" in values) if between else np.asarray(values, float)

    listed = [(name, given(values)) for name, values in axes.items()]
    return SweepPlan(case(), listed, design, rows, 1)


def same(plan: SweepPlan, executor: Any, ending: str | None, directory: Path) -> None:
    if ending is None:
        here, there = sweep(plan), sweep(plan, executor=executor, chunk_rows=BLOCK)
        for one, other in zip(here.rows.axes, there.rows.axes, strict=True):
            assert np.array_equal(one, other)
        for name, column in here.rows.found.items():
            assert np.array_equal(column, there.rows.found[name], equal_nan=True)
        assert np.array_equal(here.rows.status, there.rows.status)
        return
    files = [directory / f"{name}{ending}" for name in ("here", "there")]
    sweep(plan, out=files[0])
    sweep(plan, out=files[1], executor=executor, chunk_rows=BLOCK)
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_plan_is_kept_to_the_last_bit() -> None:
    for plan in (
        sweep_plan(AXES, "random", 100),
        sweep_plan({"load.torque_Nm": np.random.default_rng(1).random(2000)}, "table", None),
    ):
        kept = pickle.loads(pickle.dumps(plan))
        assert kept.record == plan.record
        for one, other in zip(kept.solve(0, 100)[0], plan.solve(0, 100)[0], strict=True):
            assert np.array_equal(one, other)


def test_work_under_way_is_bounded() -> None:
    """A slow reader must not have the whole sweep in memory."""
    begun: list[int] = []

    class Counting(ThreadPoolExecutor):
        def submit(self, work: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
            begun.append(args[1])
            return super().submit(work, *args, **kwargs)

    most: list[int] = []

    def progress(done: int, total: int) -> None:
        most.append(len(begun) - done // BLOCK)

    with Counting(1) as pool:
        plan = sweep_plan(AXES, "random", 12 * BLOCK)
        sweep(plan, executor=pool, in_flight=3, chunk_rows=BLOCK, progress=progress)
    assert len(begun) == 12 and max(most) <= 3


def test_progress_is_told_and_stops_the_sweep() -> None:
    told: list[tuple[int, int]] = []
    plan = sweep_plan(AXES, "random", 3 * BLOCK)
    sweep(plan, progress=lambda done, total: told.append((done, total)), chunk_rows=BLOCK)
    assert told[-1] == (3 * BLOCK, 3 * BLOCK)
    assert all(a <= b for (a, _), (b, _) in itertools.pairwise(told))

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(plan, progress=stop)


# --- labels -------------------------------------------------------------------------------


def test_netcdf_keeps_it_all(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    axes = {
        "load.torque_Nm": [1.0, 500.0],
        "effect.eccentric_bearing.reference_deflection_um": [0.0, 2.0],
        "load.preload_N": 600,
        "deceleration.output_plate": ["hypocycloid", "epicycloid"],
    }
    made = sweep(case(effect=[EFFECT]), axes).to_xarray()
    made.to_netcdf(tmp_path / "sweep.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as read:
        xarray.testing.assert_identical(read.load(), made)
        assert read.attrs["Conventions"].startswith("CF-1.")
        assert read.load_torque_Nm.attrs["units"] == "N m"
        assert read.load_torque_Nm.attrs["key"] == "load.torque_Nm"
        assert read.load_preload_N.dims == () and read.load_preload_N == 600
        status = read.status
        assert status.attrs["flag_meanings"].split() == sweep_statuses()
        assert list(status.attrs["flag_values"]) == list(range(len(sweep_statuses())))
        assert (status.sel(load_torque_Nm=500) == sweep_statuses().index("beyond_hold")).all()
        for name in (*read.data_vars, *read.coords):
            assert str(name).isidentifier(), "a name that every reader of NetCDF takes"


def test_pandas_has_a_row_for_each(tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    axes = {"load.torque_Nm": [1, 500], "deceleration.output_plate": ["epicycloid"]}
    here = sweep(case(), axes).to_pandas()
    assert list(here["status"]) == ["ok", "beyond_hold"]
    assert list(here["load.torque_Nm"]) == [1, 500]
    for ending in (".csv", ".parquet"):
        there = sweep(case(), axes, out=tmp_path / f"t{ending}").to_pandas()
        assert here.equals(there)


@pytest.mark.parametrize(
    ("suffix", "unit"),
    [
        ("", "1"),
        ("Nm", "N m"),
        ("N_per_mm", "N mm-1"),
        ("per_arcsec2", "arcsec-2"),
        ("Nm_per_rad", "N m rad-1"),
        ("arcsec_per_Nm", "arcsec N-1 m-1"),
        ("deg", "degree"),
        ("rad/(N m)", "rad/(N m)"),
    ],
)
def test_units_are_those_of_udunits(suffix: str, unit: str) -> None:
    assert cf_unit(suffix) == unit


# --- what cannot be swept -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("axes", "told"),
    [
        ({"deceleration.short_amplitude_coeficient": [0.5]}, ["did you mean", "_coefficient"]),
        ({"decelaration.ball_count": [20]}, ["unknown section", "did you mean deceleration"]),
        ({"torque_Nm": [1]}, ["did you mean load.torque_Nm?"]),
        ({"load.torque": [1]}, ["needs a unit", "torque_Nm"]),
        ({"load.torque_lbft": [1]}, ["unit lbft is not read"]),
        ({"effect.creep.amplitude": [1]}, ['[[effect]] with id = "creep"']),
        ({"uncertainty.torque_gain_rel": [1]}, ["does not change the elastic angle"]),
        ({"torsion_spring.torsional_stiffness_Nm_per_rad": [1]}, ["has a ball drive"]),
        ({"deceleration.ball_count": [20.5]}, ["20.5", "whole number"]),
        ({"deceleration.contact_angle_deg": [45, 95]}, ["95", "less than 90"]),
        ({"load.preload_N": [0]}, ["load.preload_N", "0", "greater than 0"]),
        ({"load.torque_Nm": [math.nan]}, ["NaN", "finite number"]),
        ({"deceleration.output_plate": ["epicloid"]}, ["did you mean epicycloid?"]),
        ({"deceleration.output_plate": [1]}, ["epicycloid"]),
        ({"load.torque_Nm": ["much"]}, ["much", "finite number"]),
        ({"load.torque_Nm": []}, ["load.torque_Nm"]),
        ({"load.torque_Nm": [[1, 2]]}, ["2 dimensions"]),
        ({"load.torque_Nm": [1j]}, ["complex"]),
        ({"load.torque_Nm": [1], "load.torque_Nmm": [1]}, ["same value as load.torque_Nm"]),
        ({}, ["no axes"]),
    ],
)
def test_a_wrong_axis_is_told_with_the_remedy(axes: dict[str, Any], told: list[str]) -> None:
    with pytest.raises(PlanError) as caught:
        sweep(case(), axes)
    for words in told:
        assert words in str(caught.value)


def test_a_hidden_value_cannot_be_swept() -> None:
    angles = {"outside_contact_angle_deg": 40, "inside_contact_angle_deg": 50}
    pair = {k: v for k, v in base_case()["equal_speed"].items() if "contact_angle" not in k}
    with pytest.raises(PlanError, match="takes precedence"):
        sweep(case(equal_speed=pair | angles), {"equal_speed.contact_angle_deg": [30, 40]})


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"design": "sobol"}, "expected one of grid, random"),
        ({"design": "random"}, "rows: missing"),
        ({"rows": 5}, "rows: the axes of a grid"),
        ({"design": "random", "rows": 0}, "rows = 0"),
        ({"design": "random", "rows": 10**13}, "expected 1 to"),
        ({"seed": -1}, "seed = -1"),
        ({"out": "sweep.xlsx"}, "must end in .csv or .parquet"),
    ],
)
def test_a_wrong_setting_is_told(given: dict[str, Any], told: str) -> None:
    with pytest.raises(PlanError, match=told.replace(".", r"\.")):
        sweep(case(), {"load.torque_Nm": [1, 2]}, **given)


def test_a_load_must_be_complete() -> None:
    with pytest.raises(PlanError, match=r"load\.preload_N: missing"):
        sweep(Drive.from_dict(base_case()), {"load.torque_Nm": [1]})
    found = sweep(Drive.from_dict(base_case()), {"load.torque_Nm": [1], "load.preload_N": 500})
    assert found.has_solution.all()


def test_what_memory_cannot_hold_goes_to_a_file() -> None:
    with pytest.raises(PlanError, match="name a file with out="):
        sweep(case(), AXES, design="random", rows=10**9)


def test_a_table_of_unequal_columns_is_refused() -> None:
    axes = {"load.torque_Nm": [1, 2, 3], "load.preload_N": [500, 600]}
    with pytest.raises(PlanError, match=r"load\.preload_N: has 2 values, another axis has 3"):
        sweep(case(), axes, design="table")


def test_the_case_of_a_plan_file_is_read_by_its_own_parser(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text('case = "none.toml"\n[axes]\nload.torque_Nm = [1]\n')
    with pytest.raises((PlanError, CaseError), match=r"none\.toml: file not found"):
        sweep(tmp_path / "plan.toml")


def test_columns_that_leave_out_the_effects_say_so() -> None:
    preloads = {"load.preload_N": [500.0, 600.0]}
    with pytest.warns(UserWarning, match=r"efficiency .*without the effects .*eccentric_bearing"):
        found = sweep(case(effect=[EFFECT]), preloads, columns=["efficiency"])
    assert len(found.plan.remarks) == 1
    assert sweep(case(effect=[EFFECT]), preloads).plan.remarks == []
    assert sweep(case(), preloads, columns=["efficiency"]).plan.remarks == []
