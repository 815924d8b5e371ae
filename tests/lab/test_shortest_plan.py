"""The shortest plan that tells effects apart: against the check that is not linear, simulated."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

import cbpt
from cbpt import Design, InvalidInputError, Limits, read_plan, shortest_plan
from cbpt.cli import main as commands

TOP = Path(__file__).parents[2]
CASE = TOP / "examples" / "campaign.toml"
LIMITS = Limits(10.0, (400.0, 1200.0), (0.0, 90.0))
EFFECTS = ["eccentric_bearing", "bearing_play", "creep"]
SIZES = {
    "eccentric_bearing": {"reference_deflection_um": 0.2, "exponent": 0.9},
    "bearing_play": {"clearance_um": 0.3},
    "creep": {"compliance_arcsec_per_Nm": 0.1, "time_constant_s": 10.0},
}


@cache
def design() -> Design:
    return shortest_plan(CASE, EFFECTS, u_elastic_angle_arcsec=0.3, limits=LIMITS, sizes=SIZES)


def test_the_plan_does_what_was_asked_and_no_run_can_be_spared() -> None:
    found = design()
    assert found.reached and found.plan is not None
    assert len(found.apart) == 9 and all(a.d >= a.needed for a in found.apart)
    runs = found.plan.runs
    assert 1 < len(runs) < 8
    one_less = shortest_plan(
        CASE,
        EFFECTS,
        u_elastic_angle_arcsec=0.3,
        limits=LIMITS,
        sizes=SIZES,
        max_runs=len(runs) - 1,
    )
    assert not one_less.reached and "do not distinguish" in one_less.report()


def test_the_check_that_is_not_linear_agrees() -> None:
    checked = design().checked()
    assert checked is not None
    for effect, values in design().sizes.items():
        smallest = checked.effect(effect).smallest["even"]
        # Another form may be seen sooner; its size comes first too, in the same unit.
        size = next(iter(values.values()))
        assert smallest is not None and smallest < size


def test_a_diagnosis_of_the_plan_names_the_effect() -> None:
    plan = design().plan
    assert plan is not None
    for effect in ("bearing_play", "creep"):
        readings = cbpt.simulate(CASE, plan, effects=[(effect, SIZES[effect])], seed=2)
        verdict = cbpt.diagnose(CASE, readings).verdict
        named = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
        assert effect in named
        assert not named & (set(EFFECTS) - {effect})


def test_twins_are_told_apart_by_no_plan() -> None:
    found = shortest_plan(
        CASE, ["preload_loss", "preload_scale"], u_elastic_angle_arcsec=0.3, limits=LIMITS
    )
    assert found.twins == (("preload_loss", "preload_scale"),)
    assert "No plan can distinguish preload_loss from preload_scale" in found.report()
    assert {a.other for a in found.apart} == {""}


@pytest.mark.parametrize(
    ("effects", "more", "told"),
    [
        ([], {}, "name the effects"),
        (["bearing"], {}, "did you mean bearing_play"),
        (["ball_diameter_lot"], {}, "nearly every other effect"),
        (["creep"], {"limits": Limits(5, (400, 900), dwell_s=None)}, "depends on time_s"),
        (["creep"], {"limits": None}, r"no \[load\]"),
        (["creep"], {"max_runs": 0}, "max_runs: found 0"),
        (["creep"], {"sizes": {"wear": {}}}, "wear is not one of the effects"),
        (["creep"], {"sizes": {"creep": {"time_constant_s": 5.0}}}, "has no influence"),
    ],
)
def test_what_is_refused(effects: list[str], more: dict[str, object], told: str) -> None:
    with pytest.raises(InvalidInputError, match=told):
        shortest_plan(
            CASE,
            effects,
            u_elastic_angle_arcsec=0.3,
            **{"limits": LIMITS, **more},  # type: ignore[arg-type]
        )


def test_the_verb_writes_a_plan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "plan.toml"
    given = ["plan", str(CASE), "--separate", "bearing_play", "creep", "--u-arcsec", "0.3"]
    limits = ["--torque-Nm", "10", "--preload-N", "400", "1200"]
    limits += ["--size", "creep", "compliance_arcsec_per_Nm=0.2", "time_constant_s=20"]
    assert commands.main([*given, *limits, "--out", str(out)]) == 0
    assert "from no effect with a probability of 95 %" in capsys.readouterr().out
    assert read_plan(out).rows.u_elastic_angle_arcsec is not None
    assert commands.main(given) == 2 and "--torque-Nm MAX" in capsys.readouterr().err
    assert commands.main([*given, *limits, "--out", "x.csv"]) == 2
    wrong = ["--size", "creep", "um"]
    assert commands.main([*given, *limits, *wrong]) == 2 and "NAME=VALUE" in capsys.readouterr().err
