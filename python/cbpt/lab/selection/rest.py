"""What a name is worth beside a rest that has none.

    rest_arcsec     how much may be something without a name
    remains_arcsec  how much of that is left beside the names
    beside_rest     probability of each effect of an answer, given that

What is left, beyond what readings scatter by, is one draw of what the library lacks, and its scale
is known from nothing else. With Jeffreys' prior of a scale, the next draw from the same source is a
Cauchy variable of the scale R that was left (Student's t with one degree of freedom): with the
chance (2/pi) atan(R/S) it is as large as what an effect explains, S. What the effect explains may
then as well be more of the same.
"""

from __future__ import annotations

import numpy as np

from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.residuals import rmse_of, told_by
from cbpt.lab.selection.adequacy import Adequacy
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.lack_of_fit import LackOfFit
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names


def rest_arcsec(lack: LackOfFit, adequacy: Adequacy | None) -> float:
    """Root mean square: what the lack of fit explains, and where noise cannot leave as much as is
    left, all of that beyond what readings scatter by."""
    described = lack.explained_arcsec
    if adequacy is None or adequacy.p_value >= RULES.left_chance:
        return described
    beyond = max(adequacy.left_arcsec**2 - adequacy.expected_arcsec**2, 0.0)
    return max(described, float(np.sqrt(beyond)))


def remains_arcsec(lack: LackOfFit, adequacy: Adequacy | None) -> float:
    """Root mean square of what remains beside the names: a lack of fit that may stand for a part of
    what has a name describes more than that."""
    rest = rest_arcsec(lack, adequacy)
    return rest if adequacy is None else min(rest, adequacy.left_arcsec)


def beside_rest(competition: Competition, names: Names, rest: float) -> dict[str, float]:
    """Probability that each effect of a set is no part of what has no name.

    What an effect explains is what the readings lose without it, all else refitted; of the whole
    set where the set without it was not fitted. rest: arcsec.
    """
    campaign, fits = competition.campaign, competition.fits
    fit = fits[names]
    noise = told_by(campaign, fit.residual_arcsec, fit.noise)

    def left_arcsec(other: Fit) -> float:
        return rmse_of(campaign, competition.fitter.look(other, noise))

    left = left_arcsec(fit)
    found = {}
    for effect in names:
        without = fits.get(tuple(n for n in names if n != effect), fits[()])
        explained = float(np.sqrt(max(left_arcsec(without) ** 2 - left**2, 0.0)))
        found[effect] = float(1 - 2 / np.pi * np.arctan2(rest, explained))
    return found
