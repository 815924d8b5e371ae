"""The outcome of a competition of hypotheses, and what is told meanwhile.

Competition  every hypothesis that was fitted, with its odds
Progress     who is told
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.selection.lack_of_fit import Component, LackOfFit, lacks_of_fit_on
from cbpt.lab.selection.linear_screen import Signatures
from cbpt.lab.selection.setting import Names

Floats = NDArray[np.float64]
Progress = Callable[[str, float], object]
"""Called with what is next and what share of the work is done; what it raises ends the work."""


@dataclass(frozen=True, eq=False)
class Competition:
    """Outcome of the competition."""

    fitter: Fitter
    fits: dict[Names, Fit]
    """The best form of every set of effects that was fitted; () is the drive as stated."""
    log_odds: dict[Names, float]
    """Posterior log odds of each against the drive as stated."""
    lacks_of_fit: tuple[LackOfFit, ...]
    """Lacks of fit without a name, the most probable first."""
    lack_of_fit_log_odds: tuple[float, ...]
    library: Signatures = field(repr=False)
    names: dict[int, tuple[str, str]] = field(repr=False)
    """(effect, parameter) of each value of the fits."""
    null_maximum: Floats = field(repr=False)
    """Largest log odds of any effect in noise alone."""
    flexible: Noise
    """The noise as a fit sees it that may follow the whole library."""
    families: Sequence[Component] = field(default=(), repr=False)
    """Patterns that a lack of fit is looked for with."""

    def lack_on(self, names: Names, exact: bool = False) -> LackOfFit | None:
        """What a set of effects leaves without a name, whether it stands out or not. exact: its
        effects do not depart from their equations."""
        of_set = [lack for lack in self.lacks_of_fit if lack.base == names and not exact]
        if not of_set and self.families:
            fit = self.fits[names]
            if exact:
                fit = self.fitter.look(replace(fit, discrepancy_sd=0.0), fit.noise)
            rest = lacks_of_fit_on(self.fitter, fit, self.families, self.flexible, least=-np.inf)
            of_set = sorted(rest, key=lambda lack: -lack.log_evidence)
        return next(iter(of_set or self.lacks_of_fit), None)

    @property
    def campaign(self) -> Campaign:
        """The readings."""
        return self.fitter.campaign

    @property
    def best(self) -> Names:
        """The most probable set of effects."""
        return max(self.log_odds, key=lambda k: self.log_odds[k])

    def p_value(self, names: Names) -> float:
        """Chance of any single effect looking this good in noise alone."""
        odds = self.log_odds[names]
        return float(
            (1 + np.count_nonzero(self.null_maximum >= odds)) / (1 + len(self.null_maximum))
        )
