"""The page's document, without a browser. Its part about the drive is in test_drive.

Groups: what the document holds; models on every row; further combinations; own effects; the verb.
"""

from __future__ import annotations

import json
import re
import tomllib
from copy import copy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbpt
from cbpt.cli.main import main
from cbpt.effects import expression
from cbpt.errors import InvalidInputError
from cbpt.lab.diagnosis.deciding_runs import why_no_run
from cbpt.lab.diagnosis.noise_statement import floor_of
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.page.document.document import SCHEMA, page_document
from cbpt.page.document.plain import to_json
from cbpt.page.document.source import Source, from_here
from cbpt.page.document.types import Candidate, Model, PageDocument
from cbpt.page.document.typescript import TARGET, declarations
from cbpt.page.document.units import name_and_unit
from cbpt.page.workbench.session import Session
from common.documents import SOURCE, document, models
from common.hidden import FOLDER, case_of, diagnosed, table_of


@cache
def stated_document() -> Any:
    return page_document(*case_and_readings(FOLDER / "dev04.toml", FOLDER / "dev04.csv"), SOURCE)


def test_the_sentence_is_that_of_the_answer_with_names_and_units_in_print() -> None:
    parts = document("dev04")["sentence"]["arcsec"]
    words = "".join(part["text"] for part in parts)
    (aside,) = (p["text"] for p in parts if p["aside"])
    assert re.match(r"\(friction radius 575(\.\d)? ± [\d.]+ µm, engagement angle ", aside)
    assert "_" not in words
    same = words.replace("friction radius", "friction_radius_um").replace(" µm", "", 1)
    same = same.replace("±", "+-", 1)
    told = document("dev04")["answer"]["verdict"]["sentence"]
    assert same.partition(",")[0] == told.partition(",")[0]
    assert stated_document()["sentence"] == {}


def choice(name: str, effects: list[str]) -> Any:
    return models(name).choice(effects)


def array(values: list[float | None]) -> Any:
    return np.array([np.nan if v is None else v for v in values])


# --- what the document holds ----------------------------------------------------------------


@pytest.mark.parametrize("name", ["dev04", "dev10"])
def test_it_is_json_and_every_column_is_as_long_as_the_table(name: str) -> None:
    found = json.loads(to_json(document(name)))
    assert found["schema"] == SCHEMA
    n = found["data"]["rows"]
    for column, values in found["readings"].items():
        assert values is None or len(values) == n, column
    for model in found["models"]:
        assert len(model["model_arcsec"]) == len(model["residual_arcsec"]) == n, model["key"]
        assert model["signature_arcsec"] is None or len(model["signature_arcsec"]) == n
    keys = {model["key"] for model in found["models"]}
    assert found["answer_key"] in (keys if name == "dev04" else {None})
    assert {candidate["key"] for candidate in found["candidates"]} <= keys
    assert {rung["key"] for rung in found["ladder"]["rungs"]} <= keys
    for line in found["curves"]:
        assert set(line["angle_arcsec"]) == keys
        assert all(len(angle) == len(line["torque_Nm"]) for angle in line["angle_arcsec"].values())


@pytest.mark.parametrize("name", ["dev04", "dev08", "dev10"])
def test_its_numbers_are_those_of_the_answer(name: str) -> None:
    found = document(name)
    answer, ladder = found["answer"], found["ladder"]
    assert answer == diagnosed(name).to_dict()
    by_key = {model["key"]: model for model in found["models"]}
    before = by_key["stated"]
    assert before["rmse_arcsec"] == pytest.approx(answer["before"]["rmse_arcsec"], rel=1e-9)
    if found["answer_key"]:
        after = by_key[found["answer_key"]]
        assert after["rmse_arcsec"] == pytest.approx(answer["after"]["rmse_arcsec"], rel=1e-9)
    for rung in ladder["rungs"]:
        model = by_key[rung["key"]]
        assert model["rmse_arcsec"] == pytest.approx(rung["in_sample_arcsec"], rel=1e-6)
        assert model["held_out_rmse_arcsec"] == pytest.approx(rung["held_out_arcsec"], rel=1e-6)
    # A card's numbers are those of the ranking.
    cards = [c for c in found["candidates"] if c["probability"] is not None]
    for row, candidate in zip(answer["ranking"], cards, strict=True):
        model = by_key[candidate["key"]]
        assert model["probability"] == row["probability"]
        if not diagnosed(name).competition.fits[candidate["effect"],].converged:
            continue  # searched further than the diagnosis had to
        assert model["held_out_rmse_arcsec"] == row["held_out_rmse_arcsec"], row["effect"]
        assert {p["name_SI"]: (p["value_SI"], p["u"] is None) for p in model["parameters"]} == {
            name: (p["value"], p["u"] is None) for name, p in row["parameters"].items()
        }
    stop = ladder["rungs"][ladder["stop"]]
    assert stop["in_sample_arcsec"] == pytest.approx(answer["after"]["rmse_arcsec"])


def test_a_noise_floor_is_of_what_is_noise() -> None:
    found = document("dev04")["noise"]
    assert found["noise_floor_arcsec"] == pytest.approx(found["u_estimated_arcsec"])
    assert found["noise_floor_of"] == "scatter about the answer"
    # Nothing named holds all that is at work in dev10: what is left is no noise.
    found = document("dev10")["noise"]
    assert found["u_estimated_arcsec"] > 0.33
    assert found["noise_floor_arcsec"] == pytest.approx(0.3)
    assert found["noise_floor_of"] == "stated uncertainty"
    d = diagnosed("dev10")
    c = d.competition
    fitter = copy(c.fitter)
    fitter.campaign = replace(c.campaign, u_stated=False)
    floor, of = floor_of(replace(d, competition=replace(c, fitter=fitter)))
    assert floor is None
    assert "is unknown" in of


def test_a_lack_of_fit_is_named_in_words() -> None:
    of = "a free-form function of the torque and the input angle"
    assert document("dev10")["ladder"]["rungs"][-1]["label"] == of
    assert next(m["label"] for m in document("dev10")["models"] if m["key"] == "unknown") == of


def test_a_ladder_says_why_it_stops() -> None:
    ladder = document("dev10")["ladder"]
    assert "lack of fit" in ladder["stop_says"]
    ladder = document("dev04")["ladder"]
    last, more = ladder["rungs"][ladder["stop"] :]
    assert more["label"] != last["label"]
    assert "nothing" not in ladder["stop_says"]


def test_a_residual_is_reading_less_model_and_a_signature_what_a_model_adds() -> None:
    found = document("dev04")
    measured = array(found["readings"]["measured_arcsec"])
    stated = next(m for m in found["models"] if m["key"] == "stated")
    for model in found["models"]:
        residual = measured - array(model["model_arcsec"])
        np.testing.assert_allclose(residual, array(model["residual_arcsec"]), atol=2e-6)
        rmse = np.sqrt(np.mean(residual**2))
        assert model["rmse_arcsec"] == pytest.approx(rmse, rel=1e-4)
        if model["signature_arcsec"] is not None:
            added = array(model["model_arcsec"]) - array(stated["model_arcsec"])
            np.testing.assert_allclose(added, array(model["signature_arcsec"]), atol=2e-6)


def test_an_unknown_answer_brings_its_draft_and_the_pattern_as_a_model() -> None:
    found = document("dev10")
    draft = found["own"]["draft"]
    told = tomllib.loads(found["answer"]["unknown"]["effect_toml"])["effect"][0]
    assert draft["expression"] == told["expression"]
    assert {p["name"] for p in draft["parameters"]} == set(told["parameters"])
    unknown = next(m for m in found["models"] if m["role"] == "unknown")
    stated = found["models"][0]
    assert unknown["rmse_arcsec"] < 0.3 * stated["rmse_arcsec"]
    assert document("dev04")["own"]["draft"] is None
    # What to measure next, in the words of the answer.
    assert found["reasons"]["next_run"] == found["answer"]["unknown"]["measure_next"]


def test_what_does_not_explain_the_readings_is_not_the_answer() -> None:
    found = document("dev10")
    assert found["answer"]["verdict"]["effects"] == []
    assert found["answer_key"] is None
    assert "explains" in found["reasons"]["answer_key"]
    assert not any(c["in_answer"] for c in found["candidates"])
    assert "answer" not in {m["role"] for m in found["models"]}
    assert "answer_key" not in document("dev04")["reasons"]


def test_before_a_diagnosis_there_are_the_readings_beside_the_drive_as_stated() -> None:
    found = stated_document()
    assert found["answer"] is None
    assert found["reasons"]["answer"]
    (stated,) = found["models"]
    known = document("dev04")["models"][0]
    # The same zero up to the noise that judges it.
    assert stated["rmse_arcsec"] == pytest.approx(known["rmse_arcsec"], rel=1e-3)
    assert found["candidates"] == []
    assert [e["effect"] for e in found["library"]] == [
        e["effect"] for e in document("dev04")["library"]
    ]


def test_lines_run_through_the_model_at_the_torques_of_the_table() -> None:
    found = document("dev04")
    readings, line = found["readings"], found["curves"][0]
    torque, level = np.array(readings["torque_Nm"]), np.array(readings["level"])
    way = np.array(readings["branch"])
    model = array(found["models"][0]["model_arcsec"])
    rows = (level == line["level"]) & (way == line["branch"])
    for x, y in zip(line["torque_Nm"], line["angle_arcsec"]["stated"], strict=True):
        assert y == pytest.approx(model[rows & (torque == x)].mean(), abs=1e-5)


def test_what_a_line_is_the_mean_over_is_told() -> None:
    # Three input angles at each torque of dev10, and its effect depends on them.
    assert document("dev10")["curves_mean_over"] == ["input angle", "run"]
    columns = table_of("dev10")
    first = columns["run"] == columns["run"][0]
    one = {name: values[first] for name, values in columns.items()}
    case, readings = case_and_readings(FOLDER / "dev10.toml", one)
    assert page_document(case, readings, SOURCE)["curves_mean_over"] == []


# --- models on every row --------------------------------------------------------------------


def long_table(runs: int = 40) -> dict[str, Any]:
    """Runs of the drive as stated with noise; the last reading is more than the preload holds."""
    rng = np.random.default_rng(3)
    torque = np.tile(np.r_[np.linspace(-8, 8, 20), np.linspace(8, -8, 20)], runs)
    run = np.repeat(np.arange(runs) + 1, 40)
    preload = np.repeat(np.array([600.0, 800.0, 1000.0, 700.0])[np.arange(runs) % 4], 40)
    case = cbpt.Case.from_toml(case_of("dev04"))
    angle = cbpt.solve_many(case.drive, torque, preload).elastic_angle_arcsec
    angle = angle + rng.normal(0, 0.3, len(torque))
    preload[-1] = 30.0
    return {
        "run": run,
        "torque_Nm": torque,
        "preload_N": preload,
        "elastic_angle_arcsec": angle,
        "u_elastic_angle_arcsec": np.full(len(torque), 0.3),
    }


def test_all_rows_of_a_long_table_are_predicted_though_not_all_were_judged() -> None:
    case, readings = case_and_readings(FOLDER / "dev04.toml", long_table())
    d = cbpt.diagnose(case, readings)
    found: Any = page_document(case, readings, SOURCE, d)
    used = np.array(found["readings"]["used"])
    assert len(d.readings) < len(readings) == len(used)
    assert not used[-1]
    by_key = {m["key"]: m for m in found["models"]}
    stated = array(by_key["stated"]["model_arcsec"])
    # There is no solution at the last reading, and a null says so.
    assert by_key["stated"]["model_arcsec"][-1] is None
    assert found["readings"]["regime"][-1] is None
    assert np.isfinite(stated[:-1]).all()
    judged = d.model_before_arcsec
    np.testing.assert_allclose(stated[used], judged, atol=2e-3)
    refitted = by_key[found["answer_key"]]
    assert refitted["rmse_arcsec"] == pytest.approx(0.3, rel=0.1)
    to_json(found)


# --- further combinations -------------------------------------------------------------------


def test_a_combination_that_nobody_fitted_is_fitted_from_what_is_there() -> None:
    found = choice("dev04", ["friction_hysteresis", "output_torsion"])
    alone = choice("dev04", ["friction_hysteresis"])["model"]
    model = found["model"]
    assert model["key"] == "friction_hysteresis+output_torsion"
    # One more effect never fits worse.
    assert model["rmse_arcsec"] <= alone["rmse_arcsec"] * 1.001
    labels = [rung["added"] for rung in found["ladder"]]
    assert labels == ["", "friction_hysteresis", "output_torsion"]
    errors = [rung["in_sample_arcsec"] for rung in found["ladder"]]
    assert errors[1] < 0.3 * errors[0]
    assert len(found["curves"]) == len(document("dev04")["curves"])
    case = cbpt.Case.from_toml(model["case_text"])
    assert {e.id for e in case.effects} >= {"friction_hysteresis", "output_torsion"}


def test_the_case_of_a_model_predicts_what_the_model_says() -> None:
    model = choice("dev04", ["friction_hysteresis"])["model"]
    case = cbpt.Case.from_toml(model["case_text"])
    compared = cbpt.compare(case, diagnosed("dev04").readings)
    rest = compared.residual_arcsec - array(model["residual_arcsec"])
    # But for the zero, which no case holds.
    np.testing.assert_allclose(rest, rest.mean(), atol=1e-5)


@pytest.mark.parametrize("name", ["dev08", "dev12"])
def test_the_case_of_an_answer_that_moves_numbers_has_them_moved(name: str) -> None:
    found = document(name)
    answer = next(m for m in found["models"] if m["key"] == found["answer_key"])
    assert answer["effects"] == []
    case = cbpt.Case.from_toml(answer["case_text"])
    compared = cbpt.compare(case, diagnosed(name).readings)
    rest = compared.residual_arcsec - array(answer["residual_arcsec"])
    np.testing.assert_allclose(rest, rest.mean(), atol=1e-5)


def test_a_combination_has_the_numbers_of_its_model() -> None:
    found = document("dev09")
    by_key = {m["key"]: m for m in found["models"]}
    assert len(found["combinations"]) > 1
    for row in found["combinations"]:
        model = by_key[row["key"]]
        assert row["label"] == " + ".join(row["effects"]).replace("_", " ")
        assert row["probability"] == pytest.approx(model["probability"])
        assert row["rmse_arcsec"] == pytest.approx(model["rmse_arcsec"])
    likely = {row["effect"]: row["probability"] for row in found["perhaps"]}
    assert likely and all(
        c["perhaps"] == likely.get(c["effect"]) for c in found["candidates"] if not c["in_answer"]
    )
    assert found["remains"] is None and found["undecided"] is None


def test_what_remains_is_told_in_words() -> None:
    found = document("dev10")
    assert found["remains"]["depends_on"] == "the torque and the input angle"
    assert found["remains"]["rms_arcsec"] > 1
    unnamed = [row for row in found["combinations"] if row["key"] is None]
    assert unnamed and "an effect without a name" in unnamed[0]["label"]


def test_where_readings_do_not_decide_no_model_is_that_of_the_answer() -> None:
    found = document("dev11")
    assert found["answer"]["verdict"]["kind"] == "undecided" and found["undecided"]
    assert found["answer_key"] is None and "answer" not in {m["role"] for m in found["models"]}
    assert found["reasons"]["answer_key"] == "the readings do not decide"
    assert found["noise"]["noise_floor_of"] == "stated uncertainty"


def test_a_model_has_a_case_or_a_reason_why_not() -> None:
    stated, *others = document("dev10")["models"]
    assert (stated["case_text"], stated["why_no_case"]) == (None, None)
    for model in others:
        assert (model["case_text"] is None) == (model["why_no_case"] is not None), model["key"]
    (unknown,) = (m for m in others if m["case_text"] is None)
    assert unknown["key"] == "unknown"


def test_every_effect_of_the_library_can_be_switched_on_and_none_makes_the_fit_worse() -> None:
    alone = choice("dev04", ["friction_hysteresis"])["model"]["rmse_arcsec"]
    for entry in document("dev04")["library"]:
        if entry["why_not"] is None and entry["effect"] != "friction_hysteresis":
            try:
                model = choice("dev04", ["friction_hysteresis", entry["effect"]])["model"]
            except InvalidInputError as error:
                assert "do not depend" in str(error)
                continue
            assert model["rmse_arcsec"] < 1.02 * alone, entry["effect"]


@pytest.mark.parametrize("name", ["dev04", "dev09"])
def test_a_search_that_the_diagnosis_left_is_ended_or_called_rough(name: str) -> None:
    left = {n for n, fit in diagnosed(name).competition.fits.items() if not fit.converged}
    found = document(name)
    bench = models(name)._bench
    rough = set()
    for model in found["models"]:
        effects = tuple(model["effects"])
        if effects in left and model["key"] != "stated":
            before = diagnosed(name).competition.fits[effects]
            misfits = [
                bench.fitter.misfit(fit.hypothesis, fit.point.values, bench.noise)
                for fit in (before, bench.fit(effects))
            ]
            assert misfits[1] < misfits[0], model["key"]
        if not model["converged"]:
            rough.add(model["key"])
            assert model["held_out_rmse_arcsec"] is None
            assert all(number["u"] is None for number in model["numbers"])
            for p in model["parameters"]:
                assert p["u"] is None
                assert "+-" not in p["text"]
    assert len(rough) <= len(left)


def test_numbers_that_the_answer_names_have_a_card_with_their_values() -> None:
    found = document("dev08")
    (rivals,) = found["answer"]["verdict"]["rivals"]
    assert sorted(rivals) == ["contact_stiffness", "sensor_gain"]
    cards = {c["effect"]: c for c in found["candidates"] if c["is_rival"]}
    assert set(cards) == set(rivals)
    by_key = {m["key"]: m for m in found["models"]}
    for effect in rivals:
        model = by_key[cards[effect]["key"]]
        assert model["role"] == "rival"
        assert model["rmse_arcsec"] < 0.35 * found["models"][0]["rmse_arcsec"]
        (number,) = model["parameters"]
        assert number["u"] > 0
        # The sensor reads 4 % high in truth.
        if effect == "sensor_gain":
            assert abs(number["value"] - 1.04) < number["u"]


def test_a_number_that_is_the_answer_is_one_thing_in_sentence_card_and_ladder() -> None:
    found = document("dev12")
    verdict = found["answer"]["verdict"]
    assert verdict["effects"] == ["contact_stiffness"]
    (card,) = (c for c in found["candidates"] if c["effect"] == "contact_stiffness")
    assert card["in_answer"]
    assert card["key"] == found["answer_key"] == "refitted"
    assert card["moved"] in verdict["sentence"]
    refitted = next(m for m in found["models"] if m["key"] == "refitted")
    (number,) = (n for n in refitted["numbers"] if n["number"] == "contact_stiffness")
    assert f"{100 * (number['value'] - number['stated']):+.1f} %" in card["moved"]
    ladder = found["ladder"]
    assert ladder["rungs"][ladder["stop"]]["label"] == "parameters refitted (contact stiffness)"
    assert [r["key"] for r in ladder["rungs"]].count("contact_stiffness") == 0
    assert ladder["stop_says"] is None
    # Rivals are left free each, and nothing else is renamed.
    assert document("dev08")["ladder"]["rungs"][1]["label"] == "parameters refitted"


def test_what_cannot_be_switched_on_is_told() -> None:
    with pytest.raises(InvalidInputError, match="no_such_effect"):
        choice("dev04", ["no_such_effect"])


# --- own effects ----------------------------------------------------------------------------


def test_an_own_effect_is_fitted_like_the_others_and_goes_with_them() -> None:
    draft = document("dev10")["own"]["draft"]
    parameters = {p["name"]: {k: p[k] for k in p if k != "name"} for p in draft["parameters"]}
    bench = models("dev10")
    bench.add_own(expression("mine", draft["port"], draft["expression"], parameters))
    model = choice("dev10", ["mine"])["model"]
    assert model["role"] == "own"
    assert model["rmse_arcsec"] < 0.5 * document("dev10")["models"][0]["rmse_arcsec"]
    assert model["held_out_rmse_arcsec"] < 0.5
    assert {p["name"] for p in model["parameters"]} == set(parameters)
    assert 'id = "mine"' in model["case_text"]
    both = choice("dev10", ["output_torsion", "mine"])["model"]
    assert both["rmse_arcsec"] <= model["rmse_arcsec"] * 1.001
    with pytest.raises(InvalidInputError, match="choose another"):
        bench.add_own(expression("stated", "series", "a * torque_Nm", {"a": 1e-6}))
    with pytest.raises(InvalidInputError, match="no influence"):
        bench.add_own(expression("never0", "series", "cos(a) + 2", {"a": 1.0}))


# --- the verb -------------------------------------------------------------------------------


def test_report_writes_the_document_and_the_command_that_makes_it(tmp_path: Path) -> None:
    out = tmp_path / "page.json"
    case, data = str(FOLDER / "dev11.toml"), str(FOLDER / "dev11.csv")
    given = ["--seed", "3", "--angle-unit", "mrad"]
    assert main(["report", case, data, *given, "--out", str(out)]) == 0
    found = json.loads(out.read_text(encoding="utf-8"))
    words = f"cbpt report {from_here(case)} {from_here(data)} {' '.join(given)} --out report.html"
    assert found["command"] == words and found["unit"] == "mrad"
    assert found["answer"]["source"] == found["isolability"]["source"] == "dev11.csv"
    assert found["answer"]["seed"] == 3
    assert found["isolability"]["schema"] == "cbpt.isolability/1"


def test_the_words_for_other_verbs_hold_no_flag_of_the_diagnosis() -> None:
    # compare and fit know no --seed.
    source = Source.of_files("a case.toml", "t.csv", "", ["--column", "M=torque"], ["--seed", "3"])
    assert source.command.words() == {
        "case": "'a case.toml'",
        "data": "t.csv",
        "reading": "--column M=torque",
    }
    assert source.command.report.endswith("--column M=torque --seed 3 --out report.html")


@pytest.mark.parametrize("key", ["torque_Nm", "rate_urad_per_K", "stiffness_Nm_per_rad", "share"])
def test_a_unit_at_the_end_of_a_key_is_written_as_in_print(key: str) -> None:
    found = {
        "torque_Nm": ("torque", "N m"),
        "rate_urad_per_K": ("rate", "µrad/K"),
        "stiffness_Nm_per_rad": ("stiffness", "N m/rad"),
        "share": ("share", ""),
    }
    assert name_and_unit(key) == found[key]


@pytest.mark.parametrize("inside", [True, False])
def test_a_page_does_not_tell_where_the_files_lie(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, inside: bool
) -> None:
    # Where it is run, or elsewhere: what lies above is told in neither case.
    folder = tmp_path / "of a person" / "data"
    folder.mkdir(parents=True)
    for name in ("dev11.toml", "dev11.csv"):
        (folder / name).write_bytes((FOLDER / name).read_bytes())
    where = folder.parent if inside else tmp_path / "elsewhere"
    where.mkdir(exist_ok=True)
    monkeypatch.chdir(where)
    files = [folder / "dev11.toml", folder / "dev11.csv"]
    session = Session.of_files(files[0], files[1])
    text = session.document()
    assert text is not None
    assert main(["report", *map(str, files), "--out", "page.html"]) == 0
    for page in (text, (where / "page.html").read_text(encoding="utf-8")):
        assert str(tmp_path) not in page
        assert "of a person" not in page
    prefix = "data/" if inside else ""
    words = f"cbpt report {prefix}dev11.toml {prefix}dev11.csv --out report.html"
    assert json.loads(text)["command"] == words


def test_report_refuses_another_ending(capsys: pytest.CaptureFixture[str]) -> None:
    case, data = str(FOLDER / "dev11.toml"), str(FOLDER / "dev11.csv")
    assert main(["report", case, data, "--out", "page.pdf"]) == 2
    assert ".html or .json" in capsys.readouterr().err


def test_the_declarations_of_the_page_are_those_of_the_document() -> None:
    assert TARGET.read_text(encoding="utf-8") == declarations()


@pytest.mark.parametrize("name", ["dev04", "dev10"])
def test_the_document_has_what_its_type_says(name: str) -> None:
    found = document(name)
    assert set(found) == set(PageDocument.__annotations__) - {"opened"}
    for model in found["models"]:
        assert set(model) == set(Model.__annotations__) - {"ladder"}
    for candidate in found["candidates"]:
        assert set(candidate) == {*Candidate.__annotations__, "class"}


def test_where_something_remains_the_next_run_is_sought_there() -> None:
    """Beside what is named, too; that nothing is open is said where nothing is."""
    verdict = {"kind": "effect", "rivals": [], "perhaps": []}
    there = "No known effect explains what remains. Measure more readings there."
    d = diagnosed("dev04")
    assert why_no_run(d, {"verdict": verdict, "unknown": {"measure_next": there}}) == there
    assert "nothing is open" in why_no_run(d, {"verdict": verdict, "unknown": None})
