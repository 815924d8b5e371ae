"""The shape of an effect may have two basins: which a fit ends in depends on where it begins.

The readings are those of the independent reference rig (`tests/reference/rig`).
"""

from __future__ import annotations

import cbpt
from cbpt.lab.inference.modes import with_shapes
from trial.wider import make_wider


def test_friction_that_builds_up_slowly_is_a_rival_of_creep() -> None:
    """Its fit ended where it builds up within less than a reading, 4.5 in log odds lower, so that
    creep was certain."""
    campaign, _ = make_wider("spring_artefact", 8, 5)
    assert [h["id"] for h in campaign.truth["hidden"]] == ["friction_hysteresis"]
    read = cbpt.read_readings(campaign.columns(), need_preload=False)
    found = cbpt.diagnose(cbpt.Case.from_toml(campaign.to_toml()), read)
    assert found.verdict.rivals == (("creep", "friction_hysteresis"),), found.sentence
    # From the other basin.
    fitter = found.competition.fitter
    fit = found.competition.fits["friction_hysteresis",]
    start = fit.point.values.copy()
    start[fitter.place("friction_hysteresis", "engagement_angle_rad")] *= 0.02
    stuck = fitter.fit(fit.hypothesis, start, fit.noise)
    assert stuck is not None and stuck.log_evidence < fit.log_evidence - 3
    assert with_shapes(fitter, stuck).log_evidence > fit.log_evidence - 0.5
