"""Tables over months and years: what the table's own ranges would be goes beyond the equations."""

from __future__ import annotations

from dataclasses import replace

import pytest

import cbpt
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import Shape, Variant, within_limits
from common.friction_loops import FRICTION, LOOP, read_from

DAY_S = 86_400.0
CASE = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1.0},
    "uncertainty": {"contact_stiffness_rel": 0.1},
}
WITH_FRICTION = CASE | {
    "effect": [{"id": FRICTION, "friction_torque_Nm": 1.0, "engagement_angle_arcsec": 30.0}]
}


@pytest.mark.parametrize("days_a_step", [1.0, 40.0])
def test_a_table_over_years_is_diagnosed(days_a_step: float) -> None:
    table = read_from(WITH_FRICTION, LOOP, seconds_a_step=days_a_step * DAY_S)
    found = cbpt.diagnose(CASE, table)
    assert FRICTION in str(found.to_dict()["verdict"])
    campaign = Campaign.of(cbpt.Case.from_dict(CASE), cbpt.read_readings(table, need_preload=False))
    fitter = Fitter(campaign)
    for variant in fitter.library:
        for shape in variant.shapes:
            place = fitter.place(variant.effect, shape.name)
            assert fitter.model.lower[place] <= shape.low < shape.high <= fitter.model.upper[place]
            assert all(shape.low <= at <= shape.high for at in shape.grid)


def test_creep_over_years_is_fitted() -> None:
    table = read_from(WITH_FRICTION, LOOP, seconds_a_step=40 * DAY_S)
    fitted = cbpt.fit(CASE, table, [FRICTION, "creep"])
    assert fitted.after.rmse_arcsec < 10


def test_creep_that_is_over_before_the_next_reading_is_refused() -> None:
    table = read_from(WITH_FRICTION, LOOP, seconds_a_step=200 * DAY_S)
    with pytest.raises(cbpt.InvalidInputError, match="is over sooner than the next reading"):
        cbpt.fit(CASE, table, [FRICTION, "creep:superposed"])
    # What grows with a power of time has no time by which it is over.
    assert cbpt.fit(CASE, table, [FRICTION, "creep"]).after.rmse_arcsec < 10


def test_ranges_end_where_the_equation_does() -> None:
    time = Shape("time_constant_s", 1e5, 1e9, (1e6, 1e8), log=True)
    creep = Variant("creep", ("compliance_rad_per_Nm",), 1e-9, 1e-6, shapes=(time,))
    limited = within_limits(creep)
    assert limited is not None and limited.high == creep.high
    [shape] = limited.shapes
    assert shape.low == time.low and shape.grid == (1e6, shape.high)
    assert 1e7 * (1 - 1e-9) < shape.high < 1e7
    assert within_limits(replace(creep, shapes=(replace(time, low=2e7),))) is None
    assert within_limits(replace(creep, low=2.0, high=3.0)) is None
    inside = replace(creep, shapes=(replace(time, high=1e6, grid=(1e6,)),))
    assert within_limits(inside) == inside
