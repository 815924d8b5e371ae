"""A shaft that a side load moves, read by a sensor on a lever: an error that is even in torque.

It is added to the readings by hand, so that the library's equation is not its own witness.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.spring_priors import library_of
from common.comparisons import EXAMPLES
from common.friction_loops import SPRING, loops

Floats = NDArray[np.float64]
CASE = EXAMPLES / "campaign.toml"
TABLE = cbpt.read_readings(EXAMPLES / "campaign.csv")
LEVER_M = 0.1
SHIFT_M_PER_NM = 0.1e-6
RAD_PER_NM = SHIFT_M_PER_NM / LEVER_M
ARCSEC = np.pi / 648000.0


def shifted(rows: cbpt.Readings, rad_per_Nm: float = RAD_PER_NM) -> cbpt.Readings:
    """Readings of the drive as stated, at torques of both signs off by one sign."""
    plain = cbpt.simulate(CASE, rows, seed=1)
    error = rad_per_Nm * np.abs(plain.torque_Nm) / ARCSEC
    return replace(plain, elastic_angle_arcsec=plain.elastic_angle_arcsec + error)


def spoken(found: cbpt.Diagnosis) -> set[str]:
    return {*found.verdict.effects, *(each for group in found.verdict.rivals for each in group)}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_shift_of_the_shaft_is_no_torsion(sign: float) -> None:
    found = cbpt.diagnose(CASE, shifted(TABLE, sign * RAD_PER_NM))
    assert (found.verdict.kind, found.verdict.effects) == ("rig", ("shaft_shift",)), found.sentence
    value = found.parameters(found.after, "shaft_shift")["shift_rad_per_Nm"]
    assert value["value"] == pytest.approx(sign * RAD_PER_NM, abs=3 * value["u"])
    assert value["u"] < 0.1 * RAD_PER_NM


def test_a_joint_that_is_softer_one_way_is_no_shift() -> None:
    joint = {"compliance_rad_per_Nm": RAD_PER_NM, "asymmetry": 0.8}
    readings = cbpt.simulate(CASE, TABLE, effects=[("output_torsion", joint)], seed=1)
    found = cbpt.diagnose(CASE, readings)
    assert "output_torsion" in spoken(found), found.sentence
    assert "shaft_shift" not in found.verdict.effects


def test_a_shift_beside_a_zero_of_the_torque_is_told_with_it() -> None:
    """Both are off to one side under torques of both signs."""
    zero = [("torque_zero", {"zero_error_Nm": 0.4})]
    plain = cbpt.simulate(CASE, TABLE, effects=zero, seed=1)
    error = RAD_PER_NM * np.abs(plain.torque_Nm - 0.4) / ARCSEC
    readings = replace(plain, elastic_angle_arcsec=plain.elastic_angle_arcsec + error)
    found = cbpt.diagnose(CASE, readings)
    assert set(found.verdict.effects) == {"shaft_shift", "torque_zero"}, found.sentence


@pytest.mark.parametrize("turns", [True, False])
def test_under_torques_of_one_sign_nothing_tells_a_shift_from_a_shaft_that_turns(
    turns: bool,
) -> None:
    """Either is in proportion to the torque. The shift is taken to be rarer: where it is not among
    the rivals, a note has it."""
    rows = TABLE.select(np.flatnonzero(TABLE.torque_Nm >= 0))
    if turns:
        joint = ("output_torsion", {"compliance_rad_per_Nm": RAD_PER_NM})
        found = cbpt.diagnose(CASE, cbpt.simulate(CASE, rows, effects=[joint], seed=1))
    else:
        found = cbpt.diagnose(CASE, shifted(rows))
    (group,) = found.verdict.rivals
    assert "output_torsion" in group, found.sentence
    assert found.verdict.effects == ()
    noted = any(note.startswith("shaft_shift would explain") for note in found.notes)
    assert ("shaft_shift" in group) != noted


def spring_readings(torque_Nm: Floats, rad_per_Nm: float) -> cbpt.Readings:
    """Loops of a spring without friction that the shaft of the rig shifts."""
    table = loops() | {"torque_Nm": torque_Nm}
    rows = cbpt.read_readings(table, need_preload=False)
    plain = cbpt.simulate(SPRING, rows, seed=1, u_elastic_angle_arcsec=2.0)
    error = rad_per_Nm * np.abs(plain.torque_Nm) / ARCSEC
    return replace(plain, elastic_angle_arcsec=plain.elastic_angle_arcsec + error)


def test_a_shift_of_a_springs_shaft_is_no_certain_joint() -> None:
    """A joint that is softer one way turns like it beside a spring that is stiffer than stated."""
    found = cbpt.diagnose(SPRING, spring_readings(loops()["torque_Nm"], 1e-5))
    assert "shaft_shift" in spoken(found), found.sentence
    assert "output_torsion" not in found.verdict.effects, found.sentence


def of_spring(torque_Nm: Floats) -> Campaign:
    return campaign_of(cbpt.Case.from_dict(SPRING), spring_readings(torque_Nm, 0.0), [])


def test_under_torques_of_one_sign_a_springs_shift_is_its_stiffness() -> None:
    """So it is left out, as a joint without a shape is."""
    torque = loops()["torque_Nm"]
    for torque_Nm, proposed in ((torque, True), (np.abs(torque), False)):
        campaign = of_spring(torque_Nm)
        assert ("shaft_shift" in {v.effect for v in library_of(campaign)}) == proposed
    asked = library_of(of_spring(np.abs(torque)), ["shaft_shift"])
    assert "shaft_shift" in {v.effect for v in asked}
