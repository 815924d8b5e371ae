"""Fits to the last digit.

Groups: the engine by itself, on the certified problems of NIST StRD and at bounds; what is reported
is at the minimum, and other candidates are left as they are.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import cbpt
from cbpt.lab.diagnosis.fitted import Fitted
from cbpt.lab.inference.closing import closed
from cbpt.lab.inference.gauss_newton import Problem as Misfit
from cbpt.lab.inference.least_squares import Aim, minimise
from common.strd import AIM, Problem, digits, problems

Floats = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"

# --- the engine ---------------------------------------------------------------------------


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize("problem", problems(), ids=lambda p: p.name)
def test_certified_values_from_both_starts(problem: Problem, start: int) -> None:
    found = minimise(problem.residual, problem.starts[start], None, AIM)
    assert found is not None and found.converged
    assert digits(found.x, problem.certified) >= 9


def test_there_are_all_27_problems() -> None:
    assert len(problems()) == 27
    assert all(len(p.certified) == p.slopes(p.certified).shape[1] for p in problems())


@pytest.mark.parametrize("problem", problems(), ids=lambda p: p.name)
def test_slopes_are_those_of_differences(problem: Problem) -> None:
    b = problem.starts[1]
    for i, slope in enumerate(problem.slopes(b).T):
        h = 1e-5 * b[i] * np.eye(len(b))[i]
        difference = (problem.model(b + h) - problem.model(b - h)) / (2 * h[i])
        assert difference == pytest.approx(slope, rel=1e-4, abs=1e-4 * np.abs(slope).max())


def test_a_bound_holds_and_the_rest_is_at_its_best() -> None:
    x = np.array([[1.0, 2.0], [1.0, 3.0], [1.0, 5.0]])
    y = np.array([1.0, 2.5, 7.0])
    free = np.linalg.lstsq(x, y, rcond=None)[0]
    low, high = np.array([-np.inf, -np.inf]), np.array([np.inf, 0.5 * free[1]])
    found = minimise(lambda b: (y - x @ b, x), np.zeros(2), (low, high))
    assert found is not None and found.converged
    assert found.x[1] == high[1]
    assert found.x[0] == pytest.approx(float(np.mean(y - x[:, 1] * high[1])), rel=1e-12)


def test_where_the_model_has_no_value_it_goes_nearer() -> None:
    """ln x - ln 2 from 30: the plain step leads below 0."""

    def model(b: Floats) -> tuple[Floats, Floats] | None:
        return None if b[0] <= 0 else (np.log(2.0) - np.log(b), 1 / b[:, None])

    found = minimise(model, np.array([30.0]))
    assert found is not None and found.x[0] == pytest.approx(2.0, rel=1e-12)
    assert minimise(model, np.array([-1.0])) is None


def test_steps_that_run_out_are_told() -> None:
    problem = next(p for p in problems() if p.name == "MGH09")
    found = minimise(problem.residual, problem.starts[0], None, Aim(steps=3))
    assert found is not None and not found.converged and found.steps == 3


# --- what is reported ---------------------------------------------------------------------


@cache
def fitted() -> Fitted:
    own = cbpt.effects.expression(
        "groove_damage",
        "series",
        "a * sign(torque_Nm) * max(abs(torque_Nm) - t, 0)"
        " * exp(k * (cos(input_angle_rad - c) - 1))",
        {
            "a": {"unit": "rad/(N m)", "start": 1e-5, "min": 0.0, "max": 1e-3},
            "t": {"unit": "N m", "start": 2.0, "min": 0.0, "max": 6.0},
            "c": {"unit": "rad", "start": 2.3, "min": 1.8, "max": 2.8},
            "k": {"start": 5.0, "min": 1.0, "max": 30.0},
        },
    )
    return cbpt.fit(EXAMPLES / "damaged.toml", EXAMPLES / "damaged.csv", [own])


def test_a_fit_is_at_its_minimum() -> None:
    """Seen by the search's own step, which is made by another routine."""
    found, fit = fitted(), fitted().result
    assert found.closing is not None and found.closing.converged
    assert found.closing.next_step_u <= found.closing.tolerance_u
    assert f"{found.closing.steps} closing Gauss-Newton step" in found.report()
    # The drive with an effect of the user's own, at a load of choice.
    assert found.predict(6.0, 600.0).u_elastic_angle_arcsec[0] > 0
    misfit = Misfit(found.fitter.campaign, found.fitter.model, fit.unknowns, fit.noise_of_values)
    _, promised = misfit.step(fit.point)
    assert abs(promised) < 1e-8


def test_closing_moves_a_rough_fit_and_then_no_more() -> None:
    found, fit = fitted(), fitted().result
    again = closed(found.fitter, fit)
    assert again.closing is not None and again.closing.steps == 0
    start = fit.point.values.copy()
    start[[u.index for u in fit.unknowns]] *= 1.001
    rough = found.fitter.fit(fit.hypothesis, start)
    assert rough is not None and rough.closing is None
    near = closed(found.fitter, rough)
    # Another start, the same noise to what a search tells: the same values far below their u.
    for unknown in fit.unknowns:
        assert abs(near.value(unknown) - fit.value(unknown)) < 0.02 * fit.u(unknown)


def test_a_diagnosis_closes_its_answer_alone() -> None:
    found = cbpt.diagnose(EXAMPLES / "campaign.toml", EXAMPLES / "campaign.csv")
    assert found.closing is not None and found.closing.converged
    assert found.to_dict()["closing"]["next_step_u"] <= 1e-6
    fits = found.competition.fits
    assert [names for names in fits if fits[names].closing] == [found.verdict.names]
