"""A competition made up: the table is a real one; fits, odds and predictions are as a test says.

competition    from the probabilities of sets of effects
Around         what it was held in
MadeUpFit      what the rules of the decision ask of a fit
predicts_as_made_up   readings that are kept back are predicted as a made-up fit says
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.inference.hypothesis import Unknown
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.selection import decision
from cbpt.lab.selection.competition import Competition
from cbpt.lab.selection.decision import Verdict
from common.simulated import Floats, plan

NUMBERS = dict.fromkeys(PRIORS, (1.0, 0.02, 1.0))
Shares = Mapping[Any, float]
"""By sets of effects, `Names`; a mapping of short tuples is none of long ones."""


@dataclass
class MadeUpFit:
    """What the rules ask of a fit. It leaves white noise of the stated size."""

    noise: Noise = field(default_factory=Noise)
    log_marginal: float = 0.0
    values: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Mean, standard deviation of the prior, value; by unknown."""
    chi2: float = 300.0
    sizes: int = 0
    """How many sizes of effects it has, beside `values`."""
    residual_arcsec: Floats = field(default_factory=lambda: white(396))
    offsets_arcsec: Floats = field(default_factory=lambda: np.zeros(1))
    discrepancy_sd: float = 0.0
    predicts: float | None = None
    """Log density of readings that are kept back; else the larger, the more effects it has."""

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        found = [
            Unknown(i, name, mean, sd, 0.01, 100.0, sd)
            for i, (name, (mean, sd, _)) in enumerate(self.values.items())
        ]
        for i in range(self.sizes):
            found.append(Unknown(len(found), "size", 0.0, np.inf, 0.0, 1.0, 1.0, size_of=i))
        return tuple(found)

    def value(self, unknown: Unknown) -> float:
        return self.values[unknown.name][2]

    def whitener(self, columns: Floats) -> Floats:
        return columns

    @property
    def margin(self) -> Any:
        return SimpleNamespace(chi2=self.chi2)

    @property
    def covariance(self) -> Floats:
        """The readings say nothing of what is known beforehand."""
        return np.diag([1.0 if np.isinf(u.sd) else u.sd**2 for u in self.unknowns])


def said(verdict: Verdict) -> tuple[str, tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """The kind of an answer, what is certain, and the groups of rivals."""
    return verdict.kind, verdict.effects, verdict.rivals


def white(count: int, times: float = 1.0) -> Floats:
    return times * 0.3 * np.random.default_rng(17).standard_normal(count)


def shared_by(numbers: Mapping[str, float], shift_sigma: float) -> tuple[Floats, Floats, Floats]:
    """Readings that move by so many standard uncertainties of any number of slope one, and a zero.
    numbers: the slope of each, times that."""
    slope = np.linspace(-40.0, 40.0, 20)
    x = np.column_stack([*[slope * numbers.get(number, 0.0) for number in PRIORS], np.ones(20)])
    return shift_sigma * slope, x, np.r_[np.ones(len(PRIORS)), 0.0]


@dataclass(frozen=True)
class Around:
    """What a competition was held in: the drive as stated, calibrations, the table."""

    nominal_chi2: float = 300.0
    calibrations: Mapping[str, float] = field(default_factory=dict)
    campaign: Campaign = field(default_factory=lambda: plan("dev03"))
    sharing: Mapping[str, float] = field(default_factory=lambda: dict.fromkeys(PRIORS, 1.0))
    shift_sigma: float = 1.5
    lack_noise: Noise | None = None
    """Of a lack of fit; else that of the fit that it is on top of."""
    lack_arcsec: float = 0.0
    """Root mean square of a lack of fit."""


def competition(
    shares: Shares,
    fits: Mapping[Any, MadeUpFit] | None = None,
    around: Around = Around(),
) -> Competition:
    """From the probabilities of sets of effects, () among them; `unknown` in a set stands for a
    lack of fit on top of the rest of it."""
    total = sum(shares.values())
    odds = {tuple(sorted(n)): float(np.log(p / shares[()])) for n, p in shares.items()}
    assert total == pytest.approx(1)
    named = {n: o for n, o in odds.items() if "unknown" not in n}
    unnamed = {n: o for n, o in odds.items() if "unknown" in n}
    made = {n: MadeUpFit(sizes=len(n)) for n in named}
    made[()] = MadeUpFit(values=dict(NUMBERS))
    made |= {tuple(sorted(n)): fit for n, fit in (fits or {}).items()}
    c = replace(around.campaign, priors={**around.campaign.priors, **around.calibrations})
    lacks = [
        SimpleNamespace(
            base=(base := tuple(e for e in n if e != "unknown")),
            noise=around.lack_noise or made[base].noise,
            free_numbers=3,
            columns=("torque_Nm",),
            fitted_arcsec=np.full(396, around.lack_arcsec),
            explained_arcsec=around.lack_arcsec,
        )
        for n in unnamed
    ]
    return Competition(
        fitter=cast(
            Any,
            SimpleNamespace(
                campaign=c,
                at_nominal=lambda _: MadeUpFit(chi2=around.nominal_chi2),
                linear=lambda _: shared_by(around.sharing, around.shift_sigma),
                look=lambda fit, _: fit,
            ),
        ),
        fits=cast(Any, made),
        log_odds=named,
        lacks_of_fit=cast(Any, tuple(lacks)),
        lack_of_fit_log_odds=tuple(unnamed.values()),
        library=cast(Any, None),
        names={},
        null_maximum=np.zeros(400),
        flexible=Noise(),
    )


@contextmanager
def predicts_as_made_up() -> Iterator[None]:
    """Readings that are kept back are predicted as a made-up fit says."""

    def predicted(_: Any, fit: MadeUpFit, fold: Floats) -> float:
        return 10.0 * fit.sizes if fit.predicts is None else fit.predicts

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(decision, "log_score", predicted)
        yield
