"""How like each other effects look in a campaign, as the one who made it can tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from reference.contact import Floats
from reference.rig import ARCSEC, drive_of
from reference.rig.campaign import PRIORS, Campaign
from reference.rig.effects import LIBRARY, Hidden, Kind, draw_hidden
from reference.rig.instrument import noise_of
from reference.rig.mesh import NotHeldError
from trial.strength import PARAMETERS, NoSuchCampaignError, Yardstick, parameter_effect


def yardstick_of(campaign: Campaign) -> Yardstick:
    """The measure of strength on a campaign, rebuilt from its truth."""
    truth = campaign.truth
    base = tuple(parameter_effect(n, s) for n, s in truth["shifts"].items() if s != 0)
    priors = {**PRIORS, **campaign.case.get("uncertainty", {})}
    return Yardstick.of(
        drive_of(campaign.case), campaign.rows, base, noise_of(truth["noise"]), priors
    )


def zeros_of_runs(yardstick: Yardstick) -> list[Floats]:
    """Whitened change by a zero of one arcsec of each run."""
    runs = np.unique(yardstick.rows.run)
    return [yardstick.whiten(ARCSEC * (yardstick.rows.run == r)) for r in runs]


def refitted(yardstick: Yardstick, start: Hidden) -> Floats:
    """Whitened change by an effect at a strength near 8, refitted at every size that is tried."""
    return yardstick.left(yardstick.sized(start, 8.0, tolerance=0.6))


def signatures(
    yardstick: Yardstick,
    kind: Kind,
    draws: int,
    change: Callable[[Yardstick, Hidden], Floats] = refitted,
) -> list[Floats]:
    """Whitened changes by an effect in the library's form, as `change` has them of each draw."""
    if kind.id == "run_offset":
        return zeros_of_runs(yardstick)
    found = []
    rng = np.random.default_rng(7)
    for _ in range(draws):
        start = draw_hidden(kind, "library", rng)
        try:
            found.append(change(yardstick, start))
        except (NoSuchCampaignError, NotHeldError, ArithmeticError):
            continue
        if len(start.values) == 1:
            break
    return found


def span(columns: Floats) -> Floats:
    """Orthonormal basis of what some columns reach."""
    basis, scale, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[:, scale > 1e-6 * scale[0]])


def rival_correlations(
    campaign: Campaign, draws: int = 3, among: Sequence[str] = tuple(LIBRARY)
) -> dict[str, float]:
    """For every other effect of the library, the largest correlation with the one that is hidden.

    After refitting the free parameters. Effects with a phase, and zeros of runs, are given every
    combination of their signatures; of the others the likest draw counts. Takes seconds.
    """
    hiddens = [e for e in campaign.effects if isinstance(e, Hidden)]
    yardstick = yardstick_of(campaign)
    ids = [h["id"] for h in campaign.truth["hidden"]]
    true = yardstick.left(next(h for h in reversed(hiddens) if h.id == ids[0]))
    true = true / np.linalg.norm(true)
    out = {}
    for name, kind in LIBRARY.items():
        if name in ids or name in PARAMETERS.values() or name not in among:
            continue
        columns = signatures(yardstick, kind, draws)
        if not columns:
            continue
        if name == "run_offset" or "phase_rad" in kind.draw(np.random.default_rng(0)):
            out[name] = float(np.linalg.norm(span(np.column_stack(columns)).T @ true))
        else:
            out[name] = float(max(abs(c @ true) / np.linalg.norm(c) for c in columns))
    return dict(sorted(out.items(), key=lambda item: -item[1]))
