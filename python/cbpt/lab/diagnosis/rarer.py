"""Effects that follow the readings as well as one that is told, which then owes its place to the
prior odds alone.

by_prior_odds_alone  told as notes, one for each effect of the best set
of_a_torque_sensor   the same of friction no larger than the hysteresis of a torque sensor
"""

from __future__ import annotations

from collections.abc import Container, Iterator

import numpy as np

from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.decision import Verdict
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names, prior
from cbpt.lab.wording.numbers import listed, rounded

_AS_SENSORS = "friction_hysteresis", "distributed_friction"
"""Frictions that build up with the way alone, as the hysteresis of a sensor does."""
_OF_SENSORS = 0.01
"""Hysteresis of a torque sensor over the largest torque: 0.1 to 1 % of its range on data sheets."""


def by_prior_odds_alone(competition: Competition, verdict: Verdict) -> Iterator[str]:
    """Of each effect that is told: rarer ones that are not, and may stand in its place beside the
    other effects of the best set, by the odds of `certain` if all were equally likely beforehand.
    """
    best = verdict.names
    told = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
    if best not in competition.log_odds:
        return
    for effect in (name for name in best if name in told):
        instead = _instead(competition, best, effect, told)
        if instead:
            names = sorted(instead, key=lambda name: -instead[name])
            others = (*(name for name in best if name != effect), names[0])
            rarer = min(_log_rarer(effect, name) for name in names)
            yield (
                f"{listed(names, 'or')} would explain these readings about as well as {effect}; "
                f"{effect} is named because its odds before any reading are taken to be at least "
                f"{rounded(float(np.exp(rarer)))} times as high. If your rig may have such an "
                "error, fit it in its place and compare what is left: cbpt fit CASE TABLE --with "
                f"{' '.join(others)}"
            )


def of_a_torque_sensor(competition: Competition, verdict: Verdict) -> Iterator[str]:
    """Of friction that is told and no larger than what torque sensors have as hysteresis: of one
    that builds up as gradually no reading of torque and angle tells it."""
    told = {*verdict.effects, *(e for group in verdict.rivals for e in group)}
    fit, fitter = competition.fits.get(verdict.names), competition.fitter
    if fit is None:
        return
    readings = fitter.campaign.readings
    most_Nm = float(np.abs(readings.torque_Nm).max())
    preload_N = np.zeros(1) if readings.preload_N is None else readings.preload_N
    for effect in sorted(told.intersection(verdict.names, _AS_SENSORS)):
        of = {
            name: fit.point.values[fitter.place(effect, name)]
            for name in ("friction_torque_Nm", "friction_radius_m", "load_share")
        }
        if of["friction_radius_m"] > 0 and np.ptp(preload_N) > 0:
            continue  # it follows the preload, and no sensor does
        friction_Nm = of["friction_torque_Nm"] + of["friction_radius_m"] * preload_N.max()
        friction_Nm += of["load_share"] * most_Nm
        if 0 < friction_Nm <= _OF_SENSORS * most_Nm:
            yield (
                f"{effect} takes {100 * friction_Nm / most_Nm:.2g} % of the largest torque read. A "
                "torque sensor whose hysteresis is as large may look the same in these readings: "
                "compare it with the hysteresis on the data sheet of yours"
            )


def _instead(
    competition: Competition, best: Names, effect: str, told: Container[str]
) -> dict[str, float]:
    """Effects that follow the readings about as well in the place of one, with the log odds by
    which they do."""
    rest = set(best) - {effect}
    least = _of_the_readings(competition, best) - RULES.log_rival_odds
    found = {}
    for names in competition.log_odds:
        come = set(names) - set(best)
        if len(come) == 1 and set(names) - come == rest:
            (name,) = come
            log_odds = _of_the_readings(competition, names)
            if name not in told and log_odds >= least and _log_rarer(effect, name) > 0:
                found[name] = log_odds
    return found


def _log_rarer(effect: str, other: str) -> float:
    return prior((effect,)) - prior((other,))


def _of_the_readings(competition: Competition, names: Names) -> float:
    """Log odds without the prior ones."""
    return competition.log_odds[names] - prior(names)
