"""Property: what the instruments do is not taken for an effect, nor an effect for what they do, nor
either for a unit that is wrong.

Simulated on the campaign of the demo, whose drive is then exactly as stated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from common import mostly_long
from common.comparisons import EXAMPLES

Floats = NDArray[np.float64]
CASE = EXAMPLES / "campaign.toml"
TABLE = cbpt.read_readings(EXAMPLES / "campaign.csv")
U_ARCSEC = 0.3


@pytest.mark.parametrize("seed", mostly_long(range(2), [1]))
def test_noise_of_the_torque_column_is_no_effect(seed: int) -> None:
    """A torque sensor whose noise moves the angle by twice the noise of a reading."""
    rng = np.random.default_rng(seed)
    torque_Nm = TABLE.torque_Nm
    angle = cbpt.simulate(CASE, TABLE, u_elastic_angle_arcsec=1e-9).elastic_angle_arcsec
    slope = float(np.polyfit(torque_Nm, angle, 1)[0])
    shown = torque_Nm + 2 * U_ARCSEC / slope * rng.standard_normal(len(angle))
    read = angle + U_ARCSEC * rng.standard_normal(len(angle))
    found = cbpt.diagnose(CASE, replace(TABLE, torque_Nm=shown, elastic_angle_arcsec=read))
    assert found.verdict.kind in ("rig", "undecided"), found.sentence
    assert found.verdict.effects == () and found.verdict.rivals == ()
    assert "torque_noise" in found.verdict.noise
    if found.verdict.kind == "rig":
        assert "scatter of the torque readings" in found.sentence


def _walk(rng: np.random.Generator, read: Floats) -> Floats:
    assert TABLE.time_s is not None
    passed = np.diff(TABLE.time_s, prepend=TABLE.time_s[0]) / np.ptp(TABLE.time_s)
    return read + 5 * U_ARCSEC * np.cumsum(np.sqrt(passed) * rng.standard_normal(len(read)))


def _first(rng: np.random.Generator, read: Floats) -> Floats:
    first = np.unique(TABLE.run_index, return_index=True)[1]
    read[first] += 4 * U_ARCSEC
    return read


def _encoder(rng: np.random.Generator, read: Floats) -> Floats:
    return read + 2 * U_ARCSEC * np.sin(2 * np.pi * read / 14.0 + rng.uniform(0, 6))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("kind", "add"), [("random_walk", _walk), ("first_reading", _first), ("encoder", _encoder)]
)
def test_what_the_angle_sensor_does_is_no_effect(
    kind: str, add: Callable[[np.random.Generator, Floats], Floats], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    angle = cbpt.simulate(CASE, TABLE, u_elastic_angle_arcsec=1e-9).elastic_angle_arcsec
    read = add(rng, angle + U_ARCSEC * rng.standard_normal(len(angle)))
    found = cbpt.diagnose(CASE, replace(TABLE, elastic_angle_arcsec=read))
    assert found.verdict.kind in ("rig", "undecided"), found.sentence
    assert found.verdict.effects == () and found.verdict.rivals == ()
    assert kind in found.verdict.noise


@pytest.mark.parametrize("seed", mostly_long(range(12), [0, 7]))
@pytest.mark.parametrize("friction_Nm", [0.0, 8.0])
def test_a_zero_that_wanders_is_no_effect_of_a_spring(friction_Nm: float, seed: int) -> None:
    """Loops of two runs, with friction and without: a loop is looked at first, and what the
    instrument does once it is explained."""
    ramp = 250 * np.sin(2 * np.pi * np.arange(97) / 48)
    rows = cbpt.read_readings(
        {
            "run": np.repeat([1.0, 2.0], 97),
            "time_s": np.r_[np.arange(97.0), 120 + np.arange(97.0)] * 14,
            "torque_Nm": np.tile(ramp, 2),
            "elastic_angle_arcsec": np.zeros(194),
        },
        need_preload=False,
    )
    case = {"torsion_spring": {"torsional_stiffness_Nm_per_rad": 129000.0}}
    loop = {"friction_torque_Nm": friction_Nm, "engagement_angle_rad": 4e-5}
    hidden = [("friction_hysteresis", loop)] if friction_Nm else []
    readings = cbpt.simulate(case, rows, effects=hidden, u_elastic_angle_arcsec=5.0, seed=seed)
    assert readings.time_s is not None
    rng, passed = np.random.default_rng(seed), np.diff(readings.time_s, prepend=0.0) / 3000
    wander = 35 * np.cumsum(np.sqrt(passed) * rng.standard_normal(len(passed)))
    read = readings.elastic_angle_arcsec + wander
    answer = cbpt.diagnose(case, replace(readings, elastic_angle_arcsec=read))
    found = answer.verdict
    assert found.kind in ("effect" if friction_Nm else "rig", "undecided")
    assert found.effects == tuple(effect for effect, _ in hidden)
    # What the zero does is what the answer shows of it: the loop of the drive as stated is none.
    loop_arcsec = friction_Nm / 129000 * 206265
    assert found.undecided or answer.ladder[0].rmse_arcsec > 0.7 * loop_arcsec
    # Nor is that of an effect that is not at work, beside which the zero would take the loop.
    answer_has, other = answer.noises.of(found.names), answer.noises.of(("shaft_shift",))
    assert (other.instrument_arcsec is not None) == bool(found.names)
    assert answer_has.instrument_arcsec is None


def test_runs_at_one_load_each_follow_it_from_run_to_run() -> None:
    """While the crank turns through a run, the angle hardly changes: less than it scatters."""
    run = np.repeat(np.arange(6), 12)
    rows = replace(
        TABLE.select(np.arange(len(run))),
        run=run,
        torque_Nm=np.array([5.0, -5.0, 2.0, -2.0, 1.0, 4.0])[run],
        preload_N=np.full(len(run), 600.0),
        input_angle_deg=np.tile(np.arange(12) * 30.0, 6),
        elastic_angle_arcsec=np.zeros(len(run)),
    )
    found = cbpt.diagnose(CASE, cbpt.simulate(CASE, rows, u_elastic_angle_arcsec=3.0, seed=1))
    assert found.verdict.kind == "complete"


def test_a_set_of_the_first_cycles_is_no_handful_of_outliers() -> None:
    """Run-in that is over after the first cycle leaves a few readings far off."""
    values = {"permanent_set_rad": 1.2e-5}
    readings = cbpt.simulate(CASE, TABLE, effects=[("run_in", values)], seed=1)
    found = cbpt.diagnose(CASE, readings).verdict
    assert found.effects == ("run_in",)
    assert "outliers" not in found.noise


@pytest.mark.parametrize("scale", [0.25, 1.9, 2.6, 3.6, 4.5])
def test_a_stiffer_contact_is_one(scale: float) -> None:
    """Beyond what was likely it was a gain of the angle sensor, a contact angle, or a preload in
    another unit."""
    readings = cbpt.simulate(
        CASE, TABLE, effects=[("contact_stiffness", {"stiffness_scale": scale})], seed=1
    )
    verdict = cbpt.diagnose(CASE, readings).verdict
    assert (verdict.kind, verdict.effects) == ("parameter", ("contact_stiffness",))
    assert verdict.probability > 0.9


def test_a_preload_in_another_unit_is_refused() -> None:
    """Twice the stiffness turns the drive nearly as far as a preload read in N, not in lbf."""
    plain = cbpt.simulate(CASE, TABLE, seed=1)
    assert plain.preload_N is not None
    with pytest.raises(cbpt.ReadingsError, match=r"multiplied by 4\.44822"):
        cbpt.diagnose(CASE, replace(plain, preload_N=plain.preload_N / 4.448222))


def test_a_torque_sensor_off_zero_is_no_nonlinear_angle_sensor() -> None:
    """Where the drive is soft the angle is off, at torques of both signs alike."""
    readings = cbpt.simulate(CASE, TABLE, effects=[("torque_zero", {"zero_error_Nm": 0.4})], seed=1)
    found = cbpt.diagnose(CASE, readings)
    assert (found.verdict.kind, found.verdict.effects) == ("rig", ("torque_zero",))
    value = found.parameters(found.after, "torque_zero")["zero_error_Nm"]
    assert value["value"] == pytest.approx(0.4, abs=3 * value["u"])


@pytest.mark.parametrize(
    ("effect", "parameter", "value"),
    [
        ("torque_lag", "lag_s", 1.5),
        ("damping", "time_constant_s", 1.5),
        ("torque_hysteresis", "half_width_Nm", 0.12),
        ("preload_crosstalk", "crosstalk_force_N", 25.0),
        ("preload_crosstalk", "crosstalk_share", 0.1),
        ("span_drift", "rate_per_K", 0.01),
        ("torque_zero", "zero_drift_Nm_per_s", 1e-4),
    ],
)
def test_what_data_sheets_of_instruments_state_and_damping_are_no_friction(
    effect: str, parameter: str, value: float
) -> None:
    """Nor a spring or a preload that follows the temperature."""
    at = {"reference_torque_Nm": 8.0} if effect == "preload_crosstalk" else {}
    readings = cbpt.simulate(CASE, TABLE, effects=[(effect, {parameter: value, **at})], seed=1)
    found = cbpt.diagnose(CASE, readings)
    assert found.verdict.effects == (effect,)
    assert found.verdict.kind == ("effect" if effect in ("span_drift", "damping") else "rig")
    fitted = found.parameters(found.after, effect)[parameter]
    assert fitted["value"] == pytest.approx(value, abs=3 * fitted["u"])


@pytest.mark.parametrize("preloads", [1, 4])
@pytest.mark.parametrize(
    ("effect", "numbers"),
    [
        ("preload_crosstalk", {"crosstalk_share": 0.02, "reference_torque_Nm": 8.0}),
        ("torque_zero", {"zero_error_Nm": 0.1}),
    ],
)
def test_one_preload_does_not_tell_a_crosstalk_from_a_torque_zero(
    preloads: int, effect: str, numbers: dict[str, float]
) -> None:
    """The zero was certain: it was 150 times as likely before any reading."""
    assert TABLE.preload_N is not None
    table = TABLE.select(np.isin(TABLE.preload_N, np.unique(TABLE.preload_N)[:preloads]))
    readings = cbpt.simulate(CASE, table, effects=[(effect, numbers)], seed=1)
    verdict = cbpt.diagnose(CASE, readings).verdict
    if preloads > 1:
        assert (verdict.effects, verdict.rivals) == ((effect,), ())
    else:
        (group,) = verdict.rivals
        assert not verdict.effects and {"preload_crosstalk", "torque_zero"} <= set(group)


@pytest.mark.parametrize("zero_error_Nm", [-0.12, 0.12])
def test_a_zero_error_that_drifts_is_one_effect(zero_error_Nm: float) -> None:
    hidden = {"zero_error_Nm": zero_error_Nm, "zero_drift_Nm_per_s": 1e-4}
    readings = cbpt.simulate(CASE, TABLE, effects=[("torque_zero", hidden)], seed=1)
    found = cbpt.diagnose(CASE, readings)
    assert (found.verdict.effects, found.verdict.rivals) == (("torque_zero",), ())
    fitted = found.parameters(found.after, "torque_zero")
    for name, value in hidden.items():
        assert fitted[name]["value"] == pytest.approx(value, abs=3 * fitted[name]["u"])


def test_a_load_behind_friction_of_the_rig_is_told_beside_friction_of_the_drive() -> None:
    """At four preloads nothing tells it from friction that none of them changes."""
    behind = ("torque_hysteresis", {"half_width_Nm": -0.12})
    found = cbpt.diagnose(CASE, cbpt.simulate(CASE, TABLE, effects=[behind], seed=1))
    told = {*found.verdict.effects, *(e for g in found.verdict.rivals for e in g)}
    noted = any(n.startswith("torque_hysteresis") and "would explain" in n for n in found.notes)
    assert noted or "torque_hysteresis" in told, found.sentence


@pytest.mark.parametrize("torque_noise_Nm", [0.0, 0.05])
def test_first_readings_that_are_off_alike_are_no_certain_play(torque_noise_Nm: float) -> None:
    """Ramps from zero, one way: only first readings are without torque, and a play moves all others
    by what moves these the other way. The play was certain."""
    ramp_Nm, runs = np.linspace(0.0, 8.0, 22), 12
    table = {
        "run": np.repeat(np.arange(1.0, runs + 1), len(ramp_Nm)),
        "torque_Nm": np.tile(ramp_Nm, runs),
        "preload_N": np.repeat([450.0, 600.0, 800.0] * 4, len(ramp_Nm)),
        "input_angle_deg": np.repeat(np.arange(runs) * 30.0, len(ramp_Nm)),
        "elastic_angle_arcsec": np.zeros(runs * len(ramp_Nm)),
    }
    read = cbpt.simulate(CASE, cbpt.read_readings(table), u_elastic_angle_arcsec=0.3, seed=1)
    off = np.where(np.arange(len(read)) % len(ramp_Nm) == 0, -2.0, 0.0)
    angle = read.elastic_angle_arcsec + off
    noise_Nm = torque_noise_Nm * np.random.default_rng(5).standard_normal(len(read))
    shown = replace(read, torque_Nm=read.torque_Nm + noise_Nm, elastic_angle_arcsec=angle)
    found = cbpt.diagnose(CASE, shown)
    assert found.verdict.effects == (), found.sentence
    assert "first reading of each run that is off" in found.sentence


def test_first_readings_that_are_off_by_different_angles_are_no_hysteresis() -> None:
    rng = np.random.default_rng(1)
    angle = cbpt.simulate(CASE, TABLE, u_elastic_angle_arcsec=1e-9).elastic_angle_arcsec
    read = angle + U_ARCSEC * rng.standard_normal(len(angle))
    first = np.unique(TABLE.run_index, return_index=True)[1]
    read[first] += 8 * U_ARCSEC * (1 + 0.3 * rng.standard_normal(len(first)))
    found = cbpt.diagnose(CASE, replace(TABLE, elastic_angle_arcsec=read)).verdict
    assert (found.kind, found.effects, found.rivals) == ("rig", (), ())
    assert found.noise == ("first_reading",)


def test_a_zero_that_wanders_is_seen_in_few_readings_too() -> None:
    """A fit that may follow the whole library follows it as well there."""
    few = TABLE.select(TABLE.run_index < 5)
    angle = cbpt.simulate(CASE, few, u_elastic_angle_arcsec=1e-9).elastic_angle_arcsec
    rng = np.random.default_rng(1)
    assert few.time_s is not None
    passed = np.diff(few.time_s, prepend=few.time_s[0]) / np.ptp(few.time_s)
    walk = np.cumsum(np.sqrt(passed) * rng.standard_normal(len(angle)))
    read = angle + U_ARCSEC * (rng.standard_normal(len(angle)) + 8 * walk)
    found = cbpt.diagnose(CASE, replace(few, elastic_angle_arcsec=read)).verdict
    assert (found.kind, found.effects, found.rivals) == ("rig", (), ())
    assert found.noise == ("random_walk",)


def test_two_runs_with_zeros_of_their_own_demand_no_effect() -> None:
    """A permanent set of the first run, say, would look the same."""
    two = TABLE.select(TABLE.run_index < 2)
    angle = cbpt.simulate(CASE, two, u_elastic_angle_arcsec=U_ARCSEC, seed=5).elastic_angle_arcsec
    read = angle + np.where(two.run_index == 1, 4 * U_ARCSEC, 0.0)
    found = cbpt.diagnose(CASE, replace(two, elastic_angle_arcsec=read)).verdict
    assert not set(found.effects) - {"run_offset"}, found
    assert all("run_offset" in group for group in found.rivals)


@pytest.mark.parametrize("place", [10, 30])
def test_a_wrong_reading_at_the_end_of_a_loop_is_no_curve(place: int) -> None:
    """Where nothing else was read at such a torque, a curve may follow it as well."""
    up = np.linspace(0, 9, 11)
    torque_Nm = np.concatenate([up, up[-2::-1], -up[1:], -up[-2::-1]])
    n = len(torque_Nm)
    table = {
        "torque_Nm": torque_Nm,
        "preload_N": np.full(n, 500.0),
        "time_s": np.arange(float(n)),
        "elastic_angle_arcsec": np.zeros(n),
    }
    rows = cbpt.read_readings(table)
    readings = cbpt.simulate(CASE, rows, seed=1, u_elastic_angle_arcsec=U_ARCSEC)
    angle = np.array(readings.elastic_angle_arcsec)
    angle[place] += 15 * U_ARCSEC
    found = cbpt.diagnose(CASE, replace(readings, elastic_angle_arcsec=angle))
    assert found.verdict.effects == () and found.verdict.rivals == (), found.sentence
    assert "outliers" in found.verdict.noise


def test_zeros_of_runs_that_the_table_does_not_number_are_none_of_the_drive() -> None:
    """Each run at an input angle of its own: a runout, a tilt or an unknown effect took them."""
    rng = np.random.default_rng(5)
    runs = TABLE.run_index.max() + 1
    angle = cbpt.simulate(CASE, TABLE, seed=2, u_elastic_angle_arcsec=U_ARCSEC).elastic_angle_arcsec
    turned = np.linspace(0.0, 300.0, runs)[TABLE.run_index]
    assert TABLE.time_s is not None and TABLE.preload_N is not None
    table = {
        "time_s": TABLE.time_s + 4000.0 * TABLE.run_index,
        "torque_Nm": TABLE.torque_Nm,
        "preload_N": TABLE.preload_N,
        "input_angle_deg": turned,
        "elastic_angle_arcsec": angle + 3 * rng.standard_normal(runs)[TABLE.run_index],
        "u_elastic_angle_arcsec": np.full(len(angle), U_ARCSEC),
    }
    verdict = cbpt.diagnose(CASE, table).verdict
    said = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
    assert "run_offset" in said and set(verdict.effects) <= {"run_offset"}
