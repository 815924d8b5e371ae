"""How many observations readings are worth beside what the fits leave.

pattern_of            by how much likelihoods count for less, from the pattern of what is left
design_effect         the same where it comes again in runs with the same torques
doubts_of             by how much more values are uncertain where it does
autocorrelation_time  of series of one kind

What a model does not follow goes on from reading to reading, and from run to run.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.change.parties import Levels
from cbpt.lab.change.shared import Party
from cbpt.lab.covariance.linear_gaussian import Whitener
from cbpt.lab.covariance.repeated_runs import comes_again, runs_alike
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.selection.rules import RULES

Floats = NDArray[np.float64]


def pattern_of(candidates: Sequence[Levels]) -> float:
    """The dispersion phi of `reproducibility.dispersion_of` from what the fits leave, by the set of
    effects that leaves least pattern.

    What a model does not follow goes on from reading to reading; it is a few observations and not
    as many as there are readings. phi is the integrated autocorrelation time of the whitened
    residuals (Geyer, Statistical Science 7 (1992) 473: pairs of lags while their sum is above 0):
    1 of noise that is as the fit takes it.
    """
    return max(min(_time_of(levels) for levels in candidates), 1.0)


def design_effect(levels: Levels) -> float:
    """How much less than they are counted for the readings tell where what the fits leave comes
    again in runs with the same torques; 1 where it does not.

    The square of the sum over such runs, by their readings: 1 of noise, k times that of one run of
    what is the same in k runs (the design effect of Kish, Survey Sampling, 1965, section 5.4); and
    as in `pattern_of` along a run.
    """
    sums: list[Floats] = []
    count, laws = 0, False
    for party, fit in zip(levels.parties, levels.fits, strict=True):
        readings, left = party.problem.campaign.readings, fit.residual_arcsec
        again, seen = comes_again(readings, left), party.problem.whitener(left)
        is_law = again is not None and again.p_value < RULES.left_chance
        laws |= is_law
        for rows in runs_alike(readings):
            sums += [seen[rows].sum(axis=0)] if is_law else list(seen[rows])
            count += rows.size
    if not laws:
        return 1.0
    size = sum(float(of_runs @ of_runs) for of_runs in sums) / count
    # What goes up and down from reading to reading comes again all the same.
    return max(max(autocorrelation_time(sums), 1.0) * size, 1.0)


def doubts_of(levels: Levels, comes_again: Sequence[bool], alone: bool = False) -> list[float]:
    """By how much more the values of each level are uncertain where what its fit leaves comes
    again, 1 where it does not. Runs with the same torques are then one run: the square root of the
    dispersion of their means, as in `pattern_of`, with as many observations less as there are
    values. alone: beside the noise of each fit, and not that with which the levels count."""
    return [
        _doubt_of(fit, (fit if alone else party.problem).whitener, party) if law else 1.0
        for party, fit, law in zip(levels.parties, levels.fits, comes_again, strict=True)
    ]


def _doubt_of(fit: Fit, whitener: Whitener, party: Party) -> float:
    """Of one level whose rest comes again."""
    left, readings = whitener(fit.residual_arcsec), party.problem.campaign.readings
    means = [np.sqrt(len(rows)) * left[rows].mean(axis=0) for rows in runs_alike(readings)]
    time = max(autocorrelation_time(means), 1.0)
    n, values = sum(map(len, means)), sum("." in unknown.name for unknown in fit.unknowns)
    size = sum(float(mean @ mean) for mean in means) / max(n - values * time, time)
    return max(float(np.sqrt(time * size)), 1.0)


def _time_of(levels: Levels) -> float:
    """Of all levels together, along their runs."""
    runs: list[Floats] = []
    for party, fit in zip(levels.parties, levels.fits, strict=True):
        left = party.problem.whitener(fit.residual_arcsec)
        run_index = party.problem.campaign.rows.run_index
        runs += [left[run_index == run] for run in np.unique(run_index)]
    return autocorrelation_time(runs)


def autocorrelation_time(runs: Sequence[Floats]) -> float:
    """Integrated autocorrelation time of series of one kind with mean 0, in readings."""
    total = np.zeros(max(map(len, runs)))
    for run in runs:
        power = np.abs(np.fft.rfft(run, 2 * len(run))) ** 2
        total[: len(run)] += np.fft.irfft(power, 2 * len(run))[: len(run)]
    if not total[0] > 0:
        return 1.0
    pairs = total[: len(total) // 2 * 2].reshape(-1, 2).sum(axis=1) / total[0]
    below = np.flatnonzero(pairs <= 0)
    return float(2 * pairs[: below[0] if len(below) else len(pairs)].sum() - 1)
