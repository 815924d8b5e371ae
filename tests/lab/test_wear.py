"""Property: wear that slows down is told as such, and steady wear stays steady wear.

Simulated on the campaign of the demo, whose preload falls by hand, by no effect of the library.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common.comparisons import EXAMPLES

CASE = EXAMPLES / "campaign.toml"
TABLE = cbpt.read_readings(EXAMPLES / "campaign.csv")
assert TABLE.time_s is not None and TABLE.preload_N is not None
PRELOAD_N = TABLE.preload_N
TIME_s = TABLE.time_s
STARTS = np.flatnonzero(np.diff(TABLE.run_index)) + 1
SHARE_OF_TIME = (TIME_s - TIME_s.min()) / np.ptp(TIME_s)


def worn(lost: NDArray[np.float64], seed: int) -> cbpt.Readings:
    """Readings of a drive whose preload falls, in a table that tells what was set."""
    at_mesh = replace(TABLE, preload_N=PRELOAD_N * (1 - lost))
    angle = cbpt.simulate(CASE, at_mesh, seed=seed)
    return replace(angle, preload_N=PRELOAD_N)


@pytest.mark.parametrize("exponent", [0.4, 0.6])
@pytest.mark.parametrize("seed", [1, 2])
def test_wear_that_slows_down_is_no_temperature(exponent: float, seed: int) -> None:
    """A preload that follows the temperature was certain in its place, or beside it."""
    found = cbpt.diagnose(CASE, worn(0.25 * SHARE_OF_TIME**exponent, seed))
    assert found.verdict.effects == ("wear",)
    told = found.parameters(found.after, "wear")
    share, power = told["slowing_lost_share"], told["slowing_exponent"]
    assert share["value"] == pytest.approx(0.25, abs=4 * share["u"])
    assert power["value"] == pytest.approx(exponent, abs=4 * power["u"])


@pytest.mark.parametrize("seed", [1, 2])
def test_a_joint_that_seats_is_no_temperature(seed: int) -> None:
    found = cbpt.diagnose(CASE, worn(0.2 * (1 - np.exp(-5 * SHARE_OF_TIME)), seed))
    assert found.verdict.effects == ("wear",)
    told = found.parameters(found.after, "wear")
    assert told["seated_lost_share"]["value"] == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_preload_that_relaxes_in_each_run_is_no_creep(seed: int) -> None:
    """Creep was certain, and a loss of preload beside it."""
    run_s = np.concatenate([t - t[0] for t in np.split(TIME_s, STARTS)])
    found = cbpt.diagnose(CASE, worn(0.03 * np.log1p(run_s / 20), seed))
    assert "wear" in {*found.verdict.effects, *(e for g in found.verdict.rivals for e in g)}
    assert "creep" not in found.verdict.effects


def test_steady_wear_has_one_number() -> None:
    found = cbpt.diagnose(CASE, worn(0.1 * SHARE_OF_TIME, 1))
    assert found.verdict.effects == ("wear",)
    assert found.after.hypothesis.variants[0].sizes == ("lost_share_per_s",)
