"""Effects that do not keep their form exactly: what the evidence makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cbpt
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.discrepancy import DISCREPANCY_ODDS, discrepancy_columns, modulations
from cbpt.lab.selection.fit_effects import best_fit
from common.comparisons import drive_of
from common.simulated import plan, truth, variant_of

BEARING = {
    ("eccentric_bearing", "reference_deflection_m"): 4e-6,
    ("eccentric_bearing", "exponent"): 0.8,
}


def campaign_with(departure: float, seed: int = 1) -> Campaign:
    """A bearing whose share varies with the torque by this much, peak to mean, and white noise."""
    campaign = plan("dev03")
    added = truth(campaign, BEARING) - truth(
        campaign, {("eccentric_bearing", "reference_deflection_m"): 0}
    )
    share = np.abs(campaign.readings.torque_Nm)
    wave = departure * np.sin(2 * np.pi * share / share.max())
    noise = campaign.u_arcsec * np.random.default_rng([41, seed]).standard_normal(len(campaign))
    return replace(campaign, y_arcsec=truth(campaign, BEARING) + wave * added + noise)


def fitted(campaign: Campaign) -> Fit:
    return best_fit(Fitter(campaign, [variant_of("eccentric_bearing")]), ["eccentric_bearing"])


@given(seed=st.integers(0, 2**31), scale=st.floats(1e-3, 1e3))
def test_columns_leave_the_mean_and_have_the_size_of_the_effect(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    contribution, functions = scale * rng.standard_normal(50), rng.standard_normal((50, 4))
    columns = discrepancy_columns(contribution, functions)
    assert columns.shape == (50, 4)
    assert contribution @ columns == pytest.approx(np.zeros(4), abs=1e-9 * scale**2)
    size = np.linalg.norm(contribution)
    assert np.linalg.norm(columns, axis=0) == pytest.approx(np.full(4, size))


def test_no_effect_has_no_form() -> None:
    functions = modulations(plan("dev03").readings)
    assert discrepancy_columns(np.zeros(len(functions)), functions).shape[1] == 0
    # A function that is the same wherever the effect acts tells nothing.
    only = np.where(np.arange(len(functions)) < 2, 1.0, 0.0)
    assert discrepancy_columns(only, np.ones((len(functions), 1))).shape[1] == 0


def test_odds_of_departures_are_odds() -> None:
    assert DISCREPANCY_ODDS[0][0] == 0
    assert sum(share for _, share in DISCREPANCY_ODDS) == pytest.approx(1)


def test_an_exact_form_is_taken_for_exact() -> None:
    found = fitted(campaign_with(0.0))
    assert found.discrepancy_sd == 0
    # No more is paid for the doubt than the share of those who hold the form for exact.
    assert np.log(DISCREPANCY_ODDS[0][1]) <= found.log_discrepancy < 0.1


def test_a_departure_is_no_noise() -> None:
    """Without it the noise would have to be taken for larger than it is."""
    found = fitted(campaign_with(0.06))
    assert found.discrepancy_sd > 0
    exact = replace(found, discrepancy_sd=0.0)
    assert (
        Fitter(campaign_with(0.06), []).look(exact, found.noise).log_marginal
        < found.log_marginal - 5
    )


def test_the_drive_alone_has_no_form() -> None:
    found = Fitter(plan("dev03"), []).fit(Hypothesis())
    assert found is not None and found.discrepancy_sd == 0 and found.log_discrepancy == 0


def test_an_effect_departs_by_a_share_of_what_it_shows_itself() -> None:
    """A preload that is lost evenly is what the gain of the preload readings takes as well: the
    wider that gain is stated, the less the loss can lend to whatever else the readings show."""
    lost = {("preload_loss", "lost_share"): 0.1}

    def departures(stated: float) -> float:
        plain = plan("dev03")
        priors = {**plain.priors, "preload_scale": stated}
        campaign = replace(plain, y_arcsec=truth(plain, lost), priors=priors)
        fitter = Fitter(campaign, [variant_of("preload_loss")])
        hypothesis = Hypothesis((variant_of("preload_loss"),))
        fit = fitter.fit(hypothesis, fitter.start(hypothesis, {"preload_loss.lost_share": 0.1}))
        assert fit is not None
        _, x, _ = fitter.linear(replace(fit, discrepancy_sd=0.08))
        first, last = len(fit.unknowns), x.shape[1] - campaign.offsets.shape[1]
        return float(np.linalg.norm(x[:, first:last]))

    assert departures(1e-3) > 0
    assert departures(1.0) < 0.3 * departures(1e-3)


@pytest.mark.parametrize("seed", [7, 8])
def test_a_departure_beyond_all_bounds_is_told_as_a_rest(seed: int) -> None:
    """A run-out that grows with the load is an eccentricity but for the load, which a departure of
    12 times what it may be took in: chi-squared was 5.8 a degree of freedom, and no rest told."""
    rng = np.random.default_rng(seed)
    n = 200
    torque = np.tile(np.r_[np.linspace(0.5, 8, 25), np.linspace(8, 0.5, 25)], 4)
    table = {
        "run": np.repeat([1, 2, 3, 4], 50),
        "time_s": np.arange(n) * 5.0,
        "torque_Nm": torque,
        "preload_N": np.repeat([400.0, 600.0, 800.0, 600.0], 50),
        "input_angle_deg": np.round(rng.uniform(0, 360, n), 1),
        "elastic_angle_arcsec": np.zeros(n),
        "u_elastic_angle_arcsec": np.full(n, 0.08),
    }
    drive = drive_of("dev03")
    model = truth(Campaign.of(drive, cbpt.read_readings(table)), {})
    wobble = 0.2 * torque * np.sin(np.deg2rad(table["input_angle_deg"]) + 1.0)
    table["elastic_angle_arcsec"] = model + wobble + 0.08 * rng.standard_normal(n)
    found = cbpt.diagnose(drive, table)
    assert found.verdict.lack_of_fit is not None, found.sentence
    assert found.verdict.kind == "unknown" or found.verdict.probability < 0.9
