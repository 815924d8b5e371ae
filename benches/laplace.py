"""Laplace's marginal likelihoods against importance sampling and nested sampling.

`python benches/laplace.py` takes the most probable single effect and its absence in 24 campaigns of
the trial's rig, and compares the difference in log evidence with two that assume nothing of the
form of the posterior, under the same noise and the same priors. Importance sampling (a multivariate
Student's t about the mode; Geweke 1989) is exact to its own uncertainty about the modes that were
found; nested sampling (dynesty; Skilling 2006, Speagle 2020) looks everywhere, and is rougher. It
writes docs/explanation/laplace.md.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from math import lgamma
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from dynesty import NestedSampler
from numpy.typing import NDArray
from scipy.special import ndtri

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "benches"), str(ROOT / "tests")]

from cbpt import Case
from cbpt.lab.covariance.linear_gaussian import Margin, Noise
from cbpt.lab.diagnosis.diagnose import prepared
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.gauss_newton import Problem
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.model.priors import Variant, log_density
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.selection.model_comparison import compete
from trial.answers import campaign, table_of
from trial.page import dated

Floats = NDArray[np.float64]
PAGE = ROOT / "docs" / "explanation" / "laplace.md"
NOWHERE = -1e300
"""Log likelihood where there is no solution."""
DRAWS, DEGREES = 3000, 4.0
"""Of importance sampling, and the degrees of freedom of its Student's t."""


@dataclass(frozen=True)
class Audit:
    """One comparison: log evidence of an effect against none."""

    campaign: str
    effect: str
    readings: int
    laplace: float
    importance: float
    u_importance: float
    nested: float
    u_nested: float


def laplace(fitter: Fitter, fit: Fit, noise: Noise) -> float:
    """Log evidence of the hypothesis of a fit under a noise, its equations exact."""
    found = fitter.fit(fit.hypothesis, fit.point.values, noise, free_noise=False)
    assert found is not None
    return found.log_marginal + found.log_size_prior


def likelihood(fitter: Fitter, fit: Fit, noise: Noise) -> Callable[[Floats], float]:
    """Log likelihood of values of the unknowns, with all that Laplace's log evidence has beside."""
    unknowns = fitter.unknowns(fit.hypothesis)
    problem = Problem(fitter.campaign, fitter.model, unknowns, noise)
    at = np.array([u.index for u in unknowns])
    none = np.zeros(problem.offsets.shape[1])
    base = fitter.start(fit.hypothesis, {})
    lower, upper = np.array([[u.lower, u.upper] for u in unknowns]).T
    constant = laplace_constant(fitter, fit, noise)

    def log_likelihood(x: Floats) -> float:
        if (x < lower).any() or (x > upper).any():
            return NOWHERE
        values = base.copy()
        values[at] = x
        angle = fitter.model.at(values, ()).angle_arcsec
        if not np.isfinite(angle).all():
            return NOWHERE
        residual = problem.whitener(fitter.campaign.y_arcsec - angle)
        margin = Margin.of(residual, problem.offsets, none)
        return -0.5 * margin.chi2 + margin.log_volume + constant

    return log_likelihood


def importance(fitter: Fitter, fit: Fit, noise: Noise, seed: int) -> tuple[float, float]:
    """The same by importance sampling, with its standard uncertainty."""
    unknowns = fitter.unknowns(fit.hypothesis)
    p = len(unknowns)
    problem = Problem(fitter.campaign, fitter.model, unknowns, noise)
    found = fitter.fit(fit.hypothesis, fit.point.values, noise, free_noise=False)
    assert found is not None
    columns = problem.at(found.point).x_left
    spread = np.linalg.cholesky(np.linalg.inv(columns.T @ columns + np.diag(problem.precision)))
    mode = problem.off_mean(found.point)
    rng = np.random.default_rng(seed)
    normal = rng.standard_normal((DRAWS, p))
    t = normal / np.sqrt(rng.chisquare(DEGREES, DRAWS) / DEGREES)[:, None]
    z = mode + t @ spread.T
    log_drawn = lgamma((DEGREES + p) / 2) - lgamma(DEGREES / 2) - p / 2 * np.log(DEGREES * np.pi)
    log_drawn = log_drawn - float(np.sum(np.log(np.diag(spread))))
    log_drawn = log_drawn - (DEGREES + p) / 2 * np.log1p(np.sum(t**2, axis=1) / DEGREES)
    log_likelihood = likelihood(fitter, fit, noise)
    known = problem.precision > 0
    log_prior = 0.5 * np.sum(np.log(problem.precision[known] / (2 * np.pi)))
    log_prior = log_prior - 0.5 * (z**2 @ problem.precision)
    for number, variant in enumerate(fit.hypothesis.variants):
        own = [i for i, u in enumerate(unknowns) if u.size_of == number]
        size = np.maximum(np.linalg.norm(z[:, own], axis=1), 1.0)
        log_prior = log_prior + log_density(variant, size) - 0.5 * len(own) * np.log(2 * np.pi)
    x = problem.mean + z * problem.unit
    values = np.where(problem.log, np.exp(np.where(problem.log, x, 0.0)), x)
    weights = np.array([log_likelihood(v) for v in values]) + log_prior - log_drawn
    most = float(weights.max())
    share = np.exp(weights - most)
    u = float(share.std() / share.mean() / np.sqrt(DRAWS))
    return most + float(np.log(share.mean())), u


def nested(fitter: Fitter, fit: Fit, noise: Noise, seed: int) -> tuple[float, float]:
    """The same by nested sampling, with its uncertainty."""
    unknowns = fitter.unknowns(fit.hypothesis)
    # The prior of the sizes is one over the plausible ones; their flat core comes on top.
    core = sum(float(np.log1p(_core(v))) for v in fit.hypothesis.variants if v.sizes)
    log_likelihood = likelihood(fitter, fit, noise)
    transform = priors(unknowns, fit.hypothesis.variants)
    sampler = NestedSampler(
        lambda x: max(log_likelihood(x) + core, NOWHERE),
        transform,
        len(unknowns),
        nlive=60,
        sample="rwalk",
        rstate=np.random.default_rng(seed),
    )
    sampler.run_nested(dlogz=0.5, print_progress=False)
    result = sampler.results
    return float(result.logz[-1]), float(result.logzerr[-1])


def laplace_constant(fitter: Fitter, fit: Fit, noise: Noise) -> float:
    """What Laplace's log evidence has beside misfit and volume: determinant, prior of the scale."""
    found = fitter.fit(fit.hypothesis, fit.point.values, noise, free_noise=False)
    assert found is not None
    return found.log_marginal + 0.5 * found.margin.chi2 - found.margin.log_volume


def priors(
    unknowns: tuple[Unknown, ...], variants: tuple[Variant, ...]
) -> Callable[[Floats], Floats]:
    """From the unit cube to values: normal for what is known beforehand, sizes equally likely in
    the logarithm, in any direction where they have several components."""

    def transform(cube: Floats) -> Floats:
        out = np.empty(len(unknowns))
        for i, u in enumerate(unknowns):
            if u.size_of < 0:
                x = u.mean + u.sd * ndtri(np.clip(cube[i], 1e-12, 1 - 1e-12))
                out[i] = np.clip(np.exp(x) if u.log else x, u.lower, u.upper)
        for number, v in enumerate(variants):
            own = [i for i, u in enumerate(unknowns) if u.size_of == number]
            ratios = np.array(v.ratios or (1.0,) * len(own))
            neutral = np.array([unknowns[i].mean for i in own])
            out[own] = neutral + ratios * _size(cube[own], v)
        return out

    return transform


def _core(v: Variant) -> float:
    """Mass of the sizes below the plausible ones, where the density is flat, to that of the
    plausible ones (`priors.log_size_prior`)."""
    return 1 / (len(v.sizes) * float(np.log(v.high / v.low)))


def _size(cube: Floats, v: Variant) -> Floats:
    """A size, off neutral: one number, or two of any direction."""
    first = cube[0]
    sign = 1.0
    if len(cube) == 1 and v.signed:
        sign, first = (1.0, 2 * first - 1) if first >= 0.5 else (-1.0, 1 - 2 * first)
    inside = _core(v) / (1 + _core(v))
    if first < inside:
        r = v.low * (first / inside) ** (1 / len(v.sizes))
    else:
        r = v.low * (v.high / v.low) ** ((first - inside) / (1 - inside))
    if len(cube) == 1:
        return np.array([float(sign * r)])
    phase = 2 * np.pi * cube[1]
    return np.asarray(r * np.array([np.cos(phase), np.sin(phase)]))


def audited(index: int, seed: int) -> Audit | None:
    """One campaign; None where no single effect of one or two numbers was fitted."""
    given = campaign(("one", index, seed))
    if given is None:
        return None
    case, readings = case_and_readings(Case.from_toml(given["case"]), table_of(given))
    table, _ = prepared(campaign_of(case, readings, []))
    competition = compete(table, np.random.default_rng(seed))
    fits = [
        f
        for names, f in competition.fits.items()
        if len(names) == 1 and all(not v.spread and len(v.sizes) < 3 for v in f.hypothesis.variants)
    ]
    if not fits:
        return None
    best = max(fits, key=lambda f: f.log_evidence)
    fitter, noise = competition.fitter, best.noise
    null = competition.fits[()]
    with_it, u_with = nested(fitter, best, noise, seed)
    without, u_without = nested(fitter, null, noise, seed + 1)
    drawn, u_drawn = importance(fitter, best, noise, seed)
    none, u_none = importance(fitter, null, noise, seed + 1)
    return Audit(
        campaign=f"one {seed}:{index}",
        effect=best.hypothesis.variants[0].label,
        readings=len(table),
        laplace=laplace(fitter, best, noise) - laplace(fitter, null, noise),
        importance=drawn - none,
        u_importance=float(np.hypot(u_drawn, u_none)),
        nested=with_it - without,
        u_nested=float(np.hypot(u_with, u_without)),
    )


def page(found: list[Audit]) -> str:
    """The table as a page of the documentation."""
    off = np.array([a.laplace - a.importance for a in found])
    rough = np.array([a.laplace - a.nested for a in found])
    lines = [
        "# Laplace's method, audited",
        "",
        "The log evidence of a hypothesis is Laplace's: the likelihood at the mode, times the",
        "prior density, times the volume of the posterior. Here it stands beside two that make no",
        "such assumption: the difference in log evidence between the most probable single effect",
        "and no effect, under the same noise and the same priors. Importance sampling draws about",
        "the mode that was found; nested sampling (dynesty) looks everywhere, for other modes too.",
        "`python benches/laplace.py` writes this page.",
        "",
        f"{dated()}: {len(found)} campaigns. Against importance sampling the difference is "
        f"{off.mean():+.2f} on average, its root mean square "
        f"{np.sqrt(np.mean(off**2)):.2f}, the largest "
        f"{np.abs(off).max():.2f}; against nested sampling {rough.mean():+.2f}, "
        f"{np.sqrt(np.mean(rough**2)):.2f} and {np.abs(rough).max():.2f}. An effect is certain "
        "from log odds of 2.9. u is what each sampler says of itself; that of nested sampling, "
        "with 60 live points and random walks, is too small where unknowns are correlated.",
        "",
        "| campaign | effect | readings | Laplace | by importance | u | nested | u |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {a.campaign} | {a.effect} | {a.readings} | {a.laplace:.2f} | {a.importance:.2f} | "
        f"{a.u_importance:.2f} | {a.nested:.2f} | {a.u_nested:.2f} |"
        for a in found
    ]
    return "\n".join([*lines, ""])


def main() -> None:
    """The audit, campaign by campaign."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=24)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--page", type=Path, default=PAGE)
    asked = parser.parse_args()
    found: list[Audit] = []
    with ProcessPoolExecutor(asked.workers) as pool:
        # Some campaigns have no effect of one or two numbers.
        for one in pool.map(audited, range(asked.sets + 8), repeat(asked.seed)):
            if one is not None:
                found.append(one)
                print(one, flush=True)
    asked.page.write_text(page(found))


if __name__ == "__main__":
    main()
