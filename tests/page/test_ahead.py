"""Models that are prepared while nobody asks: which, when, and that they are what one would get.

Groups: turns and neighbourhoods, with work that takes no time; the fit of a set; a session.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator, Sequence
from itertools import permutations
from typing import Any

import pytest
from starlette.testclient import TestClient

from cbpt.effects import expression
from cbpt.errors import InvalidInputError
from cbpt.page.document.models import Models
from cbpt.page.document.plain import to_json
from cbpt.page.workbench import ahead as module
from cbpt.page.workbench.ahead import Ahead, Effects, Step, Turns
from cbpt.page.workbench.session import Session
from common import PATIENCE_S
from common.hidden import diagnosed
from common.page_server import CASE, DATA, client_of, opened, own_effect

OFFERED = ("a", "b", "c")


class Work:
    """Makes a model of nothing: the text is the set. What is asked for waits where told to."""

    def __init__(self) -> None:
        self.made: list[Effects] = []
        self.begun, self.go_on = threading.Event(), threading.Event()
        self.waits_at: Effects | None = None

    def __call__(self, effects: Effects, step: Step) -> str:
        if effects == self.waits_at:
            self.begun.set()
            assert self.go_on.wait(PATIENCE_S)
        step()
        if "z" in effects:
            raise InvalidInputError("z cannot be fitted")
        self.made.append(effects)
        return "+".join(effects)


def prepares(
    work: Work,
    turns: Turns | None = None,
    offered: Sequence[str] = OFFERED,
    known: Sequence[Sequence[str]] = (),
) -> Ahead:
    sets = {frozenset(each) for each in known}
    return Ahead(turns or Turns(), work, sets, lambda: offered, most_effects=3, pause_s=0.0)


# --- turns and neighbourhoods ---------------------------------------------------------------


def test_what_is_one_switch_away_is_prepared_the_likeliest_first() -> None:
    work = Work()
    ahead = prepares(work, known=[(), ("a",), ("c",)])
    ahead.around(["b"], [])
    assert ahead.join(PATIENCE_S)
    # As the page asks for them: what is shown, then what is switched on.
    assert work.made == [("b", "a"), ("b", "c"), ("b",)]
    ahead.around(["b", "a"])
    assert ahead.join(PATIENCE_S)
    assert work.made[3:] == [("a", "b", "c")]
    # With three effects more would be too many.
    ahead.around(["c", "b", "a"])
    assert ahead.join(PATIENCE_S)
    assert work.made[4:] == [("a", "c"), ("a", "b")]


def test_what_is_two_switches_away_comes_after_it_the_likeliest_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "MOST_FAR", 4)
    work = Work()
    # The page has one of the sets that one switch leads to; what follows on it is prepared too.
    ahead = prepares(work, offered=("a", "b", "c", "d"), known=[(), ("a",), ("a", "b")])
    ahead.around(["a"])
    assert ahead.join(PATIENCE_S)
    assert work.made == [
        *[("a", "c"), ("a", "d")],
        *[("a", "b", "c"), ("a", "b", "d"), ("a", "c", "b"), ("b",)],
    ]
    # Of what is there nothing is made again.
    ahead.around(["a", "c"])
    assert ahead.join(PATIENCE_S)
    assert work.made[6:8] == [("a", "c", "d"), ("c",)]
    assert ("c", "a") not in work.made  # on and off again: the page has what it shows


def test_near_goes_before_the_rest_and_the_rest_before_far(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "MOST_FAR", 1)
    work, turns = Work(), Turns()
    ahead = prepares(work, turns, offered=("a", "b"), known=[()])
    with turns.rest():
        ahead.around([])
        assert turns.last()
        assert work.made == [("a",), ("b",)]
        # Somebody looks at another model meanwhile: what is near it is not far any more.
        ahead.around(["b"])
        assert turns.last()
        assert work.made[2:] == [("b", "a")]
    ahead.around([])
    assert ahead.join(PATIENCE_S)
    assert work.made[3:] == [("a", "b")]


def test_far_stops_where_the_rest_begins_and_is_taken_up_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "MOST_FAR", 1)
    work, turns = Work(), Turns()
    work.waits_at = ("a", "b")
    ahead = prepares(work, turns, offered=("a", "b"), known=[(), ("a",), ("b",)])
    ahead.around([])
    assert work.begun.wait(PATIENCE_S)
    assert turns.last()
    with turns.rest():
        work.go_on.set()
        assert turns.last()
        assert work.made == []
    assert ahead.join(PATIENCE_S)
    assert work.made == [("a", "b")]


def test_far_is_left_where_a_model_takes_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_FAR", 9)
    monkeypatch.setattr(module, "MOST_FAR_S", -1.0)  # no work is as little
    ahead = prepares(Work(), known=[()])
    for shown, near in (([], ["a", "b", "c"]), (["a"], ["ab", "ac"])):
        ahead.around(shown)
        assert ahead.join(PATIENCE_S)
        assert ["".join(effects) for effects in ahead.ready[-len(near) :]] == near
    assert len(ahead.ready) == 5


def test_far_gives_room_to_near(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_FAR", 9)
    monkeypatch.setattr(module, "MOST", 4)
    ahead = prepares(Work(), offered=("a", "b", "c"), known=[()])
    ahead.around([])
    assert ahead.join(PATIENCE_S)
    assert ahead.ready == [("a",), ("b",), ("c",), ("a", "b")]
    ahead.around(["c"])
    assert ahead.join(PATIENCE_S)
    assert {("c", "a"), ("c", "b")} <= set(ahead.ready)


def test_a_prepared_model_is_made_once_and_so_is_one_that_was_asked_for() -> None:
    work = Work()
    ahead = prepares(work, known=[()])
    assert ahead.model(["b", "a"]) == "b+a"
    ahead.around(["b"])
    assert ahead.join(PATIENCE_S)
    assert ahead.model(["b", "c"]) == "b+c"
    assert ahead.model(["b", "a"]) == "b+a"
    assert work.made == [("b", "a"), ("b", "c")]


def test_one_that_cannot_be_fitted_stops_no_other_and_is_told_when_asked() -> None:
    work = Work()
    ahead = prepares(work, offered=("z", "a"), known=[()])
    ahead.around(["b"])
    assert ahead.join(PATIENCE_S)
    assert ahead.ready == [("b", "a")]
    with pytest.raises(InvalidInputError, match="z cannot be fitted"):
        ahead.model(["b", "z"])


def test_a_mistake_while_preparing_is_told_once_and_stops_no_other(
    capsys: pytest.CaptureFixture[str],
) -> None:
    tried: list[Effects] = []

    def made(effects: Effects, step: Step) -> str:
        tried.append(effects)
        if "z" in effects:
            raise ZeroDivisionError("a slip of ours")
        return "+".join(effects)

    ahead = Ahead(Turns(), made, [frozenset()], lambda: ("z", "a"), most_effects=3, pause_s=0.0)
    for _ in range(2):
        ahead.around(["b"])
        assert ahead.join(PATIENCE_S)
    assert ahead.ready == [("b", "a")]
    assert tried == [("b", "z"), ("b", "a")]
    assert capsys.readouterr().err.count("Traceback") == 1


def test_who_asks_goes_first_and_what_was_begun_is_taken_up_again() -> None:
    work, turns = Work(), Turns()
    work.waits_at = ("b", "a")
    ahead = prepares(work, turns, known=[()])
    ahead.around(["b"])
    assert work.begun.wait(PATIENCE_S)
    with turns.first():
        work.go_on.set()
        assert ahead.model(["c"]) == "c"
        assert work.made == [("c",)]
    assert ahead.join(PATIENCE_S)
    assert work.made == [("c",), ("b", "a"), ("b", "c")]


def test_another_model_shown_moves_the_neighbourhood_at_once() -> None:
    work = Work()
    work.waits_at = ("b", "a")
    ahead = prepares(work, known=[()])
    ahead.around(["b"])
    assert work.begun.wait(PATIENCE_S)
    ahead.around(["c"])
    work.go_on.set()
    assert ahead.join(PATIENCE_S)
    assert work.made == [("c", "a"), ("c", "b")]


@pytest.mark.parametrize("end", ["forget", "end"])
def test_what_was_under_way_when_it_held_no_longer_is_not_kept(end: str) -> None:
    work = Work()
    work.waits_at = ("b", "a")
    ahead = prepares(work, known=[()])
    ahead.model(["c"])
    ahead.around(["b"])
    assert work.begun.wait(PATIENCE_S)
    getattr(ahead, end)()
    work.go_on.set()
    assert ahead.join(PATIENCE_S)
    assert ahead.ready == []
    ahead.around(["b"])
    assert ahead.join(PATIENCE_S)
    assert len(ahead.ready) == (2 if end == "forget" else 0)


def test_the_rest_waits_for_what_is_prepared_and_all_ends_together() -> None:
    work, turns = Work(), Turns()
    work.waits_at = ("b", "a")
    ahead = prepares(work, turns, known=[()])
    ahead.around(["b"])
    assert work.begun.wait(PATIENCE_S)
    last: list[Any] = []

    def wait() -> None:
        last.append(turns.last())
        last.append(list(work.made))

    waiting = threading.Thread(target=wait)
    waiting.start()
    work.go_on.set()
    waiting.join(PATIENCE_S)
    assert last == [True, [("b", "a"), ("b", "c")]]
    turns.end()
    ahead.around(["c"])
    assert ahead.join(PATIENCE_S)
    assert len(work.made) == 2
    assert not turns.last()


def test_the_room_is_bounded_and_what_is_prepared_stays_while_it_is_near(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "MOST_BYTES", 9)
    work = Work()
    ahead = prepares(work, offered=("a", "c", "d", "e"), known=[()])
    ahead.around(["b"])
    assert ahead.join(PATIENCE_S)
    assert ahead.ready == [("b", "a"), ("b", "c"), ("b", "d")]
    # The fourth has no room, so nothing more is tried; what is asked for takes it all the same.
    assert work.made[-1] == ("b", "e")
    ahead.model(["x", "y"])
    assert ahead.ready == [("b", "c"), ("b", "d"), ("x", "y")]
    # Elsewhere, what was near before goes.
    ahead.around(["x"])
    assert ahead.join(PATIENCE_S)
    assert ahead.ready[-3:] == [("x", "a"), ("x", "c"), ("x", "d")]
    monkeypatch.setattr(module, "MOST_BYTES", 1)
    assert ahead.model(["too", "large"]) == "too+large"
    assert ("too", "large") not in ahead.ready


# --- the fit of a set -----------------------------------------------------------------------

SET = ("friction_hysteresis", "output_torsion", "plate_tilt")


# Hardly told apart: where the search ends hangs on the last digits of a solution.
ILL = ("plate_tilt", "thermal_preload", "torque_scale")


def told(models: Models, effects: Sequence[str]) -> str:
    """The model as the page is sent it; the ladder beside it follows the order of asking."""
    return to_json(models.choice(effects)["model"])


@pytest.mark.parametrize("effects", [SET, ILL])
def test_a_set_has_one_model_whatever_was_asked_for_before(effects: tuple[str, ...]) -> None:
    d = diagnosed("dev04")
    afresh = told(Models(d, d.readings), effects)
    for order in permutations(effects):
        models = Models(d, d.readings)
        for n in range(1, len(order)):
            models.choice(order[:n])
        assert told(models, order) == afresh, order
        assert told(models, effects) == afresh, order


def test_a_set_with_an_own_effect_has_one_model_too() -> None:
    d = diagnosed("dev04")
    own = expression("mine", "series", "a * torque_Nm^2", {"a": 1e-7})
    effects = ["friction_hysteresis", "mine"]
    alone, after = Models(d, d.readings), Models(d, d.readings)
    for models in (alone, after):
        models.add_own(own)
    for before in (["mine"], ["friction_hysteresis"], ["mine", "creep", "friction_hysteresis"]):
        after.choice(before)
    assert told(after, effects) == told(alone, effects)


def test_sets_in_any_order_prepared_or_asked_for_have_the_same_texts() -> None:
    d = diagnosed("dev04")
    sets = [ILL, ILL[:2], ("friction_hysteresis", "creep"), ("run_in", "plate_tilt"), ("creep",)]
    texts = []
    for order in (sets, sets[::-1], [sets[i] for i in (2, 0, 4, 1, 3)]):
        models = Models(d, d.readings)
        texts.append({effects: to_json(models.choice(effects)) for effects in order})
    assert texts[0] == texts[1] == texts[2]
    models = Models(d, d.readings)
    ahead = Ahead(
        Turns(), lambda e, step: to_json(models.choice(e, step)), (), lambda: ILL, 3, pause_s=0.0
    )
    ahead.around(ILL[:2])
    assert ahead.join(PATIENCE_S)
    assert ILL in ahead.ready
    assert ahead.model(ILL) == texts[0][ILL]


def test_fits_are_bounded_and_grow_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cbpt.page.document.bench._MOST_KEPT", 2)
    d = diagnosed("dev04")
    models = Models(d, d.readings)
    first = told(models, SET)
    models.choice(["friction_hysteresis", "run_in"])
    models.choice(["friction_hysteresis", "rough_contact"])
    assert len(models._bench._kept) == 2
    assert told(models, SET) == first


# --- a session ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    found = Session.of_files(CASE, DATA)
    found.start()
    assert found.join(PATIENCE_S)
    yield found
    found.close()


def prepared(session: Session) -> Ahead:
    assert session._ahead is not None
    assert session._ahead.join(PATIENCE_S)
    return session._ahead


def test_a_prepared_model_is_the_one_that_would_be_fitted_when_asked(session: Session) -> None:
    ahead = prepared(session)
    asked = ("friction_hysteresis", "creep")
    assert asked in ahead.ready
    d = session._diagnosed().diagnosis
    assert session._readings is not None
    directly = told(Models(d, session._readings), asked)
    assert to_json(json.loads(session.model(asked))["model"]) == directly


def test_every_candidate_of_the_page_is_prepared_beside_the_answer(session: Session) -> None:
    ahead = prepared(session)
    document = json.loads(session.document() or "")
    there = {tuple(m["effects"]) for m in document["models"]}
    for candidate in document["candidates"]:
        effects = ("friction_hysteresis", candidate["effect"])
        if effects[0] != effects[1] and tuple(sorted(effects)) not in there | ahead._cannot:
            assert effects in ahead.ready


def test_a_model_that_the_page_had_moves_the_neighbourhood_too(session: Session) -> None:
    client = client_of(session)
    wanted = ("run_in", "creep")
    assert wanted not in prepared(session).ready
    assert client.post("/api/shown", json={"effects": ["run_in"]}).json() == {}
    assert wanted in prepared(session).ready
    found = client.post("/api/model", json={"effects": wanted})
    assert found.json()["model"]["key"] == "creep+run_in"
    assert ("creep", "run_in", "friction_hysteresis") in prepared(session).ready
    for wrong in ({"effects": "creep"}, {"effects": ["creep"] * 9}, {}):
        assert client.post("/api/shown", json=wrong).status_code == 400


def test_an_own_effect_leaves_nothing_prepared_that_was_so_without_it(session: Session) -> None:
    with_it = ("friction_hysteresis", "mine")
    errors = []
    for power in ("2", "3"):
        session.fit_own(own_effect({"start": 1e-7}, expression=f"a * torque_Nm^{power}"))
        session.shown(["friction_hysteresis"])
        assert with_it in prepared(session).ready
        errors.append(json.loads(session.model(with_it))["model"]["rmse_arcsec"])
    assert errors[0] != errors[1]


def test_other_files_leave_nothing_prepared(client: TestClient, session: Session) -> None:
    other = Session.of_files(CASE, DATA)
    other.start()
    assert other.join(PATIENCE_S)
    ahead = other._ahead
    assert ahead is not None
    assert opened(client_of(other), DATA.read_bytes()).json()["ready"]
    assert ahead.join(PATIENCE_S)
    assert ahead.ready == []
    answer = client_of(other).post("/api/shown", json={"effects": []})
    assert answer.status_code == 409
    other.close()
