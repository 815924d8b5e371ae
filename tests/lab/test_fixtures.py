"""What a rig does to a play: a fixture that is not tight, which turns in its play once its friction
is overcome, or slips once; and a weight on the output, which holds it to one flank.

All are added to the readings by hand, so that the library's equations are not their own witness.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common.comparisons import EXAMPLES
from common.friction_loops import SPRING, loops

Floats = NDArray[np.float64]

U_ARCSEC = 2.0
PLAY_ARCSEC, HOLDING_Nm = 12.0, 4.0


def along(turns: list[float]) -> Floats:
    """In steps of 0.5 N m."""
    legs = [np.linspace(a, b, round(2 * abs(b - a)) + 1)[1:] for a, b in pairwise(turns)]
    return np.concatenate([turns[:1], *legs])


SMALL = along([0, 3, -3, 3, -3, 0])
LARGE = along([0, 10, -10, 10, -10, 0])
"""Which end on the other flank than they began on, or in the middle."""


def stands(torque_Nm: Floats, holding_Nm: float, at: float = -0.5) -> Floats:
    """The share of its play at which a fixture stands, which takes half a newton metre to turn."""
    found = []
    for torque in torque_Nm:
        loaded, unloaded = (torque - holding_Nm) / 0.5, (torque + holding_Nm) / 0.5
        at = float(np.clip(min(max(at, loaded), unloaded), -0.5, 0.5))
        found.append(at)
    return np.array(found)


def table(*runs: tuple[Floats, Floats], seed: int = 1) -> dict[str, Floats]:
    """Runs of torques, N m, and of what is added to the angle of the spring, arcsec."""
    torque = np.concatenate([torque for torque, _ in runs])
    angle = 60 * torque + np.concatenate([added for _, added in runs])
    angle += U_ARCSEC * np.random.default_rng(seed).standard_normal(len(angle))
    return {
        "run": np.repeat(np.arange(len(runs)), [len(torque) for torque, _ in runs]),
        "time_s": 2.0 * np.arange(len(torque)),
        "torque_Nm": torque,
        "elastic_angle_arcsec": angle,
        "u_elastic_angle_arcsec": np.full(len(angle), U_ARCSEC),
    }


def loose(seed: int = 1) -> dict[str, Floats]:
    """Loops to less and to more than what holds the fixture."""
    runs = ((t, PLAY_ARCSEC * stands(t, HOLDING_Nm)) for t in (SMALL, LARGE))
    return table(*runs, seed=seed)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_loose_fixture_that_is_asked_for_is_found(seed: int) -> None:
    """It follows what neither play nor a stiffness curve does. No diagnosis proposes it: a play of
    the reducer that friction holds looks the same."""
    read = loose(seed)
    found = cbpt.fit(SPRING, read, ["loose_fixture"])
    assert found.after.chi2_per_dof < 1.3
    assert cbpt.fit(SPRING, read, ["backlash"]).after.chi2_per_dof > 3
    numbers = found.parameters()["loose_fixture"]
    for name, true in (
        ("fixture_play_rad", PLAY_ARCSEC * np.pi / 648000),
        ("holding_torque_Nm", HOLDING_Nm),
    ):
        assert numbers[name]["value"] == pytest.approx(true, abs=4 * numbers[name]["u"]), name


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_loose_fixture_is_no_certain_part_of_the_reducer(seed: int) -> None:
    """A stiffness curve was certain in its place."""
    verdict = cbpt.diagnose(SPRING, loose(seed)).verdict
    assert not verdict.effects and not verdict.rivals, verdict


def test_a_fixture_that_came_loose_has_changed() -> None:
    """It is tried in place of what seems to have changed."""
    tight = table(*((t, 0.0 * t) for t in (SMALL, LARGE)), seed=4)
    found = cbpt.change(SPRING, tight, loose(5))
    assert {c.effect for c in found.changed} == {"loose_fixture"}, found.sentence
    assert {c.direction for c in found.changed} == {"new"}


@pytest.mark.parametrize(
    ("after_s", "by_arcsec", "seed"), [(12, -8.0, 1), (30, -8.0, 2), (100, -8.0, 2)]
)
def test_a_fixture_that_slips_once_in_a_run_is_no_certain_drift(
    after_s: float, by_arcsec: float, seed: int
) -> None:
    """A warm-up or a run-in follows a step halfway, and nothing without a name was tried in its
    place beside the friction."""
    read = dict(loops(seed=seed))
    read["elastic_angle_arcsec"] = read["elastic_angle_arcsec"] + by_arcsec * (
        read["time_s"] > after_s
    )
    found = cbpt.diagnose(SPRING, read)
    assert not {"drift", "run_in"}.intersection(found.verdict.effects), found.sentence
    spoken = {*found.verdict.effects, *(e for group in found.verdict.rivals for e in group)}
    assert "unknown" in spoken or found.remains() is not None, found.sentence


def test_a_ball_drive_has_one_where_it_is_asked_for() -> None:
    """No diagnosis of a ball drive proposes it."""
    table = cbpt.read_readings(EXAMPLES / "campaign.csv")
    found = cbpt.fit(EXAMPLES / "campaign.toml", table, ["loose_fixture"])
    assert "holding_torque_Nm" in found.parameters()["loose_fixture"]


@pytest.mark.parametrize("play_arcsec", [20.0, 400.0])
def test_a_play_that_a_weight_holds_to_one_flank_lies_off_zero_torque(play_arcsec: float) -> None:
    """It was a torque zero with a joint and a nonlinear sensor; and a large one was held to what
    the flanks at zero torque leave room for."""
    share = 0.5 + 0.5 * np.tanh((LARGE - 2.5) / 0.2)
    found = cbpt.diagnose(SPRING, table((LARGE, play_arcsec * share), (LARGE, play_arcsec * share)))
    assert found.verdict.effects == ("backlash",), found.sentence
    numbers = found.parameters(found.after, "backlash")
    for name, true in (("play_rad", play_arcsec * np.pi / 648000), ("centre_torque_Nm", 2.5)):
        assert numbers[name]["value"] == pytest.approx(true, rel=0.1), name


@pytest.mark.parametrize("zero_Nm", [-0.3, 1.0])
def test_a_torque_zero_beside_a_play_stays_possible(zero_Nm: float) -> None:
    """Where neither bends anything else, both do the same; it was left out, or two numbers that
    cancel were certain."""
    torque = np.tile(LARGE, 2)
    share = 0.5 * (torque - zero_Nm) / np.hypot(torque - zero_Nm, 0.1)
    found = cbpt.diagnose(
        SPRING, table((LARGE, 40 * share[: len(LARGE)]), (LARGE, 40 * share[: len(LARGE)]))
    )
    said = dict(found.verdict.perhaps) | dict.fromkeys(found.verdict.effects, 1.0)
    assert said["backlash"] == 1.0 and said["torque_zero"] > 0.3, found.sentence
    names = {u.name for u in found.after.unknowns}
    assert not {"backlash.centre_torque_Nm", "torque_zero.zero_error_Nm"} <= names, names


def test_a_play_off_zero_torque_is_compared_where_it_is_asked_for() -> None:
    share = 0.5 + 0.5 * np.tanh((LARGE - 2.5) / 0.2)
    small, large = (table((LARGE, play * share), seed=play) for play in (20, 40))
    found = cbpt.change(SPRING, small, large, effects=["backlash:off centre, above"])
    assert ("backlash", "up") in {(c.effect, c.direction) for c in found.changed}, found.sentence
