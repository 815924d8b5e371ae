"""The run that would decide between rivals, or that none within reach can.

Each rival, as it was fitted, predicts what a further run would read: up, down, through zero and
back at one preload and one input angle. What tells two rivals apart there is the difference of
their predictions against the noise and against what each still does not know of its own numbers;
half its squared length is the log odds that the run is expected to bring.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.assembled import Campaign
from cbpt.lab.fit import Fit, Fitter
from cbpt.lab.library import PRIORS
from cbpt.lab.readings import read_readings

if TYPE_CHECKING:
    from cbpt.lab.answer import Diagnosis

Floats = NDArray[np.float64]

# One loop of torque, in shares of its peak.
_LOOP = np.array([0, 0.25, 0.5, 0.75, 1, 0.5, 0, -0.25, -0.5, -0.75, -1, -0.5, 0])
_SECONDS = 10.0
# Log odds beyond which a pair of rivals is told apart.
_DECIDED = 5.0


@dataclass(frozen=True)
class _Run:
    torque_Nm: float
    preload_N: float
    input_angle_deg: float


def next_run(d: Diagnosis) -> dict[str, Any] | None:
    """The best run for the largest group of rivals; None where there are none that predict."""
    group = max(d.verdict.rivals, key=len, default=())
    fits = dict(sorted(_fits(d, group)))
    if len(fits) < 2:
        return None
    runs = list(_candidates(d))
    plan = Fitter(_plan(d, runs))
    if plan.effects != d.competition.fitter.effects:
        return None
    gains = _gains(d, plan, list(fits.values()), len(runs))
    # A pair that is decided need not be decided further.
    best = int(np.argmax(np.minimum(gains, _DECIDED).sum(axis=1)))
    run = runs[best]
    pairs = list(combinations(sorted(fits), 2))
    apart = sorted({n for pair, g in zip(pairs, gains[best], strict=True) for n in pair if g > 3})
    return {
        "torque_Nm": run.torque_Nm,
        "preload_N": run.preload_N,
        "input_angle_deg": run.input_angle_deg,
        "direction": "up, down, through zero and back",
        "separates": apart,
        "gain": float(gains[best].max()),
    }


def _fits(d: Diagnosis, group: tuple[str, ...]) -> Iterator[tuple[str, Fit]]:
    """Each rival together with what is certain, as it was fitted."""
    certain = [e for e in d.verdict.effects if e != "run_offset"]
    fits = d.competition.fits
    for rival in group:
        names = tuple(sorted([*certain, rival]))
        if names in fits:
            yield rival, fits[names]
        elif rival in PRIORS and tuple(certain) in fits:
            yield rival, fits[tuple(certain)]


def _candidates(d: Diagnosis) -> Iterator[_Run]:
    """Preloads in and a little beyond the range used, and input angles used and between them."""
    r = d.readings
    assert r.preload_N is not None
    low, high = float(r.preload_N.min()), float(r.preload_N.max())
    used = float(np.abs(r.torque_Nm).max())
    drive = d.competition.campaign.drive
    hold = float(drive.preload(torque_Nm=used).drive.hold_N)
    angles = np.unique(np.mod(r.input_angle_deg, 360.0))[:4].tolist()
    angles += [float(np.mod(angles[0] + step, 360.0)) for step in (45.0, 90.0)]
    for preload in np.unique([0.8 * low, low, 0.5 * (low + high), high, 1.25 * high]).tolist():
        for share in (0.5, 0.85):
            torque = min(1.25 * used, share * used * preload / hold)
            for angle in angles:
                yield _Run(float(f"{torque:.3g}"), float(f"{preload:.3g}"), float(angle))


def _plan(d: Diagnosis, runs: list[_Run]) -> Campaign:
    """All candidates as one table; its angles are to be predicted."""
    r, k = d.readings, len(_LOOP)
    number = np.repeat(np.arange(len(runs)), k)
    columns: dict[str, Any] = {
        "run": number,
        "torque_Nm": np.concatenate([run.torque_Nm * _LOOP for run in runs]),
        "preload_N": np.repeat([run.preload_N for run in runs], k),
        "input_angle_deg": np.repeat([run.input_angle_deg for run in runs], k),
        "elastic_angle_arcsec": np.zeros(len(number)),
        "u_elastic_angle_arcsec": np.ones(len(number)),
    }
    if r.time_s is not None:
        columns["time_s"] = np.arange(len(number)) * _SECONDS
    if r.temperature_degC is not None:
        columns["temperature_degC"] = np.full(len(number), float(r.temperature_degC.mean()))
    if r.cycle is not None:
        columns["cycle"] = np.ones(len(number))
    c = d.competition.campaign
    plan = Campaign.of(d.case, read_readings(columns))
    return replace(plan, own=c.own, candidates=c.candidates, effects=c.effects)


def _gains(d: Diagnosis, plan: Fitter, fits: list[Fit], runs: int) -> Floats:
    """Expected log odds that each run brings to each pair of rivals, shape (runs, pairs)."""
    noise = d.after.noise.scale * float(np.median(d.competition.campaign.u_arcsec))
    seen = [_predicted(plan, fit) for fit in fits]
    pairs = list(combinations(seen, 2))
    out = np.zeros((runs, len(pairs)))
    k = len(_LOOP)
    for column, ((one, spread_one), (other, spread_other)) in enumerate(pairs):
        for number in range(runs):
            rows = slice(number * k, (number + 1) * k)
            difference = one[rows] - other[rows]
            if not np.isfinite(difference).all():
                continue
            spread = np.column_stack([spread_one[rows], spread_other[rows]])
            # A zero of its own is given to the run.
            covariance = noise**2 * (np.eye(k) + 1e4) + spread @ spread.T
            out[number, column] = 0.5 * float(difference @ np.linalg.solve(covariance, difference))
    return out


def _predicted(plan: Fitter, fit: Fit) -> tuple[Floats, Floats]:
    """Angles at all candidate rows, and what the fit's own uncertainty makes of them, arcsec."""
    indices = [u.index for u in fit.unknowns]
    point = plan.model.at(fit.point.values, indices)
    by = np.array([fit.value(u) if u.log else 1.0 for u in fit.unknowns])
    size, axes = np.linalg.eigh(fit.covariance)
    root = axes * np.sqrt(np.maximum(size, 0.0))
    slopes = np.where(np.isfinite(point.slopes), point.slopes, 0.0) * by
    return point.angle_arcsec, slopes @ root
