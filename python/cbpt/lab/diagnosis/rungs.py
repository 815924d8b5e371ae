"""The errors of one model of the readings, in sample and held out.

rung_of               of a fit
rung_of_lack_of_fit   of a fit and what is left without a name
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.diagnosis.diagnosis_data import Rung
from cbpt.lab.inference.cross_validation import held_out_residual, rms
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.residuals import chi2_of, rmse_of, u_judging, without_offsets
from cbpt.lab.selection.lack_of_fit import LackOfFit, held_out_with_lack_of_fit


def rung_of(fitter: Fitter, added: str, fit: Fit, fold: NDArray[np.int64]) -> Rung:
    """One step of the ladder."""
    held = held_out_residual(fitter, fit, fold)
    named = bool(fit.hypothesis.effects)
    return Rung(added, rmse_of(fitter.campaign, fit), rms(held), chi2_of(fitter, fit), named)


def rung_of_lack_of_fit(lack_of_fit: LackOfFit, fold: NDArray[np.int64]) -> Rung:
    """The error with a lack of fit that has no name, in place of the last addition."""
    c = lack_of_fit.problem.fitter.campaign
    residual = lack_of_fit.problem.residual(lack_of_fit.amplitude, lack_of_fit.noise)
    residual = without_offsets(c, residual, lack_of_fit.noise)
    held = held_out_with_lack_of_fit(lack_of_fit, fold)
    chi2 = float(np.mean((residual / u_judging(c, lack_of_fit.noise)) ** 2))
    added = f"a free-form function of {' and '.join(lack_of_fit.columns)}"
    return Rung(added, rms(residual), rms(held), chi2)
