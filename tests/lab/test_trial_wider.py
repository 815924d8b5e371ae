"""The wider families of the trial, their instrument, springs, the oracle of sets and the targets.

Groups: the instrument; springs; campaigns and their strength; evidence; the adapter; what is
claimed; the table; a run that is taken up again.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import integrate, stats

import cbpt
from common.rings import RINGS as CASE
from reference.contact import Floats
from reference.rig import ARCSEC, Rows, drive_of, simulate
from reference.rig.bench import meshing, read_behind, slight_friction
from reference.rig.campaign import PRIORS, Campaign, Plan, rows_of
from reference.rig.effects import Hidden, hidden
from reference.rig.instrument import (
    ARTEFACTS,
    COARSE,
    TOGETHER,
    ZEROS,
    Instrument,
    instrument,
    noise_of,
    plain_values,
)
from reference.rig.springs import (
    SPRING_EFFECTS,
    Spring,
    SpringEffect,
    draw_spring_effect,
    spring_rows,
    turned_rad,
)
from trial import answers, claims
from trial.adapter import READERS, Said, kept, read
from trial.evidence import Candidate, inclusion, likeliest, posterior, spoken
from trial.page import BEFORE, section, write_page
from trial.rivals import yardstick_of
from trial.run import FOR_EACH, SHORT, indices, interleaved, run
from trial.spring_sets import SpringYard, spring_set
from trial.strength import ZERO_PRIOR_RAD
from trial.targets import calibration_error, targets
from trial.wider import OTHERS, WIDER, Wider, make_wider

LONG = Rows(
    run=np.repeat(np.arange(4), 6),
    time_s=np.arange(24.0) * 2,
    torque_Nm=np.tile([0.0, 1.0, 2.0, 1.0, 0.0, -1.0], 4),
    preload_N=np.full(24, 500.0),
    input_angle_rad=np.zeros(24),
    temperature_degC=np.full(24, 20.0),
    cycle=np.ones(24, dtype=np.int64),
)


# --- the instrument ---------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [TOGETHER, *COARSE, "random_walk"])
def test_readings_scatter_as_their_covariance_says(kind: str) -> None:
    noise = instrument(kind, 1.0, 1.0, np.random.default_rng(1))
    assert isinstance(noise, Instrument) and (noise.offset_rad > 0) == (kind in ZEROS)
    rng = np.random.default_rng(2)
    angle = 31.7 * LONG.torque_Nm + 0.37 * np.arange(24)
    read = np.array([noise.readings(angle, LONG, rng) - angle for _ in range(4000)])
    wanted = noise.covariance(LONG)
    sigma = np.sqrt((wanted**2 + np.outer(np.diag(wanted), np.diag(wanted))) / len(read))
    # A display's rounding is correlated with nothing only where the noise is as large as its step.
    allowed = 5 * sigma + (0.03 if noise.display_rad else 0.0)
    assert (np.abs(np.cov(read.T) - wanted) < allowed).all()
    assert noise_of(plain_values(noise)) == noise


@pytest.mark.parametrize("kind", COARSE)
def test_a_coarse_display_shows_its_steps(kind: str) -> None:
    noise = instrument(kind, 0.3, 1.0, np.random.default_rng(5))
    assert isinstance(noise, Instrument) and 1.7 <= noise.display_rad / noise.u_rad <= 2.0
    shown = noise.readings(7.0 * LONG.torque_Nm, LONG, np.random.default_rng(6)) / noise.display_rad
    np.testing.assert_allclose(shown, np.round(shown), atol=1e-9)


def test_artefacts_of_the_angle() -> None:
    rng = np.random.default_rng(3)
    angle = np.linspace(0, 60 * ARCSEC, 24)
    first = instrument("first_reading", 1e-12, 1.0, rng)
    assert isinstance(first, Instrument)
    off = (first.readings(angle, LONG, rng) - angle) / first.first_rad
    np.testing.assert_allclose(off, np.arange(24) % 6 == 0, atol=1.5)  # the noise is 1/2 to 1/6
    encoder = Instrument("encoder", 0.0, 0.0, ripple_rad=1e-6, period_rad=10 * ARCSEC)
    ripple = encoder.readings(angle, LONG, rng) - angle
    turns = 2 * np.pi * angle / (10 * ARCSEC)
    waves = np.column_stack([np.sin(turns), np.cos(turns)])
    size, left, *_ = np.linalg.lstsq(waves, ripple, rcond=None)
    assert np.hypot(*size) == pytest.approx(1e-6) and left[0] < 1e-24


def test_artefacts_of_the_torque() -> None:
    rng = np.random.default_rng(4)
    display = Instrument("torque_display", 0.1, 0.1, torque_step_Nm=0.3)
    real, shown = display.loads(LONG, rng)
    steps = shown.torque_Nm / 0.3
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    apart = np.abs(real.torque_Nm - shown.torque_Nm)
    assert 0.1 < apart.max() <= 0.15 and apart[0] == 0
    lag = Instrument("torque_hysteresis", 0.1, 0.1, torque_lag_Nm=0.2)
    real, shown = lag.loads(LONG, rng)
    np.testing.assert_array_equal(shown.torque_Nm, LONG.torque_Nm)
    behind = (real.torque_Nm - shown.torque_Nm)[:6]
    np.testing.assert_allclose(behind, [0, 0.2, 0.2, -0.2, -0.2, -0.2], atol=1e-12)


def test_artefacts_move_readings_by_a_few_uncertainties() -> None:
    """Through the compliance of the drive, those of the torque too."""
    for kind in ARTEFACTS:
        rng = np.random.default_rng(8)
        noise = instrument(kind, 1e-9, 1e-6, rng)
        assert isinstance(noise, Instrument)
        real, shown = noise.loads(LONG, rng)
        moved = replace(noise, u_rad=0.0).readings(1e-6 * real.torque_Nm, real, rng)
        off = np.abs(moved - 1e-6 * shown.torque_Nm).max() / 1e-9
        assert 0.5 < off < 12, kind


# --- torsion springs --------------------------------------------------------------------------

SPRING = Spring(1000.0, 10.0)
LOOP = spring_rows(10.0, 2, 8, 2.0, np.random.default_rng(0))


@pytest.mark.parametrize("effect_id", SPRING_EFFECTS)
def test_a_spring_without_size_is_its_stiffness(effect_id: str) -> None:
    rng = np.random.default_rng(1)
    for form in SPRING_EFFECTS[effect_id]:
        effect = draw_spring_effect(effect_id, form, rng)
        plain = LOOP.torque_Nm / 1000
        none = turned_rad(SPRING, LOOP, [effect.sized(0.0)])
        np.testing.assert_allclose(none, plain, atol=1e-15)
        more = [np.abs(turned_rad(SPRING, LOOP, [effect.sized(s)]) - plain).max() for s in (1, 2)]
        assert 0.0001 < more[0] < more[1], (effect_id, form)


def test_friction_of_a_spring_makes_loops_that_lose_work() -> None:
    for form in SPRING_EFFECTS["friction_hysteresis"]:
        effect = SpringEffect("friction_hysteresis", form, 0.1, 0.05)
        one = LOOP.take(np.flatnonzero(LOOP.run == 1))
        angle = turned_rad(SPRING, one, [effect])
        up, down = np.arange(1, 8), 16 - np.arange(1, 8)
        assert (angle[up] < angle[down]).all(), form
        work = float(np.sum((one.torque_Nm[1:] + one.torque_Nm[:-1]) / 2 * np.diff(angle)))
        assert work > 0, form
    plain = SpringEffect("friction_hysteresis", "dahl", 0.1, 1e-4)
    slipping = turned_rad(SPRING, one, [plain])[up]
    np.testing.assert_allclose(slipping, (one.torque_Nm[up] - 1.0) / 1000, rtol=1e-6)


def test_a_loop_of_a_spring_begins_where_the_one_before_it_ended() -> None:
    """As the library has it too."""
    effect = SpringEffect("friction_hysteresis", "dahl", 0.1, 0.05)
    angle = turned_rad(SPRING, LOOP, [effect])
    half = len(angle) // 2
    assert angle[half] == angle[half - 1] < 0.0 == angle[0]
    numbers = {
        "id": "friction_hysteresis",
        "friction_torque_Nm": 1.0,
        "engagement_angle_arcsec": 0.0005 / ARCSEC,
    }
    case = {
        "torsion_spring": {"torsional_stiffness_Nm_per_arcmin": 1000.0 * 60 * ARCSEC},
        "effect": [numbers],
    }
    readings = {"run": LOOP.run, "time_s": LOOP.time_s, "torque_Nm": LOOP.torque_Nm}
    found = cbpt.compare(case, {**readings, "elastic_angle_arcsec": angle / ARCSEC})
    np.testing.assert_allclose(found.residual_arcsec, 0.0, atol=1e-6)


def test_play_and_curve_of_a_spring() -> None:
    play = turned_rad(SPRING, LOOP, [SpringEffect("backlash", "hard", 0.2, 0.05)])
    off = play - LOOP.torque_Nm / 1000
    np.testing.assert_allclose(off, np.sign(LOOP.torque_Nm) * 0.1 * 0.01, atol=1e-15)
    curve = turned_rad(SPRING, LOOP, [SpringEffect("stiffness_curve", "stiffening", 0.1, 0.5)])
    wanted = LOOP.torque_Nm / 1000 - 0.1 * 0.01 * (LOOP.torque_Nm / 10) ** 3
    np.testing.assert_allclose(curve, wanted, atol=1e-15)


# --- campaigns and their strength -------------------------------------------------------------

SEED = 3


@cache
def made(family: Wider, index: int) -> tuple[Campaign, dict[str, Any] | None]:
    return make_wider(family, index, SEED)


def least_left(columns: Floats, own: Floats, covariance: Floats, prior_sd: Floats) -> float:
    """Norm that the best combination of some columns leaves, by ordinary least squares on
    readings and priors together."""
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    known = prior_sd < 1e3
    prior = np.diag(1 / prior_sd)[known]
    a = np.vstack([white @ columns, prior])
    y = np.r_[white @ own, np.zeros(len(prior))]
    best = np.linalg.lstsq(a, y, rcond=None)[0]
    return float(np.linalg.norm(y - a @ best))


@pytest.mark.long
@pytest.mark.parametrize(("family", "index"), [("two", 1), ("three", 0)])
def test_conditional_strength(family: Wider, index: int) -> None:
    """Of every hidden effect, the sizes of the others and the numbers of the drive refitted."""
    c, _ = made(family, index)
    effects = [e for e in c.effects if isinstance(e, Hidden)][-len(c.truth["hidden"]) :]
    y = yardstick_of(c)
    drive = drive_of(c.case)
    every = simulate(drive, c.rows, c.effects)
    own = []
    for e in effects:
        less = [x for x in c.effects if x is not e]
        own.append(every - simulate(drive, c.rows, less))
    covariance = noise_of(c.truth["noise"]).covariance(c.rows)
    ones = np.full((len(c.rows), 1), ARCSEC)
    for i, left in enumerate(c.truth["conditional"]):
        others = [x for j, x in enumerate(own) if j != i]
        columns = np.column_stack([y.slopes_rad, ones, *others])
        # Sizes and zero are free: priors far wider than anything that is tried.
        sd = np.r_[np.ones(y.slopes_rad.shape[1]), np.full(1 + len(others), 1e6)]
        assert least_left(columns, own[i], covariance, sd) == pytest.approx(left, rel=1e-3)
    assert min(c.truth["conditional"]) == c.truth["d"]
    wanted = 12.0 if family == "three" else 8.0
    assert c.truth["d"] == pytest.approx(wanted, rel=0.05)


@pytest.mark.long
def test_one_effect_has_its_strength_when_all_numbers_are_refitted() -> None:
    c, asked = made("one", 1)
    assert c.truth["noise"]["kind"] == TOGETHER and asked
    effect = [e for e in c.effects if isinstance(e, Hidden)][-1]
    assert yardstick_of(c).strength(effect) == pytest.approx(8.0, rel=0.12)


def test_a_spring_has_its_strength() -> None:
    c, _ = spring_set(np.random.default_rng(2), 1.0, 4)
    ids = [h["id"] for h in c.truth["hidden"]]
    assert ids == ["friction_hysteresis", "backlash"] and "preload_N" not in c.columns()
    stated = Spring(
        c.case["torsion_spring"]["torsional_stiffness_Nm_per_arcmin"] * 10800 / np.pi,
        float(c.rows.torque_Nm.max()),
    )
    shifts = c.truth["shifts"]
    real = Spring(
        stated.stiffness_Nm_per_rad,
        stated.top_Nm,
        shifts["contact_stiffness_rel"],
        float(np.exp(shifts["torque_gain_rel"])),
        float(np.exp(shifts["sensor_gain_rel"])),
        tuple(c.truth["past"]),
    )
    effects = [SpringEffect(**h["values"]) for h in c.truth["hidden"]]
    every = turned_rad(real, c.rows, effects)
    own = [every - turned_rad(real, c.rows, [e for e in effects if e is not x]) for x in effects]
    noise = noise_of(c.truth["noise"])
    plain = turned_rad(real, c.rows)
    by_gain = [-plain * PRIORS["contact_stiffness_rel"], plain * PRIORS["torque_gain_rel"]]
    slopes = np.column_stack([*by_gain, plain * PRIORS["sensor_gain_rel"]])
    covariance = noise.covariance(c.rows)
    for i, left in enumerate(c.truth["conditional"]):
        columns = np.column_stack([slopes, np.full(len(c.rows), ARCSEC), own[1 - i]])
        sd = np.r_[np.ones(3), 1e6, 1e6]
        found = least_left(columns, own[i], covariance, sd)
        assert found == pytest.approx(left, rel=0.02)  # slopes of the yard are differences
    yard = SpringYard(real, c.rows, noise)
    zero = yard.whiten(np.full(len(c.rows), ARCSEC))
    assert np.linalg.norm(zero) == pytest.approx(ARCSEC / ZERO_PRIOR_RAD, rel=1e-2)


def test_tables_of_few_readings_and_without_a_law() -> None:
    for index, wanted in ((1, 6), (3, 8), (13, 25), (17, 40)):
        c, _ = made("small", index)
        assert len(c.rows) == wanted and not c.truth["hidden"]
    bare, _ = made("lawless", 1)
    assert "run" not in bare.columns() and len(bare.rows) == 8
    factor = bare.angle_rad / simulate(drive_of(bare.case), bare.rows, bare.effects)
    assert ((factor > 0.599) & (factor < 1.401)).all() and np.ptp(factor) > 0.2


def test_a_cross_slide_is_one() -> None:
    assert all(made("slide", i)[0].case["equal_speed"]["kind"] == "cross_slide" for i in (4, 9))


def test_every_noise_has_effects_and_seeds_are_kept() -> None:
    kinds = {made("coarse", i)[0].truth["noise"]["kind"] for i in range(4)}
    assert kinds == {TOGETHER, *COARSE}
    kinds = {made("artefact", i)[0].truth["noise"]["kind"] for i in (*range(5), 20)}
    assert kinds == set(ARTEFACTS) and len(OTHERS) == 6
    again, other = make_wider("coarse", 0, SEED)[0], make_wider("coarse", 0, SEED + 1)[0]
    assert again.to_csv() == made("coarse", 0)[0].to_csv() != other.to_csv()


# --- shortcuts of the bench -------------------------------------------------------------------

PLAN = Plan((500.0, 900.0), (20.0, 200.0), False, 1, 5, 0.8, True, (4.0,), 2.0)


def test_shortcuts_meet_the_simulation() -> None:
    drive = drive_of(CASE)
    rows = rows_of(PLAN, CASE, np.random.default_rng(0))
    base = (hidden("contact_stiffness", scale=1.1), hidden("sensor_gain", gain=1.01))
    known = meshing(drive, rows, base)
    every = (*base, hidden("bearing_play", clearance_m=2e-6), hidden("run_in", set_rad=1e-6))
    wanted = simulate(drive, rows, every)
    np.testing.assert_allclose(read_behind(drive, rows, every, known.angle_rad), wanted, rtol=1e-12)
    stiff = (*base, hidden("preload_loss", share=0.05))
    warm = simulate(drive, rows, stiff, known.states)
    np.testing.assert_allclose(warm, simulate(drive, rows, stiff), rtol=1e-9)
    for form in ("library", "iwan", "own_angle"):
        rub = hidden("friction_hysteresis", form, mu_T_m=1e-6, length_rad=6 * ARCSEC)
        found = slight_friction(drive, rows, (rub,), meshing(drive, rows))
        full = simulate(drive, rows, (rub,)) - simulate(drive, rows)
        np.testing.assert_allclose(found, full, atol=0.01 * np.abs(full).max())


# --- evidence ---------------------------------------------------------------------------------


def test_evidence_is_that_of_the_normal_distribution() -> None:
    rng = np.random.default_rng(0)
    b, c, z = rng.normal(size=(7, 2)), rng.normal(size=(7, 1)), rng.normal(size=7)
    some = [Candidate("b", "", b), Candidate("c", "one", c), Candidate("c", "two", 2 * c)]
    found = posterior(z, some, odds={"": 0.2})

    def density(*parts: Floats) -> float:
        wide = np.eye(7) + sum((p @ p.T for p in parts), np.zeros((7, 7)))
        return float(stats.multivariate_normal(np.zeros(7), wide).pdf(z))

    weights = {
        frozenset[str](): density(),
        frozenset("b"): 0.2 * density(b),
        frozenset("c"): 0.2 * (density(c) + density(2 * c)) / 2,
        frozenset("bc"): 0.04 * (density(b, c) + density(b, 2 * c)) / 2,
    }
    for names, weight in weights.items():
        assert found[names] == pytest.approx(weight / sum(weights.values()))


def test_a_size_of_one_sign_has_half_the_prior() -> None:
    rng = np.random.default_rng(1)
    c, z = rng.normal(size=(5, 1)), rng.normal(size=5)
    found = posterior(z, [Candidate("c", "", c, one_sided=True)], odds={"": 1.0})

    def integrand(size: float) -> float:
        likelihood = np.exp(-0.5 * np.sum((z - size * c[:, 0]) ** 2) + 0.5 * z @ z)
        return float(2 * likelihood * stats.norm.pdf(size))

    odds = integrate.quad(integrand, 0, 10)[0]
    assert found[frozenset("c")] / found[frozenset()] == pytest.approx(odds, rel=1e-6)


def test_the_oracle_finds_a_triple_and_tells_twins() -> None:
    rng = np.random.default_rng(2)
    columns = rng.normal(size=(60, 8))
    names = "abcdefgh"
    some = [c for n, x in zip(names, columns.T, strict=True) if (c := Candidate.of(n, "", [x]))]
    z = sum((c.columns[:, 0] for c in some[:3]), rng.normal(size=60))
    found = posterior(z, some)
    assert likeliest(found) == ["a", "b", "c"] and spoken(found)["effects"] == ["a", "b", "c"]
    twin = Candidate.of("x", "", [columns[:, 0] + 1e-3 * rng.normal(size=60)])
    assert twin
    said = spoken(posterior(z, [*some, twin]))
    assert said["effects"] == ["b", "c"] and said["rivals"] == [["a", "x"]]
    assert said["kind"] == "ambiguous" and said["probability"] > 0.95
    nothing = posterior(rng.normal(size=60), some)
    assert spoken(nothing)["kind"] == "complete" and max(inclusion(nothing).values()) < 0.2
    assert Candidate.of("a", "", [np.zeros(60)]) is None


# --- the adapter ------------------------------------------------------------------------------


def test_a_document_of_the_first_version() -> None:
    verdict = {"kind": "ambiguous", "effects": ["a"], "rivals": [["b", "unknown"]]}
    verdict["probability"] = 0.9  # type: ignore[assignment]
    document = {"schema": "cbpt.diagnosis/1", "verdict": verdict, "where": [1], "noise": {}}
    said = read(document)
    assert said == Said("ambiguous", ("a",), (("b", "unknown"),), 0.9, remains=True)
    assert not said.perhaps and not said.undecided and "where" not in kept(document)


def test_another_version_needs_a_reader_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    document = {"schema": "cbpt.diagnosis/9", "names": ["a"]}
    with pytest.raises(ValueError, match=r"no reader.*READERS in adapter\.py"):
        read(document)
    monkeypatch.setitem(READERS, "cbpt.diagnosis/9", lambda d: Said("e", tuple(d["names"]), (), 1))
    assert read(document).effects == ("a",)


# --- what is claimed --------------------------------------------------------------------------


def said(
    family: str, accepted: list[list[str]], answer: dict[str, Any], **truth: Any
) -> dict[str, Any]:
    noise = {"kind": "white", "run_offset_arcsec": truth.pop("zeros", 0.0)}
    full: dict[str, Any] = {"kind": "effect", "effects": (), "rivals": (), "probability": 0.95}
    hidden = [{"id": ids[0], "form": "made up"} for ids in accepted]
    known = {"accepted": accepted, "noise": noise, "d": 12.0, "hidden": hidden, "answer": {}}
    return {"family": family, "truth": {**known, **truth}, "answer": full | answer, "oracle": None}


PAIR = [["creep"], ["bearing_play", "backlash"]]
UNKNOWN = {"kind": "unknown", "remains": True}
NONE = {"kind": "complete"}
BOTH = {"effects": ("creep", "backlash")}
OPEN = {"effects": ("creep",), "rivals": (("bearing_play", "wear"),)}
CLAIMS = [  # outcome; held, named, is_so, misleads
    (said("two", PAIR, BOTH), (True, True, True, False)),
    (said("two", PAIR, OPEN), (True, False, True, False)),
    (said("two", PAIR, {"effects": ("creep",)}), (False, False, False, True)),
    (said("two", PAIR, {"rivals": (("creep", "backlash"),)}), (False, False, False, True)),
    (said("two", PAIR, {**BOTH, "rivals": (("wear", "drift"),)}), (True, False, False, False)),
    (said("two", PAIR, {"effects": (*BOTH["effects"], "wear")}), (True, False, False, True)),
    (
        said("two", PAIR, {"effects": (*BOTH["effects"], "run_offset")}, zeros=2.0),
        (True, True, True, False),
    ),
    (said("two", PAIR, NONE), (False, False, False, True)),
    (
        said("two", PAIR, {"effects": ("creep",), "probability_of": "named"}),
        (False, False, True, True),
    ),
    (said("coarse", [], NONE), (True, True, True, False)),
    (said("coarse", [], UNKNOWN), (True, True, False, True)),
    (said("coarse", [], {"effects": ("creep",)}), (True, False, False, True)),
    (said("artefact", [], UNKNOWN), (True, True, True, False)),
    (said("artefact", [], {"kind": "rig", "effects": ("drift",)}), (True, True, True, False)),
    (said("artefact", [], {"rivals": (("creep", "wear"),)}), (True, False, False, True)),
    (said("lawless", [], NONE, lawless=True), (True, True, False, True)),
    (said("lawless", [], {"undecided": True}, lawless=True), (True, True, True, False)),
    (said("outside", [], UNKNOWN), (True, True, True, False)),
    (said("outside", [], NONE), (True, True, False, True)),
    (said("outside", [], {"effects": ("creep",)}), (True, False, False, True)),
]


@pytest.mark.parametrize(("outcome", "wanted"), CLAIMS)
def test_claims(outcome: dict[str, Any], wanted: tuple[bool, ...]) -> None:
    found = (
        claims.held(outcome["answer"], claims.accepted(outcome)),
        claims.named(outcome),
        claims.is_so(outcome),
        claims.misleads(outcome),
    )
    assert found == wanted


def test_an_artefact_may_be_told_as_the_rig() -> None:
    physics: list[dict[str, Any]] = [{"effects": ("creep",)}, {"rivals": (("creep", "wear"),)}]
    rig: list[dict[str, Any]] = [
        {"effects": ("drift",)},
        {"rivals": (("creep", "drift"),)},
        UNKNOWN,
        NONE,
    ]
    assert all(claims.speaks_of_physics(said("artefact", [], a)) for a in physics)
    assert not any(claims.speaks_of_physics(said("artefact", [], a)) for a in rig)


def test_what_is_spoken_of_leaves_the_noise_out() -> None:
    answer = {"effects": ("a", "run_offset"), "rivals": (("b", "unknown"),), "perhaps": ("c",)}
    assert claims.spoken(said("two", PAIR, answer, zeros=1.0)) == {"a", "b", "c"}
    assert claims.spoken(said("two", PAIR, answer)) == {"a", "b", "c", "run_offset"}


# --- the table --------------------------------------------------------------------------------


def test_the_distance_from_the_oracle_is_paired() -> None:
    right, wrong = said("two", PAIR, BOTH), said("two", PAIR, NONE)
    oracle = {"oracle": {"answer": right["answer"]}}
    some = [{**right, **oracle}, {**wrong, **oracle}, {**wrong, **oracle}, {**right, **oracle}]
    found = {(m.name, m.where): m for m in targets(some)}
    where = "white, d >= 8"
    assert found["pair held", where].value == 0.5 and found["pair held", where].least == 0.75
    behind = found["  pair held, behind the oracle", where]
    assert behind.value == 0.5  # two lost, none won: 1/3 +- 1.96 sqrt(3 - 4/6)/6
    assert (behind.low, behind.high) == pytest.approx((2 / 6 - 0.49898, 2 / 6 + 0.49898), abs=1e-4)
    sure = found["p >= 0.9: truth not held, or false name", "all"]
    assert (sure.value, sure.sets, sure.reached) == (0.5, 4, "")
    wrong_name = found["p >= 0.9: no truth held, or a false name certain", "all"]
    assert (wrong_name.value, wrong_name.reached) == (0.5, "no")
    assert "| pair held | white, d >= 8 | 50.0 % |" in section(some, [5])


def test_every_target_stands_in_the_table() -> None:
    found = [m for m in targets([]) if m.least is not None or m.most is not None]
    asked = {(m.name.strip(), m.least, m.most) for m in found}
    assert {
        ("false alarm", None, 0.05),
        ("false alarm", None, 0.07),
        ("named as physics", None, 0.05),
        ("single held", 0.95, None),
        ("single held, behind the oracle", None, 0.05),
        ("single named, behind the oracle", None, 0.10),
        ("pair held", 0.75, None),
        ("pair held, behind the oracle", None, 0.10),
        ("pair named, behind the oracle", None, 0.15),
        ("triple held", 0.60, None),
        ("effects spoken of for each hidden", None, 1.5),
        ("outside: a name alone", None, 0.02),
        ("an effect certain", None, 0.0),
        ("p >= 0.9: no truth held, or a false name certain", None, 0.03),
        ("calibration error", None, 0.05),
    } <= asked


def test_calibration_error() -> None:
    stated, true = np.array([0.95, 0.91, 0.3, 0.35]), np.array([1.0, 0.0, 0.0, 1.0])
    assert calibration_error(stated, true) == pytest.approx((0.86 + 0.35) / 4)


def test_the_short_form_has_some_of_everything() -> None:
    work = interleaved(SHORT, 1)
    assert {family for family, _, _ in work} >= set(WIDER) and len(work) == len(set(work)) < 320
    half = {family for family, _, _ in work[: len(work) // 2]}
    assert half == set(SHORT)
    assert all(len(indices(f, 2)) == 2 * n for f, n in FOR_EACH.items())


# --- a run that is taken up again -------------------------------------------------------------


def test_a_run_that_was_killed_goes_on_where_it_was(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(answers, "KEPT", tmp_path)
    for folder in (answers.rig_folder, answers.answer_folder):
        folder.cache_clear()
    try:
        first = answers.outcome(("lawless", 0, SEED))
        assert first and first["document"]["schema"] == "cbpt.diagnosis/2"
        assert first["answer"]["kind"] and not first.get("error")

        def fails(*_: Any) -> Any:
            raise AssertionError("made again what was there")

        monkeypatch.setattr(answers, "diagnose", fails)
        monkeypatch.setattr(answers, "make_wider", fails)
        again = run([("lawless", 0, SEED)], workers=1, fresh=False, quiet=True)
        assert len(again) == 1 and again[0]["seconds"] == first["seconds"]
    finally:
        for folder in (answers.rig_folder, answers.answer_folder):
            folder.cache_clear()


def test_a_new_page_keeps_the_table_of_before(tmp_path: Path) -> None:
    page = tmp_path / "trial.md"
    page.write_text(f"# Old\n\n{BEFORE}\n\nkept\n\nWhat falls short and why: x\n")
    every = [said("two", PAIR, BOTH)]
    for _ in range(2):
        write_page(page, every, [5, 11])
        text = page.read_text()
        assert text.count(BEFORE) == 1 and text.count("kept\n") == 1 and "Old" not in text
        assert "| pair held |" in text and "seeds 5 and 11: 1 pair." in text
        assert "| 0.9 to 1.0 | 1 |" in text
        assert text.endswith("](trial-notes.md).\n")
