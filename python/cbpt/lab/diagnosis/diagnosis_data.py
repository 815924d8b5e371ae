"""The answer as data: what was judged, the fits before and after, how the error falls.

Rung             one step of the ladder of errors
finished         a fit whose search is brought to its end
probable_sets    sets that make up most of a posterior
noises_of        the noise through which the models of an answer are looked at
DiagnosisData    the answer with all it rests on, without its words
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.estimates import parameters_of
from cbpt.lab.inference.evidence import Closing, Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.residuals import told_by, without_offsets
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.decision import Verdict
from cbpt.lab.selection.posterior import Posterior, named_of, posterior_of
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names

Floats = NDArray[np.float64]
FAR_BELOW = 0.8
LOOSE = (
    "The held-out error is computed with parameters refitted to the other readings, and an effect "
    "may then deviate a little from its stated form. A held-out error far below that in sample "
    "means that the stated form does not fit."
)
"""What an error held out far below the one in sample means."""


@dataclass(frozen=True)
class Rung:
    """The error after one more thing was added to the model."""

    added: str
    """Empty for the drive exactly as stated."""
    rmse_arcsec: float
    held_out_rmse_arcsec: float
    chi2_per_dof: float
    of_effects: bool = False
    """Whether the model has effects by name."""

    @property
    def loose(self) -> bool:
        """Whether the error held out is far below the one in sample."""
        return self.of_effects and self.held_out_rmse_arcsec < FAR_BELOW * self.rmse_arcsec


_ROUNDS = 20
"""Searches, each from the end of the one before, until one comes to its end."""


def finished(fitter: Fitter, fit: Fit, noise: Noise) -> Fit:
    """The fit as it is where its search ended; else searched further.

    The comparison leaves a fit where it is out. Whoever shows numbers of a fit shows these, so that
    they are the same everywhere.
    """
    if fit.converged:
        return fit
    found = fit
    for _ in range(_ROUNDS):
        further = fitter.fit(fit.hypothesis, found.point.values, noise, free_noise=False)
        if further is None:
            return fit
        found = further
        if found.converged:
            break
    return fitter.look(replace(found, discrepancy_sd=fit.discrepancy_sd), noise)


@dataclass(frozen=True, eq=False)
class Noises:
    """The noise of an answer, through which all models are looked at: a fit without an effect may
    take the effect for noise."""

    answer: Names
    own: Noise
    told: Noise
    """The same with what the instrument does as the answer shows it."""
    rivals: frozenset[frozenset[str]] = frozenset()
    """Sets that are as good an answer."""
    lacks: bool = False
    """Whether the answer has more than its names."""

    def of(self, names: Collection[str]) -> Noise:
        """For a set of effects. What holds the answer, or is a rival of it, tells itself what the
        instrument does; of any other set the misfit is no instrument that wanders."""
        whole = not self.lacks and set(self.answer) <= set(names)
        return self.own if whole or frozenset(names) in self.rivals else self.told


MOST_PROBABLE = 12


def probable_sets(posterior: Posterior) -> list[Names]:
    """Sets that make up 95 % of a posterior, at most twelve, the most probable first."""
    found: list[Names] = []
    for names in sorted(posterior.sets, key=lambda n: -posterior.sets[n])[:MOST_PROBABLE]:
        if sum(posterior.sets[n] for n in found) >= RULES.certain:
            break
        found.append(names)
    return found


def noises_of(competition: Competition, verdict: Verdict) -> Noises:
    """Those of the best fit, or of what it leaves without a name."""
    campaign, answer, lack = competition.campaign, verdict.names, verdict.lack_of_fit
    fit = competition.fits[answer]
    residual, noise = fit.residual_arcsec, fit.noise
    if lack is not None:
        residual, noise = lack.problem.residual(lack.amplitude, lack.noise), lack.noise
    near = {frozenset(named_of(n)) for n in probable_sets(posterior_of(competition))}
    rivals = frozenset(n for n in near if not n <= set(answer))
    told = told_by(campaign, residual, noise)
    return Noises(answer, noise, told, rivals, lack is not None)


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisData:
    """The answer with all it rests on."""

    case: Case | Drive
    readings: Readings
    """Those that were judged, shape (n,)."""
    competition: Competition = field(repr=False)
    verdict: Verdict
    before: Fit = field(repr=False)
    """The drive exactly as stated, but for the offset."""
    after: Fit = field(repr=False)
    """The best that the answer offers."""
    ladder: tuple[Rung, ...]
    reached: int
    """Rung of the model that the answer offers."""
    held_out_by: str
    fold: NDArray[np.int64] = field(repr=False)
    notes: tuple[str, ...]
    seed: int
    _finished: dict[Names, Fit] = field(default_factory=dict, init=False, repr=False)

    def fit_of(self, names: Names) -> Fit:
        """The fit of a set of effects, its search brought to its end."""
        if names not in self._finished:
            fit = self.competition.fits[names]
            self._finished[names] = finished(self.competition.fitter, fit, self.noise)
        return self._finished[names]

    @property
    def model_before_arcsec(self) -> Floats:
        """The drive as stated, with the best offset, shape (n,)."""
        return self.readings.elastic_angle_arcsec - self.before.residual_arcsec

    @property
    def model_after_arcsec(self) -> Floats:
        """The model the answer offers, shape (n,)."""
        return self.readings.elastic_angle_arcsec - self.after.residual_arcsec

    @property
    def residual_before_arcsec(self) -> Floats:
        """Shape (n,); offsets of runs taken off where the noise has them."""
        c = self.competition.campaign
        return without_offsets(c, self.before.residual_arcsec, self.noises.of(()))

    @property
    def residual_after_arcsec(self) -> Floats:
        """Shape (n,); offsets of runs taken off where the noise has them."""
        c = self.competition.campaign
        return without_offsets(c, self.after.residual_arcsec, self.noises.of(self.verdict.names))

    @cached_property
    def noises(self) -> Noises:
        """Through which all models are looked at."""
        return noises_of(self.competition, self.verdict)

    @property
    def noise(self) -> Noise:
        """That of the answer."""
        return self.noises.own

    @property
    def ladder_says(self) -> str | None:
        """What to know to read the ladder; None where nothing on it is odd."""
        return LOOSE if any(rung.loose for rung in self.ladder) else None

    @property
    def closing(self) -> Closing | None:
        """How near the values of the answer are to the minimum; None where nothing was fitted."""
        return self.after.closing

    @property
    def final_rung(self) -> Rung:
        """The rung of the model that the answer offers."""
        return self.ladder[self.reached]

    def parameters(self, fit: Fit, effect: str) -> dict[str, dict[str, Any]]:
        """Values of an effect's parameters in a fit, SI, with standard uncertainties."""
        return parameters_of(fit, effect)
