"""What changed between campaigns: nothing, an effect, a number, the scatter; trends by level."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import cbpt
from cbpt.cli import main as commands
from cbpt.lab.change.demanded import demanded, not_of_all
from cbpt.lab.change.loop_widths import _perhaps_different, widths_of
from cbpt.lab.change.parties import Levels, levels_of
from cbpt.lab.change.progress import rising
from cbpt.lab.change.reproducibility import dispersed, dispersion_of, with_set_ups
from cbpt.lab.change.shared import fit_shared
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.spring_priors import library_of
from common.counted import calls_of
from common.drives import examples
from common.friction_loops import FRICTION, SPRING, by_step, found, loops
from common.rings import RINGS

TOP = Path(__file__).parents[2]
# --- the verdict --------------------------------------------------------------------------


def test_the_sentence_tells_the_number_that_moved() -> None:
    """Of an effect whose size stayed and whose shape did not, the shape."""
    answer = found(loops(), loops(seed=2, engagement_arcsec=150))
    assert answer.kind == "changed"
    assert "changed: engagement_angle_arcsec rose from 3" in answer.sentence
    assert "friction_torque_Nm from" not in answer.sentence


def test_repeated_readings_say_that_nothing_changed() -> None:
    answer = found(loops(seed=1), loops(seed=2))
    assert answer.kind == "nothing" and not answer.changed and not answer.noise.changed
    assert answer.probability > 0.9
    assert "Nothing changed" in answer.sentence
    assert {u.effect for u in answer.unchanged} >= {FRICTION, "contact_stiffness"}


def test_tables_of_different_lengths_are_compared() -> None:
    shorter = {name: column[:-7] for name, column in loops(1.5, seed=2).items()}
    for answer in (found(loops(1.0), shorter), found(shorter, loops(1.0))):
        assert answer.kind == "changed" and answer.changed[0].effect == FRICTION


@pytest.mark.parametrize(("after", "direction"), [(1.5, "up"), (0.6, "down")])
def test_a_changed_effect_is_named_with_both_values(after: float, direction: str) -> None:
    answer = found(loops(1.0), loops(after, seed=2))
    assert answer.kind == "changed" and answer.probability > 0.99
    first = answer.changed[0]
    assert (first.effect, first.parameter) == (FRICTION, "friction_torque_Nm")
    assert first.direction == direction and first.probability > 0.95
    assert first.u_before is not None and first.u_after is not None
    assert abs(first.before - 1.0) < 3 * first.u_before
    assert abs(first.after - after) < 3 * first.u_after
    assert {c.effect for c in answer.changed} == {FRICTION}


def test_an_effect_may_be_gone() -> None:
    answer = found(loops(1.0), loops(0.0, seed=2))
    assert answer.kind == "changed" and answer.changed[0].direction == "gone"
    assert found(loops(0.0), loops(1.0, seed=2)).changed[0].direction == "new"


def test_a_changed_stiffness_is_no_changed_effect() -> None:
    answer = found(loops(1.0), loops(1.0, stiffness=0.85, seed=2))
    assert {c.effect for c in answer.changed} == {"contact_stiffness"}
    assert answer.changed[0].direction == "down"


def test_a_changed_scatter_is_a_finding_of_its_own() -> None:
    answer = found(loops(1.0, u=2.0), loops(1.0, seed=2, u=5.0))
    assert answer.kind == "nothing"
    assert answer.noise.changed and "scatter changed" in answer.sentence


@pytest.mark.parametrize("runs", [1, 3])
def test_what_the_model_does_not_follow_is_no_scatter(runs: int) -> None:
    """A law that is left is smooth along a run."""
    torque_Nm = 10 * np.sin(2 * np.pi * np.arange(240) / 240)

    def level(
        law_arcsec: float, scatter_arcsec: float, seed: int
    ) -> dict[str, NDArray[np.float64]]:
        n = runs * len(torque_Nm)
        torque = np.tile(torque_Nm, runs)
        law = law_arcsec * np.sin(0.6 * torque)
        noise = scatter_arcsec * np.random.default_rng(seed).standard_normal(n)
        run = np.repeat(np.arange(1.0, runs + 1), len(torque_Nm))
        columns = {"run": run, "time_s": np.arange(float(n)), "torque_Nm": torque}
        return columns | {"elastic_angle_arcsec": 60 * torque + law + noise}

    def scatter(*levels: dict[str, NDArray[np.float64]]) -> Any:
        return cbpt.change(SPRING, *levels, effects=[]).noise

    other_law = scatter(level(2, 0.3, 1), level(6, 0.3, 2))
    assert not other_law.changed
    assert np.allclose(other_law.u_arcsec, 0.3, rtol=0.2)
    assert scatter(level(4, 0.3, 1), level(4, 0.9, 2)).changed
    # Neighbours that are six times further apart see the bend of the law.
    every = slice(None, None, 6)
    coarser = {name: column[every] for name, column in level(6, 0.1, 1).items()}
    assert not scatter(level(6, 0.1, 1), coarser).changed


def test_a_rest_that_the_effects_of_all_levels_follow_is_none() -> None:
    answer = cbpt.change(SPRING, loops(1.0), loops(1.0, seed=2))
    assert answer.remains is None or answer.remains["rms_arcsec"] <= max(answer.rmse_arcsec)


def test_what_changed_is_found_without_being_told_the_effect() -> None:
    answer = cbpt.change(SPRING, loops(0.0, seed=3), loops(1.2, seed=4))
    assert answer.kind == "changed"
    assert answer.changed[0].effect == FRICTION


def told(
    effects: tuple[str, ...], perhaps: dict[str, float], rivals: tuple[tuple[str, ...], ...] = ()
) -> Any:
    """A diagnosis that leaves a rest without a name, of a combination of all effects."""
    every = (*effects, *perhaps, *(e for group in rivals for e in group), "creep")
    verdict = SimpleNamespace(
        lack_of_fit="a rest",
        effects=effects,
        perhaps=tuple(perhaps.items()),
        rivals=rivals,
        names=every,
    )
    library = (FRICTION, "backlash", "creep", "run_offset")
    fitter = SimpleNamespace(variants=[SimpleNamespace(effect=e) for e in library])
    return SimpleNamespace(
        competition=SimpleNamespace(fitter=fitter),
        verdict=verdict,
        combinations=lambda: [SimpleNamespace(effects=every, probability=1.0)],
    )


def test_what_may_be_part_of_a_rest_is_fitted_only_where_all_levels_have_it() -> None:
    """Beside a rest without a name the effects are those that the diagnoses tell, and what the
    answers of all levels have in common."""
    before = told((FRICTION,), {"backlash": 0.4})
    shared = ["creep", FRICTION]
    assert demanded([before, told((FRICTION,), {})]) == [[FRICTION], ["backlash", FRICTION], shared]
    rivals = told((), {}, ((FRICTION, "run_offset"),))
    assert demanded([rivals]) == [[FRICTION], [], shared]
    before.verdict.lack_of_fit = None
    assert demanded([before]) == [["backlash", "creep", FRICTION]]


def test_what_the_table_of_a_level_cannot_show_is_left_out_and_told() -> None:
    timed, bare = told((FRICTION,), {"creep": 0.4}), told((FRICTION,), {})
    bare.competition.fitter.variants = [SimpleNamespace(effect=FRICTION)]
    assert demanded([timed, bare]) == [[FRICTION], [FRICTION]]
    assert not_of_all([timed, bare]) == ["creep"] and not_of_all([timed, timed]) == []


# --- the loops as they were measured ------------------------------------------------------


def test_loops_that_differ_contradict_that_nothing_changed() -> None:
    """Friction that nobody fits: in the fitted terms nothing changed, in the loops it did."""
    answer = cbpt.change(SPRING, loops(1.0), loops(1.7, seed=2), effects=["backlash"])
    assert answer.kind == "undecided" and answer.probability < 0.5 and not answer.changed
    assert "measured loops changed" in answer.sentence and "cannot be told" in answer.sentence
    [row] = answer.to_dict()["loops"]
    assert row["differ"] == ["before", "after"] and row["loops"] == (2, 2)
    # The branches of Dahl's friction are 2 Tf/k apart where they are fully engaged.
    assert row["width_arcsec"] == pytest.approx((120, 204), rel=0.03)
    for width in row["width_arcsec"]:
        assert f"{width:.4g} arcsec" in answer.sentence and f"{width:.4g} +- " in answer.report()
    # Beside a rig that comes back no better than that they say nothing.
    unsure = cbpt.change(
        *(SPRING, loops(1.0), loops(1.7, seed=2)), effects=["backlash"], reproducibility_arcsec=40
    )
    assert unsure.kind == "nothing"


@pytest.mark.parametrize(
    ("width_arcsec", "u_arcsec", "may"),
    [
        ((2631.0, 820.0), (600.0, 500.0), (0, 1)),
        ((2631.0, 1900.0), (600.0, 500.0), None),  # by less than a factor of 1.5
        ((1000.0, 200.0), (600.0, 500.0), None),  # by less than twice their uncertainty
        ((2631.0, 820.0), (np.nan, np.nan), None),
    ],
)
def test_widths_that_may_differ_are_not_said_to_be_one(
    width_arcsec: tuple[float, ...], u_arcsec: tuple[float, ...], may: tuple[int, int] | None
) -> None:
    assert _perhaps_different(np.array(width_arcsec), np.array(u_arcsec)) == may


@pytest.mark.parametrize(
    ("repeated", "may"), [([[0, 1]], (1, 2)), ([[1, 2]], None), ([[0, 1], [1, 2]], None)]
)
def test_what_repeated_levels_differ_by_hides_no_larger_difference(
    repeated: list[list[int]], may: tuple[int, int] | None
) -> None:
    """One repeat estimates a reproducibility, and hardly better than by a factor of two."""
    tables = [loops(friction, seed=k) for k, friction in enumerate((1.0, 1.3, 0.6))]
    levels = [cbpt.read_readings(table, need_preload=False) for table in tables]
    [widths] = widths_of(levels, 25.0, repeated)
    assert widths.differ is None and widths.may_differ == may


@given(st.integers(0, 10**6), st.sampled_from([2, 3, 5]))
@examples(12)
def test_loops_of_one_width_hardly_ever_differ(seed: int, levels: int) -> None:
    rng = np.random.default_rng(seed)
    noisy = [
        loops(1.0) | {"elastic_angle_arcsec": angle + rng.normal(0, 3, len(angle))}
        for angle in [loops(1.0)["elastic_angle_arcsec"]] * levels
    ]
    tables = [cbpt.read_readings(table, need_preload=False) for table in noisy]
    assert all(widths.differ is None for widths in widths_of(tables))


def test_a_form_that_a_level_cannot_show_alone_is_fitted_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """From neutral values and from those of the other levels."""
    case = cbpt.Case.from_dict(SPRING)
    readings = [cbpt.read_readings(loops(f), need_preload=False) for f in (1.0, 1.5)]
    campaigns = [campaign_of(case, r, []) for r in readings]
    with_it = levels_of(campaigns, [FRICTION])
    monkeypatch.setattr("cbpt.lab.change.parties._Alone._values_in", lambda level, forms: None)
    without = levels_of(campaigns, [FRICTION])
    assert with_it is not None and without is not None
    for one, other in zip(with_it.fits, without.fits, strict=True):
        assert other.log_evidence == pytest.approx(one.log_evidence, abs=0.1)


def test_friction_that_does_not_follow_the_preload_is_told_by_all_levels() -> None:
    """Levels of one preload each have two of them together."""

    def level(preload_N: float) -> Campaign:
        plan = {"torque_Nm": 0.05 * np.arange(8), "preload_N": np.full(8, preload_N)}
        table = plan | {"elastic_angle_arcsec": np.arange(8.0)}
        return campaign_of(cbpt.Case.from_dict(RINGS), cbpt.read_readings(table), [])

    alone, other = level(400.0), level(600.0)
    constant = f"{FRICTION}:constant"
    assert constant not in {v.label for v in library_of(alone, beside=[level(400.0)])}
    assert constant in {v.label for v in library_of(alone, beside=[other])}
    levels = levels_of([alone, other], [constant])
    assert levels is not None and [v.label for v in levels.variants] == [constant]


def test_no_level_is_searched_from_every_other_level(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice the levels are twice the fits, and no search in the same forms is made again."""
    case = cbpt.Case.from_dict(SPRING)
    made = calls_of(monkeypatch, Fitter, "fit")

    def fits(levels: int) -> int:
        made.clear()
        readings = [
            cbpt.read_readings(loops(1 + 0.1 * k, seed=k), need_preload=False)
            for k in range(levels)
        ]
        assert levels_of([campaign_of(case, r, []) for r in readings], [FRICTION]) is not None
        return len(made)

    assert fits(8) <= 2.2 * fits(4)


# --- what a model does not follow ---------------------------------------------------------


def test_a_wave_along_the_runs_that_lies_otherwise_is_no_change() -> None:
    """Neighbouring readings are off alike, so they are few observations; what differs is no number
    of the model."""

    def waved(phase: float, seed: int) -> dict[str, NDArray[np.float64]]:
        plain = loops(seed=seed)
        at = 2 * np.pi * np.arange(len(plain["run"])) / 16 + phase
        angle = plain["elastic_angle_arcsec"] + 16 * np.sin(at)
        return plain | {"elastic_angle_arcsec": angle}

    found = cbpt.change(SPRING, waved(0.0, 1), waved(1.8, 2), effects=[FRICTION])
    assert found.kind != "changed" and found.weighed.something < 0.1


# --- the reproducibility of a set-up ------------------------------------------------------


def test_a_set_up_that_differs_a_little_is_no_change() -> None:
    """0.1 N m of friction are 4 arcsec rms of the angle: far more than the mean leaves open."""
    one, again, changed = loops(1.0), loops(1.1, seed=2), loops(2.5, seed=3)
    assert found(one, again).kind == "changed"

    def told(after: dict[str, NDArray[np.float64]]) -> cbpt.Change:
        return cbpt.change(SPRING, one, after, effects=[FRICTION], reproducibility_arcsec=5.0)

    same, other = told(again), told(changed)
    assert same.kind == "nothing" and same.to_dict()["reproducibility_arcsec"] == 5.0
    assert "set-up" in same.report()
    assert other.kind == "changed" and other.changed[0].effect == FRICTION
    # The values of a level are known no better than the rig comes back to its state.
    wide, narrow = other.changed[0].u_before, found(one, changed).changed[0].u_before
    assert wide is not None and narrow is not None and wide > 3 * narrow


def test_the_reproducibility_is_estimated_from_repeated_set_ups() -> None:
    def told(*friction_Nm: float) -> cbpt.Change:
        return cbpt.change(
            SPRING,
            by_step(*friction_Nm),
            by="step",
            effects=[FRICTION],
            repeated=[("1", "2")],
        )

    same, other = told(1.0, 1.1), told(1.0, 1.1, 2.5)
    assert same.kind == "nothing" and other.kind == "changed"
    for answer in (same, other):
        assert answer.reproducibility_arcsec == pytest.approx(3.0, rel=0.5)
        assert "comes back to the same state" not in answer.sentence


@pytest.mark.parametrize("again", ["as_built_repeated", "as built (Repeated)", "as_built repeated"])
def test_a_level_may_say_by_its_name_that_it_repeats_another(again: str) -> None:
    table = dict(by_step(1.0, 1.1))
    state = "as built" if " (" in again else "as_built"
    table["step"] = np.where(table["step"] == 1, again, state)
    found = cbpt.change(SPRING, table, by="step", effects=[FRICTION])
    assert found.kind == "nothing" and found.reproducibility_arcsec == pytest.approx(3.0, rel=0.5)
    assert f"by their names {again} and {state} repeat one state" in found.notes
    table["step"] = np.where(table["step"] == again, "not_repeated_yet", state)
    assert cbpt.change(SPRING, table, by="step", effects=[FRICTION]).kind == "changed"


@pytest.mark.parametrize("told", ["by a column", "by the files"])
def test_two_tables_may_say_that_one_repeats_the_other(told: str, tmp_path: Path) -> None:
    """A column of words or the names of their files say what a level's name says under `by`."""
    names = ("as_built", "as_built_repeated") if told == "by the files" else ("before", "after")
    parts = []
    for name, state, part in zip(
        names, ("as_built", "as_built repeated"), (loops(1.0), loops(1.1, seed=2)), strict=True
    ):
        table = dict(part)
        if told == "by a column":
            table["state"] = np.full(len(table["torque_Nm"]), state)
        parts.append(tmp_path / f"{name}.csv")
        rows = zip(*table.values(), strict=True)
        lines = [",".join(table), *(",".join(map(str, row)) for row in rows)]
        parts[-1].write_text("\n".join(lines))
    found = cbpt.change(SPRING, *parts, effects=[FRICTION])
    assert found.kind == "nothing"
    assert any("by their names" in note and "repeat one state" in note for note in found.notes)
    parts = [path.rename(tmp_path / f"{k}.csv") for k, path in enumerate(parts)]
    if told == "by the files":
        assert cbpt.change(SPRING, *parts, effects=[FRICTION]).kind == "changed"


def test_the_noise_of_a_set_up_is_a_covariance() -> None:
    """Whitened squares and determinant are those of C + J J', J the way from one fitted curve to
    the other, its beginning and its whole, scaled to the size."""
    case = cbpt.Case.from_dict(SPRING)
    tables = (loops(1.0), loops(2.5, seed=2))
    readings = [cbpt.read_readings(table, need_preload=False) for table in tables]
    levels = levels_of([campaign_of(case, r, []) for r in readings], [FRICTION])
    assert levels is not None
    plain, other = levels.parties
    wide = with_set_ups(levels, 3.0).parties[0]
    n = len(readings[0])
    inverse = plain.problem.whitener(np.eye(n))
    covariance = np.linalg.inv(inverse.T @ inverse)
    far = plain.problem.coordinates(other.point) - plain.problem.coordinates(plain.point)
    begun = plain.problem.columns(plain.point) @ (far / plain.problem.unit)
    # The loads of both tables are the same.
    columns = np.column_stack([begun, other.point.angle_arcsec - plain.point.angle_arcsec])
    offsets = plain.problem.campaign.offsets
    columns = columns - offsets @ np.linalg.lstsq(offsets, columns, rcond=None)[0]
    columns *= 3.0 / np.sqrt(np.mean(columns**2, axis=0))
    wanted = covariance + columns @ columns.T
    r = np.sin(np.arange(n))
    assert np.sum(wide.problem.whitener(r) ** 2) == pytest.approx(r @ np.linalg.solve(wanted, r))
    assert wide.problem.whitener.log_det == pytest.approx(np.linalg.slogdet(wanted)[1])


@pytest.mark.parametrize("arcsec", [3.0, 5.0, 10.0, 20.0, 40.0])
def test_a_worse_reproducibility_never_makes_a_change(arcsec: float) -> None:
    answer = cbpt.change(
        SPRING, loops(1.0), loops(1.1, seed=2), effects=[FRICTION], reproducibility_arcsec=arcsec
    )
    assert answer.kind == "nothing"


@pytest.mark.parametrize("friction_Nm", [1.1, 2.5])
def test_a_change_says_which_reproducibility_would_undo_it(friction_Nm: float) -> None:
    """A rig that is off by what the levels differ by has no change that can be told; one that is
    off by far less has it still."""
    one, other = loops(1.0), loops(friction_Nm, seed=2)
    answer = found(one, other)
    size = answer.to_dict()["levels_differ_by_arcsec"]
    assert answer.kind == "changed" and size > 0
    assert f"{size:.3g} arcsec" in answer.sentence and "Measure one state again" in answer.sentence
    assert "which these readings do not show" in answer.sentence
    assert answer.to_dict()["verdict"]["rests_on"] == [
        {"number": "reproducibility_arcsec", "taken_as": 0.0, "would_undo": size / 5}
    ]

    def told(arcsec: float) -> cbpt.Change:
        return cbpt.change(SPRING, one, other, effects=[FRICTION], reproducibility_arcsec=arcsec)

    undone = told(size)
    # Friction of 1.0 and 2.5 N m is not "nothing changed": a change like that cannot be seen.
    assert undone.kind == ("nothing" if friction_Nm == 1.1 else "undecided")
    assert undone.levels_differ_by_arcsec is None and "one state again" not in undone.report()
    assert undone.to_dict()["verdict"]["rests_on"] == []
    assert told(0.05 * size).kind == "changed"


@pytest.mark.parametrize("friction_Nm", [1.1, 1.3])
def test_repeated_levels_gain_by_values_of_their_own_what_noise_would(friction_Nm: float) -> None:
    """A unit of misfit for each value, once their dispersion is taken out."""
    case = cbpt.Case.from_dict(SPRING)
    tables = (loops(1.0), loops(friction_Nm, seed=2))
    readings = [cbpt.read_readings(table, need_preload=False) for table in tables]
    levels = levels_of([campaign_of(case, r, []) for r in readings], [FRICTION])
    assert levels is not None
    wide = dispersed(levels, dispersion_of(levels, [[0, 1]]))
    numbers = frozenset(range(len(levels.fits[0].unknowns)))

    def gain(of: Levels) -> float:
        one, own = (fit_shared(of.parties, of.variants, s) for s in (frozenset(), numbers))
        assert one is not None and own is not None
        return (one.misfit - own.misfit) / len(numbers)

    assert gain(levels) > 5
    assert gain(wide) == pytest.approx(1, rel=0.2)


def test_repeated_levels_must_be_there() -> None:
    table = by_step(1.0, 1.0)
    with pytest.raises(cbpt.InvalidInputError, match="no level 'initial'"):
        cbpt.change(SPRING, table, by="step", effects=[FRICTION], repeated=[("initial", "1")])
    with pytest.raises(cbpt.InvalidInputError, match="two different levels"):
        cbpt.change(SPRING, table, by="step", effects=[FRICTION], repeated=[("1", "1")])
    with pytest.raises(cbpt.InvalidInputError, match="give one of them"):
        cbpt.change(
            SPRING,
            table,
            by="step",
            effects=[FRICTION],
            repeated=[("1", "2")],
            reproducibility_arcsec=1.0,
        )
    with pytest.raises(cbpt.InvalidInputError, match="finite number not less than 0"):
        cbpt.change(SPRING, loops(), loops(), effects=[FRICTION], reproducibility_arcsec=-1.0)


# --- the document and the command ---------------------------------------------------------


def write(path: Path, table: dict[str, NDArray[np.float64]]) -> Path:
    rows = zip(*(values.tolist() for values in table.values()), strict=True)
    path.write_text("\n".join([",".join(table), *(",".join(map(str, row)) for row in rows)]))
    return path


def test_the_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    case.write_text(cbpt.Case.from_dict(SPRING).to_toml())
    one = write(tmp_path / "before.csv", loops(1.0))
    two = write(tmp_path / "after.csv", loops(1.5, seed=2))
    given = ["change", str(case), str(one), str(two), "--with", FRICTION]
    assert commands.main([*given, "--json", str(tmp_path / "c.json")]) == 0
    assert "rose" in capsys.readouterr().out
    document = json.loads((tmp_path / "c.json").read_text())
    verdict = document["verdict"]
    assert verdict["kind"] == "changed"
    assert commands.main([*given, "--angle-unit", "mrad"]) == 0
    told = capsys.readouterr().out.partition("Note:")[0]
    assert "rmse_mrad" in told and "torque, mrad" in told and "arcsec" not in told
    keys = {"effect", "parameter", "unit", "before", "after", "u_before", "u_after"}
    assert keys | {"direction", "probability"} <= verdict["changed"][0].keys()
    assert {"remains", "noise", "levels", "unchanged", "combinations"} <= document.keys()
    assert commands.main(["change", str(case), str(one)]) == 2
    assert commands.main(["change", str(case), str(one), str(two), "--by", "run"]) == 2


def test_progress_goes_from_the_beginning_to_the_whole() -> None:
    told: list[tuple[str, float]] = []
    tables = loops(1.0), loops(1.5, seed=2)
    for effects in ([FRICTION], None):
        told.clear()
        cbpt.change(SPRING, *tables, effects=effects, progress=lambda *now: told.append(now))
        shares = [share for _, share in told]
        assert shares == sorted(shares) and shares[-1] == 1.0 and len(set(shares)) > 5
    assert "diagnosis of after, the drive as stated" in [what for what, _ in told]


def test_both_a_table_and_a_column_are_refused() -> None:
    with pytest.raises(cbpt.InvalidInputError, match="not both"):
        cbpt.change(SPRING, loops(), loops(seed=2), by="run")


def test_a_change_tells_how_much_runs_of_one_level_differ() -> None:
    """A new set-up is another thing, but it differs by no less than runs without one."""
    note = found(loops(1.0), loops(1.5, seed=2)).notes[-1]
    differ = re.search(r"runs with the same torques differ by ([\d.]+) arcsec", note)
    assert differ is not None and float(differ.group(1)) == pytest.approx(2.0, rel=0.25)


def test_a_table_held_against_itself_is_told_so() -> None:
    same = loops(1.0)
    told = "the tables are the same readings, so nothing can have changed between them"
    assert told in found(same, same).notes
    assert told not in found(same, loops(1.0, seed=2)).notes


def test_progress_never_goes_back_where_parts_are_done_at_once() -> None:
    told: list[float] = []
    tell = rising(lambda what, share: told.append(share))
    for share in (0.2, 0.6, 0.4, 0.7):
        tell("", share)
    assert told == [0.2, 0.6, 0.6, 0.7]
