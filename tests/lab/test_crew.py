"""Fits side by side on threads: the same to the last bit, and what is raised ends them.

Groups: answers and their order; what is raised by a fit and by who takes it; functions of the
user's are asked one at a time.
"""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from cbpt.effects import own_effect
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference import crew
from cbpt.lab.inference.crew import Crew, Task, both
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.priors import VARIANTS
from cbpt.lab.selection.linear_screen import Signatures
from cbpt.lab.selection.starts import places
from common.simulated import NUMBERS, hypothesis_of, plan, readings_of, variant_of

EFFECTS = "preload_loss", "rough_contact"


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crew, "_cores", lambda: 2)


def a_fitter() -> Fitter:
    rng = np.random.default_rng(5)
    campaign = readings_of(plan(), {("contact_stiffness", NUMBERS["contact_stiffness"]): 1.05}, rng)
    return Fitter(campaign, [variant_of(effect) for effect in EFFECTS])


@pytest.mark.usefixtures("two_cores")
def test_a_thread_changes_no_bit_and_no_order() -> None:
    fitter = a_fitter()

    def task(effect: str, noise: Noise) -> Task[Fit | None]:
        return lambda own: own.fit(hypothesis_of(effect), noise=noise)

    noises = Noise(), Noise(2.0), Noise(0.5, 0.4)
    tasks = [task(effect, noise) for effect in EFFECTS for noise in noises]
    alone = [task(fitter) for task in tasks]
    beside: list[Fit | None] = []
    Crew(fitter).each(tasks, beside.append)
    assert len(beside) == len(alone)
    for one, other in zip(alone, beside, strict=True):
        assert one is not None and other is not None
        assert one.log_evidence == other.log_evidence
        np.testing.assert_array_equal(one.point.values, other.point.values)


@pytest.mark.usefixtures("two_cores")
def test_both_threads_are_at_work_each_with_a_model_of_its_own() -> None:
    fitter, two = a_fitter(), threading.Barrier(2, timeout=60)

    def met(own: Fitter) -> int:
        two.wait()
        return id(own.model)

    models: list[int] = []
    Crew(fitter).each([met] * 4, models.append)
    assert len(set(models)) == 2 and id(fitter.model) not in models


@pytest.mark.usefixtures("two_cores")
@pytest.mark.parametrize("where", ["task", "take"])
def test_what_is_raised_ends_all_others(where: str) -> None:
    done: list[int] = []

    def task(number: int) -> Task[int]:
        def of(_: Fitter) -> int:
            if where == "task" and number == 1:
                raise RuntimeError("enough")
            time.sleep(1e-3)
            done.append(number)
            return number

        return of

    def take(number: int) -> None:
        if where == "take" and number == 1:
            raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(RuntimeError if where == "task" else KeyboardInterrupt):
        Crew(a_fitter()).each(map(task, range(10_000)), take)
    assert len(done) < 10_000 and threading.active_count() == before


@pytest.mark.usefixtures("two_cores")
def test_functions_of_the_users_are_asked_one_at_a_time() -> None:
    size = {"size_rad": {"unit": "rad", "start": 1e-6}}
    wobble = own_effect("wobble", "series", lambda rows, size_rad: size_rad, size)
    fitter = Fitter(replace(plan(), own={"wobble": wobble}), ())
    alone: list[bool] = []
    Crew(fitter).each([lambda own: own is fitter] * 3, alone.append)
    assert alone == [True] * 3
    campaign, at_work = fitter.campaign, threading.get_ident
    assert both(campaign, at_work, at_work) == (at_work(), at_work())


@pytest.mark.usefixtures("two_cores")
def test_both_of_two_are_done_at_once_and_either_may_fail() -> None:
    campaign, two = plan(), threading.Barrier(2, timeout=60)
    assert set(both(campaign, two.wait, two.wait)) == {0, 1}

    def fails() -> None:
        raise RuntimeError("enough")

    for pair in ((fails, int), (int, fails)):
        with pytest.raises(RuntimeError, match="enough"):
            both(campaign, *pair)


def test_the_library_at_a_glance_is_the_same_on_one_core(monkeypatch: pytest.MonkeyPatch) -> None:
    fitter = a_fitter()
    fit = fitter.fit(Hypothesis())
    assert fit is not None
    found = []
    for cores in (1, 2):
        monkeypatch.setattr(crew, "_cores", lambda cores=cores: cores)
        library = Signatures(fitter.campaign, VARIANTS)
        found.append(library.about(fit, places(fitter)) + library.far(fit, places(fitter)))
    one, other = found
    assert [s.variant for s in one] == [s.variant for s in other]
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.columns, b.columns)
