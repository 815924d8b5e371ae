"""Whether what is left after an answer is noise, by a test that does not use the fitted scatter.

Adequacy                  what is left against what readings scatter by
adequacy_of               of a fit
scatter_shown             what is left of a coarse display, from the steps that it shows
law_left                  the same where what is left comes again in repeated runs
departure_chance          whether effects depart from their forms by more than they may
free_numbers              how many numbers a fit has
readings_of_the_curve     how many readings it has them from
readings_that_could_show  how many of them would have shown what is missing

What readings scatter by is known from readings taken again under the same conditions, else from how
smoothly they follow each other along a run, else only from what the table states. A fit takes
its scatter from the misfit, so that it would call any misfit noise. A coarse display takes as much
from a misfit as it takes from the noise, but no reading is further than the noise from the step
that it is shown in: what is left is then the scatter that the steps ask for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import STATED_DOF
from cbpt.lab.covariance.linear_gaussian import Linear
from cbpt.lab.covariance.repeatability import independent_share
from cbpt.lab.covariance.repeated_runs import comes_again
from cbpt.lab.covariance.rounding import Behind, scatter_behind
from cbpt.lab.covariance.within_run import Scatter, estimate
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.residuals import left_by, scatter_of
from cbpt.lab.model.dataset import Campaign

Floats = NDArray[np.float64]
Source = Literal["repeats", "scatter within runs", "stated", "nothing"]


@dataclass(frozen=True)
class Adequacy:
    """What is left against what readings scatter by."""

    left_arcsec: float
    """Root mean square of what is left, its degrees of freedom taken into account."""
    expected_arcsec: float
    """What readings scatter by; NaN where nothing tells."""
    source: Source
    p_value: float
    """Chance that noise leaves as much; 1 where nothing tells what it is, by one degree of freedom
    or more."""
    comes_again: bool = False
    """Whether runs that repeat each other tell it: what is left is the same in each of them."""

    @property
    def ratio(self) -> float:
        """What is left over what is expected."""
        return self.left_arcsec / self.expected_arcsec


def adequacy_of(fitter: Fitter, fit: Fit) -> Adequacy:
    """Of what a fit leaves."""
    left, dof = scatter_of(fitter, fit)
    if fitter.campaign.step_arcsec:
        behind = scatter_shown(fitter, fit)
        left, dof = behind.scale * _root_mean_square(fitter.campaign.u_arcsec), behind.dof
    expected, known, source = _expected(fitter, fit)
    repeats = fitter.campaign.repeats
    if source == "repeats" and repeats is not None and repeats.ratio is None:
        # Where none is stated repeats are pooled without weights.
        left = scatter_of(fitter, fit, weighted=False)[0]
    if not (expected > 0 and known >= 1 and dof >= 1):
        return Adequacy(left, float("nan"), "nothing", 1.0)
    from scipy.special import fdtrc

    p_value = float(fdtrc(dof, known, (left / expected) ** 2))
    return Adequacy(left, expected, source, p_value)


def scatter_shown(fitter: Fitter, fit: Fit) -> Behind:
    """Of the readings of a coarse display about a fit, its numbers searched by the steps."""
    c, noise = fitter.campaign, fit.noise
    y, x, precision = fitter.linear(fit)
    further = [np.zeros((len(c), 0))]
    if noise.offset_arcsec:
        further.append(noise.offset_arcsec * c.rows.columns())
    if noise.artefact is not None:
        further.append(noise.artefact.columns_arcsec)
    beside = np.column_stack(further)
    linear = Linear(y, np.column_stack([x, beside]), np.r_[precision, np.ones(beside.shape[1])])
    u = c.u_arcsec if noise.inflation is None else c.u_arcsec * noise.inflation
    return scatter_behind(linear, u, c.step_arcsec)


def law_left(fitter: Fitter, fit: Fit, chance: float) -> Adequacy | None:
    """What is left where it comes again in runs that repeat each other, and noise would agree so
    much with less than this chance; None elsewhere. Of a coarse display rounding comes again."""
    c = fitter.campaign
    found = None if c.step_arcsec else comes_again(c.readings, left_by(c, fit))
    if found is None or found.p_value >= chance:
        return None
    left, _ = scatter_of(fitter, fit)
    return Adequacy(left, found.scatter_arcsec, "repeats", found.p_value, comes_again=True)


def departure_chance(fit: Fit) -> float:
    """Chance that an effect departs as far from its equation as this fit has it: departures that
    are many times what they may be (`discrepancy`) are a law of their own."""
    from scipy.special import ndtr

    if not fit.discrepancy_sd:
        return 1.0
    first, behind = len(fit.unknowns), fit.offsets_arcsec.size
    sizes = np.abs(fit.margin.mode[first : len(fit.margin.mode) - behind])
    if not sizes.size:
        return 1.0
    return min(1.0, 2 * sizes.size * float(ndtr(-sizes.max())))


def _expected(fitter: Fitter, fit: Fit) -> tuple[float, float, Source]:
    """What readings scatter by, arcsec, with its degrees of freedom and where it is from."""
    c = fitter.campaign
    coarse = bool(c.step_arcsec)
    if not coarse and c.repeats is not None and c.repeats.steady:
        # Of noise whose neighbours are alike they show a share, which is as well known as that.
        share = independent_share(c.readings, fit.noise.correlation)
        return c.repeats.u_arcsec / share**0.5, c.repeats.dof * share**2, "repeats"
    correlation = fit.noise.correlation or None
    if coarse:
        return _expected_behind(c, estimate(c.readings, fit.residual_arcsec, correlation))
    if correlation and not c.u_stated:
        # Neighbours tell what is quick; how much of what is slow is noise, nothing does.
        return float("nan"), 0.0, "nothing"
    weighing = replace(c.readings, u_elastic_angle_arcsec=c.u_reading_arcsec)
    scatter = estimate(weighing, fit.residual_arcsec, correlation)
    if scatter is not None and scatter.ratio:
        scale = _root_mean_square(c.u_reading_arcsec)
        as_they_are = estimate(weighing, fit.residual_arcsec, 0.0) if correlation else scatter
        quick = as_they_are.ratio if as_they_are and as_they_are.ratio else scatter.ratio
        if scatter.ratio > max(quick, 1.0):
            # Neighbours are alike, by a correlation that the fit has from the misfit: that there is
            # more scatter than is stated, and slow, nothing else tells.
            return max(quick, 1.0) * scale, STATED_DOF, "stated"
        return scatter.ratio * scale, scatter.dof, "scatter within runs"
    if c.u_stated:
        return _root_mean_square(c.u_reading_arcsec), STATED_DOF, "stated"
    return float("nan"), 0.0, "nothing"


def _expected_behind(c: Campaign, scatter: Scatter | None) -> tuple[float, float, Source]:
    """The same before a coarse display rounds: what is stated, which may hold the rounding or not,
    or what neighbours show beyond rounding. Repeats and neighbours may as well round alike."""
    stated = c.readings.u_elastic_angle_arcsec
    told = 0.0 if stated is None else _root_mean_square(stated)
    beyond = 0.0 if scatter is None else max(scatter.u_arcsec**2 - c.step_arcsec**2 / 12, 0.0)
    if scatter is not None and beyond > told**2:
        return beyond**0.5, scatter.dof, "scatter within runs"
    return told, STATED_DOF, "stated"


def _root_mean_square(u_arcsec: Floats) -> float:
    return float(np.sqrt(np.mean(u_arcsec**2)))


def free_numbers(fitter: Fitter, fit: Fit) -> float:
    """How many free numbers a fit has: sizes and offsets in full, what is known beforehand by the
    share that the readings say of it (Spiegelhalter et al. 2002, effective number of parameters).
    """
    own = np.diag(fit.covariance)
    prior = np.array([u.sd for u in fit.unknowns]) ** 2
    shares = np.where(np.isfinite(prior), 1 - np.minimum(own / prior, 1.0), 1.0)
    return float(shares.sum()) + fit.offsets_arcsec.size + fit.noise.numbers


def readings_of_the_curve(campaign: Campaign) -> int:
    """Angles that a coarse display shows alike are one, however often they come."""
    return len(np.unique(campaign.y_arcsec)) if campaign.step_arcsec else len(campaign)


def readings_that_could_show(campaign: Campaign) -> float:
    """How many readings of the stated uncertainty would tell as much: that nothing is missing says
    little where rounding would have hidden it."""
    if campaign.rounding_arcsec is None:
        return len(campaign)
    square = campaign.u_arcsec**2 + campaign.rounding_arcsec**2
    return float(np.median(campaign.u_arcsec) ** 2 * np.sum(1 / square))
