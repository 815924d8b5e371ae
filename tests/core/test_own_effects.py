"""Effects of the user's own: expressions and functions, fitted, ranked, added.

Groups: what they are; on the rows; fitted and added; in competition; the command line.
"""

from __future__ import annotations

import json
import pickle
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt import Case, CaseError, InvalidInputError, ReadingsError, effects
from cbpt._core import OwnEffect, Predictor
from cbpt.cli import main as commands
from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.own_terms import campaign_of, variant_of
from common.comparisons import columns_of
from common.hidden import FOLDER, TRUTH, case_of
from common.simulated import plan, readings_of, truth

Floats = NDArray[np.float64]
Rows = Mapping[str, Floats]
Listed = list[tuple[str | OwnEffect, dict[str, float]]]

CASE, DATA = FOLDER / "dev10.toml", FOLDER / "dev10.csv"
SIGMA = TRUTH["dev10"]["sigma_arcsec"]

DAMAGE = effects.expression(
    "groove_damage",
    "series",
    "a * sign(torque_Nm) * max(abs(torque_Nm) - t, 0) * exp(-((input_angle_rad - c) / w)^2)",
    {
        "a": {"unit": "rad/(N m)", "start": 1e-5, "min": 0.0, "max": 1e-3},
        "t": {"unit": "N m", "start": 2.0, "min": 0.0, "max": 6.0},
        "c": {"unit": "rad", "start": 2.2, "min": 1.8, "max": 2.8},
        "w": {"unit": "rad", "start": 0.5, "min": 0.1, "max": 1.0},
    },
)
"""What someone writes who has read the card of the unknown."""


def damage(rows: Rows, a: float, t: float, c: float, w: float) -> Floats:
    torque = rows["torque_Nm"]
    over = np.maximum(np.abs(torque) - t, 0)
    return a * np.sign(torque) * over * np.exp(-(((rows["input_angle_rad"] - c) / w) ** 2))


def as_function(of: OwnEffect, function: Any) -> OwnEffect:
    fields = {n: {"unit": u, "start": s, "min": lo, "max": hi} for n, u, s, lo, hi in of.parameters}
    adds_to = of.adds_to if of.port == "load" else None
    return effects.own_effect("function", of.port, function, fields, adds_to=adds_to)


# --- what they are ------------------------------------------------------------------------


def test_an_expression_is_an_entry_of_a_case_file() -> None:
    assert (DAMAGE.id, DAMAGE.port, DAMAGE.adds_to) == ("groove_damage", "series", "angle_rad")
    case = Case.from_toml(case_of("dev10") + DAMAGE.to_toml())
    assert [own.expression for own in case.own_effects] == [DAMAGE.expression]
    assert case.own_effects[0].parameters == DAMAGE.parameters
    assert Case.from_toml(case.to_toml()) == case
    listed: Listed = [(DAMAGE, {"a": 2e-5}), ("creep", {"time_constant_s": 7.0})]
    moved = case.with_effects(listed)
    assert dict(moved.effects[0].values) == {"a": 2e-5, "t": 2.0, "c": 2.2, "w": 0.5}
    assert [effect.id for effect in moved.effects] == ["groove_damage", "creep"]


@pytest.mark.parametrize(
    ("id", "port", "expression", "parameters", "told"),
    [
        ("mine", "series", "a * torqe_Nm", {"a": 1.0}, "did you mean torque_Nm"),
        ("mine", "gap", "a", {"a": 1.0}, '"load", "series" or "reading"'),
        ("mine", "load", "a", {"a": 1.0}, '"torque_Nm" or "preload_N"'),
        ("creep", "series", "a", {"a": 1.0}, "a built-in effect has this id"),
        ("unknown", "series", "a", {"a": 1.0}, "has another meaning in answers"),
        ("my effect", "series", "a", {"a": 1.0}, "letters, digits and _"),
        ("mine", "series", "pi", {"pi": 1.0}, "has another meaning"),
        ("mine", "series", "a", {"a": float("nan")}, "a.start"),
        ("mine", "series", "a", {"a": {"start": 2.0, "max": 1.0}}, "must be in this order"),
        ("mine", "series", "a" * 5000, {"a": 1.0}, "longer than 1000 characters"),
        ("mine", "series", "__import__('os')", {}, "character"),
        ("mine", "series", "ａ + 1", {"a": 1.0}, "character 1"),
    ],
)
def test_a_mistake_is_told_as_in_a_case_file(
    id: str, port: str, expression: str, parameters: Any, told: str
) -> None:
    with pytest.raises((CaseError, InvalidInputError)) as error:
        effects.expression(id, port, expression, parameters)
    assert told in str(error.value)
    if "character" not in told and "torqe" not in expression:
        with pytest.raises((CaseError, InvalidInputError)):
            effects.own_effect(id, port, lambda rows, **p: 0.0, parameters)


def test_what_a_message_tells_is_handed_over_beside_it() -> None:
    with pytest.raises(CaseError) as error:
        effects.expression("mine", "reading", "a * torqe_Nm", {"a": 1.0})
    (mistake,) = pickle.loads(pickle.dumps(error.value)).mistakes
    assert (mistake.key, mistake.found) == ("effect[0].expression", '"a * torqe_Nm"')
    assert (mistake.nearest, mistake.place) == ("torque_Nm", (None, None, 5))
    place = f"{mistake.key} = {mistake.found}, character 5: "
    assert str(error.value) == place + mistake.words


def test_an_invalid_number_is_handed_over_with_its_field() -> None:
    with pytest.raises(InvalidInputError) as error:
        Case.from_toml(case_of("dev03")).drive.solve(1.0, -2.0)
    copy = pickle.loads(pickle.dumps(error.value))
    assert (copy.field, copy.found) == ("preload_N", "-2")
    assert str(copy) == str(error.value) == f"preload_N = -2: {copy.required}"


# --- on the rows --------------------------------------------------------------------------


def predictor(name: str, *which: str | OwnEffect) -> Predictor:
    campaign = plan(name)
    r = campaign.readings
    assert r.preload_N is not None and r.time_s is not None
    return Predictor(
        campaign.drive,
        list(which),
        campaign.rows.run_index,
        r.time_s,
        r.torque_Nm,
        r.preload_N,
        np.deg2rad(r.input_angle_deg),
        r.temperature_degC,
    )


SAME: dict[str, tuple[OwnEffect, Any, dict[str, float]]] = {
    "creep": (
        effects.expression(
            "mine",
            "series",
            "a * torque_Nm * log(1 + run_time_s / tau)",
            {"a": 2e-6, "tau": {"start": 20.0, "min": 1.0, "max": 1e4}},
        ),
        lambda rows, a, tau: a * rows["torque_Nm"] * np.log1p(rows["run_time_s"] / tau),
        {"compliance_rad_per_Nm": 2e-6, "time_constant_s": 20.0},
    ),
    "output_torsion": (
        effects.expression("mine", "series", "c * torque_Nm", {"c": 3e-6}),
        lambda rows, c: c * rows["torque_Nm"],
        {"compliance_rad_per_Nm": 3e-6},
    ),
    "preload_loss": (
        effects.expression("mine", "load", "-e * preload_N", {"e": 0.2}, adds_to="preload_N"),
        lambda rows, e: -e * rows["preload_N"],
        {"lost_share": 0.2},
    ),
    "sensor_gain": (
        effects.expression("mine", "reading", "(g - 1) * alpha_rad", {"g": 1.1}),
        lambda rows, g: (g - 1) * rows["alpha_rad"],
        {"sensor_gain": 1.1},
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_all_three_ways_are_the_effect_of_the_library(name: str) -> None:
    """Beside friction and a gain, whose slopes go through the own effect."""
    own, function, numbers = SAME[name]
    beside = ["torque_scale", "friction_hysteresis"]
    built_in, by_text, by_function = (
        predictor("dev03", *beside, e) for e in (name, own, as_function(own, function))
    )
    # Friction that follows the preload alone.
    values = np.r_[1.02, 1e-3, 4e-5, 0, 0, 1, list(numbers.values())]
    wanted = [0, 1, 2, *range(6, len(values))]
    # The library's effect may have further forms, which do nothing here.
    further = built_in.neutral()[len(values) :]
    a = built_in.predict(np.r_[values, further], wanted)
    b, c = (p.predict(values, wanted) for p in (by_text, by_function))
    for found, share in ((b, 1e-12), (c, 1e-7)):
        np.testing.assert_allclose(found.angle_rad, a.angle_rad, rtol=1e-12, atol=1e-18)
        scale = np.abs(a.sensitivities).max(axis=0)
        difference = np.abs(found.sensitivities - a.sensitivities) / scale
        assert difference.max() < max(share, 1e-10)


def test_a_function_is_called_once_for_all_rows_and_may_not_write() -> None:
    shapes: list[tuple[int, ...]] = []

    def watched(rows: Rows, a: float) -> Floats:
        shapes.append(rows["torque_Nm"].shape)
        with pytest.raises(ValueError, match="read-only"):
            rows["torque_Nm"][0] = 1.0
        return a * rows["torque_Nm"]

    own = effects.own_effect("mine", "series", watched, {"a": 1e-6})
    model = predictor("dev03", own)
    model.predict(np.array([1e-6]))
    assert shapes == [(396,)]
    model.predict(np.array([1e-6]), [0])
    assert 2 <= len(shapes) <= 5 and set(shapes) == {(396,)}
    assert own.uses("torque_Nm") and not own.uses("time_s")


def test_what_a_function_raises_is_raised() -> None:
    def wrong(rows: Rows, a: float) -> Floats:
        raise ZeroDivisionError("mine")

    for function, kind, told in (
        (wrong, ZeroDivisionError, "mine"),
        (lambda rows, a: rows["torque"], InvalidInputError, "no column 'torque'"),
        (lambda rows, a: rows["alpha_rad"], InvalidInputError, "no column 'alpha_rad'"),
        (lambda rows, a: np.zeros(3), InvalidInputError, r"shape \(3,\), expected one number"),
    ):
        model = predictor("dev03", effects.own_effect("mine", "series", function, {"a": 1.0}))
        with pytest.raises(kind, match=told):
            model.predict(np.array([1.0]))


def test_a_function_that_fails_once_leaves_the_predictor_as_it_was() -> None:
    fails = [False]

    def sometimes(rows: Rows, g: float) -> Floats:
        if fails[0]:
            raise ArithmeticError
        return g * rows["alpha_rad"]

    model = predictor("dev03", effects.own_effect("mine", "reading", sometimes, {"g": 0.1}))
    before = model.predict(np.array([0.1])).angle_rad
    fails[0] = True
    with pytest.raises(ArithmeticError):
        model.predict(np.array([0.1]))
    fails[0] = False
    np.testing.assert_allclose(model.predict(np.array([0.1])).angle_rad, before, rtol=1e-12)


def test_variables_are_those_of_the_documentation() -> None:
    page = (FOLDER.parents[2] / "docs" / "how-to" / "own-effects.md").read_text(encoding="utf-8")
    page = " ".join(page.split())
    for name, meaning in effects.VARIABLES.items():
        assert f"| `{name}` | {meaning} |" in page
        effects.expression("mine", "reading", f"0 * {name}")
    with pytest.raises(CaseError, match="known are sin") as error:
        effects.expression("mine", "reading", "none(1)")
    known = error.value.mistakes[0].allowed.removeprefix("known are ")
    assert f"functions {known}".replace(", ", "`, `").replace("functions ", "`") in page


def test_loads_of_a_case_are_solved_with_its_effects() -> None:
    case = Case.from_toml(case_of("dev10") + DAMAGE.to_toml())
    torque = np.linspace(-5, 5, 11)
    bare = cbpt.solve_many(case.drive, torque[:, None], [600, 900], 130)
    found = cbpt.solve_many(case, torque[:, None], [600, 900], 130)
    np.testing.assert_allclose(found.alpha_deceleration_rad, bare.alpha_deceleration_rad, rtol=1e-9)
    columns = {"torque_Nm": torque, "input_angle_rad": np.full(11, np.deg2rad(130))}
    added = damage(columns, a=1e-5, t=2.0, c=2.2, w=0.5)
    change = found.elastic_angle_rad - bare.elastic_angle_rad
    np.testing.assert_allclose(change, np.tile(added[:, None], 2), atol=1e-14)
    assert (found.status == "ok").all()


# --- fitted and added ---------------------------------------------------------------------


@pytest.mark.parametrize("own", [DAMAGE, as_function(DAMAGE, damage)], ids=["text", "function"])
def test_the_missing_term_makes_the_error_fall_to_the_noise(own: OwnEffect) -> None:
    fitted = cbpt.fit(CASE, DATA, [own])
    assert fitted.before.rmse_arcsec > 10 * SIGMA
    assert fitted.after.rmse_arcsec == pytest.approx(SIGMA, rel=0.1)
    assert fitted.after.held_out_rmse_arcsec == pytest.approx(SIGMA, rel=0.1)
    found = fitted.parameters()[own.id]
    slope, _, _, threshold = TRUTH["dev10"]["hidden"]["groove_damage"]
    assert (
        found["a"]["value"] == pytest.approx(slope, rel=0.3) and found["a"]["unit"] == "rad/(N m)"
    )
    assert found["t"]["value"] == pytest.approx(threshold, abs=3 * found["t"]["u"])
    assert f"{own.id}: a 1." in fitted.report()
    if own.expression is None:
        with pytest.raises(
            InvalidInputError, match="a case cannot hold; write it as an expression"
        ):
            _ = fitted.case
        return
    again = cbpt.compare(Case.from_toml(fitted.case.to_toml()), DATA)
    assert again.overall is not None
    assert again.rmse_with_best_zero_arcsec == pytest.approx(fitted.after.rmse_arcsec, rel=1e-6)
    solved = cbpt.compare(CASE, DATA, effects=[own])
    assert solved.overall is not None and solved.overall.rmse_arcsec < 1.1 * SIGMA


def test_what_the_case_has_beside_stays() -> None:
    listed: Listed = [("creep", {"compliance_rad_per_Nm": 1e-8}), (DAMAGE, {})]
    case = Case.from_file(CASE).with_effects(listed)
    found = cbpt.fit(case, DATA, "groove_damage").case
    assert [e.id for e in found.effects if e.id in ("creep", "groove_damage")] == [
        "creep",
        "groove_damage",
    ]
    assert dict(found.effects[0].values)["compliance_rad_per_Nm"] == 1e-8


def test_sizes_shapes_and_ranges_are_seen() -> None:
    campaign = campaign_of(Case.from_file(CASE), cbpt.read_readings(DATA), [DAMAGE])
    (variant,) = campaign.candidates
    assert variant.sizes == ("a",) and not variant.signed and variant.high == 1e-3
    assert [shape.name for shape in variant.shapes] == ["t", "c", "w"]
    assert all(
        shape.low <= min(shape.grid) < max(shape.grid) <= shape.high for shape in variant.shapes
    )
    two = effects.expression(
        "two", "series", "p * torque_Nm + q * direction", {"p": 1e-6, "q": 2e-6}
    )
    campaign = campaign_of(Case.from_file(CASE), cbpt.read_readings(DATA), [two])
    assert campaign.candidates[0].sizes == ("p", "q") and campaign.candidates[0].signed
    assert campaign.candidates[0].ratios == (1.0, 2.0)


@pytest.mark.parametrize(
    ("expression", "parameters", "told"),
    [
        ("1e-6 * torque_Nm", {}, "has 0 parameters"),
        ("1e-6 * exp(-a * run_time_s)", {"a": 1.0}, "must have no influence when"),
        ("a * cycles_done * 0", {"a": 1.0}, "cycle"),
        ("a * 0", {"a": 1.0}, "choose other start values"),
        ("a * torque_Nm", {"a": 0.0}, "state its max"),
    ],
)
def test_what_cannot_be_fitted_is_told(expression: str, parameters: Any, told: str) -> None:
    own = effects.expression("mine", "series", expression, parameters)
    with pytest.raises((InvalidInputError, ReadingsError), match=told):
        cbpt.fit(CASE, DATA, [own])
    with pytest.raises((InvalidInputError, ReadingsError), match=told):
        diagnose(CASE, DATA, effects=[own])


def test_two_of_one_id_and_ids_of_nothing_are_refused() -> None:
    other = effects.expression("groove_damage", "series", "a * torque_Nm", {"a": 1e-6})
    with pytest.raises(InvalidInputError, match="two own effects have this id"):
        cbpt.fit(CASE, DATA, [DAMAGE, other])
    with pytest.raises(InvalidInputError, match="has no own effect with this id"):
        diagnose(CASE, DATA, effects=["creep"])


# --- in competition -----------------------------------------------------------------------

WAVE = effects.expression(
    "wave",
    "series",
    "a * sin(torque_Nm / s) * sign(preload_N - 600)",
    {
        "a": {"unit": "rad", "start": 1e-6, "min": -1e-4, "max": 1e-4},
        "s": {"unit": "N m", "start": 1.0, "min": 0.5, "max": 2.0},
    },
)
"""Unlike anything in the library."""


def test_an_own_effect_wins_where_it_is_true_and_only_there() -> None:
    campaign = plan("dev03")
    r = campaign.readings
    assert r.preload_N is not None
    rng = np.random.default_rng(5)
    wave = 3.0 * np.sin(r.torque_Nm / 1.2) * np.sign(r.preload_N - 600)
    for true, added in ((True, wave), (False, 0.0)):
        columns = columns_of("dev03")
        columns["u_elastic_angle_arcsec"][:] = 0.3
        hidden = {} if true else {("output_torsion", "compliance_rad_per_Nm"): 4e-6}
        columns["elastic_angle_arcsec"] = (
            truth(campaign, hidden) + added + 0.3 * rng.standard_normal(len(campaign))
        )
        case = Case.from_file(FOLDER / "dev03.toml")
        answer = diagnose(case, columns, effects=[WAVE])
        named = {*answer.verdict.effects, *(e for g in answer.verdict.rivals for e in g)}
        assert ("wave" in named) == true, answer.sentence
        ranked = {row["effect"]: row for row in answer.ranking()}
        if true:
            assert answer.verdict.kind == "effect" and answer.verdict.effects == ("wave",)
            assert answer.final_rung.rmse_arcsec == pytest.approx(0.3, rel=0.15)
            assert ranked["wave"]["parameters"]["s"]["unit"] == "N m"
            assert ranked["wave"]["parameters"]["a"]["value"] == pytest.approx(1.454e-5, rel=0.05)
            assert "wave (a 1.4" in answer.sentence
            json.loads(answer.to_json())
        else:
            assert "output_torsion" in named


def test_an_own_effect_costs_what_one_of_the_library_costs() -> None:
    """Fitted to its own readings, an expression of creep has the evidence of creep, but for its
    prior range."""
    campaign = plan("dev03")
    values = {("creep", "compliance_rad_per_Nm"): 3e-7, ("creep", "time_constant_s"): 30.0}
    campaign = readings_of(campaign, values, np.random.default_rng(1))
    own, *_ = SAME["creep"]
    parameters = {
        "a": {"start": 1e-7, "min": 0.0, "max": 1e-5},
        "tau": {"start": 20.0, "min": 1.0, "max": 1e4},
    }
    assert own.expression is not None
    own = effects.expression("mine", "series", own.expression, parameters)
    campaign = replace(campaign, own={"mine": own})
    campaign = replace(campaign, candidates=(variant_of(own, campaign),))
    fitter = Fitter(campaign)
    found = {}
    for name in ("creep", "mine"):
        variant = next(v for v in fitter.variants if v.effect == name)
        start = fitter.start(Hypothesis((variant,)), {f"{name}.{variant.sizes[0]}": 1e-7})
        found[name] = fitter.fit(Hypothesis((variant,)), start)
    creep, mine = found["creep"], found["mine"]
    assert creep is not None and mine is not None
    assert mine.residual_arcsec.std() == pytest.approx(creep.residual_arcsec.std(), rel=1e-3)
    assert mine.log_evidence == pytest.approx(creep.log_evidence, abs=1.0)


# --- the command line ---------------------------------------------------------------------


def test_from_the_case_file_to_the_case_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(case_of("dev10") + DAMAGE.to_toml(), encoding="utf-8")
    fit = ["fit", "mine.toml", str(DATA), "--with", "groove_damage", "--out", "fitted.toml"]
    assert commands.main(fit) == 0
    assert "groove_damage: a 1." in capsys.readouterr().out
    case = tomllib.loads(Path("fitted.toml").read_text(encoding="utf-8"))
    own = next(e for e in case["effect"] if e["id"] == "groove_damage")
    assert own["expression"] == DAMAGE.expression
    assert own["parameters"]["t"]["start"] == pytest.approx(3.0, abs=0.2)
    assert commands.main(["compare", "fitted.toml", str(DATA), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["overall"]["rmse_arcsec"] < 1.1 * SIGMA


# --- units ----------------------------------------------------------------------------------


def test_the_unit_of_a_parameter_counts() -> None:
    """0.2 arcsec/(N m) adds 0.2 arcsec for each N m, in whatever unit it is stated."""
    arcsec = np.pi / 648000
    bare = Case.from_toml(case_of("dev10"))
    for unit, size in (
        ("rad/(N m)", 1.0),
        ("arcsec/(N m)", arcsec),
        ("mrad / (kN m)", 1e-6),
        ("arcsec/(lbf in)", arcsec / 0.1129848290276167),
    ):
        a = {"unit": unit, "start": 0.2 * arcsec / size, "max": 1 * arcsec / size}
        own = effects.expression("shaft", "series", "a * torque_Nm", {"a": a})
        ((_, told, start, least, most),) = own.parameters
        assert told == "rad/(N m)" and least is None
        assert start == pytest.approx(0.2 * arcsec, rel=1e-12)
        assert most == pytest.approx(arcsec, rel=1e-12)
        listed: Listed = [(own, {})]
        both = (bare, bare.with_effects(listed))
        before, after = (cbpt.solve_many(c, 3.0, 600.0).elastic_angle_arcsec for c in both)
        assert after - before == pytest.approx(0.6, rel=1e-6)
        function = as_function(own, lambda rows, a: a * rows["torque_Nm"])
        assert function.parameters == own.parameters


@pytest.mark.parametrize("unit", ["furlong", "rad/(N m", "arcsec per week", "degC"])
def test_a_unit_that_is_not_known_is_refused(unit: str) -> None:
    a = {"a": {"unit": unit, "start": 1.0}}
    with pytest.raises(CaseError, match=r"parameters\.a\.unit = "):
        effects.expression("shaft", "series", "a * torque_Nm", a)
    with pytest.raises(CaseError, match=r"parameters\.a\.unit = "):
        effects.own_effect("shaft", "series", lambda rows, a: 0.0, a)


def test_a_unit_of_another_dimension_is_refused_with_the_right_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    a = {"a": {"unit": "N/um", "start": 1.0}}
    said = "a is in N/um, so a * torque_Nm is in N^2; a series term is an angle"
    with pytest.raises(CaseError) as error:
        effects.expression("shaft", "series", "a * torque_Nm", a)
    (mistake,) = error.value.mistakes
    assert mistake.words == f"{said}: give a in arcsec/(N m)" and mistake.place[2] == 1
    # What is told is taken; the same formula without a unit is free.
    for unit in ("arcsec/(N m)", ""):
        right = {"a": {"unit": unit, "start": 1.0}}
        assert effects.expression("shaft", "series", "a * torque_Nm", right).id == "shaft"
    monkeypatch.chdir(tmp_path)
    own = 'id = "shaft"\nport = "series"\nexpression = "a * torque_Nm"\n'
    parameters = 'parameters = { a = { unit = "N/um", start = 1.0 } }\n'
    Path("mine.toml").write_text(f"{case_of('dev10')}[[effect]]\n{own}{parameters}")
    assert commands.main(["compare", "mine.toml", str(DATA)]) != 0
    told = capsys.readouterr().err.replace("\n", " ")
    assert said in told and '| expression = "a * torque_Nm"' in told and "^" in told


def test_a_case_keeps_the_unit_in_which_a_parameter_was_stated() -> None:
    a = {"unit": "arcsec/(N m)", "start": 0.21, "min": 0.0, "max": 3.3}
    own = effects.expression("shaft", "series", "a * torque_Nm", {"a": a})
    text = 'a = { unit = "arcsec/(N m)", start = 0.21, min = 0.0, max = 3.3 }'
    assert text in own.to_toml() and own.stated_units == {"a": "arcsec/(N m)"}
    assert text in pickle.loads(pickle.dumps(own)).to_toml()
