"""What preflight says of repeats, rates, coverage and displays, on small simulated tables."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import cbpt
from cbpt.lab.preflight.record import Check

Floats = NDArray[np.float64]
SPRING: dict[str, Any] = {
    "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 0.6},
    "rating": {"rated_torque_Nm": 20},
}
BALL = "examples/campaign.toml"
ARCSEC_PER_NM = 100.0


def ramp(amplitude: float = 20.0, quarter: int = 40, cycles: float = 1.25) -> Floats:
    """Torques 0, +T, -T, +T, ... in even steps."""
    phase = np.arange(round(4 * quarter * cycles) + 1) / (4 * quarter) % 1
    rising = np.where(phase < 0.75, 2 - 4 * phase, 4 * phase - 4)
    return amplitude * np.where(phase < 0.25, 4 * phase, rising)


def slid(torque: Floats, friction: float) -> Floats:
    """What of a torque is behind friction, from rest."""
    found, state = np.empty_like(torque), 0.0
    for i, value in enumerate(torque.tolist()):
        state = min(max(state, value - friction), value + friction)
        found[i] = state
    return found


def table(torque: list[Floats], noise: float = 2.0, seed: int = 1) -> dict[str, Any]:
    """A spring's readings, one run for each list of torques, a second apart."""
    size = [len(each) for each in torque]
    all_ = np.concatenate(torque)
    scatter = np.random.default_rng(seed).normal(0, noise, len(all_))
    return {
        "run": np.repeat(np.arange(1, len(torque) + 1), size),
        "time_s": np.concatenate([1e3 * k + np.arange(n) for k, n in enumerate(size)]),
        "torque_Nm": all_,
        "elastic_angle_arcsec": ARCSEC_PER_NM * all_ + scatter,
    }


def logged(torque_noise: float, readings: int = 400, jitter: float = 0.0) -> dict[str, Any]:
    """A ramp logged on the way. jitter: by which torques differ, and the angle with them."""
    rng = np.random.default_rng(2)
    found = table([ramp(quarter=readings // 5) + rng.normal(0, jitter, readings + 1)] * 3)
    jumps = rng.normal(0, jitter, len(found["run"])) if jitter else 0.0
    found["torque_Nm"] = found["torque_Nm"] + jumps
    found["elastic_angle_arcsec"] = found["elastic_angle_arcsec"] + ARCSEC_PER_NM * jumps
    noise = rng.normal(0, torque_noise, len(found["run"]))
    return found | {"torque_Nm": found["torque_Nm"] + noise}


def check(subject: str, data: dict[str, Any], case: Any = SPRING) -> Check:
    found = cbpt.preflight(case, data).checks
    return next(check for check in found if check.subject == subject)


def scatter(check_: Check) -> float:
    found = re.search(r"(?:scatters by|deviation) ([\d.]+) arcsec", check_.finding)
    assert found, check_.finding
    return float(found[1])


def stated(data: dict[str, Any], u: float) -> dict[str, Any]:
    return data | {"u_elastic_angle_arcsec": np.full(len(data["run"]), u)}


# --- repeats ------------------------------------------------------------------------------


@pytest.mark.parametrize("jitter", [0.0, 0.03])
@pytest.mark.parametrize(("u", "state"), [(0.2, "look"), (2.0, "good"), (20.0, "look")])
def test_repeats_are_held_against_the_stated_uncertainty(
    jitter: float, u: float, state: str
) -> None:
    """With torques that are not identical no loop was."""
    repeats = check("repeats", stated(logged(0.0, jitter=jitter), u))
    assert repeats.state == state and "of the stated uncertainty" in repeats.finding


@pytest.mark.parametrize(
    ("torque_noise", "readings", "true"),
    [(0.0, 400, 2.0), (0.02, 400, 8**0.5), (0.1, 1000, 104**0.5), (0.02, 6000, 8**0.5)],
)
def test_the_scatter_is_that_of_a_reading(torque_noise: float, readings: int, true: float) -> None:
    """However many are averaged for a point of a loop."""
    repeats = check("repeats", logged(torque_noise, readings))
    assert scatter(repeats) == pytest.approx(true, rel=0.08)
    assert repeats.state == "good"


def test_scatter_of_the_torque_is_no_misstated_uncertainty() -> None:
    repeats = check("repeats", stated(logged(0.1), 2.0))
    assert repeats.state == "good" and "scatter of the torque alone makes" in repeats.finding


@pytest.mark.parametrize(("noise", "state"), [(20.0, "good"), (300.0, "look")])
def test_a_scatter_that_makes_figures_useless_is_told(noise: float, state: str) -> None:
    repeats = check("repeats", table([ramp()] * 3, noise))
    assert repeats.state == state and "% of the range of the angle" in repeats.finding


def test_a_run_that_scatters_more_is_named() -> None:
    data = table([ramp()] * 3)
    noisy = np.random.default_rng(3).normal(0, 20, len(data["run"])) * (data["run"] == 2)
    repeats = check(
        "repeats", data | {"elastic_angle_arcsec": data["elastic_angle_arcsec"] + noisy}
    )
    assert repeats.state == "look" and "run 2 are" in repeats.finding
    assert scatter(repeats) == pytest.approx(2.0, rel=0.2)


def test_slopes_that_differ_from_run_to_run_are_told() -> None:
    data = table([ramp()] * 4)
    angle = data["elastic_angle_arcsec"] * (1 + 0.05 * (data["run"] - 2.5))
    repeats = check("repeats", data | {"elastic_angle_arcsec": angle})
    assert repeats.state == "look" and "slopes of runs differ" in repeats.finding
    assert "run 4 turns most, run 1 least" in repeats.finding


@pytest.mark.parametrize(("copy", "whose"), [(4, 2), (3, 1)])
def test_a_copied_run_is_named_and_counted_once(copy: int, whose: int) -> None:
    data = table([ramp()] * 4)
    angle = data["elastic_angle_arcsec"].copy()
    angle[data["run"] == copy] = angle[data["run"] == whose]
    repeats = check("repeats", data | {"elastic_angle_arcsec": angle})
    assert (
        repeats.state == "look"
        and f"run {copy} has the angles of run {whose}, to" in repeats.finding
    )
    assert "3 runs" in repeats.finding and scatter(repeats) == pytest.approx(2.0, rel=0.1)


def test_a_coarse_display_makes_no_copies() -> None:
    data = table([ramp()] * 4, noise=0.5)
    shown = np.round(data["elastic_angle_arcsec"] / 25) * 25
    assert (
        "same to the last digit"
        not in check("repeats", data | {"elastic_angle_arcsec": shown}).finding
    )


@pytest.mark.parametrize(
    "ways",
    [
        np.concatenate([ramp(a, cycles=1.0)[:-1] for a in (5.0, 10.0, 15.0, 20.0)]),
        np.concatenate([np.linspace(0, 20, 41), np.linspace(19.5, 0, 40)]),
    ],
)
def test_repeats_come_from_the_same_turning_point(ways: Floats) -> None:
    """With friction, loops of other amplitudes and first loadings go other ways."""
    torque = np.tile(ways, 3)
    data = table(np.split(torque, 3))
    noise = data["elastic_angle_arcsec"] - ARCSEC_PER_NM * torque
    angle = ARCSEC_PER_NM * slid(torque, 0.7) + noise
    repeats = check("repeats", data | {"elastic_angle_arcsec": angle})
    assert repeats.state == "good" and scatter(repeats) == pytest.approx(2.0, rel=0.25)


# --- rates --------------------------------------------------------------------------------


def paced(pace: Floats | None = None, **changed: ArrayLike) -> dict[str, Any]:
    """Times that go by as fast as told for each reading."""
    data = table([ramp()] * 3)
    if pace is not None:
        step = np.diff(data["time_s"], prepend=0.0)
        data["time_s"] = np.cumsum(step * pace)
    return data | changed


RUN = np.repeat([1, 2, 3], len(ramp()))
UP = np.diff(np.tile(ramp(), 3), prepend=-1.0) > 0
FAR = np.abs(np.tile(ramp(), 3)) > 10
STAIRS = np.repeat(ramp(quarter=10), 6)


@pytest.mark.parametrize(
    ("data", "state", "said"),
    [
        (paced(), "good", "0.5 N m/s"),
        (paced(np.where(UP, 1.0, 5.0)), "look", "0.5 N m/s up and 0.1 N m/s down"),
        (paced(np.where(RUN == 2, 4.0, 1.0)), "look", "0.125 N m/s in run 2 and 0.5"),
        (paced(np.where(FAR, 6.0, 1.0)), "look", "0.0833 to 0.5 N m/s along a branch"),
        (
            paced(np.where(np.arange(len(RUN)) == 300, 4e3, 1.0)),
            "look",
            "a pause of 4000 s in run 2",
        ),
        (paced(np.full(len(RUN), 1e3)), "look", "a run takes up to 55.6 h"),
        (table([STAIRS] * 2), "good", "steps with holds of 5 s"),
    ],
)
def test_rates_are_those_of_every_branch(data: dict[str, Any], state: str, said: str) -> None:
    rates = check("rates", data)
    assert rates.state == state and said in rates.finding


def test_one_quick_run_is_no_other_rate_up_than_down() -> None:
    """The middle of what rates up there are was one that no run has."""
    data = table([ramp(), ramp(cycles=0.75), ramp()])
    step = np.diff(data["time_s"], prepend=0.0)
    data["time_s"] = np.cumsum(np.where(np.array(data["run"]) == 3, 0.3, 1.0) * step)
    assert "1.67 N m/s in run 3 and 0.5 N m/s in the others" in check("rates", data).finding


def test_a_branch_that_is_held_all_but_its_ends_has_a_rate() -> None:
    """Most of it stands still, and a rate of zero ended in a division by it."""
    held = np.concatenate([np.linspace(0, 1, 3), np.ones(40), np.linspace(9, 10, 3)])
    ramps = np.concatenate([np.linspace(0, 10, 46), np.linspace(10, 0, 20)])
    data = table([np.tile(np.concatenate([held, held[::-1]]), 3), np.tile(ramps, 3)])
    assert "N m/s" in check("rates", data).finding


def test_finer_steps_near_zero_and_dwells_are_no_other_rate() -> None:
    """The first is what the remedy for lost motion asks for."""
    side = np.r_[np.linspace(0, 2, 11), np.linspace(4, 20, 9)]
    fine = np.r_[side, side[-2::-1], -side[1:], -side[-2::-1], side[1:]]
    dwell = np.repeat(ramp(), np.where(np.abs(ramp()) == 20.0, 10, 1))
    for torque, said in ((fine, "along a branch"), (dwell, "0.5 N m/s")):
        rates = check("rates", table([torque] * 2))
        assert rates.state == "good" and said in rates.finding


def test_a_run_of_one_reading_is_told() -> None:
    rates = check("rates", table([ramp(), ramp(), np.zeros(1)]))
    assert "run 3 has one reading" in rates.finding


# --- coverage -----------------------------------------------------------------------------


@pytest.mark.parametrize(("reach", "state"), [(20.0, "good"), (18.5, "good"), (4.0, "look")])
def test_torques_far_below_the_rated_one_are_told(reach: float, state: str) -> None:
    torque = check("torque", table([ramp(reach)] * 2))
    assert torque.state == state and ("20 % of the rated" in torque.finding) == (state == "look")


def test_words_of_torques_are_plain() -> None:
    one_sided = -np.abs(ramp())
    assert "-20 to 0 N m" in check("torque", table([one_sided])).finding
    large = table([ramp()]) | {"torque_Nm": 1e3 * ramp()}
    assert "-20000 to 20000 N m" in check("torque", large).finding
    assert check("torque", table([np.full(9, 5.0)])).finding.startswith("1 torque, 5 N m")


def test_sides_reach_equally_far() -> None:
    sides = check("sides", table([ramp(cycles=0.55)]))
    assert sides.state == "look" and "20 N m one way and to -4 N m the other" in sides.finding


def ball(preload: list[float], angle: list[float], together: bool = False) -> dict[str, Any]:
    """Loops of a ball drive at each preload and each input angle, or at pairs of both."""
    pairs = (
        list(zip(preload, angle, strict=True))
        if together
        else [(n, a) for n in preload for a in angle]
    )
    loop = ramp(8.0, 8)
    data = table([loop] * len(pairs), 0.3)
    data["elastic_angle_arcsec"] = data["elastic_angle_arcsec"] * 0.055
    values = np.repeat(np.array(pairs), len(loop), axis=0)
    return data | {"preload_N": values[:, 0], "input_angle_deg": values[:, 1]}


ROUND = [10.0, 47.0, 100.0, 163.0, 222.0, 301.0]


@pytest.mark.parametrize(
    ("preload", "state", "said"),
    [
        ([400.0, 600.0], "good", "2 preloads, 400 to 600 N"),
        ([500.0, 600.0, 700.0], "good", "500 to 700 N"),
        ([590.0, 600.0, 610.0], "lost", "3.39 % apart"),
        ([600.0], "lost", "1 preload, 600 N"),
    ],
)
def test_preloads_differ_by_enough(preload: list[float], state: str, said: str) -> None:
    found = cbpt.preflight(BALL, ball(preload, ROUND))
    told = next(check for check in found.checks if check.subject == "preload")
    assert told.state == state and said in told.finding
    blind = {effect for each in found.cannot_tell for effect in each.effects}
    assert ("preload_loss" in blind) == (state == "lost")


@pytest.mark.parametrize(
    ("angle", "state", "said"),
    [
        (ROUND, "good", "6 input angles, at most 79 deg apart"),
        ([10.0, 10.5, 11.0, 11.5, 12.0, 12.5], "lost", "6 input angles within 2.5 deg"),
        ([340.0, 350.0, 0.0, 10.0, 20.0], "lost", "5 input angles within 40 deg"),
        (np.radians(ROUND).tolist(), "lost", "within 5.08 deg"),
        ([0.0, 90.0, 180.0, 270.0], "look", "patterns with 4, 8, ... periods"),
        (np.arange(0.0, 360.0, 15.0).tolist(), "good", "patterns with 24, 48, ..."),
        ([10.0, 370.0, 730.0], "lost", "1 input angle"),
    ],
)
def test_input_angles_cover_the_turn(angle: list[float], state: str, said: str) -> None:
    found = cbpt.preflight(BALL, ball([400.0, 600.0], angle))
    told = next(check for check in found.checks if check.subject == "input angle")
    assert told.state == state and said in told.finding
    blind = {effect for each in found.cannot_tell for effect in each.effects}
    assert ("eccentricity_error" in blind) == (state == "lost")
    assert ("in rad" in told.remedy) == (said == "within 5.08 deg")


def test_scatter_of_the_input_angle_is_no_coverage() -> None:
    data = ball([400.0, 600.0], ROUND)
    scatter_deg = np.random.default_rng(4).normal(0, 0.02, len(data["run"]))
    data["input_angle_deg"] = (data["input_angle_deg"] + scatter_deg) % 360
    assert check("input angle", data, BALL).finding.startswith("6 input angles")


def test_preload_and_input_angle_that_change_together_are_told() -> None:
    data = ball([400.0, 500.0, 600.0, 800.0], [10.0, 100.0, 190.0, 300.0], together=True)
    told = check("input angle", data, BALL)
    assert told.state == "look" and "each preload was taken at others" in told.finding


@pytest.mark.parametrize(("radius", "state"), [({}, "good"), ({"reference_radius_mm": 20}, "lost")])
def test_a_spring_needs_no_input_angle_without_a_radius(
    radius: dict[str, float], state: str
) -> None:
    case = SPRING | {"torsion_spring": SPRING["torsion_spring"] | radius}
    found = cbpt.preflight(case, table([ramp()] * 3))
    told = next(check for check in found.checks if check.subject == "input angle")
    assert told.state == state
    blind = {effect for each in found.cannot_tell for effect in each.effects}
    assert ("eccentricity_error" in blind) == (state == "lost")


# --- displays -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("step", "digits", "state", "said"),
    [
        (20.0, 3, "look", "hide how far readings scatter"),
        (2.0, 3, "good", "steps of 2 arcsec"),
        (1.4648, 3, "good", "steps of 1.46 arcsec"),
        (1.4648, 2, "good", "steps of 1.4"),
        (0.001, 3, "good", "no step larger than"),
    ],
)
def test_steps_of_the_angle(step: float, digits: int, state: str, said: str) -> None:
    data = table([ramp()] * 3)
    shown = np.round(np.round(data["elastic_angle_arcsec"] / step) * step, digits)
    told = check("display of the angle", data | {"elastic_angle_arcsec": shown})
    assert told.state == state and said in told.finding


def test_a_few_digits_are_a_step_of_large_angles() -> None:
    data = logged(0.0)
    shown = np.array([float(f"{angle:.3g}") for angle in data["elastic_angle_arcsec"]])
    told = check("display of the angle", data | {"elastic_angle_arcsec": shown})
    assert "steps of 10 arcsec where it is large" in told.finding


@pytest.mark.parametrize(("step", "told"), [(0.5, True), (0.01, False)])
def test_steps_of_a_logged_torque_are_told_where_they_matter(step: float, told: bool) -> None:
    data = logged(0.0)
    shown = np.round(data["torque_Nm"] / step) * step
    found = cbpt.preflight(SPRING, data | {"torque_Nm": shown}).checks
    steps = [check for check in found if check.subject == "display of the torque"]
    assert bool(steps) == told
    assert all("steps of 0.5 N m" in check.finding for check in steps)


def test_a_torque_that_was_set_is_no_display() -> None:
    found = cbpt.preflight(SPRING, table([STAIRS] * 2)).checks
    assert not any(check.subject == "display of the torque" for check in found)
