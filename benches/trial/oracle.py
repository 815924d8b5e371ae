"""What somebody who knows the rig's own forms and its noise could say of a campaign.

    Oracle      its answer: the likeliest effect, how alike rivals look, the error left
    ask         the oracle on one campaign with hidden effects

It is what a diagnosis is measured against: the likelihood ratio of the effect in its true form and
shape against the whole library, everything free refitted, with the covariance that made the noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from reference.contact import Floats
from reference.rig import ARCSEC, drive_of, simulate
from reference.rig.campaign import Campaign
from reference.rig.effects import LIBRARY, Hidden
from reference.rig.kinds import Kind
from reference.rig.mesh import NotHeldError
from trial.rivals import signatures, span, yardstick_of
from trial.strength import PARAMETERS, Yardstick

LIMIT = 9.1
"""2 ln of the likelihood ratio that noise reaches in 5 % of campaigns, twenty effects tried."""


@dataclass(frozen=True)
class Oracle:
    """names: the likeliest effect, empty where noise alone would do as well. rivals: the largest
    correlation with each other effect. held_out_arcsec: RMS of held-out readings with the truth
    refitted, nan where the truth has no such refit."""

    names: str
    rivals: dict[str, float]
    held_out_arcsec: float


def ask(campaign: Campaign, draws: int = 2) -> Oracle:
    """The oracle's answer; with two hidden effects or none in the library only the error left."""
    hiddens = _hidden(campaign)
    yardstick = yardstick_of(campaign)
    left = held_out(campaign, yardstick, hiddens)
    if len(hiddens) != 1 or hiddens[0].id not in LIBRARY:
        return Oracle("", {}, left)
    true = hiddens[0]
    data = yardstick.whiten(_off_nominal(campaign, yardstick))
    own = yardstick.left(true)
    gains = {true.id: _gain(own[:, None], data, _one_sided(true.kind))}
    rivals = {}
    for name, kind in LIBRARY.items():
        if name == true.id or name in PARAMETERS.values():
            continue
        tried = signatures(yardstick, kind, draws, _first_order)
        columns = [c for c in tried if np.linalg.norm(c) > 0.1]
        if not columns:
            continue
        if name == "run_offset" or "phase_rad" in kind.draw(np.random.default_rng(0)):
            groups = [np.column_stack(columns)]
        else:
            groups = [c[:, None] for c in columns]
        rivals[name] = max(_likeness(g, own) for g in groups)
        # A zero for each run costs as many numbers as there are runs: likelihood alone is unfair.
        if name != "run_offset":
            gains[name] = max(_gain(g, data, _one_sided(kind)) for g in groups)
    best = max(gains, key=lambda n: gains[n])
    return Oracle(best if gains[best] > LIMIT else "", rivals, left)


def _hidden(campaign: Campaign) -> list[Hidden]:
    """The hidden effects, without the numbers of the drive that are off."""
    found = [e for e in campaign.effects if isinstance(e, Hidden)]
    return found[len(found) - len(campaign.truth["hidden"]) :]


def _off_nominal(campaign: Campaign, yardstick: Yardstick) -> Floats:
    """Readings less the drive as stated, to first order in the numbers that are off (rad)."""
    shifts = [campaign.truth["shifts"][n] / s for n, s in yardstick.priors.items()]
    return np.asarray(campaign.angle_rad - yardstick.angle_rad + yardstick.slopes_rad @ shifts)


def _one_sided(kind: Kind) -> bool:
    return not kind.signed and "phase_rad" not in kind.draw(np.random.default_rng(0))


def _first_order(yardstick: Yardstick, start: Hidden) -> Floats:
    """Whitened change by an effect, of a norm near 8 to first order: a few simulations."""
    kind = start.kind
    for _ in range(3):
        column = yardstick.left(start)
        off = float(np.linalg.norm(column)) / 8.0
        if 0.4 < off < 2.5:
            break
        size = (start.size - kind.neutral) / max(off, 1e-3)
        start = start.sized(float(np.clip(kind.neutral + size, -kind.high, kind.high)))
    return column


def _likeness(columns: Floats, own: Floats) -> float:
    """Correlation of the effect with the nearest combination of some columns."""
    return float(np.linalg.norm(span(columns).T @ own) / np.linalg.norm(own))


def _gain(columns: Floats, data: Floats, one_sided: bool) -> float:
    """2 ln of the likelihood ratio against nothing, the sizes free; one number more costs 2."""
    if one_sided and columns.shape[1] == 1 and float(columns[:, 0] @ data) <= 0:
        return 0.0
    kept = span(columns)
    return float(np.sum((kept.T @ data) ** 2)) - 2.0 * (int(kept.shape[1]) - 1)


# --- what the truth leaves on readings it has not seen ----------------------------------------


def folds(campaign: Campaign) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Whole preload levels where there are three or more, else whole runs, else four stretches."""
    rows = campaign.rows
    for column in (rows.preload_N, rows.run):
        values, back = np.unique(column, return_inverse=True)
        if len(values) >= 3:
            return np.asarray(back % 12, dtype=np.int64)
    return np.arange(len(rows), dtype=np.int64) * 4 // len(rows)


def held_out(campaign: Campaign, yardstick: Yardstick, hiddens: list[Hidden]) -> float:
    """RMS (arcsec) of readings predicted by the true effects in their true forms.

    Their sizes, the numbers of the drive and the zero are refitted to the other folds, to
    first order about the truth.
    """
    drive, rows = drive_of(campaign.case), campaign.rows
    effects = [*yardstick.base, *hiddens]
    try:
        truth = simulate(drive, rows, effects)
        sizes = []
        for h in hiddens:
            step = 0.02 * (h.size - h.kind.neutral)
            less = [e if e is not h else h.sized(h.size - step) for e in effects]
            sizes.append((truth - simulate(drive, rows, less)) / 0.02)
    except (NotHeldError, ArithmeticError):
        return float("nan")
    u = campaign.truth["noise"]["u_arcsec"] * ARCSEC
    shifts = np.array([campaign.truth["shifts"][n] / s for n, s in yardstick.priors.items()])
    x = np.column_stack([yardstick.slopes_rad, *sizes, np.full(len(rows), u)]) / u
    y = (campaign.angle_rad - truth) / u
    # Numbers are known to one prior standard deviation about nominal, sizes and zero not at all.
    precision = np.r_[np.ones(len(shifts)), np.full(len(sizes) + 1, 1e-9)]
    mean = np.r_[-shifts, np.zeros(len(sizes) + 1)]
    out = np.zeros(len(rows))
    fold = folds(campaign)
    for number in np.unique(fold):
        held = fold == number
        a = x[~held].T @ x[~held] + np.diag(precision)
        factor = np.linalg.cholesky(a)
        right = x[~held].T @ y[~held] + precision * mean
        half = solve_triangular(factor, right, lower=True)
        out[held] = y[held] - x[held] @ solve_triangular(factor.T, half, lower=False)
    return float(np.sqrt(np.mean(out**2)) * u / ARCSEC)
