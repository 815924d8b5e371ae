"""Single effects side by side: how probable each is alone, and what it looks like most.

ranking         every single effect that was fitted, the most probable first
probabilities   of every set that was fitted
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.inference.cross_validation import held_out_residual, rms
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.priors import CLASSES
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.linear_screen import Screen, Stack
from cbpt.lab.selection.posterior import posterior_of, set_of
from cbpt.lab.selection.setting import Names


def ranking(d: DiagnosisData) -> list[dict[str, Any]]:
    """Every single effect that was fitted, the most probable first."""
    c = d.competition
    chances = probabilities(c)
    # Signatures as the drive without effects shows them, looked at through the final noise.
    null = c.fitter.look(c.fits[()], d.after.noise)
    screen = Screen(null, Stack(c.library.about(null, c.names, secants=False)))
    best = d.verdict.names
    rows = []
    singles = sorted((n for n in c.fits if len(n) == 1), key=lambda n: -c.log_odds[n])
    for names in singles:
        fit, effect = d.fit_of(names), names[0]
        seen = c.fitter.look(fit, d.noise)
        member = _member(screen, fit)
        rival, correlation = _rival(screen, member, c)
        rows.append(
            {
                "effect": effect,
                "class": CLASSES.get(effect, "effect"),
                "parameters": d.parameters(fit, effect),
                "held_out_rmse_arcsec": rms(held_out_residual(c.fitter, seen, d.fold)),
                "p_value": c.p_value(names),
                "probability": d.verdict.of_set(names) * chances[names],
                "surviving_fraction": _surviving(screen, member),
                "rival": rival,
                "rival_correlation": correlation,
                "in_answer": effect in best,
            }
        )
    return rows


def probabilities(c: Competition) -> dict[Names, float]:
    """Posterior probability of every set that was fitted: exactly these effects, nothing else."""
    posterior = posterior_of(c)
    return {names: posterior.sets[set_of(names, fit.noise)] for names, fit in c.fits.items()}


def _member(screen: Screen, fit: Fit) -> int | None:
    """The signature nearest to a fit's shapes."""
    variant = fit.hypothesis.variants[0]
    shapes = {
        u.name.partition(".")[2]: fit.value(u)
        for u in fit.unknowns
        if u.name.startswith(variant.effect + ".")
    }
    found = [
        (sum(_way(shapes.get(name, v), v) for name, v in s.shapes.items()), m)
        for m, s in enumerate(screen.signatures)
        if s.variant == variant and screen.usable[m]
    ]
    return min(found)[1] if found else None


def _way(value: float, grid: float) -> float:
    """From a place of the grid to a value: in the logarithm, or evenly where a sign changes."""
    return float(abs(np.log(value / grid))) if value * grid > 0 else abs(value - grid)


def _surviving(screen: Screen, member: int | None) -> float | None:
    return None if member is None else float(screen.surviving[screen.places[member]].max())


def _rival(screen: Screen, member: int | None, c: Competition) -> tuple[str | None, float | None]:
    """The other effect whose signature looks most like this one after the refit."""
    if member is None or screen.signatures[member].variant.spread:
        return None, None
    own = screen.places[member]
    best: tuple[str | None, float | None] = (None, None)
    for m, s in enumerate(screen.signatures):
        same = s.variant.effect == screen.signatures[member].variant.effect
        # A lot of balls can look like nearly everything, so it says nothing as a rival.
        if same or s.variant.spread or not screen.usable[m]:
            continue
        place = screen.places[m]
        a = np.linalg.cholesky(screen.gram[own, own])
        b = np.linalg.cholesky(screen.gram[place, place])
        cross = np.linalg.solve(a, np.linalg.solve(b, screen.gram[place, own]).T)
        correlation = float(min(np.linalg.svd(cross, compute_uv=False)[0], 1.0))
        if best[1] is None or correlation > best[1]:
            best = (s.variant.effect, correlation)
    return best
