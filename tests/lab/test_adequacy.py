"""Whether what is left is noise: from repeats, from smoothness along the runs, from what is stated.

Groups: where it is known from; what is left; free numbers.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cbpt import read_readings
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.repeatability import Repeats
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import VARIANTS
from cbpt.lab.selection.adequacy import Adequacy, adequacy_of, free_numbers
from cbpt.lab.selection.model_comparison import compete
from cbpt.lab.selection.rules import RULES
from common import mostly_long
from common.comparisons import columns_of, drive_of
from common.simulated import Floats, Values, hypothesis_of, plan, sample, truth

NOTHING: Values = {("output_torsion", "compliance_rad_per_Nm"): 0.0}
TIMES = [1.0, 3.0]
"""What readings scatter by, over what is stated."""


@cache
def exact() -> Floats:
    return truth(plan(), NOTHING)


def campaign(seed: int, times: float = 1.0, misfit_arcsec: float = 0.0) -> Campaign:
    """White noise; a misfit that the five numbers of drive and rig cannot follow, smooth along the
    runs."""
    c = plan()
    scatter = sample(Noise(times), c.u_arcsec, c.rows, np.random.default_rng([51, seed]))
    torque = c.readings.torque_Nm / np.abs(c.readings.torque_Nm).max()
    return replace(c, y_arcsec=exact() + scatter + misfit_arcsec * (torque**2 - 0.4))


def adequate(c: Campaign, free_noise: bool = True) -> Adequacy:
    fitter = Fitter(c, VARIANTS)
    fit = fitter.fit(Hypothesis(), free_noise=free_noise)
    assert fit is not None
    return adequacy_of(fitter, fit)


# --- where it is known from ---------------------------------------------------------------


def test_repeats_are_asked_first_then_the_runs_then_what_is_stated() -> None:
    c = campaign(0)
    repeats = Repeats(0.31, 1.0, 40.0, 20, 60, steady=True)
    assert adequate(replace(c, repeats=repeats)).source == "repeats"
    assert adequate(replace(c, repeats=repeats)).expected_arcsec == 0.31
    # What changes between repeats says nothing of the scatter.
    changing = replace(repeats, steady=False)
    assert adequate(replace(c, repeats=changing)).source == "scatter within runs"
    assert adequate(c).source == "scatter within runs"


def one_a_run() -> Campaign:
    """Eight readings a table, no two of which follow each other closely."""
    columns = {name: values[::50] for name, values in columns_of("dev03").items()}
    columns["u_elastic_angle_arcsec"][:] = 0.3
    return Campaign.of(drive_of("dev03"), read_readings(columns))


def left_by(c: Campaign, times: float) -> Adequacy:
    """White noise that many times what is stated."""
    noise = times * 0.3 * np.random.default_rng(5).standard_normal(len(c))
    return adequate(replace(c, y_arcsec=truth(c, NOTHING) + noise))


def test_without_neighbours_only_what_is_stated_tells() -> None:
    found = left_by(one_a_run(), 1.0)
    assert found.source == "stated" and found.expected_arcsec == pytest.approx(0.3)
    assert found.p_value > 0.01
    assert left_by(one_a_run(), 8.0).p_value < RULES.left_chance


def test_where_nothing_tells_nothing_is_held_against_a_fit() -> None:
    found = left_by(replace(one_a_run(), u_stated=False), 8.0)
    assert found.source == "nothing" and found.p_value == 1.0
    assert np.isnan(found.expected_arcsec)


def test_of_slow_noise_neighbours_tell_the_quick_part_alone() -> None:
    """Where nothing is stated; the fit calls a smooth misfit correlated noise."""
    c = replace(campaign(1, misfit_arcsec=2.0), u_stated=False)
    assert adequate(c).source == "nothing"
    assert adequate(replace(campaign(1), u_stated=False)).source == "scatter within runs"


# --- what is left -------------------------------------------------------------------------


@pytest.mark.parametrize("times", mostly_long(TIMES, TIMES[:1]))
def test_noise_is_adequate_whatever_is_stated_of_it(times: float) -> None:
    """Of twenty tables hardly one is one in a hundred; about half are above the middle."""
    found = [adequate(campaign(seed, times)) for seed in range(20)]
    chances = np.array([a.p_value for a in found])
    assert np.count_nonzero(chances < 0.01) <= 1
    assert 5 <= np.count_nonzero(chances < 0.5) <= 15
    assert np.mean([a.ratio for a in found]) == pytest.approx(1.0, abs=0.05)
    assert np.mean([a.expected_arcsec for a in found]) == pytest.approx(0.3 * times, rel=0.05)
    assert np.mean([a.left_arcsec for a in found]) == pytest.approx(0.3 * times, rel=0.05)


@pytest.mark.parametrize("times", TIMES)
def test_a_smooth_misfit_is_no_noise(times: float) -> None:
    """A fit takes its scatter from the misfit; the test does not."""
    found = adequate(campaign(1, times, misfit_arcsec=4 * times), free_noise=False)
    assert found.p_value < RULES.left_chance and found.ratio > 1.3
    assert found.expected_arcsec == pytest.approx(0.3 * times, rel=0.15)
    # By repeats too.
    repeats = Repeats(0.3 * times, times, 60.0, 30, 90, steady=True)
    again = adequate(replace(campaign(1, times, misfit_arcsec=4 * times), repeats=repeats))
    assert again.source == "repeats" and again.p_value < RULES.left_chance


def test_a_correlation_that_a_fit_takes_from_a_misfit_is_no_scatter() -> None:
    """A law is smooth, and a fit may call it noise whose neighbours are alike, of four times what
    is stated. Neighbours differ as little as is stated, which alone tells."""
    found = adequate(campaign(1, misfit_arcsec=4.0))
    assert found.source == "stated" and found.p_value < RULES.left_chance
    assert found.expected_arcsec == pytest.approx(0.3, rel=0.1)
    # Twice what is stated may be: it is as well known as by a few repeats.
    twice = adequate(campaign(1, misfit_arcsec=2.0))
    assert twice.source == "stated" and twice.p_value > RULES.left_chance


def test_few_repeats_are_poor_evidence() -> None:
    """The same ratio, known from four readings or from four hundred."""
    c = campaign(2, 1.3)
    few, many = (
        adequate(replace(c, repeats=Repeats(0.3, 1.0, dof, 9, 20, steady=True))).p_value
        for dof in (4.0, 400.0)
    )
    assert few > 0.05 and many < RULES.left_chance


@pytest.mark.parametrize("noise", [Noise(1.0, 0.0, 1.5), Noise(1.0, 0.5), Noise(1.0, 0.5, 1.5)])
def test_offsets_and_correlation_are_no_misfit(noise: Noise) -> None:
    for seed in range(4):
        c = plan()
        scatter = sample(noise, c.u_arcsec, c.rows, np.random.default_rng([52, seed]))
        found = adequate(replace(c, y_arcsec=exact() + scatter))
        assert found.p_value > RULES.left_chance


# --- free numbers -------------------------------------------------------------------------


def fitted(hypothesis: Hypothesis, values: Values, noise: Noise) -> tuple[Fitter, Fit]:
    c = plan()
    scatter = sample(noise, c.u_arcsec, c.rows, np.random.default_rng(53))
    fitter = Fitter(replace(c, y_arcsec=truth(c, values) + scatter), VARIANTS)
    fit = fitter.fit(hypothesis)
    assert fit is not None
    return fitter, fit


def test_numbers_count_by_what_the_readings_say_of_them() -> None:
    fitter, fit = fitted(Hypothesis(), NOTHING, Noise())
    count = free_numbers(fitter, fit)
    # A zero, and less than the five numbers of drive and rig; some of them are known better after.
    assert 1.5 < count < 6
    nothing_said = np.diag([u.sd**2 for u in fit.unknowns])
    assert free_numbers(fitter, replace(fit, covariance=nothing_said)) == pytest.approx(1)
    all_said = np.zeros((len(fit.unknowns), len(fit.unknowns)))
    assert free_numbers(fitter, replace(fit, covariance=all_said)) == pytest.approx(6)


def test_sizes_and_structure_of_the_noise_count_in_full() -> None:
    values: Values = {("preload_loss", "lost_share"): 0.2}
    fitter, fit = fitted(hypothesis_of("preload_loss"), values, Noise())
    size = next(i for i, u in enumerate(fit.unknowns) if u.size_of == 0)
    assert np.isinf(fit.unknowns[size].sd)
    prior = np.diag([u.sd**2 if np.isfinite(u.sd) else 1.0 for u in fit.unknowns])
    known = replace(fit, covariance=prior)
    assert free_numbers(fitter, known) == pytest.approx(2)
    noise = replace(fit.noise, correlation=0.4, offset_arcsec=0.3)
    assert free_numbers(fitter, replace(known, noise=noise)) == pytest.approx(4)


def test_what_a_set_leaves_is_looked_for_on_that_set() -> None:
    """What the drive as stated leaves is no rest beside effects that follow it."""
    every_fifth = Campaign.of(
        drive_of("dev03"),
        read_readings({name: values[::5] for name, values in columns_of("dev03").items()}),
    )
    c = compete(every_fifth, np.random.default_rng(1))
    tried = list(c.fits)[:4]
    assert len(tried) == 4
    for names in tried:
        lack = c.lack_on(names)
        assert lack is not None and lack.base == names
