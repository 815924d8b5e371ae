"""Work and memory grow with the readings of a table, not with readings times runs.

Counted, not timed: rows looked at, bytes held at once. `python benches/large_tables.py` has the
seconds. And what is quick gives what the plain formula gives.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.covariance.repeatability import Repeats, pooled
from cbpt.lab.diagnosis import misfit
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.readings.reader import Readings, read_readings

Floats = NDArray[np.float64]
CASE = cbpt.example_case()
RUNS, LENGTH = 4000, 5


def table(runs: int = RUNS, length: int = LENGTH, **more: Any) -> Readings:
    """Runs of a few torques, all alike."""
    return read_readings(
        {
            "run": np.repeat(np.arange(runs), length),
            "torque_Nm": np.tile(np.linspace(1, 5, length), runs),
            "preload_N": np.full(runs * length, 400.0),
            "elastic_angle_arcsec": np.random.default_rng(3).normal(size=runs * length),
        }
        | more
    )


def peak_bytes(work: Callable[[], object]) -> int:
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_repeats_need_no_matrix_of_runs() -> None:
    readings, y = table(), np.random.default_rng(0).normal(size=RUNS * LENGTH)
    pooled(readings, y)  # scipy is imported now
    assert peak_bytes(lambda: pooled(readings, y)) < 500 * len(readings) < 8 * RUNS**2


def test_a_zero_for_each_run_needs_no_columns_before_the_table_is_thinned() -> None:
    readings = table()
    case = cbpt.Case.from_toml(CASE + '\n[measurement]\nzero = "per_run"\n')
    made: list[Campaign] = []
    peak = peak_bytes(lambda: made.append(Campaign.of(case, readings)))
    assert peak < 500 * len(readings) < 8 * RUNS * len(readings)
    few = made[0].select(made[0].rows.thinned(100))
    assert few.offsets.shape == (len(few), few.rows.runs)
    assert np.array_equal(few.offsets.sum(axis=1), np.ones(len(few)))


def test_groups_look_at_a_row_once_a_column(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mask for each run would look at readings times runs."""
    readings, seen = table(), []
    plain = misfit.misfit_of

    def counted(r: Readings, residual: Floats, rows: NDArray[Any], fitted: int = 0) -> Any:
        seen.append(rows.size)
        return plain(r, residual, rows, fitted)

    monkeypatch.setattr(misfit, "misfit_of", counted)
    y = np.random.default_rng(0).normal(size=len(readings))
    groups = list(misfit.groups_of(readings, y, np.ones(len(y), dtype=bool)))
    assert sum(g.column == "run" for g in groups) == RUNS
    assert sum(seen) <= 5 * len(readings)


@pytest.mark.parametrize("zero", ["common", "per_run"])
def test_groups_and_zeros_are_those_of_a_mask_for_each_run(zero: str) -> None:
    """Runs interleaved and of several lengths, some readings without a solution."""
    rng = np.random.default_rng(1)
    run = rng.permutation(np.repeat(np.arange(40), np.arange(1, 41)))
    torque = np.where(rng.random(len(run)) < 0.1, 1e4, rng.integers(1, 5, len(run)))
    found = cbpt.compare(
        cbpt.Case.from_toml(CASE + f'\n[measurement]\nzero = "{zero}"\n'),
        {
            "run": [f"r{i}" for i in run],
            "torque_Nm": torque,
            "preload_N": np.full(len(run), 400.0),
            "elastic_angle_arcsec": 30 * torque * rng.normal(1, 0.1, len(run)),
            "u_elastic_angle_arcsec": rng.uniform(0.5, 1.5, len(run)),
        },
    )
    solved, u = found.model.has_solution, found.readings.u_elastic_angle_arcsec
    assert u is not None and not solved.all()
    raw = found.readings.elastic_angle_arcsec - found.model.elastic_angle_arcsec
    told = {g.label: g.misfit for g in found.groups if g.column == "run"}
    labels = set(found.readings.run[solved].tolist())
    assert set(told) == labels
    assert set(found.zero_arcsec) == (labels if zero == "per_run" else set())
    for label in labels:
        rows = solved & (found.readings.run == label)
        offset = np.average(raw[rows], weights=u[rows] ** -2.0) if zero == "per_run" else 0.0
        left = raw[rows] - offset
        assert told[label].readings == rows.sum()
        assert told[label].rmse_arcsec == pytest.approx(
            np.sqrt(np.mean(left**2)), rel=1e-9, abs=1e-9
        )
        if zero == "per_run":
            assert found.zero_arcsec[label] == pytest.approx(offset, rel=1e-9)


def test_repeats_are_those_of_the_full_least_squares() -> None:
    """Runs that share no condition with others, conditions in one run alone, runs by themselves."""
    rng = np.random.default_rng(2)
    run = rng.integers(0, 30, 400)
    torque = np.where(
        run < 12, rng.integers(1, 4, 400), 5 + rng.integers(0, 3, 400) + 3 * (run % 4)
    )
    readings = read_readings(
        {
            "run": run,
            "torque_Nm": torque,
            "preload_N": np.full(400, 400.0),
            "elastic_angle_arcsec": rng.normal(size=400),
        }
    )
    y = rng.normal(size=400)
    found = pooled(readings, y)
    assert isinstance(found, Repeats)
    from cbpt.lab.covariance.repeatability import _conditions

    condition = _conditions(readings)
    again = np.bincount(condition)[condition] > 1
    columns = np.column_stack(
        [
            condition[again, None] == np.unique(condition[again]),
            readings.run_index[again, None] == np.unique(readings.run_index[again]),
        ]
    ).astype(float)
    best, _, rank, _ = np.linalg.lstsq(columns, y[again], rcond=1e-9)
    left = y[again] - columns @ best
    assert found.dof == again.sum() - rank
    assert found.u_arcsec == pytest.approx(float(np.sqrt(left @ left / found.dof)), rel=1e-9)
