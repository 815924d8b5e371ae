"""A fitted play against the table's own smaller loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cbpt
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_loops import play_allowed_rad, small_loops_of
from cbpt.lab.model.own_terms import campaign_of
from common.drives import examples

CASE = {
    "torsion_spring": {"torsional_stiffness_Nm_per_deg": 20.0},
    "measurement": {"zero": "per_run"},
    "uncertainty": {"contact_stiffness_rel": 0.5},
}
Loop = tuple[np.ndarray, np.ndarray]


def lap(amplitude_Nm: float, count: int = 24) -> np.ndarray:
    """0, +T, 0, -T, 0."""
    up = np.linspace(0, amplitude_Nm, count)
    return np.concatenate([up, up[-2::-1], -up[1:], -up[-2::-1]])


def table(
    *loops: Loop, sigma_deg: float = 0.0, seed: int = 0
) -> dict[str, list[float] | list[str]]:
    rng = np.random.default_rng(seed)
    torque = np.concatenate([t for t, _ in loops])
    angle = np.concatenate([a for _, a in loops])
    return {
        "run": [str(k) for k, (t, _) in enumerate(loops) for _ in t],
        "time_s": np.arange(len(torque), dtype=float).tolist(),
        "torque_Nm": torque.tolist(),
        "elastic_angle_deg": (angle + sigma_deg * rng.standard_normal(len(angle))).tolist(),
    }


def campaign(rows: dict[str, list[float] | list[str]]) -> Campaign:
    readings = cbpt.read_readings(rows, need_preload=False)
    return campaign_of(cbpt.Case.from_dict(CASE), readings, [])


def allowed_Nm(rows: dict[str, list[float] | list[str]]) -> float:
    """The largest friction that the smallest loops allow; infinite without such loops."""
    loops = small_loops_of(campaign(rows))
    return np.inf if loops is None else loops.friction_Nm


def played(torque_Nm: np.ndarray, play_deg: float, friction_Nm: float) -> np.ndarray:
    """A spring of 20 N m/deg with dry friction and a play behind it."""
    carried, found = 0.0, []
    for t in torque_Nm:
        carried = min(max(carried, t - friction_Nm), t + friction_Nm)
        found.append(carried / 20 + 0.5 * play_deg * np.tanh(carried / 0.02))
    return np.array(found)


@examples(30)
@given(st.floats(0.0, 5.0), st.floats(0.0, 1.5), st.floats(2.5, 10.0), st.floats(20.0, 60.0))
def test_a_play_that_is_there_is_always_allowed(
    play_deg: float, friction_Nm: float, small_Nm: float, large_Nm: float
) -> None:
    loops = [(t, played(t, play_deg, friction_Nm)) for t in map(lap, (small_Nm, large_Nm))]
    assert play_allowed_rad(campaign(table(*loops))) >= np.radians(play_deg) * 0.999


def with_friction(
    torque_Nm: np.ndarray, friction_Nm: float, engagement_deg: float, play_deg: float
) -> np.ndarray:
    """A spring of 20 N m/deg and a play, with friction by Dahl's law on what they turn."""
    friction = {"friction_torque_Nm": friction_Nm, "engagement_angle_arcsec": 3600 * engagement_deg}
    play = {"play_arcsec": 3600 * play_deg, "transition_torque_Nm": 0.05}
    made = cbpt.simulate(
        {
            **CASE,
            "effect": [{"id": "friction_hysteresis", **friction}, {"id": "backlash", **play}],
        },
        cbpt.read_readings(table((torque_Nm, np.zeros_like(torque_Nm))), need_preload=False),
        seed=0,
        u_elastic_angle_arcsec=1e-3,
    )
    return np.array(made.elastic_angle_arcsec) / 3600


@examples(30)
@given(
    st.floats(0.1, 5.0),
    st.floats(0.01, 0.5),
    st.floats(0.0, 2.0),
    st.integers(6, 24),
    st.integers(0, 3),
)
def test_a_friction_that_is_there_is_always_allowed(
    friction_Nm: float, engagement_deg: float, play_deg: float, count: int, short: int
) -> None:
    """Also one that the small loops do not overcome, and where they end short of zero torque."""
    small = lap(3.0, count)[: -short or None]
    loop = small, with_friction(small, friction_Nm, engagement_deg, play_deg)
    assert allowed_Nm(table(loop)) > 0.999 * friction_Nm


@pytest.mark.parametrize("last", [0.99, 1.0, 1.01])
def test_a_run_that_ends_at_its_largest_torque_has_no_way_back(last: float) -> None:
    """It says nothing of the opening of the loop, and bars no friction."""
    steps = np.linspace(-1.0, 1.0, 24)
    way = np.concatenate([-3.0 * steps, 3.0 * steps[1:]])
    way[-1] *= last
    angle = with_friction(way, 4.0, 0.1, 0.0)
    assert allowed_Nm(table((way, angle))) > 4.0


def test_a_loop_that_is_open_allows_no_friction_beyond_its_torque() -> None:
    small = lap(3.0)
    loop = small, with_friction(small, 1.0, 0.02, 1.0)
    assert 3.0 <= allowed_Nm(table(loop)) < 4.0


@pytest.mark.parametrize("sigma_deg", [0.0, 0.01])
@pytest.mark.parametrize("friction_Nm", [0.0, 0.1, 1.5])
def test_what_small_loops_turn_elastically_is_no_play(sigma_deg: float, friction_Nm: float) -> None:
    """A degree of play and 0.4 deg of spring: the loops turn by 1.4 deg. Friction only makes the
    flanks plainer."""
    small, large = ((t, played(t, 1.0, friction_Nm)) for t in map(lap, (4.0, 40.0)))
    rows = table(small, small, small, large, sigma_deg=sigma_deg)
    found = small_loops_of(
        campaign(rows | {"u_elastic_angle_deg": [sigma_deg or 1e-4] * len(rows["run"])})
    )
    assert found is not None and not found.held
    assert 3600 < found.allowed_arcsec < 1.35 * 3600


@pytest.mark.parametrize("friction_Nm", [0.0, 0.5])
def test_a_spring_is_no_play(friction_Nm: float) -> None:
    """A spring turns with the torque over the whole loop; a play could be half of that at most."""
    soft = played(lap(4.0), 0.0, friction_Nm) * 5
    allowed = play_allowed_rad(campaign(table((lap(4.0), soft))))
    assert np.degrees(allowed) < 0.4 * np.ptp(soft)


def test_a_slow_first_loop_does_not_decide() -> None:
    """One of three creeps by as much as the play while it is measured."""
    torque = lap(4.0)
    loop = played(torque, 1.0, 1.0)
    crept = loop + np.linspace(0, 1.0, len(loop))
    found = small_loops_of(campaign(table((torque, loop), (torque, loop), (torque, crept))))
    assert found is not None and 0.8 * 3600 < found.allowed_arcsec < 1.3 * 3600


def test_what_a_model_lacks_is_no_scatter() -> None:
    """A fit may find a scatter as large as the play; readings that follow each other do not."""
    loops = [(t, played(t, 1.0, 1.5)) for t in map(lap, (4.0, 40.0))]
    measured = campaign(table(*loops, sigma_deg=0.001))
    believed = replace(measured, u_arcsec=np.full(len(measured), 1400.0))
    found = [small_loops_of(c) for c in (measured, believed)]
    assert found[0] == found[1] and found[0] is not None and not found[0].held


def test_a_dwell_at_the_largest_torque_is_no_way_back() -> None:
    """Large loops that creep by a degree under their largest torque before it comes back."""
    small, up = lap(4.0), np.linspace(0, 40, 24)
    torque = np.concatenate([up, np.full(20, 40.0), up[-2::-1], -up[1:], -up[-2::-1]])
    creep = np.interp(np.arange(len(torque)), [24, 43], [0.0, 1.0])
    rows = table((small, played(small, 1.0, 1.0)), (torque, played(torque, 1.0, 1.0) + creep))
    found = small_loops_of(campaign(rows))
    assert found is not None and not found.held


@pytest.mark.parametrize("sigma_deg", [0.0, 0.01])
def test_a_loop_that_friction_holds_says_nothing_of_a_play(sigma_deg: float) -> None:
    loops = [(t, played(t, 2.0, 5.0)) for t in map(lap, (4.0, 40.0))]
    rows = table(*loops, sigma_deg=sigma_deg)
    found = small_loops_of(
        campaign(rows | {"u_elastic_angle_deg": [sigma_deg or 1e-4] * len(rows["run"])})
    )
    assert found is not None and found.held
    assert found.amplitude_Nm == 4.0
    assert found.allowed_arcsec == np.inf


def test_a_table_without_loops_allows_any_play() -> None:
    torque = np.linspace(0, 40, 20)
    assert small_loops_of(campaign(table((torque, torque / 20)))) is None


@pytest.mark.parametrize("seed", [0, 1])
def test_no_fitted_play_is_larger_than_the_small_loops_turn(seed: int) -> None:
    """A soft middle that only large loops see: a play of 3 deg would fit them, but the small loops
    turn by half a degree."""

    def soft(torque: np.ndarray) -> np.ndarray:
        return torque / 20 + 1.5 * np.tanh(torque / 12)

    loops = [(t, soft(t)) for t in map(lap, (2.0, 2.0, 40.0, 40.0))]
    rows = table(*loops, sigma_deg=0.02, seed=seed)
    turned = np.ptp(soft(lap(2.0)))
    found = cbpt.fit(CASE, rows, ["backlash"])
    play = found.parameters()["backlash"]["play_rad"]["value"]
    assert np.degrees(play) < 1.3 * turned
    assert any("no play is larger than that" in note for note in found.notes)


def test_readings_without_an_angle_are_left_out() -> None:
    """As those that are only predicted."""
    loops = campaign(table(*((t, played(t, 2.0, 1.0)) for t in map(lap, (4.0, 40.0)))))
    known = np.arange(len(loops)) % 7 != 0
    blind = replace(loops, y_arcsec=np.where(known, loops.y_arcsec, np.nan))
    found, whole = small_loops_of(blind), small_loops_of(loops)
    assert found is not None and whole is not None
    assert found.turn_arcsec == pytest.approx(whole.turn_arcsec, rel=0.05)
    assert found.apart_arcsec == pytest.approx(whole.apart_arcsec, rel=0.1)
    nothing = replace(loops, y_arcsec=np.full(len(loops), np.nan))
    assert small_loops_of(nothing) is None
