"""Effects added to a case: the same error when compared again, and on readings held back.

Groups: fit, case, compare; held back; what is refused; the verbs fit and diagnose.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import cbpt
from cbpt import Case, Fitted, InvalidInputError, ReadingsError, compare, read_readings
from cbpt.cli import main as commands
from cbpt.lab.model.priors import PRIORS
from common.cases import check_same
from common.comparisons import CAMPAIGNS, TRUTH, strictly

MISSING = {
    "dev03": "eccentric_bearing",
    "dev04": "friction_hysteresis",
    "dev13": "creep",
}
"""What the sets hide."""
EVERY = pytest.mark.parametrize("name", MISSING)


def case(name: str) -> Path:
    return CAMPAIGNS / f"{name}.toml"


def table(name: str) -> Path:
    return CAMPAIGNS / f"{name}.csv"


@cache
def fitted(name: str) -> Fitted:
    return cbpt.fit(case(name), table(name), [MISSING[name]])


# --- fit, case, compare -------------------------------------------------------------------


@EVERY
def test_compared_again_the_error_is_that_of_the_fit(name: str) -> None:
    found = fitted(name)
    before, after = compare(case(name), table(name)), compare(found.case, table(name))
    assert after.rmse_with_best_zero_arcsec == pytest.approx(found.after.rmse_arcsec, rel=1e-6)
    assert before.rmse_with_best_zero_arcsec == pytest.approx(found.before.rmse_arcsec, rel=1e-6)
    assert found.after.rmse_arcsec == pytest.approx(TRUTH[name]["sigma_arcsec"], rel=0.05)
    assert found.after.rmse_arcsec < 0.5 * found.before.rmse_arcsec
    assert before.overall is not None and after.overall is not None
    assert before.overall.chi2_per_dof is not None and after.overall.chi2_per_dof is not None
    assert after.overall.chi2_per_dof < 1.3 < before.overall.chi2_per_dof


@EVERY
def test_the_case_is_the_same_from_its_text(name: str, tmp_path: Path) -> None:
    found = fitted(name).case
    again = Case.from_toml(found.to_toml())
    assert again == found and again.to_toml() == found.to_toml()
    file = tmp_path / "case.toml"
    file.write_text(found.to_toml(), encoding="utf-8")
    one, other = compare(found, table(name)), compare(file, table(name))
    assert one.overall is not None and other.overall is not None
    assert one.overall.rmse_arcsec == other.overall.rmse_arcsec


@EVERY
def test_the_case_has_the_effect_and_the_numbers_as_refitted(name: str) -> None:
    found = fitted(name)
    values = {effect.id: dict(effect.values) for effect in found.case.effects}
    assert set(values) == {MISSING[name], *PRIORS}
    assert found.case.drive == Case.from_file(case(name)).drive
    told = found.parameters()[MISSING[name]]
    for parameter, number in told.items():
        assert values[MISSING[name]][parameter] == pytest.approx(number["value"], rel=1e-12)
        assert 0 < number["u"] < abs(number["value"])
    assert MISSING[name] in found.report() and found.held_out_by in found.report()


def test_what_is_in_the_case_is_not_missing_any_more() -> None:
    """Fitted once more to the case that has it, the effect stays where it is."""
    first = fitted("dev03")
    second = cbpt.fit(first.case, table("dev03"), ["eccentric_bearing"])
    assert second.before.rmse_arcsec == pytest.approx(first.after.rmse_arcsec, rel=1e-6)
    assert second.after.rmse_arcsec == pytest.approx(first.after.rmse_arcsec, rel=0.01)
    one, other = (f.parameters()["eccentric_bearing"] for f in (first, second))
    for name in one:
        assert other[name]["value"] == pytest.approx(one[name]["value"], abs=one[name]["u"])


def test_the_order_of_effects_and_of_asking_twice_is_none() -> None:
    names = ["eccentric_bearing", "drift"]
    one = cbpt.fit(case("dev03"), table("dev03"), names)
    other = cbpt.fit(case("dev03"), table("dev03"), [*reversed(names), "drift"])
    assert one.after.rmse_arcsec == pytest.approx(other.after.rmse_arcsec, rel=1e-3)
    assert set(one.effects) == set(other.effects) == set(names)
    assert sorted(e.id for e in one.case.effects) == sorted(e.id for e in other.case.effects)


# --- held back ----------------------------------------------------------------------------

LEVELS = (420.0, 560.0, 800.0, 1200.0)


@pytest.mark.parametrize("name", ["dev03", "dev04"])
@pytest.mark.parametrize("preload_N", LEVELS)
def test_the_error_falls_on_a_preload_level_held_back(name: str, preload_N: float) -> None:
    readings = read_readings(table(name))
    assert readings.preload_N is not None
    held = np.isclose(readings.preload_N, preload_N)
    found = cbpt.fit(case(name), readings.select(~held), [MISSING[name]])
    unseen = readings.select(held)
    before = compare(case(name), unseen).rmse_with_best_zero_arcsec
    after = compare(found.case, unseen).rmse_with_best_zero_arcsec
    assert before is not None and after is not None
    assert len(unseen) == 99
    assert before - after >= 0.9 * (before - TRUTH[name]["sigma_arcsec"])


def test_a_wrong_effect_does_not_reach_the_noise() -> None:
    found = cbpt.fit(case("dev04"), table("dev04"), ["preload_spring"])
    assert found.after.rmse_arcsec > 2 * TRUTH["dev04"]["sigma_arcsec"]
    assert found.after.held_out_rmse_arcsec > 2 * TRUTH["dev04"]["sigma_arcsec"]


# --- what is refused ----------------------------------------------------------------------


def test_an_effect_that_is_not_known_is_refused_with_the_near_one() -> None:
    for wrong in ("bearing", "eccentric_baering"):
        with pytest.raises(InvalidInputError, match=r"\. Did you mean eccentric_bearing\? "):
            cbpt.fit(case("dev03"), table("dev03"), [wrong])
    with pytest.raises(InvalidInputError, match='zero = "per_run"'):
        cbpt.fit(case("dev03"), table("dev03"), ["run_offset"])
    with pytest.raises(InvalidInputError, match=r"that can be fitted\. Expected one of: contact_"):
        cbpt.fit(case("dev03"), table("dev03"), ["unknown"])


def test_a_table_without_what_the_effect_depends_on_is_refused() -> None:
    readings = read_readings(table("dev03"))
    assert readings.preload_N is not None
    columns = {
        "torque_Nm": readings.torque_Nm,
        "preload_N": readings.preload_N,
        "elastic_angle_arcsec": readings.elastic_angle_arcsec,
    }
    with pytest.raises(ReadingsError, match="temperature_degC"):
        cbpt.fit(case("dev03"), columns, ["thermal_preload"])
    with pytest.raises(ReadingsError, match="time_s"):
        cbpt.fit(case("dev03"), columns, ["creep"])


# --- the verbs fit and diagnose -----------------------------------------------------------


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A directory of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(verb: str, *arguments: str | Path, name: str = "dev03") -> int:
    """A verb on one of the sets, in this process."""
    return commands.main([verb, str(case(name)), str(table(name)), *map(str, arguments)])


def test_fit_writes_the_case(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("fit", "--with", "eccentric_bearing", "--out", "new.toml") == 0
    printed = capsys.readouterr()
    assert printed.out.startswith(fitted("dev03").report() + "\n") and printed.err == ""
    assert "new.toml" in printed.out.splitlines()[-1]
    check_same(Case.from_file(desk / "new.toml"), fitted("dev03").case)
    assert [p.name for p in desk.iterdir()] == ["new.toml"]
    # To compare again, with the verb as well.
    assert commands.main(["compare", "new.toml", str(table("dev03")), "--json"]) == 0
    document = strictly(capsys.readouterr().out)
    assert document["overall"]["rmse_arcsec"] == pytest.approx(0.302, abs=0.002)


def test_fit_of_two_effects(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("fit", "--with", "eccentric_bearing", "drift:time") == 0
    out = capsys.readouterr().out
    assert "\neccentric_bearing: reference" in out and "\ndrift: " in out
    assert list(desk.iterdir()) == []


def test_diagnose_writes_document_and_picture(
    desk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib", reason="an extra")
    assert run("diagnose", "--json", "answer.json", "--plot", "answer.svg") == 0
    printed = capsys.readouterr()
    document = strictly((desk / "answer.json").read_text(encoding="utf-8"))
    assert document["verdict"]["sentence"] in " ".join(printed.out.split()) and not printed.err
    verdict = document["verdict"]
    named = {*verdict["effects"], *(e for group in verdict["rivals"] for e in group)}
    assert "eccentric_bearing" in named
    picture = xml.etree.ElementTree.parse(desk / "answer.svg").getroot()
    assert picture.tag == "{http://www.w3.org/2000/svg}svg"
    assert sorted(p.name for p in desk.iterdir()) == ["answer.json", "answer.svg"]


def test_diagnose_prints_one_json_object(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("diagnose", "--json", name="dev11") == 0
    printed = capsys.readouterr()
    assert strictly(printed.out)["verdict"]["kind"] == "undecided" and printed.err == ""
    assert list(desk.iterdir()) == []
    # The same seed, the same answer.
    assert run("diagnose", "--json", "--seed", "0", name="dev11") == 0
    assert json.loads(capsys.readouterr().out) == json.loads(printed.out)


BOTH = [str(case("dev03")), str(table("dev03"))]
WITH = ["--with", "eccentric_bearing"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["fit", *BOTH, "--with", "bearing"], "Did you mean eccentric_bearing?"),
        (["fit", *BOTH], "--with"),
        (["fit", *BOTH, *WITH, "--out", "new.csv"], "must end in .toml"),
        (["fit", *BOTH[::-1], *WITH], "CASE comes first: cbpt fit " + BOTH[0]),
        (["fit", BOTH[0], "none.csv", *WITH], "none.csv"),
        (["fit", *BOTH, *WITH, "--column", "torque"], "HEADER=NAME"),
        (["diagnose", *BOTH[::-1]], "CASE comes first: cbpt diagnose " + BOTH[0]),
        (["diagnose", *BOTH, "--plot", "x.bmp"], "x.bmp: the name must end in .svg, .png, .pdf"),
        (["diagnose", *BOTH, "--plot", "x"], ".svg, .png, .pdf"),
        (["diagnose", *BOTH, "--seed", "one"], "--seed"),
        (["diagnose", BOTH[0]], "DATA"),
        (["diagnose", "none.toml", BOTH[1]], "none.toml"),
    ],
)
def test_what_is_wrong_is_told_and_exit_code_2(
    arguments: list[str], told: str, desk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert commands.main(arguments) == 2
    printed = capsys.readouterr()
    assert told in " ".join(printed.err.split()) and printed.out == ""
    assert "Traceback" not in printed.err
    assert list(desk.iterdir()) == []


def test_a_case_that_cannot_be_written_is_exit_code_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("fit", *WITH, "--out", "nowhere/new.toml") == 1
    assert "cannot write nowhere/new.toml" in capsys.readouterr().err
