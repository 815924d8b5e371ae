"""Plans and bounds in TOML with values, depths and lengths that nobody means.

Every file is a good one with one thing made odd; it may raise the package's errors alone, and take
no time or memory beyond its length.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

import cbpt
from cbpt.design.bounds import read_bounds
from cbpt.errors import CbptError, InvalidInputError, PlanError
from cbpt.lab.experiment.plan import read_plan
from common.tables import DATA

EXAMPLES = Path(__file__).parents[2] / "examples"
CASE = cbpt.Case.from_file(EXAMPLES / "base_case.toml")
READERS: dict[str, Callable[[Path], object]] = {
    "plan.toml": lambda path: read_plan(path, CASE),
    "bounds.toml": lambda path: read_bounds(path, CASE),
}
ODD = [
    "inf", "nan", "-inf", "1e999", "9" * 400, "9" * 5000, "0x" + "f" * 5000, "true", '"x"', "[]",
    "{}", "[[1]]", "{ a = 1 }", "1979-05-27", "07:32:00", "-1", "0", "1e-320",
    "1979-05-27T07:32:00Z",
    "[inf, inf]", f"[{'9' * 400}, 1]", f'"{"x" * 3000}"', f"{{ to = {'9' * 400}, points = 5 }}",
    "{ from = -1e308, to = 1e308, points = 5 }", '{ to = 1e308, points = 9, shape = "loop" }',
    '{ to = 1e-320, from = -1e11, points = 9, shape = "loop" }', "{ to = 10, points = inf }",
    "[1e308, -1e308]", "[" * 2000 + "]" * 2000, "{ a = " * 300 + "1" + " }" * 300,
]  # fmt: skip
WHOLE = {
    "a key of many parts": "a." * 300_000 + "a = 1",
    "a section of many parts": f"[{'a.' * 300_000}a]",
    "a long key": "a" * 900_000 + " = 1",
    "too large": "#" * (1 << 20) + "\n\n",
    "not UTF-8": "a = \udcff",
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("odd", ODD, ids=lambda odd: odd[:20])
def test_an_odd_value(tmp_path: Path, name: str, odd: str) -> None:
    good = (EXAMPLES / name).read_text(encoding="utf-8")
    for place in re.finditer(r"= *([^\n#]+)", good):
        path = tmp_path / name
        path.write_text(good[: place.start(1)] + odd + "\n" + good[place.end(1) :])
        try:
            READERS[name](path)
        except CbptError as error:
            assert str(path) in str(error) and len(str(error)) < 3000


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("text", WHOLE.values(), ids=WHOLE.keys())
def test_an_odd_file(tmp_path: Path, name: str, text: str) -> None:
    path = tmp_path / name
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(CbptError) as caught:
        READERS[name](path)
    assert str(path) in str(caught.value) and len(str(caught.value)) < 1000


@pytest.mark.parametrize("name", ["plan_odd_1.toml", "plan_odd_4.toml"])
def test_a_hostile_file(name: str) -> None:
    with pytest.raises(PlanError):
        read_plan(DATA / "hostile" / name, CASE)
    with pytest.raises(InvalidInputError):
        read_bounds(DATA / "hostile" / name, CASE)


def test_a_plan_that_says_much_in_few_words_is_refused_early(tmp_path: Path) -> None:
    many = ", ".join(["1"] * 100_000)
    path = tmp_path / "plan.toml"
    for text in (
        f"dwell_s = 1\n[[run]]\ntorque_Nm = [{many}]\ninput_angle_deg = [{many}]\n",
        f"[[run]]\ntorque_Nm = 1\nrepeats = 1000\npreload_N = [{many}]\n",
        "cycles = 1000\ntorque_Nm = { to = 1, points = 10000 }\n" + "[[run]]\n" * 50_000,
    ):
        path.write_text(text)
        with pytest.raises(PlanError, match="expected at most 200000"):
            read_plan(path, CASE)
