"""Linear Gaussian evidence of every set of effects, and what follows from it by a stated rule.

    Candidate    one form of an effect as whitened columns
    posterior    probability of every set of effects of at most three
    inclusion    probability of every effect; likeliest: the most probable set
    spoken       what is certain and what is open, by the same rule as the answer

Whitened readings z, with the numbers of the drive and the zeros integrated out, are standard normal
where nothing is hidden. Under a set whose forms have the columns B, the sizes of which have a
standard normal prior, z ~ N(0, 1 + B B'):

    ln p(z | B) - ln p(z | nothing) = (h' A^-1 h - ln det A) / 2,  A = 1 + B' B,  h = B' z.

An effect of one sign has half the prior: times 2 Phi(m/s) with mean and deviation of its size.
Forms of an effect are equally likely, effects are independent, with stated prior odds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from scipy.special import log_ndtr

from reference.contact import Floats

EXPECTED = 10.0
"""Root of the mean square of d that an effect of the trial is expected to have."""
ODDS = {"": 0.03, "ball_diameter_lot": 0.01}
"""Prior odds of an effect against its absence, those that the product states for its own."""
CERTAIN, OPEN, TOGETHER = 0.95, 0.05, 0.2
MOST = 3
Posterior = dict[frozenset[str], float]


@dataclass(frozen=True)
class Candidate:
    """columns: whitened (reading, size), scaled so that sizes have a standard normal prior."""

    effect: str
    form: str
    columns: Floats
    one_sided: bool = False

    @classmethod
    def of(
        cls, effect: str, form: str, columns: Sequence[Floats], one_sided: bool = False
    ) -> Candidate | None:
        """Scaled to the expected strength; None where nothing of it can be seen."""
        b = np.column_stack(columns)
        norm = float(np.linalg.norm(b))
        if not np.isfinite(norm) or norm < 1e-3:
            return None
        if b.shape[1] > 4:  # many columns of which few count: lots of balls
            basis, scale, _ = np.linalg.svd(b, full_matrices=False)
            kept = np.cumsum(scale**2) < 0.98 * float(np.sum(scale**2))
            b = (basis * scale)[:, : int(kept.sum()) + 1]
        return cls(effect, form, EXPECTED / np.linalg.norm(b) * b, one_sided and b.shape[1] == 1)


def posterior(
    data: Floats,
    candidates: Sequence[Candidate],
    most: int = MOST,
    odds: Mapping[str, float] = ODDS,
) -> Posterior:
    """Probability of every set of at most `most` effects, the empty one included."""
    effects = sorted({c.effect for c in candidates})
    sets = [s for k in range(most + 1) for s in combinations(effects, k)]
    if not candidates:
        return {frozenset(): 1.0}
    forms = {e: [i for i, c in enumerate(candidates) if c.effect == e] for e in effects}
    picks = [(n, pick) for n, s in enumerate(sets) for pick in product(*(forms[e] for e in s))]
    gains = _gains(data, candidates, [p for _, p in picks])
    weights = [[] for _ in sets]  # type: list[list[float]]
    for (n, _), gain in zip(picks, gains, strict=True):
        weights[n].append(gain)
    logs = np.array(
        [
            float(np.logaddexp.reduce(w))
            - np.log(len(w))
            + sum(np.log(odds.get(e, odds[""])) for e in s)
            for s, w in zip(sets, weights, strict=True)
        ]
    )
    p = np.exp(logs - logs.max())
    return {frozenset(s): float(v) for s, v in zip(sets, p / p.sum(), strict=True)}


def _gains(
    data: Floats, candidates: Sequence[Candidate], picks: Sequence[tuple[int, ...]]
) -> Floats:
    """Log evidence of every pick of candidates against nothing, on one Gram matrix."""
    widths = [c.columns.shape[1] for c in candidates]
    starts = np.cumsum([0, *widths])
    every = np.hstack([c.columns for c in candidates])
    gram, pull = every.T @ every, every.T @ data
    sided = np.repeat([c.one_sided for c in candidates], widths)
    columns = [np.arange(starts[i], starts[i + 1]) for i in range(len(candidates))]
    out = np.zeros(len(picks))
    by_width: dict[int, list[int]] = {}
    for number, pick in enumerate(picks):
        by_width.setdefault(sum(widths[i] for i in pick), []).append(number)
    for width, numbers in by_width.items():
        for some in np.array_split(numbers, max(len(numbers) * width * width // 2_000_000, 1)):
            if width and len(some):
                at = np.array([np.concatenate([columns[i] for i in picks[n]]) for n in some])
                out[some] = _gain(gram, pull, sided, at)
    return out


def _gain(gram: Floats, pull: Floats, sided: Floats, at: Any) -> Floats:
    a = gram[at[:, :, None], at[:, None, :]] + np.eye(at.shape[1])
    h = pull[at]
    inverse = np.linalg.inv(a)
    mean = np.einsum("nij,nj->ni", inverse, h)
    value = 0.5 * np.einsum("ni,ni->n", h, mean) - 0.5 * np.linalg.slogdet(a)[1]
    deviation = np.sqrt(np.einsum("nii->ni", inverse))
    signs = np.where(sided[at], np.log(2) + log_ndtr(mean / deviation), 0.0)
    return np.asarray(value + signs.sum(axis=1))


# --- what is said -----------------------------------------------------------------------------


def inclusion(found: Posterior) -> dict[str, float]:
    """Probability that an effect is at work."""
    effects = sorted(set().union(*found))
    return {e: sum(p for s, p in found.items() if e in s) for e in effects}


def likeliest(found: Posterior) -> list[str]:
    """The most probable set."""
    return sorted(max(found.items(), key=lambda item: item[1])[0])


def spoken(found: Posterior) -> dict[str, Any]:
    """effects: those of at least 0.95. rivals: groups that are open, of which one is needed (0.95)
    and seldom two. probability: that all of it is so."""
    each = inclusion(found)
    certain = sorted(e for e, p in each.items() if p >= CERTAIN)
    open_ = sorted((e for e, p in each.items() if OPEN <= p < CERTAIN), key=lambda e: -each[e])
    groups: list[list[str]] = []
    while open_:
        group = _group(found, open_)
        open_ = [e for e in open_ if e not in group]
        if len(group) > 1 and _any(found, group) >= CERTAIN:
            groups.append(sorted(group))
    holds = [s for s in found if set(certain) <= s and all(s & set(g) for g in groups)]
    kind = "ambiguous" if groups else ("effect" if certain else "complete")
    so = sum(found[s] for s in holds) if certain or groups else found[frozenset()]
    return {"kind": kind, "effects": certain, "rivals": groups, "probability": so}


def _group(found: Posterior, open_: list[str]) -> list[str]:
    """From the likeliest on, whatever adds most to the chance of one and hardly any to two."""
    group = [open_[0]]
    while _any(found, group) < CERTAIN:
        others = [e for e in open_ if e not in group and _both(found, [*group, e]) < TOGETHER]
        if not others:
            break
        group.append(max(others, key=lambda e: _any(found, [*group, e])))
    return group


def _any(found: Posterior, group: list[str]) -> float:
    return sum(p for s, p in found.items() if s & set(group))


def _both(found: Posterior, group: list[str]) -> float:
    return sum(p for s, p in found.items() if len(s & set(group)) > 1)
